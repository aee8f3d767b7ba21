//! Fit of the exact motion to every sample.

use super::last_turn;
use super::minimise::{Minimum, spread};
use super::samples::{Samples, Stop, improved_start};
use crate::Error;
use crate::motion::decay::amplitude::sliding_gain;
use crate::motion::decay::closed_sums::Fall;
use std::f64::consts::TAU;

/// Parameters of a free decay with viscous and sliding friction.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Decay {
    /// A_0: the value of the turning-point law at the first time, signal unit.
    pub initial_amplitude: f64,
    /// x_F = F/k, signal unit.
    pub friction_displacement: f64,
    /// delta = gamma/2m, 1/s.
    pub decay_rate_per_s: f64,
    /// Phase at the first time, rad; zero at an upper turning point.
    pub phase_rad: f64,
    /// omega_d/2 pi, Hz.
    pub frequency_hz: f64,
    /// Rest position of the spring, signal unit.
    pub offset: f64,
}

impl Decay {
    fn from_parameters([a, x_f, delta, phase, omega, offset]: [f64; 6]) -> Self {
        Self {
            initial_amplitude: a,
            friction_displacement: x_f,
            decay_rate_per_s: delta,
            phase_rad: phase,
            frequency_hz: omega / TAU,
            offset,
        }
    }
}

/// Result of [`fit_waveform`].
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct DecayFit {
    /// The least-squares parameters.
    pub best: Decay,
    /// Their standard errors, each in its parameter's unit.
    pub std_error: Decay,
    /// Their correlations, in the order of the fields.
    pub correlation: [[f64; 6]; 6],
    /// Root mean square of signal minus model.
    pub residual_rms: f64,
    /// Whether a further step would change every parameter by less than a hundredth of its standard error.
    pub converged: bool,
    /// Number of passes over all samples in the search that found it.
    pub steps: usize,
}

/// Fits the exact free decay under viscous and sliding friction to every sample.
///
/// With `t` counted from the first time, `Phi = omega_d t + phase`, the turning
/// points `t_n` where `Phi = n pi`, and `s = (-1)^n`, the motion is
///
/// ```text
/// x = offset + s x_F + s (X_n - x_F) e^(-delta (t - t_n)) [cos(Phi - n pi) + (delta/omega_d) sin(Phi - n pi)]
/// X_n + C = (A_0 + C) e^(-delta t_n),   C = x_F coth(pi delta/2 omega_d)
/// ```
///
/// and rests from the first turning point with `X_n <= x_F` on. Eq. (15) and (16) of Vitorino, Vieira and
/// Rodrigues, *Effect of sliding friction in harmonic oscillators*, are its cycle average at high Q, with
/// `C = 4F/(pi gamma omega_0)`.
///
/// - `time_s`: s, non-decreasing, in arbitrary steps
/// - `signal`: displacement in any unit, one value per time
/// - `start`: start values of the search. The frequency must be correct to about half a cycle over the
///   record, the phase to about a radian
///
/// If the record extends past the stop, there is a minimum for every turning point at which the motion may
/// have stopped: the lowest of them is found, in about four times the time needed for one of them.
///
/// Standard errors assume white noise with the variance of the residuals. Losses may be negative, so that
/// averages over many records remain unbiased.
///
/// # Errors
/// - [`Error::Length`] if the two differ in length
/// - [`Error::TooFewSamples`] for fewer than seven
/// - [`Error::TimeBackwards`] for a time earlier than the preceding one
/// - [`Error::Parameter`] for a value that is not finite or a start frequency that is not positive
/// - [`Error::NoFit`] if the data do not determine six parameters, or if the start's decay rate is many times
///   its frequency
///
/// ```
/// use slipfit::ringdown::{Decay, fit_waveform};
/// use slipfit::{Oscillator, motion::decay::FreeDecay};
///
/// let oscillator = Oscillator::kinematic(40.0, 0.1, 0.002)?;
/// let decay = FreeDecay::from_rest(&oscillator, 1.0)?;
/// let time: Vec<f64> = (0..3000).map(|i| 0.002 * f64::from(i)).collect();
/// let signal: Vec<f64> = time.iter().map(|&t| decay.displacement(t)).collect();
/// let start = Decay {
///     initial_amplitude: 0.9,
///     friction_displacement: 0.0,
///     decay_rate_per_s: 0.2,
///     phase_rad: 0.1,
///     frequency_hz: 6.35,
///     offset: 0.0,
/// };
/// let fit = fit_waveform(&time, &signal, &start)?;
/// assert!((fit.best.friction_displacement - 0.002).abs() < 1e-9);
/// # Ok::<(), slipfit::Error>(())
/// ```
pub fn fit_waveform(time_s: &[f64], signal: &[f64], start: &Decay) -> Result<DecayFit, Error> {
    let n = time_s.len();
    super::check_lengths("signal", n, signal.len(), 7)?;
    super::check_start(&[
        ("initial_amplitude", start.initial_amplitude),
        ("friction_displacement", start.friction_displacement),
        ("decay_rate_per_s", start.decay_rate_per_s),
        ("phase_rad", start.phase_rad),
        ("offset", start.offset),
    ])?;
    if !(start.frequency_hz > 0.0 && start.frequency_hz.is_finite()) {
        return Err(Error::Parameter {
            name: "frequency_hz",
            value: start.frequency_hz,
            range: "positive finite frequencies",
        });
    }
    let (power, ordered) = crate::numeric::dispatch(PowerAndOrder { time: time_s, signal });
    if !(ordered && power.is_finite()) {
        super::check_finite("time_s", time_s)?;
        super::check_finite("signal", signal)?;
        super::check_order(time_s)?;
    }
    let origin = time_s[0];
    let at = [
        start.initial_amplitude,
        start.friction_displacement,
        start.decay_rate_per_s,
        start.phase_rad,
        TAU * start.frequency_hz,
        start.offset,
    ];
    let duration = time_s[n - 1] - origin;
    let samples = Samples { time: time_s, signal, power };
    let mut found = None;
    if let Some((near, rss)) = improved_start(time_s, signal, &at) {
        // The fit of the pieces gives the expected residual.
        found = samples.fit(near, Stop::Never).filter(|f| f.converged && f.rss < 2.0 * rss + 1e-20 * power);
    }
    found = found.or_else(|| samples.fit(at, Stop::Never));
    let unsure = found.is_none_or(|f| stopped(&f.best, duration) || samples.end_is_calmer(f.rss));
    if unsure {
        let own = samples.fit(at, Stop::Friction);
        let smooth = found.and_then(|f| {
            if stopped(&f.best, duration) { samples.fit(f.best, Stop::Friction) } else { Some(f) }
        });
        let known = [smooth, own].into_iter().flatten().min_by(|a, b| a.rss.total_cmp(&b.rss));
        found = last_turn::of_any_part(&samples, &at, known);
    } else if let Some((fit, stopping)) = found.and_then(|f| Some((f, may_stop(&f, duration, n)?))) {
        found = last_turn::near_stopping(&samples, &stopping, fit);
    }
    let found = found.ok_or(Error::NoFit { reason: "the samples do not determine all six parameters" })?;
    let (mut error, correlation) = spread(&found.inverse, found.rss / (n - 6) as f64);
    error[4] = error[4].abs();
    Ok(DecayFit {
        best: Decay::from_parameters(found.best),
        std_error: Decay::from_parameters(error),
        correlation,
        residual_rms: (found.rss / n as f64).sqrt(),
        converged: found.converged,
        steps: found.passes,
    })
}

/// Number of standard errors of friction within which a stop is considered possible.
const ERRORS: f64 = 5.0;

/// A motion that the samples do not exclude and that stops within `duration`.
fn may_stop(fit: &Minimum<6>, duration: f64, samples: usize) -> Option<[f64; 6]> {
    let error = (fit.inverse[1][1].max(0.0) * fit.rss / samples as f64).sqrt();
    let more = std::array::from_fn(|k| fit.best[k] + ERRORS * error * fit.inverse[k][1] / fit.inverse[1][1]);
    stopped(&more, duration).then_some(more)
}

/// Whether friction stops the motion within `duration`.
fn stopped(&[a0, x_f, delta, _, omega, _]: &[f64; 6], duration: f64) -> bool {
    let fall = Fall::after(delta, duration);
    a0 * fall.e - x_f * (sliding_gain(delta, omega)[0] * fall.g + 1.0) <= 0.0
}

/// Sum of squares of the samples, and whether the times are finite and non-decreasing.
struct PowerAndOrder<'a> {
    time: &'a [f64],
    signal: &'a [f64],
}

impl pulp::NullaryFnOnce for PowerAndOrder<'_> {
    type Output = (f64, bool);

    #[inline(always)]
    fn call(self) -> (f64, bool) {
        const LANES: usize = 8;
        let mut power = [0.0; LANES];
        let mut values = self.signal.chunks_exact(LANES);
        for y in &mut values {
            for k in 0..LANES {
                power[k] += y[k] * y[k];
            }
        }
        let mut sum = 0.0;
        for p in power {
            sum += p;
        }
        for y in values.remainder() {
            sum += y * y;
        }
        let mut falls = 0_u64;
        let n = self.time.len();
        for (a, b) in self.time[..n - 1].iter().zip(&self.time[1..]) {
            falls += u64::from(!(a <= b));
        }
        // If the times are in order, infinities can occur only at the ends.
        (sum, falls == 0 && self.time[0].is_finite() && self.time[n - 1].is_finite())
    }
}
