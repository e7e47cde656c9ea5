use std::sync::{Arc, Mutex, OnceLock, PoisonError};

use glam::DVec3;
use trochoid_image::Window;
use trochoid_memory::Scratch;
use trochoid_sea::{PreciseSea, Sea, SeaFrame};

use crate::extent::{Bounds, Sector, Strip};
use crate::first_hit::KeptCells;
use crate::followed::follow_sea;
use crate::footprint::least_footprint;
use crate::meet_near::{leads_to, meet_sea};
use crate::points::MeshHit;
use crate::sea_point::Limits;
use crate::spacing::Spacing;
use crate::surface::{Anchor, Asked, GivenUp, Hit, Mesh, Met, Sight, Surface};
use crate::{ChannelSet, Projector, Ray, Resting, reference, tessellate};

/// An endless sea at one time.
#[derive(Clone, Debug)]
pub struct SeaSurface {
    pub(crate) frame: SeaFrame,
    pub(crate) level: f64,
    pub(crate) bounds: Bounds,
    /// Height in meters that no phases can exceed: Σ|a|.
    pub(crate) summit: f64,
    /// Horizontal displacement in meters that no phases can exceed: Σ|h|.
    pub(crate) drift: f64,
    spacing: Spacing,
    /// Side of a pixel divided by that of the footprint by which waves are filtered.
    pub(crate) detail: f64,
    /// The waves for sums in f64, made when first needed.
    precise: Arc<OnceLock<PreciseSea>>,
    limits: Arc<OnceLock<Limits>>,
    /// Cells for the rays of cameras.
    pub(crate) cells: Arc<KeptCells>,
    /// Whether the cameras of some views are under water: every ray that meets the sea asks, and finding out takes
    /// several sums.
    submerged: Arc<Mutex<Vec<(Projector, bool)>>>,
}

/// Number of waves that the pixels of a picture resolve; of all others, less than 1e-6 is left after filtering.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Resolved {
    /// Number at the vertices that resolve the most.
    pub most: usize,
    /// Mean over all vertices.
    pub mean: f64,
    /// Number of all waves.
    pub of: usize,
}

/// Standard deviations of the displacement that the search for visible points allows for: in a normal distribution, 4
/// points in 100 million lie beyond.
const DEVIATIONS: f64 = 5.5;

/// Standard deviations of the height above which few points rise: one in forty.
const USUAL: f64 = 2.0;

/// Most steps that invert the horizontal displacement, the error relative to 1 m + distance at which they end, and
/// the least eigenvalue that they use.
const STEPS: usize = 64;
const CLOSE: f64 = 1e-12;
const LEAST: f64 = 0.5;

/// Number of views whose cameras are remembered to be under water or not.
const VIEWS: usize = 8;

impl SeaSurface {
    /// Most vertices of one sea per pixel of the picture; beyond this limit the spacing is increased.
    ///
    /// Near crests the spacing that the error limits require is finer than a picture can show. At this limit, samples
    /// of a stormy sea at 1920 × 1080 are off by 0.04 of an 8-bit step on average, and two in a thousand, at contours, by
    /// more than one; twice as many vertices halve that.
    pub const VERTICES_PER_PIXEL: f64 = 0.75;

    /// Returns the sea at a time in seconds, with its rest level at world y = `level`.
    pub fn new(sea: &Sea, time: f64, level: f64) -> Self {
        let bounds = Bounds {
            rise: sea.height_bound().min(DEVIATIONS * sea.height_rms()),
            reach: sea.horizontal_bound().min(DEVIATIONS * sea.horizontal_rms()),
            usual: sea.height_bound().min(USUAL * sea.height_rms()),
        };
        Self {
            frame: sea.at(time),
            level,
            bounds,
            summit: sea.height_bound(),
            drift: sea.horizontal_bound(),
            spacing: Spacing::new(sea),
            detail: 1.0,
            precise: Arc::default(),
            limits: Arc::default(),
            cells: Arc::default(),
            submerged: Arc::default(),
        }
    }

    /// Returns the sea for sums in f64.
    pub(crate) fn precise(&self) -> &PreciseSea {
        self.precise.get_or_init(|| PreciseSea::new(&self.frame))
    }

    /// Returns the limits of the derivatives of the displacement.
    pub(crate) fn limits(&self) -> &Limits {
        self.limits.get_or_init(|| Limits::new(self.precise()))
    }

    /// Draws the sea as for pixels `detail` times as fine: half the detail has a quarter of the vertices, and waves
    /// that two pixels cannot resolve become roughness.
    #[must_use]
    pub fn with_detail(self, detail: f64) -> Self {
        // What was found out for another detail does not hold any more.
        Self { detail, cells: Arc::default(), submerged: Arc::default(), ..self }
    }

    /// Returns whether a camera is under water.
    pub(crate) fn submerges(&self, projector: &Projector) -> bool {
        // Only whole entries are pushed, so the list may be used after a panic.
        let mut known = self.submerged.lock().unwrap_or_else(PoisonError::into_inner);
        if let Some((_, is)) = known.iter().find(|(view, _)| view == projector) {
            return *is;
        }
        let is = reference::submerged(self, projector);
        if known.len() == VIEWS {
            known.remove(0);
        }
        known.push((*projector, is));
        is
    }

    /// Returns the footprint in meters by which waves are filtered where a camera sees a rest point.
    pub(crate) fn footprint(&self, projector: &Projector, rest: DVec3) -> f64 {
        crate::footprint(projector, rest) / self.detail
    }

    /// Returns a lower bound of the footprints, in meters, of the rest points in a range of distances ahead of the
    /// camera.
    pub(crate) fn least_footprint(&self, projector: &Projector, ahead: [f64; 2]) -> f64 {
        least_footprint(projector, self.level, ahead) / self.detail
    }

    /// Returns how many waves a tessellation for this camera sums; `None` if the sea is not in the picture.
    pub fn resolved(&self, projector: &Projector) -> Option<Resolved> {
        let rows = if projector.orthographic {
            vec![self.frame.resolved(self.footprint(projector, DVec3::new(0.0, self.level, 0.0)))]
        } else {
            let sector = Sector::new(projector, self.level, self.bounds)?;
            tessellate::resolved(self, &self.spacing, projector, &sector)
        };
        let mean = rows.iter().sum::<usize>() as f64 / rows.len().max(1) as f64;
        Some(Resolved { most: rows.into_iter().max()?, mean, of: self.frame.len() })
    }

    /// Returns world y of the rest level, in meters.
    pub fn level(&self) -> f64 {
        self.level
    }

    /// Returns the sea at its time.
    pub fn frame(&self) -> &SeaFrame {
        &self.frame
    }

    /// Returns the point of the surface that rests at (x, z), its normal (not normalized) and lost slope variance, in
    /// f64.
    pub fn point(&self, rest: [f64; 2], footprint: f64) -> (DVec3, DVec3, f64) {
        let sample = self.frame.evaluate(rest, footprint);
        let position = DVec3::new(rest[0], self.level, rest[1]) + DVec3::from(sample.displacement);
        (position, DVec3::from(sample.normal()), sample.slope_variance)
    }

    /// Returns the rest point that is carried to a position x, z, under a footprint in meters.
    ///
    /// This is the fixed point of p₀ = p − D(p₀), found by Newton's method from p itself: with H = I + ∂D, p₀ changes
    /// by H⁻¹(p − p₀ − D). Eigenvalues of H are raised to at least ½, so that steps stay finite near and within
    /// folds; they never lead beyond the reach of D, and depend only on p and time, continuously. Where the sea does
    /// not fold they converge; in a fold they settle near one of its sheets.
    pub(crate) fn rest_above(&self, place: [f64; 2], footprint: f64) -> [f64; 2] {
        let mut moved = [0.0; 2];
        for _ in 0..STEPS {
            let rest = [place[0] + moved[0], place[1] + moved[1]];
            let sample = self.frame.evaluate(rest, footprint);
            let error = [-moved[0] - sample.displacement[0], -moved[1] - sample.displacement[2]];
            if libm::hypot(error[0], error[1]) <= CLOSE * (1.0 + libm::hypot(place[0], place[1])) {
                break;
            }
            let step = inverse(sample.strain, error);
            moved = [moved[0] + step[0], moved[1] + step[1]];
            let beyond = libm::hypot(moved[0], moved[1]) / self.drift;
            if beyond > 1.0 {
                moved = moved.map(|along| along / beyond);
            }
        }
        [place[0] + moved[0], place[1] + moved[1]]
    }
}

/// Applies H⁻¹ to a vector, with H = I + the strains and its eigenvalues raised to at least [`LEAST`].
///
/// A function f of a symmetric matrix with eigenvalues low and high is αI + βH with β = (f(high) − f(low))/(high −
/// low).
fn inverse([xx, xz, zz]: [f64; 3], [x, z]: [f64; 2]) -> [f64; 2] {
    let (middle, radius) = (1.0 + (xx + zz) / 2.0, libm::hypot((xx - zz) / 2.0, xz));
    let f = |eigenvalue: f64| 1.0 / eigenvalue.max(LEAST);
    let (low, high) = (middle - radius, middle + radius);
    let beta = if radius > 1e-9 { (f(high) - f(low)) / (2.0 * radius) } else { 0.0 };
    let alpha = f(low) - beta * low;
    [alpha * x + beta * ((1.0 + xx) * x + xz * z), alpha * z + beta * (xz * x + (1.0 + zz) * z)]
}

impl Surface for SeaSurface {
    fn tessellate(&self, projector: &Projector, wanted: ChannelSet) -> Mesh {
        self.tessellate_unless(projector, wanted, &|| false).unwrap_or_else(|| Mesh::empty(self.level))
    }

    fn tessellate_unless(
        &self,
        projector: &Projector,
        wanted: ChannelSet,
        stop: &(dyn Fn() -> bool + Sync),
    ) -> Option<Mesh> {
        self.tessellate_part(projector, wanted, None, stop)
    }

    fn tessellate_part(
        &self,
        projector: &Projector,
        wanted: ChannelSet,
        part: Option<Window>,
        stop: &(dyn Fn() -> bool + Sync),
    ) -> Option<Mesh> {
        let mesh = if projector.orthographic {
            Strip::new(projector, self.level, self.bounds, tessellate::strip_depth(self, &self.spacing, projector))
                .map(|strip| tessellate::strip(self, &self.spacing, projector, &strip, wanted, part, stop))
        } else {
            Sector::new(projector, self.level, self.bounds)
                .map(|sector| tessellate::sector(self, &self.spacing, projector, &sector, wanted, part, stop))
        };
        mesh.unwrap_or_else(|| Some(Mesh::empty(self.level)))
    }

    fn prepare_rays(&self, projector: &Projector, stop: &(dyn Fn() -> bool + Sync)) {
        self.cells.prepare(self, projector, stop);
    }

    fn first(&self, projector: &Projector, ray: &Ray, end: f64, asked: Asked) -> Sight {
        reference::first_of_sea(self, projector, ray, end, asked)
    }

    fn meet_near(&self, projector: &Projector, ray: &Ray, near: &MeshHit) -> Option<Hit> {
        meet_sea(self, projector, ray, near)
    }

    fn leads_to(&self, projector: &Projector, ray: &Ray, near: &MeshHit, met: &Met) -> bool {
        leads_to(self, projector, ray, near, met)
    }

    fn follow(&self, projector: &Projector, mesh_hits: &[(Ray, MeshHit)]) -> Scratch<Option<Hit>> {
        follow_sea(self, projector, mesh_hits)
    }

    fn trace(&self, projector: &Projector, ray: &Ray, end: f64) -> Result<Option<Hit>, GivenUp> {
        reference::trace_sea(self, projector, ray, end)
    }

    fn as_sea(&self) -> Option<&SeaSurface> {
        Some(self)
    }

    fn height_at(&self, place: [f64; 2], footprint: f64) -> Option<f64> {
        let rest = self.rest_above(place, footprint);
        Some(self.level + self.frame.evaluate(rest, footprint).displacement[1])
    }

    fn anchors(&self, uv: [f64; 2]) -> Vec<Anchor> {
        let sample = self.frame.evaluate(uv, 0.0);
        let ([xx, xz, zz], [yx, yz]) = (sample.strain, sample.slope);
        vec![Anchor {
            point: self.point(uv, 0.0).0,
            along_u: DVec3::new(1.0 + xx, yx, xz),
            along_v: DVec3::new(xz, yz, 1.0 + zz),
        }]
    }

    fn resting(&self) -> Option<&dyn Resting> {
        Some(self)
    }
}
