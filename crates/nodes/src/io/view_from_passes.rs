//! ViewFromPasses: what another renderer saw.

use crate::io_support::{Fit, Layer, Rule, channel_names, decode_pass, positions, take};
use std::path::{Path, PathBuf};
use trochoid_graph::*;
use trochoid_image::Plane;
use trochoid_io::Picture;
use trochoid_scene::{Camera, DVec3, Projection};

pub(crate) static NODE: &dyn NodeType = &ViewFromPasses;

struct ViewFromPasses;

static DECLARATION: Declaration = Declaration {
    name: "ViewFromPasses",
    end: End::Front,
    summary: "Makes a view of another renderer's passes, or of a painted normal map.",
    formula: "Depth d, or +∞ where d ≥ `far`. Position p and normal n/|n|, with (x, y, z) → (x, z, −y) where `up` is z; \
              packed normals are 2v − 1. Height is p.y − `level`. Coverage as stored; without that pass 1 where d < `far`, else 0.",
    edge_cases: "A degenerate normal points up. Without coverage and depth everything is covered. Each channel depends \
                 on its own pass alone, so uncovered pixels keep the position that the file has there. NaN, and a \
                 coverage outside [0, 1], are refused with their place, or repaired and counted.",
    source: "Blender writes 10¹⁰ (65504 in half) as the depth of the sky, and has z upward.",
    items: &[
        Knob::path("file", "The EXR; #### or %04d stands for the frame. A normal map may be a PNG.").item(),
        Knob::text("depth", "Layer, part or channel that holds the planar depth in meters.").item(),
        Knob::text("position", "Layer or part that holds the world position in meters.").item(),
        Knob::text("normal", "Layer or part that holds the world normal.").item(),
        Knob::text("coverage", "Layer, part or channel that holds the coverage, such as Combined.A.").item(),
        Knob::choice("up", &["y", "z"], "The axis that points up in the file; z in Blender.").item(),
        Knob::bool("packed", false, "Normals are stored as (n + 1)/2, as in painted normal maps.").item(),
        Knob::number("level", 0.0, -1e9, 1e9, "World y from which heights are measured.").unit("m").item(),
        Knob::number("far", 1e4, 0.0, f32::MAX as f64, "Depth from which on it is the sky's.").unit("m").item(),
        Knob::choice("fit", &["nearest", "crop"], "How passes of another size are laid over the picture.")
            .optional()
            .item(),
        Knob::bool("repair", false, "Set illegal values to the nearest legal one, and count them.").item(),
        Port::optional("camera", Accepts::Camera, "The camera of the passes; without it, parallel rays along −Z."),
    ],
    outputs: &[
        Output::new("view", Kind::View, "The view."),
        Output::new("coverage", Kind::MASK, "Where something is seen."),
    ],
    revision: 1,
};

/// Pass by knob, and the channels that it supplies.
const PASSES: [(&str, ChannelSet); 4] = [
    ("depth", ChannelSet::of(&[ViewChannel::Depth])),
    (
        "position",
        ChannelSet::of(&[ViewChannel::PositionX, ViewChannel::PositionY, ViewChannel::PositionZ, ViewChannel::Height]),
    ),
    ("normal", ChannelSet::of(&[ViewChannel::NormalX, ViewChannel::NormalY, ViewChannel::NormalZ])),
    ("coverage", ChannelSet::of(&[ViewChannel::Coverage])),
];

/// Below this length a normal is no direction but rounding.
const DEGENERATE: f64 = 1e-6;

impl NodeType for ViewFromPasses {
    fn declaration(&self) -> &'static Declaration {
        &DECLARATION
    }

    fn check(&self, node: &Settled, check: &mut Check<'_>) {
        if !PASSES.iter().any(|(knob, _)| node.is_set(knob)) {
            let remedy = "name the layer of at least one pass";
            check.error("file", "no pass", "depth, position, normal or coverage", remedy);
        }
    }

    fn body(&self) -> Body<'_> {
        Body::Stage(self)
    }
}

impl Stage for ViewFromPasses {
    fn supplies(&self, node: &Settled) -> ChannelSet {
        let given = PASSES.iter().filter(|(knob, _)| node.is_set(knob));
        given.fold(ViewChannel::Coverage.into(), |all, (_, channels)| all.union(*channels))
    }

    fn interval(&self, _node: &Settled, output: usize, channel: usize) -> Option<(f64, f64)> {
        use ViewChannel::{Coverage, NormalX, NormalY, NormalZ};
        match ViewChannel::ALL.get(channel) {
            _ if output == 1 => Some((0.0, 1.0)),
            Some(Coverage) => Some((0.0, 1.0)),
            Some(NormalX | NormalY | NormalZ) => Some((-1.0, 1.0)),
            _ => None,
        }
    }

    fn files(&self, node: &Settled, frame: &FrameContext) -> Vec<PathBuf> {
        vec![frame.path(node.text("file"))]
    }

    fn prepare(&self, node: &Settled, prepare: &Prepare<'_>) -> Result<Box<dyn Prepared>, NodeError> {
        let wanted = |output: usize, channel: usize| {
            prepare.wanted.get(output).and_then(|channels| channels.get(channel)).is_some_and(|wanted| *wanted)
        };
        let any = |set: ChannelSet| set.iter().any(|channel| wanted(0, channel as usize));
        let path = prepare.frame.path(node.text("file"));
        let mut reading = Reading { node, frame: prepare.frame, path: &path, repaired: 0 };
        let mut view = View {
            channels: (0..ViewChannel::COUNT).map(|_| None).collect(),
            camera: prepare.handle_of(node, "camera").or_else(level_camera),
            repaired: 0,
        };
        let given = |knob: &str, set: ChannelSet| node.is_set(knob) && any(set);
        let [(depth, far), (position, places), (normal, directions), (coverage, _)] = PASSES;
        let coverage_wanted = any(ViewChannel::Coverage.into()) || wanted(1, 0);
        if given(depth, far) || (node.is_set(depth) && !node.is_set(coverage) && coverage_wanted) {
            let (depth, covered) = reading.depth()?;
            view.set(ViewChannel::Depth, Some(depth));
            view.set(ViewChannel::Coverage, Some(covered));
        }
        if given(position, places) {
            let [x, y, z] = reading.vector(position, |v| v, |p| p)?;
            let level = node.number("level");
            let height = y.map(|y| (f64::from(y) - level) as f32);
            // In the order of the channels.
            places.iter().zip([x, y, z, height]).for_each(|(channel, layer)| view.set(channel, Some(layer)));
        }
        if given(normal, directions) {
            let unpack = if node.bool("packed") { |v| 2.0 * v - 1.0 } else { |v| v };
            let normals = reading.vector(normal, unpack, unit)?;
            directions.iter().zip(normals).for_each(|(channel, layer)| view.set(channel, Some(layer)));
        }
        if node.is_set(coverage) {
            let layer = if coverage_wanted { Some(reading.scalar(coverage, Rule::Mask)?) } else { None };
            view.set(ViewChannel::Coverage, layer.map(|(plane, fit)| Layer::new(plane, fit, None)));
        }
        view.repaired = reading.repaired;
        Ok(Box::new(view))
    }
}

/// The camera of a picture that was drawn and not rendered: parallel rays along −Z.
fn level_camera() -> Option<Handle> {
    Some(std::sync::Arc::new(Camera {
        position: DVec3::ZERO,
        target: DVec3::NEG_Z,
        roll: 0.0,
        projection: Projection::Orthographic { height: 1.0 },
    }))
}

/// n/|n|; up where there is no direction.
fn unit(n: [f64; 3]) -> [f64; 3] {
    let length = n.iter().map(|v| v * v).sum::<f64>().sqrt();
    if length > DEGENERATE && length.is_finite() { n.map(|v| v / length) } else { [0.0, 1.0, 0.0] }
}

/// Reads the passes of one frame.
struct Reading<'a> {
    node: &'a Settled,
    frame: &'a FrameContext,
    path: &'a Path,
    repaired: u64,
}

impl Reading<'_> {
    fn decode(&self, knob: &str) -> Result<(Picture, Fit), NodeError> {
        let picture = decode_pass(self.frame, self.path, self.node.text(knob))?;
        let fit = Fit::new(self.node.text("fit"), picture.display, self.frame.format, self.path)?;
        Ok((picture, fit))
    }

    fn fault(&self, knob: &str, picture: &Picture, expected: &str) -> NodeError {
        NodeError::new(format!(
            "{}: the pass \"{knob}\" is {}: found the channels {}, expected {expected}",
            self.path.display(),
            self.node.text(knob),
            channel_names(picture)
        ))
    }

    /// Takes one plane, held against a rule.
    fn take(&mut self, picture: &mut Picture, at: usize, rule: Rule) -> Result<Plane, NodeError> {
        let (plane, repaired) = take(self.path, picture, at, rule, self.node.bool("repair"))?;
        self.repaired += repaired;
        Ok(plane)
    }

    fn scalar(&mut self, knob: &str, rule: Rule) -> Result<(Plane, Fit), NodeError> {
        let (mut picture, fit) = self.decode(knob)?;
        if picture.channels.len() != 1 {
            return Err(self.fault(knob, &picture, "one; name the channel, for example \"Combined.A\""));
        }
        Ok((self.take(&mut picture, 0, rule)?, fit))
    }

    /// Depth with the sky at infinity, and what that says about coverage.
    fn depth(&mut self) -> Result<(Layer, Layer), NodeError> {
        let (mut depth, fit) = self.scalar("depth", Rule::Field)?;
        let far = self.node.number("far");
        let mut covered = depth.clone();
        for (depth, covered) in depth.samples_mut().iter_mut().zip(covered.samples_mut()) {
            let sky = f64::from(*depth) >= far;
            *covered = if sky { 0.0 } else { 1.0 };
            if sky {
                *depth = f32::INFINITY;
            }
        }
        Ok((Layer::new(depth, fit, None), Layer::new(covered, fit, None)))
    }

    /// Three components, each unpacked, then turned so that y is up, then finished.
    fn vector(
        &mut self,
        knob: &str,
        unpack: fn(f64) -> f64,
        finish: fn([f64; 3]) -> [f64; 3],
    ) -> Result<[Layer; 3], NodeError> {
        let (mut picture, fit) = self.decode(knob)?;
        let named = positions(&picture, ["X", "Y", "Z"]).or_else(|| positions(&picture, ["R", "G", "B"]));
        let at = match named {
            Some(at) => at,
            None if picture.channels.len() == 3 => [0, 1, 2],
            None => return Err(self.fault(knob, &picture, "X, Y and Z, or R, G and B")),
        };
        let [mut x, mut y, mut z] = [
            self.take(&mut picture, at[0], Rule::Field)?,
            self.take(&mut picture, at[1], Rule::Field)?,
            self.take(&mut picture, at[2], Rule::Field)?,
        ];
        let z_up = self.node.text("up") == "z";
        let rows = x.samples_mut().iter_mut().zip(y.samples_mut()).zip(z.samples_mut());
        for ((x, y), z) in rows {
            let [a, b, c] = [*x, *y, *z].map(|v| unpack(f64::from(v)));
            let turned = if z_up { [a, c, -b] } else { [a, b, c] };
            // Adding 0 keeps −0 out.
            [*x, *y, *z] = finish(turned).map(|v| v as f32 + 0.0);
        }
        Ok([x, y, z].map(|plane| Layer::new(plane, fit, None)))
    }
}

/// The channels of a view that were read.
struct View {
    channels: Vec<Option<Layer>>,
    camera: Option<Handle>,
    repaired: u64,
}

impl View {
    fn set(&mut self, channel: ViewChannel, layer: Option<Layer>) {
        self.channels[channel as usize] = layer;
    }
}

impl Prepared for View {
    fn handle(&self) -> Option<Handle> {
        self.camera.clone()
    }

    fn fill(&self, block: &Block, _inputs: &Inputs<'_>, outputs: &mut Outputs<'_>) -> Result<(), NodeError> {
        for channel in ViewChannel::ALL {
            let planes = [outputs.take(0, *channel as usize), coverage_output(*channel, outputs)];
            for plane in planes.into_iter().flatten() {
                match &self.channels[*channel as usize] {
                    Some(layer) => layer.fill(block, plane),
                    None => plane.fill(absent(*channel)),
                }
            }
        }
        Ok(())
    }

    fn reference(&self, inputs: &References<'_>) -> Result<Vec<Reference>, NodeError> {
        let value = |channel: &ViewChannel| match &self.channels[*channel as usize] {
            Some(layer) => layer.reference(inputs.at),
            None => f64::from(absent(*channel)),
        };
        let values = ViewChannel::ALL.iter().map(value).collect();
        Ok(vec![Reference::View(values), Reference::Mask(value(&ViewChannel::Coverage))])
    }

    fn repaired(&self) -> u64 {
        self.repaired
    }

    fn bytes(&self) -> usize {
        self.channels.iter().flatten().map(|layer| size_of_val(layer.samples())).sum()
    }
}

/// The plane of the output `coverage`, at that channel.
fn coverage_output<'a>(channel: ViewChannel, outputs: &mut Outputs<'a>) -> Option<&'a mut [f32]> {
    if channel == ViewChannel::Coverage { outputs.take(1, 0) } else { None }
}

/// The value of a channel without a pass: everything is covered, and the rest is background.
fn absent(channel: ViewChannel) -> f32 {
    if channel == ViewChannel::Coverage { 1.0 } else { channel.background() }
}

#[cfg(test)]
#[path = "../io_support/view_tests.rs"]
mod tests;
