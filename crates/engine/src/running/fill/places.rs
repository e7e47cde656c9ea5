//! Where single pixels lie in planes.

use trochoid_image::Window;

/// Where some pixels lie in planes of one stride, from the first corner of the smallest window around them on.
#[derive(Default)]
pub(super) struct Places {
    stride: Option<usize>,
    all: Vec<u32>,
}

impl Places {
    /// Returns the places in planes of a stride, which is mostly that of the planes before. `area` is the number of pixels of
    /// the tile.
    pub(super) fn of(&mut self, pixels: &[[i64; 2]], window: Window, stride: usize, area: usize) -> &[u32] {
        if self.stride.replace(stride) != Some(stride) {
            let place = |[x, y]: &[i64; 2]| ((y - window.y0) as usize * stride + (x - window.x0) as usize) as u32;
            self.all.clear();
            make_room(&mut self.all, area);
            self.all.extend(pixels.iter().map(place));
        }
        &self.all
    }

    /// Forgets the places: there are other pixels.
    pub(super) fn forget(&mut self) {
        self.stride = None;
    }
}

/// Inverse of the share by which planes have more room than they need.
const ROOM: usize = 8;

/// Makes room in a plane for all pixels of a tile, so that it is not moved whenever more of them are listed than before.
pub(crate) fn make_room<T>(plane: &mut Vec<T>, area: usize) {
    if plane.capacity() < area {
        // Tiles differ a little in size. Nothing of the old plane is copied.
        *plane = Vec::with_capacity(area + area / ROOM);
    }
}

/// Returns the number of samples for which [`make_room`] makes room.
pub(crate) fn with_room(samples: u64) -> u64 {
    samples.saturating_add(samples / ROOM as u64)
}
