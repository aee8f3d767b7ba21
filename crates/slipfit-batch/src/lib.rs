//! Ring-downs by the million: Arrow in, Arrow out, one row per trace.
//!
//! [`fit_batch`] takes a record batch with a column of lists (list, large list or fixed-size list of any number
//! type), one trace per row, and returns one row for each, in the same order: parameters, standard errors,
//! intervals, evidence, warnings, and a status. A row that cannot be fitted is returned with the reason.
//! Interfaces (a Python package, a table engine) only pass batches on.
//!
//! [`Method::Fit`] fits one loss model, viscous and sliding, to amplitudes by
//! [`slipfit::ringdown::fit_amplitudes`]; [`Method::Analyse`] is the whole default analysis of each row, as the
//! command performs it on a file.
//!
//! ```
//! use arrow_array::types::Float64Type;
//! use arrow_array::{ListArray, RecordBatch, cast::AsArray};
//! use slipfit_batch::{Number, Options, Signal, fit_batch};
//! use std::sync::Arc;
//!
//! let trace = |sliding: f64| Some((0..200).map(move |i| Some(1.0 - 0.01 * sliding * f64::from(i))));
//! let traces = ListArray::from_iter_primitive::<Float64Type, _, _>([trace(0.1), None, trace(0.2)]);
//! let batch = RecordBatch::try_from_iter([("amplitude", Arc::new(traces) as _)])?;
//!
//! let options = Options::fit(Signal::Amplitude("amplitude".into()), Number::Same(0.01));
//! let answer = fit_batch(&batch, &options)?;
//! let rate = answer["sliding_rate"].as_primitive::<Float64Type>();
//! assert!((rate.value(2) - 0.2).abs() < 1e-9);
//! assert_eq!(answer["status"].as_string::<i32>().value(1), "failed");
//! assert_eq!(answer["reason"].as_string::<i32>().value(1), "the trace is null");
//! # Ok::<(), Box<dyn std::error::Error>>(())
//! ```

mod analyse;
mod answer;
mod error;
mod fit;
mod map;
mod options;
mod table;
mod trace;

pub use error::Error;
pub use map::{Grid, fit_pixels};
pub use options::{Clock, Method, Number, Options, Signal};
pub use table::schema;
pub use trace::plain;

use arrow_array::RecordBatch;
use rayon::prelude::*;
use std::sync::atomic::{AtomicBool, Ordering};
use table::Columns;
use trace::{Input, Scratch};

/// Number of rows fitted by one task.
const ROWS: usize = 1024;
/// Number of rows fitted and then written to the columns at a time, so that their answers stay in a near cache.
const AT_ONCE: usize = 128;
/// Tasks per thread if each row is a whole analysis, so that no thread waits long for another.
const TASKS: usize = 8;

/// Returns one row of answer for each row of a batch.
///
/// # Errors
/// [`Error`] if the table as a whole cannot be used: a column is missing or of another type, or an option is out
/// of range. A problem of one row is reported in that row.
pub fn fit_batch(batch: &RecordBatch, options: &Options) -> Result<RecordBatch, Error> {
    fit_batch_until(batch, options, &AtomicBool::new(false))
}

/// [`fit_batch`] that ends early, with [`Error::Cancelled`], once `cancelled` is set.
///
/// # Errors
/// As [`fit_batch`].
pub fn fit_batch_until(
    batch: &RecordBatch,
    options: &Options,
    cancelled: &AtomicBool,
) -> Result<RecordBatch, Error> {
    options.check()?;
    let input = Input::new(batch, options)?;
    let rows = batch.num_rows();
    let share = rows.div_ceil(TASKS * rayon::current_num_threads()).max(1);
    let size = match options.method {
        Method::Fit => ROWS,
        Method::Analyse => share.min(ROWS),
    };
    let mut answer = Columns::new(options.method, rows);
    let together = (options.method == Method::Fit).then(|| fit::even_traces(&input)).flatten();
    let remainders: Vec<_> = answer
        .parts(size)
        .into_par_iter()
        .map_init(Scratch::default, |scratch, mut part| {
            let range = part.first()..rows.min(part.first() + size);
            for first in range.clone().step_by(AT_ONCE) {
                let some = first..range.end.min(first + AT_ONCE);
                match options.method {
                    _ if cancelled.load(Ordering::Relaxed) => break,
                    Method::Fit => fit::rows(&input, some, scratch, together.as_ref(), &mut part),
                    Method::Analyse => {
                        some.take_while(|_| !cancelled.load(Ordering::Relaxed)).for_each(|row| {
                            part.write(row, &analyse::row(&input, row, scratch, &options.ringdown))
                        })
                    }
                }
            }
            part.remainder()
        })
        .collect();
    if cancelled.load(Ordering::Relaxed) {
        return Err(Error::Cancelled);
    }
    answer.joined(&remainders, batch, options)
}
