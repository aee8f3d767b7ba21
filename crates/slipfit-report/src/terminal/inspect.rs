//! Overview of a file.

use super::braille;
use super::table::{Align, columns, width};
use super::{ANSWER, DIM, HEADING, WIDTH, labelled};
use crate::document::{reading, resonance};
use crate::escape;
use crate::format::{instant, plain};
use slipfit::answer::hint::Spelling;
use slipfit::record::Swings;
use slipfit_io::{Delimiter, Dialect, ReadError, Reading, SweepReading, Table, Tables};
use std::fmt::Write as _;
use std::path::Path;

/// Numbers of tables and columns shown; further ones are only counted.
const MOST_TABLES: usize = 8;
const MOST_COLUMNS: usize = 16;

/// What is known of a file.
#[derive(Debug, Clone, Copy)]
pub struct Inspected<'a> {
    /// Its name, for display.
    pub file: &'a Path,
    /// Everything it holds.
    pub tables: &'a Tables,
    /// The record it would be read as, or why it is not one.
    pub reading: &'a Result<Reading, ReadError>,
    /// The swings of the record.
    pub swings: Option<Swings>,
    /// The resonance curve, if the file is one and not a record.
    pub curve: Option<&'a SweepReading>,
    /// Its first lines, if it is text.
    pub lines: &'a [String],
    /// The command that analyses it.
    pub next_command: &'a str,
}

/// Contents of a file, how it would be read, and the command for it.
pub fn inspect(inspected: &Inspected<'_>, spell: Spelling<'_>) -> String {
    let tables = inspected.tables;
    let mut text = format!("{ANSWER}{}{ANSWER:#}\n", escape::terminal(&inspected.file.display().to_string()));
    text += &labelled("format", &format!("{}; {}", format_name(inspected), size(tables.bytes)));
    for table in tables.tables.iter().take(MOST_TABLES) {
        text += &one_table(table, tables.tables.len() > 1);
    }
    if tables.tables.len() > MOST_TABLES {
        let further = (tables.tables.len() - MOST_TABLES) as u64;
        text += &labelled("", &format!("and {}", reading::counted(further, "further table")));
    }
    if !inspected.lines.is_empty() {
        text.push('\n');
        for line in inspected.lines {
            let _ = writeln!(text, "  {DIM}{}{DIM:#}", clipped(&escape::terminal(line), WIDTH - 2));
        }
    }
    text.push('\n');
    match (inspected.curve, inspected.reading) {
        (Some(curve), _) => {
            text += &super::labelled_facts(&resonance::curve(curve, spell));
            text += &curve_picture(curve);
        }
        (None, Ok(reading)) => {
            text += &super::labelled_facts(&reading::record(reading, spell));
            let record = &reading.record;
            if let Some(swings) = inspected.swings.filter(|_| record.kind().oscillates()) {
                text += &labelled("motion", &motion(swings));
            }
            let points = (0..record.len()).map(|i| (record.time_s(i), record.signal()[i]));
            let ends = [record.time_s(0), record.time_s(record.len() - 1)];
            text += &picture(points, record.unit(), ends, "s");
        }
        (None, Err(error)) => {
            text += &labelled("record", &format!("none: {}", error.problem.spelled(spell)));
            let hints = error.hints();
            if !hints.is_empty() {
                text += &labelled("", &slipfit::answer::hint::spelled(&hints, spell));
            }
        }
    }
    let _ = writeln!(text, "\n> {}", escape::terminal(inspected.next_command));
    text
}

/// Properties of the motion that need no fit.
fn motion(swings: Swings) -> String {
    match (swings.crossings, swings.period_s) {
        (crossings, Some(period)) => {
            format!("{crossings} crossings of the middle, period about {}", plain(period, 2, "s"))
        }
        (0 | 1, None) => "no oscillation is seen about its middle".to_owned(),
        (crossings, None) => format!("{crossings} crossings of the middle: hardly an oscillation"),
    }
}

fn format_name(inspected: &Inspected<'_>) -> String {
    let name = inspected.tables.format.name();
    let name = name.strip_prefix("a ").or_else(|| name.strip_prefix("an ")).unwrap_or(name);
    match &inspected.tables.dialect {
        Some(dialect) => dialect_name(name, dialect),
        None => name.to_owned(),
    }
}

fn dialect_name(name: &str, dialect: &Dialect) -> String {
    let cells = match dialect.delimiter {
        Delimiter::Comma => "commas between cells",
        Delimiter::Semicolon => "semicolons between cells",
        Delimiter::Tab => "tabs between cells",
        Delimiter::Bar => "bars between cells",
        Delimiter::Blanks => "blanks between cells",
        _ => "one cell a row",
    };
    let decimal = if dialect.decimal == slipfit_io::Decimal::Comma { ", decimal comma" } else { "" };
    let writer = dialect.convention.map(|w| format!(" as {w} writes it")).unwrap_or_default();
    format!("{name}{writer}, {cells}{decimal}, {}", dialect.encoding)
}

fn size(bytes: u64) -> String {
    match bytes {
        0..1000 => format!("{bytes} bytes"),
        1000..1_000_000 => format!("{:.1} kB", bytes as f64 / 1e3),
        1_000_000..1_000_000_000 => format!("{:.1} MB", bytes as f64 / 1e6),
        _ => format!("{:.2} GB", bytes as f64 / 1e9),
    }
}

/// The columns of a table with their units, first and last values.
fn one_table(table: &Table, several: bool) -> String {
    let mut rows =
        vec![["#", "column", "unit", "first", "last", "least", "greatest"].map(str::to_owned).to_vec()];
    for (i, column) in table.columns.iter().enumerate().take(MOST_COLUMNS) {
        let finite = || column.values.iter().copied().filter(|v| v.is_finite());
        let number = |v: Option<f64>| v.map_or_else(|| "–".to_owned(), |v| plain(v, 4, ""));
        rows.push(vec![
            (i + 1).to_string(),
            if column.header.is_empty() { "–".to_owned() } else { column.header.clone() },
            clipped(if column.unit.is_empty() { "–" } else { &column.unit }, 8),
            number(finite().next()),
            number(finite().next_back()),
            number(finite().reduce(f64::min)),
            number(finite().reduce(f64::max)),
        ]);
    }
    // Names are shortened before numbers are.
    let full_names: Vec<String> = rows.iter().map(|row| row[1].clone()).collect();
    for most in (6..=24).rev() {
        rows.iter_mut().zip(shortened_distinct(&full_names, most)).for_each(|(row, name)| row[1] = name);
        if width(&rows) <= WIDTH - 4 {
            break;
        }
    }
    let align =
        [Align::Right, Align::Left, Align::Left, Align::Right, Align::Right, Align::Right, Align::Right];
    let first = if table.cut { "first " } else { "" };
    let rate = table.rate_hz.map(|r| format!(", {}", plain(r, 6, "Hz"))).unwrap_or_default();
    let (rows_held, columns_held) = (
        reading::counted(table.rows() as u64, "row"),
        reading::counted(table.columns.len() as u64, "column"),
    );
    let size = format!("{first}{rows_held}, {columns_held}{rate}");
    let title = if several { format!("`{}`: {size}", table.name) } else { size };
    let mut text = labelled("table", &title);
    for (i, line) in columns(&rows, &align).iter().enumerate() {
        let line = clipped(line, WIDTH - 4);
        match i {
            0 => {
                let _ = writeln!(text, "    {HEADING}{line}{HEADING:#}");
            }
            _ => {
                let _ = writeln!(text, "    {line}");
            }
        }
    }
    if table.columns.len() > MOST_COLUMNS {
        let further = (table.columns.len() - MOST_COLUMNS) as u64;
        let _ = writeln!(text, "    and {}", reading::counted(further, "further column"));
    }
    text
}

/// The amplitudes over frequency.
fn curve_picture(reading: &SweepReading) -> String {
    let curve = &reading.curve;
    let hz = curve.frequency_hz();
    let points = hz.iter().enumerate().map(|(i, f)| (*f, curve.response().amplitude(i)));
    let low = hz.iter().copied().fold(f64::INFINITY, f64::min);
    let high = hz.iter().copied().fold(0.0, f64::max);
    picture(points, curve.unit(), [low, high], "Hz")
}

/// Values over their positions between the ends, as a small plot.
fn picture(
    points: impl Iterator<Item = (f64, f64)> + Clone,
    unit: &str,
    ends: [f64; 2],
    ends_unit: &str,
) -> String {
    let Some((lines, [low, high])) = braille::plot(points) else { return String::new() };
    let labels = [high, low].map(|v| escape::terminal(&plain(v, 3, unit)));
    let mut text = String::from("\n");
    for (i, line) in lines.iter().enumerate() {
        let label = match i {
            0 => labels[0].as_str(),
            i if i + 1 == lines.len() => labels[1].as_str(),
            _ => "",
        };
        let _ = writeln!(text, "{:>12} {line}", clipped(label, 12));
    }
    // The ends of a narrow span differ only in their later digits.
    let digits = (ends[1].abs() / (ends[1] - ends[0])).log10().ceil().clamp(0.0, 8.0) as i32 + 3;
    // Seconds since 1970 are not written in powers of ten.
    let label = |v: f64| {
        let counted = ends_unit == "s" && v.abs() >= 1e6;
        if counted { instant(v, ends[1] - ends[0]) } else { plain(v, digits.max(4), ends_unit) }
    };
    let [start, end] = ends.map(label);
    let blanks = 66_usize.saturating_sub(start.chars().count() + end.chars().count());
    let _ = writeln!(text, "{:13}{start}{:blanks$}{end}", "", "");
    text
}

/// Names shortened to at most `most` characters; names that begin alike keep their ends as well.
fn shortened_distinct(names: &[String], most: usize) -> Vec<String> {
    let short: Vec<String> = names.iter().map(|name| clipped(name, most)).collect();
    let alike = |i: usize| (0..names.len()).any(|k| k != i && short[k] == short[i] && names[k] != names[i]);
    let inner = |name: &str| {
        let from_end = most / 2;
        let (from_start, all) = (most - from_end - 1, name.chars().count());
        let (start, end) = (name.chars().take(from_start), name.chars().skip(all - from_end));
        start.chain(['…']).chain(end).collect::<String>()
    };
    (0..names.len()).map(|i| if alike(i) { inner(&names[i]) } else { short[i].clone() }).collect()
}

/// Text shortened to at most `most` characters.
fn clipped(text: &str, most: usize) -> String {
    if text.chars().count() <= most {
        return text.to_owned();
    }
    let mut short: String = text.chars().take(most.saturating_sub(1)).collect();
    short.push('…');
    short
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn names_that_begin_alike_keep_their_ends() {
        let names = ["t", "Rate of turn of the phone x (rad/s)", "Rate of turn of the phone y (rad/s)"];
        let names = names.map(str::to_owned);
        let short = shortened_distinct(&names, 24);
        assert_eq!(
            short,
            ["t", "Rate of tur…ne x (rad/s)", "Rate of tur…ne y (rad/s)"].map(|n| n.to_owned())
        );
        assert!(short.iter().all(|name| name.chars().count() <= 24));
    }
}
