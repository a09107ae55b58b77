//! From readings of a plate to its table: jitter, errors of distances and of turns, and how far rods
//! shift a reading.

use super::plate::{GRID_MM, PlateReading, SensorKind, Site, SiteAt};
use super::table::{ALL, Measure, ProtocolRow, Statistics};
use crate::still_pose::{StillPose, still_pose};
use nalgebra::Vector3;
use std::collections::HashMap;
use trackwright_geometry::limits::short;
use trackwright_geometry::pose::{Pose, distances};

/// Longest distance that is compared, in steps of the grid: 200 mm.
const MOST_STEPS: usize = 4;

/// Fewest holes with a neighbour, of all levels: the corners of one square.
pub const MIN_HOLES: usize = 4;

/// Positions of the disc farther apart than so many times the least step are not one turn.
const LONGEST_STEP: f64 = 1.5;

/// Of a turn, what has to be measured of it at least; else the axis is not in the disc's plane.
const LEAST_TURN: f64 = 0.5;

/// Why readings are no run of the protocol.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
pub enum EvaluationError {
    #[error(
        "too few holes: {found} have a neighbour at {GRID_MM} mm along a row or a column, expected at \
         least {MIN_HOLES}"
    )]
    TooFewHoles { found: usize },
    #[error("{site}: found readings beside a rod of {rod} and none without it, expected both")]
    RodWithoutReference { site: String, rod: String },
    #[error(
        "the sensor's axis turns by {:.2}° a step of the disc, expected {:.2}°: it is not in the plane of the \
         disc",
        found_deg,
        expected_deg
    )]
    AxisOutOfPlane { found_deg: f64, expected_deg: f64 },
}

/// The pose of a still sensor at one site.
struct Still<'a> {
    site: &'a Site,
    found: StillPose,
}

/// A value and what it is of.
type Named = (f64, String);

/// All rows of the table. Readings at one site are of a still sensor: their mean without outliers counts
/// ([`still_pose`]), and their scatter is the jitter.
///
/// # Errors
/// See [`EvaluationError`]. What was not measured, such as turns, has no rows.
pub fn evaluate(
    readings: &[PlateReading],
    sensor: SensorKind,
) -> Result<Vec<ProtocolRow>, EvaluationError> {
    let stills = stills(readings);
    let plain: Vec<&Still> = stills.iter().filter(|still| still.site.rod.is_none()).collect();
    let mut levels: Vec<usize> = plain.iter().map(|still| still.site.level).collect();
    levels.sort_unstable();
    levels.dedup();
    let mut rows = Vec::new();
    jitter_rows(&plain, &levels, &mut rows);
    distance_rows(&plain, &levels, &mut rows)?;
    rotation_rows(&plain, &levels, sensor, &mut rows)?;
    rod_rows(&stills, &mut rows)?;
    Ok(rows)
}

/// Sites with their readings, in the order of their first ones.
fn stills(readings: &[PlateReading]) -> Vec<Still<'_>> {
    let mut sites: Vec<(&Site, Vec<Pose>)> = Vec::new();
    let mut places: HashMap<_, usize> = HashMap::new();
    for reading in readings {
        let site = &reading.site;
        let at = match site.at {
            SiteAt::Hole { row, column } => (0, row as u64, column as u64),
            SiteAt::Disc { angle_deg } => (1, angle_deg.to_bits(), 0),
        };
        let rod = site.rod.as_ref();
        let rod = rod.map(|rod| (&rod.rod, rod.distance_mm.to_bits(), &rod.placement));
        let place = *places.entry((site.level, at, rod)).or_insert_with(|| {
            sites.push((site, Vec::new()));
            sites.len() - 1
        });
        sites[place].1.push(reading.tracker_from_sensor);
    }
    let all = sites.into_iter();
    all.filter_map(|(site, poses)| Some(Still { site, found: still_pose(&poses)? })).collect()
}

/// A row, unless there are no values.
fn add(rows: &mut Vec<ProtocolRow>, measure: &Measure, condition: String, values: &[&Named]) {
    let Some(statistics) = Statistics::of(values.iter().map(|(value, _)| *value)) else { return };
    let worst = values.iter().max_by(|a, b| a.0.abs().total_cmp(&b.0.abs()));
    rows.push(ProtocolRow {
        measure: measure.clone(),
        condition,
        statistics,
        worst: worst.map(|(_, name)| name.clone()).unwrap_or_default(),
    });
}

fn jitter_rows(plain: &[&Still], levels: &[usize], rows: &mut Vec<ProtocolRow>) {
    // Over the three axes: the RMS distance from the mean.
    let rms_mm = |still: &Still| 3.0_f64.sqrt() * still.found.jitter.position_mm;
    let repeated = plain.iter().filter(|still| still.found.used > 1);
    let values: Vec<(usize, Named)> =
        repeated.map(|s| (s.site.level, (rms_mm(s), s.site.label()))).collect();
    by_level(&values, levels, &Measure::Jitter, rows);
}

/// A row over all levels and, where there are several, one for each.
fn by_level(
    values: &[(usize, Named)],
    levels: &[usize],
    measure: &Measure,
    rows: &mut Vec<ProtocolRow>,
) {
    let all: Vec<&Named> = values.iter().map(|(_, named)| named).collect();
    add(rows, measure, ALL.to_owned(), &all);
    for level in levels.iter().filter(|_| levels.len() > 1) {
        let of_level = values.iter().filter(|(of, _)| of == level);
        let of_level: Vec<&Named> = of_level.map(|(_, named)| named).collect();
        add(rows, measure, format!("level {level}"), &of_level);
    }
}

fn distance_rows(
    plain: &[&Still],
    levels: &[usize],
    rows: &mut Vec<ProtocolRow>,
) -> Result<(), EvaluationError> {
    let holes: Vec<([usize; 3], Vector3<f64>)> = plain
        .iter()
        .filter_map(|still| match still.site.at {
            SiteAt::Hole { row, column } => {
                Some(([still.site.level, row, column], still.found.pose.translation.vector))
            }
            SiteAt::Disc { .. } => None,
        })
        .collect();
    let positions: HashMap<[usize; 3], Vector3<f64>> = holes.iter().copied().collect();
    let neighbours = holes.iter().filter(|([level, row, column], _)| {
        let mut around = vec![[*level, row + 1, *column], [*level, *row, column + 1]];
        around.extend(row.checked_sub(1).map(|row| [*level, row, *column]));
        around.extend(column.checked_sub(1).map(|column| [*level, *row, column]));
        around.iter().any(|hole| positions.contains_key(hole))
    });
    let found = neighbours.count();
    if found < MIN_HOLES {
        return Err(EvaluationError::TooFewHoles { found });
    }
    for steps in 1..=MOST_STEPS {
        let true_mm = steps as f64 * GRID_MM;
        let measure = Measure::Distance(true_mm as u32);
        let along = |next: fn([usize; 3], usize) -> [usize; 3]| -> Vec<(usize, Named)> {
            let pairs = holes.iter().filter_map(|(hole, here)| {
                let there = positions.get(&next(*hole, steps))?;
                let [level, row, column] = *hole;
                let [_, to_row, to_column] = next(*hole, steps);
                let name =
                    format!("level {level}, row {row}, column {column} to {to_row}, {to_column}");
                Some((level, ((there - here).norm() - true_mm, name)))
            });
            pairs.collect()
        };
        let rows_apart = along(|[level, row, column], steps| [level, row + steps, column]);
        let columns_apart = along(|[level, row, column], steps| [level, row, column + steps]);
        let all: Vec<_> = columns_apart.iter().chain(&rows_apart).cloned().collect();
        by_level(&all, if steps == 1 { levels } else { &[] }, &measure, rows);
        for (name, values) in [("along x", columns_apart), ("along y", rows_apart)] {
            let values: Vec<&Named> = values.iter().map(|(_, named)| named).collect();
            add(rows, &measure, name.to_owned(), &values);
        }
    }
    Ok(())
}

fn rotation_rows(
    plain: &[&Still],
    levels: &[usize],
    sensor: SensorKind,
    rows: &mut Vec<ProtocolRow>,
) -> Result<(), EvaluationError> {
    let mut values: Vec<(usize, Named)> = Vec::new();
    let (mut measured_deg, mut true_deg) = (0.0, 0.0);
    for &level in levels {
        let mut disc: Vec<(f64, &Pose)> = plain
            .iter()
            .filter(|still| still.site.level == level)
            .filter_map(|still| match still.site.at {
                SiteAt::Disc { angle_deg } => Some((angle_deg, &still.found.pose)),
                SiteAt::Hole { .. } => None,
            })
            .collect();
        disc.sort_by(|a, b| a.0.total_cmp(&b.0));
        // From the last position on to the first.
        let beyond =
            disc.first().filter(|_| disc.len() > 2).map(|(deg, pose)| (deg + 360.0, *pose));
        let around: Vec<(f64, &Pose)> = disc.into_iter().chain(beyond).collect();
        let gaps = || around.windows(2).map(|pair| pair[1].0 - pair[0].0);
        let least = gaps().filter(|gap| *gap > 0.0).fold(f64::INFINITY, f64::min);
        for (pair, gap) in around.windows(2).zip(gaps()) {
            if !(gap > 0.0 && gap <= LONGEST_STEP * least && gap < 180.0) {
                continue;
            }
            let turn_deg = turn_rad(pair[0].1, pair[1].1, sensor).to_degrees();
            measured_deg += turn_deg;
            true_deg += gap;
            let name = format!(
                "level {level}, from {}° to {}°",
                short(pair[0].0),
                short(pair[1].0 % 360.0)
            );
            values.push((level, (turn_deg - gap, name)));
        }
    }
    if measured_deg < LEAST_TURN * true_deg {
        let count = values.len() as f64;
        let (found_deg, expected_deg) = (measured_deg / count, true_deg / count);
        return Err(EvaluationError::AxisOutOfPlane { found_deg, expected_deg });
    }
    by_level(&values, levels, &Measure::Rotation, rows);
    Ok(())
}

/// Angle between two poses: of their z, or of the rotation from one to the other.
fn turn_rad(from: &Pose, to: &Pose, sensor: SensorKind) -> f64 {
    match sensor {
        SensorKind::SixDof => distances(from, to).1,
        SensorKind::FiveDof => {
            let [a, b] = [from, to].map(|pose| pose.rotation * Vector3::z());
            a.cross(&b).norm().atan2(a.dot(&b))
        }
    }
}

fn rod_rows(stills: &[Still], rows: &mut Vec<ProtocolRow>) -> Result<(), EvaluationError> {
    let mut found: Vec<(Measure, f64, Vec<Named>)> = Vec::new();
    for still in stills {
        let Some(rod) = &still.site.rod else { continue };
        let without = Site::plain(still.site.level, still.site.at);
        let Some(reference) = stills.iter().find(|other| *other.site == without) else {
            let (site, rod) = (without.label(), rod.rod.clone());
            return Err(EvaluationError::RodWithoutReference { site, rod });
        };
        let (shift_mm, _) = distances(&reference.found.pose, &still.found.pose);
        let measure = Measure::Rod(rod.rod.clone());
        let named = (shift_mm, rod.placement.clone());
        let of_rod = |(other, mm, _): &&mut (Measure, f64, Vec<Named>)| {
            *other == measure && *mm == rod.distance_mm
        };
        match found.iter_mut().find(of_rod) {
            Some((_, _, values)) => values.push(named),
            None => found.push((measure, rod.distance_mm, vec![named])),
        }
    }
    for (measure, distance_mm, values) in &found {
        let values: Vec<&Named> = values.iter().collect();
        add(rows, measure, format!("{} mm", short(*distance_mm)), &values);
    }
    Ok(())
}
