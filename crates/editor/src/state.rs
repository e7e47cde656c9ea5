//! Shared state of the panels: the document, the selection, and the evaluated pictures. Independent of drawing.

use crate::actions::{OtherPalette, Tint};
use crate::document::group::NoGroup;
use crate::document::json::Misplaced;
use crate::document::meaning::Meaning;
use crate::document::swatches::{Swatch, SwatchKey, add_elsewhere, swatches};
use crate::document::{Edit, Node, Path, Session, Sheet, decor, group, keyed};
use crate::evaluate::{Blamed, Display, Graphics, Mixture, Result, Screen};
use std::collections::{BTreeMap, BTreeSet, HashMap};
use std::sync::Arc;
use std::time::Instant;
use trochoid::{NodeReport, RefusedFile, State as Became};

/// Why an edit cannot be made.
#[derive(Debug, thiserror::Error)]
pub enum NoEdit {
    /// It names a place that does not exist.
    #[error(transparent)]
    Misplaced(#[from] Misplaced),
    /// It changes a group that cannot be changed.
    #[error(transparent)]
    Group(#[from] NoGroup),
}

/// Shared state that panels draw. Panels do not modify it; they request changes by [`Action`](crate::actions::Action)s.
#[derive(Debug)]
pub struct State {
    /// The document.
    pub session: Session,
    /// Names of the uses that are entered, from the outermost one; empty at the top of the document.
    pub scope: Vec<String>,
    /// The inside of the innermost entered use.
    inner: Option<Arc<Sheet>>,
    /// The inside of the use that has the viewed node; `None` if the document itself has it.
    around: Option<Arc<Sheet>>,
    /// What the second viewer shows.
    pub second: Second,
    /// Names of the selected nodes.
    pub selection: BTreeSet<String>,
    /// Selected output, if no node is selected.
    pub output: Option<String>,
    /// Subject and display settings of the viewer.
    pub look: Look,
    /// Results of evaluation.
    pub evaluated: Evaluated,
    /// Current frame.
    pub frame: i64,
    /// Whether playback is running.
    pub playing: bool,
    /// First and last frame to play and render.
    pub range: (i64, i64),
    /// Rendering in progress, if any.
    pub render: Option<Render>,
    /// Place in the document that receives the next color clicked in the picture.
    pub dropper: Option<Path>,
    /// What the palette panel looks at.
    pub colors: Colors,
    /// The graphics card, if there is one.
    pub graphics: Graphics,
}

/// What the second viewer shows, in the place of the first one's.
#[derive(Debug, Default)]
pub struct Second {
    /// Subject and display settings.
    pub look: Look,
    /// Results of evaluation.
    pub evaluated: Evaluated,
    around: Option<Arc<Sheet>>,
}

/// What the palette panel looks at. Nothing of it changes the document.
#[derive(Clone, Debug, Default)]
pub struct Colors {
    /// The selected color.
    pub chosen: Option<SwatchKey>,
    /// The color that is being dragged.
    pub tint: Option<Tint>,
    /// The palette in which the picture is shown instead of the document's.
    pub compared: Option<Arc<OtherPalette>>,
    /// Whether the viewer shows where the selected color is.
    pub spot: bool,
    /// Pixel under the pointer, in fractions of the picture.
    pub hover: Option<[f32; 2]>,
}

/// Subject and display of the viewer.
#[derive(Clone, Debug, PartialEq)]
pub struct Look {
    /// Viewed node, by its name in the expanded document, and index of its output; `None` shows nothing.
    pub node: Option<(String, usize)>,
    /// Nodes assigned to the keys 1 to 9.
    pub slots: [Option<String>; 9],
    /// Mapping of values to brightness.
    pub display: Display,
    /// Factor by which the picture is smaller than the document's.
    pub proxy: u32,
    /// Region to evaluate, in fractions of the picture.
    pub region: Option<[f32; 4]>,
    /// Inspected pixel, in fractions of the picture.
    pub pick: Option<[f32; 2]>,
    /// Whether the frames beside the current one are mixed over it.
    pub onion: bool,
}

impl Default for Look {
    fn default() -> Self {
        let (slots, display) = Default::default();
        Self { node: None, slots, display, proxy: 1, region: None, pick: None, onion: false }
    }
}

/// Results of evaluation.
#[derive(Debug, Default)]
pub struct Evaluated {
    /// Newest picture of the viewed result; it may show an older text until a newer picture arrives.
    pub result: Option<Arc<Result>>,
    /// Newest finished picture, for whose pixels paintings stand.
    pub whole: Option<Arc<Result>>,
    /// Picture painted from a recipe, which is shown instead of the result.
    pub painted: Option<Arc<Result>>,
    /// Time at which the painted picture was ready to be shown.
    pub painted_at: Option<Instant>,
    /// Recipe of the viewed picture.
    pub mixture: Option<Arc<Mixture>>,
    /// Why the viewed picture has no recipe, as a sentence.
    pub unmixed: Option<String>,
    /// Completed share of the recipe of the viewed picture, from 0 to 1, while it is awaited.
    pub mixing: Option<f32>,
    /// Last picture, if there is no current one: it stays visible until there is another.
    pub last: Option<Arc<Result>>,
    /// Message why there is no picture, as a sentence.
    pub failed: Option<String>,
    /// Node at fault, if the fault appears only in evaluation.
    pub culprit: Option<String>,
    /// Whether evaluation itself failed, rather than there being nothing to view.
    pub broken: bool,
    /// Files that evaluation failed on because the document may not read them.
    pub refused: Vec<RefusedFile>,
    /// Completed fraction of the picture; `None` if nothing is being evaluated.
    pub progress: Option<f32>,
    /// Report of each node's last evaluation, by name.
    pub nodes: HashMap<String, NodeReport>,
    /// Thumbnails of nodes, by name.
    pub thumbnails: HashMap<String, Arc<Screen>>,
    /// Cached frames of the current document, for playback.
    pub frames: BTreeMap<i64, Arc<Result>>,
    /// Frame rate over the last played frames.
    pub rate: Option<f64>,
    /// Composition of the inspected pixel; that of the previous pixel until the new one is known.
    pub blame: Option<Blamed>,
    /// Past evaluations, newest last.
    pub past: Vec<PastEvaluation>,
}

/// A finished evaluation.
#[derive(Clone, Debug, PartialEq)]
pub struct PastEvaluation {
    /// The node.
    pub node: String,
    /// The frame.
    pub frame: i64,
    /// Factor by which the picture was smaller than the document's.
    pub shrunk: u32,
    /// Seconds for preparation, and in total.
    pub seconds: [f64; 2],
    /// Number of pixels outside the hull; `None` if the picture is not a color.
    pub exits: Option<u64>,
}

/// Progress of a rendering.
#[derive(Clone, Debug, PartialEq)]
pub struct Render {
    /// Number of finished frames, and of all frames.
    pub done: (usize, usize),
    /// Completed fraction of the current frame.
    pub share: f32,
}

impl Evaluated {
    /// Returns the picture that the viewer shows: the painted one, if there is one.
    pub fn shown(&self) -> Option<&Arc<Result>> {
        self.painted.as_ref().filter(|_| self.result.is_some()).or(self.result.as_ref())
    }
}

impl State {
    /// Creates the state for a newly opened document, with its first output in the viewer.
    pub fn new(session: Session, graphics: Graphics) -> Self {
        let mut state = Self {
            session,
            scope: Vec::new(),
            inner: None,
            around: None,
            second: Second::default(),
            selection: BTreeSet::new(),
            output: None,
            look: Look::default(),
            evaluated: Evaluated::default(),
            frame: 0,
            playing: false,
            range: (0, 0),
            render: None,
            dropper: None,
            colors: Colors::default(),
            graphics,
        };
        state.begin();
        state
    }

    /// Views the document's first output at its first frame.
    pub fn begin(&mut self) {
        let sheet = self.session.sheet().clone();
        let (first, last, _) = sheet.frames;
        (self.frame, self.range) = (first, (first, last));
        self.look.node = Self::first_output(&sheet);
        for (slot, output) in self.look.slots.iter_mut().zip(&sheet.outputs) {
            *slot = sheet.source(&output.source).map(|(node, _)| sheet.nodes[node].name.clone());
        }
        self.read_insides();
    }

    /// Returns the result that the document's first output renders.
    pub fn first_output(sheet: &Sheet) -> Option<(String, usize)> {
        let source = sheet.outputs.iter().find_map(|output| sheet.source(&output.source));
        source.map(|(node, output)| (sheet.nodes[node].name.clone(), output))
    }

    /// Updates the viewed, assigned, and selected nodes after nodes beside each other were renamed; `prefix` stands before
    /// their names in the expanded document.
    pub fn rename(&mut self, names: &[(String, String)], prefix: &str) {
        for (old, new) in names {
            let (whole, inside) = (format!("{prefix}{old}"), format!("{prefix}{old}/"));
            let looked = self.look.node.iter_mut().chain(&mut self.second.look.node).map(|(name, _)| name);
            for name in looked.chain(self.look.slots.iter_mut().flatten()) {
                if *name == whole {
                    *name = format!("{prefix}{new}");
                } else if let Some(rest) = name.strip_prefix(&inside) {
                    *name = format!("{prefix}{new}/{rest}");
                }
            }
            if self.selection.remove(old) {
                self.selection.insert(new.clone());
            }
        }
    }

    /// Returns the sheet that the canvas draws: the document, or the inside of the use that is entered.
    pub fn sheet(&self) -> &Arc<Sheet> {
        self.inner.as_ref().unwrap_or(self.session.sheet())
    }

    /// Reads the insides of uses again, after a change of the document, the scope or the view. Uses that are gone are
    /// left.
    pub fn read_insides(&mut self) {
        let meaning = self.session.meaning();
        let (root, graph) = (&meaning.sheet, meaning.graph.as_deref());
        let entered = |names: &[String]| group::enter(root, names, graph).map(Arc::new);
        self.inner = None;
        while !self.scope.is_empty() && self.inner.is_none() {
            self.inner = entered(&self.scope);
            if self.inner.is_none() {
                self.scope.pop();
            }
        }
        let around = |look: &Look| {
            let (path, _) = look.node.as_ref()?.0.rsplit_once('/')?;
            let names: Vec<String> = path.split('/').map(String::from).collect();
            if names == self.scope { self.inner.clone() } else { entered(&names) }
        };
        let (first, second) = (around(&self.look), around(&self.second.look));
        (self.around, self.second.around) = (first, second);
    }

    /// Puts what the second viewer shows in the place of what the first one shows, and the other way around. Both have the
    /// same nodes under the number keys.
    pub(crate) fn turn(&mut self) {
        let second = &mut self.second;
        std::mem::swap(&mut self.look, &mut second.look);
        std::mem::swap(&mut self.look.slots, &mut second.look.slots);
        std::mem::swap(&mut self.evaluated, &mut second.evaluated);
        std::mem::swap(&mut self.around, &mut second.around);
    }

    /// Updates the names of entered uses after nodes of the document were renamed.
    pub fn rename_scope(&mut self, names: &[(String, String)]) {
        if let Some(first) = self.scope.first_mut()
            && let Some((_, new)) = names.iter().find(|(old, _)| old == first)
        {
            first.clone_from(new);
        }
    }

    /// Returns an edit of the sheet that the canvas draws as one of the document.
    ///
    /// # Errors
    /// The sheet is that of a group whose definition is in another file.
    pub fn in_document(&self, edit: Edit) -> std::result::Result<Edit, NoGroup> {
        let sheet = self.sheet();
        match &sheet.within {
            Some(within) => within.rebased(&sheet.library, decor::following(sheet, edit)),
            None => Ok(edit),
        }
    }

    /// Returns what the sheet that the canvas draws would be after an edit of it, with the meaning of the document.
    ///
    /// # Errors
    /// The edit names a place that does not exist, or the group's definition is in another file.
    pub fn after(&self, edit: &Edit) -> std::result::Result<(Meaning, Arc<Sheet>), NoEdit> {
        let meaning = self.session.after(&self.in_document(edit.clone())?)?;
        let inside = group::enter(&meaning.sheet, &self.scope, meaning.graph.as_deref());
        let sheet = inside.map_or_else(|| meaning.sheet.clone(), Arc::new);
        Ok((meaning, sheet))
    }

    /// Returns the name in the expanded document of a node of the sheet that the canvas draws.
    pub fn whole_name(&self, name: &str) -> String {
        format!("{}{name}", self.sheet().prefix())
    }

    /// Returns the node of the sheet that the canvas draws which has this name in the expanded document, or is the use that
    /// has it.
    pub fn own_name<'n>(&self, whole: &'n str) -> Option<&'n str> {
        let own = whole.strip_prefix(&self.sheet().prefix())?;
        Some(own.split_once('/').map_or(own, |(name, _)| name))
    }

    /// Returns the viewed node with the sheet that has it, and the index of its output.
    pub fn looked(&self) -> Option<(&Arc<Sheet>, usize, usize)> {
        let (name, output) = self.look.node.as_ref()?;
        let (sheet, own) = match name.rsplit_once('/') {
            Some((_, own)) => (self.around.as_ref()?, own),
            None => (self.session.sheet(), name.as_str()),
        };
        Some((sheet, sheet.find(own)?, *output))
    }

    /// Returns what the last evaluation tells of a node of the sheet that the canvas draws; of a use, the sum of its nodes.
    pub fn report(&self, node: &Node) -> Option<NodeReport> {
        let whole = self.whole_name(&node.name);
        if !node.is_use {
            return self.evaluated.nodes.get(&whole).cloned();
        }
        let inside = format!("{whole}/");
        let mut all = self.evaluated.nodes.iter().filter(|(name, _)| name.starts_with(&inside)).map(|(_, own)| own);
        let mut sum = all.next()?.clone();
        for own in all {
            sum.seconds += own.seconds;
            sum.estimated |= own.estimated;
            // Left out as a whole only if every node is.
            if matches!(sum.state, Became::LeftOut(_)) || matches!(own.state, Became::Evaluated) {
                sum.state = own.state.clone();
            }
        }
        Some(sum)
    }

    /// Returns the frames with keys of the selected nodes; if none is selected, of all.
    pub fn key_frames(&self) -> Vec<f64> {
        keyed::frames(&keyed::channels(self.sheet(), &self.selection))
    }

    /// Returns the next frame, or the previous one, that has such a key.
    pub fn next_key(&self, forward: bool) -> Option<i64> {
        let frames = self.key_frames().into_iter().map(|frame| frame.round() as i64);
        match forward {
            true => frames.filter(|frame| *frame > self.frame).min(),
            false => frames.filter(|frame| *frame < self.frame).max(),
        }
    }

    /// Returns the colors of the document at the current frame.
    pub fn swatches(&self) -> Vec<Swatch> {
        let (sheet, meaning) = (self.sheet(), self.session.meaning());
        let mut all = swatches(sheet, meaning.graph.as_deref(), self.frame);
        add_elsewhere(&mut all, sheet, &meaning.sheet);
        all
    }

    /// Returns the names under which a recipe has the selected color.
    pub fn chosen_controls(&self) -> Option<Vec<String>> {
        let chosen = self.colors.chosen.as_ref()?;
        self.swatches().iter().find(|swatch| swatch.key == *chosen).map(Swatch::controls)
    }

    /// Returns the selected node if it is a use of a group, and the only selected one.
    pub fn chosen_use(&self) -> Option<&str> {
        self.chosen().filter(|name| self.sheet().node(name).is_some_and(|node| node.is_use))
    }

    /// Returns the group of an included file that is meant: the outermost one that is entered, since what is inside of it is
    /// used by that file, or else that of the selected use.
    pub fn foreign(&self) -> Option<&str> {
        let sheet = self.sheet();
        let entered = sheet.within.iter().flat_map(|within| &within.uses).map(|(_, group)| group.as_str());
        let used = self.chosen_use().and_then(|name| sheet.node(name)).map(|node| node.ty.as_str());
        entered.chain(used).find(|name| sheet.library.group(name).is_some_and(|group| group.file.is_some()))
    }

    /// Returns the selected node if exactly one is selected.
    pub fn chosen(&self) -> Option<&str> {
        let mut names = self.selection.iter();
        names.next().filter(|_| names.next().is_none()).map(String::as_str)
    }

    /// Returns the fault that appears only in evaluation, not in the document: the node, if the fault belongs to one,
    /// and the message.
    pub fn broken(&self) -> Option<(Option<&str>, &str)> {
        let (seen, meaning) = (&self.evaluated, self.session.meaning());
        let failed = seen.failed.as_deref().filter(|_| seen.broken)?;
        let culprit = seen.culprit.as_deref();
        // A known error of the node is assumed to be the same fault.
        let known = meaning.errors().any(|error| error.node.as_deref() == culprit);
        (!known).then_some((culprit, failed))
    }

    /// Returns whether a fault belongs to a node of the sheet that the canvas draws, or to one inside of it.
    pub fn is_of(&self, fault: &trochoid::Diagnostic, name: &str) -> bool {
        fault.node.as_deref().and_then(|whole| self.own_name(whole)) == Some(name)
    }

    /// Returns the first fault of a node, or of the nearest faulty node above it, with the name of that node.
    pub fn fault_of(&self, node: usize) -> Option<(&str, &trochoid::Diagnostic)> {
        let sheet = self.sheet();
        let faults = &self.session.meaning().diagnostics;
        let own = |node: usize| {
            let name = &sheet.nodes[node].name;
            let errors = faults.iter().filter(|fault| fault.severity == trochoid::Severity::Error);
            let fault = errors.into_iter().find(|fault| self.is_of(fault, name))?;
            Some((name.as_str(), fault))
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
