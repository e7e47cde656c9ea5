//! Labels beside points, without overlap.

use super::{Area, INK, Outcome, SMALL, at, font};
use plotters::prelude::*;
use plotters::style::text_anchor::HPos;

/// Box: left, top, right, bottom.
type Corners = [i32; 4];

/// Bounds for labels, and the boxes that are taken already.
pub(super) struct Labels {
    bounds: Corners,
    taken: Vec<Corners>,
}

impl Labels {
    /// Creates empty bounds for labels.
    pub(super) fn within(bounds: Corners) -> Self {
        Self { bounds, taken: Vec::new() }
    }

    /// Keeps labels away from a symbol.
    pub(super) fn keep_clear(&mut self, (x, y): (i32, i32)) {
        self.taken.push([x - 7, y - 7, x + 7, y + 7]);
    }

    /// Writes a label beside a point, as near as there is room, with a leader line if it is not adjacent to the point.
    pub(super) fn put(&mut self, area: &Area<'_>, point: (i32, i32), text: &str) -> Outcome<()> {
        let style = font(SMALL);
        let (width, height) = area.estimate_text_size(text, &style)?;
        let (width, height) = (width as i32, height as i32);
        let boxed = |(dx, dy): (i32, i32)| -> Corners {
            let left = if dx < 0 { point.0 + dx - width } else { point.0 + dx };
            let top = point.1 + dy - height / 2;
            [left, top, left + width, top + height]
        };
        let places = [0, 14, 26, 38, 50, 64, 78, 92, 110].into_iter().flat_map(|far: i32| {
            let aside = 12 + far / 3;
            [(aside, -far), (aside, far), (-aside, -far), (-aside, far)]
        });
        let cost = |place: &(i32, i32)| {
            let own = boxed(*place);
            let outside = overlap(own, self.bounds) < (own[2] - own[0]) * (own[3] - own[1]);
            let covered: i32 = self.taken.iter().map(|taken| overlap(own, *taken)).sum();
            covered + if outside { 100_000 } else { 0 }
        };
        // Among equally good places the first wins; places farther away come later.
        let Some(place) = places.min_by_key(cost) else { return Ok(()) };
        let own = boxed(place);
        let middle = (own[1] + own[3]) / 2;
        let (edge, anchor) = if place.0 < 0 { (own[2], HPos::Right) } else { (own[0], HPos::Left) };
        if place.1.abs() > 14 {
            let near = if place.0 < 0 { edge + 3 } else { edge - 3 };
            area.draw(&PathElement::new([point, (near, middle)], INK.mix(0.35).stroke_width(1)))?;
        }
        area.draw(&Text::new(text.to_owned(), (edge, middle), style.pos(at(anchor))))?;
        self.taken.push([own[0] - 3, own[1] - 1, own[2] + 3, own[3] + 1]);
        Ok(())
    }
}

/// Returns the area that two boxes share.
fn overlap(a: Corners, b: Corners) -> i32 {
    let side = |low: usize, high: usize| (a[high].min(b[high]) - a[low].max(b[low])).max(0);
    side(0, 2) * side(1, 3)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn labels_of_one_point_do_not_overlap() {
        let mut labels = Labels::within([0, 0, 600, 400]);
        labels.keep_clear((300, 200));
        super::super::svg(400, |area| (0..8).try_for_each(|n| labels.put(area, (300, 200), &format!("settings {n}"))))
            .unwrap();
        let boxes = &labels.taken;
        for (index, own) in boxes.iter().enumerate() {
            assert!(boxes[..index].iter().all(|other| overlap(*own, *other) <= 8 * 8), "{boxes:?}");
            assert!(own[0] >= -3 && own[2] <= 603, "{own:?}");
        }
        assert_eq!(boxes.len(), 9);
    }
}
