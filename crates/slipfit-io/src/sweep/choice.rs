//! What will be read, and how it is written.

use crate::report::{ColumnInfo, ColumnTaken};
use slipfit::SignalKind;

/// A column of the table that will be read.
#[derive(Debug, Clone, PartialEq)]
pub(super) struct Picked {
    pub(super) index: usize,
    pub(super) unit: String,
    pub(super) why: String,
}

/// How the frequency is written.
#[derive(Debug, Clone, PartialEq)]
pub(super) enum Frequency {
    /// Times a factor to Hz.
    Plain(Picked, f64),
    /// The factor for its unit to seconds.
    Period(Picked, f64),
    /// Times a factor, from a centre in Hz or from one that stands in a column, with its factor.
    Shift(Picked, f64, Centre),
}

#[derive(Debug, Clone, PartialEq)]
pub(super) enum Centre {
    Hz(f64),
    Column(Picked, f64),
}

/// How an amplitude is written.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum Scale {
    Linear,
    /// `10^(x/20)`.
    Decibel,
    /// The square of an amplitude.
    Power,
}

/// What the response is made of.
#[derive(Debug, Clone, PartialEq)]
pub(super) enum Response {
    Amplitude {
        amplitude: Picked,
        scale: Scale,
        phase: Option<(Picked, f64)>,
    },
    Complex(Picked, Picked),
    /// Conductance, and susceptance if there is one.
    Admittance(Picked, Option<Picked>),
    /// Series resistance and reactance.
    Impedance(Picked, Option<Picked>),
}

/// Everything to be read.
#[derive(Debug, Clone, PartialEq)]
pub(super) struct Choice {
    pub(super) frequency: Frequency,
    pub(super) response: Response,
    pub(super) drive: Option<Picked>,
    pub(super) std_error: Option<Picked>,
    pub(super) kind: SignalKind,
    pub(super) unit: String,
    pub(super) runs: usize,
    pub(super) run: usize,
    /// Whether a name says that this is a curve.
    pub(super) named: bool,
    pub(super) notes: Vec<String>,
}

impl Frequency {
    pub(super) fn indices(&self) -> Vec<usize> {
        match self {
            Self::Plain(p, _) | Self::Period(p, _) | Self::Shift(p, _, Centre::Hz(_)) => vec![p.index],
            Self::Shift(p, _, Centre::Column(c, _)) => vec![p.index, c.index],
        }
    }
}

impl Response {
    pub(super) fn indices(&self) -> Vec<usize> {
        match self {
            Self::Amplitude { amplitude, phase, .. } => {
                [Some(amplitude.index), phase.as_ref().map(|(p, _)| p.index)].into_iter().flatten().collect()
            }
            Self::Complex(a, b) => vec![a.index, b.index],
            Self::Admittance(a, b) | Self::Impedance(a, b) => {
                [Some(a.index), b.as_ref().map(|b| b.index)].into_iter().flatten().collect()
            }
        }
    }
}

impl Picked {
    /// As the report has it.
    pub(super) fn taken(&self, columns: &[ColumnInfo]) -> ColumnTaken {
        ColumnTaken { column: columns[self.index].clone(), unit: self.unit.clone(), why: self.why.clone() }
    }
}
