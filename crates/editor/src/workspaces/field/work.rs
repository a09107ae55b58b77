//! What the workspace's threads do: calls of the core in order, each reporting to one task.

use crate::document::requests::OpenWorld;
use crate::document::state::WorldGeneration;
use crate::workspaces::field::failure::Failure;
use crate::workspaces::field::metal::{FoundMetal, GeneratorSource};
use crate::workspaces::field::state::{Comparison, FieldSettings, Fitted, Table};
use std::sync::Arc;
use trackwright_calibration::fit_quality::fit_quality;
use trackwright_calibration::kind_choice::{Decided, decide};
use trackwright_calibration::room_fit::{
    FittedRoom, RoomError, RoomOrder, RoomStage, RoomTable, fit_room,
};
use trackwright_calibration::row_labels::RowLabels;
use trackwright_field::generator::Generator;
use trackwright_field::harmonic::HarmonicFitError;
use trackwright_field::samples::MeasurementContent;
use trackwright_field::selection::SelectError;
use trackwright_formats::groups::GroupColumn;
use trackwright_metal::identify::compare::{self, CompareError};
use trackwright_metal::identify::{IdentifyError, IdentifySettings, identify, room_of_found};
use trackwright_project::{Files, RoomContent, StoreError, room_name};
use trackwright_report::room::support_note;
use trackwright_report::selection::grouped_line;
use trackwright_simulation::Scenario;
use trackwright_simulation::Study;
use trackwright_simulation::study::{mode_of, study_with_figures};
use trackwright_task::{Cancelled, Task};

/// Part of the time that choosing takes, for the bar only: it tries hundreds of models.
pub const CHOOSING_PART: f64 = 0.85;
/// Parts of the rest at which the fit itself and its standard errors end; what the measurements
/// leave open takes what is left.
const FITTING_PART: f64 = 0.4;
const SUPPORT_PART: f64 = 0.5;

/// Chooses what is open, fits, and judges.
///
/// # Errors
/// See [`Failure`].
pub fn fit(
    training: &Table,
    held_out: Option<&Table>,
    settings: FieldSettings,
    task: &Task,
) -> Result<Fitted, Failure> {
    let mut notes = Vec::new();
    let request = &settings.model;
    let wanted = settings.kind.wanted(&training.samples, request.map, settings.degree);
    let Some(wanted) = wanted else {
        return Err(Failure::Because(format!(
            "{}: its generator is not built in",
            settings.kind.label()
        )));
    };
    let choosing_part = if settings.is_open() { CHOOSING_PART } else { 0.0 };
    let labels = match wanted.is_open(request, &training.samples, false) {
        true => labels(training, &mut notes)?,
        false => RowLabels::default(),
    };
    let choosing = task.subtask(0.0, choosing_part);
    let decided = decide(&training.samples, (&wanted, request), false, labels, &choosing);
    let decided = decided.map_err(|error| match error.is_cancelled() {
        true => Failure::Cancelled,
        false => in_table(training, &error),
    })?;
    let places = decided.chosen.as_ref().and_then(|chosen| chosen.places.as_ref());
    notes.extend(places.map(grouped_line));
    let FittedRoom { environment, fit, support_left_out, harmonic } =
        fit_model(training, held_out, &settings, &decided, &task.subtask(choosing_part, 1.0))?;
    notes.extend(support_left_out.as_ref().map(support_note));
    Ok(Fitted {
        training_quality: fit_quality(&fit.model, &training.samples),
        held_out_quality: held_out.map(|table| fit_quality(&fit.model, &table.samples)),
        training: Arc::clone(training),
        held_out: held_out.map(Arc::clone),
        field_settings: settings,
        decided,
        harmonic,
        notes,
        fit,
        environment: Arc::new(environment),
    })
}

/// Which rows belong together.
fn labels(training: &Table, notes: &mut Vec<String>) -> Result<RowLabels, Failure> {
    let groups = match &training.groups {
        Ok(groups) => groups.as_ref().map(|groups| groups.column.named_labels()),
        // It names the file already.
        Err(error) => return Err(Failure::Because(error.to_string())),
    };
    let sensors = match &training.sensors {
        Ok(sensors) => sensors.as_ref().map(GroupColumn::named_labels),
        Err(error) => {
            notes.push(format!("{error}; sensors are not held out"));
            None
        }
    };
    RowLabels::of(&training.samples, groups, sensors, None).map_err(|e| in_table(training, &e))
}

fn fit_model(
    training: &Table,
    held_out: Option<&Table>,
    settings: &FieldSettings,
    decided: &Decided,
    task: &Task,
) -> Result<FittedRoom, Failure> {
    let (name, held_out_name) = (training.name(), held_out.map(|table| table.name()));
    let order = RoomOrder {
        name: &room_name(&training.file.with_extension("")),
        table: RoomTable { name: &name, samples: &training.samples },
        held_out: held_out
            .zip(held_out_name.as_deref())
            .map(|(table, name)| RoomTable { name, samples: &table.samples }),
        model: &decided.model,
        settings: decided.settings,
        bounds: None,
        volume: settings.volume,
        jitter: settings.jitter,
        registration: settings.registration,
        with_support: true,
        sensors: decided.sensors(),
    };
    let stage = |stage| match stage {
        RoomStage::Fitting => task.subtask(0.0, FITTING_PART),
        RoomStage::FitValidity => task.subtask(FITTING_PART, SUPPORT_PART),
        RoomStage::Process => task.subtask(SUPPORT_PART, 1.0),
    };
    fit_room(&order, stage).map_err(|error| match error {
        error if error.is_cancelled() => Failure::Cancelled,
        RoomError::Fit(error) => in_table(training, &error),
        error
        @ (RoomError::FitValidity(_) | RoomError::Model(_) | RoomError::SharedRows { .. }) => {
            Failure::Because(error.to_string())
        }
    })
}

/// As the command line words it: the file, then what is wrong.
fn in_table(table: &Table, error: &dyn std::error::Error) -> Failure {
    Failure::Because(format!("{}: {error}", table.file.display()))
}

/// What [`compare()`] needs of the open design.
pub struct Compared {
    present: Scenario,
    tried: Scenario,
    room: Arc<Fitted>,
    generation: u64,
    revision: u64,
}

impl Compared {
    pub fn new(world: &OpenWorld, generation: WorldGeneration, room: &Arc<Fitted>) -> Self {
        let document = &world.0.document;
        Self {
            present: trackwright_project::resolve(document.design(), &world.0.environment),
            tried: trackwright_project::resolve(document.design(), &room.environment),
            room: Arc::clone(room),
            generation: generation.0,
            revision: document.revision(),
        }
    }
}

/// The figures of the design in the present room and in the fitted one.
///
/// # Errors
/// See [`Failure`].
pub fn compare(compared: Compared, task: &Task) -> Result<Comparison, Failure> {
    let study = |scenario: &Scenario| -> Result<Study, Failure> {
        match study_with_figures(scenario, &mode_of(scenario), &task.cancel) {
            Ok(studied) => studied.map_err(|why| Failure::Because(why.to_string())),
            Err(Cancelled) => Err(Failure::Cancelled),
        }
    };
    Ok(Comparison {
        present: study(&compared.present)?,
        tried: study(&compared.tried)?,
        room: compared.room,
        generation: compared.generation,
        revision: compared.revision,
    })
}

/// Finds the metal that disturbs a table, which is read whole: samples have no rolls.
///
/// # Errors
/// See [`Failure`].
pub fn find_metal(
    table: &Table,
    source: &GeneratorSource,
    of_room: Option<Generator>,
    task: &Task,
) -> Result<FoundMetal, Failure> {
    let because = |error: StoreError| Failure::Because(error.to_string());
    let generator = match source {
        GeneratorSource::BuiltIn(name) => Generator::built_in(name),
        GeneratorSource::Room => of_room,
        GeneratorSource::File(file) => {
            Some(Files::default().read_generator(file).map_err(because)?)
        }
    };
    let Some(generator) = generator else {
        return Err(Failure::Because("the room's field generator is not known".to_owned()));
    };
    let mut measurements = Files::default().read_measurements(&table.file).map_err(because)?;
    if table.reading.has_rolls {
        measurements.content = MeasurementContent::SixDof;
    }
    if measurements.samples(table.reading.map) != table.samples {
        let file = table.file.display();
        return Err(Failure::Because(format!(
            "{file}: changed since it was opened, open it again"
        )));
    }
    let settings = IdentifySettings::default();
    let found = identify(task, &generator, &measurements, &settings);
    let found = found.map_err(|error| match error {
        IdentifyError::Cancelled(_) => Failure::Cancelled,
        error => in_table(table, &error),
    })?;
    let room = room_of_found(&table.name(), &generator, &measurements, &found);
    let room = room
        .map(|(bare, metal)| RoomContent { bare: Arc::new(bare), metal: Some(Arc::new(metal)) });
    Ok(FoundMetal {
        found,
        compared: Vec::new(),
        generator,
        settings,
        measurements: Arc::new(measurements),
        room,
        table: Arc::clone(table),
    })
}

/// The same metal beside other models of its measurements.
///
/// # Errors
/// See [`Failure`].
pub fn compare_metal(metal: &FoundMetal, task: &Task) -> Result<FoundMetal, Failure> {
    let FoundMetal { found, generator, settings, measurements, table, .. } = metal;
    let compared = compare::compare(task, generator, measurements, settings, found);
    let compared = compared.map_err(|error| match error {
        CompareError::Cancelled(_)
        | CompareError::Select(SelectError::Cancelled(_))
        | CompareError::Harmonic(HarmonicFitError::Cancelled(_)) => Failure::Cancelled,
        error => in_table(table, &error),
    })?;
    Ok(FoundMetal { compared, ..metal.clone() })
}
