//! Layers of strokes: their knobs, and the layers of a node in pixels of a format.

use trochoid_field::random::key;
use trochoid_graph::Items;
use trochoid_image::Format;
use trochoid_memory::Scratch;

/// Knobs of a layer of strokes.
#[derive(Clone, Items)]
pub(crate) struct LayerKnobs {
    /// Length of the longest strokes; the shortest are half as long.
    #[knob(default = 32.0, range = 1.0..=512.0, unit = "pixels")]
    length: f64,
    /// Width of the widest strokes; the narrowest are half as wide.
    #[knob(default = 8.0, range = 0.25..=256.0, unit = "pixels")]
    width: f64,
    /// Distance between strokes: there is one per square with this side.
    #[knob(default = 8.0, range = 1.5..=512.0, unit = "pixels")]
    spacing: f64,
    /// Fraction of the strokes that are painted; multiplied by the input `density`.
    #[knob(default = 1.0, range = 0.0..=1.0)]
    density: f64,
    /// Opacity of a stroke in its middle.
    #[knob(default = 0.8, range = 0.0..=1.0)]
    opacity: f64,
    /// Largest random angle between a stroke and the flow, to either side.
    #[knob(default = 12.0, range = 0.0..=180.0, unit = "degrees")]
    turn: f64,
    /// Largest distance from its seed at which a stroke picks up its color; larger values give broken color.
    #[knob(default = 0.5, range = 0.0..=8.0, unit = "pixels")]
    stray: f64,
    /// Visibility of single bristles, and dryness of the stroke's end; 0 gives a smooth stroke.
    #[knob(default = 0.7, range = 0.0..=1.0)]
    bristle: f64,
}

/// A layer in pixels of a format.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub(crate) struct Layer {
    /// Half the length and half the width of the largest stroke, in pixels.
    pub(crate) half: [f64; 2],
    /// Side of the square that contains one stroke, in pixels.
    pub(crate) spacing: f64,
    /// Fraction of the strokes that are painted.
    pub(crate) density: f64,
    pub(crate) opacity: f64,
    /// Largest turn, in radians.
    pub(crate) turn: f64,
    /// Largest distance of the color's source, in pixels.
    pub(crate) stray: f64,
    pub(crate) bristle: f64,
    /// Whether this is the last layer, which is on top.
    pub(crate) is_last: bool,
    /// Key of its random numbers.
    pub(crate) key: u64,
}

impl Layer {
    /// Returns the side, in pixels, of the patches that are searched for seeds: coarse layers need fewer patches.
    pub(crate) fn stride(&self) -> i64 {
        if self.spacing < 5.0 { 1 } else { STRIDES[1] }
    }
}

/// Smallest spacing, in pixels of the picture.
const LEAST: f64 = 1.5;

/// Sides of the patches that are searched for seeds, in pixels.
pub(crate) const STRIDES: [i64; 2] = [1, 2];

/// Returns the layers of a node in pixels of a format, bottom layer first. The knobs are in pixels of a picture that
/// has the given height.
pub(crate) fn layers(knobs: &[LayerKnobs], height: Option<i64>, seed: i64, format: Format) -> Scratch<Layer> {
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

/// Distance from its seed within which a stroke looks for its color, for surfaces that hide it, and for the turning of
/// the flow, in pixels.
pub(crate) const MARGIN: i64 = 8;

/// Returns how far the strokes of these layers reach from their seeds, in pixels. A bend moves their ends sideways by
/// up to 0.3 of half their length.
pub(crate) fn reach(layers: &[Layer]) -> i64 {
    let reach = |layer: &Layer| libm::hypot(layer.half[0], 0.3 * layer.half[0] + layer.half[1].max(0.5));
    layers.iter().map(reach).fold(0.0, f64::max).ceil() as i64 + 1
}
