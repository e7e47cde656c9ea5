use super::spline::Spline;
use super::{Burst, ToonError, ToonParameter};

/// Height of the water in front of the bow, as a share of the body's draft.
const BOW: f64 = 0.8;

/// A floating body that travels along a cubic Bézier curve, over and over: it pushes the water down under itself by
/// its draft, and piles it up in front of its bow. Both are bursts, so that waves spread from them, and foam and
/// lines trail behind.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Body {
    /// Path of its middle: control points, times and fade are those of a burst; height and radii are ignored.
    pub way: Burst,
    /// Length, in meters.
    pub length: f64,
    /// Width, in meters.
    pub beam: f64,
    /// Draft, in meters.
    pub draught: f64,
}

impl Body {
    /// Returns the bursts by which it moves the water: the hull and, if it moves, the bow. The bow is ahead by the
    /// time in which the body travels half its length at mean speed.
    ///
    /// # Errors
    /// A length is out of range, or a burst would be invalid.
    pub fn bursts(&self) -> Result<Vec<Burst>, ToonError> {
        let size = (1e-3, 1e5);
        super::error::within(ToonParameter::BodyLength, self.length, size, "0.001 to 1e5 meters")?;
        super::error::within(ToonParameter::BodyBeam, self.beam, size, "0.001 to 1e5 meters")?;
        super::error::within(ToonParameter::BodyDraught, self.draught, (-1e5, 1e5), "-1e5 to 1e5 meters")?;
        self.way.validate()?;
        let hull =
            Burst { height: -self.draught, peak: 1.0, influence: [0.6 * self.length, 0.8 * self.beam], ..self.way };
        let way = Spline(self.way.path).lengths().last().copied().unwrap_or(0.0);
        let lead = self.length / 2.0 / way * self.way.duration;
        // A body that does not move, or turns around within its own length, has no bow.
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
