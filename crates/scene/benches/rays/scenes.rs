//! Rays as the nodes Shadow and Translucency ask for them, one sample to a pixel of 1920 × 1080: of the teapot of
//! `graphs/toon_teapot.json`, and of the storm that the README describes.

use trochoid_image::Format;
use trochoid_scene::bezier::{Patch, PatchModel, Placement, Tessellation};
use trochoid_scene::shading::unit_or_up;
use trochoid_scene::{
    Camera, Channel, ChannelSet, DVec3, Obstacles, Projection, Projector, Ray, Samples, SeaSurface, Segment, Surface,
    Visible, files, surroundings,
};
use trochoid_sea::{GerstnerSpectrum, Sea};

/// Surfaces, and the rays of a node.
pub(crate) struct Scene {
    pub(crate) surfaces: Vec<Box<dyn Surface>>,
    pub(crate) projector: Projector,
    pub(crate) obstacles: Obstacles,
    pub(crate) questions: Vec<Question>,
}

/// Rays that are asked for together.
pub(crate) struct Question {
    pub(crate) name: &'static str,
    /// Whether it only matters that something is met.
    pub(crate) any: bool,
    pub(crate) segments: Vec<Segment>,
}

/// What a pixel sees.
struct Seen {
    point: DVec3,
    normal: DVec3,
    /// Size of a facet there, in meters.
    facet: f64,
}

/// The teapot on its table: rays that find the facet of each seen point, and hard shadows.
pub(crate) fn teapot() -> Scene {
    let models: [&[u8]; 4] = [
        include_bytes!("../../../../samples/teapot_spout.json"),
        include_bytes!("../../../../samples/teapot_handle.json"),
        include_bytes!("../../../../samples/teapot_lid.json"),
        include_bytes!("../../../../samples/teapot_body.json"),
    ];
    let adaptive = Tessellation::Adaptive { tolerance: 0.1 };
    let turned = DVec3::new(0.0, 4.6, 0.0);
    let placed = |rotate| Placement { scale: DVec3::ONE, rotate, translate: DVec3::ZERO };
    let mut surfaces: Vec<Box<dyn Surface>> = Vec::new();
    for model in models {
        let patches = files::patches(model).expect("a model");
        surfaces.push(Box::new(PatchModel::new(&patches, placed(turned), false, adaptive)));
    }
    let table = [[-40.0, 12.0], [40.0, 12.0], [-40.0, -9.0], [40.0, -9.0]].map(|[x, z]| DVec3::new(x, 0.0, z));
    let table = [Patch::of(&table).expect("four points")];
    surfaces.push(Box::new(PatchModel::new(&table, placed(DVec3::ZERO), false, adaptive)));
    let (position, target) = (DVec3::new(0.0, 4.4, 12.5), DVec3::new(0.0, 1.55, 0.0));
    let projection = Projection::Perspective { fov: 34_f64.to_radians() };
    let camera = Camera { position, target, roll: 0.0, projection };
    let (mut scene, seen) = Scene::new(surfaces, &camera, 8.0);
    let landed = scene.landed(&seen);
    let sun = DVec3::new(-0.62, 0.78, 0.55).normalize();
    let above = landed.iter().zip(&seen).map(|(point, seen)| *point + seen.normal * (1.5 * seen.facet));
    let segments = above.map(|origin| Segment { ray: Ray { origin, direction: sun }, limit: 500.0 }).collect();
    scene.questions.push(Question { name: "to the light", any: true, segments });
    scene
}

/// The storm: rays that find the facet of each seen point, the far side of its crest, and the way out to the sun.
pub(crate) fn storm() -> Scene {
    let spectrum = GerstnerSpectrum {
        wavelength: 9.0,
        spread: 1.0,
        height: 4.0,
        direction: 70_f64.to_radians(),
        sharpness: 0.8,
        seed: 8,
        ..GerstnerSpectrum::default()
    };
    let sea = SeaSurface::new(&Sea::new(spectrum.waves().expect("waves within range")), 1.5, 0.0);
    let (position, target) = (DVec3::new(0.0, 5.0, 30.0), DVec3::new(0.0, 4.5, 0.0));
    let projection = Projection::Perspective { fov: 46_f64.to_radians() };
    let camera = Camera { position, target, roll: 0.0, projection };
    let (mut scene, seen) = Scene::new(vec![Box::new(sea)], &camera, 2.0);
    let landed = scene.landed(&seen);
    let inward = landed.iter().zip(&seen).map(|(point, seen)| {
        let origin = *point - seen.normal * (0.02 * seen.facet);
        Segment { ray: Ray { origin, direction: -seen.normal }, limit: 1.0 }
    });
    let inward: Vec<Segment> = inward.collect();
    let found = scene.obstacles.first(&inward);
    let sun = DVec3::new(0.5, 0.12, -1.0).normalize();
    let outward = inward.iter().zip(found.iter().copied()).map(|(inward, through)| {
        let origin = inward.ray.at(through.map_or(0.5, |through| 0.5 * through));
        Segment { ray: Ray { origin, direction: sun }, limit: 50.0 }
    });
    let outward = outward.collect();
    scene.questions.push(Question { name: "inward", any: false, segments: inward });
    scene.questions.push(Question { name: "through", any: false, segments: outward });
    scene
}

impl Scene {
    /// Returns a scene with facets of so many pixels, and what its pixels see.
    fn new(surfaces: Vec<Box<dyn Surface>>, camera: &Camera, detail: f64) -> (Self, Vec<Seen>) {
        let format = Format::new(1920, 1080, 1).expect("valid");
        let borrowed: Vec<&dyn Surface> = surfaces.iter().map(AsRef::as_ref).collect();
        let projector = surroundings(&camera.projector(format), 0.5, detail);
        let wanted = ChannelSet::POSITION.union(ChannelSet::NORMAL).union(ChannelSet::COVERAGE);
        let mut samples = Samples::new();
        let visible = Visible::prepare(camera, &borrowed, format, wanted);
        visible.fill(format.window(), format.sample_offset(0), wanted, &mut samples);
        let vector = |channels: [Channel; 3], index: usize| {
            DVec3::from(channels.map(|channel| f64::from(samples.channel(channel)[index])))
        };
        let seen = (0..format.window().area()).filter(|index| samples.channel(Channel::Coverage)[*index] > 0.0);
        let seen = seen.map(|index| {
            let point = vector([Channel::PositionX, Channel::PositionY, Channel::PositionZ], index);
            let normal = unit_or_up(vector([Channel::NormalX, Channel::NormalY, Channel::NormalZ], index));
            Seen { point, normal, facet: projector.pixel_size(point.distance(projector.position)) }
        });
        let seen = seen.collect();
        let obstacles = Obstacles::new(&projector, &borrowed);
        (Self { surfaces, projector, obstacles, questions: Vec::new() }, seen)
    }

    /// Adds the rays that find the facets of seen points, and returns where they meet them.
    fn landed(&mut self, seen: &[Seen]) -> Vec<DVec3> {
        let down = seen.iter().map(|&Seen { point, normal, facet }| {
            let reach = 4.0 * facet;
            Segment { ray: Ray { origin: point + normal * reach, direction: -normal }, limit: 2.0 * reach }
        });
        let down: Vec<Segment> = down.collect();
        let found = self.obstacles.first(&down);
        let points = down.iter().zip(seen).zip(found.iter().copied());
        let points = points.map(|((down, seen), found)| found.map_or(seen.point, |distance| down.ray.at(distance)));
        let points = points.collect();
        self.questions.push(Question { name: "landed", any: false, segments: down });
        points
    }
}
