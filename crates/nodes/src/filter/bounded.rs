//! Images whose samples are certain up to bounds.

use trochoid_graph::{Bound, Bounding, Kind, One, Outputs, REFERENCE, port};
use trochoid_image::Window;

/// One channel of the image of a filter, with its bounds.
#[derive(Clone, Copy)]
pub(crate) struct Bounded<'a> {
    window: Window,
    values: &'a [f32],
    bounds: &'a [f32],
    /// How far anything may be off at most.
    most: f64,
}

/// A sum of what samples hold and of how far they may be off.
#[derive(Clone, Copy)]
pub(crate) struct Summed {
    /// In f64, of what the stage was given.
    pub(crate) value: f64,
    pub(crate) bound: Bound,
    /// Of sizes, which rounding is relative to.
    size: f64,
}

impl Summed {
    pub(crate) const NOTHING: Self = Self { value: 0.0, bound: Bound::EXACT, size: 0.0 };

    /// The same value within another bound.
    pub(crate) fn within(self, bound: Bound) -> Self {
        Self { bound, ..self }
    }

    /// With so much more of another.
    pub(crate) fn plus(self, weight: f64, other: Self) -> Self {
        if weight == 0.0 {
            return self;
        }
        Self {
            value: self.value + weight * other.value,
            bound: Bound::of(self.bound.size + weight * other.bound.size).with(self.bound.clear && other.bound.clear),
            size: self.size + weight * other.size,
        }
    }

    /// How far a result may lie from what the reference sums, where it may be off by so much more; of nothing but NaN
    /// nothing is known.
    pub(crate) fn of(self, filled: f32, off: f64) -> Bound {
        let filled = f64::from(filled);
        if self.bound.size == 0.0 && off == 0.0 && filled == self.value {
            return Bound::of(if self.size.is_finite() { self.size * REFERENCE } else { 0.0 }).with(self.bound.clear);
        }
        Bound::of((filled - self.value).abs() + self.bound.size + off + self.size * REFERENCE).with(self.bound.clear)
    }
}

impl<'a> Bounded<'a> {
    /// A channel of an image of a kind: weights differ by 1 at most.
    fn of(bounding: &Bounding<'a>, image: &One<port::Image>, (kind, channel): (Kind, usize)) -> Option<Self> {
        let from = &bounding.inputs.all(image)[0];
        let values = from.planes.get(channel).copied()??;
        let bounds = bounding.bounds.planes(image, 0).get(channel).copied()??;
        let most = if matches!(kind, Kind::Weights(_)) { 1.0 } else { f64::INFINITY };
        Some(Self { window: from.window, values, bounds, most })
    }

    /// Every channel that a filter of an image of a kind has filled and is asked for, with what was filled, and where its
    /// bounds belong.
    pub(crate) fn channels<'o>(
        bounding: &Bounding<'a>,
        port: &One<port::Image>,
        kind: Kind,
        outputs: &mut Outputs<'o>,
    ) -> impl Iterator<Item = (Self, &'a [f32], &'o mut [f32])> {
        (0..kind.channels()).filter_map(move |channel| {
            let image = Self::of(bounding, port, (kind, channel))?;
            Some((image, bounding.filled[0][channel].unwrap_or_default(), outputs.only(channel)?))
        })
    }

    /// The pixels that it has.
    pub(crate) fn window(&self) -> Window {
        self.window
    }

    /// A pixel; beyond the edge the nearest one.
    pub(crate) fn at(&self, x: i64, y: i64) -> Summed {
        let Window { x0, x1, y0, y1 } = self.window;
        let index = (y.clamp(y0, y1 - 1) - y0) as usize * self.window.width() + (x.clamp(x0, x1 - 1) - x0) as usize;
        let value = f64::from(self.values[index]);
        let bound = Bound::decode(self.bounds[index]);
        Summed { value, bound: Bound { size: bound.size.min(self.most), ..bound }, size: value.abs() }
    }
}
