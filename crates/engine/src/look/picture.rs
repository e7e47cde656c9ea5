//! Pictures of a look from the passes of another renderer.

use super::illegal::{clamp, divide};
use super::samples::{Samples, checked};
use super::{Illegal, Look};
use crate::{BufferFault, Buffers, Cache, EvalError, Frame, Monitor, Pictures, Plan, PlanError, ShadeError};
use std::borrow::Cow;
use trochoid_image::Format;

/// Why a look has no picture.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
#[non_exhaustive]
pub enum PictureError {
    /// The passes have a wrong number or length.
    #[error(transparent)]
    Passes(#[from] ShadeError),
    /// The picture cannot be planned.
    #[error(transparent)]
    Plan(#[from] PlanError),
    /// The picture cannot be evaluated.
    #[error(transparent)]
    Evaluate(#[from] EvalError),
}

impl Look {
    /// Evaluates a picture of a format, whose passes are in slices: one for each channel of each slot, row by row from the
    /// top. Unlike samples, pictures may need filters, and nodes that make passes of their own.
    ///
    /// Passes with a stride of 1 are read where they are. `cache` keeps from picture to picture what does not change.
    ///
    /// # Errors
    /// Passes are missing, too short or illegal, files cannot be read, memory does not suffice, or the monitor cancels.
    pub fn picture(
        &self,
        format: Format,
        passes: &[Samples<'_>],
        cache: &mut Cache,
        monitor: &dyn Monitor,
    ) -> Result<Frame, PictureError> {
        let area = format.window().area();
        let is_used = |channel: usize| self.slots().iter().any(|slot| slot.is_used && slot.has(channel));
        checked("inputs", passes, is_used, self.inputs(), area)?;
        let is_clamped = self.illegal == Illegal::Clamp;
        let copied = passes.iter().enumerate().filter(|(at, pass)| is_used(*at) && (is_clamped || !pass.is_plane()));
        let copied = copied.count();
        self.planned(format, copied, |plan| {
            if copied > 0 {
                // Before they are made; otherwise the evaluation does this.
                plan.check_memory(&plan.memory(Pictures::Whole))?;
            }
            let used = self.slots().iter().filter(|slot| slot.is_used);
            let planes = used.map(|slot| {
                let channels = &passes[slot.first..slot.first + slot.channels()];
                let mut channels: Vec<Cow<'_, [f32]>> = channels.iter().map(|pass| pass.plane(area)).collect();
                if is_clamped {
                    channels.iter_mut().for_each(|channel| clamp(slot.kind, channel.to_mut()));
                    divide(slot.kind, &mut channels);
                }
                (slot.name.as_str(), channels)
            });
            let planes: Vec<(&str, Vec<Cow<'_, [f32]>>)> = planes.collect();
            let buffers = planes.iter().fold(Buffers::new(), |buffers, (name, channels)| {
                let channels: Vec<&[f32]> = channels.iter().map(|plane| &**plane).collect();
                buffers.with(name, &channels)
            });
            plan.evaluate(&buffers, cache, monitor).map_err(|error| self.told(error))
        })
    }

    /// Refuses a picture that would take more memory than [`Settings::memory_limit`](crate::Settings::memory_limit), beside
    /// copies of so many channels. For callers that copy passes themselves: [`picture`](Self::picture) counts its own.
    ///
    /// # Errors
    /// Memory does not suffice, or the picture cannot be planned.
    pub fn check_memory(&self, format: Format, copied: usize) -> Result<(), PictureError> {
        self.planned(format, copied, |plan| Ok(plan.check_memory(&plan.memory(Pictures::Whole))?))
    }

    /// Plans a picture with copies of so many channels beside it, and does something with the plan.
    fn planned<R>(
        &self,
        format: Format,
        copied: usize,
        run: impl FnOnce(&Plan<'_>) -> Result<R, PictureError>,
    ) -> Result<R, PictureError> {
        let inner = &*self.inner;
        let graph;
        let graph = if inner.graph.format() == format {
            &inner.graph
        } else {
            graph = inner.graph.clone().with_format(format);
            &graph
        };
        let mut settings = inner.settings.clone();
        settings.copies = (copied as u64 * size_of::<f32>() as u64).saturating_mul(format.window().area() as u64);
        let used = self.slots().iter().filter(|slot| slot.is_used);
        let bound: Vec<&str> = used.map(|slot| slot.name.as_str()).collect();
        let plan = Plan::new(graph, &[&inner.output], inner.frame, &bound, &settings)?;
        run(&plan)
    }

    /// Returns an error in the words of looks: their inputs have slots.
    fn told(&self, error: EvalError) -> PictureError {
        let (node, fault) = match error {
            EvalError::Buffer { node, reason } => (node, reason),
            error => return error.into(),
        };
        let slot = self.slots().iter().position(|slot| slot.name == node);
        match (slot, &fault) {
            (Some(slot), &(BufferFault::Value { sample, .. } | BufferFault::Sum { sample, .. })) => {
                ShadeError::Illegal { slot, name: node, sample, fault }.into()
            }
            _ => EvalError::Buffer { node, reason: fault }.into(),
        }
    }
}
