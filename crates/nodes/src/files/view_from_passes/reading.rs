//! Reads the passes of one frame.

use super::{Pass, PassFit, PassKnob, ViewFromPasses};
use crate::files::knobs::FitBy;
use crate::files::planar::{DepthIs, Depths, Sight, Told};
use crate::files::{Fit, FoundPass, Opened, Recipe, Rows, Rule, SharedFile, Stored, Stream, find_pass};
use std::path::Path;
use trochoid_graph::*;
use trochoid_image::Window;
use trochoid_scene::Camera;

/// Reads the passes of one frame.
pub(super) struct Reading<'a> {
    pub(super) node: &'a ViewFromPasses,
    pub(super) frame: &'a FrameContext,
    pub(super) path: &'a Path,
}

impl Reading<'_> {
    pub(super) fn fit(&self, display: Window) -> Result<Fit, NodeError> {
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
    pub(super) fn pass(
        &self,
        prepare: &Prepare<'_>,
        found: &FoundPass,
        at: &[usize],
        rule: Rule,
        recipe: Option<Box<dyn Recipe>>,
        channels: Vec<Channel>,
    ) -> Result<Pass, NodeError> {
        let repair = self.node.repair;
        Ok(Pass { stream: self.stream(prepare, found, at, (rule, repair), recipe, channels.len())?, channels })
    }

    /// Returns these stored channels, validated by a rule with or without repair, as a number of channels.
    fn stream(
        &self,
        prepare: &Prepare<'_>,
        found: &FoundPass,
        at: &[usize],
        (rule, repair): (Rule, bool),
        recipe: Option<Box<dyn Recipe>>,
        outputs: usize,
    ) -> Result<Stream, NodeError> {
        let fit = self.fit(found.info.display)?;
        let stored = Stored {
            path: self.path.into(),
            part: found.info.part,
            names: found.names().full(at),
            data: found.info.data,
            rule,
            repair,
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
        Ok(Stream::new(stored, rows, recipe, outputs, fit))
    }

    /// Returns the pass of depth, and of the coverage that follows from it.
    pub(super) fn depth(&self, prepare: &Prepare<'_>) -> Result<Pass, NodeError> {
        let node = self.node;
        let [depth, position, ..] = node.passes();
        let mut channels = vec![Channel::Depth];
        channels.extend((node.covers_by() == Some(ViewFromPasses::DEPTH)).then_some(Channel::Coverage));
        let told = if self.is_told() { self.told(prepare)? } else { None };
        let is = node.stated().or(told.and_then(|told| told.kind()));
        let near = told.and_then(|told| told.near);
        let near = node.near.or(near).or(node.convention.map(|convention| convention.near() * node.scale));
        let mut found = self.scalar(depth)?;
        let mut at = found.channels.clone();
        let along = self.sight(prepare, found.info.display).filter(|_| is == Some(DepthIs::Distance));
        if along.is_some() && position.name.is_some() {
            let (points, places) = self.vector(position)?;
            if let Some(with_points) = found.with(self.frame, self.path, &points, &places)? {
                at.clone_from(&with_points.channels);
                found = with_points;
            }
        }
        let near = near.unwrap_or_default();
        let recipe = Depths { far: node.far, misses: node.misses, scale: node.scale, near, along };
        self.pass(prepare, &found, &at, Rule::Field, Some(Box::new(recipe)), channels)
    }

    /// Whether positions may tell something that counts for depth and that no knob says.
    fn is_told(&self) -> bool {
        let is_open = self.node.depth_is.is_none() && self.node.convention.is_none();
        is_open || (self.node.stated() == Some(DepthIs::Distance) && self.node.near.is_none())
    }

    /// Returns the rays of the connected camera; `None` if there is no perspective camera.
    fn sight(&self, prepare: &Prepare<'_>, display: Window) -> Option<Sight> {
        let handle = prepare.handle_of(&self.node.camera)?;
        Sight::new(handle.downcast_ref::<Camera>()?, display, self.node.up(), self.node.scale)
    }

    /// Compares depths with positions, where both and a perspective camera are known.
    ///
    /// # Errors
    /// A pass cannot be found or decoded.
    pub(super) fn told(&self, prepare: &Prepare<'_>) -> Result<Option<Told>, NodeError> {
        let node = self.node;
        let [depth, position, ..] = node.passes();
        if depth.name.is_none() || position.name.is_none() {
            return Ok(None);
        }
        let depth = self.scalar(depth)?;
        let Some(sight) = self.sight(prepare, depth.info.display) else { return Ok(None) };
        let (position, at) = self.vector(position)?;
        // Illegal samples are no errors here: nothing is taken from these streams but what the kind of depth is.
        let raw =
            |found: &FoundPass, at: &[usize]| self.stream(prepare, found, at, (Rule::Field, true), None, at.len());
        let (depth, position) = (raw(&depth, &depth.channels)?, raw(&position, &at)?);
        Told::new([&depth, &position], &sight, |depth| node.misses.has_depth(depth, node.far))
    }

    /// Finds a pass of one channel.
    pub(super) fn scalar(&self, knob: PassKnob<'_>) -> Result<FoundPass, NodeError> {
        let found = self.find(knob)?;
        if found.channels.len() != 1 {
            let expected = "one; name the channel, for example \"Combined.A\"";
            return Err(self.fault(knob, &found, expected));
        }
        Ok(found)
    }

    /// Finds a pass of three channels, and their positions.
    pub(super) fn vector(&self, knob: PassKnob<'_>) -> Result<(FoundPass, Vec<usize>), NodeError> {
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
