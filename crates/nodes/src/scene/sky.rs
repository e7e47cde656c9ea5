//! Sky: how high the eye looks, straight and by way of the surface.

use crate::front_support::{bound_at, bound_by, where_covered};
use crate::scene_support::{NORMAL, Toward, eye, is_covered, view_planes, view_vector};
use trochoid_graph::*;
use trochoid_scene::shading::unit_or_up;
use trochoid_scene::{DVec3, Projector};

pub(crate) static NODE: &dyn NodeType = &Sky;

struct Sky;

static DECLARATION: Declaration = Declaration {
    name: "Sky",
    end: End::Front,
    summary: "Two masks for a gradient of the sky: seen straight, and mirrored by the surface.",
    formula: "(ε − from)/(to − from), limited to [0, 1]; ε is the elevation above the horizon of the ray d through \
              the sample, for `reflected` of r = d − 2(d · N)N.",
    edge_cases: "`sky` is everywhere, also behind surfaces; `reflected` is 0 where nothing is seen. A mirrored ray \
                 that points below the horizon has the elevation of the ground. A degenerate normal points up.",
    source: "The law of reflection; thesis 3.2.3.3 mirrors an environment.",
    items: &[
        Port::one("view", Accepts::View, "What the camera sees."),
        Knob::number("from", 0.0, -90.0, 90.0, "The elevation where the masks are 0; 0 is the horizon.")
            .unit("degrees")
            .item(),
        Knob::number("to", 90.0, -90.0, 90.0, "The elevation where they are 1; 90 is the zenith.")
            .unit("degrees")
            .item(),
    ],
    outputs: &[
        Output::new("sky", Kind::MASK, "How high the sample's ray points."),
        Output::new("reflected", Kind::MASK, "How high it points after the surface has mirrored it."),
    ],
    revision: 1,
};

impl NodeType for Sky {
    fn declaration(&self) -> &'static Declaration {
        &DECLARATION
    }

    fn check(&self, node: &Settled, check: &mut Check<'_>) {
        let (from, to) = (node.number("from"), node.number("to"));
        if to <= from {
            check.error("to", format!("from {from} to {to}"), "from below to", "exchange them, and Invert the mask");
        }
    }

    fn body(&self) -> Body<'_> {
        Body::Stage(self)
    }
}

impl Stage for Sky {
    fn asks(&self, _node: &Settled, wanted: &[bool]) -> ChannelSet {
        // The sky itself needs the camera alone.
        if wanted.get(1).is_some_and(|wanted| *wanted) {
            ChannelSet::of(&NORMAL).union(Channel::Coverage.into())
        } else {
            ChannelSet::EMPTY
        }
    }

    fn interval(&self, _node: &Settled, _output: usize, _channel: usize) -> Option<(f64, f64)> {
        Some((0.0, 1.0))
    }

    fn rate(&self, _node: &Settled) -> Rate {
        Rate::Surface
    }

    fn prepare(&self, node: &Settled, prepare: &Prepare<'_>) -> Result<Box<dyn Prepared>, NodeError> {
        let eye = eye(node, prepare, prepare.frame.format)?;
        Ok(Box::new(Looking { node: node.clone(), eye, from: node.number("from"), to: node.number("to") }))
    }
}

struct Looking {
    node: Settled,
    eye: Projector,
    from: f64,
    to: f64,
}

impl Looking {
    /// The mask of a direction of any length.
    fn mask(&self, direction: DVec3) -> f64 {
        let level = (direction.x * direction.x + direction.z * direction.z).sqrt();
        self.share(libm::atan2(direction.y, level).to_degrees())
    }

    /// The mask of an elevation in degrees.
    fn share(&self, elevation: f64) -> f64 {
        ((elevation - self.from) / (self.to - self.from)).clamp(0.0, 1.0)
    }
}

/// What rounding loses of a share.
const LOST: f64 = 1e-14;

/// A direction as a plane of this normal mirrors it.
fn mirrored(direction: DVec3, normal: DVec3) -> DVec3 {
    let normal = unit_or_up(normal);
    direction - normal * (2.0 * direction.dot(normal))
}

impl Prepared for Looking {
    fn fill(&self, block: &Block<'_>, inputs: &Inputs<'_>, outputs: &mut Outputs<'_>) -> Result<(), NodeError> {
        let ray = |[x, y]: [f64; 2]| self.eye.ray(x, y).direction;
        if let Some(sky) = outputs.take(0, 0) {
            sky.iter_mut().zip(block.places()).for_each(|(out, at)| *out = self.mask(ray(at)) as f32);
        }
        let Some(reflected) = outputs.take(1, 0) else { return Ok(()) };
        let normals = view_planes(inputs, NORMAL);
        let coverage = inputs.view("view", Channel::Coverage);
        for (index, (out, at)) in reflected.iter_mut().zip(block.places()).enumerate() {
            let normal = DVec3::from(normals.map(|plane| f64::from(plane[index])));
            *out = if coverage[index] > 0.0 { self.mask(mirrored(ray(at), normal)) as f32 } else { 0.0 };
        }
        Ok(())
    }

    fn bound(&self, bounding: &Bounding<'_>, outputs: &mut Outputs<'_>) -> Result<(), NoBound> {
        let ray = |[x, y]: [f64; 2]| self.eye.ray(x, y).direction;
        bound_at(bounding, outputs, (0, 0), |at| self.mask(ray(at)));
        let mut places = bounding.block.places();
        bound_by(bounding, outputs, (1, 0), |sample| {
            let at = places.next().unwrap_or_default();
            where_covered(bounding, sample, || {
                // What a normal turns by, its mirror image turns by twice, and its elevation by no more.
                let mirrored = Toward::normal(bounding, sample).mirrored(Toward::exactly(-ray(at)));
                mirrored.elevation().through(|degrees| self.share(degrees)).wider(LOST).within(0.0, 1.0)
            })
        });
        Ok(())
    }

    fn reference(&self, inputs: &References<'_>) -> Result<Vec<Reference>, NodeError> {
        let direction = self.eye.ray(inputs.at[0], inputs.at[1]).direction;
        let reflected = if is_covered(&self.node, inputs) {
            self.mask(mirrored(direction, view_vector(&self.node, inputs, NORMAL)))
        } else {
            0.0
        };
        Ok(vec![Reference::Mask(self.mask(direction)), Reference::Mask(reflected)])
    }
}
