//! Converts the rows of a file into rows in order of time.

use std::ops::Range;

/// Minimum number of samples of a record.
pub const MIN_SAMPLES: usize = 8;

use super::criteria::ClockCriteria;
use super::{Clock, ClockReport, Gap, bursts, rounding, wraps};
use crate::Error;
use crate::numeric::order::ascending;
use crate::numeric::robust::median;

/// Number of steps used for a median.
const MEDIAN_SAMPLE: usize = 1 << 17;

/// The rows from which a record is made. `time_s` may be empty if a sampling rate is given instead.
pub(super) struct Rows {
    pub(super) time_s: Vec<f64>,
    pub(super) signal: Vec<f64>,
    pub(super) quadrature: Option<Vec<f64>>,
}

impl Rows {
    /// Whether all values of row `i` are finite.
    pub(super) fn finite(&self, i: usize) -> bool {
        self.signal[i].is_finite()
            && self.time_s.get(i).is_none_or(|t| t.is_finite())
            && self.quadrature.as_ref().is_none_or(|q| q[i].is_finite())
    }

    /// Whether all values of all rows are finite.
    fn all_finite(&self) -> bool {
        let columns = [&self.time_s, &self.signal].into_iter().chain(&self.quadrature);
        columns.into_iter().all(|column| all(column, |_, v| v.is_finite()))
    }

    /// Range from the first to the last finite row.
    pub(super) fn finite_span(&self) -> Range<usize> {
        let n = self.signal.len();
        let start = (0..n).find(|&i| self.finite(i)).unwrap_or(n);
        let end = (start..n).rev().find(|&i| self.finite(i)).map_or(start, |i| i + 1);
        start..end
    }

    fn columns(&mut self) -> impl Iterator<Item = &mut Vec<f64>> {
        [&mut self.time_s, &mut self.signal].into_iter().chain(&mut self.quadrature).filter(|c| !c.is_empty())
    }

    fn keep(&mut self, range: Range<usize>) {
        for column in self.columns() {
            column.truncate(range.end);
            column.drain(..range.start);
        }
    }

    fn remove(&mut self, sorted: &[usize]) {
        for column in self.columns() {
            let (mut next, mut i) = (0, 0);
            column.retain(|_| {
                let drop = sorted.get(next) == Some(&i);
                next += usize::from(drop);
                i += 1;
                !drop
            });
        }
    }

    fn sort_by_time(&mut self) {
        let order = ascending(&self.time_s);
        for column in self.columns() {
            *column = order.iter().map(|&i| column[i]).collect();
        }
    }
}

/// Drops rows with a non-finite value.
pub(super) fn drop_nonfinite(rows: &mut Rows, report: &mut ClockReport) {
    if rows.all_finite() {
        return;
    }
    let n = rows.signal.len();
    let used = rows.finite_span();
    report.nonfinite_leading = used.start;
    report.nonfinite_trailing = n - used.end;
    let inner: Vec<usize> = used.clone().filter(|&i| !rows.finite(i)).collect();
    report.nonfinite_inner = inner.len();
    if !inner.is_empty() {
        rows.remove(&inner);
    }
    let end = used.end - inner.len();
    if used.start > 0 || end < rows.signal.len() {
        rows.keep(used.start..end);
    }
}

/// Rejects a signal that is too short or constant.
pub(super) fn check_signal(rows: &Rows) -> Result<(), Error> {
    let found = rows.signal.len();
    if found < MIN_SAMPLES {
        return Err(Error::TooFewSamples { found, needed: MIN_SAMPLES });
    }
    let constant = |c: &Vec<f64>| c.iter().all(|v| *v == c[0]);
    if constant(&rows.signal) && rows.quadrature.as_ref().is_none_or(constant) {
        return Err(Error::ConstantSignal { value: rows.signal[0] });
    }
    Ok(())
}

/// Puts the rows of one run (the longest unless one is named) in order of time and extracts their clock.
pub(super) fn clock(rows: &mut Rows, report: &mut ClockReport, run: Option<usize>) -> Result<Clock, Error> {
    if let Some(clock) = exactly_uniform(&rows.time_s) {
        report.run = run.map_or(Ok(1), |run| numbered(run, 1))?;
        return Ok(settle(clock, rows, report));
    }
    let c = &ClockCriteria::default();
    check_direction(&rows.time_s, c)?;
    count_on(rows, report, c);
    drop_corrupt_stamps(rows, report, c);
    keep_run(rows, report, run, c)?;
    let backward = steps(&rows.time_s).filter(|s| *s < 0.0).count();
    if backward > 0 {
        report.reordered = backward;
        rows.sort_by_time();
    }
    report.repeated_stamps = steps(&rows.time_s).filter(|s| *s == 0.0).count();
    if let Some(clock) = exactly_uniform(&rows.time_s) {
        return Ok(settle(clock, rows, report));
    }
    let many_repeat = report.repeated_stamps as f64 > c.repeated_share * rows.time_s.len() as f64;
    if many_repeat && let Some(rebuilt) = rounding::rebuild(&rows.time_s, c) {
        report.rebuilt_quantum_s = Some(rebuilt.quantum_s);
        report.rebuilt_excess_s = rebuilt.excess_s;
        report.rebuilt_rate_error = rebuilt.rate_error;
        return Ok(settle(rebuilt.clock, rows, report));
    }
    if many_repeat && let Some(rebuilt) = bursts::rebuild(&rows.time_s, &rows.signal, c) {
        report.burst_samples = Some(rebuilt.samples);
        report.rebuilt_rate_error = rebuilt.rate_error;
        if let Clock::Stamps(stamps) = &rebuilt.clock {
            describe_steps(stamps, report, c);
        }
        return Ok(settle(rebuilt.clock, rows, report));
    }
    let stamps = std::mem::take(&mut rows.time_s);
    describe_steps(&stamps, report, c);
    Ok(Clock::Stamps(stamps))
}

fn settle(clock: Clock, rows: &mut Rows, report: &mut ClockReport) -> Clock {
    rows.time_s = Vec::new();
    if let Clock::Uniform { interval_s, .. } = clock {
        report.median_step_s = interval_s;
    }
    clock
}

fn steps(time_s: &[f64]) -> impl Iterator<Item = f64> + '_ {
    time_s.windows(2).map(|w| w[1] - w[0])
}

/// The uniform clock that agrees with all stamps to 1e-9 of a step, or to a few units in the last place if the stamps
/// have no better resolution.
fn exactly_uniform(time_s: &[f64]) -> Option<Clock> {
    let (&start_s, &end_s) = (time_s.first()?, time_s.last()?);
    let interval_s = (end_s - start_s) / (time_s.len() as f64 - 1.0);
    if !(interval_s > 0.0 && interval_s.is_finite()) {
        return None;
    }
    let tolerance_s = (1e-9 * interval_s).max(4.0 * f64::EPSILON * start_s.abs().max(end_s.abs()));
    // Beyond this the rounding of the stamps would hide jitter.
    if tolerance_s > 1e-6 * interval_s {
        return None;
    }
    let fits = |i: f64, t: f64| (t - (start_s + i * interval_s)).abs() <= tolerance_s;
    all(time_s, fits).then_some(Clock::Uniform { start_s, interval_s })
}

/// Whether `are_so` holds for all values with their indices: evaluated block by block, so that it can be vectorised.
fn all(values: &[f64], are_so: impl Fn(f64, f64) -> bool) -> bool {
    const BLOCK: usize = 1024;
    let so = |(k, block): (usize, &[f64])| {
        let start = (k * BLOCK) as f64;
        block.iter().enumerate().fold(true, |so, (i, v)| so & are_so(start + f64::from(i as u32), *v))
    };
    values.chunks(BLOCK).enumerate().all(so)
}

fn check_direction(time_s: &[f64], c: &ClockCriteria) -> Result<(), Error> {
    let backward = steps(time_s).filter(|s| *s < 0.0).count();
    let forward = steps(time_s).filter(|s| *s > 0.0).count();
    if backward + forward == 0 {
        return Err(Error::TimeStandsStill { time_s: time_s.first().copied().unwrap_or(f64::NAN) });
    }
    if backward > forward || is_shuffled(time_s, backward, c) {
        let index = 1 + steps(time_s).position(|s| s < 0.0).unwrap_or(0);
        let (previous, next) = (time_s[index - 1], time_s[index]);
        return Err(Error::TimeOutOfOrder { index, previous, next, backward, forward });
    }
    Ok(())
}

/// Continues the count of a clock that restarts at zero while the motion goes on.
fn count_on(rows: &mut Rows, report: &mut ClockReport, c: &ClockCriteria) {
    if steps(&rows.time_s).all(|s| s >= 0.0) {
        return;
    }
    let step_s = median_step(&rows.time_s);
    if let Some(wraps) = wraps::join(&mut rows.time_s, step_s, c) {
        (report.wraps, report.wrap_period_s) = (wraps.count, Some(wraps.period_s));
    }
}

/// Whether rows are far from their place throughout the record: no clock does that.
fn is_shuffled(time_s: &[f64], backward: usize, c: &ClockCriteria) -> bool {
    if (backward as f64) < c.shuffled_share * time_s.len() as f64 {
        return false;
    }
    let order = ascending(time_s);
    let is_far = |(place, row): &(usize, &usize)| place.abs_diff(**row) > c.disorder_rows;
    let far = order.iter().enumerate().filter(is_far).count();
    2 * far > time_s.len()
}

/// Drops single rows whose stamp is far from both neighbours while these are in order.
fn drop_corrupt_stamps(rows: &mut Rows, report: &mut ClockReport, c: &ClockCriteria) {
    let t = &rows.time_s;
    let far = c.disorder_steps * median_step(t);
    let mut corrupt = Vec::new();
    for i in 1..t.len() {
        if t[i - 1] - t[i] <= far || corrupt.last() == Some(&(i - 1)) {
            continue;
        }
        let ahead = i < 2 || t[i] >= t[i - 2];
        let behind = t.get(i + 1).is_none_or(|next| *next >= t[i - 1]);
        if ahead && !(i < 2 && behind) {
            corrupt.push(i - 1);
        } else if behind {
            corrupt.push(i);
        }
    }
    report.corrupt_stamps = corrupt.len();
    if !corrupt.is_empty() {
        rows.remove(&corrupt);
    }
}

/// Splits the rows where the clock jumps back permanently and keeps one part.
fn keep_run(
    rows: &mut Rows,
    report: &mut ClockReport,
    wanted: Option<usize>,
    c: &ClockCriteria,
) -> Result<(), Error> {
    let runs = runs(&rows.time_s, c);
    report.resets = runs.len() - 1;
    report.run = match wanted {
        Some(run) => numbered(run, runs.len())?,
        None => longest(&runs),
    };
    if report.resets > 0 {
        let kept = runs[report.run - 1].clone();
        report.other_run_rows = rows.time_s.len() - kept.len();
        rows.keep(kept);
    }
    Ok(())
}

/// The parts between permanent backward jumps of the clock; at least one.
fn runs(time_s: &[f64], c: &ClockCriteria) -> Vec<Range<usize>> {
    let n = time_s.len();
    let far = c.disorder_steps * median_step(time_s);
    let resets = |i: &usize| {
        let before = time_s[i - 1];
        let recovers = || time_s[*i..n.min(i + c.disorder_rows)].iter().any(|next| *next >= before);
        before - time_s[*i] > far && !recovers()
    };
    let starts = std::iter::once(0).chain((1..n).filter(resets));
    let ends: Vec<usize> = starts.clone().skip(1).chain([n]).collect();
    starts.zip(ends).map(|(start, end)| start..end).collect()
}

/// Number of the longest run; the first if several are equally long.
fn longest(runs: &[Range<usize>]) -> usize {
    let longest = (0..runs.len()).reduce(|best, i| if runs[i].len() > runs[best].len() { i } else { best });
    longest.map_or(1, |i| i + 1)
}

fn numbered(asked: usize, found: usize) -> Result<usize, Error> {
    if (1..=found).contains(&asked) { Ok(asked) } else { Err(Error::NoSuchRun { asked, found }) }
}

/// Median of the positive steps, estimated from a subset in long records.
fn median_step(time_s: &[f64]) -> f64 {
    let stride = time_s.len().div_ceil(MEDIAN_SAMPLE).max(1);
    let mut sample: Vec<f64> =
        time_s.windows(2).step_by(stride).map(|w| w[1] - w[0]).filter(|s| *s > 0.0).collect();
    median(&mut sample).unwrap_or(0.0)
}

fn describe_steps(stamps: &[f64], report: &mut ClockReport, c: &ClockCriteria) {
    let stride = stamps.len().div_ceil(MEDIAN_SAMPLE).max(1);
    let mut sample: Vec<f64> = stamps.windows(2).step_by(stride).map(|w| w[1] - w[0]).collect();
    let typical = match median(&mut sample) {
        Some(m) if m > 0.0 => m,
        _ => median_step(stamps),
    };
    report.median_step_s = typical;
    let near = sample.iter().filter(|s| (*s - typical).abs() <= c.regular_spread * typical).count();
    let regular = near as f64 >= c.regular_share * sample.len() as f64;
    let (mut sum, mut count) = (0.0, 0.0_f64);
    for (i, step) in steps(stamps).enumerate() {
        let is_gap = if regular {
            step > c.regular_gap * typical
        } else {
            step > c.irregular_gap * typical && step > c.irregular_gap * neighbour_step(stamps, i)
        };
        if is_gap {
            report.gaps += 1;
            if report.longest_gap.is_none_or(|g| step > g.length_s) {
                report.longest_gap = Some(Gap { start_s: stamps[i], length_s: step });
            }
        } else {
            sum += (step / typical - 1.0).powi(2);
            count += 1.0;
        }
    }
    report.step_spread = (sum / count.max(1.0)).sqrt();
}

/// Median of the eight steps around step `i`.
fn neighbour_step(stamps: &[f64], i: usize) -> f64 {
    let last = stamps.len() - 1;
    let mut near: Vec<f64> = (i.saturating_sub(4)..(i + 5).min(last))
        .filter(|&j| j != i)
        .map(|j| stamps[j + 1] - stamps[j])
        .collect();
    median(&mut near).unwrap_or(0.0)
}
