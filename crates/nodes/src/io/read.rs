//! Read: a picture file as colors, weights or a field.

use crate::filter_support;
use crate::front_support::{bound_at, bound_exact};
use crate::io_support::{
    FITS, Fit, KEPT_COLORS, KEPT_WHOLE, Kept, Layer, Reading, Stream, controls, knobs, memory_of_picture, walked,
};
use crate::scene_support::named;
use std::path::PathBuf;
use std::sync::OnceLock;
use trochoid_graph::*;
use trochoid_image::{Plane, Rgb, Window};

pub(crate) static NODE: &dyn NodeType = &Read;

struct Read;

static DECLARATION: Declaration = Declaration {
    name: "Read",
    end: End::Back,
    summary: "Reads a picture file: EXR, PNG, JPEG or TIFF.",
    formula: "As color: stored value, divided by alpha if `premultiplied`, decoded, converted to the working space. \
              As weights: wᵢ/Σw. As field: the stored value.",
    edge_cases: "Colors must be finite and ≥ 0, weights in [0, 1] with sum 1 within 0.001, fields not NaN; anything \
                 else is refused with its place or, with `repair`, set to the nearest legal value (NaN to 0, weights \
                 divided by their sum) and counted. Of weights and fields in an EXR only rows that are needed are read, and of other large pictures only what samples fall on is held. Outside its data window a picture repeats its nearest pixel. \
                 An EXR without chromaticities has those of Rec. 709; of any others white becomes white (Bradford). Floats of a TIFF are linear light. Every color of the file is a control color.",
    source: "OpenEXR, Technical Introduction; IEC 61966-2-1.",
    items: &[
        knobs::FILE,
        knobs::AS,
        knobs::PART,
        knobs::LAYER,
        knobs::CHANNELS,
        Knob::choice("fit", FITS, "How a picture of another size is laid over the document's.").optional().item(),
        Knob::color("outside", "Color outside the data window; by default the nearest pixel repeats.")
            .optional()
            .item(),
        knobs::REPAIR,
        knobs::PREMULTIPLIED,
        knobs::ENCODING,
    ],
    outputs: &[Output::new("image", Kind::Color, "The picture: Color, mask, Weights or Field, by `as` and channels.")],
    revision: 1,
};

impl NodeType for Read {
    fn declaration(&self) -> &'static Declaration {
        &DECLARATION
    }

    fn outputs(&self, node: &Settled) -> Vec<Kind> {
        vec![knobs::kind(node)]
    }

    fn check(&self, node: &Settled, check: &mut Check<'_>) {
        let outside: &[&str] = if node.is_set("outside") { &["outside"] } else { &[] };
        knobs::check(node, "a Read", outside, check);
    }

    fn body(&self) -> Body<'_> {
        Body::Stage(self)
    }
}

impl Stage for Read {
    fn interval(&self, node: &Settled, _output: usize, _channel: usize) -> Option<(f64, f64)> {
        (node.text("as") == "weights").then_some((0.0, 1.0))
    }

    fn files(&self, node: &Settled, frame: &FrameContext) -> Vec<PathBuf> {
        vec![frame.path(node.text("file"))]
    }

    fn memory(&self, node: &Settled, reckoning: &Reckoning<'_>) -> MemoryUse {
        memory_of_picture(node, reckoning, true)
    }

    fn examine(&self, node: &Settled, frame: &FrameContext, wanted: &[Vec<bool>]) -> Result<(), NodeError> {
        let path = named(frame, node.text("file"))?;
        let wanted = wanted.first().map(Vec::as_slice).unwrap_or_default();
        Reading { node, frame, path: &path, outside: None }.examine(wanted, true)
    }

    fn prepare(&self, node: &Settled, prepare: &Prepare<'_>) -> Result<Box<dyn Prepared>, NodeError> {
        let path = named(prepare.frame, node.text("file"))?;
        let wanted = prepare.wanted.first().map(Vec::as_slice).unwrap_or_default();
        let kind = knobs::kind(node);
        let outside = node.is_set("outside").then(|| node.vector3("outside").map(|v| v as f32));
        let reading = Reading { node, frame: prepare.frame, path: &path, outside };
        if let Some((stream, targets)) = reading.on_demand(prepare, kind, wanted, KEPT_COLORS)? {
            return Ok(Box::new(Streamed::new(kind, stream, targets, prepare)?));
        }
        if let Some(Kept { grid, fit, planes, controls, repaired }) = reading.kept(prepare, kind, wanted, KEPT_WHOLE)? {
            let mut layers: Vec<Option<Layer>> = (0..kind.channels()).map(|_| None).collect();
            for (channel, samples) in planes {
                let outside = outside.map(|color| color[channel]);
                layers[channel] = Some(Layer::kept(grid.clone(), samples, fit, outside));
            }
            let (node, frame) = (node.clone(), prepare.frame.clone());
            let again = Again { node, frame, wanted: wanted.to_vec(), whole: OnceLock::new() };
            return Ok(Box::new(Decoded {
                kind,
                layers,
                controls: Some(controls),
                outside,
                repaired,
                again: Some(again),
            }));
        }
        let (layers, repaired) = whole(&reading, kind, wanted)?;
        Ok(Box::new(Decoded { kind, layers, controls: None, outside, repaired, again: None }))
    }
}

/// The planes of a whole file, and how many values were repaired.
fn whole(reading: &Reading<'_>, kind: Kind, wanted: &[bool]) -> Result<(Layers, u64), NodeError> {
    let Reading { node, frame, path, outside } = *reading;
    let mut fit = None;
    let (planes, repaired) = reading.planes(kind, wanted, &mut |picture| {
        fit = Some(Fit::new(node.text("fit"), FITS, picture.display, [frame.format, frame.whole], path)?);
        Ok(())
    })?;
    let outside_of = |channel: usize| outside.map(|color| color[channel]);
    let layer = |(channel, plane): (usize, Option<Plane>)| Some(Layer::new(plane?, fit?, outside_of(channel)));
    Ok((planes.into_iter().enumerate().map(layer).collect(), repaired))
}

/// The channels of an output, `None` where nobody wants them.
type Layers = Vec<Option<Layer>>;

/// What it takes to read the whole of a file of which little is kept, where someone asks for more than that.
struct Again {
    node: Settled,
    frame: FrameContext,
    wanted: Vec<bool>,
    whole: OnceLock<Result<Layers, NodeError>>,
}

impl Again {
    fn layers(&self, kind: Kind, outside: Option<Rgb>) -> Result<&Layers, NodeError> {
        let read = || {
            let path = self.frame.path(self.node.text("file"));
            let reading = Reading { node: &self.node, frame: &self.frame, path: &path, outside };
            whole(&reading, kind, &self.wanted).map(|(layers, _)| layers)
        };
        self.whole.get_or_init(read).as_ref().map_err(Clone::clone)
    }
}

/// The planes of a file, ready to be sampled.
struct Decoded {
    kind: Kind,
    layers: Layers,
    /// The colors of a file that is not kept whole.
    controls: Option<Vec<Rgb>>,
    outside: Option<Rgb>,
    repaired: u64,
    again: Option<Again>,
}

impl Decoded {
    /// The layers, of which all have what is `covered`.
    fn layers(&self, covered: impl Fn(&Layer) -> bool) -> Result<&Layers, NodeError> {
        match &self.again {
            Some(again) if !self.layers.iter().flatten().all(covered) => again.layers(self.kind, self.outside),
            _ => Ok(&self.layers),
        }
    }

    /// The channels at a place, in f64.
    fn values(&self, at: [f64; 2]) -> Result<Vec<f64>, NodeError> {
        let layers = self.layers(|layer| layer.covers_place(at))?;
        Ok(layers.iter().map(|layer| layer.as_ref().map_or(0.0, |layer| layer.reference(at))).collect())
    }
}

impl Prepared for Decoded {
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

    fn data_window(&self, picture: Window, _inputs: &dyn Fn(&str) -> Window) -> Window {
        self.layers.iter().flatten().fold(picture, |window, layer| window.union(layer.window()))
    }

    fn fill(&self, block: &Block<'_>, _inputs: &Inputs<'_>, outputs: &mut Outputs<'_>) -> Result<(), NodeError> {
        for (channel, layer) in self.layers(|layer| layer.covers(block))?.iter().enumerate() {
            if let (Some(layer), Some(plane)) = (layer, outputs.take(0, channel)) {
                layer.fill(block, plane);
            }
        }
        Ok(())
    }

    fn bound(&self, bounding: &Bounding<'_>, outputs: &mut Outputs<'_>) -> Result<(), NoBound> {
        for channel in 0..self.layers.len() {
            bound_at(bounding, outputs, (0, channel), |at| self.values(at).map_or(f64::NAN, |values| values[channel]));
        }
        Ok(())
    }

    fn reference(&self, inputs: &References<'_>) -> Result<Vec<Reference>, NodeError> {
        Ok(vec![filter_support::value(self.kind, self.values(inputs.at)?)])
    }

    fn repaired(&self) -> u64 {
        self.repaired
    }

    fn bytes(&self) -> usize {
        let whole = self.again.as_ref().and_then(|again| again.whole.get()?.as_ref().ok());
        let layers = self.layers.iter().chain(whole.into_iter().flatten());
        layers.flatten().map(|layer| size_of_val(layer.samples())).sum()
    }
}

/// The channels of a file that is read on demand.
struct Streamed {
    kind: Kind,
    stream: Stream,
    /// The output's channels that the stream has.
    targets: Vec<usize>,
    controls: Vec<Rgb>,
}

impl Streamed {
    fn new(kind: Kind, stream: Stream, targets: Vec<usize>, prepare: &Prepare<'_>) -> Result<Self, NodeError> {
        let mut controls = Vec::new();
        if kind == Kind::Color {
            controls = walked(&stream, prepare.cancellation())?;
            controls.extend(stream.outside);
        }
        Ok(Self { kind, stream, targets, controls })
    }
}

impl Prepared for Streamed {
    fn controls(&self) -> Vec<Rgb> {
        self.controls.clone()
    }

    fn data_window(&self, picture: Window, _inputs: &dyn Fn(&str) -> Window) -> Window {
        picture.union(self.stream.window())
    }

    fn fill(&self, block: &Block<'_>, _inputs: &Inputs<'_>, outputs: &mut Outputs<'_>) -> Result<(), NodeError> {
        let mut outs: Vec<_> = self.targets.iter().map(|channel| outputs.take(0, *channel)).collect();
        self.stream.fill(block, &mut outs)
    }

    fn bound(&self, bounding: &Bounding<'_>, outputs: &mut Outputs<'_>) -> Result<(), NoBound> {
        if self.stream.is_exact() {
            bound_exact(bounding, outputs);
            return Ok(());
        }
        for (index, channel) in self.targets.iter().enumerate() {
            let truth = |at| self.stream.reference(at).map_or(f64::NAN, |values| values[index]);
            bound_at(bounding, outputs, (0, *channel), truth);
        }
        Ok(())
    }

    fn reference(&self, inputs: &References<'_>) -> Result<Vec<Reference>, NodeError> {
        let mut numbers = vec![0.0; self.kind.channels()];
        for (channel, value) in self.targets.iter().zip(self.stream.reference(inputs.at)?) {
            numbers[*channel] = value;
        }
        Ok(vec![filter_support::value(self.kind, numbers)])
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

#[cfg(test)]
#[path = "../io_support/read_tests.rs"]
mod tests;
