//! Estimate of the model-free law from the amplitudes of a decay.

use super::answer::{FreeLaw, FreeLossPoint};
use super::criteria::FreeLawCriteria;
use super::curve::Curve;
use super::problem::{FreeProblem, Node, START};
use crate::Quantity;
use crate::inference::Z_95;
use crate::inference::evidence::student_factor;
use crate::inference::interval::bounded_interval;
use crate::inference::noise::{autocorrelation, significant_inflation};
use crate::inference::smooth::{Smoothed, smooth};
use crate::numeric::order::sort_by_value;
use crate::numeric::robust;
use crate::ringdown::amplitude_fit::LEAST_SQUARED_AMPLITUDE;
use std::f64::consts::PI;

/// Number of intervals between the reported points of the curve.
const INTERVALS: u32 = 48;
/// Rounds of updating weights and outliers from the curve.
const ROUNDS: usize = 2;

/// Amplitudes along a free decay, as required by the model-free law.
#[derive(Debug, Clone)]
pub(crate) struct Amplitudes {
    /// s, ascending.
    pub(crate) time_s: Vec<f64>,
    pub(crate) amplitude: Vec<f64>,
    /// Variance of each for samples of unit variance.
    pub(crate) unit_variance: Vec<f64>,
    /// Variance of one sample if known independently, otherwise zero.
    pub(crate) noise_variance: f64,
    /// If the amplitudes are root mean squares that include noise, the contribution of the noise to the
    /// square.
    pub(crate) floor: Option<f64>,
    /// Delays and shares of the low-pass that preceded the recording.
    pub(crate) delays: Vec<(f64, f64)>,
    /// rad/s, if known.
    pub(crate) omega: Option<f64>,
    pub(crate) unit: String,
}

/// The model-free law fitted to these amplitudes; `None` if they are too few or do not fall.
pub(crate) fn estimate(
    data: &Amplitudes,
    rising: bool,
    significance: f64,
    criteria: &FreeLawCriteria,
) -> Option<FreeLaw> {
    let n = data.amplitude.len();
    if n < criteria.least_points.max(4) {
        return None;
    }
    let (first, last) = (data.amplitude[0], data.amplitude[n - 1]);
    let duration = data.time_s[n - 1] - data.time_s[0];
    let stretches = (n / criteria.points_per_stretch.max(1)).clamp(1, criteria.most_stretches.max(1));
    let curve = Curve::through(&data.amplitude, duration, stretches)?;
    let mut problem = problem(data, curve);
    let mut start = vec![0.0; 1 + problem.curve.coefficients()];
    // An exponential with the overall decrease; any decreasing start suffices.
    start[START] = first;
    start[2] = (first / last.max(1e-3 * first)).ln().max(1e-3) / duration;
    let mut found = smoothed(&problem, &start, data.noise_variance)?;
    for _ in 0..ROUNDS {
        let amplitudes = problem.amplitudes(&found.parameters);
        weigh(&mut problem, &amplitudes);
        let residuals = problem.residuals(&found.parameters);
        let deviation = robust::deviation(residuals.iter().copied()).unwrap_or(0.0);
        let most = criteria.outlier_deviations * deviation.max(data.noise_variance.sqrt());
        if residuals.iter().any(|r| r.abs() > most) {
            problem = problem.without(|i| residuals[i].abs() > most);
        } else if data.floor.is_none() {
            break;
        }
        found = smoothed(&problem, &found.parameters, data.noise_variance)?;
    }
    let residuals = problem.residuals(&found.parameters);
    let rho = autocorrelation(&residuals);
    let inflation = significant_inflation(rho, residuals.len(), significance);
    let spare = (residuals.len() as f64 - 3.0 - found.effective).max(1.0) / inflation;
    let widened = inflation.sqrt() * student_factor(spare);
    Some(law(&found, &problem.curve, data, rising, widened))
}

fn smoothed(problem: &FreeProblem, start: &[f64], noise_variance: f64) -> Option<Smoothed> {
    smooth(problem, start, 3..start.len(), noise_variance)
}

fn problem(data: &Amplitudes, curve: Curve) -> FreeProblem {
    let nodes = nodes(data);
    let value = |a: &f64| if data.floor.is_some() { a * a } else { *a };
    let unit_weight: Vec<f64> = data.unit_variance.iter().map(|v| 1.0 / v).collect();
    let mut problem = FreeProblem {
        curve,
        nodes,
        value: data.amplitude.iter().map(value).collect(),
        weight: unit_weight.clone(),
        unit_weight,
        floor: data.floor,
    };
    weigh(&mut problem, &data.amplitude);
    problem
}

/// Number of steps of the even grid on which the motion before a low-pass is computed.
const GRID: f64 = 1000.0;

/// Times at which the motion is needed: those of the amplitudes or, with a low-pass, those at the delays of
/// each amplitude. The latter are interpolated on an even grid, so that the motion is computed only once.
fn nodes(data: &Amplitudes) -> Vec<Node> {
    let all = 0..data.time_s.len();
    if data.delays.is_empty() {
        return all.map(|of| Node { time_s: data.time_s[of], of, share: 1.0 }).collect();
    }
    let longest = data.delays.iter().fold(0.0f64, |m, d| m.max(d.0));
    let begin = data.time_s[0] - longest;
    let step = (data.time_s[data.time_s.len() - 1] - begin) / GRID;
    let mut shares: Vec<(usize, Node)> = Vec::new();
    for of in all {
        let mut own = std::collections::BTreeMap::new();
        for (delay, share) in &data.delays {
            let place = ((data.time_s[of] - delay - begin) / step).max(0.0);
            let (left, part) = (place.floor(), place.fract());
            *own.entry(left as usize).or_insert(0.0) += share * (1.0 - part);
            *own.entry(left as usize + 1).or_insert(0.0) += share * part;
        }
        let node = |(i, share): (usize, f64)| (i, Node { time_s: begin + step * i as f64, of, share });
        shares.extend(own.into_iter().map(node));
    }
    sort_by_value(&mut shares, |(i, _)| *i as f64);
    shares.into_iter().map(|(_, node)| node).collect()
}

/// `4 (A² + sigma²)`, the ratio of the variance of a square to that of its amplitude, with
/// `floor = 2 sigma²`.
fn spread_of_square(amplitude: f64, largest: f64, floor: f64) -> f64 {
    4.0 * (amplitude * amplitude + 0.5 * floor).max(LEAST_SQUARED_AMPLITUDE * largest * largest)
}

/// Weights mean squares by the given amplitudes: if weighted by the measured ones, those made small by noise
/// would get the largest weights.
fn weigh(problem: &mut FreeProblem, amplitudes: &[f64]) {
    let Some(floor) = problem.floor else { return };
    let largest = amplitudes.first().copied().unwrap_or(0.0);
    let own = problem.unit_weight.iter().zip(amplitudes);
    problem.weight = own.map(|(w, a)| w / spread_of_square(*a, largest, floor)).collect();
}

/// The curve with its band, its limit and its slope.
fn law(found: &Smoothed, curve: &Curve, data: &Amplitudes, rising: bool, widened: f64) -> FreeLaw {
    let period = data.omega.map_or(1.0, |omega| 2.0 * PI / omega);
    let largest = data.amplitude.iter().fold(0.0, |h, a| f64::max(h, *a));
    // An amplitude below its standard error does not count as measured.
    let measured = |(a, unit): (&f64, &f64)| a.max((unit * data.noise_variance).sqrt());
    let lowest = data.amplitude.iter().zip(&data.unit_variance).map(measured).fold(largest, f64::min);
    let n = curve.coefficients();
    let mut shapes = vec![0.0; n];
    let error = |row: &[f64]| {
        let pairs = (0..n).flat_map(|i| (0..n).map(move |j| (i, j)));
        let variance: f64 = pairs.map(|(i, j)| row[i] * row[j] * found.covariance[(i + 1, j + 1)]).sum();
        widened * variance.max(0.0).sqrt()
    };
    let mut points: Vec<FreeLossPoint> = (0..=INTERVALS)
        .map(|i| {
            // The points are denser at small amplitudes, where the decay spends most of its time.
            let amplitude = largest * (f64::from(i) / f64::from(INTERVALS)).powi(2);
            curve.shapes(amplitude, &mut shapes);
            let value: f64 = shapes.iter().zip(&found.parameters[1..]).map(|(s, p)| s * p).sum();
            let half = Z_95 * error(&shapes);
            let [loss_per_cycle, low_95, high_95] =
                [value, value - half, value + half].map(|v| v.max(0.0) * period);
            FreeLossPoint { amplitude, loss_per_cycle, low_95, high_95 }
        })
        .collect();
    let row = |k: usize| (0..n).map(|i| f64::from(u8::from(i == k))).collect::<Vec<f64>>();
    let per_second = if data.unit.is_empty() { "1/s".to_owned() } else { format!("{}/s", data.unit) };
    let limit = non_negative(found.parameters[1], error(&row(0)), per_second);
    let slope = Quantity::normal(found.parameters[2], error(&row(1)), "1/s");
    let [low, high] = limit.interval_95.map(|v| v * period);
    points[0] =
        FreeLossPoint { amplitude: 0.0, loss_per_cycle: limit.value * period, low_95: low, high_95: high };
    if rising {
        rearrange(&mut points);
    }
    FreeLaw {
        curve: points,
        friction_displacement: data.omega.map(|omega| limit.scaled(PI / (2.0 * omega), data.unit.clone())),
        limit,
        slope,
        lowest_amplitude: lowest,
        effective_parameters: 2.0 + found.effective,
        rising,
    }
}

/// A quantity that cannot be negative, with the interval for that constraint.
fn non_negative(value: f64, std_error: f64, unit: String) -> Quantity {
    let interval = if std_error > 0.0 {
        bounded_interval(value / std_error).map(|z| z * std_error)
    } else {
        [value.max(0.0); 2]
    };
    Quantity { value: value.max(0.0), std_error, interval_95: interval, unbounded_value: value, unit }
}

/// Sorts the estimate and both limits of the band in ascending order. For an increasing function the
/// rearranged estimate is never worse, and the rearranged band covers it at least as often (Chernozhukov,
/// Fernández-Val and Galichon 2009, Biometrika 96, 559).
fn rearrange(points: &mut [FreeLossPoint]) {
    let columns: [fn(&mut FreeLossPoint) -> &mut f64; 3] =
        [|p| &mut p.loss_per_cycle, |p| &mut p.low_95, |p| &mut p.high_95];
    for column in columns {
        let mut sorted: Vec<f64> = points.iter_mut().map(|p| *column(p)).collect();
        sorted.sort_by(f64::total_cmp);
        points.iter_mut().zip(sorted).for_each(|(p, v)| *column(p) = v);
    }
}
