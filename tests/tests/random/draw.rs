//! Generation of random documents of back-end nodes.

use super::pixels::{COLORS, FIELDS, HEIGHT, INPUTS, Input, WIDTH, pick};
use rand::seq::IndexedRandom;
use rand::{Rng, RngExt};

/// Kind of value of a node or a literal.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) enum Kind {
    Color,
    Mask,
    Field,
    Weights(usize),
}

/// Source of a port.
#[derive(Clone, Copy, Debug)]
pub(crate) enum Arg {
    Node(usize),
    Number(f64),
    Color([f32; 3]),
}

/// A node; its numbers are exact in f32.
#[derive(Clone, Debug)]
pub(crate) enum Op {
    Input(&'static str),
    Mix {
        a: Arg,
        b: Arg,
        t: Arg,
    },
    /// Literal weights, or those of a node.
    Blend {
        colors: Vec<Arg>,
        weights: Result<Vec<f64>, usize>,
    },
    Clamp {
        x: Arg,
        min: f64,
        max: f64,
        smooth: bool,
        power: f64,
    },
    Ramp {
        t: Arg,
        stops: Vec<(f64, Arg)>,
        interpolation: &'static str,
    },
    Bands {
        x: Arg,
        thresholds: Vec<f64>,
        width: f64,
    },
    Patch {
        u: Arg,
        v: Arg,
        colors: Vec<Arg>,
    },
    Normalize {
        fields: Vec<Arg>,
        floor: f64,
    },
    Stack(Vec<Arg>),
    Invert(Arg),
    Multiply(Vec<Arg>),
    Screen(Vec<Arg>),
    /// Any other node: the text before each argument, and after the last.
    Other(Vec<String>, Vec<Arg>),
}

/// Generated document.
pub(crate) struct Drawn {
    pub(crate) nodes: Vec<(Op, Kind)>,
    pub(crate) disabled: Vec<bool>,
    /// The node of each output.
    pub(crate) outputs: Vec<usize>,
    pub(crate) text: String,
    pub(crate) depth: usize,
}

pub(super) struct Drawing<'r, R> {
    pub(super) random: &'r mut R,
    nodes: Vec<(Op, Kind)>,
    /// The colors that literals are taken from.
    palette: Vec<[f32; 3]>,
    /// Probability of choosing the latest node, so that some graphs grow wide and some deep.
    latest: f64,
}

/// What a document is drawn from.
pub(super) struct Style<'s, R> {
    pub(super) inputs: &'s [Input],
    /// Numbers of nodes, of which one is chosen.
    pub(super) counts: &'s [usize],
    /// Draws a node.
    pub(super) node: fn(&mut Drawing<'_, R>) -> (Op, Kind),
    /// Members of the format beside its size.
    pub(super) format: &'s str,
    /// Members of each output beside its node.
    pub(super) output: &'s str,
    /// Kinds of outputs beside the last node's, which is a color.
    pub(super) outputs: &'s [Kind],
}

impl Drawn {
    /// Draws back-end nodes, all of which [`bound`](super::bound) evaluates.
    pub(crate) fn draw<R: Rng>(random: &mut R, file: &str) -> Self {
        let style = Style {
            inputs: &INPUTS,
            counts: &[4, 12, 40, 150],
            node: |drawing| drawing.node(),
            format: "",
            output: "",
            outputs: &[Kind::Mask, Kind::Weights(0)],
        };
        Self::in_style(random, file, &style)
    }

    pub(super) fn in_style<R: Rng>(random: &mut R, file: &str, style: &Style<'_, R>) -> Self {
        let hostile = random.random_bool(0.5);
        let palette = (0..random.random_range(1..6))
            .map(|_| {
                let tame: [f32; 3] = std::array::from_fn(|_| random.random_range(0..=64) as f32 / 64.0);
                if hostile { std::array::from_fn(|_| pick(&COLORS, random)) } else { tame }
            })
            .collect();
        let count = style.counts.choose(random).copied().unwrap_or(4);
        let latest = [0.3, 0.75, 0.95].choose(random).copied().unwrap_or(0.5);
        let mut drawing = Drawing { random, nodes: Vec::new(), palette, latest };
        for &(name, kind, channels) in style.inputs {
            let kind = match (kind, channels) {
                ("field", _) => Kind::Field,
                ("weights", 1 | 2) => Kind::Mask,
                ("weights", n) => Kind::Weights(n),
                _ => Kind::Color,
            };
            drawing.nodes.push((Op::Input(name), kind));
        }
        for _ in 0..count {
            let drawn = (style.node)(&mut drawing);
            drawing.nodes.push(drawn);
            if drawing.random.random_bool(0.08)
                && let Some(twin) = drawing.nodes.last().cloned()
            {
                drawing.nodes.push(twin);
            }
        }
        let (a, b, t) = (drawing.color(), drawing.color(), drawing.mask());
        drawing.nodes.push((Op::Mix { a, b, t }, Kind::Color));
        let outputs = drawing.outputs(style.outputs);
        let Drawing { random, nodes, .. } = drawing;
        let disabled: Vec<bool> = nodes
            .iter()
            .map(|(op, _)| {
                // A disabled node passes its first input through, if it is of the same kind.
                matches!(op, Op::Mix { a: Arg::Node(_), .. } | Op::Invert(Arg::Node(_))) && random.random_bool(0.06)
            })
            .collect();
        let format = format!(r#""width": {WIDTH}, "height": {HEIGHT}{}"#, style.format);
        let text = super::text::text(&nodes, &disabled, &outputs, [&format, style.output, file], random);
        let mut depth = vec![0; nodes.len()];
        for (index, (op, _)) in nodes.iter().enumerate() {
            depth[index] = 1 + op.args().iter().filter_map(node).map(|node| depth[node]).max().unwrap_or(0);
        }
        let depth = outputs.iter().map(|&output| depth[output]).max().unwrap_or(0);
        Self { nodes, disabled, outputs, text, depth }
    }
}

/// Returns the node that an argument names.
pub(crate) fn node(arg: &Arg) -> Option<usize> {
    if let Arg::Node(node) = arg { Some(*node) } else { None }
}

impl Op {
    /// Returns everything at its ports.
    pub(crate) fn args(&self) -> Vec<Arg> {
        match self {
            Self::Input(_) => Vec::new(),
            Self::Mix { a, b, t } => vec![*a, *b, *t],
            Self::Blend { colors, weights } => {
                colors.iter().copied().chain(weights.as_ref().err().map(|node| Arg::Node(*node))).collect()
            }
            Self::Clamp { x, .. } | Self::Bands { x, .. } | Self::Invert(x) => vec![*x],
            Self::Ramp { t, stops, .. } => [*t].into_iter().chain(stops.iter().map(|stop| stop.1)).collect(),
            Self::Patch { u, v, colors } => [*u, *v].into_iter().chain(colors.iter().copied()).collect(),
            Self::Normalize { fields: args, .. }
            | Self::Stack(args)
            | Self::Multiply(args)
            | Self::Screen(args)
            | Self::Other(_, args) => args.clone(),
        }
    }
}

impl<R: Rng> Drawing<'_, R> {
    /// Draws up to three outputs: the last node and others.
    fn outputs(&mut self, kinds: &[Kind]) -> Vec<usize> {
        let mut outputs = vec![self.nodes.len() - 1];
        for &kind in kinds {
            let fits =
                |found: Kind| found == kind || (matches!(kind, Kind::Weights(_)) && matches!(found, Kind::Weights(_)));
            let all: Vec<usize> = (0..self.nodes.len()).filter(|&node| fits(self.nodes[node].1)).collect();
            outputs.extend(all.choose(self.random).filter(|_| self.random.random_bool(0.5)));
        }
        outputs
    }

    /// Draws a node of a kind, preferably the latest.
    pub(super) fn find(&mut self, fits: impl Fn(Kind) -> bool) -> Option<usize> {
        let all: Vec<usize> = (0..self.nodes.len()).filter(|&node| fits(self.nodes[node].1)).collect();
        let latest = &all[all.len().saturating_sub(1)..];
        let from = if self.random.random_bool(self.latest) { latest } else { &all[..] };
        from.choose(self.random).copied()
    }

    pub(super) fn kind(&self, node: usize) -> Kind {
        self.nodes[node].1
    }

    pub(super) fn color(&mut self) -> Arg {
        let literal = self.palette.choose(self.random).copied().unwrap_or_default();
        match self.find(|kind| kind == Kind::Color) {
            Some(node) if self.random.random_bool(0.7) => Arg::Node(node),
            _ => Arg::Color(literal),
        }
    }

    pub(super) fn colors(&mut self, count: usize) -> Vec<Arg> {
        (0..count).map(|_| self.color()).collect()
    }

    pub(super) fn mask(&mut self) -> Arg {
        let literals = [0.0, 1.0, 0.5, 0.25, 0.625, 2f64.powi(-24), 2f64.powi(-149), 0.5 - 2f64.powi(-25)];
        let literal = literals.choose(self.random).copied().unwrap_or(0.5);
        match self.find(|kind| kind == Kind::Mask) {
            Some(node) if self.random.random_bool(0.7) => Arg::Node(node),
            _ => Arg::Number(literal),
        }
    }

    fn masks(&mut self) -> Vec<Arg> {
        (0..self.random.random_range(2..5)).map(|_| self.mask()).collect()
    }

    pub(super) fn scalar(&mut self) -> Arg {
        match self.find(|kind| kind == Kind::Field) {
            Some(node) if self.random.random_bool(0.6) => Arg::Node(node),
            _ => self.mask(),
        }
    }

    /// Draws a bound of a Clamp or a threshold of Bands: finite, and often exactly the value of a pixel.
    fn place(&mut self) -> f64 {
        let tame = f64::from(self.random.random_range(-64..=128)) / 64.0;
        let exact = pick(&FIELDS, self.random);
        if exact.is_finite() && self.random.random_bool(0.4) { f64::from(exact) } else { tame }
    }

    fn places(&mut self, count: usize) -> Vec<f64> {
        let mut places: Vec<f64> = (0..count).map(|_| self.place()).collect();
        places.sort_by(f64::total_cmp);
        places
    }

    pub(super) fn node(&mut self) -> (Op, Kind) {
        match self.random.random_range(0..16) {
            0..4 => (Op::Mix { a: self.color(), b: self.color(), t: self.mask() }, Kind::Color),
            4 | 5 => (self.blend(), Kind::Color),
            6 | 7 => {
                let places = self.places(2);
                let power = [1.0, 1.0, 2.0, 2.5, 16.0, 17.0].choose(self.random).copied().unwrap_or(1.0);
                let (x, smooth) = (self.scalar(), self.random.random_bool(0.4));
                (Op::Clamp { x, min: places[0], max: places[1], smooth, power }, Kind::Mask)
            }
            8 => {
                let mut places: Vec<i32> =
                    (0..self.random.random_range(1..6)).map(|_| self.random.random_range(0..=8)).collect();
                places.sort_unstable();
                let stops = places.into_iter().map(|at| (f64::from(at) / 8.0, self.color())).collect();
                let interpolation = ["linear", "smooth", "step"].choose(self.random).copied().unwrap_or("linear");
                (Op::Ramp { t: self.mask(), stops, interpolation }, Kind::Color)
            }
            9 => {
                let count = self.random.random_range(1..4);
                let width = [0.0, 0.0, 0.5, 0.25, 2.0].choose(self.random).copied().unwrap_or(0.0);
                // Both ends of a soft edge must be exact in f32.
                let thresholds = if width == 0.0 {
                    self.places(count)
                } else {
                    let mut tame: Vec<i32> = (0..count).map(|_| self.random.random_range(-64..=128)).collect();
                    tame.sort_unstable();
                    tame.into_iter().map(|place| f64::from(place) / 64.0).collect()
                };
                let kind = if count == 1 { Kind::Mask } else { Kind::Weights(count + 1) };
                (Op::Bands { x: self.scalar(), thresholds, width }, kind)
            }
            10 => {
                let count = [4, 4, 16].choose(self.random).copied().unwrap_or(4);
                (Op::Patch { u: self.mask(), v: self.mask(), colors: self.colors(count) }, Kind::Color)
            }
            11 => {
                let count = self.random.random_range(1..4);
                let fields = (0..count).map(|_| self.scalar()).collect();
                let floor = [1.0, 0.125, 2f64.powi(-10)].choose(self.random).copied().unwrap_or(1.0);
                (Op::Normalize { fields, floor }, if count == 1 { Kind::Mask } else { Kind::Weights(count + 1) })
            }
            12 => {
                let masks: Vec<Arg> = (0..self.random.random_range(1..4)).map(|_| self.mask()).collect();
                let kind = if masks.len() == 1 { Kind::Mask } else { Kind::Weights(masks.len() + 1) };
                (Op::Stack(masks), kind)
            }
            13 => (Op::Invert(self.mask()), Kind::Mask),
            14 => (Op::Multiply(self.masks()), Kind::Mask),
            _ => (Op::Screen(self.masks()), Kind::Mask),
        }
    }

    fn blend(&mut self) -> Op {
        let weights = self.find(|kind| matches!(kind, Kind::Weights(_) | Kind::Mask));
        if let Some(node) = weights.filter(|_| self.random.random_bool(0.8)) {
            let ways = if let Kind::Weights(n) = self.nodes[node].1 { n } else { 2 };
            return Op::Blend { colors: self.colors(ways), weights: Err(node) };
        }
        let ways = self.random.random_range(2..6);
        let mut left = 64;
        let mut weights: Vec<f64> = (1..ways)
            .map(|_| {
                let part = self.random.random_range(0..=left);
                left -= part;
                f64::from(part) / 64.0
            })
            .collect();
        weights.push(f64::from(left) / 64.0);
        Op::Blend { colors: self.colors(ways), weights: Ok(weights) }
    }
}
