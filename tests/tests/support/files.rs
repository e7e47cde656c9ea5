//! Image files that tests read.

use std::path::Path;
use trochoid::io::{ExrChannel, ExrImage, Samples};
use trochoid::{Plane, Window};

/// Writes channels of 32-bit floats as an EXR.
pub(crate) fn write_exr(path: &Path, width: u32, height: u32, channels: &[(&str, &[f32])]) {
    let window = Window::sized(width, height);
    let planes: Vec<Plane> =
        channels.iter().map(|(_, samples)| Plane::new(window, samples.to_vec()).unwrap()).collect();
    let image = ExrImage {
        channels: channels
            .iter()
            .zip(&planes)
            .map(|((name, _), plane)| ExrChannel::float(*name, Samples::plane(plane)))
            .collect(),
        ..ExrImage::new(window)
    };
    trochoid::io::write_exr(path, &image).unwrap();
}

/// The value at column x and row y.
type Values<'f> = &'f dyn Fn(f32, f32) -> f32;

/// A square plane whose normals turn from one side to the other.
const MESH: &str = "v -9 -2.25 9\nv 9 2.25 9\nv 9 2.25 -9\nv -9 -2.25 -9\nvt 0 0\nvt 1 0\nvt 1 1\nvt 0 1\n\
                    vn 0 1 0\nvn 0.6 0.8 0\nf 1/1/1 2/2/2 3/3/2 4/4/1\n";

/// Returns a folder with the files that golden cases read: the 4 × 3 pictures `read.exr` and `passes.exr`, and
/// `mesh.obj`.
pub(crate) fn folder() -> tempfile::TempDir {
    let folder = tempfile::tempdir().unwrap();
    std::fs::write(folder.path().join("mesh.obj"), MESH).unwrap();
    let plane = |f: Values<'_>| -> Vec<f32> { (0..12).map(|i| f((i % 4) as f32, (i / 4) as f32)).collect() };
    let write = |name: &str, channels: &[(&str, Values<'_>)]| {
        let planes: Vec<(&str, Vec<f32>)> = channels.iter().map(|(name, f)| (*name, plane(f))).collect();
        let planes: Vec<(&str, &[f32])> = planes.iter().map(|(name, plane)| (*name, plane.as_slice())).collect();
        write_exr(&folder.path().join(name), 4, 3, &planes);
    };
    write(
        "read.exr",
        &[
            ("R", &|x, _| (x + 1.0) / 8.0),
            ("G", &|_, y| (y + 1.0) / 4.0),
            ("B", &|x, y| (x + y) / 16.0),
            ("m", &|x, _| x / 4.0),
            ("w0", &|_, _| 0.5),
            ("w1", &|x, _| x / 8.0),
            ("w2", &|x, _| 0.5 - x / 8.0),
            ("Z", &|x, y| 10.0 * (x - 2.0) * (y + 1.0)),
            ("bad", &|x, _| x - 1.0),
        ],
    );
    let row = |y: f32, there: f32, else_: f32| if y == 1.0 { there } else { else_ };
    write(
        "passes.exr",
        &[
            ("scene.depth.Z", &|x, _| if x == 3.0 { 1e10 } else { 10.0 * (x + 1.0) }),
            ("scene.position.X", &|x, _| x),
            ("scene.position.Y", &|_, y| y + 10.0),
            ("scene.position.Z", &|x, y| 2.0 * x + y),
            ("scene.normal.X", &|_, _| 0.0),
            ("scene.normal.Y", &|_, y| row(y, -3.0, 0.0)),
            ("scene.normal.Z", &|_, y| row(y, 4.0, 2.0)),
        ],
    );
    folder
}
