//! Tests of Bézier patches: evaluation in every order, normals, rails, joints, and crack-free tessellation against
//! f64 rays.

use std::collections::HashMap;

use crate::random::Draw;
use trochoid_image::{Format, Window};
use trochoid_scene::bezier::{
    Bicubic, Bilinear, MAX_SEGMENTS, Patch, PatchModel, Placement, Rails, RailsError, Tessellation, UnitNormal,
    continuity,
};
use trochoid_scene::{
    Camera, Channel, ChannelSet, DVec3, Projection, Ray, Samples, Surface, Topology, TriangleModel, Triangles,
    TrianglesError, Visible, reference,
};

fn random_patch(draw: &mut Draw, size: f64) -> Bicubic {
    Bicubic { points: std::array::from_fn(|_| draw.point(size)) }
}

#[test]
fn both_orders_and_the_matrix_agree() {
    let mut draw = Draw(1);
    for size in [1e-6, 1.0, 1e7] {
        for _ in 0..200 {
            let patch = random_patch(&mut draw, size);
            let (u, v) = (draw.next(), draw.next());
            let point = patch.evaluate(u, v);
            assert!((point - patch.evaluate_v_first(u, v)).length() <= 1e-14 * size);
            // Powers cancel: their coefficients are up to 36 times as large.
            assert!((point - patch.evaluate_by_matrix(u, v)).length() <= 1e-13 * size);
            let saddle = Bilinear { points: std::array::from_fn(|_| draw.point(size)) };
            let point = saddle.evaluate(u, v);
            assert!((point - saddle.evaluate_v_first(u, v)).length() <= 1e-15 * 4.0 * size);
            assert!((point - saddle.evaluate_by_matrix(u, v)).length() <= 1e-15 * 4.0 * size);
            assert!((point - saddle.elevate().evaluate(u, v)).length() <= 1e-14 * size);
            let [along_u, along_v] = saddle.tangents(u, v);
            let [up_u, up_v] = saddle.elevate().tangents(u, v);
            assert!((along_u - up_u).length() + (along_v - up_v).length() <= 1e-13 * size);
        }
    }
}

#[test]
fn corners_are_met_and_quarters_are_the_patch() {
    let mut draw = Draw(2);
    for _ in 0..50 {
        let patch = random_patch(&mut draw, 3.0);
        assert_eq!(patch.evaluate(0.0, 0.0), patch.points[0]);
        assert!((patch.evaluate(1.0, 1.0) - patch.points[15]).length() < 1e-14);
        let (u, v) = (draw.next(), draw.next());
        for (index, quarter) in patch.quarters().iter().enumerate() {
            let place = [index % 2, index / 2].map(|half| half as f64);
            let whole = patch.evaluate((place[0] + u) / 2.0, (place[1] + v) / 2.0);
            assert!((quarter.evaluate(u, v) - whole).length() < 1e-14);
        }
    }
}

#[test]
fn tangents_are_derivatives() {
    let mut draw = Draw(3);
    for _ in 0..100 {
        let patch = random_patch(&mut draw, 1.0);
        let (u, v, h) = (draw.next(), draw.next(), 1e-5);
        let [along_u, along_v] = patch.tangents(u, v);
        let slope_u = (patch.evaluate(u + h, v) - patch.evaluate(u - h, v)) / (2.0 * h);
        let slope_v = (patch.evaluate(u, v + h) - patch.evaluate(u, v - h)) / (2.0 * h);
        assert!((along_u - slope_u).length() < 1e-8 && (along_v - slope_v).length() < 1e-8);
        let taylor = patch.taylor(u, v);
        let (a, b) = (0.3, -0.2);
        let power = |base: f64, n: usize| base.powi(n as i32);
        let series: DVec3 = (0..16).map(|k| taylor[k / 4][k % 4] * power(a, k % 4) * power(b, k / 4)).sum();
        assert!((series - patch.evaluate(u + a, v + b)).length() < 1e-12);
    }
}

/// Returns a patch over [0, 1]² in x and z with a given height function, with its outer side up.
fn sheet(height: impl Fn(f64, f64) -> f64) -> Bicubic {
    Bicubic {
        points: std::array::from_fn(|index| {
            let (x, z) = ((index % 4) as f64 / 3.0, (index / 4) as f64 / 3.0);
            DVec3::new(x, height(x, z), 1.0 - z)
        }),
    }
}

#[test]
fn normals_where_tangents_vanish_are_limits() {
    let regular = sheet(|_, _| 0.0);
    assert_eq!(regular.normal(0.3, 0.6), UnitNormal::Regular(DVec3::Y));
    // A cap: the edge at v = 0 is the pole, where the surface is level.
    let mut cap = sheet(|_, _| 0.0);
    for (index, point) in cap.points.iter_mut().enumerate() {
        let (i, j) = (index % 4, index / 4);
        let angle = -0.5 * std::f64::consts::PI * i as f64 / 3.0;
        let (radius, height) = ([0.0, 0.5, 1.0, 1.0][j], [1.0, 1.0, 0.5, 0.0][j]);
        *point = DVec3::new(radius * angle.cos(), height, radius * angle.sin());
    }
    for u in [0.0, 0.2, 0.5, 1.0] {
        let normal = cap.normal(u, 0.0);
        assert!(matches!(normal, UnitNormal::Limit(_)), "{normal:?}");
        assert!((normal.vector().y.abs() - 1.0).abs() < 1e-12, "{normal:?}");
        // It is the limit: the normal of a point nearby is nearly the same.
        assert!((cap.normal(u, 1e-6).vector() - normal.vector()).length() < 1e-4);
    }
    // If both handles of a corner coincide with it, both tangents vanish there.
    let mut corner = sheet(|x, z| x * z);
    (corner.points[1], corner.points[4]) = (corner.points[0], corner.points[0]);
    let normal = corner.normal(0.0, 0.0);
    assert!(matches!(normal, UnitNormal::Limit(_)), "{normal:?}");
    let near = corner.normal(1e-5, 1e-5).vector();
    assert!((near - normal.vector()).length() < 1e-3, "{near} {normal:?}");
    // Degenerate patches: a point, and a line.
    let point = Bicubic { points: [DVec3::new(1.0, 2.0, 3.0); 16] };
    assert_eq!(point.normal(0.5, 0.5), UnitNormal::None);
    let line = Bicubic { points: std::array::from_fn(|index| DVec3::X * (index % 4) as f64) };
    assert_eq!((line.normal(0.5, 0.5), line.normal(0.0, 1.0)), (UnitNormal::None, UnitNormal::None));
    assert_eq!(point.normal(0.0, 0.0).vector(), DVec3::Y);
}

fn rails(rails: Vec<Vec<DVec3>>, closed_u: bool, closed_v: bool) -> Vec<Patch> {
    Rails { rails, closed_u, closed_v }.patches().expect("rails that fit")
}

/// Returns a torus with its outer side outward: `around` points along the ring, `tube` points around the tube.
fn torus(around: usize, tube: usize) -> Vec<Patch> {
    let angle = |index: usize, count: usize| std::f64::consts::TAU * index as f64 / count as f64;
    let rail = |i: usize| {
        let ring = angle(i, around);
        (0..tube)
            .map(|j| {
                let (sin, cos) = angle(j, tube).sin_cos();
                DVec3::new((2.0 + 0.7 * cos) * ring.cos(), 0.7 * sin, (2.0 + 0.7 * cos) * ring.sin())
            })
            .collect()
    };
    rails((0..around).map(rail).collect(), true, true)
}

#[test]
fn rails_are_met_and_join_smoothly() {
    let mut draw = Draw(4);
    for (rows, columns) in [(2, 2), (2, 5), (3, 3), (4, 7)] {
        let points: Vec<Vec<DVec3>> = (0..rows).map(|_| (0..columns).map(|_| draw.point(1.0)).collect()).collect();
        let patches = rails(points.clone(), false, false);
        assert_eq!(patches.len(), (rows - 1) * (columns - 1));
        for (index, patch) in patches.iter().enumerate() {
            let (row, column) = (index / (columns - 1), index % (columns - 1));
            assert_eq!(patch.shape.points[0], points[row][column]);
            assert_eq!(patch.shape.points[15], points[row + 1][column + 1]);
        }
        let report = continuity(patches.iter().map(|patch| &patch.shape));
        let joints = (rows - 1) * (columns - 2) + (rows - 2) * (columns - 1);
        assert_eq!((report.joints, report.exact, report.equal_handles), (joints, joints, joints), "{report}");
        assert_eq!((report.widest_gap, report.smooth), (0.0, joints), "{report}");
        assert_eq!(report.open, 2 * (rows + columns - 2), "{report}");
    }
    // Parabolas are reproduced exactly.
    let bowl = |x: f64, z: f64| DVec3::new(x, x * x - 0.5 * z * z + x * z, z);
    let points = (0..4).map(|z| (0..5).map(|x| bowl(f64::from(x), f64::from(z))).collect()).collect();
    for (index, patch) in rails(points, false, false).iter().enumerate() {
        let (u, v) = (0.3, 0.8);
        let (x, z) = ((index % 4) as f64 + u, (index / 4) as f64 + v);
        assert!((patch.shape.evaluate(u, v) - bowl(x, z)).length() < 1e-13);
    }
    let whole = torus(8, 6);
    let report = continuity(whole.iter().map(|patch| &patch.shape));
    assert_eq!((report.patches, report.joints, report.open), (48, 96, 0), "{report}");
    assert_eq!((report.exact, report.equal_handles), (96, 96), "{report}");
}

#[test]
fn rails_that_do_not_fit_are_refused() {
    let of = |rails: Vec<Vec<DVec3>>| Rails { rails, closed_u: false, closed_v: false }.patches().map(|p| p.len());
    assert_eq!(of(vec![vec![DVec3::X; 3]]), Err(RailsError::Rails(1)));
    let uneven = RailsError::Points { rail: 1, found: 2, expected: 3 };
    assert_eq!(of(vec![vec![DVec3::X; 3], vec![DVec3::Y; 2]]), Err(uneven));
    assert_eq!(of(vec![vec![DVec3::X], vec![DVec3::Y]]), Err(RailsError::Points { rail: 0, found: 1, expected: 2 }));
    assert_eq!(of(vec![vec![DVec3::X; 40_000]; 2]), Err(RailsError::TooMany(80_000)));
}

#[test]
fn the_report_sees_gaps_and_creases() {
    let left = sheet(|_, _| 0.0);
    let moved = |by: DVec3| left.map(|point| point + by);
    let report = continuity([&left, &moved(DVec3::new(1.0, 2e-5, 0.0))]);
    assert_eq!((report.joints, report.exact, report.open), (1, 0, 6), "{report}");
    assert!((report.widest_gap - 2e-5).abs() < 1e-12, "{report}");
    // A roof: the right half falls at 45 degrees.
    let roof = sheet(|x, _| -x).map(|point| point + DVec3::X);
    let report = continuity([&left, &roof]);
    assert_eq!((report.joints, report.smooth, report.equal_handles), (1, 0, 0), "{report}");
    assert!((report.greatest_angle.to_degrees() - 45.0).abs() < 1e-9, "{report}");
    assert_eq!(continuity([&left, &moved(DVec3::X * 3.0)]).joints, 0);
    assert_eq!(continuity([]).patches, 0);
    // Turned over, the neighbor still joins smoothly.
    let over = Bicubic { points: std::array::from_fn(|i| moved(DVec3::X).points[4 * (i / 4) + 3 - i % 4]) };
    assert_eq!(continuity([&left, &over]).smooth, 1);
}

fn look(position: [f64; 3], target: [f64; 3]) -> Camera {
    let projection = Projection::Perspective { fov: 0.8 };
    Camera { position: DVec3::from(position), target: DVec3::from(target), roll: 0.0, projection }
}

const ADAPTIVE: Tessellation = Tessellation::Adaptive { tolerance: 0.1 };

fn format() -> Format {
    Format::new(160, 120, 4).expect("valid")
}

#[test]
fn closed_models_have_no_crack() {
    let patches = torus(5, 4);
    let cameras =
        [look([0.0, 2.0, 6.0], [0.0; 3]), look([0.4, 0.1, 2.9], [0.4, 0.0, 0.0]), look([90.0, 40.0, 0.0], [0.0; 3])];
    let rotate = DVec3::new(0.3, -1.1, 2.0);
    for camera in cameras {
        for tessellation in [ADAPTIVE, Tessellation::Uniform { segments: 5 }, Tessellation::Uniform { segments: 0 }] {
            for placement in
                [Placement::default(), Placement { rotate, scale: DVec3::new(1.0, -1.0, 1.0), ..Placement::default() }]
            {
                let model = PatchModel::new(&patches, placement, false, tessellation);
                // All patches are in front of every camera. The mesh is cut for the camera's picture, but no patch is
                // left out for lying beside it.
                let mut projector = camera.projector(format());
                projector.size = [1e9, 1e9];
                let mesh = model.tessellate(&projector, ChannelSet::NORMAL);
                let Topology::Triangles(triangles) = &mesh.topology else { panic!("triangles") };
                let mut sides: HashMap<_, i64> = HashMap::new();
                let at = |vertex: u32| mesh.positions[vertex as usize].map(|part| (part + 0.0).to_bits());
                for triangle in triangles {
                    for (from, to) in [(0, 1), (1, 2), (2, 0)] {
                        let (a, b) = (at(triangle[from]), at(triangle[to]));
                        // A side and the same side backward cancel.
                        *sides.entry((a.min(b), a.max(b))).or_default() += if a < b { 1 } else { -i64::from(a != b) };
                    }
                }
                assert!(sides.values().all(|sum| *sum == 0), "{tessellation:?}");
                assert_eq!(model.without_normal(&projector), 0);
            }
        }
    }
}

/// Returns the share of samples at which view and rays agree.
fn agreement(camera: &Camera, surface: &dyn Surface, tolerance: f64) -> f64 {
    let format = Format::new(80, 60, 1).expect("valid");
    let visible = Visible::prepare(camera, &[surface], format, ChannelSet::ALL);
    let mut samples = Samples::new();
    visible.fill(format.window(), [0.5, 0.5], ChannelSet::ALL, &mut samples);
    let (mut good, mut all) = (0, 0);
    for index in (0..80 * 60).step_by(7) {
        let at = |channel: Channel| f64::from(samples.channel(channel)[index]);
        let vector = |channels: [Channel; 3]| DVec3::from(channels.map(at));
        let hit = reference::trace(camera, &[surface], format, (index % 80) as f64 + 0.5, (index / 80) as f64 + 0.5)
            .expect("a first point");
        all += 1;
        good += usize::from(match hit {
            None => at(Channel::Coverage) == 0.0,
            Some(hit) => {
                let near = |a: DVec3, b: DVec3| (a - b).length() <= tolerance * hit.depth;
                at(Channel::Coverage) == 1.0
                    && near(vector([Channel::PositionX, Channel::PositionY, Channel::PositionZ]), hit.position)
                    && near(vector([Channel::RestX, Channel::RestY, Channel::RestZ]), hit.rest)
                    && (vector([Channel::NormalX, Channel::NormalY, Channel::NormalZ]) - hit.normal).length() < 0.02
                    && (at(Channel::U) - hit.uv[0]).abs() + (at(Channel::V) - hit.uv[1]).abs() < 0.01
                    && (at(Channel::RestDistance) - hit.rest_distance).abs() < tolerance * hit.depth
                    && (at(Channel::Height) - hit.height).abs() < tolerance * hit.depth
                    && (at(Channel::Depth) - hit.depth).abs() < tolerance * hit.depth
            }
        });
    }
    good as f64 / all as f64
}

#[test]
fn the_view_agrees_with_rays() {
    let placement = Placement {
        scale: DVec3::new(1.0, 1.3, 0.8),
        rotate: DVec3::new(0.5, 0.2, -0.4),
        translate: DVec3::new(1.0, -2.0, 0.5),
    };
    let camera = look([3.0, 3.0, 7.0], [1.0, -2.0, 0.5]);
    for flip in [false, true] {
        let model = PatchModel::new(&torus(8, 6), placement, flip, ADAPTIVE);
        let share = agreement(&camera, &model, 2e-3);
        assert!(share > 0.97, "{share}");
    }
    let parallel = Camera { projection: Projection::Orthographic { height: 6.0 }, ..camera };
    let share = agreement(&parallel, &PatchModel::new(&torus(8, 6), placement, false, ADAPTIVE), 2e-3);
    assert!(share > 0.97, "{share}");
    // An open, wavy sheet, seen from below.
    let mut draw = Draw(5);
    let points = (0..5).map(|z| (0..5).map(|x| DVec3::new(f64::from(x), draw.next(), -f64::from(z))).collect());
    let model = PatchModel::new(&rails(points.collect(), false, false), Placement::default(), false, ADAPTIVE);
    let share = agreement(&look([2.0, -5.0, 1.0], [2.0, 0.0, -2.0]), &model, 2e-3);
    assert!(share > 0.97, "{share}");
}

#[test]
fn rays_meet_every_patch_of_a_model_that_lies_before_them() {
    let mut draw = Draw(23);
    let projector = look([0.0, 3.0, 9.0], [0.0; 3]).projector(format());
    for _ in 0..60 {
        // Flat patches at right angles to the axes, some in the planes of the origin, and curved ones.
        let shapes: Vec<Bicubic> = (0..40)
            .map(|index| {
                let (middle, size) = (draw.point(4.0), 0.1 + draw.next());
                let mut shape = random_patch(&mut draw, size);
                for (place, point) in shape.points.iter_mut().enumerate() {
                    let flat = [(place % 4) as f64 - 1.5, (place / 4) as f64 - 1.5].map(|along| size * along);
                    *point = match index % 4 {
                        0 => DVec3::new(0.0, middle.y + flat[0], middle.z + flat[1]),
                        1 => DVec3::new(middle.x + flat[0], 0.0, middle.z + flat[1]),
                        2 => DVec3::new(middle.x + flat[0], middle.y + flat[1], middle.z),
                        _ => middle + *point,
                    };
                }
                shape
            })
            .collect();
        let patches: Vec<Patch> = shapes.iter().copied().map(Patch::new).collect();
        let model = PatchModel::new(&patches, Placement::default(), false, Tessellation::Uniform { segments: 4 });
        for (index, shape) in shapes.iter().enumerate() {
            let point = shape.evaluate(0.05 + 0.9 * draw.next(), 0.05 + 0.9 * draw.next());
            let away = match draw.next() {
                part if part < 0.3 => [DVec3::X, DVec3::Y, DVec3::Z, DVec3::X][index % 4] * 5.0,
                _ => draw.point(30.0),
            };
            let ray = Ray { origin: point + away, direction: -away.normalize() };
            let met = model.trace(&projector, &ray, f64::INFINITY).expect("never given up");
            let met = met.unwrap_or_else(|| panic!("patch {index} lies before {ray:?}"));
            assert!(met.distance <= away.length() * (1.0 + 1e-6) + 1e-6, "patch {index} is nearer than {met:?}");
        }
    }
}

#[test]
fn windows_and_channels_do_not_change_a_bit() {
    let model = PatchModel::new(&torus(6, 5), Placement::default(), false, ADAPTIVE);
    let camera = look([1.0, 2.0, 5.0], [0.5, 0.0, 0.0]);
    let fill = |prepared: ChannelSet, wanted: ChannelSet, window: Window| {
        let mut samples = Samples::new();
        Visible::prepare(&camera, &[&model], format(), prepared).fill(window, [0.25, 0.75], wanted, &mut samples);
        samples
    };
    let window = Window::new(31, 17, 120, 97);
    let all = fill(ChannelSet::ALL, ChannelSet::ALL, window);
    let whole = fill(ChannelSet::ALL, ChannelSet::ALL, format().window());
    for channel in Channel::ALL {
        let set = ChannelSet::of(&[channel]);
        assert!(fill(set, set, window).channel(channel) == all.channel(channel), "{channel:?}");
        let cut = window.y0..window.y1;
        let rows =
            cut.flat_map(|y| &whole.channel(channel)[(y * 160 + window.x0) as usize..(y * 160 + window.x1) as usize]);
        assert!(rows.eq(all.channel(channel)), "{channel:?}");
    }
}

#[test]
fn what_is_not_wanted_is_not_computed() {
    let model = PatchModel::new(&torus(6, 5), Placement::default(), false, ADAPTIVE);
    let projector = look([1.0, 2.0, 5.0], [0.5, 0.0, 0.0]).projector(format());
    let mesh = model.tessellate(&projector, ChannelSet::DEPTH);
    assert!(mesh.normals.is_empty() && mesh.rests.is_empty() && mesh.uvs.is_empty() && !mesh.positions.is_empty());
}

#[test]
fn hostile_models_stay_within_limits() {
    let mut draw = Draw(6);
    let camera = look([0.0; 3], [0.0, 0.0, -1.0]);
    for size in [0.0, 1e-30, 1e-3, 1.0, 1e7, 1e30] {
        // The camera is inside of the model.
        let patches: Vec<Patch> = (0..12).map(|_| Patch::new(random_patch(&mut draw, size))).collect();
        for tessellation in [Tessellation::Adaptive { tolerance: 1e-3 }, Tessellation::Uniform { segments: u32::MAX }] {
            let model = PatchModel::new(&patches, Placement::default(), false, tessellation);
            let mesh = model.tessellate(&camera.projector(format()), ChannelSet::ALL);
            assert!(mesh.positions.len() <= 12 * (MAX_SEGMENTS + 1).pow(2));
            assert!(mesh.normals.iter().flatten().all(|part| part.is_finite()));
        }
        let model = PatchModel::new(&patches, Placement::default(), false, ADAPTIVE);
        let visible = Visible::prepare(&camera, &[&model], format(), ChannelSet::ALL);
        let mut samples = Samples::new();
        visible.fill(format().window(), [0.5, 0.5], ChannelSet::ALL, &mut samples);
        for channel in Channel::ALL {
            assert!(samples.channel(channel).iter().all(|value| !value.is_nan()), "{channel:?} at {size}");
        }
    }
}

fn tent() -> Triangles {
    let at = |x: f64, y: f64, z: f64| DVec3::new(x, y, z);
    Triangles {
        positions: vec![at(-1.0, 0.0, 1.0), at(1.0, 0.0, 1.0), at(0.0, 1.5, 0.0), at(0.0, 0.0, -1.0)],
        normals: Vec::new(),
        uvs: vec![[0.0, 0.0], [1.0, 0.0], [0.5, 1.0], [0.5, 0.5]],
        triangles: vec![[0, 1, 2], [1, 3, 2], [3, 0, 2], [0, 3, 1]],
    }
}

#[test]
fn triangle_meshes_agree_with_rays() {
    let placement =
        Placement { rotate: DVec3::new(0.1, 0.7, 0.0), scale: DVec3::new(2.0, 1.0, -1.0), ..Placement::default() };
    for normals in [Vec::new(), vec![DVec3::Y, DVec3::Z, DVec3::X, DVec3::new(0.1, 0.2, -1.0)]] {
        let model = TriangleModel::new(Triangles { normals, ..tent() }, placement, false).expect("a mesh");
        let share = agreement(&look([1.0, 2.0, 6.0], [0.0, 0.5, 0.0]), &model, 1e-5);
        assert!(share > 0.99, "{share}");
    }
}

#[test]
fn meshes_that_do_not_fit_are_refused() {
    let of = |change: &dyn Fn(&mut Triangles)| {
        let mut mesh = tent();
        change(&mut mesh);
        TriangleModel::new(mesh, Placement::default(), false).map(|model| model.len())
    };
    assert_eq!(of(&|_| ()), Ok(4));
    let vertex = TrianglesError::Vertex { triangle: 2, vertex: 4, vertices: 4 };
    assert_eq!(of(&|mesh| mesh.triangles[2][1] = 4), Err(vertex));
    let counts = TrianglesError::Counts { what: "normals", found: 1, vertices: 4 };
    assert_eq!(of(&|mesh| mesh.normals = vec![DVec3::Y]), Err(counts));
    let place = TrianglesError::NotFinite { vertex: 1, what: "position" };
    assert_eq!(of(&|mesh| mesh.positions[1].y = f64::NAN), Err(place));
}
