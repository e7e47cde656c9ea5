//! Weights from files, from buffers and from documents that sum to 1 only nearly are divided by their sum, in pictures
//! and references alike.

use crate::support::{all_bits, evaluate, graph_in, settings, write_exr};
use trochoid::{Buffers, Cache, Certifier, Look, Plan, ReferenceFrame, Samples, SamplesMut, Settings, Silent};

const COUNT: usize = 64;

/// Three weights that differ from a sum of 1 by up to `off`.
fn weights(off: f64) -> [Vec<f32>; 3] {
    let part = |at: usize, step: usize| ((at * step) % 61) as f64 + 0.125;
    [7, 11, 5].map(|step| {
        let of = |at: usize| {
            let sum: f64 = [7, 11, 5].iter().map(|step| part(at, *step)).sum();
            let scale = 1.0 + off * (((at * 29) % 63) as f64 / 31.0 - 1.0);
            (part(at, step) / sum * scale) as f32
        };
        (0..COUNT).map(of).collect()
    })
}

const NODES: &str = r##""nodes": {
    "w": { "type": "Read", "file": "a.exr", "as": "weights", "channels": ["w0", "w1", "w2"] },
    "soft": { "type": "Blur", "image": "w", "size": 0.7 },
    "there": { "type": "Texture", "file": "a.exr", "as": "weights", "channels": ["w0", "w1", "w2"], "u": "x", "v": 0.3 },
    "x": { "type": "ScreenX" },
    "color": { "type": "Blend", "colors": ["#f00", [0, 3, 0.1], "#12f"], "weights": "w" },
    "blurred": { "type": "Blend", "colors": ["#f00", [0, 3, 0.1], "#12f"], "weights": "soft" },
    "found": { "type": "Blend", "colors": ["#f00", [0, 3, 0.1], "#12f"], "weights": "there" } }"##;

#[test]
fn files_and_buffers_mean_the_same_parts() {
    for off in [0.0, 4e-8, 9e-4] {
        let planes = weights(off);
        let folder = tempfile::tempdir().unwrap();
        let channels = ["w0", "w1", "w2"].into_iter().zip(planes.iter().map(|plane| &plane[..]));
        write_exr(&folder.path().join("a.exr"), 16, 4, &channels.collect::<Vec<_>>());
        let text = format!(
            r#"{{ "trochoid": 1, "format": {{ "width": 16, "height": 4 }}, {NODES}, "outputs": {{
                "w": {{ "weights": "w" }}, "soft": {{ "weights": "soft" }}, "there": {{ "weights": "there" }},
                "color": {{ "color": "color" }}, "blurred": {{ "color": "blurred" }}, "found": {{ "color": "found" }} }} }}"#
        );
        let graph = graph_in(folder.path(), &text);
        let frame = evaluate(&graph, 1, &Buffers::new(), &settings(|_| ()));
        let reference = ReferenceFrame::new(&graph, "w", 1).unwrap();
        for (x, y) in (0..4).flat_map(|y| (0..16).map(move |x| (x, y))) {
            let at = y * 16 + x;
            let stored = [0, 1, 2].map(|i| f64::from(planes[i][at]));
            let sum: f64 = stored.iter().sum();
            let truth = reference.pixel(x as i64, y as i64).unwrap();
            for (truth, stored) in truth.iter().zip(stored) {
                assert!((truth - stored / sum).abs() < 1e-15, "{off}: {truth} of {stored}");
            }
        }
        for name in ["w", "soft", "there"] {
            let reference = ReferenceFrame::new(&graph, name, 1).unwrap();
            for (x, y) in (0..4).flat_map(|y| (0..16).map(move |x| (x, y))) {
                let sum: f64 = reference.pixel(x, y).unwrap().iter().sum();
                assert!((sum - 1.0).abs() < 1e-14, "{off}: {name} sums to {sum}");
            }
        }
        // A buffer with the same numbers gives the same bits, to programs, filters and batches.
        let bound = Buffers::new().with("w", &[&planes[0], &planes[1], &planes[2]]);
        for settings in [settings(|_| ()), settings(|s| s.tile = Some((3, 2))), settings(|s| s.compile_from = 0)] {
            assert_eq!(all_bits(&frame), all_bits(&evaluate(&graph, 1, &bound, &settings)), "{off}");
        }
        let look = Look::new(graph.clone(), "color", 1, &["w"], &Settings::default()).unwrap();
        let mut batch = [0, 1, 2].map(|_| vec![0.0; COUNT]);
        let inputs = planes.each_ref().map(|plane| Samples::new(plane));
        let mut outputs = batch.each_mut().map(|channel| SamplesMut::new(channel));
        look.shader().unwrap().shade(COUNT, &inputs, &mut outputs).unwrap();
        let color = frame.pictures.iter().find(|picture| graph.outputs()[picture.output].name == "color").unwrap();
        for (channel, plane) in batch.iter().zip(&color.planes) {
            assert_eq!(channel, plane.samples(), "{off}");
        }
        // What is certified of buffers holds against the references of files.
        let certified = Certifier::new(&graph, &[], 1, &["w"], &settings(|_| ())).unwrap();
        let certified = certified.certify(&bound, &mut Cache::new(), &Silent).unwrap();
        for (picture, certified) in frame.pictures.iter().zip(&certified) {
            let name = &graph.outputs()[picture.output].name;
            let reference = ReferenceFrame::new(&graph, name, 1).unwrap();
            for at in 0..COUNT {
                let truth = reference.pixel((at % 16) as i64, (at / 16) as i64).unwrap();
                for (channel, truth) in truth.iter().enumerate() {
                    let error = (f64::from(picture.planes[channel].samples()[at]) - truth).abs();
                    let bound = f64::from(certified.errors[channel][at]);
                    // Colors are at most 3.
                    assert!(error <= bound && bound < 3e-6, "{off}: {name}: {error:e} of {bound:e}");
                }
            }
        }
    }
}

#[test]
fn sums_that_are_off_are_refused_alike() {
    let planes = weights(3e-3);
    let folder = tempfile::tempdir().unwrap();
    let channels = ["w0", "w1", "w2"].into_iter().zip(planes.iter().map(|plane| &plane[..]));
    write_exr(&folder.path().join("a.exr"), 16, 4, &channels.collect::<Vec<_>>());
    let text = format!(
        r#"{{ "trochoid": 1, "format": {{ "width": 16, "height": 4 }}, {NODES}, "outputs": {{ "w": {{ "weights": "w" }} }} }}"#
    );
    let graph = graph_in(folder.path(), &text);
    let bound = Buffers::new().with("w", &[&planes[0], &planes[1], &planes[2]]);
    for buffers in [Buffers::new(), bound] {
        let plan = Plan::new(&graph, &[], 1, &buffers.names(), &settings(|_| ())).unwrap();
        let error = plan.evaluate(&buffers, &mut Cache::new(), &Silent).err().unwrap().to_string();
        assert!(error.contains("sum to 0.99699997"), "{error}");
    }
}

#[test]
fn literal_weights_are_divided_by_their_sum() {
    let numbers = [0.300_000_3, 0.3, 0.400_000_2];
    let text = format!(
        r##"{{ "trochoid": 1, "format": {{ "width": 1, "height": 1 }}, "nodes": {{
            "out": {{ "type": "Blend", "colors": [[1, 0, 0], [0, 1, 0], [0, 0, 1]], "weights": {numbers:?} }} }},
            "outputs": {{ "out": {{ "color": "out" }} }} }}"##
    );
    let graph = graph_in(std::path::Path::new("."), &text);
    let frame = evaluate(&graph, 1, &Buffers::new(), &settings(|_| ()));
    let truth = ReferenceFrame::new(&graph, "out", 1).unwrap().pixel(0, 0).unwrap();
    let sum: f64 = numbers.iter().sum();
    for ((plane, truth), number) in frame.pictures[0].planes.iter().zip(truth).zip(numbers) {
        assert!((truth - number / sum).abs() < 1e-15, "{truth} of {number}");
        assert!((f64::from(plane.samples()[0]) - truth).abs() < 1e-7);
    }
}
