//! `characterize`: from recordings of two trackers to a measurement table, with its quality.

use super::file_kinds::own_name;
use super::numbers::above_zero;
use super::prelude::*;
use clap::ValueEnum;
use trackwright_calibration::characterisation::{
    Characterisation, CharacterisationError, CharacterisationSettings, HeldOut, PairKind,
    RecordedPair, characterise,
};
use trackwright_calibration::hand_eye::HandEyeSettings;
use trackwright_calibration::robust::Loss;
use trackwright_calibration::still_pose::Spread;
use trackwright_calibration::time_alignment::AlignmentSettings;
use trackwright_formats::body::{self, BodyFile};
use trackwright_formats::characterised;
use trackwright_simulation::body::{RigidBody, Sensor};
use trackwright_simulation::mounting::Mounting;

/// Make a room's measurements from recordings of the tracker beside those of a reference tracker
#[derive(Debug, Args)]
pub struct CharacterizeArgs {
    /// Recordings of the EM tracker, with any number of 6-DOF sensors on one rigid body: tables of
    /// NDI Track or ToolBox (CSV, TSV) or of NDI's sample of the combined API, Aurora logs, PLUS
    /// sequences; mm
    #[arg(long, required = true, num_args = 1.., value_name = "FILE")]
    em: Vec<PathBuf>,

    /// Recordings of the reference tracker, which sees the same body; the k-th belongs to the k-th
    /// of --em
    #[arg(long, required = true, num_args = 1.., value_name = "FILE")]
    reference: Vec<PathBuf>,

    /// Measurement table to write, a row a pose and sensor: ideal_…, measured_…, sensor, pair, pose
    #[arg(short, long, value_name = "DATA.csv")]
    output: PathBuf,

    /// Sensors that count: parts of their names, comma-separated; all where left out
    #[arg(long, value_name = "NAMES", value_delimiter = ',')]
    sensors: Vec<String>,

    /// The body where the reference's recordings have several tools: a part of its name
    #[arg(long, value_name = "NAME")]
    reference_tool: Option<String>,

    /// What a pair of recordings is of: a pose to be averaged, or a path to be aligned in time
    #[arg(long, value_enum, default_value_t)]
    pairs: PairsArg,

    /// How fast a reading that is far off stops counting where the trackers are matched
    #[arg(long, value_parser = LOSS, default_value = "huber")]
    loss: Loss,

    /// What a reading's position is expected to be off by, a standard deviation an axis; taken from
    /// the readings where left out
    #[arg(long, value_name = "MM", value_parser = above_zero, requires = "scale_deg")]
    scale_mm: Option<f64>,

    /// What its rotation is expected to be off by, likewise
    #[arg(long, value_name = "DEG", value_parser = above_zero, requires = "scale_mm")]
    scale_deg: Option<f64>,

    /// Readings farther off are left out of the table
    #[arg(long, value_name = "MM", default_value_t = CharacterisationSettings::MAX_ERROR_MM, value_parser = above_zero)]
    max_error_mm: f64,

    /// Readings turned farther off are left out of the table
    #[arg(long, value_name = "DEG", default_value_t = CharacterisationSettings::MAX_ERROR_DEG, value_parser = above_zero)]
    max_error_deg: f64,

    /// Ticks a second of the EM tracker's frame counter, for paths in files without times
    #[arg(long, value_name = "HZ", default_value_t = CharacterisationSettings::TRACKER_TICKS_PER_S, value_parser = above_zero)]
    em_tick_hz: f64,

    /// Ticks a second of the reference tracker's frame counter, likewise
    #[arg(long, value_name = "HZ", default_value_t = CharacterisationSettings::REFERENCE_TICKS_PER_S, value_parser = above_zero)]
    reference_tick_hz: f64,

    /// Longest time between two samples of a path that poses are interpolated across
    #[arg(long, value_name = "S", default_value_t = AlignmentSettings::MAX_GAP_S, value_parser = above_zero)]
    max_gap_s: f64,

    /// Fewest poses that are accepted; 3 are needed. A path counts as one a second
    #[arg(long, value_name = "COUNT", default_value_t = HandEyeSettings::MIN_POSES)]
    min_poses: usize,

    /// Least RMS turn about the axis that the body turned about least
    #[arg(long, value_name = "DEG", default_value_t = HandEyeSettings::MIN_TURN_DEG, value_parser = above_zero)]
    min_turn_deg: f64,

    /// Leaves every N-th pair out of all that is found, beginning with the K-th, so that a room made
    /// of the table can be judged by them: 1/5, 2/5 and so on hold each pair out once
    #[arg(long, value_name = "K/N", requires = "held_out", value_parser = part)]
    hold_out: Option<HeldOut>,

    /// Measurement table to write those pairs to, judged by where the others put trackers and sensors;
    /// for `fit --holdout`
    #[arg(long, value_name = "HELD.csv", requires = "hold_out")]
    held_out: Option<PathBuf>,

    #[command(flatten)]
    as_is: AsIsArgs,

    /// Body file to write (*.body.ron): the sensors where they were found on the body, in the frame that the
    /// reference tracker reports; the tip, which nothing measures, is left out
    #[arg(long, value_name = "OUT.body.ron")]
    body: Option<PathBuf>,

    /// How to print the figures
    #[arg(long, value_enum, default_value_t)]
    format: Format,
}

/// `1/5` and so on.
fn part(text: &str) -> Result<HeldOut, String> {
    let numbers = text.split_once('/').and_then(|(part, of)| {
        let (part, of): (usize, usize) = (part.trim().parse().ok()?, of.trim().parse().ok()?);
        (1 <= part && part <= of && of >= 2).then_some((part, of))
    });
    match numbers {
        Some((part, of)) => Ok(HeldOut { part: part - 1, of }),
        None => Err("expected K/N with 1 ≤ K ≤ N and two parts at least, such as 1/5".to_owned()),
    }
}

/// What pairs of recordings are of.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, ValueEnum)]
enum PairsArg {
    /// Still where the reference stayed in its place, else a path
    #[default]
    Auto,
    /// All are of still poses
    Still,
    /// All are paths
    Path,
}

const LOSS: Choice<Loss> = Choice(&[
    ("huber", "Its pull is bounded", Loss::Huber),
    ("cauchy", "Its pull fades with its distance", Loss::Cauchy),
    ("tukey", "Beyond six standard deviations it has none", Loss::Tukey),
]);

/// Reads, characterises, and writes the table.
///
/// # Errors
/// Files that can't be used, and recordings that cannot answer, with the reason.
pub fn run(args: &CharacterizeArgs, files: &Files) -> anyhow::Result<()> {
    let output = files.output(&args.output)?;
    let body_output = files.optional_output(args.body.as_deref())?;
    let held_out_output = files.optional_output(args.held_out.as_deref())?;
    if args.em.len() != args.reference.len() {
        bail!(
            "--em names {} recordings and --reference {}, expected as many of one as of the other: the k-th of each \
             belong together",
            args.em.len(),
            args.reference.len()
        );
    }
    let shown = Shown::new("characterizing");
    let reading = shown.task.subtask(0.0, 0.5);
    let (mut trackers, mut references) = (Vec::new(), Vec::new());
    for (index, (em, reference)) in args.em.iter().zip(&args.reference).enumerate() {
        reading.step(index, args.em.len())?;
        trackers.push(files.read_recording(em)?);
        references.push(files.read_recording(reference)?);
    }
    let trackers = args.as_is.take_all(trackers)?.into_iter();
    let references = args.as_is.take_all(references)?;
    let pairs: Vec<_> = trackers
        .zip(references)
        .map(|(tracker, reference)| RecordedPair { tracker, reference })
        .collect();
    let task = shown.task.subtask(0.5, 1.0);
    let found = characterise(&pairs, &settings(args), &task).map_err(|error| match error {
        CharacterisationError::ReferenceTool { pair, cause } => {
            anyhow!("{}: {cause}", args.reference[pair].display())
        }
        other => output::refused("no measurements", &other),
    })?;
    drop(shown);
    if args.held_out.is_some() && found.held_out.is_empty() {
        bail!(
            "--hold-out: found no good reading in the pairs that it holds out, of {}",
            args.em.len()
        );
    }
    output.write(|out| characterised::write(out, &found, &found.readings))?;
    if let Some(held_out) = &held_out_output {
        held_out.write(|out| characterised::write(out, &found, &found.held_out))?;
        output::note(&format!(
            "{} readings held out, written to {}; all figures are of the others",
            with_separators(found.held_out.len()),
            held_out.file().display()
        ));
    }
    if let Some(body_output) = &body_output {
        let text = body::write(&body_of(body_output.file(), &found));
        body_output.write_bytes(text.as_bytes())?;
    }
    for (pair, problem) in found.rejected() {
        output::note(&format!(
            "{} with {}: not used: {problem}",
            args.em[pair].display(),
            args.reference[pair].display()
        ));
    }
    let found = found.section().with(format!("written to {}", args.output.display()));
    output::print_section(args.format, &found)
}

/// The body that the sensors were on.
fn body_of(file: &Path, found: &Characterisation) -> BodyFile {
    let sensors = found.sensors.iter().zip(&found.hand_eye.body_from_sensor);
    let sensors = sensors.map(|(name, body_from_sensor)| {
        Sensor::six_dof(name, body_from_sensor.translation.vector, body_from_sensor.rotation)
    });
    BodyFile {
        rigid: RigidBody {
            name: own_name(file, ".body.ron"),
            tip_in_body: None,
            sensors: sensors.collect(),
        },
        mesh: None,
        definition: None,
        mounting: Mounting::default(),
    }
}

fn settings(args: &CharacterizeArgs) -> CharacterisationSettings {
    let scale = args.scale_mm.zip(args.scale_deg);
    CharacterisationSettings {
        hand_eye: HandEyeSettings {
            loss: args.loss,
            scale: scale.map(|(position_mm, angle_deg)| Spread {
                position_mm,
                angle_rad: angle_deg.to_radians(),
            }),
            min_poses: args.min_poses,
            min_turn_rad: args.min_turn_deg.to_radians(),
        },
        kind: match args.pairs {
            PairsArg::Auto => None,
            PairsArg::Still => Some(PairKind::Still),
            PairsArg::Path => Some(PairKind::Path),
        },
        sensors: args.sensors.clone(),
        reference_tool: args.reference_tool.clone(),
        tracker_ticks_per_s: args.em_tick_hz,
        reference_ticks_per_s: args.reference_tick_hz,
        alignment: AlignmentSettings { max_gap_s: args.max_gap_s },
        max_error: Spread {
            position_mm: args.max_error_mm,
            angle_rad: args.max_error_deg.to_radians(),
        },
        held_out: args.hold_out,
    }
}
