//! `compare`: designs beside each other in one room or several, and what of their differences is one.

use super::named_design::note_sizes;
use super::numbers::zero_or_more;
use super::prelude::*;
use trackwright_design::Design;
use trackwright_field::samples::MapKind;
use trackwright_formats::comparison_table::{self, Names};
use trackwright_project::{ComparedDesign, ComparedRoom, ComparedRooms};
use trackwright_report::comparison::comparison_section;
use trackwright_simulation::comparison::{LEAST_DEG, LEAST_MM, Least, Settings, compare};

/// Hold designs against each other in one room or several, and report which differences are more
/// than the room's uncertainty and the sampling of the motion
#[derive(Debug, Args)]
pub struct CompareArgs {
    /// Designs (*.design.ron); each is simulated over its range of motion, or where it has none at its
    /// own pose
    #[arg(required = true, value_name = "DESIGN")]
    designs: Vec<PathBuf>,

    /// Rooms (*.env.ron) that every design is simulated in; without any, each design is in its own
    #[arg(long, value_name = "ENV", num_args = 1..)]
    environment: Vec<PathBuf>,

    /// The design that the others are held against, by its file or its name; the first where none is
    /// named
    #[arg(long, value_name = "DESIGN")]
    baseline: Option<PathBuf>,

    /// What happens to sensors outside the model's box; rejected trials are left out and counted
    #[arg(long, value_parser = OUTSIDE, default_value = "clamp")]
    outside: OutsidePolicy,

    /// Difference of tip errors below which there is none that matters
    #[arg(long, value_name = "MM", default_value_t = LEAST_MM, value_parser = zero_or_more)]
    least_mm: f64,

    /// Likewise of angles
    #[arg(long, value_name = "DEG", default_value_t = LEAST_DEG, value_parser = zero_or_more)]
    least_deg: f64,

    /// Seed of the fields that a room might as well have, and of the poses between those of the grid
    #[arg(long, default_value_t = 0)]
    seed: u64,

    /// Table to write, one row a design and room
    #[arg(long, value_name = "OUT.csv")]
    csv: Option<PathBuf>,

    /// How to print the comparison
    #[arg(long, value_enum, default_value_t)]
    format: Format,
}

/// Reads, simulates, and prints a row for every design in every room.
///
/// # Errors
/// Files that can't be used, a design named twice, a baseline that is none of the designs.
pub fn run(args: &CompareArgs, files: &Files) -> anyhow::Result<()> {
    let csv = files.optional_output(args.csv.as_deref())?;
    named_once(&args.designs, "design")?;
    named_once(&args.environment, "environment")?;
    let designs = trackwright_project::read_compared_designs(files, &args.designs)?;
    for compared in &designs {
        note_sizes(&compared.design);
    }
    let baseline = match &args.baseline {
        None => 0,
        Some(named) => baseline(named, &designs)?,
    };
    let own_rooms: Vec<PathBuf> = designs.iter().map(|d| d.own_room.clone()).collect();
    let is_own = args.environment.is_empty();
    let rooms = match is_own {
        true => &own_rooms,
        false => &args.environment,
    };
    let ComparedRooms { rooms, of_file } = trackwright_project::read_compared_rooms(files, rooms)?;
    let of_design = |design: usize| match is_own {
        true => vec![of_file[design]],
        false => (0..rooms.len()).collect(),
    };
    let all: Vec<&Design> = designs.iter().map(|d| &d.design).collect();
    let plan = trackwright_project::comparison_plan(
        &all,
        rooms.iter().map(|r| r.environment.clone()).collect(),
        of_design,
        baseline,
        args.outside,
    );
    for ComparedRoom { file, environment } in &rooms {
        if environment.model.map() == MapKind::Correction {
            output::note(&format!(
                "note: {} is a correction map, a function of the measured pose; it is used as a distortion map",
                file.display()
            ));
        }
    }
    let settings = Settings {
        least: Least { mm: args.least_mm, deg: args.least_deg },
        seed: args.seed,
        ..Settings::default()
    };
    let shown = Shown::new("comparing");
    let found = compare(&plan, &settings, &shown.task)?;
    drop(shown);
    let names = Names::new(
        (designs.iter()).map(|d| (d.file.display().to_string(), d.design.name.as_str())),
        (rooms.iter()).map(|r| (r.file.display().to_string(), r.environment.name.as_str())),
    );
    if let Some(csv) = &csv {
        csv.write(|out| comparison_table::write(out, &found, &names))?;
    }
    output::print_section(args.format, &comparison_section(&found, &names))
}

/// # Errors
/// The second of two names of one file.
pub(super) fn named_once(files: &[PathBuf], what: &str) -> anyhow::Result<()> {
    for (number, file) in files.iter().enumerate() {
        if let Some(first) =
            files[..number].iter().find(|first| trackwright_project::is_same_file(first, file))
        {
            bail!(
                "{}: found the same {what} named twice (as {} before), expected each once",
                file.display(),
                first.display()
            );
        }
    }
    Ok(())
}

/// The number of the design that is meant.
fn baseline(named: &Path, designs: &[ComparedDesign]) -> anyhow::Result<usize> {
    let by_file = designs.iter().position(|d| trackwright_project::is_same_file(&d.file, named));
    if let Some(number) = by_file {
        return Ok(number);
    }
    let mut by_name = (0..designs.len()).filter(|&d| Path::new(&designs[d].design.name) == named);
    match (by_name.next(), by_name.next()) {
        (Some(number), None) => return Ok(number),
        (Some(_), Some(_)) => bail!(
            "--baseline {}: found several designs of this name, expected the file of one",
            named.display()
        ),
        (None, _) => {}
    }
    let files: Vec<String> = designs.iter().map(|d| d.file.display().to_string()).collect();
    let found = match named.exists() {
        true => "a design that is not compared",
        false => "no such file, and no design of this name",
    };
    bail!("--baseline {}: found {found}, expected one of {}", named.display(), files.join(", "))
}
