//! Placement knobs of surfaces, and the handle that they output.

use crate::view::SurfaceHandle;
use std::sync::Arc;
use trochoid_graph::{
    Check, Choice, Declaration, Handle, ItemName, Items, NodeError, Prepared, Reference, References, one_of,
};
use trochoid_scene::bezier::Placement;
use trochoid_scene::{DVec3, Surface};

/// Placement of a model in the world.
#[derive(Clone, Items)]
pub(crate) struct PlacementKnobs {
    /// Scale factors along the model's own axes, applied first.
    #[knob(default = [1.0; 3], places = Scale)]
    scale: [f64; 3],
    /// Rotations about x, then y, then z.
    #[knob(default = [0.0; 3], unit = "degrees", places = Rotation)]
    rotate: [f64; 3],
    /// World position of the model's origin.
    #[knob(default = [0.0; 3], unit = "m", places = Position)]
    translate: [f64; 3],
    /// Turns the surface inside out.
    #[knob(default = false)]
    pub(crate) flip: bool,
}

impl PlacementKnobs {
    /// Reports a scale that flattens the surface completely.
    pub(crate) fn check(&self, check: &mut Check<'_>) {
        if self.scale.contains(&0.0) {
            let found = format!("{:?}", self.scale);
            check.error(Self::SCALE, found, "factors other than 0", "use a small factor to flatten a model");
        }
    }

    /// Returns the placement that the knobs describe.
    pub(crate) fn placement(&self) -> Placement {
        let rotate = DVec3::from(self.rotate.map(f64::to_radians));
        Placement { scale: self.scale.into(), rotate, translate: self.translate.into() }
    }
}

/// Axis that points up in a file.
#[derive(Clone, Copy, Debug, PartialEq, Choice)]
pub(crate) enum Up {
    Y,
    Z,
}

impl Up {
    /// Converts a vector from a world with y up to the file's axes.
    #[cfg(feature = "sea")]
    pub(crate) fn of_y_up<T: std::ops::Neg<Output = T>>(self, [x, y, z]: [T; 3]) -> [T; 3] {
        match self {
            Self::Y => [x, y, z],
            Self::Z => [x, -z, y],
        }
    }

    /// Converts a vector from the file's axes to a world with y up.
    pub(crate) fn to_y_up<T: std::ops::Neg<Output = T>>(self, [x, y, z]: [T; 3]) -> [T; 3] {
        match self {
            Self::Y => [x, y, z],
            Self::Z => [x, z, -y],
        }
    }
}

/// Refuses a file whose extension belongs to another node than the one declared by `own`.
pub(crate) fn check_ending(file: &str, own: &Declaration, item: ItemName, check: &mut Check<'_>) {
    let Some(files) = own.reads.filter(|files| !files.include(file)) else { return };
    let readers = check.types().filter(|ty| ty.reads.is_some_and(|files| files.include(file)));
    let readers: Vec<&'static Declaration> = readers.collect();
    let Some(known) = readers.first().and_then(|reader| reader.reads) else { return };
    let expected = format!("a file with the extension .{}", files.endings.join(", ."));
    let remedy = format!("read it with {}, or choose another file", one_of(readers.into_iter()));
    check.error(item, format!("\"{file}\", {}", known.what), expected, remedy);
}

/// A surface at one frame.
pub(crate) struct PreparedSurface(SurfaceHandle);

impl PreparedSurface {
    pub(crate) fn new(surface: impl Surface + 'static) -> Self {
        Self(Arc::new(surface))
    }
}

impl Prepared for PreparedSurface {
    fn handle(&self) -> Option<Handle> {
        Some(Arc::new(self.0.clone()))
    }

    fn reference(&self, _inputs: &References<'_>) -> Result<Vec<Reference>, NodeError> {
        Ok(vec![Reference::Handle(Arc::new(self.0.clone()))])
    }
}
