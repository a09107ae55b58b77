//! What a click of the tool would put there: a coil or a marker on the surface, or a mark for the
//! tip.

use crate::document::shown::ShownDesign;
use crate::scene::materials::glow::{GlowMaterial, Shown};
use crate::scene::screen_size::{ScreenSized, SizeBounds};
use crate::scene::sensors::drawn_size;
use crate::scene::shapes::GlyphShapes;
use crate::schedule::EditorSystems;
use crate::viewport::tool::{SceneTool, ToolAim, new_sensor};
use crate::{convert, palette};
use bevy::prelude::*;
use nalgebra::{Point3, Translation3, UnitQuaternion};
use trackwright_geometry::pose::Pose;

/// Later than the sensors that are there.
const ORDER_MM: f32 = 22_000.0;

/// It is not there yet.
const COIL_ALPHA: [f32; 2] = [0.6, 0.85];

/// The axis through the coil and the mark of the tip, in pixels.
const AXIS_PX: [f64; 2] = [2.0, 64.0];
const TIP_RADIUS_PX: f64 = 5.5;
/// Larger where it snapped to a point of the body.
const SNAPPED_RADIUS_PX: f64 = 8.5;

/// When the preview follows the pointer.
#[derive(SystemSet, Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub(crate) struct PreviewSystems;

/// A part of the preview.
#[derive(Component, Clone, Copy, Debug, PartialEq, Eq)]
enum Part {
    Coil,
    Ball,
    Axis,
    Tip,
}

/// Where a part goes.
struct Placed {
    part: Part,
    tracker_from_part: Pose,
    across: SizeBounds,
    along: SizeBounds,
}

pub(crate) fn plugin(app: &mut App) {
    app.add_systems(
        Update,
        show.run_if(resource_changed::<ToolAim>).in_set(PreviewSystems).in_set(EditorSystems::Draw),
    );
}

fn show(
    mut commands: Commands,
    aim: Res<ToolAim>,
    tool: Res<SceneTool>,
    shown: Option<Res<ShownDesign>>,
    mut drawn: Query<(Entity, &Part, &mut Transform, &mut ScreenSized)>,
    shapes: Res<GlyphShapes>,
    mut materials: ResMut<Assets<GlowMaterial>>,
) {
    let mut wanted = shown.map_or_else(Vec::new, |shown| placed(&aim, *tool, &shown));
    for (entity, part, mut transform, mut size) in &mut drawn {
        let Some(place) = wanted.iter().position(|placed| placed.part == *part) else {
            commands.entity(entity).despawn();
            continue;
        };
        let placed = wanted.swap_remove(place);
        let scale = transform.scale;
        transform.set_if_neq(Transform { scale, ..convert::transform(&placed.tracker_from_part) });
        size.set_if_neq(placed.size());
    }
    for placed in wanted {
        let (mesh, color, [middle, rim]) = match placed.part {
            Part::Coil => (&shapes.coil, palette::SENSOR, COIL_ALPHA),
            Part::Ball => (&shapes.ball, palette::SENSOR, COIL_ALPHA),
            Part::Axis => (&shapes.cylinder, palette::SENSOR_AXIS, COIL_ALPHA),
            Part::Tip => (&shapes.sphere, palette::SELECTED, [0.9, 0.9]),
        };
        let material =
            GlowMaterial::translucent(color, middle, rim).shown(Shown::Always).order(ORDER_MM);
        commands.spawn((
            Name::new("tool preview"),
            placed.part,
            placed.size(),
            Mesh3d(mesh.clone()),
            MeshMaterial3d(materials.add(material)),
            convert::transform(&placed.tracker_from_part),
        ));
    }
}

impl Placed {
    fn size(&self) -> ScreenSized {
        ScreenSized {
            at_mm: Point3::from(self.tracker_from_part.translation.vector),
            across: self.across,
            along: self.along,
        }
    }
}

fn placed(aim: &ToolAim, tool: SceneTool, shown: &ShownDesign) -> Vec<Placed> {
    let Some(Ok(point)) = &aim.0 else {
        return Vec::new();
    };
    let Some(tracker_from_body) = shown.design.tracker_from_body(point.body) else {
        return Vec::new();
    };
    let px =
        |size_px| SizeBounds { true_mm: 0.0, least_px: size_px, most_px: size_px, extra_px: 0.0 };
    match tool {
        SceneTool::AddSensor => {
            let Some(sensor) = new_sensor(&shown.design, point) else {
                return Vec::new();
            };
            let (coil_across, coil_along) = drawn_size(&sensor);
            let tracker_from_part = tracker_from_body * sensor.body_from_sensor();
            let drawn = |part, across, along| Placed { part, tracker_from_part, across, along };
            let [across, along] = AXIS_PX.map(px);
            match sensor.axis_in_body() {
                Some(_) => vec![
                    drawn(Part::Coil, coil_across, coil_along),
                    drawn(Part::Axis, across, along),
                ],
                None => vec![drawn(Part::Ball, coil_across, coil_along)],
            }
        }
        SceneTool::SetTip => {
            let at = tracker_from_body * point.at.position_mm;
            let radius = px(match point.snap {
                Some(_) => SNAPPED_RADIUS_PX,
                None => TIP_RADIUS_PX,
            });
            vec![Placed {
                part: Part::Tip,
                tracker_from_part: Pose::from_parts(
                    Translation3::from(at.coords),
                    UnitQuaternion::identity(),
                ),
                across: radius,
                along: radius,
            }]
        }
        _ => Vec::new(),
    }
}
