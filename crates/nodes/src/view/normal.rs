//! Normal: orientation of the surface.

use super::ChannelCopy;
use trochoid_graph::*;

/// The unit normal at the seen point, in world space.
///
/// # Formula
/// N/|N|
///
/// # Edge cases
/// (0, 1, 0) where nothing is seen or the normal is degenerate. The normal of a sea points into the air, also in folds,
/// and that of an open model toward the eye.
///
/// # Source
/// The standard normal pass.
#[derive(Clone, Node)]
#[node(end = Front, revision = 1, output(normal: Kind::Field(3) = "World-space unit normal."))]
pub(crate) struct Normal {
    /// View to take normals from.
    view: One<port::View>,
}

impl ChannelCopy for Normal {
    const CHANNELS: &[Channel] = &super::NORMAL;

    fn view(&self) -> &One<port::View> {
        &self.view
    }
}
