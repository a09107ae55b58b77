//! A harmonic model's errors at many poses.
//!
//! Near axes at which the coils determine a position badly an error changes within some degrees, so
//! that no smooth function of the axis stands for it. The model is evaluated itself, by the machine's
//! vectors.

use super::HarmonicModel;
use crate::field::model::{Coefficient, values_of};
use nalgebra::{Point3, Unit, Vector3};
use pulp::{Arch, Simd, WithSimd};

/// The work of [`HarmonicModel::axis_errors`].
struct Errors<'a> {
    model: &'a HarmonicModel,
    positions_mm: &'a [Point3<f64>],
    axes: &'a [Unit<Vector3<f64>>],
    out: &'a mut [Option<Coefficient>],
}

impl WithSimd for Errors<'_> {
    type Output = ();

    #[inline(always)]
    fn with_simd<S: Simd>(self, simd: S) {
        simd.vectorize(|| {
            let poses = self.positions_mm.iter().zip(self.axes);
            for (out, (position, axis)) in self.out.iter_mut().zip(poses) {
                let error = self.model.axis_error_at(position, axis);
                *out = error.ok().map(|error| values_of(&error));
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
        assert!(
            axes.len() == count && out.len() == count,
            "one of each a pose"
        );
        Arch::new().dispatch(Errors {
            model: self,
            positions_mm,
            axes,
            out,
        });
    }
}
