//! What a hand waits for, measured by the program that runs: `trackwright --measure`.
//!
//! A window of 1280x720 opens on the built-in design, rests, shows everything at once and is
//! orbited; then edits and placements are timed without a renderer.

pub mod error;
pub mod offline;
pub mod presented;
pub mod process;
pub mod window;
pub mod worlds;

pub use error::MeasureError;

use crate::app::measure::offline::{edits_to_figures, placement};
use crate::app::measure::process::Started;
use crate::app::measure::window::{SHOWN_ARROWS, WindowFigures};
use std::fmt::Write as _;
use std::time::Duration;

/// Times an edit is made and awaited.
const EDITS: usize = 50;

/// One thing that was measured.
#[derive(Clone, Debug, PartialEq)]
pub struct Row {
    pub what: String,
    pub measured: String,
    /// The required value; `None` where it only explains another row.
    pub required: Option<&'static str>,
    pub is_met: Option<bool>,
}

impl Row {
    fn required(
        what: impl Into<String>,
        measured: String,
        required: &'static str,
        is_met: bool,
    ) -> Self {
        Self { what: what.into(), measured, required: Some(required), is_met: Some(is_met) }
    }

    fn note(what: impl Into<String>, measured: String) -> Self {
        Self { what: what.into(), measured, required: None, is_met: None }
    }
}

/// All figures, and on what they were measured.
#[derive(Clone, Debug, PartialEq)]
pub struct Report {
    pub machine: String,
    pub rows: Vec<Row>,
}

/// Measures everything; takes about half a minute. Call
/// [`preflight::window`](crate::app::preflight::window) first.
///
/// # Errors
/// See [`MeasureError`].
pub fn measure(started: Started) -> Result<Report, MeasureError> {
    let window = window::run(started)?;
    let mut rows = window_rows(&window);
    rows.extend(edit_rows()?);
    rows.extend(placement_rows()?);
    let cores = std::thread::available_parallelism().map_or(1, usize::from);
    Ok(Report { machine: format!("{}, {cores} processor cores, 1280x720", window.adapter), rows })
}

fn window_rows(window: &WindowFigures) -> Vec<Row> {
    let mut rows = vec![Row::required(
        "process start to the first presented frame with tool and figures",
        milliseconds(window.first_frame),
        "at most 1,500 ms",
        window.first_frame <= Duration::from_millis(1500),
    )];
    let rest = &window.rest;
    let share = rest.processor.map(|p| p.as_secs_f64() / rest.lasted.as_secs_f64() * 100.0);
    rows.push(Row::required(
        format!("at rest for {:.0} s", rest.lasted.as_secs_f64()),
        match share {
            Some(share) => format!("{} frames, {share:.2} % of a core", rest.frames),
            None => format!("{} frames", rest.frames),
        },
        "no frames, below 1 % of a core",
        rest.frames == 0 && share.is_none_or(|share| share < 1.0),
    ));
    let orbit = &window.orbit;
    let a_second = orbit.frames as f64 / orbit.lasted.as_secs_f64();
    let what = format!(
        "orbiting {} arrows, a slice of {}x{} texels, {} triangles",
        grouped(SHOWN_ARROWS),
        window.slice_texels[0],
        window.slice_texels[1],
        grouped(window.triangles),
    );
    let a_frame_ms = 1e3 / a_second.max(f64::MIN_POSITIVE);
    let measured = format!("{a_second:.1} frames a second, {a_frame_ms:.1} ms a frame");
    rows.push(match window.is_software {
        true => Row::required(what, measured, "20 frames a second", a_second >= 20.0),
        false => Row::required(what, measured, "below 4 ms a frame", a_frame_ms < 4.0),
    });
    if let Some(processor) = orbit.processor {
        let ms = processor.as_secs_f64() * 1e3 / orbit.frames.max(1) as f64;
        rows.push(Row::note("  processor time of such a frame, all cores", format!("{ms:.1} ms")));
    }
    for (pass, ms) in &window.passes_ms {
        rows.push(Row::note(format!("  of it: {pass}"), format!("{ms:.1} ms")));
    }
    rows
}

fn edit_rows() -> Result<Vec<Row>, MeasureError> {
    let mut times = edits_to_figures(EDITS)?;
    times.sort();
    let at = |part: usize| times[(times.len() - 1) * part / 4];
    Ok(vec![Row::required(
        "an edit to its stamped figures, 3,375 poses at order 4, renderer off",
        format!(
            "median {} ({} to {}) of {}",
            milliseconds(at(2)),
            milliseconds(at(0)),
            milliseconds(at(4)),
            times.len()
        ),
        "at most 16 ms",
        at(2) <= Duration::from_millis(16),
    )])
}

fn placement_rows() -> Result<Vec<Row>, MeasureError> {
    let placed = placement()?;
    let vertices = grouped(placed.vertices);
    Ok(vec![
        Row::required(
            format!("placement of {vertices} vertices, first picture"),
            milliseconds(placed.first),
            "0.2 s",
            placed.first <= Duration::from_millis(200),
        ),
        Row::required(
            format!("placement of {vertices} vertices, the last one"),
            milliseconds(placed.last),
            "2 s",
            placed.last <= Duration::from_secs(2),
        ),
    ])
}

/// The report as lines for a terminal.
pub fn text(report: &Report) -> String {
    let width = |of: fn(&Row) -> &str| {
        let widths = report.rows.iter().map(|row| of(row).chars().count());
        widths.max().unwrap_or(0)
    };
    let [what, measured] = [width(|r| &r.what), width(|r| &r.measured)];
    let mut out = format!("{}\n", report.machine);
    for row in &report.rows {
        let required = match (row.required, row.is_met) {
            (Some(required), Some(true)) => format!("✓ {required}"),
            (Some(required), _) => format!("✗ {required}"),
            (None, _) => String::new(),
        };
        let line = format!("{:what$}  {:measured$}  {required}", row.what, row.measured);
        // Writing to a string cannot fail.
        let _ = writeln!(out, "{}", line.trim_end());
    }
    out.truncate(out.trim_end().len());
    out
}

fn milliseconds(time: Duration) -> String {
    let ms = time.as_secs_f64() * 1e3;
    if ms < 100.0 {
        return format!("{ms:.1} ms");
    }
    format!("{} ms", grouped(ms.round() as usize))
}

/// `1,234,567`.
fn grouped(number: usize) -> String {
    crate::widgets::basic::count(number)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn only_rows_with_a_limit_are_marked_when_they_miss() {
        let report = Report {
            machine: "a machine".to_owned(),
            rows: vec![
                Row::required("start", milliseconds(Duration::from_millis(1700)), "1 s", false),
                Row::note("  of it: waiting", "1 ms".to_owned()),
            ],
        };
        assert_eq!(
            text(&report),
            "a machine\nstart             1,700 ms  ✗ 1 s\n  of it: waiting  1 ms"
        );
    }
}
