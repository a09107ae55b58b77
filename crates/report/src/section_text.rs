//! Results as text for a terminal.

use super::text_table::lines;
use trackwright_formats::printable::printable;
use trackwright_result::{Column, Item, Row, Section, Table, value_text};

/// Rows aligned, tables in columns, an empty line before a section within
/// that is not below what is above. What a terminal would obey
/// is escaped in rows and tables.
///
/// ```
/// use trackwright_report::section_text::section_text;
/// use trackwright_result::{Section, count, mm};
/// let rms = mm("rms_mm", "RMS", 0.5).part().remarked("(95 %: 0.4 to 0.6)");
/// let found = Section::of([count("poses", "poses", 12), rms]);
/// let found = found.with(Section::of([mm("max_mm", "largest", 0.9)]).below(2));
/// let lines = ["poses     12", "  RMS  0.500 mm (95 %: 0.4 to 0.6)", "  largest  0.900 mm"];
/// assert_eq!(section_text(&found), lines.join("\n"));
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
                let lines = section_text(within);
                if !lines.is_empty() && !text.is_empty() && within.indent.is_none() {
                    text.push(String::new());
                }
                let indent = " ".repeat(within.indent.unwrap_or(0));
                text.extend(
                    lines.lines().map(|line| format!("{indent}{line}").trim_end().to_owned()),
                );
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
        .map(|([l, v], row)| {
            let after = match (row.unit, printable(&row.remark)) {
                ("", remark) => remark.into_owned(),
                (unit, remark) => format!("{unit} {remark}"),
            };
            format!("{l:<label$}  {v:>value$} {after}").trim_end().to_owned()
        })
        .collect()
}

/// Nothing of a table without rows, or without columns for people.
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
