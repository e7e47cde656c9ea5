//! Maps of a picture's pixels as text: bytes, deflated, in base64.

use base64::Engine;
use base64::engine::general_purpose::STANDARD;
use libdeflater::{CompressionLvl, Compressor, DecompressionError, Decompressor};

/// Error in a map.
#[derive(Debug, PartialEq, thiserror::Error)]
pub(super) enum MapError {
    /// Not base64.
    #[error(transparent)]
    Text(#[from] base64::DecodeError),
    /// Bytes that cannot be inflated.
    #[error(transparent)]
    Packed(#[from] DecompressionError),
    /// A number of bytes that differs from what the number of pixels requires.
    #[error("{bytes} bytes for {pixels} pixels")]
    Length { bytes: usize, pixels: usize },
    /// A bit set beyond the last pixel.
    #[error("bits beyond the last pixel")]
    Spare,
}

/// Packs bytes as text.
pub(super) fn packed(bytes: &[u8]) -> String {
    let mut compressor = Compressor::new(CompressionLvl::best());
    let mut packed = vec![0; compressor.deflate_compress_bound(bytes.len())];
    // Compression cannot fail, because there is space for the worst case.
    let length = compressor.deflate_compress(bytes, &mut packed).unwrap_or(0);
    STANDARD.encode(&packed[..length])
}

/// Unpacks this many bytes, for this many pixels.
pub(super) fn unpacked(text: &str, count: usize, pixels: usize) -> Result<Vec<u8>, MapError> {
    let packed = STANDARD.decode(text)?;
    let mut bytes = vec![0; count];
    let length = Decompressor::new().deflate_decompress(&packed, &mut bytes)?;
    if length == count { Ok(bytes) } else { Err(MapError::Length { bytes: length, pixels }) }
}

/// Set of pixels of a picture, row by row: one bit per pixel, the first in the lowest bit of a byte.
#[derive(Clone, Debug, PartialEq, Eq)]
pub(super) struct PixelMap {
    bits: Vec<u8>,
}

impl PixelMap {
    pub(super) fn new(pixels: impl ExactSizeIterator<Item = bool>) -> Self {
        let mut map = Self { bits: vec![0; pixels.len().div_ceil(8)] };
        for (index, _) in pixels.enumerate().filter(|(_, is)| *is) {
            map.bits[index / 8] |= 1 << (index % 8);
        }
        map
    }

    pub(super) fn contains(&self, pixel: usize) -> bool {
        self.bits[pixel / 8] & (1 << (pixel % 8)) != 0
    }

    pub(super) fn count(&self) -> u64 {
        self.bits.iter().map(|byte| u64::from(byte.count_ones())).sum()
    }

    pub(super) fn encode(&self) -> String {
        packed(&self.bits)
    }

    /// Decodes a map of this many pixels.
    pub(super) fn decode(text: &str, pixels: usize) -> Result<Self, MapError> {
        let bits = unpacked(text, pixels.div_ceil(8), pixels)?;
        let spare = bits.len() * 8 - pixels;
        if spare > 0 && bits.last().is_some_and(|last| last >> (8 - spare) != 0) {
            return Err(MapError::Spare);
        }
        Ok(Self { bits })
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn maps_come_back() {
        for pixels in [1, 7, 8, 9, 1000] {
            for every in [1, 2, 3, 2000] {
                let map = PixelMap::new((0..pixels).map(|pixel| pixel % every == every - 1));
                assert_eq!(map.count() as usize, pixels / every);
                assert_eq!(PixelMap::decode(&map.encode(), pixels).as_ref(), Ok(&map));
                assert!(PixelMap::decode(&map.encode(), pixels + 8).is_err());
                assert!((0..pixels).all(|pixel| map.contains(pixel) == (pixel % every == every - 1)));
            }
        }
        assert!(PixelMap::decode(&PixelMap::new([true; 8].into_iter()).encode(), 7).is_err(), "a bit too many");
        assert!(PixelMap::decode("?", 8).is_err());
    }
}
