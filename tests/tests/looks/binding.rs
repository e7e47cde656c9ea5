//! Inputs of looks: what can be bound, and what is told of what cannot.

use super::{AREA, HEIGHT, WIDTH, noise, shade, shaded};
use trochoid::{Cache, Format, Kind, Look, LookBuilder, LookError, Samples, SamplesMut, Settings, Shader, Silent};

/// A document without a format.
const LOOK: &str = r##"{
    "trochoid": 1,
    "working_space": "srgb",
    "palette": { "deep": "#274e53", "foam": "#ece6c2", "spare": "#101a33" },
    "knobs": { "calm": 0.25, "half": 0.5, "bound": 2, "unused": 1 },
    "nodes": {
        "light": { "type": "ScreenX" },
        "water": { "type": "Ramp", "weight": "light", "stops": [
            { "at": 0, "color": "palette.deep" }, { "at": 0.6, "color": "#839191" }, { "at": 1, "color": "palette.foam" } ] },
        "gleam": { "type": "Mix", "a": "water", "b": "palette.foam", "weight": "= knobs.calm" },
        "sheen": { "type": "Blend", "colors": ["gleam", "palette.foam"], "weights": "calmer" },
        "calmer": { "type": "Clamp", "field": "= knobs.calm", "max": 2 },
        "cut": { "type": "Clamp", "field": 0.5, "max": "= knobs.bound * (1 + 0 * knobs.half)" },
        "camera": { "type": "Camera" }
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

/// Returns the message of the only fault of a look with some inputs.
fn refused(builder: &LookBuilder) -> String {
    let error = builder.build().map(|_| ()).unwrap_err();
    assert_eq!(error.diagnostics().len(), 1, "{error}");
    error.to_string()
}

#[test]
fn what_cannot_be_bound_is_told() {
    for (name, words) in [
        ("lihgt", "look: inputs[0]: found \"lihgt\"; expected a node of the document, palette.NAME"),
        ("lihgt", "did you mean \"light\"?"),
        ("sky", "nodes of the document: light, water, gleam, sheen, calmer, cut, camera"),
        ("foam", "did you mean \"palette.foam\"?"),
        ("palette.foan", "look: inputs[0]: found \"palette.foan\"; expected a color of the document's palette"),
        ("palette.foan", "did you mean \"palette.foam\"?"),
        ("palete.foam", "did you mean \"palette.foam\"?"),
        ("palette.zzz", "colors of the palette: deep, foam, spare"),
        ("palette.spare", "found \"palette.spare\", which nothing in the document takes"),
        ("knobs.clam", "did you mean \"knobs.calm\"?"),
        ("knobs.half", "look:5:38: knobs.half: found the input \"knobs.half\", which is used in a formula"),
        ("knobs.bound", "which is used in a formula"),
        ("knobs.unused", "which nothing in the document takes"),
        ("watre.weight", "did you mean \"water.weight\"?"),
        ("gleam.wieght", "did you mean \"gleam.weight\"?"),
        ("gleam.zzz", "look:10:9: node \"gleam\": found the input \"gleam.zzz\"; expected a port of this Mix"),
        ("gleam.zzz", "such ports: gleam.b, gleam.weight"),
        ("water.stops[3].color", "which the document does not set"),
        ("water.stops[3].color", "did you mean \"water.stops[0].color\"?"),
        ("water.stops[1].at", "a knob, which is the same for all samples"),
        ("water.stops[1].at", "set it instead: water.stops[1].at=VALUE"),
        ("water.weight", "look:8:46: node \"water\", weight: found the input \"water.weight\", which is connected"),
        ("water.weight", "remedy: bind \"light\""),
        ("water.stops", "a list"),
        (
            "camera",
            "look:14:9: node \"camera\": found the input \"camera\", a Camera; expected a node that makes a Color",
        ),
        (".", "expected a node of the document"),
    ] {
        let text = refused(&LookBuilder::new(LOOK).output("beauty").bind(name));
        assert!(text.contains(words), "{name}: {text}");
        assert!(!["plan", "buffer"].iter().any(|word| text.contains(word)), "{text}");
    }
    let painted = LOOK
        .replace("\"camera\": {", "\"paint\": { \"type\": \"Constant\", \"color\": \"palette.foam\" }, \"camera\": {");
    let painted = refused(&LookBuilder::new(painted).output("beauty").bind("palette.foam"));
    assert!(painted.contains("node \"paint\", color: found the input \"palette.foam\", a knob"), "{painted}");
    assert!(painted.contains("remedy: bind \"paint\" itself"), "{painted}");
    let keyed = LOOK.replace("\"b\": \"palette.foam\"", "\"b\": { \"keys\": [[1, \"palette.foam\"], [9, \"#fff\"]] }");
    let keyed = refused(&LookBuilder::new(keyed).output("beauty").bind("palette.foam"));
    assert!(keyed.contains("node \"gleam\", b: found the input \"palette.foam\" in keys"), "{keyed}");
    let two = refused(&LookBuilder::new(LOOK).bind("light"));
    assert!(two.contains("look: output: found none of 2 outputs; expected the name of one"), "{two}");
    let recipe = LOOK.replace("\"cut\": { \"weights\": \"cut\" }", "\"parts\": { \"recipe\": \"gleam\" }");
    let recipe = refused(&LookBuilder::new(recipe).output("parts"));
    assert!(recipe.contains("look:16:50: parts: found the recipe of \"gleam\""), "{recipe}");
    assert!(recipe.contains("remedy: ask for an output with \"color\": \"gleam\""), "{recipe}");
    let other = refused(&LookBuilder::new(LOOK).output("beuaty"));
    assert!(other.contains("output: found \"beuaty\"") && other.contains("did you mean \"beauty\"?"), "{other}");
    assert!(matches!(LookBuilder::new("{").build(), Err(LookError::Load(_))));
}

/// What is asked of a sound document has all its faults told at once, in the form of a document's.
#[test]
fn all_faults_of_a_look_are_told_at_once() {
    let asked = LookBuilder::new(LOOK).output("beuaty").bind("lihgt").bind("light").bind("palette.foan");
    let asked = asked.bind("water.weight").set("watre.weight=1").set("gleam.weight=0.5");
    let error = asked.build().map(|_| ()).unwrap_err();
    assert!(matches!(error, LookError::Asked(_)), "{error}");
    let told: Vec<_> = error.diagnostics().iter().map(trochoid::Diagnostic::to_json).collect();
    let places: Vec<_> = told.iter().map(|fault| (fault["port"].as_str(), fault["node"].as_str())).collect();
    assert_eq!(
        places,
        [
            (None, None),
            (Some("output"), None),
            (Some("inputs[0]"), None),
            (Some("inputs[2]"), None),
            (Some("weight"), Some("water"))
        ],
        "{error}"
    );
    assert_eq!(
        (&told[0]["file"], &told[2]["line"], &told[4]["line"]),
        (&"watre.weight=1".into(), &0.into(), &8.into())
    );
    assert_eq!(told[3]["remedy"], "did you mean \"palette.foam\"?");
    // One whose document is invalid has the document's faults.
    let invalid = LookBuilder::new(LOOK.replace("\"light\",", "\"lihgt\",")).output("beauty").bind("zzz");
    let error = invalid.build().map(|_| ()).unwrap_err();
    assert!(matches!(error, LookError::Load(_)) && error.diagnostics()[0].line == 8, "{error}");
}

/// An input is the first output of its node, and stands for no other.
#[test]
fn another_output_of_an_input_is_refused() {
    let sky = |weight: &str| {
        LookBuilder::new(format!(
            r##"{{ "trochoid": 1, "nodes": {{
                "camera": {{ "type": "Camera" }}, "sea": {{ "type": "GerstnerSea", "count": 0 }},
                "view": {{ "type": "Render", "camera": "camera", "surfaces": ["sea"] }},
                "sky": {{ "type": "Sky", "view": "view" }},
                "glow": {{ "type": "Mix", "a": "#000", "b": "#fff", "weight": "{weight}" }},
                "out": {{ "type": "Mix", "a": "#000", "b": "glow", "weight": "sky.sky" }} }},
            "outputs": {{ "out": {{ "color": "out" }} }} }}"##
        ))
        .bind("sky")
    };
    assert!(sky("sky.sky").build().unwrap().shader().is_ok());
    let text = refused(&sky("sky.reflected"));
    assert!(text.contains("inputs[0]: found \"sky\", of which the output needs \"sky.reflected\", too"), "{text}");
    assert!(text.contains("remedy: bind the nodes that take \"sky.reflected\""), "{text}");
    assert!(sky("sky.reflected").bind("glow").build().unwrap().shader().is_ok());
}

/// Of an input and a value, one would have no effect; so would one of two inputs.
#[test]
fn what_is_asked_twice_is_refused() {
    let look = || LookBuilder::new(LOOK).output("beauty").bind("light").bind("palette.foam");
    let sheen = |builder: LookBuilder| builder.bind("knobs.calm").bind("water.stops[1].color");
    for (builder, words) in [
        (look().bind("light"), "inputs[2]: found \"light\", which is inputs[0] already; expected each input once"),
        (look().bind("gleam.b"), "\"gleam.b\", which is the input \"palette.foam\" already"),
        (look().bind("water.stops[1].color").bind("water.stops[1].color[0]"), "\"water.stops[1].color\" already"),
        (
            look().set("palette.foam=#fff"),
            "error: palette.foam=#fff: found a value for \"palette.foam\", whose place inputs[1], \"palette.foam\", takes",
        ),
        (sheen(look()).set("knobs.calm=0.5"), "a value for \"knobs.calm\", whose place inputs[2]"),
        (sheen(look()).set("water.stops[1].color=#000"), "whose place inputs[3]"),
        (look().set("light.type=ScreenY"), "a value for \"light.type\", whose place inputs[0], \"light\", takes"),
    ] {
        let text = refused(&builder);
        assert!(text.contains(words) && text.contains("leave one of them out"), "{text}");
    }
    // A list around an input, and other values, have effects.
    let sets =
        ["water.stops=[{ \"at\": 0, \"color\": \"#000\" }, { \"at\": 1, \"color\": \"#fff\" }]", "knobs.bound=3"];
    let look = sets.iter().fold(sheen(look()), |builder, set| builder.set(set));
    assert_eq!(look.build().unwrap().slots().len(), 4);
    // The number of thresholds is that of the weights that are supplied.
    let bands = r##"{ "trochoid": 1, "nodes": {
        "deep": { "type": "ScreenX" }, "bands": { "type": "Bands", "field": "deep", "thresholds": [0.5] },
        "parts": { "type": "Multiply", "weights": ["deep", 0.5] } },
        "outputs": { "bands": { "weights": "bands" } } }"##;
    let look = LookBuilder::new(bands).bind("bands").set("bands.thresholds=[0.2, 0.4]").build().unwrap();
    assert_eq!(look.slots()[0].kind, Kind::Weights(3));
    // Nodes by their names, without a builder.
    let twice = Look::new(shaded(), "out", 1, &["light", "depth", "light"], &Settings::default()).unwrap_err();
    assert!(twice.to_string().contains("cannot bind \"light\": it is bound already"), "{twice}");
}

#[test]
fn pictures_run_on_as_many_threads_as_they_may() {
    for threads in [1, 3] {
        let look = LookBuilder::new(LOOK).output("beauty").bind("light").threads(threads).build().unwrap();
        let light = noise(1, 1.0);
        let format = Format::new(WIDTH as u32, HEIGHT as u32, 1).unwrap();
        let frame = look.picture(format, &[Samples::new(&light)], &mut Cache::new(), &Silent).unwrap();
        assert_eq!(frame.threads, threads);
    }
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
