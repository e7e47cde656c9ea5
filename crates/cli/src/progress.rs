//! Progress of a run: a bar on terminals, lines for programs, or calls of a host.

mod lines;

use crate::failure::Failure;
use crate::{host, interrupt, shell};
use indicatif::{ProgressBar, ProgressDrawTarget, ProgressState, ProgressStyle};
use lines::Lines;
pub(crate) use lines::{Form, failed};
use std::fmt::Write;
use std::time::Duration;
use trochoid::Monitor;

/// Steps of the bar per frame.
const STEPS: u64 = 1000;

/// Progress of a run, and the monitor that tells the run whether to stop.
pub(crate) struct Progress {
    bar: ProgressBar,
    lines: Option<Lines>,
    /// Position of the bar at the start of the frame.
    start: u64,
    frame: i64,
}

impl Progress {
    /// Creates a bar for this many frames, on stderr, visible only if that is a terminal.
    pub(crate) fn new(frames: usize, hidden: bool) -> Self {
        let target =
            if hidden || host::is_there() { ProgressDrawTarget::hidden() } else { ProgressDrawTarget::stderr() };
        let bar = ProgressBar::with_draw_target(Some(frames as u64 * STEPS), target);
        let template = "{bar:20} {percent:>3} %  {elapsed} elapsed, {left} left  {wide_msg}";
        if let Ok(style) = ProgressStyle::with_template(template) {
            // Without progress there is no estimate.
            let left = |state: &ProgressState, out: &mut dyn Write| {
                let seconds = state.eta().as_secs();
                let _ = if state.pos() == 0 { out.write_str("?") } else { write!(out, "{seconds}s") };
            };
            bar.set_style(style.with_key("left", left));
        }
        if !bar.is_hidden() {
            // Redrawn regularly, so that a long preparation does not look stuck.
            bar.enable_steady_tick(Duration::from_millis(250));
        }
        Self { bar, lines: None, start: 0, frame: 0 }
    }

    /// Creates progress in a form.
    pub(crate) fn of(form: Form, frames: usize, hidden: bool) -> Self {
        let lines = Lines::new(form);
        Self { lines, ..Self::new(frames, hidden || form != Form::Text) }
    }

    pub(crate) fn begin(&mut self, index: usize, frame: i64) {
        (self.start, self.frame) = (index as u64 * STEPS, frame);
        self.bar.set_position(self.start);
        self.say(&format!("frame {frame}"));
    }

    /// Skips a frame. It took no time, so it must not count in the estimate of the time left.
    pub(crate) fn skip(&self) {
        self.bar.set_position(self.start + STEPS);
        self.bar.reset_eta();
    }

    /// Prints a line on stdout, above the bar.
    pub(crate) fn print(&self, text: &str) -> Result<(), Failure> {
        self.bar.suspend(|| shell::print(text))
    }

    /// Prints messages on stderr, above the bar.
    pub(crate) fn tell(&self, messages: &[String]) {
        self.bar.suspend(|| shell::tell(messages));
    }

    pub(crate) fn finish(&self) {
        self.bar.set_position(self.bar.length().unwrap_or_default());
        self.share();
        self.bar.finish_and_clear();
    }

    /// Says what is done now.
    fn say(&self, text: &str) {
        self.bar.set_message(text.to_owned());
        if let Some(lines) = &self.lines {
            lines.say(self.frame, text);
        }
        self.share();
    }

    /// Tells the share that is done.
    fn share(&self) {
        host::progress(self.bar.position(), self.bar.length().unwrap_or_default());
        if let Some(lines) = &self.lines {
            lines.share(self.frame, self.bar.position() as f64 / self.bar.length().unwrap_or(1).max(1) as f64);
        }
    }
}

impl Monitor for Progress {
    fn preparing(&self, node: &str) {
        self.say(&format!("frame {}: preparing {node}", self.frame));
    }

    fn progress(&self, done: usize, total: usize) {
        if done == 1 {
            self.say(&format!("frame {}", self.frame));
        }
        self.bar.set_position(self.start + STEPS * done as u64 / total.max(1) as u64);
        self.share();
    }

    fn cancelled(&self) -> bool {
        interrupt::asked()
    }
}
