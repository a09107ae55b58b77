//! Designs: opened, changed by the editor's edits, and saved.

use crate::arrays::{pose, pose_array, quaternion_array, rotation, vector, vector_array};
use crate::choices::body_role;
use crate::environment::Environment;
use crate::errors::{Done, TrackwrightError};
use crate::long_work;
use crate::tables::{Notes, warn_of};
use nalgebra::{Point3, Unit, Vector3};
use numpy::PyArray1;
use pyo3::prelude::*;
use pyo3::types::PyDict;
use std::collections::BTreeMap;
use std::path::{Path, PathBuf};
use std::sync::Arc;
use trackwright_design::{BodyRole, Document, Edit, Origin, Target};
use trackwright_field as field;
use trackwright_field::samples::MapKind;
use trackwright_formats::{DesignFile, design_file};
use trackwright_geometry::limits::position_problem;
use trackwright_project::{
    Files, World, open_builtin, refresh_environment, refresh_metal, save_as,
};
use trackwright_simulation as simulation;
use trackwright_simulation::motion::{AxisRange, Motion};
use trackwright_simulation::{Coil, Metric, Pivot, Requirement, SensorOrientation};
use trackwright_sweep::number_paths;

/// A design with its room, its bodies and their meshes. It never changes: an edit gives another one.
#[pyclass(frozen, module = "trackwright")]
pub struct Design(World);

/// A sensor of a body.
#[pyclass(frozen, eq, module = "trackwright")]
#[derive(PartialEq)]
pub struct Sensor(simulation::Sensor);

impl Sensor {
    pub fn of(sensor: simulation::Sensor) -> Self {
        Self(sensor)
    }

    pub fn simulated(&self) -> &simulation::Sensor {
        &self.0
    }
}

impl Design {
    pub fn of(world: World) -> Self {
        Self(world)
    }

    pub fn world(&self) -> &World {
        &self.0
    }

    /// What messages call it: its file, or the name of a built-in one.
    pub fn label(&self) -> String {
        match self.0.document.origin() {
            Origin::File(file) => file.display().to_string(),
            Origin::BuiltIn(name) => (*name).to_owned(),
        }
    }

    /// Its room, and what messages call that: its file.
    pub fn own_room(&self) -> (String, &Arc<field::Environment>) {
        let reference = &self.0.document.design().environment;
        let label = match self.0.document.origin() {
            Origin::File(file) => file.parent().unwrap_or(Path::new("")).join(reference),
            Origin::BuiltIn(_) => PathBuf::from(reference),
        };
        (label.display().to_string(), &self.0.environment)
    }

    /// The design after some edits. There is no way back in it: the design before is still there.
    fn edited(&self, edits: impl IntoIterator<Item = Edit>) -> Done<Self> {
        let mut world = self.0.clone();
        for edit in edits {
            world.document.apply(edit)?;
        }
        let document = &world.document;
        let saved = document.saved().map(|(design, view)| (design.clone(), view.clone()));
        world.document = Document::recovered(
            document.design().clone(),
            document.own_view().clone(),
            document.origin().clone(),
            saved,
        );
        Ok(Self(world))
    }

    fn body(&self, role: BodyRole) -> Done<&simulation::RigidBody> {
        let body = self.0.document.design().body(role);
        let refused = || TrackwrightError::new_err("the design has no CRF");
        Ok(&body.ok_or_else(refused)?.rigid)
    }
}

/// What is to be known of a design in a room before its figures.
pub fn notes_of(world: &World, room: &field::Environment) -> Notes {
    let design = world.document.design();
    let sizes = design.bodies().filter_map(|(role, body)| {
        let doubt = body.rigid.size_doubt()?;
        Some(format!("{}: tip and sensors of the {role}: {doubt}", design.name))
    });
    let mut notes: Notes = sizes.collect();
    if room.model.map() == MapKind::Correction {
        notes.push(
            "the environment is a correction map, a function of the measured pose; \
             it is used as a distortion map"
                .to_owned(),
        );
    }
    notes
}

#[pymethods]
impl Design {
    /// Opens a design (`*.design.ron`) with its room, its bodies and their meshes.
    ///
    /// Raises FileNotFoundError for a file that is not there, and TrackwrightError for one that is no design.
    #[staticmethod]
    fn load(py: Python<'_>, path: PathBuf) -> Done<Self> {
        let world = long_work::run(py, |_| Ok(Files::default().open_design(&path)?))?;
        let problems = world
            .mesh_problems()
            .into_iter()
            .map(|problem| format!("{problem}; it is drawn without it"));
        let doubts = world.mesh_doubts().into_iter().map(|doubt| doubt.to_string());
        let notes = problems.chain(doubts).collect();
        warn_of(py, notes)?;
        Ok(Self(world))
    }

    /// Opens a design that is part of the package; see `builtin_names`.
    #[staticmethod]
    fn builtin(py: Python<'_>, name: &str) -> Done<Self> {
        Ok(Self(long_work::run(py, |_| Ok(open_builtin(name)?))?))
    }

    /// Names of the designs that are part of the package.
    #[staticmethod]
    fn builtin_names() -> Vec<&'static str> {
        trackwright_project::builtin_names().collect()
    }

    /// Writes the design, and beside it what changed of its bodies; returns the files that were written.
    ///
    /// What came from the disk stays where it is and is referred to; a built-in design is written whole.
    fn save(&self, py: Python<'_>, path: PathBuf) -> Done<Vec<PathBuf>> {
        long_work::run(py, |_| {
            let mut world = self.0.clone();
            Ok(save_as(&mut world, &path)?.written)
        })
    }

    /// The text of the design's own file, which refers to its bodies and its room.
    fn to_ron(&self) -> String {
        let document = &self.0.document;
        design_file::write(&DesignFile::of(document.design(), document.own_view()))
    }

    /// The design's name.
    #[getter]
    pub fn name(&self) -> &str {
        &self.0.document.design().name
    }

    /// The room that the design is in.
    #[getter]
    fn environment(&self) -> Environment {
        Environment::of_world(&self.0)
    }

    /// Whether the design has a coordinate reference frame (CRF).
    #[getter]
    fn has_crf(&self) -> bool {
        self.0.document.design().crf.is_some()
    }

    /// The sensors of a body, `"tool"` or `"crf"`.
    #[pyo3(signature = (body = "tool"))]
    fn sensors(&self, body: &str) -> Done<Vec<Sensor>> {
        let body = self.body(body_role(body)?)?;
        Ok(body.sensors.iter().cloned().map(Sensor).collect())
    }

    /// The body's tip, shape (3,), mm in its own frame; None for a body without one.
    #[pyo3(signature = (body = "tool"))]
    fn tip<'py>(&self, py: Python<'py>, body: &str) -> Done<Option<Bound<'py, PyArray1<f64>>>> {
        let tip = self.body(body_role(body)?)?.tip_in_body;
        Ok(tip.map(|tip| vector_array(py, tip.coords.into())))
    }

    /// The tool's pose, shape (7,): x, y, z in mm and qw, qx, qy, qz. It is in the CRF's frame, and in the
    /// tracker's where there is no CRF.
    #[getter]
    fn crf_from_tool<'py>(&self, py: Python<'py>) -> Bound<'py, PyArray1<f64>> {
        pose_array(py, &self.0.document.design().tool.crf_from_tool)
    }

    /// The CRF's pose in the tracker's frame, shape (7,), mm; None without a CRF.
    #[getter]
    fn tracker_from_crf<'py>(&self, py: Python<'py>) -> Option<Bound<'py, PyArray1<f64>>> {
        let crf = self.0.document.design().crf.as_ref()?;
        Some(pose_array(py, &crf.tracker_from_crf))
    }

    /// What is required of the tool's study: the name of a figure and its largest value, mm or degrees.
    #[getter]
    fn requirement<'py>(&self, py: Python<'py>) -> Done<Option<Bound<'py, PyDict>>> {
        requirement_dict(py, self.0.document.design().requirement.as_ref())
    }

    /// The tool's range of motion: an axis (x, y, z in mm; rx, ry, rz in degrees, all of the CRF) and its
    /// least value, largest value and step.
    #[getter]
    fn motion<'py>(&self, py: Python<'py>) -> Done<Option<Bound<'py, PyDict>>> {
        motion_dict(py, self.0.document.design().motion.as_ref())
    }

    /// The design with another name.
    fn with_name(&self, name: String) -> Done<Self> {
        self.edited([Edit::SetName(name)])
    }

    /// The design with a sensor changed, or with one more where the body has none of that name.
    ///
    /// position: shape (3,), mm, body's frame. One of: axis, shape (3,), a 5-DOF sensor's local z in the
    /// body's frame, of any length; rotation, shape (4,), a 6-DOF sensor's quaternion `body_from_sensor`,
    /// scalar first; marker, of an optical tracker, whose position alone is measured. coil: its diameter and
    /// length, mm. What is not given of a sensor that is there stays as it is.
    #[pyo3(signature = (
        name, position = None, *, axis = None, rotation = None, marker = false, coil = None,
        new_name = None, body = "tool"
    ))]
    #[expect(clippy::too_many_arguments, reason = "keywords in Python")]
    fn with_sensor(
        &self,
        name: String,
        position: Option<&Bound<'_, PyAny>>,
        axis: Option<&Bound<'_, PyAny>>,
        rotation: Option<&Bound<'_, PyAny>>,
        marker: bool,
        coil: Option<(f64, f64)>,
        new_name: Option<String>,
        body: &str,
    ) -> Done<Self> {
        let body = body_role(body)?;
        let sensors = &self.body(body)?.sensors;
        let index = sensors.iter().position(|sensor| sensor.name == name);
        let orientation = orientation(axis, rotation, marker)?;
        let position = position.map(|given| vector::<3>(given, "position")).transpose()?;
        let mut sensor = match (index, position, orientation) {
            (Some(index), ..) => sensors[index].clone(),
            (None, Some(position), Some(orientation)) => {
                simulation::Sensor::new(name, position, orientation)
            }
            (None, ..) => {
                let text = format!(
                    "sensor {name:?}: found none of this name to change, expected position and one of \
                     axis, rotation and marker for a new one"
                );
                return Err(TrackwrightError::new_err(text).into());
            }
        };
        if let Some(position) = position {
            sensor.position_in_body = Point3::from(position);
        }
        sensor.orientation = orientation.unwrap_or(sensor.orientation);
        if let Some((diameter_mm, length_mm)) = coil {
            sensor.coil = Some(Coil { diameter_mm, length_mm });
        }
        sensor.name = new_name.unwrap_or(sensor.name);
        self.edited([match index {
            Some(index) => Edit::SetSensor { body, index, sensor },
            None => Edit::AddSensor { body, sensor },
        }])
    }

    /// The design without a sensor.
    #[pyo3(signature = (name, *, body = "tool"))]
    fn without_sensor(&self, name: &str, body: &str) -> Done<Self> {
        let body = body_role(body)?;
        let names = self.body(body)?.sensors.iter().map(|sensor| sensor.name.as_str());
        let index = index_of("sensor", name, names)?;
        self.edited([Edit::RemoveSensor { body, index }])
    }

    /// The design with a tip at a position, shape (3,), mm, body's frame; without one where it is None.
    #[pyo3(signature = (position, *, body = "tool"))]
    fn with_tip(&self, position: Option<&Bound<'_, PyAny>>, body: &str) -> Done<Self> {
        let body = body_role(body)?;
        let tip = position.map(|given| vector::<3>(given, "position")).transpose()?;
        self.edited([Edit::SetTip { body, tip_in_body: tip.map(Point3::from) }])
    }

    /// The design with the tool at a pose, shape (7,): `crf_from_tool`, mm.
    fn with_tool_pose(&self, crf_from_tool: &Bound<'_, PyAny>) -> Done<Self> {
        self.edited([Edit::SetToolPose(pose(crf_from_tool, "crf_from_tool")?)])
    }

    /// The design with the CRF at a pose, shape (7,): `tracker_from_crf`, mm. The tool stays on it.
    fn with_crf_pose(&self, tracker_from_crf: &Bound<'_, PyAny>) -> Done<Self> {
        self.edited([Edit::SetCrfPose(pose(tracker_from_crf, "tracker_from_crf")?)])
    }

    /// The design with a range of motion, as `motion` has it; of the CRF's own study with body="crf".
    #[pyo3(signature = (motion, *, body = "tool"))]
    fn with_motion(&self, motion: Option<&Bound<'_, PyDict>>, body: &str) -> Done<Self> {
        let motion = motion.map(motion_of).transpose()?;
        self.edited([match body_role(body)? {
            BodyRole::Tool => Edit::SetMotion(motion),
            BodyRole::Crf => Edit::SetCrfMotion(motion),
        }])
    }

    /// The design with bounds on figures, as `requirement` has them; of the CRF's own study with body="crf".
    #[pyo3(signature = (requirement, *, body = "tool"))]
    fn with_requirement(&self, requirement: Option<&Bound<'_, PyDict>>, body: &str) -> Done<Self> {
        let requirement = requirement.map(requirement_of).transpose()?;
        self.edited([match body_role(body)? {
            BodyRole::Tool => Edit::SetRequirement(requirement),
            BodyRole::Crf => Edit::SetCrfRequirement(requirement),
        }])
    }

    /// The design with a target on the CRF moved or added: shape (3,), mm, CRF's frame.
    fn with_target(&self, name: String, position: &Bound<'_, PyAny>) -> Done<Self> {
        let position_in_crf = Point3::from(vector::<3>(position, "position")?);
        let target = Target { name, position_in_crf };
        let index = self.targets().position(|own| own.name == target.name);
        self.edited([match index {
            Some(index) => Edit::SetTarget { index, target },
            None => Edit::AddTarget(target),
        }])
    }

    /// The design without a target on the CRF.
    fn without_target(&self, name: &str) -> Done<Self> {
        let index = index_of("target", name, self.targets().map(|own| own.name.as_str()))?;
        self.edited([Edit::RemoveTarget { index }])
    }

    /// The design with another weight of an axis against a position in frame fitting, mm; None leaves it to
    /// the room.
    fn with_orientation_weight(&self, weight_mm: Option<f64>) -> Done<Self> {
        self.edited([Edit::SetOrientationWeight(weight_mm)])
    }

    /// The design in the room of a file (`*.env.ron`).
    fn with_environment(&self, py: Python<'_>, path: PathBuf) -> Done<Self> {
        long_work::run(py, |_| {
            let path = std::path::absolute(&path)?;
            let metal = Files::default().read_room(&path)?.metal;
            let file = path.to_string_lossy().into_owned();
            let Self(mut world) = self.edited([Edit::SetEnvironment { file, metal }])?;
            refresh_environment(&mut world)?;
            refresh_metal(&mut world)?;
            Ok(Self(world))
        })
    }

    /// The numbers that a plan of a sweep may vary, by their paths: each as it is and its unit.
    fn numbers(&self) -> BTreeMap<String, (f64, &'static str)> {
        let each = number_paths(self.0.document.design()).into_iter();
        each.map(|(path, value, unit)| (path, (value, unit))).collect()
    }

    fn __repr__(&self) -> String {
        format!("<trackwright.Design {:?}>", self.name())
    }
}

impl Design {
    fn targets(&self) -> impl Iterator<Item = &Target> {
        self.0.document.design().crf.iter().flat_map(|crf| &crf.targets)
    }
}

#[pymethods]
impl Sensor {
    /// A sensor of a body: position, shape (3,), mm, body's frame, and one of axis, rotation and marker, as in
    /// Design.with_sensor.
    #[new]
    #[pyo3(signature = (name, position, *, axis = None, rotation = None, marker = false, coil = None))]
    fn new(
        name: String,
        position: &Bound<'_, PyAny>,
        axis: Option<&Bound<'_, PyAny>>,
        rotation: Option<&Bound<'_, PyAny>>,
        marker: bool,
        coil: Option<(f64, f64)>,
    ) -> Done<Self> {
        let position = vector::<3>(position, "position")?;
        if let Some(expected) = position_problem(&position) {
            let text = format!("position: found {position:?}, expected {expected}");
            return Err(TrackwrightError::new_err(text).into());
        }
        let Some(orientation) = orientation(axis, rotation, marker)? else {
            let text = "found none of axis, rotation and marker, expected one of them";
            return Err(TrackwrightError::new_err(text).into());
        };
        let coil = coil.map(|(diameter_mm, length_mm)| Coil { diameter_mm, length_mm });
        Ok(Self(simulation::Sensor {
            coil,
            ..simulation::Sensor::new(name, position, orientation)
        }))
    }

    /// The sensor's name.
    #[getter]
    fn name(&self) -> &str {
        &self.0.name
    }

    /// 3 for a marker, 5 or 6.
    #[getter]
    fn degrees_of_freedom(&self) -> u8 {
        self.0.orientation.degrees_of_freedom()
    }

    /// Shape (3,), mm, body's frame.
    #[getter]
    fn position<'py>(&self, py: Python<'py>) -> Bound<'py, PyArray1<f64>> {
        vector_array(py, self.0.position_in_body.coords.into())
    }

    /// The sensor's local z, shape (3,), body's frame; None for a marker.
    #[getter]
    fn axis<'py>(&self, py: Python<'py>) -> Option<Bound<'py, PyArray1<f64>>> {
        self.0.axis_in_body().map(|axis| vector_array(py, axis.into_inner().into()))
    }

    /// A 6-DOF sensor's quaternion `body_from_sensor`, shape (4,), scalar first; None for others.
    #[getter]
    fn rotation<'py>(&self, py: Python<'py>) -> Option<Bound<'py, PyArray1<f64>>> {
        match &self.0.orientation {
            SensorOrientation::SixDof(rotation) => Some(quaternion_array(py, rotation)),
            SensorOrientation::Marker | SensorOrientation::FiveDof(_) => None,
        }
    }

    /// Diameter and length of its coil, mm, where they are known.
    #[getter]
    fn coil(&self) -> Option<(f64, f64)> {
        self.0.coil.map(|coil| (coil.diameter_mm, coil.length_mm))
    }

    fn __repr__(&self) -> String {
        let kind = self.0.orientation.kind_name();
        format!("<trackwright.Sensor {:?}, {kind}>", self.0.name)
    }
}

/// How a sensor is turned; `None` where nothing of it is given.
fn orientation(
    axis: Option<&Bound<'_, PyAny>>,
    quaternion: Option<&Bound<'_, PyAny>>,
    is_marker: bool,
) -> Done<Option<SensorOrientation>> {
    match (axis, quaternion, is_marker) {
        (None, None, false) => Ok(None),
        (None, None, true) => Ok(Some(SensorOrientation::Marker)),
        (Some(axis), None, false) => {
            let axis = Vector3::from(vector::<3>(axis, "axis")?);
            let length = axis.norm();
            let axis = Unit::try_new(axis, 0.0).filter(|_| length.is_finite());
            let refused = || {
                let text = format!("axis: found the length {length}, expected one above zero");
                TrackwrightError::new_err(text)
            };
            Ok(Some(SensorOrientation::FiveDof(axis.ok_or_else(refused)?)))
        }
        (None, Some(given), false) => {
            let quaternion = vector::<4>(given, "rotation")?;
            Ok(Some(SensorOrientation::SixDof(rotation(quaternion, "rotation", 0)?)))
        }
        _ => Err(TrackwrightError::new_err(
            "found several of axis, rotation and marker, expected one of them",
        )
        .into()),
    }
}

fn index_of<'a>(what: &str, name: &str, names: impl Iterator<Item = &'a str>) -> Done<usize> {
    let names: Vec<&str> = names.collect();
    names.iter().position(|own| *own == name).ok_or_else(|| {
        let expected = names.join(", ");
        let text = format!("found no {what} {name:?}, expected one of {expected}");
        TrackwrightError::new_err(text).into()
    })
}

/// `{"pivot": …, "x": (min, max, step), "rx": …}`, mm and degrees.
fn motion_of(given: &Bound<'_, PyDict>) -> Done<Motion> {
    let names = Motion::default().axes().map(|(name, _)| name);
    let mut motion = Motion::default();
    for (axis, range) in given {
        let axis: String = axis.extract()?;
        if axis == "pivot" {
            motion.pivot = pivot_of(&range)?;
            continue;
        }
        let index = index_of("axis", &axis, names.into_iter())?;
        let [min, max, step] = vector::<3>(&range, &format!("motion, {axis}"))?;
        motion = motion.with_axis(index, Some(AxisRange { min, max, step }));
    }
    Ok(motion)
}

/// `"origin"`, `"tip"`, `{"body": (x, y, z)}` or `{"reference": (x, y, z)}`, mm.
fn pivot_of(given: &Bound<'_, PyAny>) -> Done<Pivot> {
    if let Ok(point) = given.cast::<PyDict>()
        && let [(of, at)] = point.iter().collect::<Vec<_>>().as_slice()
    {
        let (of, at) = (of.extract::<String>()?, vector::<3>(at, "motion, pivot")?);
        match of.as_str() {
            "body" => return Ok(Pivot::Body(at)),
            "reference" => return Ok(Pivot::Reference(at)),
            _ => {}
        }
    }
    match given.extract::<String>().as_deref() {
        Ok("origin") => Ok(Pivot::Origin),
        Ok("tip") => Ok(Pivot::Tip),
        _ => {
            let text = format!(
                "motion, pivot: found {given:?}, expected \"origin\", \"tip\", \
                 {{\"body\": (x, y, z)}} or {{\"reference\": (x, y, z)}}"
            );
            Err(TrackwrightError::new_err(text).into())
        }
    }
}

fn motion_dict<'py>(py: Python<'py>, motion: Option<&Motion>) -> Done<Option<Bound<'py, PyDict>>> {
    let Some(motion) = motion else { return Ok(None) };
    let found = PyDict::new(py);
    let point = |of: &str, at: [f64; 3]| {
        let point = PyDict::new(py);
        point.set_item(of, (at[0], at[1], at[2])).map(|()| point)
    };
    match motion.pivot {
        Pivot::Origin => {}
        Pivot::Tip => found.set_item("pivot", "tip")?,
        Pivot::Body(at) => found.set_item("pivot", point("body", at)?)?,
        Pivot::Reference(at) => found.set_item("pivot", point("reference", at)?)?,
    }
    for (axis, range) in motion.axes() {
        if let Some(AxisRange { min, max, step }) = range {
            found.set_item(axis, (min, max, step))?;
        }
    }
    Ok(Some(found))
}

/// Bounds by the names of their figures, mm and degrees.
fn requirement_of(given: &Bound<'_, PyDict>) -> Done<Requirement> {
    let mut requirement = Requirement::default();
    for (name, limit) in given {
        let name: String = name.extract()?;
        let metric = Metric::bounded().find(|metric| metric.name() == name).ok_or_else(|| {
            let names: Vec<&str> = Metric::bounded().map(|metric| metric.name()).collect();
            let expected = names.join(", ");
            let text = format!("requirement: found {name:?}, expected one of {expected}");
            TrackwrightError::new_err(text)
        })?;
        requirement = requirement.with(metric, Some(limit.extract()?));
    }
    Ok(requirement)
}

fn requirement_dict<'py>(
    py: Python<'py>,
    requirement: Option<&Requirement>,
) -> Done<Option<Bound<'py, PyDict>>> {
    let Some(requirement) = requirement else { return Ok(None) };
    let found = PyDict::new(py);
    for (metric, limit) in requirement.bounds() {
        found.set_item(metric.name(), limit)?;
    }
    Ok(Some(found))
}
