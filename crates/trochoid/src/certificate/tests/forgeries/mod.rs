//! Forgeries: certificates and images that someone changed on purpose, as consistently as possible, with digests made
//! to fit.

mod ways;

use super::*;
use crate::certificate::bounds::PictureBounds;
use crate::certificate::color::Coding;
use crate::certificate::level::{BoundMap, PixelBound};
use crate::certificate::make::{controls_of, stored_channels};
use ways::{CLAIMS, DEPTHS, HERE, PIXELS, STATEMENTS, UNCLEAR, Way, inside, shifted};

/// A forger's copy of a certificate and its image.
struct Forgery {
    certificate: Certificate,
    image: StoredImage,
    /// Graph of the document, to describe changed maps as an honest certificate would.
    graph: trochoid_graph::CheckedGraph,
}

/// Bounds and ambiguity of the pixels of an output, for changes.
struct Stated {
    bounds: Vec<PixelBound>,
    ambiguous: Vec<bool>,
}

impl Forgery {
    fn of(studio: &Studio, image: &Path) -> Self {
        let certificate = Certificate::read(&certificate_of(image)).expect("read").expect("sealed");
        let text = certificate.document.canonical.get();
        let graph = crate::parse("a.json", text, studio.folder.path(), &[]).expect("valid").graph;
        Self { certificate, image: StoredImage::read(image).expect("read"), graph }
    }

    /// Returns the samples of a channel.
    fn samples(&mut self, channel: &str) -> &mut [f32] {
        let channel = self.image.channels.iter_mut().find(|found| found.name == channel);
        channel.expect("there").plane.samples_mut()
    }

    /// Changes a pixel in every channel.
    fn paint(&mut self, pixel: usize, change: impl Fn(usize, f32) -> f32) {
        for (index, channel) in self.image.channels.iter_mut().enumerate() {
            let sample = &mut channel.plane.samples_mut()[pixel];
            *sample = change(index, *sample);
        }
    }

    fn output(&mut self) -> &mut CertifiedOutput {
        &mut self.certificate.outputs[0]
    }

    /// Changes what is stated of the pixels of the first output's first map, and all that follows from it.
    fn state(&mut self, change: impl FnOnce(&mut Stated)) {
        let written = &self.certificate.outputs[0];
        let spec = self.graph.outputs().iter().find(|spec| spec.name == written.name).expect("an output");
        let window = self.graph.format().window();
        let honest = PictureBounds::decode(&written.error, spec.kind, window).expect("honest maps");
        let all = 0..window.area();
        let mut stated = Stated {
            bounds: all.clone().map(|pixel| honest.maps()[0].at(pixel)).collect(),
            ambiguous: all.map(|pixel| honest.is_ambiguous(pixel)).collect(),
        };
        change(&mut stated);
        let maps = vec![BoundMap::new(stated.bounds.into_iter())];
        let bounds = PictureBounds::stated(window, stated.ambiguous.into_iter(), maps);
        let coding = Coding::new(spec.kind, self.graph.space(), self.image.kind == FileKind::Png);
        let channels = stored_channels(&self.image, &written.channels).expect("there");
        let error = bounds.described(spec, self.graph.space(), coding, &channels);
        self.output().error = error;
    }

    /// Changes the document, and its hash.
    fn document(&mut self, from: &str, to: &str) {
        let text = self.certificate.document.canonical.get();
        assert!(text.contains(from), "{text}");
        let text = text.replace(from, to);
        self.certificate.document.hash = blake3::hash(text.as_bytes()).to_hex().to_string();
        self.certificate.document.canonical = serde_json::value::RawValue::from_string(text).expect("JSON");
    }

    /// Writes both, with hashes and counts that fit, and returns their paths.
    fn seal(mut self, studio: &Studio) -> (PathBuf, PathBuf) {
        let ending = if self.image.kind == FileKind::Png { "png" } else { "exr" };
        let (certificate, image) = (studio.path("forged.json"), studio.path(&format!("forged.{ending}")));
        store(&self.image, &image);
        let hashes = StoredImage::read(&image).expect("read").hashes("forged".into());
        if self.certificate.image.pixels != hashes.pixels {
            self.certificate.image = hashes;
        }
        self.certificate.write(&certificate, None).expect("written");
        (certificate, image)
    }
}

/// A toon sea whose bursts are `HEIGHT` high, seen by rays and baked.
const TOON: &str = r##"{ "trochoid": 1, "format": { "width": 24, "height": 16 },
  "nodes": {
    "camera": { "type": "Camera", "position": [4, 6, 14], "target": [4, 0, 3], "fov": 50 },
    "sea": { "type": "ToonSea", "columns": 24, "rows": 20, "spacing": 0.4, "preroll": 300, "bursts": [
      { "path": [1, 1, 3, 6, 6, 2, 8, 6], "height": HEIGHT, "along": 1.5, "across": 2 } ] },
    "view": { "type": "Render", "camera": "camera", "surfaces": ["sea"], "points": "exact" },
    "high": { "type": "Height", "view": "view" },
    "foam": { "type": "Rift", "view": "view" },
    "bake": { "type": "Bake", "sea": "sea", "width": 9, "depth": 7 }
  },
  "outputs": {
    "high": { "field": "high", "file": "high.exr", "precision": "float" },
    "foam": { "field": "foam", "file": "foam.exr", "precision": "float" },
    "bake": { "field": "bake.height", "file": "bake.exr", "precision": "float" },
    "normal": { "field": "bake.normal", "file": "normal.exr", "precision": "float" } } }"##;

/// Pictures of a simulation that is off by a hundred-thousandth, with certificates that are true of it, are not those of
/// the document; those of the simulation itself are.
#[test]
fn a_disturbed_simulation_is_detected() {
    let toon = |height: &str| Studio::new(&TOON.replace("HEIGHT", height));
    let (honest, disturbed) = (toon("3"), toon("3.00003"));
    let images = honest.make(1);
    for (image, other) in images.iter().zip(disturbed.make(1)) {
        let name = image.file_name().and_then(|name| name.to_str()).expect("a name");
        assert_eq!(failures(&certificate_of(image), image), Vec::<String>::new(), "{name}");
        let certificate = Certificate::read(&certificate_of(image)).expect("read").expect("sealed");
        let all = &certificate.outputs[0].error.channels[0].clear;
        let bound = all.max.as_ref().expect("bounded").bound;
        assert!(bound < 4e-6 && all.bounded > 90, "{name}: {bound:e} of {}", all.bounded);
        let mut forgery = Forgery::of(&honest, image);
        forgery.image = StoredImage::read(&other).expect("read");
        let (certificate, image) = forgery.seal(&honest);
        assert!(!failures(&certificate, &image).is_empty(), "{name}");
    }
}

/// Returns the ways that pass a check of all pixels.
fn passing(studio: &Studio, ways: &[Way]) -> Vec<&'static str> {
    let images = studio.make(1);
    // Nothing is forged yet.
    for image in &images {
        let (certificate, sealed) = Forgery::of(studio, image).seal(studio);
        let found = check(&certificate, &sealed, Choice::Some(9)).expect("readable");
        assert!(found.holds(), "{}: {:?}", image.display(), found.failures);
    }
    let passes = |(name, image, change): &Way| {
        let image =
            images.iter().find(|path| path.file_name().is_some_and(|own| own.to_string_lossy().starts_with(image)));
        let mut forgery = Forgery::of(studio, image.expect("rendered"));
        change(&mut forgery);
        let (certificate, image) = forgery.seal(studio);
        match check(&certificate, &image, Choice::All) {
            Ok(found) => found.holds().then_some(*name),
            // Refused, because document and picture do not go together at all.
            Err(_) => None,
        }
    };
    ways.iter().filter_map(passes).collect()
}

#[test]
fn no_changed_pixel_passes() {
    assert_eq!(passing(&Studio::of_space("linear-srgb"), PIXELS), [""; 0]);
}

#[test]
fn no_other_bound_or_ambiguity_passes() {
    assert_eq!(passing(&Studio::of_space("linear-srgb"), STATEMENTS), [""; 0]);
}

#[test]
fn no_other_claim_passes() {
    assert_eq!(passing(&Studio::of_space("linear-srgb"), CLAIMS), [""; 0]);
}

#[test]
fn no_other_depth_passes() {
    assert_eq!(passing(&Studio::new(SKY), DEPTHS), [""; 0]);
    let ways = [PIXELS, STATEMENTS, CLAIMS, DEPTHS].map(<[Way]>::len);
    assert!(ways.iter().sum::<usize>() > 90, "{ways:?}");
}

#[test]
fn changed_inputs_pass_no_better() {
    let studio = Studio::new(READS);
    write_input(&studio.path("in.exr"), 0.0);
    let image = studio.make(1).remove(0);
    // Another input, whose hash is made to fit: the picture is not that of this input.
    write_input(&studio.path("in.exr"), 1.0);
    let mut forgery = Forgery::of(&studio, &image);
    let now = super::super::inputs::hashed(&studio.path("in.exr"), studio.folder.path()).expect("read");
    forgery.certificate.inputs = vec![now];
    let file = OutputFile { path: image, outputs: vec![0] };
    forgery.certificate.fingerprint = crate::Fingerprints::new().of(&forgery.graph, &file, 1);
    let (certificate, image) = forgery.seal(&studio);
    let failed = failures(&certificate, &image);
    assert!(failed.iter().any(|failed| failed.contains("the rounded form of")), "{failed:?}");
}

#[test]
fn what_is_hidden_in_some_pixels_passes_no_more_often_than_the_check_says() {
    const SEEDS: u64 = 20;
    let studio = Studio::new(SKY);
    studio.make(1);
    let image = studio.path("beauty.exr");
    let choice = Choice::Some(96);
    let share = choice.share_found(24 * 16).expect("not all are looked at");
    let count = (share * 384.0).ceil() as usize;
    assert_eq!(count, 18);
    // Pixels of the sea, side by side or spread.
    let block: Vec<usize> = (0..count).map(|index| (11 + index / 6) * 24 + 3 + index % 6).collect();
    let spread: Vec<usize> = (0..count).map(|index| 10 * 24 + index * 7).collect();
    type Change = fn(&mut Forgery, &[usize]);
    let ways: [(&str, Change); 3] = [
        ("painted", |f, at| at.iter().for_each(|at| f.paint(*at, |_, sample| sample * (1.0 + 1.0 / 512.0)))),
        ("ambiguous", |f, at| f.state(|stated| at.iter().for_each(|at| stated.ambiguous[*at] = true))),
        ("looser", |f, at| {
            f.state(|stated| at.iter().for_each(|at| stated.bounds[*at] = shifted(stated.bounds[*at], 1)));
        }),
    ];
    for (name, change) in ways {
        for at in [&block, &spread] {
            let mut forgery = Forgery::of(&studio, &image);
            change(&mut forgery, at);
            let (certificate, image) = forgery.seal(&studio);
            let passes = |seed: &u64| {
                let (certificate, image, seed) = (&certificate, &image, *seed);
                let request = Request { certificate, image, choice, seed, key: None, document: None, access: None };
                verify(&request, &Silent).expect("readable").holds()
            };
            // 0.2 are expected of 20; 4 or more have a probability below 10⁻⁴.
            let passed = (0..SEEDS).filter(passes).count();
            assert!(passed < 4, "{name}: {passed} of {SEEDS}");
        }
    }
}

#[test]
fn the_sky_is_told_apart() {
    let studio = Studio::new(SKY);
    studio.make(1);
    let certificate = Certificate::read(&studio.path("depth.certificate.json")).expect("read").expect("sealed");
    let depth = &certificate.outputs[0];
    let ChannelBounds { all, clear, names, .. } = &depth.error.channels[0];
    assert_eq!(names[..], ["Z"]);
    assert!(all.infinite > 100 && all.bounded > 100, "{all:?}");
    assert_eq!(all.bounded + all.infinite + all.unbounded, 24 * 16);
    assert_eq!(depth.counts.infinite, all.infinite, "the sky, as the file stores it");
    assert!(clear.max.is_some_and(|max| max.bound < 1e-2) && clear.p999.is_some(), "{clear:?}");
}

#[test]
fn who_forges_is_told_what_was_found() {
    let studio = Studio::of_space("linear-srgb");
    studio.make(1);
    let image = studio.path("beauty.0001.exr");
    let failed = |change: &dyn Fn(&mut Forgery)| {
        let mut forgery = Forgery::of(&studio, &image);
        change(&mut forgery);
        let (certificate, image) = forgery.seal(&studio);
        failures(&certificate, &image)
    };
    let one = |failed: Vec<String>, words: &[&str]| {
        assert!(failed.len() == 1 && words.iter().all(|words| failed[0].contains(words)), "{failed:?}");
    };
    let marked = failed(&|f| f.state(|stated| stated.ambiguous[HERE] = true));
    one(marked, &["output \"beauty\", pixel (20, 30): found ambiguous; expected not ambiguous"]);
    let loose = failed(&|f| f.state(|stated| stated.bounds[HERE] = PixelBound::of(1.0)));
    one(loose, &["pixel (20, 30): found an error of at most 1.00e0 (level 0); expected an error of at most "]);
    let painted = failed(&|f| inside(f, UNCLEAR));
    assert!(painted[0].contains("pixel (35, 5): found [") && painted[0].contains("the rounded form of"), "{painted:?}");
    let old = failed(&|f| {
        f.certificate.trochoid = "0.0.1".into();
        f.state(|stated| stated.bounds[HERE] = PixelBound::of(1.0));
    });
    one(old, &["the certificate says that Trochoid 0.0.1 made it: check it with that version, or make it anew"]);
}
