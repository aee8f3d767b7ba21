//! Everything from which an answer is assembled.

use super::criteria::Criteria;
use super::measured::MeasuredDecay;
use super::options::Options;
use super::samples::Samples;
use super::window_fit::WindowFit;
use crate::Record;

/// A record, the request and the results.
pub(crate) struct Evidence<'a> {
    pub(crate) record: &'a Record,
    pub(crate) options: &'a Options,
    pub(crate) criteria: &'a Criteria,
    pub(crate) samples: &'a Samples<'a>,
    pub(crate) measured: &'a MeasuredDecay,
    pub(crate) fit: &'a WindowFit<'a>,
    /// Number of cycles of the free decay.
    pub(crate) cycles: f64,
}
