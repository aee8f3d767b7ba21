//! The Fourier transform of samples on a uniform grid.

use super::fourier;
use crate::numeric::{extremes, robust::median, trig};
use nalgebra::Complex;
use std::borrow::Cow;
use std::cell::RefCell;
use std::f64::consts::{FRAC_PI_2, PI};

thread_local! {
    // Blocks of this size are allocated page by page, which takes as long as a transform.
    static BUFFERS: RefCell<Buffers> = RefCell::default();
}

/// Input, output and scratch memory of a transform.
#[derive(Default)]
struct Buffers {
    real: Vec<f64>,
    complex: Vec<Complex<f64>>,
    scratch: Vec<Complex<f64>>,
}

/// Longest transform used; for a longer record its loudest part is taken.
pub(super) const LONGEST: usize = 1 << 15;

/// Samples on a uniform grid, obtained from any clock by linear interpolation.
pub(super) struct Grid<'a> {
    pub(super) interval_s: f64,
    pub(super) values: Cow<'a, [f64]>,
}

/// Median of the positive steps of a clock, from at most 2000 of them.
pub(super) fn median_step(time: &[f64]) -> f64 {
    let stride = (time.len() / 1000).max(1);
    let mut steps = Vec::with_capacity(time.len() / stride + 1);
    steps.extend(time.windows(2).step_by(stride).map(|w| w[1] - w[0]).filter(|&d| d > 0.0));
    // A uniform clock needs no search: its smallest and largest steps differ by rounding only.
    let (least, most) = extremes(&steps);
    if least >= (1.0 - SAME_STEP) * most {
        return 0.5 * (least + most);
    }
    median(&mut steps).unwrap_or(f64::NAN)
}

/// Relative difference of the steps of a uniform clock that is attributed to rounding.
const SAME_STEP: f64 = 1e-9;

/// Deviation of the stamps of a uniform clock, in parts of an interval, after rounding of many steps.
const SAME_INSTANT: f64 = 1e-6;

impl Grid<'_> {
    /// Length of the stretch, s.
    pub(super) fn duration(&self) -> f64 {
        self.values.len() as f64 * self.interval_s
    }
}

/// A grid over a record, or over its loudest part if it is long, and the number of samples from which it was made;
/// `None` for fewer than eight.
pub(super) fn loudest_grid<'a>(time: &[f64], signal: &'a [f64]) -> Option<(Grid<'a>, usize)> {
    if time.len() < 8 {
        return None;
    }
    let (from, to) = loudest(signal, LONGEST);
    let (t, y) = (&time[from..to], &signal[from..to]);
    let least = (t[t.len() - 1] - t[0]) / (2.0 * LONGEST as f64);
    Some((resample(t, y, median_step(t).max(least)), to - from))
}

/// The stretch of at most `longest` samples with the highest variance.
pub(super) fn loudest(signal: &[f64], longest: usize) -> (usize, usize) {
    if signal.len() <= longest {
        return (0, signal.len());
    }
    let hop = longest / 4;
    let stride = (hop / 64).clamp(1, 8);
    let sums: Vec<[f64; 3]> = signal.chunks_exact(hop).map(|part| strided_sums(part, stride)).collect();
    let mut best = (0, f64::NEG_INFINITY);
    for (i, four) in sums.windows(4).enumerate() {
        let [n, s, q] = four.iter().fold([0.0; 3], |[n, s, q], p| [n + p[0], s + p[1], q + p[2]]);
        let variance = q / n - (s / n) * (s / n);
        if variance > best.1 {
            best = (i * hop, variance);
        }
    }
    (best.0, (best.0 + longest).min(signal.len()))
}

/// Number, sum and sum of squares of every `stride`-th value; in separate lanes, because in a single chain each
/// addition waits for the last.
fn strided_sums(values: &[f64], stride: usize) -> [f64; 3] {
    const LANES: usize = 4;
    let (mut sum, mut squares) = ([0.0; LANES], [0.0; LANES]);
    let mut rows = values.chunks_exact(LANES * stride);
    let mut count = 0;
    for row in &mut rows {
        for k in 0..LANES {
            let v = row[k * stride];
            sum[k] += v;
            squares[k] += v * v;
        }
        count += LANES;
    }
    for (k, v) in rows.remainder().iter().step_by(stride).enumerate() {
        sum[k] += v;
        squares[k] += v * v;
        count += 1;
    }
    [count as f64, sum.iter().sum(), squares.iter().sum()]
}

fn resample<'a>(time: &[f64], signal: &'a [f64], interval_s: f64) -> Grid<'a> {
    let start = time[0];
    let count = (((time[time.len() - 1] - start) / interval_s).floor() as usize + 1).min(4 * LONGEST);
    if count <= time.len() {
        let misses =
            |i: usize, t: f64| (t - (start + i as f64 * interval_s)).abs() > SAME_INSTANT * interval_s;
        let missed = time[..count].iter().enumerate().fold(false, |any, (i, &t)| any | misses(i, t));
        if !missed {
            return Grid { interval_s, values: Cow::Borrowed(&signal[..count]) };
        }
    }
    let mut right = 1;
    let values = (0..count)
        .map(|i| {
            let t = start + i as f64 * interval_s;
            while right + 1 < time.len() && time[right] < t {
                right += 1;
            }
            let (a, b) = (time[right - 1], time[right]);
            // Within a gap nothing is known: the previous value is held.
            if b > a && b - a < 20.0 * interval_s {
                signal[right - 1] + (signal[right] - signal[right - 1]) * ((t - a) / (b - a)).clamp(0.0, 1.0)
            } else {
                signal[right - 1]
            }
        })
        .collect();
    Grid { interval_s, values: Cow::Owned(values) }
}

/// Amplitude spectrum of the grid after subtracting a straight line, with a Hann window: amplitude per bin and bin
/// width in Hz.
pub(super) fn amplitudes(grid: &Grid) -> (Vec<f64>, f64) {
    let n = grid.values.len();
    // The window's sum is n/2 for every n above one.
    let scale = if n > 1 { 4.0 / n as f64 } else { 2.0 };
    let spectrum = transform(grid, |complex| {
        let mut moduli = vec![0.0; complex.len()];
        crate::numeric::dispatch(Moduli { of: complex, scale, out: &mut moduli });
        moduli
    });
    (spectrum.unwrap_or_default(), bin_hz(grid))
}

/// Length of the transform of a grid: at least twice the number of values.
fn padded(grid: &Grid) -> usize {
    (2 * grid.values.len()).next_power_of_two()
}

/// Width of a bin of that transform, Hz.
pub(super) fn bin_hz(grid: &Grid) -> f64 {
    1.0 / (padded(grid) as f64 * grid.interval_s)
}

/// Applies `of` to the transform of the grid after subtracting a straight line, with a Hann window.
pub(super) fn transform<R>(grid: &Grid, of: impl FnOnce(&[Complex<f64>]) -> R) -> Option<R> {
    let n = grid.values.len();
    let padded = padded(grid);
    let mid = 0.5 * (n as f64 - 1.0);
    let (mean, slope) = crate::numeric::dispatch(StraightLine { values: &grid.values, mid });
    BUFFERS.with_borrow_mut(|Buffers { real, complex, scratch }| {
        real.resize(padded, 0.0);
        complex.resize(padded / 2 + 1, Complex::default());
        real[n..].fill(0.0);
        crate::numeric::dispatch(Windowed { grid: &grid.values, mean, slope, mid, out: &mut real[..n] });
        fourier::forward(real, complex, scratch).then(|| of(complex))
    })
}

/// Mean and slope of values as a function of their index, whose mean is `mid`.
struct StraightLine<'a> {
    values: &'a [f64],
    mid: f64,
}

impl pulp::NullaryFnOnce for StraightLine<'_> {
    type Output = (f64, f64);

    #[inline(always)]
    fn call(self) -> (f64, f64) {
        const LANES: usize = 8;
        let n = self.values.len() as f64;
        let (pieces, rest) = self.values.as_chunks::<LANES>();
        let (mut sums, mut moments) = ([0.0; LANES], [0.0; LANES]);
        let mut first = -self.mid;
        for piece in pieces {
            for ((sum, moment), v) in sums.iter_mut().zip(&mut moments).zip(piece) {
                *sum += v;
                *moment += first * v;
            }
            first += LANES as f64;
        }
        let (mut sum, mut moment) = (0.0, 0.0);
        for (k, (lane, lane_moment)) in sums.into_iter().zip(moments).enumerate() {
            sum += lane;
            moment += lane_moment + k as f64 * lane;
        }
        for (k, v) in rest.iter().enumerate() {
            sum += v;
            moment += (first + k as f64) * v;
        }
        // Sum of the squared indices about their mean.
        let squares = n * (n * n - 1.0) / 12.0;
        (sum / n, if squares > 0.0 { moment / squares } else { 0.0 })
    }
}

/// The grid minus its straight line, times the Hann window `sin²(pi (i + 1/2)/n)`.
struct Windowed<'a> {
    grid: &'a [f64],
    mean: f64,
    slope: f64,
    mid: f64,
    out: &'a mut [f64],
}

impl pulp::NullaryFnOnce for Windowed<'_> {
    type Output = ();

    #[inline(always)]
    fn call(self) {
        let step = PI / self.grid.len() as f64;
        // A floating-point counter would be one chain of additions.
        for ((out, &v), i) in self.out.iter_mut().zip(self.grid).zip(0i32..) {
            let at = f64::from(i);
            let (_, w) = trig::half_turn((at + 0.5) * step - FRAC_PI_2);
            *out = w * w * (v - self.mean - self.slope * (at - self.mid));
        }
    }
}

/// Moduli of numbers, times a scale.
struct Moduli<'a> {
    of: &'a [Complex<f64>],
    scale: f64,
    out: &'a mut [f64],
}

impl pulp::NullaryFnOnce for Moduli<'_> {
    type Output = ();

    #[inline(always)]
    fn call(self) {
        for (out, c) in self.out.iter_mut().zip(self.of) {
            *out = (c.re * c.re + c.im * c.im).sqrt() * self.scale;
        }
    }
}
