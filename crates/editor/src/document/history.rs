//! Undo history.

use super::json::Splice;
use std::collections::VecDeque;

/// One step of undo: splices of the text, in the order they were made.
#[derive(Clone, Debug, Default)]
pub struct Change {
    /// Description of the step, such as `Move 3 nodes`.
    pub label: String,
    /// Steps with the same key and no pause between them merge into one, as in a drag or while typing.
    pub merge: Option<String>,
    /// Changes to the text.
    pub splices: Vec<Splice>,
}

impl Change {
    fn bytes(&self) -> usize {
        size_of::<Self>() + self.label.len() + self.splices.iter().map(Splice::bytes).sum::<usize>()
    }

    /// Appends further splices, merging consecutive changes of the same place.
    fn absorb(&mut self, splices: Vec<Splice>) {
        for next in splices {
            match self.splices.last_mut() {
                // The same place changed again, for example by a slider.
                Some(last) if last.at == next.at && last.inserted == next.removed => last.inserted = next.inserted,
                _ => self.splices.push(next),
            }
        }
    }
}

/// The steps since the document was opened, limited by memory.
#[derive(Debug)]
pub struct History {
    changes: VecDeque<Change>,
    /// Steps before this index are done, the others undone.
    next: usize,
    bytes: usize,
    limit: usize,
    /// Whether the newest step still merges with others of its key.
    open: bool,
    /// Position in the history at which the document was last saved; `None` if it is no longer reachable.
    saved: Option<usize>,
}

/// Memory limit of the history, in bytes.
const LIMIT: usize = 256 << 20;

impl Default for History {
    fn default() -> Self {
        Self::with_limit(LIMIT)
    }
}

impl History {
    /// Creates a history that keeps at most this many bytes, but always the newest step.
    pub fn with_limit(limit: usize) -> Self {
        Self { changes: VecDeque::new(), next: 0, bytes: 0, limit, open: false, saved: Some(0) }
    }

    /// Records a step that was made.
    pub fn push(&mut self, change: Change) {
        while self.changes.len() > self.next {
            self.bytes -= self.changes.pop_back().map_or(0, |change| change.bytes());
        }
        if self.saved > Some(self.next) {
            self.saved = None;
        }
        // Nothing merges into the saved state, so that undo can return to it.
        let merges = self.open && self.saved != Some(self.next) && change.merge.is_some();
        match self.changes.back_mut().filter(|last| merges && last.merge == change.merge) {
            Some(last) => {
                self.bytes -= last.bytes();
                last.absorb(change.splices);
                if last.splices.iter().all(|splice| splice.removed == splice.inserted) {
                    // The merged step changes nothing any more.
                    self.changes.pop_back();
                    self.next -= 1;
                    return self.seal();
                }
                self.bytes += last.bytes();
            }
            None => {
                self.bytes += change.bytes();
                self.changes.push_back(change);
                self.next += 1;
            }
        }
        self.open = true;
        while self.bytes > self.limit && self.changes.len() > 1 {
            self.bytes -= self.changes.pop_front().map_or(0, |change| change.bytes());
            self.next -= 1;
            self.saved = self.saved.and_then(|saved| saved.checked_sub(1));
        }
    }

    /// Ends a gesture: the next change becomes a step of its own.
    pub fn seal(&mut self) {
        self.open = false;
    }

    /// Returns whether the gesture that made the newest step has not ended.
    pub fn is_open(&self) -> bool {
        self.open
    }

    /// Undoes the newest step and returns its label.
    pub fn undo(&mut self, text: &mut String) -> Option<&str> {
        self.open = false;
        self.next = self.next.checked_sub(1)?;
        let change = &self.changes[self.next];
        change.splices.iter().rev().for_each(|splice| splice.undo(text));
        Some(&change.label)
    }

    /// Redoes the last undone step and returns its label.
    pub fn redo(&mut self, text: &mut String) -> Option<&str> {
        self.open = false;
        let change = self.changes.get(self.next)?;
        change.splices.iter().for_each(|splice| splice.redo(text));
        self.next += 1;
        Some(&change.label)
    }

    /// Returns the label of the step that undo would revert.
    pub fn undoes(&self) -> Option<&str> {
        self.changes.get(self.next.checked_sub(1)?).map(|change| change.label.as_str())
    }

    /// Returns the label of the step that redo would repeat.
    pub fn redoes(&self) -> Option<&str> {
        self.changes.get(self.next).map(|change| change.label.as_str())
    }

    /// Records that the document is saved in its current state.
    pub fn mark_saved(&mut self) {
        self.saved = Some(self.next);
        self.open = false;
    }

    /// Records that no state in the history matches the saved file.
    pub fn mark_changed(&mut self) {
        self.saved = None;
    }

    /// Returns whether the document is in its saved state.
    pub fn is_saved(&self) -> bool {
        self.saved == Some(self.next)
    }
}
