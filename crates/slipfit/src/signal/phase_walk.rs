//! Estimation of a random walk of the phase in the presence of noise.
//!
//! The phase of an oscillator with white frequency noise is a random walk. With additional measurement noise it is a
//! local level model (A. C. Harvey, *Forecasting, Structural Time Series Models and the Kalman Filter*, 1989, section
//! 4.2); the likelihood is that of the part not explained by a smooth phase (restricted likelihood, ibid. 3.4.3).

use nalgebra::{DMatrix, DVector};
use pulp::{Simd, WithSimd};

/// Residual of the phase at one time after a smooth phase, rad.
#[derive(Debug, Clone)]
pub(crate) struct PhaseError {
    pub(crate) time_s: f64,
    pub(crate) error: f64,
    /// Inverse of its variance due to noise.
    pub(crate) weight: f64,
    /// `c T` of a mean over a time `T` with a kernel of cumulative weight `F`, where `c` is the integral of
    /// `F (1 - F)` over it: 1/6 for a uniform mean.
    pub(crate) averaged_s: f64,
    /// Derivatives of the smooth phase with respect to its parameters, including a constant phase.
    pub(crate) smooth: Vec<f64>,
}

/// Gain in log-likelihood, as a part of the squared detection threshold in standard errors, that one of the first few
/// rates must reach before all rates are tried.
const FIRST_PASS_GAIN: f64 = 0.25;
/// Spacing of the rates in the first pass: with the absence of a walk there are [`RATES`], computed side by side.
const FIRST_STEP: usize = 4;
/// Range of rates tried: variance of the walk over the total time, in variances of the noise of one phase.
const DECADES: std::ops::RangeInclusive<i32> = -3..=6;
/// Number of rates tried per decade.
const PER_DECADE: i32 = 3;

/// Variance added to the phase per second by a random walk, rad²/s; `None` if no walk exceeds the noise by
/// `errors_out` standard errors.
///
/// All columns are free while the walk is estimated, because the selected ones have already fitted part of it.
/// Columns that are not `selected` may explain all of it although they have no part in the motion: the residuals of
/// the selected ones are then the walk.
pub(crate) fn walk_rate(
    errors: &[PhaseError],
    selected: impl Fn(usize) -> bool,
    errors_out: f64,
) -> Option<f64> {
    posterior_mean_rate(errors, errors_out).or_else(|| {
        let kept: Vec<usize> = (0..errors.first()?.smooth.len()).filter(|k| selected(*k)).collect();
        if kept.len() == errors[0].smooth.len() {
            return None;
        }
        let of = |e: &PhaseError| kept.iter().map(|k| e.smooth[*k]).collect();
        let selected_columns: Vec<PhaseError> =
            errors.iter().map(|e| PhaseError { smooth: of(e), ..*e }).collect();
        posterior_mean_rate(&selected_columns, errors_out)
    })
}

/// The posterior mean of the rate given the phases (with Jeffreys' prior): errors computed from it are those of
/// Student's distribution if there are few steps. `None` if no rate is significant.
fn posterior_mean_rate(errors: &[PhaseError], errors_out: f64) -> Option<f64> {
    let n = errors.len();
    let columns = errors.first()?.smooth.len();
    if n < columns + 2 {
        return None;
    }
    let time_s = errors[n - 1].time_s - errors[0].time_s;
    let information: f64 = errors.iter().map(|e| e.weight).sum();
    let unit = n as f64 / information / time_s;
    if !(unit.is_finite() && unit > 0.0) {
        return None;
    }
    let phases = Phases::new(errors)?;
    let tried = |step: usize| {
        let exponents = (DECADES.start() * PER_DECADE..=DECADES.end() * PER_DECADE).step_by(step);
        let rates = exponents.map(|i| unit * 10f64.powf(f64::from(i) / f64::from(PER_DECADE)));
        let rates: Vec<f64> = std::iter::once(0.0).chain(rates).collect();
        let found: Vec<Option<f64>> =
            rates.chunks(RATES).flat_map(|rates| phases.minus_two_logs(rates)).collect();
        let of_rates = rates.into_iter().zip(&found).skip(1);
        Some((found[0]?, of_rates.filter_map(|(rate, value)| Some((rate, (*value)?))).collect::<Vec<_>>()))
    };
    let least_of = |tried: &[(f64, f64)]| tried.iter().map(|(_, l)| *l).min_by(f64::total_cmp);
    // Most phases have no walk: about one rate per decade is enough to come close to the best likelihood.
    let (still, few) = tried(FIRST_STEP)?;
    if !(still - least_of(&few)? > FIRST_PASS_GAIN * errors_out.powi(2)) {
        return None;
    }
    let (_, tried) = tried(1)?;
    let least = least_of(&tried)?;
    if !(still - least > errors_out.powi(2)) {
        return None;
    }
    let (mut sum, mut total) = (0.0, 0.0);
    for (rate, value) in tried {
        // Equal steps of the logarithm: the density is with respect to the logarithm.
        let density = (-0.5 * (value - least)).exp() * rate * prior(errors, rate);
        sum += density * rate;
        total += density;
    }
    Some(sum / total).filter(|rate| rate.is_finite())
}

/// Jeffreys' prior of the rate: the root of the information of the steps about it.
fn prior(errors: &[PhaseError], rate: f64) -> f64 {
    let information = |pair: &[PhaseError]| {
        let duration = pair[1].time_s - pair[0].time_s;
        let noise = 1.0 / pair[0].weight + 1.0 / pair[1].weight;
        (duration / (noise + rate * duration)).powi(2)
    };
    errors.windows(2).map(information).sum::<f64>().sqrt()
}

/// Maximum number of columns of a smooth phase: those of a phase with backbone and drift, and an offset.
const COLUMNS: usize = 5;

/// The phases in the form used by the filter, with columns scaled to a largest entry of one.
struct Phases {
    columns: usize,
    scale: [f64; COLUMNS],
    first_averaged_s: f64,
    steps: Vec<Step>,
}

/// Step from one phase to the next.
struct Step {
    passed_s: f64,
    noise_variance: f64,
    averaged_s: f64,
    /// The columns, followed by the error.
    row: [f64; COLUMNS + 1],
}

/// Number of rates whose innovations are computed side by side.
const RATES: usize = 8;

/// One number for each of several rates.
type Lanes<const N: usize> = [f64; N];

/// Sums over the innovations for walks of several rates, weighted by their inverse variances: the lower triangle of
/// their products, and the log determinant, which is NaN if the rate gives no variance.
struct Innovations<const N: usize> {
    products: [[Lanes<N>; COLUMNS + 1]; COLUMNS + 1],
    log_determinant: Lanes<N>,
}

/// The filter of the level for walks of several rates.
struct Filter<'a, const N: usize> {
    phases: &'a Phases,
    rates: Lanes<N>,
}

impl<const N: usize> WithSimd for Filter<'_, N> {
    type Output = Innovations<N>;

    /// Filters the error and all columns in the same way.
    #[inline(always)]
    fn with_simd<S: Simd>(self, _: S) -> Innovations<N> {
        let Self { phases, rates } = self;
        let rows = phases.columns + 1;
        // The initial knowledge of the level has no effect if there is a constant phase.
        let mut level = [[0.0; N]; COLUMNS + 1];
        let mut variance = rates.map(|rate| 2.0 * rate * phases.first_averaged_s);
        let mut sums =
            Innovations { products: [[[0.0; N]; COLUMNS + 1]; COLUMNS + 1], log_determinant: [0.0; N] };
        for steps in phases.steps.chunks(FACTORS) {
            let mut determinant = [1.0; N];
            for step in steps {
                let (mut weight, mut gain) = ([0.0; N], [0.0; N]);
                for n in 0..N {
                    let moved = variance[n] + rates[n] * step.passed_s;
                    // Differences of means of a walk are correlated like those of a walk with correspondingly less
                    // noise.
                    let total = moved + step.noise_variance - rates[n] * step.averaged_s;
                    weight[n] = 1.0 / total;
                    gain[n] = moved * weight[n];
                    variance[n] = moved * (1.0 - gain[n]);
                    determinant[n] *= if total > 0.0 { total } else { f64::NAN };
                }
                let mut innovation = [[0.0; N]; COLUMNS + 1];
                for k in 0..rows {
                    for n in 0..N {
                        innovation[k][n] = step.row[k] - level[k][n];
                        level[k][n] += gain[n] * innovation[k][n];
                    }
                }
                for k in 0..rows {
                    for l in 0..=k {
                        for n in 0..N {
                            sums.products[k][l][n] += weight[n] * innovation[k][n] * innovation[l][n];
                        }
                    }
                }
            }
            for n in 0..N {
                sums.log_determinant[n] += determinant[n].ln();
            }
        }
        sums
    }
}

/// Number of variances whose product cannot underflow.
const FACTORS: usize = 4;

impl Phases {
    fn new(errors: &[PhaseError]) -> Option<Self> {
        let first = errors.first()?;
        let columns = first.smooth.len().min(COLUMNS);
        let mut scale = [0.0f64; COLUMNS];
        for e in errors {
            scale.iter_mut().zip(&e.smooth).for_each(|(s, v)| *s = s.max(v.abs()));
        }
        scale.iter_mut().for_each(|s| *s = s.max(f64::MIN_POSITIVE));
        let mut before = first.time_s;
        let step = |e: &PhaseError| {
            let mut row = [0.0; COLUMNS + 1];
            row.iter_mut().zip(&scale).zip(&e.smooth).take(columns).for_each(|((row, s), v)| *row = v / s);
            row[columns] = e.error;
            let passed_s = e.time_s - before;
            before = e.time_s;
            Step { passed_s, noise_variance: 1.0 / e.weight, averaged_s: e.averaged_s, row }
        };
        let steps = errors.iter().map(step).collect();
        Some(Self { columns, scale, first_averaged_s: first.averaged_s, steps })
    }

    /// The innovations for walks of several rates.
    fn innovations<const N: usize>(&self, rates: Lanes<N>) -> Innovations<N> {
        crate::numeric::dispatch(Filter { phases: self, rates })
    }

    /// Minus twice the restricted log-likelihood of several rates, up to a constant; `None` if there is none.
    fn minus_two_logs(&self, rates: &[f64]) -> Vec<Option<f64>> {
        let side_by_side = std::array::from_fn(|n| rates.get(n).or(rates.last()).copied().unwrap_or(0.0));
        let innovations: Innovations<RATES> = self.innovations(side_by_side);
        (0..rates.len()).map(|n| self.minus_two_log(&innovations, n)).collect()
    }

    fn minus_two_log(&self, innovations: &Innovations<RATES>, n: usize) -> Option<f64> {
        // Cholesky factor of the products, with the error last: its diagonal element is the residual sum of squares.
        let mut factor = [[0.0; COLUMNS + 1]; COLUMNS + 1];
        let mut minus_two_log = innovations.log_determinant[n];
        for k in 0..=self.columns {
            for l in 0..=k {
                let inner: f64 = (0..l).map(|m| factor[k][m] * factor[l][m]).sum();
                let left = innovations.products[k][l][n] - inner;
                factor[k][l] = match (k == l, k == self.columns) {
                    (true, true) => {
                        minus_two_log += left;
                        left
                    }
                    (true, false) if left > 0.0 => {
                        minus_two_log += left.ln();
                        left.sqrt()
                    }
                    (true, false) => return None,
                    (false, _) => left / factor[l][l],
                };
            }
        }
        minus_two_log.is_finite().then_some(minus_two_log)
    }
}

/// A smooth phase fitted in the presence of a walk of a given rate, by generalised least squares.
pub(crate) struct Smoothed {
    /// Its parameters, and their covariance.
    pub(crate) parameters: DVector<f64>,
    pub(crate) covariance: DMatrix<f64>,
}

impl Smoothed {
    /// `None` if the phases do not determine the smooth phase.
    pub(crate) fn with_walk(errors: &[PhaseError], rate: f64) -> Option<Self> {
        let phases = Phases::new(errors)?;
        let Phases { columns, scale, .. } = phases;
        let Innovations { products, log_determinant } = phases.innovations([rate]);
        if log_determinant[0].is_nan() {
            return None;
        }
        let product = |i: usize, j: usize| products[i.max(j)][i.min(j)][0];
        let cholesky = DMatrix::from_fn(columns, columns, product).cholesky()?;
        let parameters = cholesky.solve(&DVector::from_fn(columns, |i, _| product(i, columns)));
        let inverse = cholesky.inverse();
        let covariance = DMatrix::from_fn(columns, columns, |i, j| inverse[(i, j)] / (scale[i] * scale[j]));
        let parameters = DVector::from_fn(columns, |i, _| parameters[i] / scale[i]);
        parameters.iter().all(|p| p.is_finite()).then_some(Self { parameters, covariance })
    }

    /// A linear combination of the parameters, and its variance.
    pub(crate) fn combined(&self, across: &DVector<f64>) -> (f64, f64) {
        (across.dot(&self.parameters), across.dot(&(&self.covariance * across)))
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::noise::jitter;

    /// One phase without a walk in 20 exceeds this.
    const ERRORS: f64 = 1.6;

    /// `n` phases on a line, one per second, with noise of variance 1/weight and a walk.
    fn phases(n: usize, weight: f64, rate: f64, seed: usize) -> Vec<PhaseError> {
        let mut level = 0.0;
        let of = |i: usize| {
            level += rate.sqrt() * jitter(seed * 10_000 + i, 1);
            let error = level + jitter(seed * 10_000 + i, 0) / weight.sqrt();
            PhaseError { time_s: i as f64, error, weight, averaged_s: 0.0, smooth: vec![1.0, i as f64] }
        };
        (0..n).map(of).collect()
    }

    /// The intervals of a mean rate have the stated coverage, with few steps and with many.
    #[test]
    fn intervals_of_the_rate_hold_the_truth() {
        for n in [8, 40, 200] {
            const REPEATS: usize = 400;
            let missed = (0..REPEATS).filter(|&seed| {
                let phases = phases(n, 1e4, 0.01, seed);
                let smoothed =
                    Smoothed::with_walk(&phases, walk_rate(&phases, |_| true, ERRORS).unwrap_or(0.0))
                        .unwrap();
                let (slope, variance) = smoothed.combined(&DVector::from_vec(vec![0.0, 1.0]));
                slope.abs() > 1.96 * variance.sqrt()
            });
            let part = missed.count() as f64 / REPEATS as f64;
            assert!((0.02..0.08).contains(&part), "{n} phases: {part}");
        }
    }

    #[test]
    fn noise_alone_is_seldom_taken_for_a_walk() {
        let walking = (0..400)
            .filter(|&seed| walk_rate(&phases(60, 1e4, 0.0, seed), |_| true, ERRORS).is_some())
            .count();
        assert!(walking < 40, "{walking} of 400");
    }

    /// The rate of a walk is estimated correctly from means over the full time between them.
    #[test]
    fn means_of_a_walk_tell_its_rate() {
        const PARTS: usize = 20;
        const REPEATS: usize = 10;
        let rate = 0.01;
        let found = |seed: usize| {
            let mut level = 0.0;
            let mut mean = |i: usize| {
                let step = |k: usize| (rate / PARTS as f64).sqrt() * jitter(i * PARTS + k, 3);
                let parts = (0..PARTS).map(|k| {
                    level += step(k);
                    level
                });
                parts.sum::<f64>() / PARTS as f64 + jitter(i, 4) / 20.0
            };
            let phases: Vec<PhaseError> = (300 * seed..300 * (seed + 1))
                .map(|i| PhaseError {
                    time_s: i as f64,
                    error: mean(i),
                    weight: 400.0,
                    averaged_s: 1.0 / 6.0,
                    smooth: vec![1.0, i as f64],
                })
                .collect();
            walk_rate(&phases, |_| true, ERRORS).unwrap()
        };
        let mean = (0..REPEATS).map(found).sum::<f64>() / REPEATS as f64;
        assert!((mean / rate - 1.0).abs() < 0.15, "{mean} for {rate}");
    }

    /// Without noise the steps of a walk are independent: the slope is the difference between the last phase and the
    /// first, with variance `q/T`.
    #[test]
    fn a_walk_without_noise_leaves_the_first_phase_and_the_last() {
        let phases = phases(100, 1e12, 0.3, 0);
        let (slope, variance) =
            Smoothed::with_walk(&phases, 0.3).unwrap().combined(&DVector::from_vec(vec![0.0, 1.0]));
        let expected = (phases[99].error - phases[0].error) / 99.0;
        assert!((slope / expected - 1.0).abs() < 1e-6, "{slope} for {expected}");
        assert!((variance * 99.0 / 0.3 - 1.0).abs() < 1e-6, "{variance}");
    }
}
