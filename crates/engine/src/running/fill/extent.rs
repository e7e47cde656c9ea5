//! How far images extend, and which windows are requested beyond them.

use crate::Plan;
use crate::planning::plan::{Feed, Fill};
use crate::running::prepare::PreparedStage;
use std::collections::HashMap;
use trochoid_graph::{NodeId, PortId};
use trochoid_image::Window;

/// Clamps a window to lie within another: outside of `within`, the nearest pixels repeat.
pub(super) fn clamped(window: Window, within: Window) -> Window {
    let axis = |low: i64, high: i64, first: i64, end: i64| {
        let low = low.clamp(first, (end - 1).max(first));
        (low, high.clamp(low + 1, end.max(low + 1)))
    };
    let (x0, x1) = axis(window.x0, window.x1, within.x0, within.x1);
    let (y0, y1) = axis(window.y0, window.y1, within.y0, within.y1);
    Window { x0, y0, x1, y1 }
}

/// Extent of a literal: more than any picture, but small enough to compute with.
const EVERYWHERE: Window = Window::new(-(1 << 40), -(1 << 40), 1 << 40, 1 << 40);

/// Returns how far the image of every stage extends: the picture, and the pixels that the stage has beyond it.
pub(crate) fn extents(
    plan: &Plan<'_>,
    ready: &HashMap<NodeId, PreparedStage>,
    fills: &[Fill],
) -> HashMap<NodeId, Window> {
    let picture = plan.graph.format().window();
    let mut extents = HashMap::new();
    for fill in fills.iter().filter(|fill| !plan.bound[fill.node.0]) {
        let Some(ready) = ready.get(&fill.node) else { continue };
        let of = |feeds: &Vec<Feed>| match feeds.iter().find(|feed| **feed != Feed::Nothing) {
            Some(Feed::Slot(slot)) => extents.get(&slot.node).copied().unwrap_or(picture),
            Some(Feed::Constant(_)) | None => EVERYWHERE,
            _ => picture,
        };
        let inputs = |port: PortId| {
            let connections = fill.inputs.iter().filter(|(known, _)| *known == port).flat_map(|(_, feeds)| feeds);
            connections.map(of).fold(EVERYWHERE, Window::intersect)
        };
        let extent = ready.prepared.data_window(picture, &inputs);
        extents.insert(fill.node, if extent == EVERYWHERE { picture } else { extent.union(picture) });
    }
    extents
}
