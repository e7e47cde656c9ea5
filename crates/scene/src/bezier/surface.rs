//! A model as a surface: its meshes, and its intersections with rays.

use super::model::{PatchModel, PlacedPatch, Tessellation};
use super::{tessellate, trace};
use crate::certain::{Search, contours_of_facets};
use crate::channel::FINE;
use crate::points::MeshHit;
use crate::surface::{Anchor, Hit, Mesh, Surface};
use crate::{ChannelSet, Projector, Ray};

/// Tolerances of fine meshes, in pixels; the first one that the patches can meet is used.
const FINELY: [f64; 3] = [1.0 / 64.0, 1.0 / 16.0, 1.0 / 4.0];

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

    fn tessellate_finely(&self, projector: &Projector, stop: &(dyn Fn() -> bool + Sync)) -> Option<Mesh> {
        let mut mesh = None;
        for tolerance in FINELY {
            let tessellation = Tessellation::Adaptive { tolerance };
            mesh = (!stop()).then(|| tessellate::mesh(self, projector, tessellation, FINE).0);
            // Where patches are too large for such a fine mesh, its distance from the surface is unknown.
            if mesh.as_ref().is_none_or(|mesh| mesh.tolerance.is_some()) {
                break;
            }
        }
        mesh
    }

    fn contours(&self, search: &Search<'_>, mesh: &Mesh) -> bool {
        contours_of_facets(mesh, search, true)
    }

    /// Returns the point in the smallest range of distances that contains one.
    fn meet_near(&self, projector: &Projector, ray: &Ray, near: &MeshHit) -> Option<Hit> {
        let around = |share: f64| [(1.0 - share) * near.distance, (1.0 + share) * near.distance];
        [1e-4, 1e-3, 1e-2].into_iter().find_map(|share| trace::trace(self, projector, ray, around(share)))
    }

    fn trace(&self, projector: &Projector, ray: &Ray) -> Option<Hit> {
        trace::trace(self, projector, ray, [0.0, f64::INFINITY])
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
