//! Scatter of repeats beyond their errors, estimated as in a random-effects meta-analysis.

use super::answer::RepeatScatter;
use super::criteria::Criteria;
use super::likelihood::{hartung_knapp_factor, lowest, weights};
use super::solved::SolvedMeasurement;
use crate::inference::evidence::{chi_square_tail, student_factor};
use nalgebra::{Matrix2, Vector2};

/// Measurements with the same expected value, and their arithmetic mean.
pub(super) struct Repeats<'a> {
    pub(super) list: Vec<&'a SolvedMeasurement>,
    pub(super) level: Vector2<f64>,
}

/// A mean of repeats, with the degrees of freedom of its estimated errors.
#[derive(Clone, Copy)]
pub(super) struct Mean {
    pub(super) value: Vector2<f64>,
    pub(super) covariance: Matrix2<f64>,
    /// Shift by one standard error of the disturbance common to all means; it is part of the covariance.
    pub(super) shared: Vector2<f64>,
    /// For damping and friction; infinite if the errors of the measurements explain everything.
    pub(super) freedom: [f64; 2],
    /// Minimum of the half width of an interval over that of a normal one.
    spread: f64,
}

impl Mean {
    /// Covariance of its difference from another mean; the common disturbance partly cancels.
    pub(super) fn covariance_from(&self, other: &Self) -> Matrix2<f64> {
        let both = self.shared * other.shared.transpose();
        self.covariance + other.covariance - both - both.transpose()
    }

    /// Standard error without the common disturbance.
    pub(super) fn own_error(&self, k: usize) -> f64 {
        (self.covariance[(k, k)] - self.shared[k].powi(2)).max(0.0).sqrt()
    }

    /// Standard error of damping or friction, and the value that replaces it in an interval.
    pub(super) fn errors(&self, k: usize) -> [f64; 2] {
        let std_error = self.covariance[(k, k)].sqrt();
        [std_error, std_error * student_factor(self.freedom[k]).max(self.spread)]
    }
}

/// Combined repeats.
struct CombinedRepeats {
    value: Vector2<f64>,
    covariance: Matrix2<f64>,
    shared: Vector2<f64>,
    /// Chi square of the repeats about their mean.
    chi_square: f64,
    /// Log determinant of all covariances, plus that of the weight of the mean, which restricts the likelihood.
    logarithms: f64,
}

/// Scatter of damping and friction between repeats, common to all conditions.
pub(super) struct Scatter {
    /// Constant scatter, and scatter proportional to the values, each with its weight.
    shapes: [(Shape, f64); 2],
    /// Number of repeats beyond the first of each condition.
    pub(super) freedom: f64,
    /// Chi square per quantity of the repeats about their means, including this scatter.
    pub(super) chi_square: f64,
}

/// Standard deviations of damping and friction.
#[derive(Clone, Copy, Default)]
struct Shape {
    deviation: [f64; 2],
    /// Values for which these deviations hold, if they are proportional to the values.
    largest: Option<Vector2<f64>>,
}

impl<'a> Repeats<'a> {
    pub(super) fn new(list: Vec<&'a SolvedMeasurement>) -> Self {
        let level = list.iter().map(|s| s.value).sum::<Vector2<f64>>() / list.len().max(1) as f64;
        Self { list, level }
    }

    /// Their mean, weighted by their covariances (each with `more` added) and including the common disturbance:
    /// generalised least squares with the disturbance as a further unknown, 0 ± 1. `None` if double precision is not
    /// sufficient.
    fn combined(&self, more: &Matrix2<f64>) -> Option<CombinedRepeats> {
        let (mut weight, mut sum, mut logarithms) = (Matrix2::zeros(), Vector2::zeros(), 0.0);
        let (mut cross, mut own, mut moved) = (Vector2::zeros(), 1.0, 0.0);
        for s in &self.list {
            let covariance = s.covariance + more;
            let inverse = covariance.try_inverse()?;
            weight += inverse;
            sum += inverse * s.value;
            cross += inverse * s.shared;
            own += s.shared.dot(&(inverse * s.shared));
            moved += s.shared.dot(&(inverse * s.value));
            logarithms += covariance.determinant().ln();
        }
        let given = weight.try_inverse()?;
        // Solution for the further unknown, with the mean eliminated.
        let precision = own - cross.dot(&(given * cross));
        let further = (moved - cross.dot(&(given * sum))) / precision;
        let value = given * (sum - cross * further);
        let shared = given * cross / precision;
        let covariance = given + shared * shared.transpose() * precision;
        let off = |s: &&SolvedMeasurement| {
            let d = s.value - value - s.shared * further;
            Some((d.transpose() * (s.covariance + more).try_inverse()? * d)[0])
        };
        let chi_square = self.list.iter().filter_map(off).sum::<f64>() + further * further;
        let held = value.iter().all(|v| v.is_finite())
            && covariance.diagonal().iter().all(|v| v.is_normal() && *v > 0.0);
        let logarithms = logarithms - given.determinant().ln() + precision.ln();
        held.then_some(CombinedRepeats { value, covariance, shared, chi_square, logarithms })
    }

    /// Their mean, including the scatter of repeats, and Satterthwaite's degrees of freedom of its variances.
    pub(super) fn mean(&self, scatter: &Scatter) -> Option<Mean> {
        let bare = self.combined(&Matrix2::zeros())?;
        let CombinedRepeats { value, covariance, shared, .. } =
            self.combined(&scatter.covariance(self.level))?;
        let freedom = [0, 1].map(|k| {
            let share = 1.0 - bare.covariance[(k, k)] / covariance[(k, k)];
            if share > 0.0 { scatter.freedom / (share * share) } else { f64::INFINITY }
        });
        Some(Mean { value, covariance, shared, freedom, spread: scatter.spread() })
    }
}

impl Shape {
    /// Deviations at a level, relative to the largest ones.
    fn share(&self, level: Vector2<f64>) -> Vector2<f64> {
        self.largest.map_or(Vector2::repeat(1.0), |largest| level.abs().component_div(&largest))
    }

    fn covariance(&self, level: Vector2<f64>) -> Matrix2<f64> {
        let share = self.share(level);
        Matrix2::from_diagonal(&Vector2::from_fn(|k, _| (self.deviation[k] * share[k]).powi(2)))
    }

    /// The likeliest deviations, and minus twice their restricted log-likelihood.
    fn likeliest(largest: Option<Vector2<f64>>, several: &[&Repeats<'_>]) -> (Self, f64) {
        let (mut shape, mut least) = (Self { largest, ..Self::default() }, f64::INFINITY);
        // Damping and friction are optimised in turn until neither improves.
        for _ in 0..ROUNDS {
            let before = least;
            for k in [1, 0] {
                let apart = |r: &&Repeats<'_>| {
                    let far = r.list.iter().map(|s| (s.value[k] - r.level[k]).abs()).fold(0.0, f64::max);
                    far / shape.share(r.level)[k].max(f64::MIN_POSITIVE)
                };
                let highest = several.iter().map(apart).filter(|v| v.is_finite()).fold(0.0, f64::max);
                let with = |deviation: f64| {
                    let mut tried = shape;
                    tried.deviation[k] = deviation;
                    let deviance = |r: &&Repeats<'_>| {
                        let together = r.combined(&tried.covariance(r.level))?;
                        Some(together.chi_square + together.logarithms)
                    };
                    several.iter().map(deviance).sum::<Option<f64>>().unwrap_or(f64::INFINITY)
                };
                (shape.deviation[k], least) = lowest(LARGEST_SCATTER * highest, with);
            }
            if !(before - least > SETTLED) {
                break;
            }
        }
        (shape, least)
    }
}

impl Scatter {
    /// Estimated by restricted maximum likelihood from all repeats together, since there are few for each condition.
    pub(super) fn of<'a>(all: impl IntoIterator<Item = &'a Repeats<'a>>) -> Self {
        let all: Vec<&Repeats<'_>> = all.into_iter().filter(|r| !r.list.is_empty()).collect();
        let several: Vec<&Repeats<'_>> = all.iter().copied().filter(|r| r.list.len() > 1).collect();
        let largest = all.iter().map(|r| r.level.abs()).reduce(|a, b| a.sup(&b));
        let largest = largest.filter(|l| l.iter().all(|v| *v > 0.0));
        let [same, proportional] = [None, largest].map(|largest| Shape::likeliest(largest, &several));
        let weights = weights([same.1, proportional.1]);
        let mut scatter = Self {
            shapes: [(same.0, weights[0]), (proportional.0, weights[1])],
            freedom: several.iter().map(|r| r.list.len() as f64 - 1.0).sum(),
            chi_square: 0.0,
        };
        let chi_square = |r: &&Repeats<'_>| Some(0.5 * r.combined(&scatter.covariance(r.level))?.chi_square);
        scatter.chi_square = several.iter().filter_map(chi_square).sum();
        scatter
    }

    /// Minimum of the half width of an interval over that of a normal one.
    pub(super) fn spread(&self) -> f64 {
        hartung_knapp_factor(self.chi_square / self.freedom, self.freedom)
    }

    /// The scatter relative to the values, if the errors alone do not explain the spread of repeats about their
    /// means.
    pub(super) fn relative(&self, all: &[Repeats<'_>], criteria: &Criteria) -> Option<RepeatScatter> {
        let chi_square: f64 =
            all.iter().filter_map(|r| Some(r.combined(&Matrix2::zeros())?.chi_square)).sum();
        if !(self.freedom > 0.0 && chi_square_tail(chi_square, 2.0 * self.freedom) < criteria.disagree) {
            return None;
        }
        let there = || all.iter().filter(|r| !r.list.is_empty());
        let [damping, friction] = [0, 1].map(|k| {
            let square: f64 = there().map(|r| self.covariance(r.level)[(k, k)]).sum();
            (square / there().map(|r| r.level[k].powi(2)).sum::<f64>()).sqrt()
        });
        Some(RepeatScatter { friction, damping, repeats: self.freedom as usize })
    }

    /// The contribution to the covariance of one measurement.
    pub(super) fn covariance(&self, level: Vector2<f64>) -> Matrix2<f64> {
        self.shapes.iter().map(|(shape, weight)| shape.covariance(level) * *weight).sum()
    }
}

/// Maximum number of passes over both quantities.
const ROUNDS: usize = 8;
/// Gain in twice the log-likelihood below which the iteration ends.
const SETTLED: f64 = 1e-3;
/// Largest scatter tried, relative to the largest deviation.
const LARGEST_SCATTER: f64 = 4.0;

#[cfg(test)]
mod tests {
    use super::*;
    use crate::noise::jitter;

    fn measured(value: [f64; 2], covariance: Matrix2<f64>) -> SolvedMeasurement {
        let value = Vector2::from(value);
        let shared = Vector2::zeros();
        SolvedMeasurement {
            measurement: 0,
            ring_down: true,
            value,
            covariance,
            shared,
            frequency: [1.0, 0.0],
            drive: None,
        }
    }

    /// Five loads three times each; friction scatters by 5 %, with errors correlated as in ring-downs. Earlier, the
    /// errors of damping, which does not scatter, were eight times too large, and those of friction twice.
    #[test]
    fn what_scatters_is_less_sure_and_nothing_else() {
        const RUNS: u64 = 300;
        const ERROR: f64 = 0.01;
        let covariance = Matrix2::new(1.0, -0.9, -0.9, 1.0) * (ERROR * ERROR);
        let mut found = [0, 1].map(|_| (0.0, 0.0, 0));
        let mut said = [0.0; 2];
        for seed in 0..RUNS {
            let normal = |i: usize| jitter(i, seed);
            let loads: Vec<Vec<SolvedMeasurement>> = (0..5)
                .map(|load| {
                    let repeat = |k: usize| {
                        let i = 100 * load + 10 * k;
                        let damping = ERROR * normal(i);
                        let error = -0.9 * damping + ERROR * 0.19_f64.sqrt() * normal(i + 1);
                        let friction = (load as f64 + 1.0) * (1.0 + 0.05 * normal(i + 2));
                        measured([1.0 + damping, friction + error], covariance)
                    };
                    (0..3).map(repeat).collect()
                })
                .collect();
            let all: Vec<Repeats<'_>> = loads.iter().map(|l| Repeats::new(l.iter().collect())).collect();
            let scatter = Scatter::of(&all);
            let stated = scatter.relative(&all, &Criteria::default()).unwrap();
            said[0] += stated.damping / RUNS as f64;
            said[1] += stated.friction / RUNS as f64;
            for (load, repeats) in all.iter().enumerate() {
                let mean = repeats.mean(&scatter).unwrap();
                for (k, truth) in [1.0, load as f64 + 1.0].into_iter().enumerate() {
                    let [error, wide] = mean.errors(k);
                    let off = (mean.value[k] - truth) / (load as f64 + 1.0).powi(k as i32);
                    let relative = error / (load as f64 + 1.0).powi(k as i32);
                    let (square, variance, held) = found[k];
                    let holds = (mean.value[k] - truth).abs() <= 1.96 * wide;
                    found[k] =
                        (square + off * off, variance + relative * relative, held + usize::from(holds));
                }
            }
        }
        assert!(said[0] < 0.005 && (0.04..0.055).contains(&said[1]), "{said:?}");
        for (square, variance, held) in found {
            let ratio = (variance / square).sqrt();
            assert!((0.85..1.25).contains(&ratio), "{ratio}");
            let held = held as f64 / (5 * RUNS) as f64;
            assert!((0.93..0.985).contains(&held), "{held}");
        }
    }

    /// Without scatter the errors are those of the mean alone.
    #[test]
    fn repeats_that_agree_have_the_error_of_their_mean() {
        let covariance = Matrix2::new(1.0, -0.9, -0.9, 1.0);
        let list = [[0.1, 9.9], [-0.1, 10.1], [0.0, 10.0]].map(|v| measured(v, covariance));
        let repeats = Repeats::new(list.iter().collect());
        let scatter = Scatter::of([&repeats]);
        let mean = repeats.mean(&scatter).unwrap();
        assert_eq!(scatter.relative(&[repeats], &Criteria::default()), None);
        for k in [0, 1] {
            let [error, wide] = mean.errors(k);
            assert!((error - (1.0_f64 / 3.0).sqrt()).abs() < 1e-12, "{error}");
            assert_eq!(error, wide);
        }
    }
}
