//! Certifies adaptive sampling: the reference is the mean of all samples, also where the picture keeps the first one.

use super::tally::CertifiedTile;
use crate::Plan;
use crate::planning::plan::Pass;
use crate::running::adaptive::{Contrast, around, is_adaptive};
use fearless_simd::Level;
use trochoid_graph::Bound;
use trochoid_image::Window;

/// Channels of an output, over a window.
type Channels = Vec<Vec<f32>>;

/// All samples of a tile, by output.
pub(super) struct AdaptiveTile {
    tile: Window,
    /// Pixels over which the first sample is known.
    pub(super) around: Window,
    tolerance: f32,
    /// Outputs that may keep first samples.
    is_adaptive: Vec<bool>,
    /// First samples over these pixels.
    first: Vec<Channels>,
    /// By sample: values and encoded bounds over the tile.
    samples: Vec<[Vec<Channels>; 2]>,
}

impl AdaptiveTile {
    pub(super) fn new(plan: &Plan<'_>, pass: &Pass, tile: Window, tolerance: f32) -> Self {
        let samples = Vec::with_capacity(pass.offsets.len());
        let is_adaptive = (0..plan.outputs.len()).map(|output| is_adaptive(plan, output)).collect();
        Self { tile, around: around(plan, tile), tolerance, is_adaptive, first: Vec::new(), samples }
    }

    /// Keeps the next sample, which covers the pixels around the tile if it is the first one.
    pub(super) fn keep(&mut self, sample: usize, values: Vec<Channels>, bounds: Vec<Channels>) {
        if sample > 0 {
            self.samples.push([values, bounds]);
            return;
        }
        let crop = |plane: &Vec<f32>| cropped(plane, self.around, self.tile);
        let within = |outputs: &[Channels]| outputs.iter().map(|planes| planes.iter().map(crop).collect()).collect();
        self.samples.push([within(&values), within(&bounds)]);
        self.first = values;
    }

    /// Adds all samples of an output to its tile. Where the picture keeps the first sample, it is off by its distance from
    /// the mean, besides what the samples are off by.
    pub(super) fn certify(&mut self, output: usize, own: &mut CertifiedTile, share: f64) {
        let mut differs = vec![!self.is_adaptive[output]; self.tile.area()];
        let mut contrast = Contrast::default();
        for first in &self.first[output] {
            contrast.mark(first, self.around, self.tile, self.tolerance, &mut differs, Level::new());
        }
        let kept: Vec<usize> = (0..differs.len()).filter(|pixel| !differs[*pixel]).collect();
        for channel in 0..self.first[output].len() {
            for pixel in &kept {
                let values = self.samples.iter().map(|[values, _]| f64::from(values[output][channel][*pixel]));
                let mean = values.sum::<f64>() * share;
                let first = f64::from(self.samples[0][0][output][channel][*pixel]);
                let off = if first == mean { 0.0 } else { (first - mean).abs() };
                if off == 0.0 {
                    continue;
                }
                for [_, bounds] in &mut self.samples {
                    let bound = &mut bounds[output][channel][*pixel];
                    let own = Bound::decode(*bound);
                    *bound = match off.is_finite() {
                        true => Bound::of(own.size + off).with(own.clear).encode(),
                        false => Bound::UNKNOWN.encode(),
                    };
                }
            }
        }
        for [values, bounds] in &self.samples {
            own.sample(&values[output], &bounds[output], share);
        }
        own.average(share);
        // Like sums, without −0.
        for (values, first) in own.values.iter_mut().zip(&self.samples[0][0][output]) {
            kept.iter().for_each(|pixel| values[*pixel] = f64::from(first[*pixel]) + 0.0);
        }
    }
}

/// Returns the part of a plane over a window within its own.
fn cropped(plane: &[f32], from: Window, to: Window) -> Vec<f32> {
    let start = (to.y0 - from.y0) as usize * from.width() + (to.x0 - from.x0) as usize;
    let rows = plane[start..].chunks(from.width()).take(to.height());
    rows.flat_map(|row| &row[..to.width()]).copied().collect()
}
