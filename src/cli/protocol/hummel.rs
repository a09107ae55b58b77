//! `protocol hummel`: the plate of Hummel et al. in a room, or recorded.

use super::super::jitter::JitterArgs;
use super::super::numbers::{length_above_zero, six};
use super::super::prelude::*;
use super::super::tool_reader::ToolReader;
use super::rods::{RodArgs, Rods};
use std::sync::Arc;
use trackwright_calibration::protocol::evaluation::evaluate;
use trackwright_calibration::protocol::plate::{Plate, PlateReading, SensorKind};
use trackwright_calibration::protocol::readings::{
    PAPER_SAMPLES, SamplingSettings, simulate_readings,
};
use trackwright_calibration::protocol::table::ProtocolTable;
use trackwright_design::Day;
use trackwright_field::Environment;
use trackwright_field::samples::MapKind;
use trackwright_formats::plate_recording::{self, PlateContent, PlateRow};
use trackwright_formats::protocol_table;
use trackwright_geometry::pose::pose_from_parts;
use trackwright_geometry::rotation::exp_vector;
use trackwright_project::{builtin_rooms, room_name};
use trackwright_result::{Section, data};

#[derive(Debug, Args)]
pub struct HummelArgs {
    /// Environment (*.env.ron), or the name of the built-in one (operating-table)
    #[arg(required_unless_present = "recording", conflicts_with = "recording")]
    room: Option<PathBuf>,

    /// Table to write, a row a measure: count, mean, std, rms, min and max, and the paper's figures
    #[arg(short, long, value_name = "TABLE.csv")]
    output: PathBuf,

    /// Evaluate the recording of a real plate in place of a room (CSV): row and column of a hole, or
    /// angle_deg of the disc; level; rod and distance_mm beside a rod; and x, y, z, qw, qx, qy, qz of
    /// each reading, or recording, a tracker's file with the readings of that place
    #[arg(long, value_name = "FILE")]
    recording: Option<PathBuf>,

    /// The tool that is meant where a tracker's file has several: a part of its name
    #[arg(long, value_name = "NAME", requires = "recording")]
    tool: Option<String>,

    /// What the sensor's readings determine
    #[arg(long, value_parser = SENSOR, default_value = "5dof")]
    sensor: SensorKind,

    /// Rows of holes, 50 mm apart [default: 9, or as many as the room has space for]
    #[arg(long, value_name = "N", conflicts_with = "recording")]
    rows: Option<usize>,

    /// Columns of holes [default: 10, likewise]
    #[arg(long, value_name = "N", conflicts_with = "recording")]
    columns: Option<usize>,

    /// Levels of the plate [default: 3]
    #[arg(long, value_name = "N", conflicts_with = "recording")]
    levels: Option<usize>,

    /// Distance of levels [default: 100, or as much as the room has space for]
    #[arg(long, value_name = "MM", value_parser = length_above_zero, conflicts_with = "recording")]
    level_mm: Option<f64>,

    /// Positions of the disc, of equal angles; 0 for none [default: 32]
    #[arg(long, value_name = "N", conflicts_with = "recording")]
    steps: Option<usize>,

    /// Pose of the plate in the tracker frame: middle of the grid on level 0 in mm, then a rotation
    /// vector in degrees; in the middle of the room where left out
    #[arg(
        long,
        value_name = "X,Y,Z,RX,RY,RZ",
        allow_hyphen_values = true,
        value_parser = six,
        conflicts_with = "recording"
    )]
    plate: Option<[f64; 6]>,

    /// Readings at each place; one in a room without jitter
    #[arg(long, value_name = "N", default_value_t = PAPER_SAMPLES, conflicts_with = "recording")]
    samples: usize,

    /// Seed of the jitter: the same seed gives the same table on any machine
    #[arg(long, value_name = "S", default_value_t = 1, conflicts_with = "recording")]
    seed: u64,

    /// Recording to write: the simulated readings, for --recording
    #[arg(long, value_name = "OUT.csv", conflicts_with = "recording")]
    readings: Option<PathBuf>,

    /// Day of the run, which goes to the table and orders control charts
    #[arg(long, value_name = "YYYY-MM-DD")]
    date: Option<Day>,

    #[command(flatten)]
    jitter: JitterArgs,

    #[command(flatten)]
    rods: RodArgs,

    #[command(flatten)]
    common: TableArgs,
}

const SENSOR: Choice<SensorKind> = Choice(&[
    ("5dof", "A coil along z: a turn is that of its axis", SensorKind::FiveDof),
    ("6dof", "A whole pose", SensorKind::SixDof),
]);

/// What was simulated beside the readings.
struct Simulated {
    plate: Plate,
    rods: Option<Rods>,
}

/// Simulates or reads, evaluates, and writes the table.
///
/// # Errors
/// Files that can't be used, a plate that is not in the room, readings that are no run of the protocol.
pub fn run(args: &HummelArgs, files: &Files) -> anyhow::Result<()> {
    let output = files.output(&args.output)?;
    let readings_output = files.optional_output(args.readings.as_deref())?;
    let (source, readings, simulated) = match (&args.recording, &args.room) {
        (Some(file), _) => {
            if args.jitter.jitter().is_some() {
                bail!("--jitter-position-mm belongs to a simulated room, not to --recording");
            }
            (file_name(file), recorded(args, file, files)?, None)
        }
        (None, Some(file)) => {
            let room = read_room(file, files)?;
            let (readings, simulated) = simulated(args, &room, files)
                .with_context(|| format!("{}: no run of the protocol", file.display()))?;
            (room.name, readings, Some(simulated))
        }
        (None, None) => bail!("found no room, expected one, or --recording"),
    };
    let rows = evaluate(&readings, args.sensor).map_err(|error| match &args.recording {
        Some(file) => anyhow!("{}: no run of the protocol: {error}", file.display()),
        None => anyhow!("no run of the protocol: {error}"),
    })?;
    let date = args.date.map(|date| date.to_string());
    let table = ProtocolTable { source, date, rows };
    if let Some(readings_output) = &readings_output {
        readings_output.write(|out| plate_recording::write(out, &readings))?;
    }
    output.write(|out| protocol_table::write(out, &table))?;
    output::print_section(args.common.format, &section(args, &table, simulated.as_ref()))
}

/// A room by its file, or a built-in one where no file has that name.
fn read_room(file: &Path, files: &Files) -> anyhow::Result<Environment> {
    let is_named = |room: &trackwright_project::RoomSource| {
        room_name(Path::new(&room.file_name())) == file.to_string_lossy()
    };
    let environment = match builtin_rooms().find(|room| !file.exists() && is_named(room)) {
        Some(room) => Arc::unwrap_or_clone(room.read_solved()?),
        None => files.read_environment(file)?,
    };
    if environment.model.map() == MapKind::Correction {
        output::note(&format!(
            "note: {} is a correction map, a function of the measured pose; it is used as a distortion map",
            file.display()
        ));
    }
    Ok(environment)
}

fn simulated(
    args: &HummelArgs,
    room: &Environment,
    files: &Files,
) -> anyhow::Result<(Vec<PlateReading>, Simulated)> {
    let plate = plate(args, room)?;
    plate.check_inside(room)?;
    let jitter = args.jitter.jitter().or(room.jitter);
    if jitter.is_none() {
        output::note(
            "note: the room has no jitter, so that readings have none; --jitter-position-mm and --jitter-angle-deg \
             state it",
        );
    }
    let rods = args.rods.readings(files, &plate, args.sensor)?;
    let beside = rods.as_ref().map_or(&[][..], |rods| &rods.found.readings);
    let settings = SamplingSettings { samples: args.samples, seed: args.seed };
    let readings = simulate_readings(room, jitter.as_ref(), &plate, beside, &settings)?;
    Ok((readings, Simulated { plate, rods }))
}

/// The plate as it is stated, else as it fits.
fn plate(args: &HummelArgs, room: &Environment) -> anyhow::Result<Plate> {
    let mut plate = Plate::fitted(room)?;
    let middle_mm = 0.5 * (plate.levels as f64 - 1.0) * plate.level_mm;
    plate.rows = args.rows.unwrap_or(plate.rows);
    plate.columns = args.columns.unwrap_or(plate.columns);
    plate.levels = args.levels.unwrap_or(plate.levels);
    plate.level_mm = args.level_mm.unwrap_or(plate.level_mm);
    plate.steps = args.steps.unwrap_or(plate.steps);
    plate.check()?;
    match args.plate {
        Some([x, y, z, rx, ry, rz]) => {
            let turn_rad = [rx, ry, rz].map(f64::to_radians).into();
            plate.tracker_from_plate = pose_from_parts([x, y, z].into(), exp_vector(&turn_rad));
        }
        // Other levels keep the middle.
        None => {
            let height_mm = (plate.levels as f64 - 1.0) * plate.level_mm;
            plate.tracker_from_plate.translation.vector.z += middle_mm - 0.5 * height_mm;
        }
    }
    Ok(plate)
}

fn recorded(args: &HummelArgs, file: &Path, files: &Files) -> anyhow::Result<Vec<PlateReading>> {
    let rows = args.common.as_is.take(files.read_plate_recording(file)?)?;
    let folder = file.parent().unwrap_or(Path::new(""));
    let mut reader = ToolReader::of_tool(files, args.tool.as_deref(), args.common.as_is);
    let mut readings = Vec::with_capacity(rows.len());
    for PlateRow { site, content } in rows {
        match content {
            PlateContent::Pose(tracker_from_sensor) => {
                readings.push(PlateReading { site, tracker_from_sensor });
            }
            PlateContent::Recording(name) => {
                let poses = reader.read_all([folder.join(name).as_path()])?;
                readings.extend(poses.into_iter().map(|tracker_from_sensor| PlateReading {
                    site: site.clone(),
                    tracker_from_sensor,
                }));
            }
        }
    }
    Ok(readings)
}

fn section(args: &HummelArgs, table: &ProtocolTable, simulated: Option<&Simulated>) -> Section {
    let date = table.date.as_ref().map(|date| format!(", {date}")).unwrap_or_default();
    let mut found = Section::of([
        data("source", &table.source),
        data("date", &table.date),
        data("plate", ()),
        data("rods", ()),
    ])
    .with(output::head("Protocol of Hummel et al. 2005", &table.source) + &date);
    if let Some(Simulated { plate, rods }) = simulated {
        found = found.with(plate.section().named("plate")).with(plate.statement());
        if let Some(rods) = rods {
            found = found.with(rods.section().named("rods")).with_all(rods.lines());
        }
    }
    found.with(table.rows_table()).with(format!("written to {}", args.output.display()))
}
