//! From a program to instructions with assigned rows.

use crate::rules::variance::variance;
use trochoid_graph::{NodeId, Op, Program, Slot, Type, Variance};

/// Where a row comes from.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Row {
    /// A row of the machine.
    Own(u32),
    /// A row of a plane from outside.
    Plane(u32),
}

/// One operation with rows assigned.
#[derive(Clone, Debug)]
pub(crate) enum Work {
    Constant(f32),
    Clamp {
        x: Row,
        min: f32,
        max: f32,
    },
    Smooth(Row),
    Power {
        t: Row,
        p: f32,
    },
    Step {
        x: Row,
        threshold: f32,
    },
    Complement(Row),
    Product(Row, Row),
    /// Inputs, rounded to sum to exactly 1 into the outputs.
    Partition(Vec<Row>),
    Normalize {
        values: Vec<Row>,
        floor: f32,
    },
    ConstantColor([f32; 3]),
    Mix {
        a: [Row; 3],
        b: [Row; 3],
        t: Row,
    },
    Blend {
        colors: Vec<[Row; 3]>,
        weights: Vec<Row>,
    },
}

/// An instruction: work, the rows that it writes, and how far they vary.
#[derive(Clone, Debug)]
pub(crate) struct Instruction {
    pub(crate) work: Work,
    pub(crate) to: Vec<u32>,
    pub(crate) variance: Variance,
    /// The node that it came from, and its relative cost, for reports.
    pub(crate) origin: NodeId,
    pub(crate) cost: f64,
}

/// A compiled program.
#[derive(Clone, Debug, Default)]
pub(crate) struct Compiled {
    /// Run once a tile.
    pub(crate) once: Vec<Instruction>,
    /// Run for every row.
    pub(crate) each: Vec<Instruction>,
    /// Number of rows of the machine.
    pub(crate) rows: usize,
    /// Planes read, in the order in which the machine expects them.
    pub(crate) planes: Vec<Slot>,
    /// The rows of every root.
    pub(crate) roots: Vec<Vec<Row>>,
    /// What the kernels do wrong, so that tests see whether anybody notices.
    #[cfg(test)]
    pub(crate) fault: Fault,
}

/// A deliberately broken kernel.
#[cfg(test)]
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub(crate) enum Fault {
    #[default]
    None,
    /// Mix goes beyond its second color.
    MixOvershoots,
    /// Partitions sum to a little less than 1.
    PartitionLeaks,
    /// Clamp lets a mask reach beyond 1.
    ClampLeaks,
    /// Mix gives NaN at one pixel of a row.
    MixLosesOne,
}

/// Compiles what `roots` need. With `hoist`, values that do not vary along the column run once a tile, and
/// values that do not vary along the row are computed for one pixel; with `reuse`, rows are reused.
pub(crate) fn compile(
    program: &Program,
    roots: &[u32],
    hoist: bool,
    reuse: bool,
    slot_variance: &dyn Fn(&Slot) -> Variance,
) -> Compiled {
    let ops = program.ops();
    let mut out = Compiled::default();
    let mut variances = Vec::with_capacity(ops.len());
    for (op, _) in ops {
        let v = variance(op, &|operand| variances[operand as usize], slot_variance);
        variances.push(v);
    }
    let is_once = |position: usize| hoist && variances[position] <= Variance::Column;
    // The last instruction that reads each operation's rows, aliases (Weight, loads) included.
    let mut last = vec![0usize; ops.len()];
    for (position, (op, _)) in ops.iter().enumerate() {
        op.operands(|operand| last[operand as usize] = position);
    }
    for position in (0..ops.len()).rev() {
        if let Op::Weight(partition, _) = &ops[position].0 {
            let reader = last[position];
            let own = &mut last[partition.0 as usize];
            *own = (*own).max(reader);
        }
    }
    for &root in roots {
        last[root as usize] = usize::MAX;
        if let Op::Weight(partition, _) = &ops[root as usize].0 {
            last[partition.0 as usize] = usize::MAX;
        }
    }

    let mut rows: Vec<Vec<Row>> = Vec::with_capacity(ops.len());
    let mut free: Vec<u32> = Vec::new();
    // Rows to give back once an instruction has run: by the position of their last reader.
    let mut expiring: Vec<Vec<u32>> = vec![Vec::new(); ops.len()];
    for (position, (op, origin)) in ops.iter().enumerate() {
        let one = |operand: u32| rows[operand as usize][0];
        let three = |operand: u32| [0, 1, 2].map(|c| rows[operand as usize][c]);
        let work = match op {
            Op::Load(slot) => {
                rows.push(vec![Row::Plane(plane(&mut out.planes, *slot))]);
                continue;
            }
            Op::LoadColor(slot) => {
                let planes = (0..3).map(|channel| Row::Plane(plane(&mut out.planes, Slot { channel, ..*slot })));
                rows.push(planes.collect());
                continue;
            }
            Op::Weight(partition, i) => {
                rows.push(vec![rows[partition.0 as usize][*i]]);
                continue;
            }
            Op::Constant(value) => Work::Constant(*value),
            Op::Clamp { x, min, max } => Work::Clamp { x: one(x.0), min: *min, max: *max },
            Op::Smooth(t) => Work::Smooth(one(t.0)),
            Op::Power { t, p } => Work::Power { t: one(t.0), p: *p },
            Op::Step { x, threshold } => Work::Step { x: one(x.0), threshold: *threshold },
            Op::Complement(t) => Work::Complement(one(t.0)),
            Op::Product(t, u) => Work::Product(one(t.0), one(u.0)),
            Op::Partition(weights) => Work::Partition(weights.iter().map(|w| one(w.0)).collect()),
            Op::Normalize { values, floor } => {
                Work::Normalize { values: values.iter().map(|v| one(v.0)).collect(), floor: *floor }
            }
            Op::ConstantColor(color) => Work::ConstantColor(*color),
            Op::Mix { a, b, t } => Work::Mix { a: three(a.0), b: three(b.0), t: one(t.0) },
            Op::Blend { colors, weights } => Work::Blend {
                colors: colors.iter().map(|color| three(color.0)).collect(),
                weights: rows[weights.0 as usize].clone(),
            },
        };
        let count = match op.ty() {
            Type::Scalar => 1,
            Type::Color => 3,
            Type::Partition(n) => n,
        };
        let to: Vec<u32> = (0..count)
            .map(|_| {
                // What runs once runs before everything else, so its rows must not have been anyone's before.
                let reused = if is_once(position) { None } else { free.pop() };
                reused.unwrap_or_else(|| {
                    out.rows += 1;
                    (out.rows - 1) as u32
                })
            })
            .collect();
        rows.push(to.iter().map(|&row| Row::Own(row)).collect());
        // Values of once must survive all rows of the tile.
        if reuse && !is_once(position) && last[position] < ops.len() {
            expiring[last[position].max(position)].extend(&to);
        }
        let hoisted = match variances[position] {
            // Unfused, a whole tile runs as one row: along that row also what varies from row to row does.
            Variance::Row if !reuse => Variance::Pixel,
            variance if hoist => variance,
            _ => Variance::Pixel,
        };
        let instruction = Instruction { work, to, variance: hoisted, origin: *origin, cost: cost(op) };
        if is_once(position) {
            out.once.push(instruction);
        } else {
            out.each.push(instruction);
        }
        // Freed only now, so that no instruction writes a row that it reads.
        free.append(&mut expiring[position]);
    }
    out.roots = roots.iter().map(|&root| rows[root as usize].clone()).collect();
    out
}

/// The index of a plane in the list of planes read.
fn plane(planes: &mut Vec<Slot>, slot: Slot) -> u32 {
    let index = planes.iter().position(|known| *known == slot).unwrap_or_else(|| {
        planes.push(slot);
        planes.len() - 1
    });
    index as u32
}

/// Relative cost of an operation a pixel, to share a program's time among its nodes; measured, rounded.
fn cost(op: &Op) -> f64 {
    match op {
        Op::Power { .. } => 20.0,
        Op::Clamp { .. } => 4.0,
        Op::Mix { .. } => 3.0,
        Op::Partition(weights) => 3.0 * weights.len() as f64,
        Op::Normalize { values, .. } => 4.0 * values.len() as f64,
        Op::Blend { colors, .. } => 3.0 * colors.len() as f64,
        _ => 1.0,
    }
}
