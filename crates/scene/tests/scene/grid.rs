//! Tests of finite height fields: the tessellated view against the f64 reference, and the interpolation against its
//! definition.

use trochoid_image::Format;
use trochoid_scene::{Camera, Channel, ChannelSet, DVec3, GridSurface, Projection, Samples, Visible, reference};

const WIDE: Projection = Projection::Perspective { fov: 0.9 };

fn look(position: [f64; 3], target: [f64; 3], projection: Projection) -> Camera {
    Camera { position: DVec3::from(position), target: DVec3::from(target), roll: 0.2, projection }
}

fn bumps(x: f64, z: f64) -> f64 {
    (0.9 * x).sin() * (0.7 * z + 0.4).cos() + 0.4 * (0.5 * x - 1.3 * z).sin()
}

fn grid(columns: usize, rows: usize, spacing: f64, origin: [f64; 2], height: impl Fn(f64, f64) -> f64) -> GridSurface {
    let at = |cell: usize| {
        let (i, j) = (cell % columns, cell / columns);
        height(origin[0] + i as f64 * spacing, origin[1] + j as f64 * spacing) as f32
    };
    let heights: Vec<f32> = (0..columns * rows).map(at).collect();
    // Each trail is another multiple of the heights; one of them is left out.
    let trail = |index: usize| heights.iter().map(|height| 0.2 * index as f32 * height).collect();
    let drift = [1, 2, 3, 4, 5].map(|index| if index == 3 { Vec::new() } else { trail(index) });
    let rift = trail(0);
    GridSurface::new(heights, columns, spacing, origin, 2.0).with_trails(|| rift, || drift)
}

/// Returns the share of samples at which view and reference agree, and the share that sees the surface at all.
fn agreement(camera: &Camera, surface: &GridSurface, depth: f64, angle: f64) -> (f64, f64) {
    let (width, height) = (160, 90);
    let format = Format::new(width, height, 1).expect("valid");
    let visible = Visible::prepare(camera, &[surface], format, ChannelSet::ALL);
    let mut samples = Samples::new();
    visible.fill(format.window(), [0.5, 0.5], ChannelSet::ALL, &mut samples);
    let (mut good, mut seen, mut all) = (0.0, 0.0, 0.0);
    for index in (0..(width * height) as usize).step_by(37) {
        let at = |channel: Channel| f64::from(samples.channel(channel)[index]);
        let (x, y) = ((index % width as usize) as f64 + 0.5, (index / width as usize) as f64 + 0.5);
        all += 1.0;
        let Ok(Some(hit)) = reference::trace(camera, &[surface], format, x, y) else {
            good += 1.0 - at(Channel::Coverage);
            continue;
        };
        seen += 1.0;
        let normal = DVec3::new(at(Channel::NormalX), at(Channel::NormalY), at(Channel::NormalZ));
        let near = |a: f64, b: f64| (a - b).abs() <= depth * hit.depth;
        let trails = Channel::TRAILS.into_iter().zip(hit.trails).all(|(channel, trail)| near(at(channel), trail));
        let left_out = hit.trails[3] == 0.0 && (hit.trails[5] - hit.height).abs() < 1e-4;
        let agrees = at(Channel::Coverage) == 1.0
            && trails
            && left_out
            && near(at(Channel::Depth), hit.depth)
            && near(at(Channel::Height), hit.height)
            && near(at(Channel::RestX), hit.rest.x)
            && near(at(Channel::RestZ), hit.rest.z)
            && near(at(Channel::RestDistance), hit.rest_distance)
            && (at(Channel::Jacobian) - hit.jacobian).abs() < 1e-5
            && at(Channel::SlopeVariance) == 0.0
            && normal.dot(hit.normal).clamp(-1.0, 1.0).acos() <= angle;
        good += f64::from(u8::from(agrees));
    }
    (good / all, seen / all)
}

#[test]
fn views_agree_with_the_reference() {
    let surface = grid(80, 60, 0.25, [-10.0, -7.0], bumps);
    let down = Projection::Orthographic { height: 9.0 };
    for (camera, depth, least) in [
        (look([0.0, 9.0, 16.0], [0.0, 1.0, 0.0], WIDE), 5e-3, 0.97),
        (look([2.0, 20.0, 1.0], [2.0, 2.0, 0.0], WIDE), 1e-3, 0.98),
        (look([1.0, 30.0, 9.0], [1.0, 2.0, 0.0], down), 1e-3, 0.98),
        (look([0.0, -8.0, 6.0], [0.0, 2.0, 0.0], WIDE), 5e-3, 0.97),
    ] {
        let (share, seen) = agreement(&camera, &surface, depth, 0.03);
        assert!(share >= least && seen > 0.5, "{camera:?}: {share} of {seen}");
    }
    let flat = grid(5, 4, 3.0, [0.0, 0.0], |_, _| 0.0);
    let (share, seen) = agreement(&look([6.0, 8.0, 20.0], [6.0, 2.0, 4.0], WIDE), &flat, 1e-5, 1e-6);
    assert!(share > 0.99 && seen > 0.1, "{share} of {seen}");
}

#[test]
fn heights_and_slopes_are_those_of_the_field() {
    let (columns, rows, spacing, origin) = (90, 70, 0.1, [3.0, -2.0]);
    let surface = grid(columns, rows, spacing, origin, bumps);
    for (i, j) in [(0, 0), (7, 31), (89, 69), (0, 69)] {
        let (x, z) = (origin[0] + i as f64 * spacing, origin[1] + j as f64 * spacing);
        let [height, ..] = surface.height(x, z).expect("on the grid");
        assert!((height - bumps(x, z)).abs() < 1e-6);
    }
    for step in 0..200 {
        let (x, z) = (3.3 + 0.0411 * f64::from(step), -1.8 + 0.0317 * f64::from(step));
        let [height, dx, dz] = surface.height(x, z).expect("on the grid");
        let (slope_x, slope_z) =
            ((bumps(x + 1e-5, z) - bumps(x - 1e-5, z)) / 2e-5, (bumps(x, z + 1e-5) - bumps(x, z - 1e-5)) / 2e-5);
        assert!((height - bumps(x, z)).abs() < 2e-4 && (dx - slope_x).abs() < 1e-2 && (dz - slope_z).abs() < 1e-2);
        // The derivative belongs to the interpolated function.
        let at = |x: f64, z: f64| surface.height(x, z).expect("on the grid")[0];
        assert!((dx - (at(x + 1e-6, z) - at(x - 1e-6, z)) / 2e-6).abs() < 1e-5);
    }
    assert_eq!(surface.height(2.99, 0.0), None);
    assert_eq!(surface.height(3.0, 4.91), None);
}

/// A grid keeps its corners however finely it is cut, and no ray slips through.
#[test]
fn near_cameras_cut_cells() {
    let surface = grid(12, 9, 2.0, [0.0, 0.0], bumps);
    let camera = look([11.0, 5.0, 15.0], [11.0, 2.0, 6.0], WIDE);
    let (share, seen) = agreement(&camera, &surface, 1e-2, 0.05);
    assert!(share >= 0.96 && seen > 0.3, "{share} of {seen}");
}
