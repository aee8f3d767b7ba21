//! Progress display for long work: only on a terminal, on standard error.

use indicatif::{ProgressBar, ProgressDrawTarget, ProgressStyle};
use std::sync::mpsc::{RecvTimeoutError, channel};
use std::thread;
use std::time::Duration;

/// Work that is done within this time shows no progress.
const SPINNER_DELAY: Duration = Duration::from_secs(1);
/// Time between two frames of a spinner.
const TICK: Duration = Duration::from_millis(120);

/// A bar that counts to `length`; `shown` has `{pos}` and `{len}`, or `{bytes}` and `{total_bytes}`.
pub(crate) fn bar(length: u64, shown: &str, quiet: bool) -> ProgressBar {
    let target = if quiet { ProgressDrawTarget::hidden() } else { ProgressDrawTarget::stderr() };
    let bar = ProgressBar::with_draw_target(Some(length), target);
    if let Ok(style) = ProgressStyle::with_template(&format!("{{bar:40}} {shown}, {{eta}} left")) {
        bar.set_style(style);
    }
    bar
}

/// Turns a bar into a spinner with `message`.
pub(crate) fn spin(bar: &ProgressBar, message: &'static str) {
    if let Ok(style) = ProgressStyle::with_template("{spinner} {msg}, {elapsed}") {
        bar.set_style(style);
    }
    bar.set_message(message);
    bar.enable_steady_tick(TICK);
}

/// Does `work`, with a spinner after the first second.
pub(crate) fn with_spinner<T>(message: &'static str, quiet: bool, work: impl FnOnce() -> T) -> T {
    let bar = ProgressBar::with_draw_target(None, ProgressDrawTarget::stderr());
    if quiet || bar.is_hidden() {
        return work();
    }
    thread::scope(|scope| {
        let (done, waiting) = channel::<()>();
        scope.spawn(move || {
            if waiting.recv_timeout(SPINNER_DELAY) == Err(RecvTimeoutError::Timeout) {
                bar.reset_elapsed();
                spin(&bar, message);
                // Returns an error once `done` is dropped, also after a panic.
                let _ = waiting.recv();
                bar.finish_and_clear();
            }
        });
        let result = work();
        drop(done);
        result
    })
}
