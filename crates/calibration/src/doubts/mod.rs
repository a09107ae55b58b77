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
mod beside_field;
mod effects;
mod in_order;
mod input;
mod mistake;
mod paired;
mod parts;
mod piece;
mod sensor;
mod text;
mod whole;

pub use alone::{PoseFrame, in_room, of_points, of_poses, with_written_quaternions};
pub use input::{Columns, InputMistake, of_input};
pub use mistake::{Mistake, QuaternionChange, Side};
pub use paired::PairedDoubts;
pub use whole::of_point_pairs;

use nalgebra::Vector3;

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
    /// All rows, or a part of them, are as one mistake makes them.
    Mistake { mistake: Mistake, part: Option<Part>, explained: Explained },
    /// Rows of which both sides are close to the origin, apart from the others, and among them in another unit.
    UnitOfPart { part: Part, units: &'static str },
    /// Rows whose position is zero on one side, as of missing readings.
    Zeros { count: usize, first_row: usize },
    /// Rows whose numbers are those of another row, far more often than those of other rows are.
    Repeated { count: usize, first_row: usize },
    /// Rows with the same numbers on both sides.
    Copied { count: usize, of: usize, first_row: usize },
    /// The sides differ by more than a room's field makes, and nothing explains it; RMS.
    Large { position_mm: f64, angle_rad: f64 },
    /// Positions are farther away than any tracker reads.
    TooLarge { span: f64, reach: f64, is_certain: bool },
    /// Hardly a position is in the room that is applied to them, and nearly all are with other axes.
    NotInRoom { rows: usize, inside: usize, axes: SignedAxes, inside_with_axes: usize },
    /// Trials of given poses with their sensors in the room, and the mean distance of tip and CRF from the design's
    /// own: as they are read, and without this mistake.
    Input { rows: usize, inside: [usize; 2], from_own_mm: [f64; 2], mistake: InputMistake },
    /// Row `k` of the ideal side is of row `k + rows` of the measured one; of steps from row to row.
    RowShift { rows: isize, part: Option<Part>, change: Explained },
    /// The measured side of a path is that of so many rows before, on the average; a standard error. RMS of
    /// what that moves readings by, and of what is left beside it, mm.
    Lag { rows: f64, standard_error: f64, moved_mm: f64, left_mm: f64 },
    /// The field, or else the origin of a side, changes while the rows are measured; RMS, mm.
    Drift { of_field: bool, changed_mm: f64, left_mm: f64 },
    /// The signs of the last column are those that a scalar has.
    ScalarLast { rows: usize, negative_first: usize },
    /// The orientations of the two sides have little to do with each other.
    Orientations { median_rad: f64, part: Option<Part> },
}

/// Some rows of a table: those that were looked at.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Part {
    pub count: usize,
    pub of: usize,
    pub first_row: usize,
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
        use mistake::Mistake::{Frame, OrientationFrame};
        matches!(self, Self::Mistake { mistake: Frame { .. } | OrientationFrame { .. }, .. })
    }

    /// Whether no tracker's table is like this, so that it is used only on request.
    pub fn is_beyond_doubt(&self) -> bool {
        match self {
            Self::TooFar { .. } | Self::Zeros { .. } => true,
            Self::Metres { is_certain, .. } | Self::TooLarge { is_certain, .. } => *is_certain,
            Self::InchesOrCentimetres { .. }
            | Self::Outliers { .. }
            | Self::NotInRoom { .. }
            | Self::Input { .. }
            | Self::Lag { .. }
            | Self::Drift { .. }
            | Self::UnitOfPart { .. }
            | Self::Repeated { .. }
            | Self::Copied { .. }
            | Self::Large { .. }
            | Self::ScalarLast { .. } => false,
            Self::Scale { units, .. } => units.is_some(),
            Self::RowShift { change, .. } => change.is_certain,
            Self::Mistake { explained, .. } => explained.is_certain,
            Self::Orientations { median_rad, .. } => *median_rad > whole::CERTAIN_RAD,
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
        let axes = Suspicion::Mistake {
            mistake: Mistake::Axes([(1, 1.0), (0, 1.0), (2, -1.0)]),
            part: None,
            explained: Explained::new(412.0, 2.31, 5.0, 20.0).unwrap(),
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
