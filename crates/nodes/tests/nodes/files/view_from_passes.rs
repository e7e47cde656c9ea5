//! Tests of ViewFromPasses on generated files.

use crate::testing::Frame;
use std::path::Path;
use trochoid_graph::{Channel, ChannelSet, Document, NodeError, Reference, Registry, check};
use trochoid_image::Window;
use trochoid_io::{ExrChannel, ExrImage, Samples, write_exr};

fn exr(folder: &Path, channels: &[(&str, [f32; 2])]) {
    let channels =
        channels.iter().map(|(name, samples)| ExrChannel::float(*name, Samples::contiguous(samples))).collect();
    write_exr(folder.join("a.exr"), &ExrImage { channels, ..ExrImage::new(Window::sized(2, 1)) }).unwrap();
}

/// Returns a frame whose output is the view's coverage, because a view itself cannot be an output.
fn view(folder: &Path, knobs: &str) -> Result<Frame, NodeError> {
    let text = format!(
        r#"{{ "trochoid": 1, "format": {{ "width": 2, "height": 1 }}, "nodes": {{
            "view": {{ "type": "ViewFromPasses", "file": "a.exr", {knobs} }} }},
            "outputs": {{ "out": {{ "weights": "view.coverage" }} }} }}"#
    );
    let document = Document::parse("test.json", &text).unwrap();
    let (graph, faults) = check(&document, &Registry::new(trochoid_nodes::all()), folder);
    let frame = Frame::new(graph.unwrap_or_else(|| panic!("{faults:?}")))?;
    // Bad data is found only where it is needed.
    frame.fill_all("view")?;
    Ok(frame)
}

/// Returns all channels at a pixel, by reference and by fill, which must agree.
fn channels(frame: &Frame, x: usize) -> Vec<f32> {
    let id = frame.graph.find("view").unwrap();
    let at = [x as f64 + 0.5, 0.5];
    let Reference::View(truth) = frame.reference(id, 0, at) else { panic!("a view") };
    let found: Vec<f32> = (0..Channel::COUNT).map(|channel| frame.filled(id, 0, channel, at)).collect();
    assert!(truth.iter().zip(&found).all(|(truth, found)| *truth == f64::from(*found)), "{truth:?} and {found:?}");
    assert_eq!(frame.filled(id, 1, 0, at), found[Channel::Coverage as usize]);
    found
}

#[test]
fn blender_passes_are_turned_and_their_sky_removed() {
    let folder = tempfile::tempdir().unwrap();
    exr(
        folder.path(),
        &[
            ("Sea.Depth.Z", [12.5, 65504.0]),
            ("Sea.Position.X", [1.0, 0.0]),
            ("Sea.Position.Y", [2.0, 0.0]),
            ("Sea.Position.Z", [3.0, 0.0]),
            ("Sea.Normal.X", [0.0, 0.0]),
            ("Sea.Normal.Y", [0.0, 0.0]),
            ("Sea.Normal.Z", [2.0, 0.0]),
        ],
    );
    let knobs = r#""depth": "Depth", "position": "Position", "normal": "Sea.Normal", "up": "z""#;
    let frame = view(folder.path(), knobs).unwrap();
    assert_eq!(channels(&frame, 0)[..8], [1.0, 12.5, 1.0, 3.0, -2.0, 0.0, 1.0, 0.0]);
    assert_eq!(channels(&frame, 1)[..8], [0.0, f32::INFINITY, 0.0, 0.0, 0.0, 0.0, 1.0, 0.0]);
}

#[test]
fn a_coverage_pass_counts_before_depth() {
    let folder = tempfile::tempdir().unwrap();
    exr(folder.path(), &[("Z", [2.0, 1e10]), ("Sea.Combined.A", [0.25, 0.75])]);
    let frame = view(folder.path(), r#""depth": "Z", "coverage": "Combined.A""#).unwrap();
    assert_eq!(channels(&frame, 0)[..2], [0.25, 2.0]);
    assert_eq!(channels(&frame, 1)[..2], [0.75, f32::INFINITY]);
    exr(folder.path(), &[("Z", [2.0, 1e10]), ("Sea.Combined.A", [0.25, 1.5])]);
    let text = view(folder.path(), r#""coverage": "Sea.Combined.A""#).err().unwrap().to_string();
    assert!(text.contains("\"Sea.Combined.A\", pixel (1, 0): found 1.5"), "{text}");
}

#[test]
fn a_painted_normal_map_covers_everything() {
    let folder = tempfile::tempdir().unwrap();
    exr(folder.path(), &[("R", [0.5, 1.0]), ("G", [0.5, 0.5]), ("B", [1.0, 0.5])]);
    let frame = view(folder.path(), r#""normal": "R""#).err().unwrap().to_string();
    assert!(frame.contains("X, Y and Z"), "{frame}");
    exr(folder.path(), &[("map.R", [0.5, 1.0]), ("map.G", [0.5, 0.5]), ("map.B", [1.0, 0.5])]);
    let frame = view(folder.path(), r#""normal": "map", "packed": true"#).unwrap();
    assert_eq!(channels(&frame, 0)[5..8], [0.0, 0.0, 1.0]);
    assert_eq!(channels(&frame, 1)[5..8], [1.0, 0.0, 0.0]);
    assert_eq!(channels(&frame, 0)[0], 1.0);
}

#[test]
fn the_main_layer_may_be_a_pass() {
    let folder = tempfile::tempdir().unwrap();
    exr(folder.path(), &[("R", [0.0, 0.5]), ("G", [0.5, 0.5]), ("B", [1.0, 1.0])]);
    let frame = view(folder.path(), r#""normal": "RGB", "packed": true"#).unwrap();
    let n: Vec<f32> = channels(&frame, 0)[5..8].to_vec();
    let half = std::f32::consts::FRAC_1_SQRT_2;
    assert!((n[0] + half).abs() < 1e-4 && n[1].abs() < 1e-4 && (n[2] - half).abs() < 1e-4, "{n:?}");
    exr(folder.path(), &[("Z", [2.0, 3.0])]);
    let text = view(folder.path(), r#""normal": "RGB""#).err().unwrap().to_string();
    assert!(text.contains("RGB"), "{text}");
}

#[test]
fn only_given_passes_are_supplied() {
    let folder = tempfile::tempdir().unwrap();
    exr(folder.path(), &[("Z", [2.0, 3.0])]);
    let frame = view(folder.path(), r#""depth": "Z""#).unwrap();
    let settled = frame.graph.settle(frame.graph.find("view").unwrap(), 1);
    assert_eq!(settled.stage().unwrap().supplied_channels(), ChannelSet::of(&[Channel::Coverage, Channel::Depth]));
    let text = view(folder.path(), r#""depth": "Depth""#).err().unwrap().to_string();
    assert!(text.contains("no layer \"Depth\""), "{text}");
}
