//! From the columns chosen to a record with its account.

use slipfit::{Record, record::Averaging};

use crate::{
    Format, ReadOptions, ReadProblem,
    columns::{self, Choice, Head, Taken, Time},
    report::{ColumnTaken, Dialect, ReadReport, Reading, Skipped, TimeSource},
    table::TableSource,
};

/// Rows from which columns are told apart.
const PREVIEW_ROWS: usize = 1 << 17;
/// Tables looked into where none is named.
const MOST_TABLES: usize = 64;

/// A stamp before its predecessor.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct Backwards {
    pub(crate) row: u64,
    pub(crate) previous: f64,
    pub(crate) next: f64,
}

/// The columns read, row by row, and what was left out.
#[derive(Debug, Default)]
pub(crate) struct Samples {
    /// Empty where a rate stands in for times.
    pub(crate) time_s: Vec<f64>,
    pub(crate) signal: Vec<f64>,
    /// Empty but for a lock-in.
    pub(crate) quadrature: Vec<f64>,
    /// Rows that gave a sample.
    pub(crate) read: u64,
    pub(crate) backwards: Option<Backwards>,
    pub(crate) skipped: Vec<Skipped>,
}

/// Chooses table and columns of any source and reads them.
pub(crate) fn read(
    source: &mut dyn TableSource,
    format: Format,
    options: &ReadOptions,
) -> Result<Reading, ReadProblem> {
    let (table, choice) = pick(source, options)?;
    let mut averaging = options.averaging(&choice);
    let samples = scan(source, table, &choice, &mut averaging)?;
    let dialect = source.dialect();
    finish(format, dialect, &source.heads()[table], choice, samples, averaging)
}

/// The table to read and its columns.
fn pick(source: &mut dyn TableSource, options: &ReadOptions) -> Result<(usize, Choice), ReadProblem> {
    let names: Vec<String> = source.heads().iter().map(|h| h.name.clone()).collect();
    if let Some(wanted) = &options.sheet {
        let table = find(wanted, &names)?;
        return Ok((table, choose(source, table, options)?));
    }
    if let [_] = names[..] {
        return Ok((0, choose(source, 0, options)?));
    }
    let mut fit: Vec<(usize, Choice)> = Vec::new();
    let mut first_problem = None;
    for table in 0..names.len().min(MOST_TABLES) {
        match choose(source, table, options) {
            Ok(choice) => fit.push((table, choice)),
            Err(problem) => first_problem = first_problem.or(Some(problem)),
        }
        if !fit.is_empty() && !source.must_choose() {
            break;
        }
    }
    if fit.len() > 1 {
        let fitting: Vec<String> = fit.iter().map(|(t, _)| describe(&source.heads()[*t])).collect();
        return Err(ReadProblem::SeveralTables { tables: fitting.join("; ") });
    }
    let Some((table, mut choice)) = fit.pop() else {
        let tables: Vec<String> = source.heads().iter().take(MOST_TABLES).map(describe).collect();
        let reason = first_problem.map(|p| p.to_string()).unwrap_or_default();
        return Err(ReadProblem::NoTableFits { tables: tables.join("; "), reason });
    };
    choice.notes.push(format!(
        "of {} the table `{}` was read; --sheet reads another: {}",
        names.len(),
        names[table],
        shortened(&names, table)
    ));
    Ok((table, choice))
}

/// The names of the others, not too many.
fn shortened(names: &[String], taken: usize) -> String {
    const MOST: usize = 8;
    let others: Vec<&str> =
        names.iter().enumerate().filter(|(i, _)| *i != taken).map(|(_, n)| n.as_str()).collect();
    let mut list = others.iter().take(MOST).map(|n| format!("`{n}`")).collect::<Vec<_>>().join(", ");
    if others.len() > MOST {
        list += &format!(" and {} more", others.len() - MOST);
    }
    list
}

/// ``swing` with `t`, `x` ``.
pub(crate) fn describe(head: &Head) -> String {
    const MOST: usize = 6;
    let columns: Vec<String> = head
        .names
        .iter()
        .enumerate()
        .take(MOST)
        .map(|(i, n)| if n.header.is_empty() { format!("column {}", i + 1) } else { n.header.clone() })
        .collect();
    let more = if head.names.len() > MOST { ", …" } else { "" };
    format!("`{}` ({}{more})", head.name, columns.join(", "))
}

/// Index of the table asked for by name, by part of a name or by number.
pub(crate) fn find(wanted: &str, names: &[String]) -> Result<usize, ReadProblem> {
    let key = wanted.trim().trim_matches('/').to_lowercase();
    let plain = |n: &String| n.trim_matches('/').to_lowercase();
    if let Some(index) = names.iter().position(|n| plain(n) == key) {
        return Ok(index);
    }
    if let Ok(number) = key.parse::<usize>()
        && (1..=names.len()).contains(&number)
    {
        return Ok(number - 1);
    }
    let parts: Vec<usize> =
        (0..names.len()).filter(|&i| !key.is_empty() && plain(&names[i]).contains(&key)).collect();
    match parts[..] {
        [index] => Ok(index),
        _ => Err(ReadProblem::UnknownTable {
            wanted: wanted.to_owned(),
            tables: names.iter().map(|n| format!("`{n}`")).collect::<Vec<_>>().join(", "),
        }),
    }
}

fn choose(source: &mut dyn TableSource, table: usize, options: &ReadOptions) -> Result<Choice, ReadProblem> {
    let preview = crate::table::gather(source, table, PREVIEW_ROWS)?;
    let values: Vec<Vec<f64>> = preview.columns.into_iter().map(|c| c.values).collect();
    let mut choice = columns::choose(&source.heads()[table], &values, options)?;
    if choice.by_content && preview.cut {
        choice.notes.push(format!("the columns were chosen from the first {PREVIEW_ROWS} rows"));
    }
    Ok(choice)
}

/// Reads the columns chosen.
fn scan(
    source: &mut dyn TableSource,
    table: usize,
    choice: &Choice,
    averaging: &mut Averaging,
) -> Result<Samples, ReadProblem> {
    let mut wanted = vec![choice.signal.index];
    let time = match &choice.time {
        Time::Column(taken) | Time::Intervals(taken) => {
            wanted.push(taken.index);
            Some(taken)
        }
        Time::Rate(_) => None,
    };
    wanted.extend(choice.quadrature.as_ref().map(|q| q.index));
    let intervals = matches!(choice.time, Time::Intervals(_));
    let mut samples = Samples::default();
    let (mut row, mut elapsed, mut started) = (0_u64, 0.0, false);
    // By position among the columns wanted.
    let mut missing: Vec<(u64, u64)> = vec![(0, 0); wanted.len()];
    let left_out = source.scan(table, &wanted, &mut |batch| {
        for i in 0..batch[0].len() {
            row += 1;
            let gap = batch.iter().position(|column| !column[i].is_finite());
            if let Some(at) = gap {
                let (rows, first) = &mut missing[at];
                *rows += 1;
                if *rows == 1 {
                    *first = row;
                }
            } else {
                samples.read += 1;
            }
            let Some(taken) = time else {
                // The row was sampled: it keeps its time.
                samples.signal.push(if gap.is_none() { batch[0][i] } else { f64::NAN });
                if let Some(quadrature) = batch.get(1) {
                    samples.quadrature.push(if gap.is_none() { quadrature[i] } else { f64::NAN });
                }
                continue;
            };
            let mut stamp = batch[1][i];
            if intervals && stamp.is_finite() {
                // The first sample has nothing before it.
                elapsed += if started { stamp } else { 0.0 };
                started = true;
                stamp = elapsed;
            }
            if gap.is_some() {
                continue;
            }
            let time_s = taken.seconds.of(stamp);
            if let Some(&previous) = samples.time_s.last()
                && time_s < previous
                && samples.backwards.is_none()
            {
                samples.backwards = Some(Backwards { row, previous, next: time_s });
            }
            samples.time_s.push(time_s);
            samples.signal.push(batch[0][i]);
            samples.quadrature.extend(batch.get(2).map(|q| q[i]));
        }
        averaging.settle(&mut samples.time_s, &mut samples.signal, &mut samples.quadrature);
        true
    })?;
    let mut counted: Vec<Skipped> = wanted
        .iter()
        .zip(&missing)
        .filter(|(_, (rows, _))| *rows > 0)
        .map(|(column, &(rows, first_row))| Skipped {
            reason: format!("no value in column {}", column + 1),
            rows,
            first_row,
        })
        .collect();
    counted.sort_by_key(|s| s.first_row);
    samples.skipped = left_out;
    samples.skipped.extend(counted);
    Ok(samples)
}

/// Makes the record of what was read, and its account.
pub(crate) fn finish(
    format: Format,
    dialect: Option<Dialect>,
    head: &Head,
    mut choice: Choice,
    mut samples: Samples,
    mut averaging: Averaging,
) -> Result<Reading, ReadProblem> {
    let column = columns::label(&columns::info(head, choice.signal.index));
    let left_out_rows = averaging.finish(&mut samples.time_s, &mut samples.signal, &mut samples.quadrature);
    choice.notes.extend(averaged(&averaging, samples.signal.len(), left_out_rows));
    let factor = averaging.factor() as f64;
    linearise(&mut samples, &choice);
    let Samples { time_s, signal, quadrature, read: rows_read, backwards, skipped } = samples;
    let record = match (&choice.time, choice.quadrature.is_some()) {
        (Time::Rate(rate), false) => Record::uniform(*rate / factor, signal),
        (Time::Rate(rate), true) => Record::lock_in_uniform(*rate / factor, signal, quadrature),
        (_, false) => Record::new(time_s, signal),
        (_, true) => Record::lock_in(time_s, signal, quadrature),
    };
    let record = record.map_err(|error| match (error, backwards) {
        (slipfit::Error::ConstantSignal { value }, _) => ReadProblem::ConstantSignal { column, value },
        (slipfit::Error::TooFewSamples { found, needed }, _) => {
            ReadProblem::TooFewRows { read: found, needed, column, skipped: left_out(&skipped) }
        }
        (slipfit::Error::TimeBackwards { .. }, Some(back)) => ReadProblem::TimeBackwards {
            row: back.row,
            column: match &choice.time {
                Time::Column(t) | Time::Intervals(t) => columns::label(&columns::info(head, t.index)),
                Time::Rate(_) => String::new(),
            },
            previous: back.previous,
            next: back.next,
        },
        (other, _) => ReadProblem::Record(other),
    })?;
    let record = record.with_kind(choice.kind).with_unit(choice.signal.unit.clone());
    let taken = |t: Taken| ColumnTaken { column: columns::info(head, t.index), unit: t.unit, why: t.why };
    let report = ReadReport {
        path: String::new(),
        format,
        sheet: head.name.clone(),
        sha256: String::new(),
        bytes: 0,
        rows_read,
        skipped,
        dialect,
        columns: (0..head.names.len()).map(|i| columns::info(head, i)).collect(),
        kind: choice.kind,
        tables: choice.tables,
        table: choice.group.table,
        runs: choice.runs,
        run: choice.group.run,
        time: match choice.time {
            Time::Column(t) => TimeSource::Column(taken(t)),
            Time::Intervals(t) => TimeSource::Intervals(taken(t)),
            Time::Rate(rate) => TimeSource::Rate(rate),
        },
        signal: taken(choice.signal),
        quadrature: choice.quadrature.map(taken),
        named_values: head.named_values.clone(),
        notes: choice.notes,
    };
    Ok(Reading { record, report })
}

/// What averaging did, or why it did not.
fn averaged(averaging: &Averaging, samples: usize, left_out: usize) -> Option<String> {
    if let Some(why) = averaging.stopped() {
        return Some(format!("{samples} samples are held, more than --most-samples: {why}"));
    }
    (averaging.factor() > 1).then(|| {
        let rest = match left_out {
            0 => String::new(),
            1 => "; the last row makes up none".to_owned(),
            n => format!("; the last {n} rows make up none"),
        };
        format!(
            "{} rows each were averaged into one sample, so that no more than --most-samples are held; \
             {:.0} samples a cycle are left, and the {:.2} % this takes of the amplitude was put back{rest}",
            averaging.factor(),
            averaging.samples_a_cycle(),
            100.0 * (1.0 - averaging.gain())
        )
    })
}

/// Rows left out, as an error tells them.
fn left_out(skipped: &[Skipped]) -> String {
    let reasons: Vec<String> = skipped
        .iter()
        .map(|s| format!("{} (row {}{})", s.reason, s.first_row, if s.rows > 1 { " and others" } else { "" }))
        .collect();
    if reasons.is_empty() { String::new() } else { format!("; left out: {}", reasons.join(", ")) }
}

/// Makes levels in dB linear amplitudes, `10^(x/20)`.
fn linearise(samples: &mut Samples, choice: &Choice) {
    let linear = |values: &mut [f64]| values.iter_mut().for_each(|v| *v = 10f64.powf(*v / 20.0));
    if choice.signal.level {
        linear(&mut samples.signal);
    }
    if choice.quadrature.as_ref().is_some_and(|q| q.level) {
        linear(&mut samples.quadrature);
    }
}
