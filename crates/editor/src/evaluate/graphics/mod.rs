//! The graphics card, if the program is built with the feature `gpu` and the machine has one. It converts pictures whose
//! display settings change, and paints recipes in other colors: what it works on stays in its memory, so that only the
//! settings go there and only pixels come back. What the processor makes is the definition, and what is shown whenever the
//! card cannot do it.

#[cfg(feature = "gpu")]
mod card;
#[cfg(feature = "gpu")]
mod conversion;
#[cfg(feature = "gpu")]
mod error;
#[cfg(feature = "gpu")]
mod picture;
#[cfg(feature = "gpu")]
mod recipe;
#[cfg(all(test, feature = "gpu"))]
mod tests;
#[cfg(feature = "gpu")]
mod used;

#[cfg(feature = "gpu")]
pub use card::Cards;
#[cfg(feature = "gpu")]
pub use used::Graphics;

#[cfg(not(feature = "gpu"))]
pub use without::Graphics;

/// What stands in for a card in a program that is built without the feature.
#[cfg(not(feature = "gpu"))]
mod without {
    use crate::evaluate::Painting;
    use crate::evaluate::shown::{Display, Screen, screen};
    use std::sync::Arc;
    use trochoid::{Picture, WorkingSpace};

    /// No graphics card.
    #[derive(Clone, Debug, Default)]
    pub struct Graphics(());

    impl Graphics {
        /// Opens a card: there is none.
        pub fn start(&self) {}

        /// Converts a picture for the screen.
        pub fn screen(&self, picture: &Arc<Picture>, space: WorkingSpace, display: &Display) -> Screen {
            screen(picture, space, display)
        }

        /// Paints a picture from its recipe: never, without a card.
        pub fn paint(&self, _: &Painting) -> Option<Screen> {
            None
        }

        /// Says what computes: nothing, where there is no choice.
        pub fn told(&self) -> Option<String> {
            None
        }
    }
}
