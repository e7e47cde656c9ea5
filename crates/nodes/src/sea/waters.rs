//! Checks of nodes that need more of a surface or view than its kind guarantees.

use crate::view::{Camera, Projection, Render};
use std::collections::BTreeSet;
use trochoid_graph::{Check, Connected, ItemName, Offer, One, Role, Source, Upstream, port};

/// Returns the node connected to a port, if known.
fn connected(port: &impl Connected, check: &Check<'_>) -> Option<Upstream> {
    port.sources().first().and_then(|source| check.upstream(source))
}

/// Returns the Render connected to a port and its name, if known.
fn render(view: &One<port::View>, check: &Check<'_>) -> Option<(String, Render)> {
    let view = connected(view, check)?;
    Some((view.name.clone(), view.node.get::<Render>()?.clone()))
}

/// Refuses a surface that is not a sea.
pub(crate) fn check_sea(sea: &One<port::Surface>, check: &mut Check<'_>) {
    if let Some(connected) = connected(sea, check)
        && !connected.offers(Offer::Rest)
    {
        let found = format!("\"{}\", a {}, which has no {}", connected.name, connected.ty(), Offer::Rest);
        let remedy = format!("connect {}", check.offering(Offer::Rest));
        check.error(sea.id().item(), found, "a sea", remedy);
    }
}

/// Whether waves of the connected sea can break; true if unknown.
#[cfg(feature = "sea")]
pub(crate) fn can_break(sea: &trochoid_graph::Optional<port::Surface>, check: &Check<'_>) -> bool {
    let known = |source: &Source<Vec<f64>>| check.upstream(source).is_none_or(|sea| sea.offers(Offer::Waves));
    sea.as_ref().is_some_and(known)
}

/// Warns if no surface of a view has trails.
pub(crate) fn check_trails(view: &One<port::View>, check: &mut Check<'_>) {
    let Some((name, render)) = render(view, check) else { return };
    let has_trails = |source: &Source<Vec<f64>>| check.upstream(source).is_none_or(|sea| sea.offers(Offer::Trails));
    if !render.surfaces.iter().any(has_trails) {
        let found = format!("the view \"{name}\", in which no surface has {}, so the result is 0", Offer::Trails);
        let seas = check.offering(Offer::Trails);
        let remedy = format!("add {seas} to its surfaces, or remove this node");
        check.warning(view.id().item(), found, format!("the view of {seas}"), remedy);
    }
}

/// Refuses a view of passes where rays or points of surfaces are needed.
pub(crate) fn check_surfaces(view: &One<port::View>, check: &mut Check<'_>) {
    if let Some(passes) = connected(view, check)
        && passes.node.ty().declaration().role == Some(Role::Passes)
    {
        let found = format!("\"{}\", a view of passes, which has no surfaces", passes.name);
        check.error(view.id().item(), found, "a view of surfaces", "connect a Render");
    }
}

/// Refuses views by different cameras where one camera has to see both.
pub(crate) fn check_same_camera(views: [&One<port::View>; 2], check: &mut Check<'_>) {
    let [Some((first, a)), Some((second, b))] = views.map(|view| render(view, check)) else { return };
    let differ = match (check.upstream(&a.camera), check.upstream(&b.camera)) {
        (Some(a), Some(b)) => a.node != b.node,
        _ => false,
    };
    if *a.camera != *b.camera && differ {
        let found = format!("\"{first}\" and \"{second}\", views by different cameras");
        let expected = format!("a view by the same camera as \"{}\"", views[0].id().name());
        let remedy = format!("connect the camera of \"{first}\" to \"{second}\" too");
        check.error(views[1].id().item(), found, expected, remedy);
    }
}

/// Warns about indices beyond the end of a Render's list of surfaces.
pub(crate) fn check_indices(
    view: &One<port::View>,
    item: ItemName,
    indices: impl IntoIterator<Item = f64>,
    check: &mut Check<'_>,
) {
    let Some((name, render)) = render(view, check) else { return };
    let count = render.surfaces.len();
    let beyond = indices.into_iter().filter(|index| *index >= count as f64);
    let beyond: BTreeSet<u64> = beyond.map(|index| index as u64).collect();
    if !beyond.is_empty() {
        let listed: Vec<String> = beyond.iter().map(u64::to_string).collect();
        let found = format!("the surface {} of \"{name}\", which has {count}", listed.join(", "));
        let expected = if count == 1 { "0, its only surface".into() } else { format!("0 to {}", count - 1) };
        check.warning(item, found, expected, "count the Render's list from 0");
    }
}

/// A row of roots on surfaces, from which ribbons grow.
pub(crate) struct Roots {
    /// The u, v of its two ends on the surface.
    pub(crate) ends: [[f64; 2]; 2],
    /// Scatter of the roots around the row.
    pub(crate) scatter: [f64; 2],
    /// Length of the ribbons in meters.
    pub(crate) length: f64,
    /// Index of its surface in the Render's list; `None` for all surfaces.
    pub(crate) surface: Option<i64>,
}

/// Distance, in ribbon lengths, beyond which ribbons are smaller than a pixel.
const TINY: f64 = 2000.0;

/// Warns about rows whose roots miss every surface of a view, or whose ribbons cannot be visible: too far from its
/// camera or behind it. Checks only views in which all surfaces are seas, where u and v are in meters.
pub(crate) fn check_roots(view: &One<port::View>, item: ItemName, rows: &[Roots], check: &mut Check<'_>) {
    let Some((_, render)) = render(view, check) else { return };
    let seas: Option<Vec<SeaPlane>> =
        render.surfaces.iter().map(|source| sea_plane(&check.upstream(source)?)).collect();
    // The view itself reports an input that is not a camera.
    let camera = check.upstream(&render.camera);
    let camera = camera.as_ref().and_then(|camera| camera.node.get::<Camera>());
    let (Some(seas), Some(camera)) = (seas, camera) else { return };
    let [x, _, z] = camera.position;
    let is_far = camera.projection == Projection::Perspective;
    for (index, row) in rows.iter().enumerate() {
        if seas.iter().all(|sea| sea.grid.is_some_and(|grid| misses(grid, row.ends))) {
            let found = format!("rows[{index}] outside the grids of all surfaces, so it has no ribbons");
            let remedy = "move \"from\" and \"to\" onto the surface, in meters of its x and z";
            check.warning(item, found, "roots on a surface", remedy);
        }
        let away = distance(row.ends, [x, z]);
        if is_far && away > TINY * row.length {
            let found = format!("rows[{index}], {away:.0} m from the camera, with ribbons {} m long", row.length);
            let remedy = "move \"from\" and \"to\" closer, or increase \"length\"";
            check.warning(item, found, "ribbons larger than a pixel", remedy);
        }
        let grows = |index: usize| row.surface.is_none_or(|only| only == index as i64);
        let mut grown = seas.iter().enumerate().filter(|(index, _)| grows(*index)).peekable();
        if is_far && grown.peek().is_some() && grown.all(|(_, sea)| is_behind(camera, sea.level, row)) {
            let found = format!("rows[{index}] behind the camera, so it is not visible");
            let remedy = "move \"from\" and \"to\", or turn the camera";
            check.warning(item, found, "roots in front of the camera", remedy);
        }
    }
}

/// Whether all roots of a row, and everything that ribbons of their length can reach, are behind a camera.
fn is_behind(camera: &Camera, level: f64, row: &Roots) -> bool {
    let Camera { position, target, .. } = camera;
    let forward = [0, 1, 2].map(|axis| target[axis] - position[axis]);
    let long = libm::hypot(libm::hypot(forward[0], forward[1]), forward[2]);
    let forward = if long > 0.0 { forward.map(|part| part / long) } else { [0.0, 0.0, -1.0] };
    // Ribbons begin within the scatter and reach at most two lengths.
    let reach = libm::hypot(row.scatter[0], row.scatter[1]) + 2.0 * row.length;
    let ahead = |[x, z]: [f64; 2]| {
        let off = [x - position[0], level - position[1], z - position[2]];
        off[0] * forward[0] + off[1] * forward[1] + off[2] * forward[2]
    };
    row.ends.into_iter().all(|end| ahead(end) < -reach)
}

/// Position of a sea.
struct SeaPlane {
    /// World y at rest.
    level: f64,
    /// Least and greatest x, z; `None` for an endless sea.
    grid: Option<[[f64; 2]; 2]>,
}

/// Returns the position of a surface that is a sea.
#[cfg(feature = "sea")]
fn sea_plane(surface: &Upstream) -> Option<SeaPlane> {
    use super::{gerstner_sea::GerstnerSea, ripple_sea::RippleSea, toon_sea::ToonSea};
    let node = &surface.node;
    let endless = |level: f64| SeaPlane { level, grid: None };
    let gerstner = node.get::<GerstnerSea>().map(|sea| endless(sea.level));
    let ripple = || node.get::<RippleSea>().map(|sea| endless(sea.level));
    let toon = || node.get::<ToonSea>().map(|sea| SeaPlane { level: sea.level, grid: Some(sea.extent()) });
    gerstner.or_else(ripple).or_else(toon)
}

/// Returns `None`: there are no seas without the feature `sea`.
#[cfg(not(feature = "sea"))]
fn sea_plane(_surface: &Upstream) -> Option<SeaPlane> {
    None
}

/// Whether a line between two points certainly misses a rectangle.
fn misses([least, most]: [[f64; 2]; 2], ends: [[f64; 2]; 2]) -> bool {
    (0..2).any(|axis| ends.iter().all(|end| end[axis] < least[axis]) || ends.iter().all(|end| end[axis] > most[axis]))
}

/// Returns the distance of a point from a line segment.
fn distance([from, to]: [[f64; 2]; 2], place: [f64; 2]) -> f64 {
    let (along, off) = ([to[0] - from[0], to[1] - from[1]], [place[0] - from[0], place[1] - from[1]]);
    let square = along[0] * along[0] + along[1] * along[1];
    let share = if square > 0.0 { ((along[0] * off[0] + along[1] * off[1]) / square).clamp(0.0, 1.0) } else { 0.0 };
    libm::hypot(off[0] - share * along[0], off[1] - share * along[1])
}
