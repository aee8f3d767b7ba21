//! Every threshold that decides in the comparison of several measurements.

use crate::inference::criteria::criteria;

criteria! {
    /// The thresholds of [`analyse_with`](super::analyse_with).
    pub struct Criteria in "series" {
        /// p value below which answers that are put together do not agree: a warning is given, and the scatter of repeats
        /// is stated. Errors count that scatter in any case.
        disagree: f64 = 0.01, source "one series in a hundred of a single truth",
            moves "warnings, and whether the scatter of repeats is stated";
        /// What a drag shared by all measurements costs, in minus twice the logarithm of the likelihood.
        drag_penalty: f64 = 1.0, source "chosen by simulation, drag of 5 to 40 % of the viscous loss", moves "coverage with drag, and width of intervals without it";
        /// Difference of BIC from which on a law of friction against load is excluded.
        law_excluded: f64 = 6.0, source "strong evidence on the scale of Kass and Raftery (1995)",
            moves "the sentence of a series";
    }
}
