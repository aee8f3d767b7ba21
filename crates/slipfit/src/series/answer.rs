//! The answer to a series.

use super::law::LawFit;
use crate::answer::{Parameter, Parameters, Warning};
use crate::{Error, Quantity, levels, resonance, ringdown};

/// The answer for a single measurement.
#[derive(Debug, Clone, PartialEq)]
#[non_exhaustive]
pub enum SingleAnswer {
    /// A ring-down.
    RingDown(Box<ringdown::Answer>),
    /// A resonance curve.
    Sweep(Box<resonance::Answer>),
    /// Drive levels.
    Levels(Box<levels::Answer>),
}

impl SingleAnswer {
    /// The parameters of its answer.
    pub fn parameters(&self) -> &Parameters {
        match self {
            SingleAnswer::RingDown(a) => &a.parameters,
            SingleAnswer::Sweep(a) => &a.parameters,
            SingleAnswer::Levels(a) => &a.parameters,
        }
    }

    /// Correlation of two losses, without limits.
    pub(super) fn correlation(&self, a: Parameter, b: Parameter) -> Option<f64> {
        match self {
            SingleAnswer::RingDown(answer) => answer.correlation(a, b),
            SingleAnswer::Sweep(answer) => answer.correlation(a, b),
            // Levels have viscous damping and sliding friction only.
            SingleAnswer::Levels(answer) => Some(answer.loss_correlation),
        }
    }

    /// Standard error of a loss, without limits, from the fit that has the correlations.
    pub(super) fn own_error(&self, parameter: Parameter) -> Option<f64> {
        match self {
            SingleAnswer::Sweep(answer) => answer.error_given_terms(parameter),
            SingleAnswer::RingDown(answer) => answer.unbounded_error(parameter),
            SingleAnswer::Levels(_) => None,
        }
    }
}

/// Estimate of friction and damping by one method.
#[derive(Debug, Clone, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize))]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
pub struct Estimate {
    /// Friction: x_F, or F with a calibration.
    pub friction: Quantity,
    /// Damping: delta in 1/s, or gamma with a calibration.
    pub damping: Quantity,
    /// Correlation of the two.
    pub correlation: f64,
}

/// Two estimates of one quantity, compared.
#[derive(Debug, Clone, Copy, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize))]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
pub struct Consistency {
    /// Difference over its standard error.
    pub z: f64,
    /// Two-sided p value.
    pub p_value: f64,
}

/// One condition: a row of the paper's Table 1.
#[derive(Debug, Clone, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize))]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
pub struct ConditionRow {
    /// Label of the condition.
    pub condition: String,
    /// Its value with standard error.
    #[cfg_attr(
        feature = "serde",
        serde(flatten, serialize_with = "crate::answer::serialise::condition_value")
    )]
    #[cfg_attr(feature = "schema", schemars(with = "crate::answer::serialise::ConditionValue"))]
    pub value: Option<[f64; 2]>,
    /// By ring-down (all ring-downs of this condition together).
    #[cfg_attr(feature = "serde", serde(rename = "ringdown"))]
    pub ring_down: Option<Estimate>,
    /// By resonance (sweeps and levels together).
    pub resonance: Option<Estimate>,
    /// Agreement of the friction of both methods.
    #[cfg_attr(feature = "serde", serde(rename = "friction_agreement"))]
    pub friction: Option<Consistency>,
    /// Agreement of the damping of both methods.
    #[cfg_attr(feature = "serde", serde(rename = "damping_agreement"))]
    pub damping: Option<Consistency>,
    /// p value of both together, including their correlations.
    pub p_value: Option<f64>,
    /// All measurements of this condition fitted jointly.
    pub joint: Option<Estimate>,
}

/// The joint fit of all measurements with the shared parameters.
#[derive(Debug, Clone, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize))]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
pub struct Joint {
    /// Natural frequency, Hz, if shared.
    pub natural_frequency_hz: Option<Quantity>,
    /// Drive amplitude, if shared.
    pub drive_amplitude: Option<Quantity>,
    /// Decay rate, 1/s, if shared.
    pub decay_rate_per_s: Option<Quantity>,
    /// Chi square of the single answers about the joint ones.
    pub chi_square: f64,
    /// Its degrees of freedom.
    pub degrees_of_freedom: usize,
    /// Its p value: a small value means that the measurements do not share the parameters declared as shared.
    pub p_value: f64,
}

/// Scatter of repeats at one condition beyond their errors.
#[derive(Debug, Clone, Copy, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize))]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
pub struct RepeatScatter {
    /// Standard deviation of friction over its value, common to all conditions.
    pub friction: f64,
    /// Standard deviation of damping over its value.
    pub damping: f64,
    /// Number of measurements beyond the first of each condition, from which the scatter is estimated.
    pub repeats: usize,
}

/// The complete result of [`analyse`](super::analyse).
#[derive(Debug, Clone, PartialEq)]
#[non_exhaustive]
pub struct Answer {
    /// Each measurement alone, in the order given, with its name.
    pub singles: Vec<(String, Result<SingleAnswer, Error>)>,
    /// The paper's Table 1 for these data.
    pub table: Vec<ConditionRow>,
    /// p value of the agreement of ring-down and resonance at every condition.
    pub agreement_p_value: Option<f64>,
    /// Whether they agree according to this p value.
    pub agrees: Option<bool>,
    /// Scatter of repeats, which is included in the errors; `None` without repeats, or if their errors explain it.
    pub scatter: Option<RepeatScatter>,
    /// The joint fit.
    pub joint: Option<Joint>,
    /// Laws of friction against load, compared, best first; empty without numeric conditions.
    pub laws: Vec<LawFit>,
    /// Limitations of the answer.
    pub warnings: Vec<Warning>,
}

impl Answer {
    /// Whether sliding friction is detected at any condition.
    pub fn has_friction(&self) -> bool {
        self.table.iter().filter_map(|r| r.joint.as_ref()).any(|c| c.friction.interval_95[0] > 0.0)
    }

    /// Whether any condition was measured by ring-down, and any by resonance.
    pub fn methods(&self) -> [bool; 2] {
        [self.table.iter().any(|r| r.ring_down.is_some()), self.table.iter().any(|r| r.resonance.is_some())]
    }
}
