//! Sky: elevation of the view ray and of its reflection.

use super::{NORMAL, is_covered, view_planes, view_vector};
use crate::lit::{BoundedDirection, eye};
use trochoid_graph::*;
use trochoid_scene::shading::unit_or_up;
use trochoid_scene::{DVec3, Projector};

/// Two masks for a gradient of the sky: one for the sky itself, one for its reflection in the surface.
///
/// # Formula
/// (ε − from)/(to − from), limited to [0, 1]. ε is the elevation above the horizon: for `sky`, of the ray d through
/// the sample; for `reflected`, of r = d − 2(d · N)N.
///
/// # Edge cases
/// `sky` is defined everywhere, also behind surfaces; `reflected` is 0 where nothing is seen. A reflected ray that
/// points below the horizon has a negative elevation. A degenerate normal points up.
///
/// # Source
/// The law of reflection; thesis 3.2.3.3 mirrors an environment.
#[derive(Clone, Node)]
#[node(stage, end = Front, revision = 1, outputs = Out)]
pub(crate) struct Sky {
    /// View whose rays are used.
    view: One<port::View>,
    /// Elevation at which the masks are 0; 0 is the horizon.
    #[knob(default = 0.0, range = -90.0..=90.0, unit = "degrees")]
    from: f64,
    /// Elevation at which the masks are 1; 90 is the zenith.
    #[knob(default = 90.0, range = -90.0..=90.0, unit = "degrees")]
    to: f64,
}

#[derive(Clone, Copy, Debug, PartialEq, Outputs)]
enum Out {
    /// Elevation of the sample's ray.
    #[output(Kind::MASK)]
    Sky,
    /// Elevation of the ray reflected by the surface.
    #[output(Kind::MASK)]
    Reflected,
}

impl Node for Sky {
    fn check(&self, check: &mut Check<'_>) {
        let (from, to) = (self.from, self.to);
        if to <= from {
            check.error(
                Self::TO,
                format!("from {from} to {to}"),
                "from below to",
                "exchange them, and Invert the mask",
            );
        }
    }
}

impl Stage for Sky {
    fn required_channels(&self, wanted: &[bool]) -> ChannelSet {
        // The sky itself needs only the camera.
        if wanted.get(usize::from(Out::Reflected)).is_some_and(|wanted| *wanted) {
            ChannelSet::of(&NORMAL).union(Channel::Coverage.into())
        } else {
            ChannelSet::EMPTY
        }
    }

    fn interval(&self, _output: usize, _channel: usize) -> Option<(f64, f64)> {
        Some((0.0, 1.0))
    }

    fn rate(&self) -> Rate {
        Rate::Surface
    }

    fn prepare(&self, prepare: &Prepare<'_>) -> Result<Box<dyn Prepared>, NodeError> {
        let eye = eye(prepare, &self.view, prepare.frame.format)?;
        Ok(Box::new(PreparedSky { node: self.clone(), eye }))
    }
}

struct PreparedSky {
    node: Sky,
    eye: Projector,
}

impl PreparedSky {
    /// Returns the mask of a direction of any length.
    fn mask(&self, direction: DVec3) -> f64 {
        let level = (direction.x * direction.x + direction.z * direction.z).sqrt();
        self.share(libm::atan2(direction.y, level).to_degrees())
    }

    /// Returns the mask of an elevation in degrees.
    fn share(&self, elevation: f64) -> f64 {
        ((elevation - self.node.from) / (self.node.to - self.node.from)).clamp(0.0, 1.0)
    }
}

/// Rounding error of a share.
const LOST: f64 = 1e-14;

/// Returns a direction reflected by a plane with this unit normal.
fn mirrored(direction: DVec3, normal: DVec3) -> DVec3 {
    let normal = unit_or_up(normal);
    direction - normal * (2.0 * direction.dot(normal))
}

impl Prepared for PreparedSky {
    fn fill(&self, block: &Block<'_>, inputs: &Inputs<'_>, outputs: &mut Outputs<'_>) -> Result<(), NodeError> {
        let ray = |[x, y]: [f64; 2]| self.eye.ray(x, y).direction;
        if let Some(sky) = outputs.take(Out::Sky, 0) {
            sky.iter_mut().zip(block.places()).for_each(|(out, at)| *out = self.mask(ray(at)) as f32);
        }
        let Some(reflected) = outputs.take(Out::Reflected, 0) else { return Ok(()) };
        let normals = view_planes(inputs, &self.node.view, NORMAL);
        let coverage = inputs.view(&self.node.view, Channel::Coverage);
        for (index, (out, at)) in reflected.iter_mut().zip(block.places()).enumerate() {
            let normal = DVec3::from(normals.map(|plane| f64::from(plane[index])));
            *out = if coverage[index] > 0.0 { self.mask(mirrored(ray(at), normal)) as f32 } else { 0.0 };
        }
        Ok(())
    }

    fn bound(&self, bounding: &Bounding<'_>, outputs: &mut Outputs<'_>) -> Result<(), NoBound> {
        let ray = |[x, y]: [f64; 2]| self.eye.ray(x, y).direction;
        bounding.bound_at(outputs, Out::Sky, 0, |at| self.mask(ray(at)));
        let mut places = bounding.block.places();
        bounding.bound_by(outputs, Out::Reflected, 0, |sample| {
            let at = places.next().unwrap_or_default();
            bounding.where_covered(&self.node.view, sample, || {
                // When a normal rotates, its reflection rotates by twice the angle, and the elevation by no more than
                // that.
                let mirrored = BoundedDirection::normal(bounding, &self.node.view, sample)
                    .mirrored(BoundedDirection::exactly(-ray(at)));
                mirrored.elevation().through(|degrees| self.share(degrees)).wider(LOST).within(0.0, 1.0)
            })
        });
        Ok(())
    }

    fn reference(&self, inputs: &References<'_>) -> Result<Vec<Reference>, NodeError> {
        let direction = self.eye.ray(inputs.at[0], inputs.at[1]).direction;
        let reflected = if is_covered(inputs, &self.node.view) {
            self.mask(mirrored(direction, view_vector(inputs, &self.node.view, NORMAL)))
        } else {
            0.0
        };
        Ok(vec![Reference::Mask(self.mask(direction)), Reference::Mask(reflected)])
    }
}
