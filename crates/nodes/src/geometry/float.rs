//! Float: bodies that ride on a sea.

use super::Standing;
use crate::sea::check_sea;
use crate::view::SurfaceHandle;
use trochoid_graph::*;
use trochoid_scene::{Floating, Pose, RigidBodies};

/// Makes a model ride on a sea, at one place or at many: it rises, pitches and rolls with the water under it.
///
/// # Formula
/// The plane y = h + a·u + b·v through the water at 9 × 5 points under the hull, by least squares, u toward the bow, v
/// to starboard. The model's up is the plane's normal, slopes times `tilt`; its origin stands `lift` along it above (x,
/// h, z). The water at a place is that of the rest point which waves carry there.
///
/// # Edge cases
/// Waves that are shorter than the hull hardly move it: those shorter than the points lie apart are smoothed away, the
/// rest averages out. Where waves fold over, the body follows one of the sheets. Beside a finite sea the heights of its
/// edge go on. Nothing depends on the frames before: no momentum, no drift; key `x`, `z` and `heading` to let it sail.
/// The water takes no notice of the body.
///
/// # Source
/// Creation of a cartoon shader of water for the web, part 2 (buoyancy); linear least squares.
#[derive(Clone, Node)]
#[node(end = Front, revision = 1, output(surface: Kind::Surface = "The floating bodies, as one surface."))]
pub(crate) struct Float {
    /// What floats: bow along +x, y up, y = 0 its waterline.
    model: One<port::Surface>,
    /// The water: GerstnerSea, RippleSea or ToonSea.
    sea: One<port::Surface>,
    /// Length of the hull under water.
    #[knob(default = 4.0, range = 1e-3..=1e6, unit = "m")]
    length: f64,
    /// Width of the hull under water.
    #[knob(default = 2.0, range = 1e-3..=1e6, unit = "m")]
    width: f64,
    /// Share of the water's slope that bodies take: 0 stays upright.
    #[knob(default = 1.0, range = 0.0..=10.0)]
    tilt: f64,
    /// Where the model floats.
    #[list(1..=64)]
    bodies: Vec<Afloat>,
}

#[derive(Clone, Items)]
struct Afloat {
    /// World x of its middle.
    #[knob(default = 0.0, range = -1e8..=1e8, unit = "m")]
    x: f64,
    /// World z of its middle.
    #[knob(default = 0.0, range = -1e8..=1e8, unit = "m")]
    z: f64,
    /// Where its bow points: 0 is +X, 90 is +Z.
    #[knob(default = 0.0, range = -36e5..=36e5, unit = "degrees")]
    heading: f64,
    /// How far it floats above its waterline; negative sinks it.
    #[knob(default = 0.0, range = -1e5..=1e5, unit = "m")]
    lift: f64,
}

impl Node for Float {
    fn check(&self, check: &mut Check<'_>) {
        check_sea(&self.sea, check);
        let Some(model) = check.upstream(&self.model) else { return };
        if model.node.get::<Self>().is_some() {
            let found = format!("\"{}\", which floats already: its places count as a part of the model", model.name);
            let remedy = "connect its model here too, or list all places in its \"bodies\"";
            check.warning(Self::MODEL, found, "a model that stands still", remedy);
        }
        if model.offers(Offer::Rest) {
            let found = format!("\"{}\", a {}, which is water itself", model.name, model.ty());
            check.error(Self::MODEL, found, "a model that floats", "connect a Mesh or a BezierModel");
        }
    }

    fn body(&self) -> Body<'_> {
        Body::Stage(self)
    }
}

impl Stage for Float {
    fn formatted(&self) -> bool {
        false
    }

    fn memory(&self, reckoning: &Reckoning<'_>) -> MemoryUse {
        let seen = reckoning.all(&self.model).fold(0, |sum: u64, taken| sum.saturating_add(taken.seen));
        MemoryUse::default().seen(seen.saturating_mul(self.bodies.len() as u64))
    }

    fn prepare(&self, prepare: &Prepare<'_>) -> Result<Box<dyn Prepared>, NodeError> {
        let handle = |of: &One<port::Surface>| Ok::<_, NodeError>(prepare.handles::<SurfaceHandle>(of)?.swap_remove(0));
        let [model, sea] = [handle(&self.model)?, handle(&self.sea)?];
        let pose = |body: &Afloat| {
            let floating = Floating {
                place: [body.x, body.z],
                heading: body.heading.to_radians(),
                hull: [self.length, self.width],
                lift: body.lift,
                tilt: self.tilt,
            };
            floating.pose(sea.as_ref())
        };
        let poses: Option<Vec<Pose>> = self.bodies.iter().map(pose).collect();
        match poses {
            Some(poses) => Ok(Box::new(Standing::new(RigidBodies::new(model, poses)))),
            None => Err(BadData::new("a model", "water to float on", "connect a sea").of_item(Self::SEA).into()),
        }
    }
}

#[cfg(test)]
mod tests {
    use crate::testing::{Frame, graph, refused};
    use std::path::Path;

    #[test]
    fn only_water_floats_things() {
        let nodes = |sea: &str| {
            format!(
                r#""c": {{ "type": "Camera" }}, "water": {{ "type": "RippleSea" }},
                "m": {{ "type": "BezierModel", "patches": [{{ "points": [{{ "at": [0, 0, 0] }}, {{ "at": [1, 0, 0] }},
                    {{ "at": [0, 0, 1] }}, {{ "at": [1, 0, 1] }}] }}] }},
                "f": {{ "type": "Float", "model": "m", "sea": "{sea}", "bodies": [{{ "x": 1 }}, {{ "x": 4 }}] }},
                "v": {{ "type": "Render", "camera": "c", "surfaces": ["f"] }},
                "out": {{ "type": "Depth", "view": "v" }}"#
            )
        };
        assert!(Frame::new(graph("field", &nodes("water"), Path::new(".")).unwrap()).is_ok());
        let faults = refused("field", &nodes("m"));
        assert!(faults.contains("which has no plane at rest") && faults.contains("RippleSea or ToonSea"), "{faults}");
    }
}
