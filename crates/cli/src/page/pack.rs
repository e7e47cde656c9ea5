//! Frames of a page: a table of all mixes that occur, and for each pixel its place in the table.
//!
//! A browser mixes the colors of the table, not of all pixels, and looks the pixels up. Most pixels of a shot stay as they
//! are for some frames, so frames refer to a key frame before them, which a browser decodes first. Weights are stored in whole
//! numbers with the sum [`WHOLE`]. They are rounded to multiples of 1/255, or of a finer step at pixels where the picture
//! could otherwise differ by more than [`TOLERANCE`], whatever its colors are.

use super::weights::Weights;
use std::collections::HashMap;
use trochoid::WorkingSpace;

/// Sum of the weights of a pixel as they are stored.
pub(super) const WHOLE: u32 = 255 << FINEST;
/// How often steps of 1/255 can be halved.
const FINEST: u32 = 8;
/// By how much rounded weights may change a pixel, in steps of 255. Below 1, so that pixels of 8 bits differ by at most 1.
pub(super) const TOLERANCE: f64 = 0.95;

/// A frame in the form that the page reads.
pub(super) struct Packed {
    /// Number of mixes that its key frame lacks, little-endian in 4 bytes; the high bytes of their weights by color, then
    /// the low bytes; then a number for each pixel, most significant bytes first, in as many planes as the numbers need:
    /// 0 if the pixel has the mix that it has in the key frame, else 1 more than the place of its mix, which is one of the
    /// key frame's or of those that follow them.
    pub(super) bytes: Vec<u8>,
    /// Largest change of a pixel by rounding, in steps of 255, of any colors that can be displayed.
    pub(super) farthest: f64,
    /// Mean weight of each color.
    pub(super) shares: Vec<f64>,
    /// What frames may refer to, if this one does not itself.
    pub(super) key: Option<Key>,
}

/// A frame that others refer to.
pub(super) struct Key {
    /// Places of mixes.
    known: HashMap<Box<[u16]>, u32>,
    /// Places of the mixes of pixels.
    places: Vec<u32>,
}

impl Key {
    /// Returns whether a frame has the size and the number of colors of this one.
    pub(super) fn fits(&self, recipe: &Weights) -> bool {
        let count = self.known.keys().next().map_or(0, |weights| weights.len());
        self.places.len() == recipe.window.area() && count == recipe.names.len()
    }
}

/// Packs a frame; most of its pixels may be as in a key frame of the same size and colors.
pub(super) fn pack(recipe: &Weights, key: Option<&Key>) -> Packed {
    let (area, count) = (recipe.window.area(), recipe.names.len());
    let steep = steepness(recipe);
    let base = key.map_or(0, |key| key.known.len() as u32);
    let mut rounding = Rounding::new(count);
    let mut mixes: Vec<Mix> = Vec::new();
    let mut known: HashMap<Box<[u16]>, u32> = HashMap::new();
    let (mut places, mut pixel) = (vec![0_u32; area], vec![0.0; count]);
    let mut farthest: f64 = 0.0;
    for at in 0..area {
        let is_new = recipe.weights.iter().zip(&mut pixel).fold(at == 0, |is_new, (plane, weight)| {
            let differs = *weight != plane[at];
            *weight = plane[at];
            is_new || differs
        });
        // Neighbors are often equal.
        let place = if is_new {
            farthest = farthest.max(rounding.round(&pixel, steep));
            let stored = rounding.stored.as_slice();
            let place = key.and_then(|key| key.known.get(stored)).or_else(|| known.get(stored)).copied();
            place.unwrap_or_else(|| {
                let place = base + mixes.len() as u32;
                mixes.push(Mix { weights: stored.into(), pixels: 0 });
                known.insert(stored.into(), place);
                place
            })
        } else {
            places[at - 1]
        };
        places[at] = place;
        if place >= base {
            mixes[(place - base) as usize].pixels += 1;
        }
    }
    let share = |plane: &Vec<f32>| plane.iter().copied().map(f64::from).sum::<f64>() / area as f64;
    let shares = recipe.weights.iter().map(share).collect();
    rank(&mut mixes, &mut places, &mut known, base);
    let numbers = places.iter().enumerate().map(|(at, place)| match key {
        Some(key) if key.places[at] == *place => 0,
        _ => place + 1,
    });
    let bytes = bytes(&mixes, count, base, numbers);
    let key = key.is_none().then_some(Key { known, places });
    Packed { bytes, farthest, shares, key }
}

/// A mix, and the number of pixels that show it.
struct Mix {
    weights: Box<[u16]>,
    pixels: u64,
}

/// Puts the mixes of most pixels first, so that most places are small numbers.
fn rank(mixes: &mut [Mix], places: &mut [u32], known: &mut HashMap<Box<[u16]>, u32>, base: u32) {
    let mut order: Vec<u32> = (0..mixes.len() as u32).collect();
    order.sort_by_key(|mix| std::cmp::Reverse(mixes[*mix as usize].pixels));
    let mut ranks = vec![0; order.len()];
    order.iter().zip(base..).for_each(|(mix, place)| ranks[*mix as usize] = place);
    let ranked = places.iter_mut().chain(known.values_mut()).filter(|place| **place >= base);
    ranked.for_each(|place| *place = ranks[(*place - base) as usize]);
    // Stable, as above.
    mixes.sort_by_key(|mix| std::cmp::Reverse(mix.pixels));
}

/// Returns the bytes of a frame.
fn bytes(mixes: &[Mix], count: usize, base: u32, numbers: impl Iterator<Item = u32> + Clone) -> Vec<u8> {
    let planes = match base as usize + mixes.len() {
        0..=0xff => 1,
        0x100..=0xffff => 2,
        _ => 3,
    };
    let mut bytes = (mixes.len() as u32).to_le_bytes().to_vec();
    for high in [8, 0] {
        for color in 0..count {
            bytes.extend(mixes.iter().map(|mix| (mix.weights[color] >> high) as u8));
        }
    }
    for plane in (0..planes).rev() {
        bytes.extend(numbers.clone().map(|number| (number >> (8 * plane)) as u8));
    }
    bytes
}

/// Returns by how much the display of a picture changes at most, relative to its weights: the span of its colors in any
/// channel, or 1 if that is less, times the steepest slope of the encoding.
fn steepness(recipe: &Weights) -> f64 {
    let slope = if recipe.space == WorkingSpace::Srgb { 1.0 } else { 12.92 };
    let light = |color: &[f64; 3]| match recipe.space {
        WorkingSpace::Srgb => *color,
        space => space.to_linear_srgb(*color),
    };
    let colors: Vec<[f64; 3]> = recipe.colors.iter().map(light).collect();
    let span = |c: usize| {
        let (low, high) = colors.iter().fold((0.0_f64, 1.0_f64), |(low, high), of| (low.min(of[c]), high.max(of[c])));
        high - low
    };
    slope * (0..3).map(span).fold(1.0, f64::max)
}

/// Rounds the weights of pixels.
struct Rounding {
    /// The last pixel's weights, with the sum [`WHOLE`].
    stored: Vec<u16>,
    /// Parts below a step, by color.
    parts: Vec<(f64, usize)>,
}

impl Rounding {
    fn new(count: usize) -> Self {
        Self { stored: vec![0; count], parts: Vec::with_capacity(count) }
    }

    /// Rounds weights that are ≥ 0 and sum to about 1, to steps that are as coarse as they may be; returns by how much
    /// that changes the pixel at most, in steps of 255.
    fn round(&mut self, weights: &[f32], steep: f64) -> f64 {
        let sum: f64 = weights.iter().copied().map(f64::from).sum();
        let mut error = 0.0;
        for halvings in 0..=FINEST {
            self.round_to(weights, sum, halvings);
            // What some weights gain others lose: half of all changes, times the span of the colors.
            let changes = weights
                .iter()
                .zip(&self.stored)
                .map(|(exact, stored)| (f64::from(*stored) / f64::from(WHOLE) - f64::from(*exact) / sum).abs());
            error = 255.0 * steep * changes.sum::<f64>() / 2.0;
            if error <= TOLERANCE {
                break;
            }
        }
        error
    }

    /// Rounds down, and gives the steps that are left to the colors that lost most.
    fn round_to(&mut self, weights: &[f32], sum: f64, halvings: u32) {
        let steps = 255_u32 << halvings;
        let step = (WHOLE / steps) as u16;
        let mut left = steps;
        self.parts.clear();
        for (color, weight) in weights.iter().enumerate() {
            let exact = f64::from(*weight) / sum * f64::from(steps);
            let whole = exact.floor();
            self.stored[color] = whole as u16 * step;
            left = left.saturating_sub(whole as u32);
            if exact > whole {
                self.parts.push((exact - whole, color));
            }
        }
        self.parts.sort_by(|a, b| b.0.total_cmp(&a.0));
        for (_, color) in self.parts.iter().take(left as usize) {
            self.stored[*color] += step;
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use trochoid::Window;

    /// Returns a recipe of random weights, of which at most `most` a pixel are above 0.
    fn recipe(count: usize, most: usize, space: WorkingSpace) -> Weights {
        let (width, height) = (61_usize, 40_usize);
        let mut state = 1_u64;
        let mut random = || {
            state = state.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1_442_695_040_888_963_407);
            (state >> 40) as f64 / (1 << 24) as f64
        };
        let mut pixel = |_| {
            // Multiples of 2⁻¹¹ whose sum is 1, as recipes have them.
            let (mut pixel, mut left) = (vec![0.0; count], 2048);
            for turn in 0..most {
                let part = if turn + 1 == most { left } else { (f64::from(left) * random()) as u32 };
                pixel[(random() * count as f64) as usize] += part as f32 / 2048.0;
                left -= part;
            }
            pixel
        };
        let pixels: Vec<Vec<f32>> = (0..width * height).map(&mut pixel).collect();
        let weights = (0..count).map(|color| pixels.iter().map(|pixel| pixel[color]).collect()).collect();
        Weights {
            names: (0..count).map(|index| format!("c{index}")).collect(),
            colors: (0..count).map(|index| [0.0, index as f64 / count as f64, 1.0]).collect(),
            space,
            window: Window::sized(width as u32, height as u32),
            weights,
        }
    }

    /// Returns the weights of all pixels, by color, as the page reads them.
    fn unpacked(bytes: &[u8], count: usize, area: usize) -> Vec<Vec<u32>> {
        let mixes = u32::from_le_bytes(bytes[..4].try_into().unwrap()) as usize;
        let (table, places) = bytes[4..].split_at(2 * count * mixes);
        let planes: Vec<&[u8]> = places.chunks_exact(area).collect();
        assert_eq!(planes.len() * area, places.len());
        let place = |at: usize| planes.iter().fold(0, |number, plane| 256 * number + usize::from(plane[at])) - 1;
        let weight = |color: usize, at: usize| {
            let [high, low] = [color, count + color].map(|row| u32::from(table[row * mixes + place(at)]));
            256 * high + low
        };
        (0..count).map(|color| (0..area).map(|at| weight(color, at)).collect()).collect()
    }

    #[test]
    fn weights_sum_exactly_and_come_back_within_the_tolerance() {
        for (count, most) in [(1, 1), (2, 2), (4, 3), (14, 4), (24, 24), (32, 7)] {
            for space in [WorkingSpace::Srgb, WorkingSpace::LinearSrgb, WorkingSpace::AcesCg] {
                let recipe = recipe(count, most, space);
                let area = recipe.window.area();
                let packed = pack(&recipe, None);
                let steep = steepness(&recipe);
                let weights = unpacked(&packed.bytes, count, area);
                let mut farthest: f64 = 0.0;
                for at in 0..area {
                    assert_eq!(weights.iter().map(|plane| plane[at]).sum::<u32>(), WHOLE);
                    let change = |color: usize| {
                        f64::from(weights[color][at]) / f64::from(WHOLE) - f64::from(recipe.weights[color][at])
                    };
                    let gained: f64 = (0..count).map(|color| change(color).max(0.0)).sum();
                    farthest = farthest.max(255.0 * steep * gained);
                }
                assert!((farthest - packed.farthest).abs() < 1e-6, "{farthest} and {}", packed.farthest);
                assert!(farthest <= TOLERANCE, "{count}, {most}, {space}: {farthest}");
                assert!((packed.shares.iter().sum::<f64>() - 1.0).abs() < 1e-9);
            }
        }
    }

    #[test]
    fn weights_are_as_coarse_as_they_may_be() {
        let two = Weights { weights: vec![vec![0.3; 2440], vec![0.7; 2440]], ..recipe(2, 2, WorkingSpace::Srgb) };
        let packed = pack(&two, None);
        // One mix, two colors, one byte a pixel; 0.3 is 76.5 of 255 steps.
        assert_eq!(packed.bytes.len(), 4 + 2 * 2 + 2440);
        assert!(unpacked(&packed.bytes, 2, 2440)[0][7].is_multiple_of(256));
        let linear = pack(&Weights { space: WorkingSpace::LinearSrgb, ..two }, None);
        assert!(!unpacked(&linear.bytes, 2, 2440)[0][7].is_multiple_of(256) && linear.farthest <= TOLERANCE);
    }

    #[test]
    fn frames_hold_what_differs_from_their_key_frame() {
        let first = recipe(4, 3, WorkingSpace::Srgb);
        let key = pack(&first, None).key.unwrap();
        let same = pack(&first, Some(&key));
        let area = first.window.area();
        let planes = if key.known.len() < 256 { 1 } else { 2 };
        assert_eq!(same.bytes, vec![0; 4 + planes * area]);
        assert!(same.key.is_none());
        // One pixel has a mix of another one, and one has a mix that is new.
        let mut later = first.clone();
        for plane in &mut later.weights {
            plane[7] = plane[8];
            plane[9] = 0.25;
        }
        let packed = pack(&later, Some(&key));
        assert_eq!(
            (packed.bytes[..4].to_vec(), packed.bytes[4..12].to_vec()),
            (vec![1, 0, 0, 0], vec![64, 64, 64, 63, 0, 0, 0, 0])
        );
        let number = |at: usize| {
            packed.bytes[12..].chunks_exact(area).fold(0, |number, plane| 256 * number + u32::from(plane[at]))
        };
        assert_eq!((number(7), number(9)), (key.places[8] + 1, key.known.len() as u32 + 1));
        assert_eq!((0..area).filter(|at| number(*at) > 0).count(), 2);
    }

    #[test]
    fn colors_beyond_the_display_need_finer_weights() {
        let mut bright = recipe(3, 3, WorkingSpace::Srgb);
        bright.colors[1] = [-1.0, 0.0, 9.0];
        assert_eq!(steepness(&bright), 9.0);
        assert!(pack(&bright, None).farthest <= TOLERANCE);
    }
}
