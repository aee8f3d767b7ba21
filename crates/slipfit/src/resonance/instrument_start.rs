//! A line on a background, and behind a delay, by linear equations alone.

use super::Options;
use super::block::Block;
use super::peak::{self, Peak};
use crate::motion::steady::Phasor;
use nalgebra::{DMatrix, DVector};
use std::f64::consts::FRAC_PI_2;

/// Delays tried turn the phase by this many quarters of a turn across the sweep, either way.
const MOST_QUARTERS: usize = 40;
/// Between them, in units of one over half the span: an eighth of a turn.
const STEP: f64 = 0.5 * FRAC_PI_2;
/// So many first values are worth a fit.
const MOST: usize = 4;
/// One that leaves so many times the least is none; a line with friction is not the pole it is
/// taken for, and a wrong delay may hide some of that.
const FAR: f64 = 10.0;

/// A line that stands on more than its own height, as a quartz in liquid on its parallel
/// capacitance.
pub(crate) struct InstrumentStart {
    /// The points without the straight line between the two ends of the window.
    pub(crate) without: Block,
    /// What is seen of the line then.
    pub(crate) line: Peak,
    /// What was taken off at the line's top.
    pub(crate) height: Phasor,
    /// Delay taken out as well, s.
    pub(crate) delay: f64,
    /// The delay is the pedestal's too.
    pub(crate) delayed: bool,
}

/// Looks for a line above the pedestal where the points as they are show none.
pub(crate) fn baseline(b: &Block, line: &Peak) -> Option<InstrumentStart> {
    let n = b.len();
    if !b.complex || n < 20 || line.sides.iter().all(Option::is_some) {
        return None;
    }
    let end = (n / 50).max(1);
    let mean = |range: std::ops::Range<usize>| {
        let count = range.len() as f64;
        let omega = b.omega[range.clone()].iter().sum::<f64>() / count;
        (omega, b.data[range].iter().sum::<Phasor>() / count)
    };
    let ((from, first), (to, last)) = (mean(0..end), mean(n - end..n));
    let at = |omega: f64| first + (last - first) * ((omega - from) / (to - from));
    let data = b.omega.iter().zip(&b.data).map(|(&w, z)| z - at(w)).collect();
    let without = Block { data, ..b.clone() };
    let line = peak::find(&without)?;
    // The differences of amplitudes beside the line are all noise once nothing else is left.
    let seen = line.sides.iter().all(Option::is_some) && line.height > 12.0 * peak::noise(&without);
    let height = at(line.omega);
    seen.then_some(InstrumentStart { without, line, height, delay: 0.0, delayed: false })
}

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
/// or, where the delay is the background's too, of `z e^(i s tau)` without one;
/// linear in `p`, `b`, `c` and `d` at each delay of a grid; weighted by `1/|s - p|²` of the round
/// before (Sanathanan and Koerner's iteration), so that the sum is that of the data themselves.
pub(crate) fn find(b: &Block, allowed: Allowed) -> Vec<InstrumentStart> {
    let n = b.len();
    if !b.complex || n < 10 {
        return Vec::new();
    }
    let middle = 0.5 * (b.omega[0] + b.omega[n - 1]);
    let half = (0.5 * (b.omega[n - 1] - b.omega[0])).max(f64::MIN_POSITIVE);
    let most = if allowed.delay { MOST_QUARTERS.min(n / 2) } else { 0 };
    // A short one turns a large background all the same.
    let short = [0.1, 0.5].into_iter().filter(|_| most > 0);
    let delays = short.chain((1..=most).map(|k| k as f64)).flat_map(|k| [STEP * k, -STEP * k]);
    let total: f64 = b.data.iter().zip(&b.weight).map(|(z, w)| w * z.norm_sqr()).sum();
    let tried_at = |delay: f64, delayed: bool| {
        let p = pole(b, [middle, half], delay, allowed.background, delayed)?;
        // Any delay holds the line without one as well: it must do better than that.
        let least = 1e-9 * total;
        Some(Pole { rss: if p.delay == 0.0 { p.rss } else { 1.1 * p.rss + least }, ..p })
    };
    let tried: Vec<Pole> = std::iter::once(0.0)
        .chain(delays)
        .flat_map(|delay| [(delay, false), (delay, true)])
        .filter(|&(delay, delayed)| !delayed || (delay != 0.0 && allowed.background))
        .filter_map(|(delay, delayed)| tried_at(delay, delayed))
        .collect();
    // The least of each neighbourhood, the best first.
    let beside = |p: &Pole, q: &Pole| p.delayed == q.delayed && (p.delay - q.delay).abs() < 1.2 * STEP;
    let mut least: Vec<Pole> =
        tried.iter().filter(|p| tried.iter().all(|q| !beside(p, q) || q.rss >= p.rss)).copied().collect();
    let by_rss = |list: &mut Vec<Pole>| list.sort_by(|p, q| p.rss.total_cmp(&q.rss));
    by_rss(&mut least);
    least.truncate(2 * MOST);
    for p in least.iter_mut().filter(|p| p.delay != 0.0) {
        *p = refined(*p, |delay| tried_at(delay, p.delayed));
    }
    by_rss(&mut least);
    least.truncate(MOST);
    let most = least.first().map_or(0.0, |p| FAR * p.rss);
    least.iter().filter(|p| p.rss <= most).filter_map(|p| without(b, p, middle, p.delay / half)).collect()
}

/// Where between its neighbours on the grid a delay leaves least: golden section.
fn refined(from: Pole, at: impl Fn(f64) -> Option<Pole>) -> Pole {
    const GOLDEN: f64 = 0.618_033_988_749_894_8;
    const ROUNDS: usize = 10;
    let (mut low, mut high) = (from.delay - STEP, from.delay + STEP);
    let mut best = from;
    for _ in 0..ROUNDS {
        let [left, right] = [high - GOLDEN * (high - low), low + GOLDEN * (high - low)];
        let (Some(a), Some(b)) = (at(left), at(right)) else { break };
        let lower = if a.rss < b.rss { a } else { b };
        if a.rss < b.rss {
            high = right
        } else {
            low = left
        }
        if lower.rss < best.rss {
            best = lower;
        }
    }
    best
}

/// The points with both taken off.
fn without(b: &Block, pole: &Pole, middle: f64, delay: f64) -> Option<InstrumentStart> {
    let background = |omega: f64| match pole.delayed {
        true => pole.background * Phasor::from_polar(1.0, (middle - omega) * delay),
        false => pole.background,
    };
    let data = b.data.iter().zip(&b.omega).map(|(z, omega)| z - background(*omega)).collect();
    let mut without = Block { data, ..b.clone() };
    let line = peak::find(&without)?;
    for (z, omega) in without.data.iter_mut().zip(&b.omega) {
        *z *= Phasor::from_polar(1.0, (omega - line.omega) * delay);
    }
    Some(InstrumentStart { without, line, height: background(line.omega), delay, delayed: pole.delayed })
}

#[derive(Debug, Clone, Copy)]
struct Pole {
    rss: f64,
    background: Phasor,
    /// In units of one over half the span.
    delay: f64,
    /// The delay is the background's too.
    delayed: bool,
}

fn pole(b: &Block, [middle, half]: [f64; 2], delay: f64, background: bool, delayed: bool) -> Option<Pole> {
    const ROUNDS: usize = 6;
    let n = b.len();
    let one = Phasor::new(1.0, 0.0);
    // z, s, 1, e^(-i s tau): those that are asked for.
    let width = match (background, delay != 0.0 && !delayed) {
        (true, true) => 4,
        (true, false) => 3,
        (false, _) => 2,
    };
    let row = |i: usize| {
        let s = (b.omega[i] - middle) / half;
        let turn = Phasor::from_polar(1.0, -s * delay);
        let z = if delayed { b.data[i] * turn.conj() } else { b.data[i] };
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
    (rss.is_finite() && inside).then_some(Pole { rss, background, delay, delayed })
}

#[cfg(test)]
mod tests {
    use super::super::Curve;
    use super::*;

    #[test]
    fn background_and_delay_are_found_together_and_alone() {
        let make = |background: Phasor, delay: f64, delayed: bool| {
            let hz: Vec<f64> = (0..201).map(|i| 0.95 + 5e-4 * f64::from(i)).collect();
            let z = hz.iter().map(|f| {
                let omega = std::f64::consts::TAU * f;
                let line = Phasor::new(0.02, 0.0) / Phasor::new(omega - 6.3, -0.02);
                let turn = Phasor::from_polar(1.0, (6.3 - omega) * delay);
                let offset = Phasor::from_polar(1.0, 0.4);
                if delayed { (line * offset + background) * turn } else { line * offset * turn + background }
            });
            Block::new(&Curve::complex(hz.clone(), z.collect()).build().unwrap())
        };
        let both = Allowed { background: true, delay: true };
        // A turn across this sweep is a delay of 10.
        for (background, delay, delayed) in [
            (Phasor::new(-0.6, 0.7), 0.0, false),
            (Phasor::new(0.3, -0.2), 31.0, false),
            (Phasor::new(0.3, -0.2), 31.0, true),
            (Phasor::default(), -12.0, false),
        ] {
            let found = find(&make(background, delay, delayed), both).swap_remove(0);
            assert!(found.delayed == delayed || background == Phasor::default());
            assert!((found.delay - delay).abs() < 1.3, "{} {delay}", found.delay);
            assert!((found.height - background).norm() < 0.1, "{} {background}", found.height);
            assert!((found.line.omega - 6.3).abs() < 0.005, "{:?}", found.line);
        }
    }
}
