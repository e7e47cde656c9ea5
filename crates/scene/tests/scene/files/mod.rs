//! Valid and invalid meshes.

mod patches;
mod samples;

use samples::{buoy, glb, glb_of, obj_of};
use std::path::{Path, PathBuf};
use trochoid_scene::files::mesh;
use trochoid_scene::inside::joined;
use trochoid_scene::{DVec3, Triangles};

fn samples(name: &str) -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).join("../../samples").join(name)
}

/// Returns position and texture coordinates of the corners of all triangles.
fn corners(mesh: &Triangles) -> Vec<(DVec3, [f64; 2])> {
    let corners = mesh.triangles.iter().flatten().map(|vertex| *vertex as usize);
    corners.map(|vertex| (mesh.positions[vertex], mesh.uvs[vertex])).collect()
}

#[test]
fn the_samples_are_what_this_code_makes() {
    assert_eq!(std::fs::read_to_string(samples("buoy.obj")).unwrap(), obj_of(&buoy()));
    assert_eq!(std::fs::read(samples("buoy.glb")).unwrap(), glb_of(&buoy()));
}

#[test]
#[ignore = "writes the samples anew"]
fn write_the_samples() {
    std::fs::write(samples("buoy.obj"), obj_of(&buoy())).unwrap();
    std::fs::write(samples("buoy.glb"), glb_of(&buoy())).unwrap();
}

#[test]
fn both_formats_read_back_what_was_written() {
    let made = buoy();
    for name in ["buoy.obj", "buoy.glb"] {
        let read = mesh(&std::fs::read(samples(name)).unwrap()).unwrap();
        assert_eq!(read.triangles.len(), made.triangles.len(), "{name}");
        for ((p, uv), (q, st)) in corners(&read).into_iter().zip(corners(&made)) {
            assert!(p.distance(q) < 1e-6 && (uv[0] - st[0]).abs() + (uv[1] - st[1]).abs() < 1e-6, "{name}: {p} {q}");
        }
        let [given, mean] =
            [if read.normals.is_empty() { read.mean_normals() } else { read.normals.clone() }, read.mean_normals()];
        assert!(given.iter().zip(&mean).all(|(a, b)| a.distance(*b) < 1e-3), "{name}");
        // The outer side looks outward: around a closed mesh the normals' flux is three times its volume.
        let volume: f64 = read
            .triangles
            .iter()
            .map(|t| t.map(|vertex| read.positions[vertex as usize]))
            .map(|[a, b, c]| a.dot(b.cross(c)) / 6.0)
            .sum();
        assert!(volume > 1.0 && volume < 5.0, "{name}: {volume}");
    }
}

#[test]
fn what_is_no_obj_is_refused_by_its_line() {
    let corner = "v 0 0 0\nv 1 0 0\nv 0 1 0\n";
    for (text, part) in [
        ("", "found no triangle"),
        ("# nothing\n", "found no triangle"),
        (corner, "found no triangle"),
        (&format!("{corner}f 1 2\n"), "found no triangle"),
        (&format!("{corner}f 1 2 4\n"), "line 4: found a face vertex index out of bounds"),
        (&format!("{corner}f 1 2 0\n"), "line 4: found the index 0 after 3 vertices"),
        (&format!("{corner}f 1 2 -4\n"), "line 4: found the index -4 after 3 vertices"),
        (&format!("{corner}f 1 2 99999999999999999999\n"), "line 4: found the index 99999999999999999999"),
        (&format!("{corner}f 1/-9 2/1 3/1\n"), "after 0 texture coordinates"),
        (&format!("{corner}f 1//7 2//1 3//1\nvn 0 0 1\n"), "line 5: found a face normal index out of bounds"),
        (&format!("{corner}f 1 2 three\n"), "line 4: found a face parse error"),
        ("v 0 0 0\nv 1 nought 0\n", "line 2: found a position parse error"),
        ("v 0 0\n", "line 1: found a position parse error"),
        ("v nan 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 3\n", "found the coordinate NaN of a vertex"),
        ("v 0 0 0\nv 1e300 0 0\nv 0 1 0\nf 1 2 3\n", "found the coordinate 1e300 of"),
        (&format!("{corner}vt 0 0\nf 1/1 2 3\n"), "give all corners of an object the same parts"),
        ("[dependencies]\nlibm = 1\n", "found no triangle"),
        ("PNG\0\0\0\rIHDR", "found a binary file that is not a GLB"),
    ] {
        let error = mesh(text.as_bytes()).unwrap_err().to_string();
        assert!(error.contains(part), "{text:?}: {error}");
    }
    assert!(mesh(b"v 0 0 0\n\xff\xfe\n").unwrap_err().to_string().contains("line 2"));
    let back = mesh(format!("{corner}f -3 -2 -1\n").as_bytes()).unwrap();
    assert_eq!(back.triangles, [[0, 1, 2]]);
}

/// Returns a triangle as glTF, after an edit of its JSON.
fn triangle(change: &[(&str, &str)], cut: usize) -> Vec<u8> {
    let mut json = concat!(
        r#"{"asset":{"version":"2.0"},"scene":0,"scenes":[{"nodes":[0]}],"#,
        r#""nodes":[{"children":[1],"translation":[1,0,0]},{"mesh":0,"scale":[2,1,-1]}],"#,
        r#""meshes":[{"primitives":[{"attributes":{"POSITION":0},"indices":1}]}],"#,
        r#""accessors":[{"bufferView":0,"componentType":5126,"count":4,"type":"VEC3","min":[0,0,0],"max":[1,1,1]},"#,
        r#"{"bufferView":1,"componentType":5121,"count":4,"type":"SCALAR"}],"#,
        r#""bufferViews":[{"buffer":0,"byteOffset":0,"byteLength":48},{"buffer":0,"byteOffset":48,"byteLength":4}],"#,
        r#""buffers":[{"byteLength":52}]}"#,
    )
    .to_owned();
    for (from, to) in change {
        assert!(json.contains(from), "{from}");
        json = json.replacen(from, to, 1);
    }
    let mut bytes: Vec<u8> =
        [0, 0, 0, 1, 0, 0, 0, 1, 0, 0, 0, 1].into_iter().flat_map(|v| f32::to_le_bytes(v as f32)).collect();
    bytes.extend([0, 1, 2, 3]);
    bytes.truncate(bytes.len() - cut);
    glb(&json, &bytes)
}

#[test]
fn gltf_stands_where_its_nodes_do() {
    let read = mesh(&triangle(&[(r#""indices":1"#, r#""indices":1,"mode":5"#)], 0)).unwrap();
    // A strip of two triangles; scaled by (2, 1, −1), which mirrors, then moved by 1 along x.
    assert_eq!(read.positions[1], DVec3::new(3.0, 0.0, 0.0));
    assert_eq!(read.positions[3], DVec3::new(1.0, 0.0, -1.0));
    assert_eq!(read.triangles, [[0, 2, 1], [1, 2, 3]]);
    let fan = mesh(&triangle(&[(r#""indices":1"#, r#""indices":1,"mode":6"#)], 0)).unwrap();
    assert_eq!(fan.triangles, [[0, 2, 1], [0, 3, 2]]);
    let plain = mesh(&triangle(&[], 0)).unwrap();
    assert_eq!(plain.triangles, [[0, 2, 1]]);
}

#[test]
fn buffers_may_be_embedded_but_not_apart() {
    let whole = triangle(&[(r#""buffers":[{"#, r#""buffers":[{"uri":"other.bin","#)], 0);
    assert!(mesh(&whole).unwrap_err().to_string().contains("another file, \"other.bin\""));
    let data =
        "data:application/octet-stream;base64,AAAAAAAAAAAAAAAAAACAPwAAAAAAAAAAAAAAAAAAgD8AAAAAAAAAAAAAAAAAAIA/AAECAw==";
    let embedded = triangle(&[(r#""buffers":[{"#, &format!(r#""buffers":[{{"uri":"{data}","#))], 0);
    assert_eq!(mesh(&embedded).unwrap(), mesh(&triangle(&[], 0)).unwrap());
    let broken = triangle(&[(r#""buffers":[{"#, r#""buffers":[{"uri":"data:;base64,A*","#)], 0);
    assert!(mesh(&broken).unwrap_err().to_string().contains("buffer 0: found no base64"));
}

#[test]
fn what_is_no_gltf_is_refused_by_its_place() {
    for (from, to, part) in [
        (r#""scenes":[{"nodes":[0]}]"#, r#""scenes":[{"nodes":[7]}]"#, "scenes[0].nodes[0]"),
        (r#""children":[1]"#, r#""children":[0]"#, "node 0: found it below two nodes, or below itself"),
        (r#""children":[1]"#, r#""children":[1,1]"#, "node 1: found it below two nodes"),
        (r#""scene":0,"scenes":[{"nodes":[0]}],"#, "", "found no scene"),
        (r#""count":4,"type":"VEC3""#, r#""count":5,"type":"VEC3""#, "POSITION: found 5 elements that reach beyond"),
        (r#""count":4,"type":"VEC3""#, r#""count":4000000000,"type":"VEC3""#, "found 4000000000 vertices"),
        (r#""count":4,"type":"SCALAR""#, r#""count":18446744073709551615,"type":"SCALAR""#, "indices: found 184467"),
        (r#""count":4,"type":"SCALAR""#, r#""count":0,"type":"SCALAR""#, "found no triangle"),
        (r#""byteLength":48"#, r#""byteLength":18446744073709551000"#, "POSITION: found 4 elements that reach beyond"),
        (r#""byteOffset":48"#, r#""byteOffset":18446744073709551000"#, "indices: found 4 elements that reach beyond"),
        (r#""byteLength":48"#, r#""byteLength":48,"byteStride":8"#, "reach beyond bufferView 0"),
        (r#""componentType":5121"#, r#""componentType":5126"#, "indices: found"),
        (r#""type":"SCALAR""#, r#""type":"VEC2""#, "indices: found Vec2; expected Scalar"),
        (r#""byteOffset":48"#, r#""byteOffset":44"#, "names vertex 128"),
        (r#""POSITION":0"#, r#""POSITION":2"#, "mesh 0: found accessor 2 for POSITION, but there are 2"),
        (r#""asset":{"version":"2.0"},"#, "", "missing field `asset`"),
    ] {
        let error = mesh(&triangle(&[(from, to)], 0)).err().unwrap_or_else(|| panic!("accepted: {to}")).to_string();
        assert!(error.contains(part), "{to}: {error}");
    }
    assert!(mesh(&triangle(&[], 4)).unwrap_err().to_string().contains("indices: found 4 elements that reach beyond"));
    assert!(mesh(&triangle(&[], 52)).unwrap_err().to_string().contains("reach beyond bufferView"));
    let deep = "{\"a\":".repeat(100_000);
    assert!(mesh(deep.as_bytes()).is_err());
    for length in [0u32, 4, 12, 19, 21, u32::MAX] {
        let mut file = b"glTF\x02\0\0\0".to_vec();
        file.extend(length.to_le_bytes());
        assert!(mesh(&file).unwrap_err().to_string().contains("12 bytes of a GLB"), "{length}");
    }
}

#[test]
fn damaged_files_are_refused_or_read_but_never_break() {
    let mut state = 0x2545_f491_4f6c_dd1du64;
    let mut random = move |below: usize| {
        state ^= state << 13;
        state ^= state >> 7;
        state ^= state << 17;
        (state >> 16) as usize % below.max(1)
    };
    let (mut read, mut refused) = (0, 0);
    let originals = [obj_of(&buoy()).into_bytes(), glb_of(&buoy()), triangle(&[], 0)];
    for round in 0..1500 {
        let mut bytes = originals[round % 3].clone();
        if random(4) == 0 {
            bytes.truncate(random(bytes.len()));
        }
        for _ in 0..random(6) {
            let at = random(bytes.len());
            let with = [b"9", b"-", b"/", b"e", b"\n", b"}", b"[", b"\xff"][random(8)][0];
            if let Some(byte) = bytes.get_mut(at) {
                *byte = if random(3) == 0 { random(256) as u8 } else { with };
            }
        }
        match mesh(&bytes) {
            Ok(mesh) => {
                mesh.check().unwrap();
                read += 1;
            }
            Err(error) => {
                assert!(!error.to_string().is_empty());
                refused += 1;
            }
        }
    }
    assert!(read > 100 && refused > 300, "{read} read, {refused} refused");
}

#[test]
fn parts_get_what_only_others_have() {
    let plain = mesh(b"v 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 3\n").unwrap();
    let full = mesh(b"v 0 0 5\nv 1 0 5\nv 0 1 5\nvt 0.5 0.5\nvn 1 0 0\nf 1/1/1 2/1/1 3/1/1\n").unwrap();
    let both = joined(vec![plain, full]).unwrap();
    assert_eq!(both.normals, [DVec3::Z, DVec3::Z, DVec3::Z, DVec3::X, DVec3::X, DVec3::X]);
    assert_eq!((both.uvs[0], both.uvs[5]), ([0.0; 2], [0.5; 2]));
    assert_eq!(both.triangles, [[0, 1, 2], [3, 4, 5]]);
}
