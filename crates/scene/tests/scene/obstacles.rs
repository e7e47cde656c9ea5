//! Tests of what blocks rays.

use trochoid_image::Format;
use trochoid_scene::bezier::Placement;
use trochoid_scene::{
    Camera, DVec3, Obstacles, Projection, Projector, Ray, SeaSurface, Surface, TriangleModel, Triangles,
    first_reference, surroundings,
};
use trochoid_sea::{GerstnerSpectrum, Sea};

fn camera() -> Projector {
    let camera = Camera {
        position: DVec3::new(0.0, 6.0, 30.0),
        target: DVec3::new(0.0, 2.0, 0.0),
        roll: 0.0,
        projection: Projection::Perspective { fov: 0.7 },
    };
    camera.projector(Format::new(320, 180, 1).expect("valid"))
}

/// Returns pseudorandom numbers in [0, 1).
fn random(count: usize) -> impl FnMut() -> f64 {
    let mut state = count as u64;
    move || {
        state = state.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1_442_695_040_888_963_407);
        (state >> 11) as f64 / (1_u64 << 53) as f64
    }
}

/// Returns random triangles, some of them without area, some many times as large as others.
fn soup(count: usize) -> TriangleModel {
    let mut random = random(count);
    let mut mesh = Triangles::default();
    for index in 0..count {
        let middle = DVec3::new(random(), random(), random()) * 20.0 - 10.0;
        let size = [0.1, 1.0, 15.0, 0.0][index % 4];
        for _ in 0..3 {
            let away = DVec3::new(random(), random(), random()) - 0.5;
            mesh.positions.push(middle + away * size);
        }
        let first = 3 * index as u32;
        mesh.triangles.push([first, first + 1, first + 2]);
    }
    let placement = Placement { scale: DVec3::ONE, rotate: DVec3::ZERO, translate: DVec3::ZERO };
    TriangleModel::new(mesh, placement, false).expect("a mesh")
}

#[test]
fn rays_meet_what_the_reference_says() {
    for count in [0, 1, 8, 9, 33, 1000] {
        let model = soup(count);
        let surfaces: [&dyn Surface; 1] = [&model];
        let (projector, mut random) = (camera(), random(count + 7));
        let obstacles = Obstacles::new(&projector, &surfaces);
        let mut met = 0;
        for index in 0..500 {
            let origin = DVec3::new(random(), random(), random()) * 30.0 - 15.0;
            let direction = (DVec3::new(random(), random(), random()) - 0.5).normalize();
            // Directions include the axes.
            let direction = [direction, DVec3::X, DVec3::NEG_Y, DVec3::Z][index % 4];
            let (ray, limit) = (Ray { origin, direction }, 20.0 * random());
            let truth = first_reference(&projector, &surfaces, &ray, limit).expect("smooth");
            let found = obstacles.first(&ray, limit);
            assert_eq!(obstacles.blocks(&ray, limit), found.is_some());
            // A ray may pass an edge on either side, or end just before a triangle.
            let closer = |a: f64| model_is_near(&model, &projector, &ray, a);
            match (found, truth) {
                (Some(found), Some(truth)) if (found - truth).abs() < 1e-3 => met += 1,
                (None, None) => {}
                (found, truth) => {
                    let at = found.into_iter().chain(truth).fold(f64::INFINITY, f64::min);
                    assert!(closer(at), "{count}, ray {index}: {found:?}, expected {truth:?} within {limit}");
                }
            }
        }
        assert!(count < 1000 || met > 200, "{met} of 500 rays met something");
    }
}

/// Returns whether slightly shifted rays also disagree about a distance: the point is then on an edge.
fn model_is_near(model: &TriangleModel, projector: &Projector, ray: &Ray, distance: f64) -> bool {
    let steps = [DVec3::X, DVec3::Y, DVec3::Z, DVec3::NEG_X, DVec3::NEG_Y, DVec3::NEG_Z];
    let answers: Vec<bool> = steps
        .iter()
        .map(|step| Ray { origin: ray.origin + *step * 1e-3, ..*ray })
        .map(|ray| {
            model
                .trace(projector, &ray, f64::INFINITY)
                .unwrap()
                .is_some_and(|hit| (hit.distance - distance).abs() < 0.05)
        })
        .collect();
    answers.iter().any(|answer| *answer) && answers.iter().any(|answer| !*answer)
}

#[test]
fn no_ray_slips_through_a_sea() {
    let spectrum = GerstnerSpectrum { count: 30, ..GerstnerSpectrum::default() };
    let sea = SeaSurface::new(&Sea::new(spectrum.waves().expect("valid")), 3.0, 0.5);
    let (projector, mut random) = (camera(), random(1));
    let obstacles = Obstacles::new(&projector, &[&sea]);
    for _ in 0..20_000 {
        let origin = DVec3::new(8.0 * random() - 4.0, 20.0, 15.0 - 30.0 * random());
        let direction = (DVec3::new(random() - 0.5, -3.0, random() - 0.5)).normalize();
        assert!(obstacles.blocks(&Ray { origin, direction }, 100.0), "{origin}, {direction}");
        let up = Ray { origin, direction: -direction };
        assert_eq!(obstacles.first(&up, 1e9), None);
    }
}

#[test]
fn agrees_with_the_continuous_sea() {
    let spectrum = GerstnerSpectrum { count: 12, ..GerstnerSpectrum::default() };
    let sea = SeaSurface::new(&Sea::new(spectrum.waves().expect("valid")), 1.0, 0.0);
    let surfaces: [&dyn Surface; 1] = [&sea];
    let (projector, mut random) = (surroundings(&camera(), 0.5, 2.0), random(3));
    let obstacles = Obstacles::new(&projector, &surfaces);
    let (mut errors, count) = (Vec::new(), 200);
    for _ in 0..count {
        let origin = DVec3::new(8.0 * random() - 4.0, 6.0, 10.0 - 20.0 * random());
        let direction = DVec3::new(random() - 0.5, -0.7, random() - 0.5).normalize();
        let ray = Ray { origin, direction };
        let truth = first_reference(&projector, &surfaces, &ray, 100.0).expect("smooth").expect("the sea");
        errors.push((obstacles.first(&ray, 100.0).expect("the sea") - truth).abs());
    }
    errors.sort_by(f64::total_cmp);
    assert!(errors[count * 95 / 100] < 0.05, "{errors:?}");
}
