//! Where numbers of a node are written: in the node, or in the uses of groups to whose knobs it is linked.

use super::NoGroup;
use super::face::whole_default;
use super::library::object;
use super::link;
use crate::document::change::style;
use crate::document::curve::Curve;
use crate::document::json::{Op, Path, Step};
use crate::document::link::links;
use crate::document::sheet::Sheet;
use serde_json::{Value, json};
use trochoid::{Knob, KnobType};

/// Why a number cannot be changed, as a sentence.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
pub enum NotWritten {
    /// It follows a formula.
    #[error("{knob} follows \"{link}\": change what it follows, or end the link in Properties")]
    Linked {
        /// The knob.
        knob: String,
        /// The formula.
        link: String,
        /// Where that is written, if in the document itself.
        at: Option<Path>,
    },
    /// The definition of its group is in another file.
    #[error("{knob} cannot be changed here: {why}")]
    Group {
        /// The knob.
        knob: String,
        /// The reason.
        why: NoGroup,
    },
    /// The document has no such node.
    #[error("{0} is not in the document: add it there first")]
    Missing(String),
    /// The document cannot be evaluated.
    #[error("the document has errors: correct them first")]
    Faulty,
}

/// A number of a knob, or one component of a vector, as the document has it.
#[derive(Clone, Debug, PartialEq)]
pub struct Written {
    /// Place of the knob's value in the document.
    pub path: Path,
    /// The component of the vector that is there; `None` if it is a number.
    component: Option<usize>,
    /// The value at this place, or the default of a group that stands for it.
    value: Option<Value>,
    /// Whether the value is at this place.
    is_here: bool,
    /// All numbers of the value at the present frame.
    present: Vec<f64>,
    /// Smallest and largest number that the knob takes.
    range: [f64; 2],
}

/// A link that a number follows.
struct Followed {
    text: String,
    /// Whether it stands for one component of a vector alone.
    is_component: bool,
    /// Whether it is all of the value or component, not a part of a key.
    is_whole: bool,
}

/// A use of a group that has a node.
struct Level<'s> {
    /// Its path in the document.
    place: Result<Path, NoGroup>,
    body: &'s Value,
    /// The definition of the group.
    group: &'s Value,
}

/// Returns the uses that have a node, from the outermost one, with the place and the body of the node itself.
fn descend<'s>(root: &'s Sheet, node: &str) -> Option<(Vec<Level<'s>>, Result<Path, NoGroup>, &'s Value)> {
    let (mut nodes, mut place) = (object(&root.value, "nodes")?, Ok(Path::default()));
    let mut levels = Vec::new();
    let mut names = node.split('/').peekable();
    while let Some(name) = names.next() {
        let body = nodes.get(name)?;
        let own = place.map(|place: Path| place.to("nodes").to(name));
        if names.peek().is_none() {
            return Some((levels, own, body));
        }
        let (group, definition) = root.library.used(body)?;
        levels.push(Level { place: own, body, group: &definition.body });
        place = match &definition.file {
            Some(file) => Err(NoGroup::Included { group: group.into(), file: file.clone() }),
            None => Ok(Path::default().to("groups").to(group)),
        };
        nodes = object(&definition.body, "nodes")?;
    }
    None
}

impl Written {
    /// Finds where a number of a knob is written. `node` is the name of the node in the expanded document, `record` the
    /// steps from it to the record that has the knob; of a vector, the number is a component. `present` has all numbers of
    /// the knob at the present frame.
    ///
    /// # Errors
    /// The number follows a formula, or is in a group that cannot be changed.
    pub fn find(
        root: &Sheet,
        node: &str,
        record: &[Step],
        knob: &Knob,
        component: Option<usize>,
        present: &[f64],
    ) -> Result<Self, NotWritten> {
        let steps = Path(record.to_vec()).to(knob.name);
        let spoken = format!("{}.{steps}", node.replace('/', "."));
        let (mut levels, place, body) = descend(root, node).ok_or_else(|| NotWritten::Missing(node.into()))?;
        let mut place = place.map(|place| place.join(&steps.0));
        let range = match knob.takes {
            KnobType::Number { min, max } => [min, max],
            _ => [f64::NEG_INFINITY, f64::INFINITY],
        };
        let value = steps.find(body).cloned();
        let is_here = value.is_some();
        let mut found = Self { path: Path::default(), component, value, is_here, present: present.to_vec(), range };
        while let Some(Followed { text, is_component, is_whole }) = found.link() {
            let at = place.as_ref().ok().cloned();
            let linked = || NotWritten::Linked { knob: spoken.clone(), link: text.clone(), at: at.clone() };
            let Some(("knobs", name)) = link::sole(&text).filter(|_| is_whole) else { return Err(linked()) };
            let level = levels.pop().ok_or_else(linked)?;
            let definition = level.group.get("knobs").and_then(|knobs| knobs.get(name)).ok_or_else(linked)?;
            if let Some(index) = found.component.filter(|_| is_component) {
                found.present = found.present.get(index).copied().into_iter().collect();
                found.component = None;
            }
            let own = level.body.get(name);
            found.value = own.or(whole_default(definition).0).cloned();
            found.is_here = own.is_some();
            found.narrow(definition);
            place = level.place.map(|place| place.to(name));
        }
        found.path = place.map_err(|why| NotWritten::Group { knob: spoken, why })?;
        Ok(found)
    }

    /// Returns the link that the number follows.
    fn link(&self) -> Option<Followed> {
        let value = self.value.as_ref()?;
        // What one component follows does not concern the others.
        let component = value.as_array().zip(self.component).map(|(items, index)| items.get(index));
        let is_component = component.is_some();
        let value = component.unwrap_or(Some(value))?;
        let (place, text) = links(value, &Path::default()).into_iter().next()?;
        Some(Followed { text: text.into(), is_component, is_whole: place.0.is_empty() })
    }

    /// Narrows the range to that of a knob of a group.
    fn narrow(&mut self, definition: &Value) {
        let end = |key: &str| definition.get(key).and_then(Value::as_f64);
        let [min, max] = self.range;
        self.range = [end("min").map_or(min, |own| own.max(min)), end("max").map_or(max, |own| own.min(max))];
    }

    /// Returns the number at the present frame.
    fn number(&self) -> Option<f64> {
        self.present.get(self.component.unwrap_or(0)).copied()
    }

    /// Whether two numbers are one in the document.
    pub fn is_at(&self, other: &Self) -> bool {
        (&self.path, self.component) == (&other.path, other.component)
    }

    /// Returns a number within the range of the knob.
    pub fn limited(&self, number: f64) -> f64 {
        number.max(self.range[0]).min(self.range[1])
    }
}

/// Returns the operations that give numbers other values: where a value is keyed, at its key at the frame, which is the
/// present one. Nothing is written for numbers that have their value already.
pub fn rewritten(numbers: &[(&Written, f64)], frame: i64) -> Vec<Op> {
    let mut ops = Vec::new();
    let changes = |(written, number): &(&Written, f64)| written.number() != Some(*number);
    let numbers: Vec<(&Written, f64)> = numbers.iter().copied().filter(changes).collect();
    for (index, (first, _)) in numbers.iter().enumerate() {
        if numbers[..index].iter().any(|(earlier, _)| earlier.path == first.path) {
            continue;
        }
        // All numbers of one value are written together.
        let mut all = first.present.clone();
        let changed: Vec<(usize, f64)> = numbers
            .iter()
            .filter(|(other, _)| other.path == first.path)
            .map(|(other, number)| (other.component.unwrap_or(0), *number))
            .collect();
        for (index, number) in &changed {
            if let Some(place) = all.get_mut(*index) {
                *place = *number;
            }
        }
        let whole = if first.component.is_some() { json!(all) } else { json!(all.first()) };
        match (&first.value, first.is_here) {
            (Some(Value::Array(_)), true) => {
                ops.extend(changed.iter().map(|(index, number)| Op::Set(first.path.to(*index), style(&json!(number)))));
            }
            (Some(value @ Value::Object(_)), is_here) => ops.extend(keyed(&first.path, value, is_here, frame, &whole)),
            _ => ops.push(Op::Set(first.path.clone(), style(&whole))),
        }
    }
    ops
}

/// Returns the operations that set the key of a value at a frame.
fn keyed(path: &Path, value: &Value, is_here: bool, frame: i64, whole: &Value) -> Vec<Op> {
    let Some(old) = Curve::read(value) else { return Vec::new() };
    let new = old.keyed(frame as f64, whole);
    if !is_here {
        // The keys are the default of a group: the use gets them all, with the changed one.
        return vec![Op::Set(path.clone(), style(&new.write()))];
    }
    let keys = path.to("keys");
    let Some(at) = new.find(frame as f64) else { return Vec::new() };
    if old.find(frame as f64).is_some() {
        return vec![Op::Set(keys.to(at).to(1), style(whole))];
    }
    // The handles of its neighbors may have changed, too.
    let others = new.keys.iter().enumerate().filter(|(index, _)| *index != at).map(|(_, key)| key);
    let changed = old.keys.iter().zip(others).enumerate().filter(|(_, (old, new))| old != new);
    let mut ops: Vec<Op> = changed.map(|(index, (_, new))| Op::Set(keys.to(index), style(&new.write()))).collect();
    ops.push(Op::Insert(keys.to(at), style(&new.keys[at].write())));
    ops
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::document::Session;
    use trochoid::{Item, registry};

    /// A boat in a group, used twice in another group.
    const FLEET: &str = r##"{
      "trochoid": 1, "format": { "width": 8, "height": 8 },
      "knobs": { "far": 4 },
      "groups": {
        "Boat": {
          "inputs": { "sea": "Surface" },
          "knobs": { "x": { "default": 1, "min": -50, "max": 50 }, "turn": 0, "way": { "keys": [[1, 0], [9, 8]] } },
          "nodes": {
            "hull": { "type": "BezierModel", "rotate": [0, "= knobs.turn", 5], "translate": [1, 2, 3],
              "rails": [{ "points": [{ "at": [0, 0, 0] }, { "at": [1, 0, 0] }] },
                        { "points": [{ "at": [0, 0, 1] }, { "at": [1, 0, 1] }] }] },
            "boat": { "type": "Float", "model": "hull", "sea": "sea",
                      "bodies": [{ "x": "= knobs.x", "z": "= knobs.way", "lift": "= 2*knobs.x" }] }
          },
          "outputs": { "boat": "boat" }
        },
        "Pair": {
          "inputs": { "sea": "Surface" }, "knobs": { "x": 3 },
          "nodes": {
            "front": { "type": "Boat", "sea": "sea", "x": "= knobs.x" },
            "back": { "type": "Boat", "sea": "sea", "turn": "= knobs.x - 1" }
          },
          "outputs": { "front": "front", "back": "back" }
        }
      },
      "nodes": {
        "sea": { "type": "RippleSea" },
        "pair": { "type": "Pair", "sea": "sea", "x": 7 },
        "boat": { "type": "Boat", "sea": "sea", "x": "= knobs.far" }
      }
    }"##;

    fn knob(ty: &str, list: Option<&str>, name: &str) -> Knob {
        let mut items = registry().get(ty).unwrap().declaration().items;
        if let Some(list) = list {
            let found = items.iter().find(|item| item.name() == list);
            let Some(Item::List(list)) = found else { panic!("no list {list}") };
            items = list.items;
        }
        let Some(Item::Knob(knob)) = items.iter().find(|item| item.name() == name) else { panic!("no knob {name}") };
        *knob
    }

    fn body(node: &str, name: &str, present: f64) -> Result<Written, NotWritten> {
        let session = Session::new(FLEET.into(), None);
        let record = [Step::from("bodies"), Step::from(0)];
        Written::find(session.sheet(), node, &record, &knob("Float", Some("bodies"), name), None, &[present])
    }

    fn hull(node: &str, name: &str, component: usize) -> Result<Written, NotWritten> {
        let session = Session::new(FLEET.into(), None);
        Written::find(session.sheet(), node, &[], &knob("BezierModel", None, name), Some(component), &[9.0, 8.0, 7.0])
    }

    fn set(path: &str, text: &str) -> (String, String) {
        (path.into(), text.into())
    }

    fn ops(numbers: &[(&Written, f64)], frame: i64) -> Vec<(String, String)> {
        let told = |op: Op| match op {
            Op::Set(path, text) => (path.to_string(), text),
            Op::Insert(path, text) => (format!("before {path}"), text),
            other => panic!("{other:?}"),
        };
        rewritten(numbers, frame).into_iter().map(told).collect()
    }

    #[test]
    fn a_number_is_written_where_links_to_knobs_of_groups_lead() {
        let x = body("pair/front/boat", "x", 7.0).unwrap();
        assert_eq!(ops(&[(&x, 2.5)], 1), [set("nodes.pair.x", "2.5")]);
        assert_eq!(x.limited(70.0), 50.0, "the range of the group's knob");
        // What a use does not set is set there.
        let x = body("pair/back/boat", "x", 1.0).unwrap();
        assert_eq!(ops(&[(&x, 2.5)], 1), [set("groups.Pair.nodes.back.x", "2.5")]);
    }

    #[test]
    fn a_number_that_follows_a_formula_is_not_written() {
        let linked = |found: Result<Written, NotWritten>| found.unwrap_err().to_string();
        let remedy = "change what it follows, or end the link in Properties";
        assert_eq!(
            linked(body("boat/boat", "x", 4.0)),
            format!("boat.boat.bodies[0].x follows \"= knobs.far\": {remedy}"),
            "a knob of the document is not that of a use"
        );
        assert_eq!(
            linked(body("pair/front/boat", "lift", 14.0)),
            format!("pair.front.boat.bodies[0].lift follows \"= 2*knobs.x\": {remedy}")
        );
        assert_eq!(
            linked(hull("pair/back/hull", "rotate", 1)),
            format!("pair.back.hull.rotate follows \"= knobs.x - 1\": {remedy}")
        );
        assert_eq!(linked(body("nowhere", "x", 0.0)), "nowhere is not in the document: add it there first");
    }

    #[test]
    fn components_of_one_vector_are_written_together_and_others_stay() {
        let [x, z] = [0, 2].map(|component| hull("pair/front/hull", "translate", component).unwrap());
        assert_eq!(
            ops(&[(&x, 4.0), (&z, -1.5)], 1),
            [set("groups.Boat.nodes.hull.translate[0]", "4"), set("groups.Boat.nodes.hull.translate[2]", "-1.5")]
        );
        // A vector that is not written is written as a whole.
        let [x, y] = [0, 1].map(|component| hull("pair/front/hull", "scale", component).unwrap());
        assert_eq!(ops(&[(&x, 2.0), (&y, 2.0)], 1), [set("groups.Boat.nodes.hull.scale", "[2, 2, 7]")]);
        // A linked component is a number of the use; its neighbor is one of the node.
        let turn = hull("pair/front/hull", "rotate", 1).unwrap();
        assert_eq!(ops(&[(&turn, 30.0)], 1), [set("groups.Pair.nodes.front.turn", "30")]);
        let other = hull("pair/front/hull", "rotate", 2).unwrap();
        assert_eq!(ops(&[(&other, 30.0)], 1), [set("groups.Boat.nodes.hull.rotate[2]", "30")]);
    }

    #[test]
    fn a_keyed_number_changes_at_the_frame() {
        let z = body("pair/front/boat", "z", 0.0).unwrap();
        let keys = |text: &str| [set("groups.Pair.nodes.front.way", text)];
        assert_eq!(ops(&[(&z, 5.0)], 1), keys("{ \"keys\": [[1, 5], [9, 8]] }"), "the default's keys are copied");
        assert_eq!(ops(&[(&z, 5.0)], 4), keys("{ \"keys\": [[1, 0], [4, 5], [9, 8]] }"));
        let mut own = z.clone();
        own.is_here = true;
        assert_eq!(ops(&[(&own, 5.0)], 9), [set("groups.Pair.nodes.front.way.keys[1][1]", "5")]);
        assert_eq!(ops(&[(&own, 5.0)], 12), [set("before groups.Pair.nodes.front.way.keys[2]", "[12, 5]")]);
    }

    #[test]
    fn a_new_key_in_a_smooth_curve_changes_the_handles_beside_it() {
        let mut z = body("pair/front/boat", "z", 0.0).unwrap();
        z.is_here = true;
        z.value = Some(json!({ "keys": [[1, 0, { "out": [4, 0] }], [9, 8, { "in": [-4, 0] }]] }));
        let keys = "groups.Pair.nodes.front.way.keys";
        let found = ops(&[(&z, 5.0)], 5);
        assert_eq!(
            found,
            [
                set(&format!("{keys}[0]"), r#"[1, 0, { "out": [2, 0] }]"#),
                set(&format!("{keys}[1]"), r#"[9, 8, { "in": [-2, 0] }]"#),
                set(&format!("before {keys}[1]"), r#"[5, 5, { "in": [-1, -2], "out": [1, 2] }]"#),
            ]
        );
    }
}
