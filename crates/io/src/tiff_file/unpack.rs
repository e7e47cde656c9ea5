//! Decompression of chunks to raw samples in native byte order, with the predictor undone.

use libdeflater::{DecompressionError, Decompressor};
use weezl::BitOrder;
use weezl::decode::Decoder;
use zune_jpeg::JpegDecoder;
use zune_jpeg::zune_core::bytestream::ZCursor;
use zune_jpeg::zune_core::colorspace::ColorSpace;
use zune_jpeg::zune_core::options::DecoderOptions;

use super::layout::{Layout, Meaning, Packing};
use crate::raster::JPEG_DENSEST;

/// Error of a chunk that does not decode.
pub(super) struct Damaged;

impl Layout {
    /// Returns whether this many packed bytes can represent a chunk of `size` bytes.
    pub(super) fn can_hold(&self, packed: u64, size: usize) -> bool {
        let densest = match self.packing {
            Packing::None => 1,
            // A run of 128 bytes takes two bytes.
            Packing::PackBits => 64,
            Packing::Deflate => 1032,
            // A code of 12 bits represents at most as many bytes as there are codes.
            Packing::Lzw => 4096 * 8 / 9,
            Packing::Jpeg => JPEG_DENSEST,
        };
        packed.saturating_mul(densest) >= size as u64
    }

    /// Returns the raw samples of a chunk with this many rows.
    pub(super) fn unpack(&self, mut packed: Vec<u8>, rows: usize) -> Result<Vec<u8>, Damaged> {
        let size = self.raw_size(rows);
        if self.reversed && self.packing != Packing::Jpeg {
            packed.iter_mut().for_each(|byte| *byte = byte.reverse_bits());
        }
        let mut raw = match self.packing {
            Packing::None => packed,
            Packing::Deflate => inflate(&packed, size, self.raw_size(self.chunk[1]))?,
            Packing::Lzw => lzw(&packed, size)?,
            Packing::PackBits => pack_bits(&packed, size),
            Packing::Jpeg => return self.jpeg(packed, rows),
        };
        if raw.len() < size {
            return Err(Damaged);
        }
        raw.truncate(size);
        let plain = self.predictor == 1 && self.bits <= 8 || matches!(self.meaning, Meaning::YCbCr(_));
        if !plain {
            for row in raw.chunks_exact_mut(self.raw_row()) {
                self.predict(row);
            }
        }
        Ok(raw)
    }

    /// Undoes the predictor of a row, and converts its samples to native byte order.
    fn predict(&self, row: &mut [u8]) {
        let step = self.interleaved();
        if self.predictor == 3 {
            floats(row, step, self.bits / 8);
            return;
        }
        let native = |bytes: &mut [u8]| {
            if self.big_endian != cfg!(target_endian = "big") {
                bytes.reverse();
            }
        };
        match self.bits {
            8 => {
                for at in step..row.len() {
                    row[at] = row[at].wrapping_add(row[at - step]);
                }
            }
            16 => {
                row.chunks_exact_mut(2).for_each(native);
                differences(row.as_chunks_mut().0, step, self.predictor, |a, b| {
                    u16::from_ne_bytes(a).wrapping_add(u16::from_ne_bytes(b)).to_ne_bytes()
                });
            }
            32 => {
                row.chunks_exact_mut(4).for_each(native);
                differences(row.as_chunks_mut().0, step, self.predictor, |a, b| {
                    u32::from_ne_bytes(a).wrapping_add(u32::from_ne_bytes(b)).to_ne_bytes()
                });
            }
            24 | 64 => row.chunks_exact_mut(self.bits / 8).for_each(native),
            // Samples of other sizes are packed from the high bits down, independent of the byte order.
            _ => {}
        }
    }

    /// Decodes a chunk that is a JPEG picture, except for tables that all chunks share.
    fn jpeg(&self, packed: Vec<u8>, rows: usize) -> Result<Vec<u8>, Damaged> {
        let stream = match (&self.tables[..], &packed[..]) {
            // The end of the tables and the start of the picture are left out.
            ([tables @ .., _, _], [_, _, rest @ ..]) => [tables, rest].concat(),
            _ => packed,
        };
        let mut decoder = JpegDecoder::new(ZCursor::new(stream));
        decoder.decode_headers().map_err(|_| Damaged)?;
        let stored = decoder.input_colorspace().ok_or(Damaged)?;
        let (out, samples) = match self.meaning {
            Meaning::YCbCr(_) => (ColorSpace::RGB, 3),
            _ => (stored, self.interleaved()),
        };
        let (width, height) = decoder.dimensions().ok_or(Damaged)?;
        // Some writers pad blocks; larger pictures would claim memory that no chunk needs.
        let fits = |found: usize, least: usize, most: usize| (least..=most.next_multiple_of(32)).contains(&found);
        let whole = fits(width, self.chunk[0], self.chunk[0]) && fits(height, rows, self.chunk[1]);
        if out.num_components() != samples || !whole {
            return Err(Damaged);
        }
        decoder.set_options(DecoderOptions::default().jpeg_set_out_colorspace(out));
        let pixels = decoder.decode().map_err(|_| Damaged)?;
        let row = self.chunk[0] * samples;
        Ok(pixels.chunks_exact(width * samples).take(rows).flat_map(|line| &line[..row]).copied().collect())
    }
}

/// Undoes differences, where each sample is stored as its difference from the one `step` before.
fn differences<const N: usize>(
    row: &mut [[u8; N]],
    step: usize,
    predictor: u64,
    add: impl Fn([u8; N], [u8; N]) -> [u8; N],
) {
    if predictor == 2 {
        for at in step..row.len() {
            row[at] = add(row[at], row[at - step]);
        }
    }
}

/// Undoes the predictor of floats, which stores all high bytes of a row, then all next ones, as differences from the
/// byte before.
fn floats(row: &mut [u8], step: usize, size: usize) {
    for at in step..row.len() {
        row[at] = row[at].wrapping_add(row[at - step]);
    }
    let planes = row.to_vec();
    let count = planes.len() / size;
    for (index, sample) in row.chunks_exact_mut(size).enumerate() {
        for (byte, out) in sample.iter_mut().rev().enumerate() {
            *out = planes[(size - 1 - byte) * count + index];
        }
        if cfg!(target_endian = "little") {
            sample.reverse();
        }
    }
}

fn inflate(packed: &[u8], size: usize, whole: usize) -> Result<Vec<u8>, Damaged> {
    let mut decompressor = Decompressor::new();
    // Some writers pad the last strip.
    for size in [size, whole] {
        let mut raw = vec![0; size];
        match decompressor.zlib_decompress(packed, &mut raw) {
            Ok(found) => {
                raw.truncate(found);
                return Ok(raw);
            }
            Err(DecompressionError::InsufficientSpace) => {}
            Err(DecompressionError::BadData) => return Err(Damaged),
        }
    }
    Err(Damaged)
}

fn lzw(packed: &[u8], size: usize) -> Result<Vec<u8>, Damaged> {
    let mut decoder = Decoder::with_tiff_size_switch(BitOrder::Msb, 8);
    let mut raw = vec![0; size];
    let (mut read, mut written) = (0, 0);
    while written < size {
        let step = decoder.decode_bytes(&packed[read..], &mut raw[written..]);
        read += step.consumed_in;
        written += step.consumed_out;
        if step.status.is_err() || step.consumed_in == 0 && step.consumed_out == 0 {
            break;
        }
    }
    raw.truncate(written);
    Ok(raw)
}

fn pack_bits(mut packed: &[u8], size: usize) -> Vec<u8> {
    let mut raw = Vec::with_capacity(size);
    while raw.len() < size
        && let [head, rest @ ..] = packed
    {
        packed = rest;
        match *head as i8 {
            -128 => {}
            run @ ..0 => {
                let [byte, rest @ ..] = packed else { break };
                raw.resize(raw.len() + 1 + usize::from(run.unsigned_abs()), *byte);
                packed = rest;
            }
            literal => {
                let count = (1 + usize::from(literal.unsigned_abs())).min(packed.len());
                raw.extend_from_slice(&packed[..count]);
                packed = &packed[count..];
            }
        }
    }
    raw
}
