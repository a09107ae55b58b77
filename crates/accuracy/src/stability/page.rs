//! The battery's rows for a person to read: a text table, a page, and a table for spreadsheets.

use super::case::{Family, Row};
use trackwright_report::text_table;

const HEADERS: [&str; 6] = ["case", "quantity", "condition", "error", "bound", "holds"];

fn cells(row: &Row) -> [String; 6] {
    [
        row.case.clone(),
        row.quantity.to_owned(),
        number(row.condition),
        number(row.error),
        number(row.bound),
        if row.holds { "holds" } else { "BROKEN" }.to_owned(),
    ]
}

/// Two digits: more are not the same on the next machine.
fn number(value: f64) -> String {
    if value == 0.0 || (1.0..1000.0).contains(&value.abs()) && value.fract() == 0.0 {
        format!("{value}")
    } else {
        format!("{value:.1e}")
    }
}

/// Rows under their families' names, in columns.
pub fn text(rows: &[Row]) -> String {
    let head = HEADERS.map(str::to_owned);
    let table: Vec<_> = [head].into_iter().chain(rows.iter().map(cells)).map(Vec::from).collect();
    let table = text_table::lines(&table, |column| (2..5).contains(&column));
    let mut lines = Vec::new();
    let mut family = "";
    for (row, line) in rows.iter().zip(&table[1..]) {
        if row.family != family {
            family = row.family;
            lines.push(format!("{}{family}", if lines.is_empty() { "" } else { "\n" }));
            lines.push(format!("  {}", table[0]));
        }
        lines.push(format!("  {line}"));
    }
    lines.push(String::new());
    lines.push(verdict(rows));
    lines.join("\n")
}

/// How many rows hold, and which do not.
pub fn verdict(rows: &[Row]) -> String {
    let broken: Vec<_> = rows.iter().filter(|r| !r.holds).collect();
    if broken.is_empty() {
        return format!("all {} rows hold", rows.len());
    }
    let names = broken.iter().map(|r| format!("\n  {}: {}", r.case, r.quantity));
    format!("{} of {} rows do not hold:{}", broken.len(), rows.len(), names.collect::<String>())
}

/// The page: what is tested and how, then every row. The same on every machine but for the last
/// digits of the errors.
pub fn markdown(families: &[Family], rows: &[Row]) -> String {
    let mut page = String::from(
        "# Stiff and extreme cases\n\n\
         Written by `trackwright stability`. Each computation of the program is compared with a \
         reference in numbers of 192 bits (least squares beyond 216 unknowns: exact through their \
         tensor structure, or by the gradient in that precision and a refinement step). An error \
         has to keep the bound `C · condition · epsilon · scale`, with epsilon 2.2e-16: what a \
         backward stable algorithm can promise. Where a rank is decided, the condition is that of \
         the part kept, and the case states how wide the gap below it is. Where a method has an error \
         of its own, its family states that bound. Rows that state what must happen count violations, \
         and none is allowed.\n",
    );
    page.push_str(&format!("\n{}.\n", verdict(rows)));
    for family in families {
        page.push_str(&format!("\n## {}\n\n{}\n", family.name, family.about));
        if !family.quantities.is_empty() {
            page.push_str("\n| quantity | C | condition | scale |\n| --- | --- | --- | --- |\n");
        }
        for q in &family.quantities {
            page.push_str(&format!(
                "| {} | {} | {} | {} |\n",
                q.name, q.constant, q.condition, q.scale
            ));
        }
        page.push_str("\n| case | quantity | condition | error | bound | |\n");
        page.push_str("| --- | --- | ---: | ---: | ---: | --- |\n");
        for row in rows.iter().filter(|r| r.family == family.name) {
            page.push_str(&format!("| {} |\n", cells(row).join(" | ")));
        }
    }
    page
}

/// One row a line, numbers in full, as CSV.
///
/// # Errors
/// None of the writer's own: it writes to memory.
pub fn csv(rows: &[Row]) -> Result<Vec<u8>, csv::Error> {
    let mut writer = csv::Writer::from_writer(Vec::new());
    writer.write_record(["family"].iter().chain(&HEADERS))?;
    for row in rows {
        writer.write_record([
            row.family,
            &row.case,
            row.quantity,
            &row.condition.to_string(),
            &row.error.to_string(),
            &row.bound.to_string(),
            &row.holds.to_string(),
        ])?;
    }
    writer.into_inner().map_err(|e| e.into_error().into())
}
