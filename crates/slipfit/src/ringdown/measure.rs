//! From a record to amplitudes along its free decay.

use super::options::Options;
use super::segment::{self, Seen, Stretch};
use crate::numeric::robust::neighbour_noise;
use crate::signal::blocks::{self, Block, Cut, PhaseAt};
use crate::signal::phase::{self, PhaseLaw};
use crate::signal::spectrum;
use crate::{Error, Record, SignalKind};
use std::borrow::Cow;
use std::f64::consts::TAU;
use std::ops::Range;

/// Stamps and samples of the stretch under analysis.
#[derive(Debug, Clone)]
pub(crate) struct Samples<'a> {
    pub(crate) time: Cow<'a, [f64]>,
    pub(crate) signal: Cow<'a, [f64]>,
    pub(crate) quadrature: Option<Cow<'a, [f64]>>,
}

impl<'a> Samples<'a> {
    /// The part of the record between `start_s` and `end_s`.
    pub(crate) fn of(record: &'a Record, options: &Options) -> Result<Self, Error> {
        let n = record.len();
        let below = |limit: f64| {
            let (mut a, mut b) = (0, n);
            while a < b {
                let middle = usize::midpoint(a, b);
                if record.time_s(middle) < limit { a = middle + 1 } else { b = middle }
            }
            a
        };
        let first = options.start_s.map_or(0, below);
        let end = options.end_s.map_or(n, |e| below(e).max(first));
        let (from_s, to_s) = (record.time_s(0), record.time_s(n - 1));
        for (name, asked) in [("start_s", options.start_s), ("end_s", options.end_s)] {
            let beyond = |t: &f64| if name == "start_s" { *t >= to_s } else { *t <= from_s };
            if let Some(value_s) = asked.filter(beyond) {
                return Err(Error::OutsideRecord { name, value_s, from_s, to_s });
            }
        }
        if end - first < crate::record::MIN_SAMPLES {
            return Err(Error::TooFewSamples { found: end - first, needed: crate::record::MIN_SAMPLES });
        }
        let time = match record.clock() {
            crate::Clock::Stamps(stamps) => Cow::Borrowed(&stamps[first..end]),
            crate::Clock::Uniform { .. } => Cow::Owned(record.times_s(first..end)),
        };
        Ok(Self {
            time,
            signal: Cow::Borrowed(&record.signal()[first..end]),
            quadrature: record.quadrature().map(|q| Cow::Borrowed(&q[first..end])),
        })
    }

    /// Some of the samples.
    pub(crate) fn part(&self, range: Range<usize>) -> Self {
        let cut = |column: &Cow<'a, [f64]>| match column {
            Cow::Borrowed(all) => Cow::Borrowed(&all[range.clone()]),
            Cow::Owned(all) => Cow::Owned(all[range.clone()].to_vec()),
        };
        Self {
            time: cut(&self.time),
            signal: cut(&self.signal),
            quadrature: self.quadrature.as_ref().map(cut),
        }
    }

    pub(crate) fn duration(&self) -> f64 {
        self.time[self.time.len() - 1] - self.time[0]
    }
}

/// Amplitudes along the record and its free decay.
#[derive(Debug, Clone)]
pub(crate) struct Measured {
    /// Whole record, as first followed.
    pub(crate) all: Vec<Block>,
    pub(crate) stretch: Stretch,
    /// The free decay, along a smooth phase.
    pub(crate) points: Vec<Block>,
    pub(crate) law: PhaseLaw,
    /// The phase follows the law; else it was smoothed locally.
    pub(crate) lawful: bool,
    pub(crate) noise_rms: f64,
    /// `value = A² + floor` holds for the points (bare envelopes).
    pub(crate) squared: bool,
}

impl Measured {
    /// The decay with as much before and after it, where the record is so much longer that its
    /// stretches are twice as long as they need be.
    pub(crate) fn closer(&self, samples: &Samples, frequency_hz: f64) -> Option<Range<usize>> {
        let decay = &self.all[self.stretch.first..self.stretch.end];
        let (first, last) = (decay.first()?.first, decay.last()?.end.min(samples.time.len()) - 1);
        let (from_s, to_s) = (samples.time[first], samples.time[last]);
        let length_s = to_s - from_s;
        let from = samples.time.partition_point(|t| *t < from_s - length_s);
        let end = samples.time.partition_point(|t| *t <= to_s + length_s);
        let cycles = |samples: usize, span_s: f64| Cut::for_record(span_s, samples, frequency_hz).cycles;
        let whole = cycles(samples.time.len(), samples.duration());
        let part = cycles(end - from, samples.time[end - 1] - samples.time[from]);
        (2.0 * part <= whole).then_some(from..end)
    }
}

/// Amplitudes of an oscillating record.
pub(crate) fn oscillation(
    samples: &Samples,
    options: &Options,
    frequency_hz: f64,
) -> Result<Measured, Error> {
    let (time, signal) = (&samples.time, &samples.signal);
    let cut = Cut::for_record(samples.duration(), time.len(), frequency_hz);
    let band = options.band_hz.unwrap_or([0.4 * frequency_hz, 2.5 * frequency_hz]);
    let followed = |cut: Cut| -> Result<(Vec<Block>, Stretch, f64, usize), Error> {
        let all = blocks::track(time, signal, frequency_hz, band, cut);
        if all.len() < 3 {
            return Err(Error::NotARingDown {
                cycles: samples.duration() * frequency_hz,
                needed: LEAST_CYCLES,
                reason: "too few samples or cycles to follow an oscillation",
            });
        }
        let seen = seen(&all, signal, frequency_hz);
        let mut stretch = free_of_clipping(&all, signal, frequency_hz)
            .filter(|_| options.start_s.is_none())
            .or_else(|| segment::find(&seen))
            .ok_or_else(|| if grows(&all) { NOTHING_BUT_GROWTH } else { NOTHING_FALLS })?;
        override_by(&mut stretch, &seen, options);
        let relative = seen.error[stretch.first] / seen.amplitude[stretch.first].max(f64::MIN_POSITIVE);
        let visible = (0..all.len()).filter(|&i| seen.amplitude[i] > seen.floor[i]).count();
        Ok((all, stretch, relative, visible))
    };
    let (mut all, mut stretch, relative, visible) = followed(cut)?;
    // Where single blocks are uncertain, longer ones find start, end and phase more surely.
    let longest = visible as f64 / 30.0;
    let longer = (relative / 0.015).powi(2).min(longest).floor();
    if longer >= 2.0
        && let Ok((blocks, found, ..)) = followed(Cut { cycles: cut.cycles * longer, ..cut })
    {
        (all, stretch) = (blocks, found);
    }
    let noise_rms = blocks::noise_rms(&all);
    let part = &all[stretch.first..stretch.end];
    let (points, law, lawful) = along(samples, part, noise_rms)?;
    let noise_rms = blocks::noise_rms(&points);
    Ok(Measured { stretch, points, law, lawful, noise_rms, squared: false, all })
}

const NOTHING_BUT_GROWTH: Error = Error::NotARingDown {
    cycles: 0.0,
    needed: LEAST_CYCLES,
    reason: "the amplitude grows along the record; a decay must fall",
};

/// Whether the last third of the record swings clearly wider than the first.
fn grows(all: &[Block]) -> bool {
    let third = (all.len() / 3).max(1);
    let mean = |part: &[Block]| part.iter().map(|b| b.amplitude).sum::<f64>() / part.len() as f64;
    mean(&all[all.len() - third..]) > 1.2 * mean(&all[..third])
}

/// The same free decay, begun with the record.
pub(crate) fn from_the_first_block(samples: &Samples, found: &Measured) -> Option<Measured> {
    let last = found.points.last()?;
    let end = found.all.iter().position(|b| b.end >= last.end)? + 1;
    let stretch = Stretch { first: 0, end, start_reason: segment::RECORD_START, ..found.stretch };
    let (points, law, lawful) = along(samples, &found.all[..end], found.noise_rms).ok()?;
    Some(Measured { all: found.all.clone(), stretch, points, law, lawful, ..*found })
}

const NOTHING_FALLS: Error = Error::NotARingDown {
    cycles: 0.0,
    needed: LEAST_CYCLES,
    reason: "the amplitude nowhere falls out of the noise",
};

/// The free decay after the clipped blocks, if there are any and enough remains.
fn free_of_clipping(all: &[Block], signal: &[f64], frequency_hz: f64) -> Option<Stretch> {
    let mut gone = super::clipping::flattened(all, signal, quantum(signal));
    if gone == 0 {
        return None;
    }
    // A stray crest at the very ceiling soon after belongs to it.
    let (_, last) = super::clipping::clipped(signal);
    let beyond = all.partition_point(|b| b.first < last);
    if beyond <= gone + gone.div_ceil(5) {
        gone = gone.max(beyond);
    }
    if all.len() < gone + 8 {
        return None;
    }
    let found = segment::find(&seen(&all[gone..], signal, frequency_hz))?;
    let start_reason = if found.first == 0 { segment::CLIPPED } else { found.start_reason };
    Some(Stretch { first: found.first + gone, end: found.end + gone, start_reason, ..found })
}

/// What the blocks show, and below which amplitude they show nothing.
fn seen<'a>(all: &'a [Block], signal: &[f64], frequency_hz: f64) -> Seen<'a> {
    let noise_rms = blocks::noise_rms(all);
    let quantum = quantum(signal);
    let amplitude: Vec<f64> = all.iter().map(|b| b.amplitude).collect();
    let top = amplitude.iter().fold(0.0f64, |m, &a| m.max(a));
    let error: Vec<f64> = all.iter().map(|b| b.std_error(noise_rms)).collect();
    let floor = error.iter().map(|e| (4.0 * e).max(1.5 * quantum).max(1e-5 * top)).collect();
    Seen { blocks: all, amplitude, error, floor, omega: TAU * frequency_hz }
}

/// Cycles without which there is nothing to say.
pub(crate) const LEAST_CYCLES: f64 = 2.0;

fn override_by(stretch: &mut Stretch, seen: &Seen, options: &Options) {
    if options.start_s.is_some() {
        stretch.first = 0;
        stretch.start_reason = segment::ASKED;
    }
    if options.end_s.is_some() {
        stretch.end = seen.blocks.len();
        stretch.end_reason = segment::ASKED;
        stretch.slow_tail = false;
        stretch.disturbed = false;
    }
    if let Some(least) = options.min_amplitude {
        let end = (stretch.first..stretch.end).find(|&i| seen.amplitude[i] < least).unwrap_or(stretch.end);
        if end < stretch.end {
            stretch.end = end;
            stretch.end_reason = segment::LEAST;
            stretch.slow_tail = false;
            stretch.disturbed = false;
        }
    }
}

/// Amplitudes of the blocks along one smooth phase.
fn along(samples: &Samples, part: &[Block], noise_rms: f64) -> Result<(Vec<Block>, PhaseLaw, bool), Error> {
    let rough: Vec<f64> = part.iter().map(|b| b.amplitude).collect();
    let smooth = phase::smooth(part, &rough, noise_rms)
        .ok_or(Error::NoFit { reason: "the phase of the oscillation cannot be followed" })?;
    let mut at: Vec<PhaseAt> = smooth.at;
    let mut loss = 0.0;
    for (j, p) in at.iter_mut().enumerate() {
        let (a, b) = (j.saturating_sub(2), (j + 2).min(part.len() - 1));
        let span = part[b].time_s - part[a].time_s;
        let slope = (rough[a].max(f64::MIN_POSITIVE) / rough[b].max(f64::MIN_POSITIVE)).ln() / span;
        let most = 1.0 / part[j].span_s;
        // In the noise the slope of the modulus is the noise's; the last one known goes on.
        let seen = [a, b].iter().all(|&i| part[i].amplitude > 10.0 * part[i].std_error(noise_rms));
        if seen && slope.is_finite() {
            loss = slope.clamp(-most, most);
        }
        p.loss = loss.clamp(-most, most);
        if !p.omega.is_finite() {
            p.omega = part[j].omega;
        }
    }
    let points = blocks::demodulate(&samples.time, &samples.signal, part, &at);
    Ok((points, smooth.law, smooth.lawful))
}

/// Amplitudes of a bare envelope: means of R² over short stretches, so that the
/// noise adds a constant (`E[R²] = A² + 2 sigma²`) whatever the amplitude.
pub(crate) fn envelope(samples: &Samples, options: &Options) -> Result<Measured, Error> {
    let (time, signal) = (&samples.time, &samples.signal);
    let n = signal.len();
    let width = n.div_ceil(500).max(1);
    // Scatter of neighbours about their mean: free of the slow decay.
    let noise_rms = neighbour_noise(signal.windows(3)).unwrap_or(0.0);
    let all: Vec<Block> = (0..n)
        .step_by(width)
        .filter(|&i| i + width <= n)
        .map(|first| {
            let end = first + width;
            let count = width as f64;
            let square = signal[first..end].iter().map(|v| v * v).sum::<f64>() / count;
            Block {
                first,
                end,
                time_s: time[first..end].iter().sum::<f64>() / count,
                span_s: time[end - 1] - time[first],
                amplitude: square.sqrt(),
                quadrature: 0.0,
                phase: 0.0,
                omega: f64::NAN,
                offset: 0.0,
                unit_variance: 1.0 / count,
                rss: 0.0,
                dof: count,
            }
        })
        .collect();
    let amplitude: Vec<f64> = all.iter().map(|b| b.amplitude).collect();
    let error: Vec<f64> = all.iter().map(|b| b.std_error(noise_rms)).collect();
    let mut sorted = amplitude.clone();
    sorted.sort_by(f64::total_cmp);
    let low = sorted[sorted.len() / 50];
    let floor = error.iter().map(|e| low.min(0.2 * sorted[sorted.len() - 1]) + 2.0 * e).collect();
    let seen = Seen { blocks: &all, amplitude, error, floor, omega: envelope_omega(samples, options) };
    let mut stretch = segment::find(&seen).ok_or(NOTHING_FALLS)?;
    override_by(&mut stretch, &seen, options);
    let points = all[stretch.first..stretch.end].to_vec();
    let law = PhaseLaw {
        omega: envelope_omega(samples, options),
        mean_omega: envelope_omega(samples, options),
        ..PhaseLaw::default()
    };
    Ok(Measured { all, stretch, points, law, lawful: true, noise_rms, squared: true })
}

/// Frequency behind an envelope; where unknown one so high that only the loss rate matters.
fn envelope_omega(samples: &Samples, options: &Options) -> f64 {
    options.frequency_hz.map_or(1e6 * samples.time.len() as f64 / samples.duration(), |f| TAU * f)
}

/// Amplitudes from a lock-in's two outputs, along the smooth phase of their beat.
pub(crate) fn lock_in(samples: &Samples, options: &Options) -> Result<Measured, Error> {
    let Some(quadrature) = samples.quadrature.as_deref() else {
        return Err(Error::MissingParameter {
            name: "quadrature",
            hint: "a lock-in record needs both outputs",
        });
    };
    let (time, x) = (&samples.time, &samples.signal);
    let n = x.len();
    let width = n.div_ceil(500).max(1);
    let mut all: Vec<Block> = Vec::new();
    let noise_rms = neighbour_noise(x.windows(3).chain(quadrature.windows(3))).unwrap_or(0.0);
    for first in (0..n).step_by(width).filter(|&i| i + width <= n) {
        let end = first + width;
        let count = width as f64;
        let (p, q) =
            (x[first..end].iter().sum::<f64>() / count, quadrature[first..end].iter().sum::<f64>() / count);
        let time_s = time[first..end].iter().sum::<f64>() / count;
        let mut phase = q.atan2(p);
        if let Some(last) = all.last() {
            let last: &Block = last;
            phase += TAU * ((last.phase - phase) / TAU).round();
        }
        all.push(Block {
            first,
            end,
            time_s,
            span_s: time[end - 1] - time[first],
            amplitude: p.hypot(q),
            quadrature: 0.0,
            phase,
            omega: 0.0,
            offset: 0.0,
            unit_variance: 1.0 / count,
            rss: 0.0,
            dof: count,
        });
    }
    let amplitude: Vec<f64> = all.iter().map(|b| b.amplitude).collect();
    let error: Vec<f64> = all.iter().map(|b| b.std_error(noise_rms)).collect();
    let floor = error.iter().map(|e| 4.0 * e).collect();
    let omega = envelope_omega(samples, options);
    let seen = Seen { blocks: &all, amplitude, error, floor, omega };
    let mut stretch = segment::find(&seen).ok_or(NOTHING_FALLS)?;
    override_by(&mut stretch, &seen, options);
    let mut points = all[stretch.first..stretch.end].to_vec();
    let rough: Vec<f64> = points.iter().map(|b| b.amplitude).collect();
    // The beat phase is small and slow: project on its local mean.
    if let Some(smooth) = phase::smooth_locally(&points, &rough, noise_rms) {
        for (point, phase) in points.iter_mut().zip(smooth) {
            let turn = point.phase - phase;
            point.quadrature = point.amplitude * turn.sin();
            point.amplitude *= turn.cos();
        }
    }
    let law = PhaseLaw { omega, mean_omega: omega, ..PhaseLaw::default() };
    Ok(Measured { all, stretch, points, law, lawful: true, noise_rms, squared: false })
}

/// Smallest step between different values: the converter's, where it shows.
pub(crate) fn quantum(signal: &[f64]) -> f64 {
    let stride = (signal.len() / 2000).max(1);
    let mut values: Vec<f64> = signal.iter().step_by(stride).copied().collect();
    values.sort_by(f64::total_cmp);
    let range = values[values.len() - 1] - values[0];
    let before = values.len();
    values.dedup();
    // Many repeats make a step visible; rounding noise below 1e-9 of the range is none.
    if values.len() * 3 > before * 2 || values.len() < 2 {
        return 0.0;
    }
    values
        .windows(2)
        .map(|w| w[1] - w[0])
        .filter(|d| *d > 1e-9 * range)
        .fold(f64::INFINITY, f64::min)
        .min(range)
}

/// Coarse frequency of the record.
pub(crate) fn frequency(samples: &Samples, options: &Options) -> Result<f64, Error> {
    spectrum::dominant(&samples.time, &samples.signal, options.band_hz)
        .map(|l| l.frequency_hz)
        .filter(|f| *f > 0.0 && f.is_finite())
        .ok_or(Error::NoOscillation { reason: "the spectrum has no line above the record's own length" })
}

/// The part of the signal inside a band, on the same stamps.
pub(crate) fn band_passed(samples: &Samples, band_hz: [f64; 2]) -> Vec<f64> {
    spectrum::band_pass(&samples.time, &samples.signal, band_hz)
}

/// Whether the samples swing as positions do, so that the exact waveform applies.
pub(crate) fn is_position(kind: SignalKind) -> bool {
    kind == SignalKind::Displacement
}
