//! What the person fixed, for the JSON answer; null was left to the analysis.

use serde::Serialize;
use slipfit::resonance::Method;
use slipfit::{Calibration, LossModel, levels, resonance, ringdown};

/// Options of a ring-down.
#[derive(Serialize)]
#[cfg_attr(test, derive(schemars::JsonSchema))]
pub(super) struct RecordOptions {
    /// First instant to use.
    start_s: Option<f64>,
    /// Last instant to use.
    end_s: Option<f64>,
    /// Amplitude below which nothing is used, unit of the signal.
    min_amplitude: Option<f64>,
    /// Lowest and highest frequency to use.
    band_hz: Option<[f64; 2]>,
    /// Loss model to report.
    model: Option<LossModel>,
    /// Time constant of the low-pass of the lock-in.
    lockin_time_constant_s: Option<f64>,
    /// Order of that low-pass.
    lockin_order: Option<u32>,
    /// Frequency of the oscillation.
    frequency_hz: Option<f64>,
    /// The constant that turns displacements into forces.
    calibration: Option<Constant>,
}

impl RecordOptions {
    pub(super) fn new(options: &ringdown::Options) -> Self {
        Self {
            start_s: options.start_s,
            end_s: options.end_s,
            min_amplitude: options.min_amplitude,
            band_hz: options.band_hz,
            model: options.model,
            lockin_time_constant_s: options.lockin.map(|l| l.time_constant_s),
            lockin_order: options.lockin.map(|l| l.order),
            frequency_hz: options.frequency_hz,
            calibration: options.calibration.and_then(Constant::new),
        }
    }
}

/// Options of a resonance curve.
#[derive(Serialize)]
#[cfg_attr(test, derive(schemars::JsonSchema))]
pub(super) struct CurveOptions {
    /// Lowest and highest frequency to use.
    band_hz: Option<[f64; 2]>,
    /// How the response is computed.
    method: Method,
    /// Loss model to report.
    model: Option<LossModel>,
    /// The drive amplitude as known from elsewhere.
    drive_amplitude: Option<DriveAmplitude>,
    /// Whether a complex background is fitted.
    background: Option<bool>,
    /// Whether a delay is fitted.
    delay: Option<bool>,
    /// Whether a phase offset is fitted.
    phase_offset: Option<bool>,
    /// Whether a frequency that depends on the amplitude is fitted.
    duffing: Option<bool>,
    /// The constant that turns displacements into forces.
    calibration: Option<Constant>,
}

/// The drive amplitude as known from elsewhere.
#[derive(Serialize)]
#[cfg_attr(test, derive(schemars::JsonSchema))]
struct DriveAmplitude {
    /// Its value.
    value: f64,
    /// Its standard error; zero when exact.
    std_error: f64,
}

impl CurveOptions {
    pub(super) fn new(options: &resonance::Options) -> Self {
        let drive = |d: resonance::DriveAmplitude| DriveAmplitude { value: d.value, std_error: d.std_error };
        Self {
            band_hz: options.band_hz,
            method: options.method,
            model: options.model,
            drive_amplitude: options.drive_amplitude.map(drive),
            background: options.terms.background,
            delay: options.terms.delay,
            phase_offset: options.terms.phase_offset,
            duffing: options.terms.duffing,
            calibration: options.calibration.and_then(Constant::new),
        }
    }
}

/// Options of drive levels.
#[derive(Serialize)]
#[cfg_attr(test, derive(schemars::JsonSchema))]
pub(super) struct LevelsOptions {
    /// Frequency of the oscillation.
    frequency_hz: Option<f64>,
    /// Drive amplitude for one unit of the drive level, and its standard error.
    drive_gain: Option<[f64; 2]>,
    /// Quality factor of the viscous loss, and its standard error.
    q_factor: Option<[f64; 2]>,
    /// The constant that turns displacements into forces.
    calibration: Option<Constant>,
}

impl LevelsOptions {
    pub(super) fn new(options: &levels::Options) -> Self {
        Self {
            frequency_hz: options.frequency_hz,
            drive_gain: options.drive_gain,
            q_factor: options.q_factor,
            calibration: options.calibration.and_then(Constant::new),
        }
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
    /// Its standard error; zero when exact.
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
