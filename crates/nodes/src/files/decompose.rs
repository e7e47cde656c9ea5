//! Decompose: a picture file as the weights of a palette.

use crate::files::knobs::{As, DecodeKnobs, FileKnobs, FitBy, Knobs, SelectionKnobs};
use crate::files::{Fit, Layer, Planes, Reading, memory_of_picture};
use crate::filter::value;
use crate::view::named;
use std::path::{Path, PathBuf};
use std::sync::Arc;
use trochoid_graph::*;
use trochoid_image::{Window, WorkingSpace, parse_hex, srgb_decode};
use trochoid_memory::Scratch;
use trochoid_palette::{Decomposer, MOST_COLORS};
use trochoid_weights::Storing;

/// Takes a picture file apart: how much of each color of its palette every pixel is mixed of.
///
/// # Formula
/// The weights ω that minimize Σ ωᵢhᵢ + softness·Σ ωᵢ ln ωᵢ, with Σω = 1 and ΣωᵢCᵢ = the pixel's color in the working
/// space; hᵢ is the squared distance of the color Cᵢ from the palette's mean, relative to its extent. A Blend of the
/// same colors by these weights is the picture; a Blend of other colors is the picture in these.
///
/// # Edge cases
/// The palette is written out, in its own words: it says what the picture was, so it does not follow the document's
/// palette, and the weights depend on no control color. A pixel outside of the palette's hull has the weights of the
/// nearest color in it; `trochoid palette` finds palettes that leave none outside. The same color has the same weights
/// in every pixel and every frame. Two colors give a mask, the weight of the second. Bad data is handled as in Read.
/// No color of the file is a control color.
///
/// # Source
/// Tan, Echevarria, Gingold 2018, "Efficient palette-based decomposition and recoloring of images via RGBXY-space
/// geometry", for palettes as hulls; weights of greatest entropy: Hormann, Sukumar 2008, "Maximum entropy coordinates for
/// arbitrary polytopes".
#[derive(Clone, Node)]
#[node(
    stage,
    end = Back,
    revision = 1,
    example = r##""colors": ["#102030", "#f0e0c0"]"##,
    reads("a picture": "exr", "png", "jpg", "jpeg", "tif", "tiff"),
    output(weights: Kind::ANY_WEIGHTS = "One weight per color, in the order of `colors`.")
)]
#[also_called("Unmix", "Separate", "Recolor", "PaletteWeights")]
pub(crate) struct Decompose {
    /// Picture file. #### or %04d stands for the frame number; write \# and \% for literal signs.
    #[knob(path)]
    file: String,
    /// The picture's palette, 2 to 24 colors as "#rrggbb" in sRGB.
    #[knob(len = 2..=24)]
    colors: Vec<String>,
    /// How much colors share: 0 for few colors a pixel and sharp changes, 1 for all of them everywhere.
    #[knob(default = 0.2, range = 0.0..=1.0)]
    softness: f64,
    #[items]
    selected: SelectionKnobs,
    /// Fit of a picture whose size differs from the document's. If unset, such a picture is refused.
    fit: Option<FitBy>,
    #[items]
    taken: DecodeKnobs,
}

impl Decompose {
    fn named(&self) -> FileKnobs {
        FileKnobs { file: self.file.clone(), r#as: As::Color }
    }

    fn knobs<'n>(&'n self, named: &'n FileKnobs) -> Knobs<'n> {
        Knobs { named, selected: &self.selected, taken: &self.taken, fit: self.fit }
    }

    /// Returns the palette in a working space. Colors that are none were reported by `check`.
    fn palette(&self, space: WorkingSpace) -> Vec<[f64; 3]> {
        let color = |text: &String| space.from_linear_srgb(parse_hex(text).unwrap_or_default().map(srgb_decode));
        self.colors.iter().map(color).collect()
    }

    fn kind(&self) -> Kind {
        Kind::Weights(self.colors.len().max(2))
    }

    /// Reads the picture's red, green and blue.
    fn layers(&self, frame: &FrameContext, path: &Path) -> Result<(Vec<Layer>, u64), NodeError> {
        let named = self.named();
        let reading = Reading { knobs: self.knobs(&named), frame, path, outside: None };
        let mut fit = None;
        let Planes { planes, exact, repaired } = reading.planes(Kind::Color, &[true; 3], &mut |picture| {
            let sizes = [frame.format, frame.document_format];
            fit = Some(Fit::new(self.fit, FitBy::WORDS, picture.display, sizes, path)?);
            Ok(())
        })?;
        let mut exact = exact.into_iter();
        let layers = planes.into_iter().flatten().filter_map(|plane| {
            let exact = exact.next();
            Some(Layer::new(plane, fit?, None).with_exact(exact))
        });
        Ok((layers.collect(), repaired))
    }
}

impl Node for Decompose {
    fn kinds(&self) -> Option<Vec<Kind>> {
        Some(vec![self.kind()])
    }

    fn check(&self, check: &mut Check<'_>) {
        self.knobs(&self.named()).check("a Decompose", None, check);
        if self.colors.len() < 2 {
            let found = if self.colors.is_empty() { "no colors" } else { "1 color" };
            let remedy = "`trochoid palette PICTURE` finds the colors of a picture";
            check.error(Self::COLORS, found, format!("2 to {MOST_COLORS} colors"), remedy);
        }
        for (index, text) in self.colors.iter().enumerate() {
            match parse_hex(text) {
                Err(_) => {
                    let remedy =
                        "write \"#rrggbb\" or \"#rgb\": the palette of the picture as it is, whatever the document's";
                    check.error(Self::COLORS, format!("\"{text}\""), "a color", remedy);
                }
                Ok(color) if self.colors[..index].iter().any(|other| parse_hex(other) == Ok(color)) => {
                    check.error(
                        Self::COLORS,
                        format!("\"{text}\" twice"),
                        "colors that differ",
                        "remove one of the two",
                    );
                }
                Ok(_) => {}
            }
        }
    }
}

impl Stage for Decompose {
    fn interval(&self, _output: usize, _channel: usize) -> Option<(f64, f64)> {
        Some((0.0, 1.0))
    }

    fn files(&self, frame: &FrameContext) -> Vec<PathBuf> {
        vec![frame.path(&self.file)]
    }

    fn memory(&self, context: &MemoryContext<'_>) -> MemoryUse {
        // A pixel's color, twice, and weights that nobody wants.
        let pixel = size_of::<f32>() * (6 + self.kind().channels());
        memory_of_picture(self.knobs(&self.named()), context, None).thread(pixel as u64, u64::MAX)
    }

    fn check_headers(&self, frame: &FrameContext, wanted: &[Vec<bool>]) -> Result<(), NodeError> {
        let path = named(frame, &self.file)?;
        let is_wanted = wanted.iter().flatten().any(|wanted| *wanted);
        let named = self.named();
        Reading { knobs: self.knobs(&named), frame, path: &path, outside: None }.check_headers(&[is_wanted; 3], true)
    }

    fn prepare(&self, prepare: &Prepare<'_>) -> Result<Box<dyn Prepared>, NodeError> {
        let path = named(prepare.frame, &self.file)?;
        let (layers, repaired) = match prepare.wanted.iter().flatten().any(|wanted| *wanted) {
            true => self.layers(prepare.frame, &path)?,
            false => (Vec::new(), 0),
        };
        let palette = self.palette(prepare.frame.space);
        // A palette that it does not take was reported.
        let decomposer =
            prepare.shared(&("decompose", &palette, self.softness), || Ok(Decomposer::new(&palette, self.softness)))?;
        Ok(Box::new(PreparedDecompose { kind: self.kind(), layers, decomposer, repaired }))
    }
}

struct PreparedDecompose {
    kind: Kind,
    /// Red, green and blue.
    layers: Vec<Layer>,
    /// What frames share.
    decomposer: Arc<Option<Decomposer>>,
    repaired: u64,
}

impl PreparedDecompose {
    /// Returns the weights of a color, channel by channel.
    fn weights(&self, color: [f64; 3]) -> Vec<f64> {
        (*self.decomposer).as_ref().map_or_else(Vec::new, |decomposer| decomposer.weights(color))
    }

    /// Returns the channels of the output at a position, in f64.
    fn truth(&self, at: [f64; 2]) -> Vec<f64> {
        let channel = |index: usize| self.layers.get(index).map_or(0.0, |layer| layer.reference(at));
        channels(self.kind, self.weights([0, 1, 2].map(channel)))
    }
}

/// Returns the channels of weights: of two, a mask has only the second.
fn channels<T: Copy>(kind: Kind, weights: Vec<T>) -> Vec<T> {
    if kind == Kind::MASK { weights[1..].to_vec() } else { weights }
}

impl Prepared for PreparedDecompose {
    fn data_window(&self, picture: Window, _inputs: &dyn Fn(PortId) -> Window) -> Window {
        self.layers.iter().fold(picture, |window, layer| window.union(layer.window()))
    }

    fn fill(&self, block: &Block<'_>, _inputs: &Inputs<'_>, outputs: &mut Outputs<'_>) -> Result<(), NodeError> {
        let Some(decomposer) = &*self.decomposer else { return Ok(()) };
        let area = block.window.area();
        let mut planes = [(); 3].map(|()| Scratch::of(0.0, area));
        for (layer, plane) in self.layers.iter().zip(&mut planes) {
            layer.fill(block, plane);
        }
        let [r, g, b] = &planes;
        let colors: Scratch<[f32; 3]> = r.iter().zip(g).zip(b).map(|((r, g), b)| [*r, *g, *b]).collect();
        // Planes that nobody wants, and the first weight of a mask, are thrown away.
        let first = usize::from(self.kind == Kind::MASK);
        let mut wanted: Scratch<Option<&mut [f32]>> = (0..first).map(|_| None).collect();
        wanted.extend((0..self.kind.channels()).map(|channel| outputs.only(channel)));
        let mut spare: Scratch<Scratch<f32>> =
            wanted.iter().map(|plane| Scratch::of(0.0, if plane.is_some() { 0 } else { area })).collect();
        let planes = wanted.iter_mut().zip(&mut spare);
        let mut planes: Scratch<&mut [f32]> = planes
            .map(|(plane, spare)| match plane {
                Some(plane) => &mut **plane,
                None => &mut spare[..],
            })
            .collect();
        decomposer.fill(&colors, Storing::Float, &mut planes);
        Ok(())
    }

    fn bound(&self, bounding: &Bounding<'_>, outputs: &mut Outputs<'_>) -> Result<(), NoBound> {
        let truths: Vec<Vec<f64>> = bounding.block.places().map(|at| self.truth(at)).collect();
        (0..self.kind.channels()).for_each(|channel| {
            bounding.bound_by(outputs, SoleOutput, channel, |sample| {
                let truth = truths[sample][channel];
                Span::of(&[truth, truth]).within(0.0, 1.0)
            });
        });
        Ok(())
    }

    fn reference(&self, inputs: &References<'_>) -> Result<Vec<Reference>, NodeError> {
        Ok(vec![value(self.kind, self.truth(inputs.at))])
    }

    fn repaired(&self) -> u64 {
        self.repaired
    }

    fn bytes(&self) -> usize {
        self.layers.iter().map(Layer::bytes).sum()
    }
}
