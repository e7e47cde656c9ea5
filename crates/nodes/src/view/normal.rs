//! Normal: which way things face.

use super::Copies;
use trochoid_graph::*;

/// The unit normal of the seen point.
///
/// # Formula
/// N/|N|
///
/// # Edge cases
/// (0, 1, 0) where nothing is seen or the normal is degenerate.
///
/// # Source
/// The field's normal pass.
#[derive(Clone, Node)]
#[node(end = Front, revision = 1, output(normal: Kind::Field(3) = "Unit normal in the world."))]
pub(crate) struct Normal {
    /// What is seen.
    view: One<port::View>,
}

impl Copies for Normal {
    const CHANNELS: &[Channel] = &super::NORMAL;

    fn view(&self) -> &One<port::View> {
        &self.view
    }
}
