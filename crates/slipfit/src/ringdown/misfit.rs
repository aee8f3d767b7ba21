//! Misfit of a decay: size and shape of the deviation of the amplitudes from the law.

use super::EnvelopePoint;
use super::criteria::MisfitCriteria;
use crate::answer::{Misfit, MisfitShape};
use crate::inference::least_squares::linear;
use std::f64::consts::TAU;

/// One amplitude: time, and residual relative to the root mean square of all amplitudes.
type Residual = (f64, f64);

/// The misfit of the amplitudes used; `None` if there are too few.
pub(crate) fn misfit(envelope: &[EnvelopePoint], criteria: &MisfitCriteria) -> Option<Misfit> {
    let used: Vec<&EnvelopePoint> =
        envelope.iter().filter(|p| p.used && p.fitted > 0.0 && p.amplitude.is_finite()).collect();
    let n = used.len() as f64;
    if used.len() < criteria.least_points {
        return None;
    }
    let scale = (used.iter().map(|p| p.amplitude.powi(2)).sum::<f64>() / n).sqrt();
    let residuals: Vec<Residual> =
        used.iter().map(|p| (p.time_s, (p.amplitude - p.fitted) / scale)).collect();
    let relative_rms = (residuals.iter().map(|(_, r)| r * r).sum::<f64>() / n).sqrt();
    let off = |p: &EnvelopePoint| (p.amplitude - p.fitted).abs() / p.fitted;
    // An amplitude at the rounding level of the others has no meaningful relative deviation.
    let known = used
        .iter()
        .filter(|p| p.fitted > f64::EPSILON * scale && p.std_error < (p.amplitude - p.fitted).abs());
    let largest = known.max_by(|a, b| off(a).total_cmp(&off(b)))?;
    let shape = shape(&residuals, criteria);
    Some(Misfit { relative_rms, largest: off(largest), largest_at_s: largest.time_s, shape })
}

fn shape(residuals: &[Residual], criteria: &MisfitCriteria) -> MisfitShape {
    let all: f64 = residuals.iter().map(|(_, r)| r * r).sum();
    let kept = residuals.len() - residuals.len().div_ceil(criteria.end_part);
    let before: f64 = residuals[..kept].iter().map(|(_, r)| r * r).sum();
    if before < (1.0 - criteria.explained) * all {
        return MisfitShape::End { from_s: residuals[kept].0 };
    }
    let most_left = (1.0 - criteria.explained) * all;
    let cubic = residual_sum_of_squares(residuals, |u, _| vec![1.0, u, u * u, u * u * u]);
    let (corner, broken) = kink(residuals);
    let (frequency_hz, periodic) = wobble(residuals);
    // Any smooth arc resembles a broken line.
    let broken = if broken < criteria.kink * cubic { broken } else { f64::INFINITY };
    let least = cubic.min(broken).min(periodic);
    match least {
        least if !(least < most_left) => MisfitShape::Scatter,
        least if least == periodic => MisfitShape::Wobble { frequency_hz },
        least if least == broken => MisfitShape::Kink { time_s: corner },
        _ => MisfitShape::Bow,
    }
}

/// Residual sum of squares of a linear model in time; `row` gets the time scaled to 0 to 1 and the time in s
/// from the start.
fn residual_sum_of_squares(residuals: &[Residual], row: impl Fn(f64, f64) -> Vec<f64>) -> f64 {
    let (from_s, to_s) = (residuals[0].0, residuals[residuals.len() - 1].0);
    let u = |t: f64| (t - from_s) / (to_s - from_s);
    let columns = row(0.0, 0.0).len();
    let rows = residuals.iter().map(|&(t, r)| (row(u(t), t - from_s), r, 1.0));
    linear(rows, columns).map_or(f64::INFINITY, |(_, _, left)| left)
}

/// Number of intervals between the corners tried along the decay.
const CORNERS: usize = 30;

/// The best-fitting broken line: its corner and residual sum of squares.
fn kink(residuals: &[Residual]) -> (f64, f64) {
    let (from_s, to_s) = (residuals[0].0, residuals[residuals.len() - 1].0);
    (1..CORNERS)
        .map(|i| {
            let corner = i as f64 / CORNERS as f64;
            let broken = residual_sum_of_squares(residuals, |u, _| vec![1.0, u, (u - corner).max(0.0)]);
            (from_s + corner * (to_s - from_s), broken)
        })
        .fold((from_s, f64::INFINITY), |best, next| if next.1 < best.1 { next } else { best })
}

/// Limits of the number of periods along the decay: minimum in half periods, maximum in whole periods.
const LEAST_HALF_PERIODS: usize = 5;
const MOST_PERIODS: usize = 60;

/// The best-fitting sinusoid with linearly varying amplitude: its frequency and residual sum of squares.
fn wobble(residuals: &[Residual]) -> (f64, f64) {
    let duration_s = residuals[residuals.len() - 1].0 - residuals[0].0;
    // In steps of half a period, up to one period per four points.
    let most = MOST_PERIODS.min(residuals.len() / 4);
    (LEAST_HALF_PERIODS..=2 * most)
        .map(|halves| {
            let periods = 0.5 * halves as f64;
            let periodic = residual_sum_of_squares(residuals, |u, _| {
                let (sin, cos) = (TAU * periods * u).sin_cos();
                vec![sin, cos, u * sin, u * cos]
            });
            (periods / duration_s, periodic)
        })
        .fold((0.0, f64::INFINITY), |best, next| if next.1 < best.1 { next } else { best })
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::noise::jitter;

    fn of(shape: impl Fn(f64) -> f64) -> Misfit {
        let envelope: Vec<EnvelopePoint> = (0..80)
            .map(|i| {
                let u = f64::from(i) / 80.0;
                let fitted = 2.0 - u;
                let amplitude = fitted + 0.01 * shape(u) + 2e-4 * jitter(i as usize, 1);
                let (frequency_hz, used) = (1.0, true);
                EnvelopePoint { time_s: 100.0 * u, amplitude, std_error: 1e-4, fitted, frequency_hz, used }
            })
            .collect();
        misfit(&envelope, &MisfitCriteria::default()).expect("enough points")
    }

    #[test]
    fn shapes_are_told_apart() {
        assert_eq!(of(|u| (u - 0.5).powi(2) - 1.0 / 12.0).shape, MisfitShape::Bow);
        let MisfitShape::Kink { time_s } = of(|u| (u - 0.45).abs()).shape else { panic!("no kink") };
        assert!((time_s - 45.0).abs() < 4.0, "{time_s}");
        let MisfitShape::Wobble { frequency_hz } = of(|u| (TAU * 7.0 * u).sin()).shape else {
            panic!("no wobble")
        };
        assert!((frequency_hz - 0.07).abs() < 0.006, "{frequency_hz}");
        let MisfitShape::End { from_s } = of(|u| 30.0 * (u - 0.9).max(0.0)).shape else { panic!("no end") };
        assert!((from_s - 90.0).abs() < 6.0, "{from_s}");
        assert_eq!(of(|u| jitter((u * 80.0) as usize, 9)).shape, MisfitShape::Scatter);
    }

    #[test]
    fn the_size_is_relative_to_the_amplitude() {
        let found = of(|u| if (u - 0.5).abs() < 1e-9 { 3.0 } else { 0.3 });
        assert!((found.largest - 0.02).abs() < 1e-3, "{found:?}");
        assert!((found.largest_at_s - 50.0).abs() < 1e-9, "{found:?}");
        assert!(found.relative_rms > 2e-3, "{found:?}");
        assert!(found.relative_rms < 4e-3, "{found:?}");
    }
}
