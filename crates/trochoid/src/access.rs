//! What a document asks to read that it may not.

use std::path::PathBuf;
use trochoid_graph::{CheckedGraph, NodeId, Refused};

/// Frames that are looked at in advance; evaluation looks at the others.
const FRAMES_CHECKED: usize = 10_000;

/// Files that some outputs would read at some frames and the document may not reach, see
/// [`Access`](crate::Access): of each node the first one. Opens none.
///
/// Evaluation refuses them too, one by one. To allow some, hand the graph another
/// [rule](CheckedGraph::with_access) with their [folders](crate::Outside::folder).
pub fn refused_files(graph: &CheckedGraph, outputs: &[usize], frames: &[i64]) -> Vec<Refused> {
    let connected = graph.upstream(outputs.iter().map(|index| graph.outputs()[*index].node));
    let nodes = (0..graph.nodes().len()).filter(|index| connected[*index] && !graph.nodes()[*index].disabled);
    // By node: what it read at the frame before, and what was refused of it.
    let mut open: Vec<(NodeId, Vec<PathBuf>, Option<Refused>)> =
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

/// Files of some outputs at some frames that the document itself wants where it may not write: of each output the first one.
///
/// [`output_files`](crate::output_files) refuses them too, one by one.
#[cfg(feature = "io")]
pub fn refused_outputs(graph: &CheckedGraph, outputs: &[usize], frames: &[i64]) -> Vec<Refused> {
    let refused = |index: &usize| {
        let spec = &graph.outputs()[*index];
        let of_frame = |frame: &i64| graph.check_written(spec, &crate::naming::own_file(graph, spec, *frame)?).err();
        frames.iter().find_map(of_frame).map(|refused| *refused)
    };
    outputs.iter().filter_map(refused).collect()
}
