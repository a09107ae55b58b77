//! Results as HTML: for a page, and for a notebook.

use maud::{Markup, html};
use trackwright_result::{Item, Remedy, Row, Section, Table, value_text};

/// A table of the figures, and one for each table within; names are escaped.
///
/// ```
/// use trackwright_report::section_html::section_html;
/// use trackwright_result::{Section, mm};
/// let found = Section::of([mm("rms_mm", "RMS <of all>", 0.5)]);
/// assert!(section_html(&found).into_string().contains("RMS &lt;of all&gt;</th><td>0.500 mm"));
/// ```
pub fn section_html(section: &Section) -> Markup {
    let rows: Vec<&Row> = section
        .items
        .iter()
        .filter_map(|item| match item {
            Item::Row(row) if !row.label.is_empty() => Some(row),
            _ => None,
        })
        .collect();
    html! {
        @if !rows.is_empty() {
            table { @for row in rows { (row_html(row)) } }
        }
        @for item in &section.items {
            @match item {
                Item::Row(_) => {}
                Item::Table(table) => { (table_html(table)) }
                Item::Line(line) => { p { (line) } }
                Item::Section(within) => { (section_html(within)) }
            }
        }
        @for note in &section.notes { p { (note.sentence(Remedy::as_keyword)) } }
    }
}

fn row_html(row: &Row) -> Markup {
    let indent = if row.is_part { "\u{2003}" } else { "" };
    html! { tr { th { (indent) (row.label) } td { (row.value_text()) " " (row.unit) } } }
}

fn table_html(table: &Table) -> Markup {
    let is_shown = |k: &usize| !table.columns[*k].label.is_empty();
    let shown: Vec<usize> = (0..table.columns.len()).filter(is_shown).collect();
    html! {
        @if !(table.rows.is_empty() || shown.is_empty()) {
            table {
                thead { tr { @for &k in &shown { th { (table.columns[k].label) } } } }
                @for row in &table.rows {
                    tr { @for &k in &shown { td { (value_text(&row[k], table.columns[k].decimals)) } } }
                }
            }
        }
    }
}
