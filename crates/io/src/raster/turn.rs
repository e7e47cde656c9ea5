//! Turning of pictures according to their orientation tags.

use image::metadata::Orientation;
use trochoid_image::Window;

use super::form::Form;

/// Returns the window of the upright picture.
pub(crate) fn oriented(stored: Window, orientation: Orientation) -> Window {
    use Orientation::{Rotate90, Rotate90FlipH, Rotate270, Rotate270FlipH};
    match orientation {
        Rotate90 | Rotate270 | Rotate90FlipH | Rotate270FlipH => Window::new(0, 0, stored.y1, stored.x1),
        _ => stored,
    }
}

/// Extracts row `y` of the upright picture from all stored pixels.
pub(super) fn row(whole: &[u8], form: &Form, y: usize, out: &mut Vec<u8>) {
    let (w, h, size) = (form.width as usize, form.height as usize, form.pixel());
    let width = oriented(form.stored(), form.orientation).width();
    out.clear();
    for x in 0..width {
        let (column, line) = match form.orientation {
            Orientation::NoTransforms => (x, y),
            Orientation::FlipHorizontal => (w - 1 - x, y),
            Orientation::Rotate180 => (w - 1 - x, h - 1 - y),
            Orientation::FlipVertical => (x, h - 1 - y),
            Orientation::Rotate90FlipH => (y, x),
            Orientation::Rotate90 => (y, h - 1 - x),
            Orientation::Rotate270FlipH => (w - 1 - y, h - 1 - x),
            Orientation::Rotate270 => (w - 1 - y, x),
        };
        let start = (line * w + column) * size;
        // A file that ends early has fewer pixels.
        match whole.get(start..start + size) {
            Some(pixel) => out.extend_from_slice(pixel),
            None => out.resize(out.len() + size, 0),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::{Encoding, SampleType};

    #[test]
    fn turning_agrees_with_the_image_crate() {
        let (width, height) = (3, 2);
        let samples: Vec<u8> = (0..6).collect();
        for tag in 1..=8 {
            let orientation = Orientation::from_exif(tag).expect("a legal tag");
            let buffer = image::GrayImage::from_raw(width, height, samples.clone()).expect("six pixels");
            let mut image = image::DynamicImage::ImageLuma8(buffer);
            image.apply_orientation(orientation);
            let form = Form {
                width,
                height,
                sample_type: SampleType::U8,
                bases: &["Y"],
                orientation,
                encoding: Encoding::Srgb,
                rows: 1,
                working: 0,
            };
            let (mut upright, mut line) = (Vec::new(), Vec::new());
            for y in 0..image.height() as usize {
                row(&samples, &form, y, &mut line);
                upright.extend_from_slice(&line);
            }
            assert_eq!(upright, image.as_bytes(), "{orientation:?}");
            assert_eq!(oriented(form.stored(), orientation), Window::sized(image.width(), image.height()));
        }
    }
}
