//! Periodogram: the oscillations of a stretch of record, and a band-pass filter.

use crate::inference::least_squares::linear;
use crate::numeric::{order::sort_by_value, robust::median, trig};
use realfft::RealFftPlanner;
use realfft::num_complex::Complex;
use std::borrow::Cow;
use std::cell::RefCell;
use std::f64::consts::{FRAC_PI_2, PI, TAU};

thread_local! {
    // Planning costs more than one transform; records of one length share a plan.
    static PLANNER: RefCell<RealFftPlanner<f64>> = RefCell::new(RealFftPlanner::new());
    // Blocks of this size come from the system page by page, which takes as long as a transform.
    static BUFFERS: RefCell<Buffers> = RefCell::default();
}

/// What a transform reads, writes and needs besides.
#[derive(Default)]
struct Buffers {
    real: Vec<f64>,
    complex: Vec<Complex<f64>>,
    scratch: Vec<Complex<f64>>,
}

/// Longest transform used; of a longer record its loudest part is taken.
const LONGEST: usize = 1 << 15;

/// One line of a spectrum.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct Line {
    pub(crate) frequency_hz: f64,
    pub(crate) amplitude: f64,
}

/// Samples on an even grid, made from any clock by linear interpolation.
pub(crate) struct Grid<'a> {
    pub(crate) interval_s: f64,
    pub(crate) values: Cow<'a, [f64]>,
}

/// Median of the steps of a clock, from at most 1001 of them.
pub(crate) fn median_step(time: &[f64]) -> f64 {
    let stride = (time.len() / 1000).max(1);
    let mut steps: Vec<f64> =
        time.windows(2).step_by(stride).map(|w| w[1] - w[0]).filter(|&d| d > 0.0).collect();
    median(&mut steps).unwrap_or(f64::NAN)
}

/// Part of an interval by which the stamps of an even clock miss it, after rounding of many steps.
const SAME_INSTANT: f64 = 1e-6;

/// Boxcar means of `width` samples.
pub(crate) fn averaged(time: &[f64], signal: &[f64], width: usize) -> (Vec<f64>, Vec<f64>) {
    let mean = |v: &[f64]| v.iter().sum::<f64>() / v.len() as f64;
    (time.chunks_exact(width).map(mean).collect(), signal.chunks_exact(width).map(mean).collect())
}

pub(crate) fn resample<'a>(time: &[f64], signal: &'a [f64], interval_s: f64) -> Grid<'a> {
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
            // Across a gap nothing is known: hold zero weight by holding the earlier value.
            if b > a && b - a < 20.0 * interval_s {
                signal[right - 1] + (signal[right] - signal[right - 1]) * ((t - a) / (b - a)).clamp(0.0, 1.0)
            } else {
                signal[right - 1]
            }
        })
        .collect();
    Grid { interval_s, values: Cow::Owned(values) }
}

/// Amplitude spectrum of the grid less its straight line, Hann window: amplitude per bin and bin width in Hz.
pub(crate) fn amplitudes(grid: &Grid) -> (Vec<f64>, f64) {
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

/// Length of the transform of a grid, twice as many values and more.
fn padded(grid: &Grid) -> usize {
    (2 * grid.values.len()).next_power_of_two()
}

/// Width of a bin of that transform, Hz.
fn bin_hz(grid: &Grid) -> f64 {
    1.0 / (padded(grid) as f64 * grid.interval_s)
}

/// What `of` makes of the transform of a grid less its straight line, Hann window.
fn transform<R>(grid: &Grid, of: impl FnOnce(&[Complex<f64>]) -> R) -> Option<R> {
    let n = grid.values.len();
    let padded = padded(grid);
    let mid = 0.5 * (n as f64 - 1.0);
    let (mean, slope) = crate::numeric::dispatch(StraightLine { values: &grid.values, mid });
    let fft = PLANNER.with_borrow_mut(|planner| planner.plan_fft_forward(padded));
    BUFFERS.with_borrow_mut(|Buffers { real, complex, scratch }| {
        real.resize(padded, 0.0);
        complex.resize(padded / 2 + 1, Complex::default());
        scratch.resize(fft.get_scratch_len(), Complex::default());
        real[n..].fill(0.0);
        crate::numeric::dispatch(Windowed { grid: &grid.values, mean, slope, mid, out: &mut real[..n] });
        fft.process_with_scratch(real, complex, scratch).ok().map(|()| of(complex))
    })
}

/// Mean and slope of values by their number, of which `mid` is the mean.
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
        // The squares of the numbers about their mean.
        let squares = n * (n * n - 1.0) / 12.0;
        (sum / n, if squares > 0.0 { moment / squares } else { 0.0 })
    }
}

/// The grid less its straight line, times the Hann window `sin²(pi (i + 1/2)/n)`.
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
        // A count of floating point would be one chain of additions.
        for ((out, &v), i) in self.out.iter_mut().zip(self.grid).zip(0i32..) {
            let at = f64::from(i);
            let (_, w) = trig::half_turn((at + 0.5) * step - FRAC_PI_2);
            *out = w * w * (v - self.mean - self.slope * (at - self.mid));
        }
    }
}

/// Sum of the squared moduli of numbers.
struct Power<'a> {
    of: &'a [Complex<f64>],
}

impl pulp::NullaryFnOnce for Power<'_> {
    type Output = f64;

    #[inline(always)]
    fn call(self) -> f64 {
        const LANES: usize = 8;
        let (pieces, rest) = self.of.as_chunks::<LANES>();
        let mut sums = [0.0; LANES];
        for piece in pieces {
            sums.iter_mut().zip(piece).for_each(|(sum, c)| *sum += c.norm_sqr());
        }
        sums.iter().sum::<f64>() + rest.iter().map(Complex::norm_sqr).sum::<f64>()
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

/// Position of a peak by the parabola through the logarithms of three bins.
fn refine(spectrum: &[f64], i: usize, width: f64) -> Line {
    let l = |k: usize| spectrum[k].max(f64::MIN_POSITIVE).ln();
    if i == 0 || i + 1 >= spectrum.len() {
        return Line { frequency_hz: i as f64 * width, amplitude: spectrum[i] };
    }
    let (a, b, c) = (l(i - 1), l(i), l(i + 1));
    let bend = a - 2.0 * b + c;
    let shift = if bend < 0.0 { (0.5 * (a - c) / bend).clamp(-0.5, 0.5) } else { 0.0 };
    Line { frequency_hz: (i as f64 + shift) * width, amplitude: (b - 0.25 * (a - c) * shift).exp() }
}

impl Grid<'_> {
    fn duration(&self) -> f64 {
        self.values.len() as f64 * self.interval_s
    }
}

/// A grid over a record, or over its loudest part where it is long, and how many samples it is made of; `None` for
/// fewer than eight.
fn loudest_grid<'a>(time: &[f64], signal: &'a [f64]) -> Option<(Grid<'a>, usize)> {
    if time.len() < 8 {
        return None;
    }
    let (from, to) = loudest(signal, LONGEST);
    let (t, y) = (&time[from..to], &signal[from..to]);
    let least = (t[t.len() - 1] - t[0]) / (2.0 * LONGEST as f64);
    Some((resample(t, y, median_step(t).max(least)), to - from))
}

/// Amplitude spectrum of a record, of its loudest part where it is long.
#[derive(Debug)]
pub(crate) struct Periodogram {
    spectrum: Vec<f64>,
    /// Width of a bin, Hz.
    bin: f64,
    /// Length of the stretch, s, and in samples.
    duration: f64,
    pub(crate) samples: usize,
}

impl Periodogram {
    /// `None` for fewer than eight samples.
    pub(crate) fn of(time: &[f64], signal: &[f64]) -> Option<Self> {
        let (grid, samples) = loudest_grid(time, signal)?;
        let (spectrum, bin) = amplitudes(&grid);
        Some(Self { spectrum, bin, duration: grid.duration(), samples })
    }

    fn strongest(&self, band_hz: Option<[f64; 2]>) -> Option<Line> {
        // Below one cycle per stretch there is only drift.
        let lowest = band_hz.map_or(0.0, |b| b[0]).max(0.7 / self.duration);
        let highest = band_hz.map_or(f64::INFINITY, |b| b[1]);
        let inside = |i: &usize| (lowest..=highest).contains(&(*i as f64 * self.bin));
        let bins = self.spectrum.len();
        let from = (0..bins).skip((lowest / self.bin) as usize).find(inside)?;
        let about = ((highest / self.bin) as usize).saturating_add(2).min(bins);
        let end = (from..about).rfind(inside)? + 1;
        let peak = from + highest_of(&self.spectrum[from..end])?;
        Some(refine(&self.spectrum, peak, self.bin))
    }
}

/// Index of the largest value, the last of equal ones.
fn highest_of(values: &[f64]) -> Option<usize> {
    const LANES: usize = 8;
    let (pieces, rest) = values.as_chunks::<LANES>();
    let mut most = [f64::NEG_INFINITY; LANES];
    for piece in pieces {
        for (m, v) in most.iter_mut().zip(piece) {
            *m = if v > m { *v } else { *m };
        }
    }
    let most = most.iter().chain(rest).copied().fold(f64::NEG_INFINITY, f64::max);
    values.iter().rposition(|v| *v == most)
}

/// Power density of noise about a frequency.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct Density {
    /// Over the mean density up to half the sampling rate: 1 for white noise.
    pub(crate) ratio: f64,
    /// Density at the lowest frequencies over the mean one; 0 where the band of the motion reaches down to them.
    pub(crate) lowest: f64,
    /// Degrees of freedom of that ratio.
    pub(crate) degrees: f64,
}

/// Relative width of the band about a frequency in which the density of noise is that at it.
const BAND: [f64; 2] = [0.5, 1.5];
/// Bins of independent noise that a Hann window merges into one.
const HANN_BINS: f64 = 1.5;
/// Relative deviation of the mean step of a clock from the median one that is still an even clock.
const EVEN: f64 = 0.01;
/// Bins of a spectrum that tell how an offset wanders.
const LOWEST: usize = 12;

/// The density of residuals about a frequency, which sets how well an oscillation there is known;
/// `None` for an uneven clock, whose interpolation is no white noise, or less than a cycle.
pub(crate) fn density_near(time: &[f64], residuals: &[f64], frequency_hz: f64) -> Option<Density> {
    let steps = (time.len().max(2) - 1) as f64;
    let mean_step = (time.last()? - time.first()?) / steps;
    if !((mean_step / median_step(time) - 1.0).abs() < EVEN) {
        return None;
    }
    let (grid, _) = loudest_grid(time, residuals)?;
    let (bin, duration) = (bin_hz(&grid), grid.duration());
    transform(&grid, |spectrum| density_of(spectrum, bin, duration, frequency_hz))?
}

/// The same of a transform.
fn density_of(spectrum: &[Complex<f64>], bin: f64, duration: f64, frequency_hz: f64) -> Option<Density> {
    let power = |range: std::ops::Range<usize>| {
        let part = spectrum.get(range)?;
        (!part.is_empty()).then(|| crate::numeric::dispatch(Power { of: part }) / part.len() as f64)
    };
    let index = |hz: f64| ((hz / bin) as usize).min(spectrum.len());
    let (from, to) = (index(BAND[0] * frequency_hz), index(BAND[1] * frequency_hz));
    let white = power(1..spectrum.len())?;
    let ratio = power(from..to)? / white;
    // The lowest bins hold the offset, which is fitted.
    let lowest_end = index((LOWEST as f64 * bin).min(BAND[0] * frequency_hz));
    let lowest = power(1..lowest_end).map_or(0.0, |p| p / white);
    let degrees = 2.0 * (to - from) as f64 * bin * duration / HANN_BINS;
    (ratio.is_finite() && lowest.is_finite() && degrees > 0.0).then_some(Density { ratio, lowest, degrees })
}

/// The strongest oscillation of the record, inside `band_hz` when given.
///
/// Long records are searched in the stretch of highest variance; when fewer
/// than eight cycles fit into it, it is averaged eightfold and lengthened.
pub(crate) fn dominant(time: &[f64], signal: &[f64], band_hz: Option<[f64; 2]>) -> Option<Line> {
    dominant_of(&Periodogram::of(time, signal)?, time, signal, band_hz)
}

/// As [`dominant`], its periodogram already at hand.
pub(crate) fn dominant_of(
    periodogram: &Periodogram,
    time: &[f64],
    signal: &[f64],
    band_hz: Option<[f64; 2]>,
) -> Option<Line> {
    let mut width = 1;
    let mut wider: Option<Periodogram> = None;
    loop {
        let here = wider.as_ref().unwrap_or(periodogram);
        let line = here.strongest(band_hz)?;
        let whole = here.samples >= signal.len() / width;
        let many_cycles = line.frequency_hz * here.duration >= 8.0;
        if many_cycles && !(whole && width == 1 && is_weak(&line, signal)) {
            return Some(line);
        }
        if whole {
            let apart = |found: &Line| {
                let ratio = found.frequency_hz / line.frequency_hz;
                !many_cycles || !(1.0 / SAME..=SAME).contains(&ratio)
            };
            return Some(brief(time, signal, band_hz, &line).filter(apart).unwrap_or(line));
        }
        width *= 8;
        let (t, y) = averaged(time, signal, width);
        wider = Some(Periodogram::of(&t, &y)?);
    }
}

/// Whether the amplitude of a line is a small part of the largest deflection: noise may be what is strongest on the
/// average over a record.
fn is_weak(line: &Line, signal: &[f64]) -> bool {
    let mean = signal.iter().sum::<f64>() / signal.len() as f64;
    let largest = signal.iter().map(|x| (x - mean).abs()).fold(0.0, f64::max);
    line.amplitude < WEAK * largest
}

/// Part of the largest deflection below which a line may be one of noise.
const WEAK: f64 = 0.1;
/// Ratio of two frequencies within which one of them is no news of the other.
const SAME: f64 = 1.5;
/// What the line of a part leaves of it over what that of all leaves: the strongest line of noise in a hundred samples
/// explains a seventh of them.
const MOST_LEFT: f64 = 0.75;

/// An oscillation over long before the record is: the window has hidden what swings at its very
/// beginning, and the place of rest is left. Where a part of it swings clearly wider, it counts, unless
/// the line found over all describes that part as well: few swings leak into every frequency.
fn brief(time: &[f64], signal: &[f64], band_hz: Option<[f64; 2]>, line: &Line) -> Option<Line> {
    let long_enough = |parts: &usize| signal.len() / parts >= 16;
    [4, 16, 64].into_iter().filter(long_enough).find_map(|parts| {
        let (from, to) = loudest(signal, signal.len() / parts);
        let part = Periodogram::of(&time[from..to], &signal[from..to])?;
        let found = part.strongest(band_hz)?;
        let cycles = found.frequency_hz * part.duration;
        let left = |line: &Line| left_by_sine(&time[from..to], &signal[from..to], line.frequency_hz);
        let wider = cycles >= 3.0 && found.amplitude > 2.0 * line.amplitude;
        (wider && left(&found) < MOST_LEFT * left(line)).then_some(found)
    })
}

/// Sum of squares that a sine about a straight line leaves of a signal.
fn left_by_sine(time: &[f64], signal: &[f64], frequency_hz: f64) -> f64 {
    let rows = time.iter().zip(signal).map(|(&t, &x)| {
        let (v, (sin, cos)) = (t - time[0], (TAU * frequency_hz * (t - time[0])).sin_cos());
        (vec![1.0, v, cos, sin], x, 1.0)
    });
    linear(rows, 4).map_or(f64::INFINITY, |(_, _, rss)| rss)
}

/// The strongest line where an evenly sampled signal is loudest; values that are no numbers count
/// as the one before.
pub(crate) fn loudest_line(signal: &[f64], interval_s: f64) -> Option<Line> {
    if signal.len() < 8 {
        return None;
    }
    let (from, to) = loudest(signal, LONGEST);
    let mut last = 0.0;
    let values: Vec<f64> = signal[from..to]
        .iter()
        .map(|&v| {
            last = if v.is_finite() { v } else { last };
            last
        })
        .collect();
    let duration = values.len() as f64 * interval_s;
    let samples = values.len();
    let (spectrum, bin) = amplitudes(&Grid { interval_s, values: Cow::Owned(values) });
    Periodogram { spectrum, bin, duration, samples }.strongest(None)
}

/// The stretch of at most `longest` samples with the highest variance.
fn loudest(signal: &[f64], longest: usize) -> (usize, usize) {
    if signal.len() <= longest {
        return (0, signal.len());
    }
    let hop = longest / 4;
    let stride = (hop / 64).clamp(1, 8);
    let sums: Vec<[f64; 3]> = signal
        .chunks_exact(hop)
        .map(|part| part.iter().step_by(stride).fold([0.0; 3], |[n, s, q], &v| [n + 1.0, s + v, q + v * v]))
        .collect();
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

/// Lines of at least this amplitude other than the main one, its neighbourhood
/// and its harmonics, strongest first.
pub(crate) fn other_lines(
    periodogram: &Periodogram,
    main_hz: f64,
    relative_width: f64,
    least: f64,
) -> Vec<Line> {
    let Periodogram { spectrum, bin, duration, samples } = periodogram;
    if *samples < 32 {
        return Vec::new();
    }
    let near = (relative_width * main_hz).max(4.0 / duration);
    let mut lines: Vec<Line> = (2..spectrum.len().saturating_sub(2))
        // The parabola lifts a peak of the Hann window by far less than fourfold.
        .filter(|&i| spectrum[i] > 0.25 * least)
        .filter(|&i| spectrum[i] > spectrum[i - 1] && spectrum[i] >= spectrum[i + 1])
        .map(|i| refine(spectrum, i, *bin))
        .filter(|l| {
            let order = (l.frequency_hz / main_hz).round();
            l.amplitude >= least
                && l.frequency_hz > 3.0 / duration
                && (l.frequency_hz - order.max(1.0) * main_hz).abs() > near
        })
        .collect();
    sort_by_value(&mut lines, |l| -l.amplitude);
    lines.truncate(5);
    lines
}

/// The strongest harmonic up to the fifth: its order and amplitude.
pub(crate) fn strongest_harmonic(periodogram: &Periodogram, main_hz: f64) -> Option<(usize, f64)> {
    let Periodogram { spectrum, bin, duration, .. } = periodogram;
    // Closer than this the main line's own width reaches the second harmonic.
    if main_hz * duration < 8.0 {
        return None;
    }
    (2..=5)
        .filter_map(|order| {
            let middle = order as f64 * main_hz / bin;
            let reach = (0.02 * middle).max(2.0);
            let (from, to) = ((middle - reach) as usize, (middle + reach).ceil() as usize);
            let highest = spectrum.get(from..=to)?.iter().fold(0.0f64, |m, &a| m.max(a));
            Some((order, highest))
        })
        .max_by(|a, b| a.1.total_cmp(&b.1))
}

/// The signal's part between two frequencies, edges rounded over a tenth of
/// the band, read back at the stamps given.
pub(crate) fn band_pass(time: &[f64], signal: &[f64], band_hz: [f64; 2]) -> Vec<f64> {
    let start = time[0];
    let duration = time[time.len() - 1] - start;
    // Fine enough for the band, never finer than the record.
    let step = median_step(time).max(duration / 4e6);
    let count = (duration / step).floor() as usize + 1;
    let mean = signal.iter().sum::<f64>() / signal.len() as f64;
    let mut right = 1;
    let mut buffer = vec![0.0; (2 * count).next_power_of_two()];
    for (i, v) in buffer.iter_mut().take(count).enumerate() {
        let t = start + i as f64 * step;
        while right + 1 < time.len() && time[right] < t {
            right += 1;
        }
        let (a, b) = (time[right - 1], time[right]);
        let u = if b > a { ((t - a) / (b - a)).clamp(0.0, 1.0) } else { 0.0 };
        *v = signal[right - 1] + u * (signal[right] - signal[right - 1]) - mean;
    }
    let size = buffer.len();
    let (forward, back) =
        PLANNER.with_borrow_mut(|planner| (planner.plan_fft_forward(size), planner.plan_fft_inverse(size)));
    let mut spectrum = forward.make_output_vec();
    if forward.process(&mut buffer, &mut spectrum).is_err() {
        return signal.to_vec();
    }
    let bin = 1.0 / (size as f64 * step);
    let edge = 0.1 * (band_hz[1] - band_hz[0]);
    for (i, c) in spectrum.iter_mut().enumerate() {
        let f = i as f64 * bin;
        let inside = ((f - band_hz[0]) / edge).min((band_hz[1] - f) / edge).clamp(0.0, 1.0);
        *c *= (0.5 * PI * inside).sin().powi(2) / size as f64;
    }
    spectrum[0].im = 0.0;
    if let Some(last) = spectrum.last_mut() {
        last.im = 0.0;
    }
    if back.process(&mut spectrum, &mut buffer).is_err() {
        return signal.to_vec();
    }
    time.iter()
        .map(|t| {
            let x = (t - start) / step;
            let i = (x.floor() as usize).min(count.saturating_sub(2));
            let u = x - i as f64;
            buffer[i] + u * (buffer[i + 1] - buffer[i])
        })
        .collect()
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::f64::consts::TAU;

    #[test]
    fn finds_a_slow_line_in_a_long_record_and_a_fast_one() {
        for f in [0.02, 3.0, 400.0] {
            let t: Vec<f64> = (0..200_000).map(|i| i as f64 * 1e-3).collect();
            let y: Vec<f64> = t.iter().map(|t| (TAU * f * t).sin() + 5.0).collect();
            let line = dominant(&t, &y, None).expect("a line");
            assert!((line.frequency_hz / f - 1.0).abs() < 0.02, "{line:?} for {f}");
        }
    }

    #[test]
    fn finds_what_swings_at_the_very_beginning_only() {
        for seconds in [8.0, 3.0] {
            let t: Vec<f64> = (0..3000).map(|i| i as f64 * 0.02).collect();
            let swing = |t: f64| 0.3 * (1.0 - t / seconds).max(0.0) * (TAU * 1.9 * t).cos();
            let y: Vec<f64> = t.iter().map(|&t| swing(t) + if t > seconds { 0.02 } else { 0.0 }).collect();
            let line = dominant(&t, &y, None).expect("a line");
            assert!((line.frequency_hz / 1.9 - 1.0).abs() < 0.1, "{line:?}");
        }
    }

    /// Three and a half swings of 1.7 Hz that friction ends, at 20 dB: parts of a swing hold no line of their own.
    #[test]
    fn few_swings_are_not_read_as_fast_ones() {
        for seed in 0..40u64 {
            let mut state = seed;
            let mut noise = || {
                state = state.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1_442_695_040_888_963_407);
                (state >> 11) as f64 / (1u64 << 53) as f64 - 0.5
            };
            let time: Vec<f64> = (0..5000).map(|i| f64::from(i) / 340.0).collect();
            let swing = |t: f64| (1.0 - t / 2.06).max(0.0) * (TAU * 1.7 * t).cos();
            let signal: Vec<f64> = time.iter().map(|&t| swing(t) + 0.35 * noise()).collect();
            let line = dominant(&time, &signal, None).expect("swings");
            assert!((1.0 / SAME..=SAME).contains(&(line.frequency_hz / 1.7)), "{seed}: {line:?}");
        }
    }

    #[test]
    fn the_density_of_coloured_noise_is_that_of_its_process() {
        // AR(1): (1 - a²)/(1 + a² - 2 a cos(omega)).
        let a = 0.9;
        let (mut white, mut coloured) = (Vec::new(), Vec::new());
        let mut last = 0.0;
        for i in 0..20_000 {
            let w = crate::noise::jitter(i, 11);
            last = a * last + w;
            white.push(w);
            coloured.push(last);
        }
        let time: Vec<f64> = (0..20_000).map(f64::from).collect();
        let flat = density_near(&time, &white, 1.0 / 30.0).unwrap();
        assert!((flat.ratio - 1.0).abs() < 4.0 * (2.0 / flat.degrees).sqrt(), "{flat:?}");
        let found = density_near(&time, &coloured, 1.0 / 30.0).unwrap();
        let expected = (1.0 - a * a) / (1.0 + a * a - 2.0 * a * (2.0 * PI / 30.0).cos());
        assert!((found.ratio / expected - 1.0).abs() < 0.25, "{found:?} for {expected}");
        // An uneven clock is interpolated, which colours any noise.
        let uneven: Vec<f64> =
            time.iter().map(|t| t + 0.4 * (t * t).sin() + if *t > 1e4 { *t } else { 0.0 }).collect();
        assert_eq!(density_near(&uneven, &white, 1.0 / 30.0), None);
    }

    #[test]
    fn a_band_picks_the_weaker_line() {
        let t: Vec<f64> = (0..4000).map(|i| i as f64 * 1e-2).collect();
        let y: Vec<f64> = t.iter().map(|t| (TAU * t).sin() + 0.3 * (TAU * 3.3 * t).sin()).collect();
        let line = dominant(&t, &y, Some([2.0, 5.0])).expect("a line");
        assert!((line.frequency_hz - 3.3).abs() < 0.05);
        let others = other_lines(&Periodogram::of(&t, &y).expect("long enough"), 1.0, 0.05, 0.01);
        assert!((others[0].frequency_hz - 3.3).abs() < 0.05, "{others:?}");
        assert!((others[0].amplitude - 0.3).abs() < 0.03, "{others:?}");
    }
}
