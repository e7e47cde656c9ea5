//! Rows of a picture on demand: decoded, validated and converted when a block of samples needs them.

use super::layer::Fit;
use super::legal::{Rule, illegal, legalize};
use super::recipe::Recipe;
use super::shared::{SharedFile, Slot};
use std::path::PathBuf;
use std::sync::atomic::{AtomicU64, Ordering};
use std::sync::{Arc, OnceLock};
use trochoid_graph::{Block, NodeError};
use trochoid_image::{Plane, Rgb, Window};
use trochoid_memory::Scratch;

/// Number of columns converted together, so that their samples stay in cache.
const PIECE: usize = 1024;

/// Maximum number of rows for reading on demand; limits the memory for bookkeeping per row.
pub(crate) const MOST_ROWS: usize = 1 << 24;

/// Source of stored samples.
pub(crate) enum Rows {
    /// A file decoded on demand, and the positions of the channels in it.
    File(Arc<SharedFile>, Vec<usize>),
    /// Planes in memory.
    Memory(Vec<Plane>),
}

/// Data about the stored samples, needed for validation and messages.
pub(crate) struct Stored {
    pub(crate) path: PathBuf,
    pub(crate) part: usize,
    /// Full names of the channels.
    pub(crate) names: Vec<String>,
    pub(crate) data: Window,
    pub(crate) rule: Rule,
    pub(crate) repair: bool,
}

/// Channels of a picture, laid over the document's; rows are converted only when requested.
pub(crate) struct Stream {
    pub(crate) stored: Stored,
    pub(crate) rows: Rows,
    /// Conversion of the stored channels to the output's; `None` if they are the same.
    pub(crate) recipe: Option<Box<dyn Recipe>>,
    /// Number of the output's channels.
    pub(crate) outputs: usize,
    pub(crate) fit: Fit,
    /// Color outside the data window; if `None`, the nearest pixel repeats.
    pub(crate) outside: Option<Rgb>,
    judged: Vec<AtomicU64>,
    fault: OnceLock<NodeError>,
}

/// How samples differ from the references.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Accuracy {
    /// They are the same.
    Exact,
    /// They are the same, rounded to f32 once.
    Rounded,
    /// They are blends of pixels.
    Blended,
}

/// A row for each channel; `None` for unwanted ones.
pub(crate) type Targets<'t, 'a> = &'t mut [Option<&'a mut [f32]>];

/// Buffers that one thread reuses from row to row.
#[derive(Default)]
struct RowBuffers {
    held: Option<(usize, Arc<Slot>)>,
    lines: Scratch<Scratch<f32>>,
}

impl Stream {
    pub(crate) fn new(stored: Stored, rows: Rows, recipe: Option<Box<dyn Recipe>>, outputs: usize, fit: Fit) -> Self {
        let judged = (0..stored.data.height()).map(|_| AtomicU64::new(0)).collect();
        Self { stored, rows, recipe, outputs, fit, outside: None, judged, fault: OnceLock::new() }
    }

    /// Fills a block with the samples of every wanted channel, row by row.
    pub(crate) fn fill(&self, block: &Block<'_>, outs: Targets<'_, '_>) -> Result<(), NodeError> {
        if outs.iter().all(Option::is_none) {
            return Ok(());
        }
        let mut scratch = RowBuffers::default();
        let filled = self.fit.lay(block, outs, |left, y, rows| self.line(&mut scratch, left, y, rows));
        filled.map_err(|error| self.first_fault(error))
    }

    /// Returns the channels at a position in the document, in pixels, in f64.
    pub(crate) fn reference(&self, at: [f64; 2]) -> Result<Vec<f64>, NodeError> {
        let mut scratch = RowBuffers::default();
        let mut texel = |x: i64, y: i64| {
            let mut texel = vec![[0.0_f32]; self.outputs];
            let mut rows: Vec<Option<&mut [f32]>> = texel.iter_mut().map(|value| Some(&mut value[..])).collect();
            self.line(&mut scratch, x, y, &mut rows).map_err(|error| self.first_fault(error))?;
            let exact = self.exact(&mut scratch, x, y)?;
            Ok(exact.unwrap_or_else(|| texel.into_iter().map(|[value]| f64::from(value)).collect()))
        };
        self.fit.blend(at, &mut texel)
    }

    /// Returns what the channels of the pixel nearest to (x, y) are rounded from; `None` if they are exact.
    fn exact(&self, scratch: &mut RowBuffers, x: i64, y: i64) -> Result<Option<Vec<f64>>, NodeError> {
        let Some(exact) = self.recipe.as_ref().and_then(|recipe| recipe.exact()) else { return Ok(None) };
        let data = self.stored.data;
        let (x, y) = (x.clamp(data.x0, data.x1 - 1), y.clamp(data.y0, data.y1 - 1));
        let mut stored = vec![[0.0_f32]; self.stored.names.len()];
        for (channel, sample) in stored.iter_mut().enumerate() {
            self.read(&mut scratch.held, channel, x, y, sample)?;
        }
        let lines: Vec<&[f32]> = stored.iter().map(|sample| &sample[..]).collect();
        Ok(Some(exact([x, y], &lines).into_iter().flatten().collect()))
    }

    /// Returns how samples differ from the references.
    pub(crate) fn accuracy(&self) -> Accuracy {
        match &self.recipe {
            _ if !self.fit.is_exact() => Accuracy::Blended,
            Some(recipe) if recipe.exact().is_some() => Accuracy::Rounded,
            _ => Accuracy::Exact,
        }
    }

    /// Returns the number of values repaired in the rows requested so far.
    pub(crate) fn repaired(&self) -> u64 {
        self.judged.iter().map(|judged| judged.load(Ordering::Relaxed).saturating_sub(1)).sum()
    }

    /// Returns the number of rows that are best requested together.
    pub(crate) fn rows_per_band(&self) -> Option<usize> {
        match &self.rows {
            Rows::File(file, _) if self.fit.is_pixel() => Some(file.rows_per_block()),
            _ => None,
        }
    }

    /// Returns the number of rows that are decoded together.
    pub(crate) fn rows_per_block(&self) -> usize {
        match &self.rows {
            Rows::File(file, _) => file.rows_per_block(),
            Rows::Memory(_) => 1,
        }
    }

    /// Returns the memory held, in bytes; for a shared file, this stream's share.
    pub(crate) fn bytes(&self) -> usize {
        let samples = match &self.rows {
            Rows::File(file, _) => file.bytes() / Arc::strong_count(file),
            Rows::Memory(planes) => planes.iter().map(|plane| size_of_val(plane.samples())).sum(),
        };
        samples + size_of_val(&self.judged[..])
    }

    /// Returns the file's data window in the document's pixels.
    pub(crate) fn window(&self) -> Window {
        self.fit.window(self.stored.data)
    }

    /// Passes each full row in a range to `f`, from the top down, with the channels of the output.
    pub(crate) fn each_row(
        &self,
        rows: std::ops::Range<usize>,
        mut f: impl FnMut(&[Vec<f32>]) -> Result<(), NodeError>,
    ) -> Result<(), NodeError> {
        let data = self.stored.data;
        let mut scratch = RowBuffers::default();
        let mut row = vec![vec![0.0; data.width()]; self.outputs];
        for y in rows.map(|row| data.y0 + row as i64) {
            let mut targets: Vec<Option<&mut [f32]>> = row.iter_mut().map(|row| Some(&mut row[..])).collect();
            self.texels(&mut scratch, data.x0, y, &mut targets).map_err(|error| self.first_fault(error))?;
            f(&row)?;
        }
        Ok(())
    }

    /// Reads the pixels from (`left`, `y`) on, inside or outside the data window.
    fn line(&self, scratch: &mut RowBuffers, left: i64, y: i64, outs: Targets<'_, '_>) -> Result<(), NodeError> {
        let Some(length) = outs.iter().flatten().map(|out| out.len()).next() else { return Ok(()) };
        let data = self.stored.data;
        let nearest = y.clamp(data.y0, data.y1 - 1);
        let within = |x: i64| (x - left).clamp(0, length as i64) as usize;
        let (first, last) = (within(data.x0), within(data.x1));
        if let Some(color) = self.outside
            && (nearest != y || first == last)
        {
            fill(outs, |channel, out| out.fill(color[channel]));
            return Ok(());
        }
        if first == last {
            // To the left or right of the picture: its last pixel on that side.
            let x = left.clamp(data.x0, data.x1 - 1);
            let mut texel = Scratch::of([0.0_f32], outs.len());
            let mut targets: Scratch<Option<&mut [f32]>> = texel.iter_mut().map(|value| Some(&mut value[..])).collect();
            self.texels(scratch, x, nearest, &mut targets)?;
            drop(targets);
            fill(outs, |channel, out| out.fill(texel[channel][0]));
            return Ok(());
        }
        let mut targets: Scratch<Option<&mut [f32]>> =
            outs.iter_mut().map(|out| out.as_deref_mut().map(|out| &mut out[first..last])).collect();
        self.texels(scratch, left + first as i64, nearest, &mut targets)?;
        drop(targets);
        let outside = self.outside;
        fill(outs, |channel, out| {
            let edge = |at: usize| outside.map_or(out[at], |color| color[channel]);
            let (before, after) = (edge(first), edge(last - 1));
            out[..first].fill(before);
            out[last..].fill(after);
        });
        Ok(())
    }

    /// Reads pixels of the data window.
    fn texels(&self, scratch: &mut RowBuffers, x0: i64, y: i64, outs: Targets<'_, '_>) -> Result<(), NodeError> {
        let data = self.stored.data;
        let length = outs.iter().flatten().map(|out| out.len()).next().unwrap_or_default();
        let judged = &self.judged[(y - data.y0) as usize];
        let whole = x0 == data.x0 && length == data.width();
        let known = judged.load(Ordering::Relaxed) > 0;
        let mut nothing: Scratch<Option<&mut [f32]>> = outs.iter().map(|_| None).collect();
        if !known && !whole {
            // A row is validated as a whole, so that results do not depend on which part of it is requested.
            let repaired = self.convert(scratch, data.x0, y, data.width(), true, &mut nothing)?;
            judged.store(1 + repaired, Ordering::Relaxed);
        }
        let repaired = self.convert(scratch, x0, y, length, !known, outs)?;
        if !known && whole {
            judged.store(1 + repaired, Ordering::Relaxed);
        }
        Ok(())
    }

    /// Reads, validates and converts a row of pixels, piece by piece; reads `all` channels or only the wanted ones.
    fn convert(
        &self,
        scratch: &mut RowBuffers,
        x0: i64,
        y: i64,
        length: usize,
        all: bool,
        outs: Targets<'_, '_>,
    ) -> Result<u64, NodeError> {
        let RowBuffers { held, lines } = scratch;
        let names = &self.stored.names;
        lines.resize_with(names.len().max(self.outputs), || Scratch::of(0.0, PIECE));
        let mut repaired = 0;
        for start in (0..length).step_by(PIECE) {
            let (x, count) = (x0 + start as i64, PIECE.min(length - start));
            let Some(recipe) = &self.recipe else {
                for (channel, line) in lines.iter_mut().enumerate() {
                    match outs.get_mut(channel).and_then(Option::as_deref_mut) {
                        Some(out) => repaired += self.read(held, channel, x, y, &mut out[start..start + count])?,
                        None if all => repaired += self.read(held, channel, x, y, &mut line[..count])?,
                        None => {}
                    }
                }
                continue;
            };
            for (channel, line) in lines.iter_mut().enumerate().take(names.len()) {
                repaired += self.read(held, channel, x, y, &mut line[..count])?;
            }
            let mut pieces: Scratch<&mut [f32]> = lines.iter_mut().map(|line| &mut line[..count]).collect();
            repaired += recipe.apply([x, y], &mut pieces)?;
            drop(pieces);
            fill(outs, |channel, out| out[start..start + count].copy_from_slice(&lines[channel][..count]));
        }
        Ok(repaired)
    }

    /// Reads and validates samples of one channel.
    fn read(
        &self,
        held: &mut Option<(usize, Arc<Slot>)>,
        channel: usize,
        x: i64,
        y: i64,
        out: &mut [f32],
    ) -> Result<u64, NodeError> {
        match &self.rows {
            Rows::File(file, places) => {
                let index = file.block_at(y);
                let slot = match held {
                    Some((known, slot)) if *known == index => slot,
                    held => &held.insert((index, file.block(index))).1,
                };
                slot.rows()?.row(places[channel], y, x, out);
            }
            Rows::Memory(planes) => {
                let start = (x - self.stored.data.x0) as usize;
                out.copy_from_slice(&planes[channel].row(y).unwrap_or_default()[start..start + out.len()]);
            }
        }
        let Stored { path, part, names, rule, repair, .. } = &self.stored;
        legalize(out, *rule, *repair).map_err(|at| {
            let place = (x + at as i64, y);
            illegal(path, *part, &names[channel], place, out[at], *rule)
        })
    }

    /// Returns the first error in the whole picture, so that the reported error does not depend on threads and tiles:
    /// undecodable rows come first, then the first illegal sample of each channel, then failed conversions.
    fn first_fault(&self, found: NodeError) -> NodeError {
        self.fault.get_or_init(|| self.scan().err().unwrap_or(found)).clone()
    }

    fn scan(&self) -> Result<(), NodeError> {
        let data = self.stored.data;
        let count = self.stored.names.len();
        let mut first: Vec<Option<NodeError>> = vec![None; count + 1];
        let mut held = None;
        let mut lines = vec![vec![0.0; PIECE]; count.max(self.outputs)];
        for y in data.y0..data.y1 {
            if let Rows::File(file, _) = &self.rows {
                file.block(file.block_at(y)).rows()?;
            }
            for start in (0..data.width()).step_by(PIECE) {
                let (x, length) = (data.x0 + start as i64, PIECE.min(data.width() - start));
                for channel in 0..count {
                    if let Err(error) = self.read(&mut held, channel, x, y, &mut lines[channel][..length]) {
                        first[channel].get_or_insert(error);
                    }
                }
                if let Some(recipe) = self.recipe.as_ref().filter(|_| first.iter().all(Option::is_none)) {
                    let mut pieces: Vec<&mut [f32]> = lines.iter_mut().map(|line| &mut line[..length]).collect();
                    first[count] = recipe.apply([x, y], &mut pieces).err();
                }
            }
        }
        first.into_iter().flatten().next().map_or(Ok(()), Err)
    }
}

/// Applies a function to every wanted row.
fn fill(outs: Targets<'_, '_>, mut f: impl FnMut(usize, &mut [f32])) {
    for (channel, out) in outs.iter_mut().enumerate() {
        if let Some(out) = out {
            f(channel, out);
        }
    }
}
