//! Layers that are a few shapes, which [`trackwright_scene::shapes`] makes: arrows, ellipsoids, lines.

use crate::convert;
use crate::document::requests::OpenWorld;
use crate::document::shown::ShownDesign;
use crate::layers::legend::{Legend, LegendKey, Legends, StrokeKey, Swatch};
use crate::layers::magnification::{ShownErrors, anything_moved, errors_changed};
use crate::layers::registry::{AddLayer, LayerInfo};
use crate::palette::{Rgb, Theme, ThemedColor};
use crate::scene::materials::glow::GlowMaterial;
use crate::scene::shapes::GlyphShapes;
use crate::schedule::EditorSystems;
use crate::shell::window::Workspace;
use bevy::camera::visibility::NoFrustumCulling;
use bevy::ecs::system::SystemParam;
use bevy::prelude::*;
use nalgebra::Point3;
use trackwright_geometry::solid::Solid;
use trackwright_scene::shapes::{Form, LAYERS, LegendLine, Look, Shape, ShapeLayer, Shown};

/// Arrows that are hidden by something shine through it.
const HIDDEN_ALPHA: f32 = 0.6;

const LINE_WIDTH_PX: f32 = 1.2;

/// Draws these layers and writes their lines of the legend.
pub struct ShapesPlugin;

impl Plugin for ShapesPlugin {
    fn build(&self, app: &mut App) {
        for layer in LAYERS {
            app.add_layer(LayerInfo::new(layer.row));
        }
        app.add_systems(
            Update,
            (
                explain.run_if(errors_changed.or_else(resource_changed::<Workspace>)),
                show.run_if(
                    anything_moved
                        .or_else(resource_changed::<Workspace>)
                        .or_else(resource_changed::<Theme>),
                ),
            )
                .run_if(resource_exists::<OpenWorld>.and_then(resource_exists::<ShownDesign>))
                .in_set(EditorSystems::Draw),
        );
    }
}

/// What shapes are made from.
#[derive(SystemParam)]
struct Source<'w> {
    errors: ShownErrors<'w>,
    workspace: Res<'w, Workspace>,
}

impl Source<'_> {
    fn shown(&self) -> Shown<'_> {
        let document = &self.errors.world.0.document;
        let scatter = self.errors.results.scatter.as_ref();
        Shown {
            design: document.design(),
            shown: &self.errors.shown.design,
            hidden: &document.view().hidden,
            pose: self.errors.pose(),
            scatter: scatter.and_then(|scatter| scatter.as_ref().ok()),
            times: self.errors.times(),
            eye: self.errors.rig.eye(),
            is_live: self.workspace.shows_live,
        }
    }

    fn is_on(&self, layer: &ShapeLayer) -> bool {
        layer.row.is_on(self.errors.layers())
    }
}

fn explain(source: Source, mut legends: ResMut<Legends>) {
    for layer in LAYERS {
        let line = source.is_on(layer).then(|| (layer.legend)(&source.shown())).flatten();
        legends.set(layer.row.order, line.map_or_else(Legend::default, |line| legend(layer, line)));
    }
}

fn legend(layer: &ShapeLayer, line: LegendLine) -> Legend {
    let LegendLine { words, plain_words, is_magnified } = line;
    match is_magnified {
        true => {
            let stroke = StrokeKey { words, plain_words, color: layer.color };
            Legend { stroke: Some(stroke), ..Legend::default() }
        }
        false => {
            let keys = vec![LegendKey::new(Swatch::Line(layer.color), words)];
            Legend { keys, ..Legend::default() }
        }
    }
}

/// An entity of a layer, by the layer's place in lists.
#[derive(Component, Clone, Debug, PartialEq)]
struct Drawn {
    order: u32,
    kind: Kind,
}

/// What an entity shows, as far as it cannot be changed in place.
#[derive(Clone, Debug, PartialEq)]
enum Kind {
    Arrows,
    Ellipsoid,
    Lines { strips: Vec<(Vec<Point3<f64>>, f64)>, theme: Theme },
}

/// A layer's shapes of each kind, as they are drawn.
struct Wanted {
    arrows: Option<Mesh>,
    ellipsoid: Option<(Transform, Look)>,
    lines: Option<Kind>,
}

impl Wanted {
    fn of(shapes: Vec<Shape>, shown: &Shown, theme: Theme) -> Self {
        let mut solid = Solid::default();
        let (mut ellipsoid, mut strips) = (None, Vec::new());
        for shape in shapes {
            match shape.form {
                Form::Arrow(arrow) => arrow.push_to(&mut solid, &shown.eye),
                Form::Ellipsoid { center_mm, turn, half_lengths_mm, look } => {
                    let place = convert::ellipsoid(&center_mm, &turn, &half_lengths_mm);
                    ellipsoid = Some((place, look));
                }
                Form::Lines { strips: own, alpha } => {
                    strips.extend(own.into_iter().map(|strip| (strip, alpha)));
                }
            }
        }
        let arrows = (!solid.triangles.is_empty())
            .then(|| convert::triangle_mesh(&solid.positions_mm, &solid.normals, &solid.triangles));
        let lines = (!strips.is_empty()).then_some(Kind::Lines { strips, theme });
        Self { arrows, ellipsoid, lines }
    }
}

/// What shapes are drawn with.
#[derive(SystemParam)]
struct Assets3d<'w> {
    shapes: Res<'w, GlyphShapes>,
    meshes: ResMut<'w, Assets<Mesh>>,
    materials: ResMut<'w, Assets<GlowMaterial>>,
    gizmos: ResMut<'w, Assets<GizmoAsset>>,
}

type DrawnShapes<'w, 's> = Query<
    'w,
    's,
    (Entity, &'static Drawn, Option<&'static Mesh3d>, Option<&'static mut Transform>),
>;

fn show(
    mut commands: Commands,
    source: Source,
    theme: Res<Theme>,
    mut drawn: DrawnShapes,
    mut assets: Assets3d,
) {
    let shown = source.shown();
    for layer in LAYERS {
        let shapes = match source.is_on(layer) {
            true => (layer.shapes)(&shown),
            false => Vec::new(),
        };
        let Wanted { arrows, ellipsoid, lines } = Wanted::of(shapes, &shown, *theme);
        let (mut has_arrows, mut has_ellipsoid, mut has_lines) = (false, false, false);
        for (entity, own, mesh, transform) in &mut drawn {
            if own.order != layer.row.order {
                continue;
            }
            match (&own.kind, mesh, transform) {
                (Kind::Arrows, Some(mesh), _) if arrows.is_some() => {
                    // Both entities of the arrows have the one mesh.
                    if let Some(wanted) = arrows.as_ref().filter(|_| !has_arrows)
                        && let Some(mut mesh) = assets.meshes.get_mut(&mesh.0)
                    {
                        *mesh = wanted.clone();
                    }
                    has_arrows = true;
                }
                (Kind::Ellipsoid, _, Some(mut transform)) if ellipsoid.is_some() => {
                    has_ellipsoid = true;
                    if let Some((place, _)) = ellipsoid {
                        transform.set_if_neq(place);
                    }
                }
                (kind @ Kind::Lines { .. }, ..) if lines.as_ref() == Some(kind) => {
                    has_lines = true;
                }
                _ => commands.entity(entity).despawn(),
            }
        }
        if let Some(mesh) = arrows.filter(|_| !has_arrows) {
            assets.spawn_arrows(&mut commands, layer, mesh);
        }
        if let Some(ellipsoid) = ellipsoid.filter(|_| !has_ellipsoid) {
            assets.spawn_ellipsoid(&mut commands, layer, ellipsoid);
        }
        if let Some(lines) = lines.filter(|_| !has_lines) {
            assets.spawn_lines(&mut commands, layer, lines);
        }
    }
}

impl Assets3d<'_> {
    /// Solid where they are seen, and shining through where they are hidden: of two layers the later.
    fn spawn_arrows(&mut self, commands: &mut Commands, layer: &ShapeLayer, mesh: Mesh) {
        let mesh = self.meshes.add(mesh);
        let order_mm = 10_000.0 + 100.0 * layer.row.order as f32;
        for material in [
            GlowMaterial::solid(layer.color),
            GlowMaterial::shining_through(layer.color, HIDDEN_ALPHA).order(order_mm),
        ] {
            commands.spawn((
                entity_name(layer),
                Drawn { order: layer.row.order, kind: Kind::Arrows },
                NoFrustumCulling,
                Mesh3d(mesh.clone()),
                MeshMaterial3d(self.materials.add(material)),
            ));
        }
    }

    fn spawn_ellipsoid(
        &mut self,
        commands: &mut Commands,
        layer: &ShapeLayer,
        (place, look): (Transform, Look),
    ) {
        commands.spawn((
            entity_name(layer),
            Drawn { order: layer.row.order, kind: Kind::Ellipsoid },
            Mesh3d(self.shapes.sphere.clone()),
            MeshMaterial3d(self.materials.add(material_of(layer.color, look))),
            place,
        ));
    }

    fn spawn_lines(&mut self, commands: &mut Commands, layer: &ShapeLayer, lines: Kind) {
        let mut asset = GizmoAsset::default();
        if let Kind::Lines { strips, .. } = &lines {
            for (strip, alpha) in strips {
                let color = layer.color.color_alpha(*alpha as f32);
                asset.linestrip(strip.iter().map(convert::point), color);
            }
        }
        let gizmo = Gizmo {
            handle: self.gizmos.add(asset),
            line_config: GizmoLineConfig { width: LINE_WIDTH_PX, ..default() },
            ..default()
        };
        let drawn = Drawn { order: layer.row.order, kind: lines };
        commands.spawn((entity_name(layer), drawn, gizmo));
    }
}

fn entity_name(layer: &ShapeLayer) -> Name {
    Name::new(layer.row.label.to_lowercase())
}

fn material_of(color: Rgb, look: Look) -> GlowMaterial {
    match look {
        Look::Outline => GlowMaterial::translucent(color, 0.015, 0.8).rim(5.0).order(100.0),
        Look::Veil => GlowMaterial::translucent(color, 0.10, 0.9).rim(3.0).order(150.0),
    }
}
