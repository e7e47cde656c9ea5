//! RestDistance: displacement of the seen particle.

use super::ChannelCopy;
use trochoid_graph::*;

/// The distance of the seen particle from its rest point.
///
/// # Formula
/// |P − P₀|
///
/// # Edge cases
/// 0 where nothing is seen.
///
/// # Source
/// Thesis 3.1.2, depth component: distance of a shading point to its rest point.
#[derive(Clone, Node)]
#[node(end = Front, revision = 1, output(distance: Kind::Field(1) = "Distance, m."))]
pub(crate) struct RestDistance {
    /// View to take distances from.
    view: One<port::View>,
}

impl ChannelCopy for RestDistance {
    const CHANNELS: &[Channel] = &[Channel::RestDistance];

    fn view(&self) -> &One<port::View> {
        &self.view
    }
}
