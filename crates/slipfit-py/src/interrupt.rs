//! Long computations: they run without the interpreter lock and are stopped by Ctrl-C; panics are caught.

use crate::failure::Failure;
use pyo3::prelude::*;
use rayon::{ThreadPool, ThreadPoolBuilder};
use std::any::Any;
use std::panic::{AssertUnwindSafe, catch_unwind};
use std::sync::atomic::{AtomicBool, Ordering};
use std::sync::mpsc::{self, RecvTimeoutError};
use std::sync::{Arc, Mutex, OnceLock, PoisonError};
use std::thread;
use std::time::Duration;

/// Interval at which the interpreter is asked whether a signal has arrived.
const SIGNAL_CHECK_INTERVAL: Duration = Duration::from_millis(50);

/// Runs `work` on a separate thread while this one waits for it or for a signal.
///
/// After a signal, the exception of its handler (`KeyboardInterrupt`) is raised at once; the thread ends when its
/// work is done, and its result is dropped.
pub(crate) fn interruptible<T: Send + 'static>(
    py: Python<'_>,
    work: impl FnOnce() -> T + Send + 'static,
) -> PyResult<T> {
    interruptible_until(py, |_| work())
}

/// [`interruptible`] for work that ends early when it is told to.
pub(crate) fn interruptible_until<T: Send + 'static>(
    py: Python<'_>,
    work: impl FnOnce(&AtomicBool) -> T + Send + 'static,
) -> PyResult<T> {
    let cancelled = Arc::new(AtomicBool::new(false));
    let (sender, mut receiver) = mpsc::channel();
    let stop_flag = Arc::clone(&cancelled);
    let worker = move || {
        // After a signal, nobody receives the result.
        let _ = sender.send(caught(move || work(&stop_flag)));
    };
    thread::Builder::new().name("slipfit".to_owned()).spawn(worker)?;
    loop {
        let (back, found) = py.detach(move || {
            let found = receiver.recv_timeout(SIGNAL_CHECK_INTERVAL);
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

/// Runs something short without the interpreter lock.
pub(crate) fn uninterrupted<T: Send>(py: Python<'_>, work: impl FnOnce() -> T + Send) -> PyResult<T> {
    py.detach(|| caught(work)).map_err(|panic| bug(py, &*panic))
}

/// The result of `work`, run on the threads of this process, or its panic.
pub(crate) fn caught<T: Send>(work: impl FnOnce() -> T + Send) -> thread::Result<T> {
    catch_unwind(AssertUnwindSafe(|| match forked_pool() {
        Some(pool) => pool.install(work),
        None => work(),
    }))
}

/// The thread pool of a process that was forked from one that had computed: the threads of rayon's global pool
/// remained in its parent, and work given to them would never be done. `None` in any other process.
fn forked_pool() -> Option<Arc<ThreadPool>> {
    static FIRST: OnceLock<u32> = OnceLock::new();
    static POOL: Mutex<Option<(u32, Arc<ThreadPool>)>> = Mutex::new(None);
    let process = std::process::id();
    if *FIRST.get_or_init(|| process) == process {
        return None;
    }
    let mut held = POOL.lock().unwrap_or_else(PoisonError::into_inner);
    match &*held {
        Some((owner, pool)) if *owner == process => Some(Arc::clone(pool)),
        _ => {
            let built = ThreadPoolBuilder::new().build();
            let pool = Arc::new(built.unwrap_or_else(|error| panic!("no threads can be started: {error}")));
            // A pool of the parent has no threads here that could be told to end.
            std::mem::forget(held.replace((process, Arc::clone(&pool))));
            Some(pool)
        }
    }
}

/// A panic is a bug of slipfit, and is reported as one.
fn bug(py: Python<'_>, panic: &(dyn Any + Send)) -> PyErr {
    Failure::new(py, "SlipfitError", "internal", bug_report(panic)).into_error()
}

/// The message of a panic.
pub(crate) fn bug_report(panic: &(dyn Any + Send)) -> String {
    let text = panic.downcast_ref::<&str>().map(ToString::to_string);
    let text = text.or_else(|| panic.downcast_ref::<String>().cloned()).unwrap_or_default();
    format!("this is a bug of slipfit, please report it: {text}")
}
