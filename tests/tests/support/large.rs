//! Documents of any number of nodes, the same at every call; benchmarks include this file too.

use std::fmt::Write as _;

/// A small generator of random numbers, so that this file needs only the standard library.
struct Draw(u64);

impl Draw {
    fn below(&mut self, bound: usize) -> usize {
        // Knuth's MMIX generator; the upper bits are the random ones.
        self.0 = self.0.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1_442_695_040_888_963_407);
        ((self.0 >> 33) as usize) % bound
    }

    fn unit(&mut self) -> f64 {
        self.below(1000) as f64 / 1000.0
    }

    fn color(&mut self) -> String {
        format!("[{}, {}, {}]", self.unit(), self.unit(), self.unit())
    }
}

/// Returns a document of this size with these nodes and outputs.
pub(crate) fn document(size: (u32, u32), nodes: &str, outputs: &str) -> String {
    let (width, height) = size;
    format!(
        "{{ \"trochoid\": 1, \"format\": {{ \"width\": {width}, \"height\": {height} }},\n\"nodes\": {{\n{nodes}\n}},\n\
         \"outputs\": {{ {outputs} }} }}\n"
    )
}

/// A chain of `count` nodes: each Mix mixes the one before it with a constant color, by a constant or by a mask.
pub(crate) fn chain(count: usize, size: (u32, u32)) -> String {
    let mut draw = Draw(1);
    let mut nodes = String::from(
        "\"x\": { \"type\": \"ScreenX\" },\n\"t\": { \"type\": \"Clamp\", \"field\": \"x\", \"min\": 0.2, \"max\": 0.9 }",
    );
    let mut last = draw.color();
    for index in 2..count {
        let weight = match draw.below(4) {
            0 => "\"x\"".into(),
            1 => "\"t\"".into(),
            2 if draw.below(4) == 0 => "0".into(),
            _ => (0.9 * draw.unit()).to_string(),
        };
        let color = draw.color();
        let _ = write!(
            nodes,
            ",\n\"n{index}\": {{ \"type\": \"Mix\", \"a\": {last}, \"b\": {color}, \"weight\": {weight} }}"
        );
        last = format!("\"n{index}\"");
    }
    document(size, &nodes, &format!("\"out\": {{ \"color\": {last} }}"))
}

/// Nodes of one kind in a random graph; those that nothing reads yet are also in `unread`.
#[derive(Default)]
struct Pool {
    names: Vec<String>,
    unread: Vec<String>,
}

impl Pool {
    /// Draws a node; at every second draw one that nothing reads yet, so that most nodes are used.
    fn draw(&mut self, draw: &mut Draw) -> Option<String> {
        if draw.below(2) == 0
            && let Some(name) = self.unread.pop()
        {
            return Some(name);
        }
        if self.names.is_empty() { None } else { Some(self.names[draw.below(self.names.len())].clone()) }
    }

    fn add(&mut self, name: &str) {
        self.names.push(format!("\"{name}\""));
        self.unread.push(format!("\"{name}\""));
    }
}

/// A random graph of `count` nodes of every pointwise kind. Masks are made with slopes of at most 1, so that rounding
/// does not grow along the way.
pub(crate) fn web(count: usize, size: (u32, u32)) -> String {
    let mut draw = Draw(2);
    let (mut colors, mut masks, mut threes) = (Pool::default(), Pool::default(), Pool::default());
    let mut nodes = String::from("\"x\": { \"type\": \"ScreenX\" },\n\"y\": { \"type\": \"ScreenY\" }");
    masks.add("x");
    masks.add("y");
    for index in 2..count.saturating_sub(1) {
        let name = format!("n{index}");
        let kind = draw.below(14);
        let mask = |masks: &mut Pool, draw: &mut Draw| match draw.below(60) {
            0 => "0".into(),
            1 => "1".into(),
            2..12 => draw.unit().to_string(),
            _ => masks.draw(draw).unwrap_or("0.5".into()),
        };
        let color = |colors: &mut Pool, draw: &mut Draw| {
            let drawn = if draw.below(3) == 0 { None } else { colors.draw(draw) };
            drawn.unwrap_or_else(|| draw.color())
        };
        let mut m = |draw: &mut Draw| mask(&mut masks, draw);
        let mut c = |draw: &mut Draw| color(&mut colors, draw);
        let d = &mut draw;
        let text = match kind {
            0..=2 => format!(r#""type": "Mix", "a": {}, "b": {}, "weight": {}"#, c(d), c(d), m(d)),
            3 => {
                let weights = threes.draw(d).unwrap_or("[0.5, 0, 0.5]".into());
                format!(r#""type": "Blend", "colors": [{}, {}, {}], "weights": {weights}"#, c(d), c(d), c(d))
            }
            4 => format!(
                r#""type": "Ramp", "weight": {}, "stops": [{{ "at": 0, "color": {} }}, {{ "at": 0.5, "color": {} }}, {{ "at": 1, "color": {} }}]"#,
                m(d),
                c(d),
                c(d),
                c(d)
            ),
            5 => format!(
                r#""type": "Patch", "u": {}, "v": {}, "colors": [{}, {}, {}, {}]"#,
                m(d),
                m(d),
                c(d),
                c(d),
                c(d),
                c(d)
            ),
            6 => format!(r#""type": "Clamp", "field": {}, "min": -0.25, "max": {}"#, m(d), 1.0 + d.unit()),
            7 => format!(r#""type": "Invert", "weight": {}"#, m(d)),
            8 | 9 => format!(r#""type": "Multiply", "weights": [{}, {}]"#, m(d), m(d)),
            10 => format!(r#""type": "Screen", "weights": [{}, {}]"#, m(d), m(d)),
            11 => format!(r#""type": "Bands", "field": {}, "thresholds": [0.25, 0.75], "width": 1"#, m(d)),
            12 => format!(r#""type": "Stack", "weights": [{}, {}]"#, m(d), m(d)),
            _ => format!(r#""type": "Normalize", "fields": [{}, {}], "floor": 2"#, m(d), m(d)),
        };
        let _ = write!(nodes, ",\n\"{name}\": {{ {text} }}");
        match kind {
            0..=5 => colors.add(&name),
            6..=10 => masks.add(&name),
            _ => threes.add(&name),
        }
    }
    // The output reads every color that nothing else does.
    let mut unread = colors.unread;
    unread.push(draw.color());
    let weight = 1.0 / unread.len() as f64;
    let weights = vec![format!("{weight:.12}"); unread.len()].join(", ");
    let _ = write!(
        nodes,
        ",\n\"out\": {{ \"type\": \"Blend\", \"colors\": [{}, {}], \"weights\": [0, {weights}] }}",
        draw.color(),
        unread.join(", ")
    );
    document(size, &nodes, "\"out\": { \"color\": \"out\" }")
}
