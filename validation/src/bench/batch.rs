//! Fit of a table of amplitude traces, compared with SciPy's fit of one trace and with a sum over the same memory.

use std::sync::Arc;

use arrow_array::types::{Float32Type, Float64Type};
use arrow_array::{Array, ArrayRef, ArrowPrimitiveType, FixedSizeListArray, PrimitiveArray, RecordBatch};
use arrow_schema::Field;
use slipfit_batch::{Number, Options, Signal as Column, fit_batch};

use super::contest::{Contestant, Peer, Task, Timing, race};
use super::report::{Row, three_digits};
use super::signal::{Noise, Signal};
use super::{Against, Bench, difference, faster, found_the_decay, words};
use crate::Failure;

const TRACES: usize = 262_144;
const SAMPLES: i32 = 512;
/// Required speed relative to `curve_fit` on one core.
const LEAST_SPEEDUP: f64 = 700.0;
/// Allowed time in units of one sum over the same memory.
const MOST_PASSES: f64 = 3.0;

impl Bench {
    pub(super) fn batches(&self) -> Result<Vec<Row>, Failure> {
        let signal = Signal::envelope(SAMPLES as usize);
        let data = self.doubles(&signal)?;
        let start = signal.envelope_start();
        let mut rows = Vec::new();
        for (name, table) in
            [("doubles", table::<Float64Type>(&signal)?), ("singles", table::<Float32Type>(&signal)?)]
        {
            let mut own = fitted(&table, &signal)?;
            let mut sum = summed(&table)?;
            let script = words(&["curve_fit", &data], &start);
            let mut peer = Peer::start(&self.python, "envelope_fit.py", script)?;
            let contestants: &mut [&mut dyn Contestant] = &mut [&mut own, &mut sum, &mut peer];
            let best = race(self.rounds, contestants)?;
            let [own, sum, peer] = best.as_slice() else { return Err("nobody ran".into()) };
            found_the_decay(&signal, "SciPy", peer)?;
            let each = |timing: &Timing| Timing { seconds: timing.seconds / TRACES as f64, ..timing.clone() };
            let (own, sum) = (each(own), each(sum));
            let work = format!("fit, {TRACES} traces of {SAMPLES} {name}, one core, a trace");
            let scipy = Against { peer: "SciPy `curve_fit`", at_least: Some(LEAST_SPEEDUP) };
            rows.push(faster('p', &work, &own, &scipy, peer, difference(&signal, &own, peer)));
            let memory = Against { peer: "a sum over their memory", at_least: None };
            let ratio = own.seconds / sum.seconds;
            rows.push(Row {
                ratio: three_digits(ratio),
                asked: Some((format!("≤ {MOST_PASSES:.0}"), ratio <= MOST_PASSES)),
                ..faster('p', &work, &own, &memory, &sum, None)
            });
        }
        Ok(rows)
    }
}

/// Traces that differ in their noise; the first is that of line c.
fn table<T>(signal: &Signal) -> Result<RecordBatch, Failure>
where
    T: ArrowPrimitiveType,
    T::Native: FromDouble,
{
    let mut noise = Noise::new(0x0ba7_c4e5);
    let mut values = Vec::with_capacity(TRACES * signal.values.len());
    for trace in 0..TRACES {
        // One random draw per sample would take longer than everything that is timed; each further trace uses the
        // noise of the first, shifted cyclically.
        let turned = if trace == 0 { 0 } else { (noise.normal().abs() * 1e4) as usize % signal.values.len() };
        let rest = signal.values.iter().zip(&signal.time_s).map(|(v, t)| v - signal.truth.amplitude(*t));
        let rest: Vec<f64> = rest.collect();
        let own = rest.iter().cycle().skip(turned);
        let value = |(t, r): (&f64, &f64)| T::Native::of(signal.truth.amplitude(*t) + r);
        values.extend(signal.time_s.iter().zip(own).map(value));
    }
    let values = PrimitiveArray::<T>::from_iter_values(values);
    let item = Arc::new(Field::new("item", T::DATA_TYPE, true));
    let lists: ArrayRef = Arc::new(FixedSizeListArray::try_new(item, SAMPLES, Arc::new(values), None)?);
    Ok(RecordBatch::try_from_iter([("amplitude", lists)])?)
}

/// Conversion of a double to the element type, with loss of precision where necessary.
trait FromDouble {
    fn of(value: f64) -> Self;
}

impl FromDouble for f64 {
    fn of(value: f64) -> Self {
        value
    }
}

impl FromDouble for f32 {
    fn of(value: f64) -> Self {
        value as f32
    }
}

/// Runs work on one thread, because the peers use one.
fn single_thread() -> Result<rayon::ThreadPool, Failure> {
    Ok(rayon::ThreadPoolBuilder::new().num_threads(1).build()?)
}

fn fitted<'a>(table: &'a RecordBatch, signal: &Signal) -> Result<Task<'a>, Failure> {
    let interval = 1.0 / f64::from(SAMPLES);
    let mut options = Options::fit(Column::Amplitude("amplitude".into()), Number::Same(interval));
    options.frequency_hz = Some(Number::Same(signal.truth.frequency_hz));
    let pool = single_thread()?;
    Ok(Task(Box::new(move || {
        let answer = pool.install(|| fit_batch(table, &options))?;
        let first = |name: &str| -> Result<f64, Failure> {
            let column = answer.column_by_name(name).ok_or("a column is missing")?;
            let column = column.as_any().downcast_ref::<PrimitiveArray<Float64Type>>();
            Ok(column.ok_or("a column is of another type")?.value(0))
        };
        Ok(vec![first("decay_rate_per_s")?, first("friction_displacement")?])
    })))
}

/// One pass over the numbers that only adds them.
fn summed(table: &RecordBatch) -> Result<Task<'_>, Failure> {
    fn lanes<T: Copy + Default + std::ops::AddAssign>(values: &[T]) -> [T; 64] {
        let mut lanes = [T::default(); 64];
        for chunk in values.chunks_exact(64) {
            for (lane, value) in lanes.iter_mut().zip(chunk) {
                *lane += *value;
            }
        }
        lanes
    }
    let lists = table.column(0).as_any().downcast_ref::<FixedSizeListArray>();
    let values = lists.ok_or("no fixed-size list")?.values();
    if let Some(doubles) = values.as_any().downcast_ref::<PrimitiveArray<Float64Type>>() {
        return Ok(Task(Box::new(|| Ok(lanes(doubles.values()).to_vec()))));
    }
    let singles = values.as_any().downcast_ref::<PrimitiveArray<Float32Type>>().ok_or("other numbers")?;
    Ok(Task(Box::new(|| Ok(lanes(singles.values()).map(f64::from).to_vec()))))
}
