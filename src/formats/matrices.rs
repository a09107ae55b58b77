//! Poses as 4x4 matrices in text, row by row, one after the other; mm.

use super::error::{FormatError, text};
use crate::geometry::pose::{Pose, pose_from_parts};
use crate::geometry::svd3::svd3;
use nalgebra::{Matrix3, Matrix4, Vector3};

/// How far a turn may be from one: files keep four digits at least, and what was typed by hand or
/// has a scale is off by more.
const MAX_OFF: f64 = 1e-3;

/// Reads matrices whose numbers are apart by spaces, commas or semicolons; lines that begin with `#`
/// and empty ones are skipped.
///
/// # Errors
/// Cells that are no numbers, a number of them that is no multiple of 16, last rows that are not
/// `0 0 0 1`, parts that are no rotations, no matrix.
pub fn parse(bytes: &[u8]) -> Result<Vec<Pose>, FormatError> {
    let mut poses = Vec::new();
    let mut cells = Vec::with_capacity(16);
    // Where the matrix begins that is being read.
    let mut first_line = 1;
    let mut last_line = 1;
    for (line, content) in (1..).zip(text(bytes)?.lines()) {
        last_line = line;
        if content.trim_start().starts_with('#') {
            continue;
        }
        let is_between = |c: char| c.is_whitespace() || c == ',' || c == ';';
        for cell in content.split(is_between).filter(|cell| !cell.is_empty()) {
            if cells.is_empty() {
                first_line = line;
            }
            let value: f64 = cell.parse().map_err(|_| FormatError::Line {
                line,
                found: format!("{:?}", cell.chars().take(60).collect::<String>()),
                expected: "a number of a 4x4 matrix".to_owned(),
            })?;
            cells.push(value);
            if cells.len() == 16 {
                poses.push(pose(&cells).map_err(|found| FormatError::Line {
                    line: first_line,
                    found,
                    expected: "a rotation and a shift in mm above a row 0 0 0 1".to_owned(),
                })?);
                cells.clear();
            }
        }
    }
    if !cells.is_empty() {
        return Err(FormatError::Line {
            line: last_line,
            found: format!("the end of the file after {} numbers", cells.len()),
            expected: format!("16 for the matrix that begins in line {first_line}"),
        });
    }
    if poses.is_empty() {
        return Err(FormatError::NoRows);
    }
    Ok(poses)
}

/// The pose of a matrix, or what it is instead.
fn pose(cells: &[f64]) -> Result<Pose, String> {
    let matrix = Matrix4::from_row_slice(cells);
    if cells.iter().any(|cell| !cell.is_finite()) {
        return Err("a matrix with a number that is not finite".to_owned());
    }
    let last = matrix.row(3) - Matrix4::<f64>::identity().row(3);
    if last.amax() > MAX_OFF {
        return Err(format!(
            "a last row {} {} {} {}",
            cells[12], cells[13], cells[14], cells[15]
        ));
    }
    let turn: Matrix3<f64> = matrix.fixed_view::<3, 3>(0, 0).into();
    // The nearest rotation: digits that were cut off are nobody's measurement.
    let rotation = svd3(&turn.transpose()).best_rotation();
    let off = (rotation.to_rotation_matrix().matrix() - turn).amax();
    if off > MAX_OFF {
        return Err(format!(
            "a 3x3 part that differs from a rotation by {off:.2e}"
        ));
    }
    let shift = Vector3::new(matrix[(0, 3)], matrix[(1, 3)], matrix[(2, 3)]);
    Ok(pose_from_parts(shift, rotation))
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    const QUARTER: &str = "0 -1 0 10\n1 0 0 20\n0 0 1 30\n0 0 0 1\n";

    #[test]
    fn matrices_are_read_row_by_row_whatever_is_between_their_numbers() {
        let commas = QUARTER.replace(' ', ", ");
        let one_line = QUARTER.replace('\n', "; ");
        let text = format!("# a comment\n\n{QUARTER}\n{commas}{one_line}\n");
        let poses = parse(text.as_bytes()).unwrap();
        assert_eq!(poses.len(), 3);
        for pose in poses {
            let moved = pose * nalgebra::Point3::new(1.0, 0.0, 0.0);
            assert!((moved.coords - Vector3::new(10.0, 21.0, 30.0)).norm() < 1e-12);
        }
    }

    #[test]
    fn what_is_no_matrix_is_named_with_its_line() {
        for (text, expected) in [
            (QUARTER.replace("20", "x"), "line 2: found \"x\""),
            (
                format!("{QUARTER}1 0 0"),
                "line 5: found the end of the file after 3 numbers",
            ),
            (
                QUARTER.replace("0 0 0 1", "0 0 0 2"),
                "line 1: found a last row 0 0 0 2",
            ),
            (
                QUARTER.replace("0 0 1 30", "0 0 -1 30"),
                "line 1: found a 3x3 part that differs from a rotation by 2",
            ),
            (
                QUARTER.replace("10", "nan"),
                "line 1: found a matrix with a number that is not finite",
            ),
            ("\n# nothing\n".to_owned(), "found no rows"),
        ] {
            let error = parse(text.as_bytes()).unwrap_err().to_string();
            assert!(error.starts_with(expected), "{error}");
        }
    }

    proptest! {
        #[test]
        fn no_bytes_panic(bytes in prop::collection::vec(any::<u8>(), 0..300)) {
            let _ = parse(&bytes);
        }

        #[test]
        fn numbers_of_any_size_panic_nowhere(numbers in prop::array::uniform16(any::<f64>())) {
            let text: Vec<String> = numbers.iter().map(ToString::to_string).collect();
            let _ = parse(text.join(" ").as_bytes());
        }
    }
}
