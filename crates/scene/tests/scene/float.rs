//! Tests of bodies that float on seas: heights against points that are known to lie there, planes against general
//! least squares, and floating models against their f64 rays.

use std::sync::Arc;

use crate::random::Draw;
use trochoid_image::Format;
use trochoid_scene::bezier::{Bicubic, Patch, PatchModel, Placement, Tessellation};
use trochoid_scene::{
    Camera, Channel, ChannelSet, DVec3, Floating, GridSurface, Pose, Projection, RigidBodies, Samples, SeaSurface,
    Surface, Topology, Visible, reference,
};
use trochoid_sea::{ExplicitWave, GerstnerSpectrum, Sea, Wave};

fn sea(sharpness: f64, wavelength: f64, seed: u64, time: f64) -> SeaSurface {
    let spectrum = GerstnerSpectrum {
        count: 24,
        wavelength,
        spread: 0.4,
        height: wavelength / 15.0,
        sharpness,
        seed,
        ..GerstnerSpectrum::default()
    };
    SeaSurface::new(&Sea::new(spectrum.waves().expect("valid")), time, 3.0)
}

#[test]
fn heights_are_those_of_the_points_that_waves_carry_there() {
    let (mut draw, mut looked) = (Draw(3), 0);
    for seed in 0..60 {
        let (wavelength, far) = (10f64.powf(6.0 * draw.next() - 2.0), 10f64.powf(7.0 * draw.next()));
        let surface = sea(0.45, wavelength, seed, far * draw.next());
        let footprint = if seed % 2 == 0 { 0.0 } else { 0.4 * wavelength * draw.next() };
        for _ in 0..20 {
            let rest = [far * (draw.next() - 0.5), far * (draw.next() - 0.5)];
            let (point, normal, _) = surface.point(rest, footprint);
            // Near a fold, steps are limited.
            if normal.y < 0.15 {
                continue;
            }
            looked += 1;
            let found = surface.height_at([point.x, point.z], footprint).expect("a sea");
            // A position is known to 1e-12 of its distance; slopes are at most a few units.
            let tolerance = 1e-9 * wavelength + 1e-11 * far;
            assert!((found - point.y).abs() <= tolerance, "{found} for {}, {wavelength} m at {far} m", point.y);
        }
    }
    assert!(looked > 1100, "{looked} of 1200 places lie away from folds");
}

#[test]
fn folded_seas_and_empty_ones_have_heights() {
    let mut draw = Draw(4);
    for sharpness in [1.5, 4.0, 10.0] {
        let mut steps = 0.0f64;
        for place in 0..40 {
            let place = [f64::from(place) * 1.7, 100.0 * draw.next()];
            let floating = Floating { place, heading: 1.0, hull: [4.0, 2.0], lift: 0.0, tilt: 1.0 };
            let water = |time: f64| floating.water(&sea(sharpness, 12.0, 9, time)).expect("a sea");
            let time = 50.0 * draw.next();
            let (now, next) = (water(time), water(time + 1.0 / 240.0));
            let bound = 3.0 + 24.0 * 0.8;
            assert!(now.height.abs() < bound && now.slopes.iter().all(|slope| slope.abs() < 20.0), "{now:?}");
            steps = steps.max((now.height - next.height).abs());
        }
        // Crests of 0.8 m rise at less than 2 m/s: 8 mm in that time. A jump of the hull would be as large as a
        // crest.
        assert!(steps < 0.1, "sharpness {sharpness}: a jump of {steps} m");
    }
    let flat = SeaSurface::new(&Sea::default(), 1.0, -2.5);
    assert_eq!(flat.height_at([1e9, -1e9], 0.0), Some(-2.5));
}

#[test]
fn grids_go_on_beyond_their_edge() {
    let heights: Vec<f32> = (0..12).map(|cell| (cell % 4) as f32 + 10.0 * (cell / 4) as f32).collect();
    let grid = GridSurface::new(heights, 4, 0.3, [1.0, 2.0], 5.0);
    for (place, height) in [
        ([1.0, 2.0], 0.0),
        ([1.3, 2.3], 11.0),
        ([1.9, 2.6], 23.0),
        ([1e9, 1e9], 23.0),
        ([-7.0, 2.6], 20.0),
        ([1.0 + 3.0 * 0.3, -1e300], 3.0),
    ] {
        let found = grid.height_at(place, 0.0).expect("a sea");
        assert!((found - 5.0 - height).abs() < 1e-9, "{place:?}: {found}");
    }
}

/// Fits the plane by the normal equations of any points, solved by Cramer's rule.
fn least_squares(points: &[[f64; 3]]) -> [f64; 3] {
    let (mut a, mut b) = ([[0.0; 3]; 3], [0.0; 3]);
    for [u, v, y] in points {
        let row = [1.0, *u, *v];
        for (along, (a, b)) in row.iter().zip(a.iter_mut().zip(&mut b)) {
            *b += along * y;
            a.iter_mut().zip(row).for_each(|(a, other)| *a += along * other);
        }
    }
    let determinant = |a: [[f64; 3]; 3]| DVec3::from(a[0]).dot(DVec3::from(a[1]).cross(DVec3::from(a[2])));
    std::array::from_fn(|column| {
        let mut replaced = a;
        replaced.iter_mut().zip(b).for_each(|(row, b)| row[column] = b);
        determinant(replaced) / determinant(a)
    })
}

#[test]
fn the_plane_is_that_of_least_squares() {
    let mut draw = Draw(5);
    for seed in 0..30 {
        let surface = sea(0.5, 20.0, seed, 40.0 * draw.next());
        let floating = Floating {
            place: [200.0 * draw.next(), -300.0 * draw.next()],
            heading: 7.0 * draw.next() - 3.0,
            hull: [0.1 + 20.0 * draw.next(), 0.1 + 8.0 * draw.next()],
            lift: 0.0,
            tilt: 1.0,
        };
        let (sin, cos) = floating.heading.sin_cos();
        let [length, width] = floating.hull;
        let mut points = Vec::new();
        for (i, j) in (0..9).flat_map(|i| (0..5).map(move |j| (f64::from(i), f64::from(j)))) {
            let (u, v) = (length * ((i + 0.5) / 9.0 - 0.5), width * ((j + 0.5) / 5.0 - 0.5));
            let place = [floating.place[0] + u * cos - v * sin, floating.place[1] + u * sin + v * cos];
            points.push([u, v, surface.height_at(place, (length / 9.0).max(width / 5.0)).expect("a sea")]);
        }
        let [height, bow, starboard] = least_squares(&points);
        let water = floating.water(&surface).expect("a sea");
        let error = (water.height - height).abs() + (water.slopes[0] - bow).abs() + (water.slopes[1] - starboard).abs();
        assert!(error < 1e-9, "{water:?} for {height}, {bow}, {starboard}");
    }
}

#[test]
fn bodies_follow_long_waves_and_ignore_short_ones() {
    let plain = |wavelength: f64| {
        let wave = ExplicitWave { wavelength, amplitude: 0.5, direction: 0.7, sharpness: 0.0, phase: 0.3, speed: None };
        SeaSurface::new(&Sea::new(vec![Wave::try_from(wave).expect("valid")]), 2.0, 0.0)
    };
    let floating = Floating { place: [3.0, -8.0], heading: 0.7, hull: [6.0, 2.0], lift: 0.0, tilt: 1.0 };
    let long = plain(2000.0);
    let (point, normal, _) = long.point(floating.place, 0.0);
    let pose = floating.pose(&long).expect("a sea");
    assert!((pose.origin - point).length() < 1e-4 && pose.axes[1].dot(normal.normalize()) > 1.0 - 1e-9);
    let short = floating.water(&plain(0.3)).expect("a sea");
    assert!(short.height.abs() < 0.02 && short.slopes.iter().all(|slope| slope.abs() < 0.02), "{short:?}");
    let upright = Floating { tilt: 0.0, lift: 1.5, ..floating }.pose(&long).expect("a sea");
    assert_eq!(upright.axes[1], DVec3::Y);
    assert!((upright.origin.y - pose.origin.y - 1.5).abs() < 1e-12);
    assert_eq!(floating.pose(&hull()), None, "a model is no sea");
}

/// Returns a random, curved and open model.
fn hull() -> PatchModel {
    let mut draw = Draw(6);
    let patches: Vec<Patch> = (0..4)
        .map(|_| {
            let points = std::array::from_fn(|index| {
                DVec3::new((index % 4) as f64 - 1.5, 0.0, (index / 4) as f64 - 1.5) + draw.point(0.8)
            });
            Patch::new(Bicubic { points })
        })
        .collect();
    PatchModel::new(&patches, Placement::default(), false, Tessellation::Adaptive { tolerance: 0.1 })
}

fn camera(position: [f64; 3], projection: Projection) -> Camera {
    Camera { position: DVec3::from(position), target: DVec3::new(0.0, 0.5, 0.0), roll: 0.3, projection }
}

#[test]
fn a_body_that_is_not_moved_keeps_every_bit() {
    let axes = [DVec3::X, DVec3::Y, DVec3::Z];
    let same = RigidBodies::new(Arc::new(hull()), vec![Pose { axes, origin: DVec3::ZERO }]);
    let format = Format::new(64, 36, 1).expect("valid");
    let projector = camera([2.0, 3.0, 9.0], Projection::Perspective { fov: 0.8 }).projector(format);
    let [same, own] = [&same as &dyn Surface, &hull()].map(|surface| surface.tessellate(&projector, ChannelSet::ALL));
    assert_eq!((same.positions, same.normals, same.rests), (own.positions, own.normals, own.rests));
    assert_eq!((same.rest_heights, same.uvs, same.topology), (own.rest_heights, own.uvs, own.topology));
}

#[test]
fn floating_models_agree_with_their_rays() {
    let surface = sea(0.5, 14.0, 2, 3.0);
    let poses: Vec<Pose> = [([-2.5, 0.0], 0.4), ([1.5, 1.0], 2.9), ([0.0, -4.0], -1.0), ([900.0, 0.0], 0.0)]
        .into_iter()
        .map(|(place, heading)| Floating { place, heading, hull: [3.0, 2.0], lift: 0.2 - 3.0, tilt: 2.0 })
        .map(|floating| floating.pose(&surface).expect("a sea"))
        .collect();
    for pose in &poses {
        let [x, y, z] = pose.axes;
        assert!((x.cross(y) - z).length() < 1e-12 && x.dot(y).abs() < 1e-12 && (x.length() - 1.0).abs() < 1e-12);
    }
    let sea_bodies = RigidBodies::new(
        Arc::new(GridSurface::new((0..64).map(|cell| ((cell * 7) % 5) as f32 * 0.1).collect(), 8, 0.4, [-1.4; 2], 0.0)),
        poses.clone(),
    );
    let bodies = RigidBodies::new(Arc::new(hull()), poses);
    let format = Format::new(160, 90, 1).expect("valid");
    for surface in [&bodies, &sea_bodies] {
        for projection in [Projection::Perspective { fov: 0.8 }, Projection::Orthographic { height: 9.0 }] {
            let camera = camera([2.0, 6.0, 12.0], projection);
            let projector = camera.projector(format);
            assert!(matches!(surface.tessellate(&projector, ChannelSet::ALL).topology, Topology::Triangles(_)));
            let visible = Visible::prepare(&camera, &[surface], format, ChannelSet::ALL);
            let mut samples = Samples::new();
            visible.fill(format.window(), [0.5, 0.5], ChannelSet::ALL, &mut samples);
            let (mut good, mut seen, mut all) = (0.0, 0.0, 0.0);
            for index in (0..160 * 90).step_by(41) {
                let at = |channel: Channel| f64::from(samples.channel(channel)[index]);
                let (x, y) = ((index % 160) as f64 + 0.5, (index / 160) as f64 + 0.5);
                all += 1.0;
                let Ok(Some(hit)) = reference::trace(&camera, &[surface], format, x, y) else {
                    good += 1.0 - at(Channel::Coverage);
                    continue;
                };
                seen += 1.0;
                let three = |of: [Channel; 3]| DVec3::from(of.map(at));
                let normal = three([Channel::NormalX, Channel::NormalY, Channel::NormalZ]);
                let position = three([Channel::PositionX, Channel::PositionY, Channel::PositionZ]);
                let rest = three([Channel::RestX, Channel::RestY, Channel::RestZ]);
                let agrees = at(Channel::Coverage) == 1.0
                    && (at(Channel::Depth) - hit.depth).abs() < 0.05
                    && (position - hit.position).length() < 0.05
                    && (rest - hit.rest).length() < 0.05
                    && (at(Channel::Height) - hit.height).abs() < 0.05
                    && (at(Channel::RestDistance) - hit.rest_distance).abs() < 0.05
                    && (at(Channel::U) - hit.uv[0]).abs() + (at(Channel::V) - hit.uv[1]).abs() < 0.05
                    && at(Channel::Jacobian) == 1.0
                    && normal.dot(hit.normal) > 0.99;
                good += f64::from(u8::from(agrees));
            }
            assert!(good / all >= 0.95 && seen / all > 0.05, "{projection:?}: {good} of {all}, {seen} seen");
        }
    }
}
