//! Finds palettes that enclose a cloud of colors.

use crate::Cloud;
use crate::few::few;
use crate::found::{Enclosing, Extraction, Outside, Palette};
use crate::order::{names, order};
use crate::solid::{MOST, Solid, thickened};
use crate::vector::Point;
use trochoid_weights::Hull;

/// What palettes are to be like.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Asked {
    /// How far a pixel may lie outside, in steps of 8 bits.
    pub within: f64,
    /// Colors as displayed, from 0 to 1, that are in every palette, with their names. They are rounded to a 256th of a
    /// step of 8 bits.
    pub prior: Vec<(String, [f64; 3])>,
}

/// Finds palettes of a cloud. The same cloud has the same palettes; without pixels, it has none.
///
/// The hull of the colors is simplified by merging joined corners, always by a corner that still encloses them, in
/// several runs from 24 corners on; then all corners are moved at once, by a sequence of linear programs; and they are
/// rounded to a grid. Each palette that is returned was counted to have no color outside, in whole numbers, or no color
/// farther outside than asked.
///
/// ```
/// use trochoid_palette::{Asked, Cloud, extract};
/// let mut cloud = Cloud::new();
/// for step in 0..=20 {
///     cloud.add([10 + step, 20 + 2 * step, 30]);
/// }
/// let found = extract(&cloud, &Asked::default());
/// assert_eq!(found.usual().map(|found| found.count()), Some(2));
/// let within = extract(&cloud, &Asked { within: 25.0, ..Asked::default() });
/// assert_eq!(within.fewest().map(|found| found.count()), Some(1));
/// ```
#[must_use]
pub fn extract(cloud: &Cloud, asked: &Asked) -> Extraction {
    let distinct = cloud.colors().count();
    let extremes = cloud.extremes();
    let (names, prior): (Vec<String>, Vec<[f64; 3]>) = asked.prior.iter().cloned().unzip();
    let prior: Vec<Point> = prior.iter().map(|color| color.map(|v| (v * 255.0 * 256.0).round() / 256.0)).collect();
    let all: Vec<[f32; 3]> = extremes.iter().chain(&prior).map(|color| color.map(|v| v as f32)).collect();
    let hull = Hull::new(&all);
    let corners: Vec<Point> = hull.vertices().iter().map(|color| color.map(f64::from)).collect();
    let found = |enclosing, short| Extraction { distinct, corners: corners.len(), enclosing, short };
    if extremes.is_empty() {
        return found(Vec::new(), Vec::new());
    }
    let (more, short) = match hull.dimension() {
        None | Some(0 | 1) => (vec![flat(&corners, &extremes, (&prior, &names))], Vec::new()),
        Some(2) if corners.len() <= MOST => (vec![flat(&corners, &extremes, (&prior, &names))], Vec::new()),
        dimension => {
            let own = Hull::new(&all[..extremes.len()]);
            let own: Vec<Point> = own.vertices().iter().map(|color| color.map(f64::from)).collect();
            // A planar cloud gets a thickness, since palettes of few colors are not in its plane.
            let around = if dimension == Some(2) { thickened(&own, 1.0) } else { own };
            let solid = Solid::new(cloud, &extremes, &around, asked.within, (&prior, &names));
            solid.map_or((Vec::new(), Vec::new()), |solid| solid.palettes())
        }
    };
    let least = more.first().map_or(MOST, Enclosing::count);
    let mut enclosing = if prior.is_empty() { few(&corners, &extremes, cloud, asked.within) } else { Vec::new() };
    enclosing.retain(|found| found.count() < least);
    enclosing.extend(more);
    let least = enclosing.first().map_or(0, Enclosing::count);
    found(enclosing, short.into_iter().filter(|short| short.colors.len() < least).collect())
}

/// Makes the palette of a cloud without volume: the prior colors, and the other corners of its hull.
fn flat(corners: &[Point], extremes: &[Point], (prior, known): (&[Point], &[String])) -> Enclosing {
    let shown = |point: &Point| point.map(|v| v / 255.0);
    let others: Vec<[f64; 3]> = corners.iter().filter(|corner| !prior.contains(corner)).map(shown).collect();
    let colors = prior.iter().map(shown).chain(order(&others).into_iter().map(|index| others[index]));
    let colors: Vec<[f64; 3]> = colors.collect();
    let units = [1_u32, 16, 256]
        .into_iter()
        .find(|units| prior.iter().flatten().all(|v| (v * f64::from(*units)).fract() == 0.0));
    let palette = Palette { names: names(&colors, known), colors, units: units.unwrap_or(256) };
    Enclosing::new(palette, 1.0, extremes, Outside::default())
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::found::QUIET;
    use crate::solid::Draws;
    use crate::vector::add;

    fn found(cloud: &Cloud) -> Extraction {
        extract(cloud, &Asked::default())
    }

    fn within(cloud: &Cloud, within: f64) -> Extraction {
        extract(cloud, &Asked { within, ..Asked::default() })
    }

    /// A cloud of mixes of some colors, with weights drawn by a seed.
    fn mixes(corners: &[[u8; 3]], count: usize, seed: u64) -> Cloud {
        let mut draws = Draws(seed);
        let mut cloud = Cloud::new();
        corners.iter().for_each(|corner| cloud.add(*corner));
        for _ in 0..count {
            let weights: Vec<f64> = corners.iter().map(|_| -libm::log(draws.next().max(1e-9))).collect();
            let sum: f64 = weights.iter().sum();
            let mixed = corners
                .iter()
                .zip(&weights)
                .fold([0.0; 3], |mixed, (corner, weight)| add(mixed, corner.map(|v| f64::from(v) * weight / sum)));
            cloud.add_between(mixed);
        }
        cloud
    }

    /// Tests that no color of a cloud lies farther outside of a palette than allowed, by the distances of the exact hull.
    fn encloses(found: &Enclosing, cloud: &Cloud, within: f64) {
        let scaled = |color: &[f64; 3]| color.map(|v| (v * 255.0) as f32);
        let hull = Hull::new(&found.palette.colors.iter().map(scaled).collect::<Vec<_>>());
        for color in cloud.enclosed() {
            let distance = hull.signed_distance(color.map(f64::from));
            assert!(distance <= within + 1e-9, "{color:?} lies {distance} outside of {found:?}");
        }
    }

    #[test]
    fn mixes_of_some_colors_have_a_palette_of_as_many() {
        for (seed, corners) in [
            vec![[10, 20, 30], [240, 30, 20], [30, 220, 60], [40, 60, 250]],
            vec![[20, 38, 46], [201, 143, 90], [45, 63, 82], [240, 207, 142], [255, 255, 240]],
            vec![[0, 0, 0], [250, 20, 20], [250, 240, 20], [20, 200, 240], [240, 240, 255], [60, 20, 120]],
        ]
        .into_iter()
        .enumerate()
        {
            let cloud = mixes(&corners, 4000, seed as u64);
            let found = found(&cloud);
            assert!(found.enclosing[0].count() <= corners.len(), "{found:?}");
            assert!(found.usual().is_some_and(|usual| usual.volume <= QUIET));
            for palette in &found.enclosing {
                encloses(palette, &cloud, 0.0);
                assert_eq!((palette.palette.names.len(), palette.distances.len()), (palette.count(), palette.count()));
                assert!(palette.palette.colors.iter().flatten().all(|v| (0.0..=1.0).contains(v)));
                assert!(palette.volume > 0.999, "{palette:?}");
            }
            assert!(found.enclosing.windows(2).all(|pair| pair[0].count() < pair[1].count()));
        }
    }

    #[test]
    fn the_same_cloud_has_the_same_palettes() {
        let corners = [[20, 38, 46], [201, 143, 90], [45, 63, 82], [240, 207, 142], [255, 255, 240], [90, 0, 60]];
        let once = || found(&mixes(&corners, 2000, 5));
        assert_eq!(once(), once());
    }

    #[test]
    fn clouds_without_volume_have_the_corners_of_their_hulls() {
        let of = |colors: &[[u8; 3]]| {
            let mut cloud = Cloud::new();
            colors.iter().for_each(|color| cloud.add(*color));
            extract(&cloud, &Asked::default())
        };
        assert_eq!(of(&[]).usual(), None);
        let one = of(&[[7, 8, 9], [7, 8, 9]]);
        assert_eq!(
            (one.distinct, one.usual().map(|found| found.palette.colors.clone())),
            (1, Some(vec![[7, 8, 9].map(|v| f64::from(v) / 255.0)]))
        );
        let grays: Vec<[u8; 3]> = (3..=250).map(|v| [v; 3]).collect();
        assert_eq!(
            of(&grays).usual().map(|found| found.palette.names.clone()),
            Some(vec!["black".into(), "white".into()])
        );
        let plane: Vec<[u8; 3]> = (0..50).flat_map(|x| (0..40).map(move |y| [x, y, 7])).collect();
        assert_eq!(of(&plane).usual().map(Enclosing::count), Some(4));
        // A disc has more corners than a palette has colors, so it gets a thickness.
        let disc = (0..=60).flat_map(|x| (0..=60).map(move |y| [x, y, 30])).collect::<Vec<[u8; 3]>>();
        let disc: Vec<[u8; 3]> = disc
            .into_iter()
            .filter(|[x, y, _]| (f64::from(*x) - 30.0).powi(2) + (f64::from(*y) - 30.0).powi(2) <= 900.0)
            .collect();
        let found = of(&disc);
        assert!(found.usual().is_some_and(|found| found.count() <= 8), "{found:?}");
    }

    #[test]
    fn noise_has_the_corners_of_the_cube() {
        let mut draws = Draws(9);
        let mut cloud = Cloud::new();
        for _ in 0..200_000 {
            cloud.add([(); 3].map(|()| (256.0 * draws.next()) as u8));
        }
        let found = found(&cloud);
        let usual = found.usual().expect("the cube encloses everything");
        assert!(usual.count() <= 8 && usual.volume < 1.2, "{usual:?}");
        encloses(usual, &cloud, 0.0);
        assert!(found.short.iter().all(|short| short.share > 0.0 && short.outside.largest >= short.outside.rms));
    }

    #[test]
    fn fewer_colors_do_if_pixels_may_lie_a_little_outside() {
        let corners = [[20, 38, 46], [201, 143, 90], [45, 63, 82], [240, 207, 142], [255, 255, 240], [90, 0, 60]];
        let cloud = mixes(&corners, 4000, 11);
        let mut counts = Vec::new();
        for reach in [0.0, 0.5, 4.0, 16.0, 60.0, 300.0] {
            let found = within(&cloud, reach);
            for palette in &found.enclosing {
                encloses(palette, &cloud, reach);
                assert_eq!(palette.outside, palette.palette.outside(&cloud), "{reach}");
            }
            assert!(found.enclosing.windows(2).all(|pair| pair[0].count() < pair[1].count()));
            assert!(found.short.iter().all(|short| short.outside.largest > reach));
            counts.push(found.fewest().map(Enclosing::count));
        }
        assert!(counts.is_sorted_by(|a, b| a >= b) && counts[0] > counts[3], "{counts:?}");
        assert_eq!(counts[5], Some(1), "{counts:?}");
    }

    #[test]
    fn clouds_that_are_nearly_flat_have_flat_palettes() {
        let mut cloud = Cloud::new();
        for v in 10..=240_u8 {
            let wave = (f64::from(v) / 9.0).sin();
            cloud.add([v, (f64::from(v) + 2.0 * wave).round() as u8, (f64::from(v) - 2.0 * wave).round() as u8]);
        }
        assert!(found(&cloud).fewest().is_some_and(|found| found.count() >= 4));
        let line = within(&cloud, 4.0);
        assert_eq!(line.fewest().map(Enclosing::count), Some(2));
        encloses(&line.enclosing[0], &cloud, 4.0);
        for v in 0..60_u8 {
            cloud.add([120 + v, 120, 120 - v]);
        }
        let plane = within(&cloud, 5.0);
        assert_eq!(plane.fewest().map(Enclosing::count), Some(3));
        encloses(&plane.enclosing[0], &cloud, 5.0);
    }

    #[test]
    fn prior_colors_are_kept_and_few_are_added() {
        let corners = [[20, 38, 46], [201, 143, 90], [45, 63, 182], [240, 207, 142], [255, 255, 240], [90, 0, 60]];
        // A little smaller, since the steps around a mix are enclosed, too.
        let inside = corners.map(|corner: [u8; 3]| corner.map(|v| (0.9 * f64::from(v) + 12.0) as u8));
        let cloud = mixes(&inside, 4000, 12);
        let named = |colors: &[[u8; 3]]| {
            let color =
                |(index, color): (usize, &[u8; 3])| (format!("own_{index}"), color.map(|v| f64::from(v) / 255.0));
            Asked { within: 0.0, prior: colors.iter().enumerate().map(color).collect() }
        };
        let plain = found(&cloud).fewest().map_or(0, Enclosing::count);
        // All, none missing; some missing; one that lies inside; one that lies far out.
        let some: [&[[u8; 3]]; 4] = [&corners, &corners[..4], &[[120, 110, 100]], &[[0, 255, 0]]];
        for prior in some {
            let asked = named(prior);
            let found = extract(&cloud, &asked);
            assert!(!found.enclosing.is_empty());
            for palette in &found.enclosing {
                encloses(palette, &cloud, 0.0);
                for (index, (name, color)) in asked.prior.iter().enumerate() {
                    assert_eq!((&palette.palette.names[index], palette.palette.colors[index]), (name, *color));
                }
            }
            let fewest = found.enclosing[0].count();
            match prior.len() {
                6 => assert_eq!(fewest, 6),
                4 => assert!(fewest <= 7, "{found:?}"),
                _ => assert!(fewest <= plain + 1, "{found:?}"),
            }
        }
        let found = extract(&cloud, &named(&[[120, 110, 100]]));
        assert_eq!(found.enclosing[0].palette.inner(), [0]);
    }

    #[test]
    fn prior_colors_of_flat_clouds() {
        let mut cloud = Cloud::new();
        (20..200).for_each(|v| cloud.add([v; 3]));
        let asked = |colors: &[[f64; 3]]| {
            let prior = colors.iter().map(|color| ("own".to_owned(), *color)).collect();
            extract(&cloud, &Asked { within: 0.0, prior })
        };
        let gray = |v: f64| [v / 255.0; 3];
        // A gray at an end leaves one to add, a gray within both, and a color beside them makes a triangle.
        assert_eq!(asked(&[gray(10.0)]).fewest().map(Enclosing::count), Some(2));
        assert_eq!(asked(&[gray(100.0)]).fewest().map(Enclosing::count), Some(3));
        let red = asked(&[[1.0, 0.0, 0.0]]);
        assert_eq!(red.fewest().map(Enclosing::count), Some(3));
        encloses(&red.enclosing[0], &cloud, 0.0);
        // Colors between the steps keep their places up to a 512th of a step.
        let fine = asked(&[[0.123_456; 3]]);
        assert!((fine.enclosing[0].palette.colors[0][0] - 0.123_456).abs() < 1.0 / 255.0 / 512.0);
        assert_eq!(fine.enclosing[0].palette.units, 256);
    }
}
