//! The common part of nodes that shade each sample by its normal: inputs, coverage, several lights, error bounds.

use super::{BoundedDirection, BoundedVector, Combine, Lights, Vectors3, eye, toward_eye, view_directions};
use crate::view::{NORMAL, POSITION, is_bare, is_covered, nothing, uncover, view_planes, view_vector};
use trochoid_graph::*;
use trochoid_scene::{DVec3, Projector};

/// A node with one output: a mask of how lights shade the surfaces, 0 where none is seen.
pub(crate) trait LitShader: Declare {
    /// Whether the shading depends on the eye.
    const NEEDS_EYE: bool;
    /// Channels used besides the normal, if the view supplies them.
    const OPTIONAL_CHANNELS: ChannelSet = ChannelSet::of(&POSITION);

    /// Returns the view to shade.
    fn view(&self) -> &One<port::View>;

    /// Returns the lights, and how their masks are combined.
    fn lights(&self) -> (&Many<port::Light>, Combine);

    /// Returns whether the shading depends on the lights.
    fn is_lit(&self) -> bool {
        true
    }

    /// Reports errors that the ranges of single knobs cannot express.
    fn check(&self, check: &mut Check<'_>) {
        let _ = check;
    }

    /// Fills the mask of one light over a block, from unit vectors toward it. The vectors are empty if the shading does
    /// not depend on lights.
    fn fill(&self, seen: Facing<Vectors3<'_>, &[f32]>, light: Vectors3<'_>, mask: &mut [f32]);

    /// Returns the mask of one light at one point, in f64.
    fn reference(&self, seen: Facing<DVec3, f64>, light: DVec3) -> f64;

    /// Returns the span of [`Self::reference`] over uncertain inputs.
    fn span(&self, seen: Facing<BoundedDirection, Span>, light: BoundedDirection) -> Span;
}

/// Orientation of the surface toward the eye. `V` holds vectors, `S` numbers.
#[derive(Clone, Copy)]
pub(crate) struct Facing<V, S> {
    pub(crate) normal: V,
    /// Direction toward the eye; unspecified if the shading does not depend on it.
    pub(crate) eye: V,
    /// Variance of the slopes that the pixel footprint has filtered out.
    pub(crate) variance: S,
}

/// The node type of a [`LitShader`].
#[derive(Clone)]
pub(crate) struct LitPass<T>(T);

impl<T: LitShader> Items for LitPass<T> {
    const ITEMS: &'static [Item] = T::ITEMS;

    fn read(reader: &mut Reader<'_>) -> Self {
        Self(T::read(reader))
    }
}

impl<T: LitShader> Declare for LitPass<T> {
    const DECLARATION: &'static Declaration = T::DECLARATION;
}

impl<T: LitShader> Node for LitPass<T> {
    fn check(&self, check: &mut Check<'_>) {
        self.0.check(check);
    }
}

impl<T: LitShader> Computes for LitPass<T> {
    fn body(&self) -> Body<'_> {
        Body::Stage(self)
    }
}

impl<T: LitShader> Stage for LitPass<T> {
    fn required_channels(&self, _wanted: &[bool]) -> ChannelSet {
        ChannelSet::of(&NORMAL).union(Channel::Coverage.into())
    }

    fn optional_channels(&self, _wanted: &[bool]) -> ChannelSet {
        T::OPTIONAL_CHANNELS
    }

    fn rate(&self) -> Rate {
        Rate::Surface
    }

    fn prepare(&self, prepare: &Prepare<'_>) -> Result<Box<dyn Prepared>, NodeError> {
        let (lights, combine) = self.0.lights();
        Ok(Box::new(PreparedLitPass {
            node: self.0.clone(),
            lights: Lights::of(lights, combine, prepare)?,
            eye: T::NEEDS_EYE.then(|| eye(prepare, self.0.view(), prepare.frame.format)).transpose()?,
        }))
    }
}

struct PreparedLitPass<T> {
    node: T,
    lights: Lights,
    /// The eye, if the shading depends on it.
    eye: Option<Projector>,
}

impl<T: LitShader> Prepared for PreparedLitPass<T> {
    fn fill(&self, _block: &Block<'_>, inputs: &Inputs<'_>, outputs: &mut Outputs<'_>) -> Result<(), NodeError> {
        let Some(mask) = outputs.only(0) else { return Ok(()) };
        let view = self.node.view();
        if is_bare(inputs, view) {
            mask.fill(0.0);
            return Ok(());
        }
        let eye = match &self.eye {
            Some(eye) => view_directions(inputs, view, eye, mask.len())?,
            None => Default::default(),
        };
        let seen = Facing {
            normal: view_planes(inputs, view, NORMAL),
            eye: [&eye[0][..], &eye[1], &eye[2]],
            variance: inputs.view_if_any(view, Channel::SlopeVariance).unwrap_or_default(),
        };
        if self.node.is_lit() {
            self.lights.fill(inputs, view, mask, |light, out| self.node.fill(seen, light, out))?;
        } else {
            self.node.fill(seen, [&[]; 3], mask);
        }
        uncover(inputs, view, mask);
        Ok(())
    }

    fn bound(&self, bounding: &Bounding<'_>, outputs: &mut Outputs<'_>) -> Result<(), NoBound> {
        let view = self.node.view();
        bounding.bound_by(outputs, SoleOutput, 0, |sample| {
            bounding.where_covered(view, sample, || {
                let (point, normal) =
                    (BoundedVector::point(bounding, view, sample), BoundedDirection::normal(bounding, view, sample));
                let seen = Facing {
                    normal,
                    eye: self.eye.as_ref().map_or(normal, |eye| BoundedDirection::eye(eye, point)),
                    variance: bounding.certain(view, Channel::SlopeVariance, sample),
                };
                if self.node.is_lit() {
                    self.lights.mask_span(point, |light| self.node.span(seen, light))
                } else {
                    self.node.span(seen, seen.eye).within(0.0, 1.0)
                }
            })
        });
        Ok(())
    }

    fn reference(&self, inputs: &References<'_>) -> Result<Vec<Reference>, NodeError> {
        let view = self.node.view();
        if !is_covered(inputs, view) {
            return Ok(nothing());
        }
        let [normal, point] = [NORMAL, POSITION].map(|channels| view_vector(inputs, view, channels));
        let seen = Facing {
            normal,
            eye: self.eye.as_ref().map_or(normal, |eye| toward_eye(eye, point)),
            variance: inputs.view(view, Channel::SlopeVariance),
        };
        let mask = if self.node.is_lit() {
            self.lights.reference(point, |light| self.node.reference(seen, light))
        } else {
            self.node.reference(seen, seen.eye)
        };
        Ok(vec![Reference::Mask(mask)])
    }
}
