//! All pictures of a sweep on one page.

use super::{SweepColumns, effect_chart, front, front_chart, parallel_coordinates, significant};
use crate::page::css;
use maud::{DOCTYPE, Markup, PreEscaped, html};
use trackwright_formats::printable::{printable, printable_lines};
use trackwright_result::with_separators;

const WIDE: (u32, u32) = (1100, 520);
const CHART: (u32, u32) = (720, 420);

/// Rows of the front that the page lists.
const MOST_LISTED: usize = 40;

/// The page, which needs no other file.
pub fn page(sweep: &SweepColumns) -> String {
    let figure = &sweep.figures[0];
    let with_figure = figure.values.iter().filter(|value| value.is_finite()).count();
    let content = html! {
        main {
            header {
                h1 { (sweep.title) }
                p { (with_separators(sweep.rows.len())) " rows, " (with_separators(sweep.rows.len() - with_figure)) " of them without figures." }
            }
            section {
                h2 { "Rows" }
                (picture(&parallel_coordinates(sweep, WIDE)))
            }
            section {
                h2 { "What each number does" }
                @for number in &sweep.parameters {
                    (picture(&effect_chart(sweep, number, figure).to_svg(CHART)))
                }
            }
            @if let [first, second, ..] = sweep.figures.as_slice() {
                section {
                    h2 { "Best rows" }
                    (picture(&front_chart(sweep, first, second).to_svg(CHART)))
                    (table(sweep, &front(&first.values, &second.values)))
                }
            }
        }
        footer { p { "Made by trackwright " (env!("CARGO_PKG_VERSION")) ". This file is whole: it needs no network and no other file." } }
    };
    html! {
        (DOCTYPE)
        html lang="en" {
            head {
                meta charset="utf-8";
                meta http-equiv="Content-Security-Policy" content="default-src 'none'; style-src 'unsafe-inline'";
                meta name="viewport" content="width=device-width, initial-scale=1";
                title { (printable(&sweep.title)) " – sweep" }
                style { (PreEscaped(css())) }
            }
            body { (PreEscaped(printable_lines(&content.into_string()))) }
        }
    }
    .into_string()
}

fn picture(svg: &str) -> Markup {
    html! { figure { (PreEscaped(svg)) } }
}

fn table(sweep: &SweepColumns, rows: &[usize]) -> Markup {
    let columns = || sweep.parameters.iter().chain(&sweep.figures);
    html! {
        table {
            thead { tr { th { "row" } @for column in columns() { th { (column.label()) } } } }
            tbody {
                @for &row in rows.iter().take(MOST_LISTED) {
                    tr {
                        td { (sweep.rows[row]) }
                        @for column in columns() { td { (significant(column.values[row])) } }
                    }
                }
            }
        }
        @if rows.len() > MOST_LISTED {
            p { "The first " (MOST_LISTED) " of " (with_separators(rows.len())) " rows." }
        }
    }
}
