//! Playback: shows every frame of the range in order, and waits for frames that are not evaluated yet.

use super::Editor;
use egui::Context;
use std::collections::VecDeque;
use std::time::Duration;

/// Number of frames over which the frame rate is measured.
const RATE: usize = 24;

/// State of the playback clock. Times are in seconds of the window's clock.
#[derive(Debug, Default)]
pub(super) struct Playback {
    /// Times when the last frames were shown.
    times: VecDeque<f64>,
    /// The frame shown last.
    frame: Option<i64>,
    /// Earliest time for the next frame.
    due: f64,
}

/// Next step of playback.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) enum Step {
    /// Wait for news.
    Wait,
    /// Wait for this many seconds.
    Pause(f64),
    /// Go to the next frame.
    Go,
}

impl Playback {
    /// Returns the next step at time `now`. `shown` is the completely shown frame, if any; `ready` says whether the
    /// frame after it is evaluated.
    pub(super) fn step(&mut self, now: f64, shown: Option<i64>, ready: bool, fps: f64) -> Step {
        let Some(frame) = shown else { return Step::Wait };
        let time = 1.0 / fps;
        if self.frame.replace(frame) != Some(frame) {
            // A delay of less than one frame is made up for; a longer one is not.
            let on_time = !self.times.is_empty() && now - self.due < time;
            self.due = if on_time { self.due + time } else { now + time };
            self.times.push_back(now);
            if self.times.len() > RATE + 1 {
                self.times.pop_front();
            }
        }
        match self.due - now {
            left if left > 1e-6 => Step::Pause(left),
            _ if ready => Step::Go,
            _ => Step::Wait,
        }
    }

    /// Returns the frame rate over the last frames.
    pub(super) fn rate(&self) -> Option<f64> {
        let (first, last) = (self.times.front()?, self.times.back()?);
        (last > first).then(|| (self.times.len() - 1) as f64 / (last - first))
    }
}

/// Returns the frame after another in a looped range.
pub(super) fn after(frame: i64, (first, last): (i64, i64)) -> i64 {
    if frame < first || frame >= last { first } else { frame + 1 }
}

/// Returns how many frames after the present one another frame comes in a looped range.
pub(super) fn ahead(frame: i64, present: i64, (first, last): (i64, i64)) -> i64 {
    if frame == present {
        return 0;
    }
    if !(first..=last).contains(&frame) {
        return i64::MAX;
    }
    match (first..=last).contains(&present) {
        true => (frame - present).rem_euclid(last - first + 1),
        false => frame - first + 1,
    }
}

impl Editor {
    /// Goes to the next frame once it is due and evaluated; waits for it however long that takes.
    pub(super) fn play(&mut self, context: &Context) {
        if !self.state.playing {
            self.state.evaluated.rate = None;
            return;
        }
        let seen = &self.state.evaluated;
        let frame = self.state.frame;
        if seen.failed.is_some() {
            // Waits while the document has errors; stops at a frame that fails.
            let is_of_this = self.is_asked(frame) && seen.progress.is_none();
            self.state.playing = !is_of_this || self.state.session.meaning().graph.is_none();
            return;
        }
        let is_shown = seen.progress.is_none()
            && seen.result.as_ref().is_some_and(|result| result.finished && result.frame == frame);
        let next = after(frame, self.state.range);
        let ready = next != frame && (self.is_made(next) || self.asked.failed.contains(&next));
        let (now, fps) = (context.input(|input| input.time), self.state.sheet().frames.2);
        let step = self.playback.step(now, is_shown.then_some(frame), ready, fps);
        self.state.evaluated.rate = self.playback.rate();
        match step {
            Step::Wait => {}
            // Frames may be arbitrarily far apart at low rates.
            Step::Pause(seconds) => context.request_repaint_after(Duration::from_secs_f64(seconds.min(60.0))),
            Step::Go => {
                self.state.frame = next;
                context.request_repaint();
            }
        }
    }

    /// Returns whether a frame is cached with the current display.
    pub(super) fn is_made(&self, frame: i64) -> bool {
        self.state.evaluated.frames.get(&frame).is_some_and(|made| made.display == self.state.look.display)
    }

    /// Returns the upcoming frames that are not cached, as many as fit in the cache.
    pub(super) fn missing(&self) -> Vec<i64> {
        let range = self.state.range;
        let largest = self.state.evaluated.frames.values().map(|made| made.bytes()).max().unwrap_or(0);
        let room = self.room.checked_div(largest).map_or(AHEAD, |room| room.saturating_sub(1).clamp(1, AHEAD));
        let mut next = Vec::new();
        let mut frame = self.state.frame;
        for _ in 0..room {
            frame = after(frame, range);
            if frame == self.state.frame || next.contains(&frame) {
                break;
            }
            next.push(frame);
        }
        next.retain(|frame| !self.is_made(*frame) && !self.asked.failed.contains(frame));
        next
    }
}

/// Maximum number of frames evaluated ahead.
const AHEAD: usize = 8;

#[cfg(test)]
mod tests {
    use super::*;

    /// Simulates playback until a time, where each frame takes `seconds` to evaluate after the one before. Returns the
    /// shown frames with their times, and the measured rate.
    fn played(frames: i64, fps: f64, seconds: f64, until: f64) -> (Vec<(i64, f64)>, Option<f64>) {
        let (range, mut playback) = ((1, frames), Playback::default());
        let (mut now, mut frame, mut made, mut shown) = (0.0, 1, seconds, Vec::new());
        while now < until {
            // Evaluation of the next frame starts when the last one is done.
            let before = playback.frame;
            let is_made = now >= made;
            let step = playback.step(now, Some(frame), is_made, fps);
            if before != playback.frame {
                shown.push((frame, now));
            }
            if step == Step::Go {
                frame = after(frame, range);
                made = now + seconds;
            }
            now += 0.001;
        }
        (shown, playback.rate())
    }

    #[test]
    fn slow_frames_are_waited_for_and_none_is_left_out() {
        let (shown, rate) = played(5, 24.0, 0.3, 6.0);
        let frames: Vec<i64> = shown.iter().map(|(frame, _)| *frame).collect();
        let wanted: Vec<i64> = (0..frames.len() as i64).map(|index| 1 + index % 5).collect();
        assert_eq!(frames, wanted);
        assert!(frames.len() > 15, "more than three times around");
        assert!((rate.unwrap() - 3.3).abs() < 0.1, "{rate:?}");
    }

    #[test]
    fn what_is_made_is_played_in_real_time() {
        let (shown, rate) = played(100, 24.0, 0.0, 3.0);
        assert!((rate.unwrap() - 24.0).abs() < 0.1, "{rate:?}");
        // The steps of a millisecond do not accumulate an error.
        let (first, last) = (shown[0], shown[shown.len() - 1]);
        assert!(((last.1 - first.1) - (last.0 - first.0) as f64 / 24.0).abs() < 0.01);
    }

    #[test]
    fn a_pause_is_not_made_up_for() {
        let mut playback = Playback::default();
        assert_eq!(playback.step(0.0, Some(1), true, 10.0), Step::Pause(0.1));
        assert_eq!(playback.step(5.0, Some(1), true, 10.0), Step::Go);
        assert_eq!(playback.step(5.0, None, true, 10.0), Step::Wait);
        assert!(matches!(playback.step(5.0, Some(2), true, 10.0), Step::Pause(_)));
        assert!(matches!(playback.step(5.05, Some(2), true, 10.0), Step::Pause(_)), "one frame, not two");
    }

    #[test]
    fn frames_repeat_within_the_range_and_enter_it_from_outside() {
        assert_eq!([1, 2, 3].map(|frame| after(frame, (1, 3))), [2, 3, 1]);
        assert_eq!([0, -9, 4, 90].map(|frame| after(frame, (1, 3))), [1; 4]);
        assert_eq!(after(7, (7, 7)), 7);
        assert_eq!([1, 2, 3].map(|frame| ahead(frame, 2, (1, 3))), [2, 0, 1]);
        assert_eq!(ahead(9, 2, (1, 3)), i64::MAX);
    }
}
