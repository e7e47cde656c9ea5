//! Bake: writes a sea to images for other renderers.

use super::check_sea;
use crate::geometry::Up;
use crate::view::{MOST_DOUBT, NO_RUN, SurfaceHandle, exact};
use rayon::prelude::*;
use std::ops::Range;
use trochoid_graph::*;
use trochoid_image::Window;
use trochoid_scene::Resting;
use trochoid_sea::{FieldSet, Fields, Grid, Sample};

/// Evaluates a sea over a rectangle of the world and outputs images for other renderers.
///
/// # Formula
/// Pixel (i, j) of W × H is the rest point x₀ = `x` + (i + ½)·`width`/W, z₀ = `z` + (j + ½)·`depth`/H, seen from
/// above. displacement = P − P₀; height is its y; normal = N/|N|, N = ∂P/∂z₀ × ∂P/∂x₀; jacobian = det ∂(x, z)/∂(x₀,
/// z₀). With `up` z, (x, y, z) is written as (x, −z, y).
///
/// # Edge cases
/// The images have the document's size; to bake another size, use a separate document. Each pixel is evaluated at one
/// point, regardless of `samples`, and waves fade as in a picture whose pixels are `footprint` wide. Beyond the edge
/// of a finite sea the water is at rest. Where the surface is folded, the jacobian is below 0 and the normal points
/// down; a degenerate normal points up. Outputs with three channels are written as R, G, B, outputs with one channel
/// as Y, in 32-bit float. Blender and Houdini read these files directly: set their color space to raw.
///
/// # Source
/// Cook, Shade Trees, 1984 (displacement); Tessendorf, Simulating Ocean Water, 2001 (Jacobian).
#[derive(Clone, Node)]
#[node(stage, end = Front, revision = 1, outputs = Out)]
pub(crate) struct Bake {
    /// The sea to bake: a surface with a plane at rest.
    sea: One<port::Surface>,
    /// World x of the left edge.
    #[knob(default = 0.0, range = -1e7..=1e7, unit = "m", places = X)]
    x: f64,
    /// World z of the upper edge.
    #[knob(default = 0.0, range = -1e7..=1e7, unit = "m", places = Z)]
    z: f64,
    /// World size along x.
    #[knob(default = 100.0, range = 1e-3..=1e7, unit = "m")]
    width: f64,
    /// World size along z, which points down in the images.
    #[knob(default = 100.0, range = 1e-3..=1e7, unit = "m")]
    depth: f64,
    /// Axis that points up in the images: y for Houdini and Maya, z for Blender.
    up: Up,
    /// Footprint: waves too short for it fade. If unset, the larger pixel spacing is used; 0 keeps all waves.
    #[knob(range = 0.0..=1e7, unit = "m")]
    footprint: Option<f64>,
    /// Error tolerance, relative to the root mean square of each quantity; determines how waves are summed.
    #[knob(default = 1e-4, range = 1e-7..=1.0)]
    tolerance: f64,
}

#[derive(Clone, Copy, Debug, PartialEq, Outputs)]
enum Out {
    /// Height above the sea at rest, in meters.
    #[output(Kind::Field(1))]
    Height,
    /// Unit normal.
    #[output(Kind::Field(3), stored = ["R", "G", "B"])]
    Normal,
    /// Displacement from the rest point, in meters.
    #[output(Kind::Field(3), stored = ["R", "G", "B"])]
    Displacement,
    /// Ratio of the displaced area to the area at rest; foam forms where it is small.
    #[output(Kind::Field(1))]
    Jacobian,
}

impl Out {
    /// Returns the indices of the output's channels among the images.
    fn channels(self) -> Range<usize> {
        match self {
            Self::Height => 0..1,
            Self::Normal => 1..4,
            Self::Displacement => 4..7,
            Self::Jacobian => 7..8,
        }
    }
}

impl Bake {
    /// Returns the grid of the pixels' rest points.
    fn grid(&self, frame: &FrameContext) -> Grid {
        let sides = [frame.format.width(), frame.format.height()];
        let step = [self.width / f64::from(sides[0]), self.depth / f64::from(sides[1])];
        Grid {
            origin: [self.x + step[0] / 2.0, self.z + step[1] / 2.0],
            step,
            columns: sides[0] as usize,
            rows: sides[1] as usize,
            footprint: self.footprint.unwrap_or(step[0].max(step[1])),
        }
    }
}

/// Returns all channels at one rest point.
fn channels(sample: &Sample, up: Up) -> [f64; 8] {
    let normal = sample.normal();
    // Scale first, so that no squared component overflows or underflows.
    let largest = normal.iter().fold(0.0f64, |largest, n| largest.max(n.abs()));
    let normal = if largest > 0.0 && largest.is_finite() {
        let scaled = normal.map(|n| n / largest);
        let length = libm::sqrt(scaled.iter().map(|n| n * n).sum());
        scaled.map(|n| n / length)
    } else {
        [0.0, 1.0, 0.0]
    };
    let ([nx, ny, nz], [dx, dy, dz]) = (up.of_y_up(normal), up.of_y_up(sample.displacement));
    [sample.displacement[1], nx, ny, nz, dx, dy, dz, sample.jacobian()]
}

impl Node for Bake {
    fn check(&self, check: &mut Check<'_>) {
        check_sea(&self.sea, check);
    }
}

/// Whether any channel of an output is wanted.
fn is_asked(wanted: &[Vec<bool>], output: Out) -> bool {
    wanted.get(usize::from(output)).is_some_and(|channels| channels.contains(&true))
}

/// Returns the sums needed to compute the wanted images.
fn sums(wanted: &[Vec<bool>]) -> FieldSet {
    let any = |outputs: [Out; 2]| outputs.into_iter().any(|output| is_asked(wanted, output));
    let (displacement, derivatives) = (any([Out::Height, Out::Displacement]), any([Out::Normal, Out::Jacobian]));
    FieldSet { displacement, derivatives, ..FieldSet::default() }
}

/// Counts the channels of the wanted images and of the sums needed for them.
fn planes(wanted: &[Vec<bool>]) -> [usize; 2] {
    let images = Out::ALL.into_iter().filter(|output| is_asked(wanted, *output)).map(|output| output.channels().len());
    let FieldSet { displacement, derivatives, .. } = sums(wanted);
    [images.sum(), 3 * usize::from(displacement) + 5 * usize::from(derivatives)]
}

impl Stage for Bake {
    fn memory(&self, context: &MemoryContext<'_>) -> MemoryUse {
        let [images, sums] = planes(context.wanted).map(|planes| planes as u64 * context.pixels() * 4);
        MemoryUse::held(images, "bake fewer outputs at a time, or a smaller format").working(sums)
    }

    fn prepare(&self, prepare: &Prepare<'_>) -> Result<Box<dyn Prepared>, NodeError> {
        let surface: SurfaceHandle = prepare.handles::<SurfaceHandle>(&self.sea)?.swap_remove(0);
        let (grid, up) = (self.grid(prepare.frame), self.up);
        let points = grid.columns * grid.rows;
        let sea = resting(&surface, Self::SEA)?;
        let mut fields = Fields::default();
        let stop = prepare.cancellation();
        sea.on_grid(grid, sums(prepare.wanted), self.tolerance, &mut fields, stop)?;
        prepare.check_cancelled()?;
        let sample = |point: usize| {
            let value = |values: &Vec<f32>| values.get(point).map_or(0.0, |value| f64::from(*value));
            Sample {
                displacement: fields.displacement.each_ref().map(value),
                slope: fields.slope.each_ref().map(value),
                strain: fields.strain.each_ref().map(value),
                ..Sample::default()
            }
        };
        let images: [Vec<f32>; 8] = std::array::from_fn(|channel| {
            if !Out::ALL.iter().any(|output| is_asked(prepare.wanted, *output) && output.channels().contains(&channel))
            {
                return Vec::new();
            }
            let value = |point: usize| channels(&sample(point), up)[channel] as f32;
            let mut image = vec![0.0; points];
            image.par_chunks_mut(grid.columns).enumerate().filter(|_| !stop()).for_each(|(row, out)| {
                out.iter_mut().zip(row * grid.columns..).for_each(|(out, point)| *out = value(point));
            });
            image
        });
        prepare.check_cancelled()?;
        let surface = match prepare.referenced() {
            true => exact(&[surface], ChannelSet::EMPTY, prepare)?.swap_remove(0),
            false => surface,
        };
        Ok(Box::new(PreparedBake { surface, grid, up, images }))
    }
}

/// Returns the surface as one with a plane at rest.
fn resting(surface: &SurfaceHandle, sea: ItemName) -> Result<&dyn Resting, NodeError> {
    surface.resting().ok_or_else(|| {
        let found = "a surface without a plane at rest, such as a model";
        BadData::new(found, "a sea", "connect one").of_item(sea).into()
    })
}

struct PreparedBake {
    /// The surface that references see, if prepared for them.
    surface: SurfaceHandle,
    grid: Grid,
    up: Up,
    /// The channels of all outputs, row by row; empty if not wanted.
    images: [Vec<f32>; 8],
}

impl PreparedBake {
    /// Returns all channels in the pixel of a sample, in f64.
    fn truth(&self, at: [f64; 2]) -> Result<[f64; 8], NodeError> {
        let Grid { origin, step, footprint, .. } = self.grid;
        let rest = [0, 1].map(|axis| origin[axis] + at[axis].floor() * step[axis]);
        Ok(channels(&resting(&self.surface, Bake::SEA)?.at(rest, footprint), self.up))
    }
}

impl Prepared for PreparedBake {
    fn fill(&self, block: &Block<'_>, _inputs: &Inputs<'_>, outputs: &mut Outputs<'_>) -> Result<(), NodeError> {
        let Window { x0, y0, .. } = block.window;
        let columns = block.window.width();
        if columns == 0 {
            return Ok(());
        }
        for output in Out::ALL {
            for (index, image) in self.images[output.channels()].iter().enumerate() {
                let Some(plane) = outputs.take(output, index) else { continue };
                for (row, out) in plane.chunks_exact_mut(columns).enumerate() {
                    let start = (y0 as usize + row) * self.grid.columns + x0 as usize;
                    out.copy_from_slice(&image[start..start + columns]);
                }
            }
        }
        Ok(())
    }

    fn bound(&self, bounding: &Bounding<'_>, outputs: &mut Outputs<'_>) -> Result<(), NoBound> {
        // A level surface is seen face on.
        let doubt = self.surface.doubt(1.0);
        if doubt > MOST_DOUBT {
            return Err(NO_RUN);
        }
        let pixels = bounding.block.pixels().map(|[x, y]| [x as f64, y as f64]);
        let truths: Option<Vec<[f64; 8]>> = pixels.map(|pixel| self.truth(pixel).ok()).collect();
        let Some(truths) = truths else { return Err(NoBound("the surface has no plane at rest")) };
        for output in Out::ALL {
            for (index, channel) in output.channels().enumerate() {
                bounding.bound_by(outputs, output, index, |sample| {
                    let (truth, off) = (truths[sample][channel], truths[sample][channel].abs() * REFERENCE + doubt);
                    Span { low: truth - off, high: truth + off, clear: true }
                });
            }
        }
        Ok(())
    }

    fn reference(&self, inputs: &References<'_>) -> Result<Vec<Reference>, NodeError> {
        let values = self.truth(inputs.at)?;
        Ok(Out::ALL.map(|output| Reference::Field(values[output.channels()].to_vec())).into())
    }

    fn bytes(&self) -> usize {
        self.images.iter().map(|image| image.len() * size_of::<f32>()).sum()
    }
}
