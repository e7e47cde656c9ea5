//! What a search along a ray finds, and the effort that it may take.

use crate::surface::OneSheet;
use glam::DVec3;
use trochoid_sea::Sample;

/// What a ray meets.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum First {
    /// No point of the sea.
    Nothing,
    /// The first point.
    At(FirstPoint),
    /// It is not known: the effort was not enough.
    Unknown,
    /// The cells do not contain this part of the ray.
    Beyond,
}

/// The first point of a sea on a ray.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct FirstPoint {
    /// Distance along the ray, in meters.
    pub distance: f64,
    /// Rest point x, z.
    pub rest: [f64; 2],
    /// The sea there; `None` if only the point was asked for.
    pub shape: Option<Shape>,
    /// How far any value may be from that of the sea's own point.
    pub off: f64,
    /// How far the distance may be from that of the sea's own point.
    pub deep: f64,
    /// How far the rest point may be from that of the sea's own point, in meters.
    pub moved: f64,
    /// Rest points that hold no other point of the ray.
    pub sheet: Option<OneSheet>,
}

/// The shape of a sea at a point.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Shape {
    /// Normal, not normalized: its height is the Jacobian of the horizontal displacement.
    pub normal: DVec3,
    /// Slope variance of the waves that the footprint filters out.
    pub slope_variance: f64,
}

impl From<&Sample> for Shape {
    fn from(sample: &Sample) -> Self {
        Self { normal: DVec3::from(sample.normal()), slope_variance: sample.slope_variance }
    }
}

/// Effort that a search may take.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Thoroughness {
    /// Only as much as it takes to know whether there is a point, on which sheet it lies, and its distance nearly; otherwise
    /// as `Quick`.
    Rough,
    /// As `Quick`, but values may be off by a thousandth, as the point says.
    Near,
    /// As much as most rays need; some rays, near contours above all, remain unknown.
    Quick,
    /// As much as nearly all rays need: some milliseconds at most.
    Thorough,
}

impl Thoroughness {
    /// Returns the most parts of patches, and the most smaller cells, that a ray may take.
    pub(super) fn most(self) -> (u32, u32) {
        match self {
            Self::Rough | Self::Near | Self::Quick => (1000, 6),
            Self::Thorough => (12_000, 48),
        }
    }
}
