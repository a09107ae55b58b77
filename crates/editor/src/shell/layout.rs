//! Lays the panels out around the 3D view and turns what they asked for into messages.

use crate::document::apply::{Notice, WorldGeneration, file_name};
use crate::document::body_files::{BodyFileRequest, BodyLoading};
use crate::document::drops::HoveringFiles;
use crate::document::meshes::{MeshLoading, MeshRequest};
use crate::document::recent::RecentDesigns;
use crate::document::requests::{ActiveDrag, EditRequest, FileRequest, OpenWorld, ViewRequest};
use crate::document::selection::{Hovered, Selected, Selection};
use crate::document::shown::ShownDesign;
use crate::document::trials::TrialChoice;
use crate::layers::layers_ui::{LayersPanel, LayersView, Listed, layers_ui};
use crate::palette::Theme;
use crate::runner::results::Results;
use crate::schedule::EditorSystems;
use crate::shell::PanelAction;
use crate::shell::command_palette::CommandPages;
use crate::shell::commands::{Command, RunCommand};
use crate::shell::dialogs::Dialogs;
use crate::shell::requests::Asked;
use crate::shell::status_bar::{StatusView, hint, status_bar_ui};
use crate::shell::top_bar::{TopBarView, top_bar_ui};
use crate::shell::window::{PointerHint, Presentation, ViewportRect, Workspace};
use crate::viewport::overlay::Covered;
use crate::viewport::scene_menu::SceneMenu;
use crate::widgets::theme;
use crate::workspaces::decide::DecideRequest;
use crate::workspaces::decide::against::Against;
use crate::workspaces::decide::desk::DecideDesk;
use crate::workspaces::decide::judged::Judged;
use crate::workspaces::decide::panels::table_ui::table_ui;
use crate::workspaces::design::baseline::{Baseline, note_baseline};
use crate::workspaces::design::body_file_ui::{BodyFileView, body_file_ui};
use crate::workspaces::design::history_ui::history_ui;
use crate::workspaces::design::inspector::{InspectorView, inspector_ui};
use crate::workspaces::design::mesh_ui::{MeshView, mesh_ui};
use crate::workspaces::design::outliner::{OutlinerView, outliner_ui};
use crate::workspaces::design::result::{ResultView, result_ui};
use crate::workspaces::design::row_page::RowPage;
use crate::workspaces::design::sensor_ui::IsAvailable;
use crate::workspaces::field::FieldRequest;
use crate::workspaces::field::desk::FieldDesk;
use crate::workspaces::field::samples::SampleScale;
use crate::workspaces::live::LiveRequest;
use crate::workspaces::live::desk::LiveDesk;
use crate::workspaces::present::panels::StageView;
use crate::workspaces::present::panels::slides_ui::slides_ui;
use crate::workspaces::present::panels::stage_ui::stage_ui;
use crate::workspaces::present::{PresentRequest, Presenter};
use crate::workspaces::study::desk::{Side, StudyDesk, StudyRequest};
use crate::workspaces::study::log::LogJob;
use crate::workspaces::study::precision::PrecisionRequest;
use crate::workspaces::study::study_panels::{StudyPanels, sides_ui};
use crate::workspaces::study::timeline_ui::trial_words;
use bevy::ecs::system::SystemParam;
use bevy::prelude::*;
use bevy::window::RequestRedraw;
use bevy_egui::egui::{self, Id, LayerId, Margin, Panel, ScrollArea, UiBuilder};
use bevy_egui::{EguiContexts, EguiPrimaryContextPass};
use trackwright_design::{Design, View};
use trackwright_field::Environment;
use trackwright_project::MeshOwner;

/// The panels around the 3D view.
///
/// Draws in [`EguiPrimaryContextPass`], writes [`ViewportRect`] and requests, changes no design.
pub struct UiPlugin;

/// Which side panels are unfolded.
#[derive(Resource, Clone, Copy, Debug, PartialEq, Eq)]
pub struct PanelsShown {
    pub left: bool,
    pub right: bool,
    /// The list of steps, at the foot of the left panel.
    pub history: bool,
}

impl Default for PanelsShown {
    fn default() -> Self {
        Self { left: true, right: true, history: false }
    }
}

/// Order of what is drawn with egui.
#[derive(SystemSet, Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub enum UiSystems {
    Panels,
    Overlay,
    Dialogs,
}

impl Plugin for UiPlugin {
    fn build(&self, app: &mut App) {
        app.init_resource::<Theme>()
            .init_resource::<PanelsShown>()
            .init_resource::<Presentation>()
            .init_resource::<Workspace>()
            .init_resource::<Selection>()
            .init_resource::<Hovered>()
            .init_resource::<ActiveDrag>()
            .init_resource::<PointerHint>()
            .init_resource::<Results>()
            .init_resource::<Notice>()
            .init_resource::<Baseline>()
            .init_resource::<Dialogs>()
            .init_resource::<RecentDesigns>()
            .init_resource::<CommandPages>()
            .init_resource::<StudyDesk>()
            .init_resource::<LogJob>()
            .init_resource::<FieldDesk>()
            .init_resource::<LiveDesk>()
            .init_resource::<SampleScale>()
            .init_resource::<WorldGeneration>()
            .init_resource::<RowPage>()
            .init_resource::<SceneMenu>()
            .init_resource::<MeshLoading>()
            .init_resource::<BodyLoading>()
            .init_resource::<HoveringFiles>()
            .add_message::<EditRequest>()
            .add_message::<ViewRequest>()
            .add_message::<FileRequest>()
            .add_message::<FieldRequest>()
            .add_message::<MeshRequest>()
            .add_message::<LiveRequest>()
            .add_message::<BodyFileRequest>()
            .add_message::<PrecisionRequest>()
            .add_message::<RunCommand>()
            .add_message::<StudyRequest>()
            .add_message::<PresentRequest>()
            .init_resource::<DecideDesk>()
            .add_message::<DecideRequest>()
            .init_resource::<Presenter>()
            .add_message::<RequestRedraw>()
            .configure_sets(
                EguiPrimaryContextPass,
                (UiSystems::Panels, UiSystems::Overlay, UiSystems::Dialogs).chain(),
            )
            .add_systems(Update, note_baseline.before(EditorSystems::Edit))
            .add_systems(
                EguiPrimaryContextPass,
                (
                    (set_style, panels).chain().in_set(UiSystems::Panels),
                    crate::shell::windows::systems().in_set(UiSystems::Dialogs),
                ),
            );
    }
}

/// Once a theme: a style set every frame would ask for the next frame.
fn set_style(
    mut contexts: EguiContexts,
    theme: Res<Theme>,
    mut set: Local<Option<Theme>>,
) -> Result {
    if *set != Some(*theme) {
        let ctx = contexts.ctx_mut()?;
        theme::apply(ctx);
        ctx.options_mut(|options| options.zoom_with_keyboard = false);
        *set = Some(*theme);
    }
    Ok(())
}

/// What the panels show.
#[derive(SystemParam)]
pub(crate) struct Shown<'w> {
    pub(crate) world: Option<Res<'w, OpenWorld>>,
    pub(crate) results: Res<'w, Results>,
    pub(crate) baseline: Res<'w, Baseline>,
    pub(crate) notice: Res<'w, Notice>,
    pub(crate) drag: Res<'w, ActiveDrag>,
    pub(crate) hint: Res<'w, PointerHint>,
    pub(crate) presentation: Res<'w, Presentation>,
    pub(crate) workspace: Res<'w, Workspace>,
    pub(crate) recent: Res<'w, RecentDesigns>,
    pub(crate) choice: Res<'w, TrialChoice>,
    pub(crate) desk: Res<'w, StudyDesk>,
    pub(crate) trial: Option<Res<'w, ShownDesign>>,
    pub(crate) log: Res<'w, LogJob>,
    pub(crate) field: Res<'w, FieldDesk>,
    pub(crate) live: Res<'w, LiveDesk>,
    pub(crate) presenter: Res<'w, Presenter>,
    pub(crate) decide: Res<'w, DecideDesk>,
    pub(crate) against: Option<Res<'w, Against>>,
    pub(crate) judged: Option<Res<'w, Judged>>,
    pub(crate) sample_scale: Res<'w, SampleScale>,
    pub(crate) generation: Res<'w, WorldGeneration>,
    pub(crate) loading: Res<'w, MeshLoading>,
    pub(crate) body_loading: Res<'w, BodyLoading>,
    pub(crate) layers: LayersPanel<'w>,
}

fn panels(
    mut commands: Commands,
    mut contexts: EguiContexts,
    shown: Shown,
    mut asked: Asked,
    viewport: Option<Res<ViewportRect>>,
    mut cover: ResMut<Covered>,
    mut hovered_here: Local<Option<Selected>>,
) -> Result {
    let ctx = contexts.ctx_mut()?;
    let mut root = egui::Ui::new(
        ctx.clone(),
        Id::new("root"),
        UiBuilder::new().layer_id(LayerId::background()).max_rect(ctx.viewport_rect()),
    );
    let mut actions = Vec::new();
    cover.0.clear();
    if let (true, Some(world)) = (shown.presentation.panels, &shown.world) {
        let is_available = |command: Command| {
            let workspace = *shown.workspace;
            command.is_available(Some(&**world), &asked.selection, shown.drag.0, workspace)
        };
        let desk = Desk {
            world: &world.0,
            shown: &shown,
            selection: &asked.selection,
            is_available: &is_available,
            hovered: asked.hovered.0,
            sides: *asked.shown,
        };
        if *shown.workspace == Workspace::Present {
            cover.0 = desk.present_ui(&mut root, &mut actions);
        } else {
            desk.all_ui(&mut root, &mut actions);
        }
    }
    let hole = root.available_rect_before_wrap();
    // egui may be zoomed; the window's logical pixels are not.
    let rect = ViewportRect {
        min: Vec2::new(hole.min.x, hole.min.y) * ctx.zoom_factor(),
        size: Vec2::new(hole.width().max(1.0), hole.height().max(1.0)) * ctx.zoom_factor(),
    };
    if viewport.is_none_or(|old| *old != rect) {
        commands.insert_resource(rect);
        asked.redraw.write(RequestRedraw);
    }
    asked.answer(actions, &mut hovered_here);
    Ok(())
}

/// Everything that the panels read, in one place.
pub(crate) struct Desk<'a> {
    pub(crate) world: &'a trackwright_project::World,
    pub(crate) shown: &'a Shown<'a>,
    selection: &'a Selection,
    is_available: IsAvailable<'a>,
    hovered: Option<Selected>,
    sides: PanelsShown,
}

impl Desk<'_> {
    pub(crate) fn design(&self) -> &Design {
        self.world.document.design()
    }

    pub(crate) fn view(&self) -> &View {
        self.world.document.view()
    }

    pub(crate) fn environment(&self) -> &Environment {
        &self.world.environment
    }

    fn all_ui(&self, root: &mut egui::Ui, actions: &mut Vec<PanelAction>) {
        Panel::top("top bar")
            .exact_size(theme::TOP_BAR_HEIGHT)
            .frame(theme::panel_frame(Margin::symmetric(6, 0)))
            .show(root, |ui| actions.extend(self.top_ui(ui)));
        Panel::bottom("status")
            .exact_size(theme::STATUS_BAR_HEIGHT)
            .frame(theme::panel_frame(Margin::symmetric(6, 0)))
            .show(root, |ui| self.status_ui(ui));
        let workspace = *self.shown.workspace;
        if workspace == Workspace::Study {
            Panel::bottom("timeline")
                .exact_size(theme::TIMELINE_HEIGHT)
                .resizable(false)
                .frame(theme::panel_frame(Margin::symmetric(8, 0)))
                .show(root, |ui| actions.extend(self.study().timeline(ui)));
        }
        if workspace == Workspace::Decide {
            Panel::bottom("compared")
                .exact_size(match self.shown.decide.compared {
                    Some(_) => theme::TABLE_HEIGHT,
                    None => theme::TABLE_HEAD_HEIGHT,
                })
                .resizable(false)
                .frame(theme::panel_frame(Margin::symmetric(10, 0)))
                .show(root, |ui| {
                    let asked = table_ui(ui, &self.decide());
                    actions.extend(asked.into_iter().map(PanelAction::Decide));
                });
        }
        if self.sides.left {
            Panel::left("left")
                .exact_size(match workspace {
                    Workspace::Decide => theme::RIGHT_WIDTH,
                    _ => theme::LEFT_WIDTH,
                })
                .resizable(false)
                .frame(theme::panel_frame(Margin::symmetric(8, 0)))
                .show(root, |ui| match workspace {
                    Workspace::Field => self.field_left_ui(ui, actions),
                    Workspace::Live => self.live_left_ui(ui, actions),
                    Workspace::Decide => self.decide_left_ui(ui, actions),
                    _ => self.left_ui(ui, actions),
                });
        }
        if self.sides.right {
            let (width, margin) = match workspace {
                Workspace::Field => (theme::FIELD_WIDTH, Margin::symmetric(12, 0)),
                Workspace::Decide => (theme::FIELD_WIDTH, Margin::ZERO),
                Workspace::Live => (theme::RIGHT_WIDTH, Margin::symmetric(12, 0)),
                _ => (theme::RIGHT_WIDTH, Margin::ZERO),
            };
            Panel::right(workspace.name())
                .exact_size(width)
                .resizable(false)
                .frame(theme::panel_frame(margin))
                .show(root, |ui| match workspace {
                    Workspace::Field => self.field_right_ui(ui, actions),
                    Workspace::Live => actions.extend(self.live().right(ui)),
                    Workspace::Decide => self.decide_right_ui(ui, actions),
                    _ => self.right_ui(ui, actions),
                });
        }
    }

    /// The slide, and beside it the panel that slides are made in while they are; what the slide's
    /// writing covers.
    fn present_ui(&self, root: &mut egui::Ui, actions: &mut Vec<PanelAction>) -> Vec<egui::Rect> {
        if self.shown.presenter.is_editing {
            self.slides_panel_ui(root, actions);
        }
        let mut covered = Vec::new();
        let stage = root.available_rect_before_wrap();
        actions.extend(stage_ui(root.ctx(), stage, &self.stage(), &mut covered));
        covered
    }

    fn slides_panel_ui(&self, root: &mut egui::Ui, actions: &mut Vec<PanelAction>) {
        Panel::left("slides")
            .exact_size(theme::LEFT_WIDTH)
            .resizable(false)
            .frame(theme::panel_frame(Margin::symmetric(8, 0)))
            .show(root, |ui| {
                ScrollArea::vertical().auto_shrink(false).show(ui, |ui| {
                    actions.extend(slides_ui(ui, &self.stage()));
                    actions.extend(self.layers_ui(ui, Listed::All));
                    ui.add_space(8.0);
                });
            });
    }

    /// What the slide is drawn from.
    fn stage(&self) -> StageView<'_> {
        StageView {
            document: &self.world.document,
            environment: &self.world.environment,
            presenter: &self.shown.presenter,
            figures: (self.shown.results.study.as_ref()).map(|study| &study.value.figures),
            expected: self.shown.results.expected_of_study(),
        }
    }

    fn top_ui(&self, ui: &mut egui::Ui) -> Vec<PanelAction> {
        let document = &self.world.document;
        let builtins: Vec<&str> = trackwright_project::builtin_names().collect();
        top_bar_ui(
            ui,
            &TopBarView {
                file: &file_name(document.origin()),
                is_dirty: document.is_dirty(),
                undo_label: document.undo_label(),
                redo_label: document.redo_label(),
                builtins: &builtins,
                recent: &self.shown.recent.designs,
                view: self.view(),
                workspace: *self.shown.workspace,
                is_left_shown: self.sides.left,
                is_right_shown: self.sides.right,
                is_history_shown: self.sides.history,
                is_available: self.is_available,
            },
        )
    }

    fn status_ui(&self, ui: &mut egui::Ui) {
        let study = self.shown.results.study.as_ref();
        status_bar_ui(
            ui,
            &StatusView {
                hint: (self.shown.hint.0.clone())
                    .unwrap_or_else(|| hint(self.design(), self.hovered, self.shown.drag.0)),
                trial: match self.shown.workspace.is_live() {
                    true => self.live().words(),
                    false => self.study().trial.map(trial_words),
                },
                study: study.map(|s| {
                    let took = self.shown.presentation.window.then_some(s.took);
                    (s.value.figures.trials, took)
                }),
                outside: study.map_or(0, |s| s.value.figures.outside),
                notice: &self.shown.notice,
            },
        );
    }

    /// What the panels of the Study workspace are drawn from.
    fn study(&self) -> StudyPanels<'_> {
        StudyPanels {
            document: &self.world.document,
            results: &self.shown.results,
            choice: &self.shown.choice,
            desk: &self.shown.desk,
            trial: self.shown.trial.as_ref().and_then(|shown| shown.trial.as_ref()),
            log: &self.shown.log,
        }
    }

    fn left_ui(&self, ui: &mut egui::Ui, actions: &mut Vec<PanelAction>) {
        if self.sides.history {
            actions.extend(history_ui(ui, &self.world.document.history()));
        }
        ScrollArea::vertical().auto_shrink(false).show(ui, |ui| {
            actions.extend(outliner_ui(
                ui,
                &OutlinerView {
                    design: self.design(),
                    environment: self.environment(),
                    view: self.view(),
                    selection: self.selection,
                    hovered: self.hovered,
                    is_available: self.is_available,
                    pose: self.shown.results.pose.as_ref().map(|p| &p.value),
                    layers: self.shown.layers.figures(),
                },
            ));
            ui.add_space(8.0);
        });
    }

    /// The list of layers, or those of the room.
    pub(crate) fn layers_ui(&self, ui: &mut egui::Ui, listed: Listed) -> Vec<PanelAction> {
        let layers = LayersView {
            view: self.view(),
            environment: self.environment(),
            figures: self.shown.layers.figures(),
            listed,
        };
        let view = layers_ui(ui, &layers);
        view.map(|view| PanelAction::View(ViewRequest::Set(view))).into_iter().collect()
    }

    pub(crate) fn result_view(&self) -> ResultView<'_> {
        let results = &self.shown.results;
        let study = results.study.as_ref();
        let before = study.and_then(|study| {
            let now =
                trackwright_simulation::headline(&study.value.figures, results.expected_of_study());
            self.shown.baseline.before(&now)
        });
        ResultView {
            results,
            before,
            has_expected: self.environment().process.is_some(),
            is_computing: study.is_some() && self.study().are_figures_old(),
            is_short: self.are_trials_shown(),
        }
    }

    /// Whether the panel at the right shows trials rather than the inspector.
    fn are_trials_shown(&self) -> bool {
        *self.shown.workspace == Workspace::Study && self.shown.desk.side == Side::Trials
    }

    /// Below the inspector's other sections, where a body is selected.
    fn body_parts_ui(&self, ui: &mut egui::Ui, actions: &mut Vec<PanelAction>) {
        let role = match self.selection.primary() {
            Some(Selected::Body(role)) => role,
            Some(Selected::Anatomy(index)) => {
                let whose = MeshOwner::Anatomy(Some(index));
                if let Some(view) = MeshView::of(self.world, whose, &self.shown.loading) {
                    actions.extend(mesh_ui(ui, &view));
                }
                return;
            }
            _ => return,
        };
        if let Some(view) = BodyFileView::of(self.world, role, &self.shown.body_loading) {
            actions.extend(body_file_ui(ui, &view));
        }
        if let Some(view) = MeshView::of(self.world, role, &self.shown.loading) {
            actions.extend(mesh_ui(ui, &view));
        }
    }

    fn right_ui(&self, ui: &mut egui::Ui, actions: &mut Vec<PanelAction>) {
        let results = &self.shown.results;
        let study_panels = self.study();
        let is_trials = self.are_trials_shown();
        if *self.shown.workspace == Workspace::Study {
            Panel::top("sides")
                .resizable(false)
                .show_separator_line(false)
                .frame(theme::panel_frame(Margin::symmetric(10, 4)))
                .show(ui, |ui| {
                    actions.extend(sides_ui(ui, study_panels.desk.side));
                });
        }
        Panel::bottom("result")
            .resizable(false)
            .frame(crate::workspaces::design::result::frame())
            .show(ui, |ui| result_ui(ui, &self.result_view()));
        egui::Frame::new().inner_margin(Margin::symmetric(12, 0)).show(ui, |ui| {
            ScrollArea::vertical().auto_shrink(false).show(ui, |ui| {
                if is_trials {
                    actions.extend(study_panels.trials(ui));
                    ui.add_space(8.0);
                    return;
                }
                actions.extend(inspector_ui(
                    ui,
                    &InspectorView {
                        design: self.design(),
                        selection: self.selection,
                        is_available: self.is_available,
                        pose: results.pose.as_ref().map(|p| &p.value),
                        derived_weight: self.environment().orientation_weight(None),
                    },
                ));
                self.body_parts_ui(ui, actions);
                ui.add_space(8.0);
            });
        });
    }
}
