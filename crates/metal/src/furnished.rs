//! A room with metal in it as an [`Environment`] that designs are simulated in.
//!
//! The metal is solved for; where harmonic functions stand for it in the room's box, they are evaluated
//! in its place. A [`Furnisher`] keeps what it factored, so that a moved object is answered quickly.

use crate::body::{BodyError, MetalBody, MetalShape, ResponseModel};
use crate::boundary::BoundaryShape;
use crate::cells::{Cells, Disturbance, NearMetal, errors_among};
use crate::exchange::ExchangeReport;
use crate::harmonics::Sampling;
use crate::room::{MetalRoom, PlacedBody, RoomError};
use crate::setup::{MaterialTolerance, MetalObject, ObjectShape, RoomMetal, SetupError, ShapeKey};
use crate::shapes;
use crate::surface::{ClosedSurface, SurfaceError};
use crate::uncertainty::computed;
use nalgebra::{Point3, Unit, Vector3};
use std::sync::Arc;
use trackwright_field::computed::{DisturbedCoils, FieldSource, MadeOfCoils, PoseErrors};
use trackwright_field::environment::OtherSolution;
use trackwright_field::evaluation::Coefficient;
use trackwright_field::generator::Generator;
use trackwright_field::harmonic::HarmonicModel;
use trackwright_field::samples::MapKind;
use trackwright_field::{DistortionModel, Environment, OutsidePolicy};
use trackwright_geometry::volume::Volume;
use trackwright_task::{Cancelled, Task};

pub use crate::cells::CellCounts;
pub use crate::harmonics::TOLERANCE_MM;

/// A room with its metal.
#[derive(Clone, Debug)]
pub struct Furnished {
    pub environment: Arc<Environment>,
    /// The metal, solved; `None` without any.
    pub room: Option<Arc<MetalRoom>>,
    pub report: FurnishReport,
}

/// What was done to simulate a room.
#[derive(Clone, Debug)]
pub struct FurnishReport {
    pub evaluation: MetalEvaluation,
    /// In the order of the objects.
    pub objects: Vec<ObjectReport>,
    pub exchange: ExchangeReport,
    /// Whether the room was measured, so that what the metal does to what disturbs it already is left
    /// out.
    pub is_added_to_errors: bool,
    /// What the metal's field in the volume is off by, as a part of it: what half as many triangles
    /// change.
    pub solution_error: f64,
}

/// How poses are evaluated.
#[derive(Clone, Debug)]
pub enum MetalEvaluation {
    /// There is no metal.
    None,
    /// By harmonic functions that were fitted to samples of the metal's field.
    Harmonic { degree: usize },
    /// By harmonic functions where they are within [`TOLERANCE_MM`], by the metal's field itself elsewhere.
    Cells(MetalCells),
}

/// The cells of a room, for how often each way was taken.
#[derive(Clone, Debug)]
pub struct MetalCells(Arc<Cells<DirectErrors>>);

impl MetalCells {
    /// What was evaluated until now.
    pub fn counts(&self) -> CellCounts {
        self.0.counts()
    }
}

/// How one object is answered.
#[derive(Clone, Debug, PartialEq)]
pub struct ObjectReport {
    pub name: String,
    /// None of a sphere.
    pub triangles: usize,
    /// Triangles of its mesh, where that was coarsened.
    pub coarsened_from: Option<usize>,
    pub model: ResponseModel,
}

impl Furnished {
    /// A room without metal.
    pub fn bare(environment: &Arc<Environment>) -> Self {
        let report = FurnishReport {
            evaluation: MetalEvaluation::None,
            objects: Vec::new(),
            exchange: ExchangeReport::default(),
            is_added_to_errors: false,
            solution_error: 0.0,
        };
        Self { environment: Arc::clone(environment), room: None, report }
    }
}

/// Why a room's metal cannot be simulated.
#[derive(Clone, Debug, thiserror::Error)]
pub enum FurnishError {
    #[error(transparent)]
    Setup(#[from] SetupError),
    #[error("{name}: {cause}")]
    Surface { name: String, cause: Box<SurfaceError> },
    #[error("{name}: {cause}")]
    Body { name: String, cause: BodyError },
    #[error("{}", named(cause, names))]
    Room { names: Vec<String>, cause: Box<RoomError> },
    #[error(
        "the room's model corrects measured poses, expected one that distorts true poses: metal cannot be added to it"
    )]
    Correction,
    #[error(transparent)]
    Cancelled(#[from] Cancelled),
}

impl FurnishError {
    /// The names of the objects that it is about; none where it is about the room as a whole.
    pub fn objects(&self) -> Vec<&str> {
        match self {
            Self::Setup(
                SetupError::NameTwice(name)
                | SetupError::Shape { name, .. }
                | SetupError::Triangles { name, .. }
                | SetupError::Tolerance { name, .. }
                | SetupError::Pose { name },
            )
            | Self::Surface { name, .. }
            | Self::Body { name, .. } => vec![name],
            Self::Room { names, cause } => {
                let indices = match **cause {
                    RoomError::Pose(body)
                    | RoomError::MetalCutsGenerator { body, .. }
                    | RoomError::CoilInHole { body, .. }
                    | RoomError::MetalInVolumeCenter(body) => vec![body],
                    RoomError::BodiesTouch { first, second } => vec![first, second],
                    RoomError::BodyInHole { body, other } => vec![body, other],
                    _ => Vec::new(),
                };
                indices.into_iter().filter_map(|index| Some(names.get(index)?.as_str())).collect()
            }
            Self::Setup(_) | Self::Correction | Self::Cancelled(_) => Vec::new(),
        }
    }
}

/// A room's problem with the objects' names in the place of their numbers.
fn named(cause: &RoomError, names: &[String]) -> String {
    let name = |index: usize| names.get(index).map_or("an object", String::as_str);
    match cause {
        RoomError::Pose(body) => format!("{}: the pose is not finite", name(*body)),
        RoomError::MetalCutsGenerator { body, coil } => {
            format!("{} cuts coil {} of the generator", name(*body), coil + 1)
        }
        RoomError::MetalInVolumeCenter(body) => {
            format!("{} is in the middle of the measurement volume", name(*body))
        }
        RoomError::CoilInHole { body, coil } => format!(
            "coil {} of the generator is in a hole of {}: the flux through it is not known then",
            coil + 1,
            name(*body)
        ),
        RoomError::BodyInHole { body, other } => format!(
            "{} is in a hole of {}: the flux through it is not known then",
            name(*other),
            name(*body)
        ),
        RoomError::BodiesTouch { first, second } => {
            format!("{} and {} touch or cut each other", name(*first), name(*second))
        }
        other => other.to_string(),
    }
}

/// Solves rooms and keeps what the next one may need again.
#[derive(Debug, Default)]
pub struct Furnisher {
    shapes: Vec<(ShapeKey, Arc<BoundaryShape>)>,
    bodies: Vec<(BodyKey, Arc<MetalBody>)>,
    /// How much bodies change with what is not known of their materials.
    spreads: Vec<((BodyKey, MaterialTolerance), Arc<f64>)>,
    sampling: Option<Arc<Sampling>>,
    last: Option<Arc<MetalRoom>>,
    /// The same with other triangles.
    last_second: Option<Arc<MetalRoom>>,
}

type BodyKey = (ShapeKey, crate::material::Material, f64);

/// Shapes and bodies that are kept: those of the largest room twice, before and after a change, with two
/// meshes each.
const MOST_KEPT: usize = 4 * crate::setup::MAX_OBJECTS;

impl Furnisher {
    /// The room `bare` with metal added to it.
    ///
    /// A harmonic room of the same generator is disturbed with the metal; to any other room that was
    /// measured the metal's errors are added, to first order. What the metal does to the metal that was
    /// measured is left out.
    ///
    /// # Errors
    /// See [`FurnishError`].
    pub fn furnish(
        &mut self,
        bare: &Arc<Environment>,
        metal: &RoomMetal,
        task: &Task,
    ) -> Result<Furnished, FurnishError> {
        match self.furnished(bare, metal, task) {
            // Whatever was interrupted by it.
            Err(_) if task.cancel.is_cancelled() => Err(Cancelled.into()),
            made => made,
        }
    }

    fn furnished(
        &mut self,
        bare: &Arc<Environment>,
        metal: &RoomMetal,
        task: &Task,
    ) -> Result<Furnished, FurnishError> {
        metal.check()?;
        if bare.model.map() == MapKind::Correction {
            return Err(FurnishError::Correction);
        }
        if metal.objects.is_empty() {
            return Ok(Furnished::bare(bare));
        }
        let placed = self.placed(metal, &task.subtask(0.0, 0.7))?;
        let objects = metal.objects.iter().zip(&placed).map(|(o, p)| report_of(o, &p.body));
        let objects: Vec<ObjectReport> = objects.collect();
        let last = self.last.as_deref();
        let room = Arc::new(solved(last, bare, metal, placed, &task.subtask(0.7, 0.8))?);
        self.last = Some(Arc::clone(&room));
        let solution_error = self.solution_error(&room, bare, metal, &task.subtask(0.8, 0.9))?;
        let material_std = self.material_std(metal, &task.subtask(0.9, 1.0))?;

        let of_same_coils = match bare.model.computed().map(|computed| computed.source()) {
            Some(FieldSource::Harmonic(model)) => {
                (*model.generator() == metal.generator).then(|| Arc::clone(model))
            }
            _ => None,
        };
        let is_added_to_errors = of_same_coils.is_none() && !bare.model.is_zero();
        let direct = |room| DirectErrors { room, beside: of_same_coils.clone() };
        let added = |metal: Arc<dyn PoseErrors>| -> Arc<dyn PoseErrors> {
            match is_added_to_errors {
                true => Arc::new(AddedErrors { measured: bare.model.clone(), metal }),
                false => metal,
            }
        };
        let own_std = solution_error.own_std();
        let other = solution_error
            .other
            .map(|(room, times)| OtherSolution { errors: added(Arc::new(direct(room))), times });
        let bounds = bare.model.bounds();
        let sampling = self.sampling(&bounds.size_mm());
        let cells = Arc::new(Cells::new(Arc::new(direct(Arc::clone(&room))), sampling, *bounds));
        let whole = cells.whole();
        let evaluation = match &whole {
            Some(model) => MetalEvaluation::Harmonic { degree: model.degree() },
            None => MetalEvaluation::Cells(MetalCells(Arc::clone(&cells))),
        };
        let source = match whole {
            Some(model) if !is_added_to_errors => FieldSource::Harmonic(model),
            whole => {
                let errors: Arc<dyn PoseErrors> = match whole {
                    Some(model) => model,
                    None => cells,
                };
                FieldSource::Simulated(added(errors))
            }
        };
        let report = FurnishReport {
            evaluation,
            objects,
            exchange: room.exchange(),
            is_added_to_errors,
            solution_error: solution_error.part,
        };
        let environment = Environment {
            model: DistortionModel::of_source(source, MapKind::Distortion, *bounds),
            metal: Some(computed(&bare.model, material_std, other, own_std)),
            ..Environment::clone(bare)
        };
        Ok(Furnished { environment: Arc::new(environment), room: Some(room), report })
    }

    fn sampling(&mut self, size_mm: &Vector3<f64>) -> Arc<Sampling> {
        match &self.sampling {
            Some(sampling) if sampling.size_mm() == size_mm => Arc::clone(sampling),
            _ => {
                let sampling = Arc::new(Sampling::new(size_mm));
                self.sampling = Some(Arc::clone(&sampling));
                sampling
            }
        }
    }

    fn placed(&mut self, metal: &RoomMetal, task: &Task) -> Result<Vec<PlacedBody>, FurnishError> {
        let count = metal.objects.len();
        let part = |done: usize| done as f64 / count as f64;
        let mut placed = Vec::with_capacity(count);
        for (done, object) in metal.objects.iter().enumerate() {
            task.step(done, count)?;
            let own = task.subtask(part(done), part(done + 1));
            let body = self.body(object, metal.frequency_hz, &own)?;
            placed.push(PlacedBody { body, tracker_from_body: object.tracker_from_object });
        }
        Ok(placed)
    }

    fn body(
        &mut self,
        object: &MetalObject,
        frequency_hz: f64,
        task: &Task,
    ) -> Result<Arc<MetalBody>, FurnishError> {
        let key = (object.key(), object.material.material(), frequency_hz);
        if let Some(body) = kept(&mut self.bodies, &key) {
            return Ok(body);
        }
        let shape = self.shape(object, &task.subtask(0.0, 0.7))?;
        let body = MetalBody::new(shape, key.1, frequency_hz, &task.subtask(0.7, 1.0));
        let name = || object.name.clone();
        let body = Arc::new(body.map_err(|cause| FurnishError::Body { name: name(), cause })?);
        keep(&mut self.bodies, key, &body);
        Ok(body)
    }

    fn shape(&mut self, object: &MetalObject, task: &Task) -> Result<MetalShape, FurnishError> {
        if let ObjectShape::Sphere { radius_mm } = object.shape {
            return Ok(MetalShape::Sphere { radius_mm });
        }
        let key = object.key();
        if let Some(shape) = kept(&mut self.shapes, &key) {
            return Ok(MetalShape::Surface(shape));
        }
        let surface = surface(object, &task.subtask(0.0, 0.6))?;
        let shape = Arc::new(BoundaryShape::new(surface, &task.subtask(0.6, 1.0))?);
        keep(&mut self.shapes, key, &shape);
        Ok(MetalShape::Surface(shape))
    }
}

/// A room of metal; what has not changed since the last one is used again.
fn solved(
    last: Option<&MetalRoom>,
    bare: &Environment,
    metal: &RoomMetal,
    placed: Vec<PlacedBody>,
    task: &Task,
) -> Result<MetalRoom, FurnishError> {
    let volume = bare.volume.unwrap_or(Volume::Box(*bare.model.bounds()));
    let last =
        last.filter(|last| *last.generator() == metal.generator && last.volume() == Some(&volume));
    let solved = match last {
        Some(last) => last.with_bodies(placed, task),
        None => MetalRoom::new(metal.generator.clone(), Some(volume), placed, task),
    };
    solved.map_err(|cause| FurnishError::Room {
        names: metal.objects.iter().map(|object| object.name.clone()).collect(),
        cause: Box::new(cause),
    })
}

/// The surface of an object that is no sphere.
fn surface(object: &MetalObject, task: &Task) -> Result<ClosedSurface, FurnishError> {
    let name = || object.name.clone();
    let most = object.most_triangles;
    let of_shape = |cause| SetupError::Shape { name: name(), cause };
    let made = match &object.shape {
        ObjectShape::Sphere { radius_mm } => {
            ClosedSurface::new(&shapes::sphere(*radius_mm, 3).map_err(of_shape)?)
        }
        ObjectShape::Cuboid { size_mm } => {
            ClosedSurface::new(&shapes::cuboid(size_mm, most).map_err(of_shape)?)
        }
        ObjectShape::Cylinder { radius_mm, length_mm } => {
            let mesh = shapes::cylinder(*radius_mm, *length_mm, most).map_err(of_shape)?;
            ClosedSurface::new(&mesh)
        }
        ObjectShape::Mesh(mesh) => ClosedSurface::remeshed(&mesh.surface, most, task),
    };
    made.map_err(|cause| FurnishError::Surface { name: name(), cause: Box::new(cause) })
}

/// What is kept by a key; it is the newest then.
fn kept<K: PartialEq, V>(all: &mut Vec<(K, Arc<V>)>, key: &K) -> Option<Arc<V>> {
    let index = all.iter().position(|(other, _)| other == key)?;
    let found = all.remove(index);
    let value = Arc::clone(&found.1);
    all.push(found);
    Some(value)
}

fn keep<K, V>(all: &mut Vec<(K, Arc<V>)>, key: K, value: &Arc<V>) {
    all.push((key, Arc::clone(value)));
    if all.len() > MOST_KEPT {
        all.remove(0);
    }
}

fn report_of(object: &MetalObject, body: &MetalBody) -> ObjectReport {
    let shape = match body.shape() {
        MetalShape::Sphere { .. } => None,
        MetalShape::Surface(shape) => Some(shape),
    };
    let surface = shape.map(|shape| shape.surface());
    ObjectReport {
        name: object.name.clone(),
        triangles: surface.map_or(0, |surface| surface.panels().len()),
        coarsened_from: surface.and_then(ClosedSurface::coarsened_from),
        model: *body.model(),
    }
}

/// A tracker's errors among metal, from the metal's field at each pose.
#[derive(Debug)]
struct DirectErrors {
    room: Arc<MetalRoom>,
    /// What disturbs the same coils without the metal.
    beside: Option<Arc<HarmonicModel>>,
}

impl DisturbedCoils for DirectErrors {
    fn generator(&self) -> &Generator {
        self.room.generator()
    }

    fn disturbance(&self, p: &Point3<f64>) -> Disturbance {
        self.disturbance_without(&[], p)
    }
}

impl NearMetal for DirectErrors {
    fn distances_mm(&self, p: &Point3<f64>) -> Vec<f64> {
        (0..self.room.bodies().len()).map(|body| self.room.body_distance_mm(body, p)).collect()
    }

    fn disturbance_of(&self, bodies: &[usize], p: &Point3<f64>) -> Disturbance {
        let mut fields = vec![Vector3::zeros(); self.room.generator().coils.len()];
        self.room.disturbance_of(bodies.iter().copied(), p, &mut fields).ok()?;
        Some(fields)
    }

    fn disturbance_without(&self, bodies: &[usize], p: &Point3<f64>) -> Disturbance {
        let others = (0..self.room.bodies().len()).filter(|body| !bodies.contains(body));
        let mut fields = vec![Vector3::zeros(); self.room.generator().coils.len()];
        self.room.disturbance_of(others, p, &mut fields).ok()?;
        if let Some(beside) = &self.beside {
            let mut measured = vec![Vector3::zeros(); fields.len()];
            beside.disturbance(p, &mut measured);
            fields.iter_mut().zip(measured).for_each(|(field, measured)| *field += measured);
        }
        Some(fields)
    }
}

impl PoseErrors for DirectErrors {
    fn axis_errors(
        &self,
        positions_mm: &[Point3<f64>],
        axes: &[Unit<Vector3<f64>>],
        out: &mut [Option<Coefficient>],
    ) {
        let fields = |p: &Point3<f64>| self.disturbance(p);
        errors_among(self.generator(), fields, positions_mm, axes, out);
    }
}

/// The errors of a measured room and those of metal, added.
#[derive(Debug)]
struct AddedErrors {
    measured: DistortionModel,
    metal: Arc<dyn PoseErrors>,
}

impl PoseErrors for AddedErrors {
    fn coils(&self) -> Option<MadeOfCoils<'_>> {
        Some(MadeOfCoils { has_others: true, ..self.metal.coils()? })
    }

    fn axis_errors(
        &self,
        positions_mm: &[Point3<f64>],
        axes: &[Unit<Vector3<f64>>],
        out: &mut [Option<Coefficient>],
    ) {
        self.metal.axis_errors(positions_mm, axes, out);
        for ((p, axis), out) in positions_mm.iter().zip(axes).zip(out) {
            if let Some(values) = out {
                let measured = self.measured.evaluate(p, axis, OutsidePolicy::Clamp).error;
                values.iter_mut().zip(measured.values()).for_each(|(v, own)| *v += own);
            }
        }
    }
}

mod errors;
#[cfg(test)]
mod tests;
