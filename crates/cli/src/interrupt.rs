//! Ctrl-C, as a question that long work asks now and then.

use crate::failure::{FAILED, Failure};
use std::sync::atomic::{AtomicBool, Ordering};

static ASKED: AtomicBool = AtomicBool::new(false);

/// From now on an interrupt or termination signal does not end the process but is remembered.
///
/// # Errors
/// The system takes no handler.
pub(crate) fn watch() -> Result<(), Failure> {
    match ctrlc::set_handler(|| ASKED.store(true, Ordering::Relaxed)) {
        Ok(()) | Err(ctrlc::Error::MultipleHandlers) => Ok(()),
        Err(error) => Err(Failure::new(FAILED, format!("interrupts cannot be watched: {error}"))),
    }
}

/// Whether the user has asked to stop.
pub(crate) fn asked() -> bool {
    ASKED.load(Ordering::Relaxed)
}
