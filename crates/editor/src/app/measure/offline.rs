//! Without a renderer: from an edit to its figures, and placements.

use crate::StatePlugin;
use crate::app::measure::error::{MeasureError, PATIENCE};
use crate::app::measure::worlds::{order_four, tube};
use crate::document::apply::DocumentPlugin;
use crate::document::requests::{EditRequest, OpenWorld};
use crate::runner::results::Results;
use crate::runner::solve::SolverPlugin;
use crate::runner::wake::Waker;
use bevy::prelude::*;
use std::sync::Mutex;
use std::sync::mpsc::{Receiver, channel};
use std::time::{Duration, Instant};
use trackwright_design::{BodyRole, Edit};
use trackwright_simulation::placement::vertices;
use trackwright_simulation::{AxisRule, CoilDepth, PlacedBody, PlacementPlan, place};
use trackwright_task::Task;

/// A tube of 20,000 vertices.
const PLACED: [u32; 2] = [100, 199];

/// Moves a sensor of the built-in design again and again; the time of each from the edit to its
/// stamped figures, of all poses, in the resource that panels read.
pub fn edits_to_figures(count: usize) -> Result<Vec<Duration>, MeasureError> {
    let world = order_four()?;
    let mut app = App::new();
    app.add_plugins((MinimalPlugins, StatePlugin, DocumentPlugin, SolverPlugin))
        .insert_resource(OpenWorld(world));
    let (sender, wakes) = channel();
    app.world().resource::<Waker>().wake_with(move || {
        // The last wake finds nobody.
        let _ = sender.send(());
    });
    let wakes = Mutex::new(wakes);
    wait_for_figures(&mut app, &wakes)?;
    let mut times = Vec::with_capacity(count);
    for i in 0..count {
        let tool = &app.world().resource::<OpenWorld>().0.document.design().tool;
        let Some(mut sensor) = tool.body.rigid.sensors.first().cloned() else {
            return Err(MeasureError::NoFigures);
        };
        sensor.position_in_body.z += if i % 2 == 0 { 1.0 } else { -1.0 };
        let start = Instant::now();
        app.world_mut().write_message(EditRequest::Apply(Edit::SetSensor {
            body: BodyRole::Tool,
            index: 0,
            sensor,
        }));
        wait_for_figures(&mut app, &wakes)?;
        times.push(start.elapsed());
    }
    Ok(times)
}

/// Updates until the figures of all poses belong to the document's revision.
fn wait_for_figures(app: &mut App, wakes: &Mutex<Receiver<()>>) -> Result<(), MeasureError> {
    let start = Instant::now();
    loop {
        app.update();
        let revision = app.world().resource::<OpenWorld>().0.document.revision();
        let results = app.world().resource::<Results>();
        let study = results.study.as_ref();
        if results.is_whole() && study.is_some_and(|s| s.revision == revision) {
            return Ok(());
        }
        if start.elapsed() > PATIENCE {
            return Err(MeasureError::NoFigures);
        }
        if let Ok(wakes) = wakes.lock() {
            // A wake is only a hint to look again.
            let _ = wakes.recv_timeout(PATIENCE);
        }
    }
}

/// How long the pictures of a placement took.
pub struct Placed {
    pub vertices: usize,
    pub first: Duration,
    pub last: Duration,
}

/// Places the built-in design's first sensor all over a tube.
pub fn placement() -> Result<Placed, MeasureError> {
    let world = order_four()?;
    let scenario = trackwright_project::resolve(world.document.design(), &world.environment);
    let [around, along] = PLACED;
    let start = Instant::now();
    let plan = PlacementPlan {
        body: PlacedBody::Tool,
        sensor: 0,
        rule: AxisRule::default(),
        candidates: vertices(&tube(around, along)).into(),
        depth: CoilDepth::Surface,
        surface: None,
    };
    let mut first = None;
    place(&scenario, &plan, &Task::default(), &mut |_| {
        first.get_or_insert_with(|| start.elapsed());
    })?;
    let last = start.elapsed();
    Ok(Placed { vertices: plan.candidates.len(), first: first.unwrap_or(last), last })
}
