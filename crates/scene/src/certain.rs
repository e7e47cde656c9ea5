//! Determines where it is certain what a camera sees, and what it sees there.

use crate::reference::seas_last;
use crate::surface::{Asked, Hit, Met, Sight, Surface};
use crate::{Camera, Projector};
use trochoid_image::Format;

/// What the samples of a view certainly see of the continuous surfaces, without any mesh.
///
/// ```
/// use trochoid_image::Format;
/// use trochoid_scene::{Asked, Camera, Certain, DVec3, Projection, SeaSurface, Sight};
/// use trochoid_sea::{GerstnerSpectrum, Sea};
///
/// let sea = Sea::new(GerstnerSpectrum { count: 20, ..GerstnerSpectrum::default() }.waves()?);
/// let surface = SeaSurface::new(&sea, 0.0, 0.0);
/// let camera = Camera {
///     position: DVec3::new(0.0, 6.0, 30.0),
///     target: DVec3::new(0.0, 2.0, 0.0),
///     roll: 0.0,
///     projection: Projection::Perspective { fov: 0.7 },
/// };
/// let format = Format::new(64, 36, 1)?;
/// let certain = Certain::new(&camera, &[&surface], format, &|| false).ok_or("stopped")?;
/// let low = [32, 35];
/// let sights = certain.sights(&[&surface], &[low], format.sample_offset(0), Asked::Values);
/// assert!(sights[0].hit().is_some_and(|hit| hit.distance < 60.0));
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
#[derive(Clone, Copy, Debug)]
pub struct Certain {
    projector: Projector,
}

impl Certain {
    /// Prepares the surfaces for the rays of a view; `None` soon after `stop` first says that the result is no longer
    /// needed.
    pub fn new(
        camera: &Camera,
        surfaces: &[&dyn Surface],
        format: Format,
        stop: &(dyn Fn() -> bool + Sync),
    ) -> Option<Self> {
        let projector = camera.projector(format);
        surfaces.iter().for_each(|surface| surface.prepare_rays(&projector, stop));
        (!stop()).then_some(Self { projector })
    }

    /// Returns what a sample of each of these pixels sees, at `offset` from its pixel's upper left corner.
    ///
    /// Each result depends only on its own sample. The surfaces must be those that were prepared.
    pub fn sights(&self, surfaces: &[&dyn Surface], pixels: &[[i64; 2]], offset: [f64; 2], asked: Asked) -> Vec<Sight> {
        pixels.iter().map(|&[x, y]| self.sight(surfaces, [x as f64 + offset[0], y as f64 + offset[1]], asked)).collect()
    }

    fn sight(&self, surfaces: &[&dyn Surface], [x, y]: [f64; 2], asked: Asked) -> Sight {
        let ray = self.projector.ray(x, y);
        let mut nearest = Sight::Nothing;
        // Seas last: what lies in front of them limits their search.
        for (index, surface) in seas_last(surfaces) {
            // What lies within the errors of both cannot be told apart.
            let ends = nearest.met().map(|met| [met.hit.distance - met.deep, met.hit.distance + met.deep]);
            let [near, end] = ends.unwrap_or([f64::INFINITY; 2]);
            match surface.first(&self.projector, &ray, end, asked) {
                Sight::Unclear => return Sight::Unclear,
                Sight::Nothing => {}
                Sight::Point(met) if met.hit.distance + met.deep > near => return Sight::Unclear,
                Sight::Point(met) => nearest = Sight::Point(Met { hit: Hit { surface: index, ..met.hit }, ..met }),
            }
        }
        nearest
    }
}
