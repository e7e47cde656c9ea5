//! What surfaces have beside their shape, and the checks that what needs it gets it.

use std::collections::BTreeSet;
use trochoid_graph::{Check, Settled, Source, Upstream};

/// A plane at rest, over which it stands: of every sea.
pub(crate) const REST: &str = "a plane at rest";
/// Waves that crests of break, in closed form.
pub(crate) const WAVES: &str = "waves";
/// What bursts leave behind.
pub(crate) const TRAILS: &str = "trails of bursts";

/// The node behind a port, where it is known.
fn connected(node: &Settled, check: &Check<'_>, port: &str) -> Option<Upstream> {
    node.all(port).first().and_then(|source| check.upstream(source))
}

/// Refuses what is no sea.
pub(crate) fn check_sea(node: &Settled, check: &mut Check<'_>, port: &'static str) {
    if let Some(sea) = connected(node, check, port)
        && !sea.offers(REST)
    {
        let found = format!("\"{}\", a {}, which has no {}", sea.name, sea.ty.declaration().name, &REST[2..]);
        check.error(port, found, "a sea", "connect a GerstnerSea, RippleSea or ToonSea");
    }
}

/// Whether waves of the connected sea can break; true where that is not known.
pub(crate) fn can_break(node: &Settled, check: &Check<'_>, port: &str) -> bool {
    let known = |source: &Source<Vec<f64>>| check.upstream(source).is_none_or(|sea| sea.offers(WAVES));
    node.all(port).first().is_some_and(known)
}

/// Warns where no surface of the node's view has trails.
pub(crate) fn check_trails(node: &Settled, check: &mut Check<'_>) {
    let Some(view) = connected(node, check, "view").filter(|view| view.ty.declaration().name == "Render") else {
        return;
    };
    let has_trails = |source: &Source<Vec<f64>>| check.upstream(source).is_none_or(|sea| sea.offers(TRAILS));
    if !view.node.all("surfaces").iter().any(has_trails) {
        let found = format!("the view \"{}\", in which no surface has {TRAILS}: it is 0 everywhere", view.name);
        check.warning("view", found, "the view of a ToonSea", "add a ToonSea to its surfaces, or remove this node");
    }
}

/// Refuses a view of passes where rays, or the points of surfaces, are asked for.
pub(crate) fn check_surfaces(node: &Settled, check: &mut Check<'_>) {
    let passes = connected(node, check, "view").filter(|view| view.ty.declaration().name == "ViewFromPasses");
    if let Some(view) = passes {
        let found = format!("\"{}\", a view of passes, which knows no surfaces", view.name);
        check.error("view", found, "a view of surfaces", "connect a Render");
    }
}

/// Refuses views of two cameras where one camera has to see both.
pub(crate) fn check_same_camera(node: &Settled, check: &mut Check<'_>, ports: [&'static str; 2]) {
    let views = ports.map(|port| connected(node, check, port));
    let [Some(first), Some(second)] = views else { return };
    if [&first, &second].into_iter().any(|view| view.ty.declaration().name != "Render") {
        return;
    }
    let [a, b] = [&first, &second].map(|view| view.node.source("camera").clone());
    let differ = match (check.upstream(&a), check.upstream(&b)) {
        (Some(a), Some(b)) => a.ty.declaration().name != b.ty.declaration().name || a.node != b.node,
        _ => false,
    };
    if a != b && differ {
        let found = format!("\"{}\" and \"{}\", views of two cameras", first.name, second.name);
        let remedy = format!("connect the camera of \"{}\" to \"{}\" too", first.name, second.name);
        check.error(ports[1], found, format!("a view by the camera of \"{}\"", ports[0]), remedy);
    }
}

/// Warns of places in the list of a Render's surfaces at which none stands.
pub(crate) fn check_indices(
    node: &Settled,
    check: &mut Check<'_>,
    item: &'static str,
    indices: impl Iterator<Item = f64>,
) {
    let Some(view) = connected(node, check, "view").filter(|view| view.ty.declaration().name == "Render") else {
        return;
    };
    let count = view.node.all("surfaces").len();
    let beyond: BTreeSet<u64> = indices.filter(|index| *index >= count as f64).map(|index| index as u64).collect();
    if !beyond.is_empty() {
        let listed: Vec<String> = beyond.iter().map(u64::to_string).collect();
        let found = format!("the surface {} of \"{}\", which has {count}", listed.join(", "), view.name);
        let expected = if count == 1 { "0, its only surface".into() } else { format!("0 to {}", count - 1) };
        check.warning(item, found, expected, "the first in the Render's list is 0");
    }
}

/// How many of their lengths away ribbons are smaller than a pixel.
const TINY: f64 = 2000.0;

/// Warns of rows whose roots lie beside every surface of the node's view, or so far from its camera that nothing of
/// them is seen: where all surfaces are seas, on which u and v are meters.
pub(crate) fn check_roots(node: &Settled, check: &mut Check<'_>) {
    let Some(view) = connected(node, check, "view").filter(|view| view.ty.declaration().name == "Render") else {
        return;
    };
    let surfaces: Option<Vec<Upstream>> =
        view.node.all("surfaces").iter().map(|source| check.upstream(source).filter(|sea| sea.offers(REST))).collect();
    // What is no camera is an error of the view's own.
    let camera = check.upstream(view.node.source("camera")).filter(|camera| camera.ty.declaration().name == "Camera");
    let (Some(surfaces), Some(camera)) = (surfaces, camera) else { return };
    let [x, _, z] = camera.node.vector3("position");
    let is_far = camera.node.text("projection") == "perspective";
    for (index, row) in node.list("rows").iter().enumerate() {
        let ends = ["from", "to"].map(|knob| row.vector3(knob));
        let misses = |sea: &Upstream| grid(sea).is_some_and(|grid| misses(grid, ends));
        if surfaces.iter().all(misses) {
            let found = format!("rows[{index}] beside the grids of all surfaces: it has no ribbon");
            let remedy = "move \"from\" and \"to\" onto the surface, in meters of its x and z";
            check.warning("rows", found, "roots on a surface", remedy);
        }
        let away = distance(ends, [x, z]);
        if is_far && away > TINY * row.number("length") {
            let found =
                format!("rows[{index}], {away:.0} m from the camera, with ribbons {} m long", row.number("length"));
            let remedy = "move \"from\" and \"to\" nearer, or raise \"length\"";
            check.warning("rows", found, "ribbons that are seen, larger than a pixel", remedy);
        }
        let own = if row.is_set("surface") { row } else { node };
        let only = own.is_set("surface").then(|| own.number("surface"));
        let mut grown = surfaces.iter().enumerate().filter(|(index, _)| only.is_none_or(|only| only == *index as f64));
        if is_far && grown.clone().next().is_some() && grown.all(|(_, sea)| is_behind(&camera, sea, row)) {
            let found = format!("rows[{index}] behind the camera: nothing of it is seen");
            check.warning(
                "rows",
                found,
                "roots in front of the camera",
                "move \"from\" and \"to\", or turn the camera",
            );
        }
    }
}

/// Whether all roots of a row, and all that ribbons of their length could reach, stand behind a camera.
fn is_behind(camera: &Upstream, sea: &Upstream, row: &Settled) -> bool {
    let [position, target] = ["position", "target"].map(|knob| camera.node.vector3(knob));
    let forward = [0, 1, 2].map(|axis| target[axis] - position[axis]);
    let long = libm::hypot(libm::hypot(forward[0], forward[1]), forward[2]);
    let forward = if long > 0.0 { forward.map(|part| part / long) } else { [0.0, 0.0, -1.0] };
    let scatter = row.vector3("scatter");
    // Ribbons begin within the scatter and reach two lengths at most.
    let reach = libm::hypot(scatter[0], scatter[1]) + 2.0 * row.number("length");
    let ahead = |[x, z, _]: [f64; 3]| {
        let off = [x - position[0], sea.node.number("level") - position[1], z - position[2]];
        off[0] * forward[0] + off[1] * forward[1] + off[2] * forward[2]
    };
    ["from", "to"].into_iter().all(|knob| ahead(row.vector3(knob)) < -reach)
}

/// Where a sea of cells lies: its least and greatest x, z. None for one without end.
fn grid(sea: &Upstream) -> Option<[[f64; 2]; 2]> {
    if !sea.offers(TRAILS) {
        return None;
    }
    let node = &sea.node;
    let side = |knob: &str| (node.number(knob) - 1.0) * node.number("spacing");
    let least = [node.number("x"), node.number("z")];
    Some([least, [least[0] + side("columns"), least[1] + side("rows")]])
}

/// Whether a line between two points lies beside a rectangle for certain.
fn misses([least, most]: [[f64; 2]; 2], ends: [[f64; 3]; 2]) -> bool {
    (0..2).any(|axis| ends.iter().all(|end| end[axis] < least[axis]) || ends.iter().all(|end| end[axis] > most[axis]))
}

/// How far the nearest point of a line lies.
fn distance([from, to]: [[f64; 3]; 2], place: [f64; 2]) -> f64 {
    let (along, off) = ([to[0] - from[0], to[1] - from[1]], [place[0] - from[0], place[1] - from[1]]);
    let square = along[0] * along[0] + along[1] * along[1];
    let share = if square > 0.0 { ((along[0] * off[0] + along[1] * off[1]) / square).clamp(0.0, 1.0) } else { 0.0 };
    libm::hypot(off[0] - share * along[0], off[1] - share * along[1])
}
