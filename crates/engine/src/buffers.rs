//! Buffers of the caller that stand in for nodes.

use crate::EvalError;
use std::collections::HashMap;
use trochoid_graph::Kind;

/// The caller's f32 buffers by node name: for each, one slice a channel.
///
/// A picture's buffers cover its display window row by row; a batch's hold one number a sample.
#[derive(Clone, Debug, Default)]
pub struct Buffers<'b> {
    planes: HashMap<String, Vec<&'b [f32]>>,
}

impl<'b> Buffers<'b> {
    /// No buffers.
    pub fn new() -> Self {
        Self::default()
    }

    /// Adds the channels that stand in for a node's first output: three for a Color, one for a mask, n for
    /// Weights(n) and for a Field of n components.
    #[must_use]
    pub fn with(mut self, node: &str, channels: &[&'b [f32]]) -> Self {
        self.planes.insert(node.into(), channels.to_vec());
        self
    }

    /// The names bound.
    pub fn names(&self) -> Vec<&str> {
        let mut names: Vec<&str> = self.planes.keys().map(String::as_str).collect();
        names.sort_unstable();
        names
    }

    pub(crate) fn get(&self, node: &str) -> Option<&[&'b [f32]]> {
        self.planes.get(node).map(Vec::as_slice)
    }

    /// Checks one node's buffers against its kind: number, length, and values that the kind allows.
    pub(crate) fn validate(&self, node: &str, kind: Kind, length: usize) -> Result<(), EvalError> {
        let fault = |reason: String| EvalError::Buffer { node: node.into(), reason };
        let planes = self.get(node).ok_or_else(|| fault("no buffer is given: add it with Buffers::with".into()))?;
        if planes.len() != kind.channels() {
            return Err(fault(format!("found {} channels; a {kind} has {}", planes.len(), kind.channels())));
        }
        for (channel, plane) in planes.iter().enumerate() {
            if plane.len() != length {
                return Err(fault(format!("channel {channel} has {} samples; expected {length}", plane.len())));
            }
            let (legal, rule): (fn(&f32) -> bool, _) = match kind {
                Kind::Color => (|v| v.is_finite() && *v >= 0.0, "finite and ≥ 0"),
                Kind::Weights(_) => (|v| (0.0..=1.0).contains(v), "in [0, 1]"),
                _ => (|v| !v.is_nan(), "no NaN"),
            };
            if let Some(at) = plane.iter().position(|v| !legal(v)) {
                return Err(fault(format!("channel {channel} holds {} at sample {at}; a {kind} is {rule}", plane[at])));
            }
        }
        if let Kind::Weights(n) = kind
            && n > 2
        {
            let sum = |at: usize| planes.iter().map(|plane| f64::from(plane[at])).sum::<f64>();
            if let Some(at) = (0..length).find(|&at| (sum(at) - 1.0).abs() > 1e-3) {
                return Err(fault(format!("the weights of sample {at} sum to {}; expected 1", sum(at))));
            }
        }
        Ok(())
    }
}
