//! Declarations of node types, from which schema, manual, editor widgets, checks and content keys are derived.

use crate::{Accepts, Alias, Kind};

/// Declaration of a node type.
#[derive(Clone, Copy, Debug)]
pub struct Declaration {
    /// The `type` in documents, for example `Mix`.
    pub name: &'static str,
    /// End of the graph to which the node belongs.
    pub end: End,
    /// Purpose of the node, in one sentence.
    pub summary: &'static str,
    /// Formula, in the manual's plain notation.
    pub formula: &'static str,
    /// Behavior at the edges of the domain.
    pub edge_cases: &'static str,
    /// Source of the definition.
    pub source: &'static str,
    /// Ports and knobs, in display order.
    pub items: &'static [Item],
    /// Outputs; a reference that names only the node means the first.
    pub outputs: &'static [Output],
    /// Role by which programs find the type.
    pub role: Option<Role>,
    /// Properties of its outputs beyond their kind.
    pub offers: &'static [Offer],
    /// Files that it reads, if their names tell.
    pub reads: Option<Files>,
    /// Names in other programs.
    pub aliases: &'static [Alias],
    /// What the manual's example of the node has beside what is required, as entries of a JSON object; "sea", "view" and
    /// the like stand for other nodes.
    pub example: &'static str,
    /// Version of the results: raised when they change, so that no cache returns old ones.
    pub revision: u32,
}

/// End of the graph to which a node belongs.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum End {
    /// Front end: any mathematics; makes Fields and masks.
    Front,
    /// Back end: convex operations only; makes Colors and Weights.
    Back,
}

/// Role by which editors, and checks of other nodes, find a node type.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub enum Role {
    /// The standard camera.
    Camera,
    /// The standard light.
    Light,
    /// A renderer of surfaces through a camera.
    Render,
    /// A view of passes that another renderer made.
    Passes,
    /// A sea or other water.
    Sea,
    /// The standard conversion of a field to a mask.
    Threshold,
    /// The standard lighting pass: shows surfaces with lighting only.
    Clay,
    /// A blend of colors in rows and columns.
    Patch,
    /// The mask of one of several weights, which references name by its index.
    Pick,
}

/// Property of an output beyond its kind, for ports that need it.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub enum Offer {
    /// A plane at rest, above which heights are measured. Every sea has one.
    Rest,
    /// Waves in closed form whose crests can break.
    Waves,
    /// Trails that bursts leave behind.
    Trails,
    /// Folds, which some nodes use as breaking crests.
    Folds,
    /// Map of stability over knobs.
    StabilityMap,
}

impl std::fmt::Display for Offer {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        f.write_str(match self {
            Self::Rest => "water level",
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
    /// Description of their content, such as "a picture".
    pub what: &'static str,
    /// File extensions, in lower case.
    pub endings: &'static [&'static str],
}

impl Files {
    /// Returns whether a file's name has one of the extensions.
    pub fn include(&self, name: &str) -> bool {
        let ending = name.rsplit_once('.').map(|(_, ending)| ending.to_lowercase());
        ending.is_some_and(|ending| self.endings.contains(&&*ending))
    }
}

/// One output of a node type.
#[derive(Clone, Copy, Debug)]
pub struct Output {
    /// Name, after the dot in `"node.output"`.
    pub name: &'static str,
    /// Kind, if the declaration alone determines it.
    pub kind: Kind,
    /// Kinds that knobs can decide instead.
    pub others: &'static [Kind],
    /// Help text: meaning and unit.
    pub help: &'static str,
    /// Channel names in files that other programs expect; empty for the standard names of the kind.
    pub stored: &'static [&'static str],
}

/// A port, a knob, or a list of records of them.
#[derive(Clone, Copy, Debug)]
pub enum Item {
    /// A connection.
    Port(Port),
    /// A setting.
    Knob(Knob),
    /// A list of records, for example the stops of a ramp.
    List(List),
}

impl Item {
    /// Returns the key in documents.
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
    /// Help text.
    pub help: &'static str,
    /// Kinds of value that the port accepts.
    pub accepts: Accepts,
    /// Number of connections.
    pub arity: Arity,
    /// Properties that the node uses beyond the kind.
    pub wants: &'static [Offer],
}

/// Number of connections that a port takes.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Arity {
    /// Exactly one.
    One,
    /// At most one.
    Optional,
    /// A JSON array of connections.
    Many {
        /// Smallest number.
        min: usize,
        /// Largest number.
        max: usize,
    },
}

/// A setting: a constant, or a value keyed over frames.
#[derive(Clone, Copy, Debug)]
pub struct Knob {
    /// The key in documents.
    pub name: &'static str,
    /// Help text.
    pub help: &'static str,
    /// Unit: `m`, `s`, `degrees`, `frames`; empty for none.
    pub unit: &'static str,
    /// Type and range of the value.
    pub takes: KnobType,
    /// Value if the document sets none; `None` makes the knob required.
    pub default: Option<KnobDefault>,
    /// Whether the value may be keyed over frames.
    pub animated: bool,
    /// Whether each key holds until the next, for values without intermediate ones.
    pub hold_keys: bool,
    /// Whether the knob trades accuracy for speed. Its values are in order from the coarsest to the most accurate;
    /// they change how closely the node matches its reference, but never the reference.
    pub accuracy: bool,
    /// Whether the node's work grows with the value.
    pub affects_cost: bool,
    /// Whether the value is a length in pixels, which is scaled with the size of the picture.
    pub in_pixels: bool,
    /// Whether the value is the height of a picture for which other knobs of the node are in pixels; if it is unset, that is
    /// the picture itself.
    pub picture_height: bool,
    /// What the knob sets in the world, for programs that show it there.
    pub places: Option<Placing>,
}

/// What a knob sets in the world: lengths in meters, angles in degrees, y up. Knobs of one node, or of one record of a list,
/// place one thing.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub enum Placing {
    /// A point: x, y, z; or x, z on the ground.
    Position,
    /// The point that something at a position looks at.
    Target,
    /// The direction toward something far away: x, y, z.
    Direction,
    /// The x of a point.
    X,
    /// The z of a point.
    Z,
    /// The height of a point above the sea at rest.
    Lift,
    /// The height of a sea at rest.
    Level,
    /// A direction on the ground: 0 is +X, 90 is +Z.
    Heading,
    /// Rotations about x, y and z.
    Rotation,
    /// Scale factors along x, y and z.
    Scale,
}

/// Type and range of a knob's value.
#[derive(Clone, Copy, Debug)]
pub enum KnobType {
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
    /// One of several words.
    Choice(&'static [&'static str]),
    /// A color: `"#rrggbb"` in sRGB, or `[r, g, b]` in the working space, finite and ≥ 0.
    Color,
    /// A fixed number of finite numbers.
    Vector(usize),
    /// A nonempty string.
    Text,
    /// A path, relative to the document's folder.
    Path,
    /// A list of finite numbers.
    Numbers {
        /// Smallest number.
        min: usize,
        /// Largest number.
        max: usize,
    },
    /// A list of strings.
    Texts {
        /// Largest number.
        max: usize,
    },
}

/// Value of a knob that the document does not set.
#[derive(Clone, Copy, Debug)]
pub enum KnobDefault {
    /// A number or whole number.
    Number(f64),
    /// A Boolean value.
    Bool(bool),
    /// A word or string.
    Text(&'static str),
    /// A color or vector.
    Vector(&'static [f64]),
    /// No value: the node sees the knob as unset.
    Unset,
}

/// A list of records.
#[derive(Clone, Copy, Debug)]
pub struct List {
    /// The key in documents.
    pub name: &'static str,
    /// Help text.
    pub help: &'static str,
    /// Ports and knobs of one record.
    pub items: &'static [Item],
    /// Smallest number of records.
    pub min: usize,
    /// Largest number of records.
    pub max: usize,
}
