//! Figures of agreement from rows of measured and predicted errors.

use super::noise::Noise;
use super::resampling::{Sums, interval, resampled};
use super::rows::{AgreementRow, pivot_rows, tip_in_crf};
use super::unknowns::{Taken, take_out};
use super::verdict::verdict;
use super::{
    Agreement, AgreementError, AgreementSettings, Bias, Compared, Interval, LimitsOfAgreement,
    MIN_EFFECTIVE, MIN_POSES, MIN_SPREAD_DEG, MIN_SPREAD_MM, NoiseCheck, Summary, Unknowns,
};
use crate::dependence::Dependence;
use crate::pivot::{Pivot, PivotError, PivotLimits, pivot};
use nalgebra::{Matrix3, Point3, Vector3};
use rayon::prelude::*;
use statrs::distribution::{ChiSquared, ContinuousCDF, FisherSnedecor, StudentsT};
use std::collections::HashSet;
use trackwright_field::OutsidePolicy;
use trackwright_geometry::pose::{Pose, is_finite};
use trackwright_geometry::rotation::rotation_angle_rad;
use trackwright_simulation::Statistics;
use trackwright_simulation::figure::Figures;
use trackwright_simulation::scenario::{InputTrial, Mode, Scenario};
use trackwright_simulation::study::{study, study_less};
use trackwright_simulation::tool_in_crf::ErrorVectors;
use trackwright_task::Task;

/// Most units that are resampled; of longer recordings, neighbours are summed first.
const MOST_UNITS: usize = 20_000;

/// Resamplings: fewer do not determine a 2.5 % percentile.
const RESAMPLES: std::ops::RangeInclusive<usize> = 200..=1_000_000;

/// Of a normal distribution within 1.96 standard deviations lie 95 %.
const NORMAL_95: f64 = 1.959_963_984_540_054;

/// Part of the squares below which a mean or a spread is round-off.
const ROUND_OFF: f64 = 1e-24;

/// How far measured and predicted agree; rows that are not used are kept and marked.
pub fn agreement(
    scenario: &Scenario,
    mut rows: Vec<AgreementRow>,
    settings: &AgreementSettings,
    task: &Task,
) -> Result<Agreement, AgreementError> {
    check(settings)?;
    if let Some(index) = rows.iter().position(|row| !is_usable(row)) {
        return Err(AgreementError::NotFinite(index));
    }
    let noise = Noise::new(scenario, settings.averaged, settings.truth_std_mm);
    let unsupported: Vec<Option<bool>> =
        rows.par_iter().map(|row| noise.is_unsupported(row)).collect();
    task.step(1, 10)?;
    for (row, is_unsupported) in rows.iter_mut().zip(unsupported) {
        row.is_unsupported = is_unsupported;
        let is_left_out = settings.outside == OutsidePolicy::Reject && row.outside > 0
            || !settings.keeps_unsupported && is_unsupported.ok_or(AgreementError::NoSupport)?;
        row.is_used = !is_left_out;
    }
    let tips: Vec<Point3<f64>> = rows.iter().map(|row| tip_in_crf(row, scenario)).collect();
    check_poses(&rows, &tips)?;
    let taken = take_out(&mut rows, &tips, settings.unknowns);
    task.step(2, 10)?;
    let used: Vec<&AgreementRow> = rows.iter().filter(|row| row.is_used).collect();

    let pairs: Vec<_> = used.iter().map(|r| (r.measured_mm, r.predicted_mm)).collect();
    let sample = Sample::new(&used, &pairs);
    let part = |from: f64, to: f64| task.subtask(from, to);
    let position_mm = compared(&pairs, &sample, settings, &part(0.2, 0.6))?;
    let rotations: Option<Vec<_>> =
        used.iter().map(|r| Some((in_deg(&r.measured_rad?), in_deg(&r.predicted_rad)))).collect();
    let angle_deg = match rotations {
        Some(pairs) => {
            let sample = Sample::new(&used, &pairs);
            Some(compared(&pairs, &sample, settings, &part(0.6, 0.9))?)
        }
        None => None,
    };
    let noise_check = noise_check(&noise, &used, taken, sample.effective);
    let misfits: Option<Vec<f64>> = used.par_iter().map(|row| noise.misfit_mm2(row)).collect();
    let room_misfit_rms_mm = misfits.map(|all| (all.iter().sum::<f64>() / all.len() as f64).sqrt());
    task.step(10, 10)?;
    let (verdict, statement) = verdict(
        &position_mm,
        noise_check.as_ref(),
        room_misfit_rms_mm,
        (used.len(), sample.effective),
    );
    let count = |is: fn(&AgreementRow) -> bool| rows.iter().filter(|row| is(row)).count();
    let summary = Summary {
        poses: rows.len(),
        used: used.len(),
        outside: count(|row| row.outside > 0),
        unsupported: noise.has_field_error().then(|| count(|row| row.is_unsupported == Some(true))),
        unknowns: settings.unknowns,
        position_mm,
        angle_deg,
        effective: sample.effective,
        block: sample.block,
        noise: noise_check,
        room_misfit_rms_mm,
        verdict,
        statement,
    };
    let figures = figures(scenario, &rows, settings.unknowns, task)?;
    Ok(Agreement { rows, summary, figures })
}

/// What is known of the errors that the design predicts at the poses that count, less what a
/// registration takes up.
fn figures(
    scenario: &Scenario,
    rows: &[AgreementRow],
    unknowns: Unknowns,
    task: &Task,
) -> Result<Figures, AgreementError> {
    let used = rows.iter().filter(|row| row.is_used);
    let trials: Vec<InputTrial> = used
        .map(|row| InputTrial {
            tracker_from_crf: row.tracker_from_crf,
            crf_from_tool: row.crf_from_tool,
        })
        .collect();
    let poses: Vec<Pose> = trials.iter().map(|trial| trial.crf_from_tool).collect();
    let tip = scenario.tool.judged_tip_in_body();
    let mode = Mode::Input(trials.into());
    // No requirement is about the poses of a recording.
    let scenario = Scenario { requirement: None, ..scenario.clone() };
    let less = |numbers: &[usize], errors: &mut [ErrorVectors]| {
        let poses: Vec<Pose> = numbers.iter().map(|&number| poses[number]).collect();
        let tips: Vec<_> = poses.iter().map(|pose| (pose * tip).coords).collect();
        if let Some(taken) = Taken::of(&poses, &tips, unknowns) {
            taken.take_out(errors);
        }
    };
    let found = match unknowns {
        Unknowns::None => study(&scenario, &mode, &task.cancel, None),
        Unknowns::Registration | Unknowns::Pivot => {
            study_less(&scenario, &mode, &less, &task.cancel)
        }
    };
    Ok(found?.figures)
}

fn check(settings: &AgreementSettings) -> Result<(), AgreementError> {
    let wrong = |name, found, expected| Err(AgreementError::Setting { name, found, expected });
    if !(settings.averaged.is_finite() && settings.averaged >= 1.0) {
        return wrong("readings that a pose is the mean of", settings.averaged, "1 or more");
    }
    if !(settings.truth_std_mm.is_finite() && settings.truth_std_mm >= 0.0) {
        return wrong("noise of the true tip, mm", settings.truth_std_mm, "zero or more");
    }
    if !RESAMPLES.contains(&settings.resamples) {
        return wrong("resamplings", settings.resamples as f64, "200 to 1,000,000");
    }
    Ok(())
}

/// Also that squares of the errors are numbers.
fn is_usable(row: &AgreementRow) -> bool {
    let vectors =
        [Some(row.measured_mm), Some(row.predicted_mm), Some(row.predicted_rad), row.measured_rad];
    is_finite(&row.crf_from_tool)
        && row.tracker_from_crf.as_ref().is_none_or(is_finite)
        && vectors.iter().flatten().all(|v| v.norm_squared() < 1e100)
}

fn check_poses(rows: &[AgreementRow], tips: &[Point3<f64>]) -> Result<(), AgreementError> {
    let used = || rows.iter().zip(tips).filter(|(row, _)| row.is_used);
    let count = used().count();
    if count < MIN_POSES {
        let outside = rows.iter().filter(|r| !r.is_used && r.outside > 0).count();
        return Err(AgreementError::TooFew {
            poses: rows.len(),
            used: count,
            outside,
            unsupported: rows.len() - count - outside,
        });
    }
    let n = count as f64;
    let middle = used().map(|(_, tip)| tip.coords).sum::<Vector3<f64>>() / n;
    let squares: f64 = used().map(|(_, tip)| (tip.coords - middle).norm_squared()).sum();
    let spread_mm = (squares / n).sqrt();
    let Some((first, _)) = used().next() else {
        return Ok(());
    };
    let squares: f64 = used()
        .map(|(row, _)| {
            let turn = first.crf_from_tool.rotation.rotation_to(&row.crf_from_tool.rotation);
            rotation_angle_rad(&turn).powi(2)
        })
        .sum();
    let spread_deg = (squares / n).sqrt().to_degrees();
    if spread_mm < MIN_SPREAD_MM && spread_deg < MIN_SPREAD_DEG {
        return Err(AgreementError::OnePose { poses: count, spread_mm, spread_deg });
    }
    Ok(())
}

fn in_deg(turn_rad: &Vector3<f64>) -> Vector3<f64> {
    turn_rad.map(f64::to_degrees)
}

/// The effective number of poses, and what is resampled.
struct Sample {
    /// Sums of neighbours, where there are very many rows.
    units: Vec<Sums>,
    effective: f64,
    /// In rows.
    block: f64,
    /// Rows a unit.
    each: usize,
}

impl Sample {
    fn new(used: &[&AgreementRow], pairs: &[(Vector3<f64>, Vector3<f64>)]) -> Self {
        let each = pairs.len().div_ceil(MOST_UNITS).max(1);
        let units: Vec<Sums> = pairs
            .chunks(each)
            .map(|chunk| {
                let mut sums = Sums::default();
                for (measured, predicted) in chunk {
                    sums += &Sums::of(measured, predicted);
                }
                sums
            })
            .collect();
        let residuals: Vec<Vector3<f64>> =
            units.iter().map(|u| (u.measured - u.predicted) / u.count).collect();
        // To first order the explained part is a mean of these.
        let mut all = Sums::default();
        for unit in &units {
            all += unit;
        }
        let left = 1.0 - all.explained().unwrap_or(0.0);
        let influence: Vec<Vector3<f64>> = units
            .iter()
            .map(|u| Vector3::x() * ((u.residual_squares - left * u.measured_squares) / u.count))
            .collect();
        let [a, b] = [&residuals, &influence].map(|series| Dependence::of(series));
        let count = units.len() as f64;
        let groups = used.iter().map(|row| row.group).collect::<HashSet<_>>().len();
        // Rows of one group are of one pose, whatever their errors look like.
        let rows_a_group = pairs.len() as f64 / groups.max(1) as f64;
        Self {
            effective: (count / a.inflation.max(b.inflation)).min(groups as f64),
            block: a.block.max(b.block).max(rows_a_group / each as f64) * each as f64,
            each,
            units,
        }
    }

    fn is_enough(&self) -> bool {
        self.effective >= MIN_EFFECTIVE
    }
}

fn compared(
    pairs: &[(Vector3<f64>, Vector3<f64>)],
    sample: &Sample,
    settings: &AgreementSettings,
    task: &Task,
) -> Result<Compared, AgreementError> {
    let resampled = match sample.is_enough() {
        true => resampled(
            &sample.units,
            sample.block / sample.each as f64,
            settings.resamples,
            settings.seed,
            task,
        )?,
        false => Vec::new(),
    };
    let mut all = Sums::default();
    for unit in &sample.units {
        all += unit;
    }
    let figure = |of: fn(&Sums) -> Option<f64>| {
        let ends = interval(&resampled, of);
        of(&all).map(|value| Interval { value, low: ends.map(|e| e[0]), high: ends.map(|e| e[1]) })
    };
    let lengths = |of: fn(&(Vector3<f64>, Vector3<f64>)) -> f64| {
        let mut values: Vec<f64> = pairs.iter().map(of).collect();
        // The poses were counted: there are some.
        Statistics::of(&mut values).ok_or(AgreementError::TooFew {
            poses: 0,
            used: 0,
            outside: 0,
            unsupported: 0,
        })
    };
    let bias = (settings.unknowns == Unknowns::None).then(|| bias(pairs, sample.effective));
    Ok(Compared {
        measured: lengths(|(m, _)| m.norm())?,
        predicted: lengths(|(_, p)| p.norm())?,
        residual: lengths(|(m, p)| (m - p).norm())?,
        explained: figure(Sums::explained),
        explained_of_variation: figure(Sums::explained_of_variation),
        slope: figure(Sums::slope),
        bias,
        lengths: limits_of_agreement(pairs, sample.effective),
    })
}

/// Mean difference, with Student's intervals and Hotelling's test for as many poses as are
/// independent.
pub fn bias(pairs: &[(Vector3<f64>, Vector3<f64>)], effective: f64) -> Bias {
    let n = pairs.len() as f64;
    let mean = pairs.iter().map(|(m, p)| m - p).sum::<Vector3<f64>>() / n;
    let scatter: Matrix3<f64> =
        pairs.iter().map(|(m, p)| m - p - mean).map(|r| r * r.transpose()).sum::<Matrix3<f64>>()
            / (n - 1.0);
    let student = student_975(effective);
    let half_width = student.map(|t| [0, 1, 2].map(|k| t * (scatter[(k, k)] / effective).sqrt()));
    let squares: f64 = pairs.iter().map(|(m, p)| m.norm_squared() + p.norm_squared()).sum();
    // A scatter that is round-off gives no scale for a mean.
    let is_there = scatter.trace() > ROUND_OFF * (squares / n);
    let p = student.filter(|_| is_there).and_then(|_| {
        let solved = scatter.cholesky()?.solve(&mean);
        let t_squared = effective * mean.dot(&solved);
        let f = t_squared * (effective - 3.0) / (3.0 * (effective - 1.0));
        let distribution = FisherSnedecor::new(3.0, effective - 3.0).ok()?;
        Some(distribution.sf(f)).filter(|p| p.is_finite())
    });
    Bias { mean: mean.into(), half_width, p }
}

/// The 97.5 % quantile of Student's distribution for a mean of so many.
fn student_975(effective: f64) -> Option<f64> {
    if effective < MIN_EFFECTIVE {
        return None;
    }
    Some(StudentsT::new(0.0, 1.0, effective - 1.0).ok()?.inverse_cdf(0.975))
}

/// Bland & Altman 1999, section 2: the standard error of a limit is that of the mean and that of the
/// standard deviation together.
pub fn limits_of_agreement(
    pairs: &[(Vector3<f64>, Vector3<f64>)],
    effective: f64,
) -> Option<LimitsOfAgreement> {
    let n = pairs.len() as f64;
    let differences: Vec<f64> = pairs.iter().map(|(m, p)| m.norm() - p.norm()).collect();
    let mean = differences.iter().sum::<f64>() / n;
    let squares: f64 = differences.iter().map(|d| (d - mean).powi(2)).sum();
    let std = (squares / (n - 1.0)).sqrt();
    let student = student_975(effective);
    let around = |value: f64, std_error: f64| Interval {
        value,
        low: student.map(|t| value - t * std_error),
        high: student.map(|t| value + t * std_error),
    };
    let of_mean = std / effective.sqrt();
    let of_limit = std * (1.0 / effective + NORMAL_95.powi(2) / (2.0 * (effective - 1.0))).sqrt();
    mean.is_finite().then(|| LimitsOfAgreement {
        bias: around(mean, of_mean),
        lower: around(mean - NORMAL_95 * std, of_limit),
        upper: around(mean + NORMAL_95 * std, of_limit),
    })
}

/// Three components a pose, less those that a registration took up.
fn noise_check(
    noise: &Noise<'_>,
    used: &[&AgreementRow],
    taken: usize,
    effective: f64,
) -> Option<NoiseCheck> {
    let covariances: Option<Vec<Matrix3<f64>>> = used.par_iter().map(|row| noise.at(row)).collect();
    let covariances = covariances?;
    let components = 3.0 * used.len() as f64;
    let free = components - taken as f64;
    let square = |v: &Vector3<f64>, c: &Matrix3<f64>| Some(v.dot(&(c.try_inverse()? * v)));
    let (mut of_residual, mut variance) = (0.0, 0.0);
    for (row, covariance) in used.iter().zip(&covariances) {
        of_residual += square(&row.residual_mm(), covariance)?;
        variance += covariance.trace();
    }
    let of_measured: Option<f64> =
        used.iter().map(|row| square(&row.measured_mm, &noise.of_measurement(row)?)).sum();
    let freedom = 3.0 * effective * free / components;
    let accepted = ChiSquared::new(freedom)
        .ok()
        .filter(|_| effective >= MIN_EFFECTIVE)
        .map(|d| [0.025, 0.975].map(|p| d.inverse_cdf(p) / freedom));
    Some(NoiseCheck {
        rms_mm: (variance / used.len() as f64).sqrt(),
        has_jitter: noise.has_jitter(),
        has_field_error: noise.has_field_error(),
        normalised: of_residual / free,
        normalised_measured: of_measured.map(|squares| squares / free),
        accepted,
    })
}

/// What a pivoted tool comes to.
#[derive(Clone, Debug)]
pub struct PivotedTool {
    pub pivot: Pivot,
    pub agreement: Agreement,
}

#[derive(Clone, Debug, PartialEq, thiserror::Error)]
pub enum PivotedError {
    #[error("no tip: {0}")]
    NoTip(PivotError),
    /// The design cannot be simulated there.
    #[error(transparent)]
    Simulation(AgreementError),
    /// The recording gives no result.
    #[error(transparent)]
    Agreement(AgreementError),
}

/// Finds the tip, predicts, compares; the scenario's CRF is not looked at.
pub fn pivoted_tool(
    scenario: &Scenario,
    poses: &[Pose],
    settings: &AgreementSettings,
    task: &Task,
) -> Result<PivotedTool, PivotedError> {
    // How far the tip strays is the quantity in question, so no distance is too large.
    let limits = PivotLimits { max_rms_mm: f64::MAX, ..PivotLimits::default() };
    let found = pivot(poses, &limits).map_err(PivotedError::NoTip)?;
    let (with_tip, rows) = pivot_rows(scenario, poses, &found, &task.subtask(0.0, 0.5))
        .map_err(PivotedError::Simulation)?;
    let agreement = agreement(&with_tip, rows, settings, &task.subtask(0.5, 1.0))
        .map_err(PivotedError::Agreement)?;
    Ok(PivotedTool { pivot: found, agreement })
}
