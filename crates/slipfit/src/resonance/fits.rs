//! From a curve to all loss models, fitted.

use super::block::Block;
use super::described::{Described, oscillator_seen, slot};
use super::instrument_start::{self, Allowed, InstrumentStart};
use super::models::compare;
use super::peak::{self, Peak};
use super::prepared::PreparedCurve;
use super::problem::Problem;
use super::reference::FrictionFreeFit;
use super::residuals::{autocorrelation_of, leave_out, plain_scale, settle_rice, variance};
use super::response::{BG_IM, BG_RE, DELAY, DELTA, DRAG, DUFFING, OMEGA, PHASE, R_OMEGA, X_0, X_F};
use super::search::{TRIES, best, rss, starts};
use super::{DriveSource, Options};
use crate::Error;
use crate::inference::least_squares::{Fit, LeastSquares, minimise};
use crate::inference::model_selection::ModelComparison;
use crate::inference::noise::NoiseModel;
use crate::model::loss::LossModel;

/// Fits everything; phases that fit no resonance while the amplitudes do are left aside.
pub(crate) fn describe(main: Block, reference: Option<Block>, options: &Options) -> Result<Described, Error> {
    if options.terms.delay == Some(true) && main.complex {
        // It may be many turns across the curve: no first value but its own leads there.
        let allowed = Allowed::by(options);
        if let Some(behind) = best_behind(&main, reference.as_ref(), options, allowed) {
            let plain = describe_as(main, reference, options, Way::AsGiven);
            return Ok(plain.ok().filter(|d| left(d) <= left(&behind)).unwrap_or(behind));
        }
    }
    describe_as(main, reference, options, Way::AsGiven)
}

/// How the data are taken.
pub(super) enum Way {
    AsGiven,
    /// Without the phases there were.
    Amplitudes,
    /// From background and delay known about.
    Behind(Box<InstrumentStart>),
}

/// A residual above this part of the height makes phases suspect.
const UNLIKELY: f64 = 0.08;
/// Together, terms must leave less than this part of what they leave one by one.
const BETTER: f64 = 0.8;

fn describe_as(
    main: Block,
    reference: Option<Block>,
    options: &Options,
    way: Way,
) -> Result<Described, Error> {
    let first_time = matches!(way, Way::AsGiven);
    let behind = matches!(way, Way::Behind(_));
    let allowed = Allowed::by(options);
    let mut ready = PreparedCurve::new(main, reference, options, way)?;
    let (all, conjugated, noise) = (ready.all.take(), ready.conjugated, ready.noise);
    let (mut fitting, beside) = Fitting::begin(ready, options)?;

    let sigma2 = fitting.variance().max(f64::MIN_POSITIVE);
    if let Some(reason) = peak::absence(&fitting.problem.main, noise.min(sigma2.sqrt())) {
        return Err(Error::NoResonance { reason });
    }
    if fitting.problem.main.complex && first_time && sigma2.sqrt() > UNLIKELY * fitting.line.height {
        let block = beside.as_ref().map(|b| &b.block);
        if let Some(mut other) = otherwise(&fitting.problem.main, block, options, allowed, sigma2) {
            other.conjugated ^= conjugated && !other.phases_ignored;
            other.all = all.map(|a| if other.phases_ignored { a.without_phases() } else { a });
            return Ok(other);
        }
    }
    fitting.join(beside);
    fitting.settle_rice_and_fit();
    fitting.leave_out(noise);

    let before = fitting.fit.free.len();
    if behind {
        fitting.drop_unneeded();
    }
    fitting.take_up();
    fitting.settle_order();
    let more = fitting.fit.free.len() > before || fitting.fit.free.contains(&BG_RE);
    let (_, between_neighbours, _) = autocorrelation_of(&fitting.problem, &fitting.fit);
    let noise = noise.min(between_neighbours);
    if fitting.problem.main.complex && first_time && more && fitting.variance() > 2.0 * noise * noise {
        // Terms were taken up one by one and leave more than noise: together they may not.
        let reference = fitting.problem.reference.as_ref();
        let other = best_behind(&fitting.problem.main, reference, options, allowed);
        if let Some(mut other) = other.filter(|d| left(d) < BETTER * fitting.variance()) {
            other.conjugated ^= conjugated;
            other.all = all;
            other.left_out += fitting.left_out;
            return Ok(other);
        }
    }
    fitting.keep_minima();
    let described = fitting.models()?;
    Ok(Described { conjugated, all, ..described })
}

/// A curve on the way to its loss models: viscous damping and sliding friction are free, and
/// what else the data ask for.
pub(super) struct Fitting<'a> {
    pub(super) options: &'a Options,
    pub(super) problem: Problem,
    pub(super) line: Peak,
    pub(super) fit: Fit,
    /// Everything free before terms are taken up or dropped.
    full: Vec<usize>,
    starts: Vec<Vec<f64>>,
    pub(super) minima: Vec<Fit>,
    left_out: usize,
}

impl<'a> Fitting<'a> {
    /// The curve fitted without its reference, to learn the noise that weighs it.
    fn begin(ready: PreparedCurve, options: &'a Options) -> Result<(Self, Option<FrictionFreeFit>), Error> {
        let PreparedCurve { main, reference, line, pedestal, background, from_phases, .. } = ready;
        let wanted = options.terms;
        let phase = wanted.phase_offset != Some(false);
        let problem = Problem {
            method: options.method,
            background_delayed: pedestal.as_ref().is_some_and(|p| p.delayed),
            ..Problem::new(main, line.omega, Vec::new())
        };
        let delay = pedestal.as_ref().map_or(0.0, |p| p.delay);
        let complex = problem.main.complex;
        let fixed = options.drive_amplitude.is_some_and(|d| d.std_error == 0.0);
        let mut full = vec![OMEGA, DELTA, X_F];
        let mut free_if = |yes: bool, terms: &[usize]| full.extend(terms.iter().filter(|_| yes));
        free_if(!fixed, &[X_0]);
        free_if(complex && phase, &[PHASE]);
        free_if(background, &[BG_RE, BG_IM]);
        free_if(complex && (wanted.delay == Some(true) || delay != 0.0), &[DELAY]);
        free_if(wanted.duffing == Some(true), &[DUFFING]);
        let beside = reference.map(|block| FrictionFreeFit::new(block, &problem, background)).transpose()?;
        if let Some(beside) = &beside {
            full.extend(beside.free(phase, background));
        }
        full.sort_unstable();
        let with_reference = problem.observations() + beside.as_ref().map_or(0.0, |b| b.block.observations());
        if (with_reference as usize) <= full.len() {
            return Err(Error::TooFewPoints { points: problem.main.len(), parameters: full.len() });
        }
        let known = options.drive_amplitude.map(|d| d.value).or(beside.as_ref().map(FrictionFreeFit::drive));
        let mut starts = starts(&problem.main, &line, from_phases, known, fixed);
        for s in &mut starts {
            if let Some(p) = &pedestal {
                (s[BG_RE], s[BG_IM], s[DELAY]) = (p.height.re, p.height.im, delay);
            }
            if let Some(beside) = &beside {
                beside.copy_to(s);
            }
            if !full.contains(&PHASE) {
                s[PHASE] = 0.0;
            }
        }
        let own: Vec<usize> = full.iter().copied().filter(|&k| k < R_OMEGA).collect();
        let problem = problem.with(&own);
        let fit = best(&problem, &starts, &own).ok_or(Error::NoFit {
            reason: "no resonance curve with viscous and sliding loss was reached from any start",
        })?;
        Ok((Self { options, problem, line, fit, full, starts, minima: Vec::new(), left_out: 0 }, beside))
    }

    fn variance(&self) -> f64 {
        variance(&self.problem, &self.fit)
    }

    /// Fits curve and reference together, each weighed by its own noise.
    fn join(&mut self, beside: Option<FrictionFreeFit>) {
        let sigma2 = self.variance().max(f64::MIN_POSITIVE);
        let weight = |of_curve: f64, b: f64| (of_curve / b).clamp(1e-12, 1e12);
        if let Some(drive) = self.options.drive_amplitude.filter(|d| d.std_error > 0.0) {
            self.problem.prior = Some([drive.value, sigma2 / (drive.std_error * drive.std_error)]);
        }
        let mut here = self.fit.parameters.clone();
        let mut of_reference = None;
        if let Some(beside) = beside {
            beside.copy_to(&mut here);
            of_reference = Some(beside.variance);
            self.problem.reference_weight = weight(sigma2, beside.variance);
            self.problem.reference = Some(beside.block);
        }
        self.starts.insert(0, here);
        match best(&self.problem, &self.starts, &self.full) {
            Some(fit) => self.fit = fit,
            None => self.fit.free.clone_from(&self.full),
        }
        // Without the reference the shape alone may have ended elsewhere, its residuals no measure
        // of the noise: beside the reference they are.
        let Some(of_reference) = of_reference else { return };
        let own = self.problem.used.len() as f64;
        for _ in 0..3 {
            let alone = Problem { reference: None, ..self.problem.clone() };
            let Some(left) = rss(&alone, &self.fit.parameters, f64::INFINITY) else { return };
            let better = weight(left / (alone.observations() - own).max(1.0), of_reference);
            if (better / self.problem.reference_weight).ln().abs() < 0.2 {
                return;
            }
            self.problem.reference_weight = better;
            if !self.again() {
                return;
            }
        }
    }

    /// The fit again, from where it is; whether there is one.
    fn again(&mut self) -> bool {
        let found = best(&self.problem, std::slice::from_ref(&self.fit.parameters), &self.full);
        let is = found.is_some();
        self.fit = found.unwrap_or_else(|| self.fit.clone());
        is
    }

    /// Amplitudes carry Rice's noise; its size comes from the residuals.
    pub(super) fn settle_rice(&mut self) {
        if !self.problem.main.complex {
            let v = self.variance();
            settle_rice(&mut self.problem, &self.fit.parameters, v);
        }
    }

    fn settle_rice_and_fit(&mut self) {
        if self.problem.main.complex {
            return;
        }
        for _ in 0..2 {
            self.settle_rice();
            if let Some(f) = minimise(&self.problem, &self.fit.parameters, &self.full) {
                self.fit = f;
            }
        }
    }

    fn leave_out(&mut self, noise: f64) {
        self.left_out = leave_out(&mut self.problem, &self.fit.parameters, noise);
        if self.left_out > 0 {
            self.again();
        }
    }

    /// Every loss model beside the terms now free.
    fn models(mut self) -> Result<Described, Error> {
        let asked = self.options.model;
        let losses = [X_F, DELTA, DRAG];
        let others: Vec<usize> = self.fit.free.iter().copied().filter(|k| !losses.contains(k)).collect();
        if let Some([value, _]) = self.problem.prior {
            let error = self.options.drive_amplitude.map_or(1.0, |d| d.std_error);
            self.problem.prior = Some([value, self.variance() / (error * error)]);
        }
        let (mut autocorrelation, mut neighbour_noise, widening) =
            autocorrelation_of(&self.problem, &self.fit);
        let mut noise = NoiseModel { variance_inflation: widening, ..plain_scale(&self.problem) };
        self.starts.insert(0, self.fit.parameters.clone());
        self.starts.splice(1..1, self.minima.iter().map(|m| m.parameters.clone()));
        let tries = if self.minima.is_empty() { TRIES } else { TRIES + 2 * self.minima.len() };
        let fits = compare(&self.problem, &self.starts, &others, noise, asked, tries);
        // What one loss term leaves over is no noise: it is judged beside all of them.
        let richest = fits.iter().find(|(m, f)| *m == LossModel::VISCOUS_SLIDING_DRAG && f.converged);
        if let Some((_, f)) = richest.filter(|_| widening > 1.0 && self.drag_is_possible()) {
            let own = self.problem.with(&f.free);
            (autocorrelation, neighbour_noise, noise.variance_inflation) = autocorrelation_of(&own, f);
        }
        let comparison = ModelComparison::new(&fits, slot, noise);
        let Some(first) = comparison.fits.first() else {
            return Err(Error::NoFit { reason: "no loss model could be fitted to the curve" });
        };
        let unit = noise.variance(&first.bounded);
        let least = self.minima.iter().map(|m| m.rss).fold(f64::INFINITY, f64::min);
        self.minima.retain(|m| m.rss - least < 4.0 * unit);
        let source = match (self.options.drive_amplitude, &self.problem.reference) {
            (Some(_), _) => DriveSource::Known,
            (None, Some(_)) => DriveSource::Reference,
            (None, None) => DriveSource::Shape,
        };
        let seen = oscillator_seen(&self.problem, &self.fit.parameters).and_then(|b| peak::find(&b));
        Ok(Described {
            source,
            peak: seen.unwrap_or(self.line),
            problem: self.problem,
            comparison,
            conjugated: false,
            phases_ignored: false,
            all: None,
            left_out: self.left_out,
            neighbour_noise,
            autocorrelation,
            minima: self.minima,
        })
    }
}

/// The best description from all first values of background and delay.
fn best_behind(
    main: &Block,
    reference: Option<&Block>,
    options: &Options,
    allowed: Allowed,
) -> Option<Described> {
    let noise = peak::noise(main);
    let mut best: Option<Described> = None;
    for pedestal in instrument_start::find(main, allowed) {
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
    d.comparison.preferred().map_or(f64::INFINITY, |f| d.comparison.noise.residual_variance(&f.bounded))
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
        let reference = reference.map(Block::without_phases);
        describe_as(main.without_phases(), reference, options, Way::Amplitudes).ok()
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
