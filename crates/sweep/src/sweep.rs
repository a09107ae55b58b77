//! An opened plan: designs, rooms and poses are read, and any row can be computed.

use super::checksum::hexadecimal;
use super::points::Points;
use super::template::Template;
use sha2::{Digest, Sha256};
use std::path::{Path, PathBuf};
use std::sync::Arc;
use trackwright_design::{Design, Origin};
use trackwright_field::Environment;
use trackwright_formats::environment;
use trackwright_formats::sweep_plan::{self, SweepMotion, SweepPlan};
use trackwright_project::{
    Files, RoomSource, StoreError, World, builtin_named, builtin_rooms,
    open_builtin_without_meshes, open_design_without_meshes, resolve,
};
use trackwright_simulation::metric::MetricValues;
use trackwright_simulation::motion::Motion;
use trackwright_simulation::{CancelToken, Figures, Mode, StudyError, run, study};
use trackwright_task::Cancelled;

/// A plan with all that it refers to.
#[derive(Clone, Debug)]
pub struct Sweep {
    plan: SweepPlan,
    /// With the folder that its files are relative to.
    hash: String,
    points: Points,
    designs: Vec<SweptDesign>,
    rooms: Vec<OpenRoom>,
    motions: Vec<OpenMotion>,
    rows: u64,
    /// Files of the disk, but for the plan.
    inputs: Vec<PathBuf>,
}

#[derive(Clone, Debug)]
struct SweptDesign {
    origin: Origin,
    template: Template,
    own_room: Arc<Environment>,
}

#[derive(Clone, Debug)]
struct OpenRoom {
    source: RoomSource,
    environment: Arc<Environment>,
}

#[derive(Clone, Debug)]
enum OpenMotion {
    Mode(Mode),
    Range(Motion),
}

/// What a row is of, by places in the plan's lists.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct RowKey {
    pub design: usize,
    pub point: u64,
    /// `None` for the design's own room.
    pub room: Option<usize>,
    pub motion: usize,
}

/// A computed row.
#[derive(Clone, Debug, PartialEq)]
pub struct Row {
    pub key: RowKey,
    /// The numbers that vary, in the order of the plan.
    pub numbers: Vec<f64>,
    /// The figures, or why there are none.
    pub study: Result<RowFigures, String>,
}

/// The figures of one row.
#[derive(Clone, Debug, PartialEq)]
pub struct RowFigures {
    pub trials: u64,
    pub outside: u64,
    pub out_of_volume: u64,
    /// What is known of the figures, where the plan wants it.
    pub known: Option<Figures>,
    /// Those of the room's model alone, where the plan wants them.
    pub room_field: Option<MetricValues>,
}

impl Sweep {
    /// Opens a plan's file with all that it refers to.
    ///
    /// # Errors
    /// A file that cannot be read. Paths to numbers that a design does not have are no error: the rows state
    /// them.
    pub fn open(file: &Path) -> Result<Self, StoreError> {
        let plan = Files::default().read_sweep_plan(file)?;
        Self::of_plan(plan, file.parent().unwrap_or(Path::new("")))
    }

    /// A plan whose files are relative to a folder, where it does not state another.
    ///
    /// # Errors
    /// As [`open`](Self::open).
    pub fn of_plan(mut plan: SweepPlan, folder: &Path) -> Result<Self, StoreError> {
        let folder = match &plan.folder {
            Some(stated) => folder.join(stated),
            None => folder.to_owned(),
        };
        // No folder at all is the current one.
        let folder = std::path::absolute(folder.join(".")).unwrap_or(folder);
        let mut digest = Sha256::new();
        let mut add = |text: &str| {
            digest.update((text.len() as u64).to_le_bytes());
            digest.update(text);
        };
        add(env!("CARGO_PKG_VERSION"));
        // Where the files are and how long a shard takes is in no row.
        add(&sweep_plan::write(&SweepPlan { folder: None, shard_seconds: 1.0, ..plan.clone() }));
        let mut inputs: Vec<PathBuf> = Vec::new();
        let mut designs = Vec::with_capacity(plan.designs.len());
        for name in &plan.designs {
            let world = open_named(name, &folder)?;
            let template = Template::new(world.document.design(), plan.paths());
            template.texts().iter().for_each(|text| add(text));
            add(&room_text(world.bare_environment(), world.document.design()));
            let origin = world.document.origin().clone();
            inputs.extend(world.files().map(Path::to_owned));
            designs.push(SweptDesign {
                origin,
                template,
                own_room: Arc::clone(&world.environment),
            });
        }
        let mut rooms = Vec::with_capacity(plan.rooms.len());
        for name in &plan.rooms {
            let source = room_named(name, &folder);
            let content = source.read()?;
            add(&environment::write(&content.bare, content.metal.as_deref()));
            let environment = source.solved(&content)?;
            rooms.push(OpenRoom { environment, source });
        }
        let files = Files::default();
        let has_crf = designs.iter().any(|swept: &SweptDesign| swept.template.has_crf());
        let mut motions = Vec::with_capacity(plan.motions.len());
        for motion in &plan.motions {
            motions.push(match motion {
                SweepMotion::Single => OpenMotion::Mode(Mode::Single),
                SweepMotion::Motion => OpenMotion::Mode(Mode::Motion),
                SweepMotion::Range(range) => OpenMotion::Range(*range),
                SweepMotion::Input(name) => {
                    let file = folder.join(name);
                    let trials = files.read_input(&file, has_crf)?.take(false, |_, _| ())?;
                    inputs.push(file);
                    add(&format!("{trials:?}"));
                    OpenMotion::Mode(Mode::Input(trials.into()))
                }
            });
        }
        let of_rooms = rooms.iter().filter_map(|room: &OpenRoom| room.source.file());
        inputs.extend(of_rooms.map(Path::to_owned));
        let hash = hexadecimal(digest);
        let points = Points::new(&plan.vary, plan.seed);
        let rows = plan.rows() as u64;
        plan.folder = Some(folder.to_string_lossy().into_owned());
        Ok(Self { plan, hash, points, designs, rooms, motions, rows, inputs })
    }

    /// The files that it reads, but for the plan.
    pub fn inputs(&self) -> &[PathBuf] {
        &self.inputs
    }

    /// The plan, with the folder that its files are relative to: it can be opened from anywhere.
    pub fn plan(&self) -> &SweepPlan {
        &self.plan
    }

    /// SHA-256 of the plan, of all files that it refers to, and of the program's version.
    pub fn hash(&self) -> &str {
        &self.hash
    }

    /// Number of rows.
    pub fn rows(&self) -> u64 {
        self.rows
    }

    /// Numbers that some design does not have, each with the design's name in the plan: all its rows will
    /// state it.
    pub fn problems(&self) -> Vec<String> {
        let each = self.plan.designs.iter().zip(&self.designs);
        each.filter_map(|(name, design)| Some(format!("{name}: {}", design.template.problem()?)))
            .collect()
    }

    /// What a row is of.
    pub fn key(&self, row: u64) -> RowKey {
        let motions = self.motions.len() as u64;
        let rooms = self.rooms.len().max(1) as u64;
        let point = row / motions / rooms;
        RowKey {
            design: (point / self.points.count()) as usize,
            point: point % self.points.count(),
            room: (!self.rooms.is_empty()).then(|| (row / motions % rooms) as usize),
            motion: (row % motions) as usize,
        }
    }

    /// The design of a row and the room that it is in, without what no figure depends on.
    ///
    /// # Errors
    /// Why the row has none.
    pub fn design(&self, row: u64) -> Result<(Design, Arc<Environment>), String> {
        let key = self.key(row);
        let swept = &self.designs[key.design];
        let design =
            swept.template.with(&self.points.values(key.point)).map_err(|why| why.to_string())?;
        let room = key.room.map_or(&swept.own_room, |room| &self.rooms[room].environment);
        Ok((design, Arc::clone(room)))
    }

    /// The design whose numbers a row varies.
    pub(crate) fn origin_of(&self, row: u64) -> &Origin {
        &self.designs[self.key(row).design].origin
    }

    /// The room of a row; `None` for the design's own.
    pub(crate) fn room_of(&self, row: u64) -> Option<&RoomSource> {
        self.key(row).room.map(|room| &self.rooms[room].source)
    }

    /// The range of motion that a row's figures are over, where it is not the design's own.
    pub(crate) fn range_of(&self, row: u64) -> Option<Motion> {
        match self.motions[self.key(row).motion] {
            OpenMotion::Range(range) => Some(range),
            OpenMotion::Mode(_) => None,
        }
    }

    /// Computes a row.
    ///
    /// # Errors
    /// [`Cancelled`].
    pub fn row(&self, row: u64, cancel: &CancelToken) -> Result<Row, Cancelled> {
        let key = self.key(row);
        let numbers = self.points.values(key.point);
        let study = match self.design(row) {
            Err(why) => Err(why),
            Ok((design, room)) => match self.study(&design, &room, key.motion, cancel) {
                Err(StudyError::Cancelled) => return Err(Cancelled),
                study => study.map_err(|why| why.to_string()),
            },
        };
        Ok(Row { key, numbers, study })
    }

    fn study(
        &self,
        design: &Design,
        room: &Arc<Environment>,
        motion: usize,
        cancel: &CancelToken,
    ) -> Result<RowFigures, StudyError> {
        let mut scenario = resolve(design, room);
        scenario.outside = self.plan.outside;
        let mode = match &self.motions[motion] {
            OpenMotion::Mode(mode) => mode.clone(),
            OpenMotion::Range(range) => {
                scenario.motion = Some(*range);
                Mode::Motion
            }
        };
        let (room_field, known) = match self.plan.expected {
            false => (run(&scenario, &mode, cancel, None)?.room_field, None),
            true => {
                let study = study(&scenario, &mode, cancel, None)?;
                (study.room_field, Some(study.figures))
            }
        };
        Ok(RowFigures {
            trials: room_field.trials as u64,
            outside: room_field.outside as u64,
            out_of_volume: room_field.out_of_volume as u64,
            known,
            room_field: self.plan.room_field.then(|| room_field.values()),
        })
    }
}

fn room_text(bare: &Environment, design: &Design) -> String {
    environment::write(bare, design.room_metal.as_deref())
}

/// Opens a file, or the built-in design of that name where there is no such file.
fn open_named(name: &str, folder: &Path) -> Result<World, StoreError> {
    let file = folder.join(name);
    match builtin_named(name, &file) {
        Some(builtin) => open_builtin_without_meshes(builtin),
        None => open_design_without_meshes(&file),
    }
}

/// A file, or the built-in room of that name where there is no such file.
fn room_named(name: &str, folder: &Path) -> RoomSource {
    let file = folder.join(name);
    let builtin = builtin_rooms().find(|room| room.file_name() == name && !file.exists());
    builtin.unwrap_or_else(|| RoomSource::of_file(&file))
}
