//! Conversion of cells to numbers.

use super::stamp;
use crate::report::Decimal;

/// Content of a cell.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) enum Cell {
    /// A finite number.
    Number(f64),
    /// Nothing, or a word for a missing value: NaN, `-`, infinity, overflow.
    Missing,
    /// Anything else.
    Text,
}

/// The longest number read with a decimal comma.
const LONGEST: usize = 64;

/// The longest word for a missing value, in characters.
const LONGEST_WORD: usize = 9;

/// Words for a missing value, in lower case.
const MISSING: &[&str] = &[
    "-",
    "--",
    "---",
    "*",
    "?",
    "nan",
    "-nan",
    "+nan",
    "nan(ind)",
    "-nan(ind)",
    "1.#qnan",
    "-1.#ind",
    "na",
    "n/a",
    "#n/a",
    "#na",
    "#nv",
    "#value!",
    "#div/0!",
    "null",
    "none",
    "nil",
    "inf",
    "+inf",
    "-inf",
    "infinity",
    "-infinity",
    "∞",
    "-∞",
    "overflow",
    "overload",
    "overld",
    "ovld",
    "ovl",
    "ol",
    "o.l.",
    "undefined",
    "missing",
    "undef",
];

/// The cell without surrounding blanks and quotes.
pub(super) fn trim(cell: &[u8]) -> &[u8] {
    let cell = cell.trim_ascii();
    // A no-break space is two bytes in UTF-8.
    let cell = cell.strip_prefix(b"\xc2\xa0").unwrap_or(cell);
    match cell {
        [b'"', inner @ .., b'"'] | [b'\'', inner @ .., b'\''] => inner.trim_ascii(),
        _ => cell,
    }
}

/// Reads a cell; dates are counted from 1970.
pub(super) fn cell(bytes: &[u8], decimal: Decimal) -> Cell {
    cell_since(bytes, decimal, 0)
}

/// Reads a cell; dates are counted from the midnight before `day`, which is itself counted from 1970.
pub(super) fn cell_since(bytes: &[u8], decimal: Decimal, day: i64) -> Cell {
    let bytes = trim(bytes);
    if bytes.is_empty() {
        return Cell::Missing;
    }
    match number(bytes, decimal) {
        Some(value) if value.is_finite() => Cell::Number(value),
        Some(_) => Cell::Missing,
        None => unusual_cell(bytes, decimal, day),
    }
}

/// A number that spans all the bytes.
pub(super) fn number(bytes: &[u8], decimal: Decimal) -> Option<f64> {
    match decimal {
        Decimal::Point => fast_float2::parse(bytes).ok(),
        Decimal::Comma => {
            let mut copy = [0_u8; LONGEST];
            let copy = copy.get_mut(..bytes.len())?;
            for (to, &from) in copy.iter_mut().zip(bytes) {
                *to = match from {
                    b',' => b'.',
                    b'.' => return None,
                    other => other,
                };
            }
            fast_float2::parse(&*copy).ok()
        }
    }
}

/// Numbers in typographic or Fortran notation, and words for a missing value.
#[cold]
fn unusual_cell(bytes: &[u8], decimal: Decimal, day: i64) -> Cell {
    if bytes.len() > LONGEST {
        return Cell::Text;
    }
    let Ok(text) = std::str::from_utf8(bytes) else { return Cell::Text };
    if text.chars().count() <= LONGEST_WORD && MISSING.contains(&text.to_lowercase().as_str()) {
        return Cell::Missing;
    }
    let typeset = typeset(text);
    let plain = typeset.as_deref().unwrap_or(text);
    let value =
        typeset.as_ref().and_then(|plain| number(plain.as_bytes(), decimal)).filter(|v| v.is_finite());
    let value = value.or_else(|| ungrouped(plain, decimal));
    match value.or_else(|| stamp::read(text).map(|stamp| stamp.since(day))) {
        Some(value) => Cell::Number(value),
        None => Cell::Text,
    }
}

/// A number with the typographic minus (U+2212) or the Fortran exponent (D), converted to program notation.
fn typeset(text: &str) -> Option<String> {
    // The first byte of that minus in UTF-8 is E2.
    if !text.bytes().any(|byte| matches!(byte, b'd' | b'D' | 0xe2)) {
        return None;
    }
    let plain = text.replace('\u{2212}', "-");
    let begins = plain.starts_with(|c: char| c.is_ascii_digit() || "+-.,".contains(c));
    Some(if begins { plain.replace(['d', 'D'], "e") } else { plain })
}

/// A number with grouped thousands: `1,234.5`, `1.234,5`, `1 234,5`, `1'234.5`. A single comma or point before three
/// digits is a decimal mark, unless the other mark is that of the table.
fn ungrouped(text: &str, decimal: Decimal) -> Option<f64> {
    let (mark, group) = match decimal {
        Decimal::Point => ('.', ','),
        Decimal::Comma => (',', '.'),
    };
    let unsigned = text.trim_start_matches(['+', '-']);
    let (whole, fraction) = match unsigned.split_once(mark) {
        Some((whole, fraction)) => (whole, Some(fraction)),
        None => (unsigned, None),
    };
    let separator = whole.chars().find(|c| !c.is_ascii_digit())?;
    let known = separator == group
        || matches!(separator, ' ' | '\'' | '\u{2019}' | '\u{a0}' | '\u{202f}' | '\u{2009}');
    let first = whole.split(separator).next()?;
    if !known || !(1..=3).contains(&first.len()) || first.starts_with('0') {
        return None;
    }
    let mut others = whole.split(separator).skip(1);
    let clear = separator != group || fraction.is_some() || others.clone().nth(1).is_some();
    if !clear || !others.all(|part| part.len() == 3 && part.bytes().all(|b| b.is_ascii_digit())) {
        return None;
    }
    let sign = if text.starts_with('-') { "-" } else { "" };
    let plain = format!("{sign}{}.{}", whole.replace(separator, ""), fraction.unwrap_or("0"));
    plain.parse().ok().filter(|v: &f64| v.is_finite())
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn numbers_in_any_dress_are_read() {
        for (text, decimal, value) in [
            ("1.5", Decimal::Point, 1.5),
            (" \"1,5\" ", Decimal::Comma, 1.5),
            ("+2", Decimal::Point, 2.0),
            ("-,5", Decimal::Comma, -0.5),
            ("1.0D-3", Decimal::Point, 1e-3),
            ("\u{2212}3,25E+01", Decimal::Comma, -32.5),
            ("\u{2212}1,234.5", Decimal::Point, -1234.5),
            ("\u{a0}7", Decimal::Point, 7.0),
            (".5", Decimal::Point, 0.5),
            ("5.", Decimal::Point, 5.0),
        ] {
            assert_eq!(cell(text.as_bytes(), decimal), Cell::Number(value), "{text}");
        }
    }

    #[test]
    fn thousands_set_apart_are_read() {
        for (text, decimal, value) in [
            ("1,234.5", Decimal::Point, 1234.5),
            ("-12,345,678", Decimal::Point, -12_345_678.0),
            ("1.234,5", Decimal::Comma, 1234.5),
            ("1.234.567", Decimal::Comma, 1_234_567.0),
            ("1 234,5", Decimal::Comma, 1234.5),
            ("1\u{202f}234,5", Decimal::Comma, 1234.5),
            ("1\u{a0}234.5", Decimal::Point, 1234.5),
            ("1'234.5e3", Decimal::Point, 1_234_500.0),
            ("2\u{2019}345", Decimal::Point, 2345.0),
        ] {
            assert_eq!(cell(text.as_bytes(), decimal), Cell::Number(value), "{text}");
        }
        // A mark that could be a decimal mark is one, and groups have three digits.
        for (text, decimal) in [
            ("1,234", Decimal::Point),
            ("1.234", Decimal::Comma),
            ("0,123.4", Decimal::Point),
            ("12,34.5", Decimal::Point),
            ("1234,567.8", Decimal::Point),
            ("1,234 567.0", Decimal::Point),
        ] {
            assert_eq!(cell(text.as_bytes(), decimal), Cell::Text, "{text}");
        }
    }

    #[test]
    fn words_for_nothing_are_missing_and_other_words_are_text() {
        assert_eq!(MISSING.iter().map(|word| word.chars().count()).max(), Some(LONGEST_WORD));
        for text in ["", "  ", "NaN", "-nan(ind)", "inf", "#N/A", "--", "1e999", "∞"] {
            assert_eq!(cell(text.as_bytes(), Decimal::Point), Cell::Missing, "{text}");
        }
        for text in ["a", "1.5 V", "1,5", "12:30", "0x1f", "1e", "1_000", "dd"] {
            assert_eq!(cell(text.as_bytes(), Decimal::Point), Cell::Text, "{text}");
        }
        assert_eq!(cell(b"1.5", Decimal::Comma), Cell::Text);
    }
}
