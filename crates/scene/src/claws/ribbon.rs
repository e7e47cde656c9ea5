//! Ribbons along a spine that curls toward its tip, like the foam in Hokusai's Great Wave.

/// Shape of a ribbon, independent of its size.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Shape {
    /// Total bend from root to tip, in radians; positive values turn clockwise in a picture whose y points down.
    pub curl: f64,
    /// Exponent of the bend along the spine; larger values bend closer to the tip.
    pub late: f64,
    /// Exponent of the narrowing toward the tip.
    pub taper: f64,
    /// Extra width in the middle, as a fraction.
    pub bulge: f64,
}

/// Position of a point within a ribbon.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct RibbonPoint {
    /// 0 at the root, 1 at the tip.
    pub along: f64,
    /// −1 at the left edge, 1 at the right edge, seen from the root.
    pub across: f64,
    /// Half the width of the ribbon at this point, in pixels.
    pub half_width: f64,
}

/// Fraction of the spine over which the ribbon widens from its root, as a square root.
const DRAWN_IN: f64 = 0.14;

/// Segments of a spine.
pub(super) const STEPS: usize = 24;

/// A ribbon in the picture.
#[derive(Clone, Debug, PartialEq)]
pub struct Ribbon {
    points: [[f64; 2]; STEPS + 1],
    /// Half widths at the points.
    widths: [f64; STEPS + 1],
    /// Directions of the spine at the points, in radians.
    angles: [f64; STEPS + 1],
    /// Bounding box: minimum and maximum of x, then of y.
    bounds: [[f64; 2]; 2],
}

impl Ribbon {
    /// Creates a ribbon from its root (in pixels), direction (in radians clockwise from the right), length and half
    /// width (in pixels).
    pub fn new(shape: &Shape, root: [f64; 2], direction: f64, length: f64, half_width: f64) -> Self {
        let way = |step: usize| step as f64 / STEPS as f64;
        // θ₀ + curl·s^late
        let angles: [f64; STEPS + 1] =
            std::array::from_fn(|step| direction + shape.curl * libm::pow(way(step), shape.late));
        // width/2·(1 − s)^taper·(1 + bulge·sin πs)·√min(1, s/0.14)
        let widths = std::array::from_fn(|step| {
            let s = way(step);
            let thin = libm::pow(1.0 - s, shape.taper) * (1.0 + shape.bulge * libm::sin(std::f64::consts::PI * s));
            half_width * thin * (s / DRAWN_IN).min(1.0).sqrt()
        });
        // Integrate the direction by the trapezoidal rule.
        let mut points = [root; STEPS + 1];
        for step in 1..=STEPS {
            let ([sin, cos], [sin_before, cos_before]) = (turn(angles[step]), turn(angles[step - 1]));
            let stride = 0.5 * length / STEPS as f64;
            let [x, y] = points[step - 1];
            points[step] = [x + stride * (cos + cos_before), y + stride * (sin + sin_before)];
        }
        let mut bounds = [[f64::INFINITY, f64::NEG_INFINITY]; 2];
        for (point, width) in points.iter().zip(&widths as &[f64; STEPS + 1]) {
            for (bounds, at) in bounds.iter_mut().zip(point) {
                *bounds = [bounds[0].min(at - width), bounds[1].max(at + width)];
            }
        }
        Self { points, widths, angles, bounds }
    }

    /// Returns the bounding box: minimum and maximum of x, then of y.
    pub fn bounds(&self) -> [[f64; 2]; 2] {
        self.bounds
    }

    /// Returns the point of the spine at a position from 0 to 1, and the direction there.
    pub fn spine(&self, along: f64) -> ([f64; 2], f64) {
        let step = ((along * STEPS as f64) as usize).min(STEPS);
        (self.points[step], self.angles[step])
    }

    /// Returns the position of a point within the ribbon, if it lies in it. The segment with the smallest distance in
    /// half widths decides, so ends and bends are round.
    pub fn at(&self, place: [f64; 2]) -> Option<RibbonPoint> {
        (0..STEPS).fold(None, |found, step| RibbonPoint::deeper(found, self.at_step(step, place)))
    }

    /// Returns the bounding box of one segment: minimum and maximum of x, then of y.
    pub(super) fn step_bounds(&self, step: usize) -> [[f64; 2]; 2] {
        let (from, to, wide) = (self.points[step], self.points[step + 1], self.widths[step].max(self.widths[step + 1]));
        [0, 1].map(|axis| [from[axis].min(to[axis]) - wide, from[axis].max(to[axis]) + wide])
    }

    /// Returns the position of a point within one segment, if it lies in it.
    #[inline]
    pub(super) fn at_step(&self, step: usize, place: [f64; 2]) -> Option<RibbonPoint> {
        let ([ax, ay], [bx, by]) = (self.points[step], self.points[step + 1]);
        let (dx, dy) = (bx - ax, by - ay);
        let (px, py) = (place[0] - ax, place[1] - ay);
        let squared = dx * dx + dy * dy;
        let t = if squared > 0.0 { ((px * dx + py * dy) / squared).clamp(0.0, 1.0) } else { 0.0 };
        let (ox, oy) = (px - t * dx, py - t * dy);
        let half_width = self.widths[step] + t * (self.widths[step + 1] - self.widths[step]);
        let distance = (ox * ox + oy * oy).sqrt();
        if distance > half_width || half_width <= 0.0 {
            return None;
        }
        let side = if dx * oy - dy * ox < 0.0 { -1.0 } else { 1.0 };
        Some(RibbonPoint { along: (step as f64 + t) / STEPS as f64, across: side * distance / half_width, half_width })
    }
}

impl RibbonPoint {
    /// Returns the distance to the edge, in pixels.
    pub fn inset(&self) -> f64 {
        (1.0 - self.across.abs()) * self.half_width
    }

    /// Returns whichever of two positions is nearer to the spine in half widths; the first if both are equal.
    pub(super) fn deeper(first: Option<Self>, second: Option<Self>) -> Option<Self> {
        match (first, second) {
            (Some(a), Some(b)) if b.across.abs() < a.across.abs() => second,
            (None, _) => second,
            _ => first,
        }
    }
}

fn turn(angle: f64) -> [f64; 2] {
    let (sin, cos) = libm::sincos(angle);
    [sin, cos]
}

#[cfg(test)]
mod tests {
    use super::*;

    const STRAIGHT: Shape = Shape { curl: 0.0, late: 1.5, taper: 1.0, bulge: 0.0 };

    #[test]
    fn a_straight_ribbon_is_a_wedge() {
        let ribbon = Ribbon::new(&STRAIGHT, [10.0, 5.0], 0.0, 24.0, 6.0);
        let at = |x: f64, y: f64| ribbon.at([x, y]);
        let middle = at(22.0, 5.0).unwrap();
        assert!((middle.along - 0.5).abs() < 1e-12 && middle.across == 0.0 && (middle.half_width - 3.0).abs() < 1e-12);
        let right = at(22.0, 6.5).unwrap();
        assert!((right.across - 0.5).abs() < 0.02 && right.across > 0.0, "y points down: {right:?}");
        assert!(at(22.0, 3.5).unwrap().across < 0.0);
        assert!(at(22.0, 8.2).is_none() && at(35.0, 5.0).is_none());
        // The end at the root is round.
        assert!(at(9.0, 5.0).is_some_and(|within| within.along < 0.2) && at(5.0, 5.0).is_none());
    }

    #[test]
    fn it_bends_late_and_as_far_as_it_says() {
        let shape = Shape { curl: 2.0, late: 2.5, ..STRAIGHT };
        let ribbon = Ribbon::new(&shape, [0.0; 2], 0.3, 100.0, 10.0);
        let (tip, direction) = ribbon.spine(1.0);
        assert!((direction - 2.3).abs() < 1e-12);
        // Integrate the direction in many small steps.
        let mut point = [0.0; 2];
        for step in 0..100_000 {
            let s = (f64::from(step) + 0.5) / 1e5;
            let (sin, cos) = libm::sincos(0.3 + 2.0 * libm::pow(s, 2.5));
            point = [point[0] + cos * 1e-3, point[1] + sin * 1e-3];
        }
        assert!((tip[0] - point[0]).abs() < 0.2 && (tip[1] - point[1]).abs() < 0.2, "{tip:?}, expected {point:?}");
        let ([x, y], early) = ribbon.spine(0.4);
        assert!((early - 0.3 - 2.0 * libm::pow(9.0 / 24.0, 2.5)).abs() < 1e-12);
        assert!(ribbon.at([x, y]).is_some_and(|within| within.across.abs() < 1e-9));
        let [[x0, x1], [y0, y1]] = ribbon.bounds();
        for place in (0..4000).map(|i| [f64::from(i % 63) * 3.0 - 40.0, f64::from(i / 63) * 3.0 - 40.0]) {
            let inside = (x0..=x1).contains(&place[0]) && (y0..=y1).contains(&place[1]);
            assert!(inside || ribbon.at(place).is_none(), "{place:?} lies beyond the bounds");
        }
    }
}
