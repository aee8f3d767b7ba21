//! A record over time from a table, with its report.

use slipfit::{ClockReport, Record, record::Averaging};

use super::{
    open::{Origin, opened},
    pick, rounded,
};
use crate::{
    columns::{
        clock::Time,
        head::Head,
        record::{self, Choice},
        sentinel, units,
    },
    error::{OptionProblem, ReadError, ReadProblem},
    options::ReadOptions,
    report::{Note, ReadReport, Reading, Skipped, TimeSource},
    tables::table::{self, LeftOut, Reason, TableSource},
};

/// Maximum number of tables examined if none is named.
const MOST_TABLES: usize = 64;

/// A time stamp earlier than its predecessor.
#[derive(Debug, Clone, Copy, PartialEq)]
struct Backwards {
    row: u64,
    previous: f64,
    next: f64,
}

/// The columns read, row by row, and what was left out.
#[derive(Debug)]
struct Samples {
    /// Empty if a sampling rate replaces the times.
    time_s: Vec<f64>,
    signal: Vec<f64>,
    /// Empty except for a lock-in.
    quadrature: Vec<f64>,
    /// Rows that gave a sample.
    read: u64,
    backwards: Option<Backwards>,
    skipped: Vec<Skipped>,
    averaging: Averaging,
    /// Samples after a line that gave none, with their lines; between them each line is a sample.
    lines: Vec<(usize, u64)>,
}

impl Samples {
    /// Stores the line of the next sample if it does not follow from that of the previous sample.
    fn at_line(&mut self, line: u64) {
        /// Maximum number of lines stored; later ones follow from the last of them.
        const MOST: usize = 1 << 16;
        let next = self.signal.len();
        let follows = self.lines.last().is_some_and(|(sample, of)| of + (next - sample) as u64 == line);
        if !follows && self.lines.len() < MOST {
            self.lines.push((next, line));
        }
    }

    /// The line of a sample.
    fn line(&self, sample: usize) -> u64 {
        let before = self.lines.iter().rev().find(|(first, _)| *first <= sample);
        before.map_or(sample as u64 + 1, |(first, line)| line + (sample - first) as u64)
    }

    /// Leaves out samples with a sentinel for a missing value; with a sampling rate, their time is kept.
    fn leave_out_sentinels(&mut self, choice: &Choice) {
        let columns = [Some(&choice.signal), choice.quadrature.as_ref()];
        let mut hidden = false;
        for (at, chosen) in columns.into_iter().flatten().enumerate() {
            let found =
                sentinel::hide_in_record(if at == 0 { &mut self.signal } else { &mut self.quadrature });
            hidden |= !found.is_empty();
            for sentinel in found {
                let row = self.line(sentinel.first);
                self.skipped.push(sentinel.skipped(chosen.index + 1, row));
            }
        }
        if !hidden {
            return;
        }
        let is_value: Vec<bool> = (0..self.signal.len())
            .map(|i| self.signal[i].is_finite() && self.quadrature.get(i).is_none_or(|q| q.is_finite()))
            .collect();
        if self.time_s.is_empty() {
            self.read = is_value.iter().filter(|is| **is).count() as u64;
            return;
        }
        for column in [&mut self.time_s, &mut self.signal, &mut self.quadrature] {
            let mut is = is_value.iter();
            column.retain(|_| is.next().is_none_or(|is| *is));
        }
        self.read = self.signal.len() as u64;
    }
}

/// Reads a record from any format; `watch` receives the number of bytes read.
pub(crate) fn read(
    origin: Origin<'_>,
    name: &str,
    options: &ReadOptions,
    watch: Option<&mut dyn FnMut(u64)>,
) -> Result<Reading, ReadError> {
    let (mut reading, fingerprint) =
        opened(origin, options.format, watch, |source| from_source(source, name, options))
            .map_err(|problem| ReadError::new(name, problem))?;
    fingerprint.write(&mut reading.report, name);
    Ok(reading)
}

/// The record of one of the tables.
pub(super) fn from_source(
    source: &mut dyn TableSource,
    name: &str,
    options: &ReadOptions,
) -> Result<Reading, ReadProblem> {
    let (table, choice) = choose_table(source, name, options)?;
    let samples = scan(source, table, &choice, options)?;
    let mut reading = finish(source.heads()[table], choice, samples)?;
    reading.report.dialect = source.dialect(table);
    Ok(reading)
}

/// The table to read and its columns.
fn choose_table(
    source: &mut dyn TableSource,
    name: &str,
    options: &ReadOptions,
) -> Result<(usize, Choice), ReadProblem> {
    let heads = source.heads();
    let names: Vec<&str> = heads.iter().map(|h| h.name.as_str()).collect();
    let only = match &options.sheet {
        Some(wanted) => Some(pick::find(wanted, &names, source.dialect(0).is_some())?),
        None => (names.len() == 1).then_some(0),
    };
    if let Some(table) = only {
        return Ok((table, choose(source, table, name, options)?));
    }
    let mut fit: Vec<(usize, Choice)> = Vec::new();
    let mut first_problem = None;
    for table in 0..names.len().min(MOST_TABLES) {
        match choose(source, table, name, options) {
            Ok(choice) => fit.push((table, choice)),
            Err(problem) => first_problem = first_problem.or(Some(problem)),
        }
        let settled = fit.last().is_some_and(|(_, choice)| choice.rows_run.is_none() && !choice.last_resort);
        if settled && !source.must_choose() {
            break;
        }
    }
    // Runs in groups of columns take precedence over runs that only the rows reveal.
    if fit.iter().any(|(_, choice)| choice.rows_run.is_none()) {
        fit.retain(|(_, choice)| choice.rows_run.is_none());
    }
    if fit.iter().any(|(_, choice)| !choice.last_resort) {
        fit.retain(|(_, choice)| !choice.last_resort);
    }
    if !source.must_choose() {
        fit.truncate(1);
    }
    let heads = source.heads();
    if fit.len() > 1 {
        let fitting: Vec<String> = fit.iter().map(|(t, _)| pick::describe(heads[*t])).collect();
        return Err(ReadProblem::SeveralTables { tables: fitting.join("; ") });
    }
    let Some((table, mut choice)) = fit.pop() else {
        let tables: Vec<String> = heads.iter().take(MOST_TABLES).map(|head| pick::describe(head)).collect();
        let first = Box::new(first_problem.unwrap_or(ReadProblem::Empty));
        return Err(ReadProblem::NoTableFits { tables: tables.join("; "), first });
    };
    let names: Vec<&str> = heads.iter().map(|h| h.name.as_str()).collect();
    let text = format!("of {} tables, `{}` was read", names.len(), names[table]);
    let others = format!("reads another: {}", pick::others(&names, table));
    choice.notes.push(Note::new(text).hint("sheet", others));
    Ok((table, choice))
}

/// The columns of a table, chosen from its first rows; `name` is that of the file.
fn choose(
    source: &mut dyn TableSource,
    table: usize,
    name: &str,
    options: &ReadOptions,
) -> Result<Choice, ReadProblem> {
    let mut choice = Err(ReadProblem::Empty);
    for attempt in 0.. {
        let Some(preview) = table::preview(source, table, attempt)? else { break };
        choice = record::choose(&preview.head, &preview.columns, name, options);
        let decided = choice.as_ref().is_ok_and(|choice| !choice.by_content);
        if decided || !preview.cut {
            return choice;
        }
    }
    let mut choice = choice?;
    choice.notes.push(format!("the columns were chosen from the first {}", source.previewed()).into());
    Ok(choice)
}

/// Reads the chosen columns.
fn scan(
    source: &mut dyn TableSource,
    table: usize,
    choice: &Choice,
    options: &ReadOptions,
) -> Result<Samples, ReadProblem> {
    let mut wanted = vec![choice.signal.index];
    let time = match &choice.time {
        Time::Column(chosen, seconds) | Time::Intervals(chosen, seconds) => {
            wanted.push(chosen.index);
            Some(*seconds)
        }
        Time::Rate(_) => None,
    };
    wanted.extend(choice.quadrature.as_ref().map(|q| q.index));
    wanted.extend(choice.fraction.map(|fraction| fraction.index));
    let is_interval = matches!(choice.time, Time::Intervals(..));
    let interval_s = if let Time::Rate(rate_hz) = choice.time { Some(1.0 / rate_hz) } else { None };
    // The mean of levels is not the level of the mean.
    let is_level = choice.levels.contains(&true);
    let most = options.most_samples.unwrap_or(ReadOptions::MOST_SAMPLES);
    let averaging = Averaging::new(if is_level { usize::MAX } else { most }, interval_s);
    // Within a batch, more samples may arrive than are held.
    let room = source.rows_expected().min(most.saturating_add(1 << 20));
    let reserved = |used: bool| Vec::with_capacity(if used { room } else { 0 });
    let mut samples = Samples {
        time_s: reserved(time.is_some()),
        signal: reserved(true),
        quadrature: reserved(choice.quadrature.is_some()),
        read: 0,
        backwards: None,
        skipped: Vec::new(),
        averaging,
        lines: Vec::new(),
    };
    let (mut rows_before, mut elapsed, mut started) = (0_u64, 0.0, false);
    let mut left_out = LeftOut::default();
    let skipped = source.scan(table, &wanted, &mut |batch| {
        let first_line = batch.line.unwrap_or(rows_before + 1);
        let mut irregularities = batch.irregularities.iter().peekable();
        let mut lines_passed = 0;
        for i in 0..=batch.rows() {
            let mut reason = None;
            while let Some(next) = irregularities.next_if(|irregularity| irregularity.row == i) {
                if next.reason.is_no_row() {
                    left_out.count(&next.reason, first_line + i as u64 + lines_passed);
                    lines_passed += 1;
                } else {
                    reason = Some(&next.reason);
                }
            }
            if i == batch.rows() {
                break;
            }
            let line = first_line + i as u64 + lines_passed;
            let gap = batch.columns.iter().position(|column| !column[i].is_finite());
            match gap {
                Some(at) => left_out.count(reason.unwrap_or(&Reason::NoValue(wanted[at] + 1)), line),
                None => samples.read += 1,
            }
            let Some(seconds) = time else {
                samples.at_line(line);
                // The row was sampled: it keeps its time.
                samples.signal.push(if gap.is_none() { batch.columns[0][i] } else { f64::NAN });
                if let Some(quadrature) = batch.columns.get(1) {
                    samples.quadrature.push(if gap.is_none() { quadrature[i] } else { f64::NAN });
                }
                continue;
            };
            let mut stamp = batch.columns[1][i];
            if let Some(fraction) = choice.fraction {
                stamp += batch.columns[wanted.len() - 1][i] / fraction.per_second;
            }
            if is_interval && stamp.is_finite() {
                // The first sample has no predecessor.
                elapsed += if started { stamp } else { 0.0 };
                started = true;
                stamp = elapsed;
            }
            if gap.is_some() {
                continue;
            }
            let time_s = seconds.of(stamp);
            if let Some(&previous) = samples.time_s.last()
                && time_s < previous
                && samples.backwards.is_none()
            {
                samples.backwards = Some(Backwards { row: line, previous, next: time_s });
            }
            samples.at_line(line);
            samples.time_s.push(time_s);
            samples.signal.push(batch.columns[0][i]);
            samples.quadrature.extend(choice.quadrature.as_ref().map(|_| batch.columns[2][i]));
        }
        rows_before += batch.rows() as u64;
        if !batch.more {
            samples.averaging.settle(&mut samples.time_s, &mut samples.signal, &mut samples.quadrature);
        }
        true
    })?;
    samples.skipped = skipped;
    samples.skipped.extend(left_out.skipped());
    Ok(samples)
}

/// Builds the record from the samples, with its report.
fn finish(head: &Head, mut choice: Choice, mut samples: Samples) -> Result<Reading, ReadProblem> {
    let column = head.label(choice.signal.index);
    let left_out_rows =
        samples.averaging.finish(&mut samples.time_s, &mut samples.signal, &mut samples.quadrature);
    choice.notes.extend(averaged(&samples.averaging, samples.signal.len(), left_out_rows));
    if samples.averaging.factor() == 1 {
        samples.leave_out_sentinels(&choice);
    }
    let factor = samples.averaging.factor() as f64;
    for (values, level) in [&mut samples.signal, &mut samples.quadrature].into_iter().zip(choice.levels) {
        if level {
            values.iter_mut().for_each(|v| *v = units::from_decibels(*v));
        }
    }
    let mut advice = None;
    choice.notes.extend(past_midnight(&mut samples.time_s));
    if samples.averaging.factor() == 1 {
        choice.notes.extend(snap_to_step(head, &choice.time, &mut samples.time_s));
        advice = rounded::advice(&samples.time_s);
    }
    let Samples { time_s, signal, quadrature, read: rows_read, backwards, skipped, .. } = samples;
    let record = match (&choice.time, choice.quadrature.is_some(), choice.rows_run) {
        (Time::Rate(_), _, Some(run)) if run != 1 => Err(slipfit::Error::NoSuchRun { asked: run, found: 1 }),
        (Time::Rate(rate), false, _) => Record::uniform(*rate / factor, signal),
        (Time::Rate(rate), true, _) => Record::lock_in_uniform(*rate / factor, signal, quadrature),
        (_, false, None) => Record::new(time_s, signal),
        (_, true, None) => Record::lock_in(time_s, signal, quadrature),
        (_, paired, Some(run)) => Record::of_run(run, time_s, signal, paired.then_some(quadrature)),
    };
    let record = record.map_err(|error| match (error, backwards) {
        (slipfit::Error::ConstantSignal { value }, _) => ReadProblem::ConstantSignal { column, value },
        (slipfit::Error::TooFewSamples { found, needed }, _) => {
            ReadProblem::TooFewRows { read: found, needed, column, skipped: left_out(&skipped) }
        }
        (
            slipfit::Error::TimeOutOfOrder { backward, forward, .. },
            Some(Backwards { row, previous, next }),
        ) => {
            let column = choice.time.column().map(|t| head.label(t.index)).unwrap_or_default();
            ReadProblem::TimeBackwards { row, column, previous, next, backward, forward }
        }
        (slipfit::Error::NoSuchRun { asked, found }, _) => ReadProblem::Option {
            option: "run",
            value: asked.to_string(),
            problem: OptionProblem::NumberTooLarge(found),
        },
        (other, _) => ReadProblem::Data(other),
    })?;
    let runs = runs_in_rows(&mut choice, record.clock_report());
    choice.notes.extend(runs);
    choice.notes.extend(advice.filter(|_| record.clock_report().rebuilt_quantum_s.is_none()));
    let record = record
        .with_kind(choice.kind)
        .with_unit(choice.signal.unit.clone())
        .with_lossy_compression(head.lossy)
        .with_turning_gravity(choice.turning_gravity);
    let signal = ("signal", choice.signal.taken(head));
    let quadrature = choice.quadrature.map(|q| ("quadrature", q.taken(head)));
    let report = ReadReport {
        rows_read,
        skipped,
        kind: choice.kind,
        parts: choice.parts,
        part: choice.part,
        runs: choice.runs,
        run: choice.run,
        time: Some(match choice.time {
            Time::Column(chosen, _) => TimeSource::Column(chosen.taken(head)),
            Time::Intervals(chosen, _) => TimeSource::Intervals(chosen.taken(head)),
            Time::Rate(rate) => TimeSource::Rate(rate),
        }),
        taken: [Some(signal), quadrature].into_iter().flatten().collect(),
        notes: choice.notes,
        ..head.report()
    };
    Ok(Reading { record, report })
}

/// Note on several runs that follow each other, and their number.
fn runs_in_rows(choice: &mut Choice, clock: &ClockReport) -> Option<Note> {
    if clock.resets == 0 {
        return None;
    }
    let (found, taken) = (clock.resets + 1, clock.run);
    let longest = if choice.rows_run.is_some() { "" } else { ", the longest," };
    let note = Note::new(format!(
        "the clock restarts: {found} runs follow one another; number {taken}{longest} was read"
    ));
    // Numbers refer to runs in groups of columns.
    if choice.runs > 1 {
        return Some(note);
    }
    (choice.runs, choice.run) = (found, taken);
    Some(note.hint("run", "reads another"))
}

/// Clock times restart at midnight: later times are increased by one day.
fn past_midnight(time_s: &mut [f64]) -> Option<Note> {
    const DAY_S: f64 = 86400.0;
    let of_clock = |t: &f64| (0.0..=DAY_S).contains(t);
    let steps = || time_s.windows(2).map(|w| w[1] - w[0]);
    let fall = |step: f64| step < -0.9 * DAY_S;
    // Exactly one drop in the record, and no other backward step.
    if steps().filter(|s| *s < 0.0).count() != 1 || !steps().any(fall) || !time_s.iter().all(of_clock) {
        return None;
    }
    let at = steps().position(fall)? + 1;
    time_s[at..].iter_mut().for_each(|t| *t += DAY_S);
    Some(Note::new("the times restart at midnight: later times were shifted by a day"))
}

/// Moves rounded times to multiples of the step stated in the file, if all of them deviate by less than half a step.
fn snap_to_step(head: &Head, time: &Time, time_s: &mut [f64]) -> Option<Note> {
    let (step, Time::Column(chosen, units::Seconds::Same)) = (head.step_s?, time) else { return None };
    let first = *time_s.first()?;
    let at = |i: usize| first + i as f64 * step;
    let near = |(i, t): (usize, &f64)| (t - at(i)).abs() < 0.5 * step;
    if chosen.index != 0 || !time_s.iter().enumerate().all(near) {
        return None;
    }
    time_s.iter_mut().enumerate().for_each(|(i, t)| *t = at(i));
    Some(Note::new(format!("the times were calculated from the time step that the file states, {step} s")))
}

/// Describes the averaging, or why it was not done.
fn averaged(averaging: &Averaging, samples: usize, left_out: usize) -> Option<Note> {
    if let Some(why) = averaging.stopped() {
        return Some(
            Note::new(format!("{samples} samples are held, more than the limit, because {why}"))
                .hint("most_samples", "sets the limit"),
        );
    }
    (averaging.factor() > 1).then(|| {
        let rest = match left_out {
            0 => String::new(),
            1 => "; the last row was left out".to_owned(),
            n => format!("; the last {n} rows were left out"),
        };
        let text = format!(
            "every {} rows were averaged into one sample; {:.0} samples per cycle are left, and the \
             amplitude was corrected for the {:.2} % that averaging removes{rest}",
            averaging.factor(),
            averaging.samples_a_cycle(),
            100.0 * (1.0 - averaging.gain())
        );
        Note::new(text).hint("most_samples", "sets how many are held")
    })
}

/// Rows left out, as given in an error.
fn left_out(skipped: &[Skipped]) -> String {
    let reasons: Vec<String> = skipped
        .iter()
        .map(|s| format!("{} (row {}{})", s.reason, s.first_row, if s.rows > 1 { " and others" } else { "" }))
        .collect();
    if reasons.is_empty() { String::new() } else { format!("; left out: {}", reasons.join(", ")) }
}
