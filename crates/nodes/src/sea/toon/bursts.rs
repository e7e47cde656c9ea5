//! What raises the water of a toon sea: bursts, guides with their copies, and bodies that float along.

use trochoid_graph::Items;
use trochoid_sea::toon::{self as model, ToonError};

/// Where something travels.
#[derive(Clone, Items)]
pub(crate) struct Way {
    /// Control points x, z, x, z, … of a cubic Bézier curve, from the first cell on.
    #[knob(len = 8..=8, unit = "m", required)]
    path: Vec<f64>,
    /// Time from end to end.
    #[knob(default = 10.0, range = 1e-3..=1e9, unit = "s")]
    duration: f64,
    /// Time by which it is ahead.
    #[knob(default = 0.0, range = -1e9..=1e9, unit = "s")]
    offset: f64,
}

/// What a burst raises.
#[derive(Clone, Items)]
struct Heap {
    /// Height H.
    #[knob(default = 1.0, range = -1e6..=1e6, unit = "m")]
    height: f64,
    /// Peak p: scales height and radius.
    #[knob(default = 1.0, range = 1e-3..=1e3)]
    peak: f64,
    /// Radius r along the heading, or x.
    #[knob(default = 2.0, range = 1e-3..=1e6, unit = "m")]
    along: f64,
    /// Radius r across the heading, or along z.
    #[knob(default = 2.0, range = 1e-3..=1e6, unit = "m")]
    across: f64,
}

/// When it acts.
#[derive(Clone, Items)]
struct Span {
    /// Share of the path to grow in and to die out.
    #[knob(default = 0.0, range = 0.0..=0.5)]
    fade: f64,
    /// First moment; from the preroll on if unset.
    #[knob(range = -1e9..=1e9, unit = "s")]
    start: Option<f64>,
    /// Last moment; never if unset.
    #[knob(range = -1e9..=1e9, unit = "s")]
    end: Option<f64>,
}

/// A burst set by itself, or the one that a guide copies.
#[derive(Clone, Items)]
pub(crate) struct Burst {
    #[items]
    way: Way,
    #[items]
    heap: Heap,
    #[items]
    span: Span,
}

/// A burst and its noisy copies.
#[derive(Clone, Items)]
pub(crate) struct Guide {
    #[items]
    burst: Burst,
    /// Copies.
    #[knob(default = 8, range = 1..=100_000)]
    count: i64,
    /// Width over which copies stand side by side.
    #[knob(default = 10.0, range = 0.0..=1e6, unit = "m")]
    width: f64,
    /// Standard deviation of control points.
    #[knob(default = 0.5, range = 0.0..=1e6, unit = "m")]
    jitter: f64,
    /// Standard deviation of offsets: small makes crests, large cones.
    #[knob(default = 0.25, range = 0.0..=1e6, unit = "s")]
    jitter_time: f64,
    /// Relative standard deviation of duration, peak and radii.
    #[knob(default = 0.15, range = 0.0..=10.0)]
    jitter_size: f64,
    /// Which of all such systems.
    #[knob(default = 0, range = 0..=1_000_000_000)]
    seed: i64,
}

/// What floats along.
#[derive(Clone, Items)]
pub(crate) struct Afloat {
    #[items]
    way: Way,
    #[items]
    span: Span,
    /// Length.
    #[knob(default = 4.0, range = 1e-3..=1e5, unit = "m")]
    length: f64,
    /// Width.
    #[knob(default = 1.2, range = 1e-3..=1e5, unit = "m")]
    beam: f64,
    /// How deep it lies in the water.
    #[knob(default = 0.5, range = -1e5..=1e5, unit = "m")]
    draught: f64,
}

impl Way {
    /// A burst that travels there at that time.
    fn burst(&self, span: &Span) -> model::Burst {
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
        let Heap { height, peak, along, across } = self.heap;
        model::Burst { height, peak, influence: [along, across], ..self.way.burst(&self.span) }
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

    /// How many they are.
    pub(crate) fn count(&self) -> usize {
        self.count as usize
    }
}

impl Afloat {
    /// The bursts by which it moves the water.
    ///
    /// # Errors
    /// A figure is out of range.
    pub(crate) fn bursts(&self) -> Result<Vec<model::Burst>, ToonError> {
        let Self { length, beam, draught, .. } = *self;
        model::Body { way: self.way.burst(&self.span), length, beam, draught }.bursts()
    }
}
