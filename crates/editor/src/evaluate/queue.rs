//! Pending requests for the threads by urgency, and the cancellation of tasks.

use super::blame::Question;
use super::lane::Lane;
use super::request::Job;
use super::shown::Display;
use super::subject::Subject;
use std::collections::VecDeque;
use std::sync::atomic::{AtomicU64, AtomicUsize, Ordering};
use std::sync::{Arc, Condvar, Mutex, MutexGuard, PoisonError};
use std::time::{Duration, Instant};
use trochoid::{Monitor, Picture, WorkingSpace};

/// Requests of a viewer that have not been started.
#[derive(Default)]
pub(super) struct Wanted {
    pub(super) job: Option<Job>,
    pub(super) shown: Option<(u64, Arc<Picture>, WorkingSpace, Display)>,
    pub(super) held: Option<(u64, Arc<Picture>, WorkingSpace, Display)>,
    pub(super) question: Option<Question>,
}

impl Wanted {
    /// Removes and returns a picture that only needs to be converted for the screen.
    fn take_shown(&mut self) -> Option<Task> {
        // The held picture goes first, so that both change together.
        if let Some((number, picture, space, display)) = self.held.take() {
            return Some(Task::Held(number, picture, space, display));
        }
        let (generation, picture, space, display) = self.shown.take()?;
        Some(Task::Show(generation, picture, space, display))
    }

    /// Removes and returns what must be evaluated.
    fn take_job(&mut self) -> Option<Task> {
        self.job.take().map(Task::Picture).or_else(|| self.question.take().map(Task::Blame))
    }

    fn is_empty(&self) -> bool {
        self.job.is_none() && self.shown.is_none() && self.held.is_none() && self.question.is_none()
    }
}

/// Requests that have not been started.
#[derive(Default)]
pub(super) struct Requests {
    /// Those of each viewer.
    pub(super) wanted: [Wanted; 2],
    /// Whether the second viewer is open.
    pub(super) has_second: bool,
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
        let [first, second] = &mut self.wanted;
        let shown = first.take_shown().or_else(|| second.take_shown());
        let task = shown.or_else(|| first.take_job()).or_else(|| second.take_job());
        if task.is_some() {
            task
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

    /// Returns whether a request of a viewer is pending.
    fn is_urgent(&self, lane: Lane) -> bool {
        !self.wanted[lane as usize].is_empty()
    }
}

/// Queue of the worker: its handle adds requests, its thread takes them.
#[derive(Default)]
pub(super) struct Queue {
    requests: Mutex<Requests>,
    /// Wakes the threads when a request arrives.
    wake_up: Condvar,
    /// Incremented by every request of a viewer that makes its running task obsolete.
    newest: [AtomicU64; 2],
    /// Bytes of the frames that are kept for playback.
    held: AtomicUsize,
    /// Extra milliseconds per picture, for tests.
    #[cfg(test)]
    pace: AtomicU64,
    /// Whether the next picture panics, for tests.
    #[cfg(test)]
    breaks: std::sync::atomic::AtomicBool,
}

impl Queue {
    /// Waits for the extra time per picture.
    #[cfg(test)]
    pub(super) fn pace(&self, cancelled: impl Fn() -> bool) {
        assert!(!self.breaks.swap(false, Ordering::Relaxed), "broken for a test");
        let pace = Duration::from_millis(self.pace.load(Ordering::Relaxed));
        let started = Instant::now();
        while started.elapsed() < pace && !cancelled() {
            std::thread::sleep(Duration::from_millis(1));
        }
    }

    /// Sets the bytes of the frames that are kept for playback.
    pub(super) fn hold(&self, bytes: usize) {
        self.held.store(bytes, Ordering::Relaxed);
    }

    /// Returns the bytes of the frames that are kept for playback.
    pub(super) fn held(&self) -> usize {
        self.held.load(Ordering::Relaxed)
    }

    /// Lets the next picture panic.
    #[cfg(test)]
    pub(super) fn break_once(&self) {
        self.breaks.store(true, Ordering::Relaxed);
    }

    /// Sets the extra time per picture.
    #[cfg(test)]
    pub(super) fn slow_down(&self, by: Duration) {
        self.pace.store(by.as_millis() as u64, Ordering::Relaxed);
    }

    pub(super) fn requests(&self) -> MutexGuard<'_, Requests> {
        self.requests.lock().unwrap_or_else(PoisonError::into_inner)
    }

    /// Changes the pending requests and wakes the threads; `cancels` makes the running task of a viewer obsolete.
    pub(super) fn change(&self, cancels: Option<Lane>, change: impl FnOnce(&mut Requests)) {
        let mut requests = self.requests();
        change(&mut requests);
        if let Some(lane) = cancels {
            self.newest[lane as usize].fetch_add(1, Ordering::Relaxed);
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
                return Some((job, self.stamp(Lane::First)));
            }
            requests = self.wake_up.wait(requests).unwrap_or_else(PoisonError::into_inner);
        }
    }

    /// Requests the evaluation of a recipe that is not known, unless there is a newer request. Returns its generation.
    pub(super) fn unknown(&self, job: Job, stamp: u64) -> u64 {
        let generation = job.generation;
        self.change(None, |requests| {
            if self.stamp(Lane::First) == stamp && requests.known_mixture.is_none() {
                requests.mixture = Some(job);
            }
        });
        generation
    }

    /// Returns the stamp of the present moment; a task of a viewer is obsolete once the stamp has changed.
    pub(super) fn stamp(&self, lane: Lane) -> u64 {
        self.newest[lane as usize].load(Ordering::Relaxed)
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

impl Task {
    /// Returns the viewer whose newer requests make the task obsolete.
    pub(super) fn lane(&self) -> Lane {
        match self {
            Self::Picture(job) => Lane::of(job.generation),
            Self::Show(number, ..) | Self::Held(number, ..) => Lane::of(*number),
            Self::Blame(question) => Lane::of(question.generation),
            Self::Thumbnails(..) | Self::Ahead(_) | Self::Mixture(_) => Lane::First,
        }
    }
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
    /// Those of the first viewer.
    First,
    /// Those of both viewers.
    Viewers,
    /// Those of both viewers, and for frames ahead.
    Always,
}

/// Cancels a task that is obsolete or must yield.
pub(super) struct Cancellation<'o> {
    pub(super) queue: &'o Queue,
    pub(super) lane: Lane,
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
        if self.queue.stamp(self.lane) != self.stamp {
            return true;
        }
        if self.yields == Yields::Never {
            return false;
        }
        let requests = self.queue.requests();
        requests.is_urgent(Lane::First)
            || (self.yields != Yields::First && requests.is_urgent(Lane::Second))
            || (self.yields == Yields::Always && !requests.ahead.is_empty())
    }
}
