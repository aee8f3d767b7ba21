//! Warnings of the answer to a curve.

use super::alternatives::TermSet;
use super::block::Block;
use super::criteria::{AnswerCriteria, Criteria};
use super::fitted_models::{FittedModels, SetAside, oscillator_amplitudes};
use super::lag;
use super::peak::Peak;
use super::response::{BG_IM, BG_RE, DELTA, DRAG, DUFFING, FLOOR, OFFSET, OMEGA, R_DELTA, R_OMEGA, X_0, X_F};
use super::{Answer, Curve, DriveSource, Method, Options, RunDirection, averaged, peak};
use crate::answer::describe::model_choice;
use crate::answer::{Parameter, Warning};
use crate::inference::model_selection::ModelFit;
use crate::model::loss::LossModel;
use crate::numeric::order::sort_by_value;
use std::f64::consts::TAU;

pub(super) fn warnings(
    curve: &Curve,
    used: &Curve,
    d: &FittedModels,
    p: &[f64],
    answer: &Answer,
    options: &Options,
    criteria: &Criteria,
) -> Vec<Warning> {
    let c = &criteria.answer;
    let mut list = Vec::new();
    let b = &d.problem.main;
    let noise = peak::noise(b).max(c.least_noise * d.neighbour_noise);
    let dropped = curve.dropped();
    if dropped.not_finite + dropped.zero_frequency > 0 {
        list.push(Warning::Dropped {
            not_finite: dropped.not_finite,
            zero_frequency: dropped.zero_frequency,
        });
    }
    if answer.diagnostics.left_out > 0 {
        list.push(Warning::Outliers { points: answer.diagnostics.left_out });
    }
    if let Some(SetAside { scatter, no_fit }) = d.set_aside.errors {
        list.push(Warning::ScatteredErrors { scatter, no_fit });
    }
    if let Some(SetAside { scatter, no_fit }) = d.set_aside.drive {
        list.push(Warning::DriveReadback { scatter, no_fit });
    }
    if b.work.was_cut() {
        list.push(Warning::SearchCut);
    }
    if d.phases_ignored {
        list.push(Warning::PhasesIgnored);
    }
    if d.conjugated {
        list.push(Warning::PhaseSign);
    }
    let shown = oscillator_amplitudes(&d.problem, p);
    let shown = shown.as_ref().unwrap_or(b);
    let noise = if std::ptr::eq(shown, b) { noise } else { peak::noise(shown).max(noise) };
    let runs = runs_of(used, shown, c.run_points);
    let lines: Vec<(&Block, Peak)> =
        runs.iter().map(|r| &r.1).filter_map(|b| Some((b, peak::find(b)?))).collect();
    let jump = lines.iter().find_map(|(b, line)| peak::jump(b, line, noise, &criteria.peak));
    let width = lines.first().map_or(d.peak.half_width, |l| l.1.half_width);
    let (hysteresis, differ) =
        runs_differ(&runs, d, width, lines.first().map_or(noise, |l| peak::noise(l.0)), c);
    if let Some(omega) = jump {
        list.push(Warning::Jump { frequency_hz: omega / TAU, hysteresis: hysteresis.is_some() });
    } else if let Some(omega) = hysteresis {
        list.push(Warning::Jump { frequency_hz: omega / TAU, hysteresis: true });
    } else if let Some(z) = differ {
        list.push(Warning::RunsDiffer { z });
    }
    if jump.is_none() && hysteresis.is_none() && differ.is_none() {
        list.extend(lagging(d, options, criteria));
    }
    if jump.is_none()
        && hysteresis.is_none()
        && let Some((omega, other, relative_height)) = lines.iter().find_map(|(b, line)| {
            peak::second_peak(b, line, noise, &criteria.peak)
                .map(|(other, height)| (line.omega, other, height))
        })
    {
        list.push(Warning::SecondPeak { main_hz: omega / TAU, other_hz: other / TAU, relative_height });
    }
    shape(&mut list, d, answer, c);
    instrument(&mut list, d, p, answer, c);
    list.extend(rival(d, answer, options, criteria));
    drive(&mut list, d, p, answer, options, criteria);
    let misfit = answer.diagnostics.residual_ratio();
    // The noise between neighbours has a relative error of about one over the square root of their number.
    if answer.diagnostics.residual_excess > 1.0 && misfit > 1.0 + 1.0 / b.observations().sqrt() {
        list.push(Warning::ModelMisfit { ratio: misfit, misfit: None });
    }
    list.extend(model_choice(&d.comparison, options.model, criteria.report.rival_bic));
    if answer.method == Method::Paper
        && let Some(paper) = &answer.paper
        && let (Some(friction), Some(q_factor)) = (paper.friction_bias, paper.q_factor_bias)
    {
        list.push(Warning::PaperBias { friction, q_factor });
    }
    for parameter in [Parameter::DECAY_RATE, Parameter::FRICTION_DISPLACEMENT] {
        if answer.parameter(parameter).is_some_and(|q| !q.interval_95[1].is_finite()) {
            list.push(Warning::Undetermined { parameter });
        }
    }
    list
}

/// Position of the points, and what the shape alone can determine.
fn shape(list: &mut Vec<Warning>, d: &FittedModels, answer: &Answer, c: &AnswerCriteria) {
    let b = &d.problem.main;
    let omega_0 = TAU * answer.parameter(Parameter::NaturalFrequency).map_or(0.0, |q| q.value);
    let (first, last) = (b.omega[0], b.omega[b.len() - 1]);
    let edge = d.peak.index == 0 || d.peak.index + 1 == b.len();
    if edge && d.peak.sides.iter().any(Option::is_none) || omega_0 < first || omega_0 > last {
        list.push(Warning::OneFlank { below: omega_0 > 0.5 * (first + last) });
    }
    if answer.diagnostics.points_in_line < c.points_in_line {
        list.push(Warning::FewPointsInLine { points: answer.diagnostics.points_in_line });
    }
    if d.source == DriveSource::Shape
        && let Some(beta) = answer.parameter(Parameter::FrictionRatio)
    {
        let [low, high] = beta.interval_95;
        if high - low > c.shape_interval * beta.value.max(c.shape_ratio) {
            list.push(Warning::ShapeAlone { friction_ratio: [low, high.min(1.0f64.max(low))] });
        }
    }
    let further = !answer.model.is_within(LossModel::VISCOUS_SLIDING);
    if further && answer.parameter(Parameter::DECAY_RATE).is_some_and(|q| q.value <= 0.0) {
        list.push(Warning::NoViscousLoss { model: answer.model });
    }
    if let Some(entry) = d.comparison.get(LossModel::VISCOUS_SLIDING) {
        let fit = &entry.unbounded;
        let correlation = fit.correlation(DELTA, X_F);
        let error = d.comparison.noise.std_error(fit, DELTA);
        if correlation.abs() > c.inseparable && error > c.inseparable_error * fit.parameters[DELTA].abs() {
            list.push(Warning::NotSeparable { correlation, decay_times: None });
        }
    }
    let stuck = answer.diagnostics.points_with_stops;
    if stuck > 0 {
        list.push(Warning::Stuck { points: stuck });
    }
}

fn instrument(list: &mut Vec<Warning>, d: &FittedModels, p: &[f64], answer: &Answer, c: &AnswerCriteria) {
    if answer.instrument.background.is_some() {
        list.push(Warning::Background {
            relative: p[BG_RE].hypot(p[BG_IM]) / d.problem.main.highest(),
            phases: d.problem.main.complex,
        });
    }
    if answer.instrument.amplitude_offset.is_some() {
        list.push(Warning::AmplitudeOffset { relative: p[OFFSET] / d.problem.main.highest() });
    }
    if let Some(floor) = &answer.instrument.noise_floor {
        list.push(Warning::NoiseFloor { relative: floor.value / d.problem.main.highest() });
    }
    if let Some(delay) = &answer.instrument.delay_s {
        let errors = -delay.value / delay.std_error;
        list.push(if errors > c.negative_delay {
            Warning::NegativeDelay { delay_s: delay.value, errors }
        } else {
            Warning::Delay { delay_s: delay.value }
        });
    }
    let lean = answer.parameter(Parameter::DuffingCoefficient);
    // A Duffing term that is zero within its error does not skew the peak.
    if p[DUFFING] != 0.0 && lean.is_none_or(|q| q.value.abs() > q.std_error) {
        let highest = d.problem.main.highest();
        let omega_0 = d.problem.centre + p[OMEGA];
        let shift = p[DUFFING] * highest * highest;
        list.push(Warning::Skewed {
            relative_shift: shift / omega_0,
            line_widths: shift / (2.0 * d.peak.half_width),
        });
    }
}

fn chosen<'a>(d: &'a FittedModels, options: &Options) -> Option<&'a ModelFit> {
    match options.model {
        Some(model) => d.comparison.largest_within(model),
        None => d.comparison.reported().or_else(|| d.comparison.preferred()),
    }
}

/// Lag of the points behind the frequency.
fn lagging(d: &FittedModels, options: &Options, criteria: &Criteria) -> Option<Warning> {
    let fit = &chosen(d, options)?.unbounded;
    let problem = d.problem.with(&fit.free);
    let shift = lag::shift(&problem, fit, d.comparison.noise, d.neighbour_noise, &criteria.lag)?;
    Some(Warning::Lag { shift_hz: shift / TAU })
}

/// Other terms apart from the losses that explain the curve equally well.
fn rival(d: &FittedModels, answer: &Answer, options: &Options, criteria: &Criteria) -> Option<Warning> {
    let chosen = chosen(d, options)?;
    let (rival, delta_bic, friction_displacement) = averaged::rival(d, chosen, criteria)?;
    let (set, chosen) = (rival.set, &chosen.unbounded.free);
    let drag = rival.unbounded.free.contains(&DRAG) && !chosen.contains(&DRAG);
    Some(Warning::RivalInstrument {
        background: set.background,
        delay: set.delay,
        offset: (set.offset != chosen.contains(&OFFSET)).then_some(set.offset),
        floor: (set.floor != chosen.contains(&FLOOR)).then_some(set.floor),
        duffing: (set.duffing != chosen.contains(&DUFFING)).then_some(set.duffing),
        drag,
        other_minimum: set == TermSet::of(&d.problem, chosen),
        delta_bic,
        friction_displacement,
        unit: answer.unit.clone(),
    })
}

fn drive(
    list: &mut Vec<Warning>,
    d: &FittedModels,
    p: &[f64],
    answer: &Answer,
    options: &Options,
    criteria: &Criteria,
) {
    let c = &criteria.answer;
    if let Some(gain) = &d.free_gain
        && gain.alternative.weight > c.other_gain
        && chosen(d, options).is_some_and(|c| averaged::moves_a_loss(d, &gain.alternative, c, criteria))
    {
        let by_shape =
            |of: &dyn Fn(&[f64]) -> f64| averaged::estimate(&gain.alternative.fit, d.comparison.noise, of);
        let (delta_bic, unit) = (gain.alternative.delta_bic, answer.unit.clone());
        let friction_displacement = by_shape(&|p| p[X_F]);
        list.push(match options.drive_amplitude {
            Some(given) => Warning::DriveDiffers {
                given: given.value,
                by_shape: by_shape(&|p| p[X_0]),
                delta_bic,
                friction_displacement,
                unit,
            },
            None => Warning::ReferenceGain { ratio: gain.ratio, delta_bic, friction_displacement, unit },
        });
    }
    let Some(reference) = &answer.reference else { return };
    let apart = (p[R_OMEGA] - p[OMEGA]).abs();
    let relative_frequency = apart / (d.problem.centre + p[OMEGA]);
    let ratio = p[R_DELTA] / p[DELTA];
    // The frequency of one resonator is constant within some widths, and its damping within a factor.
    let width = d.peak.half_width.max(p[R_DELTA]);
    let most = c.reference_damping;
    if apart > c.reference_widths * width || !(1.0 / most..=most).contains(&ratio) {
        list.push(Warning::ReferenceDiffers { relative_frequency, decay_rate_ratio: ratio });
    }
    if reference.sliding_p_value < c.reference_slides {
        list.push(Warning::ReferenceSlides { p_value: reference.sliding_p_value });
    }
}

/// The points of each run separately, if the frequency was swept both up and down; otherwise all as one run.
fn runs_of(used: &Curve, b: &Block, least_points: usize) -> Vec<(RunDirection, Block)> {
    let runs: Vec<_> = used.runs().iter().filter(|r| r.points >= least_points).collect();
    let has = |direction| runs.iter().any(|r| r.direction == direction);
    if !(has(RunDirection::Up) && has(RunDirection::Down)) {
        return vec![(RunDirection::Unordered, b.clone())];
    }
    runs.iter()
        .map(|r| {
            let of = r.first..r.first + r.points;
            let places: Vec<usize> = (0..b.len()).filter(|&i| of.contains(&b.index[i])).collect();
            (r.direction, b.subset(&places))
        })
        .collect()
}

/// Comparison of up and down runs: frequency of a jump, rad/s, or significance of a difference.
fn runs_differ(
    runs: &[(RunDirection, Block)],
    d: &FittedModels,
    half_width: f64,
    run_noise: f64,
    c: &AnswerCriteria,
) -> (Option<f64>, Option<f64>) {
    let of = |direction: RunDirection| -> Vec<(f64, f64)> {
        let mut all: Vec<(f64, f64)> = runs
            .iter()
            .filter(|r| r.0 == direction)
            .flat_map(|(_, b)| (0..b.len()).map(|i| (b.omega[i], b.amplitude(i))))
            .collect();
        sort_by_value(&mut all, |point| point.0);
        all
    };
    let (rising, falling) = (of(RunDirection::Up), of(RunDirection::Down));
    // Where the runs differ, the residuals of the fit to both are not noise.
    let noise = d.neighbour_noise.min(c.runs_noise * run_noise);
    // The noise is at least the rounding of the amplitudes.
    let noise = noise.max(f64::EPSILON * d.peak.height).max(f64::MIN_POSITIVE);
    let (mut sum, mut count, mut worst) = (0.0, 0.0, (0.0, 0.0));
    for &(omega, a) in &rising {
        let i = falling.partition_point(|f| f.0 < omega);
        if i == 0 || i == falling.len() {
            continue;
        }
        let ((w0, a0), (w1, a1)) = (falling[i - 1], falling[i]);
        let t = if w1 > w0 { (omega - w0) / (w1 - w0) } else { 0.5 };
        // Between widely spaced points linear interpolation is not accurate.
        if w1 - w0 > c.run_spacing * half_width {
            continue;
        }
        let apart = a - (a0 + t * (a1 - a0));
        sum += (apart / noise).powi(2);
        count += 1.0;
        if apart.abs() > worst.1 {
            worst = (omega, apart.abs());
        }
    }
    if count < c.runs_compared {
        return (None, None);
    }
    if worst.1 > (c.hysteresis_height * d.peak.height).max(c.hysteresis_noise * noise) {
        return (Some(worst.0), None);
    }
    // Each difference contains the noise of two points, slightly reduced by interpolation.
    let z = (sum / 2.0 - count) / (2.0f64 * count).sqrt();
    (None, (z > c.runs_differ).then_some(z))
}
