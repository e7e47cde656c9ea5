//! Tests of what is certain in a view, against the f64 reference.

use std::sync::Arc;

use crate::random::Draw;
use trochoid_image::Format;
use trochoid_scene::bezier::{Bicubic, Patch, PatchModel, Placement, Tessellation};
use trochoid_scene::{
    Asked, Camera, Certain, ChannelSet, DVec3, GridSurface, Hit, Met, Pose, Projection, RigidBodies, SeaSurface, Sight,
    Surface, TriangleModel, Triangles, Visible, reference,
};
use trochoid_sea::{ExplicitWave, GerstnerSpectrum, Sea, Wave};

const WIDE: Projection = Projection::Perspective { fov: 0.9 };

fn look(position: [f64; 3], target: [f64; 3], projection: Projection) -> Camera {
    Camera { position: DVec3::from(position), target: DVec3::from(target), roll: 0.1, projection }
}

/// Returns the share of unclear samples, and checks that all others agree with the reference; tests one pixel in
/// `every`.
fn unclear(camera: &Camera, surfaces: &[&dyn Surface], size: [u32; 2], every: usize) -> f64 {
    let format = Format::new(size[0], size[1], 4).expect("valid");
    let certain = Certain::new(camera, surfaces, format, &|| false).expect("nobody stops it");
    let pixels: Vec<[i64; 2]> =
        (0..i64::from(size[1])).flat_map(|y| (0..i64::from(size[0])).map(move |x| [x, y])).collect();
    let offset = format.sample_offset(1);
    let sights = certain.sights(surfaces, &pixels, offset, Asked::Values);
    for ([x, y], sight) in pixels.iter().zip(&sights).step_by(every) {
        let place = [*x as f64 + offset[0], *y as f64 + offset[1]];
        let truth = || reference::trace(camera, surfaces, format, place[0], place[1]).expect("smooth enough");
        match sight {
            Sight::Unclear => {}
            Sight::Nothing => assert_eq!(truth(), None, "at {place:?} nothing should be seen"),
            Sight::Point(Met { hit, off, .. }) => {
                let truth = truth().unwrap_or_else(|| panic!("{hit:?} should be seen at {place:?}"));
                assert!(agree(hit, &truth, *off), "at {place:?}: {hit:?} should be {truth:?}");
            }
        }
    }
    sights.iter().filter(|sight| **sight == Sight::Unclear).count() as f64 / sights.len() as f64
}

fn agree(hit: &Hit, truth: &Hit, off: f64) -> bool {
    // Grazing rays know their end less well.
    let near = 1e-9 * (1.0 + truth.distance)
        / truth.normal.dot((truth.position - truth.rest).normalize_or(DVec3::Y)).abs().max(1e-3);
    hit.surface == truth.surface
        && (hit.position - truth.position).length() <= near
        && (hit.rest - truth.rest).length() <= near
        && (hit.normal - truth.normal).length() <= 1e-6 + off
        && (hit.slope_variance - truth.slope_variance).abs() <= 1e-9
        && (hit.jacobian - truth.jacobian).abs() <= 1e-6
        && (hit.depth - truth.depth).abs() <= near
        && hit.trails.iter().zip(truth.trails).all(|(a, b)| (a - b).abs() <= 1e-6)
}

fn sea(height: f64, sharpness: f64, seed: u64) -> SeaSurface {
    let spectrum = GerstnerSpectrum {
        count: 60,
        wavelength: 12.0,
        spread: 0.5,
        height,
        sharpness,
        seed,
        ..GerstnerSpectrum::default()
    };
    SeaSurface::new(&Sea::new(spectrum.waves().expect("valid")), 7.0, 1.0)
}

#[test]
fn seas() {
    let views = [
        look([0.0, 9.0, 30.0], [0.0, -2.0, 0.0], WIDE),
        look([4.0, 60.0, 0.0], [5.0, 0.0, 5.0], WIDE),
        look([0.0, -15.0, 0.0], [0.0, 0.0, -20.0], WIDE),
        look([0.0, 50.0, 80.0], [0.0, 0.0, 0.0], Projection::Orthographic { height: 60.0 }),
    ];
    for (index, camera) in views.iter().enumerate() {
        for (height, sharpness) in [(1.2, 0.4), (2.4, 0.9)] {
            let surface = sea(height, sharpness, index as u64 + 3);
            let share = unclear(camera, &[&surface], [160, 90], 23);
            assert!(share < if height < 2.0 { 0.02 } else { 0.2 }, "view {index}, height {height}: {share} unclear");
        }
    }
}

#[test]
fn meshes_show_the_sheets_that_rays_meet() {
    let spectrum = GerstnerSpectrum {
        wavelength: 9.0,
        spread: 1.0,
        height: 4.0,
        direction: 70.0_f64.to_radians(),
        sharpness: 0.8,
        seed: 8,
        ..GerstnerSpectrum::default()
    };
    let surface = SeaSurface::new(&Sea::new(spectrum.waves().expect("valid")), 0.0, 0.0);
    let camera = look([0.0, 5.0, 30.0], [0.0, 4.5, 0.0], Projection::Perspective { fov: 46.0_f64.to_radians() });
    let format = Format::new(96, 54, 4).expect("valid");
    let visible = Visible::prepare(&camera, &[&surface], format, ChannelSet::REST);
    let certain = Certain::new(&camera, &[&surface], format, &|| false).expect("nobody stops it");
    let pixels: Vec<[i64; 2]> = (0..54).flat_map(|y| (0..96).map(move |x| [x, y])).collect();
    let offset = format.sample_offset(1);
    let sights = certain.sights(&[&surface], &pixels, offset, Asked::Values);
    let same = visible.same_sheets(&[&surface], &pixels, offset, &sights);
    let other = same.iter().filter(|same| !**same).count();
    assert!(other * 100 < pixels.len(), "another sheet is shown, or may be, at {other} of {} samples", pixels.len());
    // Pixels that are asked for alone are the same.
    for pixel in [[7, 31], [8, 31], [50, 52], [95, 53], [33, 28]] {
        let alone = certain.sights(&[&surface], &[pixel], offset, Asked::Values);
        assert_eq!(alone[0], sights[(pixel[1] * 96 + pixel[0]) as usize], "{pixel:?}");
    }
}

#[test]
fn height_fields() {
    let heights: Vec<f32> = (0..120 * 90)
        .map(|cell| {
            let (x, z) = (f64::from(cell % 120) * 0.4, f64::from(cell / 120) * 0.4);
            ((0.9 * x).sin() * (0.7 * z + 0.4).cos() + 0.4 * (0.5 * x - 1.3 * z).sin()) as f32
        })
        .collect();
    let grid = GridSurface::new(heights, 120, 0.4, [-24.0, -18.0], 2.0);
    let cameras = [
        look([0.0, 40.0, 6.0], [0.0, 0.0, 0.0], WIDE),
        look([0.0, 30.0, 3.0], [0.0, 2.0, 0.0], Projection::Orthographic { height: 40.0 }),
        look([0.0, 5.0, 30.0], [0.0, 1.0, 0.0], WIDE),
        look([2.0, 5.0, 4.0], [-9.0, 1.0, -6.0], WIDE),
    ];
    for camera in cameras {
        let share = unclear(&camera, &[&grid], [160, 90], 7);
        assert!(share < 0.06, "{share} unclear");
    }
}

/// Returns an open box of triangles, in its own space.
fn tent() -> TriangleModel {
    let mesh = Triangles {
        positions: vec![
            DVec3::new(-2.0, 0.0, -2.0),
            DVec3::new(2.0, 0.0, -2.0),
            DVec3::new(2.0, 0.0, 2.0),
            DVec3::new(-2.0, 0.0, 2.0),
            DVec3::new(0.0, 3.0, 0.0),
        ],
        triangles: vec![[0, 4, 1], [1, 4, 2], [2, 4, 3], [3, 4, 0]],
        ..Triangles::default()
    };
    let placement = Placement { scale: DVec3::ONE, rotate: DVec3::ZERO, translate: DVec3::ZERO };
    TriangleModel::new(mesh, placement, false).expect("valid")
}

#[test]
fn models_on_a_sea() {
    let sea = sea(1.5, 0.5, 8);
    let (sin, cos) = 0.6_f64.sin_cos();
    let axes = [DVec3::new(cos, 0.0, -sin), DVec3::Y, DVec3::new(sin, 0.0, cos)];
    let poses =
        vec![Pose { axes, origin: DVec3::new(-3.0, 0.5, 5.0) }, Pose { axes, origin: DVec3::new(4.0, 1.0, 0.0) }];
    let tents = RigidBodies::new(Arc::new(tent()), poses);
    let points = std::array::from_fn(|at| {
        let (u, v) = ((at % 4) as f64, (at / 4) as f64);
        DVec3::new(3.0 * u - 4.5, 4.0 + 2.0 * (u * v * 0.7).sin(), 2.0 * v - 14.0)
    });
    let placement = Placement { scale: DVec3::ONE, rotate: DVec3::ZERO, translate: DVec3::ZERO };
    let tessellation = Tessellation::Adaptive { tolerance: 0.1 };
    let sail = PatchModel::new(&[Patch::new(Bicubic { points })], placement, false, tessellation);
    let surfaces: [&dyn Surface; 3] = [&sea, &tents, &sail];
    let share = unclear(&look([0.0, 7.0, 24.0], [0.0, 1.0, 0.0], WIDE), &surfaces, [160, 90], 37);
    assert!(share < 0.1, "{share} unclear");
}

#[test]
fn random_views() {
    let mut draw = Draw(17);
    for seed in 0..12 {
        let surface = sea(3.0 * draw.next(), 1.5 * draw.next(), seed);
        let at = [40.0 * (draw.next() - 0.5), 2.0 + 30.0 * draw.next(), 40.0 * (draw.next() - 0.5)];
        let to = [100.0 * (draw.next() - 0.5), 4.0 * (draw.next() - 0.5), 100.0 * (draw.next() - 0.5)];
        let share = unclear(&look(at, to, WIDE), &[&surface], [64, 36], 19);
        assert!(share < 0.3, "{share} unclear");
    }
}

#[test]
fn crests_that_rays_cut() {
    // A wave near the camera in a fine picture: chords of its crest are shorter than the reference's steps.
    let wave =
        ExplicitWave { wavelength: 12.0, amplitude: 0.6, direction: 1.57, sharpness: 0.3, phase: 0.0, speed: None };
    let surface = SeaSurface::new(&Sea::new(vec![Wave::try_from(wave).expect("valid")]), 0.0, 0.0);
    let camera = look([0.0, 3.0, 0.0], [0.0, 2.6, -10.0], Projection::Perspective { fov: 0.016 });
    let share = unclear(&camera, &[&surface], [24, 1080], 11);
    assert!(share < 0.02, "{share} unclear");
}
