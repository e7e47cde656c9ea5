//! Other programs that run commands within their own process: what is printed is collected, interrupts are theirs, and
//! progress is told to them.
//!
//! What a run prints, and whether it is to stop, comes from any thread that works for it, so it is known to the whole
//! process; therefore runs come one after another.

use anstream::adapter::strip_str;
use std::fmt::Display;
use std::sync::{Arc, Mutex, PoisonError, RwLock};

/// A program that runs commands within its own process ([`run`](crate::run)).
///
/// Its functions are called from any thread. They must not run commands themselves.
pub trait Host: Send + Sync {
    /// Tells how much of a run is done, in steps; a run of several frames has as many steps for each.
    fn progress(&self, done: u64, total: u64) {
        let _ = (done, total);
    }

    /// Returns whether the run is to stop: it then ends soon, with code 130, and leaves no partial files.
    fn cancelled(&self) -> bool {
        false
    }
}

/// What became of a run.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
#[non_exhaustive]
pub struct Outcome {
    /// The program's exit code: 0 success; 1 input, output or the evaluation failed, or input data are bad; 2 wrong usage
    /// or an invalid document; 3 a required guarantee or tolerance is not met, or a certificate does not hold; 130
    /// cancelled.
    pub code: u8,
    /// What the program prints on stdout, without colors.
    pub text: String,
    /// What the program prints on stderr, without colors: errors, warnings and notes, some with a second line
    /// `  remedy: …`.
    pub messages: Vec<String>,
}

/// A run within another program.
struct Run {
    host: Arc<dyn Host>,
    printed: Mutex<Outcome>,
}

static RUN: RwLock<Option<Arc<Run>>> = RwLock::new(None);
static ONE_AT_A_TIME: Mutex<()> = Mutex::new(());

fn current() -> Option<Arc<Run>> {
    RUN.read().unwrap_or_else(PoisonError::into_inner).clone()
}

/// Removes the run when it ends, also by a panic.
struct Ended;

impl Drop for Ended {
    fn drop(&mut self) {
        *RUN.write().unwrap_or_else(PoisonError::into_inner) = None;
    }
}

/// Runs a command for a host. `run` returns its exit code.
pub(crate) fn hosted(host: Arc<dyn Host>, run: impl FnOnce() -> u8) -> Outcome {
    let _alone = ONE_AT_A_TIME.lock().unwrap_or_else(PoisonError::into_inner);
    let own = Arc::new(Run { host, printed: Mutex::default() });
    *RUN.write().unwrap_or_else(PoisonError::into_inner) = Some(own.clone());
    let ended = Ended;
    let code = run();
    drop(ended);
    let printed = std::mem::take(&mut *own.printed.lock().unwrap_or_else(PoisonError::into_inner));
    Outcome { code, ..printed }
}

/// Whether another program runs this command.
pub(crate) fn is_there() -> bool {
    current().is_some()
}

/// Whether the host asks to stop.
pub(crate) fn cancelled() -> bool {
    current().is_some_and(|run| run.host.cancelled())
}

/// Tells the host how much is done.
pub(crate) fn progress(done: u64, total: u64) {
    if let Some(run) = current() {
        run.host.progress(done, total);
    }
}

/// Takes a result; returns `false` if there is no host, and it is to be printed.
pub(crate) fn takes_text(text: &str) -> bool {
    with_printed(|printed| strip_str(text).for_each(|piece| printed.text.push_str(piece)))
}

/// Takes messages; returns `false` if there is no host, and they are to be printed.
pub(crate) fn takes_messages<'m, M: Display + 'm>(messages: impl IntoIterator<Item = &'m M>) -> bool {
    with_printed(|printed| printed.messages.extend(messages.into_iter().map(ToString::to_string)))
}

fn with_printed(add: impl FnOnce(&mut Outcome)) -> bool {
    let run = current();
    if let Some(run) = &run {
        add(&mut run.printed.lock().unwrap_or_else(PoisonError::into_inner));
    }
    run.is_some()
}
