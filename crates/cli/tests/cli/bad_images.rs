//! Pictures that must not be read: the exit code is 1, and nothing is written. The messages are stored in
//! `tests/told/pictures`.

use crate::scene::Scene;
use crate::told::Told;
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

/// Writes a good EXR with `with` in place of its bytes, `skip` bytes after `find`, which is the start of an attribute.
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

/// A bad picture: the name of the case and of the file, how it is made, and the knobs of the Read.
struct Case {
    name: &'static str,
    file: &'static str,
    make: fn(&Path),
    knobs: &'static str,
}

const COLOR: &str = r#""as": "color""#;
const FIELD: &str = r#""as": "field", "channels": ["G"]"#;
const MASK: &str = r#""as": "weights", "channels": ["G"]"#;

/// The bad pictures. In an EXR header, the name and the type of an attribute end with a 0 byte each; four bytes of
/// length and the value follow.
const CASES: &[Case] = &[
    Case { name: "gone", file: "gone.exr", make: |_| (), knobs: COLOR },
    Case { name: "a_folder", file: "in.exr", make: |p| fs::create_dir(p).unwrap(), knobs: COLOR },
    Case { name: "empty", file: "in.exr", make: |p| fs::write(p, "").unwrap(), knobs: COLOR },
    Case { name: "no_picture", file: "in.exr", make: |p| fs::write(p, "not a picture at all").unwrap(), knobs: COLOR },
    Case { name: "cut_signature", file: "in.png", make: |p| fs::write(p, "\u{89}PNG\r\n").unwrap(), knobs: COLOR },
    Case {
        name: "cut_early",
        file: "in.exr",
        make: |p| {
            gray(p);
            truncated(p, 0.2);
        },
        knobs: COLOR,
    },
    Case {
        name: "cut_late",
        file: "in.exr",
        make: |p| {
            gray(p);
            truncated(p, 0.95);
        },
        knobs: COLOR,
    },
    Case {
        name: "huge_window",
        file: "in.exr",
        make: |p| patched(p, b"dataWindow\0box2i\0", 4, &[0, 0, 0, 0, 0, 0, 0, 0, 255, 255, 1, 0, 255, 255, 1, 0]),
        knobs: COLOR,
    },
    Case {
        name: "reversed_window",
        file: "in.exr",
        make: |p| patched(p, b"dataWindow\0box2i\0", 4, &[9, 0, 0, 0, 0, 0, 0, 0, 3, 0, 0, 0, 1, 0, 0, 0]),
        knobs: COLOR,
    },
    Case {
        name: "unknown_compression",
        file: "in.exr",
        make: |p| patched(p, b"compression\0compression\0", 4, &[77]),
        knobs: COLOR,
    },
    Case {
        name: "unknown_sample_type",
        file: "in.exr",
        make: |p| patched(p, b"channels\0chlist\0", 4 + 2, &[9]),
        knobs: COLOR,
    },
    Case {
        name: "subsampled",
        file: "in.exr",
        make: |p| patched(p, b"channels\0chlist\0", 4 + 2 + 8, &[2, 0, 0, 0]),
        knobs: COLOR,
    },
    Case { name: "no_layer", file: "in.exr", make: gray, knobs: r#""as": "color", "layer": "beauty""# },
    Case { name: "no_part", file: "in.exr", make: gray, knobs: r#""as": "color", "part": "sea""# },
    Case { name: "no_channel", file: "in.exr", make: gray, knobs: r#""as": "field", "channels": ["Z"]"# },
    Case { name: "too_few_channels", file: "in.exr", make: gray, knobs: r#""as": "weights""# },
    Case { name: "no_colors", file: "in.exr", make: |p| exr(p, &["Y", "Z"], |_, _| 0.5), knobs: COLOR },
    Case {
        name: "negative",
        file: "in.exr",
        make: |p| exr(p, &RGB, |c, i| if (c, i) == (1, 6) { -0.25 } else { 0.5 }),
        knobs: COLOR,
    },
    Case {
        name: "infinite",
        file: "in.exr",
        make: |p| exr(p, &RGB, |c, i| if (c, i) == (2, 3) { f32::INFINITY } else { 0.5 }),
        knobs: COLOR,
    },
    Case {
        name: "no_number",
        file: "in.exr",
        make: |p| exr(p, &RGB, |_, i| if i == 0 { f32::NAN } else { 0.5 }),
        knobs: COLOR,
    },
    Case {
        name: "no_number_in_a_field",
        file: "in.exr",
        make: |p| exr(p, &RGB, |_, i| if i == 5 { f32::NAN } else { 0.5 }),
        knobs: FIELD,
    },
    Case {
        name: "no_mask",
        file: "in.exr",
        make: |p| exr(p, &RGB, |_, i| if i == 5 { 1.5 } else { 0.5 }),
        knobs: MASK,
    },
    Case {
        name: "negative_mask",
        file: "in.exr",
        make: |p| exr(p, &RGB, |_, i| if i == 7 { -0.5 } else { 0.5 }),
        knobs: MASK,
    },
    Case {
        name: "weights_beyond_one",
        file: "in.exr",
        make: |p| exr(p, &RGB, |_, _| 0.5),
        knobs: r#""as": "weights", "channels": ["R", "G", "B"]"#,
    },
    Case {
        name: "another_size",
        file: "in.exr",
        make: |p| {
            let plane = Plane::filled(Window::sized(9, 9), 0.5);
            let channels = RGB.map(|name| ExrChannel::half(name, Samples::plane(&plane))).into();
            write_exr(p, &ExrImage { channels, ..ExrImage::new(Window::sized(9, 9)) }).unwrap();
        },
        knobs: COLOR,
    },
    Case { name: "no_alpha", file: "in.exr", make: gray, knobs: r#""as": "color", "premultiplied": true"# },
    Case {
        name: "cut_png",
        file: "in.png",
        make: |p| {
            png(p);
            truncated(p, 0.6);
        },
        knobs: COLOR,
    },
    Case {
        name: "huge_png",
        file: "in.png",
        make: |p| {
            png(p);
            let mut bytes = fs::read(p).unwrap();
            // Width and height follow the signature, and the length and name of the first chunk.
            bytes[16..24].copy_from_slice(&[0x7f, 255, 255, 255, 0x7f, 255, 255, 255]);
            fs::write(p, bytes).unwrap();
        },
        knobs: COLOR,
    },
    Case {
        name: "cut_jpeg",
        file: "in.jpg",
        make: |p| fs::write(p, [0xff, 0xd8, 0xff, 0xe0, 0, 16, b'J', b'F', b'I', b'F']).unwrap(),
        knobs: COLOR,
    },
    Case {
        name: "cut_tiff",
        file: "in.tif",
        make: |p| fs::write(p, b"II*\0\x08\0\0\0\xff\xff").unwrap(),
        knobs: COLOR,
    },
];

#[test]
fn bad_pictures_are_code_1_with_a_message_of_their_own_and_nothing_is_written() {
    let mut told = Told::new("pictures");
    for case in CASES {
        let kind = ["color", "field", "weights"].into_iter().find(|kind| case.knobs.contains(kind)).unwrap();
        let scene = Scene::new(&format!(
            r##"{{ "trochoid": 1, "format": {{ "width": 4, "height": 2 }},
              "nodes": {{ "in": {{ "type": "Read", "file": "{}", {} }} }},
              "outputs": {{ "picture": {{ "{kind}": "in", "file": "out.exr" }} }} }}"##,
            case.file, case.knobs
        ));
        (case.make)(&scene.path(case.file));
        told.is(case.name, 1, &scene, &["render", "a.json"]);
        assert!(scene.files().iter().all(|name| name == case.file), "{}: {:?}", case.name, scene.files());
    }
    told.ends();
}
