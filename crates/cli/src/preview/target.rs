//! What a preview is written as: the name of the file tells.

use crate::failure::Failure;
use std::path::{Path, PathBuf};
use trochoid::{Form, expand_frame, one_frame_pattern, quoted, quoted_path};

/// What a preview is written as.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Kind {
    /// MP4.
    Movie,
    /// Animated WebP.
    Animation,
    /// A single PNG.
    Still,
    /// A PNG for each frame.
    Sequence,
}

/// Maximum width and height of a WebP file, in pixels.
const LARGEST: u32 = 16_383;

impl Kind {
    /// Returns what a file is, by its name.
    ///
    /// # Errors
    /// Nothing is written under such a name.
    pub(super) fn of(out: &Path) -> Result<Self, Failure> {
        let name = out.display().to_string();
        if let Some(one) = one_frame_pattern(&name) {
            let message = format!("--out {}: found two places for the frame; expected one", quoted_path(out));
            return Err(Failure::usage(message, format!("use a name such as {}", quoted(&one))));
        }
        let ending = out.extension().map(|ending| ending.to_string_lossy().to_ascii_lowercase());
        match ending.as_deref() {
            Some("mp4") => Ok(Self::Movie),
            Some("webp") => Ok(Self::Animation),
            Some("png") if has_frame(&name) => Ok(Self::Sequence),
            Some("png") => Ok(Self::Still),
            _ => {
                let found = if ending.is_some() { "another extension" } else { "no extension" };
                let message = format!("--out {}: found {found}; expected .mp4, .webp or .png", quoted_path(out));
                Err(Failure::usage(message, "use a name such as storm.mp4, storm.webp or storm.####.png"))
            }
        }
    }

    pub(super) fn form(self) -> Form {
        match self {
            Self::Movie => Form::Mp4,
            Self::Animation => Form::WebP,
            Self::Still | Self::Sequence => Form::Preview,
        }
    }

    /// Returns the file of a frame.
    pub(super) fn path(self, out: &Path, frame: i64) -> PathBuf {
        match (self, out.to_str()) {
            (Self::Sequence, Some(name)) => expand_frame(name, frame).into(),
            _ => out.into(),
        }
    }

    /// Returns why pictures of this size, and so many, cannot be written.
    pub(super) fn refused(self, out: &Path, [width, height]: [u32; 2], frames: usize) -> Option<Failure> {
        if self == Self::Still && frames > 1 {
            let message = format!("--out {}: found {frames} frames; expected one in a PNG", quoted_path(out));
            let remedy = "choose one with --frames, or use a name such as storm.####.png, storm.webp or storm.mp4";
            return Some(Failure::usage(message, remedy));
        }
        if matches!(self, Self::Animation | Self::Movie) && width.max(height) > LARGEST {
            let message =
                format!("found a preview of {width} × {height} pixels; expected at most {LARGEST} on each side");
            return Some(Failure::usage(message, "make it smaller: --scale"));
        }
        None
    }
}

/// Whether a name has a place for the frame.
fn has_frame(name: &str) -> bool {
    expand_frame(name, 0) != expand_frame(name, 1)
}
