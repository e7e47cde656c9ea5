//! Partial storage of large pictures that are read row by row: only the pixels that the document's samples need.

use super::knobs::FitBy;
use super::layer::Fit;
use super::legal::{illegal, legalize};
use super::palette::ColorCollector;
use super::reading::{Reading, selected};
use super::{filled, limits};
use std::ops::ControlFlow;
use std::sync::Arc;
use trochoid_graph::{Choice, Kind, NodeError, Prepare};
use trochoid_image::{Format, Rgb, Window};
use trochoid_io::RowReader;

/// Margin around the document's picture that is kept for filters, in pixels; nodes that need more cause the whole
/// picture to be read.
const MARGIN: i64 = 256;

/// Marks a column or a row that is not kept.
const NONE: u32 = u32::MAX;

/// The columns or the rows of a picture that are kept.
#[derive(Debug)]
struct Axis {
    /// First column or row of the picture.
    first: i64,
    /// Index among the kept ones, for each column or row of the picture; `NONE` if not kept.
    places: Vec<u32>,
    /// The kept columns or rows, counted from the first.
    kept: Vec<usize>,
}

impl Axis {
    fn new(fit: &Fit, axis: usize, format: Format, first: i64, count: usize) -> Self {
        let side = i64::from(if axis == 0 { format.width() } else { format.height() });
        let mut places = vec![NONE; count];
        let mut offsets: Vec<f64> = (0..format.samples()).map(|sample| format.sample_offset(sample)[axis]).collect();
        // Fields are sampled at the pixel center.
        offsets.push(0.5);
        for at in -MARGIN..side + MARGIN {
            for offset in &offsets {
                for pixel in fit.neighbors(axis, at as f64 + offset) {
                    places[(pixel - first).clamp(0, count as i64 - 1) as usize] = 0;
                }
            }
        }
        let kept: Vec<usize> = (0..count).filter(|at| places[*at] != NONE).collect();
        kept.iter().enumerate().for_each(|(place, at)| places[*at] = place as u32);
        Self { first, places, kept }
    }

    /// Returns the index of the column or row nearest to `at` within the picture; `None` if not kept.
    fn place(&self, at: i64) -> Option<usize> {
        let place = self.places[(at - self.first).clamp(0, self.places.len() as i64 - 1) as usize];
        (place != NONE).then_some(place as usize)
    }
}

/// The pixels of a picture that are kept.
#[derive(Debug)]
pub(crate) struct Grid {
    across: Axis,
    down: Axis,
    data: Window,
}

impl Grid {
    pub(super) fn new(fit: &Fit, format: Format, data: Window) -> Self {
        let across = Axis::new(fit, 0, format, data.x0, data.width());
        let down = Axis::new(fit, 1, format, data.y0, data.height());
        Self { across, down, data }
    }

    /// Returns the number of kept pixels.
    pub(super) fn count(&self) -> usize {
        self.across.kept.len() * self.down.kept.len()
    }

    /// Returns the picture's data window.
    pub(crate) fn data(&self) -> Window {
        self.data
    }

    /// Returns the index, row by row, of the picture's pixel nearest to (x, y); `None` if not kept.
    pub(crate) fn place(&self, x: i64, y: i64) -> Option<usize> {
        Some(self.down.place(y)? * self.across.kept.len() + self.across.place(x)?)
    }

    pub(crate) fn has_column(&self, x: i64) -> bool {
        self.across.place(x).is_some()
    }

    pub(crate) fn has_row(&self, y: i64) -> bool {
        self.down.place(y).is_some()
    }
}

/// A channel of an output on a grid.
pub(crate) struct KeptPlane {
    pub(crate) channel: usize,
    pub(crate) samples: Vec<f32>,
    /// What the samples are rounded from; `None` if they are exact.
    pub(crate) exact: Option<Vec<f64>>,
}

/// The kept part of a picture.
pub(crate) struct PartialPicture {
    pub(crate) grid: Arc<Grid>,
    pub(crate) fit: Fit,
    /// The output's wanted channels.
    pub(crate) planes: Vec<KeptPlane>,
    /// All colors of the picture, or the vertices of their hull.
    pub(crate) controls: Vec<Rgb>,
    pub(crate) repaired: u64,
}

impl Reading<'_> {
    /// Returns the pixels of a picture other than EXR that the document's samples need; `None` if they are most of the
    /// picture, or if the whole takes no more than `budget` bytes. Every pixel is still validated, and every color is
    /// a control color.
    ///
    /// # Errors
    /// The file cannot be read, or its values are not legal.
    pub(crate) fn kept(
        &self,
        prepare: &Prepare<'_>,
        kind: Kind,
        wanted: &[bool],
        budget: u64,
    ) -> Result<Option<PartialPicture>, NodeError> {
        let io = |error: trochoid_io::Error| selected(error, None);
        let premultiplied = kind == Kind::Color && self.knobs.taken.premultiplied;
        if !wanted.contains(&true) || premultiplied || trochoid_io::kind(self.path).map_err(io)?.is_exr() {
            return Ok(None);
        }
        let channels = self.wanted_channels(kind, wanted);
        let named = channels.len();
        let mut reader = RowReader::open(self.path, &self.selection(channels), &limits(self.frame)).map_err(io)?;
        let info = reader.info().clone();
        filled(self.path, info.part, info.data)?;
        let made = self.channel_plan(kind, &info, named, wanted)?;
        let bytes = |pixels: usize| (size_of::<f32>() * made.targets.len()) as u64 * pixels as u64;
        if bytes(info.data.area()) <= budget {
            return Ok(None);
        }
        let fit = Fit::new(
            self.knobs.fit,
            FitBy::WORDS,
            info.display,
            [self.frame.format, self.frame.document_format],
            self.path,
        )?;
        let grid = Grid::new(&fit, self.frame.format, info.data);
        if 2 * grid.count() > info.data.area() {
            return Ok(None);
        }
        if bytes(grid.count()) > self.frame.memory_limit {
            let found = format!("{} bytes of samples", bytes(grid.count()));
            return Err(self.fault(info.part, found, &format!("at most {}", self.frame.memory_limit)));
        }
        let exact = made.recipe.as_ref().and_then(|recipe| recipe.exact());
        let plane = |channel: &usize| KeptPlane {
            channel: *channel,
            samples: Vec::with_capacity(grid.count()),
            exact: exact.as_ref().map(|_| Vec::with_capacity(grid.count())),
        };
        let mut planes: Vec<KeptPlane> = made.targets.iter().map(plane).collect();
        let mut colors = (kind == Kind::Color).then(ColorCollector::default);
        let mut lines = vec![vec![0.0; info.data.width()]; made.at.len().max(planes.len())];
        let (mut repaired, mut fault) = (0, None);
        let cancelled = prepare.cancellation();
        let mut row = |y: i64, stored: &[Vec<f32>]| -> Result<(), NodeError> {
            if cancelled() {
                return Err(NodeError::Cancelled);
            }
            let y = info.data.y0 + y;
            for (line, at) in lines.iter_mut().zip(&made.at) {
                line.copy_from_slice(&stored[*at]);
                repaired += legalize(line, made.rule, self.repair()).map_err(|x| {
                    let place = (info.data.x0 + x as i64, y);
                    illegal(self.path, info.part, &info.channels[*at].full_name, place, line[x], made.rule)
                })?;
            }
            if let Some(recipe) = &made.recipe {
                if let Some(exact) = exact.as_ref().filter(|_| grid.has_row(y)) {
                    let stored: Vec<&[f32]> = lines[..made.at.len()].iter().map(|line| &line[..]).collect();
                    for (plane, line) in planes.iter_mut().zip(exact([info.data.x0, y], &stored)) {
                        if let Some(exact) = &mut plane.exact {
                            exact.extend(grid.across.kept.iter().map(|x| line[*x]));
                        }
                    }
                }
                let mut pieces: Vec<&mut [f32]> = lines.iter_mut().map(|line| &mut line[..]).collect();
                repaired += recipe.apply([info.data.x0, y], &mut pieces)?;
            }
            if let (Some(colors), [r, g, b]) = (&mut colors, &lines[..]) {
                colors.add_row(r, g, b);
            }
            if grid.has_row(y) {
                for (plane, line) in planes.iter_mut().zip(&lines) {
                    plane.samples.extend(grid.across.kept.iter().map(|x| line[*x]));
                }
            }
            Ok(())
        };
        let decoded = reader.rows(&mut |y, stored| match row(y, stored) {
            Ok(()) => ControlFlow::Continue(()),
            Err(error) => {
                fault = Some(error);
                ControlFlow::Break(())
            }
        });
        if let Some(fault) = fault {
            return Err(fault);
        }
        decoded.map_err(io)?;
        let mut controls = colors.map(ColorCollector::finish).unwrap_or_default();
        controls.extend(self.outside.filter(|_| kind == Kind::Color));
        Ok(Some(PartialPicture { grid: Arc::new(grid), fit, planes, controls, repaired }))
    }
}
