//! Position: location of the seen point.

use super::ChannelCopy;
use trochoid_graph::*;

/// The seen point in world space.
///
/// # Formula
/// P
///
/// # Edge cases
/// (0, 0, 0) where nothing is seen.
///
/// # Source
/// The standard position pass.
#[derive(Clone, Node)]
#[node(end = Front, revision = 1, output(position: Kind::Field(3) = "World-space position, m."))]
pub(crate) struct Position {
    /// View to take positions from.
    view: One<port::View>,
}

impl ChannelCopy for Position {
    const CHANNELS: &[Channel] = &super::POSITION;

    fn view(&self) -> &One<port::View> {
        &self.view
    }
}
