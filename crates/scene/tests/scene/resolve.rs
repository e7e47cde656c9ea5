//! Tests of what samples see, against the formulas and one by one.

use trochoid_image::{Channel, ChannelSet, Format, Window};
use trochoid_scene::inside::{heights, look, nearest, patches, plane, rounded, triangle};
use trochoid_scene::shading::unit_or_up;
use trochoid_scene::{
    Between, Camera, DVec3, GivenUp, GridSurface, Hit, Mesh, Projection, Projector, Ray, Samples, Surface, Topology,
    Visible,
};

/// Computes the attributes of one triangle at a pixel by itself, straight from the formulas.
fn plain(visible: &Visible, seen: Option<[u32; 2]>, pixel: [f64; 2]) -> [f32; Channel::ALL.len()] {
    let mut answers = Channel::ALL.map(Channel::background);
    let Some(seen) = seen else { return answers };
    let (surface, mesh, triangle) = triangle(visible, seen);
    let projector = visible.projector();
    let vertices = triangle.map(|vertex| vertex as usize);
    let positions = vertices.map(|vertex| glam::Vec3::from(mesh.positions[vertex]).as_dvec3());
    let (across, upward) = plane(projector, pixel);
    let (ray, [p, q, r]) = if projector.orthographic {
        (projector.forward, positions.map(|position| position - across - upward))
    } else {
        (projector.forward + across + upward, positions)
    };
    let raw = [ray.dot(q.cross(r)), ray.dot(r.cross(p)), ray.dot(p.cross(q))];
    let outer = raw[0] + raw[1] + raw[2] < 0.0;
    let kept = raw.map(|weight| {
        let weight = if outer { -weight } else { weight };
        if weight > 0.0 { weight } else { 0.0 }
    });
    let sum = kept[0] + kept[1] + kept[2];
    let weights = if sum > 0.0 && sum.is_finite() { kept.map(|weight| weight / sum) } else { [1.0 / 3.0; 3] };
    let blend = |values: [f64; 3]| values[0] * weights[0] + values[1] * weights[1] + values[2] * weights[2];
    let blend_of = |value: &dyn Fn(usize) -> f32| blend(vertices.map(|vertex| f64::from(value(vertex))));
    let mut set = |channel: Channel, value: f64| answers[channel as usize] = value as f32;
    let offset = DVec3::from_array([0, 1, 2].map(|axis| blend(positions.map(|position| position[axis]))));
    let position = projector.position + offset;
    let height = position.y - mesh.level;
    set(Channel::Coverage, 1.0);
    set(Channel::Surface, surface as f64);
    set(Channel::Depth, offset.dot(projector.forward));
    set(Channel::PositionX, position.x);
    set(Channel::PositionY, position.y);
    set(Channel::PositionZ, position.z);
    set(Channel::Height, height);
    if !mesh.normals.is_empty() {
        let normal = DVec3::from_array([0, 1, 2].map(|axis| blend_of(&|vertex| mesh.normals[vertex][axis])));
        set(Channel::Jacobian, 1.0);
        let normal = if outer == mesh.inside { -unit_or_up(normal) } else { unit_or_up(normal) };
        set(Channel::NormalX, normal.x);
        set(Channel::NormalY, normal.y);
        set(Channel::NormalZ, normal.z);
    }
    let rest = match mesh.rests.is_empty() {
        true => [offset.x, offset.z],
        false => [0, 1].map(|axis| blend_of(&|vertex| mesh.rests[vertex][axis])),
    };
    let risen = match mesh.rest_heights.is_empty() {
        true => 0.0,
        false => projector.position.y + blend_of(&|vertex| mesh.rest_heights[vertex]) - mesh.level,
    };
    let place = [projector.position.x + rest[0], projector.position.z + rest[1]];
    set(Channel::RestX, place[0]);
    set(Channel::RestY, mesh.level + risen);
    set(Channel::RestZ, place[1]);
    set(Channel::RestDistance, DVec3::new(offset.x - rest[0], height - risen, offset.z - rest[1]).length());
    let uv = match mesh.uvs.is_empty() {
        true => place,
        false => [0, 1].map(|axis| blend_of(&|vertex| mesh.uvs[vertex][axis])),
    };
    set(Channel::U, uv[0]);
    set(Channel::V, uv[1]);
    if !mesh.slope_variances.is_empty() {
        set(Channel::SlopeVariance, blend_of(&|vertex| mesh.slope_variances[vertex]));
    }
    for (values, channel) in mesh.trails.iter().zip(Channel::TRAILS).filter(|(values, _)| !values.is_empty()) {
        set(channel, blend_of(&|vertex| values[vertex]));
    }
    answers
}

struct Given(Mesh);

impl Surface for Given {
    fn tessellate(&self, _: &Projector, _: ChannelSet) -> Mesh {
        self.0.clone()
    }

    fn trace(&self, _: &Projector, _: &Ray, _: f64) -> Result<Option<Hit>, GivenUp> {
        Ok(None)
    }
}

/// Numbers from 0 to 1, one after the other.
struct Random(u64);

impl Random {
    fn next(&mut self) -> f32 {
        self.0 = self.0.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1_442_695_040_888_963_407);
        (self.0 >> 40) as f32 / (1 << 24) as f32
    }

    fn values<const N: usize>(&mut self, count: usize, hostile: bool) -> Vec<[f32; N]> {
        const HOSTILE: [f32; 6] = [0.0, -0.0, f32::NAN, f32::INFINITY, f32::MAX, 1e-42];
        let mut value = || {
            let value = self.next() * 8.0 - 4.0;
            if hostile && self.next() < 0.3 { HOSTILE[(self.next() * 6.0) as usize] } else { value }
        };
        (0..count).map(|_| std::array::from_fn(|_| value())).collect()
    }

    /// Triangles in front of a camera that looks along −Z, some of them large, many without area.
    fn mesh(&mut self, case: u32) -> Mesh {
        let count = 3 * 80;
        let has = |bit: u32| case & bit != 0;
        let mut positions = self.values::<3>(count, false);
        for (index, position) in positions.iter_mut().enumerate() {
            position[2] = -3.0 - 8.0 * self.next();
            if index % 7 == 0 {
                position[0] = 0.0;
            }
        }
        let flat = |values: Vec<[f32; 1]>| values.concat();
        let mut list = |wanted: bool| if wanted { flat(self.values(count, true)) } else { Vec::new() };
        let (rest_heights, slope_variances) = (list(has(4)), list(has(8)));
        let trails = std::array::from_fn(|index| list(has(16) && index != 2));
        let corner = |next: f32| (next * count as f32) as u32;
        let triangles = (0..160).map(|_| [0; 3].map(|_| corner(self.next()))).collect();
        Mesh {
            normals: if has(1) { self.values(count, true) } else { Vec::new() },
            rests: if has(2) { self.values(count, true) } else { Vec::new() },
            uvs: if has(32) { self.values(count, true) } else { Vec::new() },
            positions,
            rest_heights,
            slope_variances,
            trails,
            level: 0.25,
            inside: has(64),
            tolerance: None,
            topology: Topology::Triangles(triangles),
            between: Between::Triangles,
        }
    }
}

impl Random {
    /// A grid of vertices in front of the same camera, with patches or a field of heights between them; some derivatives
    /// or heights are hostile.
    fn curved(&mut self, case: u32) -> Mesh {
        const SIDES: [usize; 2] = [13, 11];
        let [columns, rows] = SIDES;
        let mut positions = self.values::<3>(columns * rows, false);
        for (index, position) in positions.iter_mut().enumerate() {
            let (column, row) = ((index % columns) as f32, (index / columns) as f32);
            *position = [column - 6.0 + 0.1 * position[0], 0.7 * row - 5.0, -4.0 - 0.5 * row + 0.1 * position[2]];
        }
        let hostile = case & 1 != 0;
        let between = if case & 2 != 0 {
            let tangents = self.values::<3>(2 * columns * rows, hostile).as_chunks::<2>().0.to_vec();
            let steps = self.values::<1>(rows - 1, hostile).concat();
            Between::Patches(patches(columns, &positions, tangents, steps, case & 4 != 0))
        } else {
            let values = self.values::<1>(60 * 40, hostile).concat();
            let grid = GridSurface::new(values, 60, 0.21, [93.8, -18.0], -1.0);
            Between::Heights(heights(&grid))
        };
        let rests = if case & 2 != 0 { self.values(columns * rows, hostile) } else { Vec::new() };
        let topology = Topology::Grid { columns, rows };
        Mesh { positions, rests, inside: case & 8 != 0, topology, between, ..Mesh::empty(-1.0) }
    }
}

#[test]
fn curved_hits_do_not_depend_on_their_neighbors_and_hostile_ones_stay_on_their_triangles() {
    let mut random = Random(11);
    for case in 0..64 {
        let projection = match case % 3 {
            0 => Projection::Orthographic { height: 7.0 },
            _ => Projection::Perspective { fov: 0.9 },
        };
        let (position, target) = (DVec3::new(100.0, 0.0, -7.0), DVec3::new(100.0, -0.2, -8.0));
        let camera = Camera { position, target, roll: 0.0, projection };
        let format = Format::new(90, 50, 1).expect("valid");
        let surface = Given(random.curved(case));
        let visible = Visible::prepare(&camera, &[&surface], format, ChannelSet::ALL);
        let (mut whole, mut some) = (Samples::new(), Samples::new());
        visible.fill(format.window(), [0.5; 2], ChannelSet::ALL, &mut whole);
        let pixels: Vec<[i64; 2]> =
            (0..90 * 50).filter(|_| random.next() < 0.3).map(|index| [index % 90, index / 90]).collect();
        visible.fill_pixels(&pixels, [0.5; 2], ChannelSet::ALL, &mut some);
        for (index, [x, y]) in pixels.iter().enumerate() {
            for channel in Channel::ALL {
                // The sign of a NaN, which hostile meshes make, is the compiler's choice.
                let bits = |samples: &Samples, index: usize| {
                    let value = samples.channel(channel)[index];
                    (!value.is_nan()).then_some(value.to_bits())
                };
                let place = (y * 90 + x) as usize;
                assert_eq!(bits(&some, index), bits(&whole, place), "case {case}, {channel:?} at {x}, {y}");
            }
        }
        assert!(
            nearest(&visible, format.window(), [0.5; 2]) == look(&visible, format.window(), [0.5; 2]),
            "case {case}"
        );
        let mut hits = 0;
        for index in 0..90 * 50 {
            let vector =
                |channels: [Channel; 3]| DVec3::from(channels.map(|channel| f64::from(whole.channel(channel)[index])));
            if whole.channel(Channel::Coverage)[index] > 0.0 {
                hits += 1;
                let position = vector([Channel::PositionX, Channel::PositionY, Channel::PositionZ]);
                let normal = vector([Channel::NormalX, Channel::NormalY, Channel::NormalZ]);
                assert!((position - camera.position).length() < 40.0, "case {case}: {position}");
                assert!((normal.length() - 1.0).abs() < 1e-5, "case {case}: {normal}");
            }
        }
        assert!(hits > 1000, "case {case}: {hits} hits");
    }
}

#[test]
fn hits_side_by_side_have_the_bits_of_each_by_itself() {
    let mut random = Random(3);
    for case in 0..128 {
        let projection = match case % 3 {
            0 => Projection::Orthographic { height: 7.0 },
            _ => Projection::Perspective { fov: 0.9 },
        };
        let (position, target) = (DVec3::new(100.0, 3.0, -7.0), DVec3::new(100.0, 3.0, -8.0));
        let camera = Camera { position, target, roll: 0.0, projection };
        let format = Format::new(90, 50, 4).expect("valid");
        let surfaces = [Given(random.mesh(case)), Given(random.mesh(case.wrapping_mul(37) ^ 85))];
        let surfaces: Vec<&dyn Surface> = surfaces.iter().map(|surface| surface as &dyn Surface).collect();
        let visible = Visible::prepare(&camera, &surfaces, format, ChannelSet::ALL);
        let window = Window::new(-3, 4, 87, 33);
        let offset = format.sample_offset(case % 4);
        let mut samples = Samples::new();
        visible.fill(window, offset, ChannelSet::ALL, &mut samples);
        // Compares all samples together with this one alone, which is requested by an offset that belongs to no
        // sample.
        let all = || (0..window.area() as i64).map(|index| [window.x0 + index % 90, window.y0 + index / 90]);
        let alone = Visible::prepare(&camera, &surfaces, Format::new(90, 50, 1).expect("valid"), ChannelSet::ALL);
        let seen = look(&visible, window, offset);
        assert!(look(&alone, window, offset) == seen, "case {case}: samples together and each by itself");
        assert!(nearest(&visible, window, offset) == seen, "case {case}: triangles one by one");
        let some: Vec<[i64; 2]> = all().filter(|_| random.next() < 0.4).collect();
        let mut alone = Samples::new();
        visible.fill_pixels(&some, offset, ChannelSet::ALL, &mut alone);
        for (index, [x, y]) in some.iter().enumerate() {
            let whole = (y - window.y0) as usize * 90 + (x - window.x0) as usize;
            for channel in Channel::ALL {
                let bits = |samples: &Samples, index: usize| samples.channel(channel)[index].to_bits();
                assert_eq!(bits(&alone, index), bits(&samples, whole), "case {case}, {channel:?} at {x}, {y}");
            }
        }
        let mut hits = 0;
        for (index, &number) in seen.iter().enumerate() {
            let place = [index % window.width(), index / window.width()];
            let pixel = [0, 1].map(|axis| {
                let first = [window.x0, window.y0][axis] + place[axis] as i64;
                first as f64 + rounded(&visible, offset[axis])
            });
            hits += usize::from(number.is_some());
            let truth = plain(&visible, number, pixel);
            for channel in Channel::ALL {
                let (found, truth) = (samples.channel(channel)[index], truth[channel as usize]);
                let same = found.to_bits() == truth.to_bits() || (found.is_nan() && truth.is_nan());
                assert!(same, "case {case}, {channel:?} at {place:?}: {found} and {truth}");
            }
        }
        assert!(hits > 100 && hits < seen.len(), "case {case}: {hits} hits");
    }
}

#[test]
fn triangles_smaller_than_pixels_are_seen_like_any_others() {
    let mut random = Random(5);
    for case in 0..24 {
        // From a tenth of a pixel to a few pixels, some of them without area, beyond the picture, or behind the camera.
        let [columns, rows] = [[400, 300], [200, 160], [120, 90], [40, 30]][case % 4];
        let mut positions = random.values::<3>(columns * rows, false);
        for (index, position) in positions.iter_mut().enumerate() {
            let (x, y) = ((index % columns) as f32 / columns as f32, (index / columns) as f32 / rows as f32);
            let [dx, dy, dz] = *position;
            let apart = 2.0 / columns as f32;
            *position = [10.0 * x - 5.0 + apart * dx, 6.0 * y - 3.0 + apart * dy, -5.0 + 0.1 * dz];
            if index % 997 == 0 {
                *position = [0.0, 0.1 * dy, dz];
            }
        }
        let mesh = Mesh { positions, topology: Topology::Grid { columns, rows }, ..Mesh::empty(0.0) };
        let camera = Camera {
            position: DVec3::ZERO,
            target: DVec3::new(0.0, 0.0, -1.0),
            roll: 0.3,
            projection: Projection::Perspective { fov: 0.9 },
        };
        let format = Format::new(90, 50, [1, 4, 16][case % 3]).expect("valid");
        let visible = Visible::prepare(&camera, &[&Given(mesh)], format, ChannelSet::COVERAGE);
        for window in [Window::new(-3, 4, 87, 33), Window::new(40, 20, 95, 52)] {
            let offset = format.sample_offset(case as u32 % format.samples());
            let seen = look(&visible, window, offset);
            assert!(nearest(&visible, window, offset) == seen, "case {case}: triangles one by one");
            assert!(seen.iter().flatten().count() > 500, "case {case}");
        }
    }
}
