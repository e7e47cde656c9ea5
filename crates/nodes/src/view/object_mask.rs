//! ObjectMask: where chosen surfaces are seen.

use super::{Render, RenderHandle, SurfaceHandle};
use crate::sea::check_indices;
use std::sync::Arc;
use trochoid_graph::*;

/// A mask of chosen surfaces: 1 where one of them is seen.
///
/// # Formula
/// 1 where the seen surface is one of `surfaces`, or has one of `indices` in the Render's list
///
/// # Edge cases
/// 0 where nothing is seen, and everywhere for surfaces not in the view.
///
/// # Source
/// The standard object ID pass (cryptomattes of one level).
#[derive(Clone, Node)]
#[node(
    stage, end = Front, revision = 1,
    example = r#""surfaces": ["sea"]"#,
    output(mask: Kind::MASK = "1 where a chosen surface is seen.")
)]
pub(crate) struct ObjectMask {
    /// View of the surfaces.
    view: One<port::View>,
    /// Chosen surfaces, by the names of their nodes.
    #[port(0..=64)]
    surfaces: Many<port::Surface>,
    /// Chosen surfaces, by their indices in the Render's list, counted from 0.
    #[knob(len = 1..=64)]
    indices: Option<Vec<f64>>,
}

impl Node for ObjectMask {
    fn check(&self, check: &mut Check<'_>) {
        let indices = self.indices.as_deref().unwrap_or_default();
        if self.surfaces.is_empty() && indices.is_empty() {
            check.error(Self::SURFACES, "no surface", "at least one", "name the surface's node, or set \"indices\"");
        }
        if let Some(index) = indices.iter().find(|index| index.fract() != 0.0 || !(0.0..64.0).contains(*index)) {
            check.error(
                Self::INDICES,
                index.to_string(),
                "whole numbers from 0 to 63",
                "write the surface's index in the list",
            );
        } else {
            check_indices(&self.view, Self::INDICES, indices.iter().copied(), check);
        }
        let Some(view) = check.upstream(&self.view) else { return };
        let Some(Render { surfaces: held, .. }) = view.node.get() else { return };
        let strangers = self.surfaces.iter().filter(|chosen| !held.contains(chosen));
        let names: Vec<String> =
            strangers.filter_map(|source| Some(format!("\"{}\"", check.upstream(source)?.name))).collect();
        if !names.is_empty() {
            let found = format!("{}, not among the surfaces of \"{}\"", names.join(", "), view.name);
            let remedy = format!("add it to the surfaces of \"{}\", or choose one of them", view.name);
            check.warning(Self::SURFACES, found, "surfaces of the view", remedy);
        }
    }
}

impl Stage for ObjectMask {
    fn required_channels(&self, _wanted: &[bool]) -> ChannelSet {
        Channel::Surface.into()
    }

    fn rate(&self) -> Rate {
        Rate::Surface
    }

    fn prepare(&self, prepare: &Prepare<'_>) -> Result<Box<dyn Prepared>, NodeError> {
        let chosen: Vec<SurfaceHandle> = prepare.handles(&self.surfaces)?;
        let mut indices: Vec<f32> = self.indices.iter().flatten().map(|index| *index as f32).collect();
        if !chosen.is_empty() {
            let handle = prepare.handle_of(&self.view);
            let Some(view) = handle.as_deref().and_then(|handle| handle.downcast_ref::<RenderHandle>()) else {
                let remedy = "use \"indices\", or view a Render";
                return Err(BadData::new("a view of passes", "a view of surfaces", remedy).into());
            };
            let held = view.surfaces.iter().enumerate();
            indices.extend(
                held.filter(|(_, held)| chosen.iter().any(|chosen| Arc::ptr_eq(chosen, held)))
                    .map(|(index, _)| index as f32),
            );
        }
        Ok(Box::new(PreparedObjectMask { view: self.view.clone(), indices }))
    }
}

struct PreparedObjectMask {
    view: One<port::View>,
    indices: Vec<f32>,
}

impl PreparedObjectMask {
    fn mask(&self, surface: f32) -> f32 {
        if self.indices.contains(&surface) { 1.0 } else { 0.0 }
    }
}

impl Prepared for PreparedObjectMask {
    fn fill(&self, _block: &Block<'_>, inputs: &Inputs<'_>, outputs: &mut Outputs<'_>) -> Result<(), NodeError> {
        let Some(mask) = outputs.only(0) else { return Ok(()) };
        let surfaces = inputs.view(&self.view, Channel::Surface);
        // Surface by surface rather than sample by sample, for vector code.
        let Some((first, others)) = self.indices.split_first() else {
            mask.fill(0.0);
            return Ok(());
        };
        for (mask, surface) in mask.iter_mut().zip(surfaces) {
            *mask = if *surface == *first { 1.0 } else { 0.0 };
        }
        for index in others {
            for (mask, surface) in mask.iter_mut().zip(surfaces) {
                *mask = if *surface == *index { 1.0 } else { *mask };
            }
        }
        Ok(())
    }

    fn bound(&self, bounding: &Bounding<'_>, outputs: &mut Outputs<'_>) -> Result<(), NoBound> {
        bounding.bound_by(outputs, SoleOutput, 0, |sample| {
            let surface = bounding.certain(&self.view, Channel::Surface, sample);
            if surface.low == surface.high {
                Span::exactly(f64::from(self.mask(surface.low as f32)))
            } else if self.indices.iter().any(|index| surface.holds(f64::from(*index))) {
                Span::unclear(0.0, 1.0)
            } else {
                // The seen surface is certainly not a chosen one.
                Span::exactly(0.0)
            }
        });
        Ok(())
    }

    fn reference(&self, inputs: &References<'_>) -> Result<Vec<Reference>, NodeError> {
        let surface = inputs.view(&self.view, Channel::Surface);
        Ok(vec![Reference::Mask(f64::from(self.mask(surface as f32)))])
    }
}
