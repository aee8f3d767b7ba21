//! Numbers annotated with a unit, an error or an imaginary part: `12.73 nm`, `12.73 ± 0.50`, `9.98-7.90j`.
//!
//! A text with such cells is split line by line before it is read: units are moved to the headers, errors and imaginary
//! parts to separate columns.

use std::borrow::Cow;

use super::{
    dialect,
    layout::text,
    number::{self, Cell},
};
use crate::{
    columns::{name::Name, units},
    report::{Decimal, Delimiter, Note},
};

/// Number of lines examined.
const FIRST: usize = 150;
/// Minimum number of rows of a table of annotated cells.
const FEWEST: usize = 3;

/// Second number of a cell.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
enum Second {
    Error,
    Imaginary,
}

/// The parts of a cell.
#[derive(Debug, PartialEq)]
struct AnnotatedNumber {
    value: f64,
    second: Option<(Second, f64)>,
    unit: String,
}

/// Content of the cells of a column.
#[derive(Debug, Clone, Default, PartialEq)]
struct Column {
    second: Option<Second>,
    unit: String,
}

impl Column {
    fn is_plain(&self) -> bool {
        self.second.is_none() && self.unit.is_empty()
    }
}

/// How the cells of a text are annotated.
#[derive(Debug, Clone, PartialEq)]
pub(super) struct Annotations {
    delimiter: Delimiter,
    decimal: Decimal,
    columns: Vec<Column>,
    /// Index of the header line.
    header: Option<usize>,
}

/// Delimiters and decimal marks of tables whose cells may contain blanks.
fn ways() -> impl Iterator<Item = (Delimiter, Decimal)> {
    let quoted = (Delimiter::Comma, Decimal::Comma);
    dialect::CANDIDATES.iter().copied().filter(move |way| way.0 != Delimiter::Blanks && *way != quoted)
}

impl Annotations {
    /// Annotation of most of the first lines, if there is one.
    pub(super) fn find(lines: &[&[u8]]) -> Option<Self> {
        let first = &lines[..lines.len().min(FIRST)];
        let filled = first.iter().filter(|line| !line.trim_ascii().is_empty()).count();
        let best = ways()
            .map(|way| rows(first, way))
            .reduce(|held, other| if other.len() > held.len() { other } else { held })?;
        if best.len() < FEWEST || best.len() * 2 <= filled {
            return None;
        }
        let (delimiter, decimal) = ways().find(|way| rows(first, *way).len() == best.len())?;
        let mut columns = vec![Column::default(); best.first()?.1.len()];
        for (i, column) in columns.iter_mut().enumerate() {
            let cells = || best.iter().filter_map(|(_, cells)| cells[i].as_ref());
            let of = |second: Second| cells().filter(|c| c.second.is_some_and(|(s, _)| s == second)).count();
            let most = [Second::Error, Second::Imaginary].into_iter().max_by_key(|second| of(*second));
            column.second = most.filter(|second| of(*second) > 0);
            column.unit = cells().find(|c| !c.unit.is_empty()).map(|c| c.unit.clone()).unwrap_or_default();
        }
        let header = (0..best.first()?.0).rev().find(|&i| {
            let cells = dialect::cells(first[i], delimiter);
            let named = |cell: &&[u8]| {
                number::cell(cell, decimal) == Cell::Text && annotated_number(cell, decimal).is_none()
            };
            !dialect::is_comment(first[i]) && cells.len() == columns.len() && cells.iter().any(named)
        });
        // Numbers are converted to the unit of their header.
        let names = header.map(|i| dialect::cells(first[i], delimiter)).unwrap_or_default();
        for (column, name) in columns.iter_mut().zip(names).filter(|(column, _)| !column.unit.is_empty()) {
            let unit = Name::parse(&text(number::trim(name))).unit;
            if !unit.is_empty() {
                units::ratio(&column.unit, &unit)?;
                column.unit = unit;
            }
        }
        Some(Self { delimiter, decimal, columns, header })
    }

    /// The first lines of the text, split into parts.
    pub(super) fn head(&self, lines: &[&[u8]]) -> Vec<Vec<u8>> {
        let line = |(i, line): (usize, &&[u8])| {
            let mut out = Vec::with_capacity(line.len());
            if self.header == Some(i) {
                self.header(line, &mut out)
            } else {
                self.line(line, &mut out)
            }
            out
        };
        lines.iter().enumerate().map(line).collect()
    }

    /// Whole lines below the header, split into parts.
    pub(super) fn rows(&self, bytes: &[u8], newline: u8) -> Vec<u8> {
        let mut out = Vec::with_capacity(bytes.len());
        for line in bytes.split_inclusive(|b| *b == newline) {
            let end = line.len() - usize::from(line.last() == Some(&newline));
            self.line(&line[..end], &mut out);
            out.extend_from_slice(&line[end..]);
        }
        out
    }

    /// Names of the columns if no line states them.
    pub(super) fn names(&self) -> Vec<Name> {
        let column = |column: &Column| {
            let name =
                |header: &str| Name { header: header.to_owned(), bare: header.to_owned(), ..Name::default() };
            let mut names = match column.second {
                Some(Second::Imaginary) => vec![name("Re"), name("Im")],
                Some(Second::Error) => vec![Name::default(), name("std error")],
                None => vec![Name::default()],
            };
            names.iter_mut().for_each(|name| name.unit.clone_from(&column.unit));
            names
        };
        self.columns.iter().flat_map(column).collect()
    }

    /// Note on the conversion.
    pub(super) fn note(&self) -> Note {
        let mut number = 0;
        let column = |column: &Column| {
            number += 1;
            let unit = if column.unit.is_empty() { String::new() } else { format!(" in {}", column.unit) };
            let beside = match column.second {
                Some(Second::Error) => "standard errors",
                Some(Second::Imaginary) => "imaginary parts",
                None => return (!unit.is_empty()).then(|| format!("column {number}{unit}")),
            };
            number += 1;
            Some(format!("column {}{unit}, its {beside} as column {number}", number - 1))
        };
        let said: Vec<String> = self.columns.iter().filter_map(column).collect();
        Note::new(format!("cells hold more than numbers and were taken apart: {}", said.join("; ")))
    }

    fn line(&self, line: &[u8], out: &mut Vec<u8>) {
        if dialect::is_comment(line) || line.trim_ascii().is_empty() {
            return out.extend_from_slice(line);
        }
        let separator = dialect::separator(self.delimiter).unwrap_or(b',');
        for (i, cell) in dialect::cells(line, self.delimiter).into_iter().enumerate() {
            if i > 0 {
                out.push(separator);
            }
            let Some(column) = self.columns.get(i).filter(|c| !c.is_plain()) else {
                out.extend_from_slice(cell);
                continue;
            };
            let taken = annotated_number(cell, self.decimal).and_then(|annotated| {
                let bare = annotated.unit.is_empty();
                let factor = if bare { Some(1.0) } else { units::ratio(&annotated.unit, &column.unit) };
                Some((annotated, factor?))
            });
            let Some((annotated, factor)) = taken else {
                out.extend_from_slice(cell);
                if column.second.is_some() {
                    out.push(separator);
                }
                continue;
            };
            self.number(annotated.value * factor, out);
            if let Some(wanted) = column.second {
                out.push(separator);
                match annotated.second {
                    Some((second, value)) if second == wanted => self.number(value * factor, out),
                    // A real number in a column of complex ones.
                    _ if wanted == Second::Imaginary => out.push(b'0'),
                    _ => {}
                }
            }
        }
    }

    fn number(&self, value: f64, out: &mut Vec<u8>) {
        let written = format!("{value:e}");
        let written = if self.decimal == Decimal::Comma { written.replace('.', ",") } else { written };
        out.extend_from_slice(written.as_bytes());
    }

    fn header(&self, line: &[u8], out: &mut Vec<u8>) {
        let separator = char::from(dialect::separator(self.delimiter).unwrap_or(b','));
        let mut names: Vec<String> = Vec::new();
        for (cell, column) in dialect::cells(line, self.delimiter).into_iter().zip(&self.columns) {
            let name = text(number::trim(cell)).replace(separator, " ");
            let unitless = Name::parse(&name).unit.is_empty() && !column.unit.is_empty();
            let in_unit =
                |name: &str| if unitless { format!("{name} ({})", column.unit) } else { name.to_owned() };
            match column.second {
                None => names.push(in_unit(&name)),
                Some(Second::Error) => {
                    let bare = Name::parse(&name).bare;
                    names.extend([in_unit(&name), in_unit(&format!("{bare} std error"))]);
                }
                Some(Second::Imaginary) => {
                    names.extend(["Re", "Im"].map(|part| in_unit(&format!("{part} {name}"))));
                }
            }
        }
        out.extend_from_slice(names.join(&separator.to_string()).as_bytes());
    }
}

/// The rows of the most common width whose cells are numbers or annotated numbers, with at least one of the latter;
/// `None` for a missing cell.
fn rows(
    lines: &[&[u8]],
    (delimiter, decimal): (Delimiter, Decimal),
) -> Vec<(usize, Vec<Option<AnnotatedNumber>>)> {
    let row = |(i, line): (usize, &&[u8])| {
        if line.trim_ascii().is_empty() || dialect::is_comment(line) {
            return None;
        }
        let mut any = false;
        let mut cells = Vec::new();
        for cell in dialect::cells(line, delimiter) {
            cells.push(match number::cell(cell, decimal) {
                Cell::Missing => None,
                Cell::Number(value) => Some(AnnotatedNumber { value, second: None, unit: String::new() }),
                Cell::Text => {
                    any = true;
                    Some(annotated_number(cell, decimal)?)
                }
            });
        }
        (any && cells.len() > 1).then_some((i, cells))
    };
    let mut rows: Vec<(usize, Vec<Option<AnnotatedNumber>>)> =
        lines.iter().enumerate().filter_map(row).collect();
    let width = rows.first().map_or(0, |(_, cells)| cells.len());
    rows.retain(|(_, cells)| cells.len() == width);
    rows
}

/// Splits a cell; `None` for anything but a number with a known unit, an error or an imaginary part.
fn annotated_number(cell: &[u8], decimal: Decimal) -> Option<AnnotatedNumber> {
    /// The longest cell examined.
    const LONGEST: usize = 80;
    let cell = text(number::trim(cell));
    if cell.len() > LONGEST {
        return None;
    }
    let cell: Cow<'_, str> =
        if cell.contains('\u{2212}') { cell.replace('\u{2212}', "-").into() } else { cell };
    let (inner, bracket) = match cell.strip_prefix('(') {
        Some(inner) => (inner, true),
        None => (&*cell, false),
    };
    let (value, rest) = number_before(inner, decimal)?;
    let written = &inner[..inner.len() - rest.len()];
    let (second, rest) = second(value, written, rest.trim_start(), decimal)?;
    let rest = rest.trim();
    let unit = if bracket { rest.strip_prefix(')')?.trim() } else { rest };
    let known = unit.is_empty() || is_unit(unit);
    known.then(|| AnnotatedNumber { value, second, unit: unit.to_owned() })
}

/// The error or imaginary part after a number, if there is one, and the remaining text.
fn second<'a>(
    value: f64,
    written: &str,
    rest: &'a str,
    decimal: Decimal,
) -> Option<(Option<(Second, f64)>, &'a str)> {
    let imaginary = |rest: &'a str| rest.strip_prefix(['i', 'j']);
    if let Some(behind) = ["\u{b1}", "+/-", "+-"].iter().find_map(|sign| rest.strip_prefix(sign)) {
        let (size, behind) = number_before(behind, decimal)?;
        // Some programs write a plus before the sign of an imaginary part.
        if let Some(behind) = imaginary(behind).filter(|_| rest.starts_with("+-")) {
            return Some((Some((Second::Imaginary, -size)), behind));
        }
        let behind = behind.trim_start();
        return Some(match behind.strip_prefix('%') {
            Some(behind) => (Some((Second::Error, (value * size / 100.0).abs())), behind),
            None => (Some((Second::Error, size.abs())), behind),
        });
    }
    if let Some(behind) = rest.strip_prefix(['+', '-']) {
        let sign = if rest.starts_with('-') { -1.0 } else { 1.0 };
        let behind = behind.trim_start();
        // `+i7.9`
        if let Some((size, behind)) = imaginary(behind).and_then(|behind| number_before(behind, decimal)) {
            return Some((Some((Second::Imaginary, sign * size)), behind));
        }
        let (size, behind) = number_before(behind, decimal)?;
        return Some((Some((Second::Imaginary, sign * size)), imaginary(behind.trim_start_matches('*'))?));
    }
    // Digits in parentheses are in units of the last digit of the value.
    if let Some((digits, behind)) = rest.strip_prefix('(').and_then(|rest| rest.split_once(')'))
        && !digits.is_empty()
        && digits.bytes().all(|b| b.is_ascii_digit())
    {
        let mark = if decimal == Decimal::Comma { ',' } else { '.' };
        let decimals = written.trim().split_once(mark).map_or(0, |(_, fraction)| fraction.len());
        let size = digits.parse::<f64>().ok()? * 10f64.powi(-i32::try_from(decimals).ok()?);
        return Some((Some((Second::Error, size)), behind));
    }
    Some((None, rest))
}

/// A finite number at the beginning of a text, and the remaining text.
fn number_before(text: &str, decimal: Decimal) -> Option<(f64, &str)> {
    let text = text.trim_start();
    let (value, used) = match decimal {
        Decimal::Point => fast_float2::parse_partial::<f64, _>(text).ok()?,
        Decimal::Comma => fast_float2::parse_partial(text.replace('.', " ").replace(',', ".")).ok()?,
    };
    let starts =
        text.trim_start_matches(['+', '-']).starts_with(|c: char| c.is_ascii_digit() || ".,".contains(c));
    (starts && value.is_finite()).then(|| (value, &text[used..]))
}

fn is_unit(text: &str) -> bool {
    let factors = [units::hertz, units::radians, units::siemens, units::ohms];
    text.starts_with(|c: char| !c.is_ascii_digit())
        && (units::measures(text).is_some() || factors.iter().any(|known| known(text).is_some()))
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    fn annotated(cell: &str, decimal: Decimal) -> Option<AnnotatedNumber> {
        annotated_number(cell.as_bytes(), decimal)
    }

    #[test]
    fn cells_are_taken_apart() {
        use Second::{Error, Imaginary};
        for (cell, value, second, unit) in [
            ("97.000 Hz", 97.0, None, "Hz"),
            ("-38.4\u{b0}", -38.4, None, "\u{b0}"),
            ("1.5V", 1.5, None, "V"),
            ("12.73 \u{b1} 0.50", 12.73, Some((Error, 0.5)), ""),
            ("12.73 +/- 0.50 nm", 12.73, Some((Error, 0.5)), "nm"),
            ("(12.73 \u{b1} 0.50) nm", 12.73, Some((Error, 0.5)), "nm"),
            ("200 \u{b1} 1 %", 200.0, Some((Error, 2.0)), ""),
            ("12.73(50) nm", 12.73, Some((Error, 0.5)), "nm"),
            ("9.97779-7.89956j", 9.97779, Some((Imaginary, -7.89956)), ""),
            ("(9.97+7.9j)", 9.97, Some((Imaginary, 7.9)), ""),
            ("9.97 + 7.9i", 9.97, Some((Imaginary, 7.9)), ""),
            ("9.97 - i7.9", 9.97, Some((Imaginary, -7.9)), ""),
            ("1e-3+-2e-3j", 1e-3, Some((Imaginary, -2e-3)), ""),
            ("\u{2212}1.5e3 mV", -1500.0, None, "mV"),
        ] {
            let found = annotated(cell, Decimal::Point).unwrap_or_else(|| panic!("{cell}"));
            assert_eq!((found.value, found.unit.as_str()), (value, unit), "{cell}");
            assert_eq!(found.second.map(|s| s.0), second.map(|s: (Second, f64)| s.0), "{cell}");
            let [found, wanted] = [found.second, second].map(|s| s.map_or(0.0, |s| s.1));
            // Percentages and last digits are products.
            assert!((found - wanted).abs() < 1e-12, "{cell}: {found}");
        }
        let comma = AnnotatedNumber { value: 12.73, second: Some((Error, 0.5)), unit: "mm".into() };
        assert_eq!(annotated("12,73 \u{b1} 0,5 mm", Decimal::Comma), Some(comma));
        for cell in [
            "12 horses",
            "12:30",
            "2024-05-01",
            "Hz",
            "0x1f",
            "1.5 V 2",
            "(1.5 V",
            "nan",
            "1,5 V",
            "+",
            "1-2",
        ] {
            assert_eq!(annotated(cell, Decimal::Point), None, "{cell}");
        }
    }

    #[test]
    fn lines_become_plain_numbers() {
        let lines: [&[u8]; 5] = [b"f,A", b"1 kHz,2 nm", b"1.1 kHz,3000 pm", b"# remark", b"1200 Hz,n/a"];
        let annotations = Annotations::find(&lines).unwrap();
        let head: Vec<String> =
            annotations.head(&lines).into_iter().map(|l| String::from_utf8(l).unwrap()).collect();
        assert_eq!(head, ["f (kHz),A (nm)", "1e0,2e0", "1.1e0,3e0", "# remark", "1.2e0,n/a"]);
        // The numbers are converted to the unit in the header.
        let lines: [&[u8]; 4] =
            [b"f (kHz),A (nm)", b"970 Hz,12 pm", b"980 Hz,20 \xc2\xb1 1 pm", b"1 kHz,20 pm"];
        let head: Vec<String> = Annotations::find(&lines)
            .unwrap()
            .head(&lines)
            .into_iter()
            .map(|l| String::from_utf8(l).unwrap())
            .collect();
        assert_eq!(head[1..3], ["9.7e-1,1.2e-2,", "9.8e-1,2e-2,1e-3"]);
        let other: [&[u8]; 4] = [b"f (kHz),A (nm)", b"970 s,12 pm", b"980 s,13 pm", b"990 s,13 pm"];
        assert_eq!(Annotations::find(&other), None);
        let plain: [&[u8]; 4] = [b"f,A", b"1,2", b"2,3", b"3,4"];
        assert_eq!(Annotations::find(&plain), None);
    }

    proptest! {
        #[test]
        fn any_lines_are_taken_apart_or_left(
            lines in prop::collection::vec("[0-9a-zA-Z.,;()+ij \u{b1}\u{b0}-]{0,24}", 0..12),
        ) {
            let lines: Vec<&[u8]> = lines.iter().map(String::as_bytes).collect();
            if let Some(annotations) = Annotations::find(&lines) {
                prop_assert_eq!(annotations.head(&lines).len(), lines.len());
                prop_assert!(annotations.names().len() >= 2);
            }
        }
    }
}
