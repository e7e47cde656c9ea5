//! Tests of what blocks rays.

use trochoid_image::Format;
use trochoid_scene::bezier::Placement;
use trochoid_scene::{
    Camera, DVec3, Obstacles, Projection, Projector, Ray, SeaSurface, Segment, Surface, TriangleModel, Triangles,
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

/// Returns the only answer about a ray.
fn first(obstacles: &Obstacles, ray: Ray, limit: f64) -> Option<f64> {
    obstacles.first(&[Segment { ray, limit }])[0]
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
    model(mesh, 1.0)
}

fn model(mesh: Triangles, scale: f64) -> TriangleModel {
    let placement = Placement { scale: DVec3::splat(scale), rotate: DVec3::ZERO, translate: DVec3::ZERO };
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
            let found = first(&obstacles, ray, limit);
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
        let down = Ray { origin, direction };
        assert!(obstacles.blocks(&[Segment { ray: down, limit: 100.0 }])[0], "{origin}, {direction}");
        let up = Ray { origin, direction: -direction };
        assert_eq!(first(&obstacles, up, 1e9), None);
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
        errors.push((first(&obstacles, ray, 100.0).expect("the sea") - truth).abs());
    }
    errors.sort_by(f64::total_cmp);
    assert!(errors[count * 95 / 100] < 0.05, "{errors:?}");
}

/// Returns where a ray meets triangles as the documentation of [`Obstacles`] defines it, by trying one after another.
fn tried_in_turn((origin, triangles): &(DVec3, Vec<[[f32; 3]; 3]>), segment: &Segment) -> Option<f32> {
    fn minus(a: [f32; 3], b: [f32; 3]) -> [f32; 3] {
        [0, 1, 2].map(|axis| a[axis] - b[axis])
    }
    fn dot(a: [f32; 3], b: [f32; 3]) -> f32 {
        a[0] * b[0] + a[1] * b[1] + a[2] * b[2]
    }
    fn cross(a: [f32; 3], b: [f32; 3]) -> [f32; 3] {
        [a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]]
    }
    const EDGE: f32 = 1e-5;
    let narrow = |vector: DVec3| vector.to_array().map(|part| part as f32);
    let (start, direction) = (narrow(segment.ray.origin - *origin), narrow(segment.ray.direction));
    let inverse = direction.map(|part| if part.abs() < 1e-18 { 1e18 } else { 1.0 / part });
    let mut nearest = None;
    for &[p, q, r] in triangles {
        let (a, b) = (minus(q, p), minus(r, p));
        let across = cross(direction, b);
        let determinant = dot(a, across);
        let offset = minus(start, p);
        let along = cross(offset, a);
        let [u, v, distance] =
            [dot(offset, across), dot(direction, along), dot(b, along)].map(|value| value / determinant);
        let (mut near, mut far) = (0.0_f32, f32::INFINITY);
        let spans = [0, 1, 2].map(|axis| [p, q, r].map(|corner| corner[axis]));
        let low = spans.map(|[a, b, c]| a.min(b).min(c));
        let high = spans.map(|[a, b, c]| a.max(b).max(c));
        let margin = 2e-5 * minus(high, low).into_iter().fold(0.0, f32::max);
        for axis in 0..3 {
            let [x, y] = [low[axis] - margin, high[axis] + margin].map(|plane| (plane - start[axis]) * inverse[axis]);
            (near, far) = (near.max(x.min(y)), far.min(x.max(y)));
        }
        let entry = near * (1.0 - 4e-6);
        let passes = u >= -EDGE && v >= -EDGE && u + v <= 1.0 + EDGE && distance >= 0.0 && distance.is_finite();
        let met = distance.max(entry) + 0.0;
        if passes && entry <= far && met <= nearest.unwrap_or(segment.limit as f32) {
            nearest = Some(met);
        }
    }
    nearest
}

/// Checks that rays get the same answers, to the last bit, in packets, alone, in another order, with the slowest
/// instructions, and by trying all triangles in turn. Returns how many met something.
fn same_in_any_company(obstacles: &Obstacles, segments: &[Segment]) -> usize {
    let bits = |answers: &[Option<f64>]| -> Vec<Option<u64>> {
        answers.iter().map(|distance| distance.map(f64::to_bits)).collect()
    };
    let triangles = trochoid_scene::inside::triangles(obstacles);
    let found = bits(&obstacles.first(segments));
    let blocked = obstacles.blocks(segments);
    let backward: Vec<Segment> = segments.iter().rev().copied().collect();
    let mut turned = bits(&obstacles.first(&backward));
    turned.reverse();
    assert_eq!(found, turned);
    let slowly = trochoid_scene::inside::slowly(obstacles, segments);
    for (index, segment) in segments.iter().enumerate() {
        let plain = tried_in_turn(&triangles, segment).map(|distance| f64::from(distance).to_bits());
        assert_eq!(found[index], plain, "ray {index}: {segment:?}");
        assert_eq!(blocked[index], plain.is_some(), "ray {index}: {segment:?}");
        let (first_slowly, blocked_slowly) = slowly[index];
        assert_eq!((first_slowly.map(f64::to_bits), blocked_slowly), (plain, plain.is_some()), "ray {index}");
        assert_eq!(bits(&obstacles.first(&[*segment])), [plain], "ray {index}: {segment:?}");
    }
    found.iter().flatten().count()
}

#[test]
fn answers_depend_on_nothing_but_the_ray() {
    for count in [0, 1, 2, 7, 8, 9, 33, 400, 5000] {
        let model = soup(count);
        let (obstacles, mut random) = (Obstacles::new(&camera(), &[&model as &dyn Surface]), random(count + 3));
        let mut segments = Vec::new();
        for index in 0..if count > 1000 { 200 } else { 700 } {
            let origin = DVec3::new(random(), random(), random()) * 30.0 - 15.0;
            let direction = (DVec3::new(random(), random(), random()) - 0.5).normalize();
            let limit = [3.0 * random(), 100.0, f64::INFINITY, 0.0, -1.0][index % 5];
            // Some rays are neighbors of the one before, most are not.
            let near = segments.last().filter(|_| index % 7 > 3).copied();
            let ray = near.map_or(Ray { origin, direction }, |Segment { ray, .. }: Segment| Ray {
                origin: ray.origin + DVec3::new(random(), random(), random()) * 0.01,
                direction: (ray.direction + direction * 0.01).normalize(),
            });
            segments.push(Segment { ray, limit });
        }
        let met = same_in_any_company(&obstacles, &segments);
        assert!(count < 400 || met > 20, "{count}: {met}");
    }
}

#[test]
fn hostile_triangles_and_rays_get_the_same_answers_in_any_company() {
    let mut random = random(99);
    let mut mesh = Triangles::default();
    let mut add = |corners: [DVec3; 3]| {
        let first = mesh.positions.len() as u32;
        mesh.positions.extend(corners);
        mesh.triangles.push([first, first + 1, first + 2]);
    };
    let scales = [1e-30, 1e-12, 1e-3, 1.0, 1e6, 1e15];
    for index in 0..600 {
        let scale = scales[index % scales.len()];
        let mut point = || (DVec3::new(random(), random(), random()) - 0.5) * scale;
        let [a, b, c] = [point(), point(), point()];
        add(match index / scales.len() % 6 {
            0 => [a, b, c],
            // Points, lines, needles, and planes across the axes.
            1 => [a, a, a],
            2 => [a, b, a + (b - a) * 0.5],
            3 => [a, b, a + (c - a) * 1e-7],
            4 => [a, b, c].map(|corner| DVec3::new(corner.x, 0.0, corner.z)),
            _ => [a, b, c].map(|corner| DVec3::new(corner.x, corner.y, a.z)),
        });
    }
    // A thousand in one place.
    let same = [DVec3::ZERO, DVec3::X, DVec3::Y];
    (0..1000).for_each(|_| add(same));
    // By the second factor, some reach beyond the range of f32.
    for factor in [1.0, 1e23] {
        let corners: Vec<DVec3> = mesh.positions.iter().map(|corner| *corner * factor).collect();
        let model = model(mesh.clone(), factor);
        let obstacles = Obstacles::new(&camera(), &[&model as &dyn Surface]);
        let mut segments = Vec::new();
        for index in 0..400 {
            let corner = corners[(random() * corners.len() as f64) as usize];
            let toward = corners[(random() * corners.len() as f64) as usize];
            let away = (DVec3::new(random(), random(), random()) - 0.5).normalize();
            let origin = [corner, toward + away * toward.length(), DVec3::splat(1e300), away][index % 4];
            let direction = match index % 9 {
                0 => DVec3::X,
                1 => DVec3::NEG_Y,
                2 => DVec3::Z,
                3 => DVec3::new(0.6, 0.8, 0.0),
                4 => DVec3::new(1.0, 1e-20, -1e-40),
                5 => (corner - origin).try_normalize().unwrap_or(away),
                _ => away,
            };
            let limit = [1.0, 1e10, f64::INFINITY, f64::NAN, 1e-30][index % 5];
            segments.push(Segment { ray: Ray { origin, direction }, limit });
        }
        let met = same_in_any_company(&obstacles, &segments);
        assert!(met > 20, "{factor}: {met}");
    }
}

#[test]
fn threads_do_not_change_a_tree() {
    let spectrum = GerstnerSpectrum { count: 12, ..GerstnerSpectrum::default() };
    let sea = SeaSurface::new(&Sea::new(spectrum.waves().expect("valid")), 1.0, 0.0);
    let model = soup(20_000);
    let surfaces: [&dyn Surface; 2] = [&sea, &model];
    let with = |threads: usize| {
        let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build().expect("threads");
        format!("{:?}", pool.install(|| Obstacles::new(&camera(), &surfaces)))
    };
    let alone = with(1);
    assert!(alone.len() > 1_000_000);
    assert!(alone == with(3));
}
