//! What is open, what is chosen and what is seen: all that panels draw. Nothing here draws.

use crate::document::{Path, Session, Sheet};
use crate::evaluate::{Blamed, Display, Result, Screen};
use std::collections::{BTreeMap, BTreeSet, HashMap};
use std::sync::Arc;
use trochoid::{NodeReport, RefusedFile};

/// All that panels draw. They change nothing in it but ask for it by [`Action`](crate::actions::Action)s.
#[derive(Debug)]
pub struct State {
    /// The document.
    pub session: Session,
    /// Names of the nodes that are chosen.
    pub selection: BTreeSet<String>,
    /// The output that is chosen, where no node is.
    pub output: Option<String>,
    /// What the viewer shows.
    pub look: Look,
    /// What has been evaluated.
    pub evaluated: Evaluated,
    /// The frame.
    pub frame: i64,
    /// Whether frames follow each other in real time.
    pub playing: bool,
    /// The frames that are played and rendered.
    pub range: (i64, i64),
    /// A run that writes files, if there is one.
    pub render: Option<Render>,
    /// The place in the document that takes the color of the picture that is clicked next.
    pub dropper: Option<Path>,
}

/// What the viewer shows, and how.
#[derive(Clone, Debug, PartialEq)]
pub struct Look {
    /// The node and the index of its output; nothing if `None`.
    pub node: Option<(String, usize)>,
    /// Nodes under the keys 1 to 9.
    pub slots: [Option<String>; 9],
    /// How values become brightness.
    pub display: Display,
    /// By how much the picture is smaller than the document's.
    pub proxy: u32,
    /// The part that is evaluated, in shares of the picture.
    pub region: Option<[f32; 4]>,
    /// The pixel that is inspected, in shares of the picture.
    pub pick: Option<[f32; 2]>,
}

impl Default for Look {
    fn default() -> Self {
        Self { node: None, slots: Default::default(), display: Display::default(), proxy: 1, region: None, pick: None }
    }
}

/// What has been evaluated.
#[derive(Debug, Default)]
pub struct Evaluated {
    /// The newest picture of what is looked at, which may be of an older text until there is a newer one.
    pub result: Option<Arc<Result>>,
    /// The picture before, where there is none any more: it stays in sight until there is another.
    pub last: Option<Arc<Result>>,
    /// Why there is none, in a sentence.
    pub failed: Option<String>,
    /// The node that it failed at, where what is wrong shows in evaluation alone.
    pub culprit: Option<String>,
    /// Whether it failed in evaluation, and not because there is nothing to be looked at.
    pub broken: bool,
    /// Files that it failed for because the document may not read them.
    pub refused: Vec<RefusedFile>,
    /// How much of the picture is done; `None` where nothing is being evaluated.
    pub progress: Option<f32>,
    /// What nodes did when they were last evaluated, by name.
    pub nodes: HashMap<String, NodeReport>,
    /// Small pictures of nodes, by name.
    pub thumbnails: HashMap<String, Arc<Screen>>,
    /// Pictures of the frames, as far as they are of the document as it is, for playing.
    pub frames: BTreeMap<i64, Arc<Result>>,
    /// Frames per second over the last frames that were played.
    pub rate: Option<f64>,
    /// What the pixel that is inspected is made of; of the picture before until it is known.
    pub blame: Option<Blamed>,
    /// The evaluations so far, the newest last.
    pub past: Vec<PastEvaluation>,
}

/// An evaluation that is over.
#[derive(Clone, Debug, PartialEq)]
pub struct PastEvaluation {
    /// The node.
    pub node: String,
    /// The frame.
    pub frame: i64,
    /// By how much the picture was smaller than the document's.
    pub shrunk: u32,
    /// Seconds to prepare, and in all.
    pub seconds: [f64; 2],
    /// Pixels outside the hull; `None` for what is no color.
    pub exits: Option<u64>,
}

/// A run that writes files.
#[derive(Clone, Debug, PartialEq)]
pub struct Render {
    /// Frames done, and to be done.
    pub done: (usize, usize),
    /// How much of the present frame is done.
    pub share: f32,
}

impl State {
    /// The state of a document that was just opened: its first output in the viewer.
    pub fn new(session: Session) -> Self {
        let mut state = Self {
            session,
            selection: BTreeSet::new(),
            output: None,
            look: Look::default(),
            evaluated: Evaluated::default(),
            frame: 0,
            playing: false,
            range: (0, 0),
            render: None,
            dropper: None,
        };
        state.begin();
        state
    }

    /// Looks at the document's first output, at its first frame.
    pub fn begin(&mut self) {
        let sheet = self.session.sheet().clone();
        let (first, last, _) = sheet.frames;
        (self.frame, self.range) = (first, (first, last));
        self.look.node = Self::first_output(&sheet);
        for (slot, output) in self.look.slots.iter_mut().zip(&sheet.outputs) {
            *slot = sheet.source(&output.source).map(|(node, _)| sheet.nodes[node].name.clone());
        }
    }

    /// What the document's first output shows.
    pub fn first_output(sheet: &Sheet) -> Option<(String, usize)> {
        let source = sheet.outputs.iter().find_map(|output| sheet.source(&output.source));
        source.map(|(node, output)| (sheet.nodes[node].name.clone(), output))
    }

    /// Goes on looking at nodes that have other names now.
    pub fn rename(&mut self, names: &[(String, String)]) {
        for (old, new) in names {
            let looked = self.look.node.iter_mut().map(|(name, _)| name);
            let all = looked.chain(self.look.slots.iter_mut().flatten());
            all.filter(|name| *name == old).for_each(|name| name.clone_from(new));
            if self.selection.remove(old) {
                self.selection.insert(new.clone());
            }
        }
    }

    /// What the canvas draws.
    pub fn sheet(&self) -> &Arc<Sheet> {
        self.session.sheet()
    }

    /// The chosen node, where it is exactly one.
    pub fn chosen(&self) -> Option<&str> {
        let mut names = self.selection.iter();
        names.next().filter(|_| names.next().is_none()).map(String::as_str)
    }

    /// What is wrong that the document does not show and evaluation does: the node, where it is one's, and what.
    pub fn broken(&self) -> Option<(Option<&str>, &str)> {
        let (seen, meaning) = (&self.evaluated, self.session.meaning());
        let failed = seen.failed.as_deref().filter(|_| seen.broken)?;
        let culprit = seen.culprit.as_deref();
        // What is told of the node already is the same.
        let known = meaning.errors().any(|error| error.node.as_deref() == culprit);
        (!known).then_some((culprit, failed))
    }

    /// The first fault of a node, or of the nearest one above it that has one: its name and what is wrong.
    pub fn fault_of(&self, node: usize) -> Option<(&str, &trochoid::Diagnostic)> {
        let sheet = self.sheet();
        let faults = &self.session.meaning().diagnostics;
        let own = |node: usize| {
            let name = &sheet.nodes[node].name;
            let errors = faults.iter().filter(|fault| fault.severity == trochoid::Severity::Error);
            let fault = errors.into_iter().find(|fault| fault.node.as_deref() == Some(name.as_str()))?;
            Some((fault.node.as_deref()?, fault))
        };
        if faults.is_empty() {
            return None;
        }
        own(node).or_else(|| {
            let mut above: Vec<usize> = sheet.upstream([node]).into_iter().collect();
            above.sort_unstable_by(|a, b| b.cmp(a));
            above.into_iter().find_map(own)
        })
    }
}
