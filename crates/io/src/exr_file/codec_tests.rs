use rand::{Rng, RngExt, SeedableRng};
use rand_pcg::Pcg64Mcg;

use super::super::zip::Deflater;
use super::*;
use crate::Storage;

fn codec(compression: Compression, sample_type: SampleType, window: Window) -> Codec {
    let layout = Layout::new(window, &Storage::Scanline, compression, false);
    let described = [b"G", b"R"].map(|name| Described { name, sample_type, linear: false });
    Codec::new(compression, &layout, described.into_iter()).unwrap()
}

/// Destination that keeps all words of a chunk, or those of its second channel.
struct Keep {
    words: Vec<u16>,
    second: bool,
}

impl Target for Keep {
    fn row(&mut self, channel: usize, _: usize, words: usize) -> Option<&mut [u16]> {
        if self.second && channel == 0 {
            return None;
        }
        let start = self.words.len();
        self.words.resize(start + words, 0);
        Some(&mut self.words[start..])
    }
}

fn unpack(codec: &Codec, window: Window, packed: &[u8], second: bool) -> Result<Vec<u16>, Failure> {
    let mut keep = Keep { words: Vec::new(), second };
    codec.check(window, packed)?;
    codec.unpack(window, packed, &mut Inflater::default(), &mut keep)?;
    Ok(keep.words)
}

/// Compresses samples with the `exr` crate.
fn pack(codec: &Codec, window: Window, samples: Vec<u8>) -> Vec<u8> {
    codec.header.compression.compress_image_section_to_le(&codec.header, samples, bounds(window)).unwrap()
}

fn to_words(bytes: &[u8]) -> Vec<u16> {
    bytes.as_chunks().0.iter().map(|bytes| u16::from_le_bytes(*bytes)).collect()
}

/// Returns samples of three kinds: constant, smooth, and incompressible noise.
fn samples(random: &mut Pcg64Mcg, size: usize, kind: usize) -> Vec<u8> {
    let mut bytes = vec![60; size];
    match kind {
        0 => {}
        1 => bytes.iter_mut().enumerate().for_each(|(i, byte)| *byte = (i / 7) as u8 ^ random.random_range(0..3)),
        _ => random.fill_bytes(&mut bytes),
    }
    bytes
}

#[test]
fn zip_is_what_the_exr_crate_reads_and_writes() {
    let mut random = Pcg64Mcg::seed_from_u64(7);
    for (width, height) in [(1, 1), (1, 16), (3, 5), (8, 16), (20, 10), (67, 16), (501, 3)] {
        for (compression, sample_type) in [
            (Compression::Zip, SampleType::Half),
            (Compression::Zips, SampleType::Half),
            (Compression::Zip, SampleType::Float),
            (Compression::Zip, SampleType::Uint),
        ] {
            let window = Window::sized(width, if compression == Compression::Zips { 1 } else { height });
            for kind in 0..3 {
                let codec = codec(compression, sample_type, window);
                let raw = samples(&mut random, codec.raw_size(window), kind);
                let words = to_words(&raw);
                assert_eq!(unpack(&codec, window, &pack(&codec, window, raw.clone()), false).unwrap(), words);
                let mut ours = b"before".to_vec();
                Deflater::default().deflate(&words, &mut ours);
                let ours = ours.strip_prefix(b"before").unwrap();
                assert!(ours.len() <= raw.len());
                assert_eq!(codec.decompress(window, ours.to_vec()).unwrap(), raw);
                assert_eq!(unpack(&codec, window, ours, false).unwrap(), words);
                let row = width as usize * sample_type.bytes() / 2;
                let second: Vec<u16> = words.chunks(2 * row).flat_map(|rows| &rows[row..]).copied().collect();
                assert_eq!(unpack(&codec, window, ours, true).unwrap(), second);
            }
        }
    }
}

#[test]
fn hostile_zip_is_refused_like_the_exr_crate_does_or_sooner() {
    let mut random = Pcg64Mcg::seed_from_u64(8);
    let window = Window::sized(40, 16);
    let codec = codec(Compression::Zip, SampleType::Half, window);
    let good = pack(&codec, window, samples(&mut random, codec.raw_size(window), 1));
    for round in 0..3000 {
        let mut bytes = good.clone();
        match round % 3 {
            0 => bytes.truncate(random.random_range(0..bytes.len())),
            1 => {
                let at = random.random_range(0..bytes.len());
                bytes[at] ^= 1 << random.random_range(0..8);
            }
            _ => random.fill_bytes(&mut bytes[2..]),
        }
        // The other decoder accepts the same chunks, with the same result.
        if let Ok(words) = unpack(&codec, window, &bytes, false) {
            assert_eq!(words, to_words(&codec.decompress(window, bytes).unwrap()), "round {round}");
        }
    }
}

#[test]
fn zip_of_the_wrong_size_is_refused() {
    let window = Window::sized(40, 16);
    let codec = codec(Compression::Zip, SampleType::Half, window);
    let message = |words: &[u16]| {
        let mut bytes = Vec::new();
        Deflater::default().deflate(words, &mut bytes);
        match unpack(&codec, window, &bytes, false) {
            Err(Failure::Invalid { found, expected }) => format!("{found}, {expected}"),
            other => panic!("{other:?}"),
        }
    };
    assert_eq!(message(&[1; 1279]), "2558 bytes when inflated, 2560");
    assert_eq!(message(&[1; 1281]), "more than 2560 bytes when inflated, 2560");
    // A few bytes that claim to be a chunk of gigabytes are refused before memory is taken.
    let huge = Window::sized(1 << 20, 16);
    assert!(matches!(unpack(&codec, huge, &[0x78; 600], false), Err(Failure::Invalid { .. })));
}

#[test]
fn claims_of_dwa_counters_are_held_against_the_pixels() {
    let window = Window::sized(20, 10);
    let codec = codec(Compression::Dwaa, SampleType::Half, window);
    let packed = pack(&codec, window, vec![60; codec.raw_size(window)]);
    assert!(unpack(&codec, window, &packed, false).is_ok());
    for counter in [1, 6, 7, 8, 9] {
        for claim in [1 << 40, i64::MAX as u64, u64::MAX] {
            let mut bytes = packed.clone();
            bytes[8 * counter..][..8].copy_from_slice(&claim.to_le_bytes());
            let found = unpack(&codec, window, &bytes, false);
            assert!(
                matches!(&found, Err(Failure::Invalid { expected, .. }) if expected.starts_with("at most")),
                "{found:?}"
            );
        }
    }
    assert!(unpack(&codec, window, &[0; 20], false).is_err());
}

#[test]
fn chunks_of_absurd_size_are_refused() {
    let window = Window::sized(20, 1);
    for compression in [Compression::None, Compression::Zip, Compression::Piz] {
        let codec = codec(compression, SampleType::Float, window);
        let size = codec.raw_size(window);
        for length in [0, size + 1] {
            assert!(matches!(unpack(&codec, window, &vec![0; length], false), Err(Failure::Invalid { .. })));
        }
        assert!(unpack(&codec, window, &vec![0; size], false).is_ok());
    }
}

#[test]
fn damaged_b44_blocks_are_an_error_or_garbage_but_no_panic() {
    let window = Window::sized(20, 10);
    let codec = codec(Compression::B44, SampleType::Half, window);
    for byte in [0x40, 0x01, 0xf8, 0xff] {
        if let Ok(words) = unpack(&codec, window, &[byte; 500], false) {
            assert_eq!(2 * words.len(), codec.raw_size(window), "{byte:#x}");
        }
    }
}
