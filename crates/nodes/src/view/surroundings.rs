//! What stands around the points of a view, for rays that go on from there.

use super::{Looking, SurfaceHandle};
use std::sync::Arc;
use trochoid_graph::{BadData, Items, NodeError, One, Prepare, port};
use trochoid_scene::{DVec3, Obstacles, Projector, Ray, Surface, first_reference, surroundings};

/// How closely surfaces stand in the way of rays.
#[derive(Clone, Items)]
pub(crate) struct Facets {
    /// Size of the facets that rays meet: larger ones are cheaper.
    #[knob(default = 2.0, range = 0.5..=64.0, unit = "pixels")]
    pub(crate) detail: f64,
    /// How far beyond the picture surfaces are in the way of rays, in pictures on each side; of a sea all around from some size
    /// on.
    #[knob(default = 0.5, range = 0.0..=8.0)]
    pub(crate) beyond: f64,
}

/// The surfaces of a view, and a little of what lies beside it, in the way of rays.
pub(crate) struct Surroundings {
    projector: Projector,
    /// Held, so that no other surfaces come to stand at their addresses, by which these are known.
    surfaces: Vec<SurfaceHandle>,
    obstacles: Obstacles,
}

/// The first distance along a ray within a limit.
pub(crate) type First<'a> = &'a dyn Fn(&Ray, f64) -> Option<f64>;

/// How far the surface that rays meet is looked for above and below a seen point, and how far under it rays into it
/// begin, in facets.
const AROUND: f64 = 4.0;
pub(crate) const UNDER: f64 = 0.02;

/// The point of the surface that rays meet which stands for a seen point with a unit normal: facets of another size
/// put it a little above or below. The seen point itself where there is none.
pub(crate) fn landed(point: DVec3, normal: DVec3, facet: f64, first: First<'_>) -> DVec3 {
    let reach = AROUND * facet;
    let down = Ray { origin: point + normal * reach, direction: -normal };
    first(&down, 2.0 * reach).map_or(point, |distance| down.at(distance))
}

impl Surroundings {
    /// What stands around the points of the node's view; all nodes that ask for the same share it.
    ///
    /// # Errors
    /// The view has no surfaces, but passes alone.
    pub(crate) fn of(view: &One<port::View>, facets: &Facets, prepare: &Prepare<'_>) -> Result<Arc<Self>, NodeError> {
        let handle = prepare.handle_of(view);
        let Some(looking) = handle.as_deref().and_then(|handle| handle.downcast_ref::<Looking>()) else {
            let expected = "one of surfaces, which can stand in the way of rays";
            return Err(BadData::new("a view of passes", expected, "connect a Render").into());
        };
        let eye = looking.camera.projector(prepare.frame.format);
        let projector = surroundings(&eye, facets.beyond, facets.detail);
        // Surfaces count by who they are: what is shared holds them, so that no other takes the place of one.
        let address = |surface: &SurfaceHandle| Arc::as_ptr(surface).cast::<()>().addr();
        let addresses: Vec<usize> = looking.surfaces.iter().map(address).collect();
        prepare.shared(&(projector, addresses), || {
            let surfaces = looking.surfaces.clone();
            let obstacles = Obstacles::new(&projector, &borrowed(&surfaces));
            Ok(Self { projector, surfaces, obstacles })
        })
    }

    /// Distance to the first point along a ray, by the tessellated surfaces.
    pub(crate) fn first(&self, ray: &Ray, limit: f64) -> Option<f64> {
        self.obstacles.first(ray, limit)
    }

    /// Whether anything stands in the way of a ray.
    pub(crate) fn blocks(&self, ray: &Ray, limit: f64) -> bool {
        self.obstacles.blocks(ray, limit)
    }

    /// The first point by the continuous surfaces, in f64.
    pub(crate) fn first_reference(&self, ray: &Ray, limit: f64) -> Option<f64> {
        first_reference(&self.projector, &borrowed(&self.surfaces), ray, limit)
    }

    /// Size of a facet at a point, in meters.
    pub(crate) fn facet(&self, point: DVec3) -> f64 {
        self.projector.pixel_size(point.distance(self.projector.position))
    }

    pub(crate) fn bytes(&self) -> usize {
        self.obstacles.bytes()
    }
}

fn borrowed(surfaces: &[SurfaceHandle]) -> Vec<&dyn Surface> {
    surfaces.iter().map(|surface| surface.as_ref() as &dyn Surface).collect()
}
