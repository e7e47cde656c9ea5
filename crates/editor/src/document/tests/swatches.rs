use super::small;
use crate::document::swatches::{Swatch, SwatchKey};
use crate::document::{Edit, Session, palette, palette_file, swatches, swatches::swatches};
use crate::state::State;
use rand::{RngExt as _, SeedableRng};
use rand_pcg::Pcg64Mcg;
use std::path::{Path, PathBuf};
use trochoid::{Kind, PackedRecipe, Severity};

fn all(session: &Session) -> Vec<Swatch> {
    swatches(session.sheet(), session.meaning().graph.as_deref(), 1)
}

fn called(session: &Session) -> Vec<String> {
    all(session).iter().map(Swatch::called).collect()
}

/// Returns every scene.
fn scenes() -> Vec<PathBuf> {
    let folder = Path::new(env!("CARGO_MANIFEST_DIR")).join("../../graphs");
    let files = std::fs::read_dir(folder).unwrap().map(|entry| entry.unwrap().path());
    let mut files: Vec<PathBuf> = files.filter(|path| path.extension().is_some_and(|end| end == "json")).collect();
    files.sort();
    assert!(!files.is_empty());
    files
}

fn errors(session: &Session) -> Vec<String> {
    session.meaning().errors().map(ToString::to_string).collect()
}

#[test]
fn colors_are_found_wherever_they_are_written() {
    let text = r##"{
      "trochoid": 1, "format": { "width": 8, "height": 4 }, "working_space": "srgb",
      "palette": { "ink": "#000", "glow": { "keys": [[1, "#ff0000"], [3, "#0000ff"]] } },
      "nodes": {
        "across": { "type": "ScreenX" },
        "one": { "type": "Constant", "color": "#ABCDEF" },
        "mix": { "type": "Mix", "a": "palette.ink", "b": "#abcdef", "weight": "across" },
        "all": { "type": "Blend", "colors": ["one", "mix", [0.25, 0.5, 0.75], "palette.glow"], "weights": [0.25, 0.25, 0.25, 0.25] },
        "late": { "type": "Mix", "a": "all", "b": { "keys": [[1, "#102030"], [2, "#203040"]] }, "weight": 0.5 }
      },
      "outputs": { "beauty": { "color": "late" } }
    }"##;
    let session = Session::new(text.into(), None);
    assert_eq!(errors(&session), Vec::<String>::new());
    assert_eq!(called(&session), ["ink", "glow", "#abcdef", "#4080bf", "#102030"]);
    let uses: Vec<Vec<String>> =
        all(&session).iter().map(|swatch| swatch.uses.iter().map(ToString::to_string).collect()).collect();
    assert_eq!(uses[1], ["nodes.all.colors[3]"]);
    assert_eq!(uses[2], ["nodes.one.color", "nodes.mix.b"], "equal colors are one, however they are written");
    assert_eq!(uses[3], ["nodes.all.colors[2]"]);
    let later = swatches(session.sheet(), None, 2);
    assert_eq!(later[4].called(), "#203040");
    assert_eq!(later[1].color, Some([0.5, 0.0, 0.5]));
}

/// A document that uses one of its colors at its top, in a group, and in a group of that group.
const GROUPED: &str = r##"{
  "trochoid": 1, "format": { "width": 8, "height": 4 },
  "palette": { "ink": "#000000", "red": "#ff0000" },
  "knobs": { "ground": { "value": "palette.ink", "help": "Below all." } },
  "groups": {
    "Inner": {
      "inputs": { "under": "Color" },
      "knobs": { "tint": "palette.ink" },
      "nodes": { "wash": { "type": "Mix", "a": "under", "b": "= knobs.tint", "weight": 0.5 } },
      "outputs": { "color": "wash" }
    },
    "Outer": {
      "inputs": {},
      "nodes": {
        "base": { "type": "Constant", "color": { "keys": [[1, "palette.ink"], [3, "#ffffff"]] } },
        "inner": { "type": "Inner", "under": "base" }
      },
      "outputs": { "color": "inner" }
    }
  },
  "nodes": {
    "one": { "type": "Outer" },
    "two": { "type": "Inner", "under": "palette.ink" },
    "all": { "type": "Mix", "a": "one", "b": "two", "weight": 0.5 }
  },
  "outputs": { "beauty": { "color": "all" } }
}"##;

/// Renaming and merging reach every use, whichever group is entered.
#[test]
fn uses_in_groups_follow_their_color() {
    for scope in [vec![], vec!["one"], vec!["one", "inner"], vec!["two"]] {
        let mut state = State::new(Session::new(GROUPED.into(), None), crate::evaluate::Graphics::default());
        assert_eq!(errors(&state.session), Vec::<String>::new());
        state.scope = scope.iter().map(ToString::to_string).collect();
        state.read_insides();
        assert_eq!(state.scope.len(), scope.len());
        let ink = |state: &State| state.swatches().into_iter().find(|own| own.called() == "ink");
        let swatch = ink(&state).unwrap();
        assert_eq!(swatch.count(), 4, "{scope:?}");
        let edit = state.in_document(palette::renamed(&swatch, "coal")).unwrap();
        let (renamed, merged) = (edit, state.in_document(palette::merged(&swatch, "red")).unwrap());
        state.session.edit(renamed).unwrap();
        assert_eq!(state.session.text(), GROUPED.replace("ink", "coal"), "{scope:?}");
        state.session.undo();
        assert_eq!(state.session.text(), GROUPED);
        state.session.edit(merged).unwrap();
        let expected = GROUPED.replace("\"ink\": \"#000000\", ", "").replace("palette.ink", "palette.red");
        assert_eq!(state.session.text(), expected, "{scope:?}");
        assert_eq!(errors(&state.session), Vec::<String>::new());
    }
}

#[test]
fn a_color_that_included_groups_use_keeps_its_name() {
    let folder = tempfile::tempdir().unwrap();
    std::fs::write(folder.path().join("lib.json"), GROUPED).unwrap();
    let text = r##"{
      "trochoid": 1, "format": { "width": 8, "height": 4 }, "include": ["lib.json"],
      "palette": { "ink": "#000000", "red": "#ff0000" },
      "nodes": { "one": { "type": "Outer" } },
      "outputs": { "beauty": { "color": "one" } }
    }"##;
    std::fs::write(folder.path().join("scene.json"), text).unwrap();
    let state =
        State::new(Session::open(&folder.path().join("scene.json")).unwrap(), crate::evaluate::Graphics::default());
    assert_eq!(errors(&state.session), Vec::<String>::new());
    let all = state.swatches();
    assert_eq!(all.iter().map(Swatch::count).collect::<Vec<_>>(), [2, 0]);
    assert_eq!(all[0].around(), ["lib.json"]);
    let why = palette::given_up(&all[0]).unwrap_err().to_string();
    assert!(why.contains("\"ink\" to stay, because groups of lib.json use it"), "{why}");
    assert_eq!(palette::given_up(&all[1]), Ok(()));
}

#[test]
fn names_come_from_places() {
    let session = small();
    let edit = palette::named_all(session.sheet(), &all(&session)).unwrap();
    let mut session = session;
    session.edit(edit).unwrap();
    assert_eq!(called(&session), ["sky_stops_0", "sky_stops_1", "sea_a"]);
    assert_eq!(palette::named_all(session.sheet(), &all(&session)), None, "all have names");
}

#[test]
fn recipes_know_the_colors_of_every_scene_by_the_names_that_the_palette_has_for_them() {
    for file in scenes() {
        let mut session = Session::open(&file).unwrap();
        let text = session.text().to_string();
        for is_named in [false, true] {
            if is_named {
                let Some(edit) = palette::named_all(session.sheet(), &all(&session)) else { break };
                session.edit(edit).unwrap();
            }
            assert_eq!(errors(&session), Vec::<String>::new(), "{}", file.display());
            let known: Vec<String> = all(&session).iter().flat_map(Swatch::controls).collect();
            let graph = session.meaning().graph.clone().unwrap();
            for (index, output) in graph.outputs().iter().enumerate().filter(|(_, spec)| spec.kind == Kind::Color) {
                let info = PackedRecipe::describe(&graph, index, 1);
                let info = info.unwrap_or_else(|error| panic!("{}, {}: {error}", file.display(), output.name));
                for (name, color) in info.names.iter().zip(&info.colors) {
                    assert!(known.contains(name), "{}: {name}", file.display());
                    let own = all(&session).into_iter().find(|swatch| swatch.controls().contains(name)).unwrap();
                    if let Some(value) = own.value {
                        let found = swatches::working(&value, graph.space(), 1.0).unwrap();
                        let off = found.iter().zip(color).map(|(a, b)| (a - b).abs()).fold(0.0, f64::max);
                        assert!(off < 1e-9, "{}: {name} is {found:?} and not {color:?}", file.display());
                    }
                }
            }
        }
        while session.undo().is_some() {}
        assert!(session.text() == text, "{}", file.display());
    }
}

#[test]
fn names_that_are_taken_or_illegal_are_refused() {
    let mut session = small();
    session.edit(palette::named(session.sheet(), &all(&session)[0], "night")).unwrap();
    let all = all(&session);
    for (name, words) in [
        ("night", "another name"),
        ("", "a name of"),
        ("7th", "a name of"),
        ("deep blue", "a name of"),
        ("palette.x", "a name of"),
    ] {
        let why = palette::free(name, &all).unwrap_err().to_string();
        assert!(why.starts_with(words), "{name}: {why}");
    }
    assert_eq!(palette::free(" day ", &all).unwrap(), "day");
    let unknown = [("nihgt".to_string(), "#000000".into())];
    let why = palette::replaced(session.sheet(), &all, &unknown).unwrap_err().to_string();
    assert!(why.contains("it has no nihgt") && why.contains("did you mean night?"), "{why}");
}

/// Returns a random change to the palette.
fn change(session: &Session, random: &mut Pcg64Mcg) -> Option<Edit> {
    let all = all(session);
    let swatch = all.get(random.random_range(0..all.len().max(1)))?.clone();
    let names: Vec<&str> = palette::names(&all).collect();
    let color = [0.0; 3].map(|_: f32| random.random_range(0.0..1.0_f32));
    let is_named = matches!(swatch.key, SwatchKey::Named(_));
    match random.random_range(0..7) {
        0 => palette::colored(session.sheet(), &swatch, color, random.random_range(-2..6)).ok(),
        1 => Some(palette::added(session.sheet(), color, &all).0),
        2 => palette::named_all(session.sheet(), &all),
        3 if is_named => {
            Some(palette::renamed(&swatch, &palette::free(&format!("n{}", random.random_range(0..50)), &all).ok()?))
        }
        3 => Some(palette::named(session.sheet(), &swatch, &palette::free("fresh", &all).ok()?)),
        4 => {
            let into = names.get(random.random_range(0..names.len().max(1)))?;
            (*into != swatch.called()).then(|| palette::merged(&swatch, into))
        }
        5 if is_named && swatch.uses.is_empty() => Some(palette::removed(&swatch.called())),
        _ => {
            let other: Vec<(String, serde_json::Value)> =
                names.iter().take(2).map(|name| ((*name).to_string(), "#123456".into())).collect();
            palette::replaced(session.sheet(), &all, &other).ok().map(|(edit, _)| edit)
        }
    }
}

#[test]
fn changes_in_any_order_leave_a_valid_document_and_are_undone_byte_by_byte() {
    let mut random = Pcg64Mcg::seed_from_u64(7);
    for round in 0..12 {
        let mut session = small();
        let text = session.text().to_string();
        let mut steps = 0;
        for _ in 0..40 {
            if let Some(edit) = change(&session, &mut random) {
                let label = edit.label.clone();
                let before = session.text().to_string();
                session.edit(edit).unwrap();
                session.seal();
                steps += usize::from(session.text() != before);
                assert_eq!(errors(&session), Vec::<String>::new(), "{round}: {label}");
            }
        }
        assert!(steps > 10, "{steps} changes");
        for _ in 0..steps {
            assert!(session.undo().is_some());
        }
        assert!(session.undo().is_none(), "each change is one step");
        assert_eq!(session.text(), text);
    }
}

#[test]
fn saved_palettes_are_read_as_they_were() {
    let folder = tempfile::tempdir().unwrap();
    for file in scenes() {
        let mut session = Session::open(&file).unwrap();
        if let Some(edit) = palette::named_all(session.sheet(), &all(&session)) {
            session.edit(edit).unwrap();
        }
        let space = swatches::space(session.sheet());
        let path = folder.path().join("palette.json");
        std::fs::write(&path, palette_file::text(&path, &all(&session), space)).unwrap();
        let back = palette_file::read(&path, space, &trochoid::Access::everything()).unwrap();
        let (edit, strange) = palette::replaced(session.sheet(), &all(&session), &back).unwrap();
        assert_eq!(strange, None);
        assert!(edit.ops.is_empty(), "{}: {:?}", file.display(), edit.ops);
        let warnings = session.meaning().diagnostics.iter().filter(|one| one.severity == Severity::Error).count();
        assert_eq!(warnings, 0);
    }
}
