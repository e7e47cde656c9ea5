//! Clouds without their rarest colors.

use crate::Cloud;
use crate::vector::{Point, dot};
use rayon::prelude::*;

/// Directions in which planes cut off colors.
const DIRECTIONS: usize = 128;
/// Steps along a direction: no two colors are farther apart than 442.
const STEPS: usize = 885;

/// Returns directions that are spread evenly over the sphere, along a spiral (Saff and Kuijlaars, *Distributing many
/// points on a sphere*, 1997).
fn directions() -> Vec<Point> {
    let golden = std::f64::consts::PI * (3.0 - 5.0_f64.sqrt());
    let direction = |index: usize| {
        let z = 1.0 - (2.0 * index as f64 + 1.0) / DIRECTIONS as f64;
        let (turn, radius) = (golden * index as f64, (1.0 - z * z).sqrt());
        [radius * libm::cos(turn), radius * libm::sin(turn), z]
    };
    (0..DIRECTIONS).map(direction).collect()
}

/// Returns the step, from 0, at which a color lies along a direction.
fn step(direction: Point, color: [u8; 3]) -> usize {
    (dot(direction, color.map(f64::from)) + 442.0).floor().max(0.0) as usize
}

impl Cloud {
    /// Returns the cloud without its outermost colors, which have at most a share of the pixels: a palette need not
    /// reach out to a few of them.
    ///
    /// In each of 128 directions, a plane cuts off that share of the pixels. The colors farthest beyond such a plane are
    /// dropped first, as long as all that are dropped have no more than the share together.
    ///
    /// ```
    /// let mut cloud = trochoid_palette::Cloud::new();
    /// (0..999).for_each(|pixel| cloud.add([100 + (pixel % 10) as u8, 100, 100]));
    /// cloud.add([255, 0, 0]);
    /// assert!(!cloud.without(0.001).contains([255, 0, 0]));
    /// assert_eq!(cloud.without(0.0009).pixels(), 1000);
    /// ```
    #[must_use]
    pub fn without(&self, share: f64) -> Self {
        let colors: Vec<([u8; 3], u32)> = self.colors().collect();
        // Shares such as 3 of 1000 are rounded to f64.
        let most = (share.clamp(0.0, 1.0) * self.pixels() as f64 * (1.0 + 1e-12)).floor() as u64;
        let plane = |direction: Point| {
            let mut counts = vec![0_u64; STEPS];
            for (color, count) in &colors {
                counts[step(direction, *color)] += u64::from(*count);
            }
            let mut beyond = 0;
            let at = counts.iter().rposition(|count| {
                beyond += count;
                beyond > most
            });
            (direction, at.unwrap_or(0))
        };
        let planes: Vec<(Point, usize)> = directions().into_par_iter().map(plane).collect();
        let excess = |(color, count): &([u8; 3], u32)| {
            let beyond = planes.iter().map(|(direction, at)| step(*direction, *color).saturating_sub(*at));
            (beyond.max().unwrap_or(0), *color, *count)
        };
        let mut excesses: Vec<(usize, [u8; 3], u32)> = colors.par_iter().map(excess).collect();
        excesses.sort_unstable_by(|a, b| b.cmp(a));
        let mut dropped = 0;
        let mut is_dropped = |(excess, _, count): &(usize, [u8; 3], u32)| {
            dropped += u64::from(*count);
            *excess > 0 && dropped <= most
        };
        let kept = excesses.iter().skip_while(|color| is_dropped(color));
        self.keeping(kept.map(|(_, color, count)| (*color, *count)))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// A ball of colors with a few far ones.
    fn ball(far: &[[u8; 3]]) -> Cloud {
        let mut cloud = Cloud::new();
        for r in 0..20_u8 {
            for g in 0..20 {
                for b in 0..20 {
                    let at = [r, g, b].map(|v| f64::from(v) - 9.5);
                    if dot(at, at) < 81.0 {
                        cloud.add([100 + r, 100 + g, 100 + b]);
                    }
                }
            }
        }
        far.iter().for_each(|color| cloud.add(*color));
        cloud
    }

    #[test]
    fn the_farthest_colors_go_first_and_never_more_than_the_share() {
        let far = [[255, 0, 0], [0, 0, 0], [10, 250, 250], [0, 0, 255]];
        let cloud = ball(&far);
        let share = |pixels: f64| pixels / cloud.pixels() as f64;
        let all = cloud.without(share(4.0));
        assert_eq!(all.pixels(), cloud.pixels() - 4);
        assert!(far.iter().all(|color| !all.contains(*color)));
        let three = cloud.without(share(3.9));
        assert_eq!(three.pixels(), cloud.pixels() - 3);
        assert_eq!(far.iter().filter(|color| three.contains(**color)).count(), 1);
        for part in [0.0, 0.003, 0.02, 0.1, 0.5, 0.9] {
            let left = cloud.without(part);
            let dropped = (cloud.pixels() - left.pixels()) as f64;
            assert!(dropped <= part * cloud.pixels() as f64, "{part}: {dropped}");
            assert!(left.colors().all(|(color, _)| cloud.contains(color)));
            if part >= 0.02 {
                assert!(dropped > 0.5 * part * cloud.pixels() as f64, "{part}: {dropped}");
            }
        }
        assert_eq!(Cloud::new().without(0.1).pixels(), 0);
    }

    #[test]
    fn steps_between_which_a_dropped_pixel_lay_are_dropped_with_it() {
        let mut cloud = ball(&[]);
        cloud.add_between([250.5, 3.5, 3.5]);
        cloud.add_between([110.5, 110.2, 110.7]);
        let left = cloud.without(1.0 / cloud.pixels() as f64);
        assert_eq!(left.pixels(), cloud.pixels() - 1);
        assert!(!left.enclosed().any(|color| color[0] > 200));
        assert!([110, 111].into_iter().all(|r| left.contains([r, 110, 111])));
    }
}
