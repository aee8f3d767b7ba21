//! The answer to a series.

use super::law::LawFit;
use crate::answer::{Parameter, Parameters, Warning};
use crate::{Error, Quantity, levels, resonance, ringdown};

/// One measurement alone.
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

    /// Correlation of two losses, limits lifted.
    pub(super) fn correlation(&self, a: Parameter, b: Parameter) -> Option<f64> {
        match self {
            SingleAnswer::RingDown(answer) => answer.correlation(a, b),
            SingleAnswer::Sweep(answer) => answer.correlation(a, b),
            // They have viscous damping and sliding friction alone.
            SingleAnswer::Levels(answer) => Some(answer.loss_correlation),
        }
    }

    /// Standard error of a loss, limits lifted, of the fit that has the correlations.
    pub(super) fn own_error(&self, parameter: Parameter) -> Option<f64> {
        match self {
            SingleAnswer::Sweep(answer) => answer.error_given_terms(parameter),
            SingleAnswer::RingDown(answer) => answer.unbounded_error(parameter),
            SingleAnswer::Levels(_) => None,
        }
    }
}

/// Estimate of friction and damping by one kind of experiment.
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
    /// Two-sided p value of it.
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
    /// Do the frictions agree?
    #[cfg_attr(feature = "serde", serde(rename = "friction_agreement"))]
    pub friction: Option<Consistency>,
    /// Do the dampings agree?
    #[cfg_attr(feature = "serde", serde(rename = "damping_agreement"))]
    pub damping: Option<Consistency>,
    /// p value of both together, their correlations counted.
    pub p_value: Option<f64>,
    /// All measurements of this condition fitted jointly.
    pub joint: Option<Estimate>,
}

/// The joint fit of all measurements with the shared parameters.
#[derive(Debug, Clone, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize))]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
pub struct Joint {
    /// Natural frequency, Hz, where shared.
    pub natural_frequency_hz: Option<Quantity>,
    /// Drive amplitude where shared.
    pub drive_amplitude: Option<Quantity>,
    /// Decay rate where shared, 1/s.
    pub decay_rate_per_s: Option<Quantity>,
    /// Chi square of the single answers about the joint ones.
    pub chi_square: f64,
    /// Its degrees of freedom.
    pub degrees_of_freedom: usize,
    /// p value of it: small means that they do not share what they were said to.
    pub p_value: f64,
}

/// How repeats at one condition scatter beyond their errors.
#[derive(Debug, Clone, Copy, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize))]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
pub struct RepeatScatter {
    /// Standard deviation of friction over its value, of all conditions.
    pub friction: f64,
    /// Standard deviation of damping over its value.
    pub damping: f64,
    /// Measurements beyond the first of each condition, which tell it.
    pub repeats: usize,
}

/// Everything [`analyse`](super::analyse) found out.
#[derive(Debug, Clone, PartialEq)]
#[non_exhaustive]
pub struct Answer {
    /// Each measurement alone, in the order given, with its name.
    pub singles: Vec<(String, Result<SingleAnswer, Error>)>,
    /// The paper's Table 1 for these data.
    pub table: Vec<ConditionRow>,
    /// p value that ring-down and resonance agree at every condition.
    pub agreement_p_value: Option<f64>,
    /// Whether they agree by it.
    pub agrees: Option<bool>,
    /// How repeats scatter, which counts in the errors; `None` without repeats, or where their errors explain it.
    pub scatter: Option<RepeatScatter>,
    /// Everything fitted jointly.
    pub joint: Option<Joint>,
    /// Friction against load, laws compared, best first; empty without numeric conditions.
    pub laws: Vec<LawFit>,
    /// What limits the answer.
    pub warnings: Vec<Warning>,
}

impl Answer {
    /// Whether sliding friction is seen at any condition.
    pub fn has_friction(&self) -> bool {
        self.table.iter().filter_map(|r| r.joint.as_ref()).any(|c| c.friction.interval_95[0] > 0.0)
    }

    /// Whether any condition was measured by ring-down, and any by resonance.
    pub fn methods(&self) -> [bool; 2] {
        [self.table.iter().any(|r| r.ring_down.is_some()), self.table.iter().any(|r| r.resonance.is_some())]
    }
}
