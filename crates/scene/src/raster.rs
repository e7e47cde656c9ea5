//! Which triangle each sample sees, and what it sees there.

use glam::DVec3;
use trochoid_image::Window;

use crate::project::{BIN, Layer, ScreenVertex};
use crate::shading::unit_or_up;
use crate::{Channel, ChannelSet, Samples, Visible};

/// The triangle that each sample of a window sees.
pub(crate) struct Seen {
    /// Primitive and which of its triangles, packed; [`NOTHING`] where there is none.
    triangles: Vec<u64>,
}

const NOTHING: u64 = u64::MAX;

/// Twice a triangle's signed area and its edge functions at points, exact in i64.
struct Edges {
    /// Edge functions A·x + B·y + C, each positive inside.
    a: [i64; 3],
    b: [i64; 3],
    c: [i64; 3],
    /// Least value inside: 0 where the edge itself belongs to the triangle, else 1.
    least: [i64; 3],
    /// Keys of the corner across from each edge, over twice the area.
    keys: [f64; 3],
}

impl Edges {
    /// `None` for a triangle without area.
    ///
    /// Both orientations are seen: where a sea folds over, its triangles turn over. A sample exactly on an edge
    /// belongs to the triangle for which the edge is a top or a left one, so that exactly one of two neighbors
    /// takes it.
    #[inline]
    fn new(mut corners: [ScreenVertex; 3]) -> Option<Self> {
        let at = |vertex: ScreenVertex| (i64::from(vertex.x), i64::from(vertex.y));
        let [(x0, y0), (x1, y1), (x2, y2)] = corners.map(at);
        let mut area = (x1 - x0) * (y2 - y0) - (y1 - y0) * (x2 - x0);
        if area == 0 {
            return None;
        }
        if area < 0 {
            corners.swap(1, 2);
            area = -area;
        }
        let (mut a, mut b, mut c, mut least) = ([0; 3], [0; 3], [0; 3], [0; 3]);
        for edge in 0..3 {
            let (px, py) = at(corners[(edge + 1) % 3]);
            let (qx, qy) = at(corners[(edge + 2) % 3]);
            a[edge] = py - qy;
            b[edge] = qx - px;
            // With positive area and y down: a left edge rises (A > 0), a top edge is level and runs right (B > 0).
            let takes_edge = a[edge] > 0 || (a[edge] == 0 && b[edge] > 0);
            c[edge] = -(a[edge] * px + b[edge] * py);
            least[edge] = i64::from(!takes_edge);
        }
        Some(Self { a, b, c, least, keys: corners.map(|corner| f64::from(corner.key) / area as f64) })
    }

    /// Key at a sample, or `None` outside.
    #[inline]
    fn key(&self, x: i64, y: i64) -> Option<f64> {
        let at = |edge: usize| self.a[edge] * x + self.b[edge] * y + self.c[edge];
        let weights = [at(0), at(1), at(2)];
        if (0..3).any(|edge| weights[edge] < self.least[edge]) {
            return None;
        }
        Some(weights[0] as f64 * self.keys[0] + weights[1] as f64 * self.keys[1] + weights[2] as f64 * self.keys[2])
    }
}

impl Visible {
    fn layer(&self, primitive: u32) -> usize {
        self.firsts.partition_point(|&first| first <= primitive) - 1
    }

    /// The nearest triangle at each sample; of two equally near ones that with the lower number.
    pub(crate) fn rasterize(&self, window: Window, offset: [f64; 2]) -> Seen {
        let inside = window.intersect(Window::sized(self.projector.size[0] as u32, self.projector.size[1] as u32));
        let mut seen = vec![NOTHING; window.area()];
        let mut keys = vec![f64::NEG_INFINITY; window.area()];
        let shift = [self.raster.fix(offset[0]), self.raster.fix(offset[1])];
        if inside.is_empty() {
            return Seen { triangles: seen };
        }
        for bin_y in inside.y0 / BIN[1]..=(inside.y1 - 1) / BIN[1] {
            for bin_x in inside.x0 / BIN[0]..=(inside.x1 - 1) / BIN[0] {
                let (x0, y0) = (bin_x * BIN[0], bin_y * BIN[1]);
                let part = inside.intersect(Window::new(x0, y0, x0 + BIN[0], y0 + BIN[1]));
                let bin = (bin_y * self.bins[0] + bin_x) as usize;
                let range = self.starts[bin] as usize..self.starts[bin + 1] as usize;
                for &primitive in &self.binned[range] {
                    let layer = self.layer(primitive);
                    let local = (primitive - self.firsts[layer]) as usize;
                    let layer = &self.layers[layer];
                    for (half, triangle) in layer.triangles(local).iter().enumerate() {
                        let corners = triangle.map(|vertex| layer.screen[vertex as usize]);
                        let number = u64::from(primitive) * 2 + half as u64;
                        self.cover(corners, part, shift, |x, y, key| {
                            let index = (y - window.y0) as usize * window.width() + (x - window.x0) as usize;
                            if key > keys[index] || (key == keys[index] && number < seen[index]) {
                                keys[index] = key;
                                seen[index] = number;
                            }
                        });
                    }
                }
            }
        }
        Seen { triangles: seen }
    }

    /// Calls `hit` with pixel and key for every sample of `part` that the triangle covers.
    #[inline]
    fn cover(&self, corners: [ScreenVertex; 3], part: Window, shift: [i64; 2], mut hit: impl FnMut(i64, i64, f64)) {
        let bits = self.raster.bits;
        let [p, q, r] = corners;
        // First and last pixel whose sample lies within the triangle's bounds.
        let range = |values: [i32; 3], shift: i64, low: i64, high: i64| {
            let least = i64::from(values[0].min(values[1]).min(values[2]));
            let most = i64::from(values[0].max(values[1]).max(values[2]));
            let first = (least - shift + (1 << bits) - 1) >> bits;
            (first.max(low), ((most - shift) >> bits).min(high - 1))
        };
        let (y0, y1) = range([p.y, q.y, r.y], shift[1], part.y0, part.y1);
        if y0 > y1 {
            return;
        }
        let (x0, x1) = range([p.x, q.x, r.x], shift[0], part.x0, part.x1);
        if x0 > x1 {
            return;
        }
        let Some(edges) = Edges::new(corners) else { return };
        for y in y0..=y1 {
            for x in x0..=x1 {
                if let Some(key) = edges.key((x << bits) + shift[0], (y << bits) + shift[1]) {
                    hit(x, y, key);
                }
            }
        }
    }

    /// Interpolates what the seen triangles carry.
    pub(crate) fn resolve(&self, seen: &Seen, window: Window, offset: [f64; 2], wanted: ChannelSet, out: &mut Samples) {
        // The offset that the raster rounded to, so that the ray meets the triangle that was found.
        let unit = f64::from(1_u32 << self.raster.bits);
        let offset = offset.map(|part| self.raster.fix(part) as f64 / unit);
        let mut index = 0;
        for y in window.y0..window.y1 {
            for x in window.x0..window.x1 {
                let number = seen.triangles[index];
                if number != NOTHING {
                    let primitive = (number / 2) as u32;
                    let surface = self.layer(primitive);
                    let layer = &self.layers[surface];
                    let local = (primitive - self.firsts[surface]) as usize;
                    let triangle = layer.triangles(local)[(number % 2) as usize];
                    let pixel = [x as f64 + offset[0], y as f64 + offset[1]];
                    self.answer(layer, surface, triangle, pixel, wanted, index, out);
                }
                index += 1;
            }
        }
    }

    #[allow(clippy::too_many_arguments, reason = "one sample's triangle, place and destination")]
    fn answer(
        &self,
        layer: &Layer,
        surface: usize,
        triangle: [u32; 3],
        pixel: [f64; 2],
        wanted: ChannelSet,
        index: usize,
        out: &mut Samples,
    ) {
        out.set(Channel::Coverage, index, 1.0);
        out.set(Channel::Surface, index, surface as f64);
        let vertices = triangle.map(|vertex| vertex as usize);
        let mesh = &layer.mesh;
        let positions = vertices.map(|vertex| glam::Vec3::from(mesh.positions[vertex]).as_dvec3());
        let (weights, outer) = self.weights(positions, pixel);
        let blend = |values: [f64; 3]| values[0] * weights[0] + values[1] * weights[1] + values[2] * weights[2];
        let offset = DVec3::from_array([0, 1, 2].map(|axis| blend(positions.map(|position| position[axis]))));
        let projector = &self.projector;
        out.set(Channel::Depth, index, offset.dot(projector.forward));
        let position = projector.position + offset;
        out.set(Channel::PositionX, index, position.x);
        out.set(Channel::PositionY, index, position.y);
        out.set(Channel::PositionZ, index, position.z);
        let height = position.y - mesh.level;
        out.set(Channel::Height, index, height);
        if wanted.intersects(ChannelSet::NORMALS) && !mesh.normals.is_empty() {
            let normal = DVec3::from_array(
                [0, 1, 2].map(|axis| blend(vertices.map(|vertex| f64::from(mesh.normals[vertex][axis])))),
            );
            out.set(Channel::Jacobian, index, if mesh.displaced { normal.y } else { 1.0 });
            // Of a side seen from the wrong side, as in a fold, the other normal counts.
            let normal = if outer == mesh.inside { -unit_or_up(normal) } else { unit_or_up(normal) };
            out.set(Channel::NormalX, index, normal.x);
            out.set(Channel::NormalY, index, normal.y);
            out.set(Channel::NormalZ, index, normal.z);
        }
        if wanted.intersects(ChannelSet::RESTS.union(ChannelSet::UV)) {
            // A surface without rest points rests where it is.
            let rest = if mesh.rests.is_empty() {
                [offset.x, offset.z]
            } else {
                [0, 1].map(|axis| blend(vertices.map(|vertex| f64::from(mesh.rests[vertex][axis]))))
            };
            // The level, or how much higher the model's own rest point stands.
            let risen = if mesh.rest_heights.is_empty() {
                0.0
            } else {
                projector.position.y + blend(vertices.map(|vertex| f64::from(mesh.rest_heights[vertex]))) - mesh.level
            };
            let place = [projector.position.x + rest[0], projector.position.z + rest[1]];
            out.set(Channel::RestX, index, place[0]);
            out.set(Channel::RestY, index, mesh.level + risen);
            out.set(Channel::RestZ, index, place[1]);
            let moved = DVec3::new(offset.x - rest[0], height - risen, offset.z - rest[1]);
            out.set(Channel::RestDistance, index, moved.length());
            let uv = if mesh.uvs.is_empty() {
                place
            } else {
                [0, 1].map(|axis| blend(vertices.map(|vertex| f64::from(mesh.uvs[vertex][axis]))))
            };
            out.set(Channel::U, index, uv[0]);
            out.set(Channel::V, index, uv[1]);
        }
        if wanted.contains(Channel::SlopeVariance) && !mesh.slope_variances.is_empty() {
            out.set(
                Channel::SlopeVariance,
                index,
                blend(vertices.map(|vertex| f64::from(mesh.slope_variances[vertex]))),
            );
        }
        if wanted.intersects(ChannelSet::TRAILS) {
            for (values, channel) in mesh.trails.iter().zip(Channel::TRAILS) {
                if wanted.contains(channel) && !values.is_empty() {
                    out.set(channel, index, blend(vertices.map(|vertex| f64::from(values[vertex]))));
                }
            }
        }
    }

    /// Barycentric weights of the point of a triangle that a pixel's ray meets, from the exact positions: the
    /// fixed-point ones only decided that it is this triangle.
    ///
    /// For a ray from the origin along r, the point Σ wᵢPᵢ is on it if w₀ : w₁ : w₂ = r·(P₁×P₂) : r·(P₂×P₀) :
    /// r·(P₀×P₁). The flag tells whether the triangle's outer side is seen. Rounding may have put the ray just
    /// beside the triangle: negative weights count as 0.
    #[inline]
    fn weights(&self, positions: [DVec3; 3], pixel: [f64; 2]) -> ([f64; 3], bool) {
        let projector = &self.projector;
        let (across, upward) = projector.plane(pixel[0], pixel[1]);
        let (ray, [p, q, r]) = if projector.orthographic {
            (projector.forward, positions.map(|position| position - across - upward))
        } else {
            (projector.forward + across + upward, positions)
        };
        let raw = [ray.dot(q.cross(r)), ray.dot(r.cross(p)), ray.dot(p.cross(q))];
        // The sum is r·((P₁−P₀)×(P₂−P₀)): negative where the outer side is seen.
        let outer = raw[0] + raw[1] + raw[2] < 0.0;
        let sign = if outer { -1.0 } else { 1.0 };
        let kept = raw.map(|weight| (weight * sign).max(0.0));
        let sum = kept[0] + kept[1] + kept[2];
        let weights = if sum > 0.0 && sum.is_finite() { kept.map(|weight| weight / sum) } else { [1.0 / 3.0; 3] };
        (weights, outer)
    }
}
