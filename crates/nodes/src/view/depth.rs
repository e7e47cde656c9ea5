//! Depth: distance from the camera.

use super::ChannelCopy;
use trochoid_graph::*;

/// The planar distance from the camera, along its axis.
///
/// # Formula
/// (P − P_C) · axis
///
/// # Edge cases
/// +∞ where nothing is seen; Clamp maps it to 1.
///
/// # Source
/// Thesis 3.2.3.4, Z_s.
#[derive(Clone, Node)]
#[node(end = Front, revision = 1, output(depth: Kind::Field(1) = "Planar distance, m.", ["Z"]))]
#[also_called("Fog", "Mist", "Haze" => "then a Clamp to a mask, and a Mix toward the color")]
pub(crate) struct Depth {
    /// View to take depth from.
    view: One<port::View>,
}

impl ChannelCopy for Depth {
    const CHANNELS: &[Channel] = &[Channel::Depth];

    fn view(&self) -> &One<port::View> {
        &self.view
    }
}
