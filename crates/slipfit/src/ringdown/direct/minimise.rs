//! Gauss-Newton minimisation for a few parameters, without allocation.

/// Sums over the samples: `JᵀJ` (lower triangle suffices), `Jᵀr`, `rᵀr`, with `r = data - model`.
#[derive(Debug, Clone, Copy)]
pub(super) struct Sums<const N: usize> {
    pub(super) jtj: [[f64; N]; N],
    pub(super) jtr: [f64; N],
    pub(super) rss: f64,
}

/// Result of the search.
#[derive(Debug, Clone, Copy)]
pub(super) struct Minimum<const N: usize> {
    pub(super) best: [f64; N],
    /// `(JᵀJ)⁻¹`.
    pub(super) inverse: [[f64; N]; N],
    pub(super) rss: f64,
    pub(super) converged: bool,
    /// Number of times the sums were computed.
    pub(super) passes: usize,
}

const MOST_PASSES: usize = 60;
/// The last step is taken without evaluating its sums if the remaining error, extrapolated from the
/// convergence so far, is below this fraction of a standard error.
const LAST_STEP_ERROR: f64 = 1e-3;
/// Maximum length of the last step, as a multiple of that fraction.
const LONGEST_LAST_STEP: f64 = 300.0;
/// The relative rounding error of the residuals is at most about 1e-13 of the signal.
pub(super) const ROUNDING: f64 = 1e-26;

/// Least squares from `start`.
///
/// `sums` computes the sums at a point, or `None` if the model does not exist there; `moved` adds a step.
/// `power` is the sum of squares of the signal.
pub(super) fn minimise<const N: usize>(
    start: [f64; N],
    observations: f64,
    power: f64,
    sums: impl FnMut(&[f64; N]) -> Option<Sums<N>>,
    moved: impl Fn(&[f64; N], &[f64; N]) -> [f64; N],
) -> Option<Minimum<N>> {
    minimise_to(LAST_STEP_ERROR, start, observations, power, sums, moved)
}

/// [`minimise`] with the tolerance `part`, as a fraction of a standard error.
pub(super) fn minimise_to<const N: usize>(
    part: f64,
    start: [f64; N],
    observations: f64,
    power: f64,
    mut sums: impl FnMut(&[f64; N]) -> Option<Sums<N>>,
    moved: impl Fn(&[f64; N], &[f64; N]) -> [f64; N],
) -> Option<Minimum<N>> {
    let mut best = start;
    let mut here = sums(&best).filter(|s| s.rss.is_finite())?;
    let mut passes = 1;
    let mut damping = 0.0;
    let mut converged = false;
    let mut before = f64::INFINITY;
    while passes < MOST_PASSES && damping < 1e10 {
        let Some((step, gain)) = step(&here, damping) else {
            damping = if damping == 0.0 { 1e-8 } else { damping * 100.0 };
            continue;
        };
        let trial = moved(&best, &step);
        let noise = here.rss / observations;
        // The gain of a step is the square of its length in standard errors, times the noise variance.
        let length = (gain.max(0.0) / noise).sqrt();
        let remains = length * (length / before).min(1.0);
        let last = remains <= part && length <= LONGEST_LAST_STEP * part;
        if damping == 0.0 && (last || gain <= ROUNDING * power) {
            if trial.iter().all(|v| v.is_finite()) {
                best = trial;
                here.rss = (here.rss - gain).max(0.0);
            }
            converged = true;
            break;
        }
        passes += 1;
        match sums(&trial).filter(|s| s.rss <= here.rss && trial.iter().all(|v| v.is_finite())) {
            Some(there) => {
                damping = if here.rss - there.rss > 0.25 * gain { damping * 0.01 } else { damping * 2.0 };
                if damping < 1e-6 {
                    damping = 0.0;
                }
                before = length;
                (best, here) = (trial, there);
            }
            None if gain <= 1e-9 * here.rss.max(1e3 * ROUNDING * power) => {
                // Any further decrease is hidden by rounding, but the gradient is still accurate.
                if damping == 0.0 && trial.iter().all(|v| v.is_finite()) {
                    best = trial;
                }
                converged = true;
                break;
            }
            None => damping = if damping == 0.0 { 1e-3 } else { damping * 10.0 },
        }
    }
    let inverse = inverse(&here.jtj)?;
    Some(Minimum { best, inverse, rss: here.rss, converged, passes })
}

/// `A + damping diag A = L D Lᵀ`: `L` below the diagonal, `1/D` on it.
///
/// `None` if a column is, to rounding, a linear combination of those before it.
#[inline(always)]
fn factor<const N: usize>(a: &[[f64; N]; N], damping: f64) -> Option<[[f64; N]; N]> {
    let mut l = [[0.0; N]; N];
    for j in 0..N {
        let whole = a[j][j] * (1.0 + damping);
        let mut pivot = whole;
        // L D, row j.
        let mut scaled = [0.0; N];
        for k in 0..j {
            scaled[k] = l[j][k];
            l[j][k] *= l[k][k];
            pivot -= l[j][k] * scaled[k];
        }
        if !(pivot > 1e-14 * whole && whole.is_finite()) {
            return None;
        }
        l[j][j] = 1.0 / pivot;
        for i in j + 1..N {
            let mut sum = a[i][j];
            for k in 0..j {
                // Rows below still contain L D.
                sum -= l[i][k] * l[j][k];
            }
            l[i][j] = sum;
        }
    }
    Some(l)
}

#[inline(always)]
fn solve<const N: usize>(l: &[[f64; N]; N], g: &[f64; N]) -> [f64; N] {
    let mut x = *g;
    for i in 0..N {
        for k in 0..i {
            x[i] -= l[i][k] * x[k];
        }
    }
    for i in 0..N {
        x[i] *= l[i][i];
    }
    for i in (0..N).rev() {
        for k in i + 1..N {
            x[i] -= l[k][i] * x[k];
        }
    }
    x
}

/// The damped step and the predicted decrease of the sum of squares.
pub(super) fn step<const N: usize>(sums: &Sums<N>, damping: f64) -> Option<([f64; N], f64)> {
    let l = factor(&sums.jtj, damping)?;
    let x = solve(&l, &sums.jtr);
    // (A + d D) x = g, so 2 g·x - x·A x = g·x + d x·D x.
    let mut gain = 0.0;
    for i in 0..N {
        gain += x[i] * (sums.jtr[i] + damping * sums.jtj[i][i] * x[i]);
    }
    Some((x, gain))
}

pub(super) fn inverse<const N: usize>(a: &[[f64; N]; N]) -> Option<[[f64; N]; N]> {
    let l = factor(a, 0.0)?;
    let mut out = [[0.0; N]; N];
    for (i, row) in out.iter_mut().enumerate() {
        let mut unit = [0.0; N];
        unit[i] = 1.0;
        *row = solve(&l, &unit);
    }
    Some(out)
}

/// Standard errors and correlations from a covariance `J C Jᵀ` known up to its scale.
pub(super) fn spread<const N: usize>(covariance: &[[f64; N]; N], variance: f64) -> ([f64; N], [[f64; N]; N]) {
    let mut error = [0.0; N];
    for i in 0..N {
        error[i] = (covariance[i][i].max(0.0) * variance).sqrt();
    }
    let mut correlation = [[0.0; N]; N];
    for i in 0..N {
        for j in 0..N {
            let product = (covariance[i][i] * covariance[j][j]).sqrt();
            correlation[i][j] = if product > 0.0 { covariance[i][j] / product } else { 0.0 };
        }
    }
    (error, correlation)
}
