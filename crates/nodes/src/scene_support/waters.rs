//! What surfaces have beside their shape, and the checks that what needs it gets it.

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
