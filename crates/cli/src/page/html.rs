//! The page: markup, style and scripts from `web/`, with the pictures.

use super::Offered;
use super::picture::{Frame, GROUP, Picture};
use crate::shell::printable;
use serde_json::{Value, json};
use std::fmt::Write as _;
use trochoid::{GENERATOR, VERSION, WorkingSpace};

/// Scripts of the page, in the order in which they run.
const SCRIPTS: [&str; 9] = [
    include_str!("web/color.js"),
    include_str!("web/frames.js"),
    include_str!("web/painter.js"),
    include_str!("web/state.js"),
    include_str!("web/swatches.js"),
    include_str!("web/editor.js"),
    include_str!("web/stage.js"),
    include_str!("web/export.js"),
    include_str!("web/main.js"),
];

/// Returns the whole page.
pub(super) fn page(title: &str, fps: f64, pictures: Vec<Picture>, palettes: &[Offered]) -> String {
    let facts = facts(title, fps, &pictures, palettes);
    let scripts = SCRIPTS.concat();
    let title = escape(&printable(title));
    let (mut first, mut others) = (String::new(), String::new());
    for (index, picture) in pictures.into_iter().enumerate() {
        for (number, frame) in picture.frames.into_iter().enumerate() {
            // Browsers show the first frame while they still read the others.
            let into = if index + number == 0 { &mut first } else { &mut others };
            data(into, &format!("frame-{index}-{number}"), &frame.data);
        }
        if let Some(cube) = &picture.cube {
            data(&mut others, &format!("cube-{index}"), cube);
        }
    }
    let generator = format!("{GENERATOR}{VERSION}");
    let values = [
        ("title", title.as_str()),
        ("generator", generator.as_str()),
        ("style", include_str!("web/style.css")),
        ("facts", facts.as_str()),
        ("first", first.as_str()),
        ("scripts", scripts.as_str()),
        ("others", others.as_str()),
    ];
    fill(include_str!("web/page.html"), &values)
}

/// Writes a block of data, which is no script.
fn data(page: &mut String, id: &str, text: &str) {
    let _ = writeln!(page, "<script type=\"application/octet-stream\" id=\"{id}\">{text}</script>");
}

/// Fills places such as `{{title}}` of a template. Values are not looked into: they may hold such places themselves.
fn fill(template: &str, values: &[(&str, &str)]) -> String {
    let mut page = String::with_capacity(template.len() + values.iter().map(|(_, value)| value.len()).sum::<usize>());
    let mut rest = template;
    while let Some((before, after)) = rest.split_once("{{") {
        let (name, behind) = after.split_once("}}").unwrap_or((after, ""));
        page.push_str(before);
        page.push_str(values.iter().find(|(known, _)| *known == name).map_or("", |(_, value)| value));
        rest = behind;
    }
    page.push_str(rest);
    page
}

/// Returns what the scripts have to know, as JSON that cannot end its element.
fn facts(title: &str, fps: f64, pictures: &[Picture], palettes: &[Offered]) -> String {
    let space = pictures[0].space;
    let pictures: Vec<Value> = pictures.iter().map(picture).collect();
    let palettes: Vec<Value> = palettes
        .iter()
        .map(|offered| {
            let colors = &offered.colors;
            let named = colors.names.iter().zip(&colors.colors);
            json!({
                "name": offered.name,
                "colors": named.map(|(name, of)| json!({ "name": name, "color": color(space, *of) })).collect::<Vec<_>>(),
            })
        })
        .collect();
    let facts = json!({
        "title": title,
        "fps": fps,
        "version": VERSION,
        "space": space.name(),
        "group": GROUP,
        "linear": space != WorkingSpace::Srgb,
        "pictures": pictures,
        "palettes": palettes,
    });
    facts.to_string().replace('<', "\\u003c")
}

fn picture(picture: &Picture) -> Value {
    let colors = |frame: &Frame| -> Vec<Value> { frame.colors.iter().map(|of| color(picture.space, *of)).collect() };
    let frames = picture.frames.iter().enumerate().map(|(index, frame)| {
        // Colors that are keyed differ from frame to frame.
        let differs = index > 0 && frame.colors != picture.frames[0].colors;
        json!({ "label": frame.label, "colors": differs.then(|| colors(frame)) })
    });
    let mean = |index: usize| {
        picture.frames.iter().map(|frame| frame.shares[index]).sum::<f64>() / picture.frames.len() as f64
    };
    let shares: Vec<f64> = (0..picture.names.len()).map(mean).collect();
    json!({
        "name": picture.name,
        "width": picture.size[0],
        "height": picture.size[1],
        "names": picture.names,
        "colors": colors(&picture.frames[0]),
        "shares": shares,
        "frames": frames.collect::<Vec<_>>(),
        "hasCube": picture.cube.is_some() && picture.frames.iter().all(|frame| frame.colors == picture.frames[0].colors),
    })
}

/// Returns a color as displayed and, if 8 bits do not hold it, as a palette file has it: in the working space.
fn color(space: WorkingSpace, of: [f64; 3]) -> Value {
    let shown = space.to_display(of);
    let is_whole = |channel: &f64| {
        let steps = 255.0 * channel;
        (0.0..=255.0).contains(&steps.round()) && (steps - steps.round()).abs() < 1e-6
    };
    if shown.iter().all(is_whole) {
        return json!({ "shown": shown.map(|channel| (255.0 * channel).round() / 255.0) });
    }
    json!({ "shown": shown, "exact": of })
}

/// Escapes a text for HTML.
fn escape(text: &str) -> String {
    text.replace('&', "&amp;").replace('<', "&lt;").replace('>', "&gt;").replace('"', "&quot;")
}

#[cfg(test)]
mod tests {
    use super::*;

    fn one(name: &str) -> Picture {
        let frame = Frame {
            label: "1".into(),
            colors: vec![[0.2, 0.5, 1.0 / 3.0]],
            shares: vec![1.0],
            data: "AAAA".into(),
            farthest: 0.0,
        };
        Picture {
            name: name.into(),
            size: [2, 1],
            space: WorkingSpace::Srgb,
            names: vec![name.into()],
            frames: vec![frame],
            cube: None,
        }
    }

    #[test]
    fn names_do_not_become_markup() {
        let hostile = "</script><script>alert(1)</script>{{first}}&amp;\"";
        let page = page(hostile, 24.0, vec![one(hostile)], &[]);
        assert!(!page.contains("<script>alert") && !page.contains("</script><script>alert"));
        assert!(page.contains("<title>&lt;/script&gt;&lt;script&gt;alert(1)&lt;/script&gt;{{first}}&amp;amp;&quot;"));
        assert_eq!(page.matches("id=\"frame-0-0\"").count(), 1);
    }

    #[test]
    fn pages_ask_for_nothing_outside() {
        let page = page("a", 24.0, vec![one("a")], &[]);
        for outside in ["http:", "https:", "//cdn", "src=\"", "@import", "url("] {
            assert!(!page.contains(outside), "{outside}");
        }
        // Nothing is left to fill, and what it is made of is found at its start.
        assert!(!page.contains("{{") && page[..4096].contains("<meta name=\"generator\" content=\"Trochoid "));
    }

    #[test]
    fn colors_are_whole_where_they_can_be() {
        let whole = color(WorkingSpace::Srgb, [1.0, 0.2, 0.0]);
        assert_eq!((&whole["shown"][1], &whole["exact"]), (&json!(51.0 / 255.0), &Value::Null));
        assert_eq!(color(WorkingSpace::LinearSrgb, [0.5, 0.0, 2.0])["exact"], json!([0.5, 0.0, 2.0]));
    }
}
