//! The amplitude followed from point to point with its derivatives by start and loss terms.

use super::amplitude::{self, AmplitudeLaw, FURTHER, FallingStep, IntegratedStep, exp_share, integrate_step};
use super::backbone::{PerTerm, TERMS, backbone_factors};
use super::dense::{LongStep, LossAt};
use crate::model::loss::{LossTerm, SHAPED};

/// Derivatives carried: by the start, `a0`, `a1`, `a2`, the further terms and the parameters of shapes.
pub(crate) const CARRIED: usize = SHAPE + SHAPED;

/// Where the parameters of the shapes stand.
pub(crate) const SHAPE: usize = 4 + FURTHER;

/// Longest step of the closed law, over the time in which the loss changes.
pub(super) const STEP: f64 = 0.3;
/// Most parts of one step of the closed law, and of one that is integrated: in more than the latter the amplitude all
/// but ends between two points.
const MOST_PARTS: f64 = 64.0;
const MOST_INTEGRATED_PARTS: f64 = 24.0;
/// Part of the longest step that one between whose ends is interpolated may be: derivatives are then right to 1e-7.
const INTERPOLATED_PART: f64 = 0.7;
/// Most durations asked for that are one such step.
const MOST_AHEAD: f64 = 64.0;
/// How much faster the loss may change at the end of such a step than at its begin.
const MOST_STIFFER: f64 = 2.0;
/// Relative half width of the difference that the slope of a loss is where the frequency changes it.
const NEAR: f64 = 1e-4;
/// Order of the error of an integrated step.
const ORDER: f64 = 5.0;
/// First amplitude over the present one from which on integrated steps are longer, and the most that counts.
const LONGER_STEPS_FROM: f64 = 4.0;
const MOST_AMPLITUDE_RATIO: f64 = 1e6;

/// The law in force where the frequency is shifted: each term times its factor.
pub(crate) fn shifted(law: &AmplitudeLaw, f: &PerTerm) -> AmplitudeLaw {
    AmplitudeLaw {
        a0: law.a0 * f[0],
        a1: law.a1 * f[1],
        a2: law.a2 * f[2],
        further: std::array::from_fn(|k| law.further[k] * f[3 + k]),
        ..*law
    }
}

/// The amplitude carried from point to point with its derivatives.
#[derive(Debug, Clone, Copy)]
pub(crate) struct AmplitudePath {
    pub(crate) amplitude: f64,
    /// By start, a0, a1, a2 and the further terms.
    pub(crate) by: [f64; CARRIED],
    law: AmplitudeLaw,
    /// Whether its closed form is the whole law.
    closed: bool,
    /// Relative shift of frequency per A² and A⁴, which changes the loss terms.
    backbone: [f64; 2],
    carried: Carried,
    /// The last step where the law stays the same, and its duration.
    last: (f64, Step),
    /// The step of an integrated law within which the path is.
    long: Option<LongStep<CARRIED>>,
}

/// The derivatives that are carried along.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) enum Carried {
    None,
    /// By start, sliding, viscous and drag loss.
    Closed,
    /// Those by the further terms besides.
    All,
}

impl Carried {
    /// Those by these parameters, which begin with the start and the losses.
    pub(crate) fn for_parameters(parameters: &[usize]) -> Self {
        match parameters {
            [] => Self::None,
            list if list.iter().any(|k| (4..CARRIED).contains(k)) => Self::All,
            _ => Self::Closed,
        }
    }
}

/// What steps of one duration share.
#[derive(Debug, Clone, Copy)]
enum Step {
    Linear(LinearStep),
    Falling(FallingStep),
    Other,
}

/// Relative difference of durations that is rounding.
const SAME_STEP: f64 = 1e-12;

/// The propagator of `dA/dt = -(a0 + a1 A)` over one step: `A -> A e - a0 g`,
/// `e = e^(-a1 h)`, `g = (1 - e)/a1`.
#[derive(Debug, Clone, Copy)]
pub(super) struct LinearStep {
    duration: f64,
    e: f64,
    g: f64,
    /// `e` and `g` of half the step.
    half: [f64; 2],
}

impl LinearStep {
    fn new(a1: f64, duration: f64) -> Self {
        let h = duration;
        let x = 0.5 * a1 * h;
        // expm1 twice over: e^(-2x) - 1 = m (2 + m).
        let m = (-x).exp_m1();
        let share = if x.abs() < 1e-5 { exp_share(x) } else { -m / x };
        let (e, share_of_all) = ((1.0 + m) * (1.0 + m), 0.5 * share * (2.0 + m));
        Self { duration, e, g: h * share_of_all, half: [1.0 + m, 0.5 * h * share] }
    }
}

impl AmplitudePath {
    pub(crate) fn new(law: AmplitudeLaw, backbone: [f64; 2]) -> Self {
        let mut by = [0.0; CARRIED];
        by[0] = 1.0;
        let last = (f64::NAN, Step::Other);
        let closed = law.is_closed();
        Self { amplitude: law.initial, by, law, closed, backbone, carried: Carried::All, last, long: None }
    }

    /// The same with some of the derivatives alone.
    pub(crate) fn carrying(self, carried: Carried) -> Self {
        Self { carried, ..self }
    }

    /// The law in force at an amplitude, and the factors that make it so.
    fn local(&self, amplitude: f64) -> (AmplitudeLaw, PerTerm) {
        if self.backbone == [0.0; 2] {
            return (self.law, [1.0; TERMS]);
        }
        let f = backbone_factors(amplitude, self.backbone);
        (shifted(&self.law, &f), f)
    }

    /// Loss `-dA/dt` here.
    pub(crate) fn rate(&self) -> f64 {
        self.rate_at(self.amplitude)
    }

    fn rate_at(&self, amplitude: f64) -> f64 {
        if self.closed && self.backbone == [0.0; 2] {
            return self.law.closed_rate(amplitude);
        }
        self.local(amplitude).0.rate(amplitude)
    }

    /// Whether viscous and sliding loss act alone and the frequency is constant.
    fn is_linear(&self) -> bool {
        self.backbone == [0.0; 2] && self.law.a2 == 0.0 && self.closed
    }

    /// How fast the loss changes with the amplitude, 1/s.
    fn stiffness(&self) -> f64 {
        let a = self.amplitude;
        // Below zero the further losses stay what they are at zero.
        if self.closed || a <= 0.0 {
            return self.law.a1.abs() + 2.0 * self.law.a2.abs() * a.abs();
        }
        // Losses that cancel, as a fit of many terms tries them, change as little as their sum does.
        self.law.rate_slope(a).abs().max(self.law.rate(a).abs() / a)
    }

    /// Moves on by `duration` seconds (negative: back).
    pub(crate) fn advance(&mut self, duration: f64) {
        if duration == 0.0 {
            return;
        }
        let duration = if self.closed { duration } else { self.advance_long(duration) };
        if duration == 0.0 {
            return;
        }
        let parts = self.parts(duration);
        let part = duration / parts as f64;
        if self.backbone != [0.0; 2] {
            (0..parts).for_each(|_| self.advance_part(part));
            return;
        }
        match self.step(part) {
            Step::Linear(step) => (0..parts).for_each(|_| self.advance_linear(&step)),
            Step::Falling(step) => (0..parts).for_each(|_| self.advance_falling(&step, part)),
            Step::Other => (0..parts).for_each(|_| self.advance_part(part)),
        }
    }

    /// The step of a law that stays the same; that of the last time where it was as long.
    fn step(&mut self, duration: f64) -> Step {
        let (last_duration, last) = self.last;
        if (duration - last_duration).abs() <= SAME_STEP * duration.abs() {
            return last;
        }
        let step = if self.is_linear() {
            Step::Linear(LinearStep::new(self.law.a1, duration))
        } else {
            self.law.falling_step(duration).map_or(Step::Other, Step::Falling)
        };
        self.last = (duration, step);
        step
    }

    /// Parts of a step: each is exact where the law is closed, so that they only serve the derivatives.
    fn parts(&self, duration: f64) -> usize {
        let (step, most) =
            if self.closed { (STEP, MOST_PARTS) } else { (self.integrated_step(), MOST_INTEGRATED_PARTS) };
        let parts = (self.stiffness() * duration.abs() / step).min(most);
        // Rounded up, without the call that `ceil` is.
        let whole = parts as usize;
        (whole + usize::from((whole as f64) < parts)).max(1)
    }

    /// Longest step of an integrated law, over the time in which the loss changes. It may be longer at a small
    /// amplitude, for the same error relative to the first one: where a loss ends the motion, as `A^n` with `n < 1`
    /// does, it changes ever faster.
    fn integrated_step(&self) -> f64 {
        let ratio = self.law.initial / self.amplitude;
        let longer =
            if ratio > LONGER_STEPS_FROM { ratio.min(MOST_AMPLITUDE_RATIO).powf(1.0 / ORDER) } else { 1.0 };
        amplitude::STEP * longer
    }

    /// Steps that move on by `duration` each time, where viscous and sliding loss act alone and the
    /// frequency is constant.
    pub(super) fn even_steps(&self, duration: f64) -> Option<(usize, LinearStep)> {
        let parts = self.parts(duration);
        self.is_linear().then(|| (parts, LinearStep::new(self.law.a1, duration / parts as f64)))
    }

    /// One step of viscous and sliding loss alone.
    #[inline(always)]
    pub(super) fn advance_linear(&mut self, step: &LinearStep) {
        let [e_half, g_half] = step.half;
        let before = self.amplitude;
        self.amplitude = before * step.e - self.law.a0 * step.g;
        if self.carried == Carried::None {
            return;
        }
        let middle = before * e_half - self.law.a0 * g_half;
        self.carry([before, middle, self.amplitude], step.duration, [step.e, e_half, 1.0], [1.0; TERMS]);
    }

    /// One step of a law with drag that the frequency does not change.
    fn advance_falling(&mut self, step: &FallingStep, part: f64) {
        let (law, before) = (self.law, self.amplitude);
        let [middle, after] = law.fall(before, step);
        self.amplitude = after;
        if self.carried == Carried::None {
            return;
        }
        let points = [before, middle, after];
        let slopes = slopes_along(&law, true, points, points.map(|a| law.closed_rate(a)), part);
        self.carry(points, part, slopes, [1.0; TERMS]);
    }

    /// One step of any law, its terms taken as those in the middle.
    fn advance_part(&mut self, part: f64) {
        let before = self.amplitude;
        let (here, _) = self.local(before);
        let (law, f) =
            self.local(if self.backbone == [0.0; 2] { before } else { here.after(before, 0.5 * part) });
        let IntegratedStep { middle, after, rates } = if self.closed {
            let (middle, after) = (law.after(before, 0.5 * part), law.after(before, part));
            IntegratedStep { middle, after, rates: [before, middle, after].map(|a| law.closed_rate(a)) }
        } else {
            integrate_step(|a| law.rate(a), before, part)
        };
        let slopes = slopes_along(&law, self.closed, [before, middle, after], rates, part);
        self.carry([before, middle, after], part, slopes, f);
        self.amplitude = after;
    }

    /// Carries the derivatives over a step by Simpson's rule: `points` are the amplitudes at its
    /// begin, middle and end, `slopes` the derivatives of the last by each of them.
    fn carry(&mut self, points: [f64; 3], duration: f64, slopes: [f64; 3], factors: PerTerm) {
        if self.carried == Carried::All {
            let losses = points.map(|a| self.loss(a, &factors).by);
            for (k, by) in self.by.iter_mut().enumerate() {
                *by = *by * slopes[0] - simpson(duration, slopes, losses.map(|loss| loss[k]));
            }
            return;
        }
        for v in &mut self.by {
            *v *= slopes[0];
        }
        let shapes = [[1.0; 3], points, points.map(|a| a * a)];
        for k in 0..3 {
            self.by[k + 1] -= factors[k] * simpson(duration, slopes, shapes[k]);
        }
    }

    /// The loss at an amplitude, and its derivatives by the amplitude and by all that is carried. A loss whose shape
    /// has a parameter refers to the start: `d/dA0 [A0 G(A/A0)] = G - u G'`.
    fn loss(&self, amplitude: f64, factors: &PerTerm) -> LossAt<CARRIED> {
        let (law, a) = (&self.law, amplitude);
        let mut by = [0.0; CARRIED];
        by[1..4].copy_from_slice(&[factors[0], factors[1] * a, factors[2] * a * a]);
        let mut slope = factors[1] * law.a1 + 2.0 * a * factors[2] * law.a2;
        for (k, term) in LossTerm::further().iter().take(FURTHER - SHAPED).enumerate() {
            by[4 + k] = factors[3 + k] * term.shape(a.max(0.0));
            slope += factors[3 + k] * law.further[k] * term.shape_derivative(a.max(0.0));
        }
        for k in (0..SHAPED).filter(|&k| law.shapes[k].parameter != 0.0) {
            let (term, initial) = (FURTHER - SHAPED + k, law.initial);
            let [value, by_u, by_s] = law.relative(k, a);
            let coefficient = factors[3 + term] * law.further[term];
            by[0] += coefficient * (value - a.max(0.0) / initial * by_u);
            by[4 + term] = factors[3 + term] * initial * value;
            by[SHAPE + k] = coefficient * initial * by_s;
            slope += coefficient * by_u;
        }
        let losses = [law.a0, law.a1, law.a2].into_iter().chain(law.further);
        LossAt { rate: losses.zip(&by[1..]).map(|(c, shape)| c * shape).sum(), slope, by }
    }
}

/// Integrated laws in steps of their own length.
impl AmplitudePath {
    /// Moves on in steps that do not end where they are asked for, so that the amplitude is as smooth a function of the
    /// parameters as of time; returns what is left of `duration` where no such step can be taken.
    fn advance_long(&mut self, duration: f64) -> f64 {
        if !(duration > 0.0 && duration.is_finite()) {
            self.long = None;
            return duration;
        }
        let mut left = duration;
        loop {
            if let Some(step) = &mut self.long {
                let room = step.duration - step.passed;
                step.passed += left.min(room);
                self.interpolate();
                if left <= room {
                    return 0.0;
                }
                left -= room;
            }
            let ahead = INTERPOLATED_PART * self.integrated_step() / self.stiffness();
            let ahead = ahead.max(duration / MOST_INTEGRATED_PARTS).min(MOST_AHEAD * duration);
            self.long = self.long_step(ahead);
            if self.long.is_none() {
                return left;
            }
        }
    }

    fn interpolate(&mut self) {
        let Some(step) = &self.long else { return };
        self.amplitude = step.amplitude();
        if self.carried != Carried::None {
            self.by = step.derivatives();
        }
    }

    /// A step from here; `None` where the loss changes too much along it.
    fn long_step(&self, duration: f64) -> Option<LongStep<CARRIED>> {
        let step = match &self.long {
            Some(last) => last.next(duration, |a| self.rate_at(a), |a| self.loss_at(a)),
            None => {
                LongStep::new(self.amplitude, self.by, duration, |a| self.rate_at(a), |a| self.loss_at(a))
            }
        };
        let there = Self { amplitude: step.amplitude_at_end(), ..*self };
        let alike = there.stiffness() * duration <= MOST_STIFFER * there.integrated_step();
        (alike && there.amplitude.is_finite() && duration > f64::MIN_POSITIVE).then_some(step)
    }

    /// The loss, what the frequency does to it included.
    fn loss_at(&self, amplitude: f64) -> LossAt<CARRIED> {
        if self.backbone == [0.0; 2] {
            return self.loss(amplitude, &[1.0; TERMS]);
        }
        let (_, factors) = self.local(amplitude);
        let h = NEAR * amplitude.abs().max(f64::MIN_POSITIVE);
        let slope = (self.rate_at(amplitude + h) - self.rate_at(amplitude - h)) / (2.0 * h);
        LossAt { slope, ..self.loss(amplitude, &factors) }
    }
}

/// Simpson's rule for `∫ carry f` over a step, from its ends and its middle.
#[inline(always)]
fn simpson(duration: f64, carry: [f64; 3], f: [f64; 3]) -> f64 {
    duration / 6.0 * (carry[0] * f[0] + 4.0 * carry[1] * f[1] + carry[2] * f[2])
}

/// Derivatives of the amplitude at the end of a step by those at its begin, middle and end: all lie on one curve, so
/// that each is the ratio of its slopes, `rates`.
fn slopes_along(
    law: &AmplitudeLaw,
    closed: bool,
    points: [f64; 3],
    rates: [f64; 3],
    duration: f64,
) -> [f64; 3] {
    let [before, middle, after] = points;
    let by = |earlier: f64, rate: f64, h: f64| {
        let ratio = rates[2] / rate;
        if (law.a2 == 0.0 && closed) || !(ratio > 0.0 && ratio.is_finite()) {
            (-law.rate_slope(0.5 * (earlier + after)) * h).exp()
        } else {
            ratio
        }
    };
    [by(before, rates[0], duration), by(middle, rates[1], 0.5 * duration), 1.0]
}

#[cfg(test)]
mod tests {
    use super::*;

    fn moved(mut rates: [f64; 4], k: usize, by: f64) -> AmplitudeLaw {
        rates[k] += by;
        let [initial, a0, a1, a2] = rates;
        AmplitudeLaw::from_rates(initial, [a0, a1, a2])
    }

    #[test]
    fn derivatives_are_those_of_differences() {
        for rates in
            [[1.0, 0.02, 0.2, 0.0], [1.0, 0.05, 0.0, 0.0], [1.5, 0.0, 0.1, 0.2], [1.0, 0.01, 0.9, 0.1]]
        {
            for step in [0.05, 0.7] {
                let follow = |law| {
                    let mut path = AmplitudePath::new(law, [0.0; 2]);
                    (0..4).for_each(|_| path.advance(step));
                    path
                };
                let path = follow(moved(rates, 0, 0.0));
                let law = moved(rates, 0, 0.0);
                assert!((path.amplitude - law.after(law.initial, 4.0 * step)).abs() < 1e-14);
                for k in 0..4 {
                    let h = 1e-6;
                    let numeric = (follow(moved(rates, k, h)).amplitude
                        - follow(moved(rates, k, -h)).amplitude)
                        / (2.0 * h);
                    let error = (path.by[k] - numeric).abs();
                    assert!(error < 1e-5, "{rates:?}, step {step}, {k}: {} for {numeric}", path.by[k]);
                }
            }
        }
    }

    /// Instants so close that a part of their distance is zero.
    #[test]
    fn steps_below_all_numbers_end() {
        let mut law = AmplitudeLaw::from_rates(1.0, [0.1, 0.2, 0.0]);
        law.further[0] = 0.3;
        let mut path = AmplitudePath::new(law, [0.0; 2]);
        for duration in [5e-324, 1e-310, 1e-300] {
            path.advance(duration);
        }
        assert_eq!(path.amplitude, 1.0);
    }

    /// A frequency that overflows puts its turning points at NaN or infinity.
    #[test]
    fn steps_that_are_not_finite_end() {
        let mut law = AmplitudeLaw::from_rates(1.0, [0.1, 0.2, 0.0]);
        law.further[0] = 0.3;
        for backbone in [[0.0; 2], [0.1, 0.0]] {
            for duration in [f64::NAN, f64::INFINITY, f64::NEG_INFINITY, f64::MAX] {
                let mut path = AmplitudePath::new(law, backbone);
                for step in [0.1, duration, 0.1, duration] {
                    path.advance(step);
                }
            }
        }
    }

    /// Losses whose shape is fitted, their parameter among them, over a long decay.
    #[test]
    fn derivatives_by_shapes_are_those_of_differences() {
        for (k, shape) in [(0, 1.5), (1, 0.1), (2, 0.08)] {
            let at = |p: [f64; 5]| {
                let mut law = AmplitudeLaw::from_rates(p[0], [p[1], p[2], 0.0]);
                law.further[FURTHER - SHAPED + k] = p[3];
                law.shapes[k] = LossTerm::shaped()[k].with(p[4]);
                let mut path = AmplitudePath::new(law, [0.0; 2]);
                (0..150).for_each(|_| path.advance(1.5));
                path
            };
            let p = [1.0, 0.0008, 0.0005, 0.0005, shape];
            let path = at(p);
            let by =
                [path.by[0], path.by[1], path.by[2], path.by[4 + FURTHER - SHAPED + k], path.by[SHAPE + k]];
            for j in 0..5 {
                let h = 1e-5 * p[j];
                let (mut up, mut down) = (p, p);
                (up[j], down[j]) = (p[j] + h, p[j] - h);
                let numeric = (at(up).amplitude - at(down).amplitude) / (2.0 * h);
                assert!((by[j] / numeric - 1.0).abs() < 1e-7, "{k} {j}: {} {numeric}", by[j]);
            }
        }
    }
}
