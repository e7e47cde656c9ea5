use super::*;
use crate::failure::{FAILED, INTERRUPTED, MISSED};
use std::path::Path;
use trochoid::{Buffers, Cache, EvalError, Frame, Monitor, Plan, Sink};

const DOCUMENT: &str = r##"{
    "trochoid": 1, "format": { "width": 8, "height": 4 }, "frames": { "first": 1, "last": 3 },
    "nodes": { "across": { "type": "ScreenX" },
               "mix": { "type": "Mix", "a": "#123", "b": "#fed", "weight": "across" } },
    "outputs": { "beauty": { "color": "mix", "file": "beauty.#.exr" },
                 "mask": { "weights": "across", "file": "mask.#.exr" } } }"##;

fn arguments(folder: &Path) -> Args {
    let graph = folder.join("a.json");
    std::fs::write(&graph, DOCUMENT).unwrap();
    Args { graph, quiet: true, report: Some(folder.join("report.json")), ..Args::default() }
}

fn report(folder: &Path) -> serde_json::Value {
    serde_json::from_slice(&std::fs::read(folder.join("report.json")).unwrap()).unwrap()
}

fn honest(
    plan: &Plan<'_>,
    sink: Option<&dyn Sink>,
    cache: &mut Cache,
    monitor: &dyn Monitor,
) -> Result<Frame, EvalError> {
    plan.evaluate_to(sink.expect("EXR is streamed"), &Buffers::new(), cache, monitor)
}

/// Evaluates a plan, and forges the second frame to have left the hull, which no document can achieve.
fn forged(
    plan: &Plan<'_>,
    sink: Option<&dyn Sink>,
    cache: &mut Cache,
    monitor: &dyn Monitor,
) -> Result<Frame, EvalError> {
    let mut frame = honest(plan, sink, cache, monitor)?;
    if frame.number == 2 {
        (frame.pictures[0].audit.hull_exits, frame.pictures[0].audit.worst_exit) = (5, 0.25);
    }
    Ok(frame)
}

#[test]
fn a_missed_guarantee_writes_no_file_and_lets_the_others_go_on() {
    let folder = tempfile::tempdir().unwrap();
    let args = Args { require: Some("hull".into()), ..arguments(folder.path()) };
    let failure = run_with(&args, &forged).unwrap_err();
    assert_eq!(failure.code, MISSED);
    let there = |name: &str| folder.path().join(name).exists();
    assert!(there("beauty.1.exr") && !there("beauty.2.exr") && there("beauty.3.exr"));
    assert!(there("mask.2.exr"), "nothing is required of a mask");
    let report = report(folder.path());
    assert_eq!(report["status"], "guarantee missed");
    assert_eq!(report["frames"][1]["outputs"]["beauty"]["hull_exits"], 5);
    assert_eq!(report["frames"][1]["files"][0]["state"], "required guarantee missed");
}

#[test]
fn without_a_requirement_the_same_frame_is_written_but_resume_does_not_take_it_for_one_that_holds() {
    let folder = tempfile::tempdir().unwrap();
    let args = arguments(folder.path());
    run_with(&args, &forged).unwrap();
    assert!(folder.path().join("beauty.2.exr").exists());
    let resumed = Args { resume: true, ..arguments(folder.path()) };
    run_with(&resumed, &|_, _, _, _| panic!("every file is up to date")).unwrap();
    let strict = Args { resume: true, require: Some("box".into()), ..arguments(folder.path()) };
    let evaluated = std::sync::Mutex::new(Vec::new());
    run_with(&strict, &|plan, sink, cache, monitor| {
        evaluated.lock().unwrap().push(plan.frame());
        honest(plan, sink, cache, monitor)
    })
    .unwrap();
    assert_eq!(*evaluated.lock().unwrap(), [2]);
}

#[test]
fn a_failed_evaluation_stops_and_keeps_what_is_done() {
    let folder = tempfile::tempdir().unwrap();
    let fails_at_two =
        |plan: &Plan<'_>, sink: Option<&dyn Sink>, cache: &mut Cache, monitor: &dyn Monitor| match plan.frame() {
            2 => Err(EvalError::Memory { bytes: 7 }),
            _ => honest(plan, sink, cache, monitor),
        };
    let failure = run_with(&arguments(folder.path()), &fails_at_two).unwrap_err();
    assert_eq!(failure.code, FAILED);
    assert!(failure.messages[0].to_string().starts_with("error: frame 2: out of memory"), "{failure:?}");
    assert!(folder.path().join("mask.1.exr").exists() && !folder.path().join("mask.3.exr").exists());
    assert_eq!(report(folder.path())["status"], "failed");
    assert_eq!(report(folder.path())["frames"].as_array().unwrap().len(), 1);
}

#[test]
fn a_cancelled_evaluation_is_an_interruption() {
    let folder = tempfile::tempdir().unwrap();
    let failure = run_with(&arguments(folder.path()), &|_, _, _, _| Err(EvalError::Cancelled)).unwrap_err();
    assert_eq!(failure.code, INTERRUPTED);
    assert_eq!(report(folder.path())["status"], "interrupted");
    assert!(!folder.path().join("beauty.1.exr").exists());
}

#[test]
fn long_work_at_a_late_frame_is_told_by_its_place() {
    let folder = tempfile::tempdir().unwrap();
    let args = arguments(folder.path());
    let sea = r#"{ "trochoid": 1, "format": { "width": 8, "height": 4 }, "nodes": {
"camera": { "type": "Camera" },
"sea": { "type": "ToonSea", "columns": 512, "rows": 512, "bursts": [{ "path": [1, 1, 2, 2, 3, 3, 4, 4] }] },
"view": { "type": "Render", "camera": "camera", "surfaces": ["sea"] },
"depth": { "type": "Depth", "view": "view" } }, "outputs": { "depth": { "field": "depth" } } }"#;
    std::fs::write(&args.graph, sea).unwrap();
    let loaded = trochoid::load(&args.graph, &[]).unwrap();
    let warnings = |frame: i64| {
        let mut faults = Vec::new();
        let chosen = Chosen::new(loaded.graph.clone(), &args, &mut faults);
        let job = Job::new(&chosen, &args, Some(vec![frame]), &mut faults);
        assert!(faults.is_empty(), "{faults:?}");
        job.warnings()
    };
    assert_eq!(warnings(1), [""; 0]);
    let [late] = &warnings(1_000_000)[..] else { panic!("{:?}", warnings(1_000_000)) };
    let words = format!("warning: {}:3:1: frame 1000000: node \"sea\", preroll: found about", args.graph.display());
    assert!(late.starts_with(&words), "{late}");
}

#[test]
fn a_frame_of_an_input_that_is_changed_meanwhile_is_not_written() {
    let folder = tempfile::tempdir().unwrap();
    let picture = |value: f32, seconds: u64| {
        let path = folder.path().join("in.exr");
        let samples = vec![value; 32];
        let channel = |name: &str| trochoid::io::ExrChannel::half(name, trochoid::io::Samples::contiguous(&samples));
        let window = trochoid::Window::sized(8, 4);
        let image = trochoid::io::ExrImage {
            channels: ["R", "G", "B"].map(channel).into(),
            ..trochoid::io::ExrImage::new(window)
        };
        trochoid::io::write_exr(&path, &image).unwrap();
        let then = std::time::UNIX_EPOCH + std::time::Duration::from_secs(seconds);
        std::fs::File::options().write(true).open(&path).unwrap().set_modified(then).unwrap();
    };
    let args = arguments(folder.path());
    let document = DOCUMENT
        .replace("\"across\":", "\"in\": { \"type\": \"Read\", \"file\": \"in.exr\", \"as\": \"color\" }, \"across\":");
    std::fs::write(&args.graph, document.replace("\"a\": \"#123\"", "\"a\": \"in\"")).unwrap();
    picture(0.25, 1);
    run_with(&args, &honest).unwrap();
    let whole = std::fs::read(folder.path().join("beauty.2.exr")).unwrap();
    for name in ["beauty.2.exr", "mask.2.exr"] {
        std::fs::remove_file(folder.path().join(name)).unwrap();
    }
    // Another picture of the same length, written after the first was read.
    let args = Args { resume: true, ..args };
    let failure = run_with(&args, &|plan, sink, cache, monitor| {
        let frame = honest(plan, sink, cache, monitor);
        picture(0.5, 2);
        frame
    });
    let failure = failure.unwrap_err();
    assert_eq!(failure.code, FAILED);
    assert!(!folder.path().join("beauty.2.exr").exists(), "nothing is written");
    // With the first picture restored, the same bytes are written.
    picture(0.25, 1);
    run_with(&args, &honest).unwrap();
    assert!(std::fs::read(folder.path().join("beauty.2.exr")).unwrap() == whole);
}
