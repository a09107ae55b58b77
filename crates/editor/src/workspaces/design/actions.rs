//! What the panels of the Design workspace request.

use crate::document::requests::BodyFileRequest;
use crate::document::requests::MeshRequest;
use crate::document::requests::{EditRequest, ViewRequest};
use crate::document::selection::{Hovered, Selected, Selection};
use crate::document::state::Notice;
use crate::shell::commands::RunCommand;
use crate::shell::requests::Requests;
use crate::viewport::mounting::state::MountingState;
use crate::viewport::tool::SceneTool;
use crate::widgets::basic::NumberChange;
use bevy::ecs::system::SystemParam;
use bevy::prelude::*;
use bevy::window::RequestRedraw;
use trackwright_design::Edit;

/// What a person requested in a panel.
#[derive(Clone, Debug, PartialEq)]
pub enum DesignAction {
    Edit(EditRequest),
    View(ViewRequest),
    Mesh(MeshRequest),
    BodyFile(BodyFileRequest),
    /// A command, by its name.
    Run(&'static str),
    Select(Option<Selected>),
    /// Selects it with what is selected, or takes it away.
    SelectAlso(Selected),
    Hover(Selected),
    Mounting(MountingAction),
}

/// What is set in the section of mounting regions; changes of the regions are edits.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum MountingAction {
    Set(MountingState),
    /// A tool is taken in hand, or put back.
    Take(SceneTool),
    /// Why something is not done.
    Refuse(&'static str),
}

impl DesignAction {
    /// One edit that is one undo step.
    pub fn apply(edit: Edit) -> Self {
        Self::Edit(EditRequest::Apply(edit))
    }
}

/// Turns what a number field reported into requests; `edit` makes the edit of a value.
pub(crate) fn number_edits(
    changes: &[NumberChange],
    actions: &mut Vec<DesignAction>,
    label: &str,
    edit: impl Fn(f64) -> Option<Edit>,
) {
    for change in changes {
        match change {
            NumberChange::Begin => {
                actions.push(DesignAction::Edit(EditRequest::Begin(label.to_owned())));
            }
            NumberChange::Set(value) => actions.extend(edit(*value).map(DesignAction::apply)),
            NumberChange::Commit => actions.push(DesignAction::Edit(EditRequest::Commit)),
        }
    }
}

/// Writes [`DesignAction`]s as messages.
#[derive(SystemParam)]
pub(crate) struct DesignRequests<'w, 's> {
    edits: Requests<'w, 's, EditRequest>,
    views: Requests<'w, 's, ViewRequest>,
    meshes: Requests<'w, 's, MeshRequest>,
    body_files: Requests<'w, 's, BodyFileRequest>,
    run: Requests<'w, 's, RunCommand>,
    commands: Commands<'w, 's>,
}

impl DesignRequests<'_, '_> {
    pub fn write(&mut self, actions: Vec<DesignAction>) {
        for action in actions {
            match action {
                DesignAction::Edit(request) => self.edits.write(request),
                DesignAction::View(request) => self.views.write(request),
                DesignAction::Mesh(request) => self.meshes.write(request),
                DesignAction::BodyFile(request) => self.body_files.write(request),
                DesignAction::Run(command) => self.run.write(RunCommand(command)),
                DesignAction::Select(what) => self.select(move |own| *own = Selection::of(what)),
                DesignAction::SelectAlso(what) => self.select(move |own| own.toggle(what)),
                DesignAction::Hover(_) => {}
                DesignAction::Mounting(action) => self.mounting(action),
            }
        }
    }

    fn mounting(&mut self, action: MountingAction) {
        self.commands.queue(move |world: &mut World| match action {
            MountingAction::Set(state) => {
                world.resource_mut::<MountingState>().set_if_neq(state);
            }
            MountingAction::Take(tool) => {
                world.resource_mut::<SceneTool>().set_if_neq(tool);
            }
            MountingAction::Refuse(why) => {
                let notice = Notice::Refused(why.to_owned());
                world.resource_mut::<Notice>().set_if_neq(notice);
            }
        });
        self.commands.write_message(RequestRedraw);
    }

    fn select(&mut self, change: impl FnOnce(&mut Selection) + Send + 'static) {
        self.commands.queue(|world: &mut World| change(&mut world.resource_mut()));
        self.commands.write_message(RequestRedraw);
    }
}

/// The row that is hovered in a panel: the scene hovers too, and only what was hovered in a row is
/// taken back when it leaves it.
#[derive(Resource, Default)]
pub(crate) struct HoveredRow(Option<Selected>);

impl HoveredRow {
    /// Follows what a panel reported.
    pub fn follow(&mut self, actions: &[DesignAction], commands: &mut Commands) {
        let row = actions.iter().rev().find_map(|action| match action {
            DesignAction::Hover(what) => Some(*what),
            _ => None,
        });
        if row != self.0 {
            self.0 = row;
            commands.queue(move |world: &mut World| {
                world.resource_mut::<Hovered>().set_if_neq(Hovered(row));
            });
            commands.write_message(RequestRedraw);
        }
    }
}

/// Where the rows are no longer drawn nothing in them is hovered.
pub(crate) fn forget_hovered_row(mut hovered: ResMut<Hovered>, mut row: ResMut<HoveredRow>) {
    if row.0.take().is_some() {
        hovered.set_if_neq(Hovered(None));
    }
}
