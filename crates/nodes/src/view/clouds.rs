//! Clouds: layers of procedural density, lit by a light.

use super::cloud_layers::{BEND, Cut, Layer, MORE_STEPS};
use trochoid_field::{Noise, NoiseKind, NoiseParameters};
use trochoid_graph::*;
use trochoid_image::Format;
use trochoid_memory::Scratch;
use trochoid_scene::{Camera, DVec3, Light, Projector, Ray};

/// Volumetric cloud layers lit by a light: dark where they are thick, with silver edges in front of the light.
///
/// # Formula
/// D = ramp((n − θ)/`softness`), θ = 1 − 2·`cover` + `rounding`·(2q − 1)², with gradient noise n and the height q
/// within the layer as a share of its thickness H; the mean of D is used where n is finer than the footprint. A
/// segment of length w in a layer is cut into `steps`·min(max(w/H, 1), 6) parts. Each part, of length s, covers a = 1
/// − exp(−`opacity`·D·s/H) of what lies behind and has the brightness b = exp(−`shade`·D̄)(1 − `sunward`(1 − f²)). D̄
/// is the mean of D, without detail finer than H/3, at 1/6, 1/2 and 5/6 of H toward the light, and f = (1 + d · L)/2.
/// The total is Σ T·a·b/Σ T·a, moved toward 1 by `silver`·f¹⁶(1 − density).
///
/// # Edge cases
/// Without clouds, density and light are 0 and depth is +∞. Layers curve with the Earth (6371 km) around a perspective
/// camera, so that they descend to the horizon. Clouds fade out over the last quarter of `distance`. Layers that
/// overlap are stacked in the order of their bases. A ray ends in a layer once less than 1/500 of what lies behind
/// remains visible.
///
/// # Source
/// Kajiya and Von Herzen, Ray Tracing Volume Densities, 1984; Schneider, The Real-Time Volumetric Cloudscapes of
/// Horizon Zero Dawn, 2015: density toward the light, silver lining.
#[derive(Clone, Node)]
#[node(stage, end = Front, revision = 2, outputs = Out)]
pub(crate) struct Clouds {
    /// Camera that sees the clouds.
    camera: One<port::Camera>,
    /// Light that illuminates the clouds.
    light: One<port::Light>,
    /// Cloud layers.
    #[list(1..=8)]
    layers: Vec<CloudLayer>,
    /// Number of parts into which a vertical ray is cut within a layer; a slanting ray is cut into up to six times as
    /// many.
    #[knob(default = 6, range = 1..=256)]
    steps: i64,
    /// Strength of the clouds' self-shadowing.
    #[knob(default = 2.5, range = 0.0..=100.0)]
    shade: f64,
    /// Darkening of clouds in the direction opposite the light.
    #[knob(default = 0.5, range = 0.0..=1.0)]
    sunward: f64,
    /// Brightness of thin cloud edges in front of the light.
    #[knob(default = 0.6, range = 0.0..=1.0)]
    silver: f64,
    /// Azimuth toward which clouds move and along which they are stretched: 0 is +X, 90 is +Z.
    #[knob(default = 0.0, range = -360.0..=360.0, unit = "degrees")]
    wind: f64,
    /// Maximum viewing distance.
    #[knob(default = 5e5, range = 1.0..=1e7, unit = "m")]
    distance: f64,
}

#[derive(Clone, Copy, Debug, PartialEq, Outputs)]
enum Out {
    /// Coverage of the clouds.
    #[output(Kind::MASK)]
    Density,
    /// Brightness of the visible clouds.
    #[output(Kind::MASK)]
    Light,
    /// Mean depth of the visible clouds, in meters.
    #[output(Kind::Field(1))]
    Depth,
}

/// One cloud layer.
#[derive(Clone, Copy, Items)]
struct CloudLayer {
    /// World y of the layer's base.
    #[knob(default = 1500.0, range = -1e6..=1e6, unit = "m")]
    height: f64,
    /// Distance from base to top.
    #[knob(default = 500.0, range = 1e-3..=1e6, unit = "m")]
    thickness: f64,
    /// Size of the largest clouds across the wind.
    #[knob(default = 2000.0, range = 1e-3..=1e7, unit = "m")]
    scale: f64,
    /// Factor by which clouds are longer along the wind.
    #[knob(default = 1.0, range = 1e-3..=1e3)]
    stretch: f64,
    /// Share of the sky that clouds cover: 0 is none, 1 is all.
    #[knob(default = 0.5, range = 0.0..=1.0)]
    cover: f64,
    /// Softness of the clouds' edges, as a range of noise values; 0 is a hard edge.
    #[knob(default = 0.3, range = 0.0..=2.0)]
    softness: f64,
    /// Thinning of the clouds toward the layer's base and top.
    #[knob(default = 0.5, range = 0.0..=2.0)]
    rounding: f64,
    /// Optical depth of the layer at full density.
    #[knob(default = 6.0, range = 0.0..=1e3)]
    opacity: f64,
    /// Number of octaves of noise.
    #[knob(default = 5, range = 1..=16)]
    octaves: i64,
    /// Amplitude of each octave relative to the previous one.
    #[knob(default = 0.5, range = 0.0..=1.0)]
    gain: f64,
    /// Wind speed.
    #[knob(default = 10.0, range = -1e4..=1e4, unit = "m/s")]
    speed: f64,
    /// Random seed.
    #[knob(default = 0, range = 0..=1_000_000_000)]
    seed: i64,
}

impl CloudLayer {
    /// Returns the layer at a time in seconds, with the wind along a unit vector.
    fn at(&self, time: f64, wind: [f64; 2]) -> Layer {
        let &Self { height, thickness, scale, stretch, cover, softness, rounding, opacity, octaves, gain, speed, seed } =
            self;
        let parameters = NoiseParameters { scale, octaves: octaves as usize, lacunarity: 2.0, gain, seed: seed as u32 };
        Layer {
            base: height,
            thickness,
            sparse: 1.0 - 2.0 * cover,
            softness,
            rounding,
            opacity,
            noise: Noise::new(NoiseKind::Fbm, parameters, None),
            wind,
            stretch,
            moved: speed * time,
        }
    }
}

/// Number of points toward the light at which density is sampled.
const LIGHT_STEPS: usize = 3;
/// Visible remainder of the background at which a ray ends.
const OPAQUE: f64 = 2e-3;
/// Share of the distance over which clouds fade.
const FADING: f64 = 0.25;
/// Least slope of a ray for enlarging a pixel's footprint on a layer.
const GRAZING: f64 = 0.02;

impl Node for Clouds {
    fn work(&self, format: Format, _time: f64) -> Option<Work> {
        // Seconds per step, plus seconds per octave, including the samples toward the light.
        const STEP: f64 = 2e-8;
        const OCTAVE: f64 = 3e-9;
        let layer = |layer: &CloudLayer| STEP + OCTAVE * layer.octaves as f64;
        let samples = format.window().area() as f64 * f64::from(format.samples());
        let steps = 0.5 * MORE_STEPS * self.steps as f64;
        let seconds = samples * steps * self.layers.iter().map(layer).sum::<f64>();
        let remedy = "lower \"steps\", or use fewer layers, octaves, samples or pixels";
        Some(Work { seconds, item: Self::STEPS, remedy })
    }
}

impl Stage for Clouds {
    fn is_costly(&self) -> bool {
        true
    }

    fn depends_on_time(&self) -> bool {
        true
    }

    fn memory(&self, _context: &MemoryContext<'_>) -> MemoryUse {
        // Lists grow to twice what they hold, out of the ones before.
        let lists = 3 * (size_of::<Dense>() + size_of::<(usize, Cut)>());
        let ray = size_of::<Ray>() + (1 + self.layers.len()) * size_of::<Accumulated>() + 4 * size_of::<f64>();
        MemoryUse::default().thread((lists + ray) as u64, u64::MAX)
    }

    fn rate(&self) -> Rate {
        Rate::Pixel
    }

    fn prepare(&self, prepare: &Prepare<'_>) -> Result<Box<dyn Prepared>, NodeError> {
        let cameras: Vec<Camera> = prepare.handles(&self.camera)?;
        let lights: Vec<Light> = prepare.handles(&self.light)?;
        let (Some(camera), Some(light)) = (cameras.first(), lights.first()) else {
            return Err(BadData::new("no camera or no light", "a camera and a light", "connect them").into());
        };
        let (sin, cos) = libm::sincos(self.wind.to_radians());
        let layer = |layer: &CloudLayer| layer.at(prepare.frame.time, [cos, sin]);
        let mut layers: Vec<Layer> = self.layers.iter().map(layer).collect();
        layers.sort_by(|a, b| a.base.total_cmp(&b.base));
        let eye = camera.projector(prepare.frame.format);
        let bend = if eye.orthographic { 0.0 } else { BEND };
        Ok(Box::new(PreparedClouds { node: self.clone(), eye, bend, light: *light, layers }))
    }
}

struct PreparedClouds {
    node: Clouds,
    eye: Projector,
    /// Sinking of layers with distance, in 1/m.
    bend: f64,
    light: Light,
    /// Layers in ascending order of their bases.
    layers: Vec<Layer>,
}

/// Light and coverage that a ray accumulates in one layer or in all.
#[derive(Clone, Copy)]
struct Accumulated {
    /// Transmittance T: the remaining share of what lies behind.
    left: f64,
    /// Σ T·a·b.
    light: f64,
    /// Σ T·a·t.
    distance: f64,
}

impl Accumulated {
    const NOTHING: Self = Self { left: 1.0, light: 0.0, distance: 0.0 };

    fn add(&mut self, covers: f64, bright: f64, distance: f64) {
        self.light += self.left * covers * bright;
        self.distance += self.left * covers * distance;
        self.left *= 1.0 - covers;
    }

    fn behind(self, front: Self) -> Self {
        Self {
            left: front.left * self.left,
            light: front.light + front.left * self.light,
            distance: front.distance + front.left * self.distance,
        }
    }
}

/// A point of a ray that lies in a cloud.
struct Dense {
    /// Index of the ray, distance along it, and length of the part.
    ray: usize,
    at: f64,
    length: f64,
    point: DVec3,
    /// Direction toward the light.
    light: DVec3,
    density: f64,
    /// Sum of the densities toward the light.
    shaded: f64,
}

impl PreparedClouds {
    /// Returns the footprint of a sample at a distance along a ray: that of a pixel on the layer, but at least half of
    /// the ray's part, because finer clouds would show as stripes along the horizon.
    fn footprint(&self, ray: &Ray, distance: f64, part: f64) -> f64 {
        let depth = distance * ray.direction.dot(self.eye.forward);
        let pixel = self.eye.pixel_size(depth) / ray.direction.y.abs().max(GRAZING).sqrt();
        pixel.max(0.5 * part)
    }

    /// Returns the share of a ray's part at a distance that clouds of a density cover.
    fn covers(&self, layer: &Layer, density: f64, part: f64, distance: f64) -> f64 {
        let left = ((self.node.distance - distance) / (FADING * self.node.distance)).clamp(0.0, 1.0);
        let fade = left * left * (3.0 - 2.0 * left);
        1.0 - libm::exp(-layer.opacity * density * fade * part / layer.thickness)
    }

    /// Returns the height of a point above a plane that sinks with the distance from the camera.
    fn height(&self, point: DVec3) -> f64 {
        let (x, z) = (point.x - self.eye.position.x, point.z - self.eye.position.z);
        point.y + self.bend * (x * x + z * z)
    }

    /// Returns the brightness of a point whose mean density toward the light is `shaded`.
    fn bright(&self, ray: &Ray, toward: DVec3, shaded: f64) -> f64 {
        let facing = 0.5 * (1.0 + ray.direction.dot(toward)).clamp(0.0, 2.0);
        libm::exp(-self.node.shade * shaded) * (1.0 - self.node.sunward * (1.0 - facing * facing))
    }

    /// Returns the distance between points toward the light; finer detail is left out there.
    fn light_step(layer: &Layer) -> f64 {
        layer.thickness / LIGHT_STEPS as f64
    }

    /// Returns the point at a number of steps toward the light.
    fn toward(layer: &Layer, point: DVec3, light: DVec3, step: usize) -> DVec3 {
        point + light * (Self::light_step(layer) * (step as f64 + 0.5))
    }

    /// Returns density, light and depth accumulated by a ray over all layers, given from the lowest up.
    fn resolve(&self, ray: &Ray, by_layer: impl DoubleEndedIterator<Item = Accumulated>) -> [f64; 3] {
        let join = |front: Accumulated, layer: Accumulated| layer.behind(front);
        let all = if ray.direction.y >= 0.0 {
            by_layer.fold(Accumulated::NOTHING, join)
        } else {
            by_layer.rev().fold(Accumulated::NOTHING, join)
        };
        let density = (1.0 - all.left).clamp(0.0, 1.0);
        if density == 0.0 {
            return [0.0, 0.0, f64::INFINITY];
        }
        let (light, distance) = ((all.light / density).clamp(0.0, 1.0), all.distance / density);
        let toward = self.light.illuminate(ray.at(distance)).direction;
        let facing = 0.5 * (1.0 + ray.direction.dot(toward)).clamp(0.0, 2.0);
        let silver = self.node.silver * libm::pow(facing, 16.0) * (1.0 - density);
        [density, light + (1.0 - light) * silver, distance * ray.direction.dot(self.eye.forward)]
    }

    /// Returns what rays accumulate in one layer, advancing all rays together, step by step.
    fn gather(
        &self,
        layer: &Layer,
        rays: &[Ray],
        lit: bool,
        inputs: &Inputs<'_>,
    ) -> Result<Scratch<Accumulated>, NodeError> {
        let mut gathered = Scratch::of(Accumulated::NOTHING, rays.len());
        let mut cuts: Scratch<(usize, Cut)> = (rays.iter().enumerate())
            .filter_map(|(index, ray)| {
                Some((index, layer.cut(layer.span(ray, self.bend, self.node.distance)?, self.node.steps as usize)))
            })
            .collect();
        let mut noise = Scratch::of(0.0, cuts.len());
        for step in 0.. {
            inputs.check_cancelled()?;
            cuts.retain(|(index, cut)| gathered[*index].left > OPAQUE && cut.at(step).is_some());
            if cuts.is_empty() {
                break;
            }
            noise.truncate(cuts.len());
            let parts = || cuts.iter().filter_map(|(index, cut)| Some((*index, cut.part, cut.at(step)?)));
            let place = |point: DVec3| layer.place(point, self.height(point));
            let places = parts().map(|(index, _, (at, _))| place(rays[index].at(at)));
            let prints: Scratch<f32> =
                parts().map(|(index, part, (at, _))| self.footprint(&rays[index], at, part) as f32).collect();
            layer.noise.fill(places, &prints, &mut noise);
            let (mut dense, mut dense_prints) = (Scratch::new(), Scratch::new());
            for (((ray, _, (at, length)), noise), print) in parts().zip(&noise).zip(&prints) {
                let point = rays[ray].at(at);
                let density = layer.density(f64::from(*noise), self.height(point), layer.spread(f64::from(*print)));
                if density > 0.0 {
                    let light = self.light.illuminate(point).direction;
                    dense.push(Dense { ray, at, length, point, light, density, shaded: 0.0 });
                    dense_prints.push(print.max(Self::light_step(layer) as f32));
                }
            }
            if lit {
                let mut noise = Scratch::of(0.0, dense.len());
                for ahead in 0..LIGHT_STEPS {
                    let point = |dense: &Dense| Self::toward(layer, dense.point, dense.light, ahead);
                    layer.noise.fill(dense.iter().map(|dense| place(point(dense))), &dense_prints, &mut noise);
                    for (dense, noise) in dense.iter_mut().zip(&noise) {
                        dense.shaded += layer.density(f64::from(*noise), self.height(point(dense)), 0.0);
                    }
                }
            }
            for &Dense { ray, at, length, light, density, shaded, .. } in &dense {
                let bright = self.bright(&rays[ray], light, shaded / LIGHT_STEPS as f64);
                gathered[ray].add(self.covers(layer, density, length, at), bright, at);
            }
        }
        Ok(gathered)
    }

    /// Returns what a ray accumulates in one layer, in f64.
    fn gather_reference(&self, layer: &Layer, ray: &Ray) -> Accumulated {
        let mut gathered = Accumulated::NOTHING;
        let Some(span) = layer.span(ray, self.bend, self.node.distance) else { return gathered };
        let cut = layer.cut(span, self.node.steps as usize);
        let density = |point: DVec3, footprint: f64, spread: f64| {
            let height = self.height(point);
            layer.density(layer.noise.reference(&layer.place(point, height), footprint), height, spread)
        };
        for (distance, length) in (0..).map_while(|step| cut.at(step)) {
            if gathered.left <= OPAQUE {
                break;
            }
            let (point, footprint) = (ray.at(distance), self.footprint(ray, distance, cut.part));
            let light = self.light.illuminate(point).direction;
            let coarse = footprint.max(Self::light_step(layer));
            let shaded: f64 =
                (0..LIGHT_STEPS).map(|ahead| density(Self::toward(layer, point, light, ahead), coarse, 0.0)).sum();
            let bright = self.bright(ray, light, shaded / LIGHT_STEPS as f64);
            let density = density(point, footprint, layer.spread(footprint));
            gathered.add(self.covers(layer, density, length, distance), bright, distance);
        }
        gathered
    }
}

impl Prepared for PreparedClouds {
    fn fill(&self, block: &Block<'_>, inputs: &Inputs<'_>, outputs: &mut Outputs<'_>) -> Result<(), NodeError> {
        let mut planes = Out::ALL.map(|output| outputs.take(output, 0));
        if planes.iter().all(Option::is_none) {
            return Ok(());
        }
        let rays: Scratch<Ray> = block.places().map(|[x, y]| self.eye.ray(x, y)).collect();
        let lit = planes[usize::from(Out::Light)].is_some();
        let by_layer: Result<Scratch<Scratch<Accumulated>>, NodeError> =
            self.layers.iter().map(|layer| self.gather(layer, &rays, lit, inputs)).collect();
        let by_layer = by_layer?;
        for (index, ray) in rays.iter().enumerate() {
            let values = self.resolve(ray, by_layer.iter().map(|gathered| gathered[index]));
            for (plane, value) in planes.iter_mut().zip(values) {
                if let Some(plane) = plane {
                    plane[index] = value as f32;
                }
            }
        }
        Ok(())
    }

    fn bound(&self, _bounding: &Bounding<'_>, _outputs: &mut Outputs<'_>) -> Result<(), NoBound> {
        Err(NoBound("its rays end, and enter layers, depending on the density found so far"))
    }

    fn reference(&self, inputs: &References<'_>) -> Result<Vec<Reference>, NodeError> {
        let ray = self.eye.ray(inputs.at[0], inputs.at[1]);
        let [density, light, depth] =
            self.resolve(&ray, self.layers.iter().map(|layer| self.gather_reference(layer, &ray)));
        let of = |output| match output {
            Out::Density => Reference::Mask(density),
            Out::Light => Reference::Mask(light),
            Out::Depth => Reference::Field(vec![depth]),
        };
        Ok(Vec::from(Out::ALL.map(of)))
    }
}
