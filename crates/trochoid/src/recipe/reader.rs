//! Recipes that are read strip by strip, so that memory does not grow with the picture.

use super::header::RecipeError;
use super::info::{RecipeInfo, Rounding};
use std::path::{Path, PathBuf};
use trochoid_engine::{StoredSample, paint};
use trochoid_image::Window;
use trochoid_io::{BandBuffer, ExrReader, Limits, SampleType, Selection, read_metadata};

/// Recipe opened for painting, some rows at a time, by any number of threads.
#[derive(Debug)]
pub struct RecipeReader {
    path: PathBuf,
    info: RecipeInfo,
    rounding: Rounding,
    file: ExrReader,
    /// Whether all channels are halves, which are mixed without being converted first.
    is_half: bool,
}

/// Reusable memory of a thread that paints.
#[derive(Debug, Default)]
pub struct RecipeScratch {
    band: BandBuffer,
    rows: Vec<Vec<f32>>,
}

impl RecipeReader {
    /// Opens a recipe, and reads its header, but no pixels.
    ///
    /// # Errors
    /// The file cannot be read, or has other metadata or channels.
    pub fn open(path: &Path) -> Result<Self, RecipeError> {
        let (info, rounding) = RecipeInfo::read(path, &read_metadata(path)?)?;
        let file = ExrReader::open(path, &Selection::channels(info.channels()), &Limits::default())?;
        let is_half = file.info().channels.iter().all(|channel| channel.sample_type == SampleType::Half);
        Ok(Self { path: path.into(), info, rounding, file, is_half })
    }

    /// Returns the description of the recipe.
    pub fn info(&self) -> &RecipeInfo {
        &self.info
    }

    /// Returns what storing the recipe rounded.
    pub fn rounding(&self) -> Rounding {
        self.rounding
    }

    /// Returns the pixels of the picture.
    pub fn window(&self) -> Window {
        self.file.info().data
    }

    /// Returns the frame that viewers show.
    pub fn display(&self) -> Window {
        self.file.info().display
    }

    /// Paints full rows of the picture in other colors, one for each name, in the working space. Best called for whole
    /// strips of 16 rows, as files store them.
    ///
    /// # Errors
    /// The file is damaged, or its weights are not ≥ 0 with the sum 1.
    ///
    /// # Panics
    /// The rows are not those of the picture, `out` has another size, or there are not as many colors as names.
    pub fn paint(
        &self,
        rows: Window,
        colors: &[[f64; 3]],
        scratch: &mut RecipeScratch,
        out: &mut [Vec<f32>; 3],
    ) -> Result<(), RecipeError> {
        assert_eq!(colors.len(), self.info.names.len(), "a color for each name");
        let colors = self.info.factors(colors);
        let width = rows.width();
        let mut y = rows.y0;
        while y < rows.y1 {
            let band = self.file.band_at(y).unwrap_or_default();
            self.file.decode(band, &mut scratch.band)?;
            let end = scratch.band.window().y1.min(rows.y1);
            while y < end {
                let pixels = (y - rows.y0) as usize * width..(y - rows.y0 + 1) as usize * width;
                let row = out.each_mut().map(|channel| &mut channel[pixels.clone()]);
                let painted = self.row(y, &colors, scratch, row);
                let at = Window::new(rows.x0, y, rows.x1, y + 1);
                painted.map_err(|pixel| RecipeError::weights(&self.path, at, pixel))?;
                y += 1;
            }
        }
        Ok(())
    }

    /// Paints one row of the band that was decoded.
    fn row(&self, y: i64, colors: &[[f64; 3]], scratch: &mut RecipeScratch, out: [&mut [f32]; 3]) -> Result<(), usize> {
        let channels = self.file.info().channels.len();
        if self.is_half {
            let rows: Vec<&[u16]> = (0..channels).filter_map(|channel| scratch.band.row_bits(channel, y)).collect();
            return self.mixed(&rows, colors, out);
        }
        scratch.rows.resize(channels, Vec::new());
        for (channel, row) in scratch.rows.iter_mut().enumerate() {
            row.resize(out[0].len(), 0.0);
            scratch.band.row_f32(channel, y, self.window().x0, row);
        }
        let rows: Vec<&[f32]> = scratch.rows.iter().map(Vec::as_slice).collect();
        self.mixed(&rows, colors, out)
    }

    fn mixed<S: StoredSample>(&self, rows: &[&[S]], colors: &[[f64; 3]], out: [&mut [f32]; 3]) -> Result<(), usize> {
        let (weights, images) = rows.split_at(self.info.weights());
        paint(weights, colors, images.try_into().ok(), out)
    }
}
