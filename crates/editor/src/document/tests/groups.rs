//! Groups are made and unpacked without any change of the picture.

use crate::document::group::{grouped, made_local, promoted, renamed_knob, unpacked};
use crate::document::link::is_link;
use crate::document::{Edit, Path, Session, Sheet, edit, group};
use rand::{RngExt, SeedableRng};
use rand_pcg::Pcg64Mcg;
use serde_json::{Value, json};
use std::collections::BTreeSet;
use std::sync::Arc;
use trochoid::{Buffers, Cache, Item, Kind, KnobType, Plan, Settings, Silent};

/// Groups within groups, with links of all kinds into and out of them.
pub(crate) const LINKED: &str = r##"{
  "trochoid": 1,
  "format": { "width": 24, "height": 14 },
  "working_space": "srgb",
  "frames": { "first": 1, "last": 9, "fps": 24 },
  "palette": { "deep": "#102030" },
  "knobs": { "wind": { "value": 0.1, "min": 0, "max": 1 }, "ink": "#f0a040", "gap": "= soft.min + 0.05" },
  "groups": {
    "Dot": {
      "inputs": { "under": "Color", "shape": { "kind": "Mask", "default": 1 }, "over": { "kind": "Color", "optional": true } },
      "knobs": {
        "x": { "default": 0.5, "min": 0, "max": 2, "unit": "heights", "help": "Place across." },
        "size": 0.2, "ink": "#d8513a", "form": "disc", "half": "= knobs.size / 2"
      },
      "nodes": {
        "spot": { "type": "Shape", "shapes": [{ "form": "= knobs.form", "center": "= [knobs.x, 0.3 + knobs.half]", "radius": "= knobs.size" }] },
        "cut": { "type": "Multiply", "weights": ["spot", "shape"] },
        "lit": { "type": "Mix", "a": "under", "b": "= knobs.ink", "weight": "cut" }
      },
      "outputs": { "color": "lit", "spot": "cut", "through": "under" }
    },
    "Pair": {
      "inputs": { "ground": "Color" },
      "knobs": { "gap": { "default": 0.6 }, "ink": "#ffffff" },
      "nodes": {
        "one": { "type": "Dot", "under": "ground", "ink": "= knobs.ink" },
        "two": { "type": "Dot", "under": "one", "x": "= one.x + knobs.gap", "size": 0.1, "shape": "one.spot" }
      },
      "outputs": { "color": "two", "first": "one.spot" }
    }
  },
  "nodes": {
    "across": { "type": "ScreenX" },
    "soft": { "type": "Clamp", "field": "across", "min": "= 0.5 * knobs.wind", "max": "= soft.min + 0.5" },
    "sky": { "type": "Mix", "a": "palette.deep", "b": "= knobs.ink", "weight": "soft" },
    "pair": { "type": "Pair", "ground": "sky", "gap": "= 0.2 + knobs.gap" },
    "keyed": { "type": "Dot", "under": "pair", "x": { "keys": [[1, 0.2], [9, 1.2]] }, "size": 0.15, "shape": "pair.first" },
    "last": { "type": "Mix", "a": "keyed", "b": "keyed.through", "weight": { "keys": [[1, 0.25], [9, 0.5]] } },
    "grain": { "type": "Mix", "a": "last", "b": "#203040", "weight": "= pair.gap / 4" }
  },
  "outputs": { "beauty": { "color": "grain", "file": "a.png" }, "dots": { "weights": "keyed.spot", "file": "b.exr" } }
}
"##;

/// Returns the samples of all pictures of a document, at its first frame and at another one.
pub(crate) fn bits(text: &str) -> Vec<Vec<u32>> {
    let loaded =
        trochoid::parse("test", text, std::path::Path::new("."), &[]).unwrap_or_else(|error| panic!("{error}\n{text}"));
    let frames = [1, 5].into_iter().flat_map(|frame| {
        let plan = Plan::new(&loaded.graph, &[], frame, &[], &Settings::default()).unwrap();
        let frame = plan.evaluate(&Buffers::new(), &mut Cache::new(), &Silent).unwrap();
        frame.pictures.into_iter().flat_map(|picture| picture.planes)
    });
    frames.map(|plane| plane.samples().iter().map(|sample| sample.to_bits()).collect()).collect()
}

fn sheet(text: &str) -> Arc<Sheet> {
    Session::new(text.into(), None).sheet().clone()
}

fn names(sheet: &Sheet) -> Vec<String> {
    sheet.nodes.iter().map(|node| node.name.clone()).collect()
}

fn body(session: &Session, path: &Path) -> Value {
    session.sheet().get(path).cloned().unwrap_or_default()
}

#[test]
fn uses_look_like_nodes() {
    let sheet = sheet(LINKED);
    let keyed = sheet.node("keyed").unwrap();
    assert!(keyed.is_use);
    let pins: Vec<(&str, bool)> = keyed.pins.iter().map(|pin| (pin.label.as_str(), pin.required)).collect();
    assert_eq!(pins, [("under", true), ("shape", false), ("over", false)]);
    let makes = [("color", Some(Kind::Color)), ("spot", Some(Kind::MASK)), ("through", Some(Kind::Color))];
    assert_eq!(keyed.makes, makes);
    assert_eq!(sheet.node("pair").unwrap().makes[1], ("first", Some(Kind::MASK)));
    let wires = sheet.wires.iter().filter(|wire| sheet.nodes[wire.to.0].name == "last");
    let sources: Vec<String> = wires.map(|wire| sheet.reference(wire.from.0, wire.from.1)).collect();
    assert_eq!(sources, ["keyed", "keyed.through"]);
    let knob = |name: &str| {
        keyed.declaration.unwrap().items.iter().find_map(|item| match item {
            Item::Knob(knob) if knob.name == name => Some(*knob),
            _ => None,
        })
    };
    let x = knob("x").unwrap();
    assert_eq!((x.unit, x.help), ("heights", "Place across."));
    assert!(matches!(x.takes, KnobType::Number { min: 0.0, max: 2.0 }), "{:?}", x.takes);
    assert!(matches!(knob("ink").unwrap().takes, KnobType::Color));
    assert!(matches!(knob("form").unwrap().takes, KnobType::Choice(words) if words.contains(&"disc")));
    assert!(matches!(knob("size").unwrap().takes, KnobType::Number { min, .. } if min >= 0.0), "as a radius");
    // What is the same is made once.
    let again = sheet.node("pair").and_then(|pair| pair.declaration).unwrap();
    let other = Session::new(LINKED.replace("0.25", "0.5"), None);
    assert!(std::ptr::eq(again, other.sheet().node("pair").unwrap().declaration.unwrap()));
}

#[test]
fn any_nodes_can_be_grouped_and_unpacked_and_the_picture_stays() {
    let mut random = Pcg64Mcg::seed_from_u64(7);
    let whole = bits(LINKED);
    let (mut made, mut nested) = (0, 0);
    for round in 0..90 {
        let mut session = Session::new(LINKED.into(), None);
        for _ in 0..3 {
            let sheet = session.sheet().clone();
            let all = names(&sheet);
            let uses: Vec<&String> = all.iter().filter(|name| sheet.node(name).unwrap().is_use).collect();
            let (edit, before) = if random.random_bool(0.5) && !uses.is_empty() {
                let name = uses[random.random_range(0..uses.len())];
                nested += 1;
                (unpacked(&sheet, name).unwrap().0, session.text().to_string())
            } else {
                let chosen: BTreeSet<String> = all.iter().filter(|_| random.random_bool(0.4)).cloned().collect();
                let Ok((edit, name)) = grouped(&sheet, &chosen) else { continue };
                assert!(sheet.find(&name).is_none());
                made += 1;
                (edit, session.text().to_string())
            };
            let label = edit.label.clone();
            session.edit(edit).unwrap();
            session.seal();
            assert_eq!(bits(session.text()), whole, "round {round}: {label}\n{before}\n→\n{}", session.text());
            session.undo();
            assert_eq!(session.text(), before, "one step");
            session.redo();
        }
    }
    assert!(made > 20 && nested > 20, "{made} and {nested}");
}

#[test]
fn everything_is_unpacked_until_no_group_is_used() {
    let mut session = Session::new(LINKED.into(), None);
    let whole = bits(LINKED);
    while let Some(name) = names(session.sheet()).into_iter().find(|name| session.sheet().node(name).unwrap().is_use) {
        let (edit, made) = unpacked(session.sheet(), &name).unwrap();
        session.edit(edit).unwrap();
        assert!(made.iter().all(|name| session.sheet().find(name).is_some()), "{made:?}");
        assert_eq!(bits(session.text()), whole, "{}", session.text());
    }
    let is_used = |value: &Value| value.to_string().contains("\"Dot\"") || value.to_string().contains("\"Pair\"");
    assert!(!is_used(&session.sheet().value["nodes"]));
    // A keyed value in a formula has a name now.
    assert_eq!(session.sheet().value["knobs"]["keyed_x"], json!({ "value": { "keys": [[1, 0.2], [9, 1.2]] } }));
}

#[test]
fn a_group_has_what_comes_in_and_goes_out() {
    let mut session = Session::new(LINKED.into(), None);
    let chosen = ["soft", "sky"].map(String::from).into();
    let (edit, name) = grouped(session.sheet(), &chosen).unwrap();
    session.edit(edit).unwrap();
    let group = Path::default().to("groups").to("Group");
    assert_eq!(body(&session, &group.to("inputs")), json!({ "across": "Mask" }));
    assert_eq!(body(&session, &group.to("outputs")), json!({ "sky": "sky" }));
    assert_eq!(
        body(&session, &Path::node(&name)),
        json!({ "type": "Group", "across": "across", "wind": "= knobs.wind", "ink": "= knobs.ink" })
    );
    assert_eq!(body(&session, &Path::default().to("knobs").to("gap")), json!("= group.soft_min + 0.05"));
    assert_eq!(body(&session, &group.to("nodes").to("soft").to("min")), json!("= knobs.soft_min"));
    // What lies between must be selected, too.
    let sheet = sheet(LINKED);
    let why = grouped(&sheet, &["soft", "pair"].map(String::from).into()).unwrap_err().to_string();
    assert!(why.starts_with("sky lies between"), "{why}");
    assert!(grouped(&sheet, &BTreeSet::new()).unwrap_err().to_string().contains("select some nodes"));
    assert!(unpacked(&sheet, "sky").unwrap_err().to_string().contains("sky is not a use"));
}

#[test]
fn the_inside_of_a_use_is_edited_like_a_document() {
    let mut session = Session::new(LINKED.into(), None);
    let enter = |session: &Session, names: &[&str]| {
        let names: Vec<String> = names.iter().map(|name| (*name).into()).collect();
        group::enter(session.sheet(), &names, session.meaning().graph.as_deref()).unwrap()
    };
    let inside = enter(&session, &["pair", "two"]);
    let within = inside.within.clone().unwrap();
    assert_eq!((within.prefix().as_str(), within.group(), within.count), ("pair/two/", "Dot", 3));
    assert_eq!(
        names(&inside),
        ["under", "shape", "over", "spot", "cut", "lit", "outputs.color", "outputs.spot", "outputs.through"]
    );
    assert_eq!(inside.node("cut").unwrap().makes[0].1, Some(Kind::MASK));
    let ends = |inside: &Sheet| {
        let wires = inside.wires.iter().map(|wire| {
            let [from, to] = [wire.from.0, wire.to.0].map(|node| inside.nodes[node].called().to_string());
            format!("{from} {to}")
        });
        wires.collect::<Vec<String>>()
    };
    assert!(ends(&inside).contains(&"under lit".to_string()) && ends(&inside).contains(&"lit color".to_string()));
    let change = |session: &mut Session, edit: Edit| {
        let inside = enter(session, &["pair", "two"]);
        session.edit(inside.within.as_ref().unwrap().rebased(&inside.library, edit).unwrap()).unwrap();
        assert_eq!(session.meaning().errors().count(), 0, "{:?}\n{}", session.meaning().diagnostics, session.text());
        session.seal();
    };
    let dot = Path::default().to("groups").to("Dot");
    let spot = inside.find("spot").unwrap();
    change(&mut session, edit::connected(&inside, (spot, 0), (inside.find("outputs.spot").unwrap(), 0)));
    assert_eq!(body(&session, &dot.to("outputs").to("spot")), json!("spot"));
    change(&mut session, edit::moved(&[("cut".into(), [10.0, 20.0])]));
    assert_eq!(body(&session, &dot.to("ui").to("positions")), json!({ "cut": [10, 20] }));
    let renamed = edit::renamed(&enter(&session, &["pair", "two"]), "cut", "trimmed");
    change(&mut session, renamed);
    assert_eq!(body(&session, &dot.to("nodes").to("lit").to("weight")), json!("trimmed"));
    let form = Path::node("spot").to("shapes").to(0).to("form");
    let why = promoted(&enter(&session, &["keyed"]), &form, None).unwrap_err().to_string();
    assert!(why.contains("spot.form is a link already"), "{why}");
    assert!(promoted(session.sheet(), &form, None).unwrap_err().to_string().contains("enter a group"));
    for _ in 0..3 {
        session.undo();
    }
    assert_eq!(session.text(), LINKED);
}

#[test]
fn groups_are_made_and_unpacked_inside_of_groups() {
    let whole = bits(LINKED);
    let mut session = Session::new(LINKED.into(), None);
    let inside = |session: &Session, names: &[&str]| {
        let names: Vec<String> = names.iter().map(|name| (*name).into()).collect();
        group::enter(session.sheet(), &names, session.meaning().graph.as_deref()).unwrap()
    };
    let make = |session: &mut Session, sheet: &Sheet, edit: Edit| {
        session.edit(sheet.within.as_ref().unwrap().rebased(&sheet.library, edit).unwrap()).unwrap();
        assert_eq!(bits(session.text()), whole, "{}", session.text());
    };
    let pair = inside(&session, &["pair"]);
    for names in [&["one"][..], &["two"], &["one", "two"]] {
        let (edit, name) = grouped(&pair, &names.iter().map(|name| (*name).into()).collect()).unwrap();
        make(&mut session, &pair, edit);
        let made = inside(&session, &["pair"]);
        make(&mut session, &made, unpacked(&made, &name).unwrap().0);
        session.undo();
        session.undo();
        assert_eq!(session.text(), LINKED);
    }
    // What several uses have inside is taken apart in all of them.
    let pair = inside(&session, &["pair"]);
    make(&mut session, &pair, unpacked(&pair, "one").unwrap().0);
    let dot = inside(&session, &["keyed"]);
    let (edit, _) = grouped(&dot, &["spot", "cut"].map(String::from).into()).unwrap();
    make(&mut session, &dot, edit);
    let group = Path::default().to("groups").to("Group");
    assert_eq!(body(&session, &group.to("inputs")), json!({ "shape": "Mask" }));
    assert_eq!(
        body(&session, &Path::default().to("groups").to("Dot").to("nodes").to("group")),
        json!({
            "type": "Group", "shape": "shape",
            "form": "= knobs.form", "x": "= knobs.x", "half": "= knobs.half", "size": "= knobs.size"
        })
    );
}

#[test]
fn a_promoted_knob_is_the_default_of_all_uses() {
    let text = LINKED.replace("\"= knobs.form\"", "\"disc\"").replace("\"form\": \"disc\", ", "");
    assert_ne!(text, LINKED);
    let mut session = Session::new(text.clone(), None);
    let inside = group::enter(session.sheet(), &["keyed".into()], None).unwrap();
    let place = Path::node("spot").to("shapes").to(0).to("form");
    let items = inside.node("spot").unwrap().declaration.unwrap().items;
    let declared = group::declared_at(items, &place.0[2..]);
    let (edit, name) = promoted(&inside, &place, declared).unwrap();
    session.edit(inside.within.as_ref().unwrap().rebased(&inside.library, edit).unwrap()).unwrap();
    assert_eq!(name, "form");
    let dot = Path::default().to("groups").to("Dot");
    assert_eq!(body(&session, &dot.to("knobs").to("form").to("default")), json!("disc"));
    assert_eq!(body(&session, &dot.to("nodes").to("spot").to("shapes").to(0).to("form")), json!("= knobs.form"));
    assert_eq!(bits(session.text()), bits(&text));
    session.edit(renamed_knob(session.sheet(), "Dot", "size", "radius")).unwrap();
    assert_eq!(body(&session, &Path::node("keyed").to("radius")), json!(0.15));
    assert_eq!(body(&session, &dot.to("knobs").to("half")), json!("= knobs.radius / 2"));
    assert_eq!(bits(session.text()), bits(&text));
}

#[test]
fn groups_of_included_files_are_seen_copied_and_unpacked_with_their_paths() {
    let folder = tempfile::tempdir().unwrap();
    let at = |name: &str| folder.path().join(name);
    std::fs::create_dir_all(at("lib/more")).unwrap();
    let lib = r##"{ "trochoid": 1, "include": ["more/dots.json"], "groups": { "Plate": {
      "inputs": { "over": "Mask" }, "knobs": { "file": "plate.png", "tint": "#fff" },
      "nodes": { "read": { "type": "Read", "as": "color", "file": "= knobs.file" },
                 "own": { "type": "Read", "as": "color", "file": "plate.png" },
                 "both": { "type": "Mix", "a": "read", "b": "own", "weight": "over" } },
      "outputs": { "color": "both" } } } }"##;
    let dots = r##"{ "trochoid": 1, "groups": { "Half": { "inputs": {}, "nodes": { "x": { "type": "ScreenX" } }, "outputs": { "x": "x" } } } }"##;
    std::fs::write(at("lib/lib.json"), lib).unwrap();
    std::fs::write(at("lib/more/dots.json"), dots).unwrap();
    let text = r##"{ "trochoid": 1, "format": { "width": 4, "height": 2 }, "include": ["lib/lib.json"],
      "nodes": { "half": { "type": "Half" }, "plate": { "type": "Plate", "over": "half", "file": "lib/plate.png" } },
      "outputs": { "beauty": { "color": "plate" } } }"##;
    std::fs::write(at("scene.json"), text).unwrap();
    let picture = image::RgbImage::from_fn(4, 2, |x, y| image::Rgb([60 * x as u8, 99 * y as u8, 7]));
    picture.save(at("lib/plate.png")).unwrap();
    let mut session = Session::open(&at("scene.json")).unwrap();
    assert_eq!(session.meaning().errors().count(), 0, "{:?}", session.meaning().diagnostics);
    let plate = session.sheet().node("plate").unwrap();
    assert_eq!(plate.makes, [("color", Some(Kind::Color))]);
    assert_eq!(session.sheet().node("half").unwrap().makes, [("x", Some(Kind::MASK))]);
    let inside = group::enter(session.sheet(), &["plate".into()], None).unwrap();
    let within = inside.within.clone().unwrap();
    assert_eq!(within.file.as_deref(), Some("lib/lib.json"));
    let refused = within.rebased(&inside.library, edit::moved(&[("own".into(), [0.0, 0.0])]));
    assert!(refused.unwrap_err().to_string().contains("belongs to lib/lib.json"));
    let sheet = session.sheet().clone();
    let (unpack, _) = unpacked(&sheet, "plate").unwrap();
    session.edit(unpack).unwrap();
    let files = [Path::node("read").to("file"), Path::node("own").to("file")].map(|path| body(&session, &path));
    assert_eq!(files, [json!("lib/plate.png"), json!("lib/plate.png")]);
    assert_eq!(session.meaning().errors().count(), 0, "{:?}", session.meaning().diagnostics);
    session.undo();
    let (edit, copy) = made_local(session.sheet(), "Plate").unwrap();
    session.edit(edit).unwrap();
    assert_eq!(session.meaning().errors().count(), 0, "{:?}", session.meaning().diagnostics);
    assert_eq!(copy, "Plate2");
    let own = Path::default().to("groups").to("Plate2");
    assert_eq!(body(&session, &own.to("knobs").to("file")), json!("lib/plate.png"));
    assert_eq!(body(&session, &own.to("nodes").to("own").to("file")), json!("lib/plate.png"));
    assert_eq!(body(&session, &Path::node("plate").to("type")), json!("Plate2"));
    assert!(made_local(session.sheet(), "Plate2").unwrap_err().to_string().contains("already"));
    // Saved elsewhere, all paths lead to the same files.
    std::fs::create_dir(at("other")).unwrap();
    session.save(&at("other/scene.json")).unwrap();
    assert_eq!(session.sheet().value["include"], json!(["../lib/lib.json"]));
    assert_eq!(body(&session, &own.to("nodes").to("own").to("file")), json!("../lib/plate.png"));
    assert_eq!(body(&session, &own.to("knobs").to("file")), json!("../lib/plate.png"));
    assert!(is_link(body(&session, &own.to("nodes").to("read").to("file")).as_str().unwrap()));
}
