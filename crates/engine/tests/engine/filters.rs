//! Tests of filters in the engine: halos, controls, and a broken kernel that must be noticed.

use crate::nodes;
use std::path::Path;
use trochoid_engine::inside::mix_levels;
use trochoid_engine::{Buffers, Cache, Frame, Plan, ReferenceFrame, Settings, Silent, Switches};
use trochoid_graph::*;
use trochoid_image::{Format, Window};

/// A blend of each pixel with the two to its left and right: a quarter, a half, a quarter.
///
/// # Formula
/// # Edge cases
/// # Source
#[derive(Clone, Node)]
#[node(stage, end = Back, revision = 1, output(image: Kind::Color = ""))]
pub(super) struct Smear {
    /// Color to blend.
    image: One<port::Color>,
}

/// The same, of whole rows if there are any.
///
/// # Formula
/// # Edge cases
/// # Source
#[derive(Clone, Node)]
#[node(stage, end = Back, revision = 1, output(image: Kind::Color = ""))]
struct SmearOfRows {
    /// Color to blend.
    image: One<port::Color>,
}

/// A blend with a negative lobe, which no filter may have.
///
/// # Formula
/// # Edge cases
/// # Source
#[derive(Clone, Node)]
#[node(stage, end = Back, revision = 1, output(image: Kind::Color = ""))]
struct Sharpen {
    /// Color to sharpen.
    image: One<port::Color>,
}

macro_rules! filter {
    ($ty:ident, $lobe:literal, $takes_whole_rows:literal) => {
        impl Node for $ty {}

        impl Stage for $ty {
            fn regions_of_interest(&self, _port: PortId, window: Window, _format: Format) -> Window {
                Window { x0: window.x0 - 2, x1: window.x1 + 2, ..window }
            }
            fn takes_whole_rows(&self) -> bool {
                $takes_whole_rows
            }
            fn prepare(&self, _prepare: &Prepare<'_>) -> Result<Box<dyn Prepared>, NodeError> {
                Ok(Box::new(Blended { image: self.image.clone(), lobe: $lobe }))
            }
        }
    };
}

filter!(Smear, 0.25, false);
filter!(SmearOfRows, 0.25, true);
filter!(Sharpen, -0.25, false);

pub(super) static TYPES: [NodeType; 3] =
    [NodeType::of::<Smear>(), NodeType::of::<SmearOfRows>(), NodeType::of::<Sharpen>()];

struct Blended {
    image: One<port::Color>,
    lobe: f32,
}

impl Prepared for Blended {
    fn fill(&self, block: &Block<'_>, inputs: &Inputs<'_>, outputs: &mut Outputs<'_>) -> Result<(), NodeError> {
        let image = &inputs.all(&self.image)[0];
        let (from, window) = (image.window, block.window);
        assert!(from.intersect(image.extent) == from && from.intersect(window) == window);
        for channel in 0..3 {
            let (Some(out), Some(samples)) = (outputs.only(channel), image.planes[channel]) else { continue };
            assert_eq!((out.len(), samples.len()), (window.area(), from.area()));
            for (index, out) in out.iter_mut().enumerate() {
                let (x, y) = (window.x0 + (index % window.width()) as i64, (index / window.width()) as i64);
                let row = &samples[(window.y0 - from.y0 + y) as usize * from.width()..];
                let at = |x: i64| row[(x.clamp(from.x0, from.x1 - 1) - from.x0) as usize];
                *out = self.lobe * at(x - 2) + (1.0 - 2.0 * self.lobe) * at(x) + self.lobe * at(x + 2);
            }
        }
        Ok(())
    }

    fn reference(&self, inputs: &References<'_>) -> Result<Vec<Reference>, NodeError> {
        let at = |dx: f64| inputs.moved(dx, 0.0).color(&self.image);
        let (left, here, right, lobe) = (at(-2.0), at(0.0), at(2.0), f64::from(self.lobe));
        Ok(vec![Reference::Color([0, 1, 2].map(|c| lobe * left[c] + (1.0 - 2.0 * lobe) * here[c] + lobe * right[c]))])
    }
}

fn graph(last: &str) -> CheckedGraph {
    graph_of(last, 4)
}

fn graph_of(last: &str, samples: u32) -> CheckedGraph {
    let text = format!(
        r##"{{ "trochoid": 1, "format": {{ "width": 31, "height": 5, "samples": {samples} }},
        "nodes": {{
            "slope": {{ "type": "Slope" }}, "gate": {{ "type": "Gate", "field": "slope" }},
            "mix": {{ "type": "Mix", "a": [0, 0.5, 1], "b": [1, 0.25, 0], "weight": "gate" }},
            "first": {{ "type": "Smear", "image": "mix" }},
            "again": {{ "type": "Mix", "a": "first", "b": "mix", "weight": "gate" }},
            "last": {{ "type": "{last}", "image": "again" }} }},
        "outputs": {{ "last": {{ "color": "last" }} }} }}"##
    );
    let document = Document::parse("test", &text).unwrap();
    let (graph, diagnostics) = check(&document, &Registry::new(nodes::TYPES.iter().chain(&TYPES)), Path::new("."));
    graph.unwrap_or_else(|| panic!("{diagnostics:?}"))
}

fn evaluate(graph: &CheckedGraph, settings: &Settings) -> Frame {
    let plan = Plan::new(graph, &["last"], 1, &[], settings).unwrap();
    assert_eq!(plan.halo(), (4, 0));
    plan.evaluate(&Buffers::new(), &mut Cache::new(), &Silent).unwrap()
}

#[test]
fn tiles_share_what_lies_between_them() {
    let graph = graph("Smear");
    let expected = evaluate(&graph, &Settings::default());
    for samples in [1, 4] {
        let expected = evaluate(&graph_of("Smear", samples), &Settings::default());
        for (last, switches) in [
            ("Smear", Switches::ALL),
            ("Smear", Switches::NONE),
            ("SmearOfRows", Switches::ALL),
            ("SmearOfRows", Switches::NONE),
        ] {
            let graph = graph_of(last, samples);
            for (threads, tile) in [(1, (1, 1)), (2, (7, 3)), (1, (1000, 1000))] {
                let mut settings = Settings::default();
                (settings.switches, settings.threads, settings.tile) = (switches, threads, Some(tile));
                let found = evaluate(&graph, &settings);
                assert_eq!(found.pictures[0].planes, expected.pictures[0].planes, "{last} {samples} {tile:?}");
            }
        }
    }
    let reference = ReferenceFrame::new(&graph, "last", 1).unwrap();
    for x in [0, 1, 15, 30] {
        for (plane, truth) in expected.pictures[0].planes.iter().zip(reference.pixel(x, 2).unwrap()) {
            assert!((f64::from(plane.nearest(x, 2)) - truth).abs() < 1e-6, "{x}");
        }
    }
}

#[test]
fn a_negative_lobe_leaves_the_hull_of_what_is_filtered() {
    let sound = evaluate(&graph("Smear"), &Settings::default()).pictures.remove(0);
    assert_eq!((sound.control_count, sound.audit.hull_exits), (2, 0));
    // Two mixes and two filters.
    let levels = mix_levels(&Plan::new(&graph("Smear"), &[], 1, &[], &Settings::default()).unwrap());
    assert_eq!(levels, 4);
    let broken = evaluate(&graph("Sharpen"), &Settings::default()).pictures.remove(0);
    assert_eq!(broken.control_count, 2);
    assert!(broken.audit.hull_exits > 10 && broken.audit.worst_exit > 0.01, "{:?}", broken.audit);
}
