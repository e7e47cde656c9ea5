//! Sheets: all pixels of a case by the f64 references, in a text that is stored beside it.

use std::fmt::Write as _;
use trochoid::{CheckedGraph, ReferenceFrame};

/// Values of an output by its reference.
pub(crate) struct Truth {
    pub(crate) output: String,
    size: [usize; 2],
    /// Values row by row, each pixel with all its channels.
    pixels: Vec<Vec<f64>>,
}

impl Truth {
    /// Evaluates all outputs of a graph at a frame.
    pub(crate) fn of(graph: &CheckedGraph, frame: i64) -> Result<Vec<Self>, String> {
        let size = [graph.format().width(), graph.format().height()];
        let all = graph.outputs().iter().map(|output| {
            let reference = ReferenceFrame::new(graph, &output.name, frame).map_err(|error| error.to_string())?;
            let places = (0..i64::from(size[1])).flat_map(|y| (0..i64::from(size[0])).map(move |x| (x, y)));
            let pixels = places.map(|(x, y)| reference.pixel(x, y).map_err(|error| error.to_string()));
            Ok(Self {
                output: output.name.clone(),
                size: size.map(|side| side as usize),
                pixels: pixels.collect::<Result<_, String>>()?,
            })
        });
        all.collect()
    }

    /// Returns all values with their pixels and channels.
    pub(crate) fn values(&self) -> impl Iterator<Item = ([i64; 2], usize, f64)> {
        let width = self.size[0];
        self.pixels.iter().enumerate().flat_map(move |(at, pixel)| {
            let place = [(at % width) as i64, (at / width) as i64];
            pixel.iter().enumerate().map(move |(channel, value)| (place, channel, *value))
        })
    }
}

/// Formats a sheet with one line per row. Numbers have enough digits to read back the same bits.
pub(crate) fn text(name: &str, truths: &[Truth]) -> String {
    let mut text = format!(
        "Every pixel as the f64 references have it; made by TROCHOID_UPDATE=1 cargo test -p trochoid-tests -- nodes/{name}\n"
    );
    for truth in truths {
        for channel in 0..truth.pixels[0].len() {
            let _ = writeln!(text, "\n{}, channel {channel}", truth.output);
            for row in truth.pixels.chunks(truth.size[0]) {
                let row: Vec<String> = row.iter().map(|pixel| pixel[channel].to_string()).collect();
                let _ = writeln!(text, "{}", row.join(" "));
            }
        }
    }
    text
}
