//! The checks that what needs more of a surface, or of its view, than its kind gets it.

use crate::view::{Camera, Projection, Render};
use std::collections::BTreeSet;
use trochoid_graph::{Check, Connected, ItemName, Offer, One, Role, Source, Upstream, port};

/// The node behind a port, where it is known.
fn connected(port: &impl Connected, check: &Check<'_>) -> Option<Upstream> {
    port.sources().first().and_then(|source| check.upstream(source))
}

/// The same where it looks at surfaces.
fn render(view: &One<port::View>, check: &Check<'_>) -> Option<(String, Render)> {
    let view = connected(view, check)?;
    Some((view.name.clone(), view.node.get::<Render>()?.clone()))
}

/// Refuses what is no sea.
pub(crate) fn check_sea(sea: &One<port::Surface>, check: &mut Check<'_>) {
    if let Some(connected) = connected(sea, check)
        && !connected.offers(Offer::Rest)
    {
        let found = format!("\"{}\", a {}, which has no {}", connected.name, connected.ty(), Offer::Rest);
        let remedy = format!("connect {}", check.offering(Offer::Rest));
        check.error(sea.id().item(), found, "a sea", remedy);
    }
}

/// Whether waves of the connected sea can break; true where that is not known.
#[cfg(feature = "sea")]
pub(crate) fn can_break(sea: &trochoid_graph::Optional<port::Surface>, check: &Check<'_>) -> bool {
    let known = |source: &Source<Vec<f64>>| check.upstream(source).is_none_or(|sea| sea.offers(Offer::Waves));
    sea.as_ref().is_some_and(known)
}

/// Warns where no surface of a view has trails.
pub(crate) fn check_trails(view: &One<port::View>, check: &mut Check<'_>) {
    let Some((name, render)) = render(view, check) else { return };
    let has_trails = |source: &Source<Vec<f64>>| check.upstream(source).is_none_or(|sea| sea.offers(Offer::Trails));
    if !render.surfaces.iter().any(has_trails) {
        let found = format!("the view \"{name}\", in which no surface has {}: it is 0 everywhere", Offer::Trails);
        let seas = check.offering(Offer::Trails);
        let remedy = format!("add {seas} to its surfaces, or remove this node");
        check.warning(view.id().item(), found, format!("the view of {seas}"), remedy);
    }
}

/// Refuses a view of passes where rays, or the points of surfaces, are asked for.
pub(crate) fn check_surfaces(view: &One<port::View>, check: &mut Check<'_>) {
    if let Some(passes) = connected(view, check)
        && passes.node.ty().declaration().role == Some(Role::Passes)
    {
        let found = format!("\"{}\", a view of passes, which knows no surfaces", passes.name);
        check.error(view.id().item(), found, "a view of surfaces", "connect a Render");
    }
}

/// Refuses views of two cameras where one camera has to see both.
pub(crate) fn check_same_camera(views: [&One<port::View>; 2], check: &mut Check<'_>) {
    let [Some((first, a)), Some((second, b))] = views.map(|view| render(view, check)) else { return };
    let differ = match (check.upstream(&a.camera), check.upstream(&b.camera)) {
        (Some(a), Some(b)) => a.node != b.node,
        _ => false,
    };
    if *a.camera != *b.camera && differ {
        let found = format!("\"{first}\" and \"{second}\", views of two cameras");
        let expected = format!("a view by the camera of \"{}\"", views[0].id().name());
        let remedy = format!("connect the camera of \"{first}\" to \"{second}\" too");
        check.error(views[1].id().item(), found, expected, remedy);
    }
}

/// Warns of places in the list of a Render's surfaces at which none stands.
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
        check.warning(item, found, expected, "the first in the Render's list is 0");
    }
}

/// A row of roots on surfaces, of which ribbons grow.
pub(crate) struct Roots {
    /// Where it begins and ends on its surface: u, v.
    pub(crate) ends: [[f64; 2]; 2],
    /// How far roots stand off the row.
    pub(crate) scatter: [f64; 2],
    /// The length of ribbons in meters.
    pub(crate) length: f64,
    /// Index of its surface in the Render's list; `None` for all.
    pub(crate) surface: Option<i64>,
}

/// How many of their lengths away ribbons are smaller than a pixel.
const TINY: f64 = 2000.0;

/// Warns of rows whose roots lie beside every surface of a view, or so far from its camera that nothing of
/// them is seen: where all surfaces are seas, on which u and v are meters.
pub(crate) fn check_roots(view: &One<port::View>, item: ItemName, rows: &[Roots], check: &mut Check<'_>) {
    let Some((_, render)) = render(view, check) else { return };
    let seas: Option<Vec<Place>> = render.surfaces.iter().map(|source| place(&check.upstream(source)?)).collect();
    // What is no camera is an error of the view's own.
    let camera = check.upstream(&render.camera);
    let camera = camera.as_ref().and_then(|camera| camera.node.get::<Camera>());
    let (Some(seas), Some(camera)) = (seas, camera) else { return };
    let [x, _, z] = camera.position;
    let is_far = camera.projection == Projection::Perspective;
    for (index, row) in rows.iter().enumerate() {
        if seas.iter().all(|sea| sea.grid.is_some_and(|grid| misses(grid, row.ends))) {
            let found = format!("rows[{index}] beside the grids of all surfaces: it has no ribbon");
            let remedy = "move \"from\" and \"to\" onto the surface, in meters of its x and z";
            check.warning(item, found, "roots on a surface", remedy);
        }
        let away = distance(row.ends, [x, z]);
        if is_far && away > TINY * row.length {
            let found = format!("rows[{index}], {away:.0} m from the camera, with ribbons {} m long", row.length);
            let remedy = "move \"from\" and \"to\" nearer, or raise \"length\"";
            check.warning(item, found, "ribbons that are seen, larger than a pixel", remedy);
        }
        let grows = |index: usize| row.surface.is_none_or(|only| only == index as i64);
        let mut grown = seas.iter().enumerate().filter(|(index, _)| grows(*index)).peekable();
        if is_far && grown.peek().is_some() && grown.all(|(_, sea)| is_behind(camera, sea.level, row)) {
            let found = format!("rows[{index}] behind the camera: nothing of it is seen");
            let remedy = "move \"from\" and \"to\", or turn the camera";
            check.warning(item, found, "roots in front of the camera", remedy);
        }
    }
}

/// Whether all roots of a row, and all that ribbons of their length could reach, stand behind a camera.
fn is_behind(camera: &Camera, level: f64, row: &Roots) -> bool {
    let Camera { position, target, .. } = camera;
    let forward = [0, 1, 2].map(|axis| target[axis] - position[axis]);
    let long = libm::hypot(libm::hypot(forward[0], forward[1]), forward[2]);
    let forward = if long > 0.0 { forward.map(|part| part / long) } else { [0.0, 0.0, -1.0] };
    // Ribbons begin within the scatter and reach two lengths at most.
    let reach = libm::hypot(row.scatter[0], row.scatter[1]) + 2.0 * row.length;
    let ahead = |[x, z]: [f64; 2]| {
        let off = [x - position[0], level - position[1], z - position[2]];
        off[0] * forward[0] + off[1] * forward[1] + off[2] * forward[2]
    };
    row.ends.into_iter().all(|end| ahead(end) < -reach)
}

/// Where a sea lies.
struct Place {
    /// World y at rest.
    level: f64,
    /// Its least and greatest x, z; `None` for one without end.
    grid: Option<[[f64; 2]; 2]>,
}

/// Where a surface lies that is a sea.
#[cfg(feature = "sea")]
fn place(surface: &Upstream) -> Option<Place> {
    use super::{gerstner_sea::GerstnerSea, ripple_sea::RippleSea, toon_sea::ToonSea};
    let node = &surface.node;
    let endless = |level: f64| Place { level, grid: None };
    let gerstner = node.get::<GerstnerSea>().map(|sea| endless(sea.level));
    let ripple = || node.get::<RippleSea>().map(|sea| endless(sea.level));
    let toon = || node.get::<ToonSea>().map(|sea| Place { level: sea.level, grid: Some(sea.extent()) });
    gerstner.or_else(ripple).or_else(toon)
}

/// There are no seas.
#[cfg(not(feature = "sea"))]
fn place(_surface: &Upstream) -> Option<Place> {
    None
}

/// Whether a line between two points lies beside a rectangle for certain.
fn misses([least, most]: [[f64; 2]; 2], ends: [[f64; 2]; 2]) -> bool {
    (0..2).any(|axis| ends.iter().all(|end| end[axis] < least[axis]) || ends.iter().all(|end| end[axis] > most[axis]))
}

/// How far the nearest point of a line lies.
fn distance([from, to]: [[f64; 2]; 2], place: [f64; 2]) -> f64 {
    let (along, off) = ([to[0] - from[0], to[1] - from[1]], [place[0] - from[0], place[1] - from[1]]);
    let square = along[0] * along[0] + along[1] * along[1];
    let share = if square > 0.0 { ((along[0] * off[0] + along[1] * off[1]) / square).clamp(0.0, 1.0) } else { 0.0 };
    libm::hypot(off[0] - share * along[0], off[1] - share * along[1])
}
