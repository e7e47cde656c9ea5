//! Long-term behavior of the time-dependent nodes of a graph.

use trochoid_graph::{CheckedGraph, Dynamics, NodeId, Stability, Stage, StepErrors, Verdict};

/// Returns the stability of every node that depends on time other than by keyframes, in document order, with its knobs
/// at a frame: theory and measurements. Takes some seconds per node.
///
#[cfg_attr(feature = "sea", doc = "```")]
#[cfg_attr(not(feature = "sea"), doc = "```ignore")]
/// let document = r##"{
///   "trochoid": 1,
///   "format": { "width": 4, "height": 4 },
///   "nodes": {
///     "sea": { "type": "ToonSea", "columns": 32, "rows": 32 },
///     "bake": { "type": "Bake", "sea": "sea" }
///   },
///   "outputs": { "height": { "field": "bake.height" } }
/// }"##;
/// let loaded = trochoid::parse("sea.json", document, std::path::Path::new("."), &[])?;
/// let found = trochoid::stability(&loaded.graph, 1);
/// let (_, sea) = &found[0];
/// assert_eq!(sea.verdict, trochoid::Verdict::Stable);
/// assert!(sea.figures.iter().all(|figure| figure.holds() != Some(false)));
/// # Ok::<(), trochoid::LoadError>(())
/// ```
pub fn stability(graph: &CheckedGraph, frame: i64) -> Vec<(NodeId, Stability)> {
    let ids = (0..graph.nodes().len()).map(NodeId);
    ids.filter_map(|id| Some((id, stability_of(graph, id, frame)?))).collect()
}

/// Returns the stability of one node; `None` if it is disabled or does not depend on time.
pub fn stability_of(graph: &CheckedGraph, id: NodeId, frame: i64) -> Option<Stability> {
    let node = graph.node(id);
    if node.disabled {
        return None;
    }
    let settled = graph.settle(id, frame);
    let depends_on_time = settled.stage().is_some_and(Stage::depends_on_time);
    settled.node().dynamics().and_then(Dynamics::stability).or_else(|| depends_on_time.then(stateless))
}

/// Measures what f32 loses of one node over a number of steps, in comparison with f64; `None` if it is disabled or
/// carries no state, or soon after `stop` says that it is no longer needed. Takes up to a minute for 10,000 steps.
pub fn step_errors_of(
    graph: &CheckedGraph,
    id: NodeId,
    frame: i64,
    steps: u64,
    stop: &(dyn Fn() -> bool + Sync),
) -> Option<StepErrors> {
    let is_disabled = graph.node(id).disabled;
    let settled = graph.settle(id, frame);
    settled.node().dynamics().filter(|_| !is_disabled)?.step_errors(steps, stop)
}

/// Returns the stability of a node that carries no state.
fn stateless() -> Stability {
    Stability {
        verdict: Verdict::ClosedForm,
        explanation: vec![
            "Every frame is computed from its own time: no state is carried from frame to frame, so no error can grow."
                .into(),
        ],
        figures: Vec::new(),
        map: None,
    }
}
