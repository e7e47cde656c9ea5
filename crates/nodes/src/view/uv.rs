//! UV: texture coordinates of the seen point.

use super::ChannelCopy;
use trochoid_graph::*;

/// The texture coordinates of the seen point.
///
/// # Formula
/// (u, v): for a patch, its parameters; for rails, 0 to 1 over the whole sheet; for a mesh, those in its file
///
/// # Edge cases
/// (0, 0) where nothing is seen. Surfaces without texture coordinates, such as a sea, use the rest point's x and z in
/// meters instead. To take one coordinate, use a FieldMath: a.x is u, a.y is v.
///
/// # Source
/// The standard UV pass.
#[derive(Clone, Node)]
#[node(end = Front, revision = 1, output(uv: Kind::Field(2) = "Texture coordinates u, v."))]
pub(crate) struct UV {
    /// View to take texture coordinates from.
    view: One<port::View>,
}

impl ChannelCopy for UV {
    const CHANNELS: &[Channel] = &[Channel::U, Channel::V];

    fn view(&self) -> &One<port::View> {
        &self.view
    }
}
