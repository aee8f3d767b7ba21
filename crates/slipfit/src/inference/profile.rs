//! Intervals from the profile likelihood, i.e. the profile of the sum of squares.

use super::Z_95;
use super::interval::bounded_interval;
use super::least_squares::{Fit, LeastSquares, descend_within};
use super::noise::NoiseModel;
use super::quadratic::{QuadraticProfile, conditional_minimum};

/// A parameter with its interval.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct Estimate {
    pub(crate) value: f64,
    /// Value without limits on any parameter: unbiased and suitable for averaging.
    pub(crate) unbounded: f64,
    pub(crate) std_error: f64,
    pub(crate) interval: [f64; 2],
}

impl Estimate {
    /// Widens the interval to at least that of the standard error times Student's `factor`: the sum of squares rises
    /// toward another minimum, and its rise is not a likelihood ratio of a regular problem. Unchanged if the interval
    /// is narrower than one standard error, because two losses then explain the same data and the curvature at the
    /// optimum is meaningless.
    pub(crate) fn widened_to_std_error(self, factor: f64, [least, most]: [f64; 2]) -> Self {
        let half = Z_95 * factor * self.std_error;
        let [low, high] = self.interval;
        if !half.is_finite() || high - low < self.std_error {
            return self;
        }
        let lower = low.min((self.value - half).max(least));
        Self { interval: [lower, high.max((self.value + half).min(most))], ..self }
    }
}

/// Input of a profile.
pub(crate) struct Profile<'a> {
    pub(crate) problem: &'a dyn LeastSquares,
    /// The optimum; parameters at their limit may be fixed in it.
    pub(crate) fit: &'a Fit,
    /// The fit without limits, whose covariance is used to predict the profile.
    pub(crate) unbounded: &'a Fit,
    pub(crate) noise: NoiseModel,
    /// Range of possible values.
    pub(crate) range: [f64; 2],
    /// Other parameters that cannot be negative.
    pub(crate) non_negative: &'a [usize],
    /// Other minima of the same sum of squares, used as additional starts for the fits along the profile.
    pub(crate) other_minima: &'a [Fit],
}

/// Ratio of the sum of squares to its rounding part up to which rounding dominates.
const MOSTLY_ROUNDING: f64 = 2.0;

/// Distance from its limit, in standard errors, below which an estimate gets a profile.
const NEAR: f64 = 6.0;

impl Profile<'_> {
    /// Interval of a parameter that cannot be negative: near zero that of Feldman and Cousins in units of the signed
    /// root of the likelihood ratio, further away the ends of the profile. `curved` requests the profile also far from
    /// zero.
    pub(crate) fn non_negative(&self, parameter: usize, curved: bool) -> Estimate {
        let (value, std_error, unit, wide) = self.fit_and_errors(parameter);
        let unbounded = self.unbounded.parameters[parameter];
        let z = value / wide;
        if z >= NEAR && curved {
            return self.two_sided(parameter, true);
        }
        if !(z.is_finite() && wide.is_finite()) || z >= NEAR {
            return Estimate {
                value,
                unbounded,
                std_error,
                interval: [value - Z_95 * wide, value + Z_95 * wide],
            };
        }
        if self.is_rounding() {
            let interval = bounded_interval(z).map(|end| end * wide);
            return Estimate { value, unbounded, std_error, interval };
        }
        let root = Root::new(self, parameter, unit);
        // At its limit the optimum itself is the fit at zero.
        let distance = if value == 0.0 { 0.0 } else { root.at(0.0).map_or(z, |r| -r) };
        let [low, high] = bounded_interval(distance);
        let lower = if low <= 0.0 { 0.0 } else { root.find(low - distance, wide).max(0.0) };
        let upper = root.find(high - distance, wide).max(0.0);
        Estimate { value, unbounded, std_error, interval: [lower, upper] }
    }

    /// Two-sided interval from the profile, or `1.96` standard errors.
    pub(crate) fn two_sided(&self, parameter: usize, curved: bool) -> Estimate {
        let (value, std_error, unit, wide) = self.fit_and_errors(parameter);
        let unbounded = self.unbounded.parameters[parameter];
        let interval = if curved && wide.is_finite() && !self.is_rounding() {
            let root = Root::new(self, parameter, unit);
            [root.find(-Z_95, wide), root.find(Z_95, wide)]
        } else {
            [value - Z_95 * wide, value + Z_95 * wide]
        };
        Estimate { value, unbounded, std_error, interval }
    }

    /// Whether the residuals of the optimum are hardly more than rounding; within such small errors nothing is curved.
    fn is_rounding(&self) -> bool {
        self.fit.rss <= MOSTLY_ROUNDING * self.problem.rounding()
    }

    fn fit_and_errors(&self, parameter: usize) -> (f64, f64, f64, f64) {
        let factor = self.noise.student_factor(self.fit);
        let std_error = known(self.noise.std_error(self.fit, parameter));
        let unit = self.noise.variance(self.fit).sqrt() * factor;
        (self.fit.parameters[parameter], std_error, unit, known(std_error * factor))
    }
}

/// If not even a variance can be computed, the error is infinite.
fn known(error: f64) -> f64 {
    if error.is_nan() { f64::INFINITY } else { error }
}

/// Deviation of the signed root from its target below which a straight line through the origin gives the remaining
/// correction.
const ROOT_TOLERANCE: f64 = 0.1;
/// Accuracy of a fit along the profile, in standard errors.
const FIT_TOLERANCE: f64 = 0.05;
/// Root above which the fit is also started at the optimum; it exceeds the root at every end of an interval.
const FAR_ROOT: f64 = 4.0;
/// Accuracy of the root of the quadratic form, which only provides the start of the search.
const GUESS_TOLERANCE: f64 = 0.02;
const MOST_TRIALS: usize = 14;

struct Root<'a> {
    profile: &'a Profile<'a>,
    parameter: usize,
    unit: f64,
    quadratic: QuadraticProfile<'a>,
}

impl<'a> Root<'a> {
    fn new(profile: &'a Profile<'a>, parameter: usize, unit: f64) -> Self {
        let quadratic = QuadraticProfile::new(profile.unbounded, parameter, profile.non_negative);
        Self { profile, parameter, unit, quadratic }
    }

    fn centre(&self) -> f64 {
        self.profile.fit.parameters[self.parameter]
    }

    /// Root of the likelihood ratio for a sum of squares.
    fn root_of(&self, rss: f64) -> f64 {
        (rss - self.profile.fit.rss).max(0.0).sqrt() / self.unit
    }

    /// The outermost of the other minima on the side of `target` and below it: its value, its root, and the position of
    /// the target predicted by its curvature.
    fn outermost_minimum(&self, target: f64) -> Option<[f64; 3]> {
        let of = |other: &Fit| {
            let (value, root) = (other.parameters[self.parameter], self.root_of(other.rss));
            let left = (target * target - root * root).sqrt();
            let step = (left * self.unit * other.unit_std(self.parameter)).copysign(target);
            ((value - self.centre()) * target > 0.0 && root < target.abs())
                .then(|| [value, root.copysign(target), value + step])
        };
        let far = |m: &[f64; 3]| (m[0] - self.centre()).abs();
        self.profile.other_minima.iter().filter_map(of).max_by(|a, b| far(a).total_cmp(&far(b)))
    }

    /// Signed root of the likelihood ratio at a fixed value of the parameter; `None` if the model does not exist or the
    /// work allowed for the search is used up.
    fn at(&self, value: f64) -> Option<f64> {
        let Profile { problem, fit, unbounded, non_negative, other_minima, .. } = *self.profile;
        let free: Vec<usize> = unbounded.free.iter().copied().filter(|&i| i != self.parameter).collect();
        let rss = |start: &[f64], free: &[usize]| {
            descend_within(problem, start, free, non_negative, FIT_TOLERANCE).map(|(_, sums, _)| sums.rss)
        };
        let predicted = self.quadratic.at(value).and_then(|near| {
            let moving: Vec<usize> = free.iter().copied().filter(|i| !near.on_limit.contains(i)).collect();
            rss(&near.parameters, &moving)
        });
        let root = |rss: f64| self.root_of(rss);
        // At such a distance a search along the curved valleys of a limited parameter may have stopped short of the
        // minimum; for problems without limits the extra work is not needed.
        let limited = || unbounded.free.iter().any(|i| problem.range(*i)[1].is_finite());
        let near = predicted.filter(|rss| root(*rss) < FAR_ROOT || !limited());
        let found = near.or_else(|| {
            let mut plain = fit.parameters.clone();
            plain[self.parameter] = value;
            [predicted, rss(&plain, &free)].into_iter().flatten().min_by(f64::total_cmp)
        });
        let from_another =
            |other: &Fit| rss(&conditional_minimum(other, &[(self.parameter, value)])?.1, &free);
        let found =
            found.into_iter().chain(other_minima.iter().filter_map(from_another)).min_by(f64::total_cmp);
        if problem.is_spent() {
            return None;
        }
        Some((value - self.centre()).signum() * root(found?))
    }

    /// The same root, predicted by the quadratic form.
    fn predicted(&self, value: f64) -> Option<f64> {
        let least = self.quadratic.at(self.centre())?.rise;
        let rise = (self.quadratic.at(value)?.rise - least).max(0.0);
        Some((value - self.centre()).signum() * rise.sqrt() / self.unit)
    }

    /// Approximate position of the root according to the quadratic form; `wide` per unit of the root if the form gives
    /// none.
    fn guess(&self, target: f64, wide: f64) -> f64 {
        let centre = self.centre();
        let plain = centre + target * wide;
        let (mut inner, mut outer) = ((centre, 0.0), None);
        let mut value = plain;
        for _ in 0..MOST_TRIALS {
            let Some(root) = self.predicted(value) else { return plain };
            if (root - target).abs() < GUESS_TOLERANCE {
                return value;
            }
            if root.abs() < target.abs() {
                inner = (value, root);
            } else {
                outer = Some((value, root));
            }
            value = match outer {
                Some(outer) => between(inner, outer, target),
                None => centre + 2.0 * (value - centre),
            };
        }
        value
    }

    /// The value at which the root is `target`, clipped to the range.
    fn find(&self, target: f64, wide: f64) -> f64 {
        let centre = self.centre();
        let [least, most] = self.profile.range;
        let limit = if target < 0.0 { least } else { most };
        if target == 0.0 || !((limit - centre) * target > 0.0) {
            return centre;
        }
        let clip = |v: f64| if target < 0.0 { v.max(limit) } else { v.min(limit) };
        // The inner end lies short of the target; the outer end, once found, lies beyond it.
        let another = self.outermost_minimum(target);
        let (mut inner, mut inner_root) = another.map_or((centre, 0.0), |[value, root, _]| (value, root));
        let mut outer: Option<(f64, f64)> = None;
        let mut value = clip(another.map_or_else(|| self.guess(target, wide), |[_, _, end]| end));
        for _ in 0..MOST_TRIALS {
            let found = self.at(value);
            if found.is_none() && self.profile.problem.is_spent() {
                // Prediction of the quadratic form, but not inside the values already known to lie within the interval.
                let guess = clip(self.guess(target, wide));
                return if (guess - inner) * target > 0.0 { guess } else { inner };
            }
            let root = found.unwrap_or(f64::INFINITY * target.signum());
            if (root - target).abs() < ROOT_TOLERANCE {
                return clip(centre + (value - centre) * target / root);
            }
            if root * target.signum() < target.abs() {
                if value == limit {
                    return limit;
                }
                (inner, inner_root) = (value, root);
                value = match outer {
                    Some(o) => between((inner, inner_root), o, target),
                    None => {
                        let slope = if root == 0.0 { 0.25 } else { (root / target).clamp(0.25, 0.95) };
                        clip(centre + (value - centre) / slope * 1.02)
                    }
                };
            } else {
                outer = Some((value, root));
                value = between((inner, inner_root), (value, root), target);
            }
        }
        value
    }
}

/// A point between two that bracket the target, by linear interpolation, kept away from the ends.
fn between((a, root_a): (f64, f64), (b, root_b): (f64, f64), target: f64) -> f64 {
    let t = if root_b.is_finite() { ((target - root_a) / (root_b - root_a)).clamp(0.05, 0.95) } else { 0.5 };
    a + t * (b - a)
}

#[cfg(test)]
mod tests {
    use super::super::least_squares::{Normal, minimise};
    use super::*;

    /// `y = a + b³ x`: linear in `b³`, so the profile of `b` is a nonlinear transform of that of `b³`.
    struct Cubic {
        points: Vec<(f64, f64)>,
    }

    impl LeastSquares for Cubic {
        fn parameters(&self) -> usize {
            2
        }
        fn observations(&self) -> f64 {
            self.points.len() as f64
        }
        fn normal(&self, p: &[f64], out: &mut Normal) -> bool {
            out.clear();
            for &(x, y) in &self.points {
                out.add_row(&[1.0, 3.0 * p[1] * p[1] * x], y - (p[0] + p[1].powi(3) * x), 1.0);
            }
            true
        }
    }

    #[test]
    fn a_bent_parameter_has_the_bent_interval() {
        let noise = |i: i32| f64::from((i * 7919) % 101 - 50) / 50.0;
        let points = (0..200)
            .map(|i| (f64::from(i % 20) - 9.5, 0.3 + 0.5 * (f64::from(i % 20) - 9.5) + 4.0 * noise(i)));
        let problem = Cubic { points: points.collect() };
        let fit = minimise(&problem, &[0.0, 1.0], &[0, 1]).unwrap();
        let noise_model = NoiseModel::white(200.0);
        let range = [f64::NEG_INFINITY, f64::INFINITY];
        let e = Profile {
            problem: &problem,
            fit: &fit,
            unbounded: &fit,
            noise: noise_model,
            range,
            non_negative: &[],
            other_minima: &[],
        }
        .two_sided(1, true);
        // The interval is symmetric in b³.
        let [low, high] = e.interval.map(|b| b.powi(3));
        let centre = e.value.powi(3);
        assert!(((high - centre) / (centre - low) - 1.0).abs() < 0.02, "{low} {centre} {high}");
        let straight = 3.0 * e.value * e.value * e.std_error * Z_95;
        assert!(((high - low) / (2.0 * straight) - 1.0).abs() < 0.05);
    }

    /// A problem that allows a limited number of passes.
    struct Limited {
        problem: Cubic,
        left: std::cell::Cell<usize>,
    }

    impl LeastSquares for Limited {
        fn parameters(&self) -> usize {
            self.problem.parameters()
        }
        fn observations(&self) -> f64 {
            self.problem.observations()
        }
        fn is_spent(&self) -> bool {
            self.left.get() == 0
        }
        fn normal(&self, p: &[f64], out: &mut Normal) -> bool {
            self.left.set(self.left.get().saturating_sub(1));
            !self.is_spent() && self.problem.normal(p, out)
        }
    }

    #[test]
    fn where_the_work_is_used_up_the_quadratic_form_gives_the_interval() {
        let points = (0..200).map(|i| (f64::from(i % 20) - 9.5, f64::from((i * 7919) % 101)));
        let problem = Cubic { points: points.collect() };
        let fit = minimise(&problem, &[0.0, 1.0], &[0, 1]).unwrap();
        let problem = Limited { problem, left: std::cell::Cell::new(0) };
        let noise = NoiseModel::white(200.0);
        let straight = Z_95 * noise.student_factor(&fit) * noise.std_error(&fit, 1);
        for passes in 0..30 {
            problem.left.set(passes);
            let range = [f64::NEG_INFINITY, f64::INFINITY];
            let p = Profile {
                problem: &problem,
                fit: &fit,
                unbounded: &fit,
                noise,
                range,
                non_negative: &[],
                other_minima: &[],
            };
            let [low, high] = p.two_sided(1, true).interval;
            assert!(low < fit.parameters[1] - 0.5 * straight, "{passes}: {low}");
            assert!(high > fit.parameters[1] + 0.5 * straight, "{passes}: {high}");
        }
    }

    #[test]
    fn beside_other_minima_the_standard_error_is_the_least_half_width() {
        let found = Estimate { value: 1.0, unbounded: 1.0, std_error: 1.0, interval: [0.9, 4.0] };
        let wide = found.widened_to_std_error(1.0, [0.0, 5.0]);
        assert_eq!(wide.interval, [0.0, 4.0]);
        let unknown = Estimate { std_error: f64::INFINITY, ..found };
        assert_eq!(unknown.widened_to_std_error(1.0, [0.0, 5.0]), unknown);
        let degenerate = Estimate { std_error: 1e3, ..found };
        assert_eq!(degenerate.widened_to_std_error(1.0, [0.0, 5.0]), degenerate);
        assert_eq!(found.widened_to_std_error(2.5, [0.0, 5.0]).interval, [0.0, 5.0]);
    }

    #[test]
    fn a_range_ends_the_interval() {
        let problem = Cubic { points: (0..20).map(|i| (f64::from(i % 3), f64::from(i % 5))).collect() };
        let fit = minimise(&problem, &[0.0, 1.0], &[0, 1]).unwrap();
        let noise = NoiseModel::white(20.0);
        let most = fit.parameters[1] + 1e-3;
        let p = Profile {
            problem: &problem,
            fit: &fit,
            unbounded: &fit,
            noise,
            range: [0.0, most],
            non_negative: &[],
            other_minima: &[],
        };
        assert_eq!(p.two_sided(1, true).interval[1], most);
    }
}
