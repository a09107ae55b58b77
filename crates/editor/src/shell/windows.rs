//! What stands above the panels: pages, menus of the scene, questions.

use crate::document::apply::WorldGeneration;
use crate::document::body_files::BodyFileRequest;
use crate::document::drops::HoveringFiles;
use crate::document::meshes::MeshRequest;
use crate::document::requests::{EditRequest, FileRequest, OpenWorld};
use crate::document::selection::Selection;
use crate::palette::ThemedColor;
use crate::shell::PanelAction;
use crate::shell::command_palette::{CommandPages, command_pages_ui};
use crate::shell::commands::{Availability, Command, RunCommand};
use crate::shell::dialogs::{DialogAnswer, Dialogs, dialog_ui};
use crate::shell::drop_plate::drop_plate_ui;
use crate::shell::window::Workspace;
use crate::viewport::scene_menu::{SceneMenu, scene_menu_ui};
use crate::workspaces::decide::DecideRequest;
use crate::workspaces::design::row_page::{RowPage, row_window};
use crate::workspaces::field::FieldRequest;
use crate::workspaces::field::desk::FieldDesk;
use crate::workspaces::field::panels::selection::selection_window;
use crate::workspaces::live::LiveRequest;
use crate::workspaces::study::precision::{PrecisionPage, PrecisionRequest};
use crate::workspaces::study::precision_ui::precision_window;
use bevy::ecs::schedule::ScheduleConfigs;
use bevy::ecs::system::{ScheduleSystem, SystemParam};
use bevy::prelude::*;
use bevy::window::RequestRedraw;
use bevy_egui::EguiContexts;
use bevy_egui::egui::{self, Id};

/// In the order in which they cover each other.
pub(crate) fn systems() -> ScheduleConfigs<ScheduleSystem> {
    (
        precision_page.run_if(is_precision_open),
        selection_page.run_if(is_selection_open),
        scene_menu.run_if(is_scene_menu_open),
        row_page.run_if(is_row_page_open),
        command_pages.run_if(is_command_page_open),
        dialogs,
        drop_plate.run_if(are_files_hovering),
    )
        .chain()
}

fn are_files_hovering(hovering: Res<HoveringFiles>) -> bool {
    !hovering.0.is_empty()
}

fn drop_plate(mut contexts: EguiContexts, hovering: Res<HoveringFiles>) -> Result {
    drop_plate_ui(contexts.ctx_mut()?, &hovering);
    Ok(())
}

fn is_precision_open(page: Option<Res<PrecisionPage>>) -> bool {
    page.is_some_and(|page| page.is_open)
}

fn precision_page(
    mut contexts: EguiContexts,
    page: Res<PrecisionPage>,
    world: Option<Res<OpenWorld>>,
    generation: Res<WorldGeneration>,
    mut requests: MessageWriter<PrecisionRequest>,
    mut redraw: MessageWriter<RequestRedraw>,
) -> Result {
    let revision = world.map(|world| world.0.document.revision());
    let is_current =
        page.of.as_ref().is_some_and(|(_, g, r)| *g == generation.0 && Some(*r) == revision);
    for request in precision_window(contexts.ctx_mut()?, &page, is_current) {
        requests.write(request);
        redraw.write(RequestRedraw);
    }
    Ok(())
}

fn is_selection_open(desk: Res<FieldDesk>, workspace: Res<Workspace>) -> bool {
    desk.is_selection_open && *workspace == Workspace::Field
}

fn selection_page(
    mut contexts: EguiContexts,
    desk: Res<FieldDesk>,
    mut requests: MessageWriter<FieldRequest>,
    mut redraw: MessageWriter<RequestRedraw>,
    mut stood: Local<Option<egui::Rect>>,
) -> Result {
    let Some(fitted) = desk.fitted.as_ref().filter(|f| f.chosen.is_some()) else {
        return Ok(());
    };
    let (asked, stands) = selection_window(contexts.ctx_mut()?, fitted);
    let is_moving = *stood != stands;
    *stood = stands;
    if is_moving || !asked.is_empty() {
        redraw.write(RequestRedraw);
    }
    for request in asked {
        requests.write(request);
    }
    Ok(())
}

fn is_scene_menu_open(menu: Res<SceneMenu>) -> bool {
    menu.0.is_some()
}

fn scene_menu(
    mut contexts: EguiContexts,
    mut menu: ResMut<SceneMenu>,
    available: Availability,
    mut commands: MessageWriter<RunCommand>,
    mut redraw: MessageWriter<RequestRedraw>,
) -> Result {
    let is_available = |command: Command| available.of(command);
    let menu = menu.bypass_change_detection();
    for action in scene_menu_ui(contexts.ctx_mut()?, menu, &is_available) {
        if let PanelAction::Run(command) = action {
            commands.write(RunCommand(command));
        }
    }
    if menu.0.is_none() {
        redraw.write(RequestRedraw);
    }
    Ok(())
}

fn is_row_page_open(page: Res<RowPage>) -> bool {
    page.is_open
}

fn row_page(
    mut contexts: EguiContexts,
    mut page: ResMut<RowPage>,
    world: Option<Res<OpenWorld>>,
    selection: Res<Selection>,
    mut edits: MessageWriter<EditRequest>,
    mut redraw: MessageWriter<RequestRedraw>,
) -> Result {
    let Some(world) = world else { return Ok(()) };
    // Writing to the resource would mark it as changed in every frame.
    let page = page.bypass_change_detection();
    let design = world.0.document.design();
    if let Some(edit) = row_window(contexts.ctx_mut()?, page, design, &selection) {
        edits.write(edit);
    }
    if !page.is_open {
        redraw.write(RequestRedraw);
    }
    Ok(())
}

fn is_command_page_open(pages: Res<CommandPages>) -> bool {
    pages.is_any_open()
}

fn command_pages(
    mut contexts: EguiContexts,
    mut pages: ResMut<CommandPages>,
    available: Availability,
    mut commands: MessageWriter<RunCommand>,
    mut redraw: MessageWriter<RequestRedraw>,
) -> Result {
    // Writing to the resource would mark it as changed in every frame.
    let pages = pages.bypass_change_detection();
    let is_available = |command: Command| available.of(command);
    if let Some(command) = command_pages_ui(contexts.ctx_mut()?, pages, is_available) {
        commands.write(RunCommand(command));
        redraw.write(RequestRedraw);
    }
    Ok(())
}

/// Where what a dialog came to goes.
#[derive(SystemParam)]
struct Asked<'w> {
    files: MessageWriter<'w, FileRequest>,
    fields: MessageWriter<'w, FieldRequest>,
    meshes: MessageWriter<'w, MeshRequest>,
    live: MessageWriter<'w, LiveRequest>,
    body_files: MessageWriter<'w, BodyFileRequest>,
    decide: MessageWriter<'w, DecideRequest>,
}

fn dialogs(
    mut contexts: EguiContexts,
    mut dialogs: ResMut<Dialogs>,
    mut asked: Asked,
    mut redraw: MessageWriter<RequestRedraw>,
) -> Result {
    let ctx = contexts.ctx_mut()?;
    // Writing to the resource would mark it as changed in every frame.
    let open = dialogs.bypass_change_detection();
    let Some(dialog) = &mut open.current else {
        return Ok(());
    };
    // egui keeps the size of what it has seen: a short question is no list of files.
    let kind = std::mem::discriminant(&*dialog);
    let modal = egui::Modal::new(Id::new(("dialog", kind)))
        .backdrop_color(crate::palette::SHADOW.color32_alpha(140))
        .show(ctx, |ui| dialog_ui(ui, dialog));
    let is_closed = modal.should_close();
    let answer = match modal.inner {
        None if is_closed => Some(DialogAnswer::Close),
        answer => answer,
    };
    let Some(answer) = answer else { return Ok(()) };
    redraw.write(RequestRedraw);
    open.current = match answer {
        DialogAnswer::Close => None,
        DialogAnswer::Become(dialog) => Some(dialog),
        DialogAnswer::Request(request) => {
            asked.files.write(request);
            None
        }
        DialogAnswer::Mesh(request) => {
            asked.meshes.write(request);
            None
        }
        DialogAnswer::BodyFile(request) => {
            asked.body_files.write(request);
            None
        }
        DialogAnswer::Field(request) => {
            asked.fields.write(request);
            None
        }
        DialogAnswer::Decide(request) => {
            asked.decide.write(request);
            None
        }
        DialogAnswer::Live(request) => {
            asked.live.write(request);
            None
        }
    };
    Ok(())
}
