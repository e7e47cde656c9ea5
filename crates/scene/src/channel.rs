use trochoid_image::{Channel, ChannelSet, Window};

use crate::Hit;

/// What a mesh's normals are needed for.
pub(crate) const NORMALS: ChannelSet = ChannelSet::NORMAL.union(ChannelSet::of(&[Channel::Jacobian]));
/// What a mesh's rest points are needed for.
pub(crate) const RESTS: ChannelSet = ChannelSet::REST.union(ChannelSet::of(&[Channel::RestDistance]));
/// What fine meshes have: contours are known by normals, surfaces are found from rest points on.
pub(crate) const FINE: ChannelSet = RESTS.union(ChannelSet::NORMAL);
/// What bursts leave behind.
pub(crate) const TRAILS: ChannelSet = ChannelSet::of(&Channel::TRAILS);

/// What a channel holds where this is seen, or nothing.
pub fn channel_of(hit: Option<&Hit>, channel: Channel) -> f64 {
    let Some(hit) = hit else { return f64::from(channel.background()) };
    match channel {
        Channel::Coverage => 1.0,
        Channel::Depth => hit.depth,
        Channel::PositionX => hit.position.x,
        Channel::PositionY => hit.position.y,
        Channel::PositionZ => hit.position.z,
        Channel::NormalX => hit.normal.x,
        Channel::NormalY => hit.normal.y,
        Channel::NormalZ => hit.normal.z,
        Channel::RestX => hit.rest.x,
        Channel::RestY => hit.rest.y,
        Channel::RestZ => hit.rest.z,
        Channel::Height => hit.height,
        Channel::RestDistance => hit.rest_distance,
        Channel::SlopeVariance => hit.slope_variance,
        Channel::Jacobian => hit.jacobian,
        Channel::Surface => hit.surface as f64,
        Channel::U => hit.uv[0],
        Channel::V => hit.uv[1],
        Channel::Rift => hit.trails[0],
        Channel::DriftWeight => hit.trails[1],
        Channel::AlongCos => hit.trails[2],
        Channel::AlongSin => hit.trails[3],
        Channel::AcrossCos => hit.trails[4],
        Channel::AcrossSin => hit.trails[5],
    }
}

/// The answers for one sample of each pixel of a window: a plane for each channel that was asked for.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Samples {
    window: Window,
    planes: [Vec<f32>; Channel::COUNT],
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
