//! Pending requests for the threads by urgency, and the cancellation of tasks.

use super::blame::Question;
use super::request::Job;
use super::shown::Display;
use super::subject::Subject;
use std::collections::VecDeque;
use std::sync::atomic::{AtomicU64, Ordering};
use std::sync::{Arc, Condvar, Mutex, MutexGuard, PoisonError};
use std::time::{Duration, Instant};
use trochoid::{Monitor, Picture, WorkingSpace};

/// Requests that have not been started.
#[derive(Default)]
pub(super) struct Requests {
    pub(super) job: Option<Job>,
    pub(super) shown: Option<(u64, Arc<Picture>, WorkingSpace, Display)>,
    pub(super) held: Option<(u64, Arc<Picture>, WorkingSpace, Display)>,
    pub(super) question: Option<Question>,
    /// Picture whose recipe is wanted, if that of another text may do.
    pub(super) known_mixture: Option<Job>,
    /// Picture whose recipe must be evaluated.
    pub(super) mixture: Option<Job>,
    pub(super) thumbnails: Option<(Subject, i64)>,
    pub(super) ahead: VecDeque<Job>,
    /// Generation and frame being evaluated ahead.
    pub(super) making: Option<(u64, i64)>,
    pub(super) closed: bool,
}

impl Requests {
    /// Removes and returns the most urgent task.
    fn take(&mut self) -> Option<Task> {
        // The held picture goes first, so that both change together.
        if let Some((number, picture, space, display)) = self.held.take() {
            Some(Task::Held(number, picture, space, display))
        } else if let Some((generation, picture, space, display)) = self.shown.take() {
            Some(Task::Show(generation, picture, space, display))
        } else if let Some(job) = self.job.take() {
            Some(Task::Picture(job))
        } else if let Some(question) = self.question.take() {
            Some(Task::Blame(question))
        } else if let Some(job) = self.ahead.pop_front() {
            // Playback waits for frames; nothing waits for thumbnails.
            self.making = Some((job.generation, job.frame));
            Some(Task::Ahead(job))
        } else if let Some(job) = self.mixture.take() {
            Some(Task::Mixture(job))
        } else {
            self.thumbnails.take().map(|(subject, frame)| Task::Thumbnails(subject, frame))
        }
    }

    /// Returns whether a request for the visible picture is pending.
    fn is_urgent(&self) -> bool {
        let is_painted = self.job.is_some() || self.shown.is_some() || self.held.is_some();
        is_painted || self.question.is_some()
    }
}

/// Queue of the worker: its handle adds requests, its thread takes them.
#[derive(Default)]
pub(super) struct Queue {
    requests: Mutex<Requests>,
    /// Wakes the threads when a request arrives.
    wake_up: Condvar,
    /// Incremented by every request that makes the running task obsolete.
    newest: AtomicU64,
    /// Extra milliseconds per picture, for tests.
    #[cfg(test)]
    pace: AtomicU64,
}

impl Queue {
    /// Waits for the extra time per picture.
    #[cfg(test)]
    pub(super) fn pace(&self, cancelled: impl Fn() -> bool) {
        let pace = Duration::from_millis(self.pace.load(Ordering::Relaxed));
        let started = Instant::now();
        while started.elapsed() < pace && !cancelled() {
            std::thread::sleep(Duration::from_millis(1));
        }
    }

    /// Sets the extra time per picture.
    #[cfg(test)]
    pub(super) fn slow_down(&self, by: Duration) {
        self.pace.store(by.as_millis() as u64, Ordering::Relaxed);
    }

    pub(super) fn requests(&self) -> MutexGuard<'_, Requests> {
        self.requests.lock().unwrap_or_else(PoisonError::into_inner)
    }

    /// Changes the pending requests and wakes the threads; `cancels` makes the running task obsolete.
    pub(super) fn change(&self, cancels: bool, change: impl FnOnce(&mut Requests)) {
        let mut requests = self.requests();
        change(&mut requests);
        if cancels {
            self.newest.fetch_add(1, Ordering::Relaxed);
        }
        drop(requests);
        self.wake_up.notify_all();
    }

    /// Waits for the most urgent task; returns `None` once the queue is closed.
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

    /// Waits for a request of a recipe that may be known, and returns it with its stamp; `None` once the queue is closed.
    pub(super) fn next_known(&self) -> Option<(Job, u64)> {
        let mut requests = self.requests();
        loop {
            if requests.closed {
                return None;
            }
            if let Some(job) = requests.known_mixture.take() {
                return Some((job, self.stamp()));
            }
            requests = self.wake_up.wait(requests).unwrap_or_else(PoisonError::into_inner);
        }
    }

    /// Requests the evaluation of a recipe that is not known, unless there is a newer request. Returns its generation.
    pub(super) fn unknown(&self, job: Job, stamp: u64) -> u64 {
        let generation = job.generation;
        self.change(false, |requests| {
            if self.stamp() == stamp && requests.known_mixture.is_none() {
                requests.mixture = Some(job);
            }
        });
        generation
    }

    /// Returns the stamp of the present moment; a task is obsolete once the stamp has changed.
    pub(super) fn stamp(&self) -> u64 {
        self.newest.load(Ordering::Relaxed)
    }
}

/// Task of the evaluation thread.
pub(super) enum Task {
    Picture(Job),
    Show(u64, Arc<Picture>, WorkingSpace, Display),
    Held(u64, Arc<Picture>, WorkingSpace, Display),
    Blame(Question),
    Thumbnails(Subject, i64),
    Ahead(Job),
    Mixture(Job),
}

/// Reports progress, but no more often than is visible.
pub(super) struct Progress<'t> {
    tell: &'t (dyn Fn(f32) + Sync),
    last: Mutex<Instant>,
}

impl<'t> Progress<'t> {
    pub(super) fn new(tell: &'t (dyn Fn(f32) + Sync)) -> Self {
        Self { tell, last: Mutex::new(Instant::now()) }
    }
}

/// Requests that interrupt a task.
#[derive(Clone, Copy, PartialEq, Eq)]
pub(super) enum Yields {
    /// None.
    Never,
    /// Requests for the visible picture.
    Short,
    /// Requests for the visible picture and for frames ahead.
    Always,
}

/// Cancels a task that is obsolete or must yield.
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
