//! What two sides of a table show beside each other, row by row.

use super::alone::{Extent, PoseFrame, Signs, is_too_far};
use super::{Explained, MIN_ROWS, Suspicion, in_order, on_axes, signed_axes, turned};
use crate::registration::register;
use crate::robust::median;
use nalgebra::{Matrix3, Point3, Vector3};
use std::collections::VecDeque;
use trackwright_field::samples::{Measurement, MeasurementContent};

/// Rows that are looked at, evenly from the table, of however many.
const MAX_KEPT: usize = 4096;

/// Rows by which a side may be late.
const MAX_SHIFT: usize = 3;

/// Rows around a step: as many before it and behind it as a side may be late by.
const WINDOW: usize = 2 * MAX_SHIFT + 2;

/// Steps from row to row that are used, the longest of the table, and the fewest: on a path,
/// whose rows are nearly where their neighbours are, those at its gaps and ends alone.
const MAX_STEPS: usize = 256;
const MIN_STEPS: usize = 6;

/// Difference in the median that requires an explanation, mm: the worst good table has 4.7.
const LEAST_MM: f64 = 5.0;

/// Part of the spread beyond which a difference is not the field's; good tables have at most 0.04.
const CERTAIN_PART: f64 = 0.2;

/// An explanation as good as the best to this factor is preferred where it is simpler.
const AS_GOOD: f64 = 1.5;

/// A row is an outlier where its sides are farther apart than this, mm, and so many times as far as
/// the median row's. Good tables have 24 and 50 mm at most, the latter where characterisation leaves
/// out what is farther, and 19 times the median.
const OUTLIER_MM: f64 = 60.0;
const OUTLIER_RATIO: f64 = 20.0;

/// Those down to half as far are outliers as well where so many times as far as the next nearer row: they
/// are the tracker's other solution too.
const OUTLIER_GAP: f64 = 1.5;

/// Spread of the wider side that determines the other's unit, mm: a still sensor's is noise.
const MIN_SPREAD_MM: f64 = 20.0;

/// Rows that the distance of each row to is compared.
const SCALE_PARTNERS: usize = 8;

/// Ratios of units, and how near one has to be; a field scales by some hundredths.
const UNITS: [(f64, &str); 5] = [
    (1000.0, "metres and millimetres"),
    (304.8, "feet and millimetres"),
    (100.0, "metres and centimetres"),
    (25.4, "inches and millimetres"),
    (10.0, "centimetres and millimetres"),
];
const UNIT_TOLERANCE: f64 = 0.1;

/// Ratio of the sides' spreads that no field makes, where it is of no units.
const MAX_SCALE: f64 = 1.5;

/// Parts of the spread that a registration leaves: to be reported, and of no good localisation.
const LEAST_PART: f64 = 0.02;
const MIRRORED_PART: f64 = 0.05;

/// Points that are their own mirror image but for a rotation.
const MIN_MIRRORED: usize = 3;

/// Measurements as they come, of which a bounded number is kept.
#[derive(Clone, Debug)]
pub struct PairedDoubts {
    content: MeasurementContent,
    frame: PoseFrame,
    rows: usize,
    kept: Vec<Measurement>,
    /// Every so many-th row is kept.
    stride: usize,
    recent: VecDeque<Pair>,
    /// With the rows around them.
    steps: Vec<Step>,
    /// Shorter ones are not among the longest.
    least_step_mm: f64,
    /// Distance between the sides of each row, mm.
    apart_mm: Vec<f32>,
    ideal: Extent,
    measured: Extent,
    signs: [Signs; 2],
}

impl PairedDoubts {
    /// Of a table without rows.
    pub fn new(content: MeasurementContent, frame: PoseFrame) -> Self {
        Self {
            content,
            frame,
            rows: 0,
            kept: Vec::new(),
            stride: 1,
            recent: VecDeque::with_capacity(WINDOW),
            steps: Vec::new(),
            least_step_mm: LEAST_MM,
            apart_mm: Vec::new(),
            ideal: Extent::default(),
            measured: Extent::default(),
            signs: [Signs::default(); 2],
        }
    }

    /// The suspicions of a whole table.
    pub fn of(
        measurements: &[Measurement],
        content: MeasurementContent,
        frame: PoseFrame,
    ) -> Vec<Suspicion> {
        let mut doubts = Self::new(content, frame);
        measurements.iter().for_each(|m| doubts.push(m));
        doubts.suspicions()
    }

    /// Takes the next row.
    pub fn push(&mut self, m: &Measurement) {
        let (ideal, measured) = positions(m);
        self.ideal.push(&[ideal]);
        self.measured.push(&[measured]);
        self.apart_mm.push((measured - ideal).norm() as f32);
        if self.content != MeasurementContent::PositionOnly {
            self.signs[0].push(&m.tracker_from_ideal);
            self.signs[1].push(&m.tracker_from_measured);
        }
        if self.rows.is_multiple_of(self.stride) {
            if self.kept.len() == MAX_KEPT {
                let mut places = 0..;
                self.kept.retain(|_| places.next().is_some_and(|k: usize| k.is_multiple_of(2)));
                self.stride *= 2;
            }
            if self.rows.is_multiple_of(self.stride) {
                self.kept.push(*m);
            }
        }
        self.push_step((ideal, measured));
        self.rows += 1;
    }

    fn push_step(&mut self, pair: Pair) {
        if self.recent.len() == WINDOW {
            self.recent.pop_front();
        }
        self.recent.push_back(pair);
        if self.recent.len() < WINDOW {
            return;
        }
        let around: [Pair; WINDOW] = std::array::from_fn(|k| self.recent[k]);
        let length_mm = (around[MAX_SHIFT + 1].0 - around[MAX_SHIFT].0).norm();
        let is_long = length_mm > self.least_step_mm && length_mm < super::MAX_POSITION_MM;
        if !is_long {
            return;
        }
        self.steps.push(Step { length_mm, around });
        if self.steps.len() == 2 * MAX_STEPS {
            self.steps.sort_by(|a, b| b.length_mm.total_cmp(&a.length_mm));
            self.steps.truncate(MAX_STEPS);
            self.least_step_mm = self.steps[MAX_STEPS - 1].length_mm;
        }
    }

    /// What is suspected, the worst first.
    pub fn suspicions(&self) -> Vec<Suspicion> {
        let mut found = self.alone();
        if self.rows < MIN_ROWS {
            return found;
        }
        let usable: Vec<Measurement> = self
            .kept
            .iter()
            .filter(|m| {
                let (ideal, measured) = positions(m);
                !is_too_far(&ideal) && !is_too_far(&measured)
            })
            .copied()
            .collect();
        let pairs: Vec<_> = usable.iter().map(positions).collect();
        if pairs.len() < MIN_ROWS {
            return found;
        }
        // One of another scale is compared with nothing until that is put right.
        if let Some(scale) = scale(&pairs, ["ideal", "measured"]) {
            found.push(scale);
        } else {
            let place = self.shift(&pairs).or_else(|| placed(&pairs));
            let is_shifted = matches!(place, Some(Suspicion::RowShift { .. }));
            let has_frame = place.is_some();
            found.extend(place.clone());
            if place.is_none() {
                found.extend(self.outliers());
            }
            if self.content != MeasurementContent::PositionOnly && !is_shifted {
                let turned = turned::suspicion(&usable, has_frame);
                if turned.is_none() {
                    found.extend(self.scalar_last());
                }
                found.extend(turned);
            }
        }
        // Other mistakes move all rows, or whole parts of them.
        if found.iter().all(|suspicion| matches!(suspicion, Suspicion::Outliers { .. })) {
            found.extend(in_order::suspicions(&usable, self.content, self.stride));
        }
        found.sort_by_key(|suspicion| !suspicion.is_beyond_doubt());
        found
    }

    /// What a side shows by itself. Sides in one small unit report it once.
    fn alone(&self) -> Vec<Suspicion> {
        let mut found = self.ideal.suspicions(self.frame);
        for other in self.measured.suspicions(self.frame) {
            let is_reported = |earlier: &Suspicion| {
                std::mem::discriminant(earlier) == std::mem::discriminant(&other)
            };
            if !found.iter().any(is_reported) {
                found.push(other);
            }
        }
        found
    }

    fn scalar_last(&self) -> Option<Suspicion> {
        let [ideal, measured] = self.signs.map(|signs| signs.suspicion());
        ideal.or(measured)
    }

    fn outliers(&self) -> Option<Suspicion> {
        let mut all: Vec<f64> = self.apart_mm.iter().map(|&mm| f64::from(mm)).collect();
        let median = median(&mut all)?;
        let mut limit = OUTLIER_MM.max(OUTLIER_RATIO * median);
        all.sort_by(f64::total_cmp);
        let first_beyond = all.partition_point(|mm| *mm <= limit);
        let half_as_far = all.partition_point(|mm| *mm <= limit / 2.0);
        let neighbors = all.get(half_as_far.saturating_sub(1)..=first_beyond)?.windows(2);
        let gap = neighbors.max_by(|a, b| (a[1] / a[0]).total_cmp(&(b[1] / b[0])));
        if let Some(&[nearer, farther]) = gap
            && farther > OUTLIER_GAP * nearer
        {
            limit = (nearer + farther) / 2.0;
        }
        let mut beyond = self.apart_mm.iter().enumerate().filter(|(_, mm)| {
            let mm = f64::from(**mm);
            mm > limit && mm < super::MAX_POSITION_MM
        });
        let (first, mm) = beyond.next()?;
        let (count, largest) =
            beyond.fold((1, *mm), |(count, most), (_, mm)| (count + 1, most.max(*mm)));
        let (first_row, largest) = (first + 1, largest.into());
        Some(Suspicion::Outliers { count, first_row, limit, largest, median })
    }

    /// Rows of one side that are late: its steps from row to row are those of other rows.
    fn shift(&self, pairs: &[Pair]) -> Option<Suspicion> {
        if self.steps.len() < MIN_STEPS {
            return None;
        }
        let late = |rows: isize| {
            let each = self.steps.iter().map(|step| step.difference_mm(rows));
            median(&mut each.collect::<Vec<_>>())
        };
        let shifts = (1..=MAX_SHIFT as isize).flat_map(|rows| [rows, -rows]);
        let tried = shifts.filter_map(|rows| Some((rows, late(rows)?)));
        let (rows, after) = tried.min_by(|a, b| a.1.total_cmp(&b.1))?;
        let certain = CERTAIN_PART * spread(pairs.iter().map(|pair| &pair.0));
        let change = Explained::new(late(0)?, after, LEAST_MM, certain)?;
        Some(Suspicion::RowShift { rows, change })
    }
}

/// Where a table goes from one row to the next.
#[derive(Clone, Copy, Debug)]
struct Step {
    /// Of the ideal side.
    length_mm: f64,
    around: [Pair; WINDOW],
}

impl Step {
    /// Between this step of the ideal side and the measured one so many rows later.
    fn difference_mm(&self, rows: isize) -> f64 {
        let at = MAX_SHIFT.saturating_add_signed(rows);
        let ideal = self.around[MAX_SHIFT + 1].0 - self.around[MAX_SHIFT].0;
        (self.around[at + 1].1 - self.around[at].1 - ideal).norm()
    }
}

/// Suspicions about corresponding points that a registration has to bring together: their scale, and
/// whether they are mirror images; what is explained is what the registration leaves, RMS.
pub fn of_point_pairs(source: &[Point3<f64>], target: &[Point3<f64>]) -> Vec<Suspicion> {
    let pairs: Vec<Pair> = source
        .iter()
        .zip(target)
        .map(|(source, target)| (source.coords, target.coords))
        .filter(|(a, b)| !is_too_far(a) && !is_too_far(b))
        .collect();
    if let Some(scale) = scale(&pairs, ["source", "target"]) {
        return vec![scale];
    }
    // What lies in a plane is its own mirror image, turned over.
    let of = |side: fn(&Pair) -> Vector3<f64>| pairs.iter().map(side).map(Point3::from).collect();
    let [source, mirrored, target]: [Vec<Point3<f64>>; 3] =
        [of(|p| p.0), of(|p| mirror() * p.0), of(|p| p.1)];
    let fre = |source: &[Point3<f64>]| register(source, &target).map(|found| found.fre_rms_mm);
    let (Ok(before), Ok(after)) = (fre(&source), fre(&mirrored)) else {
        return Vec::new();
    };
    let spread = spread(pairs.iter().map(|pair| &pair.0));
    let least = LEAST_MM.min(LEAST_PART * spread);
    match Explained::new(before, after, least, MIRRORED_PART * spread) {
        Some(change) if pairs.len() > MIN_MIRRORED => vec![Suspicion::Mirrored { change }],
        _ => Vec::new(),
    }
}

fn mirror() -> Matrix3<f64> {
    Matrix3::from_diagonal(&Vector3::new(-1.0, 1.0, 1.0))
}

/// An ideal and a measured position.
type Pair = (Vector3<f64>, Vector3<f64>);

fn positions(m: &Measurement) -> Pair {
    (m.tracker_from_ideal.translation.vector, m.tracker_from_measured.translation.vector)
}

/// Median distance of the sides, one of them mapped.
fn apart(pairs: &[Pair], map: impl Fn(&Vector3<f64>) -> Vector3<f64>) -> f64 {
    let mut each: Vec<f64> =
        pairs.iter().map(|(ideal, measured)| (map(ideal) - measured).norm()).collect();
    median(&mut each).unwrap_or(0.0)
}

fn explained(pairs: &[Pair], after: f64) -> Option<Explained> {
    let spread = spread(pairs.iter().map(|pair| &pair.0));
    Explained::new(apart(pairs, |p| *p), after, LEAST_MM, CERTAIN_PART * spread)
}

/// Median distance from the middle, coordinate by coordinate.
fn spread<'a>(positions: impl Iterator<Item = &'a Vector3<f64>> + Clone) -> f64 {
    let middle = middle(positions.clone());
    median(&mut positions.map(|p| (p - middle).norm()).collect::<Vec<_>>()).unwrap_or(0.0)
}

fn middle<'a>(positions: impl Iterator<Item = &'a Vector3<f64>> + Clone) -> Vector3<f64> {
    Vector3::from_fn(|k, _| {
        median(&mut positions.clone().map(|p| p[k]).collect::<Vec<_>>()).unwrap_or(0.0)
    })
}

/// The ratio of distances between rows, whatever frames they are in.
fn scale(pairs: &[Pair], sides: [&'static str; 2]) -> Option<Suspicion> {
    // Every row with some others, all over the table.
    let others = (1..pairs.len()).step_by((pairs.len() / SCALE_PARTNERS).max(1));
    let each = others.flat_map(|by| {
        (0..pairs.len()).map(move |k| {
            let (a, b) = (&pairs[k], &pairs[(k + by) % pairs.len()]);
            ((a.0 - b.0).norm(), (a.1 - b.1).norm())
        })
    });
    let distances: Vec<(f64, f64)> = each.filter(|(a, b)| a.max(*b) >= MIN_SPREAD_MM).collect();
    let ratio = median(&mut distances.iter().map(|(a, b)| b / a).collect::<Vec<_>>())?;
    let factor = ratio.max(ratio.recip());
    if !factor.is_finite() || factor < MAX_SCALE {
        return None;
    }
    let is_of = |unit: f64| (factor / unit - 1.0).abs() < UNIT_TOLERANCE;
    let units = UNITS.iter().find(|(unit, _)| is_of(*unit));
    let typical =
        |side: fn(&(f64, f64)) -> f64| median(&mut distances.iter().map(side).collect::<Vec<_>>());
    Some(Suspicion::Scale {
        sides,
        ratio,
        first_mm: typical(|d| d.0)?,
        second_mm: typical(|d| d.1)?,
        units: units.map(|(_, name)| *name),
    })
}

/// Axes, a frame or a mirror that explain how the sides differ.
fn placed(pairs: &[Pair]) -> Option<Suspicion> {
    if apart(pairs, |p| *p) <= LEAST_MM {
        return None;
    }
    let axes = signed_axes()
        .map(|rows| (rows, apart(pairs, |p| on_axes(&rows, p))))
        .min_by(|a, b| a.1.total_cmp(&b.1));
    let (frame, mirror) = (rigid(pairs, false), rigid(pairs, true));
    let best = [axes.map(|found| found.1), frame.map(|found| found.1), mirror.map(|found| found.1)]
        .into_iter()
        .flatten()
        .fold(f64::INFINITY, f64::min);
    let is_good = |after: f64| after <= AS_GOOD * best;
    if let Some((rows, after)) = axes.filter(|found| is_good(found.1))
        && let Some(change) = explained(pairs, after)
    {
        return Some(Suspicion::Axes { rows, change });
    }
    if let Some((pose, after)) = frame.filter(|found| is_good(found.1))
        && let Some(change) = explained(pairs, after)
    {
        let at = middle(pairs.iter().map(|pair| &pair.0));
        return Some(Suspicion::OtherFrame {
            angle_rad: pose.rotation.angle(),
            shift: (pose * Point3::from(at) - Point3::from(at)).norm(),
            change,
        });
    }
    let (_, after) = mirror.filter(|found| is_good(found.1))?;
    explained(pairs, after).map(|change| Suspicion::Mirrored { change })
}

/// The rotation and translation of most pairs, of the ideal side's mirror image where requested,
/// and the median that they leave: a registration of the better half of the pairs, some times over
/// (Rousseeuw & Van Driessen, Data Mining and Knowledge Discovery 12, 2006).
fn rigid(pairs: &[Pair], is_mirrored: bool) -> Option<(trackwright_geometry::pose::Pose, f64)> {
    const STEPS: usize = 5;
    let mirror = match is_mirrored {
        true => self::mirror(),
        false => Matrix3::identity(),
    };
    let source: Vec<Point3<f64>> = pairs.iter().map(|p| (mirror * p.0).into()).collect();
    let target: Vec<Point3<f64>> = pairs.iter().map(|p| p.1.into()).collect();
    let mut order = central(pairs);
    let mut found = None;
    for _ in 0..STEPS {
        let of = |points: &[Point3<f64>]| order.iter().map(|&k| points[k]).collect::<Vec<_>>();
        let pose = register(&of(&source), &of(&target)).ok()?.target_from_source;
        let left = |k: usize| (pose * source[k] - target[k]).norm();
        let mut all: Vec<f64> = (0..pairs.len()).map(left).collect();
        let after = median(&mut all)?;
        found = Some((pose, after));
        order = (0..pairs.len()).collect();
        order.sort_by(|&a, &b| left(a).total_cmp(&left(b)));
        order.truncate(pairs.len().div_ceil(2).max(MIN_MIRRORED + 1));
    }
    found
}

/// Pairs with neither side far out.
fn central(pairs: &[Pair]) -> Vec<usize> {
    let sides = [
        (middle(pairs.iter().map(|p| &p.0)), spread(pairs.iter().map(|p| &p.0))),
        (middle(pairs.iter().map(|p| &p.1)), spread(pairs.iter().map(|p| &p.1))),
    ];
    let is_in = |pair: &Pair| {
        [pair.0, pair.1]
            .iter()
            .zip(&sides)
            .all(|(at, (middle, spread))| (at - middle).norm() <= 4.0 * spread)
    };
    (0..pairs.len()).filter(|&k| is_in(&pairs[k])).collect()
}
