//! What was done, and can be undone.

use super::json::Splice;
use std::collections::VecDeque;

/// One step of undo: changes of the text in the order in which they were made.
#[derive(Clone, Debug, Default)]
pub struct Change {
    /// What it does, such as `Move 3 nodes`.
    pub label: String,
    /// Changes with the same key, without a pause between them, are one step: a drag, or typing.
    pub merge: Option<String>,
    /// What became of the text.
    pub splices: Vec<Splice>,
}

impl Change {
    fn bytes(&self) -> usize {
        size_of::<Self>() + self.label.len() + self.splices.iter().map(Splice::bytes).sum::<usize>()
    }

    /// Takes in what follows, where it only goes on.
    fn absorb(&mut self, splices: Vec<Splice>) {
        for next in splices {
            match self.splices.last_mut() {
                // The same place changed once more, as by a slider.
                Some(last) if last.at == next.at && last.inserted == next.removed => last.inserted = next.inserted,
                _ => self.splices.push(next),
            }
        }
    }
}

/// Every change since the document was opened, as far as the memory for it goes.
#[derive(Debug)]
pub struct History {
    changes: VecDeque<Change>,
    /// Those before it are done, those from it on undone.
    next: usize,
    bytes: usize,
    limit: usize,
    /// Whether the newest change takes in others of its key.
    open: bool,
    /// At which place in the history the document was saved; `None` where that is gone.
    saved: Option<usize>,
}

/// Memory for undo, bytes.
const LIMIT: usize = 256 << 20;

impl Default for History {
    fn default() -> Self {
        Self::with_limit(LIMIT)
    }
}

impl History {
    /// A history that keeps so many bytes, and always the newest change.
    pub fn with_limit(limit: usize) -> Self {
        Self { changes: VecDeque::new(), next: 0, bytes: 0, limit, open: false, saved: Some(0) }
    }

    /// Notes a change that was made.
    pub fn push(&mut self, change: Change) {
        while self.changes.len() > self.next {
            self.bytes -= self.changes.pop_back().map_or(0, |change| change.bytes());
        }
        if self.saved > Some(self.next) {
            self.saved = None;
        }
        // What was saved can be gone back to, so nothing is merged into it.
        let merges = self.open && self.saved != Some(self.next) && change.merge.is_some();
        match self.changes.back_mut().filter(|last| merges && last.merge == change.merge) {
            Some(last) => {
                self.bytes -= last.bytes();
                last.absorb(change.splices);
                if last.splices.iter().all(|splice| splice.removed == splice.inserted) {
                    // All is as it was before.
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

    /// Ends a gesture: what comes next is a step of its own.
    pub fn seal(&mut self) {
        self.open = false;
    }

    /// Takes the newest change back, and says what it was.
    pub fn undo(&mut self, text: &mut String) -> Option<&str> {
        self.open = false;
        self.next = self.next.checked_sub(1)?;
        let change = &self.changes[self.next];
        change.splices.iter().rev().for_each(|splice| splice.undo(text));
        Some(&change.label)
    }

    /// Makes the change again that was undone last, and says what it was.
    pub fn redo(&mut self, text: &mut String) -> Option<&str> {
        self.open = false;
        let change = self.changes.get(self.next)?;
        change.splices.iter().for_each(|splice| splice.redo(text));
        self.next += 1;
        Some(&change.label)
    }

    /// What undo would take back.
    pub fn undoes(&self) -> Option<&str> {
        self.changes.get(self.next.checked_sub(1)?).map(|change| change.label.as_str())
    }

    /// What redo would make again.
    pub fn redoes(&self) -> Option<&str> {
        self.changes.get(self.next).map(|change| change.label.as_str())
    }

    /// Notes that the document is saved as it is.
    pub fn mark_saved(&mut self) {
        self.saved = Some(self.next);
        self.open = false;
    }

    /// Notes that no state of the history is what is saved.
    pub fn mark_changed(&mut self) {
        self.saved = None;
    }

    /// Whether the document is as it was saved.
    pub fn is_saved(&self) -> bool {
        self.saved == Some(self.next)
    }
}
