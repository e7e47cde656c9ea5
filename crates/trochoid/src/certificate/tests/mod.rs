//! Tests of whole certificates: correct ones hold, and changes are detected.

mod changes;
mod forgeries;
mod signatures;

use super::image::StoredImage;
use super::*;
use crate::{OutputFile, load, output_files, write_output};
use serde_json::Value;
use std::collections::BTreeSet;
use std::path::{Path, PathBuf};
use trochoid_engine::{Buffers, Cache, Certifier, Plan, Settings, Silent};
use trochoid_io::{ExrChannel, ExrImage, FileKind, PngImage, SampleType, Samples, write_exr, write_png8, write_png16};

/// 70 × 66 pixels are 2 × 2 blocks. The edge of `step` lies on the first samples of the column at x = 35.
const DOCUMENT: &str = r##"{ "trochoid": 1, "format": { "width": 70, "height": 66, "samples": 4 },
  "working_space": "SPACE", "frames": { "first": 1, "last": 2 },
  "nodes": {
    "across": { "type": "ScreenX" }, "down": { "type": "ScreenY" },
    "wave": { "type": "FieldMath", "expression": "sin(9*a)*b", "a": "across", "b": "down" },
    "soft": { "type": "Clamp", "field": "wave", "min": { "keys": [[1, -1], [2, -0.9]] }, "max": 1.5 },
    "step": { "type": "Clamp", "field": "across", "min": 0.5018115942028986, "max": 0.5018115942028986 },
    "ramp": { "type": "Ramp", "weight": "soft", "stops": [
      { "at": 0, "color": "#102040" }, { "at": 0.4, "color": "#c05030" }, { "at": 1, "color": "#f8f0d0" } ] },
    "mix": { "type": "Mix", "a": "ramp", "b": "#204010", "weight": "step" },
    "three": { "type": "Normalize", "fields": ["across", "down"], "floor": 1 },
    "unused": { "type": "Constant", "color": "#ff00ff" }
  },
  "outputs": {
    "beauty": { "color": "mix", "file": "beauty.####.exr", "precision": "float", "require": { "guarantee": "hull" } },
    "print": { "color": "mix", "file": "print.####.png" },
    "deep": { "color": "ramp", "file": "deep.####.png", "precision": "uint16" },
    "mask": { "weights": "soft", "file": "mask.####.exr" },
    "three": { "weights": "three", "file": "three.####.exr" },
    "wave": { "field": "wave", "file": "three.####.exr" } } }"##;

/// Half a sky over a flat sea, without and with waves: depths that are infinite, colors, and weights of three.
const SKY: &str = r##"{ "trochoid": 1, "format": { "width": 24, "height": 16, "samples": 4 },
  "nodes": {
    "camera": { "type": "Camera", "position": [0, 3, 10], "target": [0, 3, 0], "fov": 50 },
    "depth": { "type": "Depth", "view": "view" },
    "far": { "type": "Clamp", "field": "depth", "min": 5, "max": 60 },
    "mix": { "type": "Mix", "a": "#102040", "b": "#f8f0d0", "weight": "far" },
    "sea": { "type": "GerstnerSea", "count": 0 },
    "view": { "type": "Render", "camera": "camera", "surfaces": ["sea"] }
  },
  "outputs": {
    "beauty": { "color": "mix", "file": "beauty.exr" },
    "depth": { "field": "depth", "file": "depth.exr" } } }"##;

/// Folder with a document and its rendered files.
struct Studio {
    folder: tempfile::TempDir,
}

impl Studio {
    fn new(document: &str) -> Self {
        let folder = tempfile::tempdir().expect("a folder");
        std::fs::write(folder.path().join("a.json"), document).expect("written");
        Self { folder }
    }

    fn of_space(space: &str) -> Self {
        Self::new(&DOCUMENT.replace("SPACE", space))
    }

    fn path(&self, name: &str) -> PathBuf {
        self.folder.path().join(name)
    }

    /// Renders a frame, and certifies every image next to it; returns the images.
    fn make(&self, frame: i64) -> Vec<PathBuf> {
        let graph = load(&self.path("a.json"), &[]).expect("valid").graph;
        let settings = Settings::default();
        let mut cache = Cache::new();
        let plan = Plan::new(&graph, &[], frame, &[], &settings).expect("small");
        let picture = plan.evaluate(&Buffers::new(), &mut cache, &Silent).expect("evaluated");
        let certifier = Certifier::new(&graph, &[], frame, &[], &settings).expect("small");
        let certified = certifier.certify(&Buffers::new(), &mut cache, &Silent).expect("certified");
        let files = output_files(&graph, &plan.outputs(), frame, false, None).expect("named");
        for file in &files {
            let metadata = crate::Fingerprints::new().metadata(&graph, file, &picture);
            write_output(&graph, &picture, file, &metadata).expect("written");
            let made = CertificateInputs { graph: &graph, file, frame, certified: &certified, settings: &settings };
            let path = certificate_of(&file.path);
            certify(&made, &path).expect("certified").write(&path, None).expect("written");
        }
        files.into_iter().map(|OutputFile { path, .. }| path).collect()
    }
}

fn certificate_of(image: &Path) -> PathBuf {
    image.with_extension("certificate.json")
}

fn check(certificate: &Path, image: &Path, choice: Choice) -> Result<Verification, CertificateError> {
    verify(&Request { certificate, image, choice, seed: 1, key: None, document: None, access: None }, &Silent)
}

/// Returns what does not hold.
fn failures(certificate: &Path, image: &Path) -> Vec<String> {
    let found = check(certificate, image, Choice::All).expect("readable");
    found.failures.iter().map(ToString::to_string).collect()
}

#[test]
fn every_kind_of_file_holds_in_every_space() {
    for space in ["linear-srgb", "acescg", "srgb"] {
        let studio = Studio::of_space(space);
        for image in studio.make(1) {
            for choice in [Choice::All, Choice::default(), Choice::Some(500)] {
                let found = check(&certificate_of(&image), &image, choice).expect("readable");
                assert!(found.holds(), "{space}, {}: {:#?}", image.display(), found.failures);
                assert_eq!((found.frame, found.blocks), (Some(1), 4));
                let looked: Vec<u64> = found.outputs.iter().map(|output| output.looked_at).collect();
                let expected = match choice {
                    Choice::All => 70 * 66..=70 * 66,
                    // Two strata may draw a pixel on their border, and the certificate names a few more.
                    Choice::Some(drawn) => drawn * 4 / 5..=drawn + 9,
                };
                assert!(looked.iter().all(|count| expected.contains(count)), "{looked:?}");
                let float = image.extension().is_some_and(|ending| ending == "exr");
                assert!(found.outputs.iter().all(|output| output.distance < if float { 1e-5 } else { 1e-6 }));
            }
        }
    }
}

#[test]
fn what_is_ambiguous_is_counted_and_the_rest_is_near() {
    let studio = Studio::of_space("linear-srgb");
    studio.make(1);
    let read = |name: &str| Certificate::read(&studio.path(name)).expect("read").expect("sealed").outputs.remove(0);
    let beauty = read("beauty.0001.certificate.json");
    assert_eq!((beauty.error.ambiguous.pixels, beauty.error.channels.len()), (66, 1));
    let ChannelBounds { all, clear, names, .. } = &beauty.error.channels[0];
    assert_eq!((all.bounded, clear.bounded, names.join("")), (70 * 66, 69 * 66, "RGB".into()));
    let [all, clear] = [all, clear].map(|summary| summary.max.expect("known").bound);
    assert!((0.05..0.3).contains(&all) && clear > 0.0 && clear < 1e-5, "{all}, {clear}");
    let display = beauty.error.display.as_ref().expect("a color");
    let shown = display.all.max.expect("known").bound;
    assert!(shown > all && shown < 0.5, "dark linear colors differ more in display values: {shown}");
    let p999 = display.all.p999.expect("known").bound;
    assert_eq!(display.clear.bounded, 69 * 66);
    assert!(p999 > 0.05, "one pixel in 70 is ambiguous: {p999}");
    let guarantee = beauty.guarantee.as_ref().expect("a color");
    assert_eq!((guarantee.held.as_deref(), guarantee.required.as_deref()), (Some("hull"), Some("hull")));
    assert_eq!(beauty.controls.map(|controls| (controls.corners, controls.values.len())), Some((4, 4)));
    let wave = read("three.0001.certificate.json");
    assert_eq!((wave.error.display, wave.controls, wave.guarantee), (None, None, None));
    assert!(beauty.unbounded.is_empty());
}

#[test]
fn seas_too_rough_for_references_are_ambiguous_and_hold() {
    let rough = r#""wavelength": 9, "spread": 1, "height": 4, "direction": 70, "sharpness": 10, "seed": 8"#;
    let studio = Studio::new(&SKY.replace(r#""count": 0"#, rough));
    for image in studio.make(1) {
        let found = check(&certificate_of(&image), &image, Choice::All).expect("readable");
        assert!(found.holds(), "{}: {:#?}", image.display(), found.failures);
        let Findings { given_up, ambiguous, pixels, .. } = found.outputs[0];
        assert!(0 < given_up && given_up <= ambiguous, "{given_up} given up, {ambiguous} of {pixels} ambiguous");
    }
}

#[test]
fn a_document_without_its_folder_is_enough_and_another_document_is_told() {
    let studio = Studio::of_space("srgb");
    studio.make(1);
    let (image, certificate) = (studio.path("print.0001.png"), studio.path("print.0001.certificate.json"));
    let against = |text: &str| {
        let graph = crate::parse("b.json", text, studio.folder.path(), &[]).expect("valid").graph;
        let request = Request {
            certificate: &certificate,
            image: &image,
            choice: Choice::Some(9),
            seed: 1,
            key: None,
            document: Some(&graph),
            access: None,
        };
        verify(&request, &Silent).expect("readable").failures
    };
    let text = DOCUMENT.replace("SPACE", "srgb");
    assert_eq!(against(&text), []);
    let [failed] = &against(&text.replace("#c05030", "#c05031"))[..] else { panic!("one failure") };
    assert!(failed.place.starts_with("b.json"), "{failed}");
    std::fs::remove_file(studio.path("a.json")).expect("removed");
    assert_eq!(failures(&certificate, &image), [""; 0]);
}

#[test]
fn other_frames_outputs_and_sizes_are_rejected() {
    let studio = Studio::of_space("linear-srgb");
    studio.make(1);
    studio.make(2);
    let certificate = studio.path("print.0001.certificate.json");
    let [_, ..] = &failures(&certificate, &studio.path("print.0002.png"))[..] else { panic!("another frame") };
    for (name, words) in [("deep.0001.png", "channels"), ("beauty.0001.exr", "kind of file")] {
        let failures = failures(&certificate, &studio.path(name));
        assert!(failures.iter().any(|failed| failed.contains(words)), "{name}: {failures:?}");
    }
    let plane = trochoid_image::Plane::filled(trochoid_image::Window::sized(70, 65), 0.5);
    let small = studio.path("small.png");
    write_png8(&small, &PngImage::new(70, 65, [Samples::plane(&plane); 3])).expect("written");
    let failures = failures(&certificate, &small);
    assert!(failures.iter().any(|failed| failed.contains("small.png: pixels")), "{failures:?}");
}

/// A picture with a picture as input, which has more colors than a certificate lists.
const READS: &str = r#"{ "trochoid": 1, "format": { "width": 12, "height": 10 },
  "nodes": { "in": { "type": "Read", "file": "in.exr", "as": "color" }, "across": { "type": "ScreenX" },
             "mix": { "type": "Mix", "a": "in", "b": [0.5, 0.25, 0.125], "weight": "across" } },
  "outputs": { "beauty": { "color": "mix", "file": "out.exr", "precision": "float" } } }"#;

fn write_input(path: &Path, seed: f32) {
    let noise = |index: usize| ((index as f32 * 12.9898 + seed).sin() * 43758.547).fract().abs();
    let samples: Vec<f32> = (0..3 * 120).map(noise).collect();
    let plane = |c: usize| Samples::contiguous(&samples[c * 120..(c + 1) * 120]);
    let channels = ["R", "G", "B"].into_iter().enumerate().map(|(c, name)| ExrChannel::float(name, plane(c))).collect();
    let image = ExrImage { channels, ..ExrImage::new(trochoid_image::Window::sized(12, 10)) };
    write_exr(path, &image).expect("written");
}

#[test]
fn inputs_are_found_from_the_certificate_and_held_against_their_hashes() {
    let studio = Studio::new(READS);
    write_input(&studio.path("in.exr"), 0.0);
    let image = studio.make(1).remove(0);
    let certificate = certificate_of(&image);
    let read = Certificate::read(&certificate).expect("read").expect("sealed");
    assert_eq!(read.inputs.iter().map(|input| input.path.as_str()).collect::<Vec<_>>(), ["in.exr"]);
    assert!(read.outputs[0].controls.as_ref().is_some_and(|controls| controls.corners > 10));
    assert_eq!(failures(&certificate, &image), [""; 0]);
    // The whole folder may move.
    let moved = tempfile::tempdir().expect("a folder");
    for name in ["in.exr", "out.exr", "out.certificate.json"] {
        std::fs::copy(studio.path(name), moved.path().join(name)).expect("copied");
    }
    let at = |name: &str| moved.path().join(name);
    assert_eq!(failures(&at("out.certificate.json"), &at("out.exr")), [""; 0]);
    write_input(&at("in.exr"), 1.0);
    let failed = failures(&at("out.certificate.json"), &at("out.exr"));
    assert!(failed.len() == 1 && failed[0].contains("in.exr: input"), "{failed:?}");
    std::fs::remove_file(at("in.exr")).expect("removed");
    let error = check(&at("out.certificate.json"), &at("out.exr"), Choice::All).expect_err("an input is missing");
    assert!(matches!(&error, CertificateError::NoInput { path, .. } if path.ends_with("in.exr")), "{error}");
}

/// Copies an image with its samples changed: by column, row, index of the channel by name, and value.
fn repaint(image: &Path, to: &Path, change: &dyn Fn(usize, usize, usize, f32) -> f32) {
    let mut picture = StoredImage::read(image).expect("read");
    let width = picture.window.width();
    for (index, channel) in picture.channels.iter_mut().enumerate() {
        for (at, sample) in channel.plane.samples_mut().iter_mut().enumerate() {
            *sample = change(at % width, at / width, index, *sample);
        }
    }
    store(&picture, to);
}

/// Stores an image with the same channels and types of samples.
fn store(picture: &StoredImage, to: &Path) {
    let samples = |name: &str| Samples::plane(&picture.channel(name).expect("there").plane);
    if picture.kind == FileKind::Png {
        let size = [picture.window.width() as u32, picture.window.height() as u32];
        let names: &[&str] = if picture.channels.len() == 3 { &["R", "G", "B"] } else { &["Y"] };
        let png = PngImage::new(size[0], size[1], names.iter().map(|name| samples(name)).collect::<Vec<_>>());
        if picture.channels[0].stored == SampleType::U16 { write_png16(to, &png) } else { write_png8(to, &png) }
            .expect("written");
        return;
    }
    let channel = |channel: &super::image::StoredChannel| {
        let (name, samples) = (channel.name.clone(), samples(&channel.name));
        if channel.stored == SampleType::Half {
            ExrChannel::half(name, samples)
        } else {
            ExrChannel::float(name, samples)
        }
    };
    let channels = picture.channels.iter().map(channel).collect();
    write_exr(to, &ExrImage { channels, ..ExrImage::new(picture.window) }).expect("written");
}

/// Copies an image with one pixel changed by `change` in every channel.
fn change_pixel(image: &Path, to: &Path, at: [usize; 2], change: impl Fn(f32) -> f32) {
    repaint(image, to, &|x, y, _, sample| if [x, y] == at { change(sample) } else { sample });
}

#[test]
fn every_changed_block_is_named() {
    let studio = Studio::of_space("linear-srgb");
    studio.make(1);
    let step = |sample: f32| if sample > 0.5 { sample - 1.0 / 255.0 } else { sample + 1.0 / 255.0 };
    let cases: [(&str, &dyn Fn(f32) -> f32); 2] = [("beauty.0001.exr", &f32::next_up), ("print.0001.png", &step)];
    for (name, change) in cases {
        let image = studio.path(name);
        let other = studio.path(&format!("changed.{name}"));
        for (index, at) in [[0, 0], [69, 63], [63, 64], [69, 65]].into_iter().enumerate() {
            change_pixel(&image, &other, at, change);
            let [failed] = &failures(&certificate_of(&image), &other)[..] else { panic!("one failure") };
            assert!(failed.contains(&format!("block {index}, x ")), "{failed}");
        }
        change_pixel(&image, &other, [0, 0], |sample| sample);
        assert_eq!(failures(&certificate_of(&image), &other), [""; 0], "the file itself may be another");
    }
}
