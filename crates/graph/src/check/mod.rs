//! Validation: turns a document into a checked graph, or reports all of its faults at once. Afterwards only input and
//! output, bad input data, memory or cancellation can make an evaluation fail.

mod around;
mod groups;
mod items;
mod keyed;
mod kinds;
mod knobs;
mod order;
mod outputs;
mod palette;
mod top;
mod values;
mod view;
pub(crate) mod weight_names;
mod wiring;

use crate::document::Origin;
use crate::expand::{Expanded, ExpansionFault, expand};
use crate::spanned::{Entry, Json, Spanned, shorten};
use crate::{
    Access, Check, CheckedGraph, CheckedNode, Diagnostic, Document, DocumentPlace, Fault, Item, Kind, Knob, KnobType,
    NodeId, NodeType, Record, Refusal, Registry, Setting, Settled, Severity, Term, Work, nearest, refusal,
};
use around::{Surroundings, direct_consumers};
use items::Names;
use kinds::name_kinds;
use knobs::KnobValue;
use palette::Palette;
use std::collections::HashMap;
use std::path::Path;
pub use top::FORMAT_VERSION;
use top::Top;
pub use values::expected;

/// Checks a document against the node types of a registry.
///
/// `folder` is the folder to which paths in the document are relative. The result contains the graph if no diagnostic
/// is an error, and all diagnostics in the order of the text.
pub fn check(document: &Document, registry: &Registry, folder: &Path) -> (Option<CheckedGraph>, Vec<Diagnostic>) {
    let expanded = expand(document, registry);
    let mut checker = Checker {
        document,
        expanded: &expanded,
        registry,
        diagnostics: Vec::new(),
        space: Default::default(),
        palette: Palette::default(),
        knob_values: knobs::values(&expanded.knobs),
        records: Vec::new(),
        element: None,
        has_gaps: false,
    };
    let graph = checker.graph(folder);
    let mut diagnostics = checker.diagnostics;
    // Assignments first.
    diagnostics
        .sort_by(|a, b| (!a.is_assigned, &a.file, a.line, a.column).cmp(&(!b.is_assigned, &b.file, b.line, b.column)));
    diagnostics.dedup();
    let valid = diagnostics.iter().all(|diagnostic| diagnostic.severity == Severity::Warning);
    (graph.filter(|_| valid), diagnostics)
}

/// Walks a document and collects diagnostics.
struct Checker<'a> {
    document: &'a Document,
    expanded: &'a Expanded<'a>,
    registry: &'a Registry,
    diagnostics: Vec<Diagnostic>,
    space: trochoid_image::WorkingSpace,
    palette: Palette<'a>,
    /// Ports that take values of the document's knobs.
    knob_values: HashMap<usize, KnobValue>,
    /// Lists that are being read, each with the index of the record.
    records: Vec<(&'static str, usize)>,
    /// Index of what is read of a list of connections.
    element: Option<usize>,
    /// Whether a list of connections of the node that is being read lacks what was faulty.
    has_gaps: bool,
}

/// Place of a fault: byte offset, node, port or knob.
#[derive(Clone, Copy)]
struct FaultLocation<'a> {
    offset: usize,
    node: Option<&'a str>,
    port: Option<&'a str>,
}

impl<'a> FaultLocation<'a> {
    fn top(offset: usize, port: &'a str) -> Self {
        Self { offset, node: None, port: Some(port) }
    }

    fn at(self, offset: usize) -> Self {
        Self { offset, ..self }
    }
}

/// A node between parsing and wiring.
struct Draft<'a> {
    name: &'a str,
    offset: usize,
    /// `None` if the type is unknown; then references to the node are not checked against it.
    ty: Option<&'static NodeType>,
    disabled: bool,
    record: Record,
    /// The record at the first frame, with the connections of the last call of [`name_kinds`].
    settled: Option<Settled>,
    /// Place of each item in the text.
    offsets: Vec<(&'static str, usize)>,
    /// Whether items of the node are faulty; then checks across knobs are skipped, which would only repeat the faults.
    faulty: bool,
    /// Whether one of its lists of connections lacks what was faulty; then its number of weights is unknown.
    has_gaps: bool,
    kinds: Vec<Kind>,
}

impl Draft<'_> {
    /// Whether a choice without a default is missing or not one of the legal words.
    fn lacks_a_choice(&self) -> bool {
        let items = self.ty.map_or(&[][..], |ty| ty.declaration().items);
        self.faulty
            && items.iter().any(|item| match item {
                Item::Knob(knob @ Knob { default: None, takes: KnobType::Choice(_), .. }) => {
                    !self.record.knobs.iter().any(|(name, value)| *name == knob.name && *value != Setting::Unset)
                }
                _ => false,
            })
    }

    /// Returns the kinds of its outputs; none if they are unknown.
    fn kinds_of(&self, settled: &Settled) -> Vec<Kind> {
        let kinds = settled.kinds();
        let is_unknown = self.has_gaps && kinds.iter().any(|kind| matches!(kind, Kind::Weights(_)));
        // A wrong choice may be the one that decides the kinds.
        if is_unknown || self.lacks_a_choice() { Vec::new() } else { kinds }
    }

    /// Returns the place of an item in the text, or that of the node if the document does not set the item.
    fn offset_of(&self, item: &str) -> usize {
        self.offsets.iter().find(|known| known.0 == item).map_or(self.offset, |known| known.1)
    }
}

impl<'a> Checker<'a> {
    fn report(
        &mut self,
        severity: Severity,
        place: FaultLocation<'_>,
        found: String,
        expected: String,
        remedy: String,
    ) -> Option<&mut Diagnostic> {
        // Nobody reads a longer list of faults.
        if self.is_full() {
            return None;
        }
        let origin = self.document.origin(place.offset);
        let used = place.node.and_then(|node| self.use_of(node));
        self.diagnostics.push(Diagnostic {
            severity,
            is_assigned: origin.is_assigned,
            file: origin.file.to_string(),
            line: origin.line,
            column: origin.column,
            node: place.node.map(shorten),
            port: place.port.map(shorten),
            found,
            expected,
            remedy,
            means: None,
            used,
        });
        self.diagnostics.last_mut()
    }

    /// Whether no more diagnostics are accepted, so that expensive work for them can be skipped.
    fn is_full(&self) -> bool {
        self.diagnostics.len() >= 1000
    }

    fn error(
        &mut self,
        place: FaultLocation<'_>,
        found: impl ToString,
        expected: impl ToString,
        remedy: impl ToString,
    ) {
        self.report(Severity::Error, place, found.to_string(), expected.to_string(), remedy.to_string());
    }

    /// Returns the entries of an object; reports other values and duplicate keys.
    fn object(&mut self, value: &'a Spanned, place: FaultLocation<'_>, expected: &str) -> Option<Vec<&'a Entry>> {
        let Json::Object(entries) = &value.json else {
            self.error(place.at(value.offset), value.brief(), expected, "write a JSON object: { … }");
            return None;
        };
        let mut seen = HashMap::new();
        let mut kept: Vec<&Entry> = Vec::with_capacity(entries.len());
        for entry in entries {
            // Most objects have few keys, for which a linear search is faster than hashing.
            let first = if entries.len() <= 16 {
                kept.iter().find(|known| known.key == entry.key).map(|known| known.offset)
            } else {
                seen.insert(entry.key.as_str(), entry.offset)
            };
            if let Some(first) = first {
                let Origin { line, column, .. } = self.document.origin(first);
                self.error(
                    place.at(entry.offset),
                    format!("a second \"{}\"", shorten(&entry.key)),
                    format!("each name once; the first is at {line}:{column}"),
                    "rename or remove one of them",
                );
            } else {
                kept.push(entry);
            }
        }
        Some(kept)
    }

    /// Reports a key that is not in `known`.
    fn unknown_key(&mut self, place: FaultLocation<'_>, key: &str, known: &[&str]) {
        let remedy = match nearest(key, known.iter().copied()) {
            Some(near) => format!("did you mean \"{near}\"?"),
            None => format!("rename it to one of these, or remove it: {}", known.join(", ")),
        };
        self.error(place, format!("unknown key \"{}\"", shorten(key)), "a known key", remedy);
    }

    fn graph(&mut self, folder: &Path) -> Option<CheckedGraph> {
        let document = self.document;
        let root = self.object(
            &self.expanded.root,
            FaultLocation::top(0, "document"),
            "an object with \"trochoid\", \"format\", \"nodes\" and \"outputs\"",
        )?;
        if root.iter().any(|entry| entry.key == "trochoid_palette") {
            let remedy = "give a document; it names this file as its \"palette\"";
            self.error(FaultLocation::top(0, "document"), "a palette", "a document", remedy);
            return None;
        }
        let top = self.top(&root);
        self.palette(&root);
        for ExpansionFault { offset, node, item, found, expected, remedy } in self.expanded.faults.clone() {
            let place = FaultLocation { offset, node: node.as_deref(), port: item.as_deref() };
            self.error(place, found, expected, remedy);
        }
        if !self.expanded.is_whole {
            return None;
        }
        let entries = match root.iter().find(|entry| entry.key == "nodes") {
            Some(entry) => {
                self.object(&entry.value, FaultLocation::top(entry.value.offset, "nodes"), "an object of nodes by name")
            }
            None => {
                self.error(
                    FaultLocation::top(0, "nodes"),
                    "no \"nodes\"",
                    "an object of nodes by name",
                    "add \"nodes\": { … }",
                );
                None
            }
        };
        let entries = entries.unwrap_or_default();
        if entries.len() > crate::document::MAX_NODES {
            let found = format!("{} nodes", entries.len());
            self.error(
                FaultLocation::top(0, "nodes"),
                found,
                format!("at most {} nodes", crate::document::MAX_NODES),
                "split the scene into several documents",
            );
            return None;
        }
        let mut drafts: Vec<Draft<'a>> = entries.iter().map(|entry| self.draft(entry)).collect();
        let names: Names<'a> =
            drafts.iter().enumerate().map(|(i, d)| (d.name, (i, d.ty.map(NodeType::declaration)))).collect();
        for (draft, entry) in drafts.iter_mut().zip(&entries) {
            self.fill_in(draft, entry, &names);
        }
        name_kinds(&mut drafts, top.first);
        if drafts.iter().any(|draft| draft.disabled) {
            self.bypass_disabled(&mut drafts);
            // If a disabled node made a list of connections shorter, the number of weights may have changed.
            name_kinds(&mut drafts, top.first);
        }
        self.weight_names(&drafts, &entries);
        self.inputs_of_groups(&drafts, &names);
        self.connections(&drafts);
        self.loops(&drafts)?;
        self.node_rules(&drafts, &top);
        let outputs = match root.iter().find(|entry| entry.key == "outputs") {
            Some(entry) => self.outputs(&entry.value, &drafts, &names),
            None => {
                let place = FaultLocation::top(0, "outputs");
                self.error(
                    place,
                    "no \"outputs\"",
                    "at least one output",
                    "add \"outputs\": { \"beauty\": { \"color\": … } }",
                );
                Vec::new()
            }
        };
        self.unused(&drafts, &outputs);
        let find = |name: &str| names.get(name).map(|(index, _)| NodeId(*index));
        let palette = self.palette_colors(&find);
        let knobs = self.document_knobs(&find);
        if self.diagnostics.iter().any(|diagnostic| diagnostic.severity == Severity::Error) {
            return None;
        }
        let nodes = drafts
            .into_iter()
            .map(|draft| {
                let ty = draft.ty?;
                let Draft { name, disabled, record, kinds, offset, offsets, .. } = draft;
                let place = |offset: usize| {
                    let Origin { file, line, column, .. } = document.origin(offset);
                    DocumentPlace { document: file, line, column }
                };
                let places = offsets.into_iter().map(|(item, offset)| (item, place(offset)));
                // Values from `--set` have no place in the document.
                let places = places.filter(|(_, place)| place.line > 0).collect();
                Some(CheckedNode { name: name.into(), ty, record, kinds, disabled, place: place(offset), places })
            })
            .collect::<Option<Vec<_>>>()?;
        let graph = CheckedGraph {
            name: document.name().into(),
            folder: folder.into(),
            format: top.format?,
            document_format: top.format.filter(|_| !document.has_no_size),
            format_place: format_place(document, &root),
            space: self.space,
            palette,
            knobs,
            document_files: document.paths().map(Path::to_path_buf).collect(),
            first: top.first,
            last: top.last,
            fps: top.fps,
            tolerance: top.tolerance,
            order: order::order_of_use(&nodes, &outputs),
            nodes,
            groups: self.group_uses(),
            outputs,
            canonical: document.canonical_with(&self.expanded.moved),
            access: Access::usual(folder),
            recipes: None,
        };
        let all: Vec<usize> = (0..graph.outputs.len()).collect();
        if graph.has_recipe(&all) {
            self.diagnostics.extend(graph.clone().with_recipes(&all).err().into_iter().flatten());
        }
        Some(graph)
    }

    /// Reads a node's name and type.
    fn draft(&mut self, entry: &'a Entry) -> Draft<'a> {
        let name = entry.key.as_str();
        let place = FaultLocation { offset: entry.offset, node: Some(name), port: None };
        if name == "palette" {
            self.error(
                place,
                "the name \"palette\"",
                "a name of its own",
                "rename the node: these are the document's colors",
            );
        }
        // The names of uses stand before those of a group's nodes.
        let own = match name.rsplit_once('/') {
            Some((path, own)) if self.expanded.uses.iter().any(|used| used.path == path) => own,
            _ => name,
        };
        if !is_legal_name(own) && !self.expanded.picks.contains(name) {
            let found = format!("the name \"{}\"", shorten(own));
            self.error(place, found, "a–z, A–Z, 0–9 and _, not starting with a digit", "rename the node");
        }
        let mut draft = Draft {
            name,
            offset: entry.offset,
            ty: None,
            disabled: false,
            record: Record::default(),
            settled: None,
            offsets: Vec::new(),
            faulty: false,
            has_gaps: false,
            kinds: Vec::new(),
        };
        let Json::Object(items) = &entry.value.json else {
            self.error(place, entry.value.brief(), "an object with a \"type\"", "write { \"type\": … }");
            return draft;
        };
        match items.iter().find(|item| item.key == "type") {
            None => {
                self.error(
                    place,
                    "no \"type\"",
                    "the type of the node",
                    "add \"type\"; `trochoid nodes` lists the types",
                );
            }
            Some(Entry { value: Spanned { json: Json::String(ty), offset }, .. }) => {
                draft.ty = self.registry.get(ty);
                if draft.ty.is_none() {
                    self.unknown_type(FaultLocation { offset: *offset, node: Some(name), port: Some("type") }, ty);
                }
            }
            Some(item) => {
                let place = FaultLocation { offset: item.value.offset, node: Some(name), port: Some("type") };
                self.error(place, item.value.brief(), "the name of a node type", "`trochoid nodes` lists the types");
            }
        }
        draft
    }

    /// Reports an operation on colors that leaves the hull.
    fn refused(&mut self, place: FaultLocation<'_>, name: &str, refusal: &Refusal) {
        let found = format!("the operation {}", shorten(name));
        let expected = format!("a convex operation: {}; {}", refusal.reason, refusal.witness);
        self.error(place, found, expected, refusal.rewrite);
    }

    fn unknown_type(&mut self, place: FaultLocation<'_>, ty: &str) {
        if let Some(refusal) = refusal(ty) {
            return self.refused(place, ty, refusal);
        }
        let groups = &self.expanded.groups;
        let near =
            nearest(ty, self.registry.names().map(|name| -> &str { name }).chain(groups.iter().map(String::as_str)));
        let term = Term::of(ty, self.registry);
        let remedy = match (term, near) {
            (Some(term), Some(near)) if term.node() != Some(near) => {
                format!("{}; or did you mean \"{near}\"?", term.remedy())
            }
            (Some(term), _) => term.remedy(),
            (None, Some(near)) => format!("did you mean \"{near}\"?"),
            (None, None) => "`trochoid nodes` lists the types".into(),
        };
        self.error(place, format!("unknown node type \"{}\"", shorten(ty)), "a node type", remedy);
    }

    /// Runs each node's own checks: at the first and last frame and at every key, or only once if nothing is keyed.
    fn node_rules(&mut self, drafts: &[Draft<'_>], top: &Top) {
        let (first, last) = (top.first, top.last);
        let consumers = direct_consumers(drafts);
        for (index, draft) in drafts.iter().enumerate().filter(|(_, draft)| !draft.faulty && !draft.disabled) {
            let (Some(ty), Some(settled)) = (draft.ty, &draft.settled) else { continue };
            let (mut faults, mut work): (Vec<Fault>, Option<Work>) = (Vec::new(), None);
            let mut rules = |frame: f64, settled: &Settled| {
                let around =
                    Surroundings { registry: self.registry, drafts, consumers: &consumers, node: index, frame };
                let mut check = Check::new(&around);
                settled.node().check(&mut check);
                faults.extend(check.into_faults());
                let at = |time: f64| top.format.and_then(|format| settled.node().work(format, time));
                // A simulation takes only the steps since the frame before.
                let next = if last > first { at(1.0 / top.fps) } else { None };
                let here = at(0.0);
                let between = next.zip(here).map(|(next, here)| Work { seconds: next.seconds - here.seconds, ..next });
                let all = here.into_iter().chain(between).chain(work);
                work = all.max_by(|a, b| a.seconds.total_cmp(&b.seconds));
            };
            let mut frames = draft.record.key_frames();
            if frames.is_empty() {
                rules(first as f64, settled);
            } else {
                frames.extend([first as f64, last as f64]);
                frames.sort_by(f64::total_cmp);
                frames.dedup();
                frames.into_iter().for_each(|frame| rules(frame, &ty.settle(draft.record.settle(frame))));
            }
            faults.dedup();
            // A faulty value may be the reason for the long time.
            if let Some(work) = work.filter(|work| work.is_heavy() && faults.iter().all(|fault| fault.warning)) {
                let (item, found, expected, remedy) = (work.item, work.found(), Work::expected(), work.remedy.into());
                faults.push(Fault { item, found, expected, remedy, warning: true });
            }
            for fault in faults {
                let offset = draft.offset_of(fault.item.as_str());
                let place = FaultLocation { offset, node: Some(draft.name), port: Some(fault.item.as_str()) };
                let severity = if fault.warning { Severity::Warning } else { Severity::Error };
                self.report(severity, place, fault.found, fault.expected, fault.remedy);
            }
        }
    }
}

/// Whether a text may be the name of a node or of a color.
pub(crate) fn is_legal_name(name: &str) -> bool {
    name.starts_with(|c: char| c.is_ascii_alphabetic() || c == '_')
        && name.chars().all(|c| c.is_ascii_alphanumeric() || c == '_')
}

/// Returns line and column of the format.
fn format_place(document: &Document, root: &[&Entry]) -> [usize; 2] {
    let format = root.iter().find(|entry| entry.key == "format");
    let origin = document.origin(format.map_or(0, |entry| entry.value.offset));
    [origin.line, origin.column]
}
