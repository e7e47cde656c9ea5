//! Ctrl-C, as a question that long work asks now and then.

use crate::failure::{FAILED, Failure, INTERRUPTED, INTERRUPTION};
use crate::shell;
use std::sync::atomic::{AtomicBool, Ordering};
use std::time::Duration;

/// How long long work may take to notice; then the process ends as if asked twice.
const PATIENCE: Duration = Duration::from_secs(1);

static ASKED: AtomicBool = AtomicBool::new(false);

/// From now on an interrupt or termination signal does not end the process but is remembered, so that what runs can
/// stop in order; a second one ends it, and so does time.
///
/// # Errors
/// The system takes no handler.
pub(crate) fn watch() -> Result<(), Failure> {
    let asked = || {
        if ASKED.swap(true, Ordering::Relaxed) {
            // Whoever asks twice does not wait for what is being computed.
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

/// Ends the process at once. What is half written is removed before anything is told.
fn end(messages: &[String]) -> ! {
    trochoid::discard_partial_files();
    shell::tell(messages);
    std::process::exit(i32::from(INTERRUPTED))
}

/// Whether the user has asked to stop.
pub(crate) fn asked() -> bool {
    ASKED.load(Ordering::Relaxed)
}
