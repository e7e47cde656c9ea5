//! Tests of CryptoMask on generated files and on one of Blender's.

use crate::testing::{Frame, graph};
use std::path::Path;
use trochoid_graph::{Document, NodeError, Registry, check};
use trochoid_image::{Plane, Window};
use trochoid_io::{ExrChannel, ExrImage, Limits, Samples, Selection, read, write_exr};

/// IDs of names as mmh3, another implementation, has them.
const BUNNY: u32 = 0x1385_1a76;
const DEFAULT: u32 = 0x42c9_679f;
const SHIP: u32 = 0x10a8_2c94;

const WIDTH: usize = 4;
const PIXELS: usize = 12;

/// A channel of 4 × 3 pixels: an ID in all of them, or coverages.
enum Filling<'p> {
    Id(u32),
    Coverage(&'p dyn Fn(usize) -> f32),
}
use Filling::{Coverage, Id};

fn file(folder: &Path, channels: &[(&str, Filling<'_>)], metadata: &[(&str, &str)]) {
    let planes: Vec<Vec<f32>> = channels
        .iter()
        .map(|(_, plane)| match plane {
            Id(id) => vec![f32::from_bits(*id); PIXELS],
            Coverage(of) => (0..PIXELS).map(of).collect(),
        })
        .collect();
    let image = ExrImage {
        channels: channels
            .iter()
            .zip(&planes)
            .map(|((name, _), plane)| ExrChannel::float(*name, Samples::contiguous(plane)))
            .collect(),
        metadata: metadata.iter().map(|(name, value)| ((*name).into(), (*value).into())).collect(),
        ..ExrImage::new(Window::sized(4, 3))
    };
    write_exr(folder.join("a.exr"), &image).unwrap();
}

/// The attributes of a cryptomatte with this manifest.
fn attributes(manifest: &str) -> [(&str, &str); 4] {
    [
        ("cryptomatte/d593dd7/name", "CryptoObject"),
        ("cryptomatte/d593dd7/hash", "MurmurHash3_32"),
        ("cryptomatte/d593dd7/conversion", "uint32_to_float32"),
        ("cryptomatte/d593dd7/manifest", manifest),
    ]
}

const MANIFEST: &str = r#"{"bunny":"13851a76", "default":"42c9679f", "Größe 船":"10a82c94"}"#;

fn first(index: usize) -> f32 {
    0.4 + index as f32 / 40.0
}
fn second(index: usize) -> f32 {
    (index % 3) as f32 / 10.0
}
fn third(index: usize) -> f32 {
    (index % 2) as f32 / 7.0
}

/// Writes a file of three ranks, of which the last has no second one beside it.
fn three_ranks(folder: &Path, metadata: &[(&str, &str)]) {
    let channels = [
        ("CryptoObject00.R", Id(BUNNY)),
        ("CryptoObject00.G", Coverage(&first)),
        ("CryptoObject00.B", Id(DEFAULT)),
        ("CryptoObject00.A", Coverage(&second)),
        ("CryptoObject01.R", Id(SHIP)),
        ("CryptoObject01.G", Coverage(&third)),
    ];
    file(folder, &channels, metadata);
}

fn frame(folder: &Path, knobs: &str) -> Result<Frame, NodeError> {
    let node = format!(r#""out": {{ "type": "CryptoMask", "file": "a.exr", {knobs} }}"#);
    let frame = Frame::new(graph("weights", &node, folder).unwrap())?;
    // Bad data is found only where it is needed.
    frame.fill_all("out")?;
    Ok(frame)
}

fn refused(folder: &Path, knobs: &str) -> String {
    frame(folder, knobs).err().unwrap().to_string()
}

/// Checks the mask of every pixel, and that it and its reference agree.
fn expect(frame: &Frame, expected: impl Fn(usize) -> f64) {
    let id = frame.graph.find("out").unwrap();
    for index in 0..PIXELS {
        let at = [(index % WIDTH) as f64 + 0.5, (index / WIDTH) as f64 + 0.5];
        let (found, truth) = (frame.filled(id, 0, 0, at), frame.truth(at)[1]);
        let expected = expected(index);
        assert!((truth - expected).abs() <= 1e-15, "pixel {index}: the reference {truth}, not {expected}");
        assert_eq!(found, truth as f32, "pixel {index}");
    }
}

#[test]
fn masks_are_the_coverages_of_all_ranks_by_name() {
    let folder = tempfile::tempdir().unwrap();
    three_ranks(folder.path(), &attributes(MANIFEST));
    let one = |of: fn(usize) -> f32| move |index: usize| f64::from(of(index));
    expect(&frame(folder.path(), r#""names": ["bunny"]"#).unwrap(), one(first));
    expect(&frame(folder.path(), r#""names": ["default"]"#).unwrap(), one(second));
    expect(&frame(folder.path(), r#""names": ["Größe 船"], "layer": "CryptoObject""#).unwrap(), one(third));
    let all = frame(folder.path(), r#""names": ["default", "bunny", "Größe 船", "bunny"]"#).unwrap();
    expect(&all, |i| (f64::from(first(i)) + f64::from(second(i)) + f64::from(third(i))).min(1.0));
}

#[test]
fn ids_come_from_the_manifest_and_otherwise_from_names() {
    let folder = tempfile::tempdir().unwrap();
    // A manifest counts before the hash: here the names are exchanged.
    three_ranks(folder.path(), &attributes(r#"{"bunny":"42c9679f"}"#));
    expect(&frame(folder.path(), r#""names": ["bunny"]"#).unwrap(), |i| f64::from(second(i)));
    // Without one, names are hashed as the specification has it, also if the manifest is in another file.
    three_ranks(folder.path(), &[]);
    expect(&frame(folder.path(), r#""names": ["bunny", "Größe 船"]"#).unwrap(), |i| {
        f64::from(first(i)) + f64::from(third(i))
    });
    expect(&frame(folder.path(), r#""names": ["bnuny"]"#).unwrap(), |_| 0.0);
    let mut sidecar = attributes("manifest.json");
    sidecar[3].0 = "cryptomatte/d593dd7/manif_file";
    three_ranks(folder.path(), &sidecar);
    expect(&frame(folder.path(), r#""names": ["default"]"#).unwrap(), |i| f64::from(second(i)));
}

#[test]
fn exponents_of_hashes_are_neither_0_nor_255() {
    // The hashes are 000738c5 and ff8d97ef, of which the first is near 0 and the second is no number.
    let folder = tempfile::tempdir().unwrap();
    for (name, id) in [("n17", 0x0087_38c5), ("n535", 0xff0d_97ef), ("a", 0x3c25_69b2), ("abcde", 0xe89b_9af6)] {
        file(folder.path(), &[("CryptoAsset00.r", Id(id)), ("CryptoAsset00.g", Coverage(&first))], &[]);
        expect(&frame(folder.path(), &format!(r#""names": ["{name}"]"#)).unwrap(), |i| f64::from(first(i)));
    }
}

#[test]
fn a_misspelt_name_is_refused_with_the_nearest_of_the_manifest() {
    let folder = tempfile::tempdir().unwrap();
    three_ranks(folder.path(), &attributes(MANIFEST));
    let text = refused(folder.path(), r#""names": ["bunny", "defualt"]"#);
    assert!(text.contains("\"names\"") && text.contains("a.exr") && text.contains("found \"defualt\""), "{text}");
    assert!(text.contains("\"bunny\", \"default\"") && text.ends_with("did you mean \"default\"?"), "{text}");
}

#[test]
fn damaged_manifests_are_refused_by_their_place() {
    let folder = tempfile::tempdir().unwrap();
    for (manifest, what) in [
        ("{\"bunny\":\"13851a76\"", "EOF"),
        ("[\"bunny\"]", "invalid type: sequence"),
        ("{\"bunny\":327949942}", "invalid type: integer"),
        ("{\"bunny\":\"13851a7\"}", "the ID \"13851a7\" of \"bunny\""),
        ("{\"bunny\":\"+3851a76\"}", "the ID \"+3851a76\" of \"bunny\""),
        ("{\"bunny\":\"13851ä6\"}", "the ID \"13851ä6\" of \"bunny\""),
        ("", "EOF"),
    ] {
        three_ranks(folder.path(), &attributes(manifest));
        let text = refused(folder.path(), r#""names": ["bunny"]"#);
        let place = "part 0: found attribute cryptomatte/d593dd7/manifest: ";
        assert!(text.contains(place) && text.contains(what), "{manifest}: {text}");
    }
    three_ranks(folder.path(), &attributes("{}"));
    let text = refused(folder.path(), r#""names": ["bunny"]"#);
    assert!(text.contains("its manifest, which is empty"), "{text}");
    for field in [1, 2] {
        let mut other = attributes(MANIFEST);
        other[field].1 = "MD5";
        three_ranks(folder.path(), &other);
        let text = refused(folder.path(), r#""names": ["bunny"]"#);
        assert!(text.contains(other[field].0) && text.contains("found") && text.contains("\"MD5\""), "{text}");
    }
}

#[test]
fn the_cryptomatte_is_found_by_itself_if_there_is_one() {
    let folder = tempfile::tempdir().unwrap();
    file(folder.path(), &[("R", Coverage(&first))], &[]);
    let text = refused(folder.path(), r#""names": ["bunny"]"#);
    assert!(text.contains("\"file\": ") && text.contains("a file without a cryptomatte"), "{text}");
    let two = [
        ("CryptoMaterial00.r", Id(DEFAULT)),
        ("CryptoMaterial00.g", Coverage(&second)),
        ("CryptoObject00.r", Id(BUNNY)),
        ("CryptoObject00.g", Coverage(&first)),
        ("uv00.r", Coverage(&first)),
    ];
    file(folder.path(), &two, &[]);
    let text = refused(folder.path(), r#""names": ["bunny"]"#);
    assert!(text.contains("2 cryptomattes: \"CryptoMaterial\", \"CryptoObject\""), "{text}");
    let text = refused(folder.path(), r#""names": ["bunny"], "layer": "CryptoAsset""#);
    assert!(text.contains("no cryptomatte \"CryptoAsset\", expected one of \"CryptoMaterial\""), "{text}");
    let found = frame(folder.path(), r#""names": ["default"], "layer": "cryptomaterial""#).unwrap();
    expect(&found, |i| f64::from(second(i)));
    // Names of layers need not begin with "crypto" if the header says what they are.
    let own = [("ids00.r", Id(BUNNY)), ("ids00.g", Coverage(&first))];
    file(folder.path(), &own, &[("cryptomatte/1/name", "ids")]);
    expect(&frame(folder.path(), r#""names": ["bunny"]"#).unwrap(), |i| f64::from(first(i)));
}

#[test]
fn channels_without_their_other_half_are_refused() {
    let folder = tempfile::tempdir().unwrap();
    for (channels, what) in [
        ([("CryptoObject00.r", Id(BUNNY)), ("CryptoObject00.b", Id(DEFAULT))], "IDs without coverages"),
        ([("CryptoObject00.g", Coverage(&first)), ("CryptoObject00.a", Coverage(&first))], "coverages without IDs"),
    ] {
        file(folder.path(), &channels, &[]);
        let text = refused(folder.path(), r#""names": ["bunny"]"#);
        assert!(text.contains("channel \"CryptoObject00.") && text.contains(what), "{text}");
    }
    let ids = [f32::from_bits(BUNNY); PIXELS];
    let image = ExrImage {
        channels: vec![
            ExrChannel::half("CryptoObject00.r", Samples::contiguous(&ids)),
            ExrChannel::float("CryptoObject00.g", Samples::contiguous(&ids)),
        ],
        ..ExrImage::new(Window::sized(4, 3))
    };
    write_exr(folder.path().join("a.exr"), &image).unwrap();
    let text = refused(folder.path(), r#""names": ["bunny"]"#);
    assert!(text.contains("IDs as half"), "{text}");
}

#[test]
fn illegal_coverages_are_refused_or_repaired_and_sums_end_at_1() {
    let folder = tempfile::tempdir().unwrap();
    for (bad, found, repaired) in [(f32::NAN, "found NaN", 0.0), (1.5, "found 1.5", 1.0), (-0.5, "found -0.5", 0.0)] {
        let coverage = |index: usize| if index == 6 { bad } else { 0.25 };
        file(folder.path(), &[("Crypto00.r", Id(BUNNY)), ("Crypto00.g", Coverage(&coverage))], &[]);
        let text = refused(folder.path(), r#""names": ["bunny"]"#);
        assert!(text.contains("channel \"Crypto00.g\", pixel (2, 1)") && text.contains(found), "{text}");
        let frame = frame(folder.path(), r#""names": ["bunny"], "repair": true"#).unwrap();
        expect(&frame, |index| if index == 6 { repaired } else { 0.25 });
        assert_eq!(frame.node("out").repaired(), 1);
    }
    // Rounding of renderers is no fault.
    file(folder.path(), &[("Crypto00.r", Id(BUNNY)), ("Crypto00.g", Coverage(&|_| 1.000_1))], &[]);
    expect(&frame(folder.path(), r#""names": ["bunny"]"#).unwrap(), |_| 1.0);
    let twice = [
        ("Crypto00.r", Id(BUNNY)),
        ("Crypto00.g", Coverage(&|_| 0.75)),
        ("Crypto00.b", Id(DEFAULT)),
        ("Crypto00.a", Coverage(&|_| 0.75)),
    ];
    file(folder.path(), &twice, &[]);
    expect(&frame(folder.path(), r#""names": ["bunny", "default"]"#).unwrap(), |_| 1.0);
}

#[test]
fn masks_of_a_file_of_blender_are_sums_over_its_layers() {
    let path = Path::new(env!("CARGO_MANIFEST_DIR")).join("../../samples/blender_ocean.0001.exr");
    let folder = tempfile::tempdir().unwrap();
    std::fs::copy(path, folder.path().join("a.exr")).unwrap();
    let layers = ["Ocean.CryptoObject00", "Ocean.CryptoObject01"]
        .map(|layer| read(folder.path().join("a.exr"), &Selection::layer(layer), &Limits::default()).unwrap());
    let ranks: Vec<[&Plane; 2]> = layers
        .iter()
        .flat_map(|layer| [["r", "g"], ["b", "a"]].map(|rank| rank.map(|name| layer.channel(name).unwrap())))
        .collect();
    let sum = |ids: &[u32], x: i64, y: i64| -> f64 {
        let at = |plane: &Plane| plane.row(y).unwrap()[x as usize];
        let of = |[id, coverage]: &[&Plane; 2]| {
            if ids.contains(&at(id).to_bits()) { f64::from(at(coverage)) } else { 0.0 }
        };
        ranks.iter().map(of).sum()
    };
    let (hull, mast) = (0xa65b_7927, 0x4683_23e4);
    for (names, ids) in [(r#"["Ship_Hull"]"#, &[hull][..]), (r#"["Ship_Mast", "Ship_Hull"]"#, &[hull, mast])] {
        let text = format!(
            r#"{{ "trochoid": 1, "format": {{ "width": 480, "height": 270 }},
                "nodes": {{ "out": {{ "type": "CryptoMask", "file": "a.exr", "names": {names} }} }},
                "outputs": {{ "out": {{ "weights": "out" }} }} }}"#
        );
        let document = Document::parse("test.json", &text).unwrap();
        let (graph, faults) = check(&document, &Registry::new(trochoid_nodes::all()), folder.path());
        let mask = Frame::new(graph.unwrap_or_else(|| panic!("{faults:?}"))).unwrap();
        mask.fill_all("out").unwrap();
        let id = mask.graph.find("out").unwrap();
        let (mut whole, mut partial) = (0, 0);
        for (x, y) in (0..270).flat_map(|y| (0..480).map(move |x| (x, y))) {
            let (found, expected) = (mask.filled(id, 0, 0, [x as f64 + 0.5, y as f64 + 0.5]), sum(ids, x, y).min(1.0));
            assert!((f64::from(found) - expected).abs() <= 6e-8, "pixel ({x}, {y}): {found}, not {expected}");
            whole += u32::from(expected == 1.0);
            partial += u32::from(expected > 0.0 && expected < 1.0);
        }
        assert!(whole > 1000 && partial > 100, "{names}: {whole} whole pixels, {partial} partial ones");
    }
}
