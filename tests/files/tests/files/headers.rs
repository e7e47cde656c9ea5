//! Headers: hostile claims, unsupported kinds, and descriptions of good files.

use trochoid_image::{Chromaticities, Window};

use super::make::{Method, Part, SMALL, describe, exr, file, read};
use trochoid_io::{
    BandBuffer, Compression, Error, ExrReader, FileKind, Levels, Limits, SampleType, Selection, Storage, info,
};

/// Builder of headers, attribute by attribute.
#[derive(Clone)]
struct Head(Vec<u8>);

impl Head {
    fn new(flags: u32) -> Self {
        Self([0x0131_2f76_u32.to_le_bytes(), (2 | flags).to_le_bytes()].concat())
    }

    fn with(mut self, name: &str, kind: &str, value: &[u8]) -> Self {
        self = self.claiming(name, kind, value.len() as i32);
        self.0.extend(value);
        self
    }

    fn claiming(mut self, name: &str, kind: &str, size: i32) -> Self {
        for text in [name, kind] {
            self.0.extend(text.as_bytes());
            self.0.push(0);
        }
        self.0.extend(size.to_le_bytes());
        self
    }

    fn window(self, name: &str, [x0, y0, x1, y1]: [i32; 4]) -> Self {
        let bytes: Vec<u8> = [x0, y0, x1, y1].into_iter().flat_map(i32::to_le_bytes).collect();
        self.with(name, "box2i", &bytes)
    }

    fn channels(self, names: &[(&str, i32, i32)]) -> Self {
        let mut list = Vec::new();
        for &(name, kind, sampling) in names {
            list.extend(name.as_bytes());
            list.push(0);
            for number in [kind, 0, sampling, sampling] {
                list.extend(number.to_le_bytes());
            }
        }
        list.push(0);
        self.with("channels", "chlist", &list)
    }

    /// Adds the attributes of a part with one half channel Y and this size.
    fn part(self, width: i32, height: i32, compression: u8) -> Self {
        self.channels(&[("Y", 1, 1)])
            .with("compression", "compression", &[compression])
            .window("dataWindow", [0, 0, width - 1, height - 1])
            .window("displayWindow", [0, 0, 9, 9])
    }

    fn end(mut self) -> Vec<u8> {
        self.0.push(0);
        self.0
    }
}

fn refused(bytes: &[u8]) -> Error {
    read(bytes, &Selection::default()).expect_err("refused")
}

#[test]
fn huge_claims_are_refused_at_once() {
    let huge = Head::new(0).part(100_000, 100_000, 3).end();
    assert!(huge.len() < 1024);
    for result in [
        info(file(&huge).path(), &Limits::default()).map(|_| ()),
        trochoid_io::read(file(&huge).path(), &Selection::default(), &Limits::default()).map(|_| ()),
    ] {
        let error = result.unwrap_err();
        assert!(matches!(error, Error::TooLarge { found: 10_000_000_000, limit: 2_147_483_648, .. }), "{error}");
    }
    let side = i32::MAX / 2;
    for bytes in [
        Head::new(0).part(side, side, 0).end(),
        Head::new(0).part(side, 1, 9).end(),
        Head::new(0x200).part(side, side, 0).with("tiles", "tiledesc", &[1, 0, 0, 0, 1, 0, 0, 0, 0x12]).end(),
    ] {
        assert!(matches!(refused(&bytes), Error::TooLarge { .. }), "{}", refused(&bytes));
    }
    // Small enough in pixels, but one chunk would need too much memory.
    let wide = Head::new(0).part(1 << 20, 1, 9).end();
    let limits = Limits { pixels: u64::MAX, bytes: 1 << 20 };
    let error = trochoid_io::read(file(&wide).path(), &Selection::default(), &limits).unwrap_err();
    assert!(matches!(error, Error::TooLarge { .. }), "{error}");
}

#[test]
fn a_chunk_that_cannot_hold_its_pixels_takes_no_memory() {
    // A row of 2 MiB in 40 bytes, by every method.
    for compression in 1..=9 {
        let mut bytes = Head::new(0).part(1 << 20, 1, compression).end();
        let chunk = bytes.len() as u64 + 8;
        bytes.extend(chunk.to_le_bytes());
        bytes.extend(0_i32.to_le_bytes());
        bytes.extend(40_i32.to_le_bytes());
        bytes.extend([0x78; 40]);
        let of = |bytes: &[u8]| ExrReader::open(file(bytes).path(), &Selection::default(), &SMALL);
        let reader = of(&bytes).unwrap();
        let mut buffer = BandBuffer::new();
        let error = reader.decode(0, &mut buffer).unwrap_err();
        assert!(matches!(error, Error::Invalid { .. }), "method {compression}: {error}");
        assert!(buffer.bytes() < 1 << 17, "method {compression}: {} bytes", buffer.bytes());
        assert!(matches!(refused(&bytes), Error::Invalid { .. }), "method {compression}");
    }
}

#[test]
fn claims_beyond_the_file_are_refused() {
    // A chunk table longer than the file.
    let error = refused(&Head::new(0).part(10, 100_000, 2).end());
    assert!(matches!(error, Error::Invalid { .. }), "{error}");
    // An attribute longer than the file; one of negative size.
    for size in [i32::MAX, 100, -1] {
        let error = refused(&Head::new(0).claiming("comments", "string", size).0);
        assert!(matches!(error, Error::Invalid { .. }) && error.to_string().contains("comments"), "{error}");
    }
    // A name without end.
    assert!(matches!(refused(&Head::new(0).claiming(&"x".repeat(300), "int", 4).0), Error::Invalid { .. }));
    // A chunk count that does not fit the window.
    let bytes = Head::new(0).part(10, 10, 0).with("chunkCount", "int", &i32::MAX.to_le_bytes()).end();
    assert!(refused(&bytes).to_string().contains("chunk count"), "{}", refused(&bytes));
}

#[test]
fn broken_headers_name_the_attribute() {
    let good = || Head::new(0).channels(&[("Y", 1, 1)]).with("compression", "compression", &[0]);
    let windows = |head: Head| head.window("dataWindow", [0, 0, 3, 3]).window("displayWindow", [0, 0, 3, 3]);
    let cases: [(Vec<u8>, &str); 11] = [
        (Head::new(0).end(), "dataWindow"),
        (windows(Head::new(0).with("compression", "compression", &[0])).end(), "channels"),
        (windows(Head::new(0).channels(&[])).with("compression", "compression", &[0]).end(), "empty list"),
        (
            windows(Head::new(0).channels(&[("Y", 9, 1)])).with("compression", "compression", &[0]).end(),
            "sample type 9",
        ),
        (windows(Head::new(0).channels(&[("Y", 1, 0)])).with("compression", "compression", &[0]).end(), "sampling"),
        (
            windows(Head::new(0).channels(&[("Z", 1, 1), ("A", 1, 1)])).with("compression", "compression", &[0]).end(),
            "order",
        ),
        (
            windows(Head::new(0).channels(&[("Z", 1, 1), ("Z", 1, 1)])).with("compression", "compression", &[0]).end(),
            "order",
        ),
        (good().window("dataWindow", [5, 5, 1, 1]).window("displayWindow", [0, 0, 3, 3]).end(), "dataWindow"),
        (
            good().window("dataWindow", [i32::MIN, 0, i32::MAX, 1]).window("displayWindow", [0, 0, 3, 3]).end(),
            "dataWindow",
        ),
        (windows(Head::new(0x200).channels(&[("Y", 1, 1)]).with("compression", "compression", &[0])).end(), "tiles"),
        (
            windows(Head::new(0x200).channels(&[("Y", 1, 1)]).with("compression", "compression", &[0]))
                .with("tiles", "tiledesc", &[0; 9])
                .end(),
            "tiles",
        ),
    ];
    for (bytes, word) in cases {
        let error = refused(&bytes);
        assert!(matches!(error, Error::Invalid { .. }), "{error}");
        assert!(error.to_string().contains(word), "{word}: {error}");
    }
}

#[test]
fn what_is_not_supported_says_so_and_is_described_all_the_same() {
    let small = || Head::new(0).part(4, 4, 3);
    let deep = Head::new(0x800).part(4, 4, 2).with("type", "string", b"deepscanline").end();
    let odd = Head::new(0x800).part(4, 4, 2).with("type", "string", b"splats").end();
    let subsampled = Head::new(0)
        .channels(&[("BY", 1, 2), ("RY", 1, 2), ("Y", 1, 1)])
        .with("compression", "compression", &[3])
        .window("dataWindow", [0, 0, 3, 3])
        .window("displayWindow", [0, 0, 3, 3])
        .end();
    for (bytes, word) in [
        (deep, "deep data"),
        (odd, "the type \"splats\""),
        (Head::new(0).part(4, 4, 10).end(), "HTJ2K256 compression"),
        (Head::new(0).part(4, 4, 11).end(), "HTJ2K32 compression"),
        (Head::new(0).part(4, 4, 200).end(), "method 200 compression"),
        (subsampled, "channel \"BY\": subsampling by 2 × 2"),
    ] {
        let error = refused(&bytes);
        assert!(matches!(error, Error::Unsupported { .. }), "{error}");
        assert!(error.to_string().contains(word) && error.to_string().contains("ZIP"), "{error}");
        assert_eq!(describe(&bytes).unwrap().parts.len(), 1);
    }
    let newer = [&Head::new(0).0[..4], &[3, 0, 0, 0], &small().end()[8..]].concat();
    assert!(matches!(refused(&newer), Error::Unsupported { .. }));
    let flags = [&Head::new(0).0[..4], &[2, 0, 1, 0], &small().end()[8..]].concat();
    assert!(matches!(refused(&flags), Error::Unsupported { .. }));
}

#[test]
fn a_readable_part_beside_one_that_is_not() {
    let parts = [
        Part { name: Some("first"), ..Part::new(Method::ZIP16) },
        Part { name: Some("other"), ..Part::new(Method::ZIP16) },
    ];
    let mut bytes = exr(&parts);
    // The first part's compression becomes HTJ2K32, with the same number of chunks stated.
    let marker = b"compression\0compression\0\x01\0\0\0";
    let at = bytes.windows(marker.len()).position(|window| window == marker).unwrap() + marker.len();
    bytes[at] = 11;
    assert!(matches!(read(&bytes, &Selection::layer("first")), Err(Error::Unsupported { .. })));
    let picture = read(&bytes, &Selection::layer("other")).unwrap();
    assert_eq!(picture.channel("Z").unwrap().samples(), parts[1].float());
}

#[test]
fn interrupted_writers_are_recognized() {
    let part = Part::new(Method::ZIP16);
    let mut bytes = exr(std::slice::from_ref(&part));
    // The table of three chunks begins where the position of the first chunk is that of the table's end.
    let word = |at: usize| u64::from_le_bytes(bytes[at..at + 8].try_into().unwrap());
    let table = (0..bytes.len() - 8).find(|at| word(*at) == *at as u64 + 3 * 8).unwrap();
    bytes[table + 8..table + 16].fill(0);
    let message = refused(&bytes).to_string();
    assert!(message.contains("chunk 1 (rows 27 to 42)") && message.contains("interrupted"), "{message}");
}

#[test]
fn a_header_is_described() {
    let chromaticities: Vec<u8> =
        [0.64_f32, 0.33, 0.3, 0.6, 0.15, 0.06, 0.3127, 0.329].into_iter().flat_map(f32::to_le_bytes).collect();
    let bytes = Head::new(0x200)
        .channels(&[("Ocean.u", 2, 1), ("R", 1, 1), ("id", 0, 1)])
        .with("compression", "compression", &[9])
        .window("dataWindow", [-5, -6, 4, 3])
        .window("displayWindow", [0, 0, 639, 359])
        .with("tiles", "tiledesc", &[8, 0, 0, 0, 4, 0, 0, 0, 0x11])
        .with("chromaticities", "chromaticities", &chromaticities)
        .with("comments", "string", "größer".as_bytes())
        .end();
    let info = describe(&bytes).unwrap();
    let part = &info.parts[0];
    assert_eq!(info.kind, FileKind::Exr);
    assert_eq!((part.data, part.display), (Window::new(-5, -6, 5, 4), Window::sized(640, 360)));
    assert_eq!(part.compression, Compression::Dwab);
    assert_eq!(part.storage, Storage::Tiled { width: 8, height: 4, levels: Levels::Mip });
    assert_eq!(part.layers, ["Ocean", ""]);
    let kinds: Vec<SampleType> = part.channels.iter().map(|channel| channel.sample_type).collect();
    assert_eq!(kinds, [SampleType::Float, SampleType::Half, SampleType::Uint]);
    let expected = Chromaticities { red: [0.64, 0.33], green: [0.3, 0.6], blue: [0.15, 0.06], white: [0.3127, 0.329] };
    assert_eq!(part.chromaticities, Some(expected));
    assert!(part.attributes.contains(&("comments".into(), "größer".into())));
    assert!(part.attributes.contains(&("compression".into(), "DWAB".into())));
}

#[test]
fn other_files_are_refused() {
    let refused = |bytes: &[u8]| describe(bytes).unwrap_err();
    for (bytes, found) in [(&b""[..], "an empty file"), (b"v", "text"), (b"GIF89a..", "a GIF picture")] {
        let error = refused(bytes);
        assert!(matches!(error, Error::NoPicture { .. }) && error.to_string().contains(found), "{error}");
    }
    for bytes in [&b"\x76\x2f\x31\x01"[..], b"\x76\x2f\x31\x01\x02\0\0\0"] {
        let error = refused(bytes);
        assert!(matches!(error, Error::Invalid { .. }), "{error}");
    }
    let folder = tempfile::tempdir().unwrap();
    for path in [folder.path().to_path_buf(), folder.path().join("missing.exr")] {
        let error = trochoid_io::read(&path, &Selection::default(), &SMALL).unwrap_err();
        assert!(matches!(error, Error::Io { .. } | Error::NotAFile { .. }), "{error}");
        assert!(error.to_string().starts_with(&path.display().to_string()), "{error}");
    }
}
