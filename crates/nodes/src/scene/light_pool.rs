//! LightPool: sun that falls through gaps of the clouds.

use crate::front_support::{Span, bound_by, certain, known, where_covered};
use crate::scene_support::{POSITION, is_covered, nothing, uncover, view_planes, view_vector};
use trochoid_graph::*;
use trochoid_scene::{DVec3, Light};

pub(crate) static NODE: &dyn NodeType = &LightPool;

struct LightPool;

static DECLARATION: Declaration = Declaration {
    name: "LightPool",
    end: End::Front,
    summary: "A mask of pools of light in the world, as sun makes that falls through gaps of the clouds.",
    formula: "s = Σ strengthᵢ·exp(−(a/length)² − (b/width)²) + ragged·noise, a and b the horizontal distances from \
              the pool's center along and across its direction; t = (s − from)/(to − from) limited to [0, 1]; t²(3 − \
              2t). With a `light` each point counts where its ray of light meets the height 0.",
    edge_cases: "0 where nothing is seen. Without pools the noise alone has gaps. A light that comes from the horizon \
                 or below, or has a place, moves nothing. `from` = `to` is a hard edge.",
    source: "Gaussian spots, broken by noise: how marine painters lead the eye.",
    items: &[
        Port::one("view", Accepts::View, "What light falls on."),
        Port::optional("noise", Accepts::Scalar, "Breaks the edges: a Noise in world space, say."),
        Port::optional("light", Accepts::Light, "Whence it comes: crests then reach out of a pool, toward the light."),
        List::of(
            "pools",
            &[
                Knob::number("x", 0.0, -1e7, 1e7, "Where the center lies along x.").unit("m").item(),
                Knob::number("z", 0.0, -1e7, 1e7, "Where the center lies along z.").unit("m").item(),
                Knob::number("length", 10.0, 1e-3, 1e7, "Half its length, where e⁻¹ of the light is left.")
                    .unit("m")
                    .item(),
                Knob::number("width", 10.0, 1e-3, 1e7, "Half its width.").unit("m").item(),
                Knob::number("direction", 0.0, -360.0, 360.0, "Where the length points: 0 is +X, 90 is +Z.")
                    .unit("degrees")
                    .item(),
                Knob::number("strength", 1.0, 0.0, 1e3, "How much light in its center.").item(),
            ],
            0,
            64,
            "The pools.",
        ),
        Knob::number("ragged", 0.2, -1e3, 1e3, "How much of the noise is added.").item(),
        Knob::number("from", 0.05, -1e3, 1e3, "Light at which the mask begins.").item(),
        Knob::number("to", 0.7, -1e3, 1e3, "Light at which it is 1.").item(),
    ],
    outputs: &[Output::new("mask", Kind::MASK, "The light.")],
    revision: 1,
};

impl NodeType for LightPool {
    fn declaration(&self) -> &'static Declaration {
        &DECLARATION
    }

    fn check(&self, node: &Settled, check: &mut Check<'_>) {
        if node.number("to") < node.number("from") {
            let found = format!("{} below from, {}", node.number("to"), node.number("from"));
            check.error("to", found, "at least as much", "swap them, and Invert the mask");
        }
        if node.list("pools").is_empty() && node.all("noise").is_empty() {
            let found = "no pools and no noise: the light is the same everywhere";
            check.warning("pools", found, "pools, or a noise that has gaps", "give \"pools\", or connect \"noise\"");
        }
    }

    fn body(&self) -> Body<'_> {
        Body::Stage(self)
    }
}

impl Stage for LightPool {
    fn asks(&self, _node: &Settled, _wanted: &[bool]) -> ChannelSet {
        ChannelSet::of(&POSITION).union(Channel::Coverage.into())
    }

    fn interval(&self, _node: &Settled, _output: usize, _channel: usize) -> Option<(f64, f64)> {
        Some((0.0, 1.0))
    }

    fn formatted(&self) -> bool {
        false
    }

    fn rate(&self, _node: &Settled) -> Rate {
        Rate::Surface
    }

    fn prepare(&self, node: &Settled, prepare: &Prepare<'_>) -> Result<Box<dyn Prepared>, NodeError> {
        let pool = |pool: &Settled| {
            let (sin, cos) = libm::sincos(pool.number("direction").to_radians());
            Pool {
                center: ["x", "z"].map(|knob| pool.number(knob)),
                along: [cos, sin],
                size: ["length", "width"].map(|knob| pool.number(knob)),
                strength: pool.number("strength"),
            }
        };
        let lights: Vec<Light> = prepare.handles(node, "light")?;
        Ok(Box::new(Falling {
            node: node.clone(),
            pools: node.list("pools").iter().map(pool).collect(),
            slant: lights.first().map_or([0.0; 2], slant),
            ragged: node.number("ragged"),
            from: node.number("from"),
            to: node.number("to"),
        }))
    }
}

/// How far light moves along x and z with each meter up.
fn slant(light: &Light) -> [f64; 2] {
    let toward = light.illuminate(DVec3::ZERO).direction;
    match light {
        Light::Directional { .. } if toward.y > 1e-3 => [toward.x / toward.y, toward.z / toward.y],
        _ => [0.0; 2],
    }
}

struct Pool {
    center: [f64; 2],
    /// Unit vector of its length.
    along: [f64; 2],
    size: [f64; 2],
    strength: f64,
}

struct Falling {
    node: Settled,
    pools: Vec<Pool>,
    slant: [f64; 2],
    ragged: f64,
    from: f64,
    to: f64,
}

/// What rounding loses of a sum, for a unit of what is added.
const LOST: f64 = 1e-14;

/// The largest of three numbers' sizes.
fn size(numbers: [f64; 3]) -> f64 {
    numbers.into_iter().fold(0.0, |most, number| most.max(number.abs()))
}

/// Gaussians of more than this power are nothing.
const NOTHING: f64 = 40.0;

impl Falling {
    fn mask(&self, point: DVec3, noise: f64) -> f64 {
        let light = |pool: &Pool| {
            let [a, b] = self.across(pool, point);
            let power = a * a + b * b;
            if power < NOTHING { pool.strength * libm::exp(-power) } else { 0.0 }
        };
        let sum = self.pools.iter().map(light).sum::<f64>() + self.ragged * noise;
        self.brightness(sum)
    }

    /// The mask of a sum of light.
    fn brightness(&self, sum: f64) -> f64 {
        let t = crate::scene_support::ramp(sum, self.from, self.to - self.from);
        t * t * (3.0 - 2.0 * t)
    }

    /// What the mask may be, where a point and the noise may lie anywhere in spans.
    fn span(&self, point: [Span; 3], noise: Span) -> Span {
        let (middle, half) = (point.map(Span::middle), point.map(Span::half));
        let reach = |axis: usize, along: usize| {
            let lost = LOST * (1.0 + self.slant[axis].abs()) * size(middle);
            half[along] + self.slant[axis].abs() * half[1] + if size(half) > 0.0 { lost } else { 0.0 }
        };
        let (dx, dz) = (reach(0, 0), reach(1, 2));
        let (mut low, mut high) = (self.ragged * noise.low, self.ragged * noise.high);
        (low, high) = (low.min(high), low.max(high));
        if low.is_nan() || high.is_nan() || !(dx + dz).is_finite() {
            return Span::unclear(0.0, 1.0);
        }
        for pool in &self.pools {
            let [cos, sin] = pool.along.map(f64::abs);
            let [a, b] = self.across(pool, DVec3::from(middle));
            let away = [(a, (dx * cos + dz * sin) / pool.size[0]), (b, (dz * cos + dx * sin) / pool.size[1])];
            let square = |v: f64| v * v;
            let power =
                |end: fn(f64, f64) -> f64| away.map(|(at, by)| square(end(at.abs(), by).max(0.0))).iter().sum::<f64>();
            let light = |power: f64| if power < NOTHING { pool.strength * libm::exp(-power) } else { 0.0 };
            low += light(power(|at, by| at + by));
            high += light(power(|at, by| at - by));
        }
        // What is nothing of pools, and what sums lose.
        let strength = self.pools.iter().map(|pool| pool.strength).sum::<f64>();
        let sum = Span { low, high, clear: true }.wider(LOST * (strength + (self.ragged * noise.high).abs()));
        let ends = [sum.low, sum.high].map(|sum| self.brightness(sum));
        let clear = noise.clear && point.iter().all(|along| along.clear);
        let mask = Span::of(&ends).wider(LOST).within(0.0, 1.0);
        mask.with(clear && (self.to > self.from || ends[0] == ends[1]))
    }

    /// How far a point lies from a pool's center along and across it, in halves of its size.
    fn across(&self, pool: &Pool, point: DVec3) -> [f64; 2] {
        let place = [point.x - self.slant[0] * point.y, point.z - self.slant[1] * point.y];
        let [dx, dz] = [place[0] - pool.center[0], place[1] - pool.center[1]];
        let [cos, sin] = pool.along;
        [(dx * cos + dz * sin) / pool.size[0], (dz * cos - dx * sin) / pool.size[1]]
    }
}

impl Prepared for Falling {
    fn fill(&self, _block: &Block<'_>, inputs: &Inputs<'_>, outputs: &mut Outputs<'_>) -> Result<(), NodeError> {
        let Some(mask) = outputs.take(0, 0) else { return Ok(()) };
        let planes = view_planes(inputs, POSITION);
        let noise = inputs.all("noise").first().and_then(|connection| connection.planes[0]);
        for (index, out) in mask.iter_mut().enumerate() {
            let point = DVec3::from(planes.map(|plane| f64::from(plane[index])));
            *out = self.mask(point, noise.map_or(0.0, |noise| f64::from(noise[index]))) as f32;
        }
        uncover(inputs, mask);
        Ok(())
    }

    fn bound(&self, bounding: &Bounding<'_>, outputs: &mut Outputs<'_>) -> Result<(), NoBound> {
        bound_by(bounding, outputs, (0, 0), |sample| {
            where_covered(bounding, sample, || {
                let point = POSITION.map(|channel| certain(bounding, channel, sample));
                self.span(point, known(bounding, "noise", 0, sample).unwrap_or(Span::exactly(0.0)))
            })
        });
        Ok(())
    }

    fn reference(&self, inputs: &References<'_>) -> Result<Vec<Reference>, NodeError> {
        if !is_covered(&self.node, inputs) {
            return Ok(nothing());
        }
        let noise = self.node.all("noise").first().map_or(0.0, |source| inputs.scalar(source));
        Ok(vec![Reference::Mask(self.mask(view_vector(&self.node, inputs, POSITION), noise))])
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::testing::refused;

    fn falling(slant: [f64; 2]) -> Falling {
        let frame = crate::testing::frame("field", r#""out": { "type": "ScreenX" }"#);
        let node = frame.graph.settle(frame.graph.find("out").unwrap(), 1);
        let pool = Pool { center: [10.0, -5.0], along: [0.6, 0.8], size: [20.0, 5.0], strength: 1.0 };
        Falling { node, pools: vec![pool], slant, ragged: 0.5, from: 0.0, to: 1.0 }
    }

    #[test]
    fn a_pool_is_brightest_in_its_center_and_as_long_as_it_says() {
        let pool = falling([0.0; 2]);
        let at = |x: f64, z: f64| pool.mask(DVec3::new(x, 3.0, z), 0.0);
        assert_eq!(at(10.0, -5.0), 1.0);
        let smooth = |t: f64| t * t * (3.0 - 2.0 * t);
        let edge = smooth(libm::exp(-1.0));
        for side in [-1.0, 1.0] {
            let along = at(10.0 + side * 20.0 * 0.6, -5.0 + side * 20.0 * 0.8);
            let across = at(10.0 - side * 5.0 * 0.8, -5.0 + side * 5.0 * 0.6);
            assert!((along - edge).abs() < 1e-12 && (across - edge).abs() < 1e-12, "{along}, {across}, {edge}");
        }
        assert_eq!(at(1e9, 0.0), 0.0);
        assert!(pool.mask(DVec3::new(10.0, 0.0, -5.0), -1.0) < 0.6, "noise takes from it");
    }

    #[test]
    fn slanting_light_meets_crests_beside_the_pool() {
        let pool = falling([2.0, 0.0]);
        // Two meters up, the light comes from four meters along x.
        assert_eq!(pool.mask(DVec3::new(14.0, 2.0, -5.0), 0.0), 1.0);
        assert_eq!(slant(&Light::Directional { direction: DVec3::new(1.0, 0.5, 0.0) })[0], 2.0);
        assert_eq!(slant(&Light::Directional { direction: DVec3::new(1.0, -0.5, 0.0) }), [0.0; 2]);
    }

    #[test]
    fn edges_run_upward() {
        let nodes = r#""camera": { "type": "Camera" }, "sea": { "type": "GerstnerSea", "count": 0 },
            "view": { "type": "Render", "camera": "camera", "surfaces": ["sea"] },
            "out": { "type": "LightPool", "view": "view", "from": 0.5, "to": 0.25 }"#;
        assert!(refused("weights", nodes).contains("0.25 below from"));
    }
}
