//! Work that takes long: it runs on a thread of its own, while the calling thread answers Ctrl-C and tells about progress.

use pyo3::exceptions::PyOSError;
use pyo3::prelude::*;
use std::panic::resume_unwind;
use std::sync::atomic::{AtomicBool, Ordering};
use std::sync::{Arc, Condvar, Mutex, PoisonError};
use std::time::{Duration, Instant};
use trochoid::Monitor;
use trochoid_cli::Host;

/// Longest time until an interrupt is noticed, and between two calls of a progress function.
const PAUSE: Duration = Duration::from_millis(20);
/// Longest time between two calls of a progress function, also where one node takes long and nothing goes on: its answer may
/// stop the work.
const LONGEST: Duration = Duration::from_millis(250);
/// Stack of the work: that of a program's first thread.
const STACK: usize = 8 << 20;

/// What the work and the calling thread know of each other.
#[derive(Default)]
pub(crate) struct Watch {
    state: Mutex<State>,
    ended: Condvar,
    is_to_stop: AtomicBool,
}

#[derive(Clone, Copy, Default)]
struct State {
    /// How much is done, of how much.
    done: Option<(u64, u64)>,
    has_ended: bool,
}

impl Watch {
    fn tell(&self, done: u64, total: u64) {
        let mut state = self.state.lock().unwrap_or_else(PoisonError::into_inner);
        // Threads may overtake each other; what begins anew begins at 0.
        let is_late = state.done.is_some_and(|(before, of)| of == total && done < before && done > 0);
        if !is_late {
            state.done = Some((done, total));
        }
    }

    /// Waits a moment, or until the work ends.
    fn wait(&self) -> State {
        let state = self.state.lock().unwrap_or_else(PoisonError::into_inner);
        let waited = self.ended.wait_timeout_while(state, PAUSE, |state| !state.has_ended);
        *waited.unwrap_or_else(PoisonError::into_inner).0
    }
}

/// Says that the work has ended, also if it panics.
struct End<'w>(&'w Watch);

impl Drop for End<'_> {
    fn drop(&mut self) {
        self.0.state.lock().unwrap_or_else(PoisonError::into_inner).has_ended = true;
        self.0.ended.notify_all();
    }
}

impl Monitor for Watch {
    fn progress(&self, done: usize, total: usize) {
        self.tell(done as u64, total as u64);
    }

    fn cancelled(&self) -> bool {
        self.is_to_stop.load(Ordering::Relaxed)
    }
}

impl Host for Watch {
    fn progress(&self, done: u64, total: u64) {
        self.tell(done, total);
    }

    fn cancelled(&self) -> bool {
        self.is_to_stop.load(Ordering::Relaxed)
    }
}

/// Does some work while other threads of Python run. `progress(done, total)` is called now and then; if it returns
/// something false but `None`, the work is asked to stop. What it raises, or the handler of a signal, is raised once the work has stopped.
pub(crate) fn watched<T: Send>(
    py: Python<'_>,
    progress: Option<&Bound<'_, PyAny>>,
    work: impl FnOnce(&Arc<Watch>) -> T + Send,
) -> PyResult<T> {
    let watch = Arc::new(Watch::default());
    std::thread::scope(|scope| {
        let own = &watch;
        let worker = std::thread::Builder::new().name("trochoid".into()).stack_size(STACK);
        let worker = worker.spawn_scoped(scope, move || {
            let _end = End(own);
            work(own)
        });
        let worker = worker.map_err(|error| PyOSError::new_err(format!("a thread cannot be started: {error}")))?;
        let (mut told, mut last, mut raised) = (None, Instant::now(), None);
        loop {
            let state = py.detach(|| watch.wait());
            let mut call = || {
                py.check_signals()?;
                // Before anything is known, nothing is done of something.
                let is_due = last.elapsed() >= LONGEST && !state.has_ended;
                let done = state.done.or(is_due.then_some((0, 1)));
                match (progress, done) {
                    (Some(progress), Some(done)) if is_due || told != Some(done) => {
                        last = Instant::now();
                        let answer = progress.call1(done)?;
                        Ok(answer.is_none() || answer.is_truthy()?)
                    }
                    _ => Ok(true),
                }
            };
            if !watch.is_to_stop.load(Ordering::Relaxed) {
                let answer = call();
                told = state.done;
                if !matches!(answer, Ok(true)) {
                    watch.is_to_stop.store(true, Ordering::Relaxed);
                }
                raised = answer.err();
            }
            if state.has_ended {
                break;
            }
        }
        match (py.detach(|| worker.join()), raised) {
            (Err(panic), _) => resume_unwind(panic),
            (_, Some(raised)) => Err(raised),
            (Ok(made), None) => Ok(made),
        }
    })
}
