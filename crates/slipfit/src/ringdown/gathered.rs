//! The samples of a window condensed into sums over stretches, for motions near a reference.
//!
//! All models of a decay, and all steps of their fits, require sums over the same samples for motions that
//! hardly differ. Within a stretch of some cycles a motion is determined by its state in the middle
//! (amplitude and phase) and by `x_F`, `delta`, drag rate, `omega` and offset. The motion scales with the
//! amplitude. The displacement is linear in the remaining difference to a reference, so the sums at the
//! reference and their derivatives by its parameters give the sums for any nearby motion:
//!
//! ```text
//! x = s x_ref(x_F/s, delta, c s, phi, omega),   s = A/A_ref
//! x - x_ref = J d,   d_A = A - A_ref,  d_x = x_F - x_F,ref,  d_c = s² c - (2 s - 1) c_ref,  d_k = s (k - k_ref) else
//! ```
//!
//! The neglected terms are of second order in the change of a loss over half a stretch, not over the window.
//! The last half cycles before a stop, whose number may change, and the rest are summed sample by sample.

use super::described::{A, C, D, DESCRIBED, Follow, LANES, Lanes, O, P, State, W, X, is_described};
use crate::inference::least_squares::Normal;
use crate::motion::decay::amplitude::sliding_gain;
use crate::motion::decay::parameters::{
    A0, BACKBONE, CHIRP, COUNT, DELTA, DRAG, OFFSET, OMEGA, PHASE, X_F, law_of,
};
use crate::motion::decay::window::Window;
use pulp::Simd;
use std::f64::consts::PI;

/// Number of stretches of a window, maximum number of parts of each for the fine description, and minimum
/// number of samples per part.
const STRETCHES: usize = 12;
const MOST_PARTS: usize = 3;
const LEAST_IN_PART: usize = 64;
/// Minimum amplitude at the end of the last stretch, in friction displacements, of the reference and of a
/// described motion.
const REFERENCE_SWING: f64 = 12.0;
const LEAST_SWING: f64 = 2.5;
/// Maximum difference of the phase, rad, and of the loss over half a stretch for a motion to be near the
/// reference, and for a rough description.
const NEAR: f64 = 0.05;
const ROUGH: f64 = 0.25;
/// Rise of the sum of squares above that of the reference, in variances, above which a rough description
/// suffices: such a motion is no rival.
const LARGE_RISE: f64 = 1000.0;
/// Tolerated shift of a parameter, in standard errors, by the neglected terms in the fine description: for a
/// motion as good as the reference, and as a fraction of the square root of the rise for others; then the
/// same for motions that are no rivals.
const FINE: f64 = 1e-3;
const FINE_AT_LARGE_RISE: f64 = 1e-2;
/// Fraction of the sums that their differences must exceed.
const ROUNDING: f64 = 1e-7;
/// Number of samples whose computation takes as long as the start of a half cycle, and minimum work, in
/// samples, for which gathering pays.
const SAMPLES_PER_HALF_CYCLE: f64 = 30.0;
const LEAST_WORK: f64 = 2000.0;

/// Sums over the stretches of a window.
#[derive(Debug, Clone)]
pub(crate) struct Gathered {
    reference: Vec<f64>,
    rss: f64,
    samples: usize,
    /// Residuals of the samples; empty if some samples lie after the last stretch.
    residuals: Vec<f64>,
    /// Sums at the reference for these parameters and, approximately, for disturbances of phase and offset;
    /// `None` if the rest has its own level.
    there: Option<Normal>,
    coarse: Stretches,
    /// The same with each stretch divided into parts.
    fine: Option<Stretches>,
    /// First sample after the last stretch, and the end of that stretch relative to the origin, s.
    tail: (usize, f64),
}

/// Required accuracy of the sums.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) enum Closeness {
    /// Sufficient for a search.
    Coarse,
    /// Accurate to within [`FINE`].
    Fine,
}

/// Stretches of equal length, from the start of the window.
#[derive(Debug, Clone)]
struct Stretches {
    /// s.
    length: f64,
    list: Vec<Stretch>,
}

/// A stretch, with the state of the reference in its middle.
#[derive(Debug, Clone)]
struct Stretch {
    state: State,
    sums: Part,
}

/// Sums over some of the samples.
#[derive(Debug, Clone)]
struct Part {
    products: [Lanes; LANES],
    residual: Lanes,
    rss: f64,
}

impl Part {
    /// Constructs the sums from the rows of the lower triangle.
    fn new(rows: &[f64]) -> Self {
        let pair = |a: usize, c: usize| rows[a.max(c) * (a.max(c) + 1) / 2 + a.min(c)];
        let (mut products, mut residual) = ([[0.0; LANES]; LANES], [0.0; LANES]);
        for i in 0..DESCRIBED.len() {
            residual[i] = pair(DESCRIBED.len(), i);
            for j in 0..DESCRIBED.len() {
                products[i][j] = pair(i, j);
            }
        }
        Self { products, residual, rss: pair(DESCRIBED.len(), DESCRIBED.len()) }
    }

    fn joined(parts: &[Self]) -> Self {
        let mut all = Self { products: [[0.0; LANES]; LANES], residual: [0.0; LANES], rss: 0.0 };
        for part in parts {
            let rows = all.products.iter_mut().chain([&mut all.residual]);
            for (sums, row) in rows.zip(part.products.iter().chain([&part.residual])) {
                sums.iter_mut().zip(row).for_each(|(sum, v)| *sum += v);
            }
            all.rss += part.rss;
        }
        all
    }
}

impl Stretches {
    fn about(reference: &[f64], length: f64, sums: &[Part]) -> Self {
        // The phase lag by drag contributes to the derivatives even if the reference has no drag.
        let mut follow = Follow::new(reference, true);
        let middles = (0..sums.len()).map(|k| (k as f64 + 0.5) * length);
        let list = middles.zip(sums).map(|(t, sums)| Stretch { state: follow.to(t), sums: sums.clone() });
        Self { length, list: list.collect() }
    }
}

/// Adds the sums of a stretch for all parameters, including disturbances.
fn add_disturbed(
    there: &mut Normal,
    window: &Window,
    middle: f64,
    products: &[Lanes; LANES],
    residual: &Lanes,
) {
    let duration = window.duration.max(f64::MIN_POSITIVE);
    let v = middle / duration;
    let phase = |value: f64, rate: f64| {
        let mut lanes = [0.0; LANES];
        (lanes[P], lanes[W]) = (value - rate * middle, rate);
        lanes
    };
    let (bent, bending) = window.backbone.map_or((0.0, 0.0), |b| b.at(middle));
    let disturbed = [
        (BACKBONE, phase(bent, bending)),
        (CHIRP, phase(0.5 * middle * (middle - duration), middle - 0.5 * duration)),
        (OFFSET + 1, scaled(v, &unit(O))),
        (OFFSET + 2, scaled(v * v, &unit(O))),
    ];
    let described = DESCRIBED.into_iter().enumerate().map(|(i, slot)| (slot, unit(i)));
    let rows: Vec<(usize, Lanes)> = described.chain(disturbed).collect();
    for (i, (a, row)) in rows.iter().enumerate() {
        let mut by_lanes = [0.0; LANES];
        for (factor, product) in row.iter().zip(products) {
            by_lanes.iter_mut().zip(product).for_each(|(sum, p)| *sum += factor * p);
        }
        there.jtr[*a] += row.iter().zip(residual).map(|(f, r)| f * r).sum::<f64>();
        for (c, other) in &rows[..=i] {
            let sum: f64 = other.iter().zip(by_lanes).map(|(f, p)| f * p).sum();
            there.jtj[(*a.max(c), *a.min(c))] += sum;
        }
    }
}

impl Gathered {
    /// Gathers the samples of a window about a motion near its minimum. `None` if the motion cannot be
    /// described in this way.
    pub(crate) fn about(window: &Window, reference: &[f64]) -> Option<Self> {
        let Window { time, origin, duration, .. } = *window;
        let n = time.len();
        let half_cycles = duration * reference[OMEGA] / PI;
        let work = n as f64 + SAMPLES_PER_HALF_CYCLE * half_cycles;
        if !is_described(reference) || work < LEAST_WORK {
            return None;
        }
        let law = law_of(reference, reference[OMEGA]);
        let swings = |t: f64| law.amplitude(t) > REFERENCE_SWING * reference[X_F].max(0.0);
        let length = duration / STRETCHES as f64;
        let whole = (1..=STRETCHES).rev().find(|k| swings(*k as f64 * length))?;
        let finer = (n / (STRETCHES * LEAST_IN_PART)).clamp(1, MOST_PARTS);
        let before = |k: usize| time.partition_point(|t| *t < origin + k as f64 * length / finer as f64);
        let borders: Vec<usize> = (1..STRETCHES * finer).map(before).filter(|border| *border < n).collect();
        let mut residuals = Vec::with_capacity(n);
        let window = Window { active: &DESCRIBED, ..*window };
        let parts = window.sums_of_parts(reference, &borders, Some(&mut residuals))?;
        let parts: Vec<Part> = parts.iter().map(|rows| Part::new(rows)).collect();
        let stretches: Vec<Part> = parts.chunks(finer).map(Part::joined).collect();
        let mut there = Normal::zeros(COUNT);
        for (k, Part { products, residual, rss }) in stretches.iter().enumerate() {
            add_disturbed(&mut there, &window, (k as f64 + 0.5) * length, products, residual);
            there.rss += rss;
        }
        let about = |length, sums: &[Part], count: usize| {
            Stretches::about(reference, length, &sums[..sums.len().min(count)])
        };
        let coarse = about(length, &stretches, whole);
        let fine = (finer > 1).then(|| about(length / finer as f64, &parts, whole * finer));
        let tail = (borders.get(whole * finer - 1).copied().unwrap_or(n), whole as f64 * length);
        let rss = there.rss;
        let there = (tail.0 == n || window.models_rest_position).then_some(there);
        if tail.0 < n {
            residuals.clear();
        }
        let reference = reference.to_vec();
        Some(Self { reference, rss, samples: n, residuals, there, coarse, fine, tail })
    }

    /// The residuals at the reference if no sample is at rest; `None` for any other motion.
    pub(crate) fn residuals_at(&self, p: &[f64]) -> Option<&[f64]> {
        (p == self.reference && !self.residuals.is_empty()).then_some(&self.residuals)
    }

    /// Sums at the reference for all parameters; those for disturbances of phase and offset are approximate,
    /// since within a stretch the phase is taken as linear and the offset as constant. `None` for any other
    /// motion.
    pub(crate) fn roughly_at(&self, p: &[f64]) -> Option<&Normal> {
        self.there.as_ref().filter(|_| p == self.reference)
    }

    /// The sums at `p` for the `free` parameters; `None` if the motion is not near the reference. The sums of
    /// the samples after the last stretch are computed by `sums_after`.
    pub(crate) fn normal_of(
        &self,
        p: &[f64],
        free: &[usize],
        closeness: Closeness,
        out: &mut Normal,
        sums_after: &SumsAfter,
    ) -> Option<()> {
        if !(is_described(p) && free.iter().all(|k| DESCRIBED.contains(k))) {
            return None;
        }
        let pass = |stretches| {
            crate::numeric::dispatch(Pass { gathered: self, stretches, closeness, sums_after, p, free })
        };
        // For most motions the few long stretches are accurate enough.
        let finely = || pass(self.fine.as_ref().filter(|_| closeness == Closeness::Fine)?);
        let sums = pass(&self.coarse).or_else(finely)?;
        for (i, a) in DESCRIBED.into_iter().enumerate().filter(|(_, a)| free.contains(a)) {
            out.jtr[a] = sums.residual[i];
            for (j, c) in DESCRIBED.into_iter().enumerate().take(i + 1).filter(|(_, c)| free.contains(c)) {
                out.jtj[(a, c)] = sums.products[i][j];
            }
        }
        out.rss = sums.rss;
        Some(())
    }
}

/// Sums of the samples of a window from a given one on, for parameters that refer to a given time after the
/// origin; returns whether they exist.
type SumsAfter<'a> = dyn Fn(usize, f64, &[f64], &[usize], &mut Normal) -> bool + 'a;

/// Request for the sums at a motion.
struct Pass<'a> {
    gathered: &'a Gathered,
    stretches: &'a Stretches,
    closeness: Closeness,
    sums_after: &'a SumsAfter<'a>,
    p: &'a [f64],
    free: &'a [usize],
}

/// Products and residuals for the described parameters.
struct Sums {
    products: [Lanes; LANES],
    residual: Lanes,
    rss: f64,
}

/// Adds `factor` times the lanes.
#[inline(always)]
fn add<S: Simd>(simd: S, to: &mut Lanes, factor: f64, lanes: &Lanes) {
    let factor = simd.splat_f64s(factor);
    let ((to, _), (lanes, _)) = (S::as_mut_simd_f64s(to), S::as_simd_f64s(lanes));
    for (to, lanes) in to.iter_mut().zip(lanes) {
        *to = simd.mul_add_e_f64s(factor, *lanes, *to);
    }
}

#[inline(always)]
fn scaled(factor: f64, lanes: &Lanes) -> Lanes {
    lanes.map(|v| factor * v)
}

#[inline(always)]
fn unit(k: usize) -> Lanes {
    let mut lanes = [0.0; LANES];
    lanes[k] = 1.0;
    lanes
}

impl Sums {
    /// Adds products and residuals, transformed by the rows of derivatives of the lanes.
    #[inline(always)]
    fn add<S: Simd>(
        &mut self,
        simd: S,
        products: &[Lanes; LANES],
        residual: &Lanes,
        rows: &[Lanes; LANES - 1],
    ) {
        for (i, row) in rows.iter().enumerate() {
            let mut by_lanes = [0.0; LANES];
            for (product, other) in products[i].iter().zip(rows) {
                add(simd, &mut by_lanes, *product, other);
            }
            for (sum, factor) in self.products.iter_mut().zip(row) {
                add(simd, sum, *factor, &by_lanes);
            }
            add(simd, &mut self.residual, residual[i], row);
        }
    }
}

impl pulp::WithSimd for Pass<'_> {
    type Output = Option<Sums>;

    #[inline(always)]
    fn with_simd<S: Simd>(self, simd: S) -> Option<Sums> {
        let Self { gathered, stretches: Stretches { length, list }, closeness, sums_after, p, free } = self;
        let drags = p[DRAG] != 0.0 || free.contains(&DRAG);
        let mut sums = Sums { products: [[0.0; LANES]; LANES], residual: [0.0; LANES], rss: 0.0 };
        let (mut cancelling, mut farthest, mut neglected) = (0.0, 0.0f64, 0.0);
        let mut follow = Follow::new(p, drags);
        let (from, from_s) = gathered.tail;
        let q = DESCRIBED.map(|k| p[k]);
        let q_ref = DESCRIBED.map(|k| gathered.reference[k]);
        let gains = [p, &gathered.reference].map(|p| sliding_gain(p[DELTA], p[OMEGA])[0]);
        for (k, stretch) in list.iter().enumerate() {
            let here = follow.to((k as f64 + 0.5) * length);
            let Stretch { state, sums: Part { products, residual, rss } } = stretch;
            let s = here.amplitude / state.amplitude;
            let turned = here.phase - state.phase;
            // Viscous and drag loss of opposite sign cancel apart from the change of the amplitude.
            let (viscous, drag) = (q[D] - q_ref[D], q[C] * here.amplitude - q_ref[C] * state.amplitude);
            let loss = (viscous + drag).abs() + 0.25 * drag.abs();
            farthest = farthest.max(turned.abs()).max(0.5 * loss * length);
            if !(farthest < ROUGH && here.amplitude > 0.0) {
                return None;
            }
            if closeness == Closeness::Fine {
                let sliding = gains[0] * q[X] / here.amplitude - gains[1] * q_ref[X] / state.amplitude;
                let whole = q_ref[D] + q_ref[C] * state.amplitude + gains[1] * q_ref[X] / state.amplitude;
                let half = 0.5 * length;
                // Rate at which the logarithms of the two amplitudes diverge, and the change of this rate as
                // the amplitude falls.
                let apart = (drag - sliding).abs();
                let net = (viscous + drag + sliding).abs() + whole.abs() * half * apart;
                let rate = (q[W] - q_ref[W]).abs();
                let second = net * (net + apart) + rate * (rate + net) + (turned / half).powi(2);
                // The mean fourth power of the time from the middle is a fifth of its value at the ends.
                let relative = (0.5 * half * half * second).powi(2) / 5.0;
                neglected += relative * (state.amplitude / state.by[A]).powi(2) * products[A][A];
            }
            // Differences of state and parameters, with their derivatives.
            let s_by = scaled(1.0 / state.amplitude, &here.by);
            let mut moved = [0.0; LANES];
            let mut rows = [[0.0; LANES]; LANES - 1];
            (moved[A], rows[A]) = (here.amplitude - state.amplitude, here.by);
            (moved[X], rows[X]) = (q[X] - q_ref[X], unit(X));
            (moved[O], rows[O]) = (q[O] - q_ref[O], unit(O));
            for k in [D, W] {
                moved[k] = s * (q[k] - q_ref[k]);
                rows[k] = scaled(q[k] - q_ref[k], &s_by);
                rows[k][k] += s;
            }
            moved[C] = s * s * q[C] - (2.0 * s - 1.0) * q_ref[C];
            rows[C] = scaled(2.0 * (s * q[C] - q_ref[C]), &s_by);
            rows[C][C] += s * s;
            moved[P] = s * turned;
            rows[P] = scaled(turned, &s_by);
            add(simd, &mut rows[P], s, &here.phase_by);
            // Convert to differences of amplitude and phase at the origin, to which the sums refer.
            let over = 1.0 / state.by[A];
            for k in [X, D, C, W] {
                moved[A] -= state.by[k] * moved[k];
                let row = rows[k];
                add(simd, &mut rows[A], -state.by[k], &row);
            }
            (moved[A], rows[A]) = (over * moved[A], scaled(over, &rows[A]));
            for k in [A, X, D, C, W] {
                moved[P] -= state.phase_by[k] * moved[k];
                let row = rows[k];
                add(simd, &mut rows[P], -state.phase_by[k], &row);
            }
            let mut left = *residual;
            let mut there = *residual;
            for (row, by) in products.iter().zip(moved) {
                add(simd, &mut left, -by, row);
            }
            add(simd, &mut there, 1.0, &left);
            let change = there.iter().zip(moved).map(|(r, d)| r * d).sum::<f64>();
            sums.rss += rss - change;
            cancelling += rss + change.abs();
            sums.add(simd, products, &left, &rows);
        }
        let samples = gathered.samples as f64;
        if closeness == Closeness::Fine {
            let here: f64 = list.iter().map(|stretch| stretch.sums.rss).sum();
            let rise = (sums.rss - here).max(0.0);
            let part = if rise * samples > LARGE_RISE * gathered.rss { FINE_AT_LARGE_RISE } else { FINE };
            if !(neglected * samples <= FINE * FINE * gathered.rss + part * part * rise * samples) {
                return None;
            }
        }
        let end = follow.to(from_s);
        if !(end.amplitude > LEAST_SWING * p[X_F].max(0.0)) {
            return None;
        }
        if from < gathered.samples {
            let active: &[usize] = if drags { &DESCRIBED } else { &[A0, X_F, DELTA, PHASE, OMEGA, OFFSET] };
            let mut there = p.to_vec();
            (there[A0], there[PHASE]) = (end.amplitude, end.phase);
            let mut found = Normal::zeros(COUNT);
            if !sums_after(from, from_s, &there, active, &mut found) {
                return None;
            }
            let (mut products, mut residual) = ([[0.0; LANES]; LANES], [0.0; LANES]);
            for (i, &a) in DESCRIBED.iter().enumerate() {
                residual[i] = found.jtr[a];
                for (j, &c) in DESCRIBED[..=i].iter().enumerate() {
                    products[i][j] = found.jtj[(a, c)];
                    products[j][i] = found.jtj[(a, c)];
                }
            }
            let mut rows = std::array::from_fn(unit);
            (rows[A], rows[P]) = (end.by, end.phase_by);
            sums.rss += found.rss;
            cancelling += found.rss;
            sums.add(simd, &products, &residual, &rows);
        }
        let rise = (sums.rss - gathered.rss) * samples;
        if closeness == Closeness::Coarse && farthest > NEAR && !(rise > LARGE_RISE * gathered.rss) {
            return None;
        }
        // For exact samples the residuals are pure rounding errors.
        (sums.rss > ROUNDING * cancelling).then_some(sums)
    }
}
