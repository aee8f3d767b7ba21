//! Test for the presence of a resonance.

use super::block::Block;
use super::criteria::Criteria;
use super::problem::Problem;
use super::residuals::noise_model;
use super::response::Modelled;
use crate::error::NO_MORE_THAN_A_LINE;
use crate::inference::evidence::f_tail;
use crate::inference::least_squares::Fit;
use crate::motion::steady::Phasor;

/// Reason why the points show no resonance, if they do not; `fit` is the resonance that describes them best, `noise`
/// the noise of one amplitude.
///
/// The decision is based on all points: an F test of the resonance against a straight line, which must also be
/// significant without the point farthest from the line. The p value is multiplied by the number of positions at which
/// a peak of that width may be found by chance. If the test is not significant, points far above the noise still count
/// as a resonance, unless the residuals of the line are only noise.
pub(super) fn absence(problem: &Problem, fit: &Fit, noise: f64, criteria: &Criteria) -> Option<&'static str> {
    let b = &problem.main;
    if noise == 0.0 || is_beyond_a_line(problem, fit, criteria) {
        return None;
    }
    let c = &criteria.peak;
    let used = || (0..b.len()).filter(|&i| b.weight[i] > 0.0);
    let level = |i: usize| b.data[i] / b.drive[i];
    let (sum, count) = used().fold((Phasor::default(), 0.0), |(sum, n), i| (sum + level(i), n + 1.0));
    // Squared distance and index of the point farthest from a centre, with one point excluded.
    let farthest = |centre: Phasor, but: usize| {
        let apart = used().filter(|&i| i != but).map(|i| ((level(i) - centre).norm_sqr(), i));
        apart.fold((0.0, 0), |most: (f64, usize), this| if this.0 > most.0 { this } else { most })
    };
    let (square, far) = farthest(sum / count, usize::MAX);
    if square.sqrt() < c.above_noise * noise {
        return Some("no peak stands out of the noise");
    }
    let (square, _) = farthest((sum - level(far)) / (count - 1.0), far);
    if square.sqrt() < c.above_noise * noise {
        return Some("only a single point stands out of the noise, not a peak");
    }
    let line = Line::through(b, None)?;
    let variance = line.rss / (b.observations() - line.parameters).max(1.0);
    let nothing_left = variance < criteria.selection.noise_variances * line.neighbour_variance;
    nothing_left.then_some(NO_MORE_THAN_A_LINE)
}

/// Whether the fit describes the points better than a straight line by more than chance.
fn is_beyond_a_line(problem: &Problem, fit: &Fit, criteria: &Criteria) -> bool {
    let b = &problem.main;
    let Some(all) = Line::through(b, None) else { return false };
    let Some(without) = Line::through(b, Some(all.farthest)) else { return false };
    let far = problem.residuals(&fit.parameters)[all.farthest];
    let rest = fit.rss - far.map_or(0.0, |r| b.weight[all.farthest] * r.norm_sqr());
    let inflation = noise_model(problem, fit, &criteria.residuals).variance_inflation;
    let places = independent_positions(problem, fit);
    [(all, fit.rss, 0.0), (without, rest, 1.0)].into_iter().all(|(line, left, dropped)| {
        let observations = b.observations() - dropped * if b.complex { 2.0 } else { 1.0 };
        let numerator = (fit.free.len() as f64 - line.parameters).max(1.0);
        let denominator = observations / inflation - fit.free.len() as f64;
        if denominator < 1.0 || !(left > 0.0) {
            return false;
        }
        let f = (line.rss - left) / numerator / (left / denominator);
        places * f_tail(f, numerator, denominator) < criteria.peak.chance
    })
}

/// Number of peaks of the fitted width that fit side by side into the range of the points.
fn independent_positions(problem: &Problem, fit: &Fit) -> f64 {
    let b = &problem.main;
    let size = |m: Option<Modelled>, drive: f64| m.map_or(f64::NAN, |m| m.oscillator.norm() / drive);
    let sizes: Vec<f64> =
        problem.predict(&fit.parameters, false).into_iter().zip(&b.drive).map(|(m, d)| size(m, *d)).collect();
    let ends = |(l, h): (f64, f64), s: &f64| (l.min(*s), h.max(*s));
    let (low, high) = sizes.iter().fold((f64::INFINITY, 0.0), ends);
    let wide = sizes.iter().filter(|s| **s > 0.5 * (low + high)).count();
    b.len() as f64 / wide.max(1) as f64
}

/// The straight line through the response divided by the drive.
struct Line {
    rss: f64,
    parameters: f64,
    /// The point with the largest weighted distance from the line.
    farthest: usize,
    /// Variance of a point from differences between the residuals of neighbours.
    neighbour_variance: f64,
}

impl Line {
    fn through(b: &Block, but: Option<usize>) -> Option<Self> {
        let middle = 0.5 * (b.omega.first()? + b.omega.last()?);
        let used = || (0..b.len()).filter(|&i| b.weight[i] > 0.0 && Some(i) != but);
        let weight = |i: usize| b.weight[i] * b.drive[i] * b.drive[i];
        let level = |i: usize| b.data[i] / b.drive[i];
        let total: f64 = used().map(weight).sum();
        let place = used().map(|i| weight(i) * (b.omega[i] - middle)).sum::<f64>() / total;
        let mean = used().map(|i| level(i) * weight(i)).sum::<Phasor>() / total;
        let t = |i: usize| b.omega[i] - middle - place;
        let square: f64 = used().map(|i| weight(i) * t(i) * t(i)).sum();
        let slope = used().map(|i| (level(i) - mean) * (weight(i) * t(i))).sum::<Phasor>() / square;
        let residual = |i: usize| (level(i) - mean - slope * t(i)) * weight(i).sqrt();
        let left = |i: usize| residual(i).norm_sqr();
        let steps = used().zip(used().skip(1)).map(|(i, j)| (residual(j) - residual(i)).norm_sqr());
        let per = if b.complex { 2.0 } else { 1.0 };
        let neighbour_variance = 0.5 * steps.sum::<f64>() / (per * used().skip(1).count() as f64);
        let farthest = used().max_by(|&i, &j| left(i).total_cmp(&left(j)))?;
        let rss: f64 = used().map(left).sum();
        rss.is_finite().then_some(Self { rss, parameters: 2.0 * per, farthest, neighbour_variance })
    }
}

#[cfg(test)]
mod tests {
    use super::super::{Curve, Options, analyse};
    use crate::motion::steady::{Phasor, scan};
    use crate::noise::jitter;
    use crate::{Error, Oscillator, Parameter};

    const Q: f64 = 50.0;

    fn hz(points: usize) -> Vec<f64> {
        (0..points).map(|i| 1.0 + 0.06 * (2.0 * i as f64 / (points - 1) as f64 - 1.0)).collect()
    }

    fn noise(seed: u64, i: usize) -> Phasor {
        Phasor::new(jitter(i, 2 * seed), jitter(i, 2 * seed + 1))
    }

    /// Friction balances nine tenths of the drive: the peak is flat, and its highest point is rarely six standard
    /// deviations above the mean.
    #[test]
    fn a_flat_peak_in_noise_is_answered() {
        for points in [21, 101] {
            let x_f = 0.9 * std::f64::consts::FRAC_PI_4;
            let o = Oscillator::builder().frequency_hz(1.0).q_factor(Q).friction_displacement(x_f).build();
            let o = o.unwrap();
            let clean: Vec<Phasor> =
                hz(points).iter().map(|hz| scan::reading(&o, 1.0, *hz).unwrap().fundamental).collect();
            let sigma = 0.07 * clean.iter().map(|z| z.norm()).fold(0.0, f64::max);
            let known = super::super::DriveAmplitude { value: 1.0, std_error: 0.0 };
            let options = Options { drive_amplitude: Some(known), ..Options::default() };
            let (mut answered, mut held) = (0, 0);
            for seed in 0..40 {
                let seen =
                    clean.iter().enumerate().map(|(i, z)| (z + noise(seed, i) * sigma).norm()).collect();
                let curve = Curve::builder(hz(points), seen).build().unwrap();
                let Ok(answer) = analyse(&curve, &options) else { continue };
                answered += 1;
                let [low, high] = answer.parameter(Parameter::FRICTION_DISPLACEMENT).unwrap().interval_95;
                held += usize::from((low..=high).contains(&x_f));
            }
            // Judged by single points 34 of 40 are rejected.
            assert!(answered >= 39, "{points} points: {answered} of 40");
            assert!(held >= 34, "{points} points: {held} of {answered}");
        }
    }

    #[test]
    fn noise_and_a_slope_are_no_resonance() {
        for (points, level, slope, complex) in [
            (8, 20.0, 0.0, false),
            (21, 0.0, 0.0, false),
            (21, 30.0, 8.0, false),
            (41, 0.0, 0.0, true),
            (41, 50.0, 8.0, false),
            (101, 50.0, 10.0, true),
        ] {
            let answered = (0..50).filter(|&seed| {
                let at = |(i, hz): (usize, &f64)| {
                    Phasor::new(level + slope * (hz - 1.0) / 0.06, 0.0) + noise(seed, i)
                };
                let frequencies = hz(points);
                let seen: Vec<Phasor> = frequencies.iter().enumerate().map(at).collect();
                let curve = if complex {
                    Curve::complex(frequencies, seen)
                } else {
                    Curve::builder(frequencies, seen.iter().map(|z| z.norm()).collect())
                };
                match analyse(&curve.build().unwrap(), &Options::default()) {
                    Ok(_) => true,
                    Err(Error::NoResonance { .. } | Error::NoFit { .. }) => false,
                    Err(other) => panic!("{other}"),
                }
            });
            let answered = answered.count();
            assert!(answered <= 1, "{points} points, level {level}, slope {slope}: {answered} of 50");
        }
    }

    #[test]
    fn a_sweep_too_narrow_to_show_its_peak_is_refused_with_what_helps() {
        let o = Oscillator::builder().frequency_hz(1.0).q_factor(Q).build().unwrap();
        let frequencies: Vec<f64> = (0..15).map(|i| 1.006 + 4e-4 * f64::from(i)).collect();
        let read = |(i, f): (usize, &f64)| {
            (scan::reading(&o, 1.0, *f).unwrap().fundamental + noise(3, i) * 0.5).norm()
        };
        let seen = frequencies.iter().enumerate().map(read).collect();
        let refused = analyse(&Curve::builder(frequencies, seen).build().unwrap(), &Options::default());
        let error = refused.unwrap_err();
        assert!(error.to_string().contains("too narrow or too coarse"), "{error}");
        let hints = error.hints(crate::answer::hint::Analysis::Resonance);
        assert!(hints[0].to_string().contains("sweep over several widths"), "{hints:?}");
    }
}
