//! TIFFs of rare kinds, written here tag by tag, compared with the values that were put in.

use half::f16;

use super::make::read;
use trochoid_io::{Encoding, Error, SampleType, Selection};

const WIDTH: usize = 19;
const HEIGHT: usize = 11;

/// TIFF with these tags and chunks; `big` uses the offsets of BigTIFF.
#[derive(Clone, Default)]
struct Tiff {
    big: bool,
    tags: Vec<(u16, Vec<u64>)>,
    chunks: Vec<Vec<u8>>,
    tiled: bool,
}

impl Tiff {
    fn new(photometric: u64, samples: u64, bits: u64) -> Self {
        let tags = [(256, WIDTH as u64), (257, HEIGHT as u64), (258, bits), (262, photometric), (277, samples)];
        Self { tags: tags.map(|(tag, value)| (tag, vec![value])).to_vec(), ..Self::default() }
    }

    fn tag(mut self, tag: u16, values: impl Into<Vec<u64>>) -> Self {
        self.tags.push((tag, values.into()));
        self
    }

    fn chunk(mut self, bytes: impl Into<Vec<u8>>) -> Self {
        self.chunks.push(bytes.into());
        self
    }

    /// Little-endian bytes.
    fn bytes(&self) -> Vec<u8> {
        let word = if self.big { 8 } else { 4 };
        let mut out = if self.big { b"II+\0\x08\0\0\0".to_vec() } else { b"II*\0".to_vec() };
        let start = out.len();
        out.resize(start + word, 0);
        let mut tags = self.tags.clone();
        let mut offsets = Vec::new();
        for chunk in &self.chunks {
            offsets.push(out.len() as u64);
            out.extend_from_slice(chunk);
        }
        let (places, lengths) = if self.tiled { (324, 325) } else { (273, 279) };
        tags.push((places, offsets));
        tags.push((lengths, self.chunks.iter().map(|chunk| chunk.len() as u64).collect()));
        tags.sort();
        let mut entries = Vec::new();
        for (tag, values) in &tags {
            // As numbers of 32 bits.
            let bytes: Vec<u8> = values.iter().flat_map(|value| (*value as u32).to_le_bytes()).collect();
            entries.extend(tag.to_le_bytes());
            entries.extend(4_u16.to_le_bytes());
            entries.extend(&(values.len() as u64).to_le_bytes()[..word]);
            let mut value = bytes.clone();
            if bytes.len() > word {
                value = out.len().to_le_bytes().to_vec();
                out.extend(bytes);
            }
            value.resize(word, 0);
            entries.extend(value);
        }
        let directory = out.len() as u64;
        out[start..start + word].copy_from_slice(&directory.to_le_bytes()[..word]);
        out.extend(&(tags.len() as u64).to_le_bytes()[..if self.big { 8 } else { 2 }]);
        out.extend(entries);
        out.extend(vec![0; word]);
        out
    }
}

/// Returns different numbers below `most`, one for each sample.
fn numbers(count: usize, most: usize) -> Vec<u32> {
    (0..WIDTH * HEIGHT * count).map(|i| (i * 7919 % most) as u32).collect()
}

fn refused(tiff: &Tiff) -> String {
    let error = read(&tiff.bytes(), &Selection::default()).unwrap_err();
    assert!(matches!(error, Error::Unsupported { .. }), "{error}");
    error.to_string()
}

/// Returns the samples of the picture, pixel by pixel.
fn samples(tiff: &Tiff) -> (Vec<f32>, Encoding, SampleType) {
    let picture = read(&tiff.bytes(), &Selection::default()).unwrap();
    let planes: Vec<&[f32]> = picture.channels.iter().map(|channel| channel.plane.samples()).collect();
    let pixels = (0..planes[0].len()).flat_map(|at| planes.iter().map(move |plane| plane[at])).collect();
    (pixels, picture.encoding, picture.channels[0].sample_type)
}

fn close(found: &[f32], expected: impl Iterator<Item = f64>, within: f64) {
    let expected: Vec<f64> = expected.collect();
    assert_eq!(found.len(), expected.len());
    for (at, (found, expected)) in found.iter().zip(expected).enumerate() {
        assert!((f64::from(*found) - expected).abs() <= within, "sample {at}: {found} and {expected}");
    }
}

#[test]
fn floats_of_all_sizes_as_they_are() {
    let values: Vec<f32> = numbers(2, 509).iter().map(|n| *n as f32 / 16.0 - 8.0).collect();
    let plain = |bits: u64| Tiff::new(1, 2, bits).tag(339, [3]).tag(338, [2]);
    let half: Vec<u8> = values.iter().flat_map(|v| f16::from_f32(*v).to_le_bytes()).collect();
    let single: Vec<u8> = values.iter().flat_map(|v| v.to_le_bytes()).collect();
    let double: Vec<u8> = values.iter().flat_map(|v| f64::from(*v).to_le_bytes()).collect();
    // 16 of the 23 bits of the fraction, and an exponent around 63.
    let short = |v: &f32| match v.to_bits() {
        0 => [0; 3],
        bits => {
            let exponent = (bits >> 23 & 0xff) + 63 - 127;
            let short = (bits >> 31) << 23 | exponent << 16 | bits >> 7 & 0xffff;
            [short as u8, (short >> 8) as u8, (short >> 16) as u8]
        }
    };
    let three: Vec<u8> = values.iter().flat_map(short).collect();
    for (bits, bytes, kind) in [
        (16, half, SampleType::Half),
        (24, three, SampleType::Float),
        (32, single.clone(), SampleType::Float),
        (64, double, SampleType::Float),
    ] {
        assert_eq!(samples(&plain(bits).chunk(bytes)), (values.clone(), Encoding::Linear, kind), "{bits} bits");
    }
    // Predictor 3: the bytes of a row are separated, high bytes first, and stored as differences.
    let mut apart = Vec::new();
    for row in single.chunks_exact(WIDTH * 8) {
        let count = row.len() / 4;
        let line: Vec<u8> = (0..row.len()).map(|at| row[at % count * 4 + 3 - at / count]).collect();
        apart.extend((0..line.len()).map(|at| if at < 2 { line[at] } else { line[at].wrapping_sub(line[at - 2]) }));
    }
    assert_eq!(samples(&plain(32).tag(317, [3]).chunk(apart)).0, values);
}

#[test]
fn bits_are_packed_from_the_high_ones_down() {
    for bits in [1, 2, 4, 6, 10, 12] {
        let most = 1 << bits;
        let values = numbers(1, most);
        let mut bytes = Vec::new();
        for row in values.chunks_exact(WIDTH) {
            let bits = row.iter().flat_map(|v| (0..bits).rev().map(move |bit| v >> bit & 1));
            let bits: Vec<u32> = bits.collect();
            bytes.extend(
                bits.chunks(8).map(|eight| eight.iter().enumerate().fold(0, |b, (i, v)| b | (*v as u8) << (7 - i))),
            );
        }
        let tiff = Tiff::new(1, 1, bits as u64).chunk(bytes.clone());
        let full = f64::from(most as u32 - 1);
        let within = if bits <= 8 { 0.5 / 255.0 } else { 0.5 / 65535.0 };
        let expected = || values.iter().map(|v| f64::from(*v) / full);
        close(&samples(&tiff).0, expected(), within + 1e-7);
        assert_eq!(samples(&tiff).1, Encoding::Srgb);
        let inverted = Tiff::new(0, 1, bits as u64).chunk(bytes.clone());
        close(&samples(&inverted).0, expected().map(|v| 1.0 - v), within + 1e-7);
        let turned: Vec<u8> = bytes.iter().map(|byte| byte.reverse_bits()).collect();
        assert_eq!(samples(&tiff.clone()), samples(&Tiff::new(1, 1, bits as u64).tag(266, [2]).chunk(turned)));
    }
}

#[test]
fn palettes_cmyk_and_chroma_become_rgb() {
    let values = numbers(1, 256);
    let bytes: Vec<u8> = values.iter().map(|v| *v as u8).collect();
    for (by, kind) in [(257, SampleType::U8), (256, SampleType::U8), (1, SampleType::U8), (251, SampleType::U16)] {
        let map: Vec<u64> = (0..768_u64).map(|i| i * 31 % 256 * by).collect();
        let tiff = Tiff::new(3, 1, 8).tag(320, map.clone()).chunk(bytes.clone());
        let full = if kind == SampleType::U16 { 65535.0 } else { by as f64 * 255.0 };
        let entry = |v: u32, channel: usize| map[channel * 256 + v as usize] as f64 / full;
        let (found, _, stored) = samples(&tiff);
        assert_eq!(stored, kind);
        close(&found, values.iter().flat_map(|v| [0, 1, 2].map(|channel| entry(*v, channel))), 1e-6);
    }
    let inks = numbers(4, 256);
    let tiff = Tiff::new(5, 4, 8).chunk(inks.iter().map(|v| *v as u8).collect::<Vec<_>>());
    let light = |v: u32| 1.0 - f64::from(v) / 255.0;
    let expected = inks.chunks_exact(4).flat_map(|p| [0, 1, 2].map(|ink| light(p[ink]) * light(p[3])));
    close(&samples(&tiff).0, expected, 0.5 / 255.0 + 1e-6);

    // For each block of 2 × 2 pixels: its luma samples, then Cb and Cr.
    let (across, down) = (WIDTH.div_ceil(2), HEIGHT.div_ceil(2));
    let block =
        |at: usize| [at * 3, at * 5 + 1, at * 7 + 2, at * 11 + 3, 100 + at % 50, 140 - at % 30].map(|v| v as u8);
    let raw: Vec<u8> = (0..across * down).flat_map(block).collect();
    let expected = (0..WIDTH * HEIGHT).flat_map(|at| {
        let (x, y) = (at % WIDTH, at / WIDTH);
        let block = block(y / 2 * across + x / 2).map(f64::from);
        let (light, cb, cr) = (block[y % 2 * 2 + x % 2], block[4] - 128.0, block[5] - 128.0);
        [light + 1.402 * cr, light - 0.344_136 * cb - 0.714_136 * cr, light + 1.772 * cb]
            .map(|v| v.clamp(0.0, 255.0) / 255.0)
    });
    close(&samples(&Tiff::new(6, 3, 8).tag(530, [2, 2]).chunk(raw)).0, expected, 0.5 / 255.0 + 1e-6);
}

#[test]
fn tiles_strips_planes_and_methods_hold_the_same() {
    let values = numbers(4, 256);
    let plain: Vec<u8> = values.iter().map(|v| *v as u8).collect();
    let expected = samples(&Tiff::new(2, 4, 8).tag(338, [2]).chunk(plain.clone()));
    close(&expected.0, values.iter().map(|v| f64::from(*v) / 255.0), 1e-7);

    let at = |x: usize, y: usize, s: usize| if x < WIDTH && y < HEIGHT { plain[(y * WIDTH + x) * 4 + s] } else { 0 };
    let mut tiles = Tiff { tiled: true, big: true, ..Tiff::new(2, 4, 8).tag(338, [2]).tag(322, [16]).tag(323, [8]) };
    let mut planes =
        Tiff { tiled: true, ..Tiff::new(2, 4, 8).tag(338, [2]).tag(322, [16]).tag(323, [8]).tag(284, [2]) };
    let corners = [(0, 0), (16, 0), (0, 8), (16, 8)];
    let places = |(x0, y0): (usize, usize)| (0..128).map(move |i| (x0 + i % 16, y0 + i / 16));
    for corner in corners {
        tiles = tiles.chunk(places(corner).flat_map(|(x, y)| [0, 1, 2, 3].map(|s| at(x, y, s))).collect::<Vec<_>>());
    }
    for s in 0..4 {
        for corner in corners {
            planes = planes.chunk(places(corner).map(|(x, y)| at(x, y, s)).collect::<Vec<_>>());
        }
    }
    assert_eq!(samples(&tiles), expected);
    assert_eq!(samples(&planes), expected);

    // Rows of literals of at most 128 bytes; and runs.
    let literal = |bytes: &[u8]| bytes.chunks(128).flat_map(|c| [&[c.len() as u8 - 1], c].concat()).collect::<Vec<_>>();
    assert_eq!(samples(&Tiff::new(2, 4, 8).tag(338, [2]).tag(259, [32773]).chunk(literal(&plain))), expected);
    let mut runs = Tiff::new(1, 1, 8).tag(259, [32773]).tag(278, [4]);
    for rows in [4, 4, 3] {
        let mut left = WIDTH * rows;
        let mut bytes = vec![0x80];
        while left > 0 {
            let run = left.min(128);
            bytes.extend(if run == 1 { [0, 9] } else { [(257 - run) as u8, 9] });
            left -= run;
        }
        runs = runs.chunk(bytes);
    }
    assert_eq!(samples(&runs).0, [9.0 / 255.0; WIDTH * HEIGHT]);

    let lzw = |bytes: &[u8]| {
        let mut encoder = weezl::encode::Encoder::with_tiff_size_switch(weezl::BitOrder::Msb, 8);
        encoder.encode(bytes).unwrap()
    };
    let deflated = |bytes: &[u8]| {
        let mut compressor = libdeflater::Compressor::new(libdeflater::CompressionLvl::default());
        let mut out = vec![0; compressor.zlib_compress_bound(bytes.len())];
        let length = compressor.zlib_compress(bytes, &mut out).unwrap();
        out[..length].to_vec()
    };
    let differences: Vec<u8> = plain
        .chunks_exact(WIDTH * 4)
        .flat_map(|row| (0..row.len()).map(|at| if at < 4 { row[at] } else { row[at].wrapping_sub(row[at - 4]) }))
        .collect();
    for (method, pack) in [(5, &lzw as &dyn Fn(&[u8]) -> Vec<u8>), (8, &deflated)] {
        let tiff = Tiff::new(2, 4, 8).tag(338, [2]).tag(259, [method]);
        assert_eq!(samples(&tiff.clone().chunk(pack(&plain))), expected, "method {method}");
        assert_eq!(samples(&tiff.tag(317, [2]).chunk(pack(&differences))), expected, "method {method}");
    }
}

#[test]
fn what_is_not_read_is_named() {
    let method = |number: u64| refused(&Tiff::new(1, 1, 8).tag(259, [number]).chunk([0; 9]));
    for (number, name) in
        [(4, "CCITT G4"), (3, "CCITT G3"), (6, "old-style JPEG"), (50000, "Zstandard"), (24, "method 24")]
    {
        let message = method(number);
        assert!(message.contains(name) && message.contains("oiiotool"), "{message}");
    }
    assert!(refused(&Tiff::new(32845, 3, 16).chunk([0; 9])).contains("LogLuv"));
    assert!(refused(&Tiff::new(8, 3, 8).chunk([0; 9])).contains("L*a*b*"));
    assert!(refused(&Tiff::new(1, 1, 16).tag(339, [2]).chunk([0; 9])).contains("signed"));
}

#[test]
fn claims_are_held_against_the_file() {
    let invalid = |tiff: &Tiff| {
        let error = read(&tiff.bytes(), &Selection::default()).unwrap_err();
        assert!(matches!(error, Error::Invalid { .. }), "{error}");
    };
    // Chunks that extend beyond the file, too few bytes, chunks that are not listed.
    let plain = Tiff::new(1, 1, 8).chunk(vec![0; WIDTH * HEIGHT]);
    let mut cut = plain.bytes();
    let at = cut.windows(2).position(|pair| pair == [0x17, 1]).unwrap();
    cut[at + 8..at + 12].copy_from_slice(&u32::MAX.to_le_bytes());
    assert!(read(&cut, &Selection::default()).is_ok(), "uncompressed data have their own size");
    invalid(&Tiff::new(1, 1, 8).chunk(vec![0; WIDTH]));
    invalid(&Tiff::new(1, 1, 8).tag(278, [1]).chunk(vec![0; WIDTH * HEIGHT]));
    // A few bytes that claim to be many, for each method.
    for method in [1, 5, 7, 8, 32773] {
        let mut huge = Tiff::new(2, 3, 16).tag(259, [method]).chunk(vec![0x78; 40]);
        huge.tags[0].1 = vec![600];
        huge.tags[1].1 = vec![600];
        if method == 7 {
            huge.tags[2].1 = vec![8];
        }
        invalid(&huge);
    }
}
