//! Hostile pixels: legal values that are difficult for arithmetic.

use rand::seq::IndexedRandom;
use rand::{Rng, RngExt};
use trochoid::{Buffers, CheckedGraph};

pub(crate) const WIDTH: usize = 16;
pub(crate) const HEIGHT: usize = 3;
pub(crate) const AREA: usize = WIDTH * HEIGHT;

/// Values of fields and thresholds.
pub(crate) const FIELDS: [f32; 16] = [
    0.0,
    -0.0,
    1e-45,
    -1e-40,
    f32::MIN_POSITIVE,
    0.25,
    0.5,
    0.75,
    1.0,
    -1.0,
    65504.0,
    f32::MAX,
    -f32::MAX,
    f32::INFINITY,
    f32::NEG_INFINITY,
    3.0e38,
];

const MASKS: [f32; 12] = [
    0.0,
    -0.0,
    1.0,
    0.5,
    0.5f32.next_down(),
    0.5f32.next_up(),
    1.0f32.next_down(),
    1e-45,
    f32::MIN_POSITIVE,
    5.960_464_5e-8,
    0.25,
    0.999,
];

pub(crate) const COLORS: [f32; 12] =
    [0.0, -0.0, 1e-45, 1e-40, f32::MIN_POSITIVE, 0.18, 1.0, 1.0f32.next_up(), 2.5, 65504.0, f32::MAX / 4.0, f32::MAX];

/// An input of a graph: name, kind in the document, channels.
pub(crate) type Input = (&'static str, &'static str, usize);

/// The inputs of every graph.
pub(crate) const INPUTS: [Input; 8] = [
    ("f0", "field", 1),
    ("f1", "field", 1),
    ("m0", "weights", 1),
    ("m1", "weights", 1),
    ("w3", "weights", 3),
    ("c0", "color", 3),
    ("c1", "color", 3),
    ("c2", "color", 3),
];

/// Inputs of graphs that only read files: weights with sums that are off, and data that is repaired.
pub(crate) const MORE: [Input; 5] =
    [("p2", "weights", 2), ("w5", "weights", 5), ("xf", "field", 1), ("xw", "weights", 3), ("xc", "color", 3)];

/// The planes of all inputs.
pub(crate) struct Pixels {
    /// Channel name, such as `c0_1`, and its samples.
    pub(super) planes: Vec<(String, Vec<f32>)>,
}

impl Pixels {
    pub(crate) fn draw(random: &mut impl Rng) -> Self {
        let hostile = random.random_bool(0.5);
        let one = COLORS.choose(random).copied().unwrap_or(1.0);
        Self::drawn(random, hostile, one)
    }

    /// Draws pixels whose colors are from 0 to 1, as halves hold them.
    pub(crate) fn tame(random: &mut impl Rng) -> Self {
        Self::drawn(random, false, 0.18)
    }

    fn drawn(random: &mut impl Rng, hostile: bool, one: f32) -> Self {
        let mut planes = Vec::new();
        for (name, kind, channels) in INPUTS {
            let mut rows = vec![vec![0.0f32; AREA]; channels];
            for at in 0..AREA {
                match (kind, channels) {
                    ("field", _) => {
                        let tame = random.random_range(-2.0..2.0);
                        rows[0][at] = if random.random_bool(0.6) { pick(&FIELDS, random) } else { tame };
                    }
                    ("weights", 1) => {
                        let tame = random.random_range(0.0..1.0);
                        rows[0][at] = if random.random_bool(0.6) { pick(&MASKS, random) } else { tame };
                    }
                    ("weights", _) => {
                        // Multiples of 2⁻²⁴ that sum to exactly 1.
                        let (a, b) = (random.random_range(0..=1 << 24), random.random_range(0..=1 << 24));
                        let (low, high) = (a.min(b), a.max(b));
                        for (row, part) in rows.iter_mut().zip([low, high - low, (1 << 24) - high]) {
                            row[at] = part as f32 / 16_777_216.0;
                        }
                    }
                    _ => {
                        for row in &mut rows {
                            let tame = random.random_range(0.0..1.0);
                            row[at] = if hostile { pick(&COLORS, random) } else { tame };
                            // One image has a single color, so that operands may be equal.
                            if name == "c2" {
                                row[at] = one;
                            }
                        }
                    }
                }
            }
            planes.extend(rows.into_iter().enumerate().map(|(channel, row)| (format!("{name}_{channel}"), row)));
        }
        Self { planes }
    }

    pub(crate) fn channels(&self) -> Vec<(&str, &[f32])> {
        self.planes.iter().map(|(name, plane)| (name.as_str(), plane.as_slice())).collect()
    }

    /// Returns the samples of an input at a pixel.
    pub(crate) fn at(&self, name: &str, at: usize) -> Vec<f32> {
        self.of(name).iter().map(|plane| plane[at]).collect()
    }

    fn of(&self, name: &str) -> Vec<&[f32]> {
        let own = |channel: &str| channel.rsplit_once('_').is_some_and(|(node, _)| node == name);
        self.planes.iter().filter(|(channel, _)| own(channel)).map(|(_, plane)| plane.as_slice()).collect()
    }

    /// Returns buffers for every input that the graph declares.
    pub(crate) fn buffers(&self, graph: &CheckedGraph) -> Buffers<'_> {
        let inputs = INPUTS.iter().filter(|(name, ..)| graph.find(name).is_some());
        inputs.fold(Buffers::new(), |buffers, (name, ..)| buffers.with(name, &self.of(name)))
    }
}

pub(crate) fn pick(values: &[f32], random: &mut impl Rng) -> f32 {
    values.choose(random).copied().unwrap_or_default()
}
