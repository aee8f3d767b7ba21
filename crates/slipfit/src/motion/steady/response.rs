//! The response of an oscillator at one frequency: parameters and result.

use super::Phasor;
use crate::numeric::dual::Pair;

/// An oscillator at one frequency of its drive, with differences that would cancel given separately.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Point {
    /// Angular frequency of the drive, rad/s.
    pub omega: f64,
    /// Natural angular frequency, rad/s.
    pub omega_0: f64,
    /// `omega - omega_0`, rad/s, given separately because it cancels at high Q.
    pub detuning: f64,
    /// Decay rate, 1/s.
    pub delta: f64,
    /// Drive amplitude `x_0`.
    pub x_0: f64,
    /// Friction displacement `x_F`.
    pub x_f: f64,
}

/// Kind of motion that gave a fundamental.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Regime {
    /// Two turning points per cycle, no stop.
    Sliding,
    /// One stop per half cycle.
    OneStop,
    /// Several slides per half cycle.
    ManyStops,
    /// More than two turning points without a symmetric stop: found by shooting; the derivatives are only those of
    /// the closed form.
    ManyTurns,
    /// Nothing moves.
    Stuck,
}

impl Regime {
    /// Minimum number of stops per cycle.
    pub fn stops(self) -> usize {
        match self {
            Regime::Sliding | Regime::Stuck | Regime::ManyTurns => 0,
            Regime::OneStop => 2,
            Regime::ManyStops => 4,
        }
    }
}

/// The fundamental `x = Re Z e^(i omega t)`, drive `x_0 cos(omega t)`, and its derivatives.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Fundamental {
    /// `Z`.
    pub value: Phasor,
    /// Derivative with respect to `omega_0` at fixed `omega` (the detuning changes with it).
    pub by_omega_0: Phasor,
    /// Derivative with respect to the decay rate.
    pub by_delta: Phasor,
    /// Derivative with respect to the drive amplitude.
    pub by_x_0: Phasor,
    /// Derivative with respect to the friction displacement.
    pub by_x_f: Phasor,
    /// The kind of motion.
    pub regime: Regime,
}

impl Fundamental {
    pub(super) const REST: Self = {
        let zero = Phasor::new(0.0, 0.0);
        Self {
            value: zero,
            by_omega_0: zero,
            by_delta: zero,
            by_x_0: zero,
            by_x_f: zero,
            regime: Regime::Stuck,
        }
    };

    pub(super) fn of_pair(z: &Pair<4>, regime: Regime) -> Self {
        let by = |i: usize| Phasor::new(z.re.d[i], z.im.d[i]);
        Self {
            value: Phasor::new(z.re.value, z.im.value),
            by_omega_0: by(0),
            by_delta: by(1),
            by_x_0: by(2),
            by_x_f: by(3),
            regime,
        }
    }
}
