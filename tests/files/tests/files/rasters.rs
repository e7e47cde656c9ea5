//! PNG, JPEG and TIFF made by the `image` crate.

use std::io::Cursor;

use image::{DynamicImage, ImageFormat};
use trochoid_image::Window;

use super::make::{SMALL, describe, file, read};
use trochoid_io::{Encoding, Error, FileKind, Limits, SampleType, Selection};

const WIDTH: u32 = 13;
const HEIGHT: u32 = 7;

fn encoded(image: &DynamicImage, format: ImageFormat) -> Vec<u8> {
    let mut bytes = Cursor::new(Vec::new());
    image.write_to(&mut bytes, format).unwrap();
    bytes.into_inner()
}

fn bytes_of(channels: u32) -> Vec<u8> {
    (0..WIDTH * HEIGHT * channels).map(|i| (i * 37 % 251) as u8).collect()
}

fn words_of(channels: u32) -> Vec<u16> {
    (0..WIDTH * HEIGHT * channels).map(|i| (i * 37_001 % 65_521) as u16).collect()
}

macro_rules! picture {
    ($kind:ident, $values:expr) => {
        DynamicImage::$kind(image::ImageBuffer::from_raw(WIDTH, HEIGHT, $values).unwrap())
    };
}

#[test]
fn gray_and_color_of_both_depths() {
    let pictures: [(DynamicImage, &[&str]); 8] = [
        (picture!(ImageLuma8, bytes_of(1)), &["Y"]),
        (picture!(ImageLumaA8, bytes_of(2)), &["Y", "A"]),
        (picture!(ImageRgb8, bytes_of(3)), &["R", "G", "B"]),
        (picture!(ImageRgba8, bytes_of(4)), &["R", "G", "B", "A"]),
        (picture!(ImageLuma16, words_of(1)), &["Y"]),
        (picture!(ImageLumaA16, words_of(2)), &["Y", "A"]),
        (picture!(ImageRgb16, words_of(3)), &["R", "G", "B"]),
        (picture!(ImageRgba16, words_of(4)), &["R", "G", "B", "A"]),
    ];
    for (image, bases) in pictures {
        for (format, kind) in [(ImageFormat::Png, FileKind::Png), (ImageFormat::Tiff, FileKind::Tiff)] {
            if kind == FileKind::Tiff && bases.len() == 2 {
                continue; // the encoder has no gray with alpha
            }
            let bytes = encoded(&image, format);
            let info = describe(&bytes).unwrap();
            assert_eq!((info.kind, info.parts[0].data), (kind, Window::sized(WIDTH, HEIGHT)));
            let picture = read(&bytes, &Selection::default()).unwrap();
            assert_eq!(picture.encoding, Encoding::Srgb);
            let names: Vec<&str> = picture.channels.iter().map(|channel| channel.name.as_str()).collect();
            assert_eq!(names, bases);
            for (index, channel) in picture.channels.iter().enumerate() {
                let expected: Vec<f32> = match channel.sample_type {
                    SampleType::U8 => bytes_of(bases.len() as u32).iter().map(|&v| f32::from(v) / 255.0).collect(),
                    _ => words_of(bases.len() as u32).iter().map(|&v| f32::from(v) / 65535.0).collect(),
                };
                let expected: Vec<f32> = expected.into_iter().skip(index).step_by(bases.len()).collect();
                assert_eq!(channel.plane.samples(), expected, "{kind} {names:?}");
            }
        }
    }
}

#[test]
fn jpeg_is_close_and_must_be_whole() {
    let flat = image::RgbImage::from_pixel(64, 48, image::Rgb([200, 100, 50]));
    let bytes = encoded(&DynamicImage::ImageRgb8(flat), ImageFormat::Jpeg);
    let picture = read(&bytes, &Selection::channels(["b", "R"])).unwrap();
    assert_eq!(picture.channels[0].name, "B");
    assert!((picture.channels[0].plane.samples()[99] - 50.0 / 255.0).abs() < 0.02);
    for cut in [bytes.len() - 2, bytes.len() - 20, bytes.len() / 2, 30] {
        let error = read(&bytes[..cut], &Selection::default()).unwrap_err();
        assert!(matches!(error, Error::Invalid { .. }), "{cut}: {error}");
    }
}

#[test]
fn orientation_is_applied() {
    // An EXIF block with "rotate by 90° clockwise" after the start of the file.
    let exif = b"\xff\xe1\x00\x22Exif\0\0II*\0\x08\0\0\0\x01\0\x12\x01\x03\0\x01\0\0\0\x06\0\0\0\0\0\0\0";
    let image = image::RgbImage::from_fn(64, 32, |x, _| image::Rgb([if x < 32 { 0 } else { 255 }; 3]));
    let mut bytes = encoded(&DynamicImage::ImageRgb8(image), ImageFormat::Jpeg);
    bytes.splice(2..2, exif.iter().copied());
    assert_eq!(describe(&bytes).unwrap().parts[0].data, Window::sized(32, 64));
    let picture = read(&bytes, &Selection::channels(["R"])).unwrap();
    let plane = &picture.channels[0].plane;
    assert!(plane.nearest(16, 4) < 0.1 && plane.nearest(16, 60) > 0.9);
}

#[test]
fn floating_point_tiff_is_linear() {
    let image = DynamicImage::ImageRgb32F(image::ImageBuffer::from_pixel(2, 2, image::Rgb([0.5, 7.25, -1.0])));
    let picture = read(&encoded(&image, ImageFormat::Tiff), &Selection::default()).unwrap();
    assert_eq!((picture.encoding, picture.channels[1].sample_type), (Encoding::Linear, SampleType::Float));
    assert_eq!(picture.channel("G").unwrap().samples(), [7.25; 4]);
}

#[test]
fn huge_claims_are_refused() {
    let image = picture!(ImageRgb8, bytes_of(3));
    let png = encoded(&image, ImageFormat::Png);
    // IHDR with 2³¹ − 1 pixels in each direction and a corrected checksum, as in an attack.
    let mut huge = png.clone();
    huge[16..24].copy_from_slice(&[0x7f, 0xff, 0xff, 0xff, 0x7f, 0xff, 0xff, 0xff]);
    let sum = !huge[12..29].iter().fold(!0_u32, |mut c, &byte| {
        c ^= u32::from(byte);
        (0..8).for_each(|_| c = if c & 1 == 1 { 0xedb8_8320 ^ (c >> 1) } else { c >> 1 });
        c
    });
    huge[29..33].copy_from_slice(&sum.to_be_bytes());
    assert!(!matches!(read(&huge, &Selection::default()), Ok(_) | Err(Error::Io { .. })));
    let tight = Limits { bytes: 100, ..SMALL };
    for format in [ImageFormat::Png, ImageFormat::Tiff, ImageFormat::Jpeg] {
        let file = file(&encoded(&image, format));
        let error = trochoid_io::read(file.path(), &Selection::default(), &tight).unwrap_err();
        assert!(matches!(error, Error::TooLarge { .. } | Error::Unsupported { .. }), "{format:?}: {error}");
    }
}
