//! The number type of the core: `f64` or `f32`.

use core::fmt::{Debug, Display};
use core::ops::{Add, AddAssign, Div, Mul, Neg, Sub, SubAssign};

mod sealed {
    pub trait Sealed {}
    impl Sealed for f32 {}
    impl Sealed for f64 {}
}

/// A real number the core can compute with, `f64` or `f32`.
///
/// Every transcendental function goes through `libm`, with or without `std`, so that the same
/// samples give the same forces on every target.
pub trait Scalar:
    sealed::Sealed
    + Copy
    + Debug
    + Display
    + Default
    + PartialOrd
    + Add<Output = Self>
    + AddAssign
    + Sub<Output = Self>
    + SubAssign
    + Mul<Output = Self>
    + Div<Output = Self>
    + Neg<Output = Self>
    + Send
    + Sync
    + 'static
{
    /// 0.
    const ZERO: Self;
    /// 1.
    const ONE: Self;
    /// 1/2.
    const HALF: Self;
    /// 2.
    const TWO: Self;
    /// Positive infinity.
    const INFINITY: Self;
    /// Distance from 1 to the next larger number.
    const EPSILON: Self;
    /// pi.
    const PI: Self;

    /// The nearest representable number.
    fn from_f64(value: f64) -> Self;
    /// The same number as `f64`.
    fn to_f64(self) -> f64;
    /// Neither infinite nor NaN.
    fn is_finite(self) -> bool;
    /// Absolute value.
    #[must_use]
    fn abs(self) -> Self;
    /// Square root.
    #[must_use]
    fn sqrt(self) -> Self;
    /// Sine and cosine of an angle in radians.
    fn sin_cos(self) -> (Self, Self);
    /// Exponential.
    #[must_use]
    fn exp(self) -> Self;
    /// `exp(self) - 1` without cancellation near 0.
    #[must_use]
    fn exp_m1(self) -> Self;
    /// Arc sine in radians.
    #[must_use]
    fn asin(self) -> Self;
    /// Angle of the point (`x`, `self`) in radians.
    #[must_use]
    fn atan2(self, x: Self) -> Self;
    /// Length of the hypotenuse of the sides `self` and `other`.
    #[must_use]
    fn hypot(self, other: Self) -> Self;
    /// Largest integer not above the number.
    #[must_use]
    fn floor(self) -> Self;
    /// The number to the power `exponent`.
    #[must_use]
    fn powf(self, exponent: Self) -> Self;

    /// The smaller of two numbers.
    #[inline]
    #[must_use]
    fn min(self, other: Self) -> Self {
        if other < self { other } else { self }
    }
    /// The larger of two numbers.
    #[inline]
    #[must_use]
    fn max(self, other: Self) -> Self {
        if other > self { other } else { self }
    }
    /// The number limited to `[-bound, bound]`, for `bound >= 0`.
    #[inline]
    #[must_use]
    fn within(self, bound: Self) -> Self {
        self.min(bound).max(-bound)
    }
}

macro_rules! scalar {
    ($t:ident, $abs:path, $sqrt:path, $sincos:path, $exp:path, $expm1:path, $asin:path,
     $atan2:path, $hypot:path, $floor:path, $pow:path) => {
        impl Scalar for $t {
            const ZERO: Self = 0.0;
            const ONE: Self = 1.0;
            const HALF: Self = 0.5;
            const TWO: Self = 2.0;
            const INFINITY: Self = $t::INFINITY;
            const EPSILON: Self = $t::EPSILON;
            const PI: Self = core::$t::consts::PI;

            #[inline]
            #[allow(clippy::cast_possible_truncation)] // rounding to f32 is what is asked for
            fn from_f64(value: f64) -> Self {
                value as $t
            }
            #[inline]
            fn to_f64(self) -> f64 {
                f64::from(self)
            }
            #[inline]
            fn is_finite(self) -> bool {
                $t::is_finite(self)
            }
            #[inline]
            fn abs(self) -> Self {
                $abs(self)
            }
            #[inline]
            fn sqrt(self) -> Self {
                $sqrt(self)
            }
            #[inline]
            fn sin_cos(self) -> (Self, Self) {
                $sincos(self)
            }
            #[inline]
            fn exp(self) -> Self {
                $exp(self)
            }
            #[inline]
            fn exp_m1(self) -> Self {
                $expm1(self)
            }
            #[inline]
            fn asin(self) -> Self {
                $asin(self)
            }
            #[inline]
            fn atan2(self, x: Self) -> Self {
                $atan2(self, x)
            }
            #[inline]
            fn hypot(self, other: Self) -> Self {
                $hypot(self, other)
            }
            #[inline]
            fn floor(self) -> Self {
                $floor(self)
            }
            #[inline]
            fn powf(self, exponent: Self) -> Self {
                $pow(self, exponent)
            }
        }
    };
}

scalar!(
    f64,
    libm::fabs,
    libm::sqrt,
    libm::sincos,
    libm::exp,
    libm::expm1,
    libm::asin,
    libm::atan2,
    libm::hypot,
    libm::floor,
    libm::pow
);
scalar!(
    f32,
    libm::fabsf,
    libm::sqrtf,
    libm::sincosf,
    libm::expf,
    libm::expm1f,
    libm::asinf,
    libm::atan2f,
    libm::hypotf,
    libm::floorf,
    libm::powf
);
