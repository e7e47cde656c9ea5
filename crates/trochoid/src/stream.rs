//! Files that are written while their rows are computed, so that memory does not grow with the picture.

use crate::Form;
use crate::exr_layer::{convert, file_channels, reserved};
use crate::files::{folder_of_file, target};
use crate::marks::with_mark;
use crate::output_file::{OutputError, OutputFile};
use std::sync::{Arc, Mutex, PoisonError};
use trochoid_engine::{EvalError, Plan, Sink};
use trochoid_graph::{CheckedGraph, Kind};
use trochoid_image::{Window, WorkingSpace};
use trochoid_io::{EncodeScratch, ExrHeader, ExrWriter};

/// Sink for the EXR files of one frame, which [`Plan::evaluate_to`] writes band by band.
///
/// ```
/// use trochoid::{Buffers, Cache, FileSink, OutputFile, Plan, Settings, Silent};
///
/// let folder = tempfile::tempdir()?;
/// let text = r##"{ "trochoid": 1, "format": { "width": 64, "height": 40 },
///                  "nodes": { "across": { "type": "ScreenX" },
///                             "mix": { "type": "Mix", "a": "#123", "b": "#fed", "weight": "across" } },
///                  "outputs": { "beauty": { "color": "mix" } } }"##;
/// let graph = trochoid::parse("a.json", text, folder.path(), &[])?.graph;
/// let plan = Plan::new(&graph, &[], 1, &[], &Settings::default())?;
/// let files = [OutputFile { path: folder.path().join("a.exr"), outputs: vec![0] }];
/// let sink = FileSink::create(&graph, &plan, &files)?.expect("all of them are EXR");
/// let frame = plan.evaluate_to(&sink, &Buffers::new(), &mut Cache::new(), &Silent)?;
/// assert_eq!(frame.pictures[0].audit.hull_exits, 0);
/// sink.finish(|_| Some(Vec::new()))?;
/// assert!(files[0].path.exists());
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
pub struct FileSink<'g> {
    graph: &'g CheckedGraph,
    files: Vec<Open>,
    spare: Mutex<Vec<EncodeScratch>>,
    /// Why the evaluation fails: what came first, for what follows is its consequence.
    failure: Mutex<Option<Arc<OutputError>>>,
}

/// File being written.
struct Open {
    file: OutputFile,
    writer: ExrWriter,
    /// Outputs by their index in the plan, and whether their colors are decoded to linear light.
    outputs: Vec<(usize, bool)>,
}

impl<'g> FileSink<'g> {
    /// Creates the files of a plan's outputs; `None` if one of them is not an EXR file, since other files need the
    /// whole frame.
    ///
    /// # Errors
    /// A file cannot be created.
    pub fn create(graph: &'g CheckedGraph, plan: &Plan<'_>, files: &[OutputFile]) -> Result<Option<Self>, OutputError> {
        let is_exr = |file: &OutputFile| file.path.extension().is_some_and(|e| e.eq_ignore_ascii_case("exr"));
        if !files.iter().all(is_exr) {
            return Ok(None);
        }
        let planned = plan.outputs();
        let mut open = Vec::with_capacity(files.len());
        for file in files {
            folder_of_file(&file.path)?;
            let outputs: Vec<usize> = planned.iter().copied().filter(|output| file.outputs.contains(output)).collect();
            let specs = || outputs.iter().map(|output| &graph.outputs()[*output]);
            let header = ExrHeader {
                display: graph.format().window(),
                data: plan.window(),
                channels: specs().flat_map(|spec| file_channels(graph, spec, file)).collect(),
                late_metadata: reserved(specs()),
                chromaticities: specs().any(|s| s.kind == Kind::Color).then(|| graph.space().chromaticities()),
                ..ExrHeader::new(plan.window())
            };
            let encoded = |kind: Kind| kind == Kind::Color && graph.space() == WorkingSpace::Srgb;
            let place = |output: &usize| planned.iter().position(|planned| planned == output);
            let outputs = specs().zip(&outputs).filter_map(|(spec, output)| Some((place(output)?, encoded(spec.kind))));
            let outputs = outputs.collect();
            open.push(Open {
                file: file.clone(),
                writer: ExrWriter::create(target(&file.path, Form::Exr, graph.access().overwrites()), &header)?,
                outputs,
            });
        }
        Ok(Some(Self { graph, files: open, spare: Mutex::new(Vec::new()), failure: Mutex::new(None) }))
    }

    /// Completes the files; `metadata` gives what goes into each one, or `None` where it is not to appear.
    ///
    /// # Errors
    /// A file cannot be written.
    pub fn finish(
        self,
        mut metadata: impl FnMut(&OutputFile) -> Option<Vec<(String, String)>>,
    ) -> Result<(), OutputError> {
        for open in self.files {
            if let Some(metadata) = metadata(&open.file) {
                open.writer.finish(&with_mark(&metadata))?;
            }
        }
        Ok(())
    }

    fn encode(
        &self,
        open: &Open,
        band: Window,
        rows: &[Vec<&[f32]>],
        scratch: &mut EncodeScratch,
    ) -> Result<(), OutputError> {
        let width = band.width();
        let height = open.writer.rows_per_band();
        let first = (band.y0 - open.writer.band_window(0).y0) as usize / height;
        for (index, start) in (0..band.height()).step_by(height).enumerate() {
            let range = start * width..(start + height).min(band.height()) * width;
            let mut linear: Vec<[Vec<f32>; 3]> = Vec::new();
            for &(output, _) in open.outputs.iter().filter(|(_, encoded)| *encoded) {
                let rgb = [0, 1, 2].map(|c: usize| &rows[output][c][range.clone()]);
                linear.push(convert(rgb, |color| self.graph.space().to_linear_srgb(color)));
            }
            let mut linear = linear.iter();
            let mut channels: Vec<&[f32]> = Vec::new();
            for &(output, encoded) in &open.outputs {
                match encoded.then(|| linear.next()).flatten() {
                    Some(color) => channels.extend(color.iter().map(Vec::as_slice)),
                    None => channels.extend(rows[output].iter().map(|row| &row[range.clone()])),
                }
            }
            open.writer.push(open.writer.encode(first + index, &channels, scratch)?)?;
        }
        Ok(())
    }
}

impl std::fmt::Debug for FileSink<'_> {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        f.debug_list().entries(self.files.iter().map(|open| &open.file.path)).finish()
    }
}

impl Sink for FileSink<'_> {
    fn rows(&self) -> usize {
        self.files.first().map_or(1, |open| open.writer.rows_per_band())
    }

    fn take(&self, band: Window, rows: &[Vec<&[f32]>]) -> Result<(), EvalError> {
        let spare = || self.spare.lock().unwrap_or_else(PoisonError::into_inner);
        let mut scratch = spare().pop().unwrap_or_default();
        let encoded = self.files.iter().try_for_each(|open| self.encode(open, band, rows, &mut scratch));
        spare().push(scratch);
        encoded.map_err(|error| {
            let mut failure = self.failure.lock().unwrap_or_else(PoisonError::into_inner);
            EvalError::Sink(failure.get_or_insert_with(|| Arc::new(error)).clone().into())
        })
    }
}
