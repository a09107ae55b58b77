//! `procedure`: where a design stands in the paper's design procedure, and what is decided in it.

use super::figures;
use super::numbers::zero_or_more;
use super::prelude::*;
use super::simulate::note_world;
use super::verify::FRAME;
use trackwright_calibration::agreement::{BuiltRecording, RecordedFrame};
use trackwright_design::{BodyRole, Decision, Design, Edit, Origin, Procedure, ProcedureEdit};
use trackwright_formats::printable::printable;
use trackwright_procedure::{
    BuiltStatus, Change, DecisionBasis, Row, State, Step, StepStatus, StudiesStatus, headline,
};
use trackwright_project::{ProcedureRequest, StoreError, World};
use trackwright_report::figures_json::{merge, study_json};
use trackwright_report::text_table::columns;
use trackwright_simulation::Verdict;
use trackwright_simulation::requirement::Requirement;
use trackwright_simulation::{ErrorOf, Metric};

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
    let procedure = &world.document.design().procedure;
    let design = world.document.design();
    args.format.print(|| as_json(&design.name, procedure, &found), || as_text(design, &found))
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

fn as_json(design: &str, procedure: &Procedure, found: &StepStatus) -> Value {
    let steps = Step::ALL.into_iter().map(|step| {
        let mut value = match step {
            Step::Crf => studies_as_json(&found.crf),
            Step::Tool => studies_as_json(&found.tool),
            Step::Built => built_as_json(&found.built),
        };
        value["step"] = json!(step.key());
        value["state"] = json!(found.state(step));
        value["decision"] = json!(procedure.decision(step).map(decision_as_json));
        let changes = found.changes(step).iter().map(change_as_json);
        value["changes"] = changes.collect();
        value
    });
    json!({ "design": design, "steps": steps.collect::<Vec<_>>() })
}

fn studies_as_json(found: &StudiesStatus) -> Value {
    json!({
        "requirement": found.requirement,
        "rows": found.rows.iter().map(row_as_json).collect::<Vec<_>>(),
    })
}

fn row_as_json(row: &Row) -> Value {
    let mut value = json!({
        "environment": row.room.name,
        "environment_file": row.room.file,
        "for_now": row.is_for_now,
        "target": row.target,
        "no_figures": row.studied.as_ref().err().map(ToString::to_string),
    });
    let Ok(studied) = &row.studied else {
        return value;
    };
    merge(&mut value, study_json(studied, None));
    value
}

fn built_as_json(found: &BuiltStatus) -> Value {
    match &found.recording {
        None => json!({ "recording": null }),
        Some(Err(why)) => json!({ "recording": null, "no_figures": why }),
        Some(Ok(recording)) => json!({
            "recording": recording.found.recording.to_string(),
            "environment": recording.found.room.name,
            "environment_file": recording.found.room.file,
            "figures": recording.summary,
        }),
    }
}

fn decision_as_json(decision: &Decision) -> Value {
    json!({ "date": decision.date.to_string(), "note": decision.note })
}

fn change_as_json(change: &Change) -> Value {
    let mut value = json!({ "what": change.what, "words": change.to_string() });
    value["environment_file"] = json!(change.room.as_ref().map(|room| &room.file));
    value["target"] = json!(change.target);
    value
}

fn as_text(design: &Design, found: &StepStatus) -> String {
    let mut lines = vec![printable(&design.name).into_owned()];
    for step in Step::ALL {
        lines.push(String::new());
        let what = match step {
            Step::Crf => design.body(BodyRole::Crf).map(|body| &body.rigid.name),
            Step::Tool | Step::Built => Some(&design.tool.body.rigid.name),
        };
        let title = match (step, what) {
            (Step::Crf, Some(name)) => format!("The CRF alone, {name}"),
            (Step::Crf, None) => "The CRF alone".to_owned(),
            (Step::Tool, name) => match design.crf {
                Some(_) => format!("The tool in the CRF, {}", name.map_or("", String::as_str)),
                None => format!("The tool, {}", name.map_or("", String::as_str)),
            },
            (Step::Built, _) => "The built tool".to_owned(),
        };
        lines.push(format!("{}. {}: {}", step.number(), printable(&title), headline(found, step)));
        match step {
            Step::Crf => lines.extend(studies(&found.crf, true)),
            Step::Tool => lines.extend(studies(&found.tool, false)),
            Step::Built => lines.extend(built(&found.built)),
        }
        if let Some(decision) = design.procedure.decision(step) {
            lines.extend(decided(decision, found.changes(step)));
        }
    }
    lines.join("\n")
}

fn studies(found: &StudiesStatus, has_targets: bool) -> Vec<String> {
    if found.state == State::DoesNotApply {
        return Vec::new();
    }
    let has_targets = has_targets && found.rows.iter().any(|row| row.target.is_some());
    let mut head = vec!["room"];
    if has_targets {
        head.push("judged at");
    }
    let left = head.len();
    let mut head: Vec<String> = head.into_iter().map(str::to_owned).collect();
    head.extend(Metric::decided().map(|m| format!("{} {}", m.summary.short(), m.unit())));
    head.push("required".to_owned());
    let figures = head.len() - left;
    let mut table = vec![head];
    for row in &found.rows {
        let mut cells = vec![room_name(row)];
        if has_targets {
            cells.push(row.target.clone().unwrap_or_default());
        }
        match &row.studied {
            Err(_) => cells.extend((0..figures).map(|_| "–".to_owned())),
            Ok(studied) => {
                let figures = Metric::decided().filter_map(|metric| studied.figures.get(metric));
                cells.extend(figures.map(|figure| figure.value_text(4)));
                let verdict = row.verdict().map_or("–", Verdict::label);
                cells.push(verdict.to_owned());
            }
        }
        table.push(cells);
    }
    let mut lines: Vec<String> =
        columns(&table, left).into_iter().map(|line| format!("   {line}")).collect();
    for row in &found.rows {
        let notes = match &row.studied {
            Err(why) => vec![format!("no figures: {why}")],
            Ok(studied) => {
                let rows = figures::rows(&studied.figures).into_iter();
                let rows = rows.map(|(label, value, unit)| format!("{label} {value} {unit}"));
                let line = figures::no_interval_line(&studied.figures);
                rows.chain(line).chain(studied.notes()).collect()
            }
        };
        let at = row.target.as_ref().map_or_else(String::new, |target| format!(", {target}"));
        lines.extend(notes.into_iter().map(|note| format!("   {}{at}: {note}", room_name(row))));
    }
    lines.push(format!("   {}", required(found.requirement.as_ref())));
    lines
}

fn room_name(row: &Row) -> String {
    let name = match row.room.name.trim() {
        "" => row.room.file.clone(),
        name => name.to_owned(),
    };
    match row.is_for_now {
        true => format!("{} (this once)", printable(&name)),
        false => printable(&name).into_owned(),
    }
}

fn required(requirement: Option<&Requirement>) -> String {
    let bounds = requirement.iter().flat_map(|r| r.bounds());
    let bounds: Vec<String> = bounds
        .map(|(metric, bound)| {
            let space = if metric.of == ErrorOf::Angle { "" } else { " " };
            format!("{} ≤ {bound}{space}{}", metric.name(), metric.unit())
        })
        .collect();
    match bounds.is_empty() {
        true => "nothing is required".to_owned(),
        false => format!("required: {}", bounds.join(", ")),
    }
}

fn built(found: &BuiltStatus) -> Vec<String> {
    let lines = match &found.recording {
        None => return Vec::new(),
        Some(Err(why)) => vec![format!("no figures: {why}")],
        Some(Ok(recording)) => {
            let of = &recording.found;
            let rms = Metric::TIP_RMS.label();
            vec![
                format!("{}, in {}", of.recording, of.room.name),
                format!(
                    "{} of {} poses; {rms}: measured {:.3} mm, predicted {:.3} mm, measured − predicted {:.3} mm",
                    of.used, of.poses, of.measured_rms_mm, of.predicted_rms_mm, of.residual_rms_mm
                ),
                of.statement.clone(),
            ]
        }
    };
    lines.into_iter().map(|line| format!("   {line}")).collect()
}

fn decided(decision: &Decision, changes: &[Change]) -> Vec<String> {
    let mut lines = vec![match decision.note.trim() {
        "" => format!("   decided on {}", decision.date),
        note => format!("   decided on {}: {note}", decision.date),
    }];
    if let DecisionBasis::Recording(recording) = &decision.basis {
        lines.push(format!("   on {}", recording.recording));
    }
    lines.extend(changes.iter().map(|change| format!("   since then: {change}")));
    lines
}
