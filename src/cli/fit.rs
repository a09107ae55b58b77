//! `fit`: measurements to an environment, and what the fit leaves.

use super::choose;
use super::jitter::JitterArgs;
use super::output::{self, Format, Shown};
use crate::field::environment::{HoldoutProvenance, Jitter, Provenance};
use crate::field::fit::{Factored, Fit, FitMethod, FitSettings, Residuals, factor, residuals};
use crate::field::model::OutsidePolicy;
use crate::field::samples::{MapKind, SampleSet};
use crate::field::support::SupportError;
use crate::field::{DistortionModel, Environment, Support};
use crate::geometry::directions::{DirectionSet, Weighting};
use crate::geometry::volume::Volume;
use crate::store::{self, SampleReading};
use crate::study::figures::with_separators;
use crate::task::Task;
use anyhow::Context;
use clap::{Args, ValueEnum};
use serde_json::{Value, json};
use std::path::{Path, PathBuf};

/// Part of a fit's time that reducing its samples takes, for its progress bar only.
const FACTORING_PART: f64 = 0.8;

#[derive(Debug, Args)]
pub struct FitArgs {
    /// Measurement table (CSV): ideal_x … ideal_qz, measured_x … measured_qz; mm, unit quaternions
    data: PathBuf,

    /// Environment to write (*.env.ron)
    #[arg(short, long, value_name = "ENV")]
    output: PathBuf,

    /// Order of the Bernstein polynomials; 0 is no correction. Chosen as `select` does where left out
    #[arg(long, value_name = "N", allow_negative_numbers = true)]
    order: Option<usize>,

    /// Number of basis orientations: 1, 6, 12, 14, 26 or 42; 1 ignores orientation. Chosen as
    /// `select` does where left out
    #[arg(long, value_name = "M", default_value_if("order", "0", "1"))]
    directions: Option<usize>,

    /// How the orientations share the samples
    #[arg(long, value_enum, default_value_t)]
    method: MethodArg,

    /// Which pose the error is a function of: the ideal one to simulate, the measured one to compensate
    #[arg(long, value_enum, default_value_t)]
    map: MapArg,

    /// What the table's quaternions mean
    #[arg(long, value_enum, default_value_t)]
    sensors: SensorsArg,

    /// How an axis is shared among the three orientations around it
    #[arg(long, value_enum, default_value_t)]
    weights: WeightsArg,

    /// Ridge, as a part of the largest singular value; 0, or chosen with order or directions where
    /// one of them is left out
    #[arg(long, value_name = "R")]
    ridge: Option<f64>,

    /// Singular values below this part of the largest count as zero
    #[arg(long, default_value = "1e-10", value_name = "R")]
    rcond: f64,

    /// Measurements that are not fitted, to judge the model on
    #[arg(long, value_name = "DATA2.csv")]
    holdout: Option<PathBuf>,

    /// The tracker's measurement volume, where it is known
    #[arg(long, value_enum)]
    volume: Option<VolumeArg>,

    /// Leave out what the environment says of where its model may be believed
    #[arg(long)]
    no_support: bool,

    #[command(flatten)]
    jitter: JitterArgs,

    /// How to print the figures
    #[arg(long, value_enum, default_value_t)]
    format: Format,
}

#[derive(Clone, Copy, Debug, Default, ValueEnum)]
pub(super) enum MethodArg {
    /// Each orientation by itself, the paper's
    #[default]
    PerDirection,
    /// All orientations at once
    Joint,
}

#[derive(Clone, Copy, Debug, Default, ValueEnum)]
pub(super) enum MapArg {
    #[default]
    Distortion,
    Correction,
}

#[derive(Clone, Copy, Debug, Default, ValueEnum)]
pub(super) enum SensorsArg {
    /// Only the sensors' local z was measured
    #[default]
    #[value(name = "5dof")]
    FiveDof,
    /// Full rotations were measured
    #[value(name = "6dof")]
    SixDof,
}

#[derive(Clone, Copy, Debug, Default, ValueEnum)]
pub(super) enum WeightsArg {
    /// Areas of spherical triangles, the paper's
    #[default]
    Area,
    /// Coordinates in the triangle's plane, continuous
    Gnomonic,
}

#[derive(Clone, Copy, Debug, ValueEnum)]
pub(super) enum VolumeArg {
    /// 500 mm in front of a planar generator
    AuroraCube,
}

/// A model's figures on measurements that it was not fitted to.
pub(super) struct Holdout {
    data: String,
    samples: usize,
    before: Residuals,
    after: Residuals,
}

/// Fits, writes the environment, and prints the residuals.
///
/// # Errors
/// Files that can't be used, settings that make no fit.
pub fn run(args: &FitArgs) -> anyhow::Result<()> {
    let asked = asked(args)?;
    let map = asked.map;
    let set = read(&args.data, args.sensors, map)?;
    let holdout_set = args
        .holdout
        .as_ref()
        .map(|f| read(f, args.sensors, map))
        .transpose()?;
    let (settings, chosen) = choose::settings(&args.data, &set, asked)?;
    let target = Target {
        data: &args.data,
        output: &args.output,
        volume: args.volume,
        jitter: args.jitter.jitter(),
        with_support: !args.no_support,
    };
    let holdout = args.holdout.as_deref().zip(holdout_set.as_ref());
    let (fitted, holdout) = fit_and_write(&target, &settings, &set, holdout)?;
    if let Some(chosen) = &chosen {
        output::note(&chosen.reason());
    }
    match args.format {
        Format::Json => {
            let mut value = as_json(&settings, &fitted, holdout.as_ref());
            if let Some(chosen) = &chosen {
                value["selection"] = chosen.as_json();
            }
            output::print_json(&value)
        }
        Format::Text => output::print(&as_text(&target, &settings, &fitted, holdout.as_ref())),
    }
}

/// Where measurements come from, and where their environment goes.
pub(super) struct Target<'a> {
    pub data: &'a Path,
    pub output: &'a Path,
    pub volume: Option<VolumeArg>,
    pub jitter: Option<Jitter>,
    /// Whether the environment says where its model may be believed.
    pub with_support: bool,
}

/// Fits, judges on a second table where there is one, writes the environment, and warns.
pub(super) fn fit_and_write(
    target: &Target,
    settings: &FitSettings,
    samples: &SampleSet,
    holdout: Option<(&Path, &SampleSet)>,
) -> anyhow::Result<(Fit, Option<Holdout>)> {
    let fitting = Shown::new("fitting");
    let (factored, fitted) = factor(
        samples,
        settings,
        None,
        &fitting.task.stretch(0.0, FACTORING_PART),
    )
    .and_then(|factored| {
        let task = fitting.task.stretch(FACTORING_PART, 1.0);
        let solved = factored.solve_with(settings.rcond, settings.ridge, &task)?;
        Ok((factored, solved.judged(samples)))
    })
    .with_context(|| target.data.display().to_string())?;
    drop(fitting);
    let support = match target.with_support {
        true => {
            let supporting = Shown::new("support");
            support(samples, &factored, &fitted, &supporting.task)?
        }
        false => None,
    };
    let holdout = holdout.map(|(file, set)| judge(&fitted.model, file, set));
    let mut environment = environment(target, &fitted, settings, holdout.as_ref());
    environment.support = support;
    store::write_environment(target.output, &environment)?;
    for warning in warnings(&fitted) {
        output::note(&format!("warning: {warning}"));
    }
    Ok((fitted, holdout))
}

/// What the command line says about the model, and what it leaves open.
fn asked(args: &FitArgs) -> anyhow::Result<choose::Asked> {
    Ok(choose::Asked {
        order: args.order,
        directions: args
            .directions
            .map(|m| DirectionSet::try_from(m).context("--directions"))
            .transpose()?,
        ridge: args.ridge,
        method: args.method.into(),
        map: args.map.into(),
        weighting: args.weights.into(),
        rcond: args.rcond,
    })
}

impl From<MethodArg> for FitMethod {
    fn from(arg: MethodArg) -> Self {
        match arg {
            MethodArg::PerDirection => Self::PerDirection,
            MethodArg::Joint => Self::Joint,
        }
    }
}

impl From<MapArg> for MapKind {
    fn from(arg: MapArg) -> Self {
        match arg {
            MapArg::Distortion => Self::Distortion,
            MapArg::Correction => Self::Correction,
        }
    }
}

impl From<WeightsArg> for Weighting {
    fn from(arg: WeightsArg) -> Self {
        match arg {
            WeightsArg::Area => Self::Area,
            WeightsArg::Gnomonic => Self::Gnomonic,
        }
    }
}

/// Reads a table as samples, with a progress bar.
///
/// # Errors
/// A file that can't be used.
pub(super) fn read(file: &Path, sensors: SensorsArg, map: MapKind) -> anyhow::Result<SampleSet> {
    let reading = SampleReading {
        has_rolls: matches!(sensors, SensorsArg::SixDof),
        map,
    };
    Ok(store::read_samples(
        file,
        reading,
        &Shown::new("reading").task,
    )?)
}

/// Where the model may be believed; one that is too large to keep is left out with a note.
fn support(
    samples: &SampleSet,
    factored: &Factored,
    fitted: &Fit,
    task: &Task,
) -> anyhow::Result<Option<Support>> {
    match Support::of_fit(samples, factored, &fitted.model, task) {
        Ok(support) => Ok(Some(support)),
        Err(SupportError::NoOrder) => Ok(None),
        Err(error @ (SupportError::TooLarge { .. } | SupportError::TooManyUnknowns { .. })) => {
            output::note(&format!(
                "note: {error}; the environment is written without it"
            ));
            Ok(None)
        }
        Err(error @ (SupportError::Cancelled(_) | SupportError::Fit(_))) => Err(error.into()),
    }
}

fn judge(model: &DistortionModel, file: &Path, samples: &SampleSet) -> Holdout {
    let zero = DistortionModel::zero(*model.bounds(), model.map());
    Holdout {
        data: file_name(file),
        samples: samples.samples.len(),
        before: residuals(&zero, samples, OutsidePolicy::Clamp),
        after: residuals(model, samples, OutsidePolicy::Clamp),
    }
}

fn environment(
    target: &Target,
    fitted: &Fit,
    settings: &FitSettings,
    holdout: Option<&Holdout>,
) -> Environment {
    Environment {
        name: stem(target.output),
        model: fitted.model.clone(),
        volume: target
            .volume
            .map(|VolumeArg::AuroraCube| Volume::AuroraCube),
        jitter: target.jitter,
        support: None,
        provenance: Some(Provenance {
            data: file_name(target.data),
            samples: fitted.samples,
            method: settings.method,
            ridge: settings.ridge,
            train_before: fitted.before,
            train_after: fitted.after,
            holdout: holdout.map(|h| HoldoutProvenance {
                data: h.data.clone(),
                samples: h.samples,
                before: h.before,
                after: h.after,
            }),
        }),
    }
}

/// A file's name without its folder.
pub(super) fn file_name(file: &Path) -> String {
    file.file_name()
        .map_or_else(String::new, |n| n.to_string_lossy().into_owned())
}

/// `room` of `folder/room.env.ron`.
fn stem(file: &Path) -> String {
    let name = file_name(file);
    let stem = name.strip_suffix(".ron").unwrap_or(&name);
    stem.strip_suffix(".env").unwrap_or(stem).to_owned()
}

fn warnings(fitted: &Fit) -> Vec<String> {
    let mut warnings = Vec::new();
    let few: Vec<_> = fitted
        .systems
        .iter()
        .filter(|s| s.is_underdetermined())
        .collect();
    if let Some(least) = few.iter().min_by_key(|s| s.samples) {
        warnings.push(format!(
            "{} of {} orientations have fewer samples than the {} coefficients, the least {}; \
             the solution of least norm was taken",
            few.len(),
            fitted.systems.len(),
            least.unknowns,
            with_separators(least.samples),
        ));
    }
    let deficient = fitted
        .systems
        .iter()
        .filter(|s| !s.is_underdetermined() && s.rank < s.unknowns)
        .count();
    if deficient > 0 {
        warnings.push(format!(
            "{deficient} of {} orientations do not determine all their coefficients; the solution \
             of least norm was taken",
            fitted.systems.len()
        ));
    }
    if fitted.ambiguous > 0 {
        warnings.push(format!(
            "{} samples have opposite axes, so that their orientation error is ambiguous",
            with_separators(fitted.ambiguous)
        ));
    }
    warnings
}

pub(super) fn method_name(method: FitMethod) -> &'static str {
    match method {
        FitMethod::PerDirection => "per-direction",
        FitMethod::Joint => "joint",
    }
}

pub(super) fn map_name(map: MapKind) -> &'static str {
    match map {
        MapKind::Distortion => "distortion",
        MapKind::Correction => "correction",
    }
}

pub(super) fn as_json(settings: &FitSettings, fitted: &Fit, holdout: Option<&Holdout>) -> Value {
    let residuals = |r: &Residuals| {
        json!({
            "position_rms_mm": r.position_rms_mm,
            "angle_rms_deg": r.angle_rms_rad.map(f64::to_degrees),
        })
    };
    let before_after =
        |before, after| json!({"before": residuals(before), "after": residuals(after)});
    let one_or_all = |values: Vec<Value>| match (settings.method, values.as_slice()) {
        (FitMethod::Joint, [one]) => one.clone(),
        _ => Value::Array(values),
    };
    let mut value = json!({
        "samples": fitted.samples,
        "order": settings.order,
        "directions": settings.directions.len(),
        "method": method_name(settings.method),
        "map": map_name(settings.map),
        "train": before_after(&fitted.before, &fitted.after),
        "holdout": holdout.map(|h| before_after(&h.before, &h.after)),
        "rank": one_or_all(fitted.systems.iter().map(|s| json!(s.rank)).collect()),
        "condition": one_or_all(fitted.systems.iter().map(|s| json!(s.condition)).collect()),
    });
    value["system_samples"] = one_or_all(fitted.systems.iter().map(|s| json!(s.samples)).collect());
    value["ambiguous"] = json!(fitted.ambiguous);
    value
}

fn as_text(
    target: &Target,
    settings: &FitSettings,
    fitted: &Fit,
    holdout: Option<&Holdout>,
) -> String {
    let mut lines = vec![format!(
        "{}: {} samples, order {}, {} orientation{}, {}, {} map",
        file_name(target.data),
        with_separators(fitted.samples),
        settings.order,
        settings.directions.len(),
        if settings.directions.len() == 1 {
            ""
        } else {
            "s"
        },
        method_name(settings.method),
        map_name(settings.map),
    )];
    lines.push(format!("{:<22}{:>12}  {:>12}", "", "before", "after"));
    let mut rows = |name: &str, before: &Residuals, after: &Residuals| {
        lines.push(format!(
            "{:<22}{:>9.4} mm  {:>9.4} mm",
            format!("{name} position RMS"),
            before.position_rms_mm,
            after.position_rms_mm
        ));
        if let (Some(b), Some(a)) = (before.angle_rms_rad, after.angle_rms_rad) {
            lines.push(format!(
                "{:<22}{:>9.4} °   {:>9.4} °",
                format!("{name} angle RMS"),
                b.to_degrees(),
                a.to_degrees()
            ));
        }
    };
    rows("trained", &fitted.before, &fitted.after);
    if let Some(h) = holdout {
        rows("held out", &h.before, &h.after);
    }
    if let (Some(least), Some(most)) = (
        fitted
            .systems
            .iter()
            .min_by(|a, b| a.condition.total_cmp(&b.condition)),
        fitted
            .systems
            .iter()
            .max_by(|a, b| a.condition.total_cmp(&b.condition)),
    ) {
        let rank = fitted.systems.iter().map(|s| s.rank).min().unwrap_or(0);
        let samples = fitted.systems.iter().map(|s| s.samples).min().unwrap_or(0);
        lines.push(format!(
            "least rank {rank} of {}, least samples {}, condition {:.1} to {:.1}",
            least.unknowns,
            with_separators(samples),
            least.condition,
            most.condition
        ));
    }
    lines.push(format!("written to {}", target.output.display()));
    lines.join("\n")
}
