//! Commands within another program, compared with the program itself.

use crate::scene::{SCENE, Scene, with_unused};
use std::fs;
use std::sync::atomic::{AtomicBool, AtomicU64, Ordering};
use std::sync::{Arc, Mutex};
use trochoid_cli::{Host, Outcome, run};

/// Remembers what it is told, and asks to stop from some step on.
#[derive(Default)]
struct Watcher {
    told: Mutex<Vec<(u64, u64)>>,
    stop_from: Option<u64>,
    asks_to_stop: AtomicBool,
    polls: AtomicU64,
}

impl Host for Watcher {
    fn progress(&self, done: u64, total: u64) {
        self.told.lock().unwrap().push((done, total));
        if self.stop_from.is_some_and(|step| done >= step) {
            self.asks_to_stop.store(true, Ordering::Relaxed);
        }
    }

    fn cancelled(&self) -> bool {
        self.polls.fetch_add(1, Ordering::Relaxed);
        self.asks_to_stop.load(Ordering::Relaxed)
    }
}

fn hosted(arguments: &[&str]) -> Outcome {
    run(arguments, Arc::new(Watcher::default()))
}

/// A document whose every frame takes a while.
fn slow() -> Scene {
    let nodes = (0..3).map(|number: usize| {
        let from = number.checked_sub(1).map_or("n".into(), |before| format!("b{before}"));
        format!(r#""b{number}": {{ "type": "Blur", "image": "{from}", "size": 30 }}"#)
    });
    let nodes = nodes.collect::<Vec<_>>().join(", ");
    Scene::new(&format!(
        r#"{{ "trochoid": 1, "format": {{ "width": 1000, "height": 1000 }}, "frames": {{ "first": 1, "last": 9 }},
             "nodes": {{ "n": {{ "type": "Noise" }}, {nodes} }},
             "outputs": {{ "b": {{ "field": "b2", "file": "b.####.exr" }} }} }}"#
    ))
}

#[test]
fn a_host_gets_what_the_program_prints() {
    let scene = Scene::new(&with_unused());
    let (graph, absent) = (scene.path("a.json"), scene.path("absent.json"));
    let (graph, absent) = (graph.to_str().unwrap(), absent.to_str().unwrap());
    let long = format!("{}/nowhere", scene.path("").display());
    for arguments in [
        // The memory that is free differs from run to run.
        &["check", graph, "--memory", "1GB"][..],
        &["check", graph, "--json", "--memory", "1GB"],
        &["check", graph, "--strict", "--memory", "1GB"],
        &["check", absent],
        &["nodes", "Mix"],
        &["schema"],
        &["render", graph, "--output", "lost"],
        &["render", graph, "--frames", "x"],
        &["info", graph],
        &["check", graph, "--memory", "1GB", "--allow", &long],
        &["--version"],
        &["rendre"],
        &["check"],
    ] {
        // The second run of a host knows nothing of the first.
        for _ in 0..2 {
            let (own, program) = (hosted(arguments), scene.run(arguments));
            assert_eq!(i32::from(own.code), program.code, "{arguments:?}");
            assert_eq!(own.text, program.out, "{arguments:?}");
            assert_eq!(own.messages.join("\n").trim_end(), program.err.trim_end(), "{arguments:?}");
        }
    }
}

#[test]
fn a_host_is_told_of_progress_and_files_are_those_of_the_program() {
    let (own, other) = (Scene::new(SCENE), Scene::new(SCENE));
    let watcher = Arc::new(Watcher::default());
    let outcome = run(["render", own.path("a.json").to_str().unwrap()], watcher.clone());
    assert_eq!((outcome.code, &outcome.messages[..]), (0, &[][..]));
    other.run(&["render", "a.json"]).code(0);
    assert_eq!(own.files(), other.files());
    for name in own.files() {
        assert_eq!(fs::read(own.path(&name)).unwrap(), fs::read(other.path(&name)).unwrap(), "{name}");
    }
    let told = watcher.told.lock().unwrap();
    assert!(told.iter().all(|(done, total)| done <= total), "{told:?}");
    assert_eq!(told.last(), Some(&(3000, 3000)));
}

#[test]
fn a_host_can_stop_a_run_and_the_next_one_goes_on() {
    let scene = slow();
    let graph = scene.path("a.json");
    let watcher = Arc::new(Watcher { stop_from: Some(1500), ..Watcher::default() });
    let outcome = run(["render", graph.to_str().unwrap()], watcher.clone());
    assert_eq!(outcome.code, 130, "{outcome:?}");
    assert!(outcome.messages[0].contains("interrupted"), "{outcome:?}");
    assert_eq!(scene.files(), ["b.0001.exr"]);
    assert!(watcher.polls.load(Ordering::Relaxed) > 0);
    let outcome = hosted(&["render", graph.to_str().unwrap(), "--frames", "2"]);
    assert_eq!(outcome.code, 0, "{outcome:?}");
    assert_eq!(scene.files(), ["b.0001.exr", "b.0002.exr"]);
}

#[test]
fn what_would_replace_the_host_is_refused() {
    let outcome = hosted(&["edit"]);
    assert_eq!(outcome.code, 2);
    assert!(outcome.messages[0].contains("expected another command"), "{outcome:?}");
}

#[test]
fn a_limit_of_memory_ends_with_its_run() {
    let scene = slow();
    let graph = scene.path("a.json");
    let limited = hosted(&["check", graph.to_str().unwrap(), "--json", "--memory", "64MB"]);
    let free = hosted(&["check", graph.to_str().unwrap(), "--json"]);
    let limit = |outcome: &Outcome| -> u64 {
        let json: serde_json::Value = serde_json::from_str(&outcome.text).unwrap();
        json["memory"]["limit"].as_u64().unwrap()
    };
    assert_eq!(limit(&limited), 64_000_000);
    assert!(limit(&free) > 64_000_000);
}

#[test]
fn a_panic_of_a_host_ends_its_run() {
    struct Panics;
    impl Host for Panics {
        fn progress(&self, _: u64, _: u64) {
            panic!("as a host may")
        }
    }
    let scene = Scene::new(SCENE);
    let graph = scene.path("a.json");
    let arguments = ["render", graph.to_str().unwrap(), "--frames", "1"];
    assert!(std::panic::catch_unwind(|| run(arguments, Arc::new(Panics))).is_err());
    assert_eq!(hosted(&arguments).code, 0);
}
