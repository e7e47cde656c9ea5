//! Validation of file data: the values refused for each kind, and the nearest legal value.

use std::path::Path;
use trochoid_graph::{BadData, NodeError};
use trochoid_image::{Plane, Window};
use trochoid_io::Picture;

/// Requirement on the samples of a channel.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Rule {
    /// Finite and ≥ 0.
    Color,
    /// In [0, 1].
    Mask,
    /// Not NaN.
    Field,
}

impl Rule {
    /// Returns the nearest legal value; 0 for NaN.
    pub(crate) fn nearest(self, value: f32) -> f32 {
        match self {
            _ if value.is_nan() => 0.0,
            Self::Color => value.clamp(0.0, f32::MAX),
            Self::Mask => value.clamp(0.0, 1.0),
            Self::Field => value,
        }
    }

    fn expected(self) -> &'static str {
        match self {
            Self::Color => "a finite number, at least 0",
            Self::Mask => "a number from 0 to 1",
            Self::Field => "a number, not NaN",
        }
    }
}

/// Checks samples against a rule. Returns the position of the first illegal one as an error or, with `repair`, sets
/// each to the nearest legal value and returns their number.
pub(crate) fn legalize(samples: &mut [f32], rule: Rule, repair: bool) -> Result<u64, usize> {
    // Without branches, because nearly all samples are legal.
    let fine = match rule {
        Rule::Color => samples.iter().fold(true, |fine, v| fine & (*v >= 0.0) & (*v <= f32::MAX)),
        Rule::Mask => samples.iter().fold(true, |fine, v| fine & (*v >= 0.0) & (*v <= 1.0)),
        Rule::Field => samples.iter().fold(true, |fine, v| fine & !v.is_nan()),
    };
    let mut repaired = 0;
    if !fine {
        for (index, sample) in samples.iter_mut().enumerate() {
            let legal = rule.nearest(*sample);
            // NaN differs from every number, including itself.
            if *sample != legal {
                if !repair {
                    return Err(index);
                }
                *sample = legal;
                repaired += 1;
            }
        }
    }
    // Adding 0 turns −0 into 0, so that no bit depends on what is pruned.
    samples.iter_mut().for_each(|sample| *sample += 0.0);
    Ok(repaired)
}

/// Returns the error for an illegal sample.
pub(crate) fn illegal(path: &Path, part: usize, channel: &str, pixel: (i64, i64), found: f32, rule: Rule) -> NodeError {
    let remedy = "correct the file, or set \"repair\": true to take the nearest legal value";
    let bad = BadData::new(found, rule.expected(), remedy);
    bad.in_file(path).in_part(part).in_channel(channel).at_pixel(pixel).into()
}

/// Takes the plane of channel `at` out of a picture and checks every sample against a rule: the first illegal one is
/// refused or, with `repair`, each is set to the nearest legal value. Returns their number.
pub(crate) fn take(
    path: &Path,
    picture: &mut Picture,
    at: usize,
    rule: Rule,
    repair: bool,
) -> Result<(Plane, u64), NodeError> {
    let part = picture.part;
    let channel = &mut picture.channels[at];
    let window = channel.plane.window();
    let samples = channel.plane.samples_mut();
    let repaired = legalize(samples, rule, repair)
        .map_err(|index| illegal(path, part, &channel.full_name, place(window, index), samples[index], rule))?;
    let empty = Plane::filled(Window::new(0, 0, 0, 0), 0.0);
    Ok((std::mem::replace(&mut channel.plane, empty), repaired))
}

/// Returns the pixel of sample `index` of a plane.
pub(crate) fn place(window: Window, index: usize) -> (i64, i64) {
    let width = window.width().max(1);
    (window.x0 + (index % width) as i64, window.y0 + (index / width) as i64)
}
