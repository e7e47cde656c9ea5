//! Finds points of a sea near those of its mesh, by sums in f32 over many points side by side.

use crate::meet_near::meet_sea;
use crate::points::MeshHit;
use crate::reference::hit_of_sea;
use crate::surface::Hit;
use crate::{Projector, Ray, SeaSurface};
use glam::{DMat3, DVec3};
use std::cell::RefCell;
use trochoid_memory::Scratch;
use trochoid_sea::{FieldSet, Fields, Points, Sample};

/// Number of points that are processed together; no point affects the result of another.
const TOGETHER: usize = 64;

/// Number of Newton steps, and the distance from the ray, in footprints of the pixel, after which a single further
/// step is enough.
const STEPS: usize = 4;
const CLOSE: f64 = 1e-3;

/// A point that is being moved to a ray.
struct FollowedPoint {
    /// Index of the ray.
    index: usize,
    rest: [f64; 2],
    distance: f64,
}

#[derive(Default)]
struct Sums {
    x: Vec<f64>,
    z: Vec<f64>,
    footprint: Vec<f64>,
    fields: Fields,
}

thread_local! {
    /// Reused from call to call.
    static SUMS: RefCell<Sums> = RefCell::default();
}

/// Does the same as [`meet_sea`] up to f32 rounding; falls back to it for points that are not found.
pub(crate) fn follow_sea(
    sea: &SeaSurface,
    projector: &Projector,
    mesh_hits: &[(Ray, MeshHit)],
) -> Scratch<Option<Hit>> {
    let mut found = Scratch::of(None, mesh_hits.len());
    for first in (0..mesh_hits.len()).step_by(TOGETHER) {
        let range = first..(first + TOGETHER).min(mesh_hits.len());
        let start = |index: usize| {
            let near = &mesh_hits[index].1;
            FollowedPoint { index, rest: [near.rest.x, near.rest.z], distance: near.distance }
        };
        let mut walks: Scratch<FollowedPoint> = range.clone().map(start).collect();
        SUMS.with_borrow_mut(|sums| {
            for _ in 0..STEPS {
                sums.look(sea, projector, &walks);
                let mut lane = 0;
                walks.retain_mut(|walk| {
                    lane += 1;
                    let (ray, near) = &mesh_hits[walk.index];
                    let (sample, footprint) = (sums.sample(lane - 1), sums.footprint[lane - 1]);
                    let Some(error) = walk.step(sea, ray, &sample) else { return true };
                    let is_there = error <= CLOSE * footprint && walk.distance >= 0.0;
                    if is_there {
                        let (rest, distance) = (walk.rest, walk.distance);
                        found[walk.index] = Some(hit_of_sea(sea, projector, ray, distance, rest, &sample, near.inside));
                    }
                    !is_there
                });
            }
        });
        for walk in &walks {
            let (ray, near) = &mesh_hits[walk.index];
            found[walk.index] = meet_sea(sea, projector, ray, near);
        }
    }
    found
}

impl Sums {
    /// Evaluates the sea at the rest points of the walks.
    fn look(&mut self, sea: &SeaSurface, projector: &Projector, walks: &[FollowedPoint]) {
        let Self { x, z, footprint, fields } = self;
        [&mut *x, &mut *z, &mut *footprint].into_iter().for_each(Vec::clear);
        for FollowedPoint { rest, .. } in walks {
            x.push(rest[0]);
            z.push(rest[1]);
            footprint.push(sea.footprint(projector, DVec3::new(rest[0], sea.level, rest[1])));
        }
        let wanted = FieldSet { displacement: true, derivatives: true, slope_variance: true, velocity: false };
        sea.frame.scattered(Points { x, z, footprint }, wanted, fields);
    }

    fn sample(&self, lane: usize) -> Sample {
        let of = |values: &Vec<f32>| f64::from(values[lane]);
        let Fields { displacement, slope, strain, slope_variance, .. } = &self.fields;
        Sample {
            displacement: displacement.each_ref().map(of),
            slope: slope.each_ref().map(of),
            strain: strain.each_ref().map(of),
            slope_variance: of(slope_variance),
            ..Sample::default()
        }
    }
}

impl FollowedPoint {
    /// Takes one Newton step, given the sea here, and returns how far from the ray the point was; `None` if there is
    /// no such step.
    fn step(&mut self, sea: &SeaSurface, ray: &Ray, sample: &Sample) -> Option<f64> {
        let ([xx, xz, zz], [yx, yz]) = (sample.strain, sample.slope);
        let point = DVec3::new(self.rest[0], sea.level, self.rest[1]) + DVec3::from(sample.displacement);
        let error = point - ray.at(self.distance);
        // The change of the footprint along the way is neglected: it is slow, and more steps follow.
        let ways = DMat3::from_cols(DVec3::new(1.0 + xx, yx, xz), DVec3::new(xz, yz, 1.0 + zz), -ray.direction);
        let step = ways.inverse() * error;
        if !step.is_finite() {
            return None;
        }
        self.rest = [self.rest[0] - step.x, self.rest[1] - step.y];
        self.distance -= step.z;
        Some(error.length())
    }
}
