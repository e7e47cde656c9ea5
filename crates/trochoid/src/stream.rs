//! Files that are written while their rows are computed, so that memory does not grow with the picture.

use crate::Form;
use crate::exr_layer::{Conversion, file_channels, reserved};
use crate::files::{folder_of_file, target};
use crate::marks::with_mark;
use crate::output_file::{OutputError, OutputFile};
use std::borrow::Cow;
use std::sync::{Arc, Mutex, PoisonError};
use trochoid_engine::{EvalError, Plan, Sink};
use trochoid_graph::{CheckedGraph, Kind};
use trochoid_image::Window;
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
pub struct FileSink {
    files: Vec<Open>,
    spare: Mutex<Vec<EncodeScratch>>,
    /// Why the evaluation fails: what came first, for what follows is its consequence.
    failure: Mutex<Option<Arc<OutputError>>>,
}

/// File being written.
struct Open {
    file: OutputFile,
    writer: ExrWriter,
    /// Outputs by their index in the plan.
    outputs: Vec<(usize, Conversion)>,
}

impl FileSink {
    /// Creates the files of a plan's outputs; `None` if one of them is not an EXR file, since other files need the
    /// whole frame.
    ///
    /// # Errors
    /// A file cannot be created.
    pub fn create(graph: &CheckedGraph, plan: &Plan<'_>, files: &[OutputFile]) -> Result<Option<Self>, OutputError> {
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
            let conversions = specs().map(|spec| Conversion::of(graph, spec, file, plan.frame()));
            let conversions = conversions.collect::<Result<Vec<_>, _>>()?;
            let header = ExrHeader {
                display: graph.format().window(),
                data: plan.window(),
                channels: specs().flat_map(|spec| file_channels(graph, spec, file)).collect(),
                late_metadata: reserved(specs(), conversions.iter()),
                chromaticities: specs().any(|s| s.kind == Kind::Color).then(|| graph.space().chromaticities()),
                ..ExrHeader::new(plan.window())
            };
            let place = |output: &usize| planned.iter().position(|planned| planned == output);
            let outputs = outputs.iter().zip(conversions);
            let outputs = outputs.filter_map(|(output, conversion)| Some((place(output)?, conversion))).collect();
            open.push(Open {
                file: file.clone(),
                writer: ExrWriter::create(target(&file.path, Form::Exr, graph.access().overwrites()), &header)?,
                outputs,
            });
        }
        Ok(Some(Self { files: open, spare: Mutex::new(Vec::new()), failure: Mutex::new(None) }))
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
                let late = open.outputs.iter().filter_map(|(_, conversion)| conversion.metadata());
                let metadata = with_mark(&metadata).into_iter().chain(late);
                open.writer.finish(&metadata.collect::<Vec<_>>())?;
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
            let converted = open.outputs.iter().flat_map(|(output, conversion)| {
                let rows: Vec<&[f32]> = rows[*output].iter().map(|row| &row[range.clone()]).collect();
                conversion.channels(&rows)
            });
            let converted: Vec<Cow<'_, [f32]>> = converted.collect();
            let channels: Vec<&[f32]> = converted.iter().map(|channel| &**channel).collect();
            open.writer.push(open.writer.encode(first + index, &channels, scratch)?)?;
        }
        Ok(())
    }
}

impl std::fmt::Debug for FileSink {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        f.debug_list().entries(self.files.iter().map(|open| &open.file.path)).finish()
    }
}

impl Sink for FileSink {
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
