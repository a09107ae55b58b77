//! `export poses`: poses and tips as points, as a transform, as a table.

use super::super::file_kinds::{AXES, file_kind, refuse_axes};
use super::super::numbers::three;
use super::super::prelude::*;
use super::super::tool_reader::ToolReader;
use trackwright_formats::export::markups::MarkupPoint;
use trackwright_formats::export::{PatientAxes, itk_transform, markups};
use trackwright_formats::poses::{self, WhosePoses};
use trackwright_geometry::pose::Pose;

#[derive(Debug, Args)]
pub struct PosesArgs {
    /// Recordings or tables of poses: whatever `pivot` reads; or, with --columns, one of the
    /// program's own tables
    #[arg(required = true)]
    poses: Vec<PathBuf>,

    /// File to write, its kind given by its name: *.mrk.json (points, LPS), *.tfm (one transform,
    /// LPS) or *.csv (poses as they are)
    #[arg(short, long, value_name = "OUT")]
    output: PathBuf,

    /// The tool that is meant where a recording has several: a part of its name
    #[arg(long, value_name = "NAME", conflicts_with = "columns")]
    tool: Option<String>,

    /// Which poses of a table that has several: `true` and `sim` of a simulation log, `ideal` and
    /// `measured` of a measurement table, `tool` and `crf` of input data
    #[arg(long, value_parser = COLUMNS)]
    columns: Option<WhosePoses>,

    /// What is exported of each pose: the point of its body at this place, mm, as `pivot` prints a
    /// tip; the body's origin where left out
    #[arg(long, value_name = "X,Y,Z", allow_hyphen_values = true, value_parser = three)]
    tip: Option<[f64; 3]>,

    /// One pose only, counted from 0
    #[arg(long, value_name = "N")]
    row: Option<usize>,

    /// What 3D Slicer is to take x, y and z for (*.mrk.json, *.tfm)
    #[arg(long, value_parser = AXES, default_value = "ras")]
    axes: PatientAxes,

    #[command(flatten)]
    as_is: AsIsArgs,
}

const COLUMNS: Choice<WhosePoses> = Choice(&[
    ("true", "", WhosePoses::True),
    ("sim", "", WhosePoses::Simulated),
    ("ideal", "", WhosePoses::Ideal),
    ("measured", "", WhosePoses::Measured),
    ("tool", "", WhosePoses::Tool),
    ("crf", "", WhosePoses::Crf),
]);

/// Reads and writes.
///
/// # Errors
/// Files that can't be used, rows that are not there, several poses for one transform.
pub fn run(args: &PosesArgs, files: &Files) -> anyhow::Result<()> {
    let output = files.output(&args.output)?;
    let kind = file_kind(&args.output, "poses", &[".mrk.json", ".tfm", ".csv"])?;
    if kind == ".csv" {
        refuse_axes(args.axes, &args.output)?;
    }
    let mut found = match args.columns {
        None => ToolReader::of_tool(files, args.tool.as_deref(), args.as_is)
            .read_all(args.poses.iter().map(PathBuf::as_path))?,
        Some(columns) => {
            let mut all = Vec::new();
            for file in &args.poses {
                all.extend(args.as_is.take(files.read_poses_of(file, columns)?)?);
            }
            all
        }
    };
    if let Some([x, y, z]) = args.tip {
        let tip = Pose::translation(x, y, z);
        found.iter_mut().for_each(|pose| *pose *= tip);
    }
    let chosen = chosen(&found, args.row)?;
    let axes = args.axes;
    match (kind, chosen.as_slice()) {
        (".csv", _) => {
            output.write(|out| poses::write(out, chosen.iter().map(|(_, pose)| pose)))?;
        }
        (".mrk.json", _) => {
            let points: Vec<_> = chosen
                .iter()
                .map(|(row, pose)| MarkupPoint {
                    // As a person counts poses.
                    label: (row + 1).to_string(),
                    tracker_from_point: *pose,
                })
                .collect();
            output.write(|out| markups::write(out, &points, axes))?;
        }
        (_, [(_, pose)]) => {
            output.write(|out| itk_transform::write(out, pose, axes))?;
        }
        _ => bail!(
            "{}: found {} poses, expected one for a transform; --row 0 to {} chooses it",
            args.output.display(),
            with_separators(chosen.len()),
            chosen.len().saturating_sub(1)
        ),
    }
    output::print(&format!(
        "{} poses written to {}",
        with_separators(chosen.len()),
        args.output.display()
    ))
}

/// All poses with their rows, or one.
fn chosen(poses: &[Pose], row: Option<usize>) -> anyhow::Result<Vec<(usize, Pose)>> {
    let all = || poses.iter().copied().enumerate();
    match row {
        None => Ok(all().collect()),
        Some(row) if row < poses.len() => Ok(all().skip(row).take(1).collect()),
        Some(row) => bail!(
            "found {} poses, expected more than --row {row}, which counts from 0",
            with_separators(poses.len())
        ),
    }
}
