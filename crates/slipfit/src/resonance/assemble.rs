//! From fits to the answer a person reads.

use super::bias;
use super::block::Block;
use super::described::{Described, loss_terms};
use super::paper::Lorentzian;
use super::problem::{
    BG_IM, BG_RE, COUNT, DELAY, DELTA, DRAG, DUFFING, OMEGA, PHASE, Problem, R_BG_IM, R_BG_RE, R_DELTA,
    R_OMEGA, R_PHASE, X_0, X_F,
};
use super::{
    Answer, Candidate, Curve, CurvePoint, Diagnostics, DriveSource, FittedCurve, Instrument, Method, Options,
    Parameter, ReferenceFit, RunDirection, SlidingEvidence, force, paper,
};
use crate::inference::least_squares::{Fit, minimise};
use crate::inference::profile::{Estimate, Profile};
use crate::model::calibration::physical;
use crate::ringdown::{Entry, LossModel};
use crate::{Error, Quantity};
use std::f64::consts::{FRAC_PI_4, PI, TAU};

/// p value below which sliding friction counts as seen.
const DETECTED: f64 = 0.01;

pub(super) fn answer(curve: &Curve, used: &Curve, options: &Options, d: &Described) -> Result<Answer, Error> {
    let preferred = d.preferred().ok_or(Error::NoFit { reason: "no model converged" })?;
    let chosen = match options.model {
        Some(model) => d.get(model).ok_or(Error::NoFit {
            reason: "the model asked for has more parameters than the curve determines",
        })?,
        // Without a viscous loss, which BIC may spare, friction would look far surer than it is.
        None if preferred.model == LossModel::Sliding => {
            d.get(LossModel::ViscousSliding).unwrap_or(preferred)
        }
        None => preferred,
    };
    let preferred = if options.model.is_some() { preferred } else { chosen };
    if d.method() == Method::Paper && d.source == DriveSource::Shape {
        return Err(Error::MissingParameter {
            name: "drive_amplitude",
            hint: "the paper's inversion needs x_0, by --drive-amplitude or --reference",
        });
    }
    let problem = d.problem_of(chosen);
    let p = &chosen.bounded.parameters;
    let (p_value, delta_bic) = d.sliding_evidence();
    let parameters = match d.method() {
        Method::Paper => papers_parameters(used, options, d, chosen)?,
        _ => parameters(used, options, d, chosen),
    };
    let mut shown = p.clone();
    if d.method() == Method::Paper {
        let of = |name: &str| parameters.iter().find(|q| q.name == name).map_or(0.0, |q| q.quantity.value);
        (shown[DELTA], shown[X_F]) = (of("decay_rate_per_s"), of("friction_displacement"));
    }
    let share = |amplitude: f64| sliding_share(&problem, &shown, amplitude);
    let (lowest, highest) = amplitudes(&problem, p);
    let sliding = SlidingEvidence {
        detected: p_value < DETECTED && delta_bic > 0.0,
        p_value,
        delta_bic,
        share_at_peak: share(highest),
        share_at_lowest: share(lowest),
        viscous_only_p_value: d.viscous_only(chosen.model),
    };
    let sigma = (d.scale.variance_of(&chosen.bounded)).sqrt();
    let best_bic = d.entries.iter().map(|e| e.bic).fold(f64::INFINITY, f64::min);
    let mut comparison: Vec<Candidate> = d.entries.iter().map(|e| candidate(d, e, best_bic)).collect();
    comparison.sort_by(|a, b| a.bic.total_cmp(&b.bic));
    let (force, force_line) = force::balance(&problem, p, sigma, used.unit());
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
    let reference = problem.reference.is_some().then(|| reference(d, chosen, &problem, sigma));
    let mut answer = Answer {
        model: chosen.model,
        method: d.method(),
        drive_source: d.source,
        parameters,
        comparison,
        sliding,
        correlations: correlations(chosen),
        instrument: instrument(d, chosen),
        force,
        force_line,
        paper: paper::estimate(&problem, p, d.source != DriveSource::Shape),
        reference,
        diagnostics: diagnostics(curve, used, d, &points, sigma),
        warnings: Vec::new(),
        unit: used.unit().to_owned(),
        points,
        mean_drive: used.drive().map(|d| d.iter().sum::<f64>() / d.len() as f64),
        fit: FittedCurve { guide: guide(used, &problem, p), parameters: p.clone(), problem },
    };
    answer.warnings = super::doubts::doubts(curve, used, d, &answer, preferred);
    Ok(answer)
}

/// The first run's points, where there are runs up and down.
fn guide(used: &Curve, problem: &Problem, p: &[f64]) -> Vec<[f64; 2]> {
    let has = |direction| used.runs().iter().any(|r| r.direction == direction && r.points >= 5);
    let Some(run) = used.runs().iter().find(|r| r.points >= 5) else { return Vec::new() };
    if !(has(RunDirection::Up) && has(RunDirection::Down)) {
        return Vec::new();
    }
    let b = &problem.main;
    let at = problem.setting(p, false);
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
    // Losses as forces over the stiffness: 4 x_F/pi, 2 delta A/omega_0, 2 a2 A²/omega_0.
    let sliding = 4.0 / PI * p[X_F].max(0.0);
    let rest = 2.0 * amplitude / omega_0 * (p[DELTA].max(0.0) + p[DRAG].max(0.0) * amplitude);
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

/// A loss term of the chosen model, or of the model with it besides.
fn loss_term(d: &Described, chosen: &Entry, term: usize) -> (Estimate, bool) {
    let present = chosen.fit.free.contains(&term);
    let entry = if present { Some(chosen) } else { d.with_term(chosen.model, term) };
    let Some(entry) = entry else {
        let open = [0.0, f64::INFINITY];
        return (Estimate { value: 0.0, std_error: f64::INFINITY, interval: open }, false);
    };
    let problem = d.problem_of(entry);
    // No loss exceeds what it would be alone.
    let most = alone(d, term)
        .filter(|_| !on_background(chosen))
        .map_or(f64::INFINITY, |m| m.max(entry.fit.parameters[term]));
    let profile = Profile { problem: &problem, fit: &entry.fit, scale: d.scale, range: [0.0, most] };
    let mut found = profile.non_negative(term, bends(d));
    found.interval[1] = found.interval[1].min(most);
    if present && let Some(by) = unbiased(d, chosen, &problem, &entry.fit) {
        found = moved(found, by[term]);
    }
    (found, present)
}

/// Standard error of `x_F` over the drive from which on the bias of least squares, which goes with
/// its square, is worth taking out.
const VAGUE: f64 = 0.2;

/// What takes the bias out of a fit that tells little; not beside a limit, which has its own.
fn unbiased(d: &Described, chosen: &Entry, problem: &Problem, fit: &Fit) -> Option<Vec<f64>> {
    let (error, _) = d.scale.std_error(&chosen.fit, X_F);
    let vague = error > VAGUE * chosen.fit.parameters[X_0];
    let wanted = vague && chosen.at_limit.is_none() && chosen.fit.free.contains(&X_F);
    let variance = d.scale.variance_of(fit) * d.scale.widening;
    if wanted { bias::correction(problem, fit, variance) } else { None }
}

/// The estimate moved, not out of its interval; by more than half a standard error it is no second
/// order any more.
fn moved(e: Estimate, by: f64) -> Estimate {
    let [low, high] = e.interval;
    let most = 0.5 * e.std_error;
    Estimate { value: (e.value + by.max(-most).min(most)).max(low).min(high), ..e }
}

/// Whether the sum of squares is far from a parabola: with the drive free, height and
/// width say one thing less than there are parameters.
fn bends(d: &Described) -> bool {
    d.source != DriveSource::Known || d.problem.prior.is_some()
}

/// Far upper end of a loss term in the model that holds nothing else.
fn alone(d: &Described, term: usize) -> Option<f64> {
    let model = LossModel::from_terms(term == DELTA, term == X_F, false)?;
    let entry = d.get(model)?;
    let (error, _) = d.scale.std_error(&entry.fit, term);
    let most = entry.fit.parameters[term].max(0.0) + 4.0 * error;
    most.is_finite().then_some(most)
}

fn non_negative(found: Estimate, present: bool, unit: &str) -> Quantity {
    Quantity {
        value: if present { found.value.max(0.0) } else { 0.0 },
        std_error: found.std_error,
        interval_95: found.interval.map(|v| v.max(0.0)),
        unbounded_value: found.value,
        unit: unit.into(),
    }
}

fn plain(d: &Described, fit: &Fit, k: usize, factor: f64, offset: f64, unit: &str) -> Quantity {
    let (error, wide) = d.scale.std_error(fit, k);
    let mut q = Quantity::normal((fit.parameters[k] + offset) * factor, error * factor.abs(), unit);
    let half = crate::inference::Z_95 * error * wide * factor.abs();
    q.interval_95 = [q.value - half, q.value + half];
    q
}

/// `Q = omega_0/(2 delta)`; infinite where no viscous loss is seen.
fn q_factor(delta: &Quantity, omega_0: f64) -> Quantity {
    let q = |d: f64| if d > 0.0 { omega_0 / (2.0 * d) } else { f64::INFINITY };
    let value = q(delta.value);
    Quantity {
        value,
        std_error: if delta.value > 0.0 { value * delta.std_error / delta.value } else { f64::INFINITY },
        interval_95: [q(delta.interval_95[1]), q(delta.interval_95[0])],
        unbounded_value: omega_0 / (2.0 * delta.unbounded_value),
        unit: String::new(),
    }
}

fn parameters(used: &Curve, options: &Options, d: &Described, chosen: &Entry) -> Vec<Parameter> {
    let unit = used.unit();
    let mut list = Vec::new();
    let mut push = |name, quantity| list.push(Parameter { name, quantity });
    let bounded = &chosen.bounded;
    let omega_0 = d.problem.centre + bounded.parameters[OMEGA];
    push("natural_frequency_hz", plain(d, bounded, OMEGA, 1.0 / TAU, d.problem.centre, "Hz"));
    let (delta, has_delta) = loss_term(d, chosen, DELTA);
    let delta = spanned(d, non_negative(delta, has_delta, "1/s"), |p| p[DELTA]);
    push("decay_rate_per_s", delta.clone());
    push("q_factor", q_factor(&delta, omega_0));
    let (x_f, has_x_f) = loss_term(d, chosen, X_F);
    let x_f = spanned(d, non_negative(x_f, has_x_f, unit), |p| p[X_F]);
    push("friction_displacement", x_f.clone());
    let x_0 = drive_amplitude(d, chosen, unit);
    let x_0 = if bounded.free.contains(&X_0) { spanned(d, x_0, |p| p[X_0]) } else { x_0 };
    let beta = friction_ratio(d, chosen, &x_f, &x_0);
    let beta = spanned(d, beta, |p| p[X_F] / (FRAC_PI_4 * p[X_0]));
    push("drive_amplitude", x_0);
    push("friction_ratio", beta);
    if chosen.fit.free.contains(&DRAG) {
        let (drag, present) = loss_term(d, chosen, DRAG);
        let drag_unit = if unit.is_empty() { "1/s".to_owned() } else { format!("1/({unit} s)") };
        push("drag_rate", non_negative(drag, present, &drag_unit));
    }
    if bounded.free.contains(&DUFFING) {
        let lean_unit = if unit.is_empty() { "Hz".to_owned() } else { format!("Hz/{unit}²") };
        push("frequency_shift_by_amplitude", plain(d, bounded, DUFFING, 1.0 / TAU, 0.0, &lean_unit));
    }
    if let Some(calibration) = options.calibration {
        for (name, quantity) in physical(calibration, omega_0, unit, &delta, &x_f) {
            push(name, quantity);
        }
    }
    list
}

/// The interval stretched over those of all minima that explain the data as well.
fn spanned(d: &Described, mut q: Quantity, of: fn(&[f64]) -> f64) -> Quantity {
    if d.minima.len() < 2 {
        return q;
    }
    for fit in &d.minima {
        let p = &fit.parameters;
        let slopes: Vec<(usize, f64)> = fit
            .free
            .iter()
            .filter(|&&k| [DELTA, X_0, X_F].contains(&k))
            .map(|&k| {
                let step = 1e-4 * fit.unit_std(k).max(1e-9 * p[k].abs()).min(p[k].abs().max(1e-12));
                let (mut up, mut down) = (p.clone(), p.clone());
                (up[k], down[k]) = (p[k] + step, p[k] - step);
                (k, (of(&up) - of(&down)) / (2.0 * step))
            })
            .collect();
        let mut square = 0.0;
        for &(a, slope_a) in &slopes {
            for &(b, slope_b) in &slopes {
                square += slope_a * slope_b * fit.unit_covariance[(a, b)];
            }
        }
        let variance = d.scale.variance_of(fit) * d.scale.widening;
        let half = crate::inference::Z_95 * (square.max(0.0) * variance).sqrt();
        if half.is_finite() {
            q.interval_95[0] = q.interval_95[0].min((of(p) - half).max(0.0));
            q.interval_95[1] = q.interval_95[1].max(of(p) + half);
        }
    }
    q
}

/// Whether a background takes part: then no smaller model bounds what the chosen one finds.
fn on_background(chosen: &Entry) -> bool {
    chosen.fit.free.contains(&BG_RE)
}

fn drive_amplitude(d: &Described, chosen: &Entry, unit: &str) -> Quantity {
    let bounded = &chosen.bounded;
    if !bounded.free.contains(&X_0) {
        return Quantity::normal(bounded.parameters[X_0], 0.0, unit);
    }
    let problem = d.problem.with(&bounded.free);
    // By the shape alone: between no friction at all and nothing but friction.
    let end = |model: LossModel, side: f64| {
        d.get(model)
            .map(|e| e.bounded.parameters[X_0] + side * 4.0 * d.scale.std_error(&e.bounded, X_0).0)
            .filter(|v| v.is_finite())
    };
    let low = end(LossModel::Viscous, -1.0).filter(|v| *v > 0.0).unwrap_or(0.0);
    let high = end(LossModel::Sliding, 1.0).unwrap_or(f64::INFINITY);
    let value = bounded.parameters[X_0];
    let range = if d.source == DriveSource::Shape && !on_background(chosen) {
        [low.min(value), high.max(value)]
    } else {
        [0.0, f64::INFINITY]
    };
    let mut found =
        Profile { problem: &problem, fit: bounded, scale: d.scale, range }.two_sided(X_0, bends(d));
    let mut unbounded_value = chosen.fit.parameters[X_0];
    if let Some(by) = unbiased(d, chosen, &problem, bounded) {
        found = moved(found, by[X_0]);
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
fn friction_ratio(d: &Described, chosen: &Entry, x_f: &Quantity, x_0: &Quantity) -> Quantity {
    let scaled = x_f.scaled(1.0 / (FRAC_PI_4 * x_0.value), "");
    if x_0.std_error == 0.0 {
        return scaled;
    }
    let present = chosen.fit.free.contains(&X_F);
    let found = (if present { Some(chosen) } else { d.with_term(chosen.model, X_F) }).and_then(|entry| {
        let mut problem = d.problem_of(entry);
        problem.ratio = true;
        let mut start = entry.fit.parameters.clone();
        start[X_F] /= FRAC_PI_4 * start[X_0];
        let fit = minimise(&problem, &start, &entry.fit.free)?;
        let most = if d.source == DriveSource::Shape { 4.0 / PI } else { f64::INFINITY };
        let range = [0.0, most.max(fit.parameters[X_F])];
        let mut e = Profile { problem: &problem, fit: &fit, scale: d.scale, range }.non_negative(X_F, true);
        if present && let Some(by) = unbiased(d, chosen, &problem, &fit) {
            e = moved(e, by[X_F]);
        }
        Some(non_negative(e, present, ""))
    });
    found.unwrap_or(scaled)
}

/// The parameters by the paper's inversion.
fn papers_parameters(
    used: &Curve,
    options: &Options,
    d: &Described,
    chosen: &Entry,
) -> Result<Vec<Parameter>, Error> {
    let b = &d.problem.main;
    let measured: Vec<f64> = (0..b.len()).map(|i| b.amplitude(i)).collect();
    let lorentzian =
        Lorentzian::of(b, &measured).ok_or(Error::NoFit { reason: "no effective Lorentzian was reached" })?;
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
    let mut list = vec![
        Parameter { name: "natural_frequency_hz", quantity: hz },
        Parameter { name: "decay_rate_per_s", quantity: delta.clone() },
        Parameter { name: "q_factor", quantity: Quantity::normal(found.q, q_std, "") },
        Parameter { name: "friction_displacement", quantity: x_f.clone() },
        Parameter { name: "drive_amplitude", quantity: x_0 },
        Parameter { name: "friction_ratio", quantity: limited(found.beta, beta_std, "") },
    ];
    if let Some(calibration) = options.calibration {
        for (name, quantity) in physical(calibration, omega_0, unit, &delta, &x_f) {
            list.push(Parameter { name, quantity });
        }
    }
    Ok(list)
}

fn candidate(d: &Described, e: &Entry, best_bic: f64) -> Candidate {
    let p = &e.bounded.parameters;
    let problem = d.problem_of(e);
    let mut sum = 0.0;
    for (r, weight) in problem.residuals(p).into_iter().zip(&problem.main.weight) {
        if *weight > 0.0 {
            sum += r.map_or(0.0, |r| r.norm_sqr());
        }
    }
    Candidate {
        model: e.model,
        bic: e.bic,
        delta_bic: e.bic - best_bic,
        rms: (sum / problem.main.observations().max(1.0)).sqrt(),
        free_parameters: e.fit.free.len(),
        converged: e.fit.converged,
        at_limit: e.at_limit.map(|t| match t {
            X_F => "friction_displacement",
            DELTA => "decay_rate_per_s",
            _ => "drag_rate",
        }),
        natural_frequency_hz: (d.problem.centre + p[OMEGA]) / TAU,
        decay_rate_per_s: p[DELTA],
        friction_displacement: p[X_F],
        drive_amplitude: p[X_0],
        drag_rate: if loss_terms(e.model).contains(&DRAG) { p[DRAG] } else { 0.0 },
    }
}

fn correlations(chosen: &Entry) -> Vec<(&'static str, &'static str, f64)> {
    let named = [
        (OMEGA, "natural_frequency_hz"),
        (DELTA, "decay_rate_per_s"),
        (X_F, "friction_displacement"),
        (X_0, "drive_amplitude"),
        (DRAG, "drag_rate"),
        (DUFFING, "frequency_shift_by_amplitude"),
    ];
    let mut list = Vec::new();
    for (i, &(a, name_a)) in named.iter().enumerate() {
        for &(b, name_b) in &named[i + 1..] {
            if chosen.fit.free.contains(&a) && chosen.fit.free.contains(&b) {
                list.push((name_a, name_b, chosen.fit.correlation(a, b)));
            }
        }
    }
    list
}

fn instrument(d: &Described, chosen: &Entry) -> Instrument {
    let fit = &chosen.bounded;
    let term = |k: usize, unit: &str| fit.free.contains(&k).then(|| plain(d, fit, k, 1.0, 0.0, unit));
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

fn reference(d: &Described, chosen: &Entry, problem: &Problem, sigma: f64) -> ReferenceFit {
    let fit = &chosen.bounded;
    let own_sigma = sigma / problem.reference_weight.sqrt();
    ReferenceFit {
        natural_frequency_hz: plain(d, fit, R_OMEGA, 1.0 / TAU, d.problem.centre, "Hz"),
        decay_rate_per_s: plain(d, fit, R_DELTA, 1.0, 0.0, "1/s"),
        points: points(problem, &fit.parameters, true, own_sigma),
        sliding_p_value: reference_slides(problem, fit),
    }
}

/// p value of sliding friction in the reference alone, its drive free.
fn reference_slides(problem: &Problem, fit: &Fit) -> f64 {
    let Some(block) = problem.reference.clone() else { return 1.0 };
    let q = &fit.parameters;
    let mut p = vec![0.0; COUNT];
    (p[OMEGA], p[DELTA], p[X_0], p[PHASE]) = (q[R_OMEGA], q[R_DELTA], q[X_0], q[R_PHASE]);
    (p[BG_RE], p[BG_IM], p[DELAY]) = (q[R_BG_RE], q[R_BG_IM], q[DELAY]);
    let mut free = vec![OMEGA, DELTA, X_0];
    if block.complex {
        free.push(PHASE);
    }
    if fit.free.contains(&R_BG_RE) {
        free.extend([BG_RE, BG_IM]);
    }
    let mut own =
        Problem { main: block, reference: None, prior: None, used: free.clone(), ..problem.clone() };
    let scale = crate::inference::profile::Scale {
        observations: own.main.observations(),
        least_variance: None,
        widening: 1.0,
    };
    let Some(without) = minimise(&own, &p, &free) else { return 1.0 };
    free.push(X_F);
    free.sort_unstable();
    own.used = free.clone();
    let mut start = without.parameters.clone();
    start[X_F] = 0.05 * start[X_0];
    match super::search::best(&own, &[start, without.parameters.clone()], &free) {
        Some(with) if with.parameters[X_F] > 0.0 => scale.test(without.rss, with.rss, &with),
        _ => 1.0,
    }
}

fn diagnostics(curve: &Curve, used: &Curve, d: &Described, points: &[CurvePoint], sigma: f64) -> Diagnostics {
    let b = &d.problem.main;
    let span = b.omega[b.len() - 1] - b.omega[0];
    let near = |w: &&f64| (**w - d.peak.omega).abs() <= d.peak.half_width;
    Diagnostics {
        points: d.all.as_ref().map_or(b.len(), Block::len) - d.left_out,
        outside_band: curve.len() - used.len(),
        left_out: d.left_out,
        noise_rms: d.neighbour_noise,
        residual_rms: sigma,
        residual_excess: d.scale.widening,
        residual_autocorrelation: d.autocorrelation,
        signal_to_noise_db: 20.0 * (b.highest() / sigma.max(f64::MIN_POSITIVE)).log10(),
        line_widths: span / (2.0 * d.peak.half_width),
        points_in_line: b.omega.iter().filter(near).count(),
        points_with_stops: points.iter().filter(|p| p.stops > 0).count(),
    }
}
