//! Estimation and inference: least squares, noise model, intervals, model comparison.

pub(crate) mod bounded;
pub(crate) mod coefficient;
pub(crate) mod covariance;
pub(crate) mod criteria;
pub(crate) mod evidence;
pub(crate) mod interval;
pub(crate) mod jackknife;
pub(crate) mod least_squares;
pub(crate) mod limited_step;
pub(crate) mod model_average;
pub(crate) mod model_selection;
pub(crate) mod noise;
pub(crate) mod noise_law;
pub(crate) mod normal;
pub(crate) mod profile;
pub(crate) mod quadratic;
pub(crate) mod smooth;

/// Two-sided 95 % point of the normal distribution.
pub(crate) const Z_95: f64 = 1.959_963_984_540_054;
