//! Profiles of seas, and what simulated seas reach, for plots and notes.

/// A line on the plane of a sea at rest.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct ProfileLine {
    /// World x and z of its middle; `None` for the middle of the sea, or the origin if the sea has no end.
    pub through: Option<[f64; 2]>,
    /// Direction, degrees: 0 is +X, 90 is +Z.
    pub direction: f64,
    /// Length in meters; `None` for some waves, or the whole sea if it ends.
    pub length: Option<f64>,
    /// Number of points of the sea at rest, at least 2.
    pub points: usize,
}

/// The surface above a line of the sea at rest, seen from the side.
#[derive(Clone, Debug, PartialEq)]
pub struct Profile {
    /// World x and z of the middle of the line.
    pub through: [f64; 2],
    /// Length of the line, m.
    pub length: f64,
    /// Points in their order at rest. A sea that ends has fewer of them than the line.
    pub points: Vec<ProfilePoint>,
}

/// A point of the surface.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct ProfilePoint {
    /// Distance from the middle of the line, m, with what the wave has moved it along the line.
    pub along: f64,
    /// Height above the level at rest, m.
    pub height: f64,
    /// Whether the surface is turned over here.
    pub folded: bool,
}

/// What a simulated sea reaches over the frames of a document.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Reached {
    /// Time of the last frame that was looked at, s.
    pub until: f64,
    /// Least and greatest height above the level at rest, m.
    pub heights: [f64; 2],
    /// Greatest rift.
    pub rift: f64,
}

/// Times of the frames of a document, in seconds since the first one.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct FrameTimes {
    /// Number of frames, at least 1.
    pub count: u64,
    /// Frames per second.
    pub fps: f64,
}

impl FrameTimes {
    /// Returns the times, in their order.
    pub fn iter(self) -> impl Iterator<Item = f64> {
        (0..self.count).map(move |frame| frame as f64 / self.fps)
    }

    /// Returns the time of the last frame.
    pub fn last(self) -> f64 {
        self.count.saturating_sub(1) as f64 / self.fps
    }
}
