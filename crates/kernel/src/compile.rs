//! Compiles a program to code that runs once per tile, once per row, and for every pixel.

use crate::audit::ValueRule;
use crate::code::{ColorOperand, CompiledProgram, Row};
use crate::generate::{GeneratorInput, Location, generate};
use crate::native::Native;
use crate::order::cost;
use crate::variance::variance;
use std::collections::HashMap;
use trochoid_graph::{NodeId, Op, Program, Slot, Type, Variance};
use trochoid_memory::Instructions;

/// How a program is compiled; never what it computes.
#[derive(Clone, Copy)]
pub struct Options<'a> {
    /// Compute values that do not vary per pixel once per tile or once per row.
    pub hoist: bool,
    /// Fuse operations, chain colors, and jump over branches without weight.
    pub fuse: bool,
    /// Also run what no root needs.
    pub everything: bool,
    /// Instruction sets that may be used.
    pub instructions: Instructions,
    /// Record the extremes of weights and of results, for reports.
    pub audits: bool,
    /// Run as machine code, if possible.
    pub native: bool,
    /// How a plane varies over the picture.
    pub variance: &'a dyn Fn(&Slot) -> Variance,
    /// Planes of the caller, and the values that are legal in them.
    pub rule: &'a dyn Fn(&Slot) -> Option<ValueRule>,
}

/// How often an operation runs.
#[derive(Clone, Copy, PartialEq)]
enum Frequency {
    /// It is a plane or a constant.
    Never,
    Tile,
    Row,
    Pixel,
}

/// Compiles what `roots` need.
pub fn compile(program: &Program, roots: &[u32], options: &Options<'_>) -> CompiledProgram {
    let ops = program.ops();
    let mut out = CompiledProgram { instructions: options.instructions, ..CompiledProgram::default() };
    let mut planes = PlaneList { slots: Vec::new(), known: HashMap::new() };
    let mut given = HashMap::new();
    let needed = if options.everything { vec![true; ops.len()] } else { needed(ops, roots) };
    for (at, (op, _)) in ops.iter().enumerate().filter(|(at, _)| needed[*at]) {
        match op {
            Op::Load(slot) => {
                given.insert(at as u32, Location::Scalar(planes.row(*slot)));
            }
            Op::LoadColor(slot) => {
                let rows = [0, 1, 2].map(|c| planes.row(Slot { channel: slot.channel + c, ..*slot }));
                given.insert(at as u32, Location::Color(ColorOperand::Rows(rows)));
            }
            _ => {}
        }
    }
    out.planes = planes.slots;
    let rates = rates(ops, roots, &needed, options);
    let hoists =
        [(Frequency::Tile, &mut out.column, Row::Column as fn(u32) -> Row), (Frequency::Row, &mut out.row, Row::Line)];
    for (rate, code, place) in hoists {
        let hoisted = hoisted(ops, roots, &needed, &rates, rate);
        if hoisted.is_empty() {
            continue;
        }
        *code = generate(GeneratorInput {
            ops,
            roots: &hoisted,
            given: given.clone(),
            fuse: options.fuse,
            everything: false,
            audits: options.audits,
            checks: Vec::new(),
        });
        for (&at, &(first, count)) in hoisted.iter().zip(&code.roots) {
            let row = |channel: usize| place((first + channel) as u32);
            let value = match ops[at as usize].0.ty() {
                Type::Scalar => Location::Scalar(row(0)),
                Type::Color => Location::Color(ColorOperand::Rows([row(0), row(1), row(2)])),
                Type::Partition(_) => Location::Partition((0..count).map(row).collect()),
            };
            given.insert(at, value);
        }
    }
    let checks =
        out.planes.iter().enumerate().filter_map(|(at, slot)| Some((at as u32, (options.rule)(slot)?))).collect();
    out.main = generate(GeneratorInput {
        ops,
        roots,
        given,
        fuse: options.fuse,
        everything: options.everything,
        audits: options.audits,
        checks,
    });
    if options.native {
        let (planes, columns, lines) = (out.planes.len(), out.column.channels(), out.row.channels());
        out.native = Native::new(&out.main, planes, columns, lines, options.instructions.level());
    }
    out.roots = out.main.roots.iter().map(|(_, count)| *count).collect();
    // Filling planes is counted as their stages' work.
    let is_load = |op: &Op| matches!(op, Op::Load(_) | Op::LoadColor(_));
    let run = ops.iter().enumerate().filter(|(at, (op, _))| needed[*at] && !is_load(op));
    out.costs = run.map(|(_, (op, origin))| (*origin, cost(op))).collect();
    out
}

/// Returns what the roots depend on, including the roots.
fn needed(ops: &[(Op, NodeId)], roots: &[u32]) -> Vec<bool> {
    let mut needed = vec![false; ops.len()];
    for &root in roots {
        needed[root as usize] = true;
    }
    for at in (0..ops.len()).rev() {
        if needed[at] {
            ops[at].0.operands(|operand| needed[operand as usize] = true);
        }
    }
    needed
}

/// Returns how often every operation has to run.
fn rates(ops: &[(Op, NodeId)], roots: &[u32], needed: &[bool], options: &Options<'_>) -> Vec<Frequency> {
    let mut variances = Vec::with_capacity(ops.len());
    for (op, _) in ops {
        variances.push(variance(op, &|operand| variances[operand as usize], options.variance));
    }
    let is_plane = |op: &Op| matches!(op, Op::Load(_) | Op::LoadColor(_) | Op::Constant(_) | Op::ConstantColor(_));
    let mut rates: Vec<Frequency> = ops
        .iter()
        .zip(&variances)
        .map(|((op, _), variance)| match variance {
            _ if is_plane(op) => Frequency::Never,
            // Only another name for a row of its partition.
            _ if matches!(op, Op::Weight(..)) => Frequency::Pixel,
            Variance::Constant | Variance::Column if options.hoist => Frequency::Tile,
            Variance::Row if options.hoist => Frequency::Row,
            _ => Frequency::Pixel,
        })
        .collect();
    // A mix of constants costs as much per channel as reading a row, and can be folded, so it runs where it is read.
    let is_constant = |at: u32| matches!(ops[at as usize].0, Op::ConstantColor(_));
    let mut read_by_pixels = vec![false; ops.len()];
    roots.iter().for_each(|&root| read_by_pixels[root as usize] = true);
    for at in (0..ops.len()).rev().filter(|&at| needed[at]) {
        if let Op::Mix { a, b, .. } = &ops[at].0
            && options.fuse
            && read_by_pixels[at]
            && is_constant(a.0)
            && is_constant(b.0)
        {
            rates[at] = Frequency::Pixel;
        }
        if rates[at] == Frequency::Pixel {
            ops[at].0.operands(|operand| read_by_pixels[operand as usize] = true);
        }
    }
    rates
}

/// Returns the operations of a rate that other operations, or the roots, read.
fn hoisted(ops: &[(Op, NodeId)], roots: &[u32], needed: &[bool], rates: &[Frequency], rate: Frequency) -> Vec<u32> {
    let mut read = vec![false; ops.len()];
    roots.iter().for_each(|&root| read[root as usize] = true);
    for at in (0..ops.len()).filter(|&at| needed[at] && rates[at] != rate) {
        ops[at].0.operands(|operand| read[operand as usize] = true);
    }
    (0..ops.len()).filter(|&at| needed[at] && read[at] && rates[at] == rate).map(|at| at as u32).collect()
}

/// Planes that a program reads, each once.
struct PlaneList {
    slots: Vec<Slot>,
    known: HashMap<Slot, u32>,
}

impl PlaneList {
    fn row(&mut self, slot: Slot) -> Row {
        Row::Plane(*self.known.entry(slot).or_insert_with(|| {
            self.slots.push(slot);
            (self.slots.len() - 1) as u32
        }))
    }
}
