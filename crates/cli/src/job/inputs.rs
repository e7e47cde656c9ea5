//! Copies of the files that a document reads.

use super::folder::Content;
use super::work::{GRAPH, utf8};
use super::{Args, Files};
use crate::failure::{FAILED, Failure, once};
use std::collections::BTreeMap;
use std::path::{Component, Path, PathBuf};
use trochoid::{CheckedGraph, Item, KnobType, LoadError, NodeId, quoted_path, refusals, refused_files};

/// Returns the copies of the document and of all files that it reads for these outputs at these frames, in any variant;
/// nothing if the document stays in its place. Adds faults of files that cannot be copied, or that the document may not
/// read.
pub(super) fn files(
    args: &Args,
    variants: &[&CheckedGraph],
    outputs: &[usize],
    frames: &[i64],
    faults: &mut Vec<Failure>,
) -> Files {
    // Access is checked for links within the folder that lead elsewhere; a path that leaves the folder is no matter of
    // trust if all files are copied.
    let refused: Vec<_> = variants.iter().flat_map(|graph| refused_files(graph, outputs, frames)).collect();
    let check_access = |faults: &mut Vec<Failure>| {
        if !refused.is_empty() {
            faults.push(LoadError::Invalid(once(refusals(&refused))).into());
        }
    };
    if args.shared {
        check_access(faults);
        return Files::new();
    }
    let folder = args.graph.parent().unwrap_or(Path::new(""));
    let before = faults.len();
    let mut read: BTreeMap<PathBuf, i64> = BTreeMap::new();
    for graph in variants {
        faults.extend(absolute(graph, outputs, frames));
        let roots = || outputs.iter().map(|index| graph.outputs()[*index].node);
        for &frame in frames {
            let needed = graph.dependencies(roots(), frame);
            for path in graph.files(&needed, &graph.frame_context(frame, u64::MAX)) {
                read.entry(path).or_insert(frame);
            }
        }
        // The palette of the command line has a place of its own.
        let own = graph.document_files().iter().filter(|path| Some(*path) != args.changes.palette.as_ref());
        own.for_each(|path| _ = read.entry(path.clone()).or_insert(frames[0]));
    }
    let mut copies: BTreeMap<String, PathBuf> = BTreeMap::new();
    copies.extend(place(&args.graph, folder, "the document", faults).map(|place| (place, args.graph.clone())));
    for (path, frame) in read {
        let reader = format!("the document reads it at frame {frame}");
        if let Some(place) = place(&path, folder, &reader, faults) {
            if !path.exists() {
                let message = format!("{}: found no file; expected one, because {reader}", path.display());
                faults.push(Failure::new(FAILED, message));
            }
            copies.insert(place, path);
        }
    }
    if faults.len() == before {
        check_access(faults);
    }
    let palette = args.changes.palette.iter().map(|path| (palette(path), path.clone()));
    copies.into_iter().chain(palette).map(|(place, path)| (place, Content::Copy(path))).collect()
}

/// Returns the path of the copied palette of the command line.
pub(super) fn palette(path: &Path) -> String {
    format!("palette/{}", path.file_name().unwrap_or_default().to_string_lossy())
}

/// Returns the path of a copy in the folder of the job; adds a fault if the path leads out of the document's folder.
fn place(path: &Path, folder: &Path, reader: &str, faults: &mut Vec<Failure>) -> Option<String> {
    let inside = path
        .strip_prefix(folder)
        .ok()
        .filter(|rest| rest.components().all(|part| matches!(part, Component::Normal(_) | Component::CurDir)));
    let Some(inside) = inside else {
        let message = format!(
            "{}: found a file outside of the document's folder, and {reader}; expected one that can be copied with the document",
            path.display()
        );
        let remedy = "leave all files in their places: --shared, with --allow and the folder of the file; or move it beneath \
                      the document's folder and name it by a path within";
        faults.push(Failure::usage(message, remedy));
        return None;
    };
    let parts: Vec<_> =
        inside.components().filter(|part| *part != Component::CurDir).map(Component::as_os_str).collect();
    let joined: PathBuf = parts.into_iter().collect();
    match utf8("the document's file", &joined) {
        Ok(text) => Some(format!("{GRAPH}/{text}")),
        Err(fault) => {
            faults.push(fault);
            None
        }
    }
}

/// Returns failures for files that the document names by absolute paths, which its copy would name, too.
fn absolute(graph: &CheckedGraph, outputs: &[usize], frames: &[i64]) -> Vec<Failure> {
    let connected = graph.upstream(outputs.iter().map(|index| graph.outputs()[*index].node));
    let nodes = (0..graph.nodes().len()).filter(|index| connected[*index] && !graph.nodes()[*index].disabled);
    let named = nodes.flat_map(|index| {
        let settled = graph.settle(NodeId(index), frames[0]);
        let items = graph.nodes()[index].ty.declaration().items.iter();
        items.filter_map(move |item| {
            let Item::Knob(knob) = item else { return None };
            let is_path = matches!(knob.takes, KnobType::Path) && settled.is_set(knob.name);
            let text = is_path.then(|| settled.text(knob.name))?;
            Path::new(text).is_absolute().then(|| (index, knob.name, text.to_owned()))
        })
    });
    let fault = |(index, knob, text): (usize, &str, String)| {
        let (place, name) = (graph.place_of(NodeId(index), Some(knob)), &graph.nodes()[index].name);
        let text = quoted_path(Path::new(&text));
        let message = format!(
            "{place}: node \"{name}\", {knob}: found the absolute path {text}; expected one relative to the document, which \
             is copied"
        );
        Failure::usage(message, "name the file relative to the document; or leave all files in their places: --shared")
    };
    named.map(fault).collect()
}
