//! What became of the frames of a run.

use crate::failure::{Failure, MISSED};
use std::collections::HashSet;

/// What became of the frames so far.
#[derive(Default)]
pub(super) struct Tally {
    pub(super) done: usize,
    /// Number of frames that missed a requirement.
    pub(super) missed: usize,
    /// Frames that failed, with their exit codes.
    pub(super) failed: Vec<(i64, u8)>,
    /// Nodes, and surfaces of views, of which is warned once.
    pub(super) told: HashSet<String>,
    pub(super) unseen: HashSet<(String, String)>,
}

impl Tally {
    /// Returns the failure of a run.
    pub(super) fn outcome(&self) -> Result<(), Failure> {
        let missed = (self.missed > 0).then(|| {
            let message = format!("a required guarantee was missed in {} of {} frames", self.missed, self.done);
            Failure::new(MISSED, message)
        });
        // What may succeed if it is tried again comes before what cannot.
        let code = self.failed.iter().map(|(_, code)| *code).min();
        let failed = code.map(|code| {
            let frames: Vec<String> = self.failed.iter().take(20).map(|(frame, _)| frame.to_string()).collect();
            let more = if self.failed.len() > 20 { " and others" } else { "" };
            let message = format!("{} of {} frames failed: {}{more}", self.failed.len(), self.done, frames.join(", "));
            Failure::new(code, message)
        });
        match (failed, missed) {
            (Some(mut failed), Some(missed)) => {
                failed.messages.extend(missed.messages);
                Err(failed)
            }
            (failed, missed) => failed.or(missed).map_or(Ok(()), Err),
        }
    }
}
