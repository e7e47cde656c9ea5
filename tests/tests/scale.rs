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
fn a_chain_of_ten_thousand_nodes() {
    let frame = holds(&chain(COUNT, (16, 9)), 1e-6);
    assert!(frame.nodes.iter().all(|node| node.state == State::Evaluated || node.name != "n9999"));
}

#[test]
fn a_web_of_ten_thousand_nodes() {
    let frame = holds(&web(COUNT, (16, 9)), 1e-5);
    let count = |is: fn(&State) -> bool| frame.nodes.iter().filter(|node| is(&node.state)).count();
    assert!(count(|state| *state == State::Evaluated) > COUNT / 2, "most of it is needed");
    assert!(count(|state| matches!(state, State::LeftOut(LeftOut::Weight(_)))) > 100, "weights of 0 and 1 cut");
    assert_eq!(*state(&frame, "out"), State::Evaluated);
}
