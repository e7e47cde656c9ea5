//! Tests of whole certificates: correct ones hold, and changes are detected.

use super::*;
use crate::{OutputFile, load, output_files, write_output};
use serde_json::Value;
use std::collections::BTreeSet;
use std::path::{Path, PathBuf};
use trochoid_engine::{Buffers, Cache, Certifier, Plan, Settings, Silent};
use trochoid_io::{ExrChannel, ExrImage, Limits, PngImage, Samples, Selection, read, write_exr, write_png8};

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
            let made = CertificateInputs {
                graph: &graph,
                file,
                frame: &picture,
                certified: &certified,
                settings: &settings,
                required: None,
            };
            let path = certificate_of(&file.path);
            certify(&made, &path).expect("certified").write(&path).expect("written");
        }
        files.into_iter().map(|OutputFile { path, .. }| path).collect()
    }
}

fn certificate_of(image: &Path) -> PathBuf {
    image.with_extension("certificate.json")
}

fn check(certificate: &Path, image: &Path, choice: Choice) -> Result<Verification, CertificateError> {
    verify(&Request { certificate, image, choice, document: None, access: None }, &Silent)
}

/// Returns what does not hold.
fn failures(certificate: &Path, image: &Path) -> Vec<String> {
    let found = check(certificate, image, Choice::All).expect("readable");
    found.failures.iter().map(ToString::to_string).collect()
}

/// Collects all single changes of a JSON value: of numbers, texts, Booleans, items and fields.
fn mutations(value: &Value, place: &str, all: &mut Vec<(String, Value)>) {
    let mut other = |value: Value| all.push((place.to_string(), value));
    match value {
        Value::Null => other(1.into()),
        Value::Bool(is) => other((!is).into()),
        Value::Number(number) => {
            let number = number.as_f64().expect("a number");
            other(if number == number.trunc() && number.abs() < 1e15 {
                (number as i64 + 1).into()
            } else {
                (number * 1.001).into()
            });
            other(Value::Null);
        }
        Value::String(text) => {
            let last = if text.ends_with('0') { "1" } else { "0" };
            let kept = text.char_indices().next_back().map_or("", |(at, _)| &text[..at]);
            other(format!("{kept}{last}").into());
        }
        Value::Array(items) => {
            let with = |change: &dyn Fn(&mut Vec<Value>)| {
                let mut items = items.clone();
                change(&mut items);
                Value::Array(items)
            };
            other(with(&|items| items.push(items.first().cloned().unwrap_or(0.into()))));
            if !items.is_empty() {
                other(with(&|items| drop(items.remove(0))));
            }
            for (index, item) in items.iter().enumerate() {
                let mut own = Vec::new();
                mutations(item, &format!("{place}[]"), &mut own);
                all.extend(own.into_iter().map(|(at, item)| (at, with(&|items| items[index] = item.clone()))));
            }
        }
        Value::Object(fields) => {
            let mut more = fields.clone();
            more.insert("more".into(), 1.into());
            other(Value::Object(more));
            for (name, value) in fields {
                let mut fewer = fields.clone();
                fewer.remove(name);
                all.push((format!("{place}.{name}"), Value::Object(fewer)));
                let mut own = Vec::new();
                mutations(value, &format!("{place}.{name}"), &mut own);
                for (at, value) in own {
                    let mut fields = fields.clone();
                    fields.insert(name.clone(), value);
                    all.push((at, Value::Object(fields)));
                }
            }
        }
    }
}

/// Returns all single changes of a certificate, as places and texts.
fn changed(certificate: &Path) -> Vec<(String, String)> {
    let text = std::fs::read_to_string(certificate).expect("there");
    let value: Value = serde_json::from_str(&text).expect("JSON");
    let mut all = Vec::new();
    mutations(&value, "", &mut all);
    all.into_iter().map(|(place, value)| (place, format!("{value:#}"))).collect()
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
                let expected = if choice == Choice::Some(500) { 500 } else { 70 * 66 };
                assert!(looked.iter().all(|count| *count == expected), "{looked:?}");
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
    let (pixels, ambiguous) = (&beauty.error.pixels, &beauty.error.ambiguous);
    assert_eq!((pixels.count, ambiguous.pixels, ambiguous.samples), (69 * 66, 66, 66));
    assert!(ambiguous.max.is_some_and(|max| max > 0.05 && max < 0.3), "{ambiguous:?}");
    assert_eq!(ambiguous.share, ambiguous.share_beyond_8_bit);
    assert!(pixels.max.is_some_and(|max| max > 0.0 && max < 1e-5), "{pixels:?}");
    assert!(beauty.guarantee.is_some_and(|g| g.held.as_deref() == Some("hull") && g.asked.as_deref() == Some("hull")));
    assert_eq!(beauty.controls.map(|controls| (controls.count, controls.corners)), Some((4, 4)));
    assert!(beauty.unbounded.is_empty());
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
fn no_single_change_of_a_certificate_passes() {
    let studio = Studio::of_space("linear-srgb");
    studio.make(1);
    let (image, certificate) = (studio.path("beauty.0001.exr"), studio.path("beauty.0001.certificate.json"));
    let forged = studio.path("forged.json");
    let changed = changed(&certificate);
    let places: BTreeSet<&str> = changed.iter().map(|(place, _)| place.as_str()).collect();
    for place in [".outputs[].error.samples.max", ".document.canonical.nodes.ramp.stops[].at", ".image.blocks[]"] {
        assert!(places.contains(place), "{place} is not among {places:?}");
    }
    assert!(changed.len() > 300, "{}", changed.len());
    for (place, text) in changed {
        std::fs::write(&forged, &text).expect("written");
        if let Ok(found) = check(&forged, &image, Choice::Some(1)) {
            assert!(!found.holds(), "{place}: {text}");
        }
    }
    // A duplicate field, of which readers take the first or the last; another spelling of the same number.
    let text = std::fs::read_to_string(&certificate).expect("there");
    for (from, to) in [("\"frame\": 1", "\"frame\": 2,\n  \"frame\": 1"), ("\"frame\": 1", "\"frame\": 1.0")] {
        std::fs::write(&forged, text.replacen(from, to, 1)).expect("written");
        assert!(!check(&forged, &image, Choice::Some(1)).is_ok_and(|found| found.holds()), "{to}");
    }
    std::fs::write(&forged, text.replace("\n", "\r\n")).expect("written");
    assert!(check(&forged, &image, Choice::Some(1)).expect("readable").holds(), "white space says nothing");
    for text in ["", "{}", "[1]", "{\"digest\": 5}"] {
        std::fs::write(&forged, text).expect("written");
        let error = check(&forged, &image, Choice::All).expect_err("no certificate");
        assert!(matches!(error, CertificateError::NoCertificate { .. }), "{error}");
    }
}

/// Copies an image with one pixel changed by `change` in every channel.
fn change_pixel(image: &Path, to: &Path, [x, y]: [usize; 2], change: impl Fn(f32) -> f32) {
    let mut picture = read(image, &Selection::default(), &Limits::default()).expect("read");
    let width = picture.data.width();
    for channel in &mut picture.channels {
        let sample = &mut channel.plane.samples_mut()[y * width + x];
        *sample = change(*sample);
    }
    let samples = |index: usize| Samples::plane(&picture.channels[index].plane);
    if to.extension().is_some_and(|ending| ending == "png") {
        let size = [picture.data.width() as u32, picture.data.height() as u32];
        write_png8(to, &PngImage::new(size[0], size[1], [samples(0), samples(1), samples(2)])).expect("written");
    } else {
        let channel = |(index, name): (usize, &str)| ExrChannel::float(name, samples(index));
        let channels = ["R", "G", "B"].into_iter().enumerate().map(channel).collect();
        write_exr(to, &ExrImage { channels, ..ExrImage::new(picture.data) }).expect("written");
    }
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
    assert!(read.outputs[0].controls.as_ref().is_some_and(|controls| controls.count > LISTED && controls.corners > 10));
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

/// Changes a certificate, and recomputes its digest.
fn forge(certificate: &Path, forged: &Path, change: impl FnOnce(&mut Certificate)) {
    let mut read = Certificate::read(certificate).expect("read").expect("sealed");
    change(&mut read);
    read.write(forged).expect("written");
}

#[test]
fn who_lowers_the_error_and_makes_the_digest_fit_is_caught_by_the_references() {
    let studio = Studio::of_space("linear-srgb");
    studio.make(1);
    let (image, certificate) = (studio.path("beauty.0001.exr"), studio.path("beauty.0001.certificate.json"));
    let forged = studio.path("forged.json");
    forge(&certificate, &forged, |_| ());
    assert_eq!(failures(&forged, &image), [""; 0], "nothing is forged yet");
    forge(&certificate, &forged, |c| {
        let error = &mut c.outputs[0].error;
        (error.pixels.max, error.pixels.p999) = (Some(1e-12), Some(1e-12));
    });
    let found = check(&forged, &image, Choice::Some(200)).expect("readable");
    assert!(found.failures.iter().any(|failed| failed.expected.contains("by the references")), "{:?}", found.failures);
    // The maximum may be true while the percentile is false.
    forge(&certificate, &forged, |c| c.outputs[0].error.pixels.p999 = Some(1e-12));
    let found = check(&forged, &image, Choice::Some(2000)).expect("readable");
    assert!(found.failures.len() == 1 && found.failures[0].place.ends_with("p999"), "{:?}", found.failures);
}

#[test]
fn who_changes_pixels_with_their_hashes_is_caught_by_the_references() {
    let studio = Studio::of_space("linear-srgb");
    studio.make(1);
    let (image, certificate) = (studio.path("beauty.0001.exr"), studio.path("beauty.0001.certificate.json"));
    let (forged, painted) = (studio.path("forged.json"), studio.path("painted.exr"));
    let forge_with = |change: &dyn Fn(f32) -> f32| {
        change_pixel(&image, &painted, [40, 3], change);
        let hashes = super::image::StoredImage::read(&painted).expect("read").hashes("painted.exr".into());
        forge(&certificate, &forged, |c| c.image = hashes);
        failures(&forged, &painted)
    };
    assert_eq!(forge_with(&|sample| sample), [""; 0]);
    let failed = forge_with(&|sample| sample + 1e-4);
    assert!(failed.iter().any(|failed| failed.contains("pixel (40, 3)")), "{failed:?}");
    // Even without an error bound, the hull is checked.
    change_pixel(&image, &painted, [40, 3], |_| 0.9);
    let hashes = super::image::StoredImage::read(&painted).expect("read").hashes("painted.exr".into());
    forge(&certificate, &forged, |c| {
        c.image = hashes;
        (c.outputs[0].error.pixels.max, c.outputs[0].error.pixels.p999) = (None, None);
    });
    let failed = failures(&forged, &painted);
    assert!(failed.len() == 1 && failed[0].contains("(40, 3)") && failed[0].contains("outside the hull"), "{failed:?}");
}

/// Changes that the check cannot detect if the digest is recomputed: weaker claims than possible, counts that only the
/// fast path knows, and names of files.
const BEYOND_CHECKING: &[&str] = &[
    ".document.folder",
    ".image.file",
    ".optimized",
    ".outputs[].audit.judged",
    ".outputs[].audit.margin",
    ".outputs[].audit.weight_min",
    ".outputs[].audit.weight_sum_max_deviation",
    ".outputs[].error.ambiguous.map",
    ".outputs[].error.ambiguous.max",
    ".outputs[].error.ambiguous.share_beyond_8_bit",
    ".outputs[].error.pixels.max",
    ".outputs[].error.pixels.p999",
    ".outputs[].error.samples.max",
    ".outputs[].error.samples.p999",
    ".outputs[].guarantee.asked",
];

#[test]
fn most_changes_are_found_even_where_the_digest_fits() {
    let studio = Studio::of_space("linear-srgb");
    studio.make(1);
    let (image, certificate) = (studio.path("beauty.0001.exr"), studio.path("beauty.0001.certificate.json"));
    let forged = studio.path("forged.json");
    let honest = Certificate::read(&certificate).expect("read").expect("sealed");
    let mut passed = BTreeSet::new();
    for (place, text) in changed(&certificate) {
        let Ok(read) = serde_json::from_str::<Certificate>(&text) else { continue };
        // Changes of the document change its hash, so one of them is enough.
        // A missing field reads the same as `null`.
        if place.starts_with(".plan") && read.plan == honest.plan {
            continue;
        }
        if place == ".digest" || (place.starts_with(".document.canonical") && !place.contains("stops[].at")) {
            continue;
        }
        read.write(&forged).expect("written");
        if check(&forged, &image, Choice::Some(4)).is_ok_and(|found| found.holds()) {
            passed.insert(place);
        }
    }
    let unknown: Vec<&String> = passed.iter().filter(|place| !BEYOND_CHECKING.contains(&place.as_str())).collect();
    assert!(unknown.is_empty(), "{unknown:#?}");
}
