//! A harmonic model's errors at many poses.
//!
//! Near axes at which the coils determine a position badly an error changes within some degrees, so
//! that no smooth function of the axis stands for it. The model is evaluated itself, by the machine's
//! vectors.

use super::model::HarmonicModel;
use super::solid_harmonics::{MAX_TERMS, gradients, terms};
use crate::evaluation::Coefficient;
use crate::generator::MAX_COILS;
use crate::generator::lanes::{LANES, LaneDipole, Lanes, read_axes};
use crate::samples::PoseError;
use nalgebra::{Point3, SimdValue, Unit, Vector3};
use pulp::{Arch, Simd, WithSimd};
use trackwright_geometry::rotation::axis_rotation;

/// The work of [`HarmonicModel::axis_errors`].
struct Errors<'a> {
    model: &'a HarmonicModel,
    /// `None` for a generator with loops, which is read pose by pose.
    dipoles: Option<&'a [LaneDipole]>,
    positions_mm: &'a [Point3<f64>],
    axes: &'a [Unit<Vector3<f64>>],
    out: &'a mut [Option<Coefficient>],
}

impl WithSimd for Errors<'_> {
    type Output = ();

    #[inline(always)]
    fn with_simd<S: Simd>(self, simd: S) {
        simd.vectorize(|| {
            let places = self.positions_mm.chunks(LANES);
            let groups = places.zip(self.axes.chunks(LANES));
            for ((positions, axes), out) in groups.zip(self.out.chunks_mut(LANES)) {
                let errors =
                    self.dipoles.map(|dipoles| self.model.lane_errors(dipoles, positions, axes));
                let errors = errors.unwrap_or([None; LANES]);
                for (k, out) in out.iter_mut().enumerate() {
                    let plain = || self.model.axis_error_at(&positions[k], &axes[k]).ok();
                    *out = errors[k].or_else(plain).map(|error| error.values());
                }
            }
        });
    }
}

impl HarmonicModel {
    /// [`Self::axis_error_at`] at each pose; nothing where the tracker reports none.
    ///
    /// # Panics
    /// Where there are not as many axes and values as positions.
    pub fn axis_errors(
        &self,
        positions_mm: &[Point3<f64>],
        axes: &[Unit<Vector3<f64>>],
        out: &mut [Option<Coefficient>],
    ) {
        let count = positions_mm.len();
        assert!(axes.len() == count && out.len() == count, "one of each a pose");
        let dipoles = self.generator.lane_dipoles();
        Arch::new().dispatch(Errors {
            model: self,
            dipoles: dipoles.as_deref(),
            positions_mm,
            axes,
            out,
        });
    }

    /// Errors at up to [`LANES`] poses; nothing where the plain form has to answer.
    #[inline(always)]
    fn lane_errors(
        &self,
        dipoles: &[LaneDipole],
        positions_mm: &[Point3<f64>],
        axes: &[Unit<Vector3<f64>>],
    ) -> [Option<PoseError>; LANES] {
        let last = positions_mm.len() - 1;
        let lane = |value: &dyn Fn(usize) -> f64| {
            simba::simd::AutoSimd(std::array::from_fn(|k| value(k.min(last))))
        };
        let p = Vector3::from_fn(|c, _| lane(&|k| positions_mm[k][c]));
        let n = Vector3::from_fn(|c, _| lane(&|k| axes[k][c]));
        let disturbed = self.lane_disturbance(&p, &n);
        let read = read_axes(dipoles, &p, &n, &disturbed[..dipoles.len()]);
        std::array::from_fn(|k| {
            if k > last || !read.is_found[k] {
                return None;
            }
            let axis = Unit::new_unchecked(read.axis.map(|v| v.0[k]));
            Some(PoseError {
                position_mm: (read.position_mm - p).map(|v| v.0[k]),
                rotation_rad: axis_rotation(&axes[k], &axis).vector_rad,
            })
        })
    }

    /// What the room adds to the signal of each coil, in the first lanes of as many as there are coils.
    #[inline(always)]
    fn lane_disturbance(&self, p: &Vector3<Lanes>, n: &Vector3<Lanes>) -> [Lanes; MAX_COILS] {
        let splat = |v: f64| Lanes::splat(v);
        let x = (p - self.center_mm.coords.map(splat)) / splat(self.scale_mm);
        let mut slopes = [Vector3::repeat(splat(0.0)); MAX_TERMS];
        gradients(self.degree, &x, &mut slopes);
        let each = terms(self.degree);
        let mut along = [splat(0.0); MAX_TERMS];
        for (along, slope) in along.iter_mut().zip(&slopes[..each]) {
            *along = n.dot(slope);
        }
        let mut out = [splat(0.0); MAX_COILS];
        for (out, coefficients) in out.iter_mut().zip(self.coefficients.chunks_exact(each)) {
            let mut sum = splat(0.0);
            for (a, along) in coefficients.iter().zip(&along) {
                sum += *along * splat(*a);
            }
            *out = sum;
        }
        out
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::generator::Generator;
    use crate::random_models::Seeded;

    fn model(generator: Generator, strength: f64) -> HarmonicModel {
        let count = generator.coils.len() * terms(4);
        let mut seeded = Seeded::new(5);
        let coefficients = (0..count).map(|_| strength * (2.0 * seeded.uniform() - 1.0));
        let center = Point3::new(0.0, 0.0, -300.0);
        HarmonicModel::new(generator, center, 250.0, 4, coefficients.collect()).unwrap()
    }

    fn poses(count: usize) -> (Vec<Point3<f64>>, Vec<Unit<Vector3<f64>>>) {
        let mut seeded = Seeded::new(6);
        let mut one = || 2.0 * seeded.uniform() - 1.0;
        let each = (0..count).map(|_| {
            let p = Point3::new(200.0 * one(), 200.0 * one(), -300.0 + 200.0 * one());
            (p, Unit::new_normalize(Vector3::new(one(), one(), one())))
        });
        each.unzip()
    }

    #[test]
    fn lanes_read_what_single_readings_do() {
        // Some 1 mm, and so much that some poses have no answer.
        for (generator, strength) in [
            (Generator::planar_nine(), 1e-9),
            (Generator::planar_nine(), 3e-7),
            (Generator::anser(), 1e-9),
        ] {
            let model = model(generator, strength);
            let (positions, axes) = poses(203);
            let mut found = vec![None; 203];
            model.axis_errors(&positions, &axes, &mut found);
            for ((p, n), found) in positions.iter().zip(&axes).zip(found) {
                let plain = model.axis_error_at(p, n).ok().map(|error| error.values());
                match (found, plain) {
                    (Some(found), Some(plain)) => {
                        for c in 0..6 {
                            let gap = (found[c] - plain[c]).abs();
                            assert!(gap < 1e-8 * (1.0 + plain[c].abs()), "{gap} at {p}");
                        }
                    }
                    (found, plain) => assert_eq!(found, plain),
                }
            }
        }
    }

    #[test]
    fn a_reading_is_the_same_in_any_batch() {
        let model = model(Generator::planar_nine(), 1e-9);
        let (positions, axes) = poses(21);
        let mut all = vec![None; 21];
        model.axis_errors(&positions, &axes, &mut all);
        for first in [1, 5, 18] {
            let mut some = vec![None; 21 - first];
            model.axis_errors(&positions[first..], &axes[first..], &mut some);
            assert_eq!(some, all[first..]);
        }
    }
}
