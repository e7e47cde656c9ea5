//! Samples of one channel, as a stage reads them.

use super::Fills;
use super::tapped::Taps;
use crate::planning::plan::Feed;
use std::ops::Deref;
use trochoid_image::Window;
use trochoid_kernel::Plane;
use trochoid_memory::Scratch;

/// Samples in the planes where they are, or copied from there.
pub(super) enum Samples<'a> {
    InPlace(&'a [f32]),
    Copied(Scratch<f32>),
}

impl Deref for Samples<'_> {
    type Target = [f32];

    fn deref(&self) -> &[f32] {
        match self {
            Self::InPlace(samples) => samples,
            Self::Copied(samples) => samples,
        }
    }
}

/// Samples by port, connection and channel; `None` where not requested.
pub(super) type PortSamples<'a> = Scratch<Scratch<Scratch<Option<Samples<'a>>>>>;

impl Fills<'_> {
    /// Returns the samples of one channel over a region, row by row; borrowed if they are already contiguous.
    pub(super) fn samples<'a>(
        &'a self,
        feed: &Feed,
        region: Window,
        index: usize,
        taps: &'a Taps,
    ) -> Option<Samples<'a>> {
        let plane = match feed {
            Feed::Nothing => return None,
            Feed::Constant(value) => return Some(Samples::Copied(Scratch::of(*value, region.area()))),
            Feed::Tap(root, channel) => {
                let (samples, within) = match self.known_taps(index) {
                    Some(known) => (&known[*root][*channel][..], self.plan.graph.format().window()),
                    None => (taps.get(*root, *channel)?, self.fills[index].tap_window),
                };
                let stride = within.width();
                let start = (region.y0 - within.y0) as usize * stride + (region.x0 - within.x0) as usize;
                Plane { samples, start, stride }
            }
            Feed::Slot(slot) => self.plane(slot, region, &self.fills[..index]),
        };
        let (width, height) = (region.width(), region.height());
        let cropped = if let Feed::Slot(slot) = feed { self.crops.get(slot, region) } else { None };
        Some(if let Some(samples) = cropped {
            Samples::InPlace(samples)
        } else if plane.stride == width || height == 1 {
            Samples::InPlace(&plane.samples[plane.start..plane.start + region.area()])
        } else {
            let mut samples = Scratch::with_room(region.area());
            for y in 0..height {
                samples.extend_from_slice(plane.row(y, width));
            }
            Samples::Copied(samples)
        })
    }
}
