//! An evaluator of its own: computes pixels in f64 from the manuals alone, to hold the references and the pictures
//! against them.
//!
//! It is written from the pages of the nodes and from the chapter "Definitions", and shares no code with what it
//! judges: only this file calls Trochoid, to load documents and to get pictures, bounds and references; a test of the
//! architecture ensures that. What the manuals do not say, the evaluator cannot compute.
//!
//! Where a sample lies so near to a contour, a threshold or the edge of a stroke that rounding decides, it is left out.
//! The evaluator itself decides that, and few may be left out.

mod camera;
mod document;
mod draw;
mod evaluate;
mod filters;
mod first_hit;
mod formula;
mod keys;
mod mixes;
mod passes;
mod sea;
mod shape;
mod strokes;
mod toon;
mod vector;
mod view;

use crate::support::{evaluate, graph_in, settings};
use document::Document;
use draw::{FRAME, Family, draw};
use evaluate::Evaluator;
use rand::SeedableRng;
use rand_pcg::Pcg64Mcg;
use std::path::Path;
use trochoid::{Buffers, Cache, Certifier, ReferenceFrame, Silent};

/// Largest difference of a reference, relative to values of at least 1.
const REFERENCE: f64 = 1e-9;

/// Largest difference of a picture with strokes that do not depend on a view.
const PAINTED: f64 = 1e-4;

/// Pixels at which a document is compared, at least.
const PIXELS: usize = 14;

/// What was compared, and what occurred.
#[derive(Debug, Default)]
struct Tally {
    pixels: usize,
    left_out: usize,
    /// Largest difference of a reference.
    furthest: f64,
    faults: Vec<String>,
    sights: u64,
    overturned: u64,
    shared: u64,
    unshared: u64,
    strokes: u64,
    /// Values that tell that a pixel takes all samples, and that it keeps its first one.
    adaptive: [u64; 2],
    /// Values of pixels that did otherwise, since a steep mask made much of what a surface is off by.
    misjudged: u64,
}

fn exceeds(distance: f64, bound: f64) -> bool {
    distance > bound || distance.is_nan()
}

/// Holds some pixels of all outputs of a document against the evaluator.
fn compare(family: Family, seed: u64, tally: &mut Tally) {
    let json = draw(family, &mut Pcg64Mcg::seed_from_u64(seed));
    let graph = graph_in(Path::new("."), &json.to_string());
    let document = Document::new(&json, FRAME);
    let evaluator = Evaluator::new(&document);
    let frame = evaluate(&graph, FRAME, &Buffers::new(), &settings(|_| ()));
    let certifier = Certifier::new(&graph, &[], FRAME, &[], &settings(|_| ())).unwrap();
    let certified = certifier.certify(&Buffers::new(), &mut Cache::new(), &Silent).unwrap();
    let names: Vec<&str> = graph.outputs().iter().map(|output| output.name.as_str()).collect();
    let area = certified[0].window.area();
    let step = area / PIXELS;
    let pixels: Vec<[i64; 2]> = (seed as usize % step..area)
        .step_by(step)
        .map(|at| [at as i64 % document.width, at as i64 / document.width])
        .collect();
    let reference = ReferenceFrame::prepared(&graph, &names, FRAME, &mut Cache::new(), &Silent).unwrap();
    let references = reference.pixels(&pixels, &Silent).unwrap();
    for (pixel, references) in pixels.into_iter().zip(references) {
        let [x, y] = pixel;
        let at = (y * document.width + x) as usize;
        for ((picture, certified), reference) in frame.pictures.iter().zip(&certified).zip(references) {
            let name = names[picture.output];
            let (expected, is_near_jump) = evaluator.pixel(name, x, y);
            tally.pixels += 1;
            if is_near_jump {
                tally.left_out += 1;
                continue;
            }
            assert_eq!(reference.value.len(), expected.len(), "{family:?} {seed}: {name}");
            let is_certain = |x: i64, y: i64| {
                let is_inside = (0..document.width).contains(&x) && (0..document.height).contains(&y);
                !is_inside || certified.doubt[(y * document.width + x) as usize] == 0.0
            };
            let around = (y - 1..=y + 1).flat_map(|y| (x - 1..=x + 1).map(move |x| (x, y)));
            let is_certain = around.into_iter().all(|(x, y)| is_certain(x, y));
            let adaptive = evaluator.adaptive(name, x, y).filter(|_| is_certain);
            for (channel, (expected, found)) in expected.into_iter().zip(reference.value).enumerate() {
                let place = || format!("{family:?} {seed}: {name}, channel {channel} of pixel {pixel:?}");
                let most = REFERENCE * if expected.is_finite() { expected.abs().max(1.0) } else { 1.0 };
                let off = if found == expected { 0.0 } else { (found - expected).abs() };
                tally.furthest = tally.furthest.max(off * REFERENCE / most);
                if exceeds(off, most) {
                    tally.faults.push(format!("{}: the reference is {found}, not {expected}", place()));
                }
                let filled = f64::from(picture.planes[channel].samples()[at]);
                if let Some((first, keeps)) = &adaptive
                    // More than what passes of surfaces are off by.
                    && (first[channel] - expected).abs() > 0.02
                {
                    tally.adaptive[usize::from(*keeps)] += 1;
                    let is_kept = (filled - first[channel]).abs() < (filled - expected).abs();
                    tally.misjudged += u64::from(is_kept != *keeps);
                }
                let mut bound = f64::from(certified.errors[channel][at]) + most;
                if family == Family::Painted && document.adaptive.is_none() {
                    // Strokes have no bound that tells anything; on the picture itself, they only round.
                    bound = bound.min(PAINTED);
                }
                if filled != expected && exceeds((filled - expected).abs(), bound) {
                    tally.faults.push(format!("{}: the picture has {filled}, not {expected} ± {bound:e}", place()));
                }
            }
        }
    }
    let counts = &evaluator.counts;
    tally.sights += counts.sights.get();
    tally.overturned += counts.overturned.get();
    tally.shared += counts.shared.get();
    tally.unshared += counts.unshared.get();
    tally.strokes += counts.strokes.get();
}

/// Compares documents: by default `count`, or as many as the environment variable `TROCHOID_MANUAL` says.
fn hold(family: Family, count: u64) -> Tally {
    let count = std::env::var("TROCHOID_MANUAL").map_or(count, |count| count.parse().unwrap());
    let mut tally = Tally::default();
    for seed in 0..count {
        compare(family, seed, &mut tally);
    }
    let faults = std::mem::take(&mut tally.faults);
    println!("{family:?}: {tally:?}");
    assert!(faults.is_empty(), "{} faults\n{}", faults.len(), faults.join("\n"));
    assert!(tally.left_out * 100 <= tally.pixels, "{tally:?}");
    assert!(tally.misjudged * 100 <= tally.adaptive.iter().sum(), "{tally:?}");
    tally
}

#[test]
fn flat_pictures_are_what_the_manuals_say() {
    let tally = hold(Family::Flat, 30);
    assert!(tally.shared > 100, "{tally:?}");
    assert!(tally.adaptive[0] > 50 && tally.adaptive[1] > 5, "{tally:?}");
}

#[test]
fn seas_are_what_the_manuals_say() {
    let tally = hold(Family::Sea, 10);
    assert!(tally.sights > 2000 && tally.overturned > 5, "{tally:?}");
    assert!(tally.shared > 100 && tally.unshared > 100, "{tally:?}");
}

#[test]
fn toon_seas_are_what_the_manuals_say() {
    let tally = hold(Family::Toon, 10);
    assert!(tally.sights > 1000, "{tally:?}");
}

#[test]
fn strokes_are_what_the_manuals_say() {
    let tally = hold(Family::Painted, 20);
    assert!(tally.strokes > 300, "{tally:?}");
}

#[test]
fn strokes_on_seas_are_what_the_manuals_say() {
    let tally = hold(Family::PaintedSea, 7);
    assert!(tally.strokes > 50 && tally.sights > 2000, "{tally:?}");
}
