//! Excel workbooks (.xlsx): sheets as XML in an archive.

use std::collections::HashMap;

use quick_xml::events::Event;

use super::package::{attribute, character, events_while};

use crate::{
    error::ReadProblem,
    format::Format,
    tables::sheet::{self, Cell, Sheet},
    tables::table::LoadedTables,
    tables::unpack::Archive,
};

/// Maximum number of rows and columns in Excel.
const MOST_ROWS: u32 = 1 << 20;
const MOST_COLUMNS: u32 = 1 << 14;
/// Days from Excel's origin to 1970, and from the 1904 origin of its first Macintosh version.
const BEFORE_1970: f64 = 25_569.0;
const FROM_1904: f64 = 24_107.0;

/// Reads every sheet, cell by cell, up to `most_cells` cells each.
pub(crate) fn tables(archive: &mut Archive, most_cells: usize) -> Result<LoadedTables, ReadProblem> {
    let strings = strings(archive)?;
    let dates = date_styles(archive)?;
    let before_1970 = before_1970(archive)?;
    let mut sheets = Vec::new();
    for (name, part) in parts(archive)? {
        let mut sheet = Sheet::new(&name);
        // Charts have separate parts; a missing part is an empty sheet.
        if archive.index_for_name(&part).is_some() {
            cells(
                archive,
                &part,
                &SheetContext { strings: &strings, dates: &dates, before_1970, most_cells },
                &mut sheet,
            )?;
        }
        sheets.push(sheet);
    }
    sheet::tables(&sheets).map_err(|e| Format::Xlsx.broken(e))
}

/// Passes every event of a part to `each`; does nothing if the part is missing.
fn events(
    archive: &mut Archive,
    part: &str,
    mut each: impl FnMut(Event<'_>) -> Result<(), ReadProblem>,
) -> Result<(), ReadProblem> {
    events_while(archive, part, Format::Xlsx, |event| each(event).map(|()| true))
}

/// Name and part of each sheet, in the order of the workbook.
fn parts(archive: &mut Archive) -> Result<Vec<(String, String)>, ReadProblem> {
    let mut targets = HashMap::new();
    events(archive, "xl/_rels/workbook.xml.rels", |event| {
        if let Event::Start(tag) | Event::Empty(tag) = &event
            && let (Some(id), Some(target)) = (attribute(tag, "Id"), attribute(tag, "Target"))
        {
            let absolute = target.strip_prefix('/').map(str::to_owned);
            targets.insert(id, absolute.unwrap_or_else(|| format!("xl/{target}")));
        }
        Ok(())
    })?;
    let mut sheets = Vec::new();
    events(archive, "xl/workbook.xml", |event| {
        if let Event::Start(tag) | Event::Empty(tag) = &event
            && tag.local_name().as_ref() == "sheet"
            && let Some(part) = attribute(tag, "r:id").and_then(|id| targets.get(&id).cloned())
        {
            sheets.push((attribute(tag, "name").unwrap_or_default(), part));
        }
        Ok(())
    })?;
    Ok(sheets)
}

/// Days from the origin of dates to 1970.
fn before_1970(archive: &mut Archive) -> Result<f64, ReadProblem> {
    let mut before = BEFORE_1970;
    events(archive, "xl/workbook.xml", |event| {
        if let Event::Start(tag) | Event::Empty(tag) = &event
            && tag.local_name().as_ref() == "workbookPr"
            && attribute(tag, "date1904").is_some_and(|is| matches!(is.as_str(), "1" | "true"))
        {
            before = FROM_1904;
        }
        Ok(())
    })?;
    Ok(before)
}

/// Texts that cells refer to by number.
fn strings(archive: &mut Archive) -> Result<Vec<String>, ReadProblem> {
    let (mut strings, mut current, mut within, mut aside) = (Vec::new(), String::new(), false, false);
    events(archive, "xl/sharedStrings.xml", |event| {
        match &event {
            Event::Start(tag) => match tag.local_name().as_ref() {
                "si" => current.clear(),
                "t" => within = true,
                // The phonetic form of a text is not part of it.
                "rPh" => aside = true,
                _ => {}
            },
            Event::End(tag) => match tag.local_name().as_ref() {
                "si" => strings.push(std::mem::take(&mut current)),
                "t" => within = false,
                "rPh" => aside = false,
                _ => {}
            },
            Event::Empty(tag) if tag.local_name().as_ref() == "si" => strings.push(String::new()),
            Event::Text(piece) if within && !aside => current.push_str(piece),
            Event::GeneralRef(reference) if within && !aside => current.extend(character(reference)),
            _ => {}
        }
        Ok(())
    })?;
    Ok(strings)
}

/// Whether each style of cells shows a date or a time.
fn date_styles(archive: &mut Archive) -> Result<Vec<bool>, ReadProblem> {
    let (mut codes, mut dates, mut within) = (HashMap::new(), Vec::new(), false);
    events(archive, "xl/styles.xml", |event| {
        match &event {
            Event::Start(tag) | Event::Empty(tag) => match tag.local_name().as_ref() {
                "numFmt" => {
                    if let (Some(id), Some(code)) = (attribute(tag, "numFmtId"), attribute(tag, "formatCode"))
                    {
                        codes.insert(id, code);
                    }
                }
                "cellXfs" => within = matches!(event, Event::Start(_)),
                "xf" if within => {
                    let id = attribute(tag, "numFmtId").unwrap_or_default();
                    let own = id.parse::<u32>().is_ok_and(|id| matches!(id, 14..=22 | 45..=47));
                    dates.push(own || codes.get(&id).is_some_and(|code| shows_time(code)));
                }
                _ => {}
            },
            Event::End(tag) if tag.local_name().as_ref() == "cellXfs" => within = false,
            _ => {}
        }
        Ok(())
    })?;
    Ok(dates)
}

/// Whether a format such as `hh:mm:ss.000` shows a time, i.e. contains letters of one outside quotes, colours and
/// conditions.
fn shows_time(code: &str) -> bool {
    let (mut quoted, mut bracket, mut found) = (false, String::new(), false);
    let (mut bracketed, mut escaped) = (false, false);
    for c in code.chars().flat_map(char::to_lowercase) {
        match c {
            _ if escaped => escaped = false,
            '\\' | '_' | '*' => escaped = true,
            '"' => quoted = !quoted,
            _ if quoted => {}
            '[' => {
                bracketed = true;
                bracket.clear();
            }
            ']' => {
                bracketed = false;
                found |= !bracket.is_empty() && bracket.chars().all(|c| matches!(c, 'h' | 'm' | 's'));
            }
            c if bracketed => bracket.push(c),
            'y' | 'd' | 'h' | 's' => found = true,
            _ => {}
        }
    }
    found
}

/// Row and column of a cell reference such as `AB12`, from 0.
fn place(name: &str) -> Option<(u32, u32)> {
    let digits = name.find(|c: char| c.is_ascii_digit())?;
    let (letters, digits) = name.split_at(digits);
    let mut column = 0_u32;
    for letter in letters.bytes() {
        let letter = letter.to_ascii_uppercase();
        if !letter.is_ascii_uppercase() {
            return None;
        }
        column = column.checked_mul(26)?.checked_add(u32::from(letter - b'A') + 1)?;
    }
    let row = digits.parse::<u32>().ok()?.checked_sub(1)?;
    let column = column.checked_sub(1)?;
    (row < MOST_ROWS && column < MOST_COLUMNS).then_some((row, column))
}

/// A cell being read.
#[derive(Default)]
struct Open {
    kind: String,
    style: usize,
    value: String,
    within: bool,
}

/// What the cells of all sheets refer to, and the maximum number of cells read per sheet.
struct SheetContext<'a> {
    strings: &'a [String],
    dates: &'a [bool],
    before_1970: f64,
    most_cells: usize,
}

/// Reads the cells of one sheet; the last row is read completely or not at all.
fn cells(
    archive: &mut Archive,
    part: &str,
    context: &SheetContext<'_>,
    sheet: &mut Sheet,
) -> Result<(), ReadProblem> {
    // Rows and cells without a reference follow the preceding ones.
    let (mut row, mut column) = (0_u32, 0_u32);
    let mut open = Open::default();
    let mut left = context.most_cells;
    events_while(archive, part, Format::Xlsx, |event| {
        match &event {
            Event::Start(tag) | Event::Empty(tag) => match tag.local_name().as_ref() {
                "row" => {
                    if left == 0 {
                        sheet.cut = true;
                        return Ok(false);
                    }
                    let named = attribute(tag, "r").and_then(|r| r.parse::<u32>().ok()?.checked_sub(1));
                    row = named.unwrap_or(row);
                    column = 0;
                }
                "c" => {
                    if let Some(name) = attribute(tag, "r") {
                        (row, column) = place(&name).ok_or_else(|| {
                            Format::Xlsx.broken(format!("{part}: no cell is named `{name:.20}`"))
                        })?;
                    }
                    open = Open {
                        kind: attribute(tag, "t").unwrap_or_default(),
                        style: attribute(tag, "s").and_then(|s| s.parse().ok()).unwrap_or(usize::MAX),
                        ..Open::default()
                    };
                    if matches!(event, Event::Empty(_)) {
                        column += 1;
                    }
                }
                "v" | "t" => open.within = matches!(event, Event::Start(_)),
                _ => {}
            },
            Event::Text(piece) if open.within => open.value.push_str(piece),
            Event::GeneralRef(reference) if open.within => open.value.extend(character(reference)),
            Event::End(tag) => match tag.local_name().as_ref() {
                "v" | "t" => open.within = false,
                "c" => {
                    if let Some(cell) = finished(&open, context)
                        && row < MOST_ROWS
                        && column < MOST_COLUMNS
                    {
                        sheet.set(row, column, cell);
                    }
                    column += 1;
                    left = left.saturating_sub(1);
                }
                "row" => row = row.saturating_add(1),
                _ => {}
            },
            _ => {}
        }
        Ok(true)
    })
}

fn finished(open: &Open, context: &SheetContext<'_>) -> Option<Cell> {
    let value = open.value.as_str();
    match open.kind.as_str() {
        "s" => context.strings.get(value.trim().parse::<usize>().ok()?).map(|t| Cell::Text(t.clone())),
        "str" | "inlineStr" | "d" => (!value.is_empty()).then(|| Cell::Text(value.to_owned())),
        "e" => None,
        _ => {
            let number = value.trim().parse::<f64>().ok().filter(|v| v.is_finite())?;
            let shows_time = context.dates.get(open.style).copied().unwrap_or(false);
            Some(if shows_time { Cell::time(number, context.before_1970) } else { Cell::Number(number) })
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn cells_are_named_by_letters_and_digits() {
        assert_eq!(
            (place("A1"), place("AB12"), place("XFD1048576")),
            (Some((0, 0)), Some((11, 27)), Some((1_048_575, 16_383)))
        );
        for name in ["", "A", "7", "A0", "XFE1", "A1048577", "A99999999999", "ZZZZZZZZZZ1", "A1B", "é1"] {
            assert_eq!(place(name), None, "{name}");
        }
    }

    #[test]
    fn formats_of_times_are_told_from_formats_of_numbers() {
        for code in ["hh:mm:ss", "yyyy-mm-dd", "[h]:mm", "[ss].000", "d/m"] {
            assert!(shows_time(code), "{code}");
        }
        for code in ["General", "0.00E+00", "[Red]0.0", "0.0\" s\"", "#,##0\\s", "0%"] {
            assert!(!shows_time(code), "{code}");
        }
    }
}
