//! Cards that fail, and what the threads do then.

use super::super::card::Cards;
use super::super::error::CardError;
use super::super::used::Graphics;
use super::card;
use crate::evaluate::shown::{Display, screen};
use crate::evaluate::{News, Worker};
use std::sync::Arc;
use std::time::Duration;
use trochoid::{Audit, Kind, Picture, Plane, Window, WorkingSpace};

fn ramp() -> Arc<Picture> {
    let window = Window::new(0, 0, 50, 10);
    let plane =
        |channel: usize| Plane::new(window, (0..500).map(|at| (at * (channel + 1)) as f32 / 900.0).collect()).unwrap();
    Arc::new(Picture {
        output: 0,
        kind: Kind::Color,
        planes: (0..3).map(plane).collect(),
        guarantee: None,
        audit: Audit::default(),
        control_count: 0,
        control_colors: Vec::new(),
        hull: None,
        margin: 0.0,
    })
}

#[test]
fn a_lost_card_is_given_up_and_the_processor_goes_on() {
    let graphics = Graphics::default();
    assert_eq!(graphics.told(), None);
    graphics.open(Cards::Any);
    let told = graphics.told().unwrap();
    assert!(told.ends_with(" shows and recolors pictures.") && !told.contains("processor"), "{told}");
    let (picture, display) = (ramp(), Display { exposure: 0.5, ..Display::default() });
    let expected = screen(&picture, WorkingSpace::Srgb, &display);
    assert_eq!(graphics.screen(&picture, WorkingSpace::Srgb, &display), expected);
    graphics.lose();
    assert_eq!(graphics.screen(&picture, WorkingSpace::Srgb, &display), expected);
    let told = graphics.told().unwrap();
    assert!(told.starts_with("The processor shows and recolors pictures: ") && told.contains(" failed: "), "{told}");
    assert_eq!(graphics.screen(&picture, WorkingSpace::Srgb, &display), expected);
}

#[test]
fn what_a_card_cannot_do_leaves_it_open() {
    let graphics = Graphics::default();
    graphics.open(Cards::Any);
    let (picture, display) = (ramp(), Display { exposure: 110.0, ..Display::default() });
    let expected = screen(&picture, WorkingSpace::LinearSrgb, &display);
    assert_eq!(graphics.screen(&picture, WorkingSpace::LinearSrgb, &display), expected);
    assert!(graphics.told().unwrap().starts_with("The processor "));
    graphics.screen(&picture, WorkingSpace::LinearSrgb, &Display::default());
    assert!(!graphics.told().unwrap().contains("processor"));
}

#[test]
fn sizes_are_checked_before_memory_is_taken() {
    let card = card();
    let most = card.most();
    let words = usize::try_from(most / 4 + 1).unwrap();
    let kernel = card.kernel("@group(0) @binding(0) var<storage, read_write> screen: array<u32>;\n@compute @workgroup_size(64) fn main(@builtin(global_invocation_id) id: vec3u) { screen[id.x] = 7; }");
    let kernel = kernel.unwrap();
    assert!(matches!(card.run(&kernel, words, &[]), Err(CardError::Large { bytes, .. }) if bytes > most));
    // The card still works.
    assert_eq!(card.run(&kernel, 3, &[]).unwrap(), [7, 0, 0, 0].repeat(3));
    assert!(card.run(&kernel, 0, &[]).unwrap().is_empty());
}

#[test]
fn a_kernel_that_the_driver_refuses_is_an_error() {
    let found = card().kernel("fn main() -> nonsense {}").map(|_| ());
    assert!(matches!(found, Err(CardError::Failed(..))), "{found:?}");
}

#[test]
fn drivers_that_compute_on_the_processor_are_for_tests_alone() {
    let graphics = Graphics::default();
    graphics.open(Cards::Real);
    let told = graphics.told().unwrap();
    // A machine with a card has it.
    let is_software = told.contains("is no graphics card, but computes on the processor");
    assert!(is_software || told.ends_with(" shows and recolors pictures."), "{told}");
}

#[test]
fn a_picture_and_the_held_one_beside_the_wipe_line_come_from_the_card() {
    let graphics = Graphics::default();
    graphics.open(Cards::Any);
    let worker = Worker::new(&graphics, || ()).unwrap();
    let (picture, held) = (ramp(), ramp());
    for (step, exposure) in [0.25, -1.0, 2.0].into_iter().enumerate() {
        let display = Display { exposure, ..Display::default() };
        let number = step as u64 + 1;
        worker.show(number, picture.clone(), WorkingSpace::Srgb, display.clone());
        worker.show_held(number, held.clone(), WorkingSpace::LinearSrgb, display.clone());
        let mut found = [None, None];
        while found.iter().any(Option::is_none) {
            match worker.wait(Duration::from_secs(60)).unwrap() {
                News::Shown { screen, .. } => found[0] = Some(screen),
                News::Held { screen, .. } => found[1] = Some(screen),
                _ => {}
            }
        }
        let expected = [WorkingSpace::Srgb, WorkingSpace::LinearSrgb].map(|space| screen(&picture, space, &display));
        assert!(found.into_iter().flatten().map(|found| (*found).clone()).eq(expected), "{exposure}");
    }
    assert!(!graphics.told().unwrap().contains("processor"), "the card did it all");
}
