//! The answer to a series of drive levels.

use super::curve::Growth;
use super::level_row::exact_row;
use crate::Quantity;
use crate::answer::columns::columns;
use crate::answer::{Parameter, Parameters, Warning};
use crate::inference::Z_95;

/// One level with its fitted amplitude.
#[derive(Debug, Clone, Copy, PartialEq)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
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
    /// Whether the mass moves at this level according to the fit.
    pub moving: bool,
}

/// Drive levels between which the mass breaks loose, drive unit.
#[derive(Debug, Clone, Copy, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize))]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
pub struct Breakaway {
    /// Highest level at which the mass stuck; `None` if it never did.
    pub stuck_below: Option<f64>,
    /// Lowest level at which the mass moved.
    pub moving_from: f64,
    /// Highest level above the threshold of the moving branch at which the mass stuck.
    pub stuck_above_threshold: Option<f64>,
    /// Lower limit of the ratio of static to sliding friction if the mass stuck above the threshold `x_T`: at rest the
    /// spring pulls with `k x_0 <= F_s`, while `F = (pi/4) k x_T`.
    pub static_ratio_at_least: Option<f64>,
}

/// Quality of the fit of the line to the points.
#[derive(Debug, Clone, Copy, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize))]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
pub struct Diagnostics {
    /// Points used.
    pub points: usize,
    /// Points on the moving branch.
    pub moving: usize,
    /// Points on the stuck branch.
    pub stuck: usize,
    /// Points close to the threshold that may stick or move and whose reading does not decide.
    pub undecided: usize,
    /// Root mean square of the residuals of the moving branch, response unit (weighted if errors are known).
    pub residual_rms: f64,
    /// p value of a bend (drag, hardening) in the moving branch.
    pub bend_p_value: f64,
}

/// Reading of the detector without motion.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub(crate) struct Detector {
    pub(crate) at_rest: f64,
    /// Whether it adds in quadrature; otherwise it is a constant.
    pub(crate) squares: bool,
}

impl Detector {
    fn reading(self, amplitude: f64) -> f64 {
        if self.squares { amplitude.hypot(self.at_rest) } else { amplitude + self.at_rest }
    }
}

/// The fitted line, or curve, with its threshold.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct FittedLevels {
    pub(crate) slope: f64,
    pub(crate) threshold: f64,
    /// Q of the exact motion; `None` for the line itself.
    pub(crate) exact_q: Option<f64>,
    /// `c` of `y + c y² = slope (drive - threshold)`, or of `y + c y³`; zero for a line.
    pub(crate) bend: f64,
    pub(crate) growth: Growth,
    pub(crate) detector: Detector,
}

impl FittedLevels {
    /// Fitted amplitude `y` at a drive level, as read by the detector: `slope (drive - threshold)`, or with a bend `c`
    /// the solution of `y + c y² = slope (drive - threshold)` or of `y + c y³`; zero motion below the threshold. If Q
    /// is known, the amplitude of the exact motion replaces that of the line.
    pub fn amplitude(&self, drive: f64) -> f64 {
        let line = [-self.slope * self.threshold, self.slope];
        let exact = self.exact_q.and_then(|q| exact_row(line, q, drive));
        self.read(exact.map_or(self.slope * (drive - self.threshold), |row| row.amplitude(line)))
    }

    /// The same without friction, i.e. with zero threshold.
    pub fn friction_free(&self, drive: f64) -> f64 {
        self.read(self.slope * drive)
    }

    fn read(&self, line: f64) -> f64 {
        let line = line.max(0.0);
        // A curve of increasing slope ends where its slope becomes infinite.
        let [amplitude, _] = self.growth.on_curve(line, self.bend).unwrap_or([2.0 * line, f64::INFINITY]);
        self.detector.reading(amplitude)
    }
}

columns! {
    level_columns of crate::levels::LevelPoint {
        drive: f64, amplitude: f64, std_error: f64, fitted: f64, moving: bool,
    }
}

/// Complete result of [`analyse`](super::analyse).
#[derive(Debug, Clone, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize))]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
#[non_exhaustive]
pub struct Answer {
    /// Parameters by name: `slope`, `threshold`, and, if the drive is calibrated, `q_factor`, `friction_displacement`,
    /// `decay_rate_per_s`, forces.
    pub parameters: Parameters,
    /// p value of the threshold, i.e. of the line without sliding friction. One-sided.
    pub p_value: f64,
    /// Whether a threshold is detected (`p_value` below 0.01).
    pub detected: bool,
    /// Correlation of slope and threshold.
    pub correlation: f64,
    /// Correlation of decay rate and friction displacement; zero if they are not reported.
    #[cfg_attr(feature = "serde", serde(skip))]
    pub(crate) loss_correlation: f64,
    /// Drive levels at which the mass breaks loose.
    pub breakaway: Option<Breakaway>,
    /// The points with their fitted amplitudes, in order of increasing drive.
    #[cfg_attr(feature = "serde", serde(rename = "levels", serialize_with = "level_columns::serialize"))]
    #[cfg_attr(feature = "schema", schemars(with = "level_columns::Columns"))]
    pub points: Vec<LevelPoint>,
    /// Quality of the fit.
    pub diagnostics: Diagnostics,
    /// What limits the validity of the answer.
    pub warnings: Vec<Warning>,
    /// Unit of the amplitudes.
    #[cfg_attr(feature = "serde", serde(skip))]
    pub unit: String,
    /// Unit of the drive levels.
    #[cfg_attr(feature = "serde", serde(skip))]
    pub drive_unit: String,
    /// Frequency of the resonance, Hz, if given.
    #[cfg_attr(feature = "serde", serde(skip))]
    pub(crate) frequency_hz: Option<f64>,
    /// The fitted line.
    #[cfg_attr(feature = "serde", serde(skip))]
    pub fit: FittedLevels,
}

impl Answer {
    /// Factor by which few residuals widen an interval: half width by Student's t over that of the normal distribution.
    pub(crate) fn student_factor(&self) -> f64 {
        let of_slope = self.parameters.get(Parameter::Slope).map(|q| {
            let [low, high] = q.interval_95;
            (high - low) / (2.0 * Z_95 * q.std_error)
        });
        of_slope.filter(|f| f.is_finite()).unwrap_or(1.0).max(1.0)
    }

    /// The value of a parameter, if the analysis reports it.
    pub fn parameter(&self, parameter: Parameter) -> Option<&Quantity> {
        self.parameters.get(parameter)
    }
}
