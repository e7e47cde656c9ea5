//! Ctrl-C as a flag that long work polls. A host has its own way to stop.

use crate::failure::{FAILED, Failure, INTERRUPTED, INTERRUPTION};
use crate::{host, shell};
use std::sync::atomic::{AtomicBool, Ordering};
use std::time::Duration;

/// Time that work has to stop after an interrupt; then the process ends as after a second one.
const PATIENCE: Duration = Duration::from_secs(1);

static ASKED: AtomicBool = AtomicBool::new(false);

/// Installs a handler that records the first interrupt or termination signal instead of ending the process, so that
/// work can stop in order. A second signal ends the process, and so does the end of [`PATIENCE`].
///
/// # Errors
/// The system does not accept the handler.
pub(crate) fn watch() -> Result<(), Failure> {
    if host::is_there() {
        return Ok(());
    }
    let asked = || {
        if ASKED.swap(true, Ordering::Relaxed) {
            // After a second signal the process does not wait for running work.
            end(&[]);
        }
        std::thread::spawn(|| {
            std::thread::sleep(PATIENCE);
            end(&[format!("error: {INTERRUPTION}")]);
        });
    };
    match ctrlc::set_handler(asked) {
        Ok(()) | Err(ctrlc::Error::MultipleHandlers) => Ok(()),
        Err(error) => Err(Failure::new(FAILED, format!("interrupts cannot be watched: {error}"))),
    }
}

/// Ends the process at once. Partial files are removed before messages are printed.
fn end(messages: &[String]) -> ! {
    trochoid::discard_partial_files();
    shell::tell(messages);
    std::process::exit(i32::from(INTERRUPTED))
}

/// Returns whether the user has asked to stop.
pub(crate) fn asked() -> bool {
    ASKED.load(Ordering::Relaxed) || host::cancelled()
}
