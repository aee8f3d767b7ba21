//! Rows of answer as columns.

use crate::answer::{Estimate, Status};
use crate::error::{Error, place};
use crate::options::{Method, Options};
use crate::trace::column;
use arrow_array::{ArrayRef, BooleanArray, Float64Array, Int64Array, RecordBatch, StringArray};
use arrow_buffer::{BooleanBuffer, Buffer, OffsetBuffer};
use arrow_schema::{ArrowError, DataType, Field, Schema};
use slipfit::ringdown::AmplitudeFit;
use slipfit::{InferenceCriteria, Parameter};
use std::sync::Arc;

/// The answer to one trace; NaN where a number does not exist.
#[derive(Debug, Clone)]
pub(crate) struct Row {
    pub(crate) status: Status,
    /// Codes of the warnings, or why it failed.
    pub(crate) reason: String,
    pub(crate) model: &'static str,
    pub(crate) frequency: Estimate,
    pub(crate) initial_amplitude: Estimate,
    pub(crate) decay_rate: Estimate,
    pub(crate) sliding_rate: Estimate,
    pub(crate) friction_displacement: Estimate,
    pub(crate) correlation: f64,
    pub(crate) residual_rms: f64,
    pub(crate) p_value: f64,
    pub(crate) detected: Option<bool>,
    pub(crate) samples: i64,
    pub(crate) left_out: i64,
    pub(crate) start_s: f64,
    pub(crate) end_s: f64,
}

impl Default for Row {
    fn default() -> Self {
        Self {
            status: Status::Failed,
            reason: String::new(),
            model: "",
            frequency: Estimate::NONE,
            initial_amplitude: Estimate::NONE,
            decay_rate: Estimate::NONE,
            sliding_rate: Estimate::NONE,
            friction_displacement: Estimate::NONE,
            correlation: f64::NAN,
            residual_rms: f64::NAN,
            p_value: f64::NAN,
            detected: None,
            samples: 0,
            left_out: 0,
            start_s: f64::NAN,
            end_s: f64::NAN,
        }
    }
}

impl Row {
    pub(crate) fn failed(reason: String) -> Self {
        Self { reason, ..Self::default() }
    }
}

/// Fits of neighbouring rows, all of which used every sample.
pub(crate) struct Fits<'a> {
    pub(crate) fits: &'a [AmplitudeFit],
    /// Value and standard error; empty without a frequency.
    pub(crate) friction_displacement: &'a [[f64; 2]],
    pub(crate) p_value: &'a [f64],
    pub(crate) samples: usize,
}

/// Type of a column, how it is taken from a row, and how it is taken from fits.
enum Content {
    /// Text, and the text common to all fits without warnings.
    Text(fn(&Row) -> &str, &'static str),
    Number(fn(&Row) -> f64, fn(&Fits<'_>, &mut [f64])),
    Count(fn(&Row) -> i64, fn(&Fits<'_>) -> i64),
    Flag(fn(&Row) -> Option<bool>, fn(&Fits<'_>, &mut [Flag])),
}

/// A flag, which may be missing.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
#[repr(u8)]
pub(crate) enum Flag {
    Unset,
    Set,
    Missing,
}

impl From<Option<bool>> for Flag {
    fn from(flag: Option<bool>) -> Self {
        match flag {
            None => Self::Missing,
            Some(true) => Self::Set,
            Some(false) => Self::Unset,
        }
    }
}

impl Content {
    fn data_type(&self) -> DataType {
        match self {
            Self::Text(..) => DataType::Utf8,
            Self::Number(..) => DataType::Float64,
            Self::Count(..) => DataType::Int64,
            Self::Flag(..) => DataType::Boolean,
        }
    }
}

/// Writes a value of each fit to `to`, one after the other.
fn each<T, U>(values: impl Iterator<Item = T>, to: &mut [U], of: impl Fn(T) -> U) {
    to.iter_mut().zip(values).for_each(|(to, value)| *to = of(value));
}

macro_rules! number {
    ($name:expr, $row:expr, $fits:ident, $of:expr) => {
        ($name, Content::Number($row, |f, to| each(f.$fits(), to, $of)))
    };
}

/// A quantity with error and interval: its field in a row, and in fits.
macro_rules! estimate {
    ($name:literal, $unit:literal, $field:ident, $fits:ident) => {
        [
            number!(concat!($name, $unit), |r| r.$field.value, $fits, |[value, _]| value),
            number!(concat!($name, "_std_error", $unit), |r| r.$field.std_error, $fits, |[_, error]| error),
            number!(concat!($name, "_low", $unit), |r| r.$field.low, $fits, |e| Estimate::normal(e).low),
            number!(concat!($name, "_high", $unit), |r| r.$field.high, $fits, |e| Estimate::normal(e).high),
        ]
    };
}

impl Fits<'_> {
    fn decay_rate(&self) -> impl Iterator<Item = [f64; 2]> {
        self.fits.iter().map(|fit| fit.decay_rate_per_s)
    }

    fn sliding_rate(&self) -> impl Iterator<Item = [f64; 2]> {
        self.fits.iter().map(|fit| fit.sliding_rate)
    }

    fn friction_displacement(&self) -> impl Iterator<Item = [f64; 2]> {
        self.friction_displacement.iter().copied()
    }

    fn initial_amplitude(&self) -> impl Iterator<Item = [f64; 2]> {
        self.fits.iter().map(|fit| fit.initial_amplitude)
    }

    fn correlation(&self) -> impl Iterator<Item = f64> {
        self.fits.iter().map(|fit| fit.correlation)
    }

    fn residual_rms(&self) -> impl Iterator<Item = f64> {
        self.fits.iter().map(|fit| fit.residual_rms)
    }

    fn p_value(&self) -> impl Iterator<Item = f64> {
        self.p_value.iter().copied()
    }

    /// Missing values for what only an analysis has.
    fn nothing(&self) -> impl Iterator<Item = [f64; 2]> {
        self.fits.iter().map(|_| [f64::NAN; 2])
    }
}

/// Names and contents in the order of the answer; the names are those of the command's `--table`.
fn contents(method: Method) -> Vec<(&'static str, Content)> {
    let mut all = vec![
        ("status", Content::Text(|r| r.status.name(), Status::Done.name())),
        ("reason", Content::Text(|r| &r.reason, "")),
    ];
    if method == Method::Analyse {
        all.push(("model", Content::Text(|r| r.model, "")));
        all.extend(estimate!("frequency", "_hz", frequency, nothing));
    }
    all.extend(estimate!("decay_rate", "_per_s", decay_rate, decay_rate));
    all.extend(estimate!("sliding_rate", "", sliding_rate, sliding_rate));
    all.extend(estimate!("friction_displacement", "", friction_displacement, friction_displacement));
    all.extend(estimate!("initial_amplitude", "", initial_amplitude, initial_amplitude));
    all.push(number!("correlation", |r| r.correlation, correlation, |v| v));
    all.push(number!("residual_rms", |r| r.residual_rms, residual_rms, |v| v));
    let flags = |f: &Fits<'_>, to: &mut [Flag]| each(f.p_value(), to, |p| Some(detected(p)).into());
    all.push(("sliding_detected", Content::Flag(|r| r.detected, flags)));
    all.push(number!("sliding_p_value", |r| r.p_value, p_value, |v| v));
    all.push(("samples", Content::Count(|r| r.samples, |f| f.samples as i64)));
    all.push(("samples_left_out", Content::Count(|r| r.left_out, |_| 0)));
    if method == Method::Analyse {
        all.push(number!("start_s", |r| r.start_s, nothing, |[v, _]| v));
        all.push(number!("end_s", |r| r.end_s, nothing, |[v, _]| v));
    }
    all
}

/// Whether sliding friction is detected.
pub(crate) fn detected(p_value: f64) -> bool {
    p_value < InferenceCriteria::default().detected
}

/// The columns of an answer to a table of this schema: the kept columns, then those of the answer, whose units
/// are in their metadata under `unit`.
///
/// # Errors
/// [`Error::NoColumn`], [`Error::AmbiguousColumn`] if a column to keep does not exist or exists more than once;
/// [`Error::Option`] if it would appear twice.
pub fn schema(table: &Schema, options: &Options) -> Result<Schema, Error> {
    let own = contents(options.method);
    let mut fields = Vec::new();
    for (at, name) in options.keep.iter().enumerate() {
        let field = table.field(place(table, name)?);
        if options.keep[..at].contains(name) {
            return Err(Error::Option { option: "keep", problem: format!("`{name}` is named twice") });
        }
        if own.iter().any(|(known, _)| known == name) {
            let problem = format!("the answer has a column `{name}` of its own");
            return Err(Error::Option { option: "keep", problem });
        }
        fields.push(field.clone());
    }
    // Every number may be missing, and engines need the same schema for every batch.
    fields.extend(own.iter().map(|(name, content)| {
        let field = Field::new(*name, content.data_type(), true);
        let unit = unit(name, options);
        if unit.is_empty() { field } else { field.with_metadata([(UNIT.to_owned(), unit)]) }
    }));
    Ok(Schema::new(fields))
}

/// The key of a column's metadata that holds its unit.
const UNIT: &str = "unit";

/// The unit of a column of the answer; empty for a pure number, or if the unit of the traces is not known.
fn unit(name: &str, options: &Options) -> String {
    let parameters = [
        ("frequency_", Parameter::Frequency),
        ("decay_rate", Parameter::DECAY_RATE),
        ("sliding_rate", Parameter::SlidingRate),
        ("initial_amplitude", Parameter::InitialAmplitude),
        ("friction_displacement", Parameter::FRICTION_DISPLACEMENT),
    ];
    let signal = &options.unit;
    match parameters.into_iter().find(|(stem, _)| name.starts_with(stem)) {
        Some((_, Parameter::FRICTION_DISPLACEMENT)) => options.signal.kind().displacement_unit(signal),
        Some((_, parameter)) => parameter.unit(signal),
        None => match name {
            "residual_rms" => signal.clone(),
            "start_s" | "end_s" => "s".to_owned(),
            _ => String::new(),
        },
    }
}

/// The columns of the answer, allocated for the whole table at the start, so that rows are written in place.
pub(crate) struct Columns {
    contents: Vec<(&'static str, Content)>,
    rows: usize,
    memory: Vec<Memory>,
}

/// The values of one column.
enum Memory {
    /// The text of most rows.
    Text(&'static str),
    Number(Vec<f64>),
    Count(Vec<i64>),
    Flag(Vec<Flag>),
}

/// Some neighbouring rows of one column, to be written to.
enum Place<'a> {
    /// The rows whose text differs from that of fits without warnings.
    Text(Vec<(usize, String)>),
    Number(&'a mut [f64]),
    Count(&'a mut [i64]),
    Flag(&'a mut [Flag]),
}

/// Some neighbouring rows of the answer.
pub(crate) struct Part<'a> {
    contents: &'a [(&'static str, Content)],
    first: usize,
    places: Vec<Place<'a>>,
}

/// The data of a part that are not stored in the columns' memory: for each column ...
pub(crate) struct PartRemainder(Vec<ColumnRemainder>);

struct ColumnRemainder {
    /// ... whether a value is missing,
    missing: bool,
    /// and the rows whose text differs from that of fits without warnings.
    text: Vec<(usize, String)>,
}

impl Columns {
    pub(crate) fn new(method: Method, rows: usize) -> Self {
        let contents = contents(method);
        let memory = |(_, content): &(&str, Content)| match content {
            Content::Text(_, usual) => Memory::Text(usual),
            Content::Number(..) => Memory::Number(vec![0.0; rows]),
            Content::Count(..) => Memory::Count(vec![0; rows]),
            Content::Flag(..) => Memory::Flag(vec![Flag::Unset; rows]),
        };
        let memory = contents.iter().map(memory).collect();
        Self { contents, rows, memory }
    }

    /// Divides the columns into parts of `size` rows.
    pub(crate) fn parts(&mut self, size: usize) -> Vec<Part<'_>> {
        let Self { contents, rows, memory } = self;
        let mut parts: Vec<Part<'_>> = (0..*rows)
            .step_by(size)
            .map(|first| Part { contents, first, places: Vec::with_capacity(contents.len()) })
            .collect();
        for column in memory {
            let places: Box<dyn Iterator<Item = Place<'_>>> = match column {
                Memory::Text(_) => Box::new(std::iter::repeat_with(|| Place::Text(Vec::new()))),
                Memory::Number(values) => Box::new(values.chunks_mut(size).map(Place::Number)),
                Memory::Count(values) => Box::new(values.chunks_mut(size).map(Place::Count)),
                Memory::Flag(values) => Box::new(values.chunks_mut(size).map(Place::Flag)),
            };
            parts.iter_mut().zip(places).for_each(|(part, place)| part.places.push(place));
        }
        parts
    }

    /// The answer: the kept columns, then these.
    pub(crate) fn joined(
        self,
        remainders: &[PartRemainder],
        batch: &RecordBatch,
        options: &Options,
    ) -> Result<RecordBatch, Error> {
        let schema = Arc::new(schema(&batch.schema(), options)?);
        let mut arrays: Vec<ArrayRef> = Vec::new();
        for name in &options.keep {
            arrays.push(Arc::clone(column(batch, name)?));
        }
        for (at, memory) in self.memory.into_iter().enumerate() {
            let missing = remainders.iter().any(|remainder| remainder.0[at].missing);
            arrays.push(match memory {
                Memory::Text(usual) => {
                    let others: Vec<_> =
                        remainders.iter().flat_map(|remainder| &remainder.0[at].text).collect();
                    Arc::new(texts(self.rows, usual, &others)?)
                }
                Memory::Number(values) => {
                    let nulls = missing.then(|| values.iter().map(|v| !v.is_nan()).collect());
                    Arc::new(Float64Array::new(values.into(), nulls))
                }
                Memory::Count(values) => Arc::new(Int64Array::from(values)),
                Memory::Flag(values) => {
                    let set = BooleanBuffer::collect_bool(values.len(), |row| values[row] == Flag::Set);
                    let nulls = missing.then(|| values.iter().map(|v| *v != Flag::Missing).collect());
                    Arc::new(BooleanArray::new(set, nulls))
                }
            });
        }
        Ok(RecordBatch::try_new(schema, arrays)?)
    }
}

/// A column of text: `usual` in every row except `others`.
fn texts(rows: usize, usual: &str, others: &[&(usize, String)]) -> Result<StringArray, Error> {
    let length: usize = others.iter().map(|(_, text)| text.len()).sum();
    let length = length + (rows - others.len()) * usual.len();
    if i32::try_from(length).is_err() {
        return Err(ArrowError::OffsetOverflowError(length).into());
    }
    let mut bytes = String::with_capacity(length);
    let mut ends = Vec::with_capacity(rows + 1);
    ends.push(0);
    let usually = |until: usize, bytes: &mut String, ends: &mut Vec<i32>| {
        let (before, count) = (bytes.len(), until - (ends.len() - 1));
        bytes.extend(std::iter::repeat_n(usual, count));
        // Within the length that was checked above.
        ends.extend((1..=count).map(|i| (before + i * usual.len()) as i32));
    };
    for (row, text) in others {
        usually(*row, &mut bytes, &mut ends);
        bytes += text;
        ends.push(bytes.len() as i32);
    }
    usually(rows, &mut bytes, &mut ends);
    Ok(StringArray::try_new(OffsetBuffer::new(ends.into()), Buffer::from_vec(bytes.into_bytes()), None)?)
}

impl Part<'_> {
    /// Number of the first row.
    pub(crate) fn first(&self) -> usize {
        self.first
    }

    /// Writes fits, starting at a row.
    pub(crate) fn write_fits(&mut self, row: usize, fits: &Fits<'_>) {
        let range = row - self.first..row - self.first + fits.fits.len();
        for ((_, content), place) in self.contents.iter().zip(&mut self.places) {
            match (content, place) {
                (Content::Number(_, of), Place::Number(to)) => of(fits, &mut to[range.clone()]),
                (Content::Count(_, of), Place::Count(to)) => to[range.clone()].fill(of(fits)),
                (Content::Flag(_, of), Place::Flag(to)) => of(fits, &mut to[range.clone()]),
                _ => {}
            }
        }
    }

    /// Writes a row, replacing a fit in its place; rows come in order.
    pub(crate) fn write(&mut self, row: usize, answer: &Row) {
        let at = row - self.first;
        for ((_, content), place) in self.contents.iter().zip(&mut self.places) {
            match (content, place) {
                (Content::Text(of, usual), Place::Text(to)) => {
                    let text = of(answer);
                    if text != *usual {
                        to.push((row, text.to_owned()));
                    }
                }
                (Content::Number(of, _), Place::Number(to)) => to[at] = of(answer),
                (Content::Count(of, _), Place::Count(to)) => to[at] = of(answer),
                (Content::Flag(of, _), Place::Flag(to)) => to[at] = of(answer).into(),
                _ => {}
            }
        }
    }

    /// What remains to be joined.
    pub(crate) fn remainder(self) -> PartRemainder {
        let remainder = |place| match place {
            Place::Text(text) => ColumnRemainder { missing: false, text },
            Place::Number(values) => {
                ColumnRemainder { missing: values.iter().any(|v| v.is_nan()), text: Vec::new() }
            }
            Place::Flag(values) => {
                ColumnRemainder { missing: values.contains(&Flag::Missing), text: Vec::new() }
            }
            Place::Count(_) => ColumnRemainder { missing: false, text: Vec::new() },
        };
        PartRemainder(self.places.into_iter().map(remainder).collect())
    }
}
