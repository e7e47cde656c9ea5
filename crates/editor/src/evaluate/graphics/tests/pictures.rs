//! Pictures that are converted for the screen.

use super::super::conversion::Conversion;
use super::super::error::CardError;
use super::super::picture::Pictures;
use super::{HOSTILE, beyond_a_place, card, difference, number};
use crate::evaluate::shown::{Channel, Display, screen};
use crate::transform::Transform;
use rand::RngExt;
use rand_pcg::Pcg64Mcg;
use std::sync::Arc;
use trochoid::{Audit, Kind, Picture, Plane, Window, WorkingSpace};

/// Sizes around those of groups.
const SIZES: [[usize; 2]; 7] = [[1, 1], [3, 1], [1, 64], [65, 1], [13, 11], [64, 9], [127, 33]];

/// Makes a picture.
fn picture(kind: Kind, size: [usize; 2], mut value: impl FnMut() -> f32) -> Arc<Picture> {
    let window = Window::new(0, 0, size[0] as i64, size[1] as i64);
    let plane = |_| Plane::new(window, (0..window.area()).map(|_| value()).collect()).unwrap();
    Arc::new(Picture {
        output: 0,
        kind,
        planes: (0..kind.channels()).map(plane).collect(),
        guarantee: None,
        audit: Audit::default(),
        control_count: 0,
        control_colors: Vec::new(),
        hull: None,
        margin: 0.0,
    })
}

/// Returns display settings within the ranges of the toolbar.
fn display(random: &mut Pcg64Mcg) -> Display {
    let channels = [Channel::All, Channel::All, Channel::One(0), Channel::One(2), Channel::Luminance];
    let [exposure, gamma] = match random.random_range(0..3) {
        0 => [0.0, 1.0],
        1 => [random.random_range(-16.0..16.0), random.random_range(0.1..8.0)],
        _ => [random.random_range(-2.0..2.0), random.random_range(0.5..2.0)],
    };
    Display {
        channel: channels[random.random_range(0..channels.len())],
        exposure,
        gamma,
        range: None,
        false_color: random.random(),
        transform: if random.random() { Transform::Srgb } else { Transform::Bt1886 },
    }
}

#[test]
fn colors_are_those_of_the_processor() {
    let card = card();
    let mut pictures = Pictures::new(&card).unwrap();
    let mut random = Pcg64Mcg::new(0xca4d);
    let (mut same, mut made) = (0, 0);
    for round in 0..140 {
        let picture = picture(Kind::Color, SIZES[round % SIZES.len()], || number(&mut random));
        for space in [WorkingSpace::Srgb, WorkingSpace::LinearSrgb, WorkingSpace::AcesCg] {
            let display = display(&mut random);
            let expected = screen(&picture, space, &display);
            let found = match pictures.screen(&card, &picture, space, &display) {
                Err(CardError::Unfit(_)) if space == WorkingSpace::AcesCg => continue,
                found => found.unwrap(),
            };
            made += 1;
            same += usize::from(found == expected);
            let off = match (space, display.channel) {
                // The matrix is one of 64-bit numbers on the processor.
                (WorkingSpace::AcesCg, Channel::All) => {
                    beyond_a_place(&found, &expected, &Conversion::of_colors(space, &display).unwrap().table)
                }
                _ => difference(&found, &expected),
            };
            assert!(off <= 1, "round {round}: {space}: {display:?}: {off}");
        }
    }
    assert!(made > 350, "{made} pictures were made");
    // Nearly all are equal: places in tables are found by the same roundings.
    assert!(10 * same > 9 * made, "{same} of {made} pictures are the same");
}

#[test]
fn every_pair_of_hostile_numbers_is_shown_as_by_the_processor() {
    let card = card();
    let mut pictures = Pictures::new(&card).unwrap();
    let count = HOSTILE.len();
    // All triples of them.
    let mut at = 0;
    let picture = picture(Kind::Color, [count * count, count], || {
        let (channel, pixel) = (at / count.pow(3), at % count.pow(3));
        at += 1;
        HOSTILE[pixel / count.pow(channel as u32) % count]
    });
    for space in [WorkingSpace::Srgb, WorkingSpace::LinearSrgb, WorkingSpace::AcesCg] {
        for channel in [Channel::All, Channel::One(1), Channel::Luminance] {
            if (space, channel) == (WorkingSpace::AcesCg, Channel::Luminance) {
                continue;
            }
            for exposure in [-16.0, 0.0, 3.0, 16.0] {
                let display = Display { channel, exposure, false_color: exposure > 0.0, ..Display::default() };
                let found = pictures.screen(&card, &picture, space, &display).unwrap();
                let off = difference(&found, &screen(&picture, space, &display));
                assert!(off <= 1, "{space}: {display:?}: {off}");
            }
        }
    }
}

#[test]
fn fields_and_weights_are_those_of_the_processor_in_false_colors_too() {
    let card = card();
    let mut pictures = Pictures::new(&card).unwrap();
    let mut random = Pcg64Mcg::new(0xf1e1d);
    for round in 0..120 {
        let kind = [Kind::Field(1), Kind::Field(3), Kind::MASK, Kind::Weights(4)][round % 4];
        let is_wild = round % 3 == 0;
        let value = || if is_wild { number(&mut random) } else { random.random_range(-40.0..90.0) };
        let picture = picture(kind, SIZES[round % SIZES.len()], value);
        for channel in [Channel::All, Channel::One(1), Channel::One(9)] {
            let range = [None, Some([0.0, 1.0]), Some([-3.0, 50.0]), Some([0.1, 0.1001])][random.random_range(0..4)];
            let display = Display { channel, range, ..display(&mut random) };
            let expected = screen(&picture, WorkingSpace::Srgb, &display);
            match pictures.screen(&card, &picture, WorkingSpace::Srgb, &display) {
                // A range over all numbers.
                Err(CardError::Unfit(_)) if is_wild || picture.planes[0].samples().len() == 1 => {}
                found => assert!(difference(&found.unwrap(), &expected) <= 1, "{kind}: {display:?}"),
            }
        }
    }
}

#[test]
fn the_last_pictures_stay_on_the_card_and_no_other_is_taken_for_them() {
    let card = card();
    let mut pictures = Pictures::new(&card).unwrap();
    let mut random = Pcg64Mcg::new(7);
    let mut known: Vec<Arc<Picture>> = Vec::new();
    for round in 0..60 {
        // Some are forgotten, so that new ones get their addresses.
        if known.len() < 3 || random.random() {
            let value = round as f32 / 60.0;
            known.push(picture(Kind::Color, [9, 4], || value));
        }
        if known.len() > 4 {
            known.remove(random.random_range(0..4));
        }
        let picture = &known[random.random_range(0..known.len())];
        let display = Display::default();
        let found = pictures.screen(&card, picture, WorkingSpace::LinearSrgb, &display).unwrap();
        assert_eq!(found, screen(picture, WorkingSpace::LinearSrgb, &display), "round {round}");
    }
}

#[test]
fn what_only_the_processor_shows_is_refused_and_nothing_is_nothing() {
    let card = card();
    let mut pictures = Pictures::new(&card).unwrap();
    let mut refused = |kind: Kind, space: WorkingSpace, display: &Display| {
        let picture = picture(kind, [4, 4], || 0.5);
        let found = pictures.screen(&card, &picture, space, display).map(|_| ());
        found.map_err(|error| error.to_string())
    };
    let luminance = Display { channel: Channel::Luminance, ..Display::default() };
    assert_eq!(
        refused(Kind::Color, WorkingSpace::AcesCg, &luminance).unwrap_err(),
        "only the processor shows the luminance of ACEScg"
    );
    let field = Kind::Field(1);
    for range in [[1.0, 0.0], [2.0, 2.0], [f32::NAN, 1.0], [0.0, f32::INFINITY], [f32::MIN, f32::MAX]] {
        let display = Display { range: Some(range), ..Display::default() };
        assert!(refused(field, WorkingSpace::Srgb, &display).is_err(), "{range:?}");
    }
    let bright = Display { exposure: 120.0, ..Display::default() };
    assert!(refused(Kind::Color, WorkingSpace::LinearSrgb, &bright).is_err());
    let mut empty = Picture::clone(&picture(Kind::Color, [1, 1], || 0.0));
    empty.planes.clear();
    let found = pictures.screen(&card, &Arc::new(empty), WorkingSpace::Srgb, &Display::default()).unwrap();
    assert_eq!((found.size, found.pixels.len()), ([0, 0], 0));
}
