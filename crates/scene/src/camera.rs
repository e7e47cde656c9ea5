use glam::DVec3;
use trochoid_image::Format;
use trochoid_key::{ContentKey, KeyHasher};

/// How a camera maps the world to its picture.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Projection {
    /// Rays through one point; `fov` is more than 0 and less than π.
    Perspective {
        /// Horizontal angle of view, in radians.
        fov: f64,
    },
    /// Parallel rays; `height` is more than 0.
    Orthographic {
        /// Height of the picture, in meters.
        height: f64,
    },
}

/// A camera that looks from `position` to `target`.
///
/// If both coincide, it looks along −Z; if it looks straight up or down, −Z or +Z is up in the picture.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Camera {
    /// Position of the camera.
    pub position: DVec3,
    /// Point at the center of the picture.
    pub target: DVec3,
    /// Rotation about the view axis, in radians: positive values turn the camera clockwise, and the picture
    /// counterclockwise.
    pub roll: f64,
    /// Projection.
    pub projection: Projection,
}

/// A half-line in the world.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Ray {
    /// Starting point.
    pub origin: DVec3,
    /// Unit direction.
    pub direction: DVec3,
}

impl Ray {
    /// Returns the point at a distance in meters.
    pub fn at(&self, distance: f64) -> DVec3 {
        self.origin + self.direction * distance
    }
}

/// A camera fitted to a format: turns pixel positions into rays and points into pixel positions.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Projector {
    /// Position of the camera.
    pub position: DVec3,
    /// Unit vector to the right of the picture.
    pub right: DVec3,
    /// Unit vector to the top of the picture.
    pub up: DVec3,
    /// Unit vector along the view axis.
    pub forward: DVec3,
    /// Whether rays are parallel.
    pub orthographic: bool,
    /// Pixels per tangent of 1 (perspective), or per meter (orthographic).
    pub scale: f64,
    /// Width and height, in pixels.
    pub size: [f64; 2],
    /// Factor by which vertices of meshes are closer together than pixels require; 1 by default.
    pub fineness: f64,
}

impl ContentKey for Projector {
    fn feed(&self, hasher: &mut KeyHasher) {
        let Self { position, right, up, forward, orthographic, scale, size, fineness } = self;
        [position, right, up, forward].map(|vector| vector.to_array()).feed(hasher);
        (orthographic, scale, size, fineness).feed(hasher);
    }
}

impl Camera {
    /// Returns the projector of this camera for pictures of one format; pixels are square.
    pub fn projector(&self, format: Format) -> Projector {
        let view = self.target - self.position;
        let forward = view.try_normalize().unwrap_or(DVec3::NEG_Z);
        let level_right = forward.cross(DVec3::Y);
        // Within 1e-6 of the vertical the horizon gives no direction, so use −Z turned up or down instead.
        let right = if level_right.length() > 1e-6 { level_right.normalize() } else { DVec3::X };
        let up = right.cross(forward);
        let (sin, cos) = libm::sincos(self.roll);
        let size = [f64::from(format.width()), f64::from(format.height())];
        let (orthographic, scale) = match self.projection {
            Projection::Perspective { fov } => (false, size[0] / 2.0 / libm::tan(fov / 2.0)),
            Projection::Orthographic { height } => (true, size[1] / height),
        };
        Projector {
            position: self.position,
            right: right * cos - up * sin,
            up: up * cos + right * sin,
            forward,
            orthographic,
            scale,
            size,
            fineness: 1.0,
        }
    }
}

impl Projector {
    /// Returns the ray through a position in pixels, measured from the upper left corner of the picture.
    ///
    /// Orthographic rays start in the plane through the camera.
    pub fn ray(&self, x: f64, y: f64) -> Ray {
        let (across, upward) = self.plane(x, y);
        if self.orthographic {
            Ray { origin: self.position + across + upward, direction: self.forward }
        } else {
            Ray { origin: self.position, direction: (self.forward + across + upward).normalize() }
        }
    }

    /// Returns the offsets across and upward of a pixel position, for a depth of 1 (perspective) or in meters
    /// (orthographic).
    #[inline]
    pub(crate) fn plane(&self, x: f64, y: f64) -> (DVec3, DVec3) {
        let [across, upward] = self.place(x, y);
        (self.right * across, self.up * upward)
    }

    /// Returns the lengths of these offsets.
    #[inline(always)]
    pub(crate) fn place(&self, x: f64, y: f64) -> [f64; 2] {
        [(x - self.size[0] / 2.0) / self.scale, (self.size[1] / 2.0 - y) / self.scale]
    }

    /// Returns the pixel position and planar depth of a world point; a perspective point at depth 0 or less has no
    /// position.
    pub fn project(&self, point: DVec3) -> Option<([f64; 2], f64)> {
        let offset = point - self.position;
        let depth = offset.dot(self.forward);
        let scale = if self.orthographic {
            self.scale
        } else if depth > 0.0 {
            self.scale / depth
        } else {
            return None;
        };
        let x = self.size[0] / 2.0 + offset.dot(self.right) * scale;
        let y = self.size[1] / 2.0 - offset.dot(self.up) * scale;
        Some(([x, y], depth))
    }

    /// Returns the width in meters that a pixel at the picture's center covers, face on, at a distance in meters.
    #[inline]
    pub fn pixel_size(&self, distance: f64) -> f64 {
        if self.orthographic { 1.0 / self.scale } else { distance / self.scale }
    }

    /// Returns the horizontal unit vector, x and z, in which the camera looks; if it looks straight down or up, that
    /// of the picture's upper edge.
    pub(crate) fn heading(&self) -> [f64; 2] {
        let ahead = if self.forward.y.abs() < 0.999 { self.forward } else { self.up };
        let length = libm::sqrt(ahead.x * ahead.x + ahead.z * ahead.z).max(1e-300);
        [ahead.x / length, ahead.z / length]
    }

    /// Returns the rays along the picture's border, clockwise; their directions have any length.
    pub(crate) fn border(&self) -> Vec<Ray> {
        const STEPS: u32 = 64;
        let [w, h] = self.size;
        let corners = [[0.0, 0.0], [w, 0.0], [w, h], [0.0, h], [0.0, 0.0]];
        let mut rays = Vec::new();
        for side in corners.windows(2) {
            for step in 0..STEPS {
                let part = f64::from(step) / f64::from(STEPS);
                let at = |axis: usize| side[0][axis] + (side[1][axis] - side[0][axis]) * part;
                rays.push(self.ray(at(0), at(1)));
            }
        }
        rays
    }
}
