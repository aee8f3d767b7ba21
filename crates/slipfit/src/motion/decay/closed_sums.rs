//! Normal equations of the exact motion under viscous and sliding friction, accumulated half cycle by half cycle.
//!
//! The general [half-cycle kernel](super::half_cycle), for every loss and disturbance, takes two to four times as
//! long.

use super::amplitude::{exp_share as phi, sliding_gain};
use crate::numeric::wide;
use pulp::Simd;
use std::f64::consts::{FRAC_PI_2, PI};

/// Computes the normal equations at the parameters `p`.
pub(crate) struct Pass<'a> {
    pub(crate) time: &'a [f64],
    pub(crate) signal: &'a [f64],
    pub(crate) origin: f64,
    pub(crate) p: &'a [f64; 6],
    pub(crate) stop: Stop,
    /// Whether the rest position is part of the model; otherwise the model equals the offset there.
    pub(crate) models_rest_position: bool,
    /// Samples at which a new part begins, ascending, and the sums of all parts before the last.
    pub(crate) borders: &'a [usize],
    pub(crate) parts: &'a mut Vec<ClosedSums>,
}

/// How the motion ends.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) enum Stop {
    /// It does not: the law continues past zero, smooth in every parameter.
    Never,
    /// Where friction holds the mass.
    Friction,
    /// At the turning point with this number, whether or not friction holds the mass there: smooth in every
    /// parameter.
    Turn(f64),
}

impl Stop {
    #[inline(always)]
    fn is_at(self, n: f64, swing: f64) -> bool {
        match self {
            Self::Never => false,
            Self::Friction => swing <= 0.0,
            Self::Turn(last) => n >= last,
        }
    }
}

/// Sums over the samples of products of derivatives with respect to `A_0`, `x_F`, `delta`, phase, `omega` and offset:
/// `JᵀJ` (lower triangle), `Jᵀr`, `rᵀr`.
#[derive(Debug, Clone, Copy)]
pub(crate) struct ClosedSums {
    pub(crate) jtj: [[f64; 6]; 6],
    pub(crate) jtr: [f64; 6],
    pub(crate) rss: f64,
    /// Index of the first sample at rest; the number of samples if none is at rest, or not yet.
    pub(crate) at_rest: usize,
}

/// Products of the derivatives with respect to `A_0` … `omega` and of the residual (lower triangle), and their
/// totals.
struct Totals<S: Simd> {
    products: [S::f64s; 21],
    totals: [S::f64s; 6],
}

impl<S: Simd> Totals<S> {
    #[inline(always)]
    fn new(simd: S) -> Self {
        let zero = simd.splat_f64s(0.0);
        Self { products: [zero; 21], totals: [zero; 6] }
    }

    #[inline(always)]
    fn add(&mut self, simd: S, rows: &[[S::f64s; 6]]) {
        let (mut p, mut t) = (self.products, self.totals);
        for row in rows {
            let mut at = 0;
            for i in 0..6 {
                for k in 0..=i {
                    p[at] = simd.mul_add_e_f64s(row[i], row[k], p[at]);
                    at += 1;
                }
                t[i] = simd.add_f64s(t[i], row[i]);
            }
        }
        (self.products, self.totals) = (p, t);
    }

    /// The sums after this many samples.
    #[inline(always)]
    fn sums(&self, simd: S, samples: usize, at_rest: usize) -> ClosedSums {
        let mut out = ClosedSums { jtj: [[0.0; 6]; 6], jtr: [0.0; 6], rss: 0.0, at_rest };
        let mut at = 0;
        for i in 0..6 {
            for k in 0..=i {
                let sum = simd.reduce_sum_f64s(self.products[at]);
                at += 1;
                match (i, k) {
                    (5, 5) => out.rss = sum,
                    (5, _) => out.jtr[k] = sum,
                    _ => out.jtj[i][k] = sum,
                }
            }
            let total = simd.reduce_sum_f64s(self.totals[i]);
            if i == 5 { out.jtr[5] = total } else { out.jtj[5][i] = total }
        }
        out.jtj[5][5] = samples as f64;
        out
    }
}

/// `e^(-delta t)`, `G = (1 - e^(-delta t))/delta` and `dG/d delta`.
#[derive(Clone, Copy)]
pub(crate) struct Fall {
    pub(crate) e: f64,
    pub(crate) g: f64,
    g_by_delta: f64,
}

impl Fall {
    pub(crate) fn after(delta: f64, t: f64) -> Self {
        let x = delta * t;
        let share = phi(x);
        let e = (-x).exp();
        let slope = if x.abs() < 0.02 {
            -0.5 + x * (1.0 / 3.0 + x * (-0.125 + x * (1.0 / 30.0 + x * (-1.0 / 144.0 + x / 840.0))))
        } else {
            (e - share) / x
        };
        Self { e, g: t * share, g_by_delta: t * t * slope }
    }

    /// Extends by another stretch `of` length `t`: integrals of an exponential combine this way.
    #[inline(always)]
    fn and(self, of: Self, t: f64) -> Self {
        Self {
            e: self.e * of.e,
            g: self.g * of.e + of.g,
            g_by_delta: self.g_by_delta * of.e - t * of.e * self.g + of.g_by_delta,
        }
    }
}

/// Number of registers of samples whose rows are summed together.
const BATCH: usize = 16;
/// Number of half cycles after which the running products are recomputed.
const FRESH: usize = 32;
/// `1/k!`: the terms of `e^x` that are needed for `|x| <= 1/16`.
const EXPONENTIAL: [f64; 10] = {
    let mut out = [1.0; 10];
    let mut k = 1;
    while k < 10 {
        out[k] = out[k - 1] / k as f64;
        k += 1;
    }
    out
};

impl pulp::WithSimd for Pass<'_> {
    type Output = Option<ClosedSums>;

    #[inline(always)]
    fn with_simd<S: Simd>(self, simd: S) -> Option<ClosedSums> {
        let Self { time, signal, origin, p, stop, models_rest_position, mut borders, parts } = self;
        let &[a0, x_f, delta, phase, omega, offset] = p;
        if !(omega > 0.0 && omega.is_finite()) {
            return None;
        }
        let period = PI / omega;
        let mut squarings = 0;
        let mut reach = (delta * period).abs();
        while reach > 0.0625 {
            reach *= 0.5;
            squarings += 1;
            if squarings > 10 || !reach.is_finite() {
                return None;
            }
        }
        let exponent = simd.splat_f64s(-delta * 0.5f64.powi(squarings));
        let [gain, gain_by_delta, gain_by_omega] = sliding_gain(delta, omega);
        let tilt = delta / omega;
        let half = Fall::after(delta, period);

        let zero = simd.splat_f64s(0.0);
        let mut totals = Totals::new(simd);
        // Rows are collected in a batch, because computing them and summing them each need all registers.
        let mut rows = [[zero; 6]; BATCH];
        let mut waiting = 0;
        let mut n = (phase / PI).floor();
        let mut fall = Fall { e: 1.0, g: 0.0, g_by_delta: 0.0 };
        let mut stale = FRESH;
        let (mut index, mut at_rest) = (0, time.len());
        let mut part_begins = 0;
        while index < time.len() {
            let turn = (n * PI - phase) / omega;
            if stale >= FRESH {
                fall = Fall::after(delta, turn);
                stale = 0;
            }
            let amplitude = a0 * fall.e - x_f * gain * fall.g;
            let swing = amplitude - x_f;
            // Beyond 2^50 half cycles the count is no longer exact.
            if !(swing.is_finite() && n.abs() < 1e15) {
                return None;
            }
            // The spring no longer overcomes friction: at rest permanently.
            let rests = stop.is_at(n, swing);
            if rests {
                at_rest = index;
            }
            let limit = origin + ((n + 1.0) * PI - phase) / omega;
            let end = if rests { time.len() } else { end_before(time, index, limit) };
            if end == index {
                // No samples lie in this half cycle; a gap is crossed in one step.
                let next = ((time[index] - origin) * omega + phase) / PI;
                if next > n + 2.0 {
                    n = first_at_rest(n, next.floor() - 1.0, |n| {
                        let fall = Fall::after(delta, (n * PI - phase) / omega);
                        stop.is_at(n, a0 * fall.e - x_f * gain * fall.g - x_f)
                    });
                    stale = FRESH;
                } else {
                    n += 1.0;
                    stale += 1;
                    fall = fall.and(half, period);
                }
                continue;
            }
            let sign = if (0.5 * n).fract() == 0.0 { 1.0 } else { -1.0 };
            let sign = if rests && !models_rest_position { 0.0 } else { sign };
            // With f1 = e^(-delta u) [cos + tilt sin], f3 = e^(-delta u) sin, every derivative is a combination of
            // f1, u f1, f3, u f3 and 1; at rest, of 1 alone.
            let by_delta = -turn * a0 * fall.e - x_f * (gain_by_delta * fall.g + gain * fall.g_by_delta);
            let by_phase = (delta * a0 + x_f * gain) * fall.e / omega;
            let by_omega = turn * by_phase - x_f * gain_by_omega * fall.g;
            let height = sign * swing;
            let spin = height * (1.0 + tilt * tilt);
            let level = simd.splat_f64s(offset + sign * if rests { amplitude } else { x_f });
            let minus_height = simd.splat_f64s(if rests { 0.0 } else { -height });
            let direct = simd.splat_f64s(if rests { 0.0 } else { sign });
            let begin = simd.splat_f64s(origin + turn);
            let (wide_omega, wide_tilt) = (simd.splat_f64s(omega), simd.splat_f64s(tilt));
            let quarter = simd.splat_f64s(-FRAC_PI_2);
            let a0_1 = simd.splat_f64s(sign * fall.e);
            let x_f_1 = simd.splat_f64s(-sign * (gain * fall.g + if rests { 0.0 } else { 1.0 }));
            let delta_1 = simd.splat_f64s(sign * by_delta);
            let delta_3 = simd.splat_f64s(height / omega);
            let phase_1 = simd.splat_f64s(sign * by_phase);
            let phase_3 = simd.splat_f64s(-spin);
            let omega_1 = simd.splat_f64s(sign * by_omega);
            let omega_2 = simd.splat_f64s(height * tilt);
            let omega_3 = simd.splat_f64s(-turn * spin - height * tilt / omega);
            while index < end {
                let to = borders.first().map_or(end, |border| end.min(*border));
                for (t, y, weight) in wide::Pairs::new(simd, &time[index..to], &signal[index..to]) {
                    let (mut f1, mut f3, mut u) = (weight, zero, zero);
                    if !rests {
                        u = simd.mul_f64s(weight, simd.sub_f64s(t, begin));
                        // cos = -sin(theta - pi/2), sin = cos(theta - pi/2)
                        let (s, c) = wide::half_turn(simd, simd.mul_add_e_f64s(u, wide_omega, quarter));
                        let mut e = wide::horner(simd, simd.mul_f64s(u, exponent), &EXPONENTIAL);
                        for _ in 0..squarings {
                            e = simd.mul_f64s(e, e);
                        }
                        let e = simd.mul_f64s(weight, e);
                        f3 = simd.mul_f64s(e, c);
                        f1 = simd.negate_mul_add_e_f64s(e, s, simd.mul_f64s(wide_tilt, f3));
                    }
                    let (f2, f4) = (simd.mul_f64s(u, f1), simd.mul_f64s(u, f3));
                    let above = simd.mul_f64s(weight, simd.sub_f64s(y, level));
                    let r = simd.mul_add_e_f64s(minus_height, f1, above);
                    let j0 = simd.mul_f64s(a0_1, f1);
                    let j1 = simd.mul_add_e_f64s(x_f_1, f1, simd.mul_f64s(direct, weight));
                    let j2 = simd.mul_add_e_f64s(delta_3, f3, simd.mul_f64s(delta_1, f1));
                    let j2 = simd.mul_add_e_f64s(minus_height, f2, j2);
                    let j3 = simd.mul_add_e_f64s(phase_3, f3, simd.mul_f64s(phase_1, f1));
                    let j4 = simd.mul_add_e_f64s(omega_3, f3, simd.mul_f64s(omega_1, f1));
                    let j4 = simd.mul_add_e_f64s(omega_2, f2, simd.mul_add_e_f64s(phase_3, f4, j4));
                    rows[waiting] = [j0, j1, j2, j3, j4, r];
                    waiting += 1;
                    if waiting == BATCH {
                        totals.add(simd, &rows);
                        waiting = 0;
                    }
                }
                index = to;
                while let Some((_, others)) = borders.split_first().filter(|(border, _)| **border == index) {
                    totals.add(simd, &rows[..waiting]);
                    parts.push(totals.sums(simd, index - part_begins, at_rest));
                    (totals, waiting, part_begins) = (Totals::new(simd), 0, index);
                    borders = others;
                }
            }
            n += 1.0;
            stale += 1;
            fall = fall.and(half, period);
        }
        totals.add(simd, &rows[..waiting]);
        Some(totals.sums(simd, time.len() - part_begins, at_rest))
    }
}

/// The first half cycle at rest after the moving half cycle `n`, or `far` if none before it is at rest.
fn first_at_rest(n: f64, far: f64, rests: impl Fn(f64) -> bool) -> f64 {
    // Beyond 2^50 half cycles the count is no longer exact.
    if !(far < 1e15 && rests(far)) {
        return far;
    }
    let (mut before, mut after) = (n, far);
    while after - before > 1.0 {
        let middle = (0.5 * (before + after)).floor();
        if rests(middle) { after = middle } else { before = middle }
    }
    after
}

/// First index at or after `index` whose time is not below `limit`.
#[inline(always)]
fn end_before(time: &[f64], index: usize, limit: f64) -> usize {
    let mut step = 16;
    while index + step < time.len() && time[index + step] < limit {
        step *= 2;
    }
    let (mut a, mut b) = (index + if step > 16 { step / 2 } else { 0 }, (index + step).min(time.len()));
    while a < b {
        let middle = usize::midpoint(a, b);
        if time[middle] < limit { a = middle + 1 } else { b = middle }
    }
    a
}
