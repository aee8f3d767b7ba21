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

use super::amplitude::sliding_gain;
use super::drag::{self, Slowing};
use super::parameters::{BEND, CHIRP, DELTA, DRAG, OFFSET, OMEGA, PHASE, X_F, by_parameters, law_of};
use super::path::{AmplitudePath, CARRIED};
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

/// Integral of the squared amplitude along a reference decay, for the backbone.
#[derive(Debug, Clone, Default)]
pub(crate) struct Bend {
    /// Even spacing of the knots, s.
    step: f64,
    /// Integral and its rate at the knots.
    knots: Vec<(f64, f64)>,
}

impl Bend {
    /// From an amplitude law over `[0, duration]`.
    pub(crate) fn along(amplitude: impl Fn(f64) -> f64, duration: f64) -> Self {
        let count = 512;
        let step = duration / (count - 1) as f64;
        let square = |t: f64| amplitude(t).powi(2);
        let mut sum = 0.0;
        let mut knots = Vec::with_capacity(count);
        for i in 0..count {
            let t = i as f64 * step;
            if i > 0 {
                sum += step / 6.0 * (square(t - step) + 4.0 * square(t - 0.5 * step) + square(t));
            }
            knots.push((sum, square(t)));
        }
        Self { step, knots }
    }

    /// Integral and rate at a time, extended with the end rates.
    #[inline(always)]
    pub(crate) fn at(&self, t: f64) -> (f64, f64) {
        let last = self.knots.len() - 1;
        let i = ((t / self.step).max(0.0) as usize).min(last - 1);
        let ((p, u), (q, v)) = (self.knots[i], self.knots[i + 1]);
        let d = t - i as f64 * self.step;
        if d < 0.0 {
            return (p + u * d, u);
        }
        let e = d - self.step;
        if e > 0.0 {
            return (q + v * e, v);
        }
        let h = self.step;
        let slope = (q - p) / h;
        let a = (slope - u) / h;
        let b = (u + v - 2.0 * slope) / (h * h);
        (p + d * (u + d * (a + b * e)), u + 2.0 * a * d + b * (2.0 * d * e + d * d))
    }
}

/// Samples of a window and the shape of the model.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Window<'a> {
    /// s, never decreasing.
    pub(crate) time: &'a [f64],
    pub(crate) signal: &'a [f64],
    /// Time the parameters refer to, s.
    pub(crate) origin: f64,
    pub(crate) duration: f64,
    /// Shape of the backbone; `None` leaves [`BEND`] without effect.
    pub(crate) bend: Option<&'a Bend>,
    /// Whether the place of rest is part of the model; where not, the model is zero there.
    pub(crate) rest_tells: bool,
    /// Parameters whose derivatives are wanted.
    pub(crate) active: &'a [usize],
}

impl Window<'_> {
    /// Phase and its rate `t` after the origin, and the shape functions of the phase parameters.
    #[inline(always)]
    pub(crate) fn phase(&self, p: &[f64], t: f64) -> (f64, f64, [f64; 4]) {
        let (i, r) = self.bend.map_or((0.0, 0.0), |b| b.at(t));
        (
            p[PHASE] + p[OMEGA] * t + p[BEND] * i + 0.5 * p[CHIRP] * t * (t - self.duration),
            p[OMEGA] + p[BEND] * r + p[CHIRP] * (t - 0.5 * self.duration),
            [1.0, t, i, 0.5 * t * (t - self.duration)],
        )
    }

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

/// A turning point with everything its half cycles need.
#[derive(Clone, Copy)]
struct Turn {
    time: f64,
    /// Rate of the phase but for drag.
    omega: f64,
    amplitude: f64,
    /// Derivatives of the phase by all parameters of losses and phase.
    phase_by: [f64; OFFSET],
    /// Derivatives of the amplitude by all loss and phase parameters.
    by: [f64; OFFSET],
}

/// The turning points one after the other.
struct Turns<'a> {
    window: &'a Window<'a>,
    p: &'a [f64],
    gain: [f64; 3],
    path: AmplitudePath,
    /// Time of `path`.
    now: f64,
    /// Phase that drag has cost until now, and its derivatives by amplitude and losses.
    lag: f64,
    lag_by: [f64; CARRIED],
}

impl<'a> Turns<'a> {
    #[inline(always)]
    fn new(window: &'a Window<'a>, p: &'a [f64]) -> Self {
        // Relative frequency shift per A², which also changes the loss terms.
        let backbone = if window.bend.is_some() { [p[BEND] / p[OMEGA], 0.0] } else { [0.0; 2] };
        let further = window.active.iter().any(|k| (DRAG + 1..PHASE).contains(k));
        let path = AmplitudePath::new(law_of(p, p[OMEGA]), backbone).with_further(further);
        Self {
            window,
            p,
            gain: sliding_gain(p[DELTA], p[OMEGA]),
            path,
            now: 0.0,
            lag: 0.0,
            lag_by: [0.0; CARRIED],
        }
    }

    /// Turning point `n`, the one after the last asked for, near `guess`.
    #[inline(always)]
    fn at(&mut self, n: f64, guess: f64) -> Turn {
        let p = self.p;
        let slowing = self.slowing(guess);
        let time = self.turn_time(n, guess, slowing.rate);
        let (before, passed) = (self.path.by, time - self.now);
        self.path.advance(passed);
        self.now = time;
        let mut by = [0.0; OFFSET];
        by[..CARRIED].copy_from_slice(&by_parameters(self.path.by, p, &self.gain));
        if slowing != Slowing::default() {
            self.lag += slowing.rate * passed;
            let before = by_parameters(before, p, &self.gain);
            for ((lag, before), after) in self.lag_by.iter_mut().zip(before).zip(by) {
                *lag += slowing.by_amplitude * 0.5 * (before + after) * passed;
            }
            self.lag_by[DELTA] += slowing.by_decay * passed;
            self.lag_by[DRAG] += slowing.by_drag * passed;
        }
        let (_, omega, shapes) = self.window.phase(p, time);
        let mut phase_by = [0.0; OFFSET];
        phase_by[PHASE..].copy_from_slice(&shapes);
        for (by, lag) in phase_by.iter_mut().zip(self.lag_by) {
            *by = -lag;
        }
        phase_by[OMEGA] += self.lag / p[OMEGA];
        // A later phase moves the turn: dX/dp = rate S/omega; and a0 depends on omega.
        let rate = self.path.rate() / (omega - slowing.rate);
        for (by, phase_by) in by.iter_mut().zip(phase_by) {
            *by += rate * phase_by;
        }
        by[OMEGA] += self.path.by[X_F] * p[X_F] * self.gain[2];
        Turn { time, omega, amplitude: self.path.amplitude, phase_by, by }
    }

    /// How much slower drag makes the phase run on the way to the turn near `guess`, with its derivatives.
    #[inline(always)]
    fn slowing(&self, guess: f64) -> Slowing {
        let p = self.p;
        if p[DRAG] == 0.0 && !self.window.active.contains(&DRAG) {
            return Slowing::default();
        }
        let halfway = self.path.amplitude - 0.5 * (guess - self.now) * self.path.rate();
        Slowing::new(halfway, [p[DELTA], p[DRAG]], p[OMEGA])
    }

    /// Time at which the phase reaches `n pi`, from a guess.
    #[inline(never)]
    fn turn_time(&self, n: f64, guess: f64, slowing: f64) -> f64 {
        let mut t = guess;
        for _ in 0..8 {
            let (phase, omega, _) = self.window.phase(self.p, t);
            let (phase, omega) = (phase - self.lag - slowing * (t - self.now), omega - slowing);
            let step = (n * PI - phase) / omega;
            t += step;
            if step.abs() * omega < 1e-12 * (1.0 + n.abs()) {
                break;
            }
        }
        t
    }
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
