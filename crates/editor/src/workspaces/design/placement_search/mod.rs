//! *Find better places*: a search for the best places of sensors, started in a panel of the Design
//! workspace; its answers are shown in the scene, and one of them can be taken.

mod answer;
mod charts_ui;
pub mod ghosts;
mod give_way;
mod kinds_ui;
pub mod result_ui;
pub mod search_ui;
pub mod state;
mod thumbnail;
pub mod wish;
mod work;

pub use answer::STEP;

use crate::document::requests::OpenWorld;
use crate::document::state::WorldGeneration;
use crate::schedule::{EditorSystems, request_then_receive};
use crate::shell::commands::{AddCommand, Command, CommandsSystems, EDIT};
use crate::shell::registry::{AddToShell, PanelInfo, Side};
use crate::shell::requests::Requests;
use crate::shell::window::{PanelsShown, Workspace};
use crate::widgets::theme::{RIGHT_MARGIN, panel_frame};
use crate::widgets::tooltip::button_ui;
use crate::workspaces::design::placement_search::search_ui::placement_search_ui;
use crate::workspaces::design::placement_search::state::{PlacementSearch, PlacementSearchRequest};
use crate::workspaces::design::workspace::WORKSPACE;
use bevy::prelude::*;
use bevy::winit::EventLoopProxyWrapper;
use bevy_egui::egui::{Margin, Panel, Ui};

pub const FIND_PLACES: Command = Command::new(
    EDIT,
    57,
    "Find better places",
    "Searches for the places of sensors with the least error, in all rooms of the design",
)
.available_if(|now| now.world.is_some());

/// The panel with its state and its command.
pub struct PlacementSearchPlugin;

impl Plugin for PlacementSearchPlugin {
    fn build(&self, app: &mut App) {
        let panel = PanelInfo::new(WORKSPACE, Side::Right);
        app.init_resource::<PlacementSearch>()
            .add_message::<PlacementSearchRequest>()
            .add_command(FIND_PLACES, open)
            .add_panel(panel.shown_if(is_open), search_panel)
            .add_panel(panel.fixed().shown_if(is_closed), open_panel)
            .add_systems(
                Update,
                answer::answer
                    .run_if(
                        on_message::<PlacementSearchRequest>.and_then(resource_exists::<OpenWorld>),
                    )
                    .after(CommandsSystems)
                    .in_set(EditorSystems::Input),
            )
            .add_systems(
                First,
                // Without a window nobody waits for frames.
                give_way::give_way
                    .run_if(is_running.and_then(resource_exists::<EventLoopProxyWrapper>)),
            )
            .add_systems(
                Update,
                request_then_receive(
                    answer::follow_document.run_if(
                        resource_exists_and_changed::<OpenWorld>
                            .or_else(resource_exists_and_changed::<WorldGeneration>),
                    ),
                    answer::receive.run_if(is_running),
                )
                .run_if(resource_exists::<OpenWorld>),
            );
    }
}

/// Whether the panel stands in the place of the inspector.
pub fn is_open(world: &World) -> bool {
    world.get_resource::<PlacementSearch>().is_some_and(|search| search.is_open)
}

pub fn is_closed(world: &World) -> bool {
    !is_open(world)
}

fn is_running(search: Res<PlacementSearch>) -> bool {
    search.running.is_some()
}

/// Shows the panel, where it is.
fn open(
    mut shown: ResMut<Workspace>,
    mut panels: ResMut<PanelsShown>,
    mut requests: MessageWriter<PlacementSearchRequest>,
) {
    shown.set_if_neq(WORKSPACE);
    panels.set_if_neq(PanelsShown { right: true, ..*panels });
    requests.write(PlacementSearchRequest::Open);
}

fn search_panel(
    mut ui: InMut<Ui>,
    world: Res<OpenWorld>,
    search: Res<PlacementSearch>,
    mut requests: Requests<PlacementSearchRequest>,
) {
    let design = world.0.document.design();
    requests.write_all(placement_search_ui(&mut ui, design, &search));
}

/// The way to it, always in view above the figures that it makes better.
fn open_panel(mut ui: InMut<Ui>, mut requests: Requests<PlacementSearchRequest>) {
    let frame = panel_frame(Margin::symmetric(RIGHT_MARGIN, 6));
    Panel::bottom("way to better places").resizable(false).frame(frame).show(&mut ui, |ui| {
        if button_ui(ui, FIND_PLACES.name, FIND_PLACES.about).clicked() {
            requests.write(PlacementSearchRequest::Open);
        }
    });
}
