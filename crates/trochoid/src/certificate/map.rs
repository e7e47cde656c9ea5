//! Map of the ambiguous pixels: one bit per pixel, deflated, in base64.

use base64::Engine;
use base64::engine::general_purpose::STANDARD;
use libdeflater::{CompressionLvl, Compressor, DecompressionError, Decompressor};

/// Why a text is no map of a picture's pixels.
#[derive(Debug, PartialEq, thiserror::Error)]
pub(super) enum MapError {
    /// It is no base64.
    #[error(transparent)]
    Text(#[from] base64::DecodeError),
    /// Its bytes are not deflated bits.
    #[error(transparent)]
    Packed(#[from] DecompressionError),
    /// It has other bits than the picture has pixels.
    #[error("{bytes} bytes of bits for {pixels} pixels")]
    Length { bytes: usize, pixels: usize },
    /// It marks what is no pixel.
    #[error("bits beyond the last pixel")]
    Spare,
}

/// Set of pixels of a picture, row by row.
#[derive(Clone, Debug, PartialEq, Eq)]
pub(super) struct PixelMap {
    bits: Vec<u8>,
    pixels: usize,
}

impl PixelMap {
    pub(super) fn new(pixels: impl ExactSizeIterator<Item = bool>) -> Self {
        let mut map = Self { bits: vec![0; pixels.len().div_ceil(8)], pixels: pixels.len() };
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
        let mut compressor = Compressor::new(CompressionLvl::best());
        let mut packed = vec![0; compressor.deflate_compress_bound(self.bits.len())];
        // Compression cannot fail, because there is space for the worst case.
        let length = compressor.deflate_compress(&self.bits, &mut packed).unwrap_or(0);
        STANDARD.encode(&packed[..length])
    }

    /// Decodes a map of this many pixels; the error says what is wrong with the text.
    pub(super) fn decode(text: &str, pixels: usize) -> Result<Self, MapError> {
        let packed = STANDARD.decode(text)?;
        let mut bits = vec![0; pixels.div_ceil(8)];
        let length = Decompressor::new().deflate_decompress(&packed, &mut bits)?;
        if length != bits.len() {
            return Err(MapError::Length { bytes: length, pixels });
        }
        let spare = bits.len() * 8 - pixels;
        if spare > 0 && bits.last().is_some_and(|last| last >> (8 - spare) != 0) {
            return Err(MapError::Spare);
        }
        Ok(Self { bits, pixels })
    }

    /// Returns the number of all pixels.
    #[cfg(test)]
    fn len(&self) -> usize {
        self.pixels
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
                assert_eq!(map.len(), pixels);
                assert_eq!(PixelMap::decode(&map.encode(), pixels).as_ref(), Ok(&map));
                assert!(PixelMap::decode(&map.encode(), pixels + 8).is_err());
                assert!((0..pixels).all(|pixel| map.contains(pixel) == (pixel % every == every - 1)));
            }
        }
        assert!(PixelMap::decode(&PixelMap::new([true; 8].into_iter()).encode(), 7).is_err(), "a bit too many");
        assert!(PixelMap::decode("?", 8).is_err());
    }
}
