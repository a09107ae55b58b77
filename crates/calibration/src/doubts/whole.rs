//! What a whole side of a table may be: the scale, the frame and the axes that bring the two sides together.

use super::mistake::Mistake;
use super::{Explained, Suspicion};
use crate::registration::register;
use crate::robust::median;
use nalgebra::{Matrix3, Point3, Translation3, Vector3};
use trackwright_field::samples::Measurement;
use trackwright_geometry::pose::Pose;
use trackwright_geometry::rotation::rotation_angle_rad;
use trackwright_geometry::svd3::svd3;

/// Difference in the median that requires an explanation, mm: the worst good table has 4.7.
pub(super) const LEAST_MM: f64 = 5.0;

/// Part of the spread beyond which a difference is not the field's; good tables have at most 0.04.
pub(super) const CERTAIN_PART: f64 = 0.2;

/// An explanation as good as the best to this factor is preferred where it is simpler.
const AS_GOOD: f64 = 1.5;

/// The same in radians: a field turns axes by some degrees, by which a wrong change may seem better.
const AS_GOOD_RAD: f64 = 0.035;

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

/// Upper over lower quartile of the ratios, at most.
const MAX_SPREAD: f64 = 2.0;

/// Parts of the spread that a registration leaves: to be reported, and of no good localisation.
const LEAST_PART: f64 = 0.02;
const MIRRORED_PART: f64 = 0.05;

/// Points that are their own mirror image but for a rotation.
const MIN_MIRRORED: usize = 3;

/// Median angle between the axes of two sides that requires an explanation: ten times what the
/// worst of the rooms has (RMS 2.7°, median 1.6°), and half of it where a better one is at hand.
const UNEXPLAINED_RAD: f64 = 0.35;
const LEAST_RAD: f64 = 0.17;

/// Median angle that no field makes.
pub(super) const CERTAIN_RAD: f64 = 0.79;

/// Suspicions about corresponding points that a registration has to bring together: their scale, and
/// whether they are mirror images; what is explained is what the registration leaves, RMS.
pub fn of_point_pairs(source: &[Point3<f64>], target: &[Point3<f64>]) -> Vec<Suspicion> {
    let pairs: Vec<Pair> = source
        .iter()
        .zip(target)
        .map(|(source, target)| (source.coords, target.coords))
        .filter(|(a, b)| !super::alone::is_too_far(a) && !super::alone::is_too_far(b))
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
        Some(explained) if pairs.len() > MIN_MIRRORED => {
            vec![Suspicion::Mistake { mistake: Mistake::Mirrored, part: None, explained }]
        }
        _ => Vec::new(),
    }
}

fn mirror() -> Matrix3<f64> {
    Matrix3::from_diagonal(&Vector3::new(-1.0, 1.0, 1.0))
}

/// An ideal and a measured position.
pub(super) type Pair = (Vector3<f64>, Vector3<f64>);

pub(super) fn positions(m: &Measurement) -> Pair {
    (m.tracker_from_ideal.translation.vector, m.tracker_from_measured.translation.vector)
}

/// Median distance of the sides.
fn apart(rows: &[Measurement], change: impl Fn(&Measurement) -> Measurement) -> f64 {
    let each = rows.iter().map(|m| {
        let (ideal, measured) = positions(&change(m));
        (ideal - measured).norm()
    });
    median(&mut each.collect::<Vec<_>>()).unwrap_or(0.0)
}

/// Median distance from the middle, coordinate by coordinate.
pub(super) fn spread<'a>(positions: impl Iterator<Item = &'a Vector3<f64>> + Clone) -> f64 {
    let middle = middle(positions.clone());
    median(&mut positions.map(|p| (p - middle).norm()).collect::<Vec<_>>()).unwrap_or(0.0)
}

fn middle<'a>(positions: impl Iterator<Item = &'a Vector3<f64>> + Clone) -> Vector3<f64> {
    Vector3::from_fn(|k, _| {
        median(&mut positions.clone().map(|p| p[k]).collect::<Vec<_>>()).unwrap_or(0.0)
    })
}

/// The ratio of distances between rows, whatever frames they are in.
pub(super) fn scale(pairs: &[Pair], sides: [&'static str; 2]) -> Option<Suspicion> {
    // Every row with some others, all over the table.
    let others = (1..pairs.len()).step_by((pairs.len() / SCALE_PARTNERS).max(1));
    let each = others.flat_map(|by| {
        (0..pairs.len()).map(move |k| {
            let (a, b) = (&pairs[k], &pairs[(k + by) % pairs.len()]);
            ((a.0 - b.0).norm(), (a.1 - b.1).norm())
        })
    });
    let distances: Vec<(f64, f64)> = each.filter(|(a, b)| a.max(*b) >= MIN_SPREAD_MM).collect();
    let mut ratios: Vec<f64> = distances.iter().map(|(a, b)| b / a).collect();
    let ratio = median(&mut ratios)?;
    ratios.sort_by(f64::total_cmp);
    let [low, high] = [1, 3].map(|quarter| ratios[quarter * (ratios.len() - 1) / 4]);
    // Where a part of the rows is of other places or another unit, there is no one ratio.
    if high > MAX_SPREAD * low {
        return None;
    }
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
pub(super) fn placed(rows: &[Measurement]) -> Option<Suspicion> {
    let before = apart(rows, |m| *m);
    if before <= LEAST_MM {
        return None;
    }
    let pairs: Vec<Pair> = rows.iter().map(positions).collect();
    let [frame, mirrored] = [false, true].map(|is_mirrored| rigid(&pairs, is_mirrored));
    let at = middle(pairs.iter().map(|pair| &pair.0));
    let of_frame = |(pose, after): (Pose, f64)| {
        let angle_rad = pose.rotation.angle();
        let shift = (pose * Point3::from(at) - Point3::from(at)).norm();
        (Mistake::Frame { angle_rad, shift }, after)
    };
    let tried: Vec<(Mistake, f64)> = Mistake::of_axes()
        .map(|mistake| (mistake, apart(rows, |m| mistake.undone(m))))
        .min_by(|a, b| a.1.total_cmp(&b.1))
        .into_iter()
        .chain(sensor_offset(rows))
        .chain(frame.map(of_frame))
        .chain(mirrored.map(|(_, after)| (Mistake::Mirrored, after)))
        .collect();
    let best = tried.iter().map(|tried| tried.1).fold(f64::INFINITY, f64::min);
    let certain = CERTAIN_PART * spread(pairs.iter().map(|pair| &pair.0));
    let explained = |(mistake, after): (Mistake, f64)| {
        let explained = Explained::new(before, after, LEAST_MM, certain)?;
        Some(Suspicion::Mistake { mistake, part: None, explained })
    };
    tried.into_iter().filter(|tried| tried.1 <= AS_GOOD * best).find_map(explained)
}

/// The vector in the sensors' frames that most rows differ by: of 5-DOF sensors, whose roll is any, along their axes.
fn sensor_offset(rows: &[Measurement]) -> Option<(Mistake, f64)> {
    let mut along: Vec<f64> = rows
        .iter()
        .map(|m| {
            let (ideal, measured) = positions(m);
            (m.tracker_from_ideal.rotation.inverse() * (measured - ideal)).z
        })
        .collect();
    let z = median(&mut along)?;
    let spread = median(&mut along.iter().map(|of| (of - z).abs()).collect::<Vec<_>>())?;
    // Of a median of normal numbers, by their median deviation (Huber, 1981).
    let standard_error_mm = 1.253 * 1.483 * spread / (rows.len() as f64).sqrt();
    let after = apart(rows, |m| Measurement {
        tracker_from_ideal: m.tracker_from_ideal * Translation3::new(0.0, 0.0, z),
        ..*m
    });
    Some((
        Mistake::SensorOffset {
            offset_mm: [0.0, 0.0, z],
            standard_error_mm: Some(standard_error_mm),
        },
        after,
    ))
}

/// The rotation and translation of most pairs, of the ideal side's mirror image where requested,
/// and the median that they leave: a registration of the better half of the pairs, some times over
/// (Rousseeuw & Van Driessen, Data Mining and Knowledge Discovery 12, 2006).
pub(super) fn rigid(pairs: &[Pair], is_mirrored: bool) -> Option<(Pose, f64)> {
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

/// Which order, signs or rotation would bring the orientations together; `has_frame_difference` where positions
/// are already known to be in two frames, which orientations then are as well. Only the sensors' z axes are
/// compared: the roll of a 5-DOF sensor is any.
pub(super) fn turned(rows: &[Measurement], has_frame_difference: bool) -> Option<Suspicion> {
    let before = apart_rad(rows, |m| *m)?;
    if before <= LEAST_RAD {
        return None;
    }
    let suspicion = |mistake: Mistake, after: f64| {
        let explained = Explained::new(before, after, LEAST_RAD, CERTAIN_RAD)?;
        Some(Suspicion::Mistake { mistake, part: None, explained })
    };
    let axis = mean_axis_in_sensor(rows).map(|axis| Mistake::SensorAxis(axis.into()));
    let rotation = axes_rotation(rows);
    let angle_rad = rotation_angle_rad(&rotation);
    let mut tried: Vec<(Mistake, f64)> = Mistake::of_orientations()
        .chain(axis)
        .filter_map(|mistake| Some((mistake, apart_rad(rows, |m| mistake.undone(m))?)))
        .collect();
    let rotated = apart_rad(rows, |m| Measurement {
        tracker_from_ideal: Pose::from_parts(
            m.tracker_from_ideal.translation,
            rotation * m.tracker_from_ideal.rotation,
        ),
        ..*m
    })?;
    tried.push((Mistake::OrientationFrame { angle_rad }, rotated));
    let best = tried.iter().map(|tried| tried.1).min_by(f64::total_cmp)?;
    let is_good = |found: &&(Mistake, f64)| found.1 <= AS_GOOD * best + AS_GOOD_RAD;
    match tried.iter().filter(is_good).find_map(|(mistake, after)| suspicion(*mistake, *after)) {
        Some(Suspicion::Mistake { mistake: Mistake::OrientationFrame { .. }, .. })
            if has_frame_difference =>
        {
            None
        }
        None if before > UNEXPLAINED_RAD => {
            Some(Suspicion::Orientations { median_rad: before, part: None })
        }
        found => found,
    }
}

/// Median angle between the z axes of the two sides.
fn apart_rad(rows: &[Measurement], change: impl Fn(&Measurement) -> Measurement) -> Option<f64> {
    let angle = |m: &Measurement| {
        let m = change(m);
        ideal_axis(&m).angle(&measured_axis(&m))
    };
    median(&mut rows.iter().map(angle).collect::<Vec<_>>())
}

fn ideal_axis(m: &Measurement) -> Vector3<f64> {
    m.tracker_from_ideal.rotation * Vector3::z()
}

fn measured_axis(m: &Measurement) -> Vector3<f64> {
    m.tracker_from_measured.rotation * Vector3::z()
}

/// The measured z axis in the ideal sensor's frame, where it is one throughout.
fn mean_axis_in_sensor(rows: &[Measurement]) -> Option<Vector3<f64>> {
    let each = rows.iter().map(|m| m.tracker_from_ideal.rotation.inverse() * measured_axis(m));
    let mean = each.sum::<Vector3<f64>>() / rows.len() as f64;
    // Directions all over the sphere have a mean near zero, whose direction is meaningless.
    mean.try_normalize(0.5)
}

/// The rotation that takes the ideal axes nearest to the measured ones (Wahba 1965).
fn axes_rotation(rows: &[Measurement]) -> nalgebra::UnitQuaternion<f64> {
    let each = rows.iter().map(|m| ideal_axis(m) * measured_axis(m).transpose());
    svd3(&each.sum::<Matrix3<f64>>()).best_rotation()
}
