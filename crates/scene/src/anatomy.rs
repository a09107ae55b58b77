//! The design's anatomy, translucent; what of a body's own mesh is anatomy looks the same.

use super::drawing::{Drawing, transform_of};
use super::mounting::crf_patch_shape;
use super::palette::{BONE, Rgb};
use serde_json::Value;
use trackwright_design::Anatomy;
use trackwright_formats::gltf::write::{MaterialId, NodeId};
use trackwright_geometry::mesh::SurfaceMesh;

/// How opaque anatomy is: what it hides has to be seen through it, and its shape has to be read all
/// the same.
const ANATOMY_ALPHA: f64 = 0.3;

/// What a design's anatomy is drawn in: its own colour, or that of bone.
pub fn color_of(anatomy: &Anatomy) -> Rgb {
    match anatomy.color {
        Some(color) => Rgb::same(color.map(|part| (part * 255.0).round() as u8)),
        None => BONE,
    }
}

impl Drawing<'_> {
    /// Each mesh where it is; nothing while the layer is off.
    pub(super) fn anatomy(&mut self) -> Vec<NodeId> {
        let stage = self.stage;
        let list = stage.design().anatomy.iter().zip(&stage.anatomy);
        list.filter_map(|(anatomy, mesh)| self.one_mesh(anatomy, mesh.as_deref()?)).collect()
    }

    fn one_mesh(&mut self, anatomy: &Anatomy, mesh: &SurfaceMesh) -> Option<NodeId> {
        let look = self.anatomy_look(&format!("anatomy {}", anatomy.name), color_of(anatomy));
        let mut children = Vec::new();
        for part in &mesh.parts {
            let shape = self.part(part);
            children.extend(self.shape_node(&part.name, shape, look, Value::Null));
        }
        if self.stage.view.layers.mounting && !anatomy.crf_patch.is_empty() {
            children.extend(self.mounting_nodes(&crf_patch_shape(&anatomy.crf_patch, mesh)));
        }
        let tracker_from_mesh = anatomy.tracker_from_mesh(self.stage.design());
        let name = format!("anatomy {}", anatomy.name);
        self.group(&name, transform_of(&tracker_from_mesh), children)
    }

    /// How anatomy looks.
    pub(super) fn anatomy_look(&mut self, name: &str, color: Rgb) -> MaterialId {
        self.veil(name, color, ANATOMY_ALPHA)
    }
}

#[cfg(test)]
mod tests {
    use super::super::{SceneWish, glb};
    use nalgebra::Point3;
    use std::fs;
    use trackwright_design::view::Layers;
    use trackwright_design::{Anatomy, AnatomyEdit, AnatomyFrame, BodyRole, Edit};
    use trackwright_formats::gltf::parse;
    use trackwright_geometry::bounds::Bounds;
    use trackwright_geometry::mesh_reference::MeshReference;
    use trackwright_geometry::pose::Pose;
    use trackwright_project::{World, open_builtin, refresh_meshes};
    use trackwright_task::Task;

    const COLOR: [f64; 3] = [0.2, 0.4, 0.6];

    /// Corners at 10, 20 and 30 mm along the mesh's own axes.
    const OBJ: &str = "o face\nv 10 0 0\nv 0 20 0\nv 0 0 30\nf 1 2 3\n";

    fn world(folder: &std::path::Path) -> World {
        let file = folder.join("face.obj");
        fs::write(&file, OBJ).unwrap();
        let mut world = open_builtin("pointer-on-head").unwrap();
        for (name, on) in [("patient", AnatomyFrame::Crf), ("table", AnatomyFrame::Tracker)] {
            let anatomy = Anatomy {
                name: name.to_owned(),
                mesh: MeshReference::new(file.to_string_lossy()),
                on,
                frame_from_mesh: Pose::translation(0.0, 0.0, 5.0),
                color: (on == AnatomyFrame::Tracker).then_some(COLOR),
                crf_patch: Vec::new(),
            };
            let add = AnatomyEdit::Add(Box::new(anatomy));
            world.document.apply(Edit::Anatomy(add)).unwrap();
        }
        refresh_meshes(&mut world).unwrap();
        world
    }

    fn scene(world: &World, layers: &str) -> Vec<u8> {
        let wish =
            SceneWish { layers: Some(Layers::named(layers).unwrap()), ..SceneWish::default() };
        glb(world, &wish, &Task::default()).unwrap().glb
    }

    #[test]
    fn anatomy_is_in_its_frame_and_its_layer() {
        let folder = tempfile::tempdir().unwrap();
        let world = world(folder.path());
        let read = parse(&scene(&world, "anatomy"), 1000.0).unwrap();
        let faces: Vec<_> = read.parts.iter().filter(|part| part.name == "face").collect();
        let tracker_from_crf = world.document.design().tracker_from_body(BodyRole::Crf);
        let frames = [tracker_from_crf.unwrap(), Pose::identity()];
        for (face, frame) in faces.iter().zip(frames) {
            for corner in [[10.0, 0.0, 5.0], [0.0, 20.0, 5.0], [0.0, 0.0, 35.0]] {
                let at_mm = frame * Point3::from(corner);
                // glTF's y is the tracker's -z, its z the tracker's y.
                let found = face.positions_mm.iter().any(|p| {
                    let tracker_mm = Point3::new(p.x, p.z, -p.y);
                    (tracker_mm - at_mm).norm() < 1e-3
                });
                assert!(found, "{at_mm}: {:?}", face.positions_mm);
            }
            assert!(face.base_color[3] < 0.5);
        }
        assert_eq!(faces.len(), 2);
        // Bone is lighter in red than in blue, the other's own colour the other way round.
        let is_warm = |color: [f32; 4]| color[0] > color[2];
        assert!(is_warm(faces[0].base_color) && !is_warm(faces[1].base_color));
        let without = parse(&scene(&world, "none"), 1000.0).unwrap();
        assert!(without.parts.iter().all(|part| part.name != "face"));
    }

    #[test]
    fn a_crf_patch_is_drawn_in_its_layer() {
        let folder = tempfile::tempdir().unwrap();
        let mut world = world(folder.path());
        let boxes = vec![Bounds::from(([0.0; 3], [40.0, 40.0, 15.0]))];
        let edit = AnatomyEdit::SetCrfPatch { index: 0, boxes };
        world.document.apply(Edit::Anatomy(edit)).unwrap();
        // The mesh reader refuses the lines of the body's regions; the file's text has the names.
        let name = b"\"CRF patch\"";
        let has_patch =
            |layers: &str| scene(&world, layers).windows(name.len()).any(|text| text == name);
        assert!(has_patch("anatomy,mounting"));
        assert!(!has_patch("anatomy") && !has_patch("mounting"));
    }
}
