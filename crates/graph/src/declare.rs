//! The one declaration of a node type: schema, manual, editor widgets, checks and keys derive from it.

use crate::Accepts;
use crate::Kind;

/// Everything that is said about a node type, once.
#[derive(Clone, Copy, Debug)]
pub struct Declaration {
    /// The `type` in documents, for example `Mix`.
    pub name: &'static str,
    /// Which end of the graph it belongs to.
    pub end: End,
    /// What it does, in one sentence.
    pub summary: &'static str,
    /// The formula, in the manual's plain notation.
    pub formula: &'static str,
    /// What happens at the edges of its domain.
    pub edge_cases: &'static str,
    /// Where the definition comes from.
    pub source: &'static str,
    /// Ports and knobs, in the order in which they are shown.
    pub items: &'static [Item],
    /// Outputs; the first is meant where a reference names the node alone.
    pub outputs: &'static [Output],
    /// Raised when the node's results change, so that no cache returns the old ones.
    pub revision: u32,
}

/// Which end of the graph a node belongs to.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum End {
    /// Any mathematics; makes Fields and masks.
    Front,
    /// Convex operations only; makes Colors and Weights.
    Back,
}

/// One output of a node type.
#[derive(Clone, Copy, Debug)]
pub struct Output {
    /// Name after the dot in `"node.output"`.
    pub name: &'static str,
    /// Its kind, where the declaration alone determines it.
    pub kind: Kind,
    /// What it holds, with its unit.
    pub help: &'static str,
    /// Names of its channels in files, where others look for certain ones; none where those of its kind do.
    pub stored: &'static [&'static str],
}

/// A port, a knob, or a list of records of them.
#[derive(Clone, Copy, Debug)]
pub enum Item {
    /// A connection.
    Port(Port),
    /// A constant that the user sets.
    Knob(Knob),
    /// A list of records, for example a ramp's stops.
    List(List),
}

impl Item {
    /// The key in documents.
    pub fn name(&self) -> &'static str {
        match self {
            Self::Port(port) => port.name,
            Self::Knob(knob) => knob.name,
            Self::List(list) => list.name,
        }
    }
}

/// A typed socket for connections.
#[derive(Clone, Copy, Debug)]
pub struct Port {
    /// The key in documents.
    pub name: &'static str,
    /// What it means.
    pub help: &'static str,
    /// What it takes.
    pub accepts: Accepts,
    /// How many connections.
    pub arity: Arity,
}

/// How many connections a port takes.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Arity {
    /// Exactly one.
    One,
    /// One or none.
    Optional,
    /// A JSON array of this many.
    Many {
        /// Fewest.
        min: usize,
        /// Most.
        max: usize,
    },
}

/// A constant that the user sets.
#[derive(Clone, Copy, Debug)]
pub struct Knob {
    /// The key in documents.
    pub name: &'static str,
    /// What it means.
    pub help: &'static str,
    /// Its unit, empty if it has none: `m`, `s`, `degrees`, `frames`.
    pub unit: &'static str,
    /// What it takes.
    pub takes: Takes,
    /// The value where the document sets none; `None` makes the knob required.
    pub default: Option<Default>,
    /// Whether the value may be keyed over frames.
    pub animated: bool,
    /// Whether each key holds until the next, since nothing lies between the values.
    pub held: bool,
    /// Whether its values stand from the coarsest to the most accurate, and which is chosen changes how closely and how fast
    /// the node meets its reference, but never the reference.
    pub accuracy: bool,
    /// Whether the node's work grows with it.
    pub scales: bool,
    /// Whether it is a length on the picture, in pixels, so that a smaller picture of the same thing takes it smaller.
    pub drawn: bool,
}

/// What a knob takes.
#[derive(Clone, Copy, Debug)]
pub enum Takes {
    /// A finite number in a closed range.
    Number {
        /// Smallest legal value.
        min: f64,
        /// Largest legal value.
        max: f64,
    },
    /// A whole number in a closed range.
    Integer {
        /// Smallest legal value.
        min: i64,
        /// Largest legal value.
        max: i64,
    },
    /// `true` or `false`.
    Bool,
    /// One of these words.
    Choice(&'static [&'static str]),
    /// A color: `"#rrggbb"` in sRGB, or `[r, g, b]` in the working space, finite and ≥ 0.
    Color,
    /// This many finite numbers.
    Vector(usize),
    /// Any text.
    Text,
    /// A path relative to the document's folder.
    Path,
    /// A list of finite numbers.
    Numbers {
        /// Fewest.
        min: usize,
        /// Most.
        max: usize,
    },
    /// A list of texts.
    Texts {
        /// Most.
        max: usize,
    },
}

/// A knob's value where the document sets none.
#[derive(Clone, Copy, Debug)]
pub enum Default {
    /// A number or whole number.
    Number(f64),
    /// A truth value.
    Bool(bool),
    /// A word or text.
    Text(&'static str),
    /// A color or vector.
    Vector(&'static [f64]),
    /// Nothing: the node knows the knob as unset.
    Unset,
}

/// A list of records.
#[derive(Clone, Copy, Debug)]
pub struct List {
    /// The key in documents.
    pub name: &'static str,
    /// What it means.
    pub help: &'static str,
    /// Ports and knobs of one record.
    pub items: &'static [Item],
    /// Fewest records.
    pub min: usize,
    /// Most records.
    pub max: usize,
}

impl Port {
    /// A port with exactly one connection.
    pub const fn one(name: &'static str, accepts: Accepts, help: &'static str) -> Item {
        Item::Port(Self { name, help, accepts, arity: Arity::One })
    }

    /// A port that may be left open.
    pub const fn optional(name: &'static str, accepts: Accepts, help: &'static str) -> Item {
        Item::Port(Self { name, help, accepts, arity: Arity::Optional })
    }

    /// A port with an array of connections.
    pub const fn many(name: &'static str, accepts: Accepts, min: usize, max: usize, help: &'static str) -> Item {
        Item::Port(Self { name, help, accepts, arity: Arity::Many { min, max } })
    }
}

impl Knob {
    const fn new(
        name: &'static str,
        takes: Takes,
        default: Option<Default>,
        animated: bool,
        help: &'static str,
    ) -> Self {
        Self {
            name,
            help,
            unit: "",
            takes,
            default,
            animated,
            held: false,
            accuracy: false,
            scales: false,
            drawn: false,
        }
    }

    /// A number in `[min, max]` with a default.
    pub const fn number(name: &'static str, default: f64, min: f64, max: f64, help: &'static str) -> Self {
        Self::new(name, Takes::Number { min, max }, Some(Default::Number(default)), true, help)
    }

    /// A whole number in `[min, max]` with a default.
    pub const fn integer(name: &'static str, default: i64, min: i64, max: i64, help: &'static str) -> Self {
        Self::new(name, Takes::Integer { min, max }, Some(Default::Number(default as f64)), true, help)
    }

    /// A truth value with a default.
    pub const fn bool(name: &'static str, default: bool, help: &'static str) -> Self {
        Self::new(name, Takes::Bool, Some(Default::Bool(default)), false, help)
    }

    /// One of several words; the first is the default.
    pub const fn choice(name: &'static str, words: &'static [&'static str], help: &'static str) -> Self {
        Self::new(name, Takes::Choice(words), Some(Default::Text(words[0])), false, help)
    }

    /// A color, required.
    pub const fn color(name: &'static str, help: &'static str) -> Self {
        Self::new(name, Takes::Color, None, true, help)
    }

    /// A vector of numbers with a default.
    pub const fn vector(name: &'static str, default: &'static [f64], help: &'static str) -> Self {
        Self::new(name, Takes::Vector(default.len()), Some(Default::Vector(default)), true, help)
    }

    /// A text that may be left unset.
    pub const fn text(name: &'static str, help: &'static str) -> Self {
        Self::new(name, Takes::Text, Some(Default::Unset), false, help)
    }

    /// A path, required.
    pub const fn path(name: &'static str, help: &'static str) -> Self {
        Self::new(name, Takes::Path, None, false, help)
    }

    /// A list of numbers, required.
    pub const fn numbers(name: &'static str, min: usize, max: usize, help: &'static str) -> Self {
        Self::new(name, Takes::Numbers { min, max }, None, false, help)
    }

    /// A list of texts that may be left unset.
    pub const fn texts(name: &'static str, max: usize, help: &'static str) -> Self {
        Self::new(name, Takes::Texts { max }, Some(Default::Unset), false, help)
    }

    /// Removes the default, so that the document must set the knob.
    pub const fn required(mut self) -> Self {
        self.default = None;
        self
    }

    /// Lets the node see the knob as unset where the document sets none.
    pub const fn optional(mut self) -> Self {
        self.default = Some(Default::Unset);
        self
    }

    /// Lets each key hold until the next.
    pub const fn held(mut self) -> Self {
        self.held = true;
        self
    }

    /// Says that its words, or numbers, stand from the coarsest to the most accurate method.
    pub const fn accuracy(mut self) -> Self {
        self.accuracy = true;
        self
    }

    /// Says that the node's work grows with it.
    pub const fn scales(mut self) -> Self {
        self.scales = true;
        self
    }

    /// Says that it is a length on the picture, in pixels, as the width of a line is.
    pub const fn drawn(mut self) -> Self {
        self.drawn = true;
        self.unit("pixels")
    }

    /// States the unit.
    pub const fn unit(mut self, unit: &'static str) -> Self {
        self.unit = unit;
        self
    }

    /// Ends the declaration of a knob.
    pub const fn item(self) -> Item {
        Item::Knob(self)
    }
}

impl List {
    /// A list of `min` to `max` records.
    pub const fn of(name: &'static str, items: &'static [Item], min: usize, max: usize, help: &'static str) -> Item {
        Item::List(Self { name, help, items, min, max })
    }
}

impl Output {
    /// An output of one kind.
    pub const fn new(name: &'static str, kind: Kind, help: &'static str) -> Self {
        Self { name, kind, help, stored: &[] }
    }

    /// States the names of its channels in files.
    pub const fn stored_as(mut self, channels: &'static [&'static str]) -> Self {
        self.stored = channels;
        self
    }
}
