//! Knobs of surfaces that stand in the world, and what they hand on.

use crate::view::SurfaceHandle;
use std::sync::Arc;
use trochoid_graph::{
    Check, Choice, Declaration, Handle, ItemName, Items, NodeError, Prepared, Reference, References, one_of,
};
use trochoid_scene::bezier::Placement;
use trochoid_scene::{DVec3, Surface};

/// How a model stands in the world.
#[derive(Clone, Items)]
pub(crate) struct Stance {
    /// Factors along the model's own axes; first of all.
    #[knob(default = [1.0; 3])]
    scale: [f64; 3],
    /// Turns about x, then y, then z.
    #[knob(default = [0.0; 3], unit = "degrees")]
    rotate: [f64; 3],
    /// Where the model's origin comes to stand.
    #[knob(default = [0.0; 3], unit = "m")]
    translate: [f64; 3],
    /// Takes the other side for the outer one.
    #[knob(default = false)]
    pub(crate) flip: bool,
}

impl Stance {
    /// Reports a scale that leaves no surface.
    pub(crate) fn check(&self, check: &mut Check<'_>) {
        if self.scale.contains(&0.0) {
            let found = format!("{:?}", self.scale);
            check.error(Self::SCALE, found, "factors other than 0", "write a small factor to make a model flat");
        }
    }

    /// What the knobs say.
    pub(crate) fn placement(&self) -> Placement {
        let rotate = DVec3::from(self.rotate.map(f64::to_radians));
        Placement { scale: self.scale.into(), rotate, translate: self.translate.into() }
    }
}

/// The axis that points up in a file.
#[derive(Clone, Copy, Debug, PartialEq, Choice)]
pub(crate) enum Up {
    Y,
    Z,
}

impl Up {
    /// A vector of a world whose y points up as the file has it.
    #[cfg(feature = "sea")]
    pub(crate) fn of_y_up<T: std::ops::Neg<Output = T>>(self, [x, y, z]: [T; 3]) -> [T; 3] {
        match self {
            Self::Y => [x, y, z],
            Self::Z => [x, -z, y],
        }
    }

    /// A vector of the file in a world whose y points up.
    pub(crate) fn to_y_up<T: std::ops::Neg<Output = T>>(self, [x, y, z]: [T; 3]) -> [T; 3] {
        match self {
            Self::Y => [x, y, z],
            Self::Z => [x, z, -y],
        }
    }
}

/// Refuses a file that by its name another node reads, not the one declared here.
pub(crate) fn check_ending(file: &str, own: &Declaration, item: ItemName, check: &mut Check<'_>) {
    let Some(files) = own.reads.filter(|files| !files.include(file)) else { return };
    let readers = check.types().filter(|ty| ty.reads.is_some_and(|files| files.include(file)));
    let readers: Vec<&'static Declaration> = readers.collect();
    let Some(known) = readers.first().and_then(|reader| reader.reads) else { return };
    let expected = format!("a file with the ending .{}", files.endings.join(", ."));
    let remedy = format!("read it by {}, or choose another file", one_of(readers.into_iter()));
    check.error(item, format!("\"{file}\", {}", known.what), expected, remedy);
}

/// A surface at one frame.
pub(crate) struct Standing(SurfaceHandle);

impl Standing {
    pub(crate) fn new(surface: impl Surface + 'static) -> Self {
        Self(Arc::new(surface))
    }
}

impl Prepared for Standing {
    fn handle(&self) -> Option<Handle> {
        Some(Arc::new(self.0.clone()))
    }

    fn reference(&self, _inputs: &References<'_>) -> Result<Vec<Reference>, NodeError> {
        Ok(vec![Reference::Handle(Arc::new(self.0.clone()))])
    }
}
