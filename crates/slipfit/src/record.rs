//! A measured record: when, how much, and what kind of signal.

/// What the numbers of a record are.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash, Default)]
#[non_exhaustive]
pub enum SignalKind {
    /// Position or angle, or anything proportional to it.
    #[default]
    Displacement,
    /// Its first derivative in time.
    Velocity,
    /// Its second derivative in time.
    Acceleration,
    /// The amplitude of the oscillation (lock-in R, peak amplitude, dB made linear), never negative.
    Envelope,
    /// In-phase and quadrature outputs of a lock-in amplifier.
    LockIn,
}

/// Samples of one oscillating quantity with their times.
#[derive(Debug, Clone, PartialEq)]
pub struct Record {
    time_s: Vec<f64>,
    signal: Vec<f64>,
    quadrature: Option<Vec<f64>>,
    kind: SignalKind,
    unit: String,
}
