//! Values that a file format rounds to a stored sample.

use trochoid_io::SampleType;

/// Returns the smallest and the largest number that are stored as this sample.
pub(super) fn before_rounding(stored: SampleType, sample: f32) -> (f64, f64) {
    let value = f64::from(sample);
    match stored {
        SampleType::U8 => steps(value, 255.0),
        SampleType::U16 => steps(value, 65535.0),
        SampleType::Half if value.is_finite() => {
            let (down, up) = (half_below(value), -half_below(-value));
            (0.5 * (value + down), 0.5 * (value + up))
        }
        // f32 samples are stored unchanged.
        SampleType::Half | SampleType::Float | SampleType::Uint => (value, value),
    }
}

/// Returns the range that rounds to the nearest whole step.
fn steps(value: f64, steps: f64) -> (f64, f64) {
    let step = (value * steps).round();
    ((step - 0.5) / steps, (step + 0.5) / steps)
}

/// Returns the next 16-bit float below a value (IEEE 754 binary16: 11 bits, smallest step 2⁻²⁴).
fn half_below(value: f64) -> f64 {
    const LEAST: f64 = 1.0 / 16_777_216.0;
    let size = value.abs();
    // 2 to the power of the exponent, and the distance between neighbors above it.
    let power = if size == 0.0 { 0.0 } else { f64::from_bits(size.to_bits() & (0x7ff << 52)) };
    let step = (power / 1024.0).max(LEAST);
    // Below a power of two, neighbors are half as far apart.
    let step = if value > 0.0 && size == power { (step / 2.0).max(LEAST) } else { step };
    value - step
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn halves_have_their_neighbors() {
        assert_eq!(half_below(1.0), 1.0 - 1.0 / 2048.0);
        assert_eq!(half_below(-1.0), -1.0 - 1.0 / 1024.0);
        assert_eq!(half_below(1.5), 1.5 - 1.0 / 1024.0);
        assert_eq!(half_below(0.0), -(0.5_f64.powi(24)));
        assert_eq!(half_below(0.5_f64.powi(24)), 0.0);
        assert_eq!(half_below(0.5_f64.powi(14)), 0.5_f64.powi(14) - 0.5_f64.powi(24));
    }

    #[test]
    fn what_is_stored_lies_between() {
        let folder = tempfile::tempdir().expect("a folder");
        let values: Vec<f32> = (0..4096).map(|i| (i as f32 * 0.37).sin().abs() * 0.5_f32.powi(i % 26)).collect();
        for stored in [SampleType::U8, SampleType::U16, SampleType::Half, SampleType::Float] {
            let path =
                folder.path().join(if matches!(stored, SampleType::U8 | SampleType::U16) { "a.png" } else { "a.exr" });
            let samples = trochoid_io::Samples::contiguous(&values);
            let png = trochoid_io::PngImage::new(64, 64, [samples]);
            let exr = |channel| trochoid_io::ExrImage {
                channels: vec![channel],
                ..trochoid_io::ExrImage::new(trochoid_image::Window::sized(64, 64))
            };
            match stored {
                SampleType::U8 => trochoid_io::write_png8(&path, &png),
                SampleType::U16 => trochoid_io::write_png16(&path, &png),
                SampleType::Half => trochoid_io::write_exr(&path, &exr(trochoid_io::ExrChannel::half("Y", samples))),
                _ => trochoid_io::write_exr(&path, &exr(trochoid_io::ExrChannel::float("Y", samples))),
            }
            .expect("written");
            let picture = trochoid_io::read(&path, &Default::default(), &Default::default()).expect("read");
            for (value, sample) in values.iter().zip(picture.channels[0].plane.samples()) {
                let (low, high) = before_rounding(stored, *sample);
                let value = f64::from(*value);
                assert!(low <= value && value <= high, "{stored}: {value} is stored as {sample}, of [{low}, {high}]");
                let size = if stored == SampleType::Half { value / 1024.0 + 1e-7 } else { 1.0 / 254.0 };
                assert!(high - low <= size, "{stored}: [{low}, {high}]");
            }
        }
    }
}
