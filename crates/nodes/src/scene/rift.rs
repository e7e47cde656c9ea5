//! Rift: the foam that bursts leave behind.

use crate::scene_support::ViewCopy;
use trochoid_graph::*;

pub(crate) static NODE: &dyn NodeType = &ViewCopy { declaration: &DECLARATION, channels: CHANNELS };

const CHANNELS: &[Channel] = &[Channel::Rift];

static DECLARATION: Declaration = Declaration {
    name: "Rift",
    end: End::Front,
    summary: "The rift of a toon sea: how much foam trails behind its bursts, for Bands or Clamp.",
    formula: "r += k·max(d − m, 0), m the distance from a burst, and r ÷= 1 + ε at each step; a burst that rests comes \
              to k·(d − m)/ε. Between cells bicubic. d, k and ε are knobs of the ToonSea.",
    edge_cases: "A burst that passes at v m/s leaves about 60·k·d²/v in its middle: with the defaults of ToonSea 0.5 \
                 at 5 m/s, and 3 where it rests; systems of bursts leave more. 0 where nothing is seen and on other \
                 surfaces. The interpolation may fall a little below 0 beside a steep edge.",
    source: "Dadfar and Welling, Japanese-Style Toon-Based Water Shader, 3.3.",
    items: &[Port::one("view", Accepts::View, "What is seen.")],
    outputs: &[Output::new("rift", Kind::Field(1), "The rift.")],
    revision: 1,
};
