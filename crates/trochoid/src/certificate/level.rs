//! Levels of error bounds: eighths of octaves, one byte for each pixel.

use super::map::{MapError, packed, unpacked};
use std::fmt;

/// Bounds of level 0 to 7: 2^(level/8), to the nearest f64.
const EIGHTHS: [f64; 8] = [
    1.0,
    1.090_507_732_665_257_7,
    1.189_207_115_002_721,
    1.296_839_554_651_009_6,
    std::f64::consts::SQRT_2,
    1.542_210_825_407_940_7,
    1.681_792_830_507_429,
    1.834_008_086_409_342_4,
];

/// Returns the smallest level whose bound is at least `size`, which is positive and finite: ⌈8·log₂ size⌉.
pub(super) fn level_of(size: f64) -> i32 {
    let (fraction, exponent) = libm::frexp(size);
    // frexp returns a fraction from ½ to 1.
    let above = EIGHTHS.iter().filter(|eighth| **eighth < 2.0 * fraction).count();
    8 * (exponent - 1) + above as i32
}

/// Returns the bound of a level.
pub(super) fn bound_of(level: i32) -> f64 {
    libm::scalbn(EIGHTHS[level.rem_euclid(8) as usize], level.div_euclid(8))
}

/// What is certified of the error of one pixel.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum PixelBound {
    /// None.
    Exact,
    /// At most the bound of a level.
    AtMost(i32),
    /// None, on an infinite value.
    Infinite,
    /// No bound is known.
    Unknown,
}

impl PixelBound {
    /// Rounds a bound up to a level.
    pub(super) fn of(size: f64) -> Self {
        match size {
            0.0 => Self::Exact,
            size if size.is_finite() => Self::AtMost(level_of(size)),
            _ => Self::Unknown,
        }
    }

    /// Returns the bound as a number: +∞ if none is known.
    pub(super) fn size(self) -> f64 {
        match self {
            Self::Exact | Self::Infinite => 0.0,
            Self::AtMost(level) => bound_of(level),
            Self::Unknown => f64::INFINITY,
        }
    }
}

impl fmt::Display for PixelBound {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Exact => f.write_str("no error"),
            Self::AtMost(level) => write!(f, "an error of at most {:.2e} (level {level})", bound_of(*level)),
            Self::Infinite => f.write_str("an infinite value that equals its reference"),
            Self::Unknown => f.write_str("no known bound"),
        }
    }
}

/// More than the base of any map: f64 has levels from −8592 to 8192.
const BASES: i32 = 10_000;

/// Bytes of special bounds. A byte between `EXACT` and `INFINITE` is a level, counted from the map's base.
const EXACT: u8 = 0;
const LARGEST: u8 = 253;
const INFINITE: u8 = 254;
const UNKNOWN: u8 = 255;

/// Bounds of a picture's pixels, row by row. The largest level has the byte 253; bounds more than 252 levels (31½
/// octaves) smaller are rounded up to the smallest level, of byte 1.
#[derive(Clone, Debug, PartialEq, Eq)]
pub(super) struct BoundMap {
    /// Level of byte 0, so that byte b has the level `base + b`.
    base: i32,
    bytes: Vec<u8>,
}

impl BoundMap {
    pub(super) fn new(bounds: impl Iterator<Item = PixelBound> + Clone) -> Self {
        let level = |bound: PixelBound| if let PixelBound::AtMost(level) = bound { Some(level) } else { None };
        let largest = bounds.clone().filter_map(level).max();
        let base = largest.map_or(0, |largest| largest - i32::from(LARGEST));
        Self { base, bytes: bounds.map(|bound| byte(bound, base)).collect() }
    }

    /// Returns the level of byte 0.
    pub(super) fn base(&self) -> i32 {
        self.base
    }

    /// Returns the bound of a pixel.
    pub(super) fn at(&self, pixel: usize) -> PixelBound {
        match self.bytes[pixel] {
            EXACT => PixelBound::Exact,
            INFINITE => PixelBound::Infinite,
            UNKNOWN => PixelBound::Unknown,
            byte => PixelBound::AtMost(self.base + i32::from(byte)),
        }
    }

    /// Returns a bound as the map holds it.
    pub(super) fn rounded(&self, bound: PixelBound) -> PixelBound {
        match bound {
            PixelBound::AtMost(level) => PixelBound::AtMost(level.max(self.base + 1)),
            bound => bound,
        }
    }

    pub(super) fn encode(&self) -> String {
        packed(&self.bytes)
    }

    /// Decodes a map of this many pixels. A base of any number is limited to those that maps have.
    pub(super) fn decode(base: i32, text: &str, pixels: usize) -> Result<Self, MapError> {
        Ok(Self { base: base.clamp(-BASES, BASES), bytes: unpacked(text, pixels, pixels)? })
    }

    /// Returns the base that these levels require.
    pub(super) fn proper_base(&self) -> i32 {
        let levels = self.bytes.iter().filter(|byte| (1..=LARGEST).contains(*byte));
        levels.max().map_or(0, |largest| self.base + i32::from(*largest) - i32::from(LARGEST))
    }
}

fn byte(bound: PixelBound, base: i32) -> u8 {
    match bound {
        PixelBound::Exact => EXACT,
        PixelBound::AtMost(level) => (level - base).clamp(1, i32::from(LARGEST)) as u8,
        PixelBound::Infinite => INFINITE,
        PixelBound::Unknown => UNKNOWN,
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn levels_round_up_to_eighths_of_octaves_and_no_further() {
        for level in -1200..1200 {
            let bound = bound_of(level);
            assert_eq!(level_of(bound), level);
            assert_eq!(level_of(bound.next_up()), level + 1);
            assert_eq!(level_of(bound.next_down()), level);
            let log = libm::log2(bound);
            assert!((log - f64::from(level) / 8.0).abs() < 1e-12, "{level}: {bound}");
        }
        let mut last = 0;
        for bits in (0..f32::INFINITY.to_bits()).step_by(99_991).skip(1) {
            let size = f64::from(f32::from_bits(bits));
            let level = level_of(size);
            assert!(bound_of(level) >= size && bound_of(level - 1) < size, "{size}");
            assert!(bits < 100_000 || level >= last, "levels are monotone");
            last = level;
        }
    }

    #[test]
    fn maps_of_bounds_come_back() {
        let sizes = [0.0, 1e-30, 1e-7, 0.3, 0.5, 7.0, f64::INFINITY];
        let bounds: Vec<PixelBound> = sizes.map(PixelBound::of).into_iter().chain([PixelBound::Infinite]).collect();
        let map = BoundMap::new(bounds.iter().copied());
        assert_eq!(BoundMap::decode(map.base(), &map.encode(), 8).as_ref(), Ok(&map));
        assert_eq!(map.proper_base(), map.base());
        for (pixel, bound) in bounds.iter().enumerate() {
            assert_eq!(map.at(pixel), map.rounded(*bound));
            let exact = if pixel == 1 { bound_of(level_of(7.0) - 252) } else { bound.size() };
            assert_eq!(map.at(pixel).size(), exact, "only what is far smaller than the largest is rounded further");
        }
        let exact = BoundMap::new([PixelBound::Exact, PixelBound::Unknown].into_iter());
        assert_eq!((exact.base(), exact.proper_base()), (0, 0));
        assert_ne!(BoundMap::decode(4, &exact.encode(), 2).expect("bytes").proper_base(), 4);
        assert!(BoundMap::decode(0, &exact.encode(), 3).is_err());
    }
}
