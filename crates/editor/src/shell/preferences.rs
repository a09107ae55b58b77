//! Window and layout as a person left them: put back when the window opens, and written in the
//! background when they change.

use crate::document::state::Notice;
use crate::palette::Theme;
use crate::runner::jobs::{JobInfo, Runner};
use crate::runner::wake::Waker;
use crate::schedule::EditorSystems;
use crate::shell::egui_camera::EguiCamera;
use crate::shell::registry::Workspaces;
use crate::shell::window::{LegendFolded, PanelsShown, SideWidths, Workspace};
use bevy::app::AppExit;
use bevy::ecs::system::{NonSendMarker, SystemParam};
use bevy::prelude::*;
use bevy::window::{Monitor, PrimaryWindow, RequestRedraw, WindowResized};
use bevy::winit::WINIT_WINDOWS;
use bevy_egui::{EguiContexts, EguiPlugin};
use std::path::PathBuf;
use std::time::Duration;
use trackwright_formats::preferences_file::{Preferences, SCALES, ShownPanels};
use trackwright_project::{read_preferences, write_preferences};
use trackwright_task::Task;

/// How long nothing changes before it is written: a window's edge is dragged for seconds.
const QUIET: Duration = Duration::from_millis(700);

/// Sizes that commands step through.
const STEPS: [f64; 10] = [0.8, 0.9, 1.0, 1.1, 1.25, 1.5, 1.75, 2.0, 2.5, 3.0];

/// Frames until egui has taken a new scale over: its own, then the size of the window in it, then
/// what is laid out in that.
const SETTLING_FRAMES: usize = 3;

/// How large everything is that egui draws; 1 is as the program has it.
#[derive(Resource, Clone, Copy, Debug, PartialEq)]
pub struct InterfaceScale(pub f64);

impl Default for InterfaceScale {
    fn default() -> Self {
        Self(1.0)
    }
}

/// Width and height in egui's points that the panels and the 3D view need: in a smaller window a
/// larger scale would cut what is written.
pub const LEAST_POINTS: [f64; 2] = [960.0, 600.0];

impl InterfaceScale {
    /// The scale in a window of a size in logical pixels: as large as leaves [`LEAST_POINTS`], and
    /// never reduced below 1.
    pub fn in_window(self, size_px: Vec2) -> f64 {
        let [width, height] = LEAST_POINTS;
        let most = (f64::from(size_px.x) / width).min(f64::from(size_px.y) / height);
        self.0.min(most.max(1.0))
    }

    /// The next larger (1) or smaller (-1) size that shows in a window of a size in logical pixels.
    pub fn step_in_window(&mut self, direction: i32, size_px: Option<Vec2>) {
        let shown = |scale: Self| size_px.map_or(scale.0, |px| scale.in_window(px));
        self.0 = shown(*self);
        self.step(direction);
        self.0 = shown(*self);
    }

    /// The next larger (1) or smaller (-1) size.
    pub fn step(&mut self, direction: i32) {
        let now = self.0;
        let next = match direction {
            1.. => STEPS.into_iter().find(|step| *step > now),
            _ => STEPS.into_iter().rev().find(|step| *step < now),
        };
        if let Some(next) = next {
            self.0 = next.clamp(SCALES[0], SCALES[1]);
        }
    }
}

/// What was read when the program began. Insert it before the plugins; without it nothing is
/// kept, as in pictures.
#[derive(Resource, Clone, Debug)]
pub struct Recalled {
    folder: PathBuf,
    pub preferences: Preferences,
    /// Why they are not those that were left.
    pub problem: Option<String>,
    /// Another version's file stays as it is.
    is_kept: bool,
}

impl Recalled {
    /// Preferences of a state folder; the program's own where there are none or they cannot be
    /// used.
    pub fn in_folder(folder: PathBuf) -> Self {
        let (preferences, problem, is_kept) = match read_preferences(&folder) {
            Ok(preferences) => (preferences.unwrap_or_default(), None, true),
            Err(error) => {
                let problem = format!("Window and layout are the program's own: {error}");
                (Preferences::default(), Some(problem), !error.is_other_version())
            }
        };
        Self { folder, preferences, problem, is_kept }
    }
}

/// Puts [`Recalled`] into effect and keeps it up to date; applies [`InterfaceScale`].
pub struct PreferencesPlugin;

/// Writes in the background.
#[derive(Resource)]
struct Keeper {
    runner: Runner<(), ()>,
    folder: PathBuf,
    /// As they were handed over last.
    last: Preferences,
}

impl Plugin for PreferencesPlugin {
    fn build(&self, app: &mut App) {
        app.init_resource::<InterfaceScale>();
        if app.is_plugin_added::<EguiPlugin>() {
            app.add_systems(Update, scale_interface.in_set(EditorSystems::Draw));
        }
        let Some(recalled) = app.world().get_resource::<Recalled>().cloned() else {
            return;
        };
        apply(app, &recalled);
        if !recalled.is_kept {
            return;
        }
        let keeper = Keeper {
            // A file that is written changes nothing that is shown.
            runner: Runner::new("preferences", Waker::silent()),
            folder: recalled.folder,
            last: recalled.preferences,
        };
        app.insert_resource(keeper).add_systems(
            Update,
            (shrink_to_screen.run_if(any_with_component::<Monitor>), keep.run_if(has_changed))
                .chain()
                .in_set(EditorSystems::Draw),
        );
        app.add_systems(Last, finish.run_if(on_message::<AppExit>));
    }
}

fn apply(app: &mut App, recalled: &Recalled) {
    let preferences = &recalled.preferences;
    let theme = match preferences.is_light {
        true => Theme::Light,
        false => Theme::Dark,
    };
    theme.apply();
    let known = app.world().get_resource::<Workspaces>().map_or(&[][..], |all| &all.0);
    let own = known.iter().find(|workspace| {
        // Nobody wants to begin without panels.
        workspace.name == preferences.workspace && !workspace.is_presentation
    });
    let workspace = own.or(known.first()).copied();
    let ShownPanels { left, right, history } = preferences.panels;
    app.insert_resource(theme)
        .insert_resource(workspace.unwrap_or_default())
        .insert_resource(SideWidths(preferences.widths.clone()))
        .insert_resource(InterfaceScale(preferences.scale))
        .insert_resource(LegendFolded(preferences.is_legend_folded))
        .insert_resource(PanelsShown { left, right, history });
    if let Some(problem) = &recalled.problem {
        app.insert_resource(Notice::Refused(problem.clone()));
    }
}

/// Everything that is remembered, as it is now.
#[derive(SystemParam)]
struct Now<'w, 's> {
    panels: Res<'w, PanelsShown>,
    widths: Res<'w, SideWidths>,
    legend: Res<'w, LegendFolded>,
    theme: Res<'w, Theme>,
    workspace: Res<'w, Workspace>,
    scale: Res<'w, InterfaceScale>,
    window: Query<'w, 's, (Entity, &'static Window), With<PrimaryWindow>>,
}

fn has_changed(now: Now, mut resized: MessageReader<WindowResized>) -> bool {
    let is_resized = resized.read().last().is_some();
    is_resized
        || now.panels.is_changed()
        || now.widths.is_changed()
        || now.legend.is_changed()
        || now.theme.is_changed()
        || now.workspace.is_changed()
        || now.scale.is_changed()
}

/// `NonSendMarker`: the window system is queried from the main thread.
fn keep(now: Now, mut keeper: ResMut<Keeper>, _main_thread: NonSendMarker) {
    let before = &keeper.last;
    let (mut window, mut is_maximised) = (before.window, before.is_maximised);
    if let Ok((entity, shown)) = now.window.single() {
        is_maximised = is_window_maximised(entity);
        // A maximised window comes back to the size that it had before.
        if !is_maximised {
            let size = shown.resolution.size().round().as_uvec2();
            window = Some([size.x.max(1), size.y.max(1)]);
        }
    }
    let PanelsShown { left, right, history, .. } = *now.panels;
    let preferences = Preferences {
        window,
        is_maximised,
        is_light: *now.theme == Theme::Light,
        scale: now.scale.0,
        panels: ShownPanels { left, right, history },
        workspace: now.workspace.name.to_owned(),
        widths: now.widths.0.clone(),
        is_legend_folded: now.legend.0,
    };
    if preferences == keeper.last {
        return;
    }
    keeper.last = preferences.clone();
    let (folder, info) = (keeper.folder.clone(), JobInfo::once_quiet(QUIET));
    let write = move |_: &Task, _: &mut dyn FnMut(())| {
        // What cannot be written only costs a few clicks at the next start, and is tried again with
        // the next change.
        let _ = write_preferences(&folder, &preferences);
        None
    };
    keeper.runner.submit(info, (), Box::new(write));
}

/// `false` where the window system does not report it.
fn is_window_maximised(window: Entity) -> bool {
    WINIT_WINDOWS.with_borrow(|windows| {
        windows.get_window(window).is_some_and(|window| window.is_maximized())
    })
}

/// A window that was left on a larger screen is brought onto this one, once the screens are known.
fn shrink_to_screen(
    monitors: Query<&Monitor>,
    window: Option<Single<&mut Window, With<PrimaryWindow>>>,
    mut is_done: Local<bool>,
) {
    let (Some(mut window), false) = (window, *is_done) else {
        return;
    };
    *is_done = true;
    let screens = monitors
        .iter()
        .map(|monitor| Vec2::new(monitor.physical_width as f32, monitor.physical_height as f32));
    let size = window.resolution.size();
    let scale = window.scale_factor();
    let fitting = fitting(size, screens.map(|physical| physical / scale));
    if fitting != size {
        window.resolution.set(fitting.x, fitting.y);
    }
}

/// Height of a slide in egui's points: what is written on it is read from the back of a room, on a
/// window of any size, whatever the size of the panels.
const STAGE_POINTS: f64 = 560.0;

/// A size that is on the largest of the screens as a whole.
pub fn fitting(size: Vec2, screens: impl Iterator<Item = Vec2>) -> Vec2 {
    screens
        .max_by(|a, b| (a.x * a.y).total_cmp(&(b.x * b.y)))
        .map_or(size, |screen| size.min(screen))
}

fn scale_interface(
    scale: Res<InterfaceScale>,
    workspace: Res<Workspace>,
    camera: Option<Single<&Camera, With<EguiCamera>>>,
    mut contexts: EguiContexts,
    mut redraw: MessageWriter<RequestRedraw>,
    mut unsettled: Local<usize>,
    mut last_px: Local<Option<Vec2>>,
) -> Result {
    // Unknown before the first frame.
    let target_px = camera.and_then(|camera| camera.logical_target_size());
    // Slides grow with the window, and so does the largest scale.
    let is_resized = *last_px != target_px;
    *last_px = target_px;
    if scale.is_changed() || workspace.is_changed() || is_resized || workspace.is_presentation {
        let ctx = contexts.ctx_mut()?;
        let zoom = match (workspace.is_presentation, target_px) {
            (true, Some(px)) => (f64::from(px.y) / STAGE_POINTS).max(0.5),
            (false, Some(px)) => scale.in_window(px),
            (_, None) => scale.0,
        };
        let zoom = zoom as f32;
        // A pixel more or less is no other size.
        if (ctx.zoom_factor() / zoom - 1.0).abs() > 2e-3 {
            ctx.set_zoom_factor(zoom);
            *unsettled = SETTLING_FRAMES;
        }
    }
    if *unsettled > 0 {
        *unsettled -= 1;
        redraw.write(RequestRedraw);
    }
    Ok(())
}

fn finish(mut keeper: ResMut<Keeper>) {
    keeper.runner.finish();
}
