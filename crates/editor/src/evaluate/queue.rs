//! What waits for the thread that evaluates, the more urgent first, and when it has to stop what it does.

use super::blame::Question;
use super::request::Job;
use super::shown::Display;
use super::subject::Subject;
use std::collections::VecDeque;
use std::sync::atomic::{AtomicU64, Ordering};
use std::sync::{Arc, Condvar, Mutex, MutexGuard, PoisonError};
use std::time::{Duration, Instant};
use trochoid::{Monitor, Picture, WorkingSpace};

/// What is asked for and not begun.
#[derive(Default)]
pub(super) struct Requests {
    pub(super) job: Option<Job>,
    pub(super) shown: Option<(u64, Arc<Picture>, WorkingSpace, Display)>,
    pub(super) held: Option<(u64, Arc<Picture>, WorkingSpace, Display)>,
    pub(super) question: Option<Question>,
    pub(super) thumbnails: Option<(Subject, i64)>,
    pub(super) ahead: VecDeque<Job>,
    /// The frame that is being made ahead, and whose it is.
    pub(super) making: Option<(u64, i64)>,
    pub(super) closed: bool,
}

impl Requests {
    /// What is next.
    fn take(&mut self) -> Option<Task> {
        // What is held goes first, so that both change as one.
        if let Some((number, picture, space, display)) = self.held.take() {
            Some(Task::Held(number, picture, space, display))
        } else if let Some((generation, picture, space, display)) = self.shown.take() {
            Some(Task::Show(generation, picture, space, display))
        } else if let Some(job) = self.job.take() {
            Some(Task::Picture(job))
        } else if let Some(question) = self.question.take() {
            Some(Task::Blame(question))
        } else if let Some(job) = self.ahead.pop_front() {
            // Frames are waited for; small pictures of nodes are not.
            self.making = Some((job.generation, job.frame));
            Some(Task::Ahead(job))
        } else {
            self.thumbnails.take().map(|(subject, frame)| Task::Thumbnails(subject, frame))
        }
    }

    /// Whether something waits that is looked at now.
    fn is_urgent(&self) -> bool {
        self.job.is_some() || self.shown.is_some() || self.held.is_some() || self.question.is_some()
    }
}

/// The jobs of the worker, which its handle adds and its thread takes.
#[derive(Default)]
pub(super) struct Queue {
    requests: Mutex<Requests>,
    /// Wakes the thread where something is asked for.
    wake_up: Condvar,
    /// Grows with everything that makes what is being done out of date.
    newest: AtomicU64,
    /// Milliseconds that each picture takes besides, for tests.
    #[cfg(test)]
    pace: AtomicU64,
}

impl Queue {
    /// Waits as long as each picture takes besides.
    #[cfg(test)]
    pub(super) fn pace(&self, cancelled: impl Fn() -> bool) {
        let pace = Duration::from_millis(self.pace.load(Ordering::Relaxed));
        let started = Instant::now();
        while started.elapsed() < pace && !cancelled() {
            std::thread::sleep(Duration::from_millis(1));
        }
    }

    /// Lets each picture take so long besides.
    #[cfg(test)]
    pub(super) fn slow_down(&self, by: Duration) {
        self.pace.store(by.as_millis() as u64, Ordering::Relaxed);
    }

    pub(super) fn requests(&self) -> MutexGuard<'_, Requests> {
        self.requests.lock().unwrap_or_else(PoisonError::into_inner)
    }

    /// Changes what waits, and wakes the thread; `cancels` says whether what is being done is out of date then.
    pub(super) fn change(&self, cancels: bool, change: impl FnOnce(&mut Requests)) {
        change(&mut self.requests());
        if cancels {
            self.newest.fetch_add(1, Ordering::Relaxed);
        }
        self.wake_up.notify_one();
    }

    /// The most urgent task, waited for; `None` once there will be no more.
    pub(super) fn next(&self) -> Option<Task> {
        let mut requests = self.requests();
        loop {
            if requests.closed {
                return None;
            }
            if let Some(task) = requests.take() {
                return Some(task);
            }
            requests = self.wake_up.wait(requests).unwrap_or_else(PoisonError::into_inner);
        }
    }

    /// What is begun now is out of date once this is another.
    pub(super) fn stamp(&self) -> u64 {
        self.newest.load(Ordering::Relaxed)
    }
}

/// Something to be done.
pub(super) enum Task {
    Picture(Job),
    Show(u64, Arc<Picture>, WorkingSpace, Display),
    Held(u64, Arc<Picture>, WorkingSpace, Display),
    Blame(Question),
    Thumbnails(Subject, i64),
    Ahead(Job),
}

/// Tells how far an evaluation is, but not more often than anybody can see.
pub(super) struct Progress<'t> {
    tell: &'t (dyn Fn(f32) + Sync),
    last: Mutex<Instant>,
}

impl<'t> Progress<'t> {
    pub(super) fn new(tell: &'t (dyn Fn(f32) + Sync)) -> Self {
        Self { tell, last: Mutex::new(Instant::now()) }
    }
}

/// What is more urgent, and comes between.
#[derive(Clone, Copy, PartialEq, Eq)]
pub(super) enum Yields {
    /// Nothing.
    Never,
    /// What is looked at now.
    Short,
    /// Frames that come next, too.
    Always,
}

/// Stops what is out of date.
pub(super) struct Cancellation<'o> {
    pub(super) queue: &'o Queue,
    pub(super) stamp: u64,
    pub(super) yields: Yields,
    pub(super) progress: Option<&'o Progress<'o>>,
}

impl Monitor for Cancellation<'_> {
    fn progress(&self, done: usize, total: usize) {
        let Some(told) = self.progress else { return };
        let mut last = told.last.lock().unwrap_or_else(PoisonError::into_inner);
        if last.elapsed() > Duration::from_millis(60) {
            *last = Instant::now();
            (told.tell)(done as f32 / total.max(1) as f32);
        }
    }

    fn cancelled(&self) -> bool {
        self.queue.stamp() != self.stamp
            || (self.yields != Yields::Never && {
                let requests = self.queue.requests();
                requests.is_urgent() || (self.yields == Yields::Always && !requests.ahead.is_empty())
            })
    }
}
