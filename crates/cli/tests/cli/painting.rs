//! Palettes that are read off pictures.

use crate::scene::Scene;
use serde_json::Value;
use std::fs;
use trochoid::io::{PngImage, Samples, write_png8};

/// A picture of a sunset: mixes of four colors, in steps of 8 bits.
const SUNSET: &str = r##"{ "trochoid": 1, "format": { "width": 48, "height": 32 }, "working_space": "srgb",
  "palette": { "night": "#101a33", "dusk": "#5a3f5e", "sun": "#f0cf8e", "foam": "#e8f4ff" },
  "nodes": { "x": { "type": "ScreenX" }, "y": { "type": "ScreenY" },
             "sky": { "type": "Mix", "a": "palette.dusk", "b": "palette.sun", "weight": "x" },
             "sea": { "type": "Mix", "a": "palette.night", "b": "palette.foam", "weight": "x" },
             "all": { "type": "Mix", "a": "sky", "b": "sea", "weight": "y" } },
  "outputs": { "all": { "color": "all", "file": "sunset.png" } } }"##;

#[test]
fn a_palette_is_read_off_a_picture_and_used_by_a_document() {
    let scene = Scene::new(SUNSET);
    scene.run(&["render", "a.json"]).code(0);
    let out = ["--out", "p.json", "--out", "p.gpl", "--out", "p.png"];
    let run = scene.run(&[&["palette", "sunset.png"][..], &out].concat()).code(0);
    let run = run.says(&["colors in 1 picture of 1536 pixels", "  colors   hull  farthest"]);
    let palette: Value = serde_json::from_slice(&fs::read(scene.path("p.json")).unwrap()).unwrap();
    let colors = palette["palette"].as_object().unwrap();
    assert!((4..=6).contains(&colors.len()), "{palette}");
    for (name, color) in colors {
        assert!(run.out.contains(&format!("{name} ")) && run.out.contains(color.as_str().unwrap()), "{name}");
    }
    // A document takes it as it is, from either file.
    for file in ["p.json", "p.gpl"] {
        let document = SUNSET.replace("{ \"night\"", "\"FILE\" , \"notes\": { \"night\"").replace("FILE", file);
        let first = colors.keys().next().unwrap();
        let names = ["night", "dusk", "sun", "foam"];
        let named = names
            .iter()
            .fold(document, |text, name| text.replace(&format!("palette.{name}"), &format!("palette.{first}")));
        fs::write(scene.path("b.json"), named).unwrap();
        scene.run(&["check", "b.json"]).code(0);
    }
    let swatches = trochoid::io::info(scene.path("p.png"), &Default::default()).unwrap();
    assert_eq!(swatches.parts[0].display.width(), 128 * colors.len());
    // Files of ours are replaced, others are not.
    scene.run(&[&["palette", "sunset.png", "--quiet"][..], &out].concat()).code(0);
    fs::write(scene.path("p.gpl"), "GIMP Palette\n1 2 3 mine\n").unwrap();
    scene.run(&["palette", "sunset.png", "--out", "p.gpl"]).fails(2, &["p.gpl"]);
    scene.run(&["palette", "sunset.png", "--out", "sunset.png"]).fails(2, &["sunset.png"]);
}

#[test]
fn every_pixel_lies_in_the_hull_of_the_palette() {
    let scene = Scene::new(SUNSET);
    scene.run(&["render", "a.json"]).code(0);
    let json = scene.run(&["palette", "sunset.png", "--json"]).code(0).json();
    let picture = trochoid::io::read(scene.path("sunset.png"), &Default::default(), &Default::default()).unwrap();
    let [r, g, b] = [0, 1, 2].map(|c| picture.channels[c].plane.samples());
    for palette in json["enclosing"].as_array().unwrap() {
        let colors: Vec<[f32; 3]> = serde_json::from_value::<Vec<[f64; 3]>>(palette["colors"].clone())
            .unwrap()
            .into_iter()
            .map(|color| color.map(|v| v as f32))
            .collect();
        let hull = trochoid::Hull::new(&colors);
        for ((r, g), b) in r.iter().zip(g).zip(b) {
            let point = [f64::from(*r), f64::from(*g), f64::from(*b)];
            assert!(hull.signed_distance(point) < 1e-6, "{point:?} outside of {palette}");
        }
    }
    let parts = scene.run(&["palette", "sunset.png", "--region", "0,0,8,4", "--json"]).code(0).json();
    assert_eq!((parts["pixels"].as_u64(), json["pixels"].as_u64()), (Some(32), Some(1536)));
}

#[test]
fn what_cannot_be_done_is_told_before_anything_is_read() {
    let scene = Scene::new(SUNSET);
    scene.run(&["palette"]).fails(2, &["<PICTURE>..."]);
    scene.run(&["palette", "none.png"]).fails(1, &["none.png"]);
    scene.run(&["palette", "none.png", "--out", "p.txt"]).fails(2, &["expected .json, .gpl or .png"]);
    scene.run(&["palette", "none.png", "--region", "1,2,3"]).fails(2, &["--region", "expected four whole numbers"]);
    scene.run(&["palette", "a.json"]).fails(1, &["a.json"]);
    let gray: Vec<[f32; 3]> = (0..64).map(|v| [v as f32 / 255.0; 3]).collect();
    write_png8(scene.path("gray.png"), &PngImage::new(8, 8, Samples::rgb(&gray))).unwrap();
    scene.run(&["palette", "gray.png"]).code(0).says(&["64 colors", "#000000", "#3f3f3f"]);
    let words = ["found no palette of 5 colors that encloses every pixel; expected one of 2 colors"];
    scene.run(&["palette", "gray.png", "--colors", "5"]).fails(3, &words);
    scene.run(&["palette", "gray.png", "--region", "9,9,4,4"]).fails(2, &["none of them in a --region"]);
}

#[test]
fn stray_pixels_may_be_left_out() {
    let scene = Scene::new(SUNSET);
    scene.run(&["render", "a.json"]).code(0);
    let picture = trochoid::io::read(scene.path("sunset.png"), &Default::default(), &Default::default()).unwrap();
    let [r, g, b] = [0, 1, 2].map(|c| picture.channels[c].plane.samples());
    let mut pixels: Vec<[f32; 3]> = (0..r.len()).map(|at| [r[at], g[at], b[at]]).collect();
    pixels[700] = [0.0, 1.0, 0.0];
    write_png8(scene.path("stray.png"), &PngImage::new(48, 32, Samples::rgb(&pixels))).unwrap();
    let all = scene.run(&["palette", "stray.png", "--json"]).code(0).json();
    assert_eq!([&all["ignored"], &all["outside"]], [0, 0]);
    assert!(all["palette"].as_object().unwrap().values().any(|color| color == "#00ff00"), "{all}");
    let left = scene.run(&["palette", "stray.png", "--ignore", "0.001", "--json"]).code(0).json();
    assert_eq!([&left["ignored"], &left["outside"]], [1, 1]);
    assert!(left["outside_largest"].as_f64().unwrap() > 50.0, "{left}");
    let whole = scene.run(&["palette", "sunset.png", "--json"]).code(0).json();
    assert!(left["enclosing"][0]["volume"].as_f64().unwrap() < 1.5 * whole["enclosing"][0]["volume"].as_f64().unwrap());
    let words = ["1 pixel ignored; 1 pixel outside of this palette, by up to "];
    scene.run(&["palette", "stray.png", "--ignore", "0.001"]).code(0).says(&words);
    let nothing = scene.run(&["palette", "stray.png", "--ignore", "0.0001"]).code(0);
    assert!(!nothing.out.contains("ignored"), "{}", nothing.out);
    scene.run(&["palette", "stray.png", "--ignore", "0.5"]).fails(2, &["--ignore", "a number from 0 to 0.1"]);
}

#[test]
fn pixels_may_lie_a_little_outside() {
    let scene = Scene::new(SUNSET);
    scene.run(&["render", "a.json"]).code(0);
    let found = |within: &str| scene.run(&["palette", "sunset.png", "--within", within, "--json"]).code(0).json();
    let (least, some, all) = (found("0"), found("3"), found("255"));
    let count = |json: &Value| json["palette"].as_object().unwrap().len();
    assert!(count(&some) < count(&least) && count(&all) == 1, "{some}");
    assert_eq!(count(&least), least["enclosing"][0]["colors"].as_array().unwrap().len());
    let largest = some["outside_largest"].as_f64().unwrap();
    assert!(largest > 0.0 && largest <= 3.0 && least["outside"] == 0, "{some}");
    assert_eq!(
        [&some["enclosing"][0]["outside"], &some["enclosing"][0]["largest"]],
        [&some["outside"], &some["outside_largest"]]
    );
    let words = ["outside of this palette, by up to ", "% of the pixels are outside, by up to "];
    scene.run(&["palette", "sunset.png", "--within", "3"]).code(0).says(&words);
    for wrong in ["-1", "256", "NaN", "x"] {
        let option = format!("--within={wrong}");
        scene.run(&["palette", "sunset.png", &option]).fails(2, &["--within", "a number of steps from 0 to 255"]);
    }
}

#[test]
fn prior_colors_are_kept() {
    let scene = Scene::new(SUNSET);
    scene.run(&["render", "a.json"]).code(0);
    fs::write(scene.path("own.json"), r##"{ "night": "#0f1932", "gray": "#808080" }"##).unwrap();
    let run = scene.run(&["palette", "sunset.png", "--prior", "own.json", "--out", "p.json"]).code(0);
    run.says(&["night  ", "#0f1932  prior\n", "#808080  prior, in the hull of the others\n"]);
    let palette: Value = serde_json::from_slice(&fs::read(scene.path("p.json")).unwrap()).unwrap();
    assert_eq!([&palette["palette"]["night"], &palette["palette"]["gray"]], ["#0f1932", "#808080"]);
    // Once all are there, nothing is added.
    let again = ["palette", "sunset.png", "--prior", "p.json", "--json"];
    let again = scene.run(&again).code(0).json();
    assert_eq!(again["palette"], palette["palette"]);
    assert_eq!(
        (&again["outside"], again["prior"].as_u64()),
        (&Value::from(0), Some(palette["palette"].as_object().unwrap().len() as u64))
    );
    scene.run(&["palette", "sunset.png", "--prior", "p.json", "--out", "p.json"]).fails(2, &["p.json: is an input"]);
    fs::write(scene.path("loud.json"), r##"{ "glow": [1.5, 0.2, 0.1] }"##).unwrap();
    scene.run(&["palette", "sunset.png", "--prior", "loud.json"]).fails(2, &["loud.json: glow: found [1.5,"]);
    scene.run(&["palette", "sunset.png", "--prior", "none.json"]).fails(1, &["none.json: cannot open the file"]);
}

#[test]
fn colors_are_taken_off_regions_and_their_corners() {
    let scene = Scene::new(SUNSET);
    scene.run(&["render", "a.json"]).code(0);
    let regions = ["--region", "left=0,0,24,32", "--region", "24,0,24,32"];
    let run = |more: &[&str]| scene.run(&[&["palette", "sunset.png"], &regions[..], more].concat());
    run(&["--by-region", "--out", "r.json"])
        .code(0)
        .says(&["pixels outside of this palette, by up to ", "left_top_left_light  "]);
    let palette: Value = serde_json::from_slice(&fs::read(scene.path("r.json")).unwrap()).unwrap();
    let colors = palette["palette"].as_object().unwrap();
    assert_eq!(colors.len(), 20);
    let color = |name: &str| u32::from_str_radix(&colors[name].as_str().unwrap()[1..], 16).unwrap();
    let light = |name: &str| (color(name) >> 16) + (color(name) >> 8 & 255) + (color(name) & 255);
    assert!(light("left_light") > light("left_dark") && light("region_2_light") > light("left_light"));
    assert!(light("left_bottom_left_dark") < light("left_top_right_dark"));
    let both = run(&["--prior", "r.json", "--json"]).code(0).json();
    assert_eq!((&both["outside"], &both["prior"]), (&Value::from(0), &Value::from(20)));
    let none = ["palette", "sunset.png", "--by-region"];
    scene.run(&none).fails(2, &["--region"]);
    run(&["--by-region", "--colors", "5"]).fails(2, &["cannot be used with"]);
    run(&["--region", "left=0,0,1,1", "--by-region"]).fails(2, &["--region left=…: found two regions of this name"]);
    scene.run(&["palette", "sunset.png", "--region", "a b=0,0,1,1"]).fails(2, &["--region", "a name of letters"]);
}

#[test]
fn sequences_have_one_palette() {
    let scene = Scene::new(SUNSET);
    scene.run(&["render", "a.json", "--frames", "1", "--out", "s.####.png"]).code(0);
    scene.run(&["render", "a.json", "--frames", "2", "--out", "s.####.png", "--set", "palette.sun=#ff0000"]).code(0);
    let both = scene.run(&["palette", "s.####.png", "--frames", "1-2", "--json"]).code(0).json();
    let listed = scene.run(&["palette", "s.0001.png", "s.0002.png", "--json"]).code(0).json();
    assert_eq!(both, listed);
    assert_eq!(both["pixels"], 2 * 1536);
    scene.run(&["palette", "s.####.png"]).fails(2, &["s.####.png: found a sequence", "--frames 1-96"]);
    scene.run(&["palette", "s.####.png", "--frames", "1-3"]).fails(1, &["s.0003.png"]);
    scene.run(&["palette", "s.0001.png", "--frames", "1-3"]).fails(2, &["expected a place for the frame"]);
    scene.run(&["palette", "s.####.png", "--frames", "3-1"]).fails(2, &["--frames: found \"3-1\""]);
}

/// Writes a PNG with 8 bits a channel, with as many channels as `color` has.
fn plain_png(path: std::path::PathBuf, color: png::ColorType, width: u32, bytes: &[u8]) {
    let mut encoder = png::Encoder::new(fs::File::create(path).unwrap(), width, 1);
    encoder.set_color(color);
    encoder.write_header().unwrap().write_image_data(bytes).unwrap();
}

#[test]
fn transparent_pixels_are_left_out() {
    let scene = Scene::new(SUNSET);
    let pixels = [0, 255, 0, 0, 255, 0, 255, 0, 10, 20, 30, 1, 200, 100, 50, 255];
    plain_png(scene.path("rgba.png"), png::ColorType::Rgba, 4, &pixels);
    let json = scene.run(&["palette", "rgba.png", "--json"]).code(0).json();
    assert_eq!((&json["pixels"], &json["transparent"]), (&Value::from(2), &Value::from(2)));
    let colors: Vec<&str> =
        json["palette"].as_object().unwrap().values().map(|color| color.as_str().unwrap()).collect();
    assert_eq!(colors, ["#0a141e", "#c86432"]);
    scene.run(&["palette", "rgba.png"]).code(0).says(&["2 pixels transparent, and left out"]);
    plain_png(scene.path("gray.png"), png::ColorType::GrayscaleAlpha, 3, &[9, 255, 100, 255, 250, 0]);
    let gray = scene.run(&["palette", "gray.png", "--json"]).code(0).json();
    assert_eq!(gray["enclosing"][0]["colors"].as_array().unwrap().len(), 2);
    plain_png(scene.path("clear.png"), png::ColorType::Rgba, 1, &[9, 9, 9, 0]);
    scene.run(&["palette", "clear.png"]).fails(2, &["found no pixel that is not transparent"]);
    let part = ["palette", "rgba.png", "--region", "0,0,2,1"];
    scene.run(&part).fails(2, &["none of them in a --region that are not transparent"]);
}

#[test]
fn pictures_of_few_colors_have_as_many() {
    let scene = Scene::new(SUNSET);
    let colors = |bytes: &[u8], more: &[&str]| {
        plain_png(scene.path("few.png"), png::ColorType::Rgb, bytes.len() as u32 / 3, bytes);
        let json = scene.run(&[&["palette", "few.png", "--json"], more].concat()).code(0).json();
        assert_eq!(json["outside"], 0, "{json}");
        json["palette"].as_object().unwrap().len()
    };
    assert_eq!(colors(&[7, 8, 9], &[]), 1);
    assert_eq!(colors(&[7, 8, 9, 7, 8, 9], &[]), 1);
    assert_eq!(colors(&[7, 8, 9, 100, 20, 9], &[]), 2);
    assert_eq!(colors(&[7, 8, 9, 100, 20, 9, 3, 3, 3], &[]), 3);
    assert_eq!(colors(&[7, 8, 9, 100, 20, 9, 3, 3, 3, 255, 0, 255], &[]), 4);
    assert_eq!(colors(&[0, 0, 0, 255, 255, 255, 9, 9, 9], &[]), 2);
    for more in [["--within", "0"], ["--within", "0.5"], ["--ignore", "0.1"]] {
        assert_eq!(colors(&[7, 8, 9], &more), 1, "{more:?}");
        assert_eq!(colors(&[7, 8, 9, 100, 20, 9], &more), 2, "{more:?}");
    }
    fs::write(scene.path("own.json"), r##"{ "own": "#070809" }"##).unwrap();
    assert_eq!(colors(&[7, 8, 9], &["--prior", "own.json"]), 1);
    assert_eq!(colors(&[7, 8, 9, 100, 20, 9], &["--prior", "own.json"]), 2);
    assert_eq!(colors(&[1, 1, 1, 250, 250, 250], &["--prior", "own.json"]), 3);
    assert_eq!(colors(&[7, 8, 9, 100, 20, 9], &["--region", "0,0,2,1", "--by-region"]), 10);
}

#[test]
fn light_beyond_white_and_values_that_are_no_light() {
    let scene = Scene::new(SUNSET);
    let exr = |values: [f32; 3]| {
        let window = trochoid::Window::sized(3, 1);
        let plane = trochoid::Plane::new(window, values.to_vec()).unwrap();
        let channel = |name| trochoid::io::ExrChannel::float(name, Samples::plane(&plane));
        let channels = ["R", "G", "B"].map(channel).into();
        let image = trochoid::io::ExrImage { channels, ..trochoid::io::ExrImage::new(window) };
        trochoid::io::write_exr(scene.path("a.exr"), &image).unwrap();
    };
    exr([0.0, 0.25, 8.0]);
    let json = scene.run(&["palette", "a.exr", "--json"]).code(0).json();
    assert_eq!((&json["brighter"], &json["outside"]), (&Value::from(1), &Value::from(0)));
    scene.run(&["palette", "a.exr"]).code(0).says(&["1 pixel brighter than white, and white there", "#ffffff"]);
    for bad in [f32::NAN, f32::INFINITY, -0.5] {
        exr([0.0, bad, 1.0]);
        scene.run(&["palette", "a.exr"]).fails(1, &["a.exr", "expected a finite number, at least 0"]);
    }
}

#[test]
fn a_page_shows_the_palette_without_other_files() {
    let scene = Scene::new(SUNSET);
    scene.run(&["render", "a.json", "--out", "a<b>.png"]).code(0);
    let write = |more: &[&str]| scene.run(&[&["palette", "a<b>.png", "--report", "p.html"], more].concat());
    let json = write(&["--json"]).code(0).json();
    let page = fs::read_to_string(scene.path("p.html")).unwrap();
    for (name, color) in json["palette"].as_object().unwrap() {
        assert!(
            page.contains(&format!("<b>{}</b>", name.replace('_', "_<wbr>"))) && page.contains(color.as_str().unwrap()),
            "{name}"
        );
    }
    let words =
        ["Palette of a&lt;b&gt;.png", "none lies outside of their hull", "data:image/png;base64,", "<table>", "<svg"];
    words.iter().for_each(|word| assert!(page.contains(word), "{word}"));
    assert!(!page.contains("http") && !page.contains("src=\"/"), "other files");
    let start = page.find("id=\"space\">").unwrap() + "id=\"space\">".len();
    let data: Value = serde_json::from_str(&page[start..start + page[start..].find("</script>").unwrap()]).unwrap();
    assert_eq!(data["colors"].as_array().unwrap().len(), json["palette"].as_object().unwrap().len());
    assert!(data["edges"].as_array().unwrap().len() >= 6 && data["outside"] == serde_json::json!([]), "{data}");
    let shares: Vec<f64> =
        page.split(" % of the picture").map(|text| text.rsplit('>').next().unwrap().parse().unwrap_or(0.0)).collect();
    assert!((shares.iter().sum::<f64>() - 100.0).abs() < 0.3, "{shares:?}");
    // Again, and what lies outside.
    write(&["--within", "3"]).code(0);
    assert!(fs::read_to_string(scene.path("p.html")).unwrap().contains("of the pixels lie outside of their hull, by "));
    write(&["--region", "0,0,9,9", "--by-region"]).code(0);
    fs::write(scene.path("p.html"), "<p>mine</p>").unwrap();
    write(&[]).fails(2, &["p.html"]);
    scene.run(&["palette", "a<b>.png", "--report", "p.txt"]).fails(2, &["--report", "expected .html"]);
}
