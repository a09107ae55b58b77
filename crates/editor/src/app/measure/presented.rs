//! Frames as they leave for the screen, seen from the renderer's side.

use crate::document::requests::OpenWorld;
use crate::runner::results::Results;
use bevy::prelude::*;
use bevy::render::{Extract, ExtractSchedule, Render, RenderApp, RenderSystems};
use std::sync::{Arc, Mutex};
use std::time::Instant;

/// What was presented so far; the renderer's thread writes it, the window's reads it.
#[derive(Resource, Clone, Default)]
pub struct Presented(Arc<Mutex<Frames>>);

#[derive(Clone, Copy, Debug, Default)]
pub struct Frames {
    pub count: u64,
    /// When the first frame with tool and figures was handed to the window system.
    pub first_with_figures: Option<Instant>,
    /// Frames with figures so far.
    with_figures: u64,
}

/// Letters that are new reach the graphics adapter a frame late: the second frame shows them.
const COMPLETE_FRAME: u64 = 2;

/// Whether the frame that the renderer works on has figures.
#[derive(Resource, Default)]
struct HasFigures(bool);

/// Counts presented frames in [`Presented`].
pub struct PresentedPlugin;

impl Plugin for PresentedPlugin {
    fn build(&self, app: &mut App) {
        let presented = Presented::default();
        app.insert_resource(presented.clone());
        if let Some(render_app) = app.get_sub_app_mut(RenderApp) {
            render_app
                .insert_resource(presented)
                .init_resource::<HasFigures>()
                .add_systems(ExtractSchedule, see_figures)
                .add_systems(Render, count.in_set(RenderSystems::PostCleanup));
        }
    }
}

impl Presented {
    pub fn frames(&self) -> Frames {
        match self.0.lock() {
            Ok(frames) => *frames,
            Err(poisoned) => *poisoned.into_inner(),
        }
    }
}

fn see_figures(
    world: Extract<Option<Res<OpenWorld>>>,
    results: Extract<Option<Res<Results>>>,
    mut has_figures: ResMut<HasFigures>,
) {
    has_figures.0 = world.as_ref().zip(results.as_ref()).is_some_and(|(world, results)| {
        let revision = world.0.document.revision();
        let study = results.study.as_ref();
        results.is_whole() && study.is_some_and(|study| study.revision == revision)
    });
}

fn count(presented: Res<Presented>, has_figures: Res<HasFigures>) {
    let Ok(mut frames) = presented.0.lock() else {
        return;
    };
    frames.count += 1;
    frames.with_figures += u64::from(has_figures.0);
    if frames.with_figures == COMPLETE_FRAME && frames.first_with_figures.is_none() {
        frames.first_with_figures = Some(Instant::now());
    }
}
