//! Estimate of a sensor curve from the harmonics in the residuals of a fitted motion.

use super::Answer;
use super::criteria::SensorCriteria;
use super::samples::Samples;
use super::sensor_curve::SensorCurve;
use crate::Parameter;
use crate::inference::least_squares::{Normal, linear_of};
use crate::model::displacement::{Coordinate, DisplacementUnit};
use crate::signal::noise_density::density_near;
use std::ops::Range;

/// Columns of the regression of the residuals of a reading; that of saturation is the last.
const COLUMNS: usize = SATURATION + 1;
const SATURATION: usize = 9;

/// Coefficients of the remaining nonlinearity of a reading, and the covariance of the odd ones.
#[derive(Debug, Clone, Copy)]
pub(super) struct Estimate {
    pub(super) quadratic: f64,
    /// Cubic coefficient and saturation coefficient.
    pub(super) odd: [f64; 2],
    /// Cholesky factor (lower triangular) of their covariance: each of its columns is a change of both
    /// coefficients.
    pub(super) spread: [[f64; 2]; 2],
}

impl Estimate {
    /// Standard errors of the odd coefficients.
    pub(super) fn errors(&self) -> [f64; 2] {
        let [[first, along], [_, across]] = self.spread;
        [first.abs(), along.hypot(across)]
    }

    /// A fraction of the estimate, with the same errors as the whole.
    pub(super) fn times(&self, part: f64) -> Self {
        Self { quadratic: part * self.quadratic, odd: self.odd.map(|c| part * c), ..*self }
    }

    /// The curve with the estimate added.
    pub(super) fn added_to(&self, curve: SensorCurve) -> SensorCurve {
        let [cubic_std_error, saturation_std_error] = self.errors();
        SensorCurve {
            quadratic: curve.quadratic + self.quadratic,
            cubic: curve.cubic + self.odd[0],
            cubic_std_error,
            saturation: curve.saturation + self.odd[1],
            saturation_std_error,
            ..curve
        }
    }
}

/// Cubic coefficient of a tracker that sees the horizontal position `L sin θ` of a pendulum, from the
/// decrease of frequency with amplitude: `f = f₀ (1 + b A²)` with `b = -1/(16 L²)`, and `k = -1/(6 L²)`.
/// `None` if the frequency does not decrease, or if the record is an angle.
pub(super) fn of_pendulum(answer: &Answer) -> Option<f64> {
    let falls = answer.backbone.as_ref().map(|b| b.quadratic).filter(|b| *b < 0.0)?;
    let angle =
        DisplacementUnit::named(&answer.signal_unit).is_some_and(|u| u.coordinate == Coordinate::Angle);
    (!angle).then_some(8.0 / 3.0 * falls)
}

/// Ratio of the spectral density of the residuals at the harmonics to that of white noise, at least 1.
fn excess_over_white(samples: &Samples, range: Range<usize>, answer: &Answer) -> f64 {
    let time = &samples.time[range.clone()];
    let left: Vec<f64> =
        time.iter().zip(&samples.signal[range]).map(|(t, s)| s - answer.fit.signal_at(*t)).collect();
    let frequency_hz = answer.parameter(Parameter::Frequency).map_or(f64::NAN, |q| q.value);
    let density = density_near(time, &left, frequency_hz);
    density.map_or(1.0, |d| d.least_ratio_at_harmonics()).max(1.0)
}

/// The nonlinearity of the reading of a fitted motion, estimated from its harmonics; `None` if they are not
/// those of a sensor curve. If a curve was already `found`, the remaining nonlinearity counts however small
/// it is.
///
/// The curve of a `pendulum` with this cubic coefficient is accepted if the third harmonic, which is hidden
/// by noise, is nearer to that coefficient than to zero; the estimate is then constrained to be near it.
pub(super) fn bend(
    samples: &Samples,
    answer: &Answer,
    criteria: &SensorCriteria,
    found: Option<&SensorCurve>,
    pendulum: Option<f64>,
) -> Option<Estimate> {
    let fit = &answer.fit;
    let [from, to] = fit.range_s();
    let to = fit.rest_s().unwrap_or(to).min(to);
    let range = samples.time.partition_point(|t| *t < from)..samples.time.partition_point(|t| *t <= to);
    let first = fit.amplitude_at(from);
    if !(first > 0.0) {
        return None;
    }
    let so_far = found.copied().unwrap_or_default();
    let coloured = excess_over_white(samples, range.clone(), answer);
    let sums = |falls: Falls| {
        let mut sums = Normal::zeros(COLUMNS);
        for (t, s) in samples.time[range.clone()].iter().zip(&samples.signal[range.clone()]) {
            let Some(at) = fit.phase_at(*t) else { continue };
            let left = s - fit.signal_at(*t);
            if left.is_finite() {
                let amplitude = fit.amplitude_at(*t);
                // A component that is even in the reading is not even in the straightened reading.
                let weight = so_far.odd_slope(amplitude * at.phase.cos()).powi(2);
                sums.add_row(&row(&so_far, amplitude, at.phase, first, falls), left, weight);
            }
        }
        sums
    };
    let mut by_powers = sums(Falls::ByPowers);
    let unsaturated: Vec<usize> = (0..SATURATION).collect();
    let (c, covariance, rss) = linear_of(&by_powers, &unsaturated)?;
    let free = COLUMNS + answer.parameters.iter().count();
    let dof = range.len().checked_sub(free).filter(|n| *n > 0)? as f64;
    // Noise that is stronger at low frequencies produces apparent harmonics.
    let variance = coloured * rss / dof;
    let error = |i: usize| (variance * covariance[(i, i)]).sqrt();
    let in_phase =
        |i: usize| c[i].abs() + criteria.phase_errors * error(i + 1) > criteria.in_phase * c[i + 1].abs();
    // A spring that changes the frequency by a relative amount through stiffening has a third harmonic of a
    // twelfth of that amount.
    let of_spring = answer.backbone.as_ref().map_or(0.0, |b| b.quadratic) / 3.0;
    // A harmonic that is not observed is no evidence for a curve, whatever a spring would produce.
    let third = in_phase(0) && c[0].abs() > criteria.significance * error(0);
    let second = in_phase(2) && c[2].abs() > criteria.quadratic_significance * error(2);
    let in_proportion = || linear_of(&sums(Falls::InProportion), &unsaturated).map(|(.., rss)| rss);
    let counts = match pendulum {
        Some(k) => found.is_some() || in_phase(0) && c[0] - of_spring < criteria.pendulum * k,
        None => found.is_some() || (third || second) && rss < in_proportion()?,
    };
    if !counts {
        return None;
    }
    let third = third || pendulum.is_some() || so_far.cubic != 0.0;
    let second = second || so_far.quadratic != 0.0;
    // Prior knowledge enters as an additional measurement.
    let mut expect = |column: usize, mean: f64, width: f64| {
        let mut row = [0.0; COLUMNS];
        row[column] = 1.0;
        by_powers.add_row(&row, mean, variance / width.powi(2));
    };
    if let Some(k) = pendulum {
        expect(0, k - so_far.cubic + of_spring, criteria.pendulum * k);
    }
    if so_far.cubic < 0.0 {
        let [mean, width] = [criteria.saturation, criteria.saturation_width].map(|part| part * -so_far.cubic);
        expect(SATURATION, mean - so_far.saturation, width);
    }
    let (c, covariance, _) = linear_of(&by_powers, &unsaturated)?;
    let quadratic = if second { c[2] } else { 0.0 };
    let cubic = if third { c[0] - of_spring } else { 0.0 };
    let cubic_error = (variance * covariance[(0, 0)]).sqrt();
    let unsaturated = Estimate { quadratic, odd: [cubic, 0.0], spread: [[cubic_error, 0.0], [0.0; 2]] };
    if !(so_far.cubic < 0.0) {
        return Some(unsaturated);
    }
    let all: Vec<usize> = (0..COLUMNS).collect();
    let Some((c, covariance, _)) = linear_of(&by_powers, &all) else { return Some(unsaturated) };
    let [kk, kr, rr] =
        [(0, 0), (0, SATURATION), (SATURATION, SATURATION)].map(|at| variance * covariance[at]);
    let along = kr / kk.sqrt();
    let spread = [[kk.sqrt(), along], [0.0, (rr - along * along).max(0.0).sqrt()]];
    // A curve that flattens does not steepen again: at this limit the cubic coefficient is re-optimised.
    let saturation = c[SATURATION].max(-so_far.saturation);
    let cubic = c[0] - of_spring + kr / rr * (saturation - c[SATURATION]);
    Some(Estimate { quadratic, odd: [cubic, saturation], spread })
}

/// Dependence of the harmonics of a motion on its amplitude.
#[derive(Debug, Clone, Copy)]
enum Falls {
    /// Powers of the amplitude, as for a sensor curve.
    ByPowers,
    /// Proportional to the amplitude, as for electronics.
    InProportion,
}

/// Regression row: changes of the straightened reading by the cubic coefficient, with the third harmonic in
/// quadrature; by the quadratic coefficient, with the second harmonic in quadrature, its mean and a level; at
/// the fundamental frequency, where the fitted motion has absorbed its part; and by saturation.
fn row(curve: &SensorCurve, amplitude: f64, phase: f64, first: f64, falls: Falls) -> [f64; COLUMNS] {
    let [(sin_2, cos_2), (sin_3, cos_3)] = [(2.0 * phase).sin_cos(), (3.0 * phase).sin_cos()];
    let x = amplitude * phase.cos();
    let (third, second, by_odd) = match falls {
        Falls::ByPowers => {
            let slope = curve.odd_slope(x);
            (0.25 * amplitude.powi(3), 0.5 * amplitude * amplitude, curve.by_odd(x).map(|by| by / slope))
        }
        Falls::InProportion => (amplitude, amplitude, [amplitude * cos_3, 0.0]),
    };
    let a = (amplitude / first).powi(2);
    let even = [second * cos_2, second * sin_2, second, 1.0];
    let [e0, e1, e2, e3] = even;
    [by_odd[0], third * sin_3, e0, e1, e2, e3, x, a * x, a * a * x, by_odd[1]]
}
