//! Records longer than memory should hold are averaged while they are read.

use crate::signal::spectrum;
use std::f64::consts::PI;

/// Averages rows while they are read, so that a record of any length stays within a given number of samples.
///
/// Whenever more than `most` samples are stored, neighbours are averaged in pairs; from then on incoming rows are
/// averaged in groups of that size. Rows of an irregular clock, and oscillations that would keep fewer than
/// [`Averaging::LEAST_A_CYCLE`] samples per cycle, are not averaged: the record then grows beyond `most`.
///
/// The mean of `k` samples a time `h` apart shows an oscillation of frequency `f` at its middle, reduced by the
/// factor
///
/// ```text
/// sin(pi f k h) / (k sin(pi f h)),
/// ```
///
/// which [`Averaging::finish`] corrects (at most 0.7 %). White noise falls by `sqrt(k)`, so that an estimate from the
/// averaged record is as precise as one from all rows.
///
/// ```
/// use slipfit::record::Averaging;
/// let swing = |i: usize| (0.05 * i as f64).cos();
/// let mut averaging = Averaging::new(1000, Some(1.0));
/// let (mut time_s, mut signal, mut quadrature) = (Vec::new(), Vec::new(), Vec::new());
/// for i in 0..3000 {
///     signal.push(swing(i));
///     averaging.settle(&mut time_s, &mut signal, &mut quadrature);
/// }
/// averaging.finish(&mut time_s, &mut signal, &mut quadrature);
/// assert_eq!((averaging.factor(), signal.len()), (4, 750));
/// // The first sample stands for the first four rows, at their mean time of 1.5 s.
/// assert!((signal[0] - (0.05 * 1.5_f64).cos()).abs() < 1e-5);
/// ```
#[derive(Debug, Clone)]
pub struct Averaging {
    most: usize,
    /// Time between two rows, if there are no time stamps.
    interval_s: Option<f64>,
    /// Number of rows per sample.
    factor: usize,
    /// Number of leading samples that are means of `factor` rows; single rows follow.
    done: usize,
    row_s: f64,
    frequency_hz: f64,
    /// Reason why no more rows are averaged.
    stopped: Option<&'static str>,
}

impl Averaging {
    /// Minimum number of samples per cycle after averaging.
    pub const LEAST_A_CYCLE: f64 = 16.0;

    /// Averaging to at most `most` samples; `interval_s` is the time between two rows without time stamps.
    #[must_use]
    pub fn new(most: usize, interval_s: Option<f64>) -> Self {
        let row_s = interval_s.unwrap_or(0.0);
        let most = most.max(64);
        Self { most, interval_s, factor: 1, done: 0, row_s, frequency_hz: 0.0, stopped: None }
    }

    /// Number of rows per sample; 1 if nothing was averaged.
    #[must_use]
    pub fn factor(&self) -> usize {
        self.factor
    }

    /// Remaining samples per cycle of the strongest oscillation.
    #[must_use]
    pub fn samples_a_cycle(&self) -> f64 {
        1.0 / (self.frequency_hz * self.factor as f64 * self.row_s)
    }

    /// Reason why more rows than wanted are stored, if there are.
    #[must_use]
    pub fn stopped(&self) -> Option<&'static str> {
        self.stopped
    }

    /// Remaining part of an oscillation's amplitude.
    #[must_use]
    pub fn gain(&self) -> f64 {
        let (k, phase) = (self.factor as f64, PI * self.frequency_hz * self.row_s);
        if phase > 0.0 { (k * phase).sin() / (k * phase.sin()) } else { 1.0 }
    }

    /// Averages the rows added since the last call, and joins samples if they are too many. Unused columns are empty;
    /// the others have equal lengths.
    pub fn settle(&mut self, time_s: &mut Vec<f64>, signal: &mut Vec<f64>, quadrature: &mut Vec<f64>) {
        if self.factor > 1 && signal.len() >= self.done + self.factor {
            let limit_s = 1.5 * self.row_s;
            self.done = join(self.done, self.factor, limit_s, time_s, signal, quadrature);
        }
        while signal.len() > self.most && self.stopped.is_none() {
            self.halve(time_s, signal, quadrature);
        }
    }

    /// Averages the remaining rows at the end and corrects the amplitude of the oscillation. Returns the number of
    /// last rows omitted because they do not make up a sample (less than a sixteenth of a cycle).
    pub fn finish(
        &mut self,
        time_s: &mut Vec<f64>,
        signal: &mut Vec<f64>,
        quadrature: &mut Vec<f64>,
    ) -> usize {
        self.settle(time_s, signal, quadrature);
        if self.factor == 1 {
            return 0;
        }
        let left_out = signal.len() - self.done;
        for column in [time_s, &mut *signal, &mut *quadrature] {
            column.truncate(self.done);
        }
        let gain = self.gain();
        for column in [signal, quadrature].into_iter().filter(|c| !c.is_empty()) {
            let (sum, count) = column
                .iter()
                .filter(|v| v.is_finite())
                .fold((0.0, 0_u64), |(sum, count), v| (sum + v, count + 1));
            let mean = sum / count.max(1) as f64;
            column.iter_mut().for_each(|v| *v = mean + (*v - mean) / gain);
        }
        left_out
    }

    fn halve(&mut self, time_s: &mut Vec<f64>, signal: &mut Vec<f64>, quadrature: &mut Vec<f64>) {
        let step_s = match self.interval_s {
            Some(row_s) => row_s * self.factor as f64,
            None => match even(&time_s[..self.complete_len(signal.len())]) {
                Some(step_s) => step_s,
                None => return self.stopped = Some("its clock is not uniform"),
            },
        };
        self.row_s = step_s / self.factor as f64;
        let complete = &signal[..self.complete_len(signal.len())];
        let Some(line) = spectrum::loudest_line(complete, step_s) else {
            return self.stopped = Some("no oscillation was found in it");
        };
        if line.frequency_hz * 2.0 * step_s * Self::LEAST_A_CYCLE > 1.0 {
            return self.stopped = Some("averaging would leave too few samples per cycle");
        }
        self.frequency_hz = line.frequency_hz;
        // Rows that do not yet make up a sample are kept as they are.
        let complete = self.complete_len(signal.len()) & !1;
        let waiting = signal.len() - complete;
        let tail = |column: &mut Vec<f64>| {
            if column.is_empty() { Vec::new() } else { column.split_off(column.len() - waiting) }
        };
        let tails = [tail(time_s), tail(signal), tail(quadrature)];
        // An odd sample after the pairs would fit neither kind: it is expanded into the same number of rows.
        let odd = if self.factor > 1 { self.done - complete } else { 0 };
        self.done = join(0, 2, 1.5 * step_s, time_s, signal, quadrature);
        let (factor, row_s) = (self.factor, self.row_s);
        let middle = 0.5 * (factor as f64 - 1.0);
        let steps = [row_s, 0.0, 0.0];
        for ((column, tail), step) in [time_s, signal, quadrature].into_iter().zip(tails).zip(steps) {
            for value in tail.iter().take(odd) {
                column.extend((0..factor).map(|i| value + (i as f64 - middle) * step));
            }
            column.extend_from_slice(&tail[odd.min(tail.len())..]);
        }
        self.factor *= 2;
    }

    /// Number of values that are samples of the present kind.
    fn complete_len(&self, len: usize) -> usize {
        if self.factor > 1 { self.done } else { len }
    }
}

/// The step of a clock, if all its steps agree within half of it.
fn even(time_s: &[f64]) -> Option<f64> {
    let (first, last) = (time_s.first()?, time_s.last()?);
    let step_s = (last - first) / (time_s.len() as f64 - 1.0);
    let steady = |w: &[f64]| (w[1] - w[0] - step_s).abs() <= 0.5 * step_s;
    (step_s > 0.0 && step_s.is_finite() && time_s.windows(2).all(steady)).then_some(step_s)
}

/// Replaces each `factor` rows from `start` on by their mean; a step beyond `limit_s` ends a group early. Returns the
/// end of the means; incomplete groups follow as rows.
fn join(
    start: usize,
    factor: usize,
    limit_s: f64,
    time_s: &mut Vec<f64>,
    signal: &mut Vec<f64>,
    quadrature: &mut Vec<f64>,
) -> usize {
    let (n, timed) = (signal.len(), !time_s.is_empty());
    let (mut to, mut from) = (start, start);
    while from < n {
        let mut end = (from + factor).min(n);
        if timed {
            let broken = |w: &[f64]| !(w[1] - w[0]).abs().le(&limit_s);
            if let Some(at) = time_s[from..(end + 1).min(n)].windows(2).position(broken) {
                end = from + at + 1;
            } else if end - from < factor {
                break;
            }
        } else if end - from < factor {
            break;
        }
        for column in [&mut *time_s, &mut *signal, &mut *quadrature] {
            if !column.is_empty() {
                column[to] = mean(&column[from..end]);
            }
        }
        (to, from) = (to + 1, end);
    }
    for column in [time_s, signal, quadrature].into_iter().filter(|c| !c.is_empty()) {
        column.drain(to..from);
    }
    to
}

/// Mean of the finite values, to full precision if they are close together; NaN if there are none.
fn mean(values: &[f64]) -> f64 {
    let Some(&first) = values.iter().find(|v| v.is_finite()) else { return f64::NAN };
    let finite = values.iter().filter(|v| v.is_finite());
    let (sum, count) = finite.fold((0.0, 0.0), |(sum, count), v| (sum + (v - first), count + 1.0));
    first + sum / count
}
