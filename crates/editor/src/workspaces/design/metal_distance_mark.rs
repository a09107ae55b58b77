//! A ball in the scene where the selected metal object may be nearest to the tip. A click puts it there.

use super::metal_distance::MetalDistance;
use crate::document::requests::{EditRequest, OpenWorld};
use crate::document::selection::{Selected, Selection};
use crate::document::state::WorldGeneration;
use crate::palette;
use crate::scene::materials::glow::GlowMaterial;
use crate::schedule::EditorSystems;
use crate::shell::window::{Presentation, Workspace};
use crate::viewport::ball_handle::{BallHandle, Balls, LARGE_PX};
use bevy::picking::events::{Click, Pointer};
use bevy::picking::pointer::PointerButton;
use bevy::prelude::*;
use nalgebra::Point3;
use trackwright_design::{Edit, MetalEdit};

/// The ball, with the edit that a click makes.
#[derive(Component, Clone, Debug, PartialEq)]
pub struct LeastDistanceMark(Edit);

pub(super) fn plugin(app: &mut App) {
    app.add_observer(on_click).add_systems(
        Update,
        mark.run_if(resource_exists::<OpenWorld>.and_then(resource_exists::<Assets<GlowMaterial>>))
            .run_if(
                resource_changed::<MetalDistance>
                    .or_else(resource_changed::<OpenWorld>)
                    .or_else(resource_changed::<Selection>)
                    .or_else(resource_changed::<Workspace>),
            )
            .in_set(EditorSystems::Draw),
    );
}

fn mark(
    (state, selection): (Res<MetalDistance>, Res<Selection>),
    (world, generation): (Res<OpenWorld>, Res<WorldGeneration>),
    (workspace, presentation): (Res<Workspace>, Res<Presentation>),
    mut balls: Balls<LeastDistanceMark>,
) {
    let document = &world.0.document;
    let least = state.least(document.design(), generation.0, document.revision());
    let is_shown = workspace.edits_design && presentation.window;
    let least =
        least.filter(|(index, _)| is_shown && selection.primary() == Some(Selected::Metal(*index)));
    let wanted = least.map(|(index, tracker_from_object)| {
        let name = document.design().metal_object(index).map_or("it", |own| own.name.as_str());
        let words = format!(
            "The requirement holds from here on · Click to put {name} here, at its least distance"
        );
        let at_mm = Point3::from(tracker_from_object.translation.vector);
        let edit = Edit::Metal(MetalEdit::SetPose { index, tracker_from_object });
        (LeastDistanceMark(edit), BallHandle { at_mm, radius_px: LARGE_PX }, words)
    });
    balls.place("least distance", |_| palette::BEST_PLACE, wanted, |_, _| true);
}

fn on_click(
    mut click: On<Pointer<Click>>,
    marks: Query<&LeastDistanceMark>,
    mut edits: MessageWriter<EditRequest>,
) {
    let Ok(mark) = marks.get(click.entity) else { return };
    click.propagate(false);
    if click.button == PointerButton::Primary {
        edits.write(EditRequest::Apply(mark.0.clone()));
    }
}
