//! Guard around third-party decoders that panic on some corrupt files.

use std::any::Any;
use std::cell::Cell;
use std::panic::{AssertUnwindSafe, catch_unwind};

#[cfg(any(feature = "arrow", feature = "hdf5"))]
use super::unpack::BUDGET;
use crate::{error::ReadProblem, format::Format};

thread_local! {
    static GUARDED: Cell<bool> = const { Cell::new(false) };
}

/// Whether this thread runs a decoder whose panic becomes a [`ReadProblem::Broken`].
///
/// A program that should not print the message of such a panic to stderr checks this in its panic hook.
#[must_use]
pub fn panic_becomes_error() -> bool {
    GUARDED.get()
}

/// Runs a decoder; data left invalid by a panic are not used again.
pub(crate) fn guarded<T, E>(
    format: Format,
    decode: impl FnOnce() -> Result<T, E>,
    problem: impl FnOnce(E) -> ReadProblem,
) -> Result<T, ReadProblem> {
    let before = GUARDED.replace(true);
    let outcome = catch_unwind(AssertUnwindSafe(decode));
    GUARDED.set(before);
    match outcome {
        Ok(done) => done.map_err(problem),
        Err(panic) => Err(ReadProblem::Broken {
            format,
            reason: format!("its decoder gave up: {}", panic_message(&*panic)),
        }),
    }
}

/// Memory that any file may request.
#[cfg(any(feature = "arrow", feature = "hdf5"))]
const SMALL: usize = 1 << 24;

/// Maximum number of bytes to which `packed` bytes may unpack: the limit of their compression, but at most [`BUDGET`]
/// or, for a file larger than that, a few times its size.
#[cfg(any(feature = "arrow", feature = "hdf5"))]
pub(crate) fn budget(packed: usize, most_times: usize) -> usize {
    let affordable = BUDGET.max(packed.saturating_mul(8));
    packed.saturating_mul(most_times).min(affordable).max(SMALL)
}

fn panic_message(panic: &(dyn Any + Send)) -> &str {
    let text = panic.downcast_ref::<&str>().copied();
    text.or_else(|| panic.downcast_ref::<String>().map(String::as_str)).unwrap_or("without a word")
}
