//! Tests that views meet seas themselves, not the triangles of their meshes.

use crate::random::Draw;
use trochoid_image::Format;
use trochoid_scene::{
    Asked, Camera, Certain, Channel, ChannelSet, DVec3, GridSurface, Met, Projection, Samples, SeaSurface, Sight, Sums,
    Surface, Visible,
};
use trochoid_sea::{GerstnerSpectrum, Sea};

const SIZE: [u32; 2] = [160, 90];

/// Errors of the samples of a view that see the same sheet of the surface as their rays.
#[derive(Debug, Default)]
struct Errors {
    /// Sorted: distances of points from the surface, in pixels; errors of normals, in radians; of rest points, relative
    /// to the depth; of the Jacobian.
    sorted: [Vec<f64>; 4],
    /// Samples that see another sheet, or for which it is not certain.
    unclear: usize,
}

impl Errors {
    fn of(camera: &Camera, surface: &dyn Surface) -> Self {
        let format = Format::new(SIZE[0], SIZE[1], 4).expect("valid");
        let offset = format.sample_offset(2);
        let pixels: Vec<[i64; 2]> =
            (0..i64::from(SIZE[1])).flat_map(|y| (0..i64::from(SIZE[0])).map(move |x| [x, y])).collect();
        let visible = Visible::prepare(camera, &[surface], format, ChannelSet::ALL);
        let mut samples = Samples::new();
        visible.fill(format.window(), offset, ChannelSet::ALL, &mut samples);
        let certain = Certain::new(camera, &[surface], format, &|| false).expect("nobody stops it");
        let sights = certain.sights(&[surface], &pixels, offset, Asked::Values);
        let near = visible.points(&[surface], &pixels, offset, Sums::Double);
        let projector = visible.projector();
        let mut errors = Self::default();
        for (index, sight) in sights.iter().enumerate() {
            let at = |channel: Channel| f64::from(samples.channel(channel)[index]);
            let vector = |channels: [Channel; 3]| DVec3::from(channels.map(at));
            let hit = match (sight, near[index]) {
                (Sight::Point(Met { hit, .. }), Some(near))
                    if (near.distance - hit.distance).abs() <= 1e-6 * hit.distance =>
                {
                    hit
                }
                (Sight::Nothing, _) if at(Channel::Coverage) == 0.0 => continue,
                _ => {
                    errors.unclear += 1;
                    continue;
                }
            };
            let position = vector([Channel::PositionX, Channel::PositionY, Channel::PositionZ]);
            let normal = vector([Channel::NormalX, Channel::NormalY, Channel::NormalZ]);
            let off = (position - hit.position).dot(hit.normal).abs();
            let rest = DVec3::new(at(Channel::RestX), hit.rest.y, at(Channel::RestZ));
            let found = [
                off / projector.pixel_size(hit.depth),
                (normal - hit.normal).length(),
                (rest - hit.rest).length() / hit.depth,
                (at(Channel::Jacobian) - hit.jacobian).abs(),
            ];
            errors.sorted.iter_mut().zip(found).for_each(|(errors, found)| errors.push(found));
        }
        errors.sorted.iter_mut().for_each(|errors| errors.sort_by(f64::total_cmp));
        errors
    }

    /// Returns the errors that a share of the samples exceeds.
    fn beyond(&self, share: f64) -> [f64; 4] {
        self.sorted.each_ref().map(|errors| errors[((1.0 - share) * (errors.len() - 1) as f64) as usize])
    }

    /// Checks that no more samples than these shares exceed these errors, and that most samples are clear.
    fn hold(&self, limits: &[(f64, [f64; 4])], what: &str) {
        let count = self.sorted[0].len();
        assert!(count > 2500 && self.unclear * 40 < count, "{what}: {} of {count} samples are unclear", self.unclear);
        for (share, limit) in limits {
            let found = self.beyond(*share);
            let holds = found.iter().zip(limit).all(|(found, limit)| found <= limit);
            assert!(holds, "{what}: a share {share} is beyond {found:?}, not {limit:?}");
        }
    }
}

fn look(position: [f64; 3], target: [f64; 3], projection: Projection) -> Camera {
    Camera { position: DVec3::from(position), target: DVec3::from(target), roll: 0.1, projection }
}

const WIDE: Projection = Projection::Perspective { fov: 0.9 };

/// Cameras above, just above and below the water, straight down, and with parallel rays.
fn cameras() -> [Camera; 6] {
    [
        look([0.0, 7.0, 30.0], [0.0, 0.0, 0.0], WIDE),
        look([2.0, 3.4, 12.0], [0.0, 3.0, -20.0], WIDE),
        look([0.0, 5.0, 0.0], [0.0, 5.0, -20.0], WIDE),
        look([0.0, -12.0, 0.0], [0.0, 0.0, -20.0], WIDE),
        look([4.0, 50.0, 3.0], [5.0, 0.0, 5.0], WIDE),
        look([0.0, 50.0, 80.0], [0.0, 0.0, 0.0], Projection::Orthographic { height: 60.0 }),
    ]
}

fn sea(sharpness: f64, seed: u64) -> SeaSurface {
    let spectrum = GerstnerSpectrum {
        count: 60,
        wavelength: 9.0,
        spread: 0.7,
        height: 1.6,
        sharpness,
        direction_spread: 0.8,
        seed,
        ..GerstnerSpectrum::default()
    };
    SeaSurface::new(&Sea::new(spectrum.waves().expect("valid")), 7.0, 0.0)
}

#[test]
fn views_meet_seas_up_to_the_fourth_power_of_the_spacing() {
    // Round crests, sharp ones, crests near the cusp, and folds. About twice what was found.
    for (index, sharpness) in [0.3, 0.75, 0.98, 1.6].into_iter().enumerate() {
        for (view, camera) in cameras().iter().enumerate().skip(index % 2).step_by(2) {
            let errors = Errors::of(camera, &sea(sharpness, (5 + index + 7 * view) as u64));
            let limits = [(0.5, [6e-4, 2e-3, 1e-5, 3e-3]), (0.001, [1e-2, 2.5e-2, 4e-3, 4e-2])];
            errors.hold(&limits, &format!("sharpness {sharpness}, view {view}"));
        }
    }
}

#[test]
fn views_meet_height_fields_themselves() {
    // Heights from cell to cell at random: slopes of more than 1, and contours everywhere. A pixel of the last camera is
    // as large as a cell, and normals are those a hundredth of a pixel away.
    let mut draw = Draw(3);
    let heights = (0..60 * 60).map(|_| draw.next() as f32).collect();
    let grid = GridSurface::new(heights, 60, 1.0, [-30.0; 2], 0.0);
    for (view, camera) in cameras().iter().enumerate() {
        let limits = [(0.5, [1e-5, 3e-4, 1e-6, 1e-5]), (0.005, [3e-4, 2e-2, 1e-5, 1e-5])];
        Errors::of(camera, &grid).hold(&limits, &format!("view {view}"));
    }
}
