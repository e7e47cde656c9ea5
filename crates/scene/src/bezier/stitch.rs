//! Triangles of one patch: a regular grid inside, joined to edges that are cut to match their neighbors.

/// How a patch is cut.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) struct Cut {
    /// Pieces of each edge, in the order of [`Bicubic::edge`](super::Bicubic::edge).
    pub(crate) edges: [usize; 4],
    /// Cells of the inner grid along u and v, at least 2 each; the join replaces its outermost cells.
    pub(crate) inner: [usize; 2],
}

impl Cut {
    /// Returns the number of vertices.
    pub(crate) fn vertices(&self) -> usize {
        self.edges.iter().sum::<usize>() + (self.inner[0] - 1) * (self.inner[1] - 1)
    }

    /// Returns the number of the border vertex `index` of an edge; the border runs counterclockwise from (0, 0).
    fn border(&self, edge: usize, index: usize) -> u32 {
        let before: usize = self.edges[..edge].iter().sum();
        let all: usize = self.edges.iter().sum();
        ((before + index) % all) as u32
    }

    /// Returns the number of the inner vertex at column `i` and row `j`, each from 1.
    fn inside(&self, i: usize, j: usize) -> u32 {
        (self.edges.iter().sum::<usize>() + (j - 1) * (self.inner[0] - 1) + (i - 1)) as u32
    }

    /// Returns (u, v) of every inner vertex, in order.
    pub(crate) fn inner_points(&self) -> impl Iterator<Item = [f64; 2]> {
        let [columns, rows] = self.inner;
        (1..rows).flat_map(move |j| (1..columns).map(move |i| [i as f64 / columns as f64, j as f64 / rows as f64]))
    }

    /// Returns the triangles, counterclockwise seen from the outer side.
    pub(crate) fn triangles(&self) -> Vec<[u32; 3]> {
        let [columns, rows] = self.inner;
        let mut triangles = Vec::with_capacity(2 * columns * rows + self.edges.iter().sum::<usize>());
        for j in 1..rows - 1 {
            for i in 1..columns - 1 {
                let (a, b) = (self.inside(i, j), self.inside(i + 1, j));
                let (c, d) = (self.inside(i, j + 1), self.inside(i + 1, j + 1));
                triangles.extend([[a, b, c], [b, d, c]]);
            }
        }
        for edge in 0..4 {
            self.join(edge, &mut triangles);
        }
        triangles
    }

    /// Adds the triangles between an edge and the inner vertices along it.
    fn join(&self, edge: usize, triangles: &mut Vec<[u32; 3]>) {
        let [columns, rows] = self.inner;
        let (outer, inner) = (self.edges[edge], if edge.is_multiple_of(2) { columns } else { rows });
        let inside = |at: usize| match edge {
            0 => self.inside(at, 1),
            1 => self.inside(columns - 1, at),
            2 => self.inside(columns - at, rows - 1),
            _ => self.inside(1, rows - at),
        };
        // Positions along the edge, 0 to 1: the next vertex of whichever side is behind comes first.
        let (mut a, mut b) = (0, 1);
        while a < outer || b < inner - 1 {
            let outer_first = b == inner - 1 || (a < outer && (a + 1) * inner <= (b + 1) * outer);
            if outer_first {
                triangles.push([self.border(edge, a), self.border(edge, a + 1), inside(b)]);
                a += 1;
            } else {
                triangles.push([self.border(edge, a), inside(b + 1), inside(b)]);
                b += 1;
            }
        }
    }
}
