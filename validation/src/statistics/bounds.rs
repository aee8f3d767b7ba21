//! Smallest standard errors that an unbiased estimator can have (Cramér and Rao).

use std::f64::consts::PI;

use nalgebra::DMatrix;
use slipfit::Oscillator;
use slipfit::motion::decay::{AmplitudeLaw, FreeDecay};

/// Cramér-Rao standard errors of delta and x_F with amplitude, phase, frequency and offset free,
/// from central differences of the exact motion. Order of `truth`: amplitude, delta, x_F, time of
/// release, omega_0, offset.
pub(super) fn of_motion(truth: [f64; 6], time: &[f64], sigma: f64) -> [f64; 2] {
    let motion = |[amplitude, delta, x_f, earlier, omega_0, offset]: [f64; 6]| -> Vec<f64> {
        let shifted: Vec<f64> = time.iter().map(|t| (t + earlier).max(0.0)).collect();
        let mut out = vec![0.0; time.len()];
        let filled = Oscillator::kinematic(omega_0, delta.max(0.0), x_f.max(0.0))
            .and_then(|oscillator| FreeDecay::from_rest(&oscillator, amplitude))
            .and_then(|decay| decay.fill(&shifted, &mut out));
        if filled.is_err() {
            out.fill(f64::NAN);
        }
        out.iter().map(|x| x + offset).collect()
    };
    // The two parameters of interest come first.
    let columns: Vec<Vec<f64>> = [1, 2, 0, 3, 4, 5]
        .into_iter()
        .map(|k| {
            let step = match k {
                1 => 1e-4 * truth[1],
                2 => 1e-4 * truth[2].max(1e-3 * truth[1] / truth[4]),
                3 => 1e-6,
                4 => 1e-7 * truth[1].max(1e-2),
                _ => 1e-5,
            };
            // One-sided at the limits x_F = 0 and t = 0.
            let back = if (k == 2 && truth[2] == 0.0) || k == 3 { 0.0 } else { step };
            let moved = |by: f64| {
                let mut parameters = truth;
                parameters[k] += by;
                motion(parameters)
            };
            moved(step).iter().zip(&moved(-back)).map(|(a, b)| (a - b) / (step + back)).collect()
        })
        .collect();
    information_bound(&columns, sigma)
}

/// Bounds for amplitudes alone, sampled at `time` with noise `sigma`: decay rate and friction displacement with the
/// first amplitude free.
pub(super) fn of_amplitudes(oscillator: &Oscillator, amplitude: f64, time: &[f64], sigma: f64) -> [f64; 2] {
    let truth = [oscillator.decay_rate_per_s(), oscillator.friction_displacement(), amplitude];
    let omega = oscillator.omega_0();
    let law = |[delta, x_f, amplitude]: [f64; 3]| -> Option<Vec<f64>> {
        let law = AmplitudeLaw::new(amplitude, 2.0 * omega * x_f / PI, delta, 0.0).ok()?;
        Some(time.iter().map(|&t| law.amplitude(t).max(0.0)).collect())
    };
    let column = |k: usize| -> Option<Vec<f64>> {
        let step = 1e-5 * [truth[0], truth[1].max(truth[0] * amplitude / omega), truth[2]][k];
        let back = if k == 1 && truth[1] == 0.0 { 0.0 } else { step };
        let moved = |by: f64| {
            let mut parameters = truth;
            parameters[k] += by;
            law(parameters)
        };
        let (up, down) = (moved(step)?, moved(-back)?);
        Some(up.iter().zip(&down).map(|(a, b)| (a - b) / (step + back)).collect())
    };
    let Some(columns) = (0..3).map(column).collect::<Option<Vec<_>>>() else { return [f64::NAN; 2] };
    information_bound(&columns, sigma)
}

/// Bounds of the first two parameters from the derivatives by all of them, with noise `sigma` at each sample.
fn information_bound(columns: &[Vec<f64>], sigma: f64) -> [f64; 2] {
    let information = DMatrix::from_fn(columns.len(), columns.len(), |i, j| {
        columns[i].iter().zip(&columns[j]).map(|(a, b)| a * b).sum::<f64>() / (sigma * sigma)
    });
    let all: Vec<usize> = (0..columns.len()).collect();
    cramer_rao(&information, &all).unwrap_or([f64::NAN; 2])
}

/// Cramér-Rao standard errors of the first two parameters from an information matrix of which the parameters `kept`
/// are free; `None` if it is singular.
pub(super) fn cramer_rao(information: &DMatrix<f64>, kept: &[usize]) -> Option<[f64; 2]> {
    let part = |i: usize, j: usize| information[(kept[i], kept[j])];
    // Scaled to unit diagonal first: rates and lengths differ by many orders of magnitude.
    let scale: Vec<f64> = (0..kept.len()).map(|i| 1.0 / part(i, i).sqrt()).collect();
    let unit = DMatrix::from_fn(kept.len(), kept.len(), |i, j| part(i, j) * scale[i] * scale[j]);
    let inverse = unit.try_inverse()?;
    Some([0, 1].map(|i| inverse[(i, i)].sqrt() * scale[i]))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn correlated_parameters_widen_each_others_bounds() {
        let information = DMatrix::from_row_slice(3, 3, &[4.0, 0.0, 0.0, 0.0, 1.0, 0.6, 0.0, 0.6, 1.0]);
        let alone = cramer_rao(&information, &[0, 1]).unwrap();
        assert_eq!(alone, [0.5, 1.0]);
        let [rate, friction] = cramer_rao(&information, &[0, 1, 2]).unwrap();
        assert!((rate - 0.5).abs() < 1e-12, "{rate}");
        assert!((friction - 1.25).abs() < 1e-12, "{friction}");
    }
}
