use super::*;
use std::path::Path;

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
        pixels: 12,
        whole: true,
        set: Vec::new(),
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
        assert!(number("measured_max") <= number("certified_max"), "{rung}");
        assert!(number("measured_rms") <= number("measured_max"), "{rung}");
        assert!(number("seconds") > 0.0 && number("predicted_over_taken") > 0.0 && number("measured_pixels") > 0.0);
        assert_eq!((number("hull_exits"), number("nan_count")), (0.0, 0.0));
    }
    let attempts = json["attempts"].as_array().unwrap();
    assert_eq!(attempts.len(), 10);
    for attempt in attempts {
        let (met, allowed) = (attempt["met"].as_bool().unwrap(), attempt["allowed"].as_f64().unwrap());
        assert!(!met || attempt["certified_max"].as_f64().unwrap() <= allowed, "{attempt}");
        assert!(met || attempt["limited_by"].is_object() || attempt["limited_by"].is_string(), "{attempt}");
    }
    assert!(attempts[0]["met"] == true && attempts[9]["met"] == false, "{attempts:?}");
    let fastest = |allowed: f64| {
        let meets = rungs.iter().filter(|rung| {
            rung["is_method"] == true && rung["certified_max"].as_f64().is_some_and(|certified| certified <= allowed)
        });
        meets.min_by(|a, b| a["seconds"].as_f64().unwrap().total_cmp(&b["seconds"].as_f64().unwrap()))
    };
    for attempt in attempts {
        let expected =
            fastest(attempt["allowed"].as_f64().unwrap()).map_or(&serde_json::Value::Null, |rung| &rung["set"]);
        assert_eq!(&attempt["set"], expected, "{attempt}");
    }
    assert!(rungs.iter().chain(attempts).all(|row| row["scope"] == "whole") && json["summary"][2].is_null(), "{json}");
    let csv = read(&args, "report.csv");
    let lines: Vec<&str> = csv.lines().collect();
    assert_eq!(lines.len(), 1 + rungs.len());
    assert!(lines[1].contains("sea, \"\"calm\"\".json\""), "{}", lines[1]);
    let mut table = ::csv::Reader::from_reader(csv.as_bytes());
    let columns = table.headers().unwrap().len();
    assert!(table.records().all(|record| record.unwrap().len() == columns) && columns > 20);
    let html = read(&args, "report.html");
    assert!(html.matches("<svg").count() >= 6 && html.contains("data:image/png;base64,"), "plots are missing");
    assert!(!html.contains("NaN") && !html.contains("<script") && !html.contains("strips"));
    assert!(html.split("http").skip(1).all(|rest| rest.starts_with("://www.w3.org/")), "something is fetched");
}

#[test]
fn the_text_stays_within_a_terminal() {
    let folder = tempfile::tempdir().unwrap();
    let args = Args { whole: false, pixels: 4, ..arguments(folder.path()) };
    let loaded = trochoid::load(&args.graph, &[]).unwrap();
    let ladder = measure(&args, &loaded.graph, 0, 1).unwrap();
    let text = text::table(&Report::new(&loaded.graph, &ladder, false));
    // The line that names the document may be longer; escape sequences do not count.
    let long = text
        .lines()
        .filter(|line| !line.contains(".json"))
        .find(|line| anstream::adapter::strip_str(line).to_string().chars().count() > 100);
    assert_eq!(long, None);
    assert!(text.contains("points exact") && text.contains("1/512") && !text.contains("NaN"), "{text}");
}

/// Measures a document; returns its report as JSON, as a page and as text.
fn forms(args: &Args) -> [String; 3] {
    let loaded = trochoid::load(&args.graph, &[]).unwrap();
    let ladder = measure(args, &loaded.graph, 0, 1).unwrap();
    let report = Report::new(&loaded.graph, &ladder, args.whole);
    let csv = csv::table(&report).unwrap();
    assert!(String::from_utf8(csv).unwrap().contains(&format!(",{},", report.scope())));
    [data::to_json(&report).to_string(), html::page(&report).unwrap(), text::table(&report)]
}

#[test]
fn what_is_certified_on_strips_is_said_to_be_so_wherever_it_stands() {
    let folder = tempfile::tempdir().unwrap();
    let [json, html, text] = forms(&Args { whole: false, pixels: 2, ..arguments(folder.path()) });
    let json: serde_json::Value = serde_json::from_str(&json).unwrap();
    let rows = json["rungs"].as_array().unwrap().iter().chain(json["attempts"].as_array().unwrap());
    assert!(json["whole"] == false && rows.into_iter().all(|row| row["scope"] == "strips"), "{json:#}");
    let summary = json["summary"].as_array().unwrap();
    let sentence = |index: usize| summary[index].as_str().unwrap();
    assert!(sentence(0).contains(" on the strips in "), "{summary:?}");
    assert!(sentence(1).contains(" is met on the strips by "), "{summary:?}");
    assert!(sentence(2).contains("--whole"), "{summary:?}");
    for words in ["largest error on the strips, certified", "\nmet on the strips\n", ">certified on the strips</th>"] {
        assert!(html.contains(words), "no \"{words}\"");
    }
    for words in [
        "certified†",
        "† on strips, an eighth",
        "met on the strips by ",
        "+points mesh, fineness 4",
        "+ a coarser or finer",
    ] {
        assert!(text.contains(words), "no \"{words}\" in: {text}");
    }
}

#[test]
fn a_pass_that_knows_no_bound_is_named_and_plots_without_points_are_not_drawn() {
    let folder = tempfile::tempdir().unwrap();
    let args = Args { pixels: 2, ..arguments(folder.path()) };
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
    fails(occupied, &["error: "]);
}
