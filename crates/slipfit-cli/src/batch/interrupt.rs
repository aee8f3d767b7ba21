//! Ctrl-C: what is done stays, what is being done is finished, nothing else is begun.

use crate::failure::Failure;
use std::process::exit;
use std::sync::atomic::{AtomicBool, Ordering};

/// Exit status after an interrupt, as shells have it: 128 and the signal's number.
pub(crate) const INTERRUPTED: u8 = 130;

static ASKED: AtomicBool = AtomicBool::new(false);

/// Takes interrupts from here on. A second one ends the program at once; the journal has
/// every finished row even so.
pub(crate) fn watch() -> Result<(), Failure> {
    let taken = ctrlc::set_handler(|| {
        if ASKED.swap(true, Ordering::SeqCst) {
            exit(i32::from(INTERRUPTED));
        }
    });
    taken.map_err(|e| Failure::new(format!("interrupts cannot be taken: {e}")))
}

/// Whether there was one.
pub(crate) fn asked() -> bool {
    ASKED.load(Ordering::SeqCst)
}
