//! From a curve to all loss models, fitted: starts, instrument terms, noise.

use super::block::Block;
use super::look::{self, Line};
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

/// Fits everything; phases that fit no resonance while the amplitudes do are left aside.
pub(crate) fn describe(main: Block, reference: Option<Block>, options: &Options) -> Result<Described, Error> {
    describe_as(main, reference, options, true)
}

/// A residual above this part of the height makes phases suspect.
const UNLIKELY: f64 = 0.08;

fn describe_as(
    main: Block,
    reference: Option<Block>,
    options: &Options,
    may_ignore_phases: bool,
) -> Result<Described, Error> {
    let mut main = main;
    let no = |reason| Error::NoResonance { reason };
    let mut line = look::line(&main).ok_or(no("every amplitude is zero"))?;
    if main.len() < 4 {
        return Err(Error::TooFewPoints { points: main.len(), parameters: 4 });
    }
    let noise = look::noise(&main);
    let wanted = options.terms;
    let mut pedestal = look::pedestal(&main, &line).filter(|_| wanted.background != Some(false));
    if let Some(p) = &pedestal {
        line = p.line;
    }
    let background = wanted.background == Some(true) || pedestal.is_some();
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
    if wanted.delay == Some(true) && complex {
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
            (s[BG_RE], s[BG_IM]) = (p.height.re, p.height.im);
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
    if complex && may_ignore_phases && sigma2.sqrt() > UNLIKELY * line.height {
        let plain = amplitudes_only(&problem.main);
        let reference = block.as_ref().map(amplitudes_only);
        if let Ok(mut described) = describe_as(plain, reference, options, false)
            && described.preferred().is_some_and(|e| described.scale.variance_of(&e.bounded) < 0.06 * sigma2)
        {
            described.phases_ignored = true;
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

    // Instrument terms the data cannot do without.
    let mut free = full;
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
            let Some(f) = minimise(&trial, &fit.parameters, &more) else { continue };
            // A term that is missing makes residuals hang together: what counts is how they do
            // with it.
            let (_, _, widening) = hang_together(&trial, &f);
            let scale = Scale { widening, ..plain_scale(&trial) };
            let gain = scale.bic(fit.rss, free.len()) - scale.bic(f.rss, more.len());
            if gain > TAKEN_UP && found.as_ref().is_none_or(|(g, ..)| gain > *g) {
                found = Some((gain, more, f));
            }
        }
        let Some((_, more, f)) = found else { break };
        problem.used = more.iter().copied().filter(|&k| k < R_OMEGA).collect();
        (free, fit) = (more, f);
        if !complex {
            let v = variance(&fit, &problem);
            settle_rice(&mut problem, &fit.parameters, v);
        }
    }
    let others: Vec<usize> = free.iter().copied().filter(|k| ![X_F, DELTA, DRAG].contains(k)).collect();
    if let Some([value, _]) = problem.prior {
        let drive = options.drive_amplitude.map_or(1.0, |d| d.std_error);
        problem.prior = Some([value, variance(&fit, &problem) / (drive * drive)]);
    }

    let (autocorrelation, neighbour_noise, widening) = hang_together(&problem, &fit);
    let scale = Scale { widening, ..plain_scale(&problem) };
    starts.insert(0, fit.parameters.clone());
    let entries = compare(&problem, &starts, &others, &scale, options.model);
    if entries.is_empty() {
        return Err(Error::NoFit { reason: "no loss model could be fitted to the curve" });
    }
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
    })
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
    const TRIES: usize = 3;
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
    for (_, s) in ranked.into_iter().take(TRIES) {
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
        if again > 0 {
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
) -> Vec<Entry> {
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
        if let Some(fit) = best(&own, &from, &free) {
            if model == LossModel::ViscousSliding {
                // So far from zero no data call for a model without it.
                surely_viscous = fit.parameters[DELTA] > 10.0 * scale.std_error(&fit, DELTA).0;
            }
            fits.push((model, fit));
        }
    }
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
