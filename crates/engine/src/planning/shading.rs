//! Which stages are evaluated once for several samples of a pixel.

use super::lower::Lowered;
use super::planner::Planner;
use trochoid_graph::{Channel, Kind, NodeId, Rate, Source, Variance};
use trochoid_image::Shading;

/// What a view must tell, by [`Shading::is_shared`].
pub(crate) const TELLING: [Channel; 2] = [Channel::Surface, Channel::Depth];

/// By node: `None` where every sample has a result of its own, else the views that must see the same surface there as at
/// the pixel's first sample for its result to be taken.
///
/// That follows from the graph alone, never from switches or from what else is asked for.
pub(crate) type Shared = Vec<Option<Vec<NodeId>>>;

impl Planner<'_, '_> {
    pub(crate) fn shared(&self, lowered: &Lowered) -> Shared {
        let nodes = self.graph.nodes().len();
        let mut shared: Shared = vec![None; nodes];
        let format = self.graph.format();
        if format.shading() == Shading::Sample || format.samples() == 1 {
            return shared;
        }
        // By node: the views over whose surfaces it varies smoothly; `None` where it may change within a pixel.
        let mut smooth: Shared = vec![None; nodes];
        for &id in self.graph.order() {
            (smooth[id.0], shared[id.0]) = self.rate(id, lowered, &smooth);
        }
        shared
    }

    /// Over which views' surfaces a node varies smoothly, and the same where samples share its result.
    fn rate(&self, id: NodeId, lowered: &Lowered, smooth: &Shared) -> (Option<Vec<NodeId>>, Option<Vec<NodeId>>) {
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
            let supplied = stage.supplies();
            let tells = TELLING.iter().all(|channel| supplied.contains(*channel));
            return (tells.then(|| vec![lowered.stands_in[id.0]]), None);
        }
        let mut outputs = (0..node.kinds.len()).filter(|output| node.kinds[*output].channels() > 0).peekable();
        if outputs.peek().is_none() {
            return (EVERYWHERE, None);
        }
        // Evaluated for a row or a column at a time, which costs nothing.
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
