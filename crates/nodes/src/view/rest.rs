//! Rest: position of the seen point at rest.

use super::ChannelCopy;
use trochoid_graph::*;

/// The rest point of the seen point; patterns based on it move with the surface.
///
/// # Formula
/// P₀: for a sea, the particle's position on the rest level; for a model, the point in object space
///
/// # Edge cases
/// (0, 0, 0) where nothing is seen.
///
/// # Source
/// The standard rest (reference position) pass.
#[derive(Clone, Node)]
#[node(end = Front, revision = 1, output(rest: Kind::Field(3) = "Rest point, m."))]
pub(crate) struct Rest {
    /// View to take rest points from.
    view: One<port::View>,
}

impl ChannelCopy for Rest {
    const CHANNELS: &[Channel] = &[Channel::RestX, Channel::RestY, Channel::RestZ];

    fn view(&self) -> &One<port::View> {
        &self.view
    }
}
