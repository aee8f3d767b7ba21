//! Options fixed by the user, for the JSON answer; null was left to the analysis.

use super::object::object;
use serde::Serialize;
use slipfit::resonance::Method;
use slipfit::ringdown::LawOption;
use slipfit::{Calibration, LossModel, levels, resonance, ringdown};

object! {
    /// Options of a ring-down.
    pub(super) struct RecordOptions of options: &ringdown::Options {
        /// First time to use.
        start_s: Option<f64> = options.start_s,
        /// Last time to use.
        end_s: Option<f64> = options.end_s,
        /// Amplitude below which the record is not used, in the unit of the signal.
        min_amplitude: Option<f64> = options.min_amplitude,
        /// Lowest and highest frequency to use.
        band_hz: Option<[f64; 2]> = options.band_hz,
        /// Loss model to report.
        model: Option<LossModel> = options.model,
        /// Model-free loss law drawn in addition.
        law: Option<LawOption> = options.law,
        /// Time constant of the lock-in's low-pass filter.
        lockin_time_constant_s: Option<f64> = options.lockin.map(|l| l.time_constant_s),
        /// Order of that filter.
        lockin_order: Option<u32> = options.lockin.map(|l| l.order),
        /// Frequency of the oscillation.
        frequency_hz: Option<f64> = options.frequency_hz,
        /// The constant that turns displacements into forces.
        calibration: Option<Constant> = options.calibration.and_then(Constant::new),
    }
}

object! {
    /// Options of a resonance curve.
    pub(super) struct CurveOptions of options: &resonance::Options {
        /// Lowest and highest frequency to use.
        band_hz: Option<[f64; 2]> = options.band_hz,
        /// How the response is computed.
        method: Method = options.method,
        /// Loss model to report.
        model: Option<LossModel> = options.model,
        /// The drive amplitude, if it is known independently.
        drive_amplitude: Option<DriveAmplitude> = options.drive_amplitude.map(DriveAmplitude::new),
        /// Whether a complex background is fitted.
        background: Option<bool> = options.terms.background,
        /// Whether a delay is fitted.
        delay: Option<bool> = options.terms.delay,
        /// Whether a constant offset of every amplitude is fitted.
        amplitude_offset: Option<bool> = options.terms.amplitude_offset,
        /// Whether a noise floor added in quadrature is fitted.
        noise_floor: Option<bool> = options.terms.noise_floor,
        /// Whether a phase offset is fitted.
        phase_offset: Option<bool> = options.terms.phase_offset,
        /// Whether an amplitude-dependent frequency is fitted.
        duffing: Option<bool> = options.terms.duffing,
        /// The constant that turns displacements into forces.
        calibration: Option<Constant> = options.calibration.and_then(Constant::new),
    }
}

object! {
    /// The drive amplitude, if it is known independently.
    struct DriveAmplitude of drive: resonance::DriveAmplitude {
        /// Its value.
        value: f64 = drive.value,
        /// Its standard error; zero if exact.
        std_error: f64 = drive.std_error,
    }
}

object! {
    /// Options of drive levels.
    pub(super) struct LevelsOptions of options: &levels::Options {
        /// Frequency of the oscillation.
        frequency_hz: Option<f64> = options.frequency_hz,
        /// Drive amplitude per unit of the drive level, and its standard error.
        drive_gain: Option<[f64; 2]> = options.drive_gain,
        /// Quality factor of the viscous loss, and its standard error.
        q_factor: Option<[f64; 2]> = options.q_factor,
        /// The constant that turns displacements into forces.
        calibration: Option<Constant> = options.calibration.and_then(Constant::new),
    }
}

/// The constant that turns displacements into forces.
#[derive(Serialize)]
#[cfg_attr(test, derive(schemars::JsonSchema))]
pub(super) struct Constant {
    /// Stiffness (N/m, N m/rad) or mass (kg, kg m²).
    #[cfg_attr(test, schemars(extend("enum" = ["stiffness", "mass"])))]
    kind: &'static str,
    /// Its value.
    value: f64,
    /// Its standard error; zero if exact.
    std_error: f64,
}

impl Constant {
    pub(super) fn new(calibration: Calibration) -> Option<Self> {
        match calibration {
            Calibration::Stiffness { value, std_error } => Some(Self { kind: "stiffness", value, std_error }),
            Calibration::Mass { value, std_error } => Some(Self { kind: "mass", value, std_error }),
            _ => None,
        }
    }
}
