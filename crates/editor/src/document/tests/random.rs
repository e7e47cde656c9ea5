use super::{SMALL, small};
use crate::document::edit;
use crate::document::history::{Change, History};
use crate::document::json::Splice;
use crate::document::{Edit, Path, Session};
use rand::seq::IndexedRandom;
use rand::{RngExt, SeedableRng};
use rand_pcg::Pcg64Mcg;
use serde_json::json;
use trochoid::registry;

/// Returns a random command, as a user could give it.
fn any(session: &Session, random: &mut Pcg64Mcg) -> Option<Edit> {
    let sheet = session.sheet();
    let types: Vec<&str> = registry().names().collect();
    let name = sheet.nodes.choose(random).map(|node| node.name.clone());
    let some = |random: &mut Pcg64Mcg| -> Vec<String> {
        sheet.nodes.iter().filter(|_| random.random_bool(0.2)).map(|node| node.name.clone()).collect()
    };
    let point = |random: &mut Pcg64Mcg| [random.random_range(-900.0..900.0), random.random_range(-900.0..900.0)];
    Some(match random.random_range(0..14) {
        0 | 1 if sheet.nodes.len() < 40 => {
            let declaration = registry().get(types.choose(random)?)?.declaration();
            edit::added(sheet, declaration, point(random)).0
        }
        2 => edit::deleted(sheet, &some(random).into_iter().take(3).collect::<Vec<_>>()),
        3 | 4 => {
            let (from, to) =
                (random.random_range(0..sheet.nodes.len().max(1)), random.random_range(0..sheet.nodes.len().max(1)));
            let pins = sheet.nodes.get(to)?.pins.len();
            let output = sheet.nodes[from].makes.len();
            if pins == 0 || output == 0 {
                return None;
            }
            edit::connected(sheet, (from, random.random_range(0..output)), (to, random.random_range(0..pins)))
        }
        5 => {
            let wire = sheet.wires.choose(random)?;
            edit::disconnected(sheet, wire.to)
        }
        6 => {
            let places: Vec<_> = some(random).into_iter().map(|name| (name, point(random))).collect();
            edit::moved(&places).merging("drag")
        }
        7 => edit::renamed(sheet, &name?, &sheet.free_name("näme".trim_matches('ä'))),
        8 => edit::disabled(sheet, &some(random)),
        9 => edit::pasted(sheet, &edit::copied(sheet, &some(random)), point(random))?.0,
        10 => edit::retyped(sheet, &name?, registry().get(types.choose(random)?)?.declaration()),
        11 => Edit::set(Path::node(&name?).to("notes"), &json!(format!("„{}“\n", random.random::<u16>())))
            .merging("notes"),
        12 => edit::extracted(sheet, &some(random)),
        _ => edit::laid_out(
            sheet,
            &sheet.nodes.iter().map(|node| (node.name.clone(), point(random))).collect::<Vec<_>>(),
        ),
    })
}

#[test]
fn random_commands_are_undone_and_redone_byte_by_byte() {
    undone_and_redone(600);
}

#[test]
#[ignore = "takes half a minute; run with --ignored ten_thousand"]
fn ten_thousand_random_commands_are_undone_and_redone_byte_by_byte() {
    undone_and_redone(10_000);
}

/// What the history of a session should be, by whole texts.
struct Expected {
    /// The text before the first step, and after each one.
    texts: Vec<String>,
    /// Number of steps that are done.
    done: usize,
    /// The key of the newest step, while it still merges with others of this key.
    open: Option<String>,
}

impl Expected {
    /// Records a command that changed the text. No random command takes back the one that it merges with, which would
    /// leave no step.
    fn push(&mut self, text: &str, merge: Option<String>) {
        let merges = merge.is_some() && merge == self.open;
        // What was undone is lost.
        self.texts.truncate(self.done + usize::from(!merges));
        self.texts.push(text.into());
        self.done = self.texts.len() - 1;
        self.open = merge;
    }

    /// Undoes some steps, or redoes some if the number is negative, and compares the text after each; returns whether
    /// there were as many.
    fn walk(&mut self, session: &mut Session, steps: i32) -> bool {
        self.open = None;
        for _ in 0..steps.unsigned_abs() {
            let (next, label) = match steps > 0 {
                true => (self.done.checked_sub(1), session.undo()),
                false => (Some(self.done + 1).filter(|next| *next < self.texts.len()), session.redo()),
            };
            assert_eq!(next.is_some(), label.is_some(), "at step {} of {}", self.done, self.texts.len() - 1);
            let Some(next) = next else { return false };
            self.done = next;
            assert!(session.text() == self.texts[next], "{label:?} leads to step {next}: {}", session.text());
        }
        true
    }
}

fn undone_and_redone(count: usize) {
    let mut random = Pcg64Mcg::seed_from_u64(7);
    let mut session = small();
    let mut expected = Expected { texts: vec![SMALL.into()], done: 0, open: None };
    let (mut tried, mut made) = (0, 0);
    while tried < count {
        // A document that has grown large is replaced, so that commands act on graphs as users make them.
        if session.sheet().nodes.len() > 60 {
            session.replace(SMALL, "Start again");
            expected.push(session.text(), None);
        }
        let Some(edit) = any(&session, &mut random) else { continue };
        tried += 1;
        let before = session.text().to_string();
        let merge = edit.merge.clone();
        if session.edit(edit).is_err() {
            assert_eq!(session.text(), before, "a refused command changes nothing");
            continue;
        }
        made += 1;
        let _: serde_json::Value = serde_json::from_str(session.text()).unwrap();
        if session.text() != before {
            expected.push(session.text(), merge);
        }
        if random.random_bool(0.3) {
            session.seal();
            expected.open = None;
        }
        if random.random_bool(0.03) {
            expected.walk(&mut session, random.random_range(1..6));
            expected.walk(&mut session, -random.random_range(1..6));
        }
    }
    assert!(made > count / 2, "most commands can be made");
    while expected.walk(&mut session, 1) {}
    assert_eq!(session.text(), SMALL);
    while expected.walk(&mut session, -1) {}
    assert!(expected.texts.len() > count / 4, "most commands are a step of their own");
}

#[test]
fn memory_for_undo_is_bounded_and_the_newest_stays() {
    let mut history = History::with_limit(10_000);
    let mut text = String::new();
    for index in 0..200 {
        let splice = Splice { at: text.len(), removed: String::new(), inserted: format!("{index:0>200}") };
        splice.redo(&mut text);
        history.push(Change { label: index.to_string(), merge: None, splices: vec![splice] });
    }
    let whole = text.clone();
    let mut undone = 0;
    while history.undo(&mut text).is_some() {
        undone += 1;
    }
    assert!((10..50).contains(&undone), "{undone}");
    while history.redo(&mut text).is_some() {}
    assert_eq!(text, whole);
}

#[test]
fn saved_is_a_place_in_the_history() {
    let mut session = small();
    assert!(!session.is_changed());
    session.edit(edit::moved(&[("sky".into(), [1.0, 2.0])])).unwrap();
    assert!(session.is_changed());
    session.undo();
    assert!(!session.is_changed(), "back at what was opened");
    session.redo();
    let folder = tempfile::tempdir().unwrap();
    let file = folder.path().join("a.json");
    session.save(&file).unwrap();
    assert!(!session.is_changed());
    assert_eq!(std::fs::read_to_string(&file).unwrap(), session.text());
    session.undo();
    assert!(session.is_changed());
    session.edit(edit::moved(&[("sky".into(), [3.0, 4.0])])).unwrap();
    session.undo();
    assert!(session.is_changed(), "what was saved cannot be reached any more");
    std::fs::write(&file, "{}").unwrap();
    assert_eq!(session.differs_on_disk(), Some(true));
    session.reload().unwrap();
    assert_eq!(session.text(), "{}");
    assert!(!session.is_changed());
    session.undo();
    assert_eq!(session.text(), SMALL);
}
