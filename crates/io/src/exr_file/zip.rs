//! ZIP and ZIPS: the low and the high bytes of a chunk's 16-bit words are separated, stored as differences, and
//! deflated.
//!
//! A 32-bit sample is two words, low word first.

use libdeflater::{CompressionLvl, Compressor, DecompressionError, Decompressor};

use super::failure::{Failure, WHOLE};
use crate::limits::grow;

/// Compression level of libdeflate. Measured on noisy half RGB, 2 is a fifth faster than 4, OpenEXR's default, and its
/// files are 1.4 % larger; 1 saves as much time again for another 1.2 %, but costs 3.3 % and more on float channels.
const LEVEL: i32 = 2;
/// Offset of stored differences.
const ZERO: u8 = 128;

/// Decoder of compressed chunks with reusable memory.
pub(super) struct Inflater {
    decompressor: Decompressor,
    bytes: Vec<u8>,
}

impl Default for Inflater {
    fn default() -> Self {
        Self { decompressor: Decompressor::new(), bytes: Vec::new() }
    }
}

impl Inflater {
    /// Decodes the words of a chunk of `size` bytes, which has been checked to be possible.
    pub(super) fn inflate(&mut self, packed: &[u8], size: usize) -> Result<Words<'_>, Failure> {
        grow(&mut self.bytes, size).map_err(Failure::Memory)?;
        let bytes = &mut self.bytes[..size];
        match self.decompressor.zlib_decompress(packed, bytes) {
            Ok(found) if found == size => Ok(Words::new(bytes)),
            Ok(found) => Err(Failure::invalid(format!("{found} bytes when inflated"), size.to_string())),
            Err(DecompressionError::InsufficientSpace) => {
                Err(Failure::invalid(format!("more than {size} bytes when inflated"), size.to_string()))
            }
            Err(DecompressionError::BadData) => Err(Failure::invalid("bytes that do not inflate", WHOLE)),
        }
    }
}

/// Reader of an inflated chunk's words from the front.
pub(super) struct Words<'a> {
    low: &'a [u8],
    high: &'a [u8],
    /// Low and high byte of the last word.
    last: [u8; 2],
}

impl<'a> Words<'a> {
    fn new(bytes: &'a [u8]) -> Self {
        let (low, high) = bytes.split_at(bytes.len() / 2);
        // The differences of the high bytes continue from the low ones. Sums of bytes are fast, so both halves are
        // decoded side by side.
        Self { low, high, last: [ZERO, sum(ZERO, low)] }
    }

    /// Takes the next words.
    pub(super) fn take(&mut self, out: &mut [u16]) {
        let (low, high) = self.split_off(out.len());
        let (low_eights, low_rest) = low.as_chunks();
        let (high_eights, high_rest) = high.as_chunks();
        let (out_eights, out_rest) = out.as_chunks_mut();
        let [mut a, mut b] = self.last;
        for ((out, low), high) in out_eights.iter_mut().zip(low_eights).zip(high_eights) {
            *out = eight_words(running(low, &mut a), running(high, &mut b));
        }
        for ((out, low), high) in out_rest.iter_mut().zip(low_rest).zip(high_rest) {
            a = sum(a, &[*low]);
            b = sum(b, &[*high]);
            *out = u16::from_le_bytes([a, b]);
        }
        self.last = [a, b];
    }

    /// Skips words.
    pub(super) fn skip(&mut self, count: usize) {
        let (low, high) = self.split_off(count);
        self.last = [sum(self.last[0], low), sum(self.last[1], high)];
    }

    fn split_off(&mut self, count: usize) -> (&'a [u8], &'a [u8]) {
        let ((low, low_rest), (high, high_rest)) = (self.low.split_at(count), self.high.split_at(count));
        (self.low, self.high) = (low_rest, high_rest);
        (low, high)
    }
}

/// Returns the sum of differences.
fn sum(start: u8, differences: &[u8]) -> u8 {
    differences.iter().fold(start, |sum, byte| sum.wrapping_add(byte ^ ZERO))
}

/// Mask of every other byte of a word.
const BYTES: u64 = 0x00ff_00ff_00ff_00ff;
/// Factor that turns every lane of 16 bits into the sum of the lanes up to it.
const SUMS: u64 = 0x0001_0001_0001_0001;

/// Returns the running sums of eight differences, starting from `last`: those at even and at odd places, in lanes of 16
/// bits.
///
/// Byte by byte, each sum depends on the one before; here eight sums take a single addition. Lanes are wide enough for
/// the sums of nine bytes.
fn running(differences: &[u8; 8], last: &mut u8) -> [u64; 2] {
    let bytes = u64::from_le_bytes(*differences) ^ u64::from_le_bytes([ZERO; 8]);
    let even = (bytes & BYTES).wrapping_mul(SUMS);
    let odd = ((bytes >> 8) & BYTES).wrapping_mul(SUMS);
    let pairs = even.wrapping_add(odd);
    let start = u64::from(*last).wrapping_mul(SUMS);
    *last = last.wrapping_add((pairs >> 48) as u8);
    [even.wrapping_add(odd << 16).wrapping_add(start) & BYTES, pairs.wrapping_add(start) & BYTES]
}

/// Joins low and high bytes, given as even and odd lanes.
fn eight_words(low: [u64; 2], high: [u64; 2]) -> [u16; 8] {
    let [even, odd] = [low[0] | (high[0] << 8), low[1] | (high[1] << 8)];
    std::array::from_fn(|i| ([even, odd][i % 2] >> (16 * (i / 2))) as u16)
}

/// Encoder of compressed chunks with reusable memory.
pub(super) struct Deflater {
    compressor: Compressor,
    bytes: Vec<u8>,
}

impl Default for Deflater {
    fn default() -> Self {
        // An unknown level would fall back to the library's default, 6.
        let level = CompressionLvl::new(LEVEL).unwrap_or_default();
        Self { compressor: Compressor::new(level), bytes: Vec::new() }
    }
}

impl Deflater {
    /// Appends the chunk of these words, unchanged if they do not shrink.
    pub(super) fn deflate(&mut self, words: &[u16], out: &mut Vec<u8>) {
        self.bytes.resize(2 * words.len(), 0);
        differences(words, &mut self.bytes);
        let start = out.len();
        out.resize(start + self.bytes.len(), 0);
        let room = &mut out[start..];
        let shorter = room.len().saturating_sub(1);
        match self.compressor.zlib_compress(&self.bytes, &mut room[..shorter]) {
            Ok(size) => out.truncate(start + size),
            Err(_) => {
                for (bytes, word) in room.as_chunks_mut().0.iter_mut().zip(words) {
                    *bytes = word.to_le_bytes();
                }
            }
        }
    }
}

/// Stores all low bytes, then all high bytes, each as its difference from the one before.
fn differences(words: &[u16], out: &mut [u8]) {
    let (low, high) = out.split_at_mut(words.len());
    let ([low_first, low @ ..], [high_first, high @ ..]) = (low, high) else { return };
    let ([first, rest @ ..], [.., last]) = (words, words) else { return };
    let [[first_low, first_high], [last_low, _]] = [first.to_le_bytes(), last.to_le_bytes()];
    (*low_first, *high_first) = (first_low, first_high.wrapping_sub(last_low) ^ ZERO);
    for (((low, high), before), word) in low.iter_mut().zip(high).zip(words).zip(rest) {
        let [[a, b], [c, d]] = [before.to_le_bytes(), word.to_le_bytes()];
        (*low, *high) = (c.wrapping_sub(a) ^ ZERO, d.wrapping_sub(b) ^ ZERO);
    }
}

#[cfg(test)]
#[path = "zip_tests.rs"]
mod tests;
