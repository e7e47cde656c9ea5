//! Contact sheets.

use crate::scene::{SCENE, Scene};
use crate::told::Told;
use std::fs;
use trochoid::Plane;

/// Returns the red channel of a PNG.
fn red(scene: &Scene, file: &str) -> Plane {
    let selection = trochoid::io::Selection::channels(["R"]);
    trochoid::io::read(scene.path(file), &selection, &Default::default()).unwrap().channels.remove(0).plane
}

/// Counts the columns of pixels, each of `height`, that are wholly black or white.
fn has_picture(sheet: &Plane, [x, y]: [usize; 2], [width, height]: [usize; 2]) -> bool {
    let at = |x: usize, y: usize| sheet.samples()[y * sheet.window().width() + x];
    (0..height).all(|row| at(x, y + row) < 0.01 && at(x + width - 1, y + row) > 0.99)
}

#[test]
fn frames_values_and_documents_stand_side_by_side() {
    let scene = Scene::new(SCENE);
    let sheet = |arguments: &[&str]| scene.run(&[&["sheet"], arguments].concat()).code(0);
    sheet(&["a.json", "-o", "frames.png"]).says(&["3 pictures → frames.png  "]);
    let frames = red(&scene, "frames.png");
    let [width, height] = [frames.window().width(), frames.window().height()];
    // Pictures of 16 × 8 pixels, which are not enlarged; below each is room for its caption.
    let found: Vec<[usize; 2]> = (0..height - 8)
        .flat_map(|y| (0..width - 16).map(move |x| [x, y]))
        .filter(|corner| has_picture(&frames, *corner, [16, 8]))
        .collect();
    assert_eq!(found.len(), 3, "{found:?}");
    assert!(found[0][1] > 20, "a title");
    // Values are rows where there are several frames.
    fs::create_dir(scene.path("more")).unwrap();
    fs::copy(scene.path("a.json"), scene.path("more/b.json")).unwrap();
    let run = sheet(&["a.json", "more/b.json", "--wedge", "mix.a=#000,#888", "--frames", "1,3", "-o", "new/all.png"]);
    run.says(&["8 pictures → new/all.png"]);
    let all = red(&scene, "new/all.png");
    assert!(all.window().width() < 80 && all.window().height() > 200, "two columns, four rows");
    let run = sheet(&["a.json", "--frames", "1-3", "--columns", "1", "--width", "16", "-o", "frames.png", "--quiet"]);
    assert_eq!(run.out, "");
    assert!(red(&scene, "frames.png").window().height() > 100);
    assert_eq!(scene.files(), ["frames.png", "more/b.json", "new/all.png"]);
}

#[test]
fn a_field_is_shown_by_one_range_of_all_pictures() {
    let document = r##"{ "trochoid": 1, "format": { "width": 32, "height": 8 },
      "nodes": { "across": { "type": "ScreenX" },
                 "values": { "type": "FieldMath", "a": "across", "b": 0, "expression": "10 * b + a" },
                 "mix": { "type": "Mix", "a": "#000", "b": "#fff", "weight": "across" } },
      "outputs": { "beauty": { "color": "mix" } } }"##;
    let scene = Scene::new(document);
    let run = scene.run(&["sheet", "a.json", "--view", "values", "--wedge", "values.b=0,1", "-o", "x.png"]).code(0);
    run.says(&["from 0 (black) to 11 (white)"]);
    let sheet = red(&scene, "x.png");
    let brightest = sheet.samples().iter().filter(|value| **value > 0.999).count();
    assert!(brightest >= 8, "the last column of the second value is white");
    // Ramps of a range of their own would both reach white.
    let rows: Vec<&[f32]> = sheet.samples().chunks_exact(sheet.window().width()).collect();
    let ramps = rows.iter().filter(|row| row.iter().filter(|value| **value == 1.0).count() == 1).count();
    assert_eq!(ramps, 8, "rows with one white pixel");
}

#[test]
fn what_cannot_be_shown_is_told_at_once() {
    let (scene, mut told) = (Scene::new(SCENE), Told::new("sheet"));
    fs::write(scene.path("b.json"), "{}").unwrap();
    fs::write(scene.path("theirs.png"), "theirs").unwrap();
    let cases: [(&str, &[&str]); 7] = [
        ("no_png", &["a.json", "-o", "x.jpg"]),
        ("bad_document", &["a.json", "b.json", "-o", "x.png"]),
        ("unknown_output", &["a.json", "a.json", "--output", "beuty", "-o", "x.png"]),
        ("bad_wedge", &["a.json", "--wedge", "mix.a=#000,3,4", "-o", "x.png"]),
        ("no_wedge", &["a.json", "--wedge", "mix", "--frames", "y", "-o", "x.png"]),
        ("too_many", &["a.json", "--frames", "1-2000", "-o", "x.png"]),
        ("foreign", &["a.json", "-o", "theirs.png"]),
    ];
    for (name, arguments) in cases {
        told.is(name, 2, &scene, &[&["sheet"], arguments].concat());
    }
    told.is("onto_itself", 2, &scene, &["sheet", "a.json", "-o", "a.json", "--overwrite"]);
    told.ends();
    assert_eq!(scene.files(), ["b.json", "theirs.png"]);
}
