use super::small;
use crate::document::Session;
use crate::document::keep::{Keeper, discard, kept};
use std::io::{BufRead, BufReader, Write};
use std::path::{Path, PathBuf};
use std::process::{Command, Stdio};
use std::time::{Duration, Instant};

fn wait_for(what: impl Fn() -> bool) {
    let started = Instant::now();
    while !what() {
        assert!(started.elapsed() < Duration::from_secs(20), "the condition did not hold in time");
        std::thread::sleep(Duration::from_millis(5));
    }
}

/// Creates a file that was last written so many seconds ago.
fn old(path: &Path, seconds: u64) {
    let file = std::fs::File::create(path).unwrap();
    file.set_modified(std::time::SystemTime::now() - Duration::from_secs(seconds)).unwrap();
}

#[test]
fn locks_of_editors_that_have_ended_are_removed() {
    let folder = tempfile::tempdir().unwrap();
    let at = |name: &str| folder.path().join(name);
    old(&at("1-0.lock"), 3600);
    old(&at("2-0.lock"), 0);
    old(&at("3-0.lock"), 3600);
    std::fs::write(at("3-0.json"), "{}").unwrap();
    old(&at("4-0.lock"), 3600);
    let held = std::fs::File::open(at("4-0.lock")).unwrap();
    held.try_lock().unwrap();
    let keeper = Keeper::new(folder.path()).unwrap();
    assert!(!at("1-0.lock").exists());
    for (name, why) in [("2-0.lock", "may be taken yet"), ("3-0.lock", "has a copy"), ("4-0.lock", "is held")] {
        assert!(at(name).exists(), "{name} {why}");
    }
    drop(keeper);
    assert_eq!(std::fs::read_dir(folder.path()).unwrap().count(), 4);
}

fn copies(folder: &Path) -> usize {
    let entries = std::fs::read_dir(folder).unwrap().flatten();
    entries.filter(|entry| entry.path().extension().is_some_and(|end| end == "json")).count()
}

#[test]
fn a_running_editor_keeps_its_copy_to_itself() {
    let folder = tempfile::tempdir().unwrap();
    let keeper = Keeper::new(folder.path()).unwrap();
    let other = Keeper::new(folder.path()).unwrap();
    keeper.keep(Some(Path::new("a.json")), "text");
    wait_for(|| copies(folder.path()) == 1);
    assert_eq!(kept(folder.path()), [], "it is locked");
    drop(other);
    keeper.forget();
    wait_for(|| copies(folder.path()) == 0);
    keeper.keep(None, "more");
    wait_for(|| copies(folder.path()) == 1);
    drop(keeper);
    assert_eq!(copies(folder.path()), 0, "a window that closes leaves nothing");
}

#[test]
fn the_copy_of_an_editor_that_ended_is_found_once() {
    let folder = tempfile::tempdir().unwrap();
    std::fs::write(folder.path().join("9-0.json"), r#"{ "file": "/x/storm.json", "text": "{ }" }"#).unwrap();
    std::fs::write(folder.path().join("9-0.lock"), "").unwrap();
    std::fs::write(folder.path().join("8-0.json"), "damaged").unwrap();
    let found = kept(folder.path());
    assert_eq!(found.len(), 1, "what is damaged is no work");
    assert_eq!(found[0].file, Some(PathBuf::from("/x/storm.json")));
    assert_eq!(found[0].text, "{ }");
    discard(&found[0]);
    assert_eq!(kept(folder.path()), []);
}

#[test]
fn the_copy_of_an_editor_with_the_same_process_id_is_not_overwritten() {
    let folder = tempfile::tempdir().unwrap();
    let name = format!("{}-0", std::process::id());
    let [copy, lock] = ["json", "lock"].map(|end| folder.path().join(format!("{name}.{end}")));
    std::fs::write(&copy, r#"{ "text": "lost" }"#).unwrap();
    std::fs::write(&lock, "").unwrap();
    let keeper = Keeper::new(folder.path()).unwrap();
    assert_eq!(kept(folder.path())[0].text, "lost", "its lock is free");
    keeper.keep(None, "other");
    wait_for(|| copies(folder.path()) == 2);
    drop(keeper);
    assert_eq!(kept(folder.path())[0].text, "lost");
}

#[test]
fn a_copy_knows_its_document_from_wherever_the_editor_is_started() {
    let session = Session::new("{}".into(), Some("storm.json".into()));
    let whole = std::env::current_dir().unwrap().join("storm.json");
    assert_eq!(session.file(), Some(whole.as_path()));
    assert_eq!(Some(session.folder().as_path()), whole.parent());
    // A relative path is ignored, because it may name another document in another folder.
    let folder = tempfile::tempdir().unwrap();
    std::fs::write(folder.path().join("9-0.json"), r#"{ "file": "storm.json", "text": "{ }" }"#).unwrap();
    assert_eq!(kept(folder.path())[0].file, None);
}

#[cfg(unix)]
#[test]
fn work_on_a_file_whose_name_is_no_unicode_is_kept() {
    use std::os::unix::ffi::OsStrExt;
    let folder = tempfile::tempdir().unwrap();
    let keeper = Keeper::new(folder.path()).unwrap();
    keeper.keep(Some(Path::new(std::ffi::OsStr::from_bytes(b"/x/\xff.json"))), "text");
    wait_for(|| copies(folder.path()) == 1);
}

/// The process that the test below starts and kills: it edits, and prints the number of each edit.
#[test]
#[ignore = "is killed by the test that starts it"]
fn victim() {
    let Some(folder) = std::env::var_os("TROCHOID_TEST_FOLDER") else { return };
    let context = egui::Context::default();
    let mut editor = crate::editor::Editor::new(&context, small(), Some(Path::new(&folder))).unwrap();
    let mut number = 0;
    loop {
        let edit = crate::document::edit::moved(&[("sky".into(), [number as f32, 0.0])]);
        editor.act(crate::actions::Action::Edit(edit), &context);
        println!("did {number}");
        std::io::stdout().flush().unwrap();
        number += 1;
        // Draws frames, as a window does.
        for _ in 0..4 {
            let mut output = context.run_ui(egui::RawInput::default(), |ui| editor.ui(ui));
            output.textures_delta.clear();
            std::thread::sleep(Duration::from_millis(10));
        }
    }
}

/// Kills a running editor at random moments; no edit older than 2 s may be lost.
#[test]
#[ignore = "takes two minutes; run with --ignored killed"]
fn killed_at_fifty_random_moments_nothing_old_is_lost() {
    let mut worst = Duration::ZERO;
    for round in 0..50_u64 {
        let folder = tempfile::tempdir().unwrap();
        let mut child = Command::new(std::env::current_exe().unwrap())
            .args(["--exact", "document::tests::kept::victim", "--ignored", "--nocapture", "--test-threads", "1"])
            .env("TROCHOID_TEST_FOLDER", folder.path())
            .stdout(Stdio::piped())
            .spawn()
            .unwrap();
        let lines = BufReader::new(child.stdout.take().unwrap()).lines();
        let times = std::sync::Arc::new(std::sync::Mutex::new(Vec::new()));
        let theirs = times.clone();
        let reader = std::thread::spawn(move || {
            for line in lines.map_while(Result::ok) {
                if let Some(number) = line.rsplit("did ").next().and_then(|number| number.trim().parse::<u64>().ok()) {
                    theirs.lock().unwrap().push((number, Instant::now()));
                }
            }
        });
        wait_for(|| !times.lock().unwrap().is_empty());
        std::thread::sleep(Duration::from_millis(1000 + round * 7919 % 1500));
        let died = Instant::now();
        child.kill().unwrap();
        child.wait().unwrap();
        reader.join().unwrap();
        let found = kept(&folder.path().join("unsaved"));
        let last = found.first().and_then(|kept| {
            let value: serde_json::Value = serde_json::from_str(&kept.text).ok()?;
            value["ui"]["positions"]["sky"][0].as_u64()
        });
        let times = times.lock().unwrap();
        // The first edit that is not in the copy.
        let lost = times.iter().find(|(number, _)| last.is_none_or(|last| *number > last));
        let age = lost.map_or(Duration::ZERO, |(_, when)| died.saturating_duration_since(*when));
        assert!(age < Duration::from_secs(2), "round {round}: an edit {age:?} old was lost");
        worst = worst.max(age);
    }
    println!("the oldest edit that was lost was {:.2} s old", worst.as_secs_f64());
}
