//! Amplitude at resonance from a frequency sweep.

use super::criteria::LevelCriteria;
use crate::resonance::{Curve, CurveFit, fit};
use std::f64::consts::{FRAC_PI_4, PI};

/// Largest residual, relative to the largest amplitude, that is due to rounding for points without noise.
const ROUNDING: f64 = 1e-9;

/// Height of a resonance from the exact response fitted to the amplitudes of a curve; `None` if the response does not
/// describe the curve, or too few points lie in the upper half of the peak.
///
/// The largest amplitude of a sweep is lower than the height because of the finite frequency steps, and is increased by
/// noise.
///
/// ```
/// let hz: Vec<f64> = (0..14).map(|i| 96.7 + 0.5 * f64::from(i)).collect();
/// let amplitude: Vec<f64> = hz.iter().map(|f| 1.0 / (1.0 - f * f / 1e4).hypot(f / 5e3)).collect();
/// let largest = amplitude.iter().copied().fold(0.0, f64::max);
/// let height = slipfit::levels::peak_height(&hz, &amplitude).expect("a resonance");
/// assert!(largest < 49.0 && (height - 50.0).abs() < 0.05);
/// ```
#[must_use]
pub fn peak_height(frequency_hz: &[f64], amplitude: &[f64]) -> Option<f64> {
    let c = LevelCriteria::default();
    let largest = amplitude.iter().copied().fold(0.0, f64::max);
    let upper = amplitude.iter().filter(|a| **a >= 0.5 * largest).count();
    if upper < c.peak_points || amplitude.len() < 2 * c.peak_points {
        return None;
    }
    let curve = Curve::builder(frequency_hz.to_vec(), amplitude.to_vec()).build().ok()?;
    // For points without noise no step is smaller than its error.
    let settled = |f: &CurveFit| f.converged || f.residual_rms < ROUNDING * largest;
    let found = fit(&curve, None).ok().filter(settled)?;
    let [delta, x_f, x_0, hz] = [
        found.decay_rate_per_s,
        found.friction_displacement,
        found.drive_amplitude,
        found.natural_frequency_hz,
    ]
    .map(|p| p[0]);
    let height = PI * hz / delta * (x_0 - x_f / FRAC_PI_4);
    let ends =
        frequency_hz.iter().fold([f64::INFINITY, f64::NEG_INFINITY], |e, f| [e[0].min(*f), e[1].max(*f)]);
    let described = found.residual_rms < c.peak_residual * largest;
    let higher = (1.0 - c.peak_residual..c.peak_rise).contains(&(height / largest));
    (described && higher && (ends[0]..ends[1]).contains(&hz)).then_some(height)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::Oscillator;
    use crate::motion::steady::scan;
    use crate::noise::jitter;

    /// Root mean square of the relative error of the heights found, and their number, of 40 sweeps.
    fn missed(points: usize, beta: f64, noise: f64) -> (f64, usize) {
        let (q, x_f) = (100.0, FRAC_PI_4 * beta);
        let o =
            Oscillator::builder().frequency_hz(1.0).q_factor(q).friction_displacement(x_f).build().unwrap();
        let height = q * (1.0 - beta);
        let found: Vec<f64> = (0..40u64)
            .filter_map(|seed| {
                let hz = |i: usize| 0.96 + (i as f64 + 0.5 * jitter(seed as usize, 3)) * 0.08 / points as f64;
                let hz: Vec<f64> = (0..points).map(hz).collect();
                let read = |(i, f): (usize, &f64)| {
                    let a = scan::reading(&o, 1.0, *f).unwrap().amplitude();
                    (a + noise * height * jitter(i, 2 * seed)).hypot(noise * height * jitter(i, 2 * seed + 1))
                };
                let amplitude: Vec<f64> = hz.iter().enumerate().map(read).collect();
                peak_height(&hz, &amplitude)
            })
            .collect();
        let square: f64 = found.iter().map(|h| (h / height - 1.0).powi(2)).sum();
        ((square / found.len() as f64).sqrt(), found.len())
    }

    #[test]
    fn the_height_lies_between_the_points() {
        for beta in [0.0, 0.3, 0.7] {
            // Of 21 points, at most eight within a width, the largest is 3 % low.
            let (off, found) = missed(33, beta, 0.002);
            assert!(off < 4e-3 && found >= 36, "{beta}: {off} of {found}");
            let (off, found) = missed(61, beta, 0.01);
            assert!(off < 0.015 && found >= 36, "{beta}: {off} of {found}");
        }
    }

    #[test]
    fn points_without_noise_have_one() {
        for from in [96.7, 96.8, 96.9, 97.0, 97.1] {
            let hz: Vec<f64> = (0..14).map(|i| from + 0.5 * f64::from(i)).collect();
            let read = |f: &f64| 1.0 / (1.0 - f * f / 1e4).hypot(f / 5e3);
            let amplitude: Vec<f64> = hz.iter().map(read).collect();
            let height = peak_height(&hz, &amplitude);
            assert!(height.is_some_and(|h| (h / 50.0 - 1.0).abs() < 1e-3), "{from}: {height:?}");
        }
    }

    #[test]
    fn what_is_no_resonance_has_no_height() {
        let hz: Vec<f64> = (0..41).map(|i| 1.0 + 0.01 * f64::from(i)).collect();
        let steps: Vec<f64> = (0..41).map(|i| if (10..30).contains(&i) { 2.0 } else { 1.0 }).collect();
        assert_eq!(peak_height(&hz, &steps), None);
        assert_eq!(peak_height(&hz[..4], &steps[..4]), None);
        assert_eq!(peak_height(&[], &[]), None);
    }
}
