//! What is needed for some outputs at one frame, in which order, and why the rest is not.

use super::planner::Planner;
use super::shading::Shared;
use crate::judge::Judge;
use crate::kernel::Compiled;
use crate::{Account, LeftOut, Settings};
use std::sync::{Arc, OnceLock};
use trochoid_graph::{CheckedGraph, FrameContext, Key, Kind, NodeId, PortId, Program, Settled, Slot, Variance};
use trochoid_image::Window;

/// Why a plan cannot be made.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
pub enum PlanError {
    /// An output's name is none of the document's.
    #[error("found the output \"{found}\"; expected one of: {known}")]
    UnknownOutput {
        /// The name asked for.
        found: String,
        /// The document's outputs.
        known: String,
    },
    /// The region lies outside the picture.
    #[error("the region {region} has no pixel in common with the picture {picture}: choose one within it")]
    Region {
        /// The region asked for.
        region: Window,
        /// The picture's display window.
        picture: Window,
    },
    /// A buffer is bound to something that takes none.
    #[error("cannot bind \"{name}\": {reason}")]
    Binding {
        /// The name as given.
        name: String,
        /// What is wrong with it.
        reason: BindingFault,
    },
    /// Shading samples need every front-end node bound.
    #[error("shading samples cannot be evaluated from \"{name}\" (a {ty}): bind it to a buffer")]
    Unbound {
        /// The node.
        name: String,
        /// Its type.
        ty: String,
    },
}

/// Why a buffer cannot be bound.
#[derive(Clone, Copy, Debug, PartialEq, Eq, thiserror::Error)]
pub enum BindingFault {
    /// There is no such node.
    #[error("no node has that name")]
    NoNode,
    /// The node makes nothing that buffers hold.
    #[error("only Colors, masks, Weights and Fields can be bound; bind the passes instead")]
    NoImage,
}

/// A stage to fill in one pass: which planes, from what.
#[derive(Clone, Debug)]
pub(crate) struct Fill {
    pub(crate) node: NodeId,
    /// By output, by channel.
    pub(crate) wanted: Vec<Vec<bool>>,
    pub(crate) variance: Variance,
    /// The inputs: port, and for each connection the planes of its channels.
    pub(crate) inputs: Vec<(PortId, Vec<Vec<Feed>>)>,
    /// The pointwise values that it takes, computed before it.
    pub(crate) taps: Option<Compiled>,
    /// Whether the pass' own program reads it, so that it is needed over the whole tile.
    pub(crate) read: bool,
    /// The views that must see the same surface for a sample to take the result at the pixel's first one; `None` where it
    /// never does.
    pub(crate) shared: Option<Vec<NodeId>>,
}

impl Fill {
    /// Whether it fills a plane.
    pub(crate) fn fills(&self, slot: &Slot) -> bool {
        self.node == slot.node
            && self.wanted.get(slot.output).and_then(|channels| channels.get(slot.channel)) == Some(&true)
    }
}

/// Where a plane of a stage's input comes from.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) enum Feed {
    /// Not asked for.
    Nothing,
    /// A plane that another stage filled.
    Slot(Slot),
    /// A value of the program before it: root and channel.
    Tap(usize, usize),
    /// A literal.
    Constant(f32),
}

/// One walk over all samples: at these offsets, fill these stages, then run this program.
#[derive(Clone, Debug)]
pub(crate) struct Pass {
    pub(crate) offsets: Vec<[f64; 2]>,
    pub(crate) fills: Vec<Fill>,
    /// How far beyond a tile, across and down, its stages reach: the sum along the longest chain of filters. Tiles that
    /// are small against it compute most samples several times.
    pub(crate) halo: (usize, usize),
    /// Whether samples of a pixel share.
    pub(crate) sharing: bool,
    pub(crate) program: Compiled,
    /// The outputs that the program's roots belong to: output of the plan, first channel.
    pub(crate) roots: Vec<(usize, usize)>,
}

/// An output within a plan.
#[derive(Clone, Debug)]
pub(crate) struct PlannedOutput {
    /// Index in the graph.
    pub(crate) index: usize,
    pub(crate) kind: Kind,
    /// Most Mix operations on a path from a control to the output, for the margin of rounding.
    pub(crate) mix_levels: usize,
    /// Constant control colors.
    pub(crate) constants: Vec<[f32; 3]>,
    /// Stages whose controls count.
    pub(crate) control_stages: Vec<NodeId>,
    /// What it is judged by, where the document's own colors are all of its controls.
    pub(crate) judge: OnceLock<Arc<Judge>>,
}

/// A plan: having one is the proof that its graph is checked. That its frame fits in memory, [`Plan::check_memory`] tells.
#[derive(Debug)]
pub struct Plan<'g> {
    pub(crate) graph: &'g CheckedGraph,
    pub(crate) context: FrameContext,
    pub(crate) settings: Settings,
    pub(crate) window: Window,
    pub(crate) outputs: Vec<PlannedOutput>,
    pub(crate) passes: Vec<Pass>,
    /// What nodes say before anything is optimized, and by output where its channels stand in it.
    pub(crate) source: (Program, Vec<Vec<u32>>),
    /// Stages to prepare, in order, with the channels wanted by any pass.
    pub(crate) prepares: Vec<(NodeId, Vec<Vec<bool>>)>,
    pub(crate) settled: Vec<Option<Settled>>,
    pub(crate) keys: Vec<Key>,
    pub(crate) bound: Vec<bool>,
    /// The threads, once they are needed.
    pub(crate) pool: OnceLock<Result<rayon::ThreadPool, Arc<rayon::ThreadPoolBuildError>>>,
    /// What samples share.
    pub(crate) shared: Shared,
    /// By node: `None` where it is evaluated.
    pub(crate) left_out: Vec<Option<LeftOut>>,
}

impl<'g> Plan<'g> {
    /// Plans some outputs of a graph at a frame.
    ///
    /// `bound` names nodes whose first output the caller will supply as buffers when the plan runs; what only
    /// they needed is left out.
    ///
    /// # Errors
    /// Unknown outputs or bindings, or a region outside the picture.
    pub fn new(
        graph: &'g CheckedGraph,
        outputs: &[&str],
        frame: i64,
        bound: &[&str],
        settings: &Settings,
    ) -> Result<Self, PlanError> {
        Self::made(graph, outputs, frame, bound, settings, None)
    }

    /// The same plan, and what becomes of each node of the graph in it, in the graph's order, with the proofs.
    ///
    /// # Errors
    /// As [`Plan::new`].
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
        Ok(Planner { graph, settings, bound, frame }.plan(&chosen, context, window, accounts))
    }

    /// The frame.
    pub fn frame(&self) -> i64 {
        self.context.frame
    }

    /// The pixels that the plan evaluates.
    pub fn window(&self) -> Window {
        self.window
    }

    /// The outputs, as indices in the graph.
    pub fn outputs(&self) -> Vec<usize> {
        self.outputs.iter().map(|output| output.index).collect()
    }

    /// How far beyond a tile, across and down, any pass reaches: the sum along the longest chain of filters.
    pub fn halo(&self) -> (usize, usize) {
        self.passes.iter().fold((0, 0), |halo, pass| (halo.0.max(pass.halo.0), halo.1.max(pass.halo.1)))
    }

    /// Why each node of the graph is left out; `None` where it is evaluated.
    pub fn left_out(&self) -> &[Option<LeftOut>] {
        &self.left_out
    }

    /// What the nodes that are evaluated have to say, in sentences.
    pub fn notes(&self) -> Vec<(NodeId, Vec<String>)> {
        let evaluated = self.left_out.iter().zip(&self.settled).enumerate().filter(|(_, (why, _))| why.is_none());
        evaluated
            .filter_map(|(index, (_, settled))| {
                let notes = settled.as_ref()?.node().notes();
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
        bound[id.0] = true;
    }
    Ok(bound)
}
