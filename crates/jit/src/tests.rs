//! Tests that compare compiled programs with the definitions, sample by sample and bit by bit.

use crate::program::Item;
use crate::{Code, Lanes, Op, Program, Run, STEP, Scratch, Set, Stores, Value};
use trochoid_memory::{Buffer, Target, write_around};
use trochoid_weights::arithmetic as a;

/// A small random number generator.
struct Draw(u64);

impl Draw {
    fn next(&mut self) -> u64 {
        // Knuth's MMIX generator, of which only the upper bits are random enough.
        self.0 = self.0.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1_442_695_040_888_963_407);
        self.0 >> 33
    }

    fn below(&mut self, bound: usize) -> usize {
        self.next() as usize % bound
    }

    fn mask(&mut self) -> f32 {
        match self.below(8) {
            0 => 0.0,
            1 => 1.0,
            2 => 0.5,
            3 => 0.5f32.next_down(),
            4 => f32::from_bits(self.below(1 << 20) as u32),
            _ => (self.next() >> 7) as f32 / 16_777_215.0,
        }
    }

    fn field(&mut self) -> f32 {
        match self.below(8) {
            0 => f32::NAN,
            1 => f32::INFINITY,
            2 => f32::NEG_INFINITY,
            3 => -0.0,
            _ => (self.mask() - 0.3) * 40.0,
        }
    }

    fn pick<T: Copy>(&mut self, from: &[T]) -> T {
        from[self.below(from.len())]
    }
}

const MASKS: usize = 6;
const FIELDS: usize = 4;
const LINES: usize = 2;
const OUTPUTS: usize = 12;
/// Number of vectors of state: two for masks, one for fields (shifted), and two for sums.
const STATE: usize = 5;

/// Values that a random program can use.
#[derive(Clone)]
struct Pool {
    masks: Vec<Value>,
    fields: Vec<Value>,
    colors: Vec<[Value; 3]>,
    partitions: Vec<Vec<Value>>,
}

fn step(draw: &mut Draw, program: &mut Program, pool: &mut Pool, depth: usize) {
    let (t, u, x) = (draw.pick(&pool.masks), draw.pick(&pool.masks), draw.pick(&pool.fields));
    let n = 1 + draw.below(16) as u32;
    match draw.below(14) {
        0 => pool.masks.push(program.compute(Op::Clamp { x, min: -2.5, width: 0.25 + draw.below(9) as f32 })),
        1 => pool.masks.push(program.compute(Op::Step { x, threshold: draw.below(5) as f32 - 1.0 })),
        2 => pool.masks.push(program.compute(Op::Smooth(t))),
        3 => pool.masks.push(program.compute(Op::Power { t, n })),
        4 => pool.masks.push(program.compute(Op::Complement(t))),
        5 => pool.masks.push(program.compute(Op::Product(t, u))),
        6 => {
            program.see(t, Some(0), 1, false);
            program.see(x, None, 2, true);
        }
        7 => {
            // Weights that sum to 1 up to rounding.
            let mut rest = program.compute(Op::Constant(1.0));
            let mut weights = Vec::new();
            for _ in 0..1 + draw.below(5) {
                let t = draw.pick(&pool.masks);
                weights.push(program.compute(Op::Product(rest, t)));
                let left = program.compute(Op::Complement(t));
                rest = program.compute(Op::Product(rest, left));
            }
            weights.push(rest);
            let weights = program.partition(weights);
            program.see_sum(weights.clone(), 3);
            pool.partitions.push(weights);
        }
        8 if !pool.partitions.is_empty() => {
            let weights = pool.partitions[draw.below(pool.partitions.len())].clone();
            let colors = weights.iter().map(|_| draw.pick(&pool.colors)).collect();
            let color = program.blend(colors, weights);
            pool.colors.push(color);
        }
        9 if depth < 3 => {
            let closed = draw.below(2) as f32;
            let outside = pool.clone();
            program.gate(t, closed);
            for _ in 0..draw.below(20) {
                step(draw, program, pool, depth + 1);
            }
            let (a, b) = (draw.pick(&outside.colors), draw.pick(&pool.colors));
            let (a, b, otherwise) = if closed == 0.0 { (a, b, a) } else { (b, a, a) };
            let inside = [0, 1, 2].map(|c| program.compute(Op::Mix { a: a[c], b: b[c], t }));
            let color = program.join(inside, otherwise);
            *pool = outside;
            pool.colors.push(color);
        }
        _ => {
            let (a, b) = (draw.pick(&pool.colors), draw.pick(&pool.colors));
            pool.colors.push([0, 1, 2].map(|c| program.compute(Op::Mix { a: a[c], b: b[c], t })));
        }
    }
}

fn random(draw: &mut Draw) -> Program {
    let mut program = Program::new(MASKS + FIELDS, LINES, OUTPUTS, STATE);
    let input = |program: &mut Program, index: usize| program.compute(Op::Input(index as u32));
    let mut masks: Vec<Value> = (0..MASKS).map(|index| input(&mut program, index)).collect();
    masks.extend((0..LINES).map(|line| program.compute(Op::Line(line as u32))));
    masks.push(program.compute(Op::Constant(0.25)));
    let fields = (MASKS..MASKS + FIELDS).map(|index| input(&mut program, index)).collect();
    let constant = |program: &mut Program, value: f32| program.compute(Op::Constant(value));
    let mut colors: Vec<[Value; 3]> =
        (0..4).map(|i| [0, 1, 2].map(|c| constant(&mut program, 0.1 + 0.3 * i as f32 + 0.05 * c as f32))).collect();
    // A gate would not reproduce the −0 of a mix, so programs have either zeros of both signs or gates.
    let depth = 3 * draw.below(2);
    if depth > 0 {
        colors
            .extend([[0.0, -0.0, 1.0], [-0.0, 0.0, 0.5]].map(|color| color.map(|value| constant(&mut program, value))));
    }
    colors.push([masks[0], masks[1], masks[2]]);
    program.fetch(0);
    let mut pool = Pool { masks, fields, colors, partitions: Vec::new() };
    for _ in 0..5 + draw.below(120) {
        step(draw, &mut program, &mut pool, depth);
    }
    for to in 0..OUTPUTS / 3 {
        let color = draw.pick(&pool.colors);
        (0..3).for_each(|c| program.output(color[c], (3 * to + c) as u32));
    }
    program
}

/// Evaluates a program at one sample: returns the outputs, and the state that does not depend on the order of samples.
fn reference(program: &Program, inputs: &[f32], lines: &[f32]) -> (Vec<f32>, [u32; 3], f64) {
    let mut values = vec![0.0f32; program.values as usize];
    let mut out = vec![0.0; program.outputs];
    let (mut seen, mut deviation) = ([u32::MAX, 0, 0], 0.0f64);
    let mut at = 0;
    while at < program.items.len() {
        let get = |value: &Value| values[value.0 as usize];
        match &program.items[at] {
            Item::Over { .. } | Item::Within { .. } | Item::Ready(_) => unreachable!("made by the schedule"),
            Item::Compute { op, to } => {
                let v = match op {
                    Op::Input(index) => inputs[*index as usize],
                    Op::Line(index) => lines[*index as usize],
                    Op::Constant(value) => *value,
                    Op::Clamp { x, min, width } => a::clamp(get(x), *min, *min + *width),
                    Op::Step { x, threshold } => a::step(get(x), *threshold),
                    Op::Smooth(t) => a::smooth(get(t)),
                    Op::Power { t, n } => a::power(get(t), *n as f32),
                    Op::Complement(t) => a::complement(get(t)),
                    Op::Product(t, u) => a::product(get(t), get(u)),
                    Op::Mix { a, b, t } => a::mix(get(a), get(b), get(t)),
                };
                values[to.0 as usize] = v;
            }
            Item::Blend { colors, weights, to } => {
                let weights: Vec<f32> = weights.iter().map(get).collect();
                let channels = [0, 1, 2].map(|c| {
                    let colors: Vec<f32> = colors.iter().map(|color| get(&color[c])).collect();
                    a::blend(&colors, &weights)
                });
                for (to, v) in to.iter().zip(channels) {
                    values[to.0 as usize] = v;
                }
            }
            Item::Partition { weights, to } => {
                let mut weights: Vec<f32> = weights.iter().map(get).collect();
                a::round_partition(&mut weights);
                for (to, v) in to.iter().zip(weights) {
                    values[to.0 as usize] = v;
                }
            }
            Item::Fetch(_) => {}
            Item::See { value, least, shifted, .. } => {
                let bits = get(value).to_bits();
                if *shifted {
                    seen[2] = seen[2].max(bits << 1);
                } else {
                    assert!(least.is_some());
                    seen = [seen[0].min(bits), seen[1].max(bits), seen[2]];
                }
            }
            Item::SeeSum { weights, .. } => {
                let sum: f64 = weights.iter().map(|weight| f64::from(get(weight))).sum();
                deviation = deviation.max((sum - 1.0).abs());
            }
            Item::Output { value, to } => out[*to as usize] = get(value),
            Item::Gate { t, closed, join } => {
                if get(t).to_bits() == closed.to_bits() {
                    let Item::Join { otherwise, to, .. } = &program.items[*join] else { unreachable!() };
                    let taken = otherwise.map(|value| get(&value));
                    for (to, v) in to.iter().zip(taken) {
                        values[to.0 as usize] = v;
                    }
                    at = *join;
                }
            }
            Item::Join { inside, to, .. } => {
                let taken = inside.map(|value| get(&value));
                for (to, v) in to.iter().zip(taken) {
                    values[to.0 as usize] = v;
                }
            }
        }
        at += 1;
    }
    (out, seen, deviation)
}

fn sets() -> Vec<Set> {
    let mut sets = Vec::new();
    if is_x86_feature_detected!("avx512f") {
        sets.push(Set::Avx512);
    }
    if is_x86_feature_detected!("avx2") && is_x86_feature_detected!("fma") {
        sets.push(Set::Avx2);
    }
    sets
}

fn rows(draw: &mut Draw, count: usize) -> Vec<Vec<f32>> {
    let masks = (0..MASKS).map(|index| {
        // Two inputs have runs of 0 or 1, so that gates close.
        let mut run = 0.0;
        (0..count)
            .map(|at| {
                if at % (2 * STEP) == 0 {
                    run = draw.below(2) as f32;
                }
                if index < 2 { run } else { draw.mask() }
            })
            .collect()
    });
    let masks: Vec<Vec<f32>> = masks.collect();
    let fields = (0..FIELDS).map(|_| (0..count).map(|_| draw.field()).collect());
    masks.into_iter().chain(fields.collect::<Vec<_>>()).collect()
}

#[test]
fn compiled_programs_have_the_bits_of_the_definitions() {
    let mut draw = Draw(7);
    let (mut gated, mut spilled) = (0, 0);
    for round in 0..300 {
        let program = random(&mut draw);
        gated += usize::from(program.items.iter().any(|item| matches!(item, Item::Gate { .. })));
        let count = STEP * (1 + draw.below(6));
        let rows = rows(&mut draw, count);
        let inputs: Vec<&[f32]> = rows.iter().map(|row| &row[..]).collect();
        let lines = [[draw.mask()], [1.0]];
        let lines: Vec<&[f32]> = lines.iter().map(|line| &line[..]).collect();
        let line_values: Vec<f32> = lines.iter().map(|line| line[0]).collect();
        let expected: Vec<_> = (0..count)
            .map(|at| {
                let sample: Vec<f32> = rows.iter().map(|row| row[at]).collect();
                reference(&program, &sample, &line_values)
            })
            .collect();
        for set in sets() {
            let code = Code::compile(&program, set, Stores::Cached).unwrap();
            // Steps of the code may be shorter than the longest.
            assert!(STEP.is_multiple_of(code.step()), "{}", code.step());
            let count = count - (STEP - code.step());
            let (start, beyond) = (3, 5);
            let mut out = vec![vec![-7.0f32; start + count + beyond]; OUTPUTS];
            let mut state = [Lanes([0; 16]); STATE];
            state[0] = Lanes([u32::MAX; 16]);
            let mut scratch = Scratch::default();
            let mut targets: Vec<Target<'_>> = out.iter_mut().map(|row| Target::new(row)).collect();
            code.run(&Run { inputs: &inputs, lines: &lines, start, count }, &mut targets, &mut state, &mut scratch);
            spilled += usize::from(!scratch.slots.is_empty());
            for (at, (expected, ..)) in expected.iter().take(count).enumerate() {
                for (channel, expected) in expected.iter().enumerate() {
                    let found = out[channel][start + at];
                    assert_eq!(
                        found.to_bits(),
                        expected.to_bits(),
                        "{round} {set:?} {channel} {at}: {found} {expected}"
                    );
                }
            }
            let untouched = out.iter().flat_map(|row| row[..start].iter().chain(&row[start + count..]));
            assert!(untouched.into_iter().all(|v| *v == -7.0), "{round} {set:?} wrote beyond its targets");
            let fold = |index: usize, f: fn(u32, u32) -> u32| state[index].0.into_iter().reduce(f).unwrap();
            let seen = [fold(0, u32::min), fold(1, u32::max), fold(2, u32::max)];
            // A gate closes only for a whole vector, so state behind one may include more values than each sample
            // needs.
            if !program.items.iter().any(|item| matches!(item, Item::Gate { .. })) {
                let all = expected.iter().take(count).fold([u32::MAX, 0, 0], |all, (_, seen, _)| {
                    [all[0].min(seen[0]), all[1].max(seen[1]), all[2].max(seen[2])]
                });
                assert_eq!(seen, all, "{round} {set:?}");
            }
            let sums = state[3].0.into_iter().chain(state[4].0);
            let sums: Vec<u32> = sums.collect();
            let most = sums.chunks(2).map(|pair| f64::from_bits(u64::from(pair[0]) | u64::from(pair[1]) << 32));
            assert!(most.fold(0.0, f64::max) == 0.0, "partitions sum to 1");
            assert!(expected.iter().all(|(.., deviation)| *deviation == 0.0));
        }
    }
    assert!(gated > 50 && spilled > 50, "{gated} with gates, {spilled} with values out of registers");
}

#[test]
fn results_go_around_the_cache_into_whole_lines_only() {
    let mut program = Program::new(1, 0, 1, 0);
    let input = program.compute(Op::Input(0));
    let half = program.compute(Op::Constant(0.5));
    let product = program.compute(Op::Product(input, half));
    program.output(product, 0);
    let row: Vec<f32> = (0..80).map(|v| v as f32).collect();
    let run = Run { inputs: &[&row], lines: &[], start: 16, count: 64 };
    for set in sets() {
        let code = Code::compile(&program, set, Stores::Around).unwrap();
        let mut buffer = Buffer::zeroed(96, 0).unwrap();
        write_around(&mut [&mut buffer[..]], |targets| code.run(&run, targets, &mut [], &mut Scratch::default()));
        for (at, v) in buffer.iter().enumerate() {
            let inside = (16..80).contains(&at);
            assert_eq!(*v, if inside { (at - 16) as f32 / 2.0 } else { 0.0 }, "{set:?} {at}");
        }
        for (start, around) in [(16, false), (15, true)] {
            let refused = std::panic::catch_unwind(|| {
                let mut buffer = Buffer::zeroed(96, 0).unwrap();
                let run = Run { start, ..run };
                if around {
                    write_around(&mut [&mut buffer[..]], |targets| {
                        code.run(&run, targets, &mut [], &mut Scratch::default())
                    });
                } else {
                    code.run(&run, &mut [Target::new(&mut buffer)], &mut [], &mut Scratch::default());
                }
            });
            assert!(refused.is_err(), "{set:?} {start} {around}");
        }
    }
}

/// Tests every way in which a caller could make the code access memory beyond its slices.
#[test]
fn what_does_not_fit_is_refused() {
    let mut program = Program::new(1, 1, 1, 1);
    let (input, line) = (program.compute(Op::Input(0)), program.compute(Op::Line(0)));
    let product = program.compute(Op::Product(input, line));
    program.see(product, None, 0, false);
    program.output(product, 0);
    let row = [1.0f32; 32];
    for set in sets() {
        let code = Code::compile(&program, set, Stores::Cached).unwrap();
        let call = |inputs: &[&[f32]], lines: &[&[f32]], size: usize, states: usize, count: usize| {
            std::panic::catch_unwind(|| {
                let mut out = vec![0.0f32; size];
                let mut state = vec![Lanes([0; 16]); states];
                let run = Run { inputs, lines, start: 0, count };
                code.run(&run, &mut [Target::new(&mut out)], &mut state, &mut Scratch::default());
            })
        };
        assert!(call(&[&row], &[&[0.5]], 32, 1, 32).is_ok());
        assert!(call(&[&row], &[&[0.5]], 0, 1, 0).is_ok());
        assert!(call(&[&row[..31]], &[&[0.5]], 32, 1, 32).is_err(), "an input too short");
        assert!(call(&[&row], &[&[]], 32, 1, 32).is_err(), "a line of nothing");
        assert!(call(&[&row], &[&[0.5]], 31, 1, 32).is_err(), "a target too short");
        assert!(call(&[&row], &[&[0.5]], 32, 0, 32).is_err(), "no state");
        assert!(call(&[&row], &[&[0.5]], 32, 1, 17).is_err(), "no whole steps");
        assert!(call(&[], &[&[0.5]], 32, 1, 32).is_err(), "no input");
        assert!(call(&[&row], &[], 32, 1, 32).is_err(), "no line");
    }
}

/// Tests more pointers, and more values at once, than there are registers for.
#[test]
fn many_rows_and_many_values_live_at_once() {
    let count = 70;
    let mut program = Program::new(count, 0, count, 0);
    let values: Vec<Value> = (0..count as u32).map(|index| program.compute(Op::Input(index))).collect();
    let all: Vec<Value> = values
        .iter()
        .enumerate()
        .map(|(i, v)| program.compute(Op::Product(*v, values[(i * 31 + 7) % count])))
        .collect();
    let reversed: Vec<Value> = all.iter().rev().copied().collect();
    for (index, (v, w)) in all.iter().zip(&reversed).enumerate() {
        let sum = program.compute(Op::Mix { a: *v, b: *w, t: values[(index * 17) % count] });
        program.output(sum, index as u32);
    }
    let rows: Vec<Vec<f32>> =
        (0..count).map(|i| (0..32).map(|x| ((i * 37 + x * 11) % 100) as f32 / 99.0).collect()).collect();
    let inputs: Vec<&[f32]> = rows.iter().map(|row| &row[..]).collect();
    for set in sets() {
        let code = Code::compile(&program, set, Stores::Cached).unwrap();
        let mut out = vec![vec![0.0f32; 32]; count];
        let mut targets: Vec<Target<'_>> = out.iter_mut().map(|row| Target::new(row)).collect();
        code.run(
            &Run { inputs: &inputs, lines: &[], start: 0, count: 32 },
            &mut targets,
            &mut [],
            &mut Scratch::default(),
        );
        for x in 0..32 {
            let sample: Vec<f32> = rows.iter().map(|row| row[x]).collect();
            let (expected, ..) = reference(&program, &sample, &[]);
            for (index, expected) in expected.iter().enumerate() {
                assert_eq!(out[index][x].to_bits(), expected.to_bits(), "{set:?} {index} {x}");
            }
        }
    }
}
