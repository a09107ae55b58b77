//! Balls on the faces of boxes of the body whose mounting regions are edited: each is dragged along
//! its face's normal.
//!
//! Where a face goes is the core's ([`trackwright_geometry::box_face`]), and which boxes have balls is
//! the body's ([`trackwright_simulation::Mounting::boxes_to_drag`]).

use crate::document::requests::OpenWorld;
use crate::document::selection::Selection;
use crate::document::shown::ShownDesign;
use crate::palette::{self, Rgb};
use crate::schedule::EditorSystems;
use crate::shell::window::Presentation;
use crate::viewport::ball_handle::{BallHandle, Balls, SMALL_PX};
use crate::viewport::camera::Sight;
use crate::viewport::fine_pointer::DragKeys;
use crate::viewport::mounting::drag::size_text;
use crate::viewport::mounting::state::EditedBody;
use crate::viewport::scene_drag::{self, SceneDrag};
use crate::viewport::tool::SceneTool;
use crate::widgets::basic::{decimal, with_unit};
use bevy::ecs::system::SystemParam;
use bevy::prelude::*;
use trackwright_design::{BodyRole, Edit};
use trackwright_geometry::bounds::Bounds;
use trackwright_geometry::box_face::{BoxFace, HeldFace};
use trackwright_geometry::pose::Pose;
use trackwright_simulation::Mounting;
use trackwright_simulation::mounting::BoxPlace;

/// With Ctrl faces are at whole multiples of this.
const ROUND_MM: f64 = 1.0;

/// The ball of one face.
#[derive(Component, Clone, Copy, Debug, PartialEq)]
pub struct BoxBall {
    pub body: BodyRole,
    pub place: BoxPlace,
    pub face: BoxFace,
}

/// A face that is held, of a box in the mounting as it was.
pub struct HeldBox {
    ball: BoxBall,
    face: HeldFace,
    body_from_tracker: Pose,
    mounting: Mounting,
}

/// What a drag reads.
#[derive(SystemParam)]
pub struct Grip<'w> {
    sight: Sight<'w>,
    keys: DragKeys<'w>,
}

pub(super) fn plugin(app: &mut App) {
    app.add_plugins(scene_drag::plugin::<BoxBall>)
        .add_systems(Update, place_balls.run_if(is_due).in_set(EditorSystems::Draw));
}

/// What decides where there are balls.
#[derive(SystemParam)]
struct Faces<'w> {
    world: Option<Res<'w, OpenWorld>>,
    shown: Option<Res<'w, ShownDesign>>,
    edited: EditedBody<'w>,
    tool: Res<'w, SceneTool>,
    presentation: Res<'w, Presentation>,
}

impl Faces<'_> {
    fn balls(&self) -> Option<Vec<(BoxBall, BallHandle, String)>> {
        let body = self.edited.get()?;
        let view = self.world.as_ref()?.0.document.view();
        let shown = self.shown.as_ref()?;
        // A trial has the body elsewhere, and a picture for a page has no handles.
        let is_free = *self.tool == SceneTool::Select
            && self.presentation.panels
            && shown.trial.is_none()
            && ![&view.hidden, &view.locked].iter().any(|own| own.has_body(body));
        if !is_free {
            return None;
        }
        let tracker_from_body = shown.design.tracker_from_body(body)?;
        let boxes = shown.design.body(body)?.mounting.boxes_to_drag();
        let balls = boxes.flat_map(|(place, own)| {
            BoxFace::all().map(move |face| {
                let at_mm = tracker_from_body * face.middle_mm(own);
                let ball = BoxBall { body, place, face };
                (ball, BallHandle { at_mm, radius_px: SMALL_PX }, words(&ball))
            })
        });
        Some(balls.collect())
    }
}

fn is_due(faces: Faces) -> bool {
    faces.world.is_none_or(|world| world.is_changed())
        || faces.shown.is_none_or(|shown| shown.is_changed())
        || faces.edited.is_changed()
        || faces.tool.is_changed()
        || faces.presentation.is_changed()
}

fn place_balls(faces: Faces, mut balls: Balls<BoxBall>) {
    let wanted = faces.balls().unwrap_or_default();
    balls.place("box handle", color, wanted, |a, b| a == b);
}

fn color(ball: &BoxBall) -> Rgb {
    match ball.place {
        BoxPlace::KeepOut { .. } => palette::FORBIDDEN,
        BoxPlace::Surface { .. } | BoxPlace::CrfPatch { .. } => palette::MOUNTING,
    }
}

impl SceneDrag for BoxBall {
    type Held = HeldBox;
    type Grip = Grip<'static>;

    fn take(&self, grip: &Grip, _: &Selection, at: Vec2) -> Option<HeldBox> {
        let design = grip.sight.design()?;
        let mounting = design.body(self.body)?.mounting.clone();
        let body_from_tracker = design.tracker_from_body(self.body)?.inverse();
        let ray = grip.sight.ray(at)?.transformed_by(&body_from_tracker);
        let face = self.face.take(mounting.stated_box(self.place)?, &ray)?;
        Some(HeldBox { ball: *self, face, body_from_tracker, mounting })
    }

    fn label(held: &HeldBox) -> String {
        format!("Resize {} of the {}", name(held.ball.place), held.ball.body)
    }

    fn edit(held: &mut HeldBox, grip: &Grip, at: Vec2) -> Option<(Edit, String)> {
        let ray = grip.sight.ray(at)?.transformed_by(&held.body_from_tracker);
        let round_to_mm = grip.keys.is_snapping().then_some(ROUND_MM);
        let resized = held.face.bounds_at(&ray, round_to_mm)?;
        let mut mounting = held.mounting.clone();
        *mounting.stated_box_mut(held.ball.place)? = resized;
        let text = readout_text(held.ball.face, &resized);
        Some((Edit::SetMounting { body: held.ball.body, mounting: Box::new(mounting) }, text))
    }
}

fn name(place: BoxPlace) -> &'static str {
    match place {
        BoxPlace::KeepOut { .. } => "forbidden box",
        BoxPlace::Surface { .. } | BoxPlace::CrfPatch { .. } => "box of a mounting patch",
    }
}

fn axis_name(face: BoxFace) -> &'static str {
    ["x", "y", "z"][face.axis]
}

/// What dragging a ball does.
fn words(ball: &BoxBall) -> String {
    let (name, axis) = (name(ball.place), axis_name(ball.face));
    let end = if ball.face.is_max { "ends" } else { "begins" };
    format!(
        "Drag to set where the {name} {end} along {axis} of the {} · Ctrl rounds to \
         {ROUND_MM:.0}\u{2009}mm · Shift moves finely · Esc takes it back",
        ball.body
    )
}

/// `x to 12.5 mm   25.0 × 10.0 × 10.0 mm`.
fn readout_text(face: BoxFace, resized: &Bounds) -> String {
    let value = with_unit(&decimal(face.value_mm(resized), 1), "mm");
    let end = if face.is_max { "to" } else { "from" };
    format!("{} {end} {value}   {}", axis_name(face), size_text(resized))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_face_readout_names_axis_end_and_size() {
        let own = Bounds::from(([-2.5, 0.0, 10.0], [10.0, 4.0, 30.0]));
        let text = |axis, is_max| readout_text(BoxFace { axis, is_max }, &own);
        let size = "12.5 × 4.0 × 20.0\u{2009}mm";
        assert_eq!(text(0, false), format!("x from \u{2212}2.5\u{2009}mm   {size}"));
        assert_eq!(text(2, true), format!("z to 30.0\u{2009}mm   {size}"));
    }
}
