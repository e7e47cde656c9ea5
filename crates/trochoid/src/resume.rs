//! Fingerprints: hashes of everything that a picture was made from, which `--resume` compares.

use crate::{Frame, OutputFile, Plan, Settings, Switches, VERSION, held, requirement};
use std::collections::HashMap;
use std::path::{Path, PathBuf};
use std::time::SystemTime;
use trochoid_graph::{CheckedGraph, ContentKey, Guarantee, KeyHasher, NodeId};
use trochoid_image::Window;

/// Metadata key of the fingerprint.
pub(crate) const FINGERPRINT: &str = "trochoid:fingerprint";
/// Metadata key of the fingerprint that the whole picture of a region has.
pub(crate) const WHOLE: &str = "trochoid:whole";
/// Version of the fingerprint's definition. Files with another version are rendered again.
const RECIPE: u32 = 3;
/// Metadata key for the names of the outputs in a file.
pub(crate) const OUTPUTS: &str = "trochoid:outputs";
/// Metadata key of the weakest guarantee that was found to hold on a color of the file.
pub(crate) const HELD: &str = "trochoid:held";
/// Metadata key of the guarantees of colors, with the number of pixels outside.
pub(crate) const GUARANTEE: &str = "trochoid:guarantee";

/// Length and modification time. A file with the same ones counts as unchanged, as in the cache of an evaluation.
type State = Option<(u64, Option<SystemTime>)>;

/// Fingerprints of the files of a run. An input file is hashed again only if it has changed.
#[derive(Debug, Default)]
pub struct Fingerprints {
    settings: Settings,
    by_reference: bool,
    inputs: HashMap<PathBuf, (State, String)>,
}

impl Fingerprints {
    /// Creates fingerprints for a run with default settings.
    pub fn new() -> Self {
        Self::default()
    }

    /// Creates fingerprints for a run with these settings.
    pub fn with(settings: &Settings) -> Self {
        Self { settings: settings.clone(), ..Self::default() }
    }

    /// Sets whether pictures are evaluated [by the references](Plan::evaluate_by_reference).
    #[must_use]
    pub fn by_reference(self, by_reference: bool) -> Self {
        Self { by_reference, ..self }
    }

    /// Returns the hash of everything that a file's bytes depend on: versions of the program and the nodes, the
    /// document (including `--set`), the frame, the outputs, settings that affect the picture or its metadata, and the
    /// contents of all input files. An input that cannot be read contributes the reason.
    pub fn of(&mut self, graph: &CheckedGraph, file: &OutputFile, frame: i64) -> String {
        self.of_region(graph, file, frame, self.settings.region)
    }

    /// Returns the hash of a region; of the whole picture for `None`.
    fn of_region(&mut self, graph: &CheckedGraph, file: &OutputFile, frame: i64, region: Option<Window>) -> String {
        let context = graph.frame_context(frame, u64::MAX);
        let roots = file.outputs.iter().map(|index| graph.outputs()[*index].node);
        let reached = graph.dependencies(roots, frame);
        let mut hasher = KeyHasher::new();
        let names: Vec<&str> = file.outputs.iter().map(|index| graph.outputs()[*index].name.as_str()).collect();
        (RECIPE, VERSION, graph.document_hash(), frame, names).feed(&mut hasher);
        graph.format().feed(&mut hasher);
        self.shown(region, &mut hasher);
        let nodes = graph.order().iter().filter(|id| reached[id.0]).map(|id| graph.node(*id).ty.declaration());
        let nodes: Vec<(&str, u32)> = nodes.map(|declaration| (declaration.name, declaration.revision)).collect();
        nodes.feed(&mut hasher);
        // Files that the document may not read are not read for the fingerprint, either.
        let may_read = |(index, reached): (usize, bool)| reached && graph.refused(NodeId(index), &context).is_none();
        let may_read: Vec<bool> = reached.into_iter().enumerate().map(may_read).collect();
        let files = graph.files(&may_read, &context);
        files.len().feed(&mut hasher);
        for path in files {
            let state = std::fs::metadata(&path).ok().map(|found| (found.len(), found.modified().ok()));
            if self.inputs.get(&path).is_none_or(|(known, _)| *known != state) {
                let hash = hash_of(&path);
                self.inputs.insert(path.clone(), (state, hash));
            }
            self.inputs[&path].1.feed(&mut hasher);
        }
        hasher.finish().to_hex()
    }

    /// Feeds the settings that affect a file to the hash.
    fn shown(&self, region: Option<Window>, hasher: &mut KeyHasher) {
        let Settings { switches, judge, .. } = &self.settings;
        // The metadata list what is left out, but not how the rest is computed.
        let switches = Switches { hoist: true, fuse: true, compile: true, hold: true, sparse: true, ..*switches };
        (switches, judge, &region, self.by_reference).feed(hasher);
    }

    /// Summarizes the needed and omitted nodes of a file's outputs, whatever other outputs the run evaluates.
    fn plan_summary(&self, graph: &CheckedGraph, file: &OutputFile, frame: &Frame) -> String {
        if frame.pictures.iter().all(|picture| file.outputs.contains(&picture.output)) {
            return crate::report::plan_summary(frame);
        }
        let names: Vec<&str> = file.outputs.iter().map(|index| graph.outputs()[*index].name.as_str()).collect();
        match Plan::new(graph, &names, frame.number, &[], &self.settings) {
            Ok(plan) => crate::report::summary_of(plan.left_out().iter().map(Option::is_some)),
            Err(error) => error.to_string(),
        }
    }

    /// Returns whether the file exists already, is complete, has this fingerprint, and was found to meet the
    /// requirement.
    pub fn is_current(
        &mut self,
        graph: &CheckedGraph,
        file: &OutputFile,
        frame: i64,
        required: Option<Guarantee>,
    ) -> bool {
        let metadata = metadata_of_whole(&file.path);
        let entry = |key: &str| metadata.iter().find(|entry| entry.0 == key).map(|entry| entry.1.as_str());
        let demanded = file.outputs.iter().filter_map(|index| requirement(&graph.outputs()[*index], required)).max();
        entry(FINGERPRINT) == Some(self.of(graph, file, frame).as_str())
            && entry(HELD).and_then(Guarantee::from_name) >= demanded
    }

    /// Returns whether a complete file exists that was written with the [`metadata`](Self::metadata) of this
    /// fingerprint.
    pub fn is_marked(path: &Path, fingerprint: &str) -> bool {
        metadata_of_whole(path).iter().any(|(key, value)| key == FINGERPRINT && value == fingerprint)
    }

    /// Returns the metadata of a file: what it was made from, and what was found on its pixels.
    pub fn metadata(&mut self, graph: &CheckedGraph, file: &OutputFile, frame: &Frame) -> Vec<(String, String)> {
        let pictures = || frame.pictures.iter().filter(|picture| file.outputs.contains(&picture.output));
        let held = pictures().filter(|picture| picture.guarantee.is_some()).map(held).min().flatten();
        let guarantees: Vec<String> = pictures()
            .filter_map(|picture| {
                let name = &graph.outputs()[picture.output].name;
                let guarantee = picture.guarantee?;
                Some(format!("{name}: {}, {} outside", guarantee.name(), picture.audit.hull_exits))
            })
            .collect();
        let names: Vec<&str> = pictures().map(|picture| graph.outputs()[picture.output].name.as_str()).collect();
        let entry = |key: &str, value: String| (format!("trochoid:{key}"), value);
        let whole = self.settings.region.map(|_| (WHOLE.into(), self.of_region(graph, file, frame.number, None)));
        let entries = vec![
            entry("version", VERSION.into()),
            (OUTPUTS.into(), names.join(", ")),
            entry("document", graph.document_hash()),
            entry("frame", frame.number.to_string()),
            entry("workingSpace", graph.space().name().into()),
            entry("plan", self.plan_summary(graph, file, frame)),
            (GUARANTEE.into(), guarantees.join("; ")),
            (HELD.into(), held.map_or("none", Guarantee::name).into()),
            (FINGERPRINT.into(), self.of(graph, file, frame.number)),
        ];
        entries.into_iter().chain(whole).collect()
    }
}

/// Returns the metadata of a picture file that is complete and has nothing after its end; empty for other files.
fn metadata_of_whole(path: &Path) -> Vec<(String, String)> {
    let whole = trochoid_io::check_whole(path).and_then(|()| trochoid_io::read_metadata(path));
    whole.unwrap_or_default()
}

/// Returns the hash of a file's contents, or the reason that it cannot be read.
fn hash_of(path: &Path) -> String {
    let mut hasher = blake3::Hasher::new();
    let file = match trochoid_io::open_file(path) {
        Ok(file) => file,
        Err(error) => return error.to_string(),
    };
    match std::io::copy(&mut file.reader(), &mut hasher) {
        Ok(_) => hasher.finalize().to_hex().to_string(),
        Err(error) => error.to_string(),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_order_of_nodes_and_outputs_does_not_matter() {
        let of = |nodes: &str, outputs: &str| {
            let text = format!(
                r#"{{ "trochoid": 1, "format": {{ "width": 4, "height": 2 }}, "nodes": {{ {nodes} }},
                    "outputs": {{ {outputs} }} }}"#
            );
            let graph = crate::parse("a.json", &text, Path::new("."), &[]).expect("valid").graph;
            let output = graph.outputs().iter().position(|output| output.name == "a").expect("there");
            let file = OutputFile { path: "a.exr".into(), outputs: vec![output] };
            Fingerprints::new().of(&graph, &file, 1)
        };
        let (x, y) = (r#""x": { "type": "ScreenX" }"#, r#""y": { "type": "ScreenY" }"#);
        let [both, a, b] = [
            r#""both": { "type": "Multiply", "weights": ["x", "y"] }"#,
            r#""a": { "weights": "both" }"#,
            r#""b": { "weights": "y" }"#,
        ];
        let one = of(&[x, y, both].join(", "), &[a, b].join(", "));
        assert_eq!(one, of(&[both, y, x].join(", "), &[b, a].join(", ")));
        let swapped = both.replace(r#"["x", "y"]"#, r#"["y", "x"]"#);
        assert_ne!(one, of(&[x, y, &swapped].join(", "), &[a, b].join(", ")), "the order in a list is meant");
    }
}
