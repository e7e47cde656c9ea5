//! Memory estimates for nodes that read pictures, from the files' headers.

use super::kept::Grid;
use super::knobs::{FitBy, Knobs};
use super::{Fit, FoundPass, Holding, Reading, limits};
use crate::files::shared::KEPT;
use std::path::Path;
use trochoid_graph::{Choice, FrameContext, Kind, MemoryContext, MemoryUse, NodeError};
use trochoid_image::Window;
use trochoid_io::{Cost, RowReader, Selection};

/// Remedy for files that take too much memory.
const REMEDY: &str = "crop or scale the picture, or save it as EXR, which is read row by row on demand";

/// Returns the memory of a picture that is `laid` over the document's pixels and held so (Read), or looked up anywhere
/// (Texture).
///
/// Reads only headers and decodes no pixels. A file that cannot be read counts as nothing.
pub(crate) fn memory_of_picture(knobs: Knobs<'_>, context: &MemoryContext<'_>, laid: Option<Holding>) -> MemoryUse {
    let path = context.frame.path(&knobs.named.file);
    let wanted = context.wanted.first().map(Vec::as_slice).unwrap_or_default();
    if !wanted.contains(&true) {
        return MemoryUse::default();
    }
    in_use(Reading { knobs, frame: context.frame, path: &path, outside: None }.cost(wanted, laid))
}

/// Returns the memory of a view of passes for its file.
pub(crate) fn memory_of_passes(file: &str, context: &MemoryContext<'_>) -> MemoryUse {
    in_use(cost_of_passes(context.frame, &context.frame.path(file)))
}

/// Returns the memory of channels that are read on demand, and of nothing else in their parts.
pub(crate) fn memory_on_demand(parts: &[FoundPass]) -> MemoryUse {
    let whole = parts.iter().map(|found| 4 * found.info.data.area() as u64 * found.channels.len() as u64);
    MemoryUse::held(whole.map(|bytes| bytes.min(KEPT as u64)).sum(), REMEDY)
}

fn in_use(cost: Result<Cost, NodeError>) -> MemoryUse {
    let Cost { held, decoding } = cost.unwrap_or_default();
    MemoryUse::held(held, REMEDY).working(decoding)
}

impl Reading<'_> {
    /// Returns the cost of a value, from the knobs shared by Read and Texture; a Read keeps only the pixels that the
    /// document's samples need.
    fn cost(&self, wanted: &[bool], laid: Option<Holding>) -> Result<Cost, NodeError> {
        let kind = self.knobs.kind();
        let selection = self.selection(self.wanted_channels(kind, wanted));
        let cost = trochoid_io::cost(self.path, &selection, None, &limits(self.frame))?;
        let planes = match kind {
            // A gray picture has three planes of color; alpha is held while colors are divided by it.
            Kind::Color => 3 + u64::from(self.knobs.taken.premultiplied),
            Kind::Field(_) => wanted.iter().filter(|wanted| **wanted).count() as u64,
            _ => kind.channels() as u64,
        };
        let (pixels, grid) = self.pixels(&selection, kind, laid.is_some())?;
        let whole = 4 * planes * pixels;
        // Of weights that are divided by their sum, decoded pictures keep the quotients in f64 too.
        let more = if matches!(kind, Kind::Weights(_)) && self.knobs.selected.channels.len() > 1 { 3 } else { 1 };
        let streams = |colors: u64| kind != Kind::Color || whole > colors;
        let held = match (grid, laid) {
            (Held::Stream, Some(laid)) if laid.on_demand.is_some_and(streams) => whole.min(KEPT as u64),
            (Held::Grid(count), Some(laid)) if whole > laid.whole && 2 * count <= pixels => more * 4 * planes * count,
            _ => more * whole,
        };
        // While a whole picture is decoded, its channels are in memory too.
        let besides = if held >= whole { cost.held.saturating_sub(whole) } else { 0 };
        Ok(Cost { held, decoding: cost.decoding + besides })
    }

    /// Returns the number of pixels in the picture, and how a Read holds them.
    fn pixels(&self, selection: &Selection, kind: Kind, laid: bool) -> Result<(u64, Held), NodeError> {
        let premultiplied = kind == Kind::Color && self.knobs.taken.premultiplied;
        if trochoid_io::kind(self.path)?.is_exr() {
            let reader = trochoid_io::ExrReader::open(self.path, selection, &limits(self.frame))?;
            let held = if premultiplied { Held::Whole } else { Held::Stream };
            return Ok((reader.info().data.area() as u64, held));
        }
        let reader = RowReader::open(self.path, selection, &limits(self.frame))?;
        let (display, data): (Window, Window) = (reader.info().display, reader.info().data);
        let pixels = data.area() as u64;
        if premultiplied || !laid {
            return Ok((pixels, Held::Whole));
        }
        let fit = Fit::new(
            self.knobs.fit,
            FitBy::WORDS,
            display,
            [self.frame.format, self.frame.document_format],
            self.path,
        )?;
        Ok((pixels, Held::Grid(Grid::new(&fit, self.frame.format, data).count() as u64)))
    }
}

fn cost_of_passes(frame: &FrameContext, path: &Path) -> Result<Cost, NodeError> {
    if trochoid_io::kind(path)?.is_exr() {
        // Rows are read on demand and take no more than all channels of the file.
        let info = trochoid_io::info(path, &limits(frame))?;
        let whole = info.parts.iter().map(|part| 4 * part.data.area() as u64 * part.channels.len() as u64);
        return Ok(Cost { held: whole.sum::<u64>().min(KEPT as u64), decoding: 0 });
    }
    Ok(trochoid_io::cost(path, &Selection::default(), None, &limits(frame))?)
}

/// Storage of a file's pixels.
enum Held {
    Whole,
    /// Rows read on demand.
    Stream,
    /// Pixels of a grid, with their number.
    Grid(u64),
}
