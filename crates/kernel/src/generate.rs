//! Generates instructions from steps: assigns chunks, chains colors through the accumulator, and folds mixes of
//! constants into the instructions that read them.

use crate::audit::ValueRule;
use crate::code::{Code, ColorOperand, Instruction, Row};
use crate::order::{Order, Step};
use std::collections::{BTreeMap, HashMap, HashSet};
use trochoid_graph::{NodeId, Op, Type};

/// Location of an operation's result.
#[derive(Clone, Debug)]
pub(crate) enum Location {
    Scalar(Row),
    Color(ColorOperand),
    Partition(Vec<Row>),
}

/// Input of code generation.
pub(crate) struct GeneratorInput<'a> {
    pub(crate) ops: &'a [(Op, NodeId)],
    pub(crate) roots: &'a [u32],
    /// Values that are already computed: planes, and results of earlier code.
    pub(crate) given: HashMap<u32, Location>,
    /// Whether to fold operations into each other; otherwise each one is an instruction.
    pub(crate) fuse: bool,
    /// Whether to run also what no root needs.
    pub(crate) everything: bool,
    /// Whether to record the extremes of weights and of results.
    pub(crate) audits: bool,
    /// Planes to check against the rules of their kinds.
    pub(crate) checks: Vec<(u32, ValueRule)>,
}

/// Generates code.
pub(crate) fn generate(input: GeneratorInput<'_>) -> Code {
    let is_constant = |at: u32| matches!(input.ops[at as usize].0, Op::Constant(_) | Op::ConstantColor(_));
    let given = |at: u32| input.given.contains_key(&at) || is_constant(at);
    let mut wanted = input.roots.to_vec();
    if input.everything {
        wanted.extend(0..input.ops.len() as u32);
    }
    let order = Order::new(input.ops, &wanted, &given, input.fuse);
    let steps = order.steps(&wanted);
    let mut last = vec![0usize; input.ops.len()];
    for (index, step) in steps.iter().enumerate() {
        let Step::Run(at) = step else { continue };
        note_reads(input.ops, &order, *at, index, &mut last);
    }
    let mut expiring = vec![Vec::new(); steps.len()];
    for step in &steps {
        if let Step::Run(at) = step
            && order.uses[*at as usize] > 0
        {
            expiring[last[*at as usize]].push(*at);
        }
    }
    let mut roots_of: HashMap<u32, Vec<u32>> = HashMap::new();
    for (root, &at) in input.roots.iter().enumerate() {
        roots_of.entry(at).or_default().push(root as u32);
    }
    let mut generator = Generator {
        code: Code { checks: input.checks.clone(), audits: input.audits, ..Code::default() },
        values: input.given.clone(),
        input: &input,
        order: &order,
        steps: &steps,
        roots_of,
        free: Vec::new(),
        constants: HashMap::new(),
        accumulated: None,
        audited: vec![HashSet::new()],
        unchecked: input.checks.iter().enumerate().map(|(index, &(plane, _))| (plane, index as u32)).collect(),
        gates: Vec::new(),
    };
    generator.layout_roots();
    for (index, step) in steps.iter().enumerate() {
        match *step {
            Step::Open { mix, closed } => generator.open(mix, closed),
            Step::Run(at) => generator.run(index, at),
        }
        for &at in &expiring[index] {
            generator.release(at);
        }
    }
    generator.finish_roots();
    generator.check_rest();
    generator.code
}

/// Marks every operation whose rows step `index` reads, directly, through operations folded into it, and through
/// weights.
fn note_reads(ops: &[(Op, NodeId)], order: &Order<'_>, at: u32, index: usize, last: &mut [usize]) {
    ops[at as usize].0.operands(|operand| {
        last[operand as usize] = last[operand as usize].max(index);
        match &ops[operand as usize].0 {
            Op::Mix { t, .. } if order.inline[operand as usize] => {
                last[t.0 as usize] = last[t.0 as usize].max(index);
                note_partition(ops, t.0, index, last);
            }
            _ => note_partition(ops, operand, index, last),
        }
    });
}

/// Marks a weight's partition as read too, since a weight is one of its rows.
fn note_partition(ops: &[(Op, NodeId)], at: u32, index: usize, last: &mut [usize]) {
    if let Op::Weight(partition, _) = &ops[at as usize].0 {
        last[partition.0 as usize] = last[partition.0 as usize].max(index);
    }
}

struct Generator<'a> {
    input: &'a GeneratorInput<'a>,
    order: &'a Order<'a>,
    steps: &'a [Step],
    code: Code,
    values: HashMap<u32, Location>,
    roots_of: HashMap<u32, Vec<u32>>,
    free: Vec<u32>,
    /// Own rows that hold a constant, by its bits.
    constants: HashMap<u32, u32>,
    /// Operation whose color is only in the accumulator.
    accumulated: Option<u32>,
    /// Masks and partitions that were audited, by position: in code that always runs, and within each open gate.
    audited: Vec<HashSet<u32>>,
    /// Planes that still have to be checked against the rule of their kind, with the index of each check.
    unchecked: BTreeMap<u32, u32>,
    /// Open gates: the mix, and the position of the gate's instruction.
    gates: Vec<(u32, usize)>,
}

impl Generator<'_> {
    fn op(&self, at: u32) -> &Op {
        &self.input.ops[at as usize].0
    }

    fn layout_roots(&mut self) {
        let mut first = 0;
        for &root in self.input.roots {
            let count = match self.op(root).ty() {
                Type::Scalar => 1,
                Type::Color => 3,
                Type::Partition(n) => n,
            };
            self.code.roots.push((first, count));
            self.code.colors.push(self.op(root).ty() == Type::Color);
            first += count;
        }
    }

    fn allocate(&mut self) -> u32 {
        self.free.pop().unwrap_or_else(|| {
            self.code.own += 1;
            (self.code.own - 1) as u32
        })
    }

    /// Frees the rows of a value after its last reader.
    fn release(&mut self, at: u32) {
        // A weight is a row of its partition.
        if matches!(self.op(at), Op::Weight(..)) {
            return;
        }
        let rows = match self.values.get(&at) {
            Some(Location::Scalar(row)) => vec![*row],
            Some(Location::Color(ColorOperand::Rows(rows))) => rows.to_vec(),
            Some(Location::Partition(rows)) => rows.clone(),
            _ => return,
        };
        self.free.extend(rows.into_iter().filter_map(|row| if let Row::Own(row) = row { Some(row) } else { None }));
    }

    /// Returns the row of a scalar; a constant gets its own row permanently.
    fn scalar(&mut self, at: u32) -> Row {
        if let Some(&Location::Scalar(row)) = self.values.get(&at) {
            self.check(row);
            return row;
        }
        match *self.op(at) {
            Op::Constant(value) => {
                let known = self.constants.get(&value.to_bits()).copied();
                Row::Own(known.unwrap_or_else(|| {
                    // Never a row that was used before, since it is filled only once.
                    let row = self.code.own as u32;
                    self.code.own += 1;
                    self.code.constants.push((row, value));
                    self.constants.insert(value.to_bits(), row);
                    row
                }))
            }
            _ => unreachable!("operands run before their readers"),
        }
    }

    /// Checks a plane right before it is first read, so that its loads overlap with other computations.
    fn check(&mut self, row: Row) {
        if let Row::Plane(plane) = row
            && let Some(index) = self.unchecked.remove(&plane)
        {
            self.code.list.push(Instruction::Check { plane, index });
        }
    }

    /// Checks all planes that are not yet checked.
    fn check_rest(&mut self) {
        let rest = std::mem::take(&mut self.unchecked);
        self.code.list.extend(rest.into_iter().map(|(plane, index)| Instruction::Check { plane, index }));
    }

    fn scalars(&mut self, of: &[trochoid_graph::Scalar]) -> Vec<Row> {
        of.iter().map(|scalar| self.scalar(scalar.0)).collect()
    }

    fn partition(&self, at: u32) -> Vec<Row> {
        match self.values.get(&at) {
            Some(Location::Partition(rows)) => rows.clone(),
            _ => unreachable!("operands run before their readers"),
        }
    }

    fn color(&mut self, at: u32) -> ColorOperand {
        if self.accumulated == Some(at) {
            return ColorOperand::Last;
        }
        if let Some(&Location::Color(source)) = self.values.get(&at) {
            if let ColorOperand::Rows(rows) = source {
                rows.into_iter().for_each(|row| self.check(row));
            }
            return source;
        }
        match *self.op(at) {
            Op::ConstantColor(color) => ColorOperand::Constant(color),
            Op::Mix { a, b, t } if self.order.inline[at as usize] => match (self.op(a.0), self.op(b.0)) {
                (Op::ConstantColor(from), Op::ConstantColor(to)) => {
                    let (from, to) = (*from, *to);
                    ColorOperand::Pair { from, to, by: self.scalar(t.0) }
                }
                _ => unreachable!("only mixes of constants are folded"),
            },
            _ => unreachable!("operands run before their readers"),
        }
    }

    /// Opens a gate: the instructions that follow are jumped over where the mask is all `closed`.
    fn open(&mut self, mix: u32, closed: f32) {
        let Op::Mix { a, b, t } = *self.op(mix) else { unreachable!("gates are at mixes") };
        self.audit_mask(t.0);
        // Planes that are only read behind the gate are checked all the same.
        self.check_rest();
        let otherwise = self.color(if closed == 0.0 { a.0 } else { b.0 });
        let t = self.scalar(t.0);
        self.audited.push(HashSet::new());
        self.gates.push((mix, self.code.list.len()));
        self.code.list.push(Instruction::Gate { t, closed, otherwise, skip: 0 });
    }

    /// Returns whether a mask or a partition still has to be audited here; afterwards it counts as audited.
    fn is_unaudited(&mut self, at: u32) -> bool {
        let is_new = self.code.audits && !self.audited.iter().any(|done| done.contains(&at));
        if is_new && let Some(innermost) = self.audited.last_mut() {
            innermost.insert(at);
        }
        is_new
    }

    /// Audits a mask, once.
    fn audit_mask(&mut self, at: u32) {
        if !self.is_unaudited(at) {
            return;
        }
        let row = self.scalar(at);
        let checked =
            self.input.checks.iter().any(|(plane, rule)| row == Row::Plane(*plane) && *rule == ValueRule::Mask);
        if !checked {
            self.code.list.push(Instruction::AuditMask(row));
        }
    }

    fn run(&mut self, index: usize, at: u32) {
        let ty = self.op(at).ty();
        match self.op(at).clone() {
            Op::Weight(partition, i) => {
                let row = self.partition(partition.0)[i];
                self.values.insert(at, Location::Scalar(row));
            }
            Op::Mix { a, b, t } => self.mix(index, at, a.0, b.0, t.0),
            Op::Blend { colors, weights } => {
                let rows = self.partition(weights.0);
                if self.is_unaudited(weights.0) {
                    self.code.list.push(Instruction::AuditPartition(rows.clone()));
                }
                let colors = colors.iter().map(|color| self.color(color.0)).collect();
                self.code.list.push(Instruction::Blend { colors, weights: rows });
                self.after_color(index, at);
            }
            op => {
                let instruction = self.scalar_instruction(&op);
                self.code.list.push(instruction);
                match self.code.list.last() {
                    Some(Instruction::Partition { to, .. } | Instruction::Normalize { to, .. }) => {
                        let rows = to.iter().map(|&row| Row::Own(row)).collect();
                        self.values.insert(at, Location::Partition(rows));
                    }
                    Some(
                        Instruction::Clamp { to, .. }
                        | Instruction::Smooth { to, .. }
                        | Instruction::Power { to, .. }
                        | Instruction::Step { to, .. }
                        | Instruction::Complement { to, .. }
                        | Instruction::Product { to, .. },
                    ) => {
                        let row = Row::Own(*to);
                        self.values.insert(at, Location::Scalar(row));
                    }
                    _ => unreachable!("colors have been dealt with"),
                }
            }
        }
        if ty != Type::Color {
            for root in self.roots_of.remove(&at).unwrap_or_default() {
                self.out_rows(root, at);
            }
        }
    }

    fn scalar_instruction(&mut self, op: &Op) -> Instruction {
        match op {
            Op::Clamp { x, min, max } => {
                let x = self.scalar(x.0);
                Instruction::Clamp { x, min: *min, max: *max, to: self.allocate() }
            }
            Op::Smooth(t) => Instruction::Smooth { t: self.scalar(t.0), to: self.allocate() },
            Op::Power { t, p } => Instruction::Power { t: self.scalar(t.0), p: *p, to: self.allocate() },
            Op::Step { x, threshold } => {
                Instruction::Step { x: self.scalar(x.0), threshold: *threshold, to: self.allocate() }
            }
            Op::Complement(t) => Instruction::Complement { t: self.scalar(t.0), to: self.allocate() },
            Op::Product(t, u) => {
                let (t, u) = (self.scalar(t.0), self.scalar(u.0));
                Instruction::Product { t, u, to: self.allocate() }
            }
            Op::Partition(weights) => {
                let weights = self.scalars(weights);
                let to = weights.iter().map(|_| self.allocate()).collect();
                Instruction::Partition { weights, to }
            }
            Op::Normalize { values, floor } => {
                let values = self.scalars(values);
                let to = (0..=values.len()).map(|_| self.allocate()).collect();
                Instruction::Normalize { values, floor: *floor, to }
            }
            _ => unreachable!("colors, constants and planes are no scalar work"),
        }
    }

    fn mix(&mut self, index: usize, at: u32, a: u32, b: u32, t: u32) {
        self.audit_mask(t);
        let (a, b) = (self.color(a), self.color(b));
        let t = self.scalar(t);
        let gated = self.gates.last().is_some_and(|(mix, _)| *mix == at);
        let own_root = self.roots_of.get(&at).filter(|roots| roots.len() == 1).map(|roots| roots[0]);
        let fused = self.input.fuse && !gated && self.order.uses[at as usize] == 0;
        let instruction = match (a, b) {
            (ColorOperand::Pair { from, to, by }, ColorOperand::Pair { from: from_2, to: to_2, by: by_2 })
                if by == by_2 && self.input.fuse =>
            {
                Instruction::Patch { corners: [from, to, from_2, to_2], x: by, y: t }
            }
            _ => Instruction::Mix { a, b, t, out: own_root.filter(|_| fused) },
        };
        let is_out = matches!(instruction, Instruction::Mix { out: Some(_), .. });
        self.code.list.push(instruction);
        if gated && let Some((_, gate)) = self.gates.pop() {
            self.audited.pop();
            let end = self.code.list.len();
            if let Instruction::Gate { skip, .. } = &mut self.code.list[gate] {
                *skip = end - gate - 1;
            }
        }
        if is_out {
            self.roots_of.remove(&at);
            self.accumulated = None;
        } else {
            self.after_color(index, at);
        }
    }

    /// Handles a color that was just left in the accumulator: writes it if it is a root, and saves it unless its only
    /// reader is the next color.
    fn after_color(&mut self, index: usize, at: u32) {
        for root in self.roots_of.remove(&at).unwrap_or_default() {
            self.code.list.push(Instruction::OutColor(root));
        }
        self.accumulated = None;
        if self.order.uses[at as usize] == 0 {
            return;
        }
        if self.input.fuse && self.order.uses[at as usize] == 1 && self.is_next_mixed(index, at) {
            self.accumulated = Some(at);
            return;
        }
        let to = [0; 3].map(|_| self.allocate());
        self.values.insert(at, Location::Color(ColorOperand::Rows(to.map(Row::Own))));
        self.code.list.push(Instruction::Keep(to));
    }

    /// Returns whether the next color to be made is a mix of this one.
    fn is_next_mixed(&self, index: usize, at: u32) -> bool {
        for step in &self.steps[index + 1..] {
            let Step::Run(next) = *step else { return false };
            match self.op(next) {
                Op::Mix { a, b, .. } => return a.0 == at || b.0 == at,
                op if op.ty() == Type::Color => return false,
                _ => {}
            }
        }
        false
    }

    /// Writes roots that no instruction computes: constants, planes, and values that were already computed.
    fn finish_roots(&mut self) {
        let mut open: Vec<(u32, u32)> =
            self.roots_of.drain().flat_map(|(at, roots)| roots.into_iter().map(move |root| (root, at))).collect();
        open.sort_unstable();
        for (root, at) in open {
            if self.op(at).ty() == Type::Color {
                let source = self.color(at);
                self.code.list.extend([Instruction::Load(source), Instruction::OutColor(root)]);
            } else {
                self.out_rows(root, at);
            }
        }
    }

    fn out_rows(&mut self, root: u32, at: u32) {
        let rows = match self.values.get(&at) {
            Some(Location::Partition(rows)) => rows.clone(),
            _ => vec![self.scalar(at)],
        };
        self.code.list.push(Instruction::OutRows { root, rows });
    }
}
