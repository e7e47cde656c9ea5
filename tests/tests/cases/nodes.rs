//! Golden cases, one for every node type. `nodes/Type.json` is a document of a few pixels; beside it lie
//! `Type.expect.json`, the pixels that are worked out by hand, each with its arithmetic, and `Type.sheet.txt`, all
//! pixels as the f64 references compute them.
//!
//! Every case compares the references with the sheet, to the last bit, and the fast path with both, and with itself
//! under all settings.

use crate::sheet::{self, Truth};
use crate::support::{evaluate, folder, graph_in, pixels_are_as_the_whole, root, sample, settings, under_all_settings};
use crate::{stored, trial};
use libtest_mimic::Trial;
use serde::Deserialize;
use std::collections::BTreeMap;
use std::path::PathBuf;
use trochoid::{
    Buffers, Cache, Certifier, CheckedGraph, Format, Frame, Picture, ReferenceFrame, Shading, Silent, registry,
};

/// Maximum number of pixels that are worked out by hand, because nobody would check more.
const BY_HAND: usize = 5;

/// Contents of `Type.expect.json`.
#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
struct Expected {
    /// Formula that the case computes.
    formula: String,
    /// Number of the frame; the document's first if omitted.
    frame: Option<i64>,
    /// Tolerance of the fast path against the reference, relative to 1 or to the value, whichever is larger, with any
    /// number of samples.
    reference_tolerance: f64,
    /// Tolerance of the fast path against the sheet, by output. Values of 0, 1 or infinity in the sheet must be exact.
    sheet_tolerance: BTreeMap<String, f64>,
    /// Outputs whose zeros and ones are rounded like their other values.
    #[serde(default)]
    inexact: Vec<String>,
    /// Pixels with a larger tolerance against the sheet.
    #[serde(default)]
    farther: Vec<Farther>,
    /// Whether every stage bounds its errors, and no pixel is ambiguous.
    #[serde(default)]
    no_doubt: bool,
    by_hand: Vec<ByHand>,
    /// Reason that nothing can be worked out by hand, if so.
    #[serde(default)]
    not_by_hand: String,
}

/// Pixel with a larger tolerance against the sheet than the others of its output.
#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
struct Farther {
    output: String,
    pixel: [i64; 2],
    tolerance: f64,
    why: String,
}

/// Pixel that is worked out by hand.
#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
struct ByHand {
    output: String,
    pixel: [i64; 2],
    value: Channels,
    tolerance: f64,
    /// Arithmetic of the value.
    why: String,
}

/// One channel, or all; "inf" is a number too.
#[derive(Deserialize)]
#[serde(untagged)]
enum Channels {
    One(Number),
    All(Vec<Number>),
}

#[derive(Deserialize)]
#[serde(untagged)]
enum Number {
    Finite(f64),
    Infinite(Infinite),
}

#[derive(Deserialize)]
enum Infinite {
    #[serde(rename = "inf")]
    Positive,
}

impl Number {
    fn value(&self) -> f64 {
        match self {
            Self::Finite(value) => *value,
            Self::Infinite(Infinite::Positive) => f64::INFINITY,
        }
    }
}

impl Channels {
    fn values(&self) -> Vec<f64> {
        match self {
            Self::One(value) => vec![value.value()],
            Self::All(values) => values.iter().map(Number::value).collect(),
        }
    }
}

fn cases() -> PathBuf {
    root().join("tests/nodes")
}

fn read(name: &str) -> Result<String, String> {
    let text = std::fs::read_to_string(cases().join(name));
    text.map_err(|error| format!("tests/nodes/{name}: {error}; every node type has a golden case"))
}

fn picture<'f>(graph: &CheckedGraph, frame: &'f Frame, output: &str) -> Option<&'f Picture> {
    frame.pictures.iter().find(|picture| graph.outputs()[picture.output].name == output)
}

/// Returns the distance of a value from the expected one, which is 0 for equal infinities.
fn distance(found: f64, expected: f64) -> f64 {
    if found == expected { 0.0 } else { (found - expected).abs() }
}

/// Returns the differences from the pixels worked out by hand.
fn by_hand(graph: &CheckedGraph, frame: &Frame, rows: &[ByHand]) -> Vec<String> {
    let mut faults = Vec::new();
    if rows.len() > BY_HAND {
        faults
            .push(format!("by_hand: found {} pixels; expected at most {BY_HAND}, the rest is the sheet's", rows.len()));
    }
    for row in rows {
        let ([x, y], output) = (row.pixel, &row.output);
        if row.why.trim().is_empty() {
            faults.push(format!("by_hand: {output} at ({x}, {y}) does not say \"why\"; expected its arithmetic"));
        }
        let Some(picture) = picture(graph, frame, output) else {
            faults.push(format!("by_hand: the document has no output \"{output}\""));
            continue;
        };
        let values = row.value.values();
        if !picture.planes[0].window().contains(x, y) || values.len() != picture.planes.len() {
            let window = picture.planes[0].window();
            let (found, channels) = (values.len(), picture.planes.len());
            faults.push(format!(
                "by_hand: found {found} channels of {output} at ({x}, {y}); expected {channels}, within {window}"
            ));
            continue;
        }
        for (channel, value) in values.into_iter().enumerate() {
            let found = f64::from(sample(picture, channel, x, y));
            if distance(found, value).is_nan() || distance(found, value) > row.tolerance {
                let tolerance = row.tolerance;
                faults.push(format!(
                    "by_hand: {output}, channel {channel} of ({x}, {y}): found {found}; expected {value} ± {tolerance}: {}",
                    row.why
                ));
            }
        }
    }
    faults
}

impl Expected {
    /// Returns the tolerance of a value against the sheet; `None` if the case has none.
    fn tolerance(&self, output: &str, pixel: [i64; 2], value: f64) -> Option<f64> {
        let farther = self.farther.iter().find(|one| one.output == output && one.pixel == pixel);
        let rounded = self.inexact.iter().any(|one| one == output);
        let exact = value.is_infinite() || ((value == 0.0 || value == 1.0) && !rounded);
        let tolerance = farther.map(|one| one.tolerance).or(self.sheet_tolerance.get(output).copied());
        tolerance.map(|tolerance| if exact { 0.0 } else { tolerance })
    }

    /// Returns the values of the fast path that are too far from the references in the sheet.
    fn sheet(&self, graph: &CheckedGraph, frame: &Frame, truths: &[Truth]) -> Vec<String> {
        let mut faults = Vec::new();
        let named = self.sheet_tolerance.keys().chain(&self.inexact).chain(self.farther.iter().map(|one| &one.output));
        for name in named.filter(|name| picture(graph, frame, name).is_none()) {
            faults.push(format!("found a tolerance of \"{name}\"; expected an output of the document"));
        }
        if self.farther.iter().any(|one| one.why.trim().is_empty()) {
            faults.push("farther: found a pixel that does not say \"why\"".into());
        }
        for truth in truths {
            let (output, mut far) = (&truth.output, Vec::new());
            let picture = picture(graph, frame, output).unwrap();
            for ([x, y], channel, value) in truth.values() {
                let Some(tolerance) = self.tolerance(output, [x, y], value) else {
                    faults.push(format!("sheet_tolerance: found none of the output \"{output}\"; expected one"));
                    break;
                };
                let found = f64::from(sample(picture, channel, x, y));
                let off = distance(found, value);
                if off.is_nan() || off > tolerance {
                    far.push(format!(
                        "sheet: {output}, channel {channel} of ({x}, {y}): found {found}; expected {value} ± {tolerance}"
                    ));
                }
            }
            let count = far.len();
            faults.extend(far.into_iter().take(3));
            if count > 3 {
                faults.push(format!("sheet: {output}: {} more values are off", count - 3));
            }
        }
        faults
    }
}

/// Compares the fast path with the f64 reference, and with itself under all settings.
fn holds_itself(name: &str, graph: &CheckedGraph, number: i64, tolerance: f64) {
    let what =
        format!("{name}, {} samples, shaded by the {}", graph.format().samples(), graph.format().shading().name());
    let frame = under_all_settings(graph, number, &Buffers::new(), &what);
    let certifier = Certifier::new(graph, &[], number, &[], &settings(|_| ())).unwrap();
    let certified = certifier.certify(&Buffers::new(), &mut Cache::new(), &Silent).unwrap();
    pixels_are_as_the_whole(graph, number, &frame, &certified, &what);
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
                // Adaptive sampling leaves samples out.
                assert!(
                    distance(found, *truth) <= tolerance * scale || graph.format().adaptive().is_some(),
                    "{what}: {output}, channel {channel} of ({x}, {y}): found {found}, the reference says {truth}"
                );
            }
        }
    }
}

/// Checks that every pixel has a certified bound.
fn is_in_no_doubt(graph: &CheckedGraph, number: i64) {
    let certifier = Certifier::new(graph, &[], number, &[], &settings(|_| ())).unwrap();
    for output in certifier.certify(&Buffers::new(), &mut Cache::new(), &Silent).unwrap() {
        assert_eq!(output.unclear.total(), 0, "pixels in doubt");
        assert!(output.clear.max() < 1e-4 && output.clear.total() > 0, "certified to {}", output.clear.max());
    }
}

fn holds(name: &str) -> Result<(), String> {
    let folder = folder();
    let text = read(&format!("{name}.json"))?;
    if !text.contains(&format!("\"type\": \"{name}\"")) {
        return Err(format!("tests/nodes/{name}.json has no {name}"));
    }
    let file = format!("{name}.expect.json");
    let expected: Expected =
        serde_json::from_str(&read(&file)?).map_err(|error| format!("tests/nodes/{file}: {error}"))?;
    let graph = graph_in(folder.path(), &text);
    let number = expected.frame.unwrap_or(graph.frames().0);
    let truths = Truth::of(&graph, number)?;
    let frame = evaluate(&graph, number, &Buffers::new(), &settings(|_| ()));
    let mut faults = by_hand(&graph, &frame, &expected.by_hand);
    if expected.formula.is_empty() {
        faults.push("formula: found none; expected what the case computes".into());
    }
    if expected.by_hand.is_empty() == expected.not_by_hand.is_empty() {
        faults.push("by_hand: expected pixels that are worked out by hand, or not_by_hand, why there are none".into());
    }
    faults.extend(expected.sheet(&graph, &frame, &truths));
    faults.extend(stored::holds(&cases().join(format!("{name}.sheet.txt")), &sheet::text(name, &truths)).err());
    if !faults.is_empty() {
        return Err(format!("tests/nodes/{name}\n{}", faults.join("\n")));
    }
    let formats = [(1, Shading::Sample, None), (4, Shading::Sample, None), (4, Shading::Pixel, None)];
    for (samples, shading, adaptive) in formats.into_iter().chain([(4, Shading::Sample, Some(0.1))]) {
        let format = Format::new(graph.format().width(), graph.format().height(), samples).unwrap();
        let graph = graph.clone().with_format(format.with_shading(shading).with_adaptive(adaptive));
        holds_itself(name, &graph, number, expected.reference_tolerance);
    }
    if expected.no_doubt {
        is_in_no_doubt(&graph, number);
    }
    Ok(())
}

/// Checks that every file of the folder belongs to a type.
fn strays() -> Result<(), String> {
    for entry in std::fs::read_dir(cases()).unwrap() {
        let name = entry.unwrap().file_name().into_string().unwrap();
        let (ty, ending) = name.split_once('.').unwrap_or((&name, ""));
        if registry().iter().all(|known| known.declaration().name != ty) {
            return Err(format!("tests/nodes/{name} is no type's case"));
        }
        if !["json", "expect.json", "sheet.txt"].contains(&ending) {
            return Err(format!("tests/nodes/{name} is no part of a case"));
        }
    }
    Ok(())
}

pub(crate) fn trials() -> Vec<Trial> {
    let types = registry().iter().map(|ty| ty.declaration().name);
    let mut trials: Vec<Trial> = types.map(|name| trial("nodes", name, move || holds(name))).collect();
    trials.push(trial("nodes", "every_file_belongs_to_a_type", strays));
    trials
}
