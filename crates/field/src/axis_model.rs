//! A distortion model for one axis: the orientations blended once, many positions after that.

use super::batch::Batch;
use super::computed::ComputedField;
use super::evaluation::Linearization;
use super::evaluation::{Coefficient, Evaluation, OutsidePolicy};
use super::model::DistortionModel;
use nalgebra::{Point3, Unit, Vector3};
use pulp::Arch;
use trackwright_geometry::bounds::Bounds;
use trackwright_geometry::directions::{DirectionSet, Weighting};

/// The field of a sensor whose axis stays: a third of the work at each position.
#[derive(Clone, Debug, PartialEq)]
pub struct AxisModel {
    /// With the one orientation that is left.
    model: DistortionModel,
}

impl DistortionModel {
    /// The mean of the model over its basis orientations, of a model of one orientation that one:
    /// what is taken for the field at a place where nothing has an axis, as at a marker.
    pub fn mean_over_axes(&self) -> AxisModel {
        if let Some(computed) = self.computed() {
            return self.of_one_axis(computed.at_axis(None));
        }
        let count = self.directions().len();
        let mut mean = vec![[0.0; 6]; self.of_direction(0).len()];
        for direction in 0..count {
            let own = self.of_direction(direction).as_flattened();
            for (sum, value) in mean.as_flattened_mut().iter_mut().zip(own) {
                *sum += value / count as f64;
            }
        }
        self.of_blended(mean)
    }

    /// The model for an axis, or the mean over axes where there is none.
    pub fn at_axis_or_mean(&self, axis: Option<&Unit<Vector3<f64>>>) -> AxisModel {
        axis.map_or_else(|| self.mean_over_axes(), |axis| self.at_axis(axis))
    }

    /// The model for one axis.
    ///
    /// ```
    /// use nalgebra::Vector3;
    /// use trackwright_field::OutsidePolicy::Clamp;
    /// use trackwright_field::random_models::{random_model, room};
    /// use trackwright_geometry::directions::{DirectionSet, Weighting};
    ///
    /// let model = random_model(2, DirectionSet::Twelve, Weighting::Area, [1.0, 0.01], 7);
    /// let (at, axis) = (room().center_mm(), Vector3::y_axis());
    /// let blended = model.at_axis(&axis).evaluate(&at, Clamp).error;
    /// let whole = model.evaluate(&at, &axis, Clamp).error;
    /// assert!((blended.position_mm - whole.position_mm).norm() < 1e-13);
    /// ```
    pub fn at_axis(&self, axis: &Unit<Vector3<f64>>) -> AxisModel {
        if let Some(computed) = self.computed() {
            return self.of_one_axis(computed.at_axis(Some(axis)));
        }
        let weights = self.directions().weights(axis, self.weighting());
        let [a, b, c] = weights.directions.map(|d| self.of_direction(d).as_flattened());
        let [wa, wb, wc] = weights.weights;
        let mut blended = vec![[0.0; 6]; a.len() / 6];
        let sums = blended.as_flattened_mut();
        Arch::new().dispatch(|| {
            for (((sum, a), b), c) in sums.iter_mut().zip(a).zip(b).zip(c) {
                *sum = wa * a + wb * b + wc * c;
            }
        });
        self.of_blended(blended)
    }

    fn of_one_axis(&self, field: ComputedField) -> AxisModel {
        AxisModel { model: Self::of_computed(field, self.map(), *self.bounds()) }
    }

    fn of_blended(&self, coefficients: Vec<Coefficient>) -> AxisModel {
        AxisModel {
            model: DistortionModel::of_parts_known_to_fit(
                self.order(),
                DirectionSet::One,
                Weighting::default(),
                self.map(),
                *self.bounds(),
                coefficients,
            ),
        }
    }
}

impl AxisModel {
    /// The model, with the one orientation that is left.
    pub(super) fn model(&self) -> &DistortionModel {
        &self.model
    }

    /// Order of the polynomials; 0 for a field without distortion.
    pub fn order(&self) -> usize {
        self.model.order()
    }

    /// Where the polynomials were fitted and may be used.
    pub fn bounds(&self) -> &Bounds {
        self.model.bounds()
    }

    /// The coefficients of this axis: i, j, k.
    pub fn coefficients(&self) -> &[Coefficient] {
        self.model.coefficients()
    }

    /// What [`DistortionModel::evaluate`] gives at a position for this axis.
    pub fn evaluate(&self, position_mm: &Point3<f64>, outside: OutsidePolicy) -> Evaluation {
        self.model.evaluate(position_mm, &Vector3::z_axis(), outside)
    }

    /// What [`DistortionModel::evaluate_with_jacobian`] gives at a position for this axis, without
    /// the change by the axis.
    pub fn evaluate_with_jacobian(
        &self,
        position_mm: &Point3<f64>,
        outside: OutsidePolicy,
    ) -> Linearization {
        self.model.evaluate_with_jacobian(position_mm, &Vector3::z_axis(), outside)
    }

    /// What [`AxisModel::evaluate`] gives at each position, with the buffers of a batch.
    pub fn evaluate_all(
        &self,
        batch: &mut Batch,
        positions_mm: &[Point3<f64>],
        outside: OutsidePolicy,
        out: &mut Vec<Evaluation>,
    ) {
        batch.evaluate_positions(&self.model, positions_mm, outside, out);
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::batch::Instructions;
    use crate::random_models::{random_model, room};
    use crate::samples::MapKind;

    fn positions() -> Vec<Point3<f64>> {
        (0..101)
            .map(|i| {
                let t = f64::from(i);
                let unit = Vector3::new((0.7 * t).sin(), (1.3 * t).cos(), (0.4 * t).sin());
                room().center_mm() + room().size_mm().component_mul(&unit) * 0.6
            })
            .collect()
    }

    #[test]
    fn one_axis_at_a_time_is_the_same_field() {
        for set in DirectionSet::ALL {
            for order in 1..=8 {
                let model = random_model(order, set, Weighting::Area, [1.0, 1.0], order as u64);
                let axes = [
                    Unit::new_normalize(Vector3::new(0.3, -0.7, 0.2)),
                    set.directions()[set.len() - 1],
                ];
                for axis in axes {
                    let at_axis = model.at_axis(&axis);
                    let (mut batch, mut all) = (Batch::default(), Vec::new());
                    at_axis.evaluate_all(&mut batch, &positions(), OutsidePolicy::Clamp, &mut all);
                    assert_eq!(all.len(), positions().len());
                    for (p, in_batch) in positions().iter().zip(all) {
                        let expected = model.evaluate(p, &axis, OutsidePolicy::Clamp);
                        for found in [at_axis.evaluate(p, OutsidePolicy::Clamp), in_batch] {
                            assert_eq!(found.is_inside, expected.is_inside);
                            let d = found.error.largest_difference(&expected.error);
                            assert!(d < 1e-13, "{set:?} {order} {d}");
                        }
                    }
                }
            }
        }
    }

    #[test]
    fn all_instructions_extrapolate_alike() {
        let model = random_model(3, DirectionSet::Six, Weighting::Area, [1.0, 1.0], 3);
        let axis = Unit::new_normalize(Vector3::new(0.3, -0.7, 0.2));
        let at_axis = model.at_axis(&axis);
        for level in [Instructions::Best, Instructions::Avx2, Instructions::Portable] {
            let mut out = Vec::new();
            let outside = OutsidePolicy::Extrapolate;
            let mut batch = Batch::with_instructions(level);
            at_axis.evaluate_all(&mut batch, &positions(), outside, &mut out);
            for (p, found) in positions().iter().zip(out) {
                let expected = model.evaluate(p, &axis, outside);
                let d = found.error.position_mm - expected.error.position_mm;
                // Outside the box a basis of order 3 reaches some ten.
                assert!(d.amax() < 1e-12, "{level:?} {d}");
            }
        }
    }

    #[test]
    fn without_distortion_there_is_none_for_any_axis() {
        let bounds = Bounds::from(([0.0; 3], [1.0; 3]));
        let model = DistortionModel::zero(bounds, MapKind::Distortion);
        let at_axis = model.at_axis(&Vector3::x_axis());
        let at = at_axis.evaluate(&Point3::new(2.0, 0.0, 0.0), OutsidePolicy::Clamp);
        assert_eq!(at.error.position_mm, Vector3::zeros());
        assert!(!at.is_inside);
    }
}
