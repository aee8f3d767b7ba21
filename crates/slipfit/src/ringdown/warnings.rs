//! The warnings attached to the answer to a ring-down.

use super::Answer;
use super::envelope::law_of;
use super::evidence::Evidence;
use super::window::EndReason;
use super::window_fit::Problem;
use crate::SignalKind;
use crate::answer::describe::model_choice;
use crate::answer::{Parameter, Warning};
use crate::signal::phase_step::phase_step;

/// Whether the record is too short to separate viscous from sliding loss. Not if both are determined, nor if
/// sliding friction is certain, stops the motion and is itself determined: no record of that motion would be
/// longer.
fn too_short(e: &Evidence, answer: &Answer) -> bool {
    let criteria = &e.criteria.answer;
    let determined = |parameter| {
        let q = answer.parameter(parameter);
        q.is_some_and(|q| q.std_error < criteria.determined * q.value)
    };
    let stops =
        e.measured.window.end_reason == EndReason::Rest && answer.sliding.p_value < criteria.certain_sliding;
    let is_determined =
        determined(Parameter::FRICTION_DISPLACEMENT) && (determined(Parameter::DECAY_RATE) || stops);
    e.record.kind().oscillates() && e.cycles < criteria.few_cycles && !is_determined
}

/// Whether the two losses cannot be separated, judged by their correlation; not if sliding is certain.
fn inseparable(e: &Evidence, correlation: f64, sliding_p_value: f64) -> bool {
    let criteria = &e.criteria.answer;
    correlation.abs() > criteria.inseparable && sliding_p_value >= criteria.certain_sliding
}

/// A clock of bursts, or one with stamps so coarse that its rate error dominates the uncertainty of the
/// frequency.
fn rebuilt_clock(e: &Evidence, answer: &Answer) -> Option<Warning> {
    let report = e.record.clock_report();
    let (rate_error, quantum_s) = (report.rebuilt_rate_error, report.rebuilt_quantum_s);
    let of_frequency = |q: &crate::Quantity| 2.0 * rate_error * q.value / 3.0_f64.sqrt() > q.std_error;
    let coarse = quantum_s.is_some() && answer.parameter(Parameter::Frequency).is_some_and(of_frequency);
    let burst_samples = report.burst_samples;
    (coarse || burst_samples.is_some()).then_some(Warning::ClockRebuilt {
        burst_samples,
        quantum_s,
        rate_error,
    })
}

/// `omega A / (2 dA/dt)` from the best law at the first amplitude.
fn quality_factor_at_first(e: &Evidence) -> Option<f64> {
    let omega = e.measured.law.omega;
    let law = law_of(&e.fit.comparison.preferred()?.bounded.parameters, omega);
    let loss = law.rate(law.initial);
    (loss > 0.0).then(|| omega * law.initial / (2.0 * loss))
}

/// Whether the residuals of the blocks exceed their noise by the number of standard errors that causes a
/// warning.
fn shows_misfit(e: &Evidence, excess: f64) -> bool {
    let dof = (e.measured.points.len() as f64 - 3.0).max(1.0);
    let limit = 1.0 + e.criteria.answer.misfit_errors * (2.0 / dof).sqrt();
    matches!(e.fit.problem, Problem::Waveform(_)) && excess > limit
}

/// Warning of a frequency that changes with time by more than with the amplitude.
fn frequency_drift(e: &Evidence, answer: &Answer) -> Option<Warning> {
    let backbone = answer.backbone.as_ref().filter(|_| matches!(e.fit.problem, Problem::Waveform(_)))?;
    let relative = backbone.drift_per_s * (answer.segment.end_s - answer.segment.start_s);
    let with_amplitude = backbone.frequency_at_start_hz / backbone.frequency_at_zero_hz - 1.0;
    (relative.abs() > with_amplitude.abs()).then_some(Warning::FrequencyDrift { relative })
}

/// Warning of a third harmonic in quadrature that stays constant while the amplitude falls.
fn play(e: &Evidence, answer: &Answer) -> Option<Warning> {
    let found = e.fit.harmonics.filter(|h| h.steady > e.criteria.answer.play_errors)?;
    let first = answer.parameter(Parameter::InitialAmplitude)?.value;
    Some(Warning::Play { relative_amplitude: found.steady_amplitude / first })
}

pub(crate) fn warnings(e: &Evidence, answer: &Answer) -> Vec<Warning> {
    let criteria = &e.criteria.answer;
    let mut list = Vec::new();
    let bare = !e.record.kind().oscillates();
    if too_short(e, answer) {
        list.push(Warning::TooFewCycles { cycles: e.cycles });
    }
    let correlation =
        answer.correlation(Parameter::DECAY_RATE, Parameter::FRICTION_DISPLACEMENT).unwrap_or(0.0);
    if inseparable(e, correlation, answer.sliding.p_value) {
        list.push(Warning::NotSeparable { correlation, decay_times: Some(answer.diagnostics.decay_times) });
    }
    if let Some(other) =
        answer.diagnostics.other_modes.iter().find(|m| m.relative_amplitude > criteria.strong_mode)
    {
        list.push(Warning::SeveralModes {
            main_hz: answer.parameter(Parameter::Frequency).map_or(f64::NAN, |q| q.value),
            other_hz: other.frequency_hz,
            relative_amplitude: other.relative_amplitude,
        });
    }
    let excess = answer.diagnostics.residual_excess;
    if e.fit.leaves_much(criteria) || shows_misfit(e, excess) {
        list.push(Warning::ModelMisfit { ratio: excess.sqrt(), misfit: answer.diagnostics.misfit });
    }
    if e.options.law.is_some() && answer.free_law.is_none() {
        let (amplitudes, needed) = (e.measured.points.len(), e.criteria.free_law.least_points);
        list.push(Warning::NoFreeLaw { amplitudes, needed });
    }
    if e.measured.window.end_reason == EndReason::SlowTail {
        let end = answer.segment.end_s;
        list.push(Warning::SlowTail {
            amplitude: answer.fit.amplitude_at(end),
            time_s: end,
            unit: answer.signal_unit.clone(),
        });
    } else if e.measured.window.end_reason == EndReason::LawChange {
        list.push(Warning::LawChanges { time_s: answer.segment.end_s });
    }
    if e.measured.window.disturbed {
        list.push(Warning::Disturbance { time_s: answer.segment.end_s });
    }
    let window = e.measured.points[0].first..e.measured.points[e.measured.points.len() - 1].end;
    let (samples, inside) = super::clipping::clipped_samples(&e.samples.signal, window, &e.criteria.clipping);
    if !bare && samples > 0 {
        list.push(Warning::Clipped { samples, inside });
    }
    if let Some(found) =
        answer.diagnostics.distortion.filter(|d| d.relative_amplitude > criteria.strong_harmonic)
    {
        let super::Distortion { order, relative_amplitude } = found;
        list.push(Warning::Harmonics { order, relative_amplitude });
    }
    if !bare {
        let decay = &e.measured.all[e.measured.window.first..e.measured.window.end];
        let step = phase_step(decay, e.measured.noise_rms, &e.criteria.phase);
        list.extend(step.map(|s| Warning::PhaseStep { time_s: s.time_s, radians: s.radians }));
    }
    list.extend(frequency_drift(e, answer));
    list.extend(play(e, answer));
    list.extend(rebuilt_clock(e, answer));
    if e.record.has_turning_gravity() {
        list.push(Warning::TurningGravity);
    }
    if e.record.is_lossily_compressed() && answer.sliding.detected {
        list.push(Warning::LossyCompression { share: answer.sliding.share_at_highest });
    }
    let comparison = &e.fit.comparison;
    list.extend(model_choice(comparison, e.options.model, e.criteria.report.rival_bic));
    let derivative = matches!(e.record.kind(), SignalKind::Velocity | SignalKind::Acceleration)
        && matches!(e.fit.problem, Problem::Envelope(_));
    if let Some(quality_factor) = quality_factor_at_first(e)
        .filter(|quality_factor| derivative && *quality_factor < criteria.derivative_quality_factor)
    {
        list.push(Warning::LowQDerivative { quality_factor });
    }
    if !bare {
        let points = &e.measured.points;
        // Half cycles with few samples form no blocks, but their samples lie between the blocks.
        let samples = points[points.len() - 1].end - points[0].first;
        let per_cycle = samples as f64 / e.cycles;
        if per_cycle < criteria.samples_per_cycle {
            list.push(Warning::CoarseSampling { samples_per_cycle: per_cycle });
        }
    } else if e.options.frequency_hz.is_none() {
        list.push(Warning::FrequencyUnknown);
    }
    list
}

#[cfg(test)]
mod tests {
    use crate::noise::jitter;
    use crate::ringdown::{Options, analyse};
    use crate::{Oscillator, Record, motion::decay::FreeDecay};

    const DELTA: f64 = 0.06;
    const OMEGA: f64 = 7.0;

    /// Number of records out of six, each of 40 s at 40 samples per second and 44 dB, in which a warning is
    /// given.
    fn count_warned(code: &str, motion: impl Fn(f64) -> f64) -> usize {
        let exact: Vec<f64> = (0..1600).map(|i| motion(i as f64 / 40.0)).collect();
        let warns = |repeat: &usize| {
            let noisy = exact.iter().enumerate().map(|(i, x)| x + 0.006 * jitter(i + 1600 * repeat, 7));
            let record = Record::uniform(40.0, noisy.collect()).expect("valid");
            let answer = analyse(&record, &Options::default()).expect("a ring-down");
            answer.warnings.iter().any(|w| w.code() == code)
        };
        (0..6).filter(warns).count()
    }

    #[test]
    fn a_gap_is_no_mode() {
        let warned = |repeat: usize| {
            let time: Vec<f64> =
                (0..1600).map(|i| i as f64 / 40.0).filter(|t| !(9.0..12.0).contains(t)).collect();
            let noisy = |(i, t): (usize, &f64)| {
                amplitude(*t) * (OMEGA * t).cos() + 0.006 * jitter(i + 1600 * repeat, 7)
            };
            let signal = time.iter().enumerate().map(noisy).collect();
            let answer = analyse(&Record::new(time, signal).expect("valid"), &Options::default());
            answer.expect("a ring-down").warnings.iter().any(|w| w.code() == "several_modes")
        };
        assert!(!(0..6).any(warned));
    }

    fn amplitude(t: f64) -> f64 {
        (-DELTA * t).exp()
    }

    #[test]
    fn a_frequency_that_drifts_is_told_and_one_that_depends_on_the_amplitude_is_not() {
        let drifting = |t: f64| amplitude(t) * (OMEGA * t * (1.0 + 0.005 * t / 80.0)).cos();
        assert_eq!(count_warned("frequency_drift", drifting), 6);
        // Phase lag for the frequency omega (1 - 0.02 A²).
        let lag = |t: f64| 0.01 * OMEGA / DELTA * (1.0 - amplitude(t).powi(2));
        assert_eq!(count_warned("frequency_drift", |t| amplitude(t) * (OMEGA * t - lag(t)).cos()), 0);
    }

    #[test]
    fn a_knock_that_shifts_the_phase_gives_a_warning() {
        let knocked = |kick: f64| {
            move |t: f64| {
                let since = (t - 11.3).max(0.0);
                amplitude(t) * (OMEGA * t).cos() + kick * amplitude(since) * (OMEGA * since).sin()
            }
        };
        assert_eq!(count_warned("phase_step", knocked(0.06)), 6);
        assert_eq!(count_warned("phase_step", knocked(0.0)), 0);
    }

    #[test]
    fn an_amplitude_off_the_law_by_six_errors_is_a_misfit_below_twice_the_noise() {
        let wobbling =
            |part: f64| move |t: f64| amplitude(t) * (1.0 + part * (0.9 * t).cos()) * (OMEGA * t).cos();
        assert!(count_warned("model_misfit", wobbling(0.007)) >= 4);
        assert_eq!(count_warned("model_misfit", wobbling(0.0)), 0);
    }

    #[test]
    fn play_is_told_and_friction_is_not() {
        let motion = |x_f: f64| {
            let oscillator = Oscillator::kinematic(OMEGA, DELTA, x_f).expect("valid");
            FreeDecay::from_rest(&oscillator, 1.0).expect("valid")
        };
        let (free, sliding) = (motion(0.0), motion(0.008));
        let mut reading = 1.0;
        let with_play: Vec<f64> = (0..1600)
            .map(|i| {
                let x = free.displacement(i as f64 / 40.0);
                reading = f64::clamp(reading, x - 0.01, x + 0.01);
                reading
            })
            .collect();
        assert_eq!(count_warned("play", |t| with_play[(40.0 * t).round() as usize]), 6);
        assert_eq!(count_warned("play", |t| sliding.displacement(t)), 0);
    }
}
