//! Writing of PNG with metadata as text.

mod text;

use std::path::Path;

use image::codecs::png::{CompressionType, FilterType, PngEncoder};
use image::{ExtendedColorType, ImageEncoder};
use rayon::prelude::*;

pub(crate) use text::{check_whole, read_text, readable_text};

use crate::{Error, Samples, Target};

/// Picture to write as PNG, with display-encoded values from 0 to 1.
#[derive(Clone, Debug)]
pub struct PngImage<'a> {
    /// Width in pixels.
    pub width: u32,
    /// Height in pixels.
    pub height: u32,
    /// Gray, gray and alpha, RGB, or RGBA: one to four channels of width × height samples.
    pub channels: Vec<Samples<'a>>,
    /// Whether values outside 0 to 1 are clamped; otherwise they are refused. NaN is always refused.
    pub clamp: bool,
    /// Keywords and texts, in order; keywords have 1 to 79 printable Latin-1 characters.
    pub metadata: Vec<(String, String)>,
}

impl<'a> PngImage<'a> {
    /// Creates a picture without metadata that refuses values outside 0 to 1.
    pub fn new(width: u32, height: u32, channels: impl Into<Vec<Samples<'a>>>) -> Self {
        Self { width, height, channels: channels.into(), clamp: false, metadata: Vec::new() }
    }
}

const COLORS_8: [ExtendedColorType; 4] =
    [ExtendedColorType::L8, ExtendedColorType::La8, ExtendedColorType::Rgb8, ExtendedColorType::Rgba8];

/// Writes 8 bits per channel, rounded to nearest, atomically and marked as sRGB.
///
/// ```
/// use trochoid_io::{Limits, PngImage, Samples, Selection, read, write_png8};
/// let folder = tempfile::tempdir()?;
/// let path = folder.path().join("swatch.png");
/// write_png8(&path, &PngImage::new(2, 1, Samples::rgb(&[[1.0, 0.0, 0.2], [0.0, 0.4, 1.0]])))?;
/// let picture = read(&path, &Selection::default(), &Limits::default())?;
/// assert_eq!(picture.channel("B").map(|plane| plane.samples()), Some(&[0.2, 1.0][..]));
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
///
/// # Errors
/// The samples do not fill the picture, a value is NaN, or outside 0 to 1 without `clamp`, the metadata do not fit PNG,
/// or the file cannot be written. An existing file is then left as it was.
pub fn write_png8(target: impl Into<Target>, image: &PngImage<'_>) -> Result<(), Error> {
    let target = target.into();
    let path = target.path();
    let bytes = quantize(path, image, eight_bits)?;
    write(&target, image, &bytes, COLORS_8)
}

/// Encodes a file with 8 bits per channel, rounded to nearest, marked as sRGB.
///
/// # Errors
/// As [`write_png8`], except that nothing is written.
pub fn encode_png8(image: &PngImage<'_>) -> Result<Vec<u8>, Error> {
    let path = Path::new("a picture in memory");
    let bytes = quantize(path, image, eight_bits)?;
    encode(path, image, &bytes, COLORS_8)
}

/// Writes 16 bits per channel, rounded to nearest, atomically and marked as sRGB.
///
/// # Errors
/// As [`write_png8`].
pub fn write_png16(target: impl Into<Target>, image: &PngImage<'_>) -> Result<(), Error> {
    let target = target.into();
    let path = target.path();
    let bytes = quantize(path, image, sixteen_bits)?;
    let colors = [ExtendedColorType::L16, ExtendedColorType::La16, ExtendedColorType::Rgb16, ExtendedColorType::Rgba16];
    write(&target, image, &bytes, colors)
}

/// Rounds a value from 0 to 1 to the nearest of 8 bits; one in the middle, up. Products and sums are exact.
#[inline]
fn eight_bits(value: f32) -> [u8; 1] {
    [(f64::from(value) * 255.0 + 0.5) as u8]
}

/// Does the same with 16 bits.
#[inline]
fn sixteen_bits(value: f32) -> [u8; 2] {
    ((f64::from(value) * 65535.0 + 0.5) as u16).to_ne_bytes()
}

/// Pixels that a thread rounds at a time.
const BAND: usize = 1 << 16;

/// Checks every value and stores it, pixel by pixel.
fn quantize<const N: usize>(
    path: &Path,
    image: &PngImage<'_>,
    round: impl Fn(f32) -> [u8; N] + Sync,
) -> Result<Vec<u8>, Error> {
    let count = image.channels.len();
    let area = image.width as usize * image.height as usize;
    if !(1..=4).contains(&count) || area == 0 {
        let found = format!("a PNG of {} × {} pixels with {count} channels", image.width, image.height);
        return Err(Error::unwritable(path, found, "it has at least one pixel and 1 to 4 channels"));
    }
    for (index, samples) in image.channels.iter().enumerate() {
        if samples.len() != area {
            let found = format!("channel {} with {} samples for {area} pixels", name(count, index), samples.len());
            return Err(Error::unwritable(path, found, "pass one sample per pixel"));
        }
    }
    let mut bytes = crate::limits::reserve(path, "the picture", area * count * N)?;
    bytes.resize(area * count * N, 0);
    let rounded = |(band, bytes): (usize, &mut [u8])| {
        let (first, pixels) = (band * BAND, bytes.len() / (count * N));
        let (mut gathered, mut is_legal) = (Vec::new(), true);
        for (index, samples) in image.channels.iter().enumerate() {
            let to = bytes.as_chunks_mut::<N>().0.iter_mut().skip(index).step_by(count);
            for (to, value) in to.zip(samples.row(first, pixels, &mut gathered)) {
                is_legal &= image.stores(*value);
                *to = round(value.clamp(0.0, 1.0));
            }
        }
        is_legal
    };
    let bands = bytes.par_chunks_mut(BAND * count * N).enumerate();
    if !bands.map(rounded).reduce(|| true, |a, b| a & b) {
        return Err(image.refused(path));
    }
    Ok(bytes)
}

impl PngImage<'_> {
    /// Returns whether a value can be stored.
    #[inline]
    fn stores(&self, value: f32) -> bool {
        (0.0..=1.0).contains(&value) || (self.clamp && !value.is_nan())
    }

    /// Names the first value that cannot be stored.
    fn refused(&self, path: &Path) -> Error {
        let (count, width) = (self.channels.len(), self.width as usize);
        let all = (0..width * self.height as usize).flat_map(|pixel| (0..count).map(move |index| (pixel, index)));
        let with_value = all.map(|(pixel, index)| (pixel, index, self.channels[index].get(pixel).unwrap_or(f32::NAN)));
        let (pixel, index, value) = { with_value }.find(|(.., value)| !self.stores(*value)).unwrap_or((0, 0, f32::NAN));
        Error::Unrepresentable {
            path: path.into(),
            channel: name(count, index).into(),
            x: (pixel % width) as i64,
            y: (pixel / width) as i64,
            value,
            expected: if value.is_nan() {
                "a number; find the node that makes NaN"
            } else {
                "0 to 1; write EXR, which holds any value"
            },
        }
    }
}

fn name(count: usize, index: usize) -> &'static str {
    let names: &[&str] = if count < 3 { &["Y", "A"] } else { &["R", "G", "B", "A"] };
    names.get(index).copied().unwrap_or("?")
}

fn write(target: &Target, image: &PngImage<'_>, bytes: &[u8], colors: [ExtendedColorType; 4]) -> Result<(), Error> {
    crate::write_bytes(target.clone(), &encode(target.path(), image, bytes, colors)?)
}

fn encode(path: &Path, image: &PngImage<'_>, bytes: &[u8], colors: [ExtendedColorType; 4]) -> Result<Vec<u8>, Error> {
    let text = text::chunks(path, &image.metadata)?;
    let mut png = Vec::new();
    let color = colors[image.channels.len() - 1];
    // One filter for all rows: choosing among them takes up to 1.7 times as long, for files of about the same size.
    PngEncoder::new_with_quality(&mut png, CompressionType::Fast, FilterType::Paeth)
        .write_image(bytes, image.width, image.height, color)
        .map_err(|error| {
            Error::unwritable(path, format!("a picture that the PNG encoder refuses ({error})"), "a smaller one")
        })?;
    // Text is written before the pixels, so that reading it does not have to skip them.
    let (head, pixels) = png.split_at(text::HEADER.min(png.len()));
    Ok([head, &text, pixels].concat())
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::{Limits, Selection, read, read_metadata};

    #[test]
    fn every_value_of_both_depths_survives() {
        let folder = tempfile::tempdir().expect("a folder");
        let path = folder.path().join("a.png");
        for (steps, write) in [(255_u16, write_png8 as fn(_, &PngImage<'_>) -> _), (65535, write_png16)] {
            let values: Vec<f32> = (0..=steps).map(|v| f32::from(v) / f32::from(steps)).collect();
            let (width, height) = (256, values.len() as u32 / 256);
            let reversed: Vec<f32> = values.iter().rev().copied().collect();
            let channels = [Samples::contiguous(&values), Samples::contiguous(&reversed), Samples::contiguous(&values)];
            for count in 1..=3 {
                write(&path, &PngImage::new(width, height, &channels[..count])).expect("written");
                let picture = read(&path, &Selection::default(), &Limits::default()).expect("read");
                assert_eq!(picture.channels.len(), count);
                assert_eq!(picture.channels[0].plane.samples(), values);
                if count > 1 {
                    assert_eq!(picture.channels[1].plane.samples(), reversed);
                }
            }
        }
    }

    #[test]
    fn values_outside_are_refused_with_their_place_or_clamped() {
        let folder = tempfile::tempdir().expect("a folder");
        let path = folder.path().join("a.png");
        std::fs::write(&path, "old").expect("written");
        for bad in [1.0001, -0.1, f32::INFINITY, f32::NAN] {
            let pixels = [[0.0, 0.5, 1.0], [0.1, 0.2, bad]];
            let mut image = PngImage::new(1, 2, Samples::rgb(&pixels));
            let error = write_png8(&path, &image).expect_err("refused");
            assert!(matches!(&error, Error::Unrepresentable { channel, x: 0, y: 1, .. } if channel == "B"), "{error}");
            assert_eq!(std::fs::read(&path).expect("there"), b"old");
            image.clamp = true;
            assert_eq!(write_png8(folder.path().join("b.png"), &image).is_ok(), !bad.is_nan());
        }
    }

    #[test]
    fn metadata_come_back_in_order() {
        let folder = tempfile::tempdir().expect("a folder");
        let path = folder.path().join("a.png");
        let pairs = [("trochoid:frame", "17"), ("Title", "stürmische See 波"), ("empty", ""), ("Größe", "é")];
        let metadata: Vec<(String, String)> = pairs.map(|(k, v)| (k.into(), v.into())).to_vec();
        let mut image = PngImage::new(1, 1, Samples::rgb(&[[0.0; 3]]));
        image.metadata = metadata.clone();
        write_png16(&path, &image).expect("written");
        assert_eq!(read_metadata(&path).expect("read"), metadata);
        for key in ["", "波", " a", "a\nb", &"x".repeat(80)] {
            image.metadata = vec![(key.into(), String::new())];
            assert!(matches!(write_png8(&path, &image), Err(Error::Unwritable { .. })), "{key:?}");
        }
        image.metadata = vec![("a".into(), "nul\0".into())];
        assert!(write_png8(&path, &image).is_err());
        assert_eq!(read_metadata(&path).expect("still there"), metadata);
    }

    #[test]
    fn samples_must_fill_the_picture() {
        let path = Path::new("never.png");
        for image in [
            PngImage::new(2, 2, [Samples::contiguous(&[0.0; 3])]),
            PngImage::new(0, 2, [Samples::contiguous(&[])]),
            PngImage::new(1, 1, []),
            PngImage::new(1, 1, [Samples::contiguous(&[0.0]); 5]),
        ] {
            assert!(matches!(write_png8(path, &image), Err(Error::Unwritable { .. })));
        }
    }
}
