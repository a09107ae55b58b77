//! Turns what the panels asked for into messages.

use crate::document::body_files::BodyFileRequest;
use crate::document::meshes::MeshRequest;
use crate::document::requests::{EditRequest, FileRequest, ViewRequest};
use crate::document::selection::{Hovered, Selected, Selection};
use crate::shell::PanelAction;
use crate::shell::commands::RunCommand;
use crate::shell::layout::PanelsShown;
use crate::workspaces::decide::DecideRequest;
use crate::workspaces::field::FieldRequest;
use crate::workspaces::live::LiveRequest;
use crate::workspaces::present::PresentRequest;
use crate::workspaces::study::desk::StudyRequest;
use bevy::ecs::system::SystemParam;
use bevy::prelude::*;
use bevy::window::RequestRedraw;

/// Where what the person asked for goes.
#[derive(SystemParam)]
pub(crate) struct Asked<'w> {
    pub shown: Res<'w, PanelsShown>,
    pub selection: ResMut<'w, Selection>,
    pub hovered: ResMut<'w, Hovered>,
    edits: MessageWriter<'w, EditRequest>,
    views: MessageWriter<'w, ViewRequest>,
    files: MessageWriter<'w, FileRequest>,
    fields: MessageWriter<'w, FieldRequest>,
    meshes: MessageWriter<'w, MeshRequest>,
    live: MessageWriter<'w, LiveRequest>,
    body_files: MessageWriter<'w, BodyFileRequest>,
    commands: MessageWriter<'w, RunCommand>,
    study: MessageWriter<'w, StudyRequest>,
    present: MessageWriter<'w, PresentRequest>,
    decide: MessageWriter<'w, DecideRequest>,
    pub redraw: MessageWriter<'w, RequestRedraw>,
}

impl Asked<'_> {
    pub fn answer(&mut self, actions: Vec<PanelAction>, hovered_here: &mut Option<Selected>) {
        let mut hovered = None;
        let mut is_asked = false;
        for action in actions {
            is_asked |= !matches!(action, PanelAction::Hover(_));
            match action {
                PanelAction::Edit(request) => {
                    self.edits.write(request);
                }
                PanelAction::View(request) => {
                    self.views.write(request);
                }
                PanelAction::File(request) => {
                    self.files.write(request);
                }
                PanelAction::Field(request) => {
                    self.fields.write(request);
                }
                PanelAction::Mesh(request) => {
                    self.meshes.write(request);
                }
                PanelAction::Live(request) => {
                    self.live.write(request);
                }
                PanelAction::BodyFile(request) => {
                    self.body_files.write(request);
                }
                PanelAction::Run(command) => {
                    self.commands.write(RunCommand(command));
                }
                PanelAction::Study(request) => {
                    self.study.write(request);
                }
                PanelAction::Present(request) => {
                    self.present.write(request);
                }
                PanelAction::Decide(request) => {
                    self.decide.write(request);
                }
                PanelAction::Select(what) => *self.selection = Selection::of(what),
                PanelAction::SelectAlso(what) => self.selection.toggle(what),
                PanelAction::Hover(what) => hovered = Some(what),
            }
        }
        // The scene hovers too: only what was hovered here is taken back here.
        if hovered != *hovered_here {
            self.hovered.set_if_neq(Hovered(hovered));
            *hovered_here = hovered;
            is_asked = true;
        }
        if is_asked {
            self.redraw.write(RequestRedraw);
        }
    }
}
