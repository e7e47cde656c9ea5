//! Noise at one point in f64, straight from the definition: corner by corner and cell by cell.

use super::{AMPLITUDE, Noise, NoiseKind, Octave, extend, feature, gradient};

impl Noise {
    /// Returns the noise at a point of two or three coordinates, for a footprint in the unit of the coordinates.
    ///
    /// # Panics
    /// If the point has fewer than two coordinates or more than three.
    pub fn reference(&self, point: &[f64], footprint: f64) -> f64 {
        let axes = point.len() + usize::from(self.evolution.is_some());
        let mean = self.kind.mean(axes);
        let value = |octave: &Octave| {
            let kept = kept(octave, footprint);
            let place = place(self, octave, point.iter().copied());
            let value = match self.kind {
                NoiseKind::Fbm => gradient_value(octave.seed, &place),
                NoiseKind::Ridged => {
                    let valley = 1.0 - gradient_value(octave.seed, &place).abs();
                    valley * valley
                }
                NoiseKind::Cellular => distances(octave.seed, &place)[0],
                NoiseKind::Edges => {
                    let distances = distances(octave.seed, &place);
                    distances[1] - distances[0]
                }
            };
            octave.weight * (kept * value + (1.0 - kept) * mean)
        };
        let (low, high) = self.kind.range();
        self.octaves.iter().map(value).sum::<f64>().clamp(low, high)
    }

    /// Returns noise of kind [`NoiseKind::Edges`] at a point of the plane, and its slope along each axis, per unit of the
    /// coordinates: the difference of the unit vectors away from the two nearest feature points.
    pub fn edges_reference(&self, point: [f64; 2]) -> (f64, [f64; 2]) {
        let mut slope = [0.0; 2];
        for octave in &self.octaves {
            let along = |axis: usize| point[axis] * octave.frequency + octave.shift[axis];
            let place = [0, 1].map(along).map(|along| if along.is_finite() { along } else { 0.0 });
            let [first, second] = nearest(octave.seed, &place);
            for axis in 0..2 {
                let away = |(distance, way): &(f64, [f64; MOST_AXES])| {
                    if *distance > 0.0 { -way[axis] / distance } else { 0.0 }
                };
                slope[axis] += octave.weight * octave.frequency * (away(&second) - away(&first));
            }
        }
        (self.reference(&point, 0.0), slope)
    }
}

/// Returns the fraction of an octave that a footprint leaves.
pub(super) fn kept(octave: &Octave, footprint: f64) -> f64 {
    let t = (2.0 - 2.0 * footprint * octave.frequency).clamp(0.0, 1.0);
    t * t * (3.0 - 2.0 * t)
}

/// A place in cells: its coordinates, filled up to the most, and how many they are.
#[derive(Clone, Copy)]
pub(super) struct Place {
    all: [f64; MOST_AXES],
    axes: usize,
}

impl std::ops::Deref for Place {
    type Target = [f64];

    fn deref(&self) -> &[f64] {
        &self.all[..self.axes]
    }
}

/// Converts a point to cells of an octave.
pub(super) fn place(noise: &Noise, octave: &Octave, point: impl Iterator<Item = f64>) -> Place {
    let along = point.map(|coordinate| coordinate * octave.frequency).chain(noise.evolution);
    let mut place = Place { all: [0.0; MOST_AXES], axes: 0 };
    for (along, shift) in along.zip(octave.shift) {
        let shifted = along + shift;
        place.all[place.axes] = if shifted.is_finite() { shifted } else { 0.0 };
        place.axes += 1;
    }
    place
}

/// Most coordinates: three of space, and the evolution.
pub(super) const MOST_AXES: usize = 4;

/// Returns the hash of the cell that lies some steps from that of a place.
fn hash(seed: u32, place: &[f64], step: impl Fn(usize) -> i64) -> u32 {
    let cell = place.iter().enumerate().map(|(axis, along)| (along.floor() as i64).wrapping_add(step(axis)));
    cell.fold(seed, extend)
}

/// Returns Σ over the corners of Π fade · gradient · offset, in [−1, 1], and its slope along each axis before clamping.
///
/// # Panics
/// If the place has fewer than two coordinates or more than four.
pub(super) fn gradient_noise(seed: u32, place: &[f64]) -> (f64, [f64; MOST_AXES]) {
    of_axes::<true>(seed, place)
}

/// Returns the same without its slopes.
///
/// # Panics
/// If the place has fewer than two coordinates or more than four.
pub(super) fn gradient_value(seed: u32, place: &[f64]) -> f64 {
    of_axes::<false>(seed, place).0
}

fn of_axes<const SLOPES: bool>(seed: u32, place: &[f64]) -> (f64, [f64; MOST_AXES]) {
    match *place {
        [x, y] => on_axes::<2, SLOPES>(seed, [x, y]),
        [x, y, z] => on_axes::<3, SLOPES>(seed, [x, y, z]),
        [x, y, z, w] => on_axes::<4, SLOPES>(seed, [x, y, z, w]),
        _ => panic!("noise has two to four axes"),
    }
}

#[allow(clippy::needless_range_loop, reason = "loops over several arrays")]
fn on_axes<const D: usize, const SLOPES: bool>(seed: u32, place: [f64; D]) -> (f64, [f64; MOST_AXES]) {
    let (mut cells, mut fractions, mut shares, mut fading) = ([0_i64; D], [0.0; D], [[0.0; 2]; D], [0.0; D]);
    for axis in 0..D {
        let floor = place[axis].floor();
        let t = place[axis] - floor;
        let fade = t * t * t * (t * (t * 6.0 - 15.0) + 10.0);
        (cells[axis], fractions[axis], shares[axis]) = (floor as i64, t, [1.0 - fade, fade]);
        fading[axis] = 30.0 * t * t * (t - 1.0) * (t - 1.0);
    }
    let (mut sum, mut slopes) = (0.0, [0.0; MOST_AXES]);
    for corner in 0..1_usize << D {
        let upper = |axis: usize| (corner >> axis) & 1;
        let mut hash = seed;
        for axis in 0..D {
            hash = extend(hash, cells[axis].wrapping_add(upper(axis) as i64));
        }
        let (mut weight, mut dot, mut gradients) = (1.0, 0.0, [0.0; D]);
        for axis in 0..D {
            weight *= shares[axis][upper(axis)];
            gradients[axis] = f64::from(gradient(hash, axis));
            dot += gradients[axis] * (fractions[axis] - upper(axis) as f64);
        }
        sum += weight * dot;
        for axis in 0..if SLOPES { D } else { 0 } {
            let mut others = 1.0;
            for other in 0..D {
                if other != axis {
                    others *= shares[other][upper(other)];
                }
            }
            let fading = if upper(axis) == 1 { fading[axis] } else { -fading[axis] };
            slopes[axis] += weight * gradients[axis] + others * fading * dot;
        }
    }
    let amplitude = f64::from(AMPLITUDE[D]);
    slopes.iter_mut().for_each(|slope| *slope *= amplitude);
    ((amplitude * sum).clamp(-1.0, 1.0), slopes)
}

/// Returns the distances to the two nearest feature points, nearest first, each at most 1.
pub(super) fn distances(seed: u32, place: &[f64]) -> [f64; 2] {
    nearest(seed, place).map(|(distance, _)| distance)
}

/// Returns the distances to the two nearest feature points, nearest first, each at most 1, and the vectors to them: 0
/// if none is nearer than 1.
fn nearest(seed: u32, place: &[f64]) -> [(f64, [f64; MOST_AXES]); 2] {
    let axes = place.len();
    let mut found = [(1.0, [0.0; MOST_AXES]); 2];
    for index in 0..3usize.pow(axes as u32) {
        let step = |axis: usize| (index / 3usize.pow(axis as u32) % 3) as i64 - 1;
        let hash = hash(seed, place, step);
        let mut way = [0.0; MOST_AXES];
        for (axis, (way, along)) in way.iter_mut().zip(place).enumerate() {
            *way = step(axis) as f64 + f64::from(feature(hash, axis)) - (along - along.floor());
        }
        let distance = way[..axes].iter().map(|along| along * along).sum::<f64>().sqrt();
        if distance < found[0].0 {
            found = [(distance, way), found[0]];
        } else if distance < found[1].0 {
            found[1] = (distance, way);
        }
    }
    found
}
