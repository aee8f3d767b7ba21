//! Fit of traces given by their moments, several in parallel.

use super::amplitudes::AmplitudeFit;
use super::lack_of_fit;
use super::moments::{DEGREES, recurrence};
use crate::numeric::trig::{fused, has_fused};

/// Number of traces fitted in parallel.
pub(super) const TRACES: usize = 16;

type Lanes = [f64; TRACES];

/// Traces given by their moments; a trace with zero power is ignored.
#[derive(Debug, Default)]
pub(super) struct Known {
    /// `c_k`, with respect to the polynomials of degree `k` that are orthonormal over the samples.
    pub(super) moments: [Lanes; DEGREES],
    /// Sums of squares of the samples.
    pub(super) power: Lanes,
    /// Time from the first sample to the last, s.
    pub(super) duration: Lanes,
}

/// The law over `samples` samples, `y = m + b (G - mean G)` with
///
/// ```text
/// G(z) = (1 - e^(-z s))/z = sum_j (-z)^j s^(j+1)/(j+1)!      -1 <= s <= 1, z = delta T/2
/// ```
///
/// projected on the polynomials below a given degree. Its products with a trace and with itself are power
/// series in `z`, which need no exponential and are regular without viscous loss.
#[derive(Debug, Clone)]
pub(super) struct Law {
    samples: f64,
    degrees: usize,
    /// Maximum of `|z|`.
    most: f64,
    /// Moments of each power of `z` in `G`.
    powers: Vec<[f64; DEGREES]>,
    /// Coefficients of the mean of `G`, of odd powers of `z`.
    mean: Vec<f64>,
    /// Coefficients of `sum (G - mean G)²` and `sum (G' - mean G')²`, in powers of `z²`.
    square: Vec<[f64; 2]>,
    /// `1/(j+1)!` and `(j+1)/(j+2)!`: of `(e^z - 1)/z` and its derivative.
    share: Vec<[f64; 2]>,
}

/// Number of moments sufficient for slow decays, and the number of decay times up to which they are:
/// parameters are accurate to 1e-7 of their standard errors.
pub(super) const FEW: usize = 10;
const SLOW: f64 = 2.0;
/// Limit of decay times with all moments; the error exceeds 1e-8 of a standard error.
const FASTEST: f64 = 8.0;
/// Number of powers of `z` in `G`: the first one omitted is below 1e-18 for slow decays and 1e-19 for the
/// fastest.
const TERMS: [usize; 2] = [19, 34];
/// Number of powers of `z²` in the squares, which grow twice as fast.
const SQUARES: [usize; 2] = [13, 24];

impl Law {
    /// The law with the first [`FEW`] moments or with all.
    pub(super) fn new(samples: usize, few: bool) -> Self {
        let (degrees, decay_times, at) = if few { (FEW, SLOW, 0) } else { (DEGREES, FASTEST, 1) };
        const MOST: usize = 2 * 24 + 2;
        let n = samples as f64;
        let factors: [f64; MOST + 1] = recurrence(samples);
        // Moments of s^j, each computed from those of the preceding power.
        let mut power = [0.0; MOST];
        power[0] = n.sqrt();
        let mut per = 1.0;
        let terms: Vec<[f64; DEGREES]> = (0..2 * SQUARES[at])
            .map(|j| {
                power = std::array::from_fn(|k| {
                    let below = if k > 0 { factors[k] * power[k - 1] } else { 0.0 };
                    below + if k + 1 < MOST { factors[k + 1] * power[k + 1] } else { 0.0 }
                });
                per /= -(j as f64 + 1.0);
                std::array::from_fn(|k| if k < degrees { -per * power[k] } else { 0.0 })
            })
            .collect();
        let dot = |i: usize, j: usize| -> f64 { (1..degrees).map(|k| terms[i][k] * terms[j][k]).sum() };
        let square = |i: usize| {
            let own: f64 = (0..=2 * i).map(|j| dot(j, 2 * i - j)).sum();
            // The same for G', whose coefficient of z^(j-1) is j times as large.
            let bend = |j: usize| (j * (2 * i + 2 - j)) as f64 * dot(j, 2 * i + 2 - j);
            [own, (1..2 * i + 2).map(bend).sum()]
        };
        let mut factorial = 1.0;
        Self {
            samples: n,
            degrees,
            most: 0.5 * decay_times,
            mean: (1..TERMS[at]).step_by(2).map(|j| terms[j][0] / n.sqrt()).collect(),
            square: (0..SQUARES[at] - 1).map(square).collect(),
            share: (0..TERMS[at])
                .map(|j| {
                    factorial *= (j + 1) as f64;
                    let one = 1.0 / factorial;
                    [one, one * (j + 1) as f64 / (j + 2) as f64]
                })
                .collect(),
            powers: terms[..TERMS[at]].to_vec(),
        }
    }

    /// Fits the traces; the result includes those that the moments determine.
    pub(super) fn fit(&self, known: &Known) -> Found {
        crate::numeric::dispatch(Fit { law: self, known })
    }
}

/// Results of the fit, per lane.
#[derive(Debug)]
pub(super) struct Found {
    pub(super) serves: [bool; TRACES],
    initial: [Lanes; 2],
    sliding: [Lanes; 2],
    decay: [Lanes; 2],
    correlation: Lanes,
    rms: Lanes,
    lack_of_fit: [Lanes; 2],
}

impl Found {
    /// The fit of a lane; `None` if the moments do not determine it.
    pub(super) fn lane(&self, lane: usize) -> Option<AmplitudeFit> {
        let of = |pair: &[Lanes; 2]| [pair[0][lane], pair[1][lane]];
        self.serves[lane].then(|| AmplitudeFit {
            initial_amplitude: of(&self.initial),
            sliding_rate: of(&self.sliding),
            decay_rate_per_s: of(&self.decay),
            correlation: self.correlation[lane],
            residual_rms: self.rms[lane],
            lack_of_fit: of(&self.lack_of_fit),
            converged: true,
            steps: 1,
        })
    }
}

/// Maximum number of steps of a fit that converges; most take two.
const MOST_STEPS: usize = 12;
/// Tolerance as a fraction of a standard error.
const TOLERANCE: f64 = 1e-8;
/// Residuals below this fraction of the signal's power are differences of nearly equal sums and lose digits.
const EXACT: f64 = 1e-9;
/// Standard error of `delta T` beyond which the law is nonlinear within it: a fit with safeguarded steps is
/// required.
const MOST_RATE_ERROR: f64 = 0.3;

/// Products at `z`: of the law and its derivatives with the trace (`gy`, …), with itself, and of its
/// derivative with itself.
struct At {
    gy: Lanes,
    hy: Lanes,
    by: Lanes,
    gg: Lanes,
    gh: Lanes,
    gh_slope: Lanes,
    hh: Lanes,
}

struct Fit<'a> {
    law: &'a Law,
    known: &'a Known,
}

impl pulp::WithSimd for Fit<'_> {
    type Output = Found;

    #[inline(always)]
    fn with_simd<S: pulp::Simd>(self, _: S) -> Found {
        if const { has_fused::<S>() } { self.found::<true>() } else { self.found::<false>() }
    }
}

impl Fit<'_> {
    #[inline(always)]
    fn at<const FUSED: bool>(&self, series: &[Lanes], z: &Lanes) -> At {
        let zero = [0.0; TRACES];
        let (mut gy, mut hy, mut by) = (zero, zero, zero);
        for term in series.iter().rev() {
            for k in 0..TRACES {
                by[k] = fused::<FUSED>(by[k], z[k], hy[k]);
                hy[k] = fused::<FUSED>(hy[k], z[k], gy[k]);
                gy[k] = fused::<FUSED>(gy[k], z[k], term[k]);
            }
        }
        let (mut gg, mut first, mut second, mut hh) = (zero, zero, zero, zero);
        for [own, bend] in self.law.square.iter().rev() {
            for k in 0..TRACES {
                let q = z[k] * z[k];
                second[k] = fused::<FUSED>(second[k], q, first[k]);
                first[k] = fused::<FUSED>(first[k], q, gg[k]);
                gg[k] = fused::<FUSED>(gg[k], q, *own);
                hh[k] = fused::<FUSED>(hh[k], q, *bend);
            }
        }
        let (mut gh, mut gh_slope) = (zero, zero);
        for k in 0..TRACES {
            by[k] *= 2.0;
            gh[k] = z[k] * first[k];
            gh_slope[k] = 4.0 * z[k] * z[k] * second[k] + first[k];
        }
        At { gy, hy, by, gg, gh, gh_slope, hh }
    }

    /// Newton's method in the rate alone, since level and slope are linear parameters.
    #[inline(always)]
    fn found<const FUSED: bool>(&self) -> Found {
        let Self { law, known } = self;
        let n = law.samples;
        let per_freedom = 1.0 / (n - 3.0);
        let (per_sample, per_root) = (1.0 / n, 1.0 / n.sqrt());
        let zero = [0.0; TRACES];
        // The products of the trace with G, as a series in z.
        let mut series = [zero; TERMS[1]];
        let series = &mut series[..law.powers.len()];
        for (j, (to, of)) in series.iter_mut().zip(&law.powers).enumerate() {
            // Polynomials of the other parity and those of higher degree do not contribute.
            for d in (2 - (j + 1) % 2..law.degrees.min(j + 2)).step_by(2) {
                for k in 0..TRACES {
                    to[k] = fused::<FUSED>(of[d], known.moments[d][k], to[k]);
                }
            }
        }
        let mut z = zero;
        let mut about_mean = zero;
        for k in 0..TRACES {
            z[k] = start(known.moments[1][k], known.moments[2][k]);
            about_mean[k] = known.power[k] - known.moments[0][k] * known.moments[0][k];
        }
        let mut before = zero;
        let mut ended = [false; TRACES];
        for _ in 0..MOST_STEPS {
            let at = self.at::<FUSED>(series, &z);
            let mut open = false;
            for k in 0..TRACES {
                let per = 1.0 / at.gg[k];
                let (slope, along) = (at.gy[k] * per, at.gh[k] * per);
                let across = at.hh[k] - along * at.gh[k];
                // Half the derivative of gy²/gg divided by the slope, and the derivative of that.
                let ascent = at.hy[k] - along * at.gy[k];
                let bend = at.by[k] - along * at.hy[k] - slope * (at.gh_slope[k] - 2.0 * along * at.gh[k]);
                let plain = -slope * across;
                // Far from the maximum the second derivative is not yet reliable and the Gauss-Newton value
                // is used.
                let (product, square) = (bend * plain, plain * plain);
                let bend = if (product > 0.5 * square) & (product < 2.0 * square) { bend } else { plain };
                let step = -ascent / bend;
                let variance = (about_mean[k] - slope * at.gy[k]) * per_freedom;
                // If the steps continue to shrink quadratically, as in Newton's method, the next one is the
                // cube of this one over the square of the last.
                let (this, last) = (step * step, before[k]);
                let small = this * this * this * slope * slope * across
                    <= TOLERANCE * TOLERANCE * variance * last * last;
                before[k] = this;
                z[k] = if ended[k] { z[k] } else { z[k] + step };
                ended[k] |= (small & (this < last)) | !(z[k].abs() < 2.0 * law.most);
                open |= !ended[k];
            }
            if !open {
                break;
            }
        }
        let at = self.at::<FUSED>(series, &z);
        let (mut mean, mut mean_slope) = (zero, zero);
        for term in law.mean.iter().rev() {
            for k in 0..TRACES {
                let q = z[k] * z[k];
                mean_slope[k] = fused::<FUSED>(mean_slope[k], q, mean[k]);
                mean[k] = fused::<FUSED>(mean[k], q, *term);
            }
        }
        let (mut share, mut share_slope) = (zero, zero);
        for [one, slope] in law.share.iter().rev() {
            for k in 0..TRACES {
                share[k] = fused::<FUSED>(share[k], z[k], *one);
                share_slope[k] = fused::<FUSED>(share_slope[k], z[k], *slope);
            }
        }
        let mut found = Found {
            serves: [false; TRACES],
            initial: [zero; 2],
            sliding: [zero; 2],
            decay: [zero; 2],
            correlation: zero,
            rms: zero,
            lack_of_fit: [zero; 2],
        };
        // Power of the trace in the polynomials above the mean.
        let mut slow = zero;
        for moment in &known.moments[1..law.degrees] {
            for k in 0..TRACES {
                slow[k] = fused::<FUSED>(moment[k], moment[k], slow[k]);
            }
        }
        for k in 0..TRACES {
            let z = z[k];
            let per = 1.0 / at.gg[k];
            let (b, along) = (at.gy[k] * per, at.gh[k] * per);
            let across = at.hh[k] - along * at.gh[k];
            let ascent = at.hy[k] - along * at.gy[k];
            let rss = about_mean[k] - b * at.gy[k];
            let variance = rss * per_freedom;
            let sharp = b * b * across;
            let z_variance = variance / sharp;
            // Mean of G: odd powers only.
            let (level, level_slope) = (z * mean[k], mean[k] + 2.0 * z * z * mean_slope[k]);
            // G at the first sample is -share; e^z = 1 + z share.
            let (fall, fall_slope) = (share[k] + level, share_slope[k] + level_slope);
            let rise = 2.0 * fused::<FUSED>(z, share[k], 1.0);
            let initial = known.moments[0][k] * per_root - b * fall;
            // The slope is a function of the rate: b' = -along b.
            let initial_slope = b * (along * fall - fall_slope);
            let initial_variance =
                variance * (per_sample + fall * fall * per) + initial_slope * initial_slope * z_variance;
            // a0 T = -2 b e^z - 2 z A_0.
            let sliding = -b * rise - 2.0 * z * initial;
            let by_b = 2.0 * z * fall - rise;
            let sliding_slope = -b * rise * (1.0 - along) - 2.0 * initial - 2.0 * z * initial_slope;
            let sliding_variance = variance * (4.0 * z * z * per_sample + by_b * by_b * per)
                + sliding_slope * sliding_slope * z_variance;
            let sliding_error = sliding_variance.sqrt();
            let z_error = z_variance.sqrt();
            let rate = 1.0 / known.duration[k];
            found.initial[0][k] = initial;
            found.initial[1][k] = initial_variance.sqrt();
            found.sliding[0][k] = sliding * rate;
            found.sliding[1][k] = sliding_error * rate;
            found.decay[0][k] = 2.0 * z * rate;
            found.decay[1][k] = 2.0 * z_error * rate;
            found.correlation[k] = sliding_slope * z_error / sliding_error;
            found.rms[k] = (rss * per_sample).sqrt();
            let left = lack_of_fit::ratio(slow[k] - b * at.gy[k], rss, law.degrees, n as usize);
            [found.lack_of_fit[0][k], found.lack_of_fit[1][k]] = left;
            found.serves[k] = ended[k]
                & (known.power[k] > 0.0)
                & (z.abs() <= law.most)
                // Size of the step that would follow.
                & ((b * ascent).abs() <= 10.0 * TOLERANCE * z_error * sharp)
                & (2.0 * z_error < MOST_RATE_ERROR)
                & (rss > EXACT * known.power[k]);
        }
        found
    }
}

/// Start of `z` from the moments of first and second degree: for an exponential on -1 to 1, `e^(-z s)`, their
/// ratio is that of the spherical Bessel functions `i_2/i_1`, approximately `7 z/(35 + z²)`; a constant level
/// contributes to neither.
#[inline(always)]
fn start(first: f64, second: f64) -> f64 {
    // The orthonormal polynomials are the Legendre polynomials times the root of 2 k + 1.
    const ROOT: f64 = 0.774_596_669_241_483_4;
    let ratio = -ROOT * second / first;
    // Noise may give a ratio larger than that of any exponential.
    let ratio = if ratio.abs() < 0.55 { ratio } else { 0.55f64.copysign(ratio) };
    70.0 * ratio / (7.0 + (49.0 - 140.0 * ratio * ratio).sqrt())
}
