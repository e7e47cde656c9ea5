//! Checks and renders the documents in the book.

use crate::fault::Fault;
use std::path::Path;
use trochoid::io::{Limits, Selection, read};
use trochoid::{Buffers, Cache, OutputFile, Plan, Settings, Silent, parse, write_output};

/// Maximum difference between a stored picture and a rendering: rounding on another machine.
const SAME: f32 = 2.5 / 255.0;

/// Renders the first output of a document at its first frame, as a PNG.
///
/// # Errors
/// Fails if the document has a fault or a warning, cannot be rendered, or leaves the hull of its control colors.
pub(crate) fn render(name: &str, document: &str, folder: &Path, to: &Path) -> Result<(), Fault> {
    let loaded = parse(name, document, folder, &[])?;
    if let Some(warning) = loaded.warnings.into_iter().next() {
        return Err(Fault::Warning(warning.into()));
    }
    let graph = &loaded.graph;
    let document = || name.to_owned();
    let output = graph.outputs().first().ok_or_else(|| Fault::NoOutput { document: document() })?;
    let plan = Plan::new(graph, &[output.name.as_str()], graph.frames().0, &[], &Settings::default())
        .map_err(|source| Fault::Plan { document: document(), source: source.into() })?;
    let frame = plan
        .evaluate(&Buffers::new(), &mut Cache::new(), &Silent)
        .map_err(|source| Fault::Evaluation { document: document(), source: source.into() })?;
    let picture = &frame.pictures[0];
    if picture.audit.hull_exits > 0 {
        return Err(Fault::Outside { document: document(), pixels: picture.audit.hull_exits });
    }
    let file = OutputFile { path: to.into(), outputs: vec![picture.output] };
    write_output(graph, &frame, &file, &[])
        .map_err(|source| Fault::Picture { document: document(), source: source.into() })
}

/// Returns whether two pictures are equal up to rounding.
///
/// # Errors
/// Fails if one of them cannot be read.
pub(crate) fn same_pictures(a: &Path, b: &Path) -> Result<bool, trochoid::io::Error> {
    let picture = |path: &Path| read(path, &Selection::default(), &Limits::default());
    let (a, b) = (picture(a)?, picture(b)?);
    let same_size = a.data == b.data && a.channels.len() == b.channels.len();
    let near = |(a, b): (&f32, &f32)| (a - b).abs() <= SAME;
    Ok(same_size
        && a.channels.iter().zip(&b.channels).all(|(a, b)| a.plane.samples().iter().zip(b.plane.samples()).all(near)))
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Returns a document that renders a single color, 8 × 4, with further nodes.
    fn document(color: &str, more: &str) -> String {
        format!(
            r##"{{ "trochoid": 1, "format": {{ "width": 8, "height": 4 }},
                "nodes": {{ "c": {{ "type": "Constant", "color": "{color}" }}{more} }},
                "outputs": {{ "picture": {{ "color": "c" }} }} }}"##
        )
    }

    #[test]
    fn pictures_are_told_apart() {
        let folder = tempfile::tempdir().expect("a folder");
        let pictures = ["#808080", "#818181", "#848484"].map(|color| {
            let to = folder.path().join(format!("{}.png", &color[1..]));
            render(color, &document(color, ""), folder.path(), &to).expect("valid");
            to
        });
        assert!(same_pictures(&pictures[0], &pictures[1]).expect("readable"), "rounding");
        assert!(!same_pictures(&pictures[0], &pictures[2]).expect("readable"));
        assert!(same_pictures(&pictures[0], &folder.path().join("none.png")).is_err());
    }

    #[test]
    fn faults_and_warnings_of_documents_are_said() {
        let folder = tempfile::tempdir().expect("a folder");
        let to = folder.path().join("a.png");
        for (text, part) in [
            (document("blue", ""), "error: a.json:2:"),
            (document("#000", r#", "x": { "type": "ScreenX" }"#), "no output needs"),
            (document("#000", "").replace(r#""color": "c""#, r#""field": "c""#), "error: a.json:3:"),
        ] {
            let fault = render("a.json", &text, folder.path(), &to).expect_err(part).told();
            assert!(fault.contains(part), "{fault}: {part}");
            assert!(!to.exists());
        }
    }
}
