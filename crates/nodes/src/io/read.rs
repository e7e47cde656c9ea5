//! Read: a picture file as colors, weights or a field.

use crate::io_support::{FITS, Fit, Layer, Premultiplied, Rule, channel_names, convert, decode, positions, take};
use std::collections::HashSet;
use std::path::{Path, PathBuf};
use trochoid_graph::*;
use trochoid_image::{Plane, Rgb};
use trochoid_io::{Picture, Selection};
use trochoid_weights::HullBuilder;

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
                 divided by their sum) and counted. Outside its data window a picture repeats its nearest pixel. \
                 An EXR without chromaticities has those of Rec. 709. Every color of the file is a control color.",
    source: "OpenEXR, Technical Introduction; IEC 61966-2-1.",
    items: &[
        Knob::path("file", "The picture; #### or %04d stands for the frame.").item(),
        Knob::choice("as", &["color", "weights", "field"], "What the values mean.").required().item(),
        Knob::text("part", "Part of a multi-part EXR, by name or number.").item(),
        Knob::text("layer", "Layer of an EXR; by default the main one.").item(),
        Knob::texts(
            "channels",
            4096,
            "Channels in order: 1 or 3 of a color, one a weight (one alone is a mask), up to 4 of a field. \
             By default RGB of a color, the only one of others.",
        )
        .item(),
        Knob::choice("fit", FITS, "How a picture of another size is laid over the document's.").optional().item(),
        Knob::color("outside", "Color outside the data window; by default the nearest pixel repeats.")
            .optional()
            .item(),
        Knob::bool("repair", false, "Set illegal values to the nearest legal one, and count them.").item(),
        Knob::bool("premultiplied", false, "Divide by alpha; where it is 0, take the nearest covered pixel.").item(),
        Knob::choice(
            "encoding",
            &["auto", "linear", "srgb"],
            "How color is stored; auto: EXR linear, others encoded for display.",
        )
        .item(),
    ],
    outputs: &[Output::new("image", Kind::Color, "The picture: Color, mask, Weights or Field, by `as` and channels.")],
    revision: 1,
};

/// Largest difference from 1 of a sum of weights: what storing them in half can cost.
const SUM_TOLERANCE: f64 = 1e-3;

/// Control colors that are handed over one by one; of more only the vertices of their hull.
const MANY_COLORS: usize = 1 << 16;

impl NodeType for Read {
    fn declaration(&self) -> &'static Declaration {
        &DECLARATION
    }

    fn outputs(&self, node: &Settled) -> Vec<Kind> {
        let channels = node.texts("channels").len().max(1);
        vec![match node.text("as") {
            "weights" if channels == 1 => Kind::MASK,
            "weights" => Kind::Weights(channels),
            "field" => Kind::Field(channels),
            _ => Kind::Color,
        }]
    }

    fn check(&self, node: &Settled, check: &mut Check<'_>) {
        let channels = node.texts("channels").len();
        let found = format!("{channels} channels");
        match node.text("as") {
            "color" if !matches!(channels, 0 | 1 | 3) => {
                check.error("channels", found, "1 channel (gray) or 3 of a color", "list red, green and blue");
            }
            "field" if channels > 4 => {
                check.error("channels", found, "at most 4 components of a field", "read the others in another Read");
            }
            _ => {}
        }
        if node.text("as") == "color" {
            return;
        }
        let found = format!("a Read as {}", node.text("as"));
        for (item, set) in [("outside", node.is_set("outside")), ("premultiplied", node.bool("premultiplied"))] {
            if set {
                check.error(item, &found, "\"as\": \"color\"", format!("remove \"{item}\""));
            }
        }
        if node.text("encoding") == "srgb" {
            let remedy = "remove \"encoding\": weights and fields are taken as stored";
            check.error("encoding", found, "\"as\": \"color\"", remedy);
        }
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
        let kind = self.outputs(node)[0];
        let nothing = !wanted.contains(&true);
        let reading = Reading { node, frame: prepare.frame, path: &path, repair: node.bool("repair") };
        let (layers, repaired) = match kind {
            _ if nothing => ((0..kind.channels()).map(|_| None).collect(), 0),
            Kind::Color => reading.color()?,
            Kind::Field(_) => reading.field(wanted)?,
            _ => reading.weights()?,
        };
        let outside = node.is_set("outside").then(|| node.vector3("outside").map(|v| v as f32));
        Ok(Box::new(Decoded { kind, layers, outside, repaired }))
    }
}

/// One reading: the planes of the output, `None` where nobody wants them, and the number of repaired values.
struct Reading<'a> {
    node: &'a Settled,
    frame: &'a FrameContext,
    path: &'a Path,
    repair: bool,
}

type Layers = (Vec<Option<Layer>>, u64);

impl Reading<'_> {
    fn selection(&self, channels: Vec<String>) -> Selection {
        let text = |knob: &str| self.node.is_set(knob).then(|| self.node.text(knob));
        Selection { part: text("part").map(Into::into), layer: text("layer").map(Into::into), channels }
    }

    fn fit(&self, picture: &Picture) -> Result<Fit, NodeError> {
        Fit::new(self.node.text("fit"), picture.display, self.frame.format, self.path)
    }

    fn fault(&self, picture: &Picture, found: String, expected: &str) -> NodeError {
        NodeError::new(format!("{}: part {}: found {found}, expected {expected}", self.path.display(), picture.part))
    }

    /// Takes the planes at these positions of a picture, each held against a rule.
    fn take(&self, picture: &mut Picture, at: &[usize], rule: Rule) -> Result<(Vec<Plane>, u64), NodeError> {
        let mut repaired = 0;
        let mut planes = Vec::with_capacity(at.len());
        for &index in at {
            let (plane, more) = take(self.path, picture, index, rule, self.repair)?;
            planes.push(plane);
            repaired += more;
        }
        Ok((planes, repaired))
    }

    fn color(&self) -> Result<Layers, NodeError> {
        let mut channels = self.node.texts("channels").to_vec();
        let premultiplied = self.node.bool("premultiplied");
        if let Some(first) = channels.first().filter(|_| premultiplied) {
            // Alpha of the layer that the channels are of.
            let layer = first.rfind('.').map_or("", |dot| &first[..=dot]);
            channels.push(format!("{layer}A"));
        }
        let named = channels.len();
        let mut picture = decode(self.frame, self.path, &self.selection(channels))?;
        let fit = self.fit(&picture)?;
        let at = match named {
            0 => self.find_color(&picture)?,
            1 | 2 => [0; 3],
            _ => [0, 1, 2],
        };
        let alpha = match (premultiplied, named) {
            (false, _) => None,
            (true, 0) => Some(positions(&picture, ["A"]).map(|[at]| at).ok_or_else(|| {
                let expected = "a channel \"A\" to divide by; set \"premultiplied\": false";
                self.fault(&picture, format!("the channels {}", channel_names(&picture)), expected)
            })?),
            (true, _) => Some(named - 1),
        };
        let (alpha, mut repaired) = match alpha {
            Some(at) => {
                let (planes, repaired) = self.take(&mut picture, &[at], Rule::Color)?;
                (planes.into_iter().next(), repaired)
            }
            None => (None, 0),
        };
        let gray = at[0] == at[1];
        let bytes = 3 * size_of::<f32>() as u64 * picture.data.area() as u64;
        if gray && bytes > self.frame.memory_limit {
            let found = format!("a gray picture of {bytes} bytes as color");
            return Err(self.fault(&picture, found, &format!("at most {} bytes", self.frame.memory_limit)));
        }
        let stored = picture.channels[at[0]].sample_type;
        let (planes, more) = self.take(&mut picture, if gray { &at[..1] } else { &at }, Rule::Color)?;
        repaired += more;
        let mut planes: [Plane; 3] = match <[Plane; 3]>::try_from(planes) {
            Ok(planes) => planes,
            Err(gray) => [0, 1, 2].map(|_| gray[0].clone()),
        };
        let outside = self.node.is_set("outside").then(|| self.node.vector3("outside").map(|v| v as f32));
        let premultiplied = alpha.map(|alpha| Premultiplied { alpha, uncovered: outside });
        let space = (self.node.text("encoding"), self.frame.space);
        repaired += convert(self.path, &picture, stored, &mut planes, space, premultiplied.as_ref(), self.repair)?;
        let outside = |c: usize| outside.map(|color| color[c]);
        let layers = planes.into_iter().enumerate().map(|(c, plane)| Some(Layer::new(plane, fit, outside(c))));
        Ok((layers.collect(), repaired))
    }

    /// R, G and B, or the one channel besides alpha.
    fn find_color(&self, picture: &Picture) -> Result<[usize; 3], NodeError> {
        if let Some(found) = positions(picture, ["R", "G", "B"]) {
            return Ok(found);
        }
        let is_alpha = |index: &usize| picture.channels[*index].name.eq_ignore_ascii_case("A");
        let others: Vec<usize> = (0..picture.channels.len()).filter(|index| !is_alpha(index)).collect();
        match others[..] {
            [gray] => Ok([gray; 3]),
            _ => {
                let expected = "R, G and B, or one channel; name 1 or 3 of them in \"channels\"";
                Err(self.fault(picture, format!("the channels {}", channel_names(picture)), expected))
            }
        }
    }

    /// The named channels, or the only one.
    fn scalars(&self, channels: Vec<String>) -> Result<Picture, NodeError> {
        let named = !channels.is_empty();
        let picture = decode(self.frame, self.path, &self.selection(channels))?;
        if named || picture.channels.len() == 1 {
            return Ok(picture);
        }
        let found = format!("{} channels: {}", picture.channels.len(), channel_names(&picture));
        Err(self.fault(&picture, found, "one; name the ones that are meant in \"channels\""))
    }

    fn field(&self, wanted: &[bool]) -> Result<Layers, NodeError> {
        let names = self.node.texts("channels").iter().zip(wanted);
        let names: Vec<String> = names.filter(|(_, wanted)| **wanted).map(|(name, _)| name.clone()).collect();
        let mut picture = self.scalars(names)?;
        let fit = self.fit(&picture)?;
        let all: Vec<usize> = (0..picture.channels.len()).collect();
        let (planes, repaired) = self.take(&mut picture, &all, Rule::Field)?;
        let mut layers = planes.into_iter().map(|plane| Layer::new(plane, fit, None));
        Ok((wanted.iter().map(|wanted| if *wanted { layers.next() } else { None }).collect(), repaired))
    }

    fn weights(&self) -> Result<Layers, NodeError> {
        let mut picture = self.scalars(self.node.texts("channels").to_vec())?;
        let fit = self.fit(&picture)?;
        let all: Vec<usize> = (0..picture.channels.len()).collect();
        let (mut planes, mut repaired) = self.take(&mut picture, &all, Rule::Mask)?;
        if planes.len() > 1 {
            repaired += self.normalize(&picture, &mut planes)?;
        }
        if planes.len() == 2 {
            // A mask is written as the weight of its second control.
            planes.remove(0);
        }
        Ok((planes.into_iter().map(|plane| Some(Layer::new(plane, fit, None))).collect(), repaired))
    }

    /// Divides weights by their sum. Returns the number of pixels where that repaired them.
    fn normalize(&self, picture: &Picture, planes: &mut [Plane]) -> Result<u64, NodeError> {
        let window = planes[0].window();
        let equal = 1.0 / planes.len() as f64;
        let mut repaired = 0;
        for index in 0..window.area() {
            let sum: f64 = planes.iter().map(|plane| f64::from(plane.samples()[index])).sum();
            if (sum - 1.0).abs() > SUM_TOLERANCE {
                if !self.repair {
                    let (x, y) = (index % window.width(), index / window.width());
                    let (x, y) = (window.x0 + x as i64, window.y0 + y as i64);
                    let found = format!("weights in {} that sum to {sum} at pixel ({x}, {y})", channel_names(picture));
                    let expected = "the sum 1 within 0.001; set \"repair\": true to divide them by their sum";
                    return Err(self.fault(picture, found, expected));
                }
                repaired += 1;
            }
            for plane in planes.iter_mut() {
                let sample = &mut plane.samples_mut()[index];
                *sample = if sum > 0.0 { f64::from(*sample) / sum } else { equal } as f32;
            }
        }
        Ok(repaired)
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
        let mut colors: Vec<Rgb> = match distinct(r.samples(), g.samples(), b.samples()) {
            Some(colors) => colors,
            None => {
                let mut hull = HullBuilder::new();
                hull.add_row(r.samples(), g.samples(), b.samples());
                hull.finish().vertices().to_vec()
            }
        };
        colors.extend(self.outside);
        colors
    }

    fn fill(&self, block: &Block, _inputs: &Inputs<'_>, outputs: &mut Outputs<'_>) -> Result<(), NodeError> {
        for (channel, layer) in self.layers.iter().enumerate() {
            if let (Some(layer), Some(plane)) = (layer, outputs.take(0, channel)) {
                layer.fill(block, plane);
            }
        }
        Ok(())
    }

    fn reference(&self, inputs: &References<'_>) -> Result<Vec<Reference>, NodeError> {
        let value = |layer: &Option<Layer>| layer.as_ref().map_or(0.0, |layer| layer.reference(inputs.at));
        let values: Vec<f64> = self.layers.iter().map(value).collect();
        Ok(vec![match (self.kind, &values[..]) {
            (Kind::Color, &[r, g, b]) => Reference::Color([r, g, b]),
            (Kind::MASK, &[t]) => Reference::Mask(t),
            (Kind::Weights(_), _) => Reference::Weights(values),
            _ => Reference::Field(values),
        }])
    }

    fn repaired(&self) -> u64 {
        self.repaired
    }

    fn bytes(&self) -> usize {
        self.layers.iter().flatten().map(|layer| size_of_val(layer.samples())).sum()
    }
}

/// Every different color, in the order of its first pixel; `None` if there are too many to list.
fn distinct(r: &[f32], g: &[f32], b: &[f32]) -> Option<Vec<Rgb>> {
    let mut seen = HashSet::new();
    let mut colors = Vec::new();
    let mut last = None;
    for ((r, g), b) in r.iter().zip(g).zip(b) {
        let bits = [r.to_bits(), g.to_bits(), b.to_bits()];
        // Flat areas are long.
        if last.replace(bits) != Some(bits) && seen.insert(bits) {
            if colors.len() == MANY_COLORS {
                return None;
            }
            colors.push([*r, *g, *b]);
        }
    }
    Some(colors)
}

#[cfg(test)]
#[path = "../io_support/read_tests.rs"]
mod tests;
