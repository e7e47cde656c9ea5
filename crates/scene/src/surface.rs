use std::sync::Arc;

use glam::{DVec3, Vec3};
use trochoid_image::Window;
use trochoid_memory::Scratch;

use crate::on_heights::HeightField;
use crate::patches::Patches;
use crate::points::MeshHit;
use crate::{ChannelSet, Projector, Ray, Resting, SeaSurface};

/// Something that a camera can see.
///
/// `tessellate` and `trace` describe the same surface: the first is fast and faceted, finely enough for the given
/// camera, the second is in f64 without facets.
pub trait Surface: Send + Sync {
    /// Returns a mesh of the part of the surface that the camera may see, fine enough for its pixels.
    ///
    /// Must not compute anything that `wanted` does not request, and must not depend on the number of threads. An
    /// empty mesh is correct if nothing can be seen.
    fn tessellate(&self, projector: &Projector, wanted: ChannelSet) -> Mesh;

    /// Does the same, or returns `None` soon after `stop` first says that the result is no longer needed.
    fn tessellate_unless(
        &self,
        projector: &Projector,
        wanted: ChannelSet,
        stop: &(dyn Fn() -> bool + Sync),
    ) -> Option<Mesh> {
        (!stop()).then(|| self.tessellate(projector, wanted))
    }

    /// Does the same for a part of the picture, given in pixels: the mesh may lack what is not seen there. What is seen
    /// there has the same bits, and primitives the same order.
    fn tessellate_part(
        &self,
        projector: &Projector,
        wanted: ChannelSet,
        _part: Option<Window>,
        stop: &(dyn Fn() -> bool + Sync),
    ) -> Option<Mesh> {
        self.tessellate_unless(projector, wanted, stop)
    }

    /// Returns the first point of the continuous surface along a ray from the camera, if it is nearer than `end`, in f64.
    ///
    /// # Errors
    /// The surface is too rough along the ray to find its first point with reasonable effort.
    fn trace(&self, projector: &Projector, ray: &Ray, end: f64) -> Result<Option<Hit>, GivenUp>;

    /// Prepares for many rays of a camera; gives up soon after `stop` says that they are no longer needed.
    fn prepare_rays(&self, projector: &Projector, stop: &(dyn Fn() -> bool + Sync)) {
        let _ = (projector, stop);
    }

    /// Returns the first point of the continuous surface along a ray from the camera, if it is nearer than `end`, in
    /// f64 and with limited effort: [`Sight::Unclear`] if that does not suffice to be certain.
    fn first(&self, projector: &Projector, ray: &Ray, end: f64, asked: Asked) -> Sight {
        let _ = asked;
        match self.trace(projector, ray, end) {
            Ok(hit) => hit.map_or(Sight::Nothing, Sight::of),
            Err(GivenUp) => Sight::Unclear,
        }
    }

    /// Returns the point of the continuous surface along a ray near a point of its mesh, in f64.
    fn meet_near(&self, projector: &Projector, ray: &Ray, near: &MeshHit) -> Option<Hit> {
        let _ = near;
        self.trace(projector, ray, f64::INFINITY).ok().flatten()
    }

    /// Returns whether the way from a point of the mesh to the surface along a ray leads to the point that the ray meets.
    fn leads_to(&self, projector: &Projector, ray: &Ray, near: &MeshHit, met: &Met) -> bool {
        met.holds(near.rest) || self.meet_near(projector, ray, near).is_some_and(|led| met.is_at(led.distance))
    }

    /// Meets the surface near points of its mesh for many rays; sums of waves may be computed in f32. Each result depends only on its own ray.
    fn follow(&self, projector: &Projector, mesh_hits: &[(Ray, MeshHit)]) -> Scratch<Option<Hit>> {
        mesh_hits.iter().map(|(ray, near)| self.meet_near(projector, ray, near)).collect()
    }

    /// Returns the sea of waves, for objects that move with the water; `None` for any other surface.
    fn as_sea(&self) -> Option<&SeaSurface> {
        None
    }

    /// Returns world y of a sea above or below a position x, z, without the waves that a footprint in meters filters
    /// out; `None` for a surface that is not a sea.
    fn height_at(&self, place: [f64; 2], footprint: f64) -> Option<f64> {
        let _ = (place, footprint);
        None
    }

    /// Returns every point that has these texture coordinates; none if the surface does not know them.
    fn anchors(&self, uv: [f64; 2]) -> Vec<Anchor> {
        let _ = uv;
        Vec::new()
    }

    /// Returns the same surface by its rest points, if it lies over a resting plane.
    fn resting(&self) -> Option<&dyn Resting> {
        None
    }

    /// Returns the surface that references see, with at least the wanted channels: one that was computed in f64 from its
    /// description. Gives up soon after `stop` says that it is no longer needed.
    fn exact(&self, wanted: ChannelSet, stop: &(dyn Fn() -> bool + Sync)) -> Exact {
        let _ = (wanted, stop);
        Exact::Itself
    }

    /// Returns how far any channel of a hit may be from that of the surface's description because of the rounding of
    /// what the surface was made from, given |normal · ray|.
    fn doubt(&self, facing: f64) -> f64 {
        let _ = facing;
        0.0
    }
}

/// The surface that references see.
#[derive(Clone)]
pub enum Exact {
    /// The surface itself.
    Itself,
    /// Another surface, whose `exact` is itself.
    Other(Arc<dyn Surface>),
    /// It was stopped.
    Stopped,
}

impl Sight {
    /// Returns the sight of a point of which nothing else is known.
    pub(crate) fn of(hit: Hit) -> Self {
        Self::Point(Met { hit, off: 0.0, deep: 0.0, sheet: None })
    }

    /// Returns the point, if the ray certainly meets one.
    pub fn hit(&self) -> Option<&Hit> {
        self.met().map(|met| &met.hit)
    }

    /// Returns the point with what is known about it, if the ray certainly meets one.
    pub fn met(&self) -> Option<&Met> {
        match self {
            Self::Point(met) => Some(met),
            Self::Unclear | Self::Nothing => None,
        }
    }
}

/// Error: a surface is too rough along a ray to find its first point with reasonable effort.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct GivenUp;

impl std::fmt::Display for GivenUp {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        f.write_str("a surface that is too rough to find its first point along a ray")
    }
}

impl std::error::Error for GivenUp {}

/// What is asked about the first point on a ray.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Asked {
    /// The surface and the sheet. The distance is known nearly, and no other value need be that of the point.
    Surface,
    /// All values, each of which may be off by a thousandth, as [`Met::off`] says.
    Nearly,
    /// All values.
    Values,
}

/// What a ray certainly meets.
#[derive(Clone, Copy, Debug, PartialEq)]
#[allow(clippy::large_enum_variant, reason = "nearly all sights are points")]
pub enum Sight {
    /// It is not certain.
    Unclear,
    /// No surface.
    Nothing,
    /// A point of a surface.
    Point(Met),
}

/// A point of a surface that a ray certainly meets first.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Met {
    /// The point.
    pub hit: Hit,
    /// How far any of the hit's values may be from those of the surface's own point: its search ended this close.
    pub off: f64,
    /// How far its distance may be off, in meters.
    pub deep: f64,
    /// The sheet around it, if it is known.
    pub sheet: Option<OneSheet>,
}

/// Largest distance of a point to which steps from the mesh lead from the first point of the ray, relative to 1 m +
/// distance, if they are one.
const SAME: f64 = 1e-6;

impl Met {
    /// Returns whether a rest point lies in the sheet, so that only this point of the ray may belong to its surroundings.
    pub(crate) fn holds(&self, rest: DVec3) -> bool {
        self.sheet.is_some_and(|sheet| sheet.holds([rest.x, rest.z]))
    }

    /// Returns whether a point of the ray at a distance is this one.
    pub(crate) fn is_at(&self, distance: f64) -> bool {
        (distance - self.hit.distance).abs() <= SAME * (1.0 + self.hit.distance) + self.deep
    }
}

/// A rectangle of rest points of which a ray meets one at most: no two are carried to the same offset from the ray.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct OneSheet {
    /// Its middle, x and z, in meters.
    pub middle: [f64; 2],
    /// Horizontal unit vector x, z along its first side.
    pub heading: [f64; 2],
    /// Half of its sides along the heading and across it, in meters.
    pub half: [f64; 2],
}

impl OneSheet {
    /// Returns whether a rest point x, z lies in it, up to rounding.
    pub fn holds(&self, rest: [f64; 2]) -> bool {
        let [x, z] = [0, 1].map(|axis| rest[axis] - self.middle[axis]);
        let [a, b] = self.heading;
        let slack = 8.0 * f64::EPSILON * (rest[0].abs() + rest[1].abs());
        let away = [x * a + z * b, z * a - x * b].map(f64::abs);
        (0..2).all(|axis| away[axis] <= self.half[axis] * (1.0 + 1e-8) + slack)
    }
}

/// A point of a surface by its texture coordinates (u, v).
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Anchor {
    /// Point in the world.
    pub point: DVec3,
    /// ∂P/∂u, or at least its direction.
    pub along_u: DVec3,
    /// ∂P/∂v, or at least its direction.
    pub along_v: DVec3,
}

/// How the vertices of a mesh are connected.
#[derive(Clone, Debug, PartialEq)]
pub enum Topology {
    /// Row by row; each cell of four neighbors is two triangles. Seen from the outer side, a step to the next row
    /// followed by a step to the next column turns clockwise.
    Grid {
        /// Number of vertices in a row.
        columns: usize,
        /// Number of rows.
        rows: usize,
    },
    /// Three vertices per triangle, counterclockwise seen from the outer side.
    Triangles(Vec<[u32; 3]>),
}

/// What lies between the vertices of a mesh.
#[derive(Clone, Debug)]
pub enum Between {
    /// Flat triangles, over which everything is interpolated linearly.
    Triangles,
    /// The patches of a grid's cells.
    Patches(Patches),
    /// The field of heights that the vertices are taken from; it gives normals and trails, too.
    Heights(HeightField),
}

/// A tessellated surface. All positions are relative to the camera's, so that f32 is exact near it.
///
/// Its triangles decide which surface a ray meets. Where exactly, and with which normal, is decided by what lies
/// between the vertices.
#[derive(Clone, Debug)]
pub struct Mesh {
    /// Vertices relative to the camera, in meters.
    pub positions: Vec<[f32; 3]>,
    /// Normals of any length; empty if not wanted, or if they follow from what lies between the vertices.
    pub normals: Vec<[f32; 3]>,
    /// Rest points x, z relative to the camera; empty if not wanted.
    pub rests: Vec<[f32; 2]>,
    /// Rest points y relative to the camera; empty if not wanted or if all lie on the rest level.
    pub rest_heights: Vec<f32>,
    /// Texture coordinates; empty if not wanted. Without them, rest points replace them.
    pub uvs: Vec<[f32; 2]>,
    /// Slope variance that the footprint filtered out; empty if not wanted.
    pub slope_variances: Vec<f32>,
    /// [`Channel::TRAILS`](crate::Channel::TRAILS); each is empty if not wanted or if the surface has none.
    pub trails: [Vec<f32>; 6],
    /// World y of the rest level, in meters.
    pub level: f64,
    /// Whether the camera is on the inner side of the surface, such as under water.
    pub inside: bool,
    /// Largest distance of triangles from the surface, in pixels, if the triangles alone determine it; `None` if
    /// unknown.
    pub tolerance: Option<f64>,
    /// Connections of the vertices.
    pub topology: Topology,
    /// What lies between the vertices.
    pub between: Between,
}

impl Mesh {
    /// Returns a mesh without vertices.
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
            inside: false,
            tolerance: None,
            topology: Topology::Triangles(Vec::new()),
            between: Between::Triangles,
        }
    }

    /// Returns the mesh with normals at its vertices and flat triangles between them, for a camera's position.
    pub(crate) fn into_triangles(mut self, eye: DVec3) -> Self {
        match std::mem::replace(&mut self.between, Between::Triangles) {
            Between::Triangles => {}
            Between::Patches(patches) => {
                let normal = |[by_s, by_t]: &[[f32; 3]; 2]| Vec3::from(*by_s).cross(Vec3::from(*by_t)).to_array();
                self.normals = patches.tangents.iter().map(normal).collect();
            }
            Between::Heights(field) => {
                let normal = |[x, _, z]: &[f32; 3]| {
                    let [dx, dz] = field.slopes([eye.x + f64::from(*x), eye.z + f64::from(*z)]);
                    [-dx as f32, 1.0, -dz as f32]
                };
                self.normals = self.positions.iter().map(normal).collect();
                self.rests = self.positions.iter().map(|[x, _, z]| [*x, *z]).collect();
            }
        }
        self
    }

    /// Returns the number of cells of a grid, or of triangles.
    pub(crate) fn primitives(&self) -> usize {
        match &self.topology {
            Topology::Grid { columns, rows } => columns.saturating_sub(1) * rows.saturating_sub(1),
            Topology::Triangles(triangles) => triangles.len(),
        }
    }
}

/// Point that a ray meets, in f64.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Hit {
    /// Index of the surface.
    pub surface: usize,
    /// Distance along the ray, in meters.
    pub distance: f64,
    /// Planar depth, in meters.
    pub depth: f64,
    /// Position in the world.
    pub position: DVec3,
    /// Unit normal of the outer side, as in [`Channel::NormalX`](crate::Channel::NormalX).
    pub normal: DVec3,
    /// Rest point, as in [`Channel::RestX`](crate::Channel::RestX).
    pub rest: DVec3,
    /// Height above the rest level, in meters.
    pub height: f64,
    /// Distance from the rest point, in meters.
    pub rest_distance: f64,
    /// Slope variance that the footprint filtered out.
    pub slope_variance: f64,
    /// Ratio of the areas of the displaced and the resting surface.
    pub jacobian: f64,
    /// Texture coordinates, as in [`Channel::U`](crate::Channel::U).
    pub uv: [f64; 2],
    /// [`Channel::TRAILS`](crate::Channel::TRAILS).
    pub trails: [f64; 6],
}
