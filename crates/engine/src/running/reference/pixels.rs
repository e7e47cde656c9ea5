//! Evaluates what a check of finished pictures needs from the references: many pixels, the weights on the way to
//! them, and the control colors. Nothing here looks at a program, a tile or a plane.

use super::{PixelEvaluation, PointOutputs, ReferenceFrame};
use crate::{EvalError, Monitor};
use rayon::prelude::*;
use std::sync::atomic::{AtomicUsize, Ordering};
use trochoid_graph::{Body, Kind, Reference, References, Source, literal};
use trochoid_image::Rgb;

/// Number of pixels that a thread takes at once.
const PIECE: usize = 16;

/// The outputs of a pixel.
type ReferencesOfPixel = Vec<Result<ReferencePixel, EvalError>>;

/// A pixel computed by the references.
#[derive(Clone, Debug, PartialEq)]
pub struct ReferencePixel {
    /// Mean over the samples that the fast path averages, by channel.
    pub value: Vec<f64>,
    /// Smallest weight that any node returned at any of the samples; +∞ if no node returned weights.
    pub weight_min: f64,
    /// Largest |Σω − 1| of those weights.
    pub weight_sum_max_deviation: f64,
}

impl ReferencePixel {
    /// Records the weights that a node returned.
    fn see(&mut self, given: &Reference) {
        match given {
            // The two weights 1 − t and t sum to 1 by definition.
            Reference::Mask(t) => self.weight_min = self.weight_min.min(t.min(1.0 - t)),
            Reference::Weights(weights) => {
                self.weight_min = weights.iter().copied().fold(self.weight_min, f64::min);
                let deviation = (weights.iter().sum::<f64>() - 1.0).abs();
                self.weight_sum_max_deviation = self.weight_sum_max_deviation.max(deviation);
            }
            _ => {}
        }
    }
}

impl ReferenceFrame<'_> {
    /// Evaluates every output at some pixels, like [`ReferenceFrame::pixel`], and records the weights on the way; on
    /// all threads. Returns the outputs of each pixel.
    ///
    /// # Errors
    /// Same as [`ReferenceFrame::sample`]; or the monitor asked to stop.
    pub fn pixels(&self, places: &[[i64; 2]], monitor: &dyn Monitor) -> Result<Vec<Vec<ReferencePixel>>, EvalError> {
        let pixels = self.pixels_or_errors(places, monitor)?;
        pixels.into_iter().map(|outputs| outputs.into_iter().collect()).collect()
    }

    /// Does the same, with `None` where a node gives up a reference because it takes more effort than is reasonable.
    ///
    /// # Errors
    /// Same as [`ReferenceFrame::pixels`], except for these.
    pub fn pixels_in_reach(
        &self,
        places: &[[i64; 2]],
        monitor: &dyn Monitor,
    ) -> Result<Vec<Vec<Option<ReferencePixel>>>, EvalError> {
        let known = |output: Result<ReferencePixel, EvalError>| match output {
            Err(error) if error.is_given_up() => Ok(None),
            output => output.map(Some),
        };
        let pixels = self.pixels_or_errors(places, monitor)?;
        pixels.into_iter().map(|outputs| outputs.into_iter().map(known).collect()).collect()
    }

    fn pixels_or_errors(
        &self,
        places: &[[i64; 2]],
        monitor: &dyn Monitor,
    ) -> Result<Vec<ReferencesOfPixel>, EvalError> {
        let done = AtomicUsize::new(0);
        let upstream: Vec<Vec<bool>> = (0..self.plan.outputs.len()).map(|output| self.upstream(output)).collect();
        let pieces: Result<Vec<Vec<ReferencesOfPixel>>, EvalError> = places
            .par_chunks(PIECE)
            .map(|piece| {
                let seen = |&place: &[i64; 2]| {
                    if monitor.cancelled() {
                        Err(EvalError::Cancelled)
                    } else {
                        Ok(self.seen(place, &upstream, monitor))
                    }
                };
                let pixels = piece.iter().map(seen).collect();
                let done = done.fetch_add(piece.len(), Ordering::Relaxed) + piece.len();
                monitor.progress(done, places.len());
                pixels
            })
            .collect();
        Ok(pieces?.into_iter().flatten().collect())
    }

    /// Returns which nodes an output depends on.
    fn upstream(&self, output: usize) -> Vec<bool> {
        let graph = self.plan.graph;
        let spec = &graph.outputs()[self.plan.outputs[output].index];
        graph.dependencies([spec.node], self.plan.frame())
    }

    fn seen(&self, place: [i64; 2], upstream: &[Vec<bool>], monitor: &dyn Monitor) -> ReferencesOfPixel {
        let none = ReferencePixel { value: Vec::new(), weight_min: f64::INFINITY, weight_sum_max_deviation: 0.0 };
        let mut pixels = vec![none; upstream.len()];
        let mut show = |known: &PointOutputs| {
            for (pixel, upstream) in pixels.iter_mut().zip(upstream) {
                let given = known.iter().filter(|((id, _), _)| upstream[id.0]).flat_map(|(_, given)| given);
                given.for_each(|given| pixel.see(given));
            }
        };
        let values = PixelEvaluation::new(self, monitor).outputs(upstream.len(), place, &mut show);
        pixels.into_iter().zip(values).map(|(pixel, value)| Ok(ReferencePixel { value: value?, ..pixel })).collect()
    }

    /// Returns every color that an output, by its place among those requested, is mixed from. The colors are found by
    /// following its Color connections: literals, colors that nodes make themselves, and colors that stages declare as
    /// controls.
    pub fn controls(&self, output: usize) -> Vec<Rgb> {
        let graph = self.plan.graph;
        let spec = &graph.outputs()[self.plan.outputs[output].index];
        let mut colors = Vec::new();
        let mut add = |color: &[f64]| colors.push([0, 1, 2].map(|c| literal(color[c]) + 0.0));
        let mut seen = vec![false; graph.nodes().len()];
        let mut open = vec![spec.node];
        while let Some(id) = open.pop() {
            let Some(settled) = self.plan.settled[id.0].as_ref().filter(|_| !std::mem::replace(&mut seen[id.0], true))
            else {
                continue;
            };
            let before = open.len();
            let mut takes_color = false;
            let mut take = |source: &Source<Vec<f64>>| match source {
                Source::Color(color) => {
                    takes_color = true;
                    add(color);
                }
                Source::Output { node, output } if graph.node(*node).kinds[*output] == Kind::Color => open.push(*node),
                _ => {}
            };
            match settled.node().identity() {
                Some(source) => take(source),
                None => settled.each_source(&mut take),
            }
            takes_color |= open.len() > before;
            match settled.node().body() {
                // A node without color inputs makes its own color, the same everywhere.
                Body::Pointwise(pointwise) if !takes_color => {
                    let nothing = |source: &Source<Vec<f64>>, _: [f64; 2]| self.nothing(source);
                    let inputs = References::new(&self.plan.context, [0.5; 2], &nothing);
                    if let Reference::Color(color) = pointwise.reference(&inputs) {
                        add(&color);
                    }
                }
                Body::Pointwise(_) => {}
                Body::Stage(_) => {
                    let controls = self.ready.get(&id).map(|ready| ready.prepared.controls());
                    controls.unwrap_or_default().iter().for_each(|color| add(&color.map(f64::from)));
                }
            }
        }
        colors
    }

    fn nothing(&self, source: &Source<Vec<f64>>) -> Reference {
        match source {
            Source::Output { node, output } => super::nothing(self.plan.graph.node(*node).kinds[*output]),
            _ => Reference::Mask(0.0),
        }
    }
}
