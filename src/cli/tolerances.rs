//! `tolerances`: a design's manufacturing sheet, with how far off its sensors may be.

use super::prelude::*;
use super::simulate::note_world;
use trackwright_formats::manufacturing_table;
use trackwright_report::manufacturing::{built_check_words, sheet_section};
use trackwright_result::{Section, data};
use trackwright_simulation::tolerance::{MAX_DRAWS, check_built, manufacturing_sheet};

/// Print where a design's sensors are to be built, and how far off each may be before the
/// requirement fails
#[derive(Debug, Args)]
pub struct TolerancesArgs {
    /// Design (*.design.ron), or the name of a built-in one, with the requirement that a built tool has to meet
    design: PathBuf,

    /// Also draw so many tools with every sensor off at random within its tolerances, simulate each,
    /// and report how many meet the requirement; exit status 1 where one does not
    #[arg(long, value_name = "N", value_parser = draws)]
    check: Option<usize>,

    /// Seed of the draws: the same seed gives the same tools on any machine
    #[arg(long, value_name = "S", default_value_t = 0, requires = "check")]
    seed: u64,

    /// Table to write, one row a sensor
    #[arg(long, value_name = "OUT.csv")]
    csv: Option<PathBuf>,

    /// What happens to sensors outside the model's box; poses at which one is there as drawn are left
    /// out where they are rejected
    #[arg(long, value_parser = OUTSIDE, default_value = "clamp")]
    outside: OutsidePolicy,

    /// How to print the sheet
    #[arg(long, value_enum, default_value_t)]
    format: Format,
}

fn draws(text: &str) -> Result<usize, String> {
    let number = text.parse().ok();
    number
        .filter(|n| (1..=MAX_DRAWS).contains(n))
        .ok_or_else(|| format!("expected 1 to {MAX_DRAWS}"))
}

/// Finds the tolerances, checks them where requested, writes the table, and prints the sheet.
///
/// # Errors
/// Files that can't be used. A requirement that is missed, or anything else that leaves no tolerances,
/// is stated in the sheet.
pub fn run(args: &TolerancesArgs, files: &Files) -> anyhow::Result<Ending> {
    let csv = files.optional_output(args.csv.as_deref())?;
    let world = files.open_design(&args.design)?;
    let design = world.document.design();
    let mut scenario = trackwright_project::resolve(design, &world.environment);
    scenario.outside = args.outside;
    note_world(&world);
    let shown = Shown::new("looking for tolerances");
    let mut sheet = manufacturing_sheet(&scenario, &shown.task)
        .with_context(|| args.design.display().to_string())?;
    drop(shown);
    sheet.coils = trackwright_project::coil_findings(&world);
    output::note_outside(
        "poses have a sensor",
        sheet.study_outside,
        sheet.study_poses,
        scenario.outside,
    );
    let check = match args.check {
        None => None,
        Some(draws) => {
            let shown = Shown::new("drawing tools");
            check_built(&scenario, &sheet, draws, args.seed, &shown.task)
                .with_context(|| args.design.display().to_string())?
        }
    };
    if let Some(csv) = &csv {
        csv.write(|out| manufacturing_table::write(out, &sheet))?;
    }
    let found = Section::of([
        data("design", &design.name),
        data("environment", &world.environment.name),
        data("orientation_weight_mm", scenario.orientation_weight_mm),
        data("check", &check),
    ])
    .with(output::head(&design.name, &world.environment.name))
    .with_all(sheet_section(&sheet).items)
    .with_all(check.iter().flat_map(built_check_words));
    output::print_section(args.format, &found)?;
    if args.check.is_some() && check.is_none() {
        output::note("note: without tolerances there is nothing to check");
    }
    Ok(match check {
        Some(check) if !check.holds() => Ending::DoesNotHold,
        _ => Ending::Done,
    })
}
