use super::*;
use crate::shown::{bytes, show};
use std::path::Path;

const GRAPH: &str = r##"{
  "trochoid": 1, "format": { "width": 6, "height": 3 }, "working_space": "srgb",
  "frames": { "first": 1, "last": 4, "fps": 20 },
  "nodes": {
    "across": { "type": "ScreenX" },
    "beauty": { "type": "Mix", "a": { "keys": [[1, "#000000"], [4, "#ff0000"]] }, "b": "#ffffff", "weight": "across" },
    "values": { "type": "FieldMath", "a": "across", "expression": "3 + 2 * a" }
  },
  "outputs": { "beauty": { "color": "beauty" }, "mask": { "weights": "across" }, "values": { "field": "values" } }
}"##;

fn args(folder: &Path, out: &str) -> Args {
    let graph = folder.join("graph.json");
    std::fs::write(&graph, GRAPH).unwrap();
    let out = folder.join(out);
    Args {
        graph,
        output: None,
        view: None,
        frames: None,
        scale: None,
        shrink: None,
        quality: 90,
        out,
        changes: Changes::default(),
        files: FileOptions::default(),
        quiet: true,
    }
}

fn rgb(path: &Path) -> ([usize; 2], Vec<f32>) {
    let picture = trochoid::io::read(path, &trochoid::io::Selection::channels(["R", "G", "B"]), &Default::default());
    let picture = picture.unwrap();
    let planes: Vec<_> = picture.channels.iter().map(|channel| &channel.plane).collect();
    let size = [planes[0].window().width(), planes[0].window().height()];
    (size, (0..size[0] * size[1]).flat_map(|i| planes.iter().map(move |plane| plane.samples()[i])).collect())
}

#[test]
fn an_animation_has_the_size_and_times_that_were_asked_for() {
    let folder = tempfile::tempdir().unwrap();
    let args = Args { frames: Some("1-4x3".into()), ..args(folder.path(), "x.webp") };
    run(&args).unwrap();
    let bytes = trochoid::io::read_bytes(&args.out, 1 << 20).unwrap();
    let frames: Vec<_> = webp_animation::Decoder::new(&bytes).unwrap().into_iter().collect();
    assert_eq!(frames.len(), 2);
    assert_eq!(frames[0].dimensions(), (3, 2));
    assert_eq!(frames.iter().map(webp_animation::Frame::timestamp).collect::<Vec<_>>(), [150, 300], "ends, in ms");
    let first = |frame: usize| frames[frame].data()[0];
    assert!(first(1) > first(0) + 100, "{} after {}", first(1), first(0));
}

#[test]
fn slow_drift_does_not_stand_still() {
    let folder = tempfile::tempdir().unwrap();
    let args = Args { scale: Some(1.0), ..args(folder.path(), "x.webp") };
    let drifting = GRAPH
        .replace(r#""width": 6, "height": 3"#, r#""width": 96, "height": 64"#)
        .replace(r#""last": 4"#, r#""last": 24"#)
        .replace(r##"[1, "#000000"], [4, "#ff0000"]"##, r##"[1, "#405060"], [24, "#506070"]"##);
    std::fs::write(&args.graph, &drifting).unwrap();
    run(&args).unwrap();
    let bytes = trochoid::io::read_bytes(&args.out, 1 << 20).unwrap();
    let last = webp_animation::Decoder::new(&bytes).unwrap().into_iter().last().unwrap();
    let still = trochoid::parse("graph.json", &drifting, Path::new("."), &[]).unwrap();
    let still = show(&still.graph, 0, 24, &mut Cache::new(), &Progress::new(1, true)).unwrap().within(None);
    let expected = |pixel: usize| (still[2][pixel] * 255.0).round() as i32;
    // The left part of a row, whose colors come from the drift alone.
    let apart = (0..24).map(|x| (i32::from(last.data()[4 * (96 * 32 + x) + 2]) - expected(96 * 32 + x)).abs());
    let furthest = apart.max().unwrap();
    assert!(furthest < 6, "{furthest} levels from the still");
}

#[test]
fn nothing_that_the_document_reads_is_written_over() {
    let folder = tempfile::tempdir().unwrap();
    let args = Args { frames: Some("1".into()), ..args(folder.path(), "x.png") };
    run(&args).unwrap();
    let before = trochoid::io::read_bytes(&args.out, 1 << 20).unwrap();
    let reads = r##"{ "trochoid": 1, "format": { "width": 3, "height": 2 }, "working_space": "srgb",
        "nodes": { "picture": { "type": "Read", "as": "color", "file": "x.png" } }, "outputs": { "beauty": { "color": "picture" } } }"##;
    std::fs::write(&args.graph, reads).unwrap();
    let failure = run(&args).unwrap_err();
    assert!(failure.messages[0].text().contains("is an input of the document"), "{:?}", failure.messages);
    assert_eq!(trochoid::io::read_bytes(&args.out, 1 << 20).unwrap(), before);
}

#[test]
fn one_frame_is_a_still_of_its_own_size() {
    let folder = tempfile::tempdir().unwrap();
    let args = Args { frames: Some("4".into()), shrink: Some(3), ..args(folder.path(), "x.png") };
    run(&args).unwrap();
    let (size, samples) = rgb(&args.out);
    assert_eq!(size, [2, 1]);
    // Two pixels: ScreenX is 0 at the first one and 1 at the last one, at any size.
    assert_eq!(samples, [1.0, 0.0, 0.0, 1.0, 1.0, 1.0]);
    let failure = run(&Args { frames: None, ..args }).unwrap_err();
    assert!(failure.messages[0].text().contains("4 frames"), "{:?}", failure.messages);
}

#[test]
fn a_sequence_has_a_file_for_each_frame() {
    let folder = tempfile::tempdir().unwrap();
    let args = Args { frames: Some("2-4x2".into()), ..args(folder.path(), "small/x.####.png") };
    run(&args).unwrap();
    let names = std::fs::read_dir(folder.path().join("small")).unwrap().map(|entry| entry.unwrap().file_name());
    let mut names: Vec<_> = names.collect();
    names.sort();
    assert_eq!(names, ["x.0002.png", "x.0004.png"]);
    assert_eq!(rgb(&folder.path().join("small/x.0004.png")).0, [3, 2]);
}

#[test]
fn values_of_a_field_are_shown_from_black_to_white() {
    let folder = tempfile::tempdir().unwrap();
    let args = args(folder.path(), "x.png");
    let args = Args { output: Some("values".into()), frames: Some("1".into()), ..args };
    run(&args).unwrap();
    let (size, samples) = rgb(&args.out);
    assert_eq!((size, &samples[..3], &samples[6..9]), ([3, 2], &[0.0; 3][..], &[1.0; 3][..]));
    let loaded = trochoid::parse("graph.json", GRAPH, Path::new("."), &[]).unwrap();
    let field = show(&loaded.graph, 2, 1, &mut Cache::new(), &Progress::new(1, true)).unwrap();
    assert_eq!(field.range(), Some([3.0, 5.0]));
    assert_eq!(bytes(&field.within(Some([3.0, 5.0])))[3..6], [51; 3]);
    assert_eq!(bytes(&field.within(Some([4.0, 4.0])))[..3], [128; 3], "nothing to tell apart");
}

#[test]
fn what_is_wrong_is_told_at_once_and_nothing_is_written() {
    let folder = tempfile::tempdir().unwrap();
    let args = Args { frames: Some("x".into()), output: Some("beuty".into()), ..args(folder.path(), "x.gif") };
    let failure = run(&args).unwrap_err();
    assert_eq!((failure.code, failure.messages.len()), (crate::failure::INVALID, 3), "{:?}", failure.messages);
    assert!(!args.out.exists());
}

#[test]
fn frames_last_until_the_next() {
    assert_eq!(times(&[1, 3, 4], 10.0), [0, 200, 300, 400]);
    assert_eq!(times(&[7], 24.0), [0, 42]);
}
