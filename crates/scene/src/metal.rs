//! The metal of a design's room, in the colours of its materials.

use super::drawing::{Drawing, transform_of};
use super::palette::{ALUMINIUM, BRONZE, COPPER, FERRITE, OTHER_METAL, Rgb, STEEL, TITANIUM};
use serde_json::{Value, json};
use trackwright_formats::gltf::write::{Light, Material, NodeId};
use trackwright_metal::setup::{MetalObject, ObjectMaterial};

/// How a material is drawn.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct MetalLook {
    pub color: Rgb,
    /// How much a metal's, from 0 to 1.
    pub metallic: f64,
    pub roughness: f64,
}

/// Brushed metal; ferrite is a ceramic.
pub fn look_of_metal(material: &ObjectMaterial) -> MetalLook {
    let metal = |color| MetalLook { color, metallic: 0.6, roughness: 0.45 };
    let ObjectMaterial::Named(key) = material else {
        return metal(OTHER_METAL);
    };
    match *key {
        "aluminium" => metal(ALUMINIUM),
        "copper" => metal(COPPER),
        "titanium" => metal(TITANIUM),
        "bronze" => metal(BRONZE),
        "ferrite" => MetalLook { color: FERRITE, metallic: 0.0, roughness: 0.8 },
        key if key.starts_with("steel") => metal(STEEL),
        _ => metal(OTHER_METAL),
    }
}

impl Drawing<'_> {
    /// Each object where it is, but for those that are hidden.
    pub(super) fn metal(&mut self) -> Vec<NodeId> {
        let stage = self.stage;
        let objects = stage.design().room_metal.iter().flat_map(|metal| &metal.objects);
        let shown = objects.filter(|object| !stage.view.hidden.has_metal(&object.name));
        shown.filter_map(|object| self.metal_object(object)).collect()
    }

    fn metal_object(&mut self, object: &MetalObject) -> Option<NodeId> {
        let look = look_of_metal(&object.material);
        let material = self.writer.material(&Material {
            name: object.material.label(),
            color: self.linear(look.color, 1.0),
            light: Light::Lit { metallic: look.metallic, roughness: look.roughness },
            both_faces: false,
            fades: false,
        });
        // What has no shape, which the design refuses, is not drawn.
        let mesh = object.shape.drawn().ok()?;
        let mut children = Vec::new();
        for part in &mesh.parts {
            let shape = self.part(part);
            children.extend(self.shape_node(&part.name, shape, material, extras(object)));
        }
        let name = format!("metal {}", object.name);
        self.group(&name, transform_of(&object.tracker_from_object), children)
    }
}

fn extras(object: &MetalObject) -> Value {
    json!({"material": object.material.label()})
}

#[cfg(test)]
mod tests {
    use super::super::{SceneWish, glb};
    use nalgebra::Point3;
    use trackwright_design::view::{Layers, View};
    use trackwright_design::{Edit, MetalEdit, Thing};
    use trackwright_formats::gltf::parse;
    use trackwright_geometry::mesh::MeshPart;
    use trackwright_geometry::pose::Pose;
    use trackwright_metal::new_object::NewShape;
    use trackwright_metal::setup::{MetalObject, ObjectMaterial};
    use trackwright_project::{World, open_builtin};
    use trackwright_task::Task;

    /// Two boxes of 100 mm, of copper and of ferrite. They need not be solved for to be drawn.
    fn world() -> World {
        let mut world = open_builtin("pointer-on-head").unwrap();
        for (index, key) in ["copper", "ferrite"].into_iter().enumerate() {
            let add = world.added_metal(NewShape::Box.shape(), key);
            world.document.apply(add).unwrap();
            let object = world.document.design().metal_object(index).unwrap();
            let object = Box::new(MetalObject {
                material: ObjectMaterial::Named(key),
                tracker_from_object: Pose::translation(500.0, 300.0 * index as f64, -250.0),
                ..object.clone()
            });
            world.document.apply(Edit::Metal(MetalEdit::Set { index, object })).unwrap();
        }
        world
    }

    fn boxes(world: &World) -> Vec<MeshPart> {
        let wish = SceneWish { layers: Some(Layers::none()), ..SceneWish::default() };
        let read = parse(&glb(world, &wish, &Task::default()).unwrap().glb, 1000.0).unwrap();
        // glTF's x is the tracker's; nothing else is so far out.
        let is_far = |part: &MeshPart| part.positions_mm.iter().all(|p| p.x > 440.0);
        read.parts.into_iter().filter(is_far).collect()
    }

    #[test]
    fn metal_is_drawn_where_it_is() {
        let mut world = world();
        let drawn = boxes(&world);
        assert_eq!(drawn.len(), 2);
        for (index, part) in drawn.iter().enumerate() {
            let y_mm = 300.0 * index as f64;
            for corner in [[450.0, y_mm - 50.0, -300.0], [550.0, y_mm + 50.0, -200.0]] {
                // glTF's y is the tracker's -z, its z the tracker's y.
                let at_mm = Point3::new(corner[0], -corner[2], corner[1]);
                let found = part.positions_mm.iter().any(|p| (p - at_mm).norm() < 1e-3);
                assert!(found, "{at_mm}: {:?}", part.positions_mm);
            }
        }
        // Copper is reddish, ferrite darker.
        let [copper, ferrite] = [0, 1].map(|index| drawn[index].base_color);
        assert!(copper[0] > 2.0 * copper[2] && ferrite[0] < 0.5 * copper[0]);
        let mut view: View = world.document.view().clone();
        view.hidden.toggle(Thing::Metal("copper".to_owned()));
        assert!(world.document.set_view(view));
        assert_eq!(boxes(&world).len(), 1);
    }
}
