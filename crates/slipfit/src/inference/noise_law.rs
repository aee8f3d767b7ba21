//! Noise with a floor and a part proportional to the amplitude, estimated from the likelihood of the residuals.

/// The residuals of one measured amplitude with the contributions to their variance.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Scatter {
    /// Modelled amplitude, squared.
    pub(crate) square: f64,
    /// Variance of the floor, up to a common factor.
    pub(crate) floor: f64,
    /// Sum of squares of the residuals.
    pub(crate) sum_of_squares: f64,
    /// Number of terms in that sum.
    pub(crate) count: f64,
}

/// Whether the common factor of the variances is known.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) enum Scale {
    /// The factor is one.
    Known,
    /// The factor is estimated from the residuals.
    Estimated,
}

/// A ratio of the two parts of the variance with its likelihood.
#[derive(Debug, Clone, Copy)]
pub(crate) struct RatioLikelihood {
    /// Proportional part of the variance over the floor, per squared amplitude.
    pub(crate) ratio: f64,
    /// Minus twice the logarithm of the likelihood, up to a constant.
    pub(crate) minus_two_log: f64,
}

/// The most likely common factor of variances `floor + ratio A²`.
pub(crate) fn scale_at(scatter: &[Scatter], ratio: f64) -> f64 {
    let count: f64 = scatter.iter().map(|s| s.count).sum();
    scatter.iter().map(|s| s.sum_of_squares / (s.floor + ratio * s.square)).sum::<f64>() / count
}

/// The likelihood of residuals with variance `floor + ratio A²` times a common factor.
pub(crate) fn likelihood(scatter: &[Scatter], ratio: f64, scale: Scale) -> RatioLikelihood {
    let count: f64 = scatter.iter().map(|s| s.count).sum();
    let logarithms: f64 = scatter.iter().map(|s| s.count * (s.floor + ratio * s.square).ln()).sum();
    let found = scale_at(scatter, ratio);
    let squares = match scale {
        Scale::Known => count * found,
        Scale::Estimated => count * (1.0 + found.max(f64::MIN_POSITIVE).ln()),
    };
    RatioLikelihood { ratio, minus_two_log: squares + logarithms }
}

/// The most likely of the given ratios.
pub(crate) fn most_likely(
    scatter: &[Scatter],
    ratios: impl Iterator<Item = f64>,
    scale: Scale,
) -> Option<RatioLikelihood> {
    ratios
        .map(|ratio| likelihood(scatter, ratio, scale))
        .filter(|l| l.minus_two_log.is_finite())
        .min_by(|a, b| a.minus_two_log.total_cmp(&b.minus_two_log))
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::noise::jitter;

    fn scatter(absolute: f64, relative: f64) -> Vec<Scatter> {
        (0..400)
            .map(|i| {
                let amplitude = (-0.01 * f64::from(i)).exp();
                let deviation = 1e-3 * absolute.hypot(relative * 1e3 * amplitude);
                let residual = (deviation * jitter(i as usize, 3)).powi(2);
                Scatter { square: amplitude * amplitude, floor: 1e-6, sum_of_squares: residual, count: 1.0 }
            })
            .collect()
    }

    #[test]
    fn a_floor_is_told_apart_from_a_part_of_the_amplitude() {
        let ratios = || std::iter::once(0.0).chain((-60..60).map(|i| 1e-6 * 10f64.powf(0.1 * f64::from(i))));
        let noise = scatter(4.0, 0.0);
        let best = most_likely(&noise, ratios(), Scale::Estimated).expect("finite");
        assert!((scale_at(&noise, best.ratio) / 16.0 - 1.0).abs() < 0.3);
        let law = scatter(1.0, 0.02);
        let best = most_likely(&law, ratios(), Scale::Estimated).expect("finite");
        let scale = scale_at(&law, best.ratio);
        assert!((scale - 1.0).abs() < 0.5, "{scale}");
        assert!((best.ratio * scale / 4e-4 - 1.0).abs() < 0.5, "{}", best.ratio);
        let known = most_likely(&law, ratios(), Scale::Known).expect("finite");
        assert!((known.ratio / 4e-4 - 1.0).abs() < 0.5, "{}", known.ratio);
        assert!(known.minus_two_log >= best.minus_two_log);
    }
}
