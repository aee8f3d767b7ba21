//! The covariance of the parameters of a fit.

use nalgebra::DMatrix;
use std::ops::Index;

/// A covariance matrix indexed by all parameters; elements of parameters that are not free are zero.
///
/// Only about six of eighteen parameters are free, so only their block is computed and copied.
#[derive(Debug, Clone)]
pub(crate) struct Covariance {
    free: DMatrix<f64>,
    /// Position of each parameter among the free ones; the number of free parameters if it is not free.
    place: Vec<usize>,
}

impl Covariance {
    /// Covariance of the `free` ones among `parameters`, in their order.
    pub(super) fn new(covariance: DMatrix<f64>, free: &[usize], parameters: usize) -> Self {
        let mut place = vec![free.len(); parameters];
        for (k, &parameter) in free.iter().enumerate() {
            place[parameter] = k;
        }
        Self { free: covariance, place }
    }
}

impl Index<(usize, usize)> for Covariance {
    type Output = f64;

    fn index(&self, (a, b): (usize, usize)) -> &f64 {
        self.free.get((self.place[a], self.place[b])).unwrap_or(&0.0)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn parameters_that_are_not_free_have_no_covariance() {
        let block = DMatrix::from_row_slice(2, 2, &[1.0, 2.0, 3.0, 4.0]);
        let covariance = Covariance::new(block, &[3, 1], 4);
        let all: Vec<f64> = (0..16).map(|k| covariance[(k / 4, k % 4)]).collect();
        let expected = [0.0, 0.0, 0.0, 0.0, 0.0, 4.0, 0.0, 3.0, 0.0, 0.0, 0.0, 0.0, 0.0, 2.0, 0.0, 1.0];
        assert_eq!(all, expected);
    }
}
