//! Thresholds of the law without a model.

use crate::inference::criteria::criteria;

criteria! {
    /// The law without a model.
    pub struct FreeLawCriteria in "free_law" {
        /// Amplitudes without which no law is drawn through them.
        least_points: usize = 12, source "four times the three unknowns of a start, a loss and its slope",
            moves "coverage of the law without a model";
        /// Amplitudes for each stretch of the curve with a curvature of its own.
        points_per_stretch: usize = 5, source "more stretches change no coverage",
            moves "coverage of the law without a model";
        /// Stretches of the curve at most.
        most_stretches: usize = 24, source "more stretches change no coverage",
            moves "coverage of the law without a model, time of analysis";
        /// Robust standard deviations beyond which an amplitude is left out.
        outlier_deviations: f64 = 8.0, source "as for the laws with a model",
            moves "spread with glitches";
    }
}
