//! Progress as lines, for the programs that carry jobs.

use crate::shell;
use clap::ValueEnum;
use serde_json::json;
use std::sync::{Mutex, PoisonError};
use std::time::{Duration, Instant};

/// Shortest time between two lines of one kind.
const PAUSE: Duration = Duration::from_millis(500);

/// Form of progress.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, ValueEnum)]
pub(crate) enum Form {
    /// A bar on stderr, if that is a terminal
    #[default]
    Text,
    /// JSON objects on stderr, one a line: {"progress": 12.5, "frame": 3}, {"status": "…", "frame": 3}
    Json,
    /// Lines of Open Job Description on stdout: openjd_progress, openjd_status, openjd_fail
    Openjd,
}

/// Progress that is printed line by line.
pub(super) struct Lines {
    form: Form,
    last: Mutex<Last>,
}

/// What was said last, and when.
#[derive(Default)]
struct Last {
    said: Option<(Instant, String)>,
    shared: Option<(Instant, i64)>,
}

impl Lines {
    /// Returns `None` for a form without lines.
    pub(super) fn new(form: Form) -> Option<Self> {
        (form != Form::Text).then(|| Self { form, last: Mutex::default() })
    }

    /// Says what is done now, unless something was said a moment ago.
    pub(super) fn say(&self, frame: i64, text: &str) {
        let mut last = self.last.lock().unwrap_or_else(PoisonError::into_inner);
        let is_due = last.said.as_ref().is_none_or(|(at, said)| at.elapsed() > PAUSE && said != text);
        if is_due {
            last.said = Some((Instant::now(), text.into()));
            match self.form {
                Form::Openjd => print(&format!("openjd_status: {}", shell::printable(text))),
                _ => shell::tell([&json!({ "status": text, "frame": frame })]),
            }
        }
    }

    /// Tells the share that is done, from 0 to 1, if it has grown by a tenth of a percent since a moment ago.
    pub(super) fn share(&self, frame: i64, share: f64) {
        let tenths = (1000.0 * share) as i64;
        let mut last = self.last.lock().unwrap_or_else(PoisonError::into_inner);
        let is_due = last.shared.is_none_or(|(at, told)| told != tenths && (at.elapsed() > PAUSE || tenths >= 1000));
        if is_due {
            last.shared = Some((Instant::now(), tenths));
            let percent = tenths as f64 / 10.0;
            match self.form {
                Form::Openjd => print(&format!("openjd_progress: {percent:.1}")),
                _ => shell::tell([&json!({ "progress": percent, "frame": frame })]),
            }
        }
    }
}

/// Tells Open Job Description why a run failed; other forms have no line for that.
pub(crate) fn failed(form: Form, why: &str) {
    if form == Form::Openjd {
        print(&format!("openjd_fail: {}", shell::printable(why.lines().next().unwrap_or_default())));
    }
}

/// Prints a line; the run goes on if nobody listens.
fn print(line: &str) {
    let _ = shell::print(&format!("{line}\n"));
}
