//! Pseudorandom numbers that are the same in every run.

use trochoid_scene::DVec3;

/// Numbers in [0, 1) by a fixed rule: Weyl's sequence, scrambled.
pub(crate) struct Draw(pub(crate) u64);

impl Draw {
    pub(crate) fn next(&mut self) -> f64 {
        self.0 = self.0.wrapping_add(0x9e37_79b9_7f4a_7c15);
        let mixed = (self.0 ^ (self.0 >> 31)).wrapping_mul(0xbf58_476d_1ce4_e5b9);
        ((mixed ^ (mixed >> 27)) >> 11) as f64 / (1_u64 << 53) as f64
    }

    pub(crate) fn point(&mut self, size: f64) -> DVec3 {
        (DVec3::new(self.next(), self.next(), self.next()) - 0.5) * 2.0 * size
    }
}
