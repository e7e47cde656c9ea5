//! UV: where on its texture the seen point lies.

use super::Copies;
use trochoid_graph::*;

/// The texture coordinates of the seen point.
///
/// # Formula
/// (u, v): of a patch its parameters, of rails 0 to 1 over the whole sheet, of a mesh those of its file
///
/// # Edge cases
/// (0, 0) where nothing is seen. Surfaces without texture coordinates, such as a sea, have the rest point's x and z
/// instead, in meters. A FieldMath takes one of them: a.x is u, a.y is v.
///
/// # Source
/// The field's UV pass.
#[derive(Clone, Node)]
#[node(end = Front, revision = 1, output(uv: Kind::Field(2) = "Texture coordinates u, v."))]
pub(crate) struct UV {
    /// What is seen.
    view: One<port::View>,
}

impl Copies for UV {
    const CHANNELS: &[Channel] = &[Channel::U, Channel::V];

    fn view(&self) -> &One<port::View> {
        &self.view
    }
}
