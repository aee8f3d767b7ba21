//! Assembles the answer from the fits.

use super::compare::slot;
use super::decay_series::{backbone, envelope_points, fitted_motion, loss_points};
use super::envelope::{A0, DELTA, X_F, law_of};
use super::evidence::Evidence;
use super::fitted::FittedMotion;
use super::free_law::free_law;
use super::measured::BELOW_NOISE;
use super::misfit::misfit;
use super::quantities::{angular_frequency, displacement_of, parameters};
use super::samples::Filtered;
use super::stop::{FittedEnd, stop};
use super::waveform::{OFFSET, OMEGA};
use super::window::EndReason;
use super::window_fit::Problem;
use super::{Answer, Diagnostics, Distortion, EnvelopePoint, OtherMode, Segment, Stop};
use crate::answer::describe::{self, candidates, sliding_evidence};
use crate::answer::{Correlation, Parameter, SlidingEvidence, Values};
use crate::inference::model_selection::{ModelComparison, ModelFit};
use crate::inference::noise::NoiseModel;
use crate::model::loss::LossModel;
use crate::motion::decay::AmplitudeLaw;
use crate::numeric::roots::border;
use crate::signal::blocks::Block;
use crate::signal::spectrum::{self, NoiseFloor};
use crate::{Error, SignalKind};
use std::f64::consts::TAU;
use std::sync::Arc;

pub(crate) fn answer(e: &Evidence) -> Result<Answer, Error> {
    let comparison = &e.fit.comparison;
    let preferred = comparison.preferred().ok_or(Error::NoFit { reason: "no model converged" })?;
    let chosen = match e.options.model {
        Some(model) => comparison.largest_within(model).ok_or(Error::NoFit {
            reason: "the model asked for has more parameters than the record determines",
        })?,
        None => comparison.reported().unwrap_or(preferred),
    };
    if !rms(e, chosen).is_finite() {
        return Err(Error::NoFit { reason: "the amplitude of the best loss model diverges" });
    }
    // An error of the law from cycle to cycle does not put a motion below the noise.
    let noise = NoiseModel { variance_inflation: e.fit.serial_inflation, ..comparison.noise };
    let error = noise.std_error(&chosen.bounded, A0);
    if !(chosen.bounded.parameters[A0] > e.criteria.answer.least_amplitude * error) {
        let needed = e.criteria.blocks.least_cycles;
        return Err(Error::NotARingDown { cycles: e.cycles, needed, reason: BELOW_NOISE });
    }
    let omega = angular_frequency(e, chosen);
    let law = law_of(&chosen.bounded.parameters, omega);
    let duration = e.fit.end - e.fit.origin;
    let shares = [law.initial, last_amplitude(e, &law)].map(|amplitude| law.shares(amplitude)[0]);
    let sliding = SlidingEvidence {
        dominates_from_s: dominates_from(&law, duration, e.criteria.answer.dominating_share)
            .map(|t| e.fit.origin + t),
        ..sliding_evidence(comparison, chosen, shares)
    };
    let fit = fitted_motion(e, chosen, law, omega);
    let envelope = envelope_points(e, chosen, &fit);
    let diagnostics = diagnostics(e, chosen, &law, &envelope);
    let sliding = SlidingEvidence { detected: sliding.detected && diagnostics.law_holds, ..sliding };
    let (parameters, counted_losses) = parameters(e, chosen, omega);
    let diagnostics = Diagnostics { counted_losses, ..diagnostics };
    let stop = stop_of(e, chosen, &fit, sliding.detected);
    let mut models = candidates(comparison, |f| rms(e, f), |f| values(e, f, omega));
    // With an unconstrained negative loss the amplitude may diverge over a long record: such a model is useless.
    models.retain(|candidate| candidate.rms.is_finite());
    let mut answer = Answer {
        model: chosen.model,
        preferred_model: preferred.model,
        parameters,
        comparison: models,
        sliding,
        correlations: correlations(e, chosen),
        unbounded_errors: unbounded_errors(e, chosen, omega),
        segment: segment_of(e, stop.as_ref()),
        loss: loss_points(e, &law, omega),
        envelope,
        free_law: free_law(e, chosen),
        backbone: backbone(e, chosen, &law, omega),
        stop,
        second_mode: None,
        sensor_curve: None,
        diagnostics,
        warnings: Vec::new(),
        signal_unit: e.record.unit().to_owned(),
        fit,
    };
    answer.warnings = super::warnings::warnings(e, &answer);
    Ok(answer)
}

/// Root mean square of the residuals of a model, signal unit.
fn rms(e: &Evidence, fit: &ModelFit) -> f64 {
    match &e.fit.problem {
        Problem::Waveform(_) => (fit.bounded.rss / e.fit.comparison.noise.observations).sqrt(),
        Problem::Envelope(problem) => problem.unweighted_rms(&fit.bounded.parameters),
    }
}

/// Slot and name of each parameter of a fit.
fn named(comparison: &ModelComparison) -> Vec<(usize, Parameter)> {
    let terms = comparison.terms().map(|term| (slot(term), Parameter::Loss(term)));
    std::iter::once((A0, Parameter::InitialAmplitude)).chain(terms).collect()
}

fn values(e: &Evidence, fit: &ModelFit, omega: f64) -> Values {
    let displacement = displacement_of(e.record, omega).0;
    let value = |(slot, parameter)| {
        let factor = if parameter == Parameter::FRICTION_DISPLACEMENT { displacement } else { 1.0 };
        (parameter, factor * fit.bounded.parameters[slot])
    };
    named(&e.fit.comparison).into_iter().map(value).collect()
}

fn unbounded_errors(e: &Evidence, chosen: &ModelFit, omega: f64) -> Vec<(Parameter, f64)> {
    let (fit, noise) = (&chosen.unbounded, e.fit.comparison.noise);
    let displacement = displacement_of(e.record, omega).0;
    let error = |(slot, parameter)| {
        let factor = if parameter == Parameter::FRICTION_DISPLACEMENT { displacement } else { 1.0 };
        (parameter, factor * noise.std_error(fit, slot))
    };
    named(&e.fit.comparison).into_iter().filter(|(slot, _)| fit.free.contains(slot)).map(error).collect()
}

fn correlations(e: &Evidence, chosen: &ModelFit) -> Vec<Correlation> {
    let mut named = named(&e.fit.comparison);
    if matches!(e.fit.problem, Problem::Waveform(_)) {
        named.push((OMEGA, Parameter::Frequency));
    }
    let mut list = describe::correlations(&chosen.unbounded, &named);
    let pair = [Parameter::DECAY_RATE, Parameter::FRICTION_DISPLACEMENT];
    if !list.iter().any(|c| c.parameters == pair)
        && let Some(both) = e.fit.comparison.get(LossModel::VISCOUS_SLIDING)
    {
        list.push(Correlation { parameters: pair, value: both.unbounded.correlation(DELTA, X_F) });
    }
    list
}

/// The rest after the motion, if the samples are positions and the end is not set by the user.
///
/// Below the resolution of the converter a rest may conceal decaying oscillations as well as a stop: the
/// fitted motion distinguishes them.
fn stop_of(e: &Evidence, chosen: &ModelFit, fit: &FittedMotion, slides: bool) -> Option<Stop> {
    if e.record.kind() != SignalKind::Displacement || e.options.end_s.is_some() {
        return None;
    }
    let samples = e.samples.with_rest();
    let converter_step = samples.converter_step(e.criteria.blocks.distinct_values);
    let stops_in_window = slides && fit.rest_s().is_some_and(|t| t < e.fit.end);
    let rests =
        e.measured.window.end_reason == EndReason::Rest || e.samples.rest.is_some() && stops_in_window;
    let last = e.measured.points.last()?;
    let middle = match &e.fit.problem {
        Problem::Waveform(_) => {
            let end_s = fit.rest_s().filter(|_| stops_in_window).unwrap_or(e.fit.end);
            let offset = fit.phase_at(end_s).map_or(last.offset, |knot| knot.offset);
            [offset, e.fit.comparison.noise.std_error(&chosen.bounded, OFFSET)]
        }
        Problem::Envelope(_) => middle_of(&e.measured.points, e.measured.noise_rms),
    };
    let motion = fit.continued_to(*samples.time.last()?);
    let fitted = FittedEnd { motion, slides, stops_in_window, middle };
    stop(&samples, e.measured, &fitted, converter_step, rests, &e.criteria.stop)
}

/// Number of blocks that give the centre of the oscillation at its end.
const LAST_BLOCKS: usize = 5;

/// The centre of an oscillation at its end, and its standard error, from the offsets of its last blocks. The
/// very last block is left out: its offset is in error by a part of the amplitude lost in it.
fn middle_of(points: &[Block], noise_rms: f64) -> [f64; 2] {
    let last = &points[points.len().saturating_sub(LAST_BLOCKS + 1)..(points.len() - 1).max(1)];
    let mean = last.iter().map(|b| b.offset).sum::<f64>() / last.len() as f64;
    let scatter = last.iter().map(|b| (b.offset - mean).powi(2)).sum::<f64>() / last.len() as f64;
    let of_noise = noise_rms.powi(2) * last.iter().map(|b| b.unit_variance).sum::<f64>() / last.len() as f64;
    [mean, (scatter.max(of_noise) / last.len() as f64).sqrt()]
}

/// Two times closer than this fraction of a window count as the same instant.
const SAME_INSTANT: f64 = 1e-6;

fn segment_of(e: &Evidence, stop: Option<&Stop>) -> Segment {
    let points = &e.measured.points;
    let end_reason = match e.measured.window.end_reason {
        EndReason::RecordEnd if e.samples.rest.is_some() => match stop {
            Some(_) => EndReason::Rest,
            None => EndReason::Resolution,
        },
        reason => reason,
    };
    // For time stamps with few digits, the middle of a block minus half its length equals its first sample up
    // to rounding.
    let first_s = e.samples.time[points[0].first];
    let rounded = (e.fit.origin - first_s).abs() < SAME_INSTANT * (e.fit.end - e.fit.origin);
    Segment {
        start_s: if rounded { first_s } else { e.fit.origin },
        end_s: e.fit.end.min(e.samples.time[e.samples.time.len() - 1]),
        samples: points[points.len() - 1].end - points[0].first,
        start_reason: e.measured.window.start_reason,
        end_reason,
        cycles: if !e.record.kind().oscillates() { 0.0 } else { e.cycles },
    }
}

/// Last amplitude of the law inside the segment, never below zero.
pub(crate) fn last_amplitude(e: &Evidence, law: &AmplitudeLaw) -> f64 {
    law.amplitude(e.fit.end - e.fit.origin)
}

/// First time from which sliding accounts for more than a given share of the loss until the end.
fn dominates_from(law: &AmplitudeLaw, duration: f64, share: f64) -> Option<f64> {
    let dominates = |t: f64| law.shares(law.amplitude(t))[0] > share;
    if !(law.a0 > 0.0) || !dominates(duration) {
        return None;
    }
    if dominates(0.0) {
        return Some(0.0);
    }
    // The share grows as the amplitude falls.
    Some(border(duration, 0.0, dominates).0)
}

fn diagnostics(
    e: &Evidence,
    chosen: &ModelFit,
    law: &AmplitudeLaw,
    envelope: &[EnvelopePoint],
) -> Diagnostics {
    let variance = e.fit.comparison.noise.residual_variance(&chosen.bounded);
    let residual_rms = match &e.fit.problem {
        Problem::Waveform(_) => (chosen.bounded.rss / e.fit.comparison.noise.observations).sqrt(),
        Problem::Envelope(_) => variance.sqrt(),
    };
    // If friction is large, turning points raise the scatter within a block above its noise: the excess over
    // the residuals is not noise.
    let within_blocks = e.measured.noise_rms;
    let of_all = matches!(e.fit.problem, Problem::Waveform(_)) && e.samples.filtered == Filtered::Nothing;
    let is_excess = of_all && within_blocks.powi(2) > e.criteria.answer.misfit * variance;
    let noise = if is_excess { variance.sqrt() } else { within_blocks };
    // Below its standard error an amplitude is not distinguishable from zero.
    let measured_to = e.measured.points.last().map_or(0.0, |last| last.std_error(noise));
    let last = last_amplitude(e, law).max(measured_to);
    let decay_times = if last > 0.0 { (law.initial / last).ln().max(0.0) } else { 0.0 };
    let (other_modes, distortion) = other_modes(e);
    let leaves_much = e.fit.leaves_much(&e.criteria.answer);
    let misfit = leaves_much.then(|| misfit(envelope, &e.criteria.misfit)).flatten();
    Diagnostics {
        method: e.fit.problem.method(),
        noise_rms: noise,
        residual_rms,
        noise_inflation: 1.0,
        counted_losses: None,
        residual_excess: e.fit.excess,
        excess_by_chance: e.fit.excess_by_chance(),
        residual_autocorrelation: e.fit.autocorrelation,
        law_holds: !misfit.is_some_and(|m| m.relative_rms > e.criteria.inference.no_law),
        misfit,
        signal_to_noise_db: 20.0
            * (law.initial / std::f64::consts::SQRT_2 / noise.max(f64::MIN_POSITIVE)).log10(),
        decay_times,
        falls: !(decay_times < e.criteria.answer.least_decay),
        left_out: e.fit.outliers,
        samples_at_turns: match &e.fit.problem {
            Problem::Waveform(problem) => problem.at_turns(&chosen.bounded.parameters),
            Problem::Envelope(_) => 0,
        },
        other_modes,
        distortion,
    }
}

/// Fraction of the samples in the free decay from which on the lines of all samples serve for it.
const SAME_SAMPLES: f64 = 0.95;

/// Spectral lines of the free decay that noise does not explain: those that are neither the main one nor its
/// harmonics, and the strongest harmonic.
fn other_modes(e: &Evidence) -> (Vec<OtherMode>, Option<Distortion>) {
    if !e.record.kind().oscillates() {
        return (Vec::new(), None);
    }
    let criteria = &e.criteria.answer;
    let points = &e.measured.points;
    let range = points[0].first..points[points.len() - 1].end;
    let main = e.measured.law.mean_omega / TAU;
    let whole = spectrum::between_gaps(&e.samples.time[range.clone()], main, &e.criteria.spectrum);
    let gapless = whole.len() == range.len();
    let range = range.start + whole.start..range.start + whole.end;
    let (time, signal) = (&e.samples.time[range.clone()], &e.samples.signal[range]);
    // The main line is as wide as its frequency changes from start to end.
    let mean = |part: &[Block]| part.iter().map(|b| b.omega).sum::<f64>() / part.len() as f64 / TAU;
    let quarter = points.len().div_ceil(4);
    let spread = (mean(&points[..quarter]) - mean(&points[points.len() - quarter..])).abs() / main;
    // The periodogram of all samples is used if hardly any are left out.
    let of_all = e
        .measured
        .periodogram
        .clone()
        .filter(|p| p.samples == e.samples.len() && time.len() as f64 >= SAME_SAMPLES * p.samples as f64)
        .filter(|_| gapless);
    let Some(periodogram) = of_all.or_else(|| spectrum::Periodogram::of(time, signal).map(Arc::new)) else {
        return (Vec::new(), None);
    };
    let Some(own) = spectrum::dominant_of(&periodogram, time, signal, None, &e.criteria.spectrum) else {
        return (Vec::new(), None);
    };
    let width = (criteria.line_changes * spread).max(criteria.line_width);
    let noise = NoiseFloor { rms: e.measured.noise_rms, probability: criteria.line_of_noise };
    let least = criteria.other_mode * own.amplitude;
    let others = spectrum::other_lines(&periodogram, main, width, least, noise)
        .into_iter()
        .map(|l| OtherMode { frequency_hz: l.frequency_hz, relative_amplitude: l.amplitude / own.amplitude })
        .collect();
    let distortion = spectrum::strongest_harmonic(&periodogram, main, noise, &e.criteria.spectrum)
        .map(|(order, amplitude)| Distortion { order, relative_amplitude: amplitude / own.amplitude });
    (others, distortion)
}

#[cfg(test)]
mod tests {
    use crate::motion::decay::FreeDecay;
    use crate::noise::jitter;
    use crate::ringdown::{Options, analyse};
    use crate::{Oscillator, Record};
    use std::f64::consts::TAU;

    /// Half cycles about two centres, which no block of one cycle describes to a millionth.
    #[test]
    fn turning_points_are_not_noise() {
        for noise in [1e-7, 1e-5, 2e-3] {
            let oscillator = Oscillator::kinematic(TAU * 1.2, TAU * 0.01, 0.005).expect("valid");
            let decay = FreeDecay::from_rest(&oscillator, 0.4).expect("valid");
            let at = |i: usize| decay.displacement(i as f64 / 50.0) + noise * jitter(i, 6);
            let record = Record::uniform(50.0, (0..1000).map(at).collect()).expect("valid");
            let found = analyse(&record, &Options::default()).expect("fits").diagnostics;
            assert!((0.7..1.5).contains(&(found.noise_rms / noise)), "{} for {noise}", found.noise_rms);
        }
    }
}
