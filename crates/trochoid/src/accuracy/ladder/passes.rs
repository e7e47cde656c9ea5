//! Which passes the certified errors come from.

use super::budget::Deadline;
use super::limit::output;
use super::looked::in_time;
use super::{Request, TargetError};
use trochoid_engine::{Buffers, Cache, Certifier};
use trochoid_graph::CheckedGraph;

/// Share of a pass in the certified error.
#[derive(Clone, Debug, PartialEq)]
pub struct PassError {
    /// Name of the node.
    pub node: String,
    /// Type of the node.
    pub ty: &'static str,
    /// Drop of the bound if the pass has no errors of its own, averaged over pixels, in units of the working space.
    pub drop: f64,
}

/// Returns the share of each pass in the bounds of some pixels, largest first; `None` if the time is too short.
pub(super) fn passes(
    graph: &CheckedGraph,
    request: &Request<'_>,
    pixels: &[[i64; 2]],
    cache: &mut Cache,
    deadline: &Deadline<'_>,
) -> Result<Option<Vec<PassError>>, TargetError> {
    let certifier = Certifier::new(graph, request.outputs, request.frame, &[], request.settings)?;
    let output = output(graph, request);
    let mut drops = vec![0.0; graph.nodes().len()];
    for pixel in pixels {
        let found = certifier.by_stage(output, *pixel, &Buffers::new(), cache, deadline);
        let Some((whole, by_stage)) = in_time(found, deadline)? else { return Ok(None) };
        for (stage, without) in by_stage {
            drops[stage.0] += (whole - without).max(0.0) / pixels.len() as f64;
        }
    }
    let passes = graph.nodes().iter().zip(drops).filter(|(_, drop)| *drop > 0.0);
    let mut passes: Vec<PassError> = passes
        .map(|(node, drop)| PassError { node: node.name.clone(), ty: node.ty.declaration().name, drop })
        .collect();
    passes.sort_by(|a, b| b.drop.total_cmp(&a.drop));
    Ok(Some(passes))
}
