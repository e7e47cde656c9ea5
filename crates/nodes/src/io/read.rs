//! Read: a picture file as colors, weights or a field.

use crate::filter_support;
use crate::front_support::{bound_at, bound_exact};
use crate::io_support::{FITS, Fit, Layer, Reading, Stream, controls, knobs, walked};
use std::path::PathBuf;
use trochoid_graph::*;
use trochoid_image::{Plane, Rgb, Window};

pub(crate) static NODE: &dyn NodeType = &Read;

struct Read;

/// Colors of at most so many bytes are kept decoded: their file is read for the control colors, so that reading it on demand
/// would decode it twice.
const KEPT_COLORS: u64 = 256 << 20;

static DECLARATION: Declaration = Declaration {
    name: "Read",
    end: End::Back,
    summary: "Reads a picture file: EXR, PNG, JPEG or TIFF.",
    formula: "As color: stored value, divided by alpha if `premultiplied`, decoded, converted to the working space. \
              As weights: wᵢ/Σw. As field: the stored value.",
    edge_cases: "Colors must be finite and ≥ 0, weights in [0, 1] with sum 1 within 0.001, fields not NaN; anything \
                 else is refused with its place or, with `repair`, set to the nearest legal value (NaN to 0, weights \
                 divided by their sum) and counted. Of weights and fields in an EXR only rows that are needed are read. Outside its data window a picture repeats its nearest pixel. \
                 An EXR without chromaticities has those of Rec. 709. Every color of the file is a control color.",
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

    fn prepare(&self, node: &Settled, prepare: &Prepare<'_>) -> Result<Box<dyn Prepared>, NodeError> {
        let path = prepare.frame.path(node.text("file"));
        let wanted = prepare.wanted.first().map(Vec::as_slice).unwrap_or_default();
        let kind = knobs::kind(node);
        let outside = node.is_set("outside").then(|| node.vector3("outside").map(|v| v as f32));
        let reading = Reading { node, frame: prepare.frame, path: &path, outside };
        if let Some((stream, targets)) = reading.on_demand(prepare, kind, wanted, KEPT_COLORS)? {
            return Ok(Box::new(Streamed::new(kind, stream, targets, prepare)?));
        }
        let mut fit = None;
        let (planes, repaired) = reading.planes(kind, wanted, &mut |picture| {
            fit = Some(Fit::new(node.text("fit"), FITS, picture.display, prepare.frame.format, &path)?);
            Ok(())
        })?;
        let outside_of = |channel: usize| outside.map(|color| color[channel]);
        let layer = |(channel, plane): (usize, Option<Plane>)| Some(Layer::new(plane?, fit?, outside_of(channel)));
        let layers = planes.into_iter().enumerate().map(layer).collect();
        Ok(Box::new(Decoded { kind, layers, outside, repaired }))
    }
}

/// The planes of a file, ready to be sampled.
struct Decoded {
    kind: Kind,
    layers: Vec<Option<Layer>>,
    outside: Option<Rgb>,
    repaired: u64,
}

impl Prepared for Decoded {
    fn controls(&self) -> Vec<Rgb> {
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
        for (channel, layer) in self.layers.iter().enumerate() {
            if let (Some(layer), Some(plane)) = (layer, outputs.take(0, channel)) {
                layer.fill(block, plane);
            }
        }
        Ok(())
    }

    fn bound(&self, bounding: &Bounding<'_>, outputs: &mut Outputs<'_>) -> Result<(), NoBound> {
        for (channel, layer) in self.layers.iter().enumerate() {
            bound_at(bounding, outputs, (0, channel), |at| layer.as_ref().map_or(0.0, |layer| layer.reference(at)));
        }
        Ok(())
    }

    fn reference(&self, inputs: &References<'_>) -> Result<Vec<Reference>, NodeError> {
        let value = |layer: &Option<Layer>| layer.as_ref().map_or(0.0, |layer| layer.reference(inputs.at));
        Ok(vec![filter_support::value(self.kind, self.layers.iter().map(value).collect())])
    }

    fn repaired(&self) -> u64 {
        self.repaired
    }

    fn bytes(&self) -> usize {
        self.layers.iter().flatten().map(|layer| size_of_val(layer.samples())).sum()
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
