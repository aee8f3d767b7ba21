//! Division of the record into short stretches ("blocks"): amplitude, phase, offset and noise of each, by local least
//! squares. No step assumes uniform sampling.

use crate::numeric::{robust::median, wide};
use nalgebra::{SMatrix, SVector};
use std::f64::consts::{PI, TAU};

/// Number of samples used per block while the frequency is being tracked.
const TRACK_SAMPLES: usize = 384;
/// Residual variance over total variance above which a guess is far from the frequency: at half the step between
/// guesses, an oscillation of ten cycles is explained to two thirds.
const FAR: f64 = 0.9;

/// One stretch of the record.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct Block {
    /// Sample range `first..end`.
    pub(crate) first: usize,
    pub(crate) end: usize,
    /// Middle of the stretch, s.
    pub(crate) time_s: f64,
    /// Its length, s.
    pub(crate) span_s: f64,
    /// Amplitude (of the fundamental), signal unit.
    pub(crate) amplitude: f64,
    /// Component of the amplitude in quadrature to the reference phase.
    pub(crate) quadrature: f64,
    /// Phase at `time_s`, rad, unwrapped; the motion is `amplitude cos(phase)`.
    pub(crate) phase: f64,
    /// Rate of the phase, rad/s.
    pub(crate) omega: f64,
    pub(crate) offset: f64,
    /// Variance of `amplitude` for samples of unit variance.
    pub(crate) unit_variance: f64,
    /// Residual sum of squares and its degrees of freedom.
    pub(crate) rss: f64,
    pub(crate) dof: f64,
}

impl Block {
    /// A stretch of samples about a time, not yet fitted.
    pub(crate) fn of(first: usize, end: usize, time_s: f64) -> Self {
        Self {
            first,
            end,
            time_s,
            span_s: 0.0,
            amplitude: 0.0,
            quadrature: 0.0,
            phase: 0.0,
            omega: 0.0,
            offset: 0.0,
            unit_variance: 0.0,
            rss: 0.0,
            dof: 0.0,
        }
    }

    /// Standard error of the amplitude for noise of `noise_rms` per sample.
    pub(crate) fn std_error(&self, noise_rms: f64) -> f64 {
        noise_rms * self.unit_variance.sqrt()
    }
}

/// How a record is divided into blocks.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct Cut {
    /// Cycles per block.
    pub(crate) cycles: f64,
    /// Minimum number of samples of a block.
    pub(crate) least: usize,
}

impl Cut {
    /// About 400 blocks, none shorter than a cycle or ten samples.
    pub(crate) fn for_record(duration_s: f64, samples: usize, frequency_hz: f64) -> Self {
        let cycles = duration_s * frequency_hz;
        let per_cycle = samples as f64 / cycles.max(1e-9);
        let wanted = (cycles / 400.0).max(10.0 / per_cycle).max(1.0);
        Self { cycles: wanted.round().max(1.0), least: 7 }
    }
}

/// Tracks the oscillation along the record, block by block, and unwraps its phase.
///
/// The frequency of each block is refined separately, starting from that of its predecessor, so that a frequency that
/// changes with amplitude is tracked.
pub(crate) fn track(
    time: &[f64],
    signal: &[f64],
    frequency_hz: f64,
    band_hz: [f64; 2],
    cut: Cut,
) -> Vec<Block> {
    let coarse = TAU * frequency_hz;
    let band = band_hz.map(|f| TAU * f);
    let mut blocks: Vec<Block> = Vec::new();
    let mut omega = coarse;
    let (mut thin_time, mut thin_signal) = (Vec::new(), Vec::new());
    let mut first = 0;
    while first < time.len() {
        let start = time[first];
        let span = cut.cycles * TAU / omega;
        let end = first + time[first..].partition_point(|&t| t < start + span * (1.0 - 1e-9));
        let reaches = end < time.len() || time[end - 1] - start > 0.9 * span;
        let filled = end > first && time[end - 1] - start > 0.6 * span;
        if end - first < cut.least || !filled || !reaches {
            first = end.max(first + 1);
            continue;
        }
        let (from, to, stride) = thinned(first, end, cut.cycles);
        thin_time.clear();
        thin_time.extend(time[from..to].iter().step_by(stride));
        thin_signal.clear();
        thin_signal.extend(signal[from..to].iter().step_by(stride));
        let sampled = (thin_time.as_slice(), thin_signal.as_slice());
        let Some(mut local) = refine(sampled, omega, start, span, band, 1.0) else {
            first = end;
            continue;
        };
        if local.unexplained > 0.2 {
            // The frequency may have moved away from its predecessor's: try others nearby.
            for factor in [0.6, 0.7, 0.8, 0.9, 1.1, 1.2, 1.35, 1.5] {
                let guess = coarse * factor;
                if guess < band[0] || guess > band[1] {
                    continue;
                }
                if let Some(other) = refine(sampled, guess, start, span, band, FAR)
                    && other.unexplained < 0.5 * local.unexplained
                {
                    local = other;
                }
            }
        }
        let good = local.unexplained < 0.5;
        if good {
            omega = local.omega;
        }
        let scale = stride as f64 * (to - from) as f64 / (end - first) as f64;
        let count = ((to - from) as f64 / stride as f64).max(1.0);
        let mut block = Block {
            first,
            end,
            time_s: start + 0.5 * span,
            span_s: span,
            amplitude: local.z[0].hypot(local.z[1]),
            quadrature: 0.0,
            phase: local.z[1].atan2(local.z[0]),
            omega: if good { local.omega } else { omega },
            offset: local.offset,
            unit_variance: local.unit_variance,
            rss: local.rss * scale.max(1.0),
            dof: (count - 6.0).max(1.0),
        };
        if let Some(previous) = blocks.last() {
            let predicted =
                previous.phase + 0.5 * (previous.omega + block.omega) * (block.time_s - previous.time_s);
            block.phase += TAU * ((predicted - block.phase) / TAU).round();
        }
        blocks.push(block);
        first = end;
    }
    blocks
}

/// Range and stride that keep the tracking of a block cheap without aliasing.
fn thinned(first: usize, end: usize, cycles: f64) -> (usize, usize, usize) {
    let count = end - first;
    let stride =
        ((count as f64 / cycles / 24.0).floor() as usize).clamp(1, count.div_ceil(TRACK_SAMPLES).max(1));
    if count / stride <= TRACK_SAMPLES {
        return (first, end, stride);
    }
    let from = first + (count - TRACK_SAMPLES * stride) / 2;
    (from, from + TRACK_SAMPLES * stride, stride)
}

struct Local {
    omega: f64,
    z: [f64; 2],
    offset: f64,
    unit_variance: f64,
    rss: f64,
    /// Residual variance over total variance.
    unexplained: f64,
}

/// Least squares of offset, two phasor components and their slopes; the rotation of the phasor corrects the
/// frequency, at most three times. `None` if the guess itself leaves more than the part `most` of the variance
/// unexplained.
fn refine(
    (time, signal): (&[f64], &[f64]),
    guess: f64,
    start: f64,
    span: f64,
    band: [f64; 2],
    most: f64,
) -> Option<Local> {
    let centre = start + 0.5 * span;
    let half = 0.5 * span;
    let level = signal.first()?;
    let mut omega = guess;
    let mut best: Option<Local> = None;
    for _ in 0..4 {
        let sums = crate::numeric::dispatch(SlopedSums { time, signal, level, centre, half, omega });
        let [c, s, uc, us, cc, cs, ss, ucc, ucs, uss, uucc, uucs, uuss, y, yc, ys, uyc, uys, q] = sums;
        let n = time.len() as f64;
        // Normal equations of 1, cos, -sin, u cos, -u sin.
        #[rustfmt::skip]
        let a = SMatrix::<f64, 5, 5>::new(
            n,    c,    -s,    uc,    -us,
            c,    cc,   -cs,   ucc,   -ucs,
            -s,   -cs,  ss,    -ucs,  uss,
            uc,   ucc,  -ucs,  uucc,  -uucs,
            -us,  -ucs, uss,   -uucs, uuss,
        );
        let g = SVector::<f64, 5>::new(y, yc, -ys, uyc, -uys);
        let total = (q - y * y / n).max(0.0);
        let cholesky = a.cholesky()?;
        let c = cholesky.solve(&g);
        let rss = (q - c.dot(&g)).max(0.0);
        let (p, r) = (c[1], c[2]);
        let power = p * p + r * r;
        let (x, y) = if power > 0.0 { (p / power.sqrt(), r / power.sqrt()) } else { (1.0, 0.0) };
        let along = SVector::<f64, 5>::new(0.0, x, y, 0.0, 0.0);
        let amplitude_variance = along.dot(&cholesky.solve(&along));
        let here = Local {
            omega,
            z: [p, r],
            offset: level + c[0],
            unit_variance: amplitude_variance,
            rss,
            unexplained: if total > 0.0 { rss / total } else { 1.0 },
        };
        if best.is_none() && here.unexplained > most {
            return None;
        }
        // Im(z'/z) is the rotation of the phasor from the middle to the edge.
        let turn = if power > 0.0 { (c[4] * p - c[3] * r) / power } else { 0.0 };
        let better = best.as_ref().is_none_or(|b| here.rss <= b.rss);
        if better {
            best = Some(here);
        }
        let next = omega + (turn / half).clamp(-0.3 * omega, 0.3 * omega);
        if !better || !turn.is_finite() || turn.abs() < 1e-3 || next < band[0] || next > band[1] {
            break;
        }
        omega = next;
    }
    best
}

/// Sums over few samples for the fit with slopes.
struct SlopedSums<'a> {
    time: &'a [f64],
    signal: &'a [f64],
    /// Subtracted from every sample, because the squares of a large offset would swamp the noise.
    level: &'a f64,
    centre: f64,
    half: f64,
    omega: f64,
}

impl pulp::WithSimd for SlopedSums<'_> {
    type Output = [f64; 19];

    /// With `u = (t - centre)/half`: sums of c, s, uc, us, cc, cs, ss, ucc, ucs, uss,
    /// uucc, uucs, uuss, y, yc, ys, uyc, uys, yy.
    #[inline(always)]
    fn with_simd<S: pulp::Simd>(self, simd: S) -> [f64; 19] {
        let mut sums = [simd.splat_f64s(0.0); 19];
        let centre = simd.splat_f64s(self.centre);
        let inverse = simd.splat_f64s(1.0 / self.half);
        let omega = simd.splat_f64s(self.omega);
        let level = simd.splat_f64s(*self.level);
        for (t, y, weight) in wide::Pairs::new(simd, self.time, self.signal) {
            let y = simd.mul_f64s(weight, simd.sub_f64s(y, level));
            let t = simd.sub_f64s(t, centre);
            let (sin, cos) = wide::sin_cos(simd, simd.mul_f64s(omega, t));
            let u = simd.mul_f64s(t, inverse);
            let (c, s) = (simd.mul_f64s(weight, cos), simd.mul_f64s(weight, sin));
            let (uc, us) = (simd.mul_f64s(u, c), simd.mul_f64s(u, s));
            let plain = [(0, c), (1, s), (2, uc), (3, us), (13, y)];
            let products = [
                (4, c, c),
                (5, c, s),
                (6, s, s),
                (7, uc, c),
                (8, uc, s),
                (9, us, s),
                (10, uc, uc),
                (11, uc, us),
                (12, us, us),
                (14, y, c),
                (15, y, s),
                (16, y, uc),
                (17, y, us),
                (18, y, y),
            ];
            for (k, x) in plain {
                sums[k] = simd.add_f64s(sums[k], x);
            }
            for (k, x, y) in products {
                sums[k] = simd.mul_add_e_f64s(x, y, sums[k]);
            }
        }
        let mut totals = [0.0; 19];
        for (total, sum) in totals.iter_mut().zip(sums) {
            *total = simd.reduce_sum_f64s(sum);
        }
        totals
    }
}

/// A phase given at the middle of each block with its first two derivatives.
#[derive(Debug, Clone, Copy)]
pub(crate) struct PhaseAt {
    pub(crate) phase: f64,
    pub(crate) omega: f64,
    pub(crate) chirp: f64,
    /// Relative rate of amplitude loss, 1/s, so that the amplitude is nearly constant within a block.
    pub(crate) loss: f64,
}

/// Amplitude of every block along a given phase, from all samples.
pub(crate) fn demodulate(time: &[f64], signal: &[f64], blocks: &[Block], phases: &[PhaseAt]) -> Vec<Block> {
    let one = |(block, phase): (&Block, &PhaseAt)| along(time, signal, block, *phase);
    #[cfg(feature = "threads")]
    {
        use rayon::prelude::*;
        if signal.len() > 100_000 {
            return blocks.par_iter().zip(phases.par_iter()).map(one).collect();
        }
    }
    blocks.iter().zip(phases).map(one).collect()
}

fn along(time: &[f64], signal: &[f64], block: &Block, phase: PhaseAt) -> Block {
    let range = block.first..block.end;
    let sums = crate::numeric::dispatch(Sums {
        time: &time[range.clone()],
        signal: &signal[range],
        level: block.offset,
        centre: block.time_s,
        phase,
    });
    let [n, c, s, cc, cs, ss, y, yc, ys, yy] = sums;
    // Normal equations of offset, cosine, minus sine.
    let a = SMatrix::<f64, 3, 3>::new(n, c, -s, c, cc, -cs, -s, -cs, ss);
    let g = SVector::<f64, 3>::new(y, yc, -ys);
    let Some(cholesky) = a.cholesky() else {
        return *block;
    };
    let x = cholesky.solve(&g);
    Block {
        amplitude: x[1],
        quadrature: x[2],
        phase: phase.phase,
        omega: phase.omega,
        offset: block.offset + x[0],
        unit_variance: cholesky.inverse()[(1, 1)],
        rss: (yy - x.dot(&g)).max(0.0),
        dof: (n - 3.0).max(1.0),
        ..*block
    }
}

struct Sums<'a> {
    time: &'a [f64],
    signal: &'a [f64],
    /// Subtracted from every sample, as in [`SlopedSums`].
    level: f64,
    centre: f64,
    phase: PhaseAt,
}

impl pulp::WithSimd for Sums<'_> {
    type Output = [f64; 10];

    /// Sums of 1, c, s, cc, cs, ss, y, yc, ys, yy over the block.
    #[inline(always)]
    fn with_simd<S: pulp::Simd>(self, simd: S) -> [f64; 10] {
        let mut sums = [simd.splat_f64s(0.0); 9];
        let centre = simd.splat_f64s(self.centre);
        let phase = simd.splat_f64s(self.phase.phase);
        let omega = simd.splat_f64s(self.phase.omega);
        let half_chirp = simd.splat_f64s(0.5 * self.phase.chirp);
        let minus_loss = simd.splat_f64s(-self.phase.loss);
        let one = simd.splat_f64s(1.0);
        let level = simd.splat_f64s(self.level);
        for (t, y, weight) in wide::Pairs::new(simd, self.time, self.signal) {
            let y = simd.mul_f64s(weight, simd.sub_f64s(y, level));
            let t = simd.sub_f64s(t, centre);
            let angle = simd.mul_add_e_f64s(simd.mul_add_e_f64s(half_chirp, t, omega), t, phase);
            let (sin, cos) = wide::sin_cos(simd, angle);
            let shape = simd.mul_f64s(weight, simd.mul_add_e_f64s(minus_loss, t, one));
            let (c, s) = (simd.mul_f64s(cos, shape), simd.mul_f64s(sin, shape));
            let products = [(c, c), (c, s), (s, s), (y, c), (y, s), (y, y)];
            for (sum, x) in sums.iter_mut().zip([c, s, y]) {
                *sum = simd.add_f64s(*sum, x);
            }
            for (sum, (x, y)) in sums[3..].iter_mut().zip(products) {
                *sum = simd.mul_add_e_f64s(x, y, *sum);
            }
        }
        let mut totals = [0.0; 9];
        for (total, sum) in totals.iter_mut().zip(sums) {
            *total = simd.reduce_sum_f64s(sum);
        }
        let [c, s, y, cc, cs, ss, yc, ys, yy] = totals;
        [self.signal.len() as f64, c, s, cc, cs, ss, y, yc, ys, yy]
    }
}

/// Noise of one sample: root of the median of the blocks' residual variances.
///
/// The median excludes jolts and glitches; `median_bias` corrects the difference between median and mean of a
/// chi-squared distribution.
pub(crate) fn noise_rms(blocks: &[Block]) -> f64 {
    let mut variances: Vec<f64> = blocks
        .iter()
        .map(|b| {
            let median_bias = (1.0 - 2.0 / (9.0 * b.dof)).powi(3);
            b.rss / b.dof / median_bias
        })
        .collect();
    median(&mut variances).unwrap_or(0.0).sqrt()
}

/// The phase wrapped to `(-pi, pi]`.
pub(crate) fn wrap(phase: f64) -> f64 {
    phase - TAU * ((phase - PI) / TAU).ceil()
}
