//! Files that are written while their rows are computed, so that memory does not grow with the picture.

use crate::Form;
use crate::exr_layer::{Conversion, file_channels, reserved};
use crate::files::{folder_of_file, target};
use crate::marks::with_mark;
use crate::output_file::{OutputError, OutputFile};
use std::sync::{Arc, Mutex, PoisonError};
use trochoid_engine::{EvalError, Frame, Plan, Sink};
use trochoid_graph::{CheckedGraph, Kind};
use trochoid_image::Window;
use trochoid_io::{EncodeScratch, ExrHeader, ExrWriter};

/// Metadata key of a tile: bytes that the file of the whole picture reserves for late metadata.
pub(crate) const RESERVED: &str = "trochoid:reserved";
/// Bytes that a tile reserves beyond these: for [`RESERVED`], and the fingerprint of the whole picture.
const OF_TILE: usize = 256;

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
    spare: Mutex<Vec<Scratch>>,
    /// Why the evaluation fails: what came first, for what follows is its consequence.
    failure: Mutex<Option<Arc<OutputError>>>,
}

/// Reusable memory of a thread.
#[derive(Default)]
struct Scratch {
    encoding: EncodeScratch,
    /// Converted samples by output and channel.
    converted: Vec<Vec<Vec<f32>>>,
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
        let open = files.iter().map(|file| Open::create(graph, file, &planned, plan.window(), plan.frame()));
        let open = open.collect::<Result<Vec<_>, _>>()?;
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
                open.finish(&metadata)?;
            }
        }
        Ok(())
    }
}

impl Open {
    /// Starts a file of some of the `evaluated` outputs.
    fn create(
        graph: &CheckedGraph,
        file: &OutputFile,
        evaluated: &[usize],
        window: Window,
        frame: i64,
    ) -> Result<Self, OutputError> {
        folder_of_file(&file.path)?;
        let outputs: Vec<usize> = evaluated.iter().copied().filter(|output| file.outputs.contains(output)).collect();
        let specs = || outputs.iter().map(|output| &graph.outputs()[*output]);
        let conversions = specs().map(|spec| Conversion::of(graph, spec, file, frame));
        let conversions = conversions.collect::<Result<Vec<_>, _>>()?;
        let display = graph.format().window();
        let of_tile = if window == display { 0 } else { OF_TILE };
        let header = ExrHeader {
            display,
            channels: specs().flat_map(|spec| file_channels(graph, spec, file)).collect(),
            late_metadata: reserved(specs(), conversions.iter()) + of_tile,
            chromaticities: specs().any(|spec| spec.kind == Kind::Color).then(|| graph.space().chromaticities()),
            ..ExrHeader::new(window)
        };
        let place = |output: &usize| evaluated.iter().position(|evaluated| evaluated == output);
        let outputs = outputs.iter().zip(conversions);
        let outputs = outputs.filter_map(|(output, conversion)| Some((place(output)?, conversion))).collect();
        let writer = ExrWriter::create(target(&file.path, Form::Exr, graph.access().overwrites()), &header)?;
        Ok(Self { file: file.clone(), writer, outputs })
    }

    /// Adds whole bands of the file, beginning with row `y0`: the samples by evaluated output and channel.
    fn encode(&self, y0: i64, rows: &[Vec<&[f32]>], scratch: &mut Scratch) -> Result<(), OutputError> {
        let window = self.writer.band_window(0);
        let first = (y0 - window.y0) as usize / self.writer.rows_per_band();
        let mut start = 0;
        for band in first..self.writer.bands() {
            let range = start..start + self.writer.band_window(band).area();
            if rows.iter().flatten().next().is_none_or(|row| row.len() < range.end) {
                break;
            }
            scratch.converted.resize_with(self.outputs.len(), Vec::new);
            let outputs = self.outputs.iter().zip(&mut scratch.converted);
            let channels = outputs.flat_map(|((output, conversion), converted)| {
                let rows: Vec<&[f32]> = rows[*output].iter().map(|row| &row[range.clone()]).collect();
                conversion.channels(&rows, converted)
            });
            let channels: Vec<&[f32]> = channels.collect();
            self.writer.push(self.writer.encode(band, &channels, &mut scratch.encoding)?)?;
            start = range.end;
        }
        Ok(())
    }

    fn finish(self, metadata: &[(String, String)]) -> Result<(), OutputError> {
        let late = self.outputs.iter().filter_map(|(_, conversion)| conversion.metadata());
        let ExrHeader { display, data, late_metadata, .. } = *self.writer.header();
        let of_tile = (data != display).then(|| (RESERVED.into(), (late_metadata - OF_TILE).to_string()));
        Ok(self.writer.finish(&with_mark(metadata).into_iter().chain(late).chain(of_tile).collect::<Vec<_>>())?)
    }
}

/// Writes outputs of an evaluated frame as layers of an EXR file.
pub(crate) fn write_layers(
    graph: &CheckedGraph,
    frame: &Frame,
    file: &OutputFile,
    metadata: &[(String, String)],
) -> Result<(), OutputError> {
    let evaluated: Vec<usize> = frame.pictures.iter().map(|picture| picture.output).collect();
    let open = Open::create(graph, file, &evaluated, frame.window, frame.number)?;
    open.writer.each_band(|band, scratch: &mut Scratch| {
        let window = open.writer.band_window(band);
        let start = (window.y0 - frame.window.y0) as usize * frame.window.width();
        let planes = frame.pictures.iter().map(|picture| picture.planes.iter());
        let rows = planes.map(|planes| planes.map(|plane| &plane.samples()[start..start + window.area()]).collect());
        open.encode(window.y0, &rows.collect::<Vec<_>>(), scratch)
    })?;
    open.finish(metadata)
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
        let encoded = self.files.iter().try_for_each(|open| open.encode(band.y0, rows, &mut scratch));
        spare().push(scratch);
        encoded.map_err(|error| {
            let mut failure = self.failure.lock().unwrap_or_else(PoisonError::into_inner);
            EvalError::Sink(failure.get_or_insert_with(|| Arc::new(error)).clone().into())
        })
    }
}
