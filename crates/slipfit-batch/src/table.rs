//! Rows of answer as columns.

use crate::answer::{Estimate, Status};
use crate::error::Error;
use crate::options::{Method, Options};
use crate::trace::column;
use arrow_array::builder::{BooleanBuilder, StringBuilder};
use arrow_array::{ArrayRef, Float64Array, Int64Array, RecordBatch};
use arrow_schema::{DataType, Field, Schema};
use arrow_select::concat::concat;
use rayon::prelude::*;
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

type Text = fn(&Row) -> &str;
type Number = fn(&Row) -> f64;
type Count = fn(&Row) -> i64;
type Flag = fn(&Row) -> Option<bool>;

/// What a column holds and where a row has it.
enum Content {
    Text(Text),
    Number(Number),
    Count(Count),
    Flag(Flag),
}

impl Content {
    fn data_type(&self) -> DataType {
        match self {
            Self::Text(_) => DataType::Utf8,
            Self::Number(_) => DataType::Float64,
            Self::Count(_) => DataType::Int64,
            Self::Flag(_) => DataType::Boolean,
        }
    }

    fn column(&self, rows: usize) -> Column {
        match self {
            Self::Text(of) => Column::Text(*of, StringBuilder::new()),
            Self::Number(of) => Column::Number(*of, Vec::with_capacity(rows)),
            Self::Count(of) => Column::Count(*of, Vec::with_capacity(rows)),
            Self::Flag(of) => Column::Flag(*of, BooleanBuilder::with_capacity(rows)),
        }
    }
}

/// A column that grows.
enum Column {
    Text(Text, StringBuilder),
    Number(Number, Vec<f64>),
    Count(Count, Vec<i64>),
    Flag(Flag, BooleanBuilder),
}

impl Column {
    fn extend(&mut self, rows: &[Row]) {
        match self {
            Self::Text(of, held) => rows.iter().for_each(|row| held.append_value(of(row))),
            Self::Number(of, held) => held.extend(rows.iter().map(of)),
            Self::Count(of, held) => held.extend(rows.iter().map(of)),
            Self::Flag(of, held) => rows.iter().for_each(|row| held.append_option(of(row))),
        }
    }

    fn array(self) -> ArrayRef {
        match self {
            Self::Text(_, mut held) => Arc::new(held.finish()),
            Self::Number(_, held) => {
                let missing = held.iter().any(|v| v.is_nan());
                let nulls = missing.then(|| held.iter().map(|v| !v.is_nan()).collect());
                Arc::new(Float64Array::new(held.into(), nulls))
            }
            Self::Count(_, held) => Arc::new(Int64Array::from(held)),
            Self::Flag(_, mut held) => Arc::new(held.finish()),
        }
    }
}

macro_rules! estimate {
    ($name:literal, $unit:literal, $field:ident) => {
        [
            (concat!($name, $unit), Content::Number(|r| r.$field.value)),
            (concat!($name, "_std_error", $unit), Content::Number(|r| r.$field.std_error)),
            (concat!($name, "_low", $unit), Content::Number(|r| r.$field.low)),
            (concat!($name, "_high", $unit), Content::Number(|r| r.$field.high)),
        ]
    };
}

/// Names and contents in the order of the answer; names are those of the command's `--table`.
fn contents(method: Method) -> Vec<(&'static str, Content)> {
    let mut all =
        vec![("status", Content::Text(|r| r.status.name())), ("reason", Content::Text(|r| &r.reason))];
    if method == Method::Analyse {
        all.push(("model", Content::Text(|r| r.model)));
        all.extend(estimate!("frequency", "_hz", frequency));
    }
    all.extend(estimate!("decay_rate", "_per_s", decay_rate));
    all.extend(estimate!("sliding_rate", "", sliding_rate));
    all.extend(estimate!("friction_displacement", "", friction_displacement));
    all.extend(estimate!("initial_amplitude", "", initial_amplitude));
    all.push(("correlation", Content::Number(|r| r.correlation)));
    all.push(("residual_rms", Content::Number(|r| r.residual_rms)));
    all.push(("sliding_detected", Content::Flag(|r| r.detected)));
    all.push(("sliding_p_value", Content::Number(|r| r.p_value)));
    all.push(("samples", Content::Count(|r| r.samples)));
    all.push(("samples_left_out", Content::Count(|r| r.left_out)));
    if method == Method::Analyse {
        all.push(("start_s", Content::Number(|r| r.start_s)));
        all.push(("end_s", Content::Number(|r| r.end_s)));
    }
    all
}

/// The columns of an answer to a table of this schema: those kept, then the answer's own.
///
/// # Errors
/// [`Error::NoColumn`] where a column to keep is not there; [`Error::Option`] where it would stand
/// twice.
pub fn schema(table: &Schema, options: &Options) -> Result<Schema, Error> {
    let own = contents(options.method);
    let mut fields = Vec::new();
    for name in &options.keep {
        let Ok(field) = table.field_with_name(name) else {
            let all: Vec<String> = table.fields().iter().map(|field| format!("`{}`", field.name())).collect();
            return Err(Error::NoColumn { name: name.clone(), columns: all.join(", ") });
        };
        if own.iter().any(|(known, _)| known == name) {
            let problem = format!("the answer has a column `{name}` of its own");
            return Err(Error::Option { option: "keep", problem });
        }
        fields.push(field.clone());
    }
    // Every number may be missing; engines want the same of every batch.
    fields.extend(own.iter().map(|(name, content)| Field::new(*name, content.data_type(), true)));
    Ok(Schema::new(fields))
}

/// The columns of the answer's own.
pub(crate) struct Columns(Vec<(&'static str, Content)>);

impl Columns {
    pub(crate) fn new(method: Method) -> Self {
        Self(contents(method))
    }

    /// Rows, column by column, as they come; `rows` of them at most.
    pub(crate) fn part(&self, rows: usize) -> Part {
        Part(self.0.iter().map(|(_, content)| content.column(rows)).collect())
    }

    /// All parts, one below the other, behind the columns to keep.
    pub(crate) fn joined(
        &self,
        parts: &[Vec<ArrayRef>],
        batch: &RecordBatch,
        options: &Options,
    ) -> Result<RecordBatch, Error> {
        let schema = Arc::new(schema(&batch.schema(), options)?);
        if parts.is_empty() {
            return Ok(RecordBatch::new_empty(schema));
        }
        let mut arrays: Vec<ArrayRef> = Vec::new();
        for name in &options.keep {
            arrays.push(Arc::clone(column(batch, name)?));
        }
        let own: Result<Vec<ArrayRef>, _> = (0..self.0.len())
            .into_par_iter()
            .map(|i| concat(&parts.iter().map(|part| part[i].as_ref()).collect::<Vec<_>>()))
            .collect();
        arrays.extend(own?);
        Ok(RecordBatch::try_new(schema, arrays)?)
    }
}

/// Rows on their way to be columns.
pub(crate) struct Part(Vec<Column>);

impl Part {
    pub(crate) fn extend(&mut self, rows: &[Row]) {
        self.0.iter_mut().for_each(|column| column.extend(rows));
    }

    pub(crate) fn arrays(self) -> Vec<ArrayRef> {
        self.0.into_iter().map(Column::array).collect()
    }
}
