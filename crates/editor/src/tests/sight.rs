//! The view of the graph: it is fitted until somebody moves it, and it stays as it was left.

use super::dusk;
use crate::actions::{Action, Layout};
use crate::document::Session;
use crate::document::tests::groups::LINKED;
use crate::testing::{Window, act, graph, unseen};
use egui::{Event, Modifiers, MouseWheelUnit, Rect, TouchPhase, vec2};
use egui_kittest::kittest::Queryable;

/// Returns the places of some nodes of the document that are in view.
fn nodes(window: &Window) -> Vec<Rect> {
    let labels = ["Node pair, Pair", "Node keyed, Dot", "Node down, ScreenY", "Node sky, Ramp", "Node dusk, Mix"];
    labels.iter().filter_map(|label| Some(window.query_by_label(label)?.rect())).collect()
}

fn wheel(window: &mut Window) {
    window.hover_at(graph(window).center());
    let (unit, phase, modifiers) = (MouseWheelUnit::Line, TouchPhase::Move, Modifiers::NONE);
    window.event(Event::MouseWheel { unit, delta: vec2(0.0, 1.5), phase, modifiers });
    window.run_steps(20);
}

#[test]
fn a_view_is_the_same_after_a_group_was_entered_and_left() {
    let mut window = unseen(Session::new(LINKED.into(), None));
    window.run_steps(3);
    wheel(&mut window);
    let before = nodes(&window);
    assert!(!before.is_empty());
    for _ in 0..3 {
        act(&mut window, Action::Enter(vec!["pair".into()]));
        wheel(&mut window);
        act(&mut window, Action::Enter(Vec::new()));
        assert_eq!(nodes(&window), before);
    }
}

#[test]
fn a_layout_fits_the_graph_until_somebody_moves_the_view() {
    let mut window = unseen(dusk());
    for layout in [Layout::Painting, Layout::Animation, Layout::First] {
        act(&mut window, Action::Layout(layout));
        let (panel, nodes) = (graph(&window), nodes(&window));
        let all = nodes.iter().copied().reduce(Rect::union).unwrap();
        assert!(nodes.len() == 3 && panel.contains_rect(all), "{panel:?} {nodes:?}");
    }
    wheel(&mut window);
    let before = nodes(&window);
    act(&mut window, Action::Layout(Layout::Animation));
    let after = nodes(&window);
    let sizes = |nodes: &[Rect]| nodes.iter().map(|node| node.width().round()).collect::<Vec<f32>>();
    assert_eq!(sizes(&after)[..1], sizes(&before)[..1], "the zoom stays");
}
