//! Tests of ViewFromPasses on passes whose depth is measured along the ray, and on other renderers' misses.

use crate::testing::Frame;
use std::path::Path;
use trochoid_graph::{
    Block, Bound, Bounding, Channel, Document, Inputs, NodeError, Outputs, Reference, Registry, check,
};
use trochoid_image::Window;
use trochoid_io::{ExrChannel, ExrImage, Samples, write_exr};
use trochoid_memory::Scratch;

const WIDTH: usize = 48;
const HEIGHT: usize = 27;

/// A camera above a floor, in the words of a document.
const CAMERA: &str = r#""camera": { "type": "Camera", "position": [1, 4, 12], "target": [0, 1, 0], "fov": 60 }"#;

/// Passes of a floor at y = 0 as far as z = −20, below a sky.
struct Passes {
    position: [Vec<f64>; 3],
    planar: Vec<f64>,
    distance: Vec<f64>,
    hit: Vec<bool>,
}

impl Passes {
    /// Renders the floor by rays that leave the middle of their pixels by up to `jitter` pixels.
    fn new(jitter: f64) -> Self {
        let from = [1.0, 4.0, 12.0];
        let minus = |a: [f64; 3], b: [f64; 3]| [a[0] - b[0], a[1] - b[1], a[2] - b[2]];
        let dot = |a: [f64; 3], b: [f64; 3]| a[0] * b[0] + a[1] * b[1] + a[2] * b[2];
        let cross = |a: [f64; 3], b: [f64; 3]| {
            [a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]]
        };
        let unit = |a: [f64; 3]| a.map(|v| v / dot(a, a).sqrt());
        let forward = unit(minus([0.0, 1.0, 0.0], from));
        let right = unit(cross(forward, [0.0, 1.0, 0.0]));
        let up = cross(right, forward);
        let per_pixel = 2.0 * 30.0_f64.to_radians().tan() / WIDTH as f64;
        let mut passes =
            Self { position: Default::default(), planar: Vec::new(), distance: Vec::new(), hit: Vec::new() };
        for index in 0..WIDTH * HEIGHT {
            // Steps of the golden ratio are as good as random ones.
            let off = |factor: f64| jitter * (2.0 * (index as f64 * factor).fract() - 1.0);
            let x = (index % WIDTH) as f64 + 0.5 + off(0.618_034) - WIDTH as f64 / 2.0;
            let y = (index / WIDTH) as f64 + 0.5 + off(0.754_878) - HEIGHT as f64 / 2.0;
            let ray = unit([0, 1, 2].map(|i| forward[i] + right[i] * x * per_pixel - up[i] * y * per_pixel));
            let distance = -from[1] / ray[1];
            let point = [0, 1, 2].map(|i| from[i] + ray[i] * distance);
            let hit = distance > 0.0 && point[2] > -20.0;
            let of_hit = |value: f64| if hit { value } else { 0.0 };
            (0..3).for_each(|i| passes.position[i].push(of_hit(point[i])));
            passes.planar.push(of_hit(distance * dot(ray, forward)));
            passes.distance.push(of_hit(distance));
            passes.hit.push(hit);
        }
        assert!(passes.hit.contains(&false) && passes.hit.contains(&true));
        passes
    }

    /// Writes `depth` as dd.T and the positions as pp, in units of `unit` meters, with z up if so.
    fn write(&self, folder: &Path, depth: &[f64], unit: f64, z_up: bool) {
        let [x, y, z] = &self.position;
        let stored = |values: &[f64], sign: f64| -> Vec<f32> {
            values.iter().map(|value| (sign * value / unit) as f32).collect()
        };
        let (second, third) = if z_up { (stored(z, -1.0), stored(y, 1.0)) } else { (stored(y, 1.0), stored(z, 1.0)) };
        let channels = [("dd.T", stored(depth, 1.0)), ("pp.X", stored(x, 1.0)), ("pp.Y", second), ("pp.Z", third)];
        write(folder, &channels);
    }
}

fn write(folder: &Path, channels: &[(&str, Vec<f32>)]) {
    let channels =
        channels.iter().map(|(name, samples)| ExrChannel::float(*name, Samples::contiguous(samples))).collect();
    let window = Window::sized(WIDTH as u32, HEIGHT as u32);
    write_exr(folder.join("a.exr"), &ExrImage { channels, ..ExrImage::new(window) }).unwrap();
}

fn view(folder: &Path, knobs: &str) -> Result<Frame, NodeError> {
    let text = format!(
        r#"{{ "trochoid": 1, "format": {{ "width": {WIDTH}, "height": {HEIGHT} }}, "nodes": {{ {CAMERA},
            "view": {{ "type": "ViewFromPasses", "file": "a.exr", {knobs} }} }},
            "outputs": {{ "out": {{ "weights": "view.coverage" }} }} }}"#
    );
    let document = Document::parse("test.json", &text).unwrap();
    let (graph, faults) = check(&document, &Registry::new(trochoid_nodes::all()), folder);
    let frame = Frame::new(graph.unwrap_or_else(|| panic!("{faults:?}")))?;
    frame.fill_all("view")?;
    Ok(frame)
}

/// Returns the depth and coverage of every pixel; the reference agrees within f32's rounding.
fn filled(frame: &Frame) -> Vec<[f64; 2]> {
    let id = frame.graph.find("view").unwrap();
    let at = |index: usize| [(index % WIDTH) as f64 + 0.5, (index / WIDTH) as f64 + 0.5];
    let all = (0..WIDTH * HEIGHT).map(|index| {
        let Reference::View(truth) = frame.reference(id, 0, at(index)) else { panic!("a view") };
        [Channel::Depth, Channel::Coverage].map(|channel| {
            let found = f64::from(frame.filled(id, 0, channel as usize, at(index)));
            let truth = truth[channel as usize];
            assert!(found == truth || (found - truth).abs() <= 6e-8 * truth, "pixel {index}: {found}, not {truth}");
            found
        })
    });
    all.collect()
}

/// Checks that depths are the expected ones within a relative tolerance, and that misses are uncovered.
fn expect(frame: &Frame, hit: &[bool], depth: &[f64], tolerance: f64) {
    for (index, [found, coverage]) in filled(frame).into_iter().enumerate() {
        let expected = if hit[index] { depth[index] } else { f64::INFINITY };
        assert_eq!(coverage, f64::from(u8::from(hit[index])), "pixel {index}");
        let off = if found == expected { 0.0 } else { (found - expected).abs() / expected };
        assert!(off <= tolerance, "pixel {index}: {found}, not {expected}");
    }
}

/// Checks that the bounds of all channels are at least the differences from the reference, and small.
fn expect_bounds(frame: &Frame) {
    let id = frame.graph.find("view").unwrap();
    let kinds = &frame.graph.node(id).kinds;
    let block = Block::of(Window::sized(WIDTH as u32, HEIGHT as u32), [0.5; 2]);
    let memory = || -> Vec<Vec<Vec<f32>>> {
        kinds.iter().map(|kind| vec![vec![f32::NAN; WIDTH * HEIGHT]; kind.channels()]).collect()
    };
    fn lend(memory: &mut [Vec<Vec<f32>>]) -> Outputs<'_> {
        Outputs::new(memory.iter_mut().map(|planes| planes.iter_mut().map(|plane| Some(&mut plane[..]))))
    }
    let (mut filled, mut bounds) = (memory(), memory());
    let ports = [Scratch::new()];
    let (view, inputs) = (frame.node("view"), Inputs::new(&ports));
    view.fill(&block, &inputs, &mut lend(&mut filled)).unwrap();
    let lent: Vec<Vec<Option<&[f32]>>> =
        filled.iter().map(|planes| planes.iter().map(|plane| Some(&plane[..])).collect()).collect();
    let bounding = Bounding { block: &block, inputs: &inputs, bounds: &inputs, filled: &lent };
    view.bound(&bounding, &mut lend(&mut bounds)).unwrap();
    for (index, at) in block.places().enumerate() {
        let Reference::View(truth) = frame.reference(id, 0, at) else { panic!("a view") };
        for (channel, truth) in truth.into_iter().enumerate() {
            let (value, bound) = (f64::from(filled[0][channel][index]), Bound::decode(bounds[0][channel][index]));
            let error = if value == truth { 0.0 } else { (value - truth).abs() };
            assert!(error <= bound.size, "channel {channel}, pixel {index}: {error} is more than {}", bound.size);
            assert!(bound.size <= 1e-6 * (1.0 + truth.abs()), "channel {channel}, pixel {index}: {}", bound.size);
        }
    }
}

const PASSES: &str = r#""camera": "camera", "depth": "dd.T", "position": "pp""#;

#[test]
fn depth_along_the_ray_is_told_by_positions_and_converted() {
    let folder = tempfile::tempdir().unwrap();
    let passes = Passes::new(0.5);
    passes.write(folder.path(), &passes.distance, 1.0, false);
    // The two kinds of depth differ by far more than the tolerance, and so do rays from those through the middles.
    let most = |of: &dyn Fn(usize) -> f64| (0..WIDTH * HEIGHT).filter(|i| passes.hit[*i]).map(of).fold(0.0, f64::max);
    assert!(most(&|i| passes.distance[i] / passes.planar[i] - 1.0) > 0.1);
    let frame = view(folder.path(), PASSES).unwrap();
    expect(&frame, &passes.hit, &passes.planar, 1e-6);
    expect_bounds(&frame);
    let stated = format!(r#"{PASSES}, "convention": "mitsuba""#);
    expect(&view(folder.path(), &stated).unwrap(), &passes.hit, &passes.planar, 1e-6);
    // What is stated counts before what positions tell.
    let planar = format!(r#"{PASSES}, "depth_is": "planar""#);
    expect(&view(folder.path(), &planar).unwrap(), &passes.hit, &passes.distance, 1e-7);
}

#[test]
fn distances_may_begin_at_the_near_clipping_plane() {
    let folder = tempfile::tempdir().unwrap();
    let from = |passes: &Passes, near: f64| -> Vec<f64> {
        let of =
            |(distance, planar): (&f64, &f64)| if *planar > 0.0 { distance - near * distance / planar } else { 0.0 };
        passes.distance.iter().zip(&passes.planar).map(of).collect()
    };
    let passes = Passes::new(0.5);
    for near in [0.001, 0.01, 0.5, 2.0] {
        passes.write(folder.path(), &from(&passes, near), 1.0, false);
        for more in ["", r#", "convention": "mitsuba""#, r#", "depth_is": "distance""#] {
            let frame = view(folder.path(), &format!("{PASSES}{more}")).unwrap();
            expect(&frame, &passes.hit, &passes.planar, 2e-6);
            expect_bounds(&frame);
        }
    }
    // What is stated counts before what positions tell.
    let off = |near: f64| passes.planar.iter().map(|planar| planar - 2.0 + near).collect::<Vec<f64>>();
    let stated = view(folder.path(), &format!(r#"{PASSES}, "near": 1.5"#)).unwrap();
    expect(&stated, &passes.hit, &off(1.5), 1e-6);
    // Without positions the plane is that of the convention, in units of the file.
    let passes = Passes::new(0.0);
    let knobs = r#""camera": "camera", "depth": "dd.T", "convention": "mitsuba""#;
    for (unit, more) in [(1.0, ""), (0.5, r#", "scale": 0.5"#)] {
        passes.write(folder.path(), &from(&passes, 0.01 * unit), unit, false);
        expect(&view(folder.path(), &format!("{knobs}{more}")).unwrap(), &passes.hit, &passes.planar, 1e-6);
    }
}

#[test]
fn planar_depth_stays_as_stored() {
    let folder = tempfile::tempdir().unwrap();
    let passes = Passes::new(0.5);
    passes.write(folder.path(), &passes.planar, 1.0, false);
    let stored: Vec<f64> = passes.planar.iter().map(|depth| f64::from(*depth as f32)).collect();
    expect(&view(folder.path(), PASSES).unwrap(), &passes.hit, &stored, 0.0);
}

#[test]
fn rays_without_positions_lead_through_the_middles_of_pixels() {
    let folder = tempfile::tempdir().unwrap();
    let passes = Passes::new(0.0);
    passes.write(folder.path(), &passes.distance, 1.0, false);
    let knobs = r#""camera": "camera", "depth": "dd.T", "depth_is": "distance""#;
    expect(&view(folder.path(), knobs).unwrap(), &passes.hit, &passes.planar, 1e-6);
    // With nothing to tell by, depth is planar.
    let knobs = r#""camera": "camera", "depth": "dd.T""#;
    expect(&view(folder.path(), knobs).unwrap(), &passes.hit, &passes.distance, 1e-7);
}

#[test]
fn a_camera_that_is_not_that_of_the_passes_tells_nothing() {
    let folder = tempfile::tempdir().unwrap();
    let mut passes = Passes::new(0.5);
    passes.position[0].iter_mut().for_each(|x| *x += 30.0);
    passes.write(folder.path(), &passes.distance, 1.0, false);
    expect(&view(folder.path(), PASSES).unwrap(), &passes.hit, &passes.distance, 1e-7);
}

#[test]
fn a_few_wrong_positions_do_not_change_what_is_told() {
    let folder = tempfile::tempdir().unwrap();
    let mut passes = Passes::new(0.5);
    for index in (0..WIDTH * HEIGHT).step_by(3) {
        passes.position[1][index] = if index % 2 == 0 { f64::NAN } else { 1e9 };
    }
    passes.write(folder.path(), &passes.distance, 1.0, false);
    let text = view(folder.path(), PASSES).err().unwrap().to_string();
    assert!(text.contains("channel \"pp.Y\", pixel (0, 0): found NaN"), "{text}");
    let frame = view(folder.path(), &format!(r#"{PASSES}, "repair": true"#)).unwrap();
    let found = filled(&frame);
    for index in (0..WIDTH * HEIGHT).filter(|index| index % 3 != 0 && passes.hit[*index]) {
        let (found, expected) = (found[index][0], passes.planar[index]);
        assert!((found - expected).abs() <= 1e-6 * expected, "pixel {index}: {found}, not {expected}");
    }
}

#[test]
fn centimeters_and_z_up_become_meters_and_y_up() {
    let folder = tempfile::tempdir().unwrap();
    let passes = Passes::new(0.5);
    passes.write(folder.path(), &passes.distance, 0.01, true);
    let frame = view(folder.path(), &format!(r#"{PASSES}, "scale": 0.01, "up": "z", "level": -2"#)).unwrap();
    expect(&frame, &passes.hit, &passes.planar, 1e-6);
    expect_bounds(&frame);
    let id = frame.graph.find("view").unwrap();
    let channels = [Channel::PositionX, Channel::PositionY, Channel::PositionZ, Channel::Height];
    for index in (0..WIDTH * HEIGHT).filter(|index| passes.hit[*index]) {
        let at = [(index % WIDTH) as f64 + 0.5, (index / WIDTH) as f64 + 0.5];
        let [x, y, z] = [0, 1, 2].map(|axis| passes.position[axis][index]);
        for (channel, expected) in channels.into_iter().zip([x, y, z, y + 2.0]) {
            let found = f64::from(frame.filled(id, 0, channel as usize, at));
            assert!((found - expected).abs() <= 2e-6 * (1.0 + expected.abs()), "{channel:?}: {found}, not {expected}");
        }
    }
}

/// Returns the coverage of the first five pixels of a row of depths, or of normals.
fn coverage(folder: &Path, knobs: &str) -> Vec<f64> {
    filled(&view(folder, knobs).unwrap()).iter().take(5).map(|[_, coverage]| *coverage).collect()
}

#[test]
fn misses_are_what_the_knob_says() {
    let folder = tempfile::tempdir().unwrap();
    let row = |first: [f32; 5]| -> Vec<f32> { first.into_iter().chain([1.0; WIDTH * HEIGHT - 5]).collect() };
    write(folder.path(), &[("Z", row([0.0, 2.0, 1e10, f32::INFINITY, 20_000.0]))]);
    for (misses, expected) in [
        ("auto", [0.0, 1.0, 0.0, 0.0, 0.0]),
        ("far", [1.0, 1.0, 0.0, 0.0, 0.0]),
        ("zero", [0.0, 1.0, 1.0, 0.0, 1.0]),
        ("none", [1.0, 1.0, 1.0, 1.0, 1.0]),
    ] {
        let knobs = format!(r#""depth": "Z", "misses": "{misses}""#);
        assert_eq!(coverage(folder.path(), &knobs), expected, "{misses}");
    }
    assert_eq!(coverage(folder.path(), r#""depth": "Z""#), [0.0, 1.0, 0.0, 0.0, 0.0], "the default");
}

#[test]
fn normals_of_length_0_are_misses_in_files_without_depth() {
    let folder = tempfile::tempdir().unwrap();
    let row = |first: [f32; 5]| -> Vec<f32> { first.into_iter().chain([1.0; WIDTH * HEIGHT - 5]).collect() };
    let (x, z) = (row([0.0, 0.0, 0.5, 0.0, 1.0]), row([0.0, 1.0, 0.5, -0.0, 0.5]));
    write(folder.path(), &[("n.X", x.clone()), ("n.Y", x), ("n.Z", z)]);
    for (knobs, expected) in [
        ("", [0.0, 1.0, 1.0, 0.0, 1.0]),
        (r#", "misses": "none""#, [1.0; 5]),
        (r#", "misses": "far""#, [1.0; 5]),
        // Painted maps have no convention for misses, but may be said to have.
        (r#", "packed": true"#, [1.0; 5]),
        (r#", "packed": true, "misses": "zero""#, [1.0, 1.0, 0.0, 1.0, 1.0]),
    ] {
        assert_eq!(coverage(folder.path(), &format!(r#""normal": "n"{knobs}"#)), expected, "{knobs}");
    }
}
