//! What a search along a ray finds, and the effort that it may take.

use crate::surface::OneSheet;
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
    pub sample: Option<Sample>,
    /// How far derivatives and roughness may be from those of the sea's own point.
    pub off: f64,
    /// How far the distance may be from that of the sea's own point.
    pub deep: f64,
    /// Rest points that hold no other point of the ray.
    pub sheet: Option<OneSheet>,
}

/// Effort that a search may take.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Thoroughness {
    /// Only as much as it takes to know whether there is a point, on which sheet it lies, and its distance nearly; otherwise
    /// as `Quick`.
    Rough,
    /// As much as most rays need; some rays, near contours above all, remain unknown.
    Quick,
    /// As much as nearly all rays need: some milliseconds at most.
    Thorough,
}

impl Thoroughness {
    /// Returns the most parts of patches, and the most smaller cells, that a ray may take.
    pub(super) fn most(self) -> (u32, u32) {
        match self {
            Self::Rough | Self::Quick => (1000, 6),
            Self::Thorough => (12_000, 48),
        }
    }
}
