use super::{MAX_CELLS, MAX_CROWD, MAX_DROPS, MAX_STEPS, MAX_WORK};

figures! {
    /// A figure of a spray.
    SprayFigure {
        Center = "center",
        Size = "size",
        Cell = "cell",
        Rate = "rate",
        Threshold = "threshold",
        Width = "width",
        Density = "density",
        Follow = "follow",
        Speed = "speed",
        Cone = "cone",
        Wind = "wind",
        Drag = "drag",
        Lifetime = "lifetime",
        Radius = "radius",
        Growth = "growth",
        Vary = "vary",
        Tuft = "tuft",
        Torn = "torn",
        Bursts = "bursts",
    }
}

/// Why a spray is refused.
#[derive(Clone, Debug, PartialEq)]
pub enum SprayError {
    /// A figure is not finite, or outside what it can mean.
    Figure(SprayFigure, f64),
    /// More cells than [`MAX_CELLS`].
    Cells(f64, f64),
    /// More steps in a lifetime than [`MAX_STEPS`].
    Steps(f64),
    /// More cells times steps than [`MAX_WORK`].
    Work(f64),
    /// More drops a cell and step than [`MAX_CROWD`].
    Crowd(f64),
    /// More drops at a time than [`MAX_DROPS`].
    Drops,
    /// Nothing is wrong: it was told to stop.
    Stopped,
}

impl SprayError {
    /// The figure that is best changed.
    pub fn figure(&self) -> SprayFigure {
        match self {
            Self::Figure(figure, _) => *figure,
            Self::Cells(..) => SprayFigure::Cell,
            Self::Steps(_) | Self::Work(_) => SprayFigure::Rate,
            Self::Crowd(_) | Self::Drops | Self::Stopped => SprayFigure::Density,
        }
    }
}

impl std::fmt::Display for SprayError {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        match self {
            Self::Figure(figure, found) => {
                write!(f, "{figure} {found} is refused: use a finite number that is not negative")
            }
            Self::Cells(columns, rows) => write!(
                f,
                "{columns} × {rows} cells are refused: at most {MAX_CELLS}; make \"size\" smaller or \"cell\" larger"
            ),
            Self::Steps(steps) => write!(
                f,
                "{steps} steps in a lifetime are refused: at most {MAX_STEPS}; make \"rate\" or \"lifetime\" smaller"
            ),
            Self::Work(work) => write!(
                f,
                "{work} cells over all steps of a lifetime are refused: at most {MAX_WORK}; make \"size\", \"rate\" or \
                 \"lifetime\" smaller, or \"cell\" larger"
            ),
            Self::Crowd(crowd) => write!(
                f,
                "{crowd} drops from a cell in a step are refused: at most {MAX_CROWD}; make \"density\" or \"cell\" \
                 smaller, or \"rate\" larger"
            ),
            Self::Drops => write!(
                f,
                "more than {MAX_DROPS} drops at a time are refused; make \"density\", \"size\", \"lifetime\" or the \
                 counts of \"bursts\" smaller"
            ),
            Self::Stopped => f.write_str("stopped"),
        }
    }
}

impl std::error::Error for SprayError {}
