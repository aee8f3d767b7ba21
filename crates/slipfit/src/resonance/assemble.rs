//! Assembles the answer from the fits.

use super::averaged::{self};
use super::block::Block;
use super::criteria::Criteria;
use super::fitted_models::FittedModels;
use super::paper::Lorentzian;
use super::problem::Problem;
use super::quantities::{given_terms, is_exact, papers_parameters, parameters};
use super::response::{
    BG_IM, BG_RE, DELAY, DELTA, DRAG, DUFFING, FLOOR, ModelResponse, OFFSET, OMEGA, PHASE, R_DELTA, R_OMEGA,
    X_0, X_F, slot,
};
use super::{
    Answer, Curve, CurvePoint, Diagnostics, DriveSource, FittedCurve, Instrument, Method, Options,
    ReferenceFit, RunDirection, force, paper, reference,
};
use crate::answer::describe::{candidates, correlations, sliding_evidence, symmetric};
use crate::answer::{Parameter, SlidingEvidence, Values};
use crate::inference::Z_95;
use crate::inference::model_selection::{ModelComparison, ModelFit};
use crate::model::loss::{LossModel, LossTerm};
use crate::{Error, Quantity};
use std::f64::consts::{PI, TAU};

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
        Some(model) => comparison.largest_within(model).ok_or(Error::NoFit {
            reason: "the model asked for has more parameters than the curve determines",
        })?,
        None => comparison.reported().unwrap_or(preferred),
    };
    // If even the models within it have no fit inside the limits, the points are not a resonance.
    if chosen.model.terms().any(|term| chosen.bounded.parameters[slot(term)] < 0.0) {
        return Err(Error::NoFit {
            reason: "only a negative loss describes the curve: it may not be an amplitude, or the motion \
                     may not be steady",
        });
    }
    if d.method() == Method::Paper && d.source == DriveSource::Shape {
        return Err(Error::MissingParameter {
            name: "drive_amplitude",
            hint: "the paper's inversion needs x_0",
        });
    }
    let problem = d.problem_of(chosen);
    let p = &chosen.bounded.parameters;
    let lorentzian = papers_lorentzian(d, criteria)?;
    let (parameters, counted_losses) = match &lorentzian {
        Some(lorentzian) => (papers_parameters(used, options, d, chosen, lorentzian), None),
        None => parameters(used, options, d, chosen),
    };
    let mut shown = p.clone();
    if lorentzian.is_some() {
        let of = |parameter| parameters.get(parameter).map_or(0.0, |q| q.value);
        (shown[DELTA], shown[X_F]) = (of(Parameter::DECAY_RATE), of(Parameter::FRICTION_DISPLACEMENT));
    }
    let (lowest, highest) = amplitudes(&problem, p);
    let shares = [highest, lowest].map(|amplitude| sliding_share(&problem, &shown, amplitude));
    let sigma = comparison.noise.residual_variance(&chosen.bounded).sqrt();
    let (force, force_line) = force::balance(&problem, p, sigma, used.unit(), &criteria.force);
    let mut points = match &d.all {
        // Every point with its fitted value; the fit used the means of groups.
        Some(all) => {
            let group = (all.len() as f64 / problem.main.len() as f64).max(1.0);
            let mut everyone = problem.clone();
            everyone.main = Block { rice: group * problem.main.rice, ..all.clone() };
            points(&everyone, p, false, sigma * group.sqrt())
        }
        None => points(&problem, p, false, sigma),
    };
    let mut fit = FittedCurve {
        guide: guide(used, &problem, p, criteria.answer.run_points),
        parameters: p.clone(),
        friction_free: with_no_friction(p),
        problem: problem.clone(),
    };
    let mut diagnostics =
        Diagnostics { counted_losses, law_holds: true, ..diagnostics(curve, used, d, &points, sigma) };
    if let Some(lorentzian) = &lorentzian {
        let of = |parameter| parameters.get(parameter).map_or(0.0, |q| q.value);
        let free = [of(Parameter::DECAY_RATE), of(Parameter::DriveAmplitude)];
        fit.friction_free = lorentzian.linear(&problem, p, free);
        fit.parameters = lorentzian.linear(&problem, p, lorentzian.effective());
        describe_by(&fit, lorentzian.residual_rms() / sigma, &mut points);
        let left = lorentzian.autocorrelation(&criteria.residuals);
        diagnostics.residual_rms = lorentzian.residual_rms();
        diagnostics.residual_excess = left.variance_inflation;
        diagnostics.residual_autocorrelation = left.rho;
    }
    let reference = problem.reference.is_some().then(|| reference(d, chosen, &problem, sigma, criteria));
    let (sliding, law_holds) = evidence(d, chosen, shares);
    diagnostics.law_holds = law_holds;
    let mut answer = Answer {
        model: chosen.model,
        preferred_model: preferred.model,
        method: d.method(),
        drive_source: d.source,
        parameters,
        comparison: candidates(comparison, |f| rms(d, f), |f| values(d, f)),
        sliding,
        correlations: correlations(&chosen.unbounded, &named(comparison)),
        instrument: instrument(d, chosen),
        force,
        force_line,
        paper: paper::estimate(&problem, p, d.source != DriveSource::Shape, &criteria.search),
        reference,
        diagnostics,
        warnings: Vec::new(),
        unit: used.unit().to_owned(),
        given_terms: given_terms(used, d, chosen),
        points,
        mean_drive: used.drive().map(|d| d.iter().sum::<f64>() / d.len() as f64),
        fit,
    };
    answer.warnings = super::warnings::warnings(curve, used, d, p, &answer, options, criteria);
    Ok(answer)
}

/// The Lorentzian from which the inversion of the paper starts, if this method was requested.
fn papers_lorentzian(d: &FittedModels, criteria: &Criteria) -> Result<Option<Lorentzian>, Error> {
    if d.method() != Method::Paper {
        return Ok(None);
    }
    let b = &d.problem.main;
    let found = Lorentzian::of(b, &b.amplitudes(), &criteria.search);
    found.map(Some).ok_or(Error::NoFit { reason: "no effective Lorentzian could be fitted" })
}

/// Parameters of the same oscillator without sliding friction.
fn with_no_friction(p: &[f64]) -> Vec<f64> {
    let mut free = p.to_vec();
    free[X_F] = 0.0;
    free
}

/// Describes points by another curve, which represents their amplitudes alone; `noise` is the ratio of the scatter
/// about this curve to that about the previous one.
fn describe_by(fit: &FittedCurve, noise: f64, points: &mut [CurvePoint]) {
    for point in points {
        let value = fit.response_at(point.frequency_hz, point.drive);
        (point.fitted_amplitude, point.fitted_phase_rad) = (value.norm(), value.arg());
        point.residual = point.amplitude - point.fitted_amplitude;
        point.residual_across = 0.0;
        point.std_error *= noise;
    }
}

/// The evidence for sliding friction, with other instrument terms taken into account. If the reported losses include
/// friction, its p value is at least that in addition to these losses; if its coefficient is zero, it is not detected.
/// Also returns whether the law on which the evidence is based is valid.
fn evidence(d: &FittedModels, chosen: &ModelFit, shares: [f64; 2]) -> (SlidingEvidence, bool) {
    let found = sliding_evidence(&d.comparison, chosen, shares);
    let own = d.comparison.sliding_p_value_in(chosen).map_or(found.p_value, |p| p.max(found.p_value));
    let none = chosen.model.has(LossTerm::Sliding) && !(chosen.bounded.parameters[X_F] > 0.0);
    let p_value = if none { 1.0 } else { averaged::sliding_p_value(d, own) };
    // With a further loss a vanishing viscous loss is improbable: friction that replaces it requires stronger evidence.
    let further = !chosen.model.is_within(LossModel::VISCOUS_SLIDING);
    let takes_its_place = further && !none && !(chosen.bounded.parameters[DELTA] > 0.0);
    let penalty = if takes_its_place { d.comparison.criteria.no_viscous_penalty } else { 0.0 };
    let significant = found.detected && found.delta_bic > penalty && p_value < d.comparison.criteria.detected;
    let law_holds = !significant || d.law_holds(chosen);
    (SlidingEvidence { p_value, detected: significant && law_holds, ..found }, law_holds)
}

/// The points of the first run, if there are runs up and down.
fn guide(used: &Curve, problem: &Problem, p: &[f64], least: usize) -> Vec<[f64; 2]> {
    let has = |direction| used.runs().iter().any(|r| r.direction == direction && r.points >= least);
    let Some(run) = used.runs().iter().find(|r| r.points >= least) else { return Vec::new() };
    if !(has(RunDirection::Up) && has(RunDirection::Down)) {
        return Vec::new();
    }
    let b = &problem.main;
    let at = problem.response(p, false);
    let seen = |i: usize| b.data[i] - at.background_at(b.omega[i]);
    let amplitude =
        |i: usize| if b.complex { seen(i).norm() } else { at.amplitude_from_reading(b.data[i].re) };
    (0..b.len())
        .filter(|&i| (run.first..run.first + run.points).contains(&b.index[i]))
        .map(|i| [b.omega[i], amplitude(i)])
        .collect()
}

/// Share of sliding friction in the loss per cycle at an amplitude.
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

/// Root mean square of the residuals of a model, response unit.
fn rms(d: &FittedModels, fit: &ModelFit) -> f64 {
    let problem = d.problem_of(fit);
    let left = problem.residuals(&fit.bounded.parameters).into_iter().zip(&problem.main.weight);
    let sum: f64 = left.filter(|(_, weight)| **weight > 0.0).filter_map(|(r, _)| Some(r?.norm_sqr())).sum();
    (sum / problem.main.observations().max(1.0)).sqrt()
}

/// Slots of the parameters in a fit.
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
        amplitude_offset: term(OFFSET, ""),
        noise_floor: term(FLOOR, "").map(root),
        phase_was_conjugated: d.conjugated,
        centre_hz: d.problem.centre / TAU,
    }
}

/// The square root of a quantity; zero if the quantity is negative.
fn root(square: Quantity) -> Quantity {
    let of = |v: f64| v.max(0.0).sqrt();
    let [low, high] = square.interval_95.map(of);
    let value = of(square.value);
    Quantity {
        value,
        std_error: (high - low) / (2.0 * Z_95),
        interval_95: [low, high],
        unbounded_value: value,
        ..square
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
            let fitted_amplitude = match &m {
                Some(m) if !b.complex => b.reading(i, m).re,
                _ => size,
            };
            let apart = if b.complex {
                // Along and perpendicular to the fitted phase.
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
        counted_losses: None,
        points: d.all.as_ref().map_or(b.len(), Block::len) - d.left_out,
        outside_band: curve.len() - used.len(),
        left_out: d.left_out + d.spikes,
        noise_rms: d.neighbour_noise,
        residual_rms: sigma,
        proportional_noise: d.proportional_noise,
        residual_excess: d.comparison.noise.variance_inflation,
        residual_autocorrelation: d.autocorrelation,
        law_holds: true,
        signal_to_noise_db: 20.0 * (b.highest() / sigma.max(f64::MIN_POSITIVE)).log10(),
        line_widths: span / (2.0 * d.peak.half_width),
        points_in_line: b.omega.iter().filter(near).count(),
        points_with_stops: points.iter().filter(|p| p.stops > 0).count(),
    }
}
