//! What `verify` reads of a built tool: a measurement table with full rotations, and its columns
//! `sensor` and `pose` (or `frame`, `cluster`) where it has them.

use super::error::FormatError;
use super::{groups, measurements};
use trackwright_calibration::built_tool::RecordedTable;
use trackwright_field::samples::MeasurementContent;

/// Reads the table.
///
/// # Errors
/// Those of a measurement table; one without quaternions; cells of `sensor` or `pose` that are
/// empty.
pub fn parse(bytes: &[u8]) -> Result<RecordedTable, FormatError> {
    let set = measurements::parse(bytes)?;
    if set.content == MeasurementContent::PositionOnly {
        return Err(FormatError::MissingColumns {
            missing: ["ideal_qw", "measured_qw"].map(str::to_owned).into(),
            expected: "a table with quaternions: how the tool was turned",
        });
    }
    let sensors = groups::parse_sensors(bytes)?;
    Ok(RecordedTable {
        rows: set.measurements,
        sensors: sensors.map(|column| column.labels),
        groups: groups::parse(bytes, None)?.map(|column| column.labels),
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    const HEAD: &str = "ideal_x,ideal_y,ideal_z,ideal_qw,ideal_qx,ideal_qy,ideal_qz,measured_x,measured_y,\
        measured_z,measured_qw,measured_qx,measured_qy,measured_qz";
    const ROW: &str = "1,2,3,1,0,0,0,1.5,2,3,1,0,0,0";

    #[test]
    fn sensor_and_pose_columns_are_read() {
        let plain = parse(format!("{HEAD}\n{ROW}\n").as_bytes()).unwrap();
        assert_eq!((plain.rows.len(), plain.sensors, plain.groups), (1, None, None));
        let named = format!("{HEAD},sensor,pose\n{ROW},\"a, b\",7\n{ROW},c,7\n");
        let named = parse(named.as_bytes()).unwrap();
        assert_eq!(named.sensors.unwrap(), ["a, b", "c"]);
        assert_eq!(named.groups.unwrap(), ["7", "7"]);
    }

    #[test]
    fn tables_of_positions_alone_are_refused() {
        let table = "ideal_x,ideal_y,ideal_z,measured_x,measured_y,measured_z\n1,2,3,1,2,3\n";
        let problem = parse(table.as_bytes()).unwrap_err().to_string();
        assert!(problem.contains("ideal_qw"), "{problem}");
    }

    #[test]
    fn a_cut_table_is_shorter_or_an_error() {
        let whole = format!("{HEAD},sensor,pose\n{ROW},a,1\n{ROW},b,1\n");
        for end in 0..whole.len() {
            if let Ok(table) = parse(&whole.as_bytes()[..end]) {
                assert!(table.rows.len() <= 2);
            }
        }
    }
}
