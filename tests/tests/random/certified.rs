//! Graphs of all back-end nodes, fields and filters over hostile and inexact passes, with one or more samples: every
//! pixel lies within its own bound of the reference, neither names nor order of nodes change anything, and the
//! certificate of every honest picture holds.

use super::FRAME;
use super::draw::{Drawn, Kind, Style};
use super::more::{inputs, node, passes};
use super::one_plan::{accounts, results};
use super::pixels::{HEIGHT, WIDTH};
use super::shuffled::shuffled;
use crate::certificates::faults;
use crate::support::{evaluate, graph_in, settings, write_exr};
use rand::SeedableRng;
use rand::seq::IndexedRandom;
use rand_pcg::Pcg64Mcg;
use trochoid::{Buffers, Cache, Certifier, CheckedGraph, ReferenceFrame, Silent};

/// Number of graphs by default.
const GRAPHS: u64 = 20;

/// Bounds divided by errors where there are errors, and the number of samples in doubt.
#[derive(Default)]
struct Tally {
    ratios: Vec<f64>,
    pixels: u64,
    unclear: u64,
    endless: u64,
}

/// Compares every pixel with the reference.
fn outside(graph: &CheckedGraph, tally: &mut Tally) -> Vec<String> {
    let frame = evaluate(graph, FRAME, &Buffers::new(), &settings(|_| ()));
    let certifier = Certifier::new(graph, &[], FRAME, &[], &settings(|_| ())).unwrap();
    let certified = certifier.certify(&Buffers::new(), &mut Cache::new(), &Silent).unwrap();
    let mut faults = Vec::new();
    for (picture, certified) in frame.pictures.iter().zip(&certified) {
        let name = &graph.outputs()[picture.output].name;
        let reference = ReferenceFrame::new(graph, name, FRAME).unwrap();
        for at in 0..WIDTH * HEIGHT {
            let truth = reference.pixel((at % WIDTH) as i64, (at / WIDTH) as i64).unwrap();
            for (channel, truth) in truth.iter().enumerate() {
                let found = f64::from(picture.planes[channel].samples()[at]);
                let error = if found == *truth { 0.0 } else { (found - truth).abs() };
                let bound = f64::from(certified.errors[channel][at]);
                if error > bound || error.is_nan() && bound < f64::INFINITY {
                    faults.push(format!(
                        "{name}, channel {channel} of pixel {at}: {found:e} is {error:e} from {truth:e}, certified {bound:e}"
                    ));
                }
                tally.pixels += 1;
                tally.endless += u64::from(bound == f64::INFINITY);
                if certified.doubt[at] > 0.0 {
                    tally.unclear += 1;
                } else if error > 1e-9 * truth.abs() && bound < f64::INFINITY {
                    tally.ratios.push(bound / error);
                }
            }
        }
    }
    faults
}

#[test]
fn every_pixel_lies_within_its_bound_whatever_nodes_are_called() {
    let count = super::count(GRAPHS);
    let folder = tempfile::tempdir().unwrap();
    let (mut tally, mut all) = (Tally::default(), Vec::new());
    let inputs = inputs();
    for seed in 0..count {
        let mut random = Pcg64Mcg::seed_from_u64(seed);
        let pixels = passes(&mut random);
        let file = format!("{seed}.exr");
        write_exr(&folder.path().join(&file), WIDTH as u32, HEIGHT as u32, &pixels.channels());
        let samples = [
            "",
            r#", "samples": 4"#,
            r#", "samples": 16"#,
            r#", "samples": 4, "shading": "pixel""#,
            r#", "samples": 4, "adaptive": 0.1"#,
            r#", "samples": 4, "shading": "pixel", "adaptive": 0.1"#,
        ];
        let style = Style {
            inputs: &inputs,
            counts: &[4, 12, 30],
            node,
            format: samples.choose(&mut random).copied().unwrap_or(""),
            output: r#", "precision": "float""#,
            outputs: &[Kind::Mask, Kind::Weights(0), Kind::Field],
        };
        let drawn = Drawn::in_style(&mut random, &file, &style);
        let graph = graph_in(folder.path(), &drawn.text);
        let (text, names) = shuffled(&drawn.text, &mut random);
        let other = graph_in(folder.path(), &text);
        let mut found = outside(&graph, &mut tally);
        let expected = accounts(&graph, &[], &settings(|_| ()), Some(&names));
        if accounts(&other, &[], &settings(|_| ()), None) != expected {
            found.push("another plan".into());
        }
        if results(&graph) != results(&other) {
            found.push("another picture or bound".into());
        }
        found.extend(faults(&other, FRAME));
        if !found.is_empty() {
            let more = found.len().saturating_sub(3);
            found.truncate(3);
            all.push(format!("graph {seed}: {}, and {more} more\n{}", found.join("\n"), drawn.text));
        }
    }
    tally.ratios.sort_by(f64::total_cmp);
    let ratio = |share: f64| tally.ratios.get((share * tally.ratios.len() as f64) as usize).copied().unwrap_or(0.0);
    println!(
        "{count} graphs, {} failed; {} values, {} in doubt, {} without a bound; bound/error: least {:.3}, median {:.2}, 90 % {:.1}",
        all.len(),
        tally.pixels,
        tally.unclear,
        tally.endless,
        ratio(0.0),
        ratio(0.5),
        ratio(0.9)
    );
    assert!(all.is_empty(), "{} of {count}: {}", all.len(), all.join("\n\n"));
    // A bound that says nothing holds too.
    assert!(ratio(0.5) < 10.0 && 2 * tally.unclear < tally.pixels && 4 * tally.endless < tally.pixels);
}
