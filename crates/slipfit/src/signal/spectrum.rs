//! Periodogram: the oscillations in a stretch of a record, and a band-pass filter.

use super::criteria::SpectrumCriteria;
use super::fourier;
use super::transform::{Grid, LONGEST, amplitudes, loudest, loudest_grid, median_step};
use crate::inference::least_squares::linear;
use crate::numeric::order::sort_by_value;
use nalgebra::Complex;
use std::borrow::Cow;
use std::f64::consts::{PI, TAU};
use std::ops::Range;

/// One line of a spectrum.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct Line {
    pub(crate) frequency_hz: f64,
    pub(crate) amplitude: f64,
}

/// Boxcar means of `width` samples.
pub(crate) fn averaged(time: &[f64], signal: &[f64], width: usize) -> (Vec<f64>, Vec<f64>) {
    let mean = |v: &[f64]| v.iter().sum::<f64>() / v.len() as f64;
    (time.chunks_exact(width).map(mean).collect(), signal.chunks_exact(width).map(mean).collect())
}

/// Position of a peak by a parabola through the logarithms of three bins.
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

/// Amplitude spectrum of a record, or of its loudest part if it is long.
#[derive(Debug)]
pub(crate) struct Periodogram {
    spectrum: Vec<f64>,
    /// Width of a bin, Hz.
    bin: f64,
    /// Length of the stretch, in s and in samples.
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

    /// Amplitude exceeded with this probability by the highest of `lines` independent lines of white noise.
    ///
    /// Under the Hann window the square of a line's amplitude is exponentially distributed with mean `6 sigma²/n`.
    fn line_of_noise(&self, noise_rms: f64, lines: f64, probability: f64) -> f64 {
        let height = (lines.max(1.0) / probability).ln();
        noise_rms * (6.0 * height / self.samples.max(1) as f64).sqrt()
    }

    fn strongest(&self, band_hz: Option<[f64; 2]>, criteria: &SpectrumCriteria) -> Option<Line> {
        let lowest = band_hz.map_or(0.0, |b| b[0]).max(criteria.least_cycles / self.duration);
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

/// Index of the largest value; the last one if several are equal.
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

/// The strongest oscillation of the record, inside `band_hz` if given.
///
/// Long records are searched in the stretch of highest variance; if fewer than eight cycles fit into it, the record
/// is averaged eightfold, which lengthens the stretch.
pub(crate) fn dominant(
    time: &[f64],
    signal: &[f64],
    band_hz: Option<[f64; 2]>,
    criteria: &SpectrumCriteria,
) -> Option<Line> {
    dominant_of(&Periodogram::of(time, signal)?, time, signal, band_hz, criteria)
}

/// As [`dominant`], from an existing periodogram.
pub(crate) fn dominant_of(
    periodogram: &Periodogram,
    time: &[f64],
    signal: &[f64],
    band_hz: Option<[f64; 2]>,
    criteria: &SpectrumCriteria,
) -> Option<Line> {
    let mut width = 1;
    let mut wider: Option<Periodogram> = None;
    loop {
        let here = wider.as_ref().unwrap_or(periodogram);
        let line = here.strongest(band_hz, criteria)?;
        let whole = here.samples >= signal.len() / width;
        let many_cycles = line.frequency_hz * here.duration >= criteria.many_cycles;
        if many_cycles && !(whole && width == 1 && is_weak(&line, signal, criteria)) {
            return Some(line);
        }
        if whole {
            let apart = |found: &Line| {
                let ratio = found.frequency_hz / line.frequency_hz;
                !many_cycles || !(1.0 / criteria.same_frequency..=criteria.same_frequency).contains(&ratio)
            };
            return Some(brief(time, signal, band_hz, &line, criteria).filter(apart).unwrap_or(line));
        }
        width *= 8;
        let (t, y) = averaged(time, signal, width);
        wider = Some(Periodogram::of(&t, &y)?);
    }
}

/// Whether the amplitude of a line is a small part of the largest deflection, so that the strongest line of the whole
/// record may be noise.
fn is_weak(line: &Line, signal: &[f64], criteria: &SpectrumCriteria) -> bool {
    let mean = signal.iter().sum::<f64>() / signal.len() as f64;
    let largest = signal.iter().map(|x| (x - mean).abs()).fold(0.0, f64::max);
    line.amplitude < criteria.weak_line * largest
}

/// An oscillation that ends long before the record: the window has suppressed the swings at its beginning and shows
/// the rest. A part of the record with clearly larger swings is preferred, unless the line found in the whole record
/// also describes that part, because a few swings leak into every frequency.
fn brief(
    time: &[f64],
    signal: &[f64],
    band_hz: Option<[f64; 2]>,
    line: &Line,
    criteria: &SpectrumCriteria,
) -> Option<Line> {
    let long_enough = |parts: &usize| signal.len() / parts >= 16;
    [4, 16, 64].into_iter().filter(long_enough).find_map(|parts| {
        let (from, to) = loudest(signal, signal.len() / parts);
        let part = Periodogram::of(&time[from..to], &signal[from..to])?;
        let found = part.strongest(band_hz, criteria)?;
        let cycles = found.frequency_hz * part.duration;
        let left =
            |line: &Line| residual_sum_of_squares(&time[from..to], &signal[from..to], line.frequency_hz);
        let wider =
            cycles >= criteria.brief_cycles && found.amplitude > criteria.brief_wider * line.amplitude;
        (wider && left(&found) < criteria.brief_left * left(line)).then_some(found)
    })
}

/// Residual sum of squares of a signal after a sine about a straight line.
fn residual_sum_of_squares(time: &[f64], signal: &[f64], frequency_hz: f64) -> f64 {
    let rows = time.iter().zip(signal).map(|(&t, &x)| {
        let (v, (sin, cos)) = (t - time[0], (TAU * frequency_hz * (t - time[0])).sin_cos());
        (vec![1.0, v, cos, sin], x, 1.0)
    });
    linear(rows, 4).map_or(f64::INFINITY, |(_, _, rss)| rss)
}

/// The strongest line where a uniformly sampled signal is loudest; a NaN counts as the value before it.
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
    Periodogram { spectrum, bin, duration, samples }.strongest(None, &SpectrumCriteria::default())
}

/// White noise under the lines of a spectrum.
#[derive(Debug, Clone, Copy)]
pub(crate) struct NoiseFloor {
    /// Noise of one sample.
    pub(crate) rms: f64,
    /// Probability of an equally strong line in noise, below which a line is attributed to the motion.
    pub(crate) probability: f64,
}

/// The longest stretch of some stamps between gaps of half a cycle or more, across which interpolation cannot follow
/// the motion and would create spurious lines. All stamps, if the stretch has less than half of them.
pub(crate) fn between_gaps(time: &[f64], frequency_hz: f64, criteria: &SpectrumCriteria) -> Range<usize> {
    let longest_step = (0.5 / frequency_hz).max(criteria.gap_steps * median_step(time));
    let gaps = time.windows(2).fold(false, |any, pair| any | (pair[1] - pair[0] > longest_step));
    if !gaps {
        return 0..time.len();
    }
    let stretches = time.chunk_by(|a, b| !(b - a > longest_step));
    let mut end = 0;
    let ranges = stretches.map(|stretch| {
        end += stretch.len();
        end - stretch.len()..end
    });
    let longest = ranges.max_by_key(|range| range.len());
    longest.filter(|range| 2 * range.len() >= time.len()).unwrap_or(0..time.len())
}

/// Lines of at least this amplitude that noise does not explain, excluding the main line, its neighbourhood and its
/// harmonics; strongest first.
pub(crate) fn other_lines(
    periodogram: &Periodogram,
    main_hz: f64,
    relative_width: f64,
    least: f64,
    noise: NoiseFloor,
) -> Vec<Line> {
    let Periodogram { spectrum, bin, duration, samples } = periodogram;
    if *samples < 32 {
        return Vec::new();
    }
    let of_noise = periodogram.line_of_noise(noise.rms, 0.5 * *samples as f64, noise.probability);
    let least = least.max(of_noise);
    let near = (relative_width * main_hz).max(4.0 / duration);
    let mut lines: Vec<Line> = (2..spectrum.len().saturating_sub(2))
        // The parabola raises a peak of the Hann window by far less than a factor of four.
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

/// The strongest harmonic up to the fifth that noise does not explain: order and amplitude.
pub(crate) fn strongest_harmonic(
    periodogram: &Periodogram,
    main_hz: f64,
    noise: NoiseFloor,
    criteria: &SpectrumCriteria,
) -> Option<(usize, f64)> {
    let Periodogram { spectrum, bin, duration, .. } = periodogram;
    // With fewer cycles, the width of the main line extends to the second harmonic.
    if main_hz * duration < criteria.many_cycles {
        return None;
    }
    let mut looked_at = 0;
    let found = (2..=5).filter_map(|order| {
        let middle = order as f64 * main_hz / bin;
        let reach = (0.02 * middle).max(2.0);
        let (from, to) = ((middle - reach) as usize, (middle + reach).ceil() as usize);
        let about = spectrum.get(from..=to)?;
        looked_at += about.len();
        Some((order, about.iter().fold(0.0f64, |m, &a| m.max(a))))
    });
    let (order, amplitude) = found.max_by(|a, b| a.1.total_cmp(&b.1))?;
    let lines = looked_at as f64 * bin * duration;
    let of_noise = periodogram.line_of_noise(noise.rms, lines, noise.probability);
    (amplitude > of_noise).then_some((order, amplitude))
}

/// The part of the signal between two frequencies, evaluated at the given stamps: unchanged inside the band, and
/// tapered outside over a tenth of the band, or over the lower frequency if that is less. The signal is extended by
/// its mirror image at either end, because an abrupt end would leak into the band.
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
    let mirrored = (count - 1).min((size - count) / 2);
    for k in 1..=mirrored {
        let fading = (0.5 * PI * k as f64 / (mirrored + 1) as f64).cos().powi(2);
        buffer[count - 1 + k] = fading * buffer[count - 1 - k];
        buffer[size - k] = fading * buffer[k];
    }
    let (mut spectrum, mut scratch) = (vec![Complex::default(); size / 2 + 1], Vec::new());
    if !fourier::forward(&mut buffer, &mut spectrum, &mut scratch) {
        return signal.to_vec();
    }
    let bin = 1.0 / (size as f64 * step);
    let [low, high] = band_hz;
    let above = 0.1 * (high - low);
    let below = above.min(0.1 * low);
    for (i, c) in spectrum.iter_mut().enumerate() {
        let f = i as f64 * bin;
        let outside = ((low - f) / below).max((f - high) / above).clamp(0.0, 1.0);
        *c *= (0.5 * PI * outside).cos().powi(2) / size as f64;
    }
    spectrum[0].im = 0.0;
    if let Some(last) = spectrum.last_mut() {
        last.im = 0.0;
    }
    if !fourier::inverse(&mut spectrum, &mut buffer, &mut scratch) {
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
    use crate::noise::jitter;
    use std::f64::consts::TAU;

    #[test]
    fn a_wide_band_keeps_the_amplitude_of_what_lies_near_its_ends() {
        let time: Vec<f64> = (0..4000).map(|i| 0.02 * f64::from(i)).collect();
        let signal: Vec<f64> = time.iter().map(|t| 5.0 + (TAU * 1.2 * t).sin()).collect();
        for band in [[0.1, 20.0], [1.1, 20.0], [0.0, 1.3], [0.3, 2.0]] {
            let kept = band_pass(&time, &signal, band);
            let middle = &kept[1500..2500];
            let mean_square = middle.iter().map(|x| x * x).sum::<f64>() / middle.len() as f64;
            assert!((2.0 * mean_square - 1.0).abs() < 0.02, "{band:?}: {mean_square}");
        }
        let kept = band_pass(&time, &signal, [2.0, 20.0]);
        assert!(kept[1500..2500].iter().all(|x| x.abs() < 0.02));
    }

    #[test]
    fn finds_a_slow_line_in_a_long_record_and_a_fast_one() {
        for f in [0.02, 3.0, 400.0] {
            let t: Vec<f64> = (0..200_000).map(|i| i as f64 * 1e-3).collect();
            let y: Vec<f64> = t.iter().map(|t| (TAU * f * t).sin() + 5.0).collect();
            let line = dominant(&t, &y, None, &SpectrumCriteria::default()).expect("a line");
            assert!((line.frequency_hz / f - 1.0).abs() < 0.02, "{line:?} for {f}");
        }
    }

    #[test]
    fn finds_what_swings_at_the_very_beginning_only() {
        for seconds in [8.0, 3.0] {
            let t: Vec<f64> = (0..3000).map(|i| i as f64 * 0.02).collect();
            let swing = |t: f64| 0.3 * (1.0 - t / seconds).max(0.0) * (TAU * 1.9 * t).cos();
            let y: Vec<f64> = t.iter().map(|&t| swing(t) + if t > seconds { 0.02 } else { 0.0 }).collect();
            let line = dominant(&t, &y, None, &SpectrumCriteria::default()).expect("a line");
            assert!((line.frequency_hz / 1.9 - 1.0).abs() < 0.1, "{line:?}");
        }
    }

    /// Three and a half swings of 1.7 Hz ended by friction, at 20 dB: parts of a swing have no line of their own.
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
            let line = dominant(&time, &signal, None, &SpectrumCriteria::default()).expect("swings");
            assert!((1.0 / 1.5..=1.5).contains(&(line.frequency_hz / 1.7)), "{seed}: {line:?}");
        }
    }

    const NO_NOISE: NoiseFloor = NoiseFloor { rms: 0.0, probability: 0.01 };

    /// For a decay in white noise of a tenth of its amplitude, one record in a hundred shows another line, and as
    /// many a harmonic.
    #[test]
    fn noise_is_no_other_mode_and_no_harmonic() {
        const RECORDS: usize = 400;
        let rms = 0.1;
        let time: Vec<f64> = (0..860).map(|i| f64::from(i) / 51.0).collect();
        let shows = |record: usize| {
            let noisy = |(i, t): (usize, &f64)| {
                (-0.18 * t).exp() * (TAU * 1.7 * t).cos() + rms * jitter(record * time.len() + i, 4)
            };
            let signal: Vec<f64> = time.iter().enumerate().map(noisy).collect();
            let periodogram = Periodogram::of(&time, &signal).expect("long enough");
            let noise = NoiseFloor { rms, probability: 0.01 };
            let lines = other_lines(&periodogram, 1.7, 0.05, 0.0, noise);
            [
                !lines.is_empty(),
                strongest_harmonic(&periodogram, 1.7, noise, &SpectrumCriteria::default()).is_some(),
            ]
        };
        let found: Vec<[bool; 2]> = (0..RECORDS).map(shows).collect();
        for k in 0..2 {
            let count = found.iter().filter(|found| found[k]).count();
            assert!(count <= 12, "{count} of {RECORDS}");
        }
        // A harmonic of a fifth of the motion is not noise.
        let signal: Vec<f64> = time
            .iter()
            .enumerate()
            .map(|(i, t)| {
                let phase = TAU * 1.7 * t;
                (-0.18 * t).exp() * (phase.cos() + 0.2 * (3.0 * phase).cos()) + rms * jitter(i, 4)
            })
            .collect();
        let periodogram = Periodogram::of(&time, &signal).expect("long enough");
        let harmonic = strongest_harmonic(
            &periodogram,
            1.7,
            NoiseFloor { rms, probability: 0.01 },
            &SpectrumCriteria::default(),
        );
        assert_eq!(harmonic.map(|(order, _)| order), Some(3));
    }

    #[test]
    fn a_gap_parts_a_clock_and_missing_samples_do_not() {
        let even: Vec<f64> = (0..1000).map(|i| 0.01 * f64::from(i)).collect();
        let criteria = SpectrumCriteria::default();
        assert_eq!(between_gaps(&even, 2.0, &criteria), 0..1000);
        // Every third sample is missing, and 0.2 s of a motion of 2 Hz.
        let thinned: Vec<f64> =
            even.iter().enumerate().filter(|(i, _)| i % 3 != 0).map(|(_, t)| *t).collect();
        assert_eq!(between_gaps(&thinned, 2.0, &criteria), 0..666);
        let short: Vec<f64> = even.iter().copied().filter(|t| !(3.0..3.2).contains(t)).collect();
        assert_eq!(between_gaps(&short, 2.0, &criteria), 0..980);
        let gap: Vec<f64> = even.iter().copied().filter(|t| !(3.0..3.5).contains(t)).collect();
        assert_eq!(between_gaps(&gap, 2.0, &criteria), 300..950);
        // No stretch has half of the samples.
        let parts: Vec<f64> = even.iter().copied().filter(|t| t % 2.0 < 1.4).collect();
        assert_eq!(between_gaps(&parts, 2.0, &criteria), 0..parts.len());
    }

    #[test]
    fn a_band_picks_the_weaker_line() {
        let t: Vec<f64> = (0..4000).map(|i| i as f64 * 1e-2).collect();
        let y: Vec<f64> = t.iter().map(|t| (TAU * t).sin() + 0.3 * (TAU * 3.3 * t).sin()).collect();
        let line = dominant(&t, &y, Some([2.0, 5.0]), &SpectrumCriteria::default()).expect("a line");
        assert!((line.frequency_hz - 3.3).abs() < 0.05);
        let others = other_lines(&Periodogram::of(&t, &y).expect("long enough"), 1.0, 0.05, 0.01, NO_NOISE);
        assert!((others[0].frequency_hz - 3.3).abs() < 0.05, "{others:?}");
        assert!((others[0].amplitude - 0.3).abs() < 0.03, "{others:?}");
    }
}
