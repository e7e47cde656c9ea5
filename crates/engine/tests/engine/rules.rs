//! Tests the rules of every operation against what the operation computes.

use proptest::prelude::*;
use std::collections::HashMap;
use trochoid_engine::inside::{BOUNDS, interval, trace};
use trochoid_engine::{Inspection, Instructions, Interval};
use trochoid_graph::{Bound, Color, NodeId, Op, Partition, Program, Scalar, Slot, Type, Variance};
use trochoid_kernel::{Options, Origin, Plane, compile};

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
    let fields = Partition(push(Op::Normalize { values: vec![x, y], floor: v[3].abs().max(1e-30) }));
    for way in 0..3 {
        push(Op::Weight(fields, way));
    }
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

fn inspect(program: &Program, inputs: &[f64]) -> Inspection {
    Inspection::new(program, &|slot| inputs[slot.node.0 + slot.channel])
}

/// Runs a program at one sample with bounds, and returns the values and bounds of every operation but partitions.
fn traced(program: &Program, inputs: &[f32], bounds: &[Bound], instructions: Instructions) -> Traced {
    let options = Options {
        hoist: false,
        fuse: false,
        everything: true,
        instructions,
        audits: true,
        native: false,
        variance: &|_| Variance::Pixel,
        rule: &|_| None,
    };
    let last = program.ops().len() as u32 - 1;
    let mut compiled = compile(program, &[last], &options);
    let is_row = |position: &u32| !matches!(program.ops()[*position as usize].0.ty(), Type::Partition(_));
    let roots: Vec<u32> = (0..=last).filter(is_row).collect();
    compiled.origin = Origin { program: program.clone(), roots: roots.clone() };
    // Values, then bounds, as plans that certify have them.
    let at = |slot: &Slot| slot.node.0 + slot.channel;
    let mut samples: Vec<[f32; 1]> = compiled.planes.iter().map(|slot| [inputs[at(slot)]]).collect();
    samples.extend(compiled.planes.iter().map(|slot| [bounds[at(slot)].encode()]));
    compiled.planes.extend_from_within(..);
    let planes: Vec<Plane<'_>> = samples.iter().map(|samples| Plane { samples, start: 0, stride: 1 }).collect();
    let mut rows = Traced::new();
    trace(&compiled, &planes, &mut |root, channel, _, row| {
        let rows = rows.entry(roots[root]).or_insert_with(|| [Vec::new(), Vec::new()]);
        rows[usize::from(channel >= BOUNDS)].push(row[0]);
    });
    rows
}

/// Values and encoded bounds by position.
type Traced = HashMap<u32, [Vec<f32>; 2]>;

/// Values of fields, masks and colors that are difficult for arithmetic.
fn hostile() -> impl Strategy<Value = f32> {
    prop_oneof![
        0.0f32..1.5,
        -3.0f32..3.0,
        prop::sample::select(vec![
            0.0,
            1e-45,
            -1e-40,
            f32::MIN_POSITIVE,
            1.0,
            0.5,
            65504.0,
            -65504.0,
            1e30,
            f32::MAX,
            f32::INFINITY,
            f32::NEG_INFINITY,
        ]),
    ]
}

proptest! {
    #[test]
    fn errors_stay_within_their_bound(
        v in prop::collection::vec(-2.0f32..2.0, 4),
        scale in prop::sample::select(vec![1.0f32, 1.0, 65504.0, 1e30, 1e-41]),
        inputs in prop::collection::vec(hostile(), 5),
        errors in prop::collection::vec(prop_oneof![Just(0.0), 0.0f64..1e-6, 0.0f64..0.2], 5),
        signs in prop::collection::vec(prop_oneof![-1.0f64..1.0, Just(1.0), Just(-1.0)], 5),
    ) {
        let v: Vec<f32> = v.iter().enumerate().map(|(i, v)| if i == 2 { *v } else { v * scale }).collect();
        let program = program(&v);
        // Colors are finite and ≥ 0, and only a finite number can be off.
        let inputs: Vec<f32> =
            inputs.iter().enumerate().map(|(i, x)| if i < 2 { *x } else { x.abs().min(f32::MAX) }).collect();
        let errors: Vec<f64> = errors
            .iter()
            .zip(&inputs)
            .map(|(e, x)| if x.is_finite() { e * f64::from(x.abs()).max(1e-3) } else { 0.0 })
            .collect();
        let moved: Vec<f64> = (0..5)
            .map(|i| f64::from(inputs[i]) + errors[i] * signs[i])
            .enumerate()
            .map(|(i, x)| if i < 2 { x } else { x.max(0.0) })
            .collect();
        // Rounding the sum may move an input farther than by its error.
        let bound = |i: usize| errors[i].max((moved[i] - f64::from(inputs[i])).abs());
        let bounds: Vec<Bound> = (0..5).map(|i| Bound::of(if inputs[i].is_finite() { bound(i) } else { 0.0 })).collect();
        let truth = inspect(&program, &moved);
        let found = traced(&program, &inputs, &bounds, Instructions::Best);
        prop_assert_eq!(&found, &traced(&program, &inputs, &bounds, Instructions::Baseline));
        for (position, [values, bounds]) in &found {
            for ((computed, truth), bound) in values.iter().zip(truth.value(*position)).zip(bounds) {
                let (computed, bound) = (f64::from(*computed), Bound::decode(*bound));
                let error = if computed == *truth { 0.0 } else { (computed - truth).abs() };
                prop_assert!(error <= bound.size, "{:?}: {computed} and {truth}", program.ops()[*position as usize].0);
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
        let values = inspect(&program, &inputs);
        let mut bounds: Vec<Vec<Interval>> = Vec::new();
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
        let inspection = inspect(&program, &inputs);
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
