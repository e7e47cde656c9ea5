//! Shared test code: loading, evaluating, comparing bits, and the settings that must not change a bit.

mod certified;
mod files;
pub(crate) mod large;

pub(crate) use certified::pixels_are_as_the_whole;
pub(crate) use files::{folder, write_exr};

use std::path::{Path, PathBuf};
use std::process::Command;
use trochoid::{
    Buffers, Cache, CheckedGraph, Frame, Instructions, Judging, Keep, Picture, Plan, Plane, ReferenceFrame, Settings,
    Silent, State, Switches, Window, parse,
};

/// Returns the workspace's root, and makes it the current folder, so that scenes may read beneath it.
pub(crate) fn root() -> PathBuf {
    let root = Path::new(env!("CARGO_MANIFEST_DIR")).parent().unwrap();
    std::env::set_current_dir(root).unwrap();
    root.into()
}

/// Environment variable of a process in which a single test runs.
const ALONE: &str = "TROCHOID_TEST_ALONE";

/// Returns whether a test runs in a process of its own, where no other test takes memory. Elsewhere, runs it in such a
/// process, and panics if it fails there.
#[track_caller]
pub(crate) fn is_alone(test: &str) -> bool {
    if std::env::var_os(ALONE).is_some() {
        return true;
    }
    let mut command = Command::new(std::env::current_exe().unwrap());
    let output = command.args(["--exact", test, "--nocapture"]).env(ALONE, "1").output().unwrap();
    let told = String::from_utf8_lossy(&[output.stdout, output.stderr].concat()).into_owned();
    assert!(output.status.success() && told.contains("1 passed"), "{test}, alone: {told}");
    false
}

/// Returns the graph of a document's text; paths are relative to `folder`.
pub(crate) fn graph_in(folder: &Path, text: &str) -> CheckedGraph {
    match parse("test.json", text, folder, &[]) {
        Ok(loaded) => loaded.graph,
        Err(error) => panic!("{error}\n{text}"),
    }
}

/// Returns the graph of these nodes and outputs at a format.
pub(crate) fn graph(format: &str, nodes: &str, outputs: &str) -> CheckedGraph {
    let text = format!(
        r#"{{ "trochoid": 1, "format": {{ {format} }}, "frames": {{ "first": 1, "last": 100 }},
            "nodes": {{ {nodes} }}, "outputs": {{ {outputs} }} }}"#
    );
    graph_in(Path::new("."), &text)
}

/// Evaluates all outputs at a frame.
pub(crate) fn evaluate(graph: &CheckedGraph, frame: i64, buffers: &Buffers<'_>, settings: &Settings) -> Frame {
    evaluate_some(graph, &[], frame, buffers, settings)
}

/// Evaluates all outputs at a frame with a cache of earlier evaluations.
pub(crate) fn evaluate_again(
    graph: &CheckedGraph,
    frame: i64,
    buffers: &Buffers<'_>,
    settings: &Settings,
    cache: &mut Cache,
) -> Frame {
    let plan = Plan::new(graph, &[], frame, &buffers.names(), settings).unwrap();
    plan.evaluate(buffers, cache, &Silent).unwrap()
}

/// Evaluates some outputs at a frame.
pub(crate) fn evaluate_some(
    graph: &CheckedGraph,
    outputs: &[&str],
    frame: i64,
    buffers: &Buffers<'_>,
    settings: &Settings,
) -> Frame {
    let plan = Plan::new(graph, outputs, frame, &buffers.names(), settings).unwrap();
    plan.evaluate(buffers, &mut Cache::new(), &Silent).unwrap()
}

/// Returns the bits of a picture, channel by channel.
pub(crate) fn bits(picture: &Picture) -> Vec<Vec<u32>> {
    picture.planes.iter().map(|plane| plane.samples().iter().map(|v| v.to_bits()).collect()).collect()
}

/// Returns the bits of all pictures of a frame.
pub(crate) fn all_bits(frame: &Frame) -> Vec<Vec<Vec<u32>>> {
    frame.pictures.iter().map(bits).collect()
}

/// Returns default settings with one thread and a change.
pub(crate) fn settings(change: impl FnOnce(&mut Settings)) -> Settings {
    let mut settings = Settings::default();
    settings.threads = 1;
    change(&mut settings);
    settings
}

/// Settings that must not change a bit: every switch alone on and alone off, all off, tile sizes, threads, instruction
/// sets, machine code, and planes that are kept for the next evaluation.
pub(crate) fn variants() -> Vec<(String, Settings)> {
    let mut variants = vec![
        ("all switches off".into(), settings(|s| s.switches = Switches::NONE)),
        ("tiles of 1 × 1".into(), settings(|s| s.tile = Some((1, 1)))),
        ("tiles of 3 × 2".into(), settings(|s| s.tile = Some((3, 2)))),
        ("one tile".into(), settings(|s| s.tile = Some((1 << 20, 1 << 20)))),
        ("AVX2 at most".into(), settings(|s| s.instructions = Instructions::Avx2)),
        ("the baseline".into(), settings(|s| s.instructions = Instructions::Baseline)),
        ("judged by samples".into(), settings(|s| s.judge = Judging::Sampled)),
        ("2 threads".into(), settings(|s| (s.threads, s.tile) = (2, Some((2, 1))))),
        ("3 threads".into(), settings(|s| (s.threads, s.tile) = (3, Some((3, 1))))),
        ("machine code".into(), settings(|s| s.compile_from = 0)),
        ("machine code, AVX2".into(), settings(|s| (s.compile_from, s.instructions) = (0, Instructions::Avx2))),
        ("machine code, sampled".into(), settings(|s| (s.compile_from, s.judge) = (0, Judging::Sampled))),
        (
            "machine code, 2 threads, tiles of 37 × 3".into(),
            settings(|s| (s.compile_from, s.threads, s.tile) = (0, 2, Some((37, 3)))),
        ),
        (
            "what stages fill is kept".into(),
            settings(|s| (s.keep, s.threads, s.tile) = (Keep::ForEdits, 2, Some((3, 2)))),
        ),
        ("what stages filled is used".into(), settings(|s| (s.keep, s.tile) = (Keep::ForFrames, Some((5, 1))))),
        ("off, tiles of 3 × 2".into(), settings(|s| (s.switches, s.tile) = (Switches::NONE, Some((3, 2))))),
    ];
    type Field = fn(&mut Switches) -> &mut bool;
    let switches: [(&str, Field); 9] = [
        ("demand", |s| &mut s.demand),
        ("prune", |s| &mut s.prune),
        ("fold", |s| &mut s.fold),
        ("merge", |s| &mut s.merge),
        ("hoist", |s| &mut s.hoist),
        ("fuse", |s| &mut s.fuse),
        ("compile", |s| &mut s.compile),
        ("hold", |s| &mut s.hold),
        ("sparse", |s| &mut s.sparse),
    ];
    for (name, field) in switches {
        variants.push((format!("{name} off"), settings(|s| *field(&mut s.switches) = false)));
        let alone = settings(|s| {
            (s.switches, s.compile_from) = (Switches::NONE, 0);
            *field(&mut s.switches) = true;
        });
        variants.push((format!("only {name} on"), alone));
    }
    variants
}

/// Evaluates under every variant, compares all bits with those of the default settings, and returns their frame.
pub(crate) fn under_all_settings(graph: &CheckedGraph, frame: i64, buffers: &Buffers<'_>, what: &str) -> Frame {
    let expected = evaluate(graph, frame, buffers, &settings(|_| ()));
    assert_eq!(expected.pictures.len(), graph.outputs().len(), "{what}: pictures");
    let mut kept = Cache::new();
    for (name, settings) in variants() {
        let found = if settings.keep != Keep::Nothing {
            evaluate_again(graph, frame, buffers, &settings, &mut kept)
        } else {
            evaluate(graph, frame, buffers, &settings)
        };
        assert_eq!(found.pictures.len(), expected.pictures.len(), "{what}: {name}: pictures");
        for (a, b) in expected.pictures.iter().zip(&found.pictures) {
            let output = &graph.outputs()[a.output].name;
            let shape = |picture: &Picture| {
                let windows: Vec<Window> = picture.planes.iter().map(Plane::window).collect();
                (picture.output, windows)
            };
            assert_eq!(shape(b), shape(a), "{what}: {name}: planes of output {output}");
            for (channel, (a, b)) in a.planes.iter().zip(&b.planes).enumerate() {
                let pairs = a.samples().iter().zip(b.samples());
                if let Some(at) = pairs.clone().position(|(a, b)| a.to_bits() != b.to_bits()) {
                    let (a, b) = (a.samples()[at], b.samples()[at]);
                    panic!("{what}: {name}: output {output}, channel {channel}, pixel {at}: {b:e} instead of {a:e}");
                }
            }
            assert_eq!(a.audit.hull_exits, b.audit.hull_exits, "{what}: {name}: exits of {output}");
        }
    }
    expected
}

/// Evaluates these nodes and outputs on passes, written to `a.exr`, under all settings, and hands every output's name,
/// values found and true values, row by row, to `judge`.
pub(crate) fn on_passes(
    [width, height]: [u32; 2],
    passes: &[(&str, Vec<f32>)],
    nodes: &str,
    outputs: &[String],
    mut judge: impl FnMut(&str, &[[f64; 2]]),
) {
    let folder = tempfile::tempdir().unwrap();
    let channels: Vec<(&str, &[f32])> = passes.iter().map(|(name, plane)| (*name, &plane[..])).collect();
    write_exr(&folder.path().join("a.exr"), width, height, &channels);
    let text = format!(
        r#"{{ "trochoid": 1, "format": {{ "width": {width}, "height": {height} }}, "nodes": {{ {nodes} }},
            "outputs": {{ {} }} }}"#,
        outputs.join(", ")
    );
    let graph = graph_in(folder.path(), &text);
    let frame = under_all_settings(&graph, 1, &Buffers::new(), "passes");
    for picture in &frame.pictures {
        let output = &graph.outputs()[picture.output].name;
        let reference = ReferenceFrame::new(&graph, output, 1).unwrap();
        let pixels = (0..i64::from(height)).flat_map(|y| (0..i64::from(width)).map(move |x| (x, y)));
        let pairs: Vec<[f64; 2]> =
            pixels.map(|(x, y)| [f64::from(sample(picture, 0, x, y)), reference.pixel(x, y).unwrap()[0]]).collect();
        judge(output, &pairs);
    }
}

/// Returns a sample of a picture.
pub(crate) fn sample(picture: &Picture, channel: usize, x: i64, y: i64) -> f32 {
    picture.planes[channel].row(y).unwrap()[(x - picture.planes[channel].window().x0) as usize]
}

/// Returns the state of a node.
pub(crate) fn state<'f>(frame: &'f Frame, node: &str) -> &'f State {
    &frame.nodes.iter().find(|report| report.name == node).unwrap().state
}
