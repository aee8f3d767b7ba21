//! The answer to a series.

use super::law::LawFit;
use crate::answer::Parameters;
use crate::{Error, Quantity, levels, resonance, ringdown};
use std::fmt;

/// One measurement alone.
#[derive(Debug, Clone, PartialEq)]
#[non_exhaustive]
pub enum Solo {
    /// A ring-down.
    RingDown(Box<ringdown::Answer>),
    /// A resonance curve.
    Sweep(Box<resonance::Answer>),
    /// Drive levels.
    Levels(Box<levels::Answer>),
}

impl Solo {
    /// The parameters of its answer.
    pub fn parameters(&self) -> &Parameters {
        match self {
            Solo::RingDown(a) => &a.parameters,
            Solo::Sweep(a) => &a.parameters,
            Solo::Levels(a) => &a.parameters,
        }
    }
}

/// Estimate of friction and damping by one kind of experiment.
#[derive(Debug, Clone, PartialEq)]
pub struct Cell {
    /// Friction: x_F, or F with a calibration.
    pub friction: Quantity,
    /// Damping: delta in 1/s, or gamma with a calibration.
    pub damping: Quantity,
    /// Correlation of the two.
    pub correlation: f64,
}

/// Two estimates of one quantity, compared.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Pair {
    /// Difference over its standard error.
    pub z: f64,
    /// Two-sided p value of it.
    pub p_value: f64,
}

/// One condition: a row of the paper's Table 1.
#[derive(Debug, Clone, PartialEq)]
pub struct Row {
    /// Label of the condition.
    pub condition: String,
    /// Its value with standard error.
    pub value: Option<[f64; 2]>,
    /// By ring-down (all ring-downs of this condition together).
    pub ring_down: Option<Cell>,
    /// By resonance (sweeps and levels together).
    pub resonance: Option<Cell>,
    /// Do the frictions agree?
    pub friction: Option<Pair>,
    /// Do the dampings agree?
    pub damping: Option<Pair>,
    /// p value of both together, their correlations counted.
    pub p_value: Option<f64>,
    /// All measurements of this condition fitted jointly.
    pub joint: Option<Cell>,
}

/// The joint fit of all measurements with the shared parameters.
#[derive(Debug, Clone, PartialEq)]
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

/// A doubt about a series.
#[derive(Debug, Clone, PartialEq)]
#[non_exhaustive]
pub enum Warning {
    /// Two ways disagree at one condition.
    Disagree {
        /// The condition.
        condition: String,
        /// p value of their agreement.
        p_value: f64,
    },
    /// The measurements do not share what they were said to.
    NotShared {
        /// p value of it.
        p_value: f64,
    },
    /// A measurement could not be analysed; the others were.
    Failed {
        /// Its name.
        name: String,
    },
    /// A measurement gives no friction displacement and damping (units, too short).
    NotUsed {
        /// Its name.
        name: String,
        /// Why.
        why: &'static str,
    },
}

impl Warning {
    /// Machine-readable code.
    pub fn code(&self) -> &'static str {
        match self {
            Warning::Disagree { .. } => "disagree",
            Warning::NotShared { .. } => "not_shared",
            Warning::Failed { .. } => "failed",
            Warning::NotUsed { .. } => "not_used",
        }
    }
}

impl fmt::Display for Warning {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        use crate::answer::p_value;
        match self {
            Warning::Disagree { condition, p_value: p } => {
                write!(f, "{condition}: ring-down and resonance disagree ({})", p_value(*p))
            }
            Warning::NotShared { p_value: p } => write!(
                f,
                "the measurements do not share the parameters they were said to share ({})",
                p_value(*p)
            ),
            Warning::Failed { name } => write!(f, "{name} could not be analysed; the others were"),
            Warning::NotUsed { name, why } => write!(f, "{name} is not in the joint fit: {why}"),
        }
    }
}

/// Everything [`analyse`](super::analyse) found out.
#[derive(Debug, Clone, PartialEq)]
#[non_exhaustive]
pub struct Answer {
    /// Each measurement alone, in the order given, with its name.
    pub solo: Vec<(String, Result<Solo, Error>)>,
    /// The paper's Table 1 for these data.
    pub table: Vec<Row>,
    /// p value that ring-down and resonance agree at every condition.
    pub agreement_p_value: Option<f64>,
    /// Everything fitted jointly.
    pub joint: Option<Joint>,
    /// Friction against load, laws compared, best first; empty without numeric conditions.
    pub laws: Vec<LawFit>,
    /// Doubts.
    pub warnings: Vec<Warning>,
}
