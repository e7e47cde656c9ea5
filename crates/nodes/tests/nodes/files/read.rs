//! Tests of Read on generated files.

use crate::testing::{Frame, graph, refused};
use std::path::Path;
use trochoid_graph::{Kind, NodeError};
use trochoid_image::{Chromaticities, Plane, Window, WorkingSpace, srgb_decode};
use trochoid_io::{ExrChannel, ExrImage, PngImage, Samples, write_exr, write_png8};

/// Writes 4 × 3 pixels of named channels with the given samples.
pub(super) fn exr(folder: &Path, channels: &[(&str, [f32; 12])], chromaticities: Option<Chromaticities>) {
    let window = Window::sized(4, 3);
    let channels =
        channels.iter().map(|(name, samples)| ExrChannel::float(*name, Samples::contiguous(samples))).collect();
    write_exr(folder.join("a.exr"), &ExrImage { channels, chromaticities, ..ExrImage::new(window) }).unwrap();
}

pub(super) fn read(folder: &Path, key: &str, knobs: &str) -> Result<Frame, NodeError> {
    let node = format!(r#""out": {{ "type": "Read", "file": "a.exr", {knobs} }}"#);
    let frame = Frame::new(graph(key, &node, folder).unwrap())?;
    // Bad data may be found only where it is needed.
    frame.fill_all("out")?;
    Ok(frame)
}

fn message(result: Result<Frame, NodeError>) -> String {
    result.err().expect("an error").to_string()
}

/// Returns the value by reference and by fill, which must agree.
pub(super) fn value(frame: &Frame, x: usize, y: usize) -> Vec<f32> {
    let at = [x as f64 + 0.5, y as f64 + 0.5];
    let (truth, found) = (frame.truth(at), frame.lowered(at));
    let near = |(truth, found): (&f64, &f32)| (truth - f64::from(*found)).abs() < 1e-6 || *truth == f64::from(*found);
    assert!(truth.len() == found.len() && truth.iter().zip(&found).all(near), "{truth:?} and {found:?}");
    found
}

fn ramp(scale: f32) -> [f32; 12] {
    std::array::from_fn(|index| index as f32 * scale)
}

#[test]
fn colors_come_as_they_are_and_are_controls() {
    let folder = tempfile::tempdir().unwrap();
    exr(folder.path(), &[("B", ramp(0.5)), ("G", ramp(0.25)), ("R", ramp(1.0)), ("A", [0.0; 12])], None);
    let frame = read(folder.path(), "color", r#""as": "color""#).unwrap();
    assert_eq!(value(&frame, 2, 1), [6.0, 1.5, 3.0]);
    assert_eq!(frame.node("out").controls().len(), 12);
    assert_eq!(frame.node("out").bytes(), 3 * 12 * 4);
    let gray = read(folder.path(), "color", r#""as": "color", "channels": ["B"]"#).unwrap();
    assert_eq!(value(&gray, 2, 1), [3.0, 3.0, 3.0]);
}

#[test]
fn many_colors_are_handed_over_as_their_hull() {
    let folder = tempfile::tempdir().unwrap();
    const MOST: usize = 1 << 16;
    for (count, listed) in [(9, 9), (MOST, MOST), (MOST + 1, 4)] {
        // Every color twice; more than the most that are listed lie on a line and a point beside it.
        let planes = [0, 1, 2].map(|channel: usize| -> Vec<f32> {
            let color = |index: usize| if index == 3 { [1.0, 7.0, 9.0][channel] } else { index as f32 };
            (0..2 * count).map(|at| color(at / 2)).collect()
        });
        let channels = ["R", "G", "B"].into_iter().zip(&planes);
        let channels = channels.map(|(name, plane)| ExrChannel::float(name, Samples::contiguous(plane))).collect();
        let image = ExrImage { channels, ..ExrImage::new(Window::new(0, 0, 2, count as i64)) };
        write_exr(folder.path().join("a.exr"), &image).unwrap();
        let controls = read(folder.path(), "color", r#""as": "color", "fit": "crop""#).unwrap().node("out").controls();
        if count <= MOST {
            assert_eq!(controls.len(), listed, "in the order of their pixels: {:?}", &controls[..4]);
            assert_eq!(controls[..3], [[0.0; 3], [1.0; 3], [2.0; 3]]);
        } else {
            assert!(controls.len() <= listed, "{controls:?}");
            for corner in [[0.0; 3], [MOST as f32; 3], [1.0, 7.0, 9.0]] {
                assert!(controls.contains(&corner), "{corner:?} of {controls:?}");
            }
        }
    }
}

#[test]
fn bad_data_are_refused_with_their_place_or_repaired() {
    let folder = tempfile::tempdir().unwrap();
    let mut bad = ramp(0.05);
    bad[6] = -0.25;
    bad[7] = f32::NAN;
    exr(folder.path(), &[("R", ramp(0.1)), ("G", bad), ("B", ramp(0.1))], None);
    for (knobs, key, expected) in [
        (r#""as": "color""#, "color", "at least 0"),
        (r#""as": "weights", "channels": ["G"]"#, "weights", "from 0 to 1"),
    ] {
        let text = message(read(folder.path(), key, knobs));
        assert!(text.contains("part 0, channel \"G\", pixel (2, 1): found -0.25"), "{text}");
        assert!(text.contains(expected) && text.contains("\"repair\""), "{text}");
    }
    let text = message(read(folder.path(), "field", r#""as": "field", "channels": ["G"]"#));
    assert!(text.contains("pixel (3, 1): found NaN"), "{text}");
    let frame = read(folder.path(), "color", r#""as": "color", "repair": true"#).unwrap();
    assert_eq!(frame.node("out").repaired(), 2);
    assert_eq!(value(&frame, 2, 1)[1], 0.0);
}

#[test]
fn weights_need_a_sum_of_one() {
    let folder = tempfile::tempdir().unwrap();
    let third = [0.3335_f32; 12];
    let mut off = third;
    off[5] = 0.25;
    exr(folder.path(), &[("a", third), ("b", third), ("c", third), ("d", off), ("half", [0.5; 12])], None);
    let frame = read(folder.path(), "weights", r#""as": "weights", "channels": ["a", "b", "c"]"#).unwrap();
    assert!((value(&frame, 1, 1).iter().sum::<f32>() - 1.0).abs() < 1e-6);
    let two = read(folder.path(), "weights", r#""as": "weights", "channels": ["half", "half"]"#).unwrap();
    assert_eq!(value(&two, 1, 1), [0.5, 0.5]);
    let bad = r#""as": "weights", "channels": ["a", "b", "d"]"#;
    let text = message(read(folder.path(), "weights", bad));
    assert!(text.contains("pixel (1, 1)") && text.contains("sum"), "{text}");
    let repaired = read(folder.path(), "weights", &format!(r#"{bad}, "repair": true"#)).unwrap();
    assert_eq!(repaired.node("out").repaired(), 1);
    assert!((value(&repaired, 1, 1).iter().sum::<f32>() - 1.0).abs() < 1e-6);
    let text = message(read(folder.path(), "weights", r#""as": "weights""#));
    assert!(text.contains("5 channels: ") && text.contains("\"half\""), "{text}");
}

#[test]
fn fields_keep_infinity_and_take_named_channels() {
    let folder = tempfile::tempdir().unwrap();
    let mut depth = ramp(10.0);
    depth[3] = f32::INFINITY;
    exr(folder.path(), &[("depth.Z", depth), ("uv.U", ramp(0.1)), ("uv.V", ramp(-0.1))], None);
    let frame = read(folder.path(), "field", r#""as": "field", "layer": "depth""#).unwrap();
    assert_eq!(value(&frame, 3, 0), [f32::INFINITY]);
    let uv = read(folder.path(), "field", r#""as": "field", "layer": "uv", "channels": ["V", "U"]"#).unwrap();
    assert_eq!(value(&uv, 1, 0), [-0.1, 0.1]);
    assert!(message(read(folder.path(), "field", r#""as": "field", "layer": "dept""#)).contains("\"depth\""));
}

#[test]
fn premultiplied_colors_are_divided() {
    let folder = tempfile::tempdir().unwrap();
    let mut alpha = [0.5; 12];
    (alpha[0], alpha[4]) = (0.0, 0.0);
    exr(folder.path(), &[("R", [0.25; 12]), ("G", ramp(0.25)), ("B", [0.0; 12]), ("A", alpha)], None);
    let frame = read(folder.path(), "color", r#""as": "color", "premultiplied": true"#).unwrap();
    assert_eq!(value(&frame, 2, 0), [0.5, 1.0, 0.0]);
    assert_eq!(value(&frame, 0, 0), [0.5, 0.5, 0.0], "from the pixel to the right");
    exr(folder.path(), &[("R", [0.25; 12]), ("G", [0.0; 12]), ("B", [0.0; 12]), ("A", [0.0; 12])], None);
    let nothing = r#""as": "color", "premultiplied": true"#;
    assert!(message(read(folder.path(), "color", nothing)).contains("alpha 0 everywhere"));
    let outside = read(folder.path(), "color", &format!(r#"{nothing}, "outside": [1, 2, 3]"#)).unwrap();
    assert_eq!(value(&outside, 1, 1), [1.0, 2.0, 3.0]);
}

#[test]
fn stated_primaries_are_converted() {
    let folder = tempfile::tempdir().unwrap();
    let light = [0.25_f64, 0.5, 0.125];
    let wide = WorkingSpace::AcesCg.from_linear_srgb(light);
    let channels = ["R", "G", "B"].iter().zip(wide).map(|(name, v)| (*name, [v as f32; 12])).collect::<Vec<_>>();
    exr(folder.path(), &channels, Some(WorkingSpace::AcesCg.chromaticities()));
    let frame = read(folder.path(), "color", r#""as": "color""#).unwrap();
    for (found, expected) in value(&frame, 0, 0).iter().zip(light) {
        assert!((f64::from(*found) - expected).abs() < 1e-6);
    }
    exr(
        folder.path(),
        &[("R", [0.0; 12]), ("G", [0.5; 12]), ("B", [0.0; 12])],
        Some(WorkingSpace::AcesCg.chromaticities()),
    );
    let text = message(read(folder.path(), "color", r#""as": "color""#));
    assert!(text.contains("pixel (0, 0)") && text.contains("linear-srgb") && text.contains("acescg"), "{text}");
    // Other primaries work too: from P3 to Rec. 709 with the published 6 digits.
    let p3 = Chromaticities { red: [0.68, 0.32], green: [0.265, 0.69], blue: [0.15, 0.06], white: [0.3127, 0.329] };
    exr(folder.path(), &[("R", [0.5; 12]), ("G", [0.5; 12]), ("B", [0.25; 12])], Some(p3));
    let frame = read(folder.path(), "color", r#""as": "color""#).unwrap();
    let m = [[1.224_940, -0.224_940, 0.0], [-0.042_057, 1.042_057, 0.0], [-0.019_638, -0.078_636, 1.098_274]];
    for (found, row) in value(&frame, 0, 0).iter().zip(m) {
        let expected = row[0] * 0.5 + row[1] * 0.5 + row[2] * 0.25;
        assert!((f64::from(*found) - expected).abs() < 1e-5, "{found} and {expected}");
    }
    for bad in [Chromaticities { red: p3.green, ..p3 }, Chromaticities { white: [f32::NAN, 0.3], ..p3 }] {
        exr(folder.path(), &[("R", [0.5; 12]), ("G", [0.5; 12]), ("B", [0.25; 12])], Some(bad));
        let text = message(read(folder.path(), "color", r#""as": "color""#));
        assert!(
            text.contains("expected three primaries that span colors") && text.contains("chromaticities"),
            "{text}"
        );
    }
}

#[test]
fn png_is_decoded_for_colors_only() {
    let folder = tempfile::tempdir().unwrap();
    let level = 128.0_f32 / 255.0;
    let pixels = [[level, 0.0, 1.0]; 12];
    write_png8(folder.path().join("a.exr"), &PngImage::new(4, 3, Samples::rgb(&pixels))).unwrap();
    let frame = read(folder.path(), "color", r#""as": "color""#).unwrap();
    assert_eq!(value(&frame, 0, 0), [srgb_decode(128.0 / 255.0) as f32, 0.0, 1.0]);
    let linear = read(folder.path(), "color", r#""as": "color", "encoding": "linear""#).unwrap();
    assert_eq!(value(&linear, 0, 0), [level, 0.0, 1.0]);
    let mask = read(folder.path(), "weights", r#""as": "weights", "channels": ["R"]"#).unwrap();
    assert_eq!(value(&mask, 0, 0)[1], level);
}

#[test]
fn other_sizes_windows_and_limits() {
    let folder = tempfile::tempdir().unwrap();
    let plane = Plane::new(Window::new(1, 1, 3, 2), vec![0.25, 0.75]).unwrap();
    let image = |display: Window| ExrImage {
        data: plane.window(),
        channels: vec![ExrChannel::float("Y", Samples::plane(&plane))],
        ..ExrImage::new(display)
    };
    write_exr(folder.path().join("a.exr"), &image(Window::sized(4, 3))).unwrap();
    let repeated = read(folder.path(), "color", r#""as": "color""#).unwrap();
    assert_eq!((value(&repeated, 0, 0)[0], value(&repeated, 3, 2)[0]), (0.25, 0.75));
    let filled = read(folder.path(), "color", r#""as": "color", "outside": [1, 2, 3]"#).unwrap();
    assert_eq!((value(&filled, 0, 0), value(&filled, 1, 1)), (vec![1.0, 2.0, 3.0], vec![0.25; 3]));
    assert_eq!(filled.node("out").controls().len(), 3);

    write_exr(folder.path().join("a.exr"), &image(Window::sized(8, 6))).unwrap();
    let text = message(read(folder.path(), "color", r#""as": "color""#));
    assert!(text.contains("8 × 6") && text.contains("4 × 3") && text.contains("\"fit\""), "{text}");
    let scaled = read(folder.path(), "color", r#""as": "color", "fit": "bilinear""#).unwrap();
    assert_eq!(value(&scaled, 0, 0)[0], 0.25);

    let node = r#""out": { "type": "Read", "file": "a.exr", "as": "color", "fit": "crop" }"#;
    let graph = graph("color", node, folder.path()).unwrap();
    let context = graph.frame_context(1, 4);
    let settled = graph.settle(graph.find("out").unwrap(), 1);
    let wanted = [vec![true; 3]];
    let pool = trochoid_graph::Pool::new();
    let prepare = trochoid_graph::Prepare::new(&context, &[Kind::Color], &wanted, &|_| None, &|| false, &pool);
    let stage = settled.stage().unwrap();
    assert!(stage.prepare(&prepare).is_err_and(|error| error.to_string().contains("at most 4")));
}

#[test]
fn knobs_that_do_not_fit_together_are_refused() {
    let node = |knobs: &str| format!(r#""out": {{ "type": "Read", "file": "a.exr", {knobs} }}"#);
    for (key, knobs, expected) in [
        ("color", r#""as": "color", "channels": ["R", "G"]"#, "2 channels"),
        ("field", r#""as": "field", "channels": ["a", "b", "c", "d", "e"]"#, "at most 4"),
        ("field", r#""as": "field", "outside": [0, 0, 0]"#, "a Read as field"),
        ("weights", r#""as": "weights", "premultiplied": true"#, "a Read as weights"),
        ("weights", r#""as": "weights", "encoding": "srgb""#, "as stored"),
        ("color", r#""part": "0""#, "no \\\"as\\\""),
    ] {
        let text = refused(key, &node(knobs));
        assert!(text.contains(expected), "{text}");
    }
}
