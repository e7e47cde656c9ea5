//! Evaluates a plan: prepares, then computes tiles on all cores and judges them as they are made.

use super::bands::{Bands, OwnRows, Rows};
use super::frame::{Frame, NodeReport, Phases, Picture, State};
use super::memory::Pictures;
use super::prepare::{PreparedStage, prepare};
use super::tile::{Evaluation, Worker};
use crate::judge::Judge;
use crate::planning::plan::{Feed, Pass, PlannedOutput};
use crate::{Buffers, Cache, EvalError, Monitor, Plan};
use std::collections::HashMap;
use std::num::NonZero;
use std::sync::atomic::{AtomicBool, AtomicUsize, Ordering};
use std::sync::{Arc, Mutex, OnceLock, PoisonError};
use std::time::Instant;
use trochoid_graph::{Guarantee, Kind, NodeId, Omission, PortId, Prepared, Source};
use trochoid_image::{Plane, Window};
use trochoid_kernel::{Chunks, CompiledProgram, WeightAudit};
use trochoid_memory::Scratch;
use trochoid_weights::{Audit, BoxHull, HullBuilder};

/// Takes finished rows, instead of planes in memory.
///
/// Bands come from many threads at once. They start in order from the top of the picture, but may finish in any
/// order.
pub trait Sink: Sync {
    /// Returns the number of rows of which bands are whole multiples, except for the last one.
    fn rows(&self) -> usize;

    /// Takes a band of full rows: the samples by output of the plan and by channel, row by row.
    ///
    /// # Errors
    /// The rows cannot be stored; the evaluation stops.
    fn take(&self, band: Window, rows: &[Vec<&[f32]>]) -> Result<(), EvalError>;
}

/// What the workers report when they are done.
#[derive(Default)]
pub(crate) struct WorkerTotals {
    pub(crate) fill_seconds: Vec<f64>,
    /// By node, the number of samples left out since they do not show.
    pub(crate) left_out: HashMap<NodeId, u64>,
    pub(crate) program_seconds: f64,
    pub(crate) weights: WeightAudit,
    pub(crate) audits: Vec<Audit>,
}

impl WorkerTotals {
    fn add(&mut self, worker: &Worker<'_>) {
        self.fill_seconds.resize(worker.fill_seconds.len(), 0.0);
        for (all, own) in self.fill_seconds.iter_mut().zip(&worker.fill_seconds) {
            *all += own;
        }
        worker.left_out().for_each(|(node, count)| *self.left_out.entry(node).or_default() += count);
        self.program_seconds += worker.program_seconds;
        self.weights = self.weights.merge(worker.audit());
        self.audits.resize(worker.audits.len(), Audit::default());
        for (all, own) in self.audits.iter_mut().zip(&worker.audits) {
            *all = all.merge(*own);
        }
    }
}

impl Plan<'_> {
    /// Evaluates the plan. `buffers` supplies the bound nodes; `cache` keeps what the next frame can use.
    ///
    /// # Errors
    /// Input and output, illegal input data, memory, or cancellation.
    pub fn evaluate(
        &self,
        buffers: &Buffers<'_>,
        cache: &mut Cache,
        monitor: &dyn Monitor,
    ) -> Result<Frame, EvalError> {
        let mut frame = Frame::default();
        self.evaluate_into(&mut frame, buffers, cache, monitor)?;
        Ok(frame)
    }

    /// Does the same as [`Plan::evaluate`], but reuses the memory of a frame that is no longer needed, such as the
    /// previous one. After an error the frame holds nothing useful.
    ///
    /// # Errors
    /// Same as [`Plan::evaluate`].
    pub fn evaluate_into(
        &self,
        frame: &mut Frame,
        buffers: &Buffers<'_>,
        cache: &mut Cache,
        monitor: &dyn Monitor,
    ) -> Result<(), EvalError> {
        let old = std::mem::take(&mut frame.pictures);
        let mut pictures = Vec::new();
        let into = &mut pictures;
        *frame = self.run(buffers, cache, monitor, Pictures::Whole, move |tile| {
            *into = self.allocate(old)?;
            Ok(Bands::of_planes(into.iter_mut().collect(), self.window, tile))
        })?;
        for (picture, planes) in frame.pictures.iter_mut().zip(pictures) {
            picture.planes = planes;
        }
        Ok(())
    }

    /// Does the same as [`Plan::evaluate`], but hands rows to a sink as soon as they are finished, so that memory
    /// does not grow with the picture. The frame's pictures have no planes.
    ///
    /// # Errors
    /// Same as [`Plan::evaluate`], and errors that the sink reports.
    pub fn evaluate_to(
        &self,
        sink: &dyn Sink,
        buffers: &Buffers<'_>,
        cache: &mut Cache,
        monitor: &dyn Monitor,
    ) -> Result<Frame, EvalError> {
        let channels: Vec<usize> = self.outputs.iter().map(|output| output.kind.channels()).collect();
        self.run(buffers, cache, monitor, Pictures::Rows, |(width, height)| {
            let height = height.next_multiple_of(sink.rows().max(1));
            Ok(Bands::of_sink(sink, channels, self.window, (width, height)))
        })
    }

    /// Returns what the stages of the plan leave out of their own work at this frame, by node. Prepares all of them,
    /// but fills nothing.
    ///
    /// # Errors
    /// Same as [`Plan::evaluate`].
    pub fn omissions(
        &self,
        cache: &mut Cache,
        monitor: &dyn Monitor,
    ) -> Result<Vec<(NodeId, Vec<Omission>)>, EvalError> {
        self.in_pool(|| {
            let (ready, _) = prepare(self, cache, monitor, Pictures::Rows)?;
            let stages = self.prepares.iter().filter_map(|(id, _)| Some((*id, ready.get(id)?.prepared.left_out())));
            Ok(stages.filter(|(_, omissions)| !omissions.is_empty()).collect())
        })
    }

    fn run<'s>(
        &self,
        buffers: &Buffers<'_>,
        cache: &mut Cache,
        monitor: &dyn Monitor,
        pictures: Pictures,
        bands: impl FnOnce((usize, usize)) -> Result<Bands<'s>, EvalError> + Send,
    ) -> Result<Frame, EvalError> {
        self.in_pool(|| {
            self.validate(buffers)?;
            let started = Instant::now();
            let (ready, mut account) = prepare(self, cache, monitor, pictures)?;
            let prepared = started.elapsed().as_secs_f64();
            let started = Instant::now();
            let judges: Vec<Option<Arc<Judge>>> =
                self.outputs.iter().map(|output| self.judge(output, &ready, buffers)).collect();
            let judged = started.elapsed().as_secs_f64();
            let started = Instant::now();
            let mut keeper = self.keeper(&ready, &account, cache);
            if let Some(steps) = keeper.steps() {
                self.account_for_steps(&mut account, steps);
            }
            let bands = bands(self.tile(&ready, &keeper.load(self, true)))?;
            let mut totals = WorkerTotals::default();
            let mut steps = || {
                while keeper.begin_step(self) {
                    let between = (!keeper.is_last_step()).then(|| {
                        let tile = self.tile(&ready, &keeper.load(self, false));
                        Bands::of_planes(Vec::new(), self.window, tile)
                    });
                    let bands = between.as_ref().unwrap_or(&bands);
                    // No more workers than tiles, nor than can run at once: those that wait would hold tiles.
                    let workers = account.workers().min(bands.tiles()).min(cores()).max(1);
                    let judges = &judges[..];
                    let evaluation =
                        Evaluation { plan: self, ready: &ready, buffers, judges, keeper: &keeper, monitor };
                    self.tiles(evaluation, bands, workers, &mut totals)?;
                    keeper.end_step();
                }
                Ok(())
            };
            let done = steps();
            let spared = keeper.spared.clone();
            if done.is_ok() {
                keeper.finish(cache);
            }
            // Data decoded on demand counts too.
            cache.trim();
            done?;
            let seconds = Phases { prepare: prepared, hull: judged, tiles: started.elapsed().as_secs_f64() };
            Ok(self.assemble(judges, &totals, &ready, &spared, seconds))
        })
    }

    /// Runs on as many threads as the settings request.
    pub(crate) fn in_pool<R: Send>(&self, run: impl FnOnce() -> Result<R, EvalError> + Send) -> Result<R, EvalError> {
        let threads = self.settings.threads;
        if threads == 0 {
            return run();
        }
        // Made once, since starting threads costs as much as a small picture.
        let pool =
            self.pool.get_or_init(|| rayon::ThreadPoolBuilder::new().num_threads(threads).build().map_err(Arc::new));
        match pool {
            Ok(pool) => pool.install(run),
            Err(error) => Err(EvalError::Threads(error.clone().into())),
        }
    }

    /// Checks the buffers of bound nodes. Values that only programs read are checked while the programs run.
    pub(crate) fn validate(&self, buffers: &Buffers<'_>) -> Result<(), EvalError> {
        let picture_area = self.graph.format().window().area();
        for (id, _) in self.bound.iter().enumerate().filter(|(_, bound)| **bound) {
            let node = self.graph.node(NodeId(id));
            let kind = node.kinds[0];
            buffers.validate(&node.name, kind, picture_area)?;
            let feeds_stage = self.passes.iter().flat_map(|pass| &pass.fills).any(|fill| {
                let feeds = fill.inputs.iter().flat_map(|(_, connections)| connections).flatten();
                feeds.into_iter().any(|feed| matches!(feed, Feed::Slot(slot) if slot.node.0 == id))
                    || fill.taps.iter().flat_map(|taps| &taps.planes).any(|slot| slot.node.0 == id)
            });
            // The palette is computed from a color's values before they are mixed.
            if feeds_stage || kind == Kind::Color || matches!(kind, Kind::Weights(n) if n > 2) {
                buffers.validate_values(&node.name, kind)?;
            }
        }
        Ok(())
    }

    /// Checks every value of the buffers of bound nodes.
    pub(crate) fn validate_all(&self, buffers: &Buffers<'_>) -> Result<(), EvalError> {
        self.validate(buffers)?;
        let bound = self.graph.nodes().iter().zip(&self.bound).filter(|(_, bound)| **bound);
        bound.into_iter().try_for_each(|(node, _)| buffers.validate_values(&node.name, node.kinds[0]))
    }

    /// Returns what a color output is judged by, or `None` for other kinds; kept if all controls are in the document.
    pub(crate) fn judge(
        &self,
        output: &PlannedOutput,
        ready: &HashMap<NodeId, PreparedStage>,
        buffers: &Buffers<'_>,
    ) -> Option<Arc<Judge>> {
        let judge = || Arc::new(self.palette(output, ready, buffers));
        (output.kind == Kind::Color).then(|| match output.control_stages[..] {
            // Only colors in the document: the same at every evaluation.
            [] => output.judge.get_or_init(judge).clone(),
            _ => judge(),
        })
    }

    /// Builds the palette of a color output from the controls that it depends on; those of bound nodes are in
    /// buffers.
    pub(crate) fn palette(
        &self,
        output: &PlannedOutput,
        ready: &HashMap<NodeId, PreparedStage>,
        buffers: &Buffers<'_>,
    ) -> Judge {
        let mut builder = HullBuilder::new();
        let mut colors = output.constants.clone();
        builder.add(&colors);
        let mut count = 0;
        let mut all_listed = true;
        for id in &output.control_stages {
            let controls = if self.bound[id.0] {
                // As those of an image: the corners of the hull of its colors.
                let mut own = HullBuilder::new();
                if let Some([r, g, b]) = buffers.get(&self.graph.node(*id).name) {
                    own.add_row(r, g, b);
                }
                own.corners()
            } else {
                ready.get(id).map(|ready| ready.prepared.controls()).unwrap_or_default()
            };
            builder.add(&controls);
            count += controls.len();
            all_listed &= controls.len() <= 64;
            colors.extend(controls.iter().take(64));
        }
        colors.sort_by(|a, b| a.iter().zip(b).fold(std::cmp::Ordering::Equal, |o, (a, b)| o.then(a.total_cmp(b))));
        colors.dedup();
        // Distinct colors are counted, as far as all are listed.
        let count = if all_listed { colors.len() } else { count + output.constants.len() };
        colors.truncate(64);
        let hull = builder.finish();
        // One level more, for averaging the samples.
        let margin = hull.margin(output.mix_levels + 1);
        let bounds = BoxHull::new(hull.vertices());
        Judge { hull: Arc::new(hull), bounds, margin, count, colors }
    }

    /// Allocates planes for every output, reusing the given ones if possible.
    pub(crate) fn allocate(&self, old: Vec<Picture>) -> Result<Vec<Vec<Plane>>, EvalError> {
        let mut old: Vec<Plane> = old.into_iter().flat_map(|picture| picture.planes).collect();
        old.retain(|plane| plane.window() == self.window);
        old.reverse();
        let mut index = 0;
        let mut plane = || {
            index += 1;
            let bytes = self.window.area().saturating_mul(4);
            old.pop().map_or_else(|| Plane::zeroed(self.window, index).map_err(|_| EvalError::Memory { bytes }), Ok)
        };
        self.outputs.iter().map(|output| (0..output.kind.channels()).map(|_| plane()).collect()).collect()
    }

    /// Evaluates every tile of a step, on `workers` threads.
    fn tiles(
        &self,
        evaluation: Evaluation<'_>,
        bands: &Bands<'_>,
        workers: usize,
        totals: &mut WorkerTotals,
    ) -> Result<(), EvalError> {
        let monitor = evaluation.monitor;
        let tiles = bands.tiles();
        let [before, steps] = evaluation.keeper.progress();
        let done = AtomicUsize::new(before * tiles);
        let totals = Mutex::new(totals);
        let failed: Mutex<Option<EvalError>> = Mutex::new(None);
        let stop = AtomicBool::new(false);
        let fill = || {
            let mut chunks = Chunks::of(self.passes.iter().flat_map(programs));
            let mut worker = Worker::new(evaluation, chunks.all());
            let mut own = OwnRows::new();
            let mut run = |tile: Window, rows: &mut Rows<'_>| {
                if monitor.cancelled() {
                    return Err(EvalError::Cancelled);
                }
                worker.tile(tile, rows)?;
                monitor.progress(done.fetch_add(1, Ordering::Relaxed) + 1, steps * tiles);
                Ok(())
            };
            while !stop.load(Ordering::Relaxed) {
                match bands.work(&mut own, &mut run) {
                    Ok(true) => {}
                    Ok(false) => break,
                    Err(error) => {
                        stop.store(true, Ordering::Relaxed);
                        failed.lock().unwrap_or_else(PoisonError::into_inner).get_or_insert(error);
                    }
                }
            }
            totals.lock().unwrap_or_else(PoisonError::into_inner).add(&worker);
        };
        let work = || {
            fill();
            // Tiles of the same size take the same memory again, but what comes next may take other memory.
            Scratch::release();
        };
        rayon::scope(|scope| {
            for _ in 1..workers {
                scope.spawn(|_| work());
            }
            work();
        });
        match failed.into_inner().unwrap_or_else(PoisonError::into_inner) {
            Some(error) => Err(error),
            None => Ok(()),
        }
    }

    pub(crate) fn assemble(
        &self,
        judges: Vec<Option<Arc<Judge>>>,
        totals: &WorkerTotals,
        ready: &HashMap<NodeId, PreparedStage>,
        spared: &[NodeId],
        seconds: Phases,
    ) -> Frame {
        let pictures = self
            .outputs
            .iter()
            .zip(judges)
            .enumerate()
            .map(|(index, (output, judge))| {
                let mut audit = totals.audits.get(index).copied().unwrap_or_default();
                audit.weight_min = f64::from(totals.weights.min);
                audit.weight_sum_max_deviation = totals.weights.max_deviation;
                let hull = judge.as_ref().map(|judge| judge.hull.clone());
                let (margin, count, colors) =
                    judge.map_or((0.0, 0, Vec::new()), |j| (j.margin, j.count, j.colors.clone()));
                Picture {
                    output: output.index,
                    kind: output.kind,
                    planes: Vec::new(),
                    // Every color operation has scalar weights, so the hull is what is guaranteed.
                    guarantee: (output.kind == Kind::Color).then_some(Guarantee::Hull),
                    audit,
                    control_count: count,
                    control_colors: colors,
                    hull,
                    margin,
                }
            })
            .collect();
        Frame {
            number: self.context.frame,
            window: self.window,
            pictures,
            nodes: self.node_reports(totals, ready, spared),
            seconds,
            threads: rayon::current_num_threads(),
        }
    }

    /// Returns the names of the nodes connected to one of which nothing is in the picture.
    fn unseen(&self, node: usize, prepared: &dyn Prepared) -> Vec<String> {
        let Some(settled) = &self.settled[node] else { return Vec::new() };
        let name = |(port, index): (PortId, usize)| match settled.all(port.name()).get(index)? {
            Source::Output { node, .. } => Some(self.graph.node(*node).name.clone()),
            _ => None,
        };
        prepared.unseen().into_iter().filter_map(name).collect()
    }

    /// Reports on all nodes. Nodes in `spared` filled nothing: their planes are known from an earlier evaluation, or not needed.
    fn node_reports(
        &self,
        totals: &WorkerTotals,
        ready: &HashMap<NodeId, PreparedStage>,
        spared: &[NodeId],
    ) -> Vec<NodeReport> {
        // The programs' time is divided by the cost of each node's operations.
        let mut costs = vec![0.0; self.graph.nodes().len()];
        let mut samples = vec![0u64; costs.len()];
        for pass in &self.passes {
            let taken = (self.window.area() * pass.offsets.len()) as u64;
            for compiled in programs(pass) {
                for (origin, cost) in &compiled.costs {
                    costs[origin.0] += cost * taken as f64;
                    samples[origin.0] = taken;
                }
            }
            for fill in pass.fills.iter().filter(|fill| !spared.contains(&fill.node)) {
                samples[fill.node.0] += taken;
            }
        }
        for (node, count) in &totals.left_out {
            samples[node.0] = samples[node.0].saturating_sub(*count);
        }
        let total: f64 = costs.iter().sum();
        let nodes = self.graph.nodes().iter().enumerate();
        nodes
            .map(|(index, node)| {
                let ready = ready.get(&NodeId(index));
                let fill = totals.fill_seconds.get(index).copied().unwrap_or(0.0);
                let share = if total > 0.0 { costs[index] / total * totals.program_seconds } else { 0.0 };
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
                    kept: ready.map_or(0, |ready| ready.prepared.kept()),
                    repaired: ready.map_or(0, |ready| ready.prepared.repaired()),
                    first_repaired: ready.and_then(|ready| ready.prepared.first_repaired()),
                    unseen: ready.map_or_else(Vec::new, |ready| self.unseen(index, &*ready.prepared)),
                }
            })
            .collect()
    }
}

/// Returns the number of threads that the machine runs at once.
fn cores() -> usize {
    static CORES: OnceLock<usize> = OnceLock::new();
    // If it is unknown, as many as are asked for.
    *CORES.get_or_init(|| std::thread::available_parallelism().map_or(usize::MAX, NonZero::get))
}

/// Lists every program that a pass runs.
pub(crate) fn programs(pass: &Pass) -> impl Iterator<Item = &CompiledProgram> {
    let gates = pass.gates.iter().flat_map(|gates| &gates.levels);
    pass.fills.iter().filter_map(|fill| fill.taps.as_ref()).chain(gates).chain([&pass.program]).chain(&pass.scattered)
}
