//! `trochoid blame`: the colors that pixels are mixed from.
//!
//! The JSON output has `output` and `frame`, and `pixels`, a list of `{x, y, color, colors, images}`: the displayed color;
//! a list of `{name, color, weight}`, the largest weight first, of all colors with a weight above 0; and the weight of
//! pictures that the document reads. All weights of a pixel sum to 1.

use crate::changes::Changes;
use crate::failure::Failure;
use crate::files::AccessOptions;
use crate::fit::source::{self, Source};
use crate::palette::write::hex;
use crate::progress::Progress;
use crate::{interrupt, shell, warnings};
use serde_json::{Value, json};
use std::fmt::Write as _;
use std::path::PathBuf;
use trochoid::Window;

/// Options of `trochoid blame`.
#[derive(Debug, clap::Args)]
#[command(after_help = "\
Weights are those of the finished pixel, over all samples, filters and strokes. Each color of the document's palette is \
counted once, wherever it is used; other colors are named by node and place, such as sky.stops[1].color.

Examples:
  trochoid blame storm.json --at 960,540
  trochoid blame storm.json --frame 36 --at 412,300 --at 413,300 --json")]
pub(crate) struct Args {
    /// The document
    #[arg(value_name = "GRAPH")]
    graph: PathBuf,
    /// The pixel, from the left and from the top, the first being 0,0; may be repeated
    #[arg(long, value_name = "X,Y", required = true, value_parser = pixel, allow_hyphen_values = true)]
    at: Vec<[i64; 2]>,
    /// Frame [default: the document's first]
    #[arg(long, value_name = "N", allow_hyphen_values = true)]
    frame: Option<i64>,
    /// Output [default: the first color]
    #[arg(long, value_name = "NAME")]
    output: Option<String>,
    #[command(flatten)]
    changes: Changes,
    #[command(flatten)]
    reach: AccessOptions,
    /// Print JSON
    #[arg(long)]
    json: bool,
}

/// Text that is no pixel.
#[derive(Debug, thiserror::Error)]
#[error("expected two whole numbers, such as 960,540")]
struct NoPixel;

fn pixel(text: &str) -> Result<[i64; 2], NoPixel> {
    let (x, y) = text.split_once(',').ok_or(NoPixel)?;
    match (x.trim().parse(), y.trim().parse()) {
        (Ok(x), Ok(y)) => Ok([x, y]),
        _ => Err(NoPixel),
    }
}

/// Least weight that is listed for reading; JSON has all.
const LISTED: f64 = 5e-5;

/// A pixel and its colors.
struct Blamed {
    at: [i64; 2],
    /// As displayed.
    color: [f64; 3],
    /// Indices of colors, and their weights, the largest first.
    colors: Vec<(usize, f64)>,
    images: f64,
}

/// Tells the colors of pixels.
///
/// # Errors
/// The document is invalid, has no such pixel, or cannot be rendered.
pub(crate) fn run(args: &Args) -> Result<(), Failure> {
    let loaded = args.reach.load(&args.graph, &args.changes.assignments())?;
    let output = source::output(&loaded.graph, args.output.as_deref())?;
    let window = loaded.graph.format().window();
    let beyond = args.at.iter().filter(|[x, y]| !window.contains(*x, *y)).map(|[x, y]| {
        let (width, height) = (window.width(), window.height());
        let message = format!("--at {x},{y}: found a pixel outside of the picture; expected one of {width} × {height}");
        Failure::usage(message, format!("the last one is {},{}", width - 1, height - 1))
    });
    warnings::after(beyond, &warnings::of(&loaded.graph, &[output], loaded.warnings))?;
    interrupt::watch()?;
    let frame = args.frame.unwrap_or(loaded.graph.frames().0);
    let mut progress = Progress::new(args.at.len(), args.json);
    let (mut names, mut colors, mut blamed) = (Vec::new(), Vec::new(), Vec::new());
    for (index, &[x, y]) in args.at.iter().enumerate() {
        progress.begin(index, frame);
        let region = Some(Window::new(x, y, x + 1, y + 1));
        let source = Source::of_graph(&loaded.graph, output, frame, region, &progress)?;
        let (weights, images) = source.at(0);
        let mut mixed = images;
        for (weight, color) in weights.iter().zip(&source.colors) {
            (0..3).for_each(|c| mixed[c] += weight * color[c]);
        }
        let images = (1.0 - weights.iter().sum::<f64>()).max(0.0);
        let mut parts: Vec<(usize, f64)> =
            weights.into_iter().enumerate().filter(|(_, weight)| *weight > 0.0).collect();
        parts.sort_by(|a, b| b.1.total_cmp(&a.1).then(a.0.cmp(&b.0)));
        // What rounding leaves of the sum is no image.
        let images = if images > 1e-4 { images } else { 0.0 };
        blamed.push(Blamed { at: [x, y], color: source.space.to_display(mixed), colors: parts, images });
        colors = source.colors.iter().map(|color| source.space.to_display(*color)).collect();
        names = source.names;
    }
    progress.finish();
    let shown = |color: [f64; 3]| hex(color.map(|v| v.clamp(0.0, 1.0)));
    let name = &loaded.graph.outputs()[output].name;
    if args.json {
        let part = |(index, weight): &(usize, f64)| -> Value {
            json!({ "name": names[*index], "color": shown(colors[*index]), "weight": weight })
        };
        let pixel = |blamed: &Blamed| -> Value {
            let Blamed { at: [x, y], color, colors, images } = blamed;
            let parts: Vec<Value> = colors.iter().map(part).collect();
            json!({ "x": x, "y": y, "color": shown(*color), "colors": parts, "images": images })
        };
        let pixels: Vec<Value> = blamed.iter().map(pixel).collect();
        return shell::print_json(&json!({ "output": name, "frame": frame, "pixels": pixels }));
    }
    let mut text = String::new();
    for Blamed { at: [x, y], color, colors: parts, images } in &blamed {
        let _ = writeln!(text, "{name}, frame {frame}, pixel {x},{y}: {}", shown(*color));
        let (listed, rest) = parts.split_at(parts.partition_point(|(_, weight)| *weight >= LISTED));
        for (index, weight) in listed {
            let _ = writeln!(text, "  {:6.2} %  {}  {}", 100.0 * weight, shown(colors[*index]), names[*index]);
        }
        if !rest.is_empty() {
            let (sum, count) = (rest.iter().map(|(_, weight)| weight).sum::<f64>(), rest.len());
            let colors = if count == 1 { "color" } else { "colors" };
            let _ = writeln!(text, "  {:6.2} %  {count} more {colors}, each below 0.005 %", 100.0 * sum);
        }
        if *images > 0.0 {
            let _ = writeln!(text, "  {:6.2} %  pictures that the document reads", 100.0 * images);
        }
    }
    shell::print(&text)
}
