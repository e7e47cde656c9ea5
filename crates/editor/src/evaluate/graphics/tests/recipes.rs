//! Pictures that are painted from their recipes.

use super::super::conversion::Conversion;
use super::super::recipe::Recipes;
use super::{beyond_a_place, card};
use crate::evaluate::painter::Canvas;
use crate::evaluate::{Display, Painting, SharedRecipe};
use rand::RngExt;
use rand_pcg::Pcg64Mcg;
use std::path::Path;
use std::sync::Arc;
use trochoid::{Cache, PackedRecipe, Silent, parse};

/// The recipe of a picture that is no multiple of tiles in size, unless it is one pixel.
fn recipe(space: &str, size: [u32; 2]) -> SharedRecipe {
    let text = format!(
        r##"{{
          "trochoid": 1, "format": {{ "width": {}, "height": {} }}, "working_space": "{space}",
          "palette": {{ "a": "#101a33", "b": "#f2ead2", "c": "#d8513a", "d": "#208040", "e": "#808080", "f": "#c0ffee" }},
          "nodes": {{
            "across": {{ "type": "ScreenX" }}, "down": {{ "type": "ScreenY" }},
            "right": {{ "type": "Clamp", "field": "across", "min": 0.6, "max": 0.9 }},
            "ab": {{ "type": "Mix", "a": "palette.a", "b": "palette.b", "weight": "down" }},
            "cd": {{ "type": "Mix", "a": "palette.c", "b": "palette.d", "weight": "down" }},
            "abcd": {{ "type": "Mix", "a": "ab", "b": "cd", "weight": "right" }},
            "ef": {{ "type": "Mix", "a": "palette.e", "b": "palette.f", "weight": "across" }},
            "all": {{ "type": "Mix", "a": "abcd", "b": "ef", "weight": 0.25 }}
          }},
          "outputs": {{ "beauty": {{ "color": "all" }} }}
        }}"##,
        size[0], size[1]
    );
    let graph = parse("a.json", &text, Path::new("."), &[]).unwrap().graph;
    let made = PackedRecipe::evaluate(&graph, 0, 1, None, 1 << 24, &mut Cache::new(), &Silent);
    SharedRecipe(Arc::new(made.unwrap()))
}

#[test]
fn recolored_pictures_are_those_of_the_processor() {
    let card = card();
    let mut recipes = Recipes::new(&card).unwrap();
    let mut random = Pcg64Mcg::new(0x4ec19e);
    for size in [[1, 1], [150, 21], [64, 8], [65, 9], [7, 100]] {
        for space in ["srgb", "linear-srgb", "acescg"] {
            let recipe = recipe(space, size);
            for round in 0..8 {
                let wild = |random: &mut Pcg64Mcg| match random.random_range(0..6) {
                    0 => 0.0,
                    1 => 1.0,
                    2 => 4.0e4,
                    _ => random.random_range(0.0..1.0),
                };
                let colors = recipe.0.info().colors.iter();
                let colors =
                    colors.map(|own| if round == 0 { *own } else { [(); 3].map(|()| wild(&mut random)) }).collect();
                let spot = (round % 3 == 1).then(|| (0..6).map(|_| random.random()).collect());
                let display = Display { exposure: [0.0, 1.5, -3.0][round % 3], ..Display::default() };
                let painting =
                    Painting { generation: 1, recipe: recipe.clone(), colors, spot, display: display.clone() };
                let found = recipes.paint(&card, &painting).unwrap();
                let expected = Canvas::new(painting.clone()).screen;
                let table = Conversion::of_colors(recipe.0.info().space, &display).unwrap().table;
                let off = beyond_a_place(&found, &expected, &table);
                assert!(off <= 1, "{size:?}, {space}, round {round}: {off}");
            }
        }
    }
}

#[test]
fn what_images_contribute_is_painted_too() {
    let folder = tempfile::tempdir().unwrap();
    let image = image::RgbImage::from_fn(130, 17, |x, y| image::Rgb([x as u8, 15 * y as u8, 77]));
    image.save(folder.path().join("sky.png")).unwrap();
    let text = r##"{
      "trochoid": 1, "format": { "width": 130, "height": 17 }, "working_space": "srgb",
      "palette": { "a": "#101a33", "b": "#f2ead2" },
      "nodes": {
        "across": { "type": "ScreenX" }, "down": { "type": "ScreenY" },
        "half": { "type": "Clamp", "field": "across", "min": 0.5, "max": 0.9 },
        "sky": { "type": "Read", "as": "color", "file": "sky.png" },
        "ab": { "type": "Mix", "a": "palette.a", "b": "palette.b", "weight": "down" },
        "all": { "type": "Mix", "a": "ab", "b": "sky", "weight": "half" }
      },
      "outputs": { "beauty": { "color": "all" } }
    }"##;
    let graph = parse("a.json", text, folder.path(), &[]).unwrap().graph;
    let made = PackedRecipe::evaluate(&graph, 0, 1, None, 1 << 24, &mut Cache::new(), &Silent).unwrap();
    assert!(made.info().has_images);
    let painting = Painting {
        generation: 1,
        colors: vec![[0.9, 0.1, 0.2], [0.3, 0.8, 0.1]],
        recipe: SharedRecipe(Arc::new(made)),
        spot: None,
        display: Display::default(),
    };
    let card = card();
    let found = Recipes::new(&card).unwrap().paint(&card, &painting).unwrap();
    assert!(super::difference(&found, &Canvas::new(painting).screen) <= 1);
}
