//! Draws the editor's window for the manual, without a screen but with a graphics driver:
//!
//! ```text
//! cargo run --release -p trochoid-editor --features snapshots --example screenshots -- FOLDER
//! ```

use egui_kittest::Harness;
use std::collections::BTreeSet;
use std::path::Path;
use trochoid_editor::actions::{Action, Pane};
use trochoid_editor::document::Session;
use trochoid_editor::document::swatches::Swatch;
use trochoid_editor::editor::Editor;
use trochoid_editor::state::State;

/// Scene, selected node (by default the one in the viewer), and panel.
const SCENES: [(&str, Option<&str>, Pane); 4] = [
    ("great_wave", None, Pane::Palette),
    ("stormy_sea_bare", Some("sea"), Pane::Waves),
    ("toon_sea", Some("waves"), Pane::Properties),
    ("cartoon_bay", None, Pane::Report),
];

/// Size of a picture, in pixels.
const SIZE: [u32; 2] = [1280, 800];
/// Width of the margin that is cropped from all sides of the window, in pixels.
const MARGIN: u32 = 8;

/// A window with an editor, which is made by the first drawing.
type Window = Harness<'static, Option<Editor>>;

fn main() -> Result<(), Box<dyn std::error::Error>> {
    let folder = std::env::args_os().nth(1).ok_or("expected the folder for the pictures")?;
    let folder = std::path::absolute(folder)?;
    // Scenes read files beneath the root of the repository.
    std::env::set_current_dir(Path::new(env!("CARGO_MANIFEST_DIR")).join("../.."))?;
    for (scene, chosen, pane) in SCENES {
        let mut window = open(Session::open(&Path::new("graphs").join(format!("{scene}.json")))?);
        act(&mut window, Action::Frame(36))?;
        finish(&mut window)?;
        let state = editor(&window)?.state();
        let (looked, _) = state.look.node.clone().ok_or("the scene has no output")?;
        // The graph frames the node in the viewer, and its inputs.
        let sheet = state.sheet();
        let node = sheet.find(&looked).ok_or("the scene has no such node")?;
        let inputs = sheet.wires.iter().filter(|wire| wire.to.0 == node).map(|wire| wire.from.0);
        let framed = inputs.chain([node]).map(|node| sheet.nodes[node].name.clone()).collect();
        let chosen = chosen.map_or(looked, String::from);
        for action in [Action::Select(framed), Action::Frames, Action::Select([chosen].into()), Action::Panel(pane)] {
            act(&mut window, action)?;
        }
        if pane == Pane::Palette {
            while editor(&window)?.state().evaluated.mixture.is_none() {
                window.step();
                std::thread::sleep(std::time::Duration::from_millis(2));
            }
            let most = most(editor(&window)?.state()).ok_or("the scene has no colors")?;
            let users: BTreeSet<String> = most.nodes().into_iter().collect();
            // The graph frames the nodes that use the color, and the viewer shows where it is.
            for action in [Action::Select(users), Action::Frames, Action::Select(BTreeSet::new())] {
                act(&mut window, action)?;
            }
            act(&mut window, Action::Swatch(Some(most.key)))?;
            act(&mut window, Action::Spot(true))?;
            while editor(&window)?.state().evaluated.painted.is_none() {
                window.step();
                std::thread::sleep(std::time::Duration::from_millis(2));
            }
        }
        window.run_steps(5);
        let picture = window.render()?;
        let picture = image::imageops::crop_imm(&picture, MARGIN, MARGIN, SIZE[0], SIZE[1]).to_image();
        picture.save(folder.join(format!("editor_{scene}.png")))?;
    }
    Ok(())
}

/// Returns the color of which the picture has most.
fn most(state: &State) -> Option<Swatch> {
    let mixture = state.evaluated.mixture.as_ref()?;
    let share = |swatch: &Swatch| mixture.share(&swatch.controls()).unwrap_or(0.0);
    state.swatches().into_iter().max_by(|a, b| share(a).total_cmp(&share(b)))
}

fn open(session: Session) -> Window {
    let mut session = Some(session);
    let draw = move |ui: &mut egui::Ui, editor: &mut Option<Editor>| {
        if let Some(session) = session.take() {
            *editor = Editor::new(ui.ctx(), session, None).ok();
        }
        if let Some(editor) = editor {
            editor.ui(ui);
        }
    };
    let size = SIZE.map(|side| (side + 2 * MARGIN) as f32);
    Harness::builder().with_size(size).with_step_dt(0.02).build_ui_state(draw, None)
}

fn editor(window: &Window) -> Result<&Editor, &'static str> {
    window.state().as_ref().ok_or("the system cannot start a thread")
}

fn act(window: &mut Window, action: Action) -> Result<(), &'static str> {
    let context = window.ctx.clone();
    window.state_mut().as_mut().ok_or("the system cannot start a thread")?.act(action, &context);
    window.run_steps(3);
    Ok(())
}

/// Draws until the picture and the thumbnails are complete.
fn finish(window: &mut Window) -> Result<(), String> {
    loop {
        window.step();
        let seen = &editor(window)?.state().evaluated;
        if let Some(failed) = &seen.failed {
            return Err(failed.clone());
        }
        let is_finished = seen.progress.is_none() && seen.result.as_ref().is_some_and(|result| result.finished);
        if is_finished && !seen.thumbnails.is_empty() {
            break;
        }
        std::thread::sleep(std::time::Duration::from_millis(2));
    }
    window.run_steps(8);
    Ok(())
}
