//! Tests of playback with a worker that is slower than the frame rate.

use super::{DUSK, dusk};
use crate::actions::Action;
use crate::document::{Edit, Path, Session};
use crate::testing::{Window, ask, editor, finished, window};
use serde_json::json;
use std::time::{Duration, Instant};

/// Number of frames of `DUSK`.
const FRAMES: i64 = 8;

/// Opens a window whose worker takes this long for every picture. The window's clock runs ten times as fast as the
/// machine's.
fn slow(session: Session, milliseconds: u64) -> Window {
    let mut window = window(session, None);
    finished(&mut window);
    editor(&window).worker.slow_down(Duration::from_millis(milliseconds));
    window
}

/// Returns the frame that is shown, if its picture is finished.
fn shown(window: &Window) -> Option<i64> {
    let state = editor(window).state();
    let result = state.evaluated.result.as_ref().filter(|result| result.finished && state.evaluated.failed.is_none());
    result.map(|result| result.frame)
}

/// Draws until `count` frames have been shown, and returns them.
fn follow(window: &mut Window, count: usize) -> Vec<i64> {
    let (started, mut frames) = (Instant::now(), Vec::new());
    while frames.len() < count {
        assert!(started.elapsed() < Duration::from_secs(60), "nothing follows {frames:?}");
        std::thread::sleep(Duration::from_millis(2));
        window.step();
        let frame = shown(window).unwrap_or(-1);
        if frames.last() != Some(&frame) {
            frames.push(frame);
        }
    }
    frames
}

/// Returns the frames that playback of a range should show, from a frame on.
fn wanted(from: i64, (first, last): (i64, i64), count: usize) -> Vec<i64> {
    (0..count as i64).map(|index| first + (from - first + index).rem_euclid(last - first + 1)).collect()
}

#[test]
fn every_frame_is_shown_in_order_however_long_it_takes() {
    // 300 ms on the window's clock; at 24 frames per second, a frame should last 42 ms.
    let mut window = slow(dusk(), 30);
    ask(&mut window, Action::Play(true));
    let count = 2 * FRAMES as usize + 3;
    assert_eq!(follow(&mut window, count), wanted(1, (1, FRAMES), count));
    assert!(editor(&window).state().evaluated.rate.is_some_and(|rate| rate > 0.0 && rate < 30.0));
    assert_eq!(editor(&window).state().evaluated.frames.len(), FRAMES as usize, "all are kept");
    ask(&mut window, Action::Play(false));
    window.step();
    assert_eq!(editor(&window).state().evaluated.rate, None);
}

#[test]
fn frames_are_kept_as_shown_and_have_their_values_when_looked_at() {
    let mut window = slow(dusk(), 5);
    ask(&mut window, Action::Play(true));
    let last = *follow(&mut window, FRAMES as usize + 2).last().unwrap();
    assert!(
        editor(&window).state().evaluated.frames.values().all(|made| made.is_bare()),
        "values take four times the memory"
    );
    let shown = editor(&window).state().evaluated.result.clone().unwrap();
    assert!(shown.is_bare() && shown.frame == last);
    // No coarse picture comes in between.
    ask(&mut window, Action::Play(false));
    let paused = editor(&window).state().frame;
    while editor(&window).state().evaluated.progress.is_some()
        || editor(&window).state().evaluated.result.as_ref().unwrap().is_bare()
    {
        assert!(editor(&window).state().evaluated.result.as_ref().unwrap().finished);
        window.step();
    }
    for frame in [paused, 3, 2] {
        ask(&mut window, Action::Frame(frame));
        let kept = editor(&window).state().evaluated.frames[&frame].screen.clone();
        assert_eq!(editor(&window).state().evaluated.result.as_ref().unwrap().screen, kept, "shown at once");
        finished(&mut window);
        let result = editor(&window).state().evaluated.result.as_ref().unwrap();
        assert_eq!((result.frame, result.picture.planes.len(), &result.screen), (frame, 3, &kept));
    }
    // Nothing is asked for again when nothing happens.
    let generation = editor(&window).state().evaluated.result.as_ref().unwrap().generation;
    window.run_steps(5);
    assert_eq!(editor(&window).state().evaluated.result.as_ref().unwrap().generation, generation);
    assert!(editor(&window).state().evaluated.progress.is_none());
}

#[test]
fn a_range_too_large_for_the_memory_is_played_all_the_same() {
    let mut window = slow(dusk(), 5);
    window.state_mut().as_mut().unwrap().room = 1;
    ask(&mut window, Action::Play(true));
    let count = 2 * FRAMES as usize + 3;
    assert_eq!(follow(&mut window, count), wanted(1, (1, FRAMES), count));
    assert!(editor(&window).state().evaluated.frames.len() <= 2);
}

#[test]
fn an_edit_while_frames_are_played_shows_in_those_that_follow() {
    let mut window = slow(dusk(), 10);
    ask(&mut window, Action::Play(true));
    follow(&mut window, 4);
    let edit = Edit::set(Path::node("dusk").to("weight"), &json!(0.75));
    ask(&mut window, Action::Edit(edit));
    let revision = editor(&window).state().session.revision();
    let from = shown(&window).unwrap();
    let frames = follow(&mut window, 12);
    assert_eq!(frames, wanted(from, (1, FRAMES), 12));
    assert_eq!(editor(&window).state().evaluated.result.as_ref().unwrap().subject.revision, revision);
    // Playback waits while the document has a fault.
    let broken = editor(&window).state().session.text().replace("\"sky\", \"b\"", "\"skyy\", \"b\"");
    ask(&mut window, Action::Rewrite(broken));
    finished(&mut window);
    window.run_steps(5);
    assert!(editor(&window).state().playing && editor(&window).state().evaluated.failed.is_some());
    ask(&mut window, Action::Undo);
    let from = editor(&window).state().frame;
    finished(&mut window);
    let frames = follow(&mut window, 5);
    assert_eq!(frames, wanted(frames[0], (1, FRAMES), 5));
    assert!(wanted(from, (1, FRAMES), 2).contains(&frames[0]), "playback continues where it was");
}

#[test]
fn a_frame_that_fails_ends_playback_and_says_why() {
    let folder = tempfile::tempdir().unwrap();
    for frame in [1, 2, 4, 5] {
        let name = format!("plate.{frame:04}.png");
        image::RgbImage::from_pixel(4, 4, image::Rgb([40 * frame as u8; 3])).save(folder.path().join(name)).unwrap();
    }
    let read = r#"{ "type": "Read", "as": "color", "fit": "nearest", "file": "plate.####.png" }"#;
    let text = DUSK.replace(r#"{ "type": "ScreenY" }"#, read).replace("\"color\": \"dusk\"", "\"color\": \"down\"");
    let text = text.replace("\"weight\": \"down\"", "\"weight\": 0.5");
    let file = folder.path().join("dusk.json");
    std::fs::write(&file, text).unwrap();
    let mut window = slow(Session::open(&file).unwrap(), 5);
    ask(&mut window, Action::Play(true));
    crate::testing::until(&mut window, "the end", |editor| !editor.state().playing);
    let state = editor(&window).state();
    assert_eq!(state.frame, 3);
    let why = state.evaluated.failed.clone().unwrap();
    assert!(why.contains("plate.0003.png"), "{why}");
    assert_eq!(state.evaluated.last.as_ref().map(|last| last.frame), Some(2), "the last picture stays in sight");
    ask(&mut window, Action::Frame(4));
    finished(&mut window);
    assert_eq!((shown(&window), editor(&window).state().evaluated.last.is_none()), (Some(4), true));
}

#[test]
fn a_range_of_one_frame_shows_that_frame() {
    let mut window = slow(dusk(), 0);
    ask(&mut window, Action::Range(3, 3));
    ask(&mut window, Action::Play(true));
    assert_eq!(follow(&mut window, 2), [1, 3]);
    window.run_steps(40);
    assert_eq!((shown(&window), editor(&window).state().playing), (Some(3), true));
}

#[test]
fn the_range_and_the_frame_may_change_while_frames_are_played() {
    let mut window = slow(dusk(), 8);
    ask(&mut window, Action::Play(true));
    follow(&mut window, 3);
    ask(&mut window, Action::Range(5, 7));
    let frames = follow(&mut window, 10);
    assert_eq!(frames[1..], wanted(5, (5, 7), 9));
    // No frame of this range is evaluated yet.
    ask(&mut window, Action::Range(20, 22));
    let frames = follow(&mut window, 8);
    assert_eq!(frames[1..], wanted(20, (20, 22), 7));
    ask(&mut window, Action::Range(1, FRAMES));
    ask(&mut window, Action::Frame(2));
    finished(&mut window);
    let frames = follow(&mut window, 10);
    assert_eq!(frames, wanted(frames[0], (1, FRAMES), 10));
    assert!(frames[0] == 2 || frames[0] == 3, "playback continues at the selected frame: {frames:?}");
}

#[test]
fn onion_skin_mixes_the_frames_that_are_ready_over_the_picture() {
    use egui_kittest::kittest::Queryable;
    let mut window = window(super::dusk(), None);
    finished(&mut window);
    let none = "Onion skin: no other frame is ready. Step through frames, or play.";
    assert!(window.query_by_label(none).is_none());
    window.get_by_label("Onion").click();
    window.run_steps(3);
    assert!(editor(&window).state().look.onion);
    window.get_by_label(none);
    window.key_press(egui::Key::ArrowRight);
    finished(&mut window);
    window.run_steps(2);
    assert!(window.query_by_label(none).is_none(), "the first frame is still there");
    // What is mixed over the picture is no part of it, and nothing is evaluated for it.
    let pixel = editor(&window).state().evaluated.result.as_ref().unwrap().screen.pixels[..3].to_vec();
    let frames = editor(&window).state().evaluated.frames.len();
    window.key_press_modifiers(egui::Modifiers::SHIFT, egui::Key::O);
    window.run_steps(3);
    let state = editor(&window).state();
    assert!(!state.look.onion && state.evaluated.frames.len() == frames);
    assert_eq!(state.evaluated.result.as_ref().unwrap().screen.pixels[..3].to_vec(), pixel);
    assert_eq!(state.range, (1, 8), "the keys did not set the end of the range");
}
