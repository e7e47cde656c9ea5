//! The slow f64 definition of what a camera sees: the continuous surfaces, without any tessellation.

use glam::DVec3;
use trochoid_image::Format;
use trochoid_sea::Sample;

use crate::extent::HORIZON_M;
use crate::first_hit::{First, FirstPoint, NoCells, Shape, Thoroughness};
use crate::first_point::first_point;
use crate::shading::unit_or_up;
use crate::surface::{Asked, GivenUp, Hit, Met, Sight, Surface};
use crate::{Camera, Projector, Ray, SeaSurface};

/// Returns what a camera sees at (`x`, `y`) pixels from the upper left corner: the nearest hit of all surfaces.
///
/// # Errors
/// A surface is too rough along the ray.
pub fn trace(
    camera: &Camera,
    surfaces: &[&dyn Surface],
    format: Format,
    x: f64,
    y: f64,
) -> Result<Option<Hit>, GivenUp> {
    let projector = camera.projector(format);
    let ray = projector.ray(x, y);
    let mut nearest: Option<Hit> = None;
    // Seas last: what lies in front of them limits their search.
    for (index, surface) in seas_last(surfaces) {
        let end = nearest.map_or(f64::INFINITY, |hit| hit.distance);
        let hit = surface.trace(&projector, &ray, end)?.map(|hit| Hit { surface: index, ..hit });
        nearest = hit.or(nearest);
    }
    Ok(nearest)
}

/// Returns the surfaces and their indices, in an order in which those whose rays cost most come last.
pub(crate) fn seas_last<'s>(surfaces: &'s [&dyn Surface]) -> impl Iterator<Item = (usize, &'s dyn Surface)> {
    let of = move |is_sea: bool| {
        let all = surfaces.iter().copied().enumerate();
        all.filter(move |(_, surface)| surface.as_sea().is_some() == is_sea)
    };
    of(false).chain(of(true))
}

/// Number of Newton steps that invert the horizontal displacement at one point.
const INVERSIONS: usize = 24;

/// Returns the range of distances in which a ray may meet a sea; `None` if it cannot.
fn within_slab(sea: &SeaSurface, ray: &Ray) -> Option<[f64; 2]> {
    let (rise, height) = (sea.summit, ray.origin.y - sea.level);
    let slope = ray.direction.y;
    // There is no surface outside of the slab of heights that waves reach.
    let (start, end) = if slope == 0.0 {
        if height.abs() > rise || rise == 0.0 {
            return None;
        }
        (0.0, HORIZON_M)
    } else {
        let (a, b) = ((-rise - height) / slope, (rise - height) / slope);
        (a.min(b).max(0.0), a.max(b))
    };
    let horizontal = libm::sqrt((ray.direction.x * ray.direction.x + ray.direction.z * ray.direction.z).max(0.0));
    let end = end.min(HORIZON_M / horizontal.max(1e-9));
    (start <= end).then_some([start, end])
}

/// Returns the first point where a ray passes through the displaced sea before a distance, considering all sheets where
/// it folds.
pub(crate) fn trace_sea(sea: &SeaSurface, projector: &Projector, ray: &Ray, end: f64) -> Result<Option<Hit>, GivenUp> {
    let Some(range) = within_slab(sea, ray).and_then(|range| before(range, end)) else { return Ok(None) };
    let found = match sea.cells.of(projector).as_deref() {
        Some(Ok(cells)) => cells.first(sea, projector, ray, range, Thoroughness::Thorough),
        // What is too rough for cells is too rough for the search of each ray of a picture.
        Some(Err(NoCells::TooMany)) => First::Unknown,
        Some(Err(NoCells::Unseen | NoCells::Stopped)) | None => First::Beyond,
    };
    let found = match found {
        First::Nothing => None,
        First::At(FirstPoint { distance, rest, .. }) => Some((distance, rest)),
        First::Unknown => return Err(GivenUp),
        First::Beyond => first_point(sea, projector, ray, range)?,
    };
    let found = found.filter(|(distance, _)| *distance < end);
    Ok(found.map(|(distance, rest)| hit(sea, projector, ray, distance, rest)))
}

/// Returns the part of a range of distances before an end.
fn before([start, last]: [f64; 2], end: f64) -> Option<[f64; 2]> {
    (start < end).then_some([start, last.min(end)])
}

/// Returns what a camera's ray meets of a sea before a distance, if the cells that were made for the camera tell.
pub(crate) fn first_of_sea(sea: &SeaSurface, projector: &Projector, ray: &Ray, end: f64, asked: Asked) -> Sight {
    let Some(range) = within_slab(sea, ray).and_then(|range| before(range, end)) else { return Sight::Nothing };
    let effort = match asked {
        Asked::Surface => Thoroughness::Rough,
        Asked::Nearly => Thoroughness::Near,
        Asked::Values => Thoroughness::Quick,
    };
    let found = match sea.cells.of(projector).as_deref() {
        Some(Ok(cells)) => cells.first(sea, projector, ray, range, effort),
        Some(Err(NoCells::Unseen)) => First::Nothing,
        Some(Err(NoCells::TooMany | NoCells::Stopped)) | None => First::Unknown,
    };
    match found {
        First::Nothing => Sight::Nothing,
        // The sample is within 1e-14 of the plain sum.
        First::At(FirstPoint { distance, rest, shape, off, deep, sheet, .. }) if distance - deep < end => {
            let shape = shape.unwrap_or(Shape { normal: DVec3::Y, slope_variance: 0.0 });
            let hit = hit_of_shape(sea, projector, ray, distance, rest, shape, sea.submerges(projector));
            Sight::Point(Met { hit, off, deep, sheet })
        }
        First::At(..) => Sight::Nothing,
        First::Unknown | First::Beyond => Sight::Unclear,
    }
}

/// Returns whether a camera is under water: below the point of the sea that is carried above or below it. Slow;
/// [`SeaSurface::submerges`] remembers it.
pub(crate) fn submerged(sea: &SeaSurface, projector: &Projector) -> bool {
    let eye = projector.position;
    if (eye.y - sea.level).abs() > sea.summit {
        return eye.y < sea.level;
    }
    let rest = rest_below(sea, projector, eye, [eye.x, eye.z]);
    let print = sea.footprint(projector, DVec3::new(rest[0], sea.level, rest[1]));
    eye.y - sea.level < sea.frame.evaluate(rest, print).displacement[1]
}

/// Returns the rest point that is carried above or below `point`, by Newton's method on p₀ + D(p₀) = p from a guess.
fn rest_below(sea: &SeaSurface, projector: &Projector, point: DVec3, guess: [f64; 2]) -> [f64; 2] {
    let mut rest = guess;
    for _ in 0..INVERSIONS {
        let print = sea.footprint(projector, DVec3::new(rest[0], sea.level, rest[1]));
        let sample = sea.frame.evaluate(rest, print);
        let error = [rest[0] + sample.displacement[0] - point.x, rest[1] + sample.displacement[2] - point.z];
        if libm::hypot(error[0], error[1]) <= 1e-11 * (1.0 + libm::hypot(point.x, point.z)) {
            break;
        }
        // Steps with the inverse Jacobian would grow without bound near a fold; plain steps are used there.
        let [xx, xz, zz] = sample.strain;
        let jacobian = sample.jacobian();
        let step = if jacobian > 0.1 {
            [((1.0 + zz) * error[0] - xz * error[1]) / jacobian, ((1.0 + xx) * error[1] - xz * error[0]) / jacobian]
        } else {
            [error[0] * 0.5, error[1] * 0.5]
        };
        rest = [rest[0] - step[0], rest[1] - step[1]];
    }
    rest
}

fn hit(sea: &SeaSurface, projector: &Projector, ray: &Ray, distance: f64, rest: [f64; 2]) -> Hit {
    let print = sea.footprint(projector, DVec3::new(rest[0], sea.level, rest[1]));
    hit_of_sea(sea, projector, ray, distance, rest, &sea.frame.evaluate(rest, print), sea.submerges(projector))
}

/// Returns the hit of a sea's point with this rest point at a distance along a ray.
pub(crate) fn hit_of_sea(
    sea: &SeaSurface,
    projector: &Projector,
    ray: &Ray,
    distance: f64,
    rest: [f64; 2],
    sample: &Sample,
    inside: bool,
) -> Hit {
    hit_of_shape(sea, projector, ray, distance, rest, Shape::from(sample), inside)
}

/// Does the same, given the shape of the sea there.
fn hit_of_shape(
    sea: &SeaSurface,
    projector: &Projector,
    ray: &Ray,
    distance: f64,
    rest: [f64; 2],
    Shape { normal, slope_variance }: Shape,
    inside: bool,
) -> Hit {
    let jacobian = normal.y;
    let normal = unit_or_up(normal);
    // The normal points to the air: toward a ray that comes from there, along a ray that comes from the water.
    let normal = if (normal.dot(ray.direction) > 0.0) == inside { normal } else { -normal };
    let (position, rest_point) = (ray.at(distance), DVec3::new(rest[0], sea.level, rest[1]));
    Hit {
        surface: 0,
        distance,
        depth: (position - projector.position).dot(projector.forward),
        position,
        normal,
        rest: rest_point,
        height: position.y - sea.level,
        rest_distance: (position - rest_point).length(),
        slope_variance,
        jacobian,
        trails: [0.0; 6],
        uv: rest,
    }
}
