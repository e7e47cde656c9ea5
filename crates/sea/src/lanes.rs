//! Short vectors used as numbers, so that one library transform runs for several lines at once, with the same bits on
//! every processor.

use rustfft::FftNum;
use rustfft::num_complex::Complex;
use rustfft::num_traits::{FromPrimitive, Num, One, Signed, Zero};
use std::ops::{Add, Div, Mul, Neg, Rem, Sub};

/// Number of values in a [`Lanes`].
pub(crate) const WIDTH: usize = 4;

/// Floating-point type of the transforms.
pub(crate) trait Real: FftNum {
    /// Converts to the nearest number of this type.
    fn of(value: f64) -> Self;
    /// Converts to the nearest f32.
    fn single(self) -> f32;
}

impl Real for f32 {
    #[inline(always)]
    fn of(value: f64) -> Self {
        value as f32
    }

    #[inline(always)]
    fn single(self) -> f32 {
        self
    }
}

impl Real for f64 {
    #[inline(always)]
    fn of(value: f64) -> Self {
        value
    }

    #[inline(always)]
    fn single(self) -> f32 {
        self as f32
    }
}

/// Four numbers that are added and multiplied together: `rustfft` transforms them as if they were one number.
///
/// Only its plain code is used, never the code for one processor: sums and products in one order, none of them fused.
#[derive(Clone, Copy, Debug, PartialEq)]
#[repr(align(16))]
pub(crate) struct Lanes<T>(pub(crate) [T; WIDTH]);

/// Complex numbers of the transforms.
pub(crate) type Line<T> = Complex<Lanes<T>>;

impl<T: Real> Lanes<T> {
    #[inline(always)]
    pub(crate) fn splat(value: T) -> Self {
        Self([value; WIDTH])
    }
}

/// Returns four copies of a complex number.
#[inline(always)]
pub(crate) fn splat<T: Real>(value: Complex<T>) -> Line<T> {
    Complex::new(Lanes::splat(value.re), Lanes::splat(value.im))
}

macro_rules! lanewise {
    ($($operator:ident $name:ident),*) => {$(
        impl<T: Real> $operator for Lanes<T> {
            type Output = Self;

            #[inline(always)]
            fn $name(self, other: Self) -> Self {
                let ([a, b, c, d], [e, f, g, h]) = (self.0, other.0);
                Self([a.$name(e), b.$name(f), c.$name(g), d.$name(h)])
            }
        }
    )*};
}

lanewise!(Add add, Sub sub, Mul mul, Div div, Rem rem);

impl<T: Real> Neg for Lanes<T> {
    type Output = Self;

    #[inline(always)]
    fn neg(self) -> Self {
        Self(self.0.map(Neg::neg))
    }
}

impl<T: Real> Zero for Lanes<T> {
    #[inline(always)]
    fn zero() -> Self {
        Self::splat(T::zero())
    }

    fn is_zero(&self) -> bool {
        self.0.iter().all(Zero::is_zero)
    }
}

impl<T: Real> One for Lanes<T> {
    fn one() -> Self {
        Self::splat(T::one())
    }
}

impl<T: Real> Num for Lanes<T> {
    type FromStrRadixErr = T::FromStrRadixErr;

    fn from_str_radix(text: &str, radix: u32) -> Result<Self, Self::FromStrRadixErr> {
        T::from_str_radix(text, radix).map(Self::splat)
    }
}

impl<T: Real> Signed for Lanes<T> {
    fn abs(&self) -> Self {
        Self(self.0.map(|value| value.abs()))
    }

    fn abs_sub(&self, other: &Self) -> Self {
        Self(std::array::from_fn(|lane| self.0[lane].abs_sub(&other.0[lane])))
    }

    fn signum(&self) -> Self {
        Self(self.0.map(|value| value.signum()))
    }

    fn is_positive(&self) -> bool {
        self.0.iter().all(Signed::is_positive)
    }

    fn is_negative(&self) -> bool {
        self.0.iter().all(Signed::is_negative)
    }
}

impl<T: Real> FromPrimitive for Lanes<T> {
    fn from_i64(value: i64) -> Option<Self> {
        T::from_i64(value).map(Self::splat)
    }

    fn from_u64(value: u64) -> Option<Self> {
        T::from_u64(value).map(Self::splat)
    }

    /// Called by `rustfft` for its sines, which come from the system's library: the last bits, in which such
    /// libraries differ, are rounded off.
    fn from_f64(value: f64) -> Option<Self> {
        const KEPT: f64 = (1_u64 << 44) as f64;
        Some(Self::splat(T::of(libm::rint(value * KEPT) / KEPT)))
    }
}
