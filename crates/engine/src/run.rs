//! Evaluates a plan: prepare, then tiles on all cores, judged as they are made.

use crate::frame::{Frame, NodeReport, Phases, Picture, State};
use crate::kernel::WeightAudit;
use crate::plan::PlannedOutput;
use crate::prepare::{Ready, prepare};
use crate::tile::Worker;
use crate::{Buffers, Cache, EvalError, Monitor, Plan};
use rayon::prelude::*;
use std::collections::HashMap;
use std::sync::Mutex;
use std::sync::atomic::{AtomicUsize, Ordering};
use std::time::Instant;
use trochoid_graph::{Guarantee, Kind, NodeId};
use trochoid_image::{Plane, Rgb, Window};
use trochoid_weights::{Audit, Hull, HullBuilder};

/// What a color output is judged by.
struct Judge {
    hull: Hull,
    margin: f64,
    count: usize,
    colors: Vec<Rgb>,
}

/// A band of full rows of every picture.
struct Band<'a> {
    window: Window,
    /// By output, by channel.
    rows: Vec<Vec<&'a mut [f32]>>,
}

/// What the workers report when they are done.
#[derive(Default)]
struct Tally {
    fill_seconds: Vec<f64>,
    program_seconds: f64,
    weights: WeightAudit,
    audits: Vec<Audit>,
}

impl Plan<'_> {
    /// Evaluates the plan. `buffers` supplies what was bound; `cache` keeps what the next frame can use.
    ///
    /// # Errors
    /// Input and output, illegal input data, memory, or cancellation.
    pub fn evaluate(
        &self,
        buffers: &Buffers<'_>,
        cache: &mut Cache,
        monitor: &dyn Monitor,
    ) -> Result<Frame, EvalError> {
        let pool = rayon::ThreadPoolBuilder::new()
            .num_threads(self.settings.threads)
            .build()
            .map_err(|error| EvalError::Threads(error.to_string()))?;
        pool.install(|| self.evaluate_here(buffers, cache, monitor))
    }

    fn evaluate_here(
        &self,
        buffers: &Buffers<'_>,
        cache: &mut Cache,
        monitor: &dyn Monitor,
    ) -> Result<Frame, EvalError> {
        let picture_area = self.graph.format().window().area();
        for (id, _) in self.bound.iter().enumerate().filter(|(_, bound)| **bound) {
            let node = self.graph.node(NodeId(id));
            buffers.validate(&node.name, node.kinds[0], picture_area)?;
        }
        let started = Instant::now();
        let ready = prepare(self, cache, monitor)?;
        let prepared = started.elapsed().as_secs_f64();
        let started = Instant::now();
        let judges: Vec<Option<Judge>> =
            self.outputs.iter().map(|output| self.judge(output, &ready, buffers)).collect();
        let judged = started.elapsed().as_secs_f64();
        let started = Instant::now();
        let mut pictures = self.allocate()?;
        let tally = self.tiles(&mut pictures, &ready, buffers, &judges, monitor)?;
        let seconds = Phases { prepare: prepared, hull: judged, tiles: started.elapsed().as_secs_f64() };
        Ok(self.assemble(pictures, judges, &tally, &ready, seconds))
    }

    /// The hull of every control color that an output depends on.
    fn judge(&self, output: &PlannedOutput, ready: &HashMap<NodeId, Ready>, buffers: &Buffers<'_>) -> Option<Judge> {
        if output.kind != Kind::Color {
            return None;
        }
        let mut builder = HullBuilder::new();
        let mut colors = output.constants.clone();
        builder.add(&colors);
        let mut count = 0;
        for id in &output.control_stages {
            if self.bound[id.0] {
                if let Some([r, g, b]) = buffers.get(&self.graph.node(*id).name) {
                    builder.add_row(r, g, b);
                    count += r.len();
                }
            } else if let Some(ready) = ready.get(id) {
                let controls = ready.prepared.controls();
                builder.add(&controls);
                count += controls.len();
                colors.extend(controls.iter().take(64));
            }
        }
        colors.sort_by(|a, b| a.iter().zip(b).fold(std::cmp::Ordering::Equal, |o, (a, b)| o.then(a.total_cmp(b))));
        colors.dedup();
        let count = if count == 0 { colors.len() } else { count + output.constants.len() };
        colors.truncate(64);
        let hull = builder.finish();
        // One level more for averaging the samples.
        let margin = hull.margin(output.mix_levels + 1);
        Some(Judge { hull, margin, count, colors })
    }

    fn allocate(&self) -> Result<Vec<Vec<Plane>>, EvalError> {
        let area = self.window.area();
        self.outputs
            .iter()
            .map(|output| {
                (0..output.kind.channels())
                    .map(|_| {
                        let mut samples: Vec<f32> = Vec::new();
                        samples.try_reserve_exact(area).map_err(|_| EvalError::Memory { bytes: area * 4 })?;
                        samples.resize(area, 0.0);
                        Plane::new(self.window, samples).map_err(|_| EvalError::Memory { bytes: area * 4 })
                    })
                    .collect()
            })
            .collect()
    }

    fn tiles(
        &self,
        pictures: &mut [Vec<Plane>],
        ready: &HashMap<NodeId, Ready>,
        buffers: &Buffers<'_>,
        judges: &[Option<Judge>],
        monitor: &dyn Monitor,
    ) -> Result<Tally, EvalError> {
        let (tile_width, tile_height) = (self.settings.tile.0.max(1), self.settings.tile.1.max(1));
        let bands = bands(pictures, self.window, tile_height);
        let total = bands.len() * self.window.width().div_ceil(tile_width);
        let done = AtomicUsize::new(0);
        let tally = Mutex::new(Tally::default());
        bands.into_par_iter().try_for_each_init(
            || Working {
                worker: Worker::new(self, ready, buffers),
                audits: vec![Audit::default(); judges.len()],
                tally: &tally,
            },
            |working, mut band| {
                for tile in band.window.tiles(tile_width, tile_height) {
                    if monitor.cancelled() {
                        return Err(EvalError::Cancelled);
                    }
                    let x = (tile.x0 - band.window.x0) as usize;
                    let (width, stride) = (tile.width(), band.window.width());
                    working.worker.tile(tile, &mut |output, channel, y, row| {
                        let start = y * stride + x;
                        band.rows[output][channel][start..start + width].copy_from_slice(row);
                    })?;
                    monitor.progress(done.fetch_add(1, Ordering::Relaxed) + 1, total);
                }
                for ((audit, judge), rows) in working.audits.iter_mut().zip(judges).zip(&band.rows) {
                    *audit = audit.merge(inspect(judge.as_ref(), rows));
                }
                Ok(())
            },
        )?;
        Ok(tally.into_inner().unwrap_or_else(std::sync::PoisonError::into_inner))
    }

    fn assemble(
        &self,
        planes: Vec<Vec<Plane>>,
        judges: Vec<Option<Judge>>,
        tally: &Tally,
        ready: &HashMap<NodeId, Ready>,
        seconds: Phases,
    ) -> Frame {
        let pictures = self
            .outputs
            .iter()
            .zip(planes)
            .zip(judges)
            .enumerate()
            .map(|(index, ((output, planes), judge))| {
                let mut audit = tally.audits.get(index).copied().unwrap_or_default();
                audit.weight_min = f64::from(tally.weights.min);
                audit.weight_sum_max_deviation = tally.weights.max_deviation;
                let (margin, count, colors) = judge.map_or((0.0, 0, Vec::new()), |j| (j.margin, j.count, j.colors));
                Picture {
                    output: output.index,
                    kind: output.kind,
                    planes,
                    // Every color operation has scalar weights, so the hull is what holds.
                    guarantee: (output.kind == Kind::Color).then_some(Guarantee::Hull),
                    audit,
                    control_count: count,
                    control_colors: colors,
                    margin,
                }
            })
            .collect();
        Frame {
            number: self.context.frame,
            window: self.window,
            pictures,
            nodes: self.node_reports(tally, ready),
            seconds,
            threads: rayon::current_num_threads(),
        }
    }

    fn node_reports(&self, tally: &Tally, ready: &HashMap<NodeId, Ready>) -> Vec<NodeReport> {
        // The programs' time is shared out by the cost of each node's operations.
        let mut costs = vec![0.0; self.graph.nodes().len()];
        let mut samples = vec![0u64; costs.len()];
        for pass in &self.passes {
            let taken = (self.window.area() * pass.offsets.len()) as u64;
            for compiled in pass.fills.iter().filter_map(|fill| fill.taps.as_ref()).chain([&pass.program]) {
                for instruction in compiled.once.iter().chain(&compiled.each) {
                    costs[instruction.origin.0] += instruction.cost * taken as f64;
                    samples[instruction.origin.0] = taken;
                }
            }
            for fill in &pass.fills {
                samples[fill.node.0] += taken;
            }
        }
        let total: f64 = costs.iter().sum();
        let nodes = self.graph.nodes().iter().enumerate();
        nodes
            .map(|(index, node)| {
                let ready = ready.get(&NodeId(index));
                let fill = tally.fill_seconds.get(index).copied().unwrap_or(0.0);
                let share = if total > 0.0 { costs[index] / total * tally.program_seconds } else { 0.0 };
                let state = match &self.left_out[index] {
                    Some(why) => State::LeftOut(why.clone()),
                    None if ready.is_some_and(|ready| ready.cached) => State::Cached,
                    None => State::Evaluated,
                };
                NodeReport {
                    name: node.name.clone(),
                    ty: node.ty.declaration().name,
                    state,
                    seconds: ready.map_or(0.0, |ready| ready.seconds) + fill + share,
                    estimated: costs[index] > 0.0,
                    pixels: samples[index],
                    bytes: ready.map_or(0, |ready| ready.prepared.bytes()),
                    repaired: ready.map_or(0, |ready| ready.prepared.repaired()),
                }
            })
            .collect()
    }
}

/// A worker that hands its tally in when its thread is done with it.
struct Working<'p, 't> {
    worker: Worker<'p>,
    audits: Vec<Audit>,
    tally: &'t Mutex<Tally>,
}

impl Drop for Working<'_, '_> {
    fn drop(&mut self) {
        let mut tally = self.tally.lock().unwrap_or_else(std::sync::PoisonError::into_inner);
        tally.fill_seconds.resize(self.worker.fill_seconds.len(), 0.0);
        for (all, own) in tally.fill_seconds.iter_mut().zip(&self.worker.fill_seconds) {
            *all += own;
        }
        tally.program_seconds += self.worker.program_seconds;
        tally.weights = tally.weights.merge(self.worker.audit());
        tally.audits.resize(self.audits.len(), Audit::default());
        for (all, own) in tally.audits.iter_mut().zip(&self.audits) {
            *all = all.merge(*own);
        }
    }
}

/// Cuts every plane into bands of the same rows.
fn bands(pictures: &mut [Vec<Plane>], window: Window, height: usize) -> Vec<Band<'_>> {
    let width = window.width();
    let mut bands: Vec<Band<'_>> = window
        .tiles(width, height)
        .map(|window| Band { window, rows: pictures.iter().map(|_| Vec::new()).collect() })
        .collect();
    for (output, planes) in pictures.iter_mut().enumerate() {
        for plane in planes {
            for (band, rows) in bands.iter_mut().zip(plane.samples_mut().chunks_mut(width * height)) {
                band.rows[output].push(rows);
            }
        }
    }
    bands
}

/// Counts what is wrong with a band of finished pixels.
fn inspect(judge: Option<&Judge>, rows: &[&mut [f32]]) -> Audit {
    let mut audit = Audit { pixels: rows.first().map_or(0, |row| row.len() as u64), ..Audit::default() };
    audit.nan_count = (0..audit.pixels as usize).filter(|&x| rows.iter().any(|row| row[x].is_nan())).count() as u64;
    if let (Some(judge), [r, g, b]) = (judge, rows) {
        (audit.hull_exits, audit.worst_exit) = judge.hull.exits(r, g, b, judge.margin);
    }
    audit
}
