//! Knobs of surfaces that stand in the world, and what they hand on.

use super::{SurfaceHandle, vector};
use std::sync::Arc;
use trochoid_graph::{Check, Handle, Item, Knob, NodeError, Prepared, Reference, References, Settled};
use trochoid_scene::bezier::Placement;
use trochoid_scene::{DVec3, Surface};

pub(crate) const SCALE: Item =
    Knob::vector("scale", &[1.0, 1.0, 1.0], "Factors along the model's own axes; first of all.").item();
pub(crate) const ROTATE: Item =
    Knob::vector("rotate", &[0.0, 0.0, 0.0], "Turns about x, then y, then z.").unit("degrees").item();
pub(crate) const TRANSLATE: Item =
    Knob::vector("translate", &[0.0, 0.0, 0.0], "Where the model's origin comes to stand.").unit("m").item();
pub(crate) const UP: Item = Knob::choice("up", &["y", "z"], "The axis that points up in the file.").item();
pub(crate) const FLIP: Item = Knob::bool("flip", false, "Takes the other side for the outer one.").item();

/// A vector of a world whose y points up as one of a world whose axis `up` does, "y" or "z".
pub(crate) fn y_up_to<T: std::ops::Neg<Output = T>>(up: &str, [x, y, z]: [T; 3]) -> [T; 3] {
    if up == "z" { [x, -z, y] } else { [x, y, z] }
}

/// The way back from [`y_up_to`].
pub(crate) fn to_y_up<T: std::ops::Neg<Output = T>>(up: &str, [x, y, z]: [T; 3]) -> [T; 3] {
    if up == "z" { [x, z, -y] } else { [x, y, z] }
}

/// What the knobs say.
pub(crate) fn placement(node: &Settled) -> Placement {
    let rotate = node.vector3("rotate").map(f64::to_radians);
    Placement { scale: vector(node, "scale"), rotate: DVec3::from(rotate), translate: vector(node, "translate") }
}

/// Reports a scale that leaves no surface.
pub(crate) fn check_scale(node: &Settled, check: &mut Check<'_>) {
    let scale = node.vector3("scale");
    if scale.contains(&0.0) {
        check.error("scale", format!("{scale:?}"), "factors other than 0", "write a small factor to make a model flat");
    }
}

/// Refuses a file whose name says that another node reads it.
pub(crate) fn check_ending(node: &Settled, check: &mut Check<'_>, knob: &'static str, endings: &[&str]) {
    const READERS: [(&[&str], &str, &str); 3] = [
        (&["obj", "glb", "gltf"], "a mesh of triangles", "Mesh"),
        (&["json"], "a model of Bézier patches", "BezierModel"),
        (&["exr", "png", "jpg", "jpeg", "tif", "tiff"], "a picture", "Texture"),
    ];
    let name = node.text(knob).to_lowercase();
    let is_one = |endings: &[&str]| endings.iter().any(|ending| name.ends_with(&format!(".{ending}")));
    let reader = READERS.iter().find(|(known, ..)| is_one(known)).filter(|_| !is_one(endings));
    if let Some((_, what, reader)) = reader {
        let expected = format!("a file with the ending .{}", endings.join(", ."));
        let remedy = format!("read it by the node {reader}, or choose another file");
        check.error(knob, format!("\"{}\", {what}", node.text(knob)), expected, remedy);
    }
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
