//! Start values of background and delay, from linear equations alone.

use super::Options;
use super::block::Block;
use super::criteria::InstrumentCriteria;
use super::peak::{self, Peak};
use crate::motion::steady::Phasor;
use crate::numeric::{GOLDEN_SECTION, order::sort_by_value};
use nalgebra::{DMatrix, DVector};
use std::f64::consts::FRAC_PI_2;

/// Step between the delays tried, in units of one over half the span: an eighth of a turn.
const STEP: f64 = 0.5 * FRAC_PI_2;

/// Start values of background and delay.
#[derive(Debug, Clone, Copy, Default)]
pub(super) struct InstrumentTerms {
    /// Background at the peak.
    pub(super) background: Phasor,
    /// Delay, s.
    pub(super) delay: f64,
    /// Whether the delay also applies to the background.
    pub(super) delayed: bool,
}

/// The same, with the remaining curve.
#[derive(Clone)]
pub(super) struct InstrumentStart {
    pub(super) terms: InstrumentTerms,
    /// The points without background and delay.
    pub(super) without: Block,
    /// The peak of these points.
    pub(super) peak: Peak,
}

/// A peak above the straight line between the two ends of the curve, such as that of a quartz crystal in liquid above
/// its parallel capacitance, if the points without this correction show no complete peak.
pub(super) fn baseline(b: &Block, peak: &Peak, c: &InstrumentCriteria) -> Option<InstrumentStart> {
    let n = b.len();
    if !b.complex || n < c.baseline_points || peak.sides.iter().all(Option::is_some) {
        return None;
    }
    let end = (n / c.baseline_part).max(1);
    let mean = |range: std::ops::Range<usize>| {
        let count = range.len() as f64;
        let omega = b.omega[range.clone()].iter().sum::<f64>() / count;
        (omega, b.data[range].iter().sum::<Phasor>() / count)
    };
    let ((from, first), (to, last)) = (mean(0..end), mean(n - end..n));
    let at = |omega: f64| first + (last - first) * ((omega - from) / (to - from));
    let data = b.omega.iter().zip(&b.data).map(|(&w, z)| z - at(w)).collect();
    let without = Block { data, ..b.clone() };
    let peak = peak::find(&without)?;
    // The differences of amplitudes off the peak are pure noise once nothing else is left.
    let whole = peak.sides.iter().all(Option::is_some);
    let stands_out = whole && peak.height > c.baseline_above_noise * peak::noise(&without);
    let terms = InstrumentTerms { background: at(peak.omega), ..InstrumentTerms::default() };
    stands_out.then_some(InstrumentStart { terms, without, peak })
}

/// Start values of background and delay, the best first, from a model with one pole,
///
/// ```text
/// z = b + c e^(-i s tau)/(s - p)   =>   z s = p z + b s + d + c e^(-i s tau),   d = -b p
/// ```
///
/// or, if the delay also applies to the background, for `z e^(i s tau)` without a delay; linear in `p`, `b`, `c` and
/// `d` at each delay of a grid; weighted by `1/|s - p|²` of the previous iteration (Sanathanan and Koerner's
/// iteration), so that the sum of squares refers to the data themselves.
pub(super) fn find(b: &Block, options: &Options, c: &InstrumentCriteria) -> Vec<InstrumentStart> {
    let n = b.len();
    if !b.complex || n < c.pole_points {
        return Vec::new();
    }
    let background = options.terms.background != Some(false);
    let middle = 0.5 * (b.omega[0] + b.omega[n - 1]);
    let half = (0.5 * (b.omega[n - 1] - b.omega[0])).max(f64::MIN_POSITIVE);
    let may_be_delayed = options.terms.delay != Some(false);
    let most = if may_be_delayed { c.most_quarters.min(n / 2) } else { 0 };
    // Even a short delay rotates a large background noticeably.
    let short = [0.1, 0.5].into_iter().filter(|_| most > 0);
    let delays = short.chain((1..=most).map(|k| k as f64)).flat_map(|k| [STEP * k, -STEP * k]);
    let total: f64 = b.data.iter().zip(&b.weight).map(|(z, w)| w * z.norm_sqr()).sum();
    let tried_at = |delay: f64, delayed: bool| {
        let p = pole(b, [middle, half], delay, background, delayed)?;
        // A pole with a delay also describes one without, so it must fit better.
        let least = 1e-9 * total;
        Some(Pole { rss: if p.delay == 0.0 { p.rss } else { c.delay_penalty * p.rss + least }, ..p })
    };
    let tried: Vec<Pole> = std::iter::once(0.0)
        .chain(delays)
        .flat_map(|delay| [(delay, false), (delay, true)])
        .filter(|&(delay, delayed)| !delayed || (delay != 0.0 && background))
        .filter_map(|(delay, delayed)| tried_at(delay, delayed))
        .collect();
    // The minimum of each neighbourhood.
    let beside = |p: &Pole, q: &Pole| p.delayed == q.delayed && (p.delay - q.delay).abs() < 1.2 * STEP;
    let mut least: Vec<Pole> =
        tried.iter().filter(|p| tried.iter().all(|q| !beside(p, q) || q.rss >= p.rss)).copied().collect();
    let by_rss = |list: &mut Vec<Pole>| sort_by_value(list, |p| p.rss);
    by_rss(&mut least);
    least.truncate(2 * c.most_starts);
    for p in least.iter_mut().filter(|p| p.delay != 0.0) {
        *p = refined(*p, |delay| tried_at(delay, p.delayed));
    }
    by_rss(&mut least);
    least.truncate(c.most_starts);
    let most = least.first().map_or(0.0, |p| c.worth_a_fit * p.rss);
    least.iter().filter(|p| p.rss <= most).filter_map(|p| without(b, p, middle, p.delay / half)).collect()
}

/// Minimises over the delay between its neighbours on the grid by golden section.
fn refined(from: Pole, at: impl Fn(f64) -> Option<Pole>) -> Pole {
    const ROUNDS: usize = 10;
    let (mut low, mut high) = (from.delay - STEP, from.delay + STEP);
    let mut best = from;
    for _ in 0..ROUNDS {
        let [left, right] = [high - GOLDEN_SECTION * (high - low), low + GOLDEN_SECTION * (high - low)];
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

/// The points with background and delay removed.
fn without(b: &Block, pole: &Pole, middle: f64, delay: f64) -> Option<InstrumentStart> {
    let background = |omega: f64| match pole.delayed {
        true => pole.background * Phasor::from_polar(1.0, (middle - omega) * delay),
        false => pole.background,
    };
    let data = b.data.iter().zip(&b.omega).map(|(z, omega)| z - background(*omega)).collect();
    let mut without = Block { data, ..b.clone() };
    let peak = peak::find(&without)?;
    for (z, omega) in without.data.iter_mut().zip(&b.omega) {
        *z *= Phasor::from_polar(1.0, (omega - peak.omega) * delay);
    }
    let terms = InstrumentTerms { background: background(peak.omega), delay, delayed: pole.delayed };
    Some(InstrumentStart { terms, without, peak })
}

#[derive(Debug, Clone, Copy)]
struct Pole {
    rss: f64,
    background: Phasor,
    /// In units of one over half the span.
    delay: f64,
    /// Whether the delay also applies to the background.
    delayed: bool,
}

fn pole(b: &Block, [middle, half]: [f64; 2], delay: f64, background: bool, delayed: bool) -> Option<Pole> {
    const ROUNDS: usize = 6;
    let n = b.len();
    let one = Phasor::new(1.0, 0.0);
    // z, s, 1, e^(-i s tau): those columns that are used.
    let width = match (background, delay != 0.0 && !delayed) {
        (true, true) => 4,
        (true, false) => 3,
        (false, _) => 2,
    };
    let place_of = |omega: &f64| (omega - middle) / half;
    let rotations: Vec<Phasor> =
        b.omega.iter().map(|omega| Phasor::from_polar(1.0, -place_of(omega) * delay)).collect();
    let row = |i: usize| {
        let (s, rotation) = (place_of(&b.omega[i]), rotations[i]);
        let z = if delayed { b.data[i] * rotation.conj() } else { b.data[i] };
        let columns = if background { [z, one * s, one, rotation] } else { [z, rotation, one, one] };
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
    use super::super::{Criteria, Curve};
    use super::*;

    #[test]
    fn background_and_delay_are_found_together_and_alone() {
        let make = |background: Phasor, delay: f64, delayed: bool| {
            let hz: Vec<f64> = (0..201).map(|i| 0.95 + 5e-4 * f64::from(i)).collect();
            let z = hz.iter().map(|f| {
                let omega = std::f64::consts::TAU * f;
                let resonance = Phasor::new(0.02, 0.0) / Phasor::new(omega - 6.3, -0.02);
                let turn = Phasor::from_polar(1.0, (6.3 - omega) * delay);
                let offset = Phasor::from_polar(1.0, 0.4);
                let seen = resonance * offset;
                if delayed { (seen + background) * turn } else { seen * turn + background }
            });
            Block::new(&Curve::complex(hz.clone(), z.collect()).build().unwrap())
        };
        let c = Criteria::default().instrument;
        // One turn across this sweep corresponds to a delay of 10.
        for (background, delay, delayed) in [
            (Phasor::new(-0.6, 0.7), 0.0, false),
            (Phasor::new(0.3, -0.2), 31.0, false),
            (Phasor::new(0.3, -0.2), 31.0, true),
            (Phasor::default(), -12.0, false),
        ] {
            let found = find(&make(background, delay, delayed), &Options::default(), &c).swap_remove(0);
            assert!(found.terms.delayed == delayed || background == Phasor::default());
            assert!((found.terms.delay - delay).abs() < 1.3, "{} {delay}", found.terms.delay);
            assert!(
                (found.terms.background - background).norm() < 0.1,
                "{} {background}",
                found.terms.background
            );
            assert!((found.peak.omega - 6.3).abs() < 0.005, "{:?}", found.peak);
        }
    }
}
