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

/// Writes a cryptomatte of 4 × 3 pixels with three ranks: the hull before the sea on the left, behind it on the right, and
/// the mast before both.
fn write_cryptomatte(path: &Path) {
    let manifest = r#"{"hull":"2c1f9a4a","mast":"1b24764f","sea":"93ca1dde"}"#;
    let [hull, mast, sea] = [0x2c1f_9a4a, 0x1b24_764f, 0x93ca_1dde].map(f32::from_bits);
    let plane = |f: &dyn Fn(usize, usize) -> f32| -> Vec<f32> { (0..12).map(|i| f(i % 4, i / 4)).collect() };
    let planes = [
        ("CryptoObject00.r", plane(&|x, _| if x < 2 { hull } else { sea })),
        ("CryptoObject00.g", plane(&|_, _| 0.5)),
        ("CryptoObject00.b", plane(&|x, _| if x < 2 { sea } else { hull })),
        ("CryptoObject00.a", plane(&|x, _| (x as f32 + 1.0) / 10.0)),
        ("CryptoObject01.r", plane(&|_, _| mast)),
        ("CryptoObject01.g", plane(&|_, y| y as f32 / 30.0)),
    ];
    let channels = planes.iter().map(|(name, plane)| ExrChannel::float(*name, Samples::contiguous(plane))).collect();
    let attributes = [("name", "CryptoObject"), ("hash", "MurmurHash3_32"), ("conversion", "uint32_to_float32")];
    let attributes = attributes.into_iter().chain([("manifest", manifest)]);
    let metadata = attributes.map(|(name, value)| (format!("cryptomatte/d593dd7/{name}"), value.into())).collect();
    let image = ExrImage { channels, metadata, ..ExrImage::new(Window::sized(4, 3)) };
    trochoid::io::write_exr(path, &image).unwrap();
}

/// Returns a folder with the files that golden cases read: the 4 × 3 pictures `read.exr`, `passes.exr` and `crypto.exr`,
/// and `mesh.obj`.
pub(crate) fn folder() -> tempfile::TempDir {
    let folder = tempfile::tempdir().unwrap();
    std::fs::write(folder.path().join("mesh.obj"), MESH).unwrap();
    write_cryptomatte(&folder.path().join("crypto.exr"));
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
