use trochoid_image::Window;

use crate::Hit;

/// One scalar that a view can answer for each sample.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash, PartialOrd, Ord)]
#[repr(u8)]
pub enum Channel {
    /// 1 where a surface is seen, else 0.
    Coverage,
    /// Planar depth in meters; +∞ where nothing is seen.
    Depth,
    /// World x of the point in meters; 0 where nothing is seen.
    PositionX,
    /// World y.
    PositionY,
    /// World z.
    PositionZ,
    /// Unit normal, x; (0, 1, 0) where nothing is seen. It stands on the outer side, a sea's in the air: toward a
    /// camera outside, away from one inside. Where a sea folds over itself the side that is seen counts, not the
    /// one that was up at rest.
    NormalX,
    /// Unit normal, y.
    NormalY,
    /// Unit normal, z.
    NormalZ,
    /// World x of the rest point in meters; 0 where nothing is seen. A sea's rest point lies on its rest level, a
    /// model's in the model's own space, so that textures stay on it.
    RestX,
    /// World y of the rest point.
    RestY,
    /// World z of the rest point.
    RestZ,
    /// Height above the surface's rest level in meters; 0 where nothing is seen.
    Height,
    /// Distance from the rest point in meters; 0 where nothing is seen.
    RestDistance,
    /// Slope variance that the pixel's footprint took away: roughness to add; 0 where nothing is seen.
    SlopeVariance,
    /// Area ratio of displaced and resting surface, det J: below 1 where crests gather, negative in folds; 1 where
    /// nothing is seen.
    Jacobian,
    /// Index of the surface; −1 where nothing is seen.
    Surface,
    /// Texture coordinate u; 0 where nothing is seen. Of surfaces without texture coordinates it is the rest point's x.
    U,
    /// Texture coordinate v, or the rest point's z.
    V,
    /// Foam that bursts left behind on a toon sea; 0 on other surfaces and where nothing is seen, as all that follow.
    Rift,
    /// How lately and closely bursts have passed, w: 1 in their middle.
    DriftWeight,
    /// w·cos of the angle that counts drift lines along the paths of bursts, a full turn for every 16.
    AlongCos,
    /// w·sin of that angle.
    AlongSin,
    /// w·cos of the angle that counts drift lines across the paths.
    AcrossCos,
    /// w·sin of that angle.
    AcrossSin,
}

impl Channel {
    /// All channels, in order.
    pub const ALL: [Self; 24] = [
        Self::Coverage,
        Self::Depth,
        Self::PositionX,
        Self::PositionY,
        Self::PositionZ,
        Self::NormalX,
        Self::NormalY,
        Self::NormalZ,
        Self::RestX,
        Self::RestY,
        Self::RestZ,
        Self::Height,
        Self::RestDistance,
        Self::SlopeVariance,
        Self::Jacobian,
        Self::Surface,
        Self::U,
        Self::V,
        Self::Rift,
        Self::DriftWeight,
        Self::AlongCos,
        Self::AlongSin,
        Self::AcrossCos,
        Self::AcrossSin,
    ];
    /// What bursts leave behind, in the order of [`Mesh::trails`](crate::Mesh::trails).
    pub const TRAILS: [Self; 6] =
        [Self::Rift, Self::DriftWeight, Self::AlongCos, Self::AlongSin, Self::AcrossCos, Self::AcrossSin];

    /// What the channel holds where nothing is seen.
    pub const fn background(self) -> f32 {
        match self {
            Self::Depth => f32::INFINITY,
            Self::NormalY | Self::Jacobian => 1.0,
            Self::Surface => -1.0,
            _ => 0.0,
        }
    }

    /// What the channel holds where this is seen, or nothing.
    pub fn of(self, hit: Option<&Hit>) -> f64 {
        let Some(hit) = hit else { return f64::from(self.background()) };
        match self {
            Self::Coverage => 1.0,
            Self::Depth => hit.depth,
            Self::PositionX => hit.position.x,
            Self::PositionY => hit.position.y,
            Self::PositionZ => hit.position.z,
            Self::NormalX => hit.normal.x,
            Self::NormalY => hit.normal.y,
            Self::NormalZ => hit.normal.z,
            Self::RestX => hit.rest.x,
            Self::RestY => hit.rest.y,
            Self::RestZ => hit.rest.z,
            Self::Height => hit.height,
            Self::RestDistance => hit.rest_distance,
            Self::SlopeVariance => hit.slope_variance,
            Self::Jacobian => hit.jacobian,
            Self::Surface => hit.surface as f64,
            Self::U => hit.uv[0],
            Self::V => hit.uv[1],
            Self::Rift => hit.trails[0],
            Self::DriftWeight => hit.trails[1],
            Self::AlongCos => hit.trails[2],
            Self::AlongSin => hit.trails[3],
            Self::AcrossCos => hit.trails[4],
            Self::AcrossSin => hit.trails[5],
        }
    }
}

/// A set of channels.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash, Default)]
pub struct ChannelSet(u32);

impl ChannelSet {
    /// None.
    pub const NONE: Self = Self(0);
    /// Coverage.
    pub const COVERAGE: Self = Self::of(&[Channel::Coverage]);
    /// Depth.
    pub const DEPTH: Self = Self::of(&[Channel::Depth]);
    /// Position, three channels.
    pub const POSITION: Self = Self::of(&[Channel::PositionX, Channel::PositionY, Channel::PositionZ]);
    /// Normal, three channels.
    pub const NORMAL: Self = Self::of(&[Channel::NormalX, Channel::NormalY, Channel::NormalZ]);
    /// What a mesh's normals are needed for.
    pub(crate) const NORMALS: Self = Self::NORMAL.union(Self::of(&[Channel::Jacobian]));
    /// What a mesh's rest points are needed for.
    pub(crate) const RESTS: Self = Self::REST.union(Self::of(&[Channel::RestDistance]));
    /// What fine meshes have: contours are known by normals, surfaces are found from rest points on.
    pub(crate) const FINE: Self = Self::RESTS.union(Self::NORMAL);
    /// Rest point, three channels.
    pub const REST: Self = Self::of(&[Channel::RestX, Channel::RestY, Channel::RestZ]);
    /// Texture coordinates, two channels.
    pub const UV: Self = Self::of(&[Channel::U, Channel::V]);
    /// What bursts leave behind.
    pub(crate) const TRAILS: Self = Self::of(&Channel::TRAILS);
    /// Every channel.
    pub const ALL: Self = Self::of(&Channel::ALL);

    /// The set of these channels.
    pub const fn of(channels: &[Channel]) -> Self {
        let (mut bits, mut index) = (0, 0);
        while index < channels.len() {
            bits |= 1 << channels[index] as u16;
            index += 1;
        }
        Self(bits)
    }

    /// Whether the channel is in the set.
    pub const fn contains(self, channel: Channel) -> bool {
        self.0 & (1 << channel as u16) != 0
    }

    /// Whether the sets share a channel.
    pub const fn intersects(self, other: Self) -> bool {
        self.0 & other.0 != 0
    }

    /// The channels of either set.
    pub const fn union(self, other: Self) -> Self {
        Self(self.0 | other.0)
    }

    /// Whether all channels of `other` are in this set.
    pub const fn includes(self, other: Self) -> bool {
        self.0 & other.0 == other.0
    }

    /// The channels, in order.
    pub fn iter(self) -> impl Iterator<Item = Channel> {
        Channel::ALL.into_iter().filter(move |&channel| self.contains(channel))
    }
}

impl FromIterator<Channel> for ChannelSet {
    fn from_iter<T: IntoIterator<Item = Channel>>(channels: T) -> Self {
        channels.into_iter().fold(Self::NONE, |set, channel| set.union(Self::of(&[channel])))
    }
}

/// The answers for one sample of each pixel of a window: a plane for each channel that was asked for.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Samples {
    window: Window,
    planes: [Vec<f32>; Channel::ALL.len()],
}

impl Samples {
    /// No answers yet; a buffer that `fill` reuses.
    pub fn new() -> Self {
        Self::default()
    }

    /// The pixels answered for.
    pub fn window(&self) -> Window {
        self.window
    }

    /// One channel row by row; empty where it was not asked for.
    pub fn channel(&self, channel: Channel) -> &[f32] {
        &self.planes[channel as usize]
    }

    /// Room for a window in the wanted channels only; what they hold there is yet to be written.
    pub(crate) fn shape(&mut self, window: Window, wanted: ChannelSet) {
        self.window = window;
        for channel in Channel::ALL {
            self.planes[channel as usize].resize(if wanted.contains(channel) { window.area() } else { 0 }, 0.0);
        }
    }

    /// The samples of a channel from `first` on; none where it was not asked for.
    #[inline]
    pub(crate) fn from(&mut self, channel: Channel, first: usize) -> &mut [f32] {
        self.planes[channel as usize].get_mut(first..).unwrap_or_default()
    }
}
