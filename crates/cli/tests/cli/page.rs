//! Recipes as pages.

use crate::scene::Scene;
use serde_json::Value;
use std::fs;

/// A picture of three colors, with two frames.
const SCENE: &str = r##"{ "trochoid": 1, "format": { "width": 40, "height": 30 }, "working_space": "srgb",
  "frames": { "first": 1, "last": 2 },
  "palette": { "night": "#101a33", "sun": "#f0cf8e", "foam": "#e8f4ff" },
  "nodes": { "x": { "type": "ScreenX" }, "y": { "type": "ScreenY" },
             "sky": { "type": "Mix", "a": "palette.night", "b": "palette.sun", "weight": "x" },
             "land": { "type": "Mix", "a": "sky", "b": "palette.foam", "weight": "y" } },
  "outputs": { "land": { "color": "land", "file": "land.####.png" } } }"##;

fn made() -> Scene {
    let scene = Scene::new(SCENE);
    scene.run(&["render", "a.json"]).code(0);
    let pictures = ["land.0001.png", "land.0002.png", "--palette", "a.json", "--out", "{name}.exr"];
    scene.run(&[&["decompose"][..], &pictures].concat()).code(0);
    scene
}

/// Returns what a page says of its pictures.
fn facts(scene: &Scene, name: &str) -> Value {
    let page = fs::read_to_string(scene.path(name)).unwrap();
    let (_, rest) = page.split_once("<script type=\"application/json\" id=\"data\">").unwrap();
    serde_json::from_str(rest.split_once("</script>").unwrap().0).unwrap()
}

#[test]
fn frames_and_palettes_are_on_one_page() {
    let scene = made();
    fs::write(scene.path("evening.json"), r##"{ "sun": "#ff8844" }"##).unwrap();
    let page = ["page", "land.####.exr", "--frames", "1-2", "--fps", "12", "--palette", "evening.json", "-o", "p.html"];
    let run = scene.run(&page).code(0);
    run.says(&["land: 2 frames, 40 × 30 pixels, 3 colors, within 0.", " of 255 → p.html  "]);
    let facts = facts(&scene, "p.html");
    let picture = &facts["pictures"][0];
    assert_eq!((&facts["title"], &facts["fps"], &picture["names"][1]), (&"land".into(), &12.0.into(), &"sun".into()));
    assert_eq!((picture["frames"].as_array().unwrap().len(), &picture["hasCube"]), (2, &true.into()));
    assert_eq!(facts["palettes"][0]["colors"][0]["color"]["shown"][0], 1.0);
    // Again, over the page that is there, and of files one by one; the same page.
    let before = fs::read(scene.path("p.html")).unwrap();
    let one_by_one = [&["page", "land.0001.exr", "land.0002.exr"][..], &page[4..]].concat();
    assert_eq!(scene.run(&[&one_by_one[..], &["--quiet"]].concat()).code(0).out, "");
    assert!(fs::read(scene.path("p.html")).unwrap() == before);
}

#[test]
fn other_files_are_pictures_of_their_own() {
    let scene = made();
    fs::copy(scene.path("land.0001.exr"), scene.path("sea.exr")).unwrap();
    let run = scene.run(&["page", "sea.exr", "land.0001.exr", "--width", "20", "--title", "A & <B>", "-o", "p.html"]);
    run.code(0).says(&["2 pictures, within "]);
    let facts = facts(&scene, "p.html");
    assert_eq!((&facts["pictures"][1]["name"], &facts["pictures"][0]["width"]), (&"land".into(), &20.into()));
    assert!(fs::read_to_string(scene.path("p.html")).unwrap().contains("<title>A &amp; &lt;B&gt;</title>"));
}

#[test]
fn renders_are_put_on_a_page_without_images() {
    let scene = made();
    scene.run(&["render", "a.json", "--recipe", "w.####.exr", "--overwrite"]).code(0);
    let run = scene.run(&["page", "w.####.exr", "--frames", "1-2", "-o", "p.html"]);
    run.code(0).says(&["w: 2 frames, 40 × 30 pixels, 3 colors"]);
    let reads = r##"{ "trochoid": 1, "format": { "width": 40, "height": 30 }, "working_space": "srgb",
      "nodes": { "in": { "type": "Read", "file": "land.0001.png", "as": "color" },
                 "mix": { "type": "Mix", "a": "in", "b": "#fff", "weight": 0.5 } },
      "outputs": { "x": { "color": "mix", "file": "x.png" } } }"##;
    fs::write(scene.path("i.json"), reads).unwrap();
    scene.run(&["render", "i.json", "--recipe", "i.exr"]).code(0);
    scene.run(&["page", "i.exr", "-o", "q.html"]).fails(2, &["i.exr: found pixels of images", "trochoid decompose"]);
}

#[test]
fn what_cannot_be_on_a_page_is_told() {
    let scene = made();
    let page = |more: &[&str]| scene.run(&[&["page"][..], more].concat());
    page(&["land.0001.exr", "-o", "p.png"]).fails(2, &["found the extension .png; expected .html"]);
    page(&["land.####.exr", "-o", "p.html"]).fails(2, &["land.####.exr", "a pattern without frames"]);
    page(&["land.0001.exr", "--frames", "1", "-o", "p.html"]).fails(2, &["--frames: found no ####"]);
    page(&["land.####.exr", "--frames", "1-3", "-o", "p.html"]).fails(1, &["land.0003.exr: cannot open the file"]);
    page(&["land.0001.png", "-o", "p.html"]).fails(2, &["a picture without weights", "trochoid decompose"]);
    page(&["land.0001.exr", "--fps", "0", "-o", "p.html"]).fails(2, &["expected a number from 1 to 120"]);
    page(&["land.0001.exr", "--palette", "none.json", "-o", "p.html"]).fails(1, &["none.json"]);
    fs::write(scene.path("n.json"), r##"{ "foma": "#fff" }"##).unwrap();
    page(&["land.0001.exr", "--palette", "n.json", "-o", "p.html"]).fails(2, &["\"foma\"", "did you mean \"foam\"?"]);
    fs::write(scene.path("p.html"), "theirs").unwrap();
    page(&["land.0001.exr", "-o", "p.html"]).fails(2, &["p.html"]);
    assert_eq!(fs::read_to_string(scene.path("p.html")).unwrap(), "theirs");
    // Frames of one picture are alike.
    fs::write(scene.path("b.json"), SCENE.replace("\"width\": 40", "\"width\": 44").replace("\"land.", "\"wide."))
        .unwrap();
    scene.run(&["render", "b.json", "--frames", "2"]).code(0);
    scene.run(&["decompose", "wide.0002.png", "--palette", "a.json", "--out", "land.0003.exr"]).code(0);
    page(&["land.0001.exr", "land.0003.exr", "-o", "q.html"])
        .fails(2, &["land.0003.exr: found 44 × 30 pixels; expected 40 × 30 pixels"]);
    assert!(!scene.path("q.html").exists());
}
