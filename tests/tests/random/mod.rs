//! Random valid graphs of back-end nodes over hostile pixels, each compared with an independent evaluation.
//!
//! For each graph: no pixel leaves the box of its own controls, exactly, nor the hull of all; the fast path errs by no
//! more than the bound of [`bound`]; buffers and files give the same bits; and so do all settings.

mod bound;
mod certified;
mod draw;
mod groups;
mod more;
mod one_plan;
mod pixels;
mod refused;
mod shuffled;
mod text;

use crate::support::{all_bits, evaluate, graph_in, settings, under_all_settings, write_exr};
use bound::Value;
pub(crate) use draw::Drawn;
pub(crate) use pixels::{AREA, HEIGHT, Pixels, WIDTH};
use rand::SeedableRng;
use rand_pcg::Pcg64Mcg;
use trochoid::{Buffers, Cache, Certifier, CheckedGraph, Frame, ReferenceFrame, Silent, State};

/// Number of graphs by default.
const GRAPHS: u64 = 400;
/// Number of graphs that are shuffled.
const PLANS: u64 = 300;
/// Frame at which keyframed knobs have the generated values.
const FRAME: i64 = 2;

/// Returns the number of graphs: that of the environment variable `TROCHOID_GRAPHS`, or the default.
fn count(default: u64) -> u64 {
    std::env::var("TROCHOID_GRAPHS").map_or(default, |count| count.parse().unwrap())
}

/// Statistics over many graphs, which reveal a generator that produces nothing of interest.
#[derive(Default)]
struct Tally {
    pixels: usize,
    pruned: usize,
    merged: usize,
    deepest: usize,
    loosest: f64,
    /// Ratios of certified to measured errors.
    ratios: Vec<f64>,
    clear: u64,
    doubtful: u64,
}

fn within(seed: u64, drawn: &Drawn, frame: &Frame, pixels: &Pixels, graph: &CheckedGraph, tally: &mut Tally) {
    for picture in &frame.pictures {
        let spec = &graph.outputs()[picture.output];
        let node = drawn.outputs[picture.output];
        let reference = ReferenceFrame::new(graph, &spec.name, FRAME).unwrap();
        assert_eq!(picture.audit.hull_exits, 0, "graph {seed}: {} leaves the hull\n{}", spec.name, drawn.text);
        assert_eq!(picture.audit.nan_count, 0, "graph {seed}: NaN in {}", spec.name);
        assert_eq!(picture.audit.weight_sum_max_deviation, 0.0, "graph {seed}");
        assert!(picture.audit.weight_min >= 0.0, "graph {seed}: a weight of {}", picture.audit.weight_min);
        for at in 0..WIDTH * HEIGHT {
            let (x, y) = ((at % WIDTH) as i64, (at / WIDTH) as i64);
            let found: Vec<f32> = picture.planes.iter().map(|plane| plane.samples()[at]).collect();
            let values = bound::evaluate(drawn, pixels, at);
            // The reference is slow, so it is compared at every seventh pixel, at others in each graph.
            let truth = if (at as u64 + seed).is_multiple_of(7) { Some(reference.pixel(x, y).unwrap()) } else { None };
            let expected = values[node].channels();
            assert_eq!(found.len(), expected.len(), "graph {seed}: {}", spec.name);
            for (channel, (found, expected)) in found.iter().zip(&expected).enumerate() {
                let place = || format!("graph {seed}: {}, channel {channel} of pixel {at}\n{}", spec.name, drawn.text);
                let error = (f64::from(*found) - expected.value).abs();
                // f64 rounds too, on each of the levels.
                let bound = expected.error + 1e-12 * expected.high.abs();
                assert!(error <= bound, "{error:e} > {bound:e}: {found:e}, not {:e}: {}", expected.value, place());
                if let Some(truth) = &truth {
                    let error = (f64::from(*found) - truth[channel]).abs();
                    assert!(error <= bound, "{error:e} > {bound:e}: {found:e}, not {truth:?}: {}", place());
                }
                // At an uncertain threshold the bound is the box, which says nothing about rounding.
                if bound > 0.0 && bound < 1e-5 * expected.high {
                    tally.loosest = tally.loosest.max(error / bound);
                }
            }
            if let Value::Color(color) = &values[node] {
                for (found, (low, high)) in found.iter().zip(color.low.iter().zip(&color.high)) {
                    assert!(low <= found && found <= high, "graph {seed}: {found} not in [{low}, {high}]");
                }
            }
            tally.pixels += 1;
        }
    }
}

/// Checks that the certified error of every sample holds, and is not much larger than the measured one.
fn certified(seed: u64, drawn: &Drawn, frame: &Frame, buffers: &Buffers<'_>, graph: &CheckedGraph, tally: &mut Tally) {
    let certifier = Certifier::new(graph, &[], FRAME, &buffers.names(), &settings(|_| ())).unwrap();
    let certified = certifier.certify(buffers, &mut Cache::new(), &Silent).unwrap();
    for (picture, certified) in frame.pictures.iter().zip(&certified) {
        let name = &graph.outputs()[picture.output].name;
        assert_eq!(picture.output, certified.output);
        let reference = ReferenceFrame::new(graph, name, FRAME).unwrap();
        for at in (seed as usize % 7..WIDTH * HEIGHT).step_by(7) {
            let truth = reference.pixel((at % WIDTH) as i64, (at / WIDTH) as i64).unwrap();
            for (channel, truth) in truth.iter().enumerate() {
                let found = f64::from(picture.planes[channel].samples()[at]);
                let error = if found == *truth { 0.0 } else { (found - truth).abs() };
                let bound = f64::from(certified.errors[channel][at]);
                assert!(
                    error <= bound,
                    "graph {seed}: {name}, channel {channel} of pixel {at}: {found:e} is {error:e} from the reference, \
                     certified {bound:e}\n{}",
                    drawn.text
                );
                if certified.doubt[at] == 0.0 && error > 1e-9 {
                    tally.ratios.push(bound / error);
                }
            }
        }
        tally.doubtful += certified.unclear.total();
        tally.clear += certified.clear.total();
    }
}

#[test]
fn random_graphs_hold_every_promise() {
    let folder = tempfile::tempdir().unwrap();
    let mut tally = Tally::default();
    let count = count(GRAPHS);
    for seed in 0..count {
        let mut random = Pcg64Mcg::seed_from_u64(seed);
        let pixels = Pixels::draw(&mut random);
        let file = format!("{seed}.exr");
        write_exr(&folder.path().join(&file), WIDTH as u32, HEIGHT as u32, &pixels.channels());
        let drawn = Drawn::draw(&mut random, &file);
        let graph = graph_in(folder.path(), &drawn.text);
        let buffers = pixels.buffers(&graph);
        let frame = under_all_settings(&graph, FRAME, &buffers, &format!("graph {seed}: {}", drawn.text));
        let read = evaluate(&graph, FRAME, &Buffers::new(), &settings(|_| ()));
        assert_eq!(all_bits(&frame), all_bits(&read), "graph {seed}: buffers and files differ\n{}", drawn.text);
        within(seed, &drawn, &frame, &pixels, &graph, &mut tally);
        certified(seed, &drawn, &frame, &buffers, &graph, &mut tally);
        let states = read.nodes.iter().map(|report| &report.state);
        for state in states {
            match state {
                State::LeftOut(trochoid::LeftOut::Weight(_)) => tally.pruned += 1,
                State::LeftOut(trochoid::LeftOut::SameAs(_)) => tally.merged += 1,
                _ => {}
            }
        }
        tally.deepest = tally.deepest.max(drawn.depth);
    }
    assert!(tally.pixels as u64 > count * 48, "{} pixels", tally.pixels);
    assert!(tally.pruned > 20, "{} nodes pruned", tally.pruned);
    assert!(tally.merged > 20, "{} nodes merged", tally.merged);
    assert!(tally.deepest >= 40, "the deepest graph has {} levels", tally.deepest);
    tally.ratios.sort_by(f64::total_cmp);
    let median = tally.ratios[tally.ratios.len() / 2];
    assert!(
        tally.ratios.len() as u64 > 5 * count && median < 10.0,
        "{median} times the error found, of {}",
        tally.ratios.len()
    );
    let share = tally.doubtful as f64 / (tally.clear + tally.doubtful) as f64;
    assert!(share > 0.0 && share < 0.1, "{share} of the samples are in doubt");
    // A bound far above all errors would prove little.
    assert!((0.2..=1.0).contains(&tally.loosest), "the worst error is {} of its bound", tally.loosest);
}
