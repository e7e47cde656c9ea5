//! Pseudorandom numbers that are the same in every run.

/// Deterministic numbers (Marsaglia's xorshift, 13, 7, 17); the seed must not be 0.
pub(crate) struct Random(pub(crate) u64);

impl Random {
    /// Returns a number in [0, 1).
    pub(crate) fn unit(&mut self) -> f64 {
        self.0 ^= self.0 << 13;
        self.0 ^= self.0 >> 7;
        self.0 ^= self.0 << 17;
        (self.0 >> 11) as f64 / (1_u64 << 53) as f64
    }

    /// Returns a number in [low, high).
    pub(crate) fn between(&mut self, low: f64, high: f64) -> f64 {
        low + (high - low) * self.unit()
    }
}
