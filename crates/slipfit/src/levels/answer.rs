//! The answer to a series of drive levels.

use crate::Quantity;
use crate::answer::{Parameter, Parameters};
use std::fmt;

/// One level beside the fit.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct LevelPoint {
    /// Index in the order of measurement.
    pub index: usize,
    /// Drive level, drive unit.
    pub drive: f64,
    /// Measured amplitude, response unit.
    pub amplitude: f64,
    /// Its standard error.
    pub std_error: f64,
    /// Fitted amplitude.
    pub fitted: f64,
    /// Whether the mass moves there, by the fit.
    pub moving: bool,
}

/// Where the mass breaks loose: between these drive levels, drive unit.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Breakaway {
    /// Highest level at which it was seen stuck; `None` where none was.
    pub stuck_below: Option<f64>,
    /// Lowest level at which it was seen moving.
    pub moving_from: f64,
    /// Highest level above the threshold of the moving branch at which it stuck.
    pub stuck_above_threshold: Option<f64>,
    /// Static over sliding friction, at least, where it stuck above the threshold `x_T`: at rest
    /// the spring pulls with `k x_0 <= F_s`, while `F = (pi/4) k x_T`.
    pub static_ratio_at_least: Option<f64>,
}

/// How well the line describes the points.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Diagnostics {
    /// Points used.
    pub points: usize,
    /// Points on the moving branch.
    pub moving: usize,
    /// Points on the stuck branch.
    pub stuck: usize,
    /// Residual over the moving branch, response unit (weighted where errors are known).
    pub residual_rms: f64,
    /// p value of a bend (drag, hardening) in the moving branch.
    pub bend_p_value: f64,
}

/// A doubt about an answer.
#[derive(Debug, Clone, PartialEq)]
#[non_exhaustive]
pub enum Warning {
    /// No level lies below the threshold: it is extrapolated.
    ThresholdExtrapolated {
        /// Lowest level over the threshold.
        ratio: f64,
    },
    /// The moving branch is bent: drag or a nonlinear spring besides.
    Bent {
        /// p value of a straight line.
        p_value: f64,
        /// Whether the slope falls with the amplitude.
        falling: bool,
    },
    /// Drive and amplitude have different units: no Q and no friction displacement.
    DriveUncalibrated,
    /// Levels at which the mass stuck lie above those at which it moved.
    Hysteresis {
        /// Highest stuck level.
        stuck_at: f64,
        /// Lowest moving level.
        moving_at: f64,
    },
    /// Points left out because a value is no number.
    Dropped {
        /// How many.
        points: usize,
    },
}

impl Warning {
    /// Machine-readable code, as in the JSON answer.
    pub fn code(&self) -> &'static str {
        match self {
            Warning::ThresholdExtrapolated { .. } => "threshold_extrapolated",
            Warning::Bent { .. } => "bent",
            Warning::DriveUncalibrated => "drive_uncalibrated",
            Warning::Hysteresis { .. } => "hysteresis",
            Warning::Dropped { .. } => "dropped",
        }
    }
}

impl fmt::Display for Warning {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Warning::ThresholdExtrapolated { ratio } => write!(
                f,
                "every level lies above the threshold (the lowest {ratio:.1} times): it is extrapolated along the \
                 line; lower levels would show it"
            ),
            Warning::Bent { p_value, falling } => write!(
                f,
                "the moving branch is bent ({}): {}",
                crate::answer::p_value(*p_value),
                if *falling {
                    "the slope falls with the drive, as drag or a detuned hardening spring make it"
                } else {
                    "the slope rises with the drive; friction may weaken with speed"
                }
            ),
            Warning::DriveUncalibrated => f.write_str(
                "drive levels have a unit of their own: the threshold is given in it; --drive-gain or --q gives Q \
                 and the friction displacement",
            ),
            Warning::Hysteresis { stuck_at, moving_at } => write!(
                f,
                "stuck at {stuck_at:.4e}, moving at {moving_at:.4e}: static friction above kinetic, or a level not \
                 waited out"
            ),
            Warning::Dropped { points } => write!(f, "{points} points that are no number were left out"),
        }
    }
}

/// The fitted line with its threshold.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct FittedLevels {
    pub(crate) slope: f64,
    pub(crate) threshold: f64,
}

impl FittedLevels {
    /// Fitted amplitude at a drive level: `slope (drive - threshold)`, zero below.
    pub fn amplitude(&self, drive: f64) -> f64 {
        (self.slope * (drive - self.threshold)).max(0.0)
    }

    /// The same without friction: the line through zero.
    pub fn friction_free(&self, drive: f64) -> f64 {
        self.slope * drive
    }
}

/// Everything [`analyse`](super::analyse) found out.
#[derive(Debug, Clone, PartialEq)]
#[non_exhaustive]
pub struct Answer {
    /// Parameters by name: `slope`, `threshold`, and, where the drive is calibrated,
    /// `q_factor`, `friction_displacement`, `decay_rate_per_s`, forces.
    pub parameters: Parameters,
    /// p value of the threshold: no sliding friction would do as well. One-sided.
    pub p_value: f64,
    /// Whether a threshold is seen (`p_value` below 0.01).
    pub detected: bool,
    /// Correlation of slope and threshold.
    pub correlation: f64,
    /// Where the mass breaks loose.
    pub breakaway: Option<Breakaway>,
    /// The points beside the fit, by rising drive.
    pub points: Vec<LevelPoint>,
    /// Quality of the description.
    pub diagnostics: Diagnostics,
    /// Doubts.
    pub warnings: Vec<Warning>,
    /// Unit of the amplitudes.
    pub unit: String,
    /// Unit of the drive levels.
    pub drive_unit: String,
    /// The fitted line.
    pub fit: FittedLevels,
}

impl Answer {
    /// The value of a parameter, if the analysis reports it.
    pub fn parameter(&self, parameter: Parameter) -> Option<&Quantity> {
        self.parameters.get(parameter)
    }
}
