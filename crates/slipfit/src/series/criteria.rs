//! Every threshold that decides in the comparison of several measurements.

use crate::inference::criteria::criteria;

criteria! {
    /// The thresholds of [`analyse_with`](super::analyse_with).
    pub struct Criteria in "series" {
        /// p value below which answers that are put together do not agree: a warning says so, and
        /// their variances grow by chi square over its degrees of freedom.
        disagree: f64 = 0.01, source "one series in a hundred of a single truth",
            moves "warnings, and errors of what is put together";
    }
}
