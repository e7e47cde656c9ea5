//! Nothing moves under the pointer when pictures, thumbnails and notices arrive.

use super::dusk;
use crate::actions::Action;
use crate::testing::{Window, act, finished, until, window};
use egui::Rect;
use egui_kittest::kittest::Queryable;

const NODES: [&str; 3] = ["Node down, ScreenY", "Node sky, Ramp", "Node dusk, Mix"];

fn places(window: &Window, labels: &[&str]) -> Vec<Rect> {
    labels.iter().map(|label| window.get_all_by_label(label).next().unwrap().rect()).collect()
}

#[test]
fn nodes_stay_where_they_are_when_their_thumbnails_arrive() {
    let mut window = window(dusk(), None);
    let before = places(&window, &NODES);
    finished(&mut window);
    until(&mut window, "the thumbnails", |editor| editor.state().evaluated.thumbnails.len() >= 3);
    window.run_steps(3);
    assert_eq!(places(&window, &NODES), before);
}

#[test]
fn knobs_stay_where_they_are_when_pictures_and_notices_arrive() {
    let mut window = window(dusk(), None);
    act(&mut window, Action::Select(["dusk".to_string()].into()));
    let labels = ["weight", "Node dusk, Mix", "Viewer", "Palette"];
    let before = places(&window, &labels);
    act(
        &mut window,
        Action::Notice("A notice that is longer than the panel is wide, so that it takes two lines".into()),
    );
    assert_eq!(places(&window, &labels), before, "a notice lies above");
    finished(&mut window);
    window.run_steps(3);
    assert_eq!(places(&window, &labels), before, "a picture and its report have their places");
}
