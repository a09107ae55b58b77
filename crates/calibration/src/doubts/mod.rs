//! Suspicions that a table of poses is not what it is read as: its units, its frames, the order of
//! its rows, axes and quaternions.
//!
//! A distorted field moves readings by some tens of millimetres and turns them by some degrees. A
//! mistake about units or frames moves them by the size of the tracker's volume. What is suspected is
//! that gap, with the numbers; nothing is ever put right here.
//!
//! Thresholds were found on the tables of the tests: simulated rooms with 2 to 3 mm RMS, the course's
//! calibration sets with up to 7.2 mm RMS and 24 mm at most, and a real Aurora beside a Polaris with 3 to
//! 6 mm RMS. On these nothing is suspected, and each mistake is.

mod alone;
mod in_order;
mod paired;
mod turned;

pub use alone::{PoseFrame, in_room, of_points, of_poses, with_written_quaternions};
pub use paired::{PairedDoubts, of_point_pairs};

use nalgebra::Vector3;
use std::fmt;
use turned::QuaternionChange;

/// Fewest rows of which anything but a number out of all bounds is reported: six numbers of a frame
/// explain three rows exactly and a few more nearly.
const MIN_ROWS: usize = 10;

/// Beyond this no tracker measures, mm: a kilometre. Placeholders of missing readings are.
const MAX_POSITION_MM: f64 = 1e6;

/// How many times less has to be left, in the median, where something is suspected to explain how the
/// sides differ. A registration takes 1.0 to 1.6 times out of the good tables' errors.
const SUSPECT_RATIO: f64 = 4.0;

/// The same for an explanation beyond doubt.
const CERTAIN_RATIO: f64 = 10.0;

/// One of the two sides of a measurement table.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Side {
    Ideal,
    Measured,
    Both,
}

/// Axes taken for others: axis `k` is the axis, 0 to 2, with the sign in place `k`.
pub type SignedAxes = [(usize, f64); 3];

/// What is suspected, with the evidence; lengths in mm as the table is read, angles in radians.
#[derive(Clone, Debug, PartialEq)]
pub enum Suspicion {
    /// All positions are within some units of the origin.
    Metres { span: f64, reach: f64, is_certain: bool },
    /// They are within some tens of units of it.
    InchesOrCentimetres { span: f64, reach: f64 },
    /// Coordinates that no tracker reads.
    TooFar { count: usize, first_row: usize, largest: f64 },
    /// Positions that differ by more than a limit, far more than the others do.
    Outliers { count: usize, first_row: usize, limit: f64, largest: f64, median: f64 },
    /// Distances among the positions of the second side are so many times those of the first.
    Scale {
        sides: [&'static str; 2],
        ratio: f64,
        first_mm: f64,
        second_mm: f64,
        /// What is so many times the other unit, where something is.
        units: Option<&'static str>,
    },
    /// The measured axes are others of the ideal ones.
    Axes { rows: SignedAxes, change: Explained },
    /// Hardly a position is in the room that is applied to them, and nearly all are with other axes.
    NotInRoom { rows: usize, inside: usize, axes: SignedAxes, inside_with_axes: usize },
    /// A mirror image, whatever the plane.
    Mirrored { change: Explained },
    /// A rotation and a translation are between the sides.
    OtherFrame { angle_rad: f64, shift: f64, change: Explained },
    /// Row `k` of the ideal side is of row `k + rows` of the measured one; of steps from row to row.
    RowShift { rows: isize, change: Explained },
    /// The measured side of a path is that of so many rows before, on the average; a standard error. RMS of
    /// what that moves readings by, and of what is left beside it, mm.
    Lag { rows: f64, standard_error: f64, moved_mm: f64, left_mm: f64 },
    /// The field, or else the origin of a side, changes while the rows are measured; RMS, mm.
    Drift { of_field: bool, changed_mm: f64, left_mm: f64 },
    /// Quaternions of one side have another order or other signs; angles.
    Quaternions { side: Side, change: QuaternionChange, explained: Explained },
    /// The signs of the last column are those that a scalar has.
    ScalarLast { rows: usize, negative_first: usize },
    /// The measured sensors' z is this direction in the ideal sensors' frames; angles.
    SensorAxis { axis_in_sensor: [f64; 3], explained: Explained },
    /// One rotation is between the orientations of the two sides, and none between the positions; angles.
    OrientationFrame { angle_rad: f64, explained: Explained },
    /// The orientations of the two sides have little to do with each other.
    Orientations { median_rad: f64 },
}

/// How far the sides differ in the median, and how far where the suspicion is right.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Explained {
    pub before: f64,
    pub after: f64,
    /// Far more than any tracker's error, and next to nothing of it is left.
    pub is_certain: bool,
}

impl Explained {
    /// An explanation that is reported: `certain` is a difference that no field makes.
    fn new(before: f64, after: f64, least: f64, certain: f64) -> Option<Self> {
        (before > least && before > SUSPECT_RATIO * after).then_some(Self {
            before,
            after,
            is_certain: before > certain && before > CERTAIN_RATIO * after,
        })
    }
}

impl Suspicion {
    /// Whether it is about the frames of the two sides, and nothing else.
    pub fn is_of_frames(&self) -> bool {
        matches!(self, Self::OtherFrame { .. } | Self::OrientationFrame { .. })
    }

    /// Whether no tracker's table is like this, so that it is used only on request.
    pub fn is_beyond_doubt(&self) -> bool {
        match self {
            Self::TooFar { .. } => true,
            Self::Metres { is_certain, .. } => *is_certain,
            Self::InchesOrCentimetres { .. }
            | Self::Outliers { .. }
            | Self::NotInRoom { .. }
            | Self::Lag { .. }
            | Self::Drift { .. }
            | Self::ScalarLast { .. } => false,
            Self::Scale { units, .. } => units.is_some(),
            Self::Axes { change, .. }
            | Self::Mirrored { change }
            | Self::OtherFrame { change, .. }
            | Self::RowShift { change, .. } => change.is_certain,
            Self::Quaternions { explained, .. }
            | Self::SensorAxis { explained, .. }
            | Self::OrientationFrame { explained, .. } => explained.is_certain,
            Self::Orientations { median_rad } => *median_rad > turned::CERTAIN_RAD,
        }
    }
}

/// A sentence without a full stop, for a line of its own or behind a file's name.
impl fmt::Display for Suspicion {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let mm = |c: &Explained| {
            format!("{} mm apart in the median, {} mm", short(c.before), short(c.after))
        };
        let deg = |e: &Explained| {
            let [before, after] = [e.before, e.after].map(f64::to_degrees);
            format!("{before:.1}° apart in the median, {after:.1}°")
        };
        match self {
            Self::Metres { span, reach, .. } => write!(
                f,
                "positions span {} and reach {} from the origin, a tracker's volume some 100 to 1,000 mm: are they metres?",
                short(*span),
                short(*reach)
            ),
            Self::InchesOrCentimetres { span, reach } => write!(
                f,
                "positions span {} and reach {} from the origin, a tracker's volume some 100 to 1,000 mm: are they inches \
                 or centimetres?",
                short(*span),
                short(*reach)
            ),
            Self::TooFar { count, first_row, largest } => write!(
                f,
                "{count} {} a coordinate beyond 1 km (row {first_row}; the largest is {largest:.3e} mm): are they missing \
                 readings?",
                if *count == 1 { "row has" } else { "rows have" }
            ),
            Self::Outliers { count, first_row, limit, largest, median } => write!(
                f,
                "{count} {} more than {} mm, up to {} mm, between ideal and measured position (row {first_row} first), \
                 the median is {} mm: are they outliers?",
                if *count == 1 { "row has" } else { "rows have" },
                short(*limit),
                short(*largest),
                short(*median)
            ),
            Self::Scale { sides: [first, second], ratio, first_mm, second_mm, units } => {
                write!(
                    f,
                    "distances among {second} positions are {} times those among {first} ones ({} and {} mm in the median): ",
                    short(*ratio),
                    short(*second_mm),
                    short(*first_mm)
                )?;
                match units {
                    Some(units) => write!(f, "are they in {units}?"),
                    None => f.write_str("are they of the same places, in one unit?"),
                }
            }
            Self::Axes { rows, change } => write!(
                f,
                "the sides are {} where {}: {}",
                mm(change),
                named_axes(rows, "measured ", "ideal "),
                match is_mirror(rows) {
                    true => "is one side mirrored or left-handed?",
                    false => "are axes taken for others?",
                }
            ),
            Self::NotInRoom { rows, inside, axes, inside_with_axes } => write!(
                f,
                "{inside} of {rows} positions are in the room's box, {inside_with_axes} where {}: are axes taken for others?",
                named_axes(axes, "", "")
            ),
            Self::Mirrored { change } => write!(
                f,
                "the sides are {} mm apart, {} mm where one is the other's mirror image, registered: is one mirrored or \
                 left-handed?",
                short(change.before),
                short(change.after)
            ),
            Self::OtherFrame { angle_rad, shift, change } => write!(
                f,
                "the sides are {} once they are registered (a rotation by {:.1}° and a translation of {} mm): are they \
                 in two frames?",
                mm(change),
                angle_rad.to_degrees(),
                short(*shift)
            ),
            Self::RowShift { rows, change } => write!(
                f,
                "from row to row, the sides' steps are {} where the ideal side's row k belongs to the measured side's row k \
                 {} {}: are rows shifted?",
                mm(change),
                if *rows < 0 { "−" } else { "+" },
                rows.abs()
            ),
            Self::Lag { rows, standard_error, moved_mm, left_mm } => write!(
                f,
                "along the path the measured side is {} rows {} the ideal one (standard error {}): readings move by {} mm \
                 RMS, where {} mm is left beside that: are the clocks of the two sides apart? (lag {} takes it out)",
                short(rows.abs()),
                if *rows < 0.0 { "before" } else { "behind" },
                short(*standard_error),
                short(*moved_mm),
                short(*left_mm),
                short(*rows)
            ),
            Self::Drift { of_field, changed_mm, left_mm } => write!(
                f,
                "from the first row to the last {} by {} mm RMS, where {} mm is left beside that: {}?",
                if *of_field { "the field changes" } else { "one side moves" },
                short(*changed_mm),
                short(*left_mm),
                if *of_field { "was metal moved" } else { "did the reference move" }
            ),
            Self::Quaternions { side, change, explained } => write!(
                f,
                "the orientations are {} where {} {change}",
                deg(explained),
                match side {
                    Side::Ideal => "the ideal quaternions",
                    Side::Measured => "the measured quaternions",
                    Side::Both => "all quaternions",
                }
            ),
            Self::ScalarLast { rows, negative_first } => write!(
                f,
                "qz is negative in none of {rows} rows and qw in {negative_first}, as if qw were the last: are the \
                 quaternions in the order x, y, z, w?"
            ),
            Self::SensorAxis { axis_in_sensor: [x, y, z], explained } => write!(
                f,
                "the sensors' axes are {} where the measured z axis is ({x:.2}, {y:.2}, {z:.2}) in the ideal sensor's \
                 frame: is another axis meant?",
                deg(explained)
            ),
            Self::OrientationFrame { angle_rad, explained } => write!(
                f,
                "the orientations are {} once all are rotated by {:.1}°, which the positions are not: are they in \
                 another frame?",
                deg(explained),
                angle_rad.to_degrees()
            ),
            Self::Orientations { median_rad } => write!(
                f,
                "the orientations are {:.1}° apart in the median, and no order, sign or frame of theirs explains it: are \
                 angles in degrees taken for radians, or quaternions made of other angles?",
                median_rad.to_degrees()
            ),
        }
    }
}

/// All signed permutations of the axes but the identity.
fn signed_axes() -> impl DoubleEndedIterator<Item = SignedAxes> {
    const ORDERS: [[usize; 3]; 6] =
        [[0, 1, 2], [1, 0, 2], [2, 1, 0], [0, 2, 1], [1, 2, 0], [2, 0, 1]];
    (1..48_usize).map(|number| {
        let sign = |k: usize| if number & (1 << k) == 0 { 1.0 } else { -1.0 };
        [0, 1, 2].map(|k| (ORDERS[number / 8][k], sign(k)))
    })
}

/// A vector with its axes taken for others.
fn on_axes(rows: &SignedAxes, p: &Vector3<f64>) -> Vector3<f64> {
    Vector3::from_fn(|k, _| rows[k].1 * p[rows[k].0])
}

/// `whose z is those z`, axis by axis, of those that are not themselves.
fn named_axes(rows: &SignedAxes, whose: &str, those: &str) -> String {
    let names = ["x", "y", "z"];
    let each = (0..3).filter(|&k| rows[k] != (k, 1.0)).map(|k| {
        let (of, sign) = rows[k];
        let minus = if sign < 0.0 { "−" } else { "" };
        format!("{whose}{} is {those}{minus}{}", names[k], names[of])
    });
    each.collect::<Vec<_>>().join(", ")
}

/// Whether a map of signed axes is a mirror image.
fn is_mirror(rows: &SignedAxes) -> bool {
    let signs: f64 = rows.iter().map(|row| row.1).product();
    // An even permutation of three moves all of them or none.
    let moved = (0..3).filter(|&k| rows[k].0 != k).count();
    let parity = if moved == 2 { -1.0 } else { 1.0 };
    signs * parity < 0.0
}

/// Three digits, whatever the size.
fn short(value: f64) -> String {
    let magnitude = value.abs();
    match magnitude {
        _ if magnitude >= 1e6 || (magnitude < 1e-4 && magnitude > 0.0) => format!("{value:.2e}"),
        _ if magnitude >= 100.0 => format!("{value:.0}"),
        _ if magnitude >= 10.0 => format!("{value:.1}"),
        _ if magnitude >= 1.0 || magnitude == 0.0 => format!("{value:.2}"),
        _ => format!("{value:.4}"),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn mirrors_are_distinguished_from_rotations() {
        for (rows, expected) in [
            ([(0, 1.0), (1, 1.0), (2, -1.0)], true),
            ([(0, -1.0), (1, -1.0), (2, 1.0)], false),
            ([(1, 1.0), (0, 1.0), (2, 1.0)], true),
            ([(1, 1.0), (0, -1.0), (2, 1.0)], false),
            ([(1, 1.0), (2, 1.0), (0, 1.0)], false),
            ([(1, -1.0), (2, -1.0), (0, -1.0)], true),
        ] {
            assert_eq!(is_mirror(&rows), expected, "{rows:?}");
        }
    }

    #[test]
    fn a_suspicion_is_a_sentence_with_its_numbers() {
        let axes = Suspicion::Axes {
            rows: [(1, 1.0), (0, 1.0), (2, -1.0)],
            change: Explained::new(412.0, 2.31, 5.0, 20.0).unwrap(),
        };
        assert!(axes.is_beyond_doubt());
        assert_eq!(
            axes.to_string(),
            "the sides are 412 mm apart in the median, 2.31 mm where measured x is ideal y, measured y is ideal x, \
             measured z is ideal −z: are axes taken for others?"
        );
        let metres = Suspicion::Metres { span: 0.6, reach: 0.71, is_certain: true };
        assert!(metres.to_string().starts_with("positions span 0.6000 and reach 0.7100"));
    }

    #[test]
    fn differences_of_a_field_are_no_evidence() {
        assert_eq!(Explained::new(4.9, 0.0, 5.0, 20.0), None);
        assert_eq!(Explained::new(12.0, 4.0, 5.0, 20.0), None);
        let small = Explained::new(12.0, 1.0, 5.0, 20.0).unwrap();
        assert!(!small.is_certain);
    }
}
