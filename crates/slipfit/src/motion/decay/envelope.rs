//! The slow envelope under sliding, viscous and drag loss together.

use crate::error::Error;
use crate::model::oscillator::{Oscillator, at_least_zero};
use std::f64::consts::PI;

/// Amplitude of a decay whose loss is a constant, a linear and a quadratic part.
///
/// ```text
/// dA/dt = -(a0 + a1 A + a2 A²)
/// A(t) = [A_0 (1 - a1 T) - 2 a0 T] / [1 + (2 a2 A_0 + a1) T],
/// D = 4 a0 a2 - a1²;   T = tan(t sqrt(D)/2)/sqrt(D),  tanh(t sqrt(-D)/2)/sqrt(-D)  or  t/2
/// ```
///
/// evaluated without cancellation through every degenerate case. The three
/// losses are
///
/// ```text
/// sliding  F         a0 = 2 omega x_F / pi         per s, in units of displacement
/// viscous  gamma     a1 = delta = gamma / 2m       per s
/// drag     c v|v|    a2 = 4 c omega / (3 pi m)     per s and displacement
/// ```
///
/// With `a2 = 0` this is the amplitude of eq. (16) of Vitorino, Vieira and
/// Rodrigues; with drag it is the extension they propose after eq. (18).
/// Averaged over a cycle: holds to first order in the loss per cycle.
///
/// ```
/// # use slipfit::motion::decay::Envelope;
/// let sliding = Envelope::new(1.0, 0.1, 0.0, 0.0)?;
/// assert!((sliding.amplitude(4.0) - 0.6).abs() < 1e-15); // a straight line
/// assert_eq!(sliding.stop_time_s(), Some(10.0));
/// # Ok::<(), slipfit::Error>(())
/// ```
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Envelope {
    initial: f64,
    a0: f64,
    a1: f64,
    a2: f64,
}

impl Envelope {
    /// From the initial amplitude and the three rates.
    ///
    /// # Errors
    /// [`Error::Parameter`] if one is negative or not finite.
    pub fn new(initial_amplitude: f64, a0: f64, a1: f64, a2: f64) -> Result<Self, Error> {
        at_least_zero("initial_amplitude", initial_amplitude)?;
        at_least_zero("a0 (sliding rate)", a0)?;
        at_least_zero("a1 (decay rate)", a1)?;
        at_least_zero("a2 (drag rate)", a2)?;
        Ok(Self { initial: initial_amplitude, a0, a1, a2 })
    }

    /// From an oscillator, its drag rate `a2` (per s and displacement), and the initial amplitude.
    ///
    /// # Errors
    /// As [`Envelope::new`].
    pub fn of(oscillator: &Oscillator, drag_rate: f64, initial_amplitude: f64) -> Result<Self, Error> {
        Self::new(
            initial_amplitude,
            sliding_rate(oscillator.friction_displacement(), oscillator.omega_d()),
            oscillator.decay_rate_per_s(),
            drag_rate,
        )
    }

    /// The rates `a0`, `a1`, `a2`.
    pub fn rates(&self) -> [f64; 3] {
        [self.a0, self.a1, self.a2]
    }

    /// Loss `-dA/dt` at an amplitude: constant, linear and quadratic part.
    pub fn losses(&self, amplitude: f64) -> [f64; 3] {
        [self.a0, self.a1 * amplitude, self.a2 * amplitude * amplitude]
    }

    /// Amplitude at `time_s`, zero after the stop, the initial one before zero.
    pub fn amplitude(&self, time_s: f64) -> f64 {
        let (a, t) = (self.initial, time_s);
        if t <= 0.0 {
            return a;
        }
        let (a0, a1, a2) = (self.a0, self.a1, self.a2);
        let d = self.discriminant();
        let (up, down) = if d > 0.0 {
            let root = d.sqrt();
            let half = 0.5 * t * root;
            // Beyond a quarter turn the stop has passed.
            if half >= 0.5 * PI {
                return 0.0;
            }
            let (sin, cos) = half.sin_cos();
            let s = sin / root;
            (a * (cos - a1 * s) - 2.0 * a0 * s, cos + (2.0 * a2 * a + a1) * s)
        } else {
            // T = (1 - E)/(r (1 + E)), E = e^-rt, both sides times (1 + E)/2; a1 - r by
            // its conjugate, so that a purely viscous decay stays relatively exact.
            let r = (-d).sqrt();
            let e = (-r * t).exp();
            let s = if r * t < 1e-40 { t } else { -(-r * t).exp_m1() / r };
            let slow = if a1 > 0.0 { 4.0 * a0 * a2 / (r + a1) } else { 0.0 };
            (a * e - s * (a0 + 0.5 * a * slow), e + s * (0.5 * (r + a1) + a2 * a))
        };
        (up / down).clamp(0.0, a)
    }

    fn discriminant(&self) -> f64 {
        4.0 * self.a0 * self.a2 - self.a1 * self.a1
    }

    /// Time at which the amplitude has fallen to `amplitude`, s.
    ///
    /// `None` if it never gets there, or starts below it.
    pub fn time_to(&self, amplitude: f64) -> Option<f64> {
        let (a, b) = (self.initial, amplitude);
        if !(0.0..=a).contains(&b) {
            return None;
        }
        if a == b {
            return Some(0.0);
        }
        let (a0, a1, a2) = (self.a0, self.a1, self.a2);
        // T of the closed form solved for; t from T.
        let fall = a - b;
        let rate = 2.0 * a0 + a1 * (a + b) + 2.0 * a2 * a * b;
        let d = self.discriminant();
        let t = if d > 0.0 {
            let root = d.sqrt();
            2.0 * f64::atan2(root * fall, rate) / root
        } else {
            let r = (-d).sqrt();
            let slow = if a1 > 0.0 { 4.0 * a0 * a2 / (r + a1) } else { 0.0 };
            // rate - r fall, its cancelling parts joined beforehand.
            let less = 2.0 * a0 + a * slow + b * (r + a1) + 2.0 * a2 * a * b;
            let x = 2.0 * r * fall / less;
            if x < 1e-40 { 2.0 * fall / less } else { x.ln_1p() / r }
        };
        t.is_finite().then_some(t)
    }

    /// Time at which the amplitude reaches zero, s; `None` without sliding friction.
    ///
    /// The mass itself stops up to half a period from there, with an offset of
    /// up to `F_s/k`: see [`FreeDecay::stop`](super::FreeDecay::stop).
    pub fn stop_time_s(&self) -> Option<f64> {
        if self.a0 == 0.0 && self.initial > 0.0 { None } else { self.time_to(0.0) }
    }
}

/// `a0 = 2 omega x_F / pi`: loss of amplitude per second to sliding friction.
pub fn sliding_rate(friction_displacement: f64, omega: f64) -> f64 {
    2.0 * omega * friction_displacement / PI
}

/// `a2 = 4 c omega / (3 pi m)`: drag rate of a force `c v|v|`.
pub fn drag_rate(drag_coefficient: f64, mass: f64, omega: f64) -> f64 {
    4.0 * drag_coefficient * omega / (3.0 * PI * mass)
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    fn slope(e: &Envelope, a: f64) -> f64 {
        e.losses(a).iter().sum()
    }

    #[test]
    fn a_viscous_decay_stays_relatively_exact_to_the_end() {
        let e = Envelope::new(2.0, 0.0, 0.3, 0.0).unwrap();
        assert!((e.amplitude(1000.0) / (2.0 * (-300.0f64).exp()) - 1.0).abs() < 1e-13);
        assert_eq!(e.stop_time_s(), None);
    }

    #[test]
    fn pure_drag_falls_as_one_over_time() {
        let e = Envelope::new(2.0, 0.0, 0.0, 0.25).unwrap();
        assert!((e.amplitude(6.0) - 2.0 / (1.0 + 0.25 * 2.0 * 6.0)).abs() < 1e-15);
        assert!((e.time_to(0.5).unwrap() - 6.0).abs() < 1e-13);
    }

    #[test]
    fn sliding_and_drag_run_along_a_tangent() {
        let (a0, a2): (f64, f64) = (0.02, 0.5);
        let e = Envelope::new(1.0, a0, 0.0, a2).unwrap();
        let k = (a0 * a2).sqrt();
        let exact = |t: f64| (a0 / a2).sqrt() * ((1.0 * (a2 / a0).sqrt()).atan() - k * t).tan();
        for t in [0.1, 1.0, 5.0, 13.0] {
            assert!((e.amplitude(t) - exact(t)).abs() < 1e-14, "{t}");
        }
    }

    #[test]
    fn neighbours_of_a_degenerate_case_agree_with_it() {
        let e = |a0, a1, a2| Envelope::new(1.0, a0, a1, a2).unwrap();
        let pairs = [
            (e(0.1, 0.2, 0.1), e(0.1, 0.2 + 1e-12, 0.1)),
            (e(0.1, 0.2, 0.1), e(0.1, 0.2 - 1e-12, 0.1)),
            (e(0.1, 0.2, 0.0), e(0.1, 0.2, 1e-14)),
            (e(0.1, 0.0, 0.0), e(0.1, 1e-14, 0.0)),
            (e(0.0, 0.2, 0.3), e(1e-15, 0.2, 0.3)),
            (e(0.0, 0.0, 0.3), e(1e-30, 1e-15, 0.3)),
            (e(0.0, 0.0, 0.0), e(1e-15, 1e-15, 1e-15)),
        ];
        for (a, b) in pairs {
            for t in [1e-9, 0.3, 2.0, 4.0] {
                assert!((a.amplitude(t) - b.amplitude(t)).abs() < 1e-12, "{a:?} {b:?} {t}");
            }
        }
    }

    proptest! {
        #[test]
        fn the_closed_form_solves_its_equation(
            a0 in prop_oneof![Just(0.0), 1e-6..0.5f64],
            a1 in prop_oneof![Just(0.0), 1e-6..0.5f64],
            a2 in prop_oneof![Just(0.0), 1e-6..0.5f64],
            initial in 0.1..3.0f64,
            t in 0.0..3.0f64,
        ) {
            let e = Envelope::new(initial, a0, a1, a2).unwrap();
            let (h, a) = (1e-4, e.amplitude(t + 1e-4));
            prop_assume!(e.amplitude(t + 2.0 * h) > 0.0);
            let numeric = (e.amplitude(t) - e.amplitude(t + 2.0 * h)) / (2.0 * h);
            prop_assert!((numeric - slope(&e, a)).abs() < 1e-7);
        }

        #[test]
        fn times_and_amplitudes_invert_each_other(
            a0 in prop_oneof![Just(0.0), 1e-6..0.5f64],
            a1 in prop_oneof![Just(0.0), 1e-6..0.5f64],
            a2 in prop_oneof![Just(0.0), 1e-6..0.5f64],
            initial in 0.1..3.0f64,
            fraction in 0.01..1.0f64,
        ) {
            prop_assume!(a0 + a1 + a2 > 0.0);
            let e = Envelope::new(initial, a0, a1, a2).unwrap();
            let t = e.time_to(fraction * initial).unwrap();
            prop_assert!((e.amplitude(t) - fraction * initial).abs() < 1e-11 * initial);
            if let Some(stop) = e.stop_time_s() {
                prop_assert!(stop >= t && e.amplitude(stop * (1.0 + 1e-12)) < 1e-9 * initial);
            }
        }
    }
}
