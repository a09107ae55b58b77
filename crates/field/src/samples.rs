//! Measurement error (1): what a tracker read against what it should have read.

use super::field_point::FieldPoint;
use nalgebra::{Point3, Unit, Vector3};
use serde::{Deserialize, Serialize};
use trackwright_geometry::pose::{Pose, pose_from_parts};
use trackwright_geometry::rotation::{axis_rotation, exp_vector, log_quaternion};

/// Six error values of a sensor in tracker axes: `e_pos` and `e_ori` of equation (1).
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct PoseError {
    pub position_mm: Vector3<f64>,
    /// A rotation vector in radians.
    pub rotation_rad: Vector3<f64>,
}

impl PoseError {
    /// X, Y, Z in mm and Rx, Ry, Rz in radians.
    pub fn values(&self) -> [f64; 6] {
        let (p, r) = (&self.position_mm, &self.rotation_rad);
        [p.x, p.y, p.z, r.x, r.y, r.z]
    }

    /// The largest difference in any of the six values.
    pub fn largest_difference(&self, other: &Self) -> f64 {
        let pairs = self.values().into_iter().zip(other.values());
        pairs.map(|(a, b)| (a - b).abs()).fold(0.0, f64::max)
    }

    /// The error of six values.
    pub fn of_values([x, y, z, rx, ry, rz]: [f64; 6]) -> Self {
        Self { position_mm: Vector3::new(x, y, z), rotation_rad: Vector3::new(rx, ry, rz) }
    }
}

/// A sensor's ideal pose beside the measured one, in the tracker frame.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Measurement {
    pub tracker_from_ideal: Pose,
    pub tracker_from_measured: Pose,
}

/// Root mean squares of the errors' norms.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Residuals {
    pub position_rms_mm: f64,
    /// `None` where orientations were not measured.
    pub angle_rms_rad: Option<f64>,
}

/// Measurements, and how much of them is information.
#[derive(Clone, Debug, PartialEq)]
pub struct MeasurementSet {
    pub measurements: Vec<Measurement>,
    pub content: MeasurementContent,
}

/// How much of a table's poses the tracker really measured.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub enum MeasurementContent {
    /// No orientations at all: needs a model with a single direction.
    PositionOnly,
    /// Position and local z; roll is noise.
    FiveDof,
    SixDof,
}

/// Which pose the error is a function of.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub enum MapKind {
    /// Of the ideal pose, to simulate.
    Distortion,
    /// Of the measured pose, to compensate.
    Correction,
}

/// One row of a fit: an error and where it belongs.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Sample {
    pub position_mm: Point3<f64>,
    pub axis: Unit<Vector3<f64>>,
    /// Local x of a 6-DOF reading that is to be corrected: see [`FieldPoint::x_axis`].
    pub x_axis: Option<Unit<Vector3<f64>>>,
    pub error: PoseError,
}

impl Sample {
    /// Of a sensor with one axis.
    pub fn new(position_mm: Point3<f64>, axis: Unit<Vector3<f64>>, error: PoseError) -> Self {
        Self { position_mm, axis, x_axis: None, error }
    }

    /// Where it is.
    pub fn point(&self) -> FieldPoint {
        FieldPoint { position_mm: self.position_mm, axis: self.axis, x_axis: self.x_axis }
    }

    /// Whether all its numbers are numbers and its axis has a direction. Files are checked where
    /// they are read; this is for samples that come from anywhere else.
    pub fn is_usable(&self) -> bool {
        let vectors = [
            &self.position_mm.coords,
            self.axis.as_ref(),
            &self.error.position_mm,
            &self.error.rotation_rad,
        ];
        vectors.iter().all(|v| v.iter().all(|x| x.is_finite())) && self.axis.norm() > 0.5
    }
}

/// Samples ready to be fitted.
#[derive(Clone, Debug, PartialEq)]
pub struct SampleSet {
    pub samples: Vec<Sample>,
    /// Whether the rotation errors mean anything.
    pub has_rotations: bool,
    /// Samples whose axes are opposite, so that their rotation error was chosen, not measured.
    pub ambiguous: usize,
}

impl SampleSet {
    /// No samples yet, of a table with this content.
    pub fn new(content: MeasurementContent) -> Self {
        Self {
            samples: Vec::new(),
            has_rotations: content != MeasurementContent::PositionOnly,
            ambiguous: 0,
        }
    }

    /// Adds the error of a measurement as a function of the ideal or the measured pose.
    pub fn push(&mut self, m: &Measurement, content: MeasurementContent, map: MapKind) {
        let (rotation_rad, is_ambiguous) = rotation_error(m, content);
        self.ambiguous += usize::from(is_ambiguous);
        let at = match map {
            MapKind::Distortion => &m.tracker_from_ideal,
            MapKind::Correction => &m.tracker_from_measured,
        };
        self.samples.push(Sample {
            position_mm: at.translation.vector.into(),
            axis: at.rotation * Vector3::z_axis(),
            // Simulated sensors have one axis, and what is simulated does not depend on the roll.
            x_axis: (content == MeasurementContent::SixDof && map == MapKind::Correction)
                .then(|| at.rotation * Vector3::x_axis()),
            error: PoseError {
                position_mm: m.tracker_from_measured.translation.vector
                    - m.tracker_from_ideal.translation.vector,
                rotation_rad,
            },
        });
    }
}

impl SampleSet {
    /// The samples of some rows.
    #[must_use]
    pub fn of_rows(&self, rows: &[usize]) -> Self {
        Self {
            samples: rows.iter().map(|&row| self.samples[row]).collect(),
            has_rotations: self.has_rotations,
            ambiguous: 0,
        }
    }

    /// The samples and, of each, one whose axis is turned round: a 5-DOF coil reads the same there.
    #[must_use]
    pub fn with_turned_axes(&self) -> Self {
        let turned = self.samples.iter().map(|sample| Sample { axis: -sample.axis, ..*sample });
        Self {
            samples: self.samples.iter().copied().chain(turned).collect(),
            has_rotations: self.has_rotations,
            ambiguous: 2 * self.ambiguous,
        }
    }

    /// Samples of the distortion map as measurements of a sensor with one axis; its roll is any.
    pub fn measurements(&self) -> MeasurementSet {
        let measurement = |sample: &Sample| {
            let turn = axis_rotation(&Vector3::z_axis(), &sample.axis).vector_rad;
            let rotation = exp_vector(&turn);
            let position_mm = sample.position_mm.coords;
            Measurement {
                tracker_from_ideal: pose_from_parts(position_mm, rotation),
                tracker_from_measured: pose_from_parts(
                    position_mm + sample.error.position_mm,
                    exp_vector(&sample.error.rotation_rad) * rotation,
                ),
            }
        };
        MeasurementSet {
            measurements: self.samples.iter().map(measurement).collect(),
            content: match self.has_rotations {
                true => MeasurementContent::FiveDof,
                false => MeasurementContent::PositionOnly,
            },
        }
    }
}

impl MeasurementSet {
    /// The errors as a function of the ideal or the measured pose.
    pub fn samples(&self, map: MapKind) -> SampleSet {
        let mut set = SampleSet::new(self.content);
        for measurement in &self.measurements {
            set.push(measurement, self.content, map);
        }
        set
    }
}

fn rotation_error(m: &Measurement, content: MeasurementContent) -> (Vector3<f64>, bool) {
    match content {
        MeasurementContent::PositionOnly => (Vector3::zeros(), false),
        MeasurementContent::FiveDof => {
            let turn = axis_rotation(
                &(m.tracker_from_ideal.rotation * Vector3::z_axis()),
                &(m.tracker_from_measured.rotation * Vector3::z_axis()),
            );
            (turn.vector_rad, turn.is_ambiguous)
        }
        MeasurementContent::SixDof => (
            log_quaternion(
                &(m.tracker_from_measured.rotation * m.tracker_from_ideal.rotation.inverse()),
            ),
            false,
        ),
    }
}
