use super::lens::lens;
use super::shown::{range, screen, turbo};
use super::{Channel, Display, Graphics, Job, Lane, News, Subject, Worker};
use crate::document::{Session, Sheet};
use std::path::{Path, PathBuf};
use std::sync::Arc;
use std::time::Duration;
use trochoid::{Access, Kind};

const SCENE: &str = r##"{
  "trochoid": 1,
  "format": { "width": 64, "height": 32, "samples": 4 },
  "working_space": "srgb",
  "nodes": {
    "eye": { "type": "Camera", "position": [0, 6, 20], "target": [0, 0, 0] },
    "storm": { "type": "GerstnerSea", "count": 40, "height": 2 },
    "view": { "type": "Render", "camera": "eye", "surfaces": ["storm"] },
    "depth": { "type": "Depth", "view": "view" },
    "far": { "type": "Clamp", "field": "depth", "min": 10, "max": 60 },
    "sea": { "type": "Mix", "a": "#102030", "b": "#8090a0", "weight": "far" },
    "broken": { "type": "Mix", "a": "nothing", "b": "sea", "weight": 0.5 }
  },
  "outputs": { "beauty": { "color": "sea" } }
}"##;

fn sheet() -> Arc<Sheet> {
    Session::new(SCENE.into(), None).sheet().clone()
}

fn subject(sheet: &Arc<Sheet>, node: &str, output: usize) -> Subject {
    Subject {
        root: sheet.clone(),
        sheet: sheet.clone(),
        revision: 1,
        node: sheet.find(node).unwrap(),
        output,
        name: "test".into(),
        folder: PathBuf::new(),
        access: Access::usual(Path::new("")),
    }
}

fn job(sheet: &Arc<Sheet>, node: &str, generation: u64) -> Job {
    Job {
        generation,
        subject: subject(sheet, node, 0),
        frame: 1,
        proxy: 1,
        region: None,
        display: Display::default(),
        progressive: true,
    }
}

fn next(worker: &Worker) -> News {
    worker.wait(Duration::from_secs(60)).expect("news within a minute")
}

#[test]
fn every_kind_of_node_is_seen_and_faults_elsewhere_do_not_matter() {
    let sheet = sheet();
    let look = |name: &str| lens(&subject(&sheet, name, 0));
    assert_eq!(look("sea").unwrap().graph.outputs()[0].kind, Kind::Color);
    assert_eq!(look("far").unwrap().graph.outputs()[0].kind, Kind::MASK);
    let field = look("depth").unwrap();
    assert!(!field.clay);
    assert_eq!(field.graph.outputs()[0].kind, Kind::Field(1));
    for solid in ["storm", "view"] {
        let clay = look(solid).unwrap();
        assert!(clay.clay, "{solid} is lit like clay");
    }
    assert!(look("eye").unwrap_err().to_string().contains("a Camera is not a picture"));
    let fault = look("broken").unwrap_err().to_string();
    assert!(fault.starts_with("broken, a: found") && fault.contains("nothing"), "{fault}");
}

#[test]
fn a_coarse_picture_comes_first_and_the_last_is_whole() {
    let worker = Worker::new(&Graphics::default(), || ()).unwrap();
    worker.evaluate(job(&sheet(), "sea", 5), false);
    let mut sizes = Vec::new();
    loop {
        if let News::Picture(result) = next(&worker) {
            assert_eq!(result.generation, 5);
            assert_eq!(result.screen.size, [result.format.width() as usize, result.format.height() as usize]);
            assert_eq!(result.picture.audit.hull_exits, 0);
            sizes.push((result.format.width(), result.format.samples(), result.finished));
            if result.finished {
                break;
            }
        }
    }
    assert_eq!(sizes.first(), Some(&(8, 1, false)));
    assert_eq!(sizes.last(), Some(&(64, 4, true)));
}

#[test]
fn the_newest_request_is_answered_in_the_end() {
    let sheet = sheet();
    let worker = Worker::new(&Graphics::default(), || ()).unwrap();
    for generation in 1..=30 {
        let name = if generation % 2 == 0 { "sea" } else { "depth" };
        worker.evaluate(job(&sheet, name, generation), false);
    }
    let last = loop {
        match next(&worker) {
            News::Picture(result) if result.finished && result.generation == 30 => break result,
            News::Failed { why, .. } => panic!("{why}"),
            _ => {}
        }
    };
    assert_eq!(last.picture.kind, Kind::Color);
}

#[test]
fn a_part_of_the_picture_is_that_part() {
    let sheet = sheet();
    let worker = Worker::new(&Graphics::default(), || ()).unwrap();
    let picture = |region: Option<[f32; 4]>, generation: u64| {
        worker.evaluate(Job { region, progressive: false, ..job(&sheet, "sea", generation) }, false);
        loop {
            match next(&worker) {
                News::Picture(result) if result.finished && result.generation == generation => break result.picture,
                _ => {}
            }
        }
    };
    let (whole, part) = (picture(None, 1), picture(Some([0.25, 0.5, 0.5, 1.0]), 2));
    let window = part.planes[0].window();
    assert_eq!((window.x0, window.y0, window.x1, window.y1), (16, 16, 32, 32));
    for (x, y) in [(16, 16), (31, 31), (20, 25)] {
        assert_eq!(part.planes[0].nearest(x, y).to_bits(), whole.planes[0].nearest(x, y).to_bits());
    }
    let tiny = picture(Some([0.999, 0.999, 0.9995, 1.0]), 3);
    assert_eq!(tiny.planes[0].samples().len(), 1, "at least a pixel");
}

#[test]
fn thumbnails_of_all_nodes_come_at_once() {
    let valid = SCENE.replace("\"nothing\"", "\"#ffffff\"");
    let sheet = Session::new(valid, None).sheet().clone();
    let worker = Worker::new(&Graphics::default(), || ()).unwrap();
    worker.thumbnails(subject(&sheet, "sea", 0), 1);
    let News::Thumbnails(all) = next(&worker) else { panic!("something else") };
    let names: Vec<&str> = all.iter().map(|one| one.node.as_str()).collect();
    assert_eq!(names, ["depth", "far", "sea", "broken"]);
    assert!(all.iter().all(|one| one.screen.size[0] > 0 && one.screen.size[0] <= 128));
}

#[test]
fn a_picture_is_shown_as_asked() {
    let worker = Worker::new(&Graphics::default(), || ()).unwrap();
    worker.evaluate(Job { progressive: false, ..job(&sheet(), "sea", 1) }, false);
    let result = loop {
        if let News::Picture(result) = next(&worker) {
            break result;
        }
    };
    let space = result.lens.graph.space();
    let at = |display: &Display, x: usize| {
        let shown = screen(&result.picture, space, display);
        [0, 1, 2].map(|channel| shown.pixels[4 * x + channel])
    };
    let plain = at(&Display::default(), 5);
    let exact = [0, 1, 2].map(|c| (result.picture.planes[c].samples()[5] * 255.0).round() as i32);
    for (shown, exact) in plain.iter().zip(exact) {
        assert!((i32::from(*shown) - exact).abs() <= 1, "{plain:?} {exact:?}");
    }
    let red = at(&Display { channel: Channel::One(0), ..Display::default() }, 5);
    assert!(red[0] == red[1] && red[0].abs_diff(plain[0]) <= 1);
    let brighter = at(&Display { exposure: 1.0, ..Display::default() }, 5);
    assert!(brighter.iter().zip(plain).all(|(b, a)| *b >= a) && brighter != plain);
    let fixed = Display { range: Some([0.0, 2.0]), ..Display::default() };
    assert_eq!(range(&result.picture, &fixed), [0.0, 1.0], "colors ignore the range");
    assert!(turbo(0.0)[2] > turbo(0.0)[1] && turbo(1.0)[0] > turbo(1.0)[2], "from blue to red");
}

#[test]
fn every_channel_of_a_gray_is_as_bright_as_the_gray() {
    for space in ["linear-srgb", "srgb", "acescg"] {
        let text = SCENE.replace("\"srgb\"", &format!("\"{space}\"")).replace("#102030", "#808080");
        let text = text.replace("#8090a0", "#808080");
        let sheet = Session::new(text, None).sheet().clone();
        let worker = Worker::new(&Graphics::default(), || ()).unwrap();
        worker.evaluate(Job { progressive: false, ..job(&sheet, "sea", 1) }, false);
        let result = loop {
            match next(&worker) {
                News::Picture(result) => break result,
                News::Failed { why, .. } => panic!("{why}"),
                _ => {}
            }
        };
        let space = result.lens.graph.space();
        for (exposure, gamma) in [(0.0, 1.0), (1.0, 1.0), (-1.5, 1.0), (0.0, 2.2), (0.7, 0.6)] {
            let of = |channel: Channel| {
                let display = Display { channel, exposure, gamma, range: Some([0.0, 9.0]), ..Display::default() };
                screen(&result.picture, space, &display).pixels[..3].to_vec()
            };
            let all = of(Channel::All);
            if (exposure, gamma) == (0.0, 1.0) {
                assert_eq!(all, [128; 3], "{space:?}");
            }
            for channel in [Channel::One(0), Channel::One(1), Channel::One(2), Channel::Luminance] {
                assert_eq!(of(channel), all, "{channel:?} in {space:?} at {exposure} EV, gamma {gamma}");
            }
        }
    }
}

#[test]
fn the_first_viewer_goes_before_the_second_which_goes_on_afterwards() {
    let sheet = sheet();
    let worker = Worker::new(&Graphics::default(), || ()).unwrap();
    worker.slow_down(Duration::from_millis(300));
    let plain = |node: &str, generation| Job { progressive: false, ..job(&sheet, node, generation) };
    worker.evaluate(plain("far", Lane::SECOND), false);
    // The second viewer's picture is under way.
    std::thread::sleep(Duration::from_millis(50));
    worker.evaluate(plain("sea", 1), false);
    let mut order = Vec::new();
    while order.len() < 2 {
        if let News::Picture(result) = next(&worker) {
            order.push(result.generation);
        }
    }
    assert_eq!(order, [1, Lane::SECOND]);
    // A newer request of either cancels its own picture alone.
    worker.evaluate(plain("far", Lane::SECOND + 1), false);
    std::thread::sleep(Duration::from_millis(50));
    worker.evaluate(plain("sea", 2), false);
    worker.evaluate(plain("depth", Lane::SECOND + 2), false);
    worker.evaluate(plain("far", 3), false);
    let mut order = Vec::new();
    while order.len() < 2 {
        if let News::Picture(result) = next(&worker) {
            order.push(result.generation);
        }
    }
    assert_eq!(order, [3, Lane::SECOND + 2]);
    // What is stopped stays so.
    worker.evaluate(plain("far", Lane::SECOND + 3), false);
    worker.stop(Lane::Second);
    worker.evaluate(plain("sea", 4), false);
    assert!(
        matches!(next(&worker), News::Picture(result) if result.generation == 4) || {
            // Progress may be told before.
            let mut found = None;
            while found.is_none() {
                if let News::Picture(result) = next(&worker) {
                    found = Some(result.generation);
                }
            }
            found == Some(4)
        }
    );
    assert!(worker.wait(Duration::from_millis(600)).is_none());
}
