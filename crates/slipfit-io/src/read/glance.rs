//! Preview of a file: its tables, and the record and the curve as which it would be read.

use std::{
    fs::File,
    io::{self, Read as _, Seek as _},
};

use slipfit::{record::Swings, resonance::Curve};

use super::{
    curve,
    open::{self, Fingerprint, Origin, gathered, opened_in_part},
    record,
};
use crate::{
    columns::PEAK,
    error::{ReadError, ReadProblem},
    options::ReadOptions,
    report::{Note, Reading, SweepReading},
    tables::table::{TableSource, Tables},
};

/// Number of first bytes kept.
const HEAD: u64 = 64 << 10;
/// Maximum number of cells read per sheet: cells of a workbook take a hundred times longer than numbers.
const MOST_CELLS: usize = 1 << 13;
/// Minimum number of crossings of an oscillation: a peak has two.
const FEWEST_CROSSINGS: usize = 3;
/// Minimum ratio of the least to the largest number of a column that is clearly not a time.
const LEAST_RATIO_WITHOUT_TIMES: f64 = 0.5;

/// Content of a file, and how it would be read.
#[derive(Debug)]
#[non_exhaustive]
pub struct Glance {
    /// Its first bytes, unchanged, at most 64 kB.
    pub head: Vec<u8>,
    /// Its tables, with the first rows of each.
    pub tables: Tables,
    /// The record over time, or the reason why there is none.
    pub record: Result<Reading, ReadError>,
    /// The swings of that record.
    pub swings: Option<Swings>,
    /// The curve over frequency, if the file is one and not a record.
    pub curve: Option<SweepReading>,
    /// Whether the record was read from the first cells of a sheet only; otherwise it is the result of [`crate::read`].
    pub in_part: bool,
}

/// Previews a file; text is read twice, for its tables and for the record, other formats are opened once.
pub(crate) fn glance(
    origin: Origin<'_>,
    name: &str,
    most_rows: usize,
    record: &ReadOptions,
    curve: Option<&ReadOptions>,
) -> Result<Glance, ReadError> {
    let failed = |error| ReadError::new(name, ReadProblem::Io(error));
    let source = RepeatableSource::new(origin).map_err(failed)?;
    let reopen = || source.reopen().map_err(failed);
    let head = beginning(reopen()?).map_err(failed)?;
    let from_source = |source: &mut dyn TableSource| {
        let tables = gathered(source, most_rows)?;
        if source.dialect(0).is_some() {
            // Text is later read again as a record; a curve is accepted only from tables that were read completely.
            let whole = tables.iter().all(|table| !table.cut);
            let sweep = curve.filter(|_| whole).map(|o| curve::from_tables(&tables, o));
            return Ok((tables, None, sweep, false));
        }
        let mut reading = record::from_source(source, name, record);
        let mut sweep = curve.map(|options| curve::from_tables(&tables, options));
        let in_part = (0..tables.len()).any(|table| source.is_cut(table));
        if in_part {
            let text = format!("the first {MOST_CELLS} cells of a sheet were looked at");
            if let Ok(reading) = &mut reading {
                reading.report.notes.push(Note::new(text.as_str()));
            }
            if let Some(Ok(sweep)) = &mut sweep {
                sweep.report.notes.push(Note::new(text));
            }
        }
        Ok((tables, Some(reading), sweep, in_part))
    };
    let ((tables, reading, sweep, in_part), fingerprint) =
        opened_in_part(reopen()?, record.format, None, MOST_CELLS, from_source)
            .map_err(|problem| ReadError::new(name, problem))?;
    let cut = tables.iter().any(|table| table.cut);
    let record = match reading {
        Some(Ok(mut reading)) => {
            fingerprint.clone().write(&mut reading.report, name);
            Ok(reading)
        }
        Some(Err(problem)) => Err(ReadError::new(name, problem)),
        None => source
            .reopen_hashed(&fingerprint)
            .map_err(failed)
            .and_then(|origin| record::read(origin, name, record, None)),
    };
    let curve = sweep.and_then(Result::ok).map(|mut sweep| {
        fingerprint.clone().write(&mut sweep.report, name);
        sweep
    });
    // A curve recognised by its numbers alone is rejected if only the first rows were read.
    let curve = curve.filter(|curve| !cut || curve.report.named);
    let swings = record.as_ref().ok().map(|reading: &Reading| reading.record.swings());
    let curve = curve.filter(|curve| is_curve(curve, tables.len(), swings));
    Ok(Glance { head, tables: open::described(tables, fingerprint, name), record, swings, curve, in_part })
}

/// A source that can be read more than once: a stream is read once and kept.
enum RepeatableSource {
    File(File),
    Bytes(Vec<u8>),
}

impl RepeatableSource {
    fn new(origin: Origin<'_>) -> io::Result<Self> {
        match origin {
            Origin::File(file) => Ok(Self::File(file)),
            Origin::Stream(mut stream) => {
                let mut bytes = Vec::new();
                stream.read_to_end(&mut bytes)?;
                Ok(Self::Bytes(bytes))
            }
            Origin::Hashed(bytes, _) => Ok(Self::Bytes(bytes.to_vec())),
        }
    }

    /// The source from its beginning.
    fn reopen(&self) -> io::Result<Origin<'_>> {
        match self {
            Self::File(file) => {
                let mut file = file.try_clone()?;
                file.rewind()?;
                Ok(Origin::File(file))
            }
            Self::Bytes(bytes) => Ok(Origin::Stream(Box::new(&bytes[..]))),
        }
    }

    /// The source from its beginning, after its bytes have been hashed: a file may have changed since.
    fn reopen_hashed(&self, Fingerprint { sha256, .. }: &Fingerprint) -> io::Result<Origin<'_>> {
        match self {
            Self::File(_) => self.reopen(),
            Self::Bytes(bytes) => Ok(Origin::Hashed(bytes, sha256.clone())),
        }
    }
}

/// The first bytes of a file.
fn beginning(origin: Origin<'_>) -> io::Result<Vec<u8>> {
    let mut head = Vec::new();
    match origin {
        Origin::File(file) => file.take(HEAD).read_to_end(&mut head),
        Origin::Stream(stream) => stream.take(HEAD).read_to_end(&mut head),
        Origin::Hashed(bytes, _) => bytes.take(HEAD).read_to_end(&mut head),
    }?;
    Ok(head)
}

/// Whether a file is a resonance curve and not a record: according to its names or, without names, if the data do not
/// oscillate and are given over frequencies.
fn is_curve(curve: &SweepReading, tables: usize, swings: Option<Swings>) -> bool {
    let rings = swings.is_some_and(|s| s.crossings >= FEWEST_CROSSINGS);
    if curve.report.named {
        // Next to a record, other tables hold spectra.
        return !(tables > 1 && rings);
    }
    !rings && is_over_frequencies(&curve.curve)
}

/// Whether the amplitudes have a peak between the ends, or the abscissa begins too far from zero for times.
fn is_over_frequencies(curve: &Curve) -> bool {
    let hz = curve.frequency_hz();
    let amplitude = |i: &usize| curve.response().amplitude(*i);
    let by_frequency = |a: &usize, b: &usize| hz[*a].total_cmp(&hz[*b]);
    let ends = (0..hz.len()).min_by(by_frequency).zip((0..hz.len()).max_by(by_frequency));
    ends.is_some_and(|(first, last)| {
        let largest = (0..hz.len()).map(|i| amplitude(&i)).fold(0.0, f64::max);
        let has_peak = largest > PEAK * amplitude(&first).max(amplitude(&last));
        hz[first] > 0.0 && (has_peak || hz[first] > LEAST_RATIO_WITHOUT_TIMES * hz[last])
    })
}
