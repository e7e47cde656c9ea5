//! Forgeries: certificates and images that someone changed on purpose, as consistently as possible, with digests made
//! to fit.

use super::*;
use crate::certificate::bounds::PictureBounds;
use crate::certificate::color::Coding;
use crate::certificate::level::{BoundMap, PixelBound};
use crate::certificate::make::{controls_of, stored_channels};

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

/// A way to forge: a name, the image, and the change.
type Way = (&'static str, &'static str, fn(&mut Forgery));

/// Pixel (20, 30) of [`DOCUMENT`], far from what is ambiguous.
const HERE: usize = 30 * 70 + 20;
/// Pixel (35, 5), which is ambiguous.
const UNCLEAR: usize = 5 * 70 + 35;
/// Pixel (12, 12) of [`SKY`], on the sea, and (12, 2), in the sky.
const SEA: usize = 12 * 24 + 12;
const ABOVE: usize = 2 * 24 + 12;

/// Paints a pixel with the mean of the controls, which lies in their hull; channels are B, G, R.
fn inside(forgery: &mut Forgery, pixel: usize) {
    let controls = forgery.output().controls.as_ref().expect("a color").values.clone();
    let mean = [2, 1, 0].map(|c| controls.iter().map(|color| color[c]).sum::<f32>() / controls.len() as f32);
    forgery.paint(pixel, |channel, _| mean[channel]);
}

/// Ways to change the image of [`DOCUMENT`].
const PIXELS: &[Way] = &[
    ("one pixel by 1e-4", "beauty", |f| f.paint(HERE, |_, sample| sample + 1e-4)),
    ("one pixel by a last bit", "beauty", |f| f.paint(HERE, |_, sample| sample.next_up())),
    ("one channel by a last bit", "beauty", |f| f.samples("G")[HERE] = f.samples("G")[HERE].next_down()),
    ("one pixel within the hull", "beauty", |f| inside(f, HERE)),
    ("one ambiguous pixel within its bound", "beauty", |f| f.paint(UNCLEAR, |_, sample| sample.next_up())),
    ("all ambiguous pixels", "beauty", |f| (0..66).for_each(|y| inside(f, y * 70 + 35))),
    ("two neighbors exchanged", "beauty", |f| {
        for channel in ["R", "G", "B"] {
            f.samples(channel).swap(HERE, HERE + 1);
        }
    }),
    ("two blocks exchanged", "beauty", |f| {
        for channel in ["R", "G", "B"] {
            for y in 0..64 {
                (0..6).for_each(|x| f.samples(channel).swap(y * 70 + x, y * 70 + 64 + x));
            }
        }
    }),
    ("mirrored", "beauty", |f| {
        for channel in ["R", "G", "B"] {
            f.samples(channel).chunks_mut(70).for_each(<[f32]>::reverse);
        }
    }),
    ("turned", "beauty", |f| ["R", "G", "B"].into_iter().for_each(|channel| f.samples(channel).reverse())),
    ("a little brighter", "beauty", |f| {
        ["R", "G", "B"].into_iter().for_each(|channel| {
            f.samples(channel).iter_mut().for_each(|sample| *sample *= 1.0 + 1e-6);
        });
    }),
    ("red and blue exchanged", "beauty", |f| {
        let red = f.samples("R").to_vec();
        let blue = f.samples("B").to_vec();
        f.samples("R").copy_from_slice(&blue);
        f.samples("B").copy_from_slice(&red);
    }),
    ("a step of 8 bits", "print", |f| f.paint(HERE, |_, sample| (sample - 1.0 / 255.0).abs())),
    ("a step of 16 bits", "deep", |f| f.paint(HERE, |_, sample| (sample - 1.0 / 65535.0).abs())),
    ("a mask by a last half", "mask", |f| f.paint(HERE, |_, sample| sample * (1.0 + 1.0 / 1024.0))),
    ("weight moved between two", "three", |f| {
        f.samples("three.w0")[HERE] += 0.125;
        f.samples("three.w1")[HERE] -= 0.125;
    }),
    ("a field by a last bit", "three", |f| f.samples("wave.Y")[HERE] = f.samples("wave.Y")[HERE].next_up()),
    ("not a number in a field", "three", |f| f.samples("wave.Y")[HERE] = f32::NAN),
    ("not a number in a color, counted", "beauty", |f| {
        f.paint(HERE, |_, _| f32::NAN);
        let output = f.output();
        output.counts.nan = 1;
        output.guarantee.as_mut().expect("a color").held = None;
    }),
    ("outside of the hull", "beauty", |f| f.paint(HERE, |_, _| 0.9)),
    ("outside of the hull, counted", "beauty", |f| {
        f.paint(HERE, |_, _| 0.9);
        let output = f.output();
        (output.counts.outside, output.counts.outside_by) = (1, 0.25);
        output.guarantee.as_mut().expect("a color").held = None;
    }),
];

/// Ways to change what is said about the pixels of [`DOCUMENT`], and how that hides a changed pixel.
const STATEMENTS: &[Way] = &[
    ("a painted pixel, ambiguous", "beauty", |f| {
        inside(f, HERE);
        f.state(|stated| stated.ambiguous[HERE] = true);
    }),
    ("a painted pixel, ambiguous, of a bound of 1", "beauty", |f| {
        inside(f, HERE);
        f.state(|stated| (stated.ambiguous[HERE], stated.bounds[HERE]) = (true, PixelBound::of(1.0)));
    }),
    ("a painted pixel of a bound of 1", "beauty", |f| {
        inside(f, HERE);
        f.state(|stated| stated.bounds[HERE] = PixelBound::of(1.0));
    }),
    ("a painted pixel without a bound", "beauty", |f| {
        inside(f, HERE);
        f.state(|stated| stated.bounds[HERE] = PixelBound::Unknown);
    }),
    ("a painted pixel that counts as infinite", "beauty", |f| {
        inside(f, HERE);
        f.state(|stated| stated.bounds[HERE] = PixelBound::Infinite);
    }),
    ("a bound of 1", "beauty", |f| f.state(|stated| stated.bounds[HERE] = PixelBound::of(1.0))),
    ("a bound a level higher", "beauty", |f| f.state(|stated| stated.bounds[HERE] = shifted(stated.bounds[HERE], 1))),
    ("a bound a level lower", "beauty", |f| f.state(|stated| stated.bounds[HERE] = shifted(stated.bounds[HERE], -1))),
    ("a bound of 0", "beauty", |f| f.state(|stated| stated.bounds[HERE] = PixelBound::Exact)),
    ("no bound", "beauty", |f| f.state(|stated| stated.bounds[HERE] = PixelBound::Unknown)),
    ("all bounds doubled", "beauty", |f| {
        f.state(|stated| stated.bounds.iter_mut().for_each(|bound| *bound = shifted(*bound, 8)));
    }),
    ("all bounds halved", "beauty", |f| {
        f.state(|stated| stated.bounds.iter_mut().for_each(|bound| *bound = shifted(*bound, -8)));
    }),
    ("all bounds 0", "beauty", |f| f.state(|stated| stated.bounds.fill(PixelBound::Exact))),
    ("no bounds at all", "beauty", |f| f.state(|stated| stated.bounds.fill(PixelBound::Unknown))),
    ("every pixel ambiguous", "beauty", |f| f.state(|stated| stated.ambiguous.fill(true))),
    ("a clear pixel ambiguous", "beauty", |f| f.state(|stated| stated.ambiguous[HERE] = true)),
    ("an ambiguous pixel clear", "beauty", |f| f.state(|stated| stated.ambiguous[UNCLEAR] = false)),
    ("ambiguous pixels exchanged", "beauty", |f| f.state(|stated| stated.ambiguous.swap(UNCLEAR, HERE))),
    ("bounds exchanged", "beauty", |f| f.state(|stated| stated.bounds.swap(UNCLEAR, HERE))),
    ("largest bounds of 1", "beauty", |f| {
        let channel = &mut f.output().error.channels[0];
        for summary in [&mut channel.all, &mut channel.clear] {
            (summary.max, summary.p999) = (summary.max.map(one), summary.p999.map(one));
        }
    }),
    ("a smaller maximum", "beauty", |f| {
        let max = f.output().error.channels[0].all.max.as_mut();
        max.expect("known").bound = 1e-7;
    }),
    ("a smaller percentile", "beauty", |f| {
        let p999 = f.output().error.channels[0].clear.p999.as_mut();
        p999.expect("known").bound = 1e-9;
    }),
    ("the maximum elsewhere", "beauty", |f| {
        let max = f.output().error.channels[0].all.max.as_mut();
        max.expect("known").pixel = [0, 0];
    }),
    ("the maximum outside of the picture", "beauty", |f| {
        let max = f.output().error.channels[0].all.max.as_mut();
        max.expect("known").pixel = [-1, i64::MAX];
    }),
    ("no maximum", "beauty", |f| f.output().error.channels[0].all.max = None),
    ("fewer pixels with a bound", "beauty", |f| f.output().error.channels[0].all.bounded -= 1),
    ("a smaller display bound", "beauty", |f| {
        let max = f.output().error.display.as_mut().and_then(|display| display.all.max.as_mut());
        max.expect("known").bound *= 0.5;
    }),
    ("no display bounds", "beauty", |f| f.output().error.display = None),
    ("another base", "beauty", |f| f.output().error.channels[0].base -= 8),
    ("the largest base", "beauty", |f| f.output().error.channels[0].base = i32::MAX),
    ("another unit", "beauty", |f| f.output().error.unit = "display value".into()),
    ("other names of channels", "beauty", |f| f.output().error.channels[0].names.reverse()),
    ("a map of another output", "beauty", |f| {
        f.output().error.channels[0].map = BoundMap::new([PixelBound::Exact; 9].into_iter()).encode();
    }),
    ("fewer ambiguous pixels", "beauty", |f| f.output().error.ambiguous.pixels = 0),
];

/// Ways to change what is said about document, plan, inputs, outputs and file of [`DOCUMENT`].
const CLAIMS: &[Way] = &[
    ("no pixel outside", "beauty", |f| {
        f.paint(HERE, |_, _| 0.9);
        f.state(|stated| stated.bounds[HERE] = PixelBound::of(1.0));
    }),
    ("a guarantee that is not held", "beauty", |f| f.output().guarantee.as_mut().expect("a color").held = None),
    ("a guarantee of another class", "beauty", |f| {
        f.output().guarantee.as_mut().expect("a color").class = "box".into();
    }),
    ("a requirement", "print", |f| f.output().guarantee.as_mut().expect("a color").required = Some("hull".into())),
    ("no requirement", "beauty", |f| f.output().guarantee.as_mut().expect("a color").required = None),
    ("a wider palette", "beauty", |f| {
        let controls = f.output().controls.as_mut().expect("a color");
        let mut values = controls.values.clone();
        values.push([4.0, 4.0, 4.0]);
        *controls = controls_of(&values, controls.margin);
    }),
    ("a narrower palette", "beauty", |f| {
        let controls = f.output().controls.as_mut().expect("a color");
        *controls = controls_of(&controls.values[1..], controls.margin);
    }),
    ("a wider margin", "beauty", |f| f.output().controls.as_mut().expect("a color").margin = 1.0),
    ("an outside pixel and a wide margin", "beauty", |f| {
        f.paint(HERE, |_, _| 0.9);
        f.output().controls.as_mut().expect("a color").margin = 1.0;
    }),
    ("no controls", "beauty", |f| f.output().controls = None),
    ("controls of a mask", "mask", |f| f.output().controls = Some(controls_of(&[[0.0; 3]], 0.0))),
    ("another kind", "mask", |f| f.output().kind = "Field".into()),
    ("a stage without bounds", "beauty", |f| {
        f.output().unbounded = vec![Unbounded { node: "wave".into(), why: "its method has none".into() }];
    }),
    ("a node left out", "beauty", |f| {
        let node = f.certificate.plan.iter_mut().find(|node| node.name == "ramp").expect("planned");
        (node.state, node.why) = ("left_out".into(), Some("nothing needs it".into()));
    }),
    ("a node less in the plan", "beauty", |f| drop(f.certificate.plan.pop())),
    ("another document", "beauty", |f| f.document("#c05030", "#c05031")),
    ("another document for a node that nothing needs", "beauty", |f| f.document("#ff00ff", "#ff00fe")),
    ("another frame", "beauty", |f| f.certificate.frame = 2),
    ("another size", "beauty", |f| (f.certificate.format.width, f.certificate.format.height) = (66, 70)),
    ("more samples", "beauty", |f| f.certificate.format.samples = 16),
    ("other shading", "beauty", |f| f.certificate.format.shading = "pixel".into()),
    ("another space", "beauty", |f| f.certificate.format.working_space = "acescg".into()),
    ("another output of the same kind", "print", |f| {
        f.certificate.outputs[0].name = "deep".into();
        f.certificate.outputs[0].controls = Some(controls_of(&[[0.0; 3]; 3], 0.0));
    }),
    ("an output twice", "beauty", |f| f.certificate.outputs.push(f.certificate.outputs[0].clone())),
    ("an output less", "three", |f| drop(f.certificate.outputs.pop())),
    ("no output", "beauty", |f| f.certificate.outputs.clear()),
    ("an input", "beauty", |f| {
        let input = InputHash { bytes: 1, hash: "0".repeat(64), path: "a.json".into() };
        f.certificate.inputs.push(input);
    }),
    ("another type of samples", "beauty", |f| f.certificate.image.channels[0].stored = "half".into()),
    ("another kind of file", "beauty", |f| f.certificate.image.kind = "PNG".into()),
    ("larger blocks", "beauty", |f| f.certificate.image.block = 128),
    ("a block less", "beauty", |f| drop(f.certificate.image.blocks.pop())),
    ("blocks exchanged", "beauty", |f| f.certificate.image.blocks.swap(0, 1)),
    ("another fingerprint", "beauty", |f| f.certificate.fingerprint = "0".repeat(64)),
];

/// Ways to change depths of [`SKY`], and what is said about them.
const DEPTHS: &[Way] = &[
    ("all depths scaled", "depth", |f| f.samples("Z").iter_mut().for_each(|depth| *depth *= 1.01)),
    ("all depths scaled, with bounds", "depth", |f| {
        f.samples("Z").iter_mut().for_each(|depth| *depth *= 1.01);
        f.state(|stated| stated.bounds.iter_mut().for_each(|bound| *bound = shifted(*bound, 80)));
    }),
    ("a sky far away", "depth", |f| {
        f.samples("Z").iter_mut().filter(|depth| depth.is_infinite()).for_each(|depth| *depth = 1e6);
    }),
    ("a hole in the sky", "depth", |f| {
        f.samples("Z")[ABOVE] = 100.0;
        f.state(|stated| stated.bounds[ABOVE] = PixelBound::Exact);
        f.output().counts.infinite -= 1;
    }),
    ("sea that is sky", "depth", |f| {
        f.samples("Z")[SEA] = f32::INFINITY;
        f.output().counts.infinite += 1;
    }),
    ("sea that is sky, as stated", "depth", |f| {
        f.samples("Z")[SEA] = f32::INFINITY;
        f.state(|stated| stated.bounds[SEA] = PixelBound::Infinite);
        f.output().counts.infinite += 1;
    }),
    ("sky of the other sign", "depth", |f| f.samples("Z")[ABOVE] = f32::NEG_INFINITY),
    ("sky without a bound", "depth", |f| f.state(|stated| stated.bounds[ABOVE] = PixelBound::Unknown)),
    ("sky without an error", "depth", |f| f.state(|stated| stated.bounds[ABOVE] = PixelBound::Exact)),
    ("sea as infinite", "depth", |f| f.state(|stated| stated.bounds[SEA] = PixelBound::Infinite)),
    ("not a number", "depth", |f| {
        f.samples("Z")[SEA] = f32::NAN;
        f.output().counts.nan = 1;
    }),
    ("fewer infinities", "depth", |f| f.output().counts.infinite -= 1),
    ("a null for the maximum", "depth", |f| f.output().error.channels[0].all.max = None),
    ("the sea painted", "beauty", |f| f.paint(SEA, |_, sample| sample * (1.0 + 1.0 / 512.0))),
];

fn shifted(bound: PixelBound, by: i32) -> PixelBound {
    if let PixelBound::AtMost(level) = bound { PixelBound::AtMost(level + by) } else { bound }
}

fn one(at: BoundAt) -> BoundAt {
    BoundAt { bound: 1.0, ..at }
}

/// Returns the ways that pass a check of all pixels.
fn passing(studio: &Studio, ways: &[Way]) -> Vec<&'static str> {
    let images = studio.make(1);
    let passes = |(name, image, change): &Way| {
        let image =
            images.iter().find(|path| path.file_name().is_some_and(|own| own.to_string_lossy().starts_with(image)));
        let image = image.expect("rendered");
        assert!(Forgery::of(studio, image).seals_honestly(studio), "{name}: nothing is forged yet");
        let mut forgery = Forgery::of(studio, image);
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

impl Forgery {
    /// Returns whether an unchanged copy holds.
    fn seals_honestly(self, studio: &Studio) -> bool {
        let (certificate, image) = self.seal(studio);
        check(&certificate, &image, Choice::Some(9)).expect("readable").holds()
    }
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
