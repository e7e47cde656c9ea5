use super::{SMALL, small};
use crate::document::{Edit, Path, Session, change, edit};
use serde_json::json;
use trochoid::{Item, KnobType, registry};

fn valid(session: &Session) {
    let errors: Vec<String> = session.meaning().errors().map(ToString::to_string).collect();
    assert!(errors.is_empty(), "{errors:?}\n{}", session.text());
}

fn value(session: &Session, node: &str, item: &str) -> serde_json::Value {
    session.sheet().get(&Path::node(node).to(item)).cloned().unwrap_or_default()
}

fn names(names: &[&str]) -> Vec<String> {
    names.iter().map(|name| (*name).to_string()).collect()
}

#[test]
fn every_type_of_node_can_be_added_and_taken_back() {
    let mut session = small();
    for name in registry().names() {
        let declaration = registry().get(name).unwrap().declaration();
        let (edit, name) = edit::added(session.sheet(), declaration, [10.0, 20.0]);
        session.edit(edit).unwrap();
        assert_eq!(session.sheet().node(&name).unwrap().at, [10.0, 20.0]);
        // What can have a constant has one, so only connections, lists, files and formulas may be missing.
        for fault in session.meaning().errors().filter(|fault| fault.node.as_deref() == Some(name.as_str())) {
            let port = fault.port.clone().unwrap_or_default();
            let item = declaration.items.iter().find(|item| item.name() == port);
            let is_open = matches!(item, Some(trochoid::Item::Port(_)));
            let is_text = matches!(item, Some(trochoid::Item::Knob(knob))
                if matches!(knob.takes, trochoid::KnobType::Path | trochoid::KnobType::Text | trochoid::KnobType::Numbers { .. }));
            let is_list = matches!(item, Some(trochoid::Item::List(_)));
            let is_open = is_open || fault.remedy.contains("connect");
            assert!(is_open || is_text || is_list, "{name}: {fault}");
        }
        session.undo();
        assert_eq!(session.text(), SMALL);
    }
}

#[test]
fn deleting_a_node_connects_its_input_to_its_readers() {
    let mut session = small();
    session.edit(edit::deleted(session.sheet(), &names(&["soft"]))).unwrap();
    valid(&session);
    assert_eq!(session.sheet().outputs[0].source, "both", "the output shows what the node took");
    session.edit(edit::deleted(session.sheet(), &names(&["sky", "sea"]))).unwrap();
    assert_eq!(value(&session, "both", "colors"), json!([]));
    session.undo();
    session.undo();
    assert_eq!(session.text(), SMALL);
}

#[test]
fn renaming_reaches_every_reference() {
    let mut session = small();
    session.edit(edit::renamed(session.sheet(), "sky", "heaven")).unwrap();
    valid(&session);
    assert_eq!(value(&session, "both", "colors"), json!(["heaven", "sea"]));
    session.edit(edit::renamed(session.sheet(), "soft", "end")).unwrap();
    valid(&session);
    assert_eq!(session.sheet().outputs[0].source, "end");
}

#[test]
fn connecting_and_disconnecting_keep_a_document_valid() {
    let mut session = small();
    let sheet = session.sheet().clone();
    let (sea, across) = (sheet.find("sea").unwrap(), sheet.find("down").unwrap());
    let pin = sheet.nodes[sea].pins.iter().position(|pin| pin.label == "weight").unwrap();
    session.edit(edit::connected(&sheet, (across, 0), (sea, pin))).unwrap();
    assert_eq!(value(&session, "sea", "weight"), json!("down"));
    session.edit(edit::disconnected(session.sheet(), (sea, pin))).unwrap();
    assert_eq!(value(&session, "sea", "weight"), json!(0.5), "a mask needs a number in its place");
    valid(&session);
}

#[test]
fn a_node_is_put_into_a_wire_and_taken_out() {
    let mut session = small();
    let invert = registry().get("Blur").unwrap().declaration();
    let (added, name) = edit::added(session.sheet(), invert, [0.0, 0.0]);
    session.edit(added).unwrap();
    let sheet = session.sheet().clone();
    let (node, sea) = (sheet.find(&name).unwrap(), sheet.find("sea").unwrap());
    let wire = *sheet.wires.iter().find(|wire| wire.to.0 == sea && sheet.nodes[wire.from.0].name == "sky").unwrap();
    session.edit(edit::inserted(&sheet, node, &wire).unwrap()).unwrap();
    valid(&session);
    assert_eq!(value(&session, "sea", "b"), json!(name));
    assert_eq!(value(&session, &name, "image"), json!("sky"));
    session.edit(edit::extracted(session.sheet(), std::slice::from_ref(&name))).unwrap();
    assert_eq!(value(&session, "sea", "b"), json!("sky"));
    assert!(session.sheet().find(&name).is_some());
}

#[test]
fn a_copy_pastes_into_a_chat_and_back() {
    let mut session = small();
    let text = edit::copied(session.sheet(), &names(&["sky", "sea"]));
    let chat = format!("look at this:\n```json\n{text}```\nnice?");
    let (edit, pasted) = edit::pasted(session.sheet(), &chat, [100.0, 50.0]).unwrap();
    session.edit(edit).unwrap();
    valid(&session);
    assert_eq!(pasted, ["sky2", "sea2"]);
    assert_eq!(value(&session, "sea2", "b"), json!("sky2"), "wires within the copy follow");
    assert_eq!(value(&session, "sea2", "weight"), json!("across"), "wires from outside stay");
    assert_eq!(session.sheet().node("sky2").unwrap().at, [100.0, 50.0]);
    let mut other = Session::new("{ \"trochoid\": 1, \"nodes\": {} }".into(), None);
    let (edit, _) = edit::pasted(other.sheet(), &text, [0.0, 0.0]).unwrap();
    other.edit(edit).unwrap();
    assert_eq!(value(&other, "sea", "weight"), serde_json::Value::Null, "a wire from a missing node is left out");
    for junk in ["", "hello", "{}", "{\"a\": 1}", "{\"a\": {}}", "[1, 2]"] {
        assert!(edit::pasted(session.sheet(), junk, [0.0, 0.0]).is_none(), "{junk}");
    }
}

#[test]
fn another_type_keeps_what_both_know() {
    let mut session = small();
    let retype = |session: &mut Session, name: &str, ty: &str| {
        let declaration = registry().get(ty).unwrap().declaration();
        session.edit(edit::retyped(session.sheet(), name, declaration)).unwrap();
        session.sheet().get(&Path::node(name)).cloned().unwrap()
    };
    // Every node has notes and can be disabled; what only the new type knows gets a constant.
    session.edit(Edit::set(Path::node("across").to("notes"), &json!("left to right"))).unwrap();
    session.edit(edit::disabled(session.sheet(), &names(&["across"]))).unwrap();
    let clamp = json!({ "type": "Clamp", "field": 0, "notes": "left to right", "disabled": true });
    assert_eq!(retype(&mut session, "across", "Clamp"), clamp);
    assert_eq!(value(&session, "sea", "weight"), json!("across"), "readers stay connected");
    // What only the old type knew is dropped.
    let patch = json!({ "type": "Patch", "u": 0.5, "v": 0.5, "colors": ["sky", "sea"] });
    assert_eq!(retype(&mut session, "both", "Patch"), patch);
    let strokes = retype(&mut session, "soft", "Strokes");
    assert_eq!([&strokes["image"], &strokes["size"]], [&json!("both"), &json!(2)], "a wire and a knob");
}

#[test]
fn a_drag_is_one_step_and_typing_another() {
    let mut session = small();
    for step in 0..30 {
        let at = [step as f32, 2.0 * step as f32];
        session.edit(edit::moved(&[("sky".into(), at)]).merging("drag")).unwrap();
    }
    session.seal();
    let path = Path::node("soft").to("size");
    for step in 0..5 {
        session.edit(Edit::set(path.clone(), &json!(step)).merging("size")).unwrap();
    }
    assert_eq!(value(&session, "soft", "size"), json!(4));
    assert_eq!(session.undo().as_deref(), Some("Set soft.size"));
    assert_eq!(value(&session, "soft", "size"), json!(2));
    assert_eq!(session.undo().as_deref(), Some("Move 1 node"));
    assert_eq!(session.text(), SMALL);
    assert!(session.undo().is_none());
}

#[test]
fn documents_with_faults_open_and_can_be_repaired() {
    let faulty = SMALL.replace("\"weight\": \"across\"", "\"weight\": \"nowhere\"").replace("Blur", "Blurr");
    let mut session = Session::new(faulty, None);
    assert!(session.meaning().graph.is_none());
    assert_eq!(session.sheet().nodes.len(), 6, "all nodes are there");
    assert!(session.sheet().node("soft").unwrap().declaration.is_none());
    session.edit(Edit::set(Path::node("sea").to("weight"), &json!("across"))).unwrap();
    session.edit(Edit::set(Path::node("soft").to("type"), &json!("Blur"))).unwrap();
    valid(&session);
    let broken = Session::new("{ \"trochoid\": 1, ".into(), None);
    assert!(!broken.meaning().readable);
    assert_eq!(broken.meaning().errors().count(), 1);
    assert_eq!(broken.sheet().nodes.len(), 0);
    // The nodes of the last valid text stay visible.
    session.replace("{ \"trochoid\": 1, ", "Type");
    assert!(!session.meaning().readable && session.meaning().graph.is_none());
    assert_eq!(session.sheet().nodes.len(), 6);
    session.undo();
    valid(&session);
}

#[test]
fn numbers_are_written_as_people_write_them() {
    let value = json!({ "a": [1.0, 2.5, -0.25], "b": { "c": "#fff000" }, "d": {}, "e": true });
    assert_eq!(change::style(&value), r##"{ "a": [1, 2.5, -0.25], "b": { "c": "#fff000" }, "d": {}, "e": true }"##);
}

#[test]
fn a_record_holds_what_its_items_take() {
    fn look(node: &str, items: &'static [Item], body: &serde_json::Value) {
        for item in items {
            match item {
                Item::Knob(knob) => match (&knob.takes, body.get(knob.name)) {
                    (KnobType::Number { min, max }, Some(value)) => {
                        let number = value.as_f64().unwrap_or(f64::NAN);
                        assert!((*min..=*max).contains(&number), "{node}: {} {value}", knob.name);
                    }
                    (KnobType::Vector(count), Some(value)) => {
                        let found = value.as_array().map(Vec::len);
                        assert_eq!(found, Some(*count), "{node}: {} {value}", knob.name);
                    }
                    _ => {}
                },
                Item::List(list) => look(node, list.items, &edit::record(list.items, 7)),
                Item::Port(_) => {}
            }
        }
    }
    for name in registry().names() {
        let items = registry().get(name).unwrap().declaration().items;
        look(name, items, &json!({}));
    }
}
