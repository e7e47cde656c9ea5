/// A regular grid of rest points along the world's axes, row by row: x grows fastest.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Grid {
    /// First rest point, x and z in meters.
    pub origin: [f64; 2],
    /// Distance between neighbors along x and z, in meters.
    pub step: [f64; 2],
    /// Number of points along x.
    pub columns: usize,
    /// Number of points along z.
    pub rows: usize,
    /// Footprint of all points, in meters.
    pub footprint: f64,
}

/// Most points along a side of a grid.
pub const MAX_SIDE: usize = 1 << 20;
/// Most points of a grid.
pub const MAX_POINTS: usize = 1 << 31;

/// Why a grid is rejected.
#[derive(Clone, Debug, PartialEq)]
pub enum GridError {
    /// It has more points than [`MAX_SIDE`] along a side, or than [`MAX_POINTS`] in all.
    Size(usize, usize),
    /// The origin, the step or the footprint is not a finite number of meters, or the footprint is negative.
    Meters(&'static str, f64),
}

impl std::fmt::Display for GridError {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        match self {
            Self::Size(columns, rows) => write!(
                f,
                "found a grid of {columns} × {rows} points; expected at most {MAX_SIDE} along a side and \
                 {MAX_POINTS} in all"
            ),
            Self::Meters(what, found) => {
                write!(
                    f,
                    "found a grid whose {what} is {found}; expected a finite number of meters, ≥ 0 for the footprint"
                )
            }
        }
    }
}

impl std::error::Error for GridError {}

impl Grid {
    /// Checks that the grid can be evaluated.
    ///
    /// # Errors
    /// It has too many points, or a number that is not finite.
    pub fn validate(&self) -> Result<(), GridError> {
        let sides = self.columns <= MAX_SIDE && self.rows <= MAX_SIDE;
        if !sides || self.columns * self.rows > MAX_POINTS {
            return Err(GridError::Size(self.columns, self.rows));
        }
        let meters = [("origin", self.origin[0]), ("origin", self.origin[1]), ("step", self.step[0])];
        for (what, value) in meters.into_iter().chain([("step", self.step[1]), ("footprint", self.footprint)]) {
            if !value.is_finite() || (what == "footprint" && value < 0.0) {
                return Err(GridError::Meters(what, value));
            }
        }
        Ok(())
    }
}
