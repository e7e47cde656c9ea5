//! Float: bodies that float on a sea.

use super::PreparedSurface;
use crate::sea::check_sea;
use crate::view::SurfaceHandle;
use trochoid_graph::*;
use trochoid_scene::{Exact, Floating, Pose, RigidBodies};

/// Floats a model on a sea, at one or more places: it rises, pitches and rolls with the water under it.
///
/// # Formula
/// The plane y = h + a·u + b·v is fitted by least squares to the water at 9 × 5 points under the hull, u toward the
/// bow, v to starboard. The model's up axis is the plane's normal, with slopes multiplied by `tilt`; its origin lies
/// `lift` along this axis above (x, h, z). The water at a place is found from the rest point that waves carry there.
///
/// # Edge cases
/// Waves shorter than the hull hardly move it: waves shorter than the distance between the points are filtered out,
/// and the others average out. Where waves fold over, the body follows one of the sheets. Beyond the edge of a finite
/// sea, the heights of its edge continue. Nothing depends on earlier frames: there is no momentum or drift. Key `x`,
/// `z` and `heading` to make the body travel. The body does not affect the water.
///
/// # Source
/// Creation of a cartoon shader of water for the web, part 2 (buoyancy); linear least squares.
#[derive(Clone, Node)]
#[node(
    stage, end = Front, revision = 1,
    example = r#""model": "boat", "bodies": [{ "x": 3 }]"#,
    output(surface: Kind::Surface = "The floating bodies, as one surface.")
)]
pub(crate) struct Float {
    /// Model to float: bow along +x, y up, waterline at y = 0.
    model: One<port::Surface>,
    /// Sea to float on: a GerstnerSea, RippleSea or ToonSea.
    sea: One<port::Surface>,
    /// Length of the hull below the waterline.
    #[knob(default = 4.0, range = 1e-3..=1e6, unit = "m")]
    length: f64,
    /// Width of the hull below the waterline.
    #[knob(default = 2.0, range = 1e-3..=1e6, unit = "m")]
    width: f64,
    /// Share of the water's slope that bodies follow; 0 keeps them upright.
    #[knob(default = 1.0, range = 0.0..=10.0)]
    tilt: f64,
    /// Places where the model floats.
    #[list(1..=64)]
    bodies: Vec<BodyPlacement>,
}

#[derive(Clone, Items)]
struct BodyPlacement {
    /// World x of the body's middle.
    #[knob(default = 0.0, range = -1e8..=1e8, unit = "m", places = X)]
    x: f64,
    /// World z of the body's middle.
    #[knob(default = 0.0, range = -1e8..=1e8, unit = "m", places = Z)]
    z: f64,
    /// Direction of the bow: 0 is +X, 90 is +Z.
    #[knob(default = 0.0, range = -36e5..=36e5, unit = "degrees", places = Heading)]
    heading: f64,
    /// Height above the normal waterline; negative values sink the body.
    #[knob(default = 0.0, range = -1e5..=1e5, unit = "m", places = Lift)]
    lift: f64,
}

impl Node for Float {
    fn check(&self, check: &mut Check<'_>) {
        check_sea(&self.sea, check);
        let Some(model) = check.upstream(&self.model) else { return };
        if model.node.get::<Self>().is_some() {
            let found = format!("\"{}\", which already floats: its places become part of the model", model.name);
            let remedy = "connect its model here instead, or list all places in its \"bodies\"";
            check.warning(Self::MODEL, found, "a model that does not float yet", remedy);
        }
        if model.offers(Offer::Rest) {
            let found = format!("\"{}\", a {}, which is water", model.name, model.ty());
            check.error(Self::MODEL, found, "a model that floats", "connect a Mesh or a BezierModel");
        }
    }
}

impl Stage for Float {
    fn depends_on_format(&self) -> bool {
        false
    }

    fn memory(&self, context: &MemoryContext<'_>) -> MemoryUse {
        let seen = context.all(&self.model).fold(0, |sum: u64, taken| sum.saturating_add(taken.per_view));
        MemoryUse::default().per_view(seen.saturating_mul(self.bodies.len() as u64))
    }

    fn prepare(&self, prepare: &Prepare<'_>) -> Result<Box<dyn Prepared>, NodeError> {
        let handle = |of: &One<port::Surface>| Ok::<_, NodeError>(prepare.handles::<SurfaceHandle>(of)?.swap_remove(0));
        let [model, sea] = [handle(&self.model)?, handle(&self.sea)?];
        let floating = |body: &BodyPlacement| Floating {
            place: [body.x, body.z],
            heading: body.heading.to_radians(),
            hull: [self.length, self.width],
            lift: body.lift,
            tilt: self.tilt,
        };
        let poses: Option<Vec<Pose>> = self.bodies.iter().map(|body| floating(body).pose(sea.as_ref())).collect();
        let Some(poses) = poses else {
            return Err(BadData::new("a model", "water to float on", "connect a sea").of_item(Self::SEA).into());
        };
        let mut bodies = RigidBodies::new(model, poses);
        if prepare.referenced()
            && let Exact::Other(water) = sea.exact(ChannelSet::EMPTY, prepare.cancellation())
        {
            let poses = self.bodies.iter().filter_map(|body| floating(body).pose(&*water));
            bodies = bodies.with_exact(poses.collect(), water.doubt(1.0));
        }
        prepare.check_cancelled()?;
        Ok(Box::new(PreparedSurface::new(bodies)))
    }
}
