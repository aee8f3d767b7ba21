//! Noise about the frequency of the motion, where it is more than the noise inside single cycles.

use super::criteria::ColouredNoiseCriteria;
use super::samples::Samples;
use super::{Answer, EndReason};
use crate::Parameter;
use crate::answer::MisfitShape;
use crate::inference::noise::autocorrelation;
use crate::numeric::robust::median;
use crate::signal::blocks::{Block, PhaseAt, demodulate};
use std::f64::consts::{LN_2, TAU};

/// Rounds in which the noise is measured and the record looked at again.
const ROUNDS: usize = 2;
/// Samples without which a stretch has no amplitude.
const LEAST_SAMPLES: usize = 6;

/// The answer by `refit` with the noise that the amplitudes show, where that is more than the noise
/// inside single cycles.
pub(crate) fn with_coloured_noise<'a>(
    mut samples: Samples<'a>,
    mut answer: Answer,
    criteria: &ColouredNoiseCriteria,
    refit: impl Fn(Samples<'a>) -> Option<Answer>,
) -> Answer {
    for _ in 0..ROUNDS {
        let by_scatter = || noise_inflation(&answer, criteria);
        let at_rest = inflation_at_rest(&samples, &answer, criteria);
        let Some(inflation) = at_rest.or_else(by_scatter) else { break };
        samples.noise_inflation *= inflation;
        let before = answer.diagnostics.noise_rms * answer.diagnostics.noise_inflation.sqrt();
        // Recorded amplitudes and records of a cycle or two have a noise of their own.
        let taken = |found: &Answer| found.diagnostics.noise_rms > before;
        let Some(mut found) = refit(samples.clone()).filter(taken) else { break };
        found.diagnostics.noise_inflation = samples.noise_inflation;
        found.diagnostics.noise_rms /= samples.noise_inflation.sqrt();
        found.diagnostics.signal_to_noise_db += 10.0 * samples.noise_inflation.log10();
        answer = found;
    }
    answer
}

/// Variance of the noise of the amplitudes over that which the noise inside single cycles gives;
/// `None` where the amplitudes scatter by no more, where what they scatter by goes with the
/// amplitude, or where their residuals have a shape.
///
/// Inside a cycle the noise of low frequencies looks like an offset and a slope. Noise with a
/// spectral density that falls with frequency (1/f, AR(1)) is therefore underestimated there, and its
/// scatter looks like a law that errs.
fn noise_inflation(answer: &Answer, criteria: &ColouredNoiseCriteria) -> Option<f64> {
    let used = || answer.envelope.iter().filter(|p| p.used && p.std_error > 0.0 && p.fitted.is_finite());
    let points: Vec<ScatterPoint> = used()
        .map(|p| ScatterPoint {
            squared_residual: (p.amplitude - p.fitted).powi(2),
            noise_variance: p.std_error.powi(2),
            squared_amplitude: p.fitted.powi(2),
        })
        .collect();
    let n = points.len() as f64;
    let shapeless = answer.diagnostics.misfit.is_none_or(|m| m.shape == MisfitShape::Scatter);
    let enough = answer.diagnostics.residual_excess > 1.0 + criteria.significance * (2.0 / n).sqrt();
    if points.len() < criteria.least_points || !shapeless || !enough {
        return None;
    }
    let scaled: Vec<f64> = used().map(|p| (p.amplitude - p.fitted) / p.std_error).collect();
    if autocorrelation(&scaled).abs() > criteria.significance / n.sqrt() {
        return None;
    }
    let relative = best_over_ratios(&points, |points, ratio| log_likelihood(points, 1.0, ratio));
    let both = best_over_ratios(&points, |points, ratio| {
        log_likelihood(points, inflation_at(points, ratio), ratio * inflation_at(points, ratio))
    });
    let inflation = inflation_at(&points, both.ratio);
    let gain = 2.0 * (both.log_likelihood - relative.log_likelihood);
    (inflation > 1.0 && gain > criteria.significance.powi(2)).then_some(inflation)
}

/// The same by what oscillates at the frequency of the motion after it: a median, so that single
/// disturbances do not count. `None` where the record ends with the motion or the noise is white.
fn inflation_at_rest(samples: &Samples, answer: &Answer, criteria: &ColouredNoiseCriteria) -> Option<f64> {
    if !matches!(answer.segment.end_reason, EndReason::Noise | EndReason::Rest) {
        return None;
    }
    let frequency_hz = answer.parameter(Parameter::Frequency)?.value;
    let mut spacings: Vec<f64> =
        answer.envelope.windows(2).filter(|w| w[1].used).map(|w| w[1].time_s - w[0].time_s).collect();
    let span_s = median(&mut spacings)?;
    let last = answer.envelope.iter().rfind(|p| p.used)?;
    let visible = |t: f64| answer.fit.amplitude_at(t) > criteria.hidden * last.std_error;
    let from_s = answer.segment.end_s.max(last.time_s) + span_s;
    let mut first = samples.time.partition_point(|t| *t < from_s);
    let mut blocks = Vec::new();
    while first < samples.len() {
        let start_s = samples.time[first];
        let end = samples.time.partition_point(|t| *t < start_s + span_s);
        if end == samples.len() {
            break;
        }
        if !visible(start_s) && end - first >= LEAST_SAMPLES {
            blocks.push(Block { span_s, ..Block::of(first, end, start_s + 0.5 * span_s) });
        }
        first = end;
    }
    if blocks.len() < criteria.least_points / 2 {
        return None;
    }
    let omega = TAU * frequency_hz;
    let phases = vec![PhaseAt { phase: 0.0, omega, chirp: 0.0, loss: 0.0 }; blocks.len()];
    let found = demodulate(&samples.time, &samples.signal, &blocks, &phases);
    let mut powers: Vec<f64> =
        found.iter().map(|b| 0.5 * (b.amplitude.powi(2) + b.quadrature.powi(2)) / b.unit_variance).collect();
    let n = powers.len() as f64;
    // A power of two normal parts is exponential: its median is ln 2 of its mean.
    let variance = median(&mut powers)? / LN_2;
    let noise = answer.diagnostics.noise_rms.powi(2) * answer.diagnostics.noise_inflation;
    let inflation = variance / noise;
    // The median of n exponential values is known to a part of 1/(ln 2 sqrt(n)).
    let error = 1.0 / (LN_2 * n.sqrt());
    (inflation.is_finite() && inflation > 1.0 + criteria.significance * error).then_some(inflation)
}

/// One amplitude's residual with what it may come from.
struct ScatterPoint {
    squared_residual: f64,
    noise_variance: f64,
    squared_amplitude: f64,
}

/// Log-likelihood of residuals of variance `inflation v + relative A²`.
fn log_likelihood(points: &[ScatterPoint], inflation: f64, relative: f64) -> f64 {
    points
        .iter()
        .map(|p| {
            let variance = inflation * p.noise_variance + relative * p.squared_amplitude;
            -0.5 * (variance.ln() + p.squared_residual / variance)
        })
        .sum()
}

/// The most likely inflation for a variance `inflation (v + ratio A²)`.
fn inflation_at(points: &[ScatterPoint], ratio: f64) -> f64 {
    let sum: f64 =
        points.iter().map(|p| p.squared_residual / (p.noise_variance + ratio * p.squared_amplitude)).sum();
    sum / points.len() as f64
}

struct BestRatio {
    ratio: f64,
    log_likelihood: f64,
}

/// The ratio of relative to absolute variance of the highest likelihood: none, or one on a
/// logarithmic grid from what no point sees to what hides the noise of every point.
fn best_over_ratios(
    points: &[ScatterPoint],
    log_likelihood: impl Fn(&[ScatterPoint], f64) -> f64,
) -> BestRatio {
    const STEPS: i32 = 60;
    let mean = |value: fn(&ScatterPoint) -> f64| points.iter().map(value).sum::<f64>() / points.len() as f64;
    let scale = mean(|p| p.noise_variance) / mean(|p| p.squared_amplitude).max(f64::MIN_POSITIVE);
    let grid = (-STEPS..=STEPS).map(|i| scale * 10f64.powf(0.1 * f64::from(i)));
    std::iter::once(0.0)
        .chain(grid)
        .map(|ratio| BestRatio { ratio, log_likelihood: log_likelihood(points, ratio) })
        .filter(|b| b.log_likelihood.is_finite())
        .max_by(|a, b| a.log_likelihood.total_cmp(&b.log_likelihood))
        .unwrap_or(BestRatio { ratio: 0.0, log_likelihood: f64::NEG_INFINITY })
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::noise::jitter;

    fn points(absolute: f64, relative: f64) -> Vec<ScatterPoint> {
        (0..400)
            .map(|i| {
                let amplitude = (-0.01 * f64::from(i)).exp();
                let deviation = 1e-3 * absolute.hypot(relative * 1e3 * amplitude);
                ScatterPoint {
                    squared_residual: (deviation * jitter(i as usize, 3)).powi(2),
                    noise_variance: 1e-6,
                    squared_amplitude: amplitude * amplitude,
                }
            })
            .collect()
    }

    #[test]
    fn scatter_of_noise_is_told_from_scatter_of_the_law() {
        let likelihood = |points: &[ScatterPoint], ratio: f64| {
            log_likelihood(points, inflation_at(points, ratio), ratio * inflation_at(points, ratio))
        };
        let noise = points(4.0, 0.0);
        let best = best_over_ratios(&noise, likelihood);
        assert!((inflation_at(&noise, best.ratio) / 16.0 - 1.0).abs() < 0.3);
        let law = points(1.0, 0.02);
        let best = best_over_ratios(&law, likelihood);
        let inflation = inflation_at(&law, best.ratio);
        assert!((inflation - 1.0).abs() < 0.5, "{inflation}");
        assert!((best.ratio * inflation / 4e-4 - 1.0).abs() < 0.5, "{}", best.ratio);
    }
}
