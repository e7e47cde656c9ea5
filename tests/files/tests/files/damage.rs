//! Damaged files give errors, never panics, and never more memory than the limits allow.

use std::panic::{AssertUnwindSafe, catch_unwind};

use image::{DynamicImage, ImageFormat};
use rand::{Rng, RngExt};

use super::make::{METHODS, Method, Part, SMALL, exr, file, random, read};
use trochoid_io::{Levels, Selection};

/// Returns small valid files of every kind.
fn files() -> Vec<(String, Vec<u8>)> {
    let size = (19, 21);
    let mut files: Vec<(String, Vec<u8>)> = Vec::new();
    for method in METHODS {
        let rows = Part { size, ..Part::new(method) };
        files.push((format!("rows {method}"), exr(&[rows])));
        let tiles = Part { size, ..Part::tiled(method, (8, 8)) };
        files.push((format!("tiles {method}"), exr(&[tiles])));
    }
    for levels in [Levels::Mip, Levels::Rip] {
        let part = Part { size, levels, ..Part::tiled(Method::ZIP16, (8, 8)) };
        files.push((format!("{levels:?}"), exr(&[part])));
    }
    let parts = [
        Part { size, name: Some("one"), ..Part::new(Method::PIZ) },
        Part { size, name: Some("two"), ..Part::tiled(Method::B44, (8, 8)) },
    ];
    files.push(("parts".into(), exr(&parts)));
    let image =
        DynamicImage::ImageRgb8(image::RgbImage::from_fn(17, 9, |x, y| image::Rgb([(x * y) as u8, x as u8, 9])));
    for format in [ImageFormat::Png, ImageFormat::Jpeg, ImageFormat::Tiff] {
        let mut bytes = std::io::Cursor::new(Vec::new());
        image.write_to(&mut bytes, format).unwrap();
        files.push((format!("{format:?}"), bytes.into_inner()));
    }
    files
}

/// Calls all functions that read. Any result is accepted, as long as they return.
fn survive(name: &str, case: &str, bytes: &[u8]) {
    let attempt = catch_unwind(AssertUnwindSafe(|| {
        let file = file(bytes);
        let _ = trochoid_io::info(file.path(), &SMALL);
        let _ = trochoid_io::read_metadata(file.path());
        if let Ok(picture) = trochoid_io::read(file.path(), &Selection::default(), &SMALL) {
            let held: usize = picture.channels.iter().map(|channel| channel.plane.samples().len() * 4).sum();
            assert!(held as u64 <= SMALL.bytes);
        }
    }));
    assert!(attempt.is_ok(), "{name}, {case}: panicked");
}

/// Number of cases for each test and file; the environment variable `TROCHOID_DAMAGE_ROUNDS` sets another.
fn rounds() -> usize {
    std::env::var("TROCHOID_DAMAGE_ROUNDS").ok().and_then(|text| text.parse().ok()).unwrap_or(150)
}

#[test]
fn flipped_bytes() {
    let mut random = random();
    for (name, good) in files() {
        for round in 0..rounds() {
            let mut bytes = good.clone();
            for _ in 0..random.random_range(1..4) {
                let at = random.random_range(0..bytes.len());
                bytes[at] = match random.random_range(0..4) {
                    0 => 0,
                    1 => 0xff,
                    2 => bytes[at] ^ (1 << random.random_range(0..8)),
                    _ => random.next_u32() as u8,
                };
            }
            survive(&name, &format!("round {round}"), &bytes);
        }
    }
}

#[test]
fn cut_short() {
    for (name, good) in files() {
        let step = (good.len() / rounds()).max(1);
        for length in (0..good.len()).step_by(step) {
            survive(&name, &format!("cut to {length}"), &good[..length]);
            if !name.starts_with("Mip")
                && !name.starts_with("Rip")
                && name != "parts"
                && name != "Png"
                && name != "Tiff"
            {
                assert!(read(&good[..length], &Selection::default()).is_err(), "{name}, cut to {length}: read");
            }
        }
    }
}

#[test]
fn words_replaced_by_extremes() {
    let mut random = random();
    for (name, good) in files() {
        for round in 0..rounds() {
            let mut bytes = good.clone();
            let at = random.random_range(0..bytes.len() - 8);
            let word = [0, 1, u64::MAX, i64::MAX as u64, u64::from(u32::MAX), i32::MAX as u64, 1 << 40];
            let word = word[random.random_range(0..word.len())];
            let length = if random.random_bool(0.5) { 4 } else { 8 };
            bytes[at..at + length].copy_from_slice(&word.to_le_bytes()[..length]);
            survive(&name, &format!("round {round} at {at}"), &bytes);
        }
    }
}

#[test]
fn garbage_behind_every_magic_number() {
    let mut random = random();
    for magic in
        [&b"\x76\x2f\x31\x01\x02\0\0\0"[..], b"\x89PNG\r\n\x1a\n", b"\xff\xd8\xff\xe0", b"II*\0", b"MM\0*", b""]
    {
        for round in 0..rounds() {
            let mut bytes = magic.to_vec();
            let mut tail = vec![0; random.random_range(0..400)];
            random.fill_bytes(&mut tail);
            bytes.extend(tail);
            survive("garbage", &format!("{magic:?} round {round}"), &bytes);
        }
    }
}
