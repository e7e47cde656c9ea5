//! Cost of checking and planning documents of ten thousand nodes.

#![allow(clippy::unwrap_used, missing_docs, reason = "a benchmark may panic")]

#[path = "../../../tests/tests/support/large.rs"]
mod large;

use divan::{Bencher, black_box};
use std::path::Path;
use trochoid::{CheckedGraph, Plan, Settings, parse};

const COUNT: usize = 10_000;

/// Returns the document of this shape.
fn text(shape: &str) -> String {
    let make = if shape == "chain" { large::chain } else { large::web };
    make(COUNT, (64, 64))
}

fn graph(text: &str) -> CheckedGraph {
    parse("large.json", text, Path::new("."), &[]).unwrap().graph
}

fn main() {
    divan::main();
}

#[divan::bench(args = ["chain", "web"])]
fn check(bencher: Bencher<'_, '_>, shape: &str) {
    let text = text(shape);
    bencher.bench(|| graph(black_box(&text)));
}

#[divan::bench(args = ["chain", "web"])]
fn plan(bencher: Bencher<'_, '_>, shape: &str) {
    let graph = graph(&text(shape));
    let settings = Settings::default();
    bencher.bench(|| {
        let plan = Plan::new(black_box(&graph), &[], 1, &[], &settings).unwrap();
        black_box(plan.left_out().len())
    });
}
