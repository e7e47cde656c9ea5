//! Hits of one mesh that are processed together.

#![allow(clippy::needless_range_loop, reason = "loops over lanes of several arrays")]

use glam::DVec3;

use super::hits::Hits;
use super::{BLOCK, Lanes};
use crate::shading::unit_or_up;
use crate::surface::Mesh;
use crate::{Channel, Projector, Targets};

/// Hits of one mesh.
pub(super) struct Block<'a> {
    pub(super) hits: &'a Hits,
    pub(super) mesh: &'a Mesh,
    /// Places across and upward from the middle of the picture, as of [`Projector::place`].
    pub(super) places: [Lanes; 2],
}

impl Block<'_> {
    /// Writes normals of any length, turned over on a side that faces away, as in a fold.
    #[inline(always)]
    pub(super) fn put_normals(&self, normals: &[Lanes; 3], sides: &Lanes, out: &mut Targets<'_>) {
        let own = if self.mesh.inside { 1.0 } else { -1.0 };
        let (mut x, mut y, mut z) = ([0.0; BLOCK], [0.0; BLOCK], [0.0; BLOCK]);
        for lane in 0..BLOCK {
            let normal = DVec3::new(normals[0][lane], normals[1][lane], normals[2][lane]);
            let normal = unit_or_up(normal) * (own * sides[lane]);
            (x[lane], y[lane], z[lane]) = (normal.x, normal.y, normal.z);
        }
        self.put(Channel::NormalX, &x, out);
        self.put(Channel::NormalY, &y, out);
        self.put(Channel::NormalZ, &z, out);
    }

    /// Computes the barycentric weights of the points where the pixels' rays meet triangles, from the exact positions:
    /// the fixed-point positions only decided which triangles these are.
    ///
    /// For a ray from the origin along r, the point Σ wᵢPᵢ is on it if w₀ : w₁ : w₂ = r·(P₁×P₂) : r·(P₂×P₀) :
    /// r·(P₀×P₁). Also gives −1 if a triangle's outer side is seen, else 1. Rounding may have put the ray slightly
    /// outside of the triangle: negative weights count as 0. Without perspective, all rays are parallel.
    #[inline(always)]
    pub(super) fn weights<const PARALLEL: bool>(
        &self,
        positions: &[[Lanes; 3]; 3],
        projector: &Projector,
        weights: &mut [Lanes; 3],
        sides: &mut Lanes,
    ) {
        for lane in 0..BLOCK {
            let (across, upward) = (projector.right * self.places[0][lane], projector.up * self.places[1][lane]);
            let corner = |corner: usize| {
                let [x, y, z] = &positions[corner];
                let position = DVec3::new(x[lane], y[lane], z[lane]);
                if PARALLEL { position - across - upward } else { position }
            };
            let (p, q, r) = (corner(0), corner(1), corner(2));
            let ray = if PARALLEL { projector.forward } else { projector.forward + across + upward };
            let (a, b, c) = (ray.dot(q.cross(r)), ray.dot(r.cross(p)), ray.dot(p.cross(q)));
            // The sum is r·((P₁−P₀)×(P₂−P₀)): negative if the outer side is seen.
            let side = if a + b + c < 0.0 { -1.0 } else { 1.0 };
            let kept = |weight: f64| if weight * side > 0.0 { weight * side } else { 0.0 };
            let (a, b, c) = (kept(a), kept(b), kept(c));
            let sum = a + b + c;
            let fair = sum > 0.0 && sum < f64::INFINITY;
            let share = |weight: f64| if fair { weight / sum } else { 1.0 / 3.0 };
            (weights[0][lane], weights[1][lane], weights[2][lane]) = (share(a), share(b), share(c));
            sides[lane] = side;
        }
    }

    /// Writes the value of each hit if the channel was requested.
    #[inline(always)]
    pub(super) fn put(&self, channel: Channel, values: &Lanes, out: &mut Targets<'_>) {
        let samples = out.all(channel);
        if samples.is_empty() {
            return;
        }
        let mut rounded = [0.0; BLOCK];
        for lane in 0..BLOCK {
            rounded[lane] = values[lane] as f32;
        }
        let places = &self.hits.places[..self.hits.count];
        match self.hits.run() {
            Some(run) => samples[run].copy_from_slice(&rounded[..places.len()]),
            None => places.iter().zip(rounded).for_each(|(place, value)| samples[*place as usize] = value),
        }
    }

    /// Writes one value at all hits.
    #[inline(always)]
    pub(super) fn put_all(&self, channel: Channel, value: f32, out: &mut Targets<'_>) {
        let samples = out.all(channel);
        if samples.is_empty() {
            return;
        }
        match self.hits.run() {
            Some(run) => samples[run].fill(value),
            None => self.hits.places[..self.hits.count].iter().for_each(|place| samples[*place as usize] = value),
        }
    }
}
