//! Carries out the panels' requests, or starts the thread that does.

use crate::document::file_names::file_folder;
use crate::document::requests::{EditRequest, FileRequest, OpenWorld};
use crate::document::state::{Notice, WorldGeneration};
use crate::document::trials::TrialChoice;
use crate::runner::jobs::Job;
use crate::runner::wake::Waker;
use crate::scene::bodies::shown_mesh;
use crate::shell::dialogs::{Dialogs, ErrorDialog};
use crate::shell::window::Workspace;
use crate::workspaces::decide::dialog::DecideDialog;
use crate::workspaces::decide::judged::Judged;
use crate::workspaces::decide::requests::DecideRequest;
use crate::workspaces::decide::state::{DecideState, Pinned};
use crate::workspaces::decide::table::{AddedDesign, Compare, Failure, Wanted, compared};
use crate::workspaces::field::FieldRequest;
use crate::workspaces::study::{self, state::StudyRequest};
use bevy::ecs::system::SystemParam;
use bevy::prelude::*;
use bevy::window::RequestRedraw;
use std::path::{Path, PathBuf};
use std::sync::Arc;
use trackwright_calibration::agreement::{BuiltRecording, RecordedFrame};
use trackwright_design::{BodyRole, Decision, Edit, Origin, ProcedureEdit};
use trackwright_procedure::Step;
use trackwright_project::{Files, RoomSource, file_name};

pub(crate) fn answer(mut requests: MessageReader<DecideRequest>, mut params: DecideParams) {
    for request in requests.read() {
        params.answer(request.clone());
    }
    params.redraw.write(RequestRedraw);
}

/// What the requests work on.
#[derive(SystemParam)]
pub(crate) struct DecideParams<'w> {
    state: ResMut<'w, DecideState>,
    world: Option<Res<'w, OpenWorld>>,
    generation: Res<'w, WorldGeneration>,
    waker: Res<'w, Waker>,
    dialogs: ResMut<'w, Dialogs>,
    notice: ResMut<'w, Notice>,
    workspace: ResMut<'w, Workspace>,
    judged: Res<'w, Judged>,
    edits: MessageWriter<'w, EditRequest>,
    files: MessageWriter<'w, FileRequest>,
    fields: MessageWriter<'w, FieldRequest>,
    study: MessageWriter<'w, StudyRequest>,
    redraw: MessageWriter<'w, RequestRedraw>,
}

impl DecideParams<'_> {
    fn answer(&mut self, request: DecideRequest) {
        match request {
            DecideRequest::PinHere => self.pin_here(),
            DecideRequest::ShowPin => {
                let folder = self.folder(self.state.designs_folder.as_deref());
                self.dialogs.show(DecideDialog::pin(folder));
            }
            DecideRequest::Pin(file) => self.pin(file),
            DecideRequest::Unpin => {
                self.state.pinned = None;
                self.state.pinning = None;
            }
            DecideRequest::ShowAddDesign => {
                let folder = self.folder(self.state.designs_folder.as_deref());
                self.dialogs.show(DecideDialog::add_design(folder));
            }
            DecideRequest::AddDesign(file) => self.add_designs(vec![file]),
            DecideRequest::AddDesigns(files) => self.add_designs(files),
            DecideRequest::AddBuiltIn(name) => self.add(vec![AddedDesign::BuiltIn(name)]),
            DecideRequest::RemoveDesign(added) => {
                self.state.designs.retain(|other| *other != added);
            }
            DecideRequest::AddRoom(place) => self.add_room(place),
            DecideRequest::RemoveRoom(file) => self.edit(ProcedureEdit::RemoveRoom(file)),
            DecideRequest::ShowRecorded(body) => {
                let folder = self.folder(self.state.recordings_folder.as_deref());
                self.dialogs.show(DecideDialog::open_recorded(folder, body));
            }
            DecideRequest::Recorded(body, file) => {
                self.state.recordings_folder = file.parent().map(Path::to_path_buf);
                self.recorded(body, &file);
            }
            DecideRequest::SetRecorded(recorded) => self.state.recorded = Some(recorded),
            DecideRequest::CloseRecorded => self.state.recorded = None,
            DecideRequest::ShowPoses => self.show_poses(),
            DecideRequest::SetNote(step, note) => self.state.notes[step.number() - 1] = note,
            DecideRequest::Decide(step) => self.decide(step),
            DecideRequest::Withdraw(step) => self.edit(ProcedureEdit::Withdraw { step }),
            DecideRequest::Compare => self.compare(),
            DecideRequest::CancelCompare => {
                if let Some(job) = &self.state.comparing {
                    job.cancel();
                }
            }
            DecideRequest::OpenRow(row) => self.open_row(row),
            DecideRequest::ShowAllFigures(all) => self.state.shows_all_figures = all,
        }
    }

    fn pin_here(&mut self) {
        let Some(world) = &self.world else { return };
        self.state.serial += 1;
        self.state.pinning = None;
        self.state.pinned = Some(Pinned {
            design: Arc::new(world.0.document.design().clone()),
            file: None,
            tool_mesh: shown_mesh(&world.0, BodyRole::Tool),
            serial: self.state.serial,
            is_gone: false,
        });
    }

    /// The baseline that is there stays until the new one is.
    fn pin(&mut self, file: PathBuf) {
        self.state.designs_folder = file.parent().map(Path::to_path_buf);
        self.state.serial += 1;
        let serial = self.state.serial;
        self.state.pinning = Some(Job::start("pin", &self.waker, move |_| {
            let world = trackwright_project::open_design(&file)?;
            Ok(Pinned {
                design: Arc::new(world.document.design().clone()),
                tool_mesh: shown_mesh(&world, BodyRole::Tool),
                file: Some(file),
                serial,
                is_gone: false,
            })
        }));
    }

    fn add_designs(&mut self, files: Vec<PathBuf>) {
        if let Some(folder) = files.first().and_then(|file| file.parent()) {
            self.state.designs_folder = Some(folder.to_path_buf());
        }
        self.add(files.into_iter().map(AddedDesign::File).collect());
    }

    /// Adds those that are not in the table, which the open one always is; names the others.
    fn add(&mut self, designs: Vec<AddedDesign>) {
        let mut known = Vec::new();
        for added in designs {
            let is_same = |other: &AddedDesign| match (other, &added) {
                (AddedDesign::File(a), AddedDesign::File(b)) => {
                    trackwright_project::is_same_file(a, b)
                }
                (other, added) => other == added,
            };
            let is_open =
                self.world.as_ref().is_some_and(|world| added.is_open(world.0.document.origin()));
            match is_open || self.state.designs.iter().any(is_same) {
                true => known.push(added.to_string()),
                false => self.state.designs.push(added),
            }
        }
        match known.as_slice() {
            [] => {}
            [one] => *self.notice = Notice::Refused(format!("{one} is in the table already")),
            many => {
                let names = many.join(", ");
                *self.notice = Notice::Refused(format!("these are in the table already: {names}"));
            }
        }
    }

    fn edit(&mut self, edit: ProcedureEdit) {
        self.edits.write(EditRequest::Apply(Edit::Procedure(edit)));
    }

    fn add_room(&mut self, place: RoomSource) {
        let Some(world) = &self.world else { return };
        match trackwright_project::reference_to_room(&world.0, &place) {
            Ok(reference) => self.edit(ProcedureEdit::AddRoom(reference)),
            Err(error) => self.dialogs.show(ErrorDialog::new("The room cannot be used", &error)),
        }
    }

    /// In the tracker's frame, its truth known beforehand, as `characterize` writes such a table.
    /// The tool's table begins a recording, the CRF's joins it.
    fn recorded(&mut self, body: BodyRole, file: &Path) {
        let Some(world) = &self.world else { return };
        let reference = match trackwright_project::reference_to_file(&world.0, file) {
            Ok(reference) => reference,
            Err(error) => {
                self.dialogs.show(ErrorDialog::new("The recording cannot be used", &error));
                return;
            }
        };
        match (body, &mut self.state.recorded) {
            (BodyRole::Tool, recorded) => *recorded = Some(BuiltRecording::of(reference)),
            (BodyRole::Crf, Some(recorded)) => {
                recorded.crf_table = Some(reference);
                // Both tables are the tracker's.
                recorded.frame = RecordedFrame::Tracker;
            }
            (BodyRole::Crf, None) => {}
        }
    }

    /// Reads the recording that is looked at; the Study workspace shows it once it is there.
    fn show_poses(&mut self) {
        let Some(world) = &self.world else { return };
        let Some(recorded) = self.state.recorded.clone() else { return };
        let world = world.0.clone();
        self.state.reading_poses = Some(Job::start("poses", &self.waker, move |task| {
            trackwright_project::recorded_poses(&Files::default(), &world, &recorded, task)
        }));
    }

    /// On what is shown, and only where that is of the design as it is.
    fn decide(&mut self, step: Step) {
        let Some((status, true)) = self.judged.found() else {
            *self.notice = Notice::Refused("its figures are still being computed".to_owned());
            return;
        };
        let note = self.state.note(step).trim().to_owned();
        if let (Some(objection), "") = (status.objection(step), note.as_str()) {
            *self.notice =
                Notice::Refused(format!("{step}: {objection}, so the decision needs a reason"));
            return;
        }
        let decision = match (status.basis(step), trackwright_project::today()) {
            (Ok(basis), Ok(date)) => Decision { date, note, basis },
            (Err(why), _) => {
                *self.notice = Notice::Refused(why.to_string());
                return;
            }
            (_, Err(why)) => {
                *self.notice = Notice::Refused(why.to_string());
                return;
            }
        };
        self.state.notes[step.number() - 1].clear();
        self.edit(ProcedureEdit::Decide { step, decision: Box::new(decision) });
    }

    fn compare(&mut self) {
        let Some(world) = &self.world else { return };
        if let Some(pinned) = &mut self.state.pinned {
            pinned.is_gone = pinned.file.as_deref().is_some_and(|file| !file.exists());
        }
        let wanted = Wanted {
            open: Arc::new(world.0.document.design().clone()),
            pinned: (self.state.pinned.as_ref()).map(|pinned| Arc::clone(&pinned.design)),
            added: self.state.designs.clone(),
            environment: Arc::clone(&world.0.environment),
            rooms: trackwright_project::further_rooms(&world.0).unwrap_or_default(),
            generation: self.generation.0,
        };
        self.state.counts.tables += 1;
        let job = Job::start("compare", &self.waker, move |task| compared(wanted, task));
        self.state.comparing = Some(job);
    }

    /// A row of the open design in its own room leads to its worst trial; in another room, puts it
    /// there; any other opens its design.
    fn open_row(&mut self, row: usize) {
        let Some(compared) = &self.state.compared else {
            return;
        };
        let Some(row) = compared.comparison.rows.get(row) else {
            return;
        };
        let room = compared.rooms.get(row.room).cloned().flatten();
        let design = match compared.designs.get(row.design) {
            Some(Compare::Added(added)) => added.clone(),
            Some(Compare::Pinned) => {
                match self.state.pinned.as_ref().and_then(|p| p.file.clone()) {
                    Some(file) => AddedDesign::File(file),
                    None => {
                        *self.notice = Notice::Refused(
                            "the baseline is an earlier state of the open design: undo leads to it"
                                .to_owned(),
                        );
                        return;
                    }
                }
            }
            Some(Compare::Open) => {
                match room {
                    Some(place) => {
                        self.fields.write(FieldRequest::Assign(place));
                    }
                    None => {
                        *self.workspace = study::WORKSPACE;
                        self.study.write(StudyRequest::ShowWorst);
                    }
                }
                return;
            }
            None => return,
        };
        self.state.then_assign = room.map(|room| (design.clone(), room));
        self.files.write(match design {
            AddedDesign::File(file) => FileRequest::Open(file),
            AddedDesign::BuiltIn(name) => FileRequest::OpenBuiltIn(name.to_owned()),
        });
    }

    /// Where a dialog begins: where its files were chosen last, else beside the open design.
    fn folder(&self, last: Option<&Path>) -> PathBuf {
        if let Some(last) = last.filter(|last| last.is_dir()) {
            return last.to_path_buf();
        }
        let beside = self.world.as_ref().and_then(|world| {
            let Origin::File(file) = world.0.document.origin() else {
                return None;
            };
            let folder = file.parent().filter(|f| !f.as_os_str().is_empty());
            folder.map(Path::to_path_buf)
        });
        beside.unwrap_or_else(|| PathBuf::from("."))
    }
}

/// Another design is open: a recording and reasons of the last one are not its, and where a row was
/// opened it goes into that row's room.
pub(crate) fn turn_to_opened(
    mut state: ResMut<DecideState>,
    world: Res<OpenWorld>,
    mut fields: MessageWriter<FieldRequest>,
) {
    state.recorded = None;
    state.notes = Default::default();
    let Some((design, room)) = state.then_assign.take() else {
        return;
    };
    let is_it = design.is_open(world.0.document.origin());
    if is_it && trackwright_project::own_room(&world.0).ok().as_ref() != Some(&room) {
        fields.write(FieldRequest::Assign(room));
    }
}

/// The design was saved for the first time, or elsewhere: the recording stays the one that it was.
pub(crate) fn follow_to_folder(
    mut state: ResMut<DecideState>,
    world: Res<OpenWorld>,
    mut last: Local<Option<(Origin, PathBuf)>>,
) {
    let origin = world.0.document.origin();
    if last.as_ref().is_some_and(|(last, _)| last == origin) {
        return;
    }
    let now = (origin.clone(), file_folder(&world.0));
    let old = last.replace(now);
    let (Some((_, old)), Some(recorded)) = (old, &state.recorded) else {
        return;
    };
    let mut moved = recorded.clone();
    for reference in moved.references_mut() {
        // Joined to the old folder, an absolute one is itself.
        if let Ok(now) = trackwright_project::reference_to_file(&world.0, &old.join(&*reference)) {
            *reference = now;
        }
    }
    state.recorded = Some(moved);
}

/// Takes what the threads found.
pub(crate) fn receive_results(
    mut state: ResMut<DecideState>,
    mut dialogs: ResMut<Dialogs>,
    (mut choice, mut workspace): (ResMut<TrialChoice>, ResMut<Workspace>),
    mut redraw: MessageWriter<RequestRedraw>,
) {
    const NO_POSES: &str = "The recording cannot be shown pose by pose";
    const NO_COMPARISON: &str = "There is no comparison";
    const NOT_PINNED: &str = "The design cannot be pinned";
    let state = state.bypass_change_detection();
    if let Some(answer) = state.comparing.as_ref().and_then(Job::answer) {
        state.comparing = None;
        redraw.write(RequestRedraw);
        match answer {
            Ok(Ok(found)) => state.compared = Some(found),
            Ok(Err(Failure::Cancelled(_))) => {}
            Err(lost) => dialogs.show(ErrorDialog::new(NO_COMPARISON, &lost)),
        }
    }
    if let Some(answer) = state.reading_poses.as_ref().and_then(Job::answer) {
        state.reading_poses = None;
        redraw.write(RequestRedraw);
        match answer {
            Ok(Ok(poses)) => {
                let table = state.recorded.as_ref().map(|recorded| Path::new(&recorded.table));
                choice.take_recording(table.map(file_name).unwrap_or_default(), poses);
                *workspace = study::WORKSPACE;
            }
            Ok(Err(error)) => dialogs.show(ErrorDialog::new(NO_POSES, &error)),
            Err(lost) => dialogs.show(ErrorDialog::new(NO_POSES, &lost)),
        }
    }
    if let Some(answer) = state.pinning.as_ref().and_then(Job::answer) {
        state.pinning = None;
        redraw.write(RequestRedraw);
        match answer {
            Ok(Ok(pinned)) => state.pinned = Some(pinned),
            Ok(Err(error)) => dialogs.show(ErrorDialog::new(NOT_PINNED, &error)),
            Err(lost) => dialogs.show(ErrorDialog::new(NOT_PINNED, &lost)),
        }
    }
}
