//! What a file holds beside what a run would write into it.

use crate::exr_layer::file_channels;
use crate::resume::OUTPUTS;
use crate::{OutputFile, output_files};
use std::collections::BTreeSet;
use trochoid_graph::{CheckedGraph, resolved};
use trochoid_io::Limits;

/// The outputs of a document that a file holds which is there, and that would be gone if `file` were written: those that the
/// document wants in the same file, that `file` leaves out, and whose channels are in it. Indices; empty where there is no such
/// file.
pub fn outputs_lost(graph: &CheckedGraph, file: &OutputFile, frame: i64) -> Vec<usize> {
    let others = (0..graph.outputs().len()).filter(|index| !file.outputs.contains(index));
    if others.clone().next().is_none() || !file.path.is_file() {
        return Vec::new();
    }
    let place = resolved(&file.path);
    let is_there = |index: &usize| {
        let named = output_files(graph, &[*index], frame, false, None).unwrap_or_default();
        named.iter().any(|named| resolved(&named.path) == place)
    };
    let others: Vec<usize> = others.filter(is_there).collect();
    if others.is_empty() {
        return others;
    }
    let metadata = trochoid_io::read_metadata(&file.path).unwrap_or_default();
    if let Some((_, held)) = metadata.iter().find(|(key, _)| key == OUTPUTS) {
        let held: BTreeSet<&str> = held.split(", ").collect();
        return others.into_iter().filter(|index| held.contains(graph.outputs()[*index].name.as_str())).collect();
    }
    // Of a file that does not say so, its channels tell.
    let Ok(info) = trochoid_io::info(&file.path, &Limits::default()) else { return Vec::new() };
    let parts = info.parts.into_iter().flat_map(|part| part.channels);
    let found: BTreeSet<String> = parts.map(|channel| channel.full_name).collect();
    // An output that has a file for itself may have other names there than among several.
    let channels = |index: usize, outputs: Vec<usize>| -> BTreeSet<String> {
        let file = OutputFile { path: file.path.clone(), outputs };
        file_channels(graph, &graph.outputs()[index], &file).into_iter().map(|(name, _)| name).collect()
    };
    let is_alone = |index: &usize| channels(*index, vec![*index]) == found;
    if file.outputs.iter().any(is_alone) {
        return Vec::new();
    }
    let all = [&file.outputs[..], &others].concat();
    let is_held = |index: &usize| is_alone(index) || !channels(*index, all.clone()).is_disjoint(&found);
    others.iter().copied().filter(is_held).collect()
}
