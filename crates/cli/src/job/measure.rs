//! Time of a task, measured on this machine.

use super::work::{Work, evaluated};
use crate::failure::{FAILED, Failure};
use crate::progress::Progress;
use std::time::Instant;
use trochoid::{Buffers, Cache, CheckedGraph, EvalError, Plan, Settings, Sink, Window};

/// Times as long as measured that a task may take, since machines differ.
const MARGIN: f64 = 4.0;
/// Minutes beside that: the queue of a file system, the start of a machine.
const BESIDE: f64 = 2.0;
/// Seconds that starting the program and loading a document take.
const START: f64 = 0.1;
/// Share of a task's time that what each task does anew is to take at most.
const SHARE: f64 = 0.1;

/// Times of a task.
pub(super) struct Measured {
    /// Seconds of its first frame: with a simulation up to it, and what all frames share.
    first: f64,
    /// Seconds of each further frame.
    further: f64,
    /// Frames of a task.
    frames: usize,
}

impl Measured {
    /// Returns the seconds of a task.
    fn seconds(&self) -> f64 {
        START + self.first + self.further * (self.frames - 1) as f64
    }

    /// Returns the share of a task's time that it would not take if one task rendered all frames.
    fn overhead(&self) -> f64 {
        (START + (self.first - self.further).max(0.0)) / self.seconds()
    }

    /// Returns the fewest frames of a task of which little is overhead.
    fn frames_that_pay(&self) -> u64 {
        let anew = START + (self.first - self.further).max(0.0);
        (anew * (1.0 - SHARE) / SHARE / self.further.max(1e-3)).ceil().max(1.0) as u64
    }

    /// Returns the minutes after which an engine may end a task.
    pub(super) fn minutes(&self) -> u32 {
        (self.seconds() * MARGIN / 60.0 + BESIDE).ceil().min(100_000.0) as u32
    }

    /// Tells the times, as lines, in a job of so many frames.
    pub(super) fn told(&self, of: usize) -> String {
        let mut told = format!("a task takes {} here", in_words(self.seconds()));
        if self.frames > 1 {
            let (first, further) = (in_words(self.first), in_words(self.further));
            told += &format!(": its first frame {first}, each further one {further}");
        }
        told += &format!("; {:.0} % of it is done anew by each task\n", 100.0 * self.overhead());
        if self.overhead() > SHARE && (self.frames as u64 + 1..=of as u64).contains(&self.frames_that_pay()) {
            told += &format!("with --chunk {} that would be {:.0} %\n", self.frames_that_pay(), 100.0 * SHARE);
        }
        told
    }
}

/// Takes rows, and does nothing with them.
struct Nowhere;

impl Sink for Nowhere {
    fn rows(&self) -> usize {
        1
    }

    fn take(&self, _band: Window, _rows: &[Vec<&[f32]>]) -> Result<(), EvalError> {
        Ok(())
    }
}

/// Renders the first two frames of the last whole task, or one tile of them in the middle of the picture; nothing is
/// written.
///
/// # Errors
/// A frame cannot be rendered, or the user interrupted.
pub(super) fn measure(work: &Work, graph: &CheckedGraph, outputs: &[usize]) -> Result<Measured, Failure> {
    let graph = evaluated(graph, outputs)?;
    let names: Vec<&str> = outputs.iter().map(|index| graph.outputs()[*index].name.as_str()).collect();
    let mut settings = Settings::default();
    settings.threads = usize::from(work.threads);
    settings.region = work.tiles.get(work.middle).map(|[x, y, width, height]| {
        let [x, y, width, height] = [x, y, width, height].map(|size| i64::from(*size));
        Window::new(x, y, x + width, y + height)
    });
    settings.local = settings.region.is_some();
    let whole = work.frames.chunks_exact(work.chunk.min(work.frames.len())).next_back().unwrap_or(&work.frames);
    let mut cache = Cache::new();
    let mut times = Vec::new();
    let mut progress = Progress::new(whole.len().min(2), false);
    for (done, &frame) in whole.iter().take(2).enumerate() {
        progress.begin(done, frame);
        let started = Instant::now();
        let plan = Plan::new(&graph, &names, frame, &[], &settings)
            .map_err(|error| Failure::new(FAILED, format!("frame {frame}: {error}")))?;
        plan.evaluate_to(&Nowhere, &Buffers::new(), &mut cache, &progress).map_err(|error| match error {
            EvalError::Cancelled => Failure::interrupted(),
            error => Failure::evaluated(&format!("frame {frame}: "), &error),
        })?;
        times.push(started.elapsed().as_secs_f64());
        cache.forget_unused();
    }
    progress.finish();
    let first = times.first().copied().unwrap_or_default();
    Ok(Measured { first, further: times.get(1).copied().unwrap_or(first), frames: whole.len() })
}

/// Returns a time in words.
fn in_words(seconds: f64) -> String {
    match seconds {
        ..9.95 => format!("{seconds:.1} s"),
        ..119.5 => format!("{seconds:.0} s"),
        ..7170.0 => format!("{:.0} minutes", seconds / 60.0),
        _ => format!("{:.1} hours", seconds / 3600.0),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn what_tasks_do_anew_is_told() {
        let sea = Measured { first: 30.0, further: 1.0, frames: 10 };
        assert!((sea.seconds() - 39.1).abs() < 1e-9 && (sea.overhead() - 29.1 / 39.1).abs() < 1e-9);
        assert_eq!((sea.minutes(), sea.frames_that_pay()), (5, 262));
        assert!(
            sea.told(500).contains("39 s here: its first frame 30 s, each further one 1.0 s; 74 %"),
            "{}",
            sea.told(500)
        );
        assert!(sea.told(500).contains("--chunk 262"), "{}", sea.told(500));
        assert!(!sea.told(96).contains("--chunk"), "there are not so many frames");
        let still = Measured { first: 7200.0, further: 7200.0, frames: 1 };
        assert_eq!(still.minutes(), 483);
        assert_eq!(still.told(1), "a task takes 2.0 hours here; 0 % of it is done anew by each task\n");
    }
}
