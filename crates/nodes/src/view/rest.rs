//! Rest: where the seen point was before anything moved it.

use super::Copies;
use trochoid_graph::*;

/// The rest point of what is seen: patterns over it move with the surface.
///
/// # Formula
/// P₀: of a sea the particle's place on the rest level, of a model the point in the model's own space
///
/// # Edge cases
/// (0, 0, 0) where nothing is seen.
///
/// # Source
/// The field's rest (reference position) pass.
#[derive(Clone, Node)]
#[node(end = Front, revision = 1, output(rest: Kind::Field(3) = "Rest point, m."))]
pub(crate) struct Rest {
    /// What is seen.
    view: One<port::View>,
}

impl Copies for Rest {
    const CHANNELS: &[Channel] = &[Channel::RestX, Channel::RestY, Channel::RestZ];

    fn view(&self) -> &One<port::View> {
        &self.view
    }
}
