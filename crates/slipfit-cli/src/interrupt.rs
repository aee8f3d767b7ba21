//! Interrupts (Ctrl-C): a half-written file is removed; a run over many files finishes those it has begun.

use crate::failure::Failure;
use std::path::{Path, PathBuf};
use std::process::exit;
use std::sync::atomic::{AtomicBool, Ordering};
use std::sync::{Mutex, OnceLock, PoisonError};

/// Exit status after an interrupt, as shells have it: 128 and the signal's number.
pub(crate) const INTERRUPTED: u8 = 130;

/// Whether the first interrupt only asks for an end.
static PATIENT: AtomicBool = AtomicBool::new(false);
static ASKED: AtomicBool = AtomicBool::new(false);
/// Files to remove should the program end now.
static UNFINISHED: Mutex<Vec<PathBuf>> = Mutex::new(Vec::new());

/// From here on an interrupt asks for an end; a second one ends the program at once.
pub(crate) fn watch() -> Result<(), Failure> {
    PATIENT.store(true, Ordering::SeqCst);
    handle().map_err(|e| Failure::new(format!("interrupts cannot be handled: {e}")))
}

/// Whether there was one.
pub(crate) fn asked() -> bool {
    ASKED.load(Ordering::SeqCst)
}

fn handle() -> Result<(), String> {
    static HANDLER: OnceLock<Result<(), String>> = OnceLock::new();
    let interrupted = || {
        if !PATIENT.load(Ordering::SeqCst) || ASKED.swap(true, Ordering::SeqCst) {
            let unfinished = UNFINISHED.lock().unwrap_or_else(PoisonError::into_inner);
            for path in unfinished.iter() {
                let _ = std::fs::remove_file(path);
            }
            exit(i32::from(INTERRUPTED));
        }
    };
    HANDLER.get_or_init(|| ctrlc::set_handler(interrupted).map_err(|e| e.to_string())).clone()
}

/// A file that an interrupt removes, as long as this lives.
pub(crate) struct Unfinished(PathBuf);

impl Unfinished {
    pub(crate) fn new(path: &Path) -> Self {
        // Without a handler the file stays where it is: no reason not to write.
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
