//! Rigid bodies: one surface at many poses.

use std::sync::Arc;

use glam::DVec3;

use crate::points::MeshHit;
use crate::surface::{Anchor, Asked, Exact, GivenUp, Hit, Mesh, Met, Sight, Surface, Topology};
use crate::{ChannelSet, Projector, Ray};

/// Position and orientation of a rigid body.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Pose {
    /// Unit vectors along the body's x, y and z, at right angles, right-handed.
    pub axes: [DVec3; 3],
    /// Position of the body's origin, in meters.
    pub origin: DVec3,
}

impl Pose {
    /// Converts a direction of the body to the world.
    pub fn turn(&self, direction: DVec3) -> DVec3 {
        let [x, y, z] = self.axes;
        x * direction.x + y * direction.y + z * direction.z
    }

    /// Converts a point of the body to the world.
    pub fn apply(&self, point: DVec3) -> DVec3 {
        self.origin + self.turn(point)
    }

    /// Converts a direction of the world to the body's space.
    fn turn_back(&self, direction: DVec3) -> DVec3 {
        DVec3::from(self.axes.map(|axis| axis.dot(direction)))
    }

    /// Converts a ray to the body's space.
    fn ray(&self, ray: &Ray) -> Ray {
        Ray { origin: self.turn_back(ray.origin - self.origin), direction: self.turn_back(ray.direction) }
    }

    /// Converts a hit of the body to the world.
    fn hit(&self, projector: &Projector, hit: Hit) -> Hit {
        let position = self.apply(hit.position);
        let level = hit.position.y - hit.height;
        Hit {
            depth: (position - projector.position).dot(projector.forward),
            position,
            normal: self.turn(hit.normal),
            height: position.y - level,
            rest_distance: position.distance(hit.rest),
            jacobian: 1.0,
            ..hit
        }
    }

    /// Converts a camera to the body's space.
    fn projector(&self, projector: &Projector) -> Projector {
        Projector {
            position: self.turn_back(projector.position - self.origin),
            right: self.turn_back(projector.right),
            up: self.turn_back(projector.up),
            forward: self.turn_back(projector.forward),
            ..*projector
        }
    }
}

/// A surface at several poses. Its rest points and texture coordinates are those of the surface itself.
#[derive(Clone)]
pub struct RigidBodies {
    model: Arc<dyn Surface>,
    poses: Vec<Pose>,
    /// Poses in which references see it, if they differ, and the doubt about the water that they float on.
    exact: Option<(Vec<Pose>, f64)>,
    /// The doubt about the water, for the poses themselves.
    doubt: f64,
}

impl RigidBodies {
    /// Makes bodies of a model, one per pose.
    pub fn new(model: Arc<dyn Surface>, poses: Vec<Pose>) -> Self {
        Self { model, poses, exact: None, doubt: 0.0 }
    }

    /// Sets the poses in which references see the bodies ([`Surface::exact`]), and the doubt about the water that they
    /// float on ([`Surface::doubt`]).
    #[must_use]
    pub fn with_exact(self, poses: Vec<Pose>, doubt: f64) -> Self {
        Self { exact: Some((poses, doubt)), ..self }
    }

    /// Returns the poses.
    pub fn poses(&self) -> &[Pose] {
        &self.poses
    }

    /// Returns the mesh of one body; `tessellate` makes it as the body's own camera sees it.
    fn body(
        &self,
        pose: &Pose,
        projector: &Projector,
        tessellate: impl Fn(&Projector) -> Option<Mesh>,
    ) -> Option<Mesh> {
        let own = pose.projector(projector);
        let mut mesh = tessellate(&own)?.into_triangles(own.position);
        // Vectors relative to the camera are only rotated.
        let turn = |vector: &mut [f32; 3]| {
            *vector = pose.turn(DVec3::from(vector.map(f64::from))).as_vec3().to_array();
        };
        mesh.positions.iter_mut().for_each(turn);
        mesh.normals.iter_mut().for_each(turn);
        // Rest points stay those of the model, but are relative to the camera's position in the world.
        let moved = own.position - projector.position;
        let shift = |value: &mut f32, by: f64| *value = (f64::from(*value) + by) as f32;
        for [x, z] in &mut mesh.rests {
            shift(x, moved.x);
            shift(z, moved.z);
        }
        mesh.rest_heights.iter_mut().for_each(|y| shift(y, moved.y));
        Some(mesh)
    }

    /// Returns the mesh of all bodies.
    fn bodies(&self, projector: &Projector, tessellate: impl Fn(&Projector) -> Option<Mesh>) -> Option<Mesh> {
        let mut all = Mesh { tolerance: Some(0.0), ..Mesh::empty(0.0) };
        let mut joined = Vec::new();
        for pose in &self.poses {
            let mesh = self.body(pose, projector, &tessellate)?;
            all.level = mesh.level;
            all.tolerance = all.tolerance.zip(mesh.tolerance).map(|(a, b)| a.max(b));
            // A body out of sight has no vertices; the attributes of all others match.
            let own = triangles(&mesh.topology, all.positions.len() as u32);
            // Each body has its own inner side: if it is seen from there, turning its triangles over has the same
            // effect.
            joined.extend(own.into_iter().map(|[a, b, c]| if mesh.inside { [a, c, b] } else { [a, b, c] }));
            all.positions.extend(mesh.positions);
            all.normals.extend(mesh.normals);
            all.rests.extend(mesh.rests);
            all.rest_heights.extend(mesh.rest_heights);
            all.uvs.extend(mesh.uvs);
            all.slope_variances.extend(mesh.slope_variances);
        }
        all.topology = Topology::Triangles(joined);
        Some(all)
    }
}

/// Returns the triangles of a mesh, with vertices numbered from `first` on.
fn triangles(topology: &Topology, first: u32) -> Vec<[u32; 3]> {
    match topology {
        Topology::Triangles(triangles) => {
            triangles.iter().map(|triangle| triangle.map(|vertex| vertex + first)).collect()
        }
        Topology::Grid { columns, rows } => {
            let cells = (1..*rows).flat_map(|row| (1..*columns).map(move |column| (row, column)));
            let of = |(row, column): (usize, usize)| {
                let [near, far] = [row - 1, row].map(|row| (row * columns + column - 1) as u32 + first);
                [[near, far + 1, far], [near, near + 1, far + 1]]
            };
            cells.flat_map(of).collect()
        }
    }
}

impl Surface for RigidBodies {
    fn exact(&self, wanted: ChannelSet, stop: &(dyn Fn() -> bool + Sync)) -> Exact {
        let model = match self.model.exact(wanted, stop) {
            Exact::Stopped => return Exact::Stopped,
            Exact::Itself => None,
            Exact::Other(model) => Some(model),
        };
        if model.is_none() && self.exact.is_none() {
            return Exact::Itself;
        }
        let (poses, doubt) = self.exact.clone().unwrap_or_else(|| (self.poses.clone(), 0.0));
        Exact::Other(Arc::new(Self { doubt, ..Self::new(model.unwrap_or_else(|| self.model.clone()), poses) }))
    }

    /// A pose is a mean of the water's heights and slopes over the hull, which is about as long as the body.
    fn doubt(&self, facing: f64) -> f64 {
        const POSE: f64 = 8.0;
        self.model.doubt(facing) + POSE * self.doubt / facing
    }

    fn anchors(&self, uv: [f64; 2]) -> Vec<Anchor> {
        let anchors = self.model.anchors(uv);
        let stand = |pose: &Pose| {
            let (turn, point) = (|way| pose.turn(way), |point| pose.apply(point));
            let place =
                |at: &Anchor| Anchor { point: point(at.point), along_u: turn(at.along_u), along_v: turn(at.along_v) };
            anchors.iter().map(place).collect::<Vec<_>>()
        };
        self.poses.iter().flat_map(stand).collect()
    }

    fn tessellate(&self, projector: &Projector, wanted: ChannelSet) -> Mesh {
        let model = |own: &Projector| Some(self.model.tessellate(own, wanted));
        self.bodies(projector, model).unwrap_or_else(|| Mesh::empty(0.0))
    }

    fn meet_near(&self, projector: &Projector, ray: &Ray, near: &MeshHit) -> Option<Hit> {
        let away = |hit: &Hit| (hit.distance - near.distance).abs();
        let hits = self.hits(projector, ray, |own, ray| self.model.meet_near(own, ray, near));
        hits.min_by(|a, b| away(a).total_cmp(&away(b)))
    }

    fn first(&self, projector: &Projector, ray: &Ray, end: f64, asked: Asked) -> Sight {
        let mut nearest = Sight::Nothing;
        let mut end = end;
        for pose in &self.poses {
            match self.model.first(&pose.projector(projector), &pose.ray(ray), end, asked) {
                Sight::Unclear => return Sight::Unclear,
                Sight::Nothing => {}
                Sight::Point(met) => {
                    end = met.hit.distance;
                    nearest = Sight::Point(Met { hit: pose.hit(projector, met.hit), ..met });
                }
            }
        }
        nearest
    }

    fn trace(&self, projector: &Projector, ray: &Ray, end: f64) -> Result<Option<Hit>, GivenUp> {
        let (mut nearest, mut end) = (None, end);
        for pose in &self.poses {
            if let Some(hit) = self.model.trace(&pose.projector(projector), &pose.ray(ray), end)? {
                end = hit.distance;
                nearest = Some(pose.hit(projector, hit));
            }
        }
        Ok(nearest)
    }
}

impl RigidBodies {
    /// Returns the hits of the model, in the world, that `meet` finds with camera and ray in each body's space.
    fn hits(
        &self,
        projector: &Projector,
        ray: &Ray,
        meet: impl Fn(&Projector, &Ray) -> Option<Hit>,
    ) -> impl Iterator<Item = Hit> {
        self.poses
            .iter()
            .filter_map(move |pose| Some(pose.hit(projector, meet(&pose.projector(projector), &pose.ray(ray))?)))
    }
}
