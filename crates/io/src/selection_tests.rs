use trochoid_image::Window;

use super::*;
use crate::{Compression, Encoding, SampleType, Storage};

/// Creates parts with these names and channels.
fn parts(described: &[(Option<&str>, &[&str])]) -> Vec<PartInfo> {
    let mut parts: Vec<PartInfo> = described
        .iter()
        .map(|(name, channels)| PartInfo {
            name: name.map(Into::into),
            display: Window::sized(1, 1),
            data: Window::sized(1, 1),
            compression: Compression::Zip,
            storage: Storage::Scanline,
            layers: Vec::new(),
            channels: channels
                .iter()
                .map(|name| ChannelInfo {
                    full_name: (*name).into(),
                    layer: String::new(),
                    base: String::new(),
                    sample_type: SampleType::Half,
                    sampling: [1, 1],
                })
                .collect(),
            attributes: Vec::new(),
            chromaticities: None,
            encoding: Encoding::Linear,
        })
        .collect();
    names::resolve(&mut parts);
    parts
}

fn find(parts: &[PartInfo], selection: &Selection) -> Result<(usize, Vec<String>), Error> {
    let found = selection.resolve(Path::new("a.exr"), parts)?;
    let names = found.channels.iter().map(|&index| parts[found.part].channels[index].full_name.clone());
    Ok((found.part, names.collect()))
}

fn full(part: usize, names: &[&str]) -> (usize, Vec<String>) {
    (part, names.iter().map(|name| (*name).into()).collect())
}

fn blender_5() -> Vec<PartInfo> {
    parts(&[
        (Some("Ocean.Combined"), &["Ocean.Combined.A", "Ocean.Combined.B", "Ocean.Combined.G", "Ocean.Combined.R"]),
        (Some("Ocean.Depth"), &["Ocean.Depth.Z"]),
        (Some("Ocean.Diffuse Direct"), &["Ocean.Diffuse Direct.B", "Ocean.Diffuse Direct.G", "Ocean.Diffuse Direct.R"]),
        (Some("Ocean.UV"), &["Ocean.UV.u", "Ocean.UV.v"]),
    ])
}

fn blender_3() -> Vec<PartInfo> {
    parts(&[(
        None,
        &[
            "ViewLayer.Combined.A",
            "ViewLayer.Combined.B",
            "ViewLayer.Combined.G",
            "ViewLayer.Combined.R",
            "ViewLayer.Depth.Z",
            "ViewLayer.Vector.W",
            "ViewLayer.Vector.X",
            "ViewLayer.Vector.Y",
            "ViewLayer.Vector.Z",
        ],
    )])
}

#[test]
fn one_part_a_layer() {
    let parts = blender_5();
    let rgba = ["R", "G", "B", "A"].map(|base| format!("Ocean.Combined.{base}"));
    for selection in [
        Selection::default(),
        Selection::layer("Ocean.Combined"),
        Selection::layer("Combined"),
        Selection::layer("combined"),
        Selection::default().with_part("Ocean.Combined"),
        Selection::default().with_part("0"),
        Selection::default().with_part(0),
    ] {
        assert_eq!(find(&parts, &selection).unwrap(), (0, rgba.to_vec()), "{selection:?}");
    }
    let rgb = ["R", "G", "B"].map(|base| format!("Ocean.Diffuse Direct.{base}"));
    assert_eq!(find(&parts, &Selection::layer("Diffuse Direct")).unwrap(), (2, rgb.to_vec()));
    assert_eq!(find(&parts, &Selection::channels(["Ocean.Depth.Z"])).unwrap(), full(1, &["Ocean.Depth.Z"]));
    let uv = Selection::layer("UV").with_channels(["V", "u"]);
    assert_eq!(find(&parts, &uv).unwrap(), full(3, &["Ocean.UV.v", "Ocean.UV.u"]));
}

#[test]
fn all_layers_in_one_part() {
    let parts = blender_3();
    assert_eq!(parts[0].layers, ["ViewLayer.Combined", "ViewLayer.Depth", "ViewLayer.Vector"]);
    assert_eq!(find(&parts, &Selection::default()).unwrap().1[0], "ViewLayer.Combined.R");
    assert_eq!(find(&parts, &Selection::layer("Depth")).unwrap(), full(0, &["ViewLayer.Depth.Z"]));
    let vector: Vec<String> = ["X", "Y", "Z", "W"].map(|base| format!("ViewLayer.Vector.{base}")).to_vec();
    assert_eq!(find(&parts, &Selection::layer("ViewLayer.Vector")).unwrap(), (0, vector));
    let wanted = Selection::channels(["ViewLayer.Depth.Z", "R"]);
    assert_eq!(find(&parts, &wanted).unwrap(), full(0, &["ViewLayer.Depth.Z", "ViewLayer.Combined.R"]));
}

#[test]
fn parts_with_bare_channels() {
    let parts = parts(&[(Some("rgba"), &["A", "B", "G", "R"]), (Some("depth"), &["Z"]), (Some("motion"), &["u", "v"])]);
    assert_eq!(parts[1].layers, ["depth"]);
    assert_eq!(find(&parts, &Selection::default()).unwrap(), full(0, &["R", "G", "B", "A"]));
    assert_eq!(find(&parts, &Selection::layer("depth")).unwrap(), full(1, &["Z"]));
    assert_eq!(find(&parts, &Selection::default().with_part("Motion")).unwrap(), full(2, &["u", "v"]));
    let error = find(&parts, &Selection::channels(["R", "Z"])).unwrap_err();
    assert!(matches!(error, Error::Ambiguous { .. }), "{error}");
}

#[test]
fn parts_whose_channels_lack_the_part_name() {
    let parts = parts(&[(Some("Ocean"), &["Combined.R", "Depth.Z"]), (Some("Sky"), &["Combined.R"])]);
    assert_eq!(find(&parts, &Selection::layer("Ocean.Combined")).unwrap(), full(0, &["Combined.R"]));
    assert_eq!(find(&parts, &Selection::layer("Combined").with_part("Sky")).unwrap(), full(1, &["Combined.R"]));
    let error = find(&parts, &Selection::layer("Combined")).unwrap_err();
    assert!(error.to_string().contains("Combined of part 1 \"Sky\""), "{error}");
    // The layer of a part with one layer can be selected by the part's name, too.
    assert_eq!(find(&parts, &Selection::layer("Sky")).unwrap(), full(1, &["Combined.R"]));
}

#[test]
fn the_unnamed_layer_is_the_main_one() {
    let parts = parts(&[(None, &["A", "B", "G", "R", "Z", "diffuse.B", "diffuse.G", "diffuse.R"])]);
    assert_eq!(parts[0].layers, ["", "diffuse"]);
    assert_eq!(find(&parts, &Selection::default()).unwrap(), full(0, &["R", "G", "B", "A", "Z"]));
    assert_eq!(find(&parts, &Selection::channels(["Z"])).unwrap(), full(0, &["Z"]));
    assert_eq!(find(&parts, &Selection::layer("")).unwrap(), full(0, &["R", "G", "B", "A", "Z"]));
}

#[test]
fn errors_list_the_nearest_name_first() {
    let parts = blender_5();
    let text = |selection: Selection| find(&parts, &selection).unwrap_err().to_string();
    let message = text(Selection::layer("Ocean.Dept"));
    assert!(message.starts_with("a.exr: no layer \"Ocean.Dept\"; the file has \"Ocean.Depth\","), "{message}");
    let message = text(Selection::layer("Depth").with_channels(["R"]));
    assert_eq!(
        message,
        "a.exr: no channel \"R\" in layer \"Ocean.Depth\"; the file has \"Z\": name one of these, such as \"Z\""
    );
    let message = text(Selection::default().with_part("Ocean.UW"));
    assert!(message.contains("no part \"Ocean.UW\"; the file has \"Ocean.UV\""), "{message}");
    let message = text(Selection::default().with_part(9));
    assert!(message.contains("no part \"9\""), "{message}");
    let message = text(Selection::channels(["Ocean.Depth.Q"]));
    assert!(message.contains("no channel \"Ocean.Depth.Q\""), "{message}");
}

#[test]
fn case_is_ignored_only_where_one_name_fits() {
    let parts = parts(&[(None, &["R", "g", "r"])]);
    assert_eq!(find(&parts, &Selection::channels(["G"])).unwrap(), full(0, &["g"]));
    assert_eq!(find(&parts, &Selection::channels(["r"])).unwrap(), full(0, &["r"]));
    let parts = self::parts(&[(None, &["Z", "z"])]);
    assert_eq!(find(&parts, &Selection::channels(["Z"])).unwrap(), full(0, &["Z"]));
}

#[test]
fn layers_without_a_main_one_must_be_named() {
    let parts = parts(&[(None, &["depth.Z", "normal.X"])]);
    let error = find(&parts, &Selection::default()).unwrap_err();
    assert!(matches!(error, Error::Ambiguous { .. }));
    assert!(error.to_string().contains("name the layer"), "{error}");
}

#[test]
fn a_bare_channel_of_a_named_layer_is_sought_nowhere_else() {
    let file = parts(&[(None, &["R", "G", "B", "depth.Z"])]);
    let selection = Selection::layer("depth").with_channels(["R"]);
    let error = find(&file, &selection).unwrap_err().to_string();
    assert!(error.contains("no channel \"R\" in layer \"depth\"") && error.contains('Z'), "{error}");
    assert_eq!(find(&file, &Selection::channels(["R", "depth.Z"])).unwrap(), full(0, &["R", "depth.Z"]));
}
