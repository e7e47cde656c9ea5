//! Buffers of the caller that replace nodes.

use super::buffer_fault::{BufferFault, rule};
use crate::{EvalError, Plan};
use std::collections::HashMap;
use trochoid_graph::{Kind, Slot};
use trochoid_image::Window;
use trochoid_kernel::Plane;
use trochoid_memory::Scratch;
use trochoid_weights::sums;

/// The caller's f32 buffers by node name, one slice per channel.
///
/// A picture's buffers cover its display window row by row; a batch's buffers hold one number per sample.
#[derive(Clone, Debug, Default)]
pub struct Buffers<'b> {
    planes: HashMap<String, Vec<&'b [f32]>>,
}

impl<'b> Buffers<'b> {
    /// Returns an empty set of buffers.
    pub fn new() -> Self {
        Self::default()
    }

    /// Adds the channels that replace a node's first output: three for a Color, one for a mask, n for Weights(n) and
    /// for a Field of n components. Weights(n) must sum to 1 within 0.001, and are divided by their sum.
    #[must_use]
    pub fn with(mut self, node: &str, channels: &[&'b [f32]]) -> Self {
        self.planes.insert(node.into(), channels.to_vec());
        self
    }

    /// Returns the names of the bound nodes.
    pub fn names(&self) -> Vec<&str> {
        let mut names: Vec<&str> = self.planes.keys().map(String::as_str).collect();
        names.sort_unstable();
        names
    }

    pub(crate) fn get(&self, node: &str) -> Option<&[&'b [f32]]> {
        self.planes.get(node).map(Vec::as_slice)
    }

    /// Checks the number and length of one node's buffers against its kind.
    pub(crate) fn validate(&self, node: &str, kind: Kind, length: usize) -> Result<(), EvalError> {
        let fault = |reason: BufferFault| EvalError::Buffer { node: node.into(), reason };
        let planes = self.get(node).ok_or_else(|| fault(BufferFault::None))?;
        if planes.len() != kind.channels() {
            return Err(fault(BufferFault::Channels { found: planes.len(), kind }));
        }
        for (channel, plane) in planes.iter().enumerate() {
            if plane.len() != length {
                return Err(fault(BufferFault::Length { channel, found: plane.len(), expected: length }));
            }
        }
        Ok(())
    }

    /// Checks every value of one node's buffers: the values that programs otherwise check while they run, and the
    /// sums of weights.
    pub(crate) fn validate_values(&self, node: &str, kind: Kind) -> Result<(), EvalError> {
        let planes = self.get(node).unwrap_or_default();
        for (channel, plane) in planes.iter().enumerate() {
            check(node, kind, channel, plane, 0)?;
        }
        let length = planes.first().map_or(0, |plane| plane.len());
        if let Kind::Weights(n) = kind
            && n > 2
        {
            let sum = |at: usize| planes.iter().map(|plane| f64::from(plane[at])).sum::<f64>();
            if let Some(at) = (0..length).find(|&at| sums::is_off(sum(at))) {
                let reason = BufferFault::Sum { sample: at, sum: sum(at) };
                return Err(EvalError::Buffer { node: node.into(), reason });
            }
        }
        Ok(())
    }

    /// Returns copies of the caller's masks and colors over a tile with −0 turned into 0, by index among `slots`, or the first
    /// illegal value as an error. Fields keep their zeros, which nothing checks, in every tile.
    pub(crate) fn normalized(
        &self,
        plan: &Plan<'_>,
        slots: &[Slot],
        planes: &[Plane<'_>],
        tile: Window,
    ) -> Result<Scratch<(usize, Scratch<f32>)>, EvalError> {
        let mut copies = Scratch::new();
        for (index, (slot, plane)) in slots.iter().zip(planes).enumerate().filter(|(_, (s, _))| plan.bound[s.node.0]) {
            let node = plan.graph.node(slot.node);
            let kind = node.kinds[slot.output];
            let mut copy = Scratch::new();
            for y in 0..tile.height() {
                let row = plane.row(y, tile.width());
                check(&node.name, kind, slot.channel, row, plane.start + y * plane.stride)?;
                copy.extend(row.iter().map(|v| v + 0.0));
            }
            if !matches!(kind, Kind::Field(_)) {
                copies.push((index, copy));
            }
        }
        Ok(copies)
    }
}

/// Checks samples of a buffer against its kind. `start` is the index of the first of them in the buffer.
fn check(node: &str, kind: Kind, channel: usize, samples: &[f32], start: usize) -> Result<(), EvalError> {
    let (legal, _) = rule(kind);
    match samples.iter().position(|v| !legal(v)) {
        Some(at) => {
            let (found, at) = (samples[at], start + at);
            let reason = BufferFault::Value { channel, sample: at, found, kind };
            Err(EvalError::Buffer { node: node.into(), reason })
        }
        None => Ok(()),
    }
}
