//! Colors of pictures, as `Read` reads them.

use crate::failure::{FAILED, Failure};
use crate::{frames, remedies};
use serde_json::{Value, json};
use std::path::{Path, PathBuf};
use trochoid::io::{self, ChannelInfo, Encoding, Limits, PartInfo, SampleType};
use trochoid::{
    Access, Buffers, Cache, Frame, Monitor, Plan, Settings, Window, escape_frame, expand_frame, parse_within,
    quoted_path,
};

/// Returns the files of pictures: of each with a place for the frame one for each of the frames, if there is a list.
///
/// # Errors
/// The list names no frames, or no picture has a place for them; a picture that does not exist has one, and there is no
/// list.
pub(super) fn files(pictures: &[PathBuf], list: Option<&str>) -> Result<Vec<PathBuf>, Failure> {
    let at = |picture: &Path, frame| PathBuf::from(expand_frame(&picture.to_string_lossy(), frame));
    let has_frame = |picture: &Path| at(picture, 1) != at(picture, 2);
    let Some(list) = list else {
        let lost = pictures.iter().filter(|picture| has_frame(picture) && !picture.exists());
        Failure::all(lost.map(|picture| {
            let message = format!("{}: found a sequence; expected its frames", picture.display());
            Failure::usage(message, "say which, such as --frames 1-96")
        }))?;
        return Ok(pictures.to_vec());
    };
    let frames = match frames::parse(list) {
        Ok(frames) => frames,
        Err(faults) => {
            let remedy = "use a list such as 1-10,20-40x2";
            Failure::all(faults.into_iter().map(|fault| Failure::usage(fault, remedy)))?;
            Vec::new()
        }
    };
    if !pictures.iter().any(|picture| has_frame(picture)) {
        let name = pictures.first().map_or(String::new(), |picture| quoted_path(picture));
        let message = format!("--frames {list}: found {name}; expected a place for the frame in a name");
        return Err(Failure::usage(message, "write #### where the number is, such as shot.####.png"));
    }
    let expand = |picture: &PathBuf| -> Vec<PathBuf> {
        if has_frame(picture) {
            frames.iter().map(|frame| at(picture, *frame)).collect()
        } else {
            vec![picture.clone()]
        }
    };
    Ok(pictures.iter().flat_map(expand).collect())
}

/// Pixels of a picture, row by row.
pub(crate) struct Pixels {
    pub(crate) window: Window,
    /// Colors as displayed.
    pub(crate) colors: Vec<[f32; 3]>,
    /// Largest distance to which the file's rounding moves a color from 0 to 1.
    pub(crate) rounding: f64,
    /// Alpha, if the picture has one.
    alpha: Option<Vec<f32>>,
}

impl Pixels {
    /// Returns the colors that are not transparent, with their places: columns from the left, rows from the top.
    pub(super) fn seen(&self) -> impl Iterator<Item = ([usize; 2], [f32; 3])> {
        let width = self.window.width().max(1);
        let is_seen = |index: &usize| self.alpha.as_ref().is_none_or(|alpha| alpha[*index] > 0.0);
        let all = (0..self.colors.len()).filter(is_seen);
        all.map(move |index| ([index % width, index / width], self.colors[index]))
    }
}

/// Returns the colors of a picture as displayed, row by row.
///
/// # Errors
/// The picture cannot be read, or has illegal values.
pub(crate) fn colors(path: &Path, monitor: &dyn Monitor) -> Result<(Window, Vec<[f32; 3]>), Failure> {
    pixels(path, monitor).map(|pixels| (pixels.window, pixels.colors))
}

/// Returns the pixels of a picture.
///
/// # Errors
/// The picture cannot be read, or has illegal values.
pub(crate) fn pixels(path: &Path, monitor: &dyn Monitor) -> Result<Pixels, Failure> {
    let info = io::info(path, &Limits::default()).map_err(|error| Failure::new(FAILED, error))?;
    let part = &info.parts[0];
    let has_alpha = part.channels.iter().any(|channel| channel.full_name == "A");
    let [width, height] = [part.display.width(), part.display.height()];
    let file = trochoid::resolved(path);
    let file = escape_frame(&file.to_string_lossy());
    let mut document = json!({
        "trochoid": 1,
        "format": { "width": width, "height": height },
        "working_space": "srgb",
        "nodes": { "picture": { "type": "Read", "file": file, "as": "color" } },
        "outputs": { "picture": { "color": "picture" } },
    });
    if has_alpha {
        document["nodes"]["alpha"] = json!({ "type": "Read", "file": file, "as": "field", "channels": ["A"] });
        document["outputs"]["alpha"] = json!({ "field": "alpha" });
    }
    let outputs: &[&str] = if has_alpha { &["picture", "alpha"] } else { &["picture"] };
    let frame = evaluated(path, &document, outputs, monitor)?;
    let colors = displayed(&frame);
    let alpha = has_alpha.then(|| frame.pictures[1].planes[0].samples().to_vec());
    Ok(Pixels { window: frame.window, colors, rounding: rounding(part), alpha })
}

/// Returns the largest distance to which rounding moves a color from 0 to 1 that is stored in a part.
fn rounding(part: &PartInfo) -> f64 {
    let of = |channel: &ChannelInfo| match (channel.sample_type, part.encoding) {
        (SampleType::U8, Encoding::Srgb) => 0.5 / 255.0,
        (SampleType::U16, Encoding::Srgb) => 0.5 / 65535.0,
        // Half an ulp of 11 bits; the sRGB curve makes of it at most this much, which it does of white.
        (SampleType::Half, Encoding::Linear) => 1.055 / 2.4 / 2048.0,
        _ => 0.0,
    };
    3.0_f64.sqrt() * part.channels.iter().map(of).fold(0.0, f64::max)
}

/// Returns the colors of a picture as displayed, row by row, scaled to a size.
///
/// # Errors
/// The picture cannot be read, or has illegal values.
pub(crate) fn scaled(
    path: &Path,
    [width, height]: [usize; 2],
    monitor: &dyn Monitor,
) -> Result<Vec<[f32; 3]>, Failure> {
    let file = trochoid::resolved(path);
    let file = escape_frame(&file.to_string_lossy());
    let document = json!({
        "trochoid": 1,
        // Many samples: pixels of larger pictures are averaged.
        "format": { "width": width, "height": height, "samples": 16 },
        "working_space": "srgb",
        "nodes": { "picture": { "type": "Read", "file": file, "as": "color", "fit": "bilinear" } },
        "outputs": { "picture": { "color": "picture" } },
    });
    Ok(displayed(&evaluated(path, &document, &["picture"], monitor)?))
}

/// Evaluates a document that reads a picture.
fn evaluated(path: &Path, document: &Value, outputs: &[&str], monitor: &dyn Monitor) -> Result<Frame, Failure> {
    let name = path.display().to_string();
    let loaded = parse_within(&name, &document.to_string(), Path::new("."), &[], Access::everything())?;
    let failed = |error: &trochoid::EvalError| Failure::new(FAILED, remedies::evaluation(error));
    let plan =
        Plan::new(&loaded.graph, outputs, 1, &[], &Settings::default()).map_err(|error| Failure::new(FAILED, error))?;
    plan.evaluate(&Buffers::new(), &mut Cache::new(), monitor).map_err(|error| failed(&error))
}

/// Returns the pixels of a frame's first picture.
fn displayed(frame: &Frame) -> Vec<[f32; 3]> {
    let [r, g, b] = [0, 1, 2].map(|channel| frame.pictures[0].planes[channel].samples());
    r.iter().zip(g).zip(b).map(|((r, g), b)| [*r, *g, *b]).collect()
}

#[cfg(test)]
mod tests {
    #![allow(clippy::unwrap_used, reason = "a test may panic")]

    use super::*;

    #[test]
    fn sequences_have_a_file_for_each_frame() {
        let paths = |names: &[&str]| names.iter().map(PathBuf::from).collect::<Vec<_>>();
        let pictures = paths(&["a.##.png", "b.png"]);
        assert_eq!(files(&pictures, Some("1-3x2")).unwrap(), paths(&["a.01.png", "a.03.png", "b.png"]));
        assert_eq!(files(&pictures[1..], None).unwrap(), paths(&["b.png"]));
        let told = |pictures: &[PathBuf], list| files(pictures, list).unwrap_err().messages[0].text().to_owned();
        assert!(told(&pictures, None).starts_with("a.##.png: found a sequence; expected its frames"));
        assert!(told(&pictures[1..], Some("1")).contains("expected a place for the frame"));
        assert!(told(&pictures, Some("x")).contains("--frames: found \"x\""));
    }
}
