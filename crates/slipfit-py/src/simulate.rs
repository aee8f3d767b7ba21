//! Exact motion.

use crate::failure::{core_error, option_error};
use crate::interrupt::interruptible;
use numpy::{IntoPyArray, PyArray1};
use pyo3::prelude::*;
use slipfit::answer::hint::Analysis;
use slipfit::motion::decay::FreeDecay;
use slipfit::motion::simulate::{Drive, Friction, Harmonic, Motion};
use slipfit::motion::steady::scan::{self, Reading};
use slipfit::motion::steady::{HarmonicDrive, solve};
use slipfit::{Error, Oscillator};
use std::f64::consts::TAU;

type Array<'py> = Bound<'py, PyArray1<f64>>;

/// More samples than any record has.
const MOST_SAMPLES: f64 = 1e9;

/// An oscillator as the core's builder takes it.
#[derive(FromPyObject)]
#[pyo3(from_item_all)]
pub(crate) struct OscillatorChoices {
    frequency_hz: Option<f64>,
    mass: Option<f64>,
    stiffness: Option<f64>,
    q_factor: Option<f64>,
    viscous_coefficient: Option<f64>,
    friction_displacement: Option<f64>,
    coulomb_force: Option<f64>,
    static_displacement: Option<f64>,
    static_force: Option<f64>,
    displacement_unit: Option<String>,
}

impl OscillatorChoices {
    fn build(self) -> Result<Oscillator, Error> {
        let mut builder = Oscillator::builder();
        macro_rules! set {
            ($($name:ident),+) => {
                $(if let Some(value) = self.$name {
                    builder = builder.$name(value);
                })+
            };
        }
        set!(frequency_hz, mass, stiffness, q_factor, viscous_coefficient, friction_displacement);
        set!(coulomb_force, static_displacement, static_force, displacement_unit);
        builder.build()
    }
}

/// Times from zero to the duration, both included.
fn times(py: Python<'_>, duration_s: f64, rate_hz: f64) -> PyResult<Vec<f64>> {
    for (name, value) in [("duration_s", duration_s), ("rate_hz", rate_hz)] {
        if !(value > 0.0 && value.is_finite()) {
            return Err(option_error(py, name, format!("{name} = {value} must be a positive number")));
        }
    }
    let rows = (duration_s * rate_hz).floor() + 1.0;
    if rows > MOST_SAMPLES {
        let message = format!("{rows:.0} samples asked for, at most {MOST_SAMPLES:.0} are made");
        return Err(option_error(py, "duration_s", message));
    }
    Ok((0..rows as u64).map(|i| i as f64 / rate_hz).collect())
}

/// Runs a simulation without the interpreter lock.
fn simulated<T: Send + 'static>(
    py: Python<'_>,
    work: impl FnOnce() -> Result<T, Error> + Send + 'static,
) -> PyResult<T> {
    interruptible(py, work)?.map_err(|error| core_error(py, Analysis::Ringdown, &error))
}

/// Samples of a free decay, released at rest.
#[pyfunction]
pub(crate) fn decay<'py>(
    py: Python<'py>,
    oscillator: OscillatorChoices,
    amplitude: f64,
    duration_s: f64,
    rate_hz: f64,
) -> PyResult<(Array<'py>, Array<'py>)> {
    let time_s = times(py, duration_s, rate_hz)?;
    let (time_s, signal) = simulated(py, move || {
        let decay = FreeDecay::from_rest(&oscillator.build()?, amplitude)?;
        let signal: Vec<f64> = time_s.iter().map(|&t| decay.displacement(t)).collect();
        Ok((time_s, signal))
    })?;
    Ok((time_s.into_pyarray(py), signal.into_pyarray(py)))
}

/// A harmonic of a drive: amplitude, frequency [Hz] or that of the oscillator, and phase ahead of a cosine [rad].
type HarmonicChoice = (f64, Option<f64>, f64);

/// Samples of the motion under a drive of harmonics; steady motion is that under the first one.
#[pyfunction]
pub(crate) fn driven<'py>(
    py: Python<'py>,
    oscillator: OscillatorChoices,
    harmonics: Vec<HarmonicChoice>,
    duration_s: f64,
    rate_hz: f64,
    steady: bool,
    drive_off_s: Option<f64>,
) -> PyResult<(Array<'py>, Array<'py>)> {
    let time_s = times(py, duration_s, rate_hz)?;
    let (time_s, signal) = simulated(py, move || {
        let oscillator = oscillator.build()?;
        let harmonic = |(amplitude, hz, phase): HarmonicChoice| Harmonic {
            amplitude,
            omega: TAU * hz.unwrap_or(oscillator.frequency_hz()),
            phase,
        };
        let harmonics: Vec<Harmonic> = harmonics.into_iter().map(harmonic).collect();
        let (position, velocity) = match harmonics.first() {
            Some(first) if steady => {
                solve(&oscillator, &HarmonicDrive::new(first.amplitude, first.omega)?)?.state.state(0.0)
            }
            _ => (0.0, 0.0),
        };
        let mut drive = Drive::harmonics(0.0, &harmonics)?;
        drive.check_sampling(rate_hz)?;
        if let Some(off_s) = drive_off_s {
            drive = drive.until(off_s)?;
        }
        let mut motion = Motion::new(&oscillator, drive, 0.0, position, velocity)?;
        let mut signal = vec![0.0; time_s.len()];
        motion.fill(&time_s, &mut signal)?;
        Ok((time_s, signal))
    })?;
    Ok((time_s.into_pyarray(py), signal.into_pyarray(py)))
}

/// Amplitude and phase of the fundamental at each drive amplitude and frequency [Hz], or that of the oscillator.
#[pyfunction]
pub(crate) fn readings<'py>(
    py: Python<'py>,
    oscillator: OscillatorChoices,
    steps: Vec<(f64, Option<f64>)>,
    wait_s: Option<f64>,
) -> PyResult<(Array<'py>, Array<'py>)> {
    let readings: Vec<Reading> = simulated(py, move || {
        let oscillator = oscillator.build()?;
        let steps = steps.into_iter().map(|(x_0, hz)| (x_0, hz.unwrap_or(oscillator.frequency_hz())));
        match wait_s {
            Some(wait_s) => {
                let steps: Vec<_> = steps.collect();
                scan::stepped(&oscillator, Friction::of(&oscillator), &steps, wait_s)
            }
            None => steps.map(|(x_0, hz)| scan::reading(&oscillator, x_0, hz)).collect(),
        }
    })?;
    let column = |of: fn(&Reading) -> f64| readings.iter().map(of).collect::<Vec<_>>().into_pyarray(py);
    // A mass at rest has no phase.
    let phase_rad = |r: &Reading| r.phase_rad().unwrap_or(f64::NAN);
    Ok((column(Reading::amplitude), column(phase_rad)))
}
