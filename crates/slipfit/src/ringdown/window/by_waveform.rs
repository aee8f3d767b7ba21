//! Whether the residuals of one motion for the samples in a window are noise.

use crate::ringdown::criteria::AgreementCriteria;
use crate::ringdown::envelope::{X_F, law_of};
use crate::ringdown::measured::MeasuredDecay;
use crate::ringdown::residuals::remaining_fundamental;
use crate::ringdown::samples::Samples;
use crate::ringdown::waveform::{OMEGA, Waveform};
use crate::ringdown::window_fit::{Problem, WindowFit};

/// Whether the residuals of every block in the window are noise: in single blocks and in runs of them, in
/// phase and in quadrature.
pub(crate) fn agrees(
    fitted: &WindowFit,
    samples: &Samples,
    measured: &MeasuredDecay,
    criteria: &AgreementCriteria,
) -> bool {
    let Problem::Waveform(problem) = &fitted.problem else { return false };
    let Some(best) = fitted.comparison.preferred() else { return false };
    let residual = problem.residuals(&best.bounded.parameters);
    if !is_noise(&residual, measured.noise_rms.powi(2), criteria) {
        return false;
    }
    let first = samples.time.partition_point(|&t| t < problem.origin);
    let left = remaining_fundamental(problem, first, &residual, &best.bounded, &measured.all);
    let within = |part: fn(&(f64, f64)) -> f64| {
        let values: Vec<f64> = left.iter().map(|v| part(v) / measured.noise_rms).collect();
        let mean_of_run = |w: &[f64]| w.iter().sum::<f64>() / (criteria.run as f64).sqrt();
        values.iter().all(|v| v.abs() < criteria.fundamental_errors)
            && values.windows(criteria.run).all(|w| mean_of_run(w).abs() < criteria.fundamental_errors)
    };
    within(|v| v.0) && within(|v| v.1)
}

/// Whether the mean square of the residuals is consistent with white noise of the given variance.
pub(crate) fn is_noise(residual: &[f64], variance: f64, criteria: &AgreementCriteria) -> bool {
    let n = residual.len() as f64;
    let mean_square = residual.iter().map(|r| r * r).sum::<f64>() / n;
    mean_square <= variance * (1.0 + criteria.scatter_errors * (2.0 / n).sqrt())
}

/// End of the samples up to which the motion fitted to `from..to`, continued, has residuals that are noise.
pub(crate) fn agreeing_end(
    samples: &Samples,
    measured: &MeasuredDecay,
    fitted: &WindowFit,
    from: usize,
    to: usize,
    criteria: &AgreementCriteria,
) -> Option<usize> {
    let Problem::Waveform(problem) = &fitted.problem else { return None };
    let best = &fitted.comparison.preferred()?.bounded;
    let law = law_of(&best.parameters, best.parameters[OMEGA]);
    let variance = fitted.comparison.noise.residual_variance(best);
    let least = (criteria.least_amplitude * law.initial).max(criteria.least_frictions * best.parameters[X_F]);
    // Block by block, then the samples after the last whole one.
    let rest = measured.all.last().map(|b| (b.end, samples.len()));
    let pieces = measured.all.iter().map(|b| (b.first, b.end)).filter(|p| p.0 >= to).chain(rest);
    let mut end = to;
    for (first, last) in pieces.filter(|p| p.1 > p.0) {
        if first > end || law.amplitude(samples.time[first] - fitted.origin) < least {
            break;
        }
        let followed = Waveform {
            time: &samples.time[from..last],
            signal: &samples.signal[from..last],
            ..problem.clone()
        };
        if !is_noise(&followed.residuals(&best.parameters)[first - from..], variance, criteria) {
            break;
        }
        end = last;
    }
    Some(end)
}
