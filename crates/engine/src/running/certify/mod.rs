//! Certifies how far a picture may lie from the f64 references: bounds on the errors of all passes are carried
//! through the back end by a rule for each operation.
//!
//! In a certifying plan, every channel of values has a channel of bounds behind it. Stages bound their own results;
//! the program computes bounds beside its values. The values of the picture are computed as always.

mod adaptive;
mod scattered;
mod stage;
mod tally;
mod trace;

use adaptive::AdaptiveTile;
pub use scattered::CertifiedPixels;
pub(crate) use stage::{Found, Ports, fill_with_bounds};
use tally::CertifiedTile;
pub use tally::{Certified, Distribution};
pub(crate) use trace::Trace;

use crate::planning::bounds::BOUNDS;
use crate::planning::plan::{Pass, PlannedOutput};
use crate::running::fill::Fills;
use crate::running::memory::Pictures;
use crate::running::prepare::{PreparedStage, prepare};
use crate::{Buffers, Cache, EvalError, Monitor, Plan, PlanError, Settings, Switches};
use rayon::prelude::*;
use std::collections::{BTreeMap, HashMap};
use std::sync::atomic::{AtomicUsize, Ordering};
use std::sync::{Mutex, PoisonError};
use trochoid_graph::{CheckedGraph, Kind, NodeId, Purpose};
use trochoid_image::{Rgb, Window};
use trochoid_kernel::Chunks;

/// Size of the tiles that are certified one by one: so large that little is certified twice in the halos of filters.
const TILE: (usize, usize) = (128, 64);

/// Certifies some outputs at a frame.
///
/// ```
/// # use trochoid_engine::{Buffers, Cache, Certifier, Settings, Silent};
/// # fn show(graph: &trochoid_graph::CheckedGraph) -> Result<(), Box<dyn std::error::Error>> {
/// let certifier = Certifier::new(graph, &["beauty"], 1, &[], &Settings::default())?;
/// let certified = certifier.certify(&Buffers::new(), &mut Cache::new(), &Silent)?;
/// println!("{} at most, {} of the samples in doubt", certified[0].clear.max(), certified[0].in_doubt(1.0 / 255.0));
/// # Ok(())
/// # }
/// ```
#[derive(Debug)]
pub struct Certifier<'g> {
    plan: Plan<'g>,
}

impl<'g> Certifier<'g> {
    /// Plans some outputs, with the arguments of [`Plan::new`].
    ///
    /// # Errors
    /// Same as [`Plan::new`].
    pub fn new(
        graph: &'g CheckedGraph,
        outputs: &[&str],
        frame: i64,
        bound: &[&str],
        settings: &Settings,
    ) -> Result<Self, PlanError> {
        // Folded constants have already been rounded; here the error of every operation counts.
        let switches = Switches { demand: true, ..Switches::NONE };
        let settings = Settings { switches, purpose: Purpose::Bounds, tile: None, ..settings.clone() };
        Ok(Self { plan: Plan::new(graph, outputs, frame, bound, &settings)? })
    }

    /// Bounds the error of every sample of every output, on all threads.
    ///
    /// # Errors
    /// Same as [`Plan::evaluate`].
    pub fn certify(
        &self,
        buffers: &Buffers<'_>,
        cache: &mut Cache,
        monitor: &dyn Monitor,
    ) -> Result<Vec<Certified>, EvalError> {
        let plan = &self.plan;
        plan.in_pool(|| {
            plan.validate_all(buffers)?;
            let (ready, _) = prepare(plan, cache, monitor, Pictures::Whole)?;
            let tiles: Vec<Window> = self.grid().collect();
            let mut all: Vec<Certified> =
                plan.outputs.iter().map(|output| Certified::new(output.index, output.kind, plan.window)).collect();
            let run = Certification::new(&ready, buffers, tiles.len(), monitor);
            let parts: Result<Vec<Vec<CertifiedTile>>, EvalError> = tiles
                .par_chunks(run.share(tiles.len()))
                .map(|tiles| {
                    let mut own = Vec::new();
                    self.tiles(tiles, &run, &mut |_, tile| own.extend(tile)).map(|()| own)
                })
                .collect();
            for (index, part) in parts?.iter().flatten().enumerate() {
                all[index % plan.outputs.len()].add(&part.bounds);
            }
            for (certified, facts) in all.iter_mut().zip(self.facts(run)) {
                certified.cap(facts.limit);
                (certified.palette, certified.margin) = (facts.palette, facts.margin);
                certified.unbounded = facts.unbounded;
            }
            Ok(all)
        })
    }

    /// Returns the tiles that are certified one by one.
    fn grid(&self) -> impl Iterator<Item = Window> {
        let ((width, height), (across, down)) = (TILE, self.plan.halo());
        self.plan.window.tiles(width.max(4 * across), height.max(4 * down))
    }

    /// Returns what holds for all pixels of each output.
    fn facts(&self, run: Certification<'_>) -> Vec<OutputFacts> {
        let plan = &self.plan;
        let unbounded = run.unbounded.into_inner().unwrap_or_else(PoisonError::into_inner);
        let facts = plan.outputs.iter().map(|output| {
            let node = plan.graph.outputs()[output.index].node;
            let reached = plan.graph.dependencies([node], plan.frame());
            let mut unbounded: Vec<(NodeId, &'static str)> =
                unbounded.iter().map(|(id, why)| (*id, *why)).filter(|(id, _)| reached[id.0]).collect();
            // By name, as in the canonical document.
            unbounded.sort_by_key(|(id, _)| &plan.graph.node(*id).name);
            let (mut palette, mut margin) = (Vec::new(), 0.0);
            let limit = match output.kind {
                Kind::Color => {
                    let judge = plan.palette(output, run.ready, run.buffers);
                    (palette, margin) = (judge.hull.vertices().to_vec(), judge.margin);
                    breadth(&palette) + 2.0 * margin
                }
                Kind::Weights(_) => 1.0,
                _ => f64::INFINITY,
            };
            OutputFacts { palette, margin, unbounded, limit }
        });
        facts.collect()
    }

    /// Returns the stage that contributes most to the bound at a pixel: the one without whose own errors the bound is
    /// smallest.
    ///
    /// # Errors
    /// Same as [`Plan::evaluate`].
    pub fn limiting(
        &self,
        output: usize,
        pixel: [i64; 2],
        buffers: &Buffers<'_>,
        cache: &mut Cache,
        monitor: &dyn Monitor,
    ) -> Result<AccuracyLimit, EvalError> {
        let (bound, by_stage) = self.by_stage(output, pixel, buffers, cache, monitor)?;
        let least = by_stage.into_iter().min_by(|a, b| a.1.total_cmp(&b.1));
        let (stage, without) = least.map_or((None, bound), |(stage, without)| (Some(stage), without));
        Ok(AccuracyLimit { stage: stage.filter(|_| without < MATTERS * bound), bound, without })
    }

    /// Returns the bound of an output at a pixel, and for each stage the bound as it would be without that stage's
    /// own errors.
    ///
    /// The bounds are those of the largest channel, averaged over the pixel's samples. Stages that the cache holds
    /// from a certification are used again.
    ///
    /// # Errors
    /// Same as [`Plan::evaluate`].
    pub fn by_stage(
        &self,
        output: usize,
        [x, y]: [i64; 2],
        buffers: &Buffers<'_>,
        cache: &mut Cache,
        monitor: &dyn Monitor,
    ) -> Result<(f64, Vec<(NodeId, f64)>), EvalError> {
        let graph = self.plan.graph;
        let name = graph.outputs()[output].name.as_str();
        let bound = self.plan.bound.iter().enumerate().filter(|(_, bound)| **bound);
        let bound: Vec<&str> = bound.map(|(id, _)| graph.node(NodeId(id)).name.as_str()).collect();
        let region = Some(Window::new(x, y, x + 1, y + 1));
        let mut at = |exact: Option<NodeId>| {
            let settings = Settings { region, exact, ..self.plan.settings.clone() };
            let Ok(plan) = Plan::new(graph, &[name], self.plan.frame(), &bound, &settings) else {
                unreachable!("a part of a plan is no larger than the plan")
            };
            let certified = Self { plan }.certify(buffers, cache, monitor)?;
            Ok(certified[0].errors.iter().map(|error| f64::from(error[0])).fold(0.0, f64::max))
        };
        let whole = at(None)?;
        let stages = self.plan.prepares.iter().map(|(stage, _)| Ok((*stage, at(Some(*stage))?)));
        Ok((whole, stages.collect::<Result<_, EvalError>>()?))
    }

    /// Certifies some tiles, and hands over the index and the outputs of each.
    fn tiles(
        &self,
        tiles: &[Window],
        run: &Certification<'_>,
        take: &mut dyn FnMut(usize, Vec<CertifiedTile>),
    ) -> Result<(), EvalError> {
        let plan = &self.plan;
        let mut chunks = Chunks::of([]);
        let mut chunks = chunks.all();
        let mut seconds = vec![0.0; plan.graph.nodes().len()];
        let mut passes: Vec<(&Pass, Fills<'_>, Trace<'_>)> = plan
            .passes
            .iter()
            .map(|pass| {
                let fills = Fills::new(plan, run.ready, run.buffers, pass, run.monitor, &mut chunks);
                (pass, fills, Trace::new(&pass.program))
            })
            .collect();
        for (index, &tile) in tiles.iter().enumerate() {
            if run.monitor.cancelled() {
                return Err(EvalError::Cancelled);
            }
            let of = |output: &PlannedOutput| CertifiedTile::new(output.index, output.kind, tile);
            let mut own: Vec<CertifiedTile> = plan.outputs.iter().map(of).collect();
            for (pass, fills, trace) in &mut passes {
                let share = 1.0 / pass.offsets.len() as f64;
                let tolerance = plan.graph.format().adaptive().filter(|_| pass.offsets.len() > 1);
                let mut adaptive = tolerance.map(|tolerance| AdaptiveTile::new(plan, pass, tile, tolerance));
                for sample in pass.samples() {
                    let window = match &adaptive {
                        Some(adaptive) if sample.index == 0 => adaptive.around,
                        _ => tile,
                    };
                    fills.fill(window, sample, &mut seconds)?;
                    run.note(fills);
                    let planes = fills.planes(&pass.program);
                    // Rows by root and channel: values, then bounds.
                    let mut rows = vec![Vec::new(); pass.roots.len() * 2 * BOUNDS];
                    trace.tile(&planes, window.width(), window.height(), &mut |root, channel, _, row| {
                        rows[root * 2 * BOUNDS + channel].extend_from_slice(row);
                    });
                    let mut values: Vec<Vec<Vec<f32>>> = vec![Vec::new(); own.len()];
                    let mut bounds = values.clone();
                    for (&(output, _), rows) in pass.roots.iter().zip(rows.chunks_mut(2 * BOUNDS)) {
                        let mut rows = rows.iter_mut().map(std::mem::take);
                        values[output].extend(rows.by_ref().take(BOUNDS).filter(|row| !row.is_empty()));
                        bounds[output].extend(rows.filter(|row| !row.is_empty()));
                    }
                    if let Some(adaptive) = &mut adaptive {
                        adaptive.keep(sample.index, values, bounds);
                        continue;
                    }
                    for (own, (values, bounds)) in own.iter_mut().zip(values.iter().zip(&bounds)) {
                        if !bounds.is_empty() {
                            own.sample(values, bounds, share);
                        }
                    }
                }
                for output in pass.outputs() {
                    match &mut adaptive {
                        Some(adaptive) => adaptive.certify(output, &mut own[output], share),
                        None => own[output].average(share),
                    }
                }
            }
            take(index, own);
            run.step();
        }
        Ok(())
    }
}

/// What limits the accuracy of an output.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct AccuracyLimit {
    /// Stage that limits it; `None` if no single stage does, only f32 rounding throughout the graph.
    pub stage: Option<NodeId>,
    /// Bound on the error, in the output's own unit.
    pub bound: f64,
    /// Bound as it would be if the stage had no errors.
    pub without: f64,
}

/// A stage is limiting if less than this share of the bound is left without its errors.
const MATTERS: f64 = 0.75;

/// Returns the largest difference between two colors of a palette in any channel.
fn breadth(palette: &[Rgb]) -> f64 {
    let span = |channel: usize| {
        let values = || palette.iter().map(|color| f64::from(color[channel]));
        values().fold(f64::NEG_INFINITY, f64::max) - values().fold(f64::INFINITY, f64::min)
    };
    (0..3).map(span).fold(0.0, f64::max)
}

/// What holds for all pixels of an output.
struct OutputFacts {
    /// Vertices of the hull of all control colors, and the margin of rounding around it.
    palette: Vec<Rgb>,
    margin: f64,
    /// Stages upstream that know no bound, and why.
    unbounded: Vec<(NodeId, &'static str)>,
    /// Limit that no error can exceed, because picture and reference both lie within it.
    limit: f64,
}

/// State that the threads of one certification share.
struct Certification<'m> {
    ready: &'m HashMap<NodeId, PreparedStage>,
    buffers: &'m Buffers<'m>,
    /// Number of all tiles.
    total: usize,
    done: AtomicUsize,
    /// Stages that know no bound, and why.
    unbounded: Mutex<BTreeMap<NodeId, &'static str>>,
    monitor: &'m dyn Monitor,
}

impl<'m> Certification<'m> {
    fn new(
        ready: &'m HashMap<NodeId, PreparedStage>,
        buffers: &'m Buffers<'m>,
        total: usize,
        monitor: &'m dyn Monitor,
    ) -> Self {
        Self { ready, buffers, total, done: AtomicUsize::new(0), unbounded: Mutex::default(), monitor }
    }

    /// Returns how many of some tiles a thread takes at once.
    fn share(&self, tiles: usize) -> usize {
        tiles.div_ceil(8 * rayon::current_num_threads()).max(1)
    }

    /// Records which stages know no bound.
    fn note(&self, fills: &Fills<'_>) {
        for (id, why) in fills.unbounded() {
            self.unbounded.lock().unwrap_or_else(PoisonError::into_inner).insert(id, why.0);
        }
    }

    /// Counts a tile.
    fn step(&self) {
        self.monitor.progress(self.done.fetch_add(1, Ordering::Relaxed) + 1, self.total);
    }
}
