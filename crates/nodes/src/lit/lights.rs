//! Directions to lights and to the eye over a block of samples, and how the masks of several lights combine.

use crate::view::{POSITION, RenderHandle, view_planes};
use trochoid_graph::{BadData, Choice, Connected, Inputs, Many, NodeError, One, Prepare, port};
use trochoid_image::Format;
use trochoid_memory::Scratch;
use trochoid_scene::{Camera, DVec3, Illumination, Light, Projector};

/// X, y and z planes of many vectors.
pub(crate) type Vectors3<'a> = [&'a [f32]; 3];

/// How the masks of several lights are combined into one.
#[derive(Clone, Copy, Debug, PartialEq, Choice)]
pub(crate) enum Combine {
    Screen,
    Max,
    Mean,
}

impl Combine {
    /// Combines several masks, in f64.
    pub(crate) fn reference(self, masks: &[f64]) -> f64 {
        match self {
            Self::Screen => 1.0 - masks.iter().map(|t| 1.0 - t).product::<f64>(),
            Self::Max => masks.iter().copied().fold(0.0, f64::max),
            Self::Mean => masks.iter().sum::<f64>() / masks.len().max(1) as f64,
        }
    }

    /// Combines the mask of light `index` of `count` with that of the lights before it.
    fn take(self, mask: &mut [f32], light: &[f32], index: usize, count: usize) {
        for (mask, light) in mask.iter_mut().zip(light) {
            *mask = match self {
                _ if index == 0 && self != Self::Mean => *light,
                Self::Screen => trochoid_weights::arithmetic::screen(*mask, *light),
                Self::Max => mask.max(*light),
                // A partial sum of n masks, each divided by n, can exceed 1 only by rounding.
                Self::Mean => (*mask + *light / count as f32).min(1.0),
            };
        }
    }
}

/// Lights connected to a pass.
pub(crate) struct Lights {
    lights: Vec<Light>,
    combine: Combine,
}

impl Lights {
    pub(crate) fn of(lights: &Many<port::Light>, combine: Combine, prepare: &Prepare<'_>) -> Result<Self, NodeError> {
        Ok(Self { lights: prepare.handles(lights)?, combine })
    }

    pub(crate) fn lights(&self) -> &[Light] {
        &self.lights
    }

    pub(crate) fn combine(&self) -> Combine {
        self.combine
    }

    /// Fills `mask` with the combined masks of all lights. `shade` gives the mask of one light from unit vectors toward
    /// it, which is then scaled by the light's intensity.
    ///
    /// # Errors
    /// A light has a position, but the view has no position pass.
    pub(crate) fn fill(
        &self,
        inputs: &Inputs<'_>,
        view: &One<port::View>,
        mask: &mut [f32],
        mut shade: impl FnMut(Vectors3<'_>, &mut [f32]),
    ) -> Result<(), NodeError> {
        mask.fill(0.0);
        let n = mask.len();
        let mut directions = [0, 1, 2].map(|_| Scratch::of(0.0, n));
        let mut intensity = Scratch::of(1.0, n);
        let mut one = Scratch::of(0.0, n);
        for (index, light) in self.lights.iter().enumerate() {
            if let Light::Directional { .. } = light {
                let toward = light.illuminate(DVec3::ZERO).direction.as_vec3();
                for (plane, value) in directions.iter_mut().zip([toward.x, toward.y, toward.z]) {
                    plane.fill(value);
                }
                intensity.fill(1.0);
            } else {
                if inputs.view_if_any(view, POSITION[0]).is_none() {
                    let expected = "one, which a point or spot light needs";
                    return Err(without_position(expected, "add the pass, or use a directional light"));
                }
                let positions = view_planes(inputs, view, POSITION);
                let [x, y, z] = &mut directions;
                for i in 0..n {
                    let point = DVec3::from(positions.map(|plane| f64::from(plane[i])));
                    let Illumination { direction, intensity: arrives } = light.illuminate(point);
                    (x[i], y[i], z[i]) = (direction.x as f32, direction.y as f32, direction.z as f32);
                    intensity[i] = arrives as f32;
                }
            }
            shade([&directions[0], &directions[1], &directions[2]], &mut one);
            for (one, intensity) in one.iter_mut().zip(&intensity) {
                *one *= intensity;
            }
            self.combine.take(mask, &one, index, self.lights.len());
        }
        Ok(())
    }

    /// Returns the combined mask at one point, in f64.
    pub(crate) fn reference(&self, point: DVec3, shade: impl Fn(DVec3) -> f64) -> f64 {
        self.within_reach(std::iter::once(point), |lit| lit.iter().map(|lit| shade(lit.direction)).collect())[0]
    }

    /// Returns the combined mask at each of many points, in f64. `shade` gives the masks of one light at those of them
    /// that its light reaches, which are then scaled by the light's intensity.
    pub(crate) fn within_reach(
        &self,
        points: impl Iterator<Item = DVec3> + Clone,
        shade: impl Fn(&[Lit]) -> Scratch<f64>,
    ) -> Scratch<f64> {
        let mut masks: Scratch<Scratch<f64>> = points.clone().map(|_| Scratch::of(0.0, self.lights.len())).collect();
        for (light, index_of_light) in self.lights.iter().zip(0..) {
            let lit = |(index, point): (usize, DVec3)| {
                let Illumination { direction, intensity } = light.illuminate(point);
                let reach = match light {
                    Light::Directional { .. } => f64::INFINITY,
                    Light::Point { position } | Light::Spot { position, .. } => position.distance(point),
                };
                (intensity > 0.0).then_some(Lit { index, direction, reach, intensity })
            };
            let lit: Scratch<Lit> = points.clone().enumerate().filter_map(lit).collect();
            for (lit, mask) in lit.iter().zip(&shade(&lit)) {
                masks[lit.index][index_of_light] = lit.intensity * mask;
            }
        }
        masks.iter().map(|masks| self.combine.reference(masks)).collect()
    }
}

/// A point that the light of some light reaches.
pub(crate) struct Lit {
    /// Its index among the points.
    pub(crate) index: usize,
    /// Unit vector toward the light.
    pub(crate) direction: DVec3,
    /// Distance of the light in meters; infinite if it has no position.
    pub(crate) reach: f64,
    intensity: f64,
}

/// Returns the projector of the connected view's camera.
///
/// # Errors
/// The view has no camera.
pub(crate) fn eye(prepare: &Prepare<'_>, view: &impl Connected, format: Format) -> Result<Projector, NodeError> {
    let handle = prepare.handle_of(view);
    // The handle of a Render has its surfaces too; that of a view from passes has the camera alone.
    let camera = handle.as_deref().and_then(|handle| {
        handle.downcast_ref::<Camera>().or_else(|| handle.downcast_ref::<RenderHandle>().map(|render| &render.camera))
    });
    match camera {
        Some(camera) => Ok(camera.projector(format)),
        None => Err(BadData::new("a view without a camera", "a camera", "connect one to the view").into()),
    }
}

/// Returns a vector from a point toward the eye, of any length, in f64.
fn without_position(expected: &str, remedy: &str) -> NodeError {
    BadData::new("a view without a position pass", expected, remedy).into()
}

pub(crate) fn toward_eye(eye: &Projector, point: DVec3) -> DVec3 {
    if eye.orthographic { -eye.forward } else { eye.position - point }
}

/// Returns unit vectors from the points of a block toward the eye.
///
/// # Errors
/// The camera is a perspective one, but the view has no position pass.
pub(crate) fn view_directions(
    inputs: &Inputs<'_>,
    view: &One<port::View>,
    eye: &Projector,
    count: usize,
) -> Result<[Scratch<f32>; 3], NodeError> {
    let mut views = [0, 1, 2].map(|_| Scratch::of(0.0, count));
    let [x, y, z] = &mut views;
    trochoid_scene::shading::view_directions(view_positions(inputs, view, eye)?, eye, [x, y, z]);
    Ok(views)
}

/// Returns the points of a block; none if the rays toward the eye are parallel and the view has no position pass.
///
/// # Errors
/// The camera is a perspective one, but the view has no position pass.
pub(crate) fn view_positions<'a>(
    inputs: &Inputs<'a>,
    view: &One<port::View>,
    eye: &Projector,
) -> Result<Vectors3<'a>, NodeError> {
    match inputs.view_if_any(view, POSITION[0]) {
        Some(_) => Ok(view_planes(inputs, view, POSITION)),
        None if eye.orthographic => Ok([&[]; 3]),
        None => {
            let expected = "one, which a perspective camera needs";
            Err(without_position(expected, "add the pass, or connect an orthographic camera"))
        }
    }
}
