use super::spline::Spline;
use super::{Burst, ToonError, ToonFigure};

/// Share of its draught by which a body heaps the water up before its bow.
const BOW: f64 = 0.8;

/// Something afloat that travels along a cubic Bézier curve, over and over: it presses the water down where it lies, by
/// its draught, and heaps it up before its bow. Both are bursts, so that waves run from them, and foam and lines
/// trail behind.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Body {
    /// The way of its middle: control points, times and fade are those of a burst; height and radii do not matter.
    pub way: Burst,
    /// Length in meters.
    pub length: f64,
    /// Width in meters.
    pub beam: f64,
    /// How deep it lies in meters.
    pub draught: f64,
}

impl Body {
    /// The bursts by which it moves the water: the hull, and, if it moves, the bow. The bow runs ahead by the time that
    /// half the length takes at mean speed.
    ///
    /// # Errors
    /// A length is out of range, or the bursts would be.
    pub fn bursts(&self) -> Result<Vec<Burst>, ToonError> {
        let size = (1e-3, 1e5);
        super::error::within(ToonFigure::BodyLength, self.length, size, "0.001 to 1e5 meters")?;
        super::error::within(ToonFigure::BodyBeam, self.beam, size, "0.001 to 1e5 meters")?;
        super::error::within(ToonFigure::BodyDraught, self.draught, (-1e5, 1e5), "-1e5 to 1e5 meters")?;
        self.way.validate()?;
        let hull =
            Burst { height: -self.draught, peak: 1.0, influence: [0.6 * self.length, 0.8 * self.beam], ..self.way };
        let way = Spline(self.way.path).lengths().last().copied().unwrap_or(0.0);
        let lead = self.length / 2.0 / way * self.way.duration;
        // Who does not move, or turns around within its own length, has no bow.
        if way < self.length {
            return Ok(vec![hull]);
        }
        let bow = Burst {
            height: BOW * self.draught,
            influence: [0.6 * self.beam, 0.9 * self.beam],
            offset: self.way.offset + lead,
            ..hull
        };
        Ok(vec![hull, bow])
    }
}
