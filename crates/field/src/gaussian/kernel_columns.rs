//! Covariances of many sensor poses with one, in the lanes of the machine's vectors: nearly all the time
//! of a process is spent here.

use super::kernel::KernelScale;
use crate::field_point::FieldPoint;
use nalgebra::{Unit, Vector3};
use pulp::{Arch, Simd, WithSimd};

/// Places and axes of sensor poses, coordinate by coordinate.
#[derive(Clone, Debug)]
pub(super) struct PointColumns {
    coordinates: [Vec<f64>; 6],
    /// The second axes, where the poses have some.
    x_axes: Option<[Vec<f64>; 3]>,
}

impl PointColumns {
    pub fn of(points: &[FieldPoint]) -> Self {
        let column = |c: usize| -> Vec<f64> {
            let each = points.iter().map(|point| match c {
                0..3 => point.position_mm[c],
                _ => point.axis[c - 3],
            });
            each.collect()
        };
        let x_axes: Option<Vec<_>> = points.iter().map(|point| point.x_axis).collect();
        let x_axes = x_axes.filter(|axes| !axes.is_empty());
        let of = |axes: Vec<Unit<Vector3<f64>>>| {
            std::array::from_fn(|c| axes.iter().map(|axis| axis[c]).collect())
        };
        Self { coordinates: std::array::from_fn(column), x_axes: x_axes.map(of) }
    }

    fn len(&self) -> usize {
        self.coordinates[0].len()
    }

    /// Covariances of the poses from `first` on with one other, Matérn 5/2 in position.
    pub fn matern(&self, scales: &[KernelScale; 2], first: usize, with: &FieldPoint) -> Vec<f64> {
        self.covariances::<false>(scales, first, with)
    }

    /// The same, Gaussian in position.
    pub fn gaussian(&self, scales: &[KernelScale; 2], first: usize, with: &FieldPoint) -> Vec<f64> {
        self.covariances::<true>(scales, first, with)
    }

    fn covariances<const IS_GAUSSIAN: bool>(
        &self,
        scales: &[KernelScale; 2],
        first: usize,
        with: &FieldPoint,
    ) -> Vec<f64> {
        let times = if IS_GAUSSIAN { 1.0 } else { 5.0_f64.sqrt() };
        let mut out = vec![0.0; self.len() - first];
        let scales = scales.map(|scale| Scale {
            by_mm: times / scale.length_mm,
            by_sine_squared: 0.5 / (scale.axis_sine * scale.axis_sine),
            by_x_sine_squared: 0.5 / (scale.x_axis_sine * scale.x_axis_sine),
            variance: scale.variance,
        });
        let points = self.coordinates.each_ref().map(|column| &column[first..]);
        let with_x = with.x_axis.map_or_else(Vector3::zeros, Unit::into_inner);
        let (arch, out_mut) = (Arch::new(), &mut out[..]);
        match &self.x_axes {
            None => arch.dispatch(Fill::<IS_GAUSSIAN, false> {
                scales,
                points,
                x_axes: [&[]; 3],
                with,
                with_x,
                out: out_mut,
            }),
            Some(x_axes) => arch.dispatch(Fill::<IS_GAUSSIAN, true> {
                scales,
                points,
                x_axes: x_axes.each_ref().map(|column| &column[first..]),
                with,
                with_x,
                out: out_mut,
            }),
        }
        out
    }
}

/// Exponentials, in place.
///
/// After a product of matrices scalar code on that core takes twice as long: the upper halves of the vector
/// registers are left set. They are cleared when this returns.
pub(super) fn exponentials(values: &mut [f64]) {
    Arch::new().dispatch(Exponentials(values));
}

struct Exponentials<'a>(&'a mut [f64]);

impl WithSimd for Exponentials<'_> {
    type Output = ();

    #[inline(always)]
    fn with_simd<S: Simd>(self, simd: S) {
        simd.vectorize(
            #[inline(always)]
            || {
                for value in self.0 {
                    *value = exp(*value);
                }
            },
        );
    }
}

/// A length scale as it is computed with.
#[derive(Clone, Copy)]
struct Scale {
    by_mm: f64,
    by_sine_squared: f64,
    by_x_sine_squared: f64,
    variance: f64,
}

struct Fill<'a, const IS_GAUSSIAN: bool, const HAS_X: bool> {
    scales: [Scale; 2],
    points: [&'a [f64]; 6],
    /// Empty without `HAS_X`.
    x_axes: [&'a [f64]; 3],
    with: &'a FieldPoint,
    with_x: Vector3<f64>,
    out: &'a mut [f64],
}

impl<const IS_GAUSSIAN: bool, const HAS_X: bool> WithSimd for Fill<'_, IS_GAUSSIAN, HAS_X> {
    type Output = ();

    #[inline(always)]
    fn with_simd<S: Simd>(self, simd: S) {
        let Self { scales, points: [x, y, z, a, b, c], x_axes, with, with_x, out } = self;
        let n = out.len();
        let [d, e, f] = x_axes.map(|column| if HAS_X { &column[..n] } else { column });
        let [pd, pe, pf]: [f64; 3] = with_x.into();
        let (x, y, z) = (&x[..n], &y[..n], &z[..n]);
        let (a, b, c) = (&a[..n], &b[..n], &c[..n]);
        let [px, py, pz]: [f64; 3] = with.position_mm.coords.into();
        let [pa, pb, pc]: [f64; 3] = with.axis.into_inner().into();
        simd.vectorize(
            #[inline(always)]
            || {
                for i in 0..n {
                    let (dx, dy, dz) = (x[i] - px, y[i] - py, z[i] - pz);
                    let distance_mm = (dx * dx + dy * dy + dz * dz).sqrt();
                    let cosine = a[i] * pa + b[i] * pb + c[i] * pc;
                    let sine_squared = (1.0 - cosine * cosine).max(0.0);
                    let x_sine_squared = if HAS_X {
                        let cosine = d[i] * pd + e[i] * pe + f[i] * pf;
                        (1.0 - cosine * cosine).max(0.0)
                    } else {
                        0.0
                    };
                    let mut sum = 0.0;
                    for scale in &scales {
                        let t = scale.by_mm * distance_mm;
                        let mut turn = scale.by_sine_squared * sine_squared;
                        if HAS_X {
                            turn += scale.by_x_sine_squared * x_sine_squared;
                        }
                        sum += match IS_GAUSSIAN {
                            true => scale.variance * exp(-(0.5 * t * t + turn)),
                            false => scale.variance * (1.0 + t + t * t / 3.0) * exp(-(t + turn)),
                        };
                    }
                    out[i] = sum;
                }
            },
        );
    }
}

/// Below its opposite the exponential is negligible against any noise.
const MOST_EXPONENT: f64 = 700.0;

/// Adding it leaves a number's nearest integer in the lowest bits.
const TO_INTEGER: f64 = 6_755_399_441_055_744.0;

/// The logarithm of 2 in two parts, the first with zeros at its end.
const LN_2_HIGH: f64 = 0.693_147_180_369_123_8;
const LN_2_LOW: f64 = 1.908_214_929_270_587_7e-10;

/// 1 / k! from the highest: the series of an exponential on half of the logarithm of 2 on each side ends
/// below round-off.
const SERIES: [f64; 14] = {
    let mut series = [1.0; 14];
    let (mut k, mut factorial) = (1, 1.0);
    while k < 14 {
        factorial *= k as f64;
        series[13 - k] = 1.0 / factorial;
        k += 1;
    }
    series
};

/// `exp(x)` without a branch, so that it is done in lanes: within 5e-16 of it, and `exp(±700)` beyond ±700.
#[inline(always)]
fn exp(x: f64) -> f64 {
    let x = x.clamp(-MOST_EXPONENT, MOST_EXPONENT);
    let shifted = x * std::f64::consts::LOG2_E + TO_INTEGER;
    let whole = shifted - TO_INTEGER;
    let rest = (x - whole * LN_2_HIGH) - whole * LN_2_LOW;
    let mut sum = SERIES[0];
    for coefficient in &SERIES[1..] {
        sum = sum * rest + coefficient;
    }
    // The integer goes where a number keeps its power of 2.
    sum * f64::from_bits((shifted.to_bits() << 52).wrapping_add(1.0_f64.to_bits()))
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::gaussian::Kernel;
    use nalgebra::Point3;

    #[test]
    fn the_exponential_is_right_to_round_off() {
        let exponents: Vec<f64> = (-70_000..70_000).map(|i| f64::from(i) * 0.01).collect();
        let mut found = exponents.clone();
        exponentials(&mut found);
        for (x, found) in exponents.iter().zip(found) {
            assert!((found / x.exp() - 1.0).abs() < 5e-16, "{x}: {found}");
        }
        assert_eq!(exp(0.0), 1.0);
        assert!(exp(-1e9) < 1e-300);
    }

    #[test]
    fn many_at_once_are_what_each_is_alone() {
        for has_x in [false, true] {
            check_many_at_once(has_x);
        }
    }

    fn check_many_at_once(has_x: bool) {
        let x_axis = |i: i32| Unit::new_normalize(Vector3::new(1.0, f64::from(i % 4) - 2.0, 0.3));
        let point = |i: i32| FieldPoint {
            position_mm: Point3::new(f64::from(i) * 7.3, f64::from(i % 5) * 11.0, -3.0),
            axis: Unit::new_normalize(Vector3::new(0.3, f64::from(i % 7) - 3.0, 0.8)),
            x_axis: has_x.then(|| x_axis(i)),
        };
        let points: Vec<_> = (0..37).map(point).collect();
        let scale = |length_mm, axis_sine| KernelScale {
            length_mm,
            axis_sine,
            x_axis_sine: 0.6,
            variance: 0.7,
        };
        let scales = [scale(90.0, 0.4), scale(30.0, f64::INFINITY)];
        let kernel = Kernel { scales, nugget: 1e-4 };
        let (columns, with) = (PointColumns::of(&points), &points[20]);
        let gaussian = columns.gaussian(&scales, 4, with);
        let found = columns.matern(&scales, 4, with);
        for ((found, gaussian), other) in found.iter().zip(gaussian).zip(&points[4..]) {
            let expected = kernel.covariance(other, with);
            assert!((found - expected).abs() < 1e-15, "{found} {expected}");
            let distance_mm = (other.position_mm - with.position_mm).norm();
            let second = other.x_axis.zip(with.x_axis).map_or(0.0, |(a, b)| a.cross(&b).norm());
            let sine = other.axis.cross(&with.axis).norm();
            let each = scales.map(|s| {
                let along = (distance_mm / s.length_mm).hypot(second / s.x_axis_sine);
                along.hypot(sine / s.axis_sine)
            });
            let expected: f64 = each.map(|t| 0.7 * (-0.5 * t * t).exp()).iter().sum();
            assert!((gaussian - expected).abs() < 1e-15, "{gaussian} {expected}");
        }
    }
}
