//! Peak, width and noise of a curve before any model is fitted; other peaks and jumps.

use super::block::Block;
use super::criteria::{PeakCriteria, ResidualCriteria};
use crate::motion::steady::Phasor;

/// The main peak as determined from the points.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct Peak {
    /// Index of the point of the highest amplitude.
    pub(crate) index: usize,
    /// Frequency of the peak, rad/s, from the parabola through its neighbours.
    pub(crate) omega: f64,
    /// Its height.
    pub(crate) height: f64,
    /// Half width at 1/√2 of the height, rad/s.
    pub(crate) half_width: f64,
    /// Half widths found below and above the peak.
    pub(crate) sides: [Option<f64>; 2],
}

/// Noise of one amplitude from differences between neighbours, insensitive to linear trends.
pub(crate) fn noise(b: &Block) -> f64 {
    let n = b.len();
    if n < 5 {
        return 0.0;
    }
    let level = b.levels();
    let mut second: Vec<f64> = (1..n - 1)
        .filter_map(|i| {
            let (l, r) = (b.omega[i] - b.omega[i - 1], b.omega[i + 1] - b.omega[i]);
            let span = l + r;
            let between = if span > 0.0 {
                (level[i - 1] * r + level[i + 1] * l) / span
            } else {
                0.5 * (level[i - 1] + level[i + 1])
            };
            let (p, q) = if span > 0.0 { (r / span, l / span) } else { (0.5, 0.5) };
            let d = (level[i] - between).abs() / (1.0 + p * p + q * q).sqrt();
            d.is_finite().then_some(d)
        })
        .collect();
    if second.is_empty() {
        return 0.0;
    }
    let middle = second.len() / 2;
    // Half of the absolute values of a normal variable are below 0.6745 standard deviations.
    *second.select_nth_unstable_by(middle, f64::total_cmp).1 / 0.6745
}

pub(crate) fn find(b: &Block) -> Option<Peak> {
    let n = b.len();
    let amplitude = b.levels();
    let (mut top, mut height) = (0, *amplitude.first()?);
    for (i, &a) in amplitude.iter().enumerate() {
        // The last one of equal amplitudes.
        if a >= height {
            (top, height) = (i, a);
        }
    }
    if !(height > 0.0) {
        return None;
    }
    let cut = height * std::f64::consts::FRAC_1_SQRT_2;
    let crossing = |range: &mut dyn Iterator<Item = usize>| {
        let mut last = top;
        for i in range {
            if amplitude[i] < cut {
                let t = (amplitude[last] - cut) / (amplitude[last] - amplitude[i]);
                return Some((b.omega[last] + t * (b.omega[i] - b.omega[last]) - b.omega[top]).abs());
            }
            last = i;
        }
        None
    };
    let sides = [crossing(&mut (0..top).rev()), crossing(&mut (top + 1..n))];
    let span = b.omega[n - 1] - b.omega[0];
    let half_width = match sides {
        [Some(l), Some(r)] => 0.5 * (l + r),
        [Some(w), None] | [None, Some(w)] => w,
        [None, None] => span,
    };
    let omega = match sides {
        [Some(l), Some(r)] => b.omega[top] + 0.25 * (r - l),
        _ => b.omega[top],
    };
    let least = 1e-9 * b.omega[top];
    Some(Peak { index: top, omega, height, half_width: half_width.max(least), sides })
}

/// The points without the highest one, if it is isolated like a glitch.
pub(crate) fn without_spike(b: &Block, c: &ResidualCriteria) -> Option<Block> {
    let level = b.levels();
    let top = find(b)?.index;
    let beside = [top.wrapping_sub(1), top + 1].into_iter().filter_map(|i| level.get(i));
    let beside = beside.copied().fold(0.0, f64::max);
    let alone = beside < c.outlier_neighbour * level[top]
        && level[top] - beside > c.outlier_deviations * noise(b)
        && b.len() >= c.outlier_points;
    let rest: Vec<usize> = (0..b.len()).filter(|&i| i != top).collect();
    alone.then(|| b.subset(&rest))
}

/// Whether every point has the same response.
pub(crate) fn is_flat(b: &Block, c: &PeakCriteria) -> bool {
    let used = || (0..b.len()).filter(|&i| b.weight[i] > 0.0).map(|i| b.data[i] / b.drive[i]);
    let centre = used().sum::<Phasor>() / used().count() as f64;
    used().all(|z| (z - centre).norm() < c.above_mean * centre.norm())
}

/// The highest other peak: frequency, and height relative to the main peak.
pub(crate) fn second_peak(b: &Block, peak: &Peak, noise: f64, c: &PeakCriteria) -> Option<(f64, f64)> {
    let n = b.len();
    let mut best: Option<(f64, f64)> = None;
    let mut scan = |range: &mut dyn Iterator<Item = usize>| {
        // Lowest amplitude since the main peak.
        let mut saddle = peak.height;
        for i in range {
            let a = b.amplitude(i);
            saddle = saddle.min(a);
            let rises = a - saddle;
            // A single high point is a glitch, so its neighbours must rise as well.
            let shares = |i: usize| b.amplitude(i) - saddle > c.second_neighbour * rises;
            let company = (i > 0 && shares(i - 1)) || (i + 1 < n && shares(i + 1));
            let least =
                (c.second_above_noise * noise).max(c.second_of_height * peak.height).max(c.second_of_own * a);
            if rises > least && company && best.is_none_or(|(_, h)| a > h) {
                best = Some((b.omega[i], a));
            }
        }
    };
    scan(&mut (0..peak.index).rev());
    scan(&mut (peak.index + 1..n));
    best.map(|(omega, a)| (omega, a / peak.height))
}

/// Frequency at which the amplitude jumps: a step far steeper than the slope of the other flank, which a single-valued
/// peak does not have.
pub(crate) fn jump(b: &Block, peak: &Peak, noise: f64, c: &PeakCriteria) -> Option<f64> {
    let n = b.len();
    let slope = |i: usize| {
        let step = (b.omega[i + 1] - b.omega[i]).max(1e-9 * b.omega[i]);
        (b.amplitude(i + 1) - b.amplitude(i)).abs() / step
    };
    let steepest = |range: std::ops::Range<usize>| range.map(slope).fold(0.0, f64::max);
    let gentle = steepest(0..peak.index).min(steepest(peak.index..n - 1));
    if gentle == 0.0 {
        return None;
    }
    // A Lorentzian is nowhere steeper than 0.385 of its height per half width.
    let usual = gentle.max(0.385 * peak.height / peak.half_width);
    (0..n - 1)
        .filter(|&i| {
            let fall = (b.amplitude(i + 1) - b.amplitude(i)).abs();
            fall > (c.jump_of_height * peak.height).max(c.jump_above_noise * noise)
                && slope(i) > c.jump_steepness * usual
        })
        .map(|i| 0.5 * (b.omega[i] + b.omega[i + 1]))
        .next()
}

#[cfg(test)]
mod tests {
    use super::super::{Criteria, Curve};
    use super::*;
    use crate::noise::jitter;

    fn block(f: impl Fn(f64) -> f64) -> Block {
        let frequency: Vec<f64> = (0..201).map(|i| 0.9 + 0.001 * f64::from(i)).collect();
        let amplitude = frequency.iter().map(|&w| f(w)).collect();
        Block::new(&Curve::builder(frequency, amplitude).build().unwrap())
    }

    fn lorentzian(w: f64, centre: f64, width: f64) -> f64 {
        width / (w - centre).hypot(width)
    }

    #[test]
    fn one_peak_has_a_width_and_nothing_else() {
        let b = block(|w| lorentzian(w, 1.0, 0.01));
        let l = find(&b).unwrap();
        let hz = std::f64::consts::TAU;
        assert!((l.half_width / hz - 0.01).abs() < 1e-4, "{l:?}");
        assert!((l.omega / hz - 1.0).abs() < 1e-6, "{l:?}");
        let c = Criteria::default().peak;
        assert_eq!(second_peak(&b, &l, 0.0, &c), None);
        assert_eq!(jump(&b, &l, 0.0, &c), None);
    }

    #[test]
    fn a_second_peak_and_a_jump_are_found() {
        let c = Criteria::default().peak;
        let b = block(|w| lorentzian(w, 0.97, 0.005) + 0.4 * lorentzian(w, 1.04, 0.005));
        let (omega, height) = second_peak(&b, &find(&b).unwrap(), 0.0, &c).unwrap();
        assert!((omega / std::f64::consts::TAU - 1.04).abs() < 2e-3, "{omega}");
        assert!((height - 0.45).abs() < 0.1, "{height}");
        let b = block(|w| if w < 1.0 { lorentzian(w, 1.0, 0.02) } else { 0.3 * lorentzian(w, 1.0, 0.02) });
        assert!(jump(&b, &find(&b).unwrap(), 0.0, &c).is_some());
    }

    #[test]
    fn noise_is_read_beside_a_peak() {
        let number = std::cell::Cell::new(0);
        let b = block(|w| lorentzian(w, 1.0, 0.02) + 1e-3 * jitter(number.replace(number.get() + 1), 9));
        let n = noise(&b);
        assert!((0.8e-3..1.25e-3).contains(&n), "{n}");
    }
}
