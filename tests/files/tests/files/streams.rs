//! Files read and written band by band.

use std::sync::Mutex;

use exr::image::Blocks;
use exr::math::Vec2;
use rand::RngExt;
use trochoid_image::{Plane, Window};

use super::make::{METHODS, Method, Part, SMALL, exr, file, random, values};
use trochoid_io::{
    BandBuffer, EncodeScratch, EncodedBand, Error, ExrChannel, ExrHeader, ExrImage, ExrReader, ExrWriter, Limits,
    SampleType, Samples, Selection, info, read, read_metadata, write_exr,
};

fn reader(bytes: &[u8], selection: &Selection) -> ExrReader {
    ExrReader::open(file(bytes).path(), selection, &SMALL).unwrap()
}

#[test]
fn bands_hold_what_the_whole_picture_holds() {
    for method in METHODS {
        for part in [Part::new(method), Part::tiled(method, (16, 8)), Part::tiled(method, (64, 64))] {
            let bytes = exr(std::slice::from_ref(&part));
            // One channel twice, another not at all.
            let selection = Selection::channels(["Z", "A", "Z"]);
            let picture = super::make::read(&bytes, &selection).unwrap();
            let reader = reader(&bytes, &selection);
            assert_eq!((reader.info().data, reader.info().display), (picture.data, picture.display));
            let mut buffer = BandBuffer::new();
            let mut y = picture.data.y0;
            for band in 0..reader.bands() {
                reader.decode(band, &mut buffer).unwrap();
                let window = buffer.window();
                assert_eq!((window, window.y0, reader.band_at(y)), (reader.band_window(band), y, Some(band)));
                y = window.y1;
                for (index, channel) in picture.channels.iter().enumerate() {
                    assert_eq!(reader.info().channels[index].full_name, channel.full_name);
                    let inner = Window::new(window.x0 + 5, window.y0, window.x1 - 20, window.y1);
                    let mut out = vec![0.0; inner.area()];
                    buffer.copy_rows(index, inner, &mut out);
                    for (row, y) in out.chunks(inner.width()).zip(inner.y0..) {
                        assert_eq!(row, &channel.plane.row(y).unwrap()[5..25], "{method}, row {y}");
                    }
                }
            }
            assert_eq!((y, reader.band_at(y)), (picture.data.y1, None));
            assert!(reader.band_window(reader.bands()).is_empty());
        }
    }
}

#[test]
fn a_damaged_band_is_named_and_the_others_are_read() {
    for blocks in [Blocks::ScanLines, Blocks::Tiles(Vec2(16, 16))] {
        let part = Part { blocks, ..Part::new(Method::ZIP16) };
        let mut bytes = exr(std::slice::from_ref(&part));
        bytes.pop();
        let reader = reader(&bytes, &Selection::default());
        let mut buffer = BandBuffer::new();
        assert!(reader.decode(0, &mut buffer).is_ok());
        let error = reader.decode(2, &mut buffer).unwrap_err().to_string();
        assert!(error.contains("rows 43 to 47") && error.contains("end of the file"), "{error}");
        assert!(buffer.window().is_empty());
        assert!(super::make::read(&bytes, &Selection::default()).unwrap_err().to_string().contains("rows 43 to 47"));
        assert!(reader.decode(1, &mut buffer).is_ok());
    }
}

#[test]
fn a_buffer_serves_one_file_after_another() {
    let [first, second] = [(45, 37), (44, 37)].map(|size| Part { size, ..Part::new(Method::ZIP1) });
    let selection = Selection::channels(["Z"]);
    let readers = [&first, &second].map(|part| reader(&exr(std::slice::from_ref(part)), &selection));
    let mut buffer = BandBuffer::new();
    for band in [0, 1, 20, 3] {
        for (reader, part) in readers.iter().zip([&first, &second]) {
            reader.decode(band, &mut buffer).unwrap();
            let mut row = vec![0.0; part.size.0];
            buffer.row_f32(0, buffer.window().y0, buffer.window().x0, &mut row);
            assert_eq!(row, part.float()[band * part.size.0..][..part.size.0]);
        }
    }
}

#[test]
fn other_kinds_of_file_are_not_streamed() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("a.png");
    std::fs::write(&path, b"\x89PNG\r\n\x1a\n").unwrap();
    let error = ExrReader::open(&path, &Selection::default(), &SMALL).unwrap_err();
    assert!(error.to_string().contains("found a PNG file, expected an EXR file"), "{error}");
}

const DATA: Window = Window::new(-3, 5, 50, 138);

fn header() -> ExrHeader {
    ExrHeader {
        display: Window::sized(64, 48),
        channels: vec![("Z".into(), SampleType::Float), ("R".into(), SampleType::Half), ("B".into(), SampleType::Half)],
        metadata: vec![("trochoid:frame".into(), "17".into())],
        ..ExrHeader::new(DATA)
    }
}

fn planes() -> Vec<Plane> {
    (0..3).map(|salt| Plane::new(DATA, values(DATA.area(), salt)).unwrap()).collect()
}

fn encoded(writer: &ExrWriter, planes: &[Plane], band: usize) -> EncodedBand {
    let window = writer.band_window(band);
    let first = (window.y0 - DATA.y0) as usize * DATA.width();
    let rows: Vec<&[f32]> = planes.iter().map(|plane| &plane.samples()[first..][..window.area()]).collect();
    writer.encode(band, &rows, &mut EncodeScratch::new()).unwrap()
}

#[test]
fn any_order_of_bands_makes_the_bytes_of_a_whole_write() {
    let folder = tempfile::tempdir().unwrap();
    let [whole, bands] = ["whole.exr", "bands.exr"].map(|name| folder.path().join(name));
    let (header, planes) = (header(), planes());
    let samples = || planes.iter().map(Samples::plane).zip(&header.channels);
    let channels = samples().map(|(samples, (name, kind))| match kind {
        SampleType::Half => ExrChannel::half(name, samples),
        _ => ExrChannel::float(name, samples),
    });
    let image = ExrImage {
        display: header.display,
        data: DATA,
        channels: channels.collect(),
        metadata: header.metadata.clone(),
        reserved: 0,
        chromaticities: None,
    };
    write_exr(&whole, &image).unwrap();
    let expected = std::fs::read(&whole).unwrap();
    let mut random = random();
    for round in 0..20 {
        let writer = ExrWriter::create(&bands, &header).unwrap();
        let mut order: Vec<usize> = (0..writer.bands()).collect();
        for i in (1..order.len()).rev() {
            order.swap(i, random.random_range(0..=i));
        }
        let queue = Mutex::new(order.into_iter());
        std::thread::scope(|scope| {
            for _ in 0..1 + round % 3 {
                scope.spawn(|| {
                    loop {
                        let Some(band) = queue.lock().unwrap().next() else { return };
                        writer.push(encoded(&writer, &planes, band)).unwrap();
                    }
                });
            }
        });
        writer.finish(&[]).unwrap();
        assert!(std::fs::read(&bands).unwrap() == expected, "round {round}");
    }
}

#[test]
fn late_metadata_take_the_place_kept_for_them() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("a.exr");
    let planes = planes();
    let write = |free: usize, late: &[(&str, &str)]| {
        let writer = ExrWriter::create(&path, &ExrHeader { late_metadata: free, ..header() }).unwrap();
        for band in 0..writer.bands() {
            writer.push(encoded(&writer, &planes, band)).unwrap();
        }
        writer.finish(&late.iter().map(|&(key, value)| (key.into(), value.into())).collect::<Vec<_>>())
    };
    let long = "a-name-that-older-readers-of-the-format-do-not-take";
    for (free, late) in [(0, vec![]), (40, vec![]), (40, vec![("late", "value")]), (100, vec![("a", ""), (long, "x")])]
    {
        write(free, &late).unwrap();
        let mut expected = vec![("trochoid:frame".to_string(), "17".to_string())];
        expected.extend(late.iter().map(|&(key, value)| (key.to_string(), value.to_string())));
        assert_eq!(read_metadata(&path).unwrap(), expected);
        let picture = read(&path, &Selection::channels(["Z"]), &Limits::default()).unwrap();
        assert_eq!(picture.channels[0].plane, planes[0]);
        assert!(exr::prelude::read_all_flat_layers_from_file(&path).is_ok());
    }
    // Exactly full: four bytes of name, five of value, and twelve more.
    write(21, &[("late", "value")]).unwrap();
    let before = std::fs::read(&path).unwrap();
    for (free, late) in [
        (20, [("late", "value")]),
        (0, [("a", "")]),
        (99, [("trochoid:frame", "18")]),
        (99, [("channels", "")]),
        (99, [("reserved", "")]),
    ] {
        assert!(matches!(write(free, &late), Err(Error::Unwritable { .. })), "{late:?}");
        assert!(std::fs::read(&path).unwrap() == before);
    }
    assert_eq!(std::fs::read_dir(folder.path()).unwrap().count(), 1);
}

#[test]
fn a_file_that_is_not_finished_leaves_nothing() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("a.exr");
    let planes = planes();
    let count = || std::fs::read_dir(folder.path()).unwrap().count();
    let writer = ExrWriter::create(&path, &header()).unwrap();
    writer.push(encoded(&writer, &planes, 0)).unwrap();
    assert_eq!(count(), 1);
    drop(writer);
    assert_eq!(count(), 0);
    let writer = ExrWriter::create(&path, &header()).unwrap();
    for band in (0..writer.bands()).filter(|&band| band != 3) {
        writer.push(encoded(&writer, &planes, band)).unwrap();
    }
    let error = writer.finish(&[]).unwrap_err().to_string();
    assert!(error.contains("without band 3 of 9"), "{error}");
    assert_eq!(count(), 0);
}

#[test]
fn bands_that_do_not_fit_are_refused() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("a.exr");
    let planes = planes();
    let writer = ExrWriter::create(&path, &header()).unwrap();
    let scratch = &mut EncodeScratch::new();
    let full = vec![0.5; writer.band_window(0).area()];
    let short = &full[1..];
    for (band, rows) in [
        (0, vec![&full[..], &full]),
        (0, vec![&full, &full, short]),
        (9, vec![&full, &full, &full]),
        (8, vec![&full; 3]),
    ] {
        let error = writer.encode(band, &rows, scratch).unwrap_err();
        assert!(matches!(error, Error::Unwritable { .. }), "{error}");
    }
    let mut bad = full.clone();
    bad[2 * DATA.width() + 7] = -1e6;
    // Float accepts values of that size.
    writer.encode(1, &[&bad, &full, &full], scratch).unwrap();
    let error = writer.encode(1, &[&full, &full, &bad], scratch).unwrap_err();
    assert!(
        matches!(&error, Error::Unrepresentable { channel, x: 4, y: 23, value: -1e6, .. } if channel == "B"),
        "{error}"
    );
    for band in [0, 5] {
        writer.push(encoded(&writer, &planes, band)).unwrap();
        assert!(writer.push(encoded(&writer, &planes, band)).is_err());
    }
    let integers = ExrHeader { channels: vec![("id".into(), SampleType::Uint)], ..header() };
    assert!(matches!(ExrWriter::create(&path, &integers), Err(Error::Unwritable { .. })));
    assert!(info(&path, &SMALL).is_err());
}
