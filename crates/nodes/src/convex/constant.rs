//! Constant: a single control color.

use trochoid_graph::*;

/// Fills the picture with one control color.
///
/// # Formula
/// C
///
/// # Edge cases
/// A keyframed color is a single control color at every frame.
///
/// # Source
/// A vertex of the convex hull: Akleman, Liu, House, Barycentric Shaders, 2016.
#[derive(Clone, Node)]
#[node(pointwise, end = Back, revision = 1, output(color: Kind::Color = "The color."))]
#[also_called("Color", "Colour", "Solid", "SolidColor", "Fill", "Background", "RGB")]
pub(crate) struct Constant {
    /// Control color: a color of the palette.
    #[knob(color)]
    color: [f64; 3],
}

impl Node for Constant {}

impl Pointwise for Constant {
    fn lower(&self, lowering: &mut Lowering<'_>) -> Value {
        Value::Color(lowering.build.control(self.color))
    }

    fn reference(&self, _inputs: &References<'_>) -> Reference {
        Reference::Color(self.color)
    }
}
