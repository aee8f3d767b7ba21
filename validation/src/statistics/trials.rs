//! Many simulated measurements of one oscillator, analysed, and the coverage of their intervals.

use std::ops::{Range, RangeInclusive};

use rand::SeedableRng;
use rand_chacha::ChaCha8Rng;
use rayon::prelude::*;
use slipfit::{Parameter, Quantity};

/// Headings of the columns that [`Summary::columns`] fills.
pub(super) const COLUMNS: &str = "δ bias | δ spread | δ covered | x_F bias | x_F spread | x_F covered";

/// True decay rate and friction displacement, with their Cramér-Rao standard errors.
#[derive(Debug, Clone, Copy)]
pub(super) struct Truth {
    pub(super) value: [f64; 2],
    pub(super) bound: [f64; 2],
}

/// One analysed measurement.
#[derive(Debug, Clone, Default)]
pub(super) struct Trial {
    /// Decay rate and friction displacement; `None` if the analysis refused.
    pub(super) estimates: Option<[Estimate; 2]>,
    pub(super) sliding_detected: bool,
    /// Q and x_F by the paper's inversion.
    pub(super) paper: Option<[f64; 2]>,
}

#[derive(Debug, Clone, Copy)]
pub(super) struct Estimate {
    /// The unbounded value, which may be negative.
    value: f64,
    /// Whether the reported 95 % interval covers the true value.
    covered: bool,
}

impl Truth {
    /// The estimates of an answer; `parameter` looks a parameter up in it.
    pub(super) fn estimates<'a>(
        &self,
        parameter: impl Fn(Parameter) -> Option<&'a Quantity>,
    ) -> Option<[Estimate; 2]> {
        let one = |asked: Parameter, truth: f64| {
            let quantity = parameter(asked)?;
            let [low, high] = quantity.interval_95;
            Some(Estimate { value: quantity.unbounded_value, covered: (low..=high).contains(&truth) })
        };
        let [delta, x_f] = self.value;
        Some([one(Parameter::DECAY_RATE, delta)?, one(Parameter::FRICTION_DISPLACEMENT, x_f)?])
    }
}

/// A measurement that can be simulated repeatedly with different noise.
pub(super) trait Experiment: Sync {
    /// Seed; different experiments have different noise.
    fn seed(&self) -> u64;
    /// Simulates one measurement and analyses it.
    fn trial(&self, rng: &mut ChaCha8Rng) -> Trial;
}

/// The trials with these seeds, on all cores.
pub(super) fn trials(experiment: &impl Experiment, seeds: Range<u64>) -> Vec<Trial> {
    let one = |seed: u64| {
        let mut rng = ChaCha8Rng::seed_from_u64(seed.wrapping_mul(0x9E37_79B9) ^ experiment.seed());
        experiment.trial(&mut rng)
    };
    seeds.into_par_iter().map(one).collect()
}

/// A seed from the parameters that distinguish an experiment from others.
pub(super) fn seed(start: u64, parts: &[f64]) -> u64 {
    parts.iter().fold(start, |seed, p| (seed ^ p.to_bits()).wrapping_mul(0x0000_0100_0000_01B3))
}

/// Statistics of one parameter.
#[derive(Debug, Clone, Copy)]
pub(super) struct Figures {
    /// Bias over the spread.
    bias: f64,
    /// Standard deviation over the Cramér-Rao bound.
    spread: f64,
    /// Share of the 95 % intervals that cover the true value.
    coverage: f64,
}

/// Statistics of the trials of one experiment.
#[derive(Debug, Clone)]
pub(super) struct Summary {
    pub(super) trials: usize,
    /// Decay rate and friction displacement.
    figures: [Figures; 2],
    /// Share of the trials in which sliding friction was detected.
    pub(super) detected: f64,
    refused: usize,
}

/// Requirements on an experiment.
#[derive(Debug, Clone)]
pub(super) struct Requirements {
    pub(super) bias_and_spread: bool,
    pub(super) coverage: RangeInclusive<f64>,
    /// There is no sliding friction, so none may be detected.
    pub(super) no_sliding: bool,
}

impl Requirements {
    /// Requirements under white noise alone.
    pub(super) fn of_white_noise(sliding: bool) -> Self {
        Self { bias_and_spread: true, coverage: 0.93..=0.97, no_sliding: !sliding }
    }
}

/// Marks a coverage that misses by no more than its own standard error.
pub(super) const WITHIN_CHANCE: &str = "(within chance)";

impl Summary {
    pub(super) fn of(trials: &[Trial], truth: &Truth) -> Self {
        let good: Vec<_> = trials.iter().filter_map(|trial| trial.estimates).collect();
        let figures = [0, 1].map(|k| {
            let values: Vec<f64> = good.iter().map(|estimates| estimates[k].value).collect();
            let (mean, deviation) = mean_and_deviation(&values);
            let covered = good.iter().filter(|estimates| estimates[k].covered).count();
            Figures {
                bias: (mean - truth.value[k]) / deviation,
                spread: deviation / truth.bound[k],
                coverage: covered as f64 / good.len() as f64,
            }
        });
        let detected = trials.iter().filter(|trial| trial.sliding_detected).count();
        Self {
            trials: trials.len(),
            figures,
            detected: detected as f64 / trials.len() as f64,
            refused: trials.len() - good.len(),
        }
    }

    /// All requirements that are not met.
    pub(super) fn misses(&self, requirements: &Requirements) -> Vec<String> {
        let mut misses = Vec::new();
        for (name, figures) in ["δ", "x_F"].into_iter().zip(self.figures) {
            if requirements.bias_and_spread && figures.bias.abs() > 0.15 {
                misses.push(format!("{name} bias"));
            }
            if requirements.bias_and_spread && figures.spread > 1.10 {
                misses.push(format!("{name} spread"));
            }
            if !requirements.coverage.contains(&figures.coverage) {
                let chance = coverage_error(self.trials);
                let (low, high) =
                    (requirements.coverage.start() - chance, requirements.coverage.end() + chance);
                let within = (low..=high).contains(&figures.coverage);
                misses.push(format!("{name} coverage {}", if within { WITHIN_CHANCE } else { "" }));
            }
        }
        if requirements.no_sliding && self.detected > 0.05 {
            misses.push("sliding claimed".into());
        }
        if self.refused > 0 {
            misses.push(format!("{} refused", self.refused));
        }
        misses.iter_mut().for_each(|miss| miss.truncate(miss.trim_end().len()));
        misses
    }

    /// The cells of a table under [`COLUMNS`].
    pub(super) fn columns(&self) -> String {
        let cells = self.figures.map(|Figures { bias, spread, coverage }| {
            format!("{bias:+.2} | {spread:.2} | {:.1} %", 100.0 * coverage)
        });
        cells.join(" | ")
    }

    /// One line for the terminal.
    pub(super) fn line(&self) -> String {
        let Self { trials, detected, refused, .. } = self;
        format!("{trials:6} trials | {} | detected {detected:.3}, refused {refused}", self.columns())
    }
}

/// Standard error of a coverage of 95 %.
pub(super) fn coverage_error(trials: usize) -> f64 {
    (0.95f64 * 0.05 / trials as f64).sqrt()
}

/// Mean and standard deviation of a sample.
pub(super) fn mean_and_deviation(values: &[f64]) -> (f64, f64) {
    let n = values.len() as f64;
    let mean = values.iter().sum::<f64>() / n;
    let variance = values.iter().map(|v| (v - mean).powi(2)).sum::<f64>() / (n - 1.0);
    (mean, variance.sqrt())
}

#[cfg(test)]
mod tests {
    use super::*;

    fn estimate(value: f64, covered: bool) -> Trial {
        let estimate = Estimate { value, covered };
        Trial { estimates: Some([estimate; 2]), ..Trial::default() }
    }

    #[test]
    fn bias_is_over_the_spread_and_spread_over_the_bound() {
        let truth = Truth { value: [1.0, 2.0], bound: [0.5, 1.0] };
        let trials = [estimate(1.0, true), estimate(2.0, true), estimate(3.0, false), Trial::default()];
        let summary = Summary::of(&trials, &truth);
        let [rate, friction] = summary.figures;
        assert_eq!((rate.bias, rate.spread), (1.0, 2.0));
        assert_eq!((friction.bias, friction.spread), (0.0, 1.0));
        assert_eq!(rate.coverage, 2.0 / 3.0);
        assert_eq!((summary.trials, summary.refused), (4, 1));
    }

    #[test]
    fn a_coverage_that_misses_by_its_own_error_is_marked() {
        let truth = Truth { value: [0.0; 2], bound: [1.0; 2] };
        let summary = |covered: usize| {
            let trials: Vec<Trial> =
                (0..100).map(|i| estimate(f64::from(i % 2) - 0.5, (i as usize) < covered)).collect();
            Summary::of(&trials, &truth).misses(&Requirements::of_white_noise(true)).join(", ")
        };
        assert_eq!(summary(95), "");
        assert_eq!(summary(92), "δ coverage (within chance), x_F coverage (within chance)");
        assert_eq!(summary(80), "δ coverage, x_F coverage");
    }
}
