//! Mounting regions: patches, channels and seats where sensors may be, forbidden boxes and the tip's
//! clearance where no coil may be.
//!
//! Drawn of every body while the layer is on, and of the body whose regions are edited; else nothing
//! is made. The same holds for the patch of anatomy that the CRF may stand on. What is drawn is the
//! scene's ([`trackwright_scene::mounting`]).

use crate::document::requests::OpenWorld;
use crate::document::shown::ShownDesign;
use crate::layers::legend::{Legend, LegendKey, Legends, Swatch};
use crate::layers::registry::{AddLayer, LayerInfo};
use crate::palette::{Theme, ThemedColor};
use crate::scene::materials::glow::{GlowMaterial, Shown};
use crate::schedule::EditorSystems;
use crate::viewport::mounting::channel::ChannelDraft;
use crate::viewport::mounting::state::{EditedBody, MountingOwner};
use crate::{convert, palette};
use bevy::ecs::system::SystemParam;
use bevy::prelude::*;
use nalgebra::Point3;
use std::sync::Arc;
use trackwright_design::BodyRole;
use trackwright_design::view::Layer;
use trackwright_geometry::bounds::Bounds;
use trackwright_geometry::mesh::SurfaceMesh;
use trackwright_scene::mounting::{
    CRF_PATCH_WORDS, FORBIDDEN_WORDS, MOUNTING_WORDS, MountingPart, MountingShape, crf_patch_shape,
    forbids, mounting_shapes,
};
use trackwright_simulation::{Mounting, MountingRegion};

/// The layer.
pub const LAYER: LayerInfo = LayerInfo::new(&Layer::MOUNTING);

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
    owner: MountingOwner,
    of: Of,
}

/// What it was made of.
#[derive(Clone, PartialEq)]
struct Of {
    mounting: Mounting,
    /// Of anatomy.
    crf_patch: Vec<Bounds>,
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
            .add_layer(LAYER)
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
    /// `None` of what is not drawn.
    fn wanted(&self, owner: MountingOwner) -> Option<Of> {
        match owner {
            MountingOwner::Body(role) => self.wanted_of_body(role),
            MountingOwner::Anatomy(index) => self.wanted_of_anatomy(index),
        }
    }

    fn wanted_of_anatomy(&self, index: usize) -> Option<Of> {
        let world = &self.world.as_ref()?.0;
        let layers = world.document.view().layers;
        let is_edited = self.edited.owner() == Some(MountingOwner::Anatomy(index));
        let anatomy = world.document.design().anatomy.get(index)?;
        let is_shown = is_edited || (LAYER.is_on(layers) && layers.anatomy);
        if !is_shown || anatomy.crf_patch.is_empty() {
            return None;
        }
        Some(Of {
            mounting: Mounting::default(),
            crf_patch: anatomy.crf_patch.clone(),
            tip_in_body: Point3::origin(),
            draft_mm: Vec::new(),
            theme: *self.theme,
            mesh: world.anatomy_mesh(&anatomy.mesh).map(|mesh| SharedMesh(Arc::clone(mesh))),
        })
    }

    fn wanted_of_body(&self, role: BodyRole) -> Option<Of> {
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
            crf_patch: Vec::new(),
            tip_in_body: body.rigid.judged_tip_in_body(),
            draft_mm: draft.map_or_else(Vec::new, |draft| draft.points_mm.clone()),
            theme: *self.theme,
            mesh: world.mesh(role).map(|mesh| SharedMesh(Arc::clone(mesh))),
        })
    }

    fn place(&self, owner: MountingOwner) -> Option<Transform> {
        let design = &self.shown.as_ref()?.design;
        let pose = match owner {
            MountingOwner::Body(role) => design.tracker_from_body(role)?,
            MountingOwner::Anatomy(index) => design.anatomy.get(index)?.tracker_from_mesh(design),
        };
        Some(convert::transform(&pose))
    }

    /// All that may be drawn.
    fn owners(&self) -> impl Iterator<Item = MountingOwner> + use<> {
        let anatomy = self.shown.as_ref().map_or(0, |shown| shown.design.anatomy.len());
        let bodies = BodyRole::ALL.into_iter().map(MountingOwner::Body);
        bodies.chain((0..anatomy).map(MountingOwner::Anatomy))
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
    let wanted =
        state.owners().filter_map(|own| Some((own, state.place(own)?, state.wanted(own)?)));
    let mut wanted: Vec<(MountingOwner, Transform, Of)> = wanted.collect();
    if wanted.is_empty() && drawn.is_empty() {
        return;
    }
    let own = wanted.iter().map(|(owner, _, of)| (*owner, of));
    legends.set(LAYER.row.order, Legend { keys: keys(own), ..Legend::default() });
    for (entity, old, mut transform) in &mut drawn {
        let same =
            |(own, _, of): &(MountingOwner, Transform, Of)| *own == old.owner && *of == old.of;
        match wanted.iter().position(same) {
            Some(index) => {
                transform.set_if_neq(wanted.swap_remove(index).1);
            }
            None => shapes.commands.entity(entity).despawn(),
        }
    }
    for (owner, place, of) in wanted {
        shapes.spawn(owner, place, of);
    }
}

/// Of what is drawn.
fn keys<'o>(drawn: impl Iterator<Item = (MountingOwner, &'o Of)>) -> Vec<LegendKey> {
    let key = |color, words: &str| LegendKey::new(Swatch::Surface(color), words);
    let (bodies, anatomy): (Vec<_>, Vec<_>) = drawn.partition(|(own, _)| own.body().is_some());
    let allowed = (!bodies.is_empty()).then(|| key(palette::MOUNTING, MOUNTING_WORDS));
    let has_forbidden = bodies.iter().any(|(_, of)| forbids(&of.mounting));
    let forbidden = has_forbidden.then(|| key(palette::FORBIDDEN, FORBIDDEN_WORDS));
    let crf = (!anatomy.is_empty()).then(|| key(palette::CRF, CRF_PATCH_WORDS));
    allowed.into_iter().chain(forbidden).chain(crf).collect()
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
    fn spawn(&mut self, owner: MountingOwner, place: Transform, of: Of) {
        self.count.0 += 1;
        let mesh = of.mesh.as_ref().map(|mesh| &*mesh.0);
        let mut shapes = match owner {
            MountingOwner::Body(_) => mounting_shapes(&of.mounting, mesh, &of.tip_in_body),
            MountingOwner::Anatomy(_) => {
                mesh.map(|mesh| crf_patch_shape(&of.crf_patch, mesh)).into_iter().collect()
            }
        };
        shapes.extend(draft_shapes(&of.draft_mm));
        let root = (Name::new("mounting regions"), place, Drawn { owner, of });
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
        MountingPart::Patch | MountingPart::CrfPatch => material,
    }
}
