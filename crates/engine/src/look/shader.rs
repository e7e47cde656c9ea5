//! Runs batches of a look.

use super::batch::Batch;
use super::error::ShadeError;
use super::illegal::{clamp, first_illegal};
use super::points::Points;
use super::samples::{Pixels, Samples, SamplesMut, Slices};
use super::{Illegal, Look};
use crate::BufferFault;
use self_cell::{MutBorrow, self_cell};
use std::ops::Range;
use trochoid_graph::Kind;
use trochoid_kernel::{BLOCK, Block, Chunks, Machine};
use trochoid_weights::sums;

type Running<'p> = Machine<'p>;

self_cell!(
    /// A machine, with the program and the memory that it runs on.
    struct Engine {
        owner: (Look, MutBorrow<Chunks>),

        #[not_covariant]
        dependent: Running,
    }
);

/// What one thread needs to run a look: its scratch memory, made once.
pub struct Shader {
    engine: Engine,
    blocks: Blocks,
}

/// A block of every plane and channel.
struct Blocks {
    inputs: Vec<Block>,
    outputs: Vec<Block>,
    sums: Box<[f64; BLOCK]>,
}

impl Look {
    /// Returns the program over samples; a shader is made only if there is one.
    fn points(&self) -> &Points {
        self.inner.points.as_ref().unwrap_or_else(|_| unreachable!("a shader has a program"))
    }
}

impl Shader {
    /// Makes the shader of a look that has a program over samples.
    pub(super) fn new(look: Look) -> Self {
        let points = look.points();
        let blocks = Blocks {
            inputs: vec![Block::ZERO; points.inputs.len()],
            outputs: vec![Block::ZERO; points.outputs.len()],
            sums: Box::new([0.0; BLOCK]),
        };
        let chunks = Chunks::of([&points.program]);
        let engine = Engine::new((look, MutBorrow::new(chunks)), |(look, chunks)| {
            Machine::new(&look.points().program, &mut chunks.borrow_mut().all())
        });
        Self { engine, blocks }
    }

    /// Returns the look.
    pub fn look(&self) -> &Look {
        &self.engine.borrow_owner().0
    }

    /// Evaluates `count` samples in slices: one for each channel of each slot in, one for each channel of the output out.
    /// Allocates nothing after the first batch. The results are those of pictures, bit for bit.
    ///
    /// # Errors
    /// Channels are missing or too short, or a sample is illegal.
    pub fn shade(
        &mut self,
        count: usize,
        inputs: &[Samples<'_>],
        outputs: &mut [SamplesMut<'_>],
    ) -> Result<(), ShadeError> {
        let look = self.look();
        let is_used = |channel: usize| look.points().reads(channel);
        let mut slices = Slices::new(inputs, is_used, outputs, [look.inputs(), look.channels()], count)?;
        let done = self.in_place(count, &mut slices);
        self.blocks(done..count, &mut slices)
    }

    /// Evaluates whole steps of samples where they are, if they follow one another or are the same for all; returns how
    /// many. Blocks do the rest, and all if something is illegal, or −0, or if they are few and no whole number of steps.
    fn in_place(&mut self, count: usize, slices: &mut Slices<'_, '_, '_>) -> usize {
        let Self { engine, blocks } = self;
        engine.with_dependent_mut(|(look, _), machine| {
            let rest = count % machine.step();
            let whole = if rest > 0 && count < BLOCK { 0 } else { count - rest };
            let points = look.points();
            let is_plain = look.illegal == Illegal::Refuse && points.partitions.is_empty();
            if whole == 0 || !is_plain || !slices.are_rows(points) {
                return 0;
            }
            // Uniform inputs stand in blocks, so the others are read by blocks too.
            let mut step = whole;
            for (block, (input, _)) in blocks.inputs.iter_mut().zip(&points.inputs) {
                if let Some(value) = slices.uniform(*input) {
                    block.0[..whole.min(BLOCK)].fill(value);
                    step = step.min(BLOCK);
                }
            }
            for start in (0..whole).step_by(step) {
                let range = start..whole.min(start + step);
                let count = range.len();
                let (inputs, outputs) = slices.rows(points, range, &blocks.inputs);
                machine.rows(inputs, count, outputs);
            }
            if machine.has_illegal_input() {
                machine.reset_checks();
                return 0;
            }
            whole
        })
    }

    /// Does the same, and writes the results as pixels: the channels of a sample side by side, and the samples `stride`
    /// numbers apart, such as 3 for RGB or 4 for RGBA, whose A is left alone.
    ///
    /// # Errors
    /// As [`shade`](Self::shade); also if the stride is less than the number of channels.
    pub fn shade_pixels(
        &mut self,
        count: usize,
        inputs: &[Samples<'_>],
        pixels: &mut [f32],
        stride: usize,
    ) -> Result<(), ShadeError> {
        let look = self.look();
        let is_used = |channel: usize| look.points().reads(channel);
        let mut pixels = Pixels::new(inputs, is_used, pixels, stride, [look.inputs(), look.channels()], count)?;
        self.run(count, &mut pixels)
    }

    /// Does the same with samples wherever they are.
    ///
    /// # Errors
    /// A sample is illegal.
    pub fn run<B: Batch + ?Sized>(&mut self, count: usize, batch: &mut B) -> Result<(), ShadeError> {
        self.blocks(0..count, batch)
    }

    fn blocks<B: Batch + ?Sized>(&mut self, range: Range<usize>, batch: &mut B) -> Result<(), ShadeError> {
        let Self { engine, blocks } = self;
        engine.with_dependent_mut(|(look, _), machine| {
            for start in range.clone().step_by(BLOCK) {
                block(look, machine, blocks, start, BLOCK.min(range.end - start), batch)?;
            }
            Ok(())
        })
    }
}

impl std::fmt::Debug for Shader {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        write!(f, "Shader of \"{}\"", self.look().output())
    }
}

/// Evaluates the samples of one block.
fn block<B: Batch + ?Sized>(
    look: &Look,
    machine: &mut Machine<'_>,
    blocks: &mut Blocks,
    start: usize,
    count: usize,
    batch: &mut B,
) -> Result<(), ShadeError> {
    let Blocks { inputs, outputs, sums } = blocks;
    let points = look.points();
    for (block, (input, kind)) in inputs.iter_mut().zip(&points.inputs) {
        let samples = &mut block.0[..count];
        batch.read(*input, start, samples);
        if look.illegal == Illegal::Clamp {
            clamp(*kind, samples);
        }
        // As for pictures, −0 becomes 0 in masks and colors, so that no bit depends on pruning.
        if !matches!(kind, Kind::Field(_)) {
            samples.iter_mut().for_each(|sample| *sample += 0.0);
        }
    }
    for (slot, planes) in &points.partitions {
        divide(look, *slot, planes, inputs, &mut sums[..count], start)?;
    }
    machine.block(inputs, count, outputs);
    if machine.has_illegal_input() {
        machine.reset_checks();
        if let Some(error) = fault(look, points, inputs, start, count) {
            return Err(error);
        }
    }
    for (block, output) in outputs.iter().zip(&points.outputs) {
        batch.write(*output, start, &block.0[..count]);
    }
    Ok(())
}

/// Divides the weights of a slot by their sum.
fn divide(
    look: &Look,
    slot: usize,
    planes: &[usize],
    inputs: &mut [Block],
    all: &mut [f64],
    start: usize,
) -> Result<(), ShadeError> {
    all.fill(0.0);
    for plane in planes {
        all.iter_mut().zip(&inputs[*plane].0).for_each(|(sum, weight)| *sum += f64::from(*weight));
    }
    if look.illegal == Illegal::Refuse {
        // A weight that is illegal by itself is told first.
        if planes.iter().any(|plane| is_suspicious(&inputs[*plane].0[..all.len()]))
            && let Some(error) = fault(look, look.points(), inputs, start, all.len())
        {
            return Err(error);
        }
        if let Some(at) = all.iter().position(|sum| sums::is_off(*sum)) {
            let (sample, name) = (start + at, look.slots()[slot].name.clone());
            return Err(ShadeError::Illegal { slot, name, sample, fault: BufferFault::Sum { sample, sum: all[at] } });
        }
    }
    for plane in planes {
        for (weight, sum) in inputs[*plane].0.iter_mut().zip(&*all) {
            *weight = sums::part(*weight, *sum, planes.len()) as f32;
        }
    }
    Ok(())
}

/// Whether one of some weights is illegal: the bits of numbers ≥ 0 sort like whole numbers, and those of negative numbers
/// and NaN above all of them.
fn is_suspicious(weights: &[f32]) -> bool {
    weights.iter().fold(0, |most, weight| weight.to_bits().max(most)) > 1.0_f32.to_bits()
}

/// Returns the first illegal sample of the first input that has one.
fn fault(look: &Look, points: &Points, inputs: &[Block], start: usize, count: usize) -> Option<ShadeError> {
    let planes = inputs.iter().zip(&points.inputs);
    let illegal = planes.filter_map(|(block, (input, kind))| {
        let at = first_illegal(*kind, &block.0[..count])?;
        Some((*input, at, block.0[at]))
    });
    let (input, at, found) = illegal.min_by_key(|(input, ..)| *input)?;
    let number = look.slots().iter().position(|slot| slot.has(input))?;
    let slot = &look.slots()[number];
    let (channel, sample, kind) = (input - slot.first, start + at, slot.kind);
    let fault = BufferFault::Value { channel, sample, found, kind };
    Some(ShadeError::Illegal { slot: number, name: slot.name.clone(), sample, fault })
}
