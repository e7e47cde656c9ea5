use glam::DVec3;

use crate::certain::Search;
use crate::channel::FINE;
use crate::points::Near;
use crate::{ChannelSet, Projector, Ray, Resting, SeaSurface};

/// Something that a camera can see.
///
/// `tessellate` and `trace` describe one and the same surface: the first fast and faceted, finely enough for the
/// given camera, the second in f64 without facets.
pub trait Surface: Send + Sync {
    /// A mesh of whatever part of the surface the camera may see, fine enough for its pixels.
    ///
    /// Must compute nothing that `wanted` does not ask for, and must not depend on the number of threads. An empty
    /// mesh is right where nothing can be seen.
    fn tessellate(&self, projector: &Projector, wanted: ChannelSet) -> Mesh;

    /// The same, or `None` soon after `stop` has first said that nobody waits for it any longer.
    fn tessellate_unless(
        &self,
        projector: &Projector,
        wanted: ChannelSet,
        stop: &(dyn Fn() -> bool + Sync),
    ) -> Option<Mesh> {
        (!stop()).then(|| self.tessellate(projector, wanted))
    }

    /// A mesh with normals and rest points that is as much finer than a picture needs as it takes to know contours closely;
    /// or `None` as above.
    fn tessellate_finely(&self, projector: &Projector, stop: &(dyn Fn() -> bool + Sync)) -> Option<Mesh> {
        self.tessellate_unless(projector, FINE, stop)
    }

    /// The first point of the continuous surface along a ray from the camera, in f64.
    fn trace(&self, projector: &Projector, ray: &Ray) -> Option<Hit>;

    /// Marks every place of the picture where this surface, its `mesh` for the camera or anything between them may have a
    /// contour that something sees. False where that is not known.
    ///
    /// The mesh is that of [`tessellate_finely`](Self::tessellate_finely).
    fn contours(&self, search: &Search<'_>, mesh: &Mesh) -> bool {
        let _ = (search, mesh);
        false
    }

    /// The point of the continuous surface along a ray that lies next to a point of its mesh, in f64.
    fn meet_near(&self, projector: &Projector, ray: &Ray, near: &Near) -> Option<Hit> {
        let _ = near;
        self.trace(projector, ray)
    }

    /// The same of many, where sums of waves may be made in f32. What a ray meets depends on that ray alone.
    fn follow(&self, projector: &Projector, nears: &[(Ray, Near)]) -> Vec<Option<Hit>> {
        nears.iter().map(|(ray, near)| self.meet_near(projector, ray, near)).collect()
    }

    /// The sea of waves that it is, for what moves with the water; `None` for any other surface.
    fn as_sea(&self) -> Option<&SeaSurface> {
        None
    }

    /// World y of a sea above or below a place x, z, without the waves that a footprint in meters takes; `None` for
    /// whatever is no sea.
    fn height_at(&self, place: [f64; 2], footprint: f64) -> Option<f64> {
        let _ = (place, footprint);
        None
    }

    /// Every point that has these texture coordinates; none of surfaces that do not know them.
    fn anchors(&self, uv: [f64; 2]) -> Vec<Anchor> {
        let _ = uv;
        Vec::new()
    }

    /// The same surface by its rest points, where it lies over a resting plane.
    fn resting(&self) -> Option<&dyn Resting> {
        None
    }
}

/// A point of a surface by its texture coordinates (u, v).
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Anchor {
    /// The point in the world.
    pub point: DVec3,
    /// ∂P/∂u, or at least its direction.
    pub along_u: DVec3,
    /// ∂P/∂v, or at least its direction.
    pub along_v: DVec3,
}

/// How the vertices of a mesh hang together.
#[derive(Clone, Debug, PartialEq)]
pub enum Topology {
    /// Row by row; each cell of four neighbors is two triangles. Seen from the outer side, a step to the next row
    /// and then one to the next column turn clockwise.
    Grid {
        /// Vertices in a row.
        columns: usize,
        /// Number of rows.
        rows: usize,
    },
    /// Three vertices for each triangle, counterclockwise seen from the outer side.
    Triangles(Vec<[u32; 3]>),
}

/// A tessellated surface. All positions are relative to the camera's, so that f32 is exact where it is near.
#[derive(Clone, Debug, PartialEq)]
pub struct Mesh {
    /// Vertices relative to the camera in meters.
    pub positions: Vec<[f32; 3]>,
    /// Normals ∂P/∂z₀ × ∂P/∂x₀ by the rest point, so that y is the Jacobian, or empty where neither is wanted.
    /// Surfaces without rest points have normals of any length.
    pub normals: Vec<[f32; 3]>,
    /// Rest points x, z relative to the camera, or empty where they are not wanted.
    pub rests: Vec<[f32; 2]>,
    /// Rest points y relative to the camera, or empty where they are not wanted or all lie on the rest level.
    pub rest_heights: Vec<f32>,
    /// Texture coordinates, or empty where they are not wanted; without them, rest points stand for them.
    pub uvs: Vec<[f32; 2]>,
    /// Slope variance that the footprint took, or empty where it is not wanted.
    pub slope_variances: Vec<f32>,
    /// [`Channel::TRAILS`](crate::Channel::TRAILS), each empty where it is not wanted or the surface has none.
    pub trails: [Vec<f32>; 6],
    /// World y of the rest level in meters.
    pub level: f64,
    /// Whether the surface has rest points, which give its normals their length.
    pub displaced: bool,
    /// Whether the camera stands on the inner side of the surface, such as under water.
    pub inside: bool,
    /// How far triangles stand off the surface at most, in pixels, where they alone tell that; `None` where it is not known.
    pub tolerance: Option<f64>,
    /// How vertices hang together.
    pub topology: Topology,
}

impl Mesh {
    /// A mesh without vertices.
    pub fn empty(level: f64) -> Self {
        Self {
            positions: Vec::new(),
            normals: Vec::new(),
            rests: Vec::new(),
            rest_heights: Vec::new(),
            uvs: Vec::new(),
            slope_variances: Vec::new(),
            trails: Default::default(),
            level,
            displaced: false,
            inside: false,
            tolerance: None,
            topology: Topology::Triangles(Vec::new()),
        }
    }

    /// Number of cells of a grid, or of triangles.
    pub(crate) fn primitives(&self) -> usize {
        match &self.topology {
            Topology::Grid { columns, rows } => columns.saturating_sub(1) * rows.saturating_sub(1),
            Topology::Triangles(triangles) => triangles.len(),
        }
    }
}

/// What a ray meets, in f64.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Hit {
    /// Index of the surface.
    pub surface: usize,
    /// Distance along the ray in meters.
    pub distance: f64,
    /// Planar depth in meters.
    pub depth: f64,
    /// World point.
    pub position: DVec3,
    /// Unit normal of the outer side, as in [`Channel::NormalX`](crate::Channel::NormalX).
    pub normal: DVec3,
    /// Rest point, as in [`Channel::RestX`](crate::Channel::RestX).
    pub rest: DVec3,
    /// Height above the rest level in meters.
    pub height: f64,
    /// Distance from the rest point in meters.
    pub rest_distance: f64,
    /// Slope variance that the footprint took.
    pub slope_variance: f64,
    /// Area ratio of displaced and resting surface.
    pub jacobian: f64,
    /// Texture coordinates, as in [`Channel::U`](crate::Channel::U).
    pub uv: [f64; 2],
    /// [`Channel::TRAILS`](crate::Channel::TRAILS).
    pub trails: [f64; 6],
}
