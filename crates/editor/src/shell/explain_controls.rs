//! Names and places of the controls, for scripts that operate the window.

use crate::runner::diagnostics::Explain;
use bevy::prelude::*;
use bevy_egui::egui::accesskit::{Node, TreeUpdate};
use bevy_egui::{EguiContexts, EguiFullOutput, EguiPostUpdateSet};

/// Reports each named control with its place beside [`Explain`]'s other lines. Insert it to have
/// the lines; egui then describes its controls in each frame, which costs time.
#[derive(Resource, Default)]
pub struct ExplainControls {
    last: Vec<String>,
}

/// Between `controls` and `controls end`, a line for each control whenever one of them changed:
/// `control X Y WIDTH HEIGHT ROLE NAME`, in pixels of the window.
pub struct ExplainControlsPlugin;

impl Plugin for ExplainControlsPlugin {
    fn build(&self, app: &mut App) {
        let report = report_controls
            .after(EguiPostUpdateSet::EndPass)
            .before(EguiPostUpdateSet::ProcessOutput)
            .run_if(resource_exists::<ExplainControls>.and_then(resource_exists::<Explain>));
        app.add_systems(PostUpdate, report);
    }
}

fn report_controls(
    mut contexts: EguiContexts,
    outputs: Query<&EguiFullOutput>,
    mut controls: ResMut<ExplainControls>,
    mut explain: ResMut<Explain>,
) -> Result {
    let ctx = contexts.ctx_mut()?;
    ctx.enable_accesskit();
    let scale = f64::from(ctx.zoom_factor());
    let outputs = outputs.iter().filter_map(|output| output.0.as_ref());
    let updates = outputs.filter_map(|output| output.platform_output.accesskit_update.as_ref());
    let mut lines: Vec<String> = updates.flat_map(|update| lines_of(update, scale)).collect();
    // They come in another order each time.
    lines.sort();
    if !lines.is_empty() && lines != controls.last {
        explain.line("controls");
        for line in &lines {
            explain.line(line);
        }
        explain.line("controls end");
        controls.last = lines;
    }
    Ok(())
}

fn lines_of(update: &TreeUpdate, scale: f64) -> Vec<String> {
    update.nodes.iter().filter_map(|(_, node)| line_of(node, scale)).collect()
}

/// `None` of what has no name or no place.
fn line_of(node: &Node, scale: f64) -> Option<String> {
    let name = node.label().or(node.value())?.replace('\n', " ");
    let bounds = node.bounds()?;
    let [x, y, width, height] =
        [bounds.x0, bounds.y0, bounds.width(), bounds.height()].map(|points| points * scale);
    let role = node.role();
    Some(format!("control {x:.0} {y:.0} {width:.0} {height:.0} {role:?} {name}"))
}
