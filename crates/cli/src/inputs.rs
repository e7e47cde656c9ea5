//! Files that a document reads, which nothing may write over.

use crate::failure::Failure;
use std::collections::HashSet;
use std::path::{Path, PathBuf};
use trochoid::CheckedGraph;

/// The files that some outputs read at some frames, and the document itself.
pub(crate) struct InputFiles(HashSet<PathBuf>);

impl InputFiles {
    /// Of the document at `path`; files that are not there cannot be written over.
    pub(crate) fn new(path: &Path, graph: &CheckedGraph, outputs: &[usize], frames: &[i64]) -> Self {
        let roots = || outputs.iter().map(|index| graph.outputs()[*index].node);
        let read = frames.iter().flat_map(|frame| {
            let needed = graph.reached(roots(), *frame);
            graph.files(&needed, &graph.frame_context(*frame, u64::MAX))
        });
        let all: HashSet<PathBuf> = read.chain([path.to_path_buf()]).collect();
        Self(all.iter().filter_map(|path| path.canonicalize().ok()).collect())
    }

    pub(crate) fn contains(&self, path: &Path) -> bool {
        path.canonicalize().is_ok_and(|path| self.0.contains(&path))
    }

    /// What is wrong with writing a file, where it is one of these.
    pub(crate) fn refusal(&self, path: &Path) -> Option<Failure> {
        self.contains(path).then(|| {
            let message = format!("{}: is an input of the document, and would be written over", path.display());
            Failure::usage(message, "give the output another name")
        })
    }
}
