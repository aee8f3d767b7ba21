//! Thresholds of what every analysis reports about its models.

use crate::inference::criteria::criteria;

criteria! {
    /// What is reported of the models that were compared.
    pub struct ReportCriteria in "report" {
        /// Standard errors above its limit within which a coefficient bends the profile of another, so that
        /// the interval is the profile's.
        near_limit: f64 = 3.0, source "beyond three the limit changes no 95 % interval",
            moves "coverage of losses beside one that is near zero";
        /// Difference of BIC below which two models explain the data equally well.
        rival_bic: f64 = 2.0, source "Kass and Raftery 1995: not worth more than a bare mention",
            moves "warnings";
        /// Widening of an interval by losses that the model has not, above which they are named.
        mentioned_widening: f64 = 1.1, source "less does not show in two digits", moves "the report";
    }
}
