//! Spray: drops that breaking crests and bursts throw into the air.

use crate::front_support::{Span, bound_by, certain};
use crate::scene_support::{SurfaceHandle, can_break, eye};
use std::sync::{Arc, OnceLock};
use trochoid_graph::*;
use trochoid_scene::Projector;
use trochoid_scene::spray::{Brush, Dabs, Planes, Sprayed, Stamp};
use trochoid_sea::spray::{Burst, MAX_DROPS, Spray as Drops, SprayError, SprayRun, reference};

pub(crate) static NODE: &dyn NodeType = &Spray;

struct Spray;

static DECLARATION: Declaration = Declaration {
    name: "Spray",
    end: End::Front,
    summary: "Drops that breaking crests and directed bursts throw into the air, as stamps of a brush.",
    formula: "Per m² and s `density`·clamp((threshold − det J)/width, 0, 1) drops are born, fewer between tufts. \
              v' = −g·ŷ + drag·(radius/r)(wind − v). alpha = 1 − Π(1 − αᵢ), αᵢ = opacity·(1 − age)·stamp·seen, \
              seen = clamp((d − dᵢ)/soft + ½, 0, 1), d, dᵢ: depths of view and drop.",
    edge_cases: "Cells and steps of births are fixed in world and time: drops do not depend on the picture's size, nor a \
                 frame on those before. Knobs, and the sea's own, hold for all drops that a frame shows. Only a GerstnerSea \
                 folds; over other surfaces, or none, bursts alone throw. Drops sink at the sea's level. Without drops: \
                 alpha 0, depth +∞, age 0.",
    source: "Thesis 3.2.4.5: particles, each with one of several modelled strokes. Peachey, Modeling Waves and Surf, 1986.",
    items: &[
        Port::one("view", Accepts::View, "What hides drops, and whose camera sees them."),
        Port::optional("sea", Accepts::Surface, "The GerstnerSea whose crests break."),
        Knob::vector("center", &[0.0, 0.0], "Middle x, z of the region in which crests throw drops.").unit("m").item(),
        Knob::vector("size", &[60.0, 60.0], "The region's size along x and z.").unit("m").item(),
        Knob::number("cell", 0.5, 1e-3, 1e5, "Side of the world's cells; shorter crests throw nothing.")
            .unit("m")
            .item(),
        Knob::number("rate", 20.0, 1e-2, 1e4, "Steps of births a second.").unit("1/s").item(),
        Knob::number("threshold", 0.4, -1e6, 1e6, "det J below which drops are born.").item(),
        Knob::number("width", 0.2, 0.0, 1e6, "How far below det J must be for the full density.").item(),
        Knob::number("density", 40.0, 0.0, 1e6, "Drops born a square meter and second.").item(),
        Knob::number("follow", 0.8, -1e3, 1e3, "Share of the water's velocity that drops take along.").item(),
        Knob::number("speed", 3.0, 0.0, 1e4, "Greatest speed of the throw.").unit("m/s").item(),
        Knob::number("spread", 35.0, 0.0, 180.0, "Angle from straight up within which is thrown.")
            .unit("degrees")
            .item(),
        Knob::vector("wind", &[4.0, 0.0, 0.0], "Velocity of the wind.").unit("m/s").item(),
        Knob::number("drag", 0.6, 0.0, 1e4, "How fast the largest drops take the wind's velocity.").unit("1/s").item(),
        Knob::number("lifetime", 1.5, 0.0, 1e4, "Longest life of a drop.").unit("s").item(),
        Knob::number("radius", 0.25, 0.0, 1e4, "Radius of the largest drops.").unit("m").item(),
        Knob::number("growth", 1.0, 0.0, 1e3, "By how many times they grow until they are gone.").item(),
        Knob::number("vary", 1.0, 0.0, 1.0, "How much radii, lives and speeds differ.").item(),
        Knob::number("tuft", 3.0, 1e-3, 1e5, "Size of the tufts in which drops gather.").unit("m").item(),
        Knob::number("torn", 0.8, 0.0, 1.0, "How much tufts differ; 1 leaves gaps.").item(),
        Knob::choice("stamp", &["mixed", "disc", "streak", "ragged"], "Mixed: large ones ragged, small ones others.")
            .item(),
        Knob::number("opacity", 0.9, 0.0, 1.0, "Alpha of a stamp's middle at birth.").item(),
        Knob::number("stretch", 0.04, 0.0, 10.0, "Motion by which streaks and ragged stamps are drawn out.")
            .unit("s")
            .item(),
        Knob::number("least", 0.7, 0.1, 100.0, "Least radius of a stamp; thinner drops fade.").drawn().item(),
        Knob::number("soft", 0.3, 0.0, 1e6, "Depth over which a surface swallows a drop.").unit("m").item(),
        Knob::integer("seed", 0, 0, 1_000_000_000, "Which spray of all that have these figures.").item(),
        List::of("bursts", BURST, 0, 1000, "Throws set by hand, such as where a wave meets a rock."),
    ],
    outputs: &[
        Output::new("alpha", Kind::MASK, "What the drops cover."),
        Output::new("depth", Kind::Field(1), "Planar depth of the nearest drop in m; +∞ where there is none."),
        Output::new("age", Kind::MASK, "Mean share of their lives that is over; 0 where there are none."),
    ],
    revision: 1,
};

static BURST: &[Item] = &[
    Knob::vector("position", &[0.0, 0.0, 0.0], "Where it comes from.").unit("m").item(),
    Knob::number("extent", 0.3, 0.0, 1e6, "Radius around it in which drops are born.").unit("m").item(),
    Knob::number("time", 0.0, -1e8, 1e8, "When it begins.").unit("s").item(),
    Knob::number("duration", 0.2, 0.0, 1e6, "How long it lasts.").unit("s").item(),
    Knob::vector("direction", &[0.0, 1.0, 0.0], "Where it throws, any length; 0 is up.").item(),
    Knob::number("spread", 25.0, 0.0, 180.0, "Angle from there within which it throws.").unit("degrees").item(),
    Knob::number("speed", 8.0, 0.0, 1e4, "Greatest speed.").unit("m/s").item(),
    Knob::integer("count", 200, 0, MAX_DROPS as i64, "Number of drops, in some √count jets.").item(),
];

/// The spray that the knobs describe.
fn spray(node: &Settled) -> Result<Drops, SprayError> {
    let plane = |knob: &str| {
        let [x, z, _] = node.vector3(knob);
        [x, z]
    };
    let bursts = node.list("bursts").iter().map(|burst| Burst {
        position: burst.vector3("position"),
        extent: burst.number("extent"),
        time: burst.number("time"),
        duration: burst.number("duration"),
        direction: burst.vector3("direction"),
        spread: burst.number("spread").to_radians(),
        speed: burst.number("speed"),
        count: burst.integer("count") as usize,
    });
    let spray = Drops {
        center: plane("center"),
        size: plane("size"),
        cell: node.number("cell"),
        rate: node.number("rate"),
        threshold: node.number("threshold"),
        width: node.number("width"),
        density: node.number("density"),
        follow: node.number("follow"),
        speed: node.number("speed"),
        cone: node.number("spread").to_radians(),
        wind: node.vector3("wind"),
        drag: node.number("drag"),
        lifetime: node.number("lifetime"),
        radius: node.number("radius"),
        growth: node.number("growth"),
        vary: node.number("vary"),
        tuft: node.number("tuft"),
        torn: node.number("torn"),
        seed: node.integer("seed"),
        bursts: bursts.collect(),
    };
    spray.check().map(|()| spray)
}

fn brush(node: &Settled) -> Brush {
    Brush {
        stamp: match node.text("stamp") {
            "disc" => Stamp::Disc,
            "streak" => Stamp::Streak,
            "ragged" => Stamp::Ragged,
            _ => Stamp::Mixed,
        },
        opacity: node.number("opacity"),
        stretch: node.number("stretch"),
        least: node.number("least"),
        soft: node.number("soft"),
    }
}

impl NodeType for Spray {
    fn declaration(&self) -> &'static Declaration {
        &DECLARATION
    }

    fn check(&self, node: &Settled, check: &mut Check<'_>) {
        if let Err(error) = spray(node) {
            return check.error(error.figure(), error, "a spray within its limits", "change the knobs named");
        }
        if !node.list("bursts").is_empty() {
            return;
        }
        let [x, z, _] = node.vector3("size");
        if x == 0.0 || z == 0.0 {
            let found = format!("a region of {x} × {z} m, in which nothing is thrown, and no bursts");
            check.warning(
                "size",
                found,
                "a region of some size, or bursts",
                "make \"size\" larger, or give \"bursts\"",
            );
        } else if !can_break(node, check, "sea") && (node.all("sea").is_empty() || node.number("threshold") <= 1.0) {
            let found = "a spray without bursts, on nothing that breaks: it throws nothing";
            let remedy = "connect a GerstnerSea to \"sea\", or give \"bursts\"";
            check.warning("sea", found, "the waves of a GerstnerSea, or bursts", remedy);
        }
    }

    fn body(&self) -> Body<'_> {
        Body::Stage(self)
    }
}

impl Stage for Spray {
    fn asks(&self, _node: &Settled, _wanted: &[bool]) -> ChannelSet {
        Channel::Depth.into()
    }

    fn interval(&self, _node: &Settled, output: usize, _channel: usize) -> Option<(f64, f64)> {
        (output != 1).then_some((0.0, 1.0))
    }

    fn rate(&self, node: &Settled) -> Rate {
        // Smaller stamps would slip between pixels, and an edge is one of each sample.
        if node.number("least") >= 0.5 && node.number("soft") > 0.0 { Rate::Surface } else { Rate::Sample }
    }

    fn timed(&self) -> bool {
        true
    }

    fn memory(&self, node: &Settled, reckoning: &Reckoning<'_>) -> MemoryUse {
        // What is born, and the bins of stamps.
        const DROP: f64 = 64.0;
        let Ok(spray) = spray(node) else { return MemoryUse::default() };
        let drops = spray.most_drops() * DROP;
        MemoryUse::held(drops as u64 + reckoning.pixels() * 4, "lower \"density\", \"lifetime\" or \"size\"")
    }

    fn prepare(&self, node: &Settled, prepare: &Prepare<'_>) -> Result<Box<dyn Prepared>, NodeError> {
        let seas: Vec<SurfaceHandle> = prepare.handles(node, "sea")?;
        let spray = spray(node).map_err(NodeError::new)?;
        let sea = seas.first().and_then(|surface| surface.as_sea()).map(|sea| (sea.frame().sea(), sea.level()));
        // Frames share the births that they have in common.
        let run = prepare.shared(&(&spray, &sea), || {
            let spray = spray.clone();
            match sea.clone() {
                Some((sea, level)) => SprayRun::new(spray, sea, level),
                None => SprayRun::bursts(spray),
            }
            .map_err(NodeError::new)
        })?;
        let (time, brush) = (prepare.frame.time, brush(node));
        let projector = eye(node, prepare, prepare.frame.format)?;
        let drops = run.at_unless(time, prepare.cancellation()).map_err(NodeError::new)?;
        let dabs = Dabs::new(&projector, &drops, &brush).map_err(NodeError::new)?;
        let (node, drops, reference) = (node.clone(), drops.len(), OnceLock::new());
        Ok(Box::new(Spraying { node, run, time, projector, brush, drops, dabs, reference }))
    }
}

struct Spraying {
    node: Settled,
    /// Held for the next frame too.
    run: Arc<SprayRun>,
    time: f64,
    projector: Projector,
    brush: Brush,
    /// Number of drops in the air, of which the stamps are those in the picture.
    drops: usize,
    dabs: Dabs,
    /// The stamps of the f64 births, made when a reference is first asked for.
    reference: OnceLock<Option<Dabs>>,
}

impl Spraying {
    /// The stamps of the f64 births, where they are not too many.
    fn truth(&self) -> Option<&Dabs> {
        let made = self.reference.get_or_init(|| {
            let run = &self.run;
            let drops = reference::drops(run.spray(), run.sea(), run.level(), self.time);
            Dabs::new(&self.projector, &drops, &self.brush).ok()
        });
        made.as_ref()
    }
}

/// Sets stamps over a block before surfaces at these depths.
fn paint(dabs: &Dabs, block: &Block<'_>, surface: &[f32], planes: Planes<'_>, stop: &dyn Fn() -> bool) {
    match block.scattered {
        Some(pixels) => dabs.fill_pixels_unless(pixels, block.offset, surface, planes, stop),
        None => dabs.fill_unless(block.window, block.offset, surface, planes, stop),
    }
}

/// The nearest f32 that is not above a number.
fn down(number: f64) -> f32 {
    let near = number as f32;
    if f64::from(near) > number { near.next_down() } else { near }
}

impl Prepared for Spraying {
    fn fill(&self, block: &Block<'_>, inputs: &Inputs<'_>, outputs: &mut Outputs<'_>) -> Result<(), NodeError> {
        let [alpha, depth, age] = [0, 1, 2].map(|output| outputs.take(output, 0));
        let surface = inputs.view("view", Channel::Depth);
        let planes = Planes { alpha, depth, age, weight: None };
        let stop = inputs.cancellation();
        paint(&self.dabs, block, surface, planes, stop);
        inputs.go_on()
    }

    fn bound(&self, bounding: &Bounding<'_>, outputs: &mut Outputs<'_>) -> Result<(), NoBound> {
        // Whether a drop is born at all is drawn against waves, so that no drop's error follows from another figure's.
        let Some(dabs) = self.truth() else { return Err(NoBound("the reference's drops cover too much")) };
        let count = bounding.block.window.area();
        let depths: Vec<Span> = (0..count).map(|sample| certain(bounding, Channel::Depth, sample)).collect();
        // The deeper the surface, the more is seen of each drop.
        let seen = |surface: Vec<f32>| {
            let mut planes = [(); 4].map(|()| vec![0.0; count]);
            let [alpha, depth, age, weight] = planes.each_mut().map(|plane| Some(&mut plane[..]));
            paint(dabs, bounding.block, &surface, Planes { alpha, depth, age, weight }, &|| false);
            planes
        };
        let near = seen(depths.iter().map(|depth| down(depth.low)).collect());
        let far = seen(depths.iter().map(|depth| -down(-depth.high)).collect());
        let rounded = |low: f32, high: f32| {
            // As planes hold what the reference gives.
            let slack = |end: f32| {
                if end.is_finite() { f64::from(end.abs()) * LITERAL + f64::from(f32::from_bits(1)) } else { 0.0 }
            };
            Span { low: f64::from(low) - slack(low), high: f64::from(high) + slack(high), clear: true }
        };
        bound_by(bounding, outputs, (0, 0), |sample| {
            let alpha = rounded(near[0][sample], far[0][sample]).within(0.0, 1.0);
            alpha.with(depths[sample].clear && (self.brush.soft > 0.0 || near[0][sample] == far[0][sample]))
        });
        bound_by(bounding, outputs, (1, 0), |sample| {
            let [nearest, farthest] = [&far, &near].map(|planes| planes[1][sample]);
            rounded(nearest, farthest).with(nearest == farthest)
        });
        bound_by(bounding, outputs, (2, 0), |sample| {
            let is_bare = far[0][sample] == 0.0 && far[1][sample] == f32::INFINITY;
            if is_bare || depths[sample].low == depths[sample].high {
                return rounded(near[2][sample], far[2][sample]).within(0.0, 1.0);
            }
            // Before the nearer surface drops have a mean age; what is seen more of them before the farther one may be of any.
            let [least, most] = [&near, &far].map(|planes| f64::from(planes[3][sample]));
            if least > 0.0 && depths[sample].clear && self.brush.soft > 0.0 {
                let more = (most - least) / most + 2.0 * LITERAL;
                let mean = rounded(near[2][sample], near[2][sample]);
                Span { low: mean.low * (1.0 - more), high: mean.high + more * (1.0 - mean.low), clear: true }
                    .within(0.0, 1.0)
            } else {
                Span::unclear(0.0, 1.0)
            }
        });
        Ok(())
    }

    fn reference(&self, inputs: &References<'_>) -> Result<Vec<Reference>, NodeError> {
        let Some(dabs) = self.truth() else { return Err(NodeError::new("the reference's drops cover too much")) };
        let Sprayed { alpha, depth, age, .. } =
            dabs.at(inputs.at, inputs.view(self.node.source("view"), Channel::Depth));
        Ok(vec![Reference::Mask(alpha), Reference::Field(vec![depth]), Reference::Mask(age)])
    }

    fn left_out(&self) -> Vec<Omission> {
        let (count, of) = ((self.drops - self.dabs.len()) as f64, self.drops as f64);
        let why = "they lie beside the picture or behind the camera, or have faded";
        if count > 0.0 { vec![Omission { port: None, what: "drops", count, of, why }] } else { Vec::new() }
    }

    fn bytes(&self) -> usize {
        self.dabs.bytes() + self.run.bytes()
    }
}

#[cfg(test)]
mod tests {
    use crate::testing::refused;

    const SCENE: &str = r#""c": { "type": "Camera" }, "s": { "type": "GerstnerSea", "count": 4 },
        "v": { "type": "Render", "camera": "c", "surfaces": ["s"] },"#;

    #[test]
    fn what_would_take_too_much_is_refused_with_the_knob_to_change() {
        for (knobs, expected) in [
            (r#""size": [1e6, 1e6]"#, "smaller or \\\"cell\\\" larger"),
            (r#""lifetime": 10000, "rate": 10000"#, "steps in a lifetime"),
            (r#""size": [400, 400], "lifetime": 200"#, "cells over all steps"),
            (r#""density": 1e6, "cell": 10, "size": [20, 20]"#, "drops from a cell"),
            (r#""size": [-1, 5]"#, "not negative"),
            (r#""bursts": [{ "count": 500000 }, { "count": 1 }]"#, "drops at a time"),
        ] {
            let nodes = format!(r#"{SCENE} "out": {{ "type": "Spray", "view": "v", "sea": "s", {knobs} }}"#);
            let faults = refused("weights", &nodes);
            assert!(faults.contains(expected), "{knobs}: {faults}");
        }
    }
}
