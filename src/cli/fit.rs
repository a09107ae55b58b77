//! `fit`: measurements to an environment, and what the fit leaves.

use super::choose;
use super::jitter::JitterArgs;
use super::model_kind::ModelArgs;
use super::prelude::*;
use super::registration::RegistrationArgs;
use clap::{ArgAction, ValueEnum};
use trackwright_calibration::kind_choice::{Decided, TriedKind, Wanted};
use trackwright_calibration::room_choice::ModelRequest;
use trackwright_calibration::room_fit::{
    FittedRoom, RegistrationError, RoomError, RoomOrder, RoomStage, RoomTable, fit_room,
};
use trackwright_calibration::room_model::RoomModel;
use trackwright_calibration::row_labels::HeldOut;
use trackwright_field::computed::ModelKind;
use trackwright_field::environment::Jitter;
use trackwright_field::fit::{FitMethod, FitSettings};
use trackwright_field::samples::{MapKind, SampleSet};
use trackwright_field::selection::sensors::SensorSpread;
use trackwright_geometry::directions::{DirectionSet, Weighting};
use trackwright_geometry::volume::Volume;
use trackwright_project::{MOST_LAG_ROWS, MOST_SENSOR_OFFSET_MM, Output, SampleReading};
use trackwright_report::room::{fit_warnings, support_note};
use trackwright_report::selection_section::decided_section;

/// Fit a distortion model to measurements and write it as an environment
#[derive(Debug, Args)]
pub struct FitArgs {
    /// Measurement table (CSV): ideal_x … ideal_qz, measured_x … measured_qz; mm, unit quaternions
    data: PathBuf,

    /// Environment to write (*.env.ron)
    #[arg(short, long, value_name = "ENV")]
    output: PathBuf,

    #[command(flatten)]
    model: ModelArgs,

    /// Order of the Bernstein polynomials; 0 is no correction. Chosen as `select` does where left out
    #[arg(long, value_name = "N", allow_negative_numbers = true)]
    order: Option<usize>,

    /// Number of basis orientations: 1, 6, 12, 14, 26 or 42; 1 ignores orientation. Chosen as
    /// `select` does where left out
    #[arg(long, value_name = "M", default_value_if("order", "0", "1"))]
    directions: Option<usize>,

    #[command(flatten)]
    fitting: FittingArgs,

    /// Ridge, as a part of the largest singular value. Of Bernstein polynomials 0, or chosen with order or
    /// directions where one of them is left out; of a harmonic model chosen with the kind, or 1e-6 where the
    /// kind is named
    #[arg(long, value_name = "R")]
    ridge: Option<f64>,

    /// Measurements that are not fitted, to judge the model on
    #[arg(long, value_name = "DATA2.csv")]
    holdout: Option<PathBuf>,

    /// What is held out of the table itself to choose a model by, as `select` does: rows, groups,
    /// sensors, or a column whose rows with equal text belong together. A model with nothing left
    /// open is judged by it as well
    #[arg(long, value_name = "rows|groups|sensors|COLUMN")]
    hold_out: Option<HeldOut>,

    /// The tracker's measurement volume, where it is known
    #[arg(long, value_enum, default_value_t)]
    volume: VolumeArg,

    /// Leave out what the environment keeps of how far its field may be off: the model's standard
    /// error and the measurements
    #[arg(long)]
    no_support: bool,

    #[command(flatten)]
    jitter: JitterArgs,

    #[command(flatten)]
    registration: RegistrationArgs,

    #[command(flatten)]
    common: TableArgs,
}

const METHOD: Choice<FitMethod> = Choice(&[
    ("per-direction", "Each orientation by itself, the paper's", FitMethod::PerDirection),
    ("joint", "All orientations at once", FitMethod::Joint),
]);
const MAP: Choice<MapKind> =
    Choice(&[("distortion", "", MapKind::Distortion), ("correction", "", MapKind::Correction)]);
const WEIGHTS: Choice<Weighting> = Choice(&[
    ("area", "Areas of spherical triangles, the paper's", Weighting::Area),
    ("gnomonic", "Coordinates in the triangle's plane, continuous", Weighting::Gnomonic),
]);
pub(super) const HAS_ROLLS: Choice<bool> = Choice(&[
    ("5dof", "Only the sensors' local z was measured", false),
    ("6dof", "Full rotations were measured", true),
]);

/// How a table is read, and how polynomials are fitted to it.
#[derive(Args, Clone, Copy, Debug)]
pub(super) struct FittingArgs {
    /// How the orientations share the samples
    #[arg(long, value_parser = METHOD, default_value = "per-direction")]
    pub method: FitMethod,

    /// Which pose the error is a function of: the ideal one to simulate, the measured one to compensate
    #[arg(long, value_parser = MAP, default_value = "distortion")]
    pub map: MapKind,

    /// What the table's quaternions mean
    #[arg(long = "sensors", value_name = "SENSORS", value_parser = HAS_ROLLS, default_value = "5dof",
        action = ArgAction::Set)]
    pub has_rolls: bool,

    /// Rows that the measured side is behind the ideal one, as a warning states it; each reading is put
    /// beside the ideal pose of that moment
    #[arg(long, default_value = "0", value_name = "ROWS", allow_negative_numbers = true)]
    pub lag: f64,

    /// How far measured positions are along the sensor's z axis from ideal ones, as a warning states it: one
    /// side of the tip, the other of the coil. It is taken out
    #[arg(long, default_value = "0", value_name = "MM", allow_negative_numbers = true)]
    pub sensor_offset: f64,

    /// How an axis is shared among the three orientations around it
    #[arg(long, value_parser = WEIGHTS, default_value = "area")]
    pub weights: Weighting,

    /// Singular values below this part of the largest count as zero
    #[arg(long, default_value = "1e-10", value_name = "R")]
    pub rcond: f64,
}

impl FittingArgs {
    /// How the table is read.
    ///
    /// # Errors
    /// A lag or an offset that is not one.
    pub(super) fn reading(&self) -> anyhow::Result<SampleReading> {
        let Self { has_rolls, map, lag, sensor_offset, .. } = *self;
        let within = |option: &str, found: f64, most: f64, unit: &str| match found.abs() <= most {
            true => Ok(found),
            false => bail!("{option}: found {found}, expected -{most} to {most} {unit}"),
        };
        Ok(SampleReading {
            has_rolls,
            map,
            lag_rows: within("--lag", lag, MOST_LAG_ROWS, "rows")?,
            sensor_offset_mm: within(
                "--sensor-offset",
                sensor_offset,
                MOST_SENSOR_OFFSET_MM,
                "mm",
            )?,
        })
    }

    /// The options of polynomials, and whether each is other than usual.
    pub(super) fn of_polynomials(&self) -> [(&'static str, bool); 3] {
        [
            ("--method", self.method != FitMethod::default()),
            ("--weights", self.weights != Weighting::default()),
            ("--rcond", self.rcond.to_bits() != DEFAULT_RCOND.to_bits()),
        ]
    }
}

#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, ValueEnum)]
pub(super) enum VolumeArg {
    /// 500 mm in front of a planar Aurora generator
    #[value(alias = "aurora-cube")]
    Cube,
    /// 960 mm across and 610 mm deep in front of a planar Aurora generator
    Dome,
    /// 420 by 600 mm above an Aurora tabletop generator
    Tabletop,
    /// 220 mm across in front of a compact Aurora generator
    Compact,
    /// Not known: nothing counts as out of it
    #[default]
    None,
}

impl From<VolumeArg> for Option<Volume> {
    fn from(arg: VolumeArg) -> Self {
        match arg {
            VolumeArg::Cube => Some(Volume::AuroraCube),
            VolumeArg::Dome => Some(Volume::AuroraDome),
            VolumeArg::Tabletop => Some(Volume::AuroraTabletop),
            VolumeArg::Compact => Some(Volume::AuroraCompact),
            VolumeArg::None => None,
        }
    }
}

/// Singular values that count as zero by default, as the option has it in text.
const DEFAULT_RCOND: f64 = 1e-10;

/// Fits, writes the environment, and prints the residuals.
///
/// # Errors
/// Files that can't be used, a hold-out that is fitted as well, settings that make no fit.
pub fn run(args: &FitArgs, files: &Files) -> anyhow::Result<()> {
    let output = files.output(&args.output)?;
    output.expect_own()?;
    let request = model_request(args)?;
    let map = request.map;
    let kind = args.model.kind(has_polynomial_options(args))?;
    let model = kind.map(|kind| args.model.model(kind, args.ridge, files)).transpose()?;
    if let Some(kind) = kind {
        refuse_what_others_have(args, kind)?;
    }
    if args.no_support && args.registration.error().is_some() {
        bail!("--registration-mm is for what --no-support leaves out, expected one of them");
    }
    let reading = args.fitting.reading()?;
    let set = read(files, &args.data, reading, args.common.as_is)?;
    let holdout_set =
        args.holdout.as_ref().map(|f| read(files, f, reading, args.common.as_is)).transpose()?;
    let wanted = match model {
        Some(model) => Wanted::One(model),
        None => {
            let mut kinds = TriedKind::all(&set, map);
            // It is made of what is to be left out.
            kinds.retain(|kind| !(args.no_support && *kind == TriedKind::Kriging));
            Wanted::Best(kinds)
        }
    };
    let hold_out = args.hold_out.as_ref();
    let decided = choose::decided(files, &args.data, &set, (&wanted, &request), hold_out)?;
    let Decided { model, settings, .. } = &decided;
    let target = Target {
        data: &args.data,
        output: &output,
        volume: args.volume,
        jitter: args.jitter.jitter(),
        registration: args.registration.error(),
        with_support: !args.no_support,
        sensors: decided.sensors(),
    };
    let holdout = args.holdout.as_deref().zip(holdout_set.as_ref());
    let room = fit_and_write(&target, model, settings, &set, holdout)?;
    if let Some((_, set)) = holdout {
        let bounds = room.environment.model.bounds();
        let outside = (set.samples.iter()).filter(|sample| !bounds.contains(&sample.position_mm));
        let count = outside.count();
        output::note_outside(
            "held-out samples are",
            count,
            set.samples.len(),
            OutsidePolicy::Clamp,
        );
    }
    let found = decided_section(&file_name(&args.data), &decided, &room)
        .with(format!("written to {}", output.file().display()));
    output::print_section(args.common.format, &found)
}

/// Where measurements come from, and where their environment goes.
pub(super) struct Target<'a> {
    pub data: &'a Path,
    pub output: &'a Output<'a>,
    pub volume: VolumeArg,
    pub jitter: Option<Jitter>,
    pub registration: Option<RegistrationError>,
    /// Whether the environment keeps model validity.
    pub with_support: bool,
    /// What sensors differ by among themselves, where they were held out.
    pub sensors: Option<SensorSpread>,
}

/// Fits, judges on a second table where there is one, writes the environment, and warns.
pub(super) fn fit_and_write(
    target: &Target,
    model: &RoomModel,
    settings: &FitSettings,
    samples: &SampleSet,
    holdout: Option<(&Path, &SampleSet)>,
) -> anyhow::Result<FittedRoom> {
    let (table, held_out) =
        (file_name(target.data), holdout.map(|(file, set)| (file_name(file), set)));
    let order = RoomOrder {
        name: &trackwright_project::room_name(target.output.file()),
        table: RoomTable { name: &table, samples },
        held_out: held_out.as_ref().map(|(name, samples)| RoomTable { name, samples }),
        model,
        settings: *settings,
        bounds: None,
        volume: target.volume.into(),
        jitter: target.jitter,
        registration: target.registration,
        with_support: target.with_support,
        sensors: target.sensors,
    };
    let mut shown = None;
    let room = fit_room(&order, |stage| {
        // The bar of the stage before goes first.
        shown = None;
        let bar = Shown::new(match stage {
            RoomStage::Fitting => "fitting",
            RoomStage::FitValidity => "support",
            RoomStage::Process => "what the measurements leave open",
        });
        let task = bar.task.clone();
        shown = Some(bar);
        task
    });
    drop(shown);
    let named = || target.data.display().to_string();
    let room = match room {
        Err(RoomError::Fit(error)) => Err(error).with_context(named)?,
        Err(RoomError::Model(error)) => Err(error).with_context(named)?,
        other => other?,
    };
    if let Some(why) = &room.support_left_out {
        output::note(&format!("note: {}", support_note(why)));
    }
    target.output.write_environment(&room.environment)?;
    for warning in fit_warnings(&room.fit) {
        output::note(&format!("warning: {warning}"));
    }
    Ok(room)
}

/// Whether an option is given that only polynomials have.
fn has_polynomial_options(args: &FitArgs) -> bool {
    args.order.is_some()
        || args.directions.is_some()
        || args.ridge.is_some()
        || args.fitting.of_polynomials().iter().any(|(_, is_given)| *is_given)
}

/// Options of polynomials beside another kind of model.
fn refuse_what_others_have(args: &FitArgs, kind: ModelKind) -> anyhow::Result<()> {
    let has_ridge = matches!(kind, ModelKind::Bernstein | ModelKind::Harmonic);
    let of_size = [
        ("--order", args.order.is_some()),
        ("--directions", args.directions.is_some()),
        ("--ridge", args.ridge.is_some() && !has_ridge),
    ];
    let others = [
        ("--hold-out", args.hold_out.is_some()),
        ("--no-support", args.no_support && kind == ModelKind::Kriging),
    ];
    let mut given = of_size.into_iter().chain(args.fitting.of_polynomials()).chain(others);
    match given.find(|(_, is_given)| *is_given) {
        Some((name, _)) if kind != ModelKind::Bernstein => bail!(
            "{name} does not go with --model {}{}",
            kind.name(),
            match name {
                "--hold-out" => "; select --models tries kinds of models on rows held out",
                "--no-support" => ", which is made of the measurements",
                _ => "",
            }
        ),
        _ => Ok(()),
    }
}

/// What the command line states about the model, and what it leaves open.
fn model_request(args: &FitArgs) -> anyhow::Result<ModelRequest> {
    Ok(ModelRequest {
        order: args.order,
        directions: args
            .directions
            .map(|m| DirectionSet::try_from(m).context("--directions"))
            .transpose()?,
        ridge: args.ridge,
        method: args.fitting.method,
        map: args.fitting.map,
        weighting: args.fitting.weights,
        rcond: args.fitting.rcond,
    })
}

/// Reads a table as samples, with a progress bar.
///
/// # Errors
/// A file that can't be used, or is not what it is read as.
pub(super) fn read(
    files: &Files,
    file: &Path,
    reading: SampleReading,
    as_is: AsIsArgs,
) -> anyhow::Result<SampleSet> {
    as_is.take(files.read_samples(file, reading, &Shown::new("reading").task)?)
}
