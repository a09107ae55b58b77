//! Charts of a study's tip error: over position, over orientation, and how it is spread.

use super::plot::{Axis, Chart, Series, SeriesStyle};
use trackwright_simulation::profile::AxisProfile;
use trackwright_simulation::{AlongShaft, Metric, Profile, Requirement};

/// Columns of a timeline: more would be a solid band.
const MOST_COLUMNS: usize = 200;

/// Points of the cumulative curve.
const CURVE_POINTS: usize = 200;

/// Points of the curve along the shaft.
const SHAFT_POINTS: usize = 60;

/// The charts of a study, with the requirement as a line; none of a single pose.
pub fn charts(profile: &Profile, requirement: Option<&Requirement>) -> Vec<Chart> {
    if profile.len() < 2 {
        return Vec::new();
    }
    let requirement = requirement.copied().unwrap_or_default();
    let mut charts = Vec::new();
    for (axes, moved, label) in [
        (["x", "y", "z"], "position", "moved from the design's pose, mm"),
        (["rx", "ry", "rz"], "orientation", "turned from the design's pose, °"),
    ] {
        let shown: Vec<&AxisProfile> =
            profile.axes.iter().filter(|profile| axes.contains(&profile.axis)).collect();
        if shown.is_empty() {
            continue;
        }
        charts.push(over_axes(
            format!("RMS over {moved}"),
            label,
            &shown,
            |axis| &axis.rms_mm,
            requirement.bound(Metric::TIP_RMS),
        ));
        charts.push(over_axes(
            format!("Largest over {moved}"),
            label,
            &shown,
            |axis| &axis.max_mm,
            requirement.bound(Metric::TIP_MAX),
        ));
    }
    if charts.is_empty() {
        charts.push(over_trials(profile));
    }
    charts.push(spread(profile, &requirement));
    charts.extend(profile.along_shaft.as_ref().map(|along| along_shaft(along, &requirement)));
    charts
}

/// The error of every point of the tool's long axis, from the tip to the rearmost sensor.
fn along_shaft(along: &AlongShaft, requirement: &Requirement) -> Chart {
    let sensors = along.sensors_mm.iter().map(|&at_mm| (at_mm, along.rms_mm(at_mm)));
    let mut series = vec![
        Series::new("RMS", SeriesStyle::Line, along.curve(SHAFT_POINTS)),
        Series::new("sensors", SeriesStyle::Points, sensors.collect()),
        bound(0.0, ""),
    ];
    let limit_mm = requirement.bound(Metric::TIP_RMS);
    series.extend(limit_mm.map(|limit_mm| bound(limit_mm, "required at the tip")));
    Chart {
        title: "RMS error along the shaft".to_owned(),
        x: Axis::linear("from the tip along the shaft, mm"),
        y: Axis::linear("error, mm"),
        series,
    }
}

/// One line an axis of the motion, and the level that is allowed.
fn over_axes(
    title: String,
    label: &str,
    axes: &[&AxisProfile],
    values: impl Fn(&AxisProfile) -> &Vec<f64>,
    limit_mm: Option<f64>,
) -> Chart {
    let mut series: Vec<Series> = axes
        .iter()
        .map(|axis| {
            let points = axis.values.iter().copied().zip(values(axis).iter().copied());
            Series::new(axis.axis, SeriesStyle::Line, points.collect())
        })
        .collect();
    // Without a name, for the axis alone: errors are read against zero.
    series.push(bound(0.0, ""));
    series.extend(limit_mm.map(|limit_mm| bound(limit_mm, "required")));
    Chart { title, x: Axis::linear(label), y: Axis::linear("tip error, mm"), series }
}

/// Errors in the order of the poses; of many the worst of neighbours stands for them.
fn over_trials(profile: &Profile) -> Chart {
    let columns = profile.columns(MOST_COLUMNS);
    let each = profile.len().div_ceil(columns.len().max(1));
    let label = match each {
        0 | 1 => "trial".to_owned(),
        _ => format!("trial; of each {each} the one with the largest error"),
    };
    // Counted from 1, as everywhere that a person reads it.
    let number = |trial: usize| trial as f64 + 1.0;
    let points = columns.iter().map(|column| (number(column.worst_trial), column.max_mm)).collect();
    Chart {
        title: "Tip error pose by pose".to_owned(),
        x: Axis::linear(label),
        y: Axis::linear("tip error, mm"),
        series: vec![Series::new("", SeriesStyle::Points, points)],
    }
}

/// Which part of the positions is within which error, and the allowed one on that curve.
fn spread(profile: &Profile, requirement: &Requirement) -> Chart {
    let curve = profile.cumulative(CURVE_POINTS);
    let points = curve.iter().map(|&(mm, part)| (mm, 100.0 * part)).collect();
    let mut series = vec![Series::new("", SeriesStyle::Line, points)];
    let largest_mm = curve.last().map_or(0.0, |&(mm, _)| mm);
    if let Some((_, limit_mm)) = requirement.single_position_mm()
        && limit_mm <= largest_mm
    {
        let point = (limit_mm, 100.0 * profile.part_within(limit_mm));
        series.push(Series::new(format!("{limit_mm} mm"), SeriesStyle::Marked, vec![point]));
    }
    Chart {
        title: "How many positions are within an error".to_owned(),
        x: Axis::linear("tip error, mm"),
        y: Axis::linear("positions, %"),
        series,
    }
}

fn bound(level_mm: f64, name: &str) -> Series {
    Series::new(name, SeriesStyle::Bound, vec![(0.0, level_mm)])
}

#[cfg(test)]
mod tests {
    use super::*;
    use trackwright_simulation::{CancelToken, Mode, study_profiled};

    fn profile(mode: &Mode) -> (Profile, Requirement) {
        let world =
            trackwright_project::open_builtin_without_meshes(trackwright_project::DEFAULT_BUILTIN)
                .unwrap();
        let scenario = trackwright_project::resolve(world.document.design(), &world.environment);
        let (_, profile) = study_profiled(&scenario, mode, &CancelToken::default()).unwrap();
        (profile.unwrap(), scenario.requirement.unwrap())
    }

    #[test]
    fn position_and_orientation_have_two_charts_each() {
        let (profile, requirement) = profile(&Mode::Motion);
        let charts = charts(&profile, Some(&requirement));
        let titles: Vec<&str> = charts.iter().map(|chart| chart.title.as_str()).collect();
        assert_eq!(
            titles[..4],
            [
                "RMS over position",
                "Largest over position",
                "RMS over orientation",
                "Largest over orientation"
            ]
        );
        // The requirement is about RMS alone: no line claims to bound the largest.
        let has_bound = |chart: &Chart| chart.series.iter().any(|s| s.name == "required");
        assert_eq!(
            charts.iter().map(has_bound).collect::<Vec<_>>(),
            [true, false, true, false, false, false]
        );
        // The largest over each axis is the largest of all.
        let largest = profile.tip_error_mm.iter().copied().fold(0.0, f64::max);
        let lines = |s: &&Series| s.style == SeriesStyle::Line;
        for series in charts[1].series.iter().filter(lines) {
            let top = series.points.iter().map(|p| p.1).fold(0.0, f64::max);
            assert_eq!(top, largest);
        }
    }

    #[test]
    fn the_shaft_has_a_chart_that_begins_at_the_tip() {
        let (profile, requirement) = profile(&Mode::Motion);
        let charts = charts(&profile, Some(&requirement));
        let chart = charts.last().unwrap();
        assert!(chart.x.label.ends_with("mm") && chart.y.label.ends_with("mm"));
        let squares: f64 = profile.tip_error_mm.iter().map(|e| e * e).sum();
        let rms_mm = (squares / profile.len() as f64).sqrt();
        let (from_tip_mm, at_tip_mm) = chart.series[0].points[0];
        assert!(from_tip_mm == 0.0 && (at_tip_mm - rms_mm).abs() < 1e-9, "{at_tip_mm} {rms_mm}");
        assert!(chart.series.iter().any(|s| s.name == "required at the tip"));
    }

    #[test]
    fn trials_are_counted_from_one() {
        let (profile, _) = profile(&Mode::Motion);
        let given = Profile { axes: Vec::new(), ..profile };
        let chart = over_trials(&given);
        let first = chart.series[0].points.first().unwrap().0;
        assert!(first >= 1.0, "{first}");
        let last = chart.series[0].points.iter().map(|p| p.0).fold(0.0, f64::max);
        assert!(last <= given.len() as f64, "{last}");
        let worst = given.worst().unwrap() as f64 + 1.0;
        assert!(chart.series[0].points.iter().any(|p| p.0 == worst), "{worst}");
    }

    #[test]
    fn one_pose_has_nothing_to_chart() {
        let (profile, requirement) = profile(&Mode::Single);
        assert!(charts(&profile, Some(&requirement)).is_empty());
    }
}
