//! Every stage's bounds, held against its reference: inputs are drawn, hostile ones and smooth ones, and so are bounds on
//! them; the reference is asked with what lies anywhere within.

use crate::testing::{Frame, graph};
use std::collections::HashMap;
use std::path::Path;
use trochoid_graph::*;
use trochoid_image::{Format, Window};

/// A node "out" to be held.
struct Case {
    /// Of the document's output.
    key: &'static str,
    nodes: &'static str,
    /// What the median of bounds over errors may be on smooth inputs; `None` where all is in doubt.
    tight: Option<f64>,
}

/// The scene of all cases.
const SCENE: &str = r#""c": { "type": "Camera", "position": [0, 5, 10], "target": [0, 0, 0] },
    "s": { "type": "GerstnerSea", "count": 0 }, "s2": { "type": "GerstnerSea", "count": 0, "level": -1 },
    "v": { "type": "Render", "camera": "c", "surfaces": ["s", "s2"] },
    "w": { "type": "Render", "camera": "c", "surfaces": ["s2"] },
    "sun": { "type": "Light", "direction": [0.3, 0.6, 0.4] },
    "lamp": { "type": "Light", "kind": "point", "position": [1, 4, 2] },
    "spot": { "type": "Light", "kind": "spot", "position": [2, 6, 3], "target": [0, 0, 0], "angle": 40, "soft": 30 },
    "hard": { "type": "Light", "kind": "spot", "position": [2, 6, 3], "target": [0, 0, 0], "angle": 30, "soft": 0 },
    "field": { "type": "FieldMath", "expression": "0" }, "field2": { "type": "FieldMath", "expression": "1" },
    "mask": { "type": "ScreenX" }, "mask2": { "type": "ScreenY" },"#;

/// Numbers of a generator: Marsaglia's xorshift.
struct Draws(u64);

impl Draws {
    fn next(&mut self) -> u64 {
        self.0 ^= self.0 << 13;
        self.0 ^= self.0 >> 7;
        self.0 ^= self.0 << 17;
        self.0
    }

    /// From 0 to 1.
    fn unit(&mut self) -> f64 {
        (self.next() >> 11) as f64 / (1u64 << 53) as f64
    }

    /// From −1 to 1.
    fn signed(&mut self) -> f64 {
        2.0 * self.unit() - 1.0
    }

    fn one_of<T: Copy>(&mut self, from: &[T]) -> T {
        from[(self.next() % from.len() as u64) as usize]
    }

    fn chance(&mut self, of: f64) -> bool {
        self.unit() < of
    }

    fn direction(&mut self) -> [f64; 3] {
        let v = [0; 3].map(|_| self.signed());
        let length = v.iter().map(|v| v * v).sum::<f64>().sqrt().max(1e-3);
        v.map(|v| v / length)
    }
}

/// What one channel is at one sample: what the stage is given, within what, and what the reference is given.
#[derive(Clone, Copy)]
struct Drawn {
    value: f32,
    bound: Bound,
}

impl Drawn {
    fn exactly(value: f64) -> Self {
        Self { value: value as f32, bound: Bound::EXACT }
    }

    /// Anything within the bound; where that has no end, something else of the same kind.
    fn truth(self, draws: &mut Draws, other: f64) -> f64 {
        let value = f64::from(self.value);
        // As it stands in planes.
        let size = Bound::decode(self.bound.encode()).size;
        match size {
            0.0 => value,
            size if size.is_finite() => {
                value + size / (1.0 + 1e-6) * if draws.chance(0.3) { draws.one_of(&[-1.0, 1.0]) } else { draws.signed() }
            }
            _ => other,
        }
    }
}

/// One connection over its window.
struct Given {
    kind: Kind,
    window: Window,
    /// By channel.
    drawn: Vec<Vec<Drawn>>,
    truths: Vec<Vec<f64>>,
}

/// Ranges within which the truth lies whatever the bound.
fn legal(kind: Kind, channel: usize) -> (f64, f64) {
    match (kind, ViewChannel::ALL.get(channel)) {
        (Kind::Weights(_), _) => (0.0, 1.0),
        (Kind::Color, _) => (0.0, f64::MAX),
        (Kind::View, Some(ViewChannel::Coverage)) => (0.0, 1.0),
        (Kind::View, Some(ViewChannel::Depth | ViewChannel::SlopeVariance)) => (0.0, f64::INFINITY),
        _ => (f64::NEG_INFINITY, f64::INFINITY),
    }
}

/// How inputs are drawn.
#[derive(Clone, Copy, PartialEq)]
enum How {
    Hostile,
    Smooth,
}

impl Given {
    fn new(draws: &mut Draws, how: How, kind: Kind, window: Window) -> Self {
        let mut drawn: Vec<Vec<Drawn>> = vec![Vec::new(); kind.channels()];
        let slope: Vec<[f64; 3]> = drawn.iter().map(|_| [0; 3].map(|_| draws.signed())).collect();
        let size = draws.one_of(&[1e-6, 1e-5, 1e-4]);
        for place in Block::of(window, [0.5; 2]).places() {
            let sample = match how {
                How::Smooth => smooth(draws, kind, place, &slope, size),
                How::Hostile => hostile(draws, kind),
            };
            drawn.iter_mut().zip(sample).for_each(|(plane, drawn)| plane.push(drawn));
        }
        let mut given = Self { kind, window, drawn, truths: Vec::new() };
        given.redraw(draws);
        given
    }

    /// Draws other truths.
    fn redraw(&mut self, draws: &mut Draws) {
        self.truths = vec![vec![0.0; self.window.area()]; self.drawn.len()];
        for sample in 0..self.window.area() {
            let other = hostile(draws, self.kind);
            for (channel, plane) in self.drawn.iter().enumerate() {
                let (low, high) = legal(self.kind, channel);
                let truth = plane[sample].truth(draws, f64::from(other[channel].value)).clamp(low, high);
                let is_whole = self.kind == Kind::View
                    && [ViewChannel::Coverage, ViewChannel::Surface].contains(&ViewChannel::ALL[channel]);
                self.truths[channel][sample] = if is_whole { truth.round() } else { truth };
            }
        }
    }

    fn planes(&self, of: impl Fn(&Drawn) -> f32) -> Vec<Vec<f32>> {
        self.drawn.iter().map(|plane| plane.iter().map(&of).collect()).collect()
    }

    /// What the reference is given at a place.
    fn reference(&self, at: [f64; 2]) -> Reference {
        let x = (at[0].floor() as i64).clamp(self.window.x0, self.window.x1 - 1) - self.window.x0;
        let y = (at[1].floor() as i64).clamp(self.window.y0, self.window.y1 - 1) - self.window.y0;
        let sample = y as usize * self.window.width() + x as usize;
        let numbers: Vec<f64> = self.truths.iter().map(|plane| plane[sample]).collect();
        match self.kind {
            Kind::View => Reference::View(numbers),
            Kind::Color => Reference::Color([numbers[0], numbers[1], numbers[2]]),
            Kind::MASK => Reference::Mask(numbers[0]),
            Kind::Weights(_) => Reference::Weights(numbers),
            _ => Reference::Field(numbers),
        }
    }
}

/// A sample of a connection of which everything varies slowly, within small bounds.
fn smooth(draws: &mut Draws, kind: Kind, [x, y]: [f64; 2], slope: &[[f64; 3]], size: f64) -> Vec<Drawn> {
    let ripple = |channel: usize| {
        let [a, b, c] = slope[channel];
        c + 0.05 * (a * x + b * y) + 0.01 * libm::sin(x * a + y * b)
    };
    let spot = |channel: usize| libm::sin(3.0 * ripple(channel) + 0.7 * x + 1.1 * y);
    let drawn = |draws: &mut Draws, value: f64| Drawn {
        value: value as f32,
        bound: Bound::of(size * (0.5 + 0.5 * draws.unit()) * value.abs().max(0.1)),
    };
    if kind != Kind::View {
        return (0..kind.channels())
            .map(|channel| {
                let value = spot(channel);
                drawn(draws, if matches!(kind, Kind::Field(_)) { value } else { 0.5 + 0.49 * value })
            })
            .collect();
    }
    let normal = [0.3 * ripple(5), 1.0, 0.3 * ripple(7)];
    let length = normal.iter().map(|v| v * v).sum::<f64>().sqrt();
    let channel = |(index, channel): (usize, &ViewChannel)| {
        let value = match channel {
            ViewChannel::Coverage => return Drawn::exactly(1.0),
            ViewChannel::Surface => return Drawn::exactly(0.0),
            ViewChannel::Depth => 10.0 + ripple(index),
            ViewChannel::NormalX => normal[0] / length,
            ViewChannel::NormalY => normal[1] / length,
            ViewChannel::NormalZ => normal[2] / length,
            ViewChannel::PositionX | ViewChannel::RestX | ViewChannel::U => 0.3 * x + ripple(index),
            ViewChannel::PositionZ | ViewChannel::RestZ | ViewChannel::V => 0.3 * y + ripple(index),
            ViewChannel::SlopeVariance => 0.002 * (1.5 + spot(index)),
            ViewChannel::Jacobian => 0.4 + 0.3 * spot(index),
            ViewChannel::DriftWeight => 0.6 + 0.1 * spot(index),
            // A line every few pixels, in good agreement.
            ViewChannel::AlongCos | ViewChannel::AcrossCos => 0.59 * libm::cos(0.05 * x + ripple(20)),
            ViewChannel::AlongSin | ViewChannel::AcrossSin => 0.59 * libm::sin(0.05 * x + ripple(20)),
            _ => spot(index),
        };
        drawn(draws, value)
    };
    ViewChannel::ALL.iter().enumerate().map(channel).collect()
}

/// A sample of a connection as bad as its kind allows.
fn hostile(draws: &mut Draws, kind: Kind) -> Vec<Drawn> {
    let scale = draws.one_of(&[0.0, 1e-9, 1e-6, 1e-4, 1e-2, 0.3]);
    let doubt = draws.chance(0.15);
    let drawn = |draws: &mut Draws, value: f64| {
        let size = match () {
            () if doubt && draws.chance(0.3) => f64::INFINITY,
            () if draws.chance(0.2) => 0.0,
            () => scale * value.abs().max(draws.one_of(&[1e-3, 1.0])) * draws.unit(),
        };
        let size = if value.is_finite() || size.is_infinite() { size } else { 0.0 };
        Drawn { value: value as f32, bound: Bound::of(size).with(!doubt) }
    };
    let number = |draws: &mut Draws| match draws.next() % 12 {
        0 => 0.0,
        1 => 1e6 * draws.signed(),
        2 => 1e-6 * draws.signed(),
        3 => draws.one_of(&[1e30, -1e30, 1.0, -1.0, 0.5]),
        _ => 3.0 * draws.signed(),
    };
    if kind != Kind::View {
        return (0..kind.channels())
            .map(|_| {
                let value = match kind {
                    Kind::Weights(_) if draws.chance(0.3) => draws.one_of(&[0.0, 1.0]),
                    Kind::Weights(_) => draws.unit(),
                    Kind::Color => draws.one_of(&[0.0, 0.5, 3.0, 1e4]) * draws.unit(),
                    _ if draws.chance(0.03) => draws.one_of(&[f64::INFINITY, f64::NEG_INFINITY]),
                    _ => number(draws),
                };
                drawn(draws, value)
            })
            .collect();
    }
    let covered = !draws.chance(0.15);
    let normal = match draws.next() % 8 {
        0 => [0.0; 3],
        1 => draws.one_of(&[[0.0, 1.0, 0.0], [0.0, -1.0, 0.0], [1.0, 0.0, 0.0], [0.3, 0.6, 0.4]]),
        2 => draws.direction().map(|v| v * 1e-18),
        3 => draws.direction().map(|v| v * 40.0),
        _ => draws.direction(),
    };
    let position = match draws.next() % 8 {
        0 => draws.one_of(&[[1.0, 4.0, 2.0], [2.0, 6.0, 3.0], [0.0, 5.0, 10.0]]),
        1 => draws.direction().map(|v| v * 1e6),
        _ => [0; 3].map(|_| 5.0 * draws.signed()),
    };
    let channel = |channel: &ViewChannel| {
        let value = match channel {
            ViewChannel::Coverage if doubt => {
                return Drawn { value: f32::from(u8::from(covered)), bound: Bound::of(1.0).with(false) };
            }
            ViewChannel::Coverage => return Drawn::exactly(f64::from(u8::from(covered))),
            _ if !covered && !doubt => return Drawn::exactly(f64::from(channel.background())),
            ViewChannel::Surface => {
                let value = draws.one_of(&[0.0, 0.0, 1.0, 2.0]);
                let bound = if doubt { Bound::of(draws.one_of(&[0.0, 1.0, 64.0])).with(false) } else { Bound::EXACT };
                return Drawn { value: value as f32, bound };
            }
            ViewChannel::Depth if draws.chance(0.1) => f64::INFINITY,
            ViewChannel::Depth => draws.one_of(&[1e-3, 1.0, 10.0, 1e5]) * draws.unit(),
            ViewChannel::NormalX => normal[0],
            ViewChannel::NormalY => normal[1],
            ViewChannel::NormalZ => normal[2],
            ViewChannel::PositionX => position[0],
            ViewChannel::PositionY => position[1],
            ViewChannel::PositionZ => position[2],
            ViewChannel::SlopeVariance => draws.one_of(&[0.0, 1e-6, 0.1, 1e6]) * draws.unit(),
            ViewChannel::DriftWeight => draws.one_of(&[0.0, 1e-4, 1.0]) * draws.unit(),
            _ => number(draws),
        };
        drawn(draws, value)
    };
    ViewChannel::ALL.iter().map(channel).collect()
}

/// What holding a case has found.
#[derive(Default)]
struct Found {
    /// Errors beyond their bounds.
    faults: Vec<String>,
    /// Bounds over errors, where there is an error and no doubt.
    ratios: Vec<f64>,
    /// Clear bounds.
    clear: usize,
    /// Bounds without end.
    endless: usize,
    all: usize,
}

impl Found {
    fn median(&mut self) -> f64 {
        self.ratios.sort_by(f64::total_cmp);
        self.ratios.get(self.ratios.len() / 2).copied().unwrap_or(0.0)
    }
}

/// Holds a node on inputs drawn from a seed; bounds are made `tighter` before.
fn hold(frame: &Frame, how: How, seed: u64, tighter: f64) -> Found {
    let mut draws = Draws(seed.wrapping_mul(0x9e37_79b9_7f4a_7c15) | 1);
    let id = frame.graph.find("out").unwrap();
    let (node, prepared) = (frame.graph.settle(id, frame.context.frame), frame.prepared[id.0].as_ref().unwrap());
    let Body::Stage(stage) = frame.graph.node(id).ty.body() else { panic!("not a stage") };
    let picture = frame.context.format.window();
    let mut given: HashMap<(NodeId, usize), Given> = HashMap::new();
    let mut ports: Vec<(&'static str, Vec<(NodeId, usize)>)> = Vec::new();
    for (port, _) in frame.graph.node(id).record.ports() {
        let mut sources = Vec::new();
        for source in node.all(port) {
            let Source::Output { node: from, output } = source else { panic!("connect {port} to a node") };
            let kind = frame.graph.node(*from).kinds[*output];
            let window = stage.regions_of_interest(&node, port, picture, frame.context.format).intersect(picture);
            let new = Given::new(&mut draws, how, kind, window);
            assert!(given.insert((*from, *output), new).is_none() || kind.channels() == 0, "two ports share a source");
            sources.push((*from, *output));
        }
        ports.push((port, sources));
    }
    let block = Block::of(picture, [draws.unit(), draws.unit()]);
    let planes = |bounds: bool| -> HashMap<(NodeId, usize), Vec<Vec<f32>>> {
        let of = |given: &Given| given.planes(|drawn| if bounds { drawn.bound.encode() } else { drawn.value });
        given.iter().map(|(source, given)| (*source, of(given))).collect()
    };
    let (values, bounds) = (planes(false), planes(true));
    fn connect<'a>(
        ports: &[(&'static str, Vec<(NodeId, usize)>)],
        planes: &'a HashMap<(NodeId, usize), Vec<Vec<f32>>>,
        window: Window,
    ) -> Vec<(&'static str, Vec<Connection<'a>>)> {
        let connection = |source: &(NodeId, usize)| Connection {
            planes: planes[source].iter().map(|plane| Some(&plane[..])).collect(),
            window,
            extent: window,
        };
        ports.iter().map(|(port, sources)| (*port, sources.iter().map(connection).collect())).collect()
    }
    let (values, bounds) = (connect(&ports, &values, picture), connect(&ports, &bounds, picture));
    let (inputs, limits) = (Inputs::new(&values), Inputs::new(&bounds));
    let kinds = &frame.graph.node(id).kinds;
    let memory = || -> Vec<Vec<Vec<f32>>> {
        kinds.iter().map(|kind| vec![vec![f32::NAN; picture.area()]; kind.channels()]).collect()
    };
    fn lend(memory: &mut [Vec<Vec<f32>>]) -> Outputs<'_> {
        Outputs::new(
            memory.iter_mut().map(|planes| planes.iter_mut().map(|plane| Some(&mut plane[..])).collect()).collect(),
        )
    }
    let (mut filled, mut certain) = (memory(), memory());
    prepared.fill(&block, &inputs, &mut lend(&mut filled)).unwrap();
    let lent: Vec<Vec<Option<&[f32]>>> =
        filled.iter().map(|planes| planes.iter().map(|plane| Some(&plane[..])).collect()).collect();
    let bounding = Bounding { block: &block, inputs: &inputs, bounds: &limits, filled: &lent };
    prepared.bound(&bounding, &mut lend(&mut certain)).unwrap();

    let mut found = Found::default();
    let mut errors: HashMap<(usize, usize, usize), f64> = HashMap::new();
    for _ in 0..6 {
        for (sample, at) in block.places().enumerate() {
            let upstream = |source: &Source<Vec<f64>>, at: [f64; 2]| {
                let Source::Output { node, output } = source else { unreachable!("literals stand for themselves") };
                given[&(*node, *output)].reference(at)
            };
            let outputs = prepared.reference(&References::new(&frame.context, at, &upstream)).unwrap();
            for (output, value) in outputs.into_iter().enumerate() {
                let numbers = match value {
                    Reference::Color(color) => color.to_vec(),
                    Reference::Mask(t) => vec![t],
                    Reference::Weights(values) | Reference::Field(values) | Reference::View(values) => values,
                    Reference::Handle(_) => Vec::new(),
                };
                for (channel, truth) in numbers.into_iter().enumerate() {
                    let value = f64::from(filled[output][channel][sample]);
                    let bound = Bound::decode(certain[output][channel][sample]);
                    let error = if value == truth { 0.0 } else { (value - truth).abs() };
                    if error.is_nan() || error > bound.size / tighter {
                        found.faults.push(format!(
                            "output {output}, channel {channel}, sample {sample} of seed {seed}: {value}, the reference \
                             says {truth}: {error:e} beyond {bound:?}"
                        ));
                    }
                    let most = errors.entry((output, channel, sample)).or_default();
                    *most = most.max(error);
                }
            }
        }
        given.values_mut().for_each(|given| given.redraw(&mut draws));
    }
    for ((output, channel, sample), error) in errors {
        let bound = Bound::decode(certain[output][channel][sample]);
        found.all += 1;
        found.clear += usize::from(bound.clear);
        found.endless += usize::from(bound.size.is_infinite());
        // What is smooth jumps nowhere, so what is certain up to little is off by little.
        if how == How::Smooth && bound.clear && bound.size > 0.2 {
            found.faults.push(format!("{bound:?} for sure, where inputs are certain, at sample {sample} of seed {seed}"));
        }
        if error > 0.0 && bound.clear && bound.size.is_finite() {
            found.ratios.push(bound.size / error);
        }
    }
    found
}

fn frame(case: &Case) -> Frame {
    let graph = graph(case.key, &format!("{SCENE} {}", case.nodes), Path::new(".")).unwrap();
    Frame::new(graph.with_format(Format::new(16, 9, 1).unwrap())).unwrap()
}

fn hold_all(cases: &[Case]) {
    for case in cases {
        let frame = frame(case);
        let (mut endless, mut all) = (0, 0);
        for seed in 1..=60 {
            let found = hold(&frame, How::Hostile, seed, 1.0);
            assert!(found.faults.is_empty(), "{}: {:#?}", case.nodes, &found.faults[..found.faults.len().min(5)]);
            (endless, all) = (endless + found.endless, all + found.all);
        }
        let mut together = Found::default();
        for seed in 1..=20 {
            let found = hold(&frame, How::Smooth, seed, 1.0);
            assert!(found.faults.is_empty(), "{}: {:#?}", case.nodes, &found.faults[..found.faults.len().min(5)]);
            together.ratios.extend(found.ratios);
            together.clear += found.clear;
            together.all += found.all;
        }
        let median = together.median();
        println!(
            "{}: median {median:.2} of {}, clear {:.3}, endless {:.3} where hostile",
            case.nodes,
            together.ratios.len(),
            together.clear as f64 / together.all as f64,
            endless as f64 / all as f64
        );
        if let Some(most) = case.tight {
            assert!(median <= most && together.ratios.len() > 100, "{}: {median} of {}", case.nodes, together.ratios.len());
            assert!(2 * together.clear > together.all, "{}: most is in doubt", case.nodes);
        }
    }
}

const LIT: &[Case] = &[
    Case { key: "weights", nodes: r#""out": { "type": "ObjectMask", "view": "v", "indices": [1] }"#, tight: None },
    Case { key: "weights", nodes: r#""out": { "type": "NonSpecular", "view": "v", "lights": ["sun"] }"#, tight: Some(10.0) },
    Case {
        key: "weights",
        nodes: r#""out": { "type": "NonSpecular", "view": "v", "power": 0.3, "lights": ["lamp", "spot", "hard"] }"#,
        tight: Some(10.0),
    },
    Case {
        key: "weights",
        nodes: r#""out": { "type": "NonSpecular", "view": "v", "power": 3.5, "lights": ["sun", "spot"], "combine": "mean" }"#,
        tight: Some(10.0),
    },
    Case { key: "weights", nodes: r#""out": { "type": "Specular", "view": "v", "lights": ["sun"] }"#, tight: Some(10.0) },
    Case {
        key: "weights",
        nodes: r#""out": { "type": "Specular", "view": "v", "shininess": 5000, "lights": ["lamp", "spot"] }"#,
        tight: Some(10.0),
    },
    Case {
        key: "weights",
        nodes: r#""out": { "type": "Specular", "view": "v", "model": "reflection", "lights": ["sun", "lamp"], "combine": "max" }"#,
        tight: Some(10.0),
    },
    Case {
        key: "weights",
        nodes: r#""out": { "type": "Specular", "view": "v", "shininess": 0, "lights": ["sun"] }"#,
        tight: None,
    },
    Case { key: "weights", nodes: r#""out": { "type": "Fresnel", "view": "v" }"#, tight: Some(10.0) },
    Case {
        key: "weights",
        nodes: r#""out": { "type": "Fresnel", "view": "v", "lights": ["lamp", "sun"], "cosine": "half", "eta": 3 }"#,
        tight: Some(10.0),
    },
    Case { key: "weights", nodes: r#""out": { "type": "FoldFoam", "view": "v" }"#, tight: Some(10.0) },
    Case { key: "weights", nodes: r#""out": { "type": "FoldFoam", "view": "v", "width": 0 }"#, tight: None },
    Case {
        key: "weights",
        nodes: r#""out": { "type": "CrestFoam", "view": "v", "height": -0.5, "rise": 1 }"#,
        tight: Some(10.0),
    },
    Case { key: "weights", nodes: r#""out": { "type": "CrestFoam", "view": "v", "softness": 0 }"#, tight: None },
];

const PATTERNS: &[Case] = &[
    Case { key: "field", nodes: r#""out": { "type": "Noise", "scale": 0.4, "evolution": 0.3 }"#, tight: Some(10.0) },
    Case { key: "field", nodes: r#""out": { "type": "Noise", "view": "v", "space": "world" }"#, tight: Some(10.0) },
    Case {
        key: "field",
        nodes: r#""out": { "type": "Noise", "view": "v", "space": "world", "kind": "ridged", "evolution": 2.5 }"#,
        tight: Some(10.0),
    },
    Case {
        key: "field",
        nodes: r#""out": { "type": "Noise", "view": "v", "space": "rest", "kind": "cellular", "offset": [1e5, 0, -20] }"#,
        tight: Some(10.0),
    },
    Case {
        key: "field",
        nodes: r#""out": { "type": "Noise", "view": "v", "space": "rest", "kind": "edges", "filter": false }"#,
        tight: Some(10.0),
    },
    Case { key: "weights", nodes: r#""out": { "type": "Grain", "threads": 4 }"#, tight: Some(10.0) },
    Case { key: "weights", nodes: r#""out": { "type": "Grain", "threads": 3, "kind": "paper" }"#, tight: Some(10.0) },
    Case {
        key: "weights",
        nodes: r#""out": { "type": "Shape", "edge": 3, "shapes": [
            { "center": [0.4, 0.5], "radius": 0.3 },
            { "form": "polygon", "center": [1.1, 0.5], "angle": 20, "points": [-0.5, -0.4, 0.5, 0.4, 0.5, -0.4, -0.5, 0.4] }
        ] }"#,
        tight: Some(10.0),
    },
    Case {
        key: "weights",
        nodes: r#""out": { "type": "Scumble", "density": "mask", "noise": "field" }"#,
        tight: Some(10.0),
    },
    Case {
        key: "weights",
        nodes: r#""out": { "type": "Scumble", "density": "mask", "noise": "field", "dry": 0 }"#,
        tight: Some(10.0),
    },
    Case {
        key: "weights",
        nodes: r#""out": { "type": "Scumble", "density": "mask", "noise": "mask2", "from": 0.7, "to": 0.7 }"#,
        tight: None,
    },
    Case {
        key: "weights",
        nodes: r#""out": { "type": "LightPool", "view": "v", "noise": "field", "light": "sun", "pools": [
            { "x": 1, "z": 2, "length": 3, "width": 2, "direction": 30 }, { "x": 4, "z": 1, "length": 2, "width": 2 }
        ] }"#,
        tight: Some(10.0),
    },
    Case {
        key: "weights",
        nodes: r#""out": { "type": "LightPool", "view": "v", "noise": "field", "ragged": -1, "from": 0.3, "to": 0.3 }"#,
        tight: None,
    },
];

const VIEWS: &[Case] = &[
    Case { key: "weights", nodes: r#""out": { "type": "DriftLines", "view": "v" }"#, tight: Some(10.0) },
    Case {
        key: "weights",
        nodes: r#""out": { "type": "DriftLines", "view": "v", "coordinate": "along", "thickness": 1, "finest": 0.2, "shift": 7.3 }"#,
        tight: Some(10.0),
    },
    Case { key: "weights", nodes: r#""out": { "type": "Outline", "view": "v", "thickness": "mask" }"#, tight: None },
    Case {
        key: "weights",
        nodes: r#""out": { "type": "Outline", "view": "v", "width": 2.5, "owner": "last", "depth_step": 0.05 }"#,
        tight: None,
    },
    Case { key: "weights", nodes: r#""out": { "type": "InFront", "view": "v", "other": "w", "soft": 1 }"#, tight: Some(10.0) },
    Case { key: "weights", nodes: r#""out": { "type": "InFront", "view": "v", "other": "w", "soft": 0 }"#, tight: None },
    Case { key: "weights", nodes: r#""out": { "type": "Silhouette", "view": "v", "cutoff": 0.2, "ramp": 0.8 }"#, tight: Some(10.0) },
    Case { key: "weights", nodes: r#""out": { "type": "Silhouette", "view": "v", "width": 8 }"#, tight: None },
    Case { key: "weights", nodes: r#""out": { "type": "Sky", "view": "v", "from": -90, "to": 90 }"#, tight: Some(10.0) },
    Case {
        key: "weights",
        nodes: r#""out": { "type": "WaterlineFoam", "view": "v", "behind": "w", "edge": "field", "distance": 3 }"#,
        tight: None,
    },
    Case {
        key: "weights",
        nodes: r#""out": { "type": "WaterlineFoam", "view": "v", "behind": "w", "measure": "height", "solid": 1 }"#,
        tight: None,
    },
    Case { key: "weights", nodes: r#""out": { "type": "Shadow", "view": "v", "lights": ["sun"] }"#, tight: None },
    Case { key: "field", nodes: r#""out": { "type": "Thickness", "view": "v", "ray": "eye" }"#, tight: None },
    Case { key: "weights", nodes: r#""out": { "type": "Translucency", "view": "v", "lights": ["sun"] }"#, tight: None },
    Case {
        key: "weights",
        nodes: r#""out": { "type": "Spray", "view": "v", "bursts": [
            { "position": [0, 1, 2], "count": 400, "time": -0.7, "duration": 2 }
        ], "soft": 6 }"#,
        tight: Some(10.0),
    },
];

const IMAGES: &[Case] = &[
    Case { key: "weights", nodes: r#""out": { "type": "Blur", "image": "mask", "size": 1.5 }"#, tight: Some(10.0) },
    Case {
        key: "color",
        nodes: r#""dark": { "type": "Constant", "color": [0, 0, 0] },
            "color": { "type": "Mix", "a": "dark", "b": "dark", "weight": 0.5 },
            "out": { "type": "Blur", "image": "color", "size": 2, "size_y": 0, "filter": "box" }"#,
        tight: Some(10.0),
    },
    Case { key: "weights", nodes: r#""out": { "type": "Warp", "image": "mask", "dx": "field", "dy": "field2" }"#, tight: Some(10.0) },
    Case {
        key: "field",
        nodes: r#""image": { "type": "FieldMath", "expression": "2" },
            "out": { "type": "Warp", "image": "image", "dx": "field", "dy": "field2", "reach": 3 }"#,
        tight: Some(10.0),
    },
];

#[test]
fn what_views_show_lies_within_its_bounds() {
    hold_all(VIEWS);
}

#[test]
fn filtered_images_lie_within_their_bounds() {
    hold_all(IMAGES);
}

#[test]
fn what_light_gives_lies_within_its_bounds() {
    hold_all(LIT);
}

#[test]
fn patterns_lie_within_their_bounds() {
    hold_all(PATTERNS);
}

#[test]
fn bounds_that_are_too_small_are_found() {
    for case in [LIT, PATTERNS, VIEWS, IMAGES].into_iter().flatten().filter(|case| case.tight.is_some()) {
        let frame = frame(case);
        assert!((1..9).any(|seed| !hold(&frame, How::Smooth, seed, 20.0).faults.is_empty()), "{}", case.nodes);
    }
}
