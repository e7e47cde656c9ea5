//! Inverse Fourier transforms of lengths without a prime factor greater than 5.
//!
//! The planner of `rustfft` chooses an algorithm when the program runs, so all of its algorithms are compiled for each
//! type of number: half of this crate's code, of which these lengths need a small part. Here the choice is between that
//! part alone. It is the planner's choice (version 6.4, of `FftPlannerScalar`): the same steps with the same butterflies
//! and the same factors, so that results have the same bits.

use rustfft::algorithm::butterflies::{
    Butterfly2, Butterfly3, Butterfly4, Butterfly5, Butterfly6, Butterfly8, Butterfly9, Butterfly12, Butterfly16,
    Butterfly24, Butterfly27, Butterfly32,
};
use rustfft::algorithm::{Dft, GoodThomasAlgorithmSmall, MixedRadixSmall, Radix4};
use rustfft::num_complex::Complex;
use rustfft::num_traits::Zero;
use rustfft::{Fft, FftDirection, FftNum};
use std::f64::consts::PI;
use std::sync::Arc;

/// Direction of all transforms.
const INVERSE: FftDirection = FftDirection::Inverse;

/// An inverse transform of one length, without the factor 1/length.
pub(crate) enum Transform<T> {
    /// An algorithm of the library.
    Whole(Arc<dyn Fft<T>>),
    /// Several different radices above a butterfly: the library offers this algorithm through its planner only.
    Layered(Layered<T>),
}

impl<T: FftNum> Transform<T> {
    /// Plans a transform. It is slow if the length has a prime factor greater than 5.
    pub(crate) fn new(length: usize) -> Self {
        if let Some(whole) = butterfly(length) {
            return Self::Whole(whole);
        }
        if let Some((left, right)) = product(length)
            && let (Some(first), Some(second)) = (butterfly(left), butterfly(right))
        {
            return Self::Whole(if are_coprime(left, right) {
                Arc::new(GoodThomasAlgorithmSmall::new(first, second))
            } else {
                Arc::new(MixedRadixSmall::new(first, second))
            });
        }
        let Some((base, rest)) = base(length).and_then(|base| Some((butterfly(base)?, length / base))) else {
            return Self::Whole(Arc::new(Dft::new(length, INVERSE)));
        };
        let doublings = rest.trailing_zeros();
        if rest.is_power_of_two() && doublings.is_multiple_of(2) {
            return Self::Whole(Arc::new(Radix4::new_with_base(doublings / 2, base)));
        }
        Self::Layered(Layered::new(base, &radices(rest)))
    }

    /// Returns how many values [`process`](Self::process) needs for itself.
    pub(crate) fn scratch_len(&self) -> usize {
        match self {
            Self::Whole(whole) => whole.get_inplace_scratch_len(),
            Self::Layered(layered) => layered.order.len(),
        }
    }

    /// Transforms values in place. What `scratch` holds does not matter.
    pub(crate) fn process(&self, values: &mut [Complex<T>], scratch: &mut [Complex<T>]) {
        match self {
            Self::Whole(whole) => whole.process_with_scratch(values, scratch),
            Self::Layered(layered) => layered.process(values, scratch),
        }
    }
}

/// Returns the transform of a length for which there is a butterfly.
fn butterfly<T: FftNum>(length: usize) -> Option<Arc<dyn Fft<T>>> {
    Some(match length {
        0 | 1 => Arc::new(Dft::new(length, INVERSE)),
        2 => Arc::new(Butterfly2::new(INVERSE)),
        3 => Arc::new(Butterfly3::new(INVERSE)),
        4 => Arc::new(Butterfly4::new(INVERSE)),
        5 => Arc::new(Butterfly5::new(INVERSE)),
        6 => Arc::new(Butterfly6::new(INVERSE)),
        8 => Arc::new(Butterfly8::new(INVERSE)),
        9 => Arc::new(Butterfly9::new(INVERSE)),
        12 => Arc::new(Butterfly12::new(INVERSE)),
        16 => Arc::new(Butterfly16::new(INVERSE)),
        24 => Arc::new(Butterfly24::new(INVERSE)),
        27 => Arc::new(Butterfly27::new(INVERSE)),
        32 => Arc::new(Butterfly32::new(INVERSE)),
        _ => return None,
    })
}

/// Returns the two butterflies whose product is a length, with the least sum.
fn product(length: usize) -> Option<(usize, usize)> {
    const BUTTERFLIES: [usize; 11] = [2, 3, 4, 5, 6, 8, 9, 16, 24, 27, 32];
    if length.is_power_of_two() {
        return None;
    }
    let pairs = BUTTERFLIES.iter().map(|&left| (left, length / left));
    let pairs = pairs.filter(|&(left, right)| left <= right && left * right == length && BUTTERFLIES.contains(&right));
    pairs.min_by_key(|(left, right)| left + right)
}

fn are_coprime(mut a: usize, mut b: usize) -> bool {
    while b != 0 {
        (a, b) = (b, a % b);
    }
    a == 1
}

/// Returns the length of the butterfly below the other radices, or nothing if the length has a prime factor greater
/// than 5.
fn base(length: usize) -> Option<usize> {
    let mut rest = length;
    let [twos, threes, fives] = [2, 3, 5].map(|prime| {
        let mut count = 0_usize;
        while rest.is_multiple_of(prime) {
            rest /= prime;
            count += 1;
        }
        count
    });
    let is_odd = twos % 2 == 1;
    (rest == 1).then(|| match (twos, threes, fives) {
        (_, 0, 0) => {
            if is_odd {
                8
            } else {
                16
            }
        }
        (_, 1, 0) => {
            if is_odd {
                24
            } else {
                12
            }
        }
        (1.., 1.., _) => match twos.saturating_sub(threes) {
            0 => 6,
            1 => 12,
            _ => 24,
        },
        (_, 3.., _) => 27,
        (_, 2, _) => 9,
        _ => 5,
    })
}

/// Returns the radices above the base, from the lowest on.
fn radices(mut rest: usize) -> Vec<usize> {
    let mut radices = Vec::new();
    for radix in [6, 5, 3] {
        while rest.is_multiple_of(radix) {
            rest /= radix;
            radices.push(radix);
        }
    }
    let doublings = rest.trailing_zeros() as usize;
    radices.extend(std::iter::repeat_n(2, doublings % 2));
    radices.extend(std::iter::repeat_n(4, doublings / 2));
    radices
}

/// A transform of mixed radix (Cooley and Tukey 1965), with all layers in place.
pub(crate) struct Layered<T> {
    base: Arc<dyn Fft<T>>,
    /// By place: index of the value that belongs there before the transforms of the base.
    order: Vec<usize>,
    layers: Vec<Layer<T>>,
}

/// A step that joins as many neighboring transforms as its radix says to one.
struct Layer<T> {
    butterfly: Radix<T>,
    /// Factors of all rows but the first, by column.
    factors: Vec<Complex<T>>,
}

enum Radix<T> {
    Two(Butterfly2<T>),
    Three(Butterfly3<T>),
    Four(Butterfly4<T>),
    Five(Butterfly5<T>),
    Six(Butterfly6<T>),
}

impl<T: FftNum> Layered<T> {
    fn new(base: Arc<dyn Fft<T>>, radices: &[usize]) -> Self {
        let mut length = base.len();
        let layers = radices.iter().map(|&radix| {
            let columns = length;
            length *= radix;
            let factors = (0..columns).flat_map(|column| (1..radix).map(move |row| column * row));
            Layer { butterfly: Radix::new(radix), factors: factors.map(|index| root(index, length)).collect() }
        });
        let layers: Vec<Layer<T>> = layers.collect();
        // The digits of a place, one for each layer, are those of the value's index in reverse.
        let count = length / base.len();
        let places = (0..count).map(|place| {
            let (mut place, mut index) = (place, 0);
            for radix in radices {
                index = index * radix + place % radix;
                place /= radix;
            }
            index
        });
        let order = places.flat_map(|first| (0..base.len()).map(move |step| first + step * count)).collect();
        Self { base, order, layers }
    }

    fn process(&self, values: &mut [Complex<T>], scratch: &mut [Complex<T>]) {
        let work = &mut scratch[..values.len()];
        for (to, &from) in work.iter_mut().zip(&self.order) {
            *to = values[from];
        }
        // Butterflies need no scratch.
        self.base.process_with_scratch(work, &mut []);
        let mut columns = self.base.len();
        for Layer { butterfly, factors } in &self.layers {
            columns *= match butterfly {
                Radix::Two(butterfly) => join::<T, 2, 1>(butterfly, factors, columns, work),
                Radix::Three(butterfly) => join::<T, 3, 2>(butterfly, factors, columns, work),
                Radix::Four(butterfly) => join::<T, 4, 3>(butterfly, factors, columns, work),
                Radix::Five(butterfly) => join::<T, 5, 4>(butterfly, factors, columns, work),
                Radix::Six(butterfly) => join::<T, 6, 5>(butterfly, factors, columns, work),
            };
        }
        values.copy_from_slice(work);
    }
}

impl<T: FftNum> Radix<T> {
    fn new(radix: usize) -> Self {
        match radix {
            2 => Self::Two(Butterfly2::new(INVERSE)),
            3 => Self::Three(Butterfly3::new(INVERSE)),
            4 => Self::Four(Butterfly4::new(INVERSE)),
            5 => Self::Five(Butterfly5::new(INVERSE)),
            _ => Self::Six(Butterfly6::new(INVERSE)),
        }
    }
}

/// Number of columns that are joined at once.
const TOGETHER: usize = 8;

/// Joins transforms of `columns` values each, and returns the radix `N`. `REST` is N − 1.
#[inline(never)]
fn join<T: FftNum, const N: usize, const REST: usize>(
    butterfly: &impl Fft<T>,
    factors: &[Complex<T>],
    columns: usize,
    values: &mut [Complex<T>],
) -> usize {
    let (factors, _) = factors.as_chunks::<REST>();
    let mut room = [[Complex::zero(); N]; TOGETHER];
    for part in values.chunks_exact_mut(N * columns) {
        for (factors, first) in factors.chunks(TOGETHER).zip((0..).step_by(TOGETHER)) {
            let room = &mut room[..factors.len()];
            for ((joined, factors), column) in room.iter_mut().zip(factors).zip(first..) {
                joined[0] = part[column];
                for (row, factor) in factors.iter().enumerate() {
                    joined[row + 1] = part[(row + 1) * columns + column] * *factor;
                }
            }
            butterfly.process_with_scratch(room.as_flattened_mut(), &mut []);
            for (joined, column) in room.iter().zip(first..) {
                for (row, value) in joined.iter().enumerate() {
                    part[row * columns + column] = *value;
                }
            }
        }
    }
    N
}

/// Returns e^{2πi·index/length}, as the library computes it.
fn root<T: FftNum>(index: usize, length: usize) -> Complex<T> {
    let angle = -2.0 * PI / length as f64 * index as f64;
    // Numbers of every type that is transformed come from any f64.
    let of = |value: f64| T::from_f64(value).unwrap_or_else(T::zero);
    let (sin, cos) = libm::sincos(angle);
    Complex::new(of(cos), of(sin)).conj()
}
