//! Nodes and passes beyond those that [`bound`](super::bound) evaluates: all other back-end nodes, fields, filters;
//! numbers that f32 does not hold; and passes as hostile as files may be.

use super::draw::{Arg, Drawing, Kind, Op};
use super::pixels::{AREA, INPUTS, Input, MORE, Pixels, pick};
use rand::seq::IndexedRandom;
use rand::{Rng, RngExt};

/// All inputs of a graph that reads files.
pub(super) fn inputs() -> Vec<Input> {
    INPUTS.into_iter().chain(MORE).collect()
}

/// Draws samples of a magnitude, with extremes among them.
fn number(random: &mut impl Rng, scale: f64) -> f32 {
    match random.random_range(0..10) {
        0 => 0.0,
        1 => pick(&[1e-45, 1e-40, f32::MIN_POSITIVE, 1.0, 0.5, 65504.0, 1e30], random),
        2 => (scale * 1e-7 * random.random_range(0.0..1.0)) as f32,
        _ => (scale * random.random_range(0.0..1.0)) as f32,
    }
}

/// Weights whose sum is off by up to `off`.
fn weights(random: &mut impl Rng, count: usize, off: f64) -> Vec<f32> {
    let raw: Vec<f64> = (0..count)
        .map(|_| if random.random_bool(0.2) { 0.0 } else { random.random_range(0.0..1.0f64).powi(3) })
        .map(|weight: f64| weight + 1e-9)
        .collect();
    let sum: f64 = raw.iter().sum();
    let scale = (1.0 + off * random.random_range(-1.0..1.0)) / sum;
    raw.into_iter().map(|weight| ((weight * scale) as f32).min(1.0)).collect()
}

/// Passes of any magnitude, with weights that do not sum to 1, and with data that only repairing makes legal.
pub(super) fn passes(random: &mut impl Rng) -> Pixels {
    let scale = [1.0, 1.0, 1e-3, 65504.0, 65504.0, 1e30, 1e-40].choose(random).copied().unwrap_or(1.0);
    let off = [0.0, 4e-8, 4e-8, 1e-6, 9.9e-4].choose(random).copied().unwrap_or(0.0);
    let bad = [f32::NAN, -1.0, f32::INFINITY, f32::NEG_INFINITY, -1e-45, 2.0];
    let mut planes = Vec::new();
    for (name, kind, channels) in inputs() {
        let mut rows = vec![Vec::with_capacity(AREA); channels];
        for _ in 0..AREA {
            let mut sample: Vec<f32> = match (kind, channels) {
                ("field", _) => {
                    let sign = if random.random_bool(0.3) { -1.0 } else { 1.0 };
                    let infinite = pick(&[f32::INFINITY, f32::NEG_INFINITY, f32::MAX], random);
                    vec![if random.random_bool(0.03) { infinite } else { sign * number(random, scale) }]
                }
                ("weights", 1) => vec![number(random, 1.0).min(1.0)],
                ("weights", _) => weights(random, channels, off),
                _ => (0..channels).map(|_| number(random, scale)).collect(),
            };
            if name.starts_with('x') && random.random_bool(0.3) {
                let channel = random.random_range(0..channels);
                sample[channel] = pick(&bad, random);
            }
            rows.iter_mut().zip(sample).for_each(|(row, value)| row.push(value));
        }
        planes.extend(rows.into_iter().enumerate().map(|(channel, row)| (format!("{name}_{channel}"), row)));
    }
    Pixels { planes }
}

/// A node of any kind; two in three are back-end nodes with numbers that f32 may not hold.
pub(super) fn node<R: Rng>(drawing: &mut Drawing<'_, R>) -> (Op, Kind) {
    match drawing.random.random_range(0..30) {
        0..10 => drawing.node(),
        10..13 => clamp(drawing),
        13 | 14 => bands(drawing),
        15 => ramp(drawing),
        16 => sheet(drawing),
        17 => (literal_weights(drawing), Kind::Color),
        18 => switch(drawing),
        19 => {
            let color: Vec<String> = (0..3).map(|_| format!("{:?}", number(drawing.random, 3.0))).collect();
            (
                Op::Other(vec![format!(r#""type": "Constant", "color": [{}]"#, color.join(", "))], Vec::new()),
                Kind::Color,
            )
        }
        20 => normalize(drawing),
        21..26 => field(drawing),
        26 | 27 => filter(drawing),
        _ => texture(drawing),
    }
}

/// A decimal number of a field's magnitude.
fn place(random: &mut impl Rng) -> f64 {
    let scale = [1.0, 1.0, 1000.0, 65504.0, 1e30, 1e-41].choose(random).copied().unwrap_or(1.0);
    scale * f64::from(random.random_range(-1000..=2000)) / 1000.0
}

fn clamp<R: Rng>(drawing: &mut Drawing<'_, R>) -> (Op, Kind) {
    let x = drawing.scalar();
    let random = &mut *drawing.random;
    let min = place(random);
    let width = [0.0, 1e-9, 1e-4, 0.37, 3.0, 1e4].choose(random).copied().unwrap_or(1.0);
    let power = [1.0, 1.0, 1.0 + 3e-8, 1.1, 7.3, 999.9].choose(random).copied().unwrap_or(1.0);
    let smooth = random.random_bool(0.4);
    (Op::Clamp { x, min, max: min + width * min.abs().max(1e-42), smooth, power }, Kind::Mask)
}

fn bands<R: Rng>(drawing: &mut Drawing<'_, R>) -> (Op, Kind) {
    let x = drawing.scalar();
    let random = &mut *drawing.random;
    let count = random.random_range(1..5);
    let mut thresholds: Vec<f64> = (0..count).map(|_| place(random)).collect();
    thresholds.sort_by(f64::total_cmp);
    let scale = thresholds.iter().fold(1e-42, |scale: f64, at| scale.max(at.abs()));
    let width = scale * [0.0, 1e-8, 1e-6, 0.01, 0.3, 2.0].choose(random).copied().unwrap_or(0.3);
    (Op::Bands { x, thresholds, width }, if count == 1 { Kind::Mask } else { Kind::Weights(count + 1) })
}

/// Ascending positions in [0, 1].
fn positions(random: &mut impl Rng, count: usize) -> Vec<f64> {
    let mut at: Vec<f64> = (0..count).map(|_| f64::from(random.random_range(0..=1000)) / 1000.0).collect();
    at.sort_by(f64::total_cmp);
    if random.random_bool(0.2) {
        // Positions that are one in f32.
        (1..count).for_each(|i| at[i] = at[i].max((at[i - 1] * (1.0 + 1e-9)).min(1.0)));
    }
    at
}

fn ramp<R: Rng>(drawing: &mut Drawing<'_, R>) -> (Op, Kind) {
    let count = drawing.random.random_range(1..6);
    let at = positions(drawing.random, count);
    let stops = at.into_iter().map(|at| (at, drawing.color())).collect();
    let interpolation = ["linear", "smooth", "step"].choose(drawing.random).copied().unwrap_or("linear");
    (Op::Ramp { t: drawing.mask(), stops, interpolation }, Kind::Color)
}

fn sheet<R: Rng>(drawing: &mut Drawing<'_, R>) -> (Op, Kind) {
    let (columns, rows) = (drawing.random.random_range(1..4), drawing.random.random_range(1..4));
    let interpolation = ["linear", "smooth"].choose(drawing.random).copied().unwrap_or("linear");
    let mut knobs = format!(r#", "columns": {columns}, "interpolation": "{interpolation}""#);
    if drawing.random.random_bool(0.5) {
        let (across, down) = (positions(drawing.random, columns), positions(drawing.random, rows));
        knobs += &format!(r#", "columns_at": {across:?}, "rows_at": {down:?}"#);
    }
    let mut pieces = vec![r#""type": "Sheet", "u": "#.into(), r#", "v": "#.into(), r#", "colors": ["#.into()];
    let args: Vec<Arg> = [drawing.mask(), drawing.mask()].into_iter().chain(drawing.colors(columns * rows)).collect();
    pieces.extend((1..columns * rows).map(|_| ", ".to_string()));
    pieces.push(format!("]{knobs}"));
    (Op::Other(pieces, args), Kind::Color)
}

/// A Blend by numbers that sum to 1 as decimals do.
fn literal_weights<R: Rng>(drawing: &mut Drawing<'_, R>) -> Op {
    let count = drawing.random.random_range(2..6);
    let off = [0.0, 1e-8, 9e-7].choose(drawing.random).copied().unwrap_or(0.0);
    let raw: Vec<f64> = (0..count).map(|_| f64::from(drawing.random.random_range(0..50) + 1)).collect();
    let scale = (1.0 + off) / raw.iter().sum::<f64>();
    let colors = drawing.colors(count);
    Op::Blend { colors, weights: Ok(raw.into_iter().map(|weight| weight * scale).collect()) }
}

fn switch<R: Rng>(drawing: &mut Drawing<'_, R>) -> (Op, Kind) {
    let which = drawing.random.random_range(0..2);
    let pieces = [r#""type": "Switch", "inputs": ["#.into(), ", ".into(), format!(r#"], "which": {which}"#)].into();
    let kind = [Kind::Color, Kind::Mask].choose(drawing.random).copied().unwrap_or(Kind::Color);
    // Literals here have no keys.
    let mut input = || drawing.find(|found| found == kind).map_or(Arg::Number(0.5), Arg::Node);
    (Op::Other(pieces, vec![input(), input()]), kind)
}

fn normalize<R: Rng>(drawing: &mut Drawing<'_, R>) -> (Op, Kind) {
    let count = drawing.random.random_range(1..5);
    let fields = (0..count).map(|_| drawing.scalar()).collect();
    let floor = [0.001, 0.3, 1e-30, 7e4, 1e30].choose(drawing.random).copied().unwrap_or(1.0);
    (Op::Normalize { fields, floor }, if count == 1 { Kind::Mask } else { Kind::Weights(count + 1) })
}

/// A field or a mask that a front-end node makes.
fn field<R: Rng>(drawing: &mut Drawing<'_, R>) -> (Op, Kind) {
    let plain = |text: String, kind: Kind| (Op::Other(vec![text], Vec::new()), kind);
    let seed = drawing.random.random_range(0..1000);
    match drawing.random.random_range(0..9) {
        0 => plain(r#""type": "ScreenX""#.into(), Kind::Mask),
        1 => plain(r#""type": "ScreenY""#.into(), Kind::Mask),
        2 | 3 => {
            let kind = ["fbm", "ridged", "cellular", "edges"].choose(drawing.random).copied().unwrap_or("fbm");
            let scale = [0.05, 0.31, 7.0, 1e4].choose(drawing.random).copied().unwrap_or(1.0);
            let offset = [0.0, 0.3, -1e7].choose(drawing.random).copied().unwrap_or(0.0);
            let knobs = format!(r#""scale": {scale:?}, "offset": [{offset:?}, 1, 0], "seed": {seed}"#);
            plain(format!(r#""type": "Noise", "kind": "{kind}", {knobs}"#), Kind::Field)
        }
        4 => {
            let (x, y) = (drawing.random.random_range(0.0..5.0), drawing.random.random_range(0.0..1.0));
            let edge = [0.0, 0.3, 1.0, 40.0].choose(drawing.random).copied().unwrap_or(1.0);
            let shapes = format!(
                r#"{{ "center": [{x}, {y}], "radius": 0.6 }},
                {{ "form": "box", "center": [1.7, 0.4], "size": [0.9, 0.3], "corner": 0.1, "angle": {seed} }}"#
            );
            plain(format!(r#""type": "Shape", "edge": {edge:?}, "shapes": [{shapes}]"#), Kind::Mask)
        }
        5 => {
            let kind = ["canvas", "paper"].choose(drawing.random).copied().unwrap_or("paper");
            plain(format!(r#""type": "Grain", "kind": "{kind}", "threads": 1.3, "turn": {}"#, seed % 300), Kind::Mask)
        }
        6 => {
            let thin = [1e-6, 0.4, 1.0].choose(drawing.random).copied().unwrap_or(0.4);
            let knobs = format!(r#", "dry": 1.35, "from": 0.1, "to": {}, "thin": {thin:?}"#, 0.1 + 0.9 * thin);
            let pieces = vec![r#""type": "Scumble", "density": "#.into(), r#", "noise": "#.into(), knobs];
            (Op::Other(pieces, vec![drawing.mask(), drawing.scalar()]), Kind::Mask)
        }
        _ => {
            let formulas = [
                "a*0.7 - b",
                "a/(b*b + 0.001)",
                "sqrt(a)",
                "mod(a, 0.37) + floor(b)",
                "exp(min(a, 3)) - 1",
                "sin(a)*b^2",
                "if(a > b, a, 1 - b)",
                "smoothstep(0.1, 0.9, a) - b",
                "abs(a)^0.5 * sign(b)",
                "a*1e20",
                "a*1e-20*b",
                "log(abs(a) + 1e-30)",
                "max(a, b) - min(a, b)",
                "atan2(a, b + 2)",
            ];
            let formula = formulas.choose(drawing.random).copied().unwrap_or("a - b");
            let pieces = vec![
                format!(r#""type": "FieldMath", "expression": "{formula}", "nan": 0.3, "a": "#),
                r#", "b": "#.into(),
                String::new(),
            ];
            (Op::Other(pieces, vec![drawing.scalar(), drawing.scalar()]), Kind::Field)
        }
    }
}

/// A Blur or a Warp of anything.
fn filter<R: Rng>(drawing: &mut Drawing<'_, R>) -> (Op, Kind) {
    let kinds = [Kind::Color, Kind::Mask, Kind::Field, Kind::Weights(0)];
    let kind = kinds.choose(drawing.random).copied().unwrap_or(Kind::Color);
    let fits = |found: Kind| found == kind || matches!((kind, found), (Kind::Weights(_), Kind::Weights(_)));
    let Some(node) = drawing.find(fits) else { return drawing.node() };
    let (image, kind) = (Arg::Node(node), drawing.kind(node));
    if drawing.random.random_bool(0.5) {
        let size = [0.0, 0.3, 1.5].choose(drawing.random).copied().unwrap_or(1.0);
        let shape = ["gaussian", "box"].choose(drawing.random).copied().unwrap_or("box");
        let knobs = format!(r#", "size": {size:?}, "filter": "{shape}""#);
        return (Op::Other(vec![r#""type": "Blur", "image": "#.into(), knobs], vec![image]), kind);
    }
    let pieces = [r#""type": "Warp", "image": "#, r#", "dx": "#, r#", "dy": "#, r#", "reach": 2.5"#];
    (Op::Other(pieces.map(String::from).into(), vec![image, drawing.scalar(), drawing.scalar()]), kind)
}

/// A lookup in the file of the passes.
fn texture<R: Rng>(drawing: &mut Drawing<'_, R>) -> (Op, Kind) {
    let inputs = inputs();
    let (name, kind, channels) = inputs.choose(drawing.random).copied().unwrap_or(INPUTS[0]);
    let named: Vec<String> = (0..channels).map(|channel| format!(r#""{name}_{channel}""#)).collect();
    let wrap = ["repeat", "clamp", "mirror"].choose(drawing.random).copied().unwrap_or("repeat");
    let filter = ["bilinear", "nearest"].choose(drawing.random).copied().unwrap_or("bilinear");
    let knobs =
        format!(r#", "wrap": "{wrap}", "filter": "{filter}", "repair": true, "channels": [{}]"#, named.join(", "));
    let pieces =
        vec![format!(r#""type": "Texture", "file": "FILE", "as": "{kind}", "u": "#), r#", "v": "#.into(), knobs];
    let kind = match (kind, channels) {
        ("field", _) => Kind::Field,
        ("color", _) => Kind::Color,
        (_, 1 | 2) => Kind::Mask,
        (_, n) => Kind::Weights(n),
    };
    (Op::Other(pieces, vec![drawing.scalar(), drawing.scalar()]), kind)
}
