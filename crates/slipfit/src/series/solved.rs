//! A measurement solved alone, as the comparison and the joint fit take it.

use nalgebra::{Matrix2, Vector2};

/// What one measurement says, limits lifted, in the common unit.
pub(super) struct SolvedMeasurement {
    pub(super) measurement: usize,
    pub(super) ring_down: bool,
    /// Damping rate and friction displacement.
    pub(super) value: Vector2<f64>,
    pub(super) covariance: Matrix2<f64>,
    /// Natural frequency, Hz, and its standard error.
    pub(super) frequency: Option<[f64; 2]>,
    /// Drive amplitude, its standard error, and its correlation with the two.
    pub(super) drive: Option<([f64; 2], [f64; 2])>,
}
