//! Conversion of chunks' raw samples to rows of a picture.

use super::layout::{Layout, Meaning, Packing, to_bytes};
use crate::SampleType;

impl Layout {
    /// Copies a decoded chunk, or one chunk of each plane, to the row of chunks that it belongs to.
    pub(super) fn place(&self, chunks: &[Vec<u8>], column: usize, rows: usize, band: &mut [u8]) {
        let (pixel, left) = (self.form.pixel(), column * self.chunk[0]);
        let width = self.chunk[0].min(self.form.width as usize - left);
        let mut numbers = vec![0_u32; self.wanted];
        for (y, row) in band.chunks_exact_mut(self.form.row_bytes()).take(rows).enumerate() {
            let out = &mut row[left * pixel..][..width * pixel];
            if let Meaning::YCbCr(steps) = self.meaning {
                match self.packing {
                    Packing::Jpeg => out.copy_from_slice(&chunks[0][y * self.chunk[0] * 3..][..out.len()]),
                    _ => self.light_and_chroma(&chunks[0], steps, y, out),
                }
                continue;
            }
            let raw_row =
                if self.packing == Packing::Jpeg { self.chunk[0] * self.interleaved() } else { self.raw_row() };
            let lines: Vec<&[u8]> = chunks.iter().map(|chunk| &chunk[y * raw_row..][..raw_row]).collect();
            for (x, out) in out.chunks_exact_mut(pixel).enumerate() {
                for (at, number) in numbers.iter_mut().enumerate() {
                    *number = match &lines[..] {
                        [line] if !self.planar => self.sample(line, x * self.samples + at),
                        lines => self.sample(lines[at], x),
                    };
                }
                self.pixel(&numbers, out);
            }
        }
    }

    /// Returns a stored sample: its number, or the bits of an f32 or a half.
    fn sample(&self, line: &[u8], index: usize) -> u32 {
        let bits = self.bits;
        match (bits, self.float) {
            (8, _) => u32::from(line[index]),
            (16, _) => u32::from(u16::from_ne_bytes([line[2 * index], line[2 * index + 1]])),
            (32, _) => line.as_chunks().0.get(index).map_or(0, |bytes| u32::from_ne_bytes(*bytes)),
            (64, true) => {
                line.as_chunks().0.get(index).map_or(0, |bytes| (f64::from_ne_bytes(*bytes) as f32).to_bits())
            }
            (24, true) => {
                let [a, b, c] = [0, 1, 2].map(|byte| line[3 * index + byte]);
                let bytes = if cfg!(target_endian = "big") { [0, a, b, c] } else { [a, b, c, 0] };
                float24(u32::from_ne_bytes(bytes))
            }
            // Packed from the high bits down.
            _ => (index * bits..(index + 1) * bits)
                .fold(0, |sum, at| sum << 1 | u32::from(line[at / 8] >> (7 - at % 8) & 1)),
        }
    }

    /// Converts the stored numbers of a pixel to the form of the picture.
    fn pixel(&self, numbers: &[u32], out: &mut [u8]) {
        let full = if self.bits == 32 { u32::MAX } else { (1 << self.bits.min(31)) - 1 };
        match &self.meaning {
            Meaning::Palette(map) => {
                let entries = map.len() / 3;
                let by = to_bytes(map);
                for (channel, out) in out.chunks_exact_mut(self.form.sample_type.bytes()).enumerate() {
                    let entry = map[channel * entries + (numbers[0] as usize).min(entries - 1)];
                    match by {
                        Some(by) => out[0] = (entry / by) as u8,
                        None => out.copy_from_slice(&entry.to_ne_bytes()),
                    }
                }
            }
            Meaning::Cmyk => {
                let [.., black] = numbers else { return };
                let full = u64::from(full);
                for (ink, out) in numbers.iter().zip(out.chunks_exact_mut(self.form.sample_type.bytes())) {
                    let light = (full - u64::from(*ink)) * (full - u64::from(*black));
                    self.put(((light + full / 2) / full) as u32, full as u32, out);
                }
            }
            meaning => {
                for (index, out) in out.chunks_exact_mut(self.form.sample_type.bytes()).enumerate() {
                    let mut number = numbers[index];
                    if index == 0 && *meaning == (Meaning::Gray { inverted: true }) && !self.float {
                        number = full - number;
                    }
                    self.put(number, full, out);
                }
            }
        }
    }

    fn put(&self, number: u32, full: u32, out: &mut [u8]) {
        let scaled = |most: u64| (u64::from(number) * most + u64::from(full) / 2) / u64::from(full);
        match self.form.sample_type {
            SampleType::U8 => out[0] = scaled(255) as u8,
            SampleType::U16 => out.copy_from_slice(&(scaled(65535) as u16).to_ne_bytes()),
            SampleType::Half => out.copy_from_slice(&(number as u16).to_ne_bytes()),
            _ if self.float => out.copy_from_slice(&number.to_ne_bytes()),
            _ => out.copy_from_slice(&((f64::from(number) / f64::from(full)) as f32).to_ne_bytes()),
        }
    }

    /// Decodes a row of a chunk with subsampled chroma, which stores the luma samples of each block, then Cb and Cr.
    fn light_and_chroma(&self, raw: &[u8], [h, v]: [usize; 2], y: usize, out: &mut [u8]) {
        let block = h * v + 2;
        let row = &raw[y / v * self.chunk[0].div_ceil(h) * block..];
        for (x, out) in out.as_chunks_mut::<3>().0.iter_mut().enumerate() {
            let block = &row[x / h * block..][..block];
            let light = f64::from(block[y % v * h + x % h]);
            let [cb, cr] = [block[h * v], block[h * v + 1]].map(|chroma| f64::from(chroma) - 128.0);
            // Rec. 601 with full range, the defaults of TIFF 6.0.
            let rgb = [light + 1.402 * cr, light - 0.344_136 * cb - 0.714_136 * cr, light + 1.772 * cb];
            *out = rgb.map(|value| value.round().clamp(0.0, 255.0) as u8);
        }
    }
}

/// Converts a 24-bit float (1 sign bit, 7 bits of exponent with bias 63, 16 bits of fraction) to the bits of an f32.
fn float24(bits: u32) -> u32 {
    // 2⁻⁷⁸, a unit of the fraction at the smallest exponent.
    const LEAST: f32 = f32::from_bits((127 - 62 - 16) << 23);
    let (sign, exponent, fraction) = ((bits >> 23 & 1) << 31, bits >> 16 & 0x7f, bits & 0xffff);
    match exponent {
        0 if fraction == 0 => sign,
        0 => sign | (fraction as f32 * LEAST).to_bits(),
        0x7f => sign | 0x7f80_0000 | fraction << 7,
        _ => sign | (exponent + 127 - 63) << 23 | fraction << 7,
    }
}
