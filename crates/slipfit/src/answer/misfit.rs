//! Residuals of a law along a decay: their size and shape.

use super::figures::figures;
use std::fmt;

/// Residuals of the amplitudes along the decay with respect to the law.
#[derive(Debug, Clone, Copy, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize))]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
pub struct Misfit {
    /// Root mean square of the residuals over that of the amplitudes.
    pub relative_rms: f64,
    /// Largest residual over the amplitude at its instant, where the noise is smaller than the residual.
    pub largest: f64,
    /// Instant of the largest residual, s on the clock of the record.
    pub largest_at_s: f64,
    /// Shape of the residuals along the decay.
    pub shape: MisfitShape,
}

/// Shape of the residuals along a decay, which indicates what the law lacks.
#[derive(Debug, Clone, Copy, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize), serde(tag = "kind", rename_all = "snake_case"))]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
#[non_exhaustive]
pub enum MisfitShape {
    /// A smooth arc: a loss term is missing.
    Bow,
    /// A corner: the loss changes at some instant.
    Kink {
        /// Its instant, s on the clock of the record.
        time_s: f64,
    },
    /// A periodic beat: a second mode at this frequency difference.
    Wobble {
        /// Difference of the two frequencies, Hz.
        frequency_hz: f64,
    },
    /// Only the end of the decay.
    End {
        /// Instant from which the law fails, s on the clock of the record.
        from_s: f64,
    },
    /// No shape: scatter beyond the noise.
    Scatter,
}

impl fmt::Display for MisfitShape {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Bow => f.write_str("the residuals curve along the decay, as if a loss term were missing"),
            Self::Kink { time_s } => {
                write!(
                    f,
                    "the residuals have a kink at {} s, as if the loss changed there",
                    figures(*time_s, 4)
                )
            }
            Self::Wobble { frequency_hz } => {
                write!(
                    f,
                    "the residuals oscillate at {} Hz, as if there were a second mode at that distance in frequency",
                    figures(*frequency_hz, 3)
                )
            }
            Self::End { from_s } => {
                write!(
                    f,
                    "only the end of the decay, from {} s on, deviates from the law",
                    figures(*from_s, 4)
                )
            }
            Self::Scatter => {
                f.write_str("the residuals scatter without a pattern, as those of a disturbed motion do")
            }
        }
    }
}
