//! Power density of noise about a frequency.

use super::transform::{bin_hz, loudest_grid, median_step, transform};
use nalgebra::Complex;

/// Power density of noise about a frequency.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct Density {
    /// Relative to the mean density up to half the sampling rate: 1 for white noise.
    pub(crate) ratio: f64,
    /// Density at the lowest frequencies relative to the mean; 0 if the band of the motion extends down to them.
    pub(crate) lowest: f64,
    /// Degrees of freedom of that ratio.
    pub(crate) degrees: f64,
    /// The ratio in the bands between the frequency and its second and third harmonics, and its degrees of freedom.
    between: [f64; 2],
}

impl Density {
    /// The ratio minus its own standard error: a lower bound on the excess over white noise.
    pub(crate) fn least_ratio(&self) -> f64 {
        minus_standard_error([self.ratio, self.degrees])
    }

    /// The same for the noise at the second and third harmonics, estimated from the bands next to them.
    pub(crate) fn least_ratio_at_harmonics(&self) -> f64 {
        minus_standard_error(self.between)
    }
}

fn minus_standard_error([ratio, degrees]: [f64; 2]) -> f64 {
    ratio * (1.0 - (2.0 / degrees).sqrt())
}

/// Relative band around a frequency in which the noise density is taken as that at the frequency.
const BAND: [f64; 2] = [0.5, 1.5];
/// The same for the bands next to the harmonics, which contain neither harmonics nor the motion.
const BETWEEN: [[f64; 2]; 2] = [[1.25, 1.75], [2.25, 2.75]];
/// Number of independent noise bins merged into one by a Hann window.
const HANN_BINS: f64 = 1.5;
/// Maximum relative deviation of the mean step of a clock from its median step for a uniform clock.
const EVEN: f64 = 0.01;
/// Number of lowest bins used to estimate the wander of an offset.
const LOWEST: usize = 12;

/// The noise density of residuals around a frequency, which determines the accuracy of an oscillation there; `None`
/// for a non-uniform clock, whose interpolation colours the noise, or for less than a cycle.
pub(crate) fn density_near(time: &[f64], residuals: &[f64], frequency_hz: f64) -> Option<Density> {
    let steps = (time.len().max(2) - 1) as f64;
    let mean_step = (time.last()? - time.first()?) / steps;
    if !((mean_step / median_step(time) - 1.0).abs() < EVEN) {
        return None;
    }
    let (grid, _) = loudest_grid(time, residuals)?;
    let (bin, duration) = (bin_hz(&grid), grid.duration());
    transform(&grid, |spectrum| density_of(spectrum, bin, duration, frequency_hz))?
}

/// The same, from a transform.
fn density_of(spectrum: &[Complex<f64>], bin: f64, duration: f64, frequency_hz: f64) -> Option<Density> {
    let power = |range: std::ops::Range<usize>| {
        let part = spectrum.get(range)?;
        (!part.is_empty()).then(|| crate::numeric::dispatch(Power { of: part }) / part.len() as f64)
    };
    let index = |hz: f64| ((hz / bin) as usize).min(spectrum.len());
    let (from, to) = (index(BAND[0] * frequency_hz), index(BAND[1] * frequency_hz));
    let white = power(1..spectrum.len())?;
    let ratio = power(from..to)? / white;
    // The lowest bins contain the offset, which is fitted.
    let lowest_end = index((LOWEST as f64 * bin).min(BAND[0] * frequency_hz));
    let lowest = power(1..lowest_end).map_or(0.0, |p| p / white);
    let degrees_of = |bins: usize| 2.0 * bins as f64 * bin * duration / HANN_BINS;
    let degrees = degrees_of(to - from);
    let (mut sum, mut bins) = (0.0, 0);
    for [low, high] in BETWEEN {
        let band = index(low * frequency_hz)..index(high * frequency_hz);
        let count = band.len();
        if let Some(density) = power(band) {
            sum += density * count as f64;
            bins += count;
        }
    }
    // With few samples per cycle there are no such bands, and hardly any harmonics.
    let between = if bins > 0 { [sum / bins as f64 / white, degrees_of(bins)] } else { [ratio, degrees] };
    (ratio.is_finite() && lowest.is_finite() && degrees > 0.0).then_some(Density {
        ratio,
        lowest,
        degrees,
        between,
    })
}

/// Sum of the squared moduli of numbers.
struct Power<'a> {
    of: &'a [Complex<f64>],
}

impl pulp::NullaryFnOnce for Power<'_> {
    type Output = f64;

    #[inline(always)]
    fn call(self) -> f64 {
        const LANES: usize = 8;
        let (pieces, rest) = self.of.as_chunks::<LANES>();
        let mut sums = [0.0; LANES];
        for piece in pieces {
            sums.iter_mut().zip(piece).for_each(|(sum, c)| *sum += c.norm_sqr());
        }
        sums.iter().sum::<f64>() + rest.iter().map(Complex::norm_sqr).sum::<f64>()
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::f64::consts::PI;

    #[test]
    fn the_density_of_coloured_noise_is_that_of_its_process() {
        // AR(1): (1 - a²)/(1 + a² - 2 a cos(omega)).
        let a = 0.9;
        let (mut white, mut coloured) = (Vec::new(), Vec::new());
        let mut last = 0.0;
        for i in 0..20_000 {
            let w = crate::noise::jitter(i, 11);
            last = a * last + w;
            white.push(w);
            coloured.push(last);
        }
        let time: Vec<f64> = (0..20_000).map(f64::from).collect();
        let flat = density_near(&time, &white, 1.0 / 30.0).unwrap();
        assert!((flat.ratio - 1.0).abs() < 4.0 * (2.0 / flat.degrees).sqrt(), "{flat:?}");
        let found = density_near(&time, &coloured, 1.0 / 30.0).unwrap();
        let expected = (1.0 - a * a) / (1.0 + a * a - 2.0 * a * (2.0 * PI / 30.0).cos());
        assert!((found.ratio / expected - 1.0).abs() < 0.25, "{found:?} for {expected}");
        // A non-uniform clock is interpolated, which colours any noise.
        let uneven: Vec<f64> =
            time.iter().map(|t| t + 0.4 * (t * t).sin() + if *t > 1e4 { *t } else { 0.0 }).collect();
        assert_eq!(density_near(&uneven, &white, 1.0 / 30.0), None);
    }
}
