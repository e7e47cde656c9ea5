//! Looks: batches of samples and pictures whose inputs another renderer supplies.

use crate::support::{evaluate, graph, settings};
use rand::{RngExt, SeedableRng};
use rand_pcg::Pcg64Mcg;
use trochoid::{
    Batch, BufferFault, Buffers, Cache, CheckedGraph, Format, Illegal, Kind, Look, LookBuilder, LookError,
    OpeningFault, PictureError, PlanError, Samples, SamplesMut, Settings, ShadeError, Shader, Silent, Switches,
};

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
fn an_unbound_pass_is_named() {
    let look = Look::new(shaded(), "out", 1, &["depth"], &Settings::default()).unwrap();
    match look.shader() {
        // The pass that is missing: the light, or the view that it needs.
        Err(error @ PlanError::Unbound { .. }) => {
            let text = error.to_string();
            assert!(
                ["\"view\" (a Render)", "\"light\" (a NonSpecular)"].iter().any(|name| text.contains(name)),
                "{text}"
            );
        }
        other => panic!("{:?}", other.map(|_| ())),
    }
    // A picture makes the missing passes itself.
    let depth = noise(2, 70.0);
    let format = Format::new(WIDTH as u32, HEIGHT as u32, 1).unwrap();
    let frame = look.picture(format, &[Samples::new(&depth)], &mut Cache::new(), &Silent).unwrap();
    assert_eq!(frame.pictures[0].audit.hull_exits, 0);
    let constant = Look::new(shaded(), "paint", 1, &[], &Settings::default()).unwrap();
    assert!(constant.shader().is_ok(), "a constant needs nothing");
}

/// A document without a format.
const LOOK: &str = r##"{
    "trochoid": 1,
    "working_space": "srgb",
    "palette": { "deep": "#274e53", "foam": "#ece6c2" },
    "knobs": { "calm": 0.25, "half": 0.5, "bound": 2, "unused": 1 },
    "nodes": {
        "light": { "type": "ScreenX" },
        "water": { "type": "Ramp", "weight": "light", "stops": [
            { "at": 0, "color": "palette.deep" }, { "at": 0.6, "color": "#839191" }, { "at": 1, "color": "palette.foam" } ] },
        "gleam": { "type": "Mix", "a": "water", "b": "palette.foam", "weight": "= knobs.calm" },
        "sheen": { "type": "Blend", "colors": ["gleam", "palette.foam"], "weights": "calmer" },
        "calmer": { "type": "Clamp", "field": "= knobs.calm", "max": 2 },
        "cut": { "type": "Clamp", "field": 0.5, "max": "= knobs.bound * (1 + 0 * knobs.half)" }
    },
    "outputs": { "beauty": { "color": "sheen" }, "cut": { "weights": "cut" } }
}"##;

#[test]
fn colors_and_numbers_change_without_a_new_plan() {
    let light = noise(1, 1.0);
    let of = |set: &[&str]| {
        let builder = LookBuilder::new(LOOK).output("beauty").bind("light");
        let look = set.iter().fold(builder, |builder, set| builder.set(set)).build().unwrap();
        shade(&mut look.shader().unwrap(), std::slice::from_ref(&light), AREA).unwrap()
    };
    let open = LookBuilder::new(LOOK).output("beauty").bind("light");
    let open = open.bind("palette.foam").bind("water.stops[1].color").bind("gleam.weight").build().unwrap();
    assert_eq!(
        open.slots().iter().map(|slot| slot.kind).collect::<Vec<_>>(),
        [Kind::MASK, Kind::Color, Kind::Color, Kind::MASK]
    );
    let mut shader = open.shader().unwrap();
    let color = |hex: &str| trochoid::parse_hex(hex).unwrap().map(|channel| channel as f32);
    for (foam, middle, weight) in
        [("#ece6c2", "#839191", 0.25), ("#ff0000", "#00ff80", 1.0), ("#102030", "#405060", 0.0)]
    {
        let (foam_is, middle_is) = (color(foam), color(middle));
        let mut inputs = vec![Samples::new(&light)];
        inputs.extend(foam_is.iter().chain(&middle_is).chain([&weight]).map(Samples::uniform));
        let mut out = vec![vec![0.0; AREA]; 3];
        let mut outputs: Vec<SamplesMut<'_>> = out.iter_mut().map(|plane| SamplesMut::new(plane)).collect();
        shader.shade(AREA, &inputs, &mut outputs).unwrap();
        let sets = [
            format!("palette.foam={foam}"),
            format!("water.stops[1].color={middle}"),
            format!("gleam.weight={weight}"),
        ];
        assert_eq!(out, of(&sets.each_ref().map(String::as_str)), "{sets:?}");
    }
    // Unbound, they stay what they are.
    let graph = open.graph().clone();
    let look = Look::new(graph, "beauty", 1, &["light"], &Settings::default()).unwrap();
    assert_eq!(shade(&mut look.shader().unwrap(), std::slice::from_ref(&light), AREA).unwrap(), of(&[]));
    // A knob of the document is every port that takes it.
    let knob = LookBuilder::new(LOOK).output("beauty").bind("light").bind("knobs.calm").build().unwrap();
    assert_eq!(knob.slot("knobs.calm").unwrap().kind, Kind::MASK);
    let mut shader = knob.shader().unwrap();
    for calm in [0.0, 0.25, 0.3, 1.0] {
        let found = shade(&mut shader, &[light.clone(), vec![calm; AREA]], AREA).unwrap();
        assert_eq!(found, of(&[&format!("knobs.calm={calm}")]), "{calm}");
    }
    let field = LookBuilder::new(LOOK).output("cut").bind("light").bind("cut.field").build().unwrap();
    assert_eq!(field.slot("cut.field").unwrap().kind, Kind::Field(1));
    let depths = vec![-7.0, 0.5, 1.5, f32::INFINITY];
    let found = shade(&mut field.shader().unwrap(), &[Vec::new(), depths], 4).unwrap();
    assert_eq!(found, [[0.0, 0.25, 0.75, 1.0]]);
}

#[test]
fn what_cannot_be_bound_is_told() {
    let error = |name: &str| LookBuilder::new(LOOK).output("beauty").bind(name).build().map(|_| ()).unwrap_err();
    for (name, words) in [
        ("lihgt", "no node has that name"),
        ("palette.foan", "did you mean \"foam\"?"),
        ("knobs.clam", "did you mean \"calm\"?"),
        ("knobs.half", "is used in a formula"),
        ("knobs.bound", "is used in a formula"),
        ("knobs.unused", "not at all"),
        ("watre.weight", "did you mean \"water\"?"),
        ("water.stops[3].color", "is no port with a color or number of its own"),
        ("water.stops[1].at", "is no port"),
        ("water.weight", "is no port with a color or number of its own"),
        ("water.stops", "is no port"),
        (".", "no node"),
    ] {
        let text = error(name).to_string();
        assert!(text.contains(words), "{name}: {text}");
    }
    assert!(matches!(error("palette.x"), LookError::Open { fault: OpeningFault::NoColor { .. }, .. }));
    let two = LookBuilder::new(LOOK).bind("light").build().map(|_| ()).unwrap_err();
    assert!(two.to_string().contains("found 2 outputs (beauty, cut)"), "{two}");
    assert!(matches!(LookBuilder::new("{").build(), Err(LookError::Load(_))));
}

#[test]
fn looks_go_to_other_threads() {
    fn is_shared<T: Send + Sync>() {}
    fn moves<T: Send>() {}
    is_shared::<Look>();
    moves::<Shader>();
    let look = LookBuilder::new(LOOK).output("beauty").bind("light").build().unwrap();
    let light = noise(1, 1.0);
    let expected = shade(&mut look.shader().unwrap(), std::slice::from_ref(&light), AREA).unwrap();
    std::thread::scope(|scope| {
        for _ in 0..4 {
            let mut shader = look.shader().unwrap();
            let (light, expected) = (&light, &expected);
            scope.spawn(move || {
                for _ in 0..50 {
                    assert_eq!(shade(&mut shader, std::slice::from_ref(light), AREA).unwrap(), *expected);
                }
            });
        }
    });
}

#[test]
fn knobs_that_reach_ports_through_groups_can_be_bound() {
    let document = r##"{
        "trochoid": 1,
        "working_space": "srgb",
        "knobs": { "calm": 0.25 },
        "groups": { "Veiled": {
            "inputs": { "on": "Color" },
            "knobs": { "veil": { "default": 0.5, "min": 0, "max": 1 } },
            "nodes": { "mixed": { "type": "Mix", "a": "on", "b": "#ffffff", "weight": "= knobs.veil" } },
            "outputs": { "color": "mixed" }
        } },
        "nodes": {
            "light": { "type": "ScreenX" },
            "dark": { "type": "Mix", "a": "#000000", "b": "#204060", "weight": "light" },
            "far": { "type": "Veiled", "on": "dark", "veil": "= knobs.calm" },
            "near": { "type": "Veiled", "on": "far", "veil": "= knobs.calm" }
        },
        "outputs": { "beauty": { "color": "near" } }
    }"##;
    let light = noise(1, 1.0);
    let bound = LookBuilder::new(document).bind("light").bind("knobs.calm").build().unwrap();
    for calm in [0.0, 0.3, 1.0] {
        let found = shade(&mut bound.shader().unwrap(), &[light.clone(), vec![calm; AREA]], AREA).unwrap();
        let set = LookBuilder::new(document).bind("light").set(&format!("knobs.calm={calm}")).build().unwrap();
        assert_eq!(found, shade(&mut set.shader().unwrap(), std::slice::from_ref(&light), AREA).unwrap(), "{calm}");
    }
}
