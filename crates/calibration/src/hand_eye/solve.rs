//! Robust nonlinear least squares over `Y` and all `X`: Levenberg–Marquardt on rotations and
//! translations, the loss as weights anew in each step.
//!
//! A change of a pose turns its rotation from the left, `R ← exp(δ) R`, and adds to its translation.

use super::{HandEyeSettings, PairedReading, pose_error};
use crate::robust::{Loss, median, scale_of_lengths};
use crate::still_pose::Spread;
use nalgebra::{DMatrix, DVector, Matrix3, SMatrix, SVector, UnitQuaternion, Vector3};
use trackwright_field::samples::PoseError;
use trackwright_geometry::pose::{Pose, pose_from_parts};
use trackwright_geometry::rotation::exp_vector;

/// Least scales, for exact readings: a tenth of the last digits that trackers write.
const LEAST: Spread = Spread { position_mm: 1e-4, angle_rad: 1e-7 };

/// Readings from which a sensor has a scale of its own; with fewer it has that of all.
const OWN_SCALE_FROM: usize = 20;

/// Rounds of scales. Each brings them nearer by some factor of three to ten.
const MAX_ROUNDS: usize = 60;

/// Part by which scales may still change in the last round.
const SCALES_STAY: f64 = 1e-6;

/// Steps of a round; from the closed form some five are taken.
const MAX_STEPS: usize = 60;

/// A step below this is round-off: of a metre, and of a turn.
const STEP_MM: f64 = 1e-11;
const STEP_RAD: f64 = 1e-14;

/// Unknowns of a reading: those of `Y`, then those of its sensor.
pub(super) type Slopes = SMatrix<f64, 6, 12>;

/// The unknowns.
#[derive(Clone, Debug, PartialEq)]
pub(super) struct Frames {
    pub y: Pose,
    pub x: Vec<Pose>,
}

/// An answer with what its readings were divided by.
#[derive(Clone, Debug, PartialEq)]
pub(super) struct Solved {
    pub frames: Frames,
    /// One a sensor.
    pub scales: Vec<Spread>,
    /// One a reading: standard deviations of known noise and scale together.
    pub sigmas: Vec<Spread>,
}

impl Frames {
    pub fn residual(&self, reading: &PairedReading) -> PoseError {
        let expected = self.y * reading.reference_from_body * self.x[reading.sensor];
        pose_error(&reading.tracker_from_sensor, &expected)
    }

    /// Slopes of the residual (position, then rotation) in a change of `Y` (rotation, translation)
    /// and of the sensor's `X`.
    pub fn slopes(&self, reading: &PairedReading, residual: &PoseError) -> Slopes {
        let turn = self.y.rotation * reading.reference_from_body.rotation;
        let turn = turn.to_rotation_matrix().into_inner();
        let body = &reading.reference_from_body;
        let lever = self.y.rotation
            * (body.rotation * self.x[reading.sensor].translation.vector + body.translation.vector);
        let inverse = inverse_right_jacobian(&residual.rotation_rad);
        let mut slopes = Slopes::zeros();
        let mut set = |row: usize, column: usize, block: &Matrix3<f64>| {
            slopes.fixed_view_mut::<3, 3>(row, column).copy_from(block);
        };
        set(0, 0, &lever.cross_matrix());
        set(0, 3, &-Matrix3::identity());
        set(0, 9, &-turn);
        set(3, 0, &-inverse);
        set(3, 6, &(-inverse * turn));
        slopes
    }

    fn changed(&self, step: &DVector<f64>) -> Self {
        let change = |pose: &Pose, first: usize| {
            let turn = exp_vector(&step.fixed_rows::<3>(first).into_owned());
            let at = pose.translation.vector + step.fixed_rows::<3>(first + 3);
            let rotation = (turn * pose.rotation).into_inner();
            pose_from_parts(at, UnitQuaternion::new_normalize(rotation))
        };
        Self {
            y: change(&self.y, 0),
            x: self.x.iter().enumerate().map(|(k, pose)| change(pose, 6 + 6 * k)).collect(),
        }
    }

    pub fn unknowns(&self) -> usize {
        6 + 6 * self.x.len()
    }
}

/// Six components of an error in the scales of a reading.
pub(crate) fn whitened(error: &PoseError, sigma: &Spread) -> SVector<f64, 6> {
    let (position_mm, angle_rad) = (sigma.position_mm, sigma.angle_rad);
    let (p, r) = (error.position_mm / position_mm, error.rotation_rad / angle_rad);
    SVector::from([p.x, p.y, p.z, r.x, r.y, r.z])
}

pub(super) fn whitened_slopes(mut slopes: Slopes, sigma: &Spread) -> Slopes {
    let mut rows = slopes.fixed_rows_mut::<3>(0);
    rows /= sigma.position_mm;
    let mut rows = slopes.fixed_rows_mut::<3>(3);
    rows /= sigma.angle_rad;
    slopes
}

/// `log(exp(r) exp(−δ)) ≈ r − J δ` (Solà et al., *A micro Lie theory*, 2018, equation 144).
fn inverse_right_jacobian(r: &Vector3<f64>) -> Matrix3<f64> {
    let angle = r.norm();
    let cross = r.cross_matrix();
    let factor = if angle < 1e-3 {
        // The next term of the series is angle² / 720.
        1.0 / 12.0
    } else {
        let half = 0.5 * angle;
        (1.0 - half / half.tan()) / (angle * angle)
    };
    Matrix3::identity() + 0.5 * cross + factor * cross * cross
}

/// Adds a reading's 12 × 12 block where its unknowns are.
pub(super) fn scatter_matrix(into: &mut DMatrix<f64>, sensor: usize, block: &SMatrix<f64, 12, 12>) {
    let places = [0, 6 + 6 * sensor];
    for (i, row) in places.into_iter().enumerate() {
        for (j, column) in places.into_iter().enumerate() {
            let mut view = into.fixed_view_mut::<6, 6>(row, column);
            view += block.fixed_view::<6, 6>(6 * i, 6 * j);
        }
    }
}

pub(super) fn scatter_vector(into: &mut DVector<f64>, sensor: usize, part: &SVector<f64, 12>) {
    for (i, row) in [0, 6 + 6 * sensor].into_iter().enumerate() {
        let mut view = into.fixed_rows_mut::<6>(row);
        view += part.fixed_rows::<6>(6 * i);
    }
}

/// From a start to the least cost, with scales taken anew until they stay; `None` where there is no
/// finite answer.
pub(super) fn solve(
    readings: &[PairedReading],
    start: Frames,
    settings: &HandEyeSettings,
) -> Option<Solved> {
    let mut frames = start;
    let mut scales: Option<Vec<Spread>> = None;
    for _ in 0..MAX_ROUNDS {
        let now = match settings.scale {
            Some(stated) => vec![stated; frames.x.len()],
            None => scales_of(readings, &frames),
        };
        let sigmas: Vec<Spread> = readings.iter().map(|r| sigma(r, &frames, &now)).collect();
        frames = least(readings, &sigmas, frames, settings.loss)?;
        let is_settled = scales.as_ref().is_some_and(|before| stay(before, &now));
        scales = Some(now);
        if is_settled {
            break;
        }
    }
    let scales = scales?;
    let sigmas = readings.iter().map(|r| sigma(r, &frames, &scales)).collect();
    Some(Solved { frames, scales, sigmas })
}

fn stay(before: &[Spread], now: &[Spread]) -> bool {
    let is_near = |a: f64, b: f64| (a - b).abs() <= SCALES_STAY * b;
    before
        .iter()
        .zip(now)
        .all(|(a, b)| is_near(a.position_mm, b.position_mm) && is_near(a.angle_rad, b.angle_rad))
}

/// What is known beforehand of a reading's variances, of a component each: position mm², angle rad².
/// An angle of the reference moves a sensor across its lever, in two directions of three.
fn known(reading: &PairedReading, frames: &Frames) -> (f64, f64) {
    let (a, b) = (&reading.noise.tracker, &reading.noise.reference);
    let lever2 = frames.x[reading.sensor].translation.vector.norm_squared();
    (
        a.position_mm.powi(2) + b.position_mm.powi(2) + 2.0 / 3.0 * lever2 * b.angle_rad.powi(2),
        a.angle_rad.powi(2) + b.angle_rad.powi(2),
    )
}

fn sigma(reading: &PairedReading, frames: &Frames, scales: &[Spread]) -> Spread {
    let (mm2, rad2) = known(reading, frames);
    let scale = &scales[reading.sensor];
    Spread {
        position_mm: (mm2 + scale.position_mm.powi(2)).sqrt().max(LEAST.position_mm),
        angle_rad: (rad2 + scale.angle_rad.powi(2)).sqrt().max(LEAST.angle_rad),
    }
}

/// For each sensor, what its residuals scatter by beyond the known noise.
fn scales_of(readings: &[PairedReading], frames: &Frames) -> Vec<Spread> {
    let of = |sensor: Option<usize>| {
        let (mut mm, mut rad, mut mm2, mut rad2) = (vec![], vec![], vec![], vec![]);
        for reading in readings.iter().filter(|r| sensor.is_none_or(|s| r.sensor == s)) {
            let residual = frames.residual(reading);
            mm.push(residual.position_mm.norm());
            rad.push(residual.rotation_rad.norm());
            let known = known(reading, frames);
            mm2.push(known.0);
            rad2.push(known.1);
        }
        let beyond = |lengths: &mut [f64], known: &mut [f64], least: f64| {
            let known = median(known).unwrap_or(0.0);
            let square = scale_of_lengths(lengths).powi(2) - known;
            square.max(least * least).sqrt()
        };
        let scale = Spread {
            position_mm: beyond(&mut mm, &mut mm2, LEAST.position_mm),
            angle_rad: beyond(&mut rad, &mut rad2, LEAST.angle_rad),
        };
        (scale, mm.len())
    };
    let (of_all, _) = of(None);
    (0..frames.x.len())
        .map(|sensor| match of(Some(sensor)) {
            (own, count) if count >= OWN_SCALE_FROM => own,
            _ => of_all,
        })
        .collect()
}

fn cost(readings: &[PairedReading], sigmas: &[Spread], frames: &Frames, loss: Loss) -> f64 {
    let each = readings.iter().zip(sigmas);
    each.map(|(r, sigma)| loss.cost(whitened(&frames.residual(r), sigma).norm())).sum()
}

/// The least cost for fixed standard deviations.
fn least(
    readings: &[PairedReading],
    sigmas: &[Spread],
    mut frames: Frames,
    loss: Loss,
) -> Option<Frames> {
    let mut damping = 1e-6;
    let mut now = cost(readings, sigmas, &frames, loss);
    if !now.is_finite() {
        return None;
    }
    for _ in 0..MAX_STEPS {
        let unknowns = frames.unknowns();
        let mut normal = DMatrix::zeros(unknowns, unknowns);
        let mut gradient = DVector::zeros(unknowns);
        for (reading, sigma) in readings.iter().zip(sigmas) {
            let residual = frames.residual(reading);
            let slopes = whitened_slopes(frames.slopes(reading, &residual), sigma);
            let r = whitened(&residual, sigma);
            let weight = loss.weight(r.norm());
            scatter_matrix(&mut normal, reading.sensor, &(slopes.transpose() * slopes * weight));
            scatter_vector(&mut gradient, reading.sensor, &(slopes.transpose() * r * weight));
        }
        let step = damped_step(&normal, &gradient, damping)?;
        let next = frames.changed(&step);
        let then = cost(readings, sigmas, &next, loss);
        let is_tiny = (0..unknowns / 3).all(|part| {
            let length = step.fixed_rows::<3>(3 * part).norm();
            length <= if part % 2 == 0 { STEP_RAD } else { STEP_MM }
        });
        // At the least, round-off decides which of two costs is the smaller.
        if then <= now {
            (frames, now) = (next, then);
            damping = (damping / 10.0).max(1e-12);
        } else {
            damping *= 10.0;
        }
        if is_tiny || damping > 1e6 {
            break;
        }
    }
    Some(frames)
}

/// Marquardt's step: the diagonal is made larger by a part of itself. Columns are divided by their
/// lengths first, since some are of millimetres and some of radians.
fn damped_step(
    normal: &DMatrix<f64>,
    gradient: &DVector<f64>,
    damping: f64,
) -> Option<DVector<f64>> {
    let lengths = normal.diagonal().map(f64::sqrt);
    if lengths.iter().any(|l| !(*l > 0.0 && l.is_finite())) {
        return None;
    }
    let mut scaled = normal.clone();
    for (i, mut column) in scaled.column_iter_mut().enumerate() {
        column.component_div_assign(&lengths);
        column /= lengths[i];
        column[i] += damping;
    }
    let step = scaled.cholesky()?.solve(&-gradient.component_div(&lengths));
    Some(step.component_div(&lengths))
}
