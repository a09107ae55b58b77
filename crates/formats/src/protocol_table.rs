//! The table of an assessment protocol, one row a measure under a condition.

use super::error::{FormatError, quoted};
use super::table::Table;
use std::io::{self, Write};
use trackwright_calibration::protocol::table::{Measure, ProtocolRow, ProtocolTable, Statistics};
use trackwright_geometry::number::shortest;

const COLUMNS: [&str; 14] = [
    "source",
    "date",
    "measure",
    "condition",
    "unit",
    "count",
    "mean",
    "std",
    "rms",
    "min",
    "max",
    "worst",
    "paper_aurora",
    "paper_microbird",
];

/// What is read back: the paper's columns are for people.
const READ: [&str; 12] = {
    let [a, b, c, d, e, f, g, h, i, j, k, l, ..] = COLUMNS;
    [a, b, c, d, e, f, g, h, i, j, k, l]
};

const EXPECTED: &str = "the columns of a protocol table, which `protocol hummel` writes";

/// Writes the table. Lengths are in mm and angles in degrees.
pub fn write(out: &mut dyn Write, table: &ProtocolTable) -> io::Result<()> {
    let mut csv = csv::Writer::from_writer(out);
    csv.write_record(COLUMNS)?;
    for row in &table.rows {
        let Statistics { count, mean, std, rms, min, max } = row.statistics;
        let [aurora, microbird] = row.paper().unwrap_or_default();
        let mut cells = vec![
            table.source.clone(),
            table.date.clone().unwrap_or_default(),
            row.measure.key(),
            row.condition.clone(),
            row.measure.unit().to_owned(),
            count.to_string(),
        ];
        cells.extend([mean, std, rms, min, max].map(shortest));
        cells.extend([&*row.worst, aurora, microbird].map(str::to_owned));
        csv.write_record(cells)?;
    }
    csv.flush()
}

/// Reads the table.
///
/// # Errors
/// A table of another kind, cells that are no numbers, a measure that is none.
pub fn parse(bytes: &[u8]) -> Result<ProtocolTable, FormatError> {
    let table = Table::parse(bytes)?;
    let columns = table.header().columns(&READ, EXPECTED)?;
    let rows = table.read(|row| {
        let text = |k: usize| row.cell(columns[k]);
        let number = |k: usize| row.number(columns[k]);
        let measure = Measure::of_key(text(2)).ok_or_else(|| {
            let expected = "jitter, rotation, distance_ and a length, or rod_ and a material";
            FormatError::cell(row.line(), "measure", quoted(text(2)), expected)
        })?;
        let count = number(5)?;
        if count.fract() != 0.0 || !(1.0..1e9).contains(&count) {
            let found = shortest(count);
            return Err(FormatError::cell(row.line(), "count", found, "a whole number from 1"));
        }
        let statistics = Statistics {
            count: count as usize,
            mean: number(6)?,
            std: number(7)?,
            rms: number(8)?,
            min: number(9)?,
            max: number(10)?,
        };
        let condition = text(3).to_owned();
        let row = ProtocolRow { measure, condition, statistics, worst: text(11).to_owned() };
        Ok((text(0).to_owned(), Some(text(1).to_owned()).filter(|date| !date.is_empty()), row))
    })?;
    let first = rows.first().map(|(source, date, _)| (source.clone(), date.clone()));
    let (source, date) = first.unwrap_or_default();
    Ok(ProtocolTable { source, date, rows: rows.into_iter().map(|(.., row)| row).collect() })
}

#[cfg(test)]
pub(super) mod tests {
    use super::*;
    use crate::test_cases::assert_refused;
    use trackwright_calibration::protocol::table::ALL;

    fn table() -> ProtocolTable {
        let row = |measure: Measure, condition: &str, values: &[f64]| ProtocolRow {
            measure,
            condition: condition.to_owned(),
            statistics: Statistics::of(values.iter().copied()).unwrap(),
            worst: "level 0, row 1, column 2 to 1, 3".to_owned(),
        };
        ProtocolTable {
            source: "Theatre 2, \"old\"".to_owned(),
            date: Some("2026-05-31".to_owned()),
            rows: vec![
                row(Measure::Jitter, ALL, &[0.1, 0.12]),
                row(Measure::Distance(50), ALL, &[0.9, -0.3]),
                row(Measure::Rotation, "level 1", &[0.25]),
                row(Measure::Rod("steel-416".to_owned()), "20 mm", &[4.2, 3.0]),
            ],
        }
    }

    /// A good file.
    pub(crate) fn good() -> String {
        let mut written = Vec::new();
        write(&mut written, &table()).unwrap();
        String::from_utf8(written).unwrap()
    }

    #[test]
    fn a_table_is_read_back() {
        let mut written = Vec::new();
        write(&mut written, &table()).unwrap();
        assert_eq!(parse(&written).unwrap(), table());
        let text = String::from_utf8(written).unwrap();
        assert!(text.contains("0.96 ± 0.68"), "{text}");
    }

    #[test]
    fn other_tables_are_refused() {
        let mut good = Vec::new();
        write(&mut good, &table()).unwrap();
        let good = String::from_utf8(good).unwrap();
        let cases = r#"
            x,y,z,qw,qx,qy,qz\n1,2,3,1,0,0,0\n | line 1: found no column source, date, measure…
            ,rms, => ,root,
                | line 1: found no column rms, expected the columns of a protocol…
            jitter => noise | line 2: measure is "noise", expected jitter…
            jitter,all,mm,2, => jitter,all,mm,2.5, | line 2: count is 2.5…
            mm,2,0.11, => mm,2,NaN, | line 2: mean is "NaN", expected a finite…
        "#;
        assert_refused(&good, cases, |text| parse(text.as_bytes()).unwrap_err().to_string());
    }
}
