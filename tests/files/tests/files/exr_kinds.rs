//! Every kind of EXR that the `exr` crate writes.

use exr::image::Blocks;
use exr::math::{RoundingMode, Vec2};
use exr::meta::attribute::LineOrder;
use trochoid_image::Window;

use super::make::{METHODS, Method, Part, describe, exr, file, read};
use trochoid_io::{Compression, Encoding, Error, Levels, SampleType, Selection, Storage};

/// Checks the three channels of a part made by [`Part`].
fn check(part: &Part, bytes: &[u8], selection: &Selection) {
    let what = format!("{} {:?} {:?} {:?}", part.method, part.blocks, part.levels, part.rounding);
    let picture = read(bytes, selection).unwrap_or_else(|error| panic!("{what}: {error}"));
    let (x, y) = (i64::from(part.position.0), i64::from(part.position.1));
    let window = Window::new(x, y, x + part.size.0 as i64, y + part.size.1 as i64);
    assert_eq!((picture.data, picture.display), (window, Window::sized(20, 10)), "{what}");
    assert_eq!(picture.encoding, Encoding::Linear);
    let lossy_half = matches!(part.method, Method::B44 | Method::B44A | Method::DWAA(_) | Method::DWAB(_));
    let close = |found: &[f32], expected: &[f32], tolerance: f32| {
        assert_eq!(found.len(), expected.len());
        for (index, (a, b)) in found.iter().zip(expected).enumerate() {
            assert!((a - b).abs() <= tolerance, "{what}: sample {index}: {a} for {b}");
        }
    };
    close(picture.channel("A").unwrap().samples(), &part.half(), if lossy_half { 0.02 } else { 0.0 });
    let lossy_float = part.method == Method::PXR24;
    close(picture.channel("Z").unwrap().samples(), &part.float(), if lossy_float { 1e-4 } else { 0.0 });
    if let Some(id) = picture.channel("id") {
        let expected: Vec<f32> = part.uint().into_iter().map(|v| v as f32).collect();
        assert_eq!(id.samples(), expected, "{what}");
    }
}

#[test]
fn every_compression_as_scanlines_and_tiles() {
    for method in METHODS {
        for mut part in [Part::new(method), Part::tiled(method, (16, 8)), Part::tiled(method, (64, 64))] {
            for order in [LineOrder::Increasing, LineOrder::Decreasing] {
                part.order = order;
                check(&part, &exr(std::slice::from_ref(&part)), &Selection::default());
            }
        }
    }
}

#[test]
fn the_largest_of_several_levels() {
    for levels in [Levels::Mip, Levels::Rip] {
        for rounding in [RoundingMode::Down, RoundingMode::Up] {
            for size in [(45, 37), (1, 37), (64, 3)] {
                let part = Part { levels, rounding, size, ..Part::tiled(Method::ZIP16, (16, 8)) };
                let bytes = exr(std::slice::from_ref(&part));
                let storage = Storage::Tiled { width: 16, height: 8, levels };
                assert_eq!(describe(&bytes).unwrap().parts[0].storage, storage);
                check(&part, &bytes, &Selection::default());
            }
        }
    }
}

#[test]
fn several_parts_of_different_kinds() {
    let parts = [
        Part { name: Some("Ocean.Combined"), prefix: "Ocean.Combined.", ..Part::new(Method::ZIP16) },
        Part { name: Some("mips"), levels: Levels::Mip, position: (3, 3), ..Part::tiled(Method::PIZ, (8, 8)) },
        Part { name: Some("rips"), size: (5, 9), levels: Levels::Rip, ..Part::tiled(Method::RLE, (4, 4)) },
        Part { name: Some("last"), prefix: "deep down.", size: (1, 1), ..Part::new(Method::Uncompressed) },
    ];
    let bytes = exr(&parts);
    for (part, layer) in parts.iter().zip(["Combined", "mips", "rips", "deep down"]) {
        check(part, &bytes, &Selection::layer(layer));
        check(part, &bytes, &Selection::default().with_part(part.name.unwrap()));
    }
    let info = describe(&bytes).unwrap();
    assert_eq!(info.parts[0].layers, ["Ocean.Combined"]);
    assert_eq!(info.parts[3].layers, ["deep down"]);
    assert_eq!(info.parts[1].compression, Compression::Piz);
}

#[test]
fn windows_may_be_negative_disjoint_or_large() {
    for position in [(-500, -400), (500, 400), (-3, -3), (1 << 29, -(1 << 29))] {
        let part = Part { position, ..Part::new(Method::ZIP16) };
        check(&part, &exr(std::slice::from_ref(&part)), &Selection::default());
        let part = Part { position, blocks: Blocks::Tiles(Vec2(7, 100)), ..Part::new(Method::ZIP1) };
        check(&part, &exr(std::slice::from_ref(&part)), &Selection::default());
    }
}

#[test]
fn only_wanted_channels_come_and_in_the_wanted_order() {
    let part = Part::new(Method::PIZ);
    let bytes = exr(std::slice::from_ref(&part));
    let picture = read(&bytes, &Selection::channels(["ID", "z"])).unwrap();
    let names: Vec<(&str, SampleType)> = picture.channels.iter().map(|c| (c.name.as_str(), c.sample_type)).collect();
    assert_eq!(names, [("id", SampleType::Uint), ("Z", SampleType::Float)]);
    assert_eq!(picture.channel("Z").unwrap().samples(), part.float());
    assert!(matches!(read(&bytes, &Selection::channels(["Q"])), Err(Error::NotFound { .. })));
}

#[test]
fn large_tiles_in_many_bands() {
    let part = Part { size: (2100, 2100), ..Part::tiled(Method::RLE, (256, 100)) };
    let bytes = exr(std::slice::from_ref(&part));
    let limits = trochoid_io::Limits::default();
    let picture = trochoid_io::read(file(&bytes).path(), &Selection::channels(["Z"]), &limits).unwrap();
    assert_eq!(picture.channels[0].plane.samples(), part.float());
}
