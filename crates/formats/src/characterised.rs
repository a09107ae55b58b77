//! Measurement tables of a characterised room: as any, and which sensor, recording and pose a row is of.

use super::table::POSE;
use std::io::{self, Write};
use trackwright_calibration::characterisation::{Characterisation, CharacterisedReading};
use trackwright_geometry::number::shortest;
use trackwright_geometry::pose::pose_to_array;

/// Writes a row for each of some readings of a characterisation, its own or those that were held out:
/// `sensor` by name, `pair` and `pose` numbered from 0. Rows of one pose belong together: a still
/// pose, or a second of a path.
pub fn write(
    out: &mut dyn Write,
    found: &Characterisation,
    readings: &[CharacterisedReading],
) -> io::Result<()> {
    let mut table = csv::Writer::from_writer(out);
    let poses = ["ideal", "measured"]
        .iter()
        .flat_map(|whose| POSE.iter().map(move |name| format!("{whose}_{name}")));
    let names = ["sensor", "pair", "pose"].map(str::to_owned);
    table.write_record(poses.chain(names))?;
    for reading in readings {
        let m = &reading.measurement;
        let numbers = [&m.tracker_from_ideal, &m.tracker_from_measured]
            .into_iter()
            .flat_map(pose_to_array)
            .map(shortest);
        let sensor = found.sensors.get(reading.sensor).cloned();
        let rest = [sensor.unwrap_or_default(), reading.pair.to_string(), reading.pose.to_string()];
        table.write_record(numbers.chain(rest))?;
    }
    table.flush()
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::{groups, measurements};
    use nalgebra::{DMatrix, Vector3};
    use trackwright_calibration::hand_eye::{HandEye, Motion};
    use trackwright_calibration::long_run::EffectiveSize;
    use trackwright_calibration::still_pose::Spread;
    use trackwright_field::samples::Measurement;
    use trackwright_geometry::pose::pose_from_array;

    #[test]
    fn characterised_tables_read_back_with_groups() {
        let measurement = Measurement {
            tracker_from_ideal: pose_from_array([0.1, -2.0, 1.0 / 3.0, 0.8, 0.0, 0.6, 0.0])
                .unwrap(),
            tracker_from_measured: pose_from_array([1e-7, -2.0, 0.3, 0.6, 0.0, 0.8, 0.0]).unwrap(),
        };
        let reading = |pair, pose, sensor| CharacterisedReading {
            pair,
            pose,
            sensor,
            measurement,
            error: Spread::default(),
        };
        let found = Characterisation {
            sensors: vec!["Port 1: a, \"b\"".to_owned(), "c".to_owned()],
            hand_eye: HandEye {
                tracker_from_reference: measurement.tracker_from_ideal,
                body_from_sensor: Vec::new(),
                covariance: DMatrix::zeros(0, 0),
                poses: 0,
                effective_size: EffectiveSize { effective: 0.0, freedom: None },
                scales: Vec::new(),
                motion: Motion {
                    largest_rad: 0.0,
                    least_turn_rad: 0.0,
                    second_turn_rad: 0.0,
                    axis_in_body: Vector3::z(),
                    axis_in_reference: Vector3::z(),
                },
            },
            readings: vec![reading(0, 0, 0), reading(0, 0, 1), reading(3, 7, 0)],
            held_out: vec![reading(1, 2, 1)],
            pairs: Vec::new(),
            distances: Vec::new(),
            recordings: None,
        };
        let mut table = Vec::new();
        write(&mut table, &found, &found.readings).unwrap();
        let read = measurements::parse(&table).unwrap();
        assert_eq!(read.measurements, [measurement; 3]);
        let labels = |name| groups::parse(&table, name).unwrap().unwrap();
        assert_eq!(labels(None).name, "pose");
        assert_eq!(labels(None).labels, ["0", "0", "7"]);
        assert_eq!(labels(Some("pair")).labels, ["0", "0", "3"]);
        assert_eq!(labels(Some("sensor")).labels[0], "Port 1: a, \"b\"");
        let mut table = Vec::new();
        write(&mut table, &found, &found.held_out).unwrap();
        let pairs = groups::parse(&table, Some("pair")).unwrap().unwrap();
        assert_eq!(pairs.labels, ["1"]);
    }
}
