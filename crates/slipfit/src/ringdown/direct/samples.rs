//! Least-squares fit of the exact motion to samples, and start values near the minimum.

use super::minimise::{Minimum, Sums, minimise};
use crate::motion::decay::amplitude::sliding_gain;
use crate::motion::decay::closed_sums::ClosedSums;
pub(super) use crate::motion::decay::closed_sums::{Pass, Stop};
use crate::signal::blocks::{self, Block, PhaseAt};
use std::f64::consts::TAU;

/// The samples and their sum of squares.
pub(super) struct Samples<'a> {
    pub(super) time: &'a [f64],
    pub(super) signal: &'a [f64],
    pub(super) power: f64,
}

impl Samples<'_> {
    pub(super) fn sums(&self, p: &[f64; 6], stop: Stop) -> Option<Sums<6>> {
        let (time, signal, origin) = (self.time, self.signal, self.time[0]);
        let (borders, parts) = (&[][..], &mut Vec::new());
        let pass = Pass { time, signal, origin, p, stop, models_rest_position: true, borders, parts };
        let ClosedSums { jtj, jtr, rss, .. } = crate::numeric::dispatch(pass)?;
        Some(Sums { jtj, jtr, rss })
    }

    pub(super) fn fit(&self, from: [f64; 6], stop: Stop) -> Option<Minimum<6>> {
        let moved = |p: &[f64; 6], step: &[f64; 6]| std::array::from_fn(|k| p[k] + step[k]);
        minimise(from, self.time.len() as f64, self.power, |p| self.sums(p, stop), moved)
    }

    /// Whether the last samples scatter less about their mean than all residuals of a fit do, which white
    /// noise would not.
    pub(super) fn end_is_calmer(&self, rss: f64) -> bool {
        let n = self.signal.len();
        let end = &self.signal[n - (n / END_PART).clamp(END_LEAST.min(n), END_MOST)..];
        let count = end.len() as f64;
        let mean = end.iter().sum::<f64>() / count;
        let scatter = end.iter().map(|y| (y - mean).powi(2)).sum::<f64>() / (count - 1.0);
        rss / n as f64 > REST_VARIANCE_RATIO * scatter
    }
}

/// Part of the record, as a fraction and as minimum and maximum number of samples, that is examined for a
/// rest.
const END_PART: usize = 16;
const END_LEAST: usize = 8;
const END_MOST: usize = 128;
/// Ratio of the residual variance of a fit to the variance of the end above which the end is at rest.
const REST_VARIANCE_RATIO: f64 = 1.6;

/// Maximum number of pieces whose amplitudes and phases improve the start values.
const PIECES: usize = 24;

/// Improved start values: amplitude and phase of a few pieces are measured along the phase of the given
/// start, a straight line is fitted to the phases and the averaged law to the amplitudes. Also returns the
/// residual sum of squares of the pieces. `None` for fewer than four cycles or if the result is not
/// plausible.
pub(super) fn improved_start(time: &[f64], signal: &[f64], at: &[f64; 6]) -> Option<([f64; 6], f64)> {
    let &[_, x_f, delta, phase, omega, _] = at;
    let (origin, n) = (time[0], time.len());
    let cycles = omega / TAU * (time[n - 1] - origin);
    let count = (cycles.min(n as f64 / 12.0) as usize).min(PIECES);
    if count < 4 {
        return None;
    }
    let pieces: Vec<Block> = (0..count)
        .map(|i| {
            let (first, end) = (i * n / count, (i + 1) * n / count);
            Block::of(first, end, 0.5 * (time[first] + time[end - 1]))
        })
        .collect();
    let along: Vec<PhaseAt> = pieces
        .iter()
        .map(|b| PhaseAt { phase: phase + omega * (b.time_s - origin), omega, chirp: 0.0, loss: 0.0 })
        .collect();
    let found = blocks::demodulate(time, signal, &pieces, &along);
    let centres: Vec<f64> = found.iter().map(|b| b.time_s).collect();
    let amplitudes: Vec<f64> = found.iter().map(|b| b.amplitude.hypot(b.quadrature)).collect();
    // Straight line through the phases, weighted by the square of the amplitude.
    let mut line = [0.0; 5];
    let mut ahead = 0.0;
    for (b, a) in found.iter().zip(&amplitudes) {
        let turn = b.quadrature.atan2(b.amplitude);
        ahead = turn + TAU * ((ahead - turn) / TAU).round();
        let (t, w) = (b.time_s - origin, a * a);
        for (sum, term) in line.iter_mut().zip([w, w * t, w * t * t, w * ahead, w * t * ahead]) {
            *sum += term;
        }
    }
    let [w, wt, wtt, wp, wtp] = line;
    let bend = w * wtt - wt * wt;
    let (shift, rate) = ((wtt * wp - wt * wtp) / bend, (w * wtp - wt * wp) / bend);
    let next = omega + rate;
    let offset_amplitude = x_f * sliding_gain(delta, omega)[0] / delta;
    let start = super::EnvelopeStart {
        initial_amplitude: amplitudes[0],
        offset_amplitude: if offset_amplitude.is_finite() { offset_amplitude } else { 0.0 },
        decay_rate_per_s: delta,
    };
    let law = super::fit_envelope(&centres, &amplitudes, &start).ok().filter(|f| f.converged)?.best;
    let (c, delta) = (law.offset_amplitude, law.decay_rate_per_s);
    let first = (law.initial_amplitude + c) * (delta * (centres[0] - origin)).exp() - c;
    let mean = found.iter().map(|b| b.offset).sum::<f64>() / count as f64;
    let near = [first, c * delta / sliding_gain(delta, next)[0], delta, phase + shift, next, mean];
    let sound = near.iter().all(|v| v.is_finite()) && next > 0.5 * omega && next < 2.0 * omega && first > 0.0;
    sound.then(|| (near, found.iter().map(|b| b.rss).sum()))
}
