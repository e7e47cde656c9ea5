//! Noise: procedural variation that stays where it is put.

use crate::front_support::{
    Axes, Noise as Octaves, NoiseKind, Screen, Span, bound_by, certain, noise_reference, noise_span, where_covered,
};
use trochoid_graph::*;

pub(crate) static NODE: &dyn NodeType = &Noise;

struct Noise;

static DECLARATION: Declaration = Declaration {
    name: "Noise",
    end: End::Front,
    summary: "Makes procedural noise: on the picture, in the world, or on the water as it moves.",
    formula: "Σ gⁱ·nᵢ / Σ gⁱ over `octaves`, g = `gain`, where `filter` is on each nᵢ drawn to its mean as the pixel's \
              footprint grows from half a cell to one; cells of octave i measure scale/lacunarityⁱ. fbm: nᵢ is \
              gradient noise n in [−1, 1]; ridged: (1 − |n|)², in [0, 1]; cellular: min(F₁, 1), edges: min(F₂, 1) − \
              min(F₁, 1), both in [0, 1], with the distances F₁ ≤ F₂ in cells to the nearest feature points.",
    edge_cases: "In world and rest space 0 where nothing is seen. Screen coordinates run right and down from the \
                 upper left corner in picture heights, so that noise does not change with the picture's size. A view \
                 without camera or depth has no footprints, and is not filtered. Positions come in 32 bits: far from \
                 the origin cells finer than that are lost, but the noise itself is not. Random numbers come of \
                 integers, alike on every machine.",
    source: "Perlin, Improving Noise, 2002; Musgrave, Kolb and Mace, The Synthesis and Rendering of Eroded Fractal \
             Terrains, 1989; Worley, A Cellular Texture Basis Function, 1996.",
    items: &[
        Port::optional("view", Accepts::View, "What the noise lies on; for `space` world and rest."),
        Knob::choice("kind", &["fbm", "ridged", "cellular", "edges"], "Clouds, ridges, cells, or borders of cells.")
            .item(),
        Knob::choice(
            "space",
            &["screen", "world", "rest"],
            "Where it stays: on the picture, at the point in the \
                     world, or at the water's point at rest, with which it moves.",
        )
        .item(),
        Knob::number(
            "scale",
            1.0,
            1e-3,
            1e7,
            "Size of the largest cells: in meters, in screen space in picture heights.",
        )
        .item(),
        Knob::vector(
            "offset",
            &[0.0, 0.0, 0.0],
            "Moves the noise, in the unit of `scale`; in screen space right and \
                     down, in rest space along x and z.",
        )
        .item(),
        Knob::integer("octaves", 4, 1, 16, "How many sizes of cells.").item(),
        Knob::number("lacunarity", 2.0, 1.0, 8.0, "By what factor the cells of an octave are smaller.").item(),
        Knob::number("gain", 0.5, 0.0, 1.0, "By what factor an octave is weaker.").item(),
        Knob::number(
            "evolution",
            0.0,
            -1e9,
            1e9,
            "Place along one more axis, in cells. Key it, and the noise changes \
                     where it stands; 1 cell changes it entirely.",
        )
        .optional()
        .item(),
        Knob::bool("filter", true, "Takes out cells that are smaller than what a pixel covers, which would flicker.")
            .item(),
        Knob::integer("seed", 0, 0, 1_000_000_000, "Which noise of all that have these figures.").item(),
    ],
    outputs: &[Output::new("noise", Kind::Field(1), "fbm in [−1, 1], all else in [0, 1].")],
    revision: 2,
};

const REST: [Channel; 2] = [Channel::RestX, Channel::RestZ];
const WORLD: [Channel; 3] = [Channel::PositionX, Channel::PositionY, Channel::PositionZ];

fn kind(node: &Settled) -> NoiseKind {
    match node.text("kind") {
        "ridged" => NoiseKind::Ridged,
        "cellular" => NoiseKind::Cellular,
        "edges" => NoiseKind::Edges,
        _ => NoiseKind::Fbm,
    }
}

/// The channels that give the place in its space; none for the screen.
fn channels(node: &Settled) -> &'static [Channel] {
    match node.text("space") {
        "world" => &WORLD,
        "rest" => &REST,
        _ => &[],
    }
}

impl NodeType for Noise {
    fn declaration(&self) -> &'static Declaration {
        &DECLARATION
    }

    fn check(&self, node: &Settled, check: &mut Check<'_>) {
        if !channels(node).is_empty() && node.all("view").is_empty() {
            let found = format!("{} without a view", node.text("space"));
            check.error("space", found, "a view to lie on", "connect \"view\", or use \"screen\"");
        }
    }

    fn body(&self) -> Body<'_> {
        Body::Stage(self)
    }
}

impl Stage for Noise {
    fn asks(&self, node: &Settled, _wanted: &[bool]) -> ChannelSet {
        match channels(node) {
            [] => ChannelSet::EMPTY,
            channels => ChannelSet::of(channels).union(Channel::Coverage.into()),
        }
    }

    fn prefers(&self, node: &Settled, _wanted: &[bool]) -> ChannelSet {
        // With the ray, the depth says where the point stands, in rest space too.
        if node.bool("filter") && !channels(node).is_empty() { Channel::Depth.into() } else { ChannelSet::EMPTY }
    }

    fn interval(&self, node: &Settled, _output: usize, _channel: usize) -> Option<(f64, f64)> {
        Some(kind(node).range())
    }

    fn rate(&self, _node: &Settled) -> Rate {
        Rate::Surface
    }

    fn prepare(&self, node: &Settled, prepare: &Prepare<'_>) -> Result<Box<dyn Prepared>, NodeError> {
        let axes = Axes {
            scale: node.number("scale"),
            octaves: node.integer("octaves") as usize,
            lacunarity: node.number("lacunarity"),
            gain: node.number("gain"),
            seed: node.integer("seed") as u32,
        };
        Ok(Box::new(Noisy {
            node: node.clone(),
            noise: Octaves::new(kind(node), axes, node.is_set("evolution").then(|| node.number("evolution"))),
            offset: node.vector3("offset"),
            screen: Screen::of(prepare.frame.format),
            footprints: Footprints::of(node, prepare),
        }))
    }
}

struct Noisy {
    node: Settled,
    noise: Octaves,
    offset: [f64; 3],
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
    fn of(node: &Settled, prepare: &Prepare<'_>) -> Self {
        if !node.bool("filter") {
            return Self::None;
        }
        if channels(node).is_empty() {
            return Self::Even(1.0 / f64::from(prepare.frame.format.height()));
        }
        #[cfg(feature = "scene")]
        if let Ok(eye) = crate::scene_support::eye(node, prepare, prepare.frame.format) {
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

impl Noisy {
    /// Fills the noise at the places that some channels of the view give.
    fn on<const S: usize>(&self, block: &Block<'_>, inputs: &Inputs<'_>, channels: [Channel; S], out: &mut [f32]) {
        let footprints = self.footprints.over(block, inputs.view_if_any("view", Channel::Depth));
        let planes = channels.map(|channel| inputs.view("view", channel));
        let place = |index: usize| std::array::from_fn(|axis| f64::from(planes[axis][index]) - self.moved(axis, S));
        self.noise.fill::<S>((0..out.len()).map(place), &footprints, out);
        for (out, coverage) in out.iter_mut().zip(inputs.view("view", Channel::Coverage)) {
            if *coverage == 0.0 {
                *out = 0.0;
            }
        }
    }

    /// How far the noise is moved along an axis of so many.
    fn moved(&self, axis: usize, axes: usize) -> f64 {
        let on_the_water = axes == 2 && axis == 1 && !channels(&self.node).is_empty();
        self.offset[if on_the_water { 2 } else { axis }]
    }
}

impl Prepared for Noisy {
    fn fill(&self, block: &Block<'_>, inputs: &Inputs<'_>, outputs: &mut Outputs<'_>) -> Result<(), NodeError> {
        let Some(out) = outputs.take(0, 0) else { return Ok(()) };
        match channels(&self.node).len() {
            3 => self.on(block, inputs, WORLD, out),
            2 => self.on(block, inputs, REST, out),
            _ => {
                let place = |pixels: [f64; 2]| {
                    let [x, y] = self.screen.at(pixels);
                    [x - self.offset[0], y - self.offset[1]]
                };
                self.noise.fill::<2>(block.places().map(place), &self.footprints.over(block, None), out);
            }
        }
        Ok(())
    }

    fn bound(&self, bounding: &Bounding<'_>, outputs: &mut Outputs<'_>) -> Result<(), NoBound> {
        let channels = channels(&self.node);
        let mut places = bounding.block.places();
        bound_by(bounding, outputs, (0, 0), |sample| {
            let at = places.next().unwrap_or_default();
            let moved = |(axis, along): (usize, Span)| {
                let by = self.moved(axis, if channels.is_empty() { 2 } else { channels.len() });
                Span { low: along.low - by, high: along.high - by, ..along }
            };
            if channels.is_empty() {
                let place: Vec<Span> =
                    self.screen.at(at).map(Span::exactly).into_iter().enumerate().map(moved).collect();
                return noise_span(&self.noise, &place, self.footprints.span(at, Span::exactly(0.0)));
            }
            where_covered(bounding, sample, || {
                let along = channels.iter().map(|channel| certain(bounding, *channel, sample));
                let place: Vec<Span> = along.enumerate().map(moved).collect();
                let depth = certain(bounding, Channel::Depth, sample);
                noise_span(&self.noise, &place, self.footprints.span(at, depth))
            })
        });
        Ok(())
    }

    fn reference(&self, inputs: &References<'_>) -> Result<Vec<Reference>, NodeError> {
        let mut place: Vec<f64> = match channels(&self.node) {
            [] => self.screen.at(inputs.at).to_vec(),
            channels => {
                let view = self.node.source("view");
                if inputs.view(view, Channel::Coverage) == 0.0 {
                    return Ok(vec![Reference::Field(vec![0.0])]);
                }
                channels.iter().map(|channel| inputs.view(view, *channel)).collect()
            }
        };
        let depth = match self.node.all("view").first() {
            Some(view) if !channels(&self.node).is_empty() => inputs.view(view, Channel::Depth),
            _ => 0.0,
        };
        let footprint = self.footprints.at(inputs.at, depth);
        let axes = place.len();
        place.iter_mut().enumerate().for_each(|(axis, along)| *along -= self.moved(axis, axes));
        Ok(vec![Reference::Field(vec![noise_reference(&self.noise, &place, footprint)])])
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
