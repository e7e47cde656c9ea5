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
    #[knob(default = 0.0, range = -1e7..=1e7, unit = "m")]
    x: f64,
    /// World z of the upper edge.
    #[knob(default = 0.0, range = -1e7..=1e7, unit = "m")]
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

#[cfg(test)]
mod tests {
    use super::*;
    use crate::testing::{Frame, graph, refused};
    use std::path::Path;
    use trochoid_image::Format;
    use trochoid_sea::{ExplicitWave, Sea, Wave};

    fn baked(nodes: &str, width: u32, height: u32) -> Result<Frame, NodeError> {
        let graph = graph("field", &format!("{nodes}, {PICKED}"), Path::new(".")).unwrap();
        Frame::new(graph.with_format(Format::new(width, height, 1).unwrap()))
    }

    const PICKED: &str = r#""out": { "type": "FieldMath", "expression": "a", "a": "b.height" }"#;

    /// Returns a generator of numbers from 0 to 1, determined by a seed.
    fn random(seed: u64) -> impl FnMut() -> f64 {
        let mut state = seed.wrapping_mul(0x9e37_79b9_7f4a_7c15) | 1;
        move || {
            state ^= state << 13;
            state ^= state >> 7;
            state ^= state << 17;
            (state >> 11) as f64 / (1u64 << 53) as f64
        }
    }

    /// Returns random waves, as JSON and as a sea.
    fn waves(count: usize, shortest: f64, random: &mut impl FnMut() -> f64) -> (String, Sea) {
        let mut list = Vec::new();
        let mut sea = Vec::new();
        for _ in 0..count {
            let wave = ExplicitWave {
                wavelength: shortest * libm::exp(4.0 * random()),
                amplitude: random() - 0.3,
                direction: (360.0 * random()).round().to_radians(),
                sharpness: 2.0 * random() / count as f64,
                phase: (360.0 * random()).round().to_radians(),
                speed: None,
            };
            list.push(format!(
                r#"{{ "wavelength": {:?}, "amplitude": {:?}, "direction": {}, "sharpness": {:?}, "phase": {} }}"#,
                wave.wavelength,
                wave.amplitude,
                wave.direction.to_degrees().round(),
                wave.sharpness,
                wave.phase.to_degrees().round(),
            ));
            sea.push(Wave::try_from(wave).unwrap());
        }
        (format!(r#""sea": {{ "type": "GerstnerSea", "count": 0, "waves": [{}] }}"#, list.join(", ")), Sea::new(sea))
    }

    /// Returns the largest distance of each image from the f64 sum, relative to the given scale of its values.
    fn distances(frame: &Frame, scales: [f64; 4]) -> [f64; 4] {
        let id = frame.graph.find("b").unwrap();
        let (width, height) = (frame.context.format.width(), frame.context.format.height());
        let mut worst = [0.0f64; 4];
        for (x, y) in (0..height).flat_map(|y| (0..width).map(move |x| (x, y))) {
            let at = [f64::from(x) + 0.25, f64::from(y) + 0.75];
            for output in 0..4 {
                let Reference::Field(truth) = frame.reference(id, output, at) else { unreachable!() };
                for (channel, truth) in truth.into_iter().enumerate() {
                    let found = f64::from(frame.filled(id, output, channel, at));
                    assert!(found.is_finite());
                    worst[output] = worst[output].max((found - truth).abs() / scales[output]);
                }
            }
        }
        worst
    }

    #[test]
    fn images_are_within_the_tolerance_of_the_f64_sum() {
        let mut random = random(3);
        for (count, tolerance) in [(0, 1e-4f64), (1, 1e-4), (7, 1e-6), (60, 1e-4), (300, 1e-3), (300, 1e-6)] {
            for (x, width, depth, shortest) in [(-20.0, 64.0, 30.0, 1.0), (1e7, 0.5, 9.0, 0.05), (3.0, 4e5, 1.0, 2e3)] {
                let (sea, truth) = waves(count, shortest, &mut random);
                let bake = format!(
                    r#"{sea}, "b": {{ "type": "Bake", "sea": "sea", "x": {x}, "z": -7, "width": {width},
                        "depth": {depth}, "footprint": {}, "tolerance": {tolerance:?} }}"#,
                    shortest * random()
                );
                let frame = baked(&bake, 37, 21).unwrap();
                // Normals and Jacobians depend on slopes and strains, whose products grow with their size.
                let steep = truth.derivative_rms(1, 0.0);
                let strain: f64 = truth.waves().iter().map(|wave| wave.compression().powi(2) / 2.0).sum();
                let bend = (1.0 + steep + strain.sqrt()).powi(2);
                let move_rms = truth.height_rms().max(truth.horizontal_rms()).max(1e-3);
                let worst = distances(&frame, [truth.height_rms().max(1e-3), bend, move_rms, bend]);
                let exact = tolerance.max(2e-6) + 2e-7;
                for (output, worst) in worst.into_iter().enumerate() {
                    // A normal is a direction: near a fold, a small error turns it far.
                    let limit = if output == 1 { 40.0 * exact } else { 4.0 * exact };
                    assert!(worst <= limit, "{count} waves, {tolerance}, {width} m, output {output}: {worst}");
                }
            }
        }
    }

    #[test]
    fn the_axis_that_points_up_turns_vectors() {
        let (sea, _) = waves(5, 3.0, &mut random(8));
        let nodes = |up: &str| format!(r#"{sea}, "b": {{ "type": "Bake", "sea": "sea", "up": "{up}" }}"#);
        let [y, z] = ["y", "z"].map(|up| baked(&nodes(up), 6, 5).unwrap());
        let id = y.graph.find("b").unwrap();
        for output in [1, 2] {
            let [y, z] = [&y, &z].map(|frame| [0, 1, 2].map(|c| frame.filled(id, output, c, [3.5, 1.5])));
            assert_eq!([y[0], -y[2], y[1]], z);
        }
    }

    #[test]
    fn a_toon_sea_is_baked_and_rests_where_it_ends() {
        let sea = r#""sea": { "type": "ToonSea", "columns": 32, "rows": 24, "spacing": 0.5, "preroll": 40,
            "bursts": [{ "path": [4, 4, 6, 6, 8, 6, 12, 8], "height": 3, "along": 3, "across": 2 }] }"#;
        let bake =
            format!(r#"{sea}, "b": {{ "type": "Bake", "sea": "sea", "x": -4, "z": -4, "width": 24, "depth": 20 }}"#);
        let frame = baked(&bake, 30, 25).unwrap();
        let worst = distances(&frame, [1.0; 4]);
        assert!(worst.iter().all(|worst| *worst < 2e-5), "{worst:?}");
        let id = frame.graph.find("b").unwrap();
        assert_eq!(frame.filled(id, 0, 0, [0.5, 0.5]), 0.0);
        let highest = (0..25).map(|y| frame.filled(id, 0, 0, [14.5, f64::from(y) + 0.5])).fold(0.0, f32::max);
        assert!(highest > 0.02, "{highest}");
    }

    #[test]
    fn what_cannot_be_baked_is_refused() {
        let model = r#""sea": { "type": "BezierModel", "patches": [{ "points": [{ "at": [0, 0, 0] },
            { "at": [1, 0, 0] }, { "at": [0, 0, 1] }, { "at": [1, 0, 1] }] }] },
            "b": { "type": "Bake", "sea": "sea" }"#;
        let faults = refused("field", &format!("{model}, {PICKED}"));
        assert!(faults.contains("which has no plane at rest") && faults.contains("GerstnerSea"), "{faults}");
    }

    #[test]
    fn what_is_held_is_reckoned_before_it_is_taken() {
        let sea = r#""sea": { "type": "GerstnerSea", "count": 3 }, "b": { "type": "Bake", "sea": "sea" }"#;
        let frame = baked(sea, 16, 9).unwrap();
        let node = frame.graph.settle(frame.graph.find("b").unwrap(), 1);
        let (bake, of) = (node.get::<Bake>().unwrap(), |_| MemoryUse::default());
        let taken = |wanted: [bool; 4]| {
            let channels = [1, 3, 3, 1].into_iter().zip(wanted).map(|(count, wanted)| vec![wanted; count]);
            let channels: Vec<Vec<bool>> = channels.collect();
            let taken = bake.memory(&MemoryContext::new(&frame.context, &channels, &of));
            [taken.held, taken.working].map(|bytes| bytes / (16 * 9 * 4))
        };
        assert_eq!(taken([true, false, false, false]), [1, 3]);
        assert_eq!(taken([true; 4]), [8, 8]);
        assert_eq!(taken([false; 4]), [0, 0]);
    }

    #[test]
    fn only_the_images_that_are_wanted_are_held() {
        let (sea, _) = waves(3, 3.0, &mut random(1));
        let frame = baked(&format!(r#"{sea}, "b": {{ "type": "Bake", "sea": "sea" }}"#), 4, 3).unwrap();
        let id = frame.graph.find("b").unwrap();
        let settled = frame.graph.settle(id, 1);
        let bake = settled.get::<Bake>().unwrap();
        let handles = |id: NodeId| frame.prepared[id.0].as_ref().and_then(|prepared| prepared.handle());
        let wanted = [vec![true], vec![false; 3], vec![false; 3], vec![false]];
        let pool = Pool::new();
        let kinds = &frame.graph.node(id).kinds;
        let prepare = Prepare::new(&frame.context, kinds, &wanted, &handles, &|| false, &pool);
        assert_eq!(bake.prepare(&prepare).unwrap().bytes(), 4 * 3 * size_of::<f32>());
        let stopped = Prepare::new(&frame.context, kinds, &wanted, &handles, &|| true, &pool);
        assert_eq!(bake.prepare(&stopped).err().unwrap().to_string(), "cancelled");
    }
}
