//! Claws: ribbons with thumbs in the picture, such as foam rooted in a surface; finds the pixels inside them and computes
//! what is drawn there.

mod lanes;
mod ribbon;

pub use ribbon::{Ribbon, RibbonPoint, Shape};

use fearless_simd::{Level, Simd, dispatch};
use lanes::{Deepest, LANES};
use ribbon::STEPS;
use trochoid_image::Window;
use trochoid_memory::Scratch;

/// A ribbon with its thumbs.
pub struct Claw {
    /// Ribbons, each with its random number. Where a point lies equally deep in two, the later one wins.
    pub parts: Vec<(Ribbon, f64)>,
    /// Depth of the root.
    pub depth: f64,
    /// Side to which the ribbon bends: 1 is right, −1 is left.
    pub side: f64,
    /// Number of its row, counted from 1.
    pub row: f64,
    /// Value passed on to the outputs.
    pub tag: f64,
    /// Widths of the ink along the outer and inner edges, in pixels.
    pub line: [f64; 2],
    /// Size of the shading crescent.
    pub shade: f64,
}

/// Values of all outputs at a point in a claw.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Drawn {
    /// Fraction of the pixel that the claw covers.
    pub mask: f64,
    /// Position along the ribbon: 0 at the root, 1 at the tip.
    pub along: f64,
    /// Position across the ribbon: −1 at the left edge, 1 at the right edge, seen from the root.
    pub across: f64,
    /// Half the width of the ribbon, in pixels.
    pub half_width: f64,
    /// Side to which the claw bends.
    pub side: f64,
    /// Random number of the ribbon.
    pub random: f64,
    /// Row of the claw.
    pub row: f64,
    /// Distance to the edge, in pixels.
    pub inset: f64,
    /// Tag of the claw.
    pub tag: f64,
    /// Strength of the ink along the edges, in [0, 1].
    pub ink: f64,
    /// Strength of the shading on the inner side, in [0, 1].
    pub shade: f64,
}

/// Ranges along the ribbon over which the ink fades in, on the outer and inner edges.
const OUTER_INK: [f64; 2] = [0.06, 0.3];
const INNER_INK: [f64; 2] = [0.35, 0.65];
/// Largest width of the ink, as a fraction of half the ribbon's width.
const MOST_INK: f64 = 0.62;
/// The shading crescent: where along the ribbon it is widest, how far it reaches to either side, its width there (in
/// half widths, for a `shade` of 1), and the loss of width at its ends.
const CRESCENT_MIDDLE: f64 = 0.42;
const CRESCENT_REACH: f64 = 0.4;
const CRESCENT_WIDTH: f64 = 0.98;
const CRESCENT_LOSS: f64 = 0.8;

impl Claw {
    /// Returns the bounding box: minimum and maximum of x, then of y.
    pub fn bounds(&self) -> [[f64; 2]; 2] {
        [0, 1].map(|axis: usize| {
            let ends = self.parts.iter().map(|(ribbon, _)| ribbon.bounds()[axis]);
            ends.fold([f64::INFINITY, f64::NEG_INFINITY], |all, [low, high]| [all[0].min(low), all[1].max(high)])
        })
    }

    /// Returns the position of a point within the claw, and the random number of the ribbon it lies in.
    pub fn at(&self, place: [f64; 2]) -> Option<(RibbonPoint, f64)> {
        let parts = self.parts.iter().map(|(ribbon, random)| ribbon.at(place).map(|within| (within, *random)));
        parts.fold(None, united)
    }

    /// Returns the outputs at a position within a ribbon of this claw that has the given random number.
    pub fn drawn(&self, within: RibbonPoint, random: f64) -> Drawn {
        let RibbonPoint { along, across, half_width } = within;
        // t = across·side: 1 at the inner edge, −1 at the outer one.
        let (inner, inset) = (across * self.side, within.inset());
        let eased = |[from, to]: [f64; 2]| {
            let t = ((along - from) / (to - from)).clamp(0.0, 1.0);
            t * t * (3.0 - 2.0 * t)
        };
        // ink = clamp(½ + line − i) with the inset i.
        let line = if inner < 0.0 { self.line[0] * eased(OUTER_INK) } else { self.line[1] * eased(INNER_INK) };
        let line = line.min(MOST_INK * half_width);
        let ink = if line > 0.0 { (0.5 + line - inset).clamp(0.0, 1.0) } else { 0.0 };
        // shade = clamp(½ + h·(t − 1 + shade·(0.98 − 0.8·((s − 0.42)/0.4)²))) with half the width h, and s from 0 at
        // the root to 1 at the tip.
        let middle = (along - CRESCENT_MIDDLE) / CRESCENT_REACH;
        let crescent = inner - 1.0 + self.shade * (CRESCENT_WIDTH - CRESCENT_LOSS * middle * middle);
        let shade = if self.shade > 0.0 { (0.5 + half_width * crescent).clamp(0.0, 1.0) } else { 0.0 };
        let (mask, &Self { side, row, tag, .. }) = (inset.min(1.0), self);
        Drawn { mask, along, across, half_width, side, random, row, inset, tag, ink, shade }
    }
}

/// Returns whichever of two ribbons a point lies deeper in; the latter if both are equal.
fn united(all: Option<(RibbonPoint, f64)>, part: Option<(RibbonPoint, f64)>) -> Option<(RibbonPoint, f64)> {
    match (all, part) {
        (Some((first, _)), Some((second, _))) if second.inset() < first.inset() => all,
        (_, None) => all,
        _ => part,
    }
}

/// Positions of samples within a claw, each with the random number of its ribbon. Kept between calls to reuse the
/// memory.
#[derive(Default)]
pub struct Places {
    all: Scratch<Option<(RibbonPoint, f64)>>,
    /// Those within one ribbon, and the x of its samples, in groups of neighbors.
    part: Scratch<Deepest>,
    columns: Scratch<[f64; LANES]>,
    /// Whether any sample of each group is asked for, if only some are.
    asked: Scratch<bool>,
}

impl Places {
    /// Finds the samples of a window, at an offset within their pixels, row by row. The results are those of
    /// [`Claw::at`], but faster: each segment of a spine visits only the pixels of its bounding box, several at once. If
    /// `only` says which pixels are asked for, others may get any result.
    pub fn find(
        &mut self,
        claw: &Claw,
        window: Window,
        offset: [f64; 2],
        only: Option<&dyn Fn(i64, i64) -> bool>,
    ) -> &[Option<(RibbonPoint, f64)>] {
        self.all.clear();
        self.all.resize(window.area(), None);
        for (ribbon, random) in &claw.parts {
            let around = covered(ribbon.bounds(), window);
            if around.area() == 0 {
                continue;
            }
            self.find_part(ribbon, around, offset, only);
            for (y, part) in (around.y0..).zip(self.part.chunks_exact(self.columns.len())) {
                let first = (y - window.y0) as usize * window.width() + (around.x0 - window.x0) as usize;
                for (all, part) in self.all[first..][..around.width()].chunks_mut(LANES).zip(part) {
                    for (lane, all) in all.iter_mut().enumerate() {
                        *all = united(*all, part.at(lane).map(|within| (within, *random)));
                    }
                }
            }
        }
        &self.all
    }

    /// Finds the samples of a window in one ribbon. The last group of a row may reach beyond the window.
    fn find_part(
        &mut self,
        ribbon: &Ribbon,
        around: Window,
        offset: [f64; 2],
        only: Option<&dyn Fn(i64, i64) -> bool>,
    ) {
        self.columns.clear();
        self.columns.extend(
            (around.x0..around.x1)
                .step_by(LANES)
                .map(|first| std::array::from_fn(|lane| (first + lane as i64) as f64 + offset[0])),
        );
        let groups = self.columns.len();
        self.part.clear();
        self.part.resize(groups * around.height(), Deepest::NONE);
        self.asked.clear();
        if let Some(only) = only {
            for y in around.y0..around.y1 {
                let firsts = (around.x0..around.x1).step_by(LANES);
                self.asked.extend(firsts.map(|x| (x..around.x1.min(x + LANES as i64)).any(|x| only(x, y))));
            }
        }
        dispatch!(Level::new(), simd => simd.vectorize(#[inline(always)] || {
            for step in 0..STEPS {
                let (segment, covered) = (ribbon.segment(step), covered(ribbon.segment_bounds(step), around));
                if covered.area() == 0 {
                    continue;
                }
                let [first, end] = [covered.x0, covered.x1].map(|x| (x - around.x0) as usize);
                let within = first / LANES..end.div_ceil(LANES);
                for y in covered.y0..covered.y1 {
                    let first = (y - around.y0) as usize * groups;
                    let row = &mut self.part[first..][within.clone()];
                    let row = row.iter_mut().zip(&self.columns[within.clone()]);
                    if self.asked.is_empty() {
                        row.for_each(|(deepest, x)| deepest.deepen(simd, &segment, x, y as f64 + offset[1]));
                        continue;
                    }
                    for ((deepest, x), asked) in row.zip(&self.asked[first..][within.clone()]) {
                        if *asked {
                            deepest.deepen(simd, &segment, x, y as f64 + offset[1]);
                        }
                    }
                }
            }
        }));
    }
}

/// Returns the pixels of a window whose samples may lie within a bounding box.
pub fn covered([[x0, x1], [y0, y1]]: [[f64; 2]; 2], window: Window) -> Window {
    let [x0, y0] = [x0, y0].map(|low| low.floor() as i64);
    let [x1, y1] = [x1, y1].map(|high| high.floor() as i64 + 1);
    Window::new(x0, y0, x1.max(x0), y1.max(y0)).intersect(window)
}
