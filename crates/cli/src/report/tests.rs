use super::*;
use std::path::Path;

/// A sea in a picture so small that all is measured in a moment.
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
    let csv = read(&args, "report.csv");
    let lines: Vec<&str> = csv.lines().collect();
    assert_eq!(lines.len(), 1 + rungs.len());
    assert!(lines[1].contains("sea, \"\"calm\"\".json\""), "{}", lines[1]);
    let mut table = ::csv::Reader::from_reader(csv.as_bytes());
    let columns = table.headers().unwrap().len();
    assert!(table.records().all(|record| record.unwrap().len() == columns) && columns > 20);
    let html = read(&args, "report.html");
    assert!(html.matches("<svg").count() >= 6 && html.contains("data:image/png;base64,"), "plots are missing");
    assert!(!html.contains("NaN") && !html.contains("<script"));
    assert!(html.split("http").skip(1).all(|rest| rest.starts_with("://www.w3.org/")), "something is fetched");
}

#[test]
fn the_text_stays_within_a_terminal() {
    let folder = tempfile::tempdir().unwrap();
    let args = Args { whole: false, pixels: 4, ..arguments(folder.path()) };
    let loaded = trochoid::load(&args.graph, &[]).unwrap();
    let ladder = measure(&args, &loaded.graph, 0, 1).unwrap();
    let text = text::table(&Report::new(&loaded.graph, &ladder, false));
    // One line names the document, however long its name is; escapes take no room.
    let long = text
        .lines()
        .filter(|line| !line.contains(".json"))
        .find(|line| anstream::adapter::strip_str(line).to_string().chars().count() > 100);
    assert_eq!(long, None);
    assert!(text.contains("points exact") && text.contains("1/512") && !text.contains("NaN"), "{text}");
}

#[test]
fn faults_are_told_before_anything_is_measured() {
    let folder = tempfile::tempdir().unwrap();
    let fails = |args: Args, words: &[&str]| {
        let failure = run(&args).unwrap_err();
        assert!(words.iter().all(|word| failure.messages[0].contains(word)), "{:?}", failure.messages);
        assert!(!args.out.join("report.json").exists());
    };
    fails(Args { output: Some("beuaty".into()), ..arguments(folder.path()) }, &["beuaty", "beauty"]);
    let occupied = Args { out: folder.path().join("sea, \"calm\".json"), ..arguments(folder.path()) };
    fails(occupied, &["error: "]);
}
