//! `slipfit inspect`: contents of a file.

use crate::args::{InspectArgs, quoted};
use crate::failure::{Failure, spelled};
use crate::output;
use crate::progress;
use anstream::ColorChoice;
use slipfit_io::{Glance, ReadError, ReadProblem, Reading, Table, Tables};
use slipfit_report::terminal::{self, Inspected};
use std::path::Path;
use std::process::ExitCode;

/// Number of rows of each table that are read.
const PREVIEW_ROWS: usize = 20_000;
/// Number of lines shown from the start of a text.
const FIRST_LINES: usize = 5;

pub(crate) fn run(args: &InspectArgs, color: ColorChoice) -> Result<ExitCode, Failure> {
    if args.file.is_dir() {
        let (name, typed) = (args.file.display(), typed(&args.file));
        return Err(Failure::new(format!("{name}: this is a folder")).hint(format!(
            "slipfit ringdown {typed} makes a table of decays; slipfit resonance {typed} reads driven records, one \
             for each frequency"
        )));
    }
    // Standard output may be redirected into the file itself.
    output::Outputs::new(false, [args.file.as_path()])?;
    let curve_options = args.reading.curve_options();
    let looked = progress::with_spinner("reading", false, || {
        slipfit_io::glance(&args.file, PREVIEW_ROWS, &args.reading.options(), curve_options.as_ref())
    })
    .map_err(|error| refused(&args.file, error))?;
    let Glance { head, tables, record: reading, swings, curve, .. } = looked;
    let lines = if tables.dialect.is_some() { first_lines(&head) } else { Vec::new() };
    let flags = args.reading.as_flags();
    let is_levels = || {
        let read = || slipfit_io::read_levels(&args.file, &args.reading.options());
        curve.is_none()
            && reading.is_err()
            && args.file.as_os_str() != "-"
            && read().is_ok_and(|read| read.report.named)
    };
    let verb = if is_levels() { "levels" } else { verb(&tables, &reading, curve.is_some()) };
    let next_command = command(&args.file, &flags, &tables, &reading, verb);
    let inspected = Inspected {
        file: Path::new(&tables.path),
        tables: &tables,
        reading: &reading,
        swings,
        curve: curve.as_ref(),
        lines: &lines,
        next_command: &next_command,
    };
    output::print(&terminal::inspect(&inspected, &spelled), color)?;
    Ok(ExitCode::SUCCESS)
}

/// The failure of reading; for a manifest with a hint at the command that reads it.
fn refused(file: &Path, error: ReadError) -> Failure {
    let is_manifest = matches!(error.problem, ReadProblem::NoTable { .. })
        && file.extension().is_some_and(|extension| extension.eq_ignore_ascii_case("toml"))
        && std::fs::read_to_string(file)
            .is_ok_and(|text| text.lines().any(|line| line.trim_start().starts_with("[[measurement]]")));
    let failure = Failure::from(error);
    if is_manifest {
        failure.hint(format!("slipfit series {} reads the files named in it", typed(file)))
    } else {
        failure
    }
}

/// The command that analyses the file.
fn verb(tables: &Tables, reading: &Result<Reading, ReadError>, is_curve: bool) -> &'static str {
    let sweep = is_curve || reading.is_err() && tables.tables.iter().any(Table::is_sweep);
    if sweep { "resonance" } else { "ringdown" }
}

/// The command to type next.
fn command(
    file: &Path,
    flags: &str,
    tables: &Tables,
    reading: &Result<Reading, ReadError>,
    verb: &str,
) -> String {
    let mut text = format!("slipfit {verb} {}{}", typed(file), flags);
    if let Err(error) = reading
        && verb == "ringdown"
    {
        // A missing value is named in capitals if the file does not suggest it.
        text += &match &error.problem {
            ReadProblem::NoTime { rate_hz, .. } => {
                format!(" --rate-hz {}", rate_hz.map_or_else(|| "RATE".to_owned(), |r| r.to_string()))
            }
            ReadProblem::NoTickRate { .. } => " --time-unit CLOCK".to_owned(),
            ReadProblem::SeveralTables { .. } => {
                let first = tables.tables.first().map_or("NAME", |t| t.name.as_str());
                format!(" --sheet {}", quoted(first))
            }
            _ => String::new(),
        };
    }
    text
}

/// The file as it is typed: never like a flag, and as one word; `-` is standard input.
fn typed(file: &Path) -> String {
    let path = file.display().to_string();
    quoted(&if path.starts_with('-') && path != "-" { format!("./{path}") } else { path })
}

/// The first lines without changes; none of a compressed file.
fn first_lines(head: &[u8]) -> Vec<String> {
    let mut lines = Vec::new();
    for line in head.split_inclusive(|b| *b == b'\n').take(FIRST_LINES) {
        if line.iter().any(|b| *b == 0 || *b == 0x1f) {
            return Vec::new();
        }
        let text = slipfit_io::text_of(line);
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
    }
    lines
}
