//! Generator of the buoy under `samples/`.

use std::fmt::Write as _;
use trochoid_scene::{DVec3, Triangles};

/// Radius and height in meters around the axis, from the keel up; the waterline is at 0.
const PROFILE: [[f64; 2]; 15] = [
    [0.0, -1.15],
    [0.5, -1.1],
    [0.9, -0.75],
    [1.0, -0.3],
    [1.0, 0.22],
    [0.9, 0.38],
    [0.55, 0.46],
    [0.38, 0.62],
    [0.3, 1.5],
    [0.24, 2.3],
    [0.34, 2.38],
    [0.38, 2.6],
    [0.3, 2.84],
    [0.14, 2.98],
    [0.0, 3.02],
];
/// Segments around the axis.
const SECTORS: usize = 32;

/// Makes a buoy: a body, a mast and a lamp, with texture coordinates around and up. Coordinates are rounded so that both
/// formats store the same mesh.
pub(super) fn buoy() -> Triangles {
    let [low, high] = [PROFILE[0][1], PROFILE[PROFILE.len() - 1][1]];
    let mut mesh = Triangles::default();
    for [radius, height] in PROFILE {
        for sector in 0..=SECTORS {
            let share = sector as f64 / SECTORS as f64;
            // The seam's two sides stand at one place, to the bit.
            let angle = (sector % SECTORS) as f64 / SECTORS as f64 * std::f64::consts::TAU;
            let rounded = |value: f64| (value * 1e4).round() / 1e4;
            let [x, z] = [libm::cos(angle), -libm::sin(angle)].map(|part| rounded(radius * part));
            mesh.positions.push(DVec3::new(x, height, z));
            mesh.uvs.push([share, rounded((height - low) / (high - low))]);
        }
    }
    for ring in 0..PROFILE.len() - 1 {
        for sector in 0..SECTORS {
            let below = (ring * (SECTORS + 1) + sector) as u32;
            let above = below + SECTORS as u32 + 1;
            // At the ends of the axis one of the two has no area.
            if PROFILE[ring][0] > 0.0 {
                mesh.triangles.push([below, below + 1, above + 1]);
            }
            if PROFILE[ring + 1][0] > 0.0 {
                mesh.triangles.push([below, above + 1, above]);
            }
        }
    }
    mesh
}

/// Writes a mesh as Wavefront OBJ, without normals.
pub(super) fn obj_of(mesh: &Triangles) -> String {
    let mut text = String::from("# A buoy: a body, a mast and a lamp. Meters, y up, waterline at 0.\no buoy\n");
    for point in &mesh.positions {
        writeln!(text, "v {} {} {}", point.x + 0.0, point.y, point.z + 0.0).unwrap();
    }
    for [u, v] in &mesh.uvs {
        writeln!(text, "vt {u} {v}").unwrap();
    }
    for [a, b, c] in mesh.triangles.iter().map(|corners| corners.map(|vertex| vertex + 1)) {
        writeln!(text, "f {a}/{a} {b}/{b} {c}/{c}").unwrap();
    }
    text
}

/// Writes a mesh as binary glTF, with normals.
pub(super) fn glb_of(mesh: &Triangles) -> Vec<u8> {
    let normals = mesh.mean_normals();
    let mut bytes: Vec<u8> = Vec::new();
    let mut views = Vec::new();
    let mut view = |values: Vec<u8>| {
        views.push(format!(r#"{{"buffer":0,"byteOffset":{},"byteLength":{}}}"#, bytes.len(), values.len()));
        bytes.extend(values);
        bytes.resize(bytes.len().next_multiple_of(4), 0);
    };
    let floats = |values: &mut dyn Iterator<Item = f64>| values.flat_map(|v| (v as f32 + 0.0).to_le_bytes()).collect();
    view(floats(&mut mesh.positions.iter().flat_map(|p| p.to_array())));
    view(floats(&mut normals.iter().flat_map(|n| n.to_array())));
    view(floats(&mut mesh.uvs.iter().flat_map(|[u, v]| [*u, 1.0 - *v])));
    view(mesh.triangles.iter().flatten().flat_map(|vertex| (*vertex as u16).to_le_bytes()).collect());
    let reach = |pick: fn(f64, f64) -> f64| {
        let all = mesh.positions.iter().copied();
        let corner = all.reduce(|a, b| DVec3::new(pick(a.x, b.x), pick(a.y, b.y), pick(a.z, b.z))).unwrap();
        format!("[{},{},{}]", corner.x as f32, corner.y as f32, corner.z as f32)
    };
    let accessor = |view: usize, ty: u32, count: usize, name: &str, more: &str| {
        format!(r#"{{"bufferView":{view},"componentType":{ty},"count":{count},"type":"{name}"{more}}}"#)
    };
    let count = mesh.positions.len();
    let bounds = format!(r#","min":{},"max":{}"#, reach(f64::min), reach(f64::max));
    let accessors = [
        accessor(0, 5126, count, "VEC3", &bounds),
        accessor(1, 5126, count, "VEC3", ""),
        accessor(2, 5126, count, "VEC2", ""),
        accessor(3, 5123, 3 * mesh.triangles.len(), "SCALAR", ""),
    ];
    let json = format!(
        concat!(
            r#"{{"asset":{{"version":"2.0"}},"scene":0,"scenes":[{{"nodes":[0]}}],"#,
            r#""nodes":[{{"name":"buoy","mesh":0}}],"#,
            r#""meshes":[{{"primitives":[{{"attributes":{{"POSITION":0,"NORMAL":1,"TEXCOORD_0":2}},"indices":3}}]}}],"#,
            r#""accessors":[{}],"bufferViews":[{}],"#,
            r#""buffers":[{{"byteLength":{}}}]}}"#,
        ),
        accessors.join(","),
        views.join(","),
        bytes.len(),
    );
    glb(&json, &bytes)
}

/// Joins two chunks into a GLB.
pub(super) fn glb(json: &str, bytes: &[u8]) -> Vec<u8> {
    let mut json = json.as_bytes().to_vec();
    json.resize(json.len().next_multiple_of(4), b' ');
    let mut file = b"glTF\x02\0\0\0".to_vec();
    let length = 12 + 8 + json.len() + 8 + bytes.len();
    file.extend((length as u32).to_le_bytes());
    for (kind, chunk) in [(b"JSON", json.as_slice()), (b"BIN\0", bytes)] {
        file.extend((chunk.len() as u32).to_le_bytes());
        file.extend(kind);
        file.extend(chunk);
    }
    file
}
