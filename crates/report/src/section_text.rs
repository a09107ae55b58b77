//! Results as text for a terminal.

use super::text_table::lines;
use trackwright_formats::printable::printable;
use trackwright_result::{Column, Item, Row, Section, Table, value_text};

/// Rows aligned, tables in columns; a section within has an empty line before it, or its heading, below
/// which it is indented. What a terminal would obey is escaped, but for sentences.
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
    let heading = (!section.heading.is_empty()).then(|| printable(&section.heading).into_owned());
    heading.into_iter().chain(lines_of(section)).collect::<Vec<_>>().join("\n")
}

/// All but the heading.
fn lines_of(section: &Section) -> Vec<String> {
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
            Item::Line(line) => text.extend(line.lines().map(str::to_owned)),
            Item::Section(within) => {
                let lines = lines_of(within);
                let is_headed = !within.heading.is_empty();
                if lines.is_empty() {
                    continue;
                }
                if is_headed {
                    text.push(printable(&within.heading).into_owned());
                } else if !text.is_empty() && within.indent.is_none() {
                    text.push(String::new());
                }
                let indent = " ".repeat(within.indent.unwrap_or(if is_headed { 2 } else { 0 }));
                text.extend(
                    lines.iter().map(|line| format!("{indent}{line}").trim_end().to_owned()),
                );
            }
        }
    }
    text.extend(aligned(&rows));
    text
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

/// Nothing of a table without rows or labels; no head of blank labels.
fn table_lines(table: &Table) -> Vec<String> {
    let shown: Vec<(usize, &Column)> =
        table.columns.iter().enumerate().filter(|(_, column)| !column.label.is_empty()).collect();
    if table.rows.is_empty() || shown.is_empty() {
        return Vec::new();
    }
    let head: Vec<String> = shown.iter().map(|(_, column)| column.label.to_string()).collect();
    let mut cells: Vec<Vec<String>> = Vec::new();
    cells.extend(head.iter().any(|label| !label.trim().is_empty()).then_some(head));
    cells.extend(table.rows.iter().map(|row| {
        shown.iter().map(|(k, column)| value_text(&row[*k], column.decimals)).collect()
    }));
    lines(&cells, |k| !shown[k].1.is_text)
}

#[cfg(test)]
mod tests {
    use super::*;
    use trackwright_result::{count, data, mm, text, vector};

    /// A result with all that there may be in one.
    fn found() -> Section {
        let table = Table::of("points", &[("a\u{202e}", 0.5), ("bc", 12.25)])
            .text("name", "point", |(name, _)| *name)
            .number("off_mm", "off, mm", 1, |(_, off_mm)| *off_mm)
            .data("chance", |_| 0.25)
            .done();
        let none = Table::of("none", &[0.0; 0]).number("mm", "mm", 1, |mm| *mm).done();
        Section::of([
            count("poses", "poses", 1200),
            mm("rms_mm", "RMS", 0.125).part(),
            vector("tip", "tip", [1.0, -2.0], 2, "mm"),
            vector::<2>("", "interval, ±", None, 2, "mm").part(),
            data("covariance", [[1.0]]),
        ])
        .with("a sentence".to_owned())
        .with(Section::of([data("of_programs", 1)]))
        .with(Section::default().with(table))
        .with(Section::default().with(none))
        .with(Section::of([text("model", "model", "order 2\n")]).named("fit"))
    }

    #[test]
    fn rows_are_aligned_and_sections_are_apart() {
        let expected = "\
poses               1,200
  RMS               0.125 mm
tip            1.00 -2.00 mm
  interval, ±           – mm
a sentence

point      off, mm
a\\u{202e}      0.5
bc            12.2

model  order 2\\u{a}";
        assert_eq!(section_text(&found()), expected);
    }

    #[test]
    fn programs_and_pages_are_given_the_same() {
        let found = found();
        let json = found.to_json();
        assert_eq!(json["points"][1]["off_mm"], 12.25);
        assert_eq!(json["fit"]["model"], "order 2\n");
        assert_eq!((&json["none"], &json["of_programs"]), (&[0; 0].into(), &1.into()));
        let page = crate::section_html::section_html(&found).into_string();
        for shown in ["<th>poses</th><td>1,200 ", "<td>12.2</td>", "<p>a sentence</p>", "RMS"] {
            assert!(page.contains(shown), "{shown}: {page}");
        }
        assert!(!page.contains("covariance") && !page.contains("of_programs"), "{page}");
    }

    #[test]
    fn rows_under_a_heading_are_indented() {
        let names = Table::of("", &["a", "b"]).text("", " ", |name| *name).done();
        let only_data = Table::of("each", &[1, 2]).data("value", |value| *value).done();
        let section = Section::of([data("hidden", 1)])
            .with(only_data)
            .with(Section::of([mm("rms_mm", "RMS", 0.5)]).headed("in\nroom:"))
            .with(Section::default().with(names).headed("names:"))
            .with(Section::default().headed("of nothing:"));
        let text = "in\\u{a}room:\n  RMS  0.500 mm\nnames:\n  a\n  b";
        assert_eq!(section_text(&section), text);
    }
}
