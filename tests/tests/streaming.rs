//! Files are read on demand, a few rows at a time: no bit depends on how many are asked for at once, and a picture that
//! changes on disk is read anew.

use crate::support::{all_bits, evaluate, graph_in, settings, state, write_exr};
use std::path::Path;
use std::sync::Mutex;
use trochoid::{Buffers, Cache, CheckedGraph, EvalError, NodeError, Plan, Silent, Sink, State, Window};

const SIZE: (u32, u32) = (37, 83);

/// Writes the file `a.exr`: weights that sum to 1, and a picture.
fn write(folder: &Path, bad: Option<usize>) {
    let area = (SIZE.0 * SIZE.1) as usize;
    let plane = |step: usize| -> Vec<f32> { (0..area).map(|i| ((i * step) % 101) as f32 / 256.0).collect() };
    let (u, v, r) = (plane(7), plane(13), plane(29));
    let mut rest: Vec<f32> = u.iter().zip(&v).map(|(u, v)| 1.0 - u - v).collect();
    if let Some(at) = bad {
        rest[at] = f32::NAN;
    }
    let depth: Vec<f32> = (0..area).map(|i| i as f32).collect();
    let channels: [(&str, &[f32]); 7] =
        [("u", &u), ("v", &v), ("rest", &rest), ("R", &r), ("G", &u), ("B", &v), ("depth.Z", &depth)];
    write_exr(&folder.join("a.exr"), SIZE.0, SIZE.1, &channels);
}

/// Several readers of one file, one of them blurred.
fn graph(folder: &Path, size: (u32, u32), samples: u32, fit: &str) -> CheckedGraph {
    let (width, height) = size;
    graph_in(
        folder,
        &format!(
            r#"{{ "trochoid": 1, "format": {{ "width": {width}, "height": {height}, "samples": {samples} }}, "nodes": {{
            "image": {{ "type": "Read", "file": "a.exr", "as": "color", "fit": "{fit}" }},
            "shares": {{ "type": "Read", "file": "a.exr", "as": "weights", "channels": ["u", "v", "rest"], "fit": "{fit}" }},
            "one": {{ "type": "Read", "file": "a.exr", "as": "weights", "channels": ["v"], "fit": "{fit}" }},
            "depth": {{ "type": "Read", "file": "a.exr", "as": "field", "layer": "depth", "fit": "{fit}" }},
            "soft": {{ "type": "Blur", "image": "one", "size": 5 }},
            "base": {{ "type": "Blend", "colors": ["image", [0.1, 0.2, 0.3], [1, 0, 0]], "weights": "shares" }},
            "out": {{ "type": "Mix", "a": "base", "b": "image", "weight": "soft" }} }},
            "outputs": {{ "out": {{ "color": "out" }}, "shares": {{ "weights": "shares" }}, "depth": {{ "field": "depth" }} }} }}"#
        ),
    )
}

#[test]
fn no_bit_depends_on_tiles_threads_or_regions() {
    let folder = tempfile::tempdir().unwrap();
    write(folder.path(), None);
    for (size, samples, fit) in [(SIZE, 1, "crop"), (SIZE, 4, "crop"), ((50, 60), 1, "crop"), ((50, 60), 4, "bilinear")]
    {
        let graph = graph(folder.path(), size, samples, fit);
        let buffers = Buffers::new();
        let whole = evaluate(&graph, 1, &buffers, &settings(|s| s.tile = Some((1 << 20, 1 << 20))));
        for (tile, threads) in
            [(None, 2), (Some((1, 1)), 1), (Some((3, 2)), 3), (Some((64, 16)), 2), (Some((1 << 20, 5)), 4)]
        {
            let found = evaluate(&graph, 1, &buffers, &settings(|s| (s.tile, s.threads) = (tile, threads)));
            assert!(
                all_bits(&found) == all_bits(&whole),
                "tiles of {tile:?}, {threads} threads, {samples} samples, {fit}"
            );
        }
        let region = Window::new(5, 19, 30, 47);
        let part = evaluate(&graph, 1, &buffers, &settings(|s| s.region = Some(region)));
        for (part, whole) in part.pictures.iter().zip(&whole.pictures) {
            for (part, whole) in part.planes.iter().zip(&whole.planes) {
                for y in region.y0..region.y1 {
                    let row = &whole.row(y).unwrap()[region.x0 as usize..region.x1 as usize];
                    assert_eq!(part.row(y).unwrap(), row, "row {y}");
                }
            }
        }
    }
}

#[test]
fn bad_rows_are_refused_where_they_are_needed() {
    let folder = tempfile::tempdir().unwrap();
    write(folder.path(), Some(37 * 50 + 3));
    let graph = graph(folder.path(), SIZE, 1, "crop");
    let fault = |outputs: &[&str], region: Option<Window>| {
        let plan = Plan::new(&graph, outputs, 1, &[], &settings(|s| (s.region, s.threads) = (region, 3))).unwrap();
        match plan.evaluate(&Buffers::new(), &mut Cache::new(), &Silent) {
            Err(EvalError::Node { node, error: NodeError::Data(bad), .. }) => Some((node, *bad)),
            Err(error) => panic!("{error}"),
            Ok(_) => None,
        }
    };
    let (node, bad) = fault(&["shares"], None).unwrap();
    assert_eq!((&*node, &*bad.found), ("shares", "NaN"));
    assert_eq!((bad.place.channel.as_deref(), bad.place.pixel), (Some("rest"), Some((3, 50))));
    assert_eq!(fault(&["depth"], None), None, "the channel is not needed");
    assert_eq!(fault(&["shares"], Some(Window::new(0, 0, 37, 16))), None, "the row is not needed");
}

#[test]
fn a_file_that_changes_is_read_anew() {
    let folder = tempfile::tempdir().unwrap();
    let paint = |name: &str, level: f32| {
        let samples = vec![level; 6];
        write_exr(
            &folder.path().join(name),
            3,
            2,
            &[("R", &samples), ("G", &samples), ("B", &samples), ("m", &samples)],
        );
    };
    paint("a.0001.exr", 0.25);
    paint("a.0002.exr", 0.5);
    let text = r#"{ "trochoid": 1, "format": { "width": 3, "height": 2 }, "frames": { "first": 1, "last": 2 }, "nodes": {
        "image": { "type": "Read", "file": "a.####.exr", "as": "color" },
        "mask": { "type": "Read", "file": "a.####.exr", "as": "weights", "channels": ["m"] } },
        "outputs": { "image": { "color": "image" }, "mask": { "weights": "mask" } } }"#;
    let graph = graph_in(folder.path(), text);
    let mut cache = Cache::new();
    let settings = settings(|_| ());
    let mut plans = [1, 2].map(|frame| Plan::new(&graph, &[], frame, &[], &settings).unwrap());
    let mut level = |plan: &Plan<'_>, expected: f32, cached: bool| {
        let frame = plan.evaluate(&Buffers::new(), &mut cache, &Silent).unwrap();
        for name in ["image", "mask"] {
            assert_eq!(*state(&frame, name) == State::Cached, cached, "{name}");
        }
        for picture in &frame.pictures {
            assert!(picture.planes.iter().flat_map(|plane| plane.samples()).all(|v| *v == expected), "{expected}");
        }
    };
    // Frames 1, 2, 1: frame 1 is still in the cache.
    level(&plans[0], 0.25, false);
    level(&plans[1], 0.5, false);
    level(&plans[0], 0.25, true);
    // The same plan notices the new file by its modification time.
    paint("a.0001.exr", 0.75);
    let file = std::fs::File::options().write(true).open(folder.path().join("a.0001.exr")).unwrap();
    file.set_modified(std::time::SystemTime::now() + std::time::Duration::from_secs(60)).unwrap();
    level(&plans[0], 0.75, false);
    level(&plans[1], 0.5, true);
    plans[0] = Plan::new(&graph, &[], 1, &[], &settings).unwrap();
    level(&plans[0], 0.75, false);
}

#[test]
fn a_cache_obeys_its_limit() {
    let folder = tempfile::tempdir().unwrap();
    write(folder.path(), None);
    let (width, height) = SIZE;
    let text = format!(
        r#"{{ "trochoid": 1, "format": {{ "width": {width}, "height": {height} }}, "nodes": {{
        "a": {{ "type": "Read", "file": "a.exr", "as": "color" }},
        "b": {{ "type": "Read", "file": "a.exr", "as": "color", "channels": ["B", "G", "R"] }} }},
        "outputs": {{ "a": {{ "color": "a" }}, "b": {{ "color": "b" }} }} }}"#
    );
    let graph = graph_in(folder.path(), &text);
    let plan = Plan::new(&graph, &[], 1, &[], &settings(|_| ())).unwrap();
    let image = 3 * 4 * (width * height) as usize;
    for (limit, kept, runs) in [
        // The older of the two is dropped each time.
        (image * 3 / 2, image, [[false, false], [false, true], [true, false]]),
        (image * 2, image * 2, [[false, false], [true, true], [true, true]]),
        // One picture alone exceeds the limit.
        (image - 1, 0, [[false, false]; 3]),
    ] {
        let mut cache = Cache::with_limit(limit);
        for (run, expected) in runs.into_iter().enumerate() {
            let frame = plan.evaluate(&Buffers::new(), &mut cache, &Silent).unwrap();
            let cached = ["a", "b"].map(|name| *state(&frame, name) == State::Cached);
            assert_eq!(cached, expected, "run {run} with {limit} bytes");
            assert_eq!(cache.bytes(), kept, "run {run} with {limit} bytes");
        }
    }
}

/// Takes bands of sixteen rows, as compressed files do.
struct Collected(Mutex<Vec<Vec<f32>>>);

impl Sink for Collected {
    fn rows(&self) -> usize {
        16
    }

    fn take(&self, band: Window, rows: &[Vec<&[f32]>]) -> Result<(), EvalError> {
        let mut planes = self.0.lock().unwrap();
        let channels: Vec<&[f32]> = rows.iter().flatten().copied().collect();
        planes.resize(channels.len(), vec![f32::NAN; (SIZE.0 * SIZE.1) as usize]);
        for (plane, channel) in planes.iter_mut().zip(channels) {
            plane[band.y0 as usize * SIZE.0 as usize..][..channel.len()].copy_from_slice(channel);
        }
        Ok(())
    }
}

#[test]
fn bands_of_a_sink_hold_every_row_however_high_tiles_are() {
    let folder = tempfile::tempdir().unwrap();
    write(folder.path(), None);
    for size in [1, 5, 9, 30] {
        let text = format!(
            r#"{{ "trochoid": 1, "format": {{ "width": {}, "height": {} }}, "nodes": {{
            "image": {{ "type": "Read", "file": "a.exr", "as": "color" }},
            "across": {{ "type": "ScreenX" }}, "sure": {{ "type": "Clamp", "field": "across", "min": 0, "max": 1 }},
            "plain": {{ "type": "Mix", "a": "image", "b": [1, 1, 1], "weight": "sure" }},
            "out": {{ "type": "Blur", "image": "plain", "size": {size} }} }}, "outputs": {{ "out": {{ "color": "out" }} }} }}"#,
            SIZE.0, SIZE.1
        );
        let graph = graph_in(folder.path(), &text);
        let whole = evaluate(&graph, 1, &Buffers::new(), &settings(|s| s.tile = Some((1 << 20, 1 << 20))));
        for (threads, tile) in [(1, None), (2, None), (3, None), (5, None), (2, Some((7, 5))), (3, Some((64, 24)))] {
            let settings = settings(|s| (s.threads, s.tile) = (threads, tile));
            let plan = Plan::new(&graph, &[], 1, &[], &settings).unwrap();
            let sink = Collected(Mutex::default());
            plan.evaluate_to(&sink, &Buffers::new(), &mut Cache::new(), &Silent).unwrap();
            let found = sink.0.into_inner().unwrap();
            for (found, whole) in found.iter().zip(&whole.pictures[0].planes) {
                assert!(found == whole.samples(), "a blur of {size} pixels, {threads} threads, tiles of {tile:?}");
            }
        }
    }
}
