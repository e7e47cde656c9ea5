//! Rift: foam trails behind bursts.

use crate::view::ChannelCopy;
use trochoid_graph::*;

/// The rift of a toon sea: the amount of foam that trails behind its bursts. Connect it to Bands or Clamp.
///
/// # Formula
/// At each step r += k·max(d − m, 0), with m the distance from a burst, and r ÷= 1 + ε. A burst that rests converges
/// to k·(d − m)/ε. Bicubic between cells. d, k and ε are knobs of the ToonSea.
///
/// # Edge cases
/// A burst that passes at v m/s leaves about 60·k·d²/v in its middle: with the defaults of ToonSea, 0.5 at 5 m/s, and
/// 3 where it rests; systems of bursts leave more. 0 where nothing is seen and on other surfaces. Interpolation may
/// give values slightly below 0 next to a steep edge.
///
/// # Source
/// Dadfar and Welling, Japanese-Style Toon-Based Water Shader, 3.3.
#[derive(Clone, Node)]
#[node(end = Front, revision = 1, output(rift: Kind::Field(1) = "The rift."))]
pub(crate) struct Rift {
    /// View of a toon sea.
    view: One<port::View>,
}

impl ChannelCopy for Rift {
    const CHANNELS: &[Channel] = &[Channel::Rift];

    fn view(&self) -> &One<port::View> {
        &self.view
    }
}
