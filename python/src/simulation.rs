//! Studies: a design simulated in a room, its figures and its trials.

use crate::choices::{one_of, outside_policy};
use crate::design::{Design, notes_of};
use crate::environment::Environment;
use crate::errors::{Done, TrackwrightError};
use crate::fitting::jitter;
use crate::found::Found;
use crate::keywords::Keywords;
use crate::long_work;
use crate::records::{Cell, Field, Records};
use crate::tables::{Notes, Table, of_memory, take, warn_of};
use anyhow::Context;
use pyo3::prelude::*;
use pyo3::types::{PyDict, PyString};
use std::sync::Arc;
use trackwright_calibration::doubts::{PoseFrame, of_input, with_written_quaternions};
use trackwright_design::BodyRole;
use trackwright_field as field;
use trackwright_field::OutsidePolicy;
use trackwright_field::environment::Jitter;
use trackwright_geometry::pose::pose_to_array;
use trackwright_project::{Doubted, Files, coil_findings, resolve, resolve_crf};
use trackwright_report::study::StudyReport;
use trackwright_result::{Section, data};
use trackwright_simulation::support::SupportSurvey;
use trackwright_simulation::uncertainty::{
    DEFAULT_SAMPLES, Sampling, UncertaintyError, UncertaintyMethods, UncertaintyReport,
};
use trackwright_simulation::{
    self as simulation, InputTrial, Mode, NoInterval, Outcome, RoomFieldFigures, Scenario, Trial,
    coil_section, run, survey,
};
use trackwright_task::Task;

const EXPECTED_TOOL: &str =
    "the columns of an input table (tool_x, tool_y, tool_z, tool_qw, …, tool_qz)";
const EXPECTED_CRF: &str = "all of crf_x … crf_qz, or none of them";

/// What a study found.
#[pyclass(frozen, extends = Found, module = "trackwright")]
pub struct Simulation {
    trials: Py<PyAny>,
}

#[pymethods]
impl Simulation {
    /// The trials, a record each, as `trackwright simulate --log` writes them: true_x … true_qz and sim_x …
    /// sim_qz, the tool's true and simulated pose in the CRF's frame (mm, unit quaternions); err_x, err_y,
    /// err_z and err_mm, the tip's error (mm, CRF's frame); err_deg, the angle's; outside and out_of_volume,
    /// how many sensors were there.
    #[getter]
    fn trials(&self, py: Python<'_>) -> Py<PyAny> {
        self.trials.clone_ref(py)
    }
}

impl Simulation {
    fn new(
        py: Python<'_>,
        (section, trials): (Section, Vec<Trial>),
        notes: Notes,
    ) -> Done<Py<Self>> {
        let trials = records(&trials).into_numpy(py)?.unbind();
        Ok(Py::new(py, (Self { trials }, Found::new(py, section, notes)?))?)
    }
}

/// Simulates a design at one pose, over its range of motion, or at given poses.
///
/// mode: "single", "motion", or "input" with poses: a file, or a table in memory with the columns tool_x …
/// tool_qz (`crf_from_tool`, mm, unit quaternions) and, perhaps, crf_x … crf_qz (`tracker_from_crf`).
/// environment: the design's own where it is None. outside: as in Environment.distort; trials that are
/// rejected are left out and counted. expected=False finds `figures["room_field"]` and the counts alone,
/// without `figures["figures"]`, intervals and verdict, where errors come from and which coils do not fit,
/// which take most of the time.
///
/// support=True adds `figures["support"]`: how many trials lean on field that no samples support, and the
/// standard errors of the field there. uncertainty adds `figures["uncertainty"]`: how far the tracker's jitter
/// scatters the tip, by "first-order", "monte-carlo" of one pose with samples and a seed, or both of them in a
/// list. The jitter is the room's, or jitter_position_mm and jitter_angle_deg, standard deviations per axis.
#[pyfunction]
#[pyo3(
    signature = (design, mode = "single", **options),
    text_signature = "(design, mode='single', *, environment=None, poses=None, outside='clamp', \
        expected=True, support=False, uncertainty=None, samples=100000, seed=0, \
        jitter_position_mm=None, jitter_angle_deg=None, jitter_growth_mm=None, as_is=False)"
)]
pub fn simulate(
    py: Python<'_>,
    design: &Bound<'_, Design>,
    mode: &str,
    options: Option<&Bound<'_, PyDict>>,
) -> Done<Py<Simulation>> {
    let keywords = Keywords::of(options);
    let design = design.get();
    let world = design.world();
    let outside = keywords.value::<String>("outside")?;
    let outside = outside.map_or(Ok(OutsidePolicy::Clamp), |name| outside_policy(&name))?;
    let environment: Option<Bound<'_, Environment>> = keywords.value("environment")?;
    let poses = keywords.object("poses")?;
    let has_expected = keywords.flag("expected", true)?;
    let has_support = keywords.flag("support", false)?;
    let uncertainty = Uncertainty::of(&keywords, mode)?;
    let as_is = keywords.flag("as_is", false)?;
    keywords.finish()?;
    let mut notes = Notes::new();
    let room = environment.as_ref().map_or(&world.environment, |room| &room.get().solved);
    let mode = match poses {
        None if mode == "input" => {
            return Err(TrackwrightError::new_err("mode \"input\" needs poses").into());
        }
        None => one_of("mode", mode, &[("single", Mode::Single), ("motion", Mode::Motion)])?,
        Some(poses) if mode == "input" => {
            let scenario = resolve(world.document.design(), room);
            let trials = input_trials(&poses, scenario.crf.is_some())?;
            let trials = trials.and(|trials| of_input(trials, &scenario));
            Mode::Input(take(trials, as_is, &mut notes)?.into())
        }
        Some(_) => {
            let text = format!("poses: found the mode {mode:?}, expected \"input\"");
            return Err(TrackwrightError::new_err(text).into());
        }
    };
    notes.extend(notes_of(world, room));
    let room = match &uncertainty {
        Some(uncertainty) => &uncertainty.room(room)?,
        None => room,
    };
    let found = long_work::run(py, |task| {
        let named = || design.label();
        let mut scenario = resolve(world.document.design(), room);
        scenario.outside = outside;
        let of = (&scenario, &mode);
        // Before the trials: what cannot be found is an error.
        let weight_mm = world.document.design().orientation_weight_mm;
        let scattered = uncertainty.map(|uncertainty| {
            let Uncertainty { methods, source, .. } = uncertainty;
            UncertaintyReport::of(of, source, weight_mm, &methods, task).with_context(named)
        });
        let scattered = scattered.transpose()?;
        let support = has_support.then(|| survey(&scenario, &mode, task).with_context(named));
        let support = support.transpose()?;
        let Studied { mut section, outcome, trials, note } = match has_expected {
            true => study(BodyRole::Tool, of, task),
            false => run_alone(of, task),
        }
        .with_context(named)?;
        notes.extend(note);
        if let Some(scattered) = &scattered {
            section = section.with(scattered.section(&outcome).named("uncertainty"));
        }
        section = section.with_all(support.as_ref().map(SupportSurvey::section));
        let coils = if has_expected { coil_findings(world) } else { Vec::new() };
        Ok((section.with(coil_section(&coils)), trials))
    })?;
    Simulation::new(py, found, notes)
}

/// How far jitter scatters the tip: by which methods, and which jitter.
struct Uncertainty {
    methods: UncertaintyMethods,
    /// That of the keywords; the room's where there is none.
    jitter: Option<Jitter>,
    source: &'static str,
}

impl Uncertainty {
    /// What the keywords request; `None` where that is nothing.
    fn of(keywords: &Keywords, mode: &str) -> Done<Option<Self>> {
        let refused = |text: &str| Err(TrackwrightError::new_err(text.to_owned()).into());
        let names: Vec<String> = match keywords.object("uncertainty")? {
            Some(one) if one.is_instance_of::<PyString>() => vec![one.extract()?],
            Some(several) => several.extract()?,
            None => Vec::new(),
        };
        let samples: Option<usize> = keywords.value("samples")?;
        let seed: Option<u64> = keywords.value("seed")?;
        let jitter = jitter(keywords)?;
        let mut methods = UncertaintyMethods::default();
        for name in &names {
            let known = [("first-order", false), ("monte-carlo", true)];
            match one_of("uncertainty", name, &known)? {
                false => methods.first_order = true,
                true => {
                    let samples = samples.unwrap_or(DEFAULT_SAMPLES);
                    let seed = seed.unwrap_or_default();
                    methods.monte_carlo = Some(Sampling { samples, seed });
                }
            }
        }
        if methods.monte_carlo.is_none() && (samples.is_some() || seed.is_some()) {
            return refused("samples and seed need uncertainty=\"monte-carlo\"");
        }
        if names.is_empty() {
            return match jitter {
                Some(_) => refused("jitter_position_mm needs uncertainty"),
                None => Ok(None),
            };
        }
        match mode {
            "input" => refused("uncertainty needs the mode \"single\" or \"motion\""),
            "motion" if methods.monte_carlo.is_some() => refused(
                "uncertainty=\"monte-carlo\" needs the mode \"single\"; over a range of motion there is \
                 uncertainty=\"first-order\"",
            ),
            _ => {
                let source = if jitter.is_some() { "keywords" } else { "environment" };
                Ok(Some(Self { methods, jitter, source }))
            }
        }
    }

    /// The room with the jitter.
    fn room(&self, room: &Arc<field::Environment>) -> Done<Arc<field::Environment>> {
        match (self.jitter, &room.jitter) {
            (Some(jitter), _) => {
                Ok(Arc::new(field::Environment { jitter: Some(jitter), ..(**room).clone() }))
            }
            (None, Some(_)) => Ok(Arc::clone(room)),
            (None, None) => {
                let text = format!(
                    "{}; state it with jitter_position_mm and jitter_angle_deg, here or in Environment.fit",
                    UncertaintyError::NoJitter { environment: room.name.clone() }
                );
                Err(TrackwrightError::new_err(text).into())
            }
        }
    }
}

/// Simulates the design's CRF alone against the tracker, once for each of its targets.
///
/// `figures` name the target; errors are in the tracker's frame, mm.
#[pyfunction]
#[pyo3(signature = (design, mode = "single", *, environment = None, outside = "clamp"))]
pub fn simulate_crf(
    py: Python<'_>,
    design: &Bound<'_, Design>,
    mode: &str,
    environment: Option<&Bound<'_, Environment>>,
    outside: &str,
) -> Done<Vec<Py<Simulation>>> {
    let design = design.get();
    let world = design.world();
    let outside = outside_policy(outside)?;
    let mode = one_of("mode", mode, &[("single", Mode::Single), ("motion", Mode::Motion)])?;
    let label = design.label();
    let refused = |what: &str| TrackwrightError::new_err(format!("{label}: {what}"));
    match &world.document.design().crf {
        None => return Err(refused("the design has no CRF to simulate").into()),
        Some(crf) if matches!(mode, Mode::Motion) && crf.motion.is_none() => {
            let what = "crf.motion is absent, expected the CRF's own range of motion";
            return Err(refused(what).into());
        }
        Some(_) => {}
    }
    let room = environment.map_or(&world.environment, |room| &room.get().solved);
    let mut notes = notes_of(world, room);
    let found = long_work::run(py, |task| {
        let each = resolve_crf(world.document.design(), room).into_iter().map(|at| {
            let mut scenario = at.scenario;
            scenario.outside = outside;
            let Studied { section, trials, note, .. } =
                study(BodyRole::Crf, (&scenario, &mode), task).with_context(|| label.clone())?;
            notes.extend(note);
            Ok((section.with(data("target", at.target)), trials))
        });
        each.collect::<Done<Vec<_>>>()
    })?;
    warn_of(py, notes)?;
    found.into_iter().map(|found| Simulation::new(py, found, Notes::new())).collect()
}

/// A study with all of its trials, and why a room that was measured gives its figures no interval.
struct Studied {
    section: Section,
    /// By the room's model alone.
    outcome: RoomFieldFigures,
    trials: Vec<Trial>,
    note: Option<String>,
}

fn study(
    role: BodyRole,
    (scenario, mode): (&Scenario, &Mode),
    task: &Task,
) -> anyhow::Result<Studied> {
    let mut trials = Vec::new();
    let mut keep = |trial: &Trial| trials.push(*trial);
    let found = simulation::study(scenario, mode, &task.cancel, Some(&mut keep))?;
    let last = trials.last().copied();
    let report = StudyReport::of(role, (scenario, mode), found, last, &task.cancel)?;
    let note = match &report.study.figures.no_interval {
        Some(NoInterval::NoneDrawn(why)) => Some(format!("the figures have no interval: {why}")),
        _ => None,
    };
    let section = report.section((scenario, mode), false);
    Ok(Studied { section, outcome: report.study.room_field, trials, note })
}

/// The figures of the room's model alone alone.
fn run_alone((scenario, mode): (&Scenario, &Mode), task: &Task) -> anyhow::Result<Studied> {
    let mut trials = Vec::new();
    let mut keep = |trial: &Trial| trials.push(*trial);
    let Outcome { room_field, .. } = run(scenario, mode, &task.cancel, Some(&mut keep))?;
    let single = trials.last().filter(|_| matches!(mode, Mode::Single));
    let section = room_field.section(single);
    Ok(Studied { section, outcome: room_field, trials, note: None })
}

/// Given poses; the CRF's columns count only for a design that has one.
fn input_trials(given: &Bound<'_, PyAny>, has_crf: bool) -> Done<Doubted<Vec<InputTrial>>> {
    let columns = match Table::of(given)? {
        Table::File(file) => return Ok(Files::default().read_input(&file, has_crf)?),
        Table::Memory(columns) => columns,
    };
    let crf_from_tool = columns.poses("tool_", EXPECTED_TOOL)?.all()?;
    let tracker_from_crf = match has_crf && columns.has_pose("crf_")? {
        true => columns.poses("crf_", EXPECTED_CRF)?.all()?.into_iter().map(Some).collect(),
        false => vec![None; crf_from_tool.len()],
    };
    let suspicions = with_written_quaternions(&crf_from_tool, PoseFrame::Any);
    let each = tracker_from_crf.into_iter().zip(crf_from_tool);
    let trials = each
        .map(|(tracker_from_crf, crf_from_tool)| InputTrial { tracker_from_crf, crf_from_tool })
        .collect();
    Ok(of_memory(trials, "poses", suspicions))
}

/// The trials as the log of `simulate --log` has them.
fn records(trials: &[Trial]) -> Records<21> {
    use Field::{Count, Float};
    let fields = [
        ("true_x", Float),
        ("true_y", Float),
        ("true_z", Float),
        ("true_qw", Float),
        ("true_qx", Float),
        ("true_qy", Float),
        ("true_qz", Float),
        ("sim_x", Float),
        ("sim_y", Float),
        ("sim_z", Float),
        ("sim_qw", Float),
        ("sim_qx", Float),
        ("sim_qy", Float),
        ("sim_qz", Float),
        ("err_x", Float),
        ("err_y", Float),
        ("err_z", Float),
        ("err_mm", Float),
        ("err_deg", Float),
        ("outside", Count),
        ("out_of_volume", Count),
    ];
    let mut found = Records::new(fields, trials.len());
    for trial in trials {
        let [t, s] = [&trial.crf_from_tool, &trial.crf_from_tool_simulated].map(pose_to_array);
        let e = trial.tip_error_in_crf_mm;
        let floats = [
            t[0],
            t[1],
            t[2],
            t[3],
            t[4],
            t[5],
            t[6],
            s[0],
            s[1],
            s[2],
            s[3],
            s[4],
            s[5],
            s[6],
            e.x,
            e.y,
            e.z,
            trial.tip_error_mm,
            trial.angle_error_deg,
        ];
        let counts = [trial.outside, trial.out_of_volume];
        found.push(std::array::from_fn(|k| match floats.get(k) {
            Some(value) => Cell::Float(*value),
            None => Cell::Count(counts[k - floats.len()]),
        }));
    }
    found
}
