//! Passes of how lights shade what is seen, each sample by its normal.

use super::{Combine, Lights, Near, Toward, Vectors3, eye, toward_eye, view_directions};
use crate::view::{NORMAL, POSITION, is_bare, is_covered, nothing, uncover, view_planes, view_vector};
use trochoid_graph::*;
use trochoid_scene::{DVec3, Projector};

/// A node whose one output is a mask of what lights do where something is seen, and 0 elsewhere.
pub(crate) trait Shades: Declare {
    /// Whether it matters where the eye is.
    const LOOKS: bool;
    /// What counts beside the normal, where the view supplies it.
    const PREFERS: ChannelSet = ChannelSet::of(&POSITION);

    /// What is lit.
    fn view(&self) -> &One<port::View>;

    /// Its lights, and how their masks become one.
    fn lights(&self) -> (&Many<port::Light>, Combine);

    /// Whether lights count.
    fn is_lit(&self) -> bool {
        true
    }

    /// Reports what ranges of single knobs cannot express.
    fn check(&self, check: &mut Check<'_>) {
        let _ = check;
    }

    /// The masks of one light over a block, from unit vectors toward it; of none where lights do not count.
    fn fill(&self, seen: Facing<Vectors3<'_>, &[f32]>, light: Vectors3<'_>, mask: &mut [f32]);

    /// The mask of one light at one point, in f64.
    fn reference(&self, seen: Facing<DVec3, f64>, light: DVec3) -> f64;

    /// What that may be.
    fn span(&self, seen: Facing<Toward, Span>, light: Toward) -> Span;
}

/// How what is seen stands to the eye: `V` holds vectors, `S` numbers.
#[derive(Clone, Copy)]
pub(crate) struct Facing<V, S> {
    pub(crate) normal: V,
    /// Toward the eye; nothing of use where it does not matter.
    pub(crate) eye: V,
    /// Of the slopes that the footprint took away.
    pub(crate) variance: S,
}

/// Such a node.
#[derive(Clone)]
pub(crate) struct LitPass<T>(T);

impl<T: Shades> Items for LitPass<T> {
    const ITEMS: &'static [Item] = T::ITEMS;

    fn read(reader: &mut Reader<'_>) -> Self {
        Self(T::read(reader))
    }
}

impl<T: Shades> Declare for LitPass<T> {
    const DECLARATION: &'static Declaration = T::DECLARATION;
}

impl<T: Shades> Node for LitPass<T> {
    fn check(&self, check: &mut Check<'_>) {
        self.0.check(check);
    }

    fn body(&self) -> Body<'_> {
        Body::Stage(self)
    }
}

impl<T: Shades> Stage for LitPass<T> {
    fn asks(&self, _wanted: &[bool]) -> ChannelSet {
        ChannelSet::of(&NORMAL).union(Channel::Coverage.into())
    }

    fn prefers(&self, _wanted: &[bool]) -> ChannelSet {
        T::PREFERS
    }

    fn rate(&self) -> Rate {
        Rate::Surface
    }

    fn prepare(&self, prepare: &Prepare<'_>) -> Result<Box<dyn Prepared>, NodeError> {
        let (lights, combine) = self.0.lights();
        Ok(Box::new(PreparedPass {
            node: self.0.clone(),
            lights: Lights::of(lights, combine, prepare)?,
            eye: T::LOOKS.then(|| eye(prepare, self.0.view(), prepare.frame.format)).transpose()?,
        }))
    }
}

struct PreparedPass<T> {
    node: T,
    lights: Lights,
    /// Where it matters.
    eye: Option<Projector>,
}

impl<T: Shades> Prepared for PreparedPass<T> {
    fn fill(&self, _block: &Block<'_>, inputs: &Inputs<'_>, outputs: &mut Outputs<'_>) -> Result<(), NodeError> {
        let Some(mask) = outputs.only(0) else { return Ok(()) };
        let view = self.node.view();
        if is_bare(inputs, view) {
            mask.fill(0.0);
            return Ok(());
        }
        let eye = match &self.eye {
            Some(eye) => view_directions(inputs, view, eye, mask.len())?,
            None => [const { Vec::new() }; 3],
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
        bounding.bound_by(outputs, (Only, 0), |sample| {
            bounding.where_covered(view, sample, || {
                let (point, normal) = (Near::point(bounding, view, sample), Toward::normal(bounding, view, sample));
                let seen = Facing {
                    normal,
                    eye: self.eye.as_ref().map_or(normal, |eye| Toward::eye(eye, point)),
                    variance: bounding.certain(view, Channel::SlopeVariance, sample),
                };
                if self.node.is_lit() {
                    self.lights.may_give(point, |light| self.node.span(seen, light))
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
