//! Screenshots of the window, drawn by wgpu; they need a graphics driver, so they run only on request.

use crate::actions::{Action, Pane};
use crate::document::Session;
use crate::testing::{Window, act, editor, finished, sized};
use std::path::{Path, PathBuf};

/// Draws until the picture and the thumbnails are complete.
fn still(window: &mut Window) {
    finished(window);
    crate::testing::until(window, "thumbnails", |editor| !editor.state().evaluated.thumbnails.is_empty());
    window.run_steps(8);
}

fn graphs() -> PathBuf {
    at_root();
    Path::new(env!("CARGO_MANIFEST_DIR")).join("../../graphs")
}

/// Makes the root of the repository the current folder, because scenes read files beneath it.
pub(crate) fn at_root() {
    std::env::set_current_dir(Path::new(env!("CARGO_MANIFEST_DIR")).join("../..")).unwrap();
}

/// Width of the margin that is cropped from all sides of the window, in pixels.
const MARGIN: u32 = 8;

/// Writes the screenshots of README into the folder that `TROCHOID_SHOTS` names.
#[test]
#[ignore = "needs a graphics driver, and minutes"]
fn screenshots_of_scenes() {
    let Some(folder) = std::env::var_os("TROCHOID_SHOTS").map(PathBuf::from) else { return };
    // Scene, nodes that the graph frames, selected node, and panel.
    let scenes: [(&str, &[&str], &str, Pane); 3] = [
        ("stormy_sea_bare", &[], "sea", Pane::Waves),
        ("toon_sea", &[], "waves", Pane::Properties),
        ("cartoon_bay", &[], "", Pane::Report),
    ];
    for (scene, framed, chosen, pane) in scenes {
        for size in [[1280, 800], [2560, 1440]] {
            let session = Session::open(&graphs().join(format!("{scene}.json"))).unwrap();
            let points = size.map(|side: u32| (side + 2 * MARGIN) as f32);
            let mut window = sized(session, None, points);
            act(&mut window, Action::Frame(36));
            still(&mut window);
            let sheet = editor(&window).state().sheet().clone();
            let name = editor(&window).state().look.node.clone().unwrap().0;
            let above = |name: &str, steps: usize| {
                let mut found = vec![sheet.find(name).unwrap()];
                for _ in 0..steps {
                    let wires = sheet.wires.iter().filter(|wire| found.contains(&wire.to.0));
                    let more: Vec<usize> = wires.map(|wire| wire.from.0).collect();
                    found.extend(more);
                }
                found.into_iter().map(|node| sheet.nodes[node].name.clone()).collect()
            };
            let framed = match framed {
                [] => above(&name, 1),
                names => names.iter().map(|name| (*name).to_string()).collect(),
            };
            act(&mut window, Action::Select(framed));
            act(&mut window, Action::Frames);
            let chosen = if sheet.find(chosen).is_some() { chosen } else { &name };
            act(&mut window, Action::Select([chosen.to_string()].into()));
            act(&mut window, Action::Panel(pane));
            window.run_steps(5);
            let picture = window.render().unwrap();
            let picture = image::imageops::crop_imm(&picture, MARGIN, MARGIN, size[0], size[1]).to_image();
            picture.save(folder.join(format!("{scene}_{}.png", size[0]))).unwrap();
        }
    }
}
