//! Generalised least-squares fit of all measurements with shared parameters.

use super::answer::Joint;
use super::likelihood::hartung_knapp_factor;
use super::solved::SolvedMeasurement;
use super::{Condition, Data, Measurement, Options};
use crate::answer::Parameter;
use crate::inference::Z_95;
use crate::inference::evidence::chi_square_tail;
use crate::model::loss::LossModel;
use crate::{Quantity, resonance};
use nalgebra::{DMatrix, DVector, Vector2};

/// A friction-free reference curve of several sweeps, and the drive amplitude that it determines by itself.
pub(super) struct Reference {
    value: f64,
    std_error: f64,
    sweeps: usize,
}

/// The references used by more than one sweep.
///
/// A sweep with a reference has `C⁻¹ = S + h h'/σ_r²`: the information from its own shape, and that from the
/// reference about the drive amplitude `h`. For `m` sweeps with one reference, `m - 1` of the contributions of the
/// reference are subtracted.
pub(super) fn references(solved: &[SolvedMeasurement], measurements: &[Measurement]) -> Vec<Reference> {
    let mut seen: Vec<(&resonance::Curve, f64, Vec<&SolvedMeasurement>)> = Vec::new();
    for s in solved.iter().filter(|s| s.drive.is_some()) {
        let m = &measurements[s.measurement];
        let Data::Sweep { options, .. } = &m.data else { continue };
        let Some(curve) = &options.reference else { continue };
        match seen.iter_mut().find(|(known, scale, _)| *known == curve && *scale == m.scale) {
            Some((_, _, sweeps)) => sweeps.push(s),
            None => seen.push((curve, m.scale, vec![s])),
        }
    }
    let shared = seen.into_iter().filter(|(_, _, sweeps)| sweeps.len() > 1);
    let alone = |(curve, scale, sweeps): (&resonance::Curve, f64, Vec<&SolvedMeasurement>)| {
        let viscous = resonance::Options { model: Some(LossModel::VISCOUS), ..resonance::Options::default() };
        let answer = resonance::analyse(curve, &viscous).ok()?;
        let drive = answer.parameter(Parameter::DriveAmplitude)?;
        // A sweep cannot have a larger error of the drive amplitude than its reference; if it does, their noise was
        // estimated differently.
        let widest = sweeps.iter().filter_map(|s| s.drive).map(|d| d.0[1]).fold(0.0, f64::max);
        let own = answer.error_given_terms(Parameter::DriveAmplitude)?;
        let std_error = (own * scale).max(widest);
        let determined = std_error > 0.0 && std_error.is_finite();
        determined.then_some(Reference { value: drive.value * scale, std_error, sweeps: sweeps.len() })
    };
    shared.filter_map(alone).collect()
}

/// Generalised least-squares fit of all measurements analysed alone; intervals are at least `least_spread` times as
/// wide as normal ones.
pub(super) fn joint(
    solved: &[SolvedMeasurement],
    references: &[Reference],
    measurements: &[Measurement],
    labels: &[&Condition],
    options: &Options,
    least_spread: f64,
) -> Option<Joint> {
    if solved.len() < 2 {
        return None;
    }
    let shared = options.shared;
    // Unknowns: friction per condition, damping per condition or one, then the shared ones.
    let n = labels.len();
    let dampings = if shared.decay_rate { 1 } else { n };
    let frequency_at = n + dampings;
    let with_frequency = shared.natural_frequency && solved.iter().any(|s| s.measured_frequency().is_some());
    let drive_at = frequency_at + usize::from(with_frequency);
    let with_drive = shared.drive_amplitude && solved.iter().any(|s| s.drive.is_some());
    // And the common disturbance of all measurements, 0 ± 1.
    let together = drive_at + usize::from(with_drive);
    let with_shared = solved.iter().any(|s| s.shared != Vector2::zeros());
    let unknowns = together + usize::from(with_shared);
    // Relative to typical values, so that hertz and metres can share a matrix.
    let scale = |k: usize| -> f64 {
        let typical =
            |v: &mut dyn Iterator<Item = f64>| v.map(f64::abs).fold(0.0, f64::max).max(f64::MIN_POSITIVE);
        if k == together {
            1.0
        } else if k < n {
            typical(&mut solved.iter().map(|s| s.covariance[(1, 1)].sqrt()))
        } else if k < frequency_at {
            typical(&mut solved.iter().map(|s| s.covariance[(0, 0)].sqrt()))
        } else if with_frequency && k == frequency_at {
            typical(&mut solved.iter().filter_map(|s| s.measured_frequency().map(|f| f[1])))
        } else {
            typical(&mut solved.iter().filter_map(|s| s.drive.map(|d| d.0[1])))
        }
    };
    let centre = solved.iter().find_map(SolvedMeasurement::measured_frequency).map_or(0.0, |f| f[0]);
    let scales: Vec<f64> = (0..unknowns).map(scale).collect();
    let mut normal = DMatrix::<f64>::zeros(unknowns, unknowns);
    let mut rhs = DVector::<f64>::zeros(unknowns);
    let (mut total, mut observations) = (0.0, 0);
    for s in solved {
        let label = &measurements[s.measurement].condition.label;
        let condition = labels.iter().position(|c| c.label == *label)?;
        let damping = n + if shared.decay_rate { 0 } else { condition };
        let mut place = vec![damping, condition];
        let mut value = vec![s.value[0], s.value[1]];
        let mut covariance = DMatrix::<f64>::zeros(2, 2);
        covariance.view_mut((0, 0), (2, 2)).copy_from(&s.covariance);
        let mut grow = |k: usize, v: f64, std: f64, rho: [f64; 2], covariance: &mut DMatrix<f64>| {
            let m = value.len();
            place.push(k);
            value.push(v);
            let old = covariance.clone();
            *covariance = DMatrix::zeros(m + 1, m + 1);
            covariance.view_mut((0, 0), (m, m)).copy_from(&old);
            covariance[(m, m)] = std * std;
            for (i, r) in rho.iter().enumerate() {
                let c = r.clamp(-0.999_999, 0.999_999) * std * old[(i, i)].sqrt();
                (covariance[(i, m)], covariance[(m, i)]) = (c, c);
            }
        };
        if with_drive && let Some(([v, std], rho)) = s.drive {
            grow(drive_at, v, std, rho, &mut covariance);
        }
        if with_frequency && let Some([v, std]) = s.measured_frequency() {
            grow(frequency_at, v - centre, std, [0.0; 2], &mut covariance);
        }
        // Three pairwise correlations from rounded answers need not be consistent.
        let inverse = covariance.clone().cholesky().map(|c| c.inverse()).or_else(|| {
            let m = covariance.nrows();
            let bare =
                DMatrix::from_fn(
                    m,
                    m,
                    |i, j| if i == j || (i < 2 && j < 2) { covariance[(i, j)] } else { 0.0 },
                );
            bare.cholesky().map(|c| c.inverse())
        })?;
        let mut add = |i: usize, j: usize, w: f64| {
            normal[(i, j)] += w * scales[i] * scales[j];
        };
        for i in 0..value.len() {
            for j in 0..value.len() {
                let w = inverse[(i, j)];
                add(place[i], place[j], w);
                rhs[place[i]] += w * value[j] * scales[place[i]];
                total += w * value[i] * value[j];
                if with_shared {
                    let [a, b] = [i, j].map(|k| s.shared.get(k).copied().unwrap_or(0.0));
                    add(place[i], together, w * b);
                    add(together, place[j], w * a);
                    add(together, together, w * a * b);
                    rhs[together] += w * a * value[j];
                }
            }
        }
        observations += value.len();
    }
    if with_shared {
        normal[(together, together)] += 1.0;
        observations += 1;
    }
    // Every sweep includes its reference: each reference must count once.
    for reference in references.iter().filter(|_| with_drive) {
        let again = (reference.sweeps - 1) as f64 / reference.std_error.powi(2);
        normal[(drive_at, drive_at)] -= again * scales[drive_at].powi(2);
        rhs[drive_at] -= again * reference.value * scales[drive_at];
        total -= again * reference.value.powi(2);
        // The information of the shapes, and the reference.
        observations += 1;
    }
    let cholesky = normal.clone().cholesky()?;
    let solution = cholesky.solve(&rhs);
    let covariance = cholesky.inverse();
    let chi_square = (total - solution.dot(&rhs)).max(0.0);
    let degrees_of_freedom = observations.saturating_sub(unknowns);
    if degrees_of_freedom == 0 {
        return None;
    }
    // As for the mean of one condition.
    let reduced = chi_square / degrees_of_freedom as f64;
    let widen = hartung_knapp_factor(reduced, degrees_of_freedom as f64).max(least_spread);
    let quantity = |k: usize, offset: f64, unit: &str| {
        let std_error = (covariance[(k, k)] * reduced.max(1.0)).sqrt() * scales[k];
        let value = solution[k] * scales[k] + offset;
        let half = Z_95 * widen * covariance[(k, k)].sqrt() * scales[k];
        Quantity { interval_95: [value - half, value + half], ..Quantity::normal(value, std_error, unit) }
    };
    Some(Joint {
        natural_frequency_hz: with_frequency.then(|| quantity(frequency_at, centre, "Hz")),
        drive_amplitude: with_drive.then(|| quantity(drive_at, 0.0, &options.unit)),
        decay_rate_per_s: shared.decay_rate.then(|| quantity(n, 0.0, "1/s")),
        chi_square,
        degrees_of_freedom,
        p_value: chi_square_tail(chi_square, degrees_of_freedom as f64),
    })
}

#[cfg(test)]
mod tests {
    use super::super::analyse;
    use super::*;
    use crate::Oscillator;
    use crate::motion::steady::{Phasor, scan};
    use crate::noise::jitter;

    /// Five loads with one friction-free curve for all: its noise must not be averaged away.
    #[test]
    fn one_reference_of_many_sweeps_counts_once() {
        const SEEDS: u64 = 60;
        let sweep = |x_f: f64, seed: u64| {
            let o = Oscillator::builder()
                .frequency_hz(2.0)
                .q_factor(80.0)
                .friction_displacement(x_f)
                .build()
                .unwrap();
            let hz: Vec<f64> = (0..61).map(|i| 1.9 + 0.2 * f64::from(i) / 60.0).collect();
            let noisy = |(i, hz): (usize, &f64)| {
                let r = scan::reading(&o, 0.3, *hz).unwrap();
                r.fundamental + Phasor::new(0.05 * jitter(i, seed), 0.05 * jitter(i, seed + 1))
            };
            let z = hz.iter().enumerate().map(noisy).collect();
            resonance::Curve::complex(hz, z).unit("mm").build().unwrap()
        };
        let mut square = 0.0;
        for seed in 0..SEEDS {
            let reference = sweep(0.0, 1000 * seed + 500);
            let measurement = |i: u64| Measurement {
                name: format!("load {i}"),
                condition: Condition { label: i.to_string(), value: None },
                data: Data::Sweep {
                    curve: Box::new(sweep(0.03 * i as f64, 1000 * seed + 10 * i)),
                    options: Box::new(resonance::Options {
                        reference: Some(reference.clone()),
                        ..resonance::Options::default()
                    }),
                },
                scale: 1.0,
            };
            let all: Vec<Measurement> = (1..=5).map(measurement).collect();
            let mut options = Options { unit: "mm".into(), ..Options::default() };
            options.shared.drive_amplitude = true;
            let drive = analyse(&all, &options).unwrap().joint.unwrap().drive_amplitude.unwrap();
            square += ((drive.value - 0.3) / drive.std_error).powi(2);
        }
        let pull = (square / SEEDS as f64).sqrt();
        // Its own uncertainty is 9 %.
        assert!((pull - 1.0).abs() < 0.25, "{pull}");
    }
}
