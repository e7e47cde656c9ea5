//! Broken kernels must be noticed: a report of zeros proves nothing unless other reports are possible.

use crate::nodes::registry;
use std::path::Path;
use trochoid_engine::inside::programs;
use trochoid_engine::{Buffers, Cache, Frame, Plan, ReferenceFrame, Settings, Silent, Switches};
use trochoid_graph::{CheckedGraph, Document, check};
use trochoid_kernel::Fault;

const DOCUMENT: &str = r##"{
  "trochoid": 1,
  "format": { "width": 50, "height": 20, "samples": 4 },
  "nodes": {
    "slope": { "type": "Slope" },
    "gate": { "type": "Gate", "field": "slope" },
    "mix": { "type": "Mix", "a": "#274e53", "b": "#839191", "weight": "gate" },
    "third": { "type": "Thirds", "colors": ["mix", "#ff8800", "#0011ff"], "weight": "gate" }
  },
  "outputs": { "beauty": { "color": "third" } }
}"##;

fn graph() -> CheckedGraph {
    let document = Document::parse("test", DOCUMENT).unwrap();
    let (graph, diagnostics) = check(&document, &registry(), Path::new("."));
    graph.unwrap_or_else(|| panic!("{diagnostics:?}"))
}

fn evaluate(graph: &CheckedGraph, fault: Fault, settings: &Settings) -> Frame {
    let mut plan = Plan::new(graph, &["beauty"], 1, &[], settings).unwrap();
    for program in programs(&mut plan) {
        program.fault = fault;
    }
    plan.evaluate(&Buffers::new(), &mut Cache::new(), &Silent).unwrap()
}

#[test]
fn sound_kernels_report_zeros() {
    let audit = evaluate(&graph(), Fault::None, &Settings::default()).pictures[0].audit;
    assert_eq!((audit.hull_exits, audit.nan_count, audit.pixels), (0, 0, 1000));
    assert_eq!((audit.weight_sum_max_deviation, audit.weight_min, audit.worst_exit), (0.0, 0.0, 0.0));
}

#[test]
fn an_overshooting_mix_leaves_the_hull() {
    let audit = evaluate(&graph(), Fault::MixOvershoots, &Settings::default()).pictures[0].audit;
    assert!(audit.hull_exits > 100 && audit.worst_exit > 1e-3, "{audit:?}");
}

#[test]
fn a_leaking_partition_is_seen_in_its_sum() {
    let audit = evaluate(&graph(), Fault::PartitionLeaks, &Settings::default()).pictures[0].audit;
    assert!(audit.weight_sum_max_deviation > 0.01 && audit.hull_exits > 0, "{audit:?}");
}

#[test]
fn a_leaking_mask_is_seen_in_the_least_weight() {
    let audit = evaluate(&graph(), Fault::ClampLeaks, &Settings::default()).pictures[0].audit;
    assert!(audit.weight_min < -0.2, "{audit:?}");
}

#[test]
fn lost_pixels_are_counted() {
    let audit = evaluate(&graph(), Fault::MixLosesOne, &Settings::default()).pictures[0].audit;
    assert!(audit.nan_count > 0 && audit.hull_exits > 0, "{audit:?}");
}

#[test]
fn every_switch_gives_the_same_bits() {
    let graph = graph();
    let bits = |settings: &Settings| -> Vec<u32> {
        let frame = evaluate(&graph, Fault::None, settings);
        frame.pictures[0].planes.iter().flat_map(|plane| plane.samples()).map(|v| v.to_bits()).collect()
    };
    let expected = bits(&Settings::default());
    let all = Switches::ALL;
    let off = [
        Switches::NONE,
        Switches { demand: false, ..all },
        Switches { prune: false, ..all },
        Switches { fold: false, ..all },
        Switches { merge: false, ..all },
        Switches { hoist: false, ..all },
        Switches { fuse: false, ..all },
        Switches { compile: false, ..all },
        Switches { hold: false, ..all },
        Switches { sparse: false, ..all },
    ];
    for switches in off {
        for (threads, tile) in [(1, (256, 16)), (2, (7, 3)), (3, (1, 1))] {
            let mut settings = Settings::default();
            (settings.switches, settings.threads) = (switches, threads);
            (settings.tile, settings.compile_from) = (Some(tile), 0);
            assert_eq!(bits(&settings), expected, "{switches:?} {threads} {tile:?}");
        }
    }
}

#[test]
fn the_reference_agrees() {
    let graph = graph();
    let frame = evaluate(&graph, Fault::None, &Settings::default());
    let reference = ReferenceFrame::new(&graph, "beauty", 1).unwrap();
    for x in 0..50 {
        let expected = reference.pixel(x, 7).unwrap();
        for (plane, expected) in frame.pictures[0].planes.iter().zip(expected) {
            assert!((f64::from(plane.nearest(x, 7)) - expected).abs() < 1e-6, "{x}");
        }
    }
}
