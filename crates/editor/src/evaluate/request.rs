//! What is asked of the thread that evaluates, and what it tells.

use super::blame::Blamed;
use super::lens::Lens;
use super::picture::PictureError;
use super::shown::{Display, Screen};
use super::subject::Subject;
use std::sync::Arc;
use trochoid::{Format, NodeReport, Phases, Picture, RefusedFile};

/// A picture to be made.
#[derive(Clone, Debug)]
pub struct Job {
    /// Told again with the result. A job with a newer number cancels one with an older.
    pub generation: u64,
    /// Of what.
    pub subject: Subject,
    /// The frame.
    pub frame: i64,
    /// By how much the finished picture is smaller than the document's: 1, 2 or 4.
    pub proxy: u32,
    /// The part that is wanted, in shares of the picture's width and height: left, top, right, bottom.
    pub region: Option<[f32; 4]>,
    /// How it is shown.
    pub display: Display,
    /// Whether a coarse picture comes first.
    pub progressive: bool,
}

/// A picture, small or whole.
#[derive(Clone, Debug)]
pub struct Result {
    /// Whose result it is.
    pub generation: u64,
    /// The frame.
    pub frame: i64,
    /// By how much it is smaller than the document's picture.
    pub shrunk: u32,
    /// Whether it is what was asked for, and not a coarse one before that.
    pub finished: bool,
    /// What was looked at.
    pub subject: Subject,
    /// What was evaluated.
    pub lens: Arc<Lens>,
    /// The document's format, at this size.
    pub format: Format,
    /// The picture.
    pub picture: Arc<Picture>,
    /// The picture as it is shown.
    pub screen: Arc<Screen>,
    /// How it is shown.
    pub display: Display,
    /// What nodes did.
    pub nodes: Arc<Vec<NodeReport>>,
    /// Seconds by phase, and in all.
    pub seconds: (Phases, f64),
}

/// A small picture of a node, sRGB of four bytes a pixel.
#[derive(Clone, Debug)]
pub struct Thumbnail {
    /// The node.
    pub node: String,
    /// The picture.
    pub screen: Screen,
}

/// What the thread has to tell.
#[derive(Clone, Debug)]
pub enum News {
    /// A picture.
    Picture(Box<Result>),
    /// A picture of another frame than the one looked at, made ahead for playing.
    Ahead(Box<Result>),
    /// A picture of another frame could not be made.
    AheadFailed {
        /// Whose.
        generation: u64,
        /// The frame.
        frame: i64,
    },
    /// The picture that is shown, shown otherwise.
    Shown {
        /// Whose picture it is.
        generation: u64,
        /// How it is shown.
        display: Display,
        /// The picture as it is shown.
        screen: Arc<Screen>,
    },
    /// A picture that is held beside the one looked at, shown otherwise.
    Held {
        /// Which.
        number: u64,
        /// How it is shown.
        display: Display,
        /// The picture as it is shown.
        screen: Arc<Screen>,
    },
    /// How much of a picture is done.
    Progress {
        /// Whose.
        generation: u64,
        /// From 0 to 1.
        share: f32,
    },
    /// It could not be made.
    Failed {
        /// What.
        generation: u64,
        /// Why.
        why: Arc<PictureError>,
        /// Whether it was begun: what has no picture is not.
        begun: bool,
        /// Files that it may not read, of each node the first one.
        refused: Vec<RefusedFile>,
    },
    /// Pictures of nodes.
    Thumbnails(Vec<Thumbnail>),
    /// What a pixel is made of.
    Blame(Box<Blamed>),
}
