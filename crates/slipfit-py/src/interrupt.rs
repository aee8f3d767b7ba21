//! Long computations: without the interpreter's lock, stopped by Ctrl-C, and no panic passes.

use crate::failure::Failure;
use pyo3::prelude::*;
use std::any::Any;
use std::panic::{AssertUnwindSafe, catch_unwind};
use std::sync::Arc;
use std::sync::atomic::{AtomicBool, Ordering};
use std::sync::mpsc::{self, RecvTimeoutError};
use std::thread;
use std::time::Duration;

/// How often the interpreter is asked whether a signal has come.
const LOOK: Duration = Duration::from_millis(50);

/// Runs `work` on a thread of its own while this one waits for it or for a signal.
///
/// After a signal the exception of its handler (`KeyboardInterrupt`) is raised at once; the thread
/// ends by itself when its work is done, and what it found is dropped.
pub(crate) fn interruptible<T: Send + 'static>(
    py: Python<'_>,
    work: impl FnOnce() -> T + Send + 'static,
) -> PyResult<T> {
    interruptible_until(py, |_| work())
}

/// [`interruptible`] for work that ends early once it is told to.
pub(crate) fn interruptible_until<T: Send + 'static>(
    py: Python<'_>,
    work: impl FnOnce(&AtomicBool) -> T + Send + 'static,
) -> PyResult<T> {
    let cancelled = Arc::new(AtomicBool::new(false));
    let (sender, mut receiver) = mpsc::channel();
    let told = Arc::clone(&cancelled);
    let worker = move || {
        // Nobody listens after a signal.
        let _ = sender.send(catch_unwind(AssertUnwindSafe(|| work(&told))));
    };
    thread::Builder::new().name("slipfit".to_owned()).spawn(worker)?;
    loop {
        let (back, found) = py.detach(move || {
            let found = receiver.recv_timeout(LOOK);
            (receiver, found)
        });
        receiver = back;
        match found {
            Ok(Ok(value)) => return Ok(value),
            Ok(Err(panic)) => return Err(bug(py, &*panic)),
            Err(RecvTimeoutError::Timeout) => {
                py.check_signals().inspect_err(|_| cancelled.store(true, Ordering::Relaxed))?;
            }
            Err(RecvTimeoutError::Disconnected) => return Err(bug(py, &"its thread was lost")),
        }
    }
}

/// Runs something short without the interpreter's lock.
pub(crate) fn quick<T: Send>(py: Python<'_>, work: impl FnOnce() -> T + Send) -> PyResult<T> {
    py.detach(|| catch_unwind(AssertUnwindSafe(work))).map_err(|panic| bug(py, &*panic))
}

/// A panic is a bug of slipfit, and is said to be one.
fn bug(py: Python<'_>, panic: &(dyn Any + Send)) -> PyErr {
    let text = panic.downcast_ref::<&str>().map(ToString::to_string);
    let text = text.or_else(|| panic.downcast_ref::<String>().cloned()).unwrap_or_default();
    Failure::new(
        py,
        "SlipfitError",
        "internal",
        format!("this is a bug of slipfit, please report it: {text}"),
    )
    .into_error()
}
