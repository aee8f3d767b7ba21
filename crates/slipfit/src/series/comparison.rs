//! Comparison of ring-down and resonance at one condition.

use super::answer::Consistency;
use super::scatter::Mean;
use crate::inference::evidence::scaled_tail;

/// Chi square of differences.
pub(super) struct Difference {
    chi_square: f64,
    compared: f64,
    /// Degrees of freedom of the errors.
    freedom: f64,
}

impl Difference {
    pub(super) fn and(self, other: Self) -> Self {
        Self {
            chi_square: self.chi_square + other.chi_square,
            compared: self.compared + other.compared,
            freedom: self.freedom.min(other.freedom),
        }
    }

    pub(super) fn p_value(self) -> f64 {
        scaled_tail(self.chi_square, self.compared, self.freedom)
    }
}

/// Means by ring-down and by resonance.
#[derive(Clone, Copy)]
pub(super) struct Pair {
    pub(super) ring_down: Mean,
    pub(super) resonance: Mean,
}

impl Pair {
    /// Difference of the two methods in damping and friction together, including their correlations.
    pub(super) fn difference(&self) -> Option<Difference> {
        let (a, b) = (&self.ring_down, &self.resonance);
        let d = a.value - b.value;
        let inverse = a.covariance_from(b).try_inverse()?;
        let chi_square = (d.transpose() * inverse * d)[(0, 0)];
        let freedom = a.freedom.into_iter().chain(b.freedom).fold(f64::INFINITY, f64::min);
        Some(Difference { chi_square, compared: 2.0, freedom })
    }

    /// Agreement of damping or friction alone.
    pub(super) fn consistency(&self, k: usize) -> Consistency {
        let (a, b) = (&self.ring_down, &self.resonance);
        let z = (a.value[k] - b.value[k]) / a.covariance_from(b)[(k, k)].sqrt();
        let freedom = a.freedom[k].min(b.freedom[k]);
        Consistency { z, p_value: scaled_tail(z * z, 1.0, freedom) }
    }
}
