//! Carries out the panels' requests, or starts the thread that does.

use crate::document::file_names::saved_words;
use crate::document::requests::{EditRequest, OpenWorld};
use crate::document::state::{Notice, WorldGeneration};
use crate::runner::jobs::Job;
use crate::runner::wake::Waker;
use crate::shell::dialogs::{Dialogs, ErrorDialog};
use crate::workspaces::field::dialog::FieldDialog;
use crate::workspaces::field::failure::Failure;
use crate::workspaces::field::metal::{FoundMetal, Searching};
use crate::workspaces::field::requests::{FieldRequest, RoomToSave};
use crate::workspaces::field::state::{FieldSettings, FieldState, Reading, Table, TableRole};
use crate::workspaces::field::work::{self, Compared};
use bevy::ecs::system::SystemParam;
use bevy::prelude::*;
use bevy::window::RequestRedraw;
use std::path::{Path, PathBuf};
use std::sync::Arc;
use trackwright_design::{Edit, Origin};
use trackwright_field::Environment;
use trackwright_project::{
    ENVIRONMENT_EXTENSION, Files, RoomContent, RoomSource, file_name, room_name, write_room_for,
};
use trackwright_task::Task;

/// Rooms that are remembered as recently used.
const MOST_RECENT: usize = 8;

pub(crate) fn answer(mut requests: MessageReader<FieldRequest>, mut params: FieldParams) {
    for request in requests.read() {
        params.answer(request.clone());
    }
    params.state.forget_other_tables();
    // What was requested shows in the panels, or in the scene after an edit.
    params.redraw.write(RequestRedraw);
}

/// What the requests work on.
#[derive(SystemParam)]
pub(crate) struct FieldParams<'w> {
    state: ResMut<'w, FieldState>,
    world: Option<Res<'w, OpenWorld>>,
    generation: Res<'w, WorldGeneration>,
    waker: Res<'w, Waker>,
    dialogs: ResMut<'w, Dialogs>,
    notice: ResMut<'w, Notice>,
    edits: MessageWriter<'w, EditRequest>,
    redraw: MessageWriter<'w, RequestRedraw>,
}

impl FieldParams<'_> {
    fn answer(&mut self, request: FieldRequest) {
        match request {
            FieldRequest::ShowOpen(role) => {
                let folder = self.table_folder();
                self.dialogs.show(FieldDialog::open_table(folder, role));
            }
            FieldRequest::Open(role, file) => self.read(role, file),
            FieldRequest::Drop(file) => {
                let slot = &self.state.training;
                if slot.table.is_none() && slot.reading.is_none() {
                    self.read(TableRole::Training, file);
                } else {
                    self.dialogs.show(FieldDialog::WhichTable { file });
                }
            }
            FieldRequest::Close(role) => {
                let slot = self.state.slot_mut(role);
                if slot.reading.take().is_none() {
                    slot.table = None;
                }
            }
            FieldRequest::TakeAsIs(file, is_taken) => {
                match is_taken {
                    true => self.state.as_is.insert(file),
                    false => self.state.as_is.remove(&file),
                };
            }
            FieldRequest::Set(settings) => self.set(settings),
            FieldRequest::Show(shown) => self.state.shown = shown,
            FieldRequest::Fit => self.fit(),
            FieldRequest::CancelFit => {
                if let Some(job) = &self.state.fitting {
                    job.cancel();
                }
            }
            FieldRequest::ShowSelection(is_open) => self.state.is_selection_open = is_open,
            FieldRequest::Try => self.compare(),
            FieldRequest::CancelTry => {
                if let Some(job) = &self.state.comparing {
                    job.cancel();
                }
            }
            FieldRequest::ShowOpenGenerator => {
                let folder = self.table_folder();
                self.dialogs.show(FieldDialog::open_generator(folder));
            }
            FieldRequest::UseGenerator(source) => self.state.metal.generator = Some(source),
            FieldRequest::FindMetal => self.find_metal(),
            FieldRequest::CompareMetal => self.compare_metal(),
            FieldRequest::CancelMetal => {
                if let Some(searching) = &self.state.metal.searching {
                    searching.job.cancel();
                }
            }
            FieldRequest::ShowSave(room) => self.show_save(room),
            FieldRequest::Save(room, file) => self.save(room, &with_extension(&file)),
            FieldRequest::Assign(place) => self.assign(place),
        }
    }

    /// The table that is there stays until the new one is.
    fn read(&mut self, role: TableRole, file: PathBuf) {
        let how = self.state.settings.reading();
        let job = Job::start("measurements", &self.waker, {
            let file = file.clone();
            move |task| Files::default().read_table(&file, how, task)
        });
        self.state.counts.readings += 1;
        self.state.slot_mut(role).reading = Some(Reading { file, how, job });
    }

    /// Other sensors or another map make other samples of the same rows.
    fn set(&mut self, settings: FieldSettings) {
        self.state.settings = settings;
        let how = settings.reading();
        for role in TableRole::ALL {
            let slot = self.state.slot(role);
            let (file, was) = match (&slot.reading, &slot.table) {
                (Some(reading), _) => (reading.file.clone(), reading.how),
                (None, Some(table)) => (table.file.clone(), table.reading),
                (None, None) => continue,
            };
            if was != how {
                self.read(role, file);
            }
        }
    }

    fn fit(&mut self) {
        if let Some(why) = self.state.hindrance() {
            *self.notice = Notice::Refused(why.to_owned());
            return;
        }
        let (Some(training), held_out) =
            (self.state.training.table.clone(), self.state.held_out.table.clone())
        else {
            return;
        };
        let settings = self.state.settings;
        self.state.counts.fits += 1;
        self.state.fitting = Some(Job::start("fit", &self.waker, move |task| {
            work::fit(&training, held_out.as_ref(), settings, task)
        }));
        self.notice.set_if_neq(Notice::Nothing);
    }

    fn compare(&mut self) {
        let (Some(fitted), Some(world)) = (&self.state.fitted, &self.world) else {
            *self.notice = Notice::Refused("no fitted room to try".to_owned());
            return;
        };
        let compared = Compared::new(world, *self.generation, fitted);
        self.state.counts.comparisons += 1;
        let job = Job::start("try", &self.waker, move |task| work::compare(compared, task));
        self.state.comparing = Some(job);
    }

    fn find_metal(&mut self) {
        let of_room = self.world.as_ref().and_then(|world| world.0.generator());
        let source = self.state.metal.generator(of_room);
        if let Some(why) = self.state.metal_hindrance(source.as_ref()) {
            *self.notice = Notice::Refused(why.to_owned());
            return;
        }
        let (Some(table), Some(source)) = (self.state.training.table.clone(), source) else {
            return;
        };
        let of_room = of_room.cloned();
        self.search(&table.clone(), false, move |task| {
            work::find_metal(&table, &source, of_room, task)
        });
    }

    fn compare_metal(&mut self) {
        let search = &self.state.metal;
        let Some(found) = search.found.clone().filter(|_| search.searching.is_none()) else {
            *self.notice = Notice::Refused("no metal to compare, look for it first".to_owned());
            return;
        };
        let table = Arc::clone(&found.table);
        self.search(&table, true, move |task| work::compare_metal(&found, task));
    }

    fn search(
        &mut self,
        table: &Table,
        is_comparison: bool,
        work: impl FnOnce(&Task) -> Result<FoundMetal, Failure> + Send + 'static,
    ) {
        let job = Job::start("find metal", &self.waker, work);
        let searching = Searching { table: Arc::clone(table), is_comparison, job };
        self.state.counts.searches += 1;
        self.state.metal.searching = Some(searching);
        self.notice.set_if_neq(Notice::Nothing);
    }

    fn show_save(&mut self, room: RoomToSave) {
        let name = match room {
            RoomToSave::Fitted => match &self.state.fitted {
                Some(fitted) => format!("{}{ENVIRONMENT_EXTENSION}", fitted.environment.name),
                None => {
                    *self.notice = Notice::Refused("no fitted room to use".to_owned());
                    return;
                }
            },
            RoomToSave::Metal => match self.found_room() {
                Some((found, _)) => {
                    let table = room_name(&found.table.file.with_extension(""));
                    format!("{table}-metal{ENVIRONMENT_EXTENSION}")
                }
                None => {
                    *self.notice = Notice::Refused("no metal that is determined to use".to_owned());
                    return;
                }
            },
        };
        let folder = self.design_folder().unwrap_or_else(|| self.table_folder());
        self.dialogs.show(FieldDialog::save_room(folder, &name, room));
    }

    /// The metal that was found, and a room of what is determined of it.
    fn found_room(&self) -> Option<(&FoundMetal, &RoomContent)> {
        let found = self.state.metal.found.as_deref()?;
        Some((found, found.room.as_ref()?))
    }

    fn save(&mut self, room: RoomToSave, file: &Path) {
        let Some(world) = &self.world else { return };
        let written = |room: RoomContent| {
            write_room_for(&world.0, file, &room.bare, room.metal.as_deref())
                .map(|reference| (room, reference))
        };
        let saved = match room {
            RoomToSave::Fitted => match &self.state.fitted {
                None => return,
                Some(fitted) => {
                    let environment =
                        Environment { name: room_name(file), ..(*fitted.environment).clone() };
                    written(RoomContent { bare: Arc::new(environment), metal: None })
                }
            },
            RoomToSave::Metal => match self.found_room() {
                None => return,
                Some((_, room)) => written(room.clone()),
            },
        };
        match saved {
            Ok((room, reference)) => {
                self.put_into(room, reference);
                self.remember(RoomSource::File(
                    file.canonicalize().unwrap_or_else(|_| file.to_owned()),
                ));
                *self.notice = Notice::Done(saved_words(file_name(file), &[]));
            }
            Err(error) => self.dialogs.show(ErrorDialog::new("The room cannot be saved", &error)),
        }
    }

    fn assign(&mut self, place: RoomSource) {
        let Some(world) = &self.world else { return };
        // A file that is gone or spoilt by now is no room to be put into.
        let read = place
            .read()
            .and_then(|room| Ok((room, trackwright_project::reference_to_room(&world.0, &place)?)));
        match read {
            Ok((room, reference)) => {
                let (left, name) = (&world.0.bare_environment().name, &room.bare.name);
                *self.notice = Notice::Done(format!(
                    "The design is in room {name}; Undo takes it back to {left}"
                ));
                self.put_into(room, reference);
                self.remember(place);
            }
            Err(error) => self.dialogs.show(ErrorDialog::new("The room cannot be opened", &error)),
        }
    }

    /// One undo step with the room's name. The room that is left stays in the list, wherever it is.
    fn put_into(&mut self, room: RoomContent, reference: String) {
        if let Some(left) = self.state.own.clone() {
            self.remember(left);
        }
        let name = &room.bare.name;
        let edit = Edit::SetEnvironment { file: reference, metal: room.metal };
        self.edits.write_batch(EditRequest::step(format!("Use room {name}"), [edit]));
    }

    fn remember(&mut self, place: RoomSource) {
        let recent = &mut self.state.recent;
        recent.retain(|other| *other != place);
        recent.insert(0, place);
        recent.truncate(MOST_RECENT);
    }

    /// Where the dialog for tables begins: beside the table that is open, else beside the design.
    fn table_folder(&self) -> PathBuf {
        let of_table = TableRole::ALL.into_iter().find_map(|role| {
            let table = self.state.slot(role).table.as_ref()?;
            table.file.parent().map(Path::to_path_buf)
        });
        of_table
            .or_else(|| self.design_folder())
            .filter(|folder| !folder.as_os_str().is_empty())
            .or_else(|| std::env::current_dir().ok())
            .unwrap_or_else(|| PathBuf::from("/"))
    }

    /// `None` for a built-in design.
    fn design_folder(&self) -> Option<PathBuf> {
        match self.world.as_ref()?.0.document.origin() {
            Origin::File(file) => file.parent().map(Path::to_path_buf),
            Origin::BuiltIn(_) => None,
        }
    }
}

/// The path with the extension of environments where a person left it out.
fn with_extension(path: &Path) -> PathBuf {
    let name = path.as_os_str().to_string_lossy();
    if name.ends_with(".ron") {
        path.to_path_buf()
    } else {
        PathBuf::from(format!("{name}{ENVIRONMENT_EXTENSION}"))
    }
}
