//! Files that a document requests but may not access.

use std::path::PathBuf;
use trochoid_graph::{CheckedGraph, NodeId, RefusedFile};

/// Maximum number of frames that are checked in advance; evaluation checks the others.
const FRAMES_CHECKED: usize = 10_000;

/// Returns files that these outputs would read at these frames without permission (see [`Access`](crate::Access)), the
/// first one of each node. Opens no files.
///
/// Evaluation refuses such files too, one by one. To allow some, give the graph [access](CheckedGraph::with_access) to
/// their [folders](crate::AccessViolation::folder).
pub fn refused_files(graph: &CheckedGraph, outputs: &[usize], frames: &[i64]) -> Vec<RefusedFile> {
    let connected = graph.upstream(outputs.iter().map(|index| graph.outputs()[*index].node));
    let nodes = (0..graph.nodes().len()).filter(|index| connected[*index] && !graph.nodes()[*index].disabled);
    // By node: the files that it read at the previous frame, and the file that was refused.
    let mut open: Vec<(NodeId, Vec<PathBuf>, Option<RefusedFile>)> =
        nodes.map(|index| (NodeId(index), Vec::new(), None)).collect();
    for &frame in frames.iter().take(FRAMES_CHECKED) {
        let context = graph.frame_context(frame, u64::MAX);
        for (id, before, refused) in open.iter_mut().filter(|(_, _, refused)| refused.is_none()) {
            let files = graph.files_of(*id, &context);
            if files != *before {
                *refused = graph.refused(*id, &context);
                *before = files;
            }
        }
    }
    open.into_iter().filter_map(|(_, _, refused)| refused).collect()
}

/// Returns files that the document names for these outputs at these frames but may not write, the first one of each
/// output.
///
/// [`output_files`](crate::output_files) refuses such files too, one by one.
#[cfg(feature = "io")]
pub fn refused_outputs(graph: &CheckedGraph, outputs: &[usize], frames: &[i64]) -> Vec<RefusedFile> {
    let refused = |index: &usize| {
        let spec = &graph.outputs()[*index];
        let of_frame = |frame: &i64| graph.check_written(spec, &crate::naming::own_file(graph, spec, *frame)?).err();
        frames.iter().find_map(of_frame).map(|refused| *refused)
    };
    outputs.iter().filter_map(refused).collect()
}
