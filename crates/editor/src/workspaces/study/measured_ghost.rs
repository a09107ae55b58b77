//! A recording pose by pose: the built tool where it was measured, beside the ghost that is predicted.

use crate::document::requests::OpenWorld;
use crate::document::shown::ShownDesign;
use crate::document::trials::{ModeKind, TrialChoice};
use crate::layers::legend::{Legend, Legends, StrokeKey};
use crate::layers::magnification::{ShownErrors, anything_moved};
use crate::layers::tool_ghost::{GhostLook, ToolGhost};
use crate::palette;
use crate::scene::bodies::shown_mesh;
use crate::schedule::EditorSystems;
use bevy::prelude::*;
use trackwright_design::BodyRole;
use trackwright_design::view::Layer;
use trackwright_geometry::pose::Pose;
use trackwright_scene::tool_errors::ToolErrors;

const LOOK: GhostLook = GhostLook {
    name: "measured ghost",
    color: palette::MEASURED,
    middle_alpha: 0.12,
    rim_alpha: 0.9,
    hidden_alpha: None,
    // Behind the design's own ghost.
    order_mm: 175.0,
    is_of_design: true,
};

/// In the legend it comes after the design's own ghost.
const LEGEND_ORDER: u32 = Layer::GHOST.order + 2;

const WORDS: &str = "tool as measured";
const PLAIN_WORDS: &str = "where the built tool was measured";

/// Draws the measured tool while a recorded pose is shown.
pub struct MeasuredGhostPlugin;

/// The measured tool's ghost.
#[derive(Component)]
struct MeasuredGhost;

impl Plugin for MeasuredGhostPlugin {
    fn build(&self, app: &mut App) {
        app.add_systems(
            Update,
            show.run_if(resource_exists::<OpenWorld>.and_then(resource_exists::<ShownDesign>))
                .run_if(anything_moved.or_else(resource_exists_and_changed::<TrialChoice>))
                .in_set(EditorSystems::Draw),
        );
    }
}

fn show(
    errors: ShownErrors,
    choice: Res<TrialChoice>,
    mut ghost: ToolGhost<MeasuredGhost>,
    mut legends: ResMut<Legends>,
) {
    let tool = measured_tool(&errors, &choice);
    let mesh = tool.and_then(|_| shown_mesh(&errors.world.0, BodyRole::Tool));
    let stroke = mesh.as_ref().map(|_| StrokeKey::new(palette::MEASURED, WORDS, PLAIN_WORDS));
    legends.set(LEGEND_ORDER, Legend { stroke, ..Legend::default() });
    ghost.show(mesh.as_ref().zip(tool), errors.times(), MeasuredGhost, &LOOK);
}

/// The built tool at the recorded pose that is shown; `None` where none is, or where its measured pose
/// is not known.
fn measured_tool(errors: &ShownErrors, choice: &TrialChoice) -> Option<ToolErrors> {
    let trial = errors.shown.trial.as_ref().filter(|trial| trial.kind == ModeKind::Input)?;
    let has_motion = errors.world.0.document.design().motion.is_some();
    let measured = choice.measured(has_motion)?.get(trial.number)?.crf_from_tool?;
    let design = &errors.shown.design;
    let tracker_from_crf = design.tracker_from_body(BodyRole::Crf).unwrap_or_else(Pose::identity);
    Some(ToolErrors {
        tracker_from_tool: tracker_from_crf * design.tool.crf_from_tool,
        tracker_from_tool_reported: tracker_from_crf * measured,
        tip_in_tool: design.body(BodyRole::Tool)?.rigid.judged_tip_in_body(),
    })
}
