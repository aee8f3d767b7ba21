//! Scores of the default analysis over many simulated measurements: coverage, errors, outliers without a warning,
//! false and missed friction, refusals.

use std::fmt::Write;

use slipfit::{Parameter, Quantity};

/// A parameter with its true value.
#[derive(Debug, Clone, Copy)]
pub(super) struct TrueValue {
    pub(super) parameter: Parameter,
    pub(super) value: f64,
}

/// Outcome of one measurement.
#[derive(Debug, Clone, Default)]
pub(super) struct Outcome {
    /// One per [`TrueValue`]; `None` if the analysis refused.
    pub(super) estimates: Option<Vec<Estimated>>,
    pub(super) warned: bool,
    pub(super) sliding_detected: bool,
    pub(super) drag_chosen: bool,
    /// Sum of squares of the reported motion minus that at the true parameters, over the variance of the noise;
    /// `None` if the samples were not compared with the motion.
    pub(super) above_truth: Option<f64>,
}

/// One reported value compared with its true value.
#[derive(Debug, Clone, Copy)]
pub(super) struct Estimated {
    error: f64,
    half_width: f64,
    /// Error over the reported standard error.
    pub(super) standard_errors: f64,
    pub(super) covered: bool,
}

/// Errors beyond this many of the reported standard errors are outliers.
const OUTLIER: f64 = 4.0;

impl Estimated {
    pub(super) fn of(quantity: &Quantity, truth: f64) -> Self {
        let error = quantity.value - truth;
        let [low, high] = quantity.interval_95;
        // Equal values agree, however narrow the interval.
        let tolerance = 1e-9 * truth.abs();
        Self {
            error,
            half_width: 0.5 * (high - low),
            standard_errors: if error.abs() <= tolerance { 0.0 } else { error.abs() / quantity.std_error },
            covered: (low - tolerance..=high + tolerance).contains(&truth),
        }
    }
}

/// Statistics over the outcomes of one cell.
#[derive(Debug, Clone)]
pub(super) struct Scores {
    /// Coverage by parameter.
    pub(super) coverage: Vec<f64>,
    /// Share of the answers with a parameter beyond [`OUTLIER`] standard errors and without a warning.
    pub(super) unwarned_outliers: f64,
    pub(super) warned: f64,
    pub(super) sliding_detected: f64,
    pub(super) drag_chosen: f64,
    pub(super) refused: f64,
    /// Root mean square of the error by parameter.
    pub(super) rms_error: Vec<f64>,
    /// Mean half width of the intervals by parameter.
    pub(super) half_width: Vec<f64>,
    /// Number of answers whose motion was compared with the samples, and of those that fit the samples worse than the
    /// true motion does.
    pub(super) compared: usize,
    pub(super) above_truth: usize,
    /// The largest excess, in variances of the noise.
    pub(super) worst_above_truth: f64,
}

/// A sum of squares that exceeds that of the true motion by less than this part of the noise variance is due to
/// rounding, or to the tolerance (a part of a standard error) at which fits stop.
const ABOVE_TRUTH: f64 = 1e-2;

impl Scores {
    pub(super) fn of(outcomes: &[Outcome], truth: &[TrueValue]) -> Self {
        let n = outcomes.len() as f64;
        let answered: Vec<&Vec<Estimated>> = outcomes.iter().filter_map(|o| o.estimates.as_ref()).collect();
        let mean = |f: &dyn Fn(&Vec<Estimated>) -> f64| {
            answered.iter().map(|e| f(e)).sum::<f64>() / answered.len() as f64
        };
        let share = |f: &dyn Fn(&Outcome) -> bool| outcomes.iter().filter(|o| f(o)).count() as f64 / n;
        let outlier = |o: &Outcome| {
            let far = |e: &Estimated| !(e.standard_errors <= OUTLIER);
            o.estimates.as_ref().is_some_and(|list| list.iter().any(far))
        };
        Self {
            coverage: (0..truth.len()).map(|k| mean(&|e| f64::from(u8::from(e[k].covered)))).collect(),
            unwarned_outliers: share(&|o| outlier(o) && !o.warned),
            warned: share(&|o| o.warned),
            sliding_detected: share(&|o| o.sliding_detected),
            drag_chosen: share(&|o| o.drag_chosen),
            refused: share(&|o| o.estimates.is_none()),
            rms_error: (0..truth.len()).map(|k| mean(&|e| e[k].error.powi(2)).sqrt()).collect(),
            half_width: (0..truth.len()).map(|k| mean(&|e| e[k].half_width)).collect(),
            worst_above_truth: outcomes.iter().filter_map(|o| o.above_truth).fold(0.0, f64::max),
            compared: outcomes.iter().filter(|o| o.above_truth.is_some()).count(),
            above_truth: outcomes
                .iter()
                .filter(|o| o.above_truth.is_some_and(|a| !(a < ABOVE_TRUTH)))
                .count(),
        }
    }

    /// The cells of a table row.
    pub(super) fn columns(&self) -> String {
        let mut text = String::new();
        for covered in &self.coverage {
            let _ = write!(text, "{:.1} % | ", 100.0 * covered);
        }
        let percent =
            [self.unwarned_outliers, self.sliding_detected, self.drag_chosen, self.refused, self.warned];
        let _ = write!(text, "{}", percent.map(|p| format!("{:.1} %", 100.0 * p)).join(" | "));
        text
    }
}

/// Means over cells, in percent; each cell comes with whether friction acts in it. Columns: coverage by parameter,
/// unwarned outliers, friction claimed and missed, drag, refusals and warnings.
pub(super) fn pooled(cells: &[(&Scores, bool)]) -> Vec<String> {
    let all = |share: &dyn Fn(&Scores) -> f64| mean_percent(cells.iter().map(|(scores, _)| share(scores)));
    let with = |friction: bool, share: &dyn Fn(&Scores) -> f64| {
        mean_percent(cells.iter().filter(|(_, acts)| *acts == friction).map(|(scores, _)| share(scores)))
    };
    let parameters = cells.first().map_or(0, |(scores, _)| scores.coverage.len());
    let mut text: Vec<String> = (0..parameters).map(|k| all(&|s| s.coverage[k])).collect();
    text.push(all(&|s| s.unwarned_outliers));
    text.push(with(false, &|s| s.sliding_detected));
    text.push(with(true, &|s| 1.0 - s.sliding_detected));
    text.push(all(&|s| s.drag_chosen));
    text.push(all(&|s| s.refused));
    text.push(all(&|s| s.warned));
    text
}

/// Mean of shares, in percent; a dash if there are none.
pub(super) fn mean_percent(shares: impl Iterator<Item = f64>) -> String {
    let (sum, count) = shares.fold((0.0, 0), |(sum, count), share| (sum + share, count + 1));
    if count == 0 { "–".to_owned() } else { format!("{:.1} %", 100.0 * sum / f64::from(count)) }
}
