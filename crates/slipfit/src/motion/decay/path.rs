//! The amplitude followed from point to point, with its derivatives with respect to the initial amplitude and the
//! loss terms.

use super::amplitude::{self, AmplitudeLaw, FURTHER, FallingStep, IntegratedStep, exp_share, integrate_step};
use super::backbone::{PerTerm, TERMS, backbone_factors};
use super::dense::{LongStep, LossAt};
use crate::model::loss::{LossTerm, SHAPED};

/// Number of derivatives carried: with respect to the initial amplitude, `a0`, `a1`, `a2`, the further terms and the
/// shape parameters.
pub(crate) const CARRIED: usize = SHAPE + SHAPED;

/// Index of the first shape parameter.
pub(crate) const SHAPE: usize = 4 + FURTHER;

/// Longest step of the closed law, relative to the time scale on which the loss changes.
pub(super) const STEP: f64 = 0.3;
/// Maximum number of parts of one step of the closed law, and of an integrated step: a step that would need more than
/// the latter almost ends the motion between two points.
const MOST_PARTS: f64 = 64.0;
const MOST_INTEGRATED_PARTS: f64 = 24.0;
/// Length of a step with interpolation, as a part of the longest step: derivatives are then accurate to 1e-7.
const INTERPOLATED_PART: f64 = 0.7;
/// Maximum length of such a step, in durations requested.
const MOST_AHEAD: f64 = 64.0;
/// Maximum ratio of the rate of change of the loss at the end of such a step to that at its beginning.
const MOST_STIFFER: f64 = 2.0;
/// Relative half width of the central difference that gives the slope of a loss if a frequency shift modifies it.
const NEAR: f64 = 1e-4;
/// Order of the error of an integrated step.
const ORDER: f64 = 5.0;
/// Ratio of the initial to the present amplitude above which integrated steps are lengthened, and the largest ratio
/// taken into account.
const LONGER_STEPS_FROM: f64 = 4.0;
const MOST_AMPLITUDE_RATIO: f64 = 1e6;

/// The effective law for a shifted frequency: each term times its factor.
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
    /// Derivatives with respect to the initial amplitude, a0, a1, a2 and the further terms.
    pub(crate) by: [f64; CARRIED],
    law: AmplitudeLaw,
    /// Whether the closed form is the complete law.
    closed: bool,
    /// Relative shift of frequency per A² and A⁴, which changes the loss terms.
    backbone: [f64; 2],
    carried: Carried,
    /// The last step and its duration, for a law that does not change.
    last: (f64, Step),
    /// The current step of an integrated law.
    long: Option<LongStep<CARRIED>>,
}

/// Which derivatives are carried along.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) enum Carried {
    None,
    /// With respect to the initial amplitude, sliding, viscous and drag loss.
    Closed,
    /// Also with respect to the further terms.
    All,
}

impl Carried {
    /// The derivatives needed for these parameters; the list begins with the initial amplitude and the losses.
    pub(crate) fn for_parameters(parameters: &[usize]) -> Self {
        match parameters {
            [] => Self::None,
            list if list.iter().any(|k| (4..CARRIED).contains(k)) => Self::All,
            _ => Self::Closed,
        }
    }
}

/// Data shared by all steps of one duration.
#[derive(Debug, Clone, Copy)]
enum Step {
    Linear(LinearStep),
    Falling(FallingStep),
    Other,
}

/// Relative difference of durations that is attributed to rounding.
const SAME_STEP: f64 = 1e-12;

/// The propagator of `dA/dt = -(a0 + a1 A)` over one step: `A -> A e - a0 g`,
/// `e = e^(-a1 h)`, `g = (1 - e)/a1`.
#[derive(Debug, Clone, Copy)]
pub(super) struct LinearStep {
    duration: f64,
    e: f64,
    g: f64,
    /// `e` and `g` for half the step.
    half: [f64; 2],
}

impl LinearStep {
    fn new(a1: f64, duration: f64) -> Self {
        let h = duration;
        let x = 0.5 * a1 * h;
        // expm1 used twice: e^(-2x) - 1 = m (2 + m).
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

    /// The same path carrying only some of the derivatives.
    pub(crate) fn carrying(self, carried: Carried) -> Self {
        Self { carried, ..self }
    }

    /// The effective law at an amplitude, and the factors on its terms.
    fn local(&self, amplitude: f64) -> (AmplitudeLaw, PerTerm) {
        if self.backbone == [0.0; 2] {
            return (self.law, [1.0; TERMS]);
        }
        let f = backbone_factors(amplitude, self.backbone);
        (shifted(&self.law, &f), f)
    }

    /// Loss rate `-dA/dt` at the present amplitude.
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

    /// Rate at which the loss changes with the amplitude, 1/s.
    fn stiffness(&self) -> f64 {
        let a = self.amplitude;
        // Below zero amplitude the further losses keep their values at zero.
        if self.closed || a <= 0.0 {
            return self.law.a1.abs() + 2.0 * self.law.a2.abs() * a.abs();
        }
        // For losses that cancel, as a fit of many terms may try them, the change of their sum counts.
        self.law.rate_slope(a).abs().max(self.law.rate(a).abs() / a)
    }

    /// Moves on by `duration` seconds (backwards if negative).
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

    /// The step of a law that does not change; the previous one is reused if it was equally long.
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

    /// Number of parts of a step. For a closed law each part is exact, so that the parts only serve the derivatives.
    fn parts(&self, duration: f64) -> usize {
        let (step, most) =
            if self.closed { (STEP, MOST_PARTS) } else { (self.integrated_step(), MOST_INTEGRATED_PARTS) };
        let parts = (self.stiffness() * duration.abs() / step).min(most);
        // Rounded up, without a function call to `ceil`.
        let whole = parts as usize;
        (whole + usize::from((whole as f64) < parts)).max(1)
    }

    /// Longest step of an integrated law, relative to the time scale on which the loss changes. It may be longer at a
    /// small amplitude for the same error relative to the initial one: if a loss ends the motion, as `A^n` with
    /// `n < 1` does, the loss changes ever faster.
    fn integrated_step(&self) -> f64 {
        let ratio = self.law.initial / self.amplitude;
        let longer =
            if ratio > LONGER_STEPS_FROM { ratio.min(MOST_AMPLITUDE_RATIO).powf(1.0 / ORDER) } else { 1.0 };
        amplitude::STEP * longer
    }

    /// Steps of `duration` each, if only viscous and sliding loss act and the frequency is constant.
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

    /// One step of a law with drag and constant frequency.
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

    /// One step of any law, with its terms evaluated in the middle.
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

    /// Carries the derivatives over a step by Simpson's rule: `points` are the amplitudes at its beginning, middle
    /// and end, `slopes` the derivatives of the last with respect to each of them.
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

    /// The loss at an amplitude, and its derivatives with respect to the amplitude and all carried parameters. A loss
    /// with a shape parameter depends on the initial amplitude: `d/dA0 [A0 G(A/A0)] = G - u G'`.
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

/// Integrated laws, with steps of their own length.
impl AmplitudePath {
    /// Moves on in steps that do not end at the requested times, so that the amplitude is as smooth a function of the
    /// parameters as of time; returns the part of `duration` that remains if no such step can be taken.
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

    /// A step from the present amplitude; `None` if the loss changes too much along it.
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

    /// The loss, including the effect of the frequency shift.
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

/// Derivatives of the amplitude at the end of a step with respect to those at its beginning, middle and end: all lie
/// on one trajectory, so that each derivative is a ratio of the slopes `rates`.
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

    /// Times so close that a part of their distance underflows to zero.
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

    /// A frequency that overflows gives turning points at NaN or infinity.
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

    /// Losses with a fitted shape, including the shape parameter, over a long decay.
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
