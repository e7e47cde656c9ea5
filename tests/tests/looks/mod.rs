//! Looks: batches of samples and pictures whose inputs another renderer supplies.

use crate::support::{evaluate, graph, settings};
use rand::{RngExt, SeedableRng};
use rand_pcg::Pcg64Mcg;
use trochoid::{
    Batch, BufferFault, Buffers, Cache, CheckedGraph, Format, Illegal, Kind, Look, LookBuilder, PictureError, Samples,
    SamplesMut, Settings, ShadeError, Shader, Silent, Switches,
};

mod binding;

const WIDTH: usize = 61;
const HEIGHT: usize = 19;
const AREA: usize = WIDTH * HEIGHT;

/// A document with everything that a renderer may bind: masks, a field, weights, colors.
fn shaded() -> CheckedGraph {
    let nodes = r##"
        "camera": { "type": "Camera" }, "sea": { "type": "GerstnerSea", "count": 0 },
        "sun": { "type": "Light" }, "view": { "type": "Render", "camera": "camera", "surfaces": ["sea"] },
        "light": { "type": "NonSpecular", "view": "view", "lights": ["sun"] },
        "depth": { "type": "Depth", "view": "view" },
        "far": { "type": "Clamp", "field": "depth", "min": 2, "max": 60, "smooth": true, "power": 2.5 },
        "layers": { "type": "Stack", "weights": ["light", "far"] },
        "paint": { "type": "Constant", "color": "#8b9aa1" },
        "bands": { "type": "Bands", "field": "depth", "thresholds": [0.25, 0.5], "width": 0.125 },
        "banded": { "type": "Blend", "colors": ["#274e53", "paint", "#f4ecc6"], "weights": "bands" },
        "layered": { "type": "Blend", "colors": ["banded", [2, 0.5, 0], "paint"], "weights": "layers" },
        "out": { "type": "Mix", "a": "paint", "b": "layered", "weight": "light" }"##;
    let outputs = r#""out": { "color": "out" }, "paint": { "color": "paint" }, "light": { "weights": "light" },
        "layers": { "weights": "layers" }, "depth": { "field": "depth" }"#;
    graph(&format!(r#""width": {WIDTH}, "height": {HEIGHT}"#), nodes, outputs)
}

const BOUND: [&str; 3] = ["light", "depth", "paint"];

/// Returns pseudorandom numbers, including −0 and both ends.
fn noise(seed: u64, scale: f32) -> Vec<f32> {
    let mut random = Pcg64Mcg::seed_from_u64(seed);
    let mut number = || match random.random_range(0..8) {
        0 => -0.0,
        1 => scale,
        _ => random.random_range(0.0..=scale),
    };
    (0..AREA).map(|_| number()).collect()
}

/// The passes of `BOUND`, channel by channel.
fn passes() -> [Vec<f32>; 5] {
    [noise(1, 1.0), noise(2, 70.0), noise(3, 1.0), noise(4, 2.0), noise(5, 65504.0)]
}

fn bits(samples: &[f32]) -> Vec<u32> {
    samples.iter().map(|sample| sample.to_bits()).collect()
}

/// Shades the first `count` samples of planes.
fn shade(shader: &mut Shader, planes: &[Vec<f32>], count: usize) -> Result<Vec<Vec<f32>>, ShadeError> {
    let mut out = vec![vec![f32::NAN; count]; shader.look().channels()];
    let inputs: Vec<Samples<'_>> = planes.iter().map(|plane| Samples::new(plane)).collect();
    let mut outputs: Vec<SamplesMut<'_>> = out.iter_mut().map(|plane| SamplesMut::new(plane)).collect();
    shader.shade(count, &inputs, &mut outputs)?;
    Ok(out)
}

#[test]
fn batches_equal_pictures_bit_for_bit() {
    let (graph, passes) = (shaded(), passes());
    let buffers = Buffers::new()
        .with("light", &[&passes[0]])
        .with("depth", &[&passes[1]])
        .with("paint", &[&passes[2], &passes[3], &passes[4]]);
    let frame = evaluate(&graph, 1, &buffers, &settings(|_| ()));
    for (switches, compile_from) in [(Switches::ALL, 0), (Switches::ALL, usize::MAX), (Switches::NONE, 0)] {
        for (picture, output) in frame.pictures.iter().zip(graph.outputs()) {
            let settings = settings(|s| (s.switches, s.compile_from) = (switches, compile_from));
            let look = Look::new(graph.clone(), &output.name, 1, &BOUND, &settings).unwrap();
            assert_eq!((look.channels(), look.inputs()), (picture.planes.len(), 5));
            let mut shader = look.shader().unwrap();
            // Sizes that end in the middle of blocks, and one shader for all of them.
            for count in [AREA, 1, 16, 257, 512, 513] {
                let found = shade(&mut shader, &passes, count).unwrap();
                for (channel, plane) in found.iter().enumerate() {
                    let expected = &picture.planes[channel].samples()[..count];
                    assert_eq!(bits(plane), bits(expected), "{}, channel {channel}, {count} samples", output.name);
                }
            }
            let passes = passes.each_ref().map(|pass| Samples::new(pass));
            let made = look.picture(graph.format(), &passes, &mut Cache::new(), &Silent).unwrap();
            for (made, picture) in made.pictures[0].planes.iter().zip(&picture.planes) {
                assert_eq!(bits(made.samples()), bits(picture.samples()), "{}", output.name);
            }
        }
    }
}

/// Fields keep the signs of their zeros, wherever their samples are, and whatever is in the tiles of other inputs.
#[test]
fn negative_zeros_of_fields_are_as_in_pictures() {
    let graph = shaded();
    let depth: Vec<f32> = (0..AREA).map(|at| if at % 3 == 0 { -0.0 } else { at as f32 - 500.0 }).collect();
    let buffers = Buffers::new().with("depth", &[&depth]);
    let frame = trochoid::Plan::new(&graph, &["depth"], 1, &["depth"], &settings(|_| ())).unwrap();
    let frame = frame.evaluate(&buffers, &mut Cache::new(), &Silent).unwrap();
    assert_eq!(bits(frame.pictures[0].planes[0].samples()), bits(&depth));
    // A mask with −0 in one tile changes no other plane there.
    let light: Vec<f32> = (0..AREA).map(|at| if at % 29 == 7 { -0.0 } else { 0.5 }).collect();
    let both = buffers.clone().with("light", &[&light]);
    for tile in [(256, 64), (7, 3)] {
        let settings = settings(|s| s.tile = Some(tile));
        let plan = trochoid::Plan::new(&graph, &["out", "depth"], 1, &["depth", "light"], &settings).unwrap();
        let made = plan.evaluate(&both, &mut Cache::new(), &Silent).unwrap();
        assert_eq!(bits(made.pictures[1].planes[0].samples()), bits(&depth), "{tile:?}");
    }
    let look = Look::new(graph, "depth", 1, &["depth"], &Settings::default()).unwrap();
    let mut shader = look.shader().unwrap();
    let plain = shade(&mut shader, std::slice::from_ref(&depth), AREA).unwrap();
    assert_eq!(bits(&plain[0]), bits(frame.pictures[0].planes[0].samples()));
    let spread: Vec<f32> = depth.iter().flat_map(|depth| [*depth, 7.0]).collect();
    let mut strided = vec![0.0; AREA];
    shader.shade(AREA, &[Samples::strided(&spread, 2)], &mut [SamplesMut::new(&mut strided)]).unwrap();
    assert_eq!(bits(&strided), bits(&plain[0]));
}

#[test]
fn strides_and_uniforms_read_and_write_what_they_name() {
    let (graph, planes) = (shaded(), passes());
    let look = Look::new(graph, "out", 1, &BOUND, &Settings::default()).unwrap();
    let mut shader = look.shader().unwrap();
    let plain = shade(&mut shader, &planes, AREA).unwrap();

    // One structure per sample: light, depth, red, green, blue, and a place for each result.
    let mut mixed: Vec<f32> = (0..AREA).flat_map(|at| planes.each_ref().map(|plane| plane[at])).collect();
    let inputs: Vec<Samples<'_>> = (0..5).map(|channel| Samples::strided(&mixed[channel..], 5)).collect();
    let mut rgb = vec![-1.0; 4 * AREA];
    let (red, rest) = rgb.split_at_mut(1);
    let _ = red;
    let mut outputs = [SamplesMut::strided(rest, 4)];
    let light = Look::new(shaded(), "light", 1, &BOUND, &Settings::default()).unwrap();
    light.shader().unwrap().shade(AREA, &inputs, &mut outputs).unwrap();
    for at in 0..AREA {
        assert_eq!(rgb[4 * at + 1].to_bits(), (planes[0][at] + 0.0).to_bits(), "sample {at}");
        assert!([0, 2, 3].iter().all(|beside| rgb[4 * at + beside] == -1.0), "what lies between stays");
    }
    // Pixels of three numbers, and of four with one that is not ours; the last one may end early.
    let inputs = planes.each_ref().map(|plane| Samples::new(plane));
    for stride in [3, 4] {
        let mut pixels = vec![-1.0; stride * AREA - (stride - 3)];
        shader.shade_pixels(AREA, &inputs, &mut pixels, stride).unwrap();
        for (at, pixel) in pixels.chunks(stride).enumerate() {
            assert_eq!(bits(&pixel[..3]), [0, 1, 2].map(|channel| plain[channel][at].to_bits()), "sample {at}");
            assert!(pixel[3..].iter().all(|rest| *rest == -1.0), "sample {at}");
        }
        let short = shader.shade_pixels(AREA + 1, &inputs, &mut pixels, stride).unwrap_err();
        assert!(matches!(short, ShadeError::Short { .. }), "{short}");
        let short = shader.shade_pixels(AREA, &inputs, &mut pixels[1..], stride).unwrap_err();
        assert!(matches!(short, ShadeError::Short { what: "outputs", found, .. } if found == AREA - 1), "{short}");
    }
    assert!(shader.shade_pixels(1, &inputs, &mut [0.0; 8], 2).is_err(), "pixels overlap");
    // Uniforms equal planes of one value.
    let (value, flat) = (0.375, vec![0.375; AREA]);
    let expected =
        shade(&mut shader, &[flat, planes[1].clone(), planes[2].clone(), planes[3].clone(), planes[4].clone()], AREA);
    let mut out = [0, 1, 2].map(|_| vec![0.0; AREA]);
    let [_, depth, r, g, b] = planes.each_ref().map(|plane| Samples::new(plane));
    let mut outputs = out.each_mut().map(|plane| SamplesMut::new(plane));
    shader.shade(AREA, &[Samples::uniform(&value), depth, r, g, b], &mut outputs).unwrap();
    assert_eq!(out.to_vec(), expected.unwrap());

    /// Writes the result where the inputs are.
    struct InPlace<'m>(&'m mut [f32]);
    impl Batch for InPlace<'_> {
        fn read(&mut self, channel: usize, start: usize, to: &mut [f32]) {
            let from = self.0.chunks_exact(5).skip(start);
            to.iter_mut().zip(from).for_each(|(to, from)| *to = from[channel]);
        }

        fn write(&mut self, channel: usize, start: usize, from: &[f32]) {
            let to = self.0.chunks_exact_mut(5).skip(start);
            to.zip(from).for_each(|(to, from)| to[2 + channel] = *from);
        }
    }
    shader.run(AREA, &mut InPlace(&mut mixed)).unwrap();
    for (at, sample) in mixed.chunks_exact(5).enumerate() {
        assert_eq!(bits(&sample[2..]), [0, 1, 2].map(|channel| plain[channel][at].to_bits()), "sample {at}");
    }
}

#[test]
fn illegal_samples_are_named_or_moved() {
    let (graph, planes) = (shaded(), passes());
    let look = Look::new(graph.clone(), "out", 1, &BOUND, &Settings::default()).unwrap();
    let mut shader = look.shader().unwrap();
    let sound = shade(&mut shader, &planes, AREA).unwrap();
    let mut random = Pcg64Mcg::seed_from_u64(7);
    for (channel, bad, legal) in [
        (0, 1.000_000_1, 1.0),
        (0, -1e-45, 0.0),
        (0, f32::NAN, 0.0),
        (0, f32::NEG_INFINITY, 0.0),
        (1, f32::NAN, 0.0),
        (2, -0.5, 0.0),
        (3, f32::INFINITY, f32::MAX),
        (4, f32::NAN, 0.0),
    ] {
        let at = random.random_range(0..AREA);
        let mut broken = planes.clone();
        broken[channel][at] = bad;
        let error = shade(&mut shader, &broken, AREA).unwrap_err();
        let (slot, within) = [(0, 0), (1, 0), (2, 0), (2, 1), (2, 2)][channel];
        let text = error.to_string();
        let ShadeError::Illegal { slot: told, name, sample, fault } = error else { panic!("{text}") };
        assert_eq!((told, name.as_str(), sample), (slot, BOUND[slot], at), "{text}");
        let BufferFault::Value { channel: told, found, .. } = fault else { panic!("{text}") };
        assert_eq!((told, found.to_bits()), (within, bad.to_bits()), "{text}");
        // The next batch is not refused for it.
        assert_eq!(shade(&mut shader, &planes, AREA).unwrap(), sound);
        // On request, it counts as the nearest legal number.
        let patient = look.clone().with_illegal(Illegal::Clamp);
        let found = shade(&mut patient.shader().unwrap(), &broken, AREA).unwrap();
        broken[channel][at] = legal;
        let expected = shade(&mut shader, &broken, AREA).unwrap();
        assert_eq!(found, expected, "{bad}");
        broken[channel][at] = bad;
        let passes = broken.each_ref().map(|pass| Samples::new(pass));
        let made = patient.picture(graph.format(), &passes, &mut Cache::new(), &Silent).unwrap();
        for (made, expected) in made.pictures[0].planes.iter().zip(&expected) {
            assert_eq!(made.samples(), expected, "{bad}");
        }
        let refused = look.picture(graph.format(), &passes, &mut Cache::new(), &Silent).unwrap_err();
        assert!(refused.to_string().contains(&format!("sample {at} ")), "{refused}");
    }
}

#[test]
fn weights_sum_to_one_or_are_told() {
    let look =
        |illegal| Look::new(shaded(), "layers", 1, &["layers"], &Settings::default()).unwrap().with_illegal(illegal);
    let mut strict = look(Illegal::Refuse).shader().unwrap();
    let planes = |weights: [f32; 3]| weights.map(|weight| vec![0.25, weight, 0.5]).to_vec();
    for (weights, told) in [
        ([0.5, 0.25, 0.3], Some("sum to 1.05")),
        ([0.0, 0.0, 0.0], Some("sum to 0")),
        ([1.5, -0.5, 0.0], Some("found 1.5 at sample 1")),
        ([0.5, f32::NAN, 0.5], Some("found NaN at sample 1")),
        ([0.5004, 0.25, 0.25], None),
    ] {
        let mut planes = planes(weights);
        for plane in &mut planes {
            (plane[0], plane[2]) = (1.0 / 3.0, 1.0 / 3.0);
        }
        let result = shade(&mut strict, &planes, 3);
        match (told, result) {
            (Some(told), Err(error)) => assert!(error.to_string().contains(told), "{weights:?}: {error}"),
            (None, Ok(_)) => {}
            (_, result) => panic!("{weights:?}: {result:?}"),
        }
        let parts = shade(&mut look(Illegal::Clamp).shader().unwrap(), &planes, 3).unwrap();
        let sum: f64 = parts.iter().map(|plane| f64::from(plane[1])).sum();
        assert!((sum - 1.0).abs() < 1e-6, "{weights:?} become {parts:?}");
        assert!(parts.iter().all(|plane| (0.0..=1.0).contains(&plane[1])), "{weights:?} become {parts:?}");
    }
}

#[test]
fn batches_that_do_not_fit_are_refused() {
    let look = Look::new(shaded(), "light", 1, &["light", "depth"], &Settings::default()).unwrap();
    assert_eq!(
        look.slots().iter().map(|slot| (slot.kind, slot.is_used)).collect::<Vec<_>>(),
        [(Kind::MASK, true), (Kind::Field(1), false)]
    );
    let mut shader = look.shader().unwrap();
    let (light, none, mut out) = ([0.5; 8], [], [0.0; 9]);
    let both = [Samples::new(&light), Samples::new(&none)];
    let told = shader.shade(8, &both[..1], &mut [SamplesMut::new(&mut out)]).unwrap_err();
    assert_eq!(told, ShadeError::Channels { what: "inputs", found: 1, expected: 2 });
    let told = shader.shade(8, &both, &mut []).unwrap_err();
    assert_eq!(told, ShadeError::Channels { what: "outputs", found: 0, expected: 1 });
    let told = shader.shade(9, &both, &mut [SamplesMut::new(&mut out)]).unwrap_err();
    assert_eq!(told, ShadeError::Short { what: "inputs", channel: 0, found: 8, expected: 9 });
    let told = shader.shade(8, &both, &mut [SamplesMut::strided(&mut out, 2)]).unwrap_err();
    assert_eq!(told, ShadeError::Short { what: "outputs", channel: 0, found: 5, expected: 8 });
    // What is not used may be empty, and so may a batch.
    shader.shade(8, &both, &mut [SamplesMut::new(&mut out)]).unwrap();
    assert_eq!(out, [0.5, 0.5, 0.5, 0.5, 0.5, 0.5, 0.5, 0.5, 0.0]);
    shader.shade(0, &[Samples::new(&none), Samples::new(&none)], &mut [SamplesMut::new(&mut [])]).unwrap();
    let short = look.picture(Format::new(3, 3, 1).unwrap(), &both, &mut Cache::new(), &Silent);
    assert!(matches!(short, Err(PictureError::Passes(ShadeError::Short { found: 8, expected: 9, .. }))));
}

/// A document without a format means its lengths in pixels as one of the picture's size does.
#[test]
fn pictures_of_documents_without_a_format_are_no_drafts() {
    let of = |format: &str| {
        let text = format!(
            r##"{{ "trochoid": 1, {format} "nodes": {{
                "light": {{ "type": "ScreenX" }},
                "moved": {{ "type": "Warp", "image": "light", "dx": 3, "reach": 8 }},
                "soft": {{ "type": "Blur", "image": "moved", "size": 5 }}
            }}, "outputs": {{ "soft": {{ "weights": "soft" }} }} }}"##
        );
        let look = LookBuilder::new(text).bind("light").build().unwrap();
        let format = Format::new(WIDTH as u32, HEIGHT as u32, 1).unwrap();
        let light = noise(1, 1.0);
        let frame = look.picture(format, &[Samples::new(&light)], &mut Cache::new(), &Silent).unwrap();
        bits(frame.pictures[0].planes[0].samples())
    };
    let stated = of(&format!(r#""format": {{ "width": {WIDTH}, "height": {HEIGHT} }},"#));
    assert_eq!(of(""), stated);
    // Larger than the document, it is scaled with it.
    assert_ne!(of(r#""format": { "width": 1, "height": 1 },"#), stated);
}

#[test]
fn nodes_in_the_way_of_batches_are_named() {
    let look = Look::new(shaded(), "out", 1, &["paint"], &Settings::default()).unwrap();
    let told = look.shader().map(|_| ()).unwrap_err();
    // The passes that colors are computed from, not the view that they need in their turn.
    let names: Vec<_> = told.faults.iter().filter_map(|fault| fault.node.as_deref()).collect();
    assert_eq!(names, ["light", "depth"], "{told}");
    let text = told.to_string();
    for words in [
        "node \"light\": found a NonSpecular, which needs more than one sample",
        "node \"depth\": found a Depth, which",
        "on the way to \"out\"",
        "remedy: bind \"light\" as an input, or make a picture",
    ] {
        assert!(text.contains(words), "{text}");
    }
    assert!(told.faults.iter().all(|fault| fault.line > 1 && fault.column > 1), "{text}");
    // Once they are inputs, nothing is in the way.
    let bound: Vec<&str> = names.iter().copied().chain(["paint"]).collect();
    assert!(Look::new(shaded(), "out", 1, &bound, &Settings::default()).unwrap().shader().is_ok());
    // Equal nodes, which are planned as one, are told one by one.
    let equal = r##"{ "trochoid": 1, "nodes": {
        "rim": { "type": "ScreenX" }, "light": { "type": "ScreenX" },
        "out": { "type": "Mix", "a": "lit", "b": "#fff", "weight": "rim" },
        "lit": { "type": "Mix", "a": "#000", "b": "#456", "weight": "light" } },
        "outputs": { "out": { "color": "out" } } }"##;
    let told = LookBuilder::new(equal).build().unwrap().shader().map(|_| ()).unwrap_err();
    assert_eq!(told.faults.iter().filter_map(|fault| fault.node.as_deref()).collect::<Vec<_>>(), ["rim", "light"]);
    // An output that no name of an input means.
    let nodes = r##"
        "camera": { "type": "Camera" }, "sea": { "type": "GerstnerSea", "count": 0 },
        "view": { "type": "Render", "camera": "camera", "surfaces": ["sea"] },
        "out": { "type": "Mix", "a": "#000", "b": "#fff", "weight": "view.coverage" }"##;
    let covered = graph(r#""width": 8, "height": 8"#, nodes, r#""out": { "color": "out" }"#);
    let told =
        Look::new(covered.clone(), "out", 1, &[], &Settings::default()).unwrap().shader().map(|_| ()).unwrap_err();
    assert!(told.to_string().contains("remedy: bind the nodes that take it as an input, or make a picture"), "{told}");
    assert!(Look::new(covered, "out", 1, &["out"], &Settings::default()).unwrap().shader().is_ok());
    let look = Look::new(shaded(), "out", 1, &["depth"], &Settings::default()).unwrap();
    // A picture makes the missing passes itself.
    let depth = noise(2, 70.0);
    let format = Format::new(WIDTH as u32, HEIGHT as u32, 1).unwrap();
    let frame = look.picture(format, &[Samples::new(&depth)], &mut Cache::new(), &Silent).unwrap();
    assert_eq!(frame.pictures[0].audit.hull_exits, 0);
    let constant = Look::new(shaded(), "paint", 1, &[], &Settings::default()).unwrap();
    assert!(constant.shader().is_ok(), "a constant needs nothing");
}

#[test]
fn memory_is_checked_before_passes_are_copied() {
    let document = r##"{
        "trochoid": 1,
        "palette": { "deep": "#274e53" },
        "nodes": { "light": { "type": "ScreenX" }, "water": { "type": "Mix", "a": "palette.deep", "b": "#ffffff", "weight": "light" } },
        "outputs": { "beauty": { "color": "water" } }
    }"##;
    let look = |megabytes: u64| {
        let mut settings = Settings::default();
        (settings.threads, settings.memory_limit) = (1, megabytes << 20);
        LookBuilder::new(document).bind("light").bind("palette.deep").settings(settings).build().unwrap()
    };
    let format = Format::new(2048, 1024, 1).unwrap();
    let light = vec![0.5; 2048 * 1024];
    let channels: [Vec<f32>; 3] = [0.1, 0.2, 0.3].map(|channel| vec![channel; 2048 * 1024]);
    let uniform = [0.1, 0.2, 0.3];
    let of = |look: &Look, deep: [Samples<'_>; 3]| {
        let passes = [&[Samples::new(&light)][..], &deep].concat();
        look.picture(format, &passes, &mut Cache::new(), &Silent)
    };
    // The picture takes 25 MB, and the copies of a color as many.
    let (small, large) = (look(32), look(64));
    let given = of(&small, channels.each_ref().map(|channel| Samples::new(channel))).unwrap();
    let copied = of(&large, uniform.each_ref().map(Samples::uniform)).unwrap();
    let planes = given.pictures[0].planes.iter().zip(&copied.pictures[0].planes);
    planes.for_each(|(given, copied)| assert!(given.samples() == copied.samples()));
    let error = of(&small, uniform.each_ref().map(Samples::uniform)).unwrap_err().to_string();
    assert!(error.contains("copies of passes 25"), "{error}");
    // Callers that copy passes themselves ask first.
    assert!(small.check_memory(format, 0).is_ok() && large.check_memory(format, 3).is_ok());
    assert!(look(8).check_memory(format, 0).is_err(), "the picture itself takes more");
    assert_eq!(small.check_memory(format, 3).unwrap_err().to_string(), error);
}
