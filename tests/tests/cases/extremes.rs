//! Ends of ranges and hostile data: the graphs of `tests/extremes`, each with its expectation beside it. A graph is
//! refused by `check`, warned of, refused when its data are read, or evaluated: within the hull, without NaN, as the
//! f64 reference says, and to the same bits with every switch off. `NAME.said.txt` has all messages, word by word.
//!
//! `NAME.expect.json` says `why` the case is there, and:
//! - `check`: "valid", "warns", "refused", or "any" if warnings do not matter; `evaluate`: false
//!   if nothing else is checked;
//! - `files`: EXR files that it reads: `data` and `display` windows, and `channels` whose values may be "nan" or "inf";
//! - `fails`: whether evaluation must end with an error;
//! - `frame`, `tolerance` (of 1 or of the value, whichever is larger), and `unsure`: the share of pixels on
//!   silhouettes, where the f32 picture and the reference may see another surface; `expect`: values worked out by hand;
//! - `writes`: whether its outputs can be written.

use crate::support::{all_bits, root, sample, settings};
use crate::{stored, trial};
use libtest_mimic::Trial;
use serde_json::Value;
use std::collections::BTreeSet;
use std::path::{Path, PathBuf};
use trochoid::io::{ExrChannel, ExrImage, Samples};
use trochoid::{
    Buffers, Cache, CheckedGraph, Diagnostic, Frame, Kind, Loaded, Plan, Plane, ReferenceFrame, Silent, Switches,
    Window, output_files, parse, write_output,
};

/// Maximum number of an output's pixels that are compared with the reference.
const PIXELS: i64 = 600;

fn number(value: &Value) -> f64 {
    match value.as_str() {
        Some("inf") => f64::INFINITY,
        Some("-inf") => f64::NEG_INFINITY,
        Some("nan") => f64::NAN,
        _ => value.as_f64().unwrap(),
    }
}

fn window(value: &Value) -> Window {
    let [x0, y0, x1, y1] = [0, 1, 2, 3].map(|index| value[index].as_i64().unwrap());
    Window::new(x0, y0, x1, y1)
}

fn write_file(path: &Path, file: &Value) {
    let data = window(&file["data"]);
    let channels = file["channels"].as_object().unwrap();
    let planes: Vec<(&String, Plane)> = channels
        .iter()
        .map(|(name, values)| {
            let values = values.as_array().unwrap().iter().map(|value| number(value) as f32).collect();
            (name, Plane::new(data, values).unwrap())
        })
        .collect();
    let display = if file["display"].is_array() { window(&file["display"]) } else { data };
    let channels = planes.iter().map(|(name, plane)| ExrChannel::float(name.as_str(), Samples::plane(plane))).collect();
    let image = ExrImage { display, channels, ..ExrImage::new(data) };
    trochoid::io::write_exr(path, &image).unwrap();
    if file["empty"] == true {
        // No writer stores a window without pixels, but a header may say so.
        let mut bytes = std::fs::read(path).unwrap();
        let name = b"dataWindow\0box2i\0";
        let at = bytes.windows(name.len()).position(|bytes| bytes == name).unwrap() + name.len() + 4;
        bytes[at + 8..at + 12].copy_from_slice(&(data.x0 as i32 - 1).to_le_bytes());
        std::fs::write(path, bytes).unwrap();
    }
}

/// Returns the graph, or `None` if it was refused as expected; adds its messages to `said`.
fn checked(
    text: &str,
    folder: &Path,
    expected: &Value,
    said: &mut Vec<String>,
) -> Result<Option<CheckedGraph>, String> {
    let check = expected["check"].as_str().unwrap();
    let list = |all: &[Diagnostic]| all.iter().map(ToString::to_string).collect::<Vec<_>>().join("\n");
    match (parse("extreme.json", text, folder, &[]), check) {
        (Ok(Loaded { warnings, graph }), "valid") if warnings.is_empty() => Ok(Some(graph)),
        (Ok(Loaded { warnings, .. }), "valid") => Err(format!("is warned of: {}", list(&warnings))),
        (Ok(Loaded { warnings, graph }), "warns") if !warnings.is_empty() => {
            said.push(list(&warnings));
            Ok(Some(graph))
        }
        (Ok(Loaded { graph, .. }), "any") => Ok(Some(graph)),
        (Err(error), "refused") => {
            said.push(error.to_string());
            Ok(None)
        }
        (Ok(_), _) => Err(format!("is valid; expected the check \"{check}\"")),
        (Err(error), _) => Err(format!("is refused: {error}")),
    }
}

fn evaluated(graph: &CheckedGraph, number: i64, switches: Option<Switches>) -> Result<Frame, String> {
    let settings = settings(|settings| settings.switches = switches.unwrap_or(settings.switches));
    let plan = Plan::new(graph, &[], number, &[], &settings).map_err(|error| error.to_string())?;
    plan.evaluate(&Buffers::new(), &mut Cache::new(), &Silent).map_err(|error| error.to_string())
}

/// Returns the faults of a frame's pictures that need no reference.
fn legal(graph: &CheckedGraph, frame: &Frame) -> Result<(), String> {
    for picture in &frame.pictures {
        let name = &graph.outputs()[picture.output].name;
        if picture.audit.nan_count + picture.audit.hull_exits > 0 {
            return Err(format!("{name}: {} NaN, {} outside", picture.audit.nan_count, picture.audit.hull_exits));
        }
        let legal = |value: &f32| match picture.kind {
            Kind::Weights(_) => (0.0..=1.0).contains(value),
            Kind::Color => *value >= 0.0 && value.is_finite(),
            _ => !value.is_nan(),
        };
        if let Some(value) = picture.planes.iter().flat_map(|plane| plane.samples()).find(|value| !legal(value)) {
            return Err(format!("{name}: holds {value}"));
        }
    }
    Ok(())
}

/// Compares every output with the reference.
fn agrees(graph: &CheckedGraph, frame: &Frame, at: i64, expected: &Value) -> Result<(), String> {
    let tolerance = expected["tolerance"].as_f64().unwrap();
    let unsure = expected["unsure"].as_f64().unwrap_or(0.0);
    let (width, height) = (i64::from(graph.format().width()), i64::from(graph.format().height()));
    let stride = (width * height / PIXELS).max(1);
    // An odd stride shares no factor with a width that is a power of two, and so meets every column.
    let stride = if stride > 1 { stride | 1 } else { stride };
    for picture in &frame.pictures {
        let name = &graph.outputs()[picture.output].name;
        let reference = ReferenceFrame::new(graph, name, at).map_err(|error| format!("{name}: {error}"))?;
        let (mut off, mut seen, mut worst) = (0, 0, String::new());
        let mut most = 0.0;
        for pixel in (0..width * height).step_by(stride as usize) {
            let (x, y) = (pixel % width, pixel / width);
            let truth = reference.pixel(x, y).map_err(|error| format!("{name}: {error}"))?;
            seen += 1;
            let distance = |(channel, truth): (usize, &f64)| {
                let found = f64::from(sample(picture, channel, x, y));
                let scale = if truth.is_finite() { truth.abs().max(1.0) } else { 1.0 };
                let far = if found == *truth { 0.0 } else { (found - truth).abs() / scale };
                (far, found, *truth)
            };
            let farther = |a: (f64, f64, f64), b: (f64, f64, f64)| if b.0 > a.0 || b.0.is_nan() { b } else { a };
            let far = truth.iter().enumerate().map(distance).fold((0.0, 0.0, 0.0), farther);
            if far.0.is_nan() || far.0 > tolerance {
                off += 1;
                if far.0 > most || worst.is_empty() {
                    most = far.0;
                    worst = format!("({x}, {y}): found {:e}, the reference says {:e}", far.1, far.2);
                }
            }
        }
        if f64::from(off) > unsure * f64::from(seen) {
            return Err(format!("{name}: {off} of {seen} pixels are off; {worst}"));
        }
    }
    Ok(())
}

/// Compares values with those worked out by hand.
fn meets(graph: &CheckedGraph, frame: &Frame, rows: &Value) -> Result<(), String> {
    for row in rows.as_array().map_or(&[][..], Vec::as_slice) {
        let (x, y) = (row["pixel"][0].as_i64().unwrap(), row["pixel"][1].as_i64().unwrap());
        let picture = frame.pictures.iter().find(|p| graph.outputs()[p.output].name == row["output"].as_str().unwrap());
        let found = f64::from(sample(picture.unwrap(), row["channel"].as_u64().unwrap() as usize, x, y));
        let value = number(&row["value"]);
        let off = if found == value { 0.0 } else { (found - value).abs() };
        if off.is_nan() || off > row["tolerance"].as_f64().unwrap() {
            return Err(format!("{row}: found {found:e}"));
        }
    }
    Ok(())
}

fn written(
    graph: &CheckedGraph,
    frame: &Frame,
    at: i64,
    expected: &Value,
    said: &mut Vec<String>,
) -> Result<(), String> {
    let Some(writes) = expected["writes"].as_bool() else { return Ok(()) };
    let all: Vec<usize> = (0..graph.outputs().len()).collect();
    let files = output_files(graph, &all, at, false, None).map_err(|error| error.to_string())?;
    for file in files {
        match (write_output(graph, frame, &file, &[]), writes) {
            (Ok(()), true) => (),
            (Ok(()), false) => return Err(format!("{} was written", file.path.display())),
            (Err(error), true) => return Err(format!("cannot be written: {error}")),
            (Err(error), false) => {
                said.push(error.to_string());
                if file.path.exists() {
                    return Err("an incomplete file is left behind".into());
                }
            }
        }
    }
    Ok(())
}

/// Judges a document, and adds the messages about it to `said`.
fn judge(text: &str, folder: &Path, expected: &Value, said: &mut Vec<String>) -> Result<(), String> {
    let Some(graph) = checked(text, folder, expected, said)? else { return Ok(()) };
    if expected["evaluate"] == false {
        return Ok(());
    }
    let at = expected["frame"].as_i64().unwrap_or(graph.frames().0);
    let frame = match (evaluated(&graph, at, None), expected["fails"] == true) {
        (Err(error), true) => {
            said.push(error);
            return Ok(());
        }
        (Ok(_), true) => return Err("was evaluated; expected an error".into()),
        (Err(error), false) => return Err(format!("cannot be evaluated: {error}")),
        (Ok(frame), false) => frame,
    };
    legal(&graph, &frame)?;
    let plain = evaluated(&graph, at, Some(Switches::NONE)).map_err(|error| format!("all switches off: {error}"))?;
    if all_bits(&frame) != all_bits(&plain) {
        return Err("the bits differ with all switches off".into());
    }
    agrees(&graph, &frame, at, expected)?;
    meets(&graph, &frame, &expected["expect"])?;
    written(&graph, &frame, at, expected, said)
}

fn cases() -> PathBuf {
    root().join("tests/extremes")
}

fn holds(name: &str) -> Result<(), String> {
    let read = |ending: &str| {
        let text = std::fs::read_to_string(cases().join(format!("{name}{ending}")));
        text.map_err(|error| format!("tests/extremes/{name}{ending}: {error}"))
    };
    let expected: Value = serde_json::from_str(&read(".expect.json")?).map_err(|error| error.to_string())?;
    if expected["why"].as_str().is_none_or(str::is_empty) {
        return Err(format!("tests/extremes/{name}.expect.json does not say \"why\" the case is there"));
    }
    let folder = tempfile::tempdir().unwrap();
    for (name, file) in expected["files"].as_object().into_iter().flatten() {
        write_file(&folder.path().join(name), file);
    }
    let mut said = Vec::new();
    judge(&read(".json")?, folder.path(), &expected, &mut said)?;
    stored::holds_said(&cases().join(format!("{name}.said.txt")), &said.join("\n"), folder.path())
}

pub(crate) fn trials() -> Vec<Trial> {
    let mut names = BTreeSet::new();
    for entry in std::fs::read_dir(cases()).unwrap() {
        let name = entry.unwrap().file_name().into_string().unwrap();
        names.insert(name.split('.').next().unwrap().to_string());
    }
    names.into_iter().map(|name| trial("extremes", &name.clone(), move || holds(&name))).collect()
}
