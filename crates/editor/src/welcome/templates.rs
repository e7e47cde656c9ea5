//! The scenes that are offered as templates. Those that read no files are part of the program; the others are offered
//! where their folder is found.

use crate::document::Session;
use crate::document::template::{NoTemplate, self_contained, with_own_outputs};
use std::path::{Path, PathBuf};

/// A scene.
#[derive(Debug, PartialEq)]
pub(crate) struct Template {
    /// Name in the welcome.
    pub(crate) name: &'static str,
    /// Name of its document, without the extension.
    pub(crate) file: &'static str,
    /// Its picture, as JPEG.
    pub(crate) picture: &'static [u8],
    /// Its text; `None` if it reads files.
    text: Option<&'static str>,
}

/// Why a template cannot be opened.
#[derive(Debug, thiserror::Error)]
pub(crate) enum NotOpened {
    #[error(transparent)]
    Template(#[from] NoTemplate),
    #[error(transparent)]
    File(#[from] trochoid::io::Error),
    #[error("the folder of the scenes is gone; open a document instead")]
    NoFolder,
}

macro_rules! whole {
    ($name:literal, $file:literal) => {
        Template {
            name: $name,
            file: $file,
            picture: include_bytes!(concat!("../../templates/", $file, ".jpg")),
            text: Some(include_str!(concat!("../../scenes/", $file, ".json"))),
        }
    };
}

macro_rules! with_files {
    ($name:literal, $file:literal) => {
        Template {
            name: $name,
            file: $file,
            picture: include_bytes!(concat!("../../templates/", $file, ".jpg")),
            text: None,
        }
    };
}

/// All scenes, in the order of the welcome.
pub(crate) static ALL: [Template; 15] = [
    with_files!("The great wave", "great_wave"),
    with_files!("Stormy sea", "stormy_sea"),
    with_files!("Toon sea", "toon_sea"),
    with_files!("Cartoon bay", "cartoon_bay"),
    whole!("Open sea", "open_sea"),
    whole!("Glow before the sun", "glow"),
    whole!("A crest set by hand", "wave_group"),
    whole!("Breaking crest and spray", "spray"),
    whole!("Lines of a toon sea", "toon_lines"),
    whole!("Bursts of a toon sea", "toon_bursts"),
    whole!("Claws of foam", "hooks"),
    whole!("A print of noise and shapes", "noise_and_shapes"),
    with_files!("Toon teapot", "toon_teapot"),
    with_files!("A painted normal map", "painted_normals"),
    with_files!("Passes of another renderer", "from_passes"),
];

/// Returns the text of a document that scenes include.
fn library(path: &str) -> Option<&'static str> {
    (path == "lib/ink.json").then_some(include_str!("../../scenes/lib/ink.json"))
}

/// Returns the folder of the scenes: beside the program or the current folder, or above them.
pub(crate) fn folder() -> Option<PathBuf> {
    let places = [std::env::current_dir().ok(), std::env::current_exe().ok()];
    let above = places.iter().flatten().flat_map(|place| place.ancestors());
    above.map(|place| place.join("graphs")).find(|folder| ALL.iter().all(|scene| scene.within(folder).is_file()))
}

/// Returns the scenes that can be opened.
pub(crate) fn offered() -> impl Iterator<Item = &'static Template> {
    let has_folder = folder().is_some();
    ALL.iter().filter(move |scene| has_folder || scene.text.is_some())
}

impl Template {
    fn within(&self, folder: &Path) -> PathBuf {
        folder.join(self.file).with_extension("json")
    }

    /// Opens it as a new document.
    ///
    /// # Errors
    /// It cannot be read.
    pub(crate) fn open(&self) -> Result<Session, NotOpened> {
        const MOST_BYTES: u64 = 1 << 24;
        if let Some(text) = self.text {
            return Ok(Session::new(self_contained(text, library)?, None));
        }
        let folder = folder().ok_or(NotOpened::NoFolder)?;
        let text = trochoid::io::read_text(self.within(&folder), MOST_BYTES)?;
        Ok(Session::based(with_own_outputs(&text)?, &folder))
    }
}
