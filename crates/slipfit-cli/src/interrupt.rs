//! Interrupts (Ctrl-C): a half-written file is removed; a run over many files finishes the files it has begun, if
//! that takes less than a second.

use crate::failure::Failure;
use std::path::{Path, PathBuf};
use std::process::exit;
use std::sync::atomic::{AtomicBool, Ordering};
use std::sync::{Mutex, OnceLock, PoisonError};
use std::thread::sleep;
use std::time::{Duration, Instant};

/// Exit status after an interrupt, by the convention of shells: 128 plus the number of the signal.
pub(crate) const INTERRUPTED: u8 = 130;

/// Whether the first interrupt only requests an end.
static GRACEFUL: AtomicBool = AtomicBool::new(false);
static STOP_REQUESTED: AtomicBool = AtomicBool::new(false);
/// Whether the analyses are finished: the rest is quick and completes the outputs.
static COMPLETING: AtomicBool = AtomicBool::new(false);
/// Time allowed after an interrupt for the files that have been begun.
const GRACE_PERIOD: Duration = Duration::from_millis(700);
/// Files to remove if the program ends now.
static UNFINISHED: Mutex<Vec<PathBuf>> = Mutex::new(Vec::new());

/// From here on, an interrupt ends the program with [`INTERRUPTED`] and removes half-written files.
pub(crate) fn begin() {
    // Without a handler, the system ends the program.
    let _ = handle();
}

/// The files are done: one interrupt no longer stops what follows, a second one does.
pub(crate) fn begin_completion() {
    COMPLETING.store(true, Ordering::SeqCst);
}

/// From here on, an interrupt requests an end; a second one ends the program at once.
pub(crate) fn enable_graceful_stop() -> Result<(), Failure> {
    GRACEFUL.store(true, Ordering::SeqCst);
    handle().map_err(|e| Failure::new(format!("interrupts cannot be handled: {e}")))
}

/// Whether an end was requested.
pub(crate) fn stop_requested() -> bool {
    STOP_REQUESTED.load(Ordering::SeqCst)
}

fn handle() -> Result<(), String> {
    static HANDLER: OnceLock<Result<(), String>> = OnceLock::new();
    let interrupted = || {
        if GRACEFUL.load(Ordering::SeqCst) && !STOP_REQUESTED.swap(true, Ordering::SeqCst) {
            let asked = Instant::now();
            while asked.elapsed() < GRACE_PERIOD {
                if COMPLETING.load(Ordering::SeqCst) {
                    return;
                }
                sleep(Duration::from_millis(10));
            }
        }
        let unfinished = UNFINISHED.lock().unwrap_or_else(PoisonError::into_inner);
        for path in unfinished.iter() {
            let _ = std::fs::remove_file(path);
        }
        exit(i32::from(INTERRUPTED));
    };
    HANDLER.get_or_init(|| ctrlc::set_handler(interrupted).map_err(|e| e.to_string())).clone()
}

/// A file that an interrupt removes while this value exists.
pub(crate) struct Unfinished(PathBuf);

impl Unfinished {
    pub(crate) fn new(path: &Path) -> Self {
        // Without a handler the file stays where it is, which is no reason not to write it.
        let _ = handle();
        UNFINISHED.lock().unwrap_or_else(PoisonError::into_inner).push(path.to_owned());
        Self(path.to_owned())
    }
}

impl Drop for Unfinished {
    fn drop(&mut self) {
        UNFINISHED.lock().unwrap_or_else(PoisonError::into_inner).retain(|path| *path != self.0);
    }
}
