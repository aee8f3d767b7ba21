//! Every sample of a window against the exact motion.

use super::cluster_jackknife::inflation_of_samples;
use super::compare::{LastSteps, Models, Search, WholeLoss, compare, loss_parameters, offer, slots};
use super::criteria::{Criteria, WaveformCriteria};
use super::envelope::{A0, DELTA, DRAG, X_F, law_of};
use super::last_swing::LastSwing;
use super::measured::MeasuredDecay;
use super::remainder::{Remainder, harmonics};
use super::samples::Samples;
use super::wandering_phase::WanderingPhase;
use super::waveform::{
    BEND, Bend, CHIRP, COUNT, Guard, OFFSET, OMEGA, Observable, PHASE, RestLevel, Waveform, rest_tells,
};
use super::window_fit::{Problem, WindowFit};
use crate::inference::least_squares::{
    Fit, LeastSquares, Normal, STEP_TOLERANCE, minimise_until, promised_gain,
};
use crate::inference::noise::NoiseModel;
use crate::inference::quadratic::given;
use crate::model::loss::{LossModel, LossTerm};
use crate::motion::decay::parameters::shape_slot;
use crate::signal::blocks;
use std::f64::consts::PI;
use std::ops::Range;

/// Parameters of phase and offset that every motion has.
const ALWAYS: [usize; 3] = [PHASE, OMEGA, OFFSET];
/// Disturbances of phase and offset, in the model only where the data pay for them.
const OPTIONAL: [usize; 4] = [BEND, CHIRP, OFFSET + 1, OFFSET + 2];

/// Accelerations jump at each turn, so that a sample on the wrong side of one holds the phase where it is: those this
/// close to a turn, rad, wait until the phase is known. Phases of blocks are less wrong than that from a Q of 5 on.
const START_GUARD: f64 = 0.15;

/// Least decay over a window that a search begins with.
const LEAST_DECAY: f64 = 1e-3;

/// Start values from the fit of the amplitudes, for a window that begins with the first block, with the disturbances
/// that the phases of the blocks show already.
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
    start[BEND] = measured.law.quadratic * measured.law.omega;
    start[CHIRP] = measured.law.drift * measured.law.omega;
    Some(start)
}

/// Fits the loss models compared, given the one asked for, to the samples of a window; disturbances of the phase that
/// `start` has are in the model until they do not pay. `None` where the phase wanders too much for the exact motion.
pub(crate) fn fit_waveform<'a>(
    samples: &'a Samples,
    measured: &MeasuredDecay,
    range: Range<usize>,
    start: Vec<f64>,
    compared: (Option<LossModel>, Models),
    criteria: &Criteria,
) -> Option<WindowFit<'a>> {
    let tells = samples.observable == Observable::Displacement
        && rest_tells(start[X_F], measured.noise_rms, range.len());
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
        && !rest_tells(best[X_F], low_frequency.sqrt(), range.len());
    let variance = found.comparison.noise.residual_variance(&found.comparison.preferred()?.bounded);
    if !wanders && !rest_is_rounded(samples, stop_s, variance, criteria) {
        return Some(found);
    }
    let (free, _) = fit(RestLevel::Free, best.clone())?;
    Some(free)
}

/// Whether rounding to the steps of the converter moves all samples at rest alike, by more than the part of the standard
/// error of their mean that the criteria allow. `variance` is that of a sample, rounding included.
///
/// Noise of `s` steps leaves of the error of a constant at most `exp(-2 pi² s²)/pi` steps (B. Widrow and I. Kollár,
/// *Quantization Noise*, 2008).
fn rest_is_rounded(samples: &Samples, stop_s: f64, variance: f64, criteria: &Criteria) -> bool {
    let at_rest = samples.len() - samples.time.partition_point(|t| *t < stop_s);
    let step = samples.converter_step(criteria.blocks.distinct_values);
    let noise = (variance - step * step / 12.0).max(0.0) / (step * step);
    let shared = step / PI * (-2.0 * PI * PI * noise).exp();
    step > 0.0 && shared * (at_rest as f64 / variance).sqrt() > criteria.waveform.rounding_of_rest
}

/// [`fit_waveform`] given what the level of the rest says, and the variance of white noise with the
/// density that the residuals have at low frequencies.
fn fit_with_rest<'a>(
    samples: &'a Samples,
    measured: &MeasuredDecay,
    range: Range<usize>,
    mut start: Vec<f64>,
    rest: RestLevel,
    (asked, models): (Option<LossModel>, Models),
    criteria: &Criteria,
) -> Option<(WindowFit<'a>, f64)> {
    let losses = loss_parameters(asked);
    // What no other term or disturbance may explain first.
    let mut basic: Vec<usize> =
        [A0, X_F, DELTA].into_iter().chain(LossTerm::further_of(asked).flat_map(slots)).collect();
    start = offer(&start, asked);
    let n = range.len();
    let origin = samples.time[range.start];
    let duration = samples.time[range.end - 1] - origin;
    let law = law_of(&start, start[OMEGA]);
    let backbone = Bend::along(|t| law.amplitude(t), duration);
    let mut problem = Waveform {
        time: &samples.time[range.clone()],
        signal: &samples.signal[range.clone()],
        observable: samples.observable,
        guard: None,
        origin,
        duration,
        bend: None,
        rest,
        // Of a phase, and of what is computed of it; that of stamps far from zero is in the samples.
        rounding_rms: f64::EPSILON * (start[OMEGA] * duration + 1.0) * start[A0].abs(),
        active: [&losses[..], &ALWAYS, &OPTIONAL].concat(),
        gathered: None,
    };
    let mut nuisance = ALWAYS.to_vec();
    if start[BEND] != 0.0 {
        problem.bend = Some(backbone.clone());
    }
    nuisance.extend([BEND, CHIRP].into_iter().filter(|&slot| start[slot] != 0.0));
    let free = with(&basic, &nuisance);
    if samples.observable == Observable::Acceleration {
        let within = |reach, start: &[f64]| {
            let guard = Some(Guard { reach, stands_for: None });
            let guarded = Waveform { guard, ..problem.clone() };
            Some(Guard { reach, stands_for: Some((n - guarded.at_turns(start)) as f64) })
        };
        let guarded = Waveform { guard: within(START_GUARD, &start), ..problem.clone() };
        start = minimum(&guarded, &start, &free)?.parameters;
        problem.guard = within(criteria.waveform.turn_guard, &start);
    }
    let mut fit = minimum(&problem, &start, &free)?;
    let excess = |fit: &Fit| fit.rss / n as f64 / measured.noise_rms.powi(2);
    let stops = |fit: &Fit| {
        law_of(&fit.parameters, fit.parameters[OMEGA]).stop_time_s().is_some_and(|t| t < duration)
    };
    problem.bend.get_or_insert(backbone);
    problem = problem.gathered_about(&fit.parameters);
    if excess(&fit) > criteria.waveform.variance_ratio && stops(&fit) && rest == RestLevel::Exact {
        fit = LastSwing::search(&problem, fit, |_| 1.0, &criteria.waveform).fit;
    }
    // In a record of a cycle or two an offset that drifts by chance would cost most of what is
    // known about the loss.
    let price = (n as f64).ln() + criteria.inference.instrument_bic_margin;
    add_nuisances(&problem, &mut fit, &basic, &mut nuisance, price)?;
    if excess(&fit) > criteria.waveform.most_excess {
        // What drag explains is no phase that wanders.
        if basic.contains(&DRAG) || asked.is_some_and(|model| !model.has(LossTerm::Drag)) {
            return None;
        }
        basic.push(DRAG);
        fit = minimum(&problem, &fit.parameters, &with(&basic, &nuisance))?;
        add_nuisances(&problem, &mut fit, &basic, &mut nuisance, price)?;
        if excess(&fit) > criteria.waveform.most_excess {
            return None;
        }
    }
    // What was started with must also pay.
    for term in [CHIRP, BEND] {
        drop_nuisance(&problem, &mut fit, &basic, &mut nuisance, term, price);
    }
    prefer_bend(&problem, &mut fit, &basic, &mut nuisance, price);
    if !nuisance.contains(&BEND) {
        problem.bend = None;
    }
    if problem.gathered.is_none() {
        problem = problem.gathered_about(&fit.parameters);
    }
    problem.active = [&losses[..], &nuisance].concat();
    problem.active.sort_unstable();
    let stands_for = problem.guard.and_then(|guard| guard.stands_for);
    let mut noise = NoiseModel::white(stands_for.unwrap_or(n as f64));
    // Of more samples, a fit that leaves no more than the noise is hardly a side minimum.
    let few = n <= criteria.waveform.multi_start_samples;
    let side_minima = excess(&fit) > criteria.waveform.variance_ratio
        || few && may_stop(&fit, n, duration, &criteria.waveform);
    if side_minima && fit.parameters[DRAG] != 0.0 && !fit.free.contains(&DRAG) {
        // That of the amplitudes, which hides where the motion stops without it.
        let mut start = fit.parameters.clone();
        start[DRAG] = 0.0;
        fit = minimum(&problem, &start, &fit.free)?;
    }
    let mut several_minima = side_minima;
    if side_minima && stops(&fit) && rest != RestLevel::Free {
        let inflation = |fit: &Fit| {
            let left = Remainder::new(&problem, range.start, fit, &measured.points);
            left.variance_inflation_beside(
                WanderingPhase::of(&problem, fit, measured.noise_rms, &criteria.phase),
                criteria,
            )
        };
        let last = LastSwing::search(&problem, fit, inflation, &criteria.waveform);
        fit = last.fit;
        several_minima = !last.is_known;
        if rest == RestLevel::Exact && !last.is_known {
            let (start, rest) = (fit.parameters, RestLevel::Bounded);
            return fit_with_rest(samples, measured, range, start, rest, (asked, models), criteria);
        }
    }
    let whole = whole_loss(&fit, duration);
    let last = problem.gathered.is_some().then(|| [problem.closely(), problem.exact()]);
    let last = last.as_ref().map(|[closely, exact]| LastSteps { closely, exact });
    let search =
        Search { asked, models, begun: Some(&fit), side_minima, last, criteria: &criteria.inference };
    let comparison = compare(&problem, &fit.parameters, &nuisance, noise, whole, search);
    let left = Remainder::new(&problem, range.start, &comparison.preferred()?.bounded, &measured.points);
    let best = &comparison.preferred()?.bounded;
    let least = criteria.sensor.samples_per_cycle;
    let harmonics = harmonics(&problem, range.start, &left, best, &measured.points, least);
    let wandering = WanderingPhase::of(&problem, best, measured.noise_rms, &criteria.phase);
    let serial_inflation = left.variance_inflation_beside(wandering, criteria);
    noise.variance_inflation = serial_inflation;
    // Where the noise about the frequency of the motion is known, the remainder is measured by that.
    let known = left.in_phase.excess * left.variance / measured.noise_rms.powi(2).max(f64::MIN_POSITIVE);
    let excess = if samples.noise_inflation > 1.0 { known } else { left.in_phase.excess };
    // What the law misses moves the cycles too, but is no noise: another law may describe it.
    if excess < criteria.answer.misfit {
        let largest = comparison.largest().map_or(best, |fit| &fit.bounded);
        let significance = criteria.inference.cluster_significance;
        let from_cycle_to_cycle = inflation_of_samples(&problem, largest, left.variance, significance);
        noise.variance_inflation = serial_inflation.max(from_cycle_to_cycle);
    }
    let fit = WindowFit {
        comparison: comparison.with_noise(noise),
        problem: Problem::Waveform(problem),
        origin,
        end: origin + duration,
        excess,
        excess_freedom: left.in_phase.freedom,
        autocorrelation: left.in_phase.autocorrelation,
        serial_inflation,
        wandering,
        harmonics,
        several_minima,
        outliers: 0,
    };
    Some((fit, left.low_frequency))
}

/// All of the loss of a fit at its first amplitude.
fn whole_loss(fit: &Fit, duration: f64) -> WholeLoss {
    let p = &fit.parameters;
    let further = law_of(p, p[OMEGA]).further_rate(p[A0]) / p[A0];
    let decay_rate = p[DELTA] + 2.0 * p[OMEGA] * p[X_F] / (PI * p[A0]) + further;
    WholeLoss::new(decay_rate.max(LEAST_DECAY / duration), p[A0], p[OMEGA])
}

/// Whether a motion that the samples do not exclude stops within the window.
fn may_stop(fit: &Fit, samples: usize, duration: f64, criteria: &WaveformCriteria) -> bool {
    // A loss of another shape beside them may leave friction without an error of its own.
    let is_shape = |slot: &usize| LossTerm::shaped().iter().any(|t| shape_slot(*t) == Some(*slot));
    let std_error = match fit.free.iter().any(is_shape) {
        true => 0.0,
        false => fit.unit_std(X_F) * (fit.rss / samples as f64).sqrt(),
    };
    let most = fit.parameters[X_F] + criteria.last_swing_errors * std_error;
    let stopping = given(fit, &[(X_F, most)]);
    stopping.is_some_and(|(_, p)| law_of(&p, p[OMEGA]).stop_time_s().is_some_and(|t| t < duration))
}

/// The minimum from a start, the last small step taken.
fn minimum(problem: &Waveform, start: &[f64], free: &[usize]) -> Option<Fit> {
    minimise_until(problem, start, free, STEP_TOLERANCE, true)
}

/// The basic losses and the nuisances, in order.
fn with(basic: &[usize], nuisance: &[usize]) -> Vec<usize> {
    let mut free = [basic, nuisance].concat();
    free.sort_unstable();
    free
}

/// Adds the nuisance that promises most, as long as one pays its price.
fn add_nuisances(
    problem: &Waveform,
    fit: &mut Fit,
    basic: &[usize],
    nuisance: &mut Vec<usize>,
    price: f64,
) -> Option<()> {
    let n = problem.time.len() as f64;
    let mut sums = Normal::zeros(COUNT);
    // The one that promises most, and its gain in variances.
    let most_promising = |sums: &Normal, nuisance: &[usize], free: usize| {
        let variance = sums.rss / (n - free as f64).max(1.0);
        // Beside drag, which may explain the same.
        let promised = |nuisance: &[usize]| {
            let mut free = with(basic, nuisance);
            free.push(DRAG);
            promised_gain(sums, &free)
        };
        let alone = promised(nuisance)?;
        let others = OPTIONAL.into_iter().filter(|o| !nuisance.contains(o));
        let others = others.filter(|&o| o != OFFSET + 2 || nuisance.contains(&(OFFSET + 1)));
        let gains = others.filter_map(|o| Some((o, (promised(&beside(nuisance, o))? - alone) / variance)));
        gains.max_by(|a, b| a.1.total_cmp(&b.1))
    };
    let rough = problem.gathered.as_ref().and_then(|(sums, _)| sums.roughly_at(&fit.parameters));
    if let Some((_, gain)) = rough.and_then(|sums| most_promising(sums, nuisance, fit.free.len()))
        && gain < ROUGH_PART * price
    {
        return Some(());
    }
    for _ in 0..OPTIONAL.len() {
        if !problem.normal(&fit.parameters, &mut sums) {
            return None;
        }
        let candidate = most_promising(&sums, nuisance, fit.free.len()).filter(|(_, gain)| *gain > price);
        let Some((term, _)) = candidate else { break };
        let wider = beside(nuisance, term);
        let Some(next) = minimum(problem, &fit.parameters, &with(basic, &wider)) else { break };
        *nuisance = wider;
        *fit = next;
    }
    Some(())
}

/// Part of its price that a disturbance roughly promises at least where it may pay it.
const ROUGH_PART: f64 = 0.5;

fn beside(nuisance: &[usize], term: usize) -> Vec<usize> {
    nuisance.iter().copied().chain([term]).collect()
}

/// Leaves a nuisance out again if the fit without it is worse by less than its price.
fn drop_nuisance(
    problem: &Waveform,
    fit: &mut Fit,
    basic: &[usize],
    nuisance: &mut Vec<usize>,
    term: usize,
    price: f64,
) {
    if !nuisance.contains(&term) {
        return;
    }
    let fewer: Vec<usize> = nuisance.iter().copied().filter(|&o| o != term).collect();
    let mut start = fit.parameters.clone();
    start[term] = 0.0;
    let Some(without) = minimum(problem, &start, &with(basic, &fewer)) else { return };
    let variance = fit.rss / (problem.time.len() as f64 - fit.free.len() as f64).max(1.0);
    if (without.rss - fit.rss) / variance < price {
        *nuisance = fewer;
        *fit = without;
    }
}

/// Takes a frequency that depends on the amplitude in place of one that drifts, if the fit is worse by less than a price:
/// every pendulum has the one, and along a short decay they look alike.
fn prefer_bend(problem: &Waveform, fit: &mut Fit, basic: &[usize], nuisance: &mut Vec<usize>, price: f64) {
    if !nuisance.contains(&CHIRP) || nuisance.contains(&BEND) {
        return;
    }
    let bent: Vec<usize> = nuisance.iter().map(|&o| if o == CHIRP { BEND } else { o }).collect();
    let mut start = fit.parameters.clone();
    start[CHIRP] = 0.0;
    let Some(found) = minimum(problem, &start, &with(basic, &bent)) else { return };
    let variance = fit.rss / (problem.time.len() as f64 - fit.free.len() as f64).max(1.0);
    if (found.rss - fit.rss) / variance < price {
        *nuisance = bent;
        *fit = found;
    }
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

    /// Viscous and sliding loss alone leave several times the noise of 60 dB, as a phase that wanders does: drag, fitted
    /// beside them, leaves none of it, whether or not the amplitudes show it first.
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

    /// Velocities and accelerations of low Q hold the truth as displacements do.
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

    /// Recorded on for two fifths of the motion after it stopped: the stop and the rest are part
    /// of what is fitted and may not pull the friction along.
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
