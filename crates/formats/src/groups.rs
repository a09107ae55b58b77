//! The column of a measurement table that states which rows belong together.

use super::error::FormatError;
use super::table::Table;
use std::io::{self, Write};

/// Columns that mean so by their name, the narrower grouping first.
pub const GROUP_COLUMNS: [&str; 3] = ["cluster", "frame", "pose"];

/// Column that states which sensor a row is of.
pub const SENSOR_COLUMN: &str = "sensor";

/// Rows with equal text in one column belong together.
#[derive(Clone, Debug, PartialEq)]
pub struct GroupColumn {
    pub name: String,
    /// One a row.
    pub labels: Vec<String>,
}

impl GroupColumn {
    /// The name, and the labels.
    pub fn named_labels(&self) -> (&str, &[String]) {
        (&self.name, &self.labels)
    }
}

/// Reads a column of this name, or else the first of [`GROUP_COLUMNS`] that is there.
///
/// # Errors
/// A named column that is missing, a column that is there twice, empty cells.
pub fn parse(bytes: &[u8], name: Option<&str>) -> Result<Option<GroupColumn>, FormatError> {
    column(bytes, name, &GROUP_COLUMNS)
}

/// Reads the column of sensors, where there is one.
///
/// # Errors
/// A column that is there twice, empty cells.
pub fn parse_sensors(bytes: &[u8]) -> Result<Option<GroupColumn>, FormatError> {
    column(bytes, None, &[SENSOR_COLUMN])
}

/// A named column, which has to be there, or else the first of those that are known to mean so.
fn column(
    bytes: &[u8],
    name: Option<&str>,
    known: &[&'static str],
) -> Result<Option<GroupColumn>, FormatError> {
    let table = Table::parse(bytes)?;
    let known = known.iter().copied().find(|known| table.header().has(known));
    let Some(name) = name.or(known) else {
        return Ok(None);
    };
    let index = table.header().place(name)?;
    let labels = table.read(|row| match row.cell(index) {
        "" => Err(FormatError::cell(row.line(), name, "empty", "the name of the row's group")),
        label => Ok(label.to_owned()),
    })?;
    Ok(Some(GroupColumn { name: name.to_owned(), labels }))
}

/// Writes a table of lines with columns of numbers added: a name and one number a row each.
pub fn write_beside(
    out: &mut dyn Write,
    table: &[u8],
    columns: &[(&str, &[usize])],
) -> io::Result<()> {
    for (i, line) in table.split(|&b| b == b'\n').enumerate() {
        if line.is_empty() {
            continue;
        }
        out.write_all(line)?;
        for (name, numbers) in columns {
            match i.checked_sub(1).map(|row| numbers.get(row)) {
                None => write!(out, ",{name}")?,
                Some(Some(number)) => write!(out, ",{number}")?,
                Some(None) => write!(out, ",")?,
            }
        }
        writeln!(out)?;
    }
    Ok(())
}

#[cfg(test)]
mod tests {
    use super::*;

    fn labels(table: &str, name: Option<&str>) -> Option<(String, Vec<String>)> {
        parse(table.as_bytes(), name).unwrap().map(|column| (column.name, column.labels))
    }

    #[test]
    fn cluster_columns_go_before_frame_columns() {
        let table = "frame, cluster ,x\n1,a,0\n1,b,0\n";
        let found = labels(table, None).unwrap();
        assert_eq!(found, ("cluster".into(), vec!["a".into(), "b".into()]));
        let found = labels(table, Some("frame")).unwrap();
        assert_eq!(found, ("frame".into(), vec!["1".into(), "1".into()]));
    }

    #[test]
    fn columns_written_beside_a_table_are_read_again() {
        let mut out = Vec::new();
        let columns: [(&str, &[usize]); 2] = [("frame", &[0, 0, 1]), ("cluster", &[7, 8, 7])];
        write_beside(&mut out, b"x,y\n1,2\n3,4\n5,6\n", &columns).unwrap();
        let table = String::from_utf8(out).unwrap();
        assert_eq!(table, "x,y,frame,cluster\n1,2,0,7\n3,4,0,8\n5,6,1,7\n");
        assert_eq!(labels(&table, None).unwrap().1, ["7", "8", "7"]);
    }

    #[test]
    fn a_table_without_such_a_column_has_no_groups() {
        assert_eq!(labels("x,y\n1,2\n", None), None);
    }

    #[test]
    fn the_sensor_column_is_read_where_there_is_one() {
        let found = parse_sensors(b"pose,sensor\n1,a\n1,b\n").unwrap().unwrap();
        assert_eq!(found.labels, ["a", "b"]);
        assert_eq!(parse_sensors(b"pose\n1\n").unwrap(), None);
        let empty = parse_sensors(b"sensor,x\n,1\n").unwrap_err().to_string();
        assert!(empty.contains("line 2: sensor is empty"), "{empty}");
    }

    #[test]
    fn columns_that_cannot_be_used_state_why() {
        let error = |table: &str, name| parse(table.as_bytes(), name).unwrap_err().to_string();
        let missing = error("x\n1\n", Some("sweep"));
        assert!(missing.contains("no column \"sweep\""), "{missing}");
        let twice = error("frame,frame\n1,2\n", None);
        assert!(twice.contains("twice the column \"frame\""), "{twice}");
        let empty = error("frame,x\n1,2\n ,3\n", None);
        assert!(empty.contains("line 3: frame is empty"), "{empty}");
    }
}
