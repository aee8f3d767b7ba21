//! Fit of viscous and sliding loss to an amplitude trace, without start values and without allocation.

use super::envelope::{LANES, Pass, Trace, by_thirds, thirds};
use super::lack_of_fit::{UNKNOWNS, lack_of_fit};
use super::minimise::{Sums, minimise_to, spread};
use super::straight::{BEND, SHARE, STRAIGHT};
use crate::Error;
use crate::error::POSITIVE;
use crate::inference::evidence::f_tail;

/// When the amplitudes of a trace were taken.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum Sampling<'a> {
    /// At equal intervals, s, starting at zero.
    Every(f64),
    /// At these times, s; elapsed time counts from the first.
    At(&'a [f64]),
}

/// Result of [`fit_amplitudes`]: each parameter with its standard error.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct AmplitudeFit {
    /// A_0, the amplitude at the first time, signal unit.
    pub initial_amplitude: [f64; 2],
    /// a0, the amplitude loss rate by sliding friction, signal unit per s.
    pub sliding_rate: [f64; 2],
    /// delta = gamma/2m, 1/s.
    pub decay_rate_per_s: [f64; 2],
    /// Correlation of `sliding_rate` and `decay_rate_per_s`.
    pub correlation: f64,
    /// Root mean square of amplitude minus model.
    pub residual_rms: f64,
    /// Ratio of the residual variance in the slow part of the trace (its moments with respect to the lowest
    /// polynomials, or the means of its tenths) to that of the rest, and its degrees of freedom; zeros for
    /// fewer than twenty samples and for residuals at rounding level.
    pub lack_of_fit: [f64; 2],
    /// Whether a further step would change every parameter by less than a hundredth of its standard error.
    pub converged: bool,
    /// Number of passes over the samples.
    pub steps: usize,
}

impl AmplitudeFit {
    /// Friction displacement `x_F = F/k` and its standard error, signal unit, for an oscillation at this
    /// frequency: `a0 = delta x_F coth(pi delta/2 omega_d)`.
    pub fn friction_displacement(&self, frequency_hz: f64) -> [f64; 2] {
        Self::friction_displacements(std::slice::from_ref(self), &[frequency_hz])[0]
    }

    /// Amplitude of the law `elapsed_s` seconds after the first time, signal unit.
    pub fn amplitude_at(&self, elapsed_s: f64) -> f64 {
        let [initial, rate] = [self.initial_amplitude[0], self.decay_rate_per_s[0]];
        let fall = -(-rate * elapsed_s).exp_m1();
        let gain = if rate == 0.0 { elapsed_s } else { fall / rate };
        initial * (1.0 - fall) - self.sliding_rate[0] * gain
    }

    /// Probability that a trace of `samples` samples without sliding friction would show at least this much
    /// of it. One-sided, since friction cannot be negative; 1 if the estimate is negative.
    pub fn sliding_p_value(&self, samples: usize) -> f64 {
        Self::sliding_p_values(std::slice::from_ref(self), samples)[0]
    }

    /// Probability that a decay under viscous and sliding friction, with white noise, has residuals at least
    /// this large in the slow part of a trace of `samples` samples: an F test of
    /// [`lack_of_fit`](Self::lack_of_fit). It is small if the motion stops within the trace, reaches a noise
    /// floor or follows another law, or if the noise is not white.
    pub fn misfit_p_value(&self, samples: usize) -> f64 {
        let [ratio, freedom] = self.lack_of_fit;
        let rest = samples as f64 - UNKNOWNS as f64 - freedom;
        if freedom > 0.0 && rest > 0.0 { f_tail(ratio, freedom, rest) } else { 1.0 }
    }
}

/// Fits the decay under viscous and sliding friction to an amplitude trace.
///
/// With `G = (1 - e^(-delta t))/delta`, which equals `t` without viscous loss, and the initial slope
/// `s = a0 + delta A_0`,
///
/// ```text
/// A(t) = A_0 e^(-delta t) - a0 G = A_0 - s G
/// ```
///
/// eq. (15) and (16) of Vitorino, Vieira and Rodrigues, *Effect of sliding friction in harmonic oscillators*.
/// This is the law fitted by [`fit_envelope`](super::fit_envelope), with `C = a0/delta`; in `A_0`, `s` and
/// `delta` it remains regular if sliding friction is the only loss. Nothing is allocated, and no start values
/// are needed: they come from sums over the thirds of the trace.
///
/// - `sampling`: a positive interval, or one time per amplitude in non-decreasing order
/// - `amplitude`: any unit; the motion must not have come to rest, and noise must not have rectified it
///
/// Standard errors assume white noise with the variance of the residuals. No parameter is constrained to be
/// positive, so that averages over many traces remain unbiased.
///
/// # Errors
/// - [`Error::Length`] if times and amplitudes differ in number
/// - [`Error::TooFewSamples`] for fewer than four
/// - [`Error::Parameter`] for a value that is not finite or an interval that is not positive
/// - [`Error::TimeBackwards`] for a time earlier than the preceding one
/// - [`Error::NoFit`] if the data do not determine three parameters, e.g. for a constant trace
///
/// ```
/// use slipfit::ringdown::{Sampling, fit_amplitudes};
/// // Sliding friction alone takes 0.3 a second.
/// let trace: Vec<f64> = (0..200).map(|i| 1.0 - 0.3 * 0.01 * f64::from(i)).collect();
/// let fit = fit_amplitudes(Sampling::Every(0.01), &trace)?;
/// assert!((fit.sliding_rate[0] - 0.3).abs() < 1e-9);
/// assert!(fit.decay_rate_per_s[0].abs() < 1e-9);
/// # Ok::<(), slipfit::Error>(())
/// ```
pub fn fit_amplitudes(sampling: Sampling<'_>, amplitude: &[f64]) -> Result<AmplitudeFit, Error> {
    let n = amplitude.len();
    let data = match sampling {
        Sampling::Every(interval) => {
            if !(interval > 0.0 && interval.is_finite()) {
                let range = POSITIVE;
                return Err(Error::Parameter { name: "interval_s", value: interval, range });
            }
            super::check_lengths("amplitude", n, n, 4)?;
            Trace { time: None, amplitude, first: 0.0, interval: Some(interval) }
        }
        Sampling::At(time_s) => {
            super::check_lengths("amplitude", time_s.len(), n, 4)?;
            super::check_finite("time_s", time_s)?;
            super::check_order(time_s)?;
            Trace { time: Some(time_s), amplitude, first: time_s[0], interval: None }
        }
    };
    let (power, thirds) = crate::numeric::dispatch(PowerAndThirds(amplitude));
    if !power.is_finite() {
        super::check_finite("amplitude", amplitude)?;
    }
    let elapsed = |i: usize| match sampling {
        Sampling::Every(interval) => interval * i as f64,
        Sampling::At(time_s) => time_s[i] - time_s[0],
    };
    let duration = elapsed(n - 1);
    let curved = data.interval.and_then(|interval| by_thirds(thirds, n / 3, interval));
    let start = match curved {
        Some([height, level, rate]) => [height + level, height * rate, rate],
        // A straight line through the first and last third.
        None => {
            let part = (n / 3) as f64;
            let [first, last] = [thirds[0] / part, thirds[2] / part];
            let slope = (first - last) / (duration * 2.0 / 3.0);
            [first + slope * duration / 6.0, slope, 0.0]
        }
    };
    let sums = |&[initial, slope, rate]: &[f64; 3]| {
        if (rate * duration).abs() < STRAIGHT {
            return Some(crate::numeric::dispatch(Straight { data: &data, initial, slope, rate }));
        }
        let height = slope / rate;
        let pass = Pass { data: &data, height, level: initial - height, rate };
        Some(by_slope(&crate::numeric::dispatch(pass), height, rate))
    };
    let moved = |p: &[f64; 3], step: &[f64; 3]| [p[0] + step[0], p[1] + step[1], p[2] + step[2]];
    let found = minimise_to(TOLERANCE, start, n as f64, power, sums, moved)
        .filter(|found| found.best.iter().all(|v| v.is_finite()))
        .ok_or(Error::NoFit { reason: "the trace does not distinguish a decay rate from a sliding rate" })?;
    let [initial, slope, rate] = found.best;
    // a0 = s - delta A_0.
    let rows = [[1.0, 0.0, 0.0], [-rate, 1.0, -initial], [0.0, 0.0, 1.0]];
    let (error, correlation) = spread(&congruent(&found.inverse, &rows), found.rss / (n - 3) as f64);
    Ok(AmplitudeFit {
        initial_amplitude: [initial, error[0]],
        sliding_rate: [slope - rate * initial, error[1]],
        decay_rate_per_s: [rate, error[2]],
        correlation: correlation[1][2],
        residual_rms: (found.rss / n as f64).sqrt(),
        lack_of_fit: lack_of_fit(elapsed, amplitude, found.best),
        converged: found.converged,
        steps: found.passes,
    })
}

/// Tolerance as a fraction of a standard error, extrapolated from the convergence of the steps so far; if
/// convergence slows down at the end, it may be exceeded by a factor of a hundred. It matches the accuracy to
/// which [`EvenTraces`](super::EvenTraces) finds the minimum by another method.
const TOLERANCE: f64 = 1e-10;

/// `R A R^T` for a symmetric `A`.
fn congruent(a: &[[f64; 3]; 3], rows: &[[f64; 3]; 3]) -> [[f64; 3]; 3] {
    let mut out = [[0.0; 3]; 3];
    for i in 0..3 {
        for j in 0..3 {
            for k in 0..3 {
                for l in 0..3 {
                    out[i][j] += rows[i][k] * a[k][l] * rows[j][l];
                }
            }
        }
    }
    out
}

/// Converts the sums for height `s/delta`, level and rate, whose derivatives are `e`, 1 and `-(s/delta) t e`,
/// to those for `A_0`, `s`, `delta`:
///
/// ```text
/// by A_0 = 1      by s = (e - 1)/delta      by delta = -(s/delta) t e + (s/delta) (1 - e)/delta
/// ```
pub(super) fn by_slope(sums: &Sums<3>, height: f64, rate: f64) -> Sums<3> {
    let (per, bent) = (1.0 / rate, height / rate);
    let rows = [[0.0, 1.0, 0.0], [per, -per, 0.0], [-bent, bent, 1.0]];
    // The minimiser uses only the lower triangle, but here the full matrix is needed; `Pass` provides it.
    let mut jtr = [0.0; 3];
    for (out, row) in jtr.iter_mut().zip(&rows) {
        *out = row[0] * sums.jtr[0] + row[1] * sums.jtr[1] + row[2] * sums.jtr[2];
    }
    Sums { jtj: congruent(&sums.jtj, &rows), jtr, rss: sums.rss }
}

/// Sum of squares and sums over the thirds of a trace.
struct PowerAndThirds<'a>(&'a [f64]);

impl pulp::NullaryFnOnce for PowerAndThirds<'_> {
    type Output = (f64, [f64; 3]);

    #[inline(always)]
    fn call(self) -> (f64, [f64; 3]) {
        let mut lanes = [0.0; 2 * LANES];
        let mut chunks = self.0.chunks_exact(2 * LANES);
        for values in &mut chunks {
            for k in 0..2 * LANES {
                lanes[k] += values[k] * values[k];
            }
        }
        let mut power = 0.0;
        for lane in lanes {
            power += lane;
        }
        for v in chunks.remainder() {
            power += v * v;
        }
        (power, thirds(self.0))
    }
}

/// The sums for a decay close to a straight line.
pub(super) struct Straight<'a> {
    pub(super) data: &'a Trace<'a>,
    pub(super) initial: f64,
    pub(super) slope: f64,
    pub(super) rate: f64,
}

impl pulp::NullaryFnOnce for Straight<'_> {
    type Output = Sums<3>;

    #[inline(always)]
    fn call(self) -> Sums<3> {
        let Self { data, initial, slope, rate } = self;
        // r, rr, g, gg, gr, h, hh, hr, gh with g the derivative by the slope and h that by the rate.
        let mut lanes = [[0.0; LANES]; 9];
        for (i, y) in data.amplitude.chunks(LANES).enumerate() {
            let u = data.elapsed(i * LANES, y.len());
            let (mut v, mut w) = ([0.0; LANES], [1.0; LANES]);
            if let Ok(whole) = <[f64; LANES]>::try_from(y) {
                v = whole;
            } else {
                w = [0.0; LANES];
                v[..y.len()].copy_from_slice(y);
                w[..y.len()].fill(1.0);
            }
            for k in 0..LANES {
                let z = -rate * u[k];
                let (mut share, mut bend) = (0.0, 0.0);
                for (a, b) in SHARE.iter().zip(&BEND).rev() {
                    share = share * z + a;
                    bend = bend * z + b;
                }
                let g = -w[k] * u[k] * share;
                let h = slope * w[k] * u[k] * u[k] * bend;
                let r = w[k] * (v[k] - initial - slope * g);
                lanes[0][k] += r;
                lanes[1][k] += r * r;
                lanes[2][k] += g;
                lanes[3][k] += g * g;
                lanes[4][k] += g * r;
                lanes[5][k] += h;
                lanes[6][k] += h * h;
                lanes[7][k] += h * r;
                lanes[8][k] += g * h;
            }
        }
        let [r, rr, g, gg, gr, h, hh, hr, gh] = lanes.map(|lane| lane.iter().sum());
        let n = data.amplitude.len() as f64;
        Sums { jtj: [[n, g, h], [g, gg, gh], [h, gh, hh]], jtr: [r, gr, hr], rss: rr }
    }
}
