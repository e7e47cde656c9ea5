//! Pictures on a card.

use super::card::{Card, Kernel};
use super::conversion::{Conversion, TEXT};
use super::error::CardError;
use crate::evaluate::shown::{Channel, Display, Screen, range};
use std::sync::{Arc, Weak};
use trochoid::{Kind, Picture, Plane, WorkingSpace};
use wgpu::Buffer;

/// Number of pictures that stay on the card: that of a viewer, and the held one.
const KEPT: usize = 2;

/// A picture with the first channel that is there. As long as it is known, its address is no other's.
type Kept = (Weak<Picture>, usize, Buffer);

/// Converts pictures, of which the last ones stay on the card.
#[derive(Debug)]
pub(super) struct Pictures {
    kernel: Kernel,
    /// Newest first.
    kept: Vec<Kept>,
}

impl Pictures {
    pub(super) fn new(card: &Card) -> Result<Self, CardError> {
        let kernel = card.kernel(&[TEXT, include_str!("picture.wgsl")].concat())?;
        Ok(Self { kernel, kept: Vec::new() })
    }

    /// Converts a picture for the screen.
    pub(super) fn screen(
        &mut self,
        card: &Card,
        picture: &Arc<Picture>,
        space: WorkingSpace,
        display: &Display,
    ) -> Result<Screen, CardError> {
        let Some(first) = picture.planes.first() else { return Ok(Screen { size: [0, 0], pixels: Vec::new() }) };
        let window = first.window();
        let size = [window.width(), window.height()];
        let (conversion, channels) = match (picture.kind, display.channel) {
            (Kind::Color, _) => (Conversion::of_colors(space, display)?, 0..3),
            (_, channel) => {
                let index = if let Channel::One(channel) = channel { channel } else { 0 };
                let index = index.min(picture.planes.len() - 1);
                (Conversion::of_field(range(picture, display), display)?, index..index + 1)
            }
        };
        let uploaded = conversion.upload(card, size, size, false)?;
        let planes = planes(&mut self.kept, card, picture, channels.start, &picture.planes[channels])?;
        let buffers = [&uploaded.settings, &uploaded.table, &uploaded.encoding, planes];
        Ok(Screen { size, pixels: card.run(&self.kernel, window.area(), &buffers)? })
    }
}

/// Copies planes to the card, unless they are there.
fn planes<'k>(
    kept: &'k mut Vec<Kept>,
    card: &Card,
    picture: &Arc<Picture>,
    first: usize,
    planes: &[Plane],
) -> Result<&'k Buffer, CardError> {
    kept.retain(|(known, ..)| known.strong_count() > 0);
    let is_it = |(known, channel, _): &Kept| std::ptr::eq(known.as_ptr(), Arc::as_ptr(picture)) && *channel == first;
    let place = match kept.iter().position(is_it) {
        Some(place) => place,
        None => {
            // Gone before the new one needs the memory.
            kept.truncate(KEPT - 1);
            let parts: Vec<&[u8]> = planes.iter().map(|plane| bytemuck::cast_slice(plane.samples())).collect();
            kept.push((Arc::downgrade(picture), first, card.upload(&parts)?));
            kept.len() - 1
        }
    };
    kept[..=place].rotate_right(1);
    Ok(&kept[0].2)
}
