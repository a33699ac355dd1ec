//! Ctrl-C: stop at the next band of rows and leave no partial file; a second one stops at once.

use std::sync::atomic::{AtomicBool, Ordering};

use super::exit::Exit;

static STOP: AtomicBool = AtomicBool::new(false);

/// Listen for Ctrl-C; the flag is set by the first one.
pub(super) fn stop_flag() -> &'static AtomicBool {
    // Without a handler (a second call, or a system that has none) Ctrl-C ends the process at once, as ever.
    let _ = ctrlc::set_handler(|| {
        if STOP.swap(true, Ordering::SeqCst) {
            std::process::exit(Exit::Interrupted as i32);
        }
    });
    &STOP
}
