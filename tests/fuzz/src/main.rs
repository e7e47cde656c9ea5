//! Writes the initial corpus of each target to a folder of its name: `trochoid-fuzz FOLDER`, from the root of the
//! project.

use std::fs;
use std::path::Path;
use trochoid::certificate::{CertificateInputs, certify};
use trochoid::io::{ExrChannel, ExrImage, PngImage, Samples, write_exr, write_png8, write_png16};
use trochoid::{Buffers, Cache, Certifier, OutputFile, Plan, Plane, Settings, Silent, Window, write_output};

type Result<T = ()> = std::result::Result<T, Box<dyn std::error::Error>>;

fn main() -> Result {
    let folder = std::env::args().nth(1).ok_or("name a folder")?;
    let folder = Path::new(&folder);
    for target in ["documents", "expressions", "exr", "rasters", "models", "certificates", "pictures"] {
        fs::create_dir_all(folder.join(target))?;
    }
    documents(folder)?;
    expressions(&folder.join("expressions"))?;
    images(folder)?;
    models(&folder.join("models"))?;
    certificate(&folder.join("certificates"))
}

/// Copies scenes, golden cases and extreme documents.
fn documents(folder: &Path) -> Result {
    for from in ["graphs", "tests/nodes", "tests/extremes"] {
        for entry in fs::read_dir(from)? {
            let path = entry?.path();
            let name = path.file_name().and_then(|name| name.to_str()).unwrap_or_default();
            if name.ends_with(".json") && !name.ends_with(".expect.json") {
                let name = format!("{}_{name}", from.replace('/', "_"));
                fs::copy(&path, folder.join("documents").join(&name))?;
                fs::copy(&path, folder.join("pictures").join(&name))?;
            }
        }
    }
    Ok(())
}

fn expressions(folder: &Path) -> Result {
    let formulas = [
        "a",
        "a + b * c",
        "clamp(a, 0, 1)",
        "mix(a, b, smoothstep(0, 1, c))",
        "vec3(a, b, c).xyz",
        "a > b ? c : d",
        "-a ^ 2 / (b - 0.5)",
        "sin(a) + cos(b) * exp(-c)",
        "min(a, max(b, c)) % 3",
        "length(vec2(a, b))",
        "1e300 * a",
    ];
    for (index, formula) in formulas.iter().enumerate() {
        fs::write(folder.join(format!("{index}")), formula)?;
    }
    Ok(())
}

fn images(folder: &Path) -> Result {
    let window = Window::new(-1, -2, 6, 5);
    let mut plane = Plane::filled(window, 0.25);
    plane.samples_mut().iter_mut().enumerate().for_each(|(index, sample)| *sample = index as f32 / 49.0);
    let names = ["R", "G", "B", "depth.Z", "more.A"];
    let channels = names.map(|name| ExrChannel::float(name, Samples::plane(&plane))).to_vec();
    write_exr(folder.join("exr/float"), &ExrImage { channels, ..ExrImage::new(window) })?;
    let colors = || [0, 1, 2].map(|_| Samples::plane(&plane)).to_vec();
    write_png8(folder.join("rasters/rgb8"), &PngImage { clamp: true, ..PngImage::new(7, 7, colors()) })?;
    write_png16(folder.join("rasters/rgb16"), &PngImage { clamp: true, ..PngImage::new(7, 7, colors()) })?;
    fs::copy("samples/buoy.png", folder.join("rasters/buoy"))?;
    Ok(())
}

/// Writes models, each after a byte that tells its kind.
fn models(folder: &Path) -> Result {
    let triangle = "v 0 0 0\nv 1 0 0\nv 0 1 0\nvt 0 0\nvn 0 0 1\nf 1/1/1 2/1/1 3/1/1\n";
    let gltf = r#"{"asset":{"version":"2.0"},"scene":0,"scenes":[{"nodes":[0]}],"nodes":[{"mesh":0}],
        "meshes":[{"primitives":[{"attributes":{"POSITION":0}}]}],
        "accessors":[{"bufferView":0,"componentType":5126,"count":3,"type":"VEC3","min":[0,0,0],"max":[1,1,0]}],
        "bufferViews":[{"buffer":0,"byteLength":36}],
        "buffers":[{"byteLength":36,"uri":"data:application/octet-stream;base64,AAAAAAAAAAAAAAAAAACAPwAAAAAAAAAAAAAAAAAAgD8AAAAA"}]}"#;
    let seeds: [(&str, u8, Vec<u8>); 6] = [
        ("triangle", 0, triangle.into()),
        ("gull", 0, fs::read("samples/gull.obj")?),
        ("gltf", 1, gltf.into()),
        ("buoy", 2, fs::read("samples/buoy.glb")?),
        ("snow", 3, fs::read("samples/great_wave_snow.json")?),
        ("spout", 3, fs::read("samples/teapot_spout.json")?),
    ];
    for (name, kind, bytes) in seeds {
        fs::write(folder.join(name), [&[kind][..], &bytes].concat())?;
    }
    Ok(())
}

fn certificate(folder: &Path) -> Result {
    let text = r##"{ "trochoid": 1, "format": { "width": 16, "height": 9 },
        "nodes": { "across": { "type": "ScreenX" }, "mix": { "type": "Mix", "a": "#123", "b": "#fed", "weight": "across" } },
        "outputs": { "beauty": { "color": "mix" } } }"##;
    let graph = trochoid::parse("a.json", text, folder, &[])?.graph;
    let (settings, mut cache) = (Settings::default(), Cache::new());
    let frame = Plan::new(&graph, &[], 1, &[], &settings)?.evaluate(&Buffers::new(), &mut cache, &Silent)?;
    let temporary = tempfile::tempdir()?;
    let file = OutputFile { path: temporary.path().join("a.png"), outputs: vec![0] };
    write_output(&graph, &frame, &file, &[])?;
    let certified = Certifier::new(&graph, &[], 1, &[], &settings)?.certify(&Buffers::new(), &mut cache, &Silent)?;
    let made = CertificateInputs { graph: &graph, file: &file, frame: 1, certified: &certified, settings: &settings };
    let path = folder.join("certificate");
    certify(&made, &path)?.write(&path, None)?;
    Ok(())
}
