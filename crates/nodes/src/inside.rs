//! What the tests of this crate see beside its nodes. They stand outside, in `tests/nodes`, so that the crate is not
//! compiled a second time for them. Nothing of it is part of the interface.

use crate::paint::scan::Row;
use crate::paint::seeds::{self, Cells};
use crate::paint::{self, Brush, Ground, LANES, Layer, Rows, Stroke};
use std::ops::Range;
use trochoid_image::Window;

/// Surface point that a pixel sees: where it is at rest, the index of its surface, and its depth.
pub type Corner = ([f64; 3], f64, f64);

/// The seeds of one layer of strokes.
pub struct Seeds(Cells);

impl Seeds {
    /// Creates the seeds of the layer with this key.
    pub fn new(layer: u64) -> Self {
        Self(Cells::new(layer))
    }

    /// Calls `found` with key, position, share and surface of each seed between four pixels (upper left, upper right,
    /// lower left, lower right) that are `side` pixels apart, one per `pixels` square pixels. Returns the area between
    /// them per pixel²; `None` if an edge lies between them, of surfaces or of depths that differ by the factor `step`.
    pub fn each(
        &mut self,
        corners: [Corner; 4],
        side: f64,
        step: f64,
        pixels: f64,
        found: &mut dyn FnMut(u64, [f64; 2], f64, f64),
    ) -> Option<f64> {
        let corners = corners.map(|(rest, part, depth)| seeds::Corner { rest, part, depth });
        let patch = seeds::placed(corners, side, step)?;
        seeds::seeds_of(&patch, pixels, &mut self.0, |seed| found(seed.key, seed.at, seed.share, seed.part));
        Some(patch.area)
    }
}

/// Returns the patches of a row that may hold seeds of the layer with a key, in ascending order, given the corners above and
/// below, the sizes of strokes and the spacing, in pixels.
pub fn scanned(layer: u64, corners: [&[Corner]; 2], side: f64, step: f64, sizes: &[f64], spacing: f64) -> Vec<usize> {
    let corners = |row: usize| corners[row].iter().map(|&(rest, part, depth)| seeds::Corner { rest, part, depth });
    let layer = Layer { key: layer, spacing, ..Layer::default() };
    let (mut row, mut found) = (Row::default(), Vec::new());
    row.begin(side, step, corners(0));
    row.next(corners(1), sizes.iter().copied());
    row.scan([&layer].into_iter(), &mut found);
    found.into_iter().map(|(patch, _)| patch).collect()
}

/// Returns the area per stroke where the input `size` has a value, in pixels².
pub fn pixels(spacing: f64, size: f64) -> f64 {
    paint::pixels(&Layer { spacing, ..Layer::default() }, size)
}

/// Returns the lower of the two levels of seeds for an area per pixel²; `None` if it is degenerate.
pub fn level_of(area: f64, pixels: f64) -> Option<i64> {
    seeds::level_of(area, pixels)
}

/// Numbers of a stroke: those of Strokes' formula, and the surface and depth beyond whose edges it ends.
pub struct StrokeNumbers {
    /// Center, in pixels.
    pub at: [f64; 2],
    /// Unit vector along the stroke.
    pub along: [f64; 2],
    /// Half its length and half its width, in pixels.
    pub half: [f64; 2],
    /// Sideways displacement of its ends, in half widths.
    pub bend: f64,
    /// Opacity and bristle, and phases of both patterns of bristles, each from 0 to 1.
    pub looks: [f64; 4],
    /// Surface and depth, if edges cut the stroke.
    pub edge: Option<(f64, f64)>,
    /// Largest ratio of two depths that is not an edge.
    pub step: f64,
}

/// A stroke as it is painted row by row, and straight from the formula, on samples with some shift.
pub struct PaintedStroke(Stroke, Brush);

impl PaintedStroke {
    /// Creates the stroke with these numbers.
    pub fn new(numbers: &StrokeNumbers) -> Self {
        let StrokeNumbers { at, along, half, bend, looks: [opacity, bristle, one, other], edge, step } = *numbers;
        let (hairs, source, order) = ([one, other], [0, 0], 0);
        let stroke = Stroke { at, along, half, bend, opacity, bristle, hairs, edge, step, source, order };
        Self(stroke, Brush::new(&stroke))
    }

    /// Returns the pixels that it may cover.
    pub fn bounds(&self, shift: [f64; 2]) -> Window {
        self.1.bounds(self.1.seen_from(shift))
    }

    /// Returns the columns that it may cover in a row of a window, counted from the window's first.
    pub fn columns(&self, shift: [f64; 2], y: i64, x0: i64, width: usize) -> Range<usize> {
        let rows = self.rows(shift, y, x0, width);
        rows.from[0] as usize..rows.to[0] as usize
    }

    /// Returns its coverage of a row of a window, given surfaces and depths there. It is the row with this number of those
    /// that are computed together.
    pub fn row(&self, shift: [f64; 2], y: i64, number: usize, x0: i64, parts: &[f32], depths: &[f32]) -> Vec<f32> {
        let rows = self.rows(shift, y - number as i64, x0, parts.len());
        let groups = parts.chunks(LANES).zip(depths.chunks(LANES)).enumerate().map(|(group, (parts, depths))| {
            let mut ground = Ground::default();
            ground.parts[..parts.len()].copy_from_slice(parts);
            ground.depths[..depths.len()].copy_from_slice(depths);
            self.1.cover(&rows, number, group * LANES, ground)
        });
        groups.collect::<Vec<_>>().concat()
    }

    fn rows(&self, shift: [f64; 2], y: i64, x0: i64, width: usize) -> Rows {
        self.1.rows(self.1.seen_from(shift), y, x0, width)
    }

    /// Returns its coverage of a pixel, from the formula.
    pub fn covers(&self, shift: [f64; 2], [x, y]: [i64; 2], part: f64, depth: f64) -> f64 {
        let stroke = self.0.seen_from(shift);
        stroke.covers([x as f64 - stroke.at[0], y as f64 - stroke.at[1]], part, depth)
    }
}

#[cfg(feature = "scene")]
pub use with_scene::{BEND, CloudLayer, LineDrawing, doubled, halved, projected, refracted};

#[cfg(feature = "scene")]
mod with_scene {
    use crate::paint::line_set::{DrawnLines, LineSet, Recent};
    use crate::view::cloud_layers::{self, Layer};
    use crate::view::{flow_field, thickness};
    use trochoid_field::{Noise, NoiseKind, NoiseParameters};
    use trochoid_graph::Settled;
    use trochoid_scene::{DVec3, Projector, Ray};

    /// The lines of a LineSet, drawn place by place.
    pub struct LineDrawing {
        drawn: DrawnLines,
        recent: Recent,
    }

    impl LineDrawing {
        /// Returns the lines of a node, if it is a LineSet.
        pub fn of(node: &Settled) -> Option<Self> {
            Some(Self { drawn: node.get::<LineSet>()?.drawn(), recent: Recent::default() })
        }

        /// Returns the masks at a place; `change` is the change across lines from pixel to pixel.
        pub fn masks(&mut self, place: [f64; 2], change: f64, thickness: f64) -> Vec<f64> {
            self.drawn.masks(place, change, thickness, &mut self.recent).to_vec()
        }

        /// Forgets the lines kept from earlier places.
        pub fn forget(&mut self) {
            self.recent = Recent::default();
        }

        /// Returns the middle of a line, the factor of its widths, and the fraction of its width that it has at a
        /// position along it.
        pub fn line(&self, index: i64, along: f64) -> [f64; 3] {
            let line = self.drawn.line(index);
            [line.middle, line.width, self.drawn.taper(&line, along)]
        }
    }

    /// Sinking of a layer of clouds below a level plane, in meters per squared meter of distance.
    pub const BEND: f64 = cloud_layers::BEND;

    /// A layer of clouds.
    pub struct CloudLayer(Layer);

    impl CloudLayer {
        /// Creates a layer whose middle holds clouds where the noise is above 0.
        pub fn new(base: f64, thickness: f64, softness: f64, rounding: f64) -> Self {
            let parameters = NoiseParameters { scale: 1e3, octaves: 1, lacunarity: 2.0, gain: 0.5, seed: 1 };
            Self(Layer {
                base,
                thickness,
                sparse: 0.0,
                softness,
                rounding,
                opacity: 6.0,
                noise: Noise::new(NoiseKind::Fbm, parameters, None),
                wind: [1.0, 0.0],
                stretch: 1.0,
                moved: 0.0,
            })
        }

        /// Returns the first segment of a ray within the layer, no farther than `limit`.
        pub fn span(&self, ray: &Ray, bend: f64, limit: f64) -> Option<[f64; 2]> {
            self.0.span(ray, bend, limit)
        }

        /// Cuts a segment into parts, and returns the middle and the length of each.
        pub fn cut(&self, segment: [f64; 2], steps: usize) -> Vec<(f64, f64)> {
            let cut = self.0.cut(segment, steps);
            (0..).map_while(|step| cut.at(step)).collect()
        }

        /// Returns the mean density where the noise at a height lies within `spread` of `noise`.
        pub fn density(&self, noise: f64, height: f64, spread: f64) -> f64 {
            self.0.density(noise, height, spread)
        }
    }

    /// Returns (cos 2φ, sin 2φ) for a unit vector.
    pub fn doubled(direction: [f64; 2]) -> [f64; 2] {
        flow_field::doubled(direction)
    }

    /// Inverts [`doubled`], and returns the length of what it was given, too.
    pub fn halved(doubled: [f64; 2]) -> ([f64; 2], f64) {
        flow_field::halved(doubled)
    }

    /// Returns the direction in the picture of a world-space direction at a point.
    pub fn projected(eye: &Projector, point: DVec3, direction: DVec3) -> Option<[f64; 2]> {
        flow_field::projected(eye, point, direction)
    }

    /// Returns a direction refracted by a surface with this unit normal into a medium with index of refraction `ior`.
    pub fn refracted(direction: DVec3, normal: DVec3, ior: f64) -> DVec3 {
        thickness::refracted(direction, normal, ior)
    }
}

#[cfg(feature = "io")]
pub use with_io::{Holding, memory_of_read, prepare_read};

#[cfg(feature = "io")]
mod with_io {
    pub use crate::files::Holding;

    use crate::files::read::Read;
    use trochoid_graph::{MemoryContext, MemoryUse, NodeError, Prepare, Prepared, Settled};

    /// Prepares a picture that is held so; `None` if the node is no Read.
    ///
    /// # Errors
    /// As Read's own.
    pub fn prepare_read(
        node: &Settled,
        prepare: &Prepare<'_>,
        holding: Holding,
    ) -> Option<Result<Box<dyn Prepared>, NodeError>> {
        Some(node.get::<Read>()?.prepare_held(prepare, holding))
    }

    /// Returns the memory of a picture that is held so; `None` if the node is no Read.
    pub fn memory_of_read(node: &Settled, context: &MemoryContext<'_>, holding: Holding) -> Option<MemoryUse> {
        Some(node.get::<Read>()?.memory_of(context, holding))
    }
}
