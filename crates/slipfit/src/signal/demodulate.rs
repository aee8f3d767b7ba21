//! Reduction of a driven record to one point of a resonance curve.
//!
//! The response of an oscillator to a harmonic drive begins with a transient and ends in a steady motion at the
//! frequency of the drive. [`demodulate`] takes the frequency from the recorded drive, finds the end of the
//! transient, and gives amplitude and phase of the fundamental after it.

mod criteria;
mod settle;
mod sine;

pub use criteria::Criteria;

use crate::error::POSITIVE;
use crate::{Error, Quantity};
use settle::Settled;
use sine::{PhaseLaw, Sine, Wave};

use crate::signal::{blocks::wrap, criteria::SpectrumCriteria, spectrum};

/// Options of [`demodulate`]. By default everything is determined automatically.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
#[non_exhaustive]
pub struct Options {
    /// Frequency of the drive, Hz, if it is known better than from the record.
    pub frequency_hz: Option<f64>,
    /// Start of the stretch used, s; the end of the transient is then not searched for.
    pub start_s: Option<f64>,
    /// End of the stretch used, s.
    pub end_s: Option<f64>,
}

/// The steady motion of one driven record.
#[derive(Debug, Clone, PartialEq)]
#[non_exhaustive]
pub struct SteadyMotion {
    /// Frequency of the drive, Hz.
    pub frequency_hz: Quantity,
    /// Amplitude of the fundamental, in the response's unit.
    pub amplitude: Quantity,
    /// Its phase relative to the drive, rad in (-pi, pi]; negative for a lag. `None` without a recorded drive.
    pub phase_rad: Option<Quantity>,
    /// Amplitude of the drive's fundamental, in the drive's unit.
    pub drive_amplitude: Option<Quantity>,
    /// Beginning of the stretch used, s.
    pub start_s: f64,
    /// Its end, s.
    pub end_s: f64,
    /// Number of samples in it.
    pub samples: usize,
    /// Number of drive cycles in it.
    pub cycles: f64,
    /// Deviation of the drive frequency from its mean, root mean square, Hz.
    pub frequency_wander_hz: f64,
    /// Length of the excluded transient, s.
    pub transient_s: f64,
    /// Whether amplitude and phase had become constant.
    pub settled: bool,
    /// Root mean square of the residuals after fundamental, harmonics, offset and drift.
    pub residual_rms: f64,
    /// Variance inflation due to autocorrelated residuals; 1 if they are white.
    pub residual_excess: f64,
}

/// Amplitude and phase of the steady part of a driven record.
///
/// The response is modelled as `x = Re Z e^(i phi(t)) + harmonics 2 and 3 + offset + drift`, where `phi` is the phase
/// of the drive: `omega t`, with curvature if the exciter changes its speed. The steady part begins where the phasors
/// of whole cycles no longer differ from those that follow, plus two decay times of the difference. Standard errors
/// are estimated from the scatter of these phasors if it exceeds that of white noise.
///
/// - `time_s`: increasing; `response`, `drive`: of the same length, any units
///
/// # Errors
/// [`Error::Length`] for columns of different length, [`Error::TimeBackwards`], [`Error::TooFewSamples`],
/// [`Error::Parameter`] for an option out of range, [`Error::NoSteadyMotion`] if nothing oscillates or fewer than
/// three cycles remain.
///
/// ```
/// use slipfit::signal::demodulate::{Options, demodulate};
/// let time_s: Vec<f64> = (0..2000).map(|i| 0.05 * f64::from(i)).collect();
/// let drive: Vec<f64> = time_s.iter().map(|t| (3.0 * t).cos()).collect();
/// let response: Vec<f64> = time_s
///     .iter()
///     .map(|t| 0.2 * (3.0 * t - 1.1).cos() - 0.1 * (-0.2 * t).exp() * (2.9 * t).cos())
///     .collect();
/// let steady = demodulate(&time_s, &response, Some(&drive), &Options::default())?;
/// assert!((steady.amplitude.value - 0.2).abs() < 1e-6);
/// assert!((steady.phase_rad.expect("a drive was given").value + 1.1).abs() < 1e-5);
/// assert!(steady.transient_s > 20.0);
/// # Ok::<(), slipfit::Error>(())
/// ```
pub fn demodulate(
    time_s: &[f64],
    response: &[f64],
    drive: Option<&[f64]>,
    options: &Options,
) -> Result<SteadyMotion, Error> {
    demodulate_with(time_s, response, drive, options, &Criteria::default())
}

/// [`demodulate`] with custom thresholds.
///
/// # Errors
/// As [`demodulate`].
pub fn demodulate_with(
    time_s: &[f64],
    response: &[f64],
    drive: Option<&[f64]>,
    options: &Options,
    criteria: &Criteria,
) -> Result<SteadyMotion, Error> {
    check(time_s, response, drive, options)?;
    let low = options.start_s.unwrap_or(f64::NEG_INFINITY);
    let high = options.end_s.unwrap_or(f64::INFINITY);
    let (from, to) = (time_s.partition_point(|t| *t < low), time_s.partition_point(|t| *t <= high));
    if to.saturating_sub(from) < criteria.least_samples {
        return Err(Error::TooFewSamples { found: to.saturating_sub(from), needed: criteria.least_samples });
    }
    let (time, response) = (&time_s[from..to], &response[from..to]);
    let drive = drive.map(|d| &d[from..to]).filter(|d| oscillates(d));
    let omega = frequency(time, response, drive, options, criteria)?;
    let span = |first: usize| (time[time.len() - 1] - time[first]) * omega / std::f64::consts::TAU;
    let few = |cycles| Error::NoSteadyMotion { cycles, needed: criteria.least_cycles };
    if span(0) < criteria.least_cycles {
        return Err(few(span(0)));
    }
    let settled = if options.start_s.is_some() {
        Settled::at_once()
    } else {
        settle::find(time, response, drive, omega, criteria)
    };
    let first = settled.first;
    let (time, response, drive) = (&time[first..], &response[first..], drive.map(|d| &d[first..]));
    // Without the transient the frequency can be estimated more accurately.
    let leader = drive.unwrap_or(response);
    let given = options.frequency_hz.map(|f| Sine::known(time, leader, std::f64::consts::TAU * f));
    let leading = given.unwrap_or_else(|| Sine::refined(time, leader, omega, criteria));
    let leading = leading.ok_or_else(|| few(span(first)))?;
    let law = match drive {
        Some(drive) if options.frequency_hz.is_none() => PhaseLaw::of(time, drive, leading.omega, criteria),
        _ => PhaseLaw::steady(time, leading.omega),
    };
    let omega = law.mean_omega();
    let wave = Wave::fit(time, response, &law, criteria).ok_or_else(|| few(span(first)))?;
    let driving = drive.and_then(|d| Wave::fit(time, d, &law, criteria));
    let hz = 1.0 / std::f64::consts::TAU;
    let amplitude = wave.phasor.norm();
    let phase_rad = driving.as_ref().map(|d| {
        let phase = wrap(wave.phasor.im.atan2(wave.phasor.re) - d.phasor.im.atan2(d.phasor.re));
        let relative = |w: &Wave| w.std_error / w.phasor.norm();
        Quantity::normal(phase, relative(&wave).hypot(relative(d)), "rad")
    });
    Ok(SteadyMotion {
        frequency_hz: Quantity::normal(omega * hz, leading.omega_std_error * hz, "Hz"),
        amplitude: Quantity::normal(amplitude, wave.std_error, ""),
        phase_rad,
        drive_amplitude: driving.map(|d| Quantity::normal(d.phasor.norm(), d.std_error, "")),
        start_s: time[0],
        end_s: time[time.len() - 1],
        samples: time.len(),
        cycles: span(first),
        frequency_wander_hz: law.wander() * hz,
        transient_s: if options.start_s.is_some() { 0.0 } else { time[0] - time_s[from] },
        settled: settled.settled,
        residual_rms: wave.residual_rms,
        residual_excess: wave.excess,
    })
}

fn check(time: &[f64], response: &[f64], drive: Option<&[f64]>, options: &Options) -> Result<(), Error> {
    let expected = time.len();
    for (name, found) in [("response", response.len()), ("drive", drive.map_or(expected, <[f64]>::len))] {
        if found != expected {
            return Err(Error::Length { name, found, expected });
        }
    }
    if let Some(index) = time.windows(2).position(|w| !(w[1] > w[0])) {
        return Err(Error::TimeBackwards { index: index + 1, previous: time[index], next: time[index + 1] });
    }
    let range = "the finite numbers";
    for (name, values) in [("response", response), ("drive", drive.unwrap_or_default())] {
        if let Some(&value) = values.iter().find(|v| !v.is_finite()) {
            return Err(Error::Parameter { name, value, range });
        }
    }
    match options.frequency_hz {
        Some(value) if !(value > 0.0 && value.is_finite()) => {
            Err(Error::Parameter { name: "frequency_hz", value, range: POSITIVE })
        }
        _ => Ok(()),
    }
}

fn oscillates(values: &[f64]) -> bool {
    let (low, high) = crate::numeric::extremes(values);
    high > low
}

/// First estimate of the angular frequency of the drive.
fn frequency(
    time: &[f64],
    response: &[f64],
    drive: Option<&[f64]>,
    options: &Options,
    criteria: &Criteria,
) -> Result<f64, Error> {
    use std::f64::consts::TAU;
    if let Some(frequency) = options.frequency_hz {
        return Ok(TAU * frequency);
    }
    let none = Error::NoSteadyMotion { cycles: 0.0, needed: criteria.least_cycles };
    if !oscillates(response) {
        return Err(none);
    }
    // Without a drive the end of the record is most suitable, because the transient has its own frequency.
    let half = if drive.is_some() { 0 } else { time.len() / 2 };
    let leader = drive.unwrap_or(response);
    let lines = &SpectrumCriteria::default();
    let line = spectrum::dominant(&time[half..], &leader[half..], None, lines)
        .or_else(|| spectrum::dominant(time, leader, None, lines));
    let omega = line.map(|l| TAU * l.frequency_hz).filter(|w| *w > 0.0 && w.is_finite()).ok_or(none)?;
    // A phase that drifts steadily is not a transient: the frequency must be correct first.
    Ok(Sine::refined(&time[half..], &leader[half..], omega, criteria).map_or(omega, |sine| sine.omega))
}

#[cfg(test)]
mod tests;
