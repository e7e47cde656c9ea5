//! Random inputs: values for stages, bounds on their errors, and the true values for the references.

use trochoid_graph::*;
use trochoid_image::Window;

/// Random number generator: Marsaglia's xorshift.
pub(super) struct Draws(pub(super) u64);

impl Draws {
    fn next(&mut self) -> u64 {
        self.0 ^= self.0 << 13;
        self.0 ^= self.0 >> 7;
        self.0 ^= self.0 << 17;
        self.0
    }

    /// Draws a number from 0 to 1.
    pub(super) fn unit(&mut self) -> f64 {
        (self.next() >> 11) as f64 / (1u64 << 53) as f64
    }

    /// Draws a number from −1 to 1.
    fn signed(&mut self) -> f64 {
        2.0 * self.unit() - 1.0
    }

    fn one_of<T: Copy>(&mut self, from: &[T]) -> T {
        from[(self.next() % from.len() as u64) as usize]
    }

    fn chance(&mut self, of: f64) -> bool {
        self.unit() < of
    }

    fn direction(&mut self) -> [f64; 3] {
        let v = [0; 3].map(|_| self.signed());
        let length = v.iter().map(|v| v * v).sum::<f64>().sqrt().max(1e-3);
        v.map(|v| v / length)
    }
}

/// A channel at one sample: the value given to the stage, and the bound of its error.
#[derive(Clone, Copy)]
pub(super) struct Drawn {
    pub(super) value: f32,
    pub(super) bound: Bound,
}

impl Drawn {
    fn exactly(value: f64) -> Self {
        Self { value: value as f32, bound: Bound::EXACT }
    }

    /// Draws a true value within the bound; if the bound is infinite, returns `other`.
    fn truth(self, draws: &mut Draws, other: f64) -> f64 {
        let value = f64::from(self.value);
        // The bound as stored in planes.
        let size = Bound::decode(self.bound.encode()).size;
        match size {
            0.0 => value,
            size if size.is_finite() => {
                value
                    + size / (1.0 + 1e-6) * if draws.chance(0.3) { draws.one_of(&[-1.0, 1.0]) } else { draws.signed() }
            }
            _ => other,
        }
    }
}

/// A connection over its window.
pub(super) struct Given {
    kind: Kind,
    window: Window,
    /// Values and bounds, by channel.
    drawn: Vec<Vec<Drawn>>,
    truths: Vec<Vec<f64>>,
}

/// Returns the range of true values, which holds regardless of the bound.
fn legal(kind: Kind, channel: usize) -> (f64, f64) {
    match (kind, Channel::ALL.get(channel)) {
        (Kind::Weights(_), _) => (0.0, 1.0),
        (Kind::Color, _) => (0.0, f64::MAX),
        (Kind::View, Some(Channel::Coverage)) => (0.0, 1.0),
        (Kind::View, Some(Channel::Depth | Channel::SlopeVariance)) => (0.0, f64::INFINITY),
        _ => (f64::NEG_INFINITY, f64::INFINITY),
    }
}

/// Ways to draw inputs.
#[derive(Clone, Copy, PartialEq)]
pub(super) enum How {
    Hostile,
    Smooth,
}

impl Given {
    pub(super) fn new(draws: &mut Draws, how: How, kind: Kind, window: Window) -> Self {
        let mut drawn: Vec<Vec<Drawn>> = vec![Vec::new(); kind.channels()];
        let slope: Vec<[f64; 3]> = drawn.iter().map(|_| [0; 3].map(|_| draws.signed())).collect();
        let size = draws.one_of(&[1e-6, 1e-5, 1e-4]);
        for place in Block::of(window, [0.5; 2]).places() {
            let sample = match how {
                How::Smooth => smooth(draws, kind, place, &slope, size),
                How::Hostile => hostile(draws, kind),
            };
            drawn.iter_mut().zip(sample).for_each(|(plane, drawn)| plane.push(drawn));
        }
        let mut given = Self { kind, window, drawn, truths: Vec::new() };
        given.redraw(draws);
        given
    }

    /// Draws other true values within the same bounds.
    pub(super) fn redraw(&mut self, draws: &mut Draws) {
        self.truths = vec![vec![0.0; self.window.area()]; self.drawn.len()];
        for sample in 0..self.window.area() {
            let other = hostile(draws, self.kind);
            for (channel, plane) in self.drawn.iter().enumerate() {
                let (low, high) = legal(self.kind, channel);
                let truth = plane[sample].truth(draws, f64::from(other[channel].value)).clamp(low, high);
                let is_whole =
                    self.kind == Kind::View && [Channel::Coverage, Channel::Surface].contains(&Channel::ALL[channel]);
                self.truths[channel][sample] = if is_whole { truth.round() } else { truth };
            }
        }
    }

    pub(super) fn planes(&self, of: impl Fn(&Drawn) -> f32) -> Vec<Vec<f32>> {
        self.drawn.iter().map(|plane| plane.iter().map(&of).collect()).collect()
    }

    /// Returns the true value at a position, as given to the reference.
    pub(super) fn reference(&self, at: [f64; 2]) -> Reference {
        let x = (at[0].floor() as i64).clamp(self.window.x0, self.window.x1 - 1) - self.window.x0;
        let y = (at[1].floor() as i64).clamp(self.window.y0, self.window.y1 - 1) - self.window.y0;
        let sample = y as usize * self.window.width() + x as usize;
        let numbers: Vec<f64> = self.truths.iter().map(|plane| plane[sample]).collect();
        match self.kind {
            Kind::View => Reference::View(numbers),
            Kind::Color => Reference::Color([numbers[0], numbers[1], numbers[2]]),
            Kind::MASK => Reference::Mask(numbers[0]),
            Kind::Weights(_) => Reference::Weights(numbers),
            _ => Reference::Field(numbers),
        }
    }
}

/// Draws a sample that varies slowly except at edges, with small bounds.
fn smooth(draws: &mut Draws, kind: Kind, [x, y]: [f64; 2], slope: &[[f64; 3]], size: f64) -> Vec<Drawn> {
    let ripple = |channel: usize| {
        let [a, b, c] = slope[channel];
        c + 0.05 * (a * x + b * y) + 0.01 * libm::sin(x * a + y * b)
    };
    let spot = |channel: usize| libm::sin(3.0 * ripple(channel) + 0.7 * x + 1.1 * y);
    let drawn = |draws: &mut Draws, value: f64| Drawn {
        value: value as f32,
        bound: Bound::of(size * (0.5 + 0.5 * draws.unit()) * value.abs().max(0.1)),
    };
    if kind != Kind::View {
        return (0..kind.channels())
            .map(|channel| {
                let value = spot(channel);
                drawn(draws, if matches!(kind, Kind::Field(_)) { value } else { 0.5 + 0.49 * value })
            })
            .collect();
    }
    let normal = [0.3 * ripple(5), 1.0, 0.3 * ripple(7)];
    let length = normal.iter().map(|v| v * v).sum::<f64>().sqrt();
    // Sky at the top, and a surface next to one that is farther away.
    let (is_sky, is_far) = (y < 1.0, x > 12.0);
    let channel = |(index, channel): (usize, &Channel)| {
        let value = match channel {
            _ if is_sky => return Drawn::exactly(f64::from(channel.background())),
            Channel::Coverage => return Drawn::exactly(1.0),
            Channel::Surface => return Drawn::exactly(f64::from(u8::from(is_far))),
            Channel::Depth => 10.0 + ripple(index) + if is_far { 4.0 } else { 0.0 },
            Channel::NormalX => normal[0] / length,
            Channel::NormalY => normal[1] / length,
            Channel::NormalZ => normal[2] / length,
            Channel::PositionX | Channel::RestX | Channel::U => 0.3 * x + ripple(index),
            Channel::PositionZ | Channel::RestZ | Channel::V => 0.3 * y + ripple(index),
            Channel::SlopeVariance => 0.002 * (1.5 + spot(index)),
            Channel::Jacobian => 0.4 + 0.3 * spot(index),
            Channel::DriftWeight => 0.6 + 0.1 * spot(index),
            // A line every few pixels, with directions that agree well.
            Channel::AlongCos | Channel::AcrossCos => 0.59 * libm::cos(0.05 * x + ripple(20)),
            Channel::AlongSin | Channel::AcrossSin => 0.59 * libm::sin(0.05 * x + ripple(20)),
            _ => spot(index),
        };
        drawn(draws, value)
    };
    Channel::ALL.iter().enumerate().map(channel).collect()
}

/// Draws a sample as extreme as its kind allows.
fn hostile(draws: &mut Draws, kind: Kind) -> Vec<Drawn> {
    let scale = draws.one_of(&[0.0, 1e-9, 1e-6, 1e-4, 1e-2, 0.3]);
    let doubt = draws.chance(0.15);
    let drawn = |draws: &mut Draws, value: f64| {
        let size = match () {
            () if doubt && draws.chance(0.3) => f64::INFINITY,
            () if draws.chance(0.2) => 0.0,
            () => scale * value.abs().max(draws.one_of(&[1e-3, 1.0])) * draws.unit(),
        };
        let size = if value.is_finite() || size.is_infinite() { size } else { 0.0 };
        Drawn { value: value as f32, bound: Bound::of(size).with(!doubt) }
    };
    let number = |draws: &mut Draws| match draws.next() % 12 {
        0 => 0.0,
        1 => 1e6 * draws.signed(),
        2 => 1e-6 * draws.signed(),
        3 => draws.one_of(&[1e30, -1e30, 1.0, -1.0, 0.5, 65504.0, 1e-45, -1e-40, 3e38]),
        _ => 3.0 * draws.signed(),
    };
    if kind != Kind::View {
        return (0..kind.channels())
            .map(|_| {
                let value = match kind {
                    Kind::Weights(_) if draws.chance(0.3) => draws.one_of(&[0.0, 1.0]),
                    Kind::Weights(_) => draws.unit(),
                    Kind::Color => draws.one_of(&[0.0, 0.5, 3.0, 65504.0, 1e30, 1e-42]) * draws.unit(),
                    _ if draws.chance(0.03) => draws.one_of(&[f64::INFINITY, f64::NEG_INFINITY]),
                    _ => number(draws),
                };
                drawn(draws, value)
            })
            .collect();
    }
    let covered = !draws.chance(0.15);
    let normal = match draws.next() % 8 {
        0 => [0.0; 3],
        1 => draws.one_of(&[[0.0, 1.0, 0.0], [0.0, -1.0, 0.0], [1.0, 0.0, 0.0], [0.3, 0.6, 0.4]]),
        2 => draws.direction().map(|v| v * 1e-18),
        3 => draws.direction().map(|v| v * 40.0),
        _ => draws.direction(),
    };
    let position = match draws.next() % 8 {
        0 => draws.one_of(&[[1.0, 4.0, 2.0], [2.0, 6.0, 3.0], [0.0, 5.0, 10.0]]),
        1 => draws.direction().map(|v| v * 1e6),
        2 => draws.direction().map(|v| v * 1e15),
        _ => [0; 3].map(|_| 5.0 * draws.signed()),
    };
    let channel = |channel: &Channel| {
        let value = match channel {
            Channel::Coverage if doubt => {
                return Drawn { value: f32::from(u8::from(covered)), bound: Bound::of(1.0).with(false) };
            }
            Channel::Coverage => return Drawn::exactly(f64::from(u8::from(covered))),
            _ if !covered && !doubt => return Drawn::exactly(f64::from(channel.background())),
            Channel::Surface => {
                let value = draws.one_of(&[0.0, 0.0, 1.0, 2.0]);
                let bound = if doubt { Bound::of(draws.one_of(&[0.0, 1.0, 64.0])).with(false) } else { Bound::EXACT };
                return Drawn { value: value as f32, bound };
            }
            Channel::Depth if draws.chance(0.1) => f64::INFINITY,
            Channel::Depth => draws.one_of(&[1e-40, 1e-3, 1.0, 10.0, 1e5, 1e30]) * draws.unit(),
            Channel::NormalX => normal[0],
            Channel::NormalY => normal[1],
            Channel::NormalZ => normal[2],
            Channel::PositionX => position[0],
            Channel::PositionY => position[1],
            Channel::PositionZ => position[2],
            Channel::SlopeVariance => draws.one_of(&[0.0, 1e-6, 0.1, 1e6]) * draws.unit(),
            Channel::DriftWeight => draws.one_of(&[0.0, 1e-4, 1.0]) * draws.unit(),
            _ => number(draws),
        };
        drawn(draws, value)
    };
    Channel::ALL.iter().map(channel).collect()
}
