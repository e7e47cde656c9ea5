//! Files that are part of the document and change on disk.

use crate::actions::Action;
use crate::document::{Session, edit};
use crate::testing::{Window, act, editor, finished, until, window};
use egui_kittest::kittest::Queryable;
use std::fs::write;

const SCENE: &str = r##"{
  "trochoid": 1, "format": { "width": 8, "height": 4 }, "working_space": "srgb",
  "include": ["lib/tones.json"], "palette": "inks.json",
  "nodes": { "tone": { "type": "Tone" }, "paper": { "type": "Mix", "a": "tone", "b": "palette.ink", "weight": 0.5 } },
  "outputs": { "beauty": { "color": "paper" } }
}"##;

fn tones(color: &str) -> String {
    format!(
        r##"{{ "trochoid": 1, "groups": {{ "Tone": {{ "nodes": {{ "plain": {{ "type": "Constant", "color": "{color}" }} }},
        "outputs": {{ "out": "plain" }} }} }} }}"##
    )
}

fn inks(color: &str) -> String {
    format!(r##"{{ "palette": {{ "ink": "{color}" }} }}"##)
}

fn shown(window: &Window) -> [u8; 3] {
    let screen = &editor(window).state().evaluated.result.as_ref().unwrap().screen;
    [screen.pixels[0], screen.pixels[1], screen.pixels[2]]
}

#[test]
fn a_changed_file_is_read_again_at_once() {
    let folder = tempfile::tempdir().unwrap();
    let (file, lib) = (folder.path().join("scene.json"), folder.path().join("lib"));
    std::fs::create_dir(&lib).unwrap();
    write(&file, SCENE).unwrap();
    write(lib.join("tones.json"), tones("#204060")).unwrap();
    write(folder.path().join("inks.json"), inks("#406080")).unwrap();
    let mut window = window(Session::open(&file).unwrap(), None);
    finished(&mut window);
    assert_eq!(editor(&window).state().evaluated.failed, None);
    assert_eq!(shown(&window), [0x30, 0x50, 0x70]);
    act(&mut window, Action::Edit(edit::moved(&[("tone".into(), [7.0, 0.0])])));
    let text = editor(&window).state().session.text().to_string();
    let shows = |color: [u8; 3]| {
        move |editor: &crate::editor::Editor| {
            editor.state().evaluated.result.as_ref().is_some_and(|result| result.screen.pixels[..3] == color)
        }
    };
    write(lib.join("tones.json"), tones("#604020")).unwrap();
    until(&mut window, "the notice", |editor| {
        editor.notices.texts().contains(&"tones.json has changed and was read again")
    });
    until(&mut window, "the color of the changed group", shows([0x50, 0x50, 0x50]));
    // Programs often replace a file instead of writing to it.
    write(folder.path().join("new.json"), inks("#604020")).unwrap();
    std::fs::rename(folder.path().join("new.json"), folder.path().join("inks.json")).unwrap();
    until(&mut window, "the color of the changed palette", shows([0x60, 0x40, 0x20]));
    // A damaged file is an error as long as it is damaged; the picture stays, marked as old.
    write(lib.join("tones.json"), "{").unwrap();
    until(&mut window, "the error", |editor| editor.state().evaluated.failed.is_some());
    window.run_steps(2);
    assert!(editor(&window).state().evaluated.last.is_some());
    window.get_by_label("Old picture");
    write(lib.join("tones.json"), tones("#204060")).unwrap();
    until(&mut window, "the picture of the corrected file", shows([0x40, 0x40, 0x40]));
    window.step();
    assert!(window.query_by_label("Old picture").is_none());
    // The document itself is as it was.
    assert_eq!(editor(&window).state().session.text(), text);
    act(&mut window, Action::Undo);
    assert_eq!(editor(&window).state().session.text(), SCENE);
}
