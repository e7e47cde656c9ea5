//! Tests the rules of every operation against what the operation computes.

use crate::rules::interval::{Bounds, Interval, interval};
use crate::running::inspect::Inspection;
use proptest::prelude::*;
use trochoid_graph::{Bound, Color, NodeId, Op, Partition, Program, Scalar, Slot};

const NODE: NodeId = NodeId(0);

/// Makes a program of every operation on two fields and constants; `v` holds thresholds and the like.
fn program(v: &[f32]) -> Program {
    let mut program = Program::default();
    let mut push = |op: Op| program.push(op, NODE);
    let x = Scalar(push(Op::Load(slot(0))));
    let y = Scalar(push(Op::Load(slot(1))));
    let (low, high) = (v[0].min(v[1]), v[0].max(v[1]) + 0.1);
    let t = Scalar(push(Op::Clamp { x, min: low, max: high }));
    let u = Scalar(push(Op::Clamp { x: y, min: 0.0, max: 1.0 }));
    let smooth = Scalar(push(Op::Smooth(t)));
    let power = Scalar(push(Op::Power { t: smooth, p: 1.0 + v[2].abs() }));
    let open = Scalar(push(Op::Complement(u)));
    let both = Scalar(push(Op::Product(power, open)));
    let step = Scalar(push(Op::Step { x, threshold: v[3] }));
    let rest = Scalar(push(Op::Complement(both)));
    let pair = Partition(push(Op::Partition(vec![both, rest])));
    let norm = Partition(push(Op::Normalize { values: vec![t, u, step], floor: 0.3 }));
    let weight = Scalar(push(Op::Weight(norm, 1)));
    let a = Color(push(Op::ConstantColor([0.1, 0.5, 0.9])));
    let b = Color(push(Op::ConstantColor([1.0, 0.0, 0.3])));
    let c = Color(push(Op::LoadColor(slot(2))));
    let mixed = Color(push(Op::Mix { a, b, t: weight }));
    let blended = Color(push(Op::Blend { colors: vec![mixed, c], weights: pair }));
    let four = Color(push(Op::Blend { colors: vec![a, blended, c, mixed], weights: norm }));
    push(Op::Mix { a: four, b: blended, t: power });
    program
}

fn slot(node: usize) -> Slot {
    Slot { node: NodeId(node), output: 0, channel: 0 }
}

fn inspect(program: &Program, inputs: &[f64], errors: &[f64]) -> Inspection {
    Inspection::new(program, &|slot| {
        (inputs[slot.node.0 + slot.channel], Bound::of(errors[slot.node.0 + slot.channel]))
    })
}

proptest! {
    #[test]
    fn errors_stay_within_their_bound(
        v in prop::collection::vec(-2.0f32..2.0, 4),
        inputs in prop::collection::vec(0.0f64..1.5, 5),
        errors in prop::collection::vec(0.0f64..0.2, 5),
        signs in prop::collection::vec(-1.0f64..1.0, 5),
    ) {
        let program = program(&v);
        let stated = inspect(&program, &inputs, &errors);
        let moved: Vec<f64> = inputs.iter().zip(&errors).zip(&signs).map(|((x, e), s)| x + e * s).collect();
        let truth = inspect(&program, &moved, &errors);
        for position in 0..program.ops().len() as u32 {
            let values = stated.value(position).iter().zip(truth.value(position)).zip(stated.bound(position));
            for ((computed, truth), bound) in values {
                prop_assert!((computed - truth).abs() <= bound.size, "{:?}", program.ops()[position as usize].0);
            }
        }
    }

    #[test]
    fn values_stay_within_their_interval(
        v in prop::collection::vec(-2.0f32..2.0, 4),
        low in prop::collection::vec(0.0f64..0.7, 5),
        width in prop::collection::vec(0.0f64..0.7, 5),
        at in prop::collection::vec(0.0f64..1.0, 5),
    ) {
        let program = program(&v);
        let inputs: Vec<f64> = (0..5).map(|i| low[i] + width[i] * at[i]).collect();
        let values = inspect(&program, &inputs, &[0.0; 5]);
        let mut bounds: Vec<Bounds> = Vec::new();
        for (op, _) in program.ops() {
            let of = |position: u32| bounds[position as usize].clone();
            let slot = |slot: &Slot, channel: usize| {
                let i = slot.node.0 + channel;
                Interval { low: low[i], high: low[i] + width[i] }
            };
            let found = interval(op, &of, &slot);
            bounds.push(found);
        }
        for (position, bounds) in bounds.iter().enumerate() {
            for (value, bound) in values.value(position as u32).iter().zip(bounds) {
                // Values are f64, bounds those of f32 kernels.
                let slack = 1e-6;
                prop_assert!(
                    *value >= bound.low - slack && *value <= bound.high + slack,
                    "{:?}: {value} outside {bound:?}",
                    program.ops()[position].0
                );
            }
        }
    }

    #[test]
    fn blame_sums_to_one_and_makes_the_pixel(
        v in prop::collection::vec(-2.0f32..2.0, 4),
        inputs in prop::collection::vec(0.0f64..1.5, 5),
    ) {
        let program = program(&v);
        let inspection = inspect(&program, &inputs, &[0.0; 5]);
        let last = program.ops().len() as u32 - 1;
        let blame = inspection.blame(last);
        let total: f64 = blame.iter().map(|share| share.weight).sum();
        prop_assert!((total - 1.0).abs() < 1e-12);
        for c in 0..3 {
            let made: f64 = blame.iter().map(|share| share.weight * share.color[c]).sum();
            prop_assert!((made - inspection.value(last)[c]).abs() < 1e-12);
        }
    }
}
