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
        (0..STEPS).fold(None, |found, step| RibbonPoint::deeper(found, self.segment(step).at(place)))
    }

    /// Returns one segment.
    pub(super) fn segment(&self, step: usize) -> Segment {
        let (from, to) = (self.points[step], self.points[step + 1]);
        let way = [to[0] - from[0], to[1] - from[1]];
        let [width, next] = [self.widths[step], self.widths[step + 1]];
        let squared = way[0] * way[0] + way[1] * way[1];
        Segment { from, way, squared, widths: [width, next - width], step: step as f64 }
    }

    /// Returns the bounding box of one segment: minimum and maximum of x, then of y.
    pub(super) fn segment_bounds(&self, step: usize) -> [[f64; 2]; 2] {
        let (from, to, wide) = (self.points[step], self.points[step + 1], self.widths[step].max(self.widths[step + 1]));
        [0, 1].map(|axis| [from[axis].min(to[axis]) - wide, from[axis].max(to[axis]) + wide])
    }
}

/// A segment of a spine.
pub(super) struct Segment {
    pub(super) from: [f64; 2],
    /// From its beginning to its end.
    pub(super) way: [f64; 2],
    /// Square of its length.
    pub(super) squared: f64,
    /// Half width at its beginning, and by how much that grows to its end.
    pub(super) widths: [f64; 2],
    /// Number of segments before it.
    pub(super) step: f64,
}

impl Segment {
    /// Returns the position of a point within the segment, if it lies in it.
    fn at(&self, place: [f64; 2]) -> Option<RibbonPoint> {
        let Self { from: [ax, ay], way: [dx, dy], squared, widths: [width, wider], step } = *self;
        let (px, py) = (place[0] - ax, place[1] - ay);
        let t = if squared > 0.0 { ((px * dx + py * dy) / squared).clamp(0.0, 1.0) } else { 0.0 };
        let (ox, oy) = (px - t * dx, py - t * dy);
        let half_width = width + t * wider;
        let distance = (ox * ox + oy * oy).sqrt();
        if distance > half_width || half_width <= 0.0 {
            return None;
        }
        let side = if dx * oy - dy * ox < 0.0 { -1.0 } else { 1.0 };
        Some(RibbonPoint { along: (step + t) / STEPS as f64, across: side * distance / half_width, half_width })
    }
}

impl RibbonPoint {
    /// Returns the distance to the edge, in pixels.
    pub fn inset(&self) -> f64 {
        (1.0 - self.across.abs()) * self.half_width
    }

    /// Returns whichever of two positions is nearer to the spine in half widths; the first if both are equal.
    fn deeper(first: Option<Self>, second: Option<Self>) -> Option<Self> {
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
