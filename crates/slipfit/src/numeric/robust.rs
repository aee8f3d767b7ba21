//! Robust statistics: medians, and noise estimates that tolerate outliers.

/// Median of the absolute value of a normal variable over its standard deviation.
const MEDIAN_SIZE: f64 = 0.674_49;

/// Median; for an even count the upper of the two middle values; `None` if empty.
///
/// Reorders the values.
pub(crate) fn median(values: &mut [f64]) -> Option<f64> {
    let middle = values.len() / 2;
    (!values.is_empty()).then(|| *values.select_nth_unstable_by(middle, f64::total_cmp).1)
}

/// Standard deviation of normal values about zero, from the median of their absolute values.
pub(crate) fn deviation(values: impl Iterator<Item = f64>) -> Option<f64> {
    let mut sizes: Vec<f64> = values.map(f64::abs).collect();
    median(&mut sizes).map(|size| size / MEDIAN_SIZE)
}

/// White noise per sample, from the deviation of each sample from the mean of its two neighbours; slow motion adds to
/// it, so that this is an upper bound. The samples are given as windows of three.
pub(crate) fn neighbour_noise<'a>(triples: impl Iterator<Item = &'a [f64]>) -> Option<f64> {
    // Variance 1 + 1/4 + 1/4.
    deviation(triples.map(|w| w[1] - 0.5 * (w[0] + w[2]))).map(|d| d / 1.5f64.sqrt())
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::noise::jitter;

    #[test]
    fn the_median_is_the_upper_one_of_two() {
        assert_eq!(median(&mut []), None);
        assert_eq!(median(&mut [3.0]), Some(3.0));
        assert_eq!(median(&mut [4.0, 1.0, 3.0, 2.0]), Some(3.0));
        assert_eq!(median(&mut [9.0, f64::INFINITY, 1.0]), Some(9.0));
    }

    #[test]
    fn noise_is_found_beneath_outliers_and_a_slow_motion() {
        let signal: Vec<f64> = (0..4000)
            .map(|i| {
                let t = f64::from(i) * 1e-3;
                let spike = if i % 50 == 0 { 1e3 } else { 0.0 };
                (6.0 * t).sin() + spike + 0.1 * jitter(i as usize, 7)
            })
            .collect();
        let noise = neighbour_noise(signal.windows(3)).unwrap();
        // Six in a hundred triples contain a spike, which raises the median by about 8 %.
        assert!((0.1..0.115).contains(&noise), "{noise}");
    }
}
