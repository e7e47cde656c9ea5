//! Tests of the tessellated view against the f64 reference, which uses no tessellation.

use trochoid_image::Format;
use trochoid_scene::{Camera, Channel, ChannelSet, DVec3, Hit, Projection, Samples, SeaSurface, Visible, reference};
use trochoid_sea::{GerstnerSpectrum, Sea};

fn sea(count: usize) -> Sea {
    let spectrum = GerstnerSpectrum {
        count,
        wavelength: 15.0,
        spread: 0.3,
        height: 1.5,
        sharpness: 0.6,
        direction: 1.5,
        seed: 3,
        ..GerstnerSpectrum::default()
    };
    Sea::new(spectrum.waves().expect("valid"))
}

/// Returns the share of about 200 samples at which depth and normal agree: the depth within a share `depth` of
/// itself, the normal within `angle` radians.
fn agreement(camera: &Camera, surface: &SeaSurface, size: [u32; 2], depth: f64, angle: f64) -> f64 {
    let format = Format::new(size[0], size[1], 1).expect("valid");
    let visible = Visible::prepare(camera, &[surface], format, ChannelSet::ALL);
    let mut samples = Samples::new();
    visible.fill(format.window(), [0.5, 0.5], ChannelSet::ALL, &mut samples);
    let pixels = (size[0] * size[1]) as usize;
    // A step without common factor with the width visits all columns.
    let step = (pixels / 200) | 1;
    let (mut good, mut all) = (0, 0);
    for index in (0..pixels).step_by(step) {
        let [x, y] = [index % size[0] as usize, index / size[0] as usize];
        let hit = reference::trace(camera, &[surface], format, x as f64 + 0.5, y as f64 + 0.5).expect("smooth");
        all += 1;
        good += usize::from(agrees(&samples, index, hit, depth, angle));
    }
    f64::from(good as u32) / f64::from(all)
}

fn agrees(samples: &Samples, index: usize, hit: Option<Hit>, depth: f64, angle: f64) -> bool {
    let at = |channel: Channel| f64::from(samples.channel(channel)[index]);
    let Some(hit) = hit else { return at(Channel::Coverage) == 0.0 };
    let normal = DVec3::new(at(Channel::NormalX), at(Channel::NormalY), at(Channel::NormalZ));
    let position = DVec3::new(at(Channel::PositionX), at(Channel::PositionY), at(Channel::PositionZ));
    let rest = DVec3::new(at(Channel::RestX), hit.rest.y, at(Channel::RestZ));
    let near = |a: f64, b: f64| (a - b).abs() <= depth * hit.depth;
    at(Channel::Coverage) == 1.0
        && at(Channel::Surface) == 0.0
        && near(at(Channel::Depth), hit.depth)
        && (position - hit.position).length() <= depth * hit.depth
        && (rest - hit.rest).length() <= depth * hit.depth
        && near(at(Channel::Height), hit.height)
        && near(at(Channel::RestDistance), hit.rest_distance)
        && normal.dot(hit.normal).clamp(-1.0, 1.0).acos() <= angle
        && (at(Channel::Jacobian) - hit.jacobian).abs() <= 0.05
        && (at(Channel::SlopeVariance) - hit.slope_variance).abs() <= 1e-3 + 0.05 * hit.slope_variance
}

fn look(position: [f64; 3], target: [f64; 3], projection: Projection) -> Camera {
    Camera { position: DVec3::from(position), target: DVec3::from(target), roll: 0.0, projection }
}

const WIDE: Projection = Projection::Perspective { fov: 0.9 };

#[test]
fn looking_over_the_sea() {
    let surface = SeaSurface::new(&sea(40), 12.0, 0.0);
    let camera = look([0.0, 6.0, 30.0], [0.0, -2.0, 0.0], WIDE);
    let share = agreement(&camera, &surface, [240, 135], 0.01, 0.02);
    assert!(share >= 0.97, "{share}");
}

#[test]
fn far_from_the_origin_rolled_and_late() {
    let surface = SeaSurface::new(&sea(40), 1e5, 20.0);
    let camera = Camera { roll: 0.5, ..look([1e5, 32.0, -1e5], [1e5 + 40.0, 18.0, -1e5 + 9.0], WIDE) };
    let share = agreement(&camera, &surface, [160, 120], 0.01, 0.02);
    assert!(share >= 0.97, "{share}");
}

#[test]
fn straight_down() {
    let surface = SeaSurface::new(&sea(40), 1.0, 0.0);
    let camera = look([5.0, 60.0, 5.0], [5.0, 0.0, 5.0], WIDE);
    let share = agreement(&camera, &surface, [200, 150], 1e-3, 0.02);
    assert!(share >= 0.99, "{share}");
}

#[test]
fn orthographic() {
    let surface = SeaSurface::new(&sea(40), 1.0, 0.0);
    let camera = look([0.0, 50.0, 80.0], [0.0, 0.0, 0.0], Projection::Orthographic { height: 60.0 });
    let share = agreement(&camera, &surface, [160, 120], 1e-3, 0.02);
    assert!(share >= 0.98, "{share}");
}

#[test]
fn from_under_water() {
    let surface = SeaSurface::new(&sea(40), 1.0, 0.0);
    let camera = look([0.0, -15.0, 0.0], [0.0, 0.0, -20.0], WIDE);
    let share = agreement(&camera, &surface, [160, 120], 0.01, 0.02);
    assert!(share >= 0.97, "{share}");
}

#[test]
fn a_flat_sea_is_a_plane() {
    let surface = SeaSurface::new(&Sea::default(), 0.0, -2.0);
    let camera = Camera { roll: 0.2, ..look([3.0, 1.0, 2.0], [9.0, 0.0, -14.0], WIDE) };
    // One pixel below the horizon, the f32 positions of the horizon's own vertices begin to show.
    assert!(agreement(&camera, &surface, [320, 200], 1e-4, 1e-6) >= 0.99);
}
