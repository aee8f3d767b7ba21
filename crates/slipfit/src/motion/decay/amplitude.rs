//! The amplitude law: the decay of the amplitude under sliding, viscous and drag loss together, in closed form.

use crate::error::Error;
pub(crate) use crate::model::loss::FURTHER;
use crate::model::loss::{LossTerm, SHAPED, Shape};
use crate::model::oscillator::{Oscillator, at_least_zero};
use crate::numeric::quadrature::integrate;
use std::f64::consts::PI;

/// Longest step of the integration, relative to the time scale on which the loss changes.
pub(super) const STEP: f64 = 0.1;
/// Maximum number of steps of one integration.
pub(super) const MOST_STEPS: f64 = 256.0;
/// Part of the amplitude lost in a step, up to which one fourth-order step is accurate to 1e-11.
const SMALL_LOSS: f64 = 0.01;

/// Amplitude of a decay whose loss has a constant, a linear and a quadratic part.
///
/// ```text
/// dA/dt = -(a0 + a1 A + a2 A²)
/// A(t) = [A_0 (1 - a1 T) - 2 a0 T] / [1 + (2 a2 A_0 + a1) T],
/// D = 4 a0 a2 - a1²;   T = tan(t sqrt(D)/2)/sqrt(D),  tanh(t sqrt(-D)/2)/sqrt(-D)  or  t/2
/// ```
///
/// It is evaluated without cancellation, including every degenerate case. The three losses are
///
/// ```text
/// sliding  F         a0 = 2 omega x_F / pi         per s, in units of displacement
/// viscous  gamma     a1 = delta = gamma / 2m       per s
/// drag     c v|v|    a2 = 4 c omega / (3 pi m)     per s and displacement
/// ```
///
/// With `a2 = 0` this is the amplitude of eq. (16) of Vitorino, Vieira and Rodrigues; with drag it is the extension
/// they propose after eq. (18). The law is averaged over a cycle and holds to first order in the loss per cycle. The
/// turning points of the exact motion with viscous and sliding friction lie on it if
/// `a0 = delta x_F coth(pi delta / 2 omega_d)`.
///
/// ```
/// # use slipfit::motion::decay::AmplitudeLaw;
/// let sliding = AmplitudeLaw::new(1.0, 0.1, 0.0, 0.0)?;
/// assert!((sliding.amplitude(4.0) - 0.6).abs() < 1e-15); // a straight line
/// assert_eq!(sliding.stop_time_s(), Some(10.0));
/// # Ok::<(), slipfit::Error>(())
/// ```
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct AmplitudeLaw {
    /// Amplitude at the start.
    pub(crate) initial: f64,
    /// Sliding, viscous and drag coefficients. Estimates of them may be negative.
    pub(crate) a0: f64,
    pub(crate) a1: f64,
    pub(crate) a2: f64,
    /// Coefficients of the further terms. These have no closed form: the law is integrated numerically.
    pub(crate) further: [f64; FURTHER],
    /// Shapes of the further terms that have a shape parameter.
    pub(crate) shapes: [Shape; SHAPED],
}

impl AmplitudeLaw {
    /// Law from the initial amplitude and the three rates.
    ///
    /// # Errors
    /// [`Error::Parameter`] if one is negative or not finite.
    pub fn new(initial_amplitude: f64, a0: f64, a1: f64, a2: f64) -> Result<Self, Error> {
        at_least_zero("initial_amplitude", initial_amplitude)?;
        at_least_zero("a0 (sliding rate)", a0)?;
        at_least_zero("a1 (decay rate)", a1)?;
        at_least_zero("a2 (drag rate)", a2)?;
        Ok(Self::from_rates(initial_amplitude, [a0, a1, a2]))
    }

    /// The same for arbitrary rates, as a fit may try them.
    pub(crate) fn from_rates(initial: f64, [a0, a1, a2]: [f64; 3]) -> Self {
        Self { initial, a0, a1, a2, further: [0.0; FURTHER], shapes: [Shape::default(); SHAPED] }
    }

    /// Law from an oscillator, its drag rate `a2` (per s and displacement), and the initial amplitude.
    ///
    /// # Errors
    /// As [`AmplitudeLaw::new`].
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

    /// Loss `-dA/dt` at an amplitude.
    pub(crate) fn rate(&self, amplitude: f64) -> f64 {
        let closed = self.closed_rate(amplitude);
        if self.is_closed() { closed } else { closed + self.further_rate(amplitude) }
    }

    /// Loss rate due to sliding, viscous and drag loss.
    #[inline(always)]
    pub(super) fn closed_rate(&self, amplitude: f64) -> f64 {
        self.a0 + amplitude * (self.a1 + amplitude * self.a2)
    }

    /// Loss rate due to the further terms at an amplitude.
    pub(crate) fn further_rate(&self, amplitude: f64) -> f64 {
        let amplitude = amplitude.max(0.0);
        let terms = self.further.iter().zip(LossTerm::further()).enumerate().filter(|(_, (c, _))| **c != 0.0);
        terms
            .map(|(k, (c, term))| match k.checked_sub(FURTHER - SHAPED).map(|shaped| self.shapes[shaped]) {
                None => c * term.shape(amplitude),
                Some(s) if s.parameter != 0.0 && self.initial > 0.0 => {
                    c * self.initial * term.relative_value(amplitude / self.initial, s)
                }
                Some(_) => 0.0,
            })
            .sum()
    }

    /// Derivative of the loss rate with respect to the amplitude.
    pub(crate) fn rate_slope(&self, amplitude: f64) -> f64 {
        let closed = self.a1 + 2.0 * amplitude * self.a2;
        if self.is_closed() {
            return closed;
        }
        let terms = self.further.iter().zip(LossTerm::further());
        let fixed = terms.take(FURTHER - SHAPED);
        let fixed = fixed.fold(closed, |sum, (c, term)| sum + c * term.shape_derivative(amplitude.max(0.0)));
        let shaped = self.further[FURTHER - SHAPED..].iter().enumerate().filter(|(_, c)| **c != 0.0);
        shaped.fold(fixed, |sum, (k, c)| sum + c * self.relative(k, amplitude)[1])
    }

    /// Relative shape of the `k`-th loss with a shape parameter, and its derivatives with respect to the amplitude
    /// over the initial one and to the parameter; zeros if the term is absent.
    pub(super) fn relative(&self, k: usize, amplitude: f64) -> [f64; 3] {
        let s = self.shapes[k];
        if s.parameter == 0.0 || !(self.initial > 0.0) {
            return [0.0; 3];
        }
        LossTerm::shaped()[k].relative(amplitude.max(0.0) / self.initial, s)
    }

    /// Shapes `g(A)` of the further loss terms.
    pub(super) fn further_shapes(&self, amplitude: f64) -> [f64; FURTHER] {
        std::array::from_fn(|k| match k.checked_sub(FURTHER - SHAPED) {
            None => LossTerm::further()[k].shape(amplitude.max(0.0)),
            Some(shaped) => self.initial * self.relative(shaped, amplitude)[0],
        })
    }

    /// Whether the closed form is the complete law.
    pub(crate) fn is_closed(&self) -> bool {
        self.further.iter().all(|c| *c == 0.0)
    }

    /// Shares of the loss at an amplitude: sliding, viscous, drag.
    pub(crate) fn shares(&self, amplitude: f64) -> [f64; 3] {
        let parts = self.losses(amplitude).map(|p| p.max(0.0));
        let further =
            self.further.iter().zip(self.further_shapes(amplitude)).map(|(c, shape)| (c * shape).max(0.0));
        let total: f64 = parts.iter().sum::<f64>() + further.sum::<f64>();
        parts.map(|p| if total > 0.0 { p / total } else { 0.0 })
    }

    /// Amplitude at `time_s`: zero after the stop, the initial amplitude before time zero.
    pub fn amplitude(&self, time_s: f64) -> f64 {
        if time_s <= 0.0 { self.initial } else { self.after(self.initial, time_s).max(0.0) }
    }

    /// The amplitude `time_s` after it was `amplitude`; negative after the stop, because a fit needs a function that
    /// stays smooth there.
    pub(crate) fn after(&self, amplitude: f64, time_s: f64) -> f64 {
        let (a, t) = (amplitude, time_s);
        if !self.is_closed() {
            let steps = (self.rate_slope(a).abs() * t.abs() / STEP).ceil().clamp(1.0, MOST_STEPS);
            return (0..steps as usize).fold(a, |a, _| integrate_step(|a| self.rate(a), a, t / steps).after);
        }
        let Self { a0, a1, a2, .. } = *self;
        if a2 == 0.0 {
            let x = a1 * t;
            return a * (-x).exp() - a0 * t * exp_share(x);
        }
        let d = 4.0 * a0 * a2 - a1 * a1;
        if d > 0.0 {
            let root = d.sqrt();
            let half = 0.5 * t * root;
            // If the viscous loss is negative, the stop may lie beyond the pole of the tangent.
            if half >= 1.5 && t >= self.fall_time(a, 0.0) {
                return 0.0;
            }
            let (sin, cos) = half.sin_cos();
            let s = sin / root;
            return unless_past(cos + (2.0 * a2 * a + a1) * s, a * (cos - a1 * s) - 2.0 * a0 * s);
        }
        let r = (-d).sqrt();
        self.falling(a, r, (-r * t).exp(), t * exp_share(r * t))
    }

    /// The amplitude after `a` for `D <= 0`: `T = (1 - E)/(r (1 + E))`, `E = e^-rt`, numerator and denominator
    /// multiplied by `(1 + E)/2`; `s = (1 - E)/r`.
    fn falling(&self, a: f64, r: f64, e: f64, s: f64) -> f64 {
        let (less, more) = self.roots(r);
        unless_past(e + s * (0.5 * more + self.a2 * a), a * e - s * (self.a0 + 0.5 * a * less))
    }

    /// Precomputed step for [`Self::after`] at `time_s/2` and `time_s`, for any amplitude: the functions of one time
    /// follow from those of the other. `None` if the law has another form.
    pub(super) fn falling_step(&self, time_s: f64) -> Option<FallingStep> {
        let r = (self.a1 * self.a1 - 4.0 * self.a0 * self.a2).sqrt();
        let x = 0.5 * r * time_s;
        (self.a2 != 0.0 && x.abs() > 1e-5 && self.is_closed()).then(|| {
            // expm1 used twice: e^(-2x) - 1 = m (2 + m).
            let m = (-x).exp_m1();
            let (e, s) = (1.0 + m, -m / r);
            FallingStep { r, half: [e, s], whole: [e * e, s * (2.0 + m)] }
        })
    }

    /// Amplitudes in the middle and at the end of a precomputed step.
    pub(super) fn fall(&self, amplitude: f64, FallingStep { r, half, whole }: &FallingStep) -> [f64; 2] {
        [half, whole].map(|[e, s]| self.falling(amplitude, *r, *e, *s))
    }

    /// `a1 - r` and `a1 + r`, `r² = a1² - 4 a0 a2`; the one that would cancel is computed from the product of both.
    pub(super) fn roots(&self, r: f64) -> (f64, f64) {
        let big = self.a1.abs() + r;
        let small = if big > 0.0 { 4.0 * self.a0 * self.a2 / big } else { 0.0 };
        if self.a1 >= 0.0 { (small, big) } else { (-big, -small) }
    }

    /// Time at which the amplitude has fallen to `amplitude`, s.
    ///
    /// `None` if it never falls to this amplitude, or starts below it.
    pub(crate) fn time_to(&self, amplitude: f64) -> Option<f64> {
        if !(0.0..=self.initial).contains(&amplitude) {
            return None;
        }
        let t = self.fall_time(self.initial, amplitude);
        t.is_finite().then_some(t)
    }

    /// Time to fall from `a` to `b`, from T of the closed form; not finite if it never does.
    fn fall_time(&self, a: f64, b: f64) -> f64 {
        if a == b {
            return 0.0;
        }
        if !self.is_closed() {
            return integrate(&|amplitude: f64| 1.0 / self.rate(amplitude), b, a);
        }
        let Self { a0, a1, a2, .. } = *self;
        let fall = a - b;
        let d = 4.0 * a0 * a2 - a1 * a1;
        if d > 0.0 {
            let root = d.sqrt();
            let rate = 2.0 * a0 + a1 * (a + b) + 2.0 * a2 * a * b;
            return 2.0 * f64::atan2(root * fall, rate) / root;
        }
        let r = (-d).sqrt();
        let (less, more) = self.roots(r);
        // rate - r fall, with the cancelling parts combined analytically.
        let rest = 2.0 * a0 + a * less + b * more + 2.0 * a2 * a * b;
        let x = 2.0 * r * fall / rest;
        if x.abs() < 1e-40 { 2.0 * fall / rest } else { x.ln_1p() / r }
    }

    /// Time at which the amplitude reaches zero, s; `None` without sliding friction.
    ///
    /// The mass itself stops up to half a period from this time, with an offset of up to `F_s/k`: see
    /// [`FreeDecay::stop`](super::FreeDecay::stop).
    pub fn stop_time_s(&self) -> Option<f64> {
        if self.a0 <= 0.0 && self.initial > 0.0 { None } else { self.time_to(0.0) }
    }
}

/// Half a step and a whole step of a law with `D < 0`: `e^-rt` and `(1 - e^-rt)/r`.
#[derive(Debug, Clone, Copy)]
pub(super) struct FallingStep {
    r: f64,
    half: [f64; 2],
    whole: [f64; 2],
}

/// Amplitudes in the middle and at the end of a step of an integrated law, and the loss rate at its beginning, middle
/// and end.
pub(super) struct IntegratedStep {
    pub(super) middle: f64,
    pub(super) after: f64,
    pub(super) rates: [f64; 3],
}

/// One step of `dA/dt = -rate(A)`: the classical Runge-Kutta rule over the step and over its halves, extrapolated to
/// fifth order. For a step of [`STEP`] the error is below 1e-9 of the amplitude, and a hundred times that in the
/// middle.
pub(super) fn integrate_step(rate: impl Fn(f64) -> f64, amplitude: f64, h: f64) -> IntegratedStep {
    let classical = |a: f64, rate_here: f64, h: f64| {
        let k1 = -rate_here;
        let k2 = -rate(a + 0.5 * h * k1);
        let k3 = -rate(a + 0.5 * h * k2);
        let k4 = -rate(a + h * k3);
        a + h / 6.0 * (k1 + 2.0 * (k2 + k3) + k4)
    };
    let before = rate(amplitude);
    let once = classical(amplitude, before, h);
    // The error is of fifth order in the loss per step, negligible here.
    if (once - amplitude).abs() < SMALL_LOSS * amplitude.abs() {
        let end = rate(once);
        // Cubic Hermite interpolation between the ends.
        let middle = 0.5 * (amplitude + once) + 0.125 * h * (end - before);
        return IntegratedStep { middle, after: once, rates: [before, rate(middle), end] };
    }
    let middle = classical(amplitude, before, 0.5 * h);
    let half = rate(middle);
    let twice = classical(middle, half, 0.5 * h);
    let after = twice + (twice - once) / 15.0;
    IntegratedStep { middle, after, rates: [before, half, rate(after)] }
}

/// The amplitude `above / below`, or zero beyond the pole, which lies long after the stop. If the viscous loss is
/// negative, the amplitude passes below zero to the pole, and beyond it the formula would return from positive
/// values.
#[inline(always)]
fn unless_past(below: f64, above: f64) -> f64 {
    if below <= 0.0 { 0.0 } else { above / below }
}

/// `(1 - e^(-x))/x`, accurate also at zero.
pub(crate) fn exp_share(x: f64) -> f64 {
    if x.abs() < 1e-5 { 1.0 - 0.5 * x + x * x / 6.0 } else { -(-x).exp_m1() / x }
}

/// `K` of `a0 = K x_F` and its derivatives with respect to delta and omega: `K = delta coth(pi delta/2 omega)`, for
/// which the turning points of the exact motion lie on the law.
pub(crate) fn sliding_gain(delta: f64, omega: f64) -> [f64; 3] {
    let y = PI * delta / (2.0 * omega);
    if y.abs() < 1e-4 {
        [2.0 * omega / PI * (1.0 + y * y / 3.0), 2.0 * y / 3.0, 2.0 / PI]
    } else {
        let coth = 1.0 / y.tanh();
        let slope = y / y.sinh().powi(2);
        [delta * coth, coth - slope, slope * delta / omega]
    }
}

/// `a0 = 2 omega x_F / pi`: loss of amplitude per second due to sliding friction.
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

    fn slope(e: &AmplitudeLaw, a: f64) -> f64 {
        e.losses(a).iter().sum()
    }

    #[test]
    fn a_viscous_decay_stays_relatively_exact_to_the_end() {
        let e = AmplitudeLaw::new(2.0, 0.0, 0.3, 0.0).unwrap();
        assert!((e.amplitude(1000.0) / (2.0 * (-300.0f64).exp()) - 1.0).abs() < 1e-13);
        assert_eq!(e.stop_time_s(), None);
    }

    #[test]
    fn pure_drag_falls_as_one_over_time() {
        let e = AmplitudeLaw::new(2.0, 0.0, 0.0, 0.25).unwrap();
        assert!((e.amplitude(6.0) - 2.0 / (1.0 + 0.25 * 2.0 * 6.0)).abs() < 1e-15);
        assert!((e.time_to(0.5).unwrap() - 6.0).abs() < 1e-13);
    }

    #[test]
    fn sliding_and_drag_run_along_a_tangent() {
        let (a0, a2): (f64, f64) = (0.02, 0.5);
        let e = AmplitudeLaw::new(1.0, a0, 0.0, a2).unwrap();
        let k = (a0 * a2).sqrt();
        let exact = |t: f64| (a0 / a2).sqrt() * ((1.0 * (a2 / a0).sqrt()).atan() - k * t).tan();
        for t in [0.1, 1.0, 5.0, 13.0] {
            assert!((e.amplitude(t) - exact(t)).abs() < 1e-14, "{t}");
        }
    }

    #[test]
    fn the_law_goes_on_past_zero_and_back_in_time_for_any_sign() {
        for (a0, a1, a2) in
            [(0.1, 0.2, 0.1), (-0.02, 0.2, 0.1), (0.1, -0.05, 0.1), (0.02, 0.3, -0.05), (0.1, 0.2, 0.0)]
        {
            let law = AmplitudeLaw::from_rates(1.0, [a0, a1, a2]);
            for t in [-1.0, 0.5, 3.0, 6.0] {
                let (here, there) = (law.after(1.0, t), law.after(law.after(1.0, t), -t));
                assert!((there - 1.0).abs() < 1e-12, "{law:?} {t}: {there}");
                let h = 1e-5;
                let slope = (law.after(1.0, t + h) - law.after(1.0, t - h)) / (2.0 * h);
                assert!((slope + law.rate(here)).abs() < 1e-8, "{law:?} {t}: {slope}");
            }
        }
    }

    #[test]
    fn a_law_with_negative_viscous_loss_reaches_its_stop_past_a_quarter_turn() {
        let law = AmplitudeLaw::from_rates(1.0, [0.1, -0.3, 0.3]);
        let stop = law.fall_time(1.0, 0.0);
        let root = (4.0f64 * 0.1 * 0.3 - 0.09).sqrt();
        assert!(0.5 * root * stop > 0.5 * PI, "{stop}");
        let h = 1e-5;
        for t in [0.9 * stop, 0.97 * stop] {
            let slope = (law.after(1.0, t + h) - law.after(1.0, t - h)) / (2.0 * h);
            let here = law.after(1.0, t);
            assert!(here > 0.0, "{here} at {t}");
            assert!((slope + law.rate(here)).abs() < 1e-8, "{slope} at {t}");
        }
        assert_eq!(law.after(1.0, 1.001 * stop), 0.0);
    }

    #[test]
    fn a_law_without_a_closed_form_is_integrated() {
        // dA/dt = -c A^1.5 has A = A0/(1 + c sqrt(A0) t/2)².
        let (c, a0): (f64, f64) = (0.4, 2.0);
        let mut a = a0;
        for i in 1..=40 {
            a = integrate_step(|a| c * a.powf(1.5), a, 0.1).after;
            let exact = a0 / (1.0 + 0.5 * c * a0.sqrt() * 0.1 * f64::from(i)).powi(2);
            assert!((a / exact - 1.0).abs() < 1e-8, "step {i}: {a} for {exact}");
        }
        let law = AmplitudeLaw::from_rates(1.0, [0.02, 0.1, 0.3]);
        let there = integrate_step(|a| law.rate(a), 1.0, 0.15).after;
        assert!((there / law.after(1.0, 0.15) - 1.0).abs() < 1e-9);
    }

    #[test]
    fn the_gain_of_sliding_has_its_derivatives() {
        for (delta, omega) in [(0.3, 5.0), (2.0, 5.0), (3e-4, 5.0), (0.0, 5.0)] {
            let h = 1e-6;
            let [_, by_delta, by_omega] = sliding_gain(delta, omega);
            let numeric = (sliding_gain(delta + h, omega)[0] - sliding_gain(delta - h, omega)[0]) / (2.0 * h);
            assert!((by_delta - numeric).abs() < 1e-7, "{delta}: {by_delta} {numeric}");
            let numeric = (sliding_gain(delta, omega + h)[0] - sliding_gain(delta, omega - h)[0]) / (2.0 * h);
            assert!((by_omega - numeric).abs() < 1e-7, "{delta}: {by_omega} {numeric}");
        }
    }

    #[test]
    fn neighbours_of_a_degenerate_case_agree_with_it() {
        let e = |a0, a1, a2| AmplitudeLaw::new(1.0, a0, a1, a2).unwrap();
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
            let e = AmplitudeLaw::new(initial, a0, a1, a2).unwrap();
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
            let e = AmplitudeLaw::new(initial, a0, a1, a2).unwrap();
            let t = e.time_to(fraction * initial).unwrap();
            prop_assert!((e.amplitude(t) - fraction * initial).abs() < 1e-11 * initial);
            if let Some(stop) = e.stop_time_s() {
                prop_assert!(stop >= t);
                prop_assert!(e.amplitude(stop * (1.0 + 1e-12)) < 1e-9 * initial);
            }
        }
    }
}
