use trochoid_image::{Channel, ChannelSet, Window};
use trochoid_memory::Scratch;

use crate::Hit;

/// Channels for which a mesh needs normals.
pub(crate) const NORMALS: ChannelSet = ChannelSet::NORMAL.union(ChannelSet::of(&[Channel::Jacobian]));
/// Channels for which a mesh needs rest points.
pub(crate) const RESTS: ChannelSet = ChannelSet::REST.union(ChannelSet::of(&[Channel::RestDistance]));
/// Channels of the traces that bursts leave behind.
pub(crate) const TRAILS: ChannelSet = ChannelSet::of(&Channel::TRAILS);
/// Channels whose values depend on where a ray meets a surface, rather than on whether it does.
pub(crate) const CURVED: ChannelSet = ChannelSet::ALL.minus(ChannelSet::of(&[Channel::Coverage, Channel::Surface]));

/// Returns the value of a channel at a hit, or its background if there is none.
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

/// Results for one sample of each pixel of a window: a plane for each requested channel.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Samples {
    window: Window,
    planes: [Scratch<f32>; Channel::COUNT],
}

impl Samples {
    /// Returns an empty buffer, which `fill` reuses.
    pub fn new() -> Self {
        Self::default()
    }

    /// Returns the window of pixels.
    pub fn window(&self) -> Window {
        self.window
    }

    /// Returns one channel row by row; empty if it was not requested.
    pub fn channel(&self, channel: Channel) -> &[f32] {
        &self.planes[channel as usize]
    }

    /// Makes room for a window, only in the wanted channels; the contents still have to be written.
    pub(crate) fn shape(&mut self, window: Window, wanted: ChannelSet) {
        self.window = window;
        for channel in Channel::ALL {
            self.planes[channel as usize].resize(if wanted.contains(channel) { window.area() } else { 0 }, 0.0);
        }
    }

    /// Returns the planes to be filled.
    pub(crate) fn targets(&mut self) -> Targets<'_> {
        Targets { planes: self.planes.each_mut().map(|plane| plane.as_mut_slice()) }
    }
}

/// Planes of the caller to be filled with one sample of each pixel of a window.
#[derive(Debug, Default)]
pub struct Targets<'a> {
    planes: [&'a mut [f32]; Channel::COUNT],
}

impl<'a> Targets<'a> {
    /// Asks for a channel, row by row in a plane that has as many entries as the window has pixels.
    pub fn ask(&mut self, channel: Channel, plane: &'a mut [f32]) {
        self.planes[channel as usize] = plane;
    }

    /// Returns the channels that are asked for, at so many pixels.
    ///
    /// # Panics
    /// A plane has another size.
    pub(crate) fn wanted(&self, pixels: usize) -> ChannelSet {
        let asked = Channel::ALL.into_iter().zip(&self.planes).filter(|(_, plane)| !plane.is_empty());
        let check = |(channel, plane): (Channel, &&mut [f32])| {
            assert_eq!(plane.len(), pixels, "a plane has an entry for each pixel");
            channel
        };
        asked.map(check).collect()
    }

    /// Returns the plane of a channel; empty if it was not asked for.
    #[inline]
    pub(crate) fn all(&mut self, channel: Channel) -> &mut [f32] {
        self.planes[channel as usize]
    }
}
