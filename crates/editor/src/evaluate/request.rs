//! Requests to the evaluation thread, and its answers.

use super::blame::Blamed;
use super::error::PictureError;
use super::lane::Lane;
use super::lens::Lens;
use super::mixture::Mixture;
use super::shown::{Display, Screen};
use super::subject::Subject;
use std::sync::Arc;
use std::time::Duration;
use trochoid::{Format, Kind, NodeReport, Phases, Picture, RefusedFile, Window};

/// Request for a picture.
#[derive(Clone, Debug)]
pub struct Job {
    /// Generation number, repeated in the result. A job with a newer number cancels one with an older.
    pub generation: u64,
    /// Subject to evaluate.
    pub subject: Subject,
    /// The frame.
    pub frame: i64,
    /// Factor by which the finished picture is smaller than the document's: 1, 2, or 4.
    pub proxy: u32,
    /// Requested region, in fractions of the picture's width and height: left, top, right, bottom.
    pub region: Option<[f32; 4]>,
    /// Display settings.
    pub display: Display,
    /// Whether coarse previews come first.
    pub progressive: bool,
}

/// An evaluated picture, coarse or finished.
#[derive(Clone, Debug)]
pub struct Result {
    /// Generation number of the job.
    pub generation: u64,
    /// The frame.
    pub frame: i64,
    /// Factor by which the picture is smaller than the document's.
    pub shrunk: u32,
    /// Whether the picture has the requested size, rather than being a coarse preview.
    pub finished: bool,
    /// Subject that was evaluated.
    pub subject: Subject,
    /// Lens through which it was evaluated.
    pub lens: Arc<Lens>,
    /// The document's format, at this size.
    pub format: Format,
    /// The pixels that were evaluated.
    pub window: Window,
    /// The picture; without planes if only the converted one is kept.
    pub picture: Arc<Picture>,
    /// The picture converted for the screen.
    pub screen: Arc<Screen>,
    /// Display settings of the conversion.
    pub display: Display,
    /// Report of each node.
    pub nodes: Arc<Vec<NodeReport>>,
    /// Seconds per phase, and in total.
    pub seconds: (Phases, f64),
}

impl Result {
    /// Returns the time that the nodes took, if all threads shared it.
    pub fn work(&self) -> Duration {
        let threads = std::thread::available_parallelism().map_or(1, std::num::NonZero::get);
        Duration::from_secs_f64(self.nodes.iter().map(|node| node.seconds).sum::<f64>() / threads as f64)
    }

    /// Returns what playback needs: the converted picture, without the values of colors.
    pub fn played(&self) -> Self {
        let mut played = self.clone();
        if self.picture.kind == Kind::Color {
            let Picture { output, kind, guarantee, audit, control_count, control_colors, hull, margin, planes: _ } =
                &*self.picture;
            played.picture = Arc::new(Picture {
                output: *output,
                kind: *kind,
                planes: Vec::new(),
                guarantee: *guarantee,
                audit: *audit,
                control_count: *control_count,
                control_colors: control_colors.clone(),
                hull: hull.clone(),
                margin: *margin,
            });
        }
        played
    }

    /// Returns whether there are no values behind the converted picture.
    pub fn is_bare(&self) -> bool {
        self.picture.planes.is_empty()
    }

    /// Returns the memory used by the picture, in bytes.
    pub fn bytes(&self) -> usize {
        self.screen.pixels.len() + self.picture.planes.iter().map(|plane| 4 * plane.samples().len()).sum::<usize>()
    }
}

/// Thumbnail of a node, sRGB with four bytes per pixel.
#[derive(Clone, Debug)]
pub struct Thumbnail {
    /// The node.
    pub node: String,
    /// The picture.
    pub screen: Screen,
}

/// Message from the evaluation thread.
#[derive(Clone, Debug)]
pub enum News {
    /// A picture.
    Picture(Box<Result>),
    /// A frame evaluated ahead for playback.
    Ahead(Box<Result>),
    /// A frame could not be evaluated ahead.
    AheadFailed {
        /// Generation number of the job.
        generation: u64,
        /// The frame.
        frame: i64,
    },
    /// The current picture, converted with other display settings.
    Shown {
        /// Generation number of the picture.
        generation: u64,
        /// Display settings.
        display: Display,
        /// The picture converted for the screen.
        screen: Arc<Screen>,
    },
    /// The held picture, converted with other display settings.
    Held {
        /// Number of the held picture.
        number: u64,
        /// Display settings.
        display: Display,
        /// The picture converted for the screen.
        screen: Arc<Screen>,
    },
    /// Progress of a picture.
    Progress {
        /// Generation number of the job.
        generation: u64,
        /// Completed fraction, from 0 to 1.
        share: f32,
    },
    /// A picture could not be evaluated.
    Failed {
        /// Generation number of the job.
        generation: u64,
        /// Reason.
        why: Arc<PictureError>,
        /// Whether evaluation had started; it does not start if the node has no picture.
        begun: bool,
        /// Files that may not be read; the first one of each node.
        refused: Vec<RefusedFile>,
    },
    /// Thumbnails of nodes.
    Thumbnails(Vec<Thumbnail>),
    /// Composition of a pixel.
    Blame(Box<Blamed>),
    /// The recipe of a picture.
    Mixture(Box<Mixture>),
    /// The recipe of a picture is not that of an earlier text, and is evaluated later.
    UnknownMixture {
        /// Generation number of the picture.
        generation: u64,
    },
    /// Completed share of a picture's recipe, from 0 to 1.
    Mixing {
        /// Generation number of the picture.
        generation: u64,
        /// Completed share.
        share: f32,
    },
    /// A picture has no recipe.
    Unmixed {
        /// Generation number of the picture.
        generation: u64,
        /// Reason, as a sentence.
        why: String,
    },
}

impl News {
    /// Returns the viewer that the message is for.
    pub fn lane(&self) -> Lane {
        match self {
            Self::Picture(result) => Lane::of(result.generation),
            Self::Shown { generation, .. } | Self::Progress { generation, .. } | Self::Failed { generation, .. } => {
                Lane::of(*generation)
            }
            Self::Held { number, .. } => Lane::of(*number),
            Self::Blame(blamed) => Lane::of(blamed.generation),
            _ => Lane::First,
        }
    }
}
