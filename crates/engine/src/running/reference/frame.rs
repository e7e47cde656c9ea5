//! Evaluates whole frames by the references.

use super::{PixelEvaluation, ReferenceError, ReferenceFrame};
use crate::judge::nan_count;
use crate::running::memory::Pictures;
use crate::running::prepare::prepare;
use crate::running::run::WorkerTotals;
use crate::{Buffers, Cache, EvalError, Frame, Monitor, Phases, Plan, Sink};
use rayon::prelude::*;
use std::sync::atomic::{AtomicUsize, Ordering};
use std::time::Instant;
use trochoid_graph::Kind;
use trochoid_image::Window;
use trochoid_weights::Audit;

impl Plan<'_> {
    /// Evaluates the outputs of the plan by the f64 references of the nodes, pixel by pixel, and rounds the averages
    /// of their samples to f32. This is thousands of times slower than [`Plan::evaluate`], or than
    /// [`Plan::evaluate_to`] if a sink is given.
    ///
    /// From the plan it only takes what to evaluate; its reports on nodes are its own.
    ///
    /// # Errors
    /// Same as [`Plan::evaluate`]; or a plan without anything left out takes too much memory.
    pub fn evaluate_by_reference(
        &self,
        sink: Option<&dyn Sink>,
        cache: &mut Cache,
        monitor: &dyn Monitor,
    ) -> Result<Frame, ReferenceError> {
        let started = Instant::now();
        let outputs = self.outputs.iter().map(|output| self.graph.outputs()[output.index].name.as_str());
        let outputs: Vec<&str> = outputs.collect();
        let limit = self.settings.memory_limit;
        let reference = ReferenceFrame::bounded(self.graph, &outputs, self.frame(), limit, cache, monitor)?;
        let (ready, _) = prepare(self, cache, monitor, Pictures::Whole)?;
        let judges: Vec<_> = self.outputs.iter().map(|output| self.judge(output, &ready, &Buffers::new())).collect();
        let prepare = started.elapsed().as_secs_f64();
        let started = Instant::now();
        let mut pictures = self.allocate(Vec::new())?;
        let mut totals = WorkerTotals::default();
        totals.audits.resize(self.outputs.len(), Audit::default());
        let window = self.window;
        let (done, total) = (AtomicUsize::new(0), window.height());
        let rows: Result<Vec<Vec<ReferenceRow>>, EvalError> = (window.y0..window.y1)
            .into_par_iter()
            .map(|y| {
                let row = row(&reference, window, y, monitor)?;
                monitor.progress(done.fetch_add(1, Ordering::Relaxed) + 1, total);
                Ok(row)
            })
            .collect();
        for (y, outputs) in rows?.iter().enumerate() {
            for (index, row) in outputs.iter().enumerate() {
                let mut audit = Audit { pixels: window.width() as u64, ..Audit::default() };
                match (&judges[index], &row[..]) {
                    (Some(judge), [r, g, b]) => audit = Audit { pixels: audit.pixels, ..judge.row([r, g, b]) },
                    _ => audit.nan_count = nan_count(&row.iter().map(Vec::as_slice).collect::<Vec<_>>()),
                }
                if let Kind::Weights(_) = self.outputs[index].kind {
                    totals.weigh(row);
                }
                totals.audits[index] = totals.audits[index].merge(audit);
                for (plane, row) in pictures[index].iter_mut().zip(row) {
                    plane.samples_mut()[y * row.len()..][..row.len()].copy_from_slice(row);
                }
            }
        }
        if let Some(sink) = sink {
            for band in window.tiles(window.width(), sink.rows().max(1)) {
                let start = (band.y0 - window.y0) as usize * window.width();
                let rows = pictures
                    .iter()
                    .map(|planes| planes.iter().map(|plane| &plane.samples()[start..start + band.area()]).collect());
                sink.take(band, &rows.collect::<Vec<_>>())?;
            }
            pictures.iter_mut().for_each(Vec::clear);
        }
        let seconds = Phases { prepare, hull: 0.0, tiles: started.elapsed().as_secs_f64() };
        let mut frame = self.assemble(judges, &totals, &ready, &[], seconds);
        for (picture, planes) in frame.pictures.iter_mut().zip(pictures) {
            picture.planes = planes;
        }
        Ok(frame)
    }
}

/// A row of an output, by channel.
type ReferenceRow = Vec<Vec<f32>>;

/// Returns a row of each output.
fn row(
    reference: &ReferenceFrame<'_>,
    window: Window,
    y: i64,
    monitor: &dyn Monitor,
) -> Result<Vec<ReferenceRow>, EvalError> {
    let mut rows: Vec<ReferenceRow> = vec![Vec::new(); reference.plan.outputs.len()];
    for x in window.x0..window.x1 {
        if monitor.cancelled() {
            return Err(EvalError::Cancelled);
        }
        let pixels = PixelEvaluation::new(reference, monitor).outputs(rows.len(), [x, y], &mut |_| ());
        for (row, pixel) in rows.iter_mut().zip(pixels) {
            let pixel = pixel?;
            row.resize(pixel.len(), Vec::new());
            row.iter_mut().zip(pixel).for_each(|(row, value)| row.push(value as f32));
        }
    }
    Ok(rows)
}

impl WorkerTotals {
    /// Audits a row of weights, given by weight.
    fn weigh(&mut self, row: &[Vec<f32>]) {
        for x in 0..row.first().map_or(0, Vec::len) {
            let weights = row.iter().map(|row| row[x]);
            self.weights.min = weights.clone().fold(self.weights.min, f32::min);
            // A mask stores only one of its two weights.
            if row.len() > 1 {
                let off = (weights.map(f64::from).sum::<f64>() - 1.0).abs();
                self.weights.max_deviation = self.weights.max_deviation.max(off);
            }
        }
    }
}
