//! Thickness: how much water light has to pass.

use crate::front_support::{Span, bound_by, where_covered};
use crate::scene_support::{
    BEYOND, DETAIL, DISTANCE, INSET, Rays, Seen, Surroundings, Way, asked, check_surfaces, eye, memory, toward_eye,
};
use std::sync::Arc;
use trochoid_graph::*;
use trochoid_scene::shading::unit_or_up;
use trochoid_scene::{DVec3, Light, Projector};

pub(crate) static NODE: &dyn NodeType = &Thickness;

struct Thickness;

static DECLARATION: Declaration = Declaration {
    name: "Thickness",
    end: End::Front,
    summary: "How much water lies between the seen point and the air behind it, toward a light or along the eye's ray.",
    formula: "The length of the straight way from P − δN to where it first passes through a surface, at most \
              `distance`; δ = `inset`, but at most halfway to where −N does. The way leads toward the light, or, \
              where `ray` is eye, along the eye's ray d as the water refracts it: r = d/η − (d · N/η + √(1 − (1 − \
              (d · N)²)/η²))N.",
    edge_cases: "0 where nothing is seen. `distance` where the way has no end: toward a light below the horizon, or \
                 out of what is seen from below. Surfaces count as far as the picture, made wider by `beyond`, holds \
                 them; ways begin at least 1/50 of a facet under them.",
    source: "Thesis 3.1.2: thin crests against the light are translucent; Snell's law.",
    items: &[
        Port::one("view", Accepts::View, "What is seen, a Render."),
        Port::optional("light", Accepts::Light, "Where light comes from; for `ray` light."),
        Knob::choice("ray", &["light", "eye"], "Where the way leads.").item(),
        Knob::number("ior", 1.333, 1.0, 10.0, "Index of refraction η; for `ray` eye.").item(),
        INSET,
        DISTANCE,
        DETAIL,
        BEYOND,
    ],
    outputs: &[Output::new("thickness", Kind::Field(1), "Length of the way, m.")],
    revision: 1,
};

impl NodeType for Thickness {
    fn declaration(&self) -> &'static Declaration {
        &DECLARATION
    }

    fn check(&self, node: &Settled, check: &mut Check<'_>) {
        check_surfaces(node, check);
        if node.text("ray") == "light" && node.all("light").is_empty() {
            let found = "the ray light without a light";
            check.error("ray", found, "a light that the way leads to", "connect \"light\", or use \"eye\"");
        }
    }

    fn body(&self) -> Body<'_> {
        Body::Stage(self)
    }
}

impl Stage for Thickness {
    fn asks(&self, _node: &Settled, _wanted: &[bool]) -> ChannelSet {
        asked()
    }

    fn interval(&self, node: &Settled, _output: usize, _channel: usize) -> Option<(f64, f64)> {
        // The value is a rounded f32.
        Some((0.0, f64::from(node.number("distance") as f32)))
    }

    fn rate(&self, _node: &Settled) -> Rate {
        Rate::Surface
    }

    fn memory(&self, node: &Settled, reckoning: &Reckoning<'_>) -> MemoryUse {
        memory::of_surroundings(node, reckoning)
    }

    fn prepare(&self, node: &Settled, prepare: &Prepare<'_>) -> Result<Box<dyn Prepared>, NodeError> {
        let lights: Vec<Light> = prepare.handles(node, "light")?;
        Ok(Box::new(Thick {
            node: node.clone(),
            surroundings: Surroundings::of(node, prepare)?,
            eye: eye(node, prepare, prepare.frame.format)?,
            light: lights.first().copied().filter(|_| node.text("ray") == "light"),
            ior: node.number("ior"),
            way: Way::of(node),
        }))
    }
}

struct Thick {
    node: Settled,
    surroundings: Arc<Surroundings>,
    eye: Projector,
    /// `None` where the way is the eye's.
    light: Option<Light>,
    ior: f64,
    way: Way,
}

impl Thick {
    fn thickness(&self, seen: &Seen, rays: Rays<'_>) -> f64 {
        let along = match &self.light {
            Some(light) => light.illuminate(seen.point).direction,
            None => refracted(-unit_or_up(toward_eye(&self.eye, seen.point)), seen.normal, self.ior),
        };
        self.way.length(seen, along, rays.first)
    }
}

/// A unit direction as a surface of this unit normal refracts it into what has index `ior`.
fn refracted(direction: DVec3, normal: DVec3, ior: f64) -> DVec3 {
    let cosine = direction.dot(normal) / ior;
    let squared = 1.0 - (1.0 / (ior * ior) - cosine * cosine);
    unit_or_up(direction / ior - normal * (cosine + squared.max(0.0).sqrt()))
}

impl Prepared for Thick {
    fn fill(&self, block: &Block<'_>, inputs: &Inputs<'_>, outputs: &mut Outputs<'_>) -> Result<(), NodeError> {
        let Some(out) = outputs.take(0, 0) else { return Ok(()) };
        self.surroundings.fill(block, inputs, out, |seen, rays| self.thickness(seen, rays))
    }

    fn bound(&self, bounding: &Bounding<'_>, outputs: &mut Outputs<'_>) -> Result<(), NoBound> {
        // The reference's rays meet the surfaces themselves: facets may let them pass, or stop them.
        bound_by(bounding, outputs, (0, 0), |sample| {
            where_covered(bounding, sample, || Span::unclear(0.0, self.way.most()))
        });
        Ok(())
    }

    fn reference(&self, inputs: &References<'_>) -> Result<Vec<Reference>, NodeError> {
        let quantity = |seen: &Seen, rays: Rays<'_>| self.thickness(seen, rays);
        Ok(vec![Reference::Field(vec![self.surroundings.quantity_reference(&self.node, inputs, quantity)])])
    }

    fn bytes(&self) -> usize {
        self.surroundings.bytes()
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::testing::refused;

    #[test]
    fn refracts_as_snell_says() {
        for angle in [0.0f64, 0.3, 1.0, 1.57] {
            let bent = refracted(DVec3::new(angle.sin(), -angle.cos(), 0.0), DVec3::Y, 1.333);
            assert!((bent.x - angle.sin() / 1.333).abs() < 1e-12 && bent.y < 0.0, "{bent}");
            assert!((bent.length() - 1.0).abs() < 1e-12);
        }
        let straight = DVec3::new(0.6, -0.8, 0.0);
        assert!((refracted(straight, DVec3::Y, 1.0) - straight).length() < 1e-12);
    }

    #[test]
    fn needs_a_light_to_go_toward() {
        let faults = refused(
            "field",
            r#""camera": { "type": "Camera" }, "sea": { "type": "GerstnerSea", "count": 0 },
               "view": { "type": "Render", "camera": "camera", "surfaces": ["sea"] },
               "out": { "type": "Thickness", "view": "view" }"#,
        );
        assert!(faults.contains("connect \\\"light\\\""), "{faults}");
    }
}
