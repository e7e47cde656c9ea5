//! SurfaceLines: the net of light lines that scrolls over cartoon water.

use crate::lit::eye;
use crate::view::{is_covered, view_planes, view_vector};
use fearless_simd::{Level, Simd, dispatch};
use std::f64::consts::TAU;
use trochoid_field::{Noise, NoiseKind, NoiseParameters, Ranks, exponentials, hypotenuses};
use trochoid_graph::*;
use trochoid_memory::Scratch;
use trochoid_scene::{DVec3, Footprints};

/// A mask of lines that scroll and sway on the water, and coordinates with which a Texture places a tiled picture
/// there instead.
///
/// # Formula
/// q = (p₀ − scroll·time)/scale + sway·n(q), with p₀ the rest point and n gradient noise. The distance to a line is d
/// = scale·(F₂ − F₁)/2, from the two nearest feature points. A line of width w is drawn at least one pixel wide: W =
/// max(w, c), where c = √((∇d·a)² + (∇d·b)²) is the change of d over the sides a and b of the pixel's footprint on the
/// water, and ∇Fᵢ is the unit vector away from feature point i. The mask is (w/W)·(½ + (W/2 − d)/c), limited to [0,
/// w/W]. With distance it fades to the share of the water that lines cover, by exp(−(2πf/scale)²/8), f the longer side
/// of the footprint. u = (x₀ − scroll_x·time)/scale, v = −(z₀ − scroll_z·time)/scale.
///
/// # Edge cases
/// 0 where nothing is seen. u and v grow toward +X and −Z; whole pairs of tiles scrolled by are left out, so that the
/// coordinates stay exact. The footprint is that of the water at rest. Needs a view with a camera.
///
/// # Source
/// Creation of a cartoon shader of water for the web, part 2 (a tiled picture of lines, pos.y += time); Worley, A
/// Cellular Texture Basis Function, 1996, for the lines.
#[derive(Clone, Node)]
#[node(stage, end = Front, revision = 2, outputs = Out)]
pub(crate) struct SurfaceLines {
    /// View of the water.
    view: One<port::View>,
    /// Factor of the width at each place, for example from a Noise; 1 if not connected.
    thickness: Optional<port::Mask>,
    /// Size of the net's cells, and of one tile of u and v.
    #[knob(default = 3.0, range = 1e-3..=1e6, unit = "m")]
    scale: f64,
    /// Width of the lines.
    #[knob(default = 0.15, range = 0.0..=1e6, unit = "m")]
    width: f64,
    /// Scroll speed along x.
    #[knob(default = 0.0, range = -1e6..=1e6, unit = "m/s")]
    scroll_x: f64,
    /// Scroll speed along z.
    #[knob(default = 0.2, range = -1e6..=1e6, unit = "m/s")]
    scroll_z: f64,
    /// Amplitude of the lines' bends, relative to the cell size; 0 keeps them straight.
    #[knob(default = 0.25, range = 0.0..=10.0)]
    sway: f64,
    /// Rate of the swaying: at 1, the bends change completely once a second.
    #[knob(default = 0.3, range = -1e3..=1e3, unit = "1/s")]
    liveliness: f64,
    /// Random seed.
    #[knob(default = 0, range = 0..=1_000_000_000)]
    seed: i64,
}

#[derive(Clone, Copy, Debug, PartialEq, Outputs)]
enum Out {
    /// The lines.
    #[output(Kind::MASK)]
    Mask,
    /// Texture coordinate across the tiles; grows by 1 per tile.
    #[output(Kind::Field(1))]
    U,
    /// Texture coordinate along the height of the tiles; grows by 1 per tile.
    #[output(Kind::Field(1))]
    V,
}

const RESTS: [Channel; 3] = [Channel::RestX, Channel::RestY, Channel::RestZ];

impl Node for SurfaceLines {}

impl Stage for SurfaceLines {
    fn is_costly(&self) -> bool {
        true
    }

    fn required_channels(&self, _wanted: &[bool]) -> ChannelSet {
        ChannelSet::of(&RESTS).union(Channel::Coverage.into())
    }

    fn interval(&self, output: usize, _channel: usize) -> Option<(f64, f64)> {
        match Out::ALL[output] {
            Out::Mask => Some((0.0, 1.0)),
            Out::U | Out::V => None,
        }
    }

    fn is_pixelwise(&self) -> bool {
        true
    }

    fn depends_on_time(&self) -> bool {
        true
    }

    fn prepare(&self, prepare: &Prepare<'_>) -> Result<Box<dyn Prepared>, NodeError> {
        let (time, seed) = (prepare.frame.time, self.seed as u32);
        let cells =
            |size: f64, seed: u32| NoiseParameters { scale: size, octaves: 1, lacunarity: 2.0, gain: 0.5, seed };
        let net = Noise::new(NoiseKind::Edges, cells(1.0, seed), None);
        let evolution = self.liveliness * time;
        let bend = |axis: u32| Noise::new(NoiseKind::Fbm, cells(BEND, mixed(seed, axis)), Some(evolution));
        Ok(Box::new(PreparedSurfaceLines {
            node: self.clone(),
            footprints: Footprints::of(&eye(prepare, &self.view, prepare.frame.format)?),
            scrolled: [self.scroll_x, self.scroll_z].map(|speed| speed * time / self.scale),
            distances: distances(&net),
            bends: [bend(1), bend(2)],
            net,
        }))
    }
}

/// Size of the bends, in cells of the net.
const BEND: f64 = 1.7;

/// Returns the seed of a bend, different for each axis and from the net's.
fn mixed(seed: u32, axis: u32) -> u32 {
    seed.wrapping_mul(3).wrapping_add(axis).wrapping_mul(0x9e37_79b9)
}

/// Number of sample points along each axis of the net, and their number per cell.
const SAMPLES: usize = 64;
const SAMPLES_PER_MESH: f64 = 3.7;

/// Returns distances to the nearest line, in cells: their distribution gives the share of the water closer to a line
/// than a given distance.
fn distances(net: &Noise) -> Ranks {
    let place = |index: usize| [index % SAMPLES, index / SAMPLES].map(|step| step as f64 / SAMPLES_PER_MESH);
    let mut distances = vec![0.0; SAMPLES * SAMPLES];
    net.fill::<2>((0..SAMPLES * SAMPLES).map(place), &[], &mut distances);
    distances.iter_mut().for_each(|distance| *distance /= 2.0);
    Ranks::new(distances, 0.5)
}

struct PreparedSurfaceLines {
    node: SurfaceLines,
    footprints: Footprints,
    /// Scroll of the tiles along x and z, in tiles.
    scrolled: [f64; 2],
    net: Noise,
    bends: [Noise; 2],
    distances: Ranks,
}

/// Everything about the lines at one place except their distance.
#[derive(Clone, Copy, Default)]
struct LinePoint {
    /// Position in cells.
    at: [f64; 2],
    /// Steps to the neighboring pixels, in cells.
    steps: [[f64; 2]; 2],
    /// Width of the line in cells.
    width: f64,
    /// Share of the lines that remains at the pixel's size.
    sharp: f64,
    /// Share of the water that lines of this width cover.
    share: f64,
}

/// Number of places whose lengths and exponentials are computed together, in vectors.
const LANES: usize = 8;

/// Fills in the share of the lines that remains at the size of each place's pixel; 0 below 1e-8.
fn sharpen(places: &mut [(usize, LinePoint)]) {
    dispatch!(Level::new(), simd => simd.vectorize(#[inline(always)] || {
        for places in places.chunks_mut(LANES) {
            let mut longest = [0.0_f64; LANES];
            for step in 0..2 {
                let mut along = [[0.0; LANES]; 2];
                for (lane, (_, place)) in places.iter().enumerate() {
                    (along[0][lane], along[1][lane]) = (place.steps[step][0], place.steps[step][1]);
                }
                let lengths = hypotenuses(along[0], along[1]);
                for (longest, length) in longest.iter_mut().zip(lengths) {
                    *longest = longest.max(length);
                }
            }
            let mut exponents = [0.0; LANES];
            for (exponent, longest) in exponents.iter_mut().zip(longest) {
                let turn = TAU * longest;
                *exponent = if turn < FAINT { -turn * turn / 8.0 } else { 0.0 };
            }
            let shares = exponentials(exponents);
            for (((_, place), share), longest) in places.iter_mut().zip(shares).zip(longest) {
                place.sharp = if TAU * longest < FAINT { share } else { 0.0 };
            }
        }
    }));
}

/// Turns of a pixel from which on nothing remains of lines.
const FAINT: f64 = 12.0;

/// Fills in how much the distance from a line changes from pixel to pixel, in cells, given places with the gradients of
/// F₂ − F₁.
fn fill_changes(places: &[(usize, LinePoint)], slopes: &[[f64; 2]], out: &mut [f64]) {
    dispatch!(Level::new(), simd => simd.vectorize(#[inline(always)] || {
        let chunks = places.chunks(LANES).zip(slopes.chunks(LANES)).zip(out.chunks_mut(LANES));
        for ((places, slopes), out) in chunks {
            let mut along = [[0.0; LANES]; 2];
            for (lane, ((_, place), slope)) in places.iter().zip(slopes).enumerate() {
                for (step, along) in along.iter_mut().enumerate() {
                    let [x, z] = place.steps[step];
                    along[lane] = (slope[0] * x + slope[1] * z) / 2.0;
                }
            }
            let lengths = hypotenuses(along[0], along[1]);
            for (change, length) in out.iter_mut().zip(lengths) {
                *change = length.max(LEAST_CHANGE);
            }
        }
    }));
}

impl LinePoint {
    /// Returns the place displaced by an offset in cells.
    fn bent(&self, by: [f64; 2]) -> Self {
        Self { at: [self.at[0] + by[0], self.at[1] + by[1]], ..*self }
    }

    /// Returns the mask, given F₂ − F₁ and the change of half of it from pixel to pixel.
    fn mask(&self, edges: f64, change: f64) -> f64 {
        let d = edges / 2.0;
        let drawn = self.width.max(change);
        let line = if self.width > 0.0 {
            (self.width / drawn) * (0.5 + (drawn / 2.0 - d) / change).clamp(0.0, 1.0)
        } else {
            0.0
        };
        self.faded(line)
    }

    /// Fades a line to the share of the water that lines cover, by the pixel's size.
    fn faded(&self, line: f64) -> f64 {
        (self.share + (line - self.share) * self.sharp).clamp(0.0, 1.0)
    }
}

/// Least softness of an edge in cells, where the distance does not change.
const LEAST_CHANGE: f64 = 1e-3;

impl PreparedSurfaceLines {
    /// Returns a rest point in tiles.
    fn tiles(&self, rest: DVec3) -> [f64; 2] {
        [rest.x / self.node.scale - self.scrolled[0], rest.z / self.node.scale - self.scrolled[1]]
    }

    /// Returns the place of a rest point, before it is bent, and before it is known what remains of the lines there.
    fn place(&self, rest: DVec3, thickness: f64) -> LinePoint {
        let steps = self.footprints.axes(rest).map(|axis| axis.map(|along| along / self.node.scale));
        let width = self.node.width * thickness / self.node.scale;
        let share = self.distances.share_below(width / 2.0);
        LinePoint { at: self.tiles(rest), steps, width, sharp: 0.0, share }
    }

    /// Returns texture coordinates without whole pairs of tiles, which make no difference to a picture, mirrored or
    /// not.
    fn coordinates(&self, rest: DVec3) -> [f64; 2] {
        let offset = self.scrolled.map(|tiles| tiles - 2.0 * libm::floor(tiles / 2.0));
        [rest.x / self.node.scale - offset[0], offset[1] - rest.z / self.node.scale]
    }

    fn fill_mask(&self, rest: impl Fn(usize) -> DVec3, coverage: &[f32], thickness: Option<&[f32]>, mask: &mut [f32]) {
        mask.fill(0.0);
        // Places with lines side by side, however few of them there are.
        let mut near = Scratch::new();
        for (index, _) in coverage.iter().enumerate().filter(|(_, coverage)| **coverage != 0.0) {
            near.push((index, self.place(rest(index), thickness.map_or(1.0, |plane| f64::from(plane[index])))));
            if near.len() == AT_ONCE {
                self.draw(&mut near, mask);
                near.clear();
            }
        }
        self.draw(&mut near, mask);
    }

    /// Draws the lines at up to `AT_ONCE` places, each with its index in the mask.
    fn draw(&self, near: &mut Scratch<(usize, LinePoint)>, mask: &mut [f32]) {
        sharpen(near);
        near.retain(|(index, place)| {
            // Without a line to see there, its distance does not matter.
            let has_line = place.width > 0.0 && place.sharp > 0.0;
            if !has_line {
                mask[*index] = place.faded(0.0) as f32;
            }
            has_line
        });
        if self.node.sway > 0.0 {
            let mut bends = [[0.0; AT_ONCE]; 2];
            for (bend, out) in self.bends.iter().zip(&mut bends) {
                bend.fill::<2>(near.iter().map(|(_, place)| place.at), &[], &mut out[..near.len()]);
            }
            for (step, (_, place)) in near.iter_mut().enumerate() {
                *place = place.bent([0, 1].map(|axis| self.node.sway * f64::from(bends[axis][step])));
            }
        }
        let (mut places, mut edges, mut slopes) = ([[0.0; 2]; AT_ONCE], [0.0; AT_ONCE], [[0.0; 2]; AT_ONCE]);
        places.iter_mut().zip(near.iter()).for_each(|(at, (_, place))| *at = place.at);
        let count = near.len();
        self.net.fill_edges(&places[..count], &mut edges[..count], &mut slopes[..count]);
        let mut wide = [[0.0; 2]; AT_ONCE];
        wide.iter_mut().zip(&slopes[..count]).for_each(|(wide, slope)| *wide = slope.map(f64::from));
        let mut changes = [0.0; AT_ONCE];
        fill_changes(near, &wide[..count], &mut changes[..count]);
        for (((index, place), edges), change) in near.iter().zip(edges).zip(changes) {
            mask[*index] = place.mask(f64::from(edges), change) as f32;
        }
    }
}

/// Number of places at which lines are drawn at once.
const AT_ONCE: usize = 256;

/// Returns all outputs at one sample.
fn references(mask: f64, [u, v]: [f64; 2]) -> Vec<Reference> {
    let output = |output| match output {
        Out::Mask => Reference::Mask(mask),
        Out::U => Reference::Field(vec![u]),
        Out::V => Reference::Field(vec![v]),
    };
    Out::ALL.map(output).into()
}

impl Prepared for PreparedSurfaceLines {
    fn fill(&self, _block: &Block<'_>, inputs: &Inputs<'_>, outputs: &mut Outputs<'_>) -> Result<(), NodeError> {
        let coverage = inputs.view(&self.node.view, Channel::Coverage);
        let planes = view_planes(inputs, &self.node.view, RESTS);
        let rest = |index: usize| DVec3::from(planes.map(|plane| f64::from(plane[index])));
        if let Some(mask) = outputs.take(Out::Mask, 0) {
            let thickness = inputs.all(&self.node.thickness).first().and_then(|connection| connection.planes[0]);
            self.fill_mask(rest, coverage, thickness, mask);
        }
        for (axis, output) in [Out::U, Out::V].into_iter().enumerate() {
            let Some(plane) = outputs.take(output, 0) else { continue };
            for (index, (out, coverage)) in plane.iter_mut().zip(coverage).enumerate() {
                *out = if *coverage == 0.0 { 0.0 } else { self.coordinates(rest(index))[axis] as f32 };
            }
        }
        Ok(())
    }

    fn bound(&self, _bounding: &Bounding<'_>, _outputs: &mut Outputs<'_>) -> Result<(), NoBound> {
        Err(NoBound("the slope of the lines jumps where the nearest cell changes"))
    }

    fn reference(&self, inputs: &References<'_>) -> Result<Vec<Reference>, NodeError> {
        if !is_covered(inputs, &self.node.view) {
            return Ok(references(0.0, [0.0; 2]));
        }
        let rest = view_vector(inputs, &self.node.view, RESTS);
        let thickness = self.node.thickness.as_ref().map_or(1.0, |source| inputs.scalar(source));
        let mut place = self.place(rest, thickness);
        let longest = place.steps.map(|[x, z]| libm::hypot(x, z)).into_iter().fold(0.0, f64::max);
        let turn = TAU * longest;
        place.sharp = if turn < FAINT { libm::exp(-turn * turn / 8.0) } else { 0.0 };
        let place = place.bent([0, 1].map(|axis| self.node.sway * self.bends[axis].reference(&place.at, 0.0)));
        let (edges, slope) = self.net.edges_reference(place.at);
        let [across, along] = place.steps.map(|[x, z]| (slope[0] * x + slope[1] * z) / 2.0);
        let mask = place.mask(edges, libm::hypot(across, along).max(LEAST_CHANGE));
        Ok(references(mask, self.coordinates(rest)))
    }

    fn bytes(&self) -> usize {
        self.distances.bytes()
    }
}
