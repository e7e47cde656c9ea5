//! What follows the knobs of uses of groups.

use super::library::object;
use super::link::sole;
use crate::document::json::{Path, Step};
use crate::document::link::links;
use crate::document::sheet::Sheet;
use serde_json::{Map, Value};

/// Returns a value inside of a use that is the value of one of its knobs: the name of its node in the expanded document, and
/// its place in that node; `None` if only formulas have the knob. `name` is that of the use in the expanded document. The
/// document must be without errors.
pub fn follower(root: &Sheet, name: &str, knob: &str) -> Option<(String, Path)> {
    let mut nodes = object(&root.value, "nodes")?;
    for name in name.split('/') {
        let (_, definition) = root.library.used(nodes.get(name)?)?;
        nodes = object(&definition.body, "nodes")?;
    }
    within(root, name, nodes, knob)
}

fn within(root: &Sheet, name: &str, nodes: &Map<String, Value>, knob: &str) -> Option<(String, Path)> {
    nodes.iter().find_map(|(own, body)| {
        let own = format!("{name}/{own}");
        let following =
            links(body, &Path::default()).into_iter().filter(|(_, text)| sole(text) == Some(("knobs", knob)));
        let mut places = following.map(|(place, _)| place);
        match root.library.used(body) {
            None => places.next().map(|place| (own, place)),
            Some((_, definition)) => places.find_map(|place| {
                // A component of a knob has no name that links inside could have.
                let [Step::Key(inner)] = place.0.as_slice() else { return None };
                within(root, &own, object(&definition.body, "nodes")?, inner)
            }),
        }
    })
}
