//! Tests the error bounds of every stage against its reference. Inputs and bounds on them are drawn at random, both
//! extreme and smooth ones; the reference gets any values within the bounds.

mod cases;
mod draws;

use crate::testing::{Frame, graph};
use cases::{Case, FILES, IMAGES, LIT, PATTERNS, SCENE, VIEWS};
use draws::{Draws, Given, How};
use std::collections::HashMap;
use trochoid_graph::*;
use trochoid_image::{Format, Window};
use trochoid_io::{ExrChannel, ExrImage, Samples, write_exr};
use trochoid_memory::Scratch;

/// Results of testing a case.
#[derive(Default)]
struct Found {
    /// Errors beyond their bounds.
    faults: Vec<String>,
    /// Bound divided by error, where there is an error and the bound is clear.
    ratios: Vec<f64>,
    /// Number of clear bounds.
    clear: usize,
    /// Number of infinite bounds.
    endless: usize,
    all: usize,
}

impl Found {
    fn median(&mut self) -> f64 {
        self.ratios.sort_by(f64::total_cmp);
        self.ratios.get(self.ratios.len() / 2).copied().unwrap_or(0.0)
    }
}

/// Tests a node on inputs drawn from a seed, with bounds divided by `tighter`.
fn hold(frame: &Frame, how: How, seed: u64, tighter: f64) -> Found {
    let mut draws = Draws(seed.wrapping_mul(0x9e37_79b9_7f4a_7c15) | 1);
    let id = frame.graph.find("out").unwrap();
    let (node, prepared) = (frame.graph.settle(id, frame.context.frame), frame.prepared[id.0].as_ref().unwrap());
    let stage = node.stage().unwrap();
    let picture = frame.context.format.window();
    // A list, since references ask for these inputs millions of times, and there are few.
    let mut given: Vec<((NodeId, usize), Given)> = Vec::new();
    let mut ports: Vec<Vec<(NodeId, usize)>> = Vec::new();
    for (index, (port, connected)) in node.ports().enumerate() {
        let mut sources = Vec::new();
        for source in connected {
            let Source::Output { node: from, output } = source else { panic!("connect {port} to a node") };
            let kind = frame.graph.node(*from).kinds[*output];
            let window =
                stage.regions_of_interest(PortId::new(index, port), picture, frame.context.format).intersect(picture);
            let new = Given::new(&mut draws, how, kind, window);
            let source = (*from, *output);
            assert!(
                given.iter().all(|(other, _)| *other != source) || kind.channels() == 0,
                "two ports share a source"
            );
            given.push((source, new));
            sources.push(source);
        }
        ports.push(sources);
    }
    let block = Block::of(picture, [draws.unit(), draws.unit()]);
    let planes = |bounds: bool| -> HashMap<(NodeId, usize), Vec<Vec<f32>>> {
        let of = |given: &Given| given.planes(|drawn| if bounds { drawn.bound.encode() } else { drawn.value });
        given.iter().map(|(source, given)| (*source, of(given))).collect()
    };
    let (values, bounds) = (planes(false), planes(true));
    fn connect<'a>(
        ports: &[Vec<(NodeId, usize)>],
        planes: &'a HashMap<(NodeId, usize), Vec<Vec<f32>>>,
        window: Window,
    ) -> Vec<Scratch<Connection<'a>>> {
        let connection = |source: &(NodeId, usize)| Connection {
            planes: planes[source].iter().map(|plane| Some(&plane[..])).collect(),
            window,
            extent: window,
        };
        ports.iter().map(|sources| sources.iter().map(connection).collect()).collect()
    }
    let (values, bounds) = (connect(&ports, &values, picture), connect(&ports, &bounds, picture));
    let (inputs, limits) = (Inputs::new(&values), Inputs::new(&bounds));
    let kinds = &frame.graph.node(id).kinds;
    let memory = || -> Vec<Vec<Vec<f32>>> {
        kinds.iter().map(|kind| vec![vec![f32::NAN; picture.area()]; kind.channels()]).collect()
    };
    fn lend(memory: &mut [Vec<Vec<f32>>]) -> Outputs<'_> {
        Outputs::new(memory.iter_mut().map(|planes| planes.iter_mut().map(|plane| Some(&mut plane[..]))))
    }
    let (mut filled, mut certain) = (memory(), memory());
    prepared.fill(&block, &inputs, &mut lend(&mut filled)).unwrap();
    let lent: Vec<Vec<Option<&[f32]>>> =
        filled.iter().map(|planes| planes.iter().map(|plane| Some(&plane[..])).collect()).collect();
    let bounding = Bounding { block: &block, inputs: &inputs, bounds: &limits, filled: &lent };
    prepared.bound(&bounding, &mut lend(&mut certain)).unwrap();

    let mut found = Found::default();
    let mut errors: HashMap<(usize, usize, usize), f64> = HashMap::new();
    for _ in 0..6 {
        for (sample, at) in block.places().enumerate() {
            let upstream = |source: &Source<Vec<f64>>, at: [f64; 2]| {
                let Source::Output { node, output } = source else { unreachable!("literals stand for themselves") };
                given.iter().find(|(source, _)| *source == (*node, *output)).unwrap().1.reference(at)
            };
            let outputs = prepared.reference(&References::new(&frame.context, at, &upstream)).unwrap();
            for (output, value) in outputs.into_iter().enumerate() {
                let numbers = match value {
                    Reference::Color(color) => color.to_vec(),
                    Reference::Mask(t) => vec![t],
                    Reference::Weights(values) | Reference::Field(values) | Reference::View(values) => values,
                    Reference::Handle(_) => Vec::new(),
                };
                for (channel, truth) in numbers.into_iter().enumerate() {
                    let value = f64::from(filled[output][channel][sample]);
                    let bound = Bound::decode(certain[output][channel][sample]);
                    let error = if value == truth { 0.0 } else { (value - truth).abs() };
                    if error.is_nan() || error > bound.size / tighter {
                        found.faults.push(format!(
                            "output {output}, channel {channel}, sample {sample} of seed {seed}: {value}, the reference \
                             says {truth}: {error:e} beyond {bound:?}"
                        ));
                    }
                    let most = errors.entry((output, channel, sample)).or_default();
                    *most = most.max(error);
                }
            }
        }
        given.iter_mut().for_each(|(_, given)| given.redraw(&mut draws));
    }
    for ((output, channel, sample), error) in errors {
        let bound = Bound::decode(certain[output][channel][sample]);
        found.all += 1;
        found.clear += usize::from(bound.clear);
        found.endless += usize::from(bound.size.is_infinite());
        // Smooth inputs have no jumps, so small errors of the inputs must give small bounds.
        if how == How::Smooth && bound.clear && bound.size > 0.2 {
            found
                .faults
                .push(format!("{bound:?} for sure, where inputs are certain, at sample {sample} of seed {seed}"));
        }
        if error > 0.0 && bound.clear && bound.size.is_finite() {
            found.ratios.push(bound.size / error);
        }
    }
    found
}

/// Prepares the frame of a case, with an image file `a.exr` next to its document.
fn frame(case: &Case) -> Frame {
    let folder = tempfile::tempdir().unwrap();
    let mut draws = Draws(5);
    let samples: Vec<f32> = (0..35).map(|_| draws.unit() as f32).collect();
    let channel = |name: &str| ExrChannel::float(name, Samples::contiguous(&samples));
    let channels = ["R", "G", "B"].map(channel).to_vec();
    write_exr(folder.path().join("a.exr"), &ExrImage { channels, ..ExrImage::new(Window::sized(7, 5)) }).unwrap();
    let graph = graph(case.key, &format!("{SCENE} {}", case.nodes), folder.path()).unwrap();
    Frame::new(graph.with_format(Format::new(16, 9, 1).unwrap())).unwrap()
}

fn hold_all(cases: &[Case]) {
    for case in cases {
        let frame = frame(case);
        let (mut endless, mut all) = (0, 0);
        for seed in 1..=60 {
            let found = hold(&frame, How::Hostile, seed, 1.0);
            assert!(found.faults.is_empty(), "{}: {:#?}", case.nodes, &found.faults[..found.faults.len().min(5)]);
            (endless, all) = (endless + found.endless, all + found.all);
        }
        let mut together = Found::default();
        for seed in 1..=20 {
            let found = hold(&frame, How::Smooth, seed, 1.0);
            assert!(found.faults.is_empty(), "{}: {:#?}", case.nodes, &found.faults[..found.faults.len().min(5)]);
            together.ratios.extend(found.ratios);
            together.clear += found.clear;
            together.all += found.all;
        }
        let median = together.median();
        println!(
            "{}: median {median:.2} of {}, clear {:.3}, endless {:.3} where hostile",
            case.nodes,
            together.ratios.len(),
            together.clear as f64 / together.all as f64,
            endless as f64 / all as f64
        );
        if let Some(most) = case.tight {
            assert!(
                median <= most && together.ratios.len() > 100,
                "{}: {median} of {}",
                case.nodes,
                together.ratios.len()
            );
            assert!(2 * together.clear > together.all, "{}: most is in doubt", case.nodes);
        }
    }
}

#[test]
fn what_views_show_lies_within_its_bounds() {
    hold_all(VIEWS);
}

#[test]
fn pictures_lie_within_their_bounds() {
    hold_all(FILES);
}

#[test]
fn filtered_images_lie_within_their_bounds() {
    hold_all(IMAGES);
}

#[test]
fn what_light_gives_lies_within_its_bounds() {
    hold_all(LIT);
}

#[test]
fn patterns_lie_within_their_bounds() {
    hold_all(PATTERNS);
}

#[test]
fn bounds_that_are_too_small_are_found() {
    for case in [LIT, PATTERNS, VIEWS, IMAGES, FILES].into_iter().flatten().filter(|case| case.tight.is_some()) {
        let frame = frame(case);
        assert!((1..9).any(|seed| !hold(&frame, How::Smooth, seed, 20.0).faults.is_empty()), "{}", case.nodes);
    }
}
