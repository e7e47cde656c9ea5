//! Windows: rectangles of pixels, and their tiles.

use trochoid_key::content_key;

/// A half-open rectangle of pixels: `x0 <= x < x1`, `y0 <= y < y1`.
///
/// Edges are 64-bit, so that width, height and area of the windows in files cannot overflow.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash, Default)]
pub struct Window {
    /// First column.
    pub x0: i64,
    /// First row.
    pub y0: i64,
    /// Column after the last.
    pub x1: i64,
    /// Row after the last.
    pub y1: i64,
}

content_key!(Window { x0, y0, x1, y1 });

impl Window {
    /// Makes the window between two corners.
    pub const fn new(x0: i64, y0: i64, x1: i64, y1: i64) -> Self {
        Self { x0, y0, x1, y1 }
    }

    /// Makes the window of `width` × `height` pixels at the origin.
    pub const fn sized(width: u32, height: u32) -> Self {
        Self::new(0, 0, width as i64, height as i64)
    }

    /// Returns the number of columns; 0 if the window is empty.
    pub const fn width(self) -> usize {
        if self.x1 > self.x0 { (self.x1 - self.x0) as usize } else { 0 }
    }

    /// Returns the number of rows; 0 if the window is empty.
    pub const fn height(self) -> usize {
        if self.y1 > self.y0 { (self.y1 - self.y0) as usize } else { 0 }
    }

    /// Returns the number of pixels.
    pub const fn area(self) -> usize {
        self.width().saturating_mul(self.height())
    }

    /// Whether the window contains no pixel.
    pub const fn is_empty(self) -> bool {
        self.width() == 0 || self.height() == 0
    }

    /// Whether the window contains pixel (x, y).
    pub const fn contains(self, x: i64, y: i64) -> bool {
        x >= self.x0 && x < self.x1 && y >= self.y0 && y < self.y1
    }

    /// Returns the intersection of both windows.
    pub fn intersect(self, other: Self) -> Self {
        Self::new(self.x0.max(other.x0), self.y0.max(other.y0), self.x1.min(other.x1), self.y1.min(other.y1))
    }

    /// Returns the bounding box of both windows; an empty window adds nothing.
    pub fn union(self, other: Self) -> Self {
        if self.is_empty() {
            return other;
        }
        if other.is_empty() {
            return self;
        }
        Self::new(self.x0.min(other.x0), self.y0.min(other.y0), self.x1.max(other.x1), self.y1.max(other.y1))
    }

    /// Cuts the window into tiles of at most `width` × `height` pixels, row by row.
    ///
    /// ```
    /// use trochoid_image::Window;
    /// let tiles: Vec<_> = Window::sized(5, 2).tiles(4, 2).collect();
    /// assert_eq!(tiles, [Window::new(0, 0, 4, 2), Window::new(4, 0, 5, 2)]);
    /// ```
    pub fn tiles(self, width: usize, height: usize) -> Tiles {
        let (width, height) = (width.max(1), height.max(1));
        let columns = self.width().div_ceil(width);
        let count = if self.is_empty() { 0 } else { columns * self.height().div_ceil(height) };
        Tiles { window: self, width, height, columns, next: 0, count }
    }
}

impl std::fmt::Display for Window {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        write!(f, "[{}, {}) × [{}, {})", self.x0, self.x1, self.y0, self.y1)
    }
}

/// Iterator over the tiles of a window, row by row. Made by [`Window::tiles`].
#[derive(Clone, Debug)]
pub struct Tiles {
    window: Window,
    width: usize,
    height: usize,
    columns: usize,
    next: usize,
    count: usize,
}

impl Iterator for Tiles {
    type Item = Window;

    fn next(&mut self) -> Option<Window> {
        if self.next == self.count {
            return None;
        }
        let (row, column) = (self.next / self.columns, self.next % self.columns);
        self.next += 1;
        let x0 = self.window.x0 + (column * self.width) as i64;
        let y0 = self.window.y0 + (row * self.height) as i64;
        let tile = Window::new(x0, y0, x0 + self.width as i64, y0 + self.height as i64);
        Some(tile.intersect(self.window))
    }

    fn size_hint(&self) -> (usize, Option<usize>) {
        (self.count - self.next, Some(self.count - self.next))
    }
}

impl ExactSizeIterator for Tiles {}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn tiles_cover_the_window_once() {
        let window = Window::new(-3, 2, 14, 9);
        let mut seen = vec![0; window.area()];
        for tile in window.tiles(5, 3) {
            for y in tile.y0..tile.y1 {
                for x in tile.x0..tile.x1 {
                    seen[(y - window.y0) as usize * window.width() + (x - window.x0) as usize] += 1;
                }
            }
        }
        assert!(seen.iter().all(|&n| n == 1));
        assert_eq!(Window::default().tiles(4, 4).count(), 0);
    }

    #[test]
    fn union_ignores_empty_windows() {
        let window = Window::new(1, 1, 3, 3);
        assert_eq!(window.union(Window::new(9, 9, 9, 20)), window);
        assert_eq!(Window::new(5, 0, 2, 7).union(window), window);
        assert!(window.intersect(Window::new(3, 0, 9, 9)).is_empty());
    }
}
