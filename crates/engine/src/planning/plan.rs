//! The plan: what some outputs need at one frame, in which order, and why the rest is left out.

use super::gates::Gates;
use super::planner::Planner;
use super::shading::ViewsByNode;
use crate::judge::Judge;
use crate::{Account, LeftOut, Settings};
use std::sync::{Arc, OnceLock};
use trochoid_graph::{
    CheckedGraph, FrameContext, Key, Kind, NodeId, PortId, Program, Purpose, Settled, Slot, Variance,
};
use trochoid_image::Window;
use trochoid_kernel::CompiledProgram;

/// Why a plan cannot be made.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
pub enum PlanError {
    /// The document has no output of this name.
    #[error("found the output \"{found}\"; expected one of: {known}")]
    UnknownOutput {
        /// Requested name.
        found: String,
        /// The document's outputs.
        known: String,
    },
    /// The region lies outside of the picture.
    #[error("the region {region} has no pixel in common with the picture {picture}: choose one within it")]
    Region {
        /// Requested region.
        region: Window,
        /// The picture's display window.
        picture: Window,
    },
    /// A buffer is bound to a node that takes none.
    #[error("cannot bind \"{name}\": {reason}")]
    Binding {
        /// Name as given.
        name: String,
        /// Reason why it cannot be bound.
        reason: BindingFault,
    },
}

/// Reason that a buffer cannot be bound.
#[derive(Clone, Copy, Debug, PartialEq, Eq, thiserror::Error)]
pub enum BindingFault {
    /// No node has this name.
    #[error("no node has that name")]
    NoNode,
    /// Buffers cannot hold the node's output.
    #[error("only Colors, masks, Weights and Fields can be bound; bind the passes instead")]
    NoImage,
    /// The name was given before.
    #[error("it is bound already: name it once")]
    Twice,
    /// Another output than the first of the node is needed, too.
    #[error("its output \"{0}\" is needed, and only the first output can be bound: bind the nodes that take it")]
    Output(&'static str),
}

/// Stage to fill in one pass: which planes, and from which inputs.
#[derive(Clone, Debug)]
pub(crate) struct Fill {
    pub(crate) node: NodeId,
    /// Channels to fill, by output and channel.
    pub(crate) wanted: Vec<Vec<bool>>,
    pub(crate) variance: Variance,
    /// Inputs: the port, and for each connection the sources of its channels.
    pub(crate) inputs: Vec<(PortId, Vec<Vec<Feed>>)>,
    /// Program of the pointwise values that the stage takes, run before it.
    pub(crate) taps: Option<CompiledProgram>,
    /// Whether most pixels of what the program reads are the same for all samples, though the stage's are not: then it
    /// runs again only where they differ.
    pub(crate) steady: bool,
    /// Whether the pass's own program reads the stage, so that it is needed over the whole tile.
    pub(crate) read: bool,
    /// Views that must see the same surface for a sample to reuse the result of the pixel's first sample; `None` if
    /// samples never reuse it.
    pub(crate) shared: Option<Vec<NodeId>>,
    /// Set of the pass's gates that are open where it shows; `None` if it may show everywhere.
    pub(crate) gates: Option<usize>,
}

impl Fill {
    /// Returns the slots that the stage reads, and the program before it.
    pub(crate) fn slots(&self) -> impl Iterator<Item = &Slot> {
        let feeds = self.inputs.iter().flat_map(|(_, connections)| connections.iter().flatten());
        let slots = feeds.filter_map(|feed| if let Feed::Slot(slot) = feed { Some(slot) } else { None });
        slots.chain(self.taps.iter().flat_map(|taps| &taps.planes))
    }

    /// Returns the number of planes that it fills.
    pub(crate) fn planes(&self) -> usize {
        self.wanted.iter().flatten().filter(|wanted| **wanted).count()
    }

    /// Returns whether it fills the plane of `slot`.
    pub(crate) fn fills(&self, slot: &Slot) -> bool {
        self.node == slot.node
            && self.wanted.get(slot.output).and_then(|channels| channels.get(slot.channel)) == Some(&true)
    }
}

/// Source of a plane of a stage's input.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) enum Feed {
    /// Not requested.
    Nothing,
    /// Plane that another stage filled.
    Slot(Slot),
    /// Value of the program before the stage: root and channel.
    Tap(usize, usize),
    /// Literal number.
    Constant(f32),
}

/// One walk over all samples: at these offsets, fill these stages, then run this program.
#[derive(Clone, Debug)]
pub(crate) struct Pass {
    pub(crate) offsets: Vec<[f64; 2]>,
    pub(crate) fills: Vec<Fill>,
    /// Where some of them show.
    pub(crate) gates: Option<Gates>,
    /// How far the stages reach beyond a tile, horizontally and vertically: the sum along the longest chain of
    /// filters. Tiles that are small compared with the halo compute most samples several times.
    pub(crate) halo: (usize, usize),
    /// Whether samples of a pixel share results.
    pub(crate) sharing: bool,
    pub(crate) program: CompiledProgram,
    /// The program for single pixels, if further samples are taken at these.
    pub(crate) scattered: Option<CompiledProgram>,
    /// Owners of the program's roots: index of the plan's output, and channel.
    pub(crate) roots: Vec<(usize, usize)>,
}

impl Pass {
    /// Returns all samples of a pixel.
    pub(crate) fn samples(&self) -> impl Iterator<Item = Sample> {
        self.offsets.iter().enumerate().map(|(index, offset)| Sample { index, offset: *offset })
    }

    /// Returns the plan's outputs that the pass makes, each once.
    pub(crate) fn outputs(&self) -> impl Iterator<Item = usize> {
        let mut outputs: Vec<usize> = self.roots.iter().map(|(output, _)| *output).collect();
        outputs.sort_unstable();
        outputs.dedup();
        outputs.into_iter()
    }
}

/// One of a pixel's samples.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Sample {
    pub(crate) index: usize,
    /// Position within the pixel.
    pub(crate) offset: [f64; 2],
}

/// An output within a plan.
#[derive(Clone, Debug)]
pub(crate) struct PlannedOutput {
    /// Index in the graph.
    pub(crate) index: usize,
    pub(crate) kind: Kind,
    /// Largest number of Mix operations on a path from a control to the output, for the rounding margin.
    pub(crate) mix_levels: usize,
    /// Constant control colors.
    pub(crate) constants: Vec<[f32; 3]>,
    /// Stages whose controls count as controls of this output.
    pub(crate) control_stages: Vec<NodeId>,
    /// Judge of the output, if all of its controls are colors in the document.
    pub(crate) judge: OnceLock<Arc<Judge>>,
}

/// A plan. It can only be made from a checked graph. [`Plan::check_memory`] tells whether its frame fits in memory.
#[derive(Debug)]
pub struct Plan<'g> {
    pub(crate) graph: &'g CheckedGraph,
    pub(crate) context: FrameContext,
    pub(crate) settings: Settings,
    pub(crate) window: Window,
    pub(crate) outputs: Vec<PlannedOutput>,
    pub(crate) passes: Vec<Pass>,
    /// Program of the nodes before optimization, and the positions of each output's channels in it.
    pub(crate) source: (Program, Vec<Vec<u32>>),
    /// Stages to prepare, in order, with the channels that any pass wants.
    pub(crate) prepares: Vec<(NodeId, Vec<Vec<bool>>)>,
    pub(crate) settled: Vec<Option<Settled>>,
    pub(crate) keys: Vec<Key>,
    pub(crate) bound: Vec<bool>,
    /// Thread pool, made when first needed.
    pub(crate) pool: OnceLock<Result<rayon::ThreadPool, Arc<rayon::ThreadPoolBuildError>>>,
    /// Stages whose results samples share.
    pub(crate) shared: ViewsByNode,
    /// Reason that each node is left out; `None` if it is evaluated.
    pub(crate) left_out: Vec<Option<LeftOut>>,
}

impl<'g> Plan<'g> {
    /// Plans some outputs of a graph at a frame.
    ///
    /// `bound` names nodes whose first output the caller will supply as buffers when the plan runs; nodes that only
    /// they need are left out.
    ///
    /// # Errors
    /// Unknown outputs or bindings, a bound node of which another output is needed, or a region outside the picture.
    pub fn new(
        graph: &'g CheckedGraph,
        outputs: &[&str],
        frame: i64,
        bound: &[&str],
        settings: &Settings,
    ) -> Result<Self, PlanError> {
        Self::made(graph, outputs, frame, bound, settings, None)
    }

    /// Makes the same plan as [`Plan::new`], and says what happens to each node of the graph, in the graph's order,
    /// with proofs.
    ///
    /// # Errors
    /// Same as [`Plan::new`].
    pub fn explained(
        graph: &'g CheckedGraph,
        outputs: &[&str],
        frame: i64,
        bound: &[&str],
        settings: &Settings,
    ) -> Result<(Self, Vec<Account>), PlanError> {
        let mut accounts = Vec::new();
        let plan = Self::made(graph, outputs, frame, bound, settings, Some(&mut accounts))?;
        Ok((plan, accounts))
    }

    fn made(
        graph: &'g CheckedGraph,
        outputs: &[&str],
        frame: i64,
        bound: &[&str],
        settings: &Settings,
        accounts: Option<&mut Vec<Account>>,
    ) -> Result<Self, PlanError> {
        let picture = graph.format().window();
        let window = settings.region.unwrap_or(picture).intersect(picture);
        if window.is_empty() {
            return Err(PlanError::Region { region: settings.region.unwrap_or(picture), picture });
        }
        let chosen = choose_outputs(graph, outputs)?;
        let bound = bind(graph, bound)?;
        let context = graph.frame_context(frame, settings.memory_limit);
        let plan = Planner { graph, settings, bound, frame }.plan(&chosen, context, window, accounts);
        plan.needs_what_is_bound()?;
        Ok(plan)
    }

    /// Checks that only the first outputs of bound nodes are needed.
    fn needs_what_is_bound(&self) -> Result<(), PlanError> {
        for fill in self.passes.iter().flat_map(|pass| &pass.fills).filter(|fill| self.bound[fill.node.0]) {
            if let Some(output) = fill.wanted.iter().skip(1).position(|channels| channels.contains(&true)) {
                let node = self.graph.node(fill.node);
                let reason = BindingFault::Output(node.ty.declaration().outputs[output + 1].name);
                return Err(PlanError::Binding { name: node.name.clone(), reason });
            }
        }
        Ok(())
    }

    /// Returns the frame.
    pub fn frame(&self) -> i64 {
        self.context.frame
    }

    /// Returns the pixels that the plan evaluates.
    pub fn window(&self) -> Window {
        self.window
    }

    /// Returns the outputs, as indices in the graph.
    pub fn outputs(&self) -> Vec<usize> {
        self.outputs.iter().map(|output| output.index).collect()
    }

    /// Returns how far any pass reaches beyond a tile, horizontally and vertically: the sum along the longest chain
    /// of filters.
    pub fn halo(&self) -> (usize, usize) {
        self.passes.iter().fold((0, 0), |halo, pass| (halo.0.max(pass.halo.0), halo.1.max(pass.halo.1)))
    }

    /// Returns the part of the picture for which stages prepare, with what filters need around the region; `None` for all
    /// of it.
    pub(crate) fn part(&self) -> Option<Window> {
        let (across, down) = self.halo();
        let (across, down) = (across as i64, down as i64);
        let Window { x0, y0, x1, y1 } = self.window;
        let around = Window::new(x0 - across, y0 - down, x1 + across, y1 + down);
        // Bounds and references look at single pixels.
        let is_local =
            self.settings.local && self.settings.region.is_some() && self.settings.purpose == Purpose::Pictures;
        is_local.then(|| around.intersect(self.graph.format().window()))
    }

    /// Returns why each node of the graph is left out; `None` where it is evaluated.
    pub fn left_out(&self) -> &[Option<LeftOut>] {
        &self.left_out
    }

    /// Returns the notes of the nodes that are evaluated, as sentences.
    pub fn notes(&self) -> Vec<(NodeId, Vec<String>)> {
        let evaluated = self.left_out.iter().zip(&self.settled).enumerate().filter(|(_, (why, _))| why.is_none());
        evaluated
            .filter_map(|(index, (_, settled))| {
                let notes = settled.as_ref()?.node().notes(self.graph.times());
                (!notes.is_empty()).then_some((NodeId(index), notes))
            })
            .collect()
    }
}

fn choose_outputs(graph: &CheckedGraph, names: &[&str]) -> Result<Vec<usize>, PlanError> {
    if names.is_empty() {
        return Ok((0..graph.outputs().len()).collect());
    }
    let mut chosen = Vec::new();
    for name in names {
        let index = graph.outputs().iter().position(|output| output.name == *name).ok_or_else(|| {
            let known: Vec<&str> = graph.outputs().iter().map(|output| output.name.as_str()).collect();
            PlanError::UnknownOutput { found: (*name).into(), known: known.join(", ") }
        })?;
        if !chosen.contains(&index) {
            chosen.push(index);
        }
    }
    Ok(chosen)
}

fn bind(graph: &CheckedGraph, names: &[&str]) -> Result<Vec<bool>, PlanError> {
    let mut bound = vec![false; graph.nodes().len()];
    for name in names {
        let fault = |reason| PlanError::Binding { name: (*name).into(), reason };
        let id = graph.find(name).ok_or_else(|| fault(BindingFault::NoNode))?;
        let kind = graph.node(id).kinds.first().copied();
        if !matches!(kind, Some(Kind::Color | Kind::Weights(_) | Kind::Field(_))) {
            return Err(fault(BindingFault::NoImage));
        }
        if std::mem::replace(&mut bound[id.0], true) {
            return Err(fault(BindingFault::Twice));
        }
    }
    Ok(bound)
}
