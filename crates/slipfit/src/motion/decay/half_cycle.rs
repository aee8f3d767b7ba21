//! The half-cycle kernel: a free decay with its derivatives against the samples of a record.
//!
//! The motion runs from turning point to turning point; between two of them, of amplitudes `X`
//! and `X'`, it is a damped cosine about `±x_F`. With the phase `theta` since the turn and
//! `ln rho = pi lambda`, `rho = (X' + x_F)/(X - x_F)`,
//!
//! ```text
//! x = s [x_F + (X - x_F) f],   f = e^(lambda theta) (cos theta - lambda sin theta)
//! ```
//!
//! which is the closed form where frequency and decay rate are constant, and joins the turning
//! points smoothly where they change slowly; quadratic drag adds [its own shape](super::drag). All
//! derivatives are combinations of `f`, `theta f`, `g = e^(lambda theta) sin theta` and that shape. One pass gives the sums of a least-squares step; of the
//! samples nothing is stored.

use super::drag;
use super::parameters::{DELTA, DRAG, OFFSET, OMEGA, PHASE, X_F};
use super::turns::{Turn, Turns};
use super::window::Window;
use crate::numeric::products::{Products, WIDTH};
use crate::numeric::trig::{has_fused, inverse_factorials};
use crate::numeric::wide;
use pulp::Simd;
use std::f64::consts::{FRAC_PI_2, PI};

/// Rows of the sums: the active parameters, the residual last.
pub(crate) type Sums = Products<{ super::parameters::COUNT + 1 }>;

/// Numbers computed together.
const LANES: usize = 8;
/// `1/k!`: the terms of `e^x` that count for `|x| <= 1/16`.
const EXPONENTIAL: [f64; 10] = inverse_factorials(0, 1);
/// No half cycle changes its swing by more than `e` to this power.
const MOST_DECREMENT: f64 = 700.0;

impl Window<'_> {
    /// Products of all active derivatives and the residual, summed over the samples, and the
    /// first sample at rest. `None` where the model does not exist.
    pub(crate) fn sums(&self, p: &[f64], residuals: Option<&mut Vec<f64>>) -> Option<(Sums, usize)> {
        pulp::Arch::new().dispatch(Pass { window: self, p, residuals })
    }
}

struct Pass<'a> {
    window: &'a Window<'a>,
    p: &'a [f64],
    residuals: Option<&'a mut Vec<f64>>,
}

impl pulp::WithSimd for Pass<'_> {
    type Output = Option<(Sums, usize)>;

    #[inline(always)]
    fn with_simd<S: Simd>(self, simd: S) -> Self::Output {
        if const { has_fused::<S>() } { self.sums::<S, true>(simd) } else { self.sums::<S, false>(simd) }
    }
}

impl Pass<'_> {
    #[inline(always)]
    fn sums<S: Simd, const FUSED: bool>(self, simd: S) -> Option<(Sums, usize)> {
        let Pass { window, p, residuals } = self;
        let Window { time, origin, .. } = *window;
        if !(p[OMEGA] > 0.0 && p[OMEGA].is_finite()) {
            return None;
        }
        let mut turns = Turns::new(window, p);
        let none = [0.0; WIDTH];
        let mut batch = Batch {
            sums: Products::new(window.active.len() + 1),
            active: window.active,
            len: 0,
            basis: Basis { u: none, f: none, theta_f: none, g: none, shape: none, slope: none },
            residuals,
        };
        let mut n = (p[PHASE] / PI).floor();
        let mut turn = turns.at(n, (n * PI - p[PHASE]) / p[OMEGA]);
        let (mut index, mut at_rest) = (0, time.len());
        while index < time.len() {
            let next = turns.at(n + 1.0, turn.time + PI / turn.omega);
            // A phase that does not advance is no motion; beyond 2^50 half cycles counting them
            // loses its meaning.
            if !(next.time > turn.time && next.amplitude.is_finite() && n.abs() < 1e15) {
                return None;
            }
            let swing = turn.amplitude - p[X_F];
            // The spring no longer overcomes the friction: at rest for good.
            let rests = !(swing > 0.0 && next.amplitude + p[X_F] > 0.0);
            let end = if rests {
                at_rest = index;
                time.len()
            } else {
                index + count_before(&time[index..], origin + next.time)
            };
            if end > index {
                let part = HalfCycle::new(window, p, &turn, &next, n, rests)?;
                part.add::<S, FUSED>(simd, window, p, index..end, &mut batch);
            }
            index = end;
            n += 1.0;
            turn = next;
        }
        batch.flush::<FUSED>();
        Some((batch.sums, at_rest))
    }
}

/// Number of leading times below `limit`, found by doubling: half cycles are short.
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

/// Coefficients of one row: `c0 + c1 f + c2 theta f + (c3 + c4 u) g`, `u` the time since the turn.
type Row = [f64; 5];
/// And of the [shape that drag adds](drag) and its slope.
type DragRow = [f64; 2];

/// One half cycle: the motion and the rows of its derivatives.
struct HalfCycle {
    /// Time of the turn, s.
    begin: f64,
    omega: f64,
    /// Half the change of frequency.
    curve: f64,
    lambda: f64,
    /// `e^(lambda theta)` is the series at `lambda theta / 2^squarings`, squared as often.
    squarings: u32,
    moving: bool,
    /// The motion is `level + height f`.
    level: f64,
    height: f64,
    rows: [Row; OFFSET],
    /// Whether drag is part of the model: its shape then times `bulge` is part of the motion.
    drags: bool,
    bulge: f64,
    drag: drag::Shape,
    drag_rows: [DragRow; OFFSET],
}

impl HalfCycle {
    /// From turning point `n` to the next; `None` where it decays too fast to be followed.
    #[inline(always)]
    fn new(window: &Window, p: &[f64], turn: &Turn, next: &Turn, n: f64, rests: bool) -> Option<Self> {
        let sign = if (0.5 * n).fract() == 0.0 { 1.0 } else { -1.0 };
        let mut rows = [[0.0; 5]; OFFSET];
        let mut drag_rows = [[0.0; 2]; OFFSET];
        let drags = p[DRAG] != 0.0 || window.active.contains(&DRAG);
        let begin = window.origin + turn.time;
        if rests {
            let seen = if window.rest_tells { sign } else { 0.0 };
            for (row, by) in rows.iter_mut().zip(turn.by) {
                row[0] = seen * by;
            }
            let level = seen * turn.amplitude;
            let (omega, lambda) = (turn.omega, 0.0);
            return Some(Self {
                begin,
                omega,
                curve: 0.0,
                lambda,
                squarings: 0,
                moving: false,
                level,
                height: 0.0,
                rows,
                drags: false,
                bulge: 0.0,
                drag: drag::Shape::default(),
                drag_rows,
            });
        }
        let x_f = p[X_F];
        let swing = turn.amplitude - x_f;
        let ratio = (next.amplitude + x_f) / swing;
        let lambda = ratio.ln() / PI;
        let mut reach = (PI * lambda).abs();
        if !(reach < MOST_DECREMENT) {
            return None;
        }
        let mut squarings = 0;
        while reach > 0.0625 {
            reach *= 0.5;
            squarings += 1;
        }
        let length = next.time - turn.time;
        // What drag slows the phase by is constant within a half cycle.
        let slowing = if drags { 0.5 * (turn.omega + next.omega) - PI / length } else { 0.0 };
        let omega = turn.omega - slowing;
        let curve = (PI - omega * length) / (length * length);
        let over_ratio = 1.0 / ratio;
        let spread = swing * (1.0 + lambda * lambda);
        let strength = drag::strength(p[DRAG], p[OMEGA]);
        // Both swings, that of the turn and that of the next: the middle of the half cycle.
        let (swing_after, middle) = (next.amplitude + x_f, swing * (next.amplitude + x_f));
        let bulge = sign * strength * middle;
        for parameter in window.active.iter().copied().filter(|p| *p < OFFSET) {
            let row = &mut rows[parameter];
            let (a, b) = (turn.by[parameter], next.by[parameter]);
            let direct = if parameter == X_F { 1.0 } else { 0.0 };
            // dx/dX = s (f - h), dx/dX' = s h/rho, dx/dx_F = s [1 - f + (1 + 1/rho) h] with
            // h = (theta f - g)/pi; dx/dtheta = -s (X - x_F)(1 + lambda²) g.
            let slide = (b * over_ratio - a + direct * (1.0 + over_ratio)) * sign / PI;
            *row = [sign * direct, sign * (a - direct), slide, -slide, 0.0];
            let (phase, change) =
                (turn.phase_by[parameter], next.phase_by[parameter] - turn.phase_by[parameter]);
            row[3] -= sign * spread * phase;
            row[4] = -sign * spread * change / length;
            if drags {
                let by_middle = (a - direct) * swing_after + swing * (b + direct);
                drag_rows[parameter] = [sign * strength * by_middle, bulge * (phase + 0.5 * change)];
            }
        }
        if drags {
            drag_rows[DRAG][0] += sign * drag::strength(1.0, p[OMEGA]) * middle;
            drag_rows[OMEGA][0] -= bulge / p[OMEGA];
        }
        let (level, height) = (sign * x_f, sign * swing);
        Some(Self {
            begin,
            omega,
            curve,
            lambda,
            squarings,
            moving: true,
            level,
            height,
            rows,
            drags,
            bulge,
            drag: drag::Shape::new(middle, [p[DELTA], p[DRAG]], p[OMEGA]),
            drag_rows,
        })
    }

    /// Adds the rows of its samples.
    #[inline(always)]
    fn add<S: Simd, const FUSED: bool>(
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
                batch.flush::<FUSED>();
                continue;
            }
            let count = (range.end - first).min(room);
            self.piece(simd, window, p, first..first + count, batch);
            first += count;
        }
    }

    #[inline(always)]
    fn piece<S: Simd>(
        &self,
        simd: S,
        window: &Window,
        p: &[f64],
        range: std::ops::Range<usize>,
        batch: &mut Batch,
    ) {
        let (m, at) = (range.len(), batch.len);
        let whole = m.next_multiple_of(LANES);
        let Batch { sums, active, basis, .. } = batch;
        let residual = &mut sums.rows[active.len()][at..at + whole];
        // Lanes beyond the last sample are overwritten by the next piece, or cleared.
        basis.u[..m].copy_from_slice(&window.time[range.clone()]);
        residual[..m].copy_from_slice(&window.signal[range]);
        self.fill(simd, basis, whole);
        // Time over the window: of the offset's slope and curvature.
        let over_duration = 1.0 / window.duration.max(f64::MIN_POSITIVE);
        let splat = |v: f64| simd.splat_f64s(v);
        let (since, over) = (splat(self.begin - window.origin), splat(over_duration));
        let level = splat(self.level + p[OFFSET]);
        let (height, slope, bow) = (splat(self.height), splat(p[OFFSET + 1]), splat(p[OFFSET + 2]));
        let tilted = p[OFFSET + 1] != 0.0 || p[OFFSET + 2] != 0.0;
        let (residual, _) = S::as_mut_simd_f64s(residual);
        let (u, _) = S::as_simd_f64s(&basis.u[..whole]);
        let (f, _) = S::as_simd_f64s(&basis.f[..whole]);
        for ((r, f), u) in residual.iter_mut().zip(f).zip(u) {
            *r = simd.negate_mul_add_e_f64s(height, *f, simd.sub_f64s(*r, level));
            if tilted {
                let v = simd.mul_f64s(simd.add_f64s(*u, since), over);
                *r = simd.negate_mul_add_e_f64s(v, simd.mul_add_e_f64s(bow, v, slope), *r);
            }
        }
        if self.drags {
            let bulge = splat(self.bulge);
            for (r, shape) in residual.iter_mut().zip(S::as_simd_f64s(&basis.shape[..whole]).0) {
                *r = simd.negate_mul_add_e_f64s(bulge, *shape, *r);
            }
        }
        for (row, &parameter) in sums.rows.iter_mut().zip(*active) {
            let row = &mut row[at..at + whole];
            match parameter.checked_sub(OFFSET) {
                None => {
                    basis.combine(simd, &self.rows[parameter], row);
                    if self.drags {
                        basis.add_drag(simd, &self.drag_rows[parameter], row);
                    }
                }
                Some(0) => row.fill(1.0),
                Some(power) => {
                    for (r, u) in S::as_mut_simd_f64s(row).0.iter_mut().zip(u) {
                        let v = simd.mul_f64s(simd.add_f64s(*u, since), over);
                        *r = if power == 1 { v } else { simd.mul_f64s(v, v) };
                    }
                }
            }
        }
        batch.len += m;
    }

    /// The functions all derivatives are made of, at the times in `basis.u`, which become times
    /// since the turn.
    #[inline(always)]
    fn fill<S: Simd>(&self, simd: S, basis: &mut Basis, whole: usize) {
        let splat = |v: f64| simd.splat_f64s(v);
        let (u, _) = S::as_mut_simd_f64s(&mut basis.u[..whole]);
        let (f, _) = S::as_mut_simd_f64s(&mut basis.f[..whole]);
        let (theta_f, _) = S::as_mut_simd_f64s(&mut basis.theta_f[..whole]);
        let (g, _) = S::as_mut_simd_f64s(&mut basis.g[..whole]);
        let (shape, _) = S::as_mut_simd_f64s(&mut basis.shape[..whole]);
        let (slope, _) = S::as_mut_simd_f64s(&mut basis.slope[..whole]);
        let begin = splat(self.begin);
        let (curve, omega, lambda) = (splat(self.curve), splat(self.omega), splat(self.lambda));
        let part = splat(self.lambda * 0.5f64.powi(self.squarings as i32));
        let quarter = splat(-FRAC_PI_2);
        for (((u, f), (theta_f, g)), (shape, slope)) in
            u.iter_mut().zip(f).zip(theta_f.iter_mut().zip(g)).zip(shape.iter_mut().zip(slope))
        {
            *u = simd.sub_f64s(*u, begin);
            if !self.moving {
                (*f, *theta_f, *g) = (splat(1.0), splat(0.0), splat(0.0));
                continue;
            }
            let theta = simd.mul_f64s(*u, simd.mul_add_e_f64s(curve, *u, omega));
            // cos theta = -sin(theta - pi/2), sin theta = cos(theta - pi/2)
            let (s, sin) = wide::half_turn(simd, simd.add_f64s(theta, quarter));
            let mut e = wide::horner(simd, simd.mul_f64s(theta, part), &EXPONENTIAL);
            for _ in 0..self.squarings {
                e = simd.mul_f64s(e, e);
            }
            *g = simd.mul_f64s(e, sin);
            *f = simd.neg_f64s(simd.mul_add_e_f64s(e, s, simd.mul_f64s(lambda, *g)));
            *theta_f = simd.mul_f64s(theta, *f);
            if self.drags {
                (*shape, *slope) = self.drag.at(simd, theta, s, sin);
            }
        }
    }
}

/// `u`, `f`, `theta f` and `g` at the samples of a piece.
struct Basis {
    u: [f64; WIDTH],
    f: [f64; WIDTH],
    theta_f: [f64; WIDTH],
    g: [f64; WIDTH],
    /// What drag adds, and its slope by the phase; filled where drag is part of the model.
    shape: [f64; WIDTH],
    slope: [f64; WIDTH],
}

impl Basis {
    #[inline(always)]
    fn combine<S: Simd>(&self, simd: S, coefficients: &Row, row: &mut [f64]) {
        let [c0, c1, c2, c3, c4] = coefficients.map(|c| simd.splat_f64s(c));
        let whole = row.len();
        let (row, _) = S::as_mut_simd_f64s(row);
        let (u, _) = S::as_simd_f64s(&self.u[..whole]);
        let (f, _) = S::as_simd_f64s(&self.f[..whole]);
        let (theta_f, _) = S::as_simd_f64s(&self.theta_f[..whole]);
        let (g, _) = S::as_simd_f64s(&self.g[..whole]);
        for ((row, u), (f, (theta_f, g))) in row.iter_mut().zip(u).zip(f.iter().zip(theta_f.iter().zip(g))) {
            let x = simd.mul_add_e_f64s(c1, *f, simd.mul_add_e_f64s(c2, *theta_f, c0));
            *row = simd.mul_add_e_f64s(simd.mul_add_e_f64s(c4, *u, c3), *g, x);
        }
    }

    #[inline(always)]
    fn add_drag<S: Simd>(&self, simd: S, coefficients: &DragRow, row: &mut [f64]) {
        let [c0, c1] = coefficients.map(|c| simd.splat_f64s(c));
        let whole = row.len();
        let (shape, _) = S::as_simd_f64s(&self.shape[..whole]);
        let (slope, _) = S::as_simd_f64s(&self.slope[..whole]);
        for (row, (shape, slope)) in S::as_mut_simd_f64s(row).0.iter_mut().zip(shape.iter().zip(slope)) {
            *row = simd.mul_add_e_f64s(c0, *shape, simd.mul_add_e_f64s(c1, *slope, *row));
        }
    }
}

/// Rows waiting for their products.
struct Batch<'a> {
    sums: Sums,
    active: &'a [usize],
    len: usize,
    basis: Basis,
    residuals: Option<&'a mut Vec<f64>>,
}

impl Batch<'_> {
    #[inline(always)]
    fn flush<const FUSED: bool>(&mut self) {
        let rows = self.active.len() + 1;
        if let Some(list) = &mut self.residuals {
            list.extend_from_slice(&self.sums.rows[rows - 1][..self.len]);
        }
        for row in &mut self.sums.rows[..rows] {
            row[self.len..].fill(0.0);
        }
        self.sums.add::<FUSED>();
        self.len = 0;
    }
}
