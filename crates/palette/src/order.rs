//! Order and names of colors.

use crate::vector::{Point, length, sub};
use trochoid_image::oklab;

/// Most colors whose order is the best one; more are ordered by lightness.
const MOST: usize = 12;

/// Returns the order of displayed colors, from 0 to 1: the darkest first, then along the shortest way through all of
/// them in OKLab.
pub(crate) fn order(colors: &[[f64; 3]]) -> Vec<usize> {
    let seen: Vec<Point> = colors.iter().map(|color| oklab(*color)).collect();
    let count = seen.len();
    let mut by_lightness: Vec<usize> = (0..count).collect();
    by_lightness.sort_by(|a, b| seen[*a][0].total_cmp(&seen[*b][0]));
    if !(2..=MOST).contains(&count) {
        return by_lightness;
    }
    let distance = |a: usize, b: usize| length(sub(seen[a], seen[b]));
    let start = by_lightness[0];
    // Shortest ways through sets of colors, by the last color, and the color before it (Held and Karp, 1962).
    let mut best = vec![vec![(f64::INFINITY, start); count]; 1 << count];
    best[1 << start][start].0 = 0.0;
    for set in 1..1_usize << count {
        for last in (0..count).filter(|last| set >> last & 1 == 1) {
            let so_far = best[set][last].0;
            if so_far.is_infinite() {
                continue;
            }
            for next in (0..count).filter(|next| set >> next & 1 == 0) {
                let way = so_far + distance(last, next);
                let known = &mut best[set | 1 << next][next];
                if way < known.0 {
                    *known = (way, last);
                }
            }
        }
    }
    let mut set = (1 << count) - 1;
    let mut last = (0..count).min_by(|a, b| best[set][*a].0.total_cmp(&best[set][*b].0)).unwrap_or(start);
    let mut way = Vec::with_capacity(count);
    while set > 0 {
        way.push(last);
        let before = best[set][last].1;
        set &= !(1 << last);
        last = before;
    }
    way.reverse();
    way
}

/// Returns a name for a displayed color by its lightness and hue, such as `dark_blue`.
pub(crate) fn name(color: [f64; 3]) -> String {
    const HUES: [(f64, &str); 8] = [
        (12.0, "pink"),
        (45.0, "red"),
        (80.0, "orange"),
        (120.0, "yellow"),
        (165.0, "green"),
        (225.0, "teal"),
        (290.0, "blue"),
        (335.0, "violet"),
    ];
    let [lightness, a, b] = oklab(color);
    let chroma = libm::hypot(a, b);
    let degrees = libm::atan2(b, a).to_degrees().rem_euclid(360.0);
    let is_gray = chroma < 0.03;
    if is_gray && lightness > 0.9 {
        return "white".into();
    }
    if chroma < 0.05 && lightness < 0.22 {
        return "black".into();
    }
    let hue = if is_gray { "gray" } else { HUES.iter().find(|(end, _)| degrees < *end).map_or("pink", |(_, hue)| hue) };
    let shade = match lightness {
        l if l < 0.35 => "deep_",
        l if l < 0.5 => "dark_",
        l if l < 0.75 => "",
        _ if chroma > 0.18 => "bright_",
        l if l < 0.9 => "light_",
        _ => "pale_",
    };
    format!("{shade}{hue}")
}

/// Returns names for displayed colors, each once, of which the first ones are known.
pub(crate) fn names(colors: &[[f64; 3]], known: &[String]) -> Vec<String> {
    let mut names = known.to_vec();
    for color in &colors[known.len()..] {
        let plain = name(*color);
        let numbered = (2..).map(|count| format!("{plain}_{count}"));
        let free = std::iter::once(plain.clone()).chain(numbered).find(|name| !names.contains(name));
        names.push(free.unwrap_or(plain));
    }
    names
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_darkest_is_first_and_the_way_is_short() {
        let gray = |v: f64| [v; 3];
        let colors = [gray(0.9), gray(0.1), gray(0.5), gray(0.7), gray(0.3)];
        assert_eq!(order(&colors), [1, 4, 2, 3, 0]);
        let many: Vec<[f64; 3]> = (0..20).map(|i| gray(f64::from(i * 7 % 20) / 20.0)).collect();
        let sorted: Vec<f64> = order(&many).iter().map(|index| many[*index][0]).collect();
        assert!(sorted.is_sorted());
    }

    #[test]
    fn names_are_what_one_calls_them() {
        let byte = |r: u8, g: u8, b: u8| [r, g, b].map(|v| f64::from(v) / 255.0);
        for (color, expected) in [
            (byte(0, 0, 0), "black"),
            (byte(255, 255, 255), "white"),
            (byte(128, 128, 128), "gray"),
            (byte(20, 38, 120), "deep_blue"),
            (byte(240, 207, 142), "light_yellow"),
            (byte(200, 30, 30), "red"),
            (byte(255, 255, 0), "bright_yellow"),
            (byte(255, 255, 216), "pale_yellow"),
            (byte(46, 120, 60), "green"),
        ] {
            assert_eq!(name(color), expected, "{color:?}");
        }
        assert_eq!(names(&[[0.5; 3], [0.52; 3], [0.51; 3]], &[]), ["gray", "gray_2", "gray_3"]);
        assert_eq!(names(&[[0.1; 3], [0.5; 3]], &["gray".into()]), ["gray", "gray_2"]);
    }
}
