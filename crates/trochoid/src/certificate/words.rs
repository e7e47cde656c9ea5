//! Readable forms of the values in a certificate.

use super::{
    BoundAt, BoundSummary, ChannelText, Controls, FormatText, GuaranteeText, InputHash, PixelCounts, PlannedNode,
    Unbounded,
};

/// Value that a failure can name.
pub(super) trait Words {
    /// Returns the value in words.
    fn words(&self) -> String;
}

/// Implements [`Words`] by `Display`.
macro_rules! displayed {
    ($($ty:ty),*) => {
        $(impl Words for $ty {
            fn words(&self) -> String {
                self.to_string()
            }
        })*
    };
}

displayed!(f64, i32, u32, u64, usize, &str, String);

impl<T: Words> Words for Option<T> {
    fn words(&self) -> String {
        self.as_ref().map_or_else(|| "none".into(), Words::words)
    }
}

impl<T: Words> Words for Vec<T> {
    fn words(&self) -> String {
        if self.is_empty() {
            return "none".into();
        }
        self.iter().map(Words::words).collect::<Vec<_>>().join(", ")
    }
}

impl Words for FormatText {
    fn words(&self) -> String {
        let Self { adaptive, width, height, samples, shading, working_space } = self;
        let samples = if *samples == 1 { "1 sample".into() } else { format!("{samples} samples") };
        let adaptive = adaptive.iter().map(|tolerance| format!(", adaptive to {tolerance}")).collect::<String>();
        format!("{width} × {height} pixels of {samples}{adaptive}, shaded by the {shading}, in {working_space}")
    }
}

impl Words for ChannelText {
    fn words(&self) -> String {
        format!("{} ({})", self.name, self.stored)
    }
}

impl Words for PlannedNode {
    fn words(&self) -> String {
        let Self { name, state, ty, why } = self;
        let why = why.as_ref().map_or_else(String::new, |why| format!(": {why}"));
        format!("\"{name}\" ({ty}) {}{why}", state.replace('_', " "))
    }
}

impl Words for PixelCounts {
    fn words(&self) -> String {
        let Self { infinite, nan, outside, outside_by, pixels } = self;
        format!("{pixels} pixels, {nan} NaN, {infinite} infinite, {outside} outside, by up to {outside_by:e}")
    }
}

impl Words for BoundSummary {
    fn words(&self) -> String {
        let Self { bounded, infinite, max, p999, unbounded } = self;
        format!(
            "{bounded} pixels of at most {}, one in a thousand of more than {}; {infinite} infinite; {unbounded} without \
             a bound",
            max.words(),
            p999.words()
        )
    }
}

impl Words for BoundAt {
    fn words(&self) -> String {
        let Self { bound, pixel: [x, y] } = self;
        format!("{bound:e} at ({x}, {y})")
    }
}

impl Words for Controls {
    fn words(&self) -> String {
        let Self { corners, hash, margin, values } = self;
        format!(
            "a hull of {corners} corners, {} of them listed, of the hash {hash}, with the margin {margin:e}",
            values.len()
        )
    }
}

impl Words for GuaranteeText {
    fn words(&self) -> String {
        let Self { class, held, required } = self;
        let [held, required] = [held, required].map(Words::words);
        format!("the class {class}; held: {held}; required: {required}")
    }
}

impl Words for Unbounded {
    fn words(&self) -> String {
        format!("\"{}\": {}", self.node, self.why)
    }
}

/// Width and height in pixels.
#[derive(PartialEq)]
pub(super) struct Size(pub(super) [u32; 2]);

impl Words for Size {
    fn words(&self) -> String {
        format!("{} × {} pixels", self.0[0], self.0[1])
    }
}

/// Length and hash of a file.
#[derive(PartialEq)]
pub(super) struct Contents<'c> {
    bytes: u64,
    hash: &'c str,
}

impl<'c> Contents<'c> {
    pub(super) fn of(input: &'c InputHash) -> Self {
        Self { bytes: input.bytes, hash: &input.hash }
    }
}

impl Words for Contents<'_> {
    fn words(&self) -> String {
        let bytes = if self.bytes == 1 { "1 byte".into() } else { format!("{} bytes", self.bytes) };
        format!("{bytes} with the hash {}", self.hash)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn values_are_named_as_people_read_them() {
        let channel = |name: &str| ChannelText { name: name.into(), stored: "half".into() };
        assert_eq!(vec![channel("G"), channel("R")].words(), "G (half), R (half)");
        assert_eq!((Size([55, 96]).words(), None::<u64>.words()), ("55 × 96 pixels".into(), "none".into()));
        assert_eq!(Contents { bytes: 266_156, hash: "4187" }.words(), "266156 bytes with the hash 4187");
        let node = |state: &str, why: Option<&str>| {
            PlannedNode { name: "a".into(), state: state.into(), ty: "Mix".into(), why: why.map(String::from) }.words()
        };
        assert_eq!(node("evaluated", None), "\"a\" (Mix) evaluated");
        assert_eq!(node("left_out", Some("nothing needs it")), "\"a\" (Mix) left out: nothing needs it");
    }
}
