//! Golden cases: for every node type a small document and values worked out from its formula by hand.
//!
//! `nodes/Type.json` is the document, `nodes/Type.expect.json` what its pixels must be. One body runs every case: the
//! fast path against the expectation, against the f64 reference, and against itself under all settings.

use crate::support::{evaluate, folder, graph_in, root, sample, settings, under_all_settings};
use serde_json::Value;
use std::path::{Path, PathBuf};
use trochoid::{Buffers, Cache, Certifier, CheckedGraph, Format, Picture, ReferenceFrame, Shading, Silent, registry};

fn cases() -> PathBuf {
    root().join("tests/nodes")
}

fn json(path: &Path) -> Value {
    let text = std::fs::read_to_string(path).unwrap_or_else(|error| panic!("{}: {error}", path.display()));
    serde_json::from_str(&text).unwrap_or_else(|error| panic!("{}: {error}", path.display()))
}

fn picture<'f>(graph: &CheckedGraph, frame: &'f trochoid::Frame, output: &str) -> &'f Picture {
    frame.pictures.iter().find(|picture| graph.outputs()[picture.output].name == output).unwrap()
}

/// Distance of a value from what is expected; equal infinities are no distance apart.
fn distance(found: f64, expected: f64) -> f64 {
    if found == expected { 0.0 } else { (found - expected).abs() }
}

fn meets_expectation(ty: &str, graph: &CheckedGraph, expected: &Value) {
    let number = expected["frame"].as_i64().unwrap_or(graph.frames().0);
    let frame = evaluate(graph, number, &Buffers::new(), &settings(|_| ()));
    let rows = expected["expect"].as_array().unwrap();
    assert!(!rows.is_empty(), "{ty} expects nothing");
    for output in graph.outputs() {
        assert!(rows.iter().any(|row| row["output"] == output.name.as_str()), "{ty}: {} is not expected", output.name);
    }
    for row in rows {
        let (x, y) = (row["pixel"][0].as_i64().unwrap(), row["pixel"][1].as_i64().unwrap());
        let (channel, tolerance) = (row["channel"].as_u64().unwrap() as usize, row["tolerance"].as_f64().unwrap());
        let value = row["value"].as_f64().unwrap_or(f64::INFINITY);
        let found = f64::from(sample(picture(graph, &frame, row["output"].as_str().unwrap()), channel, x, y));
        assert!(distance(found, value) <= tolerance, "{ty}: found {found}, expected {row}");
    }
}

/// Fast path against the f64 reference, and against itself under all settings.
fn holds_itself(ty: &str, graph: &CheckedGraph, expected: &Value) {
    let number = expected["frame"].as_i64().unwrap_or(graph.frames().0);
    let what = format!("{ty}, {} samples, shaded by the {}", graph.format().samples(), graph.format().shading().name());
    let frame = under_all_settings(graph, number, &Buffers::new(), &what);
    let tolerance = expected["reference_tolerance"].as_f64().unwrap();
    let certifier = Certifier::new(graph, &[], number, &[], &settings(|_| ())).unwrap();
    let certified = certifier.certify(&Buffers::new(), &mut Cache::new(), &Silent).unwrap();
    for (picture, certified) in frame.pictures.iter().zip(&certified) {
        let output = &graph.outputs()[picture.output].name;
        let reference = ReferenceFrame::new(graph, output, number).unwrap();
        let window = picture.planes[0].window();
        assert_eq!(picture.audit.hull_exits + picture.audit.nan_count, 0, "{what}: {output}");
        // One line of pixels through the picture reaches every row and every column.
        for at in 0..window.width().max(window.height()) as i64 {
            let (x, y) = (at % window.width() as i64, at % window.height() as i64);
            let truth = reference.pixel(x, y).unwrap();
            assert_eq!(truth.len(), picture.planes.len(), "{what}: {output}");
            for (channel, truth) in truth.iter().enumerate() {
                let found = f64::from(sample(picture, channel, x, y));
                let error = distance(found, *truth);
                let bound = f64::from(certified.errors[channel][y as usize * window.width() + x as usize]);
                assert!(
                    error <= bound,
                    "{what}: {output}, channel {channel} of ({x}, {y}): {error:e} from the reference, certified {bound:e}"
                );
                let scale = if truth.is_finite() { truth.abs().max(1.0) } else { 1.0 };
                assert!(
                    distance(found, *truth) <= tolerance * scale,
                    "{what}: {output}, channel {channel} of ({x}, {y}): found {found}, the reference says {truth}"
                );
            }
        }
    }
}

#[test]
fn every_type_has_a_case_that_holds() {
    let folder = folder();
    let mut faults = Vec::new();
    for ty in registry().iter() {
        let name = ty.declaration().name;
        let path = cases().join(format!("{name}.json"));
        if !path.exists() {
            faults.push(format!("{name} has no case: add {}", path.display()));
            continue;
        }
        let text = std::fs::read_to_string(&path).unwrap();
        assert!(text.contains(&format!("\"type\": \"{name}\"")), "the case of {name} has no {name}");
        let graph = graph_in(folder.path(), &text);
        let expected = json(&cases().join(format!("{name}.expect.json")));
        let run = std::panic::AssertUnwindSafe(|| {
            meets_expectation(name, &graph, &expected);
            for (samples, shading) in [(1, Shading::Sample), (4, Shading::Sample), (4, Shading::Pixel)] {
                let format = Format::new(graph.format().width(), graph.format().height(), samples).unwrap();
                let format = format.with_shading(shading);
                holds_itself(name, &graph.clone().with_format(format), &expected);
            }
        });
        // Every type is run before the test fails, so that one run tells all.
        if let Err(panic) = std::panic::catch_unwind(run) {
            let text = panic.downcast_ref::<String>().cloned();
            faults.push(text.unwrap_or_else(|| format!("{name} panicked")));
        }
    }
    assert!(faults.is_empty(), "{}", faults.join("\n"));
}

#[test]
fn every_case_belongs_to_a_type() {
    for entry in std::fs::read_dir(cases()).unwrap() {
        let name = entry.unwrap().file_name().into_string().unwrap();
        let ty = name.split('.').next().unwrap();
        assert!(registry().iter().any(|known| known.declaration().name == ty), "{name} is no type's case");
    }
}

/// Types whose stages bound their errors: their cases are in no doubt anywhere.
#[test]
fn what_bounds_its_errors_is_in_no_doubt() {
    for ty in ["ScreenX", "ScreenY", "Mix", "Ramp", "Blend", "Stack", "Normalize"] {
        let text = std::fs::read_to_string(cases().join(format!("{ty}.json"))).unwrap();
        let graph = graph_in(&cases(), &text);
        let certifier = Certifier::new(&graph, &[], graph.frames().0, &[], &settings(|_| ())).unwrap();
        for output in certifier.certify(&Buffers::new(), &mut Cache::new(), &Silent).unwrap() {
            assert_eq!(output.unclear.total(), 0, "{ty}");
            assert!(output.clear.max() < 1e-4 && output.clear.total() > 0, "{ty}: {}", output.clear.max());
        }
    }
}
