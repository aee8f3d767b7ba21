//! Fit of the exact motion to every sample of a window.

use super::cluster_jackknife::inflation_of_samples;
use super::compare::{
    LastSteps, Models, Search, WholeLoss, compare, loss_parameters, slots, with_shape_starts,
};
use super::criteria::{Criteria, WaveformCriteria};
use super::envelope::{A0, DELTA, DRAG, X_F, law_of};
use super::last_swing::{LastSwing, is_hidden};
use super::measured::MeasuredDecay;
use super::nuisance_selection::{ALWAYS, NuisanceSelection, OPTIONAL, in_order, minimum};
use super::residuals::{Residuals, harmonics};
use super::samples::{Filtered, Samples};
use super::wandering_phase::WanderingPhase;
use super::waveform::{
    BACKBONE, BackboneIntegral, CHIRP, COUNT, Guard, OFFSET, OMEGA, Observable, PHASE, RestLevel, Waveform,
    rest_position_matters,
};
use super::window_fit::{Problem, WindowFit};
use crate::inference::least_squares::Fit;
use crate::inference::noise::NoiseModel;
use crate::inference::quadratic::conditional_minimum;
use crate::model::loss::{LossModel, LossTerm};
use crate::motion::decay::parameters::shape_slot;
use crate::signal::blocks;
use std::f64::consts::PI;
use std::ops::Range;

/// Accelerations jump at each turning point, so that a sample on the wrong side of one fixes the phase at its
/// start value. Samples this close to a turning point, rad, are left out until the phase is known. The phase
/// error of blocks is smaller than that from a Q of 5 on.
const START_GUARD: f64 = 0.15;

/// Minimum decay over a window at the start of a search.
const LEAST_DECAY: f64 = 1e-3;

/// Start values from the fit of the amplitudes, for a window that begins with the first block, including the
/// disturbances shown by the phases of the blocks.
pub(crate) fn start_values(
    samples: &Samples,
    measured: &MeasuredDecay,
    by_amplitudes: &WindowFit,
) -> Option<Vec<f64>> {
    let first = measured.points.first()?;
    let best = by_amplitudes.comparison.preferred()?;
    let mut start = vec![0.0; COUNT];
    start[..PHASE].copy_from_slice(&best.bounded.parameters[..PHASE]);
    start[OMEGA] = measured.law.omega;
    start[PHASE] = blocks::wrap(first.phase - first.omega * (first.time_s - samples.time[first.first]));
    start[PHASE] -= samples.observable.phase_lead();
    start[OFFSET] = measured.points.iter().map(|b| b.offset).sum::<f64>() / measured.points.len() as f64;
    start[BACKBONE] = measured.law.quadratic * measured.law.omega;
    start[CHIRP] = measured.law.drift * measured.law.omega;
    Some(start)
}

/// Fits the loss models to be compared, given the requested one, to the samples of a window. Phase
/// disturbances in `start` remain in the model unless they prove unnecessary. `None` if the phase wanders too
/// much for the exact motion.
pub(crate) fn fit_waveform<'a>(
    samples: &'a Samples,
    measured: &MeasuredDecay,
    range: Range<usize>,
    start: Vec<f64>,
    compared: (Option<LossModel>, Models),
    criteria: &Criteria,
) -> Option<WindowFit<'a>> {
    let tells = samples.observable == Observable::Displacement
        && rest_position_matters(start[X_F], measured.noise_rms, range.len(), &criteria.waveform);
    let rest = match tells {
        _ if !samples.level_known => RestLevel::Free,
        true => RestLevel::Exact,
        false => RestLevel::Bounded,
    };
    let fit = |rest, start| fit_with_rest(samples, measured, range.clone(), start, rest, compared, criteria);
    let (found, low_frequency) = fit(rest, start)?;
    let best = &found.comparison.preferred()?.bounded.parameters;
    let stop_s = law_of(best, best[OMEGA]).stop_time_s().map(|t| found.origin + t).filter(|t| *t < found.end);
    let Some(stop_s) = stop_s.filter(|_| rest != RestLevel::Free) else { return Some(found) };
    let wanders = low_frequency >= criteria.coloured_noise.low_frequency * measured.noise_rms.powi(2)
        && !rest_position_matters(best[X_F], low_frequency.sqrt(), range.len(), &criteria.waveform);
    let variance = found.comparison.noise.residual_variance(&found.comparison.preferred()?.bounded);
    if !wanders && !rest_is_rounded(samples, stop_s, variance, criteria) {
        return Some(found);
    }
    let (free, _) = fit(RestLevel::Free, best.clone())?;
    Some(free)
}

/// Whether rounding to the steps of the converter shifts all samples at rest by a common error larger than
/// the allowed fraction of the standard error of their mean. `variance` is that of a sample, rounding
/// included.
///
/// With noise of `s` steps, the remaining rounding error of a constant is at most `exp(-2 pi² s²)/pi` steps
/// (B. Widrow and I. Kollár, *Quantization Noise*, 2008).
fn rest_is_rounded(samples: &Samples, stop_s: f64, variance: f64, criteria: &Criteria) -> bool {
    let at_rest = samples.len() - samples.time.partition_point(|t| *t < stop_s);
    let step = samples.converter_step(criteria.blocks.distinct_values);
    let noise = (variance - step * step / 12.0).max(0.0) / (step * step);
    let shared = step / PI * (-2.0 * PI * PI * noise).exp();
    step > 0.0 && shared * (at_rest as f64 / variance).sqrt() > criteria.waveform.rounding_of_rest
}

/// The samples of a window to which motions are fitted.
struct WindowSamples<'a, 'm> {
    samples: &'a Samples<'a>,
    measured: &'m MeasuredDecay,
    range: Range<usize>,
    criteria: &'m Criteria,
}

/// [`fit_waveform`] for a given treatment of the level of the rest; also returns the variance of white noise
/// with the spectral density that the residuals have at low frequencies.
fn fit_with_rest<'a>(
    samples: &'a Samples,
    measured: &MeasuredDecay,
    range: Range<usize>,
    start: Vec<f64>,
    rest: RestLevel,
    (asked, models): (Option<LossModel>, Models),
    criteria: &Criteria,
) -> Option<(WindowFit<'a>, f64)> {
    let window = WindowSamples { samples, measured, range: range.clone(), criteria };
    let (problem, NuisanceSelection { mut fit, nuisance, .. }) =
        window.select_nuisances(with_shape_starts(&start, asked), rest, asked)?;
    let (n, duration) = (range.len(), problem.duration);
    // With more samples, a fit with residuals no larger than the noise is hardly a secondary minimum.
    let few = n <= criteria.waveform.multi_start_samples;
    let side_minima = window.excess(&fit) > criteria.waveform.variance_ratio
        || few && may_stop(&fit, n, duration, &criteria.waveform);
    if side_minima && fit.parameters[DRAG] != 0.0 && !fit.free.contains(&DRAG) {
        // The drag is that of the amplitude fit; it hides where the motion would stop without it.
        let mut start = fit.parameters.clone();
        start[DRAG] = 0.0;
        fit = minimum(&problem, &start, &fit.free)?;
    }
    let (mut several_minima, mut other_minima) = (side_minima, Vec::new());
    let hidden = || is_hidden(&problem, &fit, criteria.waveform.last_swing_variances);
    if rest != RestLevel::Free && stops(&fit, duration) && (side_minima || few && hidden()) {
        let inflation = |fit: &Fit| window.residual_statistics(&problem, fit).serial_inflation;
        let last = LastSwing::search(&problem, fit, inflation, &criteria.waveform);
        fit = last.fit;
        several_minima = !last.others.is_empty();
        other_minima = last.others;
        if rest == RestLevel::Exact && several_minima {
            let (start, rest) = (fit.parameters, RestLevel::Bounded);
            return fit_with_rest(samples, measured, range, start, rest, (asked, models), criteria);
        }
    }
    let mut noise = NoiseModel::white(problem.counted());
    let whole = whole_loss(&fit, duration);
    let last = problem.gathered.is_some().then(|| [problem.accurate(), problem.exact()]);
    let last = last.as_ref().map(|[accurate, exact]| LastSteps { accurate, exact });
    let search =
        Search { asked, models, begun: Some(&fit), side_minima, last, criteria: &criteria.inference };
    let comparison = compare(&problem, &fit.parameters, &nuisance, noise, whole, search);
    let best = &comparison.preferred()?.bounded;
    let ResidualStatistics { residuals: left, wandering, serial_inflation } =
        window.residual_statistics(&problem, best);
    let least = criteria.sensor.samples_per_cycle;
    let harmonics = harmonics(&problem, range.start, &left, best, &measured.points, least);
    noise.variance_inflation = serial_inflation;
    // If the noise near the frequency of the motion is known, the residual fundamental is compared with it.
    let known = left.in_phase.excess * left.variance / measured.noise_rms.powi(2).max(f64::MIN_POSITIVE);
    let is_known = samples.noise_inflation > 1.0 || matches!(samples.filtered, Filtered::Noise { .. });
    let excess = if is_known { known } else { left.in_phase.excess };
    // Misfit of the law shifts the cycles too, but is not noise: another law may describe it.
    if excess < criteria.answer.misfit {
        let largest = comparison.largest().map_or(best, |fit| &fit.bounded);
        let significance = criteria.inference.cluster_significance;
        let from_cycle_to_cycle = inflation_of_samples(&problem, largest, left.variance, significance);
        noise.variance_inflation = serial_inflation.max(from_cycle_to_cycle);
    }
    let fit = WindowFit {
        comparison: comparison.with_noise(noise),
        origin: problem.origin,
        end: problem.origin + duration,
        problem: Problem::Waveform(problem),
        excess,
        excess_freedom: left.in_phase.freedom,
        autocorrelation: left.in_phase.autocorrelation,
        serial_inflation,
        wandering,
        harmonics,
        several_minima,
        other_minima,
        outliers: 0,
    };
    Some((fit, left.low_frequency))
}

/// Residual statistics of a motion.
struct ResidualStatistics {
    residuals: Residuals,
    wandering: Option<WanderingPhase>,
    /// Factor by which the variance of the parameters exceeds that under white noise (variance inflation).
    serial_inflation: f64,
}

impl<'a> WindowSamples<'a, '_> {
    /// The problem of the window, and the fit of the basic losses with the nuisance parameters that the data
    /// require. `None` if the phase wanders too much for the exact motion.
    fn select_nuisances(
        &self,
        start: Vec<f64>,
        rest: RestLevel,
        asked: Option<LossModel>,
    ) -> Option<(Waveform<'a>, NuisanceSelection)> {
        let criteria = self.criteria;
        let losses = loss_parameters(asked);
        let further = LossTerm::further_of(asked).flat_map(slots);
        let basic: Vec<usize> = [A0, X_F, DELTA].into_iter().chain(further).collect();
        let (mut problem, backbone) = self.problem(&start, rest, &losses);
        let started = [BACKBONE, CHIRP].into_iter().filter(|&slot| start[slot] != 0.0);
        let nuisance: Vec<usize> = ALWAYS.into_iter().chain(started).collect();
        let fit = self.first_fit(&mut problem, start, &in_order(&basic, &nuisance))?;
        // In a record of one or two cycles an offset drift fitted by chance would cost most of the
        // information about the loss.
        let mut price = (self.range.len() as f64).ln() + criteria.inference.instrument_bic_margin;
        if matches!(self.samples.filtered, Filtered::Noise { .. }) {
            // In variances of the residuals, which lack the noise outside the band.
            price /= self.excess(&fit).clamp(f64::MIN_POSITIVE, 1.0);
        }
        let mut selection = NuisanceSelection { fit, basic, nuisance, price };
        problem.backbone.get_or_insert(backbone);
        problem = problem.gathered_about(&selection.fit.parameters);
        let unexplained = self.excess(&selection.fit) > criteria.waveform.variance_ratio;
        if unexplained && stops(&selection.fit, problem.duration) && rest == RestLevel::Exact {
            selection.fit = LastSwing::search(&problem, selection.fit, |_| 1.0, &criteria.waveform).fit;
        }
        selection.add(&problem)?;
        if self.excess(&selection.fit) > criteria.waveform.most_excess {
            // Residuals that drag explains are not caused by a wandering phase.
            let may_have_drag = asked.is_none_or(|model| model.has(LossTerm::Drag));
            if selection.basic.contains(&DRAG) || !may_have_drag {
                return None;
            }
            selection = selection.with_loss(&problem, DRAG)?;
            selection.add(&problem)?;
            if self.excess(&selection.fit) > criteria.waveform.most_excess {
                return None;
            }
        }
        // Disturbances included from the start must be required by the data too.
        for term in [CHIRP, BACKBONE] {
            selection.drop(&problem, term);
        }
        selection.prefer_backbone(&problem);
        if !selection.nuisance.contains(&BACKBONE) {
            problem.backbone = None;
        }
        if problem.gathered.is_none() {
            problem = problem.gathered_about(&selection.fit.parameters);
        }
        problem.active = in_order(&losses, &selection.nuisance);
        Some((problem, selection))
    }

    /// The least-squares problem of every sample, with all disturbances of phase and offset, and the shape of
    /// the backbone, used if the start has one.
    fn problem(&self, start: &[f64], rest: RestLevel, losses: &[usize]) -> (Waveform<'a>, BackboneIntegral) {
        let samples = self.samples;
        let origin = samples.time[self.range.start];
        let duration = samples.time[self.range.end - 1] - origin;
        let law = law_of(start, start[OMEGA]);
        let backbone = BackboneIntegral::along(|t| law.amplitude(t), duration);
        let problem = Waveform {
            time: &samples.time[self.range.clone()],
            signal: &samples.signal[self.range.clone()],
            observable: samples.observable,
            guard: None,
            origin,
            duration,
            backbone: (start[BACKBONE] != 0.0).then(|| backbone.clone()),
            rest,
            // Rounding of a phase and of quantities computed from it; rounding of time stamps far from zero
            // is already in the samples.
            rounding_rms: f64::EPSILON * (start[OMEGA] * duration + 1.0) * start[A0].abs(),
            active: [losses, &ALWAYS, &OPTIONAL].concat(),
            gathered: None,
        };
        (problem, backbone)
    }

    /// The minimum reached from a start; for accelerations without the samples next to turning points.
    fn first_fit(&self, problem: &mut Waveform, mut start: Vec<f64>, free: &[usize]) -> Option<Fit> {
        if self.samples.observable == Observable::Acceleration {
            let within = |reach, start: &[f64]| {
                let guard = Some(Guard { reach, stands_for: None });
                let guarded = Waveform { guard, ..problem.clone() };
                Some(Guard { reach, stands_for: Some((self.range.len() - guarded.at_turns(start)) as f64) })
            };
            let guarded = Waveform { guard: within(START_GUARD, &start), ..problem.clone() };
            start = minimum(&guarded, &start, free)?.parameters;
            problem.guard = within(self.criteria.waveform.turn_guard, &start);
        }
        minimum(problem, &start, free)
    }

    /// Ratio of the residual variance to the noise variance.
    fn excess(&self, fit: &Fit) -> f64 {
        fit.rss / self.range.len() as f64 / self.measured.noise_rms.powi(2)
    }

    fn residual_statistics(&self, problem: &Waveform, fit: &Fit) -> ResidualStatistics {
        let residuals = Residuals::new(problem, self.range.start, fit, &self.measured.points);
        let wandering = WanderingPhase::of(problem, fit, self.measured.noise_rms, &self.criteria.phase);
        let serial_inflation = residuals.variance_inflation_with_walk(wandering, self.criteria);
        ResidualStatistics { residuals, wandering, serial_inflation }
    }
}

/// Whether the motion stops within the window.
fn stops(fit: &Fit, duration: f64) -> bool {
    law_of(&fit.parameters, fit.parameters[OMEGA]).stop_time_s().is_some_and(|t| t < duration)
}

/// The coefficients that would account for the whole loss of a fit at its first amplitude.
fn whole_loss(fit: &Fit, duration: f64) -> WholeLoss {
    let p = &fit.parameters;
    let further = law_of(p, p[OMEGA]).further_rate(p[A0]) / p[A0];
    let decay_rate = p[DELTA] + 2.0 * p[OMEGA] * p[X_F] / (PI * p[A0]) + further;
    WholeLoss::new(decay_rate.max(LEAST_DECAY / duration), p[A0], p[OMEGA])
}

/// Whether a motion that the samples do not exclude stops within the window.
fn may_stop(fit: &Fit, samples: usize, duration: f64, criteria: &WaveformCriteria) -> bool {
    // A loss of fitted shape may leave the friction without a meaningful error.
    let is_shape = |slot: &usize| LossTerm::shaped().iter().any(|t| shape_slot(*t) == Some(*slot));
    let std_error = match fit.free.iter().any(is_shape) {
        true => 0.0,
        false => fit.unit_std(X_F) * (fit.rss / samples as f64).sqrt(),
    };
    let most = fit.parameters[X_F] + criteria.last_swing_errors * std_error;
    let stopping = conditional_minimum(fit, &[(X_F, most)]);
    stopping.is_some_and(|(_, p)| law_of(&p, p[OMEGA]).stop_time_s().is_some_and(|t| t < duration))
}

#[cfg(test)]
mod tests {
    use crate::model::loss::LossTerm;
    use crate::motion::decay::FreeDecay;
    use crate::motion::simulate::Drive;
    use crate::motion::simulate::smooth::{self, SmoothMotion};
    use crate::noise::{assert_held, jitter};
    use crate::ringdown::{Options, analyse};
    use crate::{Oscillator, Parameter, Record, SignalKind};
    use std::f64::consts::{PI, TAU};

    const UNIT: [&str; 2] = ["rad/s", "rad/s^2"];

    /// At 60 dB viscous and sliding loss alone leave residuals of several times the noise, as a wandering
    /// phase does. Drag, fitted in addition, removes them, whether or not the amplitudes show it first.
    #[test]
    fn drag_is_no_phase_that_wanders() {
        let (omega_0, total) = (TAU * 1.7, PI * 1.7 / 30.0);
        let (drag, delta, x_f) = (0.3 * total, 0.7 * total, 0.125 * PI * total / omega_0);
        let oscillator = Oscillator::kinematic(omega_0, delta, x_f).expect("valid");
        let law = smooth::drag(drag * 3.0 * PI / (4.0 * omega_0.powi(3))).expect("valid");
        let mut motion = SmoothMotion::new(&oscillator, law, Drive::none(), 0.0, 1.0, 0.0).expect("valid");
        let time: Vec<f64> = (0..717).map(|i| f64::from(i) / 51.0).collect();
        let clean: Vec<f64> = time.iter().map(|t| motion.state_at(*t).expect("solved").position).collect();
        let record = |repeat: usize| {
            let noisy = |(i, x): (usize, &f64)| x + 1e-3 * jitter(repeat * time.len() + i, 12);
            let signal = clean.iter().enumerate().map(noisy).collect();
            Record::new(time.clone(), signal).expect("valid").with_kind(SignalKind::Displacement)
        };
        for repeat in 0..24 {
            let answer = analyse(&record(repeat), &Options::default()).expect("fits");
            assert_eq!(answer.diagnostics.method, "waveform", "record {repeat}");
            assert!(answer.model.has(LossTerm::Drag), "record {repeat}");
        }
        assert_held(record, &Options::default(), Parameter::FRICTION_DISPLACEMENT, x_f);
        assert_held(record, &Options::default(), Parameter::DECAY_RATE, delta);
    }

    /// For low-Q velocities and accelerations the intervals cover the true values as for displacements.
    #[test]
    fn velocities_and_accelerations_of_low_q_hold_the_truth() {
        const REPEATS: usize = 16;
        for kind in [SignalKind::Velocity, SignalKind::Acceleration] {
            for (q, share) in [(8.0, 0.2), (8.0, 0.5), (15.0, 0.5), (30.0, 0.5)] {
                let delta = PI / q;
                let x_f = share / (1.0 - share) * delta / 4.0;
                let oscillator = Oscillator::kinematic(TAU, delta, x_f).expect("valid");
                let decay = FreeDecay::from_rest(&oscillator, 1.0).expect("valid");
                let time: Vec<f64> = (0..(95.0 / delta) as usize).map(|i| i as f64 / 31.7).collect();
                let stop_s = decay.stop().expect("stops").time_s;
                let value = |t: f64| {
                    let (x, v) = (decay.displacement(t), decay.velocity(t));
                    match kind {
                        SignalKind::Velocity => v,
                        _ if t < stop_s => -TAU * TAU * (x + x_f * v.signum()) - 2.0 * delta * v,
                        _ => 0.0,
                    }
                };
                let signal: Vec<f64> = time.iter().map(|t| value(*t)).collect();
                let noise = 0.004 * signal.iter().fold(0.0f64, |most, v| most.max(v.abs()));
                let deviation = |repeat: usize| {
                    let noisy = |(i, v): (usize, &f64)| v + noise * jitter(repeat * time.len() + i, 0);
                    let noisy = signal.iter().enumerate().map(noisy).collect();
                    let record = Record::new(time.clone(), noisy).expect("valid").with_kind(kind);
                    let answer = analyse(
                        &record.with_unit(UNIT[usize::from(kind != SignalKind::Velocity)]),
                        &Options::default(),
                    );
                    let answer = answer.expect("fits");
                    let truths = [(Parameter::DECAY_RATE, delta), (Parameter::FRICTION_DISPLACEMENT, x_f)];
                    truths.map(|(parameter, truth)| {
                        let found = answer.parameter(parameter).expect("always reported");
                        (found.unbounded_value - truth) / found.std_error
                    })
                };
                let z: Vec<[f64; 2]> = (0..REPEATS).map(deviation).collect();
                for k in 0..2 {
                    let mean = z.iter().map(|z| z[k]).sum::<f64>() / REPEATS as f64;
                    assert!(mean.abs() < 4.0 / (REPEATS as f64).sqrt(), "{kind:?} {q} {share}: {z:.1?}");
                    assert!(z.iter().all(|z| z[k].abs() < 4.5), "{kind:?} {q} {share}: {z:.1?}");
                }
            }
        }
    }

    /// The record continues after the stop for two fifths of the duration of the motion: stop and rest are
    /// part of the fit and must not bias the friction.
    #[test]
    fn a_rest_at_the_end_leaves_the_friction_where_it_is() {
        for (q, share, noise) in [(50.0, 0.1, 0.007), (50.0, 0.5, 0.07), (1000.0, 0.5, 0.007)] {
            let delta = PI / q;
            let x_f = share / (1.0 - share) * delta / 4.0;
            let oscillator = Oscillator::kinematic(TAU, delta, x_f).expect("valid");
            let decay = FreeDecay::from_rest(&oscillator, 1.0).expect("valid");
            let end = 1.4 * decay.stop().expect("stops").time_s;
            let rate = (400.0 / end).max(8.3);
            let time: Vec<f64> = (0..(end * rate) as usize).map(|i| i as f64 / rate).collect();
            const REPEATS: usize = 12;
            let z: Vec<f64> = (0..REPEATS)
                .map(|repeat| {
                    let first = repeat * time.len();
                    let noisy = |(i, &t): (usize, &f64)| decay.displacement(t) + noise * jitter(first + i, 0);
                    let signal = time.iter().enumerate().map(noisy).collect();
                    let record = Record::new(time.clone(), signal).expect("valid");
                    let answer = analyse(&record, &Options::default()).expect("fits");
                    let found = answer.parameter(Parameter::FRICTION_DISPLACEMENT).expect("sliding found");
                    (found.unbounded_value - x_f) / found.std_error
                })
                .collect();
            let mean = z.iter().sum::<f64>() / REPEATS as f64;
            assert!(mean.abs() < 4.0 / (REPEATS as f64).sqrt(), "Q {q}, share {share}: {z:.1?}");
            assert!(z.iter().all(|z| z.abs() < 4.0), "Q {q}, share {share}: {z:.1?}");
        }
    }
}
