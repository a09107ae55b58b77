//! Whether true and measured poses are in one frame, and in that of the room: by the size of the
//! disagreement, which no field error has.

use super::rows::{AgreementRow, tip_in_crf};
use crate::registration::register;
use nalgebra::Point3;
use trackwright_geometry::rotation::rotation_angle_rad;
use trackwright_simulation::scenario::Scenario;

/// Median disagreement below which frames are taken to be one: tables in one frame have 15.7 mm at
/// most, tables of two frames 606 to 914 mm.
pub const APART_MM: f64 = 25.0;

/// The same as a multiple of the largest predicted error, for worse rooms; agreeing recordings have
/// medians below that error.
const BEYOND_PREDICTION: f64 = 3.0;

/// Part of the disagreement that a registration may leave where it is one of frames: it leaves 0.93
/// to 1.00 of a field's error (RMS), and 0.06 to 0.16 of two frames.
const LEFT_PART: f64 = 0.25;

/// True and measured poses that cannot be in one frame, or not in that of the room.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
pub enum FrameMismatch {
    #[error(
        "the measured tip is {median_mm:.0} mm from the true one (median of {poses} poses), where the room predicts \
         {predicted_max_mm:.1} mm at most{}: {}",
        outside_words(*.outside),
        common_words(.common.as_ref())
    )]
    Apart {
        poses: usize,
        median_mm: f64,
        /// Largest error that is predicted at these poses.
        predicted_max_mm: f64,
        /// Poses with a sensor outside the room's box.
        outside: usize,
        /// What a common frame would give; `None` where the poses determine none.
        common: Option<CommonFrame>,
    },
    #[error(
        "all {poses} poses have a sensor outside the room's box, which is {distance_mm:.0} mm away (median): they are \
         in another frame than the room's, or of another room"
    )]
    NotInRoom { poses: usize, distance_mm: f64 },
}

/// A registration of the true tips to the measured ones.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct CommonFrame {
    pub turn_deg: f64,
    /// Of the middle of the true tips.
    pub shift_mm: f64,
    pub before_rms_mm: f64,
    /// RMS distance that it leaves.
    pub left_rms_mm: f64,
}

impl CommonFrame {
    /// Whether it takes away nearly all of the disagreement.
    pub fn explains(&self) -> bool {
        self.left_rms_mm <= LEFT_PART * self.before_rms_mm
    }
}

fn outside_words(outside: usize) -> String {
    match outside {
        0 => String::new(),
        outside => format!(" ({outside} have a sensor outside the room's box)"),
    }
}

fn common_words(common: Option<&CommonFrame>) -> String {
    match common {
        Some(common) if common.explains() => format!(
            "they agree to {:.1} mm RMS after turning by {:.1}° and shifting by {:.0} mm, so that the two are in \
             different frames; register them with `characterize` or `register`",
            common.left_rms_mm, common.turn_deg, common.shift_mm
        ),
        Some(common) => format!(
            "no common frame explains it ({:.0} mm RMS are left by the best), expected rows of the same moments, in \
             mm, of the same point of the tool",
            common.left_rms_mm
        ),
        None => "expected both in the tracker's frame, in mm".to_owned(),
    }
}

/// Looks at the size of the disagreement. `scenario` is that of the rows.
pub fn frame_mismatch(scenario: &Scenario, rows: &[AgreementRow]) -> Option<FrameMismatch> {
    let predicted_max_mm = rows.iter().map(|row| row.predicted_mm.norm()).fold(0.0, f64::max);
    let distances: Vec<f64> = rows.iter().map(|row| row.measured_mm.norm()).collect();
    let median_mm = median(distances)?;
    let outside = rows.iter().filter(|row| row.outside > 0).count();
    if median_mm > APART_MM.max(BEYOND_PREDICTION * predicted_max_mm) {
        return Some(FrameMismatch::Apart {
            poses: rows.len(),
            median_mm,
            predicted_max_mm,
            outside,
            common: common_frame(scenario, rows),
        });
    }
    let distance_mm = median(rows.iter().map(|row| from_box_mm(scenario, row)).collect())?;
    (outside == rows.len() && distance_mm > APART_MM)
        .then_some(FrameMismatch::NotInRoom { poses: rows.len(), distance_mm })
}

fn common_frame(scenario: &Scenario, rows: &[AgreementRow]) -> Option<CommonFrame> {
    let truth: Vec<Point3<f64>> = rows.iter().map(|row| tip_in_crf(row, scenario)).collect();
    let measured = truth.iter().zip(rows).map(|(tip, row)| tip + row.measured_mm);
    let measured: Vec<Point3<f64>> = measured.collect();
    let found = register(&truth, &measured).ok()?;
    let count = rows.len() as f64;
    let squares_mm2: f64 = rows.iter().map(|row| row.measured_mm.norm_squared()).sum();
    let sum: nalgebra::Vector3<f64> = truth.iter().map(|tip| tip.coords).sum();
    let middle = Point3::from(sum / count);
    Some(CommonFrame {
        turn_deg: rotation_angle_rad(&found.target_from_source.rotation).to_degrees(),
        shift_mm: (found.target_from_source * middle - middle).norm(),
        before_rms_mm: (squares_mm2 / count).sqrt(),
        left_rms_mm: found.fre_rms_mm,
    })
}

/// Distance of the tool's farthest sensor from the room's box, 0 within it.
fn from_box_mm(scenario: &Scenario, row: &AgreementRow) -> f64 {
    let tracker_from_crf = row.tracker_from_crf_in(scenario);
    let bounds = scenario.environment.model.bounds();
    let sensors = scenario.tool.sensors.iter();
    let distances = sensors.map(|sensor| {
        let at = tracker_from_crf * (row.crf_from_tool * sensor.position_in_body);
        (at - bounds.clamp(&at)).norm()
    });
    distances.fold(0.0, f64::max)
}

/// The upper one of two in the middle.
fn median(mut values: Vec<f64>) -> Option<f64> {
    values.sort_unstable_by(f64::total_cmp);
    values.get(values.len() / 2).copied()
}
