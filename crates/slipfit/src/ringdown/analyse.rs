//! The analysis of a ring-down, from a record to its answer.

use super::active_part::active_part;
use super::amplitude_fit::fit_amplitudes;
use super::assemble;
use super::band::beyond_filter;
use super::baseline::{better, level_moves, without_baseline};
use super::clipping::{ClippedCrests, clipped_crests};
use super::coloured_noise::with_coloured_noise;
use super::criteria::{ActivePartCriteria, Criteria};
use super::evidence::Evidence;
use super::few_cycles::fit_few_cycles;
use super::further_laws::{try_further_laws, try_rivals_of_drag};
use super::hypotheses::{FittedDecay, by_waveform};
use super::level::Baseline;
use super::other_motion::other_motion;
use super::release::release;
use super::samples::{Filtered, Samples};
use super::sensor_nonlinearity::straightened;
use super::squared_reading::squared_reading;
use super::steady_line::without_steady_line;
use super::window::by_law::{change_of_law, end_of_lead_in};
use super::window::{EndReason, StartReason};
use super::window_fit::Problem;
use super::{Answer, Options, oscillation, recorded_amplitudes, second_mode};
use crate::answer::Warning;
use crate::error::FALLS_AS_AMPLITUDES;
use crate::model::loss::LossModel;
use crate::record::MIN_SAMPLES;
use crate::{Error, Parameter, Record, SignalKind};
use std::ops::Range;

/// Separates viscous from sliding loss in a record of a decaying oscillation.
///
/// Finds the free decay, follows amplitude and phase along it, fits the loss models
/// `dA/dt = -(a0 + a1 A + a2 A²)` (sliding, viscous, drag) and compares them. A requested model may have
/// [further terms](crate::LossTerm). If the record shows the motion itself, every sample is compared with the
/// exact motion, whose turning points obey
///
/// ```text
/// |X_n| + C = e^(-n pi delta/omega_d) (|X_0| + C),   C = x_F coth(pi delta / 2 omega_d)
/// ```
///
/// Eq. (16) of the paper (Vitorino, Vieira and Rodrigues, *Effect of sliding friction in harmonic
/// oscillators*) has its leading order `C = 4F/(pi gamma omega_0)`, which is 2 % too small at Q = 2. If
/// frequency or phase wander more than the exact motion allows, the amplitudes of short stretches are fitted
/// instead, with the phase left free.
///
/// Units: times in s; displacements, `x_F` and amplitudes in the record's unit. For a velocity or
/// acceleration record the amplitudes are those of the recorded quantity; `x_F` is the displacement if the
/// record's unit ends in `/s` or `/s^2`, otherwise `omega x_F` or `omega² x_F` in the record's unit.
///
/// Limits: one mode (others are reported, [`Options::band_hz`] isolates one); at least two cycles above the
/// noise, or, if the exact motion describes every sample (of at most 20 000), one half cycle that returns a
/// fifth of the first amplitude; drag is exact to second order in the loss per half cycle; further terms hold
/// for the cycle average, exact for Q well above one.
///
/// # Errors
/// [`Error::Parameter`] for an option out of range; [`Error::NoOscillation`], [`Error::NotARingDown`] or
/// [`Error::NoFit`] if the record allows no answer. A poor fit is not an error but an [`Answer`] with
/// warnings.
///
/// ```
/// use slipfit::{Oscillator, Parameter, Record, motion::decay::FreeDecay, ringdown};
///
/// let oscillator = Oscillator::kinematic(6.0, 0.03, 0.002)?; // rad/s, 1/s, rad
/// let decay = FreeDecay::from_rest(&oscillator, 0.5)?;
/// let time: Vec<f64> = (0..2000).map(|i| 0.02 * i as f64).collect();
/// let angle: Vec<f64> = time.iter().enumerate()
///     .map(|(i, &t)| decay.displacement(t) + 1e-3 * (7.7 * (i * i) as f64).sin())
///     .collect();
/// let record = Record::new(time, angle)?.with_unit("rad");
/// let answer = ringdown::analyse(&record, &ringdown::Options::default())?;
/// let x_f = answer.parameter(Parameter::FRICTION_DISPLACEMENT).expect("always reported");
/// assert!((x_f.value - 0.002).abs() < 1e-4);
/// assert!(answer.sliding.detected);
/// # Ok::<(), slipfit::Error>(())
/// ```
pub fn analyse(record: &Record, options: &Options) -> Result<Answer, Error> {
    analyse_with(record, options, &Criteria::default())
}

/// [`analyse`] with user-defined thresholds.
///
/// # Errors
/// As [`analyse`].
pub fn analyse_with(record: &Record, options: &Options, criteria: &Criteria) -> Result<Answer, Error> {
    options.check()?;
    let options = &limit_band(record, options)?;
    let prepared = Samples::prepare(record, options, criteria)?;
    let band_hz = options.band_hz.filter(|_| record.kind().oscillates());
    let whole = band_hz.map_or_else(|| Ok(prepared.borrowed()), |band_hz| prepared.within_band(band_hz))?;
    let mut answer = analyse_from_release(&whole, record, options, criteria).map_err(|refusal| {
        if may_be_amplitudes(record, criteria) { falls_as_amplitudes(refusal) } else { refusal }
    })?;
    if let Some(band_hz) = band_hz {
        let again = |samples: Samples| analyse_from_release(&samples, record, options, criteria).ok();
        answer = beyond_filter(&prepared.borrowed(), answer, band_hz, criteria, again);
    }
    if record.kind().oscillates()
        && let Some(other) = other_motion(&whole, &answer, &criteria.other_motion)
    {
        let (from, to) = (whole.time[other.range.start], whole.time[other.range.end - 1]);
        answer = analyse_one_motion(&whole, other.own, record, options, criteria).unwrap_or(answer);
        answer.warnings.push(Warning::OtherMotion { from_s: from, to_s: to });
    }
    answer.warnings.extend(squared_reading(&answer, record.kind(), &criteria.squared_reading));
    let used = answer.segment.start_s..=answer.segment.end_s;
    let spikes_s: Vec<f64> = whole.spikes_s.into_iter().filter(|t| used.contains(t)).collect();
    if let Some(first) = spikes_s.first() {
        answer.warnings.push(Warning::Spikes { samples: spikes_s.len(), time_s: *first });
    }
    Ok(answer)
}

/// Whether a record declared as an oscillation may in fact contain amplitudes.
fn may_be_amplitudes(record: &Record, criteria: &Criteria) -> bool {
    record.kind().oscillates() && recorded_amplitudes::may_be_amplitudes(record.signal(), &criteria.blocks)
}

/// The refusal of a record whose samples fall as amplitudes do.
fn falls_as_amplitudes(refusal: Error) -> Error {
    let reason = FALLS_AS_AMPLITUDES;
    match refusal {
        Error::NotARingDown { cycles, needed, .. } => Error::NotARingDown { cycles, needed, reason },
        Error::NoOscillation { .. } => Error::NoOscillation { reason },
        other => other,
    }
}

/// The answer for the samples of one of several motions.
fn analyse_one_motion(
    whole: &Samples,
    own: Range<usize>,
    record: &Record,
    options: &Options,
    criteria: &Criteria,
) -> Option<Answer> {
    let (begun, ended) = (own.start > 0, own.end < whole.len());
    let mut answer = analyse_from_release(&whole.part(own), record, options, criteria).ok()?;
    if begun && answer.segment.start_reason == StartReason::RecordStart {
        answer.segment.start_reason = StartReason::LeadIn;
    }
    Some(if ended { with_end_in_noise(answer) } else { answer })
}

/// [`analyse_with`] for prepared samples.
fn analyse_from_release(
    whole: &Samples,
    record: &Record,
    options: &Options,
    criteria: &Criteria,
) -> Result<Answer, Error> {
    let from_release = analyse_after_release(whole, record, options, criteria);
    from_release.map_or_else(|| analyse_with_line(whole, record, options, criteria), Ok)
}

/// The answer for the samples from the release on, if the mass is held before it and these samples can be
/// analysed.
fn analyse_after_release(
    whole: &Samples,
    record: &Record,
    options: &Options,
    criteria: &Criteria,
) -> Option<Answer> {
    if !shows_displacement(record, options) || options.start_s.is_some() {
        return None;
    }
    let released = release(&whole.signal, &criteria.held)?;
    let mut answer = analyse_with_line(&whole.part(released..whole.len()), record, options, criteria).ok()?;
    if answer.segment.start_reason == StartReason::RecordStart {
        answer.segment.start_reason = StartReason::Held;
    }
    Some(answer)
}

/// Whether the samples show the displacement itself, including its rest position.
fn shows_displacement(record: &Record, options: &Options) -> bool {
    record.kind() == SignalKind::Displacement && options.band_hz.is_none()
}

/// [`analyse_from_release`] without the search for a held mass.
fn analyse_with_line(
    whole: &Samples,
    record: &Record,
    options: &Options,
    criteria: &Criteria,
) -> Result<Answer, Error> {
    let answer = analyse_without_line(whole, record, options, criteria);
    if !shows_displacement(record, options) || options.lockin.is_some() {
        return answer;
    }
    without_steady_line(whole, answer, criteria, |rest| analyse_part(rest, record, options, criteria).ok())
}

/// The options with the band limited to half of the sampling rate: the filter works on samples at equal
/// intervals of one median step.
fn limit_band(record: &Record, options: &Options) -> Result<Options, Error> {
    let mut options = options.clone();
    let highest = 0.5 / record.clock_report().median_step_s;
    if let Some([low, high]) = options.band_hz.as_mut().filter(|_| record.kind().oscillates()) {
        if !(*low < highest) {
            let range = "frequencies below half of the sampling rate";
            return Err(Error::Parameter { name: "band_hz", value: *low, range });
        }
        *high = high.min(highest);
    }
    Ok(options)
}

/// [`analyse_with_line`] without the search for a steady line.
fn analyse_without_line(
    whole: &Samples,
    record: &Record,
    options: &Options,
    criteria: &Criteria,
) -> Result<Answer, Error> {
    let (level, answer, baseline) = with_baseline_subtracted(whole, record, options, criteria)?;
    let whole = &level;
    let cut = clipped_crests_of(whole, &answer, record, options, criteria);
    let after_clipping = cut.filter(|_| options.start_s.is_none()).and_then(|cut| {
        let options = Options { start_s: Some(cut.end_s.next_up()), ..options.clone() };
        let first = whole.time.partition_point(|t| *t <= cut.end_s);
        let rest = whole.part(first..whole.len());
        if rest.len() < MIN_SAMPLES {
            return None;
        }
        let answer = analyse_part(rest.clone(), record, &options, criteria).ok()?;
        Some((rest, answer, options))
    });
    let inside = after_clipping.is_none();
    let (whole, mut answer, options) = after_clipping.unwrap_or((whole.clone(), answer, options.clone()));
    // This comes before the search for a second mode: a strong third harmonic, which falls three times as
    // fast, looks like one.
    answer = straightened_reading(&whole, answer, record, &options, criteria);
    if answer.sensor_curve.is_none() {
        answer = refined(whole.clone(), answer, record, &options, criteria);
    }
    if let Some(baseline) = baseline {
        let first = answer.parameter(Parameter::InitialAmplitude).map_or(f64::NAN, |a| a.value);
        answer.warnings.push(Warning::Baseline { relative: baseline.range / first });
        answer.fit.baseline = Some(baseline);
    }
    if let Some(cut) = cut {
        answer.warnings.push(Warning::Clipped { samples: cut.samples, inside });
        if !inside {
            answer.segment.start_reason = StartReason::Clipped;
        }
    }
    Ok(answer)
}

/// The answer for the straightened reading if the reading of a displacement is bent, otherwise the given
/// answer.
fn straightened_reading(
    whole: &Samples,
    answer: Answer,
    record: &Record,
    options: &Options,
    criteria: &Criteria,
) -> Answer {
    if !shows_displacement(record, options) || LossModel::further_named(options.model) > 0 {
        return answer;
    }
    let fit = |rest: Samples| analyse_part(rest, record, options, criteria).ok();
    let refine = |rest: Samples, answer: Answer| refined(rest, answer, record, options, criteria);
    straightened(whole, answer, &criteria.sensor, fit, refine)
}

/// The answer for the samples, or for the samples minus a curved baseline if that is better and a bent sensor
/// curve does not explain the level.
fn with_baseline_subtracted<'a>(
    whole: &Samples<'a>,
    record: &Record,
    options: &Options,
    criteria: &Criteria,
) -> Result<(Samples<'a>, Answer, Option<Baseline>), Error> {
    let answer = analyse_part(whole.clone(), record, options, criteria);
    // The samples of a long record are never fitted one by one.
    let long = whole.len() > criteria.waveform.most_samples;
    let doubtful = match &answer {
        Ok(answer) => {
            let by_amplitudes = answer.diagnostics.method != "waveform";
            by_amplitudes && (!long || level_moves(answer, &criteria.baseline))
        }
        Err(refusal) => may_be_too_short(refusal),
    };
    let of_samples = record.kind().oscillates() && options.band_hz.is_none() && options.lockin.is_none();
    let level =
        if doubtful && of_samples { without_baseline(whole, answer.as_ref().ok(), criteria) } else { None };
    let bends = |answer: &Answer| {
        straightened_reading(whole, answer.clone(), record, options, criteria).sensor_curve.is_some()
    };
    if let Some((level, baseline)) = level
        && let Ok(found) = analyse_part(level.clone(), record, options, criteria)
        && better(&found, answer.as_ref().ok(), &baseline, &criteria.baseline)
        && !answer.as_ref().is_ok_and(bends)
    {
        return Ok((level, found, Some(baseline)));
    }
    Ok((whole.clone(), answer?, None))
}

/// The answer with a second mode removed, with noise near the frequency of the motion included, and with
/// further loss laws tried.
fn refined(
    whole: Samples,
    answer: Answer,
    record: &Record,
    options: &Options,
    criteria: &Criteria,
) -> Answer {
    let by_model = |options: &Options, rest: Samples| analyse_samples(rest, record, options, criteria).ok();
    let as_asked = |rest: Samples| by_model(options, rest);
    // The laws compared in every analysis show whether there is a second mode; with further laws each fit
    // takes much longer.
    let further = LossModel::further_named(options.model) > 0;
    let compared = Options { model: None, ..options.clone() };
    let refit = |rest: Samples| by_model(if further { &compared } else { options }, rest);
    let in_the_end: Option<&dyn Fn(_) -> _> = if further { Some(&as_asked) } else { None };
    let two_modes = second_mode::without_second_mode(&whole, &answer, criteria, refit, in_the_end);
    let mut answer = two_modes.unwrap_or_else(|| {
        let refit = |noisier: Samples| analyse_part(noisier, record, options, criteria).ok();
        with_coloured_noise(whole.clone(), answer, &criteria.coloured_noise, refit)
    });
    // With a low-pass the fits take a hundred times as long.
    let affordable = options.lockin.is_none() && whole.len() <= criteria.misfit.further_law_samples;
    if options.model.is_none() && affordable && answer.second_mode.is_none() {
        let samples = Samples { noise_inflation: answer.diagnostics.noise_inflation, ..whole };
        // From the amplitudes alone: a hundred times as fast as fitting every sample, and sufficient to
        // distinguish the laws.
        let mut by_amplitudes = criteria.clone();
        by_amplitudes.waveform.most_samples = 0;
        by_amplitudes.few_cycles.most_samples = 0;
        let start_s = Some(answer.segment.start_s);
        let with_terms = |model| {
            let asked = Options { model: Some(model), law: None, start_s, ..options.clone() };
            analyse_part(samples.clone(), record, &asked, &by_amplitudes).ok()
        };
        try_further_laws(&mut answer, &criteria.misfit, with_terms);
        try_rivals_of_drag(&mut answer, criteria.report.rival_bic, with_terms);
    }
    answer
}

/// Clipped crests of a displacement, unless clipping was already detected without a fit.
fn clipped_crests_of(
    whole: &Samples,
    answer: &Answer,
    record: &Record,
    options: &Options,
    criteria: &Criteria,
) -> Option<ClippedCrests> {
    let warned = answer.warnings.iter().any(|w| matches!(w, Warning::Clipped { .. }));
    if warned || !shows_displacement(record, options) {
        None
    } else {
        clipped_crests(whole, answer, &criteria.clipping)
    }
}

/// The analysis of the active part of the samples, or of all of them.
fn analyse_part(
    whole: Samples,
    record: &Record,
    options: &Options,
    criteria: &Criteria,
) -> Result<Answer, Error> {
    let part =
        record.kind().oscillates().then(|| active_part(&whole.signal, &criteria.active_part)).flatten();
    let Some(range) = part else { return analyse_samples(whole, record, options, criteria) };
    let cut = range.end < whole.len();
    match analyse_samples(whole.part(range), record, options, criteria) {
        Ok(answer) if cut && continues_above_noise(&answer, &criteria.active_part) => {
            let of_all = analyse_samples(whole, record, options, criteria).ok();
            let longer = of_all.filter(|a| a.segment.end_s > answer.segment.end_s);
            Ok(longer.unwrap_or_else(|| with_end_in_noise(answer)))
        }
        Ok(answer) => Ok(if cut { with_end_in_noise(answer) } else { answer }),
        Err(_) => analyse_samples(whole, record, options, criteria),
    }
}

/// Marks an answer for the active part of a record. What follows the part is noise, so a motion that lasts to
/// its end has reached the noise.
fn with_end_in_noise(mut answer: Answer) -> Answer {
    if answer.segment.end_reason == EndReason::RecordEnd {
        answer.segment.end_reason = EndReason::Noise;
    }
    answer
}

/// Whether the motion is still above the noise at the end of the samples.
fn continues_above_noise(answer: &Answer, criteria: &ActivePartCriteria) -> bool {
    let diagnostics = &answer.diagnostics;
    let first = answer.parameter(Parameter::InitialAmplitude).map_or(0.0, |a| a.value);
    answer.segment.end_reason == EndReason::RecordEnd
        && first * (-diagnostics.decay_times).exp() > criteria.goes_on * diagnostics.noise_rms
}

/// The analysis of the given samples of a record.
fn analyse_samples(
    mut samples: Samples,
    record: &Record,
    options: &Options,
    criteria: &Criteria,
) -> Result<Answer, Error> {
    let by_amplitudes = amplitudes(&mut samples, record.kind(), options, criteria);
    let waveform = record.kind().oscillates();
    // Further laws hold for the cycle average, and fitting several of them to every sample takes seconds.
    let affordable = match LossModel::further_named(options.model) {
        0 => true,
        1 => samples.len() <= criteria.waveform.most_samples_further,
        _ => false,
    };
    let by_samples =
        waveform && samples.filtered != Filtered::Motion && options.lockin.is_none() && affordable;
    let decay = match by_amplitudes {
        Ok(decay) if by_samples => {
            let described = by_waveform(&samples, decay, options, criteria);
            let short = samples.filtered == Filtered::Nothing
                && described.measured.cycles() < criteria.few_cycles.most_cycles;
            match described.fit.problem {
                // Blocks of whole cycles carry little information about so short a motion.
                Problem::Envelope(_) if short => {
                    fit_few_cycles(&samples, options.model, criteria).unwrap_or(described)
                }
                _ => described,
            }
        }
        Ok(decay) => decay,
        Err(refusal) if waveform && may_be_too_short(&refusal) => {
            fit_few_cycles(&samples, options.model, criteria).ok_or(refusal)?
        }
        Err(refusal) => return Err(refusal),
    };
    let FittedDecay { measured, fit } = &decay;
    let cycles = measured.cycles();
    let samples = &samples;
    assemble::answer(&Evidence { record, options, criteria, samples, measured, fit, cycles })
}

/// The free decay with its amplitudes, and every loss model fitted to them.
fn amplitudes<'a>(
    samples: &mut Samples,
    kind: SignalKind,
    options: &Options,
    criteria: &Criteria,
) -> Result<FittedDecay<'a>, Error> {
    if !kind.oscillates() {
        let mut measured = recorded_amplitudes::measure(samples, kind, options, criteria)?;
        let fit = fit_amplitudes(&mut measured, options, criteria)?;
        return Ok(FittedDecay { measured, fit });
    }
    let mut measured = oscillation::measure(samples, options, criteria)?;
    let mut fit = fit_amplitudes(&mut measured, options, criteria)?;
    if options.start_s.is_none()
        && let Some(time_s) = end_of_lead_in(&fit, &measured, options, &criteria.lead_in)
    {
        measured.begin_at(time_s);
        fit = fit_amplitudes(&mut measured, options, criteria)?;
    }
    if options.end_s.is_none()
        && let Some(time_s) = change_of_law(&fit, &measured, options, &criteria.window)
    {
        measured.end_before(time_s, EndReason::LawChange);
        fit = fit_amplitudes(&mut measured, options, criteria)?;
    }
    let (cycles, needed) = (measured.cycles(), criteria.blocks.least_cycles);
    if cycles < needed {
        let reason = "the motion is too strongly damped, or the record too short";
        return Err(Error::NotARingDown { cycles, needed, reason });
    }
    if samples.filtered == Filtered::Motion {
        // A band-pass leaves no noise inside a block to be measured: the residuals of the law are the noise.
        measured.noise_rms *= fit.excess.sqrt();
        fit.excess = 1.0;
    }
    Ok(FittedDecay { measured, fit })
}

/// Whether a record was refused possibly because it has too few cycles.
fn may_be_too_short(refusal: &Error) -> bool {
    matches!(refusal, Error::NotARingDown { .. } | Error::NoFit { .. } | Error::NoOscillation { .. })
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::Oscillator;
    use crate::motion::decay::FreeDecay;
    use crate::ringdown::direct::tests::noise;
    use std::f64::consts::TAU;

    /// At 30 samples per second there is nothing above 15 Hz, whether the time stamps are even or written
    /// with four digits.
    #[test]
    fn a_band_ends_at_half_of_the_sampling_rate() {
        let swing = |t: f64| (-0.1 * t).exp() * (TAU * 11.0 * t).cos();
        let signal: Vec<f64> = (0..900).map(|i| swing(f64::from(i) / 30.0)).collect();
        let even = Record::uniform(30.0, signal.clone()).unwrap();
        let stamps = (0..900).map(|i| (f64::from(i) / 30.0 * 1e4).round() / 1e4).collect();
        let written = Record::new(stamps, signal).unwrap();
        let within = |record: &Record, band_hz| {
            analyse(record, &Options { band_hz: Some(band_hz), ..Options::default() })
        };
        for record in [&even, &written] {
            for band_hz in [[20.0, 30.0], [40.0, 60.0]] {
                let refused = within(record, band_hz);
                let named = matches!(&refused, Err(Error::Parameter { name: "band_hz", .. }));
                assert!(named, "{band_hz:?}: {refused:?}");
            }
            let highest = 0.5 / record.clock_report().median_step_s;
            let (wide, narrow) = (within(record, [9.0, 60.0]), within(record, [9.0, highest]));
            assert_eq!(wide.unwrap().parameters, narrow.unwrap().parameters);
        }
    }

    /// The sums of squares of exact samples are rounding errors of either sign if the rest has its own level.
    #[test]
    fn exact_samples_to_the_stop_and_beyond_are_answered() {
        let built =
            Oscillator::builder().frequency_hz(1.2).q_factor(80.0).friction_displacement(0.002).build();
        let decay = FreeDecay::from_rest(&built.unwrap(), 0.4).unwrap();
        for seed in 0..12 {
            let time_s: Vec<f64> = (0..2001).map(|i| f64::from(i) / 50.0).collect();
            let last_digit = |i: usize| 1.0 + 4e-16 * (3.0 * noise(i + 2001 * seed)).round();
            let sample = |(i, &t): (usize, &f64)| decay.displacement(t) * last_digit(i);
            let angle: Vec<f64> = time_s.iter().enumerate().map(sample).collect();
            let record = Record::new(time_s, angle).unwrap().with_unit("rad");
            let answer = analyse(&record, &Options::default()).unwrap();
            let x_f = answer.parameter(Parameter::FRICTION_DISPLACEMENT).unwrap();
            assert!((x_f.value - 0.002).abs() < 1e-9, "{seed}: {x_f:?}");
        }
    }
}
