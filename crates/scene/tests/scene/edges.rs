//! Tests of cameras at the limits of what is sensible.

use trochoid_image::{Format, Window};
use trochoid_scene::{Camera, Channel, ChannelSet, DVec3, Projection, Samples, SeaSurface, Surface, Visible};
use trochoid_sea::{GerstnerSpectrum, Sea};

fn sea(count: usize) -> Sea {
    let spectrum = GerstnerSpectrum { count, height: 3.0, seed: 5, ..GerstnerSpectrum::default() };
    Sea::new(spectrum.waves().expect("valid"))
}

fn look(position: [f64; 3], target: [f64; 3]) -> Camera {
    let projection = Projection::Perspective { fov: 0.8 };
    Camera { position: DVec3::from(position), target: DVec3::from(target), roll: 0.0, projection }
}

fn fill(camera: &Camera, surfaces: &[&dyn Surface], size: [u32; 2]) -> Samples {
    let format = Format::new(size[0], size[1], 1).expect("valid");
    let visible = Visible::prepare(camera, surfaces, format, ChannelSet::ALL);
    let mut samples = Samples::new();
    visible.fill(format.window(), [0.5, 0.5], ChannelSet::ALL, &mut samples);
    for channel in Channel::ALL {
        assert!(samples.channel(channel).iter().all(|value| !value.is_nan()), "{channel:?} is never NaN");
    }
    samples
}

fn covered(samples: &Samples) -> usize {
    samples.channel(Channel::Coverage).iter().filter(|&&value| value == 1.0).count()
}

#[test]
fn the_horizon_stands_at_its_exact_row() {
    // With a level camera, the horizon is the line between rows 49 and 50, and a flat sea reaches it.
    for height in [0.5, 6.0, 300.0] {
        let surface = SeaSurface::new(&Sea::default(), 0.0, 0.0);
        let samples = fill(&look([0.0, height, 0.0], [0.0, height, -1.0]), &[&surface], [160, 100]);
        let rows: Vec<&[f32]> = samples.channel(Channel::Coverage).chunks(160).collect();
        assert!(rows[..50].iter().all(|row| row.iter().all(|&value| value == 0.0)));
        assert!(rows[50..].iter().all(|row| row.iter().all(|&value| value == 1.0)));
    }
}

#[test]
fn a_stormy_sea_hides_the_horizon_and_does_not_move_it_far_away() {
    let surface = SeaSurface::new(&sea(50), 0.0, 0.0);
    let samples = fill(&look([0.0, 20.0, 0.0], [0.0, 20.0, -1.0]), &[&surface], [160, 100]);
    let rows: Vec<&[f32]> = samples.channel(Channel::Coverage).chunks(160).collect();
    assert!(rows[50..].iter().all(|row| row.iter().all(|&value| value == 1.0)));
    assert!(rows[..49].iter().all(|row| row.iter().all(|&value| value == 0.0)));
}

#[test]
fn pure_sky_is_empty() {
    let surface = SeaSurface::new(&sea(50), 0.0, 0.0);
    let samples = fill(&look([0.0, 10.0, 0.0], [0.0, 30.0, -10.0]), &[&surface], [64, 36]);
    assert_eq!(covered(&samples), 0);
    assert!(samples.channel(Channel::Depth).iter().all(|&depth| depth == f32::INFINITY));
    assert!(samples.channel(Channel::NormalY).iter().all(|&y| y == 1.0));
    assert!(samples.channel(Channel::Surface).iter().all(|&index| index == -1.0));
    assert_eq!(covered(&fill(&look([0.0, 10.0, 0.0], [0.0, 99.0, 0.0]), &[&surface], [64, 36])), 0);
    assert_eq!(covered(&fill(&look([0.0, 10.0, 0.0], [0.0, 0.0, 0.0]), &[], [64, 36])), 0);
}

#[test]
fn straight_down_sees_only_sea() {
    let surface = SeaSurface::new(&sea(50), 0.0, 0.0);
    let samples = fill(&look([3.0, 40.0, -7.0], [3.0, 0.0, -7.0]), &[&surface], [96, 64]);
    assert_eq!(covered(&samples), 96 * 64);
    // −Z is up in the picture, +X to the right.
    let (x, z) = (samples.channel(Channel::PositionX), samples.channel(Channel::PositionZ));
    assert!(x[95] > x[0] && z[0] < z[63 * 96]);
}

#[test]
fn below_the_crests_and_inside_a_wave() {
    let surface = SeaSurface::new(&sea(50), 0.0, 0.0);
    for height in [2.0, 1.0, 0.3, 0.0, -0.3, -1.0, -30.0] {
        for target in [[0.0, height, -9.0], [0.0, height - 9.0, -3.0], [0.0, height + 9.0, -3.0]] {
            fill(&look([0.0, height, 0.0], target), &[&surface], [64, 36]);
        }
    }
    // Under water, looking up: the surface is overhead everywhere.
    let samples = fill(&look([0.0, -20.0, 0.0], [0.0, 0.0, -3.0]), &[&surface], [64, 36]);
    assert_eq!(covered(&samples), 64 * 36);
    assert!(samples.channel(Channel::NormalY).iter().all(|&y| y > 0.0));
}

#[test]
fn one_pixel() {
    let surface = SeaSurface::new(&sea(50), 0.0, 0.0);
    assert_eq!(covered(&fill(&look([0.0, 10.0, 0.0], [0.0, 0.0, -10.0]), &[&surface], [1, 1])), 1);
    assert_eq!(covered(&fill(&look([0.0, 10.0, 0.0], [0.0, 30.0, -10.0]), &[&surface], [1, 1])), 0);
}

#[test]
fn a_target_at_the_camera_looks_along_minus_z() {
    let surface = SeaSurface::new(&Sea::default(), 0.0, 0.0);
    let at = |target: [f64; 3]| fill(&look([0.0, 5.0, 0.0], target), &[&surface], [32, 20]);
    assert_eq!(at([0.0, 5.0, 0.0]), at([0.0, 5.0, -1.0]));
}

#[test]
fn the_nearer_of_several_seas_is_seen() {
    let (low, high) = (SeaSurface::new(&sea(20), 0.0, -10.0), SeaSurface::new(&sea(20), 0.0, 0.0));
    let samples = fill(&look([0.0, 30.0, 0.0], [0.0, 0.0, -10.0]), &[&low, &high], [64, 36]);
    assert!(samples.channel(Channel::Surface).iter().all(|&index| index == 1.0));
    // From between them both are visible, each on its side of the horizon.
    let samples = fill(&look([0.0, -5.0, 0.0], [0.0, -5.0, -10.0]), &[&low, &high], [64, 36]);
    let surfaces = samples.channel(Channel::Surface);
    assert_eq!((surfaces[32], surfaces[35 * 64 + 32]), (1.0, 0.0));
    assert_eq!(covered(&samples), 64 * 36);
}

#[test]
fn orthographic_cameras_look_any_way() {
    let surface = SeaSurface::new(&sea(30), 0.0, 0.0);
    let projection = Projection::Orthographic { height: 40.0 };
    let camera = |position, target| Camera { projection, ..look(position, target) };
    assert_eq!(covered(&fill(&camera([0.0, 50.0, 0.0], [0.0, 0.0, 0.0]), &[&surface], [64, 36])), 64 * 36);
    assert_eq!(covered(&fill(&camera([0.0, 50.0, 50.0], [0.0, 0.0, 0.0]), &[&surface], [64, 36])), 64 * 36);
    assert_eq!(covered(&fill(&camera([0.0, 50.0, 0.0], [0.0, 90.0, 0.0]), &[&surface], [64, 36])), 0);
    // Level with the sea: its lower half, seen from the side, is under water; crests rise into the upper half.
    let side = fill(&camera([0.0, 0.0, 50.0], [0.0, 0.0, 0.0]), &[&surface], [64, 36]);
    assert!(covered(&side) > 0);
}

#[test]
fn windows_outside_the_picture_are_sky() {
    let surface = SeaSurface::new(&sea(10), 0.0, 0.0);
    let format = Format::new(32, 20, 1).expect("valid");
    let camera = look([0.0, 30.0, 0.0], [0.0, 0.0, -1.0]);
    let visible = Visible::prepare(&camera, &[&surface], format, ChannelSet::COVERAGE);
    let mut samples = Samples::new();
    visible.fill(Window::new(-4, -4, 36, 24), [0.5, 0.5], ChannelSet::COVERAGE, &mut samples);
    assert_eq!(covered(&samples), 32 * 20);
    visible.fill(Window::new(40, 0, 50, 5), [0.5, 0.5], ChannelSet::COVERAGE, &mut samples);
    assert_eq!(covered(&samples), 0);
}

#[test]
fn rays_and_pixels_are_each_others_inverse() {
    let format = Format::new(320, 200, 1).expect("valid");
    for projection in [Projection::Perspective { fov: 0.8 }, Projection::Orthographic { height: 12.0 }] {
        let camera = Camera { roll: 0.3, projection, ..look([1.0, 2.0, 3.0], [-4.0, 1.0, 7.0]) };
        let projector = camera.projector(format);
        for (x, y) in [(0.0, 0.0), (319.5, 7.25), (160.0, 100.0)] {
            let (pixel, depth) = projector.project(projector.ray(x, y).at(25.0)).expect("in front");
            assert!((pixel[0] - x).abs() < 1e-9 && (pixel[1] - y).abs() < 1e-9 && depth > 0.0);
        }
    }
}
