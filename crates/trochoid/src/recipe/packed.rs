//! Recipes in memory, packed so that pictures are painted in other colors while one looks.

use super::info::{RecipeInfo, Rounding};
use super::rows::RecipeRows;
use super::tiles::{SIDES, Tile};
use std::sync::atomic::{AtomicUsize, Ordering};
use std::sync::{Arc, Mutex, OnceLock, PoisonError};
use trochoid_engine::{Buffers, Cache, EvalError, Monitor, Plan, PlanError, Settings, Sink, StoredSample, Storing};
use trochoid_graph::{CheckedGraph, Diagnostic};
use trochoid_image::{Window, WorkingSpace};

/// The weights of a picture over its colors, in tiles that hold only the colors that they have.
///
/// ```
/// use trochoid::{Cache, PackedRecipe, Silent};
///
/// let text = r##"{ "trochoid": 1, "format": { "width": 3, "height": 1 }, "working_space": "srgb",
///                  "palette": { "ink": "#000000", "paper": "#ffffff" },
///                  "nodes": { "across": { "type": "ScreenX" },
///                             "mix": { "type": "Mix", "a": "palette.ink", "b": "palette.paper", "weight": "across" } },
///                  "outputs": { "beauty": { "color": "mix" } } }"##;
/// let graph = trochoid::parse("a.json", text, std::path::Path::new("."), &[])?.graph;
/// let recipe = PackedRecipe::evaluate(&graph, 0, 1, None, 1 << 20, &mut Cache::new(), &Silent)?;
/// assert_eq!((&recipe.info().names[..], recipe.shares()), (&["ink".into(), "paper".into()][..], &[0.5, 0.5][..]));
/// recipe.paint(0, &[[0.0; 3], [1.0, 0.5, 0.0]], |_, [red, green, _]| {
///     assert_eq!((red, green), (&[0.0, 0.5, 1.0][..], &[0.0, 0.25, 0.5][..]));
/// });
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
#[derive(Debug)]
pub struct PackedRecipe {
    info: RecipeInfo,
    rounding: Rounding,
    window: Window,
    strips: Strips,
    shares: Vec<f64>,
    bytes: usize,
}

/// Reason that a recipe is not evaluated.
#[derive(Debug, thiserror::Error)]
pub enum PackError {
    /// The picture is no function of its colors in a way that a recipe can hold.
    #[error("{}", .0.iter().map(Diagnostic::to_string).collect::<Vec<_>>().join("\n"))]
    Refused(Vec<Diagnostic>),
    /// There is no such picture.
    #[error(transparent)]
    Plan(#[from] PlanError),
    /// The recipe would take too much memory.
    #[error(transparent)]
    Large(#[from] TooLarge),
    /// The picture cannot be evaluated.
    #[error(transparent)]
    Evaluate(EvalError),
}

/// A recipe that would take too much memory.
#[derive(Clone, Debug, thiserror::Error)]
#[error("found a recipe of more than {} MB; expected at most that, so make the picture smaller, or give its colors fewer names", .limit >> 20)]
pub struct TooLarge {
    /// Most bytes that it may take.
    pub limit: usize,
}

/// Strips of tiles from the top to the bottom, each from left to right.
type TileRows<S> = Vec<Vec<Tile<S>>>;

/// Strips of tiles, whose weights are halves or floats.
#[derive(Debug)]
enum Strips {
    Half(TileRows<u16>),
    Float(TileRows<f32>),
}

impl PackedRecipe {
    /// Evaluates the recipe of a color output of a graph at a frame, of the whole picture or of a region. `limit` bounds
    /// the bytes that it may take.
    ///
    /// # Errors
    /// The picture has no recipe, cannot be evaluated, or has one that is too large.
    pub fn evaluate(
        graph: &CheckedGraph,
        output: usize,
        frame: i64,
        region: Option<Window>,
        limit: usize,
        cache: &mut Cache,
        monitor: &dyn Monitor,
    ) -> Result<Self, PackError> {
        // In linear light, steps of a half's weights would be seen in darks.
        match graph.space() {
            WorkingSpace::Srgb => {
                let (recipe, strips) =
                    Self::packed(graph, output, frame, region, Storing::Half, limit, cache, monitor)?;
                Ok(Self { strips: Strips::Half(strips), ..recipe })
            }
            _ => {
                let (recipe, strips) =
                    Self::packed(graph, output, frame, region, Storing::Float, limit, cache, monitor)?;
                Ok(Self { strips: Strips::Float(strips), ..recipe })
            }
        }
    }

    /// Evaluates the recipe, and returns its strips beside it.
    #[expect(clippy::too_many_arguments, reason = "those of `evaluate`, and how weights are stored")]
    fn packed<S: StoredSample + Send>(
        graph: &CheckedGraph,
        output: usize,
        frame: i64,
        region: Option<Window>,
        storing: Storing,
        limit: usize,
        cache: &mut Cache,
        monitor: &dyn Monitor,
    ) -> Result<(Self, TileRows<S>), PackError> {
        let (graph, output, info) = RecipeInfo::added(graph, output, frame, storing).map_err(PackError::Refused)?;
        let mut settings = Settings::default();
        settings.region = region;
        let name = graph.outputs()[output].name.as_str();
        let plan = Plan::new(&graph, &[name], frame, &[], &settings)?;
        let packer = Packer::<S>::new(info, plan.window(), limit);
        plan.evaluate_to(&packer, &Buffers::new(), cache, monitor).map_err(|error| match &error {
            EvalError::Sink(foreign) => match foreign.downcast_ref::<TooLarge>() {
                Some(large) => PackError::Large(large.clone()),
                None => PackError::Evaluate(error),
            },
            _ => PackError::Evaluate(error),
        })?;
        Ok(packer.finished())
    }

    /// Describes the recipe that an output of a graph has at a frame, without evaluating it. If it has the names of another
    /// one of the same picture, only the colors can differ.
    ///
    /// # Errors
    /// The picture has no recipe.
    pub fn describe(graph: &CheckedGraph, output: usize, frame: i64) -> Result<RecipeInfo, PackError> {
        let added = RecipeInfo::added(graph, output, frame, Storing::Half);
        added.map(|(_, _, info)| info).map_err(PackError::Refused)
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
        self.window
    }

    /// Returns the mean weight of each color; if images contribute, that of all of them is the last.
    pub fn shares(&self) -> &[f64] {
        &self.shares
    }

    /// Returns the bytes that the recipe takes.
    pub fn bytes(&self) -> usize {
        self.bytes
    }

    /// Returns the number of strips of the picture.
    pub fn strips(&self) -> usize {
        self.window.height().div_ceil(SIDES[1])
    }

    /// Returns the rows of a strip.
    pub fn strip(&self, index: usize) -> Window {
        let y0 = self.window.y0 + (index * SIDES[1]) as i64;
        Window { y0, y1: (y0 + SIDES[1] as i64).min(self.window.y1), ..self.window }
    }

    /// Returns the width of all tiles of a strip but the last.
    pub fn tile_width(&self) -> usize {
        SIDES[0]
    }

    /// Mixes a strip of the picture of other colors, one for each name, in the working space, and hands it tile by tile to
    /// `put`: red, green and blue, row by row.
    ///
    /// # Panics
    /// There is no such strip, or there are not as many colors as names.
    pub fn paint(&self, strip: usize, colors: &[[f64; 3]], put: impl FnMut(Window, [&[f32]; 3])) {
        assert_eq!(colors.len(), self.info.names.len(), "a color for each name");
        let factors = self.info.factors(colors);
        match &self.strips {
            Strips::Half(strips) => self.each(strip, &strips[strip], put, |tile, rows| {
                tile.paint(&factors, rows);
                true
            }),
            Strips::Float(strips) => self.each(strip, &strips[strip], put, |tile, rows| {
                tile.paint(&factors, rows);
                true
            }),
        }
    }

    /// Adds up by how much changes of some colors, in the working space, change a strip of the picture, and hands the sums
    /// to `put` as [`paint`](Self::paint) does; of tiles without these colors, nothing.
    ///
    /// # Panics
    /// There is no such strip, or `changes` does not have an entry for each share.
    pub fn shift(&self, strip: usize, changes: &[Option<[f64; 3]>], put: impl FnMut(Window, [&[f32]; 3])) {
        assert_eq!(changes.len(), self.shares.len(), "an entry for each share");
        match &self.strips {
            Strips::Half(strips) => self.each(strip, &strips[strip], put, |tile, rows| tile.shift(changes, rows)),
            Strips::Float(strips) => self.each(strip, &strips[strip], put, |tile, rows| tile.shift(changes, rows)),
        }
    }

    /// Hands what `make` makes of each tile of a strip to `put`, unless it says that there is nothing.
    fn each<S: StoredSample>(
        &self,
        strip: usize,
        tiles: &[Tile<S>],
        mut put: impl FnMut(Window, [&[f32]; 3]),
        make: impl Fn(&Tile<S>, [&mut [f32]; 3]) -> bool,
    ) {
        let mut rows = [[0.0_f32; SIDES[0] * SIDES[1]]; 3];
        for (tile, window) in tiles.iter().zip(self.strip(strip).tiles(SIDES[0], SIDES[1])) {
            if make(tile, rows.each_mut().map(|row| &mut row[..window.area()])) {
                put(window, rows.each_ref().map(|row| &row[..window.area()]));
            }
        }
    }

    /// Adds up the weights of some colors in a strip of the picture, and hands the sums tile by tile to `put`, row by row.
    ///
    /// # Panics
    /// There is no such strip, or `members` does not have an entry for each share.
    pub fn sum(&self, strip: usize, members: &[bool], mut put: impl FnMut(Window, &[f32])) {
        assert_eq!(members.len(), self.shares.len(), "an entry for each share");
        let mut sums = [0.0_f32; SIDES[0] * SIDES[1]];
        for (index, window) in self.strip(strip).tiles(SIDES[0], SIDES[1]).enumerate() {
            let sums = &mut sums[..window.area()];
            match &self.strips {
                Strips::Half(strips) => strips[strip][index].sum(members, sums),
                Strips::Float(strips) => strips[strip][index].sum(members, sums),
            }
            put(window, sums);
        }
    }

    /// Hands what each tile of a strip holds to `put`: which of the [shares](Self::shares) have weights in it, and these,
    /// share by share and pixel by pixel. If images contribute to it, their red, green and blue follow.
    ///
    /// # Panics
    /// There is no such strip.
    pub fn weights(&self, strip: usize, mut put: impl FnMut(Window, &[u32], &[f32])) {
        let mut samples = Vec::new();
        for (index, window) in self.strip(strip).tiles(SIDES[0], SIDES[1]).enumerate() {
            let places = match &self.strips {
                Strips::Half(strips) => strips[strip][index].widened(&mut samples),
                Strips::Float(strips) => strips[strip][index].widened(&mut samples),
            };
            put(window, places, &samples);
        }
    }

    /// Returns the weights of a pixel that are not 0, each with its place among the [shares](Self::shares); none outside of
    /// the picture.
    pub fn at(&self, x: i64, y: i64) -> Vec<(usize, f32)> {
        if !self.window.contains(x, y) {
            return Vec::new();
        }
        let [column, row] = [(x - self.window.x0) as usize, (y - self.window.y0) as usize];
        let (strip, tile) = (row / SIDES[1], column / SIDES[0]);
        let Some(window) = self.strip(strip).tiles(SIDES[0], SIDES[1]).nth(tile) else { return Vec::new() };
        let pixel = (row % SIDES[1]) * window.width() + column % SIDES[0];
        match &self.strips {
            Strips::Half(strips) => strips[strip][tile].at(pixel, window.area()),
            Strips::Float(strips) => strips[strip][tile].at(pixel, window.area()),
        }
    }
}

/// Packs bands of rows as they are evaluated.
struct Packer<S> {
    rows: RecipeRows,
    window: Window,
    strips: Vec<OnceLock<Vec<Tile<S>>>>,
    /// By weight, the sum over all pixels.
    sums: Mutex<Vec<f64>>,
    bytes: AtomicUsize,
    limit: usize,
}

impl<S: StoredSample + Send> Packer<S> {
    fn new(info: RecipeInfo, window: Window, limit: usize) -> Self {
        Self {
            sums: Mutex::new(vec![0.0; info.weights()]),
            rows: RecipeRows::new(info),
            window,
            strips: (0..window.height().div_ceil(SIDES[1])).map(|_| OnceLock::new()).collect(),
            bytes: AtomicUsize::new(0),
            limit,
        }
    }

    fn finished(self) -> (PackedRecipe, TileRows<S>) {
        let rounding = self.rows.rounding();
        let strips = self.strips.into_iter().map(|strip| strip.into_inner().unwrap_or_default()).collect();
        let sums = self.sums.into_inner().unwrap_or_else(PoisonError::into_inner);
        let recipe = PackedRecipe {
            info: self.rows.info,
            rounding,
            window: self.window,
            strips: Strips::Half(Vec::new()),
            shares: sums.into_iter().map(|sum| sum / self.window.area() as f64).collect(),
            bytes: self.bytes.into_inner(),
        };
        (recipe, strips)
    }
}

impl<S: StoredSample + Send> Sink for Packer<S> {
    fn rows(&self) -> usize {
        SIDES[1]
    }

    fn take(&self, band: Window, rows: &[Vec<&[f32]>]) -> Result<(), EvalError> {
        let mut channels = Vec::new();
        self.rows.store(&rows[0], &mut channels);
        let weights = self.rows.info.weights();
        let own = channels[..weights].iter().map(|row| row.iter().map(|weight| f64::from(*weight)).sum::<f64>());
        let own: Vec<f64> = own.collect();
        let mut sums = self.sums.lock().unwrap_or_else(PoisonError::into_inner);
        sums.iter_mut().zip(own).for_each(|(sum, own)| *sum += own);
        drop(sums);
        let width = band.width();
        for y0 in (band.y0..band.y1).step_by(SIDES[1]) {
            let strip = Window { y0, y1: (y0 + SIDES[1] as i64).min(band.y1), ..band };
            let mut tiles = Vec::with_capacity(width.div_ceil(SIDES[0]));
            for window in strip.tiles(SIDES[0], SIDES[1]) {
                let [left, top] = [(window.x0 - band.x0) as usize, (window.y0 - band.y0) as usize];
                let row = |y: usize| (0..window.width()).map(move |x| (top + y) * width + left + x);
                let pixels: Vec<usize> = (0..window.height()).flat_map(row).collect();
                let tile = Tile::pack(&channels, weights, &pixels);
                let bytes = tile.bytes();
                if self.bytes.fetch_add(bytes, Ordering::Relaxed) + bytes > self.limit {
                    return Err(EvalError::Sink(Arc::new(TooLarge { limit: self.limit }).into()));
                }
                tiles.push(tile);
            }
            let index = (y0 - self.window.y0) as usize / SIDES[1];
            // Each strip is evaluated once.
            let _ = self.strips[index].set(tiles);
        }
        Ok(())
    }
}

#[cfg(test)]
mod tests {
    #![allow(clippy::unwrap_used, reason = "a test may panic")]

    use super::*;
    use crate::parse;
    use std::path::Path;
    use trochoid_engine::Silent;

    /// A picture that is no multiple of tiles in size, of three colors, in a working space.
    fn graph(space: &str) -> CheckedGraph {
        let text = format!(
            r##"{{
              "trochoid": 1, "format": {{ "width": 150, "height": 21, "samples": 4 }}, "working_space": "{space}",
              "palette": {{ "night": "#101a33", "foam": "#f2ead2" }},
              "nodes": {{
                "across": {{ "type": "ScreenX" }}, "down": {{ "type": "ScreenY" }},
                "half": {{ "type": "Clamp", "field": "across", "min": 0.5, "max": 0.9 }},
                "a": {{ "type": "Mix", "a": "palette.night", "b": "#d8513a", "weight": "half" }},
                "b": {{ "type": "Mix", "a": "a", "b": "palette.foam", "weight": "down" }}
              }},
              "outputs": {{ "beauty": {{ "color": "b" }} }}
            }}"##
        );
        parse("a.json", &text, Path::new("."), &[]).unwrap().graph
    }

    fn recipe(graph: &CheckedGraph, region: Option<Window>, limit: usize) -> Result<PackedRecipe, PackError> {
        PackedRecipe::evaluate(graph, 0, 1, region, limit, &mut Cache::new(), &Silent)
    }

    /// Paints all strips.
    fn painted(recipe: &PackedRecipe, colors: &[[f64; 3]]) -> Vec<[f32; 3]> {
        let whole = recipe.window();
        let mut pixels = vec![[f32::NAN; 3]; whole.area()];
        for strip in 0..recipe.strips() {
            recipe.paint(strip, colors, |window, [r, g, b]| {
                for (index, pixel) in r.iter().zip(g).zip(b).map(|((r, g), b)| [*r, *g, *b]).enumerate() {
                    let x = (window.x0 - whole.x0) as usize + index % window.width();
                    let y = (window.y0 - whole.y0) as usize + index / window.width();
                    pixels[y * whole.width() + x] = pixel;
                }
            });
        }
        pixels
    }

    #[test]
    fn the_painted_picture_is_the_evaluated_one() {
        for space in ["srgb", "linear-srgb", "acescg"] {
            let graph = graph(space);
            let region = Window::new(3, 2, 140, 19);
            for region in [None, Some(region)] {
                let recipe = recipe(&graph, region, 1 << 20).unwrap();
                assert_eq!(recipe.info().names, ["night", "foam", "a.b"]);
                let mut settings = Settings::default();
                settings.region = region;
                let plan = Plan::new(&graph, &[], 1, &[], &settings).unwrap();
                let frame = plan.evaluate(&Buffers::new(), &mut Cache::new(), &Silent).unwrap();
                let planes = &frame.pictures[0].planes;
                let bound = recipe.rounding().bound(1.0) + 1e-6;
                for (index, pixel) in painted(&recipe, &recipe.info().colors).iter().enumerate() {
                    for (channel, plane) in planes.iter().enumerate() {
                        let off = f64::from((pixel[channel] - plane.samples()[index]).abs());
                        assert!(off <= bound, "{space}: pixel {index}: {off} > {bound}");
                    }
                }
            }
        }
    }

    #[test]
    fn shares_masks_and_pixels_agree() {
        let recipe = recipe(&graph("srgb"), None, 1 << 20).unwrap();
        assert!((recipe.shares().iter().sum::<f64>() - 1.0).abs() < 1e-9, "{:?}", recipe.shares());
        for color in 0..3 {
            let members = [0, 1, 2].map(|index| index == color);
            let mut total = 0.0;
            for strip in 0..recipe.strips() {
                recipe.sum(strip, &members, |window, sums| {
                    for (index, sum) in sums.iter().enumerate() {
                        let x = window.x0 + (index % window.width()) as i64;
                        let y = window.y0 + (index / window.width()) as i64;
                        let own = recipe.at(x, y).into_iter().find(|(place, _)| *place == color);
                        assert_eq!(own.map_or(0.0, |(_, weight)| weight), *sum, "({x}, {y})");
                        total += f64::from(*sum);
                    }
                });
            }
            assert!((total / recipe.window().area() as f64 - recipe.shares()[color]).abs() < 1e-9);
        }
        let mut count = 0;
        for strip in 0..recipe.strips() {
            recipe.weights(strip, |window, places, samples| {
                assert_eq!(samples.len(), places.len() * window.area());
                for pixel in 0..window.area() {
                    let x = window.x0 + (pixel % window.width()) as i64;
                    let y = window.y0 + (pixel / window.width()) as i64;
                    let rows = samples.chunks_exact(window.area()).map(|row| row[pixel]);
                    let own: Vec<_> = places.iter().map(|place| *place as usize).zip(rows).collect();
                    let own: Vec<_> = own.into_iter().filter(|(_, weight)| *weight > 0.0).collect();
                    assert_eq!(own, recipe.at(x, y), "({x}, {y})");
                    count += 1;
                }
            });
        }
        assert_eq!(count, recipe.window().area());
        assert!(recipe.at(-1, 0).is_empty() && recipe.at(0, 21).is_empty());
    }

    #[test]
    fn changes_of_colors_change_the_pixels_that_have_them() {
        let recipe = recipe(&graph("srgb"), None, 1 << 20).unwrap();
        let old = recipe.info().colors.clone();
        let mut new = old.clone();
        new[2] = [0.25, 0.75, 0.5];
        let change = [0, 1, 2].map(|channel| new[2][channel] - old[2][channel]);
        let (before, after) = (painted(&recipe, &old), painted(&recipe, &new));
        let mut tiles = 0;
        for strip in 0..recipe.strips() {
            recipe.shift(strip, &[None, None, Some(change)], |window, sums| {
                assert!(window.x1 > 75, "the other half has nothing of it: {window}");
                tiles += 1;
                for (channel, sums) in sums.iter().enumerate() {
                    for (index, sum) in sums.iter().enumerate() {
                        let x = window.x0 as usize + index % window.width();
                        let at = (window.y0 as usize + index / window.width()) * 150 + x;
                        let off = before[at][channel] + sum - after[at][channel];
                        assert!(off.abs() < 1e-6, "({at}, {channel}): {off}");
                    }
                }
            });
        }
        assert_eq!(tiles, 6);
    }

    #[test]
    fn recipes_that_take_too_much_memory_are_refused_in_words() {
        let Err(error) = recipe(&graph("srgb"), None, 4096) else { panic!("too large") };
        assert!(matches!(error, PackError::Large(_)), "{error}");
        assert!(error.to_string().contains("expected at most"), "{error}");
    }
}
