//! The colors of a file as control colors.

use super::Stream;
use rayon::prelude::*;
use std::collections::HashSet;
use trochoid_graph::NodeError;
use trochoid_image::Rgb;
use trochoid_weights::HullBuilder;

/// Maximum number of control colors listed individually; beyond it, only the vertices of their hull are.
pub(crate) const MANY_COLORS: usize = 1 << 16;

/// Returns the control colors of three planes.
pub(crate) fn controls([r, g, b]: [&[f32]; 3]) -> Vec<Rgb> {
    distinct(r, g, b).unwrap_or_else(|| {
        let mut hull = HullBuilder::new();
        hull.add_row(r, g, b);
        hull.finish().vertices().to_vec()
    })
}

/// Returns every distinct color, in the order of its first pixel; `None` if there are too many to list.
pub(crate) fn distinct(r: &[f32], g: &[f32], b: &[f32]) -> Option<Vec<Rgb>> {
    let mut seen = HashSet::new();
    let mut colors = Vec::new();
    let mut last = None;
    for ((r, g), b) in r.iter().zip(g).zip(b) {
        let bits = [r.to_bits(), g.to_bits(), b.to_bits()];
        // Repeated colors are common: skip them before hashing.
        if last.replace(bits) != Some(bits) && seen.insert(bits) {
            if colors.len() == MANY_COLORS {
                return None;
            }
            colors.push([*r, *g, *b]);
        }
    }
    Some(colors)
}

/// Returns the control colors of a picture that is read on demand, by reading all of it: the same as [`controls`] of
/// the decoded picture.
pub(crate) fn walked(stream: &Stream, cancelled: &(dyn Fn() -> bool + Sync)) -> Result<Vec<Rgb>, NodeError> {
    let height = stream.stored.data.height();
    // Whole blocks, so that no block is decoded by two threads.
    let step = stream.rows_per_block();
    let rows = height.div_ceil(step).div_ceil(rayon::current_num_threads()) * step;
    let parts: Vec<_> = (0..height).step_by(rows).map(|first| first..height.min(first + rows)).collect();
    let gather = |rows: std::ops::Range<usize>| {
        let mut gathered = ColorCollector::default();
        stream.each_row(rows, |row| {
            if let [r, g, b] = row {
                gathered.add_row(r, g, b);
            }
            if cancelled() { Err(NodeError::Cancelled) } else { Ok(()) }
        })?;
        Ok(gathered)
    };
    let parts: Vec<ColorCollector> =
        parts.into_par_iter().with_max_len(1).map(gather).collect::<Result<_, NodeError>>()?;
    Ok(parts.into_iter().fold(ColorCollector::default(), ColorCollector::merge).finish())
}

/// Colors in the order of their first pixel or, if there are many, their hull.
#[derive(Default)]
pub(super) struct ColorCollector {
    seen: HashSet<[u32; 3]>,
    colors: Vec<Rgb>,
    hull: Option<HullBuilder>,
}

impl ColorCollector {
    pub(super) fn add_row(&mut self, r: &[f32], g: &[f32], b: &[f32]) {
        if self.hull.is_none() {
            let mut last = None;
            for ((r, g), b) in r.iter().zip(g).zip(b) {
                let color = [*r, *g, *b];
                // Repeated colors are common: skip them before hashing.
                if last.replace(color.map(f32::to_bits)) != Some(color.map(f32::to_bits)) {
                    self.add(color);
                }
            }
            if self.colors.len() > MANY_COLORS {
                self.hull();
            }
            return;
        }
        self.hull().add_row(r, g, b);
    }

    fn add(&mut self, color: Rgb) {
        if self.hull.is_none() && self.seen.insert(color.map(f32::to_bits)) {
            self.colors.push(color);
        }
    }

    fn hull(&mut self) -> &mut HullBuilder {
        let Self { seen, colors, hull } = self;
        hull.get_or_insert_with(|| {
            seen.clear();
            let mut builder = HullBuilder::new();
            builder.add(&std::mem::take(colors));
            builder
        })
    }

    fn merge(mut self, other: Self) -> Self {
        match other.hull {
            Some(hull) => self.hull().merge(&hull),
            None if self.hull.is_some() => self.hull().add(&other.colors),
            None => {
                other.colors.into_iter().for_each(|color| self.add(color));
                if self.colors.len() > MANY_COLORS {
                    self.hull();
                }
            }
        }
        self
    }

    pub(super) fn finish(self) -> Vec<Rgb> {
        match self.hull {
            Some(hull) => hull.finish().vertices().to_vec(),
            None => self.colors,
        }
    }
}
