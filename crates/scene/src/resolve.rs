//! What the triangles that samples see carry there.

#![allow(clippy::needless_range_loop, reason = "loops over lanes of several arrays")]

use fearless_simd::{Level, Simd, dispatch};
use glam::DVec3;

use crate::channel::{NORMALS, RESTS, TRAILS};
use crate::raster::{NOTHING, Row};
use crate::shading::unit_or_up;
use crate::surface::Mesh;
use crate::{Channel, ChannelSet, Projector, Samples, Visible};

/// Hits that are answered side by side, in vectors.
const BLOCK: usize = 32;

/// A value at each of them; what stands beyond the last one is never read.
type Lanes = [f64; BLOCK];

/// A sample that sees a triangle.
struct Hit {
    /// Which of its row it is.
    column: usize,
    surface: usize,
    triangle: [u32; 3],
}

/// Hits of one mesh in one row.
struct Block<'a> {
    hits: &'a [Hit],
    mesh: &'a Mesh,
    /// Number of the row's first sample, and places within the picture.
    start: usize,
    x: Lanes,
    y: f64,
}

impl Visible {
    /// Interpolates what the seen triangles carry; background where there is none.
    pub(crate) fn resolve<'s>(
        &self,
        rows: impl Iterator<Item = Row<'s>>,
        offset: [f64; 2],
        wanted: ChannelSet,
        out: &mut Samples,
    ) {
        // The offset that the raster rounded to, so that the ray meets the triangle that was found.
        let unit = f64::from(1_u32 << self.raster.bits);
        let offset = offset.map(|part| self.raster.fix(part) as f64 / unit);
        dispatch!(Level::new(), simd => simd.vectorize(
            #[inline(always)]
            || self.resolve_rows(rows, offset, wanted, out)
        ));
    }

    #[inline(always)]
    fn resolve_rows<'s>(
        &self,
        rows: impl Iterator<Item = Row<'s>>,
        offset: [f64; 2],
        wanted: ChannelSet,
        out: &mut Samples,
    ) {
        let mut hits: Vec<Hit> = Vec::new();
        for row in rows {
            let (start, numbers) = (row.first, &row.triangles);
            let width = numbers.len();
            hits.clear();
            let mut column = 0;
            while column < width {
                let number = numbers[column];
                if number == NOTHING {
                    let rest = &numbers[column..];
                    let run = rest.iter().position(|number| *number != NOTHING).unwrap_or(rest.len());
                    for channel in wanted.iter() {
                        out.from(channel, start + column)[..run].fill(channel.background());
                    }
                    column += run;
                    continue;
                }
                let primitive = (number / 2) as u32;
                let surface = self.layer(primitive);
                let local = (primitive - self.firsts[surface]) as usize;
                let triangle = self.layers[surface].triangles(local)[(number % 2) as usize];
                hits.push(Hit { column, surface, triangle });
                column += 1;
            }
            let y = row.y as f64 + offset[1];
            for hits in hits.chunk_by(|a, b| a.surface == b.surface).flat_map(|hits| hits.chunks(BLOCK)) {
                let mut x = [0.0; BLOCK];
                for (x, hit) in x.iter_mut().zip(hits) {
                    *x = row.x(hit.column) as f64 + offset[0];
                }
                let mesh = &self.layers[hits[0].surface].mesh;
                self.answer(&Block { hits, mesh, start, x, y }, wanted, out);
            }
        }
    }

    #[inline(always)]
    fn answer(&self, block: &Block<'_>, wanted: ChannelSet, out: &mut Samples) {
        let (mesh, projector) = (block.mesh, &self.projector);
        block.put_all(Channel::Coverage, 1.0, out);
        block.put_all(Channel::Surface, block.hits[0].surface as f32, out);
        let positions = block.gather(&mesh.positions);
        let (weights, sides) = block.weights(&positions, projector);
        let offset = blend(&positions, &weights);
        let [x, y, z] = &offset;
        let mut value = [0.0; BLOCK];
        if wanted.contains(Channel::Depth) {
            for lane in 0..BLOCK {
                value[lane] = DVec3::new(x[lane], y[lane], z[lane]).dot(projector.forward);
            }
            block.put(Channel::Depth, &value, out);
        }
        let eye = projector.position.to_array();
        for (axis, channel) in [Channel::PositionX, Channel::PositionY, Channel::PositionZ].into_iter().enumerate() {
            if wanted.contains(channel) {
                for lane in 0..BLOCK {
                    value[lane] = eye[axis] + offset[axis][lane];
                }
                block.put(channel, &value, out);
            }
        }
        let mut height = [0.0; BLOCK];
        for lane in 0..BLOCK {
            height[lane] = projector.position.y + y[lane] - mesh.level;
        }
        block.put(Channel::Height, &height, out);
        if wanted.intersects(NORMALS) {
            self.answer_normals(block, &weights, &sides, out);
        }
        if wanted.intersects(RESTS.union(ChannelSet::UV)) {
            self.answer_rests(block, &weights, &offset, &height, out);
        }
        let attribute = |channel: Channel, values: &[f32], out: &mut Samples| {
            if !wanted.contains(channel) {
                return;
            }
            if values.is_empty() {
                block.put_all(channel, channel.background(), out);
            } else {
                let [value] = blend(&block.gather(values.as_chunks::<1>().0), &weights);
                block.put(channel, &value, out);
            }
        };
        attribute(Channel::SlopeVariance, &mesh.slope_variances, out);
        if wanted.intersects(TRAILS) {
            for (values, channel) in mesh.trails.iter().zip(Channel::TRAILS) {
                attribute(channel, values, out);
            }
        }
    }

    #[inline(always)]
    fn answer_normals(&self, block: &Block<'_>, weights: &[Lanes; 3], sides: &Lanes, out: &mut Samples) {
        let mesh = block.mesh;
        if mesh.normals.is_empty() {
            for channel in NORMALS.iter() {
                block.put_all(channel, channel.background(), out);
            }
            return;
        }
        let [mut x, mut y, mut z] = blend(&block.gather(&mesh.normals), weights);
        if mesh.displaced {
            block.put(Channel::Jacobian, &y, out);
        } else {
            block.put_all(Channel::Jacobian, 1.0, out);
        }
        // Of a side seen from the wrong side, as in a fold, the other normal counts.
        let own = if mesh.inside { 1.0 } else { -1.0 };
        for lane in 0..BLOCK {
            let normal = unit_or_up(DVec3::new(x[lane], y[lane], z[lane])) * (own * sides[lane]);
            (x[lane], y[lane], z[lane]) = (normal.x, normal.y, normal.z);
        }
        block.put(Channel::NormalX, &x, out);
        block.put(Channel::NormalY, &y, out);
        block.put(Channel::NormalZ, &z, out);
    }

    #[inline(always)]
    fn answer_rests(
        &self,
        block: &Block<'_>,
        weights: &[Lanes; 3],
        offset: &[Lanes; 3],
        height: &Lanes,
        out: &mut Samples,
    ) {
        let (mesh, eye) = (block.mesh, self.projector.position);
        // A surface without rest points rests where it is.
        let [rest_x, rest_z] =
            if mesh.rests.is_empty() { [offset[0], offset[2]] } else { blend(&block.gather(&mesh.rests), weights) };
        // The level, or how much higher the model's own rest point stands.
        let mut risen = [0.0; BLOCK];
        if !mesh.rest_heights.is_empty() {
            let [heights] = blend(&block.gather(mesh.rest_heights.as_chunks::<1>().0), weights);
            for lane in 0..BLOCK {
                risen[lane] = eye.y + heights[lane] - mesh.level;
            }
        }
        let (mut x, mut y, mut z, mut moved) = ([0.0; BLOCK], [0.0; BLOCK], [0.0; BLOCK], [0.0; BLOCK]);
        for lane in 0..BLOCK {
            x[lane] = eye.x + rest_x[lane];
            y[lane] = mesh.level + risen[lane];
            z[lane] = eye.z + rest_z[lane];
            let up = height[lane] - risen[lane];
            moved[lane] = DVec3::new(offset[0][lane] - rest_x[lane], up, offset[2][lane] - rest_z[lane]).length();
        }
        block.put(Channel::RestX, &x, out);
        block.put(Channel::RestY, &y, out);
        block.put(Channel::RestZ, &z, out);
        block.put(Channel::RestDistance, &moved, out);
        let [u, v] = if mesh.uvs.is_empty() { [x, z] } else { blend(&block.gather(&mesh.uvs), weights) };
        block.put(Channel::U, &u, out);
        block.put(Channel::V, &v, out);
    }
}

impl Block<'_> {
    /// What the corners of each triangle carry, by corner and component.
    #[inline(always)]
    fn gather<const N: usize>(&self, values: &[[f32; N]]) -> [[Lanes; N]; 3] {
        let mut gathered = [[[0.0; BLOCK]; N]; 3];
        for (lane, hit) in self.hits.iter().enumerate() {
            for corner in 0..3 {
                let value = values[hit.triangle[corner] as usize];
                for component in 0..N {
                    gathered[corner][component][lane] = f64::from(value[component]);
                }
            }
        }
        gathered
    }

    /// Barycentric weights of the points of triangles that the pixels' rays meet, from the exact positions: the
    /// fixed-point ones only decided that it is these triangles.
    ///
    /// For a ray from the origin along r, the point Σ wᵢPᵢ is on it if w₀ : w₁ : w₂ = r·(P₁×P₂) : r·(P₂×P₀) :
    /// r·(P₀×P₁). Beside them stands −1 where a triangle's outer side is seen, else 1. Rounding may have put the ray
    /// just beside the triangle: negative weights count as 0.
    #[inline(always)]
    fn weights(&self, positions: &[[Lanes; 3]; 3], projector: &Projector) -> ([Lanes; 3], Lanes) {
        let (mut weights, mut sides) = ([[0.0; BLOCK]; 3], [0.0; BLOCK]);
        for lane in 0..BLOCK {
            let (across, upward) = projector.plane(self.x[lane], self.y);
            let corner = |corner: usize| {
                let [x, y, z] = &positions[corner];
                let position = DVec3::new(x[lane], y[lane], z[lane]);
                if projector.orthographic { position - across - upward } else { position }
            };
            let (p, q, r) = (corner(0), corner(1), corner(2));
            let ray = if projector.orthographic { projector.forward } else { projector.forward + across + upward };
            let (a, b, c) = (ray.dot(q.cross(r)), ray.dot(r.cross(p)), ray.dot(p.cross(q)));
            // The sum is r·((P₁−P₀)×(P₂−P₀)): negative where the outer side is seen.
            let side = if a + b + c < 0.0 { -1.0 } else { 1.0 };
            let kept = |weight: f64| if weight * side > 0.0 { weight * side } else { 0.0 };
            let (a, b, c) = (kept(a), kept(b), kept(c));
            let sum = a + b + c;
            let fair = sum > 0.0 && sum < f64::INFINITY;
            let share = |weight: f64| if fair { weight / sum } else { 1.0 / 3.0 };
            (weights[0][lane], weights[1][lane], weights[2][lane]) = (share(a), share(b), share(c));
            sides[lane] = side;
        }
        (weights, sides)
    }

    /// Writes the value of each hit where the channel was asked for.
    #[inline(always)]
    fn put(&self, channel: Channel, values: &Lanes, out: &mut Samples) {
        let samples = out.from(channel, self.start);
        if samples.is_empty() {
            return;
        }
        let mut rounded = [0.0; BLOCK];
        for lane in 0..BLOCK {
            rounded[lane] = values[lane] as f32;
        }
        let (first, count) = (self.hits[0].column, self.hits.len());
        if self.hits[count - 1].column - first == count - 1 {
            samples[first..first + count].copy_from_slice(&rounded[..count]);
        } else {
            for (hit, value) in self.hits.iter().zip(rounded) {
                samples[hit.column] = value;
            }
        }
    }

    /// Writes one value at all hits.
    #[inline(always)]
    fn put_all(&self, channel: Channel, value: f32, out: &mut Samples) {
        let samples = out.from(channel, self.start);
        if !samples.is_empty() {
            self.hits.iter().for_each(|hit| samples[hit.column] = value);
        }
    }
}

/// Σ wᵢvᵢ over the corners, by component.
#[inline(always)]
fn blend<const N: usize>(values: &[[Lanes; N]; 3], weights: &[Lanes; 3]) -> [Lanes; N] {
    let mut blended = [[0.0; BLOCK]; N];
    for component in 0..N {
        for lane in 0..BLOCK {
            blended[component][lane] = values[0][component][lane] * weights[0][lane]
                + values[1][component][lane] * weights[1][lane]
                + values[2][component][lane] * weights[2][lane];
        }
    }
    blended
}

#[cfg(test)]
mod tests {
    use trochoid_image::{Format, Window};

    use super::*;
    use crate::surface::{Hit, Topology};
    use crate::{Camera, Projection, Ray, Surface};

    /// What one triangle carries at a pixel, hit by itself and straight from the formulas.
    fn plain(visible: &Visible, number: u64, pixel: [f64; 2]) -> [f32; Channel::ALL.len()] {
        let mut answers = Channel::ALL.map(Channel::background);
        if number == NOTHING {
            return answers;
        }
        let primitive = (number / 2) as u32;
        let surface = visible.layer(primitive);
        let layer = &visible.layers[surface];
        let triangle = layer.triangles((primitive - visible.firsts[surface]) as usize)[(number % 2) as usize];
        let (mesh, projector) = (&layer.mesh, &visible.projector);
        let vertices = triangle.map(|vertex| vertex as usize);
        let positions = vertices.map(|vertex| glam::Vec3::from(mesh.positions[vertex]).as_dvec3());
        let (across, upward) = projector.plane(pixel[0], pixel[1]);
        let (ray, [p, q, r]) = if projector.orthographic {
            (projector.forward, positions.map(|position| position - across - upward))
        } else {
            (projector.forward + across + upward, positions)
        };
        let raw = [ray.dot(q.cross(r)), ray.dot(r.cross(p)), ray.dot(p.cross(q))];
        let outer = raw[0] + raw[1] + raw[2] < 0.0;
        let kept = raw.map(|weight| {
            let weight = if outer { -weight } else { weight };
            if weight > 0.0 { weight } else { 0.0 }
        });
        let sum = kept[0] + kept[1] + kept[2];
        let weights = if sum > 0.0 && sum.is_finite() { kept.map(|weight| weight / sum) } else { [1.0 / 3.0; 3] };
        let blend = |values: [f64; 3]| values[0] * weights[0] + values[1] * weights[1] + values[2] * weights[2];
        let blend_of = |value: &dyn Fn(usize) -> f32| blend(vertices.map(|vertex| f64::from(value(vertex))));
        let mut set = |channel: Channel, value: f64| answers[channel as usize] = value as f32;
        let offset = DVec3::from_array([0, 1, 2].map(|axis| blend(positions.map(|position| position[axis]))));
        let position = projector.position + offset;
        let height = position.y - mesh.level;
        set(Channel::Coverage, 1.0);
        set(Channel::Surface, surface as f64);
        set(Channel::Depth, offset.dot(projector.forward));
        set(Channel::PositionX, position.x);
        set(Channel::PositionY, position.y);
        set(Channel::PositionZ, position.z);
        set(Channel::Height, height);
        if !mesh.normals.is_empty() {
            let normal = DVec3::from_array([0, 1, 2].map(|axis| blend_of(&|vertex| mesh.normals[vertex][axis])));
            set(Channel::Jacobian, if mesh.displaced { normal.y } else { 1.0 });
            let normal = if outer == mesh.inside { -unit_or_up(normal) } else { unit_or_up(normal) };
            set(Channel::NormalX, normal.x);
            set(Channel::NormalY, normal.y);
            set(Channel::NormalZ, normal.z);
        }
        let rest = match mesh.rests.is_empty() {
            true => [offset.x, offset.z],
            false => [0, 1].map(|axis| blend_of(&|vertex| mesh.rests[vertex][axis])),
        };
        let risen = match mesh.rest_heights.is_empty() {
            true => 0.0,
            false => projector.position.y + blend_of(&|vertex| mesh.rest_heights[vertex]) - mesh.level,
        };
        let place = [projector.position.x + rest[0], projector.position.z + rest[1]];
        set(Channel::RestX, place[0]);
        set(Channel::RestY, mesh.level + risen);
        set(Channel::RestZ, place[1]);
        set(Channel::RestDistance, DVec3::new(offset.x - rest[0], height - risen, offset.z - rest[1]).length());
        let uv = match mesh.uvs.is_empty() {
            true => place,
            false => [0, 1].map(|axis| blend_of(&|vertex| mesh.uvs[vertex][axis])),
        };
        set(Channel::U, uv[0]);
        set(Channel::V, uv[1]);
        if !mesh.slope_variances.is_empty() {
            set(Channel::SlopeVariance, blend_of(&|vertex| mesh.slope_variances[vertex]));
        }
        for (values, channel) in mesh.trails.iter().zip(Channel::TRAILS).filter(|(values, _)| !values.is_empty()) {
            set(channel, blend_of(&|vertex| values[vertex]));
        }
        answers
    }

    struct Given(Mesh);

    impl Surface for Given {
        fn tessellate(&self, _: &Projector, _: ChannelSet) -> Mesh {
            self.0.clone()
        }

        fn trace(&self, _: &Projector, _: &Ray) -> Option<Hit> {
            None
        }
    }

    /// Numbers from 0 to 1, one after the other.
    struct Random(u64);

    impl Random {
        fn next(&mut self) -> f32 {
            self.0 = self.0.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1_442_695_040_888_963_407);
            (self.0 >> 40) as f32 / (1 << 24) as f32
        }

        fn values<const N: usize>(&mut self, count: usize, hostile: bool) -> Vec<[f32; N]> {
            const HOSTILE: [f32; 6] = [0.0, -0.0, f32::NAN, f32::INFINITY, f32::MAX, 1e-42];
            let mut value = || {
                let value = self.next() * 8.0 - 4.0;
                if hostile && self.next() < 0.3 { HOSTILE[(self.next() * 6.0) as usize] } else { value }
            };
            (0..count).map(|_| std::array::from_fn(|_| value())).collect()
        }

        /// Triangles before a camera that looks along −Z, some of them large, many without area.
        fn mesh(&mut self, case: u32) -> Mesh {
            let count = 3 * 80;
            let has = |bit: u32| case & bit != 0;
            let mut positions = self.values::<3>(count, false);
            for (index, position) in positions.iter_mut().enumerate() {
                position[2] = -3.0 - 8.0 * self.next();
                if index % 7 == 0 {
                    position[0] = 0.0;
                }
            }
            let flat = |values: Vec<[f32; 1]>| values.concat();
            let mut list = |wanted: bool| if wanted { flat(self.values(count, true)) } else { Vec::new() };
            let (rest_heights, slope_variances) = (list(has(4)), list(has(8)));
            let trails = std::array::from_fn(|index| list(has(16) && index != 2));
            let corner = |next: f32| (next * count as f32) as u32;
            let triangles = (0..160).map(|_| [0; 3].map(|_| corner(self.next()))).collect();
            Mesh {
                normals: if has(1) { self.values(count, true) } else { Vec::new() },
                rests: if has(2) { self.values(count, true) } else { Vec::new() },
                uvs: if has(32) { self.values(count, true) } else { Vec::new() },
                positions,
                rest_heights,
                slope_variances,
                trails,
                level: 0.25,
                displaced: has(1) && has(2),
                inside: has(64),
                tolerance: None,
                topology: Topology::Triangles(triangles),
            }
        }
    }

    #[test]
    fn hits_side_by_side_have_the_bits_of_each_by_itself() {
        let mut random = Random(3);
        for case in 0..128 {
            let projection = match case % 3 {
                0 => Projection::Orthographic { height: 7.0 },
                _ => Projection::Perspective { fov: 0.9 },
            };
            let (position, target) = (DVec3::new(100.0, 3.0, -7.0), DVec3::new(100.0, 3.0, -8.0));
            let camera = Camera { position, target, roll: 0.0, projection };
            let format = Format::new(90, 50, 4).expect("valid");
            let surfaces = [Given(random.mesh(case)), Given(random.mesh(case.wrapping_mul(37) ^ 85))];
            let surfaces: Vec<&dyn Surface> = surfaces.iter().map(|surface| surface as &dyn Surface).collect();
            let visible = Visible::prepare(&camera, &surfaces, format, ChannelSet::ALL);
            let window = Window::new(-3, 4, 87, 33);
            let offset = format.sample_offset(case % 4);
            let mut samples = Samples::new();
            visible.fill(window, offset, ChannelSet::ALL, &mut samples);
            // What is seen by all samples together, and by this one alone, as an offset that is no sample's is asked.
            let all = || (0..window.area() as i64).map(|index| [window.x0 + index % 90, window.y0 + index / 90]);
            let look = |visible: &Visible| {
                let mut numbers = Vec::new();
                visible.look(window, offset, |seen| numbers.extend(all().map(|[x, y]| seen.triangle(x, y))));
                numbers
            };
            let alone = Visible::prepare(&camera, &surfaces, Format::new(90, 50, 1).expect("valid"), ChannelSet::ALL);
            let seen = look(&visible);
            assert!(look(&alone) == seen, "case {case}: samples together and each by itself");
            let some: Vec<[i64; 2]> = all().filter(|_| random.next() < 0.4).collect();
            let mut alone = Samples::new();
            visible.fill_pixels(&some, offset, ChannelSet::ALL, &mut alone);
            for (index, [x, y]) in some.iter().enumerate() {
                let whole = (y - window.y0) as usize * 90 + (x - window.x0) as usize;
                for channel in Channel::ALL {
                    let bits = |samples: &Samples, index: usize| samples.channel(channel)[index].to_bits();
                    assert_eq!(bits(&alone, index), bits(&samples, whole), "case {case}, {channel:?} at {x}, {y}");
                }
            }
            let mut hits = 0;
            for (index, &number) in seen.iter().enumerate() {
                let place = [index % window.width(), index / window.width()];
                let pixel = [0, 1].map(|axis| {
                    let unit = f64::from(1_u32 << visible.raster.bits);
                    let first = [window.x0, window.y0][axis] + place[axis] as i64;
                    first as f64 + visible.raster.fix(offset[axis]) as f64 / unit
                });
                hits += usize::from(number != NOTHING);
                let truth = plain(&visible, number, pixel);
                for channel in Channel::ALL {
                    let (found, truth) = (samples.channel(channel)[index], truth[channel as usize]);
                    let same = found.to_bits() == truth.to_bits() || (found.is_nan() && truth.is_nan());
                    assert!(same, "case {case}, {channel:?} at {place:?}: {found} and {truth}");
                }
            }
            assert!(hits > 100 && hits < seen.len(), "case {case}: {hits} hits");
        }
    }
}
