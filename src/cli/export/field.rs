//! `export field`: the error of an environment on a lattice.

use super::super::numbers::{lengths_above_zero, six, three};
use super::super::output::{self, Format, OutsideArg, Shown};
use super::{AxesArg, ends_with, refuse_axes};
use anyhow::{Context, bail};
use clap::{Args, ValueEnum};
use serde_json::{Value, json};
use std::path::{Path, PathBuf};
use trackwright_field::samples::MapKind;
use trackwright_formats::export::{field_table, mha, nrrd, vti};
use trackwright_geometry::bounds::Bounds;
use trackwright_geometry::number::direction;
use trackwright_project::Files;
use trackwright_simulation::Statistics;
use trackwright_simulation::field_lattice::{
    Displacement, FieldLattice, FieldPlan, FieldSensor, sample_field,
};
use trackwright_simulation::figures::with_separators;

#[derive(Debug, Args)]
pub struct FieldArgs {
    /// Environment (*.env.ron)
    environment: PathBuf,

    /// File to write, its kind told by its name: *.nrrd or *.mha (displacement field in LPS), *.vti
    /// or *.csv (both in the tracker frame)
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
    #[arg(long, value_enum)]
    displacement: Option<DisplacementArg>,

    /// What 3D Slicer is to take the tracker's x, y and z for (*.nrrd, *.mha)
    #[arg(long, value_enum, default_value_t)]
    axes: AxesArg,

    /// What happens at points outside the model's box; rejected ones are NaN, in tables empty
    #[arg(long, value_enum, default_value_t)]
    outside: OutsideArg,

    /// How to print the figures
    #[arg(long, value_enum, default_value_t)]
    format: Format,
}

/// What is displaced from where to where.
#[derive(Clone, Copy, Debug, PartialEq, Eq, ValueEnum)]
pub enum DisplacementArg {
    /// Measured minus true position, at the true one: hung under this transform in 3D Slicer, what
    /// the tracker reads is corrected
    Error,
    /// True minus measured position, at the measured one, as `compensate` finds it: hung under this
    /// transform, what is true goes where the tracker would read it
    Correction,
}

#[derive(Clone, Copy)]
enum FileKind {
    Nrrd,
    Mha,
    Vti,
    Csv,
}

/// Reads, samples, and writes.
///
/// # Errors
/// Files that can't be used, a box that is none, a lattice of too many points.
pub fn run(args: &FieldArgs, files: &Files) -> anyhow::Result<()> {
    let output = files.output(&args.output)?;
    let kind = kind_of(&args.output)?;
    if matches!(kind, FileKind::Vti | FileKind::Csv) {
        refuse_axes(args.axes, &args.output)?;
    }
    let environment = files.read_environment(&args.environment)?;
    let model = &environment.model;
    let displacement = match (args.displacement, model.map()) {
        (Some(DisplacementArg::Error), _) | (None, MapKind::Distortion) => Displacement::Error,
        (Some(DisplacementArg::Correction), _) | (None, MapKind::Correction) => {
            Displacement::Correction
        }
    };
    let bounds = args.bounds.map_or(Ok(*model.bounds()), box_of)?;
    let outside = args.outside.into();
    let plan = FieldPlan::spanning(bounds, args.spacing, args.axis, displacement, outside)
        .context("--spacing and --box")?;
    let field = sample_field(model, &plan, &Shown::new("sampling").task)
        .with_context(|| args.environment.display().to_string())?;
    let axes = args.axes.into();
    output.write(|out| match kind {
        FileKind::Nrrd => nrrd::write(out, &field, axes),
        FileKind::Mha => mha::write(out, &field, axes),
        FileKind::Vti => vti::write(out, &field),
        FileKind::Csv => field_table::write(out, &field),
    })?;
    let mut lengths = field.lengths_mm();
    let missing = field.displacement_mm.len() - lengths.len();
    if missing > 0 && matches!(kind, FileKind::Nrrd | FileKind::Mha) {
        output::note(&format!(
            "{}: {} points are NaN, which 3D Slicer cannot move anything by; --outside clamp or a smaller --box leaves \
             fewer",
            args.output.display(),
            with_separators(missing)
        ));
    }
    let figures = FieldFigures {
        points: field.displacement_mm.len(),
        outside: field.is_outside.iter().filter(|is| **is).count(),
        missing,
        displacement_mm: Statistics::of(&mut lengths),
        field: &field,
    };
    match args.format {
        Format::Json => output::print_json(&figures.as_json()),
        Format::Text => output::print(&format!(
            "{}\n{}\nwritten to {}",
            figures.as_text(),
            plan.meaning(),
            args.output.display()
        )),
    }
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

fn kind_of(file: &Path) -> anyhow::Result<FileKind> {
    let kinds = [
        (".nrrd", FileKind::Nrrd),
        (".mha", FileKind::Mha),
        (".vti", FileKind::Vti),
        (".csv", FileKind::Csv),
    ];
    match kinds.iter().find(|(ending, _)| ends_with(file, ending)) {
        Some((_, kind)) => Ok(*kind),
        None => bail!(
            "{}: found no kind of file that a field can be written as, expected a name that ends with .nrrd, .mha, \
             .vti or .csv",
            file.display()
        ),
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

/// What was sampled, in figures.
struct FieldFigures<'a> {
    points: usize,
    outside: usize,
    missing: usize,
    displacement_mm: Option<Statistics>,
    field: &'a FieldLattice,
}

impl FieldFigures<'_> {
    fn as_json(&self) -> Value {
        let plan = &self.field.plan;
        let (min, max) = plan.bounds.into();
        json!({
            "points": self.points,
            "counts": plan.counts,
            "spacing_mm": plan.step_mm(),
            "box": [min, max],
            "displacement": match plan.displacement {
                Displacement::Error => "error",
                Displacement::Correction => "correction",
            },
            "outside": self.outside,
            "missing": self.missing,
            "displacement_mm": self.displacement_mm.map(|s| json!({"rms": s.rms(), "p95": s.p95(), "max": s.max()})),
        })
    }

    fn as_text(&self) -> String {
        let plan = &self.field.plan;
        let row =
            |label: &str, value: String, unit: &str| (label.to_owned(), value, unit.to_owned());
        let list = |values: [f64; 3]| values.map(|v| format!("{v:.3}")).join(" ");
        let [nx, ny, nz] = plan.counts;
        let mut rows = vec![
            row("points", format!("{nx} x {ny} x {nz}"), ""),
            row("step", list(plan.step_mm()), "mm"),
            row("from", list(plan.bounds.min_mm.coords.into()), "mm"),
            row("to", list(plan.bounds.max_mm.coords.into()), "mm"),
            row("outside the model's box", with_separators(self.outside), ""),
            row("without an answer", with_separators(self.missing), ""),
        ];
        if let Some(s) = &self.displacement_mm {
            rows.push(row("displacement, RMS", format!("{:.3}", s.rms()), "mm"));
            rows.push(row("displacement, largest", format!("{:.3}", s.max()), "mm"));
        }
        output::aligned(&rows)
    }
}
