//! Files of a page, as pictures with frames.

use crate::failure::{FAILED, Failure};
use crate::frames;
use std::path::{Path, PathBuf};
use trochoid::{expand_frame, quoted_path};

/// Files of a picture.
#[derive(Debug, PartialEq)]
pub(super) struct Source {
    /// Name without the frame, the folder and the extension.
    pub(super) name: String,
    /// Frames: what they are called, and their files.
    pub(super) frames: Vec<(String, PathBuf)>,
}

/// Finds the pictures of some files. Files in a row whose names differ only in the frame are frames of one picture, and so
/// are those of a pattern.
///
/// # Errors
/// All of: a list of frames is faulty, lacks its pattern, or a pattern its list; or a file is not there.
pub(super) fn find(recipes: &[PathBuf], list: Option<&str>) -> Result<Vec<Source>, Failure> {
    let mut faults = Vec::new();
    let numbers = list.map(|list| {
        frames::parse(list).unwrap_or_else(|found| {
            faults.extend(found.into_iter().map(|fault| Failure::usage(fault, "write, for example, --frames 1-48")));
            Vec::new()
        })
    });
    let is_pattern = |path: &Path| {
        let text = path.to_string_lossy();
        !path.exists() && expand_frame(&text, 1) != expand_frame(&text, 2)
    };
    if list.is_some() && !recipes.iter().any(|path| is_pattern(path)) {
        let message = "--frames: found no #### in the names of the recipes; expected one where the frame belongs";
        faults.push(Failure::usage(message, "write, for example, 'recipes/storm.####.exr', or omit --frames"));
    }
    let mut sources: Vec<Source> = Vec::new();
    for path in recipes {
        if !is_pattern(path) {
            let (name, frame) = parts(path);
            let label = frame.clone().unwrap_or_else(|| "1".into());
            match sources.last_mut() {
                Some(last) if frame.is_some() && last.name == name && alike(last, path) => {
                    last.frames.push((label, path.clone()));
                }
                _ => sources.push(Source { name, frames: vec![(label, path.clone())] }),
            }
        } else if let Some(numbers) = &numbers {
            let text = path.to_string_lossy();
            let frame = |number: &i64| (number.to_string(), PathBuf::from(expand_frame(&text, *number)));
            let frames: Vec<_> = numbers.iter().map(frame).collect();
            let name = frames.first().map_or_else(String::new, |(_, path)| parts(path).0);
            sources.push(Source { name, frames });
        } else {
            let message = format!("{}: found a pattern without frames; expected --frames", quoted_path(path));
            faults.push(Failure::usage(message, "say which, for example --frames 1-48"));
        }
    }
    for (_, path) in sources.iter().flat_map(|source| &source.frames) {
        if let Err(error) = std::fs::metadata(path) {
            faults.push(Failure::new(FAILED, format!("{}: cannot open the file: {error}", path.display())));
            // One will do: the others are most likely missing for the same reason.
            break;
        }
    }
    Failure::all(faults)?;
    Ok(sources)
}

/// Returns whether a file may be a frame of a picture that was given by files: they lie in one folder.
fn alike(source: &Source, path: &Path) -> bool {
    source.frames.last().is_some_and(|(_, last)| last.parent() == path.parent())
}

/// Returns the name of a recipe's picture and its frame: `beauty` and `12` of `beauty.0012.recipe.exr`.
fn parts(path: &Path) -> (String, Option<String>) {
    let stem = path.file_stem().unwrap_or_default().to_string_lossy();
    let stem = stem.strip_suffix(".recipe").unwrap_or(&stem);
    let digits = stem.len() - stem.trim_end_matches(|c: char| c.is_ascii_digit()).len();
    let (before, frame) = stem.split_at(stem.len() - digits);
    // Without leading zeros, but 0 itself.
    let number = frame.trim_start_matches('0');
    let number = if number.is_empty() { "0" } else { number };
    match before.strip_suffix(['.', '_', '-']) {
        Some(name) if digits > 0 && !name.is_empty() => {
            (name.strip_suffix(".recipe").unwrap_or(name).into(), Some(number.into()))
        }
        _ => (stem.into(), None),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn names_are_told_from_frames() {
        let parts = |path: &str| {
            let (name, frame) = super::parts(Path::new(path));
            (name, frame.unwrap_or_default())
        };
        let is = |name: &str, frame: &str| (name.to_string(), frame.to_string());
        assert_eq!(parts("a/beauty.0012.exr"), is("beauty", "12"));
        assert_eq!(parts("beauty.0012.recipe.exr"), is("beauty", "12"));
        assert_eq!(parts("beauty.recipe.0012.exr"), is("beauty", "12"));
        assert_eq!(parts("painting.recipe.exr"), is("painting", ""));
        assert_eq!(parts("kodim23.exr"), is("kodim23", ""));
        assert_eq!(parts("0012.exr"), is("0012", ""));
    }

    #[test]
    fn files_in_a_row_are_frames() {
        let folder = tempfile::tempdir().unwrap();
        let paths: Vec<PathBuf> =
            ["a.1.exr", "a.2.exr", "b.exr", "a.3.exr"].iter().map(|name| folder.path().join(name)).collect();
        paths.iter().for_each(|path| std::fs::write(path, "").unwrap());
        let found = find(&paths, None).unwrap();
        let labels = |index: usize| found[index].frames.iter().map(|(label, _)| label.as_str()).collect::<Vec<_>>();
        assert_eq!((found.len(), labels(0), labels(1)), (3, vec!["1", "2"], vec!["1"]));
        let pattern = [folder.path().join("a.#.exr")];
        assert_eq!(find(&pattern[..], Some("2-3")).unwrap()[0].frames[1], ("3".into(), paths[3].clone()));
        for (recipes, list) in
            [(&pattern[..], None), (&pattern[..], Some("1-4")), (&paths[..], Some("1")), (&pattern[..], Some("x"))]
        {
            assert_eq!(find(recipes, list).unwrap_err().messages.len(), 1, "{list:?}");
        }
    }
}
