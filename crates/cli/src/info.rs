//! `trochoid info`: describes the contents of an image file.

use crate::failure::{FAILED, Failure, Message};
use crate::shell::{self, HEADING, printable};
use serde_json::{Map, Value, json};
use std::fmt::Write as _;
use std::path::{Path, PathBuf};
use trochoid::Window;
use trochoid::io::{self, Encoding, Error, Info, Limits, PartInfo, Selection, Statistics};

/// Options of `trochoid info`.
#[derive(Debug, clap::Args)]
#[command(after_help = "Examples:\n  trochoid info out/beauty.0012.exr\n  trochoid info passes.exr --json")]
pub(crate) struct Args {
    /// The EXR, PNG, JPEG or TIFF file
    #[arg(value_name = "IMAGE")]
    image: PathBuf,
    /// Print JSON
    #[arg(long)]
    json: bool,
}

/// Maximum size of the decoded samples held at once, in bytes.
const BATCH: u64 = 1 << 30;

/// Statistics of a channel's samples, or the reason that the channel cannot be read.
type ChannelStatistics = Result<Statistics, Error>;

/// Prints a file's header and the statistics of each channel.
///
/// # Errors
/// The file is not an image or is damaged, or stdout cannot be written. Everything that can be read is still printed.
pub(crate) fn run(args: &Args) -> Result<(), Failure> {
    let info = io::info(&args.image, &Limits::default()).map_err(|error| Failure::new(FAILED, error))?;
    let found: Vec<Vec<ChannelStatistics>> =
        info.parts.iter().enumerate().map(|(index, part)| measure(&args.image, index, part)).collect();
    if args.json {
        shell::print_json(&to_json(&args.image, &info, &found))?;
    } else {
        shell::print(&to_text(&args.image, &info, &found))?;
    }
    // Channels that this version does not support are only described; damage is a failure.
    let mut messages: Vec<Message> = Vec::new();
    for error in found.into_iter().flatten().filter_map(Result::err) {
        let message = Message::error(&error);
        if !matches!(error, Error::Unsupported { .. }) && messages.last() != Some(&message) {
            messages.push(message);
        }
    }
    if messages.is_empty() { Ok(()) } else { Err(Failure { code: FAILED, messages }) }
}

/// Returns the statistics of each channel of a part, decoding as many channels at once as fit in [`BATCH`] bytes.
fn measure(path: &Path, index: usize, part: &PartInfo) -> Vec<ChannelStatistics> {
    let bytes = (part.data.area() as u64).saturating_mul(4).max(1);
    let batch = usize::try_from(BATCH / bytes).unwrap_or(usize::MAX).max(1);
    part.channels
        .chunks(batch)
        .flat_map(|channels| {
            let names: Vec<&str> = channels.iter().map(|channel| channel.full_name.as_str()).collect();
            let read = |names: &[&str]| {
                let selection = Selection::channels(names.iter().copied()).with_part(index);
                io::read(path, &selection, &Limits::default())
            };
            match read(&names) {
                Ok(picture) => picture.channels.iter().map(|channel| Ok(io::statistics(&channel.plane))).collect(),
                // One channel that cannot be read must not hide the others.
                Err(_) => names
                    .iter()
                    .map(|name| read(&[name]).map(|picture| io::statistics(&picture.channels[0].plane)))
                    .collect::<Vec<ChannelStatistics>>(),
            }
        })
        .collect()
}

fn layer_name(layer: &str) -> &str {
    if layer.is_empty() { "(unnamed)" } else { layer }
}

fn encoding_name(encoding: Encoding) -> &'static str {
    match encoding {
        Encoding::Linear => "linear",
        Encoding::Srgb => "sRGB",
    }
}

fn to_text(path: &Path, info: &Info, found: &[Vec<ChannelStatistics>]) -> String {
    let mut text = format!("{HEADING}{}{HEADING:#}: {}", printable(&path.display().to_string()), info.kind);
    let _ = writeln!(text, ", {} part{}", info.parts.len(), if info.parts.len() == 1 { "" } else { "s" });
    for (index, (part, found)) in info.parts.iter().zip(found).enumerate() {
        let name = part.name.as_ref().map_or(String::new(), |name| format!(" \"{}\"", printable(name)));
        let _ = writeln!(text, "\n{HEADING}Part {index}{name}{HEADING:#}");
        for (key, value) in [
            ("display", window_text(part.display)),
            ("data", window_text(part.data)),
            ("storage", part.storage.to_string()),
            ("compression", part.compression.to_string()),
            ("encoding", encoding_name(part.encoding).into()),
            ("layers", part.layers.iter().map(|l| printable(layer_name(l))).collect::<Vec<_>>().join(", ")),
        ] {
            let _ = writeln!(text, "  {key:12} {value}");
        }
        let width = part.channels.iter().map(|channel| channel.full_name.chars().count()).max().unwrap_or(0);
        let _ = writeln!(text, "\n  {HEADING}Channels{HEADING:#}");
        for (channel, found) in part.channels.iter().zip(found) {
            let values = match found {
                Ok(found) => values_text(found),
                Err(error) => format!("not read: {}", printable(&error.to_string())),
            };
            let (name, stored) = (printable(&channel.full_name), channel.sample_type.to_string());
            let _ = writeln!(text, "  {name:width$}  {stored:5}  {values}");
        }
        if !part.attributes.is_empty() {
            let _ = writeln!(text, "\n  {HEADING}Attributes{HEADING:#}");
        }
        for (key, value) in &part.attributes {
            let _ = writeln!(text, "  {}: {}", printable(key), printable(value));
        }
    }
    text
}

/// Formats the size and the corners of a window.
fn window_text(window: Window) -> String {
    let Window { x0, y0, x1, y1 } = window;
    format!("{} × {} pixels, x {x0} to {x1}, y {y0} to {y1}", window.width(), window.height())
}

fn values_text(found: &Statistics) -> String {
    let number = |value: Option<f64>| value.map_or("none".into(), |value| format!("{value:.6}"));
    let (min, max) = (found.min.map(f64::from), found.max.map(f64::from));
    let infinite = found.positive_infinite + found.negative_infinite;
    let (min, max, mean) = (number(min), number(max), number(found.mean));
    format!("min {min}  max {max}  mean {mean}  {} NaN  {infinite} infinite", found.nan)
}

fn to_json(path: &Path, info: &Info, found: &[Vec<ChannelStatistics>]) -> Value {
    let window = |w: Window| json!({ "x0": w.x0, "y0": w.y0, "x1": w.x1, "y1": w.y1 });
    let parts: Vec<Value> = info
        .parts
        .iter()
        .zip(found)
        .map(|(part, found)| {
            let channels: Vec<Value> = part
                .channels
                .iter()
                .zip(found)
                .map(|(channel, found)| {
                    let mut value = json!({
                        "name": channel.full_name,
                        "layer": channel.layer,
                        "type": channel.sample_type.to_string(),
                        "sampling": channel.sampling,
                    });
                    match found {
                        Ok(found) => {
                            value["min"] = json!(found.min);
                            value["max"] = json!(found.max);
                            value["mean"] = json!(found.mean);
                            value["finite"] = json!(found.finite);
                            value["nan"] = json!(found.nan);
                            value["positive_infinite"] = json!(found.positive_infinite);
                            value["negative_infinite"] = json!(found.negative_infinite);
                        }
                        Err(error) => value["not_read"] = json!(error.to_string()),
                    }
                    value
                })
                .collect();
            let attributes: Map<String, Value> =
                part.attributes.iter().map(|(key, value)| (key.clone(), json!(value))).collect();
            json!({
                "name": part.name,
                "display": window(part.display),
                "data": window(part.data),
                "storage": part.storage.to_string(),
                "compression": part.compression.to_string(),
                "encoding": encoding_name(part.encoding),
                "layers": part.layers,
                "channels": channels,
                "attributes": attributes,
            })
        })
        .collect();
    json!({ "file": path.display().to_string(), "kind": info.kind.to_string(), "parts": parts })
}
