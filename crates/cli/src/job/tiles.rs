//! Tiles of a picture.

/// Most columns or rows of tiles.
const MOST: u32 = 32;

/// Number of columns and rows of tiles.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) struct Grid {
    pub(super) columns: u32,
    pub(super) rows: u32,
}

impl Grid {
    /// Returns the index of the tile in the middle.
    pub(super) fn middle(self) -> usize {
        (self.rows / 2 * self.columns + self.columns / 2) as usize
    }
}

/// Text that is no grid of tiles.
#[derive(Debug, thiserror::Error)]
#[error("expected columns and rows from 1 to {MOST}, such as 4x2")]
pub(super) struct NoGrid;

/// Reads a grid such as `4x2`.
pub(super) fn grid(text: &str) -> Result<Grid, NoGrid> {
    let number = |text: &str| text.parse().ok().filter(|count| (1..=MOST).contains(count));
    let (columns, rows) = text.split_once('x').ok_or(NoGrid)?;
    Ok(Grid { columns: number(columns).ok_or(NoGrid)?, rows: number(rows).ok_or(NoGrid)? })
}

/// Returns the tiles of a picture of this size, row by row, each as left, top, width and height in pixels. They partition
/// the picture, and their sizes differ by at most a pixel; none is empty if the picture has a pixel for each.
pub(super) fn regions(grid: Grid, [width, height]: [u32; 2]) -> Vec<[u32; 4]> {
    let edge = |at: u32, count: u32, size: u32| (u64::from(at) * u64::from(size) / u64::from(count)) as u32;
    let spans = |count: u32, size: u32| {
        (0..count).map(move |at| (edge(at, count, size), edge(at + 1, count, size))).map(|(from, to)| (from, to - from))
    };
    let rows = spans(grid.rows, height);
    rows.flat_map(|(y, h)| spans(grid.columns, width).map(move |(x, w)| [x, y, w, h])).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn tiles_cover_every_pixel_once() {
        for (columns, rows, width, height) in [(1, 1, 5, 3), (3, 2, 10, 7), (5, 3, 5, 3), (32, 32, 65_536, 33)] {
            let tiles = regions(Grid { columns, rows }, [width, height]);
            assert_eq!(tiles.len(), (columns * rows) as usize);
            assert!(tiles.iter().all(|[_, _, w, h]| *w > 0 && *h > 0), "{tiles:?}");
            let mut covered = vec![0_u8; (width * height) as usize];
            for [x, y, w, h] in tiles {
                for row in y..y + h {
                    (x..x + w).for_each(|column| covered[(row * width + column) as usize] += 1);
                }
            }
            assert!(covered.iter().all(|count| *count == 1), "{columns}x{rows}");
        }
    }

    #[test]
    fn grids_are_read() {
        assert_eq!(grid("4x2").unwrap(), Grid { columns: 4, rows: 2 });
        for text in ["", "4", "x", "4x", "0x2", "4x33", "4X2", "4x2x1", "-1x2", " 4x2"] {
            assert!(grid(text).unwrap_err().to_string().contains("4x2"), "{text}");
        }
    }
}
