//! Height: height of the surface above its rest level.

use super::ChannelCopy;
use trochoid_graph::*;

/// The height of the seen point above its surface's rest level.
///
/// # Formula
/// P.y − level
///
/// # Edge cases
/// 0 where nothing is seen.
///
/// # Source
/// Thesis 3.1.2: color varies from trough to crest.
#[derive(Clone, Node)]
#[node(end = Front, revision = 1, output(height: Kind::Field(1) = "Height, m."))]
pub(crate) struct Height {
    /// View to take height from.
    view: One<port::View>,
}

impl ChannelCopy for Height {
    const CHANNELS: &[Channel] = &[Channel::Height];

    fn view(&self) -> &One<port::View> {
        &self.view
    }
}
