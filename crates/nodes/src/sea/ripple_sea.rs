//! RippleSea: crossed ripples of cartoon water.

use super::{profile, stability};
use crate::geometry::{PreparedSurface, memory};
use trochoid_graph::*;
use trochoid_scene::SeaSurface;
use trochoid_sea::{Ripple, Sea, Wave, WaveError};

/// An endless, traveling checkerboard of bumps and hollows: cartoon water.
///
/// # Formula
/// y = A·sin(k₁a − ωt + φ)·cos(k₂b) at distances a along `direction` and b across it; A = `height`, k = 2π/length, ω =
/// √(g·√(k₁² + k₂²)). convention "literal": y = A·sin(k₁a + ωt + φ)·cos(k₂b + ωt), ω = 1. Both are the sum of two
/// crossed waves of height A/2, which fade like those of a GerstnerSea.
///
/// # Edge cases
/// `height` 0 is a flat sea. With convention "literal", one of the two waves runs at 2ω and the other stands still.
/// Several ripples of different lengths make livelier water: set them as `waves` of a GerstnerSea.
///
/// # Source
/// Creation of a cartoon shader of water for the web, part 2: pos.y += cos(pos.z·5 + t)·0.1·sin(pos.x·5 + t).
#[derive(Clone, Node)]
#[node(stage, end = Front, revision = 1, role = Sea, offers(Rest), output(surface: Kind::Surface = "The sea at the frame's time."))]
pub(crate) struct RippleSea {
    /// Height of the bumps above the rest level.
    #[knob(default = 0.1, range = -1e4..=1e4, unit = "m")]
    height: f64,
    /// Distance between bumps along the direction.
    #[knob(default = 1.2566, range = 1e-3..=1e6, unit = "m")]
    along: f64,
    /// Distance between bumps across the direction; large values make long crests.
    #[knob(default = 1.2566, range = 1e-3..=1e6, unit = "m")]
    across: f64,
    /// Direction of travel: 0 is +X, 90 is +Z.
    #[knob(default = 0.0, range = -3600.0..=3600.0, unit = "degrees")]
    direction: f64,
    /// Angular frequency ω; if unset, that of deep water, or 1 with convention "literal".
    #[knob(range = -1e4..=1e4, unit = "rad/s")]
    frequency: Option<f64>,
    /// Phase φ.
    #[knob(default = 0.0, range = -1e6..=1e6, unit = "degrees")]
    phase: f64,
    /// Phases of the two waves: "settled" makes the whole pattern travel, "literal" follows the source as printed.
    convention: RippleConvention,
    /// World y of the sea at rest.
    #[knob(default = 0.0, range = -1e5..=1e5, unit = "m", places = Level)]
    pub(super) level: f64,
}

#[derive(Clone, Copy, Debug, PartialEq, Choice)]
enum RippleConvention {
    Settled,
    Literal,
}

impl RippleSea {
    /// Returns the waves that the knobs describe.
    fn waves(&self) -> Result<Vec<Wave>, WaveError> {
        let ripple = Ripple {
            height: self.height,
            lengths: [self.along, self.across],
            direction: self.direction.to_radians(),
            frequency: self.frequency,
            phase: self.phase.to_radians(),
            literal: match self.convention {
                RippleConvention::Settled => false,
                RippleConvention::Literal => true,
            },
        };
        Ok(ripple.waves()?.to_vec())
    }
}

impl Node for RippleSea {
    fn dynamics(&self) -> Option<&dyn Dynamics> {
        Some(self)
    }
}

impl Dynamics for RippleSea {
    fn stability(&self) -> Option<Stability> {
        Some(stability::waves(self.waves().ok()?))
    }

    fn spectrum(&self) -> Option<Spectrum> {
        let waves = profile::harmonics(&self.waves().ok()?);
        Some(Spectrum { waves, unfolded: f64::INFINITY, lengths: None })
    }

    fn profile(&self, line: &ProfileLine, time: f64) -> Option<Profile> {
        Some(profile::of_waves(self.waves().ok()?, line, time))
    }
}

impl Stage for RippleSea {
    fn depends_on_time(&self) -> bool {
        true
    }

    fn depends_on_format(&self) -> bool {
        false
    }

    fn memory(&self, context: &MemoryContext<'_>) -> MemoryUse {
        memory::of_sea(1.0, context)
    }

    fn prepare(&self, prepare: &Prepare<'_>) -> Result<Box<dyn Prepared>, NodeError> {
        let sea = Sea::new(self.waves()?);
        Ok(Box::new(PreparedSurface::new(SeaSurface::new(&sea, prepare.frame.time, self.level))))
    }
}
