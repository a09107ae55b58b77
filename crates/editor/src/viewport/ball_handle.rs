//! Balls in the scene that a person takes hold of: how they look, are picked and hovered.
//!
//! What a ball does when it is dragged is up to whoever spawned it.

use crate::convert;
use crate::document::requests::ActiveDrag;
use crate::palette::Rgb;
use crate::scene::materials::glow::{GlowMaterial, Shown};
use crate::scene::screen_size::{ScreenSized, SizeBounds};
use crate::scene::shapes::GlyphShapes;
use crate::schedule::EditorSystems;
use bevy::ecs::component::Mutable;
use bevy::ecs::system::SystemParam;
use bevy::picking::events::{Out, Over, Pointer};
use bevy::prelude::*;
use bevy::window::RequestRedraw;
use bevy_egui::{EguiContexts, EguiPrimaryContextPass, egui};
use nalgebra::Point3;

/// Inside this radius on the screen the pointer takes hold of a ball.
pub const HANDLE_PX: f64 = 9.0;

/// Radius of a ball that stands alone on the screen; it grows to [`HANDLE_PX`] under the pointer.
pub const LARGE_PX: f64 = 6.75;

/// Radius of one among many, so that they hide nothing.
pub const SMALL_PX: f64 = 4.0;

/// Later than all else that is translucent but sensors.
const ORDER_MM: f32 = 18_000.0;

const ALPHA: f32 = 0.9;

/// Keeps balls where they are and as large as they should be, and shows a hand over them.
pub struct HandlePlugin;

/// A ball of one size on the screen, at a place of the tracker frame.
#[derive(Component, Clone, Copy, Debug, PartialEq)]
#[require(Transform, Visibility)]
pub struct BallHandle {
    pub at_mm: Point3<f64>,
    pub radius_px: f64,
}

/// What dragging a ball does, for the status line.
#[derive(Component, Clone, Debug, PartialEq, Eq)]
pub struct BallWords(pub String);

/// The ball under the pointer.
#[derive(Resource, Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct HoveredBall(pub Option<Entity>);

impl Plugin for HandlePlugin {
    fn build(&self, app: &mut App) {
        app.init_resource::<HoveredBall>()
            .add_observer(on_over)
            .add_observer(on_out)
            .add_systems(Update, follow.after(EditorSystems::Draw))
            .add_systems(EguiPrimaryContextPass, show_cursor);
    }
}

/// The balls of one kind, each with what it is the ball of.
#[derive(SystemParam)]
pub struct Balls<'w, 's, B: Component<Mutability = Mutable> + PartialEq> {
    commands: Commands<'w, 's>,
    drawn: Query<'w, 's, (Entity, &'static mut B, &'static mut BallHandle, &'static mut BallWords)>,
    shapes: Option<Res<'w, GlyphShapes>>,
    materials: ResMut<'w, Assets<GlowMaterial>>,
}

impl<B: Component<Mutability = Mutable> + PartialEq> Balls<'_, '_, B> {
    /// Spawns, moves and takes away balls, so that there are those that are wanted, each with its
    /// words. One that is still wanted keeps its entity, so that a drag goes on.
    pub fn place(
        &mut self,
        name: &'static str,
        color: impl Fn(&B) -> Rgb,
        wanted: impl IntoIterator<Item = (B, BallHandle, String)>,
        is_same: impl Fn(&B, &B) -> bool,
    ) {
        let mut wanted: Vec<_> = wanted.into_iter().collect();
        for (entity, mut old, mut handle, mut words) in &mut self.drawn {
            let Some(index) = wanted.iter().position(|(new, ..)| is_same(new, &old)) else {
                self.commands.entity(entity).despawn();
                continue;
            };
            let (new, place, text) = wanted.swap_remove(index);
            old.set_if_neq(new);
            handle.set_if_neq(place);
            words.set_if_neq(BallWords(text));
        }
        let Some(shapes) = self.shapes.as_ref().filter(|_| !wanted.is_empty()) else {
            return;
        };
        let mut made: Vec<(Rgb, Handle<GlowMaterial>)> = Vec::new();
        for (ball, place, text) in wanted {
            let color = color(&ball);
            let known = made.iter().find(|(own, _)| *own == color);
            let material = known.map(|(_, material)| material.clone()).unwrap_or_else(|| {
                // They shine through whatever hides them.
                let material = GlowMaterial::translucent(color, ALPHA, ALPHA);
                let material = self.materials.add(material.shown(Shown::Always).order(ORDER_MM));
                made.push((color, material.clone()));
                material
            });
            self.commands.spawn((
                Name::new(name),
                ball,
                place,
                BallWords(text),
                size(&place, false),
                Mesh3d(shapes.sphere.clone()),
                MeshMaterial3d(material),
                Transform::from_translation(convert::point(&place.at_mm)),
            ));
        }
    }
}

fn size(handle: &BallHandle, is_hovered: bool) -> ScreenSized {
    let radius_px = if is_hovered { HANDLE_PX } else { handle.radius_px };
    let radius =
        SizeBounds { true_mm: 0.1, least_px: radius_px, most_px: radius_px, extra_px: 0.0 };
    ScreenSized { at_mm: handle.at_mm, across: radius, along: radius }
}

fn follow(
    hovered: Res<HoveredBall>,
    mut balls: Query<(Entity, Ref<BallHandle>, &mut Transform, &mut ScreenSized)>,
) {
    for (entity, ball, mut transform, mut sized) in &mut balls {
        if !(ball.is_changed() || hovered.is_changed()) {
            continue;
        }
        sized.set_if_neq(size(&ball, hovered.0 == Some(entity)));
        let at = convert::point(&ball.at_mm);
        if transform.translation != at {
            transform.translation = at;
        }
    }
}

fn on_over(
    over: On<Pointer<Over>>,
    balls: Query<(), With<BallHandle>>,
    mut hovered: ResMut<HoveredBall>,
    mut redraws: MessageWriter<RequestRedraw>,
) {
    let entity = over.original_event_target();
    if balls.contains(entity) {
        hovered.set_if_neq(HoveredBall(Some(entity)));
        redraws.write(RequestRedraw);
    }
}

fn on_out(
    out: On<Pointer<Out>>,
    mut hovered: ResMut<HoveredBall>,
    mut redraws: MessageWriter<RequestRedraw>,
) {
    if hovered.0 == Some(out.original_event_target()) {
        hovered.0 = None;
        redraws.write(RequestRedraw);
    }
}

/// A hand over what can be dragged.
fn show_cursor(
    mut contexts: EguiContexts,
    hovered: Res<HoveredBall>,
    balls: Query<(), With<BallHandle>>,
    active: Res<ActiveDrag>,
) -> Result {
    // One that went away while the pointer was over it is no longer there to be left.
    if hovered.0.is_some_and(|entity| balls.contains(entity)) {
        contexts.ctx_mut()?.set_cursor_icon(match active.0 {
            true => egui::CursorIcon::Grabbing,
            false => egui::CursorIcon::Grab,
        });
    }
    Ok(())
}
