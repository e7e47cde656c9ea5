//! Depth of other renderers: which pixels see nothing, and whether it is measured along the camera's axis or the ray.

use super::{ExactLines, Recipe, Stream};
use crate::geometry::Up;
use trochoid_graph::{Choice, NodeError};
use trochoid_image::Window;
use trochoid_memory::Scratch;
use trochoid_scene::{Camera, DVec3, Projection};

/// A renderer whose conventions hold for knobs that are not set.
#[derive(Clone, Copy, Debug, PartialEq, Choice)]
pub(crate) enum Convention {
    Blender,
    Mitsuba,
}

impl Convention {
    /// Returns the axis that points up.
    pub(crate) fn up(self) -> Up {
        match self {
            Self::Blender => Up::Z,
            Self::Mitsuba => Up::Y,
        }
    }

    /// Returns the planar depth at which distances along the ray begin, in units of the file.
    pub(crate) fn near(self) -> f64 {
        match self {
            Self::Blender => 0.0,
            // The default of its cameras' near clipping plane.
            Self::Mitsuba => 0.01,
        }
    }

    /// Returns what depth measures.
    pub(crate) fn depth_is(self) -> DepthIs {
        match self {
            Self::Blender => DepthIs::Planar,
            Self::Mitsuba => DepthIs::Distance,
        }
    }
}

/// What a depth pass measures.
#[derive(Clone, Copy, Debug, PartialEq, Choice)]
pub(crate) enum DepthIs {
    /// The distance along the camera's axis.
    Planar,
    /// The distance along the ray.
    Distance,
}

/// Which pixels see nothing.
#[derive(Clone, Copy, Debug, PartialEq, Choice)]
pub(crate) enum Misses {
    Auto,
    Far,
    Zero,
    None,
}

impl Misses {
    /// Whether a depth in meters is that of a pixel that sees nothing.
    pub(crate) fn has_depth(self, depth: f64, far: f64) -> bool {
        match self {
            Self::Auto => depth == 0.0 || depth >= far,
            Self::Far => depth >= far,
            Self::Zero => depth == 0.0 || depth == f64::INFINITY,
            Self::None => false,
        }
    }

    /// Whether the normal (0, 0, 0) is that of a pixel that sees nothing, in a file without depth.
    pub(crate) fn has_no_normal(self, packed: bool) -> bool {
        match self {
            // A painted map has no convention for them.
            Self::Auto => !packed,
            Self::Zero => true,
            Self::Far | Self::None => false,
        }
    }
}

/// The rays of a perspective camera through the pixels of a file.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Sight {
    position: DVec3,
    forward: DVec3,
    display: Window,
    /// Pixels per tangent of 1.
    per_tangent: f64,
    /// Conversion of stored positions to meters with y up.
    up: Up,
    scale: f64,
}

impl Sight {
    /// Returns the sight of a camera in pictures with this display window; `None` if its rays are parallel, since then
    /// both kinds of depth are the same.
    pub(crate) fn new(camera: &Camera, display: Window, up: Up, scale: f64) -> Option<Self> {
        let Projection::Perspective { fov } = camera.projection else { return None };
        let forward = (camera.target - camera.position).try_normalize().unwrap_or(DVec3::NEG_Z);
        let per_tangent = display.width() as f64 / 2.0 / libm::tan(fov / 2.0);
        Some(Self { position: camera.position, forward, display, per_tangent, up, scale })
    }

    /// Returns a stored position as seen from the camera, in meters.
    fn seen(&self, point: [f32; 3]) -> DVec3 {
        DVec3::from(self.up.to_y_up(point.map(f64::from))) * self.scale - self.position
    }

    /// Returns the planar depth of a point at a distance of 1 on the ray through the middle of a pixel.
    fn of_middle(&self, [x, y]: [i64; 2]) -> f64 {
        let Window { x0, y0, .. } = self.display;
        let from_center = |at: i64, first: i64, size: usize| (at - first) as f64 + 0.5 - size as f64 / 2.0;
        let across = from_center(x, x0, self.display.width()) / self.per_tangent;
        let down = from_center(y, y0, self.display.height()) / self.per_tangent;
        1.0 / libm::sqrt(1.0 + across * across + down * down)
    }

    /// Returns the planar depth of a point at a distance of 1 on the ray through a stored position, which need not lead
    /// through the middle of its pixel; `None` if it is not before the camera.
    fn of_point(&self, point: [f32; 3]) -> Option<f64> {
        let seen = self.seen(point);
        let ratio = seen.dot(self.forward) / seen.length();
        (ratio > 0.0 && ratio <= 1.0 + 1e-9).then_some(ratio.min(1.0))
    }
}

/// How well stored depths fit stored positions.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Told {
    /// Median of the relative differences from planar depths.
    pub(crate) from_planar: f64,
    /// Median of those from distances along the ray, which begin at `near`.
    pub(crate) from_distance: f64,
    /// Planar depth at which distances begin; `None` if depths are not accurate enough to tell.
    pub(crate) near: Option<f64>,
}

/// Rows and columns whose pixels are compared.
const ROWS: usize = 16;
const COLUMNS: usize = 64;

/// Smallest relative difference of the two kinds of depth in a pixel that tells them apart, and the least number of
/// such pixels.
const APART: f64 = 2e-3;
const FEWEST: usize = 12;

/// Largest median of a kind that fits: half floats differ by 5e-4. The other kind must differ by several times as much,
/// so that a camera that is slightly off decides nothing.
const FITS: f64 = 1e-2;
const CLEARLY: f64 = 3.0;

/// Largest median that tells where distances begin, and how many times it must be smaller than without.
const EXACTLY: f64 = 1e-4;
const BETTER: f64 = 10.0;

impl Told {
    /// Compares depths with positions at pixels all over the picture; `None` if too few of them tell anything.
    /// Both streams hold stored samples of the same data window.
    ///
    /// # Errors
    /// A row cannot be decoded.
    pub(crate) fn new(
        [depth, position]: [&Stream; 2],
        sight: &Sight,
        is_miss: impl Fn(f64) -> bool,
    ) -> Result<Option<Self>, NodeError> {
        let data = depth.stored.data;
        if position.stored.data != data {
            return Ok(None);
        }
        let mut compared: Vec<[f64; 3]> = Vec::new();
        let places = |count: usize, most: usize| {
            let taken = count.min(most);
            (0..taken).map(move |index| (2 * index + 1) * count / (2 * taken))
        };
        for row in places(data.height(), ROWS) {
            let mut depths = Vec::new();
            depth.each_row(row..row + 1, |rows| {
                depths.clone_from(&rows[0]);
                Ok(())
            })?;
            position.each_row(row..row + 1, |rows| {
                for at in places(data.width(), COLUMNS) {
                    let stored = f64::from(depths[at]) * sight.scale;
                    let seen = sight.seen([0, 1, 2].map(|axis| rows[axis][at]));
                    let (planar, distance) = (seen.dot(sight.forward), seen.length());
                    let counts = !is_miss(stored) && stored > 0.0 && stored.is_finite() && distance.is_finite();
                    if counts && planar > 0.0 && distance - planar >= APART * distance {
                        compared.push([stored, planar, distance]);
                    }
                }
                Ok(())
            })?;
        }
        Ok((compared.len() >= FEWEST).then(|| Self::of(&compared)))
    }

    /// Compares stored depths with the planar depths and the distances of positions, of which there is one at least.
    fn of(compared: &[[f64; 3]]) -> Self {
        let median = |of: &dyn Fn(&[f64; 3]) -> f64| {
            let mut all: Vec<f64> = compared.iter().map(of).collect();
            all.sort_unstable_by(f64::total_cmp);
            all[all.len() / 2]
        };
        let from_planar = median(&|[stored, planar, _]| (stored - planar).abs() / stored);
        // Distances are longer by near/cos if they begin at the camera.
        let begin = median(&|[stored, planar, distance]| planar - stored * planar / distance);
        let from = |near: f64| {
            median(&|[stored, planar, distance]| (stored - distance + near * distance / planar).abs() / stored)
        };
        let [whole, shorter] = [from(0.0), from(begin)];
        let (from_distance, near) = if begin > 0.0 && shorter <= EXACTLY && BETTER * shorter < whole {
            (shorter, Some(begin))
        } else {
            (whole, (whole <= EXACTLY).then_some(0.0))
        };
        Self { from_planar, from_distance, near }
    }

    /// Returns the kind that fits; `None` if neither does clearly.
    pub(crate) fn kind(&self) -> Option<DepthIs> {
        let (planar, distance) = (self.from_planar, self.from_distance);
        let fits = |own: f64, other: f64| own <= FITS && CLEARLY * own < other;
        if fits(planar, distance) { Some(DepthIs::Planar) } else { fits(distance, planar).then_some(DepthIs::Distance) }
    }

    /// Returns what users should know, as a sentence; `None` if depth is planar and counts as that.
    pub(crate) fn note(&self, stated: Option<DepthIs>) -> Option<String> {
        let percent = |part: f64| format!("{:.2} %", 100.0 * part);
        let (planar, distance) = (percent(self.from_planar), percent(self.from_distance));
        let found = format!(
            "half of the depths are within {planar} of planar ones, and within {distance} of distances along the ray"
        );
        match (self.kind(), stated) {
            (Some(DepthIs::Planar), None | Some(DepthIs::Planar)) => None,
            (Some(DepthIs::Distance), Some(DepthIs::Distance)) => None,
            (Some(DepthIs::Distance), None) => {
                let begins = match self.near {
                    Some(near) if near > 0.0 => format!(" from a depth of {near:.4} m on"),
                    _ => String::new(),
                };
                Some(format!("Depth is measured along the ray{begins}, and is converted: {found}."))
            }
            (Some(kind), Some(stated)) => Some(format!(
                "Depth is read as \"{}\", but positions tell that it is \"{}\": {found}.",
                stated.word(),
                kind.word()
            )),
            (None, _) => Some(format!(
                "Depth does not fit the positions as seen from the camera: {found}. Compare camera, \"up\" and \"scale\" \
                 with the renderer's."
            )),
        }
    }
}

/// Recipe for planar depth in meters with nothing at infinity, and for the coverage that follows from it. Stored are
/// the depth and, if the ray through each position counts, its three components.
pub(crate) struct Depths {
    pub(crate) far: f64,
    pub(crate) misses: Misses,
    /// Meters in the file's unit.
    pub(crate) scale: f64,
    /// Planar depth at which distances along rays begin.
    pub(crate) near: f64,
    /// Rays along which depth is measured; `None` if it is planar.
    pub(crate) along: Option<Sight>,
}

impl Depths {
    /// Returns the depth of a pixel, from its stored samples.
    fn value(&self, at: [i64; 2], depth: f32, point: Option<[f32; 3]>) -> f64 {
        let depth = f64::from(depth) * self.scale;
        if self.misses.has_depth(depth, self.far) {
            return f64::INFINITY;
        }
        let Some(sight) = &self.along else { return depth };
        depth * point.and_then(|point| sight.of_point(point)).unwrap_or_else(|| sight.of_middle(at)) + self.near
    }

    /// Returns the depths of a line, and where nothing is seen.
    fn values(&self, [x, y]: [i64; 2], lines: &[&[f32]]) -> Scratch<f64> {
        let depths = lines.first().copied().unwrap_or_default();
        let point = |index: usize| match lines[1..] {
            [x, y, z, ..] => Some([x[index], y[index], z[index]]),
            _ => None,
        };
        depths
            .iter()
            .enumerate()
            .map(|(index, depth)| self.value([x + index as i64, y], *depth, point(index)))
            .collect()
    }

    /// Returns the coverage of a pixel of this depth.
    fn covers(&self, depth: f64) -> f64 {
        if depth == f64::INFINITY && self.misses != Misses::None { 0.0 } else { 1.0 }
    }
}

impl Recipe for Depths {
    fn apply(&self, at: [i64; 2], lines: &mut [&mut [f32]]) -> Result<u64, NodeError> {
        let depths = self.values(at, &lines.iter().map(|line| &**line).collect::<Scratch<_>>());
        let mut lines = lines.iter_mut();
        let (Some(depth), mut coverage) = (lines.next(), lines.next()) else { return Ok(0) };
        for (index, (depth, value)) in depth.iter_mut().zip(&depths).enumerate() {
            if let Some(coverage) = &mut coverage {
                coverage[index] = self.covers(*value) as f32;
            }
            *depth = *value as f32;
        }
        Ok(0)
    }

    fn exact(&self) -> Option<ExactLines<'_>> {
        if self.along.is_none() && self.scale == 1.0 {
            // Depths are as stored.
            return None;
        }
        Some(Box::new(move |at, lines| {
            let depths = self.values(at, lines);
            let coverage = depths.iter().map(|depth| self.covers(*depth)).collect();
            vec![depths.to_vec(), coverage]
        }))
    }
}
