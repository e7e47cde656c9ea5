//! Additional supporting planes for hulls that are nearly flat or nearly a needle.
//!
//! The facets of such a hull meet with almost opposite normals. A point far beyond the rim may then exceed every
//! plane by less than the rounding error. Planes across the rim compensate for this: for a hull of width w in
//! direction n, the sides of its projection along n. A point that is within these sides and between the two planes of
//! the width has the same projection as some point of the hull, so it is within w of the hull, independently of the
//! facets. Together with the facets, whose rounding error ε is amplified by at most 1/w, the verdict is accurate to
//! min(w, ε/w) ≤ √ε, about 10⁻⁷ of the largest coordinate in the worst case; and to ε/10⁻³ if the hull is not thin.

use super::shape::convex_chain;
use super::vector::{Point, along, cross, dot, length, sub, unit};
use super::{Facet, MANY_PRODUCTS, supporting};

/// Ratio of width to length below which a hull is thin.
const THIN: f64 = 1e-3;

/// Returns redundant half-spaces across the rim of a thin hull; none for other hulls, or for hulls without area.
pub(super) fn guards(dimension: u8, facets: &[Facet], corners: &[Point]) -> Vec<Facet> {
    let (Some(&start), 2 | 3) = (corners.first(), dimension) else {
        return Vec::new();
    };
    let end = farthest(start, corners);
    let axis = sub(farthest(end, corners), end);
    // The first two half-spaces of a polygon are its plane.
    let sides = if dimension == 2 { &facets[2..] } else { facets };
    let stride = 1 + sides.len().saturating_mul(corners.len()) / MANY_PRODUCTS;
    let widths = sides.iter().step_by(stride).map(|facet| (facet, width(facet, corners)));
    let Some((flattest, least)) = widths.min_by(|a, b| a.1.total_cmp(&b.1)) else {
        return Vec::new();
    };
    if least >= THIN * length(axis) {
        return Vec::new();
    }
    let normal = flattest.normal;
    let u = unit(along(axis, -dot(axis, normal), normal));
    let caps = [u, u.map(|v| -v)];
    if dimension == 2 {
        return supporting(caps.to_vec(), corners);
    }
    let v = cross(normal, u);
    let flat: Vec<Point> = corners.iter().map(|&corner| [dot(u, corner), dot(v, corner), 0.0]).collect();
    let rim = convex_chain(&flat, 2);
    let next = rim.iter().cycle().skip(1);
    let across = rim.iter().zip(next).map(|(&a, &b)| {
        let [x, y, _] = unit(sub(flat[b as usize], flat[a as usize]));
        along(u.map(|c| c * y), -x, v)
    });
    let normals = across.chain(caps).collect();
    let rim: Vec<Point> = rim.iter().map(|&index| corners[index as usize]).collect();
    supporting(normals, &rim)
}

fn width(facet: &Facet, corners: &[Point]) -> f64 {
    let lowest = corners.iter().fold(f64::INFINITY, |lowest: f64, &corner| lowest.min(dot(facet.normal, corner)));
    facet.offset - lowest
}

fn farthest(from: Point, corners: &[Point]) -> Point {
    let distance = |&&p: &&Point| length(sub(p, from));
    corners.iter().max_by(|a, b| distance(a).total_cmp(&distance(b))).copied().unwrap_or(from)
}
