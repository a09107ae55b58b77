//! `export field`: the error of an environment on a lattice.

use super::super::file_kinds::{AXES, file_kind, refuse_axes};
use super::super::numbers::{lengths_above_zero, six, three};
use super::super::prelude::*;
use trackwright_field::samples::MapKind;
use trackwright_formats::export::{PatientAxes, field_table, mha, nrrd, vti};
use trackwright_geometry::bounds::Bounds;
use trackwright_geometry::number::direction;
use trackwright_simulation::field_lattice::{Displacement, FieldPlan, FieldSensor, sample_field};

#[derive(Debug, Args)]
pub struct FieldArgs {
    /// Environment (*.env.ron)
    environment: PathBuf,

    /// File to write, its kind given by its name: *.nrrd or *.mha (displacement field in LPS),
    /// *.vti or *.csv (both in the tracker frame)
    #[arg(short, long, value_name = "OUT")]
    output: PathBuf,

    /// Axis of the sensor that is imagined at each point, tracker frame; or `mean`, over the model's
    /// basis orientations
    #[arg(long, value_name = "X,Y,Z|mean", default_value = "0,0,1", allow_hyphen_values = true, value_parser = sensor)]
    axis: FieldSensor,

    /// Longest step between points in mm, one for all axes or one for each; steps are shortened so
    /// that whole ones span the box
    #[arg(long, value_name = "MM[,MM,MM]", default_value = "10", allow_hyphen_values = true, value_parser = lengths_above_zero)]
    spacing: [f64; 3],

    /// Box that the lattice spans: its least and its greatest corner in the tracker frame, mm; the
    /// model's own where left out
    #[arg(long = "box", value_name = "X,Y,Z,X,Y,Z", allow_hyphen_values = true, value_parser = six)]
    bounds: Option<[f64; 6]>,

    /// What is displaced; where left out `error` for a distortion map, `correction` for a correction
    /// map
    #[arg(long, value_parser = DISPLACEMENT)]
    displacement: Option<Displacement>,

    /// What 3D Slicer is to take the tracker's x, y and z for (*.nrrd, *.mha)
    #[arg(long, value_parser = AXES, default_value = "ras")]
    axes: PatientAxes,

    /// What happens at points outside the model's box; rejected ones are NaN, in tables empty
    #[arg(long, value_parser = OUTSIDE, default_value = "clamp")]
    outside: OutsidePolicy,

    /// How to print the figures
    #[arg(long, value_enum, default_value_t)]
    format: Format,
}

/// What is displaced from where to where.
const DISPLACEMENT: Choice<Displacement> = Choice(&[
    (
        "error",
        "Measured minus true position, at the true one: hung under this transform in 3D Slicer, \
         what the tracker reads is corrected",
        Displacement::Error,
    ),
    (
        "correction",
        "True minus measured position, at the measured one, as `compensate` finds it: hung under \
         this transform, what is true goes where the tracker would read it",
        Displacement::Correction,
    ),
]);

/// Reads, samples, and writes.
///
/// # Errors
/// Files that can't be used, a box that is none, a lattice of too many points.
pub fn run(args: &FieldArgs, files: &Files) -> anyhow::Result<()> {
    let output = files.output(&args.output)?;
    let kind = file_kind(&args.output, "a field", &[".nrrd", ".mha", ".vti", ".csv"])?;
    let is_for_slicer = matches!(kind, ".nrrd" | ".mha");
    if !is_for_slicer {
        refuse_axes(args.axes, &args.output)?;
    }
    let environment = files.read_environment(&args.environment)?;
    let model = &environment.model;
    let displacement = args.displacement.unwrap_or(match model.map() {
        MapKind::Distortion => Displacement::Error,
        MapKind::Correction => Displacement::Correction,
    });
    let bounds = args.bounds.map_or(Ok(*model.bounds()), box_of)?;
    let outside = args.outside;
    let plan = FieldPlan::spanning(bounds, args.spacing, args.axis, displacement, outside)
        .context("--spacing and --box")?;
    let field = sample_field(model, &plan, &Shown::new("sampling").task)
        .with_context(|| args.environment.display().to_string())?;
    let axes = args.axes;
    output.write(|out| match kind {
        ".nrrd" => nrrd::write(out, &field, axes),
        ".mha" => mha::write(out, &field, axes),
        ".vti" => vti::write(out, &field),
        _ => field_table::write(out, &field),
    })?;
    let missing = field.missing();
    if missing > 0 && is_for_slicer {
        output::note(&format!(
            "{}: {} points are NaN, which 3D Slicer cannot move anything by; --outside clamp or a smaller --box leaves \
             fewer",
            args.output.display(),
            with_separators(missing)
        ));
    }
    let section = field.section().with(format!("written to {}", args.output.display()));
    output::print_section(args.format, &section)
}

/// A sensor along a direction, or `mean`.
fn sensor(text: &str) -> Result<FieldSensor, String> {
    if text == "mean" {
        return Ok(FieldSensor::MeanOfBasis);
    }
    match three(text).map(direction) {
        Ok(Some(axis)) => Ok(FieldSensor::Along(axis)),
        _ => Err("expected three numbers with commas that are not all zero, or mean".to_owned()),
    }
}

fn box_of([x0, y0, z0, x1, y1, z1]: [f64; 6]) -> anyhow::Result<Bounds> {
    let (min, max) = ([x0, y0, z0], [x1, y1, z1]);
    for (k, name) in ["x", "y", "z"].iter().enumerate() {
        if min[k] > max[k] {
            bail!(
                "--box: found {name} from {} to {}, which is empty; expected the least corner first",
                min[k],
                max[k]
            );
        }
    }
    Ok(Bounds::from((min, max)))
}
