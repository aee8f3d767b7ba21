//! A curve of arbitrary shape for the loss against the amplitude.

/// The loss `g(A)` as a straight line with a separate curvature in every stretch of the amplitude:
///
/// ```text
/// g(A) = b0 + b1 A + G sum z_k psi_k(A/A_1),      psi_k'' = 1/sqrt(∫ u du) in stretch k, zero outside
/// ```
///
/// `u = A/A_1`, `A_1` is the largest amplitude, `G = A_1/duration`. A penalty on the squares of `z_k` is one
/// on `∫ A g''² dA`: a bend by a given fraction of the loss costs less at smaller amplitude, where a bend of
/// the same relative width is narrower (with the plain `∫ g''² dA` the limit of a friction that increases
/// towards rest was 3 % too low). `b0` and `b1` are loss and slope at `A = 0` itself, so the uncertainty of
/// the limit is that of two parameters.
#[derive(Debug, Clone)]
pub(super) struct Curve {
    /// Borders of the stretches relative to the largest amplitude, from 0 to 1.
    borders: Vec<f64>,
    /// Curvature scale of each stretch.
    curvature: Vec<f64>,
    largest: f64,
    /// Largest amplitude divided by the duration.
    rate: f64,
}

/// Minimum width of a stretch relative to the largest amplitude.
const LEAST_WIDTH: f64 = 1e-3;

impl Curve {
    /// Stretches between quantiles of the amplitudes, plus one from zero to the smallest of them.
    pub(super) fn through(amplitudes: &[f64], duration_s: f64, stretches: usize) -> Option<Self> {
        let mut sorted: Vec<f64> = amplitudes.iter().copied().filter(|a| *a > 0.0).collect();
        sorted.sort_by(f64::total_cmp);
        let largest = *sorted.last()?;
        let mut borders = vec![0.0];
        for i in 0..=stretches {
            let quantile = sorted[(i * (sorted.len() - 1)) / stretches.max(1)] / largest;
            if quantile > borders[borders.len() - 1] + LEAST_WIDTH {
                borders.push(quantile);
            }
        }
        let last = borders.len() - 1;
        if last == 0 || !(duration_s > 0.0 && largest.is_finite()) {
            return None;
        }
        borders[last] = 1.0;
        let integral = |ends: &[f64]| 0.5 * (ends[1] * ends[1] - ends[0] * ends[0]);
        let curvature = borders.windows(2).map(|ends| integral(ends).sqrt().recip()).collect();
        Some(Self { borders, curvature, largest, rate: largest / duration_s })
    }

    /// Number of coefficients: the two of the line and one per stretch.
    pub(super) fn coefficients(&self) -> usize {
        2 + self.curvature.len()
    }

    /// The function multiplied by each coefficient, at a given amplitude. Below zero and above the largest
    /// amplitude the curve is a straight line.
    pub(super) fn shapes(&self, amplitude: f64, out: &mut [f64]) {
        let u = amplitude / self.largest;
        (out[0], out[1]) = (1.0, amplitude);
        for ((out, ends), curvature) in out[2..].iter_mut().zip(self.borders.windows(2)).zip(&self.curvature)
        {
            let [from, to] = [(u - ends[0]).max(0.0), (u - ends[1]).max(0.0)];
            *out = 0.5 * self.rate * curvature * (from * from - to * to);
        }
    }

    /// Derivatives of these functions with respect to the amplitude.
    pub(super) fn slopes(&self, amplitude: f64, out: &mut [f64]) {
        let u = amplitude / self.largest;
        (out[0], out[1]) = (0.0, 1.0);
        for ((out, ends), curvature) in out[2..].iter_mut().zip(self.borders.windows(2)).zip(&self.curvature)
        {
            *out = self.rate / self.largest * curvature * ((u - ends[0]).max(0.0) - (u - ends[1]).max(0.0));
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn curve() -> Curve {
        let amplitudes: Vec<f64> = (1..40).map(|i| 3.0 * (-0.1 * f64::from(i)).exp()).collect();
        Curve::through(&amplitudes, 12.0, 8).unwrap()
    }

    #[test]
    fn every_shape_has_its_slope() {
        let curve = curve();
        let n = curve.coefficients();
        let (mut up, mut down, mut slope) = (vec![0.0; n], vec![0.0; n], vec![0.0; n]);
        for amplitude in [-0.2, 0.01, 0.3, 1.1, 2.9, 3.4] {
            let h = 1e-6;
            curve.shapes(amplitude + h, &mut up);
            curve.shapes(amplitude - h, &mut down);
            curve.slopes(amplitude, &mut slope);
            for k in 0..n {
                let numeric = (up[k] - down[k]) / (2.0 * h);
                assert!((slope[k] - numeric).abs() < 1e-6, "{k} at {amplitude}: {} {numeric}", slope[k]);
            }
        }
    }

    #[test]
    fn at_zero_only_the_line_is_left() {
        let curve = curve();
        let mut shapes = vec![9.0; curve.coefficients()];
        curve.shapes(0.0, &mut shapes);
        assert_eq!(shapes[0], 1.0);
        assert!(shapes[1..].iter().all(|s| *s == 0.0));
        curve.slopes(0.0, &mut shapes);
        assert_eq!(shapes[1], 1.0);
        assert!(shapes[2..].iter().all(|s| *s == 0.0));
    }

    #[test]
    fn without_a_positive_amplitude_there_is_no_curve() {
        assert!(Curve::through(&[], 1.0, 8).is_none());
        assert!(Curve::through(&[-1.0, 0.0], 1.0, 8).is_none());
        assert!(Curve::through(&[1.0, 1.0], 0.0, 8).is_none());
    }
}
