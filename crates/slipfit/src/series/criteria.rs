//! Thresholds that decide in the comparison of several measurements.

use crate::inference::criteria::criteria;

criteria! {
    /// The thresholds of [`analyse_with`](super::analyse_with).
    pub struct Criteria in "series" {
        /// p value below which combined answers disagree: a warning is given, and the scatter of repeats is reported.
        /// Errors include that scatter in any case.
        disagree: f64 = 0.01, source "one series in a hundred of a single truth",
            moves "warnings, and whether the scatter of repeats is stated";
        /// Penalty for a drag shared by all measurements, in minus twice the logarithm of the likelihood.
        drag_penalty: f64 = 1.0, source "chosen by simulation, drag of 5 to 40 % of the viscous loss", moves "coverage with drag, and width of intervals without it";
        /// Difference of BIC above which a law of friction against load is excluded.
        law_excluded: f64 = 6.0, source "strong evidence on the scale of Kass and Raftery (1995)",
            moves "the sentence of a series";
    }
}
