//! A single signal whose values are distributed over several columns, as in earthquake records:
//! `NPTS= 4001, DT= .01 SEC` above five values per line.

use super::{
    layout::{Layout, text},
    part::Part,
};
use crate::{
    columns::{name::Name, role::Role, stated, units},
    report::{Decimal, Note},
    tables::table::Irregularity,
};

/// Relative tolerance of the number of rows estimated from the size of a file.
const WITHIN: f64 = 0.05;

/// A signal that continues from column to column and from line to line.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct Wrapped {
    /// Number of values per line.
    pub(super) width: usize,
    /// Total number of values, as stated in the header.
    pub(super) count: usize,
}

impl Wrapped {
    /// The signal of a table without names, below lines that state the number of values.
    pub(super) fn find(lines: &[&[u8]], layout: &Layout) -> Option<Self> {
        let width = layout.shape.width;
        // Cells of a line that states the count are not names.
        let stated = |line: usize| lines.get(line).is_some_and(|line| count(&text(line)).is_some());
        if width < 2 || layout.shape.words || !layout.header_line.is_none_or(stated) {
            return None;
        }
        let above = || lines[..layout.first_line.min(lines.len())].iter();
        let count = above().find_map(|line| count(&text(line)))?;
        (count > width).then_some(Self { width, count })
    }

    /// The columns of all values of a line.
    pub(super) fn all(self) -> Vec<usize> {
        (0..self.width).collect()
    }

    /// Whether these rows contain as many values as the header states, counted with or without missing ones.
    pub(super) fn fits(self, rows: Part) -> bool {
        let values = self.joined(rows).columns.concat();
        let finite = values.iter().filter(|value| value.is_finite()).count();
        [finite, values.len()].iter().any(|n| (self.count..self.count + self.width).contains(n))
    }

    /// Whether this approximate number of rows can contain the values that the header states.
    pub(super) fn fits_about(self, rows: usize) -> bool {
        (rows as f64 * self.width as f64 / self.count as f64 - 1.0).abs() < WITHIN
    }

    /// Rows of several columns as one: if a row ends before the last column, the next row follows directly.
    pub(super) fn joined(self, part: Part) -> Part {
        let mut values = Vec::new();
        let mut found: Vec<Irregularity> = Vec::new();
        let mut irregularities = part.irregularities.into_iter().peekable();
        let rows = part.columns.first().map_or(0, Vec::len);
        for row in 0..=rows {
            let mut reason = None;
            while let Some(next) = irregularities.next_if(|irregularity| irregularity.row == row) {
                if next.reason.is_no_row() {
                    found.push(Irregularity { row: values.len(), reason: next.reason });
                } else {
                    reason = Some(next.reason);
                }
            }
            if row == rows {
                break;
            }
            let cells: Vec<f64> = part.columns.iter().map(|column| column[row]).collect();
            let filled = cells.iter().rposition(|value| value.is_finite()).map_or(0, |last| last + 1);
            if filled == 0 {
                found.extend(reason.map(|reason| Irregularity { row: values.len(), reason }));
                values.push(f64::NAN);
            } else if let Some(gap) = cells[..filled].iter().position(|value| !value.is_finite()) {
                found.extend(reason.map(|reason| Irregularity { row: values.len() + gap, reason }));
            }
            values.extend_from_slice(&cells[..filled]);
        }
        Part { columns: vec![values], irregularities: found, lines: part.lines }
    }

    /// Describes the single column that replaces those of the lines.
    pub(super) fn describe(self, lines: &[&[u8]], layout: &mut Layout) {
        let above: Vec<String> =
            lines[..layout.first_line.min(lines.len())].iter().map(|line| text(line).into_owned()).collect();
        let head = &mut layout.head;
        let name = above.iter().find_map(|line| quantity(line)).unwrap_or_default();
        let unit = above.iter().rev().find_map(|line| unit(line)).unwrap_or_default();
        let written = if unit.is_empty() { name.to_owned() } else { format!("{name} ({unit})") };
        head.names = vec![Name::parse(written.trim())];
        head.stated_rate_hz = head.stated_rate_hz.or_else(|| above.iter().find_map(|line| rate_hz(line)));
        // Removes the note that the lines above the values name no columns.
        head.notes.clear();
        head.notes.push(Note::new(format!(
            "the {} values that the header states stand in {} columns: they were read line by line as one \
             signal",
            self.count, self.width
        )));
    }
}

/// Words and numbers of a line, separated by marks.
fn tokens(line: &str) -> Vec<&str> {
    let marks = |c: char| c.is_whitespace() || ",;=:()".contains(c);
    line.split(marks).filter(|token| !token.is_empty()).collect()
}

/// The number of values that a line states: `NPTS= 4001`, `4001 points`, `4001 samples`.
fn count(line: &str) -> Option<usize> {
    let tokens = tokens(line);
    tokens.windows(2).find_map(|pair| {
        let is = |word: &str, list: &[&str]| list.iter().any(|known| word.eq_ignore_ascii_case(known));
        if is(pair[0], &["npts", "npoints", "nsamples", "nvalues"]) {
            pair[1].parse().ok()
        } else if is(pair[1], &["points", "samples", "values", "pts"]) {
            pair[0].parse().ok()
        } else {
            None
        }
    })
}

/// The rate stated in a sentence of a line: `100 sps`, `equally spaced at .010 sec`.
fn rate_hz(line: &str) -> Option<f64> {
    let tokens = tokens(line);
    let of = |statement: String| stated::rate_hz([statement.as_str()].into_iter(), &[','], Decimal::Point);
    tokens
        .windows(2)
        .find_map(|pair| match pair {
            [rate, unit] if unit.eq_ignore_ascii_case("sps") => of(format!("Sample rate={rate} sps")),
            _ => None,
        })
        .or_else(|| {
            tokens.windows(4).find_map(|words| match words {
                [spaced, at, step, unit] if *spaced == "spaced" && matches!(*at, "at" | "by") => {
                    of(format!("Sample interval={step} {unit}"))
                }
                _ => None,
            })
        })
}

/// The unit named in a line: after `in` or `units of`, or at the end of the line of a seismic archive.
fn unit(line: &str) -> Option<String> {
    let known = |unit: &&str| {
        units::is_known(unit) && Role::in_record(&Name::parse(&format!("x ({unit})"))) != Role::Time
    };
    let lower = line.to_lowercase();
    let behind = ["units of ", ", in ", "in units ", "units: "].iter().find_map(|mark| {
        let at = lower.find(mark)? + mark.len();
        line.get(at..)?.split([' ', ',', ';', '(']).next()
    });
    let behind = behind.map(|unit| unit.trim_end_matches('.')).filter(known);
    let last =
        || line.rsplit(',').next().map(str::trim).filter(|_| line.starts_with("TIMESERIES")).filter(known);
    behind.or_else(last).map(str::to_owned)
}

/// Kind of the values according to a line.
fn quantity(line: &str) -> Option<&'static str> {
    let lower = line.to_lowercase();
    [("accel", "acceleration"), ("veloc", "velocity"), ("displ", "displacement")]
        .into_iter()
        .find_map(|(part, word)| lower.contains(part).then_some(word))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn counts_rates_and_units_are_found_in_sentences() {
        let peer = "NPTS=   4001, DT=   .0100 SEC,";
        let csmip =
            "Roof Chan 3, 4001 points of accel data equally spaced at .010 sec, in cm/sec2.  (8f10.3)";
        let slist =
            "TIMESERIES AM_R1_00_ENN_D, 4001 samples, 100 sps, 2024-03-12T10:22:33.0, SLIST, INTEGER, Counts";
        assert_eq!([peer, csmip, slist].map(count), [Some(4001); 3]);
        for line in [csmip, slist] {
            assert!((rate_hz(line).unwrap() - 100.0).abs() < 1e-9, "{line}");
        }
        let of_g = "ACCELERATION TIME SERIES IN UNITS OF G";
        let found = [of_g, csmip, slist].map(|line| unit(line).unwrap_or_default());
        assert_eq!(found, ["G", "cm/sec2", "Counts"]);
        assert_eq!([of_g, csmip, slist].map(quantity), [Some("acceleration"), Some("acceleration"), None]);
        for line in ["", "points", "12 points a cycle? no: points", "NPTS= many", "DT = 4001"] {
            assert!(count(line).is_none_or(|n| n == 12), "{line}");
        }
    }
}
