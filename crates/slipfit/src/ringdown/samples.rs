//! The samples under analysis: the requested part of the record, in the requested band.

use super::criteria::Criteria;
use super::options::Options;
use super::sampled_signal::{SampledSignal, part_of};
use super::spikes::spikes_and_dropouts;
use super::unresolved::{may_be_unresolved, resolved};
use crate::error::BEYOND_NUMBERS;
use crate::motion::decay::window::Observable;
use crate::numeric::extremes;
use crate::record::MIN_SAMPLES;
use crate::signal::blocks::{self, Block};
use crate::signal::spectrum;
use crate::{Clock, Error, Record, SignalKind};
use std::borrow::Cow;
use std::ops::Range;

/// Range of scales in which fourth powers can be summed.
const REPRESENTABLE: std::ops::RangeInclusive<f64> = 1e-60..=1e60;
/// Differences below this fraction of the range are rounding errors, not steps of a converter.
const ROUNDING: f64 = 1e-9;
/// Number of samples examined for the steps of a converter.
const STEP_SAMPLES: usize = 2000;

/// Time stamps and samples under analysis.
#[derive(Debug, Clone)]
pub(crate) struct Samples<'a> {
    pub(crate) time: Cow<'a, [f64]>,
    pub(crate) signal: SampledSignal<'a>,
    pub(crate) observable: Observable,
    pub(crate) quadrature: Option<Cow<'a, [f64]>>,
    /// Ratio of the noise variance near the frequency of the motion to that inside single cycles, if an
    /// earlier analysis has found an excess; otherwise 1.
    pub(crate) noise_inflation: f64,
    /// Times of the spikes and dropouts left out, s.
    pub(crate) spikes_s: Vec<f64>,
    /// Whether the level of a rest is that at which friction holds the mass; false if a baseline was
    /// subtracted.
    pub(crate) level_known: bool,
    /// Which part of the samples was band-pass filtered.
    pub(crate) filtered: Filtered,
    /// A rest after these samples in which the steps of the converter hide the motion.
    pub(crate) rest: Option<UnresolvedRest<'a>>,
}

/// The part of the samples that was filtered to a frequency band.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) enum Filtered {
    Nothing,
    /// All of them: the filter has smeared the ends of the motion, its turning points and its stop.
    Motion,
    /// Everything except the motion. White noise with this root mean square has the density of the noise in
    /// the band.
    Noise {
        rms: f64,
    },
}

/// Time stamps and samples of a rest that is not analysed.
#[derive(Debug, Clone)]
pub(crate) struct UnresolvedRest<'a> {
    time: Cow<'a, [f64]>,
    signal: SampledSignal<'a>,
}

/// The observable that a record of this kind shows; amplitude records count as displacements.
fn observable(kind: SignalKind) -> Observable {
    match kind {
        SignalKind::Velocity => Observable::Velocity,
        SignalKind::Acceleration => Observable::Acceleration,
        _ => Observable::Displacement,
    }
}

impl<'a> Samples<'a> {
    /// The part of the record between `start_s` and `end_s` without its spikes and dropouts.
    pub(crate) fn prepare(record: &'a Record, options: &Options, criteria: &Criteria) -> Result<Self, Error> {
        let mut samples = Self::between(record, options.start_s, options.end_s)?;
        if record.kind().oscillates() {
            let repeats = || samples.converter_step(criteria.blocks.distinct_values) > 0.0;
            let left_out = spikes_and_dropouts(&samples.time, &samples.signal, repeats, &criteria.spikes);
            samples.leave_out(&left_out);
            if options.band_hz.is_none() && options.end_s.is_none() {
                samples.leave_unresolved(criteria);
            }
        }
        samples.check_scales()?;
        Ok(samples)
    }

    /// The same samples, filtered to a frequency band.
    pub(crate) fn within_band(&self, band_hz: [f64; 2]) -> Result<Samples<'_>, Error> {
        let signal = SampledSignal::new(spectrum::band_pass(&self.time, &self.signal, band_hz));
        let samples = Samples { signal, filtered: Filtered::Motion, ..self.borrowed() };
        samples.check_scales()?;
        Ok(samples)
    }

    fn between(record: &'a Record, start_s: Option<f64>, end_s: Option<f64>) -> Result<Self, Error> {
        let n = record.len();
        let (from_s, to_s) = (record.time_s(0), record.time_s(n - 1));
        let outside = |name, value_s| Error::OutsideRecord { name, value_s, from_s, to_s };
        if let Some(start_s) = start_s.filter(|start_s| *start_s >= to_s) {
            return Err(outside("start_s", start_s));
        }
        if let Some(end_s) = end_s.filter(|end_s| *end_s <= from_s) {
            return Err(outside("end_s", end_s));
        }
        let first = start_s.map_or(0, |start_s| first_at(record, start_s));
        let end = end_s.map_or(n, |end_s| first_at(record, end_s).max(first));
        if end - first < MIN_SAMPLES {
            return Err(Error::TooFewSamples { found: end - first, needed: MIN_SAMPLES });
        }
        let time = match record.clock() {
            Clock::Stamps(stamps) => Cow::Borrowed(&stamps[first..end]),
            Clock::Uniform { .. } => Cow::Owned(record.times_s(first..end)),
        };
        Ok(Self {
            time,
            signal: SampledSignal::new(&record.signal()[first..end]),
            observable: observable(record.kind()),
            quadrature: record.quadrature().map(|q| Cow::Borrowed(&q[first..end])),
            noise_inflation: 1.0,
            spikes_s: Vec::new(),
            level_known: true,
            filtered: Filtered::Nothing,
            rest: None,
        })
    }

    /// The same samples without copying the data.
    pub(crate) fn borrowed(&self) -> Samples<'_> {
        Samples {
            time: Cow::Borrowed(&self.time),
            signal: self.signal.borrowed(),
            quadrature: self.quadrature.as_deref().map(Cow::Borrowed),
            spikes_s: self.spikes_s.clone(),
            rest: self.rest.as_ref().map(|rest| UnresolvedRest {
                time: Cow::Borrowed(&rest.time),
                signal: rest.signal.borrowed(),
            }),
            ..*self
        }
    }

    /// A range of the samples.
    pub(crate) fn part(&self, range: Range<usize>) -> Self {
        let to_the_end = range.end == self.len();
        let cut = |column: &Cow<'a, [f64]>| part_of(column, range.clone());
        Self {
            time: cut(&self.time),
            signal: self.signal.part(range.clone()),
            observable: self.observable,
            quadrature: self.quadrature.as_ref().map(cut),
            noise_inflation: self.noise_inflation,
            spikes_s: self.spikes_s.clone(),
            level_known: self.level_known,
            filtered: self.filtered,
            rest: self.rest.clone().filter(|_| to_the_end),
        }
    }

    /// Separates a rest that the converter does not resolve from the samples.
    fn leave_unresolved(&mut self, criteria: &Criteria) {
        if !may_be_unresolved(&self.signal, &criteria.resolution) {
            return;
        }
        let step = self.converter_step(criteria.blocks.distinct_values);
        let end = resolved(&self.time, &self.signal, step, &criteria.resolution);
        if step > 0.0 && (MIN_SAMPLES..self.len()).contains(&end) {
            let after_end = end..self.len();
            let time = part_of(&self.time, after_end.clone());
            let rest = UnresolvedRest { time, signal: self.signal.part(after_end) };
            *self = Self { rest: Some(rest), ..self.part(0..end) };
        }
    }

    /// A marker that a rest follows, without its samples, for samples from which something was subtracted or
    /// that were straightened.
    pub(crate) fn rest_alone(&self) -> Option<UnresolvedRest<'a>> {
        let none = || UnresolvedRest { time: Cow::default(), signal: SampledSignal::new(Vec::new()) };
        self.rest.as_ref().map(|_| none())
    }

    /// The samples together with the rest after them.
    pub(crate) fn with_rest(&self) -> Cow<'_, Self> {
        let Some(rest) = &self.rest else { return Cow::Borrowed(self) };
        let time = Cow::Owned([&self.time[..], &rest.time].concat());
        let signal = SampledSignal::new([&self.signal[..], &rest.signal].concat());
        Cow::Owned(Self { time, signal, rest: None, ..self.clone() })
    }

    /// Removes samples by their indices, which are ascending.
    fn leave_out(&mut self, left_out: &[usize]) {
        if left_out.is_empty() {
            return;
        }
        self.spikes_s = left_out.iter().map(|i| self.time[*i]).collect();
        let kept = |column: &[f64]| {
            let mut next = left_out.iter().copied().peekable();
            let rest = column.iter().enumerate().filter(|(i, _)| next.next_if_eq(i).is_none());
            rest.map(|(_, v)| *v).collect::<Vec<f64>>()
        };
        self.time = Cow::Owned(kept(&self.time));
        self.signal = SampledSignal::new(kept(&self.signal));
        self.quadrature = self.quadrature.as_deref().map(|q| Cow::Owned(kept(q)));
    }

    /// Noise of a sample from the residuals within the blocks; with filtered noise, which has none there, the
    /// stored value.
    pub(crate) fn noise_rms(&self, blocks: &[Block]) -> f64 {
        match self.filtered {
            Filtered::Noise { rms } => rms,
            _ => self.noise_inflation.sqrt() * blocks::noise_rms(blocks),
        }
    }

    pub(crate) fn len(&self) -> usize {
        self.time.len()
    }

    /// Time from the first to the last sample, s.
    pub(crate) fn duration(&self) -> f64 {
        self.time[self.time.len() - 1] - self.time[0]
    }

    /// Smallest difference between distinct values, i.e. the step of the converter, if many values repeat.
    /// Zero if more than the fraction `distinct_values` of the samples are distinct.
    pub(crate) fn converter_step(&self, distinct_values: f64) -> f64 {
        let stride = (self.signal.len() / STEP_SAMPLES).max(1);
        let mut values: Vec<f64> = self.signal.iter().step_by(stride).copied().collect();
        if distinct_at_least(&values) as f64 > distinct_values * values.len() as f64 {
            return 0.0;
        }
        values.sort_by(f64::total_cmp);
        let range = values[values.len() - 1] - values[0];
        let count = values.len();
        values.dedup();
        if values.len() < 2 || values.len() as f64 > distinct_values * count as f64 {
            return 0.0;
        }
        values
            .windows(2)
            .map(|w| w[1] - w[0])
            .filter(|d| *d > ROUNDING * range)
            .fold(f64::INFINITY, f64::min)
            .min(range)
    }

    fn check_scales(&self) -> Result<(), Error> {
        let spread = |first: f64, (low, high): (f64, f64)| {
            low.abs().max(high.abs()).max(first - low).max(high - first)
        };
        let quadrature = self.quadrature.as_deref().map_or(0.0, |q| spread(q[0], extremes(q)));
        let signal = spread(self.signal[0], self.signal.extremes()).max(quadrature);
        if [signal, self.duration()].iter().all(|v| REPRESENTABLE.contains(v)) {
            return Ok(());
        }
        Err(Error::NoFit { reason: BEYOND_NUMBERS })
    }
}

/// A lower bound of the number of distinct values: the number of their marks in a table of [`MARKS`]. For
/// most records it makes sorting unnecessary.
fn distinct_at_least(values: &[f64]) -> usize {
    let mut marked = [0u64; MARKS / 64];
    for v in values {
        // Zeros of both signs count as one value.
        let hash = (v + 0.0).to_bits().wrapping_mul(SPREAD) >> (64 - MARKS.ilog2());
        marked[hash as usize / 64] |= 1 << (hash % 64);
    }
    marked.iter().map(|m| m.count_ones() as usize).sum()
}

/// Size of the table of marks, several times [`STEP_SAMPLES`].
const MARKS: usize = 1 << 14;
/// Odd factor that spreads the bits of a number (Knuth's multiplicative hashing with the golden ratio).
const SPREAD: u64 = 0x9e37_79b9_7f4a_7c15;

/// Index of the first sample at or after a time.
fn first_at(record: &Record, time_s: f64) -> usize {
    let (mut before, mut found) = (0, record.len());
    while before < found {
        let middle = usize::midpoint(before, found);
        if record.time_s(middle) < time_s { before = middle + 1 } else { found = middle }
    }
    before
}

#[cfg(test)]
mod tests {
    use super::*;

    fn samples(signal: Vec<f64>) -> Samples<'static> {
        let time = (0..signal.len()).map(|i| i as f64).collect();
        Samples {
            time: Cow::Owned(time),
            signal: SampledSignal::new(signal),
            observable: Observable::Displacement,
            quadrature: None,
            noise_inflation: 1.0,
            spikes_s: Vec::new(),
            level_known: true,
            filtered: Filtered::Nothing,
            rest: None,
        }
    }

    #[test]
    fn the_step_of_a_converter_shows_where_values_repeat() {
        let wave = |step: f64| {
            let value = |i: u32| ((f64::from(i) * 0.1).sin() / step).round() * step;
            samples((0..1500).map(value).collect()).converter_step(2.0 / 3.0)
        };
        assert!((wave(0.01) - 0.01).abs() < 1e-12);
        assert_eq!(wave(1e-9), 0.0);
    }
}
