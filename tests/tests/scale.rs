//! Ten thousand nodes are checked, planned and evaluated: nothing overflows, and the reference agrees.

use crate::support::large::{chain, web};
use crate::support::{evaluate, graph_in, sample, settings, state};
use std::path::Path;
use trochoid::{Buffers, LeftOut, ReferenceFrame, State, Switches};

const COUNT: usize = 10_000;

fn holds(text: &str, tolerance: f64) -> trochoid::Frame {
    let graph = graph_in(Path::new("."), text);
    assert_eq!(graph.nodes().len(), COUNT);
    let frame = evaluate(&graph, 1, &Buffers::new(), &settings(|_| ()));
    let picture = &frame.pictures[0];
    assert_eq!((picture.audit.hull_exits, picture.audit.nan_count), (0, 0));
    let reference = ReferenceFrame::new(&graph, "out", 1).unwrap();
    for (x, y) in [(0, 0), (7, 3), (12, 8), (15, 8)] {
        for (channel, truth) in reference.pixel(x, y).unwrap().into_iter().enumerate() {
            let found = f64::from(sample(picture, channel, x, y));
            assert!((found - truth).abs() <= tolerance, "({x}, {y}), channel {channel}: {found} and {truth}");
        }
    }
    let off = evaluate(&graph, 1, &Buffers::new(), &settings(|s| s.switches = Switches::NONE));
    assert_eq!(crate::support::all_bits(&frame), crate::support::all_bits(&off));
    frame
}

#[test]
fn a_chain_of_ten_thousand_nodes_agrees_with_the_reference() {
    let frame = holds(&chain(COUNT, (16, 9)), 1e-6);
    assert!(frame.nodes.iter().all(|node| node.state == State::Evaluated || node.name != "n9999"));
}

#[test]
fn a_web_of_ten_thousand_nodes_agrees_with_the_reference() {
    let frame = holds(&web(COUNT, (16, 9)), 1e-5);
    let count = |is: fn(&State) -> bool| frame.nodes.iter().filter(|node| is(&node.state)).count();
    assert!(count(|state| *state == State::Evaluated) > COUNT / 2, "most of it is needed");
    assert!(count(|state| matches!(state, State::LeftOut(LeftOut::Weight(_)))) > 100, "weights of 0 and 1 cut nodes");
    assert_eq!(*state(&frame, "out"), State::Evaluated);
}

#[test]
fn more_constants_than_16_bits_can_number_agree_with_the_reference() {
    // Each mix has a weight of its own, so that each needs a row of its own.
    let count = 70_000;
    let mut nodes = vec![
        r##""across": { "type": "ScreenX" }, "n0": { "type": "Mix", "a": "#102030", "b": "#fedcba",
        "weight": "across" }"##
            .to_string(),
    ];
    for i in 1..count {
        let (color, weight) = ((i as u64 * 0x3a_51f7) & 0xff_ffff, i as f64 / (64.0 * f64::from(count)));
        nodes.push(format!(
            r##""n{i}": {{ "type": "Mix", "a": "n{}", "b": "#{color:06x}", "weight": {weight} }}"##,
            i - 1
        ));
    }
    let outputs = format!(r#""out": {{ "color": "n{}" }}"#, count - 1);
    let graph = crate::support::graph(r#""width": 3, "height": 1"#, &nodes.join(",\n"), &outputs);
    let frame = evaluate(&graph, 1, &Buffers::new(), &settings(|_| ()));
    let reference = ReferenceFrame::new(&graph, "out", 1).unwrap();
    for x in 0..3 {
        for (channel, truth) in reference.pixel(x, 0).unwrap().into_iter().enumerate() {
            let found = f64::from(sample(&frame.pictures[0], channel, x, 0));
            assert!((found - truth).abs() <= 1e-5, "{x}, channel {channel}: {found} and {truth}");
        }
    }
}
