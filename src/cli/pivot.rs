//! `pivot`: where a tool's tip is, from recordings around one point.

use super::numbers::above_zero;
use super::output::{self, Format};
use crate::calibration::marker_body::MarkerBody;
use crate::calibration::pivot::{Pivot, PivotLimits, pivot};
use crate::formats::pivot_recording::PivotRecording;
use crate::geometry::pose::Pose;
use crate::store;
use crate::study::figures::with_separators;
use anyhow::{Context, bail};
use clap::Args;
use nalgebra::Point3;
use serde_json::{Value, json};
use std::path::PathBuf;

#[derive(Debug, Args)]
pub struct PivotArgs {
    /// Recordings of one tool around one point: tables of NDI Track or ToolBox (CSV, TSV), an Aurora
    /// log, a PLUS sequence (*.igs.mha); 4x4 matrices as text, row by row; a poses table (CSV: x, y,
    /// z, qw, qx, qy, qz); or an empivot file of the JHU course, whose tool has the frame of its
    /// markers' mean in the first frame. All in mm
    #[arg(required = true)]
    recordings: Vec<PathBuf>,

    /// The tool that is meant where a recording has several: a part of its name
    #[arg(long, value_name = "NAME")]
    tool: Option<String>,

    /// Fewest poses that are accepted; 3 are needed
    #[arg(long, value_name = "COUNT", default_value_t = PivotLimits::MIN_POSES)]
    min_poses: usize,

    /// Least angle between the two poses that differ most
    #[arg(long, value_name = "DEG", default_value_t = PivotLimits::MIN_RANGE_DEG, value_parser = above_zero)]
    min_range_deg: f64,

    /// Least RMS turn about the axis that the tool turned about least
    #[arg(long, value_name = "DEG", default_value_t = PivotLimits::MIN_TURN_DEG, value_parser = above_zero)]
    min_turn_deg: f64,

    /// Largest RMS distance of the tip from the point that it rested in
    #[arg(long, value_name = "MM", default_value_t = PivotLimits::MAX_RMS_MM, value_parser = above_zero)]
    max_rms_mm: f64,

    /// How to print the figures
    #[arg(long, value_enum, default_value_t)]
    format: Format,
}

/// Reads and calibrates.
///
/// # Errors
/// Files that can't be used, and recordings that cannot answer, with the reason.
pub fn run(args: &PivotArgs) -> anyhow::Result<()> {
    let limits = PivotLimits {
        min_poses: args.min_poses,
        min_range_rad: args.min_range_deg.to_radians(),
        min_turn_rad: args.min_turn_deg.to_radians(),
        max_rms_mm: args.max_rms_mm,
    };
    let poses = poses(&args.recordings, args.tool.as_deref())?;
    let found = pivot(&poses, &limits).context("no tip")?;
    match args.format {
        Format::Json => output::print_json(&as_json(&found)),
        Format::Text => output::print(&as_text(&found)),
    }
}

/// Of all recordings; markers have the frame that they have in the first of them.
pub(super) fn poses(files: &[PathBuf], tool: Option<&str>) -> anyhow::Result<Vec<Pose>> {
    let mut poses = Vec::new();
    let mut body: Option<MarkerBody> = None;
    for file in files {
        match store::read_pivot_recording(file)? {
            PivotRecording::Poses(more) if body.is_none() => poses.extend(more),
            PivotRecording::Tools(recording) if body.is_none() => {
                let named = || file.display().to_string();
                let track = recording.tool(tool).with_context(named)?;
                for (reason, count) in track.unusable() {
                    output::note(&format!(
                        "{}: {} of {} samples not used: {reason}",
                        named(),
                        with_separators(count),
                        with_separators(track.samples.len())
                    ));
                }
                poses.extend(track.good());
            }
            PivotRecording::Markers(frames) if body.is_some() || poses.is_empty() => {
                let body = body.get_or_insert_with(|| {
                    MarkerBody::seen_at(frames.first().map_or(&[], Vec::as_slice))
                });
                let more = body.poses(&frames);
                poses.extend(more.with_context(|| file.display().to_string())?);
            }
            _ => bail!(
                "{}: found poses beside markers, expected recordings of one kind: the tool's frame is not the same",
                file.display()
            ),
        }
    }
    Ok(poses)
}

fn as_json(found: &Pivot) -> Value {
    let point = |point: &Point3<f64>| json!([point.x, point.y, point.z]);
    json!({
        "poses": found.poses,
        "tip": point(&found.tip_in_tool),
        "pivot": point(&found.pivot_in_tracker),
        "rms_mm": found.rms_mm,
        "rms_component_mm": found.rms_component_mm(),
        "orientation_range_deg": found.orientation_range_rad.to_degrees(),
    })
}

fn as_text(found: &Pivot) -> String {
    let row = |label: &str, value: String, unit: &str| (label.to_owned(), value, unit.to_owned());
    let point = |at: &Point3<f64>| format!("{:.3} {:.3} {:.3}", at.x, at.y, at.z);
    let mm = |value: f64| format!("{value:.3}");
    output::aligned(&[
        row("poses", with_separators(found.poses), ""),
        row(
            "largest angle between two",
            format!("{:.1}", found.orientation_range_rad.to_degrees()),
            "deg",
        ),
        row("tip in the tool's frame", point(&found.tip_in_tool), "mm"),
        row(
            "  standard error, worst direction",
            mm(found.tip_std_error_mm),
            "mm",
        ),
        row(
            "pivot in the tracker's frame",
            point(&found.pivot_in_tracker),
            "mm",
        ),
        row("distance of the tip from it, RMS", mm(found.rms_mm), "mm"),
        row("  of a component", mm(found.rms_component_mm()), "mm"),
        row("  largest", mm(found.worst_mm), "mm"),
    ])
}
