//! Surroundings of the points of a view, for rays that start there.

use super::{RenderHandle, SeenPoint, SurfaceHandle};
use std::sync::Arc;
use trochoid_graph::{BadData, Items, NodeError, One, Prepare, port};
use trochoid_memory::Scratch;
use trochoid_scene::{DVec3, GivenUp, Obstacles, Projector, Ray, Segment, Surface, first_reference, surroundings};

/// Fineness of the surfaces that block rays.
#[derive(Clone, Items)]
pub(crate) struct Facets {
    /// Size of the facets that rays hit; larger facets are faster.
    #[knob(default = 2.0, range = 0.5..=64.0, unit = "pixels")]
    pub(crate) detail: f64,
    /// Distance beyond the picture up to which surfaces block rays, in picture sizes on each side; for a sea, large
    /// values include all directions.
    #[knob(default = 0.5, range = 0.0..=8.0)]
    pub(crate) beyond: f64,
}

/// The surfaces of a view, including some beyond its edges, as obstacles of rays.
pub(crate) struct Surroundings {
    projector: Projector,
    /// The surfaces, and those that references see. Both are kept alive, so that no other surface can reuse the addresses
    /// that identify these.
    surfaces: [Vec<SurfaceHandle>; 2],
    obstacles: Obstacles,
}

/// What rays meet.
pub(crate) trait Rays {
    /// Returns the distance to the first hit along each ray, if there is one.
    fn first(&self, segments: &[Segment]) -> Scratch<Option<f64>>;

    /// Whether anything blocks each ray.
    fn blocks(&self, segments: &[Segment]) -> Scratch<bool>;
}

/// Distance above and below a seen point within which the surface hit by rays is searched for, and distance below that
/// surface at which rays into it start, both in facets.
const AROUND: f64 = 4.0;
pub(crate) const UNDER: f64 = 0.02;

/// Returns the points of the surface hit by rays that correspond to seen points: facets of another size lie a little
/// above or below these. Returns a seen point itself if there is none.
pub(crate) fn landed(seen: &[SeenPoint], rays: &dyn Rays) -> Scratch<DVec3> {
    let down = |seen: &SeenPoint| {
        let &SeenPoint { point, normal, facet, .. } = seen;
        let reach = AROUND * facet;
        Segment { ray: Ray { origin: point + normal * reach, direction: -normal }, limit: 2.0 * reach }
    };
    let down: Scratch<Segment> = seen.iter().map(down).collect();
    let found = rays.first(&down);
    let landed = seen.iter().zip(&down).zip(&found);
    landed.map(|((seen, down), distance)| distance.map_or(seen.point, |distance| down.ray.at(distance))).collect()
}

impl Surroundings {
    /// Returns the surroundings of the points of the node's view, shared by all nodes that request the same.
    ///
    /// # Errors
    /// The view has no surfaces, only passes.
    pub(crate) fn of(view: &One<port::View>, facets: &Facets, prepare: &Prepare<'_>) -> Result<Arc<Self>, NodeError> {
        let handle = prepare.handle_of(view);
        let Some(render) = handle.as_deref().and_then(|handle| handle.downcast_ref::<RenderHandle>()) else {
            let expected = "a view of surfaces";
            return Err(BadData::new("a view of passes", expected, "connect a Render").into());
        };
        let eye = render.camera.projector(prepare.frame.format);
        let projector = surroundings(&eye, facets.beyond, facets.detail);
        // Surfaces are identified by their addresses. The shared value keeps them alive, so that no address is reused.
        let address = |surface: &SurfaceHandle| Arc::as_ptr(surface).cast::<()>().addr();
        let addresses: Vec<usize> = render.surfaces.iter().chain(&render.exact).map(address).collect();
        prepare.shared(&(projector, addresses), || {
            let surfaces = [render.surfaces.clone(), render.exact.clone()];
            let obstacles = Obstacles::new(&projector, &borrowed(&surfaces[0]));
            Ok(Self { projector, surfaces, obstacles })
        })
    }

    /// Returns the distance to the first hit in f64, using continuous surfaces.
    ///
    /// # Errors
    /// A surface is too rough along the ray.
    pub(crate) fn first_reference(&self, ray: &Ray, limit: f64) -> Result<Option<f64>, GivenUp> {
        first_reference(&self.projector, &borrowed(&self.surfaces[1]), ray, limit)
    }

    /// Returns the size of a facet at a point, in meters.
    pub(crate) fn facet(&self, point: DVec3) -> f64 {
        self.projector.pixel_size(point.distance(self.projector.position))
    }

    pub(crate) fn bytes(&self) -> usize {
        self.obstacles.bytes()
    }
}

/// Rays that meet tessellated surfaces.
impl Rays for Surroundings {
    fn first(&self, segments: &[Segment]) -> Scratch<Option<f64>> {
        self.obstacles.first(segments)
    }

    fn blocks(&self, segments: &[Segment]) -> Scratch<bool> {
        self.obstacles.blocks(segments)
    }
}

fn borrowed(surfaces: &[SurfaceHandle]) -> Vec<&dyn Surface> {
    surfaces.iter().map(|surface| surface.as_ref() as &dyn Surface).collect()
}
