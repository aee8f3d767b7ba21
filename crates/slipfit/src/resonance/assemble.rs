//! From fits to the answer a person reads.

use super::averaged::{self, stretched};
use super::bias;
use super::block::Block;
use super::criteria::Criteria;
use super::fitted_models::FittedModels;
use super::paper::Lorentzian;
use super::problem::Problem;
use super::response::{
    BG_IM, BG_RE, DELAY, DELTA, DRAG, DUFFING, ModelResponse, OMEGA, PHASE, R_DELTA, R_OMEGA, X_0, X_F, slot,
};
use super::{
    Answer, Curve, CurvePoint, Diagnostics, DriveSource, FittedCurve, Instrument, Method, Options,
    ReferenceFit, RunDirection, force, paper, reference,
};
use crate::answer::calibration::physical;
use crate::answer::describe::{
    candidates, correlations, fit_of, loss_estimate, non_negative, q_factor, sliding_evidence, symmetric,
    unknown,
};
use crate::answer::{Parameter, Parameters, SlidingEvidence, Values};
use crate::inference::least_squares::{Fit, minimise};
use crate::inference::model_selection::{ModelComparison, ModelFit};
use crate::inference::profile::{Estimate, Profile};
use crate::model::loss::{LossModel, LossTerm};
use crate::{Error, Quantity};
use std::f64::consts::{FRAC_PI_4, PI, TAU};

pub(super) fn answer(
    curve: &Curve,
    used: &Curve,
    options: &Options,
    d: &FittedModels,
    criteria: &Criteria,
) -> Result<Answer, Error> {
    let comparison = &d.comparison;
    let preferred = comparison.preferred().ok_or(Error::NoFit { reason: "no model converged" })?;
    let chosen = match options.model {
        Some(model) => comparison.get(model).ok_or(Error::NoFit {
            reason: "the model asked for has more parameters than the curve determines",
        })?,
        None => comparison.reported().unwrap_or(preferred),
    };
    // Where even the models within it have no fit inside the limits, the points are no resonance.
    if chosen.model.terms().any(|term| chosen.bounded.parameters[slot(term)] < 0.0) {
        return Err(Error::NoFit {
            reason: "the curve follows a loss below zero only: it may not be an amplitude, or not be steady",
        });
    }
    if d.method() == Method::Paper && d.source == DriveSource::Shape {
        return Err(Error::MissingParameter {
            name: "drive_amplitude",
            hint: "the paper's inversion needs x_0, by --drive-amplitude or --reference",
        });
    }
    let problem = d.problem_of(chosen);
    let p = &chosen.bounded.parameters;
    let parameters = match d.method() {
        Method::Paper => papers_parameters(used, options, d, chosen, criteria)?,
        _ => parameters(used, options, d, chosen),
    };
    let mut shown = p.clone();
    if d.method() == Method::Paper {
        let of = |parameter| parameters.get(parameter).map_or(0.0, |q| q.value);
        (shown[DELTA], shown[X_F]) = (of(Parameter::DECAY_RATE), of(Parameter::FRICTION_DISPLACEMENT));
    }
    let (lowest, highest) = amplitudes(&problem, p);
    let shares = [highest, lowest].map(|amplitude| sliding_share(&problem, &shown, amplitude));
    let sigma = comparison.noise.residual_variance(&chosen.bounded).sqrt();
    let (force, force_line) = force::balance(&problem, p, sigma, used.unit(), &criteria.force);
    let points = match &d.all {
        // Every point beside the fit, of which the groups' means were part.
        Some(all) => {
            let group = (all.len() as f64 / problem.main.len() as f64).max(1.0);
            let mut everyone = problem.clone();
            everyone.main = Block { rice: group * problem.main.rice, ..all.clone() };
            points(&everyone, p, false, sigma * group.sqrt())
        }
        None => points(&problem, p, false, sigma),
    };
    let reference = problem.reference.is_some().then(|| reference(d, chosen, &problem, sigma, criteria));
    let mut answer = Answer {
        model: chosen.model,
        preferred_model: preferred.model,
        method: d.method(),
        drive_source: d.source,
        parameters,
        comparison: candidates(comparison, |f| rms(d, f), |f| values(d, f)),
        sliding: evidence(d, chosen, shares),
        correlations: correlations(&chosen.unbounded, &named(comparison)),
        instrument: instrument(d, chosen),
        force,
        force_line,
        paper: paper::estimate(&problem, p, d.source != DriveSource::Shape, &criteria.search),
        reference,
        diagnostics: diagnostics(curve, used, d, &points, sigma),
        warnings: Vec::new(),
        unit: used.unit().to_owned(),
        given_terms: given_terms(used, d, chosen),
        points,
        mean_drive: used.drive().map(|d| d.iter().sum::<f64>() / d.len() as f64),
        fit: FittedCurve {
            guide: guide(used, &problem, p, criteria.answer.run_points),
            parameters: p.clone(),
            problem,
        },
    };
    answer.warnings = super::warnings::warnings(curve, used, d, &answer, options, criteria);
    Ok(answer)
}

/// The evidence for sliding friction, other terms of the instrument counted. Where the losses reported
/// have it, it is not surer than beside those; where they have none of it, it is not seen.
fn evidence(d: &FittedModels, chosen: &ModelFit, shares: [f64; 2]) -> SlidingEvidence {
    let found = sliding_evidence(&d.comparison, chosen, shares);
    let own = d.comparison.sliding_beside(chosen).map_or(found.p_value, |p| p.max(found.p_value));
    let none = chosen.model.has(LossTerm::Sliding) && !(chosen.bounded.parameters[X_F] > 0.0);
    let p_value = if none { 1.0 } else { averaged::sliding_p_value(d, own) };
    SlidingEvidence { p_value, detected: found.detected && p_value < d.comparison.criteria.detected, ..found }
}

/// The first run's points, where there are runs up and down.
fn guide(used: &Curve, problem: &Problem, p: &[f64], least: usize) -> Vec<[f64; 2]> {
    let has = |direction| used.runs().iter().any(|r| r.direction == direction && r.points >= least);
    let Some(run) = used.runs().iter().find(|r| r.points >= least) else { return Vec::new() };
    if !(has(RunDirection::Up) && has(RunDirection::Down)) {
        return Vec::new();
    }
    let b = &problem.main;
    let at = problem.response(p, false);
    let seen = |i: usize| b.data[i] - at.background_at(b.omega[i]);
    let amplitude = |i: usize| if b.complex { seen(i).norm() } else { b.data[i].re };
    (0..b.len())
        .filter(|&i| (run.first..run.first + run.points).contains(&b.index[i]))
        .map(|i| [b.omega[i], amplitude(i)])
        .collect()
}

/// Sliding over all loss of a cycle at an amplitude.
fn sliding_share(problem: &Problem, p: &[f64], amplitude: f64) -> f64 {
    let omega_0 = problem.centre + p[OMEGA];
    // Losses as forces over the stiffness: 4 x_F/pi, 2 delta A/omega_0, 2 a2 A²/omega_0 ...
    let sliding = 4.0 / PI * p[X_F].max(0.0);
    let damping = ModelResponse::further_damping(amplitude, 1.0);
    let further: f64 = damping.iter().zip(&p[DRAG + 1..]).map(|([d, _], c)| c.max(0.0) * d).sum();
    let rest = 2.0 * amplitude / omega_0 * (p[DELTA].max(0.0) + p[DRAG].max(0.0) * amplitude + further);
    if sliding + rest > 0.0 { sliding / (sliding + rest) } else { 0.0 }
}

/// Lowest and highest amplitude of the oscillator at the points.
fn amplitudes(problem: &Problem, p: &[f64]) -> (f64, f64) {
    problem
        .predict(p, false)
        .into_iter()
        .filter_map(|m| m.map(|m| m.oscillator.norm()))
        .fold((f64::INFINITY, 0.0), |(l, h), a| (l.min(a), h.max(a)))
}

/// The coefficient of a loss term, in the chosen model or the one with the term besides.
fn loss_term(d: &FittedModels, chosen: &ModelFit, term: LossTerm, unit: &str) -> Quantity {
    let (fit, present) = fit_of(&d.comparison, chosen, term);
    let found = fit.map_or_else(unknown, |fit| {
        let problem = d.problem_of(fit);
        // No loss exceeds what it would be alone.
        let most = d.comparison.most(term, slot(term)).filter(|_| !on_background(chosen));
        let found = loss_estimate(
            &problem,
            &fit.unbounded,
            d.comparison.noise,
            slot(term),
            &fit.other_slots(term, slot),
            most,
            bends(d),
        );
        let by = if present { unbiased(d, chosen, &problem, &fit.unbounded) } else { None };
        by.map_or(found, |by| moved(found, by[slot(term)], d.criteria.most_correction))
    });
    non_negative(found, present, Parameter::Loss(term).unit(unit))
}

/// What takes the bias out of a fit that tells little; not beside a limit, which has its own.
fn unbiased(d: &FittedModels, chosen: &ModelFit, problem: &Problem, fit: &Fit) -> Option<Vec<f64>> {
    let noise = d.comparison.noise;
    let most = d.criteria.vague_friction * chosen.unbounded.parameters[X_0];
    let vague = noise.std_error(&chosen.unbounded, X_F) > most;
    let wanted = vague && chosen.at_limit.is_none() && chosen.model.has_sliding();
    let variance = noise.variance(fit);
    if wanted { bias::correction(problem, fit, variance) } else { None }
}

/// The estimate moved, not out of its interval, by `most` standard errors at most.
fn moved(e: Estimate, by: f64, most: f64) -> Estimate {
    let [low, high] = e.interval;
    let most = most * e.std_error;
    let by = by.max(-most).min(most);
    Estimate { value: (e.value + by).max(low).min(high), unbounded: e.unbounded + by, ..e }
}

/// Whether the sum of squares is far from a parabola: with the drive free, height and
/// width say one thing less than there are parameters.
fn bends(d: &FittedModels) -> bool {
    d.source != DriveSource::Known || d.problem.prior.is_some()
}

/// Standard errors of what a series compares, as if no other terms of the instrument were possible.
fn given_terms(used: &Curve, d: &FittedModels, chosen: &ModelFit) -> Vec<(Parameter, f64)> {
    let frequency =
        symmetric(d.comparison.noise, &chosen.bounded, OMEGA, [1.0 / TAU, d.problem.centre], "Hz");
    vec![
        (Parameter::NaturalFrequency, frequency.std_error),
        (Parameter::DECAY_RATE, loss_term(d, chosen, LossTerm::Viscous, used.unit()).std_error),
        (Parameter::FRICTION_DISPLACEMENT, loss_term(d, chosen, LossTerm::Sliding, used.unit()).std_error),
        (Parameter::DriveAmplitude, drive_amplitude(d, chosen, used.unit()).std_error),
    ]
}

fn parameters(used: &Curve, options: &Options, d: &FittedModels, chosen: &ModelFit) -> Parameters {
    let unit = used.unit();
    let noise = d.comparison.noise;
    let mut list = Parameters::default();
    let bounded = &chosen.bounded;
    let omega_0 = d.problem.centre + bounded.parameters[OMEGA];
    let to_hz = [1.0 / TAU, d.problem.centre];
    let frequency = symmetric(noise, bounded, OMEGA, to_hz, "Hz");
    let centre = d.problem.centre;
    list.set(Parameter::NaturalFrequency, stretched(d, frequency, &|p| (centre + p[OMEGA]) / TAU));
    let delta = stretched(d, loss_term(d, chosen, LossTerm::Viscous, unit), &|p| p[DELTA]);
    list.set(Parameter::DECAY_RATE, delta.clone());
    list.set(Parameter::QFactor, q_factor(&delta, |_| omega_0));
    let x_f = stretched(d, loss_term(d, chosen, LossTerm::Sliding, unit), &|p| p[X_F]);
    list.set(Parameter::FRICTION_DISPLACEMENT, x_f.clone());
    let x_0 = drive_amplitude(d, chosen, unit);
    let x_0 = if bounded.free.contains(&X_0) { stretched(d, x_0, &|p| p[X_0]) } else { x_0 };
    let beta = friction_ratio(d, chosen, &x_f, &x_0);
    list.set(Parameter::DriveAmplitude, x_0);
    list.set(Parameter::FrictionRatio, stretched(d, beta, &|p| p[X_F] / (FRAC_PI_4 * p[X_0])));
    for term in chosen.model.terms().filter(|t| !is_exact(*t)) {
        list.set(Parameter::Loss(term), loss_term(d, chosen, term, unit));
    }
    if bounded.free.contains(&DUFFING) {
        let unit = Parameter::DuffingCoefficient.unit(unit);
        list.set(Parameter::DuffingCoefficient, symmetric(noise, bounded, DUFFING, [1.0 / TAU, 0.0], unit));
    }
    calibrated(&mut list, options, omega_0, unit, &delta, &x_f);
    list
}

/// Adds force and viscous coefficient where a stiffness or mass is known.
fn calibrated(
    list: &mut Parameters,
    options: &Options,
    omega_0: f64,
    unit: &str,
    delta: &Quantity,
    x_f: &Quantity,
) {
    if let Some(calibration) = options.calibration {
        for (parameter, quantity) in physical(calibration, omega_0, unit, delta, x_f) {
            list.set(parameter, quantity);
        }
    }
}

/// Whether a background takes part: then no smaller model bounds what the chosen one finds.
fn on_background(chosen: &ModelFit) -> bool {
    chosen.unbounded.free.contains(&BG_RE)
}

fn drive_amplitude(d: &FittedModels, chosen: &ModelFit, unit: &str) -> Quantity {
    let (noise, bounded) = (d.comparison.noise, &chosen.bounded);
    if !bounded.free.contains(&X_0) {
        return Quantity::normal(bounded.parameters[X_0], 0.0, unit);
    }
    let problem = d.problem.with(&bounded.free);
    // By the shape alone: between no friction at all and nothing but friction.
    let end = |model: LossModel, side: f64| {
        d.comparison
            .get(model)
            .map(|f| f.bounded.parameters[X_0] + side * 4.0 * noise.std_error(&f.bounded, X_0))
            .filter(|v| v.is_finite())
    };
    let low = end(LossModel::VISCOUS, -1.0).filter(|v| *v > 0.0).unwrap_or(0.0);
    let high = end(LossModel::SLIDING, 1.0).unwrap_or(f64::INFINITY);
    let value = bounded.parameters[X_0];
    let range = if d.source == DriveSource::Shape && !on_background(chosen) {
        [low.min(value), high.max(value)]
    } else {
        [0.0, f64::INFINITY]
    };
    let losses: Vec<usize> = chosen.model.terms().map(slot).collect();
    let mut found = Profile {
        problem: &problem,
        fit: bounded,
        unbounded: &chosen.unbounded,
        noise,
        range,
        non_negative: &losses,
    }
    .two_sided(X_0, bends(d));
    let mut unbounded_value = chosen.unbounded.parameters[X_0];
    if let Some(by) = unbiased(d, chosen, &problem, bounded) {
        found = moved(found, by[X_0], d.criteria.most_correction);
        unbounded_value = found.value;
    }
    Quantity {
        value: found.value,
        std_error: found.std_error,
        interval_95: found.interval,
        unbounded_value,
        unit: unit.into(),
    }
}

/// `beta = 4 x_F/(pi x_0)`; with the drive free, from a fit in which it is a parameter.
fn friction_ratio(d: &FittedModels, chosen: &ModelFit, x_f: &Quantity, x_0: &Quantity) -> Quantity {
    let scaled = x_f.scaled(1.0 / (FRAC_PI_4 * x_0.value), "");
    if x_0.std_error == 0.0 {
        return scaled;
    }
    let (with, present) = fit_of(&d.comparison, chosen, LossTerm::Sliding);
    let found = with.and_then(|with| {
        let mut problem = d.problem_of(with);
        problem.ratio = true;
        let mut start = with.unbounded.parameters.clone();
        start[X_F] /= FRAC_PI_4 * start[X_0];
        let fit = minimise(&problem, &start, &with.unbounded.free)?;
        let most = (d.source == DriveSource::Shape).then_some(4.0 / PI);
        let found = loss_estimate(
            &problem,
            &fit,
            d.comparison.noise,
            X_F,
            &with.other_slots(LossTerm::Sliding, slot),
            most,
            true,
        );
        let by = if present { unbiased(d, chosen, &problem, &fit) } else { None };
        Some(non_negative(
            by.map_or(found, |by| moved(found, by[X_F], d.criteria.most_correction)),
            present,
            String::new(),
        ))
    });
    found.unwrap_or(scaled)
}

/// The parameters by the paper's inversion.
fn papers_parameters(
    used: &Curve,
    options: &Options,
    d: &FittedModels,
    chosen: &ModelFit,
    criteria: &Criteria,
) -> Result<Parameters, Error> {
    let b = &d.problem.main;
    let measured: Vec<f64> = (0..b.len()).map(|i| b.amplitude(i)).collect();
    let lorentzian = Lorentzian::of(b, &measured, &criteria.search)
        .ok_or(Error::NoFit { reason: "no effective Lorentzian was reached" })?;
    let unit = used.unit();
    let x_0 = drive_amplitude(d, chosen, unit);
    let found = lorentzian.invert(x_0.value);
    let [q_std, x_f_std, beta_std] = lorentzian.std_errors(x_0.value, x_0.std_error);
    let omega_0 = lorentzian.omega_0();
    let delta = omega_0 / (2.0 * found.q);
    let limited = |value: f64, std: f64, unit: &str| {
        let mut q = Quantity::normal(value, std, unit);
        q.value = value.max(0.0);
        q.interval_95 = q.interval_95.map(|v| v.max(0.0));
        q
    };
    let delta = limited(delta, delta * q_std / found.q, "1/s");
    let x_f = limited(found.x_f, x_f_std, unit);
    let hz = Quantity::normal(omega_0 / TAU, lorentzian.omega_0_std() / TAU, "Hz");
    let mut list: Parameters = [
        (Parameter::NaturalFrequency, hz),
        (Parameter::DECAY_RATE, delta.clone()),
        (Parameter::QFactor, Quantity::normal(found.q, q_std, "")),
        (Parameter::FRICTION_DISPLACEMENT, x_f.clone()),
        (Parameter::DriveAmplitude, x_0),
        (Parameter::FrictionRatio, limited(found.beta, beta_std, "")),
    ]
    .into_iter()
    .collect();
    calibrated(&mut list, options, omega_0, unit, &delta, &x_f);
    Ok(list)
}

/// Root mean square of what a model leaves, response unit.
fn rms(d: &FittedModels, fit: &ModelFit) -> f64 {
    let problem = d.problem_of(fit);
    let left = problem.residuals(&fit.bounded.parameters).into_iter().zip(&problem.main.weight);
    let sum: f64 = left.filter(|(_, weight)| **weight > 0.0).filter_map(|(r, _)| Some(r?.norm_sqr())).sum();
    (sum / problem.main.observations().max(1.0)).sqrt()
}

/// Whether a loss is one of the two that the exact response has.
fn is_exact(term: LossTerm) -> bool {
    matches!(term, LossTerm::Viscous | LossTerm::Sliding)
}

/// Where each parameter stands in a fit.
fn named(comparison: &ModelComparison) -> Vec<(usize, Parameter)> {
    let loss = |term: LossTerm| (slot(term), Parameter::Loss(term));
    let mut list = vec![(OMEGA, Parameter::NaturalFrequency)];
    list.extend(comparison.terms().filter(|term| is_exact(*term)).map(loss));
    list.push((X_0, Parameter::DriveAmplitude));
    list.extend(comparison.terms().filter(|term| !is_exact(*term)).map(loss));
    list.push((DUFFING, Parameter::DuffingCoefficient));
    list
}

fn values(d: &FittedModels, fit: &ModelFit) -> Values {
    let value = |slot: usize, parameter: Parameter| match parameter {
        Parameter::NaturalFrequency => (d.problem.centre + fit.bounded.parameters[slot]) / TAU,
        Parameter::Loss(term) if !is_exact(term) && !fit.model.has(term) => 0.0,
        _ => fit.bounded.parameters[slot],
    };
    let named = named(&d.comparison).into_iter();
    let shown = named.filter(|(_, parameter)| *parameter != Parameter::DuffingCoefficient);
    shown.map(|(slot, parameter)| (parameter, value(slot, parameter))).collect()
}

fn instrument(d: &FittedModels, chosen: &ModelFit) -> Instrument {
    let fit = &chosen.bounded;
    let noise = d.comparison.noise;
    let term =
        |k: usize, unit: &str| fit.free.contains(&k).then(|| symmetric(noise, fit, k, [1.0, 0.0], unit));
    let phase = term(PHASE, "rad").map(|mut q| {
        let turn = super::start::wrapped(q.value) - q.value;
        q.value += turn;
        q.unbounded_value += turn;
        q.interval_95 = q.interval_95.map(|v| v + turn);
        q
    });
    Instrument {
        phase_offset_rad: phase,
        delay_s: term(DELAY, "s"),
        background: term(BG_RE, "").zip(term(BG_IM, "")).map(|(a, b)| [a, b]),
        background_delayed: d.problem.background_delayed
            && fit.free.contains(&DELAY)
            && fit.free.contains(&BG_RE),
        phase_was_conjugated: d.conjugated,
        centre_hz: d.problem.centre / TAU,
    }
}

fn points(problem: &Problem, p: &[f64], reference: bool, sigma: f64) -> Vec<CurvePoint> {
    let Some(b) = (if reference { problem.reference.as_ref() } else { Some(&problem.main) }) else {
        return Vec::new();
    };
    problem
        .predict(p, reference)
        .into_iter()
        .enumerate()
        .map(|(i, m)| {
            let value = m.map_or(crate::motion::steady::Phasor::new(f64::NAN, f64::NAN), |m| m.value);
            let size = value.norm();
            let fitted_amplitude = if b.complex { size } else { b.read(size, i) };
            let apart = if b.complex {
                // Along and across the fitted phase.
                (b.data[i] - value) * value.conj() / size
            } else {
                crate::motion::steady::Phasor::new(b.data[i].re - fitted_amplitude, 0.0)
            };
            CurvePoint {
                index: b.index[i],
                frequency_hz: b.omega[i] / TAU,
                amplitude: b.amplitude(i),
                phase_rad: b.complex.then(|| b.data[i].arg()),
                std_error: sigma / b.precision[i].sqrt(),
                fitted_amplitude,
                fitted_phase_rad: value.arg(),
                residual: apart.re,
                residual_across: apart.im,
                stops: m.map_or(0, |m| m.regime.stops()),
                drive: b.drive[i],
            }
        })
        .collect()
}

fn reference(
    d: &FittedModels,
    chosen: &ModelFit,
    problem: &Problem,
    sigma: f64,
    criteria: &Criteria,
) -> ReferenceFit {
    let (noise, fit) = (d.comparison.noise, &chosen.bounded);
    let own_sigma = sigma / problem.reference_weight.sqrt();
    ReferenceFit {
        natural_frequency_hz: symmetric(noise, fit, R_OMEGA, [1.0 / TAU, d.problem.centre], "Hz"),
        decay_rate_per_s: symmetric(noise, fit, R_DELTA, [1.0, 0.0], "1/s"),
        points: points(problem, &fit.parameters, true, own_sigma),
        sliding_p_value: reference::sliding_p_value(problem, fit, &criteria.search),
    }
}

fn diagnostics(
    curve: &Curve,
    used: &Curve,
    d: &FittedModels,
    points: &[CurvePoint],
    sigma: f64,
) -> Diagnostics {
    let b = &d.problem.main;
    let span = b.omega[b.len() - 1] - b.omega[0];
    let near = |w: &&f64| (**w - d.peak.omega).abs() <= d.peak.half_width;
    Diagnostics {
        points: d.all.as_ref().map_or(b.len(), Block::len) - d.left_out,
        outside_band: curve.len() - used.len(),
        left_out: d.left_out,
        noise_rms: d.neighbour_noise,
        residual_rms: sigma,
        proportional_noise: d.proportional_noise,
        residual_excess: d.comparison.noise.variance_inflation,
        residual_autocorrelation: d.autocorrelation,
        signal_to_noise_db: 20.0 * (b.highest() / sigma.max(f64::MIN_POSITIVE)).log10(),
        line_widths: span / (2.0 * d.peak.half_width),
        points_in_line: b.omega.iter().filter(near).count(),
        points_with_stops: points.iter().filter(|p| p.stops > 0).count(),
    }
}
