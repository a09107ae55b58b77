//! `procedure`: where a design stands in the paper's design procedure, and what is decided in it.

use super::numbers::zero_or_more;
use super::prelude::*;
use super::simulate::note_world;
use super::verify::FRAME;
use trackwright_calibration::agreement::{BuiltRecording, RecordedFrame};
use trackwright_design::{Decision, Edit, Origin, ProcedureEdit};
use trackwright_procedure::{Step, StepStatus};
use trackwright_project::{ProcedureRequest, StoreError, World};
use trackwright_report::procedure::procedure_section;

/// Times that a design is judged while others save it. Each time somebody else got on, so that this
/// many are always enough but for a program that does nothing but save.
const ATTEMPTS: usize = 100;

/// Report where a design stands in the design procedure: the CRF alone, the tool, the built tool,
/// each in its rooms and against its requirement; and keep what is decided in the design
#[derive(Debug, Args)]
pub struct ProcedureArgs {
    /// Design (*.design.ron), or the name of a built-in one
    design: PathBuf,

    /// Further rooms (*.env.ron) to look at the design in, this once
    #[arg(long, value_name = "ENV", num_args = 1.., conflicts_with = "decide")]
    environment: Vec<PathBuf>,

    /// Rooms that the design is judged in from now on, beside its own
    #[arg(long, value_name = "ENV", num_args = 1..)]
    add_room: Vec<PathBuf>,

    /// Rooms that the design is judged in no more
    #[arg(long, value_name = "ENV", num_args = 1..)]
    remove_room: Vec<PathBuf>,

    /// What was recorded of the built tool: a table with its true and its measured poses, as `verify`
    /// takes it. Without it the recording that was decided on is looked at again
    #[arg(long, value_name = "RECORDED.csv")]
    built: Option<PathBuf>,

    /// The same table of the CRF
    #[arg(long, value_name = "CRF.csv", requires = "built")]
    crf: Option<PathBuf>,

    /// Frame of a table's poses
    #[arg(long, value_parser = FRAME, default_value = "tracker", requires = "built", conflicts_with = "crf")]
    frame: RecordedFrame,

    /// The true poses were registered to this very recording, as `characterize` does
    #[arg(long, requires = "built")]
    registered: bool,

    /// The sensor of the table that is the whole tool: a part of its name
    #[arg(long, value_name = "NAME", requires = "built")]
    tool: Option<String>,

    /// Readings that each recorded pose is the mean of
    #[arg(long, value_name = "COUNT", default_value_t = 1, requires = "built",
        value_parser = clap::value_parser!(u32).range(1..))]
    averaged: u32,

    /// Standard deviation of the true position of the tip, an axis
    #[arg(long, value_name = "MM", default_value_t = 0.0, requires = "built", value_parser = zero_or_more)]
    truth_mm: f64,

    /// Decide that a step is good enough to go on, and keep what that was decided on in the design
    #[arg(long, value_parser = STEP, value_name = "STEP")]
    decide: Option<Step>,

    /// Why; needed where the requirement is missed
    #[arg(long, value_name = "TEXT", requires = "decide")]
    note: Option<String>,

    /// Take back what was decided
    #[arg(long, value_parser = STEP, value_name = "STEP")]
    withdraw: Option<Step>,

    /// How to print where the design stands
    #[arg(long, value_enum, default_value_t)]
    format: Format,
}

const STEP: Choice<Step> = Choice(&[
    ("crf", "The CRF alone against the tracker", Step::Crf),
    ("tool", "The tool against that CRF", Step::Tool),
    ("built", "The built tool against its prediction", Step::Built),
]);

/// Makes the requested changes, computes every step, decides, saves, and prints. Nothing is saved
/// where anything of it fails.
///
/// # Errors
/// Files that can't be used, a built-in design that is to be changed, a step that cannot be decided.
pub fn run(args: &ProcedureArgs, files: &Files) -> anyhow::Result<()> {
    let mut attempts = ATTEMPTS;
    let (world, found) = loop {
        attempts -= 1;
        match judge_and_save(args, files) {
            Err(error) if attempts > 0 && is_changed_meanwhile(&error) => {
                output::note(
                    "note: the design was saved by somebody else meanwhile; judging it anew",
                );
            }
            other => break other?,
        }
    };
    output::print_section(args.format, &procedure_section(world.document.design(), &found))
}

/// Whether nothing was saved because somebody else did between reading and saving.
fn is_changed_meanwhile(error: &anyhow::Error) -> bool {
    matches!(error.downcast_ref(), Some(StoreError::ChangedOnDisk { .. }))
}

fn judge_and_save(args: &ProcedureArgs, files: &Files) -> anyhow::Result<(World, StepStatus)> {
    let mut world = files.open_design_without_meshes(&args.design)?;
    let is_changing = args.decide.is_some()
        || args.withdraw.is_some()
        || !args.add_room.is_empty()
        || !args.remove_room.is_empty();
    if is_changing && let Origin::BuiltIn(name) = world.document.origin() {
        bail!("the built-in design {name} is read-only, expected a design of your own");
    }
    note_world(&world);
    change_rooms(args, files, &mut world)?;
    if let Some(step) = args.withdraw {
        let edit = ProcedureEdit::Withdraw { step };
        apply(args, &mut world, edit)?;
    }
    let wish = ProcedureRequest {
        rooms_for_now: args.environment.clone(),
        recording: recording(args, &world)?,
    };
    let shown = Shown::new("judging");
    let found = trackwright_project::procedure(files, &world, &wish, &shown.task, &|note| {
        output::note(&format!("note: {note}"));
    });
    drop(shown);
    let mut found = found?;
    if let Some(step) = args.decide {
        decide(args, &mut world, step, &found)?;
        found.decide(step);
    }
    if is_changing {
        for kept in trackwright_project::save(&mut world)?.kept {
            output::note(&format!("note: {kept}"));
        }
    }
    Ok((world, found))
}

fn change_rooms(args: &ProcedureArgs, files: &Files, world: &mut World) -> anyhow::Result<()> {
    for file in &args.remove_room {
        let room = trackwright_project::further_room(world, file)?.map(str::to_owned);
        let Some(room) = room else {
            let rooms = &world.document.design().procedure.further_rooms;
            let expected = match rooms.is_empty() {
                true => "it has no further rooms".to_owned(),
                false => format!("expected one of {}", rooms.join(", ")),
            };
            bail!("--remove-room {}: the design is not judged in it; {expected}", file.display());
        };
        apply(args, world, ProcedureEdit::RemoveRoom(room))?;
    }
    for file in &args.add_room {
        // One that cannot be read is not added.
        files.read_environment(file)?;
        let is_own =
            trackwright_project::own_room(world)? == trackwright_project::RoomSource::of_file(file);
        if is_own || trackwright_project::further_room(world, file)?.is_some() {
            bail!("--add-room {}: the design is judged in it already", file.display());
        }
        let reference = trackwright_project::reference_to_file(world, file)?;
        apply(args, world, ProcedureEdit::AddRoom(reference))?;
    }
    Ok(())
}

fn apply(args: &ProcedureArgs, world: &mut World, edit: ProcedureEdit) -> anyhow::Result<()> {
    let applied = world.document.apply(Edit::Procedure(edit));
    applied.with_context(|| args.design.display().to_string())?;
    Ok(())
}

/// The tables as the design will refer to them.
fn recording(args: &ProcedureArgs, world: &World) -> anyhow::Result<Option<BuiltRecording>> {
    let Some(table) = &args.built else {
        return Ok(None);
    };
    let reference = |file: &Path| trackwright_project::reference_to_file(world, file);
    Ok(Some(BuiltRecording {
        crf_table: args.crf.as_deref().map(reference).transpose()?,
        frame: args.frame,
        is_registered: args.registered,
        averaged: args.averaged,
        truth_std_mm: args.truth_mm,
        whole: args.tool.clone(),
        ..BuiltRecording::of(reference(table)?)
    }))
}

fn decide(
    args: &ProcedureArgs,
    world: &mut World,
    step: Step,
    found: &StepStatus,
) -> anyhow::Result<()> {
    let named = || format!("--decide {}", step.key());
    let basis = found.basis(step).with_context(named)?;
    let note = args.note.clone().unwrap_or_default();
    if let (Some(objection), "") = (found.objection(step), note.trim()) {
        bail!("{}: {objection}, expected --note with why that is good enough", named());
    }
    let decision = Decision { date: trackwright_project::today()?, note, basis };
    let decision = Box::new(decision);
    apply(args, world, ProcedureEdit::Decide { step, decision })
}
