//! Composition of a pixel: the control colors it is mixed from.

use super::lens::Lens;
use super::mixture::LIMIT;
use super::subject::Subject;
use trochoid::{Buffers, Cache, CheckedGraph, InspectedPixel, Kind, Monitor, PackedRecipe, Plan, Settings, Window};

/// Request for the composition of a pixel.
#[derive(Clone, Debug)]
pub struct Question {
    /// Generation number of the picture, repeated in the answer.
    pub generation: u64,
    /// The viewed result.
    pub subject: Subject,
    /// The frame.
    pub frame: i64,
    /// Factor by which the picture is smaller than the document's.
    pub shrunk: u32,
    /// Place of the pixel, in fractions of the picture's width and height.
    pub at: [f32; 2],
}

/// Composition of a pixel.
#[derive(Clone, Debug, PartialEq)]
pub struct Blamed {
    /// Generation number of the picture.
    pub generation: u64,
    /// The frame.
    pub frame: i64,
    /// Place that was asked for.
    pub at: [f32; 2],
    /// Pixel coordinates.
    pub pixel: [i64; 2],
    /// Value per channel; colors are in the working space.
    pub value: Vec<f64>,
    /// Control colors of a Color pixel, largest weight first; weights sum to 1. Empty for other kinds.
    pub shares: Vec<Share>,
}

/// Where a control color comes from.
#[derive(Clone, Debug, PartialEq, Eq)]
pub enum Origin {
    /// The palette, by the color's name.
    Palette(String),
    /// A node that has the color, or that makes colors.
    Node(String),
    /// Pictures that the document reads.
    Pictures,
}

/// Weight of a control color in a pixel.
#[derive(Clone, Debug, PartialEq)]
pub struct Share {
    /// Where the color comes from.
    pub of: Origin,
    /// The color, in the working space.
    pub color: [f64; 3],
    /// Weight, from 0 to 1.
    pub weight: f64,
}

/// Returns the pixel at a place in fractions of a picture.
pub fn pixel(at: [f32; 2], size: [u32; 2]) -> [i64; 2] {
    [0, 1].map(|axis| {
        let side = i64::from(size[axis]);
        ((f64::from(at[axis]) * side as f64).floor() as i64).clamp(0, side - 1)
    })
}

/// Determines the composition of a pixel; returns `None` if it cannot be determined.
pub(super) fn answer(question: &Question, lens: &Lens, cache: &mut Cache, monitor: &dyn Monitor) -> Option<Blamed> {
    let graph = lens.drawn(question.shrunk, true).ok()?;
    let format = graph.format();
    let pixel = pixel(question.at, [format.width(), format.height()]);
    let plan = Plan::new(&graph, &[super::lens::OUTPUT], question.frame, &[], &Settings::default()).ok()?;
    let output = plan.outputs().first().copied()?;
    let found = plan.inspect(output, pixel, &Buffers::new(), cache, monitor).ok()??;
    let mut shares = match named(&graph, output, question.frame, pixel, &found.value, cache, monitor) {
        Some(shares) => shares,
        None => by_node(&graph, &found),
    };
    shares.sort_by(|a, b| b.weight.total_cmp(&a.weight));
    Some(Blamed {
        generation: question.generation,
        frame: question.frame,
        at: question.at,
        pixel,
        value: found.value,
        shares,
    })
}

/// Returns the weights of the colors that the document names and writes, through all filters and strokes; `None` if the
/// picture has no recipe.
fn named(
    graph: &CheckedGraph,
    output: usize,
    frame: i64,
    [x, y]: [i64; 2],
    value: &[f64],
    cache: &mut Cache,
    monitor: &dyn Monitor,
) -> Option<Vec<Share>> {
    if graph.outputs()[output].kind != Kind::Color {
        return None;
    }
    let region = Some(Window::new(x, y, x + 1, y + 1));
    let recipe = PackedRecipe::evaluate(graph, output, frame, region, LIMIT, cache, monitor).ok()?;
    let info = recipe.info();
    let origin = |name: &String| {
        let has = |node: &str| name.strip_prefix(node).is_some_and(|item| item.starts_with('.'));
        let nodes = graph.nodes().iter().map(|node| &node.name).filter(|node| has(node));
        match nodes.max_by_key(|node| node.len()) {
            Some(node) => Origin::Node(node.clone()),
            None => Origin::Palette(name.clone()),
        }
    };
    let mut rest = [0, 1, 2].map(|channel| value.get(channel).copied().unwrap_or_default());
    let mut shares = Vec::new();
    for (place, weight) in recipe.at(x, y) {
        let weight = f64::from(weight);
        // Pictures come last: what the colors leave of the pixel is theirs.
        let (of, color) = match info.names.get(place) {
            Some(name) => (origin(name), info.colors[place]),
            None => (Origin::Pictures, rest.map(|channel| channel / weight)),
        };
        (0..3).for_each(|channel| rest[channel] -= weight * color[channel]);
        shares.push(Share { of, color, weight });
    }
    Some(shares)
}

/// Returns the weights of the colors that nodes contribute, as far as they can be told apart.
fn by_node(graph: &CheckedGraph, found: &InspectedPixel) -> Vec<Share> {
    merged(found.blame.iter().map(|share| Share {
        of: Origin::Node(graph.node(share.node).name.clone()),
        color: share.color,
        weight: share.weight,
    }))
}

/// Colors of one node that differ by less than this in every channel count as the same.
const SAME: f64 = 1.0 / 256.0;

/// Merges the weights of indistinguishable colors: a node that generates colors contributes a slightly different one
/// for each sample of a pixel.
fn merged(shares: impl Iterator<Item = Share>) -> Vec<Share> {
    let mut all: Vec<Share> = Vec::new();
    for share in shares {
        let is_same = |own: &&mut Share| {
            let near = own.color.iter().zip(share.color).all(|(a, b)| (a - b).abs() < SAME);
            own.of == share.of && near
        };
        match all.iter_mut().find(is_same) {
            // The first share found keeps its color.
            Some(own) => own.weight += share.weight,
            None => all.push(share),
        }
    }
    all
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn colors_of_one_node_that_look_alike_are_merged() {
        let share = |node: &str, red: f64, weight: f64| Share {
            of: Origin::Node(node.into()),
            color: [red, 0.5, 0.25],
            weight,
        };
        let all = [
            share("painted", 0.8738, 0.25),
            share("painted", 0.8736, 0.25),
            share("painted", 0.8, 0.125),
            share("other", 0.8738, 0.125),
            share("painted", 0.874, 0.25),
        ];
        let wanted = [share("painted", 0.8738, 0.75), share("painted", 0.8, 0.125), share("other", 0.8738, 0.125)];
        assert_eq!(merged(all.into_iter()), wanted);
    }
}
