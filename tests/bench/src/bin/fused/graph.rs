//! Random documents.

use std::fmt::Write as _;

/// Size of the picture.
pub(crate) const WIDTH: usize = 1920;
/// Size of the picture.
pub(crate) const HEIGHT: usize = 1080;
/// Nodes that buffers replace: four masks and a field. They come first in every graph.
pub(crate) const PASSES: [&str; 5] = ["c", "s", "f", "a", "z"];
/// Index of the field among them.
const FIELD: usize = 4;
/// Number of nodes after the passes, before the remaining unread nodes are mixed in.
const COUNT: usize = 60;

/// A small generator of random numbers.
pub(crate) struct Draw(u64);

impl Draw {
    pub(crate) fn new(seed: u64) -> Self {
        let mut draw = Self(seed);
        draw.below(1);
        draw
    }

    fn next(&mut self) -> u64 {
        // Knuth's MMIX generator; the upper bits are the random ones.
        self.0 = self.0.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1_442_695_040_888_963_407);
        self.0 >> 33
    }

    fn below(&mut self, bound: usize) -> usize {
        self.next() as usize % bound
    }

    /// Draws a number from 0 to 1 with all bits of an f32.
    pub(crate) fn unit(&mut self) -> f32 {
        (self.next() >> 7) as f32 / 16_777_215.0
    }

    /// Draws a number with two decimals, so that documents are readable.
    fn between(&mut self, low: f64, high: f64) -> f64 {
        let steps = ((high - low) * 100.0).round() as usize;
        ((low * 100.0).round() + self.below(steps + 1) as f64) / 100.0
    }
}

/// A color's source.
#[derive(Clone, Copy, PartialEq)]
pub(crate) enum Paint {
    Node(usize),
    Constant([f64; 3]),
}

/// A node; masks and fields are named by their index in the graph.
pub(crate) enum Node {
    Read,
    ScreenX,
    Clamp { of: usize, min: f64, max: f64 },
    Multiply(usize, usize),
    Screen(usize, usize),
    Invert(usize),
    Bands { of: usize, thresholds: [f64; 2], width: f64 },
    Mix { a: Paint, b: Paint, weight: usize },
    Patch { u: usize, v: usize, colors: [Paint; 4] },
    Ramp { weight: usize, at: [f64; 4], colors: [Paint; 4] },
    Blend { colors: [Paint; 3], bands: usize },
}

/// A graph: each node reads earlier ones, the last is the picture.
pub(crate) struct Graph {
    pub(crate) nodes: Vec<Node>,
}

/// Nodes of one kind; those that nothing reads yet are also in `unread`.
#[derive(Default)]
struct Pool {
    all: Vec<usize>,
    unread: Vec<usize>,
}

impl Pool {
    fn add(&mut self, node: usize) {
        self.all.push(node);
        self.unread.push(node);
    }

    /// Draws a node; at every second draw one that nothing reads yet, so that most nodes are used.
    fn draw(&mut self, draw: &mut Draw) -> Option<usize> {
        if draw.below(2) == 0
            && let Some(node) = self.unread.pop()
        {
            return Some(node);
        }
        if self.all.is_empty() {
            return None;
        }
        let node = self.all[draw.below(self.all.len())];
        self.unread.retain(|unread| *unread != node);
        Some(node)
    }
}

/// State of a graph that is being made.
struct Maker {
    draw: Draw,
    nodes: Vec<Node>,
    masks: Pool,
    colors: Pool,
}

impl Maker {
    fn mask(&mut self) -> usize {
        // There are masks from the start.
        self.masks.draw(&mut self.draw).unwrap_or(0)
    }

    /// Draws two different masks.
    fn pair(&mut self) -> (usize, usize) {
        let first = self.mask();
        loop {
            let second = self.mask();
            if second != first {
                return (first, second);
            }
        }
    }

    fn constant(&mut self) -> Paint {
        Paint::Constant([(); 3].map(|()| self.draw.between(0.0, 1.0)))
    }

    /// Draws a color; every third is a constant, as are those before the first node that makes a color.
    fn paint(&mut self) -> Paint {
        let drawn = if self.draw.below(3) == 0 { None } else { self.colors.draw(&mut self.draw) };
        drawn.map_or_else(|| self.constant(), Paint::Node)
    }

    /// Draws colors for one node, all different, because equal ones could be optimized away.
    fn paints<const N: usize>(&mut self) -> [Paint; N] {
        let mut paints: Vec<Paint> = Vec::new();
        [(); N].map(|()| {
            loop {
                let paint = self.paint();
                if !paints.contains(&paint) {
                    paints.push(paint);
                    break paint;
                }
            }
        })
    }

    fn add_mask(&mut self, node: Node) {
        self.masks.add(self.nodes.len());
        self.nodes.push(node);
    }

    fn add_color(&mut self, node: Node) {
        self.colors.add(self.nodes.len());
        self.nodes.push(node);
    }

    /// Adds a node; after Bands, also the Blend that reads them. Slopes are small, so rounding grows little.
    fn grow(&mut self) {
        let of_field = self.draw.below(2) == 0;
        match self.draw.below(100) {
            0..12 => {
                let (u, v) = self.pair();
                let colors = self.paints();
                self.add_color(Node::Patch { u, v, colors });
            }
            12..20 => {
                let at = [0.0, self.draw.between(0.2, 0.4), self.draw.between(0.6, 0.8), 1.0];
                let (weight, colors) = (self.mask(), self.paints());
                self.add_color(Node::Ramp { weight, at, colors });
            }
            20..26 => {
                let of = if of_field { FIELD } else { self.mask() };
                let unit = if of_field { 1000.0 } else { 1.0 };
                let thresholds = [self.draw.between(0.2, 0.4) * unit, self.draw.between(0.6, 0.8) * unit];
                let bands = self.nodes.len();
                self.nodes.push(Node::Bands { of, thresholds, width: 0.2 * unit });
                let colors = self.paints();
                self.add_color(Node::Blend { colors, bands });
            }
            26..36 => {
                let of = if of_field { FIELD } else { self.mask() };
                let unit = if of_field { 1000.0 } else { 1.0 };
                let (min, max) = (self.draw.between(0.0, 0.2) * unit, self.draw.between(0.7, 1.0) * unit);
                self.add_mask(Node::Clamp { of, min, max });
            }
            36..46 => {
                let (t, u) = self.pair();
                self.add_mask(Node::Multiply(t, u));
            }
            46..50 => {
                let t = self.mask();
                self.add_mask(Node::Invert(t));
            }
            50..54 => {
                let (t, u) = self.pair();
                self.add_mask(Node::Screen(t, u));
            }
            _ => {
                let ([a, b], weight) = (self.paints(), self.mask());
                self.add_color(Node::Mix { a, b, weight });
            }
        }
    }
}

impl Graph {
    /// Makes the graph of a seed.
    pub(crate) fn random(seed: u64) -> Self {
        let mut maker =
            Maker { draw: Draw::new(seed), nodes: Vec::new(), masks: Pool::default(), colors: Pool::default() };
        for pass in 0..PASSES.len() {
            maker.nodes.push(Node::Read);
            if pass != FIELD {
                maker.masks.add(pass);
            }
        }
        // The field is read in any case.
        maker.add_mask(Node::ScreenX);
        maker.add_mask(Node::Clamp { of: FIELD, min: 20.0, max: 800.0 });
        while maker.nodes.len() + maker.colors.unread.len().max(maker.masks.unread.len()) < PASSES.len() + COUNT {
            maker.grow();
        }
        // Unread nodes are mixed in, so that every node affects the picture.
        while maker.colors.unread.len() != 1 || !maker.masks.unread.is_empty() {
            let paint = |maker: &mut Maker| match maker.colors.unread.pop() {
                Some(node) => Paint::Node(node),
                None => maker.constant(),
            };
            let (b, a) = (paint(&mut maker), paint(&mut maker));
            let weight = maker.masks.unread.pop().unwrap_or_else(|| maker.mask());
            maker.add_color(Node::Mix { a, b, weight });
        }
        Self { nodes: maker.nodes }
    }

    /// Returns a node's name in the document and in C.
    pub(crate) fn name(&self, node: usize) -> String {
        match PASSES.get(node) {
            Some(name) => (*name).into(),
            None if matches!(self.nodes[node], Node::ScreenX) => "across".into(),
            None => format!("n{}", node - PASSES.len()),
        }
    }

    /// Returns the document.
    pub(crate) fn json(&self) -> String {
        let nodes: Vec<String> = (0..self.nodes.len())
            .map(|node| {
                let name = format!("\"{}\":", self.name(node));
                let items = self.items(node);
                // Long lists of colors go on lines of their own, with one line per stop.
                if name.len().max(9) + items.len() > 110 {
                    let items = items.replacen(": [", ":\n      [", 1).replace("}, {", "},\n       {");
                    format!("    {name:<9} {{ {items} }}")
                } else {
                    format!("    {name:<9} {{ {items} }}")
                }
            })
            .collect();
        let mut text = String::new();
        let _ = write!(
            text,
            "{{\n  \"trochoid\": 1,\n  \"format\": {{ \"width\": {WIDTH}, \"height\": {HEIGHT} }},\n  \
             \"working_space\": \"linear-srgb\",\n  \"nodes\": {{\n{}\n  }},\n  \
             \"outputs\": {{ \"out\": {{ \"color\": \"{}\" }} }}\n}}\n",
            nodes.join(",\n"),
            self.name(self.nodes.len() - 1)
        );
        text
    }

    /// Returns the text between a node's braces.
    fn items(&self, node: usize) -> String {
        let name = |node: usize| format!("\"{}\"", self.name(node));
        let paint = |paint: &Paint| match paint {
            Paint::Node(node) => name(*node),
            Paint::Constant([r, g, b]) => format!("[{r}, {g}, {b}]"),
        };
        let paints = |paints: &[Paint]| paints.iter().map(paint).collect::<Vec<_>>().join(", ");
        match &self.nodes[node] {
            Node::Read => {
                let kind = if node == FIELD { "field" } else { "weights" };
                format!(
                    r#""type": "Read", "file": "passes.exr", "channels": ["{}.V"], "as": "{kind}""#,
                    self.name(node)
                )
            }
            Node::ScreenX => r#""type": "ScreenX""#.into(),
            Node::Clamp { of, min, max } => {
                format!(r#""type": "Clamp", "field": {}, "min": {min}, "max": {max}"#, name(*of))
            }
            Node::Multiply(t, u) => format!(r#""type": "Multiply", "weights": [{}, {}]"#, name(*t), name(*u)),
            Node::Screen(t, u) => format!(r#""type": "Screen", "weights": [{}, {}]"#, name(*t), name(*u)),
            Node::Invert(t) => format!(r#""type": "Invert", "weight": {}"#, name(*t)),
            Node::Bands { of, thresholds, width } => {
                let of = name(*of);
                let [low, high] = thresholds;
                format!(r#""type": "Bands", "field": {of}, "thresholds": [{low}, {high}], "width": {width}"#)
            }
            Node::Mix { a, b, weight } => {
                format!(r#""type": "Mix", "a": {}, "b": {}, "weight": {}"#, paint(a), paint(b), name(*weight))
            }
            Node::Patch { u, v, colors } => {
                let colors = paints(colors);
                format!(r#""type": "Patch", "u": {}, "v": {}, "colors": [{colors}]"#, name(*u), name(*v))
            }
            Node::Ramp { weight, at, colors } => {
                let stops = at.iter().zip(colors);
                let stops: Vec<String> =
                    stops.map(|(at, color)| format!(r#"{{ "at": {at}, "color": {} }}"#, paint(color))).collect();
                format!(r#""type": "Ramp", "weight": {}, "stops": [{}]"#, name(*weight), stops.join(", "))
            }
            Node::Blend { colors, bands } => {
                format!(r#""type": "Blend", "colors": [{}], "weights": {}"#, paints(colors), name(*bands))
            }
        }
    }
}
