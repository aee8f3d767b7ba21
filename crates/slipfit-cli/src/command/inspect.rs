//! `slipfit inspect`: what a file holds.

use crate::args::InspectArgs;
use crate::failure::Failure;
use crate::{output, report};
use anstream::ColorChoice;
use slipfit_io::{ReadError, Reading, Tables};
use std::fs::File;
use std::io::{BufRead as _, BufReader, Read as _};
use std::path::Path;
use std::process::ExitCode;

/// Rows of each table looked at.
const PREVIEW_ROWS: usize = 20_000;
/// First lines of a text shown, and how far they are looked for.
const FIRST_LINES: usize = 5;
const FIRST_BYTES: u64 = 64 << 10;

/// What is known of a file.
pub(crate) struct Inspected<'a> {
    pub(crate) file: &'a Path,
    pub(crate) tables: &'a Tables,
    /// The record it would be read as, or why it is none.
    pub(crate) reading: &'a Result<Reading, ReadError>,
    /// Its first lines, of text.
    pub(crate) lines: &'a [String],
    /// Flags given, for the command to go on with.
    pub(crate) flags: &'a str,
}

pub(crate) fn run(args: &InspectArgs, color: ColorChoice) -> Result<ExitCode, Failure> {
    let tables = slipfit_io::read_tables(&args.file, PREVIEW_ROWS)?;
    let reading = slipfit_io::read(&args.file, &args.reading.options());
    let lines = if tables.dialect.is_some() { first_lines(&args.file) } else { Vec::new() };
    let flags = args.reading.as_flags();
    let inspected =
        Inspected { file: &args.file, tables: &tables, reading: &reading, lines: &lines, flags: &flags };
    output::print(&report::inspect(&inspected), color)?;
    Ok(ExitCode::SUCCESS)
}

/// The first lines as they stand; none of a packed file.
fn first_lines(path: &Path) -> Vec<String> {
    let Ok(file) = File::open(path) else { return Vec::new() };
    let mut reader = BufReader::new(file.take(FIRST_BYTES));
    let mut lines = Vec::new();
    let mut line = Vec::new();
    while lines.len() < FIRST_LINES && reader.read_until(b'\n', &mut line).is_ok_and(|n| n > 0) {
        if line.iter().any(|b| *b == 0 || *b == 0x1f) {
            return Vec::new();
        }
        let text = String::from_utf8_lossy(&line);
        let text = text.trim_end().trim_start_matches('\u{feff}');
        lines.push(
            text.chars()
                .map(|c| {
                    if c == '\t' {
                        '⇥'
                    } else if c.is_control() {
                        '·'
                    } else {
                        c
                    }
                })
                .collect(),
        );
        line.clear();
    }
    lines
}
