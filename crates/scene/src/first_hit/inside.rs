//! What tests see of cells, and of what they are made of.

pub use super::bernstein::{Net, SIDE, bent_bases_at, interpolated, nodes, off, part, range};
pub use super::first::{First, FirstPoint, Shape, Thoroughness};
pub use super::squares::{FINE, LONG_POINTS, LONG_ROUNDING, PARTS, POINTS, ROUNDING};

use super::bernstein;
use super::cells::SeaCells;
use super::footprints::Footprints;
use super::region::{Axes, Region};
use super::remainder::{CELL, Remainder, SQUARE, remainder};
use super::sizes::WaveSizes;
use super::squares;
use crate::{Projector, Ray, SeaSurface};
use fearless_simd::{Level, Simd, dispatch};
use glam::DVec3;
use trochoid_sea::FramedSea;

/// Returns value and derivatives of a polynomial at a place in 0…1.
pub fn evaluate(net: &Net, at: [f64; 2]) -> (f64, [f64; 2]) {
    let [value] = bernstein::evaluate(&[*net], at);
    value
}

/// Divides a net into halves along s or along t: returns the lower one if `takes_low`, otherwise the upper one, and leaves
/// the other one in its place.
pub fn split(net: &mut Net, along_s: bool, takes_low: bool) -> Net {
    dispatch!(Level::new(), simd => simd.vectorize(
        #[inline(always)]
        || bernstein::split(simd, net, along_s, takes_low)
    ))
}

/// Returns [`range`], computed with all instructions of the machine.
pub fn range_by_all_instructions(net: &Net) -> [f64; 2] {
    dispatch!(Level::new(), simd => simd.vectorize(
        #[inline(always)]
        || range(net)
    ))
}

/// Interpolates the values at a square's points at those of its cells.
pub fn between(own: &[[f64; POINTS]; POINTS]) -> Box<[[f64; FINE]; FINE]> {
    let mut values = Box::new([[0.0; FINE]; FINE]);
    squares::between(Level::new(), own, &mut values);
    values
}

/// Interpolates the values at the points for long waves at all points of a square.
pub fn doubled(long: &[[f64; LONG_POINTS]; LONG_POINTS]) -> [[f64; POINTS]; POINTS] {
    let mut values = [[0.0; POINTS]; POINTS];
    squares::doubled(Level::new(), long, &mut values);
    values
}

/// The footprints of a camera over a sea, and how they change.
pub struct SeaFootprints(Footprints);

impl SeaFootprints {
    /// Finds them.
    pub fn new(sea: &SeaSurface, projector: &Projector) -> Self {
        Self(Footprints::new(sea, projector))
    }

    /// Returns the square of the footprint at a distance ahead of the camera.
    pub fn square(&self, ahead: f64) -> f64 {
        self.0.square(ahead)
    }

    /// Returns the footprint at a distance ahead of the camera, and its derivative.
    pub fn change(&self, ahead: f64) -> (f64, f64) {
        self.0.change(ahead)
    }

    /// Returns the factor that bounds the power series of the square around a place, at a distance from it.
    pub fn growth(&self, ahead: f64, distance: f64) -> f64 {
        self.0.growth(ahead).at(distance)
    }

    /// Returns the linear coefficient of that factor.
    pub fn linear(&self, ahead: f64) -> f64 {
        self.0.growth(ahead).linear()
    }

    /// Returns the places where the footprint has a kink.
    pub fn kinks(&self) -> Vec<f64> {
        self.0.kinks()
    }
}

/// The part of a slab around a sea that a camera sees, in axes of its own.
pub struct SeenRegion {
    axes: Axes,
    region: Region,
}

impl SeenRegion {
    /// Finds it.
    pub fn new(sea: &SeaSurface, projector: &Projector) -> Self {
        let axes = Axes::new(sea, projector);
        Self { region: Region::new(sea, projector, &axes), axes }
    }

    /// Returns a point in its axes.
    pub fn point(&self, point: DVec3) -> DVec3 {
        self.axes.point(point)
    }

    /// Returns its range ahead of the camera.
    pub fn along(&self) -> Option<[f64; 2]> {
        self.region.along()
    }

    /// Returns its range across, over a range ahead.
    pub fn across(&self, ahead: [f64; 2]) -> Option<[f64; 2]> {
        self.region.across(ahead)
    }

    /// Returns whether a box of its axes is outside.
    pub fn misses(&self, corners: [DVec3; 2]) -> bool {
        self.region.misses(corners)
    }

    /// Returns whether a stretch of a ray of the world is inside.
    pub fn holds(&self, ray: &Ray, stretch: [f64; 2]) -> bool {
        let own = Ray { origin: self.axes.point(ray.origin), direction: self.axes.direction(ray.direction) };
        self.region.holds(&own, stretch)
    }
}

/// Bounds of the distance of a sea from polynomials through some of its points.
pub struct Remainders {
    axes: Axes,
    footprints: Footprints,
    sizes: WaveSizes,
}

/// Such a bound for a square.
pub struct BoundedSquare {
    /// Along u, up, and along v, in meters.
    pub off: [f64; 3],
    /// Number of waves that the polynomial contains, by falling wavelength.
    pub waves: usize,
    /// Number of those that come from fewer points.
    pub long: usize,
    remainder: Remainder,
}

impl BoundedSquare {
    /// Returns the bound of the derivatives by one side at a place along it, −1…1.
    pub fn turn_at(&self, place: f64) -> f64 {
        self.remainder.turn_at(place)
    }
}

impl Remainders {
    /// Prepares the waves.
    pub fn new(sea: &SeaSurface, projector: &Projector) -> Self {
        let axes = Axes::new(sea, projector);
        let waves = FramedSea::new(&sea.frame, [axes.eye.x, axes.eye.z], axes.heading);
        Self { axes, footprints: Footprints::new(sea, projector), sizes: WaveSizes::new(&waves) }
    }

    /// Returns the world's x and z of a rest point.
    pub fn rest(&self, place: [f64; 2]) -> [f64; 2] {
        self.axes.rest(place)
    }

    /// Returns the bound for a square of half side `half` around a place ahead, through [`POINTS`] points a side,
    /// or through [`SIDE`]; no point of it is farther than `away` from the camera.
    pub fn of(&self, is_square: bool, middle: f64, half: f64, away: f64) -> BoundedSquare {
        let through = if is_square { &SQUARE } else { &CELL };
        let remainder = remainder(&self.sizes, &self.footprints, through, middle, half, away);
        let Remainder { off, waves, long, .. } = remainder;
        BoundedSquare { off, waves, long, remainder }
    }
}

/// The cells of a sea that a camera sees.
pub struct Cells(SeaCells);

impl Cells {
    /// Makes them; `None` if there are none, or too many.
    pub fn new(sea: &SeaSurface, projector: &Projector) -> Option<Self> {
        SeaCells::new(sea, projector, &|| false).ok().map(Self)
    }

    /// Returns how many there are.
    pub fn count(&self) -> usize {
        self.0.count()
    }

    /// Returns a point in the axes of the cells.
    pub fn point(&self, point: DVec3) -> DVec3 {
        self.0.axes.point(point)
    }

    /// Returns the rest point x, z at a place in a cell.
    pub fn rest(&self, cell: usize, at: [f64; 2]) -> [f64; 2] {
        self.0.axes.rest(self.0.cell(cell).rest(at))
    }

    /// Returns, for each axis, the coordinate of the cell's patch at a place and its derivatives.
    pub fn patch(&self, cell: usize, at: [f64; 2]) -> [(f64, [f64; 2]); 3] {
        let components = [DVec3::X, DVec3::Y, DVec3::Z].map(|way| self.0.cell(cell).seen_along(DVec3::ZERO, way));
        bernstein::evaluate(&components, at)
    }

    /// Returns how far the patch of a cell may be from the sea along each axis, and its derivatives by −1…1 from those
    /// of the sea at its ends.
    pub fn remainder(&self, cell: usize) -> ([f64; 3], f64) {
        let remainder = &self.0.cell(cell).remainder;
        (remainder.off, remainder.turn)
    }

    /// Returns the latter at a place along one side, −1…1.
    pub fn turn_at(&self, cell: usize, place: f64) -> f64 {
        self.0.cell(cell).remainder.turn_at(place)
    }

    /// Returns half the side of a cell, in meters.
    pub fn half(&self, cell: usize) -> f64 {
        self.0.cell(cell).half
    }

    /// Returns the place of a rest point, in the axes of the cells, in a cell: 0…1 if it is inside.
    pub fn place(&self, cell: usize, rest: DVec3) -> [f64; 2] {
        self.0.cell(cell).place(rest)
    }

    /// Returns whether a point, in the axes of the cells, is out of sight.
    pub fn misses(&self, point: DVec3) -> bool {
        self.0.region.misses([point, point])
    }

    /// Returns the first point that a ray of the camera meets between two distances.
    pub fn first(
        &self,
        sea: &SeaSurface,
        projector: &Projector,
        ray: &Ray,
        stretch: [f64; 2],
        effort: Thoroughness,
    ) -> First {
        self.0.first(sea, projector, ray, stretch, effort)
    }
}
