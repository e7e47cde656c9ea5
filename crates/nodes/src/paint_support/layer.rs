//! Layers of strokes, as a document lists them.

use trochoid_graph::{Item, Knob, Settled};
use trochoid_image::Format;

/// Knobs of a layer.
pub(crate) const LAYERS: &[Item] = &[
    Knob::number("length", 32.0, 1.0, 512.0, "Length of the longest strokes; others have down to half of it.")
        .unit("pixels")
        .item(),
    Knob::number("width", 8.0, 0.25, 256.0, "Width of the widest strokes; others have down to half of it.")
        .unit("pixels")
        .item(),
    Knob::number("spacing", 8.0, 1.5, 512.0, "How far strokes stand apart: one in a square of this side.")
        .unit("pixels")
        .item(),
    Knob::number("density", 1.0, 0.0, 1.0, "Share of the strokes that are laid, times that of the port `density`.")
        .item(),
    Knob::number("opacity", 0.8, 0.0, 1.0, "How much a stroke covers in its middle.").item(),
    Knob::number("turn", 12.0, 0.0, 180.0, "How far a stroke may turn off the flow, to either side.")
        .unit("degrees")
        .item(),
    Knob::number("stray", 0.5, 0.0, 8.0, "How far from its seed a stroke may take its color, in pixels: broken color.")
        .unit("pixels")
        .item(),
    Knob::number("bristle", 0.7, 0.0, 1.0, "How much single hairs show, and how dry the stroke ends.").item(),
];

/// One layer.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct Layer {
    /// Half the length and width of the largest stroke, in pixels.
    pub(crate) half: [f64; 2],
    /// Side of the square that holds one stroke, in pixels.
    pub(crate) spacing: f64,
    /// Share of the strokes that are there.
    pub(crate) density: f64,
    pub(crate) opacity: f64,
    /// In radians.
    pub(crate) turn: f64,
    /// In pixels.
    pub(crate) stray: f64,
    pub(crate) bristle: f64,
    /// Whether nothing is painted over it.
    pub(crate) is_last: bool,
    /// What its random numbers are made of.
    pub(crate) key: u64,
}

impl Layer {
    /// How many pixels the corners of the patches stand apart in which its seeds are looked for: few strokes need few.
    pub(crate) fn stride(&self) -> i64 {
        if self.spacing < 5.0 { 1 } else { STRIDES[1] }
    }
}

/// How near strokes may stand, in pixels of the picture.
const LEAST: f64 = 1.5;

/// Sides of patches in which seeds are looked for, in pixels.
pub(crate) const STRIDES: [i64; 2] = [1, 2];

/// The layers of a node, the lowest first, in pixels of a format.
pub(crate) fn layers(node: &Settled, format: Format) -> Vec<Layer> {
    let list = node.list("layers");
    let meant = if node.is_set("height") { node.integer("height") as f64 } else { f64::from(format.height()) };
    let scale = f64::from(format.height()) / meant;
    let base = super::key(0x7374_726f_6b65, node.integer("seed"));
    list.iter()
        .enumerate()
        .map(|(index, layer)| Layer {
            half: ["length", "width"].map(|knob| layer.number(knob) / 2.0 * scale),
            spacing: (layer.number("spacing") * scale).max(LEAST),
            density: layer.number("density"),
            opacity: layer.number("opacity"),
            turn: layer.number("turn").to_radians(),
            stray: layer.number("stray") * scale,
            bristle: layer.number("bristle"),
            is_last: index + 1 == list.len(),
            key: super::key(base, index as i64),
        })
        .collect()
}

/// How far around its seed a stroke looks for its color, for what hides it, and for how the flow turns, in pixels.
pub(crate) const MARGIN: i64 = 8;

/// How far the strokes of these layers reach from their seeds, in pixels: bent ones to the side by 0.3 of the way.
pub(crate) fn reach(layers: &[Layer]) -> i64 {
    let reach = |layer: &Layer| libm::hypot(layer.half[0], 0.3 * layer.half[0] + layer.half[1].max(0.5));
    layers.iter().map(reach).fold(0.0, f64::max).ceil() as i64 + 1
}
