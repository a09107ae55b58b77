//! Rooms with metal: read with the meshes of their objects, and solved.

use super::error::StoreError;
use super::read::Kind;
use super::reader::Reader;
use super::world::{SolvedMetal, World};
use std::path::Path;
use std::sync::Arc;
use trackwright_design::{BodyRole, Design, Edit, MetalEdit, View};
use trackwright_field::Environment;
use trackwright_field::computed::FieldSource;
use trackwright_field::generator::Generator;
use trackwright_formats::environment;
use trackwright_metal::furnished::{FurnishError, FurnishReport, Furnished, Furnisher};
use trackwright_metal::setup::{ObjectShape, RoomMetal};
use trackwright_task::Task;

/// A room as its file holds it.
#[derive(Clone, Debug)]
pub struct RoomContent {
    /// The room without the metal.
    pub bare: Arc<Environment>,
    pub metal: Option<Arc<RoomMetal>>,
}

/// Metal that is to be solved for.
#[derive(Clone, Debug)]
pub struct MetalRequest(RoomContent);

/// A room with its metal solved for.
#[derive(Clone, Debug)]
pub struct MetalAnswer {
    request: MetalRequest,
    found: Result<Furnished, Arc<FurnishError>>,
}

impl RoomContent {
    /// Solves for the metal.
    pub fn solve(&self, furnisher: &mut Furnisher, task: &Task) -> Result<Furnished, FurnishError> {
        match &self.metal {
            Some(metal) => furnisher.furnish(&self.bare, metal, task),
            None => Ok(Furnished::bare(&self.bare)),
        }
    }

    /// Solves for the metal of a room that was read from a file.
    ///
    /// # Errors
    /// [`StoreError::Metal`].
    pub fn solved(&self, file: &Path, task: &Task) -> Result<Furnished, StoreError> {
        let solved = self.solve(&mut Furnisher::default(), task);
        solved.map_err(|cause| StoreError::Metal { file: file.to_owned(), cause: Arc::new(cause) })
    }
}

impl MetalRequest {
    /// Solves for the metal; `None` where the task was cancelled.
    pub fn solve(self, furnisher: &mut Furnisher, task: &Task) -> Option<MetalAnswer> {
        let found = match self.0.solve(furnisher, task) {
            Err(FurnishError::Cancelled(_)) => return None,
            found => found.map_err(Arc::new),
        };
        Some(MetalAnswer { request: self, found })
    }
}

impl Reader {
    /// The room that a file refers to.
    pub(super) fn room(&mut self, from: &Path, reference: &str) -> Result<RoomContent, StoreError> {
        let file = self.storage.resolve(from, reference);
        let content = self.read(&file, Kind::ENVIRONMENT, environment::parse)?;
        let (bare, metal) = content.into_room(|mesh| self.mesh(&file, mesh))?;
        Ok(RoomContent { bare: Arc::new(bare), metal: metal.map(Arc::new) })
    }

    /// A design with its bodies and the metal of its room.
    pub(super) fn design_in_room(&mut self, file: &Path) -> Result<(Design, View), StoreError> {
        let (mut design, view) = self.design(file)?;
        design.room_metal = self.room(file, &design.environment)?.metal;
        Ok((design, view))
    }

    /// Metal of a room's file with the surfaces of its meshes.
    pub(super) fn metal_with_surfaces(
        &mut self,
        room_file: &Path,
        metal: Option<Arc<RoomMetal>>,
    ) -> Result<Option<Arc<RoomMetal>>, StoreError> {
        let read = metal.map(|metal| {
            Arc::unwrap_or_clone(metal).with_surfaces(|mesh| self.mesh(room_file, mesh))
        });
        Ok(read.transpose()?.map(Arc::new))
    }

    /// The room that a file refers to, with its metal.
    pub(super) fn environment(
        &mut self,
        from: &Path,
        reference: &str,
    ) -> Result<Arc<Environment>, StoreError> {
        let content = self.room(from, reference)?;
        Ok(content.solved(&self.storage.resolve(from, reference), &Task::default())?.environment)
    }
}

impl World {
    /// The room as it would be without metal.
    pub fn bare_environment(&self) -> &Arc<Environment> {
        &self.bare
    }

    /// The coils whose fields metal disturbs: those of the room's metal, else those that a room of
    /// harmonic functions was fitted for. `None` where the room's coils are not known.
    pub fn generator(&self) -> Option<&Generator> {
        if let Some(metal) = &self.document.design().room_metal {
            return Some(&metal.generator);
        }
        match self.bare.model.computed()?.source() {
            FieldSource::Harmonic(model) => Some(model.generator()),
            _ => None,
        }
    }

    /// The edit that adds a new object to the room's metal, beside the measurement volume. Where the
    /// room's coils are not known they are those of a planar generator.
    pub fn added_metal(&self, shape: ObjectShape, what: &str) -> Edit {
        let bounds = self.bare.volume.map(|volume| volume.bounds());
        let bounds = bounds.unwrap_or(*self.bare.model.bounds());
        Edit::Metal(match &self.document.design().room_metal {
            Some(metal) => MetalEdit::Add(Box::new(metal.new_object(shape, what, &bounds))),
            None => {
                let generator = self.generator().cloned().unwrap_or_else(Generator::planar_nine);
                let mut metal = RoomMetal::empty(generator);
                metal.objects.push(metal.new_object(shape, what, &bounds));
                MetalEdit::Replace(Some(Arc::new(metal)))
            }
        })
    }

    /// How the metal is simulated; `None` of a room without metal.
    pub fn metal_report(&self) -> Option<&FurnishReport> {
        self.solved.furnished.as_ref().map(|furnished| &furnished.report)
    }

    /// The room's metal, solved for, and where its objects were then; `None` of a room without metal.
    pub fn solved_metal(&self) -> Option<(&Furnished, &RoomMetal)> {
        self.solved.furnished.as_ref().zip(self.solved.metal.as_deref())
    }

    /// Distance from a metal object's surface to the tool's tip at the design's pose; `None` without the
    /// object, and where the metal has not been solved for.
    pub fn distance_to_tip_mm(&self, object: usize) -> Option<f64> {
        let room = self.solved.furnished.as_ref()?.room.as_ref()?;
        let design = self.document.design();
        let tracker_from_tool = design.tracker_from_body(BodyRole::Tool)?;
        let tip = tracker_from_tool * design.tool.body.rigid.judged_tip_in_body();
        (object < room.bodies().len()).then(|| room.body_distance_mm(object, &tip))
    }

    /// Why the metal of the design cannot be simulated where it is now; the environment is then still the
    /// one before.
    pub fn metal_problem(&self) -> Option<&Arc<FurnishError>> {
        self.solved.problem.as_ref()
    }

    /// The metal of the design, where the environment is not yet that with it.
    pub fn awaited_metal(&self) -> Option<MetalRequest> {
        let metal = &self.document.design().room_metal;
        let is_solved = match (metal, &self.solved.metal) {
            (Some(metal), Some(solved)) => Arc::ptr_eq(metal, solved) || metal == solved,
            (metal, solved) => metal.is_none() && solved.is_none(),
        };
        let content = || RoomContent { bare: Arc::clone(&self.bare), metal: metal.clone() };
        (!is_solved).then(|| MetalRequest(content()))
    }

    /// Takes an answer over; whether anything changed: not where another room was opened meanwhile.
    pub fn receive_metal(&mut self, answer: MetalAnswer) -> bool {
        let MetalAnswer { request: MetalRequest(content), found } = answer;
        if !Arc::ptr_eq(&content.bare, &self.bare) {
            return false;
        }
        self.document.room_has_changed();
        match found {
            Ok(furnished) => self.has_metal(content.metal, furnished),
            Err(problem) => {
                self.solved.metal = content.metal;
                self.solved.problem = Some(problem);
            }
        }
        true
    }

    fn has_metal(&mut self, metal: Option<Arc<RoomMetal>>, furnished: Furnished) {
        self.environment = Arc::clone(&furnished.environment);
        let furnished = metal.is_some().then_some(furnished);
        self.solved = SolvedMetal { metal, furnished, problem: None };
    }

    /// Takes over another room, in which the design's metal is yet to be solved for.
    pub fn is_in_room(&mut self, bare: Arc<Environment>) {
        self.solved = SolvedMetal::default();
        if self.document.design().room_metal.is_none() {
            self.environment = Arc::clone(&bare);
        }
        self.bare = bare;
    }

    /// Takes over another room, with the design's metal in it.
    ///
    /// # Errors
    /// [`StoreError::Metal`]; everything is then as it was.
    pub(super) fn has_room(
        &mut self,
        bare: Arc<Environment>,
        file: &Path,
    ) -> Result<(), StoreError> {
        let metal = self.document.design().room_metal.clone();
        let content = RoomContent { bare, metal };
        let furnished = content.solved(file, &Task::default())?;
        self.bare = content.bare;
        self.has_metal(content.metal, furnished);
        Ok(())
    }
}

/// Solves for the design's metal where the environment is not yet that with it; whether it did.
///
/// # Errors
/// [`StoreError::Metal`]; the environment is then the one before.
pub fn refresh_metal(world: &mut World) -> Result<bool, StoreError> {
    let Some(request) = world.awaited_metal() else {
        return Ok(false);
    };
    let Some(answer) = request.solve(&mut Furnisher::default(), &Task::default()) else {
        return Ok(false);
    };
    let is_changed = world.receive_metal(answer);
    match world.metal_problem() {
        None => Ok(is_changed),
        Some(cause) => Err(StoreError::Metal {
            file: world.document.design().environment.clone().into(),
            cause: Arc::clone(cause),
        }),
    }
}
