//! Rooms: loaded and saved, and applied to poses.

use crate::arrays::{parts, poses};
use crate::choices::{one_of, outside_policy};
use crate::errors::{Done, TrackwrightError};
use crate::fitting;
use crate::found::Found;
use crate::long_work;
use crate::records::{Cell, Field, Records};
use crate::tables::{Notes, of_memory, take, warn_of};
use crate::values::to_python;
use numpy::{IntoPyArray, PyArray1, PyArray2};
use pyo3::prelude::*;
use pyo3::types::PyDict;
use std::path::PathBuf;
use std::sync::Arc;
use trackwright_calibration::doubts::{PoseFrame, in_room, with_written_quaternions};
use trackwright_field as field;
use trackwright_field::FieldPoint;
use trackwright_field::OutsidePolicy;
use trackwright_field::compensation::{Compensation, Method};
use trackwright_field::computed::FieldSource;
use trackwright_field::inverse::InverseState;
use trackwright_field::samples::MapKind;
use trackwright_geometry::pose::Pose;
use trackwright_project::{Files, RoomContent, World};
use trackwright_report::room::map_name;
use trackwright_result::{Section, with_separators};

/// A measured room: the distortion of the tracker's field, and where it may be used.
#[pyclass(frozen, module = "trackwright")]
pub struct Environment {
    /// With its metal.
    pub solved: Arc<field::Environment>,
    content: RoomContent,
    /// What messages call it: its file or its name.
    label: String,
    /// Those of the fit that made it.
    figures: Option<Section>,
}

/// Poses as the tracker would report them.
#[pyclass(frozen, get_all, module = "trackwright")]
pub struct Readings {
    positions: Py<PyArray2<f64>>,
    quaternions: Py<PyArray2<f64>>,
    outside: Py<PyArray1<bool>>,
}

/// Readings that were corrected.
#[pyclass(frozen, get_all, extends = Found, module = "trackwright")]
pub struct Corrected {
    positions: Py<PyArray2<f64>>,
    quaternions: Py<PyArray2<f64>>,
    outside: Py<PyArray1<bool>>,
    converged: Py<PyArray1<bool>>,
    ambiguous: Py<PyArray1<bool>>,
}

impl Environment {
    /// The room of a design, with the design's metal.
    pub fn of_world(world: &World) -> Self {
        let bare = Arc::clone(world.bare_environment());
        let metal = world.document.design().room_metal.clone();
        let content = RoomContent { bare, metal };
        let solved = Arc::clone(&world.environment);
        Self { label: solved.name.clone(), solved, content, figures: None }
    }

    /// A room that was fitted.
    pub fn fitted(environment: field::Environment, figures: Section) -> Self {
        let bare = Arc::new(environment);
        let content = RoomContent { bare: Arc::clone(&bare), metal: None };
        Self { label: bare.name.clone(), solved: bare, content, figures: Some(figures) }
    }

    /// What messages call it: its file or its name.
    pub fn label(&self) -> &str {
        &self.label
    }

    /// Poses of sensors that the room is applied to.
    fn sensor_poses(
        &self,
        (positions, quaternions): (&Bound<'_, PyAny>, &Bound<'_, PyAny>),
        as_is: bool,
        notes: &mut Notes,
    ) -> Done<Vec<Pose>> {
        let poses = poses(positions, quaternions)?;
        let suspicions = with_written_quaternions(&poses, PoseFrame::Tracker);
        let doubted = of_memory(poses, "poses", suspicions);
        let doubted = doubted.and(|poses| in_room(poses, self.solved.model.bounds()));
        take(doubted, as_is, notes)
    }
}

#[pymethods]
impl Environment {
    /// Opens a room (`*.env.ron`), with its metal solved for.
    #[staticmethod]
    fn load(py: Python<'_>, path: PathBuf) -> Done<Self> {
        long_work::run(py, |task| {
            let content = Files::default().read_room(&path)?;
            let solved = content.solved(&path, task)?.environment;
            Ok(Self { solved, content, label: path.display().to_string(), figures: None })
        })
    }

    /// A room from measurements: as `trackwright fit` makes it.
    ///
    /// table: a file, or a table in memory with the columns ideal_x … ideal_z and measured_x … measured_z
    /// (mm, tracker's frame) and, where orientations were measured, ideal_qw … ideal_qz and
    /// measured_qw … measured_qz (unit quaternions, scalar first). A table in memory is a NumPy structured
    /// array, a mapping of columns, or anything with the DataFrame interchange protocol.
    ///
    /// Where no model is named the best of all kinds is taken; an option of polynomials names those, and order
    /// and directions that are None are chosen by cross-validation. lag is how many rows the measured side is
    /// behind the ideal one: each reading is put beside the ideal pose of its moment. sensor_offset is how many mm
    /// measured positions are along the sensor's z axis from ideal ones; it is taken out. holdout is a second table, to judge
    /// the room on. bounds is the box of a polynomial model, shape (2, 3), mm: its least and its largest corner;
    /// that of the positions where it is None. as_is takes tables that are suspected not to be what they are read as. `figures` of the
    /// room are those of the fit.
    #[staticmethod]
    #[pyo3(
        signature = (table, **options),
        text_signature = "(table, *, order=None, directions=None, ridge=None, method='per-direction', \
            map='distortion', sensors='5dof', lag=0.0, sensor_offset=0.0, weights='area', rcond=1e-10, model=None, \
            symmetric=False, generator=None, degree=None, loss='huber', holdout=None, hold_out=None, \
            volume=None, support=True, jitter_position_mm=None, jitter_angle_deg=None, \
            jitter_growth_mm=None, registration_mm=None, registration_deg=None, \
            bounds=None, name=None, as_is=False)"
    )]
    fn fit(
        py: Python<'_>,
        table: &Bound<'_, PyAny>,
        options: Option<&Bound<'_, PyDict>>,
    ) -> Done<Self> {
        let (environment, figures) = fitting::fit(py, table, options)?;
        Ok(Self::fitted(environment, figures))
    }

    /// The room of the model that does best on rows held out: as `trackwright select --output` makes it.
    ///
    /// table, lag and sensor_offset: as for `fit`. models names the kinds to try, of none, bernstein, symmetric, kriging and
    /// harmonic; all where it is None.
    /// orders, directions and ridges are lists of what is tried. hold_out is rows, groups, sensors, or a
    /// column whose rows with equal text belong together. `figures` of the room are those of the choice.
    #[staticmethod]
    #[pyo3(
        signature = (table, **options),
        text_signature = "(table, *, models=None, orders=None, directions=None, \
            ridges=None, folds=5, group=None, hold_out=None, seed=0, method='per-direction', \
            map='distortion', sensors='5dof', lag=0.0, sensor_offset=0.0, weights='area', rcond=1e-10, generator=None, \
            degree=None, loss='huber', volume=None, jitter_position_mm=None, \
            jitter_angle_deg=None, jitter_growth_mm=None, registration_mm=None, \
            registration_deg=None, name=None, as_is=False)"
    )]
    fn select(
        py: Python<'_>,
        table: &Bound<'_, PyAny>,
        options: Option<&Bound<'_, PyDict>>,
    ) -> Done<Self> {
        let (environment, figures) = fitting::select(py, table, options)?;
        Ok(Self::fitted(environment, figures))
    }

    /// Writes the room. Another program's document is written over only with overwrite=True.
    #[pyo3(signature = (path, *, overwrite = false))]
    fn save(&self, py: Python<'_>, path: PathBuf, overwrite: bool) -> Done<()> {
        long_work::run(py, |_| {
            let files = Files::overwriting(overwrite);
            let output = files.output(&path)?;
            match &self.content.metal {
                Some(metal) => output.write_room(&self.content.bare, metal)?,
                None => output.write_environment(&self.content.bare)?,
            }
            Ok(())
        })
    }

    /// The room's name.
    #[getter]
    fn name(&self) -> &str {
        &self.solved.name
    }

    /// "distortion", a function of the true pose, or "correction", of the measured one.
    #[getter]
    fn map(&self) -> &'static str {
        map_name(self.solved.model.map())
    }

    /// The model's kind: bernstein, kriging, harmonic or simulated.
    #[getter]
    fn model(&self) -> &'static str {
        self.solved.model.kind().name()
    }

    /// The model's box in the tracker's frame, shape (2, 3): its least and its largest corner, mm.
    #[getter]
    fn bounds<'py>(&self, py: Python<'py>) -> Done<Bound<'py, PyArray2<f64>>> {
        let bounds = self.solved.model.bounds();
        crate::arrays::matrix(py, vec![bounds.min_mm.coords.into(), bounds.max_mm.coords.into()])
    }

    /// The figures of the fit or of the choice that made the room, as `--format json` prints them; None of
    /// a room that was loaded.
    #[getter]
    fn figures<'py>(&self, py: Python<'py>) -> PyResult<Option<Bound<'py, PyAny>>> {
        self.figures.as_ref().map(|figures| to_python(py, &figures.to_json())).transpose()
    }

    /// Poses of sensors as the tracker would report them.
    ///
    /// positions: shape (n, 3), mm, tracker's frame. quaternions: shape (n, 4), `tracker_from_sensor`, scalar
    /// first. outside: what stands for the field out of the model's box, "clamp", "extrapolate" or "reject".
    #[pyo3(signature = (positions, quaternions, *, outside = "clamp", as_is = false))]
    fn distort(
        &self,
        py: Python<'_>,
        positions: &Bound<'_, PyAny>,
        quaternions: &Bound<'_, PyAny>,
        outside: &str,
        as_is: bool,
    ) -> Done<Readings> {
        let outside = outside_policy(outside)?;
        let mut notes = Notes::new();
        let ideal = self.sensor_poses((positions, quaternions), as_is, &mut notes)?;
        let found = long_work::run(py, |task| {
            let mut found = Vec::with_capacity(ideal.len());
            for (row, pose) in ideal.iter().enumerate() {
                if row % ROWS_PER_STEP == 0 {
                    task.step(row, ideal.len())?;
                }
                found.push(self.solved.model.distort(pose, outside));
            }
            Ok(found)
        })?;
        let is_outside: Vec<bool> = found.iter().map(|(_, is_inside)| !is_inside).collect();
        notes.extend(note_outside(is_outside.iter().filter(|o| **o).count(), ideal.len(), outside));
        warn_of(py, notes)?;
        let is_kept = |is_inside: bool| is_inside || outside != OutsidePolicy::Reject;
        let (positions, quaternions) =
            parts(py, found.into_iter().map(|(pose, inside)| is_kept(inside).then_some(pose)))?;
        Ok(Readings {
            positions: positions.unbind(),
            quaternions: quaternions.unbind(),
            outside: is_outside.into_pyarray(py).unbind(),
        })
    }

    /// Poses of 6-DOF sensors as the tracker would report them, of a room with a harmonic model: the fields
    /// that it is made of determine what all three axes of a sensor measure.
    ///
    /// positions and quaternions as for `distort`. Beyond the model's box the fields are used as they are.
    #[pyo3(signature = (positions, quaternions, *, as_is = false))]
    fn distort_6dof(
        &self,
        py: Python<'_>,
        positions: &Bound<'_, PyAny>,
        quaternions: &Bound<'_, PyAny>,
        as_is: bool,
    ) -> Done<Readings> {
        let model = &self.solved.model;
        let Some(FieldSource::Harmonic(harmonic)) = model.computed().map(|field| field.source())
        else {
            let (name, found) = (&self.solved.name, model.kind().name());
            let text = format!("{name}: found a {found} model, expected a harmonic one");
            return Err(TrackwrightError::new_err(text).into());
        };
        let mut notes = Notes::new();
        let ideal = self.sensor_poses((positions, quaternions), as_is, &mut notes)?;
        let found = long_work::run(py, |task| {
            let mut found = Vec::with_capacity(ideal.len());
            for (row, pose) in ideal.iter().enumerate() {
                task.step(row, ideal.len())?;
                found.push(harmonic.read_pose(pose).ok().map(|read| read.tracker_from_sensor));
            }
            Ok(found)
        })?;
        let is_outside = |pose: &Pose| !model.bounds().contains(&pose.translation.vector.into());
        let outside: Vec<bool> = ideal.iter().map(is_outside).collect();
        let count = outside.iter().filter(|outside| **outside).count();
        notes.extend(note_outside(count, ideal.len(), OutsidePolicy::Extrapolate));
        warn_of(py, notes)?;
        let (positions, quaternions) = parts(py, found)?;
        Ok(Readings {
            positions: positions.unbind(),
            quaternions: quaternions.unbind(),
            outside: outside.into_pyarray(py).unbind(),
        })
    }

    /// Readings corrected: the poses whose distortion is what was measured.
    ///
    /// positions: shape (n, 3), mm, tracker's frame, as measured. quaternions: shape (n, 4), scalar first.
    /// method: "auto" is a correction map directly and a distortion map by its inverse; "inverse"; "shortcut"
    /// uses a distortion map as if it were a correction.
    #[pyo3(signature = (
        positions, quaternions, *, outside = "clamp", method = "auto", as_is = false
    ))]
    fn compensate(
        &self,
        py: Python<'_>,
        positions: &Bound<'_, PyAny>,
        quaternions: &Bound<'_, PyAny>,
        outside: &str,
        method: &str,
        as_is: bool,
    ) -> Done<Py<Corrected>> {
        let outside = outside_policy(outside)?;
        let model = &self.solved.model;
        let known = [
            ("auto", Method::of(model.map())),
            ("inverse", Method::Inverse),
            ("shortcut", Method::Shortcut),
        ];
        let wanted = one_of("method", method, &known)?;
        if model.map() == MapKind::Correction && wanted != Method::Correction {
            let text = format!(
                "{}: found a correction map, expected a distortion map with the method {method:?}; \
                 \"auto\" applies a correction map as it is",
                self.solved.name
            );
            return Err(TrackwrightError::new_err(text).into());
        }
        let mut notes = Notes::new();
        let measured = self.sensor_poses((positions, quaternions), as_is, &mut notes)?;
        let found = long_work::run(py, |task| {
            Ok(Compensation::of(model, &measured, outside, wanted, task)?)
        })?;
        let base = Found::new(py, found.section(), notes)?;
        let flags = |flag: fn(&field::compensation::Compensated) -> bool| {
            let each: Vec<bool> = found.answers.iter().map(flag).collect();
            each.into_pyarray(py).unbind()
        };
        let (positions, quaternions) = parts(py, found.answers.iter().map(|at| at.pose))?;
        let corrected = Corrected {
            positions: positions.unbind(),
            quaternions: quaternions.unbind(),
            outside: flags(|at| !at.is_inside),
            converged: flags(|at| at.pose.is_some()),
            ambiguous: flags(|at| matches!(at.state, InverseState::Ambiguous(_))),
        };
        Ok(Py::new(py, (corrected, base))?)
    }

    /// How far readings at poses may be from the model's, a record a pose.
    ///
    /// positions and quaternions as for `distort`. Fields: std_error_mm and std_error_deg, RMS distance and
    /// angle; within95_mm and within95_deg, within which 95 % are; supported, whether the measurements determine
    /// the field there; distance_mm to the nearest; of polynomials also leverage. What is not known is not a
    /// number.
    #[pyo3(signature = (positions, quaternions, *, outside = "clamp", as_is = false))]
    fn validity<'py>(
        &self,
        py: Python<'py>,
        positions: &Bound<'_, PyAny>,
        quaternions: &Bound<'_, PyAny>,
        outside: &str,
        as_is: bool,
    ) -> Done<Bound<'py, PyAny>> {
        let outside = outside_policy(outside)?;
        let mut notes = Notes::new();
        let poses = self.sensor_poses((positions, quaternions), as_is, &mut notes)?;
        let found = long_work::run(py, |_| {
            let points: Vec<_> = poses.iter().map(FieldPoint::of_pose).collect();
            Ok(self.solved.validity(&points, outside)?)
        })?;
        let Some(found) = found else {
            let text = format!(
                "{}: found no `support` and no `process`, expected one of them; Environment.fit keeps \
                 both unless support=False",
                self.solved.name
            );
            return Err(TrackwrightError::new_err(text).into());
        };
        warn_of(py, notes)?;
        let fields = [
            ("std_error_mm", Field::Float),
            ("std_error_deg", Field::Float),
            ("leverage", Field::Float),
            ("supported", Field::Flag),
            ("distance_mm", Field::Float),
            ("within95_mm", Field::Float),
            ("within95_deg", Field::Float),
        ];
        let mut records = Records::new(fields, found.len());
        for at in found {
            let fit = at.fit.as_ref();
            records.push([
                Cell::Float(at.position_error_mm),
                Cell::known(at.angle_error_rad.map(f64::to_degrees)),
                Cell::known(fit.map(|fit| fit.leverage)),
                Cell::Flag(at.is_supported),
                Cell::known(Some(at.distance_mm)),
                Cell::known(at.position_95_mm),
                Cell::known(at.angle_95_rad.map(f64::to_degrees)),
            ]);
        }
        records.into_numpy(py)
    }

    fn __repr__(&self) -> String {
        format!("<trackwright.Environment {:?}>", self.solved.name)
    }
}

/// Poses between two looks at whether to go on: some milliseconds.
const ROWS_PER_STEP: usize = 1024;

/// How many positions are outside the room's box, and what stood for the field there.
fn note_outside(outside: usize, of: usize, policy: OutsidePolicy) -> Option<String> {
    let then = match policy {
        OutsidePolicy::Clamp => "the nearest point of the box stands for them",
        OutsidePolicy::Extrapolate => "the model is extrapolated there",
        OutsidePolicy::Reject => "they are left out",
    };
    let [outside_text, of] = [outside, of].map(with_separators);
    (outside > 0)
        .then(|| format!("{outside_text} of {of} poses are outside the room's box: {then}"))
}
