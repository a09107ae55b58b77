//! Compensation of measured poses, by a correction map, by the inverse of a distortion map, or by
//! the paper's shortcut; what became of them, and how far the shortcut is off.

use super::batch::Batch;
use super::evaluation::OutsidePolicy;
use super::field_point::FieldPoint;
use super::inverse::{Inverse, InverseState};
use super::model::DistortionModel;
use super::samples::{MapKind, PoseError};
use rayon::prelude::*;
use trackwright_geometry::pose::{Pose, distances, is_finite, pose_from_parts};
use trackwright_geometry::rotation::exp_vector;
use trackwright_result::{Row, Section, count, data, number};
use trackwright_task::{Cancelled, Task};

/// Readings that one core corrects before it looks whether anyone still wants them.
const CHUNK: usize = 4096;

const LARGEST: &str = "largest correction";

/// How a measured pose is corrected.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Method {
    /// The map gives it: `p = p_m - e_pos(p_m, n_m)`, `R = exp(-e_ori) R_m`.
    Correction,
    /// The pose whose distortion is the reading.
    Inverse,
    /// The paper's: a distortion map used as if it were a correction.
    Shortcut,
}

impl Method {
    /// The exact way for a model's kind.
    pub fn of(map: MapKind) -> Self {
        match map {
            MapKind::Correction => Self::Correction,
            MapKind::Distortion => Self::Inverse,
        }
    }

    /// Its name for programs.
    pub fn name(self) -> &'static str {
        match self {
            Self::Correction => "correction",
            Self::Inverse => "inverse",
            Self::Shortcut => "shortcut",
        }
    }

    /// What poses are corrected by.
    pub fn about(self) -> &'static str {
        match self {
            Self::Correction => "correction map",
            Self::Inverse => "inverse of the distortion map",
            Self::Shortcut => "shortcut, the distortion map used as a correction",
        }
    }
}

/// A measured pose, corrected.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Compensated {
    pub pose: Option<Pose>,
    /// Other poses that read the same, where no more than two were found.
    pub others: [Option<Pose>; 2],
    pub state: InverseState,
    /// Whether the position that the map was evaluated at lies in the model's box.
    pub is_inside: bool,
}

/// Corrects measured poses on all cores; the answers do not depend on how many.
///
/// # Errors
/// [`Cancelled`].
pub fn compensate(
    model: &DistortionModel,
    measured: &[Pose],
    outside: OutsidePolicy,
    method: Method,
    task: &Task,
) -> Result<Vec<Compensated>, Cancelled> {
    Compensator::new(model, outside, method).compensate(measured, task)
}

/// A model made ready to correct readings that come a few at a time: what the inverse has to know
/// of the whole model is found once.
#[derive(Clone, Debug)]
pub struct Compensator<'a> {
    model: &'a DistortionModel,
    outside: OutsidePolicy,
    /// None where the map is used as it is.
    inverse: Option<Inverse<'a>>,
}

impl<'a> Compensator<'a> {
    /// Prepares a method for a model.
    pub fn new(model: &'a DistortionModel, outside: OutsidePolicy, method: Method) -> Self {
        Self {
            model,
            outside,
            inverse: (method == Method::Inverse).then(|| Inverse::new(model, outside)),
        }
    }

    /// See [`compensate`].
    ///
    /// # Errors
    /// [`Cancelled`].
    pub fn compensate(
        &self,
        measured: &[Pose],
        task: &Task,
    ) -> Result<Vec<Compensated>, Cancelled> {
        let Some(inverse) = &self.inverse else {
            return correct_all(self.model, measured, self.outside, task);
        };
        let found = inverse.undistort(measured, task)?;
        Ok(found
            .into_iter()
            .map(|u| Compensated {
                pose: u.pose,
                others: u.others,
                state: u.state,
                is_inside: u.is_inside,
            })
            .collect())
    }
}

/// What [`DistortionModel::correct`] gives, many at a time.
fn correct_all(
    model: &DistortionModel,
    measured: &[Pose],
    outside: OutsidePolicy,
    task: &Task,
) -> Result<Vec<Compensated>, Cancelled> {
    let all = measured.len();
    let none = Compensated {
        pose: None,
        others: [None; 2],
        state: InverseState::NotConverged,
        is_inside: false,
    };
    let mut corrected = vec![none; measured.len()];
    corrected.par_chunks_mut(CHUNK).zip(measured.par_chunks(CHUNK)).enumerate().try_for_each_init(
        || (Batch::default(), Vec::new()),
        |(batch, evaluations), (index, (corrected, measured))| {
            task.step(index * CHUNK, all)?;
            let points: Vec<_> = measured.iter().map(FieldPoint::of_pose).collect();
            batch.evaluate_points(model, &points, outside, evaluations);
            for ((out, pose), at) in corrected.iter_mut().zip(measured).zip(&*evaluations) {
                *out = corrected_by(pose, &at.error, at.is_inside, outside);
            }
            Ok(())
        },
    )?;
    Ok(corrected)
}

fn corrected_by(
    measured: &Pose,
    error: &PoseError,
    is_inside: bool,
    outside: OutsidePolicy,
) -> Compensated {
    let pose = pose_from_parts(
        measured.translation.vector - error.position_mm,
        exp_vector(&-error.rotation_rad) * measured.rotation,
    );
    let is_known = measured.translation.vector.iter().all(|v| v.is_finite()) && is_finite(&pose);
    let state = match (is_known, is_inside, outside) {
        (false, ..) => InverseState::NotConverged,
        (true, false, OutsidePolicy::Reject) => InverseState::Rejected,
        (true, ..) => InverseState::Converged,
    };
    let pose = (state == InverseState::Converged).then_some(pose);
    Compensated { pose, others: [None; 2], state, is_inside }
}

/// What became of a table.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Tally {
    pub rows: usize,
    /// Rows with an answer, the ambiguous ones among them.
    pub converged: usize,
    pub ambiguous: usize,
    pub folded: usize,
    pub not_converged: usize,
    /// Where the tracker reads nothing.
    pub in_metal: usize,
    pub rejected: usize,
    pub outside: usize,
    /// The farthest that an answer is from its reading.
    pub largest_correction_mm: f64,
    pub largest_correction_rad: f64,
}

impl Tally {
    /// Counts what became of each row.
    pub fn of(measured: &[Pose], compensated: &[Compensated]) -> Self {
        let mut tally = Self::default();
        for (reading, found) in measured.iter().zip(compensated) {
            tally.rows += 1;
            tally.outside += usize::from(!found.is_inside);
            match found.state {
                InverseState::Converged => tally.converged += 1,
                InverseState::Ambiguous(_) => {
                    tally.converged += 1;
                    tally.ambiguous += 1;
                }
                InverseState::Folded { .. } => tally.folded += 1,
                InverseState::NotConverged => tally.not_converged += 1,
                InverseState::NoReading => tally.in_metal += 1,
                InverseState::Rejected => tally.rejected += 1,
            }
            if let Some(pose) = found.pose {
                let (mm, rad) = distances(reading, &pose);
                tally.largest_correction_mm = tally.largest_correction_mm.max(mm);
                tally.largest_correction_rad = tally.largest_correction_rad.max(rad);
            }
        }
        tally
    }

    /// What became of the readings, as a result.
    pub fn section(&self) -> Section {
        let angle_deg = self.largest_correction_rad.to_degrees();
        Section::of([
            count("rows", "rows", self.rows),
            count("converged", "converged", self.converged),
            count("ambiguous", "of these ambiguous", self.ambiguous),
            count("folded", "folded", self.folded),
            count("not_converged", "not converged", self.not_converged),
            count("in_metal", "in metal", self.in_metal),
            count("rejected", "rejected", self.rejected),
            count("outside", "outside the model's box", self.outside),
            number("largest_correction_mm", LARGEST, self.largest_correction_mm, 4, "mm"),
            number("largest_correction_deg", LARGEST, angle_deg, 4, "°"),
        ])
    }

    /// Counts the rows of another table too.
    pub fn add(&mut self, other: &Self) {
        self.rows += other.rows;
        self.converged += other.converged;
        self.ambiguous += other.ambiguous;
        self.folded += other.folded;
        self.not_converged += other.not_converged;
        self.in_metal += other.in_metal;
        self.rejected += other.rejected;
        self.outside += other.outside;
        self.largest_correction_mm = self.largest_correction_mm.max(other.largest_correction_mm);
        self.largest_correction_rad =
            (self.largest_correction_rad).max(other.largest_correction_rad);
    }
}

/// Readings that were corrected, what became of them, and how far the shortcut is off.
#[derive(Clone, Debug, PartialEq)]
pub struct Compensation {
    pub method: Method,
    pub answers: Vec<Compensated>,
    pub tally: Tally,
    /// The shortcut against the inverse; none for a correction map.
    pub shortcut: Option<Difference>,
}

impl Compensation {
    /// Corrects readings; for a distortion map by both ways.
    ///
    /// # Errors
    /// [`Cancelled`].
    pub fn of(
        model: &DistortionModel,
        measured: &[Pose],
        outside: OutsidePolicy,
        method: Method,
        task: &Task,
    ) -> Result<Self, Cancelled> {
        let by = |method| compensate(model, measured, outside, method, task);
        let (answers, shortcut) = match method {
            Method::Correction => (by(Method::Correction)?, None),
            Method::Inverse | Method::Shortcut => {
                let (inverse, shortcut) = (by(Method::Inverse)?, by(Method::Shortcut)?);
                let difference = Difference::between(&inverse, &shortcut);
                let wanted = if method == Method::Inverse { inverse } else { shortcut };
                (wanted, difference)
            }
        };
        Ok(Self { method, tally: Tally::of(measured, &answers), answers, shortcut })
    }

    /// All that was found but the poses.
    pub fn section(&self) -> Section {
        let difference = self.shortcut.iter().flat_map(Difference::rows);
        (self.tally.section())
            .with(data("method", self.method.name()))
            .with(data("shortcut_against_inverse", ()))
            .with_all(difference)
    }
}

/// How far two ways to compensate are apart, over the readings that both answer.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Difference {
    pub compared: usize,
    pub position_rms_mm: f64,
    pub position_max_mm: f64,
    pub angle_rms_rad: f64,
    pub angle_max_rad: f64,
}

impl Difference {
    fn rows(&self) -> [Row; 5] {
        let [rms, max] = ["shortcut against inverse, RMS", "shortcut against inverse, max"];
        let row = |key: &str, label, value, unit| {
            number(format!("shortcut_against_inverse.{key}"), label, value, 6, unit)
        };
        let [rms_deg, max_deg] = [self.angle_rms_rad, self.angle_max_rad].map(f64::to_degrees);
        [
            data("shortcut_against_inverse.compared", self.compared),
            row("position_rms_mm", rms, self.position_rms_mm, "mm"),
            row("position_max_mm", max, self.position_max_mm, "mm"),
            row("angle_rms_deg", rms, rms_deg, "°"),
            row("angle_max_deg", max, max_deg, "°"),
        ]
    }

    /// Leaves out what either way did not answer, or only ambiguously; `None` if that is all.
    pub fn between(a: &[Compensated], b: &[Compensated]) -> Option<Self> {
        let sure = |c: &Compensated| c.pose.filter(|_| c.state == InverseState::Converged);
        let mut sum = Self::default();
        for (a, b) in a.iter().zip(b).filter_map(|(a, b)| sure(a).zip(sure(b))) {
            let (mm, rad) = distances(&a, &b);
            sum.compared += 1;
            sum.position_rms_mm += mm * mm;
            sum.angle_rms_rad += rad * rad;
            sum.position_max_mm = sum.position_max_mm.max(mm);
            sum.angle_max_rad = sum.angle_max_rad.max(rad);
        }
        let root_mean = |sum_of_squares: f64| (sum_of_squares / sum.compared as f64).sqrt();
        (sum.compared > 0).then_some(Self {
            position_rms_mm: root_mean(sum.position_rms_mm),
            angle_rms_rad: root_mean(sum.angle_rms_rad),
            ..sum
        })
    }
}
