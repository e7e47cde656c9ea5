//! Packets of rays side by side in lanes, and what they meet.

use super::Segment;
use fearless_simd::{Simd, f32x16, mask32x16, prelude::*};
use glam::{DVec3, Vec3};

/// Number of rays in a packet.
pub(super) const RAYS: usize = 16;
/// Distance by which a ray may miss a triangle's edge, relative to the triangle, so that no ray slips through between
/// two triangles.
const EDGE: f32 = 1e-5;
/// Factor by which rays enter boxes earlier than computed, so that rounding keeps none out.
pub(super) const EARLY: f32 = 1.0 - 4e-6;
/// Least size of a component of a direction when it divides: 0 would compute 0·∞ for a box at the ray's origin.
const LEAST: f32 = 1e-18;

/// A value of each ray.
pub(super) type Lanes = [f32; RAYS];

/// Rays that walk together. Lanes without a ray meet nothing.
#[repr(align(64))]
pub(super) struct Packet {
    pub(super) origin: [Lanes; 3],
    direction: [Lanes; 3],
    pub(super) inverse: [Lanes; 3],
    /// Distance beyond which nothing matters any more; negative if nothing does.
    pub(super) nearest: Lanes,
}

impl Packet {
    /// Returns the packet of at most [`RAYS`] rays, relative to an origin.
    #[inline(always)]
    pub(super) fn new(segments: &[Segment], origin: DVec3) -> Self {
        let none = [[0.0; RAYS]; 3];
        let mut packet = Self { origin: none, direction: none, inverse: none, nearest: [-1.0; RAYS] };
        for (lane, Segment { ray, limit }) in segments.iter().enumerate() {
            let (origin, direction) = ((ray.origin - origin).as_vec3(), ray.direction.as_vec3());
            let (origin, direction) = (origin.to_array(), direction.to_array());
            for axis in 0..3 {
                let part = direction[axis];
                packet.origin[axis][lane] = origin[axis];
                packet.direction[axis][lane] = part;
                packet.inverse[axis][lane] = if part.abs() < LEAST { 1.0 / LEAST } else { 1.0 / part };
            }
            // Also if it is not a number.
            packet.nearest[lane] = limit.max(-1.0) as f32;
        }
        packet
    }

    /// Returns the greatest of the distances beyond which nothing matters.
    #[inline(always)]
    pub(super) fn most<S: Simd>(&self, simd: S) -> f32 {
        f32x16::from_slice(simd, &self.nearest).reduce_max()
    }

    /// Takes rays, given as bits, out of the packet.
    #[inline(always)]
    pub(super) fn close(&mut self, mut rays: u32) {
        while rays != 0 {
            self.nearest[rays.trailing_zeros() as usize] = -1.0;
            rays &= rays - 1;
        }
    }

    #[inline(always)]
    fn vectors<S: Simd>(simd: S, lanes: &[Lanes; 3]) -> [f32x16<S>; 3] {
        let [x, y, z] = lanes;
        [f32x16::from_slice(simd, x), f32x16::from_slice(simd, y), f32x16::from_slice(simd, z)]
    }

    /// Returns the rays that enter a box, as bits, and where each enters it.
    #[inline(always)]
    pub(super) fn enter<S: Simd>(&self, simd: S, low: [f32; 3], high: [f32; 3]) -> (u32, f32x16<S>) {
        let (origin, inverse) = (Self::vectors(simd, &self.origin), Self::vectors(simd, &self.inverse));
        let mut near = f32x16::splat(simd, 0.0);
        let mut far = f32x16::splat(simd, f32::INFINITY);
        for axis in 0..3 {
            let a = (f32x16::splat(simd, low[axis]) - origin[axis]) * inverse[axis];
            let b = (f32x16::splat(simd, high[axis]) - origin[axis]) * inverse[axis];
            near = near.max(a.min(b));
            far = far.min(a.max(b));
        }
        let entry = near * EARLY;
        let nearest = f32x16::from_slice(simd, &self.nearest);
        ((entry.simd_le(far) & entry.simd_le(nearest)).to_bitmask() as u32, entry)
    }

    /// Returns the rays that meet a triangle, as bits, and keeps their distances, given the rays that enter its box and
    /// where.
    #[inline(always)]
    pub(super) fn meet<S: Simd>(&mut self, simd: S, corners: [Vec3; 3], entering: u32, entry: f32x16<S>) -> u32 {
        let [p, q, r] = corners;
        let [ax, ay, az] = (q - p).to_array();
        let [bx, by, bz] = (r - p).to_array();
        let [dx, dy, dz] = Self::vectors(simd, &self.direction);
        let across = [dy * bz - dz * by, dz * bx - dx * bz, dx * by - dy * bx];
        let determinant = across[0] * ax + across[1] * ay + across[2] * az;
        let [x, y, z] = Self::vectors(simd, &self.origin);
        let (x, y, z) = (x - p.x, y - p.y, z - p.z);
        let u = x * across[0] + y * across[1] + z * across[2];
        // Divisions take most of the time, so rays that miss by far are told before. These comparisons let pass all that
        // the exact ones below do: they ask for twice the distance from the edge, which exceeds all rounding.
        let size = determinant.abs();
        let (least, most) = (size * (-2.0 * EDGE), size * (1.0 + 2.0 * EDGE));
        let sign = f32x16::splat(simd, 1.0).copysign(determinant);
        let near_u = u * sign;
        let rough = near_u.simd_ge(least) & near_u.simd_le(most + size * (2.0 * EDGE));
        if rough.to_bitmask() as u32 & entering == 0 {
            return 0;
        }
        let along = [y * az - z * ay, z * ax - x * az, x * ay - y * ax];
        let v = dx * along[0] + dy * along[1] + dz * along[2];
        let near_v = v * sign;
        let rough = rough & near_v.simd_ge(least) & (near_u + near_v).simd_le(most);
        if rough.to_bitmask() as u32 & entering == 0 {
            return 0;
        }
        let (u, v) = (u / determinant, v / determinant);
        let distance = (along[0] * bx + along[1] * by + along[2] * bz) / determinant;
        let within = u.simd_ge(-EDGE) & v.simd_ge(-EDGE) & (u + v).simd_le(1.0 + EDGE);
        let finite = distance.simd_ge(0.0) & distance.simd_lt(f32::INFINITY);
        // The maximum of zeros may have either sign; the sum with 0 is positive.
        let distance = distance.max(entry) + 0.0;
        let nearest = f32x16::from_slice(simd, &self.nearest);
        let mask = mask32x16::from_bitmask(simd, u64::from(entering)) & within & finite & distance.simd_le(nearest);
        mask.select(distance, nearest).store_slice(&mut self.nearest);
        mask.to_bitmask() as u32
    }
}
