//! Inspects one pixel in detail: which controls it is mixed from, and how errors of its passes reach it.

use super::fill::Fills;
use super::memory::Pictures;
use super::prepare::prepare;
use super::run::programs;
use crate::rules::blame::blame;
use crate::rules::evaluate::{Values, evaluate};
use crate::{Buffers, Cache, EvalError, Monitor, Plan, Settings};
use std::collections::HashMap;
use trochoid_graph::{NodeId, Op, Program, Purpose, Slot};
use trochoid_image::Window;
use trochoid_kernel::Chunks;

/// A pixel and the controls that it is mixed from.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct InspectedPixel {
    /// Value by channel, averaged like the picture's; colors are in the working space. It is computed in f64, so it
    /// may differ from the picture's value in the last digits.
    pub value: Vec<f64>,
    /// Control colors of a Color, each color of a node once, the largest share first; empty for other kinds.
    pub blame: Vec<Blame>,
}

/// A control color's share of a pixel.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Blame {
    /// Node that holds the control color.
    pub node: NodeId,
    /// Control color, in the working space.
    pub color: [f64; 3],
    /// Weight of the color; the weights of a pixel sum to 1.
    pub weight: f64,
}

impl Plan<'_> {
    /// Returns the value of an output at a pixel, and the control colors that it is mixed from; `None` if the plan
    /// has no such output or the picture no such pixel.
    ///
    /// `output` is an index among the outputs of the graph. The mix is that of the document, before optimizations
    /// fold any of it. A color that a stage makes, such as one read from a file or filtered, counts as a control of
    /// that stage's node; if several nodes compute the same, the first counts for all of them. The call costs as much
    /// as a tile of one pixel: stages that the cache holds are not prepared again.
    ///
    /// ```
    /// # use trochoid_engine::{Buffers, Cache, Plan, Settings, Silent};
    /// # fn show(graph: &trochoid_graph::CheckedGraph) -> Result<(), Box<dyn std::error::Error>> {
    /// let plan = Plan::new(graph, &["beauty"], 1, &[], &Settings::default())?;
    /// let output = plan.outputs()[0];
    /// let pixel = plan.inspect(output, [640, 360], &Buffers::new(), &mut Cache::new(), &Silent)?;
    /// for share in pixel.unwrap_or_default().blame {
    ///     println!("{:3.0} % {:?} of {}", 100.0 * share.weight, share.color, graph.node(share.node).name);
    /// }
    /// # Ok(())
    /// # }
    /// ```
    ///
    /// # Errors
    /// Same as [`Plan::evaluate`].
    pub fn inspect(
        &self,
        output: usize,
        [x, y]: [i64; 2],
        buffers: &Buffers<'_>,
        cache: &mut Cache,
        monitor: &dyn Monitor,
    ) -> Result<Option<InspectedPixel>, EvalError> {
        let graph = self.graph;
        let window = Window::new(x, y, x.saturating_add(1), y.saturating_add(1));
        let own = self.outputs.iter().position(|own| own.index == output);
        let Some(own) = own.filter(|_| graph.format().window().intersect(window) == window && !window.is_empty())
        else {
            return Ok(None);
        };
        // Plan the same outputs, so that stages are asked for the same channels and the cache recognizes what they
        // prepared.
        let names: Vec<&str> = self.outputs.iter().map(|own| graph.outputs()[own.index].name.as_str()).collect();
        let bound = self.bound.iter().enumerate().filter(|(_, bound)| **bound);
        let bound: Vec<&str> = bound.map(|(id, _)| graph.node(NodeId(id)).name.as_str()).collect();
        let settings = Settings {
            region: Some(window),
            tile: None,
            threads: 0,
            compile_from: usize::MAX,
            purpose: Purpose::Pictures,
            exact: None,
            ..self.settings.clone()
        };
        let Ok(plan) = Plan::new(graph, &names, self.frame(), &bound, &settings) else {
            unreachable!("a pixel of a picture can be planned where the picture could")
        };
        self.in_pool(|| plan.pixel(own, buffers, cache, monitor)).map(Some)
    }

    /// Inspects the only pixel of the plan.
    fn pixel(
        &self,
        output: usize,
        buffers: &Buffers<'_>,
        cache: &mut Cache,
        monitor: &dyn Monitor,
    ) -> Result<InspectedPixel, EvalError> {
        self.validate(buffers)?;
        let (ready, _) = prepare(self, cache, monitor, Pictures::Rows)?;
        let (program, roots) = (&self.source.0, &self.source.1[output]);
        let mut chunks = Chunks::of(self.passes.iter().flat_map(programs));
        let mut chunks = chunks.all();
        let mut seconds = vec![0.0; self.graph.nodes().len()];
        let mut found = InspectedPixel::default();
        let passes = self.passes.iter().filter(|pass| pass.roots.iter().any(|(owner, _)| *owner == output));
        for pass in passes {
            let mut fills = Fills::new(self, &ready, buffers, pass, monitor, &mut chunks);
            let share = 1.0 / pass.offsets.len() as f64;
            for sample in pass.samples() {
                fills.fill(self.window, sample, &mut seconds)?;
                let planes = fills.planes(&pass.program);
                buffers.normalized(self, &pass.program.planes, &planes, self.window)?;
                let slots = pass.program.planes.iter().zip(&planes);
                let values: HashMap<&Slot, f64> =
                    slots.map(|(slot, plane)| (slot, f64::from(plane.row(0, 1)[0]))).collect();
                // Planes that no pixel depends on are not filled; any value will do for them.
                let inspection = Inspection::new(program, &|slot| values.get(slot).copied().unwrap_or_default());
                found.add(&inspection, roots, share);
            }
        }
        cache.trim();
        found.blame.sort_by(|a, b| b.weight.total_cmp(&a.weight));
        Ok(found)
    }
}

impl InspectedPixel {
    /// Adds the share of one sample.
    fn add(&mut self, inspection: &Inspection, roots: &[u32], share: f64) {
        let values: Vec<f64> = roots.iter().flat_map(|root| inspection.value(*root).iter().copied()).collect();
        self.value.resize(values.len(), 0.0);
        self.value.iter_mut().zip(values).for_each(|(sum, value)| *sum += share * value);
        for part in roots.iter().flat_map(|root| inspection.blame(*root)) {
            let weight = share * part.weight;
            match self.blame.iter_mut().find(|own| own.node == part.node && own.color == part.color) {
                Some(own) => own.weight += weight,
                None => self.blame.push(Blame { weight, ..part }),
            }
        }
    }
}

/// A program evaluated in f64 at one sample.
#[derive(Clone, Debug)]
pub struct Inspection {
    program: Program,
    values: Vec<Values>,
}

impl Inspection {
    /// Evaluates a program at a sample; `input` returns the value of each plane loaded.
    pub fn new(program: &Program, input: &dyn Fn(&Slot) -> f64) -> Self {
        let mut values: Vec<Values> = Vec::with_capacity(program.ops().len());
        for (op, _) in program.ops() {
            let channel = |slot: &Slot, channel: usize| input(&Slot { channel, ..*slot });
            values.push(evaluate(op, &|id| values[id as usize].clone(), &channel));
        }
        Self { program: program.clone(), values }
    }

    /// Returns the value at a position of the program.
    pub fn value(&self, position: u32) -> &[f64] {
        &self.values[position as usize]
    }

    /// Returns the control colors of a color and their weights, which sum to 1; controls of weight 0 are left out.
    pub fn blame(&self, position: u32) -> Vec<Blame> {
        let mut shares = vec![0.0; self.program.ops().len()];
        shares[position as usize] = 1.0;
        let mut found = Vec::new();
        for at in (0..=position as usize).rev() {
            let share = shares[at];
            if share == 0.0 {
                continue;
            }
            let (op, origin) = &self.program.ops()[at];
            blame(op, share, &|id| self.values[id as usize].clone(), &mut |operand, part| {
                shares[operand as usize] += part;
            });
            if let (Op::ConstantColor(_) | Op::LoadColor(_), [r, g, b]) = (op, self.values[at].as_slice()) {
                found.push(Blame { node: *origin, color: [*r, *g, *b], weight: share });
            }
        }
        found
    }
}
