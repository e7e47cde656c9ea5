//! Checks that every link in the book has a target.

use crate::fault::{Fault, Faults, LinkFault};
use crate::text;
use std::collections::BTreeMap;
use std::path::{Path, PathBuf};

/// Returns the links and images of all pages below a folder whose file or heading does not exist.
pub(crate) fn check(folder: &Path) -> Faults {
    let mut faults = Faults::new();
    let mut pages: BTreeMap<PathBuf, String> = BTreeMap::new();
    let mut folders = vec![folder.to_path_buf()];
    while let Some(next) = folders.pop() {
        for entry in std::fs::read_dir(next).into_iter().flatten().flatten() {
            let path = entry.path();
            if path.is_dir() {
                folders.push(path);
            } else if path.extension().is_some_and(|ending| ending == "md") {
                match text(&path) {
                    Ok(page) => drop(pages.insert(path, page)),
                    Err(error) => faults.push(error.into()),
                }
            }
        }
    }
    let summary = pages.get(&folder.join("SUMMARY.md")).map_or("", String::as_str);
    for (path, page) in &pages {
        let place = path.strip_prefix(folder).unwrap_or(path).display().to_string();
        if place != "SUMMARY.md" && !summary.contains(&format!("]({})", place.replace('\\', "/"))) {
            faults.push(Fault::Unlisted { page: place.clone() });
        }
        for target in targets(page) {
            let fault = fault(path, page, &target, &pages);
            faults.extend(fault.map(|fault| Fault::Link { page: place.clone(), target, fault }));
        }
    }
    faults
}

/// Returns the fault of a link, if any.
fn fault(path: &Path, page: &str, target: &str, pages: &BTreeMap<PathBuf, String>) -> Option<LinkFault> {
    if target.contains("://") || target.starts_with("mailto:") {
        return None;
    }
    let (file, heading) = target.split_once('#').map_or((target, None), |(file, heading)| (file, Some(heading)));
    let to = if file.is_empty() { path.to_path_buf() } else { path.parent().unwrap_or(path).join(file) };
    if !to.is_file() {
        return Some(LinkFault::Page);
    }
    let wanted = heading?;
    let linked = if file.is_empty() { Some(page) } else { pages.get(&to).map(String::as_str) };
    let found = linked.is_some_and(|page| headings(page).any(|heading| heading == wanted));
    (!found).then_some(LinkFault::Heading)
}

/// Returns the anchors of a page's headings, as mdBook and code hosts generate them.
fn headings(page: &str) -> impl Iterator<Item = String> {
    prose(page).filter(|line| line.starts_with('#')).map(|line| {
        let letters = line.trim_start_matches('#').trim().chars().filter_map(|c| match c {
            c if c.is_whitespace() => Some('-'),
            c if c.is_alphanumeric() || c == '-' || c == '_' => Some(c.to_ascii_lowercase()),
            _ => None,
        });
        letters.collect()
    })
}

/// Returns the lines of a page outside code blocks.
fn prose(page: &str) -> impl Iterator<Item = &str> {
    let mut in_code = false;
    page.lines().filter(move |line| {
        let is_fence = line.trim_start().starts_with("```");
        in_code ^= is_fence;
        !is_fence && !in_code && !line.starts_with("    ")
    })
}

/// Returns the link and image targets of a page.
fn targets(page: &str) -> Vec<String> {
    let mut found = Vec::new();
    for line in prose(page) {
        // Links inside code do not count.
        let bare: String = line.split('`').step_by(2).collect();
        for (open, close) in [("](", ')'), ("src=\"", '"'), ("href=\"", '"')] {
            for (at, _) in bare.match_indices(open) {
                let rest = &bare[at + open.len()..];
                found.extend(rest.find(close).map(|end| rest[..end].to_owned()));
            }
        }
    }
    found
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn broken_links_are_found() {
        let folder = tempfile::tempdir().expect("a folder");
        let write = |name: &str, page: &str| std::fs::write(folder.path().join(name), page).expect("a file");
        write("SUMMARY.md", "- [A](a.md)\n");
        write("a.md", "# A, the first\n[b](b.md) [`A`](a.md#a-the-first) [c](#c) ![p](p.png) `[x](y.md)` https://z\n");
        write("left.md", "alone");
        let faults = check(folder.path());
        assert_eq!(faults.len(), 4, "{faults:#?}");
        for (fault, part) in faults.iter().zip(["b.md", "#c", "p.png", "left.md: stands in no line"]) {
            assert!(fault.to_string().contains(part), "{fault}: {part}");
        }
    }
}
