//! The slide over the 3D view, and the panel in which slides are made.

use crate::document::requests::OpenWorld;
use crate::runner::results::Results;
use crate::shell::requests::Requests;
use crate::shell::window::SceneCover;
use crate::workspaces::present::panels::StageView;
use crate::workspaces::present::panels::slides_ui::slides_ui;
use crate::workspaces::present::panels::stage_ui::stage_ui;
use crate::workspaces::present::requests::{PresentRequest, Presenter};
use bevy::ecs::system::SystemParam;
use bevy::prelude::*;
use bevy_egui::egui::Ui;

/// What a slide is drawn from.
#[derive(SystemParam)]
pub(crate) struct Shown<'w> {
    world: Res<'w, OpenWorld>,
    results: Res<'w, Results>,
    presenter: Res<'w, Presenter>,
}

impl Shown<'_> {
    fn view(&self) -> StageView<'_> {
        StageView {
            document: &self.world.0.document,
            environment: &self.world.0.environment,
            presenter: &self.presenter,
            figures: self.results.study.as_ref().map(|study| &study.value.figures),
        }
    }
}

pub(crate) fn slides_panel(
    mut ui: InMut<Ui>,
    shown: Shown,
    mut requests: Requests<PresentRequest>,
) {
    requests.write_all(slides_ui(&mut ui, &shown.view()));
}

pub(crate) fn stage_panel(
    ui: InMut<Ui>,
    shown: Shown,
    mut cover: ResMut<SceneCover>,
    mut requests: Requests<PresentRequest>,
) {
    let stage = ui.available_rect_before_wrap();
    let cover = &mut cover.bypass_change_detection().0;
    requests.write_all(stage_ui(ui.ctx(), stage, &shown.view(), cover));
}
