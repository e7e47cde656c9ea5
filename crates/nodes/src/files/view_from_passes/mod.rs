//! ViewFromPasses: a view from another renderer's passes.

mod reading;

use crate::files::knobs::FitBy;
use crate::files::planar::{Convention, DepthIs, Misses};
use crate::files::turned::{Fourth, Turned, unit};
use crate::files::{Accuracy, Rule, Stream, memory_of_passes};
use crate::geometry::Up;
use crate::view::named;
use reading::Reading;
use std::path::PathBuf;
use trochoid_graph::*;
use trochoid_memory::Scratch;
use trochoid_scene::{Camera, DVec3, Projection};

/// A view made from another renderer's passes, or from a painted normal map.
///
/// # Formula
/// Depth d·`scale`, or +∞ at misses; of a distance along the ray, its part along the camera's axis, plus `near`: times
/// (p − c)·f/|p − c|, with the camera at c and its axis f, at the stored position p if that is in the same part as 32-bit
/// floats, otherwise at the middle of the pixel. Position p·`scale` and normal n/|n|, with (x, y, z) → (x, z, −y) if `up` is z; packed
/// normals are 2v − 1. Height is p.y − `level`. Coverage as stored; without a coverage pass, 0 at misses, otherwise 1.
///
/// # Edge cases
/// Misses by "auto": a depth of 0, or of `far` or more; in a file without depth, the normal (0, 0, 0) unless normals are
/// packed. "far" and "zero" are one of the two alone, "none" is neither. Without coverage, depth and normal, everything is
/// covered. If `depth_is` is unset, the kind is told by comparing depths with positions as seen from a connected
/// perspective camera, in up to 1024 pixels; where nothing can be told, depth is planar. `trochoid check` says what was
/// found.
///
/// A degenerate normal points up. Each channel depends only on its own pass, so uncovered pixels keep the position stored
/// in the file. NaN, and coverage outside [0, 1], are refused with their location, or repaired and counted.
///
/// # Source
/// Blender 5.0 (Cycles) writes 10¹⁰ (65504 in half) as the depth of the sky, planar depth, and has z upward. Mitsuba 3,
/// manual of the integrator aov: depth is the distance from the pinhole; all that is missed is 0. In its files the
/// distance begins at the near clipping plane, as measured with 3.9.1.
#[derive(Clone, Node)]
#[node(stage, end = Front, revision = 2, example = r#""depth": "depth""#, outputs = Out, role = Passes)]
#[also_called("Passes", "AOV", "AOVs", "RenderPasses", "ReadPasses")]
pub(crate) struct ViewFromPasses {
    /// EXR file; a normal map may be a PNG. #### or %04d stands for the frame number; write \# and \% for literal
    /// signs.
    #[knob(path)]
    file: String,
    /// Layer, part or channel with the depth.
    depth: Option<String>,
    /// Layer or part with the world-space position.
    position: Option<String>,
    /// Layer or part with the world-space normal; RGB selects the main layer, as in a painted normal map.
    normal: Option<String>,
    /// Layer, part or channel with the coverage, for example Combined.A.
    coverage: Option<String>,
    /// Renderer whose conventions hold for `up` and `depth_is` where they are not set: "blender" has z up and planar
    /// depth, "mitsuba" has y up and distances.
    convention: Option<Convention>,
    /// Axis that points up in the file; if unset, that of the convention, otherwise y.
    up: Option<Up>,
    /// What depth measures: the distance along the camera's axis ("planar") or along the ray ("distance"). If unset, as the
    /// convention has it; otherwise it is told from positions and the camera.
    depth_is: Option<DepthIs>,
    /// Planar depth at which distances along the ray begin: Mitsuba measures them from the near clipping plane. If unset, it is
    /// told from positions and the camera, otherwise 0.01 units with "mitsuba", and 0 without.
    #[knob(range = 0.0..=1e9, unit = "m")]
    near: Option<f64>,
    /// Which pixels see nothing: "auto", those with a depth of 0 or of `far` and more ("zero", "far": one of the two), or
    /// "none".
    misses: Misses,
    /// Meters in one unit of the file's depth and position; 0.01 for centimeters.
    #[knob(default = 1.0, range = 1e-6..=1e6, unit = "m")]
    scale: f64,
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
    /// Camera of the passes, in meters with y up; if not connected, parallel rays along −Z.
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
        let instead = |from| coverage_wanted && self.covers_by() == Some(from);
        [depth || instead(Self::DEPTH), position, normal || instead(Self::NORMAL), instead(Self::COVERAGE)]
    }

    /// Returns the pass that tells what is covered; `None` if everything is.
    fn covers_by(&self) -> Option<ItemName> {
        match (&self.coverage, &self.depth, &self.normal) {
            (Some(_), ..) => Some(Self::COVERAGE),
            (None, Some(_), _) => Some(Self::DEPTH),
            (None, None, Some(_)) if self.misses.has_no_normal(self.packed) => Some(Self::NORMAL),
            _ => None,
        }
    }

    /// Whether positions, as seen from a connected camera, may count for depth.
    fn positions_count(&self, depth: PassKnob<'_>, position: PassKnob<'_>) -> bool {
        let is_open = self.stated() != Some(DepthIs::Planar);
        is_open && depth.name.is_some() && position.name.is_some() && !self.camera.sources().is_empty()
    }

    fn up(&self) -> Up {
        self.up.or(self.convention.map(Convention::up)).unwrap_or(Up::Y)
    }

    /// Returns what depth measures, if the document says it.
    fn stated(&self) -> Option<DepthIs> {
        self.depth_is.or(self.convention.map(Convention::depth_is))
    }
}

impl Node for ViewFromPasses {
    fn check(&self, check: &mut Check<'_>) {
        if self.passes().iter().all(|pass| pass.name.is_none()) {
            let remedy = "name the layer of at least one pass";
            check.error(Self::FILE, "no pass", "depth, position, normal or coverage", remedy);
        }
        let knob = if self.depth_is.is_some() { Self::DEPTH_IS } else { Self::CONVENTION };
        let is_distance = self.depth.is_some() && self.stated() == Some(DepthIs::Distance);
        if is_distance && self.camera.sources().is_empty() {
            let remedy = "connect \"camera\", or set \"depth_is\": \"planar\"";
            check.error(knob, "depth along the ray without a camera", "the camera of the passes", remedy);
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
        let [depth, position, ..] = self.passes();
        if self.is_read(wanted)[0] && self.positions_count(depth, position) {
            reading.vector(position)?;
        }
        Ok(())
    }

    fn file_notes(&self, prepare: &Prepare<'_>) -> Vec<String> {
        let Ok(path) = named(prepare.frame, &self.file) else { return Vec::new() };
        let reading = Reading { node: self, frame: prepare.frame, path: &path };
        // What is wrong with the file is reported as its error.
        let told = reading.told(prepare).unwrap_or_default();
        told.and_then(|told| told.note(self.stated())).into_iter().collect()
    }

    fn prepare(&self, prepare: &Prepare<'_>) -> Result<Box<dyn Prepared>, NodeError> {
        let path = named(prepare.frame, &self.file)?;
        let reading = Reading { node: self, frame: prepare.frame, path: &path };
        let camera = prepare.handle_of(&self.camera).or_else(level_camera);
        let mut view = PreparedView { passes: Vec::new(), camera };
        let [_, position, normal, coverage] = self.passes();
        let [with_depth, with_position, with_normal, with_coverage] = self.is_read(prepare.wanted);
        if with_depth {
            view.passes.push(reading.depth(prepare)?);
        }
        let mut vector = |pass: PassKnob<'_>, turned: Turned| {
            let (found, at) = reading.vector(pass)?;
            let mut channels: Vec<Channel> = pass.channels.iter().collect();
            channels.extend(matches!(turned.fourth, Fourth::Coverage).then_some(Channel::Coverage));
            view.passes.push(reading.pass(prepare, &found, &at, Rule::Field, Some(Box::new(turned)), channels)?);
            Ok::<(), NodeError>(())
        };
        let up = self.up();
        if with_position {
            let (scale, fourth) = (self.scale, Fourth::Height(self.level));
            vector(position, Turned { up, unpack: |v| v, finish: |p| p, scale, fourth })?;
        }
        if with_normal {
            let unpack = if self.packed { |v| 2.0 * v - 1.0 } else { |v| v };
            let fourth = if self.covers_by() == Some(Self::NORMAL) { Fourth::Coverage } else { Fourth::None };
            vector(normal, Turned { up, unpack, finish: unit, scale: 1.0, fourth })?;
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
            let mut outs: Scratch<_> =
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
        for pass in &self.passes {
            match pass.stream.accuracy() {
                Accuracy::Exact => {}
                Accuracy::Blended => return Err(NoBound("its passes are blended")),
                Accuracy::Rounded => {
                    for (index, channel) in pass.channels.iter().enumerate() {
                        let truth = |at| pass.stream.reference(at).map_or(f64::NAN, |values| values[index]);
                        bounding.bound_at(outputs, Out::View, *channel as usize, truth);
                    }
                }
            }
        }
        // Coverage is 0 or 1, and all else is as stored.
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
