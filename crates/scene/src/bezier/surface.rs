//! A model as a surface: its meshes, and its intersections with rays.

use super::model::{PatchModel, PlacedPatch};
use super::{tessellate, trace};
use crate::points::MeshHit;
use crate::surface::{Anchor, GivenUp, Hit, Mesh, Surface};
use crate::{ChannelSet, Projector, Ray};

impl PatchModel {
    /// Returns the number of vertices without a normal in the mesh for a camera; their normals point up.
    pub fn without_normal(&self, projector: &Projector) -> usize {
        tessellate::mesh(self, projector, self.tessellation, ChannelSet::NORMAL).1
    }
}

impl Surface for PatchModel {
    fn tessellate(&self, projector: &Projector, wanted: ChannelSet) -> Mesh {
        tessellate::mesh(self, projector, self.tessellation, wanted).0
    }

    /// Returns the point in the smallest range of distances that contains one.
    fn meet_near(&self, projector: &Projector, ray: &Ray, near: &MeshHit) -> Option<Hit> {
        let around = |share: f64| [(1.0 - share) * near.distance, (1.0 + share) * near.distance];
        [1e-4, 1e-3, 1e-2].into_iter().find_map(|share| trace::trace(self, projector, ray, around(share)))
    }

    fn trace(&self, projector: &Projector, ray: &Ray, end: f64) -> Result<Option<Hit>, GivenUp> {
        Ok(trace::trace(self, projector, ray, [0.0, end]))
    }

    fn anchors(&self, uv: [f64; 2]) -> Vec<Anchor> {
        let anchor = |placed: &PlacedPatch| {
            let [u, v] = placed.place(uv)?;
            let [along_u, along_v] = placed.shape.tangents(u, v);
            Some(Anchor { point: placed.shape.evaluate(u, v), along_u, along_v })
        };
        self.placed.iter().filter_map(anchor).collect()
    }
}
