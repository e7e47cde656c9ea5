//! Tests on a card, of which a driver that computes on the processor is one: the processor's pictures are the definition.
//! Without a driver they fail.

mod failing;
mod pictures;
mod programs;
mod recipes;

use super::card::{Card, Cards};
use crate::evaluate::shown::Screen;
use rand::RngExt;
use rand_pcg::Pcg64Mcg;

/// Opens a card.
fn card() -> Card {
    Card::open(Cards::Any).expect("a graphics driver (Debian: mesa-vulkan-drivers)")
}

/// Numbers that are more than ordinary.
const HOSTILE: [f32; 20] = [
    f32::NAN,
    -f32::NAN,
    f32::INFINITY,
    f32::NEG_INFINITY,
    f32::MAX,
    f32::MIN,
    1e30,
    -1e30,
    65504.0,
    1.0,
    -1.0,
    0.5,
    0.0,
    -0.0,
    f32::MIN_POSITIVE,
    -f32::MIN_POSITIVE,
    1e-40,
    -1e-45,
    0.040_449_9,
    0.003_130_8,
];

/// Returns a number: mostly ordinary ones, and any others.
fn number(random: &mut Pcg64Mcg) -> f32 {
    match random.random_range(0..8) {
        0 => HOSTILE[random.random_range(0..HOSTILE.len())],
        1 => f32::from_bits(random.random::<u32>()),
        2 => random.random_range(0.0..0.02),
        3 => random.random_range(-30.0..30.0),
        _ => random.random_range(-0.1..1.1),
    }
}

/// Returns the largest difference of two pictures of one size.
fn difference(found: &Screen, expected: &Screen) -> u8 {
    assert_eq!(found.size, expected.size);
    assert_eq!(found.pixels.len(), expected.pixels.len());
    found.pixels.iter().zip(&expected.pixels).map(|(a, b)| a.abs_diff(*b)).max().unwrap_or(0)
}

/// Returns how far bytes of a picture lie outside of those that the processor's table has one place before or behind.
fn beyond_a_place(found: &Screen, expected: &Screen, table: &[u32]) -> u8 {
    let table: Vec<u8> = table.iter().map(|pixel| *pixel as u8).collect();
    assert!(table.is_sorted(), "a table of grays");
    let off = |(found, expected): (&u8, &u8)| {
        let before = table.partition_point(|byte| byte < expected).saturating_sub(1);
        let behind = table.partition_point(|byte| byte <= expected).min(table.len() - 1);
        let [low, high] = [table[before].min(*expected), table[behind].max(*expected)];
        found.abs_diff((*found).clamp(low, high))
    };
    assert_eq!(found.size, expected.size);
    found.pixels.iter().zip(&expected.pixels).map(off).max().unwrap_or(0)
}
