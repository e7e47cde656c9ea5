//! Decides which stages are evaluated once for several samples of a pixel.

use super::lower::LoweredGraph;
use super::planner::Planner;
use trochoid_graph::{Channel, Kind, NodeId, Rate, Slot, Source, Variance};
use trochoid_image::Shading;

/// Channels that a view must supply for [`Shading::is_shared`] to decide whether samples share.
pub(crate) const SHARING_CHANNELS: [Channel; 2] = [Channel::Surface, Channel::Depth];

/// Returns the slot of a channel by which a view decides sharing.
pub(crate) fn sharing_slot(node: NodeId, channel: Channel) -> Slot {
    Slot { node, output: 0, channel: channel as usize }
}

/// By node: the views that must see the same surface at a sample as at the pixel's first sample for the node's result
/// to be reused; `None` if every sample has its own result.
///
/// It follows from the graph alone, never from switches or from the other requested outputs.
pub(crate) type ViewsByNode = Vec<Option<Vec<NodeId>>>;

impl Planner<'_, '_> {
    pub(crate) fn shared(&self, lowered: &LoweredGraph) -> ViewsByNode {
        let nodes = self.graph.nodes().len();
        let mut shared: ViewsByNode = vec![None; nodes];
        let format = self.graph.format();
        if format.shading() == Shading::Sample || format.samples() == 1 {
            return shared;
        }
        // By node: the views over whose surfaces it varies smoothly; `None` where it may change within a pixel.
        let mut smooth: ViewsByNode = vec![None; nodes];
        for &id in self.graph.order() {
            (smooth[id.0], shared[id.0]) = self.rate(id, lowered, &smooth);
        }
        shared
    }

    /// Returns the views over whose surfaces a node varies smoothly, and the views on which sharing its result
    /// depends.
    fn rate(
        &self,
        id: NodeId,
        lowered: &LoweredGraph,
        smooth: &ViewsByNode,
    ) -> (Option<Vec<NodeId>>, Option<Vec<NodeId>>) {
        const EVERYWHERE: Option<Vec<NodeId>> = Some(Vec::new());
        if self.bound[id.0] {
            return (EVERYWHERE, None);
        }
        let (node, Some(settled)) = (self.graph.node(id), &lowered.settled[id.0]) else { return (None, None) };
        let inputs = || {
            let chosen = settled.node().identity();
            let sources: Vec<&Source<Vec<f64>>> = chosen.map_or_else(|| settled.sources(), |chosen| vec![chosen]);
            let mut views = Vec::new();
            for source in sources {
                if let Source::Output { node, .. } = source {
                    views.extend(smooth[node.0].as_ref()?);
                }
            }
            views.sort_unstable();
            views.dedup();
            Some(views)
        };
        let Some(stage) = settled.stage() else { return (inputs(), None) };
        if node.kinds.contains(&Kind::View) {
            let supplied = stage.supplied_channels();
            let decides = SHARING_CHANNELS.iter().all(|channel| supplied.contains(*channel));
            return (decides.then(|| vec![lowered.stands_in[id.0]]), None);
        }
        let mut outputs = (0..node.kinds.len()).filter(|output| node.kinds[*output].channels() > 0).peekable();
        if outputs.peek().is_none() {
            return (EVERYWHERE, None);
        }
        // Evaluated once per row or column, which costs almost nothing.
        if outputs.all(|output| stage.variance(output) < Variance::Pixel) {
            return (EVERYWHERE, None);
        }
        match stage.rate() {
            Rate::Sample => (None, None),
            Rate::Pixel => (EVERYWHERE, EVERYWHERE),
            Rate::Surface => (inputs(), inputs()),
        }
    }
}
