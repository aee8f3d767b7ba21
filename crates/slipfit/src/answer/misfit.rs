//! What a law leaves of the amplitudes along a decay: its size and its shape.

use super::figures::figures;
use std::fmt;

/// What the law leaves of the amplitudes along the decay.
#[derive(Debug, Clone, Copy, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize))]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
pub struct Misfit {
    /// Root mean square of the residuals over that of the amplitudes.
    pub relative_rms: f64,
    /// Largest residual over the amplitude at its instant, where noise is less than that.
    pub largest: f64,
    /// Instant of it, s on the record's clock.
    pub largest_at_s: f64,
    /// How the residuals run along the decay.
    pub shape: MisfitShape,
}

/// How residuals run along a decay, which tells what a law lacks.
#[derive(Debug, Clone, Copy, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize), serde(tag = "kind", rename_all = "snake_case"))]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
#[non_exhaustive]
pub enum MisfitShape {
    /// A smooth arc: a loss term is missing.
    Bow,
    /// A corner: the loss changes at an instant.
    Kink {
        /// Its instant, s on the record's clock.
        time_s: f64,
    },
    /// A periodic wobble: a second mode at this distance from the first.
    Wobble {
        /// Difference of the frequencies, Hz.
        frequency_hz: f64,
    },
    /// The end of the decay only.
    End {
        /// Instant from which on the law fails, s on the record's clock.
        from_s: f64,
    },
    /// No shape: scatter beyond the noise.
    Scatter,
}

impl fmt::Display for MisfitShape {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Bow => f.write_str("the residuals curve along the decay: a loss term is missing"),
            Self::Kink { time_s } => {
                write!(f, "the residuals have a kink at {} s: the loss changes there", figures(*time_s, 4))
            }
            Self::Wobble { frequency_hz } => {
                write!(
                    f,
                    "the residuals oscillate at {} Hz: there may be a second mode that far from the first",
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
            Self::Scatter => f.write_str("the residuals scatter without a pattern: the motion is disturbed"),
        }
    }
}
