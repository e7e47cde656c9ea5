//! Chapters of the manual: copied from `docs/src`, with documents rendered, node names linked, and node pages added.

use crate::fault::{Fault, Faults};
use crate::node_page::{node_page, row};
use crate::{copy, documents, text, write};
use std::path::{Path, PathBuf};
use trochoid::{End, registry};

/// Placeholder for the list of nodes: a list of pages in the summary; in a chapter a table, in place of all that follows.
const NODES: &str = "<!-- nodes -->";

/// Writes the pages and pictures of the book from `docs` into the folder `book`, and returns the faults found.
pub(crate) fn write_all(docs: &Path, book: &Path) -> Faults {
    let mut faults = Faults::new();
    let mut note = |result: Result<(), Fault>| faults.extend(result.err());
    for file in ["book.toml", "book.css"] {
        note(copy(&docs.join(file), &book.join(file)));
    }
    for (place, file) in files(&docs.join("src")) {
        if place.extension().is_some_and(|ending| ending == "md") {
            chapter(&file, book, &place).into_iter().for_each(|fault| note(Err(fault)));
        } else {
            note(copy(&file, &book.join("src").join(&place)));
        }
    }
    for ty in registry().iter() {
        note(node(docs, book, ty.declaration()));
    }
    faults
}

/// Returns all files below a folder with their relative paths, sorted by name.
fn files(folder: &Path) -> Vec<(PathBuf, PathBuf)> {
    let mut found = Vec::new();
    let mut folders = vec![folder.to_path_buf()];
    while let Some(next) = folders.pop() {
        for entry in std::fs::read_dir(next).into_iter().flatten().flatten() {
            let path = entry.path();
            match path.strip_prefix(folder) {
                _ if path.is_dir() => folders.push(path),
                Ok(place) => found.push((place.to_path_buf(), path)),
                Err(_) => {}
            }
        }
    }
    found.sort();
    found
}

/// Writes the page of a node type, and its picture.
fn node(docs: &Path, book: &Path, declaration: &trochoid::Declaration) -> Result<(), Fault> {
    let name = declaration.name;
    let folder = docs.join("nodes");
    let path = folder.join(format!("{name}.json"));
    let document = text(&path).map_err(|source| Fault::NoDocument { node: name, source: source.into() })?;
    let pages = book.join("src/nodes");
    documents::render(&path.display().to_string(), &document, &folder, &pages.join(format!("{name}.png")))?;
    write(&pages.join(format!("{name}.md")), &node_page(declaration, &document))
}

/// Writes a chapter.
fn chapter(file: &Path, book: &Path, place: &Path) -> Faults {
    let page = match text(file) {
        Ok(page) => page,
        Err(error) => return vec![error.into()],
    };
    let mut faults = Faults::new();
    for (name, document) in named_documents(&page) {
        faults.extend(guide_document(file, book, &name, &document).err());
    }
    let is_summary = place.ends_with("SUMMARY.md");
    let listed = if is_summary {
        page.replace(NODES, &summary_of_nodes())
    } else {
        // What follows in a chapter tells readers of the repository where the table is.
        page.split_once(NODES).map_or(page.clone(), |(before, _)| before.to_owned() + &table_of_nodes())
    };
    let linked = if is_summary { listed } else { link_nodes(&listed) };
    let (brought, missing) = bring_files(&linked, file, book);
    faults.extend(missing);
    faults.extend(write(&book.join("src").join(place), &brought).err());
    faults
}

/// Renders a document in a chapter and compares the result with the stored picture.
fn guide_document(file: &Path, book: &Path, name: &str, document: &str) -> Result<(), Fault> {
    let picture = name.replace(".json", ".png");
    // Stored pictures are copied later, in name order, so the rendered one goes to a folder of its own.
    let rendered = book.join("rendered").join(&picture);
    documents::render(&format!("{}, {name}", file.display()), document, Path::new("."), &rendered)?;
    let stored = file.parent().unwrap_or(Path::new(".")).join("pictures").join(&picture);
    let is_same = stored.exists() && documents::same_pictures(&stored, &rendered)?;
    if is_same {
        return Ok(());
    }
    Err(Fault::OtherPicture { stored, document: name.into(), rendered })
}

/// Returns the documents of a chapter: code blocks that begin with "```json NAME.json".
fn named_documents(page: &str) -> Vec<(String, String)> {
    let mut found = Vec::new();
    let mut lines = page.lines();
    while let Some(line) = lines.next() {
        let Some(name) = line.strip_prefix("```json ") else { continue };
        let body: Vec<&str> = lines.by_ref().take_while(|line| !line.starts_with("```")).collect();
        found.push((name.trim().to_owned(), body.join("\n")));
    }
    found
}

fn declarations(end: Option<End>) -> Vec<&'static trochoid::Declaration> {
    let all = registry().iter().map(|ty| ty.declaration());
    let mut chosen: Vec<_> = all.filter(|declaration| end.is_none_or(|end| declaration.end == end)).collect();
    chosen.sort_by_key(|declaration| declaration.name);
    chosen
}

fn summary_of_nodes() -> String {
    let lines = declarations(None).into_iter().map(|declaration| format!("- [{0}](nodes/{0}.md)", declaration.name));
    lines.collect::<Vec<_>>().join("\n  ")
}

fn table_of_nodes() -> String {
    let mut tables = String::new();
    for (end, heading) in [(End::Back, "Back end: convex operations"), (End::Front, "Front end: any mathematics")] {
        tables.push_str(&format!("\n## {heading}\n\n| | node | what it does |\n|---|---|---|\n"));
        declarations(Some(end)).into_iter().for_each(|declaration| tables.push_str(&row(declaration)));
    }
    tables
}

/// Links node types in backticks to their pages.
fn link_nodes(page: &str) -> String {
    let mut in_code = false;
    let mut linked = Vec::new();
    for line in page.lines() {
        let is_fence = line.trim_start().starts_with("```");
        in_code ^= is_fence;
        let is_code = is_fence || in_code || line.starts_with("    ") || line.starts_with('#');
        linked.push(if is_code { line.to_owned() } else { link_line(line) });
    }
    linked.join("\n") + "\n"
}

fn link_line(line: &str) -> String {
    let parts: Vec<&str> = line.split('`').collect();
    let mut out = String::new();
    for (index, part) in parts.iter().enumerate() {
        let is_code = index % 2 == 1 && index + 1 < parts.len();
        let is_linked_already = out.ends_with('[');
        if is_code && !is_linked_already && registry().names().any(|name| name == *part) {
            out.push_str(&format!("[`{part}`](nodes/{part}.md)"));
        } else if is_code {
            out.push_str(&format!("`{part}`"));
        } else {
            // An unpaired backtick at the end of the line does not begin code.
            out.push_str(if index % 2 == 1 { "`" } else { "" });
            out.push_str(part);
        }
    }
    out
}

/// Copies the repository files that a chapter links to (`../../samples/…`) into the book.
fn bring_files(page: &str, file: &Path, book: &Path) -> (String, Faults) {
    const UP: &str = "](../../";
    let mut faults = Faults::new();
    for (at, _) in page.match_indices(UP) {
        let rest = &page[at + UP.len()..];
        let Some(end) = rest.find(')') else { continue };
        let place = &rest[..end];
        if place.ends_with(".md") {
            faults.push(Fault::NoPage { page: file.into(), target: place.into() });
        } else {
            faults.extend(copy(Path::new(place), &book.join("src/files").join(place)).err());
        }
    }
    (page.replace(UP, "](files/"), faults)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn nodes_are_linked_once_and_outside_of_code() {
        assert_eq!(link_line("a `Mix` of `mixes`"), "a [`Mix`](nodes/Mix.md) of `mixes`");
        assert_eq!(link_line("[`Mix`](elsewhere.md) and ` alone"), "[`Mix`](elsewhere.md) and ` alone");
        assert_eq!(link_nodes("```json\n`Mix`\n```\n`Mix`\n"), "```json\n`Mix`\n```\n[`Mix`](nodes/Mix.md)\n");
    }

    #[test]
    fn documents_have_names() {
        let page = "```json\n{}\n```\n\n```json dusk.json\n{ \"a\": 1 }\n```\n";
        assert_eq!(named_documents(page), [("dusk.json".to_owned(), "{ \"a\": 1 }".to_owned())]);
    }

    #[test]
    fn a_node_without_document_is_a_fault() {
        let folder = tempfile::tempdir().expect("a folder");
        let mix = declarations(None).into_iter().find(|declaration| declaration.name == "Mix").expect("a node");
        let fault = node(folder.path(), folder.path(), mix).expect_err("no document");
        assert!(matches!(fault, Fault::NoDocument { node: "Mix", .. }), "{fault}");
    }

    #[test]
    fn a_picture_that_is_not_its_documents_is_a_fault() {
        let folder = tempfile::tempdir().expect("a folder");
        let page = folder.path().join("src/a.md");
        let document = r##"{ "trochoid": 1, "format": { "width": 4, "height": 4 },
            "nodes": { "c": { "type": "Constant", "color": "#fff" } }, "outputs": { "o": { "color": "c" } } }"##;
        write(&page, &format!("# A\n\n```json white.json\n{document}\n```\n")).expect("a page");
        let faults = chapter(&page, folder.path(), Path::new("a.md"));
        assert_eq!(faults.len(), 1, "{faults:?}");
        assert!(
            matches!(&faults[0], Fault::OtherPicture { document, .. } if document == "white.json"),
            "{}",
            faults[0]
        );
        copy(&folder.path().join("rendered/white.png"), &folder.path().join("src/pictures/white.png")).expect("a copy");
        let faults = chapter(&page, folder.path(), Path::new("a.md"));
        assert!(faults.is_empty(), "{faults:?}");
    }
}
