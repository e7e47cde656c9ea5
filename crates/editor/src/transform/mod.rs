//! What the viewer makes of light for the screen. It is for viewing only: files are written without it, and what is
//! guaranteed of a picture is guaranteed of its file.

mod cube;
mod parse;
#[cfg(test)]
mod tests;

pub use cube::Cube;
pub use parse::NoCube;

use std::path::{Path, PathBuf};
use std::sync::Arc;

/// Conversion of light for the screen.
#[derive(Clone, Debug, Default)]
pub enum Transform {
    /// As sRGB.
    #[default]
    Srgb,
    /// For a display of Rec. 709 as BT.1886 has it.
    Bt1886,
    /// By the table of a file.
    Cube(Arc<CubeFile>),
}

/// A table, and the file that it comes from.
#[derive(Debug)]
pub struct CubeFile {
    /// The file.
    pub path: PathBuf,
    /// Its table.
    pub cube: Cube,
    /// What the table takes.
    pub takes: Takes,
}

/// What a table takes.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, serde::Serialize, serde::Deserialize)]
pub enum Takes {
    /// Light, as it is in the working space.
    #[default]
    Light,
    /// Values as sRGB encodes them, from 0 to 1.
    Encoded,
}

impl PartialEq for Transform {
    fn eq(&self, other: &Self) -> bool {
        match (self, other) {
            (Self::Srgb, Self::Srgb) | (Self::Bt1886, Self::Bt1886) => true,
            (Self::Cube(own), Self::Cube(other)) => Arc::ptr_eq(own, other),
            _ => false,
        }
    }
}

impl Transform {
    /// Reads the table of a file.
    ///
    /// # Errors
    /// The file cannot be read, or is no table.
    pub fn read(path: &Path, takes: Takes) -> Result<Self, NoCube> {
        let text = trochoid::io::read_text(path, parse::MOST_BYTES)?;
        let cube = parse::parse(&text)?;
        Ok(Self::Cube(Arc::new(CubeFile { path: path.into(), cube, takes })))
    }

    /// Returns its name for the toolbar.
    pub fn name(&self) -> String {
        match self {
            Self::Srgb => "sRGB".into(),
            Self::Bt1886 => "Rec.709".into(),
            Self::Cube(file) => file.path.file_name().unwrap_or_default().to_string_lossy().into_owned(),
        }
    }

    /// Returns what the next run of the program needs to know of it.
    pub fn kept(&self) -> KeptTransform {
        match self {
            Self::Srgb => KeptTransform::Srgb,
            Self::Bt1886 => KeptTransform::Bt1886,
            Self::Cube(file) => KeptTransform::Cube(file.path.clone(), file.takes),
        }
    }
}

/// A conversion as it is stored for the next run.
#[derive(Clone, Debug, Default, PartialEq, Eq, serde::Serialize, serde::Deserialize)]
pub enum KeptTransform {
    /// As sRGB.
    #[default]
    Srgb,
    /// For a display of Rec. 709.
    Bt1886,
    /// By a file's table, and what it takes.
    Cube(PathBuf, Takes),
}

impl KeptTransform {
    /// Returns its name, or that of its file, for messages.
    pub fn name(&self) -> String {
        match self {
            Self::Srgb => "sRGB".into(),
            Self::Bt1886 => "Rec.709".into(),
            Self::Cube(path, _) => path.display().to_string(),
        }
    }

    /// Returns the conversion.
    ///
    /// # Errors
    /// Its file cannot be read any more.
    pub fn restored(&self) -> Result<Transform, NoCube> {
        match self {
            Self::Srgb => Ok(Transform::Srgb),
            Self::Bt1886 => Ok(Transform::Bt1886),
            Self::Cube(path, takes) => Transform::read(path, *takes),
        }
    }
}
