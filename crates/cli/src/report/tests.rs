use super::*;
use crate::changes::Changes;
use std::path::Path;
use trochoid::Picture;
use trochoid::accuracy::*;

/// A sea in a picture that is small enough to be measured quickly.
const SEA: &str = r##"{ "trochoid": 1,
  "format": { "width": 64, "height": 36 }, "working_space": "srgb",
  "nodes": { "camera": { "type": "Camera", "position": [0, 6, 30], "target": [0, 1, 0] },
             "sea": { "type": "GerstnerSea", "count": 12 },
             "view": { "type": "Render", "camera": "camera", "surfaces": ["sea"] },
             "fresnel": { "type": "Fresnel", "view": "view" },
             "grain": { "type": "Grain" },
             "water": { "type": "Mix", "a": "#1a2438", "b": "#93b4a6", "weight": "fresnel" } },
  "outputs": { "beauty": { "color": "water" }, "other": { "color": "water" } } }"##;

fn arguments(folder: &Path) -> Args {
    let graph = folder.join("sea, \"calm\".json");
    std::fs::write(&graph, SEA).unwrap();
    Args {
        graph,
        frame: None,
        output: None,
        size: 32,
        seconds: 50,
        pixels: Some(16),
        whole: true,
        seed: 1,
        changes: Changes::default(),
        threads: 0,
        files: Default::default(),
        out: folder.join("out"),
        quiet: true,
        json: false,
    }
}

fn read(args: &Args, name: &str) -> String {
    std::fs::read_to_string(args.out.join(name)).unwrap()
}

#[test]
fn a_report_is_whole_in_every_form() {
    let folder = tempfile::tempdir().unwrap();
    let args = arguments(folder.path());
    run(&args).unwrap();
    let json: serde_json::Value = serde_json::from_str(&read(&args, "report.json")).unwrap();
    let rungs = json["rungs"].as_array().unwrap();
    // Coarser and finer meshes, and three methods.
    assert_eq!((rungs.len(), json["output"].as_str()), (7, Some("beauty")));
    for rung in rungs {
        let number = |column: &str| rung[column].as_f64().unwrap_or_else(|| panic!("{column} of {rung}"));
        for part in ["max", "clear_max", "max_working", "clear_max_working"] {
            assert!(number(&format!("measured_{part}")) <= number(&format!("certified_{part}")), "{part}: {rung}");
        }
        assert!(number("measured_rms") <= number("measured_max"), "{rung}");
        for name in ["measured_beyond_8_bit", "measured_apart_beyond_8_bit", "ambiguous_pixels", "measured_median"] {
            let [low, value, high] = ["_low", "", "_high"].map(|end| number(&format!("{name}{end}")));
            assert!(low <= value && value <= high, "{name}: {rung}");
        }
        assert!((0.0..32.0).contains(&number("measured_max_x")) && (0.0..18.0).contains(&number("measured_max_y")));
        assert!(number("render_seconds_least") > 0.0 && number("predicted_over_taken") > 0.0);
        assert!(number("certify_over_render") > 0.0 && rung["certify_is_predicted"] == false);
        assert_eq!((number("measured_pixels"), number("certified_pixels"), number("render_runs")), (16.0, 576.0, 5.0));
        assert_eq!(
            (number("pixels_outside_hull"), number("pixels_no_number"), number("bounds_broken")),
            (0.0, 0.0, 0.0)
        );
    }
    let attempts = json["attempts"].as_array().unwrap();
    assert_eq!(attempts.len(), 10);
    for attempt in attempts {
        let (met, allowed) = (attempt["met"].as_bool().unwrap(), attempt["allowed"].as_f64().unwrap());
        assert!(!met || attempt["certified"].as_f64().unwrap() <= allowed, "{attempt}");
        assert!(met || attempt["limited_by"].is_object() || attempt["limited_by"].is_string(), "{attempt}");
    }
    assert!(attempts[0]["met"] == true && attempts[9]["met"] == false, "{attempts:?}");
    let fastest = |allowed: f64| {
        let meets = rungs.iter().filter(|rung| {
            // Tolerances of the whole picture are judged on samples, of which pixels are means.
            let certified = rung["certified_clear_max_working"].as_f64();
            rung["is_method"] == true && certified.is_some_and(|certified| certified <= allowed)
        });
        let seconds = |rung: &serde_json::Value| rung["render_seconds"].as_f64().unwrap();
        meets.min_by(|a, b| seconds(a).total_cmp(&seconds(b)))
    };
    for attempt in attempts {
        let expected =
            fastest(attempt["allowed"].as_f64().unwrap()).map_or(&serde_json::Value::Null, |rung| &rung["set"]);
        assert_eq!(&attempt["set"], expected, "{attempt}");
    }
    assert!(
        rungs.iter().chain(attempts).all(|row| row["scope"] == "whole") && json["left_to_whole"].is_null(),
        "{json}"
    );
    assert!(json["pixels"]["looked_at"].as_u64().unwrap() >= 16 && json["pixels"]["total"] == 576, "{json}");
    let csv = read(&args, "report.csv");
    let lines: Vec<&str> = csv.lines().collect();
    assert_eq!(lines.len(), 1 + rungs.len());
    assert!(lines[1].contains("sea, \"\"calm\"\".json\""), "{}", lines[1]);
    let mut table = ::csv::Reader::from_reader(csv.as_bytes());
    let columns = table.headers().unwrap().len();
    assert!(table.records().all(|record| record.unwrap().len() == columns) && columns > 20);
    let html = read(&args, "report.html");
    assert!(html.matches("<svg").count() >= 7 && html.contains("data:image/png;base64,"), "plots are missing");
    assert!(!html.contains("NaN") && !html.contains("<script") && !html.contains("at the pixels looked at from"));
    assert!(html.split("http").skip(1).all(|rest| rest.starts_with("://www.w3.org/")), "something is fetched");
}

/// Measures a document; returns its report as JSON, as a page and as text.
fn forms(args: &Args) -> [String; 3] {
    let loaded = trochoid::load(&args.graph, &[]).unwrap();
    let ladder = measure(args, &loaded.graph, 0, 1).unwrap();
    let report = Report::new(&loaded.graph, &ladder, args.within());
    let csv = csv::table(&report).unwrap();
    assert!(String::from_utf8(csv).unwrap().contains(&format!(",{},", report.scope())));
    [json::to_json(&report).to_string(), html::page(&report).unwrap(), text::table(&report)]
}

#[test]
fn what_holds_at_some_pixels_is_said_to_do_so_wherever_it_stands() {
    let folder = tempfile::tempdir().unwrap();
    let args = Args { whole: false, ..arguments(folder.path()) };
    let [json, html, text] = forms(&args);
    let json: serde_json::Value = serde_json::from_str(&json).unwrap();
    let rows = json["rungs"].as_array().unwrap().iter().chain(json["attempts"].as_array().unwrap());
    assert!(json["whole"] == false && rows.into_iter().all(|row| row["scope"] == "pixels"), "{json:#}");
    let summary: Vec<&str> = json["summary"].as_array().unwrap().iter().map(|text| text.as_str().unwrap()).collect();
    let says = |words: &str| summary.iter().any(|sentence| sentence.contains(words));
    for words in [
        " at the pixels looked at in ",
        " is met at the pixels looked at by ",
        "16 of 576 pixels were drawn, one in each of as many equal parts of the picture, and 16 of the ",
        // 1 − 0.025^(1/16)
        "What holds at all of them fails at no more than 20.6 % of the picture's pixels, with a confidence of 95 %.",
        "Left to --whole: the bounds of all pixels with their map, the time saved by leaving out 1 node and the time over",
    ] {
        assert!(says(words), "no \"{words}\" in {summary:?}");
    }
    assert!(json["rungs"][0]["certify_is_predicted"] == true && json["scalings"].as_array().unwrap().is_empty());
    for words in ["is met at the pixels looked at by", ">where settings differ</th>", "Left to <code>--whole</code>: "]
    {
        assert!(html.contains(words), "no \"{words}\"");
    }
    for words in ["ambiguous at the pixels looked at\n", "met at the pixels looked at by ", "+ a coarser or finer", "~"]
    {
        assert!(text.contains(words), "no \"{words}\" in: {text}");
    }
    // The same pixels, with the same figures: only times differ.
    let [again, ..] = forms(&args);
    let again: serde_json::Value = serde_json::from_str(&again).unwrap();
    for (rung, other) in json["rungs"].as_array().unwrap().iter().zip(again["rungs"].as_array().unwrap()) {
        for (name, value) in rung.as_object().unwrap() {
            let is_time = ["seconds", "over_render", "over_taken", "pareto"].iter().any(|word| name.contains(word));
            assert!(is_time || *value == other[name], "{name}: {value}, {}", other[name]);
        }
    }
}

#[test]
fn a_pass_that_knows_no_bound_is_named_and_plots_without_points_are_not_drawn() {
    let folder = tempfile::tempdir().unwrap();
    let args = Args { pixels: Some(2), ..arguments(folder.path()) };
    let painted = r##"{ "trochoid": 1, "format": { "width": 24, "height": 16 },
      "nodes": { "across": { "type": "ScreenX" },
                 "ramp": { "type": "Mix", "a": "#123", "b": "#fed", "weight": "across" },
                 "s": { "type": "Strokes", "image": "ramp", "layers": [{ "length": 8, "width": 3, "spacing": 4 }] } },
      "outputs": { "beauty": { "color": "s" } } }"##;
    std::fs::write(&args.graph, painted).unwrap();
    let [json, html, text] = forms(&args);
    let json: serde_json::Value = serde_json::from_str(&json).unwrap();
    for attempt in json["attempts"].as_array().unwrap() {
        let limit = &attempt["limited_by"];
        assert_eq!((limit["node"].as_str(), limit["type"].as_str()), (Some("s"), Some("Strokes")), "{attempt}");
        assert!(limit["why"].is_string(), "{attempt}");
    }
    let summary = json["summary"][0].as_str().unwrap();
    assert!(summary.contains("because “s” (Strokes) has no error bound: "), "{summary}");
    for plot in
        ["Error against time", "Certified against measured errors", "Tolerance requested against error achieved"]
    {
        assert!(!html.contains(&format!("aria-label=\"{plot}\"")), "{plot} has no points");
    }
    assert_eq!(html.matches("Nothing is certified of “beauty”").count(), 4, "in the summary and for each plot");
    assert!(text.contains("nothing: \"s\" (Strokes) has no error bound") && !text.contains("rounding"), "{text}");
}

#[test]
fn faults_are_told_before_anything_is_measured() {
    let folder = tempfile::tempdir().unwrap();
    let fails = |args: Args, words: &[&str]| {
        let failure = run(&args).unwrap_err();
        assert!(words.iter().all(|word| failure.messages[0].text().contains(word)), "{:?}", failure.messages);
        assert!(!args.out.join("report.json").exists());
    };
    fails(Args { output: Some("beuaty".into()), ..arguments(folder.path()) }, &["beuaty", "beauty"]);
    let occupied = Args { out: folder.path().join("sea, \"calm\".json"), ..arguments(folder.path()) };
    fails(occupied, &["found a file", "expected a folder"]);
}

/// A ladder of three settings with figures made up for the test.
fn made_up() -> Ladder {
    let looked_at = LookedAt { picture: 64, apart: 32, all: 98, total: 230_400, differing: 104_000, given_up: 2 };
    let at =
        |display: f64, pixel: [i64; 2]| Some(ErrorAt { size: ErrorSize { display, working: 2.0 * display }, pixel });
    let figures = |size: f64| {
        let sample = |count: u32| {
            ErrorSample::new((1..=count).map(|rank| size * f64::from(rank) / f64::from(count)).collect(), false)
        };
        let (max, clear_max) = (at(4.0 * size, [312, 200]), at(2.0 * size, [7, 358]));
        ErrorFigures { picture: sample(64), apart: sample(32), max, clear_max }
    };
    let rung = |set: &str, size: f64, seconds: &[f64]| {
        let picture = Picture {
            output: 0,
            kind: Kind::Color,
            planes: vec![trochoid::Plane::filled(trochoid::Window::sized(2, 1), 0.25); 3],
            guarantee: None,
            audit: Default::default(),
            control_count: 0,
            control_colors: Vec::new(),
            hull: None,
            margin: 0.0,
        };
        let times = seconds.iter().copied().collect();
        Rung {
            set: vec![set.to_owned()],
            is_method: !set.contains("fineness"),
            certified: Some(figures(2.0 * size)),
            measured: Some(figures(size)),
            judged: Some(8.0 * size),
            ambiguous: Some(Estimate { value: 0.03, low: 0.01, high: 0.08 }),
            ambiguous_beyond_8_bit: None,
            ratios: [Some(2.0), None],
            broken: Vec::new(),
            hull_exits: 0,
            nan: 0,
            times,
            predicted: None,
            certify: Some(CertifyTime { seconds: 20.0 * seconds[0], is_predicted: true }),
            bytes: 12_345_678,
            is_best: size < 0.01,
            passes: Vec::new(),
            map: Vec::new(),
            picture,
        }
    };
    Ladder {
        output: "beauty".into(),
        frame: 36,
        format: Format::new(640, 360, 4).unwrap(),
        threads: 2,
        seed: 1,
        is_whole: false,
        looked_at,
        rungs: vec![
            rung("view.points=mesh", 0.02, &[0.1, 0.11, 0.16]),
            rung("view.fineness=2", 0.005, &[0.2]),
            rung("view.points=exact", 0.000_004, &[3.0, 3.1]),
        ],
        attempts: vec![
            Attempt { tolerance: 1.0 / 64.0, allowed: 0.001_2, rung: Some(2), limit: None },
            Attempt {
                tolerance: 1e-6,
                allowed: 7.7e-8,
                rung: None,
                limit: Some(Limit::Pass { node: "spray".into(), ty: "Spray" }),
            },
        ],
        savings: vec![Saving {
            node: "old".into(),
            ty: "Mix",
            why: "not connected to the output".into(),
            is_node: true,
            seconds: None,
        }],
        scalings: Vec::new(),
        costly: 5,
        unseen: vec![Unseen { view: "view".into(), nodes: vec!["shoal".into()] }],
        shortfall: Shortfall { settings: vec![vec!["view.points=surface".into()]], certify: 1, ..Shortfall::default() },
    }
}

#[test]
fn the_text_says_what_was_found_and_what_was_not() {
    let folder = tempfile::tempdir().unwrap();
    let args = arguments(folder.path());
    let graph = trochoid::load(&args.graph, &[]).unwrap().graph;
    let mut ladder = made_up();
    let text = |ladder: &Ladder| {
        let text = text::table(&Report::new(&graph, ladder, Some(50.0)));
        anstream::adapter::strip_str(&text).to_string().replace(graph.name(), "sea.json")
    };
    let found = text(&ladder);
    let stored = Path::new(env!("CARGO_MANIFEST_DIR")).join("src/report/told.txt");
    if std::env::var_os("TROCHOID_UPDATE").is_some() {
        std::fs::write(&stored, &found).unwrap();
    }
    assert_eq!(found, include_str!("told.txt"), "TROCHOID_UPDATE=1 stores what was found");
    let long = found.lines().find(|line| line.chars().count() > 100);
    assert_eq!(long, None);
    ladder.rungs[1].broken = vec![BrokenBound { pixel: [3, 4], bound: 1e-3, error: 2e-3 }];
    let found = text(&ladder);
    let words =
        "1 bound does not hold. At pixel (3, 4), fineness 2, the error is 2.00e-3 in srgb, and the bound 1.00e-3";
    assert!(found.replace('\n', " ").contains(words), "{found}");
}
