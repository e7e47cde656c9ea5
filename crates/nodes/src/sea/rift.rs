//! Rift: the foam that bursts leave behind.

use crate::view::Copies;
use trochoid_graph::*;

/// The rift of a toon sea: how much foam trails behind its bursts, for Bands or Clamp.
///
/// # Formula
/// r += k·max(d − m, 0), m the distance from a burst, and r ÷= 1 + ε at each step; a burst that rests comes to k·(d −
/// m)/ε. Between cells bicubic. d, k and ε are knobs of the ToonSea.
///
/// # Edge cases
/// A burst that passes at v m/s leaves about 60·k·d²/v in its middle: with the defaults of ToonSea 0.5 at 5 m/s, and 3
/// where it rests; systems of bursts leave more. 0 where nothing is seen and on other surfaces. The interpolation may
/// fall a little below 0 beside a steep edge.
///
/// # Source
/// Dadfar and Welling, Japanese-Style Toon-Based Water Shader, 3.3.
#[derive(Clone, Node)]
#[node(end = Front, revision = 1, output(rift: Kind::Field(1) = "The rift."))]
pub(crate) struct Rift {
    /// What is seen.
    view: One<port::View>,
}

impl Copies for Rift {
    const CHANNELS: &[Channel] = &[Channel::Rift];

    fn view(&self) -> &One<port::View> {
        &self.view
    }
}
