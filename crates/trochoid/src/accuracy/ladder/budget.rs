//! What fits into the time.

use super::request::Effort;
use std::sync::atomic::{AtomicUsize, Ordering};
use trochoid_engine::Monitor;

/// Parts of the work, in the order in which they are done.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub(super) enum Phase {
    /// Rendering with all settings, in turns.
    Renders,
    /// Bounds and references of pixels.
    Pixels,
    /// The time of certifying.
    Certify,
    /// Which passes the errors come from.
    Passes,
}

impl Phase {
    /// Share of the time at which a phase ends, if all before it took as long as they may.
    fn end(self) -> f64 {
        match self {
            Self::Renders => 0.4,
            Self::Pixels => 0.8,
            Self::Certify => 0.9,
            Self::Passes => 0.96,
        }
    }
}

/// The time that there is, and the time that has passed.
pub(super) struct Budget<'a> {
    /// Seconds; `None` if the work is done however long it takes.
    seconds: Option<f64>,
    /// Seconds since the work began.
    clock: &'a (dyn Fn() -> f64 + Sync),
    monitor: &'a dyn Monitor,
    /// Steps done, and all steps, if there is no limit of time.
    done: AtomicUsize,
    steps: usize,
}

/// Parts of a step, for progress.
const GRAIN: usize = 1000;

impl<'a> Budget<'a> {
    pub(super) fn new(
        effort: Effort,
        clock: &'a (dyn Fn() -> f64 + Sync),
        monitor: &'a dyn Monitor,
        steps: usize,
    ) -> Self {
        let seconds = if let Effort::Within(seconds) = effort { Some(seconds) } else { None };
        Self { seconds, clock, monitor, done: AtomicUsize::new(0), steps }
    }

    /// Returns the seconds that have passed.
    pub(super) fn now(&self) -> f64 {
        (self.clock)()
    }

    /// Returns the seconds left for a phase; `None` if there is no limit.
    pub(super) fn left(&self, phase: Phase) -> Option<f64> {
        Some(self.seconds? * phase.end() - self.now())
    }

    /// Returns whether a phase may go on.
    pub(super) fn allows(&self, phase: Phase) -> bool {
        self.left(phase).is_none_or(|left| left > 0.0)
    }

    /// Counts a step as done.
    pub(super) fn step(&self) {
        self.done.fetch_add(1, Ordering::Relaxed);
        self.tell(0, 1);
    }

    /// Returns a monitor that stops work at the end of a phase.
    pub(super) fn until(&self, phase: Phase) -> Deadline<'_> {
        Deadline { budget: self, phase: Some(phase) }
    }

    /// Returns a monitor for work that is done in any case.
    pub(super) fn unlimited(&self) -> Deadline<'_> {
        Deadline { budget: self, phase: None }
    }

    /// Reports progress: by time if that is what ends the work, otherwise by steps.
    fn tell(&self, done: usize, total: usize) {
        match self.seconds {
            Some(seconds) => {
                let part = (self.now() / seconds).clamp(0.0, 1.0);
                self.monitor.progress((part * GRAIN as f64) as usize, GRAIN);
            }
            None => {
                let part = GRAIN * done.min(total) / total.max(1);
                let all = self.steps * GRAIN;
                self.monitor.progress((self.done.load(Ordering::Relaxed) * GRAIN + part).min(all), all);
            }
        }
    }
}

/// Monitor of a part of the work.
pub(super) struct Deadline<'b> {
    budget: &'b Budget<'b>,
    phase: Option<Phase>,
}

impl Deadline<'_> {
    /// Returns whether time, and not the user, has stopped the work.
    pub(super) fn is_over(&self) -> bool {
        !self.budget.monitor.cancelled() && self.phase.is_some_and(|phase| !self.budget.allows(phase))
    }
}

impl Monitor for Deadline<'_> {
    fn preparing(&self, node: &str) {
        self.budget.monitor.preparing(node);
    }

    fn progress(&self, done: usize, total: usize) {
        self.budget.tell(done, total);
    }

    fn cancelled(&self) -> bool {
        self.budget.monitor.cancelled() || self.is_over()
    }
}

/// Share of the time left that a prediction may use: pixels differ in what they cost.
const CAUTION: f64 = 0.6;

/// Returns how often a number of pixels, of which `new` took some seconds, may be doubled in the time that is left.
pub(super) fn doublings(count: usize, new: usize, seconds: f64, left: Option<f64>, most: usize) -> u32 {
    let mut doublings = 0;
    while count << (doublings + 1) <= most {
        let more = (count << (doublings + 1)) - count;
        // As many again as are new, in proportion.
        let predicted = seconds * more as f64 / new.max(1) as f64;
        if left.is_some_and(|left| predicted > CAUTION * left) {
            break;
        }
        doublings += 1;
    }
    doublings
}

#[cfg(test)]
mod tests {
    #![allow(clippy::unwrap_used, reason = "a test may panic")]

    use super::*;
    use std::sync::Mutex;
    use trochoid_engine::Silent;

    #[test]
    fn numbers_of_pixels_follow_from_the_time_left() {
        // 16 pixels took 1 s; 112 more would take 7 s, of the 6 that 10 s allow.
        assert_eq!(doublings(16, 16, 1.0, Some(10.0), 4096), 2);
        assert_eq!(doublings(16, 16, 1.0, Some(12.0), 4096), 3);
        assert_eq!(doublings(16, 16, 1.0, Some(0.5), 4096), 0);
        assert_eq!((doublings(16, 16, 1e-9, Some(60.0), 4096), doublings(16, 16, 9.0, None, 256)), (8, 4));
        assert_eq!(doublings(16, 16, 1.0, Some(-1.0), 4096), 0);
    }

    #[test]
    fn time_stops_a_phase_and_is_told() {
        struct Told(Mutex<Vec<(usize, usize)>>);
        impl Monitor for Told {
            fn progress(&self, done: usize, total: usize) {
                self.0.lock().unwrap().push((done, total));
            }
        }
        let told = Told(Mutex::default());
        let now = Mutex::new(0.0);
        let clock = || *now.lock().unwrap();
        let budget = Budget::new(Effort::Within(10.0), &clock, &told, 3);
        let [renders, pixels] = [Phase::Renders, Phase::Pixels].map(|phase| budget.until(phase));
        assert!(!renders.cancelled() && budget.left(Phase::Pixels) == Some(8.0));
        *now.lock().unwrap() = 5.0;
        renders.progress(1, 2);
        assert!(renders.cancelled() && renders.is_over() && !pixels.cancelled() && !budget.unlimited().cancelled());
        assert_eq!(told.0.lock().unwrap()[..], [(500, 1000)]);
        let budget = Budget::new(Effort::Pixels(4), &clock, &told, 4);
        budget.step();
        budget.until(Phase::Renders).progress(1, 2);
        assert_eq!(told.0.lock().unwrap()[1..], [(1000, 4000), (1500, 4000)]);
        assert!(!budget.until(Phase::Renders).cancelled());
    }

    #[test]
    fn what_the_user_stops_was_not_stopped_by_time() {
        struct Stopped;
        impl Monitor for Stopped {
            fn cancelled(&self) -> bool {
                true
            }
        }
        let late = || 100.0;
        let of = |monitor: &dyn Monitor| {
            let budget = Budget::new(Effort::Within(1.0), &late, monitor, 1);
            let deadline = budget.until(Phase::Passes);
            (deadline.cancelled(), deadline.is_over())
        };
        assert_eq!((of(&Stopped), of(&Silent)), ((true, false), (true, true)));
    }
}
