//! Measures the response times of the interface, without a screen: `cargo bench -p trochoid-editor --bench interaction`.
//!
//! A window of 1920 × 1080 points is laid out and tessellated as it would be for the graphics driver, whose part is not
//! measured. Times to a picture run from the edit to the drawing that has the picture.

mod window;

use egui::{Event, Modifiers, PointerButton, pos2};
use serde_json::json;
use std::path::Path;
use std::time::{Duration, Instant};
use trochoid_editor::actions::{Action, Pane, Tint};
use trochoid_editor::document::{self, Edit, Session, palette};
use trochoid_editor::editor::Editor;
use window::Window;

impl Window {
    /// Waits for the recipe of the picture; returns the time, or the reason that there is none.
    fn weigh(&mut self) -> Result<Duration, String> {
        let context = self.context.clone();
        self.editor.act(Action::Panel(Pane::Palette), &context);
        self.draw(Vec::new());
        let time = self.until(|editor| {
            let seen = &editor.state().evaluated;
            seen.mixture.is_some() || seen.unmixed.is_some()
        });
        self.editor.state().evaluated.unmixed.clone().map_or(Ok(time), Err)
    }

    /// Times from moments of drags to the whole pictures that are ready for the graphics driver: of each color that the
    /// picture has, some.
    fn drags(&mut self, moments: u8) -> Vec<Duration> {
        let context = self.context.clone();
        let mut times = Vec::new();
        // Somewhere beside all widgets, the pointer is held as in a drag.
        let button = |pressed: bool| Event::PointerButton {
            pos: pos2(960.0, 8.0),
            button: PointerButton::Primary,
            pressed,
            modifiers: Modifiers::NONE,
        };
        self.draw(vec![Event::PointerMoved(pos2(960.0, 8.0)), button(true)]);
        for swatch in self.editor.state().swatches() {
            let (controls, seen) = (swatch.controls(), &self.editor.state().evaluated);
            let share = seen.mixture.as_ref().and_then(|mixture| mixture.share(&controls));
            if share.is_none_or(|share| share == 0.0) {
                continue;
            }
            for moment in 0..=moments {
                let color = [f32::from(moment) / 255.0, 0.5, 0.75];
                let state = self.editor.state();
                let Ok(edit) = palette::colored(state.sheet(), &swatch, color, state.frame) else { continue };
                let before = state.evaluated.painted_at;
                let started = Instant::now();
                let tint = Tint { controls: controls.clone(), color, edit };
                self.editor.act(Action::Tint(Some(tint)), &context);
                self.draw(Vec::new());
                self.until(|editor| editor.state().evaluated.painted_at != before);
                let ready = self.editor.state().evaluated.painted_at;
                // The first moment of a drag also takes back the color before it.
                times.extend(ready.map(|ready| ready - started));
            }
            self.editor.act(Action::Tint(None), &context);
        }
        self.draw(vec![button(false)]);
        times
    }

    /// Times from an edit to the first picture after it, and to the whole one.
    fn edit(&mut self, edit: Edit) -> (Duration, Duration) {
        self.rest();
        let before = self.editor.state().evaluated.result.clone();
        let context = self.context.clone();
        let started = Instant::now();
        self.editor.act(Action::Edit(edit), &context);
        self.draw(Vec::new());
        let other = |editor: &Editor| match (&before, &editor.state().evaluated.result) {
            (Some(old), Some(new)) => !std::sync::Arc::ptr_eq(old, new),
            (_, new) => new.is_some(),
        };
        self.until(other);
        let first = started.elapsed();
        self.finished();
        (first, started.elapsed())
    }

    /// Pictures that come while a camera is dragged, for some seconds: each moment of the drag follows the first picture of
    /// the one before.
    fn drag_camera(&mut self, camera: &str, seconds: u64) -> f64 {
        let context = self.context.clone();
        let (started, mut count) = (Instant::now(), 0_u32);
        while started.elapsed() < Duration::from_secs(seconds) {
            let before = self.editor.state().evaluated.result.clone();
            // Never the place where it is: that would change no picture.
            let at = json!([0.02 * f64::from(count + 1), 7.0 + 0.01 * f64::from(count), 0.0]);
            let edit = Edit::set(document::Path::node(camera).to("position"), &at);
            self.editor.act(Action::Edit(edit), &context);
            self.draw(Vec::new());
            self.until(|editor| {
                let now = &editor.state().evaluated.result;
                now.as_ref().map(std::sync::Arc::as_ptr) != before.as_ref().map(std::sync::Arc::as_ptr)
            });
            count += 1;
        }
        f64::from(count) / started.elapsed().as_secs_f64()
    }
}

fn percentile(times: &mut [Duration], share: f64) -> f64 {
    times.sort();
    times[((times.len() - 1) as f64 * share) as usize].as_secs_f64() * 1e3
}

/// A chain of mixes of ramps, as many nodes as asked for.
fn chain(count: usize) -> String {
    let mut nodes = serde_json::Map::new();
    nodes.insert("down".into(), json!({ "type": "ScreenY" }));
    nodes.insert("across".into(), json!({ "type": "ScreenX" }));
    let mut last = String::from("#203040");
    for index in 0..count.saturating_sub(2) {
        let name = format!("mix_{index}");
        let weight = if index % 2 == 0 { "down" } else { "across" };
        let color = format!("#{:02x}{:02x}80", index * 7 % 256, index * 13 % 256);
        nodes.insert(name.clone(), json!({ "type": "Mix", "a": last, "b": color, "weight": weight }));
        last = name;
    }
    json!({
        "trochoid": 1,
        "format": { "width": 1920, "height": 1080, "samples": 16 },
        "nodes": nodes,
        "outputs": { "beauty": { "color": last } },
    })
    .to_string()
}

fn row(what: &str, (first, whole): (Duration, Duration)) {
    println!("{what:<52} {:>7.0} ms {:>7.0} ms", first.as_secs_f64() * 1e3, whole.as_secs_f64() * 1e3);
}

fn median(mut runs: Vec<(Duration, Duration)>) -> (Duration, Duration) {
    let middle = runs.len() / 2;
    let mut firsts: Vec<Duration> = runs.iter().map(|run| run.0).collect();
    firsts.sort();
    runs.sort_by_key(|run| run.1);
    (firsts[middle], runs[middle].1)
}

fn main() -> Result<(), Box<dyn std::error::Error>> {
    let root = Path::new(env!("CARGO_MANIFEST_DIR")).join("../..");
    // What scenes read lies beneath it.
    std::env::set_current_dir(&root)?;
    let mut window = Window::new(Session::new(chain(500), None))?;
    window.finished();
    for idle in [true, false] {
        let mut times = Vec::new();
        for frame in 0..400 {
            if !idle && frame % 10 == 0 {
                // An edit keeps the evaluation going.
                let color = json!(format!("#{:02x}4060", frame % 256));
                let path = document::Path::node("mix_3").to("b");
                let context = window.context.clone();
                window.editor.act(Action::Edit(Edit::set(path, &color)), &context);
            }
            let at = pos2(300.0 + frame as f32, 700.0);
            times.push(window.draw(vec![Event::PointerMoved(at)]));
        }
        let what = if idle { "at rest" } else { "evaluating, an edit every tenth" };
        println!(
            "frame, 500 nodes, {what}: median {:.1} ms, 95 % {:.1} ms, most {:.1} ms",
            percentile(&mut times, 0.5),
            percentile(&mut times, 0.95),
            percentile(&mut times, 1.0)
        );
    }
    println!("\n{:<52} {:>10} {:>10}", "from an edit to a picture, 1920 × 1080", "first", "whole");
    let scene = |name: &str| Session::open(&root.join("graphs").join(name));
    let set = |node: &str, knob: &str, value: serde_json::Value| Edit::set(document::Path::node(node).to(knob), &value);

    for name in ["stormy_sea.json", "great_wave.json"] {
        let mut window = Window::new(scene(name)?)?;
        window.finished();
        window.rest();
        match window.weigh() {
            Ok(weighing) => {
                window.rest();
                let mut times = window.drags(4);
                let recipe = window.editor.state().evaluated.mixture.as_ref().map(|mixture| mixture.recipe.clone());
                let megabytes = recipe.map_or(0, |recipe| recipe.bytes() >> 20);
                println!(
                    "a dragged color, {name}: median {:.1} ms, 95 % {:.1} ms, most {:.1} ms; recipe {:.1} s, {megabytes} MB",
                    percentile(&mut times, 0.5),
                    percentile(&mut times, 0.95),
                    percentile(&mut times, 1.0),
                    weighing.as_secs_f64(),
                );
            }
            Err(why) => println!("a dragged color, {name}: {why}"),
        }
    }

    for (name, node, knob, values) in [
        ("stormy_sea.json", "beauty", "light", ["#f4efe4", "#f3eee3", "#f2ede2", "#f1ece1", "#f0ebe0"]),
        ("great_wave.json", "beauty", "a", ["#f4efe4", "#f3eee3", "#f2ede2", "#f1ece1", "#f0ebe0"]),
        ("from_passes.json", "beauty", "b", ["#f4efe4", "#f3eee3", "#f2ede2", "#f1ece1", "#f0ebe0"]),
    ] {
        let started = Instant::now();
        let mut window = Window::new(scene(name)?)?;
        window.until(|editor| editor.state().evaluated.result.is_some());
        let first = started.elapsed();
        window.finished();
        let scratch = (first, started.elapsed());
        row(&format!("{name} from scratch"), scratch);
        let runs = values.iter().map(|value| window.edit(set(node, knob, json!(value)))).collect();
        let edited = median(runs);
        row(&format!("{node}.{knob} of {name}"), edited);
        println!("{:<52} {:>21.2}", "  of that from scratch", edited.1.as_secs_f64() / scratch.1.as_secs_f64());
    }

    let mut window = Window::new(scene("stormy_sea_bare.json")?)?;
    window.finished();
    println!("a dragged camera, stormy_sea_bare: {:.1} coarse pictures a second", window.drag_camera("camera", 8));

    let mut window = Window::new(scene("from_passes.json")?)?;
    window.finished();
    let sheet = window.editor.state().sheet().clone();
    let mix = sheet.nodes.iter().find(|node| {
        let b = sheet.get(&document::Path::node(&node.name).to("b"));
        node.ty == "Mix" && b.and_then(|b| b.as_str()).is_some_and(|b| b.starts_with("palette."))
    });
    if let Some(mix) = mix {
        let runs =
            (0..9).map(|n| window.edit(set(&mix.name, "b", json!(format!("#{:02x}5566", 16 * n + 9))))).collect();
        row("a control color, from_passes", median(runs));
    }
    let clamp = sheet.nodes.iter().find(|node| node.ty == "Clamp");
    if let Some(clamp) = clamp {
        let low = sheet.get(&document::Path::node(&clamp.name).to("min")).and_then(|min| min.as_f64()).unwrap_or(0.0);
        let runs =
            (0..9).map(|n| window.edit(set(&clamp.name, "min", json!(low - 0.001 * f64::from(n + 1))))).collect();
        row("a back-end knob, from_passes", median(runs));
    }

    let mut window = Window::new(scene("stormy_sea_bare.json")?)?;
    window.finished();
    let sheet = window.editor.state().sheet().clone();
    if let Some(sea) = sheet.nodes.iter().find(|node| node.ty == "GerstnerSea") {
        let runs = (0..5).map(|n| window.edit(set(&sea.name, "sharpness", json!(0.5 + 0.01 * f64::from(n))))).collect();
        row("a wave knob, stormy_sea_bare", median(runs));
    }

    let started = Instant::now();
    let mut window = Window::new(scene("stormy_sea.json")?)?;
    window.until(|editor| editor.state().evaluated.result.is_some());
    let first = started.elapsed();
    window.finished();
    row("stormy_sea opens", (first, started.elapsed()));
    Ok(())
}
