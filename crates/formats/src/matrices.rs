//! Poses as 4x4 or 3x4 matrices in text, row by row, one after the other; mm.

use super::error::{FormatError, quoted, text};
use super::table_dialect::{decimal, number_cells};
use nalgebra::{Matrix3, Matrix4, UnitQuaternion, Vector3};
use trackwright_geometry::pose::{Pose, pose_from_parts};
use trackwright_geometry::svd3::svd3;

/// How far a turn may be from one: files keep four digits at least, and what was typed by hand or
/// has a scale is off by more.
const MAX_OFF: f64 = 1e-3;

/// Reads matrices whose numbers are apart by spaces, commas or semicolons; lines that begin with `#`
/// and empty ones are skipped. Twelve numbers a line, or lines of four in threes of which none is
/// `0 0 0 1`, are matrices without their last row; sixteen whose last column is `0 0 0 1` are written
/// column by column.
///
/// # Errors
/// Cells that are no numbers, a number of them that is no multiple of 16 or 12, last rows that are
/// not `0 0 0 1`, parts that are no rotations, no matrix.
pub fn parse(bytes: &[u8]) -> Result<Vec<Pose>, FormatError> {
    let content = text(bytes)?;
    parse_sized(content, numbers_each(content))
}

/// Reads 4x4 matrices alone.
///
/// # Errors
/// As [`parse`].
pub fn parse_4x4(bytes: &[u8]) -> Result<Vec<Pose>, FormatError> {
    parse_sized(text(bytes)?, 16)
}

fn parse_sized(content: &str, size: usize) -> Result<Vec<Pose>, FormatError> {
    let mut poses = Vec::new();
    let mut cells = Vec::with_capacity(16);
    // Where the matrix begins that is being read.
    let mut first_line = 1;
    let mut last_line = 1;
    for (line, content) in (1..).zip(content.lines()) {
        last_line = line;
        if content.trim_start().starts_with('#') {
            continue;
        }
        for cell in number_cells(content) {
            if cells.is_empty() {
                first_line = line;
            }
            let value = decimal(cell);
            cells.push(value.ok_or_else(|| {
                FormatError::line(line, quoted(cell), "a number of a 4x4 matrix")
            })?);
            if cells.len() == size {
                if size == 12 {
                    cells.extend(LAST_ROW);
                }
                poses.push(pose(&cells).map_err(|found| {
                    let expected = "a rotation and a shift in mm above a row 0 0 0 1";
                    FormatError::line(first_line, found, expected)
                })?);
                cells.clear();
            }
        }
    }
    if !cells.is_empty() {
        let found = format!("the end of the file after {} numbers", cells.len());
        let expected = format!("{size} for the matrix that begins in line {first_line}");
        return Err(FormatError::line(last_line, found, expected));
    }
    if poses.is_empty() {
        return Err(FormatError::NoRows);
    }
    Ok(poses)
}

const LAST_ROW: [f64; 4] = [0.0, 0.0, 0.0, 1.0];

fn is_last_row(cells: &[f64]) -> bool {
    cells.len() == 4 && cells.iter().zip(LAST_ROW).all(|(a, b)| (a - b).abs() <= MAX_OFF)
}

/// How many numbers a matrix has: 12 where no line is a last row, and lines are whole matrices or
/// their rows.
fn numbers_each(content: &str) -> usize {
    let lines = content.lines().filter(|line| !line.trim_start().starts_with('#'));
    let mut counts = lines.map(|line| number_cells(line).count()).filter(|n| *n > 0);
    let Some(first) = counts.next() else {
        return 16;
    };
    let rows = 1 + counts.clone().count();
    let is_last_row = |line: &str| {
        let cells: Option<Vec<f64>> = number_cells(line).map(decimal).collect();
        cells.is_some_and(|cells| is_last_row(&cells))
    };
    match first {
        _ if counts.any(|count| count != first) => 16,
        12 => 12,
        4 if rows.is_multiple_of(3) && !content.lines().any(is_last_row) => 12,
        _ => 16,
    }
}

/// The pose of a matrix, or what it is instead.
fn pose(cells: &[f64]) -> Result<Pose, String> {
    let mut matrix = Matrix4::from_row_slice(cells);
    let [row, column] = [[12, 13, 14, 15], [3, 7, 11, 15]].map(|at| at.map(|k: usize| cells[k]));
    if is_last_row(&column) && !is_last_row(&row) {
        matrix.transpose_mut();
    }
    if cells.iter().any(|cell| !cell.is_finite()) {
        return Err("a matrix with a number that is not finite".to_owned());
    }
    let last = matrix.row(3) - Matrix4::<f64>::identity().row(3);
    if last.amax() > MAX_OFF {
        return Err(format!("a last row {} {} {} {}", cells[12], cells[13], cells[14], cells[15]));
    }
    let turn: Matrix3<f64> = matrix.fixed_view::<3, 3>(0, 0).into();
    let (rotation, off) = nearest_rotation(&turn);
    if off > MAX_OFF {
        return Err(format!("a 3x3 part that differs from a rotation by {off:.2e}"));
    }
    let shift = Vector3::new(matrix[(0, 3)], matrix[(1, 3)], matrix[(2, 3)]);
    Ok(pose_from_parts(shift, rotation))
}

/// The rotation that is nearest to a matrix, and how far its parts are off: digits that were cut off
/// are nobody's measurement.
pub(super) fn nearest_rotation(turn: &Matrix3<f64>) -> (UnitQuaternion<f64>, f64) {
    let rotation = svd3(&turn.transpose()).best_rotation();
    (rotation, (rotation.to_rotation_matrix().matrix() - turn).amax())
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::test_cases::assert_refused;
    use proptest::prelude::*;

    const QUARTER: &str = "0 -1 0 10\n1 0 0 20\n0 0 1 30\n0 0 0 1\n";

    #[test]
    fn matrices_are_read_with_any_separator() {
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
    fn rows_of_twelve_and_columns_are_read() {
        let expected = parse(QUARTER.as_bytes()).unwrap();
        let three = QUARTER.replace("0 0 0 1\n", "");
        let a_line = three.replace('\n', " ");
        let columns = "0 1 0 0\n-1 0 0 0\n0 0 1 0\n10 20 30 1\n";
        let decimal = "0,0;-1,0;0,0;10,0\n1,0;0;0;20,0\n0;0;1;30\n0;0;0;1\n";
        for text in [&three, &format!("{a_line}\n{a_line}\n"), columns, decimal] {
            let found = parse(text.as_bytes()).unwrap();
            assert_eq!(found[0], expected[0], "{text}");
        }
        assert_eq!(parse(three.repeat(3).as_bytes()).unwrap().len(), 3);
    }

    #[test]
    fn what_is_no_matrix_is_named_with_its_line() {
        let cases = r#"
            20 => x | line 2: found "x"…
            0 0 0 1 => 0 0 0 2 | line 1: found a last row 0 0 0 2…
            0 0 1 30 => 0 0 -1 30 | line 1: found a 3x3 part that differs from a rotation by 2…
            10 => nan | line 1: found a matrix with a number that is not finite…
            0 0 0 1 => 0 0 0 1\n1 0 0 | line 5: found the end of the file after 3 numbers…
            \n# nothing\n | found no rows…
        "#;
        assert_refused(QUARTER, cases, |text| parse(text.as_bytes()).unwrap_err().to_string());
    }

    proptest! {
        #[test]
        fn numbers_of_any_size_panic_nowhere(numbers in prop::array::uniform16(any::<f64>())) {
            let text: Vec<String> = numbers.iter().map(ToString::to_string).collect();
            let _ = parse(text.join(" ").as_bytes());
        }
    }
}
