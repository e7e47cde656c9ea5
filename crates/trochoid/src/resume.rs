//! What a picture was made from, as a hash: the key of `--resume`.

use crate::{OutputFile, VERSION, held, requirement};
use std::collections::HashMap;
use std::path::{Path, PathBuf};
use trochoid_graph::{CheckedGraph, Guarantee};

/// The metadata entry that holds the fingerprint.
const KEY: &str = "trochoid:fingerprint";
/// The metadata entry that holds the weakest guarantee found to hold on a color of the file.
const HELD: &str = "trochoid:held";

/// Fingerprints of the files of a run; hashes every input file once.
#[derive(Debug, Default)]
pub struct Fingerprints {
    inputs: HashMap<PathBuf, String>,
}

impl Fingerprints {
    /// No file hashed yet.
    pub fn new() -> Self {
        Self::default()
    }

    /// The hash of everything that a file's pixels depend on: version, document (`--set` included), frame,
    /// outputs, and the contents of all input files. An input that cannot be read counts as such.
    pub fn of(&mut self, graph: &CheckedGraph, file: &OutputFile, frame: i64) -> String {
        let context = graph.frame_context(frame, u64::MAX);
        let roots = file.outputs.iter().map(|index| graph.outputs()[*index].node);
        let files = graph.files(&graph.reached(roots, frame), &context);
        let mut hasher = blake3::Hasher::new();
        hasher.update(format!("{VERSION} {} {frame} {:?}", graph.document_hash(), file.outputs).as_bytes());
        hasher.update(format!("{:?}", graph.format()).as_bytes());
        for path in files {
            let hash = self.inputs.entry(path.clone()).or_insert_with(|| {
                let mut hasher = blake3::Hasher::new();
                let file = trochoid_io::open_file(&path).map_err(|error| error.to_string());
                let read = file
                    .and_then(|file| std::io::copy(&mut file.reader(), &mut hasher).map_err(|error| error.to_string()));
                read.map_or_else(|error| error, |_| hasher.finalize().to_hex().to_string())
            });
            hasher.update(hash.as_bytes());
        }
        hasher.finalize().to_hex().to_string()
    }

    /// Whether the file is there already, made from exactly this, and was found to hold what is required.
    pub fn is_current(
        &mut self,
        graph: &CheckedGraph,
        file: &OutputFile,
        frame: i64,
        required: Option<Guarantee>,
    ) -> bool {
        if !file.path.exists() {
            return false;
        }
        let metadata = trochoid_io::read_metadata(&file.path).unwrap_or_default();
        let entry = |key: &str| metadata.iter().find(|entry| entry.0 == key).map(|entry| entry.1.as_str());
        let demanded = file.outputs.iter().filter_map(|index| requirement(&graph.outputs()[*index], required)).max();
        entry(KEY) == Some(self.of(graph, file, frame).as_str())
            && entry(HELD).and_then(Guarantee::from_name) >= demanded
    }

    /// Whether a file is there that was written with the [`metadata`](Self::metadata) of this fingerprint.
    pub fn is_marked(path: &Path, fingerprint: &str) -> bool {
        let metadata = if path.exists() { trochoid_io::read_metadata(path).unwrap_or_default() } else { Vec::new() };
        metadata.iter().any(|(key, value)| key == KEY && value == fingerprint)
    }

    /// The metadata of a file: what it was made from and what was found on its pixels.
    pub fn metadata(&mut self, graph: &CheckedGraph, file: &OutputFile, frame: &crate::Frame) -> Vec<(String, String)> {
        let pictures = || frame.pictures.iter().filter(|picture| file.outputs.contains(&picture.output));
        let held = pictures().filter(|picture| picture.guarantee.is_some()).map(held).min().flatten();
        let guarantees: Vec<String> = pictures()
            .filter_map(|picture| {
                let name = &graph.outputs()[picture.output].name;
                let guarantee = picture.guarantee?;
                Some(format!("{name}: {}, {} exits", guarantee.name(), picture.audit.hull_exits))
            })
            .collect();
        let entry = |key: &str, value: String| (format!("trochoid:{key}"), value);
        vec![
            entry("version", VERSION.into()),
            entry("document", graph.document_hash()),
            entry("frame", frame.number.to_string()),
            entry("workingSpace", graph.space().name().into()),
            entry("plan", crate::report::plan_summary(frame)),
            entry("guarantee", guarantees.join("; ")),
            (HELD.into(), held.map_or("none", Guarantee::name).into()),
            (KEY.into(), self.of(graph, file, frame.number)),
        ]
    }
}
