//! What the person fixed, for the JSON answer; null was left to the analysis.

use serde::Serialize;
use slipfit::resonance::Method;
use slipfit::{Calibration, LossModel, levels, resonance, ringdown};

/// Options of a ring-down.
#[derive(Serialize)]
pub(super) struct RecordOptions {
    start_s: Option<f64>,
    end_s: Option<f64>,
    min_amplitude: Option<f64>,
    band_hz: Option<[f64; 2]>,
    model: Option<LossModel>,
    lockin_time_constant_s: Option<f64>,
    lockin_order: Option<u32>,
    frequency_hz: Option<f64>,
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
pub(super) struct CurveOptions {
    band_hz: Option<[f64; 2]>,
    method: Method,
    model: Option<LossModel>,
    drive_amplitude: Option<DriveAmplitude>,
    background: Option<bool>,
    delay: Option<bool>,
    phase_offset: Option<bool>,
    duffing: Option<bool>,
    calibration: Option<Constant>,
}

/// The drive amplitude as known from elsewhere.
#[derive(Serialize)]
struct DriveAmplitude {
    value: f64,
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
pub(super) struct LevelsOptions {
    frequency_hz: Option<f64>,
    drive_gain: Option<[f64; 2]>,
    q_factor: Option<[f64; 2]>,
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
pub(super) struct Constant {
    /// Stiffness (N/m, N m/rad) or mass (kg, kg m²).
    kind: &'static str,
    value: f64,
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
