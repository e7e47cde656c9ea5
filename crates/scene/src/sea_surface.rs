use glam::DVec3;
use trochoid_sea::{Sea, SeaFrame};

use crate::extent::{Bounds, Sector, Strip};
use crate::spacing::Spacing;
use crate::surface::{Hit, Mesh, Surface};
use crate::{ChannelSet, Projector, Ray, Resting, reference, tessellate};

/// An endless sea at one time.
#[derive(Clone, Debug)]
pub struct SeaSurface {
    pub(crate) frame: SeaFrame,
    pub(crate) level: f64,
    pub(crate) bounds: Bounds,
    /// Height in meters that no phases can pass: Σ|a|.
    pub(crate) summit: f64,
    /// Shortest wave in meters; infinite without waves.
    pub(crate) shortest: f64,
    spacing: Spacing,
}

/// Standard deviations of the displacement that the search for visible points allows for: of a normal distribution,
/// 4 points in 100 million lie beyond.
const DEVIATIONS: f64 = 5.5;

impl SeaSurface {
    /// The sea at a time in seconds, at rest at world y = `level`.
    pub fn new(sea: &Sea, time: f64, level: f64) -> Self {
        let bounds = Bounds {
            rise: sea.height_bound().min(DEVIATIONS * sea.height_rms()),
            reach: sea.horizontal_bound().min(DEVIATIONS * sea.horizontal_rms()),
        };
        Self {
            frame: sea.at(time),
            level,
            bounds,
            summit: sea.height_bound(),
            shortest: sea.waves().iter().map(|wave| wave.wavelength).fold(f64::INFINITY, f64::min),
            spacing: Spacing::new(sea),
        }
    }

    /// World y of the rest level in meters.
    pub fn level(&self) -> f64 {
        self.level
    }

    /// The sea at its time.
    pub fn frame(&self) -> &SeaFrame {
        &self.frame
    }

    /// The point of the surface that rests at (x, z), its normal (not normalized) and lost slope variance, in f64.
    pub fn point(&self, rest: [f64; 2], footprint: f64) -> (DVec3, DVec3, f64) {
        let sample = self.frame.evaluate(rest, footprint);
        let position = DVec3::new(rest[0], self.level, rest[1]) + DVec3::from(sample.displacement);
        (position, DVec3::from(sample.normal()), sample.slope_variance)
    }
}

impl Surface for SeaSurface {
    fn tessellate(&self, projector: &Projector, wanted: ChannelSet) -> Mesh {
        let mesh = if projector.orthographic {
            Strip::new(projector, self.level, self.bounds, tessellate::strip_depth(self, &self.spacing, projector))
                .map(|strip| tessellate::strip(self, &self.spacing, projector, &strip, wanted))
        } else {
            Sector::new(projector, self.level, self.bounds)
                .map(|sector| tessellate::sector(self, &self.spacing, projector, &sector, wanted))
        };
        mesh.unwrap_or_else(|| Mesh::empty(self.level))
    }

    fn trace(&self, projector: &Projector, ray: &Ray) -> Option<Hit> {
        reference::trace_sea(self, projector, ray)
    }

    fn resting(&self) -> Option<&dyn Resting> {
        Some(self)
    }
}
