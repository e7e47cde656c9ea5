//! Noise: procedural variation that stays where it is put.

use crate::field::Screen;
use trochoid_field::{Axes, Noise as Octaves, NoiseKind};
use trochoid_graph::*;

/// Makes procedural noise: on the picture, in the world, or on the water as it moves.
///
/// # Formula
/// Σ gⁱ·nᵢ / Σ gⁱ over `octaves`, g = `gain`, where `filter` is on each nᵢ drawn to its mean as the pixel's footprint
/// grows from half a cell to one; cells of octave i measure scale/lacunarityⁱ. fbm: nᵢ is gradient noise n in [−1, 1];
/// ridged: (1 − |n|)², in [0, 1]; cellular: min(F₁, 1), edges: min(F₂, 1) − min(F₁, 1), both in [0, 1], with the
/// distances F₁ ≤ F₂ in cells to the nearest feature points.
///
/// # Edge cases
/// In world and rest space 0 where nothing is seen. Screen coordinates run right and down from the upper left corner in
/// picture heights, so that noise does not change with the picture's size. A view without camera or depth has no
/// footprints, and is not filtered. Positions come in 32 bits: far from the origin cells finer than that are lost, but
/// the noise itself is not. Random numbers come of integers, alike on every machine.
///
/// # Source
/// Perlin, Improving Noise, 2002; Musgrave, Kolb and Mace, The Synthesis and Rendering of Eroded Fractal Terrains,
/// 1989; Worley, A Cellular Texture Basis Function, 1996.
#[derive(Clone, Node)]
#[node(end = Front, revision = 2, output(noise: Kind::Field(1) = "fbm in [−1, 1], all else in [0, 1]."))]
#[also_called("Perlin", "Fractal", "Turbulence", "Voronoi", "Worley", "Cellular", "Fbm")]
pub(crate) struct Noise {
    /// What the noise lies on; for `space` world and rest.
    view: Optional<port::View>,
    /// Clouds, ridges, cells, or borders of cells.
    kind: NoiseKind,
    /// Where it stays: on the picture, at the point in the world, or at the water's point at rest, with which it moves.
    space: Space,
    /// Size of the largest cells: in meters, in screen space in picture heights.
    #[knob(default = 1.0, range = 1e-3..=1e7)]
    scale: f64,
    /// Moves the noise, in the unit of `scale`; in screen space right and down, in rest space along x and z.
    #[knob(default = [0.0, 0.0, 0.0])]
    offset: [f64; 3],
    /// How many sizes of cells.
    #[knob(default = 4, range = 1..=16)]
    octaves: i64,
    /// By what factor the cells of an octave are smaller.
    #[knob(default = 2.0, range = 1.0..=8.0)]
    lacunarity: f64,
    /// By what factor an octave is weaker.
    #[knob(default = 0.5, range = 0.0..=1.0)]
    gain: f64,
    /// Place along one more axis, in cells. Key it, and the noise changes where it stands; 1 cell changes it entirely.
    #[knob(range = -1e9..=1e9)]
    evolution: Option<f64>,
    /// Takes out cells that are smaller than what a pixel covers, which would flicker.
    #[knob(default = true)]
    filter: bool,
    /// Which noise of all that have these figures.
    #[knob(default = 0, range = 0..=1_000_000_000)]
    seed: i64,
}

/// Where noise stays.
#[derive(Clone, Copy, Debug, PartialEq, Choice)]
pub(crate) enum Space {
    Screen,
    World,
    Rest,
}

const REST: [Channel; 2] = [Channel::RestX, Channel::RestZ];
const WORLD: [Channel; 3] = [Channel::PositionX, Channel::PositionY, Channel::PositionZ];

impl Space {
    /// The channels that give the place in it; none for the screen.
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

    fn body(&self) -> Body<'_> {
        Body::Stage(self)
    }
}

impl Stage for Noise {
    fn asks(&self, _wanted: &[bool]) -> ChannelSet {
        match self.space.channels() {
            [] => ChannelSet::EMPTY,
            channels => ChannelSet::of(channels).union(Channel::Coverage.into()),
        }
    }

    fn prefers(&self, _wanted: &[bool]) -> ChannelSet {
        // With the ray, the depth says where the point stands, in rest space too.
        if self.filter && self.space != Space::Screen { Channel::Depth.into() } else { ChannelSet::EMPTY }
    }

    fn interval(&self, _output: usize, _channel: usize) -> Option<(f64, f64)> {
        Some(self.kind.range())
    }

    fn rate(&self) -> Rate {
        Rate::Surface
    }

    fn prepare(&self, prepare: &Prepare<'_>) -> Result<Box<dyn Prepared>, NodeError> {
        let axes = Axes {
            scale: self.scale,
            octaves: self.octaves as usize,
            lacunarity: self.lacunarity,
            gain: self.gain,
            seed: self.seed as u32,
        };
        Ok(Box::new(PreparedNoise {
            node: self.clone(),
            octaves: Octaves::new(self.kind, axes, self.evolution),
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

/// What a sample stands for, in the unit of its place.
enum Footprints {
    /// Nothing is filtered.
    None,
    /// Everywhere the same: a pixel.
    Even(f64),
    /// What a pixel covers of the surface.
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

    /// Of the sample at a place in pixels that sees something at a depth.
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

    /// What it may be where the depth is only known to lie in a span.
    fn span(&self, pixels: [f64; 2], depth: Span) -> Span {
        match self {
            #[cfg(feature = "scene")]
            Self::Seen(_) if depth.low < depth.high && depth.high.is_infinite() => Span::unclear(0.0, f64::INFINITY),
            #[cfg(feature = "scene")]
            Self::Seen(eye) if depth.low < depth.high => {
                // Along a ray it grows with the depth, as far as the point's coordinates tell depths apart.
                let [near, far] = [depth.low, depth.high].map(|depth| depth.max(0.0));
                let slack = (1e-12 * (1.0 + eye.position.length() / near)).min(1.0);
                let (low, high) = (self.at(pixels, near) * (1.0 - slack), self.at(pixels, far) * (1.0 + slack));
                Span { low, high, clear: depth.clear }
            }
            _ => Span::exactly(self.at(pixels, depth.low)).with(depth.clear),
        }
    }

    /// Of a block of samples; empty where all are 0.
    #[cfg_attr(not(feature = "scene"), allow(unused_variables, reason = "only views have depths"))]
    fn over(&self, block: &Block<'_>, depths: Option<&[f32]>) -> Vec<f32> {
        match (self, depths) {
            (Self::None, _) => Vec::new(),
            (Self::Even(size), _) => vec![*size as f32; block.window.area()],
            #[cfg(feature = "scene")]
            (Self::Seen(_), None) => Vec::new(),
            #[cfg(feature = "scene")]
            (Self::Seen(_), Some(depths)) => {
                block.places().zip(depths).map(|(place, depth)| self.at(place, f64::from(*depth)) as f32).collect()
            }
        }
    }
}

impl PreparedNoise {
    /// Fills the noise at the places that some channels of the view give.
    fn on<const S: usize>(&self, block: &Block<'_>, inputs: &Inputs<'_>, channels: [Channel; S], out: &mut [f32]) {
        let footprints = self.footprints.over(block, inputs.view_if_any(&self.node.view, Channel::Depth));
        let planes = channels.map(|channel| inputs.view(&self.node.view, channel));
        let place = |index: usize| std::array::from_fn(|axis| f64::from(planes[axis][index]) - self.moved(axis));
        self.octaves.fill::<S>((0..out.len()).map(place), &footprints, out);
        for (out, coverage) in out.iter_mut().zip(inputs.view(&self.node.view, Channel::Coverage)) {
            if *coverage == 0.0 {
                *out = 0.0;
            }
        }
    }

    /// How far the noise is moved along an axis: at rest the second one is z.
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
                let place = |pixels: [f64; 2]| {
                    let [x, y] = self.screen.at(pixels);
                    [x - self.moved(0), y - self.moved(1)]
                };
                self.octaves.fill::<2>(block.places().map(place), &self.footprints.over(block, None), out);
            }
        }
        Ok(())
    }

    fn bound(&self, bounding: &Bounding<'_>, outputs: &mut Outputs<'_>) -> Result<(), NoBound> {
        let (view, channels) = (&self.node.view, self.node.space.channels());
        let mut places = bounding.block.places();
        bounding.bound_by(outputs, (Only, 0), |sample| {
            let at = places.next().unwrap_or_default();
            let moved = |(axis, along): (usize, Span)| {
                let by = self.moved(axis);
                Span { low: along.low - by, high: along.high - by, ..along }
            };
            if channels.is_empty() {
                let place: Vec<Span> =
                    self.screen.at(at).map(Span::exactly).into_iter().enumerate().map(moved).collect();
                return self.octaves.span(&place, self.footprints.span(at, Span::exactly(0.0)));
            }
            bounding.where_covered(view, sample, || {
                let along = channels.iter().map(|channel| bounding.certain(view, *channel, sample));
                let place: Vec<Span> = along.enumerate().map(moved).collect();
                let depth = bounding.certain(view, Channel::Depth, sample);
                self.octaves.span(&place, self.footprints.span(at, depth))
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

#[cfg(test)]
mod tests {
    use crate::testing::{frame, refused};

    #[test]
    fn follows_its_offset_and_agrees_with_the_reference() {
        for kind in ["fbm", "ridged", "cellular", "edges"] {
            for offset in ["[0, 0, 0]", "[1e7, -3e6, 5]"] {
                let nodes = format!(
                    r#""out": {{ "type": "Noise", "kind": "{kind}", "scale": 0.31, "offset": {offset}, "seed": 5 }}"#
                );
                let frame = frame("field", &nodes);
                let id = frame.graph.find("out").unwrap();
                for (x, y) in (0..12).flat_map(|y| (0..16).map(move |x| (x, y))) {
                    let at = [f64::from(x) / 4.0 + 0.125, f64::from(y) / 4.0 + 0.125];
                    let (found, truth) = (frame.filled(id, 0, 0, at), frame.truth(at)[0]);
                    assert!((f64::from(found) - truth).abs() < 3e-6, "{kind} at {at:?}: {found}, expected {truth}");
                }
            }
        }
    }

    #[test]
    fn needs_a_view_off_the_screen() {
        let faults = refused("field", r#""out": { "type": "Noise", "space": "rest" }"#);
        assert!(faults.contains("rest without a view"), "{faults}");
    }
}
