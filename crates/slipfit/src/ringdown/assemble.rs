//! From fits to the answer a person reads.

use super::compare::{Bounded, Entry, interval};
use super::envelope::{A0, DELTA, DRAG, X_F, backbone_factors, law_of};
use super::fits::{Described, Problem};
use super::fitted::{FittedMotion, Knot};
use super::law::LossLaw;
use super::measure::{Measured, Samples};
use super::segment;
use super::waveform::{BEND, CHIRP, OFFSET, OMEGA};
use super::{
    Answer, Backbone, Calibration, Candidate, Diagnostics, EnvelopePoint, LossModel, LossPoint, Options,
    OtherMode, Parameter, Segment, SlidingEvidence, Stop,
};
use crate::signal::blocks::Block;
use crate::signal::spectrum;
use crate::{Error, Quantity, Record, SignalKind};
use std::f64::consts::{PI, TAU};

/// All that was found out.
pub(crate) struct Evidence<'a> {
    pub(crate) record: &'a Record,
    pub(crate) options: &'a Options,
    pub(crate) samples: &'a Samples<'a>,
    pub(crate) measured: &'a Measured,
    pub(crate) described: &'a Described<'a>,
    pub(crate) cycles: f64,
}

/// p value below which sliding friction counts as seen.
const DETECTED: f64 = 0.01;

pub(crate) fn answer(e: &Evidence) -> Result<Answer, Error> {
    let comparison = &e.described.comparison;
    let preferred = comparison.best().ok_or(Error::NoFit { reason: "no model converged" })?;
    let chosen = match e.options.model {
        Some(model) => comparison.get(model).ok_or(Error::NoFit {
            reason: "the model asked for has more parameters than the record determines",
        })?,
        None => preferred,
    };
    let omega = angular_frequency(e, chosen);
    let law = law_of(&chosen.bounded.parameters, omega);
    let duration = e.described.end - e.described.origin;
    let (p_value, delta_bic) = comparison.sliding_evidence(e.described.scale);
    let sliding = SlidingEvidence {
        detected: p_value < DETECTED && delta_bic > 0.0,
        p_value,
        delta_bic,
        share_at_start: law.shares(law.amplitude_0)[0],
        share_at_end: law.shares(last_amplitude(e, &law))[0],
        dominates_from_s: dominates_from(&law, duration).map(|t| e.described.origin + t),
        viscous_only_p_value: comparison.viscous_only(chosen.model, e.described.scale),
    };
    let fit = fitted_motion(e, chosen, law, omega);
    let parameters = parameters(e, chosen, omega);
    let best_bic = comparison.entries.iter().map(|c| c.bic).fold(f64::INFINITY, f64::min);
    let mut candidates: Vec<Candidate> =
        comparison.entries.iter().map(|c| candidate(e, c, best_bic)).collect();
    candidates.sort_by(|a, b| a.bic.total_cmp(&b.bic));
    let correlations = correlations(e, chosen);
    let envelope = envelope_points(e, &fit);
    let diagnostics = diagnostics(e, chosen, &law);
    let stop = stop(e);
    let mut answer = Answer {
        model: chosen.model,
        parameters,
        comparison: candidates,
        sliding,
        correlations,
        segment: segment_of(e),
        loss: loss_points(e, &law, omega),
        envelope,
        backbone: backbone(e, chosen, &law, omega),
        stop,
        diagnostics,
        warnings: Vec::new(),
        signal_unit: e.record.unit().to_owned(),
        fit,
    };
    answer.warnings = super::doubts::doubts(e, &answer, preferred.model);
    Ok(answer)
}

/// Angular frequency at vanishing amplitude, rad/s.
fn angular_frequency(e: &Evidence, chosen: &Entry) -> f64 {
    match &e.described.problem {
        Problem::Waveform(_) => chosen.bounded.parameters[OMEGA],
        Problem::Envelope(problem) => problem.omega,
    }
}

/// Mean frequency over the stretch and its standard error, Hz.
fn mean_frequency(e: &Evidence, chosen: &Entry) -> Quantity {
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
fn frequency_known(e: &Evidence) -> bool {
    e.options.frequency_hz.is_some() || !matches!(e.record.kind(), SignalKind::Envelope | SignalKind::LockIn)
}

fn loss_term(e: &Evidence, chosen: &Entry, term: usize) -> (Bounded, bool) {
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

fn bounded_quantity(found: Bounded, present: bool, unit: String) -> Quantity {
    Quantity {
        value: if present { found.estimate.max(0.0) } else { 0.0 },
        std_error: found.std_error,
        interval_95: found.interval.map(|v| v.max(0.0)),
        unbounded_value: found.estimate,
        unit,
    }
}

fn parameters(e: &Evidence, chosen: &Entry, omega: f64) -> Vec<Parameter> {
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
        Quantity::normal(chosen.bounded.parameters[A0], chosen.bounded.unit_std(A0) * sigma, unit),
    );
    if let Some(calibration) = e.options.calibration {
        for (name, quantity) in physical(e, calibration, &delta, &x_f, omega, known) {
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

/// Forces from displacements: `gamma = 2 m delta`, `F = k x_F`, `k = m omega_0²`.
fn physical(
    e: &Evidence,
    calibration: Calibration,
    delta: &Quantity,
    x_f: &Quantity,
    omega: f64,
    known: bool,
) -> Vec<(&'static str, Quantity)> {
    if !known {
        return Vec::new();
    }
    let omega_0_squared = omega * omega + delta.value * delta.value;
    let (mass, stiffness, relative) = match calibration {
        Calibration::Stiffness { value, std_error } => (value / omega_0_squared, value, std_error / value),
        Calibration::Mass { value, std_error } => (value, value * omega_0_squared, std_error / value),
    };
    let (metres, angle) = length_in_metres(e.record.unit());
    // A velocity or acceleration record holds omega or omega² times the displacement.
    let motion = match e.record.kind() {
        SignalKind::Velocity => 1.0 / omega,
        SignalKind::Acceleration => 1.0 / (omega * omega),
        _ => 1.0,
    };
    let widened = |q: Quantity| -> Quantity {
        let extra = q.value * relative;
        let wide = |end: f64| {
            let d = end - q.value;
            q.value + d.signum() * d.hypot(crate::estimate::Z_95 * extra)
        };
        Quantity {
            std_error: q.std_error.hypot(extra),
            interval_95: [wide(q.interval_95[0]).max(0.0), wide(q.interval_95[1])],
            ..q
        }
    };
    let (gamma_unit, force_unit) = match (metres, angle) {
        (_, true) => ("N m s".to_owned(), "N m".to_owned()),
        (Some(_), _) => ("N s/m".to_owned(), "N".to_owned()),
        (None, _) => ("N s/m".to_owned(), format!("N/m × {}", e.record.unit())),
    };
    vec![
        ("viscous_coefficient", widened(delta.scaled(2.0 * mass, gamma_unit))),
        ("coulomb_force", widened(x_f.scaled(stiffness * motion * metres.unwrap_or(1.0), force_unit))),
    ]
}

/// Factor to metres (or radians), and whether the unit is an angle; `None` for a unit that is no length.
fn length_in_metres(unit: &str) -> (Option<f64>, bool) {
    let head = unit.split(['/', ' ', '·']).next().unwrap_or("");
    match head {
        "m" => (Some(1.0), false),
        "cm" => (Some(1e-2), false),
        "mm" => (Some(1e-3), false),
        "µm" | "um" | "μm" => (Some(1e-6), false),
        "nm" => (Some(1e-9), false),
        "pm" => (Some(1e-12), false),
        "g" => (Some(9.806_65), false),
        "rad" => (Some(1.0), true),
        "mrad" => (Some(1e-3), true),
        "deg" | "°" => (Some(PI / 180.0), true),
        "rev" => (Some(TAU), true),
        _ => (None, false),
    }
}

fn candidate(e: &Evidence, entry: &Entry, best_bic: f64) -> Candidate {
    let p = &entry.bounded.parameters;
    let n = e.described.scale.observations;
    Candidate {
        model: entry.model,
        bic: entry.bic,
        delta_bic: entry.bic - best_bic,
        rms: match &e.described.problem {
            Problem::Waveform(_) => (entry.bounded.rss / n).sqrt(),
            Problem::Envelope(problem) => problem.unweighted_rms(p),
        },
        free_parameters: entry.fit.free.len(),
        converged: entry.fit.converged,
        at_limit: entry.at_limit.map(|t| match t {
            X_F => "friction_displacement",
            DELTA => "decay_rate_per_s",
            _ => "drag_rate",
        }),
        initial_amplitude: p[A0],
        decay_rate_per_s: p[DELTA],
        friction_displacement: p[X_F],
        drag_rate: p[DRAG],
    }
}

fn correlations(e: &Evidence, chosen: &Entry) -> Vec<(&'static str, &'static str, f64)> {
    let mut named = vec![
        (A0, "initial_amplitude"),
        (DELTA, "decay_rate_per_s"),
        (X_F, "friction_displacement"),
        (DRAG, "drag_rate"),
    ];
    if matches!(e.described.problem, Problem::Waveform(_)) {
        named.push((OMEGA, "frequency_hz"));
    }
    let mut list = Vec::new();
    for (i, &(a, name_a)) in named.iter().enumerate() {
        for &(b, name_b) in &named[i + 1..] {
            if chosen.fit.free.contains(&a) && chosen.fit.free.contains(&b) {
                list.push((name_a, name_b, chosen.fit.correlation(a, b)));
            }
        }
    }
    let pair = ("decay_rate_per_s", "friction_displacement");
    if !list.iter().any(|c| (c.0, c.1) == pair)
        && let Some(both) = e.described.comparison.get(LossModel::ViscousSliding)
    {
        list.push((pair.0, pair.1, both.fit.correlation(DELTA, X_F)));
    }
    list
}

fn segment_of(e: &Evidence) -> Segment {
    let points = &e.measured.points;
    Segment {
        start_s: e.described.origin,
        end_s: e.described.end.min(e.samples.time[e.samples.time.len() - 1]),
        samples: points[points.len() - 1].end - points[0].first,
        start_reason: e.measured.stretch.start_reason,
        end_reason: e.measured.stretch.end_reason,
        cycles: if matches!(e.record.kind(), SignalKind::Envelope | SignalKind::LockIn) {
            0.0
        } else {
            e.cycles
        },
    }
}

/// Last amplitude of the law inside the segment, never below zero.
pub(crate) fn last_amplitude(e: &Evidence, law: &LossLaw) -> f64 {
    law.amplitude(e.described.end - e.described.origin)
}

/// First time from which sliding carries more than 95 % of the loss to the end.
fn dominates_from(law: &LossLaw, duration: f64) -> Option<f64> {
    let share = |t: f64| law.shares(law.amplitude(t))[0];
    if !(law.a0 > 0.0) || share(duration) <= 0.95 {
        return None;
    }
    if share(0.0) > 0.95 {
        return Some(0.0);
    }
    // The share grows as the amplitude falls.
    let (mut a, mut b) = (0.0, duration);
    for _ in 0..60 {
        let middle = 0.5 * (a + b);
        if share(middle) > 0.95 { b = middle } else { a = middle }
    }
    Some(b)
}

fn fitted_motion(e: &Evidence, chosen: &Entry, law: LossLaw, omega: f64) -> FittedMotion {
    let p = &chosen.bounded.parameters;
    let knots = match &e.described.problem {
        Problem::Waveform(problem) => {
            let count = 1024;
            (0..count)
                .map(|i| {
                    let time_s = e.described.origin
                        + (e.described.end - e.described.origin) * f64::from(i) / f64::from(count - 1);
                    let at = problem.phase_at(p, time_s);
                    let v = (time_s - e.described.origin) / problem.duration.max(f64::MIN_POSITIVE);
                    let offset = p[OFFSET] + v * (p[OFFSET + 1] + v * p[OFFSET + 2]);
                    Knot { time_s, phase: at.phase, omega: at.omega, offset }
                })
                .collect()
        }
        Problem::Envelope(_) if matches!(e.record.kind(), SignalKind::Envelope | SignalKind::LockIn) => {
            Vec::new()
        }
        Problem::Envelope(_) => e
            .measured
            .points
            .iter()
            .map(|b| Knot { time_s: b.time_s, phase: b.phase, omega: b.omega, offset: b.offset })
            .collect(),
    };
    let floor = match &e.described.problem {
        Problem::Envelope(problem) if problem.squared => p[super::envelope::FLOOR].max(0.0).sqrt(),
        _ => 0.0,
    };
    let backbone = backbone_terms(e, chosen, omega);
    let x_f = if matches!(e.described.problem, Problem::Waveform(_)) { p[X_F] } else { 0.0 };
    FittedMotion::new(e.described.origin, e.described.end, law, backbone, x_f, knots, floor)
}

/// Relative frequency shift per A² and A⁴.
fn backbone_terms(e: &Evidence, chosen: &Entry, omega: f64) -> [f64; 2] {
    match &e.described.problem {
        Problem::Waveform(_) => [chosen.bounded.parameters[BEND] / omega, 0.0],
        Problem::Envelope(problem) => problem.backbone,
    }
}

fn backbone(e: &Evidence, chosen: &Entry, law: &LossLaw, omega: f64) -> Option<Backbone> {
    if matches!(e.record.kind(), SignalKind::Envelope | SignalKind::LockIn) {
        return None;
    }
    let [quadratic, quartic] = match &e.described.problem {
        Problem::Waveform(_) => backbone_terms(e, chosen, omega),
        Problem::Envelope(_) => [e.measured.law.quadratic, e.measured.law.quartic],
    };
    let drift = match &e.described.problem {
        Problem::Waveform(_) => chosen.bounded.parameters[CHIRP] / omega,
        Problem::Envelope(_) => e.measured.law.drift,
    };
    let s = law.amplitude_0 * law.amplitude_0;
    Some(Backbone {
        frequency_at_zero_hz: omega / TAU,
        frequency_at_start_hz: omega / TAU * (1.0 + s * (quadratic + s * quartic)),
        quadratic,
        quartic,
        drift_per_s: drift,
    })
}

fn envelope_points(e: &Evidence, fit: &FittedMotion) -> Vec<EnvelopePoint> {
    let noise = e.measured.noise_rms;
    let bare = matches!(e.record.kind(), SignalKind::Envelope | SignalKind::LockIn);
    let used = e.measured.points.iter().map(|b| (b, true));
    let [from, to] = [e.measured.points[0].first, e.measured.points[e.measured.points.len() - 1].end];
    let unused = e.measured.all.iter().filter(|b| b.end <= from || b.first >= to).map(|b| (b, false));
    let mut list: Vec<EnvelopePoint> = used
        .chain(unused)
        .map(|(b, used)| EnvelopePoint {
            time_s: b.time_s,
            amplitude: b.amplitude,
            std_error: b.std_error(noise),
            fitted: if bare { fit.signal_at(b.time_s) } else { fit.amplitude_at(b.time_s) },
            frequency_hz: if bare { f64::NAN } else { b.omega / TAU },
            used,
        })
        .collect();
    list.sort_by(|a, b| a.time_s.total_cmp(&b.time_s));
    list
}

/// Slopes of the amplitude over groups of points, times the period.
fn loss_points(e: &Evidence, law: &LossLaw, omega: f64) -> Vec<LossPoint> {
    let points = &e.measured.points;
    if points.len() < 6 {
        return Vec::new();
    }
    let per_group = (points.len() / 24).max(3);
    let backbone = e.measured.law.backbone();
    // Without a frequency the loss is per second.
    let period = if frequency_known(e) { TAU / omega } else { 1.0 };
    points
        .chunks(per_group)
        .filter(|g| g.len() >= 3)
        .filter_map(|group| {
            let n = group.len() as f64;
            let t0 = group.iter().map(|b| b.time_s).sum::<f64>() / n;
            let a0 = group.iter().map(|b| b.amplitude).sum::<f64>() / n;
            let sxx: f64 = group.iter().map(|b| (b.time_s - t0).powi(2)).sum();
            let sxy: f64 = group.iter().map(|b| (b.time_s - t0) * (b.amplitude - a0)).sum();
            let error =
                (group.iter().map(|b| b.unit_variance).sum::<f64>() / n / sxx).sqrt() * e.measured.noise_rms;
            let s = a0 * a0;
            let f = backbone_factors(s * (backbone[0] + s * backbone[1]));
            let parts = [law.a0 * f[0], law.a1 * a0 * f[1], law.a2 * s * f[2]];
            (a0 > 0.0).then(|| LossPoint {
                amplitude: a0,
                loss_per_cycle: -sxy / sxx * period,
                std_error: error * period,
                fitted: parts.iter().sum::<f64>() * period,
                fitted_sliding: parts[0] * period,
            })
        })
        .collect()
}

fn diagnostics(e: &Evidence, chosen: &Entry, law: &LossLaw) -> Diagnostics {
    let variance = e.described.scale.variance_of(&chosen.bounded);
    let residual_rms = match &e.described.problem {
        Problem::Waveform(_) => (chosen.bounded.rss / e.described.scale.observations).sqrt(),
        Problem::Envelope(_) => variance.sqrt(),
    };
    let noise = e.measured.noise_rms;
    Diagnostics {
        method: e.described.problem.method(),
        noise_rms: noise,
        residual_rms,
        residual_excess: e.described.excess,
        residual_autocorrelation: e.described.autocorrelation,
        signal_to_noise_db: 20.0
            * (law.amplitude_0 / std::f64::consts::SQRT_2 / noise.max(f64::MIN_POSITIVE)).log10(),
        decay_times: (law.amplitude_0 / last_amplitude(e, law).max(1e-9 * law.amplitude_0)).ln().max(0.0),
        left_out: e.described.outliers,
        other_modes: other_modes(e),
    }
}

/// Lines of the free decay that are neither the main one nor its harmonics.
fn other_modes(e: &Evidence) -> Vec<OtherMode> {
    if matches!(e.record.kind(), SignalKind::Envelope | SignalKind::LockIn) {
        return Vec::new();
    }
    let points = &e.measured.points;
    let range = points[0].first..points[points.len() - 1].end;
    let (time, signal) = (&e.samples.time[range.clone()], &e.samples.signal[range]);
    let main = e.measured.law.mean_omega / TAU;
    // The main line is as wide as its own frequency wanders from start to end.
    let mean = |part: &[Block]| part.iter().map(|b| b.omega).sum::<f64>() / part.len() as f64 / TAU;
    let quarter = points.len().div_ceil(4);
    let spread = (mean(&points[..quarter]) - mean(&points[points.len() - quarter..])).abs() / main;
    let Some(look) = spectrum::Look::at(time, signal) else { return Vec::new() };
    let Some(own) = spectrum::dominant_of(&look, time, signal, None) else { return Vec::new() };
    spectrum::other_lines(&look, main, (2.0 * spread).max(0.02), 0.05 * own.amplitude)
        .into_iter()
        .map(|l| OtherMode { frequency_hz: l.frequency_hz, relative_amplitude: l.amplitude / own.amplitude })
        .collect()
}

/// The last sample before a silence: a recorder that writes a row when something
/// moves writes none at rest. After a mere drop-out the swing would go on.
fn silence(time: &[f64], last: &Block, period: f64) -> Option<usize> {
    let n = time.len();
    let silent = (last.first..n - 1).find(|&i| time[i + 1] - time[i] > 3.0 * period)?;
    let in_a_period = (last.end - last.first) as f64 / last.span_s * period;
    ((n - 1 - silent) as f64 <= 0.5 * in_a_period).then_some(silent)
}

/// The rest after the last used block, if the record goes on and holds still.
fn stop(e: &Evidence) -> Option<Stop> {
    if !matches!(e.record.kind(), SignalKind::Displacement) || e.options.end_s.is_some() {
        return None;
    }
    let (time, signal) = (&e.samples.time, &e.samples.signal);
    let last = e.measured.points.last()?;
    let period = TAU / last.omega;
    let n = signal.len();
    if let Some(silent) = silence(time, last, period) {
        return Some(Stop {
            time_s: time[silent],
            position: signal[silent] - last.offset,
            position_std_error: e.measured.noise_rms.hypot(super::measure::quantum(signal)),
            static_displacement: None,
        });
    }
    let tail = (n - last.end) / 4;
    if tail < 8 || time[n - 1] - time[last.end.min(n - 1)] < 2.0 * period {
        return None;
    }
    let rest = &signal[n - tail..];
    let position = rest.iter().sum::<f64>() / tail as f64;
    let scatter = (rest.iter().map(|v| (v - position).powi(2)).sum::<f64>() / tail as f64).sqrt();
    let tolerance = (4.0 * scatter.max(e.measured.noise_rms.min(scatter * 3.0)))
        .max(2.0 * super::measure::quantum(signal))
        .max(1e-9 * e.measured.points[0].amplitude);
    let moving = (last.first..n).rev().find(|&i| (signal[i] - position).abs() > tolerance)?;
    if moving + 1 >= n || time[n - 1] - time[moving] < 1.5 * period {
        return None;
    }
    // A rest is entered within a swing or two; a fading one only sinks below the noise.
    let before = time.partition_point(|&t| t < time[moving] - period);
    let swing = signal[before..=moving].iter().map(|v| (v - position).abs()).fold(0.0, f64::max);
    if swing < 3.0 * tolerance && e.measured.stretch.end_reason != segment::REST {
        return None;
    }
    let offset = last.offset;
    let error = scatter / (tail as f64).sqrt();
    Some(Stop {
        time_s: time[moving + 1],
        position: position - offset,
        position_std_error: error.hypot(e.measured.noise_rms * last.unit_variance.sqrt()),
        static_displacement: None,
    })
}
