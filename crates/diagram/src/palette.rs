//! Control colors of a document.

use std::collections::HashSet;
use trochoid_graph::{CheckedGraph, Item, KnobType, NodeId, PaletteColor, Source, Values};
use trochoid_image::WorkingSpace;

/// Display color: 8-bit sRGB, clipped to the display's range.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub struct Swatch(pub [u8; 3]);

impl Swatch {
    fn of(color: [f64; 3], space: WorkingSpace) -> Self {
        Self(space.to_display(color).map(|value| (value.clamp(0.0, 1.0) * 255.0).round() as u8))
    }
}

impl std::fmt::Display for Swatch {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        let [r, g, b] = self.0;
        write!(f, "#{r:02x}{g:02x}{b:02x}")
    }
}

/// Returns the colors that a node itself sets at the document's first frame, in declaration order.
pub fn controls(graph: &CheckedGraph, id: NodeId) -> Vec<Swatch> {
    let mut colors = Vec::new();
    let settled = graph.settle(id, graph.frames().0);
    collect(graph.node(id).ty.declaration().items, &settled, &mut colors);
    colors.into_iter().map(|color| Swatch::of(color, graph.space())).collect()
}

fn collect(items: &[Item], record: &Values, colors: &mut Vec<[f64; 3]>) {
    for item in items {
        match item {
            Item::Port(port) => colors.extend(record.all(port.name).iter().filter_map(Source::color)),
            Item::Knob(knob) if matches!(knob.takes, KnobType::Color) && record.is_set(knob.name) => {
                colors.push(record.vector3(knob.name));
            }
            Item::Knob(_) => {}
            Item::List(list) => record.list(list.name).iter().for_each(|record| collect(list.items, record, colors)),
        }
    }
}

/// Returns the name in the document's palette of a color that is shown as this swatch at the first frame, if it has one.
pub fn color_name(graph: &CheckedGraph, swatch: Swatch) -> Option<&str> {
    let first = graph.frames().0 as f64;
    let shown = |named: &PaletteColor| {
        let color = named.color.at(first);
        Swatch::of([color[0], color[1], color[2]], graph.space())
    };
    graph.palette().iter().find(|named| shown(named) == swatch).map(|named| named.name.as_str())
}

/// Returns every distinct control color of the shown nodes, in document order.
pub fn palette(graph: &CheckedGraph, shown: &[bool]) -> Vec<Swatch> {
    let mut known = HashSet::new();
    let nodes = (0..graph.nodes().len()).filter(|&index| shown[index]);
    nodes.flat_map(|index| controls(graph, NodeId(index))).filter(|swatch| known.insert(*swatch)).collect()
}
