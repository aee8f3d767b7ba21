//! Thresholds for what is reported of the models.

use crate::inference::criteria::criteria;

criteria! {
    /// Thresholds for the report on the models compared.
    pub struct ReportCriteria in "report" {
        /// Distance from its limit, in standard errors, within which a coefficient distorts the likelihood profile of
        /// another one, so that the interval is taken from the profile.
        near_limit: f64 = 3.0, source "beyond three the limit changes no 95 % interval",
            moves "coverage of losses beside one that is near zero";
        /// BIC difference below which two models explain the data equally well.
        rival_bic: f64 = 2.0, source "Kass and Raftery 1995: not worth more than a bare mention",
            moves "warnings";
        /// Factor by which losses absent from the model must widen an interval before they are named.
        mentioned_widening: f64 = 1.1, source "less does not show in two digits", moves "the report";
    }
}
