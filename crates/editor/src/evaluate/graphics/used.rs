//! The card as the threads use it: opened beside them, and given up when it fails.

use super::card::{Card, Cards, locked};
use super::error::CardError;
use super::picture::Pictures;
use super::recipe::Recipes;
use crate::evaluate::Painting;
use crate::evaluate::shown::{self, Display, Screen};
use std::panic::{AssertUnwindSafe, catch_unwind};
use std::sync::{Arc, Mutex};
use trochoid::{Picture, WorkingSpace};

/// The graphics card, or why there is none. Cheap to clone.
#[derive(Clone, Debug, Default)]
pub struct Graphics(Arc<Mutex<State>>);

#[derive(Debug, Default)]
enum State {
    /// Nobody asked for a card.
    #[default]
    Unused,
    Opening,
    Open(Arc<Open>),
    Without(CardError),
}

/// An open card, with what it knows.
#[derive(Debug)]
struct Open {
    card: Card,
    pictures: Mutex<Pictures>,
    recipes: Mutex<Recipes>,
    /// Why it did not do what was asked for last, if it can do something else.
    passed: Mutex<Option<CardError>>,
}

impl Open {
    fn new(which: Cards) -> Result<Self, CardError> {
        let card = Card::open(which)?;
        let (pictures, recipes) = (Mutex::new(Pictures::new(&card)?), Mutex::new(Recipes::new(&card)?));
        Ok(Self { card, pictures, recipes, passed: Mutex::new(None) })
    }
}

/// Does something with a card, which is given up if its driver's library panics.
fn guarded<T>(name: &str, work: impl FnOnce() -> Result<T, CardError>) -> Result<T, CardError> {
    let panicked = |_| Err(CardError::Failed(name.into(), "its library panicked".into()));
    catch_unwind(AssertUnwindSafe(work)).unwrap_or_else(panicked)
}

impl Graphics {
    /// Opens a card on a thread of its own, for drivers take their time; until then, the processor does everything.
    pub fn start(&self) {
        *locked(&self.0) = State::Opening;
        let own = self.clone();
        let opened = std::thread::Builder::new().name("graphics".into()).spawn(move || own.open(Cards::Real));
        if let Err(error) = opened {
            *locked(&self.0) = State::Without(CardError::Refused("a thread".into(), error.to_string()));
        }
    }

    /// Opens a card, of which a driver that computes on the processor is one only for tests.
    pub fn open(&self, which: Cards) {
        let opened = guarded("a graphics driver", || Open::new(which));
        *locked(&self.0) = match opened {
            Ok(open) => State::Open(Arc::new(open)),
            Err(error) => State::Without(error),
        };
    }

    /// Converts a picture for the screen.
    pub fn screen(&self, picture: &Arc<Picture>, space: WorkingSpace, display: &Display) -> Screen {
        self.on_card(|open| locked(&open.pictures).screen(&open.card, picture, space, display))
            .unwrap_or_else(|| shown::screen(picture, space, display))
    }

    /// Paints a picture from its recipe, if a card does so.
    pub fn paint(&self, painting: &Painting) -> Option<Screen> {
        self.on_card(|open| locked(&open.recipes).paint(&open.card, painting))
    }

    /// Says what computes, as a sentence.
    pub fn told(&self) -> Option<String> {
        let processor = |why: &CardError| format!("The processor shows and recolors pictures: {why}.");
        match &*locked(&self.0) {
            State::Unused => None,
            State::Opening => Some("The processor shows pictures until a graphics card is open.".into()),
            State::Open(open) => Some(match locked(&open.passed).as_ref() {
                Some(why) => processor(why),
                None => format!("{} shows and recolors pictures.", open.card.name()),
            }),
            State::Without(why) => Some(processor(why)),
        }
    }

    /// Lets the card do something, if there is one.
    fn on_card<T>(&self, work: impl FnOnce(&Open) -> Result<T, CardError>) -> Option<T> {
        let open = match &*locked(&self.0) {
            State::Open(open) => open.clone(),
            _ => return None,
        };
        match guarded(open.card.name(), || work(&open)) {
            Ok(done) => {
                *locked(&open.passed) = None;
                Some(done)
            }
            Err(why) if why.is_passing() => {
                *locked(&open.passed) = Some(why);
                None
            }
            Err(why) => {
                *locked(&self.0) = State::Without(why);
                None
            }
        }
    }

    /// Loses the device, as a driver that crashes does.
    #[cfg(test)]
    pub(super) fn lose(&self) {
        if let State::Open(open) = &*locked(&self.0) {
            open.card.lose();
        }
    }
}
