//! Outputs in an existing file that a run would not write again.

use crate::exr_layer::file_channels;
use crate::resume::OUTPUTS;
use crate::{OutputFile, output_files};
use std::collections::BTreeSet;
use trochoid_graph::{CheckedGraph, resolved};
use trochoid_io::Limits;

/// Returns the indices of the outputs that would be lost if `file` replaced the existing file: outputs that the
/// document writes to the same path, that `file` leaves out, and that the existing file contains. Empty if there is no
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
    // If the file does not name its outputs, its channels identify them.
    let Ok(info) = trochoid_io::info(&file.path, &Limits::default()) else { return Vec::new() };
    let parts = info.parts.into_iter().flat_map(|part| part.channels);
    let found: BTreeSet<String> = parts.map(|channel| channel.full_name).collect();
    // The channel names of an output may depend on whether it shares the file.
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
