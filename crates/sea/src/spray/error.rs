use super::{MAX_CELLS, MAX_CROWD, MAX_DROPS, MAX_STEPS, MAX_WORK};

parameters! {
    /// A parameter of a spray.
    SprayParameter {
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

/// Why a spray is rejected.
#[derive(Clone, Debug, PartialEq)]
pub enum SprayError {
    /// A number is not finite, or outside of its meaningful range.
    Parameter(SprayParameter, f64),
    /// There are more cells than [`MAX_CELLS`].
    Cells(f64, f64),
    /// A lifetime has more steps than [`MAX_STEPS`].
    Steps(f64),
    /// Cells times steps exceed [`MAX_WORK`].
    Work(f64),
    /// A cell has more drops per step than [`MAX_CROWD`].
    Crowd(f64),
    /// There are more drops at a time than [`MAX_DROPS`].
    Drops,
    /// The evaluation was told to stop; nothing is wrong.
    Stopped,
}

impl SprayError {
    /// Returns the parameter that is best changed.
    pub fn parameter(&self) -> SprayParameter {
        match self {
            Self::Parameter(parameter, _) => *parameter,
            Self::Cells(..) => SprayParameter::Cell,
            Self::Steps(_) | Self::Work(_) => SprayParameter::Rate,
            Self::Crowd(_) | Self::Drops | Self::Stopped => SprayParameter::Density,
        }
    }
}

impl std::fmt::Display for SprayError {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        match self {
            Self::Parameter(parameter, found) => {
                write!(f, "{parameter} {found}: use a finite number that is not negative")
            }
            Self::Cells(columns, rows) => {
                write!(f, "{columns} × {rows} cells, more than {MAX_CELLS}: make \"size\" smaller or \"cell\" larger")
            }
            Self::Steps(steps) => {
                write!(f, "{steps} steps in a lifetime, more than {MAX_STEPS}: make \"rate\" or \"lifetime\" smaller")
            }
            Self::Work(work) => write!(
                f,
                "{work} cells over all steps of a lifetime, more than {MAX_WORK}: make \"size\", \"rate\" or \
                 \"lifetime\" smaller, or \"cell\" larger"
            ),
            Self::Crowd(crowd) => write!(
                f,
                "{crowd} drops from a cell in a step, more than {MAX_CROWD}: make \"density\" or \"cell\" \
                 smaller, or \"rate\" larger"
            ),
            Self::Drops => write!(
                f,
                "more than {MAX_DROPS} drops at a time: make \"density\", \"size\", \"lifetime\" or the \
                 counts of \"bursts\" smaller"
            ),
            Self::Stopped => f.write_str("stopped"),
        }
    }
}

impl std::error::Error for SprayError {}
