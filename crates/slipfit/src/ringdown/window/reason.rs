//! Reasons for the start and the end of a free decay.

use std::fmt;

/// Reason for the start of the free decay.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
#[cfg_attr(feature = "serde", derive(serde::Serialize), serde(into = "&'static str"))]
#[non_exhaustive]
pub enum StartReason {
    /// The record starts there.
    RecordStart,
    /// Before it the motion is driven or disturbed.
    LeadIn,
    /// Before it the mass is held at a deflection.
    Held,
    /// Before it samples are clipped.
    Clipped,
    /// The start was set by the user.
    Requested,
}

/// Reason for the end of the free decay.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
#[cfg_attr(feature = "serde", derive(serde::Serialize), serde(into = "&'static str"))]
#[non_exhaustive]
pub enum EndReason {
    /// The record ends there.
    RecordEnd,
    /// The oscillation reaches the noise.
    Noise,
    /// The motion comes to rest.
    Rest,
    /// The motion falls below a step of the converter.
    Resolution,
    /// The amplitude jumps up.
    Disturbance,
    /// The amplitude falls below the law of the earlier decay, or follows another one.
    LawChange,
    /// The amplitude stays above what the law of the earlier decay predicts.
    SlowTail,
    /// The end was set by the user.
    Requested,
    /// The minimum amplitude set by the user is reached.
    LeastAmplitude,
}

impl StartReason {
    /// The reason in words, as in reports and in the JSON answer.
    pub const fn as_str(self) -> &'static str {
        match self {
            StartReason::RecordStart => "the record starts",
            StartReason::LeadIn => "before it the motion is driven or disturbed",
            StartReason::Held => "before it the mass is held",
            StartReason::Clipped => "before it samples are clipped",
            StartReason::Requested => "asked for",
        }
    }
}

impl EndReason {
    /// The reason in words, as in the JSON answer.
    pub const fn as_str(self) -> &'static str {
        match self {
            EndReason::RecordEnd => "the record ends",
            EndReason::Noise => "the oscillation reaches the noise",
            EndReason::Rest => "the motion comes to rest",
            EndReason::Resolution => "the motion falls below a step of the converter",
            EndReason::Disturbance => "a disturbance",
            EndReason::LawChange | EndReason::SlowTail => "the amplitude leaves the law of the earlier decay",
            EndReason::Requested => "asked for",
            EndReason::LeastAmplitude => "the least amplitude asked for",
        }
    }
}

impl fmt::Display for StartReason {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.pad(self.as_str())
    }
}

/// As in reports.
impl fmt::Display for EndReason {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.pad(match self {
            EndReason::Rest => "the motion is at rest",
            EndReason::LawChange | EndReason::SlowTail => "the loss follows another law afterwards",
            EndReason::LeastAmplitude => "the minimum amplitude asked for",
            other => other.as_str(),
        })
    }
}

impl From<StartReason> for &'static str {
    fn from(reason: StartReason) -> Self {
        reason.as_str()
    }
}

impl From<EndReason> for &'static str {
    fn from(reason: EndReason) -> Self {
        reason.as_str()
    }
}
