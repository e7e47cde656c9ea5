//! What a node's own checks find.

use crate::{Kind, Source};

/// Collects what [`NodeType::check`](crate::NodeType::check) finds.
pub struct Check<'a> {
    kinds: &'a dyn Fn(&Source<Vec<f64>>) -> Option<Kind>,
    faults: Vec<Fault>,
}

/// A fault or warning within one node.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Fault {
    /// The port or knob.
    pub item: &'static str,
    /// What was found.
    pub found: String,
    /// What was expected.
    pub expected: String,
    /// What to do.
    pub remedy: String,
    /// Whether it is only a warning.
    pub warning: bool,
}

impl<'a> Check<'a> {
    /// Made by validation; `kinds` gives the kind of a connection, where it is known.
    pub fn new(kinds: &'a dyn Fn(&Source<Vec<f64>>) -> Option<Kind>) -> Self {
        Self { kinds, faults: Vec::new() }
    }

    /// The kind of a connection or literal, where known.
    pub fn kind(&self, source: &Source<Vec<f64>>) -> Option<Kind> {
        (self.kinds)(source)
    }

    /// Reports an error.
    pub fn error(&mut self, item: &'static str, found: impl ToString, expected: impl ToString, remedy: impl ToString) {
        let (found, expected, remedy) = (found.to_string(), expected.to_string(), remedy.to_string());
        self.faults.push(Fault { item, found, expected, remedy, warning: false });
    }

    /// Reports a warning.
    pub fn warning(
        &mut self,
        item: &'static str,
        found: impl ToString,
        expected: impl ToString,
        remedy: impl ToString,
    ) {
        let (found, expected, remedy) = (found.to_string(), expected.to_string(), remedy.to_string());
        self.faults.push(Fault { item, found, expected, remedy, warning: true });
    }

    /// Everything reported.
    pub fn into_faults(self) -> Vec<Fault> {
        self.faults
    }
}
