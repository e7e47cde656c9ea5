//! What is known of the errors of a picture.

use trochoid_graph::{Bound, Kind, NodeId, REFERENCE};
use trochoid_image::{Rgb, Window};

/// How many samples have bounds of which size.
#[derive(Clone, Debug, PartialEq)]
pub struct Distribution {
    /// By size: see [`bucket`].
    counts: Vec<u64>,
    total: u64,
    max: f64,
    /// What no error can pass, whatever its bound.
    limit: f64,
}

/// A number's leading bits, which order as it does: its exponent and four bits more, so 16 to the octave.
const SHIFT: u32 = 48;
/// Of the least and of the greatest number told apart, 2⁻⁶⁰ and 2⁶⁰.
const LEAST: u64 = (1023 - 60) << 4;
const GREATEST: u64 = (1023 + 60) << 4;
/// Bucket 0 holds 0.
const BUCKETS: usize = (GREATEST - LEAST) as usize + 2;

fn bucket(size: f64) -> usize {
    if size <= 0.0 { 0 } else { ((size.to_bits() >> SHIFT).clamp(LEAST, GREATEST) - LEAST) as usize + 1 }
}

/// What no number in a bucket reaches beyond.
fn top(bucket: usize) -> f64 {
    if bucket == 0 { 0.0 } else { f64::from_bits((bucket as u64 + LEAST) << SHIFT) }
}

impl Default for Distribution {
    fn default() -> Self {
        Self { counts: vec![0; BUCKETS], total: 0, max: 0.0, limit: f64::INFINITY }
    }
}

impl Distribution {
    fn add(&mut self, size: f64) {
        self.counts[bucket(size)] += 1;
        self.total += 1;
        self.max = self.max.max(size);
    }

    fn merge(&mut self, other: &Self) {
        self.counts.iter_mut().zip(&other.counts).for_each(|(all, own)| *all += own);
        self.total += other.total;
        self.max = self.max.max(other.max);
    }

    /// Number of samples.
    pub fn total(&self) -> u64 {
        self.total
    }

    /// The largest bound.
    pub fn max(&self) -> f64 {
        self.max.min(self.limit)
    }

    /// What this share of the bounds does not pass, at most a sixteenth of an octave too large.
    pub fn quantile(&self, share: f64) -> f64 {
        let mut left = (share.clamp(0.0, 1.0) * self.total as f64).ceil() as u64;
        for (bucket, count) in self.counts.iter().enumerate() {
            left = left.saturating_sub(*count);
            if left == 0 {
                return top(bucket).min(self.max());
            }
        }
        self.max()
    }

    /// How many bounds pass a size: at most those within a sixteenth of an octave of it too many.
    pub fn above(&self, size: f64) -> u64 {
        if self.max() <= size { 0 } else { self.counts[bucket(size)..].iter().sum() }
    }
}

/// What is certain of the errors of one output: of each sample, the largest of its channels.
#[derive(Clone, Debug)]
pub struct Certified {
    /// The output's index in the graph.
    pub output: usize,
    /// Its kind.
    pub kind: Kind,
    /// The pixels.
    pub window: Window,
    /// The bounds of samples in no doubt.
    pub clear: Distribution,
    /// Those of samples where a side of a threshold, or what is seen, is not certain. They hold as well.
    pub unclear: Distribution,
    /// The pixel of the sample with the largest bound of those in no doubt; `None` where all are 0.
    pub worst: Option<[i64; 2]>,
    /// By channel, a bound on the error of each pixel, row by row.
    pub errors: Vec<Vec<f32>>,
    /// The share of each pixel's samples that is not clear.
    pub doubt: Vec<f32>,
    /// Of a color, the corners of the hull of all control colors that it may be mixed from; no branch counts as left out.
    pub palette: Vec<Rgb>,
    /// The stages on the way to it that know no bound everywhere, and why.
    pub unbounded: Vec<(NodeId, &'static str)>,
}

impl Certified {
    pub(super) fn new(output: usize, kind: Kind, window: Window) -> Self {
        Self {
            output,
            kind,
            window,
            clear: Distribution::default(),
            unclear: Distribution::default(),
            worst: None,
            errors: vec![vec![0.0; window.area()]; kind.channels()],
            doubt: vec![0.0; window.area()],
            palette: Vec::new(),
            unbounded: Vec::new(),
        }
    }

    /// The share of samples in doubt whose bound passes a tolerance.
    pub fn in_doubt(&self, tolerance: f64) -> f64 {
        self.unclear.above(tolerance) as f64 / (self.clear.total + self.unclear.total).max(1) as f64
    }

    /// Adds what averaging the samples of pixels has rounded, which by channel are these.
    pub(super) fn average(&mut self, means: &[Vec<f64>]) {
        for (means, errors) in means.iter().zip(&mut self.errors) {
            for (mean, error) in means.iter().zip(errors) {
                let rounded = (f64::from(*mean as f32) - mean).abs() + mean.abs() * REFERENCE;
                *error = Bound::of(f64::from(*error) + rounded).encode();
            }
        }
    }

    /// Takes one sample of every pixel, which has this share of them: its bounds by channel, encoded.
    pub(super) fn sample(&mut self, channels: &[Vec<f32>], share: f64) {
        for pixel in 0..self.window.area() {
            let mut sample = Bound::EXACT;
            for (bounds, errors) in channels.iter().zip(&mut self.errors) {
                let bound = Bound::decode(bounds[pixel]);
                sample = Bound { size: sample.size.max(bound.size), clear: sample.clear && bound.clear };
                errors[pixel] = Bound::of(f64::from(errors[pixel]) + share * bound.size).encode();
            }
            if sample.clear {
                if sample.size > self.clear.max {
                    let [x, y] = [pixel % self.window.width(), pixel / self.window.width()].map(|along| along as i64);
                    self.worst = Some([self.window.x0 + x, self.window.y0 + y]);
                }
                self.clear.add(sample.size);
            } else {
                self.unclear.add(sample.size);
                self.doubt[pixel] += share as f32;
            }
        }
    }

    /// Takes what no error can pass: picture and reference lie within it.
    pub(super) fn cap(&mut self, limit: f64) {
        self.clear.limit = limit;
        self.unclear.limit = limit;
        let most = Bound::of(limit).encode();
        self.errors.iter_mut().flatten().for_each(|error| *error = error.min(most));
    }

    /// Takes a tile of the picture.
    pub(super) fn add(&mut self, part: &Self) {
        if part.clear.max > self.clear.max {
            self.worst = part.worst;
        }
        self.clear.merge(&part.clear);
        self.unclear.merge(&part.unclear);
        let (all, own) = (self.window, part.window);
        let planes = self.errors.iter_mut().zip(&part.errors).chain([(&mut self.doubt, &part.doubt)]);
        for (to, from) in planes {
            for (y, row) in (own.y0..own.y1).zip(from.chunks_exact(own.width())) {
                let start = (y - all.y0) as usize * all.width() + (own.x0 - all.x0) as usize;
                to[start..start + row.len()].copy_from_slice(row);
            }
        }
    }
}
