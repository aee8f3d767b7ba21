//! Detection and subtraction of a second mode, if two modes describe a record and one does not.

use super::criteria::{Criteria, TwoModesCriteria};
use super::sampled_signal::SampledSignal;
use super::samples::Samples;
use super::two_modes::{MainMode, OneMode, ViscousMode, mode_in_residuals, weaker_of_two};
use super::window_fit::WAVEFORM;
use super::{Answer, EndReason, Mode, StartReason};
use crate::answer::Warning;
use crate::numeric::roots::border;
use crate::{Parameter, Quantity};
use std::f64::consts::{E, TAU};
use std::ops::Range;

/// Rounds of fitting the second mode to the residuals of the motion, and the motion to the samples without
/// it.
const ROUNDS: usize = 2;

/// The answer for the stronger of two modes, obtained by `refit` of the samples minus the weaker one. `None`
/// if one mode is sufficient or if a second one explains too little of its residuals.
///
/// Beats resemble friction: the amplitude falls to zero in finite time. Two viscous modes are therefore
/// compared with every law of one amplitude whose residuals exceed the noise. The stronger mode then keeps
/// its own law, friction included; with `in_the_end`, further laws than those of `refit` are used for the
/// final answer.
pub(crate) fn without_second_mode<'a>(
    samples: &Samples<'a>,
    answer: &Answer,
    criteria: &Criteria,
    refit: impl Fn(Samples<'a>) -> Option<Answer>,
    in_the_end: Option<&dyn Fn(Samples<'a>) -> Option<Answer>>,
) -> Option<Answer> {
    let c = &criteria.two_modes;
    if answer.fit.knots.is_empty() {
        return None;
    }
    let decay = window(samples, answer);
    // Each maximum of a beat resembles the start of a decay.
    let largest = answer.envelope.iter().max_by(|a, b| a.amplitude.total_cmp(&b.amplitude))?;
    let is_first_block = answer.envelope.first() == Some(largest);
    let first = if is_first_block { 0 } else { samples.time.partition_point(|t| *t < largest.time_s) };
    let longer_s = |answer: &Answer| c.longer_window * length_s(answer);
    let starts_late = |answer: &Answer| {
        first < decay.start && samples.time[samples.len() - 1] - samples.time[first] > longer_s(answer)
    };
    let left = &answer.diagnostics;
    let by_chance = left.excess_by_chance > criteria.answer.misfit_by_chance;
    let leaves_much = left.residual_excess > c.least_excess && !by_chance;
    if !leaves_much && !starts_late(answer) {
        return None;
    }
    let main = main_mode(answer)?;
    let left_by_one = residuals(samples, decay.clone(), answer);
    let (time_s, remaining) = finite_only(&samples.time[decay.clone()], &left_by_one);
    if remaining.is_empty() {
        return None;
    }
    let mean_square = remaining.iter().map(|x| x * x).sum::<f64>() / remaining.len() as f64;
    let noise = answer.diagnostics.noise_rms.powi(2);
    let one_mode = OneMode { window_s: answer.fit.range_s(), mean_square, noise };
    let described = |part: Samples<'a>, second: ViscousMode| {
        let found = refine(&part, second, criteria, &refit)?;
        let left_by_both = residuals(samples, decay.clone(), &found);
        if !explains(&left_by_one, &left_by_both, [answer, &found], c) {
            return None;
        }
        let by_further_laws = in_the_end.zip(found.fit.second_mode);
        by_further_laws.map_or(Some(found), |(refit, second)| {
            Some(with_modes(refit(without_mode(&part, second))?, second))
        })
    };
    let pair = |range: Range<usize>| {
        let part = samples.part(range.clone());
        let second =
            weaker_of_two(&part.time, &part.signal, [main.omega, main.decay_rate], &one_mode, criteria)?;
        let found = described(part, second)?;
        Some(with_reasons_of_record(found, answer, &range, &decay, samples.len()))
    };
    let in_residuals = || {
        let second = mode_in_residuals(&time_s, &remaining, &main, None, criteria)?;
        let found = described(samples.part(decay.clone()), second)?;
        Some(with_reasons_of_record(found, answer, &decay, &decay, samples.len()))
    };
    let found = if leaves_much {
        let in_window = || if decay.end < samples.len() { pair(decay.clone()) } else { None };
        pair(decay.start..samples.len()).or_else(in_window).or_else(in_residuals)
    } else {
        None
    };
    let so_far = found.as_ref().unwrap_or(answer);
    let earlier = starts_late(so_far).then(|| pair(first..samples.len())).flatten();
    earlier.filter(|a| length_s(a) > longer_s(so_far)).or(found)
}

/// Replaces the start and end reasons of an answer for a `part` of the samples by those of the record.
fn with_reasons_of_record(
    mut found: Answer,
    one_mode: &Answer,
    part: &Range<usize>,
    decay: &Range<usize>,
    samples: usize,
) -> Answer {
    if found.segment.start_reason == StartReason::RecordStart && part.start > 0 {
        let same = part.start == decay.start;
        found.segment.start_reason = if same { one_mode.segment.start_reason } else { StartReason::LeadIn };
    }
    if found.segment.end_reason == EndReason::RecordEnd && part.end < samples {
        found.segment.end_reason = one_mode.segment.end_reason;
    }
    found
}

/// Alternates between fitting the motion with the second mode subtracted and fitting that mode to the
/// residuals.
pub(crate) fn refine<'a>(
    part: &Samples<'a>,
    mut second: ViscousMode,
    criteria: &Criteria,
    refit: impl Fn(Samples<'a>) -> Option<Answer>,
) -> Option<Answer> {
    let without = |second: ViscousMode| refit(without_mode(part, second));
    let mut answer = without(second)?;
    // Phases fitted block by block contain part of the second mode, which is then missing in the residuals.
    let rounds = if answer.diagnostics.method == WAVEFORM { ROUNDS } else { 0 };
    for _ in 0..rounds {
        let (time_s, remaining) = remaining(part, &answer);
        let Some(closer) =
            mode_in_residuals(&time_s, &remaining, &main_mode(&answer)?, Some(second), criteria)
        else {
            break;
        };
        let Some(found) = without(closer) else { break };
        (second, answer) = (closer, found);
    }
    Some(with_modes(answer, second))
}

/// The samples minus a mode.
fn without_mode<'a>(part: &Samples<'a>, mode: ViscousMode) -> Samples<'a> {
    let mut rest = Samples { rest: part.rest_alone(), ..part.clone() };
    let without = rest.time.iter().zip(rest.signal.iter()).map(|(&t, x)| x - mode.at(t));
    rest.signal = SampledSignal::new(without.collect::<Vec<f64>>());
    rest
}

pub(super) fn main_mode(answer: &Answer) -> Option<MainMode> {
    let [start_s, end_s] = answer.fit.range_s();
    let e_fold = |t: f64| answer.fit.amplitude_at(start_s + t) < answer.fit.amplitude_at(start_s) / E;
    // The average decay rate down to 1/e; at a stop the local rate diverges.
    let decay_rate = if e_fold(end_s - start_s) {
        1.0 / border(end_s - start_s, 0.0, e_fold).0
    } else {
        answer.diagnostics.decay_times / (end_s - start_s)
    };
    Some(MainMode {
        omega: TAU * answer.parameter(Parameter::Frequency)?.value,
        decay_rate,
        amplitude: answer.parameter(Parameter::InitialAmplitude)?.value,
    })
}

fn length_s(answer: &Answer) -> f64 {
    let [from_s, to_s] = answer.fit.range_s();
    to_s - from_s
}

/// The samples of the free decay.
fn window(samples: &Samples, answer: &Answer) -> Range<usize> {
    let [from_s, to_s] = answer.fit.range_s();
    samples.time.partition_point(|t| *t < from_s)..samples.time.partition_point(|t| *t <= to_s)
}

/// Residuals of the motion of an answer in its window, with their times.
fn remaining(samples: &Samples, answer: &Answer) -> (Vec<f64>, Vec<f64>) {
    let range = window(samples, answer);
    finite_only(&samples.time[range.clone()], &residuals(samples, range, answer))
}

/// Residuals of the motion of an answer for some of the samples; NaN where the motion is undefined.
fn residuals(samples: &Samples, range: Range<usize>, answer: &Answer) -> Vec<f64> {
    let pairs = samples.time[range.clone()].iter().zip(&samples.signal[range]);
    pairs.map(|(&t, x)| x - answer.fit.signal_at(t)).collect()
}

fn finite_only(time_s: &[f64], residuals: &[f64]) -> (Vec<f64>, Vec<f64>) {
    time_s.iter().zip(residuals).filter(|(_, x)| x.is_finite()).unzip()
}

/// Whether the second mode explains most of the residuals of one mode above the noise, or whether both
/// together describe a much longer decay.
fn explains(
    left_by_one: &[f64],
    left_by_two: &[f64],
    [one, two]: [&Answer; 2],
    c: &TwoModesCriteria,
) -> bool {
    let both = || left_by_one.iter().zip(left_by_two).filter(|(a, b)| a.is_finite() && b.is_finite());
    let samples = both().count() as f64;
    let (by_one, by_two) =
        both().fold((0.0, 0.0), |(a, b), (x, y)| (a + x * x / samples, b + y * y / samples));
    let noise = one.diagnostics.noise_rms.powi(2).min(by_two);
    let longer = length_s(two) > c.longer_window * length_s(one)
        && two.diagnostics.residual_excess <= one.diagnostics.residual_excess;
    samples > c.common_part * one.segment.samples as f64
        && (longer || by_one - by_two > c.explained * (by_one - noise))
}

/// The answer with both modes reported and included in the fitted signal.
fn with_modes(mut answer: Answer, second: ViscousMode) -> Answer {
    let unit = &answer.signal_unit;
    let [omega, decay_rate, amplitude] = second.std_errors;
    let mode = Mode {
        frequency: Quantity::normal(second.omega / TAU, omega / TAU, "Hz"),
        decay_rate: Quantity::normal(second.decay_rate, decay_rate, "1/s"),
        amplitude: Quantity::normal(second.amplitude(), amplitude, unit),
    };
    let value = |parameter| answer.parameter(parameter).map_or(f64::NAN, |q| q.value);
    let warning = Warning::SecondMode {
        main_hz: value(Parameter::Frequency),
        other_hz: mode.frequency.value,
        relative_amplitude: mode.amplitude.value / value(Parameter::InitialAmplitude),
    };
    answer.warnings.insert(0, warning);
    answer.second_mode = Some(mode);
    answer.fit.second_mode = Some(second);
    answer
}
