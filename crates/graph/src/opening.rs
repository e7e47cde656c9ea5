//! Literals that become nodes, so that buffers can be bound to them.

use crate::*;

/// Color that was a literal.
///
/// # Formula
/// C
///
/// # Edge cases
/// Unless a buffer is bound, the literal.
///
/// # Source
/// A control color, as of a Constant.
#[derive(Clone, Node)]
#[node(pointwise, end = Back, revision = 1, output(color: Kind::Color = "The color."))]
struct OpenColor {
    /// The literal.
    #[knob(color)]
    value: [f64; 3],
}

impl Node for OpenColor {}

impl Pointwise for OpenColor {
    fn lower(&self, lowering: &mut Lowering<'_>) -> Value {
        Value::Color(lowering.build.control(self.value))
    }

    fn reference(&self, _inputs: &References<'_>) -> Reference {
        Reference::Color(self.value)
    }
}

/// Weight that was a literal.
///
/// # Formula
/// t
///
/// # Edge cases
/// Unless a buffer is bound, the literal.
///
/// # Source
/// A constant mask.
#[derive(Clone, Node)]
#[node(pointwise, end = Front, revision = 1, output(mask: Kind::MASK = "The weight."))]
struct OpenMask {
    /// The literal.
    #[knob(range = 0.0..=1.0, required)]
    value: f64,
}

impl Node for OpenMask {}

impl Pointwise for OpenMask {
    fn lower(&self, lowering: &mut Lowering<'_>) -> Value {
        Value::Weights(Weights::mask(lowering.build.constant_mask(self.value)))
    }

    fn reference(&self, _inputs: &References<'_>) -> Reference {
        Reference::Mask(self.value)
    }
}

/// Number that was a literal.
///
/// # Formula
/// x
///
/// # Edge cases
/// Unless a buffer is bound, the literal.
///
/// # Source
/// A constant field.
#[derive(Clone, Node)]
#[node(pointwise, end = Front, revision = 1, output(field: Kind::Field(1) = "The number."))]
struct OpenNumber {
    /// The literal.
    #[knob(range = f64::MIN..=f64::MAX, required)]
    value: f64,
}

impl Node for OpenNumber {}

impl Pointwise for OpenNumber {
    fn lower(&self, lowering: &mut Lowering<'_>) -> Value {
        Value::Field(vec![lowering.build.constant(self.value)])
    }

    fn reference(&self, _inputs: &References<'_>) -> Reference {
        Reference::Field(vec![self.value])
    }
}

static COLOR: NodeType = NodeType::of::<OpenColor>();
static MASK: NodeType = NodeType::of::<OpenMask>();
static NUMBER: NodeType = NodeType::of::<OpenNumber>();

/// Reason that a value cannot become a node.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
#[non_exhaustive]
pub enum OpeningFault {
    /// The name has another form.
    #[error("expected palette.NAME, knobs.NAME, or NODE.PORT as in paint.a or water.stops[1].color")]
    Form,
    /// The palette has no such color.
    #[error("the palette has no color \"{name}\"{}", meant(.near))]
    NoColor {
        /// Name in the palette.
        name: String,
        /// Nearest name that it has.
        near: Option<String>,
    },
    /// The document has no such knob.
    #[error("the document has no knob \"{name}\"{}", meant(.near))]
    NoKnob {
        /// Name of the knob.
        name: String,
        /// Nearest name that it has.
        near: Option<String>,
    },
    /// A knob of the document that does more than to give ports their values.
    #[error(
        "the knob \"{name}\" is used in a formula, in a knob of a node, or not at all; only a knob that ports take as it is, as in \"weight\": \"= knobs.{name}\", can change without a new plan"
    )]
    NoPort {
        /// Name of the knob.
        name: String,
    },
    /// The document has no such node.
    #[error("the document has no node \"{name}\"{}", meant(.near))]
    NoNode {
        /// Name of the node.
        name: String,
        /// Nearest name that it has.
        near: Option<String>,
    },
    /// Another part of a node than a port with a literal color or number.
    #[error(
        "\"{item}\" of \"{node}\" is no port with a color or number of its own: only those can change without a new plan"
    )]
    NoLiteral {
        /// The node.
        node: String,
        /// Port or knob.
        item: String,
    },
}

fn meant(near: &Option<String>) -> String {
    near.as_ref().map_or_else(String::new, |near| format!(": did you mean \"{near}\"?"))
}

impl CheckedGraph {
    /// Returns the graph with a color of the palette, `palette.NAME`, a knob of the document, `knobs.NAME`, or a literal at
    /// a port, such as `paint.a` or `water.stops[1].color`, as a node of that name. A buffer can be bound to it; otherwise
    /// the pictures stay the same.
    ///
    /// # Errors
    /// There is no such literal, or the color or knob is also used where nothing can be connected: in a knob of a node, in a
    /// formula, or between keys.
    pub fn with_open(mut self, name: &str) -> Result<Self, OpeningFault> {
        if self.find(name).is_some() {
            return Ok(self);
        }
        let (first, item) = name.split_once('.').ok_or(OpeningFault::Form)?;
        let places: Vec<(NodeId, String)> = if first == "palette" {
            let Some(color) = self.palette.iter().find(|color| color.name == item) else {
                let near = nearest(item, self.palette.iter().map(|color| color.name.as_str())).map(str::to_owned);
                return Err(OpeningFault::NoColor { name: item.into(), near });
            };
            let unfit = color.uses.iter().find(|place| !place.is_whole);
            if let Some(place) = unfit {
                let node = self.node(place.node).name.clone();
                return Err(OpeningFault::NoLiteral { node, item: place.item.clone() });
            }
            color.uses.iter().map(|place| (place.node, place.item.clone())).collect()
        } else if first == "knobs" {
            let Some(knob) = self.knobs.iter().find(|knob| knob.name == item) else {
                let near = nearest(item, self.knobs.iter().map(|knob| knob.name.as_str())).map(str::to_owned);
                return Err(OpeningFault::NoKnob { name: item.into(), near });
            };
            if !knob.is_whole || knob.ports.is_empty() {
                return Err(OpeningFault::NoPort { name: item.into() });
            }
            knob.ports.clone()
        } else {
            let Some(node) = self.find(first) else {
                let near = nearest(first, self.nodes.iter().map(|node| node.name.as_str())).map(str::to_owned);
                return Err(OpeningFault::NoNode { name: first.into(), near });
            };
            vec![(node, item.into())]
        };
        let opened = NodeId(self.nodes.len());
        let mut made: Option<(&'static NodeType, Animated, Kind)> = None;
        for (node, item) in &places {
            let fault = || OpeningFault::NoLiteral { node: self.nodes[node.0].name.clone(), item: item.clone() };
            let declared = self.nodes[node.0].ty.declaration().items;
            let accepts = port_at(declared, item).ok_or_else(fault)?;
            let source = source_at(&mut self.nodes[node.0].record, item);
            let now = match &source {
                Some(Source::Color(color)) => (&COLOR, color.clone(), Kind::Color),
                Some(Source::Number(number)) if matches!(accepts, Accepts::Mask | Accepts::Image) => {
                    (&MASK, number.clone(), Kind::MASK)
                }
                Some(Source::Number(number)) => (&NUMBER, number.clone(), Kind::Field(1)),
                _ => return Err(OpeningFault::NoLiteral { node: self.nodes[node.0].name.clone(), item: item.clone() }),
            };
            if let Some(source) = source {
                *source = Source::Output { node: opened, output: 0 };
            }
            // A number that is a weight somewhere is one everywhere.
            if made.is_none() || now.2 == Kind::MASK {
                made = Some(now);
            }
        }
        // A color that nothing uses has no place in the graph.
        let Some((ty, value, kind)) = made else {
            return Err(OpeningFault::NoLiteral { node: first.into(), item: item.into() });
        };
        let place = places.first().map(|(node, _)| self.nodes[node.0].place.clone());
        self.nodes.push(CheckedNode {
            name: name.into(),
            ty,
            record: Record { knobs: vec![("value", Setting::Numeric(value))], ..Record::default() },
            kinds: vec![kind],
            disabled: false,
            place: place.unwrap_or_else(|| self.place_of_format()),
            places: Vec::new(),
        });
        self.order.insert(0, opened);
        Ok(self)
    }
}

/// Returns what the port at a path such as `stops[1].color` accepts.
fn port_at(items: &'static [Item], path: &str) -> Option<Accepts> {
    let (step, rest) = path.split_once('.').map_or((path, None), |(step, rest)| (step, Some(rest)));
    let (name, _) = step_of(step)?;
    items.iter().find_map(|item| match (item, rest) {
        (Item::Port(port), None) if port.name == name => Some(port.accepts),
        (Item::List(list), Some(rest)) if list.name == name => port_at(list.items, rest),
        _ => None,
    })
}

/// Returns the source at a path.
fn source_at<'r>(record: &'r mut Record, path: &str) -> Option<&'r mut Source> {
    let (step, rest) = path.split_once('.').map_or((path, None), |(step, rest)| (step, Some(rest)));
    let (name, index) = step_of(step)?;
    match rest {
        None => {
            let (_, sources) = record.ports.iter_mut().find(|(known, _)| *known == name)?;
            sources.get_mut(index)
        }
        Some(rest) => {
            let (_, records) = record.lists.iter_mut().find(|(known, _)| *known == name)?;
            source_at(records.get_mut(index)?, rest)
        }
    }
}

/// Splits `stops[1]` into the name and the index, which is 0 if there is none.
fn step_of(step: &str) -> Option<(&str, usize)> {
    match step.split_once('[') {
        Some((name, index)) => Some((name, index.strip_suffix(']')?.parse().ok()?)),
        None => Some((step, 0)),
    }
}
