//! The slow f64 evaluator, which runs the nodes' references sample by sample. It is the oracle of everything fast.

mod frame;
mod pixels;

pub use pixels::ReferencePixel;

use crate::planning::shading::SHARING_CHANNELS;
use crate::running::fill::extents;
use crate::running::memory::Pictures;
use crate::running::prepare::{PreparedStage, prepare};
use crate::{Cache, EvalError, Monitor, Plan, PlanError, Settings, Silent, Switches};
use std::cell::RefCell;
use std::collections::HashMap;
use std::sync::{Arc, Mutex, PoisonError};
use trochoid_graph::{Body, CheckedGraph, Kind, NodeId, Purpose, Reference, References, Source};
use trochoid_image::{Shading, Window};

/// A frame whose outputs can be evaluated in f64 at any pixel.
pub struct ReferenceFrame<'g> {
    plan: Plan<'g>,
    ready: HashMap<NodeId, PreparedStage>,
    /// How far the images of stages extend.
    extents: HashMap<NodeId, Window>,
    /// By output: where its samples lie in a pixel.
    offsets: Vec<Vec<[f64; 2]>>,
    /// Each requested node's dependencies, with the node itself last.
    orders: Mutex<HashMap<NodeId, Arc<[NodeId]>>>,
}

/// Why a reference frame or pixel cannot be computed.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
pub enum ReferenceError {
    /// The plan cannot be made.
    #[error(transparent)]
    Plan(#[from] PlanError),
    /// A node fails.
    #[error(transparent)]
    Eval(#[from] EvalError),
}

impl<'g> ReferenceFrame<'g> {
    /// Prepares every node that an output needs at a frame.
    ///
    /// # Errors
    /// Same as planning and evaluation.
    pub fn new(graph: &'g CheckedGraph, output: &str, frame: i64) -> Result<Self, ReferenceError> {
        Self::prepared(graph, &[output], frame, &mut Cache::new(), &Silent)
    }

    /// Prepares every node that some outputs need at a frame, with what a cache holds. What the outputs share is
    /// evaluated once for all of them.
    ///
    /// # Errors
    /// Same as [`ReferenceFrame::new`]; or the monitor asked to stop.
    pub fn prepared(
        graph: &'g CheckedGraph,
        outputs: &[&str],
        frame: i64,
        cache: &mut Cache,
        monitor: &dyn Monitor,
    ) -> Result<Self, ReferenceError> {
        Self::bounded(graph, outputs, frame, Settings::default().memory_limit, cache, monitor)
    }

    /// Does the same with stages as a [`Certifier`](crate::Certifier) prepares them, so that those in its cache are not
    /// prepared again. Their references are the same up to the rounding of f64, and may be faster: seas find the points
    /// that rays meet among cells.
    ///
    /// # Errors
    /// Same as [`ReferenceFrame::prepared`].
    pub fn beside_bounds(
        graph: &'g CheckedGraph,
        outputs: &[&str],
        frame: i64,
        cache: &mut Cache,
        monitor: &dyn Monitor,
    ) -> Result<Self, ReferenceError> {
        let mut plan = Self::plan(graph, outputs, frame, Settings::default().memory_limit)?;
        plan.settings.purpose = Purpose::Bounds;
        Self::of(plan, cache, monitor)
    }

    /// Prepares as [`ReferenceFrame::prepared`], within a memory limit, in bytes.
    pub(crate) fn bounded(
        graph: &'g CheckedGraph,
        outputs: &[&str],
        frame: i64,
        memory_limit: u64,
        cache: &mut Cache,
        monitor: &dyn Monitor,
    ) -> Result<Self, ReferenceError> {
        Self::of(Self::plan(graph, outputs, frame, memory_limit)?, cache, monitor)
    }

    fn plan(
        graph: &'g CheckedGraph,
        outputs: &[&str],
        frame: i64,
        memory_limit: u64,
    ) -> Result<Plan<'g>, ReferenceError> {
        let purpose = Purpose::References;
        let settings = Settings { switches: Switches::NONE, memory_limit, purpose, ..Settings::default() };
        Ok(Plan::new(graph, outputs, frame, &[], &settings)?)
    }

    fn of(plan: Plan<'g>, cache: &mut Cache, monitor: &dyn Monitor) -> Result<Self, ReferenceError> {
        let (ready, _) = prepare(&plan, cache, monitor, Pictures::Rows)?;
        let extents = plan.passes.iter().flat_map(|pass| extents(&plan, &ready, &pass.fills)).collect();
        let mut offsets = vec![Vec::new(); plan.outputs.len()];
        for pass in &plan.passes {
            pass.outputs().for_each(|output| offsets[output].clone_from(&pass.offsets));
        }
        Ok(Self { plan, ready, extents, offsets, orders: Mutex::default() })
    }

    /// Returns the first output at a point in the picture, in pixels: pixel x has its center at x + ½.
    ///
    /// # Errors
    /// A node's input data are illegal at that point.
    pub fn sample(&self, x: f64, y: f64) -> Result<Vec<f64>, EvalError> {
        PixelEvaluation::new(self, &Silent).sample(0, [x, y])
    }

    /// Returns the first output at a pixel, averaged over the samples that the fast path averages.
    ///
    /// # Errors
    /// Same as [`ReferenceFrame::sample`].
    pub fn pixel(&self, x: i64, y: i64) -> Result<Vec<f64>, EvalError> {
        let mut outputs = PixelEvaluation::new(self, &Silent).outputs(1, [x, y], &mut |_| ());
        outputs.swap_remove(0)
    }

    /// Clamps a point to the extent of a node's image: beyond it, to the same point within the nearest pixel.
    fn within(&self, node: NodeId, at: [f64; 2]) -> [f64; 2] {
        let extent = self.extents.get(&self.handed_on(node)).copied().unwrap_or(self.plan.graph.format().window());
        let axis = |at: f64, first: i64, end: i64| {
            let pixel = at.floor();
            let nearest = pixel.clamp(first as f64, (end - 1) as f64);
            if nearest == pixel { at } else { nearest + (at - pixel) }
        };
        [axis(at[0], extent.x0, extent.x1), axis(at[1], extent.y0, extent.y1)]
    }

    /// Returns a node and its dependencies, inputs first.
    fn order(&self, id: NodeId) -> Arc<[NodeId]> {
        let upstream = || {
            let needed = self.plan.graph.dependencies([id], self.plan.context.frame);
            self.plan.graph.order().iter().filter(|id| needed[id.0]).copied().collect()
        };
        let mut orders = self.orders.lock().unwrap_or_else(PoisonError::into_inner);
        orders.entry(id).or_insert_with(upstream).clone()
    }

    /// Follows nodes that only hand an input on, and returns the node behind them.
    fn handed_on(&self, mut node: NodeId) -> NodeId {
        while let Some(settled) = &self.plan.settled[node.0]
            && let Some(Source::Output { node: chosen, .. }) = settled.node().identity()
        {
            node = *chosen;
        }
        node
    }
}

/// Outputs of nodes at points.
type PointOutputs = HashMap<(NodeId, [u64; 2]), Vec<Reference>>;

/// Evaluation of one pixel. What several outputs need at a sample is evaluated once, and so is what several samples
/// need at first samples, if the document shades per pixel.
struct PixelEvaluation<'e, 'g> {
    frame: &'e ReferenceFrame<'g>,
    /// Asked at every node, because filters of filters read very many points for one pixel.
    monitor: &'e dyn Monitor,
    /// Outputs of nodes, by the bits of the point: filters read their inputs at other points, several of them often at
    /// the same.
    known: RefCell<PointOutputs>,
}

impl<'e, 'g> PixelEvaluation<'e, 'g> {
    fn new(frame: &'e ReferenceFrame<'g>, monitor: &'e dyn Monitor) -> Self {
        Self { frame, monitor, known: RefCell::default() }
    }

    /// Returns an output of the frame at a point.
    fn sample(&self, output: usize, at: [f64; 2]) -> Result<Vec<f64>, EvalError> {
        let plan = &self.frame.plan;
        let spec = &plan.graph.outputs()[plan.outputs[output].index];
        Ok(numbers(self.output(spec.node, spec.output, at)?))
    }

    /// Returns the first `count` outputs of the frame at a pixel, each averaged over its samples, and shows what nodes
    /// returned on the way, sample by sample. An output ends at its first error.
    fn outputs(
        &self,
        count: usize,
        [x, y]: [i64; 2],
        show: &mut dyn FnMut(&PointOutputs),
    ) -> Vec<Result<Vec<f64>, EvalError>> {
        let offsets = &self.frame.offsets[..count];
        let mut sums: Vec<Result<Vec<f64>, EvalError>> = vec![Ok(Vec::new()); count];
        for sample in 0..offsets.iter().map(Vec::len).max().unwrap_or(0) {
            for (output, sums) in sums.iter_mut().enumerate() {
                let (Some(offset), Ok(all)) = (offsets[output].get(sample), &mut *sums) else { continue };
                match self.sample(output, [x as f64 + offset[0], y as f64 + offset[1]]) {
                    Ok(value) => {
                        all.resize(value.len(), 0.0);
                        all.iter_mut().zip(value).for_each(|(sum, value)| *sum += value);
                    }
                    Err(error) => *sums = Err(error),
                }
            }
            show(&self.known.borrow());
            self.forget();
        }
        for (sums, offsets) in sums.iter_mut().zip(offsets) {
            sums.iter_mut().flatten().for_each(|sum| *sum /= offsets.len() as f64);
        }
        sums
    }

    /// Forgets everything except first samples: no other sample reads it again, and filters read very many points.
    fn forget(&self) {
        self.known.borrow_mut().retain(|(_, point), _| {
            let point = point.map(f64::from_bits);
            self.first(point) == Some(point)
        });
    }

    /// Returns an output of a node at a point. Only filters recurse: whatever a node reads at its own point is
    /// evaluated before it.
    fn output(&self, id: NodeId, output: usize, at: [f64; 2]) -> Result<Reference, EvalError> {
        let key = at.map(f64::to_bits);
        let known = || self.known.borrow().get(&(id, key)).map(|outputs| outputs[output].clone());
        if let Some(value) = known() {
            return Ok(value);
        }
        for &node in self.frame.order(id).iter() {
            if !self.known.borrow().contains_key(&(node, key)) {
                let outputs = self.node(node, at)?;
                self.known.borrow_mut().insert((node, key), outputs);
            }
        }
        match known() {
            Some(value) => Ok(value),
            None => unreachable!("a node stands in its own order"),
        }
    }

    /// Returns the first sample of the pixel that contains a sample, if the document shades per pixel.
    fn first(&self, at: [f64; 2]) -> Option<[f64; 2]> {
        let format = self.frame.plan.graph.format();
        let pixel = at.map(f64::floor);
        let place = |sample: u32| {
            let offset = format.sample_offset(sample);
            [pixel[0] + offset[0], pixel[1] + offset[1]]
        };
        // Fields are evaluated only at the center, which is not a sample.
        let is_sample = format.samples() > 1 && (0..format.samples()).any(|sample| place(sample) == at);
        (is_sample && format.shading() == Shading::Pixel).then(|| place(0))
    }

    /// Returns the first sample of the pixel, if the sample at `at` reuses a stage's results from it.
    fn shares(&self, id: NodeId, at: [f64; 2]) -> Result<Option<[f64; 2]>, EvalError> {
        let Some(views) = &self.frame.plan.shared[id.0] else { return Ok(None) };
        let Some(first) = self.first(at).filter(|first| *first != at) else { return Ok(None) };
        for view in views {
            let told = |at: [f64; 2]| {
                self.output(*view, 0, at).map(|told| match told {
                    Reference::View(channels) => {
                        let [surface, depth] = SHARING_CHANNELS.map(|channel| channels[channel as usize]);
                        (surface, depth)
                    }
                    _ => unreachable!("stages share by views"),
                })
            };
            if !Shading::is_shared(told(first)?, told(at)?) {
                return Ok(None);
            }
        }
        Ok(Some(first))
    }

    fn node(&self, id: NodeId, at: [f64; 2]) -> Result<Vec<Reference>, EvalError> {
        if self.monitor.cancelled() {
            return Err(EvalError::Cancelled);
        }
        let plan = &self.frame.plan;
        let node = plan.graph.node(id);
        if let Some(first) = self.shares(id, at)? {
            return (0..node.kinds.len()).map(|output| self.output(id, output, first)).collect();
        }
        let Some(settled) = &plan.settled[id.0] else { return Ok(Vec::new()) };
        // The input callback cannot fail, so its error is kept and returned instead of the node's result.
        let failed = RefCell::new(None);
        let inputs = |source: &Source<Vec<f64>>, place: [f64; 2]| match source {
            Source::Output { node, output } => {
                let place = if place == at { at } else { self.frame.within(*node, place) };
                self.output(*node, *output, place).unwrap_or_else(|error| {
                    failed.borrow_mut().get_or_insert(error);
                    nothing(plan.graph.node(*node).kinds[*output])
                })
            }
            _ => unreachable!("literals are read where they stand"),
        };
        let inputs = References::new(&plan.context, at, &inputs).with_first(self.first(at).unwrap_or(at));
        let outputs = match settled.node().body() {
            Body::Pointwise(pointwise) => Ok(vec![pointwise.reference(&inputs)]),
            Body::Stage(_) => match self.frame.ready.get(&id) {
                Some(ready) => ready.prepared.reference(&inputs).map_err(|error| EvalError::of(plan.graph, id, error)),
                None => Ok(Vec::new()),
            },
        };
        match failed.into_inner() {
            Some(error) => Err(error),
            None => outputs,
        }
    }
}

/// Returns a value's channels.
fn numbers(value: Reference) -> Vec<f64> {
    match value {
        Reference::Color(color) => color.to_vec(),
        Reference::Mask(t) => vec![t],
        Reference::Weights(numbers) | Reference::Field(numbers) | Reference::View(numbers) => numbers,
        Reference::Handle(_) => Vec::new(),
    }
}

/// Returns a placeholder value of a kind.
fn nothing(kind: Kind) -> Reference {
    match kind {
        Kind::Color => Reference::Color([0.0; 3]),
        Kind::MASK => Reference::Mask(0.0),
        Kind::Weights(n) => Reference::Weights(vec![1.0 / n as f64; n]),
        Kind::View => Reference::View(vec![0.0; kind.channels()]),
        _ => Reference::Field(vec![0.0; kind.channels()]),
    }
}

impl std::fmt::Debug for ReferenceFrame<'_> {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        write!(f, "ReferenceFrame of {}", self.plan.graph.name())
    }
}
