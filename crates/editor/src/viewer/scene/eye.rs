//! Cameras as the picture shows them: how they project the world, and how dragging moves them.

use egui::{Pos2, Vec2, pos2};
use glam::DVec3;
use trochoid::{CheckedGraph, NodeId};

/// What a camera's knobs say at a frame.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(in crate::viewer) struct Pose {
    pub(super) position: DVec3,
    pub(super) target: DVec3,
    /// Clockwise rotation about the view axis, in degrees.
    pub(super) roll: f64,
    pub(super) lens: Lens,
}

#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) enum Lens {
    /// Horizontal angle of view, in degrees.
    Perspective(f64),
    /// Height of the picture, in meters.
    Orthographic(f64),
}

/// Nearest distance to which a camera comes by dragging, and the farthest, in meters.
const DISTANCES: [f64; 2] = [1e-3, 1e9];
/// Steepest view that turning reaches, in radians: at the vertical, the horizon gives no direction.
const STEEPEST: f64 = 89.0 * std::f64::consts::PI / 180.0;

impl Pose {
    /// Reads the knobs of a camera.
    pub(in crate::viewer) fn of(graph: &CheckedGraph, camera: NodeId, frame: i64) -> Self {
        let knobs = graph.settle(camera, frame);
        let lens = match knobs.text("projection") {
            "orthographic" => Lens::Orthographic(knobs.number("height")),
            _ => Lens::Perspective(knobs.number("fov")),
        };
        Self {
            position: knobs.vector3("position").into(),
            target: knobs.vector3("target").into(),
            roll: knobs.number("roll"),
            lens,
        }
    }

    /// Returns the unit vector along the view axis.
    pub(super) fn forward(&self) -> DVec3 {
        (self.target - self.position).try_normalize().unwrap_or(DVec3::NEG_Z)
    }

    /// Returns the horizontal unit vector to the right of the view axis.
    fn level_right(&self) -> DVec3 {
        let right = self.forward().cross(DVec3::Y);
        // Like the camera itself, which looks along the vertical then.
        if right.length() > 1e-6 { right.normalize() } else { DVec3::X }
    }

    /// Turns the camera about a point, which stays at its distance and at its place in the picture. `by` is in half turns:
    /// to the right and down.
    pub(super) fn orbited(&self, pivot: DVec3, by: Vec2) -> Self {
        let half = std::f64::consts::PI;
        let steepness = self.forward().y.clamp(-1.0, 1.0).asin();
        // A camera that is steeper already may only turn back.
        let [low, high] = [steepness.min(-STEEPEST), steepness.max(STEEPEST)];
        let tilt = (steepness - f64::from(by.y) * half).clamp(low, high) - steepness;
        let (right, turn) = (self.level_right(), -f64::from(by.x) * half);
        let turned = |at: DVec3| pivot + rotated(rotated(at - pivot, right, tilt), DVec3::Y, turn);
        Self { position: turned(self.position), target: turned(self.target), ..*self }
    }

    /// Moves the camera in its picture plane.
    pub(super) fn panned(&self, by: DVec3) -> Self {
        Self { position: self.position + by, target: self.target + by, ..*self }
    }

    /// Multiplies the distance to a point by a factor; the point keeps its place in the picture, and is never reached.
    pub(super) fn dollied(&self, pivot: DVec3, factor: f64) -> Self {
        match self.lens {
            Lens::Perspective(_) => {
                let distance = self.position.distance(pivot);
                let factor = limited(distance, factor);
                let near = |at: DVec3| pivot + (at - pivot) * factor;
                Self { position: near(self.position), target: near(self.target), ..*self }
            }
            Lens::Orthographic(height) => {
                let factor = limited(height, factor);
                let offset = pivot - self.position;
                let aside = offset - self.forward() * offset.dot(self.forward());
                let lens = Lens::Orthographic(height * factor);
                Self { lens, ..self.panned(aside * (1.0 - factor)) }
            }
        }
    }
}

/// Limits a factor so that the distance stays within what cameras take; one beyond already does not get farther out.
fn limited(distance: f64, factor: f64) -> f64 {
    let [near, far] = DISTANCES.map(|end| end / distance);
    if distance > 0.0 { factor.clamp(near.min(1.0), far.max(1.0)) } else { 1.0 }
}

/// Rotates a vector about a unit axis.
fn rotated(vector: DVec3, axis: DVec3, angle: f64) -> DVec3 {
    let (sin, cos) = angle.sin_cos();
    vector * cos + axis.cross(vector) * sin + axis * (axis.dot(vector) * (1.0 - cos))
}

/// Projection of a camera onto a picture of width and height 1.
#[derive(Clone, Copy, Debug)]
pub(in crate::viewer) struct Eye {
    pub(super) position: DVec3,
    right: DVec3,
    up: DVec3,
    pub(super) forward: DVec3,
    pub(super) orthographic: bool,
    /// Picture widths per unit tangent, or per meter if orthographic.
    scale: f64,
    /// Width of the picture divided by its height.
    aspect: f64,
}

impl Eye {
    /// Returns the projection of a camera.
    pub(in crate::viewer) fn new(pose: &Pose, aspect: f64) -> Self {
        let (forward, right) = (pose.forward(), pose.level_right());
        let up = right.cross(forward);
        let (sin, cos) = pose.roll.to_radians().sin_cos();
        let (orthographic, scale) = match pose.lens {
            Lens::Perspective(fov) => (false, 0.5 / (0.5 * fov.to_radians()).tan()),
            Lens::Orthographic(height) => (true, 1.0 / (height * aspect)),
        };
        let (right, up) = (right * cos - up * sin, up * cos + right * sin);
        Self { position: pose.position, right, up, forward, orthographic, scale, aspect }
    }

    /// Returns the distance of a point along the view axis.
    fn depth(&self, point: DVec3) -> f64 {
        (point - self.position).dot(self.forward)
    }

    /// Returns the place of an offset in the picture, at a depth.
    fn place(&self, offset: DVec3, depth: f64) -> Option<Pos2> {
        let scale = match self.orthographic {
            true => self.scale,
            false if depth > 1e-3 => self.scale / depth,
            false => return None,
        };
        let (x, y) = (offset.dot(self.right) * scale, offset.dot(self.up) * scale * self.aspect);
        Some(pos2(0.5 + x as f32, 0.5 - y as f32))
    }

    /// Projects a point, in fractions of the picture; `None` behind the camera.
    pub(in crate::viewer) fn project(&self, point: DVec3) -> Option<Pos2> {
        self.place(point - self.position, self.depth(point))
    }

    /// Projects what is infinitely far away in a direction; `None` behind the camera, or if rays are parallel.
    pub(super) fn toward(&self, direction: DVec3) -> Option<Pos2> {
        let direction = direction.try_normalize().filter(|_| !self.orthographic)?;
        self.place(direction, direction.dot(self.forward))
    }

    /// Returns the start and the unit direction of the ray at a place in the picture.
    pub(super) fn ray(&self, at: Pos2) -> (DVec3, DVec3) {
        let across = (f64::from(at.x) - 0.5) / self.scale;
        let upward = (0.5 - f64::from(at.y)) / (self.scale * self.aspect);
        let aside = self.right * across + self.up * upward;
        match self.orthographic {
            true => (self.position + aside, self.forward),
            false => (self.position, (self.forward + aside).normalize()),
        }
    }

    /// Returns the point of a plane that is seen at a place in the picture; `None` if the plane is not.
    pub(super) fn on_plane(&self, at: Pos2, (point, normal): (DVec3, DVec3)) -> Option<DVec3> {
        let (origin, direction) = self.ray(at);
        let distance = (point - origin).dot(normal) / direction.dot(normal);
        (distance.is_finite() && distance > 0.0 && distance < 1e6).then(|| origin + direction * distance)
    }

    /// Returns the point of a horizontal plane that is seen at a place in the picture; `None` above the horizon.
    pub(in crate::viewer) fn on_level(&self, at: Pos2, level: f64) -> Option<DVec3> {
        self.on_plane(at, (DVec3::Y * level, DVec3::Y))
    }

    /// Returns the point that is seen at a place in the picture, as deep as another one.
    pub(super) fn beside(&self, at: Pos2, point: DVec3) -> Option<DVec3> {
        let (origin, direction) = self.ray(at);
        let distance = (point - origin).dot(self.forward) / direction.dot(self.forward);
        distance.is_finite().then(|| origin + direction * distance)
    }

    /// Returns the width of the picture at a point, in meters.
    pub(super) fn width_at(&self, point: DVec3) -> f64 {
        if self.orthographic { 1.0 / self.scale } else { self.depth(point).max(1e-3) / self.scale }
    }
}

#[cfg(test)]
pub(super) mod tests {
    use super::*;
    use rand::{RngExt, SeedableRng};

    pub(in crate::viewer::scene) const ASPECT: f64 = 16.0 / 9.0;

    /// Cameras around the origin, of both projections; some of them look almost along the vertical.
    pub(in crate::viewer::scene) fn cameras() -> impl Iterator<Item = (Pose, rand_pcg::Pcg64Mcg)> {
        (0..400).map(|seed| {
            let mut random = rand_pcg::Pcg64Mcg::seed_from_u64(seed);
            let mut around = |size: f64| DVec3::from([0; 3].map(|_| random.random_range(-size..size)));
            let (position, target) = (around(40.0), around(10.0));
            let target = if seed % 17 == 0 { position - DVec3::new(1e-3, 5.0, 0.0) } else { target };
            let roll = random.random_range(-180.0..180.0);
            let lens = match seed % 3 {
                0 => Lens::Orthographic(random.random_range(0.1..100.0)),
                _ => Lens::Perspective(random.random_range(5.0..140.0)),
            };
            (Pose { position, target, roll, lens }, random)
        })
    }

    /// Returns a place in the picture, and a point that is seen there.
    fn seen(pose: &Pose, random: &mut rand_pcg::Pcg64Mcg) -> (Pos2, DVec3) {
        let at = pos2(random.random_range(0.0..1.0), random.random_range(0.0..1.0));
        let (origin, direction) = Eye::new(pose, ASPECT).ray(at);
        (at, origin + direction * random.random_range(0.5..60.0))
    }

    /// Asserts that a point is seen at a place, in a picture 2000 pixels wide, within a hundredth of a pixel.
    fn is_at(pose: &Pose, point: DVec3, at: Pos2) {
        let found = Eye::new(pose, ASPECT).project(point).unwrap();
        assert!((found - at).length() < 5e-6, "{pose:?} {point}: {found:?}, not {at:?}");
    }

    #[test]
    fn points_are_projected_where_their_rays_pass() {
        for (pose, mut random) in cameras() {
            let (at, point) = seen(&pose, &mut random);
            is_at(&pose, point, at);
            let eye = Eye::new(&pose, ASPECT);
            let elsewhere = pos2(random.random_range(0.0..1.0), random.random_range(0.0..1.0));
            is_at(&pose, eye.beside(elsewhere, point).unwrap(), elsewhere);
            if let Some(level) = eye.on_level(elsewhere, 0.5) {
                assert!((level.y - 0.5).abs() < 1e-6);
                is_at(&pose, level, elsewhere);
            }
            let (_, direction) = eye.ray(elsewhere);
            match eye.toward(direction) {
                Some(place) => assert!((place - elsewhere).length() < 1e-5),
                None => assert!(eye.orthographic),
            }
        }
    }

    #[test]
    fn what_is_behind_the_camera_has_no_place() {
        for (pose, _) in cameras().filter(|(pose, _)| matches!(pose.lens, Lens::Perspective(_))) {
            let eye = Eye::new(&pose, ASPECT);
            assert_eq!(eye.project(pose.position - pose.forward() * 3.0), None);
            assert_eq!(eye.toward(-pose.forward()), None);
        }
    }

    #[test]
    fn turning_keeps_the_point_at_its_distance_and_place() {
        for (pose, mut random) in cameras() {
            let (at, pivot) = seen(&pose, &mut random);
            let by = egui::vec2(random.random_range(-1.0..1.0), random.random_range(-1.0..1.0));
            let turned = pose.orbited(pivot, by);
            let (before, after) = (pose.position.distance(pivot), turned.position.distance(pivot));
            assert!((after / before - 1.0).abs() < 1e-9, "{before} {after}");
            let ahead = pose.position.distance(pose.target);
            assert!((turned.position.distance(turned.target) / ahead - 1.0).abs() < 1e-9);
            is_at(&turned, pivot, at);
            assert!(turned.forward().y.abs() <= STEEPEST.sin().max(pose.forward().y.abs()) + 1e-9);
            assert_eq!(pose.orbited(pivot, Vec2::ZERO).lens, pose.lens);
            assert!(pose.orbited(pivot, Vec2::ZERO).position.distance(pose.position) < 1e-9);
        }
    }

    #[test]
    fn panning_brings_a_point_to_another_place() {
        for (pose, mut random) in cameras() {
            let (_, point) = seen(&pose, &mut random);
            let to = pos2(random.random_range(0.0..1.0), random.random_range(0.0..1.0));
            let there = Eye::new(&pose, ASPECT).beside(to, point).unwrap();
            let panned = pose.panned(point - there);
            is_at(&panned, point, to);
            assert!(panned.forward().distance(pose.forward()) < 1e-9, "the direction stays");
        }
    }

    #[test]
    fn a_camera_never_passes_the_point_that_it_moves_to() {
        for (pose, mut random) in cameras() {
            let (at, pivot) = seen(&pose, &mut random);
            let factor = random.random_range(0.2..3.0);
            is_at(&pose.dollied(pivot, factor), pivot, at);
            let mut nearer = pose;
            for _ in 0..40 {
                nearer = nearer.dollied(pivot, 0.1);
                let ahead = (pivot - nearer.position).dot(pose.forward());
                assert!(ahead > 0.0, "{ahead}");
            }
            match nearer.lens {
                Lens::Orthographic(height) => assert!(height >= DISTANCES[0] * (1.0 - 1e-9), "{height}"),
                Lens::Perspective(_) => assert!(nearer.position.distance(pivot) >= DISTANCES[0] * 0.999),
            }
        }
    }
}
