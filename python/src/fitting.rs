//! Rooms from measurements: models fitted as requested, or chosen by cross-validation.

use crate::arrays::rows;
use crate::choices::one_of;
use crate::errors::{Done, TrackwrightError};
use crate::keywords::Keywords;
use crate::long_work;
use crate::measurements::{Measured, labels, read};
use crate::tables::{Notes, Table, warn_of};
use anyhow::Context;
use pyo3::prelude::*;
use pyo3::types::{PyDict, PyString};
use std::path::Path;
use trackwright_calibration::kind_choice::{
    KindChoice, TriedKind, TriedOptions, Wanted, best_kind, decide,
};
use trackwright_calibration::room_choice::{ModelRequest, choose_by};
use trackwright_calibration::room_fit::{
    FittedRoom, RegistrationError, RoomError, RoomOrder, RoomTable, fit_room,
};
use trackwright_calibration::room_model::{GeneratorChoice, HarmonicOrder, RoomModel};
use trackwright_calibration::row_labels::{HeldOut, RowLabels};
use trackwright_field::Environment;
use trackwright_field::computed::ModelKind;
use trackwright_field::environment::Jitter;
use trackwright_field::fit::{FitMethod, FitSettings};
use trackwright_field::generator::Generator;
use trackwright_field::harmonic::Loss;
use trackwright_field::harmonic::solid_harmonics::MAX_DEGREE;
use trackwright_field::samples::{MapKind, SampleSet};
use trackwright_field::selection::sensors::SensorSpread;
use trackwright_field::selection::{DEFAULT_FOLDS, DEFAULT_RIDGES, DEFAULT_SEED, SelectSettings};
use trackwright_geometry::bounds::Bounds;
use trackwright_geometry::directions::{DirectionSet, Weighting};
use trackwright_geometry::limits::length_problem;
use trackwright_geometry::volume::Volume;
use trackwright_project::{Files, MOST_LAG_ROWS, MOST_SENSOR_OFFSET_MM, SampleReading};
use trackwright_report::room::{fit_warnings, support_note};
use trackwright_report::room_section::fit_section;
use trackwright_report::selection_section::{decided_section, selection_section};
use trackwright_result::{Section, data};
use trackwright_task::Task;

/// Orders that are tried where none are named; 0, no correction, is tried always.
const TRIED_ORDERS: std::ops::RangeInclusive<usize> = 1..=6;

/// Singular values that count as zero, as a part of the largest.
const DEFAULT_RCOND: f64 = 1e-10;

/// How a table is read, and how polynomials are fitted to it.
#[derive(Clone, Copy)]
struct Fitting {
    reading: SampleReading,
    method: FitMethod,
    weighting: Weighting,
    rcond: f64,
}

/// What the room gets beside its model.
struct Extras {
    name: Option<String>,
    bounds: Option<Bounds>,
    volume: Option<Volume>,
    jitter: Option<Jitter>,
    registration: Option<RegistrationError>,
    with_support: bool,
}

impl Fitting {
    fn of(keywords: &Keywords) -> Done<Self> {
        let maps = [("distortion", MapKind::Distortion), ("correction", MapKind::Correction)];
        let methods = [("per-direction", FitMethod::PerDirection), ("joint", FitMethod::Joint)];
        let weights = [("area", Weighting::Area), ("gnomonic", Weighting::Gnomonic)];
        let in_range = |lag: f64| lag.abs() <= MOST_LAG_ROWS;
        let expected = format!("-{MOST_LAG_ROWS} to {MOST_LAG_ROWS} rows");
        let lag_rows = keywords.number("lag", &expected, in_range)?;
        let in_range = |offset: f64| offset.abs() <= MOST_SENSOR_OFFSET_MM;
        let expected = format!("-{MOST_SENSOR_OFFSET_MM} to {MOST_SENSOR_OFFSET_MM} mm");
        let sensor_offset_mm = keywords.number("sensor_offset", &expected, in_range)?;
        let rcond = keywords.number("rcond", "zero or more", |value| value >= 0.0)?;
        Ok(Self {
            reading: SampleReading {
                has_rolls: keywords.one_of("sensors", &[("5dof", false), ("6dof", true)])?,
                map: keywords.one_of("map", &maps)?,
                lag_rows: lag_rows.unwrap_or(0.0),
                sensor_offset_mm: sensor_offset_mm.unwrap_or(0.0),
            },
            method: keywords.one_of("method", &methods)?,
            weighting: keywords.one_of("weights", &weights)?,
            rcond: rcond.unwrap_or(DEFAULT_RCOND),
        })
    }
}

impl Extras {
    fn of(keywords: &Keywords) -> Done<Self> {
        let volumes = [
            ("none", None::<Volume>),
            ("cube", Some(Volume::AuroraCube)),
            ("dome", Some(Volume::AuroraDome)),
            ("tabletop", Some(Volume::AuroraTabletop)),
            ("compact", Some(Volume::AuroraCompact)),
        ];
        Ok(Self {
            name: keywords.value("name")?,
            bounds: None,
            volume: keywords.one_of("volume", &volumes)?,
            jitter: jitter(keywords)?,
            registration: registration(keywords)?,
            with_support: keywords.flag("support", true)?,
        })
    }
}

/// How well the reference's frame is known, where it is stated.
fn registration(keywords: &Keywords) -> Done<Option<RegistrationError>> {
    let is_length = |value: f64| value >= 0.0 && length_problem(value).is_none();
    let position_mm = keywords.number("registration_mm", "a length of zero or more", is_length)?;
    let is_angle = |value: f64| (0.0..=180.0).contains(&value);
    let angle_deg = keywords.number("registration_deg", "0 to 180", is_angle)?;
    match (position_mm, angle_deg) {
        (Some(position_mm), Some(angle_deg)) => {
            Ok(Some(RegistrationError { position_mm, angle_rad: angle_deg.to_radians() }))
        }
        (None, None) => Ok(None),
        _ => {
            let text = "registration_mm and registration_deg: found one, expected both";
            Err(TrackwrightError::new_err(text).into())
        }
    }
}

/// The jitter of a tracker, where it is stated.
///
/// # Errors
/// Numbers that are none, one of two that belong together.
pub fn jitter(keywords: &Keywords) -> Done<Option<Jitter>> {
    let zero_or_more = |value: f64| value >= 0.0;
    let position_mm = keywords.number("jitter_position_mm", "zero or more", zero_or_more)?;
    let angle_deg = keywords.number("jitter_angle_deg", "zero or more", zero_or_more)?;
    let growth_mm =
        keywords.number("jitter_growth_mm", "a length above zero", |value| value > 0.0)?;
    let jitter = match (position_mm, angle_deg) {
        (Some(position_mm), Some(angle_deg)) => {
            Some(Jitter::stated(position_mm, angle_deg.to_radians(), growth_mm))
        }
        (None, None) if growth_mm.is_none() => None,
        _ => {
            let text = "jitter_position_mm and jitter_angle_deg: found one, expected both";
            return Err(TrackwrightError::new_err(text).into());
        }
    };
    if let Some((name, found, expected)) = jitter.and_then(|jitter| jitter.problem()) {
        let text = format!("{name} is {found}, expected {expected}");
        return Err(TrackwrightError::new_err(text).into());
    }
    Ok(jitter)
}

/// The room of a table's measurements, and the figures of the fit.
///
/// # Errors
/// Tables that cannot be used, and settings that make no fit.
pub fn fit(
    py: Python<'_>,
    table: &Bound<'_, PyAny>,
    options: Option<&Bound<'_, PyDict>>,
) -> Done<(Environment, Section)> {
    let keywords = Keywords::of(options);
    let fitting = Fitting::of(&keywords)?;
    let extras = Extras { bounds: bounds(&keywords)?, ..Extras::of(&keywords)? };
    let ridge = keywords.number("ridge", "zero or more", |value| value >= 0.0)?;
    let named = room_model(&keywords, ridge)?;
    let request = ModelRequest {
        order: keywords.value("order")?,
        directions: direction_set(keywords.value("directions")?)?,
        ridge,
        method: fitting.method,
        map: fitting.reading.map,
        weighting: fitting.weighting,
        rcond: fitting.rcond,
    };
    let held_out: Option<String> = keywords.value("hold_out")?;
    let held_out = held_out.as_deref().map(HeldOut::from);
    let second = keywords.object("holdout")?;
    let as_is = keywords.flag("as_is", false)?;
    keywords.finish()?;
    // An option of polynomials names them.
    let has_options =
        polynomial_options(&request, &fitting, &extras).iter().any(|(_, given)| *given);
    let model = named.or(has_options.then_some(RoomModel::PAPER));
    if let Some(model) = &model {
        refuse_unused(&request, held_out.as_ref(), &fitting, &extras, model.kind())?;
    }
    let mut notes = Notes::new();
    let table = Table::of(table)?;
    let measured = read(py, &table, fitting.reading, as_is, &mut notes)?;
    let second = second
        .map(|second| read(py, &Table::of(&second)?, fitting.reading, as_is, &mut notes))
        .transpose()?;
    let wanted = match model {
        Some(model) => Wanted::One(model),
        None => {
            let mut kinds = TriedKind::all(&measured.samples, request.map);
            // It is made of what is to be left out.
            kinds.retain(|kind| extras.with_support || *kind != TriedKind::Kriging);
            Wanted::Best(kinds)
        }
    };
    let is_judged = held_out.is_some();
    let labels = match wanted.is_open(&request, &measured.samples, is_judged) {
        true => labels(&table, &measured, None, held_out.as_ref(), &mut notes)?,
        false => RowLabels::default(),
    };
    let (room, figures) = long_work::run(py, |task| {
        let decided = decide(&measured.samples, (&wanted, &request), is_judged, labels, task)
            .with_context(|| measured.label.clone())?;
        let how = (&decided.model, &decided.settings, decided.sensors());
        let room = fitted(&measured, second.as_ref(), how, &extras, task, &mut notes)?;
        let figures = decided_section(&measured.name, &decided, &room);
        Ok((room, figures))
    })?;
    warn_of(py, notes)?;
    Ok((room.environment, figures))
}

/// The room of the model that does best on rows held out, and the figures of the choice.
///
/// # Errors
/// Tables that cannot be used, lists that name nothing to try, rows that can't be folded.
pub fn select(
    py: Python<'_>,
    table: &Bound<'_, PyAny>,
    options: Option<&Bound<'_, PyDict>>,
) -> Done<(Environment, Section)> {
    let keywords = Keywords::of(options);
    let fitting = Fitting::of(&keywords)?;
    let extras = Extras::of(&keywords)?;
    let named = NamedKinds::of(&keywords)?;
    let orders: Option<Vec<usize>> = keywords.value("orders")?;
    let directions: Option<Vec<usize>> = keywords.value("directions")?;
    let ridges: Option<Vec<f64>> = keywords.value("ridges")?;
    let is_usual = fitting.method == FitMethod::default()
        && fitting.weighting == Weighting::default()
        && fitting.rcond.to_bits() == DEFAULT_RCOND.to_bits();
    // An option of polynomials names them.
    let has_lists = orders.is_some() || directions.is_some() || ridges.is_some() || !is_usual;
    let folds = keywords.value("folds")?.unwrap_or(DEFAULT_FOLDS);
    let seed = keywords.value("seed")?.unwrap_or(DEFAULT_SEED);
    let group: Option<String> = keywords.value("group")?;
    let held_out: Option<String> = keywords.value("hold_out")?;
    let held_out = held_out.as_deref().map(HeldOut::from);
    let as_is = keywords.flag("as_is", false)?;
    keywords.finish()?;
    let mut notes = Notes::new();
    let table = Table::of(table)?;
    let measured = read(py, &table, fitting.reading, as_is, &mut notes)?;
    let direction_sets = match directions {
        Some(counts) => {
            let sets = counts.into_iter().map(|m| DirectionSet::try_from(m).context("directions"));
            sets.collect::<Result<_, _>>()?
        }
        None if measured.samples.has_rotations => DirectionSet::ALL.to_vec(),
        None => vec![DirectionSet::One],
    };
    let orders = orders.unwrap_or_else(|| TRIED_ORDERS.collect());
    let tried = SelectSettings {
        orders: orders.into_iter().chain([0]).collect(),
        direction_sets,
        ridges: ridges.unwrap_or_else(|| DEFAULT_RIDGES.to_vec()),
        folds,
        seed,
        method: fitting.method,
        map: fitting.reading.map,
        weighting: fitting.weighting,
        rcond: fitting.rcond,
        only_contenders: named.names.is_none() && !has_lists,
    };
    let kinds = named.kinds(&measured.samples, fitting.reading.map, has_lists)?;
    let labels = labels(&table, &measured, group.as_deref(), held_out.as_ref(), &mut notes)?;
    let (room, figures) = long_work::run(py, |task| {
        let samples = &measured.samples;
        let named = || measured.label.clone();
        let (chosen, choice) = match kinds[..] {
            [TriedKind::Bernstein] => {
                (choose_by(samples, labels, tried, task).with_context(named)?, None)
            }
            _ => {
                let found = best_kind(samples, labels, &tried, &kinds, task);
                let (chosen, choice) = found.with_context(named)?;
                (chosen, Some(choice))
            }
        };
        let figures =
            selection_section(&measured.name, samples.samples.len(), &chosen, choice.as_ref());
        let best = choice.as_ref().map(KindChoice::best);
        let settings = best.map_or_else(|| chosen.settings(), |kind| kind.settings(&chosen.tried));
        let model = best.map_or(&RoomModel::PAPER, |kind| &kind.model);
        let how = (model, &settings, chosen.selection.sensors);
        let room = fitted(&measured, None, how, &extras, task, &mut notes)?;
        let fit = fit_section(&measured.name, &settings, &room);
        Ok((room, figures.with(data("fit", fit))))
    })?;
    warn_of(py, notes)?;
    Ok((room.environment, figures))
}

/// Fits a room, and notes what is to be known of it.
fn fitted(
    measured: &Measured,
    held_out: Option<&Measured>,
    (model, settings, sensors): (&RoomModel, &FitSettings, Option<SensorSpread>),
    extras: &Extras,
    task: &Task,
    notes: &mut Notes,
) -> Done<FittedRoom> {
    let table_of = |measured| {
        let Measured { name, samples, .. }: &Measured = measured;
        RoomTable { name, samples }
    };
    let order = RoomOrder {
        name: extras.name.as_ref().unwrap_or(&measured.room),
        table: table_of(measured),
        held_out: held_out.map(table_of),
        model,
        settings: *settings,
        bounds: extras.bounds,
        volume: extras.volume,
        jitter: extras.jitter,
        registration: extras.registration,
        with_support: extras.with_support,
        sensors,
    };
    let room = fit_room(&order, |_| task.clone());
    let room = match room {
        Err(RoomError::Fit(error)) => Err(error).with_context(|| measured.label.clone())?,
        Err(RoomError::Model(error)) => Err(error).with_context(|| measured.label.clone())?,
        other => other?,
    };
    notes.extend(room.support_left_out.as_ref().map(support_note));
    notes.extend(fit_warnings(&room.fit));
    Ok(room)
}

/// The least and the largest corner of a box, mm.
fn bounds(keywords: &Keywords) -> Done<Option<Bounds>> {
    let Some(given) = keywords.object("bounds")? else { return Ok(None) };
    let [min_mm, max_mm] = rows::<3>(&given, "bounds")?[..] else {
        let text =
            "bounds: found another number of rows, expected the least and the largest corner";
        return Err(TrackwrightError::new_err(text).into());
    };
    let bounds = Bounds::from((min_mm, max_mm));
    bounds.check().context("bounds")?;
    Ok(Some(bounds))
}

fn direction_set(count: Option<usize>) -> Done<Option<DirectionSet>> {
    Ok(count.map(|m| DirectionSet::try_from(m).context("directions")).transpose()?)
}

/// A model's kind, with what only that kind has; `None` where none is named. The ridge is of a harmonic one.
fn room_model(keywords: &Keywords, ridge: Option<f64>) -> Done<Option<RoomModel>> {
    let refused = |text: &str| Err(TrackwrightError::new_err(text.to_owned()).into());
    let kinds = [
        ("bernstein", ModelKind::Bernstein),
        ("kriging", ModelKind::Kriging),
        ("harmonic", ModelKind::Harmonic),
    ];
    let named: Option<String> = keywords.value("model")?;
    let kind = named.map(|found| one_of("model", &found, &kinds)).transpose()?;
    let generator: Option<String> = keywords.value("generator")?;
    let degree = checked_degree(keywords)?;
    let loss = loss(keywords)?;
    let is_symmetric = keywords.flag("symmetric", false)?;
    let kind = match kind {
        None if generator.is_some() || degree.is_some() => Some(ModelKind::Harmonic),
        None if is_symmetric => Some(ModelKind::Bernstein),
        kind => kind,
    };
    if kind != Some(ModelKind::Harmonic) {
        if generator.is_some() || degree.is_some() {
            return refused("generator and degree belong to model=\"harmonic\"");
        }
        if loss != Loss::default() {
            return refused("loss belongs to model=\"harmonic\"");
        }
    }
    if kind != Some(ModelKind::Bernstein) && is_symmetric {
        return refused("symmetric belongs to model=\"bernstein\"; the other kinds always are");
    }
    let Some(kind) = kind else { return Ok(None) };
    Ok(Some(match (kind, generator) {
        (ModelKind::Bernstein, _) => RoomModel::Bernstein { is_symmetric },
        (ModelKind::Kriging, _) => RoomModel::Kriging,
        (_, Some(name)) => {
            let generator = generator_choice(&name)?;
            RoomModel::Harmonic(HarmonicOrder { generator, degree, ridge, loss })
        }
        (_, None) => {
            return refused(
                "model=\"harmonic\": found no generator, expected planar-nine, anser, a file \
                 (*.generator.ron), or learn",
            );
        }
    }))
}

/// The kinds of models to try, as they are named.
struct NamedKinds {
    names: Option<Vec<String>>,
    generators: Option<Vec<GeneratorChoice>>,
    degree: Option<usize>,
    loss: Loss,
}

impl NamedKinds {
    fn of(keywords: &Keywords) -> Done<Self> {
        let generators: Option<Vec<String>> = match keywords.object("generator")? {
            Some(one) if one.is_instance_of::<PyString>() => Some(vec![one.extract()?]),
            Some(several) => Some(several.extract()?),
            None => None,
        };
        let choices =
            |names: Vec<String>| names.iter().map(|name| generator_choice(name)).collect();
        Ok(Self {
            names: keywords.value("models")?,
            generators: generators.map(choices).transpose()?,
            degree: checked_degree(keywords)?,
            loss: loss(keywords)?,
        })
    }

    /// Where none is named, polynomials if an option of theirs is given, else all that the samples can be
    /// fitted with.
    fn kinds(&self, samples: &SampleSet, map: MapKind, has_lists: bool) -> Done<Vec<TriedKind>> {
        let polynomials = has_lists.then(|| vec![TriedKind::Bernstein.name().to_owned()]);
        let names = self.names.clone().or(polynomials);
        let of = TriedOptions {
            names: names.as_deref(),
            generators: self.generators.as_deref(),
            degree: self.degree,
            loss: self.loss,
        };
        Ok(of.kinds(samples, map).context("models")?)
    }
}

fn loss(keywords: &Keywords) -> Done<Loss> {
    keywords.one_of("loss", &[("huber", Loss::Huber), ("squares", Loss::Squares)])
}

fn checked_degree(keywords: &Keywords) -> Done<Option<usize>> {
    match keywords.value("degree")? {
        Some(degree) if !(1..=MAX_DEGREE).contains(&degree) => {
            let text = format!("degree: found {degree}, expected 1 to {MAX_DEGREE}");
            Err(TrackwrightError::new_err(text).into())
        }
        degree => Ok(degree),
    }
}

/// `learn`, a generator by its name, or one from a file.
fn generator_choice(name: &str) -> Done<GeneratorChoice> {
    if name == "learn" {
        return Ok(GeneratorChoice::Learned(None));
    }
    Ok(GeneratorChoice::Known(match Generator::built_in(name) {
        Some(generator) => generator,
        None => Files::default().read_generator(Path::new(name))?,
    }))
}

/// What only polynomials have, and whether each is given.
fn polynomial_options(
    request: &ModelRequest,
    fitting: &Fitting,
    extras: &Extras,
) -> [(&'static str, bool); 7] {
    [
        ("order", request.order.is_some()),
        ("directions", request.directions.is_some()),
        ("bounds", extras.bounds.is_some()),
        ("ridge", request.ridge.is_some()),
        ("method", fitting.method != FitMethod::default()),
        ("weights", fitting.weighting != Weighting::default()),
        ("rcond", fitting.rcond.to_bits() != DEFAULT_RCOND.to_bits()),
    ]
}

/// Refuses what another kind of model would not look at.
fn refuse_unused(
    request: &ModelRequest,
    held_out: Option<&HeldOut>,
    fitting: &Fitting,
    extras: &Extras,
    kind: ModelKind,
) -> Done<()> {
    let others = [
        ("hold_out", held_out.is_some()),
        ("support", !extras.with_support && kind == ModelKind::Kriging),
    ];
    // The only one that another kind has.
    let has_it = |name: &str| name == "ridge" && kind == ModelKind::Harmonic;
    let of_polynomials = polynomial_options(request, fitting, extras);
    let given = of_polynomials.into_iter().filter(|(name, _)| !has_it(name)).chain(others);
    if kind != ModelKind::Bernstein
        && let Some((name, _)) = { given }.find(|(_, is_given)| *is_given)
    {
        let text = format!("{name} does not go with model={:?}", kind.name());
        return Err(TrackwrightError::new_err(text).into());
    }
    // Choosing a model means boxes of the folds.
    let is_chosen = request.order.is_none() || request.directions.is_none();
    if extras.bounds.is_some() && (is_chosen || held_out.is_some()) {
        let text = "bounds needs order and directions, and does not go with hold_out";
        return Err(TrackwrightError::new_err(text).into());
    }
    Ok(())
}
