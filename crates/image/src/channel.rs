//! The channels of a view.

use trochoid_key::{ContentKey, KeyHasher};

macro_rules! channels {
    ($($(#[$doc:meta])* $name:ident $text:literal $background:expr,)*) => {
        /// One scalar that a view can supply for each sample, and so one of its planes.
        #[derive(Clone, Copy, Debug, PartialEq, Eq, Hash, PartialOrd, Ord)]
        #[repr(u8)]
        pub enum Channel { $($(#[$doc])* $name,)* }

        impl Channel {
            /// Every channel, in the order of a view's planes.
            pub const ALL: [Self; Self::COUNT] = [$(Self::$name,)*];
            /// Number of channels.
            pub const COUNT: usize = [$(Self::$name,)*].len();

            /// Returns the name for messages.
            pub fn name(self) -> &'static str {
                match self { $(Self::$name => $text,)* }
            }

            /// Returns the value of the channel where nothing is seen.
            pub const fn background(self) -> f32 {
                match self { $(Self::$name => $background,)* }
            }
        }
    };
}

channels! {
    /// 1 where a surface is seen, 0 elsewhere.
    Coverage "coverage" 0.0,
    /// Planar distance along the camera's axis, m; +∞ where nothing is seen.
    Depth "depth" f32::INFINITY,
    /// World x of the point, m.
    PositionX "position" 0.0,
    /// World y, m.
    PositionY "position" 0.0,
    /// World z, m.
    PositionZ "position" 0.0,
    /// Unit surface normal x. The normal points to the outer side, for a sea into the air: toward a camera outside,
    /// away from one inside. Where a sea folds over itself, the visible side counts, not the one that was up at rest.
    NormalX "normal" 0.0,
    /// Unit surface normal y; degenerate normals and the background point up.
    NormalY "normal" 1.0,
    /// Unit surface normal z.
    NormalZ "normal" 0.0,
    /// X of the rest point of the visible surface point, m: for a sea in world space on its rest level, for a model
    /// in object space, so that textures stay on it.
    RestX "rest point" 0.0,
    /// Y of the rest point, m.
    RestY "rest point" 0.0,
    /// Z of the rest point, m.
    RestZ "rest point" 0.0,
    /// Height above the surface's rest level, m.
    Height "height" 0.0,
    /// Distance from the rest point, m.
    RestDistance "distance from rest" 0.0,
    /// Variance of the slopes within the pixel's footprint that were filtered out: roughness to add.
    SlopeVariance "slope variance" 0.0,
    /// Jacobian determinant: area of the displaced surface relative to the resting one; below 1 at crests, negative
    /// in folds.
    Jacobian "Jacobian" 1.0,
    /// Index of the visible surface among those of the view; −1 where nothing is seen.
    Surface "surface" -1.0,
    /// Texture coordinate u; the rest point's x on surfaces without texture coordinates.
    U "texture coordinates" 0.0,
    /// Texture coordinate v; the rest point's z on surfaces without texture coordinates.
    V "texture coordinates" 0.0,
    /// Foam that bursts left behind on a toon sea; 0 on other surfaces, like all channels below.
    Rift "rift" 0.0,
    /// Weight w of the drift, by how recently and closely bursts have passed: 1 in their middle, 0 where there were
    /// none.
    DriftWeight "drift" 0.0,
    /// w·cos of the angle that counts drift lines along the paths of bursts, one full turn for 16 lines.
    AlongCos "drift" 0.0,
    /// w·sin of that angle.
    AlongSin "drift" 0.0,
    /// w·cos of the angle that counts drift lines across the paths.
    AcrossCos "drift" 0.0,
    /// w·sin of that angle.
    AcrossSin "drift" 0.0,
}

impl Channel {
    /// Channels of the trails of bursts: the rift, then the drift.
    pub const TRAILS: [Self; 6] =
        [Self::Rift, Self::DriftWeight, Self::AlongCos, Self::AlongSin, Self::AcrossCos, Self::AcrossSin];
}

/// A set of channels.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash, Default)]
pub struct ChannelSet(u32);

impl ContentKey for ChannelSet {
    fn feed(&self, hasher: &mut KeyHasher) {
        self.0.feed(hasher);
    }
}

impl ChannelSet {
    /// No channel.
    pub const EMPTY: Self = Self(0);
    /// Coverage.
    pub const COVERAGE: Self = Self::of(&[Channel::Coverage]);
    /// Depth.
    pub const DEPTH: Self = Self::of(&[Channel::Depth]);
    /// Position, three channels.
    pub const POSITION: Self = Self::of(&[Channel::PositionX, Channel::PositionY, Channel::PositionZ]);
    /// Normal, three channels.
    pub const NORMAL: Self = Self::of(&[Channel::NormalX, Channel::NormalY, Channel::NormalZ]);
    /// Rest point, three channels.
    pub const REST: Self = Self::of(&[Channel::RestX, Channel::RestY, Channel::RestZ]);
    /// Texture coordinates, two channels.
    pub const UV: Self = Self::of(&[Channel::U, Channel::V]);
    /// Every channel.
    pub const ALL: Self = Self::of(&Channel::ALL);

    /// Makes the set of exactly these channels.
    pub const fn of(channels: &[Channel]) -> Self {
        let (mut bits, mut index) = (0, 0);
        while index < channels.len() {
            bits |= 1 << channels[index] as u32;
            index += 1;
        }
        Self(bits)
    }

    /// Whether the channel is in the set.
    pub const fn contains(self, channel: Channel) -> bool {
        self.0 & (1 << channel as u32) != 0
    }

    /// Whether all channels of `other` are in this set.
    pub const fn includes(self, other: Self) -> bool {
        self.0 & other.0 == other.0
    }

    /// Whether the sets share a channel.
    pub const fn intersects(self, other: Self) -> bool {
        self.0 & other.0 != 0
    }

    /// Returns the channels in either set.
    pub const fn union(self, other: Self) -> Self {
        Self(self.0 | other.0)
    }

    /// Returns the channels in both sets.
    pub const fn intersect(self, other: Self) -> Self {
        Self(self.0 & other.0)
    }

    /// Returns the channels in this set but not in the other.
    pub const fn minus(self, other: Self) -> Self {
        Self(self.0 & !other.0)
    }

    /// Whether no channel is in the set.
    pub const fn is_empty(self) -> bool {
        self.0 == 0
    }

    /// Returns the channels in the set, in order.
    pub fn iter(self) -> impl Iterator<Item = Channel> {
        Channel::ALL.into_iter().filter(move |&channel| self.contains(channel))
    }
}

impl From<Channel> for ChannelSet {
    fn from(channel: Channel) -> Self {
        Self::of(&[channel])
    }
}

impl FromIterator<Channel> for ChannelSet {
    fn from_iter<T: IntoIterator<Item = Channel>>(channels: T) -> Self {
        channels.into_iter().fold(Self::EMPTY, |set, channel| set.union(channel.into()))
    }
}

// Each channel has one bit.
const _: () = assert!(Channel::COUNT <= 32);
