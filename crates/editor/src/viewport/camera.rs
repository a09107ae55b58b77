//! The 3D camera: gestures into an orbit, the orbit into the document's view and the entity.
//!
//! Middle or right drag orbits, Shift with it pans, the wheel zooms to the pointer.

use crate::document::requests::{ActiveDrag, OpenWorld, ViewRequest};
use crate::document::selection::Selection;
use crate::document::shown::ShownDesign;
use crate::document::state::WorldGeneration;
use crate::palette::Theme;
use crate::palette::ThemedColor;
use crate::scene::extent;
use crate::schedule::EditorSystems;
use crate::shell::window::{Presentation, ViewportRect};
use crate::viewport::surfaces::Surfaces;
use crate::{convert, palette};
use bevy::camera::{ClearColorConfig, PerspectiveProjection, RenderTarget, Viewport};
use bevy::core_pipeline::tonemapping::{DebandDither, Tonemapping};
use bevy::ecs::system::SystemParam;
use bevy::input::mouse::{MouseScrollUnit, MouseWheel};
use bevy::prelude::*;
use bevy::window::{PrimaryWindow, RequestRedraw};
use bevy_egui::input::EguiWantsInput;
use nalgebra::Point3;
use std::time::Duration;
use trackwright_design::Design;
use trackwright_design::view::CameraView;
use trackwright_geometry::gizmo::Eye;
use trackwright_geometry::orbit::{OrbitCamera, VERTICAL_FOV_RAD};
use trackwright_geometry::surface::Ray;
pub use trackwright_scene::opening_view::opening_camera;
use trackwright_scene::opening_view::{first_camera, usual_camera};

/// How long the camera glides to where it was sent.
const GLIDE: Duration = Duration::from_millis(250);

/// Pixels of a trackpad's scrolling that count as a notch of a wheel.
const PIXELS_PER_NOTCH: f32 = 40.0;

/// The scene's 3D camera.
#[derive(Component, Clone, Copy, Debug, Default)]
pub struct MainCamera;

/// Spawns and moves the camera of the 3D view.
pub struct CameraPlugin;

/// Where the 3D view is painted if not in the window. Insert before startup.
#[derive(Resource, Clone, Debug)]
pub struct SceneTarget(pub RenderTarget);

/// Where the camera is and what moves it.
#[derive(Resource, Clone, Debug, PartialEq)]
pub struct OrbitRig {
    pub camera: OrbitCamera,
    /// Size of the 3D view in logical pixels.
    pub view_px: [f64; 2],
    glide: Option<Glide>,
    /// The camera of the document as last read or written here.
    known: Option<CameraView>,
    generation: Option<WorldGeneration>,
}

#[derive(Clone, Debug, PartialEq)]
struct Glide {
    from: OrbitCamera,
    to: OrbitCamera,
    elapsed: Duration,
}

/// Turns the camera by itself: how far the pointer of an orbiting hand would move between two
/// frames, pixels.
#[derive(Resource, Clone, Copy, Debug, Default, PartialEq)]
pub struct Turntable(pub Option<[f64; 2]>);

/// A drag that moves the camera.
#[derive(Resource, Default)]
pub struct Gesture(Option<(MouseButton, Vec2)>);

impl Plugin for CameraPlugin {
    fn build(&self, app: &mut App) {
        app.init_resource::<OrbitRig>()
            .init_resource::<Gesture>()
            .init_resource::<Turntable>()
            .add_systems(PreStartup, spawn)
            .add_systems(Update, clear_in_theme.run_if(resource_changed::<Theme>))
            .add_systems(
                Update,
                (drag_camera, zoom)
                    .chain()
                    .run_if(resource_exists::<ButtonInput<MouseButton>>)
                    .in_set(EditorSystems::Input),
            )
            .add_systems(Update, turn.run_if(is_turning).in_set(EditorSystems::Input))
            .add_systems(
                Update,
                (measure_view, follow_document, answer_requests, glide, place)
                    .chain()
                    .after(EditorSystems::Edit)
                    .before(EditorSystems::Solve),
            );
    }
}

impl Default for OrbitRig {
    fn default() -> Self {
        Self {
            camera: usual_camera(),
            view_px: [1.0, 1.0],
            glide: None,
            known: None,
            generation: None,
        }
    }
}

impl Gesture {
    pub fn is_on(&self) -> bool {
        self.0.is_some()
    }
}

impl OrbitRig {
    /// Whether it is on its way to where it was sent.
    pub fn is_gliding(&self) -> bool {
        self.glide.is_some()
    }

    /// Where it is, or will be once it is there.
    pub fn destination(&self) -> OrbitCamera {
        self.glide.as_ref().map_or(self.camera, |glide| glide.to)
    }

    /// Glides back to where it was, which is no change of the document's view.
    pub fn return_to(&mut self, camera: OrbitCamera) {
        start_glide(self, camera);
        self.known = Some(camera.into());
    }

    pub fn eye(&self) -> Eye {
        Eye { camera: self.camera, view_px: self.view_px }
    }

    /// Millimetres a pixel spans at a point; of the focus for what is behind the camera.
    pub fn mm_per_px(&self, point_mm: &Point3<f64>) -> f64 {
        self.eye().mm_per_px(point_mm)
    }
}

fn spawn(mut commands: Commands, target: Option<Res<SceneTarget>>) {
    let mut camera = commands.spawn((
        Name::new("3D camera"),
        MainCamera,
        Camera3d::default(),
        Camera { clear_color: ClearColorConfig::Custom(palette::BACKGROUND.color()), ..default() },
        Projection::Perspective(PerspectiveProjection {
            fov: convert::length(VERTICAL_FOV_RAD),
            near: 5.0,
            far: 20_000.0,
            ..default()
        }),
        // Maps have to keep the colours of their colour bar.
        Tonemapping::None,
        DebandDither::Disabled,
        Msaa::Sample4,
    ));
    if let Some(target) = target {
        camera.insert(target.0.clone());
    }
}

fn clear_in_theme(mut cameras: Query<&mut Camera, With<MainCamera>>) {
    for mut camera in &mut cameras {
        camera.clear_color = ClearColorConfig::Custom(palette::BACKGROUND.color());
    }
}

/// The 3D view as the pointer sees it: the open world through the camera.
#[derive(SystemParam)]
pub struct Sight<'w> {
    pub world: Option<Res<'w, OpenWorld>>,
    shown: Option<Res<'w, ShownDesign>>,
    pub rig: Res<'w, OrbitRig>,
    view: Option<Res<'w, ViewportRect>>,
}

impl Sight<'_> {
    /// The design as it is shown; `None` before there is one.
    pub fn design(&self) -> Option<&Design> {
        self.shown.as_ref().map(|shown| &*shown.design)
    }

    /// From where the 3D view is seen.
    pub fn eye(&self) -> Eye {
        self.rig.eye()
    }

    /// Whether a place in the window is in the 3D view.
    pub fn contains(&self, at: Vec2) -> bool {
        self.view.as_ref().is_some_and(|view| view.contains(at))
    }

    /// A place in the window as pixels of the 3D view.
    pub fn pixel(&self, at: Vec2) -> Option<[f64; 2]> {
        Some(self.view.as_ref()?.pixel(at))
    }

    /// The ray under a place in the window, in the tracker frame.
    pub fn ray(&self, at: Vec2) -> Option<Ray> {
        Some(self.rig.camera.ray(self.pixel(at)?, self.rig.view_px))
    }
}

/// Keeps the camera in the document's view.
#[derive(SystemParam)]
struct ViewKeeper<'w> {
    world: Option<Res<'w, OpenWorld>>,
    shown: Option<Res<'w, ShownDesign>>,
    views: MessageWriter<'w, ViewRequest>,
}

impl ViewKeeper<'_> {
    /// Done at the end of a gesture.
    fn keep(&mut self, rig: &mut OrbitRig) {
        let Some(world) = &self.world else { return };
        let camera = CameraView::from(rig.camera);
        if rig.known != Some(camera) {
            rig.known = Some(camera);
            let mut view = world.0.document.view().clone();
            view.camera = Some(camera);
            self.views.write(ViewRequest::Set(view));
        }
    }
}

/// What decides whether the pointer is the scene's.
#[derive(SystemParam)]
pub struct ScenePointer<'w, 's> {
    window: Option<Single<'w, 's, &'static Window, With<PrimaryWindow>>>,
    view: Option<Res<'w, ViewportRect>>,
    egui: Option<Res<'w, EguiWantsInput>>,
}

impl ScenePointer<'_, '_> {
    /// The pointer in the window, logical pixels.
    pub fn in_window(&self) -> Option<Vec2> {
        self.window.as_ref()?.cursor_position()
    }

    /// The pointer in the window if it is over the 3D view and no panel or popup wants it.
    pub fn over_scene(&self) -> Option<Vec2> {
        let at = self.in_window()?;
        let view = self.view.as_ref()?;
        let is_egui = self.egui.as_ref().is_some_and(|egui| egui.wants_any_pointer_input());
        (view.contains(at) && !is_egui).then_some(at)
    }
}

fn drag_camera(
    buttons: Res<ButtonInput<MouseButton>>,
    keys: Res<ButtonInput<KeyCode>>,
    pointer: ScenePointer,
    active: Res<ActiveDrag>,
    mut gesture: ResMut<Gesture>,
    mut rig: ResMut<OrbitRig>,
    mut keeper: ViewKeeper,
) {
    if gesture.0.is_none() && !active.0 {
        let pressed = [MouseButton::Middle, MouseButton::Right]
            .into_iter()
            .find(|button| buttons.just_pressed(*button));
        if let (Some(button), Some(at)) = (pressed, pointer.over_scene()) {
            gesture.0 = Some((button, at));
        }
    }
    let Some((button, last)) = gesture.0 else {
        return;
    };
    if let Some(at) = pointer.in_window()
        && at != last
    {
        let view_px = rig.view_px;
        let drag_px = convert::pixel(at - last);
        rig.glide = None;
        if keys.any_pressed([KeyCode::ShiftLeft, KeyCode::ShiftRight]) {
            rig.camera.pan(drag_px, view_px);
        } else {
            rig.camera.orbit(drag_px, view_px);
        }
        gesture.0 = Some((button, at));
    }
    if !buttons.pressed(button) {
        gesture.0 = None;
        keeper.keep(&mut rig);
    }
}

fn is_turning(turntable: Res<Turntable>) -> bool {
    turntable.0.is_some()
}

fn turn(
    turntable: Res<Turntable>,
    mut rig: ResMut<OrbitRig>,
    mut redraws: MessageWriter<RequestRedraw>,
) {
    if let Some(way_px) = turntable.0 {
        let view_px = rig.view_px;
        rig.glide = None;
        rig.camera.orbit(way_px, view_px);
        redraws.write(RequestRedraw);
    }
}

fn zoom(
    mut wheel: MessageReader<MouseWheel>,
    pointer: ScenePointer,
    view: Option<Res<ViewportRect>>,
    surfaces: Res<Surfaces>,
    mut rig: ResMut<OrbitRig>,
    mut keeper: ViewKeeper,
) {
    let notches: f32 = wheel
        .read()
        .map(|event| match event.unit {
            MouseScrollUnit::Line => event.y,
            MouseScrollUnit::Pixel => event.y / PIXELS_PER_NOTCH,
        })
        .sum();
    let (Some(at), Some(view)) = (pointer.over_scene(), view) else {
        return;
    };
    if notches != 0.0 {
        let view_px = rig.view_px;
        rig.glide = None;
        // What lies under the pointer stays there, at its own depth.
        if let Some(point) = keeper
            .shown
            .as_ref()
            .and_then(|s| surfaces.under(&s.design, &rig.camera.ray(view.pixel(at), view_px)))
        {
            rig.camera.refocus(&point);
        }
        rig.camera.zoom(f64::from(notches), view.pixel(at), view_px);
        keeper.keep(&mut rig);
    }
}

fn measure_view(view: Option<Res<ViewportRect>>, mut rig: ResMut<OrbitRig>) {
    let Some(view) = view else { return };
    let view_px = convert::pixel(view.size.max(Vec2::ONE));
    if rig.view_px != view_px {
        rig.view_px = view_px;
    }
}

/// Looks where the document's view is, when another is opened or its view changes elsewhere.
fn follow_document(
    world: Option<Res<OpenWorld>>,
    generation: Option<Res<WorldGeneration>>,
    presentation: Res<Presentation>,
    mut rig: ResMut<OrbitRig>,
) {
    // Before the panels have set the view's size nothing can be framed.
    let Some(world) = world.filter(|_| rig.view_px[1] > 1.0) else {
        return;
    };
    let generation = generation.map(|g| *g);
    let is_other_world = rig.generation.is_none() || rig.generation != generation;
    let wanted = world.0.document.view().camera;
    if !is_other_world && (wanted == rig.known || wanted.is_none()) {
        return;
    }
    let to = wanted.map_or_else(|| first_camera(&world.0, rig.view_px), Into::into);
    rig.generation = generation.or(Some(WorldGeneration::default()));
    rig.known = wanted;
    if is_other_world || !presentation.window {
        rig.camera = to;
        rig.glide = None;
    } else {
        start_glide(&mut rig, to);
    }
}

fn answer_requests(
    mut requests: MessageReader<ViewRequest>,
    world: Option<Res<OpenWorld>>,
    shown: Option<Res<ShownDesign>>,
    selection: Res<Selection>,
    mut rig: ResMut<OrbitRig>,
) {
    for request in requests.read() {
        let mut to = rig.destination();
        match request {
            ViewRequest::Set(_) => continue,
            ViewRequest::FrameSelection => {
                let Some(sphere) = world
                    .as_ref()
                    .zip(shown.as_ref())
                    .and_then(|(w, s)| extent::of_selection(&w.0, &s.design, &selection))
                else {
                    continue;
                };
                to.frame_sphere(sphere.center_mm, sphere.radius_mm, rig.view_px);
            }
            ViewRequest::LookAlong(axis) => to.look_along(*axis),
        }
        start_glide(&mut rig, to);
    }
}

fn start_glide(rig: &mut OrbitRig, to: OrbitCamera) {
    rig.glide = Some(Glide { from: rig.camera, to, elapsed: Duration::ZERO });
}

fn glide(
    time: Res<Time>,
    mut rig: ResMut<OrbitRig>,
    mut keeper: ViewKeeper,
    mut redraws: MessageWriter<RequestRedraw>,
) {
    let Some(mut glide) = rig.glide.clone() else {
        return;
    };
    // After a sleep the first step would be seconds long.
    glide.elapsed += time.delta().min(Duration::from_millis(40));
    let fraction = glide.elapsed.as_secs_f64() / GLIDE.as_secs_f64();
    redraws.write(RequestRedraw);
    if fraction < 1.0 {
        rig.camera = glide.from.towards(&glide.to, smooth(fraction));
        rig.glide = Some(glide);
    } else {
        rig.camera = glide.to;
        rig.glide = None;
        keeper.keep(&mut rig);
    }
}

/// Slow at both ends.
fn smooth(fraction: f64) -> f64 {
    fraction * fraction * (3.0 - 2.0 * fraction)
}

fn place(
    rig: Res<OrbitRig>,
    view: Option<Res<ViewportRect>>,
    window: Option<Single<&Window, With<PrimaryWindow>>>,
    camera: Option<Single<(&mut Transform, &mut Camera), With<MainCamera>>>,
) {
    let (Some(view), Some(camera)) = (view, camera) else {
        return;
    };
    let (mut transform, mut camera) = camera.into_inner();
    if rig.is_changed() {
        transform.set_if_neq(convert::camera_transform(&rig.camera));
    }
    let scale = window.as_ref().map_or(1.0, |w| w.scale_factor());
    let most = window.as_ref().map(|w| w.physical_size());
    let viewport = physical_viewport(&view, scale, most);
    let has_changed = match (&camera.viewport, &viewport) {
        (Some(a), Some(b)) => {
            a.physical_position != b.physical_position || a.physical_size != b.physical_size
        }
        (None, None) => false,
        _ => true,
    };
    if has_changed {
        camera.viewport = viewport;
    }
}

/// The view's rectangle in physical pixels, within the window; `None` where nothing is left.
fn physical_viewport(view: &ViewportRect, scale: f32, most: Option<UVec2>) -> Option<Viewport> {
    let min = (view.min * scale).round().max(Vec2::ZERO).as_uvec2();
    let mut max = ((view.min + view.size) * scale).round().max(Vec2::ZERO).as_uvec2();
    if let Some(most) = most {
        max = max.min(most);
    }
    let size = max.saturating_sub(min);
    (size.x > 0 && size.y > 0).then(|| Viewport {
        physical_position: min,
        physical_size: size,
        ..default()
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_viewport_is_clipped_to_the_window() {
        let view = ViewportRect { min: Vec2::new(240.0, 36.0), size: Vec2::new(900.0, 700.0) };
        let inside = physical_viewport(&view, 2.0, Some(UVec2::new(2000, 3000))).unwrap();
        assert_eq!(inside.physical_position, UVec2::new(480, 72));
        assert_eq!(inside.physical_size, UVec2::new(1520, 1400));
        assert!(physical_viewport(&view, 1.0, Some(UVec2::new(200, 30))).is_none());
    }
}
