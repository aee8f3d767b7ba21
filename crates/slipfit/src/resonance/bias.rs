//! Second-order bias of least squares.

use super::block::Block;
use super::problem::Problem;
use super::response::{COUNT, X_0};
use crate::inference::least_squares::{Fit, LeastSquares, Normal, newton_step};
use crate::motion::steady::Phasor;

/// Correction of the bias of all parameters, to second order in the noise (M. J. Box, J. R. Stat. Soc. B 33, 171,
/// 1971):
///
/// ```text
/// -bias = C Jᵀ d/2,   d_i = tr(C H_i),   C = variance (JᵀJ)⁻¹
/// ```
///
/// with `H_i` the second derivatives of the model at point `i`, computed here as second differences over one standard
/// error along each axis of `C`. `None` if the model does not exist at one of these points.
pub(super) fn correction(problem: &Problem, fit: &Fit, variance: f64) -> Option<Vec<f64>> {
    let free = &fit.free;
    if !free.iter().map(|&k| fit.unit_std(k)).all(|s| s.is_finite() && s > 0.0) {
        return None;
    }
    let steps = fit.principal_steps();
    let at = |axis: usize, side: f64| {
        let length = side * variance.sqrt();
        fit.parameters.iter().zip(&steps[axis]).map(|(p, step)| p + length * step).collect::<Vec<f64>>()
    };
    let mut moved = centred(problem, &fit.parameters)?;
    for reference in [false, true] {
        let Some(block) = moved.block(reference) else { continue };
        let centre = block.data.clone();
        let mut data = centre.clone();
        for axis in 0..free.len() {
            let up = read(problem, block, &at(axis, 1.0), reference)?;
            let down = read(problem, block, &at(axis, -1.0), reference)?;
            for (i, z) in data.iter_mut().enumerate() {
                *z += (up[i] + down[i] - centre[i] * 2.0) * 0.5;
            }
        }
        match &mut moved.reference {
            Some(r) if reference => r.data = data,
            _ => moved.main.data = data,
        }
    }
    let mut sums = Normal::zeros(COUNT);
    if !moved.normal(&fit.parameters, &mut sums) {
        return None;
    }
    let step = newton_step(&sums, free).filter(|s| s.iter().all(|v| v.is_finite()))?;
    let mut all = vec![0.0; COUNT];
    for (&k, s) in free.iter().zip(step) {
        all[k] = s;
    }
    Some(all)
}

/// The problem with the data replaced by the model, i.e. without residuals.
pub(super) fn centred(problem: &Problem, p: &[f64]) -> Option<Problem> {
    let mut centred = problem.clone();
    centred.main.data = read(problem, &problem.main, p, false)?;
    if let Some(reference) = &mut centred.reference {
        reference.data = read(problem, problem.reference.as_ref()?, p, true)?;
    }
    if let Some([_, weight]) = problem.prior {
        centred.prior = Some([p[X_0], weight]);
    }
    Some(centred)
}

/// The reading that the model predicts at each point.
fn read(problem: &Problem, block: &Block, p: &[f64], reference: bool) -> Option<Vec<Phasor>> {
    let modelled = problem.predict(p, reference).into_iter().enumerate();
    modelled
        .map(|(i, m)| match m {
            Some(m) => Some(block.reading(i, &m)),
            None if block.weight[i] > 0.0 => None,
            None => Some(Phasor::default()),
        })
        .collect()
}

#[cfg(test)]
mod tests {
    use super::super::Curve;
    use super::super::response::{DELTA, OMEGA, X_F};
    use super::*;
    use crate::inference::least_squares::minimise;
    use crate::motion::steady::fundamental::{Point, fundamental};
    use crate::noise::jitter;
    use std::f64::consts::TAU;

    /// Errors of `delta`, as fitted and after the correction, over the noise.
    fn errors(noise: f64, seed: u64) -> Option<[f64; 2]> {
        let (delta, x_f) = (TAU / 100.0, 0.7);
        let hz: Vec<f64> = (0..81).map(|i| 1.0 + 0.001 * f64::from(i - 40)).collect();
        let noisy = |(i, f): (usize, &f64)| {
            let detuning = TAU * (f - 1.0);
            let at = Point { omega: TAU * f, omega_0: TAU, detuning, delta, x_0: 1.0, x_f };
            fundamental(&at).unwrap().value.norm() + noise * jitter(i, seed)
        };
        let amplitudes = hz.iter().enumerate().map(noisy).collect();
        let free = vec![OMEGA, DELTA, X_0, X_F];
        let problem =
            Problem::new(Block::new(&Curve::builder(hz, amplitudes).build().unwrap()), TAU, free.clone());
        let mut start = vec![0.0; COUNT];
        (start[DELTA], start[X_0], start[X_F]) = (delta, 1.0, x_f);
        let fit = minimise(&problem, &start, &free)?;
        let variance = fit.rss / (problem.observations() - free.len() as f64);
        let by = correction(&problem, &fit, variance)?;
        let error = fit.parameters[DELTA] - delta;
        Some([error / noise, (error + by[DELTA]) / noise])
    }

    /// The same noise scaled down by a hundred has negligible second-order effects: the difference of the means is the
    /// bias.
    #[test]
    fn the_bias_of_a_vague_curve_is_corrected() {
        let pairs: Vec<_> = (0..400).filter_map(|s| Some((errors(0.2, s)?, errors(0.002, s)?))).collect();
        let n = pairs.len() as f64;
        let mean = |k: usize| pairs.iter().map(|(large, small)| large[k] - small[k]).sum::<f64>() / n;
        let spread = (pairs.iter().map(|(_, small)| small[0] * small[0]).sum::<f64>() / n).sqrt();
        let (before, after) = (mean(0) / spread, mean(1) / spread);
        assert!(pairs.len() > 380, "{n} {before} {after}");
        assert!(before > 0.15, "{n} {before} {after}");
        assert!(after.abs() < 0.3 * before, "{n} {before} {after}");
    }
}
