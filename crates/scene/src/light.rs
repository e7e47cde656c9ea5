use glam::DVec3;

/// A light, as far as geometry is concerned; its color is up to the back end.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Light {
    /// Parallel light; `direction` points toward the light and need not be a unit vector.
    Directional {
        /// Vector toward the light.
        direction: DVec3,
    },
    /// Light from a point in all directions, without falloff.
    Point {
        /// Position of the light.
        position: DVec3,
    },
    /// Light from a point into a cone.
    Spot {
        /// Position of the light.
        position: DVec3,
        /// Point at which it is aimed.
        target: DVec3,
        /// Half angle of the cone, in radians, 0 to π.
        angle: f64,
        /// Width of the soft edge inside of the cone, in radians, ≥ 0; 0 gives a hard edge.
        soft: f64,
    },
}

/// Light that arrives at a point.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Illumination {
    /// Unit vector from the point to the light; +Y if the light is at the point or has no direction.
    pub direction: DVec3,
    /// Share of the light that arrives, in [0, 1].
    pub intensity: f64,
}

impl Light {
    /// Returns the light that arrives at a point of the world, ignoring shadows.
    pub fn illuminate(&self, point: DVec3) -> Illumination {
        let unit = |vector: DVec3| vector.try_normalize().unwrap_or(DVec3::Y);
        match *self {
            Self::Directional { direction } => Illumination { direction: unit(direction), intensity: 1.0 },
            Self::Point { position } => Illumination { direction: unit(position - point), intensity: 1.0 },
            Self::Spot { position, target, angle, soft } => {
                let direction = unit(position - point);
                let axis = (target - position).try_normalize().unwrap_or(DVec3::NEG_Y);
                // atan2 of sine and cosine is exact near 0, where the arc cosine is not.
                let off_axis = libm::atan2(axis.cross(-direction).length(), axis.dot(-direction));
                let inside = angle - off_axis;
                let intensity = if inside < 0.0 {
                    0.0
                } else if inside >= soft {
                    1.0
                } else {
                    let t = inside / soft;
                    t * t * (3.0 - 2.0 * t)
                };
                Illumination { direction, intensity }
            }
        }
    }
}
