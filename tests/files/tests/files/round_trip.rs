//! Written files are read back unchanged.

use half::f16;
use trochoid_image::{Plane, Window, WorkingSpace};

use super::make::values;
use trochoid_io::{
    Error, ExrChannel, ExrImage, Limits, PngImage, SampleType, Samples, Selection, check_whole, info, read,
    read_metadata, readable_metadata, write_exr, write_png8,
};

#[test]
fn both_sample_types_over_all_windows() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("a.exr");
    for data in [
        Window::sized(1, 1),
        Window::sized(640, 16),
        Window::new(-30, -20, 67, 13),
        Window::new(5000, 5000, 5003, 5100),
        Window::new(-(1 << 30) + 2, 0, -(1 << 30) + 9, 300),
    ] {
        let display = Window::sized(64, 48);
        let mut half = Plane::new(data, values(data.area(), 3)).unwrap();
        half.samples_mut().iter_mut().for_each(|v| *v = f16::from_f32(*v).to_f32());
        let float = Plane::new(data, values(data.area(), 4)).unwrap();
        let image = ExrImage {
            display,
            channels: vec![
                ExrChannel::float("depth.Z", Samples::plane(&float)),
                ExrChannel::half("beauty.R", Samples::plane(&half)),
            ],
            ..ExrImage::new(data)
        };
        write_exr(&path, &image).unwrap();
        let beauty = read(&path, &Selection::layer("beauty"), &Limits::default()).unwrap();
        assert_eq!((beauty.data, beauty.display), (data, display));
        assert_eq!(beauty.channel("R"), Some(&half));
        assert_eq!(beauty.channels[0].sample_type, SampleType::Half);
        let depth = read(&path, &Selection::layer("depth"), &Limits::default()).unwrap();
        assert_eq!(depth.channel("Z"), Some(&float));
        // The library that other programs use reads the file, too.
        let other = exr::prelude::read_all_flat_layers_from_file(&path).unwrap();
        assert_eq!(other.layer_data[0].size.area(), data.area());
    }
}

#[test]
fn special_values_survive() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("a.exr");
    let special = [0.0, -0.0, 65504.0, -65504.0, f32::INFINITY, f32::NEG_INFINITY, f32::NAN, 5.9604645e-8];
    let window = Window::sized(special.len() as u32, 1);
    let tiny = [f32::MIN_POSITIVE, f32::MAX, f32::MIN, 1e-45, f32::NAN, f32::INFINITY, -0.0, 1.0];
    let image = ExrImage {
        channels: vec![
            ExrChannel::half("H", Samples::contiguous(&special)),
            ExrChannel::float("F", Samples::contiguous(&tiny)),
        ],
        ..ExrImage::new(window)
    };
    write_exr(&path, &image).unwrap();
    let picture = read(&path, &Selection::channels(["H", "F"]), &Limits::default()).unwrap();
    for (channel, expected) in picture.channels.iter().zip([special, tiny]) {
        for (found, expected) in channel.plane.samples().iter().zip(expected) {
            assert!(found.to_bits() == expected.to_bits() || found.is_nan() && expected.is_nan());
        }
    }
}

#[test]
fn interleaved_pixels_are_taken_apart() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("a.exr");
    let pixels = [[0.25, 0.5, 0.75], [1.0, 2.0, 4.0]];
    let [r, g, b] = Samples::rgb(&pixels);
    let image = ExrImage {
        channels: vec![ExrChannel::half("R", r), ExrChannel::half("G", g), ExrChannel::half("B", b)],
        ..ExrImage::new(Window::sized(1, 2))
    };
    write_exr(&path, &image).unwrap();
    let picture = read(&path, &Selection::default(), &Limits::default()).unwrap();
    let rows: Vec<&[f32]> = picture.channels.iter().map(|channel| channel.plane.samples()).collect();
    assert_eq!(rows, [[0.25, 1.0], [0.5, 2.0], [0.75, 4.0]]);
}

#[test]
fn metadata_and_chromaticities_come_back_in_order_and_bytes_repeat() {
    let folder = tempfile::tempdir().unwrap();
    let (path, again) = (folder.path().join("a.exr"), folder.path().join("b.exr"));
    let long = "a-name-that-older-readers-of-the-format-do-not-take";
    let metadata: Vec<(String, String)> = [("zebra", "1"), ("apple", "größer 波"), (long, ""), ("multi", "a\nb\0c")]
        .map(|(key, value)| (key.into(), value.into()))
        .to_vec();
    let plane = Plane::filled(Window::sized(3, 3), 0.5);
    let image = ExrImage {
        channels: vec![ExrChannel::half("Y", Samples::plane(&plane))],
        metadata: metadata.clone(),
        chromaticities: Some(WorkingSpace::AcesCg.chromaticities()),
        ..ExrImage::new(plane.window())
    };
    write_exr(&path, &image).unwrap();
    write_exr(&again, &image).unwrap();
    assert_eq!(std::fs::read(&path).unwrap(), std::fs::read(&again).unwrap());
    assert_eq!(read_metadata(&path).unwrap(), metadata);
    let info = info(&path, &Limits::default()).unwrap();
    assert_eq!(info.parts[0].chromaticities, image.chromaticities);
    assert!(exr::prelude::read_all_flat_layers_from_file(&path).is_ok());
}

#[test]
fn what_is_cut_off_or_has_bytes_behind_it_is_not_whole_and_tells_its_metadata_all_the_same() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("picture");
    let metadata: Vec<(String, String)> = vec![("trochoid:version".into(), "1".into()), ("later".into(), "2".into())];
    let plane = Plane::filled(Window::sized(5, 40), 0.5);
    let exr = ExrImage {
        channels: vec![ExrChannel::half("Y", Samples::plane(&plane))],
        metadata: metadata.clone(),
        ..ExrImage::new(plane.window())
    };
    let png = PngImage { metadata: metadata.clone(), ..PngImage::new(5, 40, [Samples::plane(&plane)]) };
    for is_exr in [true, false] {
        if is_exr {
            write_exr(&path, &exr).unwrap();
        } else {
            write_png8(&path, &png).unwrap();
        }
        let whole = std::fs::read(&path).unwrap();
        let find = |text: &str| whole.windows(text.len()).position(|found| found == text.as_bytes()).unwrap();
        check_whole(&path).unwrap();
        for length in 0..whole.len() {
            std::fs::write(&path, &whole[..length]).unwrap();
            assert!(check_whole(&path).is_err(), "{length} of {} bytes", whole.len());
            let known = readable_metadata(&path);
            assert!(metadata.starts_with(&known), "{known:?}");
            assert!(known.len() == 2 || length < find("later") + 40, "{length}: {known:?}");
            assert!(known.is_empty() || length > find("trochoid:version"), "{length}: {known:?}");
        }
        for more in [&b"x"[..], &whole] {
            std::fs::write(&path, [&whole, more].concat()).unwrap();
            assert!(check_whole(&path).is_err());
            assert_eq!(readable_metadata(&path), metadata);
        }
    }
    std::fs::write(&path, "text").unwrap();
    assert!(check_whole(&path).is_err() && readable_metadata(&path).is_empty());
}

#[test]
fn halves_that_overflow_are_refused_before_anything_is_written() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("a.exr");
    std::fs::write(&path, "old").unwrap();
    for bad in [65504.01_f32, -70000.0, f32::MAX] {
        let mut plane = Plane::filled(Window::new(-2, 3, 2, 6), 1.0);
        plane.samples_mut()[6] = bad;
        let channel = |half: bool| {
            let samples = Samples::plane(&plane);
            let channel =
                if half { ExrChannel::half("beauty.G", samples) } else { ExrChannel::float("beauty.G", samples) };
            ExrImage { channels: vec![channel], ..ExrImage::new(plane.window()) }
        };
        let error = write_exr(&path, &channel(true)).unwrap_err();
        assert!(
            matches!(&error, Error::Unrepresentable { channel, x: 0, y: 4, value, .. } if channel == "beauty.G" && *value == bad),
            "{error}"
        );
        assert_eq!(std::fs::read(&path).unwrap(), b"old");
        assert_eq!(std::fs::read_dir(folder.path()).unwrap().count(), 1);
        write_exr(folder.path().join("missing/a.exr"), &channel(false)).unwrap_err();
        let sub = tempfile::tempdir().unwrap();
        write_exr(sub.path().join("b.exr"), &channel(false)).unwrap();
    }
}

#[test]
fn pictures_that_exr_cannot_hold_are_refused() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("a.exr");
    let plane = Plane::filled(Window::sized(2, 2), 0.5);
    let samples = Samples::plane(&plane);
    let good = || ExrImage { channels: vec![ExrChannel::half("Y", samples)], ..ExrImage::new(plane.window()) };
    assert!(write_exr(&path, &good()).is_ok());
    let bad = [
        ExrImage { channels: vec![], ..good() },
        ExrImage { channels: vec![ExrChannel::half("", samples)], ..good() },
        ExrImage { channels: vec![ExrChannel::half("a\0b", samples)], ..good() },
        ExrImage { channels: vec![ExrChannel::half("x".repeat(256), samples)], ..good() },
        ExrImage { channels: vec![ExrChannel::half("Y", samples), ExrChannel::float("Y", samples)], ..good() },
        ExrImage { channels: vec![ExrChannel::half("Y", Samples::contiguous(&[1.0]))], ..good() },
        ExrImage { data: Window::default(), ..good() },
        ExrImage { display: Window::new(0, 0, 1 << 40, 1), ..good() },
        ExrImage { metadata: vec![("channels".into(), "".into())], ..good() },
        ExrImage { metadata: vec![("a".into(), "".into()), ("a".into(), "".into())], ..good() },
    ];
    let before = std::fs::read(&path).unwrap();
    for image in bad {
        let error = write_exr(&path, &image).unwrap_err();
        assert!(matches!(error, Error::Unwritable { .. }), "{error}");
        assert_eq!(std::fs::read(&path).unwrap(), before);
    }
}
