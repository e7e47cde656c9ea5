//! MaterialX: a node graph whose inputs are the shader's, of nodes of the standard library.

use crate::Job;
use crate::glsl::is_color;
use crate::input::Parameter;
use crate::translate::{Power, Target, literal, translate};
use quick_xml::Writer;
use quick_xml::events::{BytesDecl, BytesEnd, BytesStart, BytesText, Event};
use trochoid_image::WorkingSpace;

/// Writes a document with the node graph.
pub(crate) fn write(job: &Job<'_>, space: WorkingSpace) -> String {
    let mut graph = Graph { xml: Xml(Writer::new_with_indent(Vec::new(), b' ', 2)) };
    graph.xml.put(Event::Decl(BytesDecl::new("1.0", Some("UTF-8"), None)));
    graph.xml.put(Event::Comment(BytesText::from_escaped(format!(" {} ", job.by))));
    let mut root = vec![("version", "1.39".to_owned())];
    // Encoded colors are mixed as they are: a color space would have programs convert them first.
    root.extend(color_space(space).map(|name| ("colorspace", name.to_owned())));
    graph.xml.open("materialx", &root);
    graph.xml.open("nodegraph", &[("name", format!("NG_{}", job.name)), ("doc", job.heading.join(" "))]);
    for parameter in job.inputs.parameters() {
        let mut attributes = vec![
            ("name", parameter.identifier.clone()),
            ("type", ty(parameter.is_color).into()),
            ("value", if parameter.is_color { "0, 0, 0" } else { "0" }.into()),
        ];
        if parameter.is_weight {
            attributes.extend([("uimin", "0".into()), ("uimax", "1".into())]);
        }
        attributes.push(("doc", parameter.help.clone()));
        graph.xml.element("input", &attributes);
    }
    let results = translate(job, &mut graph);
    for (i, ((name, result), root)) in job.results.iter().zip(&results).zip(&job.made.roots).enumerate() {
        let (ty, name) = (ty(is_color(job, *root)), name.as_str());
        let node = match result {
            Ref::Node(node) => node.clone(),
            // An output leads to a node.
            direct => graph.node("dot", &format!("d{root}_{i}"), ty, &[("in", ty, direct)]),
        };
        graph.xml.element("output", &[("name", name.into()), ("type", ty.into()), ("nodename", node)]);
    }
    graph.xml.close("nodegraph");
    graph.xml.close("materialx");
    graph.xml.text()
}

/// Returns the name of a working space; none for colors that are not linear light.
fn color_space(space: WorkingSpace) -> Option<&'static str> {
    match space {
        WorkingSpace::LinearSrgb => Some("lin_rec709"),
        WorkingSpace::AcesCg => Some("acescg"),
        WorkingSpace::Srgb => None,
    }
}

fn ty(is_color: bool) -> &'static str {
    if is_color { COLOR } else { FLOAT }
}

const COLOR: &str = "color3";
const FLOAT: &str = "float";

/// A writer of XML into memory.
struct Xml(Writer<Vec<u8>>);

impl Xml {
    fn put(&mut self, event: Event<'_>) {
        if self.0.write_event(event).is_err() {
            unreachable!("memory takes all that is written");
        }
    }

    fn start<'n>(name: &'n str, attributes: &[(&str, String)]) -> BytesStart<'n> {
        BytesStart::new(name).with_attributes(attributes.iter().map(|(key, value)| (*key, value.as_str())))
    }

    fn open(&mut self, name: &str, attributes: &[(&str, String)]) {
        self.put(Event::Start(Self::start(name, attributes)));
    }

    fn element(&mut self, name: &str, attributes: &[(&str, String)]) {
        self.put(Event::Empty(Self::start(name, attributes)));
    }

    fn close(&mut self, name: &str) {
        self.put(Event::End(BytesEnd::new(name)));
    }

    fn text(self) -> String {
        let mut bytes = self.0.into_inner();
        bytes.push(b'\n');
        match String::from_utf8(bytes) {
            Ok(text) => text,
            Err(_) => unreachable!("only text was written"),
        }
    }
}

/// What an input of a node refers to.
#[derive(Clone, Debug)]
enum Ref {
    /// A node of the graph.
    Node(String),
    /// An input of the graph.
    Input(String),
    /// A literal.
    Value(String),
}

struct Graph {
    xml: Xml,
}

impl Graph {
    /// Adds a node, and returns its name.
    fn node(&mut self, category: &str, name: &str, ty: &str, inputs: &[(&str, &str, &Ref)]) -> String {
        self.xml.open(category, &[("name", name.into()), ("type", ty.into())]);
        for (input, ty, from) in inputs {
            let from = match from {
                Ref::Node(node) => ("nodename", node.clone()),
                Ref::Input(input) => ("interfacename", input.clone()),
                Ref::Value(value) => ("value", value.clone()),
            };
            self.xml.element("input", &[("name", (*input).into()), ("type", (*ty).into()), from]);
        }
        self.xml.close(category);
        name.into()
    }

    /// Adds a node of numbers, and refers to it.
    fn float(&mut self, category: &str, name: &str, inputs: &[(&str, &Ref)]) -> Ref {
        let inputs: Vec<(&str, &str, &Ref)> = inputs.iter().map(|(input, from)| (*input, FLOAT, *from)).collect();
        Ref::Node(self.node(category, name, FLOAT, &inputs))
    }

    /// Adds a node of two operands.
    fn binary(&mut self, category: &str, name: &str, a: &Ref, b: &Ref) -> Ref {
        self.float(category, name, &[("in1", a), ("in2", b)])
    }

    /// Adds a node that chooses by whether a ≥ b, or a > b.
    fn choose(&mut self, category: &str, name: &str, [a, b]: [&Ref; 2], then: &Ref, other: &Ref) -> Ref {
        self.float(category, name, &[("value1", a), ("value2", b), ("in1", then), ("in2", other)])
    }

    fn clamped(&mut self, name: &str, value: &Ref, high: f32) -> Ref {
        self.float("clamp", name, &[("in", value), ("low", &number(0.0)), ("high", &number(high))])
    }

    /// Adds numbers up.
    fn sum(&mut self, name: &str, terms: &[Ref]) -> Ref {
        let mut sum = terms[0].clone();
        for (i, term) in terms.iter().enumerate().skip(1) {
            sum = self.binary("add", &format!("{name}_{i}"), &sum, term);
        }
        sum
    }
}

fn number(value: f32) -> Ref {
    Ref::Value(literal(value))
}

impl Target for Graph {
    type Ref = Ref;

    fn number(&mut self, value: f32) -> Ref {
        number(value)
    }

    fn color(&mut self, color: [f32; 3]) -> Ref {
        Ref::Value(color.map(literal).join(", "))
    }

    fn input(&mut self, parameter: &Parameter) -> Ref {
        Ref::Input(parameter.identifier.clone())
    }

    fn mask(&mut self, at: usize, parameter: &Parameter) -> Ref {
        self.clamped(&format!("t{at}"), &Ref::Input(parameter.identifier.clone()), 1.0)
    }

    fn ramp(&mut self, at: usize, x: &Ref, scale: f32, low: f32, high: f32) -> Ref {
        let scaled = match scale {
            1.0 => x.clone(),
            scale => self.binary("multiply", &format!("q{at}_0"), x, &number(scale)),
        };
        let above = self.binary("subtract", &format!("q{at}_1"), &scaled, &number(low));
        let part = self.binary("divide", &format!("q{at}_2"), &above, &number(high - low));
        self.clamped(&format!("t{at}"), &part, 1.0)
    }

    fn step(&mut self, at: usize, x: &Ref, threshold: f32) -> Ref {
        self.choose("ifgreatereq", &format!("t{at}"), [x, &number(threshold)], &number(1.0), &number(0.0))
    }

    fn smooth(&mut self, at: usize, t: &Ref) -> Ref {
        // From 0 to 1 it is t²(3 − 2t).
        let ends = [number(0.0), number(1.0)];
        self.float("smoothstep", &format!("t{at}"), &[("in", t), ("low", &ends[0]), ("high", &ends[1])])
    }

    fn power(&mut self, at: usize, t: &Ref, power: Power) -> Ref {
        let mut product: Option<Ref> = None;
        let mut square = t.clone();
        let mut two = 1;
        loop {
            if power.whole & two != 0 {
                product = Some(match product {
                    Some(product) => self.binary("multiply", &format!("q{at}_p{two}"), &product, &square),
                    None => square.clone(),
                });
            }
            if two == power.highest() {
                break;
            }
            two *= 2;
            square = self.binary("multiply", &format!("q{at}_{two}"), &square, &square);
        }
        let mut product = product.unwrap_or(square);
        let (roots, left) = power.roots();
        let mut root = t.clone();
        for depth in 1..=roots.last().copied().unwrap_or_default() {
            root = self.float("sqrt", &format!("r{at}_{depth}"), &[("in", &root)]);
            if roots.contains(&depth) {
                product = self.binary("multiply", &format!("r{at}_p{depth}"), &product, &root);
            }
        }
        if left > 0.0 {
            let rest = self.binary("power", &format!("q{at}_r"), t, &number(left));
            product = self.binary("multiply", &format!("q{at}_s"), &product, &rest);
        }
        self.binary("min", &format!("t{at}"), &product, t)
    }

    fn complement(&mut self, at: usize, t: &Ref) -> Ref {
        self.binary("subtract", &format!("t{at}"), &number(1.0), t)
    }

    fn product(&mut self, at: usize, t: &Ref, u: &Ref) -> Ref {
        self.binary("multiply", &format!("t{at}"), t, u)
    }

    fn partition(&mut self, at: usize, weights: &[Ref]) -> Vec<Ref> {
        let sum = self.sum(&format!("s{at}"), weights);
        let equal = number((1.0 / weights.len() as f64) as f32);
        let part = |(i, weight): (usize, &Ref)| {
            let part = self.binary("divide", &format!("q{at}_{i}"), weight, &sum);
            self.choose("ifgreater", &format!("w{at}_{i}"), [&sum, &number(0.0)], &part, &equal)
        };
        weights.iter().enumerate().map(part).collect()
    }

    fn normalize(&mut self, at: usize, values: &[Ref], scale: f32, floor: f32) -> Vec<Ref> {
        let shares = values.iter().enumerate();
        let shares = shares.map(|(i, value)| {
            let share = self.clamped(&format!("q{at}_{i}"), value, f32::MAX);
            if scale == 1.0 { share } else { self.binary("multiply", &format!("q{at}_{i}_s"), &share, &number(scale)) }
        });
        let shares: Vec<Ref> = shares.collect();
        let sum = self.sum(&format!("s{at}"), &shares);
        let divisor = self.binary("max", &format!("d{at}"), &sum, &number(floor));
        let rest = self.binary("subtract", &format!("r{at}"), &divisor, &sum);
        let parts = shares.iter().chain([&rest]).enumerate();
        parts.map(|(i, part)| self.binary("divide", &format!("w{at}_{i}"), part, &divisor)).collect()
    }

    fn mix(&mut self, at: usize, a: &Ref, b: &Ref, t: &Ref) -> Ref {
        let inputs = [("fg", COLOR, b), ("bg", COLOR, a), ("mix", FLOAT, t)];
        Ref::Node(self.node("mix", &format!("c{at}"), COLOR, &inputs))
    }

    fn blend(&mut self, at: usize, colors: &[Ref], weights: &[Ref]) -> Ref {
        let mut sum: Option<Ref> = None;
        for (i, (color, weight)) in colors.iter().zip(weights).enumerate() {
            let inputs = [("in1", COLOR, color), ("in2", FLOAT, weight)];
            let term = Ref::Node(self.node("multiply", &format!("q{at}_{i}"), COLOR, &inputs));
            sum = Some(match &sum {
                Some(sum) => {
                    let inputs = [("in1", COLOR, sum), ("in2", COLOR, &term)];
                    Ref::Node(self.node("add", &format!("c{at}_{i}"), COLOR, &inputs))
                }
                None => term,
            });
        }
        match sum {
            Some(sum) => sum,
            None => unreachable!("a partition has weights"),
        }
    }

    fn decode(&mut self, color: &Ref) -> Ref {
        // IEC 61966-2-1, for each channel.
        let channels = [0, 1, 2].map(|channel: usize| {
            let index = Ref::Value(channel.to_string());
            let inputs = [("in", COLOR, color), ("index", "integer", &index)];
            let x = Ref::Node(self.node("extract", &format!("e{channel}"), FLOAT, &inputs));
            let low = self.binary("divide", &format!("e{channel}_a"), &x, &number(12.92));
            let above = self.binary("add", &format!("e{channel}_b"), &x, &number(0.055));
            let part = self.binary("divide", &format!("e{channel}_c"), &above, &number(1.055));
            let high = self.binary("power", &format!("e{channel}_d"), &part, &number(2.4));
            self.choose("ifgreater", &format!("e{channel}_e"), [&x, &number(0.04045)], &high, &low)
        });
        let inputs = [0, 1, 2].map(|channel| (["in1", "in2", "in3"][channel], FLOAT, &channels[channel]));
        Ref::Node(self.node("combine3", "e3", COLOR, &inputs))
    }
}
