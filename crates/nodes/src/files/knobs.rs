//! Knobs of nodes that read a file as an image, and their combined meaning.

use trochoid_graph::{Check, Choice, ItemName, Items, Kind};

/// File, and the kind of its values.
#[derive(Clone, Items)]
pub(crate) struct FileKnobs {
    /// Picture file. #### or %04d stands for the frame number; write \# and \% for literal signs.
    #[knob(path)]
    pub(crate) file: String,
    /// Meaning of the values: colors, weights or a field. Weights of one channel are a mask.
    #[knob(required)]
    pub(crate) r#as: As,
}

/// Meaning of a file's values.
#[derive(Clone, Copy, Debug, PartialEq, Choice)]
pub(crate) enum As {
    Color,
    Weights,
    Field,
}

/// Selection of data in the file.
#[derive(Clone, Items)]
pub(crate) struct SelectionKnobs {
    /// Part of a multi-part EXR, by name or number.
    pub(crate) part: Option<String>,
    /// Layer of an EXR; if unset, the main one.
    pub(crate) layer: Option<String>,
    /// Channels, in order: 1 or 3 for a color, one per weight (a single one is a mask), up to 4 for a field. If empty,
    /// RGB for a color, otherwise the only channel.
    #[knob(len = 0..=4096)]
    pub(crate) channels: Vec<String>,
}

/// Interpretation of the values.
#[derive(Clone, Items)]
pub(crate) struct DecodeKnobs {
    /// Sets illegal values to the nearest legal one, and counts them.
    #[knob(default = false)]
    pub(crate) repair: bool,
    /// Divides colors by alpha; pixels with alpha 0 take the color of the nearest covered pixel.
    #[knob(default = false)]
    pub(crate) premultiplied: bool,
    /// Encoding of stored colors; "auto" takes EXR and floating-point files as linear, others as encoded for display.
    pub(crate) encoding: Encoded,
}

/// Encoding of stored colors.
#[derive(Clone, Copy, Debug, PartialEq, Choice)]
pub(crate) enum Encoded {
    Auto,
    Linear,
    Srgb,
}

/// Fit of a picture whose size differs from the document's.
#[derive(Clone, Copy, Debug, PartialEq, Choice)]
pub(crate) enum FitBy {
    Nearest,
    Bilinear,
    Crop,
}

/// All of these knobs, of one node.
#[derive(Clone, Copy)]
pub(crate) struct Knobs<'n> {
    pub(crate) named: &'n FileKnobs,
    pub(crate) selected: &'n SelectionKnobs,
    pub(crate) taken: &'n DecodeKnobs,
    pub(crate) fit: Option<FitBy>,
}

impl Knobs<'_> {
    /// Returns the kind determined by `as` and `channels`.
    pub(crate) fn kind(self) -> Kind {
        let channels = self.selected.channels.len().max(1);
        match self.named.r#as {
            As::Weights if channels == 1 => Kind::MASK,
            As::Weights => Kind::Weights(channels),
            As::Field => Kind::Field(channels),
            As::Color => Kind::Color,
        }
    }

    /// Reports channels that do not fit the kind, and knobs that apply only to colors. `ty` is the node's type with
    /// its article; `color` is another item that applies only to colors, if set.
    pub(crate) fn check(self, ty: &str, color: Option<ItemName>, check: &mut Check<'_>) {
        let (meaning, channels) = (self.named.r#as, self.selected.channels.len());
        let found = format!("{channels} channels");
        match meaning {
            As::Color if !matches!(channels, 0 | 1 | 3) => {
                let expected = "1 channel (gray) or 3 channels of a color";
                check.error(SelectionKnobs::CHANNELS, found, expected, "list red, green and blue");
            }
            As::Field if channels > 4 => {
                let remedy = "read the others in another node of this type";
                check.error(SelectionKnobs::CHANNELS, found, "at most 4 components of a field", remedy);
            }
            As::Color | As::Weights | As::Field => {}
        }
        if meaning == As::Color {
            return;
        }
        let found = format!("{ty} as {}", meaning.word());
        let premultiplied = self.taken.premultiplied.then_some(DecodeKnobs::PREMULTIPLIED);
        for item in color.into_iter().chain(premultiplied) {
            check.error(item, &found, "\"as\": \"color\"", format!("remove \"{item}\""));
        }
        if self.taken.encoding == Encoded::Srgb {
            let remedy = "remove \"encoding\": weights and fields are used as stored";
            check.error(DecodeKnobs::ENCODING, found, "\"as\": \"color\"", remedy);
        }
    }
}
