//! Plans, pictures and certified errors do not depend on the names of nodes or on their order in the document.

use super::draw::Drawn;
use super::pixels::{HEIGHT, Pixels, WIDTH};
use super::shuffled::{Names, shuffled, told_anew};
use super::{FRAME, PLANS};
use crate::support::{bits, evaluate, graph_in, settings, write_exr};
use rand::SeedableRng;
use rand_pcg::Pcg64Mcg;
use std::collections::BTreeMap;
use trochoid::{Account, Buffers, Cache, Certifier, CheckedGraph, Plan, Settings, Silent, Switches};

/// What a plan does with each node, in words, by the node's new name.
pub(super) fn accounts(
    graph: &CheckedGraph,
    outputs: &[&str],
    settings: &Settings,
    names: Option<&Names>,
) -> BTreeMap<String, String> {
    let (plan, accounts) = Plan::explained(graph, outputs, FRAME, &[], settings).unwrap();
    let told = |account: &Account| {
        let Account { node, fate, proof, channels } = account;
        let why = &plan.left_out()[node.0];
        let (name, told) = (&graph.node(*node).name, format!("{fate:?}, {why:?}, {proof:?}, {channels:?}"));
        match names {
            Some(names) => (names[name].clone(), told_anew(&told, names)),
            None => (name.clone(), told),
        }
    };
    accounts.iter().map(told).collect()
}

/// Bits of the pictures, and of the bounds of their errors, by output.
pub(super) fn results(graph: &CheckedGraph) -> BTreeMap<String, [Vec<Vec<u32>>; 2]> {
    let frame = evaluate(graph, FRAME, &Buffers::new(), &settings(|_| ()));
    let certifier = Certifier::new(graph, &[], FRAME, &[], &settings(|_| ())).unwrap();
    let certified = certifier.certify(&Buffers::new(), &mut Cache::new(), &Silent).unwrap();
    let bounds = |errors: &[f32]| errors.iter().map(|bound| bound.to_bits()).collect();
    let both = frame.pictures.iter().zip(&certified).map(|(picture, certified)| {
        assert_eq!(picture.output, certified.output);
        let bounds = certified.errors.iter().map(|errors| bounds(errors)).collect();
        (graph.outputs()[picture.output].name.clone(), [bits(picture), bounds])
    });
    both.collect()
}

#[test]
fn names_and_order_change_neither_plan_nor_picture() {
    let folder = tempfile::tempdir().unwrap();
    let (mut merged, mut pruned) = (0, 0);
    for seed in 0..PLANS {
        let mut random = Pcg64Mcg::seed_from_u64(seed);
        let pixels = Pixels::draw(&mut random);
        let file = format!("{seed}.exr");
        write_exr(&folder.path().join(&file), WIDTH as u32, HEIGHT as u32, &pixels.channels());
        let drawn = Drawn::draw(&mut random, &file);
        let graph = graph_in(folder.path(), &drawn.text);
        let (text, names) = shuffled(&drawn.text, &mut random);
        let other = graph_in(folder.path(), &text);
        let plain = settings(|s| s.switches = Switches::NONE);
        let mut all: Vec<Vec<&str>> = vec![Vec::new()];
        all.extend(graph.outputs().iter().map(|output| vec![output.name.as_str()]));
        for settings in [settings(|_| ()), plain] {
            for outputs in &all {
                let expected = accounts(&graph, outputs, &settings, Some(&names));
                let found = accounts(&other, outputs, &settings, None);
                for (node, expected) in &expected {
                    assert_eq!(found[node], *expected, "graph {seed}: {node}\n{}\n{text}", drawn.text);
                }
                merged += expected.values().filter(|told| told.contains("SameAs") || told.contains("Merged")).count();
                pruned += expected.values().filter(|told| told.contains("Weight")).count();
            }
        }
        assert_eq!(results(&graph), results(&other), "graph {seed}\n{}\n{text}", drawn.text);
    }
    assert!(merged > 20 && pruned > 20, "{merged} nodes merged, {pruned} pruned");
}
