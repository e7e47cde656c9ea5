//! ViewFromPasses: what another renderer saw.

use crate::front_support::bound_exact;
use crate::io_support::{
    Fit, FoundPass, Opened, Recipe, Rows, Rule, SharedFile, Stored, Stream, find_pass, memory_of_passes,
};
use crate::scene_support::named;
use std::path::{Path, PathBuf};
use trochoid_graph::*;
use trochoid_image::Window;
use trochoid_scene::{Camera, DVec3, Projection};

/// Passes are not blended: between two objects lies neither.
const FITS: &[&str] = &["nearest", "crop"];

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
        Knob::path(
            "file",
            "The EXR; #### or %04d stands for the frame, \\# and \\% for the signs. A normal map may be a PNG.",
        )
        .item(),
        Knob::text("depth", "Layer, part or channel that holds the planar depth in meters.").item(),
        Knob::text("position", "Layer or part that holds the world position in meters.").item(),
        Knob::text("normal", "Layer or part that holds the world normal; RGB is the main layer, as a painted map's.")
            .item(),
        Knob::text("coverage", "Layer, part or channel that holds the coverage, such as Combined.A.").item(),
        Knob::choice("up", &["y", "z"], "The axis that points up in the file; z in Blender.").item(),
        Knob::bool("packed", false, "Normals are stored as (n + 1)/2, as in painted normal maps.").item(),
        Knob::number("level", 0.0, -1e9, 1e9, "World y from which heights are measured.").unit("m").item(),
        Knob::number("far", 1e4, 0.0, f32::MAX as f64, "Depth from which on it is the sky's.").unit("m").item(),
        Knob::choice("fit", FITS, "How passes of another size are laid over the picture.").optional().item(),
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
    ("depth", ChannelSet::of(&[Channel::Depth])),
    ("position", ChannelSet::of(&[Channel::PositionX, Channel::PositionY, Channel::PositionZ, Channel::Height])),
    ("normal", ChannelSet::of(&[Channel::NormalX, Channel::NormalY, Channel::NormalZ])),
    ("coverage", ChannelSet::of(&[Channel::Coverage])),
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
        given.fold(Channel::Coverage.into(), |all, (_, channels)| all.union(*channels))
    }

    fn lacks(&self) -> ChannelSet {
        let passes =
            PASSES.iter().fold(Channel::Coverage.into(), |all: ChannelSet, (_, channels)| all.union(*channels));
        ChannelSet::ALL.minus(passes)
    }

    fn interval(&self, _node: &Settled, output: usize, channel: usize) -> Option<(f64, f64)> {
        use Channel::{Coverage, NormalX, NormalY, NormalZ};
        match Channel::ALL.get(channel) {
            _ if output == 1 => Some((0.0, 1.0)),
            Some(Coverage) => Some((0.0, 1.0)),
            Some(NormalX | NormalY | NormalZ) => Some((-1.0, 1.0)),
            _ => None,
        }
    }

    fn files(&self, node: &Settled, frame: &FrameContext) -> Vec<PathBuf> {
        vec![frame.path(node.text("file"))]
    }

    fn memory(&self, node: &Settled, reckoning: &Reckoning<'_>) -> MemoryUse {
        memory_of_passes(node, reckoning)
    }

    fn examine(&self, node: &Settled, frame: &FrameContext, wanted: &[Vec<bool>]) -> Result<(), NodeError> {
        let path = named(frame, node.text("file"))?;
        let reading = Reading { node, frame, path: &path };
        for (index, (knob, _)) in PASSES.iter().enumerate().filter(|(index, _)| is_read(node, wanted)[*index]) {
            let found = if is_vector(index) { reading.vector(knob)?.0 } else { reading.scalar(knob)? };
            reading.fit(found.info.display)?;
        }
        Ok(())
    }

    fn prepare(&self, node: &Settled, prepare: &Prepare<'_>) -> Result<Box<dyn Prepared>, NodeError> {
        let path = named(prepare.frame, node.text("file"))?;
        let reading = Reading { node, frame: prepare.frame, path: &path };
        let camera = prepare.handle_of(node, "camera").or_else(level_camera);
        let mut view = View { passes: Vec::new(), camera };
        let [(depth, _), (position, places), (normal, directions), (coverage, _)] = PASSES;
        let [with_depth, with_position, with_normal, with_coverage] = is_read(node, prepare.wanted);
        if with_depth {
            // Without a pass of its own, coverage is what depth says.
            let mut channels = vec![Channel::Depth];
            channels.extend((!node.is_set(coverage)).then_some(Channel::Coverage));
            let sky = Box::new(Sky { far: node.number("far") });
            let found = reading.scalar(depth)?;
            view.passes.push(reading.pass(prepare, &found, &found.channels, Rule::Field, Some(sky), channels)?);
        }
        let mut vector = |knob: &str, channels: ChannelSet, turned: Turned| {
            let (found, at) = reading.vector(knob)?;
            let channels = channels.iter().collect();
            view.passes.push(reading.pass(prepare, &found, &at, Rule::Field, Some(Box::new(turned)), channels)?);
            Ok::<(), NodeError>(())
        };
        if with_position {
            let level = Some(node.number("level"));
            vector(position, places, Turned { z_up: reading.z_up(), unpack: |v| v, finish: |p| p, level })?;
        }
        if with_normal {
            let unpack = if node.bool("packed") { |v| 2.0 * v - 1.0 } else { |v| v };
            vector(normal, directions, Turned { z_up: reading.z_up(), unpack, finish: unit, level: None })?;
        }
        if with_coverage {
            let found = reading.scalar(coverage)?;
            let channels = vec![Channel::Coverage];
            view.passes.push(reading.pass(prepare, &found, &found.channels, Rule::Mask, None, channels)?);
        }
        Ok(Box::new(view))
    }
}

/// Which of the passes are read for what is wanted of the outputs.
fn is_read(node: &Settled, wanted: &[Vec<bool>]) -> [bool; 4] {
    let wanted = |output: usize, channel: usize| {
        wanted.get(output).and_then(|channels| channels.get(channel)).is_some_and(|wanted| *wanted)
    };
    let any = |set: ChannelSet| set.iter().any(|channel| wanted(0, channel as usize));
    let mut read = PASSES.map(|(knob, channels)| node.is_set(knob) && any(channels));
    let coverage_wanted = any(Channel::Coverage.into()) || wanted(1, 0);
    let [(depth, _), .., (coverage, _)] = PASSES;
    read[0] |= node.is_set(depth) && !node.is_set(coverage) && coverage_wanted;
    read[3] = node.is_set(coverage) && coverage_wanted;
    read
}

/// Whether a pass has three components.
fn is_vector(pass: usize) -> bool {
    matches!(pass, 1 | 2)
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

/// Depth with the sky at infinity, and what that says about coverage.
struct Sky {
    far: f64,
}

impl Recipe for Sky {
    fn apply(&self, _at: [i64; 2], lines: &mut [&mut [f32]]) -> Result<u64, NodeError> {
        let mut lines = lines.iter_mut();
        let (Some(depth), mut coverage) = (lines.next(), lines.next()) else { return Ok(0) };
        for (index, depth) in depth.iter_mut().enumerate() {
            let sky = f64::from(*depth) >= self.far;
            if let Some(coverage) = &mut coverage {
                coverage[index] = if sky { 0.0 } else { 1.0 };
            }
            if sky {
                *depth = f32::INFINITY;
            }
        }
        Ok(0)
    }
}

/// Three components, each unpacked, then turned so that y is up, then finished; and the height above a level.
struct Turned {
    z_up: bool,
    unpack: fn(f64) -> f64,
    finish: fn([f64; 3]) -> [f64; 3],
    level: Option<f64>,
}

impl Recipe for Turned {
    fn apply(&self, _at: [i64; 2], lines: &mut [&mut [f32]]) -> Result<u64, NodeError> {
        let [x, y, z, height @ ..] = lines else { return Ok(0) };
        for ((x, y), z) in x.iter_mut().zip(&mut **y).zip(&mut **z) {
            let [a, b, c] = [*x, *y, *z].map(|v| (self.unpack)(f64::from(v)));
            let turned = if self.z_up { [a, c, -b] } else { [a, b, c] };
            // Adding 0 keeps −0 out.
            [*x, *y, *z] = (self.finish)(turned).map(|v| v as f32 + 0.0);
        }
        if let ([height], Some(level)) = (height, self.level) {
            height.iter_mut().zip(&**y).for_each(|(height, y)| *height = (f64::from(*y) - level) as f32);
        }
        Ok(0)
    }
}

/// The passes of one frame.
struct Reading<'a> {
    node: &'a Settled,
    frame: &'a FrameContext,
    path: &'a Path,
}

impl Reading<'_> {
    fn z_up(&self) -> bool {
        self.node.text("up") == "z"
    }

    fn fit(&self, display: Window) -> Result<Fit, NodeError> {
        Fit::new(self.node.text("fit"), FITS, display, [self.frame.format, self.frame.whole], self.path)
    }

    fn find(&self, knob: &str) -> Result<FoundPass, NodeError> {
        find_pass(self.frame, self.path, knob, self.node.text(knob))
    }

    fn fault(&self, knob: &str, found: &FoundPass, expected: &str) -> NodeError {
        NodeError::new(format!(
            "{}: the pass \"{knob}\" is {}: found the channels {}, expected {expected}",
            self.path.display(),
            self.node.text(knob),
            found.names().some(&found.channels)
        ))
    }

    /// A pass of these stored channels.
    fn pass(
        &self,
        prepare: &Prepare<'_>,
        found: &FoundPass,
        at: &[usize],
        rule: Rule,
        recipe: Option<Box<dyn Recipe>>,
        channels: Vec<Channel>,
    ) -> Result<Pass, NodeError> {
        let fit = self.fit(found.info.display)?;
        let stored = Stored {
            path: self.path.into(),
            part: found.info.part,
            names: found.names().full(at),
            data: found.info.data,
            rule,
            repair: self.node.bool("repair"),
        };
        let rows = match Opened::new(prepare, self.path, found)? {
            Opened::Exr(reader) => {
                let (file, places) = SharedFile::of(prepare, self.path, &reader, at)?;
                Rows::File(file, places)
            }
            Opened::Picture(picture) => {
                Rows::Memory(at.iter().map(|&index| picture.channels[index].plane.clone()).collect())
            }
        };
        Ok(Pass { stream: Stream::new(stored, rows, recipe, channels.len(), fit), channels })
    }

    /// A pass of one channel.
    fn scalar(&self, knob: &str) -> Result<FoundPass, NodeError> {
        let found = self.find(knob)?;
        if found.channels.len() != 1 {
            let expected = "one; name the channel, for example \"Combined.A\"";
            return Err(self.fault(knob, &found, expected));
        }
        Ok(found)
    }

    /// A pass of three channels, and where they stand.
    fn vector(&self, knob: &str) -> Result<(FoundPass, Vec<usize>), NodeError> {
        let found = self.find(knob)?;
        let (names, all) = (found.names(), &found.channels);
        let named = names.among(all, ["X", "Y", "Z"]).or_else(|| names.among(all, ["R", "G", "B"]));
        let at = match named {
            Some(at) => at.to_vec(),
            None if all.len() == 3 => all.clone(),
            None => return Err(self.fault(knob, &found, "X, Y and Z, or R, G and B")),
        };
        Ok((found, at))
    }
}

/// Some channels of a view, read on demand.
struct Pass {
    stream: Stream,
    channels: Vec<Channel>,
}

/// The channels of a view that are read.
struct View {
    passes: Vec<Pass>,
    camera: Option<Handle>,
}

impl Prepared for View {
    fn handle(&self) -> Option<Handle> {
        self.camera.clone()
    }

    fn fill(&self, block: &Block<'_>, _inputs: &Inputs<'_>, outputs: &mut Outputs<'_>) -> Result<(), NodeError> {
        for pass in &self.passes {
            let mut outs: Vec<_> = pass.channels.iter().map(|channel| outputs.take(0, *channel as usize)).collect();
            let mut copy = None;
            if let Some(at) = pass.channels.iter().position(|channel| *channel == Channel::Coverage) {
                copy = outputs.take(1, 0).map(|copy| (at, copy));
                if outs[at].is_none() {
                    outs[at] = copy.take().map(|(_, copy)| copy);
                }
            }
            pass.stream.fill(block, &mut outs)?;
            if let Some((at, copy)) = copy
                && let Some(coverage) = &outs[at]
            {
                copy.copy_from_slice(coverage);
            }
        }
        // What no pass has filled.
        for channel in Channel::ALL {
            for plane in [outputs.take(0, channel as usize), coverage_output(channel, outputs)].into_iter().flatten() {
                plane.fill(absent(channel));
            }
        }
        Ok(())
    }

    fn bound(&self, bounding: &Bounding<'_>, outputs: &mut Outputs<'_>) -> Result<(), NoBound> {
        if !self.passes.iter().all(|pass| pass.stream.is_exact()) {
            return Err(NoBound("its passes are blended"));
        }
        bound_exact(bounding, outputs);
        Ok(())
    }

    fn reference(&self, inputs: &References<'_>) -> Result<Vec<Reference>, NodeError> {
        let mut values: Vec<f64> = Channel::ALL.iter().map(|channel| f64::from(absent(*channel))).collect();
        for pass in &self.passes {
            for (channel, value) in pass.channels.iter().zip(pass.stream.reference(inputs.at)?) {
                values[*channel as usize] = value;
            }
        }
        let coverage = values[Channel::Coverage as usize];
        Ok(vec![Reference::View(values), Reference::Mask(coverage)])
    }

    fn repaired(&self) -> u64 {
        self.passes.iter().map(|pass| pass.stream.repaired()).sum()
    }

    fn rows_per_band(&self) -> Option<usize> {
        self.passes.iter().filter_map(|pass| pass.stream.rows_per_band()).max()
    }

    fn bytes(&self) -> usize {
        self.passes.iter().map(|pass| pass.stream.bytes()).sum()
    }
}

/// The plane of the output `coverage`, at that channel.
fn coverage_output<'a>(channel: Channel, outputs: &mut Outputs<'a>) -> Option<&'a mut [f32]> {
    if channel == Channel::Coverage { outputs.take(1, 0) } else { None }
}

/// The value of a channel without a pass: everything is covered, and the rest is background.
fn absent(channel: Channel) -> f32 {
    if channel == Channel::Coverage { 1.0 } else { channel.background() }
}

#[cfg(test)]
#[path = "../io_support/view_tests.rs"]
mod tests;
