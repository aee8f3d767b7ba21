//! Least squares, intervals, evidence: the one place that knows statistics.

pub(crate) mod criteria;
pub(crate) mod evidence;
pub(crate) mod interval;
pub(crate) mod least_squares;
pub(crate) mod profile;

/// Two-sided 95 % point of the normal distribution.
pub(crate) const Z_95: f64 = 1.959_963_984_540_054;
