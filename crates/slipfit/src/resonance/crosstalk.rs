//! A line on a background, and behind a delay, by linear equations alone.

use super::Options;
use super::block::Block;
use super::look::{self, Pedestal};
use crate::steady::Phasor;
use nalgebra::{DMatrix, DVector};
use std::f64::consts::FRAC_PI_2;

/// Delays tried turn the phase by this many quarters of a turn across the sweep, either way.
const MOST_QUARTERS: usize = 40;
/// So many first values are worth a fit.
const MOST: usize = 4;
/// One that leaves so many times the least is none.
const FAR: f64 = 4.0;

/// What may stand between the oscillator and the data.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Allowed {
    pub(crate) background: bool,
    pub(crate) delay: bool,
}

impl Allowed {
    /// What is not ruled out.
    pub(crate) fn by(options: &Options) -> Self {
        let wanted = options.terms;
        Self { background: wanted.background != Some(false), delay: wanted.delay != Some(false) }
    }
}

/// First values of background and delay from one pole on both,
///
/// ```text
/// z = b + c e^(-i s tau)/(s - p)   =>   z s = p z + b s + d + c e^(-i s tau),   d = -b p
/// ```
///
/// linear in `p`, `b`, `c` and `d` at each delay of a grid; weighted by `1/|s - p|²` of the round
/// before (Sanathanan and Koerner's iteration), so that the sum is that of the data themselves.
pub(crate) fn find(b: &Block, allowed: Allowed) -> Vec<Pedestal> {
    let n = b.len();
    if !b.complex || n < 10 {
        return Vec::new();
    }
    let middle = 0.5 * (b.omega[0] + b.omega[n - 1]);
    let half = (0.5 * (b.omega[n - 1] - b.omega[0])).max(f64::MIN_POSITIVE);
    let most = if allowed.delay { MOST_QUARTERS.min(n / 2) } else { 0 };
    let delays = (1..=most).flat_map(|k| [k as f64, -(k as f64)]).map(|k| 0.5 * FRAC_PI_2 * k);
    let total: f64 = b.data.iter().zip(&b.weight).map(|(z, w)| w * z.norm_sqr()).sum();
    let tried: Vec<Pole> = std::iter::once(0.0)
        .chain(delays)
        .filter_map(|delay| pole(b, middle, half, delay, allowed.background))
        .map(|p| {
            // Any delay holds the line without one as well: it must do better than that.
            let least = 1e-9 * total;
            Pole { rss: if p.delay == 0.0 { p.rss } else { 1.1 * p.rss + least }, ..p }
        })
        .collect();
    // The least of each neighbourhood, the best first.
    let beside = |p: &Pole, q: &Pole| (p.delay - q.delay).abs() < 0.6 * FRAC_PI_2;
    let mut least: Vec<&Pole> =
        tried.iter().filter(|p| tried.iter().all(|q| !beside(p, q) || q.rss >= p.rss)).collect();
    least.sort_by(|p, q| p.rss.total_cmp(&q.rss));
    least.truncate(MOST);
    let most = least.first().map_or(0.0, |p| FAR * p.rss);
    least
        .into_iter()
        .filter(|p| p.rss <= most)
        .filter_map(|p| without(b, p.background, p.delay / half))
        .collect()
}

/// The points with both taken off.
fn without(b: &Block, background: Phasor, delay: f64) -> Option<Pedestal> {
    let mut without = Block { data: b.data.iter().map(|z| z - background).collect(), ..b.clone() };
    let line = look::line(&without)?;
    for (z, omega) in without.data.iter_mut().zip(&b.omega) {
        *z *= Phasor::from_polar(1.0, (omega - line.omega) * delay);
    }
    Some(Pedestal { without, line, height: background, delay })
}

#[derive(Debug, Clone, Copy)]
struct Pole {
    rss: f64,
    background: Phasor,
    /// In units of one over half the span.
    delay: f64,
}

fn pole(b: &Block, middle: f64, half: f64, delay: f64, background: bool) -> Option<Pole> {
    const ROUNDS: usize = 6;
    let n = b.len();
    let one = Phasor::new(1.0, 0.0);
    // z, s, 1, e^(-i s tau): those that are asked for.
    let width = match (background, delay != 0.0) {
        (true, true) => 4,
        (true, false) => 3,
        (false, _) => 2,
    };
    let row = |i: usize| {
        let s = (b.omega[i] - middle) / half;
        let turn = Phasor::from_polar(1.0, -s * delay);
        let z = b.data[i];
        let columns = if background { [z, one * s, one, turn] } else { [z, turn, one, one] };
        (s, columns, z)
    };
    let mut place: Option<Phasor> = None;
    let mut solution = DVector::<Phasor>::zeros(width);
    for _ in 0..ROUNDS {
        let mut m = DMatrix::<Phasor>::zeros(width, width);
        let mut v = DVector::<Phasor>::zeros(width);
        for i in 0..n {
            let (s, columns, z) = row(i);
            let weight = b.weight[i] / place.map_or(1.0, |p| (one * s - p).norm_sqr().max(1e-18));
            for a in 0..width {
                let scaled = columns[a].conj() * weight;
                v[a] += scaled * z * s;
                for c in 0..width {
                    m[(a, c)] += scaled * columns[c];
                }
            }
        }
        solution = m.lu().solve(&v)?;
        place = Some(solution[0]);
    }
    let p = place?;
    let mut rss = 0.0;
    for i in 0..n {
        let (s, columns, z) = row(i);
        let top: Phasor = (1..width).map(|k| columns[k] * solution[k]).sum();
        rss += b.weight[i] * (z - top / (one * s - p)).norm_sqr();
    }
    let inside = p.re.abs() < 1.5 && p.im.abs() < 2.0;
    let background = if background { solution[1] } else { Phasor::default() };
    (rss.is_finite() && inside).then_some(Pole { rss, background, delay })
}

#[cfg(test)]
mod tests {
    use super::super::Curve;
    use super::*;

    #[test]
    fn background_and_delay_are_found_together_and_alone() {
        let make = |background: Phasor, delay: f64| {
            let hz: Vec<f64> = (0..201).map(|i| 0.95 + 5e-4 * f64::from(i)).collect();
            let z = hz.iter().map(|f| {
                let omega = std::f64::consts::TAU * f;
                let line = Phasor::new(0.02, 0.0) / Phasor::new(omega - 6.3, -0.02);
                line * Phasor::from_polar(1.0, 0.4 - (omega - 6.3) * delay) + background
            });
            Block::new(&Curve::complex(hz.clone(), z.collect()).build().unwrap())
        };
        let both = Allowed { background: true, delay: true };
        // A turn across this sweep is a delay of 10.
        for (background, delay) in
            [(Phasor::new(-0.6, 0.7), 0.0), (Phasor::new(0.3, -0.2), 31.0), (Phasor::default(), -12.0)]
        {
            let found = find(&make(background, delay), both).swap_remove(0);
            assert!((found.delay - delay).abs() < 1.3, "{} {delay}", found.delay);
            assert!((found.height - background).norm() < 0.1, "{} {background}", found.height);
            assert!((found.line.omega - 6.3).abs() < 0.005, "{:?}", found.line);
        }
    }
}
