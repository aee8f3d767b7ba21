//! Noise near the frequency of the motion, if it exceeds the noise inside single cycles.

use super::criteria::ColouredNoiseCriteria;
use super::samples::Samples;
use super::{Answer, EndReason};
use crate::Parameter;
use crate::answer::MisfitShape;
use crate::inference::noise::autocorrelation;
use crate::inference::noise_law::{Scale, Scatter, most_likely, scale_at};
use crate::numeric::robust::median;
use crate::signal::blocks::{Block, PhaseAt, demodulate};
use std::f64::consts::{LN_2, TAU};

/// Rounds of measuring the noise and analysing the record again.
const ROUNDS: usize = 2;
/// Minimum number of samples for the amplitude of a stretch.
const LEAST_SAMPLES: usize = 6;
/// Decades of the ratio of relative to absolute variance on either side of equality, and steps per decade.
const DECADES: i32 = 6;
const PER_DECADE: i32 = 10;

/// The answer of `refit` with the noise that the amplitudes show, if that exceeds the noise inside single
/// cycles.
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
        // Recorded amplitudes and records of one or two cycles have their own noise estimate.
        let taken = |found: &Answer| found.diagnostics.noise_rms > before;
        let Some(mut found) = refit(samples.clone()).filter(taken) else { break };
        found.diagnostics.noise_inflation = samples.noise_inflation;
        found.diagnostics.noise_rms /= samples.noise_inflation.sqrt();
        found.diagnostics.signal_to_noise_db += 10.0 * samples.noise_inflation.log10();
        answer = found;
    }
    answer
}

/// Ratio of the noise variance of the amplitudes to that expected from the noise inside single cycles; `None`
/// if the amplitudes scatter by no more, if their scatter is proportional to the amplitude, or if their
/// residuals have a shape.
///
/// Inside a cycle low-frequency noise looks like an offset and a slope. Noise with a spectral density that
/// falls with frequency (1/f, AR(1)) is therefore underestimated there, and its scatter resembles a law in
/// error by a fraction of the amplitude.
fn noise_inflation(answer: &Answer, criteria: &ColouredNoiseCriteria) -> Option<f64> {
    let used = || answer.envelope.iter().filter(|p| p.used && p.std_error > 0.0 && p.fitted.is_finite());
    let points: Vec<Scatter> = used()
        .map(|p| Scatter {
            square: p.fitted.powi(2),
            floor: p.std_error.powi(2),
            sum_of_squares: (p.amplitude - p.fitted).powi(2),
            count: 1.0,
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
    // Zero, or from a ratio too small to affect any amplitude to one at which it dominates all noise.
    let mean = |value: fn(&Scatter) -> f64| points.iter().map(value).sum::<f64>() / n;
    let equal = mean(|p| p.floor) / mean(|p| p.square).max(f64::MIN_POSITIVE);
    let grid = (-DECADES * PER_DECADE..=DECADES * PER_DECADE)
        .map(|i| equal * 10f64.powf(f64::from(i) / f64::from(PER_DECADE)));
    let ratios = || std::iter::once(0.0).chain(grid.clone());
    let relative = most_likely(&points, ratios(), Scale::Known)?;
    let both = most_likely(&points, ratios(), Scale::Estimated)?;
    let inflation = scale_at(&points, both.ratio);
    let gain = relative.minus_two_log - both.minus_two_log;
    (inflation > 1.0 && gain > criteria.significance.powi(2)).then_some(inflation)
}

/// The same ratio from the signal at the frequency of the motion after the motion has ended. A median is
/// used, so that single disturbances have no effect. `None` if the record ends with the motion or the noise
/// is white.
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
        // At large time values a block may be shorter than the time stamps resolve.
        let end = samples.time.partition_point(|t| *t < start_s + span_s).max(first + 1);
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
    // A power of two normal components has an exponential distribution: its median is ln 2 times its mean.
    let variance = median(&mut powers)? / LN_2;
    let noise = answer.diagnostics.noise_rms.powi(2) * answer.diagnostics.noise_inflation;
    let inflation = variance / noise;
    // The median of n exponential values has a relative error of 1/(ln 2 sqrt(n)).
    let error = 1.0 / (LN_2 * n.sqrt());
    (inflation.is_finite() && inflation > 1.0 + criteria.significance * error).then_some(inflation)
}
