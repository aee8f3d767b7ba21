//! Thresholds of the model-free law.

use crate::inference::criteria::criteria;

criteria! {
    /// The law without a model.
    pub struct FreeLawCriteria in "free_law" {
        /// Minimum number of amplitudes for which the law is estimated.
        least_points: usize = 12, source "four times the three unknowns of a start, a loss and its slope",
            moves "coverage of the law without a model";
        /// Number of amplitudes per stretch of the curve with its own curvature.
        points_per_stretch: usize = 5, source "more stretches change no coverage",
            moves "coverage of the law without a model";
        /// Maximum number of stretches of the curve.
        most_stretches: usize = 24, source "more stretches change no coverage",
            moves "coverage of the law without a model, time of analysis";
        /// Robust standard deviations beyond which an amplitude is rejected as an outlier.
        outlier_deviations: f64 = 8.0, source "as for the laws with a model",
            moves "spread with glitches";
    }
}
