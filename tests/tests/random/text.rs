//! Text of a generated graph as a document.

use super::draw::{Arg, Kind, Op};
use super::pixels::{INPUTS, MORE};
use rand::{Rng, RngExt};

/// Returns the document, given its format, what outputs have beside their nodes, and the file of its passes; some
/// numbers and colors are keyed such that frame 2 has the value drawn.
pub(crate) fn text(
    nodes: &[(Op, Kind)],
    disabled: &[bool],
    outputs: &[usize],
    [format, output_text, file]: [&str; 3],
    random: &mut impl Rng,
) -> String {
    let list: Vec<String> = nodes
        .iter()
        .zip(disabled)
        .enumerate()
        .map(|(index, ((op, _), disabled))| {
            let disabled = if *disabled { r#", "disabled": true"# } else { "" };
            format!(r#""{}": {{ {}{disabled} }}"#, name(nodes, index), body(op, nodes, file, random))
        })
        .collect();
    let outputs: Vec<String> = outputs
        .iter()
        .map(|&output| {
            let key = match nodes[output].1 {
                Kind::Color => "color",
                Kind::Field => "field",
                Kind::Mask | Kind::Weights(_) => "weights",
            };
            format!(r#""out{output}": {{ "{key}": "{}"{output_text} }}"#, name(nodes, output))
        })
        .collect();
    format!(
        "{{ \"trochoid\": 1, \"format\": {{ {format} }},\n\"nodes\": {{\n{} }},\n\"outputs\": {{ {} }} }}",
        list.join(",\n"),
        outputs.join(", ")
    )
}

fn name(nodes: &[(Op, Kind)], index: usize) -> String {
    if let Op::Input(name) = nodes[index].0 { name.into() } else { format!("n{index}") }
}

/// Returns the value, or a keyed knob that has it at frame 2, between other values.
fn keyed(value: String, others: [&str; 2], random: &mut impl Rng) -> String {
    if random.random_bool(0.8) {
        return value;
    }
    let interpolation = ["linear", "hold", "monotone"][random.random_range(0..3)];
    let [before, after] = others;
    // A level handle changes no value at a key, and leaves no range.
    let zero = if value.starts_with('[') { "[0, 0, 0]" } else { "0" };
    let more = match random.random_range(0..4) {
        0 if interpolation != "hold" => format!(r#", {{ "in": [-0.5, {zero}], "out": [9, {zero}] }}"#),
        1 => r#", { "interpolation": "hold" }"#.into(),
        _ => String::new(),
    };
    format!(r#"{{ "keys": [[1, {before}], [2, {value}{more}], [5, {after}]], "interpolation": "{interpolation}" }}"#)
}

fn arg(arg: &Arg, nodes: &[(Op, Kind)], random: &mut impl Rng) -> String {
    match arg {
        Arg::Node(node) => format!(r#""{}""#, name(nodes, *node)),
        Arg::Number(number) => keyed(format!("{number:?}"), ["0.125", "1"], random),
        Arg::Color(color) => {
            let [r, g, b] = color.map(f64::from);
            keyed(format!("[{r:?}, {g:?}, {b:?}]"), ["[0, 1, 2]", "[0.5, 0, 3]"], random)
        }
    }
}

fn body(op: &Op, nodes: &[(Op, Kind)], file: &str, random: &mut impl Rng) -> String {
    let mut one = |a: &Arg| arg(a, nodes, random);
    match op {
        Op::Input(name) => {
            let (_, kind, channels) = INPUTS.iter().chain(&MORE).find(|input| input.0 == *name).unwrap();
            let channels: Vec<String> = (0..*channels).map(|channel| format!(r#""{name}_{channel}""#)).collect();
            let repair = if name.starts_with('x') { r#", "repair": true"# } else { "" };
            format!(
                r#""type": "Read", "file": "{file}", "as": "{kind}", "channels": [{}]{repair}"#,
                channels.join(", ")
            )
        }
        Op::Mix { a, b, t } => {
            format!(r#""type": "Mix", "a": {}, "b": {}, "weight": {}"#, one(a), one(b), one(t))
        }
        Op::Blend { colors, weights } => {
            let colors: Vec<String> = colors.iter().map(&mut one).collect();
            let weights = match weights {
                Ok(numbers) => format!("{numbers:?}"),
                Err(node) => one(&Arg::Node(*node)),
            };
            format!(r#""type": "Blend", "colors": [{}], "weights": {weights}"#, colors.join(", "))
        }
        Op::Clamp { x, min, max, smooth, power } => {
            let x = one(x);
            let power = keyed(format!("{power:?}"), ["1", "3.5"], random);
            format!(
                r#""type": "Clamp", "field": {x}, "min": {min:?}, "max": {max:?}, "smooth": {smooth}, "power": {power}"#
            )
        }
        Op::Ramp { t, stops, interpolation } => {
            let t = one(t);
            let stops: Vec<String> =
                stops.iter().map(|(at, color)| format!(r#"{{ "at": {at:?}, "color": {} }}"#, one(color))).collect();
            let stops = stops.join(", ");
            format!(r#""type": "Ramp", "weight": {t}, "interpolation": "{interpolation}", "stops": [{stops}]"#)
        }
        Op::Bands { x, thresholds, width } => {
            format!(r#""type": "Bands", "field": {}, "thresholds": {thresholds:?}, "width": {width:?}"#, one(x))
        }
        Op::Patch { u, v, colors } => {
            let (u, v) = (one(u), one(v));
            let colors: Vec<String> = colors.iter().map(&mut one).collect();
            format!(r#""type": "Patch", "u": {u}, "v": {v}, "colors": [{}]"#, colors.join(", "))
        }
        Op::Normalize { fields, floor } => {
            let fields: Vec<String> = fields.iter().map(&mut one).collect();
            format!(r#""type": "Normalize", "fields": [{}], "floor": {floor:?}"#, fields.join(", "))
        }
        Op::Other(pieces, args) => {
            let between = args.iter().map(&mut one).chain([String::new()]);
            // Textures read the file of the passes, too.
            pieces.iter().zip(between).map(|(piece, arg)| piece.replace("FILE", file) + &arg).collect()
        }
        Op::Invert(mask) => format!(r#""type": "Invert", "weight": {}"#, one(mask)),
        Op::Stack(masks) | Op::Multiply(masks) | Op::Screen(masks) => {
            let ty = match op {
                Op::Stack(_) => "Stack",
                Op::Multiply(_) => "Multiply",
                _ => "Screen",
            };
            let masks: Vec<String> = masks.iter().map(&mut one).collect();
            format!(r#""type": "{ty}", "weights": [{}]"#, masks.join(", "))
        }
    }
}
