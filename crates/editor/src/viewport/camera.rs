//! The 3D camera: requests into an orbit, the orbit into the document's view and the entity.
//!
//! What the mouse and a trackpad do to it is in a file of its own.

use crate::document::requests::{OpenWorld, ViewRequest};
use crate::document::selection::Selection;
use crate::document::shown::ShownDesign;
use crate::document::state::WorldGeneration;
use crate::palette::Theme;
use crate::palette::ThemedColor;
use crate::scene::extent;
use crate::schedule::EditorSystems;
use crate::shell::requests::Requests;
use crate::shell::window::{Presentation, ViewportRect};
use crate::{convert, palette};
use bevy::camera::{
    ClearColorConfig, OrthographicProjection, PerspectiveProjection, RenderTarget, ScalingMode,
    Viewport,
};
use bevy::core_pipeline::tonemapping::{DebandDither, Tonemapping};
use bevy::ecs::system::SystemParam;
use bevy::prelude::*;
use bevy::window::{PrimaryWindow, RequestRedraw};
use bevy_egui::input::EguiWantsInput;
use nalgebra::Point3;
use std::time::Duration;
use trackwright_design::view::CameraView;
use trackwright_design::{BodyRole, Design};
use trackwright_geometry::gizmo::Eye;
use trackwright_geometry::mesh_reference::MeshReference;
use trackwright_geometry::orbit::{self, OrbitCamera, VERTICAL_FOV_RAD};
use trackwright_geometry::pose::Pose;
use trackwright_geometry::surface::{Ray, Surface, SurfacePoint};
pub use trackwright_scene::opening_view::opening_camera;
use trackwright_scene::opening_view::{first_camera, usual_camera};

/// How long the camera glides to where it was sent.
const GLIDE: Duration = Duration::from_millis(250);

/// Nearest and farthest that is drawn, in millimetres from the eye.
const DEPTH_MM: [f32; 2] = [5.0, 20_000.0];

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

impl Plugin for CameraPlugin {
    fn build(&self, app: &mut App) {
        app.init_resource::<OrbitRig>()
            .add_systems(PreStartup, spawn)
            .add_systems(Update, clear_in_theme.run_if(resource_changed::<Theme>))
            .add_systems(
                Update,
                show_added
                    .run_if(resource_exists_and_changed::<ShownDesign>)
                    .run_if(resource_exists::<WorldGeneration>)
                    .in_set(EditorSystems::Draw),
            )
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

    /// Is where it was sent, which becomes the document's view.
    fn arrive(&mut self) {
        let (from, to) = (self.camera, self.camera);
        self.glide = Some(Glide { from, to, elapsed: GLIDE });
    }

    /// Moves by hand: what it glided to no longer counts.
    pub fn by_hand(&mut self, change: impl FnOnce(&mut OrbitCamera, [f64; 2])) {
        self.glide = None;
        change(&mut self.camera, self.view_px);
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
        projection(&usual_camera()),
        // Maps have to keep the colours of their colour bar.
        Tonemapping::None,
        DebandDither::Disabled,
        Msaa::Sample4,
    ));
    if let Some(target) = target {
        camera.insert(target.0.clone());
    }
}

/// How the renderer projects what the camera sees.
fn projection(camera: &OrbitCamera) -> Projection {
    let [near, far] = DEPTH_MM;
    match camera.projection {
        orbit::Projection::Perspective => Projection::Perspective(PerspectiveProjection {
            fov: convert::length(VERTICAL_FOV_RAD),
            near,
            far,
            ..default()
        }),
        orbit::Projection::Orthographic => {
            let viewport_height = convert::length(camera.view_height_mm());
            Projection::Orthographic(OrthographicProjection {
                near,
                far,
                scaling_mode: ScalingMode::FixedVertical { viewport_height },
                ..OrthographicProjection::default_3d()
            })
        }
    }
}

/// Whether two projections are of one kind and scale.
fn is_same_projection(a: &Projection, b: &Projection) -> bool {
    let height = |projection: &Projection| match projection {
        Projection::Orthographic(orthographic) => match orthographic.scaling_mode {
            ScalingMode::FixedVertical { viewport_height } => Some(viewport_height),
            _ => None,
        },
        _ => None,
    };
    height(a) == height(b)
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

    /// The nearest point of a body's surface under a place in the window, in the body's frame.
    pub fn hit(
        &self,
        surface: &Surface,
        tracker_from_body: &Pose,
        at: Vec2,
    ) -> Option<SurfacePoint> {
        surface.cast(&self.ray(at)?.transformed_by(&tracker_from_body.inverse()))
    }
}

/// Keeps the camera in the document's view.
#[derive(SystemParam)]
pub(crate) struct ViewKeeper<'w> {
    world: Option<Res<'w, OpenWorld>>,
    views: MessageWriter<'w, ViewRequest>,
}

impl ViewKeeper<'_> {
    /// Done at the end of a gesture.
    pub fn keep(&mut self, rig: &mut OrbitRig) {
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
            ViewRequest::FrameSelection | ViewRequest::FrameAll => {
                let shown = world.as_ref().zip(shown.as_ref());
                let sphere = shown.and_then(|(world, shown)| match request {
                    ViewRequest::FrameAll => extent::of_everything(&world.0, &shown.design),
                    _ => extent::of_selection(&world.0, &shown.design, &selection),
                });
                let Some(sphere) = sphere else { continue };
                to.frame_sphere(sphere.center_mm, sphere.radius_mm, rig.view_px);
            }
            ViewRequest::LookFrom(end) => to.look_from(*end),
            ViewRequest::SwitchProjection => to.projection = to.projection.other(),
            ViewRequest::Orbit(drag_px) => {
                rig.by_hand(|camera, view_px| camera.orbit(*drag_px, view_px));
                continue;
            }
            // It is there already: the view is kept.
            ViewRequest::EndOrbit => {
                rig.arrive();
                continue;
            }
        }
        start_glide(&mut rig, to);
    }
}

/// What of a design may come from elsewhere than what is looked at.
#[derive(Clone, Debug, PartialEq)]
struct Things {
    generation: WorldGeneration,
    count: usize,
    meshes: [Option<MeshReference>; 2],
}

/// What is added comes into view: the camera goes back until all is seen, where it is not.
fn show_added(
    (world, shown): (Res<OpenWorld>, Res<ShownDesign>),
    generation: Res<WorldGeneration>,
    selection: Res<Selection>,
    mut known: Local<Option<Things>>,
    mut requests: Requests<ViewRequest>,
    rig: Res<OrbitRig>,
) {
    let design = &shown.design;
    let metal = design.room_metal.as_ref().map_or(0, |metal| metal.objects.len());
    let now = Things {
        generation: *generation,
        count: design.bodies().count() + design.anatomy.len() + metal,
        meshes: BodyRole::ALL.map(|role| design.body(role).and_then(|body| body.mesh.clone())),
    };
    let before = known.replace(now);
    let is_more = before.zip(known.as_ref()).is_some_and(|(before, now)| {
        let is_same = before.generation == now.generation;
        is_same && (before.count < now.count || before.meshes != now.meshes)
    });
    if !is_more || rig.view_px[1] <= 1.0 {
        return;
    }
    let sphere = extent::of_selection(&world.0, design, &selection);
    let camera = rig.destination();
    if !sphere.is_none_or(|sphere| sphere.is_seen_by(&camera, rig.view_px)) {
        requests.write(ViewRequest::FrameAll);
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

/// From where, into which part of the window, and how the scene is seen.
type ViewedFrom<'a> = (&'a mut Transform, &'a mut Camera, &'a mut Projection);

fn place(
    rig: Res<OrbitRig>,
    view: Option<Res<ViewportRect>>,
    window: Option<Single<&Window, With<PrimaryWindow>>>,
    camera: Option<Single<ViewedFrom, With<MainCamera>>>,
) {
    let (Some(view), Some(camera)) = (view, camera) else {
        return;
    };
    let (mut transform, mut camera, mut own) = camera.into_inner();
    if rig.is_changed() {
        transform.set_if_neq(convert::camera_transform(&rig.camera));
        let wanted = projection(&rig.camera);
        if !is_same_projection(&own, &wanted) {
            *own = wanted;
        }
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
