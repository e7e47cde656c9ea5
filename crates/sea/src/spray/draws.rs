//! Random numbers that depend on a position in the world, not on the order in which they are drawn.

/// 2⁶⁴ divided by the golden ratio.
const GOLDEN: u64 = 0x9e37_79b9_7f4a_7c15;

/// Spreads the bits of a number over all of its bits: a bijection (Stafford, variant 13).
#[inline]
fn mix(mut x: u64) -> u64 {
    x = (x ^ (x >> 30)).wrapping_mul(0xbf58_476d_1ce4_e5b9);
    x = (x ^ (x >> 27)).wrapping_mul(0x94d0_49bb_1331_11eb);
    x ^ (x >> 31)
}

/// A stream of random numbers for each key, the same on every machine: SplitMix64 (Steele, Lea and Flood, *Fast
/// Splittable Pseudorandom Number Generators*, 2014), started from a hash of the key.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Draws(u64);

impl Draws {
    /// Returns the stream of a key.
    #[inline]
    pub(crate) fn of<const N: usize>(key: [i64; N]) -> Self {
        Self(key.into_iter().fold(0, |hash: u64, part| mix(hash.wrapping_add(GOLDEN) ^ part as u64)))
    }

    /// Returns the next 64 random bits.
    #[inline]
    pub(crate) fn bits(&mut self) -> u64 {
        self.0 = self.0.wrapping_add(GOLDEN);
        mix(self.0)
    }

    /// Returns the next number in (0, 1).
    #[inline]
    pub(crate) fn unit(&mut self) -> f64 {
        ((self.bits() >> 11) as f64 + 0.5) / (1_u64 << 53) as f64
    }
}

/// Returns smooth noise in [0, 1] over x, y and z, with one random number per unit of each.
pub(crate) fn noise(seed: i64, at: [f64; 3]) -> f64 {
    let cell = at.map(f64::floor);
    let part: [f64; 3] = std::array::from_fn(|axis| {
        let t = at[axis] - cell[axis];
        t * t * (3.0 - 2.0 * t)
    });
    let corner = |x: i64, y: i64, z: i64| {
        let [i, j, k] = cell.map(|value| value as i64);
        Draws::of([seed, i.wrapping_add(x), j.wrapping_add(y), k.wrapping_add(z)]).unit()
    };
    let along = |a: f64, b: f64, t: f64| a + (b - a) * t;
    let row = |y: i64, z: i64| along(corner(0, y, z), corner(1, y, z), part[0]);
    let sheet = |z: i64| along(row(0, z), row(1, z), part[1]);
    along(sheet(0), sheet(1), part[2])
}
