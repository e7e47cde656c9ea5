//! The closed set of kinds of value on connections.

use std::fmt;
use trochoid_image::Channel;

/// Kind of value that an output has and a port takes.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub enum Kind {
    /// RGB image in the working space; finite, ≥ 0.
    Color,
    /// A color in `n` layers that share all their weights, three channels each; only in graphs with recipes.
    Layers(usize),
    /// Partition of unity over `n` controls. `Weights(2)` is a *mask*, stored as one number t in [0, 1].
    Weights(usize),
    /// Unbounded image of 1 to 4 components, never NaN.
    Field(usize),
    /// Geometry that a camera can see. Front end only.
    Surface,
    /// Camera. Front end only.
    Camera,
    /// Light source. Front end only.
    Light,
    /// Surfaces as a camera sees them: coverage, and the fields that nodes request. Front end only.
    View,
}

impl Kind {
    /// Two-way partition of unity, written as one number.
    pub const MASK: Self = Self::Weights(2);

    /// In a declaration: a partition whose number of weights depends on knobs and connections.
    pub const ANY_WEIGHTS: Self = Self::Weights(0);

    /// In a declaration: the kind of the node's first connection.
    pub const ANY: Self = Self::Field(0);

    /// Returns the number of planes of the value in a tile; 0 for values that are not images.
    pub fn channels(self) -> usize {
        match self {
            Self::Color => 3,
            Self::Layers(n) => 3 * n,
            Self::Weights(2) => 1,
            Self::Weights(n) | Self::Field(n) => n,
            Self::View => Channel::COUNT,
            Self::Surface | Self::Camera | Self::Light => 0,
        }
    }

    /// Returns whether all values of the kind are finite.
    pub fn is_finite(self) -> bool {
        matches!(self, Self::Color | Self::Layers(_) | Self::Weights(_))
    }
}

impl fmt::Display for Kind {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Color => f.write_str("Color"),
            Self::Layers(_) => f.write_str("recipe"),
            Self::Weights(0) => f.write_str("Weights"),
            Self::Weights(2) => f.write_str("mask"),
            Self::Weights(n) => write!(f, "Weights({n})"),
            Self::Field(0) => f.write_str("the kind of the inputs"),
            Self::Field(1) => f.write_str("Field"),
            Self::Field(n) => write!(f, "Field of {n} components"),
            Self::Surface => f.write_str("Surface"),
            Self::Camera => f.write_str("Camera"),
            Self::Light => f.write_str("Light"),
            Self::View => f.write_str("View"),
        }
    }
}

/// Kinds of value and literals that a port takes.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub enum Accepts {
    /// A Color, or a literal color.
    Color,
    /// A mask, or a literal number in [0, 1].
    Mask,
    /// A partition over any number of controls.
    Weights,
    /// A Field of one component, a mask (read as a Field), or a literal number.
    Scalar,
    /// A Field of any number of components, or a mask.
    Field,
    /// A Field of two components.
    Direction,
    /// Any image: a Color, a mask, Weights or a Field; a literal color, or a literal number in [0, 1] as a mask.
    Image,
    /// A Surface.
    Surface,
    /// A Camera.
    Camera,
    /// A Light.
    Light,
    /// A View.
    View,
}

impl Accepts {
    /// Whether a value of `kind` may be connected: one of the same kind, or a mask as a Field.
    pub fn takes(self, kind: Kind) -> bool {
        matches!(
            (self, kind),
            (Self::Color, Kind::Color)
                | (Self::Mask | Self::Scalar | Self::Field, Kind::MASK)
                | (Self::Weights, Kind::Weights(_))
                | (Self::Scalar, Kind::Field(1))
                | (Self::Field, Kind::Field(_))
                | (Self::Direction, Kind::Field(2))
                | (Self::Image, Kind::Color | Kind::Weights(_) | Kind::Field(_))
                | (Self::Surface, Kind::Surface)
                | (Self::Camera, Kind::Camera)
                | (Self::Light, Kind::Light)
                | (Self::View, Kind::View)
        )
    }

    /// Whether a literal number may stand in for a connection.
    pub fn takes_number(self) -> bool {
        matches!(self, Self::Mask | Self::Scalar | Self::Field | Self::Image)
    }

    /// Whether a literal color may stand in for a connection.
    pub fn takes_color(self) -> bool {
        matches!(self, Self::Color | Self::Image)
    }

    /// Returns a remedy for diagnostics: how to turn a refused value into a legal one.
    pub fn remedy(self, found: Kind) -> String {
        match (self, found) {
            (Self::Mask | Self::Weights, Kind::Field(1)) => {
                "insert a Clamp: it maps the field to weights in [0, 1]".into()
            }
            (Self::Mask | Self::Weights, Kind::Field(_)) => {
                "extract one component with a FieldMath (\"expression\": \"a.x\"), then Clamp it".into()
            }
            (Self::Direction, Kind::Weights(_) | Kind::Field(_)) => {
                "connect a FlowField, or make two components with FieldMath".into()
            }
            (Self::Scalar, Kind::Field(_)) => "extract one component with a FieldMath: \"expression\": \"a.x\"".into(),
            (Self::Mask, Kind::Weights(n)) => {
                format!("connect the {n} weights to a Blend with {n} colors; a mask has only two weights")
            }
            (Self::Mask | Self::Weights | Self::Scalar | Self::Field | Self::Direction, Kind::Color) => {
                "a color cannot become a weight: the picture would no longer be linear in its palette; \
                 read the picture as a field (Read with \"as\": \"field\") and Clamp it"
                    .into()
            }
            (Self::Color, Kind::Weights(_) | Kind::Field(_)) => {
                "connect it as the weight of a Mix, Blend, Ramp or Patch; the colors come from control colors".into()
            }
            (Self::View, Kind::Surface | Kind::Camera) => "insert a Render: it shows surfaces through a camera".into(),
            (Self::Surface, Kind::View) => {
                "connect the surfaces themselves, such as a GerstnerSea; a View is what a camera sees of them".into()
            }
            (_, Kind::View) => "insert a pass, for example NonSpecular or Depth".into(),
            _ => format!("connect a {self}"),
        }
    }
}

impl fmt::Display for Accepts {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(match self {
            Self::Color => "Color",
            Self::Mask => "mask",
            Self::Weights => "Weights",
            Self::Scalar | Self::Field => "Field",
            Self::Direction => "Field of 2 components",
            Self::Image => "Color, mask, Weights or Field",
            Self::Surface => "Surface",
            Self::Camera => "Camera",
            Self::Light => "Light",
            Self::View => "View",
        })
    }
}
