//! Drawing of a sheet: a grid of pictures with captions.

use crate::failure::Failure;
use crate::shown;
use plotters::prelude::*;
use plotters::style::{FontStyle, register_font};
use std::error::Error;

const FONT: &str = "labels";
/// Neutral and dark, so that the pictures decide.
const PAPER: RGBColor = RGBColor(38, 38, 40);
const INK: RGBColor = RGBColor(226, 226, 226);
/// Font sizes and heights of lines of text, in pixels.
const CAPTION: (u32, u32) = (16, 20);
const TITLE: (u32, u32) = (20, 32);
/// Pixels of text, along each axis, that become one.
const FINE: u32 = 3;
/// Space around pictures, in pixels.
const MARGIN: u32 = 12;
/// Width over height that a sheet should have.
const ASPECT: f64 = 16.0 / 9.0;
/// Most pixels of a sheet.
const MOST: u64 = 1 << 28;

/// The places of pictures.
pub(super) struct Layout {
    /// Width and height of each picture.
    sizes: Vec<[u32; 2]>,
    /// Largest width and height.
    cell: [u32; 2],
    columns: usize,
    /// Lines of a caption.
    lines: usize,
}

impl Layout {
    pub(super) fn new(sizes: Vec<[u32; 2]>, cell: [u32; 2], columns: usize, lines: usize) -> Self {
        Self { sizes, cell, columns: columns.max(1), lines }
    }

    /// Returns the number of columns with which a sheet has about the shape of a screen.
    pub(super) fn columns(count: usize, [width, height]: [u32; 2]) -> usize {
        let (width, height) = (f64::from(width + MARGIN), f64::from(height + MARGIN + CAPTION.1));
        let off = |columns: usize| {
            let aspect = width * columns as f64 / (height * count.div_ceil(columns) as f64);
            // Rows that are not full count, too.
            let empty = (columns - 1 - (count - 1) % columns) as f64 / count as f64;
            (aspect / ASPECT).ln().abs() + empty
        };
        (1..=count.max(1)).min_by(|a, b| off(*a).total_cmp(&off(*b))).unwrap_or(1)
    }

    /// Returns width and height of the sheet.
    pub(super) fn size(&self) -> [u32; 2] {
        let rows = self.sizes.len().div_ceil(self.columns) as u32;
        let width = MARGIN + self.columns as u32 * (self.cell[0] + MARGIN);
        [width, TITLE.1 + MARGIN + rows * self.row()]
    }

    /// Returns the height of a row.
    fn row(&self) -> u32 {
        self.cell[1] + MARGIN / 2 + self.lines as u32 * CAPTION.1 + MARGIN
    }

    /// Returns the failure of a sheet that is too large.
    pub(super) fn refused(&self) -> Option<Failure> {
        let rows = self.sizes.len().div_ceil(self.columns) as u64;
        let width = u64::from(MARGIN) + self.columns as u64 * u64::from(self.cell[0] + MARGIN);
        let height = rows * u64::from(self.row());
        (width * height > MOST).then(|| {
            let message = format!("found a sheet of {width} × {height} pixels; expected at most {MOST} pixels");
            Failure::usage(message, "show fewer pictures, or smaller ones: --width")
        })
    }

    /// Returns the upper left corner of a picture's cell.
    fn corner(&self, index: usize) -> [u32; 2] {
        let (column, row) = ((index % self.columns) as u32, (index / self.columns) as u32);
        [MARGIN + column * (self.cell[0] + MARGIN), TITLE.1 + MARGIN + row * self.row()]
    }
}

/// A sheet.
pub(super) struct Sheet {
    pub(super) title: String,
    /// Lines below each picture.
    pub(super) captions: Vec<Vec<String>>,
    /// Red, green and blue of each picture, for display.
    pub(super) pictures: Vec<[Vec<f32>; 3]>,
    pub(super) layout: Layout,
}

impl Sheet {
    /// Draws the sheet; returns interleaved R, G and B.
    ///
    /// # Errors
    /// The font cannot be used.
    pub(super) fn draw(&self) -> Result<Vec<u8>, Box<dyn Error>> {
        // The font is part of the program, so that every machine draws the same captions.
        register_font(FONT, FontStyle::Normal, dejavu::sans::regular()).map_err(|_| "the font cannot be read")?;
        let [width, height] = self.layout.size();
        let paper = [PAPER.0, PAPER.1, PAPER.2];
        let mut pixels = paper.repeat(width as usize * height as usize);
        let mut write = |text: &str, at: [u32; 2], most: u32, (size, line): (u32, u32)| -> Result<(), Box<dyn Error>> {
            copy(&text_of(text, [most, line], size)?, most as usize, &mut pixels, width as usize, at);
            Ok(())
        };
        write(&self.title, [MARGIN, MARGIN / 2], width - 2 * MARGIN, TITLE)?;
        for (index, lines) in self.captions.iter().enumerate() {
            let [x, y] = self.layout.corner(index);
            let below = y + self.layout.sizes[index][1] + MARGIN / 2;
            for (line, text) in lines.iter().enumerate() {
                write(text, [x, below + line as u32 * CAPTION.1], self.layout.cell[0], CAPTION)?;
            }
        }
        for (index, picture) in self.pictures.iter().enumerate() {
            let ([width, _], at) = (self.layout.sizes[index], self.layout.corner(index));
            copy(&shown::bytes(picture), width as usize, &mut pixels, self.layout.size()[0] as usize, at);
        }
        Ok(pixels)
    }
}

/// Copies rows of pixels of this width to a place in a wider picture.
fn copy(from: &[u8], width: usize, pixels: &mut [u8], whole: usize, [x, y]: [u32; 2]) {
    for (row, samples) in from.chunks_exact(3 * width.max(1)).enumerate() {
        let start = 3 * ((y as usize + row) * whole + x as usize);
        pixels[start..start + samples.len()].copy_from_slice(samples);
    }
}

/// Draws a line of text, shortened in its middle if it is too wide; returns interleaved R, G and B.
///
/// Letters stand at whole pixels, which would make their distances uneven, so the text is drawn larger and averaged.
fn text_of(text: &str, [width, height]: [u32; 2], size: u32) -> Result<Vec<u8>, Box<dyn Error>> {
    let large = [width * FINE, height * FINE];
    let mut pixels = vec![0; (large[0] * large[1]) as usize * 3];
    {
        let area = BitMapBackend::with_buffer(&mut pixels, (large[0], large[1])).into_drawing_area();
        area.fill(&PAPER)?;
        let style = (FONT, size * FINE).into_font().color(&INK);
        let letters: Vec<char> = text.chars().collect();
        let (mut shown, mut kept) = (text.to_owned(), letters.len());
        while kept > 2 && area.estimate_text_size(&shown, &style)?.0 > large[0] {
            kept -= 1;
            let (head, tail) = (kept.div_ceil(2), kept / 2);
            shown = letters[..head].iter().chain(['…'].iter()).chain(&letters[letters.len() - tail..]).collect();
        }
        // The baseline is drawn half a size below the place; letters reach from 0.8 sizes above it to 0.2 below it.
        let top = (large[1] / 2) as i32 - (size * FINE / 5) as i32;
        area.draw(&Text::new(shown, (0, top), style))?;
        area.present()?;
    }
    let fine = FINE as usize;
    let mean = |x: usize, y: usize, channel: usize| {
        let row = |row: usize| 3 * ((y * fine + row) * large[0] as usize + x * fine) + channel;
        let samples = (0..fine).flat_map(|r| (0..fine).map(move |column| row(r) + 3 * column));
        (samples.map(|index| u32::from(pixels[index])).sum::<u32>() / (FINE * FINE)) as u8
    };
    let places = (0..height as usize).flat_map(|y| (0..width as usize).map(move |x| (x, y)));
    Ok(places.flat_map(|(x, y)| [mean(x, y, 0), mean(x, y, 1), mean(x, y, 2)]).collect())
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_sheet_has_the_shape_of_a_screen() {
        let columns = |count| Layout::columns(count, [320, 180]);
        assert_eq!([1, 2, 3, 8, 12].map(columns), [1, 2, 2, 3, 4]);
    }

    #[test]
    fn letters_are_whole_and_long_texts_are_shortened() {
        register_font(FONT, FontStyle::Normal, dejavu::sans::regular()).ok().unwrap();
        for (size, line) in [CAPTION, TITLE] {
            for text in ["Ålfg|_{", "storm.json, a name that is longer than the picture above it"] {
                let pixels = text_of(text, [160, line], size).unwrap();
                let rows: Vec<&[u8]> = pixels.chunks_exact(3 * 160).collect();
                let has_ink = |row: &&[u8]| row.iter().any(|sample| *sample > 150);
                assert!(rows.iter().filter(|row| has_ink(row)).count() >= size as usize / 2, "{text}");
                assert!(!has_ink(&rows[0]) && !has_ink(&rows[line as usize - 1]), "{text} is cut at {size}");
                let edge = |row: &&[u8]| row[3 * 159..].iter().any(|sample| *sample > 150);
                assert!(!rows.iter().any(edge), "{text} is cut at its end");
            }
        }
    }

    #[test]
    fn pictures_stand_in_their_places() {
        let layout = Layout::new(vec![[4, 2], [4, 1], [2, 2]], [4, 2], 2, 1);
        let [width, height] = layout.size();
        let picture = |value: f32, count: usize| [0; 3].map(|_| vec![value; count]);
        let sheet = Sheet {
            title: String::new(),
            captions: vec![Vec::new(); 3],
            pictures: vec![picture(1.0, 8), picture(0.0, 4), picture(0.5, 4)],
            layout,
        };
        let pixels = sheet.draw().unwrap();
        assert_eq!(pixels.len(), (width * height * 3) as usize);
        let at = |x: u32, y: u32| pixels[((y * width + x) * 3) as usize];
        let [[a, b], [c, d], [e, f]] = [0, 1, 2].map(|index| sheet.layout.corner(index));
        assert_eq!([at(a, b), at(a + 3, b + 1), at(a + 4, b)], [255, 255, PAPER.0]);
        assert_eq!([at(c + 3, d), at(c + 3, d + 1), at(c - 1, d)], [0, PAPER.0, PAPER.0]);
        assert_eq!([at(e + 1, f + 1), at(e + 2, f + 1)], [128, PAPER.0]);
        assert!(b == d && a == e && c > a && f > b + 2);
    }
}
