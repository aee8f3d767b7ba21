//! OpenDocument spreadsheets (.ods) of LibreOffice and others: sheets in one XML part of an archive.

use quick_xml::events::{BytesStart, Event};

use super::package::{attribute, character, events_while};
use crate::{
    error::ReadProblem,
    format::Format,
    tables::sheet::{self, Cell, Sheet},
    tables::table::LoadedTables,
    tables::unpack::Archive,
};

/// Maximum number of rows and columns in LibreOffice.
const MOST_ROWS: u32 = 1 << 20;
const MOST_COLUMNS: u32 = 1 << 14;
/// Maximum number of cells added by repetitions: equal rows and cells are written once, with their number.
const MOST_REPEATED: usize = 1 << 22;

/// Reads every sheet, cell by cell, up to `most_cells` cells each.
pub(crate) fn tables(archive: &mut Archive, most_cells: usize) -> Result<LoadedTables, ReadProblem> {
    let mut reader = Reader { left: most_cells, most_cells, ..Reader::default() };
    events_while(archive, "content.xml", Format::Ods, |event| {
        reader.take(&event)?;
        Ok(true)
    })?;
    sheet::tables(&reader.sheets).map_err(|e| Format::Ods.broken(e))
}

/// State of the reader of a spreadsheet.
#[derive(Default)]
struct Reader {
    sheets: Vec<Sheet>,
    row: u32,
    column: u32,
    /// Number of repetitions of the current row and cell.
    rows: u32,
    cells: u32,
    /// The cells of the current row, with their columns.
    line: Vec<(u32, Cell)>,
    kind: String,
    value: String,
    words: String,
    /// Whether a text of the cell, or an annotation, is being read.
    within: bool,
    aside: bool,
    repeated: usize,
    left: usize,
    most_cells: usize,
}

impl Reader {
    fn take(&mut self, event: &Event<'_>) -> Result<(), ReadProblem> {
        match event {
            Event::Start(tag) => self.begin(tag),
            Event::Empty(tag) => {
                self.begin(tag);
                return self.end(tag.local_name().as_ref());
            }
            Event::End(tag) => return self.end(tag.local_name().as_ref()),
            Event::Text(piece) if self.within && !self.aside => self.words.push_str(piece),
            Event::GeneralRef(reference) if self.within && !self.aside => {
                self.words.extend(character(reference));
            }
            _ => {}
        }
        Ok(())
    }

    fn begin(&mut self, tag: &BytesStart<'_>) {
        let repeated = |name: &str| attribute(tag, name).and_then(|n| n.parse().ok()).unwrap_or(1_u32).max(1);
        match tag.local_name().as_ref() {
            "table" => {
                self.sheets.push(Sheet::new(&attribute(tag, "table:name").unwrap_or_default()));
                (self.row, self.left) = (0, self.most_cells);
            }
            "table-row" => {
                (self.column, self.rows) = (0, repeated("table:number-rows-repeated"));
                self.line.clear();
            }
            "table-cell" | "covered-table-cell" => {
                self.cells = repeated("table:number-columns-repeated");
                self.kind = attribute(tag, "office:value-type").unwrap_or_default();
                let name = match self.kind.as_str() {
                    "date" => "office:date-value",
                    "time" => "office:time-value",
                    _ => "office:value",
                };
                self.value = attribute(tag, name).unwrap_or_default();
                self.words.clear();
            }
            "p" => self.within = true,
            "annotation" => self.aside = true,
            _ => {}
        }
    }

    fn end(&mut self, name: &str) -> Result<(), ReadProblem> {
        match name {
            "p" => self.within = false,
            "annotation" => self.aside = false,
            "table-cell" | "covered-table-cell" => {
                let next = self.column.saturating_add(self.cells);
                if let Some(cell) = self.cell() {
                    let columns = self.column..next.min(MOST_COLUMNS);
                    self.repeat(columns.len().saturating_sub(1))?;
                    self.line.extend(columns.map(|column| (column, cell.clone())));
                }
                self.column = next;
            }
            "table-row" => {
                let next = self.row.saturating_add(self.rows);
                if !self.line.is_empty() {
                    let rows = self.row..next.min(MOST_ROWS);
                    self.repeat(rows.len().saturating_sub(1).saturating_mul(self.line.len()))?;
                    for row in rows {
                        self.set(row);
                    }
                }
                self.row = next;
            }
            _ => {}
        }
        Ok(())
    }

    /// Writes the current row into its sheet, completely or not at all.
    fn set(&mut self, row: u32) {
        let Some(sheet) = self.sheets.last_mut() else { return };
        if self.left == 0 {
            sheet.cut = true;
            return;
        }
        self.left = self.left.saturating_sub(self.line.len());
        self.line.iter().for_each(|(column, cell)| sheet.set(row, *column, cell.clone()));
    }

    fn repeat(&mut self, cells: usize) -> Result<(), ReadProblem> {
        self.repeated = self.repeated.saturating_add(cells);
        if self.repeated > MOST_REPEATED {
            return Err(Format::Ods.broken(format!("more than {MOST_REPEATED} of its cells are repetitions")));
        }
        Ok(())
    }

    /// The current cell; `None` if it is empty.
    fn cell(&self) -> Option<Cell> {
        match self.kind.as_str() {
            "float" | "percentage" | "currency" => {
                self.value.trim().parse().ok().filter(|v: &f64| v.is_finite()).map(Cell::Number)
            }
            "time" => duration(&self.value).map(Cell::Number),
            // Read as a date when the sheet is read as text.
            "date" => Some(Cell::Text(self.value.clone())),
            _ => (!self.words.trim().is_empty()).then(|| Cell::Text(self.words.clone())),
        }
    }
}

/// Seconds in `PT01H02M03.5S`.
fn duration(text: &str) -> Option<f64> {
    let mut rest = text.trim().strip_prefix("PT")?;
    let mut seconds = 0.0;
    while !rest.is_empty() {
        let at = rest.find(|c: char| !c.is_ascii_digit() && c != '.' && c != ',')?;
        let number: f64 = rest[..at].replace(',', ".").parse().ok()?;
        seconds += number
            * match rest.as_bytes()[at] {
                b'H' => 3600.0,
                b'M' => 60.0,
                b'S' => 1.0,
                _ => return None,
            };
        rest = &rest[at + 1..];
    }
    Some(seconds)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn durations_are_seconds() {
        for (text, seconds) in [("PT00H00M01.25S", 1.25), ("PT26H03M04S", 93_784.0), ("PT5M", 300.0)] {
            assert_eq!(duration(text), Some(seconds), "{text}");
        }
        for text in ["", "P1D", "PT1X", "PTS", "PT1"] {
            assert_eq!(duration(text), None, "{text}");
        }
    }
}
