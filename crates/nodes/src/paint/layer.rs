//! Layers of strokes, as a document lists them.

use trochoid_field::random::key;
use trochoid_graph::Items;
use trochoid_image::Format;

/// Knobs of a layer.
#[derive(Clone, Items)]
pub(crate) struct LayerKnobs {
    /// Length of the longest strokes; others have down to half of it.
    #[knob(default = 32.0, range = 1.0..=512.0, unit = "pixels")]
    length: f64,
    /// Width of the widest strokes; others have down to half of it.
    #[knob(default = 8.0, range = 0.25..=256.0, unit = "pixels")]
    width: f64,
    /// How far strokes stand apart: one in a square of this side.
    #[knob(default = 8.0, range = 1.5..=512.0, unit = "pixels")]
    spacing: f64,
    /// Share of the strokes that are laid, times that of the port `density`.
    #[knob(default = 1.0, range = 0.0..=1.0)]
    density: f64,
    /// How much a stroke covers in its middle.
    #[knob(default = 0.8, range = 0.0..=1.0)]
    opacity: f64,
    /// How far a stroke may turn off the flow, to either side.
    #[knob(default = 12.0, range = 0.0..=180.0, unit = "degrees")]
    turn: f64,
    /// How far from its seed a stroke may take its color, in pixels: broken color.
    #[knob(default = 0.5, range = 0.0..=8.0, unit = "pixels")]
    stray: f64,
    /// How much single hairs show, and how dry the stroke ends.
    #[knob(default = 0.7, range = 0.0..=1.0)]
    bristle: f64,
}

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

/// Layers of a node, the lowest first, in pixels of a format; those of a picture of that height are meant.
pub(crate) fn layers(knobs: &[LayerKnobs], height: Option<i64>, seed: i64, format: Format) -> Vec<Layer> {
    let meant = height.map_or(f64::from(format.height()), |height| height as f64);
    let scale = f64::from(format.height()) / meant;
    let base = key(0x7374_726f_6b65, seed);
    knobs
        .iter()
        .enumerate()
        .map(|(index, layer)| Layer {
            half: [layer.length, layer.width].map(|size| size / 2.0 * scale),
            spacing: (layer.spacing * scale).max(LEAST),
            density: layer.density,
            opacity: layer.opacity,
            turn: layer.turn.to_radians(),
            stray: layer.stray * scale,
            bristle: layer.bristle,
            is_last: index + 1 == knobs.len(),
            key: key(base, index as i64),
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
