//! Results as text for a terminal.

use super::text_table::lines;
use trackwright_formats::printable::printable;
use trackwright_result::{Column, Item, Row, Section, Table, value_text};

/// Rows aligned, tables in columns, an empty line before a section within. What a terminal would obey
/// is escaped in rows and tables.
///
/// ```
/// use trackwright_report::section_text::section_text;
/// use trackwright_result::{Section, count, mm};
/// let found = Section::of([count("poses", "poses", 12), mm("rms_mm", "RMS", 0.5).part()]);
/// assert_eq!(section_text(&found), "poses     12\n  RMS  0.500 mm");
/// ```
pub fn section_text(section: &Section) -> String {
    let mut text: Vec<String> = Vec::new();
    let mut rows: Vec<&Row> = Vec::new();
    for item in &section.items {
        if let Item::Row(row) = item {
            rows.extend((!row.label.is_empty()).then_some(row));
            continue;
        }
        text.extend(aligned(&std::mem::take(&mut rows)));
        match item {
            Item::Row(_) => {}
            Item::Table(table) => text.extend(table_lines(table)),
            Item::Line(line) => text.push(line.clone()),
            Item::Section(within) => {
                let within = section_text(within);
                if !within.is_empty() && !text.is_empty() {
                    text.push(String::new());
                }
                text.extend((!within.is_empty()).then_some(within));
            }
        }
    }
    text.extend(aligned(&rows));
    text.join("\n")
}

/// Label, value and unit of each row, in one line whatever is in a name.
fn aligned(rows: &[&Row]) -> Vec<String> {
    let cells: Vec<[String; 2]> = rows
        .iter()
        .map(|row| {
            let indent = if row.is_part { "  " } else { "" };
            let label = format!("{indent}{}", row.label);
            [printable(&label).into_owned(), printable(&row.value_text()).into_owned()]
        })
        .collect();
    let width = |k: usize| cells.iter().map(|row| row[k].chars().count()).max().unwrap_or(0);
    let (label, value) = (width(0), width(1));
    cells
        .iter()
        .zip(rows)
        .map(|([l, v], row)| format!("{l:<label$}  {v:>value$} {}", row.unit).trim_end().to_owned())
        .collect()
}

/// Nothing of a table without rows, and of one that only programs read.
fn table_lines(table: &Table) -> Vec<String> {
    let shown: Vec<(usize, &Column)> =
        table.columns.iter().enumerate().filter(|(_, column)| !column.label.is_empty()).collect();
    if table.rows.is_empty() || shown.is_empty() {
        return Vec::new();
    }
    let mut cells: Vec<Vec<String>> =
        vec![shown.iter().map(|(_, column)| column.label.to_string()).collect()];
    cells.extend(table.rows.iter().map(|row| {
        shown.iter().map(|(k, column)| value_text(&row[*k], column.decimals)).collect()
    }));
    lines(&cells, |k| !shown[k].1.is_text)
}
