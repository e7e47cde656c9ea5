//! Curvature: how sharply a surface bends.

use super::{NORMAL, Neighborhood, POSITION, change, grown, may_see, surface_of, view_planes, view_vector};
use trochoid_graph::*;
use trochoid_image::{Format, Window};
use trochoid_scene::DVec3;

/// The mean curvature of the surface: positive on crests, negative in troughs.
///
/// # Formula
/// H = (eG − 2fF + gE)/(2(EG − F²)). E, F, G are the products of the changes of position P from pixel to pixel; e =
/// Pₓ·Nₓ, g = P_y·N_y and 2f = Pₓ·N_y + P_y·Nₓ are those with the changes of the normal N. A sphere of radius r seen
/// from outside has 1/r.
///
/// # Edge cases
/// 0 where nothing is seen, and where no neighboring pixel sees the same surface. Changes are taken over `reach`
/// pixels to both sides, so the footprint grows with distance, and finer bends are smoothed away; if only one of two
/// neighbors sees the same surface, to that side alone. Where one wave stands in front of another, the jump in position
/// gives nearly 0. It is 0 where EG − F² ≤ 10⁻⁶·EG.
///
/// # Source
/// Weingarten's equations; do Carmo, Differential Geometry of Curves and Surfaces, 3-3.
#[derive(Clone, Node)]
#[node(stage, end = Front, revision = 1, output(curvature: Kind::Field(1) = "Mean curvature, 1/m."))]
pub(crate) struct Curvature {
    /// View of the surface.
    view: One<port::View>,
    /// Distance to each side over which changes are taken.
    #[knob(default = 1, range = 1..=64, in_pixels)]
    reach: i64,
}

impl Node for Curvature {}

impl Stage for Curvature {
    fn required_channels(&self, _wanted: &[bool]) -> ChannelSet {
        ChannelSet::of(&NORMAL).union(ChannelSet::of(&POSITION)).union(Channel::Coverage.into())
    }

    fn optional_channels(&self, _wanted: &[bool]) -> ChannelSet {
        Channel::Surface.into()
    }

    fn regions_of_interest(&self, _port: PortId, window: Window, _format: Format) -> Window {
        grown(window, self.reach)
    }

    fn depends_on_format(&self) -> bool {
        false
    }

    fn prepare(&self, _prepare: &Prepare<'_>) -> Result<Box<dyn Prepared>, NodeError> {
        Ok(Box::new(self.clone()))
    }
}

/// Position and normal of a sample.
type Point = [DVec3; 2];

/// Smallest area, as a share of the product of its sides, that does not count as degenerate.
const FLAT: f64 = 1e-6;

/// Returns the mean curvature at a point, given the samples left and right, above and below that see the same surface.
fn curvature(here: Point, beside: [[Option<Point>; 2]; 2]) -> f64 {
    let along = |[before, after]: [Option<Point>; 2]| -> Option<Point> {
        let of = |index: usize| change(before.map(|p| p[index]), here[index], after.map(|p| p[index]));
        Some([of(0)?, of(1)?])
    };
    let [Some([px, nx]), Some([py, ny])] = beside.map(along) else { return 0.0 };
    let (e, f, g) = (px.length_squared(), px.dot(py), py.length_squared());
    let area = e * g - f * f;
    let bend = px.dot(nx) * g - (px.dot(ny) + py.dot(nx)) * f + py.dot(ny) * e;
    let curvature = bend / (2.0 * area);
    // Positions collapsed by rounding span no area and carry no information.
    if area > FLAT * e * g && curvature.is_finite() { curvature } else { 0.0 }
}

/// Position and normal of a sample, each coordinate known up to a span.
type NearPoint = [[Span; 3]; 2];

/// Returns the span of [`curvature`] for points known up to spans.
fn may_bend(here: NearPoint, beside: [[Option<NearPoint>; 2]; 2]) -> Span {
    let along = |[before, after]: [Option<NearPoint>; 2]| -> Option<NearPoint> {
        let of = |index: usize, axis: usize| {
            let own = |point: NearPoint| point[index][axis];
            change(before.map(own), own(here), after.map(own))
        };
        before.or(after)?;
        let nothing = Span::exactly(0.0);
        Some([0, 1].map(|index| [0, 1, 2].map(|axis| of(index, axis).unwrap_or(nothing))))
    };
    let [Some([px, nx]), Some([py, ny])] = beside.map(along) else { return Span::exactly(0.0) };
    let dot = |a: [Span; 3], b: [Span; 3]| a[0] * b[0] + a[1] * b[1] + a[2] * b[2];
    let (e, f, g) = (dot(px, px), dot(px, py), dot(py, py));
    let (area, least) = (e * g - f * f, e * g * FLAT);
    let bend = dot(px, nx) * g - (dot(px, ny) + dot(py, nx)) * f + dot(py, ny) * e;
    if area.low > least.high {
        bend / (area * 2.0)
    } else if area.high < least.low {
        Span::exactly(0.0)
    } else {
        Span::unclear(f64::NAN, f64::NAN)
    }
}

impl Prepared for Curvature {
    fn fill(&self, block: &Block<'_>, inputs: &Inputs<'_>, outputs: &mut Outputs<'_>) -> Result<(), NodeError> {
        let Some(plane) = outputs.only(0) else { return Ok(()) };
        let around = Neighborhood::of(inputs, &self.view);
        let (positions, normals) = (view_planes(inputs, &self.view, POSITION), view_planes(inputs, &self.view, NORMAL));
        let surfaces = around.surfaces();
        let vector = |planes: [&[f32]; 3], index: usize| DVec3::from(planes.map(|plane| f64::from(plane[index])));
        let point = |index: usize| [vector(positions, index), vector(normals, index)];
        let window = block.window;
        let pixels = (window.y0..window.y1).flat_map(|y| (window.x0..window.x1).map(move |x| (x, y)));
        for (out, (x, y)) in plane.iter_mut().zip(pixels) {
            let here = around.index(x, y);
            if surfaces[here] < 0.0 {
                *out = 0.0;
                continue;
            }
            let at = |dx: i64, dy: i64| {
                let there = around.index(x + dx * self.reach, y + dy * self.reach);
                (surfaces[there] == surfaces[here]).then(|| point(there))
            };
            *out = curvature(point(here), [[at(-1, 0), at(1, 0)], [at(0, -1), at(0, 1)]]) as f32;
        }
        Ok(())
    }

    fn bound(&self, bounding: &Bounding<'_>, outputs: &mut Outputs<'_>) -> Result<(), NoBound> {
        let around = Neighborhood::of(bounding.inputs, &self.view);
        let point = |there: usize| {
            [POSITION, NORMAL].map(|channels| channels.map(|channel| bounding.certain(&self.view, channel, there)))
        };
        let mut pixels = bounding.block.pixels();
        bounding.bound_by(outputs, SoleOutput, 0, |_| {
            let [x, y] = pixels.next().unwrap_or_default();
            let here = around.index(x, y);
            let own = may_see(bounding, &self.view, here);
            let mut known = own.is_exact();
            if known && own.low < 0.0 {
                return Span::exactly(0.0);
            }
            let mut at = |dx: i64, dy: i64| {
                let there = around.index(x + dx * self.reach, y + dy * self.reach);
                let seen = may_see(bounding, &self.view, there);
                known &= seen.is_exact();
                (seen.low == own.low).then(|| point(there))
            };
            let beside = [[at(-1, 0), at(1, 0)], [at(0, -1), at(0, 1)]];
            if known { may_bend(point(here), beside) } else { Span::unclear(f64::NAN, f64::NAN) }
        });
        Ok(())
    }

    fn reference(&self, inputs: &References<'_>) -> Result<Vec<Reference>, NodeError> {
        let surface = surface_of(inputs, &self.view);
        let point =
            |inputs: &References<'_>| [POSITION, NORMAL].map(|channels| view_vector(inputs, &self.view, channels));
        let at = |dx: i64, dy: i64| {
            let there = inputs.moved((dx * self.reach) as f64, (dy * self.reach) as f64);
            (surface_of(&there, &self.view) == surface).then(|| point(&there))
        };
        let value =
            if surface < 0.0 { 0.0 } else { curvature(point(inputs), [[at(-1, 0), at(1, 0)], [at(0, -1), at(0, 1)]]) };
        Ok(vec![Reference::Field(vec![value])])
    }
}
