//! The knobs of nodes that read a file as an image, and what they mean together.

use trochoid_graph::{Check, Choice, ItemName, Items, Kind};

/// Which file, and as what.
#[derive(Clone, Items)]
pub(crate) struct Named {
    /// The picture; #### or %04d stands for the frame, \# and \% for the signs.
    #[knob(path)]
    pub(crate) file: String,
    /// What the values mean: a mask is weights of one channel.
    #[knob(required)]
    pub(crate) r#as: As,
}

/// What values mean.
#[derive(Clone, Copy, Debug, PartialEq, Choice)]
pub(crate) enum As {
    Color,
    Weights,
    Field,
}

/// What of the file.
#[derive(Clone, Items)]
pub(crate) struct Selected {
    /// Part of a multi-part EXR, by name or number.
    pub(crate) part: Option<String>,
    /// Layer of an EXR; by default the main one.
    pub(crate) layer: Option<String>,
    /// Channels in order: 1 or 3 of a color, one a weight (one alone is a mask), up to 4 of a field. By default RGB of a color, the
    /// only one of others.
    #[knob(len = 0..=4096)]
    pub(crate) channels: Vec<String>,
}

/// How its values are taken.
#[derive(Clone, Items)]
pub(crate) struct Taken {
    /// Set illegal values to the nearest legal one, and count them.
    #[knob(default = false)]
    pub(crate) repair: bool,
    /// Divide by alpha; where it is 0, take the nearest covered pixel.
    #[knob(default = false)]
    pub(crate) premultiplied: bool,
    /// How color is stored; auto: EXR and floats linear, others encoded for display.
    pub(crate) encoding: Encoded,
}

/// How color is stored.
#[derive(Clone, Copy, Debug, PartialEq, Choice)]
pub(crate) enum Encoded {
    Auto,
    Linear,
    Srgb,
}

/// How a picture of another size is laid over the document's.
#[derive(Clone, Copy, Debug, PartialEq, Choice)]
pub(crate) enum FitBy {
    Nearest,
    Bilinear,
    Crop,
}

/// All of them, of one node.
#[derive(Clone, Copy)]
pub(crate) struct Knobs<'n> {
    pub(crate) named: &'n Named,
    pub(crate) selected: &'n Selected,
    pub(crate) taken: &'n Taken,
    pub(crate) fit: Option<FitBy>,
}

impl Knobs<'_> {
    /// The kind that `as` and `channels` make.
    pub(crate) fn kind(self) -> Kind {
        let channels = self.selected.channels.len().max(1);
        match self.named.r#as {
            As::Weights if channels == 1 => Kind::MASK,
            As::Weights => Kind::Weights(channels),
            As::Field => Kind::Field(channels),
            As::Color => Kind::Color,
        }
    }

    /// Reports channels that do not make a value of the kind, and knobs that mean colors only. `ty` is the node's type, with
    /// its article; `color` is a further item that only colors have, where it is set.
    pub(crate) fn check(self, ty: &str, color: Option<ItemName>, check: &mut Check<'_>) {
        let (meaning, channels) = (self.named.r#as, self.selected.channels.len());
        let found = format!("{channels} channels");
        match meaning {
            As::Color if !matches!(channels, 0 | 1 | 3) => {
                let expected = "1 channel (gray) or 3 of a color";
                check.error(Selected::CHANNELS, found, expected, "list red, green and blue");
            }
            As::Field if channels > 4 => {
                let remedy = "read the others in another node of this type";
                check.error(Selected::CHANNELS, found, "at most 4 components of a field", remedy);
            }
            As::Color | As::Weights | As::Field => {}
        }
        if meaning == As::Color {
            return;
        }
        let found = format!("{ty} as {}", meaning.word());
        let premultiplied = self.taken.premultiplied.then_some(Taken::PREMULTIPLIED);
        for item in color.into_iter().chain(premultiplied) {
            check.error(item, &found, "\"as\": \"color\"", format!("remove \"{item}\""));
        }
        if self.taken.encoding == Encoded::Srgb {
            let remedy = "remove \"encoding\": weights and fields are taken as stored";
            check.error(Taken::ENCODING, found, "\"as\": \"color\"", remedy);
        }
    }
}
