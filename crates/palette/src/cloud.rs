//! The colors that occur in pictures.

use crate::vector::Point;

/// Number of 8-bit colors.
const ALL: usize = 1 << 24;

/// Colors of one or more pictures, as displayed, in steps of 8 bits, each with the number of its pixels.
///
/// ```
/// let mut cloud = trochoid_palette::Cloud::new();
/// cloud.add([255, 128, 0]);
/// cloud.add_between([10.2, 20.0, 30.9]);
/// assert_eq!(cloud.pixels(), 2);
/// assert!(cloud.contains([255, 128, 0]) && cloud.contains([10, 20, 30]) && cloud.contains([11, 20, 31]));
/// ```
pub struct Cloud {
    /// Pixels of each color.
    counts: Vec<u32>,
    /// Colors that only enclose pixels between the steps.
    around: Vec<u64>,
    pixels: u64,
}

impl Default for Cloud {
    fn default() -> Self {
        Self { counts: vec![0; ALL], around: vec![0; ALL / 64], pixels: 0 }
    }
}

fn index([r, g, b]: [u8; 3]) -> usize {
    usize::from(r) << 16 | usize::from(g) << 8 | usize::from(b)
}

fn color(index: usize) -> [u8; 3] {
    [(index >> 16) as u8, (index >> 8) as u8, index as u8]
}

impl Cloud {
    /// Returns the cloud of no pixels. It takes 66 MiB.
    #[must_use]
    pub fn new() -> Self {
        Self::default()
    }

    /// Adds a pixel.
    pub fn add(&mut self, color: [u8; 3]) {
        let count = &mut self.counts[index(color)];
        *count = count.saturating_add(1);
        self.pixels += 1;
    }

    /// Adds a pixel whose channels, from 0 to 255, may lie between the steps of 8 bits; it is enclosed by the steps
    /// around it. Channels outside of that range, and those that are no number, count as the nearest step.
    pub fn add_between(&mut self, channels: [f64; 3]) {
        self.add(channels.map(|channel| channel.round() as u8));
        // What rounding to f32 does to a step does not lie between steps.
        let whole = |channel: f64| (channel - channel.round()).abs() < 1e-4;
        let end = |channel: f64, end: fn(f64) -> f64| if whole(channel) { channel.round() } else { end(channel) } as u8;
        let [low, high] = [f64::floor as fn(f64) -> f64, f64::ceil].map(|to| channels.map(|channel| end(channel, to)));
        if low == high {
            return;
        }
        for corner in 0..8 {
            let color = [0, 1, 2].map(|c| if corner >> c & 1 == 1 { high[c] } else { low[c] });
            self.around[index(color) / 64] |= 1 << (index(color) % 64);
        }
    }

    /// Adds the pixels of another cloud.
    pub fn merge(&mut self, other: &Self) {
        self.counts.iter_mut().zip(&other.counts).for_each(|(own, more)| *own = own.saturating_add(*more));
        self.around.iter_mut().zip(&other.around).for_each(|(own, more)| *own |= more);
        self.pixels += other.pixels;
    }

    /// Returns the number of pixels.
    #[must_use]
    pub fn pixels(&self) -> u64 {
        self.pixels
    }

    /// Returns whether a color is one of the cloud, or encloses a pixel between the steps.
    #[must_use]
    pub fn contains(&self, color: [u8; 3]) -> bool {
        let index = index(color);
        self.counts[index] > 0 || self.around[index / 64] >> (index % 64) & 1 == 1
    }

    /// Returns the colors that have pixels, with their numbers.
    pub fn colors(&self) -> impl Iterator<Item = ([u8; 3], u32)> {
        self.counts.iter().enumerate().filter(|(_, count)| **count > 0).map(|(index, count)| (color(index), *count))
    }

    /// Returns the cloud of some of its colors, with the steps around those of their pixels that lie between steps.
    pub(crate) fn keeping(&self, colors: impl Iterator<Item = ([u8; 3], u32)>) -> Self {
        let mut kept = Self::new();
        for (color, count) in colors {
            kept.counts[index(color)] = count;
            kept.pixels += u64::from(count);
            let near = color.map(|v| v.saturating_sub(1)..=v.saturating_add(1));
            for r in near[0].clone() {
                for g in near[1].clone() {
                    for b in near[2].clone() {
                        let at = index([r, g, b]);
                        kept.around[at / 64] |= self.around[at / 64] & 1 << (at % 64);
                    }
                }
            }
        }
        kept
    }

    /// Returns all colors that a palette has to enclose.
    pub(crate) fn enclosed(&self) -> impl Iterator<Item = [u8; 3]> {
        (0..ALL).map(color).filter(|color| self.contains(*color))
    }

    /// Returns the colors among which the corners of the hull are: the least and the greatest on each line along an axis.
    pub(crate) fn extremes(&self) -> Vec<Point> {
        let mut ends = vec![[(u8::MAX, u8::MIN); 1 << 16]; 3];
        let lines = |[r, g, b]: [u8; 3]| {
            let at = |a: u8, b: u8| usize::from(a) << 8 | usize::from(b);
            [(at(g, b), r), (at(r, b), g), (at(r, g), b)]
        };
        for color in self.enclosed() {
            for (ends, (line, place)) in ends.iter_mut().zip(lines(color)) {
                let (low, high) = &mut ends[line];
                (*low, *high) = ((*low).min(place), (*high).max(place));
            }
        }
        let is_end = |color: &[u8; 3]| {
            ends.iter().zip(lines(*color)).all(|(ends, (line, place))| ends[line].0 == place || ends[line].1 == place)
        };
        self.enclosed().filter(is_end).map(|color| color.map(f64::from)).collect()
    }
}
