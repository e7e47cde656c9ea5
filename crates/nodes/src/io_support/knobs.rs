//! The knobs of nodes that read a file as an image, and what they mean together.

use trochoid_graph::{Check, Item, Kind, Knob, Settled};

pub(crate) const FILE: Item =
    Knob::path("file", "The picture; #### or %04d stands for the frame, \\# and \\% for the signs.").item();
pub(crate) const AS: Item =
    Knob::choice("as", &["color", "weights", "field"], "What the values mean: a mask is weights of one channel.")
        .required()
        .item();
pub(crate) const PART: Item = Knob::text("part", "Part of a multi-part EXR, by name or number.").item();
pub(crate) const LAYER: Item = Knob::text("layer", "Layer of an EXR; by default the main one.").item();
pub(crate) const CHANNELS: Item = Knob::texts(
    "channels",
    4096,
    "Channels in order: 1 or 3 of a color, one a weight (one alone is a mask), up to 4 of a field. \
     By default RGB of a color, the only one of others.",
)
.item();
pub(crate) const REPAIR: Item =
    Knob::bool("repair", false, "Set illegal values to the nearest legal one, and count them.").item();
pub(crate) const PREMULTIPLIED: Item =
    Knob::bool("premultiplied", false, "Divide by alpha; where it is 0, take the nearest covered pixel.").item();
pub(crate) const ENCODING: Item = Knob::choice(
    "encoding",
    &["auto", "linear", "srgb"],
    "How color is stored; auto: EXR and floats linear, others encoded for display.",
)
.item();

/// The kind that `as` and `channels` make.
pub(crate) fn kind(node: &Settled) -> Kind {
    let channels = node.texts("channels").len().max(1);
    match node.text("as") {
        "weights" if channels == 1 => Kind::MASK,
        "weights" => Kind::Weights(channels),
        "field" => Kind::Field(channels),
        _ => Kind::Color,
    }
}

/// Reports channels that do not make a value of the kind, and knobs that mean colors only. `ty` is the node's type, with
/// its article; `colors` are further items that only colors have, where they are set.
pub(crate) fn check(node: &Settled, ty: &str, colors: &[&'static str], check: &mut Check<'_>) {
    let channels = node.texts("channels").len();
    let found = format!("{channels} channels");
    match node.text("as") {
        "color" if !matches!(channels, 0 | 1 | 3) => {
            check.error("channels", found, "1 channel (gray) or 3 of a color", "list red, green and blue");
        }
        "field" if channels > 4 => {
            let remedy = "read the others in another node of this type";
            check.error("channels", found, "at most 4 components of a field", remedy);
        }
        _ => {}
    }
    if node.text("as") == "color" {
        return;
    }
    let found = format!("{ty} as {}", node.text("as"));
    let premultiplied = node.bool("premultiplied").then_some("premultiplied");
    for item in colors.iter().copied().chain(premultiplied) {
        check.error(item, &found, "\"as\": \"color\"", format!("remove \"{item}\""));
    }
    if node.text("encoding") == "srgb" {
        let remedy = "remove \"encoding\": weights and fields are taken as stored";
        check.error("encoding", found, "\"as\": \"color\"", remedy);
    }
}
