//! Items that raise the water of a toon sea: bursts, guides with their copies, and floating bodies.

use trochoid_graph::Items;
use trochoid_sea::toon::{self as model, ToonError};

/// A path and its timing.
#[derive(Clone, Items)]
pub(crate) struct TimedPath {
    /// Control points x, z, x, z, … of a cubic Bézier curve, relative to the grid's first cell.
    #[knob(len = 8..=8, unit = "m", required)]
    path: Vec<f64>,
    /// Time to travel the path from end to end.
    #[knob(default = 10.0, range = 1e-3..=1e9, unit = "s")]
    duration: f64,
    /// Time by which it is ahead on its path.
    #[knob(default = 0.0, range = -1e9..=1e9, unit = "s")]
    offset: f64,
}

/// The shape that a burst raises.
#[derive(Clone, Items)]
struct BurstShape {
    /// Height H of the burst.
    #[knob(default = 1.0, range = -1e6..=1e6, unit = "m")]
    height: f64,
    /// Peak p: factor of height and radii.
    #[knob(default = 1.0, range = 1e-3..=1e3)]
    peak: f64,
    /// Radius r along the heading, or along x if not `oriented`.
    #[knob(default = 2.0, range = 1e-3..=1e6, unit = "m")]
    along: f64,
    /// Radius r across the heading, or along z if not `oriented`.
    #[knob(default = 2.0, range = 1e-3..=1e6, unit = "m")]
    across: f64,
}

/// The time during which it acts.
#[derive(Clone, Items)]
struct ActiveTime {
    /// Share of the path over which it fades in at the start and out at the end.
    #[knob(default = 0.0, range = 0.0..=0.5)]
    fade: f64,
    /// Start time; if unset, it acts from the preroll on.
    #[knob(range = -1e9..=1e9, unit = "s")]
    start: Option<f64>,
    /// End time; if unset, it never ends.
    #[knob(range = -1e9..=1e9, unit = "s")]
    end: Option<f64>,
}

/// A single burst, or the one copied by a guide.
#[derive(Clone, Items)]
pub(crate) struct Burst {
    #[items]
    path: TimedPath,
    #[items]
    shape: BurstShape,
    #[items]
    active: ActiveTime,
}

/// A burst and its randomized copies.
#[derive(Clone, Items)]
pub(crate) struct Guide {
    #[items]
    burst: Burst,
    /// Number of copies.
    #[knob(default = 8, range = 1..=100_000)]
    count: i64,
    /// Width over which the copies are laid out side by side.
    #[knob(default = 10.0, range = 0.0..=1e6, unit = "m")]
    width: f64,
    /// Standard deviation of the control points' positions.
    #[knob(default = 0.5, range = 0.0..=1e6, unit = "m")]
    jitter: f64,
    /// Standard deviation of the time offsets: small values make crests, large ones separate cones.
    #[knob(default = 0.25, range = 0.0..=1e6, unit = "s")]
    jitter_time: f64,
    /// Relative standard deviation of duration, peak and radii.
    #[knob(default = 0.15, range = 0.0..=10.0)]
    jitter_size: f64,
    /// Random seed.
    #[knob(default = 0, range = 0..=1_000_000_000)]
    seed: i64,
}

/// A floating body that travels along a path.
#[derive(Clone, Items)]
pub(crate) struct FloatingBody {
    #[items]
    path: TimedPath,
    #[items]
    active: ActiveTime,
    /// Length of the hull.
    #[knob(default = 4.0, range = 1e-3..=1e5, unit = "m")]
    length: f64,
    /// Width of the hull.
    #[knob(default = 1.2, range = 1e-3..=1e5, unit = "m")]
    beam: f64,
    /// Depth of the hull below the waterline.
    #[knob(default = 0.5, range = -1e5..=1e5, unit = "m")]
    draught: f64,
}

impl TimedPath {
    /// Returns a burst that travels the path during the span.
    fn burst(&self, span: &ActiveTime) -> model::Burst {
        let part = |index: usize| self.path.get(index).copied().unwrap_or_default();
        model::Burst {
            duration: self.duration,
            offset: self.offset,
            fade: span.fade,
            active: [span.start.unwrap_or(f64::NEG_INFINITY), span.end.unwrap_or(f64::INFINITY)],
            ..model::Burst::along(std::array::from_fn(|index| [part(2 * index), part(2 * index + 1)]))
        }
    }
}

impl Burst {
    pub(crate) fn burst(&self) -> model::Burst {
        let BurstShape { height, peak, along, across } = self.shape;
        model::Burst { height, peak, influence: [along, across], ..self.path.burst(&self.active) }
    }
}

impl Guide {
    pub(crate) fn bursts(&self) -> Vec<model::Burst> {
        let guide = model::Guide {
            burst: self.burst.burst(),
            count: self.count(),
            width: self.width,
            jitter: self.jitter,
            jitter_time: self.jitter_time,
            jitter_size: self.jitter_size,
            seed: self.seed as u64,
        };
        guide.bursts()
    }

    /// Returns the number of copies.
    pub(crate) fn count(&self) -> usize {
        self.count as usize
    }
}

impl FloatingBody {
    /// Returns the bursts with which the body moves the water.
    ///
    /// # Errors
    /// A value is out of range.
    pub(crate) fn bursts(&self) -> Result<Vec<model::Burst>, ToonError> {
        let Self { length, beam, draught, .. } = *self;
        model::Body { way: self.path.burst(&self.active), length, beam, draught }.bursts()
    }
}
