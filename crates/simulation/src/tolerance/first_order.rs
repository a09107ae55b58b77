//! What sensors that are off do to the tip, to first order, and which way they do most.
//!
//! A body whose sensors are off by `e` and `φ` is fitted as if it had moved by the small motion of
//! `tracking::uncertainty`: `t = mean(e)`, `θ = A⁻¹ [Σ x × e + w² Σ (I − n nᵀ) φ]`. It is the same
//! in the body's frame at every pose. With the tool at `R` in the CRF and its tip at `p` from the
//! mean of the CRF's sensors, the tip error becomes
//!
//! `e' = e + R (t_T + θ_T × d) − (t_C + θ_C × p)`, and the turn `ε' = ε + R θ_T − θ_C`.
//!
//! So nine numbers decide on the tip and six on the turn, however many sensors there are: with the
//! twelve of `m = (b_T, θ_T, t_C, θ_C)`, `b_T = t_T + θ_T × d`, the mean square is `q + 2 c·m + mᵀ Q m`.
//!
//! Each sensor's error is in a ball, and `m` is linear in them. RMS and maximum are convex, so the
//! worst is at the edge of every ball, where the linear function that touches is largest in each: a
//! step there never makes it less (Journée, Nesterov, Richtárik and Sepulchre, J. Machine Learning
//! Research 11, 2010). It ends in a local maximum; many starts find others. A 95th percentile is not
//! convex; the same steps, along what the poses about it give, are kept where they lead up.

use super::as_built::{AS_DRAWN, BuildErrors, BuiltStudy};
use super::sheet::BuiltBody;
use crate::body::{RigidBody, SensorOrientation};
use crate::linear_fit::LinearFit;
use crate::metric::{ErrorOf, Metric, Summary};
use nalgebra::{Matrix3, Point3, SMatrix, SVector, Unit, Vector3};
use trackwright_field::samples::PoseError;
use trackwright_geometry::pose::Pose;
use trackwright_geometry::rotation::{log_quaternion, perpendicular};

/// `(b_T, θ_T, t_C, θ_C)`: mm and radians.
pub type Motions = SVector<f64, 12>;
type Jacobian = SMatrix<f64, 3, 12>;

/// What one sensor's error of one kind does.
#[derive(Clone, Copy, Debug)]
pub struct Block {
    pub body: BuiltBody,
    pub sensor: usize,
    pub kind: ErrorOf,
    /// Of a unit error, mm or radian.
    effect: SMatrix<f64, 12, 3>,
    /// Turns about it are no error: the axis of a 5-DOF sensor, for its angle.
    idle_axis: Option<Unit<Vector3<f64>>>,
}

impl Block {
    /// The unit error along a vector, without what is no error.
    pub fn unit_along(&self, vector: &Vector3<f64>) -> Vector3<f64> {
        let (error, other) = match &self.idle_axis {
            None => (*vector, Vector3::x()),
            Some(axis) => {
                (vector - axis.into_inner() * axis.dot(vector), perpendicular(axis).into_inner())
            }
        };
        // What is left of a vector along the axis is round-off.
        error.try_normalize(1e-9 * vector.norm()).unwrap_or(other)
    }
}

/// A way of being off: a unit vector for each block.
pub type Direction = Vec<Vector3<f64>>;

/// One bound of the requirement.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Bound {
    summary: Summary,
    of: ErrorOf,
    limit: f64,
}

impl Bound {
    fn new((metric, limit): (Metric, f64)) -> Self {
        Self { summary: metric.summary, of: metric.of, limit }
    }

    /// Whether every pose has to be looked at to know its figure.
    pub fn is_costly(&self) -> bool {
        self.summary != Summary::Rms
    }
}

/// One pose of the study as drawn, linearised.
#[derive(Clone, Copy, Debug)]
struct Linear {
    tip_error_mm: Vector3<f64>,
    turn_rad: Vector3<f64>,
    /// Of the simulated pose.
    crf_from_tool: Matrix3<f64>,
    /// From the mean of the CRF's sensors to the tip, CRF axes.
    tip_lever_mm: Vector3<f64>,
}

/// The mean of a squared error over the poses.
#[derive(Clone, Debug)]
struct MeanSquare {
    constant: f64,
    linear: Motions,
    quadratic: SMatrix<f64, 12, 12>,
}

/// The linearised study.
#[derive(Clone, Debug)]
pub struct FirstOrder {
    poses: Vec<Linear>,
    position_mm2: MeanSquare,
    turn_rad2: MeanSquare,
    pub bounds: Vec<Bound>,
    pub blocks: Vec<Block>,
}

impl FirstOrder {
    /// Linearised about the simulated poses of the study as drawn.
    pub fn new(study: &BuiltStudy, simulated: &[Pose]) -> Self {
        let scenario = study.scenario();
        let tip_in_tool = scenario.tool.judged_tip_in_body();
        let crf = scenario.crf.as_ref();
        let weight_mm = scenario.orientation_weight_mm;
        let center = crf.map_or_else(Point3::origin, |c| {
            Point3::from(-LinearFit::new(&c.body, weight_mm).lever_mm(&Point3::origin()))
        });
        let poses: Vec<Linear> = study
            .crf_from_tool()
            .zip(simulated)
            .filter(|((_, is_kept), _)| *is_kept)
            .map(|((pose, _), simulated)| Linear {
                tip_error_mm: simulated * tip_in_tool - pose * tip_in_tool,
                turn_rad: log_quaternion(&(simulated.rotation * pose.rotation.inverse())),
                crf_from_tool: simulated.rotation.to_rotation_matrix().into_inner(),
                tip_lever_mm: simulated * tip_in_tool - center,
            })
            .collect();
        let mut blocks = blocks(&scenario.tool, weight_mm, BuiltBody::Tool, &tip_in_tool);
        if let Some(crf) = crf {
            blocks.extend(self::blocks(&crf.body, weight_mm, BuiltBody::Crf, &center));
        }
        Self {
            position_mm2: mean_square(&poses, ErrorOf::Position),
            turn_rad2: mean_square(&poses, ErrorOf::Angle),
            bounds: study.requirement().bounds().map(Bound::new).collect(),
            poses,
            blocks,
        }
    }

    /// What the blocks do at so many mm and radians each.
    pub fn motions(&self, blocks: &[usize], sizes: &[f64], direction: &Direction) -> Motions {
        let each = blocks.iter().zip(sizes).zip(direction);
        each.map(|((&block, size), unit)| self.blocks[block].effect * (unit * *size)).sum()
    }

    /// A bound's figure as a part of its limit.
    pub fn ratio(&self, bound: &Bound, motions: &Motions) -> f64 {
        let value = match bound.summary {
            Summary::Rms => {
                let mean = self.mean_square(bound.of);
                let square = mean.constant
                    + 2.0 * mean.linear.dot(motions)
                    + (mean.quadratic * motions).dot(motions);
                square.max(0.0).sqrt()
            }
            summary => {
                let errors = self.poses.iter().map(|p| p.error(bound.of, motions));
                let mut lengths: Vec<f64> = errors.map(|e| e.norm()).collect();
                match lengths.is_empty() {
                    true => f64::INFINITY,
                    false => summary.of(&mut lengths),
                }
            }
        };
        let value = if bound.of == ErrorOf::Angle { value.to_degrees() } else { value };
        part(value, bound.limit)
    }

    /// The next direction: where the function that touches the figure at `motions` is largest.
    pub fn step(
        &self,
        bound: &Bound,
        blocks: &[usize],
        motions: &Motions,
        direction: &Direction,
    ) -> Direction {
        let gradient = match bound.summary {
            Summary::Rms => {
                let mean = self.mean_square(bound.of);
                mean.linear + mean.quadratic * motions
            }
            _ => {
                let errors = self.poses.iter().map(|p| p.error(bound.of, motions));
                self.gradient(bound, errors)
            }
        };
        self.along(&gradient, blocks, direction)
    }

    /// The same from simulated poses, which know more than the first order.
    pub fn step_from(
        &self,
        bound: &Bound,
        blocks: &[usize],
        errors: impl Iterator<Item = [Vector3<f64>; 2]>,
        direction: &Direction,
    ) -> Direction {
        let errors = errors.map(|[tip, turn]| match bound.of {
            ErrorOf::Position => tip,
            ErrorOf::Angle => turn,
        });
        self.along(&self.gradient(bound, errors), blocks, direction)
    }

    /// Up to a factor, how a figure grows with the motions; from the errors of the kept poses.
    fn gradient(&self, bound: &Bound, errors: impl Iterator<Item = Vector3<f64>>) -> Motions {
        let errors: Vec<Vector3<f64>> = errors.collect();
        let count = errors.len().saturating_sub(1) as f64;
        let is_rms = bound.summary == Summary::Rms;
        let mut order: Vec<usize> = (0..errors.len()).collect();
        if !is_rms {
            let length = |i: usize| errors[i].norm_squared();
            order.sort_by(|&a, &b| length(a).total_cmp(&length(b)));
        }
        let ranks = bound.summary.ranks();
        let first = (count * ranks.start()).floor() as usize;
        let last = (count * ranks.end()).ceil() as usize;
        order
            .into_iter()
            .take(last + 1)
            .skip(first)
            .filter_map(|i| {
                let (error, pose) = (errors[i], self.poses.get(i)?);
                let pull = match is_rms {
                    true => error,
                    false => error.try_normalize(0.0)?,
                };
                Some(pose.jacobian(bound.of).transpose() * pull)
            })
            .sum()
    }

    /// The unit errors that go furthest along a gradient; one without influence stays.
    fn along(&self, gradient: &Motions, blocks: &[usize], direction: &Direction) -> Direction {
        let each = blocks.iter().zip(direction);
        each.map(|(&block, before)| {
            let pull = self.blocks[block].effect.transpose() * gradient;
            let unit = pull.try_normalize(0.0);
            unit.filter(|v| v.iter().all(|c| c.is_finite())).unwrap_or(*before)
        })
        .collect()
    }

    /// By how much the errors of a kept pose change: tip in mm and turn.
    pub fn change_at(&self, pose: usize, motions: &Motions) -> [Vector3<f64>; 2] {
        ErrorOf::ALL.map(|of| {
            let pose = &self.poses[pose];
            pose.error(of, motions) - pose.error(of, &Motions::zeros())
        })
    }

    fn mean_square(&self, of: ErrorOf) -> &MeanSquare {
        match of {
            ErrorOf::Position => &self.position_mm2,
            ErrorOf::Angle => &self.turn_rad2,
        }
    }

    /// The errors of a direction at given sizes.
    pub fn build_errors(
        &self,
        study: &BuiltStudy,
        blocks: &[usize],
        sizes: &[f64],
        direction: &Direction,
    ) -> BuildErrors {
        let mut errors = BuildErrors::none(study.scenario());
        for ((&block, size), unit) in blocks.iter().zip(sizes).zip(direction) {
            let block = &self.blocks[block];
            let of_body = match block.body {
                BuiltBody::Tool => &mut errors.tool,
                BuiltBody::Crf => &mut errors.crf,
            };
            let error = &mut of_body[block.sensor];
            match block.kind {
                ErrorOf::Position => error.position_mm = unit * *size,
                ErrorOf::Angle => error.rotation_rad = unit * *size,
            }
        }
        errors
    }
}

impl Linear {
    fn error(&self, of: ErrorOf, m: &Motions) -> Vector3<f64> {
        let three = |at: usize| -> Vector3<f64> { m.fixed_rows::<3>(at).into_owned() };
        match of {
            ErrorOf::Position => {
                self.tip_error_mm + self.crf_from_tool * three(0)
                    - three(6)
                    - three(9).cross(&self.tip_lever_mm)
            }
            ErrorOf::Angle => self.turn_rad + self.crf_from_tool * three(3) - three(9),
        }
    }

    fn jacobian(&self, of: ErrorOf) -> Jacobian {
        let mut j = Jacobian::zeros();
        let tool = match of {
            ErrorOf::Position => 0,
            ErrorOf::Angle => 3,
        };
        j.fixed_columns_mut::<3>(tool).copy_from(&self.crf_from_tool);
        match of {
            ErrorOf::Position => {
                j.fixed_columns_mut::<3>(6).copy_from(&-Matrix3::identity());
                j.fixed_columns_mut::<3>(9).copy_from(&self.tip_lever_mm.cross_matrix());
            }
            ErrorOf::Angle => j.fixed_columns_mut::<3>(9).copy_from(&-Matrix3::identity()),
        }
        j
    }
}

/// A figure as a part of its limit; endless where there is something and none is allowed.
pub fn part(value: f64, limit: f64) -> f64 {
    if value <= 0.0 {
        0.0
    } else if value.is_nan() {
        f64::INFINITY
    } else {
        value / limit
    }
}

fn mean_square(poses: &[Linear], of: ErrorOf) -> MeanSquare {
    let n = poses.len().max(1) as f64;
    let mut mean =
        MeanSquare { constant: 0.0, linear: Motions::zeros(), quadratic: SMatrix::zeros() };
    for pose in poses {
        let error = pose.error(of, &Motions::zeros());
        let jacobian = pose.jacobian(of);
        mean.constant += error.norm_squared() / n;
        mean.linear += jacobian.transpose() * error / n;
        mean.quadratic += jacobian.transpose() * jacobian / n;
    }
    mean
}

/// Every sensor's position, and its angle where it has an axis; `at_in_body` is the point that the
/// body's motion is given at: the tool's tip, the mean of the CRF's sensors.
fn blocks(
    body: &RigidBody,
    weight_mm: f64,
    role: BuiltBody,
    at_in_body: &Point3<f64>,
) -> Vec<Block> {
    let fit = LinearFit::new(body, weight_mm);
    let lever_mm = fit.lever_mm(at_in_body);
    let row = match role {
        BuiltBody::Tool => 0,
        BuiltBody::Crf => 6,
    };
    let effect = |sensor: usize, kind: ErrorOf| {
        let mut effect = SMatrix::<f64, 12, 3>::zeros();
        for component in 0..3 {
            let mut errors = vec![AS_DRAWN; body.sensors.len()];
            let PoseError { position_mm, rotation_rad } = &mut errors[sensor];
            match kind {
                ErrorOf::Position => position_mm[component] = 1.0,
                ErrorOf::Angle => rotation_rad[component] = 1.0,
            }
            let motion = fit.motion(&errors);
            let mut column = effect.column_mut(component);
            column.fixed_rows_mut::<3>(row).copy_from(&motion.at(&lever_mm));
            column.fixed_rows_mut::<3>(row + 3).copy_from(&motion.turn_rad);
        }
        effect
    };
    let kinds = |orientation: &SensorOrientation| match orientation {
        SensorOrientation::Marker => &[ErrorOf::Position][..],
        SensorOrientation::FiveDof(_) | SensorOrientation::SixDof(_) => &ErrorOf::ALL[..],
    };
    let sensors = body.sensors.iter().enumerate();
    sensors
        .flat_map(|(sensor, s)| kinds(&s.orientation).iter().map(move |kind| (sensor, *kind)))
        .map(|(sensor, kind)| Block {
            body: role,
            sensor,
            kind,
            effect: effect(sensor, kind),
            idle_axis: match (kind, &body.sensors[sensor].orientation) {
                (ErrorOf::Angle, SensorOrientation::FiveDof(axis)) => Some(*axis),
                _ => None,
            },
        })
        .collect()
}
