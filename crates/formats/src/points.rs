//! Points: a table with columns `x, y, z`, plain rows of three numbers, markups of 3D Slicer, or a
//! `ct-fiducials` file of the JHU course, distinguished by what they begin with.

use super::error::{FormatError, quoted, text};
use super::jhu_cis;
use super::markups;
use super::table::Table;
use super::table_dialect::{decimal, first_cells, number_cells as cells};
use nalgebra::Point3;
use std::io::{self, Write};
use trackwright_geometry::number::shortest;

/// Reads points, mm, in whatever frame they are.
///
/// ```
/// use trackwright_formats::points::parse;
///
/// assert_eq!(parse(b"1 2 3\n4;5;6\n"), parse(b"x,y,z\n1,2,3\n4,5,6\n"));
/// ```
///
/// # Errors
/// Cells that are no numbers, rows that are no points, no rows.
pub fn parse(bytes: &[u8]) -> Result<Vec<Point3<f64>>, FormatError> {
    let content = text(bytes)?;
    if markups::is_json(content) {
        return markups::parse_json(bytes);
    }
    if markups::is_fcsv(content) {
        return markups::parse_fcsv(bytes);
    }
    let (.., are_numbers) = first_cells(content).ok_or(FormatError::NoRows)?;
    match are_numbers {
        [true, true] => rows(content),
        // A count, then the file's name.
        [true, false] => jhu_cis::parse_ct_fiducials(bytes),
        [false, _] => {
            let table = Table::parse(bytes)?;
            let expected = "the columns of points (x, y, z)";
            let columns = table.header().columns(&["x", "y", "z"], expected)?;
            table.read(|row| {
                let mut point = Point3::origin();
                for (value, column) in point.iter_mut().zip(&columns) {
                    *value = row.number(*column)?;
                }
                Ok(point)
            })
        }
    }
}

/// Writes points as a table.
pub fn write<'a>(
    out: &mut dyn Write,
    points: impl IntoIterator<Item = &'a Point3<f64>>,
) -> io::Result<()> {
    writeln!(out, "x,y,z")?;
    for point in points {
        let [x, y, z] = [point.x, point.y, point.z].map(shortest);
        writeln!(out, "{x},{y},{z}")?;
    }
    Ok(())
}

fn rows(content: &str) -> Result<Vec<Point3<f64>>, FormatError> {
    (1..)
        .zip(content.lines().map(str::trim))
        .filter(|(_, line)| !line.is_empty() && !line.starts_with('#'))
        .map(|(line, content)| {
            let values: Vec<f64> = cells(content)
                .map_while(|cell| decimal(cell).filter(|value| value.is_finite()))
                .collect();
            match (values.as_slice(), cells(content).count()) {
                ([x, y, z], 3) => Ok(Point3::new(*x, *y, *z)),
                _ => Err(FormatError::line(line, quoted(content), "x, y, z in mm")),
            }
        })
        .collect()
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::test_cases::assert_refused;

    #[test]
    fn the_first_line_states_how_points_are_written() {
        let expected = vec![Point3::new(1.0, -2.5, 3.0), Point3::new(4.0, 5.0, 6.0)];
        for text in [
            "# a\nname,x,y,z\na,1,-2.5,3\nb,4,5,6\n".trim_start_matches("# a\n"),
            "# a\n1 -2.5 3\n\n4;5;6\n",
            "2, pa2-ct-fiducials.txt\n 1.00, -2.50, 3.00\n 4, 5, 6\n",
        ] {
            assert_eq!(parse(text.as_bytes()), Ok(expected.clone()), "{text}");
        }
        let mut written = Vec::new();
        write(&mut written, &expected).unwrap();
        assert_eq!(parse(&written), Ok(expected));
    }

    #[test]
    fn what_is_no_point_is_named() {
        let cases = r#"
            \n | found no rows, expected at least one
            1 2 3\n4 5\n | line 2: found "4 5", expected x, y, z…
            1 2 3 4\n | line 1: found "1 2 3 4"…
            1 2 3\n4 5 NaN\n | line 2…
            x,y\n1,2\n | …found no column z…
            3, ct.txt\n1,2,3\n | …expected more points…
        "#;
        assert_refused("", cases, |text| parse(text.as_bytes()).unwrap_err().to_string());
    }
}
