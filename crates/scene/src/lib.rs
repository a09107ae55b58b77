//! What a design looks like, as primitives in the editor's colours and as a glTF scene for other
//! programs: bodies, sensors, errors, the room and what is known of it.
//!
//! ```
//! use trackwright_design::view::Layers;
//! use trackwright_project::open_builtin;
//! use trackwright_scene::{SceneWish, glb};
//! use trackwright_task::Task;
//! let world = open_builtin("endoscope")?;
//! let wish = SceneWish { layers: Some(Layers::named("tip-error")?), ..SceneWish::default() };
//! let scene = glb(&world, &wish, &Task::default())?;
//! assert!(scene.glb.starts_with(b"glTF") && scene.magnification >= 1.0);
//! # Ok::<(), Box<dyn std::error::Error>>(())
//! ```
//!
//! [`glb`] does all of it. In steps: a [`Stage`] has the design's bodies as they are drawn,
//! [`Stage::sample`] computes what the layers show, [`Stage::draw`] makes the file of it. What both
//! this and the editor draw with (colours, the looks of sensors and arrows, the camera that a design
//! is opened with) is here once.

mod anatomy;
pub mod arrow_style;
mod bodies;
pub mod coils;
mod drawing;
pub mod field_arrows;
pub mod ground;
mod legend;
mod metal;
pub mod mounting;
pub mod opening_view;
pub mod painted;
pub mod palette;
pub mod room;
mod sampled;
pub mod sensor_look;
mod sensors;
mod shape_nodes;
pub mod shapes;
pub mod slice;
#[cfg(test)]
mod tests;
pub mod tool_errors;

pub use anatomy::color_of as color_of_anatomy;
pub use legend::LegendKey;
pub use metal::{MetalLook, look_of_metal};
pub use palette::Ground;
pub use sampled::{PaintedBody, Sampled, slice_plan};

use std::sync::Arc;
use trackwright_design::view::{Layers, View};
use trackwright_design::{BodyRole, Design, MissingLayer};
use trackwright_formats::gltf::GltfWriteError;
use trackwright_geometry::coarse::coarser;
use trackwright_geometry::gizmo::Eye;
use trackwright_geometry::mesh::SurfaceMesh;
use trackwright_geometry::placeholder::placeholder;
use trackwright_project::{StoreError, World};
use trackwright_simulation::placement::placement_mesh;
use trackwright_task::{Cancelled, Task};

/// The picture that glyphs of a size on the screen are measured by: `render`'s own.
const VIEW_PX: [f64; 2] = [1440.0, 900.0];

/// Most triangles of a body by default: 12 bytes each and 24 a corner are some 6 MB, ten
/// times what a built-in instrument takes.
pub const MOST_TRIANGLES: usize = 250_000;

/// What of a design is drawn, and how.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct SceneWish {
    /// The design's own where there are none.
    pub layers: Option<Layers>,
    /// What the colours are to be seen on.
    pub ground: Ground,
    /// Whose body is painted by placements, and which of its sensors is imagined elsewhere; the
    /// tool's first by default.
    pub painted: Option<(BodyRole, usize)>,
    /// A body with more triangles is drawn coarser.
    pub most_triangles: usize,
}

impl Default for SceneWish {
    fn default() -> Self {
        Self {
            layers: None,
            ground: Ground::default(),
            painted: None,
            most_triangles: MOST_TRIANGLES,
        }
    }
}

/// A scene as a file, and what is reported of it.
#[derive(Clone, Debug, PartialEq)]
pub struct Scene {
    /// Binary glTF 2.0.
    pub glb: Vec<u8>,
    /// How many times larger than life errors are.
    pub magnification: f64,
    /// What the colours of things and lines mean.
    pub legend: Vec<LegendKey>,
    /// What the colours of maps mean, one line a map.
    pub colors: Vec<String>,
    /// What is not as one may expect: layers with nothing to show, bodies that are drawn coarser.
    pub notes: Vec<String>,
}

/// Why there is no scene.
#[derive(Debug, thiserror::Error)]
pub enum SceneError {
    #[error("cancelled")]
    Cancelled,
    #[error(transparent)]
    Store(#[from] StoreError),
    #[error(transparent)]
    Write(#[from] GltfWriteError),
}

impl From<Cancelled> for SceneError {
    fn from(_: Cancelled) -> Self {
        Self::Cancelled
    }
}

/// A design and its results as binary glTF: computed and drawn.
///
/// # Errors
/// See [`SceneError`].
pub fn glb(world: &World, wish: &SceneWish, task: &Task) -> Result<Scene, SceneError> {
    let stage = Stage::new(world, wish);
    let sampled = stage.sample(task)?;
    stage.draw(&sampled)
}

/// A design made ready to be drawn.
#[derive(Clone, Debug)]
pub struct Stage<'a> {
    world: &'a World,
    view: View,
    wish: SceneWish,
    /// What is drawn of tool and CRF; no more triangles than wished.
    meshes: [Option<Arc<SurfaceMesh>>; 2],
    /// Of the design's anatomy, in its order; `None` of what is missing.
    anatomy: Vec<Option<Arc<SurfaceMesh>>>,
    notes: Vec<String>,
}

impl<'a> Stage<'a> {
    pub fn new(world: &'a World, wish: &SceneWish) -> Self {
        let mut view = world.document.view().clone();
        view.layers = wish.layers.unwrap_or(view.layers);
        let unknown = wish.layers.is_none().then_some(&view.unknown_layers);
        let mut notes: Vec<String> = (unknown.into_iter().flatten())
            .map(|name| format!("{}: not drawn", MissingLayer::Unknown(name.clone())))
            .collect();
        let mut drawn = |mesh: Arc<SurfaceMesh>, what: &str| {
            let before = triangles(&mesh);
            let mesh = light(mesh, wish.most_triangles);
            let after = triangles(&mesh);
            if after < before || after > wish.most_triangles {
                let mut note = format!("{what} is drawn with {after} of its {before} triangles");
                if after > wish.most_triangles {
                    note += &format!(
                        ", not with at most {}: fewer leave no surface of its {}",
                        wish.most_triangles,
                        counted_parts(mesh.parts.len())
                    );
                }
                notes.push(note);
            }
            mesh
        };
        let (painted, _) = wish.painted.unwrap_or((BodyRole::Tool, 0));
        let meshes = BodyRole::ALL.map(|role| {
            let mut mesh = shown_mesh(world, role)?;
            if view.layers.placement && role == painted {
                mesh = placement_mesh(&mesh).map_or(mesh, Arc::new);
            }
            Some(drawn(mesh, &format!("the {role}'s mesh")))
        });
        let anatomy = world.document.design().anatomy.iter();
        let anatomy = anatomy.map(|anatomy| {
            // What is not shown need not be made light.
            let mesh = world.anatomy_mesh(&anatomy.mesh);
            let mesh = mesh.filter(|_| view.layers.anatomy)?;
            Some(drawn(Arc::clone(mesh), &format!("the anatomy {:?}", anatomy.name)))
        });
        let anatomy = anatomy.collect();
        Self { world, view, wish: *wish, meshes, anatomy, notes }
    }

    fn design(&self) -> &'a Design {
        self.world.document.design()
    }

    /// What is drawn of a body.
    fn mesh(&self, role: BodyRole) -> Option<&Arc<SurfaceMesh>> {
        self.meshes[role as usize].as_ref()
    }

    /// From where the design is first seen.
    fn eye(&self) -> Eye {
        Eye { camera: opening_view::opening_camera(self.world, VIEW_PX), view_px: VIEW_PX }
    }
}

/// What is drawn of a body: its mesh, or a rod and spokes made of tip and sensors where it has none
/// or its file is missing.
pub fn shown_mesh(world: &World, role: BodyRole) -> Option<Arc<SurfaceMesh>> {
    let body = world.document.design().body(role)?;
    Some(world.mesh(role).cloned().unwrap_or_else(|| {
        let sensors = body.rigid.sensors.iter();
        let sensors: Vec<_> = sensors.map(|s| s.position_in_body).collect();
        Arc::new(placeholder(&body.rigid.judged_tip_in_body(), &sensors))
    }))
}

fn triangles(mesh: &SurfaceMesh) -> usize {
    mesh.parts.iter().map(|part| part.triangles.len()).sum()
}

fn counted_parts(parts: usize) -> String {
    match parts {
        1 => "one part".to_owned(),
        _ => format!("{parts} parts"),
    }
}

/// A mesh of at most so many triangles, each part with its share of them, or of the fewest that its
/// parts can have.
fn light(mesh: Arc<SurfaceMesh>, most: usize) -> Arc<SurfaceMesh> {
    let all = triangles(&mesh);
    if all <= most {
        return mesh;
    }
    let share = most as f64 / all as f64;
    let parts = mesh.parts.iter().map(|part| {
        let own = (part.triangles.len() as f64 * share) as usize;
        coarser(part, own.max(1)).unwrap_or_else(|| part.clone())
    });
    Arc::new(SurfaceMesh { parts: parts.collect(), reading: mesh.reading })
}
