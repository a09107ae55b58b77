//! Counts what the editor does, and reports it on request, one line an event.

use crate::document::requests::OpenWorld;
use crate::shell::dialogs::Dialogs;
use bevy::prelude::*;
use trackwright_design::Document;
use trackwright_simulation::{Figures, Work};

/// What was done since the start.
#[derive(Resource, Clone, Debug, Default, PartialEq, Eq)]
pub struct Diagnostics {
    /// Frames of the window.
    pub frames: u64,
    pub work: Work,
    pub poses: u64,
    pub studies: u64,
    pub studies_cancelled: u64,
    /// Studies that were kept trial by trial.
    pub profiles: u64,
    pub slices: u64,
    /// Rooms with metal that were solved for.
    pub rooms: u64,
    /// Poses that were looked up for the region of supported field.
    pub support_evaluations: u64,
    /// Results that came too late to be shown.
    pub dropped: u64,
    /// Meshes and pictures that were made or changed, and so go to the graphics card.
    pub uploads: u64,
}

/// Gets one line an event, without a line break.
pub type ExplainLine = Box<dyn FnMut(&str) + Send + Sync>;

/// Where events are reported; absent where none are requested.
#[derive(Resource)]
pub struct Explain(pub ExplainLine);

impl Explain {
    pub fn line(&mut self, text: &str) {
        (self.0)(text);
    }

    /// The counters of the work done so far.
    pub fn counters(&mut self, diagnostics: &Diagnostics) {
        let Work { study_evaluations, pose_evaluations, slice_evaluations, frame_fits, .. } =
            diagnostics.work;
        self.line(&format!(
            "counters frames={} uploads={} studies={} studies_cancelled={} poses={} slices={} rooms={} \
             study_evaluations={study_evaluations} pose_evaluations={pose_evaluations} \
             slice_evaluations={slice_evaluations} frame_fits={frame_fits}",
            diagnostics.frames,
            diagnostics.uploads,
            diagnostics.studies,
            diagnostics.studies_cancelled,
            diagnostics.poses,
            diagnostics.slices,
            diagnostics.rooms,
        ));
    }

    /// The figures that a requirement can be about, and the verdict.
    pub fn figures(&mut self, revision: u64, figures: &Figures) {
        for figure in figures.bounded() {
            let (label, words) = (figure.metric.label(), figure.words(4, ""));
            self.line(&format!("result revision={revision} {label}={words}"));
        }
        if let Some(requirement) = &figures.requirement {
            let verdict = requirement.verdict.label();
            self.line(&format!("result revision={revision} requirement={verdict}"));
        }
    }
}

/// Counts frames and reports them, and what became of the document and its dialogs in them.
pub struct DiagnosticsPlugin;

impl Plugin for DiagnosticsPlugin {
    fn build(&self, app: &mut App) {
        app.add_systems(
            Last,
            (
                report_document.run_if(resource_exists::<Explain>),
                count_uploads::<Mesh>.run_if(resource_exists::<Messages<AssetEvent<Mesh>>>),
                count_uploads::<Image>.run_if(resource_exists::<Messages<AssetEvent<Image>>>),
                count_frame,
            )
                .chain(),
        );
    }
}

/// One line when the document is another one than in the last frame, one when a dialog opens or
/// closes.
fn report_document(
    mut explain: ResMut<Explain>,
    world: Option<Res<OpenWorld>>,
    dialogs: Option<Res<Dialogs>>,
    mut last: Local<[Option<String>; 2]>,
) {
    let document = world.map(|world| document_line(&world.0.document));
    let dialog = dialogs.map(|dialogs| dialog_line(&dialogs));
    for (now, last) in [document, dialog].into_iter().zip(last.iter_mut()) {
        if now != *last {
            if let Some(line) = &now {
                explain.line(line);
            }
            *last = now;
        }
    }
}

fn document_line(document: &Document) -> String {
    let label = |label: Option<&str>| label.unwrap_or("none").to_owned();
    format!(
        "document revision={} dirty={} undo={} redo={}",
        document.revision(),
        document.is_dirty(),
        label(document.undo_label()),
        label(document.redo_label()),
    )
}

/// The dialog's text; an error in its own words.
fn dialog_line(dialogs: &Dialogs) -> String {
    let open = dialogs.current.as_ref().map(|dialog| dialog.description());
    format!("dialog {}", open.as_deref().unwrap_or("none"))
}

fn count_uploads<A: Asset>(
    mut events: MessageReader<AssetEvent<A>>,
    mut diagnostics: ResMut<Diagnostics>,
) {
    let uploads = events
        .read()
        .filter(|event| matches!(event, AssetEvent::Added { .. } | AssetEvent::Modified { .. }))
        .count() as u64;
    if uploads > 0 {
        diagnostics.uploads += uploads;
    }
}

fn count_frame(mut diagnostics: ResMut<Diagnostics>, explain: Option<ResMut<Explain>>) {
    diagnostics.frames += 1;
    if let Some(mut explain) = explain {
        explain.line(&format!("frame {}", diagnostics.frames));
    }
}
