//! Neighborhood access for filters of a view: a pixel and its neighbors.

use trochoid_graph::{Bounding, Channel, Connection, Inputs, One, References, Span, port};
use trochoid_image::Window;
use trochoid_memory::Scratch;

/// Returns a window grown by a number of pixels on each side.
pub(crate) fn grown(window: Window, by: i64) -> Window {
    Window::new(window.x0 - by, window.y0 - by, window.x1 + by, window.y1 + by)
}

/// The planes of the view around a block; beyond the image, the nearest pixel repeats.
pub(crate) struct Neighborhood<'a> {
    view: &'a Connection<'a>,
}

impl<'a> Neighborhood<'a> {
    pub(crate) fn of(inputs: &Inputs<'a>, view: &One<port::View>) -> Self {
        Self { view: &inputs.all(view)[0] }
    }

    /// Returns the index of a pixel in the planes.
    pub(crate) fn index(&self, x: i64, y: i64) -> usize {
        let window = self.view.window;
        let column = x.clamp(window.x0, window.x1 - 1) - window.x0;
        let row = y.clamp(window.y0, window.y1 - 1) - window.y0;
        row as usize * window.width() + column as usize
    }

    /// Returns a range of columns of one row of a plane; where the plane lacks some of them, `spare` takes a copy.
    pub(crate) fn row<'p, T: Copy>(
        &self,
        plane: &'p [T],
        y: i64,
        columns: std::ops::Range<i64>,
        spare: &'p mut Vec<T>,
    ) -> &'p [T] {
        let Window { x0, x1, .. } = self.view.window;
        // Columns within the plane are contiguous.
        let (first, end) = (columns.start.max(x0), columns.end.min(x1));
        let within = if first < end { &plane[self.index(first, y)..][..(end - first) as usize] } else { &[] };
        if within.len() as i64 == columns.end - columns.start {
            return within;
        }
        spare.clear();
        let end = end.max(first).min(columns.end);
        spare.extend((columns.start..first.min(columns.end)).map(|x| plane[self.index(x, y)]));
        spare.extend_from_slice(within);
        spare.extend((end..columns.end).map(|x| plane[self.index(x, y)]));
        spare
    }

    /// Returns the number of samples in a plane.
    pub(crate) fn area(&self) -> usize {
        self.view.window.area()
    }

    /// Returns a channel that the node asks for.
    #[cfg(feature = "sea")]
    pub(crate) fn whole(&self, channel: Channel) -> &'a [f32] {
        self.plane(channel).unwrap_or_default()
    }

    fn plane(&self, channel: Channel) -> Option<&'a [f32]> {
        self.view.planes[channel as usize]
    }

    /// Returns the index of the surface seen by each sample, −1 where none is seen. Views that do not distinguish
    /// surfaces count as one surface.
    pub(crate) fn surfaces(&self) -> Scratch<f32> {
        let coverage = self.plane(Channel::Coverage).unwrap_or_default();
        match self.plane(Channel::Surface) {
            Some(surfaces) => {
                surfaces.iter().zip(coverage).map(|(surface, c)| if *c > 0.0 { *surface } else { -1.0 }).collect()
            }
            None => coverage.iter().map(|coverage| if *coverage > 0.0 { 0.0 } else { -1.0 }).collect(),
        }
    }
}

/// Returns the index of the surface that a sample sees, as in [`Neighborhood::surfaces`].
pub(crate) fn surface_of(inputs: &References<'_>, view: &One<port::View>) -> f64 {
    let channel = |channel: Channel| inputs.view(view, channel);
    // Views that do not distinguish surfaces hold the background's −1.
    if channel(Channel::Coverage) > 0.0 { channel(Channel::Surface).max(0.0) } else { -1.0 }
}

/// Returns the span of the surface indices that a sample may see, as in [`Neighborhood::surfaces`]; any index if uncertain.
pub(crate) fn may_see(bounding: &Bounding<'_>, view: &One<port::View>, sample: usize) -> Span {
    let [coverage, surface] =
        [Channel::Coverage, Channel::Surface].map(|channel| bounding.certain(view, channel, sample));
    if coverage.high <= 0.0 {
        Span::exactly(-1.0)
    } else if coverage.low > 0.0 && surface.low == surface.high {
        // Views that do not distinguish surfaces hold the background's −1.
        Span::exactly(surface.low.max(0.0))
    } else {
        Span::unclear(-1.0, f64::INFINITY)
    }
}

/// Returns the change of a value along an axis, given the values before, at and after a sample, where they belong to
/// the same surface: a central difference, or a one-sided one if only one neighbor exists; `None` without neighbors.
#[inline(always)]
pub(crate) fn change<T: Copy + std::ops::Sub<Output = T> + std::ops::Mul<f64, Output = T>>(
    before: Option<T>,
    here: T,
    after: Option<T>,
) -> Option<T> {
    match (before, after) {
        (Some(before), Some(after)) => Some((after - before) * 0.5),
        (Some(before), None) => Some(here - before),
        (None, Some(after)) => Some(after - here),
        (None, None) => None,
    }
}
