//! Error bounds of all pixels of an output: from a certification, or from a certificate; and what follows from them.

use super::color::Coding;
use super::image::StoredChannel;
use super::level::{BoundMap, PixelBound};
use super::map::{MapError, PixelMap};
use super::storage::before_rounding;
use super::{Ambiguous, BoundAt, BoundSummary, CertifiedError, ChannelBounds, DisplayBounds, Summaries};
use trochoid_engine::Certified;
use trochoid_graph::{Kind, OutputSpec};
use trochoid_image::{Window, WorkingSpace};

/// Error bounds of all pixels of an output.
#[derive(Debug)]
pub(super) struct PictureBounds {
    window: Window,
    ambiguous: PixelMap,
    /// One map for all channels, of the largest; or one for each channel of a field.
    maps: Vec<BoundMap>,
}

/// Why the maps of a certificate are not those of a picture.
#[derive(Debug, thiserror::Error)]
pub(super) enum BoundsError {
    /// A map cannot be decoded.
    #[error("{0}")]
    Map(#[from] MapError),
    /// Another number of maps.
    #[error("{0} maps of bounds")]
    Count(usize),
    /// A base that does not follow from the map.
    #[error("the base {found}, where the map requires {proper}")]
    Base { found: i32, proper: i32 },
}

/// Returns the channels that share one map: all channels of a color or of weights, since their values are shares of
/// one thing; each channel of a field by itself.
pub(super) fn groups(kind: Kind) -> Vec<std::ops::Range<usize>> {
    let channels = kind.channels();
    let shared = if kind.is_finite() { channels.max(1) } else { 1 };
    (0..channels).step_by(shared).map(|first| first..first + shared).collect()
}

/// Returns the largest bound of some channels of a pixel.
pub(super) fn of_channels(errors: &[Vec<f32>], infinite: &[Vec<bool>], pixel: usize) -> PixelBound {
    if infinite.iter().any(|channel| channel[pixel]) {
        return PixelBound::Infinite;
    }
    PixelBound::of(errors.iter().fold(0.0, |most, channel| f64::max(most, f64::from(channel[pixel]))))
}

impl PictureBounds {
    /// Takes the bounds of a whole picture.
    pub(super) fn certified(certified: &Certified) -> Self {
        let pixels = 0..certified.window.area();
        let map = |group: std::ops::Range<usize>| {
            let infinite = certified.infinite.get(group.clone()).unwrap_or_default();
            let errors = &certified.errors[group];
            BoundMap::new(pixels.clone().map(|pixel| of_channels(errors, infinite, pixel)))
        };
        Self {
            window: certified.window,
            ambiguous: PixelMap::new(pixels.clone().map(|pixel| certified.doubt[pixel] > 0.0)),
            maps: groups(certified.kind).into_iter().map(map).collect(),
        }
    }

    /// Takes what a forger states.
    #[cfg(test)]
    pub(super) fn stated(window: Window, ambiguous: impl ExactSizeIterator<Item = bool>, maps: Vec<BoundMap>) -> Self {
        Self { window, ambiguous: PixelMap::new(ambiguous), maps }
    }

    /// Decodes the maps of a certificate.
    pub(super) fn decode(written: &CertifiedError, kind: Kind, window: Window) -> Result<Self, BoundsError> {
        let pixels = window.area();
        let maps = written.channels.iter().map(|channels| {
            let map = BoundMap::decode(channels.base, &channels.map, pixels)?;
            let (found, proper) = (channels.base, map.proper_base());
            if found == proper { Ok(map) } else { Err(BoundsError::Base { found, proper }) }
        });
        let maps: Vec<BoundMap> = maps.collect::<Result<_, BoundsError>>()?;
        if maps.len() != groups(kind).len() {
            return Err(BoundsError::Count(maps.len()));
        }
        Ok(Self { window, ambiguous: PixelMap::decode(&written.ambiguous.map, pixels)?, maps })
    }

    /// Returns whether a pixel is ambiguous.
    pub(super) fn is_ambiguous(&self, pixel: usize) -> bool {
        self.ambiguous.contains(pixel)
    }

    /// Returns the map of each group of channels.
    pub(super) fn maps(&self) -> &[BoundMap] {
        &self.maps
    }

    /// Returns everything that a certificate says about these bounds. `channels` are those of the file.
    pub(super) fn described(
        &self,
        spec: &OutputSpec,
        space: WorkingSpace,
        coding: Coding,
        channels: &[&StoredChannel],
    ) -> CertifiedError {
        let names = |group: std::ops::Range<usize>| {
            channels.get(group).unwrap_or_default().iter().map(|channel| channel.name.clone()).collect()
        };
        let each = self.maps.iter().zip(groups(spec.kind)).map(|(map, group)| {
            let Summaries { all, clear } = self.summaries(&|pixel| map.at(pixel));
            ChannelBounds { all, base: map.base(), clear, map: map.encode(), names: names(group) }
        });
        CertifiedError {
            ambiguous: Ambiguous { map: self.ambiguous.encode(), pixels: self.ambiguous.count() },
            channels: each.collect(),
            display: self.displayed(space, coding, channels).filter(|_| spec.kind == Kind::Color),
            unit: unit(spec.kind, space),
        }
    }

    /// Returns the bounds in display values, by those in the working space and by the colors in the file.
    fn displayed(&self, space: WorkingSpace, coding: Coding, channels: &[&StoredChannel]) -> Option<DisplayBounds> {
        let ([map], [r, g, b]) = (&self.maps[..], channels) else { return None };
        let stored = |pixel: usize| [r, g, b].map(|c| before_rounding(c.stored, c.plane.samples()[pixel]));
        let bounds = (0..self.window.area()).map(|pixel| match map.at(pixel) {
            PixelBound::AtMost(level) => {
                PixelBound::of(coding.displayed(space, stored(pixel), super::level::bound_of(level)))
            }
            bound => bound,
        });
        let bounds: Vec<PixelBound> = bounds.collect();
        let Summaries { all, clear } = self.summaries(&|pixel| bounds[pixel]);
        Some(DisplayBounds { all, clear, unit: "display value from 0 to 1 (sRGB)".into() })
    }

    fn summaries(&self, at: &dyn Fn(usize) -> PixelBound) -> Summaries {
        Summaries { all: self.summary(at, &|_| true), clear: self.summary(at, &|pixel| !self.is_ambiguous(pixel)) }
    }

    /// Summarizes the bounds of some pixels.
    fn summary(&self, at: &dyn Fn(usize) -> PixelBound, of: &dyn Fn(usize) -> bool) -> BoundSummary {
        let pixels = || (0..self.window.area()).filter(|pixel| of(*pixel));
        let (mut infinite, mut unbounded) = (0, 0);
        let mut levels: Vec<Option<i32>> = Vec::new();
        for pixel in pixels() {
            match at(pixel) {
                PixelBound::Exact => levels.push(None),
                PixelBound::AtMost(level) => levels.push(Some(level)),
                PixelBound::Infinite => infinite += 1,
                PixelBound::Unknown => unbounded += 1,
            }
        }
        levels.sort_unstable();
        let bounded = levels.len();
        let exceeded_by = |count: usize| {
            let level = *levels.get(bounded.checked_sub(1 + count)?)?;
            let bound = level.map_or(PixelBound::Exact, PixelBound::AtMost);
            let pixel = pixels().find(|pixel| at(*pixel) == bound)?;
            Some(BoundAt { bound: bound.size(), pixel: self.place(pixel) })
        };
        BoundSummary {
            bounded: bounded as u64,
            infinite,
            max: exceeded_by(0),
            p999: exceeded_by(bounded / 1000),
            unbounded,
        }
    }

    fn place(&self, pixel: usize) -> [i64; 2] {
        let width = self.window.width();
        [self.window.x0 + (pixel % width) as i64, self.window.y0 + (pixel / width) as i64]
    }
}

/// Returns the unit of an output's values and of their errors.
pub fn unit(kind: Kind, space: WorkingSpace) -> String {
    match kind {
        Kind::Color => format!("channel of a color in {}", space.name()),
        Kind::Weights(_) => "weight from 0 to 1".into(),
        _ => "unit of the field".into(),
    }
}
