//! The one declaration of a node type: schema, manual, editor widgets, checks and keys derive from it.

use crate::{Accepts, Alias, Kind};

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
    /// What it is to programs that look for one of its kind.
    pub role: Option<Role>,
    /// What its outputs have beside their kind.
    pub offers: &'static [Offer],
    /// The files that it reads, where their names tell.
    pub reads: Option<Files>,
    /// What other programs call it.
    pub aliases: &'static [Alias],
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

/// What a node type is to programs that look for one of its kind: editors, and checks of other nodes.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub enum Role {
    /// The usual camera.
    Camera,
    /// The usual light.
    Light,
    /// What looks at surfaces through a camera.
    Render,
    /// A view of passes that were rendered elsewhere.
    Passes,
    /// A sea, or other water.
    Sea,
    /// The usual way from a field to a mask.
    Threshold,
    /// The usual pass of light: how surfaces look that are lit and nothing else.
    Clay,
    /// Colors in rows and columns.
    Patch,
}

/// What an output has beside its kind, for what needs just that.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub enum Offer {
    /// A plane at rest, over which it stands: of every sea.
    Rest,
    /// Waves that crests break of, in closed form.
    Waves,
    /// What bursts leave behind.
    Trails,
    /// Folds, which some take for breaking crests.
    Folds,
    /// A map of its stability.
    StabilityMap,
}

impl std::fmt::Display for Offer {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        f.write_str(match self {
            Self::Rest => "plane at rest",
            Self::Waves => "waves",
            Self::Trails => "trails of bursts",
            Self::Folds => "folds",
            Self::StabilityMap => "map of its stability",
        })
    }
}

/// Files that a node type reads.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Files {
    /// What they hold, such as "a picture".
    pub what: &'static str,
    /// Their endings, in lower case.
    pub endings: &'static [&'static str],
}

impl Files {
    /// Whether a file's name says that it is one of them.
    pub fn include(&self, name: &str) -> bool {
        let ending = name.rsplit_once('.').map(|(_, ending)| ending.to_lowercase());
        ending.is_some_and(|ending| self.endings.contains(&&*ending))
    }
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
    /// What it makes use of beside the kind.
    pub wants: &'static [Offer],
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
