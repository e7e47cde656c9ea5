//! Inputs of filters with an error bound for every sample, and weighted sums that carry the bounds along.

use trochoid_graph::{Bound, Bounding, Kind, One, Outputs, REFERENCE, port};
use trochoid_image::Window;

/// One channel of a filter's input image with its error bounds.
#[derive(Clone, Copy)]
pub(crate) struct BoundedChannel<'a> {
    window: Window,
    values: &'a [f32],
    bounds: &'a [f32],
    /// Largest possible error of a sample of this kind.
    most: f64,
}

/// A weighted sum of samples with its error bound.
#[derive(Clone, Copy)]
pub(crate) struct BoundedSum {
    /// Sum of the samples as given to the stage, in f64.
    pub(crate) value: f64,
    pub(crate) bound: Bound,
    /// Sum of the magnitudes.
    size: f64,
    /// Bound on what rounding in f64 has lost: of each product and each sum, at most 2⁻⁵³ of the magnitudes so far.
    lost: f64,
}

impl BoundedSum {
    pub(crate) const NOTHING: Self = Self { value: 0.0, bound: Bound::EXACT, size: 0.0, lost: 0.0 };

    /// Returns the same value with another bound.
    pub(crate) fn within(self, bound: Bound) -> Self {
        Self { bound, ..self }
    }

    /// Adds another sum times a weight.
    pub(crate) fn plus(self, weight: f64, other: Self) -> Self {
        if weight == 0.0 {
            return self;
        }
        let size = self.size + weight * other.size;
        Self {
            value: self.value + weight * other.value,
            bound: Bound::of(self.bound.size + weight * other.bound.size).with(self.bound.clear && other.bound.clear),
            size,
            lost: self.lost + weight * other.lost + f64::EPSILON * size,
        }
    }

    /// Returns how far a filled result may lie from the reference's sum, given a further error of up to `off`. If the
    /// sum is NaN, the bound is infinite.
    ///
    /// |y − Σ wx′| ≤ |y − Σ wx| + Σ w·dx, and both sums are rounded.
    pub(crate) fn of(self, filled: f32, off: f64) -> Bound {
        let filled = f64::from(filled);
        let lost = 2.0 * self.lost + self.size * REFERENCE;
        if self.bound.size == 0.0 && off == 0.0 && filled == self.value {
            return Bound::of(if self.size.is_finite() { lost } else { 0.0 }).with(self.bound.clear);
        }
        Bound::of((filled - self.value).abs() + self.bound.size + off + lost).with(self.bound.clear)
    }
}

impl<'a> BoundedChannel<'a> {
    /// Returns a channel of an image of a kind. The error of a weight is at most 1.
    fn of(bounding: &Bounding<'a>, image: &One<port::Image>, kind: Kind, channel: usize) -> Option<Self> {
        let from = &bounding.inputs.all(image)[0];
        let values = from.planes.get(channel).copied()??;
        let bounds = bounding.bounds.planes(image, 0).get(channel).copied()??;
        let most = if matches!(kind, Kind::Weights(_)) { 1.0 } else { f64::INFINITY };
        Some(Self { window: from.window, values, bounds, most })
    }

    /// Iterates over the channels for which a filter is asked for bounds: the input channel, the values that the filter
    /// filled, and the plane that takes the bounds.
    pub(crate) fn channels<'o>(
        bounding: &Bounding<'a>,
        port: &One<port::Image>,
        kind: Kind,
        outputs: &mut Outputs<'o>,
    ) -> impl Iterator<Item = (Self, &'a [f32], &'o mut [f32])> {
        (0..kind.channels()).filter_map(move |channel| {
            let image = Self::of(bounding, port, kind, channel)?;
            Some((image, bounding.filled[0][channel].unwrap_or_default(), outputs.only(channel)?))
        })
    }

    /// Returns the pixels that the channel covers.
    pub(crate) fn window(&self) -> Window {
        self.window
    }

    /// Returns a pixel; beyond the edge, the nearest one.
    pub(crate) fn at(&self, x: i64, y: i64) -> BoundedSum {
        let Window { x0, x1, y0, y1 } = self.window;
        let index = (y.clamp(y0, y1 - 1) - y0) as usize * self.window.width() + (x.clamp(x0, x1 - 1) - x0) as usize;
        let value = f64::from(self.values[index]);
        let bound = Bound::decode(self.bounds[index]);
        BoundedSum { value, bound: Bound { size: bound.size.min(self.most), ..bound }, size: value.abs(), lost: 0.0 }
    }
}
