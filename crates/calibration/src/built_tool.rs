//! A built tool's poses, true and measured, from a measurement table: of the tool as a whole, where
//! the tracker reports its pose, or of its sensors one by one, fitted together as its design has
//! them.

use nalgebra::Point3;
use std::collections::{BTreeMap, HashMap, HashSet};
use trackwright_field::samples::Measurement;
use trackwright_geometry::pose::Pose;
use trackwright_simulation::frame_fit::{FrameFitter, Reading};
use trackwright_simulation::linear_fit::LinearFit;
use trackwright_simulation::{RigidBody, Sensor};

/// A measurement table with what it states about its rows.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct RecordedTable {
    pub rows: Vec<Measurement>,
    /// The sensor of each row, where the table has that column.
    pub sensors: Option<Vec<String>>,
    /// Which rows belong together, where the table has such a column.
    pub groups: Option<Vec<String>>,
}

/// A body at one moment.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct BodyMoment {
    /// `tracker_from_body`, true and measured.
    pub pose: Measurement,
    /// Moments of one still pose, or of one second, share it.
    pub group: usize,
    /// Place among the moments of its group.
    pub place: usize,
}

/// A body's recording.
#[derive(Clone, Debug, PartialEq)]
pub struct RecordedBody {
    pub moments: Vec<BodyMoment>,
    pub source: BodySource,
    /// Rows that were not used: of sensors that the body does not have, and of groups in which not
    /// every sensor was read as often.
    pub rows_left_out: usize,
    /// What the table calls each group, by its number; empty where it names none.
    pub group_names: Vec<String>,
}

/// How the body's pose is known.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum BodySource {
    /// The tracker reported it.
    Whole,
    /// The readings of so many sensors were fitted.
    Sensors {
        count: usize,
        /// RMS distance of the sensors' true positions from those of the design.
        misfit_rms_mm: f64,
    },
}

#[derive(Clone, Debug, PartialEq, thiserror::Error)]
pub enum BuiltToolError {
    #[error("{column} names {found} rows, expected {expected}, one a row")]
    Length { column: &'static str, found: usize, expected: usize },
    #[error("found no sensor {wanted:?} in column sensor, expected one of {}", .names.join("; "))]
    NoSuchSensor { wanted: String, names: Vec<String> },
    #[error("found several sensors with {wanted:?} in their names ({}), expected one", .names.join("; "))]
    SeveralSensors { wanted: String, names: Vec<String> },
    #[error(
        "found {} in column sensor, expected the tool alone, or a row for each of the sensors of {body} ({}): name the \
         sensors of the design as the recording does, or state which is the whole tool", .names.join("; "), .wanted.join("; ")
    )]
    Unmatched { body: String, names: Vec<String>, wanted: Vec<String> },
    #[error("the sensors of {body} leave its rotation free, so that their readings give no pose")]
    FreeRotation { body: String },
    #[error(
        "in none of {groups} groups of rows was every sensor of {body} read equally often, expected a row for each \
         sensor at each moment, and a column pose, frame or cluster that states which rows are of one moment"
    )]
    NoMoments { body: String, groups: usize },
}

/// The poses of a body; `whole` is a part of the name of what the tracker takes for the whole body.
///
/// Rows are of its sensors where the column `sensor` names these: by their names in the design, or
/// with these as a part. A table that names nothing, or one thing that is no sensor, is of the whole
/// body.
pub fn recorded_body(
    table: &RecordedTable,
    body: &RigidBody,
    orientation_weight_mm: f64,
    whole: Option<&str>,
) -> Result<RecordedBody, BuiltToolError> {
    let columns = [("sensor", &table.sensors), ("pose", &table.groups)];
    for (column, labels) in columns {
        if let Some(found) = labels.as_ref().map(Vec::len).filter(|n| *n != table.rows.len()) {
            return Err(BuiltToolError::Length { column, found, expected: table.rows.len() });
        }
    }
    let (groups, group_names) = group_numbers(table);
    let found = body_of(table, &groups, body, orientation_weight_mm, whole)?;
    Ok(RecordedBody { group_names, ..found })
}

fn body_of(
    table: &RecordedTable,
    groups: &[usize],
    body: &RigidBody,
    orientation_weight_mm: f64,
    whole: Option<&str>,
) -> Result<RecordedBody, BuiltToolError> {
    let names = distinct(table.sensors.as_deref().unwrap_or_default());
    if let Some(wanted) = whole {
        let name = one_named(&names, wanted)?;
        return Ok(whole_body(table, groups, Some(name)));
    }
    let matched: Option<Vec<&str>> =
        body.sensors.iter().map(|sensor| one_named(&names, &sensor.name).ok()).collect();
    match matched {
        Some(matched) if !matched.is_empty() => {
            let is_twice = distinct(&matched).len() < matched.len();
            if is_twice {
                return Err(unmatched(body, &names));
            }
            of_sensors(table, groups, body, orientation_weight_mm, &matched)
        }
        _ if names.len() <= 1 => Ok(whole_body(table, groups, None)),
        _ => Err(unmatched(body, &names)),
    }
}

fn unmatched(body: &RigidBody, names: &[&str]) -> BuiltToolError {
    BuiltToolError::Unmatched {
        body: body.name.clone(),
        names: owned(names),
        wanted: body.sensors.iter().map(|s| s.name.clone()).collect(),
    }
}

fn owned(names: &[&str]) -> Vec<String> {
    names.iter().map(|name| (*name).to_owned()).collect()
}

/// In the order of their first appearance.
fn distinct<T: AsRef<str>>(labels: &[T]) -> Vec<&str> {
    let mut seen = HashSet::new();
    let all = labels.iter().map(AsRef::as_ref);
    all.filter(|label| seen.insert(*label)).collect()
}

/// The name that is this one, else the only one with it as a part.
fn one_named<'a>(names: &[&'a str], wanted: &str) -> Result<&'a str, BuiltToolError> {
    if let Some(same) = names.iter().find(|name| **name == wanted) {
        return Ok(same);
    }
    let found: Vec<&str> = names.iter().copied().filter(|n| n.contains(wanted)).collect();
    match found.as_slice() {
        [name] => Ok(name),
        [] => Err(BuiltToolError::NoSuchSensor { wanted: wanted.to_owned(), names: owned(names) }),
        several => {
            Err(BuiltToolError::SeveralSensors { wanted: wanted.to_owned(), names: owned(several) })
        }
    }
}

/// The group of each row in the order of appearance, and their names; rows without any are alone.
fn group_numbers(table: &RecordedTable) -> (Vec<usize>, Vec<String>) {
    let Some(labels) = &table.groups else {
        return ((0..table.rows.len()).collect(), Vec::new());
    };
    let names = distinct(labels);
    let numbers: HashMap<&str, usize> = names.iter().enumerate().map(|(k, n)| (*n, k)).collect();
    let of_rows = labels.iter().map(|label| numbers[label.as_str()]);
    (of_rows.collect(), owned(&names))
}

fn whole_body(table: &RecordedTable, groups: &[usize], name: Option<&str>) -> RecordedBody {
    let is_it = |row: usize| match (name, &table.sensors) {
        (Some(name), Some(sensors)) => sensors[row] == name,
        _ => true,
    };
    let mut places = BTreeMap::<usize, usize>::new();
    let moments: Vec<BodyMoment> = (0..table.rows.len())
        .filter(|row| is_it(*row))
        .map(|row| {
            let place = places.entry(groups[row]).or_default();
            *place += 1;
            BodyMoment { pose: table.rows[row], group: groups[row], place: *place - 1 }
        })
        .collect();
    RecordedBody {
        rows_left_out: table.rows.len() - moments.len(),
        moments,
        source: BodySource::Whole,
        group_names: Vec::new(),
    }
}

/// The k-th reading of each sensor in a group is of one moment; `names` are the sensors', in the
/// order of the body's.
fn of_sensors(
    table: &RecordedTable,
    groups: &[usize],
    body: &RigidBody,
    orientation_weight_mm: f64,
    names: &[&str],
) -> Result<RecordedBody, BuiltToolError> {
    if LinearFit::new(body, orientation_weight_mm).free_motion().is_some() {
        return Err(BuiltToolError::FreeRotation { body: body.name.clone() });
    }
    let fitter = FrameFitter::new(body, orientation_weight_mm);
    let sensors = table.sensors.as_deref().unwrap_or_default();
    // Without groups, the k-th reading of each sensor in the whole table.
    let group_of = |row: usize| table.groups.as_ref().map_or(0, |_| groups[row]);
    let mut by_group = BTreeMap::<usize, Vec<Vec<usize>>>::new();
    for (row, sensor) in sensors.iter().enumerate() {
        let lists = by_group.entry(group_of(row)).or_insert_with(|| vec![Vec::new(); names.len()]);
        if let Some(k) = names.iter().position(|name| name == sensor) {
            lists[k].push(row);
        }
    }
    let mut moments = Vec::new();
    let (mut used, mut squares_mm2) = (0, 0.0);
    for (&group, lists) in &by_group {
        let count = lists.first().map_or(0, Vec::len);
        if lists.iter().any(|list| list.len() != count) {
            continue;
        }
        for place in 0..count {
            let rows: Vec<&Measurement> =
                lists.iter().map(|list| &table.rows[list[place]]).collect();
            let fitted = |of: fn(&Measurement) -> &Pose| {
                let readings: Vec<Reading> = rows.iter().map(|m| reading(of(m))).collect();
                fitter.fit(&readings, &Pose::identity())
            };
            let truth = fitted(|m| &m.tracker_from_ideal);
            let measured = fitted(|m| &m.tracker_from_measured);
            squares_mm2 += misfit_mm2(&body.sensors, &rows, &truth.tracker_from_body);
            used += rows.len();
            moments.push(BodyMoment {
                pose: Measurement {
                    tracker_from_ideal: truth.tracker_from_body,
                    tracker_from_measured: measured.tracker_from_body,
                },
                group: if table.groups.is_some() { group } else { place },
                place: if table.groups.is_some() { place } else { 0 },
            });
        }
    }
    if moments.is_empty() {
        return Err(BuiltToolError::NoMoments { body: body.name.clone(), groups: by_group.len() });
    }
    Ok(RecordedBody {
        moments,
        source: BodySource::Sensors {
            count: names.len(),
            misfit_rms_mm: (squares_mm2 / used.max(1) as f64).sqrt(),
        },
        rows_left_out: table.rows.len() - used,
        group_names: Vec::new(),
    })
}

fn reading(tracker_from_sensor: &Pose) -> Reading {
    Reading {
        position_mm: tracker_from_sensor.translation.vector.into(),
        rotation: tracker_from_sensor.rotation,
    }
}

fn misfit_mm2(sensors: &[Sensor], rows: &[&Measurement], tracker_from_body: &Pose) -> f64 {
    let each = sensors.iter().zip(rows);
    each.map(|(sensor, row)| {
        let truth = Point3::from(row.tracker_from_ideal.translation.vector);
        (tracker_from_body * sensor.position_in_body - truth).norm_squared()
    })
    .sum()
}

/// Two bodies at the same moments: pairs of the first's and the second's, in the first's order. By
/// what both tables call their groups, else by the order of these.
pub fn same_moments(first: &RecordedBody, second: &RecordedBody) -> Vec<(BodyMoment, BodyMoment)> {
    let has_names = !first.group_names.is_empty() && !second.group_names.is_empty();
    let key = |body: &RecordedBody, moment: &BodyMoment| {
        let name = body.group_names.get(moment.group).filter(|_| has_names);
        let group = name.cloned().unwrap_or_else(|| moment.group.to_string());
        (group, moment.place)
    };
    let others: HashMap<_, _> = second.moments.iter().map(|m| (key(second, m), m)).collect();
    let all = first.moments.iter();
    all.filter_map(|m| others.get(&key(first, m)).map(|other| (*m, **other))).collect()
}

#[cfg(test)]
mod tests {
    use super::*;
    use nalgebra::{UnitQuaternion, Vector3};
    use trackwright_field::random_models::Seeded;
    use trackwright_geometry::pose::pose_from_parts;
    use trackwright_geometry::rotation::rotation_angle_rad;

    fn body() -> RigidBody {
        let sensor = |name: &str, at: [f64; 3], axis: Vector3<f64>| {
            Sensor::five_dof(name, at, nalgebra::Unit::new_normalize(axis))
        };
        RigidBody {
            name: "pointer".to_owned(),
            tip_in_body: None,
            sensors: vec![
                sensor("Port 1", [0.0, 0.0, 60.0], Vector3::z()),
                sensor("Port 10", [8.0, 0.0, 95.0], Vector3::x()),
            ],
        }
    }

    /// Rows of both sensors at poses of the body, true and measured.
    fn table(poses: &[(Pose, Pose)]) -> RecordedTable {
        let body = body();
        let mut table = RecordedTable {
            sensors: Some(Vec::new()),
            groups: Some(Vec::new()),
            ..RecordedTable::default()
        };
        for (k, (ideal, measured)) in poses.iter().enumerate() {
            for sensor in &body.sensors {
                // A roll of the table's own, which has no meaning.
                let roll = UnitQuaternion::from_axis_angle(&Vector3::z_axis(), k as f64);
                let own = sensor.body_from_sensor() * pose_from_parts(Vector3::zeros(), roll);
                table.rows.push(Measurement {
                    tracker_from_ideal: ideal * own,
                    tracker_from_measured: measured * own,
                });
                let name = format!("{}: 610029", sensor.name);
                table.sensors.as_mut().unwrap().push(name);
                table.groups.as_mut().unwrap().push(format!("p{k}"));
            }
        }
        table
    }

    fn poses() -> Vec<(Pose, Pose)> {
        let mut noise = Seeded::new(7);
        (0..6).map(|_| (noise.pose_within(200.0), noise.pose_within(200.0))).collect()
    }

    #[test]
    fn readings_of_all_sensors_give_the_body_pose() {
        let mut table = table(&poses());
        for name in table.sensors.as_mut().unwrap() {
            *name = name.replace(": 610029", "");
        }
        let found = recorded_body(&table, &body(), 100.0, None).unwrap();
        assert_eq!((found.moments.len(), found.rows_left_out), (6, 0));
        for (moment, (ideal, measured)) in found.moments.iter().zip(poses()) {
            for (a, b) in [
                (moment.pose.tracker_from_ideal, ideal),
                (moment.pose.tracker_from_measured, measured),
            ] {
                assert!((a.translation.vector - b.translation.vector).norm() < 1e-10);
                assert!(rotation_angle_rad(&a.rotation.rotation_to(&b.rotation)) < 1e-12);
            }
        }
        let BodySource::Sensors { count, misfit_rms_mm } = found.source else {
            panic!("{:?}", found.source);
        };
        assert!(count == 2 && misfit_rms_mm < 1e-10);
    }

    #[test]
    fn a_name_that_is_part_of_two_is_reported_not_guessed() {
        // "Port 1" is a part of "Port 10: …" too.
        let refused = recorded_body(&table(&poses()), &body(), 100.0, None).unwrap_err();
        assert!(matches!(refused, BuiltToolError::Unmatched { .. }), "{refused}");
        let refused = recorded_body(&table(&poses()), &body(), 100.0, Some("Port 1")).unwrap_err();
        assert!(refused.to_string().contains("several"), "{refused}");
    }

    #[test]
    fn groups_without_a_sensor_are_left_out() {
        let mut table = table(&poses());
        for name in table.sensors.as_mut().unwrap() {
            *name = name.replace(": 610029", "");
        }
        table.rows.remove(3);
        table.sensors.as_mut().unwrap().remove(3);
        table.groups.as_mut().unwrap().remove(3);
        let found = recorded_body(&table, &body(), 100.0, None).unwrap();
        assert_eq!((found.moments.len(), found.rows_left_out), (5, 1));
    }

    #[test]
    fn a_table_without_sensors_is_of_the_whole_tool() {
        let rows: Vec<Measurement> = poses()
            .iter()
            .map(|(ideal, measured)| Measurement {
                tracker_from_ideal: *ideal,
                tracker_from_measured: *measured,
            })
            .collect();
        let mut table = RecordedTable { rows, ..RecordedTable::default() };
        let plain = recorded_body(&table, &body(), 100.0, None).unwrap();
        table.sensors = Some(vec!["my pointer".to_owned(); 6]);
        let named = recorded_body(&table, &body(), 100.0, None).unwrap();
        assert_eq!(plain, named);
        assert_eq!(plain.source, BodySource::Whole);
        let both = same_moments(&plain, &named);
        assert_eq!(both.len(), 6);
        assert!(both.iter().all(|(a, b)| a == b));
    }

    #[test]
    fn two_bodies_are_matched_by_their_groups() {
        let rows = |order: &[usize]| RecordedTable {
            rows: order
                .iter()
                .map(|&k| Measurement {
                    tracker_from_ideal: poses()[k].0,
                    tracker_from_measured: poses()[k].1,
                })
                .collect(),
            sensors: None,
            groups: Some(order.iter().map(|k| format!("p{k}")).collect()),
        };
        let [tool, crf] = [&[0, 1, 2, 3, 4][..], &[4, 2, 0, 5]]
            .map(|order| recorded_body(&rows(order), &body(), 100.0, None).unwrap());
        let both = same_moments(&tool, &crf);
        assert_eq!(both.len(), 3);
        assert!(both.iter().all(|(a, b)| a.pose == b.pose));
    }
}
