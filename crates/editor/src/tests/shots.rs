//! Pictures of the window, drawn by wgpu: they need a graphics driver, so CI asks for them by name.

use super::dusk;
use crate::actions::Action;
use crate::document::Session;
use crate::layout::Pane;
use crate::testing::{Window, editor, finished, sized};
use std::path::{Path, PathBuf};

fn act(window: &mut Window, action: Action) {
    let context = window.ctx.clone();
    window.state_mut().as_mut().unwrap().act(action, &context);
    window.run_steps(3);
}

/// Draws until nothing on the window changes any more: thumbnails as well.
fn still(window: &mut Window) {
    finished(window);
    crate::testing::until(window, "thumbnails", |editor| !editor.state().seen.thumbnails.is_empty());
    // Times differ from run to run.
    window.run_steps(8);
}

#[test]
#[ignore = "needs a graphics driver"]
fn snapshot_of_a_small_document() {
    let mut window = sized(dusk(), None, [1000.0, 640.0]);
    still(&mut window);
    act(&mut window, Action::Select(["sky".to_string()].into()));
    let state = &mut window.state_mut().as_mut().unwrap().state;
    // What was measured is not the same twice.
    state.seen.past.clear();
    state.seen.nodes.clear();
    window.run_steps(3);
    window.snapshot("editor_dark");
    act(&mut window, Action::Theme);
    act(&mut window, Action::Panel(Pane::Text));
    window.snapshot("editor_light");
}

fn graphs() -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).join("../../graphs")
}

/// Writes what README shows into the folder that `TROCHOID_SHOTS` names.
#[test]
#[ignore = "needs a graphics driver, and minutes"]
fn screenshots_of_scenes() {
    let Some(folder) = std::env::var_os("TROCHOID_SHOTS").map(PathBuf::from) else { return };
    let scenes = [
        ("stormy_sea_bare", "storm", Pane::Waves),
        ("toon_sea", "waves", Pane::Properties),
        ("cartoon_bay", "", Pane::Report),
    ];
    for (scene, chosen, pane) in scenes {
        for (size, name) in [([1280.0, 800.0], "1280"), ([2560.0, 1440.0], "2560")] {
            let session = Session::open(&graphs().join(format!("{scene}.json"))).unwrap();
            let mut window = sized(session, None, size);
            act(&mut window, Action::Frame(36));
            still(&mut window);
            if !chosen.is_empty() && editor(&window).state().sheet().find(chosen).is_some() {
                act(&mut window, Action::Select([chosen.to_string()].into()));
            }
            act(&mut window, Action::Panel(pane));
            window.run_steps(5);
            window.render().unwrap().save(folder.join(format!("{scene}_{name}.png"))).unwrap();
        }
    }
}
