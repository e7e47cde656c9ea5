//! LineSet: parallel tapering lines, like those a carver cuts into a wood block.

use crate::filter::numbers;
use crate::view::grown;
use trochoid_field::random::{draw, key};
use trochoid_graph::*;
use trochoid_image::{Format, Window};

/// Masks of parallel lines that each taper to their own end, like the carved lines of a printed wave. Several widths
/// give several masks, one inside the other.
///
/// # Formula
/// `place` is (q, v). Line i lies at q = i + ½ + jitter·(h₁ − ½) and runs from v₀ = mix(begin, h₃) to v₁ = mix(end,
/// h₄). Half its width is e = ½·width·thickness·(1 + vary·(h₂ − ½))·√clamp((v₁ − v)/(tail·(v₁ − v₀)))·√clamp((v −
/// v₀)/head). Width number k, counted from 0, uses q − k·lean and v − k·lag instead of q and v. A line at distance d is
/// drawn at least one pixel wide: (2e/W)·clamp(½ + (W/2 − d)/c) with c = |∇q| and W = max(2e, c). The mask is the
/// maximum over all lines, and fades out as c grows from ½/finest to 1/finest.
///
/// # Edge cases
/// h₁ to h₄ are random numbers that depend only on the line and the seed, so lines keep their shape when places move. ∇
/// is the smaller of the differences to both sides, so borders of surfaces do not widen lines. The masks are 0 where
/// the thickness is 0 or the place is not finite. Outputs beyond the list of widths are 0. `head` or `tail` 0 gives
/// blunt ends.
///
/// # Source
/// The drift lines of Dadfar and Welling, section 5.1, and the lines of Hokusai's Great Wave.
#[derive(Clone, Node)]
#[node(stage, end = Front, revision = 1, example = r#""place": "uv", "widths": [2]"#, outputs = Out)]
pub(crate) struct LineSet {
    /// Coordinates as a field of 2 components: across the lines (1 from line to line) and along them. For example from
    /// UV.
    place: One<port::Field>,
    /// Factor of the widths at each place; 1 by default.
    thickness: Optional<port::Mask>,
    #[items]
    lines: Lines,
    /// Random seed.
    #[knob(default = 0, range = 0..=1_000_000_000)]
    seed: i64,
}

/// Knobs that apply to all lines.
#[derive(Clone, Items)]
struct Lines {
    /// Widths of the lines, one per output, as a fraction of the distance between lines; 0 to 2.
    #[knob(len = 1..=4)]
    widths: Vec<f64>,
    /// Range in which lines begin, in units of `place` along the lines.
    #[knob(default = [0.0, 0.0])]
    begin: [f64; 2],
    /// Range in which lines end, in units of `place` along the lines.
    #[knob(default = [1.0, 1.0])]
    end: [f64; 2],
    /// Length over which lines widen from their beginning to full width; 0 begins bluntly.
    #[knob(default = 0.0, range = 0.0..=1e6)]
    head: f64,
    /// Fraction of a line's length over which it tapers toward its end; 0 ends bluntly.
    #[knob(default = 1.0, range = 0.0..=1.0)]
    tail: f64,
    /// Random variation of the widths, as a fraction; 0 makes all lines equally wide.
    #[knob(default = 0.6, range = 0.0..=1.9)]
    vary: f64,
    /// Random variation of the lines' positions, as a fraction of the distance between lines.
    #[knob(default = 0.25, range = 0.0..=1.0)]
    jitter: f64,
    /// Sideways offset from each width to the next, as a fraction of the distance between lines.
    #[knob(default = 0.0, range = -1.0..=1.0)]
    lean: f64,
    /// Offset along the lines from each width to the next.
    #[knob(default = 0.0, range = -1e6..=1e6)]
    lag: f64,
    /// Distance between lines below which they have faded out; they are at full strength from twice this distance on.
    #[knob(default = 3.0, range = 0.1..=1e3, in_pixels)]
    finest: f64,
}

/// Masks of the lines, one per width.
#[derive(Clone, Copy, Debug, PartialEq, Outputs)]
enum Out {
    /// Mask of the lines with the first width.
    #[output(Kind::MASK)]
    Mask,
    /// Mask of the lines with the second width.
    #[output(Kind::MASK)]
    Second,
    /// Mask of the lines with the third width.
    #[output(Kind::MASK)]
    Third,
    /// Mask of the lines with the fourth width.
    #[output(Kind::MASK)]
    Fourth,
}

/// Largest number of widths.
const MOST: usize = Out::ALL.len();
/// Largest width.
const WIDEST: f64 = 2.0;

impl Node for LineSet {
    fn check(&self, check: &mut Check<'_>) {
        if let Some(width) = self.lines.widths.iter().find(|width| !(0.0..=WIDEST).contains(*width)) {
            let remedy = "reduce the width, or increase the distance between lines";
            check.error(Lines::WIDTHS, width.to_string(), "shares from 0 to 2", remedy);
        }
        if let Some(kind) = check.kind(&self.place).filter(|kind| *kind != Kind::Field(2)) {
            let remedy = "combine two fields in a FieldMath: \"[a, b]\" with 2 components";
            check.error(Self::PLACE, kind.to_string(), "a Field of 2 components, across and along", remedy);
        }
    }
}

impl LineSet {
    pub(crate) fn drawn(&self) -> DrawnLines {
        DrawnLines::new(self.lines.clone(), self.seed)
    }
}

impl Stage for LineSet {
    fn is_costly(&self) -> bool {
        true
    }

    fn interval(&self, output: usize, _channel: usize) -> Option<(f64, f64)> {
        Some((0.0, if output < self.lines.widths.len() { 1.0 } else { 0.0 }))
    }

    fn regions_of_interest(&self, port: PortId, window: Window, _format: Format) -> Window {
        if port == self.place.id() { grown(window, 1) } else { window }
    }

    fn depends_on_format(&self) -> bool {
        false
    }

    fn prepare(&self, _prepare: &Prepare<'_>) -> Result<Box<dyn Prepared>, NodeError> {
        Ok(Box::new(PreparedLineSet {
            place: self.place.clone(),
            thickness: self.thickness.clone(),
            drawn: self.drawn(),
        }))
    }
}

struct PreparedLineSet {
    place: One<port::Field>,
    thickness: Optional<port::Mask>,
    drawn: DrawnLines,
}

/// The lines of a seed, prepared for evaluation.
pub(crate) struct DrawnLines {
    lines: Lines,
    /// How far a line may reach from its position, before it is widened to a pixel, in distances between lines.
    farthest: f64,
    key: u64,
}

/// Properties of a line that do not depend on the place.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct Line {
    index: i64,
    pub(crate) middle: f64,
    begin: f64,
    end: f64,
    /// Factor of all widths.
    pub(crate) width: f64,
}

/// Cache of the lines used last: neighboring samples mostly need the same ones.
#[derive(Default)]
pub(crate) struct Recent([Option<Line>; 4]);

impl Recent {
    fn line(&mut self, drawing: &DrawnLines, index: i64) -> &Line {
        let slot = &mut self.0[index.rem_euclid(4) as usize];
        if slot.is_none_or(|line| line.index != index) {
            *slot = None;
        }
        slot.get_or_insert_with(|| drawing.line(index))
    }
}

/// Returns the length of the gradient of a value, from its neighbors along both axes.
fn change(here: f64, across: [f64; 2], down: [f64; 2]) -> f64 {
    let [x, y] = [across, down].map(|[before, after]| (here - before).abs().min((after - here).abs()));
    (x * x + y * y).sqrt()
}

/// Rounds down a number whose magnitude is below 2⁵³: faster than a call where processors have no instruction for it.
fn floor(number: f64) -> i64 {
    let toward_zero = number as i64;
    toward_zero - i64::from(toward_zero as f64 > number)
}

/// Smallest softness of an edge, for places that do not change from pixel to pixel.
const LEAST_CHANGE: f64 = 1e-4;
/// Distance from a line relative to that at which it ends, from which on no rounding lets it appear.
const BEYOND: f64 = 1.0 + 1e-9;
/// Largest coordinate across the lines: beyond it, f32 is too coarse to tell lines apart.
const FARTHEST: f64 = 1e6;

impl DrawnLines {
    fn new(lines: Lines, seed: i64) -> Self {
        let Lines { ref widths, vary, jitter, lean, .. } = lines;
        let widest = widths.iter().copied().fold(0.0, f64::max);
        let farthest = 0.5 * widest * (1.0 + 0.5 * vary) + 0.5 * jitter + lean.abs() * (widths.len().max(1) - 1) as f64;
        Self { lines, farthest, key: key(0x6c69_6e65, seed) }
    }

    pub(crate) fn line(&self, index: i64) -> Line {
        let line = key(self.key, index);
        let [h1, h2, h3, h4] = [1, 2, 3, 4].map(|which| draw(line, which));
        let between = |[from, to]: [f64; 2], share: f64| from + share * (to - from);
        Line {
            index,
            middle: index as f64 + 0.5 + self.lines.jitter * (h1 - 0.5),
            width: 1.0 + self.lines.vary * (h2 - 0.5),
            begin: between(self.lines.begin, h3),
            end: between(self.lines.end, h4),
        }
    }

    /// Returns the fraction of its width that a line has at a position along it.
    pub(crate) fn taper(&self, line: &Line, v: f64) -> f64 {
        if v < line.begin || v > line.end {
            return 0.0;
        }
        let share = |way: f64, of: f64| if way < of { (way / of).sqrt() } else { 1.0 };
        share(line.end - v, self.lines.tail * (line.end - line.begin)) * share(v - line.begin, self.lines.head)
    }

    /// Returns the masks at a place; `change` is the change of `q` from pixel to pixel.
    pub(crate) fn masks(&self, [q, v]: [f64; 2], change: f64, thickness: f64, recent: &mut Recent) -> [f64; MOST] {
        let mut masks = [0.0; MOST];
        let sharp = (2.0 - change * self.lines.finest * 2.0).clamp(0.0, 1.0);
        // Written so that NaN fails the test.
        if !(thickness > 0.0 && sharp > 0.0 && q.abs() <= FARTHEST && v.abs() < f64::INFINITY) {
            return masks;
        }
        let change = change.max(LEAST_CHANGE);
        let farthest = self.farthest + change;
        let [first, last] = [q - farthest - 0.5, q + farthest - 0.5].map(floor);
        for index in first..=last + 1 {
            let line = recent.line(self, index);
            for (k, (mask, width)) in masks.iter_mut().zip(&self.lines.widths).enumerate() {
                let distance = (q - k as f64 * self.lines.lean - line.middle).abs();
                // Most lines end before the place even where they are widest: they need no taper.
                let widest = (width * line.width * thickness).max(change);
                if distance > 0.5 * (widest + change) * BEYOND {
                    continue;
                }
                let taper = self.taper(line, v - k as f64 * self.lines.lag);
                let wide = width * line.width * taper * thickness;
                if wide <= 0.0 {
                    continue;
                }
                let drawn = wide.max(change);
                let value = (wide / drawn) * (0.5 + (0.5 * drawn - distance) / change).clamp(0.0, 1.0);
                *mask = f64::max(*mask, sharp * value);
            }
        }
        masks
    }
}

impl Prepared for PreparedLineSet {
    fn fill(&self, block: &Block<'_>, inputs: &Inputs<'_>, outputs: &mut Outputs<'_>) -> Result<(), NodeError> {
        let place = &inputs.all(&self.place)[0];
        let [across, along] = [0, 1].map(|axis| place.planes[axis].unwrap_or_default());
        let thickness = inputs.all(&self.thickness).first().and_then(|connection| connection.planes[0]);
        let (window, from) = (block.window, place.window);
        let column = |x: i64| (x.clamp(from.x0, from.x1 - 1) - from.x0) as usize;
        let row = |y: i64| (y.clamp(from.y0, from.y1 - 1) - from.y0) as usize * from.width();
        let mut planes = Out::ALL.map(|output| outputs.take(output, 0));
        if thickness.is_some_and(|plane| plane.iter().all(|thickness| *thickness == 0.0)) {
            planes.iter_mut().flatten().for_each(|plane| plane.fill(0.0));
            return Ok(());
        }
        let mut recent = Recent::default();
        let mut index = 0;
        for y in window.y0..window.y1 {
            let [above, here, below] = [y - 1, y, y + 1].map(row);
            for x in window.x0..window.x1 {
                let wide = thickness.map_or(1.0, |plane| f64::from(plane[index]));
                let masks = if wide > 0.0 && block.counts(index) {
                    let at = |plane: &[f32], row: usize, x: i64| f64::from(plane[row + column(x)]);
                    let q = at(across, here, x);
                    let beside = [x - 1, x + 1].map(|x| at(across, here, x));
                    let change = change(q, beside, [above, below].map(|row| at(across, row, x)));
                    self.drawn.masks([q, at(along, here, x)], change, wide, &mut recent)
                } else {
                    [0.0; MOST]
                };
                for (plane, mask) in planes.iter_mut().zip(masks) {
                    if let Some(plane) = plane {
                        plane[index] = mask as f32;
                    }
                }
                index += 1;
            }
        }
        Ok(())
    }

    fn bound(&self, _bounding: &Bounding<'_>, _outputs: &mut Outputs<'_>) -> Result<(), NoBound> {
        Err(NoBound(
            "the width of an edge depends on the difference between neighboring places, which the mask is divided by",
        ))
    }

    fn reference(&self, inputs: &References<'_>) -> Result<Vec<Reference>, NodeError> {
        let place = |dx: f64, dy: f64| {
            let numbers = numbers(&inputs.moved(dx, dy), &self.place);
            [numbers[0], numbers[1]]
        };
        let [q, v] = place(0.0, 0.0);
        let beside = [[-1.0, 0.0], [1.0, 0.0], [0.0, -1.0], [0.0, 1.0]].map(|[x, y]| place(x, y)[0]);
        let thickness = self.thickness.as_ref().map_or(1.0, |source| inputs.scalar(source));
        let change = change(q, [beside[0], beside[1]], [beside[2], beside[3]]);
        let masks = self.drawn.masks([q, v], change, thickness, &mut Recent::default());
        Ok(masks.map(Reference::Mask).to_vec())
    }
}
