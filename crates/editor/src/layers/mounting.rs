//! Mounting regions: patches, channels and seats where sensors may be, forbidden boxes and the tip's
//! clearance where no coil may be.
//!
//! Drawn of every body while the layer is on, and of the body whose regions are edited; else nothing
//! is made. What is drawn is the scene's ([`trackwright_scene::mounting`]).

use crate::document::requests::OpenWorld;
use crate::document::shown::ShownDesign;
use crate::layers::legend::{Legend, LegendKey, Legends, Swatch};
use crate::layers::registry::{AddLayer, LayerInfo};
use crate::palette::{Theme, ThemedColor};
use crate::scene::materials::glow::{GlowMaterial, Shown};
use crate::schedule::EditorSystems;
use crate::viewport::mounting::channel::ChannelDraft;
use crate::viewport::mounting::state::EditedBody;
use crate::{convert, palette};
use bevy::ecs::system::SystemParam;
use bevy::prelude::*;
use nalgebra::Point3;
use std::sync::Arc;
use trackwright_design::BodyRole;
use trackwright_geometry::mesh::SurfaceMesh;
use trackwright_scene::mounting::{
    FORBIDDEN_WORDS, MOUNTING_WORDS, MountingPart, MountingShape, forbids, mounting_shapes,
};
use trackwright_simulation::{Mounting, MountingRegion};

/// The layer.
pub const LAYER: LayerInfo = LayerInfo::new("Mounting regions", 125, |layers| &mut layers.mounting);

/// What it shows.
const ABOUT: &str = "Where sensors may be mounted on the bodies, and where no coil may be: boxes and the tip's clearance";

/// Later than the bodies' own translucent parts, before handles.
const ORDER_MM: f32 = 60.0;

/// Draws the regions while their layer is on or while they are edited.
pub struct MountingLayerPlugin;

/// How many bodies' regions were made into shapes so far.
#[derive(Resource, Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct MountingDrawings(pub u64);

/// What is drawn of a body, at its pose.
#[derive(Component)]
#[require(Transform, Visibility)]
struct Drawn {
    role: BodyRole,
    of: Of,
}

/// What it was made of.
#[derive(Clone, PartialEq)]
struct Of {
    mounting: Mounting,
    tip_in_body: Point3<f64>,
    /// The points of a channel that is being drawn.
    draft_mm: Vec<Point3<f64>>,
    theme: Theme,
    mesh: Option<SharedMesh>,
}

/// Two are the same where they are one.
#[derive(Clone)]
struct SharedMesh(Arc<SurfaceMesh>);

impl PartialEq for SharedMesh {
    fn eq(&self, other: &Self) -> bool {
        Arc::ptr_eq(&self.0, &other.0)
    }
}

impl Plugin for MountingLayerPlugin {
    fn build(&self, app: &mut App) {
        app.init_resource::<MountingDrawings>()
            .add_layer(LAYER, ABOUT)
            .add_systems(Update, draw.run_if(is_due).in_set(EditorSystems::Draw));
    }
}

/// What decides whether regions are drawn, and of what.
#[derive(SystemParam)]
struct State<'w> {
    world: Option<Res<'w, OpenWorld>>,
    shown: Option<Res<'w, ShownDesign>>,
    edited: EditedBody<'w>,
    draft: Option<Res<'w, ChannelDraft>>,
    theme: Res<'w, Theme>,
}

impl State<'_> {
    /// `None` of a body whose regions are not drawn.
    fn wanted(&self, role: BodyRole) -> Option<Of> {
        let world = &self.world.as_ref()?.0;
        let view = world.document.view();
        let is_edited = self.edited.get() == Some(role);
        let is_shown = is_edited || LAYER.is_on(view.layers);
        if !is_shown || view.hidden.has_body(role) {
            return None;
        }
        let body = world.document.design().body(role)?;
        let draft = self.draft.as_ref().filter(|_| is_edited);
        Some(Of {
            mounting: body.mounting.clone(),
            tip_in_body: body.rigid.judged_tip_in_body(),
            draft_mm: draft.map_or_else(Vec::new, |draft| draft.points_mm.clone()),
            theme: *self.theme,
            mesh: world.mesh(role).map(|mesh| SharedMesh(Arc::clone(mesh))),
        })
    }

    fn place(&self, role: BodyRole) -> Option<Transform> {
        let design = &self.shown.as_ref()?.design;
        Some(convert::transform(&design.tracker_from_body(role)?))
    }
}

fn is_due(state: State) -> bool {
    state.world.as_ref().is_some_and(|world| world.is_changed())
        || state.shown.as_ref().is_some_and(|shown| shown.is_changed())
        || state.draft.as_ref().is_some_and(|draft| draft.is_changed())
        || state.edited.is_changed()
        || state.theme.is_changed()
}

fn draw(
    state: State,
    mut drawn: Query<(Entity, &Drawn, &mut Transform)>,
    mut shapes: Shapes,
    mut legends: ResMut<Legends>,
) {
    let wanted = BodyRole::ALL.map(|role| Some((role, state.place(role)?, state.wanted(role)?)));
    let mut wanted: Vec<(BodyRole, Transform, Of)> = wanted.into_iter().flatten().collect();
    if wanted.is_empty() && drawn.is_empty() {
        return;
    }
    let own = wanted.iter().map(|(_, _, of)| of);
    legends.set(LAYER.order, Legend { keys: keys(own), ..Legend::default() });
    for (entity, old, mut transform) in &mut drawn {
        let same = |(role, _, of): &(BodyRole, Transform, Of)| *role == old.role && *of == old.of;
        match wanted.iter().position(same) {
            Some(index) => {
                transform.set_if_neq(wanted.swap_remove(index).1);
            }
            None => shapes.commands.entity(entity).despawn(),
        }
    }
    for (role, place, of) in wanted {
        shapes.spawn(role, place, of);
    }
}

/// Of what is drawn.
fn keys<'o>(drawn: impl Iterator<Item = &'o Of> + Clone) -> Vec<LegendKey> {
    let key = |color, words: &str| LegendKey::new(Swatch::Surface(color), words);
    let allowed = drawn.clone().next().map(|_| key(palette::MOUNTING, MOUNTING_WORDS));
    let has_forbidden = drawn.clone().any(|of| forbids(&of.mounting));
    let forbidden = has_forbidden.then(|| key(palette::FORBIDDEN, FORBIDDEN_WORDS));
    allowed.into_iter().chain(forbidden).collect()
}

/// Makes entities of shapes.
#[derive(SystemParam)]
struct Shapes<'w, 's> {
    commands: Commands<'w, 's>,
    meshes: ResMut<'w, Assets<Mesh>>,
    materials: ResMut<'w, Assets<GlowMaterial>>,
    gizmos: ResMut<'w, Assets<GizmoAsset>>,
    count: ResMut<'w, MountingDrawings>,
}

impl Shapes<'_, '_> {
    fn spawn(&mut self, role: BodyRole, place: Transform, of: Of) {
        self.count.0 += 1;
        let mesh = of.mesh.as_ref().map(|mesh| &*mesh.0);
        let mut shapes = mounting_shapes(&of.mounting, mesh, &of.tip_in_body);
        shapes.extend(draft_shapes(&of.draft_mm));
        let root = (Name::new("mounting regions"), place, Drawn { role, of });
        let root = self.commands.spawn(root).id();
        for shape in shapes {
            self.spawn_shape(root, &shape);
        }
    }

    fn spawn_shape(&mut self, root: Entity, shape: &MountingShape) {
        let (solid, part) = (&shape.solid, shape.part);
        if !solid.triangles.is_empty() {
            let mesh =
                convert::triangle_mesh(&solid.positions_mm, &solid.normals, &solid.triangles);
            self.commands.spawn((
                ChildOf(root),
                Name::new(part.name()),
                Mesh3d(self.meshes.add(mesh)),
                MeshMaterial3d(self.materials.add(material(shape))),
            ));
        }
        if !shape.lines.is_empty() {
            let mut lines = GizmoAsset::default();
            for line in &shape.lines {
                lines.linestrip(line.iter().map(convert::point), part.color().color());
            }
            self.commands.spawn((
                ChildOf(root),
                Name::new("lines of mounting regions"),
                Gizmo {
                    handle: self.gizmos.add(lines),
                    line_config: GizmoLineConfig { width: 1.5, ..default() },
                    // Seen through the body that they run in.
                    depth_bias: -1.0,
                },
            ));
        }
    }
}

/// What is clicked so far: the channel, and a seat for each point.
fn draft_shapes(points_mm: &[Point3<f64>]) -> Vec<MountingShape> {
    let seats = points_mm.iter().map(|at| MountingRegion::Seat { position_mm: *at, axis: None });
    let regions: Vec<_> = seats.chain(MountingRegion::channel(points_mm)).collect();
    if regions.is_empty() {
        return Vec::new();
    }
    mounting_shapes(&Mounting { regions, ..Mounting::default() }, None, &Point3::origin())
}

fn material(shape: &MountingShape) -> GlowMaterial {
    let alpha = shape.alpha as f32;
    let material = GlowMaterial::translucent(shape.part.color(), alpha, alpha).order(ORDER_MM);
    match shape.part {
        // They are inside the body.
        MountingPart::Channel | MountingPart::Seat => material.shown(Shown::Always),
        MountingPart::ForbiddenBox | MountingPart::TipClearance => material.both_faces(),
        MountingPart::Patch => material,
    }
}
