//! Batches: tables are passed in and out by Arrow's C interface in Python capsules.

use crate::answer::RingdownChoices;
use crate::capsule::{export_schema, export_stream, import};
use crate::column;
use crate::failure::{Failure, keyword, option_error};
use crate::interrupt::{bug_report, caught, interruptible_until, uninterrupted};
use arrow_array::{ArrayRef, RecordBatch, RecordBatchReader};
use arrow_ipc::reader::StreamReader;
use arrow_ipc::writer::StreamWriter;
use arrow_schema::{ArrowError, DataType, FieldRef, SchemaRef};
use pyo3::exceptions::{PyKeyError, PyStopIteration};
use pyo3::prelude::*;
use pyo3::types::{PyBytes, PyCapsule};
use slipfit::SignalKind;
use slipfit_batch::{Clock, Error, Method, Number, Options, Signal, fit_batch_until, plain};
use std::collections::HashMap;
use std::sync::atomic::AtomicBool;
use std::sync::{Arc, Mutex, MutexGuard, PoisonError};

/// A table of answers.
#[pyclass(frozen, module = "slipfit")]
pub(crate) struct ArrowTable {
    schema: SchemaRef,
    batches: Vec<RecordBatch>,
}

#[pymethods]
impl ArrowTable {
    /// The table as a stream of Arrow's C interface.
    #[pyo3(signature = (requested_schema=None))]
    fn __arrow_c_stream__<'py>(
        &self,
        py: Python<'py>,
        requested_schema: Option<Bound<'py, PyAny>>,
    ) -> PyResult<Bound<'py, PyCapsule>> {
        // The requested schema is only a preference, and these types are the answer's own.
        drop(requested_schema);
        let batches: Vec<_> = self.batches.iter().cloned().map(Ok).collect();
        let reader = arrow_array::RecordBatchIterator::new(batches, Arc::clone(&self.schema));
        export_stream(py, Box::new(reader))
    }

    /// The types of the columns by Arrow's C interface.
    fn __arrow_c_schema__<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyCapsule>> {
        export_schema(py, &self.schema)
    }

    fn __len__(&self) -> usize {
        self.batches.iter().map(RecordBatch::num_rows).sum()
    }

    #[getter]
    fn column_names(&self) -> Vec<String> {
        self.schema.fields().iter().map(|field| field.name().clone()).collect()
    }

    /// Units of the columns by name, for those that have one.
    #[getter]
    fn units(&self) -> HashMap<String, String> {
        let unit = |field: &FieldRef| Some((field.name().clone(), field.metadata().get("unit")?.clone()));
        self.schema.fields().iter().filter_map(unit).collect()
    }

    /// `count` rows, starting at row `first`.
    fn rows(&self, first: usize, count: usize) -> Self {
        let mut left = (first, count);
        let part = |batch: &RecordBatch| {
            let skipped = left.0.min(batch.num_rows());
            let taken = left.1.min(batch.num_rows() - skipped);
            left = (left.0 - skipped, left.1 - taken);
            batch.slice(skipped, taken)
        };
        Self { schema: Arc::clone(&self.schema), batches: self.batches.iter().map(part).collect() }
    }

    /// A column of the answer: numbers as an array, texts as a list.
    fn column<'py>(&self, py: Python<'py>, name: &str) -> PyResult<Bound<'py, PyAny>> {
        let index = self.schema.index_of(name).map_err(|_| PyKeyError::new_err(name.to_owned()))?;
        let parts: Vec<&ArrayRef> = self.batches.iter().map(|batch| batch.column(index)).collect();
        match column::values(py, self.schema.field(index).data_type(), &parts)? {
            Some(values) => Ok(values),
            None => {
                let found = self.schema.field(index).data_type();
                let message = format!("the column `{name}` is as it came ({found}); to_pyarrow() has it");
                Err(option_error(py, "name", message))
            }
        }
    }

    /// Tables are equal if their columns and rows are, regardless of batches and units.
    fn __eq__(&self, other: &Self) -> bool {
        let columns = |table: &Self| -> Vec<_> {
            table.schema.fields().iter().map(|f| (f.name().clone(), f.data_type().clone())).collect()
        };
        columns(self) == columns(other) && column::same_rows(&self.batches, &other.batches)
    }

    /// The table as a stream of Arrow's file format.
    fn to_bytes<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyBytes>> {
        let write = || {
            let mut writer = StreamWriter::try_new(Vec::new(), &self.schema)?;
            self.batches.iter().try_for_each(|batch| writer.write(batch))?;
            writer.into_inner()
        };
        Ok(PyBytes::new(
            py,
            &uninterrupted(py, write)?.map_err(|error: ArrowError| batch_error(py, error.into()))?,
        ))
    }

    /// The table stored in these bytes.
    #[staticmethod]
    fn of_bytes(py: Python<'_>, bytes: &[u8]) -> PyResult<Self> {
        let read = || {
            let reader = StreamReader::try_new(bytes, None)?;
            Ok(Self { schema: reader.schema(), batches: reader.collect::<Result<_, _>>()? })
        };
        read().map_err(|error: ArrowError| batch_error(py, error.into()))
    }
}

/// Answers to the batches of a stream, one after the other, each computed when it is requested.
#[pyclass(frozen, module = "slipfit")]
pub(crate) struct ArrowStream {
    schema: SchemaRef,
    state: Mutex<State>,
}

/// How far a stream has been read.
enum State {
    Ready(Box<Answers>),
    /// A thread is computing the next batch.
    Busy,
    Ended,
    /// Another reader has taken it.
    Exported,
    /// The rest was lost in an error or an interruption.
    Broken,
}

/// The batches of a source, answered.
struct Answers {
    source: Box<dyn RecordBatchReader + Send>,
    options: Options,
    schema: SchemaRef,
}

impl Answers {
    fn answer(&mut self, cancelled: &AtomicBool) -> Option<Result<RecordBatch, Error>> {
        let batch = self.source.next()?;
        Some(batch.map_err(Error::from).and_then(|batch| fit_batch_until(&batch, &self.options, cancelled)))
    }
}

impl Iterator for Answers {
    type Item = Result<RecordBatch, ArrowError>;

    fn next(&mut self) -> Option<Self::Item> {
        // The caller is a reader in another language: no panic may reach it.
        match caught(|| self.answer(&AtomicBool::new(false))) {
            Ok(answer) => Some(answer?.map_err(|error| ArrowError::ExternalError(Box::new(error)))),
            Err(panic) => Some(Err(ArrowError::ExternalError(bug_report(&*panic).into()))),
        }
    }
}

impl RecordBatchReader for Answers {
    fn schema(&self) -> SchemaRef {
        Arc::clone(&self.schema)
    }
}

impl ArrowStream {
    fn state(&self) -> MutexGuard<'_, State> {
        self.state.lock().unwrap_or_else(PoisonError::into_inner)
    }

    /// The remaining answers, `None` at the end of the stream; the stream is then in the state `taken`.
    fn take(&self, py: Python<'_>, taken: State) -> PyResult<Option<Box<Answers>>> {
        let mut state = self.state();
        let (code, message) = match &*state {
            State::Ready(_) => {
                return Ok(match std::mem::replace(&mut *state, taken) {
                    State::Ready(answers) => Some(answers),
                    _ => None,
                });
            }
            State::Ended => return Ok(None),
            State::Busy => ("busy", "another thread is reading the stream"),
            State::Exported => ("read", "the stream has been read"),
            State::Broken => {
                ("broken_off", "the stream broke off at an error or an interruption: its rest is lost")
            }
        };
        Err(Failure::new(py, "OptionError", code, message).into_error())
    }
}

#[pymethods]
impl ArrowStream {
    /// The answers as a stream of Arrow's C interface; they can be read once.
    #[pyo3(signature = (requested_schema=None))]
    fn __arrow_c_stream__<'py>(
        &self,
        py: Python<'py>,
        requested_schema: Option<Bound<'py, PyAny>>,
    ) -> PyResult<Bound<'py, PyCapsule>> {
        drop(requested_schema);
        let answers = self.take(py, State::Exported)?.ok_or_else(|| {
            Failure::new(py, "OptionError", "read", "the stream has been read").into_error()
        })?;
        export_stream(py, answers)
    }

    /// The types of the columns by Arrow's C interface.
    fn __arrow_c_schema__<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyCapsule>> {
        export_schema(py, &self.schema)
    }

    #[getter]
    fn column_names(&self) -> Vec<String> {
        self.schema.fields().iter().map(|field| field.name().clone()).collect()
    }

    /// The answers to the next batch.
    fn next_batch(&self, py: Python<'_>) -> PyResult<ArrowTable> {
        let Some(mut answers) = self.take(py, State::Busy)? else {
            return Err(PyStopIteration::new_err(()));
        };
        let computed = interruptible_until(py, move |cancelled| {
            let found = answers.answer(cancelled);
            (answers, found)
        });
        let (next, found) = match computed {
            Ok((_, None)) => (State::Ended, Err(PyStopIteration::new_err(()))),
            Ok((answers, Some(Ok(batch)))) => {
                (State::Ready(answers), Ok(ArrowTable { schema: batch.schema(), batches: vec![batch] }))
            }
            Ok((_, Some(Err(error)))) => (State::Broken, Err(batch_error(py, error))),
            Err(interrupted) => (State::Broken, Err(interrupted)),
        };
        *self.state() = next;
        found
    }
}

fn batch_error(py: Python<'_>, error: Error) -> PyErr {
    let message = error.to_string();
    match error {
        Error::NoColumn { name, .. } => {
            Failure::new(py, "OptionError", "no_column", message).with("column", name).into_error()
        }
        Error::AmbiguousColumn { name } => {
            Failure::new(py, "OptionError", "ambiguous_column", message).with("column", name).into_error()
        }
        Error::ColumnType { name, .. } | Error::Extension { name, .. } => {
            Failure::new(py, "OptionError", "column_type", message).with("column", name).into_error()
        }
        Error::Option { option, problem } => {
            let name = keyword(option);
            option_error(py, name, format!("{name}: {problem}"))
        }
        _ => Failure::new(py, "SlipfitError", "arrow", message).with("option", "table").into_error(),
    }
}

/// A number for all rows, or the name of a column.
#[derive(FromPyObject)]
pub(crate) enum PerRow {
    #[pyo3(transparent)]
    Same(f64),
    #[pyo3(transparent)]
    Column(String),
}

impl From<PerRow> for Number {
    fn from(number: PerRow) -> Self {
        match number {
            PerRow::Same(value) => Self::Same(value),
            PerRow::Column(name) => Self::Column(name),
        }
    }
}

/// The contents of the table and how it is fitted.
#[derive(FromPyObject)]
#[pyo3(from_item_all)]
pub(crate) struct BatchChoices {
    amplitude: Option<String>,
    x: Option<String>,
    y: Option<String>,
    signal: Option<String>,
    kind: Option<String>,
    dt: Option<PerRow>,
    time: Option<String>,
    frequency_hz: Option<PerRow>,
    min_amplitude: Option<PerRow>,
    method: String,
    unit: String,
    levels: bool,
    factors: HashMap<String, f64>,
    keep: Vec<String>,
    ringdown: RingdownChoices,
}

impl BatchChoices {
    fn options(self, py: Python<'_>) -> PyResult<Options> {
        let wrong = |option, message: &str| Err(option_error(py, option, message));
        let method = match self.method.as_str() {
            "fit" => Method::Fit,
            "analyse" => Method::Analyse,
            other => return wrong("method", &format!("method={other:?}: one of fit, analyse")),
        };
        if let (Some(kind), None) = (&self.kind, &self.signal) {
            let message = format!("kind={kind:?}: it says what signal=… is, and there is none");
            return wrong("kind", &message);
        }
        let signal = match (self.amplitude, self.x, self.y, self.signal) {
            (Some(name), None, None, None) => Signal::Amplitude(name),
            (None, Some(x), Some(y), None) => Signal::LockIn(x, y),
            (None, None, None, Some(name)) => {
                let kind = match self.kind.as_deref() {
                    None | Some("displacement") => SignalKind::Displacement,
                    Some("velocity") => SignalKind::Velocity,
                    Some("acceleration") => SignalKind::Acceleration,
                    Some(other) => {
                        let message = format!("kind={other:?}: one of displacement, velocity, acceleration");
                        return wrong("kind", &message);
                    }
                };
                Signal::Oscillation(name, kind)
            }
            _ => {
                let message = "name the columns of the traces: amplitude=…, or x=… and y=…, or signal=…";
                return wrong("amplitude", message);
            }
        };
        let clock = match (self.dt, self.time) {
            (Some(dt), None) => Clock::Interval(dt.into()),
            (None, Some(name)) => Clock::Times(name),
            _ => return wrong("dt", "one of dt=… [s], a number or a column, and time=…, a column of lists"),
        };
        let mut options = Options::new(signal, clock, method);
        options.frequency_hz = self.frequency_hz.map(Into::into);
        options.min_amplitude = self.min_amplitude.map(Into::into);
        options.unit = self.unit;
        options.levels = self.levels;
        options.factors = self.factors;
        options.keep = self.keep;
        options.ringdown = self.ringdown.options(py)?;
        Ok(options)
    }
}

/// A table whose batches can be read once.
#[pyclass(frozen, module = "slipfit._core")]
pub(crate) struct Source {
    schema: SchemaRef,
    batches: Mutex<Option<Box<dyn RecordBatchReader + Send>>>,
}

#[pymethods]
impl Source {
    /// Takes a table, after a check of the options.
    #[new]
    fn new(py: Python<'_>, table: &Bound<'_, PyAny>, choices: BatchChoices) -> PyResult<Self> {
        choices.options(py)?;
        let batches = import(table)?;
        Ok(Self { schema: batches.schema(), batches: Mutex::new(Some(batches)) })
    }

    /// Units that the columns state in their metadata, under the keys that the reader of Arrow files uses.
    #[getter]
    fn units(&self) -> HashMap<String, String> {
        let unit = |field: &FieldRef| {
            let stated = field.metadata().get("unit").or_else(|| field.metadata().get("units"))?;
            Some((field.name().clone(), stated.clone()))
        };
        self.schema.fields().iter().filter_map(unit).collect()
    }

    /// Names of the columns whose type includes a unit of time: durations, dates, and lists of them.
    #[getter]
    fn timed(&self) -> Vec<String> {
        let timed = |field: &&FieldRef| {
            let of_values = match plain(field.data_type()) {
                DataType::List(item)
                | DataType::LargeList(item)
                | DataType::FixedSizeList(item, _)
                | DataType::ListView(item)
                | DataType::LargeListView(item) => plain(item.data_type()),
                other => other,
            };
            matches!(of_values, DataType::Duration(_) | DataType::Timestamp(..))
        };
        self.schema.fields().iter().filter(timed).map(|field| field.name().clone()).collect()
    }
}

/// The source, and the schema of its answers.
fn answers(py: Python<'_>, source: &Source, choices: BatchChoices) -> PyResult<Answers> {
    let options = choices.options(py)?;
    // A batch without rows: errors of the table as a whole are reported before any row is read.
    let empty = RecordBatch::new_empty(Arc::clone(&source.schema));
    let answer = uninterrupted(py, || slipfit_batch::fit_batch(&empty, &options))?;
    let schema = answer.map_err(|error| batch_error(py, error))?.schema();
    let source = source
        .batches
        .lock()
        .unwrap_or_else(PoisonError::into_inner)
        .take()
        .ok_or_else(|| Failure::new(py, "OptionError", "read", "the table has been read").into_error())?;
    Ok(Answers { source, options, schema })
}

/// Fits every trace of a table.
#[pyfunction]
pub(crate) fn fit_batch(py: Python<'_>, source: &Source, choices: BatchChoices) -> PyResult<ArrowTable> {
    let mut answers = answers(py, source, choices)?;
    let schema = Arc::clone(&answers.schema);
    let batches = interruptible_until(py, move |cancelled| {
        std::iter::from_fn(|| answers.answer(cancelled)).collect::<Result<Vec<_>, _>>()
    })?;
    Ok(ArrowTable { schema, batches: batches.map_err(|error| batch_error(py, error))? })
}

/// Fits the traces of a stream as they come.
#[pyfunction]
pub(crate) fn fit_stream(py: Python<'_>, source: &Source, choices: BatchChoices) -> PyResult<ArrowStream> {
    let answers = answers(py, source, choices)?;
    let schema = Arc::clone(&answers.schema);
    Ok(ArrowStream { schema, state: Mutex::new(State::Ready(Box::new(answers))) })
}
