//! From a curve to all loss models, fitted: starts, instrument terms, noise.

use super::block::Block;
use super::crosstalk::{self, Allowed};
use super::look::{self, Line, Pedestal};
use super::problem::{
    BG_IM, BG_RE, COUNT, DELAY, DELTA, DRAG, DUFFING, OMEGA, PHASE, Problem, R_BG_IM, R_BG_RE, R_DELTA,
    R_OMEGA, R_PHASE, X_0, X_F,
};
use super::start::{self, Start};
use super::{DriveSource, Method, Options};
use crate::Error;
use crate::estimate::least_squares::{Fit, LeastSquares, Normal, minimise};
use crate::estimate::profile::Scale;
use crate::ringdown::LossModel;
use crate::steady::Phasor;

/// One loss model's best fit.
#[derive(Debug, Clone)]
pub(crate) struct Entry {
    pub(crate) model: LossModel,
    /// Best fit, limits lifted.
    pub(crate) fit: Fit,
    /// Best fit with no loss term below zero.
    pub(crate) bounded: Fit,
    pub(crate) at_limit: Option<usize>,
    pub(crate) bic: f64,
}

impl Entry {
    fn rank(&self) -> f64 {
        self.bic + self.model.handicap()
    }
}

/// Everything the fits brought.
#[derive(Debug)]
pub(crate) struct Described {
    pub(crate) problem: Problem,
    pub(crate) line: Line,
    pub(crate) entries: Vec<Entry>,
    pub(crate) scale: Scale,
    pub(crate) source: DriveSource,
    pub(crate) mirrored: bool,
    /// The phases fit no resonance; only amplitudes were used.
    pub(crate) phases_ignored: bool,
    /// Every point, where the fit used means of neighbours.
    pub(crate) all: Option<Block>,
    pub(crate) left_out: usize,
    /// Noise of one point as differences of the residuals between neighbours give it.
    pub(crate) neighbour_noise: f64,
    pub(crate) autocorrelation: f64,
    /// Minima as good as the best within its errors, where there are several: amplitudes do not
    /// tell on which side of the line a background lies.
    pub(crate) minima: Vec<Fit>,
}

/// Terms beside the loss that are free.
pub(crate) fn loss_terms(model: LossModel) -> Vec<usize> {
    [(model.has_sliding(), X_F), (model.has_viscous(), DELTA), (model.has_drag(), DRAG)]
        .into_iter()
        .filter_map(|(has, k)| has.then_some(k))
        .collect()
}

/// What is free beside loss terms.
struct Others {
    list: Vec<usize>,
}

impl Others {
    fn with(&self, more: &[usize]) -> Vec<usize> {
        let mut all: Vec<usize> = self.list.iter().chain(more).copied().collect();
        all.sort_unstable();
        all.dedup();
        all
    }
}

/// A term is taken up unasked only when it lowers the BIC by this much.
const TAKEN_UP: f64 = 14.0;
/// Drag may do worse than another term by so much and is taken up all the same.
const PREFERRED: f64 = 6.0;

/// Fits everything; phases that fit no resonance while the amplitudes do are left aside.
pub(crate) fn describe(main: Block, reference: Option<Block>, options: &Options) -> Result<Described, Error> {
    let wanted = options.terms;
    if wanted.delay == Some(true) && main.complex {
        // It may be many turns across the curve: no first value but its own leads there.
        let allowed = Allowed { background: wanted.background != Some(false), delay: true };
        if let Some(behind) = best_behind(&main, reference.as_ref(), options, allowed) {
            let plain = describe_as(main, reference, options, Way::AsGiven);
            return Ok(plain.ok().filter(|d| left(d) <= left(&behind)).unwrap_or(behind));
        }
    }
    describe_as(main, reference, options, Way::AsGiven)
}

/// How the data are taken.
enum Way {
    AsGiven,
    /// Without the phases there were.
    Amplitudes,
    /// From background and delay known about.
    Behind(Box<Pedestal>),
}

/// A residual above this part of the height makes phases suspect.
const UNLIKELY: f64 = 0.08;

fn describe_as(
    main: Block,
    reference: Option<Block>,
    options: &Options,
    way: Way,
) -> Result<Described, Error> {
    let mut main = main;
    let no = |reason| Error::NoResonance { reason };
    let mut line = look::line(&main).ok_or(no("every amplitude is zero"))?;
    if main.len() < 4 {
        return Err(Error::TooFewPoints { points: main.len(), parameters: 3 });
    }
    let noise = look::noise(&main);
    if let Some(reason) = look::no_line(&main, 0.0) {
        return Err(no(reason));
    }
    let wanted = options.terms;
    let first_time = matches!(way, Way::AsGiven);
    let behind = matches!(way, Way::Behind(_));
    let allowed =
        Allowed { background: wanted.background != Some(false), delay: wanted.delay != Some(false) };
    let mut pedestal = match way {
        Way::Behind(pedestal) => Some(*pedestal),
        _ => look::pedestal(&main, &line).filter(|_| allowed.background),
    };
    if let Some(p) = &pedestal {
        line = p.line;
    }
    let raised = |p: &Pedestal| p.height != Phasor::default();
    let background = wanted.background == Some(true) || pedestal.as_ref().is_some_and(raised);
    let seen = pedestal.as_ref().map_or(&main, |p| &p.without);
    let (from_phases, mirrored) = match start::linear(seen, &line, true) {
        Some((s, mirrored)) => (Some(s), mirrored),
        None => (None, false),
    };
    let mut reference = reference;
    if mirrored {
        for z in
            main.data.iter_mut().chain(reference.iter_mut().filter(|r| r.complex).flat_map(|r| &mut r.data))
        {
            *z = z.conj();
        }
        if let Some(p) = &mut pedestal {
            p.height = p.height.conj();
            p.delay = -p.delay;
        }
    }
    // A dense curve is fitted by the means of neighbours much closer than the line is wide.
    let spacing = (main.omega[main.len() - 1] - main.omega[0]) / main.len() as f64;
    let fine = (0.03 * line.half_width / spacing.max(f64::MIN_POSITIVE)) as usize;
    let group = (main.len() / ENOUGH).min(fine).max(1);
    let all = (group > 1).then(|| {
        let few = main.grouped(group);
        line.top /= group;
        std::mem::replace(&mut main, few)
    });
    let source = match (options.drive_amplitude, &reference) {
        (Some(_), _) => DriveSource::Known,
        (None, Some(_)) => DriveSource::Reference,
        (None, None) => DriveSource::Shape,
    };
    let known = options.drive_amplitude.map(|d| d.value);
    let fixed = options.drive_amplitude.is_some_and(|d| d.std_error == 0.0);
    let mut problem = Problem {
        centre: line.omega,
        method: options.method,
        prior: None,
        ratio: false,
        used: Vec::new(),
        reference: None,
        reference_weight: 1.0,
        main,
    };
    let mut others = Others { list: vec![OMEGA] };
    if !fixed {
        others.list.push(X_0);
    }
    let complex = problem.main.complex;
    if complex && wanted.phase_offset != Some(false) {
        others.list.push(PHASE);
    }
    if background {
        others.list.extend([BG_RE, BG_IM]);
    }
    let delay = pedestal.as_ref().map_or(0.0, |p| p.delay);
    if (wanted.delay == Some(true) || delay != 0.0) && complex {
        others.list.push(DELAY);
    }
    if wanted.duffing == Some(true) {
        others.list.push(DUFFING);
    }

    // The reference alone first: it must be a line by itself, and its noise is its own.
    let mut reference_start = None;
    if let Some(block) = reference {
        let (block, fit) = reference_alone(block, &problem, background)?;
        others.list.extend([R_OMEGA, R_DELTA]);
        if block.complex && wanted.phase_offset != Some(false) {
            others.list.push(R_PHASE);
        }
        if background {
            others.list.extend([R_BG_RE, R_BG_IM]);
        }
        reference_start = Some(fit);
        problem.reference = Some(block);
    }

    let least = others.list.len() + 2;
    if (problem.observations() as usize) <= least {
        return Err(Error::TooFewPoints { points: problem.main.len(), parameters: least });
    }
    let known_level = known.or(reference_start.as_ref().map(|f| f[X_0]));
    let mut starts = starts(&problem.main, &line, from_phases, known_level, fixed);
    for s in &mut starts {
        if let Some(p) = &pedestal {
            (s[BG_RE], s[BG_IM], s[DELAY]) = (p.height.re, p.height.im, delay);
        }
        if let Some(r) = &reference_start {
            for k in [R_OMEGA, R_DELTA, R_PHASE, R_BG_RE, R_BG_IM] {
                s[k] = r[k];
            }
        }
        if others.list.iter().all(|&k| k != PHASE) {
            s[PHASE] = 0.0;
        }
    }
    // One fit without the reference, to learn the noise that weighs it.
    let full = others.with(&[X_F, DELTA]);
    problem.used = full.iter().copied().filter(|&k| k < R_OMEGA).collect();
    let block = problem.reference.take();
    let own: Vec<usize> = problem.used.clone();
    if let Some(few) = thinned(&problem)
        && let Some(fit) = best(&few, &starts, &own)
    {
        starts = vec![fit.parameters];
    }
    let first = best(&problem, &starts, &own).ok_or(Error::NoFit {
        reason: "no resonance curve with viscous and sliding loss was reached from any start",
    })?;
    let variance =
        |fit: &Fit, problem: &Problem| fit.rss / (problem.observations() - fit.free.len() as f64).max(1.0);
    let sigma2 = variance(&first, &problem).max(f64::MIN_POSITIVE);
    if let Some(reason) = look::no_line(&problem.main, noise.min(sigma2.sqrt())) {
        return Err(no(reason));
    }
    if complex && first_time && sigma2.sqrt() > UNLIKELY * line.height {
        let other = otherwise(&problem.main, block.as_ref(), options, allowed, sigma2);
        if let Some(mut described) = other {
            described.mirrored ^= mirrored && !described.phases_ignored;
            described.all = all.map(|a| if described.phases_ignored { amplitudes_only(&a) } else { a });
            return Ok(described);
        }
    }
    if let Some(r) = &reference_start {
        problem.reference_weight = (sigma2 / r[COUNT]).clamp(1e-12, 1e12);
    }
    problem.reference = block;
    if let Some(drive) = options.drive_amplitude.filter(|d| d.std_error > 0.0) {
        problem.prior = Some([drive.value, sigma2 / (drive.std_error * drive.std_error)]);
    }
    let mut here = first.parameters.clone();
    if let Some(r) = &reference_start {
        for k in [R_OMEGA, R_DELTA, R_PHASE, R_BG_RE, R_BG_IM] {
            here[k] = r[k];
        }
    }
    starts.insert(0, here);

    // Amplitudes carry Rice's noise; its size comes from the residuals.
    let mut fit = best(&problem, &starts, &full).unwrap_or(first);
    // Without the reference the shape alone may have ended elsewhere, its residuals no measure of
    // the noise: beside the reference they are.
    if let Some(r) = &reference_start {
        for _ in 0..3 {
            let alone = Problem { reference: None, ..problem.clone() };
            let free = (alone.observations() - own.len() as f64).max(1.0);
            let Some(left) = rss(&alone, &fit.parameters, f64::INFINITY) else { break };
            let weight = (left / free / r[COUNT]).clamp(1e-12, 1e12);
            if (weight / problem.reference_weight).ln().abs() < 0.2 {
                break;
            }
            problem.reference_weight = weight;
            let Some(f) = best(&problem, &[fit.parameters.clone()], &full) else { break };
            fit = f;
        }
    }
    if !complex {
        for _ in 0..2 {
            let v = variance(&fit, &problem);
            settle_rice(&mut problem, &fit.parameters, v);
            if let Some(f) = minimise(&problem, &fit.parameters, &full) {
                fit = f;
            }
        }
    }
    let left_out = leave_out(&mut problem, &fit.parameters, noise);
    if left_out > 0
        && let Some(f) = best(&problem, &[fit.parameters.clone()], &full)
    {
        fit = f;
    }

    let mut free = full;
    let before = free.len();
    if behind {
        let mut unasked: Vec<&[usize]> = Vec::new();
        if wanted.delay.is_none() {
            unasked.push(&[DELAY]);
        }
        if wanted.background.is_none() {
            unasked.push(&[BG_RE, BG_IM, R_BG_RE, R_BG_IM]);
        }
        for terms in unasked {
            drop_unneeded(&mut problem, &mut fit, &mut free, terms);
        }
    }

    // Instrument terms the data cannot do without.
    let drag_is_out = options.model.is_some_and(|m| !m.has_drag());
    let mut minima: Vec<Fit> = Vec::new();
    let candidates: [(&[usize], Option<bool>, bool); 3] = [
        (&[BG_RE, BG_IM], wanted.background, true),
        (&[DELAY], wanted.delay, complex),
        (&[DUFFING], wanted.duffing, true),
    ];
    for _ in 0..candidates.len() {
        let mut found: Option<(f64, Vec<usize>, Fit)> = None;
        for (terms, asked, possible) in candidates {
            if asked.is_some() || !possible || free.contains(&terms[0]) {
                continue;
            }
            let mut more = free.clone();
            more.extend(terms);
            if problem.reference.is_some() && terms[0] == BG_RE {
                more.extend([R_BG_RE, R_BG_IM]);
            }
            more.sort_unstable();
            if (problem.observations() as usize) < more.len() + 4 {
                continue;
            }
            let mut trial = problem.clone();
            trial.used = more.iter().copied().filter(|&k| k < R_OMEGA).collect();
            // A step of the quadratic model first: most curves need no more to say no.
            if !worth_trying(&trial, &fit, &more, &plain_scale(&trial)) {
                continue;
            }
            let all_minima = if terms[0] == BG_RE && !complex {
                settle(&trial, &fit, &line, &more)
            } else {
                minimise(&trial, &fit.parameters, &more).into_iter().collect()
            };
            let Some(f) = all_minima.first().cloned() else { continue };
            // A term that is missing makes residuals hang together: what counts is how they do
            // with it.
            let (_, _, widening) = hang_together(&trial, &f);
            let scale = Scale { widening, ..plain_scale(&trial) };
            let gain = scale.bic(fit.rss, free.len()) - scale.bic(f.rss, more.len());
            if gain > TAKEN_UP && found.as_ref().is_none_or(|(g, ..)| gain > *g) {
                found = Some((gain, more, f));
                if terms[0] == BG_RE && !complex {
                    minima = all_minima;
                }
            }
        }
        let Some((gain, mut more, mut f)) = found else { break };
        // Before the instrument or the spring is blamed: drag, a loss of its own.
        if !drag_is_out
            && !free.contains(&DRAG)
            && let Some((own, list, dragged)) = with_drag(&problem, &fit, &free)
            && own > TAKEN_UP.max(gain - PREFERRED)
        {
            (more, f) = (list, dragged);
        }
        problem.used = more.iter().copied().filter(|&k| k < R_OMEGA).collect();
        (free, fit) = (more, f);
        if !complex {
            let v = variance(&fit, &problem);
            settle_rice(&mut problem, &fit.parameters, v);
        }
    }
    if complex && first_time && free.len() > before && variance(&fit, &problem) > 2.0 * noise * noise {
        // Terms were taken up one by one and leave more than noise: together they may not.
        let other = best_behind(&problem.main, problem.reference.as_ref(), options, allowed);
        if let Some(mut other) = other.filter(|d| left(d) < 0.8 * variance(&fit, &problem)) {
            other.mirrored ^= mirrored;
            other.all = all;
            other.left_out += left_out;
            return Ok(other);
        }
    }
    let hidden = !complex && wanted.background == Some(true) && minima.is_empty();
    if hidden {
        minima = settle(&problem, &fit, &line, &free);
        fit = minima.first().cloned().unwrap_or(fit);
    }
    if free.contains(&DUFFING) || free.contains(&DRAG) {
        // Other minima were those without the terms taken up since.
        minima = minima.iter().filter_map(|m| minimise(&problem, &m.parameters, &free)).collect();
    }
    let others: Vec<usize> = free.iter().copied().filter(|k| ![X_F, DELTA, DRAG].contains(k)).collect();
    if let Some([value, _]) = problem.prior {
        let drive = options.drive_amplitude.map_or(1.0, |d| d.std_error);
        problem.prior = Some([value, variance(&fit, &problem) / (drive * drive)]);
    }

    let (mut autocorrelation, mut neighbour_noise, widening) = hang_together(&problem, &fit);
    let mut scale = Scale { widening, ..plain_scale(&problem) };
    starts.insert(0, fit.parameters.clone());
    starts.splice(1..1, minima.iter().map(|m| m.parameters.clone()));
    let tries = if minima.is_empty() { TRIES } else { TRIES + 2 * minima.len() };
    let fits = compare(&problem, &starts, &others, &scale, options.model, tries);
    // What one loss term leaves over is no noise: it is judged beside all of them.
    let richest = fits.iter().find(|(m, f)| *m == LossModel::ViscousSlidingDrag && f.converged);
    if let Some((_, f)) = richest.filter(|_| widening > 1.0 && !drag_is_out) {
        let mut own = problem.clone();
        own.used = f.free.iter().copied().filter(|&k| k < R_OMEGA).collect();
        (autocorrelation, neighbour_noise, scale.widening) = hang_together(&own, f);
    }
    let entries = ranked(&fits, &scale);
    if entries.is_empty() {
        return Err(Error::NoFit { reason: "no loss model could be fitted to the curve" });
    }
    if let Some(seen) = oscillator_seen(&problem, &fit.parameters).and_then(|b| look::line(&b)) {
        line = seen;
    }
    let least = minima.iter().map(|m| m.rss).fold(f64::INFINITY, f64::min);
    let unit = entries.first().map_or(0.0, |e| scale.variance_of(&e.bounded) * scale.widening);
    minima.retain(|m| m.rss - least < 4.0 * unit);
    Ok(Described {
        problem,
        line,
        entries,
        scale,
        source,
        mirrored,
        phases_ignored: false,
        all,
        left_out,
        neighbour_noise,
        autocorrelation,
        minima,
    })
}

/// The best description from all first values of background and delay.
fn best_behind(
    main: &Block,
    reference: Option<&Block>,
    options: &Options,
    allowed: Allowed,
) -> Option<Described> {
    let noise = look::noise(main);
    let mut best: Option<Described> = None;
    for pedestal in crosstalk::find(main, allowed) {
        let way = Way::Behind(Box::new(pedestal));
        let Ok(found) = describe_as(main.clone(), reference.cloned(), options, way) else { continue };
        let enough = left(&found) < 2.0 * noise * noise;
        if best.as_ref().is_none_or(|b| left(&found) < left(b)) {
            best = Some(found);
        }
        if enough {
            break;
        }
    }
    best
}

/// Variance the preferred model leaves.
fn left(d: &Described) -> f64 {
    d.preferred().map_or(f64::INFINITY, |e| d.scale.variance_of(&e.bounded))
}

/// What explains data that no plain resonance does: background and delay, else the amplitudes
/// alone, unless the phases are those of real and imaginary parts.
fn otherwise(
    main: &Block,
    reference: Option<&Block>,
    options: &Options,
    allowed: Allowed,
    variance: f64,
) -> Option<Described> {
    let behind = best_behind(main, reference, options, allowed);
    let with_phases = behind.as_ref().map_or(f64::INFINITY, left);
    let amplitudes = if main.separate_phase {
        let reference = reference.map(amplitudes_only);
        describe_as(amplitudes_only(main), reference, options, Way::Amplitudes).ok()
    } else {
        None
    };
    // Phases that were ever right double the data: they need not do as well to the last digit.
    let without = amplitudes.as_ref().map_or(f64::INFINITY, left);
    if with_phases < (2.0 * without).min(0.5 * variance) {
        return behind;
    }
    let mut described = amplitudes.filter(|_| without < 0.06 * variance)?;
    described.phases_ignored = true;
    Some(described)
}

/// So many points tell a line as well as more do.
const ENOUGH: usize = 1000;
/// More points than these are thinned while the fit is far from its end.
const MANY: usize = 600;

fn thinned(problem: &Problem) -> Option<Problem> {
    let n = problem.main.len();
    if n <= MANY {
        return None;
    }
    let mut few = problem.clone();
    let stride = n.div_ceil(MANY);
    for (i, w) in few.main.weight.iter_mut().enumerate() {
        if i % stride != 0 {
            *w = 0.0;
        }
    }
    Some(few)
}

/// The same points without their phases.
fn amplitudes_only(b: &Block) -> Block {
    let data = (0..b.len()).map(|i| Phasor::new(b.amplitude(i), 0.0)).collect();
    Block { data, complex: false, weight: b.precision.clone(), ..b.clone() }
}

fn plain_scale(problem: &Problem) -> Scale {
    Scale { observations: problem.observations(), least_variance: None, widening: 1.0 }
}

/// Takes out terms the fit does as well without.
fn drop_unneeded(problem: &mut Problem, fit: &mut Fit, free: &mut Vec<usize>, terms: &[usize]) {
    let fewer: Vec<usize> = free.iter().copied().filter(|k| !terms.contains(k)).collect();
    let mut trial = problem.clone();
    trial.used = fewer.iter().copied().filter(|&k| k < R_OMEGA).collect();
    let mut start = fit.parameters.clone();
    for &k in terms {
        start[k] = 0.0;
    }
    let (_, _, widening) = hang_together(problem, fit);
    let scale = Scale { widening, ..plain_scale(problem) };
    if let Some(f) = minimise(&trial, &start, &fewer)
        && scale.bic(f.rss, fewer.len()) - scale.bic(fit.rss, free.len()) < TAKEN_UP
    {
        (*problem, *fit, *free) = (trial, f, fewer);
    }
}

/// The fit with drag beside what is free, and what that brings.
fn with_drag(problem: &Problem, fit: &Fit, free: &[usize]) -> Option<(f64, Vec<usize>, Fit)> {
    let mut more = free.to_vec();
    more.push(DRAG);
    more.sort_unstable();
    if (problem.observations() as usize) < more.len() + 4 {
        return None;
    }
    let mut trial = problem.clone();
    trial.used = more.iter().copied().filter(|&k| k < R_OMEGA).collect();
    let f = minimise(&trial, &fit.parameters, &more).filter(|f| f.parameters[DRAG] > 0.0)?;
    let (_, _, widening) = hang_together(&trial, &f);
    let scale = Scale { widening, ..plain_scale(&trial) };
    let gain = scale.bic(fit.rss, fit.free.len()) - scale.bic(f.rss, more.len());
    Some((gain, more, f))
}

/// Every minimum with a background under amplitudes alone, the best first: it may lie on either
/// side of the line, and much of it looks like friction.
fn settle(problem: &Problem, fit: &Fit, line: &Line, free: &[usize]) -> Vec<Fit> {
    let mut minima: Vec<Fit> = Vec::new();
    let mut from = vec![fit.parameters.clone()];
    let fixed: Vec<usize> = free.iter().copied().filter(|k| ![BG_RE, BG_IM].contains(k)).collect();
    let known = (!free.contains(&X_0)).then(|| fit.parameters[X_0]);
    let mut oscillators: Vec<Vec<f64>> =
        start::grid(line, 0.0, known).iter().map(|s| start::of(s, known)).collect();
    oscillators.push(fit.parameters.clone());
    for p in &mut oscillators {
        p[R_OMEGA..].copy_from_slice(&fit.parameters[R_OMEGA..]);
    }
    for size in [0.04, 0.2, 0.6] {
        for eighth in 0..8 {
            let b = Phasor::from_polar(size * line.height, std::f64::consts::FRAC_PI_4 * f64::from(eighth));
            for p in &mut oscillators {
                (p[BG_RE], p[BG_IM]) = (b.re, b.im);
            }
            from.extend(best_of(problem, &oscillators, &fixed, 2).map(|f| f.parameters));
        }
    }
    for p in from {
        let Some(f) = minimise(problem, &p, free) else { continue };
        let apart = |m: &Fit| {
            [X_F, BG_RE, BG_IM].into_iter().any(|k| {
                let error = (m.unit_std(k).powi(2) * m.rss / problem.observations()).sqrt();
                (m.parameters[k] - f.parameters[k]).abs() > 0.1 * error.max(1e-9 * line.height)
            })
        };
        let sound = f.parameters[X_F] >= 0.0 && f.parameters[DELTA] >= 0.0;
        if (sound || minima.is_empty()) && minima.iter().all(apart) {
            minima.push(f);
        }
    }
    let near = minima.first().cloned();
    minima.sort_by(|a, b| a.rss.total_cmp(&b.rss));
    // Where the best leaves more than noise, a far one may only mend what the law lacks.
    if minima.first().is_some_and(|m| hang_together(problem, m).2 > 1.0) {
        return near.into_iter().collect();
    }
    minima.truncate(8);
    minima
}

/// Whether the sums at the present fit promise enough for the new terms.
fn worth_trying(trial: &Problem, fit: &Fit, free: &[usize], scale: &Scale) -> bool {
    let mut sums = Normal::zeros(COUNT);
    if !trial.normal(&fit.parameters, &mut sums) {
        return false;
    }
    match crate::estimate::least_squares::promised_gain(&sums, free) {
        // The quadratic model underrates what several steps bring: a margin of three.
        Some(gain) => {
            let promised = (fit.rss - 3.0 * gain).max(0.05 * fit.rss);
            scale.bic(fit.rss, fit.free.len()) - scale.bic(promised, free.len()) > 0.0
        }
        None => false,
    }
}

/// All first values for the minimiser, centre at the line.
pub(crate) fn starts(
    b: &Block,
    line: &Line,
    from_phases: Option<Start>,
    known: Option<f64>,
    fixed: bool,
) -> Vec<Vec<f64>> {
    let phase = from_phases.map_or_else(|| start::phase_at_peak(b, line), |s| s.phase);
    let first = from_phases.map(|s| start::of(&s, known));
    let mut list: Vec<Start> = start::grid(line, phase, known);
    if known.is_some() && !fixed {
        list.extend(start::grid(line, phase, None));
    }
    first.into_iter().chain(list.iter().map(|s| start::of(s, None))).collect()
}

fn rss(problem: &Problem, p: &[f64], limit: f64) -> Option<f64> {
    let mut sums = Normal::zeros(COUNT);
    (problem.normal_within(p, &mut sums, limit) && sums.rss.is_finite()).then_some(sums.rss)
}

/// The best fit from the best of several starts.
pub(crate) fn best(problem: &Problem, starts: &[Vec<f64>], free: &[usize]) -> Option<Fit> {
    best_of(problem, starts, free, TRIES)
}

/// So many starts are followed to their end; with more, every one of them.
const TRIES: usize = 3;

fn best_of(problem: &Problem, starts: &[Vec<f64>], free: &[usize], tries: usize) -> Option<Fit> {
    // A start far worse than the best is not even summed to its end.
    let mut least = f64::INFINITY;
    let mut ranked: Vec<(f64, &Vec<f64>)> = starts
        .iter()
        .filter_map(|s| {
            let r = rss(problem, s, 30.0 * least)?;
            least = least.min(r);
            Some((r, s))
        })
        .collect();
    ranked.sort_by(|a, b| a.0.total_cmp(&b.0));
    let mut found: Option<Fit> = None;
    let mut again = 0;
    for (_, s) in ranked.into_iter().take(tries) {
        let Some(fit) = minimise(problem, s, free) else { continue };
        // The same minimum twice is the minimum.
        let same =
            found.as_ref().is_some_and(|f| (f.rss - fit.rss).abs() < 1e-3 * f.rss / problem.observations());
        if found.as_ref().is_none_or(|f| fit.rss < f.rss) {
            found = Some(fit);
        }
        if same {
            again += 1;
        }
        if again > 0 && tries == TRIES {
            break;
        }
    }
    found
}

/// The reference by itself, no friction in it; parameters in the places of the joint fit,
/// its drive, and behind them (at [`COUNT`]) the variance of its points.
fn reference_alone(block: Block, problem: &Problem, background: bool) -> Result<(Block, Vec<f64>), Error> {
    let no = |reason| Error::NoResonance { reason };
    let line = look::line(&block).ok_or(no("the reference has no amplitude above zero"))?;
    let mut own =
        Problem { main: block, centre: line.omega, reference: None, prior: None, ..problem.clone() };
    let mut free = vec![OMEGA, DELTA, X_0];
    if own.main.complex {
        free.push(PHASE);
    }
    if background {
        free.extend([BG_RE, BG_IM]);
    }
    own.used = free.clone();
    let linear = start::linear(&own.main, &line, false).map(|(s, _)| s);
    let mut list = starts(&own.main, &line, linear, None, false);
    for p in &mut list {
        p[X_F] = 0.0;
    }
    let enough = own.observations() as usize > free.len();
    if !enough {
        return Err(Error::TooFewPoints { points: own.main.len(), parameters: free.len() });
    }
    let mut fit = best(&own, &list, &free).ok_or(no("no line was reached in the reference"))?;
    let dof = own.observations() - free.len() as f64;
    if !own.main.complex {
        for _ in 0..2 {
            settle_rice(&mut own, &fit.parameters, fit.rss / dof);
            if let Some(f) = minimise(&own, &fit.parameters, &free) {
                fit = f;
            }
        }
    }
    let p = &fit.parameters;
    let mut joint = vec![0.0; COUNT + 1];
    joint[R_OMEGA] = p[OMEGA] + line.omega - problem.centre;
    (joint[R_DELTA], joint[X_0]) = (p[DELTA], p[X_0]);
    (joint[R_PHASE], joint[R_BG_RE], joint[R_BG_IM]) = (p[PHASE], p[BG_RE], p[BG_IM]);
    joint[COUNT] = (fit.rss / dof).max(f64::MIN_POSITIVE);
    Ok((own.main, joint))
}

/// Sets Rice's noise and the weights that go with it.
fn settle_rice(problem: &mut Problem, p: &[f64], variance: f64) {
    let n = problem.main.len();
    // Noise above the lowest amplitudes read is none of Rice's.
    let mut low: Vec<f64> = (0..n).map(|i| problem.main.data[i].re).collect();
    low.sort_by(f64::total_cmp);
    problem.main.rice = variance.min(low[n / 10].powi(2));
    for (i, modelled) in problem.everywhere(p, false).into_iter().enumerate() {
        if problem.main.weight[i] > 0.0
            && let Some(m) = modelled
        {
            problem.main.weight[i] = problem.main.rice_weight(m.value.norm(), i);
        }
    }
}

/// Takes single points far off out of the sums; how many.
fn leave_out(problem: &mut Problem, p: &[f64], noise: f64) -> usize {
    const FAR: f64 = 7.0;
    let n = problem.main.len();
    if n < 20 {
        return 0;
    }
    let sizes: Vec<f64> = problem
        .residuals(p)
        .into_iter()
        .zip(&problem.main.precision)
        .map(|(r, precision)| r.map_or(0.0, |r| r.norm() * precision.sqrt()))
        .collect();
    let mut sorted = sizes.clone();
    sorted.sort_by(f64::total_cmp);
    // Median of |r|: 0.6745 sigma for one, 1.177 sigma for two quadratures.
    let sigma = sorted[n / 2] / if problem.main.complex { 1.177 } else { 0.6745 };
    let limit = FAR * sigma.max(noise);
    let far: Vec<usize> = (0..n)
        .filter(|&i| sizes[i] > limit)
        .filter(|&i| {
            let near = |j: usize| sizes.get(j).is_some_and(|s| *s > 0.5 * limit);
            !(near(i + 1) || (i > 0 && near(i - 1)))
        })
        .collect();
    if far.len() * 20 > n {
        return 0;
    }
    for &i in &far {
        problem.main.weight[i] = 0.0;
    }
    far.len()
}

/// First autocorrelation of the residuals, the noise between neighbours, and the factor on
/// variances that follows.
fn hang_together(problem: &Problem, fit: &Fit) -> (f64, f64, f64) {
    let b = &problem.main;
    let r: Vec<Phasor> = problem
        .everywhere(&fit.parameters, false)
        .into_iter()
        .enumerate()
        .filter(|&(i, _)| b.weight[i] > 0.0)
        .filter_map(|(i, m)| {
            let m = m?;
            let r = b.less(i, m.value) * b.precision[i].sqrt();
            // Along and across the fitted phase, which turns through the line.
            Some(if b.complex && m.value.norm() > 0.0 { r * m.value.conj() / m.value.norm() } else { r })
        })
        .collect();
    let square: f64 = r.iter().map(Phasor::norm_sqr).sum();
    if r.len() < 5 || !(square > 0.0) {
        return (0.0, square.max(0.0).sqrt(), 1.0);
    }
    let product: f64 = r.windows(2).map(|w| w[0].re * w[1].re + w[0].im * w[1].im).sum();
    let difference: f64 = r.windows(2).map(|w| (w[1] - w[0]).norm_sqr()).sum();
    let per = if b.complex { 2.0 } else { 1.0 };
    let count = per * (r.len() - 1) as f64;
    let rho = product / square;
    let noise = (0.5 * difference / count).sqrt();
    // Fitting takes correlation away: about the number of parameters over that of points.
    let mended = (rho + fit.free.len() as f64 / (per * r.len() as f64) * 0.5).min(0.95);
    let sure = rho * count.sqrt() > 2.8;
    let widening = if sure { (1.0 + mended) / (1.0 - mended) } else { 1.0 };
    (rho, noise, widening)
}

/// Fits every loss model, each from its relatives.
fn compare(
    problem: &Problem,
    starts: &[Vec<f64>],
    others: &[usize],
    scale: &Scale,
    asked: Option<LossModel>,
    tries: usize,
) -> Vec<(LossModel, Fit)> {
    // The richer model of two comes first: its solution starts the smaller ones.
    let order = [
        LossModel::ViscousSliding,
        LossModel::Viscous,
        LossModel::Sliding,
        LossModel::ViscousDrag,
        LossModel::SlidingDrag,
        LossModel::ViscousSlidingDrag,
    ];
    let mut fits: Vec<(LossModel, Fit)> = Vec::new();
    let mut surely_viscous = false;
    for model in order {
        let terms = loss_terms(model);
        if surely_viscous && !model.has_viscous() && asked != Some(model) {
            continue;
        }
        let mut free: Vec<usize> = others.iter().chain(&terms).copied().collect();
        free.sort_unstable();
        if (problem.observations() as usize) <= free.len() {
            continue;
        }
        let mut from: Vec<Vec<f64>> =
            fits.iter().map(|(_, f)| f.parameters.clone()).chain(starts.iter().cloned()).collect();
        for p in &mut from {
            for k in [X_F, DELTA, DRAG] {
                if !terms.contains(&k) {
                    p[k] = 0.0;
                }
            }
            // Sliding alone has no height at resonance: the drive must fall short of it.
            if model == LossModel::Sliding || model == LossModel::SlidingDrag {
                p[X_F] = p[X_F].max(0.7 * p[X_0]);
            }
        }
        from.dedup();
        let mut own = problem.clone();
        own.used = free.iter().copied().filter(|&k| k < R_OMEGA).collect();
        if let Some(fit) = best_of(&own, &from, &free, tries) {
            if model == LossModel::ViscousSliding {
                // So far from zero no data call for a model without it.
                surely_viscous = fit.parameters[DELTA] > 10.0 * scale.std_error(&fit, DELTA).0;
            }
            fits.push((model, fit));
        }
    }
    fits
}

/// The models with their evidence, none with a loss below zero.
fn ranked(fits: &[(LossModel, Fit)], scale: &Scale) -> Vec<Entry> {
    let physical = |m: LossModel, f: &Fit| loss_terms(m).iter().all(|&t| f.parameters[t] >= 0.0);
    fits.iter()
        .map(|(model, fit)| {
            let at_limit = loss_terms(*model).into_iter().find(|&t| fit.parameters[t] < 0.0);
            let bounded = if at_limit.is_none() {
                fit.clone()
            } else {
                fits.iter()
                    .filter(|(m, f)| {
                        physical(*m, f) && loss_terms(*m).iter().all(|t| loss_terms(*model).contains(t))
                    })
                    .min_by(|a, b| a.1.rss.total_cmp(&b.1.rss))
                    .map_or_else(|| fit.clone(), |(_, f)| f.clone())
            };
            let bic = scale.bic(bounded.rss, fit.free.len());
            Entry { model: *model, fit: fit.clone(), bounded, at_limit, bic }
        })
        .collect()
}

/// Amplitudes of the oscillator as the points show them: without the background fitted, at the
/// mean drive. `None` where that is what was measured.
pub(crate) fn oscillator_seen(problem: &Problem, p: &[f64]) -> Option<Block> {
    let b = &problem.main;
    let background = Phasor::new(p[BG_RE], p[BG_IM]);
    let even = b.drive.iter().all(|d| *d == 1.0);
    if even && background == Phasor::default() {
        return None;
    }
    let mut mean = problem.clone();
    mean.main.drive.fill(1.0);
    let data = problem
        .everywhere(p, false)
        .into_iter()
        .zip(mean.everywhere(p, false))
        .enumerate()
        .map(|(i, pair)| {
            let (Some(here), Some(mean)) = pair else { return Phasor::new(b.amplitude(i), 0.0) };
            let (size, wanted) = (here.oscillator.norm(), mean.oscillator.norm());
            let amplitude = if b.complex {
                let ratio = if size > 0.0 { wanted / size } else { 1.0 };
                (b.data[i] - background).norm() * ratio
            } else {
                (wanted + b.less(i, here.value).re).max(0.0)
            };
            Phasor::new(amplitude, 0.0)
        })
        .collect();
    Some(Block { data, complex: false, drive: vec![1.0; b.len()], ..b.clone() })
}

impl Described {
    pub(crate) fn get(&self, model: LossModel) -> Option<&Entry> {
        self.entries.iter().find(|e| e.model == model)
    }

    /// The model of least BIC among those with every term inside its limit.
    pub(crate) fn preferred(&self) -> Option<&Entry> {
        let least = |list: &mut dyn Iterator<Item = &'_ Entry>| -> Option<LossModel> {
            list.min_by(|a, b| a.rank().total_cmp(&b.rank())).map(|e| e.model)
        };
        let model = least(&mut self.entries.iter().filter(|e| e.at_limit.is_none()))
            .or_else(|| least(&mut self.entries.iter()))?;
        self.get(model)
    }

    fn best_where(&self, sliding: bool) -> Option<&Entry> {
        self.entries
            .iter()
            .filter(|e| e.model.has_sliding() == sliding)
            .min_by(|a, b| a.rank().total_cmp(&b.rank()))
    }

    /// The entry with the terms of `model` and one more.
    pub(crate) fn with_term(&self, model: LossModel, term: usize) -> Option<&Entry> {
        LossModel::from_terms(
            model.has_viscous() || term == DELTA,
            model.has_sliding() || term == X_F,
            model.has_drag() || term == DRAG,
        )
        .and_then(|m| self.get(m))
    }

    /// p value of sliding friction given the best model without it, and the BIC's verdict.
    pub(crate) fn sliding_evidence(&self) -> (f64, f64) {
        let (Some(without), Some(with)) = (self.best_where(false), self.best_where(true)) else {
            return (1.0, 0.0);
        };
        let p = self.with_term(without.model, X_F).map_or(1.0, |union| self.test(without, union));
        (p, without.rank() - with.rank())
    }

    /// p value of a purely viscous loss against `model`.
    pub(crate) fn viscous_only(&self, model: LossModel) -> f64 {
        let Some(viscous) = self.get(LossModel::Viscous) else { return 1.0 };
        let against = match model {
            LossModel::Viscous => return 1.0,
            LossModel::Sliding => LossModel::ViscousSliding,
            LossModel::SlidingDrag => LossModel::ViscousSlidingDrag,
            m => m,
        };
        self.get(against).map_or(1.0, |m| self.test(viscous, m))
    }

    fn test(&self, small: &Entry, large: &Entry) -> f64 {
        self.scale.test(small.bounded.rss, large.bounded.rss, &large.bounded)
    }

    /// The problem as the entry's model uses it.
    pub(crate) fn problem_of(&self, entry: &Entry) -> Problem {
        let mut own = self.problem.clone();
        own.used = entry.fit.free.iter().copied().filter(|&k| k < R_OMEGA).collect();
        own
    }

    pub(crate) fn method(&self) -> Method {
        self.problem.method
    }
}
