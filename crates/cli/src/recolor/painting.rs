//! A recipe as a picture in given colors: painted and judged strip by strip, on all threads.

use crate::failure::{FAILED, Failure};
use crate::files::OverwriteOptions;
use crate::interrupt;
use crate::progress::Progress;
use crate::remedies;
use rayon::prelude::*;
use std::path::Path;
use std::sync::atomic::{AtomicUsize, Ordering};
use trochoid::io::{EncodeScratch, ExrHeader, ExrWriter, PngImage, SampleType, Samples, write_png8, write_png16};
use trochoid::{Form, Hull, Monitor as _, Plane, RecipeReader, RecipeScratch, Window, WorkingSpace, marks};

/// Rows that are painted at once, as many as EXR compresses together.
const ROWS: usize = 16;

/// A recipe, and the colors in which it is painted.
pub(super) struct Painting<'a> {
    pub(super) recipe: &'a RecipeReader,
    pub(super) colors: &'a [[f64; 3]],
    /// Whether PNG has 16 bits a channel.
    pub(super) is_deep: bool,
    /// Whether EXR has 32-bit floats.
    pub(super) is_float: bool,
}

/// What was found on a painted picture.
pub(super) struct Written {
    /// Pixels outside of the hull of the colors; `None` if images contribute, of whose hull a recipe knows nothing.
    pub(super) outside: Option<u64>,
    /// Largest difference of a channel, in the working space, from a render in the same colors.
    pub(super) bound: f64,
}

/// Memory of a thread.
#[derive(Default)]
struct Scratch {
    recipe: RecipeScratch,
    painted: [Vec<f32>; 3],
    encode: EncodeScratch,
}

impl Painting<'_> {
    /// Paints the picture into a file: EXR as linear light, PNG as displayed.
    pub(super) fn write(&self, out: &Path, over: OverwriteOptions, progress: &Progress) -> Result<Written, Failure> {
        let form = Form::of_picture(out);
        let failed = |error: trochoid::io::Error| Failure::new(FAILED, remedies::written(&error));
        let (space, window) = (self.recipe.info().space, self.recipe.window());
        let target = over.target(out, form);
        let outside = if form == Form::Png {
            let mut planes = Vec::new();
            for channel in 0..3 {
                let bytes = 4 * window.area();
                let none =
                    |_| Failure::new(FAILED, format!("{}: found no memory for {bytes} bytes of pixels", out.display()));
                planes.push(Plane::zeroed(window, channel).map_err(none)?);
            }
            let strips = planes.iter_mut().map(|plane| plane.samples_mut().chunks_mut(ROWS * window.width()));
            let strips: Vec<Vec<&mut [f32]>> = transposed(strips.map(Iterator::collect).collect());
            let outside = self.strips(strips, progress, |_, _, painted, strip, _| {
                let shown = |color| space.to_display(color);
                let converted = converted(painted, shown);
                strip.iter_mut().zip(converted).for_each(|(to, from)| to.copy_from_slice(&from));
                Ok(())
            })?;
            let channels = planes.iter().map(Samples::plane).collect::<Vec<_>>();
            let image = PngImage::new(window.width() as u32, window.height() as u32, channels);
            let image = PngImage { clamp: true, metadata: marks(form), ..image };
            let written = if self.is_deep { write_png16(target, &image) } else { write_png8(target, &image) };
            written.map_err(failed)?;
            outside
        } else {
            let stored = if self.is_float { SampleType::Float } else { SampleType::Half };
            let header = ExrHeader {
                display: self.recipe.display(),
                channels: ["R", "G", "B"].map(|name| (name.into(), stored)).into(),
                metadata: marks(form),
                chromaticities: Some(space.chromaticities()),
                ..ExrHeader::new(window)
            };
            let writer = ExrWriter::create(target, &header).map_err(failed)?;
            let strips = vec![(); window.height().div_ceil(ROWS)];
            let outside = self.strips(strips, progress, |strip, _, painted, _, encode| {
                let linear =
                    (space == WorkingSpace::Srgb).then(|| converted(painted, |color| space.to_linear_srgb(color)));
                let channels = linear.as_ref().unwrap_or(painted).each_ref().map(Vec::as_slice);
                writer.push(writer.encode(strip, &channels, encode).map_err(failed)?).map_err(failed)
            })?;
            writer.finish(&[]).map_err(failed)?;
            outside
        };
        let outside = (!self.recipe.info().has_images).then_some(outside);
        Ok(Written { outside, bound: self.bound() })
    }

    /// Bounds the difference from a render: what storing rounded, and what mixing in f32 does.
    fn bound(&self) -> f64 {
        let ranges = (0..3).map(|channel| {
            let values = self.colors.iter().map(|color| color[channel]);
            let (least, most) = values.fold((f64::INFINITY, 0.0_f64), |(least, most), v| (least.min(v), most.max(v)));
            // What images contribute is beside the colors.
            let least = if self.recipe.info().has_images { 0.0 } else { least.min(most) };
            self.recipe.rounding().bound(most - least) + 4.0 * f64::from(f32::EPSILON) * most
        });
        ranges.fold(0.0, f64::max)
    }

    /// Paints and judges all strips, of which `take` gets the index, the pixels, and what was passed for it.
    fn strips<T: Send>(
        &self,
        strips: Vec<T>,
        progress: &Progress,
        take: impl Fn(usize, Window, &[Vec<f32>; 3], &mut T, &mut EncodeScratch) -> Result<(), Failure> + Sync,
    ) -> Result<u64, Failure> {
        let window = self.recipe.window();
        let points: Vec<[f32; 3]> = self.colors.iter().map(|color| color.map(|channel| channel as f32)).collect();
        let hull = Hull::new(&points);
        // One mix, and one level for the rounding of the colors.
        let margin = hull.margin(2);
        let (total, done) = (strips.len(), AtomicUsize::new(0));
        let paint = |scratch: &mut Scratch, (index, mut strip): (usize, T)| {
            if interrupt::asked() {
                return Err(Failure::interrupted());
            }
            let y0 = window.y0 + (index * ROWS) as i64;
            let rows = Window { y0, y1: (y0 + ROWS as i64).min(window.y1), ..window };
            scratch.painted.iter_mut().for_each(|channel| channel.resize(rows.area(), 0.0));
            self.recipe
                .paint(rows, self.colors, &mut scratch.recipe, &mut scratch.painted)
                .map_err(|error| remedies::recipe(&error))?;
            let [r, g, b] = scratch.painted.each_ref().map(Vec::as_slice);
            let outside = if self.recipe.info().has_images { 0 } else { hull.exits(r, g, b, margin).0 };
            take(index, rows, &scratch.painted, &mut strip, &mut scratch.encode)?;
            progress.progress(done.fetch_add(1, Ordering::Relaxed) + 1, total);
            Ok(outside)
        };
        strips.into_par_iter().enumerate().map_init(Scratch::default, paint).try_reduce(|| 0, |a, b| Ok(a + b))
    }
}

/// Converts the pixels of a strip in f64.
fn converted([r, g, b]: &[Vec<f32>; 3], f: impl Fn([f64; 3]) -> [f64; 3]) -> [Vec<f32>; 3] {
    let mut out = [(); 3].map(|()| Vec::with_capacity(r.len()));
    let mut last = ([f32::NAN; 3], [0.0; 3]);
    for ((r, g), b) in r.iter().zip(g).zip(b) {
        let color = [*r, *g, *b];
        // Flat areas are converted once.
        if color != last.0 {
            last = (color, f(color.map(f64::from)));
        }
        out.iter_mut().zip(last.1).for_each(|(channel, value)| channel.push(value as f32));
    }
    out
}

/// Turns strips by channel into channels by strip.
fn transposed(channels: Vec<Vec<&mut [f32]>>) -> Vec<Vec<&mut [f32]>> {
    let mut strips: Vec<Vec<&mut [f32]>> = Vec::new();
    for channel in channels {
        strips.resize_with(channel.len(), Vec::new);
        strips.iter_mut().zip(channel).for_each(|(strip, part)| strip.push(part));
    }
    strips
}
