//! Pictures that must not be read: each has its own words, exit code 1, and nothing is written.

use crate::scene::Scene;
use std::fs;
use std::path::Path;
use trochoid::io::{ExrChannel, ExrImage, PngImage, Samples, write_exr, write_png8};
use trochoid::{Plane, Window};

const WINDOW: Window = Window::sized(4, 2);

/// Writes an EXR of 4 × 2 pixels; `value` gives each channel's sample by index.
fn exr(path: &Path, channels: &[&str], value: impl Fn(usize, usize) -> f32) {
    let planes: Vec<Plane> = (0..channels.len())
        .map(|channel| Plane::new(WINDOW, (0..8).map(|i| value(channel, i)).collect()).unwrap())
        .collect();
    let channels =
        channels.iter().zip(&planes).map(|(name, plane)| ExrChannel::float(*name, Samples::plane(plane))).collect();
    write_exr(path, &ExrImage { channels, ..ExrImage::new(WINDOW) }).unwrap();
}

const RGB: [&str; 3] = ["R", "G", "B"];

fn gray(path: &Path) {
    exr(path, &RGB, |_, _| 0.5);
}

/// Changes a good EXR's bytes: `find` (the start of an attribute) and then `skip` bytes on.
fn patched(path: &Path, find: &[u8], skip: usize, with: &[u8]) {
    gray(path);
    let mut bytes = fs::read(path).unwrap();
    let at = bytes.windows(find.len()).position(|window| window == find).unwrap() + find.len() + skip;
    bytes[at..at + with.len()].copy_from_slice(with);
    fs::write(path, bytes).unwrap();
}

fn truncated(path: &Path, keep: f64) {
    let bytes = fs::read(path).unwrap();
    fs::write(path, &bytes[..(bytes.len() as f64 * keep) as usize]).unwrap();
}

fn png(path: &Path) {
    let pixels: Vec<[f32; 3]> = (0..8).map(|i| [i as f32 / 7.0, 0.3, 0.6]).collect();
    write_png8(path, &PngImage::new(4, 2, Samples::rgb(&pixels))).unwrap();
}

/// A picture: its name, how it is made, the knobs of the Read, and words of its diagnostic.
struct Case {
    file: &'static str,
    make: fn(&Path),
    knobs: &'static str,
    words: &'static [&'static str],
}

const COLOR: &str = r#""as": "color""#;
const FIELD: &str = r#""as": "field", "channels": ["G"]"#;
const MASK: &str = r#""as": "weights", "channels": ["G"]"#;

/// Attribute names end with a 0 byte, their types too, then four bytes of length stand before the value.
const CASES: &[Case] = &[
    Case { file: "gone.exr", make: |_| (), knobs: COLOR, words: &["gone.exr", "cannot open"] },
    Case { file: "in.exr", make: |p| fs::create_dir(p).unwrap(), knobs: COLOR, words: &["in.exr"] },
    Case { file: "in.exr", make: |p| fs::write(p, "").unwrap(), knobs: COLOR, words: &["in.exr", "found"] },
    Case {
        file: "in.exr",
        make: |p| fs::write(p, "not a picture at all").unwrap(),
        knobs: COLOR,
        words: &["in.exr", "found"],
    },
    Case { file: "in.png", make: |p| fs::write(p, "\u{89}PNG\r\n").unwrap(), knobs: COLOR, words: &["in.png"] },
    Case {
        file: "in.exr",
        make: |p| {
            gray(p);
            truncated(p, 0.2);
        },
        knobs: COLOR,
        words: &["in.exr", "damaged or incomplete"],
    },
    Case {
        file: "in.exr",
        make: |p| {
            gray(p);
            truncated(p, 0.95);
        },
        knobs: COLOR,
        words: &["in.exr", "damaged or incomplete"],
    },
    Case {
        file: "in.exr",
        make: |p| patched(p, b"dataWindow\0box2i\0", 4, &[0, 0, 0, 0, 0, 0, 0, 0, 255, 255, 1, 0, 255, 255, 1, 0]),
        knobs: COLOR,
        words: &["in.exr", "at most"],
    },
    Case {
        file: "in.exr",
        make: |p| patched(p, b"dataWindow\0box2i\0", 4, &[9, 0, 0, 0, 0, 0, 0, 0, 3, 0, 0, 0, 1, 0, 0, 0]),
        knobs: COLOR,
        words: &["in.exr", "window"],
    },
    Case {
        file: "in.exr",
        make: |p| patched(p, b"compression\0compression\0", 4, &[77]),
        knobs: COLOR,
        words: &["in.exr", "compression"],
    },
    Case {
        file: "in.exr",
        make: |p| patched(p, b"channels\0chlist\0", 4 + 2, &[9]),
        knobs: COLOR,
        words: &["in.exr", "channel"],
    },
    Case {
        file: "in.exr",
        make: |p| patched(p, b"channels\0chlist\0", 4 + 2 + 8, &[2, 0, 0, 0]),
        knobs: COLOR,
        words: &["in.exr", "subsampl", "not supported"],
    },
    Case { file: "in.exr", make: gray, knobs: r#""as": "color", "layer": "beauty""#, words: &["no layer \"beauty\""] },
    Case { file: "in.exr", make: gray, knobs: r#""as": "color", "part": "sea""#, words: &["no part \"sea\""] },
    Case {
        file: "in.exr",
        make: gray,
        knobs: r#""as": "field", "channels": ["Z"]"#,
        words: &["no channel \"Z\"", "\"R\""],
    },
    Case { file: "in.exr", make: gray, knobs: r#""as": "weights""#, words: &["in.exr", "channel"] },
    Case { file: "in.exr", make: |p| exr(p, &["Y", "Z"], |_, _| 0.5), knobs: COLOR, words: &["in.exr"] },
    Case {
        file: "in.exr",
        make: |p| exr(p, &RGB, |c, i| if (c, i) == (1, 6) { -0.25 } else { 0.5 }),
        knobs: COLOR,
        words: &["G", "(2, 1)", "-0.25", "repair"],
    },
    Case {
        file: "in.exr",
        make: |p| exr(p, &RGB, |c, i| if (c, i) == (2, 3) { f32::INFINITY } else { 0.5 }),
        knobs: COLOR,
        words: &["B", "(3, 0)", "inf", "repair"],
    },
    Case {
        file: "in.exr",
        make: |p| exr(p, &RGB, |_, i| if i == 0 { f32::NAN } else { 0.5 }),
        knobs: COLOR,
        words: &["(0, 0)", "NaN", "repair"],
    },
    Case {
        file: "in.exr",
        make: |p| exr(p, &RGB, |_, i| if i == 5 { f32::NAN } else { 0.5 }),
        knobs: FIELD,
        words: &["G", "(1, 1)", "NaN", "repair"],
    },
    Case {
        file: "in.exr",
        make: |p| exr(p, &RGB, |_, i| if i == 5 { 1.5 } else { 0.5 }),
        knobs: MASK,
        words: &["G", "(1, 1)", "1.5", "repair"],
    },
    Case {
        file: "in.exr",
        make: |p| exr(p, &RGB, |_, i| if i == 7 { -0.5 } else { 0.5 }),
        knobs: MASK,
        words: &["G", "(3, 1)", "-0.5"],
    },
    Case {
        file: "in.exr",
        make: |p| exr(p, &RGB, |_, _| 0.5),
        knobs: r#""as": "weights", "channels": ["R", "G", "B"]"#,
        words: &["(0, 0)", "1.5"],
    },
    Case {
        file: "in.exr",
        make: |p| {
            let plane = Plane::filled(Window::sized(9, 9), 0.5);
            let channels = RGB.map(|name| ExrChannel::half(name, Samples::plane(&plane))).into();
            write_exr(p, &ExrImage { channels, ..ExrImage::new(Window::sized(9, 9)) }).unwrap();
        },
        knobs: COLOR,
        words: &["9", "4", "fit"],
    },
    Case {
        file: "in.exr",
        make: gray,
        knobs: r#""as": "color", "premultiplied": true"#,
        words: &["expected a channel \"A\" to divide by"],
    },
    Case {
        file: "in.png",
        make: |p| {
            png(p);
            truncated(p, 0.6);
        },
        knobs: COLOR,
        words: &["in.png", "damaged or incomplete"],
    },
    Case {
        file: "in.png",
        make: |p| {
            png(p);
            let mut bytes = fs::read(p).unwrap();
            // Width and height stand behind the signature and the length and name of the first chunk.
            bytes[16..24].copy_from_slice(&[0x7f, 255, 255, 255, 0x7f, 255, 255, 255]);
            fs::write(p, bytes).unwrap();
        },
        knobs: COLOR,
        words: &["in.png"],
    },
    Case {
        file: "in.jpg",
        make: |p| fs::write(p, [0xff, 0xd8, 0xff, 0xe0, 0, 16, b'J', b'F', b'I', b'F']).unwrap(),
        knobs: COLOR,
        words: &["in.jpg"],
    },
    Case {
        file: "in.tif",
        make: |p| fs::write(p, b"II*\0\x08\0\0\0\xff\xff").unwrap(),
        knobs: COLOR,
        words: &["in.tif"],
    },
];

#[test]
fn bad_pictures_are_code_1_each_with_its_own_words_and_nothing_is_written() {
    let mut seen = Vec::new();
    for (index, case) in CASES.iter().enumerate() {
        let kind = ["color", "field", "weights"].into_iter().find(|kind| case.knobs.contains(kind)).unwrap();
        let scene = Scene::new(&format!(
            r##"{{ "trochoid": 1, "format": {{ "width": 4, "height": 2 }},
              "nodes": {{ "in": {{ "type": "Read", "file": "{}", {} }} }},
              "outputs": {{ "picture": {{ "{kind}": "in", "file": "out.exr" }} }} }}"##,
            case.file, case.knobs
        ));
        (case.make)(&scene.path(case.file));
        let run = scene.run(&["render", "a.json"]).code(1);
        assert_eq!(run.out, "", "case {index}");
        assert!(run.err.contains("node \"in\" (Read)"), "case {index}: {}", run.err);
        for word in case.words {
            assert!(run.err.contains(word), "case {index}: no \"{word}\" in {}", run.err);
        }
        assert!(scene.files().iter().all(|name| name == case.file), "case {index}: {:?}", scene.files());
        seen.push(run.err.replace(&scene.path("").display().to_string(), ""));
    }
    assert!(seen.len() >= 20);
    seen.sort();
    let distinct = seen.windows(2).filter(|pair| pair[0] != pair[1]).count() + 1;
    assert!(distinct + 2 >= seen.len(), "too few messages of their own: {seen:#?}");
}
