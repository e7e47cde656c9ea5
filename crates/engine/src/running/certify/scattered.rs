//! Certifies single pixels, wherever they are in the picture.

use super::{Certification, CertifiedTile, Certifier, OutputFacts};
use crate::planning::plan::PlannedOutput;
use crate::running::memory::Pictures;
use crate::running::prepare::prepare;
use crate::{Buffers, Cache, EvalError, Monitor};
use rayon::prelude::*;
use std::collections::BTreeMap;
use trochoid_graph::{Bound, NodeId};
use trochoid_image::{Rgb, Window};

/// Cost of a pixel that is certified alone, in pixels of a whole tile: a stage sets up its work for each window.
const ALONE: usize = 4;

/// What is certified of single pixels of an output. Lists have the order in which the pixels were requested.
#[derive(Clone, Debug, PartialEq)]
pub struct CertifiedPixels {
    /// The output's index in the graph.
    pub output: usize,
    /// Value of the picture at each pixel, by channel: the bits that [`Plan::evaluate`](crate::Plan::evaluate) gives.
    pub values: Vec<Vec<f32>>,
    /// As in [`Certified::errors`](crate::Certified::errors).
    pub errors: Vec<Vec<f32>>,
    /// As in [`Certified::infinite`](crate::Certified::infinite).
    pub infinite: Vec<Vec<bool>>,
    /// As in [`Certified::doubt`](crate::Certified::doubt).
    pub doubt: Vec<f32>,
    /// As in [`Certified::palette`](crate::Certified::palette).
    pub palette: Vec<Rgb>,
    /// As in [`Certified::margin`](crate::Certified::margin).
    pub margin: f64,
    /// As in [`Certified::unbounded`](crate::Certified::unbounded), if any pixels were requested.
    pub unbounded: Vec<(NodeId, &'static str)>,
}

impl Certifier<'_> {
    /// Bounds the error of every sample of some pixels, for every output, on all threads. Values and bounds are, bit
    /// for bit, those of these pixels in [`Certifier::certify`].
    ///
    /// # Errors
    /// Same as [`Plan::evaluate`](crate::Plan::evaluate).
    ///
    /// # Panics
    /// A pixel is outside of the region that is certified.
    pub fn certify_pixels(
        &self,
        pixels: &[[i64; 2]],
        buffers: &Buffers<'_>,
        cache: &mut Cache,
        monitor: &dyn Monitor,
    ) -> Result<Vec<CertifiedPixels>, EvalError> {
        let plan = &self.plan;
        plan.in_pool(|| {
            plan.validate_all(buffers)?;
            let (ready, _) = prepare(plan, cache, monitor, Pictures::Whole)?;
            let groups = self.groups(pixels);
            let run = Certification::new(&ready, buffers, groups.len(), monitor);
            let parts: Result<Vec<Vec<PixelOfOutputs>>, EvalError> = groups
                .par_chunks(run.share(groups.len()))
                .map(|groups| {
                    let windows: Vec<Window> = groups.iter().map(|group| group.window).collect();
                    let mut found = Vec::new();
                    let done = self.tiles(&windows, &run, &mut |index, tiles| {
                        let group = &groups[index];
                        let pixel = |index: &usize| PixelOfOutputs::of(&tiles, pixels[*index], *index);
                        found.extend(group.pixels.iter().map(pixel));
                    });
                    done.map(|()| found)
                })
                .collect();
            let parts: Vec<PixelOfOutputs> = parts?.into_iter().flatten().collect();
            let all = plan.outputs.iter().zip(self.facts(run)).enumerate().map(|(place, (output, facts))| {
                let mut certified = CertifiedPixels::new(output, facts, pixels.len());
                parts.iter().for_each(|pixel| certified.put(pixel.index, &pixel.outputs[place]));
                certified
            });
            Ok(all.collect())
        })
    }

    /// Divides pixels into windows to certify: a tile of the picture if it holds so many of them that it costs less
    /// than they do one by one, with what filters read around each.
    fn groups(&self, pixels: &[[i64; 2]]) -> Vec<PixelGroup> {
        let (across, down) = self.plan.halo();
        let cost = |width: usize, height: usize| (width + 2 * across) * (height + 2 * down);
        let tiles: Vec<Window> = self.grid().collect();
        let mut by_tile: BTreeMap<usize, Vec<usize>> = BTreeMap::new();
        let [width, height] = tiles.first().map_or([1, 1], |tile| [tile.width(), tile.height()]);
        let columns = self.plan.window.width().div_ceil(width);
        for (index, [x, y]) in pixels.iter().enumerate() {
            let place = [x - self.plan.window.x0, y - self.plan.window.y0].map(|along| along as usize);
            by_tile.entry(place[1] / height * columns + place[0] / width).or_default().push(index);
        }
        let mut groups = Vec::new();
        for (tile, held) in by_tile {
            let window = tiles[tile];
            if held.len() * ALONE * cost(1, 1) >= cost(window.width(), window.height()) {
                groups.push(PixelGroup { window, pixels: held });
                continue;
            }
            groups.extend(held.into_iter().map(|index| {
                let [x, y] = pixels[index];
                PixelGroup { window: Window::new(x, y, x + 1, y + 1), pixels: vec![index] }
            }));
        }
        groups
    }
}

/// Window to certify, and the requested pixels within it, by index.
struct PixelGroup {
    window: Window,
    pixels: Vec<usize>,
}

/// A pixel of every output.
struct PixelOfOutputs {
    /// Its index among the requested pixels.
    index: usize,
    outputs: Vec<PixelOfOutput>,
}

/// A pixel of one output, by channel.
struct PixelOfOutput {
    values: Vec<f32>,
    errors: Vec<f32>,
    infinite: Vec<bool>,
    doubt: f32,
}

impl PixelOfOutputs {
    /// Takes a pixel from a tile that contains it.
    fn of(tiles: &[CertifiedTile], [x, y]: [i64; 2], index: usize) -> Self {
        let outputs = tiles.iter().map(|CertifiedTile { bounds, values }| {
            let window = bounds.window;
            let at = (y - window.y0) as usize * window.width() + (x - window.x0) as usize;
            PixelOfOutput {
                values: values.iter().map(|channel| channel[at] as f32).collect(),
                errors: bounds.errors.iter().map(|channel| channel[at]).collect(),
                infinite: bounds.infinite.iter().map(|channel| channel[at]).collect(),
                doubt: bounds.doubt[at],
            }
        });
        Self { index, outputs: outputs.collect() }
    }
}

impl CertifiedPixels {
    fn new(output: &PlannedOutput, facts: OutputFacts, count: usize) -> Self {
        let OutputFacts { palette, margin, unbounded, limit } = facts;
        let channels = output.kind.channels();
        Self {
            output: output.index,
            values: vec![vec![0.0; count]; channels],
            // Each pixel's own bound is put in its place, or stays at the limit.
            errors: vec![vec![Bound::of(limit).encode(); count]; channels],
            infinite: vec![vec![false; count]; if output.kind.is_finite() { 0 } else { channels }],
            doubt: vec![0.0; count],
            palette,
            margin,
            unbounded,
        }
    }

    fn put(&mut self, index: usize, pixel: &PixelOfOutput) {
        self.values.iter_mut().zip(&pixel.values).for_each(|(plane, value)| plane[index] = *value);
        self.errors.iter_mut().zip(&pixel.errors).for_each(|(plane, error)| plane[index] = error.min(plane[index]));
        self.infinite.iter_mut().zip(&pixel.infinite).for_each(|(plane, is)| plane[index] = *is);
        self.doubt[index] = pixel.doubt;
    }
}
