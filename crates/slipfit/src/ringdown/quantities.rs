//! The parameters a person reads, with their uncertainties and units.

use super::assemble::Evidence;
use super::compare::{Bounded, interval};
use super::envelope::{A0, DELTA, DRAG, X_F};
use super::fits::Problem;
use super::ranked::Entry;
use super::waveform::OMEGA;
use super::{LossModel, Parameter};
use crate::model::calibration::physical;
use crate::{Quantity, SignalKind};
use std::f64::consts::TAU;
/// Angular frequency at vanishing amplitude, rad/s.
pub(crate) fn angular_frequency(e: &Evidence, chosen: &Entry) -> f64 {
    match &e.described.problem {
        Problem::Waveform(_) => chosen.bounded.parameters[OMEGA],
        Problem::Envelope(problem) => problem.omega,
    }
}

/// Mean frequency over the stretch and its standard error, Hz.
pub(crate) fn mean_frequency(e: &Evidence, chosen: &Entry) -> Quantity {
    let (omega, std) = match &e.described.problem {
        Problem::Waveform(problem) => {
            let p = &chosen.bounded.parameters;
            let across = problem.mean_rate();
            let mean = across.iter().map(|&(k, d)| p[k] * d).sum::<f64>();
            let variance: f64 = across
                .iter()
                .flat_map(|&(i, a)| across.iter().map(move |&(k, b)| (i, k, a * b)))
                .map(|(i, k, ab)| ab * chosen.bounded.unit_covariance[(i, k)])
                .sum();
            let scale = e.described.scale;
            (mean, (variance.max(0.0) * scale.variance_of(&chosen.bounded) * scale.widening).sqrt())
        }
        Problem::Envelope(problem) if e.options.frequency_hz.is_some() => (problem.omega, 0.0),
        Problem::Envelope(_) => (e.measured.law.mean_omega, e.measured.law.mean_omega_std),
    };
    Quantity::normal(omega / TAU, std / TAU, "Hz")
}

/// Whether the frequency of the oscillation is known.
pub(crate) fn frequency_known(e: &Evidence) -> bool {
    e.options.frequency_hz.is_some() || !matches!(e.record.kind(), SignalKind::Envelope | SignalKind::LockIn)
}

pub(crate) fn loss_term(e: &Evidence, chosen: &Entry, term: usize) -> (Bounded, bool) {
    let present = chosen.fit.free.contains(&term);
    let entry = if present { Some(chosen) } else { e.described.comparison.with_term(chosen.model, term) };
    match entry {
        Some(entry) => {
            let mut found =
                interval(e.described.problem.least_squares(), &entry.fit, term, e.described.scale);
            // No loss exceeds what it would be alone: the others are not negative.
            if let Some(most) = alone(e, term) {
                found.interval[1] = found.interval[1].min(most.max(found.estimate));
            }
            (found, present)
        }
        None => (Bounded { estimate: 0.0, std_error: f64::INFINITY, interval: [0.0, f64::INFINITY] }, false),
    }
}

/// Far upper end of a loss term in the model that holds nothing else.
fn alone(e: &Evidence, term: usize) -> Option<f64> {
    let model = LossModel::from_terms(term == DELTA, term == X_F, false)?;
    let entry = e.described.comparison.get(model)?;
    let scale = e.described.scale;
    let error = entry.fit.unit_std(term) * (scale.variance_of(&entry.fit) * scale.widening).sqrt();
    let most = entry.fit.parameters[term].max(0.0) + 4.0 * error;
    most.is_finite().then_some(most)
}

/// Where not even a variance can be formed nothing is known.
fn known_error(std_error: f64) -> f64 {
    if std_error.is_nan() { f64::INFINITY } else { std_error }
}

fn bounded_quantity(found: Bounded, present: bool, unit: String) -> Quantity {
    Quantity {
        value: if present { found.estimate.max(0.0) } else { 0.0 },
        std_error: known_error(found.std_error),
        interval_95: found.interval.map(|v| v.max(0.0)),
        unbounded_value: found.estimate,
        unit,
    }
}

pub(crate) fn parameters(e: &Evidence, chosen: &Entry, omega: f64) -> Vec<Parameter> {
    let unit = e.record.unit();
    let known = frequency_known(e);
    let mut list = Vec::new();
    let mut push = |name, quantity| list.push(Parameter { name, quantity });
    if known {
        push("frequency_hz", mean_frequency(e, chosen));
    }
    let (delta, has_delta) = loss_term(e, chosen, DELTA);
    let delta = bounded_quantity(delta, has_delta, "1/s".into());
    let (x_f, has_x_f) = loss_term(e, chosen, X_F);
    let x_f = bounded_quantity(x_f, has_x_f, unit.into());
    let (drag, has_drag) = loss_term(e, chosen, DRAG);
    push("decay_rate_per_s", delta.clone());
    if known {
        push("friction_displacement", x_f.clone());
    }
    let gain = super::envelope::sliding_gain(delta.value, omega).0;
    push("sliding_rate", x_f.scaled(gain, per_second(unit)));
    push(
        "drag_rate",
        bounded_quantity(
            drag,
            has_drag,
            if unit.is_empty() { "1/s".into() } else { format!("1/({unit} s)") },
        ),
    );
    if known {
        push("q_factor", q_factor(&delta, omega));
    }
    let sigma = (e.described.scale.variance_of(&chosen.bounded) * e.described.scale.widening).sqrt();
    push(
        "initial_amplitude",
        Quantity::normal(
            chosen.bounded.parameters[A0],
            known_error(chosen.bounded.unit_std(A0) * sigma),
            unit,
        ),
    );
    if let Some(calibration) = e.options.calibration.filter(|_| known) {
        // A velocity or acceleration record holds omega or omega² times the displacement.
        let motion = match e.record.kind() {
            SignalKind::Velocity => 1.0 / omega,
            SignalKind::Acceleration => 1.0 / (omega * omega),
            _ => 1.0,
        };
        let moved = x_f.scaled(motion, unit);
        for (name, quantity) in physical(calibration, omega.hypot(delta.value), unit, &delta, &moved) {
            push(name, quantity);
        }
    }
    list
}

fn per_second(unit: &str) -> String {
    if unit.is_empty() { "1/s".into() } else { format!("{unit}/s") }
}

/// `Q = omega_0/(2 delta)`, the viscous part only; infinite where no viscous loss is seen.
fn q_factor(delta: &Quantity, omega: f64) -> Quantity {
    let q = |d: f64| if d > 0.0 { omega.hypot(d) / (2.0 * d) } else { f64::INFINITY };
    let value = q(delta.value);
    Quantity {
        value,
        std_error: if delta.value > 0.0 { value * delta.std_error / delta.value } else { f64::INFINITY },
        interval_95: [q(delta.interval_95[1]), q(delta.interval_95[0])],
        unbounded_value: value,
        unit: String::new(),
    }
}
