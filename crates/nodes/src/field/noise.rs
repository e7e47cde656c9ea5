//! Noise: procedural noise, fixed on the picture, in the world or on a surface at rest.

use crate::field::Screen;
use trochoid_field::{Noise as Octaves, NoiseKind, NoiseParameters};
use trochoid_graph::*;
use trochoid_image::Window;
use trochoid_memory::Scratch;

/// Makes procedural noise on the picture, in the world, or on the moving water.
///
/// # Formula
/// Σ gⁱ·nᵢ / Σ gⁱ over `octaves`, g = `gain`; the cells of octave i have the size scale/lacunarityⁱ. With `filter`,
/// each nᵢ fades to its mean as the pixel's footprint grows from half a cell to one cell. fbm: nᵢ is gradient noise n
/// in [−1, 1]. ridged: (1 − |n|)², in [0, 1]. cellular: min(F₁, 1), and edges: min(F₂, 1) − min(F₁, 1), both in [0, 1],
/// where F₁ ≤ F₂ are the distances to the two nearest feature points in cells.
///
/// # Edge cases
/// In world and rest space, 0 where no surface is seen. Screen coordinates run right and down from the upper left
/// corner in picture heights, so the noise does not change with the picture's size. A view without a camera or depth
/// has no footprints, so its noise is not filtered. Views store positions in 32 bits: far from the origin, cells finer
/// than that precision are lost, but the noise itself stays precise. Random numbers are computed from integers, so they
/// are the same on every machine. A Clamp with `min` −1 turns all of fbm into a mask.
///
/// # Source
/// Perlin, Improving Noise, 2002; Musgrave, Kolb and Mace, The Synthesis and Rendering of Eroded Fractal Terrains,
/// 1989; Worley, A Cellular Texture Basis Function, 1996.
#[derive(Clone, Node)]
#[node(stage, end = Front, revision = 2, output(noise: Kind::Field(1) = "fbm in [−1, 1], other kinds in [0, 1]."))]
#[also_called("Perlin", "Fractal", "Turbulence", "Voronoi", "Worley", "Cellular", "Fbm")]
pub(crate) struct Noise {
    /// View of the surfaces that the noise lies on; used if `space` is world or rest.
    view: Optional<port::View>,
    /// Type of noise: fbm (clouds), ridged (ridges), cellular (cells) or edges (borders between cells).
    kind: NoiseKind,
    /// Space in which the noise is fixed: screen (the picture), world (points in world space), or rest (points of the
    /// water at rest, so the noise moves with the water).
    space: Space,
    /// Size of the largest cells, in meters (in screen space: picture heights).
    #[knob(default = 1.0, range = 1e-3..=1e7)]
    scale: f64,
    /// Offset of the noise along x, y and z, in the unit of `scale`. In screen space, x and y are right and down; in
    /// rest space, y has no effect.
    #[knob(default = [0.0, 0.0, 0.0])]
    offset: [f64; 3],
    /// Number of octaves: layers of noise with ever smaller cells.
    #[knob(default = 4, range = 1..=16)]
    octaves: i64,
    /// Factor by which cells shrink from one octave to the next.
    #[knob(default = 2.0, range = 1.0..=8.0)]
    lacunarity: f64,
    /// Strength of each octave relative to the previous one.
    #[knob(default = 0.5, range = 0.0..=1.0)]
    gain: f64,
    /// Coordinate along an additional noise axis, in cells. Keyframe it to make the noise change in place; a change by
    /// 1 gives an entirely different noise.
    #[knob(range = -1e9..=1e9)]
    evolution: Option<f64>,
    /// Fades out cells smaller than a pixel's footprint, which would flicker.
    #[knob(default = true)]
    filter: bool,
    /// Random seed.
    #[knob(default = 0, range = 0..=1_000_000_000)]
    seed: i64,
}

/// Space in which noise is fixed.
#[derive(Clone, Copy, Debug, PartialEq, Choice)]
pub(crate) enum Space {
    Screen,
    World,
    Rest,
}

const REST: [Channel; 2] = [Channel::RestX, Channel::RestZ];
const WORLD: [Channel; 3] = [Channel::PositionX, Channel::PositionY, Channel::PositionZ];

impl Space {
    /// Returns the channels of the view that give a point's position in this space; none for the screen.
    fn channels(self) -> &'static [Channel] {
        match self {
            Self::Screen => &[],
            Self::World => &WORLD,
            Self::Rest => &REST,
        }
    }
}

impl Node for Noise {
    fn check(&self, check: &mut Check<'_>) {
        if self.space != Space::Screen && self.view.is_none() {
            let found = format!("{} without a view", self.space.word());
            check.error(Self::SPACE, found, "a view to lie on", "connect \"view\", or use \"screen\"");
        }
    }
}

impl Stage for Noise {
    fn is_costly(&self) -> bool {
        true
    }

    fn required_channels(&self, _wanted: &[bool]) -> ChannelSet {
        match self.space.channels() {
            [] => ChannelSet::EMPTY,
            channels => ChannelSet::of(channels).union(Channel::Coverage.into()),
        }
    }

    fn optional_channels(&self, _wanted: &[bool]) -> ChannelSet {
        // The depth along the ray gives the point in the world, and thus its footprint, in rest space too.
        if self.filter && self.space != Space::Screen { Channel::Depth.into() } else { ChannelSet::EMPTY }
    }

    fn interval(&self, _output: usize, _channel: usize) -> Option<(f64, f64)> {
        Some(self.kind.range())
    }

    fn rate(&self) -> Rate {
        Rate::Surface
    }

    fn prepare(&self, prepare: &Prepare<'_>) -> Result<Box<dyn Prepared>, NodeError> {
        let parameters = NoiseParameters {
            scale: self.scale,
            octaves: self.octaves as usize,
            lacunarity: self.lacunarity,
            gain: self.gain,
            seed: self.seed as u32,
        };
        Ok(Box::new(PreparedNoise {
            node: self.clone(),
            octaves: Octaves::new(self.kind, parameters, self.evolution),
            screen: Screen::of(prepare.frame.format),
            footprints: Footprints::of(self, prepare),
        }))
    }
}

struct PreparedNoise {
    node: Noise,
    octaves: Octaves,
    screen: Screen,
    footprints: Footprints,
}

/// Footprints of samples, in the unit of their positions.
enum Footprints {
    /// No filtering.
    None,
    /// The same footprint everywhere: a pixel.
    Even(f64),
    /// The part of the surface that a pixel covers.
    #[cfg(feature = "scene")]
    Seen(trochoid_scene::Projector),
}

impl Footprints {
    fn of(node: &Noise, prepare: &Prepare<'_>) -> Self {
        if !node.filter {
            return Self::None;
        }
        if node.space == Space::Screen {
            return Self::Even(1.0 / f64::from(prepare.frame.format.height()));
        }
        #[cfg(feature = "scene")]
        if let Ok(eye) = crate::lit::eye(prepare, &node.view, prepare.frame.format) {
            return Self::Seen(eye);
        }
        Self::None
    }

    /// Returns the footprint of the sample at a position in pixels that sees a surface at a depth.
    #[cfg_attr(not(feature = "scene"), allow(unused_variables, reason = "only views have depths"))]
    fn at(&self, pixels: [f64; 2], depth: f64) -> f64 {
        match self {
            Self::None => 0.0,
            Self::Even(size) => *size,
            #[cfg(feature = "scene")]
            Self::Seen(eye) if depth.is_finite() => {
                let ray = eye.ray(pixels[0], pixels[1]);
                let ahead = ray.direction.dot(eye.forward);
                trochoid_scene::footprint(eye, ray.at(depth / ahead))
            }
            #[cfg(feature = "scene")]
            Self::Seen(_) => 0.0,
        }
    }

    /// Fills `out` with the footprints of several samples.
    fn fill(&self, pixels: &[[f64; 2]], depths: &[f32], out: &mut [f32]) {
        #[cfg(feature = "scene")]
        if let Self::Seen(eye) = self {
            return trochoid_scene::footprints_seen(eye, pixels, depths, out);
        }
        for ((out, pixels), depth) in out.iter_mut().zip(pixels).zip(depths) {
            *out = self.at(*pixels, f64::from(*depth)) as f32;
        }
    }

    /// Returns the span of the footprint over a span of depths.
    fn span(&self, pixels: [f64; 2], depth: Span) -> Span {
        match self {
            #[cfg(feature = "scene")]
            Self::Seen(_) if depth.low < depth.high && depth.high.is_infinite() => Span::unclear(0.0, f64::INFINITY),
            #[cfg(feature = "scene")]
            Self::Seen(eye) if depth.low < depth.high => {
                // Along a ray, the footprint grows with the depth, up to the rounding of the point's coordinates.
                let [near, far] = [depth.low, depth.high].map(|depth| depth.max(0.0));
                let slack = (1e-12 * (1.0 + eye.position.length() / near)).min(1.0);
                let (low, high) = (self.at(pixels, near) * (1.0 - slack), self.at(pixels, far) * (1.0 + slack));
                Span { low, high, clear: depth.clear }
            }
            _ => Span::exactly(self.at(pixels, depth.low)).with(depth.clear),
        }
    }
}

/// Number of points on surfaces whose noise is computed at once.
const AT_ONCE: usize = 256;

/// Points on surfaces: indices in planes, and positions in pixels.
struct Points {
    count: usize,
    indices: [usize; AT_ONCE],
    pixels: [[f64; 2]; AT_ONCE],
}

impl PreparedNoise {
    /// Fills the noise at the positions in the given channels of the view; 0 where no surface is seen.
    fn on<const S: usize>(&self, block: &Block<'_>, inputs: &Inputs<'_>, channels: [Channel; S], out: &mut [f32]) {
        let depths = inputs.view_if_any(&self.node.view, Channel::Depth);
        let coverage = inputs.view(&self.node.view, Channel::Coverage);
        let planes = channels.map(|channel| inputs.view(&self.node.view, channel));
        let place = |index: usize| std::array::from_fn(|axis| f64::from(planes[axis][index]) - self.moved(axis));
        out.fill(0.0);
        // Points on surfaces lie side by side, however few of them there are.
        let mut points = Points { count: 0, indices: [0; AT_ONCE], pixels: [[0.0; 2]; AT_ONCE] };
        let [mut ahead, mut prints, mut values] = [[0.0; AT_ONCE]; 3];
        let mut fill = |points: &mut Points| {
            let count = std::mem::take(&mut points.count);
            let (indices, values) = (&points.indices[..count], &mut values[..count]);
            if let Some(depths) = depths {
                ahead.iter_mut().zip(indices).for_each(|(ahead, index)| *ahead = depths[*index]);
                self.footprints.fill(&points.pixels[..count], &ahead[..count], &mut prints[..count]);
            }
            self.octaves.fill::<S>(indices.iter().map(|index| place(*index)), &prints[..count], values);
            for (index, value) in indices.iter().zip(values) {
                out[*index] = *value;
            }
        };
        // From within, which is faster than to ask for one place after another.
        block.places().enumerate().for_each(|(index, at)| {
            if coverage[index] != 0.0 {
                (points.indices[points.count], points.pixels[points.count]) = (index, at);
                points.count += 1;
                if points.count == AT_ONCE {
                    fill(&mut points);
                }
            }
        });
        fill(&mut points);
    }

    /// Returns the offset along an axis of the space. In rest space, the second axis is z.
    fn moved(&self, axis: usize) -> f64 {
        let is_z = self.node.space == Space::Rest && axis == 1;
        self.node.offset[if is_z { 2 } else { axis }]
    }
}

impl Prepared for PreparedNoise {
    fn fill(&self, block: &Block<'_>, inputs: &Inputs<'_>, outputs: &mut Outputs<'_>) -> Result<(), NodeError> {
        let Some(out) = outputs.only(0) else { return Ok(()) };
        match self.node.space {
            Space::World => self.on(block, inputs, WORLD, out),
            Space::Rest => self.on(block, inputs, REST, out),
            Space::Screen => {
                let moved = [self.moved(0), self.moved(1)];
                let prints = |count: usize| match self.footprints {
                    Footprints::Even(size) => Scratch::of(size as f32, count),
                    _ => Scratch::new(),
                };
                if block.scattered.is_some() {
                    let place = |pixels: [f64; 2]| {
                        let [x, y] = self.screen.at(pixels);
                        [x - moved[0], y - moved[1]]
                    };
                    self.octaves.fill::<2>(block.places().map(place), &prints(out.len()), out);
                    return Ok(());
                }
                // Divisions once for each column and row.
                let Window { x0, x1, y0, y1 } = block.window;
                let mut across = self.screen.columns(x0..x1, block.offset[0]);
                across.iter_mut().for_each(|across| *across -= moved[0]);
                let prints = prints(across.len());
                for (y, out) in (y0..y1).zip(out.chunks_mut(across.len().max(1))) {
                    let down = self.screen.row(y, block.offset[1]) - moved[1];
                    self.octaves.fill::<2>(across.iter().map(|across| [*across, down]), &prints, out);
                }
            }
        }
        Ok(())
    }

    fn bound(&self, bounding: &Bounding<'_>, outputs: &mut Outputs<'_>) -> Result<(), NoBound> {
        let (view, channels) = (&self.node.view, self.node.space.channels());
        let mut places = bounding.block.places();
        let [coverage, depths] = [Channel::Coverage, Channel::Depth].map(|channel| bounding.channel(view, channel));
        let axes: Vec<_> = channels.iter().map(|channel| bounding.channel(view, *channel)).collect();
        bounding.bound_by(outputs, SoleOutput, 0, |sample| {
            let at = places.next().unwrap_or_default();
            // All axes of the space, and others behind them.
            let place = |along: [Span; 3]| {
                [0, 1, 2].map(|axis| {
                    let by = self.moved(axis);
                    Span { low: along[axis].low - by, high: along[axis].high - by, ..along[axis] }
                })
            };
            if channels.is_empty() {
                let [x, y] = self.screen.at(at).map(Span::exactly);
                let place = place([x, y, y]);
                return self.octaves.span(&place[..2], self.footprints.span(at, Span::exactly(0.0)));
            }
            coverage.covered(sample, || {
                let mut along = [Span::exactly(0.0); 3];
                for (along, axis) in along.iter_mut().zip(&axes) {
                    *along = axis.at(sample);
                }
                self.octaves.span(&place(along)[..channels.len()], self.footprints.span(at, depths.at(sample)))
            })
        });
        Ok(())
    }

    fn reference(&self, inputs: &References<'_>) -> Result<Vec<Reference>, NodeError> {
        let channels = self.node.space.channels();
        let view = if channels.is_empty() { None } else { self.node.view.as_ref() };
        let mut place: Vec<f64> = match view {
            None => self.screen.at(inputs.at).to_vec(),
            Some(view) if inputs.view(view, Channel::Coverage) == 0.0 => {
                return Ok(vec![Reference::Field(vec![0.0])]);
            }
            Some(view) => channels.iter().map(|channel| inputs.view(view, *channel)).collect(),
        };
        let depth = view.map_or(0.0, |view| inputs.view(view, Channel::Depth));
        let footprint = self.footprints.at(inputs.at, depth);
        place.iter_mut().enumerate().for_each(|(axis, along)| *along -= self.moved(axis));
        Ok(vec![Reference::Field(vec![self.octaves.reference(&place, footprint)])])
    }
}
