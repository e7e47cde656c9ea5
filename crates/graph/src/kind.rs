//! The closed set of kinds of value that travel along edges.

use std::fmt;

/// What an output hands on and a port takes.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub enum Kind {
    /// RGB image in the working space; finite, ≥ 0.
    Color,
    /// Partition of unity over `n` controls. `Weights(2)` is a *mask*, held as one number t in [0, 1].
    Weights(usize),
    /// Unbounded image of 1 to 4 components, never NaN.
    Field(usize),
    /// Geometry that a camera can see. Front end only.
    Surface,
    /// A point of view. Front end only.
    Camera,
    /// A source of light. Front end only.
    Light,
    /// What a camera sees of surfaces: coverage, and whatever fields are asked of it. Front end only.
    View,
}

impl Kind {
    /// A two-way partition of unity, written as one number.
    pub const MASK: Self = Self::Weights(2);

    /// In a declaration: a partition of as many ways as knobs and connections say.
    pub const ANY_WEIGHTS: Self = Self::Weights(0);

    /// In a declaration: the kind of the node's first connection.
    pub const ANY: Self = Self::Field(0);

    /// Number of planes that the value occupies in a tile; 0 for values that are not images.
    pub fn channels(self) -> usize {
        match self {
            Self::Color => 3,
            Self::Weights(2) => 1,
            Self::Weights(n) | Self::Field(n) => n,
            Self::View => ViewChannel::COUNT,
            Self::Surface | Self::Camera | Self::Light => 0,
        }
    }
}

impl fmt::Display for Kind {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Color => f.write_str("Color"),
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

/// What a port takes.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub enum Accepts {
    /// A Color, or a literal color.
    Color,
    /// A mask, or a literal number in [0, 1].
    Mask,
    /// A partition of any number of controls.
    Weights,
    /// A Field of one component, a mask (which is forgotten to be one), or a literal number.
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
    /// Whether a value of `kind` may be connected: like to like, and mask → Field.
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

    /// The node that makes a legal value of a refused one, as a sentence, for diagnostics.
    pub fn remedy(self, found: Kind) -> String {
        match (self, found) {
            (Self::Mask | Self::Weights, Kind::Field(1)) => {
                "put a Clamp between: it maps the field to weights in [0, 1]".into()
            }
            (Self::Mask | Self::Weights, Kind::Field(_)) => {
                "take one component with a FieldMath (\"expression\": \"a.x\"), then Clamp it".into()
            }
            (Self::Direction, Kind::Weights(_) | Kind::Field(_)) => {
                "connect a FlowField, or make two components with FieldMath".into()
            }
            (Self::Scalar, Kind::Field(_)) => "take one component with a FieldMath: \"expression\": \"a.x\"".into(),
            (Self::Mask, Kind::Weights(n)) => {
                format!("give the {n} weights to a Blend with {n} colors; a mask has two ways only")
            }
            (Self::Mask | Self::Weights | Self::Scalar | Self::Field | Self::Direction, Kind::Color) => {
                "colors never become weights, or the picture would not stay linear in its palette; \
                 read the picture as a field (Read with \"as\": \"field\") and Clamp it"
                    .into()
            }
            (Self::Color, Kind::Weights(_) | Kind::Field(_)) => {
                "give it to a Mix, Blend, Ramp or Patch as its weight; control colors make the color".into()
            }
            (Self::View, Kind::Surface | Kind::Camera) => {
                "put a Render between: it looks at surfaces through a camera".into()
            }
            (Self::Surface, Kind::View) => {
                "name the surfaces themselves, such as a GerstnerSea; a View is what a camera sees of them".into()
            }
            (_, Kind::View) => "put a pass between, for example NonSpecular or Depth".into(),
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

macro_rules! view_channels {
    ($($(#[$doc:meta])* $name:ident $text:literal $background:expr,)*) => {
        /// One plane of a [`Kind::View`].
        #[derive(Clone, Copy, Debug, PartialEq, Eq, Hash, PartialOrd, Ord)]
        pub enum ViewChannel { $($(#[$doc])* $name,)* }

        impl ViewChannel {
            /// Every channel, in the order of a view's planes.
            pub const ALL: &[Self] = &[$(Self::$name,)*];
            /// Number of channels.
            pub const COUNT: usize = Self::ALL.len();

            /// Name for messages.
            pub fn name(self) -> &'static str {
                match self { $(Self::$name => $text,)* }
            }

            /// The documented value where nothing is seen.
            pub fn background(self) -> f32 {
                match self { $(Self::$name => $background,)* }
            }
        }
    };
}

view_channels! {
    /// 1 where a surface is seen, 0 elsewhere.
    Coverage "coverage" 0.0,
    /// Planar distance along the camera's axis, m; +∞ where nothing is seen.
    Depth "depth" f32::INFINITY,
    /// World x, m.
    PositionX "position" 0.0,
    /// World y, m.
    PositionY "position" 0.0,
    /// World z, m.
    PositionZ "position" 0.0,
    /// Unit normal x.
    NormalX "normal" 0.0,
    /// Unit normal y; a degenerate normal and the background point up.
    NormalY "normal" 1.0,
    /// Unit normal z.
    NormalZ "normal" 0.0,
    /// World x of the seen particle's rest point, m.
    RestX "rest point" 0.0,
    /// World y of the rest point, m.
    RestY "rest point" 0.0,
    /// World z of the rest point, m.
    RestZ "rest point" 0.0,
    /// Height above the surface's rest level, m.
    Height "height" 0.0,
    /// Distance from the rest point, m.
    RestDistance "distance from rest" 0.0,
    /// Slope variance of the waves that the footprint filtered out.
    SlopeVariance "slope variance" 0.0,
    /// Area ratio of displaced and resting surface, det J: below 1 where crests gather, negative in folds.
    Jacobian "Jacobian" 1.0,
    /// Index of the seen surface in the Render's list; −1 where nothing is seen.
    Surface "surface" -1.0,
    /// Texture coordinate u; the rest point's x on surfaces without texture coordinates.
    U "texture coordinates" 0.0,
    /// Texture coordinate v; the rest point's z on surfaces without texture coordinates.
    V "texture coordinates" 0.0,
    /// Foam that bursts left behind on a toon sea; 0 on other surfaces.
    Rift "rift" 0.0,
    /// How lately and closely bursts have passed: 1 in their middle, 0 where none was and on other surfaces.
    DriftWeight "drift" 0.0,
    /// Weight × cosine of the angle that counts drift lines along the paths of bursts.
    AlongCos "drift" 0.0,
    /// Weight × sine of that angle.
    AlongSin "drift" 0.0,
    /// Weight × cosine of the angle that counts drift lines across the paths.
    AcrossCos "drift" 0.0,
    /// Weight × sine of that angle.
    AcrossSin "drift" 0.0,
}

/// A set of view channels.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash, Default)]
pub struct ChannelSet(u32);

impl ChannelSet {
    /// No channel.
    pub const EMPTY: Self = Self(0);

    /// Exactly these channels.
    pub const fn of(channels: &[ViewChannel]) -> Self {
        let mut bits = 0;
        let mut i = 0;
        while i < channels.len() {
            bits |= 1 << channels[i] as u32;
            i += 1;
        }
        Self(bits)
    }

    /// Whether the channel is in the set.
    pub fn contains(self, channel: ViewChannel) -> bool {
        self.0 & (1 << channel as u32) != 0
    }

    /// The channels in either set.
    pub fn union(self, other: Self) -> Self {
        Self(self.0 | other.0)
    }

    /// The channels in this set but not in the other.
    pub fn minus(self, other: Self) -> Self {
        Self(self.0 & !other.0)
    }

    /// The channels in both sets.
    pub fn intersect(self, other: Self) -> Self {
        Self(self.0 & other.0)
    }

    /// Whether no channel is in the set.
    pub fn is_empty(self) -> bool {
        self.0 == 0
    }

    /// The channels in the set, in order.
    pub fn iter(self) -> impl Iterator<Item = ViewChannel> {
        ViewChannel::ALL.iter().copied().filter(move |&c| self.contains(c))
    }
}

impl From<ViewChannel> for ChannelSet {
    fn from(channel: ViewChannel) -> Self {
        Self::of(&[channel])
    }
}
