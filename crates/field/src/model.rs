//! The distortion model: Bernstein polynomials per basis orientation, and its evaluation (8).

use super::bernstein::{MAX_ORDER, basis, coefficient_count};
use super::computed::{ComputedField, FieldSource, ModelKind};
pub use super::evaluation::{Coefficient, Evaluation, OutsidePolicy};
use super::field_point::FieldPoint;
use super::samples::{MapKind, PoseError};
use nalgebra::{Point3, Unit, Vector3};
use serde::Deserialize;
use std::sync::Arc;
use trackwright_geometry::bounds::{Bounds, BoundsError};
use trackwright_geometry::directions::{DirectionSet, DirectionWeights, Weighting};
use trackwright_geometry::pose::{Pose, pose_from_parts};
use trackwright_geometry::rotation::exp_vector;

/// Error of a sensor's reading as a function of its position and axis.
#[derive(Clone, Debug, PartialEq, Deserialize)]
#[serde(try_from = "ModelParts")]
pub struct DistortionModel {
    order: usize,
    directions: DirectionSet,
    weighting: Weighting,
    map: MapKind,
    bounds: Bounds,
    /// Orientation slowest, then i, j, k; none at order 0, which is no correction.
    coefficients: Vec<Coefficient>,
    /// In the place of polynomials, with order 0 and one orientation.
    computed: Option<Arc<ComputedField>>,
}

/// Why numbers do not make a model.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
pub enum ModelError {
    #[error("order is {0}, expected 0 to {MAX_ORDER}")]
    Order(usize),
    #[error(
        "{found} coefficients, expected {expected} for {directions} orientations of order {order}"
    )]
    CoefficientCount { found: usize, expected: usize, directions: usize, order: usize },
    #[error("coefficient {0} is not finite")]
    NotFinite(usize),
    #[error("box: {0}")]
    Bounds(#[from] BoundsError),
}

impl DistortionModel {
    /// A model from its coefficients: orientation slowest, then i, j, k.
    pub fn new(
        order: usize,
        directions: DirectionSet,
        weighting: Weighting,
        map: MapKind,
        bounds: Bounds,
        coefficients: Vec<Coefficient>,
    ) -> Result<Self, ModelError> {
        if order > MAX_ORDER {
            return Err(ModelError::Order(order));
        }
        let expected = match order {
            0 => 0,
            _ => directions.len() * coefficient_count(order),
        };
        if coefficients.len() != expected {
            return Err(ModelError::CoefficientCount {
                found: coefficients.len(),
                expected,
                directions: directions.len(),
                order,
            });
        }
        if let Some(i) = coefficients.iter().position(|c| c.iter().any(|v| !v.is_finite())) {
            return Err(ModelError::NotFinite(i));
        }
        bounds.check_finite()?;
        Ok(Self { order, directions, weighting, map, bounds, coefficients, computed: None })
    }

    /// A distortion map of the position alone, from its coefficients: i, then j, then k.
    ///
    /// # Errors
    /// As [`Self::new`].
    pub fn of_position(
        order: usize,
        bounds: Bounds,
        coefficients: Vec<Coefficient>,
    ) -> Result<Self, ModelError> {
        let (directions, weighting) = (DirectionSet::One, Weighting::default());
        Self::new(order, directions, weighting, MapKind::Distortion, bounds, coefficients)
    }

    /// A model of the same kind with other coefficients in another box.
    ///
    /// # Errors
    /// As [`Self::new`].
    pub fn with_coefficients(
        &self,
        order: usize,
        bounds: Bounds,
        coefficients: Vec<Coefficient>,
    ) -> Result<Self, ModelError> {
        Self::new(order, self.directions, self.weighting, self.map, bounds, coefficients)
    }

    /// A model that is no polynomial, over a box. Beyond the box it is that of the nearest point,
    /// whatever the policy.
    pub fn of_source(source: FieldSource, map: MapKind, bounds: Bounds) -> Self {
        Self::of_computed(ComputedField::new(source, bounds), map, bounds)
    }

    pub(super) fn of_computed(field: ComputedField, map: MapKind, bounds: Bounds) -> Self {
        Self { computed: Some(Arc::new(field)), ..Self::zero(bounds, map) }
    }

    /// A model from parts of another, which were checked for that one.
    pub(super) fn of_parts_known_to_fit(
        order: usize,
        directions: DirectionSet,
        weighting: Weighting,
        map: MapKind,
        bounds: Bounds,
        coefficients: Vec<Coefficient>,
    ) -> Self {
        Self { order, directions, weighting, map, bounds, coefficients, computed: None }
    }

    /// A field without distortion.
    pub fn zero(bounds: Bounds, map: MapKind) -> Self {
        Self {
            order: 0,
            directions: DirectionSet::One,
            weighting: Weighting::default(),
            map,
            bounds,
            coefficients: Vec::new(),
            computed: None,
        }
    }

    /// Whether it is the field of a room without distortion.
    pub fn is_zero(&self) -> bool {
        self.order == 0 && self.computed.is_none()
    }

    /// What computes the field, where that is no polynomial.
    pub fn computed(&self) -> Option<&Arc<ComputedField>> {
        self.computed.as_ref()
    }

    /// What kind of model it is.
    pub fn kind(&self) -> ModelKind {
        match self.computed.as_ref().map(|c| c.source()) {
            Some(FieldSource::Kriging(_)) => ModelKind::Kriging,
            Some(FieldSource::Harmonic(_)) => ModelKind::Harmonic,
            Some(FieldSource::Simulated(_)) => ModelKind::Simulated,
            Some(FieldSource::Of(_)) | None => ModelKind::Bernstein,
        }
    }

    /// Order of the polynomials; 0 where there are none.
    pub fn order(&self) -> usize {
        self.order
    }

    /// The basis orientations.
    pub fn directions(&self) -> DirectionSet {
        self.directions
    }

    /// How three basis orientations share an axis.
    pub fn weighting(&self) -> Weighting {
        self.weighting
    }

    /// Whether it is a function of the ideal or of the measured pose.
    pub fn map(&self) -> MapKind {
        self.map
    }

    /// Where the polynomials were fitted and may be used.
    pub fn bounds(&self) -> &Bounds {
        &self.bounds
    }

    /// All coefficients: orientation slowest, then i, j, k.
    pub fn coefficients(&self) -> &[Coefficient] {
        &self.coefficients
    }

    /// The coefficients of one basis orientation; none at order 0.
    pub fn of_direction(&self, direction: usize) -> &[Coefficient] {
        match self.order {
            0 => &[],
            order => {
                let len = coefficient_count(order);
                &self.coefficients[direction * len..][..len]
            }
        }
    }

    /// The error (8) of a sensor at a position in the tracker frame with a unit axis.
    ///
    /// Under [`OutsidePolicy::Reject`] the clamped value is given; the caller leaves it out.
    pub fn evaluate(
        &self,
        position_mm: &Point3<f64>,
        axis: &Unit<Vector3<f64>>,
        outside: OutsidePolicy,
    ) -> Evaluation {
        let is_inside = self.bounds.contains(position_mm);
        if let Some(computed) = &self.computed {
            return computed.evaluate(position_mm, axis);
        }
        if self.order == 0 {
            return Evaluation { error: PoseError::default(), is_inside };
        }
        let at = match outside {
            OutsidePolicy::Extrapolate => *position_mm,
            OutsidePolicy::Clamp | OutsidePolicy::Reject => self.bounds.clamp(position_mm),
        };
        let weights = self.directions.weights(axis, self.weighting);
        Evaluation { error: self.blend(&self.bounds.to_unit(&at), &weights), is_inside }
    }

    /// The error (8) of a sensor that may be of 6-DOF.
    pub fn evaluate_point(&self, at: &FieldPoint, outside: OutsidePolicy) -> Evaluation {
        let rolled = self.computed().and_then(|of| of.evaluate_rolled(std::slice::from_ref(at)));
        match rolled.as_deref() {
            Some(&[rolled]) => rolled,
            _ => self.evaluate(&at.position_mm, &at.axis, outside),
        }
    }

    /// The pose a tracker would report for a sensor: equations (6) and (7).
    ///
    /// ```
    /// use trackwright_field::{DistortionModel, OutsidePolicy};
    /// use trackwright_field::{random_models::room, samples::MapKind};
    /// use trackwright_geometry::pose::Pose;
    ///
    /// let model = DistortionModel::zero(room(), MapKind::Distortion);
    /// let pose = Pose::translation(10.0, 0.0, -200.0);
    /// assert_eq!(model.distort(&pose, OutsidePolicy::Clamp), (pose, true));
    /// ```
    pub fn distort(&self, tracker_from_sensor: &Pose, outside: OutsidePolicy) -> (Pose, bool) {
        let at = self.evaluate_point(&FieldPoint::of_pose(tracker_from_sensor), outside);
        let distorted = pose_from_parts(
            tracker_from_sensor.translation.vector + at.error.position_mm,
            exp_vector(&at.error.rotation_rad) * tracker_from_sensor.rotation,
        );
        (distorted, at.is_inside)
    }

    /// The pose behind a reading, by a model of the measured pose:
    /// `p = p_m - e_pos(p_m, n_m)`, `R = exp(-e_ori) R_m`.
    pub fn correct(&self, tracker_from_measured: &Pose, outside: OutsidePolicy) -> (Pose, bool) {
        let at = self.evaluate_point(&FieldPoint::of_pose(tracker_from_measured), outside);
        let corrected = pose_from_parts(
            tracker_from_measured.translation.vector - at.error.position_mm,
            exp_vector(&-at.error.rotation_rad) * tracker_from_measured.rotation,
        );
        (corrected, at.is_inside)
    }

    /// Sum over the three orientations and all i, j, k, innermost first: `(n + 1)³` products of
    /// six values, then `(n + 1)²`, then `n + 1`.
    fn blend(&self, unit: &Vector3<f64>, weights: &DirectionWeights) -> PoseError {
        let n = self.order + 1;
        let [bx, by, bz] = [0, 1, 2].map(|k| basis(self.order, unit[k]));
        let per_direction = n * n * n;
        let mut total = [0.0; 6];
        for (&direction, &weight) in weights.directions.iter().zip(&weights.weights) {
            if weight == 0.0 {
                continue;
            }
            let start = direction * per_direction;
            let mut rows = self.coefficients[start..start + per_direction].chunks_exact(n);
            for &x in &bx[..n] {
                let mut along_y = [0.0; 6];
                for (&y, row) in by[..n].iter().zip(&mut rows) {
                    let mut along_z = [0.0; 6];
                    for (&z, coefficient) in bz[..n].iter().zip(row) {
                        for (sum, c) in along_z.iter_mut().zip(coefficient) {
                            *sum += z * c;
                        }
                    }
                    for (sum, c) in along_y.iter_mut().zip(along_z) {
                        *sum += y * c;
                    }
                }
                for (sum, c) in total.iter_mut().zip(along_y) {
                    *sum += weight * x * c;
                }
            }
        }
        PoseError::of_values(total)
    }
}

/// A model as it stands in a file.
#[derive(Deserialize)]
#[serde(rename = "DistortionModel", deny_unknown_fields)]
struct ModelParts {
    order: usize,
    directions: DirectionSet,
    weighting: Weighting,
    map: MapKind,
    #[serde(rename = "box")]
    bounds: Bounds,
    coefficients: Vec<Coefficient>,
}

impl TryFrom<ModelParts> for DistortionModel {
    type Error = ModelError;

    fn try_from(p: ModelParts) -> Result<Self, ModelError> {
        p.bounds.check()?;
        Self::new(p.order, p.directions, p.weighting, p.map, p.bounds, p.coefficients)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::bernstein::control_points;

    fn bounds() -> Bounds {
        Bounds::from(([-100.0, -50.0, -300.0], [100.0, 50.0, -100.0]))
    }

    /// Coefficients sampled from a linear function: Bernstein form reproduces those exactly.
    fn linear_model(order: usize) -> DistortionModel {
        let net = (0..14).flat_map(|_| control_points(order));
        let coefficients = net.map(|[x, y, z]| [x, y, z, x + y, 2.0 * z, 1.0]).collect();
        DistortionModel::new(
            order,
            DirectionSet::Fourteen,
            Weighting::Area,
            MapKind::Distortion,
            bounds(),
            coefficients,
        )
        .unwrap()
    }

    #[test]
    fn linear_fields_are_reproduced_at_every_order() {
        let axis = Unit::new_normalize(Vector3::new(0.2, -0.5, 0.3));
        for order in 1..=MAX_ORDER {
            let e = linear_model(order)
                .evaluate(&Point3::new(0.0, 25.0, -150.0), &axis, OutsidePolicy::Clamp)
                .error;
            assert!((e.position_mm - Vector3::new(0.5, 0.75, 0.75)).norm() < 1e-14);
            assert!((e.rotation_rad - Vector3::new(1.25, 1.5, 1.0)).norm() < 1e-14);
        }
    }

    #[test]
    fn outside_the_box_the_policy_decides() {
        let model = linear_model(3);
        let axis = Vector3::z_axis();
        let p = Point3::new(300.0, 0.0, -200.0);
        let clamped = model.evaluate(&p, &axis, OutsidePolicy::Clamp);
        let on = model.evaluate(&p, &axis, OutsidePolicy::Extrapolate);
        assert!(!clamped.is_inside && !on.is_inside);
        assert!((clamped.error.position_mm.x - 1.0).abs() < 1e-14);
        assert!((on.error.position_mm.x - 2.0).abs() < 1e-13);
    }

    #[test]
    fn a_zero_field_moves_nothing() {
        let model = DistortionModel::zero(bounds(), MapKind::Distortion);
        let pose = Pose::translation(0.0, 0.0, 500.0);
        assert_eq!(model.distort(&pose, OutsidePolicy::Clamp), (pose, false));
    }

    #[test]
    fn numbers_that_make_no_model_are_refused() {
        let new = |order, count: usize, bounds| {
            DistortionModel::of_position(order, bounds, vec![[0.0; 6]; count])
        };
        assert!(matches!(new(13, 2744, bounds()), Err(ModelError::Order(13))));
        assert!(matches!(
            new(2, 26, bounds()),
            Err(ModelError::CoefficientCount { expected: 27, .. })
        ));
        let upside_down = Bounds::from(([1.0; 3], [0.0; 3]));
        assert!(matches!(new(1, 8, upside_down), Err(ModelError::Bounds { .. })));
    }
}
