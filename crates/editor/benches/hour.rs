//! An hour of work without a screen: `cargo bench -p trochoid-editor --bench hour -- MINUTES [SCENE…]` (60, in all scenes,
//! unless told).
//!
//! Copies of the scenes are opened, looked at, edited, undone and played, at random. It reports the largest memory of the
//! process and the processor time at rest, and fails if looking changes a text, if undoing does not restore it, if a file is
//! written, or if anything panics.

mod window;

use egui::{Event, Key, Modifiers, PointerButton, Pos2, pos2};
use rand::seq::IndexedRandom;
use rand::{RngExt, SeedableRng};
use rand_pcg::Pcg64Mcg;
use serde_json::{Value, json};
use std::collections::{BTreeMap, BTreeSet};
use std::path::{Path, PathBuf};
use std::sync::atomic::{AtomicUsize, Ordering};
use std::time::{Duration, Instant};
use trochoid::Heap;
use trochoid_editor::actions::{Action, Pane, Switch};
use trochoid_editor::document::{self, Edit, Session};
use window::Window;

#[global_allocator]
static HEAP: Heap = Heap;

const SCENES: [&str; 6] = [
    "stormy_sea.json",
    "great_wave.json",
    "toon_sea.json",
    "cartoon_bay.json",
    "stormy_sea_bare.json",
    "from_passes.json",
];

/// Resident memory of the process, in bytes.
fn memory() -> u64 {
    let pages = std::fs::read_to_string("/proc/self/statm").unwrap_or_default();
    pages.split_whitespace().nth(1).and_then(|pages| pages.parse::<u64>().ok()).unwrap_or_default() * 4096
}

/// Processor time of the process, in seconds.
fn processor() -> f64 {
    let stat = std::fs::read_to_string("/proc/self/stat").unwrap_or_default();
    let fields: Vec<&str> = stat.rsplit(')').next().unwrap_or_default().split_whitespace().collect();
    let ticks = |index: usize| fields.get(index).and_then(|ticks| ticks.parse::<f64>().ok()).unwrap_or_default();
    (ticks(11) + ticks(12)) / 100.0
}

/// Every file below a folder, with what it holds.
fn files(folder: &Path, found: &mut BTreeMap<PathBuf, Vec<u8>>) -> std::io::Result<()> {
    for entry in std::fs::read_dir(folder)? {
        let path = entry?.path();
        if path.is_dir() {
            files(&path, found)?;
        } else {
            found.insert(path.clone(), std::fs::read(&path)?);
        }
    }
    Ok(())
}

fn copy(from: &Path, to: &Path) -> std::io::Result<()> {
    std::fs::create_dir_all(to)?;
    for entry in std::fs::read_dir(from)? {
        let path = entry?.path();
        let at = to.join(path.file_name().unwrap_or_default());
        if path.is_dir() {
            copy(&path, &at)?;
        } else {
            std::fs::copy(&path, &at)?;
        }
    }
    Ok(())
}

/// What is done at random.
struct Work {
    random: Pcg64Mcg,
    /// What was done last.
    last: String,
    /// The largest memory of the process and the most bytes in counted blocks, in the current scene.
    most: [u64; 2],
    deeds: u64,
}

impl Work {
    fn somewhere(&mut self) -> Pos2 {
        // Below the menus and above the timeline: in the viewer, the graph, the panels' plots.
        pos2(self.random.random_range(0.0..1500.0), self.random.random_range(80.0..1000.0))
    }

    /// Draws until a picture is there, or for some seconds.
    fn wait(&mut self, window: &mut Window) {
        let started = Instant::now();
        let patience = Duration::from_millis(self.random.random_range(50..4000));
        window.until(|editor| {
            started.elapsed() > patience
                || (editor.state().evaluated.progress.is_none() && editor.state().evaluated.result.is_some())
        });
        let most = [memory(), Heap::taken() as u64];
        self.most = [0, 1].map(|index| self.most[index].max(most[index]));
        self.deeds += 1;
    }

    fn act(&mut self, window: &mut Window, action: Action) {
        let context = window.context.clone();
        self.last = format!("{action:?}");
        window.editor.act(action, &context);
        window.draw(Vec::new());
        self.wait(window);
    }

    /// Looks around: points, clicks, views, switches; none of it may change the document.
    fn look(&mut self, window: &mut Window) {
        let names: Vec<String> = window.editor.state().sheet().nodes.iter().map(|node| node.name.clone()).collect();
        let Some(name) = names.choose(&mut self.random).cloned() else { return };
        self.last = String::new();
        let key = |key: Key| {
            [true, false].map(|pressed| Event::Key {
                key,
                physical_key: None,
                pressed,
                repeat: false,
                modifiers: Modifiers::NONE,
            })
        };
        match self.random.random_range(0..10) {
            0 => {
                let to = self.somewhere();
                self.last = format!("a click at {to}");
                window.draw(vec![Event::PointerMoved(to)]);
                for pressed in [true, false] {
                    let (button, modifiers) = (PointerButton::Primary, Modifiers::NONE);
                    window.draw(vec![Event::PointerButton { pos: to, button, pressed, modifiers }]);
                }
                self.wait(window);
                // What a click offers, such as nodes for a pin, is not taken.
                window.draw(key(Key::Escape).to_vec());
            }
            1 => {
                let to = self.somewhere();
                window.draw(vec![Event::PointerMoved(to)]);
                self.wait(window);
            }
            2 => self.act(window, Action::Look(name, 0)),
            3 => self.act(window, Action::Select(BTreeSet::from([name]))),
            4 => {
                let pane = [Pane::Palette, Pane::Properties, Pane::Waves, Pane::Report, Pane::Text];
                let pane = *pane.choose(&mut self.random).unwrap_or(&Pane::Properties);
                self.act(window, Action::Panel(pane));
            }
            5 => {
                let switch = [Switch::Hull, Switch::Near, Switch::Scopes, Switch::Hold, Switch::Wipe, Switch::LetGo];
                let switch = *switch.choose(&mut self.random).unwrap_or(&Switch::Hull);
                self.act(window, Action::Viewer(switch));
            }
            6 => {
                let frame = self.random.random_range(1..40);
                self.act(window, Action::Frame(frame));
            }
            7 => {
                self.act(window, Action::Play(true));
                self.wait(window);
                self.act(window, Action::Play(false));
            }
            8 => {
                let chosen = [Key::F, Key::H, Key::N, Key::S, Key::Escape];
                let chosen = *chosen.choose(&mut self.random).unwrap_or(&Key::F);
                window.draw(key(chosen).to_vec());
                self.wait(window);
            }
            _ => {
                let proxy = *[1, 2, 4].choose(&mut self.random).unwrap_or(&2);
                self.act(window, Action::Proxy(proxy));
            }
        }
    }

    /// Changes a number, a color or nodes, or takes that back.
    fn edit(&mut self, window: &mut Window) {
        let sheet = window.editor.state().sheet().clone();
        let Some(node) = sheet.nodes.choose(&mut self.random) else { return };
        let path = document::Path::node(&node.name);
        let action = match self.random.random_range(0..8) {
            0 => Action::Undo,
            1 => Action::Redo,
            2 => {
                let x: f32 = self.random.random_range(-500.0..500.0);
                Action::Edit(document::edit::moved(&[(node.name.clone(), [x, -x])]))
            }
            3 => Action::Edit(document::edit::disabled(&sheet, std::slice::from_ref(&node.name))),
            4 => Action::Edit(document::edit::deleted(&sheet, std::slice::from_ref(&node.name))),
            _ => {
                let Some(Value::Object(items)) = sheet.get(&path) else { return };
                let numbers: Vec<(&String, f64)> =
                    items.iter().filter_map(|(key, value)| Some((key, value.as_f64()?))).collect();
                let Some((key, number)) = numbers.choose(&mut self.random) else { return };
                let number = number * self.random.random_range(0.9..1.1);
                Action::Edit(Edit::set(path.to(key.as_str()), &json!(number)))
            }
        };
        self.act(window, action);
        let is_wrong = window.editor.state().evaluated.result.is_none();
        if is_wrong {
            self.act(window, Action::Undo);
        }
    }
}

fn main() -> Result<(), Box<dyn std::error::Error>> {
    let minutes: f64 = std::env::args().filter_map(|arg| arg.parse().ok()).next().unwrap_or(60.0);
    let root = Path::new(env!("CARGO_MANIFEST_DIR")).join("../..");
    Heap::return_large();
    static PANICS: AtomicUsize = AtomicUsize::new(0);
    let usual = std::panic::take_hook();
    std::panic::set_hook(Box::new(move |info| {
        PANICS.fetch_add(1, Ordering::Relaxed);
        usual(info);
    }));
    let scratch = tempfile::tempdir()?;
    for folder in ["graphs", "samples"] {
        copy(&root.join(folder), &scratch.path().join(folder))?;
    }
    let mut before = BTreeMap::new();
    files(scratch.path(), &mut before)?;
    std::env::set_current_dir(scratch.path())?;
    let mut work = Work { random: Pcg64Mcg::seed_from_u64(1), last: String::new(), most: [0; 2], deeds: 0 };
    let mut window = Window::new(Session::new("{}".into(), None))?;
    let told: Vec<String> = std::env::args().collect();
    let is_told = |name: &&str| told.iter().any(|told| name.strip_suffix(".json") == Some(told));
    let chosen: Vec<&str> = SCENES.into_iter().filter(is_told).collect();
    let scenes = if chosen.is_empty() { SCENES.to_vec() } else { chosen };
    for name in &scenes {
        let started = Instant::now();
        let share = Duration::from_secs_f64(minutes * 60.0 / scenes.len() as f64);
        work.act(&mut window, Action::OpenFile(scratch.path().join("graphs").join(name)));
        window.finished();
        let text = || std::fs::read_to_string(scratch.path().join("graphs").join(name));
        while started.elapsed() < share / 2 {
            work.look(&mut window);
            let (now, before) = (window.editor.state().session.text(), text()?);
            if let Some((new, old)) = now.lines().zip(before.lines()).find(|(new, old)| new != old) {
                panic!("{name}: looking changed the document\n  from {old}\n  to   {new}\n  by   {}", work.last);
            }
            assert_eq!(now.lines().count(), before.lines().count(), "{name}: by {}", work.last);
        }
        while started.elapsed() < share {
            if work.random.random_bool(0.5) {
                work.look(&mut window);
            } else {
                work.edit(&mut window);
            }
        }
        let mut undone = 0;
        while window.editor.state().session.is_changed() {
            work.act(&mut window, Action::Undo);
            undone += 1;
            assert!(undone < 100_000, "{name}: undoing does not lead back");
        }
        assert_eq!(window.editor.state().session.text(), text()?, "{name}: undoing did not restore the document");
        assert_eq!(PANICS.load(Ordering::Relaxed), 0, "{name}: something panicked");
        let ([memory, blocks], deeds) = (std::mem::take(&mut work.most).map(|bytes| bytes / 1_000_000), work.deeds);
        println!("{name:<24} {deeds:>6} deeds, {undone:>4} undone, at most {memory} MB, {blocks} MB in large blocks");
    }
    // What is viewed last may have no picture.
    window.until(|editor| editor.state().evaluated.progress.is_none());
    // Small pictures of the nodes may take long.
    let started = Instant::now();
    loop {
        let used = processor();
        window.rest();
        if processor() - used < 0.1 || started.elapsed() > Duration::from_secs(300) {
            break;
        }
    }
    let (started, used) = (Instant::now(), processor());
    while started.elapsed() < Duration::from_secs(10) {
        if window.context.has_requested_repaint() {
            window.draw(Vec::new());
        }
        std::thread::sleep(Duration::from_millis(5));
    }
    println!("at rest: {:.1} % of a processor", (processor() - used) * 10.0);
    let mut after = BTreeMap::new();
    files(scratch.path(), &mut after)?;
    assert!(before == after, "files were written");
    Ok(())
}
