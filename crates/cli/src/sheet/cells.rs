//! What is on a sheet: documents, values of a knob, frames.

use super::Args;
use super::draw::Layout;
use crate::failure::Failure;
use crate::wedge::{self, Wedge};
use crate::{frames, outputs, scale, shown, warnings};
use std::path::{Path, PathBuf};
use trochoid::{CheckedGraph, Diagnostic};

/// Most pictures of a sheet.
const MOST: usize = 1024;
/// Most frames of a single document that are chosen unasked.
const CHOSEN: i64 = 12;

/// A document, perhaps with a value of a knob, at the size of its pictures.
pub(super) struct Variant {
    pub(super) path: PathBuf,
    pub(super) graph: CheckedGraph,
    pub(super) output: usize,
    /// The value, as `sea.height = 3`.
    value: Option<String>,
    pub(super) frames: Vec<i64>,
}

/// The pictures of a sheet, row by row.
pub(super) struct Cells {
    pub(super) variants: Vec<Variant>,
    /// Warnings about what is shown.
    pub(super) warnings: Vec<Diagnostic>,
    has_documents: bool,
    has_frames: bool,
}

impl Cells {
    /// Loads all documents, and adds all faults to `faults`.
    pub(super) fn new(args: &Args, wedge: Option<&Wedge>, faults: &mut Vec<Failure>) -> Self {
        let listed = args.frames.as_deref().map(frames::parse).transpose().unwrap_or_else(|pieces| {
            faults.extend(pieces.into_iter().map(|piece| Failure::usage(piece, "use a list such as 1-96x12")));
            Some(vec![1])
        });
        let values: Vec<Option<&String>> = match wedge {
            Some(wedge) => wedge.values.iter().map(Some).collect(),
            None => vec![None],
        };
        let is_single = args.graphs.len() * values.len() == 1;
        let (mut variants, mut warned) = (Vec::new(), Vec::new());
        for path in &args.graphs {
            // Faults of a document itself would be those of each value, too.
            let plain = match args.files.load(path, &args.assignments()) {
                Ok(loaded) => loaded,
                Err(error) => {
                    faults.push(error.into());
                    continue;
                }
            };
            for (index, value) in values.iter().enumerate() {
                let loaded = match (wedge, value) {
                    (Some(wedge), Some(value)) => {
                        let assignment = format!("{}={value}", wedge.knob);
                        args.files.load(path, &[args.assignments(), vec![assignment]].concat()).map_err(wedge::refused)
                    }
                    _ => Ok(plain.clone()),
                };
                let loaded = match loaded {
                    Ok(loaded) => loaded,
                    // The other values would most often be refused for the same reason.
                    Err(failure) => {
                        faults.push(failure);
                        break;
                    }
                };
                let frames = listed.clone().unwrap_or_else(|| chosen(&loaded.graph, is_single));
                let value = wedge.zip(*value).map(|(wedge, value)| format!("{} = {value}", wedge.knob));
                match variant(args, path, loaded.graph, value, frames, faults) {
                    Some(variant) => {
                        if index == 0 {
                            warned.extend(warnings::of(&variant.graph, &[variant.output], loaded.warnings));
                        }
                        variants.push(variant);
                    }
                    None => break,
                }
            }
        }
        let has_frames = variants.iter().any(|variant| variant.frames.len() > 1);
        Self { variants, warnings: warned, has_documents: args.graphs.len() > 1, has_frames }
    }

    /// Returns the number of pictures.
    pub(super) fn count(&self) -> usize {
        self.variants.iter().map(|variant| variant.frames.len()).sum()
    }

    /// Arranges the pictures; adds a fault if there are too many.
    pub(super) fn layout(&self, args: &Args, faults: &mut Vec<Failure>) -> Layout {
        let count = self.count();
        if count > MOST {
            let message = format!("found {count} pictures; expected at most {MOST} on a sheet");
            faults.push(Failure::usage(message, "choose fewer --frames, documents or values of --wedge"));
        }
        let side = |side: fn(&CheckedGraph) -> u32| self.variants.iter().map(|variant| side(&variant.graph)).max();
        let cell =
            [side(|graph| graph.format().width()).unwrap_or(1), side(|graph| graph.format().height()).unwrap_or(1)];
        let rows = self.variants.len();
        let columns = match args.columns {
            Some(columns) => columns as usize,
            None if rows > 1 && self.has_frames => count.div_ceil(rows),
            None => Layout::columns(count, cell),
        };
        let sizes = self.variants.iter().flat_map(|variant| {
            let format = variant.graph.format();
            std::iter::repeat_n([format.width(), format.height()], variant.frames.len())
        });
        let lines = usize::from(self.has_documents) + usize::from(self.variants.iter().any(|v| v.value.is_some()));
        let layout = Layout::new(sizes.collect(), cell, columns.min(count.max(1)), (lines + 1).min(3));
        if let Some(failure) = layout.refused() {
            faults.push(failure);
        }
        layout
    }

    /// Returns the caption of each picture: lines that tell what differs.
    pub(super) fn captions(&self) -> Vec<Vec<String>> {
        let caption = |variant: &Variant, frame: &i64| {
            let name = self.has_documents.then(|| name(&variant.path));
            name.into_iter().chain(variant.value.clone()).chain([format!("frame {frame}")]).collect()
        };
        let captions = self.variants.iter().flat_map(|variant| variant.frames.iter().map(move |f| caption(variant, f)));
        captions.collect()
    }

    /// Returns the title of the sheet: the document, the output, and what is black and white.
    pub(super) fn title(&self, range: Option<[f32; 2]>) -> String {
        let Some(first) = self.variants.first() else { return String::new() };
        let output = &first.graph.outputs()[first.output].name;
        let is_same = self.variants.iter().all(|variant| variant.graph.outputs()[variant.output].name == *output);
        let documents = match self.has_documents {
            true => None,
            false => Some(name(&first.path)),
        };
        let words = documents.into_iter().chain(is_same.then(|| output.clone()));
        words.collect::<Vec<_>>().join(", ") + &shown::told(range)
    }

    /// Returns where a variant is, for messages.
    pub(super) fn place(&self, variant: &Variant) -> String {
        let document = self.has_documents.then(|| format!("{}: ", variant.path.display()));
        let value = variant.value.as_ref().map(|value| format!("{value}: "));
        document.into_iter().chain(value).collect()
    }
}

/// Returns the frames of a document that are chosen unasked.
fn chosen(graph: &CheckedGraph, is_single: bool) -> Vec<i64> {
    let (first, last) = graph.frames();
    let count = if is_single { (last - first + 1).min(CHOSEN) } else { 1 };
    // Evenly, with the first and the last one.
    (0..count).map(|index| first + (index * (last - first) + (count - 1) / 2) / (count - 1).max(1)).collect()
}

fn name(path: &Path) -> String {
    path.file_name().map_or_else(|| path.display().to_string(), |name| name.to_string_lossy().into_owned())
}

/// Returns a document at the size of its pictures; adds faults of its output.
fn variant(
    args: &Args,
    path: &Path,
    graph: CheckedGraph,
    value: Option<String>,
    frames: Vec<i64>,
    faults: &mut Vec<Failure>,
) -> Option<Variant> {
    let before = faults.len();
    let output = match args.view {
        Some(_) => graph.outputs().len() - 1,
        None => outputs::choose(&graph, args.output.as_slice(), faults)[0],
    };
    faults.extend(shown::refused(&graph.outputs()[output]));
    let place = if args.graphs.len() > 1 { format!("{}: ", path.display()) } else { String::new() };
    for fault in &mut faults[before..] {
        *fault = std::mem::take(fault).at(&place);
    }
    let factor = (f64::from(args.width) / f64::from(graph.format().width())).min(1.0);
    let size = scale::size(graph.format(), factor, false);
    match scale::sized(graph, size) {
        Ok(graph) if faults.len() == before => Some(Variant { path: path.into(), graph, output, value, frames }),
        Ok(_) => None,
        Err(failure) => {
            faults.push(failure.at(&place));
            None
        }
    }
}
