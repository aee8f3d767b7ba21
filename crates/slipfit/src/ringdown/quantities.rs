//! The reported parameters, with their uncertainties and units.

use super::compare::slot;
use super::envelope::{A0, X_F, law_of};
use super::evidence::Evidence;
use super::last_swing::may_be_another;
use super::waveform::OMEGA;
use super::window_fit::Problem;
use crate::answer::averaged::{self, absent_losses, exchanged_losses};
use crate::answer::calibration::physical;
use crate::answer::describe::{
    LossFit, error_of_interval, fit_of, non_negative, q_factor, symmetric, undetermined, unknown,
};
use crate::answer::{Parameter, Parameters};
use crate::inference::Z_95;
use crate::inference::model_selection::{ModelComparison, ModelFit};
use crate::inference::profile::{Estimate, Profile};
use crate::model::loss::{LossModel, LossTerm};
use crate::motion::decay::parameters::shape_slot;
use crate::signal::blocks::Block;
use crate::signal::phase::phase_weight;
use crate::signal::phase_walk::{PhaseError, Smoothed};
use crate::{Quantity, Record};
use std::f64::consts::{PI, TAU};

/// Angular frequency at vanishing amplitude, rad/s.
pub(crate) fn angular_frequency(e: &Evidence, chosen: &ModelFit) -> f64 {
    match &e.fit.problem {
        Problem::Waveform(_) => chosen.bounded.parameters[OMEGA],
        Problem::Envelope(problem) => problem.omega,
    }
}

/// Mean frequency over the window and its standard error, Hz; for few samples the interval is Student's.
fn mean_frequency(e: &Evidence, chosen: &ModelFit) -> Quantity {
    let hertz = |omega: f64, std: f64, factor: f64| {
        let (value, std_error) = (omega / TAU, std / TAU);
        let half = Z_95 * factor * std_error;
        Quantity { interval_95: [value - half, value + half], ..Quantity::normal(value, std_error, "Hz") }
    };
    // The rate of a rebuilt clock lies anywhere between two limits.
    let clock = e.record.clock_report().rebuilt_rate_error / 3.0_f64.sqrt();
    let timed = |omega: f64, std: f64, factor: f64| hertz(omega, std.hypot(clock * omega), factor);
    match &e.fit.problem {
        Problem::Waveform(problem) => {
            let p = &chosen.bounded.parameters;
            let across = problem.mean_rate(p);
            let mean = across.iter().map(|&(k, d)| p[k] * d).sum::<f64>();
            if let Some(w) = e.fit.wandering {
                return timed(mean + w.mean_rate, w.rate_variance.sqrt(), 1.0);
            }
            let variance: f64 = across
                .iter()
                .flat_map(|&(i, a)| across.iter().map(move |&(k, b)| (i, k, a * b)))
                .map(|(i, k, ab)| ab * chosen.bounded.unit_covariance[(i, k)])
                .sum();
            let noise = &e.fit.comparison.noise;
            let inflated = variance.max(0.0) * noise.variance(&chosen.bounded);
            timed(mean, inflated.sqrt(), noise.student_factor(&chosen.bounded))
        }
        Problem::Envelope(problem) if e.options.frequency_hz.is_some() => hertz(problem.omega, 0.0, 1.0),
        Problem::Envelope(_) => {
            let law = &e.measured.law;
            let omega = law.mean_omega + law.mean_omega_walk_correction;
            timed(omega + lag_rate(e, chosen, law.omega).unwrap_or(0.0), law.mean_omega_std, 1.0)
        }
    }
}

/// Rate at which the fundamental falls behind the phase of the motion, rad/s, with the weights of the blocks'
/// phases.
///
/// Loss adds a quadrature component to the fundamental; relative to the amplitude it is `delta/omega` for
/// viscous damping, `(3/pi) x_F/A` for sliding friction and `(5/6) a2 A/omega` for drag. The last two change
/// as the amplitude falls. Each derivative advances the phase by the relative loss of amplitude per
/// `1/omega`.
fn lag_rate(e: &Evidence, chosen: &ModelFit, omega: f64) -> Option<f64> {
    let law = law_of(&chosen.bounded.parameters, omega);
    let noise = e.measured.noise_rms;
    let start = e.fit.origin;
    let derivatives = f64::from(e.samples.observable.order());
    let lag = |b: &Block| {
        // Within the last half cycles the motion has no defined phase.
        let amplitude =
            law.amplitude(b.time_s - start).max(b.std_error(noise)).max(0.5 * PI * law.a0 / omega);
        ((1.5 - derivatives) * law.a0 / amplitude + (5.0 / 6.0 - derivatives) * law.a2 * amplitude) / omega
    };
    let lags: Vec<PhaseError> = e
        .measured
        .points
        .iter()
        .filter(|b| phase_weight(b, noise) > e.criteria.phase.least_weight)
        .map(|b| PhaseError {
            time_s: b.time_s,
            error: lag(b),
            weight: phase_weight(b, noise),
            averaged_s: b.span_s / 6.0,
            smooth: vec![1.0, b.time_s - start],
        })
        .collect();
    // A zero amplitude without noise has no defined lag.
    Some(Smoothed::with_walk(&lags, e.measured.law.walk)?.parameters[1]).filter(|rate| rate.is_finite())
}

/// Factor that converts the signal to a displacement, and the unit of the latter: for a velocity or
/// acceleration with a corresponding unit, `1/omega` and the unit times s, or `1/omega²` and the unit times
/// s².
pub(crate) fn displacement_of(record: &Record, omega: f64) -> (f64, String) {
    let (order, unit) = record.integrated();
    (omega.powi(-order), unit)
}

/// Whether the frequency of the oscillation is known.
pub(crate) fn frequency_known(e: &Evidence) -> bool {
    e.options.frequency_hz.is_some() || e.record.kind().oscillates()
}

fn loss_fit<'a>(e: &'a Evidence<'_>, fit: &'a ModelFit) -> LossFit<'a> {
    LossFit {
        problem: e.fit.problem.least_squares(),
        unbounded: &fit.unbounded,
        noise: e.fit.comparison.noise,
        near_limit: e.criteria.report.near_limit,
        other_minima: &e.fit.other_minima,
    }
}

/// The coefficient of a loss term, from the chosen model or from the one that includes the term in addition.
fn loss_term(e: &Evidence, chosen: &ModelFit, term: LossTerm, counted: &mut Vec<LossTerm>) -> Quantity {
    let comparison = &e.fit.comparison;
    let (fit, present) = fit_of(comparison, chosen, term);
    let found = fit.map_or_else(unknown, |fit| {
        // No loss exceeds its value as the only loss, since the others are not negative.
        let most = comparison.most(term, slot(term));
        let curved = is_near_another_last_swing(e, fit);
        let found = loss_fit(e, fit).estimate(slot(term), &fit.other_slots(term, slot), most, curved);
        let mut found = found.unwrap_or_else(|| undetermined(fit.bounded.parameters[slot(term)], most));
        if curved {
            found.std_error = found.std_error.max(error_of_interval(found.value, found.interval));
        }
        with_smaller_models(comparison, fit, slot(term), with_other_minima(e, fit, found, most))
    });
    let found = non_negative(found, present, Parameter::Loss(term).unit(e.record.unit()));
    with_absent_losses(e, chosen, (slot(term), Some(term)), found, counted)
}

/// Whether the motion stops in the window, and would stop at another turning point for a friction
/// displacement that the samples do not exclude.
fn is_near_another_last_swing(e: &Evidence, fit: &ModelFit) -> bool {
    let Problem::Waveform(problem) = &e.fit.problem else { return false };
    let fit = &fit.unbounded;
    let p = &fit.parameters;
    let stops = fit.free.contains(&X_F)
        && law_of(p, p[OMEGA]).stop_time_s().is_some_and(|stop_s| stop_s < problem.duration);
    let reach = e.criteria.waveform.last_swing_errors * e.fit.comparison.noise.std_error(fit, X_F);
    stops && (!e.fit.other_minima.is_empty() || may_be_another(fit, reach))
}

/// Widens an estimate between zero and `most` if there are several minima.
fn with_other_minima(e: &Evidence, fit: &ModelFit, found: Estimate, most: Option<f64>) -> Estimate {
    if !e.fit.several_minima {
        return found;
    }
    let factor = e.fit.comparison.noise.student_factor(&fit.bounded);
    found.widened_to_std_error(factor, [0.0, most.unwrap_or(f64::INFINITY)])
}

/// For a model with a loss of fitted shape: extends an interval to the values of smaller models that lie
/// within the likelihood ratio of a 95 % interval. The profile is no higher there, although the search along
/// a curved valley may not reach it.
fn with_smaller_models(
    comparison: &ModelComparison,
    fit: &ModelFit,
    slot: usize,
    mut found: Estimate,
) -> Estimate {
    if !fit.model.terms().any(LossTerm::is_shaped) {
        return found;
    }
    let noise = comparison.noise;
    let unit = noise.variance(&fit.bounded).sqrt() * noise.student_factor(&fit.bounded);
    let near = |other: &&ModelFit| {
        let rise = other.bounded.rss - fit.bounded.rss;
        other.model.is_within(fit.model) && other.at_limit.is_none() && rise <= (Z_95 * unit).powi(2)
    };
    for other in comparison.fits.iter().filter(near) {
        let value = other.bounded.parameters[slot];
        found.interval = [found.interval[0].min(value), found.interval[1].max(value)];
    }
    found
}

/// Relative standard error assigned to the viscous loss of a model that has none.
const ABSENT_LOSS_ERROR: f64 = 1e-3;

/// The interval widened by losses that the model lacks and the data do not exclude, either added to its own
/// losses or replacing the viscous one; unchanged if the model was requested. `counted` collects those that
/// widen it noticeably.
fn with_absent_losses(
    e: &Evidence,
    chosen: &ModelFit,
    (k, of): (usize, Option<LossTerm>),
    q: Quantity,
    counted: &mut Vec<LossTerm>,
) -> Quantity {
    if e.options.model.is_some() || of.is_some_and(|term| !chosen.model.has(term)) {
        return q;
    }
    let comparison = &e.fit.comparison;
    let (mut terms, mut others) = absent_losses(comparison, chosen, of, &[(k, 1.0)], &q, slot);
    let value = |fit: &ModelFit| match of {
        Some(LossTerm::Viscous) => (0.0, ABSENT_LOSS_ERROR * q.std_error),
        _ => (fit.bounded.parameters[k], comparison.noise.std_error(&fit.bounded, k)),
    };
    let (in_place, exchanged) = exchanged_losses(comparison, chosen, value);
    let left = 1.0 - exchanged.iter().map(|o| o.weight).sum::<f64>();
    others.iter_mut().for_each(|o| o.weight *= left.max(0.0));
    others.extend(exchanged);
    terms.extend(in_place);
    if averaged::widening(&q, &others) > e.criteria.report.mentioned_widening {
        counted.extend(terms);
    }
    averaged::widened(q, &others)
}

/// The shape parameter of a loss term, if the chosen model has one: its interval is that of the profile,
/// within its limits.
fn shape(e: &Evidence, chosen: &ModelFit, term: LossTerm) -> Option<(Parameter, Quantity)> {
    let (slot_of, shape) = shape_slot(term).zip(term.shape_parameter())?;
    let parameter: Parameter = shape.name.parse().ok()?;
    let fit = &chosen.bounded;
    if !chosen.model.has(term) || !fit.free.contains(&slot_of) {
        return None;
    }
    let others: Vec<usize> = chosen.model.terms().map(slot).collect();
    let profile = Profile {
        problem: e.fit.problem.least_squares(),
        fit,
        unbounded: fit,
        noise: e.fit.comparison.noise,
        range: shape.range,
        non_negative: &others,
        other_minima: &e.fit.other_minima,
    };
    let found = profile.two_sided(slot_of, true);
    let quantity = Quantity {
        value: found.value,
        std_error: found.std_error,
        interval_95: found.interval.map(|v| v.clamp(shape.range[0], shape.range[1])),
        unbounded_value: found.unbounded,
        unit: parameter.unit(e.record.unit()),
    };
    Some((parameter, quantity))
}

/// The first amplitude; if a loss is at or near its limit, the interval is that of the profile.
fn initial_amplitude(e: &Evidence, chosen: &ModelFit) -> Quantity {
    let (noise, unit) = (e.fit.comparison.noise, e.record.unit());
    let slots: Vec<usize> = chosen.model.terms().map(slot).collect();
    if !loss_fit(e, chosen).is_near_limit(&slots) && !is_near_another_last_swing(e, chosen) {
        return symmetric(noise, &chosen.unbounded, A0, [1.0, 0.0], unit);
    }
    let problem = e.fit.problem.least_squares();
    let range = [0.0, f64::INFINITY];
    let profile = Profile {
        problem,
        fit: &chosen.bounded,
        unbounded: &chosen.unbounded,
        noise,
        range,
        non_negative: &slots,
        other_minima: &e.fit.other_minima,
    };
    let found = with_other_minima(e, chosen, profile.two_sided(A0, true), None);
    let half = (found.interval[1] - found.interval[0]) / (2.0 * Z_95);
    Quantity {
        value: found.value,
        std_error: found.std_error.max(half),
        interval_95: found.interval,
        unbounded_value: chosen.unbounded.parameters[A0],
        unit: unit.to_owned(),
    }
}

/// The fit that determines the parameters: if a loss with a fitted shape is at its limit, the data carry no
/// information about the shape, and the smaller model is used.
fn determined<'a>(comparison: &'a ModelComparison, chosen: &'a ModelFit) -> &'a ModelFit {
    let Some(term) = chosen.at_limit.filter(|t| t.is_shaped()) else { return chosen };
    let others: Vec<LossTerm> = chosen.model.terms().filter(|t| *t != term).collect();
    let smaller = LossModel::from_terms(&others).and_then(|model| comparison.get(model));
    smaller.map_or(chosen, |smaller| determined(comparison, smaller))
}

/// The parameters, and the losses that the model lacks but the intervals include.
pub(crate) fn parameters(e: &Evidence, chosen: &ModelFit, omega: f64) -> (Parameters, Option<LossModel>) {
    let unit = e.record.unit();
    let known = frequency_known(e);
    let chosen = determined(&e.fit.comparison, chosen);
    let (mut list, mut counted) = (Parameters::default(), Vec::new());
    if known {
        list.set(Parameter::Frequency, mean_frequency(e, chosen));
    }
    let delta = loss_term(e, chosen, LossTerm::Viscous, &mut counted);
    let x_f = loss_term(e, chosen, LossTerm::Sliding, &mut counted);
    list.set(Parameter::DECAY_RATE, delta.clone());
    if known {
        let (factor, unit) = displacement_of(e.record, omega);
        list.set(Parameter::FRICTION_DISPLACEMENT, x_f.scaled(factor, unit));
    }
    let gain = crate::motion::decay::amplitude::sliding_gain(delta.value, omega)[0];
    list.set(Parameter::SlidingRate, x_f.scaled(gain, Parameter::SlidingRate.unit(unit)));
    for term in e.fit.comparison.terms() {
        if !matches!(term, LossTerm::Viscous | LossTerm::Sliding) {
            list.set(Parameter::Loss(term), loss_term(e, chosen, term, &mut counted));
        }
        if let Some((parameter, quantity)) = shape(e, chosen, term) {
            list.set(parameter, quantity);
        }
    }
    if known {
        list.set(Parameter::QFactor, q_factor(&delta, |d| omega.hypot(d)));
    }
    let amplitude = initial_amplitude(e, chosen);
    let amplitude = with_absent_losses(e, chosen, (A0, None), amplitude, &mut counted);
    list.set(Parameter::InitialAmplitude, amplitude);
    if let Some(calibration) = e.options.calibration.filter(|_| known) {
        // A velocity or acceleration record is omega or omega² times the displacement.
        let displacement = x_f.scaled(omega.powi(-e.samples.observable.order()), unit);
        for (parameter, quantity) in
            physical(calibration, omega.hypot(delta.value), unit, &delta, &displacement)
        {
            list.set(parameter, quantity);
        }
    }
    (list, LossModel::from_terms(&counted))
}

#[cfg(test)]
mod tests {
    use crate::motion::decay::FreeDecay;
    use crate::motion::simulate::Drive;
    use crate::motion::simulate::smooth::{SmoothMotion, drag};
    use crate::noise::assert_held;
    use crate::noise::jitter;
    use crate::ringdown::{Options, analyse};
    use crate::{Oscillator, Parameter, Record, SignalKind};
    use std::f64::consts::{FRAC_PI_4, PI, TAU};

    /// A gyroscope record in rad/s gives the friction displacement in rad, and the frequency of the motion.
    #[test]
    fn a_velocity_gives_a_displacement() {
        let oscillator = Oscillator::kinematic(TAU, 0.02, 0.003).expect("valid");
        let decay = FreeDecay::from_rest(&oscillator, 0.5).expect("valid");
        let record = |seed: usize| {
            let time_s: Vec<f64> = (0..1500).map(|i| f64::from(i) / 50.0).collect();
            let at = |(i, &t): (usize, &f64)| decay.velocity(t) + 0.02 * jitter(2000 * seed + i, 6);
            let signal = time_s.iter().enumerate().map(at).collect();
            Record::new(time_s, signal).expect("valid").with_kind(SignalKind::Velocity).with_unit("rad/s")
        };
        assert_held(record, &Options::default(), Parameter::FRICTION_DISPLACEMENT, 0.003);
        assert_held(record, &Options::default(), Parameter::Frequency, oscillator.omega_d() / TAU);
        let answer = analyse(&record(0), &Options::default()).expect("fits");
        let x_f = answer.parameter(Parameter::FRICTION_DISPLACEMENT).expect("always reported");
        assert_eq!(x_f.unit, "rad");
        // The table of models uses the same unit.
        let chosen = answer.comparison.iter().find(|c| c.model == answer.model).expect("compared");
        assert!((chosen.value(Parameter::FRICTION_DISPLACEMENT) / x_f.value - 1.0).abs() < 1e-9);
    }

    /// Models with laws that the decay does not have: what those laws may explain must not be missing from
    /// the viscous loss, whose interval must cover the true value.
    #[test]
    fn laws_named_in_vain_leave_the_viscous_loss_in_its_interval() {
        let (q, all) = (100.0, "viscous+sliding+drag+cubic+power+stribeck+presliding");
        let oscillator = Oscillator::kinematic(TAU, TAU / (2.0 * q), 0.0).expect("valid");
        let decay = FreeDecay::from_rest(&oscillator, 1.0).expect("valid");
        for seed in 0..4 {
            let time_s: Vec<f64> = (0..1200).map(|i| f64::from(i) / 30.0).collect();
            let at = |(i, &t): (usize, &f64)| decay.displacement(t) + 0.01 * jitter(2000 * seed + i, 12);
            let signal = time_s.iter().enumerate().map(at).collect();
            let record = Record::new(time_s, signal).expect("valid");
            for model in ["viscous+power", "viscous+stribeck", "viscous+presliding", all] {
                let options = Options { model: Some(model.parse().expect("a model")), ..Options::default() };
                let answer = analyse(&record, &options).expect("fits");
                let delta = answer.parameter(Parameter::DECAY_RATE).expect("always reported");
                let [low, high] = delta.interval_95;
                let truth = TAU / (2.0 * q);
                let error = if model == all { 0.05 * truth } else { 0.01 * truth };
                assert!(low - error < truth && truth < high + error, "{model}, {seed}: {delta:?}");
                for (parameter, found) in answer.parameters.iter() {
                    let is_loss = matches!(parameter, Parameter::Loss(_));
                    assert!(
                        !is_loss || found.interval_95[1] > 0.0,
                        "{model}, {seed}, {parameter:?}: {found:?}"
                    );
                }
            }
        }
    }

    /// Drag is 2 % of the viscous loss: too little to be detected, yet it shifts the decay rate by many of
    /// its errors without drag.
    #[test]
    fn weak_drag_that_does_not_show_is_counted() {
        let (omega, delta) = (TAU, PI / 300.0);
        let oscillator = Oscillator::kinematic(omega, delta, 0.05 * delta / omega).expect("valid");
        // dA/dt = -(4/3π) c ω A² for an acceleration c v².
        let law = drag(0.02 * delta * 3.0 * FRAC_PI_4 / omega.powi(3)).expect("valid");
        let record = |repeat: usize| {
            let mut motion =
                SmoothMotion::new(&oscillator, law.clone(), Drive::none(), 0.0, 1.0, 0.0).expect("valid");
            let sample = |i: usize| {
                let clean = motion.state_at(i as f64 / 9.3).expect("moves").position;
                clean + 0.0004 * jitter(800 * repeat + i, 17)
            };
            Record::uniform(9.3, (0..800).map(sample).collect()).expect("valid")
        };
        assert_held(record, &Options::default(), Parameter::DECAY_RATE, delta);
    }
}
