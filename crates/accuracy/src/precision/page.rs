//! The report for a person: a page in Markdown with a picture a family, a table for other
//! programs, and plain text for a terminal.

use super::{Family, Machine, Report, Row, What};
use std::fmt::Write;
use trackwright_report::plot::{Axis, Chart, Scale, Series, SeriesStyle};
use trackwright_report::text_table::columns;

/// Size of a picture in pixels: legible in a page of 900 pixels.
pub const PICTURE: (u32, u32) = (900, 600);

/// What a row's ring means.
const DEFAULT: &str = "default";

impl What {
    /// Name of its picture's file.
    pub fn picture(self) -> String {
        format!("precision-{}.svg", self.name())
    }
}

/// The page. Pictures lie beside it, under [`What::picture`]'s names.
pub fn markdown(report: &Report, design: &str) -> String {
    let mut page = format!(
        "# Error against run time\n\n{design} in the room *{}*, on {}.\n\n\
         A row is on the front (•) where no other answer to the same problem is both faster and \
         closer; ◎ is what the program does by default. Times are the least of \
         several runs.\n\n\
         Made by `trackwright precision -o FOLDER`.\n",
        report.room,
        machine(&report.machine)
    );
    for family in &report.families {
        let title = family.what.title();
        let _ = write!(page, "\n## {title}\n\n{}\n", family.about);
        if let Some(reason) = &family.left_out {
            let _ = write!(page, "\nLeft out: {reason}.\n");
            continue;
        }
        let _ = write!(page, "\n![{title}]({})\n", family.what.picture());
        for problem in problems(family) {
            let _ = write!(
                page,
                "\n**{problem}**\n\n\
                 | | method | order | orientations | size | time | each | error |\n\
                 | --- | --- | --: | --: | --: | --: | --: | --: |\n"
            );
            for row in rows_of(family, problem) {
                let _ = writeln!(page, "| {} |", cells(row).join(" | "));
            }
        }
    }
    page
}

/// The rows as CSV with a header.
///
/// # Errors
/// None that memory does not have.
pub fn csv(report: &Report) -> Result<Vec<u8>, csv::Error> {
    let mut out = csv::Writer::from_writer(Vec::new());
    for row in report.rows() {
        out.serialize(row)?;
    }
    out.into_inner().map_err(|e| csv::Error::from(e.into_error()))
}

/// A family's rows as lines of text.
pub fn family_text(family: &Family) -> String {
    let mut text = format!("{}\n", family.what.title());
    if let Some(reason) = &family.left_out {
        let _ = writeln!(text, "  left out: {reason}");
        return text;
    }
    for problem in problems(family) {
        let _ = writeln!(text, "  {problem}");
        let lines: Vec<_> = rows_of(family, problem).map(|row| cells(row).to_vec()).collect();
        for line in columns(&lines, 2) {
            let _ = writeln!(text, "    {line}");
        }
    }
    text
}

/// One line about the machine.
pub fn machine(machine: &Machine) -> String {
    let threads = match machine.threads {
        1 => "1 thread".to_owned(),
        n => format!("{n} threads"),
    };
    let build = if machine.is_optimised {
        ""
    } else {
        " (a build without full optimisation: its times are not representative)"
    };
    format!("{}, {}, {threads}{build}", machine.processor, machine.vectors)
}

/// A family as a picture: time against error, both logarithmic.
pub fn chart(family: &Family) -> Chart {
    let point = |row: &Row| (row.seconds, row.error);
    let mut series = Vec::new();
    let mut front: Vec<_> =
        rows_of(family, &family.charted).filter(|r| r.on_front).map(point).collect();
    front.sort_by(|a, b| a.0.total_cmp(&b.0));
    if !front.is_empty() {
        let name = format!("Pareto front: {}", family.charted);
        series.push(Series::new(name, SeriesStyle::Front, front));
    }
    for row in family.rows.iter().filter(|r| !r.series.is_empty()) {
        match series.iter_mut().find(|s| s.name == row.series) {
            Some(known) => known.points.push(point(row)),
            None => {
                let style = if row.is_step { SeriesStyle::Line } else { SeriesStyle::Points };
                series.push(Series::new(row.series.clone(), style, vec![point(row)]));
            }
        }
    }
    let default = rows_of(family, &family.charted).filter(|r| r.is_default).map(point);
    series.push(Series::new(DEFAULT, SeriesStyle::Marked, default.collect()));
    let unit = family.rows.first().map_or("", |r| r.error_unit);
    let axis = |label: String| Axis { label, scale: Scale::LogarithmicAndZero };
    Chart {
        title: format!("{}: error against run time", family.what.title()),
        x: axis("time (s)".to_owned()),
        y: axis(format!("error ({unit})")),
        series,
    }
}

/// The problems that a family answers, in the order of its rows.
pub fn problems(family: &Family) -> Vec<&str> {
    let mut problems: Vec<&str> = Vec::new();
    for row in &family.rows {
        if !problems.contains(&row.problem.as_str()) {
            problems.push(&row.problem);
        }
    }
    problems
}

/// The answers to one problem.
pub fn rows_of<'a>(family: &'a Family, problem: &'a str) -> impl Iterator<Item = &'a Row> {
    family.rows.iter().filter(move |r| r.problem == problem)
}

/// A row in words: mark, method, order, orientations, size, time, time each, error.
pub fn cells(row: &Row) -> [String; 8] {
    let mark = match (row.on_front, row.is_default) {
        (true, true) => "•◎",
        (true, false) => "•",
        (false, true) => "◎",
        (false, false) => "",
    };
    [
        mark.to_owned(),
        row.method.clone(),
        row.order.to_string(),
        row.directions.to_string(),
        trackwright_result::with_separators(row.size),
        time(row.seconds),
        time(row.seconds / row.size.max(1) as f64),
        error(row.error, row.error_unit),
    ]
}

/// A time to three digits, in the unit that suits it.
fn time(seconds: f64) -> String {
    let (scale, unit) = [(1.0, "s"), (1e3, "ms"), (1e6, "µs"), (1e9, "ns")]
        .into_iter()
        .find(|(scale, _)| seconds * scale >= 1.0)
        .unwrap_or((1e9, "ns"));
    let value = seconds * scale;
    let decimals = match value {
        v if v >= 100.0 => 0,
        v if v >= 10.0 => 1,
        _ => 2,
    };
    format!("{value:.decimals$} {unit}")
}

fn error(value: f64, unit: &str) -> String {
    if value == 0.0 {
        format!("0 {unit}")
    } else if (1e-3..1e4).contains(&value) {
        format!("{value:.4} {unit}")
    } else {
        format!("{value:.1e} {unit}")
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::precision::testing;

    fn row(problem: &str, method: &str, seconds: f64, error: f64, on_front: bool) -> Row {
        let row = testing::row(problem, method).measured(1000, seconds, error);
        Row { on_front, ..row.default_if(method == "full") }
    }

    fn report() -> Report {
        let measured = Family {
            what: What::Motion,
            about: "About the study.".into(),
            rows: vec![
                row("grid", "full", 2e-3, 1e-9, true),
                row("grid", "half", 1e-3, 0.25, true),
                row("range", "half", 1e-3, 0.5, false),
            ],
            charted: "grid".into(),
            left_out: None,
        };
        let left_out = Family {
            what: What::Heatmap,
            about: String::new(),
            rows: Vec::new(),
            charted: String::new(),
            left_out: Some("the room is ideal".into()),
        };
        let machine = Machine {
            processor: "Some processor".into(),
            vectors: "AVX-512",
            threads: 2,
            is_optimised: true,
        };
        Report { machine, room: "Room 7".into(), families: vec![measured, left_out] }
    }

    #[test]
    fn the_page_has_rows_machine_and_omissions() {
        let page = markdown(&report(), "Pointer");
        for text in [
            "Pointer in the room *Room 7*, on Some processor, AVX-512, 2 threads.",
            "![Study](precision-motion.svg)",
            "| •◎ | full | 2 | 14 | 1,000 | 2.00 ms | 2.00 µs | 1.0e-9 mm |",
            "|  | half | 2 | 14 | 1,000 | 1.00 ms | 1.00 µs | 0.5000 mm |",
            "Left out: the room is ideal.",
        ] {
            assert!(page.contains(text), "{text}\n{page}");
        }
    }

    #[test]
    fn the_chart_has_its_front_in_order_of_time() {
        let chart = chart(&report().families[0]);
        assert_eq!(chart.series[0].style, SeriesStyle::Front);
        assert_eq!(chart.series[0].points, [(1e-3, 0.25), (2e-3, 1e-9)]);
        let marked = chart.series.last().unwrap();
        assert_eq!(marked.points, [(2e-3, 1e-9)]);
    }

    #[test]
    fn the_table_has_one_line_a_row() {
        let text = String::from_utf8(csv(&report()).unwrap()).unwrap();
        let mut lines = text.lines();
        assert_eq!(
            lines.next().unwrap(),
            "what,method,order,directions,size,seconds,error,error_unit,on_front,is_default,problem"
        );
        assert_eq!(lines.next().unwrap(), "motion,full,2,14,1000,0.002,1e-9,mm,true,true,grid");
        assert_eq!(lines.count(), 2);
    }

    #[test]
    fn times_are_in_units_that_suit_them() {
        assert_eq!(time(1.234), "1.23 s");
        assert_eq!(time(0.0456), "45.6 ms");
        assert_eq!(time(7.89e-4), "789 µs");
        assert_eq!(time(4e-10), "0.40 ns");
    }
}
