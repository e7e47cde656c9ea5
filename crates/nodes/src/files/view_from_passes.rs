//! ViewFromPasses: a view from another renderer's passes.

use crate::files::knobs::FitBy;
use crate::files::{
    Accuracy, Fit, FoundPass, Opened, Recipe, Rows, Rule, SharedFile, Stored, Stream, find_pass, memory_of_passes,
};
use crate::geometry::Up;
use crate::view::named;
use std::path::{Path, PathBuf};
use trochoid_graph::*;
use trochoid_image::Window;
use trochoid_scene::{Camera, DVec3, Projection};

/// A view made from another renderer's passes, or from a painted normal map.
///
/// # Formula
/// Depth d, or +∞ where d ≥ `far`. Position p and normal n/|n|, with (x, y, z) → (x, z, −y) if `up` is z; packed
/// normals are 2v − 1. Height is p.y − `level`. Coverage as stored; without a coverage pass, 1 where d < `far`,
/// otherwise 0.
///
/// # Edge cases
/// A degenerate normal points up. Without coverage and depth, everything is covered. Each channel depends only on its
/// own pass, so uncovered pixels keep the position stored in the file. NaN, and coverage outside [0, 1], are refused
/// with their location, or repaired and counted.
///
/// # Source
/// Blender writes 10¹⁰ (65504 in half) as the depth of the sky, and has z upward.
#[derive(Clone, Node)]
#[node(stage, end = Front, revision = 1, example = r#""depth": "depth""#, outputs = Out, role = Passes)]
#[also_called("Passes", "AOV", "AOVs", "RenderPasses", "Cryptomatte", "ReadPasses")]
pub(crate) struct ViewFromPasses {
    /// EXR file; a normal map may be a PNG. #### or %04d stands for the frame number; write \# and \% for literal
    /// signs.
    #[knob(path)]
    file: String,
    /// Layer, part or channel with the planar depth in meters.
    depth: Option<String>,
    /// Layer or part with the world-space position in meters.
    position: Option<String>,
    /// Layer or part with the world-space normal; RGB selects the main layer, as in a painted normal map.
    normal: Option<String>,
    /// Layer, part or channel with the coverage, for example Combined.A.
    coverage: Option<String>,
    /// Axis that points up in the file; z for Blender.
    up: Up,
    /// Normals are stored as (n + 1)/2, as in painted normal maps.
    #[knob(default = false)]
    packed: bool,
    /// World y from which heights are measured.
    #[knob(default = 0.0, range = -1e9..=1e9, unit = "m")]
    level: f64,
    /// Depth at and above which a pixel belongs to the sky.
    #[knob(default = 1e4, range = 0.0..=f32::MAX as f64, unit = "m")]
    far: f64,
    /// Fit of passes whose size differs from the picture's.
    fit: Option<PassFit>,
    /// Sets illegal values to the nearest legal one, and counts them.
    #[knob(default = false)]
    repair: bool,
    /// Camera of the passes; if not connected, parallel rays along −Z.
    camera: Optional<port::Camera>,
}

/// Passes are not blended: a value between two objects belongs to neither.
#[derive(Clone, Copy, Debug, PartialEq, Choice)]
enum PassFit {
    Nearest,
    Crop,
}

impl From<PassFit> for FitBy {
    fn from(fit: PassFit) -> Self {
        match fit {
            PassFit::Nearest => Self::Nearest,
            PassFit::Crop => Self::Crop,
        }
    }
}

#[derive(Clone, Copy, Debug, PartialEq, Outputs)]
enum Out {
    /// The view.
    #[output(Kind::View)]
    View,
    /// 1 where something is seen, otherwise 0.
    #[output(Kind::MASK)]
    Coverage,
}

/// A pass: the knob that names it, and the channels that it supplies.
#[derive(Clone, Copy)]
struct PassKnob<'n> {
    item: ItemName,
    name: Option<&'n str>,
    channels: ChannelSet,
}

const DEPTH: ChannelSet = ChannelSet::of(&[Channel::Depth]);
const POSITION: ChannelSet =
    ChannelSet::of(&[Channel::PositionX, Channel::PositionY, Channel::PositionZ, Channel::Height]);
const NORMAL: ChannelSet = ChannelSet::of(&[Channel::NormalX, Channel::NormalY, Channel::NormalZ]);
const COVERAGE: ChannelSet = ChannelSet::of(&[Channel::Coverage]);

/// Length below which a normal is only rounding error.
const DEGENERATE: f64 = 1e-6;

impl ViewFromPasses {
    /// Returns depth, position, normal and coverage.
    fn passes(&self) -> [PassKnob<'_>; 4] {
        [
            (Self::DEPTH, &self.depth, DEPTH),
            (Self::POSITION, &self.position, POSITION),
            (Self::NORMAL, &self.normal, NORMAL),
            (Self::COVERAGE, &self.coverage, COVERAGE),
        ]
        .map(|(item, name, channels)| PassKnob { item, name: name.as_deref(), channels })
    }

    /// Whether each pass must be read for the wanted outputs.
    fn is_read(&self, wanted: &[Vec<bool>]) -> [bool; 4] {
        let wanted = |output: Out, channel: usize| {
            wanted.get(usize::from(output)).and_then(|channels| channels.get(channel)).is_some_and(|wanted| *wanted)
        };
        let any = |set: ChannelSet| set.iter().any(|channel| wanted(Out::View, channel as usize));
        let [depth, position, normal, _] = self.passes().map(|pass| pass.name.is_some() && any(pass.channels));
        let coverage_wanted = any(COVERAGE) || wanted(Out::Coverage, 0);
        // Without a coverage pass, coverage follows from depth.
        let instead = self.depth.is_some() && self.coverage.is_none() && coverage_wanted;
        [depth || instead, position, normal, self.coverage.is_some() && coverage_wanted]
    }
}

impl Node for ViewFromPasses {
    fn check(&self, check: &mut Check<'_>) {
        if self.passes().iter().all(|pass| pass.name.is_none()) {
            let remedy = "name the layer of at least one pass";
            check.error(Self::FILE, "no pass", "depth, position, normal or coverage", remedy);
        }
    }
}

impl Stage for ViewFromPasses {
    fn supplied_channels(&self) -> ChannelSet {
        let given = self.passes().into_iter().filter(|pass| pass.name.is_some());
        given.fold(COVERAGE, |all, pass| all.union(pass.channels))
    }

    fn impossible_channels(&self) -> ChannelSet {
        ChannelSet::ALL.minus(self.passes().iter().fold(COVERAGE, |all, pass| all.union(pass.channels)))
    }

    fn interval(&self, output: usize, channel: usize) -> Option<(f64, f64)> {
        use Channel::{Coverage, NormalX, NormalY, NormalZ};
        match Out::ALL[output] {
            Out::Coverage => Some((0.0, 1.0)),
            Out::View => match Channel::ALL.get(channel) {
                Some(Coverage) => Some((0.0, 1.0)),
                Some(NormalX | NormalY | NormalZ) => Some((-1.0, 1.0)),
                _ => None,
            },
        }
    }

    fn files(&self, frame: &FrameContext) -> Vec<PathBuf> {
        vec![frame.path(&self.file)]
    }

    fn memory(&self, context: &MemoryContext<'_>) -> MemoryUse {
        memory_of_passes(&self.file, context)
    }

    fn check_headers(&self, frame: &FrameContext, wanted: &[Vec<bool>]) -> Result<(), NodeError> {
        let path = named(frame, &self.file)?;
        let reading = Reading { node: self, frame, path: &path };
        for (pass, _) in self.passes().into_iter().zip(self.is_read(wanted)).filter(|(_, read)| *read) {
            let found = if pass.is_vector() { reading.vector(pass)?.0 } else { reading.scalar(pass)? };
            reading.fit(found.info.display)?;
        }
        Ok(())
    }

    fn prepare(&self, prepare: &Prepare<'_>) -> Result<Box<dyn Prepared>, NodeError> {
        let path = named(prepare.frame, &self.file)?;
        let reading = Reading { node: self, frame: prepare.frame, path: &path };
        let camera = prepare.handle_of(&self.camera).or_else(level_camera);
        let mut view = PreparedView { passes: Vec::new(), camera };
        let [depth, position, normal, coverage] = self.passes();
        let [with_depth, with_position, with_normal, with_coverage] = self.is_read(prepare.wanted);
        if with_depth {
            let mut channels = vec![Channel::Depth];
            channels.extend(coverage.name.is_none().then_some(Channel::Coverage));
            let sky = Box::new(Sky { far: self.far });
            let found = reading.scalar(depth)?;
            view.passes.push(reading.pass(prepare, &found, &found.channels, Rule::Field, Some(sky), channels)?);
        }
        let mut vector = |pass: PassKnob<'_>, turned: Turned| {
            let (found, at) = reading.vector(pass)?;
            let channels = pass.channels.iter().collect();
            view.passes.push(reading.pass(prepare, &found, &at, Rule::Field, Some(Box::new(turned)), channels)?);
            Ok::<(), NodeError>(())
        };
        let up = self.up;
        if with_position {
            vector(position, Turned { up, unpack: |v| v, finish: |p| p, level: Some(self.level) })?;
        }
        if with_normal {
            let unpack = if self.packed { |v| 2.0 * v - 1.0 } else { |v| v };
            vector(normal, Turned { up, unpack, finish: unit, level: None })?;
        }
        if with_coverage {
            let found = reading.scalar(coverage)?;
            let channels = vec![Channel::Coverage];
            view.passes.push(reading.pass(prepare, &found, &found.channels, Rule::Mask, None, channels)?);
        }
        Ok(Box::new(view))
    }
}

impl PassKnob<'_> {
    /// Whether the pass has three components.
    fn is_vector(self) -> bool {
        self.item == ViewFromPasses::POSITION || self.item == ViewFromPasses::NORMAL
    }

    /// Returns the name given by the knob; empty if unset, but then it is not needed.
    fn name(&self) -> &str {
        self.name.unwrap_or_default()
    }
}

/// Returns the camera of a picture that was painted rather than rendered: parallel rays along −Z.
fn level_camera() -> Option<Handle> {
    Some(std::sync::Arc::new(Camera {
        position: DVec3::ZERO,
        target: DVec3::NEG_Z,
        roll: 0.0,
        projection: Projection::Orthographic { height: 1.0 },
    }))
}

/// Returns n/|n|, or up if n is degenerate.
fn unit(n: [f64; 3]) -> [f64; 3] {
    let length = n.iter().map(|v| v * v).sum::<f64>().sqrt();
    if length > DEGENERATE && length.is_finite() { n.map(|v| v / length) } else { [0.0, 1.0, 0.0] }
}

/// Recipe for depth with the sky at infinity, and for the coverage that follows from it.
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

/// Recipe for three components: unpacks them, rotates them so that y is up, and finishes them; also computes the
/// height above a level.
struct Turned {
    up: Up,
    unpack: fn(f64) -> f64,
    finish: fn([f64; 3]) -> [f64; 3],
    level: Option<f64>,
}

impl Recipe for Turned {
    fn apply(&self, _at: [i64; 2], lines: &mut [&mut [f32]]) -> Result<u64, NodeError> {
        let [x, y, z, height @ ..] = lines else { return Ok(0) };
        for ((x, y), z) in x.iter_mut().zip(&mut **y).zip(&mut **z) {
            let [a, b, c] = [*x, *y, *z].map(|v| (self.unpack)(f64::from(v)));
            let turned = self.up.to_y_up([a, b, c]);
            // Adding 0 turns −0 into 0.
            [*x, *y, *z] = (self.finish)(turned).map(|v| v as f32 + 0.0);
        }
        if let ([height], Some(level)) = (height, self.level) {
            height.iter_mut().zip(&**y).for_each(|(height, y)| *height = (f64::from(*y) - level) as f32);
        }
        Ok(0)
    }
}

/// Reads the passes of one frame.
struct Reading<'a> {
    node: &'a ViewFromPasses,
    frame: &'a FrameContext,
    path: &'a Path,
}

impl Reading<'_> {
    fn fit(&self, display: Window) -> Result<Fit, NodeError> {
        Fit::new(
            self.node.fit.map(FitBy::from),
            PassFit::WORDS,
            display,
            [self.frame.format, self.frame.document_format],
            self.path,
        )
    }

    fn find(&self, pass: PassKnob<'_>) -> Result<FoundPass, NodeError> {
        find_pass(self.frame, self.path, pass.item, pass.name())
    }

    fn fault(&self, pass: PassKnob<'_>, found: &FoundPass, expected: &str) -> NodeError {
        let (name, channels) = (pass.name(), found.names().some(&found.channels));
        let found = format_args!("{name} with the channels {channels}");
        BadData::new(found, expected, "").of_item(pass.item).in_file(self.path).into()
    }

    /// Returns the pass of these stored channels.
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
            repair: self.node.repair,
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

    /// Finds a pass of one channel.
    fn scalar(&self, knob: PassKnob<'_>) -> Result<FoundPass, NodeError> {
        let found = self.find(knob)?;
        if found.channels.len() != 1 {
            let expected = "one; name the channel, for example \"Combined.A\"";
            return Err(self.fault(knob, &found, expected));
        }
        Ok(found)
    }

    /// Finds a pass of three channels, and their positions.
    fn vector(&self, knob: PassKnob<'_>) -> Result<(FoundPass, Vec<usize>), NodeError> {
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

/// Channels of a view, read on demand.
struct Pass {
    stream: Stream,
    channels: Vec<Channel>,
}

/// The channels of a view that are read.
struct PreparedView {
    passes: Vec<Pass>,
    camera: Option<Handle>,
}

impl Prepared for PreparedView {
    fn handle(&self) -> Option<Handle> {
        self.camera.clone()
    }

    fn fill(&self, block: &Block<'_>, _inputs: &Inputs<'_>, outputs: &mut Outputs<'_>) -> Result<(), NodeError> {
        for pass in &self.passes {
            let mut outs: Vec<_> =
                pass.channels.iter().map(|channel| outputs.take(Out::View, *channel as usize)).collect();
            let mut copy = None;
            if let Some(at) = pass.channels.iter().position(|channel| *channel == Channel::Coverage) {
                copy = outputs.take(Out::Coverage, 0).map(|copy| (at, copy));
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
        // Fill the channels that no pass supplies.
        for channel in Channel::ALL {
            for plane in
                [outputs.take(Out::View, channel as usize), coverage_output(channel, outputs)].into_iter().flatten()
            {
                plane.fill(absent(channel));
            }
        }
        Ok(())
    }

    fn bound(&self, bounding: &Bounding<'_>, outputs: &mut Outputs<'_>) -> Result<(), NoBound> {
        if !self.passes.iter().all(|pass| pass.stream.accuracy() == Accuracy::Exact) {
            return Err(NoBound("its passes are blended"));
        }
        bounding.exact(outputs);
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

/// Returns the plane of the output `coverage`, for that channel.
fn coverage_output<'a>(channel: Channel, outputs: &mut Outputs<'a>) -> Option<&'a mut [f32]> {
    if channel == Channel::Coverage { outputs.take(Out::Coverage, 0) } else { None }
}

/// Returns the value of a channel without a pass: full coverage, otherwise the background.
fn absent(channel: Channel) -> f32 {
    if channel == Channel::Coverage { 1.0 } else { channel.background() }
}
