//! Thickness: how much water light has to pass through.

use super::{Facets, PathKnobs, Quantity, RayQuantity, Rays, SeenPoint};
use crate::lit::{eye, toward_eye};
use trochoid_graph::*;
use trochoid_scene::shading::unit_or_up;
use trochoid_scene::{DVec3, Light};

/// The thickness of the water between the seen point and the air behind it, toward a light or along the eye's ray.
///
/// # Formula
/// The length of the straight path from P − δN to where it first passes through a surface, at most `distance`; δ =
/// `inset`, but at most half the distance to the first surface along −N. The path leads toward the light, or, if `ray`
/// is eye, along the eye's ray d refracted by the water: r = d/η − (d · N/η + √(1 − (1 − (d · N)²)/η²))N.
///
/// # Edge cases
/// 0 where nothing is seen. `distance` where the path never ends: toward a light below the horizon, or out of a
/// surface seen from below. Surfaces count as far as the picture extended by `beyond` reaches; paths start at least
/// 1/50 of a facet below them.
///
/// # Source
/// Thesis 3.1.2: thin crests against the light are translucent; Snell's law.
#[derive(Clone, Node)]
#[node(
    end = Front, revision = 1,
    example = r#""ray": "eye""#,
    output(thickness: Kind::Field(1) = "Length of the path, m.")
)]
pub(crate) struct Thickness {
    /// View of the surfaces; must be a Render.
    view: One<port::View>,
    /// Light toward which the path leads, for `ray` light.
    light: Optional<port::Light>,
    /// Direction of the path: toward the "light", or along the refracted ray of the "eye".
    ray: Leads,
    /// Index of refraction η, for `ray` eye.
    #[knob(default = 1.333, range = 1.0..=10.0)]
    ior: f64,
    #[items]
    path_knobs: PathKnobs,
    #[items]
    facets: Facets,
}

#[derive(Clone, Copy, Debug, PartialEq, Choice)]
enum Leads {
    Light,
    Eye,
}

impl RayQuantity for Thickness {
    const RATE: Rate = Rate::Surface;

    fn view(&self) -> &One<port::View> {
        &self.view
    }

    fn facets(&self) -> &Facets {
        &self.facets
    }

    fn most(&self) -> f64 {
        self.path_knobs.most()
    }

    fn interval(&self) -> Option<(f64, f64)> {
        // The value is rounded to f32.
        Some((0.0, f64::from(self.path_knobs.most() as f32)))
    }

    fn check(&self, check: &mut Check<'_>) {
        if self.ray == Leads::Light && self.light.is_none() {
            let found = "ray light without a light";
            check.error(Self::RAY, found, "a light to trace toward", "connect \"light\", or use \"eye\"");
        }
    }

    fn quantity(&self, prepare: &Prepare<'_>) -> Result<Quantity, NodeError> {
        let eye = eye(prepare, &self.view, prepare.frame.format)?;
        let light = match self.ray {
            Leads::Light => prepare.handles::<Light>(&self.light)?.first().copied(),
            Leads::Eye => None,
        };
        let &Self { ior, path_knobs, .. } = self;
        let along = move |seen: &SeenPoint| match &light {
            Some(light) => light.illuminate(seen.point).direction,
            None => refracted(-unit_or_up(toward_eye(&eye, seen.point)), seen.normal, ior),
        };
        Ok(Box::new(move |seen: &[SeenPoint], rays: &dyn Rays| {
            let starts = path_knobs.starts(seen, rays);
            path_knobs.lengths(starts.iter().copied().zip(seen.iter().map(&along)), rays)
        }))
    }

    fn output(quantity: f64) -> Reference {
        Reference::Field(vec![quantity])
    }
}

/// Returns a unit direction refracted by a surface with this unit normal into a medium with index of refraction `ior`.
pub(crate) fn refracted(direction: DVec3, normal: DVec3, ior: f64) -> DVec3 {
    let cosine = direction.dot(normal) / ior;
    let squared = 1.0 - (1.0 / (ior * ior) - cosine * cosine);
    unit_or_up(direction / ior - normal * (cosine + squared.max(0.0).sqrt()))
}
