//! What a pixel is made of.

use super::lens::Lens;
use super::subject::Subject;
use trochoid::{Buffers, Cache, Monitor, Plan, Settings};

/// A question about a pixel of a picture.
#[derive(Clone, Debug)]
pub struct Question {
    /// Of which picture: told again with the answer.
    pub generation: u64,
    /// What was looked at.
    pub subject: Subject,
    /// The frame.
    pub frame: i64,
    /// By how much the picture is smaller than the document's.
    pub shrunk: u32,
    /// Where the pixel lies, in shares of the picture's width and height.
    pub at: [f32; 2],
}

/// The answer.
#[derive(Clone, Debug, PartialEq)]
pub struct Blamed {
    /// Of which picture.
    pub generation: u64,
    /// The frame.
    pub frame: i64,
    /// Where the pixel was asked for.
    pub at: [f32; 2],
    /// The pixel.
    pub pixel: [i64; 2],
    /// Its value by channel, in the working space for colors.
    pub value: Vec<f64>,
    /// The control colors of a Color, the greatest share first; the shares sum to 1. Empty for anything else.
    pub shares: Vec<Share>,
}

/// A control color's share of a pixel.
#[derive(Clone, Debug, PartialEq)]
pub struct Share {
    /// The node that holds the color.
    pub node: String,
    /// The color, in the working space.
    pub color: [f64; 3],
    /// From 0 to 1.
    pub weight: f64,
}

/// The pixel at a place in shares of a picture.
pub fn pixel(at: [f32; 2], size: [u32; 2]) -> [i64; 2] {
    [0, 1].map(|axis| {
        let side = i64::from(size[axis]);
        ((f64::from(at[axis]) * side as f64).floor() as i64).clamp(0, side - 1)
    })
}

/// Asks a lens for what a pixel is made of; `None` where that cannot be told.
pub(super) fn answer(question: &Question, lens: &Lens, cache: &mut Cache, monitor: &dyn Monitor) -> Option<Blamed> {
    let graph = lens.drawn(question.shrunk, true).ok()?;
    let format = graph.format();
    let pixel = pixel(question.at, [format.width(), format.height()]);
    let plan = Plan::new(&graph, &[super::lens::OUTPUT], question.frame, &[], &Settings::default()).ok()?;
    let output = plan.outputs().first().copied()?;
    let found = plan.inspect(output, pixel, &Buffers::new(), cache, monitor).ok()??;
    let shares = found.blame.iter().map(|share| Share {
        node: graph.node(share.node).name.clone(),
        color: share.color,
        weight: share.weight,
    });
    let mut shares: Vec<Share> = merged(shares);
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

/// Colors of one node that differ by less than this in every channel are one: nobody tells them apart.
const SAME: f64 = 1.0 / 256.0;

/// The shares of colors that can be told apart: a node that makes colors gives every sample of a pixel one of its own.
fn merged(shares: impl Iterator<Item = Share>) -> Vec<Share> {
    let mut all: Vec<Share> = Vec::new();
    for share in shares {
        let is_same = |own: &&mut Share| {
            let near = own.color.iter().zip(share.color).all(|(a, b)| (a - b).abs() < SAME);
            own.node == share.node && near
        };
        match all.iter_mut().find(is_same) {
            // The greatest share lends its color.
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
    fn colors_of_one_node_that_nobody_tells_apart_are_one() {
        let share = |node: &str, red: f64, weight: f64| Share { node: node.into(), color: [red, 0.5, 0.25], weight };
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
