//! Read: a picture file as colors, weights or a field.

use crate::files::knobs::{As, DecodeKnobs, FileKnobs, FitBy, Knobs, SelectionKnobs};
use crate::files::{
    Accuracy, Fit, HOLDING, Holding, KeptPlane, Layer, PartialPicture, Reading, Stream, controls, memory_of_picture,
    walked,
};
use crate::filter;
use crate::view::named;
use std::path::{Path, PathBuf};
use std::sync::OnceLock;
use trochoid_graph::*;
use trochoid_image::{Rgb, Window};
use trochoid_memory::Scratch;

/// Reads a picture file: EXR, PNG, JPEG or TIFF.
///
/// # Formula
/// As color: the stored value, divided by alpha if `premultiplied`, decoded, and converted to the working space. As
/// weights: wᵢ/Σw. As field: the stored value.
///
/// # Edge cases
/// Colors must be finite and ≥ 0, weights in [0, 1] with sum 1 within 0.001, and fields not NaN. Any other value is
/// refused with its location or, with `repair`, set to the nearest legal value (NaN to 0, weights divided by their
/// sum) and counted. For weights and fields in an EXR, only the rows needed are read; of other large pictures, only
/// the pixels needed for samples are kept. Outside its data window, a picture repeats its nearest pixel. An EXR
/// without chromaticities uses those of Rec. 709; with any others, white is mapped to white (Bradford). Floating-point
/// TIFFs are linear light. Every color of the file is a control color.
///
/// # Source
/// OpenEXR, Technical Introduction; IEC 61966-2-1.
#[derive(Clone, Node)]
#[node(
    stage,
    end = Back,
    revision = 1,
    reads("a picture": "exr", "png", "jpg", "jpeg", "tif", "tiff"),
    output(image: Kind::Color or [Kind::MASK, Kind::ANY_WEIGHTS, Kind::Field(1)] = "The picture, of the kind that `as` and `channels` decide.")
)]
#[also_called("Image", "ImageRead", "ReadImage", "Load", "LoadImage", "Loader", "Input", "File", "Footage")]
#[also_called("Crop", "Reformat", "Resize", "Resample" => "its \"fit\"")]
pub(crate) struct Read {
    #[items]
    named: FileKnobs,
    #[items]
    selected: SelectionKnobs,
    /// Fit of a picture whose size differs from the document's. If unset, such a picture is refused.
    fit: Option<FitBy>,
    /// Color outside the data window; if unset, the nearest pixel repeats.
    #[knob(color)]
    outside: Option<[f64; 3]>,
    #[items]
    taken: DecodeKnobs,
}

impl Read {
    fn knobs(&self) -> Knobs<'_> {
        Knobs { named: &self.named, selected: &self.selected, taken: &self.taken, fit: self.fit }
    }

    fn reading<'a>(&'a self, frame: &'a FrameContext, path: &'a Path) -> Reading<'a> {
        let outside = self.outside.map(|color| color.map(|v| v as f32));
        Reading { knobs: self.knobs(), frame, path, outside }
    }

    /// Returns the memory of the picture if it is held so.
    pub(crate) fn memory_of(&self, context: &MemoryContext<'_>, holding: Holding) -> MemoryUse {
        memory_of_picture(self.knobs(), context, Some(holding))
    }

    /// Prepares the picture, held so.
    ///
    /// # Errors
    /// The file cannot be read, or its values are not legal.
    pub(crate) fn prepare_held(&self, prepare: &Prepare<'_>, holding: Holding) -> Result<Box<dyn Prepared>, NodeError> {
        let path = named(prepare.frame, &self.named.file)?;
        let wanted = prepare.wanted.first().map(Vec::as_slice).unwrap_or_default();
        let reading = self.reading(prepare.frame, &path);
        let (kind, outside) = (reading.knobs.kind(), reading.outside);
        if let Some(colors) = holding.on_demand
            && let Some((stream, targets)) = reading.on_demand(prepare, kind, wanted, colors)?
        {
            return Ok(Box::new(PreparedStream::new(kind, stream, targets, prepare)?));
        }
        if let Some(PartialPicture { grid, fit, planes, controls, repaired }) =
            reading.kept(prepare, kind, wanted, holding.whole)?
        {
            let mut layers: Vec<Option<Layer>> = (0..kind.channels()).map(|_| None).collect();
            for KeptPlane { channel, samples, exact } in planes {
                let outside = outside.map(|color| color[channel]);
                layers[channel] = Some(Layer::kept(grid.clone(), samples, fit, outside).with_exact(exact));
            }
            let (node, frame) = (self.clone(), prepare.frame.clone());
            let fallback = WholeFileFallback { node, frame, wanted: wanted.to_vec(), whole: OnceLock::new() };
            return Ok(Box::new(PreparedRead {
                kind,
                layers,
                controls: Some(controls),
                outside,
                repaired,
                fallback: Some(fallback),
            }));
        }
        let (layers, repaired) = whole(&reading, kind, wanted)?;
        Ok(Box::new(PreparedRead { kind, layers, controls: None, outside, repaired, fallback: None }))
    }
}

impl Node for Read {
    fn kinds(&self) -> Option<Vec<Kind>> {
        Some(vec![self.knobs().kind()])
    }

    fn check(&self, check: &mut Check<'_>) {
        self.knobs().check("a Read", self.outside.map(|_| Self::OUTSIDE), check);
    }
}

impl Stage for Read {
    fn interval(&self, _output: usize, _channel: usize) -> Option<(f64, f64)> {
        (self.named.r#as == As::Weights).then_some((0.0, 1.0))
    }

    fn files(&self, frame: &FrameContext) -> Vec<PathBuf> {
        vec![frame.path(&self.named.file)]
    }

    fn memory(&self, context: &MemoryContext<'_>) -> MemoryUse {
        self.memory_of(context, HOLDING)
    }

    fn check_headers(&self, frame: &FrameContext, wanted: &[Vec<bool>]) -> Result<(), NodeError> {
        let path = named(frame, &self.named.file)?;
        let wanted = wanted.first().map(Vec::as_slice).unwrap_or_default();
        self.reading(frame, &path).check_headers(wanted, true)
    }

    fn prepare(&self, prepare: &Prepare<'_>) -> Result<Box<dyn Prepared>, NodeError> {
        self.prepare_held(prepare, HOLDING)
    }
}

/// Reads the planes of a whole file, and returns them with the number of repaired values.
fn whole(reading: &Reading<'_>, kind: Kind, wanted: &[bool]) -> Result<(Layers, u64), NodeError> {
    let Reading { knobs, frame, path, outside } = *reading;
    let mut fit = None;
    let planes = reading.planes(kind, wanted, &mut |picture| {
        fit = Some(Fit::new(knobs.fit, FitBy::WORDS, picture.display, [frame.format, frame.document_format], path)?);
        Ok(())
    })?;
    let repaired = planes.repaired;
    let outside_of = |channel: usize| outside.map(|color| color[channel]);
    let layers = planes.channels().enumerate().map(|(channel, plane)| {
        let (plane, exact) = plane?;
        Some(Layer::new(plane, fit?, outside_of(channel)).with_exact(exact))
    });
    Ok((layers.collect(), repaired))
}

/// The channels of an output; `None` for unwanted ones.
type Layers = Vec<Option<Layer>>;

/// Reads the whole file, of which only a part was kept, when more is needed.
struct WholeFileFallback {
    node: Read,
    frame: FrameContext,
    wanted: Vec<bool>,
    whole: OnceLock<Result<Layers, NodeError>>,
}

impl WholeFileFallback {
    fn layers(&self, kind: Kind) -> Result<&Layers, NodeError> {
        let read = || {
            let path = self.frame.path(&self.node.named.file);
            whole(&self.node.reading(&self.frame, &path), kind, &self.wanted).map(|(layers, _)| layers)
        };
        self.whole.get_or_init(read).as_ref().map_err(Clone::clone)
    }
}

/// The planes of a file, ready to be sampled.
struct PreparedRead {
    kind: Kind,
    layers: Layers,
    /// The colors of a file that is not kept whole.
    controls: Option<Vec<Rgb>>,
    outside: Option<Rgb>,
    repaired: u64,
    fallback: Option<WholeFileFallback>,
}

impl PreparedRead {
    /// Returns layers that all satisfy `covered`, reading the whole file if necessary.
    fn layers(&self, covered: impl Fn(&Layer) -> bool) -> Result<&Layers, NodeError> {
        match &self.fallback {
            Some(fallback) if !self.layers.iter().flatten().all(covered) => fallback.layers(self.kind),
            _ => Ok(&self.layers),
        }
    }

    /// Returns the channels at a position, in f64.
    fn values(&self, at: [f64; 2]) -> Result<Vec<f64>, NodeError> {
        let layers = self.layers(|layer| layer.covers_place(at))?;
        Ok(layers.iter().map(|layer| layer.as_ref().map_or(0.0, |layer| layer.reference(at))).collect())
    }
}

impl Prepared for PreparedRead {
    fn controls(&self) -> Vec<Rgb> {
        if let Some(controls) = &self.controls {
            return controls.clone();
        }
        let [Some(r), Some(g), Some(b)] = &self.layers[..] else { return Vec::new() };
        if self.kind != Kind::Color {
            return Vec::new();
        }
        let mut colors = controls([r, g, b].map(Layer::samples));
        colors.extend(self.outside);
        colors
    }

    fn data_window(&self, picture: Window, _inputs: &dyn Fn(PortId) -> Window) -> Window {
        self.layers.iter().flatten().fold(picture, |window, layer| window.union(layer.window()))
    }

    fn fill(&self, block: &Block<'_>, _inputs: &Inputs<'_>, outputs: &mut Outputs<'_>) -> Result<(), NodeError> {
        for (channel, layer) in self.layers(|layer| layer.covers(block))?.iter().enumerate() {
            if let (Some(layer), Some(plane)) = (layer, outputs.only(channel)) {
                layer.fill(block, plane);
            }
        }
        Ok(())
    }

    fn bound(&self, bounding: &Bounding<'_>, outputs: &mut Outputs<'_>) -> Result<(), NoBound> {
        for channel in 0..self.layers.len() {
            bounding.bound_at(outputs, SoleOutput, channel, |at| {
                self.values(at).map_or(f64::NAN, |values| values[channel])
            });
        }
        Ok(())
    }

    fn reference(&self, inputs: &References<'_>) -> Result<Vec<Reference>, NodeError> {
        Ok(vec![filter::value(self.kind, self.values(inputs.at)?)])
    }

    fn repaired(&self) -> u64 {
        self.repaired
    }

    fn bytes(&self) -> usize {
        let whole = self.fallback.as_ref().and_then(|fallback| fallback.whole.get()?.as_ref().ok());
        let layers = self.layers.iter().chain(whole.into_iter().flatten());
        layers.flatten().map(Layer::bytes).sum()
    }
}

/// The channels of a file that is read on demand.
struct PreparedStream {
    kind: Kind,
    stream: Stream,
    /// The output's channels that the stream supplies.
    targets: Vec<usize>,
    controls: Vec<Rgb>,
}

impl PreparedStream {
    fn new(kind: Kind, stream: Stream, targets: Vec<usize>, prepare: &Prepare<'_>) -> Result<Self, NodeError> {
        let mut controls = Vec::new();
        if kind == Kind::Color {
            controls = walked(&stream, prepare.cancellation())?;
            controls.extend(stream.outside);
        }
        Ok(Self { kind, stream, targets, controls })
    }

    /// Bounds samples that are blends of pixels.
    fn bound_blends(&self, bounding: &Bounding<'_>, outputs: &mut Outputs<'_>) {
        for (index, channel) in self.targets.iter().enumerate() {
            let truth = |at| self.stream.reference(at).map_or(f64::NAN, |values| values[index]);
            bounding.bound_at(outputs, SoleOutput, *channel, truth);
        }
    }
}

impl Prepared for PreparedStream {
    fn controls(&self) -> Vec<Rgb> {
        self.controls.clone()
    }

    fn data_window(&self, picture: Window, _inputs: &dyn Fn(PortId) -> Window) -> Window {
        picture.union(self.stream.window())
    }

    fn fill(&self, block: &Block<'_>, _inputs: &Inputs<'_>, outputs: &mut Outputs<'_>) -> Result<(), NodeError> {
        let mut outs: Scratch<_> = self.targets.iter().map(|channel| outputs.only(*channel)).collect();
        self.stream.fill(block, &mut outs)
    }

    fn bound(&self, bounding: &Bounding<'_>, outputs: &mut Outputs<'_>) -> Result<(), NoBound> {
        match self.stream.accuracy() {
            Accuracy::Exact => bounding.exact(outputs),
            Accuracy::Rounded => bounding.rounded_once(outputs),
            Accuracy::Blended => self.bound_blends(bounding, outputs),
        }
        Ok(())
    }

    fn reference(&self, inputs: &References<'_>) -> Result<Vec<Reference>, NodeError> {
        let mut numbers = vec![0.0; self.kind.channels()];
        for (channel, value) in self.targets.iter().zip(self.stream.reference(inputs.at)?) {
            numbers[*channel] = value;
        }
        Ok(vec![filter::value(self.kind, numbers)])
    }

    fn repaired(&self) -> u64 {
        self.stream.repaired()
    }

    fn rows_per_band(&self) -> Option<usize> {
        self.stream.rows_per_band()
    }

    fn bytes(&self) -> usize {
        self.stream.bytes() + size_of_val(&self.controls[..])
    }
}
