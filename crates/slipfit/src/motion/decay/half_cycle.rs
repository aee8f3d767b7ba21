//! The half-cycle kernel: compares a free decay and its derivatives with the samples of a record.
//!
//! The motion runs from turning point to turning point; between two of them, with amplitudes `X` and `X'`, it is a
//! damped cosine about `±x_F`. With the phase `theta` since the turning point and `ln rho = pi lambda`,
//! `rho = (X' + x_F)/(X - x_F)`,
//!
//! ```text
//! x = s [x_F + (X - x_F) f],   f = e^(lambda theta) (cos theta - lambda sin theta)
//! ```
//!
//! This is the closed form if frequency and decay rate are constant, and joins the turning points smoothly if they
//! change slowly; quadratic drag adds [its own shape](super::drag). All derivatives are combinations of `f`,
//! `theta f`, `g = e^(lambda theta) sin theta`, `theta g` and that shape. One pass gives the sums of a least-squares
//! step; nothing is stored per sample.
//!
//! Velocities and accelerations are combinations of the same functions. With respect to the phase,
//!
//! ```text
//! f' = -(1 + lambda²) g     g' = f + 2 lambda g     (theta f)' = f + theta f'     (theta g)' = g + theta g'
//! ```
//!
//! and with respect to time, this times the phase rate, over `omega`; an acceleration jumps at each turning point.

use super::drag;
use super::parameters::{COUNT, DELTA, DRAG, OFFSET, OMEGA, PHASE, X_F};
use super::turns::{Turn, Turns};
use super::window::{Observable, Window};
use crate::numeric::products::{Products, WIDTH};
use crate::numeric::trig::inverse_factorials;
use crate::numeric::wide;
use pulp::Simd;
use std::f64::consts::{FRAC_1_PI, FRAC_PI_2, PI};

/// Number of values computed together.
const LANES: usize = 8;
/// `1/k!`: the terms of `e^x` that are needed for `|x| <= 1/16`.
const EXPONENTIAL: [f64; 10] = inverse_factorials(0, 1);
/// Maximum absolute logarithm of the ratio of successive swings.
const MOST_DECREMENT: f64 = 700.0;
/// Size below which the swing of a half cycle is a last swing, in parts of x_F, and the factor by which the ratio of
/// such swings may differ from that of viscous damping.
const LAST_SWING: f64 = 0.1;
const LAST_RATIO: f64 = 2.0;
/// Maximum number of steps between turning points per sample, and in addition independent of the samples; beyond it
/// the frequency is rejected, because a fit that strays to a frequency far above the sampling rate would take
/// minutes.
const MOST_STEPS: [usize; 2] = [8, 10_000];
/// Number of half cycles without a sample above which several are passed at once.
const GAP: f64 = 4.0;

impl Window<'_> {
    /// Products of all active derivatives and the residual, summed over the samples. `None` if the model does not
    /// exist.
    pub(crate) fn sums(&self, p: &[f64], residuals: Option<&mut Vec<f64>>) -> Option<Passed> {
        crate::numeric::dispatch(Pass { window: self, p, residuals, borders: &[], parts: &mut Vec::new() })
    }

    /// The same sums, row by row of the lower triangle, for each of the parts that begin at the first sample and at
    /// the samples `borders` (ascending); residuals if requested.
    pub(crate) fn sums_of_parts(
        &self,
        p: &[f64],
        borders: &[usize],
        residuals: Option<&mut Vec<f64>>,
    ) -> Option<Vec<Vec<f64>>> {
        let mut parts = Vec::with_capacity(borders.len() + 1);
        let pass = Pass { window: self, p, residuals, borders, parts: &mut parts };
        let last = crate::numeric::dispatch(pass)?;
        parts.push(last.sums);
        Some(parts)
    }
}

/// Result of a pass over the samples.
pub(crate) struct Passed {
    /// Sums for the active parameters and, last, the residual: row by row of the lower triangle, for the part after
    /// the last border.
    pub(crate) sums: Vec<f64>,
    /// Index of the first sample at rest.
    pub(crate) at_rest: usize,
    /// Number of samples excluded because they are too close to a turning point.
    pub(crate) left_out: usize,
}

struct Pass<'a> {
    window: &'a Window<'a>,
    p: &'a [f64],
    residuals: Option<&'a mut Vec<f64>>,
    borders: &'a [usize],
    parts: &'a mut Vec<Vec<f64>>,
}

impl pulp::WithSimd for Pass<'_> {
    type Output = Option<Passed>;

    #[inline(always)]
    fn with_simd<S: Simd>(self, simd: S) -> Self::Output {
        let Pass { window, p, residuals, mut borders, parts } = self;
        let Window { time, origin, .. } = *window;
        if !(p[OMEGA] > 0.0 && p[OMEGA].is_finite()) {
            return None;
        }
        let mut turns = Turns::new(window, p);
        let sums = Products::new(window.active.len() + 1);
        let mut batch = Batch { sums, active: window.active, len: 0, left_out: 0.0, residuals };
        let mut half = HalfCycle::new(window, p, turns.common_lambda());
        let mut n = (p[PHASE] / PI).floor();
        let mut steps_left = MOST_STEPS[0] * time.len() + MOST_STEPS[1];
        let mut turn = turns.at(n, (n * PI - p[PHASE]) / p[OMEGA]);
        let (mut index, mut at_rest) = (0, time.len());
        while index < time.len() {
            let next = turns.at(n + 1.0, turn.time + PI / turn.omega);
            // A phase that does not advance is rejected; beyond 2^50 half cycles the count is no longer exact.
            if !(next.time > turn.time && next.amplitude.is_finite() && n.abs() < 1e15 && steps_left > 0) {
                return None;
            }
            let swing = turn.amplitude - p[X_F];
            // The spring no longer overcomes friction: at rest permanently.
            let rests = !(swing > 0.0 && next.amplitude + p[X_F] > 0.0);
            let end = if rests {
                at_rest = index;
                time.len()
            } else {
                index + count_before(&time[index..], origin + next.time)
            };
            if end > index {
                half.turn_to(window, p, &turn, &next, n, rests)?;
            }
            while index < end {
                let to = borders.first().map_or(end, |b| end.min(*b));
                half.add(simd, window, p, index..to, &mut batch);
                index = to;
                while let Some((_, others)) = borders.split_first().filter(|(b, _)| **b == index) {
                    batch.flush(simd);
                    parts.push(batch.sums.taken(simd));
                    borders = others;
                }
            }
            steps_left -= 1;
            n += 1.0;
            turn = next;
            if end == index
                && index < time.len()
                && !rests
                && let Some((far, count)) = cross_gap(&mut turns, &turn, n, p[X_F], time[index] - origin)
            {
                n += count;
                turn = far;
            }
        }
        batch.flush(simd);
        Some(Passed { sums: batch.sums.taken(simd), at_rest, left_out: batch.left_out as usize })
    }
}

/// A turning point in the same gap as `turn` (number `n`) but closer to the sample at `sample`, and the number of
/// half cycles between them; `None` if there are few or the motion comes to rest in between.
#[inline(never)]
fn cross_gap(turns: &mut Turns, turn: &Turn, n: f64, x_f: f64, sample: f64) -> Option<(Turn, f64)> {
    let left = (sample - turn.time) * turn.omega * FRAC_1_PI;
    if !(left > GAP) {
        return None;
    }
    // The frequency may change in between.
    let mut count = (0.5 * left).min(turns.most_in_one()).floor();
    while count > 1.0 {
        let mut beyond = turns.clone();
        let far = beyond.leap(n, turn, count);
        if far.amplitude > x_f && far.time > turn.time && far.time < sample {
            *turns = beyond;
            return Some((far, count));
        }
        count = (0.5 * count).floor();
    }
    None
}

/// Number of leading times below `limit`, found by doubling, because half cycles are short.
#[inline(always)]
fn count_before(time: &[f64], limit: f64) -> usize {
    let mut step = 8;
    while step < time.len() && time[step] < limit {
        step *= 2;
    }
    let end = step.min(time.len());
    let from = if step > 8 { step / 2 } else { 0 };
    from + time[from..end].partition_point(|&t| t < limit)
}

/// Coefficients of one row: `c0 + c1 f + c2 theta f + (c3 + c4 u) g`, with the time `u` since the turning point.
type Row = [f64; 5];
/// Coefficients of the [shape added by drag](drag) and of its slope.
type DragRow = [f64; 2];

/// One half cycle: the motion and the rows of its derivatives.
struct HalfCycle {
    /// `lambda` of all half cycles if they are equal, and `1/rho`.
    common: Option<[f64; 2]>,
    /// Whether drag is part of the model; if so, its shape times `bulge` is added to the motion.
    drags: bool,
    observable: Observable,
    /// Time of the turning point, s.
    begin: f64,
    omega: f64,
    /// Half the rate of change of the frequency.
    curve: f64,
    lambda: f64,
    /// `e^(lambda theta)` is the series at `part theta`, `part = lambda / 2^squarings`, squared `squarings` times.
    squarings: i32,
    part: f64,
    moving: bool,
    /// The motion is `level + height f`.
    level: f64,
    height: f64,
    /// For a velocity or an acceleration: the coefficients of `f` and `g`; the phase rate over `omega` at the turning
    /// point and its change with time; and the coefficient of `g` due to that change.
    parts: [f64; 2],
    rate: [f64; 2],
    bent: f64,
    bulge: f64,
    drag: drag::Shape,
    /// Rows of the active parameters, in their order.
    rows: [Row; COUNT],
    drag_rows: [DragRow; COUNT],
}

impl HalfCycle {
    /// An empty half cycle.
    #[inline(always)]
    fn new(window: &Window, p: &[f64], common_lambda: Option<f64>) -> Self {
        Self {
            common: common_lambda.map(|lambda| [lambda, (-PI * lambda).exp()]),
            drags: p[DRAG] != 0.0 || window.active.contains(&DRAG),
            observable: window.observable,
            begin: 0.0,
            omega: 0.0,
            curve: 0.0,
            lambda: 0.0,
            squarings: 0,
            part: 0.0,
            moving: false,
            level: 0.0,
            height: 0.0,
            parts: [0.0; 2],
            rate: [0.0; 2],
            bent: 0.0,
            bulge: 0.0,
            drag: drag::Shape::default(),
            rows: [[0.0; 5]; COUNT],
            drag_rows: [[0.0; 2]; COUNT],
        }
    }

    /// Sets the half cycle from turning point `n` to the next; `None` if the decay is too fast to be followed.
    #[inline(always)]
    fn turn_to(
        &mut self,
        window: &Window,
        p: &[f64],
        turn: &Turn,
        next: &Turn,
        n: f64,
        rests: bool,
    ) -> Option<()> {
        let sign = if (n as i64) % 2 == 0 { 1.0 } else { -1.0 };
        let motion = window.active.iter().copied().enumerate().filter(|(_, p)| *p < OFFSET);
        self.begin = window.origin + turn.time;
        self.moving = !rests;
        if rests {
            let level_sign = if window.models_rest_position { sign } else { 0.0 };
            for (k, parameter) in motion {
                self.rows[k] = [level_sign * turn.by[parameter], 0.0, 0.0, 0.0, 0.0];
            }
            self.drags = false;
            (self.level, self.height, self.bulge, self.bent) = (level_sign * turn.amplitude, 0.0, 0.0, 0.0);
            return Some(());
        }
        let x_f = p[X_F];
        // The swings at this turning point and at the next.
        let (swing, swing_after) = (turn.amplitude - x_f, next.amplitude + x_f);
        let mut follows_law = true;
        let [lambda, over_ratio] = self.common.unwrap_or_else(|| {
            let mut ratio = swing_after / swing;
            if swing < LAST_SWING * x_f {
                // The amplitude law is accurate to a small part of x_F, which may be all of the last swing: the ratio
                // of such small swings is bounded by that of viscous loss alone.
                let viscous = (-PI * p[DELTA] / p[OMEGA]).exp();
                let bounded = ratio.max(viscous / LAST_RATIO).min(viscous * LAST_RATIO);
                follows_law = bounded == ratio;
                ratio = bounded;
            }
            [ratio.ln() * FRAC_1_PI, 1.0 / ratio]
        });
        let mut reach = (PI * lambda).abs();
        if !(reach < MOST_DECREMENT) {
            return None;
        }
        self.lambda = lambda;
        (self.squarings, self.part) = (0, lambda);
        while reach > 0.0625 {
            reach *= 0.5;
            self.part *= 0.5;
            self.squarings += 1;
        }
        let over_length = 1.0 / (next.time - turn.time);
        if self.common.is_some() {
            self.omega = turn.omega;
        } else {
            // Half of the frequency change occurs before the middle, half after it. The phase lag due to drag is
            // constant within a half cycle.
            self.omega = PI * over_length + 0.5 * (turn.omega - next.omega);
            self.curve = (PI * over_length - self.omega) * over_length;
        }
        let spread = swing * (1.0 + lambda * lambda);
        let strength = drag::strength(p[DRAG], p[OMEGA]);
        // The middle of the half cycle.
        let middle = swing * swing_after;
        self.bulge = sign * strength * middle;
        let per_turn = sign * FRAC_1_PI;
        for (k, parameter) in motion {
            let direct = if parameter == X_F { 1.0 } else { 0.0 };
            let a = turn.by[parameter];
            let b = if follows_law { next.by[parameter] } else { (a - direct) / over_ratio - direct };
            // dx/dX = s (f - h), dx/dX' = s h/rho, dx/dx_F = s [1 - f + (1 + 1/rho) h] with
            // h = (theta f - g)/pi; dx/dtheta = -s (X - x_F)(1 + lambda²) g.
            let slide = (b * over_ratio - a + direct * (1.0 + over_ratio)) * per_turn;
            let (phase, change) =
                (turn.phase_by[parameter], next.phase_by[parameter] - turn.phase_by[parameter]);
            let turned = -sign * spread;
            self.rows[k] = [
                sign * direct,
                sign * (a - direct),
                slide,
                turned * phase - slide,
                turned * change * over_length,
            ];
            if self.drags {
                let by_middle = (a - direct) * swing_after + swing * (b + direct);
                let drag_row = &mut self.drag_rows[k];
                *drag_row = [sign * strength * by_middle, self.bulge * (phase + 0.5 * change)];
                if parameter == DRAG {
                    drag_row[0] += sign * drag::strength(1.0, p[OMEGA]) * middle;
                }
                if parameter == OMEGA {
                    drag_row[0] -= self.bulge / p[OMEGA];
                }
            }
        }
        (self.level, self.height) = (sign * x_f, sign * swing);
        if self.observable != Observable::Displacement {
            let length = next.time - turn.time;
            self.differentiate(window.active, p[OMEGA], self.omega + self.curve * length);
        }
        if self.drags {
            self.drag = drag::Shape::new(middle, [p[DELTA], p[DRAG]], p[OMEGA]);
        }
        Some(())
    }

    /// Converts rows of the displacement into rows of its derivative over `omega` to the same power, where the mean
    /// phase rate is `mean`. The change of the rate within the half cycle is included for the signal, but not for the
    /// derivatives with respect to parameters.
    #[inline(always)]
    fn differentiate(&mut self, active: &[usize], omega: f64, mean: f64) {
        let order = self.observable.order();
        let (lambda, kappa) = (self.lambda, 1.0 + self.lambda * self.lambda);
        // Coefficients of f, g, theta f and theta g.
        let by_phase = |mut parts: [f64; 4]| {
            for _ in 0..order {
                let [f, g, theta_f, theta_g] = parts;
                parts = [
                    g + theta_f,
                    2.0 * lambda * g + theta_g - kappa * f,
                    theta_g,
                    2.0 * lambda * theta_g - kappa * theta_f,
                ];
            }
            parts
        };
        let [f, g, ..] = by_phase([1.0, 0.0, 0.0, 0.0]);
        (self.level, self.parts) = (0.0, [f, g]);
        self.rate = [self.omega / omega, 2.0 * self.curve / omega];
        self.bent = if order == 2 { -kappa * self.rate[1] / omega } else { 0.0 };
        let scale = (mean / omega).powi(order);
        let per_omega = f64::from(order) / omega;
        for (k, parameter) in active.iter().copied().enumerate().filter(|(_, p)| *p < OFFSET) {
            let [_, f, theta_f, g, u_g] = self.rows[k];
            let mut parts = by_phase([f, g, theta_f, u_g / mean]);
            if parameter == OMEGA {
                parts[0] -= per_omega * self.height * self.parts[0];
                parts[1] -= per_omega * self.height * self.parts[1];
                self.drag_rows[k][0] -= per_omega * self.bulge;
            }
            let [f, g, theta_f, theta_g] = parts.map(|part| scale * part);
            self.rows[k] = [0.0, f, theta_f, g, theta_g * mean];
            self.drag_rows[k] = self.drag_rows[k].map(|part| scale * part);
        }
    }

    /// The signal of a velocity or an acceleration, at the time `u` after the turning point.
    #[inline(always)]
    fn derivative<S: Simd>(&self, simd: S, u: S::f64s, basis: &Basis<S>) -> S::f64s {
        let splat = |v: f64| simd.splat_f64s(v);
        let [f, g] = [splat(self.parts[0] * self.height), splat(self.parts[1] * self.height)];
        let rate = simd.mul_add_e_f64s(splat(self.rate[1]), u, splat(self.rate[0]));
        let mut x = simd.mul_add_e_f64s(f, basis.f, simd.mul_f64s(g, basis.g));
        x = simd.mul_add_e_f64s(splat(self.bulge), basis.shape, x);
        for _ in 0..self.observable.order() {
            x = simd.mul_f64s(x, rate);
        }
        simd.mul_add_e_f64s(splat(self.bent * self.height), basis.g, x)
    }

    /// Adds the rows of the samples of this half cycle.
    #[inline(always)]
    fn add<S: Simd>(
        &self,
        simd: S,
        window: &Window,
        p: &[f64],
        range: std::ops::Range<usize>,
        batch: &mut Batch,
    ) {
        let mut first = range.start;
        while first < range.end {
            let room = (WIDTH - batch.len) / LANES * LANES;
            if room == 0 {
                batch.flush(simd);
                continue;
            }
            let count = (range.end - first).min(room);
            if self.drags {
                self.piece::<S, true>(simd, window, p, first..first + count, batch);
            } else {
                self.piece::<S, false>(simd, window, p, first..first + count, batch);
            }
            first += count;
        }
    }

    /// Computes a piece register by register. Lanes beyond the last sample are overwritten by the next piece, or
    /// cleared.
    #[inline(always)]
    fn piece<S: Simd, const DRAGS: bool>(
        &self,
        simd: S,
        window: &Window,
        p: &[f64],
        range: std::ops::Range<usize>,
        batch: &mut Batch,
    ) {
        let splat = |v: f64| simd.splat_f64s(v);
        let begin = splat(self.begin);
        // Time over the window, for the slope and curvature of the offset.
        let over = splat(1.0 / window.duration.max(f64::MIN_POSITIVE));
        let since = splat(self.begin - window.origin);
        let level = splat(self.level + p[OFFSET]);
        let (height, slope, bow) = (splat(self.height), splat(p[OFFSET + 1]), splat(p[OFFSET + 2]));
        let direct = self.observable == Observable::Displacement;
        let tilted = p[OFFSET + 1] != 0.0 || p[OFFSET + 2] != 0.0;
        let (time, signal) = (&window.time[range.clone()], &window.signal[range]);
        let guarded = self.moving && window.guard > 0.0;
        let Batch { sums, active, len, left_out, .. } = batch;
        let mut at = *len;
        let rows = &mut sums.rows[..=active.len()];
        for (t, y, weight) in wide::Pairs::new(simd, time, signal) {
            let u = simd.sub_f64s(t, begin);
            let v = simd.mul_f64s(simd.add_f64s(u, since), over);
            let basis = if self.moving { self.basis::<S, DRAGS>(simd, u) } else { Basis::rest(simd) };
            let mut r = simd.sub_f64s(y, level);
            if direct {
                r = simd.negate_mul_add_e_f64s(height, basis.f, r);
            } else {
                r = simd.sub_f64s(r, self.derivative(simd, u, &basis));
            }
            if tilted {
                r = simd.negate_mul_add_e_f64s(v, simd.mul_add_e_f64s(bow, v, slope), r);
            }
            if DRAGS && direct {
                r = simd.negate_mul_add_e_f64s(splat(self.bulge), basis.shape, r);
            }
            let counts = if guarded { self.off_the_turns(simd, window.guard, u) } else { splat(1.0) };
            if guarded {
                let left = simd.negate_mul_add_e_f64s(counts, weight, weight);
                *left_out += simd.reduce_sum_f64s(left);
                r = simd.mul_f64s(counts, r);
            }
            put(simd, &mut rows[active.len()], at, r);
            for (k, &parameter) in active.iter().enumerate() {
                let value = match parameter.checked_sub(OFFSET) {
                    None => {
                        let row = basis.combine(simd, u, &self.rows[k]);
                        if DRAGS { basis.add_drag(simd, &self.drag_rows[k], row) } else { row }
                    }
                    Some(0) => splat(1.0),
                    Some(1) => v,
                    Some(_) => simd.mul_f64s(v, v),
                };
                let value = if guarded { simd.mul_f64s(counts, value) } else { value };
                put(simd, &mut rows[k], at, value);
            }
            at += S::F64_LANES;
        }
        *len += time.len();
    }

    /// One, or zero if the phase is within `guard` of a turning point.
    #[inline(always)]
    fn off_the_turns<S: Simd>(&self, simd: S, guard: f64, u: S::f64s) -> S::f64s {
        let splat = |v: f64| simd.splat_f64s(v);
        let theta = simd.mul_f64s(u, simd.mul_add_e_f64s(splat(self.curve), u, splat(self.omega)));
        let off = simd.abs_f64s(simd.sub_f64s(theta, splat(FRAC_PI_2)));
        let near = simd.less_than_f64s(splat(FRAC_PI_2 - guard), off);
        simd.select_f64s(near, splat(0.0), splat(1.0))
    }

    /// The functions of which all derivatives are combinations, at times since the turning point.
    #[inline(always)]
    fn basis<S: Simd, const DRAGS: bool>(&self, simd: S, u: S::f64s) -> Basis<S> {
        let splat = |v: f64| simd.splat_f64s(v);
        let theta = simd.mul_f64s(u, simd.mul_add_e_f64s(splat(self.curve), u, splat(self.omega)));
        // cos theta = -sin(theta - pi/2), sin theta = cos(theta - pi/2)
        let (s, sin) = wide::half_turn(simd, simd.add_f64s(theta, splat(-FRAC_PI_2)));
        let mut e = wide::horner(simd, simd.mul_f64s(theta, splat(self.part)), &EXPONENTIAL);
        for _ in 0..self.squarings {
            e = simd.mul_f64s(e, e);
        }
        let g = simd.mul_f64s(e, sin);
        let f = simd.neg_f64s(simd.mul_add_e_f64s(e, s, simd.mul_f64s(splat(self.lambda), g)));
        let zero = splat(0.0);
        let (shape, slope) = if DRAGS {
            self.drag.derivative(simd, self.observable.order(), theta, s, sin)
        } else {
            (zero, zero)
        };
        Basis { f, theta_f: simd.mul_f64s(theta, f), g, shape, slope }
    }
}

/// Writes a register into a row.
#[inline(always)]
fn put<S: Simd>(_: S, row: &mut [f64; WIDTH], at: usize, value: S::f64s) {
    S::as_mut_simd_f64s(&mut row[at..at + S::F64_LANES]).0[0] = value;
}

/// Clears a row from an index on, register by register: too few places to be worth a function call.
#[inline(always)]
fn clear_from(row: &mut [f64], from: usize) {
    let (pieces, _) = row.as_chunks_mut::<LANES>();
    let first = from / LANES;
    for (piece, at) in pieces[first..].iter_mut().zip((first * LANES..).step_by(LANES)) {
        for (k, value) in piece.iter_mut().enumerate() {
            *value = if at + k < from { *value } else { 0.0 };
        }
    }
}

/// `f`, `theta f` and `g` of some samples, the change of the motion by drag, and its slope with respect to the phase.
#[derive(Clone, Copy)]
struct Basis<S: Simd> {
    f: S::f64s,
    theta_f: S::f64s,
    g: S::f64s,
    shape: S::f64s,
    slope: S::f64s,
}

impl<S: Simd> Basis<S> {
    /// The functions at rest.
    #[inline(always)]
    fn rest(simd: S) -> Self {
        let zero = simd.splat_f64s(0.0);
        Self { f: simd.splat_f64s(1.0), theta_f: zero, g: zero, shape: zero, slope: zero }
    }

    #[inline(always)]
    fn combine(&self, simd: S, u: S::f64s, coefficients: &Row) -> S::f64s {
        let c = |k: usize| simd.splat_f64s(coefficients[k]);
        let x = simd.mul_add_e_f64s(c(1), self.f, simd.mul_add_e_f64s(c(2), self.theta_f, c(0)));
        simd.mul_add_e_f64s(simd.mul_add_e_f64s(c(4), u, c(3)), self.g, x)
    }

    #[inline(always)]
    fn add_drag(&self, simd: S, coefficients: &DragRow, row: S::f64s) -> S::f64s {
        let [c0, c1] = [simd.splat_f64s(coefficients[0]), simd.splat_f64s(coefficients[1])];
        simd.mul_add_e_f64s(c0, self.shape, simd.mul_add_e_f64s(c1, self.slope, row))
    }
}

/// Rows waiting for their products.
struct Batch<'a> {
    sums: Products,
    active: &'a [usize],
    len: usize,
    left_out: f64,
    residuals: Option<&'a mut Vec<f64>>,
}

impl Batch<'_> {
    #[inline(always)]
    fn flush<S: Simd>(&mut self, simd: S) {
        let rows = self.active.len() + 1;
        if let Some(list) = &mut self.residuals {
            list.extend_from_slice(&self.sums.rows[rows - 1][..self.len]);
        }
        let few = self.len <= WIDTH / 2;
        let end = if few { WIDTH / 2 } else { WIDTH };
        for row in &mut self.sums.rows[..rows] {
            clear_from(&mut row[..end], self.len);
        }
        if few {
            self.sums.add_halves(simd);
        } else {
            self.sums.add(simd);
        }
        self.len = 0;
    }
}
